//! Opening the files of a scene.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use crate::system;

/// Which files are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Files {
    /// Pipes and devices as well: opening and reading one may wait for as long as it likes.
    All,
    /// Only those whose opening and reading wait for nobody.
    Regular,
}

impl Files {
    pub fn open(self, path: &Path) -> io::Result<File> {
        if self == Files::All {
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

    /// The first `n_most` bytes of a file.
    pub fn read(self, path: &Path, n_most: u64) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        self.open(path)?.take(n_most).read_to_end(&mut bytes)?;
        Ok(bytes)
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_pipe_keeps_nobody_who_wants_regular_files() {
        let folder = tempfile::tempdir().unwrap();
        let [pipe, file] = ["pipe", "file"].map(|name| folder.path().join(name));
        let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
        let kind = rustix::fs::FileType::Fifo;
        rustix::fs::mknodat(rustix::fs::CWD, &pipe, kind, mode, 0).unwrap();
        std::fs::write(&file, "text").unwrap();
        for path in [&pipe, &"/dev/zero".into(), &folder.path().into()] {
            let error = Files::Regular.read(path, 9).unwrap_err();
            assert!(error.to_string().contains("regular file"), "{error}");
        }
        assert_eq!(Files::Regular.read(&file, 9).unwrap(), b"text");
        assert_eq!(Files::All.read(&file, 3).unwrap(), b"tex");
    }
}
