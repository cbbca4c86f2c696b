//! Output files that appear whole or not at all, and last of all.

use std::collections::BTreeSet;
use std::ffi::{OsStr, OsString};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use tempfile::TempPath;

use crate::control::Control;
use crate::error::{Error, Result};
use crate::plain::Shown;
use crate::system;

/// A file under construction. [`commit`] puts it in its place; dropped before that, it leaves no
/// trace and the old file as it was.
///
/// It is written in the folder of its target without a name, or where the file system doesn't know
/// such files (`O_TMPFILE`) under a hidden one, and renamed at the end. A target that exists and is
/// not a regular file (a pipe, `/dev/null`) is written to directly, as is standard output. Symbolic
/// links stay, also those that lead to no file yet: it is made where they lead. The permissions of
/// the old file stay; a new one has those that the umask leaves.
///
/// # What is not promised
/// There is no `fsync`: after a power failure the file may be lost. That is the system's usual
/// bargain for files that can be made again, and a render loop would pay for it at each picture.
/// Other hard links to the old file keep the old content.
///
/// A killed process leaves nothing behind but hidden files, where it is killed between naming and
/// renaming or where files must have a name from their start. The next process that begins a file in
/// that folder removes them.
pub struct OutputFile {
    path: PathBuf,
    place: Place,
}

enum Place {
    /// Renamed to its target at the end.
    Beside(Beside),
    /// Goes straight to its target.
    Stream(BufWriter<Box<dyn Write + Send>>),
    /// Collected first, because the target can't seek, and copied to it at the end.
    Spool(BufWriter<File>, Box<dyn Write + Send>),
}

/// A file in the folder of its target.
struct Beside {
    file: BufWriter<File>,
    /// `None` while it has none.
    name: Option<HiddenName>,
    target: PathBuf,
}

/// A whole file under a hidden name, open for its lock.
struct Named {
    name: HiddenName,
    target: PathBuf,
    _file: BufWriter<File>,
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
        let path = match path == Path::new(OutputFile::STDOUT) {
            true => OutputFile::STDOUT_IN_WORDS.into(),
            false => path,
        };
        Ok(OutputFile { path, place })
    }

    /// The path as it was given, but for standard output, which has its name: for errors.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// Completes the outputs of one piece of work: from now on they are at their paths. What can fail or
/// take long comes first, for all of them, then [`Control::commit`], then the renaming.
///
/// # Errors
/// [`Error::Interrupted`] when `control` was cancelled, and [`Error::Io`] that names the path. All old
/// files are then as they were, unless the error says which ones are not.
pub fn commit(files: impl IntoIterator<Item = OutputFile>, control: &Control) -> Result<()> {
    let mut written = Vec::new();
    for OutputFile { path, place } in files {
        if let Some(beside) = place.end().map_err(Error::io(&path))? {
            written.push((path, beside));
        }
    }
    control.commit()?;
    let mut named = Vec::new();
    for (path, beside) in written {
        let name = beside.named().map_err(Error::io(&path))?;
        named.push((path, name));
    }
    let mut changed = Changed::default();
    named.into_iter().try_for_each(|(path, file)| changed.put_in_place(&path, file))
}

/// As [`commit`], of data and a scene that names them, which are one state: a process that is killed
/// amid it leaves a scene with its own data, the old one or the new one.
///
/// Two files can't be renamed at once. Where both are there already, the data get a second name beside the
/// scene, as `SCENE.toml.kugelblitz-a1B2c3.npy`. `write` writes a scene that has the data there; it is put
/// in the place of the old one, then the data, then `scene`, and the second name goes. What a killed
/// process left of it, the next that comes to its end removes.
///
/// # Errors
/// As [`commit`]; and those of `write`.
pub fn commit_with_scene(
    data: OutputFile,
    scene: OutputFile,
    write: impl FnOnce(&mut OutputFile, &Path) -> Result<()>,
    control: &Control,
) -> Result<()> {
    if !data.replaces_a_file() || !scene.replaces_a_file() {
        return commit([data, scene], control);
    }
    let (data_path, scene_path) = (data.path.clone(), scene.path.clone());
    let Some(data) = data.named()? else { return commit([scene], control) };
    // Of both its names, to the end: another process that comes to its end here removes neither.
    let _lock = data._file.get_ref().try_clone();
    let (prefix, suffix) = second_names(&scene_path, &data_path);
    let second = HiddenName::second(&data.name.0, folder_of(&scene_path), &prefix, &suffix);
    let mut second = second.map_err(Error::io(&data_path))?;
    let mut aside = OutputFile::create(&scene_path, false)?;
    write(&mut aside, &second.0)?;
    let (Some(aside), Some(scene)) = (aside.named()?, scene.named()?) else { return Ok(()) };
    control.commit()?;

    let mut changed = Changed::default();
    second.forget();
    changed.put_in_place(&scene_path, aside)?;
    // From here on, the second name is needed.
    second.0.disable_cleanup(true);
    changed.put_in_place(&data_path, data)?;
    changed.put_in_place(&scene_path, scene)?;
    let _ = fs::remove_file(&second.0);
    remove_dead(folder_of(&scene_path), &prefix, &suffix);
    Ok(())
}

/// What second names of data begin and end with, which no other scene's have.
fn second_names(scene: &Path, data: &Path) -> (String, String) {
    let name = |name: Option<&OsStr>| name.unwrap_or_default().to_string_lossy().into_owned();
    let (scene, ending) = (name(scene.file_name()), name(data.extension()));
    (format!("{scene}.kugelblitz-"), format!(".{ending}"))
}

/// The outputs that are in their places.
#[derive(Default)]
struct Changed(Vec<String>);

impl Changed {
    fn put_in_place(&mut self, path: &Path, Named { name, target, _file }: Named) -> Result<()> {
        let renamed = name.rename(&target).map_err(|error| match self.0.as_slice() {
            [] => error,
            changed => io::Error::other(format!("{error}; {} changed already", changed.join(", "))),
        });
        self.0.push(path.shown());
        renamed.map_err(Error::io(path))
    }
}

impl OutputFile {
    /// True where a file will be renamed over another.
    fn replaces_a_file(&self) -> bool {
        matches!(&self.place, Place::Beside(Beside { target, .. }) if target.exists())
    }

    /// Writes out what is left. A file that is then to be renamed is returned under its hidden name.
    fn named(self) -> Result<Option<Named>> {
        let beside = self.place.end().map_err(Error::io(&self.path))?;
        beside.map(Beside::named).transpose().map_err(Error::io(&self.path))
    }
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
        remove_dead_once(folder);
        let (file, name) = match system::unnamed(folder) {
            Ok(file) => (file, None),
            Err(_) => {
                let (file, name) = HiddenName::of_new_file(folder)?;
                (file, Some(name))
            }
        };
        if let Some(old) = old {
            system::keep_permissions(&file, &old)?;
        }
        Ok(Place::Beside(Beside { file: BufWriter::new(file), name, target }))
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
            Place::Beside(Beside { file, .. }) | Place::Spool(file, _) => file,
            Place::Stream(stream) => stream,
        }
    }

    /// Writes out what is left. A file that is then to be renamed is returned.
    fn end(self) -> io::Result<Option<Beside>> {
        match self {
            Place::Beside(mut beside) => {
                beside.file.flush()?;
                Ok(Some(beside))
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

impl Beside {
    fn named(self) -> io::Result<Named> {
        let name = match self.name {
            Some(name) => name,
            None => HiddenName::of_unnamed(self.file.get_ref(), folder_of(&self.target))?,
        };
        Ok(Named { name, target: self.target, _file: self.file })
    }
}

fn folder_of(path: &Path) -> &Path {
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
const SUFFIX: &str = ".tmp";

/// Letters and digits between the two, drawn at random.
const N_RANDOM: usize = 6;

fn builder<'a>(prefix: &'a str, suffix: &'a str) -> tempfile::Builder<'a, 'a> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(suffix).rand_bytes(N_RANDOM);
    system::like_ordinary_files(&mut builder);
    builder
}

/// The name of a file that is not in its place yet. Dropped, it removes the file.
struct HiddenName(TempPath);

/// The files that have a name before they are whole, for [`remove_unfinished`].
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

impl HiddenName {
    /// A new file in `folder`, locked as long as it is open, so that [`remove_dead`] leaves it.
    fn of_new_file(folder: &Path) -> io::Result<(File, HiddenName)> {
        loop {
            let made = builder(PREFIX, SUFFIX).tempfile_in(folder).map_err(|e| io_cause(&e))?;
            let (file, path) = made.into_parts();
            let name = HiddenName::new(path);
            // Some file systems have no locks, and there nothing is removed.
            let _ = file.lock();
            // Removed before it was locked?
            if system::has_name(&file)? {
                return Ok((file, name));
            }
        }
    }

    fn of_unnamed(file: &File, folder: &Path) -> io::Result<HiddenName> {
        // As in `of_new_file`.
        let _ = file.lock();
        HiddenName::made(folder, PREFIX, SUFFIX, |path| system::name(file, path))
    }

    /// A second name of a file, also in the folder of another file system.
    fn second(file: &Path, folder: &Path, prefix: &str, suffix: &str) -> io::Result<HiddenName> {
        HiddenName::made(folder, prefix, suffix, |path| match fs::hard_link(file, path) {
            Ok(()) => Ok(()),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Err(error),
            Err(_) => {
                let mut copy = File::create_new(path)?;
                io::copy(&mut File::open(file)?, &mut copy).map(drop)
            }
        })
    }

    fn made(
        folder: &Path,
        prefix: &str,
        suffix: &str,
        make: impl FnMut(&Path) -> io::Result<()>,
    ) -> io::Result<HiddenName> {
        let made = builder(prefix, suffix).make_in(folder, make).map_err(|e| io_cause(&e))?;
        Ok(HiddenName::new(made.into_temp_path()))
    }

    fn new(path: TempPath) -> HiddenName {
        UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).push(path.to_path_buf());
        HiddenName(path)
    }

    /// Leaves the file to its owner, whatever becomes of the process.
    fn forget(&self) {
        let mut unfinished = UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner);
        unfinished.retain(|path| **path != *self.0);
    }

    /// Puts the file in the place of `target`, whatever was there.
    fn rename(self, target: &Path) -> io::Result<()> {
        fs::rename(&self.0, target)
        // Dropped, it finds nothing to remove any more.
    }
}

impl Drop for HiddenName {
    fn drop(&mut self) {
        self.forget();
    }
}

/// Removes what this process has begun under hidden names. For a program that ends at once, without
/// dropping anything; what is not committed then never will be.
pub fn remove_unfinished() {
    for path in UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner).drain(..) {
        let _ = fs::remove_file(path);
    }
}

/// The folders that this process has looked at for hidden files.
static LOOKED_AT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

/// Removes the hidden files of ended processes where this one has not looked for them yet: a film of many
/// frames reads its folder once.
fn remove_dead_once(folder: &Path) {
    let Ok(whole) = fs::canonicalize(folder) else { return };
    if LOOKED_AT.lock().unwrap_or_else(PoisonError::into_inner).insert(whole) {
        remove_dead(folder, PREFIX, SUFFIX);
    }
}

/// Removes the files of ended processes from `folder`: those that nobody holds a lock on and that are
/// named as by [`builder`].
fn remove_dead(folder: &Path, prefix: &str, suffix: &str) {
    let is_random = |part: &str| {
        part.len() == N_RANDOM && part.bytes().all(|byte| byte.is_ascii_alphanumeric())
    };
    let is_ours = |name: &str| {
        let part = name.strip_prefix(prefix).and_then(|rest| rest.strip_suffix(suffix));
        part.is_some_and(is_random)
    };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        if !name.to_str().is_some_and(is_ours) || !entry.file_type().is_ok_and(|t| t.is_file()) {
            continue;
        }
        // Held open until it is gone, so that its maker can't have it locked meanwhile.
        if let Ok(file) = File::open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Refuses an output that would replace an input, or another output, by whatever name or link.
///
/// # Errors
/// [`Error::Usage`]
pub fn refuse_overwriting(outputs: &[&Path], inputs: &[&Path]) -> Result<()> {
    for (i, output) in outputs.iter().enumerate() {
        let Some(identity) = Identity::of(output) else { continue };
        let is_same = |other: &&&Path| Identity::of(other).as_ref() == Some(&identity);
        if let Some(input) = inputs.iter().find(is_same) {
            return Err(Error::Usage(format!(
                "{}: this is the input {}; name another file for the output",
                output.shown(),
                input.shown()
            )));
        }
        if let Some(other) = outputs[..i].iter().find(is_same) {
            return Err(Error::Usage(format!(
                "{}: this is the output {} as well; name another file for one of them",
                output.shown(),
                other.shown()
            )));
        }
    }
    Ok(())
}

/// The identity of a regular file, the same for all its paths.
#[derive(PartialEq)]
enum Identity {
    /// As the system tells it.
    File((u64, u64)),
    /// That of the folder, and the name in it of a file that is not there yet.
    New((u64, u64), OsString),
    /// The path without links, where the system tells nothing.
    Path(PathBuf),
}

impl Identity {
    /// `None` where nothing is kept, as in a pipe, and where nothing can be.
    fn of(path: &Path) -> Option<Identity> {
        if path == Path::new(OutputFile::STDOUT) {
            return None;
        }
        let target = match fs::metadata(path) {
            Ok(found) if !found.is_file() => return None,
            Ok(_) => match system::identity(path) {
                Ok(identity) => return Some(Identity::File(identity)),
                Err(_) => return fs::canonicalize(path).ok().map(Identity::Path),
            },
            Err(error) if error.kind() == io::ErrorKind::NotFound => end_of_links(path),
            Err(_) => return None,
        };
        let (folder, name) = (folder_of(&target), target.file_name()?);
        Some(match system::identity(folder) {
            Ok(identity) => Identity::New(identity, name.to_owned()),
            Err(_) => Identity::Path(fs::canonicalize(folder).ok()?.join(name)),
        })
    }
}

/// The system's reason without the temporary file's name, which says nothing to the user.
fn io_cause(error: &io::Error) -> io::Error {
    if let Some(code) = error.raw_os_error() {
        return io::Error::from_raw_os_error(code);
    }
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
            Place::Beside(Beside { file, .. }) | Place::Spool(file, _) => file.seek(position),
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

    /// An output as [`OutputFile::create`] gives it, or as it does on other file systems.
    fn create(path: &Path, has_name: bool) -> OutputFile {
        if !has_name {
            return OutputFile::create(path, false).unwrap();
        }
        let (file, name) = HiddenName::of_new_file(folder_of(path)).unwrap();
        let (file, name) = (BufWriter::new(file), Some(name));
        let place = Place::Beside(Beside { file, name, target: path.into() });
        OutputFile { path: path.into(), place }
    }

    #[test]
    fn a_file_appears_whole_or_not_at_all() {
        for has_name in [false, true] {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("out.png");
            fs::write(&path, "old").unwrap();

            let mut dropped = create(&path, has_name);
            dropped.write_all(b"half of the n").unwrap();
            dropped.flush().unwrap();
            assert_eq!(fs::read(&path).unwrap(), b"old");
            drop(dropped);
            assert_eq!(fs::read(&path).unwrap(), b"old");
            assert_eq!(names(folder.path()), ["out.png"]);

            let (cancelled, control) = (Control::default(), Control::default());
            cancelled.cancel();
            let error = commit([create(&path, has_name)], &cancelled).unwrap_err();
            assert!(matches!(error, Error::Interrupted));
            assert_eq!(fs::read(&path).unwrap(), b"old");
            assert_eq!(names(folder.path()), ["out.png"]);

            let mut whole = create(&path, has_name);
            whole.write_all(b"new").unwrap();
            assert_eq!(fs::read(&path).unwrap(), b"old");
            commit([whole], &control).unwrap();
            assert_eq!(fs::read(&path).unwrap(), b"new");
            assert_eq!(names(folder.path()), ["out.png"]);
        }
    }

    /// The folder that one of the targets would go to vanishes meanwhile.
    #[test]
    fn a_failure_amid_renaming_tells_what_was_changed() {
        for has_name in [false, true] {
            let folder = tempfile::tempdir().unwrap();
            let at = |name: &str| folder.path().join(name);
            let files = ["a", "b", "c"].map(|name| create(&at(name), has_name));
            fs::create_dir_all(at("b/full")).unwrap();
            let error = commit(files, &Control::default()).unwrap_err();
            assert!(matches!(&error, Error::Io { path, .. } if *path == at("b")), "{error}");
            let changed = format!("{} changed already", at("a").shown());
            assert!(error.to_string().contains(&changed), "{error}");
            assert_eq!(names(folder.path()), ["a", "b"]);
        }
    }

    /// As above, of two that belong together: where the data can't be put in their place, the scene that is
    /// there names them elsewhere.
    #[test]
    fn a_scene_has_its_data_where_these_have_no_place() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("s.toml"), "old").unwrap();
        fs::write(at("c.npy"), "old").unwrap();
        let [mut data, mut scene] = ["c.npy", "s.toml"].map(|name| create(&at(name), false));
        data.write_all(b"new").unwrap();
        scene.write_all(b"c.npy").unwrap();
        fs::remove_file(at("c.npy")).unwrap();
        fs::create_dir_all(at("c.npy/full")).unwrap();
        let write = |file: &mut OutputFile, data: &Path| {
            write!(file, "{}", data.display()).map_err(Error::io("s.toml"))
        };
        let error = commit_with_scene(data, scene, write, &Control::default()).unwrap_err();
        assert!(error.to_string().contains("s.toml changed already"), "{error}");
        let named = fs::read_to_string(at("s.toml")).unwrap();
        assert!(named.contains("s.toml.kugelblitz-"), "{named}");
        assert_eq!(fs::read(named).unwrap(), b"new");
        assert_eq!(names(folder.path()).len(), 3);

        // Interrupted, it leaves all as it was; done, nothing else.
        fs::remove_dir_all(at("c.npy")).unwrap();
        fs::write(at("c.npy"), "old").unwrap();
        let before = names(folder.path());
        let control = Control::default();
        for is_cancelled in [true, false] {
            let [mut data, scene] = ["c.npy", "s.toml"].map(|name| create(&at(name), false));
            data.write_all(b"newer").unwrap();
            let cancelled = Control::default();
            cancelled.cancel();
            let control = if is_cancelled { &cancelled } else { &control };
            let done = commit_with_scene(data, scene, write, control);
            assert_eq!(done.is_err(), is_cancelled);
            let expected = if is_cancelled { &before[..] } else { &before[..1] };
            assert!(names(folder.path()).starts_with(expected));
            assert_eq!(names(folder.path()).len(), if is_cancelled { 3 } else { 2 });
            assert_eq!(
                fs::read(at("c.npy")).unwrap(),
                if is_cancelled { "old" } else { "newer" }.as_bytes()
            );
        }
    }

    #[test]
    fn hidden_files_of_the_dead_are_removed_and_those_of_the_living_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let dead = folder.path().join(".kugelblitz-Ab12Cd.tmp");
        fs::write(&dead, "half").unwrap();
        for kept in [".kugelblitz-kept", ".kugelblitz-my notes.tmp", ".kugelblitz-Ab12C.tmp"] {
            fs::write(folder.path().join(kept), "no output").unwrap();
        }
        let (_file, living) = HiddenName::of_new_file(folder.path()).unwrap();
        let named = match create(&folder.path().join("a"), false).named().unwrap() {
            Some(named) => named,
            None => panic!("a file is renamed"),
        };
        remove_dead(folder.path(), PREFIX, SUFFIX);
        assert!(!dead.exists());
        assert!(living.0.exists() && named.name.0.exists());
        assert_eq!(names(folder.path()).len(), 5);
    }

    #[test]
    fn an_end_without_dropping_removes_what_was_begun() {
        let folder = tempfile::tempdir().unwrap();
        let (_file, name) = HiddenName::of_new_file(folder.path()).unwrap();
        let other = tempfile::tempdir().unwrap();
        std::mem::forget(name);
        // Not `remove_unfinished`, which would remove the files of other tests.
        let mut unfinished = UNFINISHED.lock().unwrap();
        assert!(unfinished.iter().any(|path| path.starts_with(folder.path())));
        unfinished.retain(|path| !path.starts_with(folder.path()));
        drop(unfinished);
        drop(create(&other.path().join("x"), true));
        let unfinished = UNFINISHED.lock().unwrap();
        assert!(!unfinished.iter().any(|path| path.starts_with(other.path())));
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
        for has_name in [false, true] {
            let mut file = create(&path, has_name);
            let Place::Beside(beside) = &mut file.place else { panic!() };
            let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
            beside.file = BufWriter::new(full);
            file.write_all(b"no room").unwrap();
            let error = commit([file], &Control::default()).unwrap_err().to_string();
            assert!(error.starts_with(&format!("{}: No space left", path.shown())), "{error}");
            assert!(!error.contains(PREFIX), "{error}");
            assert!(names(folder.path()).is_empty());
        }
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
