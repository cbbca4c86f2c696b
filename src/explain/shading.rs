//! [`Shading`]: light and colour in f32, in f64 and exactly.

use glam::DVec3;
use rayon::prelude::*;

use super::formula::{PointSteps, Surface, WayFrom, WaySteps, of_channel, of_light, of_point};
use super::light::{
    Channel, ColorExplanation, LightExplanation, MeanExplanation, PointExplanation, Shading,
    SkyExplanation, Verdict,
};
use super::numbers::{Columns, Exact, Short, decimal_f64, enclosed, enclosed_if_possible};
use super::ray::RayNumbers;
use super::words::Remark;
use crate::exact::{
    ExactBeam, ExactCosine, ExactHit, ExactPixels, Real, Root, Shape, Side, exact, integer,
    product3, real, real3,
};
use crate::kernel::Kernel;
use crate::prepare::Prepared;
use crate::rays::{Lens, Pixels, Ray, Rays, View};
use crate::scene::{Edges, Scene, Source};
use crate::shade::{
    ExactMean, Lamp, Lighting, LitPoint, Origin, PlainPoint, PlainWay, add_sample, mean_divisor,
    plainly,
};
use crate::verify::samples_of_pixel;

const CHANNELS: [&str; 3] = ["red", "green", "blue"];

/// The names of the columns of the table, with the kernel of each.
const COLUMNS: [&str; 3] = ["f32 lecture", "f32 stable", "f64"];

/// What the kernels `lecture`, `stable` and `double` make of the light; none where one sees another
/// object.
pub(super) type Plain = [Option<PlainPoint>; 3];

/// All that lights the scene for a ray, whose origin is the eye where it is no pixel's; `None` where
/// a pixel shows the colour of its object.
pub(super) fn lighting(scene: &Scene, rays: &Rays) -> Option<Lighting> {
    let view = match rays {
        Rays::Pixels(pixels) => pixels.view,
        Rays::List(rays) => {
            let ray = rays.first()?;
            View {
                position: ray.origin,
                forward: ray.direction,
                right: DVec3::X,
                true_up: DVec3::Y,
                h: 1.0,
                lens: Lens::Perspective,
            }
        }
    };
    Lighting::new(scene, &view)
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
        let plain = plainly(prepared, self.rays, lighting.unwrap_or(&none));
        self.plain[column] = plain.filter(|plain| Some(plain.id) == right);
    }

    /// The light on the point that is seen; `None` for a scene without light and pixels of one sample.
    pub fn shading(
        &self,
        lighting: Option<&Lighting>,
        point: Option<&LitPoint>,
    ) -> Option<Shading> {
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
            let mut exact = ExactMean::new(mean_divisor(lighting, 1));
            add_sample(&mut exact, self.scene, lighting, id, None);
            let mut color = self.color(&exact, |_, _| None);
            if lighting.is_some() {
                color.why.push(Remark::plain(self.numbers.words.no_light_on_background));
            }
            return Some(Shading { lights: Vec::new(), sky: None, color, mean });
        };
        let ways: Vec<ExactWay> = lighting
            .lamps
            .par_iter()
            .map(|lamp| ExactWay::new(self.scene, lamp, point))
            .collect::<Option<_>>()?;
        let of_sky = lighting.lamps.iter().position(|lamp| lamp.light.is_none());
        let sky = of_sky.and_then(|first| self.sky(&ways[first..], lighting, first));
        Some(Shading {
            lights: self.lights(&ways, lighting, (hit, point))?,
            sky,
            color: self.lit_color(hit.id, &ways, lighting),
            mean,
        })
    }

    /// The point that the ray sees, exactly.
    pub fn lit_point(&self) -> Option<LitPoint> {
        let hit = self.hit?;
        let (eye, near) = match self.rays {
            Rays::Pixels(pixels) => {
                let (x, y) = (pixels.x, pixels.y);
                let (origin, direction) = (pixels.origin_offset(x, y), pixels.direction(x, y));
                (pixels.view.position, Ray { origin, direction })
            }
            Rays::List(rays) => {
                let &Ray { origin, direction } = rays.first()?;
                (origin, Ray { origin: DVec3::ZERO, direction })
            }
        };
        LitPoint::new(self.scene, &self.numbers.exact, hit, (eye, &near))
    }

    /// A number in each arithmetic; `None` where the kernel sees another object.
    fn columns(&self, of: impl Fn(usize, &PlainPoint) -> Option<f64>) -> Columns {
        let [lecture, stable, double] =
            std::array::from_fn(|kernel| self.plain[kernel].as_ref().map(|at| of(kernel, at)));
        Columns { lecture, stable, double }
    }

    pub fn point(&self, hit: &ExactHit, point: &LitPoint) -> Option<PointExplanation> {
        let (at, normal) =
            (point.exact.coordinates(), hit.normal(&self.numbers.exact, &point.shape)?);
        let mut quantities = Vec::new();
        for (axis, symbol) in ["p.x", "p.y", "p.z"].into_iter().enumerate() {
            let world = |kernel, plain: &PlainPoint| {
                let origin = if kernel == 2 { self.reference[axis] } else { 0.0 };
                Some(origin + plain.at[axis])
            };
            let columns = Columns { stable: None, ..self.columns(world) };
            quantities.push(columns.against(symbol, Some(&at[axis])));
        }
        let residual =
            |kernel, plain: &PlainPoint| self.numbers.residual(self.scene, kernel, plain);
        let exact = point.exact.residual(&point.shape)?;
        quantities.push(self.columns(residual).against("f(p)", Some(&exact)));
        for (axis, symbol) in ["n.x", "n.y", "n.z"].into_iter().enumerate() {
            let columns = self.columns(|_, plain| Some(plain.normal[axis]));
            quantities.push(columns.against(symbol, Some(&normal[axis])));
        }
        let (base, surface) = match point.shape {
            Shape::Sphere { center, radius } => {
                (center, Surface::Sphere(Root::from(real(radius)?)))
            }
            Shape::Plane { point, normal } => {
                let n = real3(normal)?;
                let length = Root::new(Real::zero(), 1, product3(&n, &n), Real::one(), 1);
                (point, Surface::Plane(Box::new(n.map(Root::from)), length))
            }
        };
        let base = real3(base)?;
        let [origin, direction] = self.numbers.origin_and_direction();
        let steps = PointSteps {
            origin,
            direction,
            t: hit.root.clone(),
            from_base: std::array::from_fn(|axis| at[axis].minus(&base[axis])),
            at,
            base: base.map(Root::from),
            surface,
            residual: exact,
            normal,
            is_turned: hit.side == Side::Back,
        };
        Some(PointExplanation { quantities, lines: of_point(steps, self.numbers.digits) })
    }

    fn lights(
        &self,
        ways: &[ExactWay],
        lighting: &Lighting,
        seen: (&ExactHit, &LitPoint),
    ) -> Option<Vec<LightExplanation>> {
        let of_lamp = |index| lighting.lamps.iter().position(|lamp| lamp.light == Some(index));
        (0..self.scene.lights.len())
            .map(|index| match of_lamp(index) {
                Some(at) => self.light((index, at), &ways[at], lighting, seen),
                None => Some(self.dark(index)),
            })
            .collect()
    }

    fn dark(&self, index: usize) -> LightExplanation {
        LightExplanation {
            name: self.name_of(index),
            place: self.place_of(self.scene.lights[index].source),
            verdict: Verdict::Dark,
            why: vec![Remark::plain(self.numbers.words.dark)],
            quantities: Vec::new(),
            lines: Vec::new(),
        }
    }

    fn light(
        &self,
        (index, at): (usize, usize),
        way: &ExactWay,
        lighting: &Lighting,
        (hit, point): (&ExactHit, &LitPoint),
    ) -> Option<LightExplanation> {
        let lamp = &lighting.lamps[at];
        let (beam, cosine) = (&way.beam, way.cosine());
        let root = way
            .hidden_by
            .as_ref()
            .map(|(_, shape)| enclosed_if_possible(|n_bits| beam.first_root(shape, n_bits)));
        let components = beam.components();
        let mut quantities = Vec::new();
        for (axis, symbol) in ["w.x", "w.y", "w.z"].into_iter().enumerate() {
            let columns = self.columns(|_, plain| Some(plain.ways.get(at)?.way[axis]));
            quantities.push(columns.against(symbol, Some(&components[axis])));
        }
        let columns = self.columns(|_, plain| Some(plain.ways.get(at)?.cosine));
        quantities.push(columns.against("n·ω", Some(&cosine)));
        let columns = self.columns(|_, plain| Some(plain.ways.get(at)?.in_the_way?.1));
        let is_met = |entry: Option<Option<f64>>| entry.flatten().is_some();
        if root.is_some()
            || [columns.lecture, columns.stable, columns.double].into_iter().any(is_met)
        {
            quantities.push(columns.against("s", root.as_ref()));
        }
        let gives: [Root; 3] = std::array::from_fn(|channel| way.gives(lamp, lighting, channel));
        let is_gray = lamp.weight[0] == lamp.weight[1] && lamp.weight[1] == lamp.weight[2];
        let shown = if is_gray { &["I·n·ω"][..] } else { &CHANNELS };
        for (channel, symbol) in shown.iter().enumerate() {
            let columns = self.columns(|kernel, plain| {
                Some(gives_plainly(kernel, plain.ways.get(at)?, lamp.weight[channel]))
            });
            quantities.push(columns.against(symbol, Some(&gives[channel])));
        }
        let verdict = way.verdict();
        let strength: [Root; 3] = std::array::from_fn(|channel| {
            Root::ratio(lamp.exact_weight[channel].clone(), lighting.n_shares)
        });
        let from = match (self.scene.lights[index].source, lamp.origin) {
            (Source::Point(position), _) => {
                WayFrom::Point(real3(position)?.map(Root::from), point.exact.coordinates())
            }
            (Source::Sun(_), _) => WayFrom::Sun,
            (Source::Eye, Origin::Sun(_)) => WayFrom::Axis,
            (Source::Eye, _) => {
                let [origin, _] = self.numbers.origin_and_direction();
                WayFrom::Eye(origin, point.exact.coordinates())
            }
        };
        let why = self.why(&verdict, lamp, at, (&components, root.as_ref()));
        let steps = WaySteps {
            normal: hit.normal(&self.numbers.exact, &point.shape)?,
            way: components,
            from,
            cosine,
            root,
            gives: (verdict == Verdict::Counts).then_some([strength, gives]),
        };
        Some(LightExplanation {
            name: self.name_of(index),
            place: self.place_of(self.scene.lights[index].source),
            why,
            verdict,
            quantities,
            lines: of_light(steps, self.numbers.digits),
        })
    }

    /// Why a light counts or not, and which kernel has it otherwise.
    fn why(
        &self,
        verdict: &Verdict,
        lamp: &Lamp,
        at: usize,
        (way, root): (&[Root; 3], Option<&Root>),
    ) -> Vec<Remark> {
        let words = self.numbers.words;
        let label = |id| self.numbers.label(self.scene, id);
        let is_at_point = way.iter().all(|component| component.signum() == 0);
        let mut why = vec![match verdict {
            Verdict::Counts if lamp.origin == Origin::Eye => Remark::plain(words.counts_at_eye),
            Verdict::Counts if lamp.shadows => Remark::plain(words.counts),
            Verdict::Counts => Remark::plain(words.counts_without_shadow),
            Verdict::Behind => Remark::plain(words.behind_surface),
            Verdict::Grazing if is_at_point => Remark::plain(words.light_at_point),
            Verdict::Grazing => Remark::plain(words.grazing),
            Verdict::Hidden { by } => {
                let root =
                    root.map_or(String::new(), |root| Short::new(root, self.numbers.digits).text);
                Remark::new(words.hidden, [label(*by), root])
            }
            Verdict::Dark => Remark::plain(words.dark),
        }];
        for (kernel, column) in COLUMNS.into_iter().enumerate() {
            let Some(plain) = &self.plain[kernel] else { continue };
            let Some(way) = plain.ways.get(at) else { continue };
            let column = column.to_owned();
            why.push(match (way.in_the_way, verdict) {
                (None, Verdict::Counts) if way.cosine > 0.0 => continue,
                (Some(_), Verdict::Hidden { .. }) => continue,
                (None, Verdict::Behind | Verdict::Grazing) if way.cosine <= 0.0 => continue,
                (Some((id, _)), _) => Remark::new(words.wrong_in_the_way, [column, label(id)]),
                (None, _) if way.cosine > 0.0 => Remark::new(words.wrong_counting, [column]),
                (None, _) => Remark::new(words.wrong_behind, [column]),
            });
        }
        why
    }

    fn sky(&self, ways: &[ExactWay], lighting: &Lighting, first: usize) -> Option<SkyExplanation> {
        let sky = self.scene.sky?;
        let n = |verdict: fn(&Verdict) -> bool| {
            ways.iter().filter(|way| verdict(&way.verdict())).count()
        };
        let counting = n(|verdict| *verdict == Verdict::Counts);
        let hidden = n(|verdict| matches!(verdict, Verdict::Hidden { .. }));
        let mut sum = ExactMean::new(lighting.n_shares.into());
        for (way, lamp) in ways.iter().zip(&lighting.lamps[first..]) {
            if let Some(cosine) = way.counted() {
                sum.add_light(cosine.clone(), lamp.exact_weight.clone());
            }
        }
        let plain = |plain: &PlainPoint| plain.ways.get(first..).map(<[_]>::to_vec);
        let n_plain = self.columns(|_, at| {
            let counting = plain(at)?.iter().filter(|way| counts_plainly(way)).count();
            Some(counting as f64)
        });
        let given = self.columns(|kernel, at| {
            let ways = plain(at)?;
            let each = ways.iter().zip(&lighting.lamps[first..]);
            let each = each.map(|(way, lamp)| gives_plainly(kernel, way, lamp.weight[0]));
            Some(match kernel {
                2 => each.sum(),
                _ => f64::from(each.map(|given| given as f32).sum::<f32>()),
            })
        });
        let given_exactly = enclosed(|n_bits| sum.enclosed(0, n_bits));
        Some(SkyExplanation {
            directions: sky.directions as usize,
            counting,
            behind: ways.len() - counting - hidden,
            hidden,
            quantities: vec![
                n_plain.against("suns", Some(&Root::from(integer(counting as i64)))),
                given.against("ΣI·n·ω", Some(&given_exactly)),
            ],
        })
    }

    fn lit_color(&self, id: u32, ways: &[ExactWay], lighting: &Lighting) -> ColorExplanation {
        let color = self.scene.color(id).0;
        let exact_color = color.map(exact);
        let shares = integer(lighting.n_shares.into());
        let divisor = mean_divisor(Some(lighting), 1);
        let (mut whole, mut lamps) = (ExactMean::new(divisor), ExactMean::new(divisor));
        for (channel, part) in exact_color.iter().enumerate() {
            whole.add(channel, &(exact(lighting.ambient[channel]) * &shares * part));
        }
        for (way, lamp) in ways.iter().zip(&lighting.lamps) {
            if let Some(cosine) = way.counted() {
                let weight = &lamp.exact_weight;
                lamps.add_light(cosine.clone(), weight.clone());
                let weights =
                    std::array::from_fn(|channel| &weight[channel] * &exact_color[channel]);
                whole.add_light(cosine.clone(), weights);
            }
        }
        let mut found =
            self.color(&whole, |channel, plain| Some(color[channel] * plain.light[channel]));
        let line = |channel: usize| {
            let words = self.numbers.words;
            let sum = enclosed(|n_bits| lamps.enclosed(channel, n_bits));
            let value = enclosed(|n_bits| whole.enclosed(channel, n_bits));
            let [color, ambient] =
                [color, lighting.ambient].map(|numbers| Root::from(exact(numbers[channel])));
            let forms = (words.channel_forms[channel], words.channels[channel]);
            of_channel(forms, [color, ambient, sum, value], self.numbers.digits)
        };
        found.lines = (0..3).map(line).collect();
        found
    }

    /// `light 1`
    fn name_of(&self, index: usize) -> String {
        format!("{} {}", self.numbers.words.light, index + 1)
    }

    /// `at (4, 6, 3)`
    fn place_of(&self, source: Source) -> Remark {
        let words = self.numbers.words;
        match source {
            Source::Point(position) => {
                Remark::new(words.at_point, position.to_array().map(decimal_f64))
            }
            Source::Sun(direction) => Remark::new(words.sun, direction.to_array().map(decimal_f64)),
            Source::Eye => Remark::plain(words.at_eye),
        }
    }

    /// A colour, with what the kernels make of it.
    fn color(
        &self,
        mean: &ExactMean,
        of: impl Fn(usize, &PlainPoint) -> Option<f64>,
    ) -> ColorExplanation {
        let values: [Root; 3] =
            std::array::from_fn(|channel| enclosed(|n_bits| mean.enclosed(channel, n_bits)));
        let channels: [Channel; 3] =
            std::array::from_fn(|channel| Channel::new(mean, channel, &values[channel]));
        let mut why = Vec::new();
        let quantity = |channel: usize| {
            let columns = self.columns(|_, plain| of(channel, plain));
            let all = [columns.lecture, columns.stable, columns.double];
            for (column, value) in COLUMNS.into_iter().zip(all) {
                let Some(Some(value)) = value else { continue };
                let (byte, right) = (Edges::srgb8().number(value), channels[channel].byte);
                if byte != u16::from(right) {
                    let words = self.numbers.words;
                    let parts = [column, words.channels[channel], &byte.to_string()];
                    why.push(Remark::new(words.wrong_byte, parts));
                }
            }
            let is_known = all.into_iter().flatten().any(|value| value.is_some());
            let columns = if is_known { columns } else { Columns::NONE };
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
        let mut mean = ExactMean::new(mean_divisor(lighting, n_samples));
        for (id, point) in &samples {
            add_sample(&mut mean, self.scene, lighting, *id, point.as_ref());
        }
        Some(self.color(&mean, |_, _| None))
    }
}

impl Channel {
    fn new(mean: &ExactMean, channel: usize, value: &Root) -> Channel {
        let edges = Edges::srgb8();
        let guess = edges.number(mean.approximate(channel));
        let code = mean.code(channel, guess, 255, |code| edges.range(code).0);
        let (low, high) = edges.range(code);
        let distance = |end: f64| {
            let away = value.minus(&real(end)?);
            Some(if away.signum() < 0 { away.negated() } else { away })
        };
        let from_edge = [low, high].into_iter().filter_map(distance).min();
        Channel {
            name: CHANNELS[channel],
            byte: code as u8,
            range: [low, high],
            from_edge: Exact::from(&from_edge.unwrap_or_else(|| Root::from(Real::zero()))),
        }
    }
}

/// The way from the point to a lamp, exactly.
struct ExactWay<'a> {
    beam: ExactBeam<'a>,
    slope: Option<(i32, ExactCosine<'a>)>,
    /// The first object in the way.
    hidden_by: Option<(u32, Shape)>,
}

impl<'a> ExactWay<'a> {
    fn new(scene: &Scene, lamp: &Lamp, point: &'a LitPoint) -> Option<ExactWay<'a>> {
        let beam = point.beam(lamp)?;
        let slope = beam.slope(&point.shape);
        let is_asked = slope.as_ref().is_some_and(|(sign, _)| *sign > 0);
        let hidden_by = match (is_asked, lamp.light) {
            (false, _) => None,
            (true, None) => point.in_the_way(scene, lamp, &beam).next(),
            (true, Some(_)) => {
                let root =
                    |shape: &Shape| enclosed_if_possible(|n_bits| beam.first_root(shape, n_bits));
                let all = point
                    .in_the_way(scene, lamp, &beam)
                    .map(|(id, shape)| (root(&shape), id, shape));
                all.min_by(|a, b| a.0.cmp(&b.0).then(a.1.cmp(&b.1)))
                    .map(|(_, id, shape)| (id, shape))
            }
        };
        Some(ExactWay { beam, slope, hidden_by })
    }

    fn verdict(&self) -> Verdict {
        match (&self.slope, &self.hidden_by) {
            (None, _) => Verdict::Grazing,
            (Some((sign, _)), _) if *sign < 0 => Verdict::Behind,
            (_, Some((by, _))) => Verdict::Hidden { by: *by },
            _ => Verdict::Counts,
        }
    }

    fn counted(&self) -> Option<&ExactCosine<'a>> {
        self.slope.as_ref().filter(|_| self.verdict() == Verdict::Counts).map(|(_, cosine)| cosine)
    }

    /// `n·ω`
    fn cosine(&self) -> Root {
        let Some((sign, cosine)) = &self.slope else { return Root::from(Real::zero()) };
        let magnitude = enclosed(|n_bits| cosine.enclose(n_bits));
        if *sign < 0 { magnitude.negated() } else { magnitude }
    }

    /// A channel of what the lamp gives.
    fn gives(&self, lamp: &Lamp, lighting: &Lighting, channel: usize) -> Root {
        let Some(cosine) = self.counted() else { return Root::from(Real::zero()) };
        let mut sum = ExactMean::new(lighting.n_shares.into());
        sum.add_light(cosine.clone(), lamp.exact_weight.clone());
        enclosed(|n_bits| sum.enclosed(channel, n_bits))
    }
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
