//! The bounds of `lecture` and `stable` on devices that keep to Vulkan's precision and not to IEEE 754:
//! the worst device that keeps to it stays within them, needs more than half of each, and one that does
//! not keep to it is noticed.

use std::sync::Arc;

use glam::DVec3;
use kugelblitz::control::Control;
use kugelblitz::kernel::Lists;
use kugelblitz::kernel::plain::{Hit, Plain, PlainRays, facing};
use kugelblitz::num::Real;
use kugelblitz::prepare::{Objects, Prepared};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Hits, Kernel, Ray, Rays, Wants};
use kugelblitz::tracer::Tracer;
use kugelblitz_tests::adversarial::{Adversarial, set_choices};
use kugelblitz_tests::allowed::{Outside, compare_to_allowed};
use kugelblitz_tests::span::{QUOTIENT_ULP, ROOT_ULP, Span};
use kugelblitz_tests::{camera, in_cube, log_uniform, plane, scene, sphere};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const KERNELS: [Kernel; 2] = [Kernel::Lecture, Kernel::Stable];

/// Devices whose roundings all go down, all up, or either way; also to the ends of their tolerances.
fn devices(rng: &mut ChaCha8Rng) -> impl Iterator<Item = (u64, bool)> + use<> {
    let choices = [0, u64::MAX, rng.random()];
    choices.into_iter().flat_map(|choices| [(choices, false), (choices, true)])
}

/// A device in software whose roundings are those of this thread.
struct Device<'a> {
    prepared: &'a Prepared,
    rays: &'a Rays,
}

impl Device<'_> {
    fn trace<S: Plain<Float = f32>, P: Plain<Float = f32>>(
        &self,
        lists: &Lists<S, P>,
        hits: &mut Hits,
    ) {
        let rays = PlainRays::new(self.prepared.coordinates(), self.rays);
        for index in 0..self.rays.len() {
            let ray = rays.one::<Adversarial>(index);
            let Hit { t, id } = lists.closest(&ray);
            if id == 0 {
                continue;
            }
            let at = id as usize - 1;
            let along = match lists.spheres.get(at) {
                Some(sphere) => sphere.normal(&ray, t),
                None => lists.planes[at - lists.spheres.len()].normal(&ray, t),
            };
            hits.id[index] = id;
            hits.t[index] = (f64::from(t.0) * rays.scales::<1>(index)[0]) as f32;
            hits.normal[index] = facing(along, ray.ray.direction).0.map(|x| x.0);
        }
    }

    fn hits(&self, (choices, wide): (u64, bool)) -> Hits {
        set_choices(choices, wide);
        let mut hits = Hits::default();
        hits.reset(self.rays.len(), Wants { surface: true, level: false });
        match &self.prepared.objects {
            Objects::Lecture(lists) => self.trace(lists, &mut hits),
            Objects::Stable(lists) => self.trace(lists, &mut hits),
            other => panic!("no plain kernel in f32: {other:?}"),
        }
        hits
    }
}

fn on_cpu(prepared: &Arc<Prepared>, rays: &Rays) -> Hits {
    let (mut hits, wants) = (Hits::default(), Wants { surface: true, level: false });
    let mut tracer = Tracer::on_cpu(Arc::clone(prepared), wants);
    tracer.trace(rays, &Control::default(), &mut hits).unwrap();
    hits
}

/// Spheres from near to far away, and two planes.
fn world(rng: &mut ChaCha8Rng) -> Arc<Scene> {
    let spheres = (0..9)
        .map(|_| {
            let distance = log_uniform(rng, 1.0, 1e5).abs();
            sphere(in_cube(rng) * distance, distance * rng.random_range(0.01..0.6))
        })
        .collect();
    let planes = (0..2).map(|_| plane(in_cube(rng) * 50.0, in_cube(rng))).collect();
    Arc::new(scene(spheres, planes))
}

/// A picture, and rays from anywhere in any direction.
fn some_rays(rng: &mut ChaCha8Rng) -> [Rays; 2] {
    let view = View::new(&camera(in_cube(rng), in_cube(rng) * 3.0));
    let mut list = Vec::new();
    for _ in 0..2000 {
        let direction = in_cube(rng) * log_uniform(rng, 1e-4, 1e4);
        list.push(Ray { origin: in_cube(rng) * 10.0, direction });
    }
    [Rays::Pixels(Pixels::whole(view, 61, 43)), Rays::List(list)]
}

fn outside(prepared: &Prepared, rays: &Rays, hits: &Hits) -> Outside {
    let all: Vec<usize> = (0..rays.len()).collect();
    compare_to_allowed(prepared, rays, hits, &all).expect("a plain kernel in f32")
}

fn prepared(scene: &Arc<Scene>, kernel: Kernel, rays: &Rays) -> Arc<Prepared> {
    Arc::new(Prepared::new(Arc::clone(scene), kernel, rays).unwrap())
}

#[test]
fn each_device_that_keeps_to_the_precision_is_within_the_bounds() {
    let (mut n_hits, mut n_otherwise) = (0, 0);
    for seed in 0..6 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let scene = world(&mut rng);
        for rays in some_rays(&mut rng) {
            for kernel in KERNELS {
                let prepared = prepared(&scene, kernel, &rays);
                let device = Device { prepared: &prepared, rays: &rays };
                let nearest = on_cpu(&prepared, &rays);
                assert_eq!(outside(&prepared, &rays, &nearest).outside, 0, "the CPU");
                for choices in devices(&mut rng) {
                    let hits = device.hits(choices);
                    let found = outside(&prepared, &rays, &hits);
                    assert_eq!(found.outside, 0, "{choices:?}, seed {seed}: {found:?}");
                    n_hits += hits.n_hits();
                    n_otherwise += (0..rays.len()).filter(|&i| hits.t[i] != nearest.t[i]).count();
                }
            }
        }
    }
    assert!(n_hits > 50_000 && n_otherwise > 20_000, "{n_hits} hits, {n_otherwise} otherwise");
}

#[test]
fn results_that_no_such_device_gives_are_noticed() {
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let ball = sphere(DVec3::NEG_Z * 5.0, 1.0);
    let behind = sphere(DVec3::NEG_Z * 9.0, 1.5);
    let scene = Arc::new(scene(vec![ball, behind], vec![plane(DVec3::NEG_Z * 20.0, DVec3::Z)]));
    let view = View::new(&camera(DVec3::ZERO, DVec3::NEG_Z));
    let rays = Rays::Pixels(Pixels::whole(view, 61, 43));
    for kernel in KERNELS {
        let prepared = prepared(&scene, kernel, &rays);
        let hits = on_cpu(&prepared, &rays);
        assert_eq!(
            outside(&prepared, &rays, &hits),
            Outside { rays: 61 * 43, ..Outside::default() }
        );
        let of_ball: Vec<usize> = (0..rays.len()).filter(|&i| hits.id[i] == 1).collect();
        type Sabotage = (&'static str, fn(&mut Hits, usize));
        let sabotages: [Sabotage; 7] = [
            ("missed", |hits, i| {
                (hits.id[i], hits.t[i], hits.normal[i]) = (0, f32::INFINITY, [0.0; 3])
            }),
            ("the sphere behind", |hits, i| hits.id[i] = 2),
            ("no object", |hits, i| hits.id[i] = 99),
            ("t off by 2⁻¹²", |hits, i| hits.t[i] *= 1.0 + 2f32.powi(-12)),
            ("t not a number", |hits, i| hits.t[i] = f32::NAN),
            ("the normal turned", |hits, i| hits.normal[i][2] = -hits.normal[i][2]),
            ("the normal off by 2⁻¹⁰", |hits, i| hits.normal[i][0] += 2f32.powi(-10)),
        ];
        for (what, spoil) in sabotages {
            let mut hits = hits.clone();
            // Not at the outline, where little is certain.
            let i = of_ball[of_ball.len() / 2 + rng.random_range(0..3)];
            spoil(&mut hits, i);
            let found = outside(&prepared, &rays, &hits);
            assert_eq!((found.outside, found.first), (1, Some(i)), "{what}, {}", kernel.name());
        }
    }
    let certified = prepared(&scene, Kernel::Certified, &rays);
    assert_eq!(compare_to_allowed(&certified, &rays, &Hits::default(), &[]), None);
}

/// Of what an operation may be off, in units, the worst device takes more than half; so no bound can
/// be halved. Sums and products go to the very ends.
#[test]
fn no_bound_is_twice_as_wide_as_needed() {
    let mut rng = ChaCha8Rng::seed_from_u64(22);
    let (mut quotient_ulp, mut root_ulp, mut n_ends) = (0f64, 0f64, 0);
    for _ in 0..2000 {
        let [a, b] = [0; 2].map(|_| log_uniform(&mut rng, 1e-6, 1e6) as f32);
        for (choices, wide) in devices(&mut rng) {
            set_choices(choices, wide);
            let (x, y) = (Adversarial(a), Adversarial(b));
            let (sum, product, quotient, root) = (x + y, x * y, x / y, x.abs().sqrt());
            let (p, q) = (Span::new(a), Span::new(b));
            for (span, found) in [
                (p + q, sum),
                (p - -q, sum),
                (p * q, product),
                (p / q, quotient),
                (p.abs().sqrt(), root),
            ] {
                assert!(span.has(found.0), "{a:e}, {b:e}: {span:?} without {:e}", found.0);
            }
            for (span, found) in [(p + q, sum.0), (p * q, product.0)] {
                let neighbour = (found.next_up(), found.next_down());
                assert!(
                    !(span.has(neighbour.0) && span.has(neighbour.1)),
                    "{span:?} round {found:e}"
                );
                n_ends += 1;
            }
            let off = |found: f32, exact: f64| {
                let ulp = 2f64.powi((exact.abs().to_bits() >> 52) as i32 - 1023 - 23);
                (f64::from(found) - exact).abs() / ulp
            };
            let (a, b) = (f64::from(a), f64::from(b));
            quotient_ulp = quotient_ulp.max(off(quotient.0, a / b));
            root_ulp = root_ulp.max(off(root.0, a.abs().sqrt()));
        }
    }
    assert!(n_ends > 0);
    assert!((QUOTIENT_ULP / 2.0..QUOTIENT_ULP).contains(&quotient_ulp), "{quotient_ulp}");
    assert!((ROOT_ULP / 2.0..ROOT_ULP).contains(&root_ulp), "{root_ulp}");
}

/// A subnormal counts as it is or as 0, and what leaves f32's range may become anything.
#[test]
fn the_ends_of_the_range_are_open() {
    let least = f32::MIN_POSITIVE;
    let tiny = Span::new(least) * Span::new(0.5);
    assert!(tiny.has(0.0) && tiny.has(least / 2.0) && !tiny.has(least));
    assert!(Span::new(f32::from_bits(1)).has(0.0));
    let negative = -Span::new(least) * Span::new(0.25);
    assert!(negative.has(0.0) && !negative.has(least / 8.0));
    for any in [
        Span::new(f32::MAX) + Span::new(f32::MAX),
        Span::new(f32::MAX) * Span::new(2.0),
        Span::ONE / (Span::new(1.0) - Span::new(1.0)),
        Span::ONE / Span::new(least / 2.0),
        (-Span::ONE).sqrt(),
        Span::new(f32::NAN) + Span::ONE,
    ] {
        assert!(any.is_any() && any.has(f32::NAN) && any.has(f32::INFINITY), "{any:?}");
        assert!((any * Span::ONE).is_any() && !(any > Span::ZERO) && !(any < Span::ZERO));
    }
    assert!((Span::ONE - Span::ONE) == Span::ZERO);
}
