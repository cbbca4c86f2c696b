//! Scenes where it is hard, as scene files, and rays through them. A family is a function that fills a
//! [`Draft`] at sizes around 1; where it lies, how large it is, its lights and its camera's kind are drawn
//! for all families alike. To add a case, add a function to [`FAMILIES`].

use std::fmt::Write as _;
use std::sync::Arc;

use glam::{DVec3, dvec3};
use kugelblitz_tests::oracle::{Oracle, edges, scene::read};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::USUAL;

/// A scene file's text, and rays: origin and direction.
pub struct Hard {
    pub family: &'static str,
    pub text: String,
    pub rays: Vec<[DVec3; 2]>,
}

/// A scene before it has its place and its lights.
pub struct Draft {
    eye: DVec3,
    look_at: DVec3,
    /// Half the picture's height where it looks at.
    half: f64,
    spheres: Vec<(DVec3, f64)>,
    planes: Vec<(DVec3, DVec3)>,
    /// Lights that it is all about.
    lights: Vec<Light>,
    /// The intensity of these lights, where all things and lights are white.
    white: Option<f64>,
    /// The camera's kind, where it is not drawn.
    lens: Option<Lens>,
    /// Of the power of two that all is scaled by, where its place and size are not drawn.
    exponent: Option<i32>,
    /// Rays beside those that are drawn.
    rays: Vec<[DVec3; 2]>,
}

impl Draft {
    /// No coordinate is larger.
    fn extent(&self) -> f64 {
        let spheres = self.spheres.iter().map(|(center, radius)| center.abs() + *radius);
        let planes = self.planes.iter().map(|(point, _)| *point);
        let points = spheres.chain(planes).chain([self.eye, self.look_at]);
        points.fold(self.half, |most, v| most.max(v.abs().max_element()))
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Lens {
    Parallel,
    /// With the angle in degrees, or the one that the draft asks for.
    Perspective(Option<f64>),
}

/// A light at a point, or a sun that shines along a vector.
#[derive(Clone, Copy)]
enum Light {
    Point(DVec3),
    Sun(DVec3),
}

pub type Family = fn(&mut Rng) -> Draft;
type Rng = ChaCha8Rng;

pub const FAMILIES: [(&str, Family); 35] = [
    ("silhouettes", silhouettes),
    ("eye near a surface", eye_near),
    ("eye on a surface", eye_on),
    ("touching", touching),
    ("nested", nested),
    ("coincident", coincident),
    ("ground", ground),
    ("tiny", tiny_balls),
    ("planes about the eye", planes_about_eye),
    ("near-parallel planes", near_parallel),
    ("tangent planes", tangent_planes),
    ("grazing planes", grazing),
    ("interpenetrating", interpenetrating),
    ("crowd", crowd),
    ("far crowd", far_crowd),
    ("mixture", mixture),
    ("edges of shadows", edges_of_shadows),
    ("galaxy", galaxy),
    ("far wall", far_wall),
    ("beyond f64", beyond_f64),
    ("cloud", cloud),
    ("heap", heap),
    ("many about the eye", many_about_eye),
    ("equal roots", equal_roots),
    ("whole pixels", whole_pixels),
    ("whole numbers", whole_numbers),
    ("plane of the picture", plane_of_picture),
    ("narrow", narrow),
    ("ends of f64", ends_of_f64),
    ("planes in one place", planes_in_one_place),
    ("edges of bytes", edges_of_bytes),
    ("extremes", extremes),
    ("ends of f32", ends_of_f32),
    ("lamps on surfaces", lamps_on_surfaces),
    ("outliers", outliers),
];

/// A family's random numbers for a scene: by its name, so that a new family changes no other.
pub fn stream(family: &str, number: u64) -> u64 {
    // FNV-1a.
    let hash = family.bytes().fold(0xcbf2_9ce4_8422_2325, |hash: u64, byte| {
        (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
    });
    hash.wrapping_add(number)
}

/// The scene of this number of a family, the same for the same seed.
pub fn scene(seed: u64, family: usize, number: u64) -> Hard {
    let (family, make) = FAMILIES[family];
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(stream(family, number));
    let rng = &mut rng;
    let mut draft = make(rng);
    let lens = draft.lens.unwrap_or_else(|| match rng.random_bool(0.4) {
        true => Lens::Parallel,
        false => Lens::Perspective(None),
    });
    if draft.lens.is_none() {
        set_apart(rng, &mut draft, lens);
    }
    let place = match draft.exponent {
        None => place(rng, draft.extent()),
        Some(exponent) => Place { by: DVec3::ZERO, scale: 2f64.powi(exponent) },
    };
    let rays = rays(rng, &draft).into_iter().map(|ray| place.ray(ray)).collect();
    // The same numbers for any gain, and others for what it is.
    let of_text = rng.clone();
    let with = |gain| text(&mut of_text.clone(), &draft, place, lens, gain);
    let mut text = with(1.0);
    rng.set_stream(!stream(family, number));
    if rng.random_bool(0.15)
        && let Some(gain) = gain_onto_edge(rng, &text)
    {
        text = with(gain);
    }
    Hard { family, text, rays }
}

/// What all light has to be multiplied by to bring a number of some pixel to an edge of its range, within rounding.
fn gain_onto_edge(rng: &mut Rng, text: &str) -> Option<f64> {
    let scene = Arc::new(read(text));
    let [width, height] = USUAL;
    let truth = Oracle::new(&scene, width, height, 1)
        .pixel(rng.random_range(0..width), rng.random_range(0..height));
    let gain = any_edge(rng) / truth.channels[rng.random_range(0..3)].mean[0];
    // The background's light stays as it is.
    (scene.is_lit() && truth.id != 0 && (1e-30..1e30).contains(&gain)).then_some(gain)
}

/// A number between two bytes, between two of 16 bits, or between two floats.
fn any_edge(rng: &mut Rng) -> f64 {
    let of_bytes = if rng.random_bool(0.4) { edges(255) } else { edges(65535) };
    let edge = of_bytes[rng.random_range(0..of_bytes.len())];
    let float = edge as f32;
    match rng.random_bool(0.3) {
        true => (f64::from(float) + f64::from(float.next_up())) / 2.0,
        false => edge,
    }
}

// ---------------------------------------------------------------------------------------------
// What is drawn

fn sign(rng: &mut Rng) -> f64 {
    if rng.random() { 1.0 } else { -1.0 }
}

fn power_of_ten(rng: &mut Rng, low: f64, high: f64) -> f64 {
    10f64.powf(rng.random_range(low..high))
}

/// `2^-52 … 2^-4` of either sign, or 0.
fn little(rng: &mut Rng) -> f64 {
    if rng.random_bool(0.2) { 0.0 } else { 2f64.powi(rng.random_range(-52..-3)) * sign(rng) }
}

fn within(rng: &mut Rng, size: f64) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| rng.random_range(-size..size)))
}

fn unit(rng: &mut Rng) -> DVec3 {
    within(rng, 1.0).normalize_or(DVec3::X)
}

fn across(rng: &mut Rng, v: DVec3) -> DVec3 {
    v.cross(unit(rng)).normalize_or(v.any_orthonormal_vector())
}

fn integers(rng: &mut Rng, most: i32) -> DVec3 {
    let mut one = || f64::from(rng.random_range(-most..=most));
    let v = dvec3(one(), one(), one());
    if v == DVec3::ZERO { DVec3::Y } else { v }
}

/// A unit vector, often with short numbers.
fn way(rng: &mut Rng) -> DVec3 {
    match rng.random_range(0..3) {
        0 => [DVec3::X, DVec3::Y, DVec3::Z][rng.random_range(0..3)] * sign(rng),
        1 => dvec3(0.6, 0.8, 0.0) * sign(rng),
        _ => unit(rng),
    }
}

/// Three orthogonal integer vectors of the same integer length (the columns of a rotation by an
/// integer quaternion, times its norm; Pythagorean quadruples), and that length.
fn integer_frame(rng: &mut Rng) -> ([DVec3; 3], f64) {
    let mut integer = || f64::from(rng.random_range(-9..=9));
    let a = loop {
        match integer() {
            0.0 => {}
            a => break a,
        }
    };
    let [b, c, d] = [(); 3].map(|()| integer());
    let columns = [
        dvec3(a * a + b * b - c * c - d * d, 2.0 * (b * c + a * d), 2.0 * (b * d - a * c)),
        dvec3(2.0 * (b * c - a * d), a * a - b * b + c * c - d * d, 2.0 * (c * d + a * b)),
        dvec3(2.0 * (b * d + a * c), 2.0 * (c * d - a * b), a * a - b * b - c * c + d * d),
    ];
    (columns, a * a + b * b + c * c + d * d)
}

/// One ulp up or down, or not at all, half of the time.
fn nudged(rng: &mut Rng, x: f64) -> f64 {
    match rng.random_range(0..4) {
        0 => x.next_up(),
        1 => x.next_down(),
        _ => x,
    }
}

// ---------------------------------------------------------------------------------------------
// Families

fn draft(eye: DVec3, look_at: DVec3, half: f64) -> Draft {
    let (spheres, planes, lights, rays) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (white, lens, exponent) = (None, None, None);
    Draft { eye, look_at, half, spheres, planes, lights, white, lens, exponent, rays }
}

/// The picture shows a piece of a sphere's outline, often a very small one.
fn silhouettes(rng: &mut Rng) -> Draft {
    let eye = way(rng) * power_of_ten(rng, 0.1, 4.0);
    let distance = eye.length();
    let sine = 1.0 / distance;
    let edge = across(rng, eye) * (1.0 - sine * sine).sqrt() + eye / distance * sine;
    let mut draft = draft(eye, edge * (1.0 + little(rng)), power_of_ten(rng, -9.0, 0.3));
    draft.spheres = vec![(DVec3::ZERO, 1.0)];
    for _ in 0..rng.random_range(0..3) {
        let radius = power_of_ten(rng, -2.0, 1.0);
        draft.spheres.push((edge + (edge - eye) * 0.1 + way(rng) * radius, radius));
    }
    draft
}

fn eye_near(rng: &mut Rng) -> Draft {
    let radius = power_of_ten(rng, -1.0, 3.0);
    let outward = way(rng);
    let eye = outward * (radius * (1.0 + little(rng)));
    let look_at = match rng.random_range(0..3) {
        0 => DVec3::ZERO,
        1 => eye + across(rng, outward) * radius,
        _ => eye + outward,
    };
    let mut draft = draft(eye, look_at, (look_at - eye).length() * power_of_ten(rng, -2.0, 0.5));
    draft.spheres = vec![(DVec3::ZERO, radius), (eye + unit(rng) * 4.0, 1.0)];
    if rng.random() {
        draft.planes.push((eye - outward * little(rng), outward));
    }
    draft
}

/// Exactly on it, and exactly in a plane.
fn eye_on(rng: &mut Rng) -> Draft {
    let eye = dvec3(3.0, 4.0, 0.0);
    let look_at = [DVec3::ZERO, dvec3(-1.0, 7.0, 0.0), dvec3(3.0, 4.0, 9.0), integers(rng, 9)]
        [rng.random_range(0..4)];
    let mut draft = draft(eye, look_at, power_of_ten(rng, -1.0, 1.0));
    draft.spheres = vec![(DVec3::ZERO, 5.0), (dvec3(3.0, 4.0, 2.0), 2.0)];
    draft.spheres.push((integers(rng, 20), 3.0));
    draft.planes = vec![(eye, integers(rng, 3)), (DVec3::ZERO, dvec3(4.0, -3.0, 0.0))];
    draft
}

/// 3² + 4² = 5²: the points of contact are numbers of f64, and the ray along the picture's axis may go through one.
fn touching(rng: &mut Rng) -> Draft {
    let contact = dvec3(3.0, 4.0, 0.0);
    let eye = match rng.random() {
        true => integers(rng, 12),
        false => contact + DVec3::AXES[rng.random_range(0..3)] * (sign(rng) * 8.0),
    };
    let mut draft = draft(eye, contact, power_of_ten(rng, -6.0, 0.8));
    draft.spheres = vec![
        (DVec3::ZERO, 5.0),
        (dvec3(6.0, 8.0, 0.0), 5.0),
        (dvec3(1.5, 2.0, 0.0), 2.5),
        (dvec3(4.5, 6.0, 0.0), 2.5),
    ];
    draft.planes = vec![(dvec3(3.0, 4.0, 0.0), dvec3(3.0, 4.0, 0.0))];
    draft
}

fn nested(rng: &mut Rng) -> Draft {
    let (mut radius, n) = (1.0f64, rng.random_range(2..7));
    let eye = match rng.random_range(0..3) {
        0 => DVec3::ZERO,
        1 => way(rng) * (1.0 + little(rng)),
        _ => way(rng) * rng.random_range(1.5..6.0),
    };
    let look_at = eye + unit(rng).lerp(-eye, 0.7);
    let mut draft = draft(eye, look_at, power_of_ten(rng, -6.0, 0.5));
    for _ in 0..n {
        draft.spheres.push((way(rng) * little(rng), radius));
        radius *= match rng.random_range(0..3) {
            0 => 1.0 + 2f64.powi(-rng.random_range(40..53)),
            1 => 1.0 + 2f64.powi(-rng.random_range(10..40)),
            _ => rng.random_range(1.1..3.0),
        };
    }
    draft
}

/// The same thing twice, and one that is it but for the last bits.
fn coincident(rng: &mut Rng) -> Draft {
    let mut draft = mixture(rng);
    for _ in 0..3 {
        let (center, radius) = draft.spheres[rng.random_range(0..draft.spheres.len())];
        draft.spheres.push((center, radius));
        draft.spheres.push((center * (1.0 + little(rng)), radius * (1.0 + little(rng))));
    }
    let normal = integers(rng, 3);
    draft.planes = vec![(DVec3::ZERO, normal), (DVec3::ZERO, normal * -3.0)];
    draft.planes.push((dvec3(normal.y, -normal.x, 0.0), normal * 0.5));
    draft
}

/// A huge ball is the ground, seen from close by; small balls lie on it.
fn ground(rng: &mut Rng) -> Draft {
    let radius = power_of_ten(rng, 2.0, 9.0).round();
    let eye = dvec3(0.0, power_of_ten(rng, -3.0, 1.0), 5.0);
    let mut draft = draft(eye, dvec3(0.0, 0.4, 0.0), rng.random_range(0.3..4.0));
    draft.spheres = vec![(dvec3(0.0, -radius, 0.0), radius)];
    for _ in 0..rng.random_range(1..5) {
        let size = power_of_ten(rng, -3.0, 0.3);
        draft
            .spheres
            .push((dvec3(rng.random_range(-3.0..3.0), size * (1.0 + little(rng)), 0.0), size));
    }
    draft
}

fn tiny_balls(rng: &mut Rng) -> Draft {
    let size = power_of_ten(rng, -14.0, -3.0);
    let mut draft = draft(way(rng) * 3.0, DVec3::ZERO, size * power_of_ten(rng, 0.0, 1.0));
    for _ in 0..rng.random_range(1..8) {
        draft.spheres.push((within(rng, size * 2.0), size * rng.random_range(0.1..3.0)));
    }
    if rng.random() {
        draft.planes.push((DVec3::ZERO, way(rng)));
    }
    draft
}

fn planes_about_eye(rng: &mut Rng) -> Draft {
    let eye = integers(rng, 5);
    let mut draft = draft(eye, eye + way(rng) * 4.0, power_of_ten(rng, -1.0, 1.0));
    for _ in 0..rng.random_range(2..6) {
        let normal = if rng.random() { integers(rng, 4) } else { unit(rng) };
        draft.planes.push((eye + normal * little(rng), normal * power_of_ten(rng, -3.0, 3.0)));
    }
    draft.spheres.push((eye + unit(rng) * 3.0, 1.0));
    draft
}

fn near_parallel(rng: &mut Rng) -> Draft {
    let mut draft = draft(way(rng) * 6.0 + DVec3::Y, DVec3::ZERO, power_of_ten(rng, -6.0, 1.0));
    let (point, normal) = (within(rng, 1.0), way(rng));
    for _ in 0..rng.random_range(2..6) {
        let turned = normal + across(rng, normal) * little(rng);
        draft.planes.push((point + normal * little(rng), turned * power_of_ten(rng, -2.0, 2.0)));
    }
    draft
}

fn tangent_planes(rng: &mut Rng) -> Draft {
    let normal =
        [dvec3(3.0, 4.0, 0.0), dvec3(1.0, 2.0, 2.0), dvec3(2.0, 3.0, 6.0)][rng.random_range(0..3)];
    // Its length is a whole number.
    let contact = normal * f64::from(rng.random_range(1..4));
    let radius = contact.length();
    let eye = contact + normal * rng.random_range(0.0..4.0) + within(rng, 2.0);
    let mut draft = draft(eye, contact, radius * power_of_ten(rng, -7.0, 0.0));
    draft.spheres = vec![(DVec3::ZERO, radius), (contact * 2.0, radius)];
    draft.planes = vec![(contact, normal), (contact * (1.0 + little(rng)), -normal)];
    draft
}

/// Planes along which the picture's rays go, and things on them.
fn grazing(rng: &mut Rng) -> Draft {
    let ahead = way(rng);
    let normal = across(rng, ahead);
    let mut draft =
        draft(-ahead * 8.0 + normal * little(rng), DVec3::ZERO, power_of_ten(rng, -5.0, 0.5));
    draft.planes =
        vec![(DVec3::ZERO, normal), (normal * little(rng), normal + ahead * little(rng))];
    draft.spheres = vec![(ahead * 2.0 + normal * 0.5, 0.5), (ahead * 2.0 - normal * 0.5, 0.5)];
    draft
}

fn interpenetrating(rng: &mut Rng) -> Draft {
    let mut draft = draft(integers(rng, 5) * 2.0, DVec3::ZERO, power_of_ten(rng, -2.0, 0.7));
    for _ in 0..rng.random_range(3..7) {
        draft.spheres.push((within(rng, 1.0), rng.random_range(0.3..1.8)));
    }
    draft.planes.push((within(rng, 0.3), integers(rng, 2)));
    draft
}

/// Enough for a tree.
fn crowd(rng: &mut Rng) -> Draft {
    let mut draft = draft(unit(rng) * 9.0, DVec3::ZERO, power_of_ten(rng, -0.5, 0.6));
    for _ in 0..rng.random_range(36..70) {
        draft.spheres.push((within(rng, 3.0), power_of_ten(rng, -2.5, 0.2)));
    }
    if rng.random() {
        draft.planes.push((DVec3::Y * -3.0, DVec3::Y));
    }
    draft
}

/// The same with touching balls of a lattice, far away, and the ground below.
fn far_crowd(rng: &mut Rng) -> Draft {
    let mut draft =
        draft(unit(rng) * power_of_ten(rng, 1.5, 5.0), DVec3::ZERO, power_of_ten(rng, -1.0, 0.8));
    for k in 0..64 {
        let [x, y, z] = [k % 4, k / 4 % 4, k / 16].map(f64::from);
        draft.spheres.push((dvec3(x, y, z) * 2.0 - 3.0, 1.0));
    }
    draft.spheres.push((DVec3::Y * -1e6, 1e6 - 4.0));
    draft
}

fn mixture(rng: &mut Rng) -> Draft {
    let mut draft = draft(within(rng, 9.0), DVec3::ZERO, power_of_ten(rng, -1.0, 0.8));
    for _ in 0..rng.random_range(2..9) {
        draft.spheres.push((within(rng, 4.0), power_of_ten(rng, -2.0, 0.8)));
    }
    for _ in 0..rng.random_range(0..3) {
        draft.planes.push((within(rng, 4.0), unit(rng)));
    }
    draft
}

/// Pixels of the floor lie exactly where a ball's shadow ends, in numbers of f64: the camera looks down from
/// between the two, pixels are 1 apart, `1.5² + 2² = 2.5²`, and `4.5² + 6² = 7.5²` where rays from 10 high pass
/// a ball of radius 3 half-way.
fn edges_of_shadows(rng: &mut Rng) -> Draft {
    let is_point = rng.random();
    let (x, height, radius) = if is_point { (4.5, 5.0, 3.0) } else { (0.5, 6.0, 2.5) };
    let eye = dvec3(x, 1.0, 0.0);
    let mut draft = draft(eye, eye - DVec3::Y, HALF_OF_WHOLE);
    draft.lens = Some(Lens::Parallel);
    draft.spheres = vec![(dvec3(0.0, height, 0.0), radius)];
    draft.planes = vec![(DVec3::ZERO, DVec3::Y * f64::from(rng.random_range(1..4)))];
    draft.lights = vec![match is_point {
        true => Light::Point(DVec3::Y * 10.0),
        false => Light::Sun(-DVec3::Y),
    }];
    draft
}

/// Half the height of a picture of the usual size whose pixels are 1 apart.
const HALF_OF_WHOLE: f64 = USUAL[1] as f64 / 2.0;

/// Balls on a floor, all of a size whose square leaves f32's range, one ball beside the picture.
fn galaxy(rng: &mut Rng) -> Draft {
    let size = match rng.random_range(0..3) {
        // The balls leave the range, and where rays start does not.
        0 => power_of_ten(rng, 16.6, 17.3),
        1 => power_of_ten(rng, 17.0, 22.0),
        _ => power_of_ten(rng, 5.0, 38.0),
    };
    let is_floor = rng.random();
    let eye = match is_floor {
        true => dvec3(0.0, 6.0, 8.0),
        false => dvec3(0.0, 0.0, 8.0),
    };
    let eye = (eye + within(rng, 0.5)) * size;
    let mut draft = draft(eye, DVec3::ZERO, size * rng.random_range(2.0..4.0));
    match is_floor {
        true => {
            draft.spheres = vec![(DVec3::Y * size, size)];
            draft.planes = vec![(DVec3::ZERO, DVec3::Y)];
        }
        false => {
            draft.spheres = vec![(DVec3::ZERO, size), (dvec3(9.0, 0.0, 8.0) * size, size * 3.0)]
        }
    }
    if rng.random_bool(0.3) {
        let radius = size * power_of_ten(rng, -3.0, 0.5);
        draft.spheres.push((within(rng, 3.0) * size, radius));
    }
    draft.lens = Some(Lens::Parallel);
    draft.lights = vec![Light::Sun(match is_floor {
        true => dvec3(-1.0, rng.random_range(-2.0..-0.5), rng.random_range(-1.0..1.0)),
        false => -DVec3::X,
    })];
    draft
}

/// Far behind a small picture is a wall, and beside it a ball that darkens what is seen of the wall.
fn far_wall(rng: &mut Rng) -> Draft {
    let away = match rng.random() {
        true => power_of_ten(rng, 17.0, 31.0),
        false => power_of_ten(rng, 2.0, 39.0),
    };
    let half = power_of_ten(rng, -1.0, 2.0);
    let eye = within(rng, half);
    let mut draft = draft(eye, eye - DVec3::Z, half);
    let normal = dvec3(rng.random_range(-0.2..0.2), 0.0, 1.0);
    draft.planes = vec![(DVec3::Z * -away, normal)];
    draft.spheres = vec![(dvec3(0.5, 0.0, -0.5) * away, away * rng.random_range(0.02..0.2))];
    if rng.random_bool(0.3) {
        draft.spheres.push((within(rng, half), half * 0.3));
    }
    draft.lens = Some(Lens::Parallel);
    draft.lights = vec![Light::Sun(dvec3(-1.0, 0.0, -1.0))];
    draft
}

/// A ball whose square f64 cannot hold; rays start far apart on both sides of its surface.
fn beyond_f64(rng: &mut Rng) -> Draft {
    let apart = power_of_ten(rng, 34.0, 38.0);
    let radius = apart * power_of_ten(rng, 20.0, 60.0);
    let eye = dvec3(0.0, 0.0, apart * rng.random_range(-1.0..1.0));
    // Else the surface is met beyond f32's `t`.
    let toward = dvec3(0.0, 0.0, -eye.z) + within(rng, 0.1 * apart);
    let mut draft = draft(eye, eye + toward, apart * rng.random_range(0.2..1.0));
    draft.spheres = vec![(DVec3::Z * radius, radius)];
    if rng.random_bool(0.3) {
        draft.spheres.push((within(rng, apart), apart * 0.2));
    }
    draft.lens = Some(Lens::Parallel);
    draft.lights = vec![Light::Sun(-DVec3::Z)];
    draft
}

/// So many balls that lists of rays have a tree, seen from without or within.
fn cloud(rng: &mut Rng) -> Draft {
    let n = power_of_ten(rng, 2.12, 3.48) as usize;
    let size = rng.random_range(0.3..2.0) / (n as f64).cbrt();
    let distance = if rng.random_bool(0.7) { power_of_ten(rng, 0.5, 2.0) } else { 0.5 };
    let mut draft = draft(unit(rng) * distance, DVec3::ZERO, power_of_ten(rng, -0.7, 0.3));
    let cluster = rng.random_bool(0.3);
    for _ in 0..n {
        let center = match cluster && rng.random() {
            true => unit(rng) * power_of_ten(rng, -4.0, 0.0),
            false => within(rng, 1.0),
        };
        draft.spheres.push((center, size * power_of_ten(rng, -1.5, 0.3)));
    }
    if rng.random_bool(0.2) {
        draft.spheres.extend_from_within(..);
    }
    draft
}

/// A lattice of touching balls on a huge one.
fn heap(rng: &mut Rng) -> Draft {
    let across = rng.random_range(6..11);
    let eye = unit(rng).abs() * power_of_ten(rng, 1.2, 4.0);
    let mut draft = draft(eye, DVec3::ZERO, f64::from(across) * rng.random_range(0.2..1.2));
    for k in 0..across * across * across {
        let [x, y, z] = [k % across, k / across % across, k / across / across].map(f64::from);
        draft.spheres.push((dvec3(x, y, z) * 2.0 - f64::from(across - 1), 1.0));
    }
    draft.spheres.push((DVec3::Y * (-1e6 - f64::from(across)), 1e6));
    draft
}

/// Many balls, a third of them about the eye, whose outlines lie close behind each other.
fn many_about_eye(rng: &mut Rng) -> Draft {
    let eye = way(rng) * 0.5;
    let mut draft = draft(eye, eye + way(rng), power_of_ten(rng, -2.0, 0.3));
    for k in 0..rng.random_range(130..400) {
        let (center, radius) = match k % 3 {
            0 => (eye + way(rng) * little(rng), 4.0 + little(rng)),
            1 => (within(rng, 3.0), power_of_ten(rng, -2.0, -0.5)),
            _ => (DVec3::ZERO, 1.0 + f64::from(k) * 0.02),
        };
        draft.spheres.push((center, radius));
    }
    draft
}

/// All things meet a ray at the same fraction `t`: tangent spheres, spheres that it meets head-on, planes, mirrored spheres
/// that it pierces aside of their middles, and spheres that it starts on; some a step of f64 off.
fn equal_roots(rng: &mut Rng) -> Draft {
    let ([u, v, w], length) = integer_frame(rng);
    let most = 1 << rng.random_range(1..31);
    let origin = integers(rng, most);
    let along = f64::from(rng.random_range(1..20));
    let point = origin + u * along;
    let mut draft = draft(origin, point, length * power_of_ten(rng, -6.0, 0.5));
    for _ in 0..rng.random_range(2..7) {
        let j = f64::from(rng.random_range(1..9)) * sign(rng);
        let sphere = match rng.random_range(0..6) {
            0 => (point + v * j, nudged(rng, j.abs() * length)),
            1 => (point + u * j.abs(), nudged(rng, j.abs() * length)),
            2 => {
                let radius = (j.abs() + 1.0) * length;
                draft.spheres.push((point - w * j + u * 20.0, radius));
                (point + v * j + u * 20.0, radius)
            }
            3 => (origin + u * j, nudged(rng, j.abs() * length)),
            _ => {
                draft.planes.push((point + v * j, u + w * f64::from(rng.random_range(-3..4))));
                continue;
            }
        };
        draft.spheres.push(sphere);
    }
    for _ in 0..6 {
        let length = f64::from(rng.random_range(1..20));
        draft.rays.push([origin, [u, u, -u, v][rng.random_range(0..4)] * length]);
    }
    draft.exponent = Some(rng.random_range(-60..60));
    draft
}

/// A camera of parallel rays along an axis, whose pixels are whole numbers.
fn of_whole_pixels(rng: &mut Rng) -> Draft {
    let eye = integers(rng, 100);
    let mut draft = draft(eye, eye - DVec3::Z, HALF_OF_WHOLE);
    draft.lens = Some(Lens::Parallel);
    draft
}

/// Rays touch spheres exactly, and their roots are whole numbers, often equal: `3² + 4² = 5²`.
fn whole_pixels(rng: &mut Rng) -> Draft {
    let mut draft = of_whole_pixels(rng);
    let asides = [dvec3(3.0, 4.0, 0.0), dvec3(3.0, 0.0, 0.0), dvec3(0.0, 4.0, 0.0), DVec3::ZERO];
    for _ in 0..[3, 3, 3, 200][rng.random_range(0..4)] {
        let depth = f64::from(rng.random_range(-6..30));
        let times = f64::from(rng.random_range(1..3));
        let pixel =
            dvec3(f64::from(rng.random_range(-6..7)), f64::from(rng.random_range(-4..5)), 0.0);
        let aside = asides[rng.random_range(0..4)] * times;
        draft.spheres.push((draft.eye + pixel + aside - DVec3::Z * depth, 5.0 * times));
    }
    let at = draft.eye - DVec3::Z * f64::from(rng.random_range(0..9));
    draft.planes.push((at, integers(rng, 3)));
    draft
}

/// Tangents, contacts and lights on surfaces are common among small whole numbers.
fn whole_numbers(rng: &mut Rng) -> Draft {
    let mut draft = match rng.random() {
        true => of_whole_pixels(rng),
        false => draft(integers(rng, 9), integers(rng, 3), power_of_ten(rng, -1.0, 1.0)),
    };
    if draft.lens.is_some() {
        (draft.eye, draft.look_at) = (DVec3::Z * 9.0, DVec3::ZERO);
    }
    for _ in 0..rng.random_range(1..6) {
        draft.spheres.push((integers(rng, 6), f64::from(rng.random_range(1..6))));
    }
    for _ in 0..rng.random_range(0..3) {
        draft.planes.push((integers(rng, 6), integers(rng, 2) + DVec3::Y * 5.0));
    }
    for _ in 0..2 {
        let at = integers(rng, 8);
        draft.lights.push(if rng.random() { Light::Point(at) } else { Light::Sun(at) });
    }
    for _ in 0..24 {
        draft.rays.push([integers(rng, 9), integers(rng, 5)]);
    }
    draft
}

/// Where parallel rays start, spheres and planes begin, touch it and end.
fn plane_of_picture(rng: &mut Rng) -> Draft {
    let mut draft = of_whole_pixels(rng);
    let depth = f64::from(rng.random_range(-6..7));
    let middle = draft.eye - DVec3::Z * depth;
    draft.spheres = vec![(middle, 5.0), (middle + DVec3::X * 10.0, 5.0)];
    if rng.random() {
        draft.planes.push((draft.eye, DVec3::Z));
    }
    if rng.random() {
        draft.planes.push((draft.eye - DVec3::Z * 7.0, DVec3::Z));
    }
    if rng.random_bool(0.3) {
        let far = |k| (middle + dvec3(f64::from(k), 0.0, 100.0), 3.0);
        draft.spheres.extend((0..150).map(far));
    }
    draft
}

/// An angle so small that the product of two pixels' sizes leaves f64's range.
fn narrow(rng: &mut Rng) -> Draft {
    let mut draft = draft(DVec3::ZERO, -DVec3::Z, 1.0);
    draft.lens = Some(Lens::Perspective(Some(power_of_ten(rng, -250.0, -7.0))));
    draft.spheres = vec![(-DVec3::Z * 9.0, 2.0), (dvec3(10.0, 3.0, 0.0), 0.4)];
    for _ in 0..rng.random_range(0..3) {
        let radius = power_of_ten(rng, -1.0, 1.0);
        let near = radius * (1.0 + little(rng) * 2f64.powi(-40));
        draft.spheres.push((dvec3(near, 0.0, -rng.random_range(3.0..20.0)), radius));
    }
    draft
}

/// Things so near that rays whose directions are below the normal numbers of f64 see them.
fn ends_of_f64(rng: &mut Rng) -> Draft {
    let mut draft = mixture(rng);
    let subnormal =
        |rng: &mut Rng| unit(rng) * 2f64.powi(-1000) * 2f64.powi(-rng.random_range(22..73));
    if rng.random() {
        draft.planes = vec![(within(rng, 4.0), subnormal(rng)), (within(rng, 4.0), DVec3::Y)];
    }
    let exponent = rng.random_range(-1000..-880);
    for _ in 0..24 {
        let direction = subnormal(rng);
        // Where it is scaled it is 0, and then taken as it is.
        let is_some = direction != DVec3::ZERO;
        draft.rays.push([within(rng, 4.0), if is_some { direction } else { DVec3::Z * 5e-324 }]);
    }
    draft.exponent = Some(exponent);
    draft
}

/// The first of hundreds is seen, whatever their normals' lengths.
fn planes_in_one_place(rng: &mut Rng) -> Draft {
    let mut draft = draft(dvec3(3.0, 3.0, 8.0), DVec3::Y, 3.0);
    draft.spheres = vec![(DVec3::Y, 1.0)];
    for _ in 0..rng.random_range(20..300) {
        let across = dvec3(rng.random_range(-4.0..4.0), 0.0, rng.random_range(-4.0..4.0));
        draft.planes.push((across, DVec3::Y * rng.random_range(-9.0..9.0)));
    }
    draft
}

/// A white floor whose light is exactly the number between two bytes or two floats: three suns give a third of it each.
fn edges_of_bytes(rng: &mut Rng) -> Draft {
    let mut draft = of_whole_pixels(rng);
    (draft.eye, draft.look_at) = (dvec3(1.0, 3.0, 0.0), dvec3(1.0, 0.0, 0.0));
    draft.planes = vec![(DVec3::ZERO, DVec3::Y)];
    draft.lights = [dvec3(2.0, -1.0, 2.0), dvec3(-2.0, -1.0, 2.0), dvec3(2.0, -1.0, -2.0)]
        .map(Light::Sun)
        .to_vec();
    let edge = any_edge(rng);
    draft.white = Some(nudged(rng, edge));
    draft
}

/// Sizes that f32 does not have among ordinary ones, in a tree or not.
fn extremes(rng: &mut Rng) -> Draft {
    let eye = dvec3(0.3, 0.2, 1.0).normalize() * 4.0;
    let mut draft = draft(eye, DVec3::ZERO, 1.5);
    for _ in 0..[5, 300][rng.random_range(0..2)] {
        draft.spheres.push((within(rng, 1.0), power_of_ten(rng, -2.0, -0.5)));
    }
    for _ in 0..3 {
        draft.spheres.push(match rng.random_range(0..5) {
            0 => (-DVec3::Z * 1e30, 1e29),
            1 => (-DVec3::Y * 1e25, 1e25),
            2 => (within(rng, 1.0), 10f64.powi(-30)),
            3 => (within(rng, 1.0), 1e-200),
            _ => (DVec3::X * 1e200, 1.0),
        });
    }
    draft
}

/// Sizes at the ends of the range in which f32 may decide, a step beyond them and ordinary ones, wherever the camera is.
fn ends_of_f32(rng: &mut Rng) -> Draft {
    let size = |rng: &mut Rng| {
        let exponent = match rng.random_range(0..4) {
            0 => rng.random_range(-41..-37),
            1 => rng.random_range(57..62),
            _ => rng.random_range(-4..5),
        };
        nudged(rng, 2f64.powi(exponent)) * [1.0, rng.random_range(1.0..2.0)][rng.random_range(0..2)]
    };
    let eye = way(rng) * [0.0, 2f64.powi(rng.random_range(10..50))][rng.random_range(0..2)];
    let mut draft = draft(eye, eye, 0.0);
    draft.exponent = Some(0);
    for _ in 0..rng.random_range(1..5) {
        let radius = size(rng);
        let distance = match rng.random_range(0..4) {
            0 => radius * (1.0 + little(rng)),
            1 => radius * power_of_ten(rng, 0.0, 9.0),
            _ => size(rng),
        };
        draft.spheres.push((eye + way(rng) * distance, radius));
    }
    for _ in 0..rng.random_range(0..3) {
        let normal = way(rng) * size(rng);
        draft.planes.push((eye + across(rng, normal) * size(rng) + way(rng) * little(rng), normal));
    }
    let (center, radius) = draft.spheres[0];
    draft.look_at = center + way(rng) * radius;
    // Far from the origin a small sphere may be where the camera is.
    let distance = draft.look_at.distance(eye);
    draft.half = if distance > 0.0 { distance } else { radius } * power_of_ten(rng, -3.0, 0.3);
    draft
}

/// Lamps exactly on spheres and planes, or some steps of f64 or of f32 off, and points near their tangent planes.
fn lamps_on_surfaces(rng: &mut Rng) -> Draft {
    let mut draft = match rng.random_range(0..4) {
        0 => cloud(rng),
        _ => mixture(rng),
    };
    draft.planes.push((DVec3::Y * -4.0, DVec3::Y));
    let ([u, v, w], length) = integer_frame(rng);
    let size = 2f64.powi(rng.random_range(-12..-2));
    let lamp = integers(rng, 4);
    for _ in 0..rng.random_range(1..3) {
        let outward = [u, v, w][rng.random_range(0..3)] * sign(rng);
        match rng.random_range(0..3) {
            0 => draft.planes.push((lamp + v * size, outward)),
            _ => draft.spheres.push((lamp - outward * size, length * size)),
        }
        // What is lit along the tangent plane.
        let along = across(rng, outward) * power_of_ten(rng, -2.0, 0.5);
        let radius = power_of_ten(rng, -2.0, -0.5);
        draft.spheres.push((lamp + along + outward.normalize() * radius * little(rng), radius));
    }
    let off = match rng.random_range(0..3) {
        0 => 2f64.powi(-rng.random_range(20..54)),
        _ => 0.0,
    };
    draft.lights = vec![Light::Point(lamp + lamp * within(rng, 1.0) * off)];
    if rng.random_bool(0.3) {
        draft.lights.push(Light::Point(integers(rng, 4)));
    }
    draft
}

/// An ordinary scene with one object, lamp, eye or ray that is not.
fn outliers(rng: &mut Rng) -> Draft {
    let mut draft = [mixture, cloud, heap, crowd][rng.random_range(0..4)](rng);
    draft.lens = Some(match rng.random_bool(0.3) {
        true => Lens::Parallel,
        false => Lens::Perspective(None),
    });
    draft.exponent = Some(match rng.random_bool(0.3) {
        true => rng.random_range(-120..120),
        false => 0,
    });
    let far = |rng: &mut Rng| way(rng) * power_of_ten(rng, 1.0, 36.0);
    match rng.random_range(0..6) {
        0 => {
            let center = far(rng);
            draft.spheres.push((center, center.length() * power_of_ten(rng, -9.0, -0.1)));
        }
        1 => {
            let radius = power_of_ten(rng, 1.0, 36.0);
            draft.spheres.push((way(rng) * (radius + 5.0), radius));
        }
        2 => draft.spheres.push((within(rng, 1.0), power_of_ten(rng, -40.0, -9.0))),
        3 => draft.lights = vec![Light::Point(far(rng))],
        4 => {
            let (center, radius) = draft.spheres[rng.random_range(0..draft.spheres.len())];
            let outward = [DVec3::X, DVec3::Y, DVec3::Z][rng.random_range(0..3)] * sign(rng);
            draft.eye = center + outward * radius;
            draft.look_at = draft.eye + outward + within(rng, 1.0);
        }
        _ => {
            for _ in 0..rng.random_range(1..4) {
                let origin = far(rng);
                draft.rays.push([origin, within(rng, 1.0) - origin]);
            }
        }
    }
    draft
}

/// Sets the camera, a ball or a wall of a third of the scenes far apart from the rest. Up to `10³⁸` they are seen.
fn set_apart(rng: &mut Rng, draft: &mut Draft, lens: Lens) {
    let away = match rng.random_range(0..5) {
        0 | 1 => power_of_ten(rng, 0.0, 12.0),
        2 | 3 => power_of_ten(rng, 12.0, 38.0),
        _ => power_of_ten(rng, 38.0, 140.0),
    };
    let aside = way(rng) * away;
    match rng.random_range(0..12) {
        // Perspective would show a point.
        0 | 1 if lens == Lens::Parallel => {
            draft.eye = draft.look_at + (draft.eye - draft.look_at) * away;
        }
        2 => draft.spheres.push((aside, away * rng.random_range(0.1..1.5))),
        3 => draft.planes.push((aside, way(rng))),
        _ => {}
    }
}

// ---------------------------------------------------------------------------------------------
// Its place and its rays

/// Coordinates up to this, some of them added up, are finite.
const LARGEST: f64 = 1e300;

/// Where a draft lies: `(v + by)·scale`.
#[derive(Clone, Copy)]
struct Place {
    by: DVec3,
    scale: f64,
}

impl Place {
    fn point(self, v: DVec3) -> DVec3 {
        (v + self.by) * self.scale
    }

    fn ray(self, [origin, direction]: [DVec3; 2]) -> [DVec3; 2] {
        let scaled = direction * self.scale;
        let fits = scaled.is_finite() && scaled != DVec3::ZERO;
        [self.point(origin), if fits { scaled } else { direction }]
    }
}

/// Where all numbers of a draft of this extent stay finite.
fn place(rng: &mut Rng, extent: f64) -> Place {
    let by = match rng.random_range(0..6) {
        0..3 => DVec3::ZERO,
        // Short numbers stay short.
        3 => within(rng, 1e6).round(),
        4 => within(rng, 1.0) * power_of_ten(rng, 0.0, 4.0),
        _ => within(rng, 1.0) * power_of_ten(rng, 4.0, 12.0),
    };
    let scale = match rng.random_range(0..16) {
        0..5 => 1.0,
        5..8 => 2f64.powi(rng.random_range(-30..30)),
        8..11 => power_of_ten(rng, -6.0, 6.0),
        11..13 => power_of_ten(rng, -36.0, 36.0),
        13..15 => power_of_ten(rng, -150.0, 150.0),
        _ => {
            let exponent = rng.random_range(100.0..290.0);
            10f64.powf(exponent * sign(rng))
        }
    };
    Place { by, scale: if extent < LARGEST / scale { scale } else { 1.0 } }
}

fn rays(rng: &mut Rng, draft: &Draft) -> Vec<[DVec3; 2]> {
    let is_bundle = rng.random_bool(0.3);
    let drawn: Vec<_> = (0..48)
        .map(|_| {
            let (center, radius) = match draft.spheres.len() {
                0 => (draft.look_at, draft.half),
                n => draft.spheres[rng.random_range(0..n)],
            };
            if rng.random_bool(0.1) {
                // Touches the sphere where its box does.
                let (axis, along) = (rng.random_range(0..3), rng.random_range(1..3));
                let side = DVec3::AXES[axis] * sign(rng) * (radius * (1.0 + little(rng)));
                let along = DVec3::AXES[(axis + along) % 3] * sign(rng);
                return [center + side - along * (4.0 * radius), along];
            }
            let on = center + way(rng) * radius;
            let origin = match rng.random_range(0..5) {
                _ if is_bundle => draft.eye,
                0 => on,
                1 => on + (on - center) * little(rng),
                2 => center + unit(rng) * (radius * rng.random_range(0.0..1.0)),
                3 => center + unit(rng) * (radius * power_of_ten(rng, 0.0, 5.0)),
                _ => draft.eye,
            };
            let toward = center - origin;
            let distance = toward.length();
            let sine = ((1.0 + little(rng)) * radius / distance).min(1.0);
            let target = match rng.random_range(0..5) {
                0 => toward,
                1 => draft.look_at - origin,
                2 => unit(rng) * draft.half,
                3 => integers(rng, 3),
                // Past the outline.
                _ => toward * (1.0 - sine * sine).sqrt() + across(rng, toward) * (distance * sine),
            };
            let length = match rng.random_range(0..4) {
                0 | 1 => 1.0,
                2 => power_of_ten(rng, -8.0, 8.0),
                // `t` leaves f32's range.
                _ => power_of_ten(rng, -46.0, 46.0),
            };
            let direction = target * length;
            let fits = direction.is_finite() && direction != DVec3::ZERO;
            [origin, if fits { direction } else { DVec3::X }]
        })
        .collect();
    [drawn, draft.rays.clone()].concat()
}

// ---------------------------------------------------------------------------------------------
// The file

fn numbers(v: DVec3) -> String {
    // Debug prints the shortest text that reads back as the same f64.
    let [x, y, z] = v.to_array();
    format!("[{x:?}, {y:?}, {z:?}]")
}

fn color(rng: &mut Rng) -> String {
    match rng.random_range(0..3) {
        0 => format!("\"#{:06x}\"", rng.random_range(0..1 << 24)),
        1 => "[1.0, 1.0, 1.0]".to_string(),
        _ => numbers(within(rng, 1.0).abs()),
    }
}

fn text(rng: &mut Rng, draft: &Draft, place: Place, lens: Lens, gain: f64) -> String {
    let is_white = draft.white.is_some();
    let color = |rng: &mut Rng| match is_white {
        true => "[1.0, 1.0, 1.0]".to_string(),
        false => color(rng),
    };
    let mut text = format!("background = {}\n", color(rng));
    let depth = (draft.look_at - draft.eye).length();
    let (position, mut look_at) = (place.point(draft.eye), place.point(draft.look_at));
    if look_at == position {
        look_at = position + DVec3::X * (position.abs().max_element() + place.scale);
    }
    let ahead = (look_at / place.scale - position / place.scale).normalize_or(DVec3::X);
    let shape = match lens {
        Lens::Parallel => format!("height = {:?}", 2.0 * draft.half * place.scale),
        Lens::Perspective(Some(degrees)) => format!("fov = {degrees:?}"),
        Lens::Perspective(None) => {
            let degrees = 2.0 * (draft.half / depth.max(1e-9)).atan().to_degrees();
            format!("fov = {:?}", degrees.clamp(1e-7, 170.0))
        }
    };
    let [position, look_at, up] = [position, look_at, up_of(ahead)].map(numbers);
    let lights = lights(rng, draft, place, lens, gain);
    // Tables come last.
    let _ = write!(text, "{}", lights.0);
    let _ = writeln!(
        text,
        "\n[camera]\nposition = {position}\nlook_at = {look_at}\nup = {up}\n{shape}"
    );
    let _ = write!(text, "{}", lights.1);
    for (center, radius) in &draft.spheres {
        let center = numbers(place.point(*center));
        // The least that is a radius, where it would be none.
        let radius = (radius * place.scale).max(f64::from_bits(1));
        let color = color(rng);
        let _ =
            writeln!(text, "\n[[sphere]]\ncenter = {center}\nradius = {radius:?}\ncolor = {color}");
    }
    for (point, normal) in &draft.planes {
        let (point, normal) = (numbers(place.point(*point)), numbers(*normal));
        let color = color(rng);
        let _ = writeln!(text, "\n[[plane]]\npoint = {point}\nnormal = {normal}\ncolor = {color}");
    }
    text
}

/// An upward vector that is not along this one.
fn up_of(ahead: DVec3) -> DVec3 {
    if ahead.y.abs() > 0.95 { DVec3::X } else { DVec3::Y }
}

/// What stands before the tables, and the tables; all of it `gain` times as bright.
fn lights(rng: &mut Rng, draft: &Draft, place: Place, lens: Lens, gain: f64) -> (String, String) {
    let (mut values, mut tables) = (String::new(), String::new());
    let said = |light: &Light| match *light {
        Light::Point(at) => format!("position = {}", numbers(place.point(at))),
        Light::Sun(direction) => format!("direction = {}", numbers(direction)),
    };
    for light in &draft.lights {
        let intensity = draft.white.unwrap_or(1.0) * gain;
        let _ = writeln!(tables, "\n[[light]]\n{}\nintensity = {intensity:?}", said(light));
    }
    if draft.white.is_some() || draft.lights.is_empty() && rng.random_bool(0.1) {
        return (values, tables);
    }
    // Other light hides what a scene is about.
    let is_alone = !draft.lights.is_empty() && rng.random_bool(0.6);
    match rng.random_range(0..4) {
        0 if !is_alone => {
            values =
                format!("ambient = {}\n", numbers((within(rng, 1.0).abs() * gain).min(DVec3::ONE)))
        }
        1 => values = format!("ambient = {:?}\n", (rng.random_range(0.0..0.3) * gain).min(1.0)),
        _ => {}
    }
    let n_lights = match (is_alone, rng.random_range(0..20)) {
        (true, _) => 0,
        // More than a shader keeps at hand.
        (false, 0) => 11,
        _ => rng.random_range(1..4),
    };
    for _ in 0..n_lights {
        let intensity = match rng.random_range(0..20) {
            0 => 0.0,
            1 => power_of_ten(rng, -30.0, 30.0),
            _ => power_of_ten(rng, -2.0, 0.5),
        };
        let (intensity, color, shadows) = (intensity * gain, color(rng), rng.random_bool(0.9));
        let source = match seen(rng, draft, lens) {
            Some(seen) if rng.random_bool(0.6) => aimed(rng, draft, &seen),
            _ => beside(rng, draft, place),
        };
        let is_finite = |light: &Light| match *light {
            Light::Point(at) => place.point(at).is_finite(),
            Light::Sun(direction) => direction.is_finite(),
        };
        let source = source.filter(is_finite);
        let source = source.map_or("position = \"eye\"".to_string(), |light| said(&light));
        let _ = writeln!(
            tables,
            "\n[[light]]\n{source}\ncolor = {color}\nintensity = {intensity:?}\nshadows = {shadows}"
        );
    }
    if !is_alone && rng.random_bool(0.2) {
        let intensity = rng.random_range(0.1..1.0) * gain;
        let directions = rng.random_range(1..7);
        let _ = writeln!(tables, "\n[sky]\nintensity = {intensity:?}\ndirections = {directions}");
    }
    (values, tables)
}

/// Any of the spheres, or where the picture is.
fn any_sphere(rng: &mut Rng, draft: &Draft) -> (DVec3, f64) {
    match draft.spheres.len() {
        0 => (draft.look_at, draft.half),
        n => draft.spheres[rng.random_range(0..n)],
    }
}

/// A light in, on, beside or behind things; none is the eye's.
fn beside(rng: &mut Rng, draft: &Draft, place: Place) -> Option<Light> {
    let (center, radius) = any_sphere(rng, draft);
    let outward = way(rng);
    Some(Light::Point(match rng.random_range(0..9) {
        0 => center,
        1 => center + outward * (radius * rng.random_range(0.0..1.0)),
        2 => center + outward * radius,
        3 => center + outward * (radius * (1.0 + little(rng))),
        4 => draft.look_at + outward * (draft.half * power_of_ten(rng, -3.0, 2.0)),
        5 => {
            let most = if rng.random() { 12.0 } else { 140.0 };
            let away = power_of_ten(rng, 2.0, most);
            draft.look_at + outward * away.min(LARGEST / place.scale)
        }
        6 => return None,
        _ => {
            let direction = match (rng.random_range(0..3), draft.planes.first()) {
                // Along a plane, or hardly climbing above it.
                (0, Some((_, n))) if n.truncate().length() > 1e-300 => {
                    let along = dvec3(n.y, -n.x, 0.0);
                    along + *n * (little(rng) * f64::from(rng.random_range(0..2)))
                }
                (1, _) => integers(rng, 3),
                _ => unit(rng),
            };
            let direction = if direction == DVec3::ZERO { DVec3::X } else { direction };
            return Some(Light::Sun(direction * power_of_ten(rng, -6.0, 6.0)));
        }
    }))
}

/// What a pixel shows, to f64.
struct Seen {
    point: DVec3,
    /// Against the ray.
    normal: DVec3,
    /// How far away it is.
    depth: f64,
}

/// What some pixel of a picture of the usual size shows.
fn seen(rng: &mut Rng, draft: &Draft, lens: Lens) -> Option<Seen> {
    let toward = draft.look_at - draft.eye;
    let ahead = toward.normalize_or(DVec3::X);
    let right = ahead.cross(up_of(ahead)).normalize();
    let mut offset = |n: u32| {
        let place = 2.0 * f64::from(rng.random_range(0..n)) + 1.0 - f64::from(n);
        place / f64::from(USUAL[1]) * draft.half
    };
    let aside = right * offset(USUAL[0]) + right.cross(ahead) * offset(USUAL[1]);
    let (origin, direction) = match lens {
        Lens::Parallel => (draft.eye + aside, ahead),
        Lens::Perspective(_) => (draft.eye, (toward + aside).normalize_or(ahead)),
    };
    let spheres = draft.spheres.iter().filter_map(|&(center, radius)| {
        let l = center - origin;
        let along = l.dot(direction);
        let half = (radius * radius - (l - direction * along).length_squared()).sqrt();
        let t = if along > half { along - half } else { along + half };
        Some((t, (direction * t - l) / radius)).filter(|(t, _)| *t > 0.0)
    });
    let planes = draft.planes.iter().filter_map(|&(point, normal)| {
        let t = (point - origin).dot(normal) / direction.dot(normal);
        Some((t, normal.normalize_or(DVec3::X))).filter(|(t, _)| *t > 0.0)
    });
    let (depth, normal) = spheres.chain(planes).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
    let point = origin + direction * depth;
    (point.is_finite() && normal.is_finite()).then_some(Seen { point, normal, depth })
}

/// A light where what it gives this point, or whether it is in the way, is hard to tell; none is the eye's.
fn aimed(rng: &mut Rng, draft: &Draft, seen: &Seen) -> Option<Light> {
    let &Seen { point, normal, depth } = seen;
    let (center, radius) = any_sphere(rng, draft);
    let at = match rng.random_range(0..8) {
        // Past the outline of a sphere, before and behind it.
        0..3 => {
            let toward = center - point;
            let distance = toward.length();
            let sine = ((1.0 + little(rng)) * radius / distance).min(1.0);
            let along = toward / distance * (1.0 - sine * sine).sqrt() + across(rng, toward) * sine;
            let to_outline = (distance * distance - radius * radius).max(0.0).sqrt();
            point
                + along
                    * match rng.random_range(0..3) {
                        0 => to_outline * (1.0 + little(rng)),
                        1 => distance * rng.random_range(0.1..3.0),
                        _ => distance * power_of_ten(rng, 0.0, 6.0),
                    }
        }
        // Along the surface.
        3 => {
            let along = across(rng, normal) + normal * little(rng);
            point + along * (depth * power_of_ten(rng, -2.0, 3.0))
        }
        // At the point, or next to it.
        4 => dvec3(nudged(rng, point.x), nudged(rng, point.y), nudged(rng, point.z)),
        5 => {
            let near = depth * power_of_ten(rng, -12.0, 0.0);
            point + (normal * sign(rng) + unit(rng) * f64::from(rng.random_range(0..2))) * near
        }
        6 => point + (normal + unit(rng) * 0.9) * (depth * power_of_ten(rng, -1.0, 6.0)),
        _ => return None,
    };
    let is_sun = rng.random_bool(0.4) && at != point;
    Some(if is_sun { Light::Sun(point - at) } else { Light::Point(at) })
}
