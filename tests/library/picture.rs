//! Pictures and hits as other programs read them: each file is read back by another decoder than
//! the writer's own, or by the codec's reader.

use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, Vec2};
use glam::DVec3;
use image::DynamicImage;
use kugelblitz::Control;
use kugelblitz::lighting::{Colors, Encoding, Framebuffer, Palette, Style};
use kugelblitz::output::{OutputFile, commit};
use kugelblitz::picture::{
    ChannelBits, Format, Metadata, PictureOptions, PictureWriter, Sink, write_hits,
};
use kugelblitz::query::{Coverage, Hits};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Camera, Color, Plane, Scene};
use kugelblitz::{Error, Result};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SEED: u64 = 20_240_611;

/// The numbers of a file by the names that EXR has for them, row by row; floats as their bits.
type Channels = BTreeMap<String, Vec<u32>>;

const EIGHT: PictureOptions =
    PictureOptions { bits: ChannelBits::Eight, certificates: false, transparent: false };
const SIXTEEN: PictureOptions = PictureOptions { bits: ChannelBits::Sixteen, ..EIGHT };
const CERTIFICATES: PictureOptions = PictureOptions { certificates: true, ..EIGHT };
const TRANSPARENT: [PictureOptions; 3] =
    [with_alpha(EIGHT), with_alpha(SIXTEEN), with_alpha(CERTIFICATES)];

/// Begins a picture that says nothing of how it was made.
fn writer<W: std::io::Write + std::io::Seek>(
    format: Format,
    options: PictureOptions,
    pixels: &Pixels,
    sink: W,
) -> Result<PictureWriter<W>> {
    PictureWriter::create(format, options, pixels, &Metadata::default(), sink, "memory")
}

const fn with_alpha(options: PictureOptions) -> PictureOptions {
    PictureOptions { transparent: true, ..options }
}

/// All pixels of a picture.
fn whole(width: u32, height: u32) -> Pixels {
    Pixels::whole(View::new(&Camera::new(DVec3::Z, DVec3::ZERO)), width, height)
}

/// What a picture is made of.
#[derive(Clone)]
struct Made {
    colors: Colors,
    coverage: Coverage,
    hits: Hits,
}

impl Made {
    /// Random numbers in every place, but for the corners: background, infinity, tiny and huge `t`, ids beyond 2¹⁶, which
    /// neither u16 nor a half float would hold.
    fn new(rng: &mut impl Rng, encoding: Encoding, n: usize, n_samples: u16) -> Made {
        let id: Vec<u32> = (0..n).map(|i| (i as u32 * 7919) % 70_001).collect();
        let t = id.iter().map(|&id| match id {
            0 => f32::INFINITY,
            7919 => f32::MIN_POSITIVE,
            15838 => f32::MAX,
            _ => f32::from_bits(rng.random_range(1..f32::MAX.to_bits())),
        });
        let t = t.collect();
        let normal = |&id: &u32| if id == 0 { [0.0; 3] } else { [0.1, -0.0, -0.99] };
        let hits = Hits {
            t,
            normal: id.iter().map(normal).collect(),
            level: id.iter().map(|id| (id % 3) as u8).collect(),
            id,
            ..Hits::default()
        };
        let colors = match encoding {
            Encoding::Srgb8 => Colors::Srgb8((0..n).map(|_| rng.random()).collect()),
            Encoding::Srgb16 => Colors::Srgb16((0..n).map(|_| rng.random()).collect()),
            Encoding::Linear => Colors::Linear((0..n).map(|_| rng.random()).collect()),
        };
        let n_hits = (0..n).map(|i| (i * 41 % (usize::from(n_samples) + 1)) as u16).collect();
        Made { colors, coverage: Coverage { n_hits, n_samples }, hits }
    }

    /// The pixels of a range.
    fn part(&self, first: usize, end: usize) -> Made {
        let Hits { id, t, normal, level, .. } = &self.hits;
        let range = first..end;
        let hits = Hits {
            id: id[range.clone()].to_vec(),
            t: t[range.clone()].to_vec(),
            normal: normal[range.clone()].to_vec(),
            level: level[range.clone()].to_vec(),
            ..Hits::default()
        };
        let colors = match &self.colors {
            Colors::Srgb8(pixels) => Colors::Srgb8(pixels[range.clone()].to_vec()),
            Colors::Srgb16(pixels) => Colors::Srgb16(pixels[range.clone()].to_vec()),
            Colors::Linear(pixels) => Colors::Linear(pixels[range.clone()].to_vec()),
        };
        let coverage = Coverage { n_hits: self.coverage.n_hits[range].to_vec(), ..self.coverage };
        Made { colors, coverage, hits }
    }

    fn put<W: std::io::Write + std::io::Seek>(
        &self,
        writer: &mut PictureWriter<W>,
        options: PictureOptions,
        n_rows: u32,
    ) -> Result<()> {
        let Made { colors, coverage, hits } = self.clone();
        let coverage = options.transparent.then_some(coverage);
        writer.band(&Framebuffer { hits, colors, coverage }, n_rows)
    }

    /// A file of these pixels, written in bands.
    fn file(
        &self,
        format: Format,
        options: PictureOptions,
        pixels: &Pixels,
        n_band_rows: u32,
    ) -> Result<Vec<u8>> {
        let sink = Cursor::new(Vec::new());
        let mut writer = writer(format, options, pixels, sink)?;
        for first in (0..pixels.height).step_by(n_band_rows as usize) {
            let n = n_band_rows.min(pixels.height - first);
            let [first, end] = [first, first + n].map(|row| (row * pixels.width) as usize);
            self.part(first, end).put(&mut writer, options, n)?;
        }
        Ok(writer.finish()?.into_inner())
    }

    /// What a file of these pixels must hold.
    fn channels(&self, format: Format, options: PictureOptions) -> Channels {
        let mut channels = Channels::new();
        let mut add = |name: &str, numbers: Vec<u32>| drop(channels.insert(name.into(), numbers));
        for (i, name) in ["R", "G", "B"].into_iter().enumerate() {
            let numbers = match &self.colors {
                Colors::Srgb8(pixels) => pixels.iter().map(|rgb| rgb[i].into()).collect(),
                Colors::Srgb16(pixels) => pixels.iter().map(|rgb| rgb[i].into()).collect(),
                Colors::Linear(pixels) => pixels.iter().map(|rgb| rgb[i].to_bits()).collect(),
            };
            add(name, numbers);
        }
        let Coverage { n_hits, n_samples } = &self.coverage;
        let of = u64::from(*n_samples);
        let alpha = |&n: &u16| match self.colors.encoding() {
            Encoding::Linear if !options.transparent => 1f32.to_bits(),
            Encoding::Linear => ((f64::from(n) / of as f64) as f32).to_bits(),
            encoding => {
                // To the nearest whole number, half up, as decimals on paper do it.
                let largest = if encoding == Encoding::Srgb8 { 255 } else { 65535 };
                let all = u64::from(n) * largest;
                (all / of + u64::from(2 * (all % of) >= of)) as u32
            }
        };
        if options.transparent || format == Format::Exr {
            add("A", n_hits.iter().map(alpha).collect());
        }
        if matches!(format, Format::Exr | Format::Npy) {
            let Hits { id, t, normal, level, .. } = &self.hits;
            add("id", id.clone());
            add("Z", t.iter().map(|t| t.to_bits()).collect());
            for (i, name) in ["N.X", "N.Y", "N.Z"].into_iter().enumerate() {
                add(name, normal.iter().map(|n| n[i].to_bits()).collect());
            }
            if options.certificates {
                add("level", level.iter().map(|&level| level.into()).collect());
            }
        }
        channels
    }
}

/// A picture of 4 × 3 pixels in a file of this format.
pub fn small_file(format: Format) -> Vec<u8> {
    let rng = &mut ChaCha8Rng::seed_from_u64(SEED);
    let made = Made::new(rng, format.encoding(ChannelBits::Eight), 12, 1);
    made.file(format, EIGHT, &whole(4, 3), 3).unwrap()
}

/// Columns, rows and numbers of a file, read by another program's reader.
fn decoded(format: Format, bytes: &[u8]) -> std::result::Result<([usize; 2], Channels), String> {
    match format {
        Format::Exr => read_exr(bytes).map(|file| (file.size, file.channels)),
        Format::Npy => {
            let (dtype, shape, records) = read_npy(bytes);
            Ok(([shape[1], shape[0]], fields(&dtype, &records)))
        }
        Format::Png | Format::Ppm => {
            let kind = match format {
                Format::Png => image::ImageFormat::Png,
                _ => image::ImageFormat::Pnm,
            };
            let image = image::load_from_memory_with_format(bytes, kind);
            let image = image.map_err(|error| error.to_string())?;
            let size = [image.width() as usize, image.height() as usize];
            let numbers: Vec<u32> = match &image {
                DynamicImage::ImageRgb8(image) => image.iter().map(|&n| n.into()).collect(),
                DynamicImage::ImageRgba8(image) => image.iter().map(|&n| n.into()).collect(),
                DynamicImage::ImageRgb16(image) => image.iter().map(|&n| n.into()).collect(),
                DynamicImage::ImageRgba16(image) => image.iter().map(|&n| n.into()).collect(),
                _ => return Err("neither RGB nor RGBA".into()),
            };
            let n = usize::from(image.color().channel_count());
            let channel = |i| numbers.iter().skip(i).step_by(n).copied().collect();
            let names = ["R", "G", "B", "A"].into_iter().take(n).enumerate();
            Ok((size, names.map(|(i, name)| (name.to_string(), channel(i))).collect()))
        }
    }
}

struct ExrFile {
    display: exr::meta::attribute::IntegerBounds,
    position: Vec2<i32>,
    size: [usize; 2],
    software: String,
    channels: Channels,
}

fn read_exr(bytes: &[u8]) -> std::result::Result<ExrFile, String> {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .pedantic()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| error.to_string())?;
    let layer = image.layer_data;
    let channels = layer.channel_data.list.into_iter().map(|channel| {
        let bits = match channel.sample_data {
            FlatSamples::F32(v) => v.iter().map(|v| v.to_bits()).collect(),
            FlatSamples::U32(v) => v,
            FlatSamples::F16(_) => panic!("half floats"),
        };
        (channel.name.to_string(), bits)
    });
    Ok(ExrFile {
        display: image.attributes.display_window,
        position: layer.attributes.layer_position,
        size: [layer.size.0, layer.size.1],
        software: layer.attributes.software_name.unwrap_or_default().to_string(),
        channels: channels.collect(),
    })
}

/// A structured array: its type as the header has it, the shape, and the raw records.
fn read_npy(bytes: &[u8]) -> (String, Vec<usize>, Vec<u8>) {
    assert_eq!(bytes[..8], *b"\x93NUMPY\x01\x00");
    let n_text = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!((10 + n_text) % 64, 0);
    let (text, records) = bytes[10..].split_at(n_text);
    let text = std::str::from_utf8(text).unwrap().strip_suffix('\n').unwrap().trim_end();
    let text = text.strip_prefix("{'descr': ").unwrap().strip_suffix("), }").unwrap();
    let (dtype, shape) = text.split_once(", 'fortran_order': False, 'shape': (").unwrap();
    let shape = shape.split_terminator(", ").map(|n| n.parse().unwrap()).collect();
    (dtype.to_owned(), shape, records.to_vec())
}

/// The numbers of records of this type.
fn fields(dtype: &str, records: &[u8]) -> Channels {
    let known: [(&str, &[&str], usize); 6] = [
        ("('id', '<u4'), ", &["id"], 4),
        ("('t', '<f4'), ", &["Z"], 4),
        ("('normal', '<f4', (3,)), ", &["N.X", "N.Y", "N.Z"], 4),
        ("('rgb', '<f4', (3,)), ", &["R", "G", "B"], 4),
        ("('a', '<f4'), ", &["A"], 4),
        ("('level', '|u1'), ", &["level"], 1),
    ];
    let mut rest = dtype.strip_prefix('[').unwrap().strip_suffix(']').unwrap();
    let (mut places, mut n_bytes) = (Vec::new(), 0);
    while !rest.is_empty() {
        let field = known.iter().find_map(|field| Some((field, rest.strip_prefix(field.0)?)));
        let ((_, names, size), behind) = field.unwrap_or_else(|| panic!("{dtype}"));
        for name in *names {
            places.push((*name, n_bytes, *size));
            n_bytes += size;
        }
        rest = behind;
    }
    let (records, rest) = (records.chunks_exact(n_bytes), records.len() % n_bytes);
    assert_eq!(rest, 0);
    let numbers = |at: usize, size: usize| {
        let number = |record: &[u8]| {
            let mut word = [0; 4];
            word[..size].copy_from_slice(&record[at..at + size]);
            u32::from_le_bytes(word)
        };
        records.clone().map(number).collect()
    };
    places.iter().map(|&(name, at, size)| (name.to_string(), numbers(at, size))).collect()
}

/// However its rows are cut into bands; and a flipped bit is noticed.
#[test]
fn every_file_holds_every_value_bit_for_bit() {
    let rng = &mut ChaCha8Rng::seed_from_u64(SEED);
    let all = [EIGHT, SIXTEEN, CERTIFICATES].into_iter().chain(TRANSPARENT);
    for (format, options) in Format::ALL.into_iter().flat_map(|f| all.clone().map(move |o| (f, o)))
    {
        for (width, height, n_samples) in
            [(1, 1, 1), (3, 16, 4), (17, 33, 9), (40, 50, 36), (1, 100, 196), (31, 70, 256)]
        {
            let what = format!("{format} {options:?} {width}x{height}");
            let pixels = whole(width, height);
            let n = (width * height) as usize;
            let made = Made::new(rng, format.encoding(options.bits), n, n_samples);
            let file = |n_rows| made.file(format, options, &pixels, n_rows);
            if options.check(format).is_err() {
                assert!(matches!(file(height), Err(Error::Usage(_))), "{what}");
                continue;
            }
            let whole = file(height).unwrap();
            let expected = ([width as usize, height as usize], made.channels(format, options));
            assert!(decoded(format, &whole).as_ref() == Ok(&expected), "{what}");
            for n_rows in [1, 7, 16, 64] {
                assert!(file(n_rows).unwrap() == whole, "{what} in bands of {n_rows}");
            }
            // The middle of a larger file is pixels.
            if n > 1000 {
                let mut bad = whole.clone();
                bad[whole.len() / 2] ^= 0x10;
                assert!(decoded(format, &bad).as_ref() != Ok(&expected), "{what}: a flipped bit");
            }
        }
    }
}

/// Bytes of all values as a file names them; with 16 bits the same digits twice, as 65535 = 257·255.
#[test]
fn every_srgb_value_comes_out_as_the_file_names_it() {
    // The sRGB curve from its standard, in the other direction than the writer's.
    let linear = |byte: u8| {
        let v = f64::from(byte) / 255.0;
        if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
    };
    let srgb: Vec<[u8; 3]> =
        (0..=255_u8).map(|i| [i, 255 - i, i.wrapping_mul(167).wrapping_add(13)]).collect();
    let object = |&[r, g, b]: &[u8; 3]| Plane {
        name: None,
        point: DVec3::ZERO,
        normal: DVec3::Y,
        color: Color([r, g, b].map(linear)),
    };
    let planes: Vec<_> = srgb.iter().map(object).collect();
    let scene =
        Scene { background: planes[0].color, planes: planes[1..].into(), ..Scene::default() };
    let shaded = |encoding, ids: &[u32]| {
        let mut colors = Colors::new(encoding);
        Palette::new(&scene, &Style::new(encoding)).shade(ids, &mut colors).map(|()| colors)
    };
    let ids: Vec<u32> = (0..256).collect();
    let twice = srgb.iter().map(|rgb| rgb.map(|byte| u16::from(byte) * 257)).collect();
    assert!(shaded(Encoding::Srgb8, &ids).unwrap() == Colors::Srgb8(srgb));
    assert!(shaded(Encoding::Srgb16, &ids).unwrap() == Colors::Srgb16(twice));
    let message = shaded(Encoding::Linear, &[256]).unwrap_err().to_string();
    assert!(message.contains("id 256") && message.contains("end at 255"), "{message}");
}

#[test]
fn files_say_what_they_are() {
    let bytes = small_file(Format::Png);
    let reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    assert_eq!(reader.info().srgb, Some(png::SrgbRenderingIntent::Perceptual));
    let software = &reader.info().uncompressed_latin1_text[0];
    assert_eq!(software.keyword, "Software");
    assert!(software.text.starts_with("kugelblitz "));
    // A part says where it belongs.
    let made = Made::new(&mut ChaCha8Rng::seed_from_u64(SEED), Encoding::Linear, 20 * 35, 1);
    let pixels = Pixels { x: 600, y: 101, width: 20, height: 35, ..whole(640, 480) };
    let file = read_exr(&made.file(Format::Exr, EIGHT, &pixels, 35).unwrap()).unwrap();
    assert!(file.software.starts_with("kugelblitz "));
    assert_eq!((file.display.position, file.display.size), (Vec2(0, 0), Vec2(640, 480)));
    assert_eq!((file.position, file.size), (Vec2(600, 101), [20, 35]));
    assert!(file.channels == made.channels(Format::Exr, EIGHT));
    let of_array = made.file(Format::Npy, TRANSPARENT[2], &pixels, 35).unwrap();
    let dtype = "[('id', '<u4'), ('t', '<f4'), ('normal', '<f4', (3,)), ('rgb', '<f4', (3,)), \
                 ('a', '<f4'), ('level', '|u1'), ]";
    assert_eq!(read_npy(&of_array).0, dtype);
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
    for (n, has_level) in [(0, false), (3, false), (70_000, true)] {
        let rng = &mut ChaCha8Rng::seed_from_u64(SEED);
        let mut made = Made::new(rng, Encoding::Linear, n, 1);
        let mut expected = made.channels(Format::Npy, CERTIFICATES);
        expected.retain(|name, _| !["R", "G", "B"].contains(&&**name));
        if !has_level {
            made.hits.level.clear();
            expected.remove("level");
        }
        write(&path, &made.hits).unwrap();
        let (dtype, shape, records) = read_npy(&std::fs::read(&path).unwrap());
        assert_eq!(shape, [n]);
        assert!(fields(&dtype, &records) == expected, "{n}");
    }
    let lacking = Hits { id: vec![1], ..Hits::default() };
    assert!(matches!(write(&path, &lacking), Err(Error::Usage(_))));
}

/// Bands of another size, colours in another encoding or too few, no alpha where there must be some.
#[test]
fn what_does_not_fit_is_refused() {
    let rng = &mut ChaCha8Rng::seed_from_u64(SEED);
    for format in Format::ALL {
        let begin = |options| writer(format, options, &whole(4, 2), Cursor::new(Vec::new()));
        let made = Made::new(rng, format.encoding(ChannelBits::Eight), 8, 4);
        let rows =
            |made: &Made, n_rows| made.put(&mut begin(CERTIFICATES).unwrap(), CERTIFICATES, n_rows);
        let other = match &made.colors {
            Colors::Linear(_) => Colors::Srgb8(vec![[0; 3]; 8]),
            _ => Colors::Linear(vec![[0.0; 3]; 8]),
        };
        let too_few = Colors::new(made.colors.encoding());
        let made_of = |colors| Made { colors, ..made.clone() };
        assert!(rows(&made, 2).is_ok(), "{format}");
        for refused in
            [rows(&made, 3), rows(&made, 1), rows(&made_of(other), 2), rows(&made_of(too_few), 2)]
        {
            assert!(matches!(refused, Err(Error::Usage(_))), "{format}: {refused:?}");
        }
        let ids_only = Hits { id: made.hits.id.clone(), ..Hits::default() };
        let is_enough = !format.wants(true).surface;
        let found = rows(&Made { hits: ids_only, ..made.clone() }, 2);
        assert_eq!(found.is_ok(), is_enough, "{format}");

        let transparent = with_alpha(EIGHT);
        if format == Format::Ppm {
            let hint = begin(transparent).err().unwrap().hint().to_string();
            assert!(hint.contains(".png, .exr or .npy"), "{hint}");
            continue;
        }
        let mut short = made.clone();
        short.coverage.n_hits.pop();
        let mut more = made.clone();
        more.coverage.n_hits[7] = 5;
        for (made, options, is_alpha, says) in [
            (&short, transparent, true, "7 entries of “coverage”"),
            (&more, transparent, true, "no more hits than its 4"),
            (&made, transparent, false, "is transparent"),
            (&made, EIGHT, true, "is not transparent"),
        ] {
            let given = PictureOptions { transparent: is_alpha, ..options };
            let message = made.put(&mut begin(options).unwrap(), given, 2).unwrap_err().to_string();
            assert!(message.contains(says), "{format}: {message}");
        }
    }
    let coverage = Coverage { n_hits: vec![0, 1, 0], n_samples: 1 };
    assert_eq!(Coverage::of_ids(&[0, 7, 0], 3, 1), coverage);
}

/// One that ends too early is no better than an interrupted one.
#[test]
fn a_picture_without_its_last_rows_is_refused() {
    for format in Format::ALL {
        let rng = &mut ChaCha8Rng::seed_from_u64(SEED);
        let made = Made::new(rng, format.encoding(ChannelBits::Eight), 8 * 8, 1);
        let sink = Cursor::new(Vec::new());
        let mut writer = writer(format, EIGHT, &whole(8, 8), sink).unwrap();
        made.part(0, 32).put(&mut writer, EIGHT, 4).unwrap();
        assert!(matches!(writer.finish(), Err(Error::Usage(_))), "{format}");
    }
}
