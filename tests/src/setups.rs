//! Hard configurations of objects and rays, drawn at random: what the campaign traces. A test that
//! takes this module takes `cases.rs` and `oracle.rs` as its modules `cases` and `oracle`.

use glam::{DVec3, Vec3Swizzles as _, dvec3};
use kugelblitz::exact::Shape;
use kugelblitz::rays::{Lens, Pixels, View};
use kugelblitz::scene::{Camera, Color, Plane, Projection, Scene, Sphere};
use kugelblitz::trace::{Ray, Rays};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::cases::{
    Case, CaseRay, any_vector, exact_orthographic_case, exact_pixel_case, integer, integer_frame,
    integer_tie_case, nonzero, nudged, on_surface_case, plane, random_case, scaled, sphere,
};

/// Objects, and rays that meet them where it is hard.
pub struct Setup {
    pub shapes: Vec<Shape>,
    /// At least one. The first one's origin is the eye.
    pub aims: Vec<Ray>,
    /// A picture that must be traced as it is.
    pub pixels: Option<Pixels>,
}

fn setup(shapes: Vec<Shape>, aims: Vec<Ray>) -> Setup {
    Setup { shapes, aims, pixels: None }
}

/// A name and its setups.
pub type Family = (&'static str, fn(&mut ChaCha8Rng) -> Setup);

pub const FAMILIES: [Family; 13] = [
    ("silhouettes", silhouettes),
    ("eye near surface", eye_near_surface),
    ("eye on surface", eye_on_surface),
    ("touching", touching),
    ("nested", nested),
    ("coincident", coincident),
    ("interpenetrating", interpenetrating),
    ("grazing planes", grazing_planes),
    ("tangent planes", tangent_planes),
    ("integer ties", integer_ties),
    ("random", random),
    ("exact pixels", exact_pixels),
    ("exact orthographic", exact_orthographic),
];

/// Where a batch's rays come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    OneOrigin,
    ManyOrigins,
    Pixels,
    Orthographic,
}

pub const SOURCES: [Source; 4] =
    [Source::OneOrigin, Source::ManyOrigins, Source::Pixels, Source::Orthographic];

/// A scene with rays.
pub struct Batch {
    pub family: usize,
    pub source: Source,
    pub scene: Scene,
    pub rays: Rays,
}

/// The batch of this number, the same for the same seed.
pub fn batch(seed: u64, index: u64) -> Batch {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(index);
    let n = FAMILIES.len() as u64;
    let family = (index % n) as usize;
    let source = SOURCES[(index / n % SOURCES.len() as u64) as usize];
    let mut setup = FAMILIES[family].1(&mut rng);
    move_and_scale(&mut rng, &mut setup);
    let rays = match source {
        Source::Pixels => Rays::Pixels(picture(&mut rng, &setup, Lens::Perspective)),
        Source::Orthographic => Rays::Pixels(picture(&mut rng, &setup, Lens::Orthographic)),
        Source::OneOrigin | Source::ManyOrigins => Rays::List(list(&mut rng, &setup, source)),
    };
    Batch { family, source, scene: scene_of(&setup.shapes), rays }
}

/// Spheres first, otherwise in the order given.
pub fn scene_of(shapes: &[Shape]) -> Scene {
    let color = Color([1.0; 3]);
    let (mut spheres, mut planes) = (Vec::new(), Vec::new());
    for shape in shapes {
        match *shape {
            Shape::Sphere { center, radius } => {
                spheres.push(Sphere { center, radius });
            }
            Shape::Plane { point, normal } => {
                planes.push(Plane { name: None, point, normal, color });
            }
        }
    }
    Scene { spheres: spheres.into(), planes, ..Scene::default() }
}

// ---------------------------------------------------------------------------------------------
// From a setup to rays

fn sign(rng: &mut impl Rng) -> f64 {
    if rng.random() { 1.0 } else { -1.0 }
}

fn power_of_ten(rng: &mut impl Rng, low: f64, high: f64) -> f64 {
    10f64.powf(rng.random_range(low..high))
}

fn power_of_two(rng: &mut impl Rng, low: i32, high: i32) -> f64 {
    2f64.powi(rng.random_range(low..=high))
}

fn unit(rng: &mut impl Rng) -> DVec3 {
    loop {
        let v = any_vector(rng, 1.0);
        if (0.01..1.0).contains(&v.length_squared()) {
            return v.normalize();
        }
    }
}

/// A random unit vector across `v`.
fn across(rng: &mut impl Rng, v: DVec3) -> DVec3 {
    v.normalize().cross(unit(rng)).normalize_or(v.any_orthonormal_vector())
}

fn moved(shape: Shape, by: DVec3) -> Shape {
    match shape {
        Shape::Sphere { center, radius } => sphere(center + by, radius),
        Shape::Plane { point, normal } => plane(point + by, normal),
    }
}

/// Coordinates between 10⁻³⁰ and 10³⁰, and scenes far from the origin of the coordinates.
fn move_and_scale(rng: &mut impl Rng, setup: &mut Setup) {
    let by = match rng.random_range(0..4) {
        0 | 1 => DVec3::ZERO,
        // Mostly exact for setups of integers.
        2 => (any_vector(rng, 1.0) * power_of_ten(rng, 0.0, 12.0)).round(),
        _ => any_vector(rng, 1.0) * power_of_ten(rng, -3.0, 8.0),
    };
    let scale = match rng.random_range(0..4) {
        0 => 1.0,
        1 => power_of_two(rng, -100, 100),
        2 => power_of_two(rng, -20, 20),
        _ => power_of_ten(rng, -30.0, 30.0),
    };
    let place = |v: DVec3| (v + by) * scale;
    for shape in &mut setup.shapes {
        *shape = scaled(moved(*shape, by), scale);
        if let Shape::Plane { normal, .. } = shape {
            *normal *= power_of_ten(rng, -6.0, 6.0);
        }
    }
    for aim in &mut setup.aims {
        aim.origin = place(aim.origin);
        aim.direction *= scale;
    }
    if let Some(pixels) = &mut setup.pixels {
        pixels.view.position = place(pixels.view.position);
        if pixels.view.lens == Lens::Orthographic {
            pixels.view.h *= scale;
        }
    }
}

/// The aims, and rays beside them by 2⁻⁴ … 2⁻⁵².
fn list(rng: &mut impl Rng, setup: &Setup, source: Source) -> Vec<Ray> {
    let eye = setup.aims[0].origin;
    let from_eye: Vec<&Ray> = setup.aims.iter().filter(|aim| aim.origin == eye).collect();
    (0..400)
        .map(|_| {
            let (mut origin, direction) = match source {
                Source::ManyOrigins => {
                    let aim = setup.aims[rng.random_range(0..setup.aims.len())];
                    (aim.origin, aim.direction)
                }
                _ => (eye, from_eye[rng.random_range(0..from_eye.len())].direction),
            };
            let mut direction = beside(rng, direction);
            if source == Source::ManyOrigins {
                origin = match rng.random_range(0..4) {
                    0 => origin,
                    1 => dvec3(nudged(rng, origin.x), nudged(rng, origin.y), nudged(rng, origin.z)),
                    2 => origin + direction * (power_of_two(rng, -40, 0) * sign(rng)),
                    _ => origin + unit(rng) * (direction.length() * power_of_two(rng, -50, -1)),
                };
            }
            direction *= match rng.random_range(0..8) {
                0 => power_of_ten(rng, -40.0, 40.0),
                1 | 2 => power_of_ten(rng, -8.0, 8.0),
                // `t` about 1 in any scene.
                3 | 4 => 1.0,
                _ => power_of_two(rng, -9, 9),
            };
            Ray { origin, direction }
        })
        .collect()
}

fn beside(rng: &mut impl Rng, direction: DVec3) -> DVec3 {
    if rng.random_bool(0.3) {
        return direction;
    }
    let aside = across(rng, direction) * (direction.length() * power_of_two(rng, -52, -4));
    direction + aside
}

/// A small picture around one of the aims; where its size is odd, the aim is its axis.
fn picture(rng: &mut impl Rng, setup: &Setup, lens: Lens) -> Pixels {
    if let Some(pixels) = setup.pixels {
        return pixels;
    }
    let aim = setup.aims[rng.random_range(0..setup.aims.len())];
    let along = aim.direction.normalize();
    let mut view = View::new(&Camera {
        position: DVec3::ZERO,
        look_at: along,
        up: across(rng, along),
        projection: Projection::Perspective { fov_degrees: 45.0 },
    });
    if rng.random_bool(0.3) && aim.direction.abs().max_element() == aim.direction.length() {
        // Along an axis: an exact frame.
        view.forward = along;
        view.right = along.yzx();
        view.true_up = view.right.cross(along);
    }
    view.position = aim.origin;
    view.h = match rng.random_range(0..4) {
        0 => rng.random_range(0.01..2.0),
        1 => power_of_two(rng, -50, 4),
        _ => power_of_ten(rng, -15.0, 0.0),
    };
    view.lens = lens;
    if lens == Lens::Orthographic {
        view.h *= aim.direction.length();
    }
    let side = |rng: &mut dyn FnMut() -> u32| 2 * rng() + 1;
    let width = side(&mut || rng.random_range(0..13)) + u32::from(rng.random_bool(0.1));
    let height = side(&mut || rng.random_range(0..13)) + u32::from(rng.random_bool(0.1));
    Pixels::whole(view, width, height)
}

// ---------------------------------------------------------------------------------------------
// Families

/// A ray within 2⁻⁴ … 2⁻⁵⁰ of the silhouette of the sphere at `center`, as seen from `eye`.
fn at_silhouette(rng: &mut impl Rng, eye: DVec3, center: DVec3, r: f64) -> Ray {
    let l = center - eye;
    let aside = across(rng, l);
    let off = power_of_two(rng, -50, -4) * sign(rng);
    let distance = l.length();
    if distance <= r {
        // Inside there is none: along the surface.
        return Ray { origin: eye, direction: aside * r + l * power_of_two(rng, -50, -4) };
    }
    let sine = ((1.0 + off) * r / distance).min(1.0);
    let direction = l / distance * (1.0 - sine * sine).sqrt() + aside * sine;
    Ray { origin: eye, direction: direction * distance }
}

fn silhouettes(rng: &mut ChaCha8Rng) -> Setup {
    let eye = any_vector(rng, 1.0);
    let n = rng.random_range(1..4);
    let (mut shapes, mut aims) = (Vec::new(), Vec::new());
    for _ in 0..n {
        let r = power_of_ten(rng, -2.0, 2.0);
        let ratio = match rng.random_range(0..3) {
            0 => 1.0 + power_of_ten(rng, -9.0, 0.0),
            1 => power_of_ten(rng, 0.0, 3.0),
            _ => power_of_ten(rng, 3.0, 8.0),
        };
        let center = eye + unit(rng) * (r * ratio);
        shapes.push(sphere(center, r));
        aims.extend((0..40).map(|_| at_silhouette(rng, eye, center, r)));
        // Other eyes around the same sphere.
        aims.extend((0..5).map(|_| {
            let eye = center + unit(rng) * (r * (1.0 + power_of_ten(rng, -9.0, 3.0)));
            at_silhouette(rng, eye, center, r)
        }));
    }
    setup(shapes, aims)
}

/// Just off the surface, or just under it.
fn eye_near_surface(rng: &mut ChaCha8Rng) -> Setup {
    let eye = any_vector(rng, 1.0);
    let r = power_of_ten(rng, -3.0, 6.0);
    let gap = power_of_ten(rng, -17.0, 0.0) * sign(rng);
    let toward = unit(rng);
    let center = eye + toward * (r * (1.0 + gap));
    let other = eye + any_vector(rng, 3.0) * r;
    let shapes = vec![sphere(center, r), sphere(other, r * rng.random_range(0.1..1.5))];
    let mut aims: Vec<Ray> = (0..20).map(|_| at_silhouette(rng, eye, center, r)).collect();
    aims.extend((0..20).map(|_| Ray { origin: eye, direction: unit(rng) * r }));
    aims.extend((0..20).map(|_| {
        let direction = across(rng, toward) + toward * (power_of_ten(rng, -17.0, 0.0) * sign(rng));
        Ray { origin: eye, direction: direction * r }
    }));
    setup(shapes, aims)
}

fn eye_on_surface(rng: &mut ChaCha8Rng) -> Setup {
    if rng.random() {
        let case = on_surface_case(rng);
        return setup_of(rng, case);
    }
    // The camera at 0 on a sphere below it: `k = 0` exactly.
    let r = match rng.random_range(0..3) {
        0 => power_of_two(rng, -20, 20),
        1 => f64::from(rng.random_range(1..100)),
        _ => power_of_ten(rng, -3.0, 3.0),
    };
    let axis = [DVec3::X, DVec3::Y, DVec3::Z][rng.random_range(0..3)] * sign(rng);
    let mut shapes = vec![sphere(axis * r, nudged(rng, r))];
    if rng.random() {
        let other = r * power_of_two(rng, -3, 3);
        shapes.push(sphere(axis * -nudged(rng, other), other));
    }
    if rng.random() {
        shapes.push(plane(DVec3::ZERO, axis + any_vector(rng, 0.5).round()));
    }
    if rng.random() {
        shapes.push(sphere(unit(rng) * (3.0 * r), r));
    }
    let aims = (0..30)
        .map(|_| {
            let direction = match rng.random_range(0..4) {
                0 => axis * sign(rng),
                1 => axis.yzx() * sign(rng),
                2 => across(rng, axis) + axis * (power_of_ten(rng, -18.0, 0.0) * sign(rng)),
                _ => unit(rng),
            };
            Ray { origin: DVec3::ZERO, direction: direction * r }
        })
        .collect();
    setup(shapes, aims)
}

/// The case's ray, and rays from the same origin to its objects.
fn setup_of(rng: &mut ChaCha8Rng, case: crate::cases::Case) -> Setup {
    let CaseRay::List(ray) = case.ray else { unreachable!("a list's case") };
    let shapes: Vec<Shape> = case.objects.iter().map(|&(_, shape)| shape).collect();
    let mut aims = vec![ray; 5];
    for shape in &shapes {
        if let Shape::Sphere { center, radius } = *shape {
            aims.push(at_silhouette(rng, ray.origin, center, radius));
        }
    }
    setup(shapes, aims)
}

fn touching(rng: &mut ChaCha8Rng) -> Setup {
    let ([u, v, w], length) = integer_frame(rng, 12);
    let [a, b, c] = [0; 3].map(|_| f64::from(rng.random_range(1..9)));
    let mut shapes = vec![
        sphere(DVec3::ZERO, nudged(rng, a * length)),
        // From outside at `u·a`, and from inside there.
        sphere(u * (a + b), b * length),
        sphere(u * (a - c), c * length),
    ];
    if rng.random() {
        shapes.push(plane(u * a, u));
    }
    shuffle(rng, &mut shapes);
    let touch = u * a;
    let eyes = [
        touch + v * nonzero(rng, 30),
        touch + w * nonzero(rng, 30) + v * integer(rng, 30),
        touch + u * nonzero(rng, 30) + v * integer(rng, 9),
        touch,
    ];
    let eye = eyes[rng.random_range(0..4)];
    let mut aims: Vec<Ray> = vec![toward(rng, eye, touch); 3];
    aims.extend(eyes.map(|eye| toward(rng, eye, touch)));
    for (center, r) in [(DVec3::ZERO, a * length), (u * (a + b), b * length)] {
        aims.push(at_silhouette(rng, eye, center, r));
    }
    setup(shapes, aims)
}

fn toward(rng: &mut impl Rng, eye: DVec3, target: DVec3) -> Ray {
    let direction = target - eye;
    let direction = if direction == DVec3::ZERO { unit(rng) } else { direction };
    Ray { origin: eye, direction }
}

fn shuffle<T>(rng: &mut impl Rng, list: &mut [T]) {
    for i in (1..list.len()).rev() {
        list.swap(i, rng.random_range(0..=i));
    }
}

fn nested(rng: &mut ChaCha8Rng) -> Setup {
    let center = any_vector(rng, 3.0);
    let r = power_of_ten(rng, -2.0, 2.0);
    let mut shapes = vec![sphere(center, r)];
    let mut radius = r;
    for _ in 0..rng.random_range(1..5) {
        radius *= 1.0 + power_of_ten(rng, -16.0, 0.0);
        shapes.push(sphere(center, radius));
    }
    shuffle(rng, &mut shapes);
    let distance = match rng.random_range(0..4) {
        0 => r * rng.random_range(0.0..1.0),
        1 => (r + radius) / 2.0,
        2 => radius * (1.0 + power_of_ten(rng, -9.0, 0.0)),
        _ => radius * power_of_ten(rng, 0.0, 6.0),
    };
    let eye = center + unit(rng) * distance;
    let mut aims: Vec<Ray> = (0..10).map(|_| toward(rng, eye, center)).collect();
    aims.extend((0..20).map(|_| at_silhouette(rng, eye, center, r)));
    aims.extend((0..20).map(|_| at_silhouette(rng, eye, center, radius)));
    setup(shapes, aims)
}

/// The same sphere or plane several times, some an ulp off.
fn coincident(rng: &mut ChaCha8Rng) -> Setup {
    let eye = any_vector(rng, 1.0);
    let r = power_of_ten(rng, -1.0, 1.0);
    let center = eye + unit(rng) * (r * power_of_ten(rng, -0.5, 4.0));
    let normal = unit(rng);
    let point = center + any_vector(rng, r);
    let shapes = (0..rng.random_range(2..5))
        .map(|_| match rng.random_range(0..4) {
            0 => sphere(center, nudged(rng, r)),
            1 => sphere(dvec3(nudged(rng, center.x), center.y, center.z), r),
            2 => plane(point, normal * power_of_two(rng, -3, 3) * sign(rng)),
            _ => sphere(center, r),
        })
        .collect();
    let mut aims: Vec<Ray> = (0..20)
        .map(|_| {
            let target = center + unit(rng) * (r * 0.7);
            toward(rng, eye, target)
        })
        .collect();
    aims.extend((0..20).map(|_| at_silhouette(rng, eye, center, r)));
    aims.push(toward(rng, eye, center));
    setup(shapes, aims)
}

/// Spheres that cut each other, seen along their common circle: roots that are nearly equal.
fn interpenetrating(rng: &mut ChaCha8Rng) -> Setup {
    let r = power_of_ten(rng, -1.0, 1.0);
    let second = r * rng.random_range(0.5..1.5);
    let along = unit(rng);
    let gap = rng.random_range((r - second).abs() * 1.01 + 1e-9..(r + second) * 0.999);
    let center = any_vector(rng, 5.0);
    // Distance of the circle's plane from the first centre, and the circle's radius.
    let x = (gap * gap + r * r - second * second) / (2.0 * gap);
    let circle = (r * r - x * x).max(0.0).sqrt();
    let mut shapes = vec![sphere(center, r), sphere(center + along * gap, second)];
    if rng.random() {
        shapes.push(plane(center + along * x, along));
    }
    shuffle(rng, &mut shapes);
    let eye = match rng.random_range(0..3) {
        0 => center + any_vector(rng, 0.4) * r,
        1 => center + unit(rng) * (r * power_of_ten(rng, 0.2, 1.0)),
        _ => center + unit(rng) * (r * power_of_ten(rng, 0.2, 5.0)),
    };
    let aims = (0..40)
        .map(|_| {
            let at = center + along * x + across(rng, along) * circle;
            toward(rng, eye, at)
        })
        .collect();
    setup(shapes, aims)
}

fn grazing_planes(rng: &mut ChaCha8Rng) -> Setup {
    let eye = any_vector(rng, 1.0);
    let normal = match rng.random_range(0..3) {
        0 => [DVec3::X, DVec3::Y, DVec3::Z][rng.random_range(0..3)],
        1 => any_vector(rng, 3.0).round() + DVec3::X * 4.0,
        _ => unit(rng),
    };
    let height = match rng.random_range(0..5) {
        0 => 0.0,
        1 | 2 => power_of_ten(rng, -9.0, 0.0),
        _ => power_of_ten(rng, 0.0, 8.0),
    } * sign(rng);
    let point = eye + normal * height + across(rng, normal) * power_of_ten(rng, -2.0, 6.0);
    let mut shapes = vec![plane(point, normal)];
    if rng.random() {
        // The same plane again, nearly.
        let other = across(rng, normal) * power_of_ten(rng, -17.0, 0.0);
        shapes.push(plane(point + across(rng, normal), normal + other));
    }
    if rng.random() {
        let far = power_of_ten(rng, 0.0, 6.0);
        shapes.push(sphere(eye + across(rng, normal) * far, far * rng.random_range(0.01..0.5)));
    }
    let aims = (0..40)
        .map(|_| {
            let tilt = match rng.random_range(0..5) {
                0 => 0.0,
                _ => power_of_ten(rng, -18.0, 0.0) * sign(rng),
            };
            Ray { origin: eye, direction: across(rng, normal) + normal * tilt }
        })
        .collect();
    setup(shapes, aims)
}

fn tangent_planes(rng: &mut ChaCha8Rng) -> Setup {
    let ([u, v, w], length) = integer_frame(rng, 9);
    let r = f64::from(rng.random_range(1..9));
    let mut shapes = vec![
        sphere(DVec3::ZERO, nudged(rng, r * length)),
        plane(u * r + v * integer(rng, 5), u),
        plane(u * -r, u),
    ];
    if rng.random() {
        shapes.push(plane(v * r, v));
        shapes.push(sphere(u * (2.0 * r), r * length));
    }
    let touch = u * r;
    let eye = match rng.random_range(0..3) {
        0 => touch + u * integer(rng, 5) + v * nonzero(rng, 20),
        1 => touch + v * nonzero(rng, 20),
        _ => touch + u * f64::from(rng.random_range(1..20)) + w * integer(rng, 20),
    };
    let mut aims = vec![toward(rng, eye, touch); 4];
    aims.extend((0..10).map(|_| {
        let at = touch + across(rng, u) * (length * power_of_two(rng, -26, 2));
        toward(rng, eye, at)
    }));
    aims.extend((0..5).map(|_| at_silhouette(rng, eye, DVec3::ZERO, r * length)));
    setup(shapes, aims)
}

fn integer_ties(rng: &mut ChaCha8Rng) -> Setup {
    let case = integer_tie_case(rng);
    setup_of(rng, case)
}

fn random(rng: &mut ChaCha8Rng) -> Setup {
    let case = random_case(rng);
    let mut setup = setup_of(rng, case);
    let origin = setup.aims[0].origin;
    for _ in 0..rng.random_range(0..10) {
        let at = origin + any_vector(rng, 20.0);
        setup.shapes.push(sphere(at, power_of_ten(rng, -2.0, 1.0)));
    }
    setup.aims.extend((0..20).map(|_| Ray { origin, direction: unit(rng) * 10.0 }));
    setup
}

fn exact_pixels(rng: &mut ChaCha8Rng) -> Setup {
    around_pixel(exact_pixel_case(rng))
}

fn exact_orthographic(rng: &mut ChaCha8Rng) -> Setup {
    around_pixel(exact_orthographic_case(rng))
}

fn around_pixel(case: Case) -> Setup {
    let CaseRay::Pixel(mut pixels, x, y) = case.ray else { unreachable!("a pixel's case") };
    let shapes: Vec<Shape> = case.objects.iter().map(|&(_, shape)| shape).collect();
    // The pixel and its neighbours.
    pixels.x = x.saturating_sub(8);
    pixels.y = y.saturating_sub(8);
    pixels.width = (pixels.image_width - pixels.x).min(17);
    pixels.height = (pixels.image_height - pixels.y).min(17);
    Setup { shapes, aims: vec![pixels.ray(x, y)], pixels: Some(pixels) }
}
