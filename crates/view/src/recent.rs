//! The files that were opened last, kept from one window to the next: a path a line, the newest first.

use std::fs;
use std::path::{Path, PathBuf};

use kugelblitz::control::Control;
use kugelblitz::input::read_text;
use kugelblitz::output::{OutputFile, commit};
use kugelblitz::{Error, Result};

/// Most files that are kept.
const MOST: usize = 12;

/// The files that `list` names and that are still there; none where it can't be read.
pub fn recent(list: &Path) -> Vec<PathBuf> {
    let text = read_text(list, "a list", "remove it").unwrap_or_default();
    let paths = text.lines().map(PathBuf::from);
    paths.filter(|path| path.is_absolute() && path.exists()).take(MOST).collect()
}

/// Puts a file before all others of `list`, which other windows may have changed meanwhile; gives all.
///
/// # Errors
/// [`Error::Io`] where the list can't be written.
pub fn add_recent(list: &Path, path: &Path) -> Result<Vec<PathBuf>> {
    let path = std::path::absolute(path).map_err(Error::io(path))?;
    let mut paths = recent(list);
    paths.retain(|known| *known != path);
    // A line holds no other path.
    if path.to_str().is_some_and(|text| !text.contains(['\n', '\r'])) {
        paths.insert(0, path);
        paths.truncate(MOST);
    }
    if let Some(folder) = list.parent() {
        fs::create_dir_all(folder).map_err(Error::io(folder))?;
    }
    let lines: String = paths.iter().map(|path| format!("{}\n", path.display())).collect();
    let file = OutputFile::create(list, false)?.filled(lines.as_bytes())?;
    commit([file], &Control::default())?;
    Ok(paths)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_comes_first_and_what_is_gone_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let list = folder.path().join("state/kugelblitz/recent");
        assert!(recent(&list).is_empty());
        let files: Vec<PathBuf> =
            (0..MOST + 2).map(|i| folder.path().join(format!("{i}.toml"))).collect();
        for file in &files {
            fs::write(file, "").unwrap();
            add_recent(&list, file).unwrap();
        }
        let newest_first: Vec<PathBuf> = files.iter().rev().take(MOST).cloned().collect();
        assert_eq!(recent(&list), newest_first);
        assert_eq!(
            add_recent(&list, &files[5]).unwrap()[..2],
            [files[5].clone(), files[13].clone()]
        );
        fs::remove_file(&files[13]).unwrap();
        assert_eq!(recent(&list)[..2], [files[5].clone(), files[12].clone()]);
        let strange = folder.path().join("two\nlines.toml");
        fs::write(&strange, "").unwrap();
        assert!(!add_recent(&list, &strange).unwrap().contains(&strange));
        assert_eq!(fs::read_dir(list.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn a_list_that_cannot_be_written_is_an_error() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, "").unwrap();
        let error = add_recent(&file.join("recent"), &file).unwrap_err();
        assert!(error.to_string().contains("file"), "{error}");
        assert!(recent(folder.path()).is_empty());
    }
}
