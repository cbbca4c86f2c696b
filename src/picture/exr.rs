//! OpenEXR: one layer of scan lines, ZIP-compressed in blocks of 16 lines, without loss.
//!
//! Alpha is 1 everywhere, unless the picture is transparent: the background is a colour of the picture,
//! not a hole in it, and with alpha 0 a viewer would show it as black or add it to what lies below.
//! What was hit is in `id`.

use std::io::{self, Cursor};

use exr::block::chunk::CompressedBlock;
use exr::block::{BlockIndex, UncompressedBlock};
use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, IntegerBounds, LineOrder, SampleType, Text};
use exr::meta::header::{Header, LayerAttributes};

use super::{Encoder, Metadata, NBytes, PictureOptions, SOFTWARE, linear};
use crate::error::{Error, Hint, Message, Result, Setting};
use crate::lighting::Framebuffer;
use crate::rays::Pixels;
use crate::support::parallel;

/// Lines that are compressed together. The format fixes this number for its ZIP compression.
const BLOCK_LINES: usize = 16;

/// Largest width and height of a picture, px: the C++ library wants edges below `i32::MAX / 2`.
const MAX_EDGE_PX: u32 = i32::MAX as u32 / 2 - 1;

/// Largest block, bytes; the format counts them in an i32.
const MAX_BLOCK_BYTES: u128 = i32::MAX as u128;

/// Bytes of a channel's sample: all are f32 or u32.
const SAMPLE_BYTES: usize = 4;

/// Name, type and what gives the bits of a pixel's sample.
type ExrChannel = (&'static str, SampleType, fn(&Framebuffer, usize) -> u32);

/// The channels, sorted by name, as the format demands.
const CHANNELS: [ExrChannel; 10] = [
    ("A", SampleType::F32, |rows, i| {
        rows.coverage.as_ref().map_or(1.0, |coverage| coverage.alpha(i)).to_bits()
    }),
    ("B", SampleType::F32, |rows, i| linear(&rows.colors)[i][2].to_bits()),
    ("G", SampleType::F32, |rows, i| linear(&rows.colors)[i][1].to_bits()),
    ("N.X", SampleType::F32, |rows, i| rows.hits.normal[i][0].to_bits()),
    ("N.Y", SampleType::F32, |rows, i| rows.hits.normal[i][1].to_bits()),
    ("N.Z", SampleType::F32, |rows, i| rows.hits.normal[i][2].to_bits()),
    ("R", SampleType::F32, |rows, i| linear(&rows.colors)[i][0].to_bits()),
    ("Z", SampleType::F32, |rows, i| rows.hits.t[i].to_bits()),
    ("id", SampleType::U32, |rows, i| rows.hits.id[i]),
    // Only with certificates.
    ("level", SampleType::U32, |rows, i| rows.hits.level[i].into()),
];

fn channels(options: PictureOptions) -> &'static [ExrChannel] {
    &CHANNELS[..CHANNELS.len() - usize::from(!options.certificates)]
}

/// For a band its lines, once as they are and once compressed (which is never longer), three copies of a
/// block on each thread, and the table of blocks.
pub(super) fn n_bytes(
    options: PictureOptions,
    pixels: &Pixels,
    n_band_rows: u32,
) -> Result<NBytes> {
    if pixels.image_width > MAX_EDGE_PX || pixels.image_height > MAX_EDGE_PX {
        return Err(Error::TooLarge(
            format!(
                "OpenEXR holds at most {MAX_EDGE_PX} pixels a side, not {}x{}; write .npy",
                pixels.image_width, pixels.image_height
            )
            .into(),
        ));
    }
    let pixel = (channels(options).len() * SAMPLE_BYTES) as u128;
    let max_width = MAX_BLOCK_BYTES / (pixel * BLOCK_LINES as u128);
    if u128::from(pixels.width) > max_width {
        let text = format!(
            "OpenEXR holds at most {max_width} columns of these channels, not {}",
            pixels.width
        );
        let hint = Hint::new("write .npy, or parts with {}", [Setting::named("crop")]);
        return Err(Error::TooLarge(Message::new(text, hint)));
    }
    let line_bytes = u128::from(pixels.width) * pixel;
    let n_lines = u128::from(n_band_rows) + BLOCK_LINES as u128;
    let n_copied_lines = 3 * BLOCK_LINES * rayon::current_num_threads();
    let n_blocks = u128::from(pixels.height).div_ceil(BLOCK_LINES as u128);
    let band = (2 * n_lines + n_copied_lines as u128) * line_bytes + 8 * n_blocks;
    Ok(NBytes { pixel, band })
}

struct Exr {
    header: Header,
    channels: &'static [ExrChannel],
    width: usize,
    height: usize,
    line_bytes: usize,
    /// Where the table of blocks lies in the file, bytes.
    table_position_bytes: u64,
    /// Where each block that is written begins in the file, bytes.
    table: Vec<u64>,
    /// Bytes of the file so far.
    file_bytes: u64,
    /// Lines that wait for their block to fill: for each line, for each channel, its samples.
    lines: Vec<u8>,
}

pub(super) fn begin(
    options: PictureOptions,
    pixels: &Pixels,
    metadata: &Metadata,
    out: &mut Vec<u8>,
) -> io::Result<Box<dyn Encoder>> {
    let channels = channels(options);
    let width = pixels.width as usize;
    let height = pixels.height as usize;
    let mut header = Header::new(
        Text::default(),
        (width, height),
        channels
            .iter()
            .map(|&(name, sample_type, _)| ChannelDescription::new(name, sample_type, true))
            .collect(),
    )
    .with_encoding(Compression::ZIP16, BlockDescription::ScanLines, LineOrder::Increasing)
    .with_display_window(IntegerBounds::from_dimensions((
        pixels.image_width as usize,
        pixels.image_height as usize,
    )));
    header.own_attributes = LayerAttributes {
        layer_name: None,
        // `n_bytes` has made sure of i32.
        layer_position: Vec2(pixels.x as i32, pixels.y as i32),
        software_name: Some(Text::from(SOFTWARE)),
        ..LayerAttributes::default()
    };

    // The crate writes a file inside one call, from a closure that has all blocks. Bands come
    // from outside, so that call is left after the head and the table (zeros so far) are
    // written, and the blocks follow here, encoded by the crate one by one.
    let head = Cursor::new(&mut *out);
    let headers = std::iter::once(header.clone()).collect();
    match exr::block::write(head, headers, true, |_, _| Err(exr::error::Error::Aborted)) {
        Ok(()) | Err(exr::error::Error::Aborted) => {}
        Err(error) => return Err(to_io(error)),
    }
    let table_bytes = header.chunk_count * size_of::<u64>();
    // The crate keeps attributes of one's own in a map without an order, which would make the file another
    // one in each run. They go before the zero that ends the header, which stands before the table.
    let end_of_attributes = out.len() - table_bytes - 1;
    out.splice(end_of_attributes..end_of_attributes, attributes(metadata));
    Ok(Box::new(Exr {
        channels,
        width,
        height,
        line_bytes: width * channels.len() * SAMPLE_BYTES,
        table_position_bytes: (out.len() - table_bytes) as u64,
        table: Vec::with_capacity(header.chunk_count),
        file_bytes: out.len() as u64,
        lines: Vec::new(),
        header,
    }))
}

/// The metadata as attributes of the type `string`: name and type with a zero behind each, the length,
/// and the text.
fn attributes(metadata: &Metadata) -> Vec<u8> {
    let mut bytes = Vec::new();
    for (name, text) in metadata.texts() {
        bytes.extend([name.as_bytes(), b"\0string\0"].concat());
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(text.as_bytes());
    }
    bytes
}

impl Encoder for Exr {
    fn rows(&mut self, rows: &Framebuffer, out: &mut Vec<u8>) -> io::Result<()> {
        let (channels, width, before) = (self.channels, self.width, self.lines.len());
        self.lines.resize(before + rows.hits.id.len() / width * self.line_bytes, 0);
        let lines = self.lines[before..].chunks_mut(self.line_bytes).enumerate();
        parallel::map(lines, |(y, line)| {
            // In the byte order of this machine, as the crate wants it.
            let (samples, _) = line.as_chunks_mut::<SAMPLE_BYTES>();
            for ((.., sample), samples) in channels.iter().zip(samples.chunks_mut(width)) {
                for (bytes, i) in samples.iter_mut().zip(y * width..) {
                    *bytes = sample(rows, i).to_ne_bytes();
                }
            }
        });
        let n_lines = self.lines.len() / self.line_bytes;
        let n_lines_done = self.table.len() * BLOCK_LINES;
        let is_end = n_lines_done + n_lines == self.height;
        let n_ready = if is_end { n_lines } else { n_lines - n_lines % BLOCK_LINES };
        let rest = self.lines.split_off(n_ready * self.line_bytes);
        let blocks = self.lines.chunks(BLOCK_LINES * self.line_bytes).enumerate();
        let blocks = parallel::map(blocks, |(index, lines)| {
            self.encode_block(n_lines_done + index * BLOCK_LINES, lines)
        });
        self.lines = rest;
        for block in blocks {
            let block = block.map_err(to_io)?;
            self.table.push(self.file_bytes);
            self.file_bytes += block.len() as u64;
            out.extend_from_slice(&block);
        }
        Ok(())
    }

    /// The table of blocks and its place in the file.
    fn finish(self: Box<Self>, _: &mut Vec<u8>) -> io::Result<Option<(u64, Vec<u8>)>> {
        let table = self.table.iter().flat_map(|p| p.to_le_bytes()).collect();
        Ok(Some((self.table_position_bytes, table)))
    }
}

impl Exr {
    /// The bytes of one block as they stand in the file; `first_line` counts from the top of the
    /// data window.
    fn encode_block(&self, first_line: usize, lines: &[u8]) -> exr::error::Result<Vec<u8>> {
        let block = UncompressedBlock {
            index: BlockIndex {
                layer: 0,
                pixel_position: Vec2(0, first_line),
                pixel_size: Vec2(self.width, lines.len() / self.line_bytes),
                level: Vec2(0, 0),
            },
            data: lines.to_vec(),
        };
        let chunk = block.compress_to_chunk(std::slice::from_ref(&self.header))?;
        let mut bytes = Vec::new();
        match chunk.compressed_block {
            CompressedBlock::ScanLine(block) => block.write(&mut bytes)?,
            _ => {
                return Err(exr::error::Error::NotSupported("blocks other than scan lines".into()));
            }
        }
        Ok(bytes)
    }
}

fn to_io(error: exr::error::Error) -> io::Error {
    match error {
        exr::error::Error::Io(error) => error,
        other => io::Error::other(other.to_string()),
    }
}
