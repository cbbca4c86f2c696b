//! The oracle of light and colour (`oracle/`) against closed forms, and against the rational oracle where the hit point is
//! rational; and the numbers that the contract has computed in f64 against rationals.
//!
//! Random cases are seeded: `KUGELBLITZ_SEED=n cargo test --profile ci -p kugelblitz-tests --test library light_oracle::` repeats one.

use std::cmp::Ordering;
use std::sync::Arc;

use glam::{DVec3, dvec3};
use kugelblitz::exact::Shape;
use kugelblitz_tests::cases::{any_vector, integer_frame, integer_vector, nonzero, seed};
use kugelblitz_tests::oracle::enclosure::{Big, Narrow, Number, Undecided};
use kugelblitz_tests::oracle::scene::{
    self, Camera, Light, Plane, Projection, Scene, Sky, Source, Sphere, linear,
};
use kugelblitz_tests::oracle::{Answer, Oracle, Truth, edges};
use kugelblitz_tests::rational::{OracleRay, OracleRoot, Q, q};
use kugelblitz_tests::{rational, text_of};
use num_traits::{One, Signed, Zero};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use toml::{Table, Value};

// ---------------------------------------------------------------------------------------------
// Scenes of one ray

fn white(spheres: &[(DVec3, f64)], planes: &[(DVec3, DVec3)], lights: &[Light]) -> Scene {
    let sphere = |&(center, radius): &(DVec3, f64)| white_sphere(center, radius);
    let plane = |&(point, normal): &(DVec3, DVec3)| white_plane(point, normal);
    Scene {
        spheres: spheres.iter().map(sphere).collect(),
        planes: planes.iter().map(plane).collect(),
        lights: lights.to_vec(),
        ..Scene::default()
    }
}

fn white_sphere(center: DVec3, radius: f64) -> Sphere {
    Sphere { center: center.to_array(), radius, color: [1.0; 3] }
}

fn white_plane(point: DVec3, normal: DVec3) -> Plane {
    Plane { point: point.to_array(), normal: normal.to_array(), color: [1.0; 3] }
}

fn light(source: Source) -> Light {
    Light { source, color: [1.0; 3], intensity: 1.0, shadows: true }
}

fn point(x: f64, y: f64, z: f64) -> Light {
    light(Source::Point([x, y, z]))
}

fn sun(x: f64, y: f64, z: f64) -> Light {
    light(Source::Sun([x, y, z]))
}

/// The pixel of one ray.
fn along(scene: &Scene, origin: DVec3, direction: DVec3) -> Truth {
    one_pixel(scene, Camera::along(origin.to_array(), direction.to_array()), 1)
}

fn one_pixel(scene: &Scene, camera: Camera, n_samples: u32) -> Truth {
    Oracle::seen_by(&Arc::new(scene.clone()), camera, 1, 1, n_samples).pixel(0, 0)
}

/// Sees `target` from `eye`.
fn from_to(scene: &Scene, eye: DVec3, target: DVec3) -> Truth {
    along(scene, eye, target - eye)
}

fn is_lit(truth: &Truth) -> bool {
    truth.channels[0].linear.value > 0.0
}

/// The red mean is this number within a few steps of f64.
#[track_caller]
fn assert_mean(truth: &Truth, expected: f64) {
    let [low, high] = truth.channels[0].mean;
    let slack = expected * 1e-14;
    assert!(low <= expected + slack && high >= expected - slack, "{expected}: {truth:?}");
    assert!(high - low <= 1e-12 * high, "{truth:?}");
    assert_eq!(truth.channels[0].linear.value, expected as f32, "{truth:?}");
}

fn looking(eye: DVec3, look_at: DVec3, projection: Projection) -> Camera {
    Camera::new(eye.to_array(), look_at.to_array(), [0.0, 1.0, 0.0], projection)
}

const FLOOR: (DVec3, DVec3) = (DVec3::ZERO, DVec3::Y);

// ---------------------------------------------------------------------------------------------
// Enclosures

fn int(x: f64, bits: u64) -> Big {
    Big::new(x, 0, bits)
}

/// `a + b√2 + c√3 + d√6` as `(a + b√2) + (c + d√2)·√3`.
fn of_two_roots([a, b, c, d]: [f64; 4], bits: u64) -> Big {
    let root = |x| int(x, bits).root();
    let left = int(a, bits).plus(&int(b, bits).times(&root(2.0)));
    let right = int(c, bits).plus(&int(d, bits).times(&root(2.0)));
    left.plus(&right.times(&root(3.0)))
}

#[test]
fn numbers_of_two_roots_that_are_0_are_told_from_those_that_are_nearly() {
    // Found by reducing the lattice of the four numbers: 6.2·10⁻³⁷, −2.2·10⁻³⁸. All conjugates are
    // below 2⁴⁴, so numbers from 2⁻¹³² on are not 0. With half the exponent, 2⁻⁶⁶, this would be.
    for (near, sign) in [
        ([1024288726922.0, -543307305048.0, -149377818705.0, 1140565680.0], Ordering::Greater),
        ([-69169277254.0, 929114877989.0, 939517922751.0, -1172525979947.0], Ordering::Less),
    ] {
        for bits in 60..155 {
            assert_eq!(of_two_roots(near, bits).sign(), Err(Undecided), "{bits} bits");
        }
        assert_eq!(of_two_roots(near, 200).sign(), Ok(sign));
    }
    // √(3 + 2√2) = 1 + √2.
    let nested = |bits| {
        let two = int(2.0, bits);
        let inner = int(3.0, bits).plus(&two.times(&two.root()));
        inner.root().minus(&int(1.0, bits).plus(&two.root()))
    };
    assert_eq!(nested(5).sign(), Err(Undecided));
    assert_eq!(nested(100).sign(), Ok(Ordering::Equal));
    assert_eq!(nested(100).plus(&Big::new(1.0, -30, 100)).sign(), Ok(Ordering::Greater));
}

#[test]
fn enclosures_hold_what_rationals_say() {
    let seed = seed();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for round in 0..2000 {
        let number = |rng: &mut ChaCha8Rng| {
            let size = 2f64.powi(rng.random_range(-60..60));
            match rng.random_range(0..8) {
                0 => 0.0,
                1 => rng.random_range(-4..5) as f64,
                _ => rng.random_range(-1.0..1.0) * size,
            }
        };
        let [a, b, c, d] = std::array::from_fn(|_| number(&mut rng));
        // (ab + c)² − d, and what rationals say of its sign.
        fn term<N: Number>(numbers: [f64; 4], bits: u64) -> N {
            let [a, b, c, d] = numbers.map(|x| N::new(x, 0, bits));
            a.times(&b).plus(&c).squared().minus(&d)
        }
        let exact: Q = {
            let inner = q(a) * q(b) + q(c);
            &inner * &inner - q(d)
        };
        let sign = if exact.is_zero() {
            Ordering::Equal
        } else if exact.is_positive() {
            Ordering::Greater
        } else {
            Ordering::Less
        };
        let say = format!("seed {seed}, round {round}: {a:e} {b:e} {c:e} {d:e}");
        let narrow: Narrow = term([a, b, c, d], 53);
        assert!(narrow.sign().is_ok_and(|s| s == sign) || narrow.sign().is_err(), "{say}");
        for bits in [20, 60, 200, 1000] {
            let big: Big = term([a, b, c, d], bits);
            assert!(big.sign().is_ok_and(|s| s == sign) || big.sign().is_err(), "{say}, {bits}");
            assert!(bits < 1000 || big.sign().is_ok(), "{say}");
            if exact.is_positive() {
                // Squares and quotients of positive numbers go back.
                for roots in [
                    big.root().squared(),
                    big.over(&int(3.0, bits)).unwrap().times(&int(3.0, bits)),
                ] {
                    if let Ok(difference) = roots.minus(&term([a, b, c, d], bits)).sign() {
                        assert_eq!(difference, Ordering::Equal, "{say}");
                    }
                }
                let wide = narrow.to_big(bits).unwrap();
                assert_ne!(wide.minus(&big).sign(), Ok(Ordering::Greater), "{say}");
                assert_ne!(wide.minus(&big).sign(), Ok(Ordering::Less), "{say}");
            }
        }
    }
}

#[test]
fn ends_round_to_f64_and_f32() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    for _ in 0..20_000 {
        let size = 2f64.powi(rng.random_range(-1074..1000));
        let x: f64 = rng.random_range(0.0..1.0) * size;
        let big = int(x, 200);
        assert_eq!(big.floors(), [x, x]);
        assert_eq!(big.nearest_f32(), [x as f32; 2], "{x:e}");
        // Just beside it, by less than any place of an f64.
        let tiny = Big::new(x, -90, 300);
        let (above, below) = (int(x, 300).plus(&tiny), int(x, 300).minus(&tiny));
        if x > 0.0 {
            assert_eq!(above.floors(), [x, x]);
            assert_eq!(below.floors(), [x.next_down(); 2]);
        }
        // On an edge between two f32, and beside it.
        let edge = f64::from(x as f32) / 2.0 + f64::from((x as f32).next_up()) / 2.0;
        if edge.is_finite() && edge > 0.0 {
            let tiny = Big::new(edge, -90, 300);
            let (low, high) = (x as f32, (x as f32).next_up());
            assert_eq!(int(edge, 300).minus(&tiny).nearest_f32(), [low; 2], "{edge:e}");
            assert_eq!(int(edge, 300).plus(&tiny).nearest_f32(), [high; 2], "{edge:e}");
            let even = if low.to_bits() % 2 == 0 { low } else { high };
            assert_eq!(int(edge, 300).nearest_f32(), [even; 2], "{edge:e}");
        }
    }
    let huge = Big::new(f64::MAX, 40, 100);
    assert_eq!((huge.floors(), huge.nearest_f32()), ([f64::MAX; 2], [f32::INFINITY; 2]));
    let least = Big::new(f64::from_bits(1), -1, 100);
    assert_eq!((least.floors(), least.nearest_f32()), ([0.0; 2], [0.0; 2]));
}

// ---------------------------------------------------------------------------------------------
// Closed forms

/// What `tests/data/closed_forms.toml` says of scenes of one ray.
#[test]
fn light_is_as_closed_forms_say() {
    let numbers = |value: &Value| -> Vec<f64> {
        let number = |value: &Value| match value {
            Value::Integer(number) => *number as f64,
            other => other.as_float().expect("a number"),
        };
        value.as_array().expect("numbers").iter().map(number).collect()
    };
    let table: Table = text_of("tests/data/closed_forms.toml").parse().expect("cases");
    let mut n_rays = [0; 2];
    for case in table["case"].as_array().expect("cases") {
        let shapes = |key: &str| -> Vec<Vec<f64>> {
            case.get(key).and_then(Value::as_array).into_iter().flatten().map(numbers).collect()
        };
        let spheres = shapes("spheres").into_iter().map(|s| (DVec3::from_slice(&s), s[3]));
        let planes = shapes("planes").into_iter();
        let planes = planes.map(|p| (DVec3::from_slice(&p), DVec3::from_slice(&p[3..])));
        let lights = scene::read(&format!("light = {}", case["light"])).lights;
        let scene = white(&spheres.collect::<Vec<_>>(), &planes.collect::<Vec<_>>(), &lights);
        for ray in case["rays"].as_array().expect("rays") {
            let point = |key: &str| Some(DVec3::from_slice(&numbers(ray.get(key)?)));
            let from = point("from").expect("an origin");
            let direction = point("along").or_else(|| Some(point("to")? - from));
            let truth = along(&scene, from, direction.expect("a direction"));
            let what = format!("{}: {ray}: {truth:?}", case["says"]);
            let id = ray.get("id").map_or(truth.id.into(), |id| id.as_integer().expect("an id"));
            assert_eq!(i64::from(truth.id), id, "{what}");
            let light = ray.get("light").map(|light| {
                light.as_float().or(light.as_integer().map(|n| n as f64)).expect("a number")
            });
            let lit = light.is_some() || ray["lit"].as_bool().expect("lit or not");
            assert_eq!(is_lit(&truth), lit, "{what}");
            if let Some(light) = light {
                assert_mean(&truth, light);
            }
            n_rays[usize::from(lit)] += 1;
        }
    }
    assert!(n_rays.iter().all(|n| *n > 20), "{n_rays:?}");
}

#[test]
fn colours_intensity_and_ambient_light_count() {
    let mut scene = white(&[], &[FLOOR], &[point(4.0, 3.0, 0.0)]);
    scene.lights[0].color = [1.0, 0.5, 0.25];
    scene.lights[0].intensity = 2.0;
    scene.ambient = Some([0.125, 0.25, 0.0]);
    scene.planes[0].color = [0.5, 1.0, 0.0];
    let truth = from_to(&scene, dvec3(0.0, 5.0, 7.0), DVec3::ZERO);
    assert_eq!(truth.linear(), [0.6625, 0.85, 0.0].map(|x: f64| x as f32));
}

/// As in any picture of a ball and a floor; an orthographic camera looks along its light.
#[test]
fn a_light_at_the_eye_lights_what_is_seen() {
    let eye = dvec3(0.0, 3.0, 4.0);
    let mut scene = white(&[(dvec3(0.0, 1.0, 0.0), 1.0)], &[FLOOR], &[light(Source::Eye)]);
    for projection in [Projection::Fov(60.0), Projection::Height(6.0)] {
        scene.camera = Some(looking(eye, dvec3(0.5, 0.75, 0.0), projection));
        let oracle = Oracle::new(&Arc::new(scene.clone()), 9, 7, 1);
        for (x, y) in (0..7).flat_map(|y| (0..9).map(move |x| (x, y))) {
            let truth = oracle.pixel(x, y);
            assert_eq!(truth.id != 0, is_lit(&truth), "{x} {y} {:?}", scene.camera);
        }
    }
    let camera = Some(looking(eye, DVec3::ZERO, Projection::Height(6.0)));
    let floor = Scene { camera, ..white(&[], &[FLOOR], &[light(Source::Eye)]) };
    let [low, high] = Oracle::new(&Arc::new(floor), 4, 4, 1).pixel(1, 2).channels[0].mean;
    assert!((low - 0.6).abs() < 1e-12 && (high - 0.6).abs() < 1e-12, "{low} {high}");
}

#[test]
fn a_sky_is_its_suns() {
    let sky = Sky { intensity: 0.75, directions: 7 };
    let scene = Scene { sky: Some(sky), ..white(&[], &[FLOOR], &[]) };
    let truth = from_to(&scene, dvec3(3.0, 3.0, 0.0), DVec3::ZERO);
    let up = sky.suns();
    let sum: f64 = up.iter().map(|&sun| (-sun[1] / DVec3::from_array(sun).length()).max(0.0)).sum();
    let [low, high] = truth.channels[0].mean;
    let expected = sum * 0.75 * 4.0 / 7.0;
    assert!((low - expected).abs() < 1e-14 && (high - expected).abs() < 1e-14, "{truth:?}");
}

#[test]
fn without_light_colors_are_as_they_are() {
    let mut scene = white(&[(DVec3::ZERO, 1.0)], &[], &[]);
    let red = [0xd6, 0x27, 0x28].map(|byte| linear(f64::from(byte) / 255.0));
    scene.spheres[0].color = red;
    scene.background = [0.1, 0.2, 0.3];
    let seen = from_to(&scene, DVec3::Z * 3.0, DVec3::ZERO);
    let floats = red.map(|x| x as f32);
    assert_eq!((seen.srgb8(), seen.linear(), seen.id), ([0xd6, 0x27, 0x28], floats, 1));
    assert_eq!(seen.srgb16(), [0xd6d6, 0x2727, 0x2828]);
    let missed = along(&scene, DVec3::Z * 3.0, DVec3::Z);
    assert_eq!((missed.linear(), missed.id), ([0.1, 0.2, 0.3], 0));
    // Ambient light of 0 is a light.
    scene.ambient = Some([0.0; 3]);
    assert_eq!(from_to(&scene, DVec3::Z * 3.0, DVec3::ZERO).srgb8(), [0; 3]);
    assert_eq!(along(&scene, DVec3::Z * 3.0, DVec3::Z).linear(), [0.1, 0.2, 0.3]);
    // Beyond the largest f32 there is nothing.
    let far =
        |z: f64| along(&white(&[], &[(DVec3::Z * z, DVec3::Z)], &[]), DVec3::ZERO, DVec3::Z).id;
    let limit = f64::from(f32::MAX) + 2f64.powi(103);
    assert_eq!((far(limit), far(limit.next_down())), (0, 1));
}

#[test]
fn samples_are_averaged() {
    // Two walls that meet in the middle of the pixel.
    let mut scene = white(&[], &[(DVec3::ZERO, DVec3::Z), (DVec3::ZERO, DVec3::X)], &[]);
    scene.planes[0].color = [1.0, 0.0, 0.0];
    scene.planes[1].color = [0.0, 1.0, 0.0];
    // Rays along (−1, 0, −1): those with x > z meet z = 0 first.
    let camera = Camera {
        position: [4.0, 0.0, 4.0],
        forward: [-1.0, 0.0, -1.0],
        right: [1.0, 0.0, -1.0],
        true_up: [0.0, 1.0, 0.0],
        h: 1.0,
        is_orthographic: true,
    };
    // One pixel, samples 4 across: two of them on each side.
    let truth = one_pixel(&scene, camera, 4);
    assert_eq!(truth.linear(), [0.5, 0.5, 0.0]);
    // Three: the middle column meets both at once, and the lower id wins.
    let truth = one_pixel(&scene, camera, 3);
    assert_eq!((truth.id, truth.n_hits), (1, 9));
    let third = 2.0 / 3.0;
    assert_eq!(truth.linear(), [third as f32, (1.0 - third) as f32, 0.0]);
    let uneven = Camera { position: [4.25, 0.0, 4.0], ..camera };
    // Shifted by 1/8 of the picture's half width along `right`: 5 samples of 8 are on the red side.
    let truth = one_pixel(&scene, uneven, 8);
    assert_eq!(truth.linear()[0], 5.0 / 8.0, "{truth:?}");
}

// ---------------------------------------------------------------------------------------------
// Edges of bytes

/// A white floor under three suns of this intensity, each with a cosine of 1/3: the mean is the
/// intensity, and no enclosure with fewer than all bits says so.
fn bright(intensity: f64) -> Truth {
    let suns = [(2.0, 2.0), (-2.0, 2.0), (2.0, -2.0)];
    let lights = suns.map(|(x, z)| Light { intensity, ..sun(x, -1.0, z) });
    from_to(&white(&[], &[FLOOR], &lights), dvec3(1.0, 3.0, 0.0), DVec3::ZERO)
}

#[test]
fn equal_goes_up_at_the_edges_of_bytes() {
    assert!(edges(255).is_sorted_by(|a, b| a < b) && edges(65535).is_sorted_by(|a, b| a < b));
    for byte in [1u8, 2, 10, 100, 128, 254, 255] {
        let edge = linear((f64::from(byte) - 0.5) / 255.0);
        assert_eq!(bright(edge).channels[0].srgb8, Answer { value: byte, is_tie: true });
        let (below, above) = (edge.next_down(), edge.next_up());
        assert_eq!(bright(below).channels[0].srgb8, Answer { value: byte - 1, is_tie: false });
        assert_eq!(bright(above).channels[0].srgb8, Answer { value: byte, is_tie: false });
    }
    for wide in [1u16, 77, 30_000, 65_535] {
        let edge = linear((f64::from(wide) - 0.5) / 65535.0);
        assert_eq!(bright(edge).channels[0].srgb16.value, wide);
        assert_eq!(bright(edge.next_down()).channels[0].srgb16.value, wide - 1);
    }
    for (intensity, byte) in [(0.0, 0), (1e-300, 0), (1.0, 255), (7.0, 255), (1e300, 255)] {
        let channel = bright(intensity).channels[0];
        assert_eq!(channel.srgb8.value, byte, "{intensity}");
        assert_eq!(channel.linear.value, intensity as f32, "{intensity}");
    }
}

#[test]
fn floats_on_the_edge_of_two_are_even() {
    for bits in [1f32.to_bits(), 0.3f32.to_bits(), 0.3f32.to_bits() + 1, 1] {
        let (low, high) = (f32::from_bits(bits), f32::from_bits(bits + 1));
        let edge = (f64::from(low) + f64::from(high)) / 2.0;
        let channel = bright(edge).channels[0];
        let even = if bits % 2 == 0 { low } else { high };
        assert_eq!(channel.linear, Answer { value: even, is_tie: true });
        assert_eq!(bright(edge.next_up()).channels[0].linear.value, high);
        assert_eq!(bright(edge.next_down()).channels[0].linear.value, low);
    }
}

// ---------------------------------------------------------------------------------------------
// Against rationals

/// Small integers, so that tangencies, contacts and lights on surfaces are common.
fn integer_scene(rng: &mut ChaCha8Rng, light_near: DVec3) -> Scene {
    let n_spheres = rng.random_range(0..5);
    let spheres: Vec<(DVec3, f64)> = (0..n_spheres)
        .map(|_| (integer_vector(rng, 6), f64::from(rng.random_range(1..6))))
        .collect();
    let n_planes = rng.random_range(0..3);
    let planes: Vec<(DVec3, DVec3)> = (0..n_planes)
        .map(|_| (integer_vector(rng, 6), integer_vector(rng, 2) + DVec3::Y * 5.0))
        .collect();
    let source = match rng.random_range(0..5) {
        0 | 1 => Source::Sun((integer_vector(rng, 3) - DVec3::Y * 4.0).to_array()),
        2 => Source::Point(light_near.to_array()),
        3 => Source::Eye,
        _ => Source::Point(integer_vector(rng, 8).to_array()),
    };
    white(&spheres, &planes, &[light(source)])
}

fn shapes(scene: &Scene) -> Vec<(u32, Shape)> {
    let v = DVec3::from_array;
    let sphere =
        |&Sphere { center, radius, .. }: &Sphere| Shape::Sphere { center: v(center), radius };
    let plane =
        |&Plane { point, normal, .. }: &Plane| Shape::Plane { point: v(point), normal: v(normal) };
    let shapes = scene.spheres.iter().map(sphere).chain(scene.planes.iter().map(plane));
    (1..).zip(shapes).collect()
}

fn q3(v: impl Into<[f64; 3]>) -> [Q; 3] {
    v.into().map(q)
}

fn qdot(u: &[Q; 3], v: &[Q; 3]) -> Q {
    u.iter().zip(v).map(|(u, v)| u * v).sum()
}

/// `n·ω` squared of the light where it counts, by rationals, at the rational hit point.
fn rational_cosine2(
    scene: &Scene,
    eye: DVec3,
    direction: &[Q; 3],
    (id, p): (u32, &[Q; 3]),
) -> Option<Q> {
    let shapes = shapes(scene);
    let mut normal = match shapes[id as usize - 1].1 {
        Shape::Sphere { center, .. } => {
            let c = q3(center);
            std::array::from_fn(|i| &p[i] - &c[i])
        }
        Shape::Plane { normal, .. } => q3(normal),
    };
    if qdot(&normal, direction).is_positive() {
        normal = normal.map(|x| -x);
    }
    let (w, is_point) = match scene.lights[0].source {
        Source::Point(position) => (q3(position), true),
        Source::Sun(direction) => (q3(direction.map(|x| -x)), false),
        Source::Eye => (q3(eye), true),
    };
    let w: [Q; 3] = if is_point { std::array::from_fn(|i| &w[i] - &p[i]) } else { w };
    let along = qdot(&normal, &w);
    if !along.is_positive() {
        return None;
    }
    let shadow_ray = OracleRay { origin: p.clone(), direction: w.clone() };
    let is_in_way = |shape: &Shape| {
        OracleRoot::visible(&shadow_ray, shape)
            .is_some_and(|root| !is_point || root.cmp_rational(&q(1.0)).is_lt())
    };
    let blocked = shapes.iter().any(|(_, shape)| is_in_way(shape));
    (!blocked).then(|| &along * &along / qdot(&normal, &normal) / qdot(&w, &w))
}

#[test]
fn lit_or_not_is_what_rationals_say() {
    let seed = seed();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut lit, mut dark, mut on_spheres, mut hard) = (0, 0, 0, 0);
    for round in 0..2000 {
        // A rational point on a surface that comes first, and a ray through it.
        let (eye, direction, first): (DVec3, DVec3, Result<Sphere, Plane>) = if rng.random() {
            let ([u, ..], radius) = integer_frame(&mut rng, 3);
            let center = integer_vector(&mut rng, 6);
            let direction = integer_vector(&mut rng, 4) + DVec3::X * 9.0;
            let eye = center + u - direction * rng.random_range(1..4) as f64;
            (eye, direction, Ok(white_sphere(center, radius)))
        } else {
            let normal = integer_vector(&mut rng, 2) + DVec3::Z * 5.0;
            let point = integer_vector(&mut rng, 6);
            let direction = integer_vector(&mut rng, 5) + DVec3::X * 9.0;
            let eye = integer_vector(&mut rng, 9);
            (eye, direction, Err(white_plane(point, normal)))
        };
        let mut scene = {
            let near = integer_vector(&mut rng, 3) * nonzero(&mut rng, 2);
            integer_scene(&mut rng, eye + near)
        };
        match first {
            Ok(sphere) => scene.spheres.push(sphere),
            Err(plane) => scene.planes.push(plane),
        }
        let ray = OracleRay { origin: q3(eye), direction: q3(direction) };
        let seen = rational::nearest(&ray, &shapes(&scene));
        let truth = along(&scene, eye, direction);
        let say = || format!("seed {seed}, round {round}: {scene:?} {eye} {direction}: {truth:?}");
        assert_eq!(truth.id, seen.as_ref().map_or(0, |(id, _)| *id), "{}", say());
        let Some((id, root)) = seen else {
            continue;
        };
        // A rational root of small numbers, or none.
        let t = (1..4).map(|n| q(f64::from(n))).find(|t| root.cmp_rational(t).is_eq());
        let t = t.or_else(|| match shapes(&scene)[id as usize - 1].1 {
            Shape::Plane { point, normal } => {
                let normal = q3(normal);
                Some(qdot(&q3(point - eye), &normal) / qdot(&ray.direction, &normal))
            }
            Shape::Sphere { .. } => None,
        });
        let Some(t) = t else {
            continue;
        };
        let p = ray.at(&t);
        match rational_cosine2(&scene, eye, &ray.direction, (id, &p)) {
            None => {
                assert!(!is_lit(&truth), "{}", say());
                dark += 1;
            }
            Some(cosine2) => {
                let [low, high] = truth.channels[0].mean.map(q);
                let slack = rational::power(-45);
                assert!(&low * &low <= &cosine2 + &slack, "{}", say());
                assert!(&high * &high >= cosine2 - slack, "{}", say());
                assert!(truth.channels[0].mean[0] > 0.0, "{}", say());
                lit += 1;
            }
        }
        on_spheres += usize::from(id as usize <= scene.spheres.len());
        hard += usize::from(truth.bits > 53);
    }
    println!("{lit} lit, {dark} dark, {on_spheres} on spheres, {hard} of more than 53 bits");
    assert!(lit > 200 && dark > 200 && on_spheres > 200 && hard > 40, "seed {seed}");
}

#[test]
fn samples_see_what_rationals_see() {
    let seed = seed();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for round in 0..60 {
        let n_spheres = rng.random_range(1..8);
        let spheres: Vec<(DVec3, f64)> = (0..n_spheres)
            .map(|_| (any_vector(&mut rng, 4.0), rng.random_range(0.1..2.0)))
            .collect();
        let mut scene = white(&spheres, &[(DVec3::Y * -3.0, DVec3::Y)], &[]);
        let projection = match rng.random() {
            true => Projection::Fov(rng.random_range(1.0..150.0)),
            false => Projection::Height(rng.random_range(1.0..20.0)),
        };
        let view = looking(any_vector(&mut rng, 10.0), DVec3::ZERO, projection);
        scene.camera = Some(view);
        let [width, height] = [rng.random_range(1..9), rng.random_range(1..9)];
        let samples = rng.random_range(1..4);
        let (x, y) = (rng.random_range(0..width), rng.random_range(0..height));
        let oracle = Oracle::new(&Arc::new(scene.clone()), width, height, samples);
        let truth = oracle.pixel(x, y);
        let n_hits = (0..samples * samples)
            .filter(|k| {
                let ray =
                    sample_ray(&view, [width, height], [x, y], samples, [k % samples, k / samples]);
                rational::nearest(&ray, &shapes(&scene)).is_some()
            })
            .count();
        assert_eq!(truth.n_hits as usize, n_hits, "seed {seed}, round {round}: {scene:?} {x} {y}");
        let middle = sample_ray(&view, [width, height], [x, y], 1, [0, 0]);
        let seen = rational::nearest(&middle, &shapes(&scene));
        assert_eq!(truth.id, seen.map_or(0, |(id, _)| id), "seed {seed}, round {round}: {scene:?}");
    }
}

/// The contract's ray through `x + (i + ½)/N`, `y + (j + ½)/N`, letter by letter.
fn sample_ray(view: &Camera, size: [u32; 2], xy: [u32; 2], n: u32, ij: [u32; 2]) -> OracleRay {
    let int = |x: u32| q(f64::from(x));
    let (half, two, one) = (q(0.5), q(2.0), q(1.0));
    let [w, h] = size.map(int);
    let [x, y] = std::array::from_fn(|k| int(xy[k]) + (int(ij[k]) + &half) / int(n));
    let right = (&two * x / &w - &one) * q(view.h) * (&w / &h);
    let up = (one - two * y / h) * q(view.h);
    let (r, u) = (q3(view.right), q3(view.true_up));
    let moved = |v: [f64; 3]| {
        let v = q3(v);
        std::array::from_fn(|i| &v[i] + &right * &r[i] + &up * &u[i])
    };
    match view.is_orthographic {
        false => OracleRay { origin: q3(view.position), direction: moved(view.forward) },
        true => OracleRay { origin: moved(view.position), direction: q3(view.forward) },
    }
}

// ---------------------------------------------------------------------------------------------
// What the contract has computed in f64

/// `|x| ≤ 2^exponent`
fn is_within(x: Q, exponent: i64) -> bool {
    x.abs() <= rational::power(exponent)
}

#[test]
fn frames_are_orthonormal() {
    let mut rng = ChaCha8Rng::seed_from_u64(seed());
    for _ in 0..300 {
        let size = 2f64.powi(rng.random_range(-300..300));
        let [position, look_at, up] = std::array::from_fn(|_| any_vector(&mut rng, size));
        let (position, look_at, up) = (position.to_array(), look_at.to_array(), up.to_array());
        let camera = Camera::new(position, look_at, up, Projection::Height(1.0));
        let [f, r, u] = [camera.forward, camera.right, camera.true_up].map(q3);
        for (v, w, expected) in [
            (&f, &f, 1.0),
            (&r, &r, 1.0),
            (&u, &u, 1.0),
            (&f, &r, 0.0),
            (&f, &u, 0.0),
            (&r, &u, 0.0),
        ] {
            // Roundings of an up that is nearly along the way add up to more.
            assert!(is_within(qdot(v, w) - q(expected), -40), "{camera:?}");
        }
        // Ahead, and above.
        let ahead: [Q; 3] = std::array::from_fn(|i| q(look_at[i]) - q(position[i]));
        assert!(qdot(&f, &ahead).is_positive() && qdot(&u, &q3(up)).is_positive(), "{camera:?}");
    }
}

/// `Σ (−1)^k x^(2k + first)/(2k + first)!` to `2⁻⁸⁰`: the cosine from 0, the sine from 1.
fn series(x: &Q, first: u32) -> Q {
    let mut term = if first == 0 { Q::one() } else { x.clone() };
    let mut sum = term.clone();
    let mut k = first;
    while !is_within(term.clone(), -90) {
        term = -term * x * x / q(f64::from((k + 1) * (k + 2)));
        // Fewer digits are enough.
        term = (term * rational::power(120)).round() * rational::power(-120);
        (sum, k) = (sum + &term, k + 2);
    }
    sum
}

/// The golden angle is `π(3 − √5)`: `π` by Machin's formula, `√5` by Newton's.
#[test]
fn a_sky_turns_by_the_golden_angle() {
    let arctan_of_inverse = |n: f64| {
        let power = |k: u32| (0..2 * k + 1).fold(Q::one(), |power, _| power / q(n));
        let term = |k: u32| {
            power(k) / q(f64::from(2 * k + 1)) * q(if k.is_multiple_of(2) { 1.0 } else { -1.0 })
        };
        (0..40).map(term).sum::<Q>()
    };
    let pi = q(16.0) * arctan_of_inverse(5.0) - q(4.0) * arctan_of_inverse(239.0);
    let root = (0..6).fold(q(2.25), |x, _| (&x + q(5.0) / &x) / q(2.0));
    let turn = pi * (q(3.0) - root);
    let suns = Sky { intensity: 1.0, directions: 3 }.suns();
    // The middle one lies in the plane of the horizon, turned once.
    assert_eq!(suns[1][1], 0.0);
    let [cos, sin] = [suns[1][0], suns[1][2]].map(|x| -q(x));
    assert!(is_within(cos - series(&turn, 0), -52) && is_within(sin - series(&turn, 1), -52));
}

/// An edge `y` of a byte is `((e + 0.055)/1.055)^2.4` of the encoded number `e` between two: `y⁵ = x¹²`.
#[test]
fn edges_of_bytes_are_those_of_srgb() {
    let power = |x: &Q, n: u32| (0..n).fold(Q::one(), |power, _| power * x);
    for largest in [255u16, 65535] {
        for byte in (1..=largest).step_by(usize::from(largest / 255)) {
            let edge = edges(largest)[usize::from(byte) - 1];
            let encoded = (q(f64::from(byte)) - q(0.5)) / q(f64::from(largest));
            let tenths = |x: f64, n: f64| q(x) / q(n);
            let [low, high] =
                [-1.0, 1.0].map(|sign| q(edge) * (q(1.0) + q(sign * 4.0 * f64::EPSILON)));
            let is_near = match encoded <= tenths(4045.0, 100_000.0) {
                true => {
                    let exact = encoded / tenths(1292.0, 100.0);
                    low < exact && exact < high
                }
                false => {
                    let x = (encoded + tenths(55.0, 1000.0)) / tenths(1055.0, 1000.0);
                    let x = power(&x, 12);
                    power(&low, 5) < x && x < power(&high, 5)
                }
            };
            assert!(is_near, "{byte} of {largest}: {edge}");
        }
    }
}
