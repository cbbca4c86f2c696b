//! Other renderers' results against exact arithmetic, two pictures against each other, and what a picture
//! says of itself. Each comparison is fed something wrong, and must see it.

use std::path::Path;
use std::sync::Arc;

use kugelblitz::Session;
use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::glam::DVec3;
use kugelblitz::picture::{Channel, Image, Samples};
use kugelblitz::rays::{Pixels, Rays, View};
use kugelblitz::scene::{Scene, read_scene};
use kugelblitz::trace::Kernel;
use kugelblitz_judge::judge::{
    self, Allowed, Conventions, Judged, NormalSide, NormalSpace, Quantity, truth,
};
use kugelblitz_judge::verify::Truth;

use crate::program::scene_file as scene;

const SIZE: [u32; 2] = [96, 54];

/// A scene, its exact results, and honest claims about them as this program writes them.
struct Case {
    scene: Arc<Scene>,
    rays: Rays,
    view: View,
    truth: Truth,
    honest: Image,
}

impl Case {
    fn new(name: &str) -> Case {
        let scene = Arc::new(read_scene(Path::new(&scene(name))).unwrap());
        let view = View::new(scene.camera.as_ref().unwrap());
        let rays = Rays::Pixels(Pixels::whole(view, SIZE[0], SIZE[1]));
        let mut session = Session::new(Arc::clone(&scene), Device::Cpu, Kernel::Certified);
        let truth = truth(&mut session, &rays, &Control::default()).unwrap();
        let t = truth.t.iter().map(|&t| t as f32).collect();
        let normal = |axis: usize| truth.normal.iter().map(|n| n[axis] as f32).collect();
        let channels = [
            ("id", Samples::U32(truth.id.clone())),
            ("Z", Samples::F32(t)),
            ("N.X", Samples::F32(normal(0))),
            ("N.Y", Samples::F32(normal(1))),
            ("N.Z", Samples::F32(normal(2))),
        ];
        let [width, height] = SIZE.map(|n| n as usize);
        let honest = image(width, height, channels);
        Case { scene, rays, view, truth, honest }
    }

    fn pixels(&self) -> &Pixels {
        match &self.rays {
            Rays::Pixels(pixels) => pixels,
            Rays::List(_) => panic!("a picture"),
        }
    }

    fn judged(&self, image: &Image, conventions: &Conventions, allow: &str) -> Judged {
        let allowed = Allowed::of_rays(allow).unwrap();
        let (scene, rays) = (Arc::clone(&self.scene), self.rays.clone());
        let case = judge::Case::new(scene, rays, image.clone(), conventions.clone(), allowed);
        Judged::new(case.unwrap(), self.truth.clone()).unwrap()
    }

    /// What is not right by these rules.
    fn broken(&self, image: &Image, conventions: &Conventions, allow: &str) -> Vec<String> {
        self.judged(image, conventions, allow).broken
    }

    /// The rays that are more wrong than they may be, of which `ray` is one: as they are counted, and as they are
    /// told one by one.
    fn wrong(&self, image: &Image, ray: usize) -> Vec<usize> {
        let judged = self.judged(image, &Conventions::default(), "");
        let told = |i: &usize| !judged.of_ray(*i).is_empty();
        let wrong: Vec<usize> = (0..self.rays.len()).filter(told).collect();
        assert_eq!(wrong, judged.wrong_rays().collect::<Vec<_>>());
        assert_eq!(judged.worst(1, |_| None), judged.of_ray(ray));
        wrong
    }

    fn hint(&self, image: &Image) -> Option<String> {
        self.judged(image, &Conventions::default(), "").hint
    }

    /// A pixel that sees an object, away from silhouettes or at one.
    fn pixel(&self, at_silhouette: bool) -> usize {
        let judged = self.judged(&self.honest, &Conventions::default(), "");
        let is_at = |i: usize| judged.errors.is_at_silhouette[i];
        let is_wanted = |&i: &usize| self.truth.id[i] > 0 && is_at(i) == at_silhouette;
        // Not the first, which lies at the border.
        (0..self.truth.id.len()).filter(is_wanted).nth(50).unwrap()
    }

    /// The honest claims with some channels replaced.
    fn with<const N: usize>(&self, channels: [(&str, Samples); N]) -> Image {
        image(self.honest.width, self.honest.height, channels)
    }
}

fn image<const N: usize>(width: usize, height: usize, channels: [(&str, Samples); N]) -> Image {
    let channels = channels.map(|(name, samples)| Channel { name: name.into(), samples }).into();
    Image { format: "OpenEXR", width, height, whole: [width, height], channels, ..Image::default() }
}

fn channel<'a>(image: &'a mut Image, name: &str) -> &'a mut Samples {
    &mut image.channels.iter_mut().find(|channel| channel.name == name).unwrap().samples
}

fn ids(image: &mut Image) -> &mut Vec<u32> {
    match channel(image, "id") {
        Samples::U32(ids) => ids,
        _ => panic!("ids"),
    }
}

fn floats<'a>(image: &'a mut Image, name: &str) -> &'a mut Vec<f32> {
    match channel(image, name) {
        Samples::F32(numbers) => numbers,
        _ => panic!("{name}"),
    }
}

#[test]
fn honest_claims_are_right_and_each_wrong_one_is_seen() {
    let own = Conventions::default();
    for name in ["figure1", "inside", "orthographic"] {
        let case = Case::new(name);
        assert_eq!(case.broken(&case.honest, &own, ""), [""; 0], "{name}");
        let inner = case.pixel(false);
        type Sabotage = (&'static str, &'static str, fn(&mut Image, usize));
        let sabotages: [Sabotage; 6] = [
            ("id", "ids away from silhouettes", |image, i| ids(image)[i] += 1),
            ("a miss", "ids away from silhouettes", |image, i| ids(image)[i] = 0),
            ("t", "t is off", |image, i| {
                let t = &mut floats(image, "Z")[i];
                *t = t.next_up();
            }),
            ("NaN", "t is off by ∞", |image, i| floats(image, "Z")[i] = f32::NAN),
            ("a normal's bits", "a normal is off", |image, i| {
                for (name, step) in [("N.X", 1e-6), ("N.Y", -1e-6), ("N.Z", 1e-6)] {
                    floats(image, name)[i] += step;
                }
            }),
            ("its direction", "a normal is off by 180", |image, i| {
                for name in ["N.X", "N.Y", "N.Z"] {
                    floats(image, name)[i] *= -1.0;
                }
            }),
        ];
        for (what, words, spoil) in sabotages {
            let mut spoiled = case.honest.clone();
            spoil(&mut spoiled, inner);
            let broken = case.broken(&spoiled, &own, "");
            assert!(broken.len() == 1 && broken[0].contains(words), "{name}, {what}: {broken:?}");
            assert_eq!(case.broken(&spoiled, &own, "ids=1,t=any,normal=any"), [""; 0], "{what}");
            assert_eq!(case.wrong(&spoiled, inner), [inner], "{name}, {what}");
        }
    }
}

/// A result too few, and a picture of another size, are no results of these rays.
#[test]
fn a_missing_row_is_refused() {
    let case = Case::new("figure1");
    let mut short = case.honest.clone();
    short.height -= 1;
    let allowed = Allowed::of_rays("ids=any,t=any,normal=any").unwrap();
    let (scene, rays) = (Arc::clone(&case.scene), case.rays.clone());
    let refused = judge::Case::new(scene, rays, short, Conventions::default(), allowed.clone());
    assert!(refused.is_err_and(|error| error.to_string().contains("give one for each")));
    let (scene, rays) = (Arc::clone(&case.scene), case.rays.clone());
    let honest = judge::Case::new(scene, rays, case.honest, Conventions::default(), allowed);
    assert!(Judged::new(honest.unwrap(), Truth::default()).is_err());
}

#[test]
fn wrong_ids_at_silhouettes_are_counted_there() {
    let case = Case::new("figure1");
    for at_silhouette in [false, true] {
        let mut spoiled = case.honest.clone();
        ids(&mut spoiled)[case.pixel(at_silhouette)] = 7000;
        let errors = case.judged(&spoiled, &Conventions::default(), "").errors;
        let wrong = [errors.away.wrong_ids, errors.silhouettes.wrong_ids];
        assert_eq!(wrong, if at_silhouette { [0, 1] } else { [1, 0] });
        let rays = errors.away.rays + errors.silhouettes.rays;
        assert_eq!(rays, u64::from(SIZE[0] * SIZE[1]));
        let broken = |allow| case.broken(&spoiled, &Conventions::default(), allow).len();
        assert_eq!(broken("ids=0,silhouettes=1"), usize::from(!at_silhouette));
        assert_eq!(broken("ids=1,silhouettes=0"), usize::from(at_silhouette));
    }
}

/// The same claims told otherwise are right by the conventions that say so, wrong without, and the hint
/// names the options.
#[test]
fn conventions_of_others_are_understood() {
    let case = Case::new("figure1");
    let pixels = *case.pixels();
    let lengths: Vec<f64> = (0..pixels.len())
        .map(|i| {
            let (x, y) = pixels.xy(i);
            pixels.direction(x, y).length()
        })
        .collect();
    let (t, id, own) = (&case.truth.t, &case.truth.id, Conventions::default());
    let as_t = |number: &dyn Fn(usize) -> f64| Samples::F64((0..t.len()).map(number).collect());
    let depth = |samples| case.with([("Z", samples)]);
    let z =
        |near: f64, far: f64| as_t(&move |i| (1.0 / near - 1.0 / t[i]) / (1.0 / near - 1.0 / far));
    let mut turned = case.honest.clone();
    turned.turn_over();
    let of_view = |axis: DVec3| {
        let parts = case.truth.normal.iter().map(|&n| DVec3::from(n).dot(axis) as f32);
        Samples::F32(parts.collect())
    };
    let View { right, true_up, forward, .. } = case.view;
    let in_camera =
        case.with([("N.X", of_view(right)), ("N.Y", of_view(true_up)), ("N.Z", of_view(-forward))]);
    let from_0 = id.iter().map(|&id| id.wrapping_sub(1)).collect();
    let signed = id.iter().map(|&id| i64::from(id) - 1).collect();
    let near_far = |near, far| Conventions { near_far: Some([near, far]), ..own.clone() };
    let as_distance = Conventions { quantities: vec![Quantity::Distance], ..own.clone() };
    let cases = [
        ("distance", depth(as_t(&|i| t[i] * lengths[i])), as_distance, Some("--as distance")),
        (
            "Embree's ids",
            case.with([("id", Samples::U32(from_0))]),
            Conventions { id_offset: 1, ..own.clone() },
            Some("--id-offset 1"),
        ),
        (
            "signed ids",
            case.with([("id", Samples::I64(signed))]),
            Conventions { id_offset: 1, ..own.clone() },
            Some("--id-offset 1"),
        ),
        (
            "rows from below",
            turned,
            Conventions { rows_from_below: true, ..own.clone() },
            Some("--rows-from-below"),
        ),
        (
            "the camera's axes",
            in_camera,
            Conventions { normal_space: NormalSpace::Camera, ..own.clone() },
            Some("--normal-space camera"),
        ),
        (
            "millimetres",
            depth(as_t(&|i| t[i] * 1000.0)),
            Conventions { scale: 0.001, ..own.clone() },
            None,
        ),
        ("a z-buffer", depth(z(0.5, 200.0)), near_far(0.5, 200.0), None),
        ("a reversed one", depth(z(200.0, 0.5)), near_far(200.0, 0.5), None),
        ("an endless one", depth(z(0.5, f64::INFINITY)), near_far(0.5, f64::INFINITY), None),
    ];
    for (what, claims, conventions, options) in cases {
        // What is beyond the far plane is not there.
        let is_z = conventions.near_far.is_some();
        let allow = if is_z { "ids=any,t=1e-5" } else { "normal=1e-4,t=0.51ulp" };
        assert_eq!(case.broken(&claims, &conventions, allow), [""; 0], "{what}");
        assert_ne!(case.broken(&claims, &own, allow), [""; 0], "{what}");
        if options.is_some() {
            assert_eq!(case.hint(&claims).as_deref(), options, "{what}");
        }
    }
    assert_eq!(case.hint(&case.honest), None);
}

#[test]
fn normals_out_of_a_sphere_are_turned_inside_it() {
    let case = Case::new("inside");
    assert!(case.truth.is_back.contains(&true));
    let outward = |axis: usize| {
        let normals = case.truth.normal.iter().zip(&case.truth.is_back);
        Samples::F32(
            normals
                .map(|(n, &is_back)| n[axis] as f32 * if is_back { -1.0 } else { 1.0 })
                .collect(),
        )
    };
    let claims = case.with([("N.X", outward(0)), ("N.Y", outward(1)), ("N.Z", outward(2))]);
    let of = |normal_side| {
        case.broken(&claims, &Conventions { normal_side, ..Conventions::default() }, "").is_empty()
    };
    assert_eq!(
        [NormalSide::Facing, NormalSide::Outward, NormalSide::Either].map(of),
        [false, true, true]
    );
    assert!(case.hint(&claims).unwrap().starts_with("--normals "));
}
