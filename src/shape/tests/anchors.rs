//! Surfaces from anchors against exact ones.

use super::*;
use crate::exact::ExactRays;
use crate::rays::{Frame, Pixels, Rays, View};
use crate::scene::{Camera, Projection};

/// How many surfaces of spheres with anchors are known, of `n` that pixels hit, and of how many points and normals are off by more
/// than this share of what they may be.
fn off_anchors<R: Real<One = f32>>(n: usize, share: f64, number: impl Fn(R) -> f64) -> [usize; 3] {
    let mut random = Random(SplitMix::new(12));
    let [mut known, mut of_point, mut of_normal] = [0; 3];
    for k in 0..n {
        let radius = random.size(6.0);
        let away = radius * (2.0 + 17.0 * random.0.unit()).exp2();
        let position = random.vector() * random.size(3.0) * radius;
        let center = position + random.vector().normalize() * away;
        let aside = random.vector() * (0.5 * away);
        // From a few pixels for the sphere to some of it for a pixel.
        let share_of_picture = (-5.0 * random.0.unit()).exp2();
        let projection = match k % 2 {
            0 => {
                let fov_degrees = (3.0 * radius / away / share_of_picture).atan().to_degrees();
                Projection::Perspective { fov_degrees: fov_degrees.clamp(1e-3, 100.0) }
            }
            _ => Projection::Orthographic { height: 4.0 * radius / share_of_picture },
        };
        let aside = if k % 4 < 2 { aside } else { aside * (radius / away) };
        let mut camera = Camera { projection, ..Camera::new(position, center + aside) };
        let mut sphere = Sphere { center, radius };
        if k % 8 == 7 {
            // Parallel rays that start in the sphere or not far before it, far from the middle of the picture.
            let (aside, away) =
                ((center - position).normalize(), radius * (5.0 + 60.0 * random.0.unit()));
            let forward = aside.cross(random.vector()).normalize();
            sphere.center = position + aside * away + forward * (4.0 * radius * random.number());
            let projection = Projection::Orthographic { height: 2.5 * away };
            camera = Camera { projection, ..Camera::new(position, position + forward * away) };
        }
        let pixels = Pixels::whole(View::new(&camera), 321, 243);
        let Sphere { center, radius } = sphere;
        let Some(at) = pixels.seen_at(center + random.vector() * (0.8 * radius)) else { continue };
        let [x, y] = [at.x, at.y].map(|at| at as u32);
        let (anchors, camera) = (Anchors::new(&pixels), Frame::<f32>::of_pixels(&pixels));
        let (seen, anchor) = anchors.of(&sphere);
        if x >= 321 || y >= 243 || anchor.base.0 == [0.0; 3] {
            continue;
        }
        let rays = Rays::Pixels(pixels);
        let exact = ExactRays::from(&rays).ray((y * 321 + x) as usize);
        let Some(hit) = visible_hit(&exact, 1, sphere.in_scene()) else { continue };
        let (i, j) = pixels.offset2(x, y);
        let steps = [i, j].map(|steps| R::splat(steps as f32));
        let ray = camera.ray(steps[0], steps[1]);
        let (seen, anchor) = (seen.round::<f32>().map(R::splat), anchor.round().map(R::splat));
        let here = anchor.ray(camera.steps(), steps, &ray);
        let eye = RayOrigin::of_pixels(&pixels, Footprint::default(), f32::UNIT);
        let lengths = SurfaceErrorTerms::new(&eye, pixels.longest_direction()).map(R::splat);
        let found = anchor.to_eye(SphereRecord::surface(&seen, &here, &lengths));
        let error = number(found.point_error);
        if !(error < f32::KNOWN) {
            continue;
        }
        known += 1;
        let point = position + DVec3::from_array(found.point.0.map(&number));
        let error = error * share + 2.0 * f64::UNIT * (point.length() + position.length());
        let is_there = ExactPoint::new(&exact, &hit).is_within(error, point);
        of_point += usize::from(is_there != Some(true));
        let normal = hit.normal(&exact).unwrap().map(|x| x.to_f64());
        let off: DVec3 = DVec3::from_array(found.normal.0.map(&number)) - DVec3::from_array(normal);
        of_normal += usize::from(off.length() > number(found.normal_error) * share);
    }
    [known, of_point, of_normal]
}

#[test]
fn surfaces_from_anchors_are_within_their_bounds() {
    for [known, wrong @ ..] in [
        off_anchors::<f32>(20_000, 1.0, f64::from),
        off_anchors::<Shaky>(20_000, 1.0, |x| x.0.into()),
        off_anchors::<Finite>(20_000, 1.0, |x| x.0.into()),
    ] {
        println!("{known} known, wrong {wrong:?}");
        assert!(wrong == [0; 2] && known > 5000, "{wrong:?} of {known}");
    }
}

#[test]
fn sabotage_smaller_bounds_from_anchors_are_seen() {
    let [known, wrong @ ..] = off_anchors::<Shaky>(40_000, 0.06, |x| x.0.into());
    println!("{known} known, wrong {wrong:?}");
    assert!(wrong.iter().all(|&n| n > 0), "{wrong:?} of {known}");
}
