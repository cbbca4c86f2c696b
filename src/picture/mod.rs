//! Colours and [`Hits`] → picture file: [`PictureWriter`] takes bands of rows from top to bottom
//! and writes PNG, EXR, PPM or NPY into an [`OutputFile`] or any other sink. Memory is bounded by a
//! band, not by the picture.
//!
//! # What is not promised
//! Bytes of a file may change from one version to the next; decoded values do not.

mod exr;
mod npy;
mod png;
mod ppm;

use std::borrow::Cow;
use std::fmt;
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::camera::Pixels;
use crate::error::{Error, Result};
use crate::output::OutputFile;
use crate::shade::{Colors, Encoding};
use crate::trace::{Hits, Wants};

/// What every file says about its maker.
const SOFTWARE: &str = concat!("kugelblitz ", env!("CARGO_PKG_VERSION"));

/// The largest file offset that operating systems can name, bytes.
const MAX_FILE_BYTES: u64 = i64::MAX as u64;

/// A picture file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// Portable Network Graphics: sRGB, 8 or 16 bits a channel.
    Png,
    /// OpenEXR: linear colour, depth, id, normal, all in full precision.
    Exr,
    /// Portable pixmap (P6): sRGB, 8 or 16 bits a channel.
    Ppm,
    /// A structured NumPy array with linear colour, depth, id and normal.
    Npy,
}

impl Format {
    /// All formats, in the order that messages name them.
    pub const ALL: [Format; 4] = [Format::Png, Format::Exr, Format::Ppm, Format::Npy];

    /// The name on the command line, which is also the file ending.
    pub fn name(self) -> &'static str {
        match self {
            Format::Png => "png",
            Format::Exr => "exr",
            Format::Ppm => "ppm",
            Format::Npy => "npy",
        }
    }

    /// The format that a file name's ending asks for, in upper or lower case.
    ///
    /// # Errors
    /// [`Error::Usage`] for another ending, for none, and for `-` (standard output).
    pub fn from_path(path: &Path) -> Result<Format> {
        if path == Path::new(OutputFile::STDOUT) {
            return Err(Error::Usage(format!(
                "standard output has no ending that tells the format; add --format {}",
                names("|", "|", "")
            )));
        }
        let Some(ending) = path.extension() else {
            return Err(Error::Usage(format!(
                "{}: the name has no ending that tells the format; use {}",
                path.display(),
                names(", ", " or ", ".")
            )));
        };
        let ending = ending.to_string_lossy();
        find(&ending).ok_or_else(|| {
            Error::Usage(format!(
                "{}: no picture format has the ending .{ending}; use {}{}",
                path.display(),
                names(", ", " or ", "."),
                suggestion(&ending, "."),
            ))
        })
    }

    /// What the tracer must compute for this format. `certificates` adds the level where the
    /// format has a place for it (EXR and NPY).
    pub fn wants(self, certificates: bool) -> Wants {
        let surface = match self {
            Format::Png | Format::Ppm => false,
            Format::Exr | Format::Npy => true,
        };
        Wants { surface, level: surface && certificates }
    }

    /// How its colours are encoded.
    pub fn encoding(self, bits: Bits) -> Encoding {
        match (self, bits) {
            (Format::Png | Format::Ppm, Bits::Eight) => Encoding::Srgb8,
            (Format::Png | Format::Ppm, Bits::Sixteen) => Encoding::Srgb16,
            (Format::Exr | Format::Npy, _) => Encoding::Linear,
        }
    }

    /// Whether the writer goes back in the file at the end, so that a pipe can't take it
    /// directly; [`OutputFile::create`] wants to know.
    pub fn needs_seek(self) -> bool {
        self == Format::Exr
    }
}

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Format {
    type Err = Error;

    fn from_str(name: &str) -> Result<Format> {
        find(name).ok_or_else(|| {
            Error::Usage(format!(
                "no picture format is called “{name}”; use {}{}",
                names(", ", " or ", ""),
                suggestion(name, ""),
            ))
        })
    }
}

fn find(name: &str) -> Option<Format> {
    Format::ALL.into_iter().find(|format| format.name().eq_ignore_ascii_case(name))
}

/// `png, exr, ppm or npy` with the given separators and prefix.
fn names(separator: &str, last_separator: &str, prefix: &str) -> String {
    let mut text = String::new();
    for (i, format) in Format::ALL.into_iter().enumerate() {
        if i > 0 {
            let is_last = i + 1 == Format::ALL.len();
            text += if is_last { last_separator } else { separator };
        }
        text += prefix;
        text += format.name();
    }
    text
}

/// `; did you mean png?`, or nothing when no name is within one typing slip.
fn suggestion(name: &str, prefix: &str) -> String {
    Format::ALL
        .into_iter()
        .find(|format| strsim::osa_distance(&name.to_ascii_lowercase(), format.name()) == 1)
        .map_or_else(String::new, |format| format!("; did you mean {prefix}{format}?"))
}

/// Bits a colour channel in PNG and PPM; EXR and NPY always hold f32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Bits {
    /// 8 bits: `#rrggbb` comes out as the scene file names it.
    #[default]
    Eight,
    /// 16 bits, big endian.
    Sixteen,
}

/// How a picture is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PictureOptions {
    /// Bits a channel in PNG and PPM.
    pub bits: Bits,
    /// Whether EXR and NPY get the level that decided each pixel.
    pub certificates: bool,
}

/// The rectangle that is written and the picture that it belongs to, all in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Width of the whole picture.
    pub image_width: u32,
    /// Height of the whole picture.
    pub image_height: u32,
    /// Left column of the rectangle.
    pub x: u32,
    /// Top row of the rectangle.
    pub y: u32,
    /// Columns of the rectangle, which is the width of the file.
    pub width: u32,
    /// Rows of the rectangle, which is the height of the file.
    pub height: u32,
}

impl Frame {
    /// A picture that is written whole.
    pub fn whole(width: u32, height: u32) -> Frame {
        Frame { image_width: width, image_height: height, x: 0, y: 0, width, height }
    }
}

impl From<&Pixels> for Frame {
    fn from(pixels: &Pixels) -> Frame {
        Frame {
            image_width: pixels.image_width,
            image_height: pixels.image_height,
            x: pixels.x,
            y: pixels.y,
            width: pixels.width,
            height: pixels.height,
        }
    }
}

/// Bytes that a [`PictureWriter`] holds at most, beside the colours and [`Hits`] it is given, for
/// bands of `n_band_rows` rows.
///
/// # Errors
/// [`Error::Usage`] for an empty rectangle or one outside its picture, [`Error::TooLarge`] for a
/// picture that the format can't hold.
pub fn writer_bytes(
    format: Format,
    options: PictureOptions,
    frame: Frame,
    n_band_rows: u32,
) -> Result<u64> {
    let Frame { image_width, image_height, x, y, width, height } = frame;
    if width == 0 || height == 0 {
        return Err(Error::Usage(format!(
            "a picture of {width}x{height} pixels is empty; give it at least one column and row"
        )));
    }
    let fits = |start: u32, length: u32, whole: u32| {
        start.checked_add(length).is_some_and(|end| end <= whole)
    };
    if !fits(x, width, image_width) || !fits(y, height, image_height) {
        return Err(Error::Usage(format!(
            "the rectangle {x},{y},{width},{height} is not inside the picture of \
             {image_width}x{image_height} pixels"
        )));
    }

    let n_band_rows = n_band_rows.min(height);
    let (pixel_bytes, band_bytes) = match format {
        Format::Png => {
            png::check_size(frame)?;
            let pixel_bytes = png::pixel_bytes(options.bits);
            (pixel_bytes, png::band_bytes(options.bits, width, n_band_rows))
        }
        Format::Ppm => {
            let pixel_bytes = png::pixel_bytes(options.bits);
            let band_px = u128::from(width) * u128::from(n_band_rows);
            // For 16 bits, once more with the bytes swapped.
            (pixel_bytes, 2 * band_px * pixel_bytes)
        }
        Format::Npy => {
            let pixel_bytes = npy::pixel_bytes(options.certificates);
            let band_px = u128::from(width) * u128::from(n_band_rows);
            (pixel_bytes, band_px * pixel_bytes)
        }
        Format::Exr => {
            exr::check_size(frame, options.certificates)?;
            let pixel_bytes = exr::pixel_bytes(options.certificates);
            (pixel_bytes, exr::band_bytes(frame, options.certificates, n_band_rows))
        }
    };
    let file_bytes = u128::from(width) * u128::from(height) * pixel_bytes;
    if file_bytes > u128::from(MAX_FILE_BYTES) {
        return Err(Error::TooLarge(format!(
            "a picture of {width}x{height} pixels has {file_bytes} bytes, more than a file can \
             have ({MAX_FILE_BYTES}); render parts of it with --crop"
        )));
    }
    // What doesn't fit u64 doesn't fit any memory either, and the caller compares with that.
    Ok(u64::try_from(band_bytes).unwrap_or(u64::MAX))
}

/// Writes one picture, band by band, from top to bottom.
///
/// ```
/// # use kugelblitz::{picture::*, shade::Colors, trace::Hits};
/// # fn main() -> kugelblitz::Result<()> {
/// let sink = std::io::Cursor::new(Vec::new());
/// let mut writer = PictureWriter::create(
///     Format::Ppm,
///     PictureOptions::default(),
///     Frame::whole(2, 1),
///     sink,
///     "memory",
/// )?;
/// let hits = Hits { id: vec![0, 1], ..Hits::default() };
/// writer.rows(&Colors::Srgb8(vec![[0; 3], [255, 0, 0]]), &hits, 1)?;
/// let bytes = writer.finish()?.into_inner();
/// assert_eq!(bytes, b"P6\n2 1\n255\n\0\0\0\xff\0\0");
/// # Ok(())
/// # }
/// ```
///
/// The encoders do no input or output of their own: they append to a buffer, which goes to the
/// sink after each band. So a full disk is met in one place, whatever a codec does with errors.
pub struct PictureWriter<W> {
    encoder: Encoder,
    frame: Frame,
    wants: Wants,
    encoding: Encoding,
    n_rows_done: u32,
    /// Encoded bytes on their way to the sink.
    encoded: Vec<u8>,
    sink: W,
    path: PathBuf,
}

enum Encoder {
    Png(Box<png::Png>),
    Ppm,
    Npy(npy::Npy),
    Exr(Box<exr::Exr>),
}

impl<W: Write + Seek> PictureWriter<W> {
    /// Begins a picture: writes its header to `sink`, which stands at the beginning of its file
    /// and which errors call `path`.
    ///
    /// # Errors
    /// Those of [`writer_bytes`], and [`Error::Io`] from the sink.
    pub fn create(
        format: Format,
        options: PictureOptions,
        frame: Frame,
        sink: W,
        path: impl Into<PathBuf>,
    ) -> Result<PictureWriter<W>> {
        writer_bytes(format, options, frame, 1)?;
        let path = path.into();
        let mut encoded = Vec::new();
        let encoder = match format {
            Format::Png => png::Png::begin(options.bits, frame, &mut encoded)
                .map(|png| Encoder::Png(Box::new(png))),
            Format::Ppm => {
                ppm::begin(options.bits, frame, &mut encoded);
                Ok(Encoder::Ppm)
            }
            Format::Npy => {
                npy::Npy::begin(options.certificates, frame, &mut encoded).map(Encoder::Npy)
            }
            Format::Exr => exr::Exr::begin(options.certificates, frame, &mut encoded)
                .map(|exr| Encoder::Exr(Box::new(exr))),
        }
        .map_err(Error::io(&path))?;
        let mut writer = PictureWriter {
            encoder,
            frame,
            wants: format.wants(options.certificates),
            encoding: format.encoding(options.bits),
            n_rows_done: 0,
            encoded,
            sink,
            path,
        };
        writer.pass_on()?;
        Ok(writer)
    }

    /// Writes the next `n_rows` rows: `colors` and `hits` have one entry a pixel, row by row.
    ///
    /// # Errors
    /// [`Error::Io`] from the sink. [`Error::Usage`] when `colors` has not `n_rows` rows in the
    /// format's [`Encoding`], when `hits` has not as many with the fields that [`Format::wants`],
    /// or when the rows are more than the picture has. After an error the picture is lost.
    pub fn rows(&mut self, colors: &Colors, hits: &Hits, n_rows: u32) -> Result<()> {
        self.check(colors, hits, n_rows)?;
        if n_rows == 0 {
            return Ok(());
        }
        let encoded = &mut self.encoded;
        match &mut self.encoder {
            Encoder::Png(png) => png.rows(colors, encoded),
            Encoder::Ppm => {
                ppm::rows(colors, encoded);
                Ok(())
            }
            Encoder::Npy(npy) => {
                npy.rows(hits, linear(colors), encoded);
                Ok(())
            }
            Encoder::Exr(exr) => exr.rows(hits, linear(colors), encoded),
        }
        .map_err(Error::io(&self.path))?;
        self.n_rows_done += n_rows;
        self.pass_on()
    }

    /// Ends the picture and gives the sink back, flushed.
    ///
    /// # Errors
    /// [`Error::Io`] from the sink, [`Error::Usage`] when rows are missing.
    pub fn finish(mut self) -> Result<W> {
        if self.n_rows_done != self.frame.height {
            return Err(Error::Usage(format!(
                "{}: the picture has {} rows, but only {} were written",
                self.path.display(),
                self.frame.height,
                self.n_rows_done
            )));
        }
        match self.encoder {
            Encoder::Png(png) => {
                png.finish(&mut self.encoded).and_then(|()| self.sink.write_all(&self.encoded))
            }
            Encoder::Ppm | Encoder::Npy(_) => Ok(()),
            Encoder::Exr(exr) => {
                let (position_bytes, table) = exr.finish();
                self.sink
                    .seek(SeekFrom::Start(position_bytes))
                    .and_then(|_| self.sink.write_all(&table))
                    .and_then(|()| self.sink.seek(SeekFrom::End(0)).map(drop))
            }
        }
        .and_then(|()| self.sink.flush())
        .map_err(Error::io(&self.path))?;
        Ok(self.sink)
    }

    fn check(&self, colors: &Colors, hits: &Hits, n_rows: u32) -> Result<()> {
        let n_rows_left = self.frame.height - self.n_rows_done;
        if n_rows > n_rows_left {
            return Err(Error::Usage(format!(
                "{}: {n_rows} rows were given, but the picture has only {n_rows_left} left",
                self.path.display()
            )));
        }
        let n_pixels = self.frame.width as usize * n_rows as usize;
        if colors.encoding() != self.encoding {
            return Err(Error::Usage(format!(
                "{}: the picture takes {:?}, but colours in {:?} were given",
                self.path.display(),
                self.encoding,
                colors.encoding()
            )));
        }
        for (field, length, is_wanted) in [
            ("colour", colors.len(), true),
            ("id", hits.id.len(), true),
            ("t", hits.t.len(), self.wants.surface),
            ("normal", hits.normal.len(), self.wants.surface),
            ("level", hits.level.len(), self.wants.level),
        ] {
            if is_wanted && length != n_pixels {
                return Err(Error::Usage(format!(
                    "{}: {n_rows} rows have {n_pixels} pixels, but {length} entries of “{field}” \
                     were given",
                    self.path.display()
                )));
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

/// Colours of whole numbers as bytes of a file, the high byte first; empty for linear ones.
fn be_bytes(colors: &Colors) -> Cow<'_, [u8]> {
    match colors {
        Colors::Srgb8(pixels) => Cow::Borrowed(pixels.as_flattened()),
        Colors::Srgb16(pixels) => {
            let channels = pixels.as_flattened().iter();
            Cow::Owned(channels.flat_map(|channel| channel.to_be_bytes()).collect())
        }
        Colors::Linear(_) => Cow::Borrowed(&[]),
    }
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
    use super::*;

    fn usage(result: Result<impl fmt::Debug>) -> String {
        match result {
            Err(Error::Usage(message)) => message,
            other => panic!("expected wrong usage, got {other:?}"),
        }
    }

    #[test]
    fn endings_name_formats() {
        for (path, format) in [
            ("a.png", Format::Png),
            ("dir.exr/b.PNG", Format::Png),
            ("x.exr", Format::Exr),
            ("x.y.ppm", Format::Ppm),
            ("x.Npy", Format::Npy),
        ] {
            assert_eq!(Format::from_path(Path::new(path)).unwrap(), format, "{path}");
        }
    }

    #[test]
    fn unknown_endings_are_told_what_exists() {
        let message = usage(Format::from_path(Path::new("out.pgn")));
        assert!(message.contains(".png, .exr, .ppm or .npy"), "{message}");
        assert!(message.contains("did you mean .png?"), "{message}");
        let message = usage(Format::from_path(Path::new("out.jpeg")));
        assert!(!message.contains("did you mean"), "{message}");
        assert!(usage(Format::from_path(Path::new("out"))).contains("no ending"));
        assert!(usage(Format::from_path(Path::new("-"))).contains("--format png|exr|ppm|npy"));
        assert!(usage("expr".parse::<Format>()).contains("did you mean exr?"));
        assert_eq!("EXR".parse::<Format>().unwrap(), Format::Exr);
    }

    #[test]
    fn impossible_pictures_are_refused_before_anything_is_allocated() {
        let estimate = |format, width, height| {
            let frame = Frame::whole(width, height);
            writer_bytes(format, PictureOptions::default(), frame, 64)
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
        let frame = Frame { x: 5, ..Frame::whole(8, 8) };
        let result = writer_bytes(Format::Png, PictureOptions::default(), frame, 1);
        assert!(usage(result).contains("not inside"));
        let frame = Frame { y: u32::MAX, ..Frame::whole(8, 8) };
        assert!(writer_bytes(Format::Png, PictureOptions::default(), frame, 1).is_err());
    }
}
