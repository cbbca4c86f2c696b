//! Light in exact numbers alone: slow, and what pictures are judged by. Every object that f64 does not
//! clearly rule out is looked at; no tree, no filter and none of its bounds take part.

use glam::DVec3;
use kugelblitz::exact::{ExactBeam, ExactHit, ExactPoint, ExactRay};
use kugelblitz::lighting::{ExactMean, Lighting, PreparedLight};
use kugelblitz::scene::{Object, Scene, Source};

use super::truth::{GRANTED, Near, TruthLine};

/// A point that a ray sees.
#[derive(Debug)]
pub(crate) struct LitPoint<'a> {
    exact: ExactPoint<'a>,
    /// The point in f64, relative to the eye.
    from_eye: DVec3,
    eye: DVec3,
}

impl<'a> LitPoint<'a> {
    /// The point of a hit. `near` is the ray in f64, relative to the eye.
    pub fn new(ray: &ExactRay, hit: &ExactHit<'a>, near: &Near) -> LitPoint<'a> {
        let from_eye = near.ray.origin + near.ray.direction * hit.t_f64();
        LitPoint { exact: ExactPoint::new(ray, hit), from_eye, eye: near.reference }
    }

    /// The way to a lamp.
    pub fn beam(&self, lamp: &PreparedLight) -> Option<ExactBeam<'_>> {
        lamp.beam(&self.exact, self.eye)
    }

    /// The objects that are in the way of a lamp's light, with their ids, its own among them.
    pub fn in_the_way<'s>(
        &self,
        scene: &'s Scene,
        lamp: &'s PreparedLight,
        beam: &'s ExactBeam,
    ) -> impl Iterator<Item = (u32, Object<'s>)> {
        let candidates = lamp.shadows.then(|| self.line(lamp).candidates(scene));
        candidates.into_iter().flatten().filter(|(_, object)| beam.is_blocked_by(*object))
    }

    /// Returns the line to a lamp. The direction to a point light has the errors of both ends, relative to its own length.
    fn line(&self, lamp: &PreparedLight) -> TruthLine {
        let (way, reach) = match lamp.origin {
            Source::Eye => (-self.from_eye, 0.0),
            Source::Point(position) => {
                let from_eye = position - self.eye;
                (from_eye - self.from_eye, from_eye.length() + self.from_eye.length())
            }
            Source::Sun(direction) => (-direction, 0.0),
        };
        let direction_error = GRANTED * (1.0 + reach / way.length());
        TruthLine::new(self.eye, self.from_eye, way, direction_error)
    }
}

/// The mean of samples in a light: each with the id of the object that it sees, and of a lit one the point.
pub(crate) fn exact_mean<'a>(
    scene: &Scene,
    lighting: Option<&'a Lighting>,
    samples: impl IntoIterator<Item = (u32, Option<&'a LitPoint<'a>>)>,
) -> ExactMean<'a> {
    let samples: Vec<_> = samples.into_iter().collect();
    let mut mean = ExactMean::new(samples.len() as u64, lighting);
    for (id, point) in samples {
        let at = point.map(|point| (&point.exact, point.eye));
        mean.add_sample(scene.color(id).0, at, |(_, lamp), beam| {
            point.is_none_or(|point| point.in_the_way(scene, lamp, beam).next().is_none())
        });
    }
    mean
}

#[cfg(test)]
mod tests {
    use kugelblitz::exact::Dyadic;
    use kugelblitz::exact::nearest;
    use kugelblitz::rays::WorldRay;
    use kugelblitz::scene::{Plane, Sphere};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn vector(rng: &mut ChaCha8Rng) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)))
    }

    /// Spheres that beams touch to some `2⁻⁵⁰`, far from the origin and with lamps near their points:
    /// nothing that is in the way is ruled out by f64.
    #[test]
    fn nothing_in_the_way_is_passed_by() {
        let mut rng = ChaCha8Rng::seed_from_u64(1417);
        let (mut n_hidden, mut n_passed) = (0, 0);
        for _ in 0..2000 {
            let far = vector(&mut rng) * 10f64.powi(rng.random_range(-3..9));
            let floor = Plane {
                name: None,
                point: far,
                normal: vector(&mut rng),
                color: Default::default(),
            };
            let eye = far + vector(&mut rng);
            let ray = WorldRay { origin: eye, direction: far - eye };
            let way = vector(&mut rng) * 10f64.powi(rng.random_range(-9..3));
            let is_sun = rng.random();
            let origin = if is_sun { Source::Sun(-way) } else { Source::Point(far + way) };
            let side = way.cross(vector(&mut rng)).normalize();
            let radius = 10f64.powi(rng.random_range(-3..3));
            let off = radius * (1.0 + rng.random_range(-1..2) as f64 * 2f64.powi(-50));
            let center = far + way * rng.random_range(0.1..0.9) + side * off;
            let sphere = Sphere { center, radius };
            let scene =
                Scene { spheres: vec![sphere].into(), planes: vec![floor], ..Scene::default() };
            let exact = ExactRay::new(&ray);
            let Some(hit) = nearest(&exact, [(2, Object::Plane(&scene.planes[0]))]) else {
                continue;
            };
            let near = Near { reference: eye, ray: WorldRay { origin: DVec3::ZERO, ..ray } };
            let point = LitPoint::new(&exact, &hit, &near);
            let weight = std::array::from_fn(|_| Dyadic::one());
            let lamp = PreparedLight {
                light: None,
                origin,
                weight: [1.0; 3],
                exact_weight: weight,
                shadows: true,
            };
            let Some(beam) = point.beam(&lamp) else { continue };
            let blocking = scene.objects().filter(|(_, object)| beam.is_blocked_by(*object));
            let expected: Vec<u32> = blocking.map(|(id, _)| id).collect();
            let found: Vec<u32> =
                point.in_the_way(&scene, &lamp, &beam).map(|(id, _)| id).collect();
            assert_eq!(found, expected, "{ray:?} {lamp:?} {sphere:?}");
            n_hidden += usize::from(expected.contains(&1));
            n_passed += usize::from(!expected.contains(&1));
        }
        assert!(n_hidden > 100 && n_passed > 100, "{n_hidden}, {n_passed}");
    }
}
