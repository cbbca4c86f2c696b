//! Scenes where it is hard, as scene files, and rays through them. A family is a function that fills a
//! [`Draft`] at sizes around 1; where it lies, how large it is, its lights and its camera's kind are drawn
//! for all families alike. To add a case, add a function to [`FAMILIES`].

use std::fmt::Write as _;

use glam::{DVec3, dvec3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

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
    /// A light that it is all about, and no perspective camera.
    light: Option<Light>,
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

/// A light at a point, or a sun that shines along a vector.
enum Light {
    Point(DVec3),
    Sun(DVec3),
}

pub type Family = fn(&mut Rng) -> Draft;
type Rng = ChaCha8Rng;

pub const FAMILIES: [(&str, Family); 23] = [
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
    let is_orthographic = draft.light.is_some() || rng.random_bool(0.4);
    if draft.light.is_none() {
        set_apart(rng, &mut draft, is_orthographic);
    }
    let place = place(rng, draft.extent());
    let rays = rays(rng, &draft).into_iter().map(|ray| place.ray(ray)).collect();
    let text = text(rng, &draft, place, is_orthographic);
    Hard { family, text, rays }
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

// ---------------------------------------------------------------------------------------------
// Families

fn draft(eye: DVec3, look_at: DVec3, half: f64) -> Draft {
    let (spheres, planes) = (Vec::new(), Vec::new());
    Draft { eye, look_at, half, spheres, planes, light: None }
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

/// 3² + 4² = 5²: the points of contact are numbers of f64.
fn touching(rng: &mut Rng) -> Draft {
    let mut draft = draft(integers(rng, 12), dvec3(3.0, 4.0, 0.0), power_of_ten(rng, -6.0, 0.8));
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
    let mut draft = draft(way(rng) * 3.0, DVec3::ZERO, size * power_of_ten(rng, 0.0, 1.5));
    for _ in 0..rng.random_range(1..8) {
        draft.spheres.push((within(rng, size * 4.0), size * rng.random_range(0.1..3.0)));
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
    let mut draft = draft(eye, eye - DVec3::Y, 4.0);
    draft.spheres = vec![(dvec3(0.0, height, 0.0), radius)];
    draft.planes = vec![(DVec3::ZERO, DVec3::Y * f64::from(rng.random_range(1..4)))];
    draft.light = Some(match is_point {
        true => Light::Point(DVec3::Y * 10.0),
        false => Light::Sun(-DVec3::Y),
    });
    draft
}

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
    draft.light = Some(Light::Sun(match is_floor {
        true => dvec3(-1.0, rng.random_range(-2.0..-0.5), rng.random_range(-1.0..1.0)),
        false => -DVec3::X,
    }));
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
    draft.light = Some(Light::Sun(dvec3(-1.0, 0.0, -1.0)));
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
    draft.light = Some(Light::Sun(-DVec3::Z));
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

/// Sets the camera, a ball or a wall of a third of the scenes far apart from the rest. Up to `10³⁸` they are seen.
fn set_apart(rng: &mut Rng, draft: &mut Draft, is_orthographic: bool) {
    let away = match rng.random_range(0..5) {
        0 | 1 => power_of_ten(rng, 0.0, 12.0),
        2 | 3 => power_of_ten(rng, 12.0, 38.0),
        _ => power_of_ten(rng, 38.0, 140.0),
    };
    let aside = way(rng) * away;
    match rng.random_range(0..12) {
        // Perspective would show a point.
        0 | 1 if is_orthographic => {
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
    (0..48)
        .map(|_| {
            let (center, radius) = match draft.spheres.len() {
                0 => (draft.look_at, draft.half),
                n => draft.spheres[rng.random_range(0..n)],
            };
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
        .collect()
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

fn text(rng: &mut Rng, draft: &Draft, place: Place, is_orthographic: bool) -> String {
    let mut text = format!("background = {}\n", color(rng));
    let depth = (draft.look_at - draft.eye).length();
    let (position, mut look_at) = (place.point(draft.eye), place.point(draft.look_at));
    if look_at == position {
        look_at = position + DVec3::X * (position.abs().max_element() + place.scale);
    }
    let ahead = (look_at / place.scale - position / place.scale).normalize_or(DVec3::X);
    let up = match ahead.y.abs() > 0.95 {
        true => DVec3::X,
        false => DVec3::Y,
    };
    let shape = match is_orthographic {
        true => format!("height = {:?}", 2.0 * draft.half * place.scale),
        false => {
            let degrees = 2.0 * (draft.half / depth.max(1e-9)).atan().to_degrees();
            format!("fov = {:?}", degrees.clamp(1e-7, 170.0))
        }
    };
    let [position, look_at, up] = [position, look_at, up].map(numbers);
    let lights = lights(rng, draft, place);
    // Tables come last.
    let _ = write!(text, "{}", lights.0);
    let _ = writeln!(
        text,
        "\n[camera]\nposition = {position}\nlook_at = {look_at}\nup = {up}\n{shape}"
    );
    let _ = write!(text, "{}", lights.1);
    for (center, radius) in &draft.spheres {
        let (center, radius) = (numbers(place.point(*center)), radius * place.scale);
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

/// What stands before the tables, and the tables.
fn lights(rng: &mut Rng, draft: &Draft, place: Place) -> (String, String) {
    let (mut values, mut tables) = (String::new(), String::new());
    let given = match draft.light {
        None if rng.random_bool(0.1) => return (values, tables),
        None => None,
        Some(Light::Point(at)) => Some(format!("position = {}", numbers(place.point(at)))),
        Some(Light::Sun(direction)) => Some(format!("direction = {}", numbers(direction))),
    };
    if let Some(source) = given {
        let _ = writeln!(tables, "\n[[light]]\n{source}");
    }
    // Other light hides what a scene is about.
    let is_alone = draft.light.is_some() && rng.random_bool(0.6);
    match rng.random_range(0..4) {
        0 if !is_alone => values = format!("ambient = {}\n", color(rng)),
        1 => values = format!("ambient = {:?}\n", rng.random_range(0.0..0.3)),
        _ => {}
    }
    for _ in 0..if is_alone { 0 } else { rng.random_range(1..4) } {
        let (intensity, color) = (power_of_ten(rng, -2.0, 0.5), color(rng));
        let shadows = rng.random_bool(0.9);
        let _ = writeln!(
            tables,
            "\n[[light]]\n{}\ncolor = {color}\nintensity = {intensity:?}\nshadows = {shadows}",
            source(rng, draft, place)
        );
    }
    if !is_alone && rng.random_bool(0.2) {
        let (intensity, directions) = (rng.random_range(0.1..1.0), rng.random_range(1..7));
        let _ = writeln!(tables, "\n[sky]\nintensity = {intensity:?}\ndirections = {directions}");
    }
    (values, tables)
}

/// A light in, on, beside or behind things.
fn source(rng: &mut Rng, draft: &Draft, place: Place) -> String {
    let (center, radius) = match draft.spheres.len() {
        0 => (draft.look_at, draft.half),
        n => draft.spheres[rng.random_range(0..n)],
    };
    let outward = way(rng);
    let at = match rng.random_range(0..9) {
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
        6 => return "position = \"eye\"".to_string(),
        _ => {
            let direction = match (rng.random_range(0..3), draft.planes.first()) {
                // Along a plane.
                (0, Some((_, n))) if n.truncate().length() > 0.0 => dvec3(n.y, -n.x, 0.0),
                (1, _) => integers(rng, 3),
                _ => draft.look_at - (draft.look_at + unit(rng)),
            };
            let direction = if direction == DVec3::ZERO { DVec3::X } else { direction };
            return format!("direction = {}", numbers(direction * power_of_ten(rng, -6.0, 6.0)));
        }
    };
    format!("position = {}", numbers(place.point(at)))
}
