//! The output file that appears whole or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::{Error, Result};

/// A file under construction. [`OutputFile::commit`] puts it in its place; dropped before that, it
/// leaves no trace and the old file as it was.
///
/// It is a temporary file in the folder of its target, renamed at the end. A target that exists
/// and is not a regular file (a pipe, `/dev/null`) is written to directly, as is standard output.
/// A symbolic link stays; the file that it points to is replaced.
///
/// # What is not promised
/// There is no `fsync`: after a power failure the file may be lost. That is the system's usual
/// bargain for files that can be made again, and a render loop would pay for it at each picture.
pub struct OutputFile {
    path: PathBuf,
    place: Place,
}

enum Place {
    /// Renamed to the path at the end.
    Beside(BufWriter<NamedTempFile>, PathBuf),
    /// Goes straight to its target.
    Stream(BufWriter<Box<dyn Write + Send>>),
    /// Collected first, because the target can't seek, and copied to it at the end.
    Spool(BufWriter<File>, Box<dyn Write + Send>),
}

impl OutputFile {
    /// The path that means standard output.
    pub const STDOUT: &str = "-";

    /// Begins a file that will be at `path`; `-` is standard output. With `needs_seek` the file
    /// can be sought even if its target can't.
    ///
    /// # Errors
    /// [`Error::Io`] that names `path`, and says so when its folder does not exist.
    pub fn create(path: impl Into<PathBuf>, needs_seek: bool) -> Result<OutputFile> {
        let path = path.into();
        let place = Place::open(&path, needs_seek).map_err(Error::io(&path))?;
        Ok(OutputFile { path, place })
    }

    /// The path as it was given.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Completes the file: from now on it is at its path.
    ///
    /// # Errors
    /// [`Error::Io`] that names the path; the old file is then as it was.
    pub fn commit(self) -> Result<()> {
        let OutputFile { path, place } = self;
        place.commit().map_err(Error::io(path))
    }
}

impl Place {
    fn open(path: &Path, needs_seek: bool) -> io::Result<Place> {
        if path == Path::new(OutputFile::STDOUT) {
            return Place::direct(Box::new(io::stdout()), needs_seek);
        }
        let mut target = path.to_path_buf();
        match fs::metadata(path) {
            Ok(found) if found.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
            Ok(found) if !found.is_file() => {
                let special = OpenOptions::new().write(true).open(path)?;
                return Place::direct(Box::new(special), needs_seek);
            }
            // A rename would replace a link, not the file that it points to.
            Ok(_) => target = fs::canonicalize(path)?,
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            Err(error) => return Err(error),
        }

        let folder = match target.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        if !folder.is_dir() {
            return Err(io::Error::new(
                io::ErrorKind::NotFound,
                format!("there is no folder {}; make it first", folder.display()),
            ));
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(".kugelblitz-").suffix(".tmp");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt;
            // Temporary files are private by default; this one will be an ordinary file, with
            // the permissions that the user's umask leaves.
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        // The error's text names the temporary file, which says nothing to the user.
        let file = builder.tempfile_in(folder).map_err(|e| io_cause(&e))?;
        Ok(Place::Beside(BufWriter::new(file), target))
    }

    fn direct(target: Box<dyn Write + Send>, needs_seek: bool) -> io::Result<Place> {
        Ok(if needs_seek {
            Place::Spool(BufWriter::new(tempfile::tempfile()?), target)
        } else {
            Place::Stream(BufWriter::new(target))
        })
    }

    fn commit(self) -> io::Result<()> {
        match self {
            Place::Beside(buffered, target) => {
                let file = buffered.into_inner().map_err(io::IntoInnerError::into_error)?;
                file.persist(target).map_err(|error| error.error)?;
                Ok(())
            }
            Place::Stream(mut stream) => stream.flush(),
            Place::Spool(buffered, mut target) => {
                let mut file = buffered.into_inner().map_err(io::IntoInnerError::into_error)?;
                file.rewind()?;
                io::copy(&mut file, &mut target)?;
                target.flush()
            }
        }
    }
}

/// The system's reason without what was wrapped around it.
fn io_cause(error: &io::Error) -> io::Error {
    let mut source = error.get_ref().map(|inner| inner as &(dyn std::error::Error + 'static));
    while let Some(inner) = source {
        if let Some(cause) = inner.downcast_ref::<io::Error>()
            && let Some(code) = cause.raw_os_error()
        {
            return io::Error::from_raw_os_error(code);
        }
        source = inner.source();
    }
    error.kind().into()
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.place {
            Place::Beside(file, _) => file.write(bytes),
            Place::Stream(stream) => stream.write(bytes),
            Place::Spool(file, _) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.place {
            Place::Beside(file, _) => file.flush(),
            Place::Stream(stream) => stream.flush(),
            Place::Spool(file, _) => file.flush(),
        }
    }
}

impl Seek for OutputFile {
    /// Fails on a target that can't seek, unless the file was created with `needs_seek`.
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        match &mut self.place {
            Place::Beside(file, _) => file.seek(position),
            Place::Stream(_) => Err(io::ErrorKind::NotSeekable.into()),
            Place::Spool(file, _) => file.seek(position),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().to_string_lossy().into_owned())
            .collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_appears_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.png");
        fs::write(&path, "old").unwrap();

        let mut dropped = OutputFile::create(&path, false).unwrap();
        dropped.write_all(b"half of the n").unwrap();
        dropped.flush().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        drop(dropped);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["out.png"]);

        let mut whole = OutputFile::create(&path, false).unwrap();
        whole.write_all(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        whole.commit().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["out.png"]);
    }

    #[test]
    fn a_missing_folder_and_a_folder_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("missing").join("out.png");
        let message = OutputFile::create(&path, false).err().unwrap().to_string();
        assert!(message.contains("out.png: there is no folder"), "{message}");
        let error = OutputFile::create(folder.path(), false).err().unwrap();
        assert!(matches!(&error, Error::Io { path, .. } if path == folder.path()), "{error}");
    }

    #[cfg(unix)]
    #[test]
    fn the_file_has_the_permissions_of_any_other() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let mode = |name: &str| {
            let path = folder.path().join(name);
            fs::metadata(path).unwrap().permissions().mode()
        };
        fs::write(folder.path().join("other"), "").unwrap();
        let file = OutputFile::create(folder.path().join("out"), false).unwrap();
        file.commit().unwrap();
        assert_eq!(mode("out"), mode("other"));
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("target");
        let link = folder.path().join("link");
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        let mut file = OutputFile::create(&link, false).unwrap();
        file.write_all(b"new").unwrap();
        file.commit().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&target).unwrap(), b"new");
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn special_files_are_written_to_not_replaced() {
        use std::os::unix::fs::FileTypeExt;
        for needs_seek in [false, true] {
            let mut file = OutputFile::create("/dev/null", needs_seek).unwrap();
            file.write_all(b"gone").unwrap();
            assert_eq!(file.seek(SeekFrom::Start(1)).is_ok(), needs_seek);
            file.commit().unwrap();
            let kind = fs::metadata("/dev/null").unwrap().file_type();
            assert!(kind.is_char_device());

            let mut full = OutputFile::create("/dev/full", needs_seek).unwrap();
            full.write_all(b"no room").unwrap();
            let message = full.commit().err().unwrap().to_string();
            assert!(message.starts_with("/dev/full: "), "{message}");
        }
    }
}
