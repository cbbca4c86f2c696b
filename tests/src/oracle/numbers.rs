//! A scene's numbers for the oracle of light and colour: enclosures, with all lengths made integers by one
//! power of two.

use std::cmp::Ordering::{Equal, Greater, Less};

use super::enclosure::{Number, Undecided, integer_shift};
use super::scene::{Camera, Light, Scene, Source, V};

/// Where light comes from, with nothing left to look up.
#[derive(Clone, Copy, Debug)]
pub struct Lamp {
    pub source: LampSource,
    pub color: V,
    /// The light's intensity is the product of these over the divisor.
    pub factors: [f64; 2],
    pub divisor: u32,
    pub shadows: bool,
}

#[derive(Clone, Copy, Debug)]
pub enum LampSource {
    Point(V),
    /// The way that its light travels.
    Sun(V),
}

/// The powers of two that make integers.
#[derive(Clone, Copy, Debug)]
pub struct Shifts {
    pub length: i64,
    /// The exponent for the camera's unit vectors.
    pub frame: i64,
    /// The exponent for the camera's `h`.
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

pub fn v3<N: Number>(v: V, shift: i64, bits: u64) -> [N; 3] {
    v.map(|x| N::new(x, shift, bits))
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
pub fn length_factor(camera: &Camera, rows: u32) -> u32 {
    if camera.is_orthographic { rows } else { 1 }
}

/// The scene's lights, then the suns of its sky.
pub fn lamps(scene: &Scene, camera: &Camera) -> Vec<Lamp> {
    let lamp = |light: &Light| {
        let source = match light.source {
            Source::Point(position) => LampSource::Point(position),
            Source::Sun(direction) => LampSource::Sun(direction),
            Source::Eye if camera.is_orthographic => LampSource::Sun(camera.forward),
            Source::Eye => LampSource::Point(camera.position),
        };
        let Light { color, intensity, shadows, .. } = *light;
        Lamp { source, color, factors: [intensity, 1.0], divisor: 1, shadows }
    };
    let suns = scene.sky.iter().flat_map(|sky| {
        sky.suns().into_iter().map(|sun| Lamp {
            source: LampSource::Sun(sun),
            color: [1.0; 3],
            factors: [sky.intensity, 4.0],
            divisor: sky.directions,
            shadows: true,
        })
    });
    scene.lights.iter().map(lamp).chain(suns).collect()
}

impl Shifts {
    pub fn new(scene: &Scene, camera: &Camera, lamps: &[Lamp]) -> Shifts {
        let vectors = [camera.forward, camera.right, camera.true_up];
        let frame = integer_shift(vectors.iter().flatten().copied());
        let h = integer_shift([camera.h]);
        let spheres = scene.spheres.iter().flat_map(|s| [s.center, [s.radius; 3]]);
        let points = lamps.iter().filter_map(|lamp| match lamp.source {
            LampSource::Point(position) => Some(position),
            LampSource::Sun(_) => None,
        });
        let planes = scene.planes.iter().map(|plane| plane.point);
        let lengths = spheres.chain(points).chain(planes).chain([camera.position]);
        let length = integer_shift(lengths.flatten());
        // An orthographic camera's `h` is a length along one of the unit vectors.
        let length = match camera.is_orthographic {
            false => length,
            true => length.max(frame + h),
        };
        Shifts { length, frame, h }
    }
}

impl<N: Number> Model<N> {
    pub fn new(scene: &Scene, lamps: &[Lamp], shifts: Shifts, factor: u32, bits: u64) -> Model<N> {
        let factor = N::new(f64::from(factor), 0, bits);
        let point = |v: V| scaled(&v3(v, shifts.length, bits), &factor);
        let vector = |v: V| v3(v, integer_shift(v), bits);
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
                LampSource::Sun(direction) => (vector(direction.map(|x| -x)), false),
            };
            let number = |x: f64| N::new(x, 0, bits);
            let [first, second] = lamp.factors.map(number);
            let divisor = number(f64::from(lamp.divisor));
            let intensity = match lamp.divisor {
                1 => first.times(&second),
                _ => first.times(&second).over(&divisor).unwrap_or_else(|_| unreachable!("n > 0")),
            };
            let strength = lamp.color.map(|color| number(color).times(&intensity));
            LampNumbers { place, is_point, strength }
        });
        Model { bits, spheres: spheres.collect(), planes: planes.collect(), lamps: lamps.collect() }
    }
}
