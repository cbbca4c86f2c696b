//! A second opinion on light, samples and colours: the contract's meaning of a pixel by solving
//! quadratics in enclosures and looking where their roots lie.
//!
//! It shares nothing with the crate but the scene's types and the camera's numbers. A question is asked
//! in f64 first and then with more and more bits, until the enclosure tells, or is so narrow that the
//! number must be 0 (`enclosure.rs`). For that, all lengths are made integers by one power of
//! two, and nothing is divided: a hit point is `P/m`, where `P` has integers and one square root.
//! A test that takes this module takes `enclosure.rs` as its module `enclosure`.
#![allow(dead_code)] // each test uses what it needs

mod light_answer;
mod light_numbers;
mod light_shadow;

use std::cmp::Ordering::{Equal, Greater, Less};
use std::sync::OnceLock;

use glam::DVec3;
use kugelblitz::rays::{Lens, View};
use kugelblitz::scene::{Color, Scene};
use kugelblitz::shade::Background;

use crate::enclosure::{Big, Narrow, Number, Undecided, dot, norm2};
#[allow(unused_imports)] // each test uses what it needs
pub use light_answer::{Answer, Channel, Truth, edges};
use light_numbers::{
    Lamp, Model, Shifts, difference, lamps, length_factor, numerators, scaled, sum, v3,
};
use light_shadow::{Surface, cosine};

/// Bits of the enclosures, one after the other; the first stands for f64.
const LEVELS: [u64; 9] = [53, 160, 480, 1440, 4320, 12_960, 38_880, 116_640, 349_920];

/// From here on, an enclosure that still touches an edge counts as equal to it.
pub const TIE_BITS: u64 = 4096;

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

impl<'a> Oracle<'a> {
    /// The scene's picture with its camera and its samples.
    pub fn new(scene: &'a Scene, width: u32, height: u32) -> Oracle<'a> {
        let view = View::new(scene.camera.as_ref().expect("a camera"));
        let samples = scene.samples.map_or(1, |samples| samples.across());
        Oracle::with_view(scene, view, width, height, samples)
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

/// The smaller root; of equal ones the first.
fn nearer<N: Number>(best: Option<Root<N>>, root: Root<N>) -> Result<Root<N>, Undecided> {
    let Some(best) = best else {
        return Ok(root);
    };
    let both = [&root.numerator.times(&best.denominator), &best.numerator.times(&root.denominator)];
    Ok(if both[0].minus(both[1]).sign()? == Less { root } else { best })
}
