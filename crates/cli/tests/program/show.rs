//! `render --show`: numbers as colours, held against the numbers themselves. Legends stand in `tests/answers/show.txt`.

use std::path::Path;

use image::RgbImage;
use kugelblitz::device::Device;
use kugelblitz::scene::read_scene;
use kugelblitz::trace::Kernel;
use kugelblitz::{Picture, Session};
use kugelblitz_judge::show::{Entry, Show};
use kugelblitz_judge::verify::{Truth, compare_to_exact};
use serde_json::Value;

use kugelblitz_tests::text_of;

use crate::program::{file, run, scene_file};

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
    let out = file(&folder, "a.png");
    let args = ["render", scene, "-o", &out, "--show", show, "--json"];
    let said = run(&[&args[..], more].concat(), 0).json();
    Drawn { image: image::open(out).unwrap().into_rgb8(), said }
}

fn picture(scene: &str, kernel: Kernel, [width, height]: [u32; 2]) -> (Session, Picture) {
    let scene = read_scene(Path::new(scene)).unwrap();
    let mut session = Session::new(scene, Device::Cpu, kernel);
    let picture = session.render(width, height).unwrap();
    (session, picture)
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
fn the_guide_has_every_mode() {
    let guide = text_of("docs/guide/src/window.md");
    for show in Show::ALL {
        assert!(guide.contains(&format!("\n| `{show}` | ")), "{show}");
    }
    for entry in Entry::all(Show::Discriminant, None).iter().take(3) {
        assert!(guide.contains(&entry.meaning), "{}", entry.meaning);
    }
}
