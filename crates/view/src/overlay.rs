//! What is drawn over the picture: marks of pixels, and guides while the camera moves.

use eframe::egui;
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, Ui, Vec2, vec2};
use glam::DVec3;

use super::state::State;

/// Radius of the ring around a marked pixel, points.
const RING: f32 = 9.0;

/// Length of the lines that lead to it.
const TICK: f32 = 7.0;

/// Length of the axes, as a part of the picture's height.
const AXIS: f64 = 0.16;

const AXES: [(&str, DVec3, Color32); 3] = [
    ("x", DVec3::X, Color32::from_rgb(0xff, 0x5c, 0x5c)),
    ("y", DVec3::Y, Color32::from_rgb(0x6d, 0xd3, 0x5f)),
    ("z", DVec3::Z, Color32::from_rgb(0x6a, 0xa8, 0xff)),
];

/// A line that is seen on any ground.
pub fn line(painter: &Painter, ends: [Pos2; 2], width: f32, color: Color32) {
    painter.line_segment(ends, Stroke::new(width + 2.0, Color32::from_black_alpha(150)));
    painter.line_segment(ends, Stroke::new(width, color));
}

/// A ring that is seen on any ground.
fn ring(painter: &Painter, at: Pos2, radius: f32, color: Color32) {
    painter.circle_stroke(at, radius, Stroke::new(3.5, Color32::from_black_alpha(170)));
    painter.circle_stroke(at, radius, Stroke::new(1.5, color));
}

/// Text that is read on any ground.
pub fn text(painter: &Painter, at: Pos2, align: Align2, words: &str, color: Color32) {
    let galley = painter.layout_no_wrap(words.into(), FontId::proportional(13.0), color);
    let place = align.anchor_size(at, galley.size());
    painter.rect_filled(place.expand2(vec2(5.0, 2.0)), 4.0, Color32::from_black_alpha(165));
    painter.galley(place.min, galley, color);
}

/// Marks the pixel that is explained: nothing lies over the pixel itself.
pub fn mark(painter: &Painter, at: Pos2) {
    ring(painter, at, RING, Color32::WHITE);
    for side in [Vec2::RIGHT, Vec2::LEFT, Vec2::DOWN, Vec2::UP] {
        let ends = [at + side * RING, at + side * (RING + TICK)];
        line(painter, ends, 1.5, Color32::WHITE);
    }
}

/// Rings around pixels of a meaning that so few have that nobody would find them.
pub fn few(ui: &Ui, rect: Rect, state: &State) {
    let painter = ui.painter_at(rect);
    for (place, legend) in state.legends().iter().enumerate() {
        for entry in legend {
            let [r, g, b] = entry.color;
            for &at in entry.at.iter().filter(|[x, _]| state.place_at(*x) == place) {
                let at = state.area.of_pixel(at);
                ring(&painter, at, RING - 2.0, Color32::from_rgb(r, g, b));
            }
        }
    }
}

/// The pivot with its axes; all equally long in the world.
pub fn guides(ui: &Ui, rect: Rect, state: &State) {
    let painter = ui.painter_at(rect);
    let (pixels, pivot) = (state.pixels(), state.rig.pivot);
    let point = |at: DVec3| pixels.seen_at(at).map(|at| state.area.point(at));
    let Some(middle) = point(pivot) else { return };
    let length = AXIS * 2.0 * pixels.view.h * state.rig.pivot_depth();
    for (name, axis, color) in AXES {
        let Some(end) = point(pivot + axis * length) else { continue };
        line(&painter, [middle, end], 2.0, color);
        let away = (end - middle).normalized() * 11.0;
        text(&painter, end + away, Align2::CENTER_CENTER, name, color);
    }
    ring(&painter, middle, 5.0, Color32::WHITE);
}
