//! The exact results of rays, and which rays to compare.

use glam::DVec3;
use kugelblitz::Control;
use kugelblitz::Result;
use kugelblitz::exact::{self, ExactHit, ExactRay, ExactRays, QuadraticSurd, Side};
use kugelblitz::num::ScaledInteger;
use kugelblitz::query::WorldRay;
use kugelblitz::rays::{Pixels, Rays};
use kugelblitz::scene::{Object, Scene, Sphere};
use kugelblitz::support::parallel;
use kugelblitz::support::random::SplitMix;

use crate::compare::RayResult;
use crate::wrong_usage;

/// The exact results for some of the rays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Truth {
    /// The rays, as indices into the [`Hits`](kugelblitz::query::Hits) of all rays.
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
    /// [`Kernel::Certified`](kugelblitz::query::Kernel::Certified). Exact arithmetic on these objects alone finds
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
    pub(crate) const NONE: TrueHit =
        TrueHit { id: 0, t: f64::INFINITY, normal: [0.0; 3], normal_f32: [0.0; 3], is_back: false };

    fn of(ray: &ExactRay, hit: Option<ExactHit>) -> TrueHit {
        let Some(hit) = hit else { return TrueHit::NONE };
        let normal = hit.normal(ray);
        TrueHit {
            id: hit.id,
            t: hit.t_f64(),
            normal: normal.as_ref().map_or([0.0; 3], |n| n.each_ref().map(QuadraticSurd::to_f64)),
            normal_f32: normal
                .as_ref()
                .map_or([0.0; 3], |n| n.each_ref().map(QuadraticSurd::to_f32)),
            is_back: hit.side == Side::Back,
        }
    }
}

/// Returns the hit of a ray, by exact arithmetic on every object that f64 does not rule out. Uses no hierarchy, since all
/// other results are compared with this one.
pub(super) fn hit_of<'a>(scene: &'a Scene, ray: &ExactRay, near: &Near) -> Option<ExactHit<'a>> {
    exact::nearest(ray, candidates(scene, near))
}

/// Returns the objects that a ray may meet, with their ids, ascending.
pub(crate) fn candidates<'a>(
    scene: &'a Scene,
    near: &Near,
) -> impl Iterator<Item = (u32, Object<'a>)> {
    TruthLine::from(near).candidates(scene)
}

/// Whether the line of a ray surely misses an object. `near` is the ray in f64.
pub(crate) fn is_clearly_missed(near: &Near, object: &Object) -> bool {
    matches!(object, Object::Sphere(sphere) if TruthLine::from(near).misses(sphere))
}

/// Relative error granted to the numbers of a [`TruthLine`]; the actual one is about `2⁻⁵⁰`.
///
/// Halving it is not covered by a test: it is a thousand times the actual error.
pub(super) const GRANTED: f64 = 1.0 / (1u64 << 40) as f64;

/// Lower bound of the distance from a centre at which a [`TruthLine`] may be ruled out, world units.
///
/// Halving it is not covered by a test: squares underflow only below `1e-154`.
const MIN_REACH: f64 = 1e-140;

/// Number of spheres that are compared with a [`TruthLine`] before the candidates among them are listed.
const BLOCK: usize = 64;

/// A line in f64, to rule out spheres that it surely misses.
///
/// # Notation
/// | symbol | meaning |
/// | --- | --- |
/// | `c`, `r` | centre, relative to the reference point, and radius of a sphere |
/// | `o` | origin of the line, relative to the reference point |
/// | `w` | direction of the line; its largest component is from 1 to 2 |
/// | `l`, `s` | `c − o`, and the sum of the magnitudes of its components |
/// | `G` | [`GRANTED`] |
/// | `e` | upper bound of the relative error of `w`, beyond `G` |
///
/// # Inequality
/// 1. The line misses the sphere if `|l × w| > |r||w|`.
/// 2. `c`, `o` and `w` have relative errors of about `2⁻⁵⁰`, and `w` an error of `e|w|` more. The cross product and each of
///    the squares, sums and products below have relative errors of some `2⁻⁵³` of `|l||w|` or `|r||w|`. As `|l| ≤ |c| + |o|`,
///    these errors together are far below `G(|c| + |o| + |r|)|w| + e|l||w|`.
/// 3. So the line surely misses if `|l × w|/|w| > |r|(1 + G) + G(|c| + |o|) + e|l|`.
/// 4. `s ≥ |l|` needs no square root, and `|c| ≤ |l| + |o|`. So the right side of step 3 is at most
///    `reach = |r|(1 + G) + (G + e)s + 2G|o| + `[`MIN_REACH`].
/// 5. Squares need no square root either: **the line surely misses if `|l × w|² > reach²|w|²`**.
/// 6. Underflow has no effect: a sphere is ruled out only if `|l × w|²` is above `MIN_REACH²`, which is `1e-280`. After overflow
///    nothing is ruled out: comparing with an infinite `reach²` or with NaN gives false, and an infinite `|l × w|²` is excluded.
///
/// Omitting this exclusion is not covered by a test: if `reach²` is finite, an infinite `|l × w|²` is truly the larger one.
#[derive(Clone, Copy, Debug)]
pub(super) struct TruthLine {
    reference: DVec3,
    origin: DVec3,
    direction: DVec3,
    /// `|w|²`
    direction2: f64,
    /// `G + e`
    reach_per_offset: f64,
    /// Part of `reach` that is the same for all spheres.
    min_reach: f64,
}

impl From<&Near> for TruthLine {
    fn from(Near { reference, ray }: &Near) -> TruthLine {
        TruthLine::new(*reference, ray.origin, ray.direction, 0.0)
    }
}

impl TruthLine {
    /// Creates the line through `origin`, relative to `reference`, along a direction of any finite length.
    /// `direction_error` is `e`.
    pub fn new(
        reference: DVec3,
        origin: DVec3,
        direction: DVec3,
        direction_error: f64,
    ) -> TruthLine {
        let direction = ScaledInteger::new(direction).rounded();
        TruthLine {
            reference,
            origin,
            direction,
            direction2: direction.length_squared(),
            reach_per_offset: GRANTED + direction_error,
            min_reach: 2.0 * GRANTED * origin.length() + MIN_REACH,
        }
    }

    /// Returns the objects that the line may meet, with their ids, ascending: all planes, and the spheres that f64 does not
    /// rule out.
    pub fn candidates<'a>(self, scene: &'a Scene) -> impl Iterator<Item = (u32, Object<'a>)> {
        let n_spheres = scene.spheres.len();
        let blocks = (0..).step_by(BLOCK).zip(scene.spheres.chunks(BLOCK));
        let spheres = blocks.filter(move |(_, block)| !self.misses_all(block)).flat_map(
            move |(first, block)| {
                let candidates =
                    (first..).zip(block).filter(move |(_, sphere)| !self.misses(sphere));
                candidates.map(|(index, _)| index)
            },
        );
        let others = n_spheres..scene.n_objects();
        spheres.chain(others).filter_map(|index| {
            let id = index as u32 + 1;
            Some((id, scene.object(id)?))
        })
    }

    /// Whether the line surely misses all of these spheres. The loop has no branch, so that the compiler vectorises it.
    #[inline(never)]
    fn misses_all(&self, spheres: &[Sphere]) -> bool {
        spheres.iter().fold(true, |misses, sphere| misses & self.misses(sphere))
    }

    /// Whether the line surely misses a sphere.
    #[inline(always)]
    fn misses(&self, sphere: &Sphere) -> bool {
        let l = sphere.center - self.reference - self.origin;
        let reach = sphere.radius.abs() * (1.0 + GRANTED)
            + (l.x.abs() + l.y.abs() + l.z.abs()) * self.reach_per_offset
            + self.min_reach;
        let passed2 = l.cross(self.direction).length_squared();
        (passed2 > reach * reach * self.direction2) & (passed2 < f64::INFINITY)
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
    use kugelblitz::exact::signum_of_discriminant;
    use kugelblitz::scene::Plane;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// Length of a vector whose squares may leave f64's range.
    fn length(v: DVec3) -> f64 {
        let largest = v.abs().max_element();
        if largest == 0.0 { 0.0 } else { (v / largest).length() * largest }
    }

    /// Right side of step 3 of [`TruthLine`].
    fn reach(center: DVec3, radius: f64, origin: DVec3, direction_error: f64) -> f64 {
        radius * (1.0 + GRANTED)
            + (length(center) + length(origin)) * GRANTED
            + length(center - origin) * direction_error
    }

    /// Step 3 of [`TruthLine`] in lengths, at any magnitude, and exact arithmetic are the references. Most spheres are within the
    /// margins of the bound.
    #[test]
    fn candidates_lack_no_sphere_that_lengths_leave() {
        let mut rng = ChaCha8Rng::seed_from_u64(2718);
        let (mut n_left, mut n_ruled_out) = (0, 0);
        for _ in 0..1500 {
            let power = rng.random_range(-300..290);
            let size = 10f64.powi(power);
            let mut vector = |max_power| {
                let v = DVec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
                v * 10f64.powi(rng.random_range(0..max_power))
            };
            let reference = size * vector(9);
            let is_exact = reference.x > 0.0;
            let origin = if is_exact { DVec3::ZERO } else { size * vector(7) };
            let direction = vector(9) * 1e-4;
            let (sides, offset) = (vector(1), length(origin) * 1e-3 + size);
            let direction_error = match rng.random_range(0..3) {
                0 if !is_exact => GRANTED * 10f64.powi(rng.random_range(0..6)),
                _ => 0.0,
            };
            let unit = direction.normalize();
            let spheres = (0..rng.random_range(0..200)).map(|_| {
                let at = origin + unit * offset * rng.random_range(-1.0..1.0);
                let side = unit.cross(sides + direction * rng.random::<f64>()).normalize();
                let radius = size * 10f64.powi(rng.random_range(-12..1));
                let distance = reach(at, radius, origin, direction_error);
                let share = rng.random_range(-0.1..2.5);
                let center = at + side * (radius + (distance - radius) * share);
                Sphere { center: reference + center, radius }
            });
            let spheres: Vec<Sphere> = spheres.collect();
            let plane =
                Plane { name: None, point: reference, normal: DVec3::Y, color: Default::default() };
            let scene = Scene { spheres: spheres.into(), planes: vec![plane], ..Scene::default() };

            let line = TruthLine::new(reference, origin, direction, direction_error);
            let found: Vec<u32> = line.candidates(&scene).map(|(id, _)| id).collect();
            assert!(found.is_sorted_by(|a, b| a < b));
            assert_eq!(found.last(), Some(&(scene.n_objects() as u32)), "planes are candidates");
            let exact = ExactRay::new(&WorldRay { origin: reference, direction });
            for (id, sphere) in (1..).zip(scene.spheres.iter()) {
                let center = sphere.center - reference;
                let distance = length((center - origin).cross(unit)) / unit.length();
                let is_left = distance <= reach(center, sphere.radius, origin, direction_error);
                let meets = is_exact && signum_of_discriminant(&exact, sphere) != Some(-1);
                let is_found = found.binary_search(&id).is_ok();
                assert!(is_found || !(is_left || meets), "{line:?} {sphere:?} {is_left} {meets}");
                if (-100..100).contains(&power) {
                    n_left += usize::from(is_left);
                    n_ruled_out += usize::from(!is_found);
                }
            }
        }
        assert!(n_left > 1000 && n_ruled_out > 1000, "{n_left}, {n_ruled_out}");
    }

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
