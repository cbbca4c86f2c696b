//! The exact results of rays, and which rays to compare.

use glam::DVec3;
use kugelblitz::Result;
use kugelblitz::control::Control;
use kugelblitz::exact::{self, ExactHit, ExactRay, ExactRays, Root, Side};
use kugelblitz::num::Scaled;
use kugelblitz::parallel;
use kugelblitz::random::SplitMix;
use kugelblitz::rays::{Pixels, Rays};
use kugelblitz::scene::{Object, Scene};
use kugelblitz::trace::WorldRay;

use crate::compare::RayResult;
use crate::wrong_usage;

/// Bytes of a ray that is compared: its index, what is exact about it, and the same once more on the
/// way.
pub const SAMPLE_BYTES: u64 = 128;

/// The exact results for some of the rays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// The rays, as indices into the [`Hits`](kugelblitz::trace::Hits) of all rays.
    pub index: Vec<usize>,
    /// What each of them sees.
    pub hits: Vec<TrueHit>,
}

impl Truth {
    /// The truth about the rays with these indices; `control` counts each.
    ///
    /// # Errors
    /// [`Error::Interrupted`](kugelblitz::Error::Interrupted) when `control` was cancelled.
    pub fn of_rays(
        scene: &Scene,
        rays: &Rays,
        index: Vec<usize>,
        control: &Control,
    ) -> Result<Truth> {
        let exactly = ExactRays::from(rays);
        Truth::new(index, control, |i| {
            let exact = exactly.ray(i);
            TrueHit::of(&exact, hit_of(scene, &exact, &Near::new(rays, i)))
        })
    }

    /// The truth about all of these rays, of which the visible objects are known: `ids` are those of
    /// [`Kernel::Certified`](kugelblitz::trace::Kernel::Certified). Exact arithmetic on these objects alone finds
    /// the rest, so that it takes no longer with many of them; `control` counts each ray.
    ///
    /// # Errors
    /// [`Error::Usage`](kugelblitz::Error::Usage) for another number of ids than rays;
    /// [`Error::Interrupted`](kugelblitz::Error::Interrupted) when `control` was cancelled.
    pub fn of_known(scene: &Scene, rays: &Rays, ids: &[u32], control: &Control) -> Result<Truth> {
        if ids.len() != rays.len() {
            return wrong_usage(format!("{} ids were given for {} rays", ids.len(), rays.len()));
        }
        let rays = ExactRays::from(rays);
        Truth::new((0..ids.len()).collect(), control, |i| {
            let Some(object) = scene.object(ids[i]) else { return TrueHit::NONE };
            let ray = rays.ray(i);
            TrueHit::of(&ray, exact::nearest(&ray, [(ids[i], object)]))
        })
    }

    fn new(
        index: Vec<usize>,
        control: &Control,
        hit: impl Fn(usize) -> TrueHit + Sync,
    ) -> Result<Truth> {
        let hits = parallel::try_map(&index, |&i| {
            control.check()?;
            control.advance(1);
            Ok(hit(i))
        })?;
        Ok(Truth { index, hits })
    }
}

/// A ray in f64, relative to a point: what is near the ray may be far from the world's origin.
pub(crate) struct Near {
    pub reference: DVec3,
    pub ray: WorldRay,
}

impl Near {
    /// The ray with this index, from the camera's position, or from its own origin.
    pub fn new(rays: &Rays, index: usize) -> Near {
        match rays {
            Rays::Pixels(pixels) => Near::of_pixel(pixels, pixels.xy(index)),
            Rays::List(rays) => {
                let WorldRay { origin, direction } = rays[index];
                Near { reference: origin, ray: WorldRay { origin: DVec3::ZERO, direction } }
            }
        }
    }

    /// The centre ray of a pixel.
    pub fn of_pixel(pixels: &Pixels, (x, y): (u32, u32)) -> Near {
        let (origin, direction) = (pixels.origin_offset(x, y), pixels.direction(x, y));
        Near { reference: pixels.view.position, ray: WorldRay { origin, direction } }
    }
}

/// The exact result of a ray.
#[derive(Clone, Debug, PartialEq)]
pub struct TrueHit {
    /// Object id, 0 for the background.
    pub id: u32,
    /// The exact `t`, rounded to f64; +∞ on the background.
    pub t: f64,
    /// The exact unit normal, each component rounded to f64; zero on the background.
    pub normal: [f64; 3],
    /// The exact unit normal, each component rounded to f32; zero on the background.
    pub normal_f32: [f32; 3],
    /// Whether a sphere is seen from inside, or a plane from behind: the normal is then turned.
    pub is_back: bool,
}

impl From<&TrueHit> for RayResult {
    fn from(hit: &TrueHit) -> RayResult {
        RayResult { id: hit.id, t: Some(hit.t), normal: Some(hit.normal.into()) }
    }
}

impl TrueHit {
    /// The background.
    const NONE: TrueHit =
        TrueHit { id: 0, t: f64::INFINITY, normal: [0.0; 3], normal_f32: [0.0; 3], is_back: false };

    fn of(ray: &ExactRay, hit: Option<ExactHit>) -> TrueHit {
        let Some(hit) = hit else { return TrueHit::NONE };
        let normal = hit.normal(ray);
        TrueHit {
            id: hit.id,
            t: hit.t_f64(),
            normal: normal.as_ref().map_or([0.0; 3], |n| n.each_ref().map(Root::to_f64)),
            normal_f32: normal.as_ref().map_or([0.0; 3], |n| n.each_ref().map(Root::to_f32)),
            is_back: hit.side == Side::Back,
        }
    }
}

/// The hit of a ray, by exact arithmetic on every object that f64 does not clearly rule out. No
/// hierarchy: this is what one is judged by.
pub(super) fn hit_of<'a>(scene: &'a Scene, ray: &ExactRay, near: &Near) -> Option<ExactHit<'a>> {
    let objects = scene.objects();
    exact::nearest(ray, objects.filter(|(_, object)| !is_clearly_missed(near, object)))
}

/// True where the line of a ray whose numbers are exact to f64 passes a sphere at a distance, and so
/// surely misses it.
pub(crate) fn is_clearly_missed(Near { reference, ray }: &Near, object: &Object) -> bool {
    let way = Scaled::new(ray.direction).rounded();
    Line { reference: *reference, origin: ray.origin, way, turned: 0.0 }.clearly_passes(object)
}

/// A thousand times what the numbers of a [`Line`] are off by, which is some `2⁻⁵⁰`: no test sees it halved.
pub(super) const GRANTED: f64 = 1.0 / (1u64 << 40) as f64;

/// A line in f64. Its offset from a sphere, the cross product and the lengths are off by some `2⁻⁵⁰` of the
/// lengths' product.
pub(super) struct Line {
    /// What its origin is relative to.
    pub reference: DVec3,
    pub origin: DVec3,
    pub way: DVec3,
    /// What is granted to the way beyond that, relative: the way to a lamp is off by that of `1`, and by the lengths of
    /// point and position where it is their difference.
    pub turned: f64,
}

impl Line {
    /// True where it passes a sphere at a distance, and so surely misses it. Numbers whose squares leave
    /// f64's range rule nothing out.
    pub fn clearly_passes(&self, object: &Object) -> bool {
        // No test sees it halved: squares underflow below 1e-154.
        const LEAST: f64 = 1e-140;
        let Object::Sphere(sphere) = object else { return false };
        let center = sphere.center - self.reference;
        let l = center - self.origin;
        let reach = sphere.radius.abs() * (1.0 + GRANTED)
            + (center.length() + self.origin.length()) * GRANTED
            + l.length() * self.turned;
        let (passed, reached) = (l.cross(self.way).length(), reach * self.way.length());
        passed > reached && reach > LEAST && passed.is_finite()
    }
}

/// `n` different indices below `total`, ascending, drawn at random from `seed`; all of them when
/// `n` is not less.
pub fn sample(total: usize, n: usize, seed: u64) -> Vec<usize> {
    let (mut random, mut left) = (SplitMix::new(seed), n.min(total) as u128);
    let is_drawn = |&index: &usize| {
        // Knuth, The Art of Computer Programming 2, 3.4.2, algorithm S.
        let drawn = (u128::from(random.bits()) * (total - index) as u128) >> 64;
        let is_drawn = drawn < left;
        left -= u128::from(is_drawn);
        is_drawn
    };
    (0..total).filter(is_drawn).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_of_the_ids_saves_work_alone() {
        let text = include_str!("../../../../scenes/inside.toml");
        let scene = kugelblitz::scene::parse_scene(text, "inside.toml".as_ref()).unwrap();
        let view = kugelblitz::rays::View::new(scene.camera.as_ref().unwrap());
        let (pixels, control) = (Pixels::whole(view, 32, 18), Control::default());
        let all = (0..pixels.len()).collect();
        let rays = Rays::Pixels(pixels);
        let truth = Truth::of_rays(&scene, &rays, all, &control).unwrap();
        let ids: Vec<u32> = truth.hits.iter().map(|hit| hit.id).collect();
        assert!(truth.hits.iter().any(|hit| hit.is_back) && ids.iter().any(|&id| id > 1));
        assert_eq!(Truth::of_known(&scene, &rays, &ids, &control).unwrap(), truth);
        assert!(Truth::of_known(&scene, &rays, &ids[1..], &control).is_err());
    }

    #[test]
    fn samples_are_different_ascending_and_repeatable() {
        let sample_of = |seed| sample(10_000, 500, seed);
        let chosen = sample_of(7);
        assert_eq!(chosen.len(), 500);
        assert!(chosen.windows(2).all(|pair| pair[0] < pair[1]) && chosen[499] < 10_000);
        assert_eq!(chosen, sample_of(7));
        assert_ne!(chosen, sample_of(8));
        let mean = chosen.iter().sum::<usize>() / 500;
        assert!((4500..5500).contains(&mean), "{mean}");
        assert_eq!(sample(3, 9, 0), [0, 1, 2]);
    }
}
