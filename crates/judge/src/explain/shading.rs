//! [`ShadingExplanation`]: light and colour in f32, in f64 and exactly.

use glam::DVec3;
use kugelblitz::exact::{ExactPixels, QuadraticSurd, Side, integer, real};
use kugelblitz::lighting::{BaselinePoint, BaselineWay, ExactMean, Lighting, PreparedLight};
use kugelblitz::num::{Real as _, V3};
use kugelblitz::rays::{Pixels, Rays, View};
use kugelblitz::scene::{Camera, Light, Object, Plane, QuantizationTable, Scene, Source, Sphere};
use kugelblitz::support::parallel;

use super::calculator::Calculator as _;
use super::derivation::Derivation;
use super::derivation::LineDetail::{self, Numbers};
use super::light::{
    ChannelByte, ColorExplanation, LightExplanation, LightVerdict, MeanExplanation,
    ShadingExplanation, SkyExplanation,
};
use super::numbers::{COLUMNS, Columns, Exact, Short, decimal_f64, enclosed, zero};
use super::ray::{RayNumbers, off_sphere};
use super::step::{Tape, show};
use super::words::Remark;
use crate::verify::{LitPoint, exact_mean, samples_of_pixel};

const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// All that lights the scene for a ray, whose origin is the eye where it is no pixel's; `None` where
/// a pixel shows the colour of its object.
pub(super) fn lighting(scene: &Scene, rays: &Rays) -> Option<Lighting> {
    let view = match rays {
        Rays::Pixels(pixels) => pixels.view,
        Rays::List(rays) => {
            let position = rays.first()?.origin;
            View { position, ..View::new(&Camera::new(DVec3::Z, DVec3::ZERO)) }
        }
    };
    Lighting::new(scene, &view)
}

/// The point that a ray sees, exactly.
pub(super) struct ShadedPoint<'a> {
    lit: LitPoint<'a>,
    at: [QuadraticSurd; 3],
    /// The unit normal that faces the ray.
    normal: [QuadraticSurd; 3],
}

impl RayNumbers<'_> {
    /// The light on the point that is seen; `None` for a scene without light and pixels of one sample.
    pub fn shading(&self, point: Option<&ShadedPoint>) -> Option<ShadingExplanation> {
        let lighting = self.lighting.as_ref();
        let samples = self.scene.samples.unwrap_or_default().across();
        let pixels = self.rays.pixels().filter(|_| samples > 1);
        if lighting.is_none() && pixels.is_none() {
            return None;
        }
        let mean =
            pixels.map(|pixels| MeanExplanation { samples, color: self.mean(pixels, samples) });
        let id = self.hit.as_ref().map_or(0, |hit| hit.id);
        let exact = exact_mean(self.scene, lighting, [(id, point.map(|point| &point.lit))]);
        let lit = lighting.zip(point);
        let mut color = self.color(&exact, lit.is_some());
        let Some((lighting, point)) = lit else {
            if lighting.is_some() {
                color.why.push(self.words.no_light_on_background.into());
            }
            return Some(ShadingExplanation { lights: Vec::new(), sky: None, color, mean });
        };
        let way = |lamp| ExactWay::new(self.scene, lamp, lighting, &point.lit);
        let ways = parallel::map(0..lighting.lamps.len(), way);
        let ways: Vec<ExactWay> = ways.into_iter().collect::<Option<_>>()?;
        let (tape, mut derivation) = (Tape::default(), Derivation::new(self.digits));
        for (channel, name) in self.words.channels.into_iter().enumerate() {
            let c = tape.of_scene("c", self.scene.color(id).0[channel]);
            let a = tape.of_scene("a", lighting.ambient[channel]);
            let names = [name, &format!(r"\text{{{name}}}")];
            let formula = r"c\,(a + \textstyle\sum I\,\vec{n} \cdot \vec{\omega})";
            let sum = tape.number("Σ", sum_of(&ways, channel));
            derivation.written(names, [self.words.channel_formula, formula], c * (a + sum));
        }
        color.derivation.lines = derivation.lines;
        let light = |(index, light): (usize, &Light)| {
            let way = ways.iter().find(|way| way.lamp.light == Some(index));
            let name = format!("{} {}", self.words.light, index + 1);
            self.light(name, light.source, way, point)
        };
        let lights = self.scene.lights.iter().enumerate().map(light).collect();
        Some(ShadingExplanation { lights, sky: self.sky(&ways), color, mean })
    }

    /// A number in each arithmetic; `None` where the kernel sees another object.
    fn columns<T: Into<Option<f64>>>(&self, of: impl Fn(usize, &BaselinePoint) -> T) -> Columns {
        let plain = self.plain();
        [0, 1, 2].map(|kernel| Some(of(kernel, plain[kernel]?).into()))
    }

    /// The point that the ray sees, what the formulas say of it, and itself.
    pub fn point(&self) -> Option<(Derivation, ShadedPoint<'_>)> {
        let hit = self.hit.as_ref()?;
        let lit = LitPoint::new(&self.exact, hit, &self.near);
        let tape = Tape::default();
        let (mut derivation, [o, d]) = self.derivation(&tape);
        let t = tape.number("t", hit.root.clone());
        let p = o + V3([t; 3]).times(d);
        derivation.line("p", &p.0, Numbers);
        let (letter, off, outward) = match hit.object {
            Object::Sphere(&Sphere { center, radius }) => {
                let (c, r) = (tape.vector_of_scene("c", center), tape.of_scene("r", radius));
                derivation.line("", &(p - c).0, Numbers);
                ("n", off_sphere(p - c, r), (p - c) / r)
            }
            Object::Plane(&Plane { point, normal, .. }) => {
                let (a, n) = (tape.vector_of_scene("a", point), tape.vector_of_scene("n", normal));
                derivation.line("", &(p - a).0, Numbers);
                let length = n.dot(n).sqrt();
                show(&[length], "");
                ("", (p - a).dot(n), n / length)
            }
        };
        derivation.line("f(p)", &[off], Numbers);
        let normal = if hit.side == Side::Back { -outward } else { outward };
        derivation.line(letter, &normal.0, Numbers);

        derivation.rows(["p.x", "p.y", "p.z"], p.0, |axis| {
            let origin = |kernel| if kernel == 2 { self.reference[axis] } else { 0.0 };
            let world = |kernel, plain: &BaselinePoint| origin(kernel) + plain.at[axis];
            let [lecture, _, double] = self.columns(world);
            [lecture, None, double]
        });
        let residual = self.columns(|kernel, plain| self.residual(kernel, plain));
        derivation.row("f(p)", residual, off.value());
        derivation.rows(["n.x", "n.y", "n.z"], normal.0, |axis| {
            self.columns(|_, plain| plain.normal[axis])
        });
        let [at, normal] = [p, normal].map(|v| v.0.map(|x| x.value()));
        Some((derivation, ShadedPoint { lit, at, normal }))
    }

    /// How a light falls on the point; without a way to it, it gives none.
    fn light(
        &self,
        name: String,
        source: Source,
        way: Option<&ExactWay>,
        point: &ShadedPoint,
    ) -> LightExplanation {
        let dark = LightExplanation {
            name,
            place: self.place_of(source),
            verdict: LightVerdict::Dark,
            why: vec![self.words.dark.into()],
            derivation: Derivation::default(),
        };
        let Some(way) = way else { return dark };
        let tape = Tape::default();
        let (mut derivation, [o, d]) = self.derivation(&tape);
        let n = tape.vector("n", point.normal.clone());
        let p = tape.vector("p", point.at.clone());
        let (w, shown) = match (source, way.lamp.origin) {
            (Source::Point(position), _) => (tape.vector_of_scene("l", position) - p, Numbers),
            (Source::Sun(direction), _) => {
                (-tape.vector_of_scene("l", direction), LineDetail::Result)
            }
            (Source::Eye, Source::Sun(_)) => (-d, LineDetail::Result),
            (Source::Eye, _) => (o - p, Numbers),
        };
        derivation.line("w", &w.0, shown);
        let is_at_point = w.0.iter().all(|component| component.signum() == 0);
        let cosine = n.dot(w) / w.dot(w).sqrt();
        if !is_at_point {
            derivation.line("n·ω", &[cosine], Numbers);
        }
        let root = way.hidden_by.as_ref().map(|(root, _)| root.clone());
        if let Some(root) = &root {
            derivation.given("s", &[tape.number("s", root.clone())]);
        }
        if way.verdict == LightVerdict::Counts {
            derivation.line("", &(tape.vector("I", way.strength.clone()) * cosine).0, Numbers);
        }

        derivation.rows(["w.x", "w.y", "w.z"], w.0, |axis| {
            self.columns(|_, plain| way.plain(plain).way[axis])
        });
        let cosines = self.columns(|_, plain| way.plain(plain).cosine);
        derivation.row("n·ω", cosines, way.cosine.clone());
        let roots = self.columns(|_, plain| way.plain(plain).in_the_way.map(|(_, s)| s));
        if root.is_some() || roots.into_iter().any(|entry| entry.flatten().is_some()) {
            derivation.row("s", roots, root);
        }
        let [red, green, blue] = way.lamp.weight;
        let shown = if red == green && green == blue { &["I·n·ω"][..] } else { &CHANNELS };
        for (channel, symbol) in shown.iter().enumerate() {
            let given = self.columns(|_, plain| way.plain(plain).given[channel]);
            derivation.row(symbol, given, way.gives(channel));
        }
        let (verdict, why) = (way.verdict.clone(), self.why(way, is_at_point));
        LightExplanation { verdict, why, derivation, ..dark }
    }

    /// Why a light counts or not, and which kernel has it otherwise.
    fn why(&self, way: &ExactWay, is_at_point: bool) -> Vec<Remark> {
        let words = self.words;
        let mut why = vec![match (way.cosine.signum(), &way.hidden_by) {
            (-1, _) => words.behind_surface.into(),
            (0, _) if is_at_point => words.light_at_point.into(),
            (0, _) => words.grazing.into(),
            (_, Some((root, by))) => {
                let root = Short::new(root, self.digits).text;
                Remark::of(words.hidden, [self.label(*by), root])
            }
            _ if way.lamp.origin == Source::Eye => words.counts_at_eye.into(),
            _ if way.lamp.shadows => words.counts.into(),
            _ => words.counts_without_shadow.into(),
        }];
        let mut is_self_shadowed = false;
        for (plain, column) in self.plain().into_iter().zip(COLUMNS) {
            let Some(plain) = plain else { continue };
            let BaselineWay { in_the_way, cosine, .. } = *way.plain(plain);
            let column = column.to_owned();
            why.push(match in_the_way {
                Some(_) if way.hidden_by.is_some() => continue,
                Some((id, _)) if id == plain.id => {
                    is_self_shadowed = true;
                    Remark::of(words.wrong_self_shadowing, [column])
                }
                Some((id, _)) => Remark::of(words.wrong_in_the_way, [column, self.label(id)]),
                None if cosine > 0.0 && way.verdict == LightVerdict::Counts => continue,
                None if cosine > 0.0 => Remark::of(words.wrong_counting, [column]),
                None if cosine <= 0.0 && way.cosine.signum() <= 0 => continue,
                None => Remark::of(words.wrong_behind, [column]),
            });
        }
        if is_self_shadowed {
            why.push(words.self_shadowing.into());
        }
        why
    }

    /// What the suns of the sky give, in whose ways these are.
    fn sky(&self, ways: &[ExactWay]) -> Option<SkyExplanation> {
        let sky = self.scene.sky?;
        let ways = &ways[ways.iter().position(|way| way.lamp.light.is_none())?..];
        let counting = ways.iter().filter(|way| way.verdict == LightVerdict::Counts).count();
        let hidden = ways.iter().filter(|way| way.hidden_by.is_some()).count();
        let n_plain = self.columns(|_, plain| {
            ways.iter().filter(|way| counts_plainly(way.plain(plain))).count() as f64
        });
        let given = self.columns(|kernel, plain| {
            let each = ways.iter().map(|way| way.plain(plain).given[0]);
            match kernel {
                2 => each.sum(),
                _ => f64::from(each.map(|given| given as f32).sum::<f32>()),
            }
        });
        let mut derivation = Derivation::default();
        derivation.row("suns", n_plain, QuadraticSurd::from(integer(counting as i64)));
        derivation.row("ΣI·n·ω", given, sum_of(ways, 0));
        Some(SkyExplanation {
            directions: sky.directions as usize,
            counting,
            behind: ways.len() - counting - hidden,
            hidden,
            derivation,
        })
    }

    /// `at (4, 6, 3)`
    fn place_of(&self, source: Source) -> Remark {
        let (phrase, place) = match source {
            Source::Point(position) => (self.words.at_point, position),
            Source::Sun(direction) => (self.words.sun, direction),
            Source::Eye => return self.words.at_eye.into(),
        };
        Remark::of(phrase, place.to_array().map(decimal_f64))
    }

    /// A colour, with what the kernels make of it, if it is that of a point in the light.
    fn color(&self, mean: &ExactMean, is_lit: bool) -> ColorExplanation {
        let (mut derivation, mut why) = (Derivation::default(), Vec::new());
        let channels = [0, 1, 2].map(|channel: usize| {
            let value = enclosed(|n_bits| Some(mean.enclosed(channel, n_bits)));
            let byte = ChannelByte::new(mean, channel, &value);
            let color = |_, plain: &BaselinePoint| {
                self.scene.color(plain.id).0[channel] * plain.light[channel]
            };
            let columns = if is_lit { self.columns(color) } else { [None; 3] };
            for (column, value) in COLUMNS.into_iter().zip(columns) {
                let Some(Some(value)) = value else { continue };
                let shown = QuantizationTable::srgb8().number(value);
                if shown != u16::from(byte.byte) {
                    let parts = [column, self.words.channels[channel], &shown.to_string()];
                    why.push(Remark::of(self.words.wrong_byte, parts));
                }
            }
            derivation.row(CHANNELS[channel], columns, value);
            byte
        });
        ColorExplanation { channels, derivation, why }
    }

    /// The colour of the pixel that has so many samples across.
    fn mean(&self, pixels: &Pixels, n: u32) -> ColorExplanation {
        let lighting = self.lighting.as_ref();
        let of_samples = pixels.samples(n);
        let rays = ExactPixels::new(&of_samples);
        let pixel = (pixels.x, pixels.y);
        let samples = samples_of_pixel(self.scene, lighting, (&of_samples, &rays), n, pixel);
        let samples = samples.iter().map(|(id, point)| (*id, point.as_ref()));
        self.color(&exact_mean(self.scene, lighting, samples), false)
    }
}

impl ChannelByte {
    fn new(mean: &ExactMean, channel: usize, value: &QuadraticSurd) -> ChannelByte {
        let byte = mean.pixel::<u8>()[channel];
        let (low, high) = QuantizationTable::srgb8().range(byte.into());
        let distance = |end: f64| Some(value.plus(&QuadraticSurd::from(-real(end)?)).magnitude());
        let from_edge = [low, high].into_iter().filter_map(distance).min();
        ChannelByte {
            name: CHANNELS[channel],
            byte,
            range: [low, high],
            from_edge: Exact::from(from_edge.unwrap_or_else(zero)),
        }
    }
}

/// The way from the point to a lamp, exactly.
struct ExactWay<'a> {
    lamp: &'a PreparedLight,
    /// The lamp's place among all.
    index: usize,
    /// `n·ω`
    cosine: QuadraticSurd,
    /// `I`
    strength: [QuadraticSurd; 3],
    /// The first object in the way, after its `s`; of a sun of the sky any one, and 0.
    hidden_by: Option<(QuadraticSurd, u32)>,
    verdict: LightVerdict,
}

impl<'a> ExactWay<'a> {
    fn new(
        scene: &Scene,
        index: usize,
        lighting: &'a Lighting,
        point: &LitPoint,
    ) -> Option<ExactWay<'a>> {
        let lamp = &lighting.lamps[index];
        let beam = point.beam(lamp)?;
        let cosine = match beam.slope() {
            None => zero(),
            Some((sign, cosine)) => {
                let magnitude = enclosed(|n_bits| Some(cosine.enclose(n_bits)));
                if sign < 0 { magnitude.negated() } else { magnitude }
            }
        };
        let root = |object| enclosed(|n_bits| beam.first_root(object, n_bits));
        let mut all = point.in_the_way(scene, lamp, &beam);
        let hidden_by = match lamp.light {
            _ if cosine.signum() <= 0 => None,
            None => all.next().map(|(id, _)| (zero(), id)),
            Some(_) => all.map(|(id, object)| (root(object), id)).min(),
        };
        let verdict = match (cosine.signum(), &hidden_by) {
            (-1, _) => LightVerdict::Behind,
            (0, _) => LightVerdict::Grazing,
            (_, Some((_, by))) => LightVerdict::Hidden { by: *by },
            _ => LightVerdict::Counts,
        };
        let strength = lamp
            .exact_weight
            .each_ref()
            .map(|x| QuadraticSurd::ratio(x.clone(), lighting.n_shares));
        Some(ExactWay { lamp, index, cosine, strength, hidden_by, verdict })
    }

    /// A channel of what the lamp gives.
    fn gives(&self, channel: usize) -> QuadraticSurd {
        match self.verdict {
            LightVerdict::Counts => self.strength[channel].times(&self.cosine),
            _ => zero(),
        }
    }

    /// The way as a kernel has it.
    fn plain<'p>(&self, plain: &'p BaselinePoint) -> &'p BaselineWay {
        &plain.ways[self.index]
    }
}

/// What lamps give together.
fn sum_of(ways: &[ExactWay], channel: usize) -> QuadraticSurd {
    ways.iter().map(|way| way.gives(channel)).fold(zero(), |sum, given| sum.plus(&given))
}

fn counts_plainly(way: &BaselineWay) -> bool {
    way.cosine > 0.0 && way.in_the_way.is_none()
}
