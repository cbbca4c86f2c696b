//! The bar above the picture, in as many rows as it needs.

use egui::{ComboBox, Ui};

use super::controls::next_theme;
use super::rig::Axis;
use super::state::{Command, SAMPLES, State};
use crate::plain::Shown;
use crate::scene::Samples;
use crate::show::Show;
use crate::trace::Kernel;

/// Height of a row, points.
pub const ROW: f32 = 36.0;

/// Space left and right of a row.
pub const SIDE: f32 = 10.0;

/// Space between two items.
const GAP: f32 = 8.0;

/// Something in the bar.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Item {
    LeftKernel,
    Kernel,
    Compare,
    Show,
    Light,
    Samples,
    File,
    Camera,
    Theme,
    Help,
}

impl Item {
    const ALL: [Item; 10] = [
        Item::LeftKernel,
        Item::Kernel,
        Item::Compare,
        Item::Show,
        Item::Light,
        Item::Samples,
        Item::File,
        Item::Camera,
        Item::Theme,
        Item::Help,
    ];

    /// True for what stands at the right end where there is room.
    fn is_right(self) -> bool {
        matches!(self, Item::Theme | Item::Help)
    }
}

/// The widths of all items, points: first about what they are, then as they were drawn last.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Widths([f32; Item::ALL.len()]);

impl Default for Widths {
    fn default() -> Widths {
        Widths([104.0, 104.0, 74.0, 132.0, 48.0, 74.0, 40.0, 64.0, 106.0, 46.0])
    }
}

impl Widths {
    fn of(&self, item: Item) -> f32 {
        self.0[item as usize]
    }

    /// The items in rows that are not wider than `width`, but for a single item that is wider.
    fn rows(&self, compares: bool, width: f32) -> Vec<Vec<Item>> {
        let mut rows: Vec<Vec<Item>> = Vec::new();
        let mut used = f32::INFINITY;
        for item in Item::ALL.into_iter().filter(|item| compares || *item != Item::LeftKernel) {
            used += GAP + self.of(item);
            // Those two stay together.
            let with_next = match item {
                Item::Theme => used + GAP + self.of(Item::Help),
                _ => used,
            };
            match rows.last_mut() {
                Some(row) if with_next <= width => row.push(item),
                _ => {
                    rows.push(vec![item]);
                    used = self.of(item);
                }
            }
        }
        rows
    }

    /// Height of the bar in a window of this width, points.
    pub fn height(&self, compares: bool, window_width: f32) -> f32 {
        self.rows(compares, window_width - 2.0 * SIDE).len() as f32 * ROW
    }
}

/// The whole bar.
pub fn bar(ui: &mut Ui, state: &mut State, commands: &mut Vec<Command>) {
    ui.spacing_mut().item_spacing = egui::vec2(GAP, 0.0);
    let width = ui.available_width();
    let rows = state.bar_widths.rows(state.compares, width);
    // A row more would push at the picture.
    let height = ui.available_height() / rows.len() as f32;
    for row in rows {
        ui.allocate_ui(egui::vec2(width, height), |ui| {
            ui.set_min_height(height);
            ui.horizontal_centered(|ui| {
                for (i, &item) in row.iter().enumerate() {
                    if i > 0 && item.is_right() && !row[i - 1].is_right() {
                        let rest = &row[i..];
                        let widths: f32 = rest.iter().map(|item| state.bar_widths.of(*item)).sum();
                        let taken = widths + GAP * (rest.len() - 1) as f32;
                        ui.add_space((ui.available_width() - taken).max(0.0));
                    }
                    let drawn = ui.scope(|ui| draw(ui, item, state, commands)).response.rect;
                    state.bar_widths.0[item as usize] = drawn.width();
                }
            });
        });
    }
}

fn draw(ui: &mut Ui, item: Item, state: &mut State, commands: &mut Vec<Command>) {
    match item {
        Item::LeftKernel => {
            kernel_box(ui, "left kernel", &mut state.kernels[0], &state.offered);
        }
        Item::Kernel => kernel_box(ui, "kernel", &mut state.kernels[1], &state.offered),
        Item::Compare => {
            let tip = "Two kernels side by side (C)";
            if toggle(ui, "compare", state.compares).on_hover_text(tip).clicked() {
                state.toggle_compare();
            }
        }
        Item::Show => show_box(ui, state),
        Item::Light => light(ui, state),
        Item::Samples => samples_box(ui, state),
        Item::File => {
            ui.menu_button("file", |ui| file_menu(ui, state, commands));
        }
        Item::Camera => {
            ui.menu_button("camera", |ui| camera_menu(ui, state, commands));
        }
        Item::Theme => {
            if ui.button(theme_name(ui)).on_hover_text("Light or dark (T)").clicked() {
                next_theme(ui);
            }
        }
        Item::Help => {
            if toggle(ui, "help", state.has_help).on_hover_text("All controls (H)").clicked() {
                state.has_help = !state.has_help;
            }
        }
    }
}

/// A button that stays down.
fn toggle(ui: &mut Ui, name: &str, is_on: bool) -> egui::Response {
    ui.add(egui::Button::selectable(is_on, name).frame_when_inactive(true))
}

fn kernel_box(ui: &mut Ui, id: &str, kernel: &mut Kernel, offered: &[Kernel]) {
    ComboBox::from_id_salt(id).width(92.0).selected_text(kernel.name()).show_ui(ui, |ui| {
        for &known in offered {
            ui.selectable_value(kernel, known, known.name());
        }
    });
}

fn show_box(ui: &mut Ui, state: &mut State) {
    let shown = ComboBox::from_id_salt("show").width(116.0).selected_text(state.show.name());
    shown.show_ui(ui, |ui| {
        for (i, show) in Show::ALL.into_iter().enumerate() {
            let name = format!("{}   F{}", show.name(), i + 1);
            ui.selectable_value(&mut state.show, show, name).on_hover_text(show.explanation());
        }
    });
}

fn light(ui: &mut Ui, state: &mut State) {
    let (is_lit, is_on) = (state.scene.is_lit(), state.has_light && state.scene.is_lit());
    let label = egui::Button::selectable(is_on, "light").frame_when_inactive(true);
    let tip = "The scene's light on or off (L)";
    let response = ui.add_enabled(is_lit, label).on_hover_text(tip);
    if response.on_disabled_hover_text("The scene has no light").clicked() {
        state.has_light = !state.has_light;
    }
}

fn samples_box(ui: &mut Ui, state: &mut State) {
    let shown = ComboBox::from_id_salt("samples").width(58.0);
    let shown = shown.selected_text(samples_text(state.n_samples)).show_ui(ui, |ui| {
        for n in SAMPLES {
            ui.selectable_value(&mut state.n_samples, n, samples_text(n));
        }
    });
    shown.response.on_hover_text("Samples a pixel (N, shift + N)");
}

fn samples_text(samples: Samples) -> String {
    format!("{0} × {0}", samples.across())
}

fn theme_name(ui: &Ui) -> &'static str {
    match ui.options(|options| options.theme_preference) {
        egui::ThemePreference::Dark => "dark theme",
        egui::ThemePreference::Light => "light theme",
        egui::ThemePreference::System => "system theme",
    }
}

fn item(ui: &mut Ui, name: &str, key: &str, is_there: bool) -> bool {
    let button = egui::Button::new(name).shortcut_text(key);
    ui.add_enabled(is_there, button).clicked()
}

fn file_menu(ui: &mut Ui, state: &mut State, commands: &mut Vec<Command>) {
    let before = state.scene_before();
    if item(ui, "the scene before", "Ctrl+O", before.is_some()) {
        commands.extend(before.map(Command::Open));
    }
    if item(ui, "save what is shown", "Ctrl+S", true) {
        commands.push(Command::Save);
    }
    let recent: Vec<_> = state.recent.iter().filter(|path| **path != state.path).collect();
    if !recent.is_empty() {
        ui.separator();
        ui.weak("recent");
    }
    for path in recent {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        if ui.button(name).on_hover_text(path.shown()).clicked() {
            commands.push(Command::Open(path.clone()));
        }
    }
}

fn camera_menu(ui: &mut Ui, state: &mut State, commands: &mut Vec<Command>) {
    if item(ui, "frame everything", "F", true) {
        state.frame_everything();
    }
    for (i, axis) in Axis::ALL.into_iter().enumerate() {
        if item(ui, &format!("from {}", axis.name), &(i + 1).to_string(), true) {
            state.look_along(axis);
        }
    }
    if item(ui, "the file's camera", "R", true) {
        state.go_home();
    }
    ui.separator();
    let [undoes, redoes] = state.history.has(&state.rig);
    if item(ui, "undo", "Ctrl+Z", undoes) {
        state.undo();
    }
    if item(ui, "redo", "Ctrl+Shift+Z", redoes) {
        state.redo();
    }
    ui.separator();
    if item(ui, "copy and print as TOML", "P", true) {
        commands.push(Command::PrintCamera);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_items_are_in_rows_that_fit() {
        let widths = Widths::default();
        for compares in [false, true] {
            let n_items = if compares { 10 } else { 9 };
            let mut n_rows = usize::MAX;
            for width in (150..2600).step_by(10) {
                let rows = widths.rows(compares, width as f32);
                assert_eq!(rows.iter().flatten().count(), n_items);
                for row in &rows {
                    let items: f32 = row.iter().map(|item| widths.of(*item)).sum();
                    assert!(items + GAP * (row.len() - 1) as f32 <= width as f32);
                }
                assert!(rows.len() <= n_rows, "a wider window needs no more rows");
                n_rows = rows.len();
            }
            assert_eq!(n_rows, 1);
        }
    }
}
