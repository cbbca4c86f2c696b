//! The bar above the picture, in as many rows as it needs.

use eframe::egui;
use egui::{Button, Ui};
use kugelblitz::device::Device;
use kugelblitz::query::Kernel;
use kugelblitz::scene::Samples;
use kugelblitz_judge::show::Show;

use super::rig::SIDES;
use super::state::{SAMPLES, State, WindowCommand};

/// The whole bar.
pub fn bar(ui: &mut Ui, state: &mut State) {
    ui.horizontal_wrapped(|ui| {
        if state.compares {
            kernel_menu(ui, &mut state.kernels[0], &state.device);
        }
        kernel_menu(ui, &mut state.kernels[1], &state.device);
        let compare = ui.add(toggle("compare", state.compares));
        if compare.on_hover_text("Two kernels side by side (C)").clicked() {
            state.toggle_compare();
        }
        choice(ui, "show", state.show.name(), "What is shown (V, shift + V)", |ui| {
            for (i, show) in Show::ALL.into_iter().enumerate() {
                let name = format!("{}   F{}", show.name(), i + 1);
                ui.selectable_value(&mut state.show, show, name).on_hover_text(show.explanation());
            }
        });
        let is_lit = state.scene.is_lit();
        let light = ui.add_enabled(is_lit, toggle("light", state.has_light && is_lit));
        let light = light.on_hover_text("The scene's light on or off (L)");
        if light.on_disabled_hover_text("The scene has no light").clicked() {
            state.has_light = !state.has_light;
        }
        let chosen = samples_text(state.n_samples);
        choice(ui, "samples", &chosen, "Samples a pixel (N, shift + N)", |ui| {
            for n in SAMPLES {
                ui.selectable_value(&mut state.n_samples, n, samples_text(n));
            }
        });
        ui.menu_button("camera", |ui| camera_menu(ui, state));
        if ui.button("save").on_hover_text("Save what is shown (Ctrl+S)").clicked() {
            state.commands.push(WindowCommand::Save);
        }
        if ui.add(toggle("help", state.has_help)).on_hover_text("All controls (H)").clicked() {
            state.has_help = !state.has_help;
        }
    });
}

/// A button that opens a list, with what is chosen of it.
fn choice(ui: &mut Ui, of: &str, chosen: &str, tip: &str, list: impl FnOnce(&mut Ui)) {
    ui.menu_button(format!("{of}: {chosen}"), list).response.on_hover_text(tip);
}

/// A button that stays down.
fn toggle(name: &str, is_on: bool) -> Button<'_> {
    Button::selectable(is_on, name).frame_when_inactive(true)
}

fn kernel_menu(ui: &mut Ui, kernel: &mut Kernel, device: &Device) {
    choice(ui, "kernel", kernel.name(), "Kernel (K, shift + K)", |ui| {
        for known in device.kernels() {
            ui.selectable_value(kernel, known, known.name());
        }
    });
}

fn samples_text(samples: Samples) -> String {
    format!("{0} × {0}", samples.across())
}

fn item(ui: &mut Ui, name: &str, key: &str) -> bool {
    ui.add(Button::new(name).shortcut_text(key)).clicked()
}

fn camera_menu(ui: &mut Ui, state: &mut State) {
    if item(ui, "frame everything", "F") {
        state.frame_everything();
    }
    for (i, (name, to_eye)) in SIDES.into_iter().enumerate() {
        if item(ui, &format!("from {name}"), &(i + 1).to_string()) {
            state.look_from(to_eye);
        }
    }
    if item(ui, "the file's camera", "R") {
        state.take_file_camera();
    }
    ui.separator();
    if item(ui, "copy and print as TOML", "P") {
        state.commands.push(WindowCommand::PrintCamera);
    }
}
