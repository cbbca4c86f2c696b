//! Lines, arrows, surfaces and labels in the picture's plane, and their SVG.

use glam::{DVec2, DVec3};
use kugelblitz::rays::Pixels;
use maud::{Markup, PreEscaped, html};

use super::Figure;
use super::labels::{Label, Place, placed};
use super::words::caption;
use crate::explain::Lang;
use crate::markup::{Shade, document, for_light_and_dark};

/// Pieces of a line: hidden and visible ones meet where a piece ends.
const PIECES: usize = 120;

/// Classes with their colours on a light and on a dark page.
const COLORS: [Shade; 5] = [
    ("ink", "#1b2027", "#e8eaee"),
    ("soft", "#59616d", "#a5adb9"),
    ("surface", "#2a78b8", "#6db3ec"),
    ("given", "#b3261e", "#ff8a80"),
    ("found", "#7a5c00", "#e6c34d"),
];

/// What is drawn so far.
pub struct Drawing {
    pub pixels: Pixels,
    surfaces: Vec<Vec<DVec2>>,
    strokes: Vec<Stroke>,
    heads: Vec<([DVec2; 3], &'static str)>,
    dots: Vec<(DVec2, &'static str)>,
    labels: Vec<Label>,
}

/// A line, in pixels.
struct Stroke {
    points: Vec<DVec2>,
    class: &'static str,
    is_hidden: bool,
    is_thin: bool,
}

impl Drawing {
    pub fn new(pixels: Pixels) -> Drawing {
        Drawing {
            pixels,
            surfaces: Vec::new(),
            strokes: Vec::new(),
            heads: Vec::new(),
            dots: Vec::new(),
            labels: Vec::new(),
        }
    }

    fn size(&self) -> DVec2 {
        DVec2::new(self.pixels.image_width.into(), self.pixels.image_height.into())
    }

    /// Height of letters, px.
    fn font_px(&self) -> f64 {
        (self.size().x / 54.0).min(self.size().y / 30.0)
    }

    /// Where a point of the world is; `None` for one that is behind the camera or far off the picture.
    fn at(&self, point: DVec3) -> Option<DVec2> {
        let at = self.pixels.seen_at(point)?;
        let size = self.size();
        let far_off = 10.0 * size.max_element();
        ((at - size / 2.0).abs().max_element() < far_off).then_some(at)
    }

    /// Fills a polygon.
    pub fn surface(&mut self, corners: &[DVec3]) {
        self.surfaces.extend(corners.iter().map(|p| self.at(*p)).collect::<Option<Vec<_>>>());
    }

    /// Draws a curve through points, dashed where it is hidden.
    pub fn curve(&mut self, points: &[DVec3], class: &'static str, hidden: &dyn Fn(DVec3) -> bool) {
        self.stroke(points, class, false, hidden);
    }

    fn stroke(
        &mut self,
        points: &[DVec3],
        class: &'static str,
        is_thin: bool,
        hidden: &dyn Fn(DVec3) -> bool,
    ) {
        let mut last: Option<Stroke> = None;
        for pair in points.windows(2) {
            let ends = self.at(pair[0]).zip(self.at(pair[1]));
            let is_hidden = hidden((pair[0] + pair[1]) / 2.0);
            let goes_on =
                ends.is_some() && last.as_ref().is_some_and(|stroke| stroke.is_hidden == is_hidden);
            if !goes_on {
                self.strokes.extend(last.take());
            }
            if let Some((from, to)) = ends {
                let begin = || Stroke { points: vec![from], class, is_hidden, is_thin };
                last.get_or_insert_with(begin).points.push(to);
            }
        }
        self.strokes.extend(last);
    }

    /// Draws a straight line.
    pub fn line(
        &mut self,
        [from, to]: [DVec3; 2],
        class: &'static str,
        hidden: &dyn Fn(DVec3) -> bool,
    ) {
        self.stroke(&pieces(from, to), class, false, hidden);
    }

    /// Draws a thin line: a help to find a point.
    pub fn thin(&mut self, points: &[DVec3], hidden: &dyn Fn(DVec3) -> bool) {
        for pair in points.windows(2).filter(|pair| pair[0] != pair[1]) {
            self.stroke(&pieces(pair[0], pair[1]), "soft", true, hidden);
        }
    }

    /// Draws a line with a head at its end.
    pub fn arrow(
        &mut self,
        [from, to]: [DVec3; 2],
        class: &'static str,
        hidden: &dyn Fn(DVec3) -> bool,
    ) {
        self.line([from, to], class, hidden);
        let before = self.at(to + (from - to) / PIECES as f64);
        let Some((tip, before)) = self.at(to).zip(before) else { return };
        let Some(back) = (before - tip).try_normalize() else { return };
        let (length, half_width) = (0.7 * self.font_px(), 0.25 * self.font_px());
        let (base, side) = (tip + back * length, back.perp() * half_width);
        self.heads.push(([tip, base + side, base - side], class));
    }

    /// Marks a point; false where it can't be seen.
    pub fn dot(&mut self, point: DVec3, class: &'static str) -> bool {
        let at = self.at(point);
        self.dots.extend(at.map(|at| (at, class)));
        at.is_some()
    }

    /// A mark across an axis.
    pub fn tick(&mut self, point: DVec3, axis: DVec3) {
        let Some((at, next)) = self.at(point).zip(self.at(point + axis * 1e-3)) else { return };
        let Some(along) = (next - at).try_normalize() else { return };
        let side = along.perp() * (0.2 * self.font_px());
        let points = vec![at - side, at + side];
        self.strokes.push(Stroke { points, class: "ink", is_hidden: false, is_thin: true });
    }

    /// Writes beside a point of the picture: a letter, and what it is.
    pub fn label(&mut self, point: DVec3, (letter, rest): (&str, String), class: &'static str) {
        let is_shown = |at: &DVec2| at.cmpge(DVec2::ZERO).all() && at.cmple(self.size()).all();
        let Some(at) = self.at(point).filter(is_shown) else { return };
        let is_number = letter.is_empty();
        let size = if is_number { 0.75 } else { 1.0 } * self.font_px();
        self.labels.push(Label { at, letter: letter.into(), rest, class, size });
    }

    pub fn svg(self, figure: Figure, lang: Lang) -> String {
        let (size, font) = (self.size(), self.font_px());
        let caption = caption(figure, lang);
        let mut ink: Vec<DVec2> = self.strokes.iter().flat_map(|s| s.points.clone()).collect();
        ink.extend(self.dots.iter().map(|(at, _)| *at));
        let bottom = size.y - 2.2 * font;
        let labels = placed(&self.labels, &ink, DVec2::new(size.x, bottom));
        let class = |color: &str, is_hidden: bool, is_thin: bool| {
            let hidden = if is_hidden { " hidden" } else { "" };
            let thin = if is_thin { " thin" } else { "" };
            format!("{color}{hidden}{thin}")
        };
        let markup = html! {
            svg .figure xmlns="http://www.w3.org/2000/svg" xml:lang=(lang.name()) role="img"
                viewBox={ "0 0 " (size.x) " " (size.y) } width=(size.x) height=(size.y) {
                title { (caption) }
                style { (PreEscaped(css(font))) }
                @for corners in &self.surfaces {
                    path .surface.filled d={ (path(corners)) "Z" } {}
                }
                @for stroke in &self.strokes {
                    path class=(class(stroke.class, stroke.is_hidden, stroke.is_thin))
                        d=(path(&stroke.points)) {}
                }
                @for (corners, class) in &self.heads {
                    path class={ (class) " head" } d={ (path(corners)) "Z" } {}
                }
                @for (at, class) in &self.dots {
                    circle class={ (class) " head" } cx=(px(at.x)) cy=(px(at.y))
                        r=(px(0.22 * font)) {}
                }
                @for (label, place) in self.labels.iter().zip(&labels) { (written(label, place)) }
                text .ink x=(px(font)) y=(px(size.y - 0.9 * font)) font-size=(px(font)) {
                    (caption)
                }
            }
        };
        document(markup) + "\n"
    }
}

/// A line in pieces.
fn pieces(from: DVec3, to: DVec3) -> Vec<DVec3> {
    (0..=PIECES).map(|i| from.lerp(to, i as f64 / PIECES as f64)).collect()
}

fn written(label: &Label, place: &Place) -> Markup {
    html! {
        text class=(label.class) x=(px(place.left)) y=(px(place.baseline))
            font-size=(px(label.size)) {
            @if !label.letter.is_empty() { tspan .letter { (label.letter) } }
            (label.rest)
        }
    }
}

fn path(points: &[DVec2]) -> String {
    let steps = points
        .iter()
        .enumerate()
        .map(|(i, at)| format!("{}{} {}", if i == 0 { 'M' } else { 'L' }, px(at.x), px(at.y)));
    steps.collect()
}

/// Hundredths of a pixel.
fn px(x: f64) -> f64 {
    // No negative zero.
    (x * 100.0).round() / 100.0 + 0.0
}

fn css(font: f64) -> String {
    let rule = |class: &str, color: &str| format!(".figure .{class}{{color:{color}}}");
    let colors = for_light_and_dark(&COLORS, rule, |rules| rules);
    let (line, thin) = (px(font / 11.0), px(font / 18.0));
    let (dash, gap) = (px(font / 3.0), px(font / 4.0));
    format!(
        ".figure{{font-family:system-ui,'Segoe UI',Roboto,'DejaVu Sans',sans-serif}}\
         .figure path{{fill:none;stroke:currentColor;stroke-width:{line};stroke-linecap:round;\
         stroke-linejoin:round}}.figure .thin{{stroke-width:{thin}}}\
         .figure .hidden{{stroke-dasharray:{dash} {gap};opacity:.75}}\
         .figure .filled{{fill:currentColor;fill-opacity:.16;stroke-width:{thin}}}\
         .figure .head,.figure text{{fill:currentColor}}.figure .letter{{font-style:italic}}\
         {colors}"
    )
}
