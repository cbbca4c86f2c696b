//! Pictures and hits as other programs read them: each file is read back by another decoder than
//! the writer's own, or by the codec's reader.

use std::io::Cursor;
use std::path::Path;

use exr::prelude::{ReadChannels, ReadLayers, Vec2};
use glam::DVec3;
use kugelblitz::control::Control;
use kugelblitz::output::{OutputFile, commit};
use kugelblitz::picture::{Bits, Format, PictureOptions, PictureWriter, write_hits};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Camera, Color, Plane, Scene};
use kugelblitz::shade::{Colors, Encoding, Shader, Style};
use kugelblitz::trace::{Coverage, Hits};
use kugelblitz::{Error, Result};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SEED: u64 = 20_240_611;

/// The sRGB curve from its standard, in the other direction than the writer's.
fn linear(byte: u8) -> f64 {
    let v = f64::from(byte) / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// All pixels of a picture.
fn whole(width: u32, height: u32) -> Pixels {
    Pixels::whole(View::new(&Camera::new(DVec3::Z, DVec3::ZERO)), width, height)
}

/// A palette that goes through all 256 values of each channel, and its `#rrggbb`.
fn every_byte() -> (Vec<Color>, Vec<[u8; 3]>) {
    let srgb: Vec<[u8; 3]> =
        (0..=255_u8).map(|i| [i, 255 - i, i.wrapping_mul(167).wrapping_add(13)]).collect();
    let colors = srgb.iter().map(|c| Color(c.map(linear))).collect();
    (colors, srgb)
}

/// Hits with every field, random but for the corners: background, infinity, tiny and huge `t`.
fn random_hits(rng: &mut impl Rng, n: usize, n_colors: usize) -> Hits {
    let id: Vec<u32> = (0..n).map(|_| rng.random_range(0..n_colors as u32)).collect();
    let t = id.iter().map(|&id| match id {
        0 => f32::INFINITY,
        1 => f32::MIN_POSITIVE,
        2 => f32::MAX,
        _ => f32::from_bits(rng.random_range(1..f32::MAX.to_bits())),
    });
    Hits {
        t: t.collect(),
        normal: id.iter().map(|&id| if id == 0 { [0.0; 3] } else { [0.1, -0.0, -0.99] }).collect(),
        level: id.iter().map(|id| (id % 3) as u8).collect(),
        id,
        ..Hits::default()
    }
}

/// The rows `first..first + n` of a picture.
fn band(hits: &Hits, width: usize, first: usize, n: usize) -> Hits {
    let range = first * width..(first + n) * width;
    Hits {
        id: hits.id[range.clone()].to_vec(),
        t: hits.t[range.clone()].to_vec(),
        normal: hits.normal[range.clone()].to_vec(),
        level: hits.level[range].to_vec(),
        ..Hits::default()
    }
}

/// The colours of hits whose objects have those of `palette`, the background's first.
fn shaded(
    format: Format,
    options: PictureOptions,
    palette: &[Color],
    hits: &Hits,
) -> Result<Colors> {
    let object = |&color| Plane { name: None, point: DVec3::ZERO, normal: DVec3::Y, color };
    let planes = palette[1..].iter().map(object).collect();
    let scene = Scene { background: palette[0], planes, ..Scene::default() };
    let encoding = format.encoding(options.bits);
    let mut colors = Colors::new(encoding);
    Shader::new(&scene, &Style::new(encoding)).shade(&hits.id, &mut colors)?;
    Ok(colors)
}

fn encode(
    format: Format,
    options: PictureOptions,
    pixels: &Pixels,
    palette: &[Color],
    hits: &Hits,
    n_band_rows: u32,
) -> Result<Vec<u8>> {
    let sink = Cursor::new(Vec::new());
    let mut writer = PictureWriter::create(format, options, pixels, sink, "memory")?;
    let mut first = 0;
    while first < pixels.height {
        let n = n_band_rows.min(pixels.height - first);
        let rows = band(hits, pixels.width as usize, first as usize, n as usize);
        writer.rows(&shaded(format, options, palette, &rows)?, &rows, n)?;
        first += n;
    }
    Ok(writer.finish()?.into_inner())
}

const EIGHT: PictureOptions =
    PictureOptions { bits: Bits::Eight, certificates: false, transparent: false };
const SIXTEEN: PictureOptions = PictureOptions { bits: Bits::Sixteen, ..EIGHT };
const CERTIFICATES: PictureOptions = PictureOptions { certificates: true, ..EIGHT };

#[test]
fn every_srgb_value_comes_out_as_the_file_names_it() {
    let (palette, srgb) = every_byte();
    let hits = Hits { id: (0..256).collect(), ..Hits::default() };
    let hits = Hits { t: vec![1.0; 256], normal: vec![[0.0; 3]; 256], level: vec![0; 256], ..hits };
    let pixels = whole(64, 4);
    for (format, image_format) in
        [(Format::Png, image::ImageFormat::Png), (Format::Ppm, image::ImageFormat::Pnm)]
    {
        let bytes = encode(format, EIGHT, &pixels, &palette, &hits, 3).unwrap();
        let picture = image::load_from_memory_with_format(&bytes, image_format).unwrap();
        let image::DynamicImage::ImageRgb8(picture) = picture else {
            panic!("{format} is not 8-bit RGB");
        };
        assert_eq!(picture.dimensions(), (64, 4));
        for (id, pixel) in picture.pixels().enumerate() {
            assert_eq!(pixel.0, srgb[id], "{format}, id {id}");
        }

        let bytes = encode(format, SIXTEEN, &pixels, &palette, &hits, 3).unwrap();
        let picture = image::load_from_memory_with_format(&bytes, image_format).unwrap();
        let image::DynamicImage::ImageRgb16(picture) = picture else {
            panic!("{format} is not 16-bit RGB");
        };
        assert_eq!(picture.dimensions(), (64, 4));
        for (id, pixel) in picture.pixels().enumerate() {
            // 65535 = 257·255, so a named colour has the same digits twice.
            assert_eq!(pixel.0, srgb[id].map(|v| u16::from(v) * 257), "{format}, id {id}");
        }
    }
}

#[test]
fn png_says_that_it_is_srgb() {
    let hits = Hits { id: vec![0], ..Hits::default() };
    let bytes = encode_ids(Format::Png, &whole(1, 1), &[Color::BLACK], hits).unwrap();
    let reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    assert_eq!(reader.info().srgb, Some(png::SrgbRenderingIntent::Perceptual));
    let software = &reader.info().uncompressed_latin1_text[0];
    assert_eq!(software.keyword, "Software");
    assert!(software.text.starts_with("kugelblitz "));
}

/// Formats that only need colours take hits that have only ids.
fn encode_ids(format: Format, pixels: &Pixels, palette: &[Color], hits: Hits) -> Result<Vec<u8>> {
    let sink = Cursor::new(Vec::new());
    let mut writer = PictureWriter::create(format, EIGHT, pixels, sink, "memory")?;
    writer.rows(&shaded(format, EIGHT, palette, &hits)?, &hits, pixels.height)?;
    Ok(writer.finish()?.into_inner())
}

struct ExrFile {
    display: exr::meta::attribute::IntegerBounds,
    position: Vec2<i32>,
    size: Vec2<usize>,
    software: String,
    /// Name and samples, row by row; f32 as their bits.
    channels: Vec<(String, Vec<u32>)>,
}

fn read_exr(bytes: &[u8]) -> exr::error::Result<ExrFile> {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .pedantic()
        .from_buffered(Cursor::new(bytes))?;
    let layer = image.layer_data;
    let channels = layer.channel_data.list.into_iter().map(|channel| {
        let bits = match channel.sample_data {
            exr::prelude::FlatSamples::F32(v) => v.iter().map(|v| v.to_bits()).collect(),
            exr::prelude::FlatSamples::U32(v) => v,
            exr::prelude::FlatSamples::F16(_) => panic!("half floats"),
        };
        (channel.name.to_string(), bits)
    });
    Ok(ExrFile {
        display: image.attributes.display_window,
        position: layer.attributes.layer_position,
        size: layer.size,
        software: layer.attributes.software_name.unwrap_or_default().to_string(),
        channels: channels.collect(),
    })
}

/// The channels of an EXR as they must be, bit for bit.
fn expected_channels(hits: &Hits, palette: &[Color], level: bool) -> Vec<(String, Vec<u32>)> {
    let rgb = |i: usize| {
        let color = |&id: &u32| (palette[id as usize].0[i] as f32).to_bits();
        hits.id.iter().map(color).collect::<Vec<u32>>()
    };
    let normal = |i: usize| hits.normal.iter().map(|n| n[i].to_bits()).collect();
    let mut channels = vec![
        ("A".into(), vec![1.0_f32.to_bits(); hits.id.len()]),
        ("B".into(), rgb(2)),
        ("G".into(), rgb(1)),
        ("N.X".into(), normal(0)),
        ("N.Y".into(), normal(1)),
        ("N.Z".into(), normal(2)),
        ("R".into(), rgb(0)),
        ("Z".into(), hits.t.iter().map(|t| t.to_bits()).collect()),
        ("id".into(), hits.id.clone()),
    ];
    if level {
        channels.push(("level".into(), hits.level.iter().map(|&level| level.into()).collect()));
    }
    channels
}

/// Ids beyond 2¹⁶, which neither u16 nor a half float would hold.
fn large_palette() -> Vec<Color> {
    (0..70_000).map(|i| Color([f64::from(i) / 70_000.0, 0.25, 1.0])).collect()
}

#[test]
fn exr_holds_every_value_bit_for_bit() {
    let palette = large_palette();
    let rng = &mut ChaCha8Rng::seed_from_u64(SEED);
    for (width, height) in [(1, 1), (3, 16), (17, 33), (40, 50), (1, 100)] {
        let mut hits = random_hits(rng, width * height, palette.len());
        hits.id[0] = 0;
        hits.t[0] = f32::INFINITY;
        for options in [EIGHT, CERTIFICATES] {
            let pixels = whole(width as u32, height as u32);
            let bytes = encode(Format::Exr, options, &pixels, &palette, &hits, 7).unwrap();
            let file = read_exr(&bytes).unwrap();
            assert_eq!(file.size, Vec2(width, height));
            assert_eq!(file.display.size, Vec2(width, height));
            assert!(file.software.starts_with("kugelblitz "));
            let expected = expected_channels(&hits, &palette, options.certificates);
            assert!(file.channels == expected, "{width}x{height}");
        }
    }
}

#[test]
fn exr_of_a_crop_says_where_it_belongs() {
    let (palette, _) = every_byte();
    let hits = random_hits(&mut ChaCha8Rng::seed_from_u64(SEED), 20 * 35, palette.len());
    let pixels = Pixels { x: 600, y: 101, width: 20, height: 35, ..whole(640, 480) };
    let bytes = encode(Format::Exr, EIGHT, &pixels, &palette, &hits, 35).unwrap();
    let file = read_exr(&bytes).unwrap();
    assert_eq!(file.display.position, Vec2(0, 0));
    assert_eq!(file.display.size, Vec2(640, 480));
    assert_eq!(file.position, Vec2(600, 101));
    assert_eq!(file.size, Vec2(20, 35));
    assert!(file.channels == expected_channels(&hits, &palette, false));
}

/// A structured array: its type as the header has it, the shape, and the raw records.
fn read_npy(bytes: &[u8]) -> (String, Vec<u64>, Vec<u8>) {
    assert_eq!(bytes[..8], *b"\x93NUMPY\x01\x00");
    let n_text = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!((10 + n_text) % 64, 0);
    let (text, records) = bytes[10..].split_at(n_text);
    let text = std::str::from_utf8(text).unwrap().strip_suffix('\n').unwrap().trim_end();
    let text = text.strip_prefix("{'descr': ").unwrap().strip_suffix("), }").unwrap();
    let (dtype, shape) = text.split_once(", 'fortran_order': False, 'shape': (").unwrap();
    let shape: Vec<u64> = shape.split_terminator(", ").map(|n| n.parse().unwrap()).collect();
    let n_of = |what: &str| dtype.matches(what).count() as u64;
    let n_record_bytes = 4 * (n_of("4'") + 2 * n_of("(3,)")) + n_of("u1'");
    assert_eq!(records.len() as u64, n_record_bytes * shape.iter().product::<u64>());
    (dtype.to_owned(), shape, records.to_vec())
}

#[test]
fn npy_holds_every_value_bit_for_bit() {
    let palette = large_palette();
    let hits = random_hits(&mut ChaCha8Rng::seed_from_u64(SEED), 13 * 9, palette.len());
    for options in [EIGHT, CERTIFICATES] {
        let bytes = encode(Format::Npy, options, &whole(13, 9), &palette, &hits, 4).unwrap();
        let (dtype, shape, records) = read_npy(&bytes);
        let level = if options.certificates { "('level', '|u1'), " } else { "" };
        assert_eq!(
            dtype,
            format!(
                "[('id', '<u4'), ('t', '<f4'), ('normal', '<f4', (3,)), ('rgb', '<f4', (3,)), \
                 {level}]"
            )
        );
        assert_eq!(shape, [9, 13]);
        let record_bytes = 32 + usize::from(options.certificates);
        assert_eq!(records.len(), 13 * 9 * record_bytes);
        for (i, record) in records.chunks_exact(record_bytes).enumerate() {
            let mut expected = hits.id[i].to_le_bytes().to_vec();
            let color = palette[hits.id[i] as usize].to_f32();
            for value in [hits.t[i]].iter().chain(&hits.normal[i]).chain(&color) {
                expected.extend(value.to_le_bytes());
            }
            expected.extend(options.certificates.then_some(hits.level[i]));
            assert_eq!(record, expected, "record {i}");
        }
    }
}

fn write(path: &Path, hits: &Hits) -> Result<()> {
    let (mut file, control) = (OutputFile::create(path, false)?, Control::default());
    write_hits(&mut file, hits, &control)?;
    commit([file], &control)
}

#[test]
fn hits_of_rays_hold_every_value_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("hits.npy");
    let hits = Hits {
        id: vec![0, u32::MAX, 7],
        t: vec![f32::INFINITY, f32::MIN_POSITIVE, 1.5],
        normal: vec![[0.0; 3], [0.0, -0.0, 1.0], [0.6, 0.8, 0.0]],
        ..Hits::default()
    };
    write(&path, &hits).unwrap();
    let (dtype, shape, records) = read_npy(&std::fs::read(&path).unwrap());
    assert_eq!(dtype, "[('id', '<u4'), ('t', '<f4'), ('normal', '<f4', (3,)), ]");
    assert_eq!(shape, [3]);
    let mut expected = Vec::new();
    for i in 0..3 {
        expected.extend(hits.id[i].to_le_bytes());
        expected.extend(hits.t[i].to_le_bytes());
        expected.extend(hits.normal[i].iter().flat_map(|v| v.to_le_bytes()));
    }
    assert_eq!(records, expected);

    let many = random_hits(&mut ChaCha8Rng::seed_from_u64(SEED), 70_000, 9);
    write(&path, &many).unwrap();
    let (dtype, shape, records) = read_npy(&std::fs::read(&path).unwrap());
    assert!(dtype.contains("('level', '|u1')"), "{dtype}");
    assert_eq!(shape, [70_000]);
    assert_eq!(records[69_999 * 21 + 20], many.level[69_999]);

    write(&path, &Hits::default()).unwrap();
    assert_eq!(read_npy(&std::fs::read(&path).unwrap()).1, [0]);
    let lacking = Hits { id: vec![1], ..Hits::default() };
    assert!(matches!(write(&path, &lacking), Err(Error::Usage(_))));
}

/// A transparent picture of 10 × 5 pixels, written in bands.
fn encode_transparent(
    format: Format,
    options: PictureOptions,
    colors: &Colors,
    coverage: &Coverage,
    hits: &Hits,
    n_band_rows: u32,
) -> Result<Vec<u8>> {
    let options = PictureOptions { transparent: true, ..options };
    let sink = Cursor::new(Vec::new());
    let mut writer = PictureWriter::create(format, options, &whole(10, 5), sink, "memory")?;
    for first in (0..5).step_by(n_band_rows as usize) {
        let n = n_band_rows.min(5 - first);
        let range = 10 * first as usize..10 * (first + n) as usize;
        let colors = match colors {
            Colors::Srgb8(pixels) => Colors::Srgb8(pixels[range.clone()].to_vec()),
            Colors::Srgb16(pixels) => Colors::Srgb16(pixels[range.clone()].to_vec()),
            Colors::Linear(pixels) => Colors::Linear(pixels[range.clone()].to_vec()),
        };
        let coverage = Coverage { n_hits: coverage.n_hits[range].to_vec(), ..*coverage };
        let hits = band(hits, 10, first as usize, n as usize);
        writer.transparent_rows(&colors, &coverage, &hits, n)?;
    }
    Ok(writer.finish()?.into_inner())
}

/// Numbers of samples, and numbers of them that hit.
fn coverages() -> Vec<Coverage> {
    [1, 4, 9, 36, 196, 256]
        .map(|n_samples| Coverage {
            n_hits: (0..50).map(|i| i * 41 % (n_samples + 1)).collect(),
            n_samples,
        })
        .to_vec()
}

/// `n / of · largest` to the nearest whole number, half up, as decimals on paper do it.
fn nearest(n: u16, of: u16, largest: u64) -> u64 {
    let (quotient, rest) =
        (u64::from(n) * largest / u64::from(of), u64::from(n) * largest % u64::from(of));
    quotient + u64::from(2 * rest >= u64::from(of))
}

#[test]
fn a_transparent_picture_holds_the_share_of_the_samples_that_hit() {
    let rng = &mut ChaCha8Rng::seed_from_u64(SEED);
    let hits = random_hits(rng, 50, 9);
    for coverage in coverages() {
        let (n_hits, of) = (&coverage.n_hits, coverage.n_samples);
        for n_band_rows in [1, 2, 5] {
            let encode = |format, options, colors: &Colors| {
                encode_transparent(format, options, colors, &coverage, &hits, n_band_rows).unwrap()
            };
            let pixels: Vec<[u8; 3]> = (0..50).map(|_| rng.random()).collect();
            let bytes = encode(Format::Png, EIGHT, &Colors::Srgb8(pixels.clone()));
            let image::DynamicImage::ImageRgba8(picture) = image::load_from_memory(&bytes).unwrap()
            else {
                panic!("not RGBA of 8 bits")
            };
            for (i, pixel) in picture.pixels().enumerate() {
                assert_eq!(pixel.0[..3], pixels[i]);
                assert_eq!(u64::from(pixel.0[3]), nearest(n_hits[i], of, 255), "{i} of {of}");
            }

            let pixels: Vec<[u16; 3]> = (0..50).map(|_| rng.random()).collect();
            let bytes = encode(Format::Png, SIXTEEN, &Colors::Srgb16(pixels.clone()));
            let image::DynamicImage::ImageRgba16(picture) =
                image::load_from_memory(&bytes).unwrap()
            else {
                panic!("not RGBA of 16 bits")
            };
            for (i, pixel) in picture.pixels().enumerate() {
                assert_eq!(pixel.0[..3], pixels[i]);
                assert_eq!(u64::from(pixel.0[3]), nearest(n_hits[i], of, 65535), "{i} of {of}");
            }

            let alphas: Vec<u32> = n_hits
                .iter()
                .map(|&n| (f64::from(n) / f64::from(of)) as f32)
                .map(f32::to_bits)
                .collect();
            let pixels: Vec<[f32; 3]> = (0..50).map(|_| rng.random()).collect();
            let linear = Colors::Linear(pixels.clone());
            let channels = read_exr(&encode(Format::Exr, CERTIFICATES, &linear)).unwrap().channels;
            let names: Vec<&str> = channels.iter().map(|(name, _)| &**name).collect();
            assert_eq!(names, ["A", "B", "G", "N.X", "N.Y", "N.Z", "R", "Z", "id", "level"]);
            assert_eq!(channels[0].1, alphas, "of {of}");
            for (channel, rgb) in [(1, 2), (2, 1), (6, 0)] {
                let expected = pixels.iter().map(|pixel| pixel[rgb].to_bits());
                assert!(channels[channel].1.iter().copied().eq(expected));
            }

            for options in [EIGHT, CERTIFICATES] {
                let (dtype, _, records) = read_npy(&encode(Format::Npy, options, &linear));
                assert!(dtype.contains("('rgb', '<f4', (3,)), ('a', '<f4'), "), "{dtype}");
                let record_bytes = 36 + usize::from(options.certificates);
                for (i, record) in records.chunks_exact(record_bytes).enumerate() {
                    let words: Vec<u32> =
                        record.as_chunks().0.iter().copied().map(u32::from_le_bytes).collect();
                    assert_eq!(words[0], hits.id[i]);
                    assert_eq!(words[5..8], pixels[i].map(f32::to_bits));
                    assert_eq!(words[8], alphas[i], "{i} of {of}");
                    if options.certificates {
                        assert_eq!(record[36], hits.level[i]);
                    }
                }
            }
        }
    }
}

#[test]
fn alpha_and_picture_must_fit_each_other() {
    let hits = random_hits(&mut ChaCha8Rng::seed_from_u64(SEED), 50, 9);
    let refused = |format, coverage: &Coverage| {
        let colors = match format {
            Format::Png | Format::Ppm => Colors::Srgb8(vec![[0; 3]; 50]),
            Format::Exr | Format::Npy => Colors::Linear(vec![[0.0; 3]; 50]),
        };
        match encode_transparent(format, EIGHT, &colors, coverage, &hits, 5) {
            Err(Error::Usage(message)) => message,
            other => panic!("{format}: {other:?}"),
        }
    };
    let good = Coverage { n_hits: vec![3; 50], n_samples: 4 };
    let message = refused(Format::Ppm, &good);
    assert!(message.contains("ppm") && message.contains(".png, .exr or .npy"), "{message}");
    for format in [Format::Png, Format::Exr, Format::Npy] {
        let short = Coverage { n_hits: vec![3; 49], ..good };
        let sink = || Cursor::new(Vec::new());
        let begin = |options| PictureWriter::create(format, options, &whole(10, 5), sink(), "m");
        let colors = match format.encoding(Bits::Eight) {
            Encoding::Linear => Colors::Linear(vec![[0.0; 3]; 50]),
            _ => Colors::Srgb8(vec![[0; 3]; 50]),
        };
        let transparent = PictureOptions { transparent: true, ..EIGHT };
        let mut writer = begin(transparent).unwrap();
        let message = writer.transparent_rows(&colors, &short, &hits, 5).unwrap_err().to_string();
        assert!(message.contains("49 entries of “coverage”"), "{message}");
        let message = writer.rows(&colors, &hits, 5).unwrap_err().to_string();
        assert!(message.contains("is transparent"), "{message}");
        let message = begin(EIGHT)
            .unwrap()
            .transparent_rows(&colors, &good, &hits, 5)
            .unwrap_err()
            .to_string();
        assert!(message.contains("is not transparent"), "{message}");
        let mut more = good.clone();
        more.n_hits[7] = 5;
        assert!(refused(format, &more).contains("no more hits than its 4"));
    }
    assert_eq!(
        Coverage::of_ids(&[0, 7, 0], 3, 1),
        Coverage { n_hits: vec![0, 1, 0], n_samples: 1 }
    );
}

#[test]
fn the_size_of_the_bands_does_not_show() {
    let (palette, _) = every_byte();
    let hits = random_hits(&mut ChaCha8Rng::seed_from_u64(SEED), 31 * 70, palette.len());
    let pixels = whole(31, 70);
    for format in Format::ALL {
        for options in [EIGHT, SIXTEEN, CERTIFICATES] {
            let whole = encode(format, options, &pixels, &palette, &hits, 70).unwrap();
            for n_band_rows in [1, 7, 16, 64] {
                let bands = encode(format, options, &pixels, &palette, &hits, n_band_rows).unwrap();
                assert!(bands == whole, "{format} in bands of {n_band_rows}");
            }
        }
    }
}

#[test]
fn an_interrupted_picture_leaves_the_old_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture");
    let hits = random_hits(&mut ChaCha8Rng::seed_from_u64(SEED), 8 * 4, 2);
    let palette = [Color::BLACK, Color([1.0; 3])];
    let n_files = || std::fs::read_dir(folder.path()).unwrap().count();
    for format in Format::ALL {
        let colors = shaded(format, EIGHT, &palette, &hits).unwrap();
        std::fs::write(&path, "old").unwrap();
        let begin = || {
            let file = OutputFile::create(&path, format.needs_seek()).unwrap();
            let pixels = whole(8, 8);
            PictureWriter::create(format, EIGHT, &pixels, file, &path).unwrap()
        };
        let mut writer = begin();
        writer.rows(&colors, &hits, 4).unwrap();
        drop(writer);
        assert_eq!(std::fs::read(&path).unwrap(), b"old", "{format}");

        // Ended too early is no better than interrupted.
        let mut writer = begin();
        writer.rows(&colors, &hits, 4).unwrap();
        assert!(matches!(writer.finish(), Err(Error::Usage(_))), "{format}");
        assert_eq!(std::fs::read(&path).unwrap(), b"old", "{format}");
        assert_eq!(n_files(), 1, "{format}");

        let mut writer = begin();
        writer.rows(&colors, &hits, 4).unwrap();
        writer.rows(&colors, &hits, 4).unwrap();
        commit([writer.finish().unwrap()], &Control::default()).unwrap();
        let written = std::fs::read(&path).unwrap();
        let both = Hits {
            id: [&hits.id[..], &hits.id].concat(),
            t: [&hits.t[..], &hits.t].concat(),
            normal: [&hits.normal[..], &hits.normal].concat(),
            level: [&hits.level[..], &hits.level].concat(),
            ..Hits::default()
        };
        let expected = encode(format, EIGHT, &whole(8, 8), &palette, &both, 8).unwrap();
        assert!(written == expected, "{format}");
    }
}

#[test]
fn wrong_bands_are_refused() {
    let palette = [Color::BLACK, Color([1.0; 3])];
    let hits = random_hits(&mut ChaCha8Rng::seed_from_u64(SEED), 8, 2);
    for format in Format::ALL {
        let begin = || {
            let sink = Cursor::new(Vec::new());
            PictureWriter::create(format, CERTIFICATES, &whole(4, 2), sink, "m").unwrap()
        };
        let colors = shaded(format, CERTIFICATES, &palette, &hits).unwrap();
        assert!(matches!(begin().rows(&colors, &hits, 3), Err(Error::Usage(_))));
        assert!(matches!(begin().rows(&colors, &hits, 1), Err(Error::Usage(_))));
        let alien = Hits { id: vec![2; 8], ..hits.clone() };
        let message = shaded(format, CERTIFICATES, &palette, &alien).unwrap_err().to_string();
        assert!(message.contains("id 2") && message.contains("end at 1"), "{message}");
        let other = match colors {
            Colors::Linear(_) => Colors::Srgb8(vec![[0; 3]; 8]),
            _ => Colors::Linear(vec![[0.0; 3]; 8]),
        };
        assert!(matches!(begin().rows(&other, &hits, 2), Err(Error::Usage(_))), "{format}");
        let too_few = Colors::new(colors.encoding());
        assert!(matches!(begin().rows(&too_few, &hits, 2), Err(Error::Usage(_))), "{format}");
        let ids_only = Hits { id: hits.id.clone(), ..Hits::default() };
        let is_enough = !format.wants(true).surface;
        assert_eq!(begin().rows(&colors, &ids_only, 2).is_ok(), is_enough, "{format}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_with_a_name() {
    let hits = random_hits(&mut ChaCha8Rng::seed_from_u64(SEED), 512 * 512, 2);
    let palette = [Color::BLACK, Color([1.0; 3])];
    for format in Format::ALL {
        let attempt = || -> Result<()> {
            let file = OutputFile::create("/dev/full", format.needs_seek())?;
            let pixels = whole(512, 512);
            let mut writer = PictureWriter::create(format, EIGHT, &pixels, file, "/dev/full")?;
            writer.rows(&shaded(format, EIGHT, &palette, &hits)?, &hits, 512)?;
            commit([writer.finish()?], &Control::default())
        };
        let error = attempt().err().unwrap();
        assert!(matches!(&error, Error::Io { path, .. } if path == Path::new("/dev/full")));
        assert_eq!(error.exit_code(), 1, "{format}");
    }
}

// Sabotage: the tests above must be able to fail.

#[test]
fn a_flipped_bit_is_noticed() {
    let (palette, srgb) = every_byte();
    let mut hits = random_hits(&mut ChaCha8Rng::seed_from_u64(SEED), 16 * 16, palette.len());
    hits.id = (0..256).collect();
    let pixels = whole(16, 16);
    for format in Format::ALL {
        let good = encode(format, EIGHT, &pixels, &palette, &hits, 16).unwrap();
        // The middle of the file is pixels in each of them.
        let mut bad = good.clone();
        bad[good.len() / 2] ^= 0x10;
        let is_right = |bytes: &[u8]| match format {
            Format::Png | Format::Ppm => image::load_from_memory(bytes).is_ok_and(|picture| {
                picture.to_rgb8().pixels().map(|p| p.0).eq(srgb.iter().copied())
            }),
            Format::Exr => read_exr(bytes)
                .is_ok_and(|file| file.channels == expected_channels(&hits, &palette, false)),
            Format::Npy => read_npy(bytes).2 == read_npy(&good).2,
        };
        assert!(is_right(&good), "{format}");
        assert!(!is_right(&bad), "{format}: a flipped bit went unnoticed");
    }
}

#[test]
fn a_wrong_palette_is_noticed() {
    let (mut palette, srgb) = every_byte();
    palette.swap(200, 201);
    let hits = Hits { id: (0..256).collect(), ..Hits::default() };
    for format in [Format::Png, Format::Ppm] {
        let bytes = encode_ids(format, &whole(16, 16), &palette, hits.clone()).unwrap();
        let picture = image::load_from_memory(&bytes).unwrap().to_rgb8();
        let wrong: Vec<usize> = (0..256)
            .filter(|&i| picture.get_pixel(i as u32 % 16, i as u32 / 16).0 != srgb[i])
            .collect();
        assert_eq!(wrong, [200, 201], "{format}");
    }
}
