//! `render --show`: numbers as colours, with their legend, held against the numbers themselves.

use std::fs;
use std::path::Path;

use image::RgbImage;
use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::scene::read_scene;
use kugelblitz::trace::Kernel;
use kugelblitz::{Picture, Session};
use kugelblitz_judge::show::{Entry, Show, keep};
use kugelblitz_judge::verify::{Truth, compare_to_exact};
use serde_json::Value;
use tempfile::TempDir;

use kugelblitz_tests::text_of;

use crate::program::{Ran, ends, program, scene_file};

/// A picture and what was said of it.
struct Drawn {
    image: RgbImage,
    said: Value,
}

impl Drawn {
    fn legend(&self) -> &Vec<Value> {
        self.said["legend"].as_array().expect("a legend")
    }

    /// How many pixels the meanings with this word have.
    fn count(&self, word: &str) -> u64 {
        let entries = self.legend().iter();
        let named = entries.filter(|entry| entry["meaning"].as_str().unwrap().contains(word));
        named.map(|entry| entry["pixels"].as_u64().expect("a number of pixels")).sum()
    }

    fn counted(&self) -> u64 {
        self.legend().iter().map(|entry| entry["pixels"].as_u64().unwrap()).sum()
    }

    fn at(&self, x: u32, y: u32) -> [u8; 3] {
        self.image.get_pixel(x, y).0
    }
}

/// Renders a scene into a folder of its own.
#[track_caller]
fn render(scene: &str, show: &str, more: &[&str]) -> Drawn {
    let folder = tempfile::tempdir().unwrap();
    let mut args = vec!["render", scene, "-o", "a.png", "--show", show, "--json"];
    args.extend(more);
    let ran = in_folder(&folder, &args, 0);
    Drawn { image: image::open(folder.path().join("a.png")).unwrap().into_rgb8(), said: ran.json() }
}

#[track_caller]
fn in_folder(folder: &TempDir, args: &[&str], code: i32) -> Ran {
    let mut command = program(args);
    command.current_dir(folder);
    ends(command, code)
}

fn picture(scene: &str, kernel: Kernel, [width, height]: [u32; 2]) -> (Session, Picture) {
    let scene = read_scene(Path::new(scene)).unwrap();
    let mut session = Session::new(scene, Device::Cpu, kernel);
    let picture = session.render(width, height).unwrap();
    (session, picture)
}

#[test]
fn figure_5_has_one_pixel_with_d_0() {
    let drawn = render(&scene_file("figure5"), "discriminant", &["--size", "1281x721"]);
    assert_eq!((drawn.count("D = 0"), drawn.counted()), (1, 1281 * 721));
    let zero = &drawn.legend()[1];
    assert_eq!(
        (zero["color"].as_str(), &zero["at"]),
        (Some("#fff07a"), &serde_json::json!([[640, 360]]))
    );
    assert_eq!(drawn.at(640, 360), [0xff, 0xf0, 0x7a]);
    let (_, picture) = picture(&scene_file("figure5"), Kernel::Certified, [1281, 721]);
    // Every sphere of the figure is before the eye: a line that meets one is a ray that sees one.
    assert_eq!(drawn.count("D > 0") + 1, picture.hits.n_hits());
    assert_eq!(drawn.said["show"], "discriminant");
    for word in ["no real solution", "one real solution", "two real solutions"] {
        assert!(drawn.count(word) > 0, "{word}");
    }
}

#[test]
fn errors_are_those_that_exact_arithmetic_finds() {
    let (scene, size) = (scene_file("hard/far_1e8"), [120, 68]);
    for kernel in [Kernel::Lecture, Kernel::Stable, Kernel::Certified] {
        let drawn = render(&scene, "error", &["--size", "120x68", "--kernel", kernel.name()]);
        let (session, picture) = picture(&scene, kernel, size);
        let pixels = session.pixels(120, 68).unwrap();
        let all = (0..pixels.len()).collect();
        let truth = Truth::of_pixels(session.scene(), &pixels, all, &Default::default()).unwrap();
        let found = compare_to_exact(&picture.hits, &truth);
        let shown = ["wrong object", "object missed", "hit where"].map(|word| drawn.count(word));
        assert_eq!(shown, [found.wrong_object, found.false_misses, found.false_hits], "{kernel:?}");
        assert_eq!(drawn.counted(), 120 * 68);
        let wrong: u64 = shown.iter().sum();
        match kernel {
            // What compares is seen to find errors where there are some.
            Kernel::Lecture => assert!(wrong > 0),
            Kernel::Certified => {
                assert_eq!(wrong, 0);
                let right = drawn.count("the nearest f32") + drawn.count("background, rightly");
                assert_eq!(right, 120 * 68);
            }
            _ => {}
        }
    }
}

#[test]
fn a_picture_in_memory_is_that_of_the_file() {
    let scene = scene_file("figure2");
    for show in Show::ALL.into_iter().filter(|show| *show != Show::Color) {
        let more = ["--size", "96x54", "--kernel", "lecture", "--device", "cpu"];
        let drawn = render(&scene, show.name(), &more);
        let of_file = read_scene(Path::new(&scene)).unwrap();
        let mut session = Session::new(of_file, Device::Cpu, Kernel::Lecture);
        let pixels = session.pixels(96, 54).unwrap();
        let (shown, colors) = keep(&mut session, show, &pixels, &Control::default()).unwrap();
        assert!(colors.iter().eq(drawn.image.pixels().map(|pixel| &pixel.0)), "{show}");
        let told = drawn.legend().iter().map(|entry| entry["meaning"].as_str().unwrap());
        assert!(told.eq(shown.legend.iter().map(|entry| entry.meaning.as_str())), "{show}");
    }
    let mut session =
        Session::new(read_scene(Path::new(&scene)).unwrap(), Device::Cpu, Kernel::Lecture);
    let pixels = session.pixels(9, 6).unwrap();
    let refused = keep(&mut session, Show::Color, &pixels, &Control::default()).unwrap_err();
    assert_eq!(refused.exit_code(), 2);
}

#[test]
fn numbers_have_the_colours_that_they_are_said_to_have() {
    let (scene, size) = (scene_file("figure2"), ["--size", "96x54"]);
    let (_, picture) = picture(&scene, Kernel::Certified, [96, 54]);
    let hits = &picture.hits;
    let normals = render(&scene, "normal", &size);
    let depths = render(&scene, "depth", &size);
    let ids = render(&scene, "id", &size);
    for (i, &id) in hits.id.iter().enumerate() {
        let (x, y) = (i as u32 % 96, i as u32 / 96);
        if id == 0 {
            let nothing = [0x1c, 0x1f, 0x24];
            assert_eq!([&normals, &depths, &ids].map(|drawn| drawn.at(x, y)), [nothing; 3]);
            continue;
        }
        let normal = hits.normal[i].map(|n| ((f64::from(n) + 1.0) * 127.5).round() as u8);
        assert_eq!(normals.at(x, y), normal);
        assert_eq!(ids.at(x, y), kugelblitz_judge::show::id_color(id));
    }
    // The nearest is the brightest, and the legend has both ends.
    let seen = hits.t.iter().copied().filter(|t| t.is_finite());
    let near = seen.clone().reduce(f32::min).unwrap();
    let far = seen.reduce(f32::max).unwrap();
    for (t, grey) in [(near, 244), (far, 48)] {
        let at = hits.t.iter().position(|&other| other == t).unwrap() as u32;
        assert_eq!(depths.at(at % 96, at / 96), [grey; 3]);
    }
    let ends: Vec<_> = depths.legend().iter().map(|entry| entry["meaning"].clone()).collect();
    assert_eq!(ends, [format!("near: t = {near}"), format!("far: t = {far}")]);
}

#[test]
fn a_crop_fits_into_the_whole_picture_and_devices_agree() {
    for show in ["depth", "normal", "id", "side", "discriminant", "error"] {
        let scene = scene_file("orthographic");
        let whole = render(&scene, show, &["--size", "96x54", "--device", "cpu"]);
        let part =
            render(&scene, show, &["--size", "96x54", "--crop", "30,20,40,25", "--device", "gpu"]);
        assert_eq!(part.image.dimensions(), (40, 25));
        for (x, y, pixel) in part.image.enumerate_pixels() {
            assert_eq!(pixel.0, whole.at(30 + x, 20 + y), "{show} {x} {y}");
        }
    }
}

#[test]
fn the_stages_are_those_of_the_summary() {
    let drawn = render(&scene_file("hard/grazing"), "stage", &["--size", "320x180"]);
    let of = |stage: &str| drawn.said["rays"][stage].as_u64().unwrap();
    let shown = ["f32", "f64", "exact arithmetic"].map(|word| drawn.count(word));
    assert_eq!(shown, ["f32", "f64", "exact"].map(of));
    assert_eq!(drawn.counted(), 320 * 180);
}

#[test]
fn colour_is_what_is_drawn_without_it() {
    let scene = scene_file("lit/figure1");
    let folder = tempfile::tempdir().unwrap();
    let size = ["--size", "64x36"];
    for (name, more) in
        [("a", vec![]), ("b", vec!["--show", "colour"]), ("c", vec!["--show", "color"])]
    {
        let name = format!("{name}.png");
        let args = [&["render", &scene, "-o", &name][..], &size, &more].concat();
        in_folder(&folder, &args, 0);
    }
    let [a, b, c] =
        ["a", "b", "c"].map(|n| fs::read(folder.path().join(format!("{n}.png"))).unwrap());
    assert!(a == b && a == c);
    // Numbers take no light and no samples, whatever the scene has.
    let drawn = render(&scene, "id", &size);
    assert!(drawn.said.get("samples").is_none() && drawn.said.get("shadow_rays").is_none());
}

#[test]
fn the_legend_is_told_and_goes_not_into_a_pipe() {
    let scene = scene_file("figure5");
    let folder = tempfile::tempdir().unwrap();
    let args =
        ["render", &scene, "-o", "-", "--format", "ppm", "--show", "side", "--size", "32x18"];
    let ran = in_folder(&folder, &args, 0);
    assert_eq!(ran.stdout.len(), "P6\n32 18\n255\n".len() + 3 * 32 * 18);
    assert!(ran.stderr.contains("  #4c9fd8  front"), "{}", ran.stderr);
    let quiet = in_folder(&folder, &[&args[..], &["-q"]].concat(), 0);
    assert_eq!(quiet.stderr, "");
    let few = ["render", &scene, "-o", "a.png", "--show", "discriminant", "--size", "321x181"];
    let told = in_folder(&folder, &few, 0).stderr;
    assert!(told.contains("one real solution: 1 pixel, at 160,90"), "{told}");
}

#[test]
fn the_guide_has_every_mode() {
    let guide = text_of("docs/guide/src/window.md");
    for show in Show::ALL {
        assert!(guide.contains(&format!("\n| `{show}` | ")), "{show}");
    }
    for entry in Entry::all(Show::Discriminant, None).iter().take(3) {
        assert!(guide.contains(&entry.meaning), "{}", entry.meaning);
    }
}
