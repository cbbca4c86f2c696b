//! Whole files of others, read within one limit.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::error::{Error, Result};
use crate::plain::Shown;
use crate::support::memory;

/// Maximum number of bytes of an input that is read as a whole: a text, such as a scene or a list of digests, and an input of unknown
/// length, such as a pipe. A binary file of known length may be as large as the memory.
pub const MAX_BYTES: u64 = 64 << 20;

/// Longest line of a text that is read line by line, bytes.
pub const MAX_LINE_BYTES: u64 = 1 << 20;

/// A text. `what` it is and the next step where it is too large, for messages: "a scene", "give less".
///
/// # Errors
/// [`Error::Io`]; [`Error::TooLarge`] beyond [`MAX_BYTES`] or the memory; [`Error::Input`] where it is not
/// UTF-8.
pub fn read_text(path: &Path, what: &str, advice: &str) -> Result<String> {
    let bytes = read(path, |_| MAX_BYTES, what, advice)?;
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..valid].iter().filter(|&&byte| byte == b'\n').count();
        let message = format!("line {line}: not UTF-8 text; save it as UTF-8");
        Error::Input { path: path.to_owned(), message }
    })
}

/// The bytes of a file that is no text; the arguments as [`read_text`] has them.
///
/// # Errors
/// [`Error::Io`]; [`Error::TooLarge`] beyond the memory, and beyond [`MAX_BYTES`] where it tells no length.
pub fn read_bytes(path: &Path, what: &str, advice: &str) -> Result<Vec<u8>> {
    read(path, |n_bytes| n_bytes.max(MAX_BYTES), what, advice)
}

fn read(path: &Path, most: impl Fn(u64) -> u64, what: &str, advice: &str) -> Result<Vec<u8>> {
    let file = File::open(path).map_err(Error::io(path))?;
    let metadata = file.metadata().map_err(Error::io(path))?;
    if metadata.is_dir() {
        return Err(Error::io(path)(io::ErrorKind::IsADirectory.into()));
    }
    let n_told = if metadata.is_file() { metadata.len() } else { 0 };
    let most = most(n_told);
    let name = path.shown();
    let too_large = |found: String| {
        let most = most >> 20;
        Error::TooLarge(
            format!("{name}: {found}, but at most {most} MiB of {what} are read; {advice}").into(),
        )
    };
    if n_told > most {
        return Err(too_large(format!("it has {} MiB", n_told.div_ceil(1 << 20))));
    }
    memory::require(format!("{name}: reading it"), n_told, advice)?;
    let mut bytes = Vec::new();
    let read = bytes.try_reserve_exact(n_told as usize).map_err(io::Error::from);
    match read.and_then(|()| file.take(most + 1).read_to_end(&mut bytes)) {
        Ok(_) if bytes.len() as u64 > most => Err(too_large("it goes on".into())),
        Ok(_) => Ok(bytes),
        Err(error) if error.kind() == io::ErrorKind::OutOfMemory => {
            Err(Error::TooLarge(format!("{name}: it does not fit the memory; {advice}").into()))
        }
        Err(error) => Err(Error::io(path)(error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_larger_is_refused_by_its_length() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large");
        let file = File::create(&path).unwrap();
        file.set_len(MAX_BYTES).unwrap();
        assert_eq!(read_text(&path, "a text", "give less").unwrap().len() as u64, MAX_BYTES);
        file.set_len(MAX_BYTES + 1).unwrap();
        let error = read_text(&path, "a text", "give less").unwrap_err();
        assert_eq!(error.exit_code(), 7);
        let said = "large: it has 65 MiB, but at most 64 MiB of a text are read; give less";
        assert!(error.to_string().ends_with(said), "{error}");
        assert_eq!(read_bytes(&path, "a", "b").unwrap().len() as u64, MAX_BYTES + 1);
        std::fs::write(&path, b"a\nb\xff").unwrap();
        let error = read_text(&path, "a text", "give less").unwrap_err().to_string();
        assert!(error.contains("line 2: not UTF-8"), "{error}");
    }
}
