//! Opening another scene: a path, what its folder has, and the files of before.

use std::fs;
use std::path::{MAIN_SEPARATOR, Path, PathBuf};

use egui::{Key, Modifiers, ScrollArea, TextEdit, Ui};

use super::panels::INSET;
use super::state::{Command, State};
use crate::plain::Shown;
use crate::scene::is_cloud_file;

/// Most entries of a folder that are looked at.
const MOST_ENTRIES: usize = 5000;

/// Largest width of the dialog, points.
const WIDTH: f32 = 560.0;

/// The dialog.
pub struct Opening {
    /// The path as it is typed.
    text: String,
    /// The folder that was listed last, and what is in it.
    listed: Option<(PathBuf, Vec<Entry>)>,
    /// The entry that the arrow keys have come to.
    chosen: Option<usize>,
    /// The file that is being read, or why it can't be.
    pub answer: Option<Result<PathBuf, String>>,
    /// The cursor goes to the end of the text.
    is_new: bool,
}

/// A folder or a file.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    /// Folders come first.
    is_file: bool,
    name: String,
}

impl Opening {
    /// Begins in the folder of a file.
    pub fn beside(path: &Path) -> Opening {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new("."));
        let text = with_separator(&folder.display().to_string());
        Opening { text, listed: None, chosen: None, answer: None, is_new: true }
    }

    /// The folder and the beginning of a name that the text stands for.
    fn parts(&self) -> (PathBuf, &str) {
        let at = self.text.rfind(std::path::is_separator).map_or(0, |at| at + 1);
        let (folder, name) = self.text.split_at(at);
        (expanded(if folder.is_empty() { "." } else { folder }), name)
    }

    /// Lists the folder anew where it is another one.
    fn list(&mut self) {
        let (folder, _) = self.parts();
        if self.listed.as_ref().is_none_or(|(listed, _)| *listed != folder) {
            let entries = entries(&folder);
            self.listed = Some((folder, entries));
        }
    }

    /// The entries whose names begin with what is typed; hidden ones where a dot is.
    fn matching(&self) -> Vec<Entry> {
        let (_, typed) = self.parts();
        let typed = typed.to_lowercase();
        let entries = self.listed.iter().flat_map(|(_, entries)| entries);
        let matches = entries.filter(|entry| {
            entry.name.to_lowercase().starts_with(&typed)
                && (typed.starts_with('.') || !entry.name.starts_with('.'))
        });
        matches.cloned().collect()
    }

    /// Writes an entry's name in place of the beginning that is typed.
    fn take(&mut self, entry: &Entry) {
        let typed = self.parts().1.len();
        self.text.truncate(self.text.len() - typed);
        self.text += &entry.name;
        if !entry.is_file {
            self.text.push(MAIN_SEPARATOR);
        }
        (self.chosen, self.is_new) = (None, true);
    }

    /// Completes what is typed as far as all matching names agree.
    fn complete(&mut self) {
        let matching = self.matching();
        if let [entry] = &matching[..] {
            return self.take(entry);
        }
        let common = matching.iter().map(|entry| entry.name.as_str()).reduce(|a, b| {
            let same = a.char_indices().zip(b.chars()).find(|((_, x), y)| x != y);
            &a[..same.map_or(a.len().min(b.len()), |((at, _), _)| at)]
        });
        let typed = self.parts().1.len();
        if let Some(common) = common.filter(|common| common.len() > typed) {
            let start = self.text.len() - typed;
            self.text.replace_range(start.., common);
            self.is_new = true;
        }
    }

    /// The chosen entry, else the path that is typed: a folder is entered, a file is given.
    fn enter(&mut self) -> Option<PathBuf> {
        let matching = self.matching();
        if let Some(entry) = self.chosen.and_then(|i| matching.get(i)).cloned() {
            self.take(&entry);
        }
        let path = expanded(&self.text);
        if path.is_dir() {
            self.text = with_separator(&self.text);
            self.is_new = true;
            return None;
        }
        Some(path)
    }
}

fn with_separator(text: &str) -> String {
    match text.ends_with(std::path::is_separator) {
        true => text.to_string(),
        false => format!("{text}{MAIN_SEPARATOR}"),
    }
}

/// The path of a text, with the home folder for `~`.
fn expanded(text: &str) -> PathBuf {
    let rest = text.strip_prefix('~').filter(|rest| rest.starts_with(std::path::is_separator));
    match (rest, std::env::home_dir()) {
        (Some(rest), Some(home)) => home.join(rest.trim_start_matches(std::path::is_separator)),
        _ => text.into(),
    }
}

/// Folders and scenes of a folder, in order; none where it can't be read.
fn entries(folder: &Path) -> Vec<Entry> {
    let Ok(all) = fs::read_dir(folder) else { return Vec::new() };
    let entry = |entry: fs::DirEntry| {
        let name = entry.file_name().into_string().ok()?;
        let is_file = !entry.path().is_dir();
        let path = Path::new(&name);
        let is_scene = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
        (!is_file || is_scene || is_cloud_file(path)).then_some(Entry { is_file, name })
    };
    let mut entries: Vec<Entry> = all.flatten().take(MOST_ENTRIES).filter_map(entry).collect();
    entries.sort();
    entries
}

/// Shows the dialog where it is open.
pub fn opening(ui: &Ui, rect: egui::Rect, state: &mut State, commands: &mut Vec<Command>) {
    let Some(mut dialog) = state.opening.take() else { return };
    dialog.list();
    let width = WIDTH.min(rect.width() - 2.0 * INSET - 16.0).max(120.0);
    let height = (rect.height() - 190.0).clamp(60.0, 320.0);
    let mut is_open = true;
    let mut wanted = None;
    super::panels::dialog("Open a scene", rect).open(&mut is_open).show(ui.ctx(), |ui| {
        ui.set_width(width);
        wanted = field(ui, &mut dialog);
        match &dialog.answer {
            Some(Ok(path)) => drop(ui.weak(format!("reading {} …", path.shown()))),
            Some(Err(error)) => drop(ui.colored_label(ui.visuals().error_fg_color, error)),
            None => drop(ui.weak("Tab completes, the arrow keys choose, Enter opens")),
        }
        ScrollArea::vertical().max_height(height).auto_shrink([false, true]).show(ui, |ui| {
            if let Some(path) = list(ui, &mut dialog, &state.recent) {
                wanted = Some(path);
            }
        });
    });
    if let Some(path) = wanted {
        dialog.answer = Some(Ok(path.clone()));
        commands.push(Command::Open(path));
    }
    state.opening = is_open.then_some(dialog);
}

/// The field with the path; a file that is to be opened.
fn field(ui: &mut Ui, dialog: &mut Opening) -> Option<PathBuf> {
    let pressed = |ui: &Ui, key| ui.input_mut(|input| input.consume_key(Modifiers::NONE, key));
    if pressed(ui, Key::Tab) {
        dialog.complete();
    }
    let n = dialog.matching().len();
    if n > 0 && pressed(ui, Key::ArrowDown) {
        dialog.chosen = Some(dialog.chosen.map_or(0, |i| (i + 1) % n));
    }
    if n > 0 && pressed(ui, Key::ArrowUp) {
        dialog.chosen = Some(dialog.chosen.map_or(n - 1, |i| (i + n - 1) % n));
    }
    let enter = pressed(ui, Key::Enter);
    let mut edit = TextEdit::singleline(&mut dialog.text)
        .desired_width(f32::INFINITY)
        .hint_text("path of a scene")
        .lock_focus(true)
        .show(ui);
    let end = egui::text::CCursor::new(dialog.text.chars().count());
    if std::mem::take(&mut dialog.is_new) {
        edit.response.request_focus();
        edit.state.cursor.set_char_range(Some(egui::text::CCursorRange::one(end)));
        edit.state.store(ui.ctx(), edit.response.id);
    }
    if edit.response.changed() {
        (dialog.chosen, dialog.answer) = (None, None);
    }
    if enter {
        dialog.answer = None;
        return dialog.enter();
    }
    None
}

/// The entries that match, and the files of before; a file that is to be opened.
fn list(ui: &mut Ui, dialog: &mut Opening, recent: &[PathBuf]) -> Option<PathBuf> {
    let matching = dialog.matching();
    let mut taken = None;
    for (i, entry) in matching.iter().enumerate() {
        let name = match entry.is_file {
            true => entry.name.clone(),
            false => format!("{}{MAIN_SEPARATOR}", entry.name),
        };
        let is_chosen = dialog.chosen == Some(i);
        let response = ui.selectable_label(is_chosen, name);
        if is_chosen {
            response.scroll_to_me(None);
        }
        if response.clicked() {
            taken = Some(entry.clone());
        }
    }
    if matching.is_empty() {
        ui.weak("no folder, scene or data file begins so");
    }
    let mut wanted = None;
    if !recent.is_empty() {
        ui.add_space(6.0);
        ui.strong("recent");
    }
    for path in recent {
        if ui.selectable_label(false, path.shown()).clicked() {
            wanted = Some(path.clone());
        }
    }
    if let Some(entry) = taken {
        dialog.take(&entry);
        wanted = dialog.enter();
    }
    wanted
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> (tempfile::TempDir, Opening) {
        let folder = tempfile::tempdir().unwrap();
        for name in
            ["figure1.toml", "figure2.TOML", "fugue.toml", "gas.npy", "b.png", ".hidden.toml"]
        {
            fs::write(folder.path().join(name), "").unwrap();
        }
        fs::create_dir(folder.path().join("figures")).unwrap();
        let mut dialog = Opening::beside(&folder.path().join("figure1.toml"));
        dialog.list();
        (folder, dialog)
    }

    fn names(dialog: &Opening) -> Vec<String> {
        dialog.matching().into_iter().map(|entry| entry.name).collect()
    }

    #[test]
    fn a_folder_offers_folders_and_scenes() {
        let (_folder, mut dialog) = folder();
        assert_eq!(
            names(&dialog),
            ["figures", "figure1.toml", "figure2.TOML", "fugue.toml", "gas.npy"]
        );
        dialog.text += "FIG";
        assert_eq!(names(&dialog), ["figures", "figure1.toml", "figure2.TOML"]);
        dialog.text.truncate(dialog.text.len() - 3);
        dialog.text += ".";
        assert_eq!(names(&dialog), [".hidden.toml"]);
    }

    #[test]
    fn tab_completes_as_far_as_names_agree() {
        let (folder, mut dialog) = folder();
        let start = dialog.text.clone();
        dialog.text += "f";
        dialog.complete();
        assert_eq!(dialog.text, format!("{start}f"));
        dialog.text += "i";
        dialog.complete();
        assert_eq!(dialog.text, format!("{start}figure"));
        dialog.text += "s";
        dialog.complete();
        assert_eq!(dialog.text, format!("{start}figures{MAIN_SEPARATOR}"));
        dialog.list();
        assert!(names(&dialog).is_empty());
        dialog.text = format!("{start}fu");
        dialog.list();
        dialog.complete();
        assert_eq!(dialog.enter(), Some(folder.path().join("fugue.toml")));
    }

    #[test]
    fn enter_goes_into_folders_and_takes_what_is_chosen() {
        let (folder, mut dialog) = folder();
        let start = dialog.text.clone();
        dialog.chosen = Some(1);
        assert_eq!(dialog.enter(), Some(folder.path().join("figure1.toml")));
        dialog.text = format!("{start}figures");
        assert_eq!(dialog.enter(), None);
        assert_eq!(dialog.text, format!("{start}figures{MAIN_SEPARATOR}"));
        dialog.text = format!("{start}not there");
        assert_eq!(dialog.enter(), Some(folder.path().join("not there")));
    }

    #[test]
    fn paths_begin_where_they_are_written() {
        assert_eq!(Opening::beside(Path::new("a.toml")).text, format!(".{MAIN_SEPARATOR}"));
        assert_eq!(expanded("~a/b"), Path::new("~a/b"));
        if let Some(home) = std::env::home_dir() {
            assert_eq!(expanded("~/b"), home.join("b"));
        }
        let dialog = Opening { text: "x".into(), ..Opening::beside(Path::new("a.toml")) };
        assert_eq!(dialog.parts(), (PathBuf::from("."), "x"));
    }
}
