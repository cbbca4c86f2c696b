//! [`Shading`]: light and colour in f32, in f64 and exactly.

use glam::DVec3;
use kugelblitz::exact::{
    Dyadic, ExactBeam, ExactHit, ExactPixels, Root, Shape, Side, integer, real,
};
use kugelblitz::kernel::Kernel;
use kugelblitz::num::{Real as _, V3};
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::{Pixels, Rays, View};
use kugelblitz::scene::{Camera, Edges, Light, Scene, Source};
use kugelblitz::shade::{ExactMean, Lamp, LampOrigin, Lighting, PlainPoint, PlainWay};
use rayon::prelude::*;

use super::light::{
    ChannelByte, ColorExplanation, LightExplanation, LightVerdict, MeanExplanation,
    PointExplanation, Shading, SkyExplanation,
};
use super::line::{Derivation, LineDetail};
use super::numbers::{COLUMNS, Columns, Exact, Short, decimal_f64, enclosed, rows_of_vector};
use super::ray::{RayNumbers, off_sphere};
use super::step::{StepValue, number, of_scene, vector, vector_of_scene};
use super::words::Remark;
use crate::verify::{LitPoint, add_sample, samples_of_pixel};

const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// What the kernels `lecture`, `stable` and `double` make of the light; none where one sees another
/// object.
pub(super) type Plain = [Option<PlainPoint>; 3];

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
pub(super) struct Point {
    pub lit: LitPoint,
    at: [Root; 3],
    /// The unit normal that faces the ray.
    normal: [Root; 3],
}

/// All that is known of a ray.
pub(super) struct Seen<'a> {
    pub scene: &'a Scene,
    pub rays: &'a Rays,
    pub numbers: &'a RayNumbers,
    pub hit: Option<&'a ExactHit>,
    pub plain: Plain,
    /// What the points of `double` are relative to.
    pub reference: DVec3,
}

impl Seen<'_> {
    /// Adds the numbers of a kernel without a proof that sees the right object.
    pub fn add(&mut self, kernel: Kernel, prepared: &Prepared, lighting: Option<&Lighting>) {
        let column = match kernel {
            Kernel::Lecture => 0,
            Kernel::Stable => 1,
            Kernel::Double => 2,
            Kernel::Certified => return,
        };
        if kernel == Kernel::Double {
            self.reference = prepared.reference;
        }
        let right = self.hit.map(|hit| hit.id);
        let none = Lighting { lamps: Vec::new(), ambient: [0.0; 3], n_shares: 1 };
        let plain = PlainPoint::new(prepared, self.rays, lighting.unwrap_or(&none));
        self.plain[column] = plain.filter(|plain| Some(plain.id) == right);
    }

    /// The light on the point that is seen; `None` for a scene without light and pixels of one sample.
    pub fn shading(&self, lighting: Option<&Lighting>, point: Option<&Point>) -> Option<Shading> {
        let n_samples = match self.rays {
            Rays::Pixels(_) => self.scene.samples.unwrap_or_default().across(),
            Rays::List(_) => 1,
        };
        if lighting.is_none() && n_samples == 1 {
            return None;
        }
        let mean = match self.rays {
            Rays::Pixels(pixels) if n_samples > 1 => Some(MeanExplanation {
                samples: n_samples,
                color: self.mean(lighting, pixels, n_samples)?,
            }),
            _ => None,
        };
        let (Some(lighting), Some(hit), Some(point)) = (lighting, self.hit, point) else {
            let id = self.hit.map_or(0, |hit| hit.id);
            let mut exact = ExactMean::new(1, lighting);
            add_sample(&mut exact, self.scene, id, None);
            let mut color = self.color(&exact, |_, _| None);
            if lighting.is_some() {
                color.why.push(self.numbers.words.no_light_on_background.into());
            }
            return Some(Shading { lights: Vec::new(), sky: None, color, mean });
        };
        let ways: Vec<ExactWay> = lighting
            .lamps
            .par_iter()
            .map(|lamp| ExactWay::new(self.scene, lamp, lighting, &point.lit))
            .collect::<Option<_>>()?;
        let of_sky = lighting.lamps.iter().position(|lamp| lamp.light.is_none());
        let sky = of_sky.and_then(|first| self.sky(&ways[first..], lighting, first));
        let light = |(index, light): (usize, &Light)| {
            let words = self.numbers.words;
            // Without a lamp it gives no light.
            let mut explanation = LightExplanation {
                name: format!("{} {}", words.light, index + 1),
                place: self.place_of(light.source),
                verdict: LightVerdict::Dark,
                why: vec![words.dark.into()],
                quantities: Vec::new(),
                lines: Vec::new(),
            };
            let mut lamps = lighting.lamps.iter().enumerate();
            if let Some(lamp) = lamps.find(|(_, lamp)| lamp.light == Some(index)) {
                self.light(lamp, &ways[lamp.0], point, light.source, &mut explanation);
            }
            explanation
        };
        Some(Shading {
            lights: self.scene.lights.iter().enumerate().map(light).collect(),
            sky,
            color: self.lit_color(hit.id, &ways, lighting, &point.lit),
            mean,
        })
    }

    /// A number in each arithmetic; `None` where the kernel sees another object.
    fn columns(&self, of: impl Fn(usize, &PlainPoint) -> Option<f64>) -> Columns {
        Columns(std::array::from_fn(|kernel| self.plain[kernel].as_ref().map(|at| of(kernel, at))))
    }

    /// The point that the ray sees, what the formulas say of it, and itself.
    pub fn point(&self) -> Option<(PointExplanation, Point)> {
        let hit = self.hit?;
        let (RayNumbers { exact: ray, near, .. }, scene) = (self.numbers, self.scene);
        let lit = LitPoint::new(scene, ray, hit, (near.reference, &near.ray))?;
        let mut told = Derivation::new(self.numbers.digits);
        let ([o, d], t) = (self.numbers.told(), number("t", hit.root.clone()));
        let p = o + V3([t; 3]).times(d);
        told.line("p", p, LineDetail::Numbers);
        let (letter, off, outward) = match lit.shape {
            Shape::Sphere { center, radius } => {
                let (c, r) = (vector_of_scene("c", center), of_scene("r", radius));
                told.line("", p - c, LineDetail::Numbers);
                ("n", off_sphere(p - c, r), (p - c) / r)
            }
            Shape::Plane { point, normal } => {
                let (a, n) = (vector_of_scene("a", point), vector_of_scene("n", normal));
                told.line("", p - a, LineDetail::Numbers);
                let length = n.dot(n).sqrt();
                StepValue::from(length).tell(None);
                ("", (p - a).dot(n), n / length)
            }
        };
        told.line("f(p)", off, LineDetail::Numbers);
        let normal = if hit.side == Side::Back { -outward } else { outward };
        told.line(letter, normal, LineDetail::Numbers);

        let mut quantities = Vec::from(rows_of_vector(["p.x", "p.y", "p.z"], p, |axis| {
            let origin = |kernel| if kernel == 2 { self.reference[axis] } else { 0.0 };
            let world = |kernel, plain: &PlainPoint| Some(origin(kernel) + plain.at[axis]);
            self.columns(world).without_stable()
        }));
        let residual =
            |kernel, plain: &PlainPoint| self.numbers.residual(self.scene, kernel, plain);
        quantities.push(self.columns(residual).against("f(p)", Some(&off.value())));
        quantities.extend(rows_of_vector(["n.x", "n.y", "n.z"], normal, |axis| {
            self.columns(|_, plain| Some(plain.normal[axis]))
        }));
        let explanation = PointExplanation { quantities, lines: told.lines };
        let [at, normal] = [p, normal].map(|v| v.0.map(|x| x.value()));
        Some((explanation, Point { lit, at, normal }))
    }

    /// Adds how a lamp, the one with this index, lights the point.
    fn light(
        &self,
        (at, lamp): (usize, &Lamp),
        way: &ExactWay,
        point: &Point,
        source: Source,
        explanation: &mut LightExplanation,
    ) {
        let mut told = Derivation::new(self.numbers.digits);
        let (n, p) = (vector("n", point.normal.clone()), vector("p", point.at.clone()));
        let [o, d] = self.numbers.told();
        let (w, shown) = match (source, lamp.origin) {
            (Source::Point(position), _) => {
                (vector_of_scene("l", position) - p, LineDetail::Numbers)
            }
            (Source::Sun(direction), _) => (-vector_of_scene("l", direction), LineDetail::Result),
            (Source::Eye, LampOrigin::Sun(_)) => (-d, LineDetail::Result),
            (Source::Eye, _) => (o - p, LineDetail::Numbers),
        };
        told.line("w", w, shown);
        let is_at_point = w.0.iter().all(|component| component.signum() == 0);
        let cosine = n.dot(w) / w.dot(w).sqrt();
        if !is_at_point {
            told.line("n·ω", cosine, LineDetail::Numbers);
        }
        let root = way.hidden_by.as_ref().map(|(_, shape)| way.first_root(shape));
        if let Some(root) = &root {
            told.given("s", number("s", root.clone()), true);
        }
        explanation.verdict = way.verdict();
        if explanation.verdict == LightVerdict::Counts {
            told.line("", vector("I", way.strength.clone()) * cosine, LineDetail::Numbers);
        }

        let quantities = &mut explanation.quantities;
        quantities.extend(rows_of_vector(["w.x", "w.y", "w.z"], w, |axis| {
            self.columns(|_, plain| Some(plain.ways.get(at)?.way[axis]))
        }));
        let columns = self.columns(|_, plain| Some(plain.ways.get(at)?.cosine));
        quantities.push(columns.against("n·ω", Some(&way.cosine)));
        let columns = self.columns(|_, plain| Some(plain.ways.get(at)?.in_the_way?.1));
        if root.is_some() || columns.0.into_iter().any(|entry| entry.flatten().is_some()) {
            quantities.push(columns.against("s", root.as_ref()));
        }
        let is_gray = lamp.weight[0] == lamp.weight[1] && lamp.weight[1] == lamp.weight[2];
        let shown = if is_gray { &["I·n·ω"][..] } else { &CHANNELS };
        for (channel, symbol) in shown.iter().enumerate() {
            let columns = self.columns(|kernel, plain| {
                Some(gives_plainly(kernel, plain.ways.get(at)?, lamp.weight[channel]))
            });
            quantities.push(columns.against(symbol, Some(&way.gives(channel))));
        }
        explanation.lines = told.lines;
        explanation.why = self.why(&explanation.verdict, lamp, at, (is_at_point, root.as_ref()));
    }

    /// Why a light counts or not, and which kernel has it otherwise.
    fn why(
        &self,
        verdict: &LightVerdict,
        lamp: &Lamp,
        at: usize,
        (is_at_point, root): (bool, Option<&Root>),
    ) -> Vec<Remark> {
        let words = self.numbers.words;
        let label = |id| self.numbers.label(self.scene, id);
        let mut why = vec![match verdict {
            LightVerdict::Counts if lamp.origin == LampOrigin::Eye => words.counts_at_eye.into(),
            LightVerdict::Counts if lamp.shadows => words.counts.into(),
            LightVerdict::Counts => words.counts_without_shadow.into(),
            LightVerdict::Behind => words.behind_surface.into(),
            LightVerdict::Grazing if is_at_point => words.light_at_point.into(),
            LightVerdict::Grazing => words.grazing.into(),
            LightVerdict::Hidden { by } => {
                let root =
                    root.map_or(String::new(), |root| Short::new(root, self.numbers.digits).text);
                Remark::of(words.hidden, [label(*by), root])
            }
            LightVerdict::Dark => words.dark.into(),
        }];
        for (kernel, column) in COLUMNS.into_iter().enumerate() {
            let Some(plain) = &self.plain[kernel] else { continue };
            let Some(way) = plain.ways.get(at) else { continue };
            let column = column.to_owned();
            why.push(match (way.in_the_way, verdict) {
                (None, LightVerdict::Counts) if way.cosine > 0.0 => continue,
                (Some(_), LightVerdict::Hidden { .. }) => continue,
                (None, LightVerdict::Behind | LightVerdict::Grazing) if way.cosine <= 0.0 => {
                    continue;
                }
                (Some((id, _)), _) => Remark::of(words.wrong_in_the_way, [column, label(id)]),
                (None, _) if way.cosine > 0.0 => Remark::of(words.wrong_counting, [column]),
                (None, _) => Remark::of(words.wrong_behind, [column]),
            });
        }
        why
    }

    fn sky(&self, ways: &[ExactWay], lighting: &Lighting, first: usize) -> Option<SkyExplanation> {
        let sky = self.scene.sky?;
        let n = |verdict: fn(&LightVerdict) -> bool| {
            ways.iter().filter(|way| verdict(&way.verdict())).count()
        };
        let counting = n(|verdict| *verdict == LightVerdict::Counts);
        let hidden = n(|verdict| matches!(verdict, LightVerdict::Hidden { .. }));
        let n_plain = self.columns(|_, plain| {
            let counting = plain.ways.get(first..)?.iter().filter(|way| counts_plainly(way));
            Some(counting.count() as f64)
        });
        let given = self.columns(|kernel, plain| {
            let each = plain.ways.get(first..)?.iter().zip(&lighting.lamps[first..]);
            let each = each.map(|(way, lamp)| gives_plainly(kernel, way, lamp.weight[0]));
            Some(match kernel {
                2 => each.sum(),
                _ => f64::from(each.map(|given| given as f32).sum::<f32>()),
            })
        });
        Some(SkyExplanation {
            directions: sky.directions as usize,
            counting,
            behind: ways.len() - counting - hidden,
            hidden,
            quantities: vec![
                n_plain.against("suns", Some(&Root::from(integer(counting as i64)))),
                given.against("ΣI·n·ω", Some(&sum_of(ways, 0))),
            ],
        })
    }

    fn lit_color(
        &self,
        id: u32,
        ways: &[ExactWay],
        lighting: &Lighting,
        point: &LitPoint,
    ) -> ColorExplanation {
        let color = self.scene.color(id).0;
        let mut mean = ExactMean::new(1, Some(lighting));
        add_sample(&mut mean, self.scene, id, Some(point));
        let mut found =
            self.color(&mean, |channel, plain| Some(color[channel] * plain.light[channel]));
        let (mut told, words) = (Derivation::new(self.numbers.digits), self.numbers.words);
        for (channel, name) in words.channels.into_iter().enumerate() {
            let (c, a) = (of_scene("c", color[channel]), of_scene("a", lighting.ambient[channel]));
            let names = [name, &format!(r"\text{{{name}}}")];
            let formula = r"c\,(a + \textstyle\sum I\,\vec{n} \cdot \vec{\omega})";
            let sum = number("Σ", sum_of(ways, channel));
            told.said(names, [words.channel_formula, formula], c * (a + sum));
        }
        found.lines = told.lines;
        found
    }

    /// `at (4, 6, 3)`
    fn place_of(&self, source: Source) -> Remark {
        let words = self.numbers.words;
        match source {
            Source::Point(position) => {
                Remark::of(words.at_point, position.to_array().map(decimal_f64))
            }
            Source::Sun(direction) => Remark::of(words.sun, direction.to_array().map(decimal_f64)),
            Source::Eye => words.at_eye.into(),
        }
    }

    /// A colour, with what the kernels make of it.
    fn color(
        &self,
        mean: &ExactMean,
        of: impl Fn(usize, &PlainPoint) -> Option<f64>,
    ) -> ColorExplanation {
        let values: [Root; 3] =
            std::array::from_fn(|channel| enclosed(|n_bits| Some(mean.enclosed(channel, n_bits))));
        let channels: [ChannelByte; 3] =
            std::array::from_fn(|channel| ChannelByte::new(mean, channel, &values[channel]));
        let mut why = Vec::new();
        let quantity = |channel: usize| {
            let columns = self.columns(|_, plain| of(channel, plain));
            let all = columns.0;
            for (column, value) in COLUMNS.into_iter().zip(all) {
                let Some(Some(value)) = value else { continue };
                let (byte, right) = (Edges::srgb8().number(value), channels[channel].byte);
                if byte != u16::from(right) {
                    let words = self.numbers.words;
                    let parts = [column, words.channels[channel], &byte.to_string()];
                    why.push(Remark::of(words.wrong_byte, parts));
                }
            }
            let is_known = all.into_iter().flatten().any(|value| value.is_some());
            let columns = if is_known { columns } else { Columns([None; 3]) };
            columns.against(CHANNELS[channel], Some(&values[channel]))
        };
        let quantities = (0..3).map(quantity).collect();
        ColorExplanation { channels, quantities, why, lines: Vec::new() }
    }

    fn mean(
        &self,
        lighting: Option<&Lighting>,
        pixels: &Pixels,
        n_samples: u32,
    ) -> Option<ColorExplanation> {
        let of_samples = pixels.samples(n_samples);
        let rays = ExactPixels::new(&of_samples);
        let pixel = (pixels.x, pixels.y);
        let samples =
            samples_of_pixel(self.scene, lighting, (&of_samples, &rays), n_samples, pixel);
        let mut mean = ExactMean::new(samples.len() as u64, lighting);
        for (id, point) in &samples {
            add_sample(&mut mean, self.scene, *id, point.as_ref());
        }
        Some(self.color(&mean, |_, _| None))
    }
}

impl ChannelByte {
    fn new(mean: &ExactMean, channel: usize, value: &Root) -> ChannelByte {
        let edges = Edges::srgb8();
        let byte = mean.srgb8(channel);
        let (low, high) = edges.range(byte.into());
        let distance = |end: f64| {
            let away = value.minus(&real(end)?);
            Some(if away.signum() < 0 { away.negated() } else { away })
        };
        let from_edge = [low, high].into_iter().filter_map(distance).min();
        ChannelByte {
            name: CHANNELS[channel],
            byte,
            range: [low, high],
            from_edge: Exact::from(&from_edge.unwrap_or_else(|| Root::from(Dyadic::zero()))),
        }
    }
}

/// The way from the point to a lamp, exactly.
struct ExactWay<'a> {
    beam: ExactBeam<'a>,
    /// `n·ω`
    cosine: Root,
    /// `I`
    strength: [Root; 3],
    /// The first object in the way.
    hidden_by: Option<(u32, Shape)>,
}

impl<'a> ExactWay<'a> {
    fn new(
        scene: &Scene,
        lamp: &Lamp,
        lighting: &Lighting,
        point: &'a LitPoint,
    ) -> Option<ExactWay<'a>> {
        let beam = point.beam(lamp)?;
        let cosine = match beam.slope(&point.shape) {
            None => Root::from(Dyadic::zero()),
            Some((sign, cosine)) => {
                let magnitude = enclosed(|n_bits| Some(cosine.enclose(n_bits)));
                if sign < 0 { magnitude.negated() } else { magnitude }
            }
        };
        let strength =
            lamp.exact_weight.each_ref().map(|x| Root::ratio(x.clone(), lighting.n_shares));
        let mut way = ExactWay { beam, cosine, strength, hidden_by: None };
        if way.cosine.signum() > 0 {
            let mut all = point.in_the_way(scene, lamp, &way.beam);
            way.hidden_by = match lamp.light {
                None => all.next(),
                Some(_) => all
                    .map(|(id, shape)| (way.first_root(&shape), id, shape))
                    .min_by(|a, b| a.0.cmp(&b.0).then(a.1.cmp(&b.1)))
                    .map(|(_, id, shape)| (id, shape)),
            };
        }
        Some(way)
    }

    /// `s` of an object that is in the way.
    fn first_root(&self, shape: &Shape) -> Root {
        enclosed(|n_bits| self.beam.first_root(shape, n_bits))
    }

    fn verdict(&self) -> LightVerdict {
        match (self.cosine.signum(), &self.hidden_by) {
            (-1, _) => LightVerdict::Behind,
            (0, _) => LightVerdict::Grazing,
            (_, Some((by, _))) => LightVerdict::Hidden { by: *by },
            _ => LightVerdict::Counts,
        }
    }

    /// A channel of what the lamp gives.
    fn gives(&self, channel: usize) -> Root {
        match self.verdict() {
            LightVerdict::Counts => self.strength[channel].times(&self.cosine),
            _ => Root::from(Dyadic::zero()),
        }
    }
}

/// What lamps give together.
fn sum_of(ways: &[ExactWay], channel: usize) -> Root {
    let given = ways.iter().map(|way| way.gives(channel));
    given.fold(Root::from(Dyadic::zero()), |sum, given| sum.plus(&given))
}

fn counts_plainly(way: &PlainWay) -> bool {
    way.cosine > 0.0 && way.in_the_way.is_none()
}

/// What a lamp of a weight gives in a kernel's arithmetic.
fn gives_plainly(kernel: usize, way: &PlainWay, weight: f64) -> f64 {
    match (counts_plainly(way), kernel) {
        (false, _) => 0.0,
        (true, 2) => weight * way.cosine,
        (true, _) => f64::from(weight as f32 * way.cosine as f32),
    }
}
