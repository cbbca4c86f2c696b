//! Mouse and keyboard → camera and state.

use eframe::egui;
use egui::{
    Align2, Color32, CursorIcon, Event, Key, MouseWheelUnit, PointerButton, Rect, Response, Sense,
    Ui, ViewportCommand, pos2,
};
use glam::{DVec2, DVec3, Vec2};
use kugelblitz_judge::show::Show;

use super::overlay;
use super::rig::SIDES;
use super::state::{Area, State, WindowCommand};

/// Orbiting by a drag over the whole height of the picture, radians.
const ORBIT_OF_HEIGHT: f64 = std::f64::consts::PI;

/// Part of the distance that is left after one step of the wheel.
const ZOOM_STEP: f64 = 0.85;

/// Points that a touchpad scrolls for one step of a wheel.
const POINTS_OF_STEP: f64 = 40.0;

/// Radii of the scene that flying takes in a second.
const FLY_SPEED: f64 = 0.6;

/// How many times faster it is with shift.
const FAST: f64 = 4.0;

/// Most time that one step of flying stands for, seconds, and what a touch of a key stands for.
const FLY_STEPS: [f64; 2] = [0.1, 1.0 / 30.0];

/// Half the width in which the divider can be taken, points.
const GRIP: f32 = 6.0;

/// From the divider to the names of the kernels, points.
const APART: f32 = 17.0;

/// All keys. A key counts with what was held when it was pressed: it may be free again by now.
pub fn keys(ui: &Ui, state: &mut State) {
    state.is_moving = false;
    let mut begins = false;
    for event in ui.input(|input| input.events.clone()) {
        let Event::Key { key, pressed: true, repeat: false, modifiers, .. } = event else {
            continue;
        };
        begins = true;
        match key {
            _ if !modifiers.command => {
                state.flying.push(key);
                press(key, modifiers.shift, state);
            }
            Key::S => state.commands.push(WindowCommand::Save),
            Key::Q => ui.ctx().send_viewport_cmd(ViewportCommand::Close),
            _ => {}
        }
    }
    fly(ui, begins, state);
    state.flying.retain(|&key| ui.input(|input| input.key_down(key)));
}

fn press(key: Key, shift: bool, state: &mut State) {
    // `1` is the first side, and `F1` the first of what can be shown.
    let number = |name: &str| name.parse::<usize>().ok()?.checked_sub(1);
    if let Some((_, to_eye)) = number(key.name()).and_then(|i| SIDES.get(i)) {
        state.look_from(*to_eye);
    }
    let function = key.name().strip_prefix('F').and_then(number);
    if let Some(show) = function.and_then(|i| Show::ALL.get(i)) {
        state.show = *show;
    }
    match key {
        Key::F => state.frame_everything(),
        Key::R => state.take_file_camera(),
        Key::P => state.commands.push(WindowCommand::PrintCamera),
        Key::K => {
            let place = usize::from(!(shift && state.compares));
            state.kernels[place] = state.kernel_after(state.kernels[place]);
        }
        Key::C => state.toggle_compare(),
        Key::V => state.show = state.show.step(!shift),
        Key::L => state.has_light = !state.has_light,
        Key::N => state.step_samples(!shift),
        Key::O => state.has_panels = !state.has_panels,
        Key::H | Key::Questionmark => state.has_help = !state.has_help,
        Key::Escape if state.has_help => state.has_help = false,
        Key::Escape => state.explained = None,
        _ => {}
    }
}

fn fly(ui: &Ui, begins: bool, state: &mut State) {
    let held = |key| f64::from(u8::from(state.flying.contains(&key)));
    let axes = [(Key::D, Key::A), (Key::E, Key::Q), (Key::W, Key::S)];
    let direction = DVec3::from_array(axes.map(|(plus, minus)| held(plus) - held(minus)));
    if direction == DVec3::ZERO {
        return;
    }
    let [longest, touch] = FLY_STEPS;
    let seconds = match begins {
        // Before the first step nobody held a key.
        true => touch,
        false => f64::from(ui.input(|input| input.unstable_dt)).min(longest),
    };
    let faster = if ui.input(|input| input.modifiers.shift) { FAST } else { 1.0 };
    state.is_moving = true;
    state.rig.fly(direction * (FLY_SPEED * faster * seconds * state.extent.radius));
    ui.ctx().request_repaint();
}

/// Follows the mouse over the picture: drags, clicks, the wheel, and what is under the pointer.
pub fn picture(ui: &mut Ui, rect: Rect, state: &mut State) {
    let response = ui.allocate_rect(rect, Sense::click_and_drag());
    // What the hand meant is what was shown: the window may have another size by now. Its points are of now.
    state.area.scale = ui.pixels_per_point();
    let divider = state.compares.then(|| divide(ui, rect, state));
    match &divider {
        Some(divider) if divider.dragged() => state.pointed = None,
        _ => mouse(ui, &response, state),
    }
    state.area = Area::of(rect, ui.pixels_per_point());
    state.paint(&ui.painter_at(rect));
    if let Some(divider) = divider {
        draw_divider(ui, rect, state, divider.dragged() || divider.hovered());
    }
}

fn mouse(ui: &Ui, response: &Response, state: &mut State) {
    state.pointed = None;
    state.is_moving |= response.dragged();
    drag(ui, response, state);
    let Some(at) = response.hover_pos() else {
        state.hover = None;
        return;
    };
    let Some(at) = state.area.place(at) else { return };
    let pixel = at.as_uvec2().to_array();
    wheel(ui, at, pixel, state);
    if response.double_clicked() {
        state.explained = None;
        match state.known(pixel) {
            Some(_) => state.set_pivot(),
            None => state.pivot_wanted = Some(pixel),
        }
    } else if response.clicked() {
        state.commands.push(WindowCommand::Explain(state.question(pixel)));
    }
    state.pointed = (!response.dragged()).then(|| state.question(pixel));
}

fn drag(ui: &Ui, response: &Response, state: &mut State) {
    // It begins where the button was pressed, not where it was no click any more.
    let delta = match response.drag_started() {
        true => response.total_drag_delta().unwrap_or_default(),
        false => response.drag_delta(),
    };
    if delta == egui::Vec2::ZERO {
        return;
    }
    let by = Vec2::from_array(delta.into()).as_dvec2() * f64::from(state.area.scale);
    let height = f64::from(state.area.height.max(1));
    let shift = ui.input(|input| input.modifiers.shift);
    let pans = response.dragged_by(PointerButton::Middle)
        || response.dragged_by(PointerButton::Primary) && shift;
    if pans {
        state.rig.pan(by, height);
    } else if response.dragged_by(PointerButton::Primary) {
        let turn = by * (ORBIT_OF_HEIGHT / height);
        // What is in front follows the pointer.
        state.rig.orbit(-turn.x, -turn.y);
    }
}

fn wheel(ui: &Ui, at: DVec2, pixel: [u32; 2], state: &mut State) {
    let steps: f64 = ui.input(|input| {
        let steps = input.events.iter().map(|event| match event {
            Event::MouseWheel { unit: MouseWheelUnit::Point, delta, .. } => {
                f64::from(delta.y) / POINTS_OF_STEP
            }
            Event::MouseWheel { delta, .. } => f64::from(delta.y),
            _ => 0.0,
        });
        steps.sum()
    });
    if steps == 0.0 {
        return;
    }
    let known = state.known(pixel).filter(|answer| answer.id != 0);
    let depth = known.map_or_else(|| state.rig.pivot_depth(), |answer| f64::from(answer.t));
    let across = state.rig.across(at, state.area.size());
    state.rig.zoom(across, depth, ZOOM_STEP.powf(steps));
}

/// Moves the line between two kernels.
fn divide(ui: &Ui, rect: Rect, state: &mut State) -> Response {
    let x = state.divider_x();
    let grip = Rect::from_x_y_ranges(x - GRIP..=x + GRIP, rect.y_range());
    let response = ui
        .interact(grip, egui::Id::unique("divider"), Sense::drag())
        .on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
    if let Some(at) = response.interact_pointer_pos()
        && (response.dragged() || response.drag_stopped())
    {
        state.divider = egui::remap_clamp(at.x, rect.x_range(), 0.0..=1.0);
    }
    response
}

fn draw_divider(ui: &Ui, rect: Rect, state: &State, is_held: bool) {
    let (painter, x) = (ui.painter_at(rect), state.divider_x());
    let ends = [rect.top(), rect.bottom()].map(|y| pos2(x, y));
    let alpha = if is_held { 255 } else { 200 };
    overlay::line(&painter, ends, 1.0, Color32::from_white_alpha(alpha));
    if state.has_panels {
        let sides = [(Align2::RIGHT_CENTER, -APART), (Align2::LEFT_CENTER, APART)];
        for (kernel, (align, aside)) in state.kernels.iter().zip(sides) {
            let at = pos2(x + aside, rect.bottom() - 24.0);
            overlay::text(&painter, at, align, kernel.name(), Color32::WHITE);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use egui::{Modifiers, Pos2, RawInput};
    use kugelblitz::device::Device;
    use kugelblitz::prepare::Prepared;
    use kugelblitz::query::{Kernel, Rays};
    use kugelblitz::scene::parse_scene;

    use egui::vec2;

    use super::*;
    use crate::panels;
    use crate::rig::Rig;
    use crate::turns::Turns;

    const FIGURE5: &str = include_str!("../../../scenes/figure5.toml");

    fn state() -> State {
        let path = Path::new("figure5.toml");
        let scene = Arc::new(parse_scene(FIGURE5, path).unwrap());
        State::new(path.into(), scene, Device::Cpu, Kernel::Certified).unwrap()
    }

    /// The frames of a window of this size in which this is carried out.
    fn frames(
        context: &egui::Context,
        state: &mut State,
        size: [f32; 2],
        events: Vec<Event>,
    ) -> Vec<WindowCommand> {
        let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, size.into()));
        let mut input = RawInput { screen_rect, events, ..RawInput::default() };
        let mut turns = Turns::default();
        loop {
            turns.give(&mut input);
            input.time = None;
            let next = RawInput { screen_rect, ..RawInput::default() };
            let now = std::mem::replace(&mut input, next);
            let _ = context.run_ui(now, |ui| panels::layout(ui, state));
            if !turns.taken() {
                return std::mem::take(&mut state.commands);
            }
        }
    }

    fn button(at: Pos2, pressed: bool) -> Event {
        let (button, modifiers) = (PointerButton::Primary, Modifiers::NONE);
        Event::PointerButton { pos: at, button, pressed, modifiers }
    }

    /// Where the window changes in the frame of the click, the pixel that was seen is explained.
    #[test]
    fn a_click_asks_about_what_was_clicked() {
        let (context, mut state) = (egui::Context::default(), state());
        let (large, small) = ([800.0, 600.0], [400.0, 300.0]);
        let at = pos2(700.0, 500.0);
        // A window shows something before it is clicked.
        frames(&context, &mut state, large, Vec::new());
        let away = pos2(100.0, 100.0);
        let click = [Event::PointerMoved(at), button(at, true), button(at, false)];
        let and_away = [&click[..], &[Event::PointerMoved(away)]].concat();
        let (scene, pixels) = (Arc::clone(&state.scene), state.pixels());
        // The window becomes smaller in the frame of the click.
        let commands = frames(&context, &mut state, small, and_away);
        assert_ne!(state.pixels(), pixels);
        let asked = commands.into_iter().find_map(|command| match command {
            WindowCommand::Explain(question) => Some(question),
            _ => None,
        });
        let asked = asked.expect("a question");
        let [whole, pixel] = [asked.pixel.picture(), asked.pixel].map(Rays::Pixels);
        let prepared = Prepared::new(Arc::clone(&asked.scene), asked.kernel, &whole).unwrap();
        prepared.check(&pixel).expect("a pixel of its own picture");
        assert!(Arc::ptr_eq(&asked.scene, &scene));
        assert_eq!(asked.pixel.picture(), pixels);
    }
    /// A whole drag in one frame turns the camera as far as one whose moves have a frame each.
    #[test]
    fn a_drag_goes_as_far_as_the_hand() {
        let ends = [pos2(300.0, 300.0), pos2(420.0, 300.0)];
        let half = ends[0].lerp(ends[1], 0.5);
        let moves = [ends[0] + vec2(2.0, 0.0), half, ends[1]].map(Event::PointerMoved);
        let drag = [&[button(ends[0], true)][..], &moves, &[button(ends[1], false)]].concat();
        let positions = [drag.len(), 1].map(|in_a_frame| {
            let (context, mut state) = (egui::Context::default(), state());
            frames(&context, &mut state, [800.0, 600.0], vec![Event::PointerMoved(ends[0])]);
            for events in drag.chunks(in_a_frame) {
                frames(&context, &mut state, [800.0, 600.0], events.to_vec());
            }
            let turned = ORBIT_OF_HEIGHT * 120.0 / f64::from(state.area.height);
            let mut expected = Rig::new(state.scene.camera.as_ref().unwrap());
            expected.orbit(-turned, 0.0);
            assert!(state.rig.camera.position.distance(expected.camera.position) < 1e-9);
            state.rig.camera.position
        });
        assert!(positions[0].distance(positions[1]) < 1e-9);
    }
}
