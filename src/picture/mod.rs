//! Colours and [`Hits`](crate::query::Hits) → picture file: [`PictureWriter`] takes bands of rows from top to bottom
//! and writes PNG, EXR, PPM or NPY into an
//! [`OutputFile`](crate::output::OutputFile) or any other sink. Memory is bounded by a
//! band, not by the picture.
//!
//! # What is not promised
//! Bytes of a file may change from one version to the next; decoded values do not.

mod exr;
mod format;
pub(crate) mod hit_record;
mod metadata;
mod npy;
mod png;
mod ppm;
mod rays;
mod read;

use std::borrow::Cow;
use std::fmt::Display;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::PathBuf;

use crate::error::{Error, Hint, Message, Result, Setting, wrong_usage};
use crate::lighting::{Colors, Encoding, Framebuffer};
use crate::plain::Shown;
use crate::query::{Coverage, Outputs};
use crate::rays::Pixels;
pub use format::{ChannelBits, Format};
pub use metadata::Metadata;
pub use png::rgb8_file;
pub use rays::{STDIN, hit_records, read_rays, write_hits};
pub use read::{
    Channel, ChannelFacts, ChannelValues, Image, ImageFacts, channel_name, read_bytes, read_image,
};

/// The maker that every file names.
const SOFTWARE: &str = concat!("kugelblitz ", env!("CARGO_PKG_VERSION"));

/// The largest file offset that operating systems can name, bytes.
const MAX_FILE_BYTES: u64 = i64::MAX as u64;

/// How a picture is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PictureOptions {
    /// Bits a channel in PNG and PPM.
    pub bits: ChannelBits,
    /// True where EXR and NPY get the level that decided each pixel.
    pub certificates: bool,
    /// True where the background is left out of PNG, EXR and NPY: alpha is the share of a pixel's
    /// samples that hit an object.
    pub transparent: bool,
}

impl PictureOptions {
    /// Refuses what a format has no place for.
    ///
    /// # Errors
    /// [`Error::Usage`] for a transparent PPM.
    pub fn check(self, format: Format) -> Result<()> {
        if self.transparent && format == Format::Ppm {
            return wrong_usage(Message::new(
                "PPM has no alpha for a transparent background",
                "write .png, .exr or .npy",
            ));
        }
        Ok(())
    }
}

/// Bytes that a [`PictureWriter`] holds at most, beside the colours and [`Hits`](crate::query::Hits) it is given, for
/// bands of `n_band_rows` rows.
///
/// # Errors
/// [`Error::Usage`] for an empty rectangle or one outside its picture, and as
/// [`PictureOptions::check`]; [`Error::TooLarge`] for a picture that the format can't hold.
pub fn writer_bytes(
    format: Format,
    options: PictureOptions,
    pixels: &Pixels,
    n_band_rows: u32,
) -> Result<u64> {
    options.check(format)?;
    let Pixels { image_width, image_height, x, y, width, height, .. } = *pixels;
    if width == 0 || height == 0 {
        return wrong_usage(format!(
            "a picture of {width}x{height} pixels is empty; give it at least one column and row"
        ));
    }
    if !pixels.is_in_picture() {
        return wrong_usage(format!(
            "the rectangle {x},{y},{width},{height} is not inside the picture of \
             {image_width}x{image_height} pixels"
        ));
    }

    let n_bytes = match format {
        Format::Png => png::n_bytes,
        Format::Ppm => ppm::n_bytes,
        Format::Npy => npy::n_bytes,
        Format::Exr => exr::n_bytes,
    };
    let NBytes { pixel: pixel_bytes, band: band_bytes } =
        n_bytes(options, pixels, n_band_rows.min(height))?;
    let file_bytes = u128::from(width) * u128::from(height) * pixel_bytes;
    if file_bytes > u128::from(MAX_FILE_BYTES) {
        let text = format!(
            "a picture of {width}x{height} pixels has {file_bytes} bytes, more than a file can have ({MAX_FILE_BYTES})"
        );
        let hint = Hint::new("render parts of it with {}", [Setting::named("crop")]);
        return Err(Error::TooLarge(Message::new(text, hint)));
    }
    // What doesn't fit u64 doesn't fit any memory either, and the caller compares with that.
    Ok(u64::try_from(band_bytes).unwrap_or(u64::MAX))
}

/// Takes the bands of a picture, from top to bottom.
pub trait Sink {
    /// Takes the next `n_rows` rows.
    ///
    /// # Errors
    /// Those of the sink.
    fn band(&mut self, rows: &Framebuffer, n_rows: u32) -> Result<()>;
}

/// Writes one picture, band by band, from top to bottom.
///
/// ```
/// # use kugelblitz::rays::{Pixels, View};
/// # use kugelblitz::{glam::DVec3, picture::*, scene::Camera, query::Hits};
/// # use kugelblitz::lighting::{Colors, Framebuffer};
/// # fn main() -> kugelblitz::Result<()> {
/// let view = View::new(&Camera::new(DVec3::Z, DVec3::ZERO));
/// let pixels = Pixels::whole(view, 2, 1);
/// let (options, sink) = (PictureOptions::default(), std::io::Cursor::new(Vec::new()));
/// let metadata = Metadata::default();
/// let mut writer =
///     PictureWriter::create(Format::Ppm, options, &pixels, &metadata, sink, "memory")?;
/// let hits = Hits { id: vec![0, 1], ..Hits::default() };
/// let colors = Colors::Srgb8(vec![[0; 3], [255, 0, 0]]);
/// writer.band(&Framebuffer { hits, colors, coverage: None }, 1)?;
/// let bytes = writer.finish()?.into_inner();
/// assert_eq!(bytes, b"P6\n2 1\n255\n\0\0\0\xff\0\0");
/// # Ok(())
/// # }
/// ```
///
/// The encoders do no input or output of their own: they append to a buffer, which goes to the
/// sink after each band. So a full disk is met in one place, whatever a codec does with errors.
pub struct PictureWriter<W> {
    encoder: Box<dyn Encoder>,
    pixels: Pixels,
    wants: Outputs,
    encoding: Encoding,
    is_transparent: bool,
    n_rows_done: u32,
    /// Encoded bytes on their way to the sink.
    encoded: Vec<u8>,
    sink: W,
    path: PathBuf,
}

/// Bytes of a format.
struct NBytes {
    /// Bytes of a pixel, before it is compressed.
    pixel: u128,
    /// Bytes held for a band.
    band: u128,
}

/// A picture of one format on its way into bytes.
trait Encoder: Send {
    /// Appends rows to `out`.
    fn rows(&mut self, rows: &Framebuffer, out: &mut Vec<u8>) -> io::Result<()>;

    /// Appends the end to `out`; gives bytes that replace earlier ones of the file, and their place
    /// in it.
    fn finish(self: Box<Self>, _out: &mut Vec<u8>) -> io::Result<Option<(u64, Vec<u8>)>> {
        Ok(None)
    }
}

impl<W: Write + Seek> PictureWriter<W> {
    /// Begins a picture: writes its header to `sink`, which stands at the beginning of its file
    /// and which errors call `path`. PNG and OpenEXR have a place for `metadata`.
    ///
    /// # Errors
    /// Those of [`writer_bytes`], and [`Error::Io`] from the sink.
    pub fn create(
        format: Format,
        options: PictureOptions,
        pixels: &Pixels,
        metadata: &Metadata,
        sink: W,
        path: impl Into<PathBuf>,
    ) -> Result<PictureWriter<W>> {
        writer_bytes(format, options, pixels, 1)?;
        let path = path.into();
        let mut encoded = Vec::new();
        let begin = match format {
            Format::Png => png::begin,
            Format::Ppm => ppm::begin,
            Format::Npy => npy::begin,
            Format::Exr => exr::begin,
        };
        let encoder = begin(options, pixels, metadata, &mut encoded).map_err(Error::io(&path))?;
        let mut writer = PictureWriter {
            encoder,
            pixels: *pixels,
            wants: format.wants(options.certificates),
            encoding: format.encoding(options.bits),
            is_transparent: options.transparent,
            n_rows_done: 0,
            encoded,
            sink,
            path,
        };
        writer.pass_on()?;
        Ok(writer)
    }

    /// Ends the picture and gives the sink back, flushed.
    ///
    /// # Errors
    /// [`Error::Io`] from the sink, [`Error::Usage`] when rows are missing.
    pub fn finish(mut self) -> Result<W> {
        let (height, n_rows) = (self.pixels.height, self.n_rows_done);
        if n_rows != height {
            return self
                .wrong(format!("the picture has {height} rows, but only {n_rows} were written"));
        }
        let end = || -> io::Result<()> {
            let replaced = self.encoder.finish(&mut self.encoded)?;
            self.sink.write_all(&self.encoded)?;
            if let Some((position_bytes, bytes)) = replaced {
                self.sink.seek(SeekFrom::Start(position_bytes))?;
                self.sink.write_all(&bytes)?;
                self.sink.seek(SeekFrom::End(0))?;
            }
            self.sink.flush()
        };
        end().map_err(Error::io(&self.path))?;
        Ok(self.sink)
    }

    fn wrong<T>(&self, usage: impl Display) -> Result<T> {
        wrong_usage(format!("{}: {usage}", self.path.shown()))
    }

    fn check(&self, rows: &Framebuffer, n_rows: u32) -> Result<()> {
        let Framebuffer { hits, colors, coverage } = rows;
        let n_rows_left = self.pixels.height - self.n_rows_done;
        if n_rows > n_rows_left {
            return self.wrong(format!(
                "{n_rows} rows were given, but the picture has only {n_rows_left} left"
            ));
        }
        let (taken, given) = (self.encoding, colors.encoding());
        if given != taken {
            return self.wrong(format!(
                "the picture takes {taken:?}, but colours in {given:?} were given"
            ));
        }
        if coverage.is_some() != self.is_transparent {
            return self.wrong(if self.is_transparent {
                "the picture is transparent; give its rows with their coverage"
            } else {
                "the picture is not transparent; give its rows without a coverage"
            });
        }
        if let Some(Coverage { n_hits, n_samples }) = coverage
            && n_hits.iter().any(|n_hits| n_hits > n_samples || *n_samples == 0)
        {
            return self.wrong(format!(
                "a pixel has at least one sample, and no more hits than its {n_samples}"
            ));
        }
        let n_pixels = self.pixels.width as usize * n_rows as usize;
        let n_covered = coverage.as_ref().map_or(0, |coverage| coverage.n_hits.len());
        for (field, length, is_wanted) in [
            ("colour", colors.len(), true),
            ("coverage", n_covered, self.is_transparent),
            ("id", hits.id.len(), true),
            ("t", hits.t.len(), self.wants.surface),
            ("normal", hits.normal.len(), self.wants.surface),
            ("level", hits.level.len(), self.wants.level),
        ] {
            if is_wanted && length != n_pixels {
                return self.wrong(format!(
                    "{n_rows} rows have {n_pixels} pixels, but {length} entries of “{field}” were given"
                ));
            }
        }
        Ok(())
    }

    fn pass_on(&mut self) -> Result<()> {
        self.sink.write_all(&self.encoded).map_err(Error::io(&self.path))?;
        self.encoded.clear();
        Ok(())
    }
}

impl<W: Write + Seek> Sink for PictureWriter<W> {
    /// Writes the next `n_rows` rows: colours, hits and, of a transparent picture, coverage have one entry a pixel, row
    /// by row. A transparent picture's colour is the mean over the samples that hit in PNG; in EXR and NPY it is the mean
    /// over all samples, those that hit nothing being black: premultiplied, as OpenEXR wants it.
    ///
    /// # Errors
    /// [`Error::Io`] from the sink. [`Error::Usage`] when there are not `n_rows` rows of colours in the
    /// format's [`Encoding`], when there are not as many hits with the fields that [`Format::wants`],
    /// when the rows are more than the picture has, when there is a coverage and the picture is not transparent or the
    /// reverse, and when that has more hits than samples. After an error the picture is lost.
    fn band(&mut self, rows: &Framebuffer, n_rows: u32) -> Result<()> {
        self.check(rows, n_rows)?;
        if n_rows == 0 {
            return Ok(());
        }
        let encoded = self.encoder.rows(rows, &mut self.encoded);
        encoded.map_err(Error::io(&self.path))?;
        self.n_rows_done += n_rows;
        self.pass_on()
    }
}

/// Colours of whole numbers, and their alpha where the picture is transparent, as bytes of a file, the high byte
/// first; empty for linear ones.
fn be_bytes(rows: &Framebuffer) -> Cow<'_, [u8]> {
    fn with_alpha<T: Copy>(pixels: &[[T; 3]], alpha: impl Fn(usize) -> T) -> Vec<T> {
        let pixels = pixels.iter().enumerate();
        pixels.flat_map(|(pixel, &[r, g, b])| [r, g, b, alpha(pixel)]).collect()
    }
    let swapped = |numbers: &[u16]| numbers.iter().flat_map(|n| n.to_be_bytes()).collect();
    Cow::Owned(match (&rows.colors, &rows.coverage) {
        (Colors::Srgb8(pixels), None) => return Cow::Borrowed(pixels.as_flattened()),
        (Colors::Srgb8(pixels), Some(coverage)) => {
            with_alpha(pixels, |pixel| coverage.whole_alpha(pixel, u8::MAX.into()) as u8)
        }
        (Colors::Srgb16(pixels), None) => swapped(pixels.as_flattened()),
        (Colors::Srgb16(pixels), Some(coverage)) => {
            swapped(&with_alpha(pixels, |pixel| coverage.whole_alpha(pixel, u16::MAX)))
        }
        (Colors::Linear(_), _) => Vec::new(),
    })
}

/// The colours of a file that holds floats; empty for others.
fn linear(colors: &Colors) -> &[[f32; 3]] {
    match colors {
        Colors::Linear(pixels) => pixels,
        Colors::Srgb8(_) | Colors::Srgb16(_) => &[],
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::rays::View;
    use crate::scene::Camera;

    fn whole(width: u32, height: u32) -> Pixels {
        Pixels::whole(View::new(&Camera::new(DVec3::Z, DVec3::ZERO)), width, height)
    }

    #[test]
    fn impossible_pictures_are_refused_before_anything_is_allocated() {
        let estimate = |format, width, height| {
            writer_bytes(format, PictureOptions::default(), &whole(width, height), 64)
        };
        for format in Format::ALL {
            assert!(estimate(format, 1920, 1080).is_ok_and(|bytes| bytes < 64 << 20));
            assert!(matches!(estimate(format, 0, 5), Err(Error::Usage(_))));
            assert!(
                matches!(estimate(format, u32::MAX, u32::MAX), Err(Error::TooLarge(_))),
                "{format}"
            );
        }
        assert!(matches!(estimate(Format::Png, 1 << 31, 1), Err(Error::TooLarge(_))));
        assert!(estimate(Format::Png, (1 << 31) - 1, 1).is_ok());
        assert!(matches!(estimate(Format::Exr, 1, 1 << 30), Err(Error::TooLarge(_))));
        assert!(matches!(estimate(Format::Exr, 1 << 26, 1), Err(Error::TooLarge(_))));
    }

    #[test]
    fn a_rectangle_outside_its_picture_is_refused() {
        for pixels in [Pixels { x: 5, ..whole(8, 8) }, Pixels { y: u32::MAX, ..whole(8, 8) }] {
            let refused = writer_bytes(Format::Png, PictureOptions::default(), &pixels, 1);
            assert!(matches!(&refused, Err(Error::Usage(why)) if why.text.contains("not inside")));
        }
    }
}
