//! An [`Explanation`] as what text and LaTeX have to write: of each thing what it is, what is to be said of it, and its numbers.

use super::calculator::Calculator as _;
use super::derivation::Derivation;
use super::line::Line;
use super::numbers::six_digits;
use super::words::{ExplanationWords, Remark};
use super::{ChannelByte, ColorExplanation, Explanation, ObjectExplanation};

/// What is explained of one thing.
pub struct TextSection<'a> {
    /// The thing, with commas between the parts.
    pub subject: Vec<Remark>,
    /// What is to be said of it.
    pub why: Vec<Remark>,
    /// Notes on the numbers, after the formulas.
    pub notes: Vec<Remark>,
    /// The numbers of it, and how they come about.
    pub derivation: Option<&'a Derivation>,
}

impl Explanation {
    /// Where the ray begins and goes.
    pub(super) fn of_ray(&self) -> TextSection<'_> {
        let words = self.lang.words();
        let subject = match &self.pixel {
            Some(p) => Remark::of(words.pixel, [p.x, p.y, p.width, p.height]),
            None => words.ray.into(),
        };
        let depth = match self.camera.as_ref().map(|camera| camera.projection) {
            None => words.depth_of_ray,
            Some("perspective") => words.depth_in_perspective,
            Some(_) => words.depth_in_parallel,
        };
        let mut notes = vec![depth.into()];
        if let Some(mean) = self.shading.as_ref().and_then(|shading| shading.mean.as_ref()) {
            notes.push(Remark::of(words.ray_of_center, [mean.samples; 2]));
        }
        let objects = self.objects.iter().map(|object| &object.derivation);
        let mut lines = objects.chain([&self.ray]).flat_map(|derivation| &derivation.lines);
        if lines.any(Line::has_rounding) {
            notes.push(words.digits_missing.into());
        }
        let (why, derivation) = (Vec::new(), Some(&self.ray));
        TextSection { subject: vec![subject], why, notes, derivation }
    }

    /// What the ray sees, and the point where it does, with so many digits of `t`.
    pub(super) fn of_point(&self, n_digits: usize) -> TextSection<'_> {
        let words = self.lang.words();
        let (sees, side) = match &self.winner {
            None => (words.sees_background.into(), None),
            Some(winner) => {
                let t = winner.root.to_decimal(n_digits);
                let side = if winner.side == "back" { words.back } else { words.front };
                (Remark::of(words.sees, [&winner.label, &t]), Some(side.into()))
            }
        };
        let (subject, why) = (vec![sees], Vec::from_iter(side));
        TextSection { subject, why, notes: Vec::new(), derivation: self.point.as_ref() }
    }

    /// The light that falls on it, and the colours that come of it.
    pub(super) fn of_light(&self) -> Vec<TextSection<'_>> {
        let (words, Some(shading)) = (self.lang.words(), &self.shading) else { return Vec::new() };
        let lights = shading.lights.iter().map(|light| TextSection {
            subject: vec![Remark::name(&light.name), light.place.clone()],
            why: light.why.clone(),
            notes: Vec::new(),
            derivation: Some(&light.derivation),
        });
        let sky = shading.sky.iter().map(|sky| TextSection {
            subject: vec![Remark::of(words.sky, [sky.counting, sky.directions])],
            why: vec![Remark::of(words.sky_counts, [sky.counting, sky.behind, sky.hidden])],
            notes: Vec::new(),
            derivation: Some(&sky.derivation),
        });
        let of_ray = shading.color.section(words.color_of_ray.into(), words);
        let of_pixel = shading.mean.iter().map(|mean| {
            mean.color.section(Remark::of(words.color_of_pixel, [mean.samples; 2]), words)
        });
        lights.chain(sky).chain([of_ray]).chain(of_pixel).collect()
    }
}

impl ObjectExplanation {
    /// How the ray meets it.
    pub(super) fn section(&self) -> TextSection<'_> {
        TextSection {
            subject: vec![Remark::name(&self.label)],
            why: self.why.clone(),
            notes: Vec::new(),
            derivation: Some(&self.derivation),
        }
    }
}

impl ColorExplanation {
    /// The bytes that come out first.
    fn section(&self, subject: Remark, words: &ExplanationWords) -> TextSection<'_> {
        let byte = |(channel, name): (&ChannelByte, &str)| {
            let ChannelByte { byte, range: [low, high], from_edge, .. } = channel;
            let ends = [low, high].into_iter().filter(|end| end.is_finite());
            let mut parts = vec![name.to_owned(), byte.to_string()];
            parts.extend(ends.map(|end| six_digits(*end)));
            parts.push(from_edge.root.to_decimal(4));
            let phrase = match (low.is_finite(), high.is_finite()) {
                (false, _) => words.byte_below,
                (_, false) => words.byte_above,
                _ => words.byte,
            };
            Remark::of(phrase, parts)
        };
        let bytes = self.channels.iter().zip(words.channels).map(byte);
        let why = bytes.chain(self.why.iter().cloned()).collect();
        let (notes, derivation) = (Vec::new(), Some(&self.derivation));
        TextSection { subject: vec![subject], why, notes, derivation }
    }
}
