//! The picture formats and their names.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use crate::error::{Error, Hint, Message, Result, Setting, wrong_usage};
use crate::lighting::Encoding;
use crate::output::OutputFile;
use crate::plain::Shown;
use crate::query::Outputs;
use crate::words::did_you_mean;

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
            let formats = Format::ALL.map(Format::name).join("|");
            let hint = Hint::new("give it with {}: ", [Setting::named("format")]).then(formats);
            let text = "standard output has no ending that gives the format";
            return wrong_usage(Message::new(text, hint));
        }
        let Some(ending) = path.extension() else {
            return wrong_usage(format!(
                "{}: the name has no ending that tells the format; use {}",
                path.shown(),
                names(".")
            ));
        };
        let ending = ending.to_string_lossy();
        let wrong = || format!("{}: no picture format has the ending .{ending}", path.shown());
        find(&ending, ".", wrong)
    }

    /// True where a file holds what was found, in floats; else it holds colours alone, for the eye.
    pub fn holds_numbers(self) -> bool {
        matches!(self, Format::Exr | Format::Npy)
    }

    /// The part of [`Hits`](crate::query::Hits) that this format writes. `certificates` adds the
    /// level where the format has a place for it (EXR and NPY).
    pub fn wants(self, certificates: bool) -> Outputs {
        let surface = self.holds_numbers();
        Outputs { surface, level: surface && certificates }
    }

    /// How its colours are encoded.
    pub fn encoding(self, bits: ChannelBits) -> Encoding {
        match bits {
            _ if self.holds_numbers() => Encoding::Linear,
            ChannelBits::Eight => Encoding::Srgb8,
            ChannelBits::Sixteen => Encoding::Srgb16,
        }
    }

    /// True where a file says how it was made.
    pub fn has_metadata(self) -> bool {
        matches!(self, Format::Png | Format::Exr)
    }

    /// True where the writer goes back in the file at the end, so that a pipe can't take it
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
        find(name, "", || format!("no picture format is called “{name}”"))
    }
}

/// The format of this name; `wrong` is what is said where there is none, and names have `prefix` before them.
fn find(name: &str, prefix: &str, wrong: impl FnOnce() -> String) -> Result<Format> {
    let found = Format::ALL.into_iter().find(|format| format.name().eq_ignore_ascii_case(name));
    found.ok_or_else(|| {
        let near = did_you_mean(Format::ALL.map(Format::name), name);
        let hint = near.map_or(String::new(), |format| format!("; did you mean {prefix}{format}?"));
        Error::Usage(format!("{}; use {}{hint}", wrong(), names(prefix)).into())
    })
}

/// `png, exr, ppm or npy`, each behind a prefix.
fn names(prefix: &str) -> String {
    let [first @ .., last] = Format::ALL.map(|format| format!("{prefix}{format}"));
    format!("{} or {last}", first.join(", "))
}

/// Bits a colour channel in PNG and PPM; EXR and NPY always hold f32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ChannelBits {
    /// 8 bits: `#rrggbb` comes out as the scene file names it.
    #[default]
    Eight,
    /// 16 bits, big endian.
    Sixteen,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn usage(result: Result<impl fmt::Debug>) -> String {
        match result {
            Err(Error::Usage(message)) => message.worded(Setting::to_string),
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
        assert!(usage(Format::from_path(Path::new("-"))).contains("`format`: png|exr|ppm|npy"));
        assert!(usage("expr".parse::<Format>()).contains("did you mean exr?"));
        assert_eq!("EXR".parse::<Format>().unwrap(), Format::Exr);
    }
}
