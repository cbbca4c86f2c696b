//! The files that were opened last, kept from one window to the next: a path a line, the newest first.

use std::fs;
use std::path::{Path, PathBuf};

use kugelblitz::control::Control;
use kugelblitz::input::read_text;
use kugelblitz::output::{OutputFile, commit};
use kugelblitz::{Error, Result};

/// Most files that are kept beside the one that is open.
const MOST_OTHERS: usize = 11;

/// The files other than `path` that `list` names and that are still there; none where it can't be read.
pub fn recent(list: &Path, path: &Path) -> Vec<PathBuf> {
    let path = std::path::absolute(path).ok();
    let text = read_text(list, "a list", "remove it").unwrap_or_default();
    let known = text.lines().map(PathBuf::from);
    let is_there = |other: &PathBuf| other.is_absolute() && other.exists();
    let others = known.filter(|other| is_there(other) && Some(other) != path.as_ref());
    others.take(MOST_OTHERS).collect()
}

/// Writes `list`: a file before the others.
///
/// # Errors
/// [`Error::Io`] where the list can't be written.
pub fn add_recent(list: &Path, path: &Path, others: &[PathBuf]) -> Result<()> {
    let path = std::path::absolute(path).map_err(Error::io(path))?;
    // A line holds no other path.
    let is_line = |text: &str| !text.contains(['\n', '\r']);
    let own = path.to_str().is_some_and(is_line).then_some(&path);
    if let Some(folder) = list.parent() {
        fs::create_dir_all(folder).map_err(Error::io(folder))?;
    }
    let paths = own.into_iter().chain(others);
    let lines: String = paths.map(|path| format!("{}\n", path.display())).collect();
    let file = OutputFile::create(list, false)?.filled(lines.as_bytes())?;
    commit([file], &Control::default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_comes_first_and_what_is_gone_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let list = folder.path().join("state/kugelblitz/recent");
        let files: Vec<PathBuf> =
            (0..MOST_OTHERS + 3).map(|i| folder.path().join(format!("{i}.toml"))).collect();
        assert!(recent(&list, &files[0]).is_empty());
        let open = |file: &Path| {
            let others = recent(&list, file);
            add_recent(&list, file, &others).unwrap();
            others
        };
        let newest_first =
            |files: &[PathBuf]| -> Vec<PathBuf> { files.iter().rev().cloned().collect() };
        for file in &files {
            fs::write(file, "").unwrap();
            open(file);
        }
        assert_eq!(recent(&list, &files[13]), newest_first(&files[2..13]));
        let kept = fs::read_to_string(&list).unwrap();
        assert_eq!(kept.lines().map(PathBuf::from).collect::<Vec<_>>(), newest_first(&files[2..]));
        assert_eq!(open(&files[5])[..2], [files[13].clone(), files[12].clone()]);
        fs::remove_file(&files[13]).unwrap();
        let strange = folder.path().join("two\nlines.toml");
        fs::write(&strange, "").unwrap();
        assert_eq!(open(&strange)[..2], [files[5].clone(), files[12].clone()]);
        assert!(!fs::read_to_string(&list).unwrap().contains("lines.toml"));
        assert_eq!(fs::read_dir(list.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn the_scene_that_is_shown_is_none_of_the_others() {
        let folder = tempfile::tempdir().unwrap();
        let list = folder.path().join("recent");
        // As it is given, from the folder in which the tests run.
        let [own, other] = ["Cargo.toml", "src/lib.rs"].map(std::path::absolute);
        let [own, other] = [own.unwrap(), other.unwrap()];
        let lines = [&own, &other].map(|path| format!("{}\n", path.to_str().unwrap()));
        fs::write(&list, lines.concat()).unwrap();
        assert_eq!(recent(&list, Path::new("Cargo.toml")), [other]);
    }

    #[test]
    fn a_list_that_cannot_be_written_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let error = add_recent(&file.join("recent"), &file, &[]).unwrap_err();
        assert!(error.to_string().contains("file"), "{error}");
        assert!(recent(folder.path(), &file).is_empty());
    }
}
