//! A second opinion on light, samples and colours: the contract's meaning of a pixel by solving
//! quadratics in enclosures and looking where their roots lie.
//!
//! It shares nothing with the crate but the scene's types and the camera's numbers. A question is asked
//! in f64 first and then with more and more bits, until the enclosure tells, or is so narrow that the
//! number must be 0 (`enclosure.rs`). For that, all lengths are made integers by one power of
//! two, and nothing is divided: a hit point is `P/m`, where `P` has integers and one square root.
//! A test that takes this module takes `enclosure.rs` as its module `enclosure`.
#![allow(dead_code)] // each test uses what it needs

use std::cmp::Ordering::{Equal, Greater, Less};
use std::sync::OnceLock;

use glam::DVec3;
use kugelblitz::rays::{Lens, View};
use kugelblitz::scene::{Color, Light, Scene, Source, linear_from_srgb};
use kugelblitz::shade::Background;

use crate::enclosure::{Big, Narrow, Number, Undecided, dot, integer_shift, norm2};

/// Bits of the enclosures, one after the other; the first stands for f64.
const LEVELS: [u64; 9] = [53, 160, 480, 1440, 4320, 12_960, 38_880, 116_640, 349_920];

/// From here on, an enclosure that still touches an edge counts as equal to it.
pub const TIE_BITS: u64 = 4096;

/// Where light comes from, with nothing left to look up.
#[derive(Clone, Copy, Debug)]
pub struct Lamp {
    pub source: LampSource,
    pub color: Color,
    /// The light's intensity is the product of these over the divisor.
    pub factors: [f64; 2],
    pub divisor: u32,
    pub shadows: bool,
}

#[derive(Clone, Copy, Debug)]
pub enum LampSource {
    Point(DVec3),
    /// The way that its light travels.
    Sun(DVec3),
}

/// One number of a pixel, and whether the exact one lies on an edge of its range as far as
/// [`TIE_BITS`] tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer<T> {
    pub value: T,
    pub is_tie: bool,
}

/// One colour channel of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// The exact mean lies from the first to just above the second (`f64::next_up`).
    pub mean: [f64; 2],
    pub srgb8: Answer<u8>,
    pub srgb16: Answer<u16>,
    pub linear: Answer<f32>,
}

/// A pixel by the contract.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// What the centre ray sees.
    pub id: u32,
    /// Samples that hit something.
    pub n_hits: u32,
    pub channels: [Channel; 3],
    /// Bits that it took.
    pub bits: u64,
}

impl Truth {
    pub fn srgb8(&self) -> [u8; 3] {
        self.channels.map(|channel| channel.srgb8.value)
    }

    pub fn srgb16(&self) -> [u16; 3] {
        self.channels.map(|channel| channel.srgb16.value)
    }

    pub fn linear(&self) -> [f32; 3] {
        self.channels.map(|channel| channel.linear.value)
    }
}

/// A scene, seen as a picture.
pub struct Oracle<'a> {
    scene: &'a Scene,
    view: View,
    width: u32,
    height: u32,
    samples: u32,
    background: Background,
    /// By id.
    colors: Vec<Color>,
    lamps: Vec<Lamp>,
    shifts: Shifts,
    narrow: Model<Narrow>,
    /// The first levels of more bits, made when they are first asked.
    models: [OnceLock<Model<Big>>; 4],
}

/// The powers of two that make integers.
#[derive(Clone, Copy, Debug)]
struct Shifts {
    length: i64,
    /// Of the camera's unit vectors.
    frame: i64,
    /// Of the camera's `h`.
    h: i64,
}

/// All numbers of a scene as enclosures.
struct Model<N> {
    bits: u64,
    spheres: Vec<SphereNumbers<N>>,
    planes: Vec<PlaneNumbers<N>>,
    lamps: Vec<LampNumbers<N>>,
}

struct SphereNumbers<N> {
    center: [N; 3],
    radius: N,
    radius2: N,
}

struct PlaneNumbers<N> {
    point: [N; 3],
    normal: [N; 3],
}

struct LampNumbers<N> {
    /// The point, or the way towards the sun.
    place: [N; 3],
    is_point: bool,
    /// By channel.
    strength: [N; 3],
}

/// Where a ray meets an object: at `numerator/denominator`.
struct Root<N> {
    id: u32,
    numerator: N,
    denominator: N,
}

/// A hit point `P/m` with a normal that faces the ray.
struct Surface<N> {
    id: u32,
    point: [N; 3],
    m: N,
    /// Of any length.
    normal: [N; 3],
    length: N,
}

/// A sample: the object, or 0, and its colour.
pub struct Sample {
    pub id: u32,
    pub rgb: [Big; 3],
    pub bits: u64,
}

fn v3<N: Number>(v: DVec3, shift: i64, bits: u64) -> [N; 3] {
    v.to_array().map(|x| N::new(x, shift, bits))
}

fn sum<N: Number>(u: &[N; 3], v: &[N; 3]) -> [N; 3] {
    std::array::from_fn(|i| u[i].plus(&v[i]))
}

fn difference<N: Number>(u: &[N; 3], v: &[N; 3]) -> [N; 3] {
    std::array::from_fn(|i| u[i].minus(&v[i]))
}

fn scaled<N: Number>(v: &[N; 3], factor: &N) -> [N; 3] {
    std::array::from_fn(|i| v[i].times(factor))
}

impl<'a> Oracle<'a> {
    /// The scene's picture with its camera and its samples.
    pub fn new(scene: &'a Scene, width: u32, height: u32) -> Oracle<'a> {
        let view = View::new(scene.camera.as_ref().expect("a camera"));
        Oracle::with_view(scene, view, width, height, scene.samples.unwrap_or(1))
    }

    pub fn with_view(
        scene: &'a Scene,
        view: View,
        width: u32,
        height: u32,
        samples: u32,
    ) -> Oracle<'a> {
        let lamps = lamps(scene, &view);
        let shifts = Shifts::new(scene, &view, &lamps);
        let factor = length_factor(&view, samples * height);
        let narrow = Model::new(scene, &lamps, shifts, factor, 53);
        let models = std::array::from_fn(|_| OnceLock::new());
        let colors = scene.colors().collect();
        let background = Background::Shown;
        Oracle {
            scene,
            view,
            width,
            height,
            samples,
            background,
            colors,
            lamps,
            shifts,
            narrow,
            models,
        }
    }

    /// The same where samples that hit nothing count otherwise.
    pub fn before(self, background: Background) -> Oracle<'a> {
        Oracle { background, ..self }
    }

    pub fn lamps(&self) -> &[Lamp] {
        &self.lamps
    }

    /// The contract's pixel in column `x` of row `y`.
    pub fn pixel(&self, x: u32, y: u32) -> Truth {
        let n = self.samples;
        for bits in LEVELS {
            let sample = |k: u32| self.sample(self.offset(n * x + k % n, n * y + k / n), bits);
            let samples: Vec<Sample> = (0..n * n).map(sample).collect();
            let bits = samples.iter().map(|sample| sample.bits).fold(bits, u64::max);
            let mean = self.mean(&samples, bits.max(160));
            let is_last = samples.iter().all(|sample| sample.bits >= TIE_BITS);
            let channels = mean.each_ref().map(|channel| Channel::new(channel, is_last));
            if let [Some(red), Some(green), Some(blue)] = channels {
                let n_hits = samples.iter().filter(|sample| sample.id != 0).count() as u32;
                let id = self.center_id(x, y);
                return Truth { id, n_hits, channels: [red, green, blue], bits };
            }
        }
        unreachable!("an edge is met or not at {TIE_BITS} bits")
    }

    fn mean(&self, samples: &[Sample], bits: u64) -> [Big; 3] {
        let seen: Vec<&Sample> = match self.background {
            Background::Shown => samples.iter().collect(),
            Background::LeftOut | Background::Black => {
                samples.iter().filter(|sample| sample.id != 0).collect()
            }
        };
        let n = match self.background {
            Background::LeftOut => seen.len().max(1),
            Background::Shown | Background::Black => samples.len(),
        };
        let n = Big::new(n as f64, 0, bits);
        std::array::from_fn(|channel| {
            let zero = Big::new(0.0, 0, bits);
            let sum = seen.iter().fold(zero, |sum, sample| sum.plus(&sample.rgb[channel]));
            sum.over(&n).expect("a positive number of samples")
        })
    }

    /// Twice the offset of a sample from the picture's middle, right and up, in samples. The samples of
    /// all pixels are the pixels of a larger picture: `x + (i + ½)/N` of `W` is as far across as
    /// `Nx + i + ½` of `NW`.
    fn offset(&self, column: u32, row: u32) -> [f64; 2] {
        let (columns, rows) = (self.samples * self.width, self.samples * self.height);
        [
            2.0 * f64::from(column) + 1.0 - f64::from(columns),
            f64::from(rows) - 2.0 * f64::from(row) - 1.0,
        ]
    }

    /// What the ray through the pixel's middle sees.
    fn center_id(&self, x: u32, y: u32) -> u32 {
        let n = f64::from(self.samples);
        let right = n * (2.0 * f64::from(x) + 1.0 - f64::from(self.width));
        let up = n * (f64::from(self.height) - 2.0 * f64::from(y) - 1.0);
        fn id<N: Number>(surface: Option<Surface<N>>) -> u32 {
            surface.map_or(0, |surface| surface.id)
        }
        let at_level = |bits| match bits {
            53 => self.seen(&self.narrow, [right, up]).map(id),
            _ => self.with_model(bits, |model| self.seen(model, [right, up]).map(id)),
        };
        decided(53, at_level).0
    }

    /// The sample with this offset, with at least these bits.
    fn sample(&self, offset: [f64; 2], bits: u64) -> Sample {
        let at_level = |bits| match bits {
            53 => self.color(&self.narrow, offset),
            _ => self.with_model(bits, |model| self.color(model, offset)),
        };
        let ((id, rgb), bits) = decided(bits, at_level);
        Sample { id, rgb, bits }
    }

    fn with_model<T>(&self, bits: u64, ask: impl FnOnce(&Model<Big>) -> T) -> T {
        let factor = length_factor(&self.view, self.samples * self.height);
        let make = || Model::new(self.scene, &self.lamps, self.shifts, factor, bits);
        let level = LEVELS.iter().position(|level| *level == bits).expect("a level");
        match self.models.get(level - 1) {
            Some(model) => ask(model.get_or_init(make)),
            None => ask(&make()),
        }
    }

    /// Origin and direction, which may be any positive number times the contract's.
    fn ray<N: Number>(&self, [right, up]: [f64; 2], bits: u64) -> ([N; 3], [N; 3]) {
        let Oracle { view, shifts, .. } = self;
        let int = |x: f64, shift: i64| N::new(x, shift, bits);
        let vector = |v: DVec3| v3::<N>(v, shifts.frame, bits);
        let across = |h: N| {
            sum(
                &scaled(&vector(view.right), &h.times(&int(right, 0))),
                &scaled(&vector(view.true_up), &h.times(&int(up, 0))),
            )
        };
        let rows = f64::from(self.samples * self.height);
        let position = v3::<N>(view.position, shifts.length, bits);
        match view.lens {
            Lens::Perspective => {
                let forward = scaled(&vector(view.forward), &int(rows, shifts.h));
                (position, sum(&forward, &across(int(view.h, shifts.h))))
            }
            Lens::Orthographic => {
                let across = across(int(view.h, shifts.length - shifts.frame));
                (sum(&scaled(&position, &int(rows, 0)), &across), vector(view.forward))
            }
        }
    }

    /// True where `t` rounds beyond the largest f32: the contract's `t` is the root times the direction's
    /// factor over that of lengths.
    fn is_too_far<N: Number>(&self, root: &Root<N>, bits: u64) -> Result<bool, Undecided> {
        let Shifts { length, frame, h } = self.shifts;
        let rows = self.samples * self.height;
        let (factor, shift) = match self.view.lens {
            Lens::Perspective => (rows, frame + h),
            Lens::Orthographic => (1, frame),
        };
        let direction = N::new(f64::from(factor), shift, bits);
        let length = N::new(f64::from(length_factor(&self.view, rows)), length, bits);
        let limit = N::new(f64::from(f32::MAX) + 2f64.powi(103), 0, bits);
        let t = root.numerator.times(&direction);
        Ok(t.minus(&limit.times(&length).times(&root.denominator)).sign()? != Less)
    }

    /// The nearest object with `t > 0`, and where it is met.
    fn seen<N: Number>(
        &self,
        model: &Model<N>,
        offset: [f64; 2],
    ) -> Result<Option<Surface<N>>, Undecided> {
        let (origin, direction) = self.ray::<N>(offset, model.bits);
        let a = norm2(&direction);
        let mut best: Option<Root<N>> = None;
        for (id, sphere) in (1..).zip(&model.spheres) {
            if sphere.radius.sign()? == Equal {
                continue;
            }
            let from_center = difference(&origin, &sphere.center);
            let k = norm2(&from_center).minus(&sphere.radius2);
            for numerator in numerators(&a, &dot(&direction, &from_center), &k)? {
                if numerator.sign()? == Greater {
                    let root = Root { id, numerator, denominator: a.clone() };
                    best = Some(nearer(best, root)?);
                    break;
                }
            }
        }
        for (id, plane) in (model.spheres.len() as u32 + 1..).zip(&model.planes) {
            let along = dot(&direction, &plane.normal);
            let to_plane = dot(&difference(&plane.point, &origin), &plane.normal);
            let (numerator, denominator) = match along.sign()? {
                Equal => continue,
                Greater => (to_plane, along),
                Less => (to_plane.negative(), along.negative()),
            };
            if numerator.sign()? == Greater {
                best = Some(nearer(best, Root { id, numerator, denominator })?);
            }
        }
        let Some(root) = best else {
            return Ok(None);
        };
        if self.is_too_far(&root, model.bits)? {
            return Ok(None);
        }
        let point = sum(&scaled(&origin, &root.denominator), &scaled(&direction, &root.numerator));
        let (id, m) = (root.id, root.denominator);
        let index = id as usize - 1;
        let (outward, length) = match model.spheres.get(index) {
            Some(sphere) => {
                (difference(&point, &scaled(&sphere.center, &m)), sphere.radius.times(&m))
            }
            None => {
                let normal = &model.planes[index - model.spheres.len()].normal;
                (normal.clone(), norm2(normal).root())
            }
        };
        let normal = match dot(&outward, &direction).sign()? {
            Greater => outward.each_ref().map(N::negative),
            _ => outward,
        };
        Ok(Some(Surface { id, point, m, normal, length }))
    }

    fn color<N: Number>(
        &self,
        model: &Model<N>,
        offset: [f64; 2],
    ) -> Result<(u32, [Big; 3]), Undecided> {
        let bits = model.bits;
        let number = |x: f64| N::new(x, 0, bits);
        let to_big = |rgb: [N; 3]| -> Result<[Big; 3], Undecided> {
            let [red, green, blue] = rgb;
            Ok([red.to_big(bits)?, green.to_big(bits)?, blue.to_big(bits)?])
        };
        let Some(surface) = self.seen(model, offset)? else {
            return Ok((0, to_big(self.scene.background.0.map(number))?));
        };
        let color = self.colors[surface.id as usize].0.map(number);
        if !self.scene.is_lit() {
            return Ok((surface.id, to_big(color)?));
        }
        let mut light = self.scene.ambient.unwrap_or(Color([0.0; 3])).0.map(number);
        for (lamp, numbers) in self.lamps.iter().zip(&model.lamps) {
            if let Some(cosine) = cosine(model, &surface, numbers, lamp.shadows)? {
                for (light, strength) in light.iter_mut().zip(&numbers.strength) {
                    *light = light.plus(&strength.times(&cosine));
                }
            }
        }
        Ok((surface.id, to_big(std::array::from_fn(|i| color[i].times(&light[i])))?))
    }
}

/// The answer of the first level from `bits` on that has one, and the level.
fn decided<T>(bits: u64, ask: impl Fn(u64) -> Result<T, Undecided>) -> (T, u64) {
    let mut levels = LEVELS.into_iter().filter(|level| *level >= bits);
    let answer = levels.find_map(|level| ask(level).ok().map(|answer| (answer, level)));
    answer.expect("at these bits, 0 is told from other numbers")
}

/// The roots of `a·t² + 2b·t + k` times `a > 0`, in order.
fn numerators<N: Number>(a: &N, b: &N, k: &N) -> Result<Vec<N>, Undecided> {
    let discriminant = b.squared().minus(&a.times(k));
    Ok(match discriminant.sign()? {
        Less => vec![],
        Equal => vec![b.negative()],
        Greater => {
            let root = discriminant.root();
            vec![b.plus(&root).negative(), root.minus(b)]
        }
    })
}

/// The smaller root; of equal ones the first.
fn nearer<N: Number>(best: Option<Root<N>>, root: Root<N>) -> Result<Root<N>, Undecided> {
    let Some(best) = best else {
        return Ok(root);
    };
    let both = [&root.numerator.times(&best.denominator), &best.numerator.times(&root.denominator)];
    Ok(if both[0].minus(both[1]).sign()? == Less { root } else { best })
}

/// `n·ω` of a light that counts.
fn cosine<N: Number>(
    model: &Model<N>,
    surface: &Surface<N>,
    lamp: &LampNumbers<N>,
    shadows: bool,
) -> Result<Option<N>, Undecided> {
    let Surface { point, m, normal, length, .. } = surface;
    let w = match lamp.is_point {
        true => difference(&scaled(&lamp.place, m), point),
        false => lamp.place.clone(),
    };
    let along = dot(normal, &w);
    if along.sign()? != Greater || (shadows && is_in_shadow(model, surface, &w, lamp.is_point)?) {
        return Ok(None);
    }
    along.over(&length.times(&norm2(&w).root())).map(Some)
}

/// True where something is met from the surface along `w`, before `w` ends where it ends at a light.
/// `P + s·w` is in units of `1/m`; a sun's `s` is `m` times the contract's.
fn is_in_shadow<N: Number>(
    model: &Model<N>,
    surface: &Surface<N>,
    w: &[N; 3],
    ends: bool,
) -> Result<bool, Undecided> {
    let Surface { id: own, point, m, .. } = surface;
    // `numerator/denominator`, with a denominator greater than 0.
    let is_in_way = |numerator: &N, denominator: &N| -> Result<bool, Undecided> {
        Ok(numerator.sign()? == Greater && (!ends || numerator.minus(denominator).sign()? == Less))
    };
    let a = norm2(w);
    for (id, sphere) in (1..).zip(&model.spheres) {
        if sphere.radius.sign()? == Equal {
            continue;
        }
        let from_center = difference(point, &scaled(&sphere.center, m));
        let b = dot(w, &from_center);
        let roots = if id == *own {
            // One root is 0; their sum is −2b/a.
            vec![b.plus(&b).negative()]
        } else {
            let k = norm2(&from_center).minus(&sphere.radius2.times(&m.squared()));
            numerators(&a, &b, &k)?
        };
        for root in roots {
            if is_in_way(&root, &a)? {
                return Ok(true);
            }
        }
    }
    for (id, plane) in (model.spheres.len() as u32 + 1..).zip(&model.planes) {
        // The own plane is met at 0 alone.
        if id == *own {
            continue;
        }
        let along = dot(w, &plane.normal);
        let to_plane = dot(&difference(&scaled(&plane.point, m), point), &plane.normal);
        let is_met = match along.sign()? {
            Equal => false,
            Greater => is_in_way(&to_plane, &along)?,
            Less => is_in_way(&to_plane.negative(), &along.negative())?,
        };
        if is_met {
            return Ok(true);
        }
    }
    Ok(false)
}

/// What all lengths are multiplied by: an orthographic camera's rays start at fractions of a row.
fn length_factor(view: &View, rows: u32) -> u32 {
    match view.lens {
        Lens::Perspective => 1,
        Lens::Orthographic => rows,
    }
}

/// The scene's lights, then the suns of its sky.
fn lamps(scene: &Scene, view: &View) -> Vec<Lamp> {
    let lamp = |light: &Light| {
        let source = match (light.source, view.lens) {
            (Source::Point(position), _) => LampSource::Point(position),
            (Source::Sun(direction), _) => LampSource::Sun(direction),
            (Source::Eye, Lens::Perspective) => LampSource::Point(view.position),
            (Source::Eye, Lens::Orthographic) => LampSource::Sun(view.forward),
        };
        let Light { color, intensity, shadows, .. } = *light;
        Lamp { source, color, factors: [intensity, 1.0], divisor: 1, shadows }
    };
    let suns = scene.sky.iter().flat_map(|sky| {
        sky.suns().into_iter().map(|sun| Lamp {
            source: LampSource::Sun(sun),
            color: Color([1.0; 3]),
            factors: [sky.intensity, 4.0],
            divisor: sky.directions,
            shadows: true,
        })
    });
    scene.lights.iter().map(lamp).chain(suns).collect()
}

impl Shifts {
    fn new(scene: &Scene, view: &View, lamps: &[Lamp]) -> Shifts {
        let vectors = [view.forward, view.right, view.true_up];
        let frame = integer_shift(vectors.iter().flat_map(|v| v.to_array()));
        let h = integer_shift([view.h]);
        let spheres = scene.spheres.iter().flat_map(|s| [s.center, DVec3::splat(s.radius)]);
        let points = lamps.iter().filter_map(|lamp| match lamp.source {
            LampSource::Point(position) => Some(position),
            LampSource::Sun(_) => None,
        });
        let planes = scene.planes.iter().map(|plane| plane.point);
        let lengths = spheres.chain(points).chain(planes).chain([view.position]);
        let length = integer_shift(lengths.flat_map(|v| v.to_array()));
        // An orthographic camera's `h` is a length along one of the unit vectors.
        let length = match view.lens {
            Lens::Perspective => length,
            Lens::Orthographic => length.max(frame + h),
        };
        Shifts { length, frame, h }
    }
}

impl<N: Number> Model<N> {
    fn new(scene: &Scene, lamps: &[Lamp], shifts: Shifts, factor: u32, bits: u64) -> Model<N> {
        let factor = N::new(f64::from(factor), 0, bits);
        let point = |v: DVec3| scaled(&v3(v, shifts.length, bits), &factor);
        let vector = |v: DVec3| v3(v, integer_shift(v.to_array()), bits);
        let spheres = scene.spheres.iter().map(|sphere| {
            let radius = N::new(sphere.radius, shifts.length, bits).times(&factor);
            SphereNumbers { center: point(sphere.center), radius2: radius.squared(), radius }
        });
        let planes = scene
            .planes
            .iter()
            .map(|plane| PlaneNumbers { point: point(plane.point), normal: vector(plane.normal) });
        let lamps = lamps.iter().map(|lamp| {
            let (place, is_point) = match lamp.source {
                LampSource::Point(position) => (point(position), true),
                LampSource::Sun(direction) => (vector(-direction), false),
            };
            let number = |x: f64| N::new(x, 0, bits);
            let [first, second] = lamp.factors.map(number);
            let divisor = number(f64::from(lamp.divisor));
            let intensity = match lamp.divisor {
                1 => first.times(&second),
                _ => first.times(&second).over(&divisor).unwrap_or_else(|_| unreachable!("n > 0")),
            };
            let strength = lamp.color.0.map(|color| number(color).times(&intensity));
            LampNumbers { place, is_point, strength }
        });
        Model { bits, spheres: spheres.collect(), planes: planes.collect(), lamps: lamps.collect() }
    }
}

/// The ends of the bytes' ranges: the least linear value of byte `i + 1`, for 8 or 16 bits.
pub fn edges(largest: u16) -> &'static [f64] {
    static EDGES: [OnceLock<Vec<f64>>; 2] = [OnceLock::new(), OnceLock::new()];
    EDGES[usize::from(largest > 255)].get_or_init(|| {
        let largest_f64 = f64::from(largest);
        (1..=largest).map(|b| linear_from_srgb((f64::from(b) - 0.5) / largest_f64)).collect()
    })
}

/// The byte whose range holds both ends, or at the last level the one whose lower edge they touch.
fn byte(ends: [f64; 2], largest: u16, is_last: bool) -> Option<Answer<u16>> {
    let [low, high] = ends.map(|end| edges(largest).partition_point(|edge| *edge <= end) as u16);
    (low == high || is_last).then_some(Answer { value: high, is_tie: low != high })
}

impl Channel {
    /// None where the enclosure touches an edge and this is not the last level.
    fn new(mean: &Big, is_last: bool) -> Option<Channel> {
        // An edge is an f64: it is above a number if and only if it is above the f64 below.
        let floors = mean.floors();
        let srgb8 = byte(floors, 255, is_last)?;
        let [low, high] = mean.nearest_f32();
        let is_tie = low.to_bits() != high.to_bits();
        if is_tie && !is_last {
            return None;
        }
        // Of neighbours, the one with an even last place.
        let linear = if high.to_bits() % 2 == 0 { high } else { low };
        Some(Channel {
            mean: floors,
            srgb8: Answer { value: srgb8.value as u8, is_tie: srgb8.is_tie },
            srgb16: byte(floors, 65535, is_last)?,
            linear: Answer { value: linear, is_tie },
        })
    }
}
