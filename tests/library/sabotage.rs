//! The judge of the campaigns notices what it is there for: each of these defects, put into a right
//! result or into a small tracer of its own, is an error to it.

use std::sync::Arc;

use glam::{DVec3, dvec3};
use kugelblitz::exact::visible_root;
use kugelblitz::rays::{Lens, Pixels, View};
use kugelblitz::scene::{Object, Scene};
use kugelblitz::trace::{Hits, Kernel, Level, Ray, Rays, StageCounts};
use kugelblitz_tests::judge::{ExactRays, judge, objects, trace};
use kugelblitz_tests::{plane, scene, sphere};

/// Spheres that touch, coincide and are grazed by rays exactly, and planes; the axis ray meets
/// three objects at the same `t`.
fn world() -> (Arc<Scene>, Rays) {
    let spheres = vec![
        sphere(dvec3(0.0, 0.0, -6.0), 2.0),
        sphere(dvec3(0.0, 0.0, -6.0), 2.0),
        sphere(dvec3(0.0, 1.0, -4.0), 1.0),
        sphere(dvec3(5.0, 1.0, -9.0), 2.5),
        sphere(dvec3(0.0, 0.0, 3.0), 2.0),
        sphere(dvec3(-7.0, 2.0, -9.0), 3.0),
    ];
    let planes =
        vec![plane(dvec3(0.0, -2.0, 0.0), DVec3::Y), plane(dvec3(0.0, -2.0, 1.0), DVec3::Y * 3.0)];
    let view = View {
        position: DVec3::ZERO,
        forward: DVec3::NEG_Z,
        right: DVec3::X,
        true_up: DVec3::Y,
        h: 1.0,
        lens: Lens::Perspective,
    };
    (Arc::new(scene(spheres, planes)), Rays::Pixels(Pixels::whole(view, 65, 49)))
}

fn is_right(scene: &Scene, rays: &Rays, hits: &Hits) -> bool {
    judge(scene, rays, hits, 1).is_ok()
}

#[test]
fn sabotage_of_results_is_noticed() {
    let (scene, rays) = world();
    let hits = trace(&scene, Kernel::Certified, &rays, None);
    let tally = judge(&scene, &rays, &hits, 1).unwrap();
    assert!(tally.normals == tally.hits && tally.counts.exact > 0, "{tally:?}");
    let center = rays.len() / 2;
    type Sabotage = (&'static str, fn(&mut Hits, usize));
    let sabotages: [Sabotage; 10] = [
        ("id", |hits, i| hits.id[i] = 4),
        ("missed", |hits, i| (hits.id[i], hits.t[i]) = (0, f32::INFINITY)),
        ("t one ulp up", |hits, i| hits.t[i] = hits.t[i].next_up()),
        ("t one ulp down", |hits, i| hits.t[i] = hits.t[i].next_down()),
        ("t of the other sign", |hits, i| hits.t[i] = -hits.t[i]),
        ("t not a number", |hits, i| hits.t[i] = f32::NAN),
        ("normal turned", |hits, i| hits.normal[i][2] = -hits.normal[i][2]),
        ("normal off by 2⁻²²", |hits, i| hits.normal[i][0] += 2f32.powi(-22)),
        ("normal not a number", |hits, i| hits.normal[i][0] = f32::NAN),
        ("a ray not counted", |hits, _| hits.counts.f32 -= 1),
    ];
    for (what, apply) in sabotages {
        let mut hits = hits.clone();
        apply(&mut hits, center);
        assert!(!is_right(&scene, &rays, &hits), "{what} is not noticed");
    }
    let mut short = hits.clone();
    short.id.pop();
    assert!(!is_right(&scene, &rays, &short), "a missing ray is not noticed");
}

/// A sphere so far away that f32 leaves a tenth of the picture open, and one that is grazed.
fn far_world() -> (Arc<Scene>, Rays) {
    let (_, rays) = world();
    let Rays::Pixels(mut pixels) = rays else { unreachable!("a picture") };
    pixels.view.h = 2e-5;
    let spheres = vec![sphere(dvec3(0.0, 0.5, -1e5), 1.0), sphere(dvec3(0.0, 1.0, -9e4), 1.0)];
    (Arc::new(scene(spheres, vec![])), Rays::Pixels(pixels))
}

#[test]
fn sabotage_dropping_the_undecided_list_is_noticed() {
    for (level, (scene, rays)) in [(Level::F64, far_world()), (Level::Exact, world())] {
        let hits = trace(&scene, Kernel::Certified, &rays, None);
        judge(&scene, &rays, &hits, 1).unwrap_or_else(|what| panic!("{what}"));
        let mut dropped = hits.clone();
        let of_stage: Vec<usize> =
            (0..rays.len()).filter(|&i| hits.level[i] == level as u8 && hits.id[i] != 0).collect();
        assert!(!of_stage.is_empty(), "no ray was left to {level:?}");
        for i in of_stage {
            (dropped.id[i], dropped.t[i]) = (0, f32::INFINITY);
        }
        assert!(!is_right(&scene, &rays, &dropped), "dropped at {level:?}");
    }
}

/// A plane along the ray but for one part in 2⁶⁰, hidden where f64 adds from left to right.
#[test]
fn sabotage_f64_in_place_of_exact_arithmetic_is_noticed() {
    let wall = plane(dvec3(0.0, 0.0, 1.0), dvec3(1.0, 1.0, 1.0));
    let direction = dvec3(1.0, 2f64.powi(-60), -1.0);
    let (scene, ray) = (scene(vec![], vec![wall]), Ray { origin: DVec3::ZERO, direction });
    let (scene, rays) = (Arc::new(scene), Rays::List(vec![ray]));
    for (kernel, right) in [(Kernel::Certified, true), (Kernel::Double, false)] {
        let hits = trace(&scene, kernel, &rays, None);
        assert_eq!(is_right(&scene, &rays, &hits), right, "{}", kernel.name());
    }
}

/// What is done wrongly by [`Tiny`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Defect {
    None,
    /// Of equal roots the last one wins.
    NoTieRule,
    /// `b² + ac` for `b² − ac`.
    SignInDiscriminant,
    /// The far root for the near one.
    SignOfRoot,
    /// `c + o` for `c − o`, where it matters: the plane's point mirrored.
    SignOfOffset,
    /// `t < 0` is seen as well.
    Behind,
    /// The normal faces away.
    SignOfNormal,
    /// Tangent rays miss.
    NoTangents,
}

/// A tracer in plain f64, right on [`world`].
struct Tiny(Defect);

impl Tiny {
    /// The root nearest before the eye, 0 for none.
    fn root(&self, object: Object, d: DVec3) -> f64 {
        let Tiny(defect) = *self;
        match object {
            Object::Sphere(sphere) => {
                let c = sphere.center;
                let (a, b) = (d.dot(d), d.dot(c));
                let k = c.dot(c) - sphere.radius * sphere.radius;
                let minus = if defect == Defect::SignInDiscriminant { -1.0 } else { 1.0 };
                let discriminant = b * b - minus * a * k;
                if discriminant < 0.0 || (discriminant == 0.0 && defect == Defect::NoTangents) {
                    return 0.0;
                }
                let h = discriminant.sqrt();
                let near = if defect == Defect::SignOfRoot { b + h } else { k / (b + h) * a };
                near / a
            }
            Object::Plane(plane) => {
                let flip = if defect == Defect::SignOfOffset { -1.0 } else { 1.0 };
                let t = flip * plane.point.dot(plane.normal) / d.dot(plane.normal);
                if t.is_finite() { t } else { 0.0 }
            }
        }
    }

    fn trace(&self, scene: &Scene, pixels: &Pixels) -> Hits {
        let Tiny(defect) = *self;
        let n = pixels.len();
        let mut hits = Hits {
            id: vec![0; n],
            t: vec![f32::INFINITY; n],
            normal: vec![[0.0; 3]; n],
            level: vec![0; n],
            counts: StageCounts { f32: n as u64, ..StageCounts::default() },
        };
        for i in 0..n {
            let (x, y) = pixels.xy(i);
            let d = pixels.direction(x, y);
            let mut best = (f64::INFINITY, 0);
            for id in 1..=scene.n_objects() as u32 {
                let t = self.root(scene.object(id).unwrap(), d);
                let t = if defect == Defect::Behind { t.abs() } else { t };
                let wins = t < best.0 || (t == best.0 && defect == Defect::NoTieRule);
                if t > 0.0 && wins {
                    best = (t, id);
                }
            }
            let (t, id) = best;
            let Some(object) = scene.object(id) else { continue };
            let outward = match object {
                Object::Sphere(sphere) => (d * t - sphere.center) / sphere.radius,
                Object::Plane(plane) => plane.normal.normalize(),
            };
            let away = outward.dot(d) > 0.0;
            let normal = if away != (defect == Defect::SignOfNormal) { -outward } else { outward };
            hits.id[i] = id;
            hits.t[i] = t as f32;
            hits.normal[i] = normal.as_vec3().to_array();
        }
        hits
    }
}

/// No ray of it runs exactly along an axis.
fn even_pixels() -> Pixels {
    let (_, rays) = world();
    let Rays::Pixels(pixels) = rays else { unreachable!("a picture") };
    Pixels { image_width: 64, image_height: 64, width: 64, height: 64, ..pixels }
}

#[test]
fn sabotage_one_sign_or_the_tie_rule_is_noticed() {
    let (pixels, (scene, _)) = (even_pixels(), world());
    let rays = Rays::Pixels(pixels);
    let right = Tiny(Defect::None).trace(&scene, &pixels);
    judge(&scene, &rays, &right, 1).unwrap_or_else(|what| panic!("{what}"));
    for defect in [
        Defect::NoTieRule,
        Defect::SignInDiscriminant,
        Defect::SignOfRoot,
        Defect::SignOfOffset,
        Defect::Behind,
        Defect::SignOfNormal,
    ] {
        let wrong = Tiny(defect).trace(&scene, &pixels);
        assert!(!is_right(&scene, &rays, &wrong), "{defect:?} is not noticed");
    }
}

/// One exactly tangent ray, along the axis of an odd picture.
#[test]
fn sabotage_missing_tangents_is_noticed() {
    let (_, rays) = world();
    let Rays::Pixels(pixels) = rays else { unreachable!("a picture") };
    let pixels = Pixels { image_width: 1, image_height: 1, width: 1, height: 1, ..pixels };
    let scene = scene(vec![sphere(dvec3(0.0, 1.0, -4.0), 1.0)], vec![]);
    let rays = Rays::Pixels(pixels);
    let right = Tiny(Defect::None).trace(&scene, &pixels);
    judge(&scene, &rays, &right, 1).unwrap_or_else(|what| panic!("{what}"));
    let wrong = Tiny(Defect::NoTangents).trace(&scene, &pixels);
    assert!(!is_right(&scene, &rays, &wrong));
}

/// Equal roots of different objects are in the world, and the lowest id wins each.
#[test]
fn the_world_has_ties_of_different_objects() {
    let (scene, rays) = world();
    let (objects, exact_rays) = (objects(&scene), ExactRays::new(&rays));
    let hits = trace(&scene, Kernel::Certified, &rays, None);
    let mut n_ties = [0; 3];
    for i in 0..rays.len() {
        let ray = exact_rays.ray(i);
        let roots: Vec<_> = objects
            .iter()
            .filter_map(|(id, shape)| Some((*id, visible_root(&ray, shape)?.0)))
            .collect();
        let Some(first) = roots.iter().min_by(|a, b| a.1.cmp(&b.1).then(a.0.cmp(&b.0))) else {
            continue;
        };
        let equal = roots.iter().filter(|(_, root)| root.cmp(&first.1).is_eq()).count();
        assert_eq!(hits.id[i], first.0, "ray {i}");
        n_ties[equal.min(3) - 1] += 1;
    }
    assert!(n_ties.iter().all(|&n| n > 0), "{n_ties:?}");
}
