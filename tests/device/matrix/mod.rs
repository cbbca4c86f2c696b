//! Every way of the program to ids, hits and colours, over scenes where it is hard, against the oracle,
//! bit by bit: scene × rays (whole picture, part of one, list, samples) × camera × device.
//!
//! `KUGELBLITZ_SEED=n` draws other scenes and `KUGELBLITZ_SCENES=n` so many of them:
//! `KUGELBLITZ_SEED=7 KUGELBLITZ_SCENES=1000 cargo test --profile ci -p kugelblitz-tests --test device matrix::`.

mod scenes;

use std::fmt::Debug;
use std::path::Path;
use std::sync::{Arc, LazyLock};

use kugelblitz::Session;
use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::rays::Pixels;
use kugelblitz::scene::{Samples, Scene, parse_scene};
use kugelblitz::trace::{Hits, Kernel, Ray, Rays, StageCounts, Wants};
use kugelblitz_tests::oracle::{Hit, MISS, Oracle, Truth};
use kugelblitz_tests::{oracle, root};
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

use scenes::{Hard, N_FAMILIES};

/// Columns and rows of the pictures, and the part that is traced alone.
const SIZE: [u32; 2] = [12, 8];
const PART: [u32; 4] = [5, 3, 4, 3];

/// Samples across a pixel.
const SAMPLES: [u32; 3] = [1, 2, 3];

/// A number of the environment, or another.
fn setting(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |text| text.parse().expect("a number"))
}

/// A scene with all that the oracle says of it.
struct Case {
    hard: Hard,
    name: String,
    scene: Arc<Scene>,
    list: Rays,
    of_pixels: Vec<Hit>,
    of_list: Vec<Hit>,
    /// By number of samples.
    colors: Vec<Vec<Truth>>,
}

impl Case {
    fn new(seed: u64, index: u64) -> Case {
        let hard = scenes::scene(seed, index);
        let name = format!("seed {seed}, scene {index} ({})", hard.family);
        let file = Path::new("hard.toml");
        let scene = parse_scene(&hard.text, file)
            .unwrap_or_else(|error| panic!("{name}: {error}\n{}", hard.text));
        let text = Arc::new(oracle::scene::read(&hard.text));
        let [width, height] = SIZE;
        let xy: Vec<[u32; 2]> = (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).collect();
        let colors = SAMPLES.map(|n| {
            let oracle = Oracle::new(&text, width, height, n);
            xy.iter().map(|&[x, y]| oracle.pixel(x, y)).collect()
        });
        let oracle = Oracle::new(&text, width, height, 1);
        let of_pixels = xy.iter().map(|&[x, y]| oracle.hit(x, y)).collect();
        let ray = |&[origin, direction]: &[_; 2]| Ray { origin, direction };
        let list = Rays::List(hard.rays.iter().map(ray).collect());
        let of_list = hard
            .rays
            .iter()
            .map(|[origin, direction]| {
                Oracle::of_ray(&text, origin.to_array(), direction.to_array())
            })
            .collect();
        let (scene, colors) = (Arc::new(scene), colors.into());
        Case { hard, name, scene, list, of_pixels, of_list, colors }
    }

    /// What is wrong, with the scene and a command that shows it.
    fn fail(&self, way: &str, what: &dyn Debug, truth: &dyn Debug, command: String) -> ! {
        panic!(
            "{}, {way}: {what:?} instead of {truth:?}\n--- hard.toml\n{}---\nkugelblitz {command}",
            self.name, self.hard.text
        )
    }

    fn pixel_command(&self, pixels: &Pixels, index: usize, samples: u32) -> String {
        let (x, y) = pixels.xy(index);
        let [width, height] = SIZE;
        match samples {
            1 => format!("explain hard.toml --size {width}x{height} --pixel {x},{y}"),
            n => format!(
                "render hard.toml --size {width}x{height} --crop {x},{y},1,1 --samples {n} -o pixel.npy"
            ),
        }
    }

    fn ray_command(&self, index: usize) -> String {
        let [origin, direction] = self.hard.rays[index];
        let numbers = [origin.to_array(), direction.to_array()].concat();
        let numbers: Vec<String> = numbers.iter().map(|x| format!("{x:?}")).collect();
        format!("explain hard.toml --ray={}", numbers.join(","))
    }

    fn check_hits(
        &self,
        way: &str,
        hits: &Hits,
        wants: Wants,
        truth: &[Hit],
        of: &dyn Fn(usize) -> String,
    ) {
        assert_eq!(hits.id.len(), truth.len(), "{}, {way}", self.name);
        for (i, truth) in truth.iter().enumerate() {
            let found = match wants.surface {
                true => Hit { id: hits.id[i], t: hits.t[i], normal: hits.normal[i] },
                false => Hit { id: hits.id[i], ..*truth },
            };
            let bits = |hit: &Hit| (hit.id, hit.t.to_bits(), hit.normal.map(f32::to_bits));
            if bits(&found) != bits(truth) {
                self.fail(&format!("{way}, ray {i}"), &found, truth, of(i));
            }
        }
    }

    /// All results of one device, and how many rays each of its stages decided.
    fn check(&self, device: &Device, on: &str) -> StageCounts {
        let mut counts = StageCounts::default();
        let control = Control::default();
        let mut session = Session::new(Arc::clone(&self.scene), device.clone(), Kernel::Certified);
        let [width, height] = SIZE;
        let whole = session.pixels(width, height).unwrap();
        let [x, y, part_width, part_height] = PART;
        let part = Pixels { x, y, width: part_width, height: part_height, ..whole };
        for (surface, what) in [(false, "ids"), (true, "hits")] {
            let wants = Wants { surface, level: false };
            for (pixels, rays) in [(whole, "picture"), (part, "part")] {
                let hits = session.hits(&pixels, wants, &control).unwrap();
                counts.add(hits.counts);
                let truth: Vec<Hit> = indices(&pixels).map(|i| self.of_pixels[i]).collect();
                let command = |i| self.pixel_command(&pixels, i, 1);
                self.check_hits(&format!("{on}, {what} of {rays}"), &hits, wants, &truth, &command);
            }
            let mut hits = Hits::default();
            session.trace(&self.list, wants, &control, &mut hits).unwrap();
            counts.add(hits.counts);
            let command = |i| self.ray_command(i);
            self.check_hits(
                &format!("{on}, {what} of list"),
                &hits,
                wants,
                &self.of_list,
                &command,
            );
        }
        for (n, truth) in SAMPLES.into_iter().zip(&self.colors) {
            let samples = Samples::nearest(n);
            for (pixels, rays) in [(whole, "picture"), (part, "part")] {
                let colors: Vec<[u8; 3]> = session.colors(&pixels, samples, &control).unwrap();
                for (i, (found, of)) in colors.iter().zip(indices(&pixels)).enumerate() {
                    if *found != truth[of].srgb8() {
                        let way = format!("{on}, {n} x {n} samples of {rays}, pixel {i}");
                        let command = self.pixel_command(&pixels, i, n);
                        self.fail(&way, found, &truth[of], command);
                    }
                }
            }
            let shorts: Vec<[u16; 3]> = session.colors(&part, samples, &control).unwrap();
            let floats: Vec<[f32; 3]> = session.colors(&part, samples, &control).unwrap();
            for (i, of) in indices(&part).enumerate() {
                let bits = |floats: [f32; 3]| floats.map(f32::to_bits);
                let (found, truth) = ((shorts[i], floats[i]), &truth[of]);
                if found.0 != truth.srgb16() || bits(found.1) != bits(truth.linear()) {
                    let way = format!("{on}, 16 bits and floats of {n} x {n} samples, pixel {i}");
                    self.fail(&way, &found, truth, self.pixel_command(&part, i, n));
                }
            }
        }
        counts
    }
}

/// Where the pixels are in the whole picture.
fn indices(pixels: &Pixels) -> impl Iterator<Item = usize> {
    (0..pixels.len()).map(|i| {
        let (x, y) = pixels.xy(i);
        (y * SIZE[0] + x) as usize
    })
}

/// The scenes with what the oracle says of them, found once for all tests.
fn cases() -> &'static [Case] {
    static CASES: LazyLock<Vec<Case>> = LazyLock::new(|| {
        let seed = setting("KUGELBLITZ_SEED", 1);
        let n_scenes = setting("KUGELBLITZ_SCENES", 10 * N_FAMILIES);
        (0..n_scenes).into_par_iter().map(|index| Case::new(seed, index)).collect()
    });
    &CASES
}

#[test]
fn the_scenes_are_not_one_sided() {
    let of_pixels = || cases().iter().flat_map(|case| &case.of_pixels);
    let (hits, rays) = (of_pixels().filter(|hit| **hit != MISS).count(), of_pixels().count());
    let colors = || cases().iter().flat_map(|case| &case.colors[0]);
    let lit = colors().filter(|truth| truth.linear() != [0.0; 3]).count();
    println!("{hits} of {rays} pixels show an object, {lit} are not black");
    assert!(hits * 4 > rays && hits * 20 < rays * 19, "{hits} of {rays}");
    assert!(lit * 4 > rays, "{lit} of {rays}");
}

/// `ci/spoilings.sh` can apply each.
#[test]
fn spoilings_fit_the_source() {
    let root = root();
    let read = |path: &str| std::fs::read_to_string(root.join(path)).unwrap_or_default();
    let list: toml::Table = read("tests/device/matrix/spoilings.toml").parse().expect("a list");
    let spoilings = list["spoiling"].as_array().expect("spoilings");
    let misfits: Vec<&str> = spoilings
        .iter()
        .filter(|spoiling| {
            let [file, find, replace] =
                ["file", "find", "replace"].map(|key| spoiling[key].as_str().expect("a text"));
            read(file).matches(find).count() != 1 || find == replace
        })
        .map(|spoiling| spoiling["name"].as_str().expect("a name"))
        .collect();
    assert!(!spoilings.is_empty() && misfits.is_empty(), "{misfits:?}");
}

fn check_all(cases: &[&Case], device: &Device, on: &str) {
    let mut counts = StageCounts::default();
    cases.iter().for_each(|case| counts.add(case.check(device, on)));
    println!("{on}: {} scenes, {counts:?}", cases.len());
    assert!(counts.f32 > 0 && counts.f64 > 0 && counts.exact > 0, "{counts:?}");
}

fn on_cpu(n_threads: usize) {
    let cases: Vec<&Case> = cases().iter().collect();
    let pool = ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
    pool.install(|| check_all(&cases, &Device::Cpu, &format!("CPU, {n_threads} threads")));
}

#[test]
fn the_cpu_with_one_thread() {
    on_cpu(1);
}

#[test]
fn the_cpu_with_threads() {
    on_cpu(3);
}

/// Fewer scenes: each has shaders to make.
#[test]
fn the_device() {
    let device = Device::Gpu(kugelblitz_tests::gpu());
    let one_in = setting("KUGELBLITZ_DEVICE", 5) as usize;
    let cases: Vec<&Case> = cases().iter().step_by(one_in).collect();
    check_all(&cases, &device, "device");
}
