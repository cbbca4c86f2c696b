//! Output files that appear whole or not at all, and last of all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::TempPath;

use crate::error::{Error, Result, wrong_usage};
use crate::plain::Shown;
use crate::support::control::Control;
use crate::support::system;

/// A file under construction. [`commit`] puts it in its place; dropped before that, it leaves no
/// trace and the old file as it was.
///
/// It is written under a hidden name in the folder of its target, and renamed at the end. A target
/// that exists and is not a regular file (a pipe, `/dev/null`) is written to directly, as is standard
/// output. Symbolic links stay, also those that lead to no file yet: it is made where they lead. The
/// permissions of the old file stay; a new one has those that the umask leaves.
///
/// # What is not promised
/// There is no `fsync`: after a power failure the file may be lost. That is the system's usual
/// bargain for files that can be made again, and a render loop would pay for it at each picture.
/// Other hard links to the old file keep the old content. A killed process leaves its hidden files.
pub struct OutputFile {
    path: PathBuf,
    place: Place,
}

/// Rows that are written at a time; keeps the memory small.
const ROWS_AT_ONCE: usize = 1 << 14;

enum Place {
    /// In the folder of its target, where it is renamed to at the end.
    Beside { file: BufWriter<File>, name: TempPath, target: PathBuf },
    /// Goes straight to its target.
    Stream(BufWriter<Box<dyn Write + Send>>),
    /// Collected first, because the target can't seek, and copied to it at the end.
    Spool(BufWriter<File>, Box<dyn Write + Send>),
}

impl OutputFile {
    /// The path that means standard output.
    pub const STDOUT: &str = "-";
    /// Standard output as errors call it.
    pub const STDOUT_IN_WORDS: &str = "standard output";

    /// Begins a file that will be at `path`; `-` is standard output. With `needs_seek` the file
    /// can be sought even if its target can't. A pipe that nobody reads is waited for.
    ///
    /// # Errors
    /// [`Error::Io`] that names `path`, and says so when its folder does not exist.
    pub fn create(path: impl Into<PathBuf>, needs_seek: bool) -> Result<OutputFile> {
        let path = path.into();
        let place = Place::open(&path, needs_seek).map_err(Error::io(&path))?;
        let path = if path == Path::new(OutputFile::STDOUT) {
            OutputFile::STDOUT_IN_WORDS.into()
        } else {
            path
        };
        Ok(OutputFile { path, place })
    }

    /// Writes all that the file is to hold; it is then whole, but not in its place.
    ///
    /// # Errors
    /// [`Error::Io`]
    pub fn filled(mut self, bytes: &[u8]) -> Result<OutputFile> {
        self.write_all(bytes).map_err(Error::io(&self.path))?;
        Ok(self)
    }

    /// Writes a header and then rows, of which `append` puts some behind the bytes that it is given. `control`
    /// counts the bytes.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Interrupted`].
    pub(crate) fn write_rows(
        &mut self,
        header: Vec<u8>,
        n_rows: usize,
        row_bytes: usize,
        mut append: impl FnMut(Range<usize>, &mut Vec<u8>),
        control: &Control,
    ) -> Result<()> {
        control.expect_bytes(header.len() as u64 + n_rows as u64 * row_bytes as u64);
        let (mut bytes, mut n_done) = (header, 0);
        loop {
            control.check()?;
            self.write_all(&bytes).map_err(Error::io(&self.path))?;
            control.advance_bytes(bytes.len() as u64);
            if n_done == n_rows {
                return Ok(());
            }
            bytes.clear();
            let end = n_rows.min(n_done + ROWS_AT_ONCE);
            append(n_done..end, &mut bytes);
            n_done = end;
        }
    }

    /// The path as it was given, but for standard output, which has its name: for errors.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Completes the outputs of one piece of work: from now on they are at their paths, in this order, so
/// that data come before the scene that names them. What can fail or take long comes first, for all of
/// them, then [`Control::commit`], then the renaming.
///
/// # Errors
/// [`Error::Interrupted`] when `control` was cancelled, and [`Error::Io`] that names the path. All old
/// files are then as they were, unless the error says which ones are not.
pub fn commit(files: impl IntoIterator<Item = OutputFile>, control: &Control) -> Result<()> {
    let mut written = Vec::new();
    for OutputFile { path, place } in files {
        if let Some((name, target)) = place.end().map_err(Error::io(&path))? {
            written.push((path, name, target));
        }
    }
    control.commit()?;
    let mut changed: Vec<String> = Vec::new();
    for (path, name, target) in written {
        let hidden = name.to_path_buf();
        name.persist(target).map_err(|failed| {
            Error::io(&path)(match &changed[..] {
                [] => failed.error,
                changed => {
                    let changed = changed.join(", ");
                    io::Error::other(format!("{}; {changed} changed already", failed.error))
                }
            })
        })?;
        unfinished().retain(|path| *path != hidden);
        changed.push(path.shown());
    }
    Ok(())
}

impl Place {
    fn open(path: &Path, needs_seek: bool) -> io::Result<Place> {
        if path == Path::new(OutputFile::STDOUT) {
            return Place::direct(Box::new(io::stdout()), needs_seek);
        }
        let old = match fs::metadata(path) {
            Ok(found) if found.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
            Ok(found) if !found.is_file() => {
                let special = OpenOptions::new().write(true).open(path)?;
                return Place::direct(Box::new(special), needs_seek);
            }
            Ok(found) => Some(found),
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            Err(error) => return Err(error),
        };
        // A rename would replace a link, not the file that it leads to.
        let target = end_of_links(path);
        let folder = folder_of(&target);
        if !folder.is_dir() {
            return Err(io::Error::new(
                io::ErrorKind::NotFound,
                format!("there is no folder {}; make it first", folder.shown()),
            ));
        }
        let mut builder = tempfile::Builder::new();
        builder.prefix(PREFIX).suffix(".tmp");
        system::like_ordinary_files(&mut builder);
        let (file, name) = builder.tempfile_in(folder).map_err(|e| io_cause(&e))?.into_parts();
        unfinished().push(name.to_path_buf());
        if let Some(old) = old {
            system::keep_permissions(&file, &old)?;
        }
        Ok(Place::Beside { file: BufWriter::new(file), name, target })
    }

    fn direct(target: Box<dyn Write + Send>, needs_seek: bool) -> io::Result<Place> {
        Ok(if needs_seek {
            let file = tempfile::tempfile().map_err(|error| {
                io::Error::other(format!(
                    "the picture must be collected before it is passed on, but there can be no \
                     temporary file in {}: {}; set TMPDIR to a folder that can be written to",
                    std::env::temp_dir().shown(),
                    io_cause(&error)
                ))
            })?;
            Place::Spool(BufWriter::new(file), target)
        } else {
            Place::Stream(BufWriter::new(target))
        })
    }

    fn sink(&mut self) -> &mut dyn Write {
        match self {
            Place::Beside { file, .. } | Place::Spool(file, _) => file,
            Place::Stream(stream) => stream,
        }
    }

    /// Writes out what is left. The name of a file that is then to be renamed is returned, and what to.
    fn end(self) -> io::Result<Option<(TempPath, PathBuf)>> {
        match self {
            Place::Beside { mut file, name, target } => {
                file.flush()?;
                Ok(Some((name, target)))
            }
            Place::Stream(mut stream) => stream.flush().map(|()| None),
            Place::Spool(buffered, mut target) => {
                let mut file = buffered.into_inner().map_err(io::IntoInnerError::into_error)?;
                file.rewind()?;
                io::copy(&mut file, &mut target)?;
                target.flush().map(|()| None)
            }
        }
    }
}

/// The folder of a file that may not be there yet.
pub(crate) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// Where the links at `path` lead, be there a file or not. [`fs::metadata`] has found that they don't
/// go round in a circle.
fn end_of_links(path: &Path) -> PathBuf {
    let mut target = path.to_path_buf();
    while let Ok(next) = fs::read_link(&target) {
        target = folder_of(&target).join(next);
    }
    target
}

const PREFIX: &str = ".kugelblitz-";

/// Hidden names of files that are not in their places, for [`remove_unfinished`].
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes what this process has begun under hidden names. For a program that ends at once, without
/// dropping anything; what is not committed then never will be.
pub fn remove_unfinished() {
    for path in unfinished().drain(..) {
        let _ = fs::remove_file(path);
    }
}

/// Refuses an output that would replace an input, or another output, by whatever path or symbolic link. Other
/// hard links are no danger: what they lead to stays as it is.
///
/// # Errors
/// [`Error::Usage`]
pub fn refuse_overwriting(
    outputs: impl IntoIterator<Item: AsRef<Path>>,
    inputs: impl IntoIterator<Item: AsRef<Path>>,
) -> Result<()> {
    let of_input = |input: &Path| {
        Some((place_of(input)?, format!("the input {}", input.shown()), "the output"))
    };
    let mut known: Vec<_> =
        inputs.into_iter().filter_map(|input| of_input(input.as_ref())).collect();
    for output in outputs {
        let output = output.as_ref();
        let Some(place) = place_of(output) else { continue };
        let name = output.shown();
        if let Some((_, is, other)) = known.iter().find(|(known, ..)| *known == place) {
            return wrong_usage(format!("{name}: this is {is}; name another file for {other}"));
        }
        known.push((place, format!("the output {name} as well"), "one of them"));
    }
    Ok(())
}

/// Where a regular file is or is to be, without links; `None` where nothing is kept, as in a pipe, and where
/// nothing can be.
fn place_of(path: &Path) -> Option<PathBuf> {
    if path == Path::new(OutputFile::STDOUT) {
        return None;
    }
    match fs::metadata(path) {
        Ok(found) if found.is_file() => fs::canonicalize(path).ok(),
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            let target = end_of_links(path);
            Some(fs::canonicalize(folder_of(&target)).ok()?.join(target.file_name()?))
        }
        _ => None,
    }
}

/// The system's reason without the temporary file's name, which says nothing to the user.
fn io_cause(error: &io::Error) -> io::Error {
    let inner = error.get_ref().and_then(|wrapped| wrapped.source()?.downcast_ref::<io::Error>());
    match inner.unwrap_or(error).raw_os_error() {
        Some(code) => io::Error::from_raw_os_error(code),
        None => error.kind().into(),
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.place.sink().write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.place.sink().flush()
    }
}

impl Seek for OutputFile {
    /// Fails on a target that can't seek, unless the file was created with `needs_seek`.
    fn seek(&mut self, position: SeekFrom) -> io::Result<u64> {
        match &mut self.place {
            Place::Beside { file, .. } | Place::Spool(file, _) => file.seek(position),
            Place::Stream(_) => Err(io::ErrorKind::NotSeekable.into()),
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

    fn create(path: &Path) -> OutputFile {
        OutputFile::create(path, false).unwrap()
    }

    #[test]
    fn a_file_appears_whole_or_not_at_all() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.png");
        fs::write(&path, "old").unwrap();

        let mut dropped = create(&path);
        dropped.write_all(b"half of the n").unwrap();
        dropped.flush().unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        drop(dropped);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["out.png"]);

        let (cancelled, control) = (Control::default(), Control::default());
        cancelled.cancel();
        let error = commit([create(&path)], &cancelled).unwrap_err();
        assert!(matches!(error, Error::Interrupted));
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["out.png"]);

        let mut whole = create(&path);
        whole.write_all(b"new").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        commit([whole], &control).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert_eq!(names(folder.path()), ["out.png"]);
    }

    /// The folder that one of the targets would go to vanishes meanwhile.
    #[test]
    fn a_failure_amid_renaming_tells_what_was_changed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let files = ["a", "b", "c"].map(|name| create(&at(name)));
        fs::create_dir_all(at("b/full")).unwrap();
        let error = commit(files, &Control::default()).unwrap_err();
        assert!(matches!(&error, Error::Io { path, .. } if *path == at("b")), "{error}");
        let changed = format!("{} changed already", at("a").shown());
        assert!(error.to_string().contains(&changed), "{error}");
        assert_eq!(names(folder.path()), ["a", "b"]);
    }

    #[test]
    fn what_is_begun_is_known_until_it_is_in_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let is_known = || unfinished().iter().any(|path| path.starts_with(folder.path()));
        let file = create(&folder.path().join("x"));
        assert!(is_known());
        commit([file], &Control::default()).unwrap();
        assert!(!is_known());
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

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_disk_names_the_output_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.png");
        let mut output = create(&path);
        let Place::Beside { file, .. } = &mut output.place else { panic!() };
        *file = BufWriter::new(OpenOptions::new().write(true).open("/dev/full").unwrap());
        output.write_all(b"no room").unwrap();
        let error = commit([output], &Control::default()).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}: No space left", path.shown())), "{error}");
        assert!(!error.contains(PREFIX), "{error}");
        assert!(names(folder.path()).is_empty());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn special_files_are_written_to_not_replaced() {
        use std::os::unix::fs::FileTypeExt;
        for needs_seek in [false, true] {
            let mut file = OutputFile::create("/dev/null", needs_seek).unwrap();
            file.write_all(b"gone").unwrap();
            assert_eq!(file.seek(SeekFrom::Start(1)).is_ok(), needs_seek);
            commit([file], &Control::default()).unwrap();
            let kind = fs::metadata("/dev/null").unwrap().file_type();
            assert!(kind.is_char_device());

            let mut full = OutputFile::create("/dev/full", needs_seek).unwrap();
            full.write_all(b"no room").unwrap();
            let message = commit([full], &Control::default()).err().unwrap().to_string();
            assert!(message.starts_with("/dev/full: "), "{message}");
        }
    }
}
