//! How the files of a scene are opened.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use super::schema::CloudKeys;
use crate::control::Control;
use crate::system;

/// How a scene and the files that it names are read.
#[derive(Clone, Copy)]
pub(super) struct Reader<'r> {
    /// Counts the bytes of clouds, and can stop the reading.
    pub control: &'r Control,
    /// True where pipes and devices are refused: opening and reading one may wait for as long as it likes.
    pub only_regular: bool,
    /// What is chosen for a cloud where neither its file nor the scene says it; without, that is an error.
    pub usual: Option<&'r CloudKeys>,
}

impl<'r> Reader<'r> {
    /// Reads any file, and chooses nothing.
    pub fn new(control: &'r Control) -> Reader<'r> {
        Reader { control, only_regular: false, usual: None }
    }

    pub fn open(self, path: &Path) -> io::Result<File> {
        if !self.only_regular {
            return File::open(path);
        }
        // Else a pipe that nobody writes to would keep its reader here.
        let file = system::open_at_once(path)?;
        if file.metadata()?.is_file() {
            Ok(file)
        } else {
            Err(io::Error::other(
                "it is no regular file any more, and an open window waits for no other",
            ))
        }
    }
}

/// A file that counts what is read from it into a [`Control`], and fails once that is cancelled.
pub(crate) struct Watched<'c> {
    pub file: File,
    pub control: &'c Control,
}

impl Watched<'_> {
    /// Bytes of the file, where it tells them.
    pub fn n_bytes(&self) -> io::Result<Option<u64>> {
        let metadata = self.file.metadata()?;
        Ok(metadata.is_file().then_some(metadata.len()))
    }
}

impl Read for Watched<'_> {
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
    fn a_pipe_keeps_nobody_who_wants_regular_files() {
        use super::*;

        let folder = tempfile::tempdir().unwrap();
        let [pipe, file] = ["pipe", "file"].map(|name| folder.path().join(name));
        let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
        let kind = rustix::fs::FileType::Fifo;
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, kind, mode, 0).unwrap();
        std::fs::write(&file, "text").unwrap();
        let control = Control::default();
        let any = Reader::new(&control);
        let regular = Reader { only_regular: true, ..any };
        for path in [&pipe, &"/dev/zero".into(), &folder.path().into()] {
            let error = regular.open(path).unwrap_err();
            assert!(error.to_string().contains("regular file"), "{error}");
        }
        for reader in [any, regular] {
            assert_eq!(io::read_to_string(reader.open(&file).unwrap()).unwrap(), "text");
        }
    }
}
