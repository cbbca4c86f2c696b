//! Opens the files of a scene.

use std::cell::RefCell;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use super::decode::Input;
use super::schema::CloudKeys;
use crate::output::OutputFile;
use crate::support::control::Control;
use crate::support::system;

/// How a scene and the files that it names are read.
#[derive(Clone, Copy)]
pub(super) struct InputReader<'r, 'c> {
    /// Counts the bytes of data, and can stop the reading.
    pub control: &'c Control,
    /// Whether pipes and devices are refused, because opening and reading one may block for any time.
    pub only_regular: bool,
    /// Values of keys that neither the data nor the scene give; without them, a missing one is an error.
    pub usual: Option<&'r CloudKeys>,
    /// A data file that is open already, because its content had to be recognized. The first reader takes it.
    pub opened: Option<(&'r Path, &'r RefCell<Option<Input<'c>>>)>,
}

impl<'r, 'c> InputReader<'r, 'c> {
    /// Creates a reader that reads any file and has no defaults.
    pub fn new(control: &'c Control) -> InputReader<'r, 'c> {
        InputReader { control, only_regular: false, usual: None, opened: None }
    }

    /// Opens a file, decompressed and as UTF-8. The path `-` is standard input.
    pub fn input(self, path: &Path) -> io::Result<Input<'c>> {
        if let Some((at, opened)) = self.opened
            && at == path
            && let Some(input) = opened.take()
        {
            return Ok(input);
        }
        let control = self.control;
        if path.as_os_str() == OutputFile::STDOUT {
            if self.only_regular {
                return Err(not_regular());
            }
            let stream = ProgressReader { file: system::stdin()?, control };
            return Input::new(Box::new(stream), None);
        }
        let file = self.open(path)?;
        let metadata = file.metadata()?;
        let n_bytes = metadata.is_file().then_some(metadata.len());
        Input::new(Box::new(ProgressReader { file, control }), n_bytes)
    }

    fn open(self, path: &Path) -> io::Result<File> {
        if !self.only_regular {
            return File::open(path);
        }
        // A pipe without a writer would block its reader for ever.
        let file = system::open_at_once(path)?;
        if file.metadata()?.is_file() { Ok(file) } else { Err(not_regular()) }
    }
}

/// Opens a file as [`InputReader::input`] does.
///
/// # Errors
/// Returns the errors of opening and reading.
pub(crate) fn open_input<'c>(path: &Path, control: &'c Control) -> io::Result<Input<'c>> {
    InputReader::new(control).input(path)
}

fn not_regular() -> io::Error {
    io::Error::other("it is no longer a regular file, and an open window reads no other")
}

/// A stream that counts the bytes read from it in a [`Control`], and fails once that is cancelled.
struct ProgressReader<'c, R> {
    file: R,
    control: &'c Control,
}

impl<R: Read> Read for ProgressReader<'_, R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        // Not as `ErrorKind::Interrupted`, upon which callers would read again.
        self.control.check().map_err(io::Error::other)?;
        let n = self.file.read(bytes)?;
        self.control.advance_bytes(n as u64);
        Ok(n)
    }
}

#[cfg(test)]
mod tests {
    #[test]
    #[cfg(unix)]
    fn a_pipe_does_not_block_a_reader_of_regular_files() {
        use super::*;

        let folder = tempfile::tempdir().unwrap();
        let [pipe, file] = ["pipe", "file"].map(|name| folder.path().join(name));
        let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
        let kind = rustix::fs::FileType::Fifo;
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, kind, mode, 0).unwrap();
        std::fs::write(&file, "text").unwrap();
        let control = Control::default();
        let any = InputReader::new(&control);
        let regular = InputReader { only_regular: true, ..any };
        for path in [&pipe, &"/dev/zero".into(), &folder.path().into(), &"-".into()] {
            let error = regular.input(path).err().unwrap();
            assert!(error.to_string().contains("regular file"), "{error}");
        }
        for reader in [any, regular] {
            assert_eq!(io::read_to_string(reader.input(&file).unwrap()).unwrap(), "text");
        }
    }
}
