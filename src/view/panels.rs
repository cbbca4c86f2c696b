//! The panels around and over the picture.

use egui::{
    Align, Align2, Color32, ComboBox, CornerRadius, Frame, Layout, Margin, Panel, RichText,
    ScrollArea, Ui, vec2,
};

use super::controls::{self, next_theme};
use super::paint;
use super::rig::Axis;
use super::show::Show;
use super::state::{Area, Command, Explained, SAMPLES, State, point, six_digits};
use crate::trace::Kernel;

/// Heights of the bar above and of the lines below the picture, points.
pub const BAR: f32 = 36.0;
/// The same.
pub const LINES: f32 = 46.0;

/// Distance of what lies over the picture from its edges, points.
const INSET: f32 = 12.0;

/// All controls, as the help lists them.
const HELP: [(&str, &str); 24] = [
    ("left drag", "orbit around the pivot"),
    ("middle or shift + left drag", "pan"),
    ("wheel", "zoom toward the pointer"),
    ("double click", "set the pivot on what is hit"),
    ("click", "explain the pixel"),
    ("Ctrl + C", "copy the explanation"),
    ("W A S D, Q E", "fly: forward, left, back, right, down, up; shift: faster"),
    ("F", "frame everything"),
    ("1 2 3, 4 5 6", "look from +x +y +z, from −x −y −z"),
    ("R", "back to the file's camera"),
    ("P", "print the camera as TOML"),
    ("Ctrl + S", "save the picture at full resolution, with this light and samples"),
    ("K, shift + K", "next kernel, on the right and on the left"),
    ("C", "two kernels side by side"),
    ("drag the divider", "more of one, less of the other"),
    ("V, shift + V", "what is shown: next, previous"),
    ("F1 … F8", "colour, depth, normal, id, side, discriminant, error, stage"),
    ("L", "the scene's light on and off"),
    ("N, shift + N", "more samples a pixel, fewer"),
    ("T", "light, dark, or as the system"),
    ("O", "panels on and off"),
    ("H or ?", "this help"),
    ("Esc", "close what is open"),
    ("Ctrl + Q", "quit"),
];

/// Lays out the whole window; gives what else is to be done.
pub fn layout(ui: &mut Ui, state: &mut State) -> Vec<Command> {
    let mut commands = Vec::new();
    controls::keys(ui, state, &mut commands);
    if state.has_panels {
        Panel::top("bar")
            .exact_size(BAR)
            .frame(bar_frame(ui))
            .show(ui, |ui| bar(ui, state, &mut commands));
        Panel::bottom("lines").exact_size(LINES).frame(bar_frame(ui)).show(ui, |ui| {
            lines(ui, state);
        });
    }
    let rect = ui.available_rect_before_wrap();
    state.area = to_pixels(rect, ui.pixels_per_point());
    controls::picture(ui, rect, state, &mut commands);
    if state.has_panels {
        legend(ui, rect, state);
        notices(ui, rect, state);
    }
    explanation(ui, rect, state);
    help(ui, rect, state);
    commands
}

/// The pixels whose edges are next to the rectangle's.
fn to_pixels(rect: egui::Rect, pixels_per_point: f32) -> Area {
    let [left, top, right, bottom] = [rect.left(), rect.top(), rect.right(), rect.bottom()]
        .map(|edge| (edge * pixels_per_point).round().max(0.0) as u32);
    let (width, height) = (right.saturating_sub(left), bottom.saturating_sub(top));
    Area { left, top, width, height }
}

fn bar_frame(ui: &Ui) -> Frame {
    Frame::new().fill(ui.visuals().panel_fill).inner_margin(Margin::symmetric(10, 4))
}

fn over_picture(ui: &Ui) -> Frame {
    Frame::new()
        .fill(ui.visuals().window_fill.gamma_multiply(0.94))
        .stroke(ui.visuals().window_stroke)
        .corner_radius(CornerRadius::same(6))
        .inner_margin(Margin::symmetric(12, 8))
}

fn bar(ui: &mut Ui, state: &mut State, commands: &mut Vec<Command>) {
    ui.horizontal_centered(|ui| {
        ui.spacing_mut().item_spacing.x = 8.0;
        if state.compares {
            kernel_box(ui, "left kernel", &mut state.kernels[0], &state.offered);
            ui.weak("against");
        }
        kernel_box(ui, "kernel", &mut state.kernels[1], &state.offered);
        let tip = "Two kernels side by side (C)";
        if ui.selectable_label(state.compares, "compare").on_hover_text(tip).clicked() {
            state.toggle_compare();
        }
        ui.separator();
        ComboBox::from_id_salt("show").width(116.0).selected_text(state.show.name()).show_ui(
            ui,
            |ui| {
                for (i, show) in Show::ALL.into_iter().enumerate() {
                    let name = format!("{}   F{}", show.name(), i + 1);
                    ui.selectable_value(&mut state.show, show, name)
                        .on_hover_text(show.explanation());
                }
            },
        );
        light(ui, state);
        ui.separator();
        ui.menu_button("camera", |ui| camera_menu(ui, state, commands));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui.selectable_label(state.has_help, "help").on_hover_text("H").clicked() {
                state.has_help = !state.has_help;
            }
            if ui.button(theme_name(ui)).on_hover_text("Light or dark (T)").clicked() {
                next_theme(ui);
            }
        });
    });
}

fn light(ui: &mut Ui, state: &mut State) {
    let (is_lit, is_on) = (state.scene.is_lit(), state.has_light && state.scene.is_lit());
    let label = egui::Button::selectable(is_on, "light");
    let tip = "The scene's light on or off (L)";
    let response = ui.add_enabled(is_lit, label).on_hover_text(tip);
    if response.on_disabled_hover_text("The scene has no light").clicked() {
        state.has_light = !state.has_light;
    }
    ComboBox::from_id_salt("samples")
        .width(58.0)
        .selected_text(samples_text(state.n_samples))
        .show_ui(ui, |ui| {
            for n in SAMPLES {
                ui.selectable_value(&mut state.n_samples, n, samples_text(n));
            }
        })
        .response
        .on_hover_text("Samples a pixel (N, shift + N)");
}

fn samples_text(n: u32) -> String {
    format!("{n} × {n}")
}

fn kernel_box(ui: &mut Ui, id: &str, kernel: &mut Kernel, offered: &[Kernel]) {
    ComboBox::from_id_salt(id).width(92.0).selected_text(kernel.name()).show_ui(ui, |ui| {
        for &known in offered {
            ui.selectable_value(kernel, known, known.name());
        }
    });
}

fn theme_name(ui: &Ui) -> &'static str {
    match ui.options(|options| options.theme_preference) {
        egui::ThemePreference::Dark => "dark",
        egui::ThemePreference::Light => "light",
        egui::ThemePreference::System => "system",
    }
}

fn camera_menu(ui: &mut Ui, state: &mut State, commands: &mut Vec<Command>) {
    let item = |ui: &mut Ui, name: &str, key: &str| {
        ui.add(egui::Button::new(name).shortcut_text(key)).clicked()
    };
    if item(ui, "frame everything", "F") {
        state.rig.frame(state.extent, state.aspect());
    }
    for (i, axis) in Axis::ALL.into_iter().enumerate() {
        if item(ui, &format!("from {}", axis.name), &(i + 1).to_string()) {
            state.rig.look_along(axis, state.extent, state.aspect());
        }
    }
    if item(ui, "the file's camera", "R") {
        state.go_home();
    }
    ui.separator();
    if item(ui, "print as TOML", "P") {
        commands.push(Command::PrintCamera);
    }
    if item(ui, "save the picture", "Ctrl+S") {
        commands.push(Command::Save);
    }
}

fn lines(ui: &mut Ui, state: &State) {
    ui.spacing_mut().item_spacing.y = 3.0;
    let above = match &state.hover {
        Some(_) => hover_text(state),
        None => "drag to orbit · click a pixel to ask why · H for help".into(),
    };
    let color = ui.visuals().text_color().gamma_multiply(0.75);
    // A line that doesn't fit must not push at the picture.
    ui.add(egui::Label::new(above).truncate());
    ui.add(egui::Label::new(RichText::new(status_text(state)).color(color)).truncate());
}

/// `pixel 640, 360 · sphere 2 (touched) · t = 24 · (0, 0, -24)`
pub fn hover_text(state: &State) -> String {
    let Some(answer) = &state.hover else { return String::new() };
    let [x, y] = answer.pixel;
    if answer.id == 0 {
        return format!("pixel {x}, {y} · background");
    }
    let t = six_digits(f64::from(answer.t));
    format!("pixel {x}, {y} · id {}, {} · t = {t} · {}", answer.id, answer.label, point(answer))
}

/// Device, size, speed, undecided rays, kernel.
fn status_text(state: &State) -> String {
    let mut parts = vec![state.device.clone()];
    if let Some(picture) = &state.picture {
        let pixels = &picture.order.pixels;
        let n_rays = pixels.len() * picture.ids.len();
        let seconds = picture.time.as_secs_f64();
        parts.push(format!("{} × {}", pixels.width, pixels.height));
        match state.frame_ms {
            Some(ms) => parts.push(format!("{ms:.0} ms a frame, tracing {:.1}", seconds * 1e3)),
            None => parts.push(format!("tracing {:.1} ms", seconds * 1e3)),
        }
        parts.push(format!("{:.0} Mrays/s", n_rays as f64 / seconds.max(1e-9) / 1e6));
        let progress = picture.progress();
        let undecided = match progress.left {
            0 => format!("{} undecided by f32", progress.undecided),
            left => format!("{} undecided by f32, {left} still open", progress.undecided),
        };
        parts.push(undecided);
    }
    let kernels: Vec<_> = state.shown_kernels().iter().map(|kernel| kernel.name()).collect();
    parts.push(kernels.join(" | "));
    if state.show == Show::Color {
        parts.extend(painting_text(state));
    }
    parts.join("  ·  ")
}

/// How far painting is; `None` where there is nothing to paint, or nothing any more.
fn painting_text(state: &State) -> Option<String> {
    let is_open = state.look().is_painted() && !state.is_settled();
    is_open.then(|| match (state.painted_share(), state.show) {
        (0.0, Show::Color) => "flat colours until the camera rests".to_string(),
        (0.0, _) => "colours until the camera rests".to_string(),
        (share, _) => format!("{:.0} % of it painted", share * 100.0),
    })
}

fn legend(ui: &Ui, rect: egui::Rect, state: &State) {
    if state.show == Show::Color {
        return;
    }
    egui::Area::new(egui::Id::unique("legend"))
        .pivot(Align2::LEFT_BOTTOM)
        .fixed_pos(rect.left_bottom() + vec2(INSET, -INSET))
        .interactable(false)
        .show(ui.ctx(), |ui| {
            over_picture(ui).show(ui, |ui| {
                ui.spacing_mut().interact_size.y = 15.0;
                ui.strong(state.show.name());
                ui.label(state.show.explanation());
                for (color, meaning) in paint::legend(state.show) {
                    ui.horizontal(|ui| {
                        let (square, _) =
                            ui.allocate_exact_size(vec2(11.0, 11.0), egui::Sense::hover());
                        let [r, g, b] = color;
                        ui.painter().rect_filled(square, 2.0, Color32::from_rgb(r, g, b));
                        ui.label(meaning);
                    });
                }
                if let Some(text) = painting_text(state) {
                    ui.weak(text);
                }
            });
        });
}

fn notices(ui: &Ui, rect: egui::Rect, state: &State) {
    let mut corner = rect.left_top() + vec2(INSET, INSET);
    let mut notice = |id: &str, text: RichText| {
        let shown = egui::Area::new(egui::Id::unique(id))
            .fixed_pos(corner)
            .interactable(false)
            .show(ui.ctx(), |ui| {
                ui.set_max_width((rect.width() - 2.0 * INSET).max(100.0));
                over_picture(ui).show(ui, |ui| ui.label(text));
            });
        corner.y = shown.response.rect.bottom() + 6.0;
    };
    if let Some(error) = &state.scene_error {
        let color = ui.visuals().error_fg_color;
        notice("scene error", RichText::new(error).monospace().color(color));
    }
    if let Some((message, left)) = state.message() {
        notice("message", RichText::new(message));
        ui.ctx().request_repaint_after(left);
    }
}

fn explanation(ui: &Ui, rect: egui::Rect, state: &mut State) {
    let Some(Explained { pixel: [x, y], text }) = &state.explained else { return };
    let mut is_open = true;
    let size = (rect.size() * vec2(0.56, 0.86)).min(vec2(740.0, 720.0));
    egui::Window::new(format!("Why pixel {x}, {y}?"))
        .id(egui::Id::unique("explanation"))
        .open(&mut is_open)
        .collapsible(false)
        .default_size(size)
        .default_pos(rect.right_top() + vec2(-size.x - 2.0 * INSET, INSET))
        .constrain_to(rect)
        .show(ui.ctx(), |ui| {
            let Some(text) = text else {
                ui.weak("calculating …");
                return;
            };
            if ui.button("copy").on_hover_text("Ctrl+C").clicked() {
                ui.ctx().copy_text(text.clone());
            }
            ui.separator();
            ScrollArea::both().auto_shrink(false).show(ui, |ui| {
                let text = RichText::new(text).monospace().size(11.5);
                ui.add(egui::Label::new(text).extend());
            });
        });
    if !is_open {
        state.explained = None;
    }
}

fn help(ui: &Ui, rect: egui::Rect, state: &mut State) {
    if !state.has_help {
        return;
    }
    egui::Window::new("Controls")
        .id(egui::Id::unique("help"))
        .open(&mut state.has_help)
        .collapsible(false)
        .resizable(false)
        .pivot(Align2::CENTER_CENTER)
        .default_pos(rect.center())
        .constrain_to(rect)
        .show(ui.ctx(), |ui| {
            egui::Grid::new("controls").num_columns(2).spacing(vec2(24.0, 5.0)).show(ui, |ui| {
                for (control, what) in HELP {
                    ui.strong(control);
                    ui.label(what);
                    ui.end_row();
                }
            });
        });
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The keys between grave accents in the README's table are in the help.
    #[test]
    fn the_help_has_the_keys_of_the_readme() {
        let readme = include_str!("../../README.md");
        let table = readme.split_once("| control | does |").expect("the table").1;
        let rows = table.lines().skip(2).take_while(|line| line.starts_with('|'));
        let marked = rows.flat_map(|row| row.split('`').skip(1).step_by(2));
        // The other marked words are commands.
        let keys: Vec<&str> = marked.filter(|word| !word.starts_with(char::is_lowercase)).collect();
        assert!(keys.len() > 20 && keys.contains(&"L") && keys.contains(&"N"), "{keys:?}");
        let controls = HELP.map(|(control, _)| control);
        let is_told = |key: &str| {
            let words = controls.iter().flat_map(|control| control.split([' ', ',']));
            key.split('+').all(|part| words.clone().any(|word| word == part))
        };
        assert_eq!(keys.into_iter().filter(|key| !is_told(key)).collect::<Vec<_>>(), [""; 0]);
        assert!(!is_told("X") && !is_told("Ctrl+X"));
    }
}
