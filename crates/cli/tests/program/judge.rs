//! Other renderers' results against exact arithmetic, two pictures against each other, and what a picture
//! says of itself. Each comparison is fed something wrong, and must see it.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use kugelblitz::Session;
use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::glam::DVec3;
use kugelblitz::picture::{Channel, Image, Samples, read_bytes, read_image};
use kugelblitz::rays::{Pixels, Rays, View};
use kugelblitz::scene::{Scene, read_scene};
use kugelblitz::trace::Kernel;
use kugelblitz_judge::judge::{
    self, Allowed, Conventions, Judged, NormalSide, NormalSpace, Quantity, truth,
};
use kugelblitz_judge::verify::Truth;
use kugelblitz_tests::gpu;
use tempfile::TempDir;

use crate::program::{ends, program, scene_file as scene};

const SIZE: [u32; 2] = [96, 54];

fn file(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).to_str().unwrap().to_owned()
}

/// A picture of a scene by the program, on the CPU.
fn rendered(folder: &TempDir, scene_name: &str, name: &str, more: &[&str]) -> String {
    let out = file(folder, name);
    let size = format!("{}x{}", SIZE[0], SIZE[1]);
    let scene = scene(scene_name);
    let args = ["render", &scene, "-o", &out, "--size", &size, "--device", "cpu", "-q"];
    ends(program(&[&args, more].concat()), 0);
    out
}

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

#[test]
fn a_depth_of_the_background_is_understood() {
    let case = Case::new("figure2");
    let depth = |i: usize| if case.truth.id[i] == 0 { 1e10 } else { case.truth.t[i] };
    let claims = case.with([("Z", Samples::F64((0..case.truth.t.len()).map(depth).collect()))]);
    let own = Conventions::default();
    let broken = case.broken(&claims, &own, "");
    assert!(broken.len() == 2 && broken[0].contains("away from silhouettes"), "{broken:?}");
    let told = Conventions { background: Some(1e10), ..own };
    assert_eq!(case.broken(&claims, &told, ""), [""; 0]);
    assert_eq!(case.hint(&claims).as_deref(), Some("--background 10000000000"));
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

#[test]
fn colors_stand_for_ids() {
    let folder = tempfile::tempdir().unwrap();
    let case = Case::new("figure1");
    let own = Conventions::default();
    for (name, more) in [("a.png", &[][..]), ("b.png", &["--bits", "16"]), ("c.ppm", &[])] {
        let path = rendered(&folder, "figure1", name, more);
        let honest = read_image(path.as_ref()).unwrap();
        assert_eq!(case.broken(&honest, &own, ""), [""; 0], "{name}");
        for (levels, is_seen) in [(1, false), (2, true)] {
            let mut spoiled = honest.clone();
            let inner = case.pixel(false);
            match channel(&mut spoiled, "G") {
                Samples::U8(all) => all[inner] = all[inner].wrapping_sub(levels),
                Samples::U16(all) => all[inner] -= 257 * u16::from(levels),
                _ => panic!(),
            }
            assert_eq!(
                case.broken(&spoiled, &own, "").len(),
                usize::from(is_seen),
                "{name} {levels}"
            );
        }
    }
}

/// The program judges its own pictures, and those that it is told are another's.
#[test]
fn the_program_judges_pictures() {
    let folder = tempfile::tempdir().unwrap();
    let figure = scene("figure1");
    for (name, judged) in
        [("a.npy", "id,depth,normal"), ("a.exr", "id,depth,normal"), ("a.png", "color")]
    {
        let path = rendered(&folder, "figure1", name, &[]);
        let args = ["judge", &figure, "--against", &path, "--device", "cpu", "--json"];
        let found = ends(program(&args), 0).json();
        let judged: Vec<&str> = judged.split(',').collect();
        assert_eq!(found["judged"], serde_json::json!(judged));
        assert_eq!(found["size"], serde_json::json!(SIZE));
        assert_eq!(found["away"]["wrong_ids"], 0);
        assert_eq!(found["broken"], serde_json::json!([]));
    }
    let path = file(&folder, "a.npy");
    let mut bytes = fs::read(&path).unwrap();
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    let case = Case::new("figure1");
    let pixel = case.pixel(false);
    bytes[start + 32 * pixel] += 1;
    fs::write(&path, bytes).unwrap();
    let error = file(&folder, "error.png");
    let args = ["judge", &figure, "--against", &path, "--device", "cpu", "-o", &error];
    let ran = ends(program(&args), 6);
    let (x, y) = case.pixels().xy(pixel);
    let command = format!("kugelblitz explain {figure} --pixel {x},{y} --size 96x54");
    assert!(ran.text().contains(&command), "{}", ran.text());
    assert!(ran.stderr.contains("1 of "), "{}", ran.stderr);
    let shown = read_image(error.as_ref()).unwrap();
    assert_eq!((shown.width, shown.height), (96, 54));
    let yellow = |i: usize| {
        ["R", "G", "B"].map(|name| shown.channel(name).unwrap().number(i)) == [255.0, 224.0, 74.0]
    };
    let yellow: Vec<usize> = (0..shown.len()).filter(|&i| yellow(i)).collect();
    assert_eq!(yellow, [pixel]);
    ends(program(&["judge", &figure, "--against", &path, "--allow", "ids=1"]), 0);
}

#[test]
fn parts_are_judged_in_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let figure = scene("figure1");
    let crop = ["--crop", "30,20,40,25"];
    for name in ["a.exr", "a.png", "a.npy"] {
        let path = rendered(&folder, "figure1", name, &crop);
        let args = ["judge", &figure, "--against", &path, "--device", "cpu", "--json"];
        // An NPY file doesn't tell where it belongs.
        let place = ["--size", "96x54", crop[0], crop[1]];
        let more: &[&str] = if name == "a.npy" { &place } else { &[] };
        let found = ends(program(&[&args, more].concat()), 0).json();
        assert_eq!(found["crop"], serde_json::json!([30, 20, 40, 25]), "{name}");
        let wrong = ["--size", "96x54", "--crop", "30,20,40,24"];
        ends(program(&[&args[..], &wrong].concat()), 2);
    }
}

#[test]
fn hits_of_given_rays_are_judged() {
    let folder = tempfile::tempdir().unwrap();
    let (figure, rays) = (scene("figure1"), file(&folder, "rays.npy"));
    let hits = file(&folder, "hits.npy");
    let ray = |i: i32| vec![f64::from(i) * 0.25 - 2.0, 1.0, 6.0, 0.0, -0.05, -3.0];
    fs::write(&rays, kugelblitz_tests::npy(&(0..17).map(ray).collect::<Vec<_>>(), "<f8", false))
        .unwrap();
    ends(program(&["trace", &figure, "--rays", &rays, "-o", &hits, "--device", "cpu"]), 0);
    let args = ["judge", &figure, "--rays", &rays, "--against", &hits, "--device", "cpu"];
    ends(program(&args), 0);
    let honest = fs::read(&hits).unwrap();
    let start = honest.len() - 17 * 20;
    for (what, at) in [("id", 0), ("t", 4), ("normal", 19)] {
        let mut bytes = honest.clone();
        let hit = (0..17).find(|i| bytes[start + 20 * i] != 0).unwrap();
        bytes[start + 20 * hit + at] ^= if at == 19 { 0x80 } else { 3 };
        fs::write(&hits, bytes).unwrap();
        let ran = ends(program(&args), 6);
        assert!(ran.text().contains("--ray="), "{what}: {}", ran.text());
    }
    // A list is of rays, and of as many as there are.
    ends(program(&["judge", &figure, "--against", &hits]), 2);
    fs::write(&rays, kugelblitz_tests::npy(&(0..16).map(ray).collect::<Vec<_>>(), "<f8", false))
        .unwrap();
    ends(program(&args), 2);
}

/// A plain array of one number a pixel.
fn plain(type_: &str, fortran: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if fortran { "True" } else { "False" };
    let header = format!("{{'descr': '{type_}', 'fortran_order': {order}, 'shape': {shape}, }}");
    let mut bytes = b"\x93NUMPY\x01\x00\x76\x00".to_vec();
    bytes.extend(format!("{header:<117}\n").bytes());
    bytes.extend(data);
    bytes
}

#[test]
fn arrays_of_all_kinds_are_read() {
    let read = |bytes: &[u8]| read_bytes(bytes, "a.npy".as_ref()).unwrap();
    let value = |bytes: &[u8]| read(bytes).channels[0].samples.clone();
    let halves: Vec<u8> = [0x3c00_u16, 0x4000].iter().flat_map(|n| n.to_le_bytes()).collect();
    assert_eq!(value(&plain("<f2", false, "(1, 2)", &halves)), Samples::F16(vec![1.0, 2.0]));
    let big: Vec<u8> = [1.5_f32, -2.0].iter().flat_map(|n| n.to_be_bytes()).collect();
    assert_eq!(value(&plain(">f4", false, "(1, 2)", &big)), Samples::F32(vec![1.5, -2.0]));
    let signed: Vec<u8> = [-1_i16, 300].iter().flat_map(|n| n.to_le_bytes()).collect();
    assert_eq!(value(&plain("<i2", false, "(2,)", &signed)), Samples::I64(vec![-1, 300]));
    assert_eq!(value(&plain("|b1", false, "(2, 1)", &[0, 1])), Samples::U8(vec![0, 1]));
    let by_column = read(&plain("|u1", true, "(2, 3)", &[1, 4, 2, 5, 3, 6]));
    assert_eq!(by_column.channels[0].samples, Samples::U8(vec![1, 2, 3, 4, 5, 6]));
    assert_eq!((by_column.width, by_column.height), (3, 2));
    let colors = read(&plain("|u1", false, "(1, 2, 3)", &[1, 2, 3, 4, 5, 6]));
    assert_eq!(colors.channel("G"), Some(&Samples::U8(vec![2, 5])));
    let by_column = read(&plain("|u1", true, "(1, 2, 3)", &[1, 4, 2, 5, 3, 6]));
    assert_eq!(by_column.channels, colors.channels);
}

#[test]
fn what_is_no_picture_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let exr = fs::read(rendered(&folder, "figure1", "a.exr", &[])).unwrap();
    let png = fs::read(rendered(&folder, "figure1", "a.png", &[])).unwrap();
    let npy = fs::read(rendered(&folder, "figure1", "a.npy", &[])).unwrap();
    let refused = |bytes: &[u8]| read_bytes(bytes, "a.npy".as_ref()).unwrap_err();
    for whole in [exr, png, npy] {
        assert!(read_bytes(&whole, "a".as_ref()).is_ok());
        for n in [0, 3, 8, 20, 100, whole.len() / 2] {
            assert_eq!(refused(&whole[..n]).exit_code(), 1, "{n} of {}", whole.len());
        }
    }
    for start in
        [&b"\xff\xd8\xff\xe0\0\x10JFIF\0"[..], b"II*\0\x08\0\0\0", b"BM\x1e\0\0\0", b"#?RADIANCE\n"]
    {
        let message = refused(&[start, &[0; 100]].concat()).to_string();
        assert!(message.contains("PNG, OpenEXR, NPY and PPM can be read"), "{message}");
    }
    for (type_, shape, data) in [
        ("<f8", "(1000000000, 100000000)", &[0; 8][..]),
        ("<f8", "(99999999999, 99999999999)", &[0; 8]),
        ("|S4", "(1, 1)", b"abcd"),
        ("<c16", "(1, 1)", &[0; 16]),
        ("<f8", "(1, 1, 1, 1)", &[0; 8]),
        ("<f8", "(1, 1)", &[0; 9]),
        ("|V99999999999999999999", "(1, 1)", &[0; 9]),
        ("<f8", "'''' '' [[[[[[[[[[[[[[[[[[", &[0; 9]),
    ] {
        let error = refused(&plain(type_, false, shape, data));
        assert!([1, 7].contains(&error.exit_code()), "{type_} {shape}: {error}");
    }
}

#[test]
fn two_pictures_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let png = rendered(&folder, "figure1", "a.png", &[]);
    for (name, more) in [
        ("b.png", &[][..]),
        ("c.ppm", &["--bits", "16"]),
        ("d.exr", &[]),
        ("e.npy", &[]),
        ("f.png", &["--bits", "16"]),
    ] {
        let other = rendered(&folder, "figure1", name, more);
        let found = ends(program(&["compare", &png, &other, "--json"]), 0).json();
        assert_eq!(found["differing"], 0, "{name}");
        assert_eq!(found["channels"].as_array().unwrap().len(), 3, "{name}");
    }
    let [exr, npy] = ["d.exr", "e.npy"].map(|name| file(&folder, name));
    let found = ends(program(&["compare", &exr, &npy, "--json"]), 0).json();
    let names: Vec<&str> =
        found["channels"].as_array().unwrap().iter().map(|c| c["name"].as_str().unwrap()).collect();
    assert_eq!(names.len(), 8, "{names:?}");

    // One number of each field, by its last bit.
    let honest = fs::read(&npy).unwrap();
    let start = honest.len() - 32 * (SIZE[0] * SIZE[1]) as usize;
    let pixel = Case::new("figure1").pixel(false);
    for (channel, at) in [("id", 0), ("Z", 4), ("N.Y", 12), ("G", 24)] {
        let mut bytes = honest.clone();
        bytes[start + 32 * pixel + at] ^= 1;
        let spoiled = file(&folder, "spoiled.npy");
        fs::write(&spoiled, bytes).unwrap();
        let difference = file(&folder, "difference.png");
        let args = ["compare", &npy, &spoiled, "--json", "-o", &difference];
        let found = ends(program(&args), 6).json();
        assert_eq!((&found["differing"], &found["beyond"]), (&1.into(), &1.into()), "{channel}");
        let channels = found["channels"].as_array().unwrap();
        let differing: Vec<_> = channels.iter().filter(|c| c["differing"] == 1).collect();
        assert_eq!(differing.len(), 1);
        assert_eq!(differing[0]["name"], channel);
        assert_eq!(differing[0]["pixel"], serde_json::json!([pixel % 96, pixel / 96]));
        let is_float = channel != "id";
        assert_eq!(differing[0]["largest_ulp"] == 1, is_float, "{channel}");
        let shown = read_image(difference.as_ref()).unwrap();
        let red = shown.channel("R").unwrap();
        assert!(red.number(pixel) > 190.0 && red.number(pixel + 1) < 100.0);
        let allowed = ["compare", &npy, &spoiled, "--allow", "ulp=1"];
        ends(program(&allowed), if is_float { 0 } else { 6 });
        ends(program(&["compare", &npy, &spoiled, "--allow", "pixels=1"]), 0);
    }
    let small = file(&folder, "small.png");
    let figure = scene("figure1");
    ends(program(&["render", &figure, "-o", &small, "--size", "9x9", "--device", "cpu", "-q"]), 0);
    let ran = ends(program(&["compare", &png, &small]), 6);
    assert!(ran.stderr.contains("96×54 and 9×9"), "{}", ran.stderr);
}

#[test]
fn pictures_say_how_they_were_made_the_same_on_every_device() {
    gpu();
    let folder = tempfile::tempdir().unwrap();
    for (ending, software) in [("png", "Software"), ("exr", "software")] {
        let name = format!("a.{ending}");
        let path = rendered(&folder, "lit/figure1", &name, &["--samples", "2"]);
        let found = ends(program(&["info", &path, "--json"]), 0).json();
        let texts = &found["metadata"];
        assert_eq!(texts[software], concat!("kugelblitz ", env!("CARGO_PKG_VERSION")));
        assert_eq!(texts["kugelblitz.kernel"], "certified");
        assert_eq!(texts["kugelblitz.samples"], "2x2");
        assert_eq!(texts["kugelblitz.size"], "96x54");
        assert_eq!(texts["kugelblitz.certificate"], "5184 of 5184 pixels proven");
        assert!(texts["kugelblitz.scene"].as_str().unwrap().starts_with("kbs1:"));
        // The camera's line is one of a scene file.
        let text = fs::read_to_string(scene("lit/figure1")).unwrap();
        let (before, after) = text.split_once("[camera]").unwrap();
        let after = &after[after.find("\n[").unwrap()..];
        let camera = texts["kugelblitz.camera"].as_str().unwrap();
        let again = file(&folder, "again.toml");
        fs::write(&again, format!("{camera}\n{before}\n{after}")).unwrap();
        let other = file(&folder, &format!("b.{ending}"));
        let args = ["render", &again, "-o", &other, "--size", "96x54", "--samples", "2", "-q"];
        ends(program(&[&args[..], &["--device", "gpu"]].concat()), 0);
        assert!(fs::read(&path).unwrap() == fs::read(&other).unwrap(), "{ending}");
        let plain = rendered(&folder, "lit/figure1", &name, &["--kernel", "lecture"]);
        let found = ends(program(&["info", &plain, "--json"]), 0).json();
        assert_eq!(found["metadata"]["kugelblitz.certificate"], "0 of 5184 pixels proven");
        assert_eq!(found["metadata"]["kugelblitz.scene"], texts["kugelblitz.scene"]);
    }
}

#[test]
fn info_tells_what_there_is() {
    let folder = tempfile::tempdir().unwrap();
    let part = rendered(&folder, "figure1", "a.exr", &["--crop", "8,4,40,25", "--certificates"]);
    let found = ends(program(&["info", &part, "--json"]), 0).json();
    assert_eq!(found["window"], serde_json::json!([8, 4, 40, 25]));
    assert_eq!(found["whole"], serde_json::json!(SIZE));
    let levels = &found["levels"];
    let sum = ["f32", "f64", "exact"].map(|level| levels[level].as_u64().unwrap());
    assert_eq!(sum.iter().sum::<u64>(), 1000);
    let text = ends(program(&["info", &part]), 0).text().to_owned();
    assert!(text.contains("part: at 8,4 of 96×54"), "{text}");
    assert!(text.contains("\ncamera = { position"), "{text}");
    for (name, words) in [
        ("a.ppm", "PNM, 96×54\nchannels: R G B u8\n"),
        ("a.npy", "id u32, Z N.X N.Y N.Z R G B f32\n"),
    ] {
        let path = rendered(&folder, "figure1", name, &[]);
        let text = ends(program(&["info", &path]), 0).text().to_owned();
        assert!(text.contains(words) && text.contains("it says nothing"), "{text}");
    }
    ends(program(&["info", &scene("figure1")]), 1);
    ends(program(&["info", &file(&folder, "missing.png")]), 1);
}

#[test]
fn wrong_usage_is_told_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let figure = scene("figure1");
    let npy = rendered(&folder, "figure1", "a.npy", &[]);
    let png = rendered(&folder, "lit/figure1", "lit.png", &[]);
    let array = file(&folder, "plain.npy");
    fs::write(&array, plain("|u1", false, "(1, 2)", &[1, 2])).unwrap();
    let lit = scene("lit/figure1");
    for (args, words) in [
        (&["judge", &figure, "--against", &npy, "--as", "dept"][..], "did you mean depth?"),
        (&["judge", &figure, "--against", &npy, "--as", "depth,distance"], "of one kind"),
        (&["judge", &figure, "--against", &npy, "--as", "zbuffer"], "--near and --far"),
        (
            &["judge", &figure, "--against", &npy, "--as", "id", "--channel", "idd"],
            "did you mean id?",
        ),
        (&["judge", &figure, "--against", &npy, "--allow", "idz=1"], "did you mean ids?"),
        (&["judge", &figure, "--against", &npy, "--size", "9x9"], "with crop"),
        (&["judge", &figure, "--against", &npy, "-o", "a.exr"], ".png"),
        (&["judge", &figure, "--against", &array], "--as"),
        (&["judge", &lit, "--against", &png], "kugelblitz compare"),
        (&["compare", &npy, &npy, "--allow", "level=1"], "did you mean levels?"),
    ] {
        let ran = ends(program(args), 2);
        assert!(ran.stderr.contains(words), "{args:?}: {}", ran.stderr);
    }
    ends(program(&["judge", &figure, "--against", &scene("figure1")]), 1);
}
