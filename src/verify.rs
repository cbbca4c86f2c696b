//! Results of a kernel against exact arithmetic, and the promises that they keep or break.

mod allowed;
mod colors;
mod span;

use glam::DVec3;
use rayon::prelude::*;

use crate::compare::{Comparison, Precision};
use crate::control::Control;
use crate::error::Result;
use crate::exact::{self, ExactHit, ExactPixels, ExactRay, Shape};
use crate::kernel::Exactness;
use crate::kernel::coordinates::{exponent_of, scale_by_power_of_two};
use crate::random::SplitMix;
use crate::rays::Pixels;
use crate::scene::{Object, Scene};
use crate::trace::{Hits, Kernel, Ray};
pub use allowed::{Outside, compare_to_allowed};
pub(crate) use colors::samples_of_pixel;
pub use colors::{
    COLOR_BYTES, ColorDifferences, ColorTruth, Shown, broken_color_promises, color_promise,
    compare_colors, compare_colors_to_exact,
};
pub use span::{QUOTIENT_ULP, ROOT_ULP, Span};

/// The exact `t`'s own rounding to f64, which adds to a kernel's error: 2⁻⁵³ of `t`, which is at most
/// 2⁻²⁹ of a step.
const T_REFERENCE_ULP: f64 = 1.0 / (1u64 << 29) as f64;

/// Bytes of a ray that is compared: its index, what is exact about it, and the same once more on the
/// way.
pub const SAMPLE_BYTES: u64 = 128;

/// The exact results for some of the rays.
#[derive(Clone, Debug, Default)]
pub struct Truth {
    /// The rays, as indices into the [`Hits`] of all rays.
    pub index: Vec<usize>,
    /// Object ids, 0 for the background.
    pub id: Vec<u32>,
    /// The exact `t`, rounded to f64; +∞ on the background.
    pub t: Vec<f64>,
    /// The exact unit normals, each component rounded to f64; zero on the background.
    pub normal: Vec<[f64; 3]>,
}

impl Truth {
    /// The truth about the pixels with these indices; `control` counts each as a ray.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) when `control` was cancelled.
    pub fn of_pixels(
        scene: &Scene,
        pixels: &Pixels,
        index: Vec<usize>,
        control: &Control,
    ) -> Result<Truth> {
        let rays = ExactPixels::new(pixels);
        let ray = |i| {
            let (x, y) = pixels.xy(i);
            let (origin, direction) = (pixels.origin_offset(x, y), pixels.direction(x, y));
            let ray = Ray { origin, direction };
            (rays.ray(x, y), Near { reference: pixels.view.position, ray })
        };
        Truth::of_rays(scene, index, ray, control)
    }

    /// The truth about all rays of a list; `control` counts each.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) when `control` was cancelled.
    pub fn of_list(scene: &Scene, rays: &[Ray], control: &Control) -> Result<Truth> {
        let all = (0..rays.len()).collect();
        let ray = |i: usize| {
            let Ray { origin, direction } = rays[i];
            let ray = Ray { origin: DVec3::ZERO, direction };
            (ExactRay::new(&rays[i]), Near { reference: origin, ray })
        };
        Truth::of_rays(scene, all, ray, control)
    }

    fn of_rays(
        scene: &Scene,
        index: Vec<usize>,
        ray: impl Fn(usize) -> (ExactRay, Near) + Sync,
        control: &Control,
    ) -> Result<Truth> {
        let seen = index.par_iter().map(|&i| {
            control.check()?;
            control.advance(1);
            let (exact, near) = ray(i);
            Ok(see(scene, &exact, &near))
        });
        let seen: Vec<(u32, f64, [f64; 3])> = seen.collect::<Result<_>>()?;
        Ok(Truth {
            index,
            id: seen.iter().map(|seen| seen.0).collect(),
            t: seen.iter().map(|seen| seen.1).collect(),
            normal: seen.iter().map(|seen| seen.2).collect(),
        })
    }
}

/// A ray in f64, relative to a point: what is near the ray may be far from the world's origin.
struct Near {
    reference: DVec3,
    ray: Ray,
}

/// Id, `t` and normal of the object that a ray sees.
fn see(scene: &Scene, ray: &ExactRay, near: &Near) -> (u32, f64, [f64; 3]) {
    let Some(hit) = hit_of(scene, ray, near) else {
        return (0, f64::INFINITY, [0.0; 3]);
    };
    let normal = scene.object(hit.id).and_then(|object| hit.normal(ray, &object.into()));
    let normal = normal.map_or([0.0; 3], |normal| normal.map(|component| component.to_f64()));
    (hit.id, hit.t_f64(), normal)
}

/// The hit of a ray, by exact arithmetic on every object that f64 does not clearly rule out. No
/// hierarchy: this is what one is judged by.
fn hit_of(scene: &Scene, ray: &ExactRay, near: &Near) -> Option<ExactHit> {
    let objects = scene
        .objects()
        .filter(|(_, object)| !is_clearly_missed(near, object))
        .map(|(id, object)| (id, Shape::from(object)));
    exact::nearest(ray, objects)
}

/// True where the line of a ray whose numbers are exact to f64 passes a sphere at a distance, and so
/// surely misses it. The offset, the cross product, the lengths and the direction are off by some
/// `2⁻⁵⁰` of the lengths' product, a thousandth of what is granted. Numbers whose squares leave
/// f64's range rule nothing out.
fn is_clearly_missed(Near { reference, ray }: &Near, object: &Object) -> bool {
    const GRANTED: f64 = 1.0 / (1u64 << 40) as f64;
    let Object::Sphere(sphere) = object else { return false };
    let from_reference = sphere.center - *reference;
    let l = from_reference - ray.origin;
    let distance = from_reference.length() + ray.origin.length();
    let reach = sphere.radius.abs() * (1.0 + GRANTED) + distance * GRANTED;
    let direction = scale_by_power_of_two(ray.direction, -exponent_of(ray.direction));
    let (passed, reached) = (l.cross(direction).length(), reach * direction.length());
    const LEAST: f64 = 1e-140;
    passed > reached && reach > LEAST && passed.is_finite()
}

/// Where and how far a result is from the exact one.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct AgainstExact {
    /// Rays compared.
    pub rays: u64,
    /// Rays that hit an object where there is none.
    pub false_hits: u64,
    /// Rays that miss an object that is there.
    pub false_misses: u64,
    /// Rays that hit another object than the visible one.
    pub wrong_object: u64,
    /// Largest error of `t` where the object is right, in f32 steps at the exact `t`.
    pub t_ulp_max: f64,
    /// Largest distance of a normal from the exact one where the object is right.
    pub normal_distance_max: f64,
    /// Index of the first ray with a wrong id.
    pub first_wrong_id: Option<usize>,
}

impl AgainstExact {
    /// Rays with a wrong id.
    pub fn wrong_ids(&self) -> u64 {
        self.false_hits + self.false_misses + self.wrong_object
    }

    /// Adds another part of the same picture, whose rays begin at `first_ray`.
    pub fn add(&mut self, other: &AgainstExact, first_ray: usize) {
        self.rays += other.rays;
        self.false_hits += other.false_hits;
        self.false_misses += other.false_misses;
        self.wrong_object += other.wrong_object;
        self.t_ulp_max = self.t_ulp_max.max(other.t_ulp_max);
        self.normal_distance_max = self.normal_distance_max.max(other.normal_distance_max);
        let first = other.first_wrong_id.map(|index| first_ray + index);
        self.first_wrong_id = self.first_wrong_id.or(first);
    }
}

/// The error of one ray's result.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RayError {
    /// An object where there is none.
    FalseHit,
    /// No object where there is one; also a ray that the result lacks.
    FalseMiss,
    /// Another object than the visible one.
    WrongObject,
    /// The right object, or the background where it should be; `t` and the normal where the result
    /// has them.
    Right {
        /// The object.
        id: u32,
        /// How far `t` is off.
        t: Option<TError>,
        /// How far the normal is off.
        normal: Option<NormalError>,
    },
}

/// How far a `t` is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TError {
    /// In f32 steps at the exact `t`: `2^(e−23)` for an exact `t` in `2^e..2^(e+1)`, and not less
    /// than the smallest subnormal. +∞ where `t` is not finite. The smallest f32 in place of a `t`
    /// that would round to 0 is at most half a step off: a `t` is never 0.
    pub ulp: f64,
    /// Relative to the exact `t`. +∞ where `t` is not finite.
    pub relative: f64,
}

impl TError {
    pub(crate) fn new(t: f32, exact: f64) -> TError {
        if f64::from(t) == exact {
            return TError { ulp: 0.0, relative: 0.0 };
        }
        let error = (f64::from(t) - exact).abs();
        if error.is_nan() {
            return TError { ulp: f64::INFINITY, relative: f64::INFINITY };
        }
        let most = match t == f32::from_bits(1) && exact > 0.0 && exact < f64::from(t) {
            true => 0.5,
            false => f64::INFINITY,
        };
        let ulp = (error / Precision::Single.ulp(exact)).min(most);
        TError { ulp, relative: error / exact.abs() }
    }
}

/// How far a normal is off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalError {
    /// Length of the difference from the exact unit normal. +∞ where the normal is not finite.
    pub distance: f64,
    /// Angle to the exact normal, degrees; 180 where the normal is not finite.
    pub degrees: f64,
}

impl NormalError {
    fn new(normal: [f32; 3], exact: [f64; 3]) -> NormalError {
        let (normal, exact) = (DVec3::from(normal.map(f64::from)), DVec3::from(exact));
        let distance = (normal - exact).length();
        if !distance.is_finite() {
            return NormalError { distance: f64::INFINITY, degrees: 180.0 };
        }
        // Not the arc cosine, which loses half of its digits at small angles.
        let radians = normal.cross(exact).length().atan2(normal.dot(exact));
        NormalError { distance, degrees: radians.to_degrees() }
    }
}

/// Compares `hits` with the truth about some of its rays, in the order of the truth.
pub fn ray_errors<'a>(hits: &'a Hits, truth: &'a Truth) -> impl Iterator<Item = RayError> + 'a {
    truth.index.iter().enumerate().map(|(k, &index)| {
        match (hits.id.get(index).copied(), truth.id[k]) {
            (Some(id), expected) if id == expected => RayError::Right {
                id,
                t: hits.t.get(index).map(|&t| TError::new(t, truth.t[k])),
                normal: hits.normal.get(index).map(|&n| NormalError::new(n, truth.normal[k])),
            },
            (Some(0) | None, _) => RayError::FalseMiss,
            (Some(_), 0) => RayError::FalseHit,
            _ => RayError::WrongObject,
        }
    })
}

/// Compares `hits` with the truth about some of its rays. `t` and normals are looked at where
/// `hits` has them and the id is right. A ray that `hits` lacks counts as a wrong id.
pub fn compare_to_exact(hits: &Hits, truth: &Truth) -> AgainstExact {
    let mut result = AgainstExact { rays: truth.index.len() as u64, ..AgainstExact::default() };
    for (&index, error) in truth.index.iter().zip(ray_errors(hits, truth)) {
        let wrong = match error {
            RayError::FalseHit => &mut result.false_hits,
            RayError::FalseMiss => &mut result.false_misses,
            RayError::WrongObject => &mut result.wrong_object,
            RayError::Right { t, normal, .. } => {
                result.t_ulp_max = result.t_ulp_max.max(t.map_or(0.0, |t| t.ulp));
                result.normal_distance_max =
                    result.normal_distance_max.max(normal.map_or(0.0, |normal| normal.distance));
                continue;
            }
        };
        *wrong += 1;
        result.first_wrong_id.get_or_insert(index);
    }
    result
}

/// The promise of a kernel, in words. `bit_equal` says whether the kernel's arithmetic on the device
/// is that of IEEE 754 operation by operation, so that its result must be the CPU's bit by bit.
pub fn promise(kernel: Kernel, bit_equal: bool) -> &'static str {
    let promise = &kernel.about().promise;
    if bit_equal { promise.words } else { promise.words_elsewhere }
}

/// The promise, in words, of a kernel whose results have been [`compare_to_allowed`].
pub const PRECISION_PROMISE: &str = "ids, t and normals as Vulkan's precision allows them; neither \
     exactness nor equality with the CPU is promised";

/// The promise that a device's results outside Vulkan's precision break.
pub fn broken_precision(kernel: Kernel, device: &str, found: &Outside) -> Option<String> {
    let Outside { rays, outside, .. } = found;
    let name = kernel.name();
    (*outside > 0).then(|| {
        format!(
            "{name} on the {device}: {outside} of {rays} rays have results that Vulkan's precision does \
             not allow"
        )
    })
}

/// The promises of `kernel` that these results break, one sentence each. `parity` compares GPU
/// with CPU where both ran; `exact` has each device's name and result.
pub fn broken_promises(
    kernel: Kernel,
    bit_equal: bool,
    parity: Option<&Comparison>,
    exact: &[(&str, &AgainstExact)],
) -> Vec<String> {
    let mut broken = Vec::new();
    let name = kernel.name();
    let promised = kernel.about().promise.exact;
    let are_equal = bit_equal || promised.is_some();
    if let Some(parity) = parity.filter(|_| are_equal) {
        if parity.ids_differ() > 0 {
            broken.push(format!(
                "{name}: GPU and CPU see different objects in {} of {} rays",
                parity.ids_differ(),
                parity.rays
            ));
        } else if !parity.is_equal() {
            broken.push(format!(
                "{name}: GPU and CPU are not equal bit by bit: t differs in {} of {} rays (by up \
                 to {} ulp), the normal in {}",
                parity.t_differs, parity.rays, parity.t_ulp_max, parity.normal_differs
            ));
        }
    }
    for (device, against) in exact {
        if against.rays == 0 {
            broken.push(format!("{name} on the {device}: no ray was compared"));
        }
        let Some(Exactness { t_ulp, normal_distance }) = promised else { continue };
        if against.wrong_ids() > 0 {
            broken.push(format!(
                "{name} on the {device}: {} of {} ids are wrong",
                against.wrong_ids(),
                against.rays
            ));
        }
        if against.t_ulp_max > t_ulp + T_REFERENCE_ULP {
            broken.push(format!(
                "{name} on the {device}: t is off by {:.3} ulp, promised is {t_ulp}: the \
                 exact one rounded",
                against.t_ulp_max
            ));
        }
        if against.normal_distance_max > normal_distance {
            broken.push(format!(
                "{name} on the {device}: a normal is off by {:.3e}, promised is \
                 {normal_distance:.3e}",
                against.normal_distance_max
            ));
        }
    }
    broken
}

/// `n` different indices below `total`, ascending, drawn at random from `seed`; all of them when
/// `n` is not less.
pub fn sample(total: usize, n: usize, seed: u64) -> Vec<usize> {
    if n >= total {
        return (0..total).collect();
    }
    let mut random = SplitMix::new(seed);
    // Floyd's algorithm: n draws, whatever the total. A bit for each index, 128 MiB for the largest
    // picture, is ten times as quick as a tree.
    let mut chosen = vec![0_u64; total.div_ceil(64)];
    let mut insert = |index: usize| {
        let (word, bit) = (&mut chosen[index / 64], 1 << (index % 64));
        let is_new = *word & bit == 0;
        *word |= bit;
        is_new
    };
    for top in total - n..total {
        let drawn = (u128::from(random.next()) * (top as u128 + 1)) >> 64;
        if !insert(drawn as usize) {
            insert(top);
        }
    }
    let mut indices = Vec::with_capacity(n);
    for (at, &word) in chosen.iter().enumerate().filter(|(_, word)| **word != 0) {
        indices.extend((0..64).filter(|bit| word >> bit & 1 == 1).map(|bit| 64 * at + bit));
    }
    indices
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::compare::compare;
    use crate::rays::View;
    use crate::scene::{Camera, Color, Plane, Projection, Sphere};

    fn scene() -> (Scene, Pixels) {
        let camera = Camera {
            position: DVec3::new(0.0, 1.0, 6.0),
            look_at: DVec3::new(0.0, 0.5, 0.0),
            up: DVec3::Y,
            projection: Projection::Perspective { fov_degrees: 40.0 },
        };
        let pixels = Pixels::whole(View::new(&camera), 24, 16);
        let sphere = |x, radius| Sphere { center: DVec3::new(x, 0.5, 0.0), radius };
        let floor =
            Plane { name: None, point: DVec3::ZERO, normal: DVec3::Y, color: Color([0.5; 3]) };
        let scene = Scene {
            camera: Some(camera),
            spheres: vec![sphere(-0.6, 0.7), sphere(0.9, 0.4)].into(),
            planes: vec![floor],
            ..Scene::default()
        };
        (scene, pixels)
    }

    fn promised() -> Exactness {
        Kernel::Certified.about().promise.exact.unwrap()
    }

    /// The exact result, rounded: it keeps every promise.
    fn rounded(truth: &Truth) -> Hits {
        Hits {
            id: truth.id.clone(),
            t: truth.t.iter().map(|&t| t as f32).collect(),
            normal: truth.normal.iter().map(|n| n.map(|c| c as f32)).collect(),
            ..Hits::default()
        }
    }

    fn truth() -> Truth {
        let (scene, pixels) = scene();
        let all = (0..pixels.len()).collect();
        Truth::of_pixels(&scene, &pixels, all, &Control::default()).unwrap()
    }

    fn broken(kernel: Kernel, hits: &Hits) -> Vec<String> {
        let truth = truth();
        let parity = compare(hits, &rounded(&truth));
        let against = compare_to_exact(hits, &truth);
        broken_promises(kernel, true, Some(&parity), &[("GPU", &against)])
    }

    #[test]
    fn a_right_result_keeps_all_promises() {
        let truth = truth();
        for id in 0..=3 {
            assert!(truth.id.contains(&id), "no ray sees {id}");
        }
        let hits = rounded(&truth);
        let against = compare_to_exact(&hits, &truth);
        assert_eq!(against.rays, 24 * 16);
        assert_eq!(against.wrong_ids(), 0);
        assert!(against.t_ulp_max > 0.25 && against.t_ulp_max <= 0.5, "{against:?}");
        for kernel in Kernel::ALL {
            assert_eq!(broken(kernel, &hits), Vec::<String>::new());
        }
    }

    /// Each wrong result is noticed, under the right name, by every promise it breaks.
    #[test]
    fn sabotage_is_noticed() {
        let truth = truth();
        let on = |id| truth.id.iter().position(|&other| other == id).unwrap();
        type Sabotage = (&'static str, fn(&mut Hits, usize));
        let sabotages: [(u32, Sabotage); 7] = [
            (0, ("false hit", |hits, i| hits.id[i] = 2)),
            (1, ("false miss", |hits, i| hits.id[i] = 0)),
            (1, ("wrong object", |hits, i| hits.id[i] = 3)),
            (1, ("t", |hits, i| hits.t[i] = f32::from_bits(hits.t[i].to_bits() + 2))),
            (1, ("t", |hits, i| hits.t[i] = f32::NAN)),
            (0, ("t", |hits, i| hits.t[i] = 7.0)),
            (3, ("normal", |hits, i| hits.normal[i][1] += 2.0 / (1 << 23) as f32)),
        ];
        for (id, (what, apply)) in sabotages {
            let mut hits = rounded(&truth);
            apply(&mut hits, on(id));
            let against = compare_to_exact(&hits, &truth);
            let noticed = match what {
                "false hit" => against.false_hits == 1,
                "false miss" => against.false_misses == 1,
                "wrong object" => against.wrong_object == 1,
                "t" => against.t_ulp_max > 1.0,
                _ => against.normal_distance_max > promised().normal_distance,
            };
            assert!(noticed, "{what}: {against:?}");
            let wrong_ids = u64::from(!matches!(what, "t" | "normal"));
            assert_eq!(against.wrong_ids(), wrong_ids, "{what}");
            assert_eq!(against.first_wrong_id, (wrong_ids > 0).then(|| on(id)), "{what}");
            for kernel in Kernel::ALL {
                assert!(!broken(kernel, &hits).is_empty(), "{what}, {}", kernel.name());
            }
        }
        let short = Hits::default();
        assert_eq!(compare_to_exact(&short, &truth).wrong_ids(), truth.id.len() as u64);
        assert!(!broken(Kernel::Certified, &short).is_empty());
    }

    /// The same bits on every device: what is right to the last ulp on each is not enough.
    #[test]
    fn certified_devices_that_differ_are_noticed() {
        let truth = truth();
        let cpu = rounded(&truth);
        let i = truth.id.iter().position(|&id| id == 1).unwrap();
        type Sabotage = (&'static str, fn(&mut Hits, usize));
        let sabotages: [Sabotage; 4] = [
            ("t differs in 1", |hits, i| hits.t[i] = f32::from_bits(hits.t[i].to_bits() ^ 1)),
            ("t differs in 1", |hits, i| hits.t[i] = -hits.t[i]),
            ("the normal in 1", |hits, i| {
                hits.normal[i][2] = f32::from_bits(hits.normal[i][2].to_bits() ^ 1);
            }),
            ("see different objects in 1", |hits, i| hits.id[i] = 2),
        ];
        // Bit-equality is promised of the certified kernel also on a device whose own arithmetic
        // is not IEEE 754's.
        for bit_equal in [false, true] {
            let parity = |gpu: &Hits| {
                broken_promises(Kernel::Certified, bit_equal, Some(&compare(gpu, &cpu)), &[])
            };
            assert_eq!(parity(&cpu), Vec::<String>::new());
            for (what, apply) in sabotages {
                let mut gpu = cpu.clone();
                apply(&mut gpu, i);
                let broken = parity(&gpu);
                assert!(broken.len() == 1 && broken[0].contains(what), "{what}: {broken:?}");
            }
        }
    }

    /// A `t` is the exact one rounded: its neighbour is not, and what would round to 0 is the
    /// smallest f32.
    #[test]
    fn certified_t_is_rounded() {
        let truth = truth();
        let i = truth.id.iter().position(|&id| id == 1).unwrap();
        for step in [1, -1] {
            let mut hits = rounded(&truth);
            hits.t[i] = f32::from_bits(hits.t[i].to_bits().wrapping_add_signed(step));
            let against = compare_to_exact(&hits, &truth);
            let broken = broken_promises(Kernel::Certified, false, None, &[("GPU", &against)]);
            assert!(broken.len() == 1 && broken[0].contains("t is off"), "{step}: {broken:?}");
        }
        let least = f32::from_bits(1);
        assert!(TError::new(least, 1e-60).ulp <= promised().t_ulp);
        assert!(TError::new(least, f64::from(least) * 1.6).ulp > promised().t_ulp);
        assert!(TError::new(0.0, 1e-45).ulp > promised().t_ulp);
    }

    /// The bounds are not wider than promised: one and a half of each is too much.
    #[test]
    fn the_tolerances_are_tight() {
        for factor in [1.0, 1.5] {
            let with = [
                AgainstExact { rays: 1, t_ulp_max: 0.5 * factor, ..AgainstExact::default() },
                AgainstExact {
                    rays: 1,
                    normal_distance_max: factor / (1 << 23) as f64,
                    ..AgainstExact::default()
                },
            ];
            for against in with {
                let broken = broken_promises(Kernel::Certified, true, None, &[("CPU", &against)]);
                assert_eq!(broken.is_empty(), factor == 1.0, "{broken:?}");
            }
        }
    }

    #[test]
    fn what_is_not_promised_is_not_broken_and_nothing_is_not_success() {
        let parity = Comparison { rays: 9, other_object: 1, first: Some(3), ..Default::default() };
        let wrong = AgainstExact { rays: 9, wrong_object: 1, ..AgainstExact::default() };
        let stable = |bit_equal| {
            broken_promises(Kernel::Stable, bit_equal, Some(&parity), &[("GPU", &wrong)])
        };
        assert!(stable(false).is_empty());
        assert_eq!(stable(true).len(), 1);
        let nothing = AgainstExact::default();
        assert_eq!(broken_promises(Kernel::Stable, true, None, &[("CPU", &nothing)]).len(), 1);
    }

    #[test]
    fn ulps_are_those_of_the_exact_value() {
        assert_eq!(TError::new(1.0, 1.0).ulp, 0.0);
        assert_eq!(TError::new(1.0 + 2.0 * f32::EPSILON, 1.0).ulp, 2.0);
        assert_eq!(TError::new(1.0 - f32::EPSILON / 2.0, 1.0).ulp, 0.5);
        assert_eq!(TError::new(f32::from_bits(1), 0.0).ulp, 1.0);
        assert_eq!(TError::new(f32::INFINITY, f64::INFINITY).ulp, 0.0);
        assert_eq!(TError::new(f32::INFINITY, 1.0).ulp, f64::INFINITY);
        assert_eq!(TError::new(1.0, f64::INFINITY).ulp, f64::INFINITY);
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
