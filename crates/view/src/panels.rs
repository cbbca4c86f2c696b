//! The panels around and over the picture.

use eframe::egui;
use egui::{
    Align2, Color32, Frame, Margin, Panel, Pos2, Rect, RichText, ScrollArea, Stroke, StrokeKind,
    Ui, vec2,
};
use kugelblitz_judge::explain::six_digits;
use kugelblitz_judge::show::{Entry, Show};

use super::bar::bar;
use super::controls;
use super::explanation::explanation;
use super::overlay;
use super::state::{State, WindowCommand, point};

/// Height of the lines below the picture, points.
const LINES: f32 = 46.0;

/// Distance of what lies over the picture from its edges, points.
pub const INSET: f32 = 12.0;

/// Side of a colour in the legend, points.
const SWATCH: f32 = 13.0;

/// In a picture that is narrower, the legend is short and gives way to explanations, points.
const NARROW: f32 = 600.0;

/// All controls, as the help lists them.
const HELP: [(&str, &str); 25] = [
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
    ("P", "copy the camera as TOML, and print it"),
    ("drop a file on the window", "open it"),
    ("Ctrl + S", "save what is shown, at full resolution"),
    ("K, shift + K", "next kernel, on the right and on the left"),
    ("C", "two kernels side by side"),
    ("drag the divider", "more of one, less of the other"),
    ("V, shift + V", "what is shown: next, previous"),
    ("F1 … F7", "color, depth, normal, id, discriminant, error, stage"),
    ("L", "the scene's light on and off"),
    ("N, shift + N", "more samples a pixel, fewer"),
    ("O", "panels on and off"),
    ("H or ?", "this help"),
    ("Esc", "close what is open"),
    ("Ctrl + Q", "quit"),
    ("rings", "pixels of a meaning that has few"),
];

/// Lays out the whole window.
pub fn layout(ui: &mut Ui, state: &mut State) {
    controls::keys(ui, state);
    if state.has_panels {
        let panel = |panel: Panel, ui: &Ui| {
            let frame = Frame::side_top_panel(ui.style()).inner_margin(Margin::symmetric(10, 5));
            panel.resizable(false).frame(frame)
        };
        panel(Panel::top("bar"), ui).show(ui, |ui| bar(ui, state));
        panel(Panel::bottom("lines").exact_size(LINES), ui).show(ui, |ui| lines(ui, state));
    }
    let rect = ui.available_rect_before_wrap();
    controls::picture(ui, rect, state);
    overlay::few(ui, rect, state);
    if state.is_moving {
        overlay::guides(ui, rect, state);
    }
    if state.has_panels {
        legend(ui, rect, state);
    }
    notices(ui, rect, state);
    explanation(ui, rect, state);
    help(ui, rect, state);
    let dropped = ui.input(|input| Some(input.raw.dropped_files.first()?.path().to_owned()));
    state.commands.extend(dropped.map(WindowCommand::Open));
}

/// Height of what stands above and below the picture in a window of this width, points.
pub fn around(context: &egui::Context, state: &mut State, width: f32) -> f32 {
    let screen = Rect::from_min_size(Pos2::ZERO, vec2(width, 1000.0));
    let input = egui::RawInput { screen_rect: Some(screen), ..egui::RawInput::default() };
    let _ = context.run_ui(input, |ui| layout(ui, state));
    screen.height() - state.area.height as f32
}

/// Something over the picture that the pointer goes through.
fn plate(ui: &Ui, id: &str, (pivot, at): (Align2, Pos2), add: impl FnOnce(&mut Ui)) {
    let frame = Frame::popup(ui.style())
        .fill(ui.visuals().window_fill.gamma_multiply(0.94))
        .inner_margin(Margin::symmetric(12, 8));
    let area = egui::Area::new(egui::Id::unique(id)).pivot(pivot).fixed_pos(at);
    area.interactable(false).show(ui.ctx(), |ui| frame.show(ui, add));
}

fn lines(ui: &mut Ui, state: &State) {
    ui.spacing_mut().item_spacing.y = 3.0;
    ui.spacing_mut().interact_size.y = 0.0;
    // A line that doesn't fit must not push at the picture.
    let line = |ui: &mut Ui, text: RichText| ui.add(egui::Label::new(text).truncate());
    match (state.message(), &state.hover) {
        (Some((message, left)), _) => {
            line(ui, RichText::new(message).strong());
            ui.ctx().request_repaint_after(left);
        }
        (None, Some(_)) => drop(line(ui, hover_text(state).into())),
        (None, None) => {
            let hint = "drag to orbit · click a pixel to ask why · H for help";
            line(ui, hint.into());
        }
    }
    let color = ui.visuals().text_color().gamma_multiply(0.75);
    line(ui, RichText::new(status_text(state)).color(color));
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
    let mut parts = vec![state.device.label()];
    if let Some(frame) = &state.frame {
        let (pixels, counts) = (&frame.order.pixels, &frame.counts);
        let seconds = frame.time.as_secs_f64();
        parts.push(format!("{} × {}", pixels.width, pixels.height));
        match state.frame_ms {
            Some(ms) => parts.push(format!("{ms:.0} ms a frame, tracing {:.1}", seconds * 1e3)),
            None => parts.push(format!("tracing {:.1} ms", seconds * 1e3)),
        }
        parts.push(format!("{:.0} Mrays/s", counts.total() as f64 / seconds.max(1e-9) / 1e6));
        parts.push(format!("{} undecided by f32", counts.f64 + counts.exact));
    }
    let kernels: Vec<_> = state.shown_kernels().iter().map(|kernel| kernel.name()).collect();
    parts.push(kernels.join(" | "));
    if state.show == Show::Color {
        parts.extend(progress_text(state));
    }
    parts.join("  ·  ")
}

/// How far the picture is; `None` where it is whole.
fn progress_text(state: &State) -> Option<String> {
    state.ordered.as_ref().filter(|order| order.takes_long())?;
    match (state.share(), state.show) {
        (1.0.., _) => None,
        (0.0, Show::Color) => Some("flat colours until the camera rests".to_string()),
        (0.0, _) => Some("colours until the camera rests".to_string()),
        (share, _) => Some(format!("{:.0} % of it drawn", share * 100.0)),
    }
}

/// What the colours mean, and how many pixels of each meaning there are, of two kernels the left one's first.
fn legend(ui: &Ui, rect: Rect, state: &State) {
    let is_narrow = rect.width() < NARROW;
    if state.show == Show::Color || (is_narrow && state.explained.is_some()) {
        return;
    }
    let corner = rect.left_bottom() + vec2(INSET, -INSET);
    plate(ui, "legend", (Align2::LEFT_BOTTOM, corner), |ui| {
        ui.set_max_width((rect.width() - 4.0 * INSET).clamp(100.0, 440.0));
        ui.spacing_mut().interact_size.y = 15.0;
        ui.strong(state.show.name());
        if !is_narrow {
            ui.label(state.show.explanation());
        }
        for (i, entry) in state.legend().iter().enumerate() {
            ui.horizontal(|ui| {
                let [r, g, b] = entry.color;
                swatch(ui, Color32::from_rgb(r, g, b));
                ui.label(&entry.meaning);
                if let Some(counts) = counts_text(state, i) {
                    ui.weak(counts);
                }
            });
        }
        if let Some(text) = progress_text(state) {
            ui.weak(text);
        }
    });
}

/// A colour that is seen on the ground of either theme.
fn swatch(ui: &mut Ui, color: Color32) {
    let (square, _) = ui.allocate_exact_size(vec2(SWATCH, SWATCH), egui::Sense::hover());
    let edge = Stroke::new(1.0, ui.visuals().text_color().gamma_multiply(0.8));
    ui.painter().rect(square, 2.0, color, edge, StrokeKind::Inside);
}

/// `2 pixels`, or of two kernels `0 | 2 pixels`; `None` where they aren't counted.
fn counts_text(state: &State, entry: usize) -> Option<String> {
    let counted = |legend: &Vec<Entry>| Some(legend.get(entry)?.pixels?.to_string());
    let counts = state.legends().iter().map(counted);
    let counts = counts.collect::<Option<Vec<String>>>().filter(|counts| !counts.is_empty())?;
    let pixels = if counts == ["1"] { "pixel" } else { "pixels" };
    Some(format!("{} {pixels}", counts.join(" | ")))
}

/// The error of the scene file, and without panels what else there is to tell.
fn notices(ui: &Ui, rect: Rect, state: &State) {
    let text = match (&state.scene_error, state.message()) {
        (Some(error), _) if state.has_panels => {
            RichText::new(error).monospace().color(ui.visuals().error_fg_color)
        }
        (_, Some((message, left))) if !state.has_panels => {
            ui.ctx().request_repaint_after(left);
            RichText::new(message)
        }
        _ => return,
    };
    let corner = rect.left_top() + vec2(INSET, INSET);
    plate(ui, "notice", (Align2::LEFT_TOP, corner), |ui| {
        ui.set_max_width((rect.width() - 2.0 * INSET).max(100.0));
        ui.label(text);
    });
}

fn help(ui: &Ui, rect: Rect, state: &mut State) {
    if !state.has_help {
        return;
    }
    let window = egui::Window::new("Controls")
        .collapsible(false)
        .resizable(false)
        .pivot(Align2::CENTER_CENTER)
        .default_pos(rect.center())
        .constrain_to(rect);
    window.open(&mut state.has_help).show(ui.ctx(), |ui| {
        let height = (rect.height() - 80.0).max(60.0);
        ScrollArea::both().max_height(height).max_width(rect.width() - 60.0).show(ui, |ui| {
            let grid = egui::Grid::new("controls").num_columns(2);
            grid.spacing(vec2(24.0, 5.0)).show(ui, |ui| {
                for (control, what) in HELP {
                    ui.strong(control);
                    ui.label(what);
                    ui.end_row();
                }
            });
        });
    });
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use kugelblitz::device::Device;
    use kugelblitz::query::Kernel;
    use kugelblitz::scene::parse_scene;

    use super::*;

    fn state() -> State {
        let text = include_str!("../../../scenes/lit/figure1.toml");
        let scene = Arc::new(parse_scene(text, "figure1.toml".as_ref()).unwrap());
        State::new("figure1.toml".into(), scene, Device::Cpu, Kernel::Certified).unwrap()
    }

    /// The places of all that can be clicked above the picture in a window of this width.
    fn clickable(state: &mut State, width: f32) -> Vec<Rect> {
        let context = egui::Context::default();
        around(&context, state, width);
        let bottom = state.area.top as f32;
        context.viewport(|viewport| {
            let widgets = viewport.prev_pass.widgets.layers().flat_map(|(_, widgets)| widgets);
            let in_bar = widgets
                .filter(|widget| widget.sense.senses_click() && widget.rect.bottom() <= bottom);
            in_bar.map(|widget| widget.rect).collect()
        })
    }

    #[test]
    fn nothing_in_the_bar_overlaps_or_is_cut_off() {
        for width in [320.0, 360.0, 420.0, 500.0, 600.0, 640.0, 700.0, 900.0, 1280.0, 2560.0] {
            for compares in [false, true] {
                let mut state = state();
                state.compares = compares;
                let rects = clickable(&mut state, width);
                assert_eq!((state.area.left, state.area.width), (0, width as u32));
                assert!(state.area.height > 700, "{width}: {:?}", state.area);
                assert!(rects.len() >= if compares { 9 } else { 8 }, "{width}: {}", rects.len());
                for (i, rect) in rects.iter().enumerate() {
                    assert!(rect.left() >= 0.0 && rect.right() <= width, "{width}: {rect}");
                    for other in &rects[..i] {
                        let common = rect.intersect(*other);
                        let is_apart = common.width() <= 0.0 || common.height() <= 0.0;
                        assert!(is_apart || rect == other, "{width}: {rect} {other}");
                    }
                }
            }
        }
    }

    /// The keys between grave accents in the guide's table are in the help.
    #[test]
    fn the_help_has_the_keys_of_the_guide() {
        let guide = include_str!("../../../docs/guide/src/window.md");
        let table = guide.split_once("| control | does |").expect("the table").1;
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
