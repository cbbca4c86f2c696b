//! Random and constructed cases for tests against exact arithmetic. A test that takes this module
//! takes `oracle.rs` as its module `oracle`.

use std::fmt::Write as _;

use glam::{DVec3, dvec3};
use kugelblitz::exact::{ExactRay, Shape};
use kugelblitz::rays::{Lens, Pixels, View};
use kugelblitz::scene::{Camera, Projection};
use kugelblitz::trace::Ray;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::rational::OracleRay;

/// One ray and the objects that it may meet.
#[derive(Clone, Debug)]
pub struct Case {
    pub family: &'static str,
    pub ray: CaseRay,
    pub objects: Vec<(u32, Shape)>,
}

#[derive(Clone, Copy, Debug)]
pub enum CaseRay {
    List(Ray),
    Pixel(Pixels, u32, u32),
}

impl Case {
    pub fn exact_ray(&self) -> ExactRay {
        match self.ray {
            CaseRay::List(ray) => ExactRay::new(&ray),
            CaseRay::Pixel(pixels, x, y) => ExactRay::from_pixel(&pixels, x, y),
        }
    }

    pub fn oracle_ray(&self) -> OracleRay {
        match self.ray {
            CaseRay::List(ray) => OracleRay::new(&ray),
            CaseRay::Pixel(pixels, x, y) => OracleRay::from_pixel(&pixels, x, y),
        }
    }

    /// Rust source of the case.
    pub fn paste(&self) -> String {
        let v = |v: DVec3| format!("dvec3({:e}, {:e}, {:e})", v.x, v.y, v.z);
        let mut text = format!("Case {{ family: {:?}, ", self.family);
        let _ = match self.ray {
            CaseRay::List(r) => write!(
                text,
                "ray: CaseRay::List(Ray {{ origin: {}, direction: {} }}), ",
                v(r.origin),
                v(r.direction)
            ),
            CaseRay::Pixel(p, x, y) => write!(
                text,
                "ray: CaseRay::Pixel(Pixels::whole(View {{ position: {}, forward: {}, right: {}, \
                 true_up: {}, h: {:e}, lens: Lens::{:?} }}, {}, {}), {x}, {y}), ",
                v(p.view.position),
                v(p.view.forward),
                v(p.view.right),
                v(p.view.true_up),
                p.view.h,
                p.view.lens,
                p.image_width,
                p.image_height
            ),
        };
        text += "objects: vec![";
        for (id, shape) in &self.objects {
            let _ = match *shape {
                Shape::Sphere { center, radius } => write!(
                    text,
                    "({id}, Shape::Sphere {{ center: {}, radius: {radius:e} }}), ",
                    v(center)
                ),
                Shape::Plane { point, normal } => write!(
                    text,
                    "({id}, Shape::Plane {{ point: {}, normal: {} }}), ",
                    v(point),
                    v(normal)
                ),
            };
        }
        text + "] }"
    }
}

pub fn sphere(center: DVec3, radius: f64) -> Shape {
    Shape::Sphere { center, radius }
}

pub fn plane(point: DVec3, normal: DVec3) -> Shape {
    Shape::Plane { point, normal }
}

pub fn any_vector(rng: &mut impl Rng, size: f64) -> DVec3 {
    dvec3(
        rng.random_range(-size..size),
        rng.random_range(-size..size),
        rng.random_range(-size..size),
    )
}

pub fn integer(rng: &mut impl Rng, limit: i32) -> f64 {
    f64::from(rng.random_range(-limit..=limit))
}

pub fn nonzero(rng: &mut impl Rng, limit: i32) -> f64 {
    loop {
        let n = integer(rng, limit);
        if n != 0.0 {
            return n;
        }
    }
}

pub fn integer_vector(rng: &mut impl Rng, limit: i32) -> DVec3 {
    dvec3(integer(rng, limit), integer(rng, limit), integer(rng, limit))
}

/// Three orthogonal integer vectors of the same integer length (the columns of a rotation by an
/// integer quaternion, times its norm; Pythagorean quadruples), and that length.
pub fn integer_frame(rng: &mut impl Rng, limit: i32) -> ([DVec3; 3], f64) {
    let [a, b, c, d]: [f64; 4] =
        [nonzero(rng, limit), integer(rng, limit), integer(rng, limit), integer(rng, limit)];
    let columns = [
        dvec3(a * a + b * b - c * c - d * d, 2.0 * (b * c + a * d), 2.0 * (b * d - a * c)),
        dvec3(2.0 * (b * c - a * d), a * a - b * b + c * c - d * d, 2.0 * (c * d + a * b)),
        dvec3(2.0 * (b * d + a * c), 2.0 * (c * d - a * b), a * a - b * b - c * c + d * d),
    ];
    (columns, a * a + b * b + c * c + d * d)
}

/// One ulp up or down, or not at all, half of the time.
pub fn nudged(rng: &mut impl Rng, x: f64) -> f64 {
    match rng.random_range(0..4) {
        0 => x.next_up(),
        1 => x.next_down(),
        _ => x,
    }
}

pub fn numbered(rng: &mut impl Rng, mut shapes: Vec<Shape>) -> Vec<(u32, Shape)> {
    // In no order of ids: ties must not depend on it.
    for i in (1..shapes.len()).rev() {
        shapes.swap(i, rng.random_range(0..=i));
    }
    let mut objects: Vec<(u32, Shape)> = (1..).zip(shapes).collect();
    for i in (1..objects.len()).rev() {
        objects.swap(i, rng.random_range(0..=i));
    }
    objects
}

pub fn random_case(rng: &mut impl Rng) -> Case {
    let origin = any_vector(rng, 10.0);
    let direction = any_vector(rng, 1.0);
    let n = rng.random_range(1..6);
    let shapes = (0..n)
        .map(|_| {
            let near = origin + direction * rng.random_range(-3.0..20.0) + any_vector(rng, 2.0);
            if rng.random_bool(0.3) {
                plane(near, any_vector(rng, 3.0))
            } else {
                sphere(near, rng.random_range(0.01..5.0))
            }
        })
        .collect();
    Case {
        family: "random",
        ray: CaseRay::List(Ray { origin, direction }),
        objects: numbered(rng, shapes),
    }
}

pub fn silhouette_case(rng: &mut impl Rng) -> Case {
    let distance = 10f64.powf(rng.random_range(0.0..8.0));
    let center = any_vector(rng, distance);
    let radius = 10f64.powf(rng.random_range(-3.0..2.0));
    let origin = any_vector(rng, distance);
    let aside = (center - origin).cross(any_vector(rng, 1.0)).normalize();
    let k = rng.random_range(8..54);
    let off = 1.0 + f64::powi(2.0, -k) * if rng.random() { 1.0 } else { -1.0 };
    let direction = center + aside * radius * off - origin;
    Case {
        family: "silhouette",
        ray: CaseRay::List(Ray { origin, direction }),
        objects: vec![(1, sphere(center, radius))],
    }
}

/// Everything meets the ray at the same rational `t = i/k`: tangent spheres, spheres met head-on,
/// planes, mirrored and coinciding spheres; some an ulp off.
pub fn integer_tie_case(rng: &mut impl Rng) -> Case {
    let ([u, v, w], length) = integer_frame(rng, 12);
    let shift = {
        let bits = rng.random_range(1..31);
        integer_vector(rng, 1 << bits)
    };
    let origin = shift;
    let k = f64::from(rng.random_range(1..20));
    let i = f64::from(rng.random_range(1..20));
    let point = origin + u * i;
    let n = rng.random_range(1..6);
    let mut shapes = Vec::new();
    for _ in 0..n {
        let shape = match rng.random_range(0..6) {
            0 => {
                let j = nonzero(rng, 9);
                sphere(point + v * j, j.abs() * length)
            }
            1 => {
                let j = nonzero(rng, 9);
                sphere(point + w * j, nudged(rng, j.abs() * length))
            }
            2 => {
                let r = f64::from(rng.random_range(1..9));
                sphere(point + u * r, nudged(rng, r * length))
            }
            3 => plane(point + v * integer(rng, 3), u + w * integer(rng, 3)),
            4 => {
                // Pierced off-centre: irrational, the same for two mirrored spheres.
                let j = nonzero(rng, 9);
                let r = (j.abs() + 1.0) * length;
                shapes.push(sphere(point - w * j + u * 20.0, r));
                sphere(point + v * j + u * 20.0, r)
            }
            _ => match shapes.first() {
                Some(&shape) => shape,
                None => plane(point, u),
            },
        };
        shapes.push(shape);
    }
    let scale = f64::powi(2.0, rng.random_range(-60..60));
    for shape in &mut shapes {
        *shape = scaled(*shape, scale);
    }
    Case {
        family: "integer ties",
        ray: CaseRay::List(Ray { origin: origin * scale, direction: u * k }),
        objects: numbered(rng, shapes),
    }
}

pub fn scaled(shape: Shape, scale: f64) -> Shape {
    match shape {
        Shape::Sphere { center, radius } => sphere(center * scale, radius * scale),
        Shape::Plane { point, normal } => plane(point * scale, normal),
    }
}

/// The origin lies exactly on spheres and planes, or an ulp beside them.
pub fn on_surface_case(rng: &mut impl Rng) -> Case {
    let ([u, v, w], length) = integer_frame(rng, 9);
    let origin = integer_vector(rng, 1000);
    let direction = match rng.random_range(0..5) {
        0 => u,
        1 => -u,
        2 => v,
        3 => u * integer(rng, 5) + v * nonzero(rng, 5) + w * integer(rng, 5),
        _ => any_vector(rng, 1.0),
    };
    let n = rng.random_range(1..4);
    let shapes = (0..n)
        .map(|_| match rng.random_range(0..4) {
            0 => sphere(origin + u, nudged(rng, length)),
            1 => sphere(origin - u, nudged(rng, length)),
            2 => sphere(origin + u * 2.0 + v, length),
            _ => plane(origin + v, u),
        })
        .collect();
    Case {
        family: "on the surface",
        ray: CaseRay::List(Ray { origin, direction }),
        objects: numbered(rng, shapes),
    }
}

/// Exponents of any size, down to subnormal numbers, in objects that still meet the ray.
pub fn exponent_case(rng: &mut impl Rng) -> Case {
    let mut case = match rng.random_range(0..3) {
        0 => random_case(rng),
        1 => integer_tie_case(rng),
        _ => on_surface_case(rng),
    };
    case.family = "exponents";
    // The lowest make subnormal numbers.
    let scene = f64::powi(2.0, rng.random_range(-1065..400));
    let along = f64::powi(2.0, rng.random_range(-1000..400));
    if let CaseRay::List(ray) = &mut case.ray {
        ray.origin *= scene;
        // Often so that t fits an f32.
        ray.direction *= if rng.random_bool(0.7) { scene } else { along };
    }
    for (_, shape) in &mut case.objects {
        *shape = scaled(*shape, scene);
        if let Shape::Plane { normal, .. } = shape {
            *normal *= f64::powi(2.0, rng.random_range(-1000..900));
        }
    }
    case
}

pub fn pixel_case(rng: &mut impl Rng) -> Case {
    let projection = Projection::Perspective { fov_degrees: rng.random_range(1.0..170.0) };
    case_of_camera("pixels", projection, rng)
}

pub fn orthographic_case(rng: &mut impl Rng) -> Case {
    let projection = Projection::Orthographic { height: rng.random_range(0.01..20.0) };
    case_of_camera("orthographic", projection, rng)
}

fn case_of_camera(family: &'static str, projection: Projection, rng: &mut impl Rng) -> Case {
    let view = View::new(&Camera {
        position: any_vector(rng, 10.0),
        look_at: any_vector(rng, 10.0),
        up: any_vector(rng, 1.0),
        projection,
    });
    let (width, height) = (rng.random_range(1..5000), rng.random_range(1..3000));
    let pixels = Pixels::whole(view, width, height);
    let (x, y) = (rng.random_range(0..width), rng.random_range(0..height));
    let Ray { origin, direction: d } = pixels.ray(x, y);
    let n = rng.random_range(1..5);
    let shapes = (0..n)
        .map(|_| {
            let t = rng.random_range(-2.0..30.0);
            let at = origin + d * t;
            match rng.random_range(0..4) {
                // Grazing to f64 rounding.
                0 => {
                    let r = rng.random_range(0.1..3.0);
                    sphere(at + d.cross(any_vector(rng, 1.0)).normalize() * r, r)
                }
                1 => sphere(at + any_vector(rng, 2.0), rng.random_range(0.1..5.0)),
                2 => sphere(origin + any_vector(rng, 0.5), rng.random_range(0.5..3.0)),
                _ => plane(at, any_vector(rng, 1.0)),
            }
        })
        .collect();
    Case { family, ray: CaseRay::Pixel(pixels, x, y), objects: numbered(rng, shapes) }
}

/// An orthographic camera along an axis whose pixels are integers apart, and integer spheres and
/// planes: rays are tangent exactly, roots are integers and equal, and start on surfaces. But for
/// the picture's height, which is often odd, all numbers of the rays would be integers.
pub fn exact_orthographic_case(rng: &mut impl Rng) -> Case {
    let (width, height) = (rng.random_range(1..60), rng.random_range(1..60));
    let view = View {
        position: integer_vector(rng, 100),
        forward: dvec3(0.0, 0.0, -1.0),
        right: dvec3(1.0, 0.0, 0.0),
        true_up: dvec3(0.0, 1.0, 0.0),
        h: f64::from(height),
        lens: Lens::Orthographic,
    };
    let pixels = Pixels::whole(view, width, height);
    let (x, y) = (rng.random_range(0..width), rng.random_range(0..height));
    let (i, j) = pixels.offset2(x, y);
    let origin = view.position + dvec3(i as f64, j as f64, 0.0);
    let mut shapes = Vec::new();
    for _ in 0..rng.random_range(1..4) {
        // How far ahead the middle lies; 3² + 4² = 5², so that half the chord is 0, 3, 4 or 5.
        let depth = f64::from(rng.random_range(-6..12));
        let k = f64::from(rng.random_range(1..4));
        let aside = [dvec3(3.0, 4.0, 0.0), dvec3(3.0, 0.0, 0.0), dvec3(0.0, 4.0, 0.0), DVec3::ZERO];
        let aside = aside[rng.random_range(0..4)] * k;
        shapes.push(sphere(origin + aside - DVec3::Z * depth, 5.0 * k));
    }
    shapes
        .push(plane(origin - DVec3::Z * f64::from(rng.random_range(0..4)), integer_vector(rng, 3)));
    Case {
        family: "exact orthographic",
        ray: CaseRay::Pixel(pixels, x, y),
        objects: numbered(rng, shapes),
    }
}

/// A camera along the axes with `h = 1`: pixels whose rays are tangent exactly, `t` with `H`.
pub fn exact_pixel_case(rng: &mut impl Rng) -> Case {
    let view = View {
        position: integer_vector(rng, 100),
        forward: dvec3(0.0, 0.0, -1.0),
        right: dvec3(1.0, 0.0, 0.0),
        true_up: dvec3(0.0, 1.0, 0.0),
        h: 1.0,
        lens: Lens::Perspective,
    };
    let (width, height) = (rng.random_range(1..60), rng.random_range(1..60));
    let pixels = Pixels::whole(view, width, height);
    let (x, y) = (rng.random_range(0..width), rng.random_range(0..height));
    let (i, j) = pixels.offset2(x, y);
    let d = dvec3(i as f64, j as f64, -f64::from(height));
    // The ray passes through point; perpendicular to it stand (H, 0, i) and (0, H, j).
    let point = view.position + d * f64::from(rng.random_range(1..50));
    let across = dvec3(f64::from(height), 0.0, i as f64);
    let squared = across.length_squared();
    let mut shapes = vec![plane(point, integer_vector(rng, 5))];
    // Tangent only where the length is rational: an upright column of pixels, or luck.
    shapes.push(sphere(point + across, squared.sqrt()));
    shapes.push(sphere(
        point + dvec3(0.0, f64::from(height), j as f64),
        (f64::from(height).powi(2) + (j * j) as f64).sqrt(),
    ));
    Case {
        family: "exact pixels",
        ray: CaseRay::Pixel(pixels, x, y),
        objects: numbered(rng, shapes),
    }
}

pub const FAMILIES: [fn(&mut ChaCha8Rng) -> Case; 9] = [
    random_case,
    silhouette_case,
    integer_tie_case,
    on_surface_case,
    exponent_case,
    pixel_case,
    exact_pixel_case,
    orthographic_case,
    exact_orthographic_case,
];

/// A seed that differs from run to run, or the one that is asked for.
pub fn seed() -> u64 {
    if let Ok(text) = std::env::var("KUGELBLITZ_SEED") {
        return text.parse().expect("KUGELBLITZ_SEED is a number");
    }
    std::time::SystemTime::now()
        .duration_since(std::time::UNIX_EPOCH)
        .map_or(1, |time| time.as_nanos() as u64)
}

pub fn cases(seed: u64, per_family: usize) -> Vec<Case> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    FAMILIES
        .iter()
        .flat_map(|family| (0..per_family).map(|_| family(&mut rng)).collect::<Vec<_>>())
        .collect()
}
