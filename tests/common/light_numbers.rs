//! A scene's numbers for the oracle of light and colour: enclosures, with all lengths made integers by one
//! power of two.

use std::cmp::Ordering::{Equal, Greater, Less};

use glam::DVec3;
use kugelblitz::rays::{Lens, View};
use kugelblitz::scene::{Color, Light, Scene, Source};

use crate::enclosure::{Number, Undecided, integer_shift};

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

/// The powers of two that make integers.
#[derive(Clone, Copy, Debug)]
pub struct Shifts {
    pub length: i64,
    /// Of the camera's unit vectors.
    pub frame: i64,
    /// Of the camera's `h`.
    pub h: i64,
}

/// All numbers of a scene as enclosures.
pub struct Model<N> {
    pub bits: u64,
    pub spheres: Vec<SphereNumbers<N>>,
    pub planes: Vec<PlaneNumbers<N>>,
    pub lamps: Vec<LampNumbers<N>>,
}

pub struct SphereNumbers<N> {
    pub center: [N; 3],
    pub radius: N,
    pub radius2: N,
}

pub struct PlaneNumbers<N> {
    pub point: [N; 3],
    pub normal: [N; 3],
}

pub struct LampNumbers<N> {
    /// The point, or the way towards the sun.
    pub place: [N; 3],
    pub is_point: bool,
    /// By channel.
    pub strength: [N; 3],
}

pub fn v3<N: Number>(v: DVec3, shift: i64, bits: u64) -> [N; 3] {
    v.to_array().map(|x| N::new(x, shift, bits))
}

pub fn sum<N: Number>(u: &[N; 3], v: &[N; 3]) -> [N; 3] {
    std::array::from_fn(|i| u[i].plus(&v[i]))
}

pub fn difference<N: Number>(u: &[N; 3], v: &[N; 3]) -> [N; 3] {
    std::array::from_fn(|i| u[i].minus(&v[i]))
}

pub fn scaled<N: Number>(v: &[N; 3], factor: &N) -> [N; 3] {
    std::array::from_fn(|i| v[i].times(factor))
}

/// The roots of `a·t² + 2b·t + k` times `a > 0`, in order.
pub fn numerators<N: Number>(a: &N, b: &N, k: &N) -> Result<Vec<N>, Undecided> {
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

/// What all lengths are multiplied by: an orthographic camera's rays start at fractions of a row.
pub fn length_factor(view: &View, rows: u32) -> u32 {
    match view.lens {
        Lens::Perspective => 1,
        Lens::Orthographic => rows,
    }
}

/// The scene's lights, then the suns of its sky.
pub fn lamps(scene: &Scene, view: &View) -> Vec<Lamp> {
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
    pub fn new(scene: &Scene, view: &View, lamps: &[Lamp]) -> Shifts {
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
    pub fn new(scene: &Scene, lamps: &[Lamp], shifts: Shifts, factor: u32, bits: u64) -> Model<N> {
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
