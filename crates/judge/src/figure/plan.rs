//! Figures 2 and 5: plans of what the camera's rays meet. All lies in the plane through the middle of the picture from
//! left to right, as it is seen from above, and `t` is 0 at the camera. Where the picture has an even height, rays of pixels are half a
//! pixel lower.

use glam::DVec3;
use kugelblitz::Control;
use kugelblitz::Result;
use kugelblitz::exact::QuadraticSurd;
use kugelblitz::kernel::lecture::{plane_quotient, quadratic, quadratic_roots};
use kugelblitz::rays::{View, WorldRay};
use kugelblitz::scene::{Framing, Object, Plane, Projection, Sphere};

use super::axes;
use super::drawing::{Drawing, HIDDEN, VISIBLE, pieces};
use super::sphere::outline;
use super::words::round_step;
use crate::explain::DEFAULT_DIGITS;
use crate::explain::numbers::Short;
use crate::explain::step::Tape;

/// Rays between the edges of the picture: an even number, so that none is on the axis.
const N_RAYS: u64 = 6;

/// What is free at each edge, as a part of the picture's shorter side: room for the caption.
const MARGIN: f64 = 0.1;

/// Draws figure 2: rays of pixels of the middle row as far as they see, and all points that their lines share with objects.
/// Spheres are cut by the plane; one that is above it or below has a dashed outline.
pub fn rays(objects: &[(u32, Object)], drawing: &mut Drawing) -> Result<()> {
    let pixels = drawing.pixels;
    let View { position, true_up, .. } = pixels.view;
    let cut = |sphere: &Sphere| {
        let above = (sphere.center - position).dot(true_up);
        let squared = sphere.radius * sphere.radius - above * above;
        let is_cut = squared > 0.0;
        let radius = if is_cut { squared.sqrt() } else { sphere.radius };
        (Sphere { center: sphere.center - true_up * above, radius }, is_cut, String::new())
    };
    let end = plan(objects, drawing, cut)?;
    for (id, object) in objects {
        let Object::Plane(Plane { point, normal, .. }) = object else { continue };
        let across = *normal - true_up * normal.dot(true_up);
        if across == DVec3::ZERO {
            // Nowhere in the plan, or all of it.
            continue;
        }
        let foot = position + across * ((*point - position).dot(*normal) / across.length_squared());
        let along = across.cross(true_up).normalize_or_zero() * end;
        drawing.stroke(&pieces(foot - along, foot + along), "surface", false, VISIBLE);
        drawing.label(foot, &id.to_string(), "", "surface");
    }
    for i in 0..N_RAYS {
        let x = u64::from(pixels.image_width - 1) * i / (N_RAYS - 1);
        let ray = pixels.ray(x as u32, pixels.image_height / 2);
        let at = |t: f64| ray.origin + ray.direction * t;
        let met = objects.iter().flat_map(|(_, object)| meeting(&ray, *object).1);
        let met: Vec<f64> = met.map(|t| t.to_f64()).collect();
        let ends = [f64::min, f64::max].map(|of| met.iter().copied().fold(0.0, of));
        drawing.thin(&ends.map(at), HIDDEN);
        let seen = met.iter().copied().filter(|t| *t > 0.0).reduce(f64::min);
        // One that sees nothing leaves the picture.
        drawing.arrow([at(0.0), at(seen.unwrap_or(2.0 * end))], "given", VISIBLE);
        for t in met {
            drawing.dot(at(t), if Some(t) == seen { "found" } else { "soft" });
        }
    }
    Ok(())
}

/// Draws figure 5: the ray in the middle of the picture, which is the axis, with the points that its line shares with spheres.
/// Each sphere is turned about it into the plane, and so keeps its distance from it.
pub fn discriminants(objects: &[(u32, Object)], drawing: &mut Drawing) -> Result<()> {
    let View { position, forward, right, .. } = drawing.pixels.view;
    let ray = WorldRay { origin: position, direction: forward };
    let foot = |center: DVec3| position + forward * (center - position).dot(forward);
    let turned = |sphere: &Sphere| {
        let foot = foot(sphere.center);
        let center = foot - right * sphere.center.distance(foot);
        let (discriminant, _) = meeting(&ray, Object::Sphere(sphere));
        let sign = [" < 0", "", " > 0"][(1 + discriminant.signum()) as usize];
        (Sphere { center, ..*sphere }, true, format!(": D{}{sign}", told(&discriminant)))
    };
    plan(objects, drawing, turned)?;
    for (_, object) in objects {
        let Object::Sphere(sphere) = object else { continue };
        let (Sphere { center, .. }, ..) = turned(sphere);
        drawing.thin(&[center, foot(center)], VISIBLE);
        for t in meeting(&ray, *object).1 {
            let at = position + forward * t.to_f64();
            drawing.dot(at, "found");
            drawing.label(at, "t", &told(&t), "found");
        }
    }
    Ok(())
}

/// Draws the axis of `t` and the spheres with their ids; gives the `t` at the end of the axis. `place` says where a sphere is, whether
/// that is in the plane, and what is said of it.
fn plan(
    objects: &[(u32, Object)],
    drawing: &mut Drawing,
    place: impl Fn(&Sphere) -> (Sphere, bool, String),
) -> Result<f64> {
    let View { position, forward, right, true_up, .. } = drawing.pixels.view;
    let placed = objects.iter().filter_map(|(id, object)| match object {
        Object::Sphere(sphere) => Some((id, place(sphere))),
        Object::Plane(_) => None,
    });
    let placed: Vec<_> = placed.collect();
    let mut shown: Vec<Sphere> = placed.iter().map(|(_, (circle, ..))| *circle).collect();
    let [least, most] = [-1.0, 1.0].map(|side| {
        let reach =
            |circle: &Sphere| side * (circle.center - position).dot(forward) + circle.radius;
        side * shown.iter().map(reach).fold(0.0, f64::max)
    });
    let free = (most - least) / 20.0;
    let ends = [least - free, most + free];
    shown.extend(ends.map(|t| Sphere { center: position + forward * t, radius: 0.0 }));
    let framing = Framing {
        from: true_up,
        up: -right,
        projection: Projection::Orthographic { height: 1.0 },
        fits_height: true,
        size: [drawing.pixels.image_width, drawing.pixels.image_height],
        margin: MARGIN,
        look_at: None,
        n_turns: 1,
    };
    drawing.pixels.view = View::new(&framing.camera(&shown, &Control::default())?);
    let is_behind = |point: DVec3| (point - position).dot(forward) < 0.0;
    let step = round_step((most - least) / 4.0);
    axes::axis(drawing, "t", [position, forward], ends, step, &is_behind);
    drawing.dot(position, "ink");
    drawing.label(position, "t", " = 0", "ink");
    for (id, (circle, is_in_plane, said)) in placed {
        let outline = outline(&circle, drawing).unwrap_or_default();
        if is_in_plane {
            drawing.surface(&outline);
        }
        drawing.stroke(&outline, "surface", true, &|_| !is_in_plane);
        drawing.dot(circle.center, "surface");
        let top = circle.center - right * circle.radius;
        drawing.label(top, &id.to_string(), &said, "surface");
    }
    Ok(ends[1])
}

/// ` = 24`, or ` ≈ 2.4` where digits are missing.
fn told(number: &QuadraticSurd) -> String {
    let Short { text, rounded } = Short::new(number, DEFAULT_DIGITS);
    format!(" {} {}", if rounded { '≈' } else { '=' }, text.replace('-', "−"))
}

/// The number that decides whether the line of a ray meets an object, `D` or `d·n`, and where it does, exactly.
fn meeting(ray: &WorldRay, object: Object) -> (QuadraticSurd, Vec<QuadraticSurd>) {
    let tape = Tape::default();
    let vector = |name, v: DVec3| tape.vector_of_scene(name, v);
    let (o, d) = (vector("o", ray.origin), vector("d", ray.direction));
    let (deciding, roots) = match object {
        Object::Sphere(sphere) => {
            let equation =
                quadratic(o, d, vector("c", sphere.center), tape.of_scene("r", sphere.radius));
            let roots = match equation.discriminant.signum() {
                -1 => Vec::new(),
                sign => quadratic_roots(equation)[..=sign as usize].to_vec(),
            };
            (equation.discriminant, roots)
        }
        Object::Plane(plane) => {
            let (a, n) = (vector("a", plane.point), vector("n", plane.normal));
            let [numerator, denominator] = plane_quotient(o, d, a, n);
            let is_met = denominator.signum() != 0;
            (denominator, is_met.then(|| numerator / denominator).into_iter().collect())
        }
    };
    (deciding.value(), roots.into_iter().map(|root| root.value()).collect())
}
