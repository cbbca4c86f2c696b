//! Ordinary scenes, and outliers in them.
//!
//! All scenes lie on or above y = 0, so that a ground of any size touches this plane without rounding.

use std::f64::consts::TAU;

use glam::DVec3;
use kugelblitz::prepare::power_of_two;
use kugelblitz::query::{Rays, WorldRay};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Camera, Color, Light, Projection, Samples, Scene, Source, Sphere};
use kugelblitz_tests::{camera, in_cube, plane, scene, sphere};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

pub type Rng = ChaCha8Rng;

/// A scene and its rays.
#[derive(Clone)]
pub struct Workload {
    /// Has a camera unless the rays are a list.
    pub scene: Scene,
    pub list: Vec<WorldRay>,
    pub n_samples: Samples,
}

/// An ordinary scene, and the same scene with an outlier.
pub type Pair = [Workload; 2];

/// Name of a family of outliers, and a function that draws a pair.
pub type OutlierKind = (&'static str, fn(&mut Rng) -> Pair);

/// All kinds. Pair `n` is of kind `n` modulo their number.
pub const KINDS: [OutlierKind; 29] = [
    ("far sphere out of view", |rng| sphere_out_of_view(rng, [1.0, LARGE])),
    ("farther sphere out of view", |rng| sphere_out_of_view(rng, [LARGE, 30.0])),
    ("stray sphere out of view", |rng| sphere_out_of_view(rng, [20.0, 300.0])),
    ("far sphere in view", |rng| sphere_in_view(rng, [0.0, LARGE])),
    ("farther sphere in view", |rng| sphere_in_view(rng, [LARGE, 30.0])),
    ("huge sphere as ground", |rng| sphere_as_ground(rng, [2.0, LARGE])),
    ("larger sphere as ground", |rng| sphere_as_ground(rng, [LARGE, 30.0])),
    ("tiny sphere", tiny_sphere),
    ("sphere around everything", |rng| sphere_around(rng, LARGE - 2.0)),
    ("larger sphere around everything", |rng| sphere_around(rng, 30.0)),
    ("far plane out of view", |rng| plane_out_of_view(rng, [1.0, LARGE])),
    ("farther plane out of view", |rng| plane_out_of_view(rng, [LARGE, 30.0])),
    ("far plane in view", |rng| plane_in_view(rng, [2.0, LARGE])),
    ("farther plane in view", |rng| plane_in_view(rng, [LARGE, 30.0])),
    ("far ray, aimed at the scene", |rng| far_ray(rng, true)),
    ("far ray, aimed anywhere", |rng| far_ray(rng, false)),
    ("very long or short direction", direction_of_any_length),
    ("lamp on the floor", lamp_on_floor),
    ("lamp on the ceiling", lamp_on_ceiling),
    ("lamp on a sphere", lamp_on_sphere),
    ("lamp at a sphere's center", lamp_at_center),
    ("lamp at the camera", lamp_at_camera),
    ("far lamp", |rng| far_lamp(rng, [2.0, 14.0])),
    ("farther lamp", |rng| far_lamp(rng, [14.0, 30.0])),
    ("camera on a sphere", camera_on_sphere),
    ("camera in a plane", camera_in_plane),
    ("scaled by 2^-50..2^50", |rng| scaled_by(rng, |rng| 2f64.powi(rng.random_range(-50..=50)))),
    ("scaled by 2^-300..2^300", |rng| {
        scaled_by(rng, |rng| 2f64.powi(rng.random_range(-300..=300)))
    }),
    ("scaled by 10^-15..10^20", |rng| scaled_by(rng, |rng| power_of_ten(rng, -15.0, 20.0))),
];

/// Exponent of 10 up to which a distance or size costs nothing, in scenes of a size about 1. `EXCEPTIONS` has the costs beyond.
const LARGE: f64 = 8.0;

pub fn kind(number: u64) -> &'static OutlierKind {
    &KINDS[(number % KINDS.len() as u64) as usize]
}

pub fn pair(number: u64) -> Pair {
    kind(number).1(&mut Rng::seed_from_u64(number))
}

/// Center of the scenes.
const CENTER: DVec3 = DVec3::new(0.0, 1.25, 0.0);

impl Workload {
    fn picture(scene: Scene, camera: Camera, rng: &mut Rng) -> Workload {
        let n_samples = Samples::nearest(if rng.random_range(0..4) == 0 { 2 } else { 1 });
        Workload { scene: Scene { camera: Some(camera), ..scene }, list: vec![], n_samples }
    }

    pub fn rays(&self) -> Rays {
        match &self.scene.camera {
            Some(camera) => Rays::Pixels(Pixels::whole(View::new(camera), 40, 24)),
            None => Rays::List(self.list.clone()),
        }
    }

    /// Returns a random ray of the picture or list.
    fn ray(&self, rng: &mut Rng) -> WorldRay {
        match self.rays() {
            Rays::Pixels(pixels) => pixels.ray(rng.random_range(0..40), rng.random_range(0..24)),
            Rays::List(list) => list[rng.random_range(0..list.len())],
        }
    }

    fn camera(&mut self) -> &mut Camera {
        self.scene.camera.as_mut().expect("a picture")
    }

    /// Returns the parts of the scene that may be the outlier.
    pub fn outlier(self) -> String {
        let Scene { camera, lights, spheres, planes, .. } = self.scene;
        let (sphere, ray) = (spheres.last(), self.list.last());
        format!("{camera:?}\n{lights:?}\n{planes:?}\n{sphere:?}\n{ray:?}\n")
    }

    /// Returns point and unit direction of the view; for lists, the center and a random direction.
    fn view(&self, rng: &mut Rng) -> (DVec3, DVec3) {
        match &self.scene.camera {
            Some(camera) => (camera.position, (camera.look_at - camera.position).normalize()),
            None => (CENTER, in_cube(rng).normalize()),
        }
    }

    fn with_sphere(&self, center: DVec3, radius: f64) -> Workload {
        let mut case = self.clone();
        case.scene.spheres.push(sphere(center, radius), Color([0.7; 3]));
        case
    }

    pub fn with_plane(&self, point: DVec3, normal: DVec3) -> Workload {
        let mut case = self.clone();
        case.scene.planes.push(plane(point, normal));
        case
    }

    fn with_lamp(&self, source: Source) -> Workload {
        let mut case = self.clone();
        case.scene.lights = vec![light(source)];
        case
    }
}

fn light(source: Source) -> Light {
    Light { source, color: Color([1.0; 3]), intensity: 0.8, shadows: true }
}

/// Returns a number of 20 bits after the point, so that small sums of such numbers are exact.
fn short(number: f64) -> f64 {
    (number * power_of_two(20)).round() * power_of_two(-20)
}

fn power_of_ten(rng: &mut Rng, low: f64, high: f64) -> f64 {
    10f64.powf(rng.random_range(low..high))
}

fn cloud(rng: &mut Rng, n: usize, [low, high]: [f64; 2]) -> Scene {
    let ball = |_| sphere(CENTER + in_cube(rng).map(short), short(rng.random_range(low..high)));
    scene((0..n).map(ball).collect(), vec![])
}

/// Lights a scene by a lamp above it or, if nothing covers it, by a sun.
fn lit(scene: Scene, can_have_sun: bool, rng: &mut Rng) -> Scene {
    let [x, y, z] = in_cube(rng).to_array();
    let source = match can_have_sun && rng.random() {
        true => Source::Sun(DVec3::new(x, -1.5, z)),
        false => Source::Point(DVec3::new(2.0 * x, 2.5 + 0.4 * y, 2.0 * z).map(short)),
    };
    Scene { lights: vec![light(source)], ambient: Some(Color([0.1; 3])), ..scene }
}

/// A cloud that is found through the tree, seen from outside.
fn cloud_picture(rng: &mut Rng) -> Workload {
    let n = rng.random_range(200..3000);
    let mut scene = cloud(rng, n, [0.01, 0.05]);
    if rng.random() {
        scene = lit(scene, true, rng);
    }
    let (cos, sin) = rng.random_range(0.0..TAU).sin_cos();
    let position = DVec3::new(4.0 * cos, rng.random_range(0.5..2.5), 4.0 * sin).map(short);
    let mut camera = camera(position, CENTER);
    if rng.random_range(0..3) == 0 {
        camera.projection = Projection::Orthographic { height: 2.4 };
    }
    Workload::picture(scene, camera, rng)
}

/// A few spheres on a floor, perhaps with a ceiling or a wall.
pub fn room(rng: &mut Rng) -> Workload {
    let n = rng.random_range(1..7);
    let ball = |_| {
        let radius = short(rng.random_range(0.2..1.0));
        let [x, _, z] = (in_cube(rng) * 2.0).map(short).to_array();
        sphere(DVec3::new(x, radius, z), radius)
    };
    let spheres = (0..n).map(ball).collect();
    let mut planes = vec![plane(DVec3::ZERO, DVec3::Y)];
    let cover = rng.random_range(0..3);
    match cover {
        0 => planes.push(plane(DVec3::Y * 3.0, DVec3::Y)),
        1 => planes.push(plane(DVec3::Z * -3.0, DVec3::Z)),
        _ => {}
    }
    let scene = lit(scene(spheres, planes), cover != 0, rng);
    let position = DVec3::new(rng.random_range(-1.0..1.0), 1.6, 4.0).map(short);
    Workload::picture(scene, camera(position, DVec3::Y * 0.5), rng)
}

/// Rays from a cube about many or few spheres.
fn list(rng: &mut Rng) -> Workload {
    let scene = match rng.random() {
        true => cloud_picture(rng).scene,
        false => {
            let n = rng.random_range(5..100);
            cloud(rng, n, [0.05, 0.3])
        }
    };
    let half_side = rng.random_range(2.0..20.0);
    let ray = |_| {
        let origin = CENTER + in_cube(rng) * half_side;
        WorldRay { origin, direction: CENTER + in_cube(rng) - origin }
    };
    let list = (0..600).map(ray).collect();
    let scene = Scene { camera: None, lights: vec![], ambient: None, ..scene };
    Workload { scene, list, n_samples: Samples::ONE }
}

fn picture(rng: &mut Rng) -> Workload {
    if rng.random() { cloud_picture(rng) } else { room(rng) }
}

fn ordinary(rng: &mut Rng) -> Workload {
    if rng.random_range(0..3) == 0 { list(rng) } else { picture(rng) }
}

/// A lit picture with a floor as its first plane.
fn lit_picture(rng: &mut Rng) -> Workload {
    let mut case = picture(rng);
    if case.scene.planes.is_empty() {
        case = case.with_plane(DVec3::ZERO, DVec3::Y);
        case.scene = lit(case.scene, true, rng);
    }
    case
}

// Spheres and planes

fn sphere_out_of_view(rng: &mut Rng, [least, most]: [f64; 2]) -> Pair {
    let case = ordinary(rng);
    let (point, ahead) = case.view(rng);
    let across = ahead.cross(in_cube(rng)).normalize();
    let distance = power_of_ten(rng, least, most);
    let center = point + if rng.random() { across } else { -ahead } * distance;
    let with = case.with_sphere(center, distance * power_of_ten(rng, -4.0, -1.0));
    [case, with]
}

fn sphere_in_view(rng: &mut Rng, [least, most]: [f64; 2]) -> Pair {
    let (case, distance) = (ordinary(rng), power_of_ten(rng, least, most));
    let WorldRay { origin, direction } = case.ray(rng);
    let size = power_of_ten(rng, -6.0, -2.0);
    let camera = case.scene.camera.as_ref();
    let is_parallel =
        camera.is_some_and(|camera| matches!(camera.projection, Projection::Orthographic { .. }));
    let radius = if is_parallel { size } else { size * distance };
    let with = case.with_sphere(origin + direction.normalize() * distance, radius);
    [case, with]
}

/// The ordinary scene has a plane as ground.
fn sphere_as_ground(rng: &mut Rng, [least, most]: [f64; 2]) -> Pair {
    let mut case = ordinary(rng);
    let radius = power_of_ten(rng, least, most);
    if case.scene.planes.is_empty() {
        case = case.with_plane(DVec3::ZERO, DVec3::Y);
    }
    let mut with = case.with_sphere(DVec3::Y * -radius, radius);
    with.scene.planes.remove(0);
    [case, with]
}

fn tiny_sphere(rng: &mut Rng) -> Pair {
    let case = ordinary(rng);
    let with = case.with_sphere(CENTER + in_cube(rng), power_of_ten(rng, -40.0, -1.0));
    [case, with]
}

/// The ordinary scene is within a sphere that is just large enough.
fn sphere_around(rng: &mut Rng, most: f64) -> Pair {
    let case = ordinary(rng);
    let least = if case.list.is_empty() { 1.0 } else { 2.0 };
    let radii = [10f64.powf(least), power_of_ten(rng, least, most)];
    radii.map(|radius| case.with_sphere(CENTER, radius))
}

fn plane_out_of_view(rng: &mut Rng, [least, most]: [f64; 2]) -> Pair {
    let (case, distance) = (picture(rng), power_of_ten(rng, least, most));
    let (position, ahead) = case.view(rng);
    let with = match case.scene.planes.is_empty() {
        true => case.with_plane(position - ahead * distance, ahead),
        // Under the floor, so that it does not occlude a sun.
        false => case.with_plane(DVec3::Y * -distance, DVec3::Y),
    };
    [case, with]
}

/// The ordinary scene has its background on a plane that is just far enough.
fn plane_in_view(rng: &mut Rng, [least, most]: [f64; 2]) -> Pair {
    let case = ordinary(rng);
    let (point, ahead) = case.view(rng);
    let distances = [100.0, power_of_ten(rng, least, most)];
    distances.map(|distance| case.with_plane(point + ahead * distance, ahead))
}

// Rays of lists

fn with_ray(case: Workload, origin: DVec3, direction: DVec3) -> Pair {
    let mut with = case.clone();
    with.list.push(WorldRay { origin, direction });
    [case, with]
}

fn far_ray(rng: &mut Rng, is_aimed: bool) -> Pair {
    let origin = CENTER + in_cube(rng).normalize() * power_of_ten(rng, 0.0, 40.0);
    let direction = if is_aimed { CENTER + in_cube(rng) - origin } else { in_cube(rng) };
    let length = power_of_ten(rng, -30.0, 30.0);
    with_ray(list(rng), origin, direction.normalize() * length)
}

fn direction_of_any_length(rng: &mut Rng) -> Pair {
    let case = list(rng);
    let WorldRay { origin, .. } = case.ray(rng);
    let direction = (CENTER + in_cube(rng) - origin) * power_of_ten(rng, -30.0, 30.0);
    with_ray(case, origin, direction)
}

// Lamps and cameras. The ordinary scene has them a little away from the surface.

/// Relative distance from a surface in ordinary scenes.
const NEAR: f64 = 1e-3;

/// A lamp at a point; in the ordinary scene it is moved in the direction `away`.
fn with_lamp_at(case: &Workload, point: DVec3, away: DVec3) -> Pair {
    [point + away * (NEAR * point.length()), point].map(|at| case.with_lamp(Source::Point(at)))
}

/// A direction along an axis, but not down: spheres of rooms touch their floor there.
fn axis(rng: &mut Rng) -> DVec3 {
    [DVec3::X, -DVec3::X, DVec3::Z, -DVec3::Z, DVec3::Y][rng.random_range(0..5)]
}

fn any_sphere(case: &Workload, rng: &mut Rng) -> Sphere {
    case.scene.spheres[rng.random_range(0..case.scene.spheres.len())]
}

fn lamp_on_floor(rng: &mut Rng) -> Pair {
    let point = (in_cube(rng) * 2.5).map(short).with_y(0.0);
    with_lamp_at(&lit_picture(rng), point, DVec3::Y)
}

fn lamp_on_ceiling(rng: &mut Rng) -> Pair {
    let mut case = lit_picture(rng);
    case.scene.planes.truncate(1);
    let point = (in_cube(rng) * 2.5).map(short).with_y(3.0);
    with_lamp_at(&case.with_plane(DVec3::Y * 3.0, DVec3::Y), point, -DVec3::Y)
}

fn lamp_on_sphere(rng: &mut Rng) -> Pair {
    let (case, axis) = (lit_picture(rng), axis(rng));
    let Sphere { center, radius } = any_sphere(&case, rng);
    with_lamp_at(&case, center + axis * radius, axis)
}

fn lamp_at_center(rng: &mut Rng) -> Pair {
    let case = lit_picture(rng);
    let center = any_sphere(&case, rng).center;
    with_lamp_at(&case, center, axis(rng))
}

fn lamp_at_camera(rng: &mut Rng) -> Pair {
    let mut case = lit_picture(rng);
    case.camera().projection = Projection::Perspective { fov_degrees: 45.0 };
    let position = case.camera().position;
    with_lamp_at(&case, position, axis(rng))
}

/// The ordinary scene has a sun in the direction of the lamp.
fn far_lamp(rng: &mut Rng, [least, most]: [f64; 2]) -> Pair {
    let mut case = lit_picture(rng);
    case.scene.planes.truncate(1);
    let towards = in_cube(rng).with_y(0.5).normalize();
    let point = towards * power_of_ten(rng, least, most);
    [Source::Sun(-towards), Source::Point(point)].map(|source| case.with_lamp(source))
}

/// A camera at a point; in the ordinary scene it is moved in the direction `away`.
fn with_camera_at(case: &Workload, point: DVec3, away: DVec3, ahead: DVec3) -> Pair {
    [point + away * NEAR, point].map(|position| {
        let mut case = case.clone();
        let camera = case.camera();
        (camera.position, camera.look_at) = (position, position + ahead);
        case
    })
}

fn camera_on_sphere(rng: &mut Rng) -> Pair {
    let (case, outward) = (picture(rng), axis(rng));
    let Sphere { center, radius } = any_sphere(&case, rng);
    let ahead = outward + in_cube(rng) * 0.3;
    with_camera_at(&case, center + outward * radius, outward, ahead)
}

fn camera_in_plane(rng: &mut Rng) -> Pair {
    let mut case = lit_picture(rng);
    let position = case.camera().position.with_y(0.0);
    let target = CENTER.with_y(rng.random_range(0.0..2.0));
    with_camera_at(&case, position, DVec3::Y, target - position)
}

// Scales

fn scaled(case: &Workload, factor: f64) -> Workload {
    let mut case = case.clone();
    for sphere in case.scene.spheres.iter_mut() {
        *sphere = Sphere { center: sphere.center * factor, radius: sphere.radius * factor };
    }
    case.scene.planes.iter_mut().for_each(|plane| plane.point *= factor);
    case.list.iter_mut().for_each(|ray| ray.origin *= factor);
    for light in &mut case.scene.lights {
        if let Source::Point(position) = &mut light.source {
            *position *= factor;
        }
    }
    if let Some(Camera { position, look_at, projection, .. }) = &mut case.scene.camera {
        (*position, *look_at) = (*position * factor, *look_at * factor);
        if let Projection::Orthographic { height } = projection {
            *height *= factor;
        }
    }
    case
}

fn scaled_by(rng: &mut Rng, factor: fn(&mut Rng) -> f64) -> Pair {
    let case = ordinary(rng);
    let with = scaled(&case, factor(rng));
    [case, with]
}
