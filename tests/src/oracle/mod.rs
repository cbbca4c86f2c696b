//! A second opinion on all that a picture shows: the contract's meaning of a pixel, by solving quadratics
//! in enclosures and looking where their roots lie.
//!
//! It shares nothing with what it judges but the text of a scene (`scene.rs`) and `libm`'s tangent and
//! power, which the contract names. A question is asked in f64 first and then with more and more bits,
//! until the enclosure tells, or is so narrow that the number must be 0 (`enclosure.rs`). For that, all
//! lengths are made integers by one power of two, and nothing is divided: a hit point is `P/m`, where `P`
//! has integers and one square root.

mod answer;
pub mod enclosure;
mod numbers;
pub mod scene;
mod shadow;

use std::cmp::Ordering::{Equal, Greater, Less};
use std::sync::{Arc, OnceLock};

pub use answer::{Answer, Channel, Truth, edges};
use enclosure::{Big, Narrow, Number, Undecided, dot, norm2};
use numbers::{Lamp, Model, Shifts, difference, lamps, length_factor, numerators, scaled, sum, v3};
use scene::{Camera, Scene, V};
use shadow::{Surface, cosine};

/// Bits of the enclosures, one after the other; the first stands for f64.
const LEVELS: [u64; 9] = [53, 160, 480, 1440, 4320, 12_960, 38_880, 116_640, 349_920];

/// From here on, an enclosure that still touches an edge counts as equal to it.
pub const TIE_BITS: u64 = 4096;

/// A scene, seen as a picture.
pub struct Oracle {
    scene: Arc<Scene>,
    camera: Camera,
    width: u32,
    height: u32,
    samples: u32,
    background: Background,
    lamps: Vec<Lamp>,
    shifts: Shifts,
    narrow: Model<Narrow>,
    /// The first levels of more bits, made when they are first asked.
    models: [OnceLock<Model<Big>>; 4],
}

/// What samples beside all objects count for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Background {
    /// The scene's background colour.
    #[default]
    Shown,
    /// Nothing: the mean is that of the others.
    LeftOut,
    /// Black.
    Black,
}

/// What a ray sees: what a list of hits says of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    pub id: u32,
    pub t: f32,
    pub normal: [f32; 3],
}

/// The hit of a ray that meets nothing.
pub const MISS: Hit = Hit { id: 0, t: f32::INFINITY, normal: [0.0; 3] };

/// Where a ray meets an object: at `numerator/denominator`.
struct Root<N> {
    id: u32,
    numerator: N,
    denominator: N,
}

/// A sample: the object, or 0, and its colour.
pub struct Sample {
    pub id: u32,
    pub rgb: [Big; 3],
    pub bits: u64,
}

impl Oracle {
    /// The scene's picture by its own camera.
    pub fn new(scene: &Arc<Scene>, width: u32, height: u32, samples: u32) -> Oracle {
        Oracle::seen_by(scene, scene.camera.expect("a camera"), width, height, samples)
    }

    pub fn seen_by(
        scene: &Arc<Scene>,
        camera: Camera,
        width: u32,
        height: u32,
        samples: u32,
    ) -> Oracle {
        let scene = Arc::clone(scene);
        let lamps = lamps(&scene, &camera);
        let shifts = Shifts::new(&scene, &camera, &lamps);
        let factor = length_factor(&camera, samples * height);
        let narrow = Model::new(&scene, &lamps, shifts, factor, 53);
        let models = std::array::from_fn(|_| OnceLock::new());
        let background = Background::Shown;
        Oracle { scene, camera, width, height, samples, background, lamps, shifts, narrow, models }
    }

    /// What any ray sees.
    pub fn of_ray(scene: &Arc<Scene>, origin: V, direction: V) -> Hit {
        Oracle::seen_by(scene, Camera::along(origin, direction), 1, 1, 1).hit(0, 0)
    }

    /// This oracle where samples that hit nothing count as `background` says.
    pub fn before(self, background: Background) -> Oracle {
        Oracle { background, ..self }
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

    /// Twice the offset of the pixel's middle.
    fn middle(&self, x: u32, y: u32) -> [f64; 2] {
        let n = f64::from(self.samples);
        let right = n * (2.0 * f64::from(x) + 1.0 - f64::from(self.width));
        let up = n * (f64::from(self.height) - 2.0 * f64::from(y) - 1.0);
        [right, up]
    }

    /// The id of what the ray through the pixel's middle sees.
    fn center_id(&self, x: u32, y: u32) -> u32 {
        fn id<N: Number>(surface: Option<Surface<N>>) -> u32 {
            surface.map_or(0, |surface| surface.id)
        }
        let offset = self.middle(x, y);
        let at_level = |bits| match bits {
            53 => self.seen(&self.narrow, offset).map(id),
            _ => self.with_model(bits, |model| self.seen(model, offset).map(id)),
        };
        decided(53, at_level).0
    }

    /// What the ray through the pixel's middle sees.
    pub fn hit(&self, x: u32, y: u32) -> Hit {
        let offset = self.middle(x, y);
        let at_level = |bits| match bits {
            53 => self.hit_by(&self.narrow, offset),
            _ => self.with_model(bits, |model| self.hit_by(model, offset)),
        };
        decided(53, at_level).0
    }

    fn hit_by<N: Number>(&self, model: &Model<N>, offset: [f64; 2]) -> Result<Hit, Undecided> {
        let Some(Surface { id, t, normal, length, .. }) = self.seen(model, offset)? else {
            return Ok(MISS);
        };
        let nearest = |number: &N, divisor: &N| -> Result<f32, Undecided> {
            let [low, high] = number.over(divisor)?.to_big(model.bits)?.nearest_f32();
            let is_tie = low.to_bits() != high.to_bits();
            match model.bits < TIE_BITS && is_tie {
                true => Err(Undecided),
                // Of neighbours, the one with an even last place.
                false => Ok(if high.to_bits() % 2 == 0 { high } else { low }),
            }
        };
        let component = |x: &N| {
            Ok(match x.sign()? {
                Equal => 0.0,
                Greater => nearest(x, &length)?,
                // No −0.
                Less => 0.0 - nearest(&x.negative(), &length)?,
            })
        };
        let t = nearest(&t[0], &t[1])?.max(f32::from_bits(1));
        let [x, y, z] = &normal;
        Ok(Hit { id, t, normal: [component(x)?, component(y)?, component(z)?] })
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
        let factor = length_factor(&self.camera, self.samples * self.height);
        let make = || Model::new(&self.scene, &self.lamps, self.shifts, factor, bits);
        let level = LEVELS.iter().position(|level| *level == bits).expect("a level");
        match self.models.get(level - 1) {
            Some(model) => ask(model.get_or_init(make)),
            None => ask(&make()),
        }
    }

    /// Origin and direction, which may be any positive number times the contract's.
    fn ray<N: Number>(&self, [right, up]: [f64; 2], bits: u64) -> ([N; 3], [N; 3]) {
        let Oracle { camera, shifts, .. } = self;
        let int = |x: f64, shift: i64| N::new(x, shift, bits);
        let vector = |v: V| v3::<N>(v, shifts.frame, bits);
        let across = |h: N| {
            sum(
                &scaled(&vector(camera.right), &h.times(&int(right, 0))),
                &scaled(&vector(camera.true_up), &h.times(&int(up, 0))),
            )
        };
        let rows = f64::from(self.samples * self.height);
        let position = v3::<N>(camera.position, shifts.length, bits);
        match camera.is_orthographic {
            false => {
                let forward = scaled(&vector(camera.forward), &int(rows, shifts.h));
                (position, sum(&forward, &across(int(camera.h, shifts.h))))
            }
            true => {
                let across = across(int(camera.h, shifts.length - shifts.frame));
                (sum(&scaled(&position, &int(rows, 0)), &across), vector(camera.forward))
            }
        }
    }

    /// The contract's `t` as a number over another: the root times the direction's factor over that of
    /// lengths.
    fn t<N: Number>(&self, root: &Root<N>, bits: u64) -> [N; 2] {
        let Shifts { length, frame, h } = self.shifts;
        let rows = self.samples * self.height;
        let (factor, shift) = match self.camera.is_orthographic {
            false => (rows, frame + h),
            true => (1, frame),
        };
        let direction = N::new(f64::from(factor), shift, bits);
        let length = N::new(f64::from(length_factor(&self.camera, rows)), length, bits);
        [root.numerator.times(&direction), root.denominator.times(&length)]
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
        let t = self.t(&root, model.bits);
        // From here on, `t` rounds beyond the largest f32.
        let limit = N::new(f64::from(f32::MAX) + 2f64.powi(103), 0, model.bits);
        if t[0].minus(&limit.times(&t[1])).sign()? != Less {
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
        Ok(Some(Surface { id, t, point, m, normal, length }))
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
            return Ok((0, to_big(self.scene.background.map(number))?));
        };
        let color = self.scene.color(surface.id).map(number);
        if !self.scene.is_lit() {
            return Ok((surface.id, to_big(color)?));
        }
        let mut light = self.scene.ambient.unwrap_or([0.0; 3]).map(number);
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

/// The smaller root; of equal ones the first.
fn nearer<N: Number>(best: Option<Root<N>>, root: Root<N>) -> Result<Root<N>, Undecided> {
    let Some(best) = best else {
        return Ok(root);
    };
    let both = [&root.numerator.times(&best.denominator), &best.numerator.times(&root.denominator)];
    Ok(if both[0].minus(both[1]).sign()? == Less { root } else { best })
}
