//! Clouds that the program makes up are as their distributions are described, and in view. What the command answers stands in
//! `tests/answers/generate.txt`.

use glam::DVec3;
use kugelblitz::Control;
use kugelblitz::Error;
use kugelblitz::generate::{Distribution, Recipe, write_cloud, write_scene};
use kugelblitz::output::{self, OutputFile};
use kugelblitz::rays::View;
use kugelblitz::scene::{Projection, Scene, Sphere, read_scene};

/// The scene of a recipe, which is the same in memory and in files.
fn made(distribution: Distribution, count: u64, seed: u64) -> Scene {
    let (recipe, control) = (Recipe { distribution, count, seed }, Control::default());
    let folder = tempfile::tempdir().unwrap();
    let [cloud, scene] = ["cloud.npy", "scene.toml"].map(|name| folder.path().join(name));
    let mut files = [&cloud, &scene].map(|path| OutputFile::create(path, false).unwrap());
    write_cloud(&mut files[0], &recipe, &control).unwrap();
    write_scene(&mut files[1], &cloud, &recipe).unwrap();
    output::commit(files, &control).unwrap();
    let (read, made) = (read_scene(&scene).unwrap(), recipe.scene(&control).unwrap());
    assert!(read.spheres == made.spheres, "{}", distribution.name());
    assert!([&read, &made].iter().all(|scene| scene.camera == Some(recipe.camera())));
    let cancelled = Control::default();
    cancelled.cancel();
    assert!(matches!(recipe.scene(&cancelled), Err(Error::Interrupted)));
    read
}

#[test]
fn every_sphere_is_in_view() {
    for distribution in Distribution::ALL {
        for count in [1, 1000] {
            let scene = made(distribution, count, 1);
            let view = View::new(scene.camera.as_ref().unwrap());
            let aspect = 16.0 / 9.0;
            for (tangent, across) in [(view.h, view.true_up), (view.h * aspect, view.right)] {
                // A plane through the eye along an edge of the picture: its distance from the
                // middle of a sphere that is wholly inside is at least the radius.
                for side in [-1.0, 1.0] {
                    let inwards = (tangent * view.forward + side * across).normalize();
                    for Sphere { center, radius } in scene.spheres.iter() {
                        let distance = (*center - view.position).dot(inwards);
                        assert!(distance >= *radius, "{} {count}", distribution.name());
                    }
                }
            }
        }
    }
}

/// Every reader of a measurement relies on this: N spheres evenly in the cube of side 1.
#[test]
fn uniform_is_the_unit_cube() {
    let scene = made(Distribution::Uniform, 27_000, 2);
    let mut octants = [0; 8];
    for Sphere { center, radius } in scene.spheres.iter() {
        assert!(center.abs().max_element() <= 0.5);
        assert_eq!(*radius, 0.3 / 30.0);
        let index = center.to_array().iter().fold(0, |i, &x| 2 * i + usize::from(x > 0.0));
        octants[index] += 1;
    }
    // Binomial with a mean of 3375 and a standard deviation of 54: five of them either way.
    assert!(octants.iter().all(|n| (3105..3645).contains(n)), "{octants:?}");
    let camera = scene.camera.unwrap();
    let projection = Projection::Perspective { fov_degrees: 40.0 };
    assert_eq!((camera.look_at, camera.projection), (DVec3::ZERO, projection));
}

/// Distances and radii in whole numbers: no rounding can make a gap or an overlap.
#[test]
fn spheres_of_a_lattice_touch_and_do_not_overlap() {
    let scene = made(Distribution::Lattice, 3 * 5 * 5 + 5 + 2, 0);
    let whole = |x: f64| {
        assert_eq!(x.fract(), 0.0);
        x as i64
    };
    let spheres: Vec<_> =
        scene.spheres.iter().map(|s| (s.center.to_array().map(whole), whole(s.radius))).collect();
    let mut n_touching = 0;
    for (i, (a, r_a)) in spheres.iter().enumerate() {
        for (b, r_b) in &spheres[..i] {
            let squared: i64 = (0..3).map(|axis| (a[axis] - b[axis]).pow(2)).sum();
            assert!(squared >= (r_a + r_b).pow(2), "{a:?} {b:?}");
            n_touching += usize::from(squared == (r_a + r_b).pow(2));
        }
    }
    // Three whole layers of 5 × 5 have 2·20 contacts each and 2·25 between them; above lie a whole
    // row with 4 and two more spheres with 1 and 2 towards the row, and each stands on one below.
    assert_eq!(n_touching, 3 * 40 + 2 * 25 + 4 + 1 + 2 + 7);
}

/// Spheres of a heap touch the floor or lie on four others, and none reaches into another, up to the
/// rounding of √2.
#[test]
fn a_packing_stands() {
    let scene = made(Distribution::Packing, 1500, 3);
    let mut highest: f64 = 0.0;
    for a in scene.spheres.iter() {
        assert_eq!(a.radius, 1.0);
        highest = highest.max(a.center.y);
        let near = scene.spheres.iter().filter(|b| b.center != a.center);
        let gaps = near.map(|b| (b.center.distance(a.center) - 2.0, b.center.y < a.center.y));
        let (mut n_below, mut n_beside) = (0, 0);
        for (gap, is_below) in gaps {
            assert!(gap > -1e-14, "{gap}");
            if gap < 1e-14 {
                *if is_below { &mut n_below } else { &mut n_beside } += 1;
            }
        }
        assert!(n_beside <= 8);
        assert_eq!(n_below, if a.center.y == 1.0 { 0 } else { 4 }, "{:?}", a.center);
    }
    assert!(highest > 8.0, "{highest}");
}
