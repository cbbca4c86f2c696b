//! Lines, arrows, surfaces and labels in the picture's plane, and their SVG.

use glam::{DVec2, DVec3};
use kugelblitz::rays::{Lens, Pixels, View};

use super::Figure;
use super::labels::{Label, placed};
use super::words::caption;
use crate::explain::Lang;
use crate::markup::{ThemeColor, document, escaped, for_light_and_dark};

/// Pieces of a line: hidden and visible ones meet where a piece ends.
const PIECES: usize = 120;

/// Classes with their colours on a light and on a dark page.
const COLORS: [ThemeColor; 5] = [
    ("ink", "#1b2027", "#e8eaee"),
    ("soft", "#59616d", "#a5adb9"),
    ("surface", "#2a78b8", "#6db3ec"),
    ("given", "#b3261e", "#ff8a80"),
    ("found", "#7a5c00", "#e6c34d"),
];

/// Says of a point that something hides it.
pub type Hides<'a> = &'a dyn Fn(DVec3) -> bool;

/// Nothing hides any point.
pub const VISIBLE: Hides = &|_| false;

/// All points are hidden.
pub const HIDDEN: Hides = &|_| true;

/// From a point towards the eye of a view, not of any length.
pub fn towards_eye(view: &View, point: DVec3) -> DVec3 {
    match view.lens {
        Lens::Perspective => view.position - point,
        Lens::Orthographic => -view.forward,
    }
}

/// What is drawn so far.
pub struct Drawing {
    pub pixels: Pixels,
    /// Elements of SVG: surfaces, lines, the heads of arrows, dots, each over those before.
    layers: [String; 4],
    /// Places that labels keep clear of.
    ink: Vec<DVec2>,
    labels: Vec<Label>,
}

impl Drawing {
    pub fn new(pixels: Pixels) -> Drawing {
        let (layers, ink, labels) = Default::default();
        Drawing { pixels, layers, ink, labels }
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
        if let Some(corners) = corners.iter().map(|p| self.at(*p)).collect::<Option<Vec<_>>>() {
            let path = path(&corners);
            self.layers[0] += &format!("<path class=\"surface filled\" d=\"{path}Z\"></path>");
        }
    }

    /// Draws a line through points, dashed where it is hidden; a thin one is a help to find a point.
    pub fn stroke(&mut self, points: &[DVec3], class: &'static str, is_thin: bool, hidden: Hides) {
        let piece = |pair: &[DVec3]| {
            let ends = self.at(pair[0]).zip(self.at(pair[1]));
            ends.map(|(from, to)| (from, to, hidden((pair[0] + pair[1]) / 2.0)))
        };
        let pieces: Vec<_> = points.windows(2).map(piece).collect();
        for run in pieces.chunk_by(|a, b| a.map(|a| a.2) == b.map(|b| b.2)) {
            let Some((first, _, is_hidden)) = run[0] else { continue };
            let ends = run.iter().flatten().map(|(_, to, _)| *to);
            self.put([first].into_iter().chain(ends).collect(), class, is_hidden, is_thin);
        }
    }

    /// Puts a line down.
    fn put(&mut self, points: Vec<DVec2>, class: &str, is_hidden: bool, is_thin: bool) {
        let hidden = if is_hidden { " hidden" } else { "" };
        let thin = if is_thin { " thin" } else { "" };
        let path = path(&points);
        self.layers[1] += &format!("<path class=\"{class}{hidden}{thin}\" d=\"{path}\"></path>");
        self.ink.extend(points);
    }

    /// Draws a thin line: a help to find a point.
    pub fn thin(&mut self, points: &[DVec3], hidden: Hides) {
        for pair in points.windows(2).filter(|pair| pair[0] != pair[1]) {
            self.stroke(&pieces(pair[0], pair[1]), "soft", true, hidden);
        }
    }

    /// Draws a line with a head at its end.
    pub fn arrow(&mut self, [from, to]: [DVec3; 2], class: &'static str, hidden: Hides) {
        self.stroke(&pieces(from, to), class, false, hidden);
        let before = self.at(to + (from - to) / PIECES as f64);
        let Some((tip, before)) = self.at(to).zip(before) else { return };
        let Some(back) = (before - tip).try_normalize() else { return };
        let (length, half_width) = (0.7 * self.font_px(), 0.25 * self.font_px());
        let (base, side) = (tip + back * length, back.perp() * half_width);
        let path = path(&[tip, base + side, base - side]);
        self.layers[2] += &format!("<path class=\"{class} head\" d=\"{path}Z\"></path>");
    }

    /// Marks a point; false where it can't be seen.
    pub fn dot(&mut self, point: DVec3, class: &'static str) -> bool {
        let Some(at) = self.at(point) else { return false };
        let [x, y, r] = [at.x, at.y, 0.22 * self.font_px()].map(px);
        self.layers[3] +=
            &format!("<circle class=\"{class} head\" cx=\"{x}\" cy=\"{y}\" r=\"{r}\"></circle>");
        self.ink.push(at);
        true
    }

    /// A mark across an axis.
    pub fn tick(&mut self, point: DVec3, axis: DVec3) {
        let Some((at, next)) = self.at(point).zip(self.at(point + axis * 1e-3)) else { return };
        let Some(along) = (next - at).try_normalize() else { return };
        let side = along.perp() * (0.2 * self.font_px());
        self.put(vec![at - side, at + side], "ink", false, true);
    }

    /// Writes beside a point of the picture: a letter, and what it is.
    pub fn label(&mut self, point: DVec3, letter: &str, rest: &str, class: &'static str) {
        let is_shown = |at: &DVec2| at.cmpge(DVec2::ZERO).all() && at.cmple(self.size()).all();
        let Some(at) = self.at(point).filter(is_shown) else { return };
        let is_number = letter.is_empty();
        let size = if is_number { 0.75 } else { 1.0 } * self.font_px();
        self.labels.push(Label { at, letter: letter.into(), rest: rest.into(), class, size });
    }

    pub fn svg(self, figure: Figure, lang: Lang) -> String {
        let (size, font) = (self.size(), self.font_px());
        // The caption has its room below.
        let room = DVec2::new(size.x, px(size.y - 2.2 * font));
        let places = placed(&self.labels, &self.ink, room);
        let labels: String =
            self.labels.iter().zip(&places).map(|(label, place)| written(label, place)).collect();
        let (DVec2 { x: width, y: height }, layers) = (size, self.layers.concat());
        let layers = format!("<svg width=\"{width}\" height=\"{}\">{layers}</svg>", room.y);
        let (lang, caption, css) = (lang.name(), caption(figure, lang), css(font));
        let [x, y, font] = [font, height - 0.9 * font, font].map(px);
        document(&format!(
            "<svg class=\"figure\" xmlns=\"http://www.w3.org/2000/svg\" xml:lang=\"{lang}\" role=\"img\" \
             viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\">\
             <title>{caption}</title><style>{css}</style>{layers}{labels}\
             <text class=\"ink\" x=\"{x}\" y=\"{y}\" font-size=\"{font}\">{caption}</text></svg>"
        )) + "\n"
    }
}

/// A line in pieces.
pub fn pieces(from: DVec3, to: DVec3) -> Vec<DVec3> {
    (0..=PIECES).map(|i| from.lerp(to, i as f64 / PIECES as f64)).collect()
}

fn written(Label { letter, rest, class, size, .. }: &Label, place: &DVec2) -> String {
    let [x, y, size] = [place.x, place.y, *size].map(px);
    let letter = match escaped(letter) {
        none if none.is_empty() => none,
        letter => format!("<tspan class=\"letter\">{letter}</tspan>"),
    };
    let rest = escaped(rest);
    format!(
        "<text class=\"{class}\" x=\"{x}\" y=\"{y}\" font-size=\"{size}\">{letter}{rest}</text>"
    )
}

fn path(points: &[DVec2]) -> String {
    let points: Vec<String> =
        points.iter().map(|at| format!("{} {}", px(at.x), px(at.y))).collect();
    format!("M{}", points.join("L"))
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
