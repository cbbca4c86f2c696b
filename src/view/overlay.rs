//! What is drawn over the picture: marks of pixels, and guides while the camera moves.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, Ui, vec2};
use glam::DVec2;

use super::guides::{axes, seen_at};
use super::state::State;

/// Radius of the ring around a marked pixel, points.
const RING: f32 = 9.0;

/// Length of the lines that lead to it.
const TICK: f32 = 7.0;

const AXES: [(&str, Color32); 3] = [
    ("x", Color32::from_rgb(0xff, 0x5c, 0x5c)),
    ("y", Color32::from_rgb(0x6d, 0xd3, 0x5f)),
    ("z", Color32::from_rgb(0x6a, 0xa8, 0xff)),
];

/// A line that is seen on any ground.
fn line(painter: &Painter, ends: [Pos2; 2], width: f32, color: Color32) {
    painter.line_segment(ends, Stroke::new(width + 2.0, Color32::from_black_alpha(150)));
    painter.line_segment(ends, Stroke::new(width, color));
}

/// A ring that is seen on any ground.
fn ring(painter: &Painter, at: Pos2, radius: f32, color: Color32) {
    painter.circle_stroke(at, radius, Stroke::new(3.5, Color32::from_black_alpha(170)));
    painter.circle_stroke(at, radius, Stroke::new(1.5, color));
}

/// Text that is read on any ground.
fn text(painter: &Painter, at: Pos2, align: Align2, words: &str, color: Color32) {
    let galley = painter.layout_no_wrap(words.into(), FontId::proportional(13.0), color);
    let place = align.anchor_size(at, galley.size());
    painter.rect_filled(place.expand2(vec2(5.0, 2.0)), 4.0, Color32::from_black_alpha(165));
    painter.galley(place.min, galley, color);
}

/// Marks the pixel that is explained: nothing lies over the pixel itself.
pub fn mark(painter: &Painter, at: Pos2) {
    ring(painter, at, RING, Color32::WHITE);
    for side in [vec2(1.0, 0.0), vec2(-1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0)] {
        let ends = [at + side * RING, at + side * (RING + TICK)];
        line(painter, ends, 1.5, Color32::WHITE);
    }
}

/// Rings around pixels of a meaning that so few have that nobody would find them.
pub fn few(ui: &Ui, rect: Rect, state: &State) {
    let painter = ui.painter_at(rect);
    let points = state.area.in_points(ui.pixels_per_point());
    for place in 0..state.shown_kernels().len() {
        let Some(painted) = state.paint(place) else { continue };
        for (i, entry) in state.legend().iter().enumerate() {
            let [r, g, b] = entry.color;
            for &[x, y] in painted.tally.few(i).iter().filter(|[x, _]| state.place_at(*x) == place)
            {
                ring(&painter, points.of_pixel(x, y), RING - 2.0, Color32::from_rgb(r, g, b));
            }
        }
    }
}

/// The pivot with its axes.
pub fn guides(ui: &Ui, rect: Rect, state: &State) {
    let painter = ui.painter_at(rect);
    let (view, rig) = (state.rig.view(), &state.rig);
    let size = DVec2::new(f64::from(state.area.width), f64::from(state.area.height));
    let scale = ui.pixels_per_point();
    let point = |at: DVec2| rect.min + vec2(at.x as f32, at.y as f32) / scale;
    if let Some(pivot) = seen_at(&view, size, rig.pivot).map(point) {
        for ((name, color), end) in AXES.into_iter().zip(axes(&view, size, rig.pivot)) {
            let Some(end) = end.map(point) else { continue };
            line(&painter, [pivot, end], 2.0, color);
            let away = (end - pivot).normalized() * 11.0;
            text(&painter, end + away, Align2::CENTER_CENTER, name, color);
        }
        ring(&painter, pivot, 5.0, Color32::WHITE);
    }
}
