//! The exact module: the numbers of dashu, and single facts. The matrix covers visibility.

use glam::{DVec3, dvec3};
use kugelblitz::exact::{Dyadic, ExactRay, Side, nearest, real, signum};
use kugelblitz::query::WorldRay;
use kugelblitz::scene::{Color, Object, Plane, Sphere};

/// Would notice a version of dashu that rounds.
#[test]
fn sums_and_products_are_exact() {
    let x = |value: f64| real(value).unwrap();
    let zero = Dyadic::zero();
    let (large, small) = (x(2f64.powi(1000)), x(2f64.powi(-1000)));
    let sum = &large + &small;
    assert_eq!(&sum - &large, small);
    assert_eq!(&sum - &small, large);
    assert_eq!(&(&sum * &sum) - &(&large * &large), {
        let cross = &large * &small;
        &(&cross + &cross) + &(&small * &small)
    });
    // Subnormal, largest and signed zeros.
    let (tiny, huge) = (x(f64::from_bits(1)), x(f64::MAX));
    assert_eq!(&(&(&huge + &tiny) - &huge), &tiny);
    assert_eq!(&(&(&huge * &tiny) * &(&huge * &tiny)), &(&(&huge * &huge) * &(&tiny * &tiny)));
    assert_eq!(signum(&x(-0.0)), 0);
    assert_eq!(&x(-0.0) + &tiny, tiny);
    assert_eq!(&x(-0.0) * &tiny, zero);
    assert_eq!(signum(&(&x(-0.0) * &tiny)), 0);
    assert!(real(f64::NAN).is_none() && real(f64::INFINITY).is_none());
}

fn sphere(center: DVec3, radius: f64) -> Sphere {
    Sphere { center, radius }
}

fn plane(point: DVec3, normal: DVec3) -> Plane {
    Plane { name: None, point, normal, color: Color::BLACK }
}

fn list(origin: DVec3, direction: DVec3) -> ExactRay {
    ExactRay::new(&WorldRay { origin, direction })
}

#[test]
fn degenerate_input_is_a_miss() {
    let is_missed = |ray: &ExactRay, object: Object| nearest(ray, [(1, object)]).is_none();
    let far = sphere(dvec3(0.0, 0.0, 5.0), 1.0);
    let object = Object::Sphere(&far);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let z = dvec3(0.0, 0.0, 1.0);
        assert!(is_missed(&list(dvec3(bad, 0.0, 0.0), z), object));
        assert!(is_missed(&list(DVec3::ZERO, dvec3(0.0, bad, 1.0)), object));
        let ray = list(DVec3::ZERO, z);
        assert!(is_missed(&ray, Object::Sphere(&sphere(z * bad, 1.0))));
        assert!(is_missed(&ray, Object::Sphere(&sphere(z, bad))));
        assert!(is_missed(&ray, Object::Plane(&plane(z, dvec3(bad, 0.0, 1.0)))));
    }
    assert!(is_missed(&list(DVec3::ZERO, DVec3::ZERO), object));
    let ray = list(DVec3::ZERO, dvec3(0.0, 0.0, 1.0));
    assert!(is_missed(&ray, Object::Plane(&plane(dvec3(0.0, 0.0, 1.0), DVec3::ZERO))));
    assert!(is_missed(&ray, Object::Sphere(&sphere(dvec3(0.0, 0.0, 5.0), 0.0))));
}

#[test]
fn t_beyond_f32_is_a_miss_and_below_it_the_smallest() {
    let ray = list(DVec3::ZERO, dvec3(0.0, 0.0, 1.0));
    let at = |z: f64| {
        let plane = plane(dvec3(0.0, 0.0, z), dvec3(0.0, 0.0, 1.0));
        nearest(&ray, [(7, Object::Plane(&plane))]).map(|hit| (hit.t_f32(), hit.t_f64()))
    };
    let edge = 2f64.powi(128) - 2f64.powi(103);
    assert!(at(edge).is_none());
    assert_eq!(at(edge.next_down()).unwrap().0, f32::MAX);
    let tiny = f64::from_bits(1);
    assert_eq!(at(tiny), Some((f32::from_bits(1), tiny)));
    // Ties to even in the subnormal range: 2.5 and 3.5 of the smallest.
    let unit = 2f64.powi(-149);
    assert_eq!(at(2.5 * unit).unwrap().0.to_bits(), 2);
    assert_eq!(at(3.5 * unit).unwrap().0.to_bits(), 4);
}

#[test]
fn sides() {
    let z = dvec3(0.0, 0.0, 1.0);
    let ray = list(DVec3::ZERO, z);
    let side = |object: Object| {
        let hit = nearest(&ray, [(1, object)]).unwrap();
        (hit.side, hit.normal_f32(&ray))
    };
    let of_sphere = |center, radius| side(Object::Sphere(&sphere(center, radius)));
    let of_plane = |point, normal| side(Object::Plane(&plane(point, normal)));
    let toward = [0.0, 0.0, -1.0];
    assert_eq!(of_sphere(z * 5.0, 1.0), (Side::Front, toward));
    assert_eq!(of_sphere(z * 5.0, -1.0), (Side::Front, toward));
    assert_eq!(of_sphere(DVec3::ZERO, 1.0), (Side::Back, toward));
    // From the surface through the sphere, and tangent to it.
    assert_eq!(of_sphere(z, 1.0), (Side::Back, toward));
    assert_eq!(of_sphere(dvec3(3.0, 0.0, 5.0), 3.0), (Side::Front, [-1.0, 0.0, 0.0]));
    assert_eq!(of_plane(z, z), (Side::Back, toward));
    assert_eq!(of_plane(z, z * -7.0), (Side::Front, toward));
}
