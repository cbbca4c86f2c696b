//! PNG: RGB or, for transparent pictures, RGBA; 8 or 16 bits, marked as sRGB.

use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};

use png::{BitDepth, ColorType, Compression, Filter, SrgbRenderingIntent, StreamWriter};

use super::{ChannelBits, Encoder, Metadata, NBytes, PictureOptions, SOFTWARE, be_bytes};
use crate::error::{Error, Hint, Message, Result, Setting};
use crate::lighting::Framebuffer;
use crate::rays::Pixels;

/// The PNG specification's limit for width and height, px.
const MAX_SIDE_PX: u32 = (1 << 31) - 1;

/// Bytes of one IDAT chunk; a large one keeps the overhead of 12 bytes a chunk out of sight.
const CHUNK_BYTES: usize = 1 << 16;

pub(super) fn pixel_bytes(options: PictureOptions) -> u128 {
    let n_channels = if options.transparent { 4 } else { 3 };
    match options.bits {
        ChannelBits::Eight => n_channels,
        ChannelBits::Sixteen => 2 * n_channels,
    }
}

/// For a band three rows (this and the last one in the codec, filtered), for 16 bits the band with its
/// bytes swapped, for alpha the band with it, and the compressed band. The longest code of the codec's fixed
/// table has 12 bits for 8.
pub(super) fn n_bytes(
    options: PictureOptions,
    pixels: &Pixels,
    n_band_rows: u32,
) -> Result<NBytes> {
    if pixels.width.max(pixels.height) > MAX_SIDE_PX {
        let text = format!(
            "PNG holds at most {MAX_SIDE_PX} pixels a side, not {}x{}",
            pixels.width, pixels.height
        );
        let hint = Hint::new("write .npy, or parts with {}", [Setting::named("crop")]);
        return Err(Error::TooLarge(Message::new(text, hint)));
    }
    let pixel = pixel_bytes(options);
    let row_bytes = u128::from(pixels.width) * pixel + 1;
    let compressed_bytes = row_bytes * u128::from(n_band_rows) * 3 / 2;
    let is_copied = options.transparent || options.bits == ChannelBits::Sixteen;
    let copied_bytes = if is_copied { row_bytes * u128::from(n_band_rows) } else { 0 };
    let band = 3 * row_bytes + copied_bytes + 2 * compressed_bytes + 2 * CHUNK_BYTES as u128;
    Ok(NBytes { pixel, band })
}

struct Png {
    stream: StreamWriter<'static, Tray>,
    tray: Tray,
}

pub(super) fn begin(
    options: PictureOptions,
    pixels: &Pixels,
    metadata: &Metadata,
    out: &mut Vec<u8>,
) -> io::Result<Box<dyn Encoder>> {
    let tray = Tray::default();
    let mut encoder = encoder(tray.clone(), [pixels.width, pixels.height])?;
    if options.transparent {
        encoder.set_color(ColorType::Rgba);
    }
    if options.bits == ChannelBits::Sixteen {
        encoder.set_depth(BitDepth::Sixteen);
    }
    for (name, text) in metadata.texts() {
        encoder.add_text_chunk(name.clone(), text.clone())?;
    }
    // Flat surfaces make rows that equal the row above nearly everywhere. The filter “up”
    // turns those into zeros, and the fast codec is made for runs of zeros.
    encoder.set_filter(Filter::Up);
    let stream = encoder.write_header()?.into_stream_writer_with_size(CHUNK_BYTES)?;
    tray.empty_into(out);
    Ok(Box::new(Png { stream, tray }))
}

impl Encoder for Png {
    fn rows(&mut self, rows: &Framebuffer, out: &mut Vec<u8>) -> io::Result<()> {
        self.stream.write_all(&be_bytes(rows))?;
        self.tray.empty_into(out);
        Ok(())
    }

    fn finish(self: Box<Self>, out: &mut Vec<u8>) -> io::Result<Option<(u64, Vec<u8>)>> {
        self.stream.finish()?;
        self.tray.empty_into(out);
        Ok(None)
    }
}

/// An encoder of sRGB with 8 bits a channel.
fn encoder<W: Write>(sink: W, [width, height]: [u32; 2]) -> io::Result<png::Encoder<'static, W>> {
    let mut encoder = png::Encoder::new(sink, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder.set_compression(Compression::Fast);
    encoder.add_text_chunk("Software".into(), SOFTWARE.into())?;
    Ok(encoder)
}

/// A whole PNG file of an sRGB picture, for pictures that no camera took.
///
/// # Errors
/// That of the codec, for another number of pixels than the size has.
pub fn rgb8_file(size: [u32; 2], srgb8: &[[u8; 3]]) -> io::Result<Vec<u8>> {
    let mut file = Vec::new();
    let mut writer = encoder(&mut file, size)?.write_header()?;
    writer.write_image_data(srgb8.as_flattened())?;
    writer.finish()?;
    Ok(file)
}

/// Where the codec leaves its bytes. It can't be given the file itself: it unwraps some results
/// of `write`, and keeps only the text of the others, so a full disk would end in a panic.
#[derive(Clone, Default)]
struct Tray(Arc<Mutex<Vec<u8>>>);

impl Tray {
    fn empty_into(&self, out: &mut Vec<u8>) {
        out.append(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner));
    }
}

impl Write for Tray {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
