//! The oracle of light and colour (`oracle/`) against closed forms, and the numbers that the contract has computed in f64
//! against rationals. That what the oracle decides is so, the matrix says, which has exact arithmetic of another make.

use std::cmp::Ordering;
use std::sync::Arc;

use glam::{DVec3, dvec3};
use kugelblitz_tests::oracle::enclosure::{Big, Number, Undecided};
use kugelblitz_tests::oracle::scene::{
    self, Camera, Light, Plane, Projection, Scene, Sky, Source, Sphere, linear,
};
use kugelblitz_tests::oracle::{Answer, Oracle, Truth, edges};
use kugelblitz_tests::rational::{Q, power, q};
use kugelblitz_tests::{in_cube, text_of};
use num_traits::{One, Signed};
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
// What the contract has computed in f64

fn q3(v: impl Into<[f64; 3]>) -> [Q; 3] {
    v.into().map(q)
}

fn qdot(u: &[Q; 3], v: &[Q; 3]) -> Q {
    u.iter().zip(v).map(|(u, v)| u * v).sum()
}

/// `|x| ≤ 2^exponent`
fn is_within(x: Q, exponent: i64) -> bool {
    x.abs() <= power(exponent)
}

#[test]
fn frames_are_orthonormal() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for _ in 0..300 {
        let size = 2f64.powi(rng.random_range(-300..300));
        let [position, look_at, up] =
            std::array::from_fn(|_| (in_cube(&mut rng) * size).to_array());
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
        term = (term * power(120)).round() * power(-120);
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
    let to_the = |x: &Q, n: u32| (0..n).fold(Q::one(), |power, _| power * x);
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
                    let x = to_the(&x, 12);
                    to_the(&low, 5) < x && x < to_the(&high, 5)
                }
            };
            assert!(is_near, "{byte} of {largest}: {edge}");
        }
    }
}
