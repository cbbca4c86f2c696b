//! Results of a kernel against exact arithmetic, and the promises that they keep or break.

mod colors;
mod lit;
#[cfg(feature = "gpu")]
mod picture;
mod truth;

pub(crate) use colors::samples_of_pixel;
pub use colors::{ColorDifferences, RenderedColors};
pub(crate) use lit::{LitPoint, exact_mean};
#[cfg(feature = "gpu")]
pub use picture::{ColorsOfKernel, OfKernel, OnBoth, Parity, Verification, Verified};
use truth::hit_of;
pub(crate) use truth::{Near, candidates, is_clearly_missed};
pub use truth::{TrueHit, Truth, sample};

pub use crate::compare::RayError;
use crate::compare::{RayDifferences, RayResult};
use kugelblitz::query::{Hits, Kernel};

/// The exact `t`'s own rounding to f64, which adds to a kernel's error: 2⁻⁵³ of `t`, which is at most
/// 2⁻²⁹ of a step.
const T_REFERENCE_ULP: f64 = 1.0 / (1u64 << 29) as f64;

/// How hits of a device differ from those of another one or from the exact ones, and colours where they are looked at.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Differences {
    /// The hits.
    pub rays: RayDifferences,
    /// The colours.
    pub colors: Option<ColorDifferences>,
}

/// Compares `hits` with the truth about some of its rays, in the order of the truth.
pub fn ray_errors<'a>(hits: &'a Hits, truth: &'a Truth) -> impl Iterator<Item = RayError> + 'a {
    let error = |(&index, right): (&usize, &TrueHit)| {
        RayError::of(RayResult::of(hits, index), &right.into(), |normal| normal == right.normal_f32)
    };
    truth.index.iter().zip(&truth.hits).map(error)
}

/// Compares `hits` with the truth about some of its rays. `t` and normals are looked at where
/// `hits` has them and the id is right. A ray that `hits` lacks counts as a wrong id.
pub fn compare_to_exact(hits: &Hits, truth: &Truth) -> RayDifferences {
    let mut found = RayDifferences::default();
    found.see_exact(hits, truth, 0);
    found
}

impl RayDifferences {
    /// Counts the differences of `hits` from what is true, where the first of all rays has the index `first_ray`.
    fn see_exact(&mut self, hits: &Hits, truth: &Truth, first_ray: usize) {
        for (&ray, error) in truth.index.iter().zip(ray_errors(hits, truth)) {
            self.see(first_ray + ray, &error);
        }
    }
}

/// Returns the promise of a kernel in words.
///
/// `bit_equal`: whether the device calculates with IEEE 754's numbers, operation by operation, so that its result must equal the
/// CPU's bit by bit. `has_colors`: whether colours are compared. `has_gpu`: whether a GPU was compared with the CPU.
pub fn promise(kernel: Kernel, bit_equal: bool, has_colors: bool, has_gpu: bool) -> String {
    let promise = &kernel.about().promise;
    let mut words = if bit_equal { promise.words } else { promise.words_elsewhere }.to_owned();
    if promise.exact.is_some() {
        if has_gpu {
            words += ", GPU and CPU equal bit by bit";
        }
        if has_colors {
            words += ", every byte and every float of the colours the exact one";
        }
    }
    words
}

/// The promises of `kernel` that these results break, one sentence each. `parity` is the GPU's from the
/// CPU's where both ran; `exact` has each device's name, and its differences from what is exact.
pub fn broken_promises(
    kernel: Kernel,
    bit_equal: bool,
    parity: Option<&Differences>,
    exact: &[(&str, &Differences)],
) -> Vec<String> {
    let mut broken = Vec::new();
    let name = kernel.name();
    let promised = kernel.about().promise.exact;
    if let Some(Differences { rays, colors }) = parity.filter(|_| bit_equal || promised.is_some()) {
        let RayDifferences { rays: n, t_differs, t_ulp_max, normal_differs, .. } = rays;
        match rays.wrong_ids() {
            0 if rays.is_equal() => {}
            0 => broken.push(format!(
                "{name}: GPU and CPU are not equal bit by bit: t differs in {t_differs} of {n} rays (by up to \
                 {t_ulp_max} ulp), the normal in {normal_differs}"
            )),
            wrong => broken.push(format!("{name}: GPU and CPU see different objects in {wrong} of {n} rays")),
        }
        if let Some(found) = colors.as_ref().filter(|found| !found.is_equal()) {
            broken.push(format!("{name}: GPU and CPU show different colours: {found}"));
        }
    }
    for (device, Differences { rays, colors }) in exact {
        let mut add = |what: String| broken.push(format!("{name} on the {device}: {what}"));
        if rays.rays == 0 {
            add("no ray was compared".into());
        }
        if colors.as_ref().is_some_and(|colors| colors.pixels == 0) {
            add("no colour was compared".into());
        }
        let Some(promised) = promised else { continue };
        if rays.wrong_ids() > 0 {
            add(format!("{} of {} ids are wrong", rays.wrong_ids(), rays.rays));
        }
        if rays.t_ulp_max > promised.t_ulp + T_REFERENCE_ULP {
            add(format!(
                "t is off by {:.3} ulp, promised is {}: the exact one rounded",
                rays.t_ulp_max, promised.t_ulp
            ));
        }
        if rays.normal_differs > 0 {
            add(format!(
                "{} normals are not the exact ones rounded; the worst is off by {:.3e}",
                rays.normal_differs, rays.normal_distance_max
            ));
        }
        if let Some(found) = colors.as_ref().filter(|found| !found.is_equal()) {
            add(format!("wrong colours: {found}"));
        }
    }
    broken
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use kugelblitz::Control;
    use kugelblitz::query::Hits;
    use kugelblitz::rays::{Pixels, Rays, View};
    use kugelblitz::scene::{Camera, Color, Plane, Projection, Scene, Sphere};

    use super::*;
    use crate::compare::compare;

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

    /// The exact result, rounded: it keeps every promise.
    fn rounded(truth: &Truth) -> Hits {
        Hits {
            id: truth.hits.iter().map(|hit| hit.id).collect(),
            t: truth.hits.iter().map(|hit| hit.t as f32).collect(),
            normal: truth.hits.iter().map(|hit| hit.normal_f32).collect(),
            ..Hits::default()
        }
    }

    fn truth() -> Truth {
        let (scene, pixels) = scene();
        let all = (0..pixels.len()).collect();
        Truth::of_rays(&scene, &Rays::Pixels(pixels), all, &Control::default()).unwrap()
    }

    fn differences(rays: RayDifferences) -> Differences {
        Differences { rays, colors: None }
    }

    fn broken(kernel: Kernel, hits: &Hits) -> Vec<String> {
        let truth = truth();
        let parity = differences(compare(hits, &rounded(&truth)));
        let against = differences(compare_to_exact(hits, &truth));
        broken_promises(kernel, true, Some(&parity), &[("GPU", &against)])
    }

    #[test]
    fn a_right_result_keeps_all_promises() {
        let truth = truth();
        for id in 0..=3 {
            assert!(truth.hits.iter().any(|hit| hit.id == id), "no ray sees {id}");
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
        let on = |id| truth.hits.iter().position(|hit| hit.id == id).unwrap();
        type Sabotage = (&'static str, fn(&mut Hits, usize));
        let sabotages: [(u32, Sabotage); 9] = [
            (0, ("false hit", |hits, i| hits.id[i] = 2)),
            (1, ("false miss", |hits, i| hits.id[i] = 0)),
            (1, ("wrong object", |hits, i| hits.id[i] = 3)),
            (1, ("t", |hits, i| hits.t[i] = hits.t[i].next_up())),
            (1, ("t", |hits, i| hits.t[i] = hits.t[i].next_down())),
            (1, ("t", |hits, i| hits.t[i] = f32::NAN)),
            (0, ("t", |hits, i| hits.t[i] = 7.0)),
            (3, ("normal", |hits, i| hits.normal[i][1] = 1.0f32.next_down())),
            (1, ("normal", |hits, i| hits.normal[i][2] = hits.normal[i][2].next_up())),
        ];
        for (id, (what, apply)) in sabotages {
            let mut hits = rounded(&truth);
            apply(&mut hits, on(id));
            let against = compare_to_exact(&hits, &truth);
            let noticed = match what {
                "false hit" => against.false_hits == 1,
                "false miss" => against.false_misses == 1,
                "wrong object" => against.wrong_object == 1,
                "t" => against.t_ulp_max > 0.5,
                _ => against.normal_differs == 1,
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
        assert_eq!(compare_to_exact(&short, &truth).wrong_ids(), truth.hits.len() as u64);
        assert!(!broken(Kernel::Certified, &short).is_empty());
    }

    /// All devices give equal bits: what is right to the last ulp on each is not enough.
    #[test]
    fn certified_devices_that_differ_are_noticed() {
        let truth = truth();
        let cpu = rounded(&truth);
        let i = truth.hits.iter().position(|hit| hit.id == 1).unwrap();
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
                let parity = differences(compare(gpu, &cpu));
                broken_promises(Kernel::Certified, bit_equal, Some(&parity), &[])
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

    /// The bound is not wider than promised: one and a half of it is too much.
    #[test]
    fn the_tolerance_is_tight() {
        for factor in [1.0, 1.5] {
            let t_ulp_max = 0.5 * factor;
            let against = differences(RayDifferences { rays: 1, t_ulp_max, ..Default::default() });
            let broken = broken_promises(Kernel::Certified, true, None, &[("CPU", &against)]);
            assert_eq!(broken.is_empty(), factor == 1.0, "{broken:?}");
        }
    }

    #[test]
    fn what_is_not_promised_is_not_broken_and_nothing_is_not_success() {
        let wrong =
            RayDifferences { rays: 9, wrong_object: 1, first: Some(3), ..Default::default() };
        let wrong = differences(wrong);
        let stable = |bit_equal| {
            broken_promises(Kernel::Stable, bit_equal, Some(&wrong), &[("GPU", &wrong)])
        };
        assert!(stable(false).is_empty());
        assert_eq!(stable(true).len(), 1);
        let nothing = Differences::default();
        assert_eq!(broken_promises(Kernel::Stable, true, None, &[("CPU", &nothing)]).len(), 1);
    }
}
