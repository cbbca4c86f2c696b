//! The explanation of a pixel: beside it, with the pixel marked.

use eframe::egui;
use egui::text::{LayoutJob, TextFormat};
use egui::{Align, Align2, Event, FontId, Label, Pos2, Rect, RichText, ScrollArea, Ui, Vec2, vec2};
use kugelblitz_judge::explain::text::WIDTH;

use super::ask::Why;
use super::overlay;
use super::panels::INSET;
use super::state::{Explained, State};

/// Sizes of the letters, points: the largest with which all columns are seen.
const LETTERS: [f32; 2] = [8.5, 11.5];

/// Width of a letter, as a part of its size.
const LETTER: f32 = 0.61;

/// Size of a subscript's letters, as a part of the others'.
const SUBSCRIPT: f32 = 0.72;

/// Distance that the panel keeps from the pixel, points.
const APART: f32 = 24.0;

/// The largest size of the panel, points.
const LARGEST: Vec2 = vec2(740.0, 720.0);

/// Most that it takes of the picture.
const MOST: f32 = 0.48;

/// The frame and the title around what the panel holds, points.
const AROUND: Vec2 = vec2(14.0, 44.0);

/// Marks the pixel that is explained, and shows why it is as it is.
pub fn explanation(ui: &Ui, rect: Rect, state: &mut State) {
    let Some(Explained { question, why }) = &state.explained else { return };
    let pixel = question.at();
    let is_there = state.pixels() == question.pixel.picture();
    let at = state.area.of_pixel(pixel);
    if is_there {
        overlay::mark(&ui.painter_at(rect), at);
    }
    let place = beside(rect.shrink(INSET), rect.clamp(at));
    let mut is_open = true;
    let [x, y] = pixel;
    egui::Window::new(format!("Why pixel {x}, {y}?"))
        // Each pixel has a place of its own.
        .id(egui::Id::unique("explanation").with(pixel))
        .open(&mut is_open)
        .collapsible(false)
        .default_rect(Rect::from_min_size(place.min, place.size() - AROUND))
        .min_size(vec2(120.0, 60.0))
        .constrain_to(rect)
        .show(ui.ctx(), |ui| {
            let Some(Why { verdict, text }) = why else {
                ui.weak("calculating …");
                return;
            };
            ui.add(Label::new(RichText::new(verdict.trim_end()).monospace().strong()).wrap());
            ui.horizontal_wrapped(|ui| {
                let copy = ui.button("copy").on_hover_text("Ctrl+C");
                if copy.clicked() || ui.input(|input| input.events.contains(&Event::Copy)) {
                    ui.ctx().copy_text(text.clone());
                }
                if !is_there {
                    ui.weak("the view has changed since");
                }
            });
            ui.separator();
            ScrollArea::both().auto_shrink(false).show(ui, |ui| {
                let [least, most] = LETTERS;
                let letters = ui.available_width() / (WIDTH as f32 * LETTER);
                let job = aligned(ui, text, letters.clamp(least, most));
                ui.add(Label::new(job).extend());
            });
        });
    if !is_open {
        state.explained = None;
    }
}

/// The panel's place in `rect`: where the most room is beside a point, and away from that.
fn beside(rect: Rect, at: Pos2) -> Rect {
    let (high, wide) = (vec2(MOST, 1.0), vec2(1.0, MOST));
    let sides = [
        (rect.with_min_x(at.x + APART), Align2::RIGHT_TOP, high),
        (rect.with_max_x(at.x - APART), Align2::LEFT_TOP, high),
        (rect.with_min_y(at.y + APART), Align2::LEFT_BOTTOM, wide),
        (rect.with_max_y(at.y - APART), Align2::LEFT_TOP, wide),
    ];
    let places = sides.map(|(side, align, most)| {
        let size = side.size().max(Vec2::ZERO).min(LARGEST).min(rect.size() * most);
        align.align_size_within_rect(size, side)
    });
    // Not for a few points more on the left, where the legend is.
    let larger = |a: Rect, b: Rect| if b.area() > 1.05 * a.area() { b } else { a };
    places.into_iter().reduce(larger).unwrap_or(rect)
}

/// The text with small digits for subscripts, which the font lacks, each as wide as a letter: columns stand straight.
fn aligned(ui: &Ui, text: &str, letters: f32) -> LayoutJob {
    let width = |size| ui.fonts_mut(|fonts| fonts.glyph_width(&FontId::monospace(size), '0'));
    let format = |size: f32| TextFormat {
        font_id: FontId::monospace(size),
        extra_letter_spacing: width(letters) - width(size),
        color: ui.visuals().text_color(),
        valign: Align::BOTTOM,
        line_height: Some((letters * 1.2).round()),
        ..TextFormat::default()
    };
    let mut job = LayoutJob::default();
    for part in text.split_inclusive(|c| subscript(c).is_some()) {
        let digit = part.chars().next_back().and_then(subscript);
        job.append(part.trim_end_matches(|c| subscript(c).is_some()), 0.0, format(letters));
        if let Some(digit) = digit {
            job.append(&digit.to_string(), 0.0, format(letters * SUBSCRIPT));
        }
    }
    job
}

/// The digit of a subscript.
fn subscript(c: char) -> Option<char> {
    let digit = u32::from(c).checked_sub(u32::from('₀')).filter(|digit| *digit < 10)?;
    char::from_digit(digit, 10)
}

#[cfg(test)]
mod tests {
    use egui::pos2;

    use super::*;

    #[test]
    fn the_panel_stands_beside_the_pixel() {
        for size in
            [vec2(420.0, 480.0), vec2(640.0, 360.0), vec2(1280.0, 640.0), vec2(2560.0, 1300.0)]
        {
            let rect = Rect::from_min_size(pos2(0.0, 36.0), size);
            for x in [0.0, 0.1, 0.5, 0.8, 1.0] {
                for y in [0.0, 0.3, 0.5, 1.0] {
                    let at = rect.min + size * vec2(x, y);
                    let panel = beside(rect.shrink(INSET), at);
                    assert!(rect.contains_rect(panel) && !panel.expand(APART / 2.0).contains(at));
                    let part = panel.area() / rect.area().min(LARGEST.x * LARGEST.y);
                    assert!(part > 0.3, "{size} {x} {y}: {part}");
                    assert!(panel.area() < 0.5 * rect.area(), "{size} {x} {y}");
                }
            }
        }
    }

    #[test]
    fn columns_stand_straight() {
        let context = egui::Context::default();
        let _ = context.run_ui(egui::RawInput::default(), |ui| {
            let width = |text: &str| {
                let job = aligned(ui, text, 11.5);
                ui.fonts_mut(|fonts| fonts.layout_job(job)).rect.width()
            };
            let plain = width("abcdefgh |");
            for text in ["t₁ = 12  |", "√D ≈ ±ω·n|", "−1 ≤ ₂₃₄→|"] {
                assert_eq!(text.chars().count(), 10);
                assert!((width(text) - plain).abs() < 0.6, "{text}: {} {plain}", width(text));
            }
        });
    }

    #[test]
    fn subscripts_are_digits() {
        assert_eq!(
            "a₀₁₉².".chars().map(subscript).collect::<Vec<_>>(),
            [None, Some('0'), Some('1'), Some('9'), None, None]
        );
    }
}
