//! Every way of the program to ids, hits and colours, over scenes where it is hard, against the oracle,
//! bit by bit: scene × rays (whole picture, part of one, list, samples) × camera × device.
//!
//! `KUGELBLITZ_SEED=n` draws other scenes, `KUGELBLITZ_SCENES=n` so many of them, and `KUGELBLITZ_CASE=crowd-1-7` is one
//! alone, of family, seed and number; it may also name a file, `KUGELBLITZ_CASE=scenes/hard/touching.toml`, or a case of
//! `tests/data/promises.toml`:
//! `KUGELBLITZ_SEED=7 KUGELBLITZ_SCENES=1000 cargo test --profile ci -p kugelblitz-tests --test device matrix::`.

mod devices;
mod failures;
mod files;
mod finite;
mod scenes;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Debug;
use std::path::Path;
use std::sync::{Arc, LazyLock};

use kugelblitz::Control;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::exact::{ExactPixels, ExactRay, nearest};
use kugelblitz::lighting::{Background, Encoding, Pixel, Style};
use kugelblitz::prepare::ScaledInteger;
use kugelblitz::query::{Hits, Kernel, Outputs, Rays, Stage, StageCounts, WorldRay};
use kugelblitz::rays::Pixels;
use kugelblitz::scene::{Camera, Color, Plane, Samples, Scene, parse_scene};
use kugelblitz_tests::gpu;
use kugelblitz_tests::oracle::{self, Hit, MISS, Oracle, Truth};
use kugelblitz_tests::{root, text_of};
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;

use failures::{Failure, file_of, told};
use scenes::{FAMILIES, Hard};

/// A number of the environment, or another.
fn setting(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).map_or(otherwise, |text| text.parse().expect("a number"))
}

/// Columns and rows of most pictures. Odd sides have a ray along the axis.
const USUAL: [u32; 2] = [13, 9];

/// Columns and rows of the picture of a family's scene of this number. The larger pictures have whole squares of pixels,
/// several bands and strips, and more than a chunk.
fn size(family: usize, number: u64) -> [u32; 2] {
    match (family as u64 + number) % 30 {
        3 => [1, 19],
        7 => [23, 1],
        13 => [1, 1],
        5 | 15 => [67, 50],
        9 => [131, 127],
        _ => USUAL,
    }
}

/// Pixels of a picture that the oracle is asked for, and the most that it is asked for with so many objects.
const JUDGED: usize = 130;
const JUDGED_TIMES_OBJECTS: usize = 20_000;

/// Samples across a pixel of a picture with so many pixels.
fn samples(n_pixels: usize, number: u64) -> Vec<u32> {
    if n_pixels > 1000 { vec![1] } else { vec![1, 2, 3 + (number % 2) as u32] }
}

/// A family's name in that of a scene.
fn hyphened(family: &str) -> String {
    family.replace(' ', "-")
}

/// A scene with all that the oracle says of it.
struct Case {
    family: &'static str,
    name: String,
    /// The scene file.
    text: String,
    scene: Arc<Scene>,
    size: [u32; 2],
    rays: Vec<WorldRay>,
    /// Column and row of the pixels that are judged.
    judged: Vec<[u32; 2]>,
    of_pixels: Vec<Hit>,
    of_list: Vec<Hit>,
    /// What samples count that hit nothing, where a pixel has several.
    background: Background,
    /// By number of samples.
    colors: BTreeMap<u32, Vec<Truth>>,
}

impl Case {
    /// The scene of this number of a family.
    fn drawn(seed: u64, family: usize, number: u64) -> Case {
        let Hard { family: name, text, rays } = scenes::scene(seed, family, number);
        let size = size(family, number);
        let family = format!("{}-{seed}-{number}", hyphened(name));
        Case::new(name, family, text, size, &rays, number)
    }

    fn new(
        family: &'static str,
        name: String,
        text: String,
        size: [u32; 2],
        rays: &[[glam::DVec3; 2]],
        number: u64,
    ) -> Case {
        let scene = parse_scene(&text, Path::new("hard.toml"))
            .unwrap_or_else(|error| panic!("{name}: {error}\n{text}"));
        let read = Arc::new(oracle::scene::read(&text));
        let [width, height] = size;
        let most = JUDGED.min(JUDGED_TIMES_OBJECTS / scene.n_objects()).max(8);
        let n_pixels = (width * height) as usize;
        let judged: Vec<[u32; 2]> = (0..n_pixels)
            .step_by(n_pixels.div_ceil(most))
            .map(|i| [i as u32 % width, i as u32 / width])
            .collect();
        let (background, before) = [
            (Background::Shown, oracle::Background::Shown),
            (Background::LeftOut, oracle::Background::LeftOut),
            (Background::Black, oracle::Background::Black),
        ][(number % 3) as usize];
        let of_pixels = {
            let oracle = Oracle::new(&read, width, height, 1);
            judged.iter().map(|&[x, y]| oracle.hit(x, y)).collect()
        };
        let truth = |n| {
            let oracle = Oracle::new(&read, width, height, n);
            let oracle = if n > 1 { oracle.before(before) } else { oracle };
            judged.iter().map(|&[x, y]| oracle.pixel(x, y)).collect()
        };
        let colors = samples(n_pixels, number).into_iter().map(|n| (n, truth(n))).collect();
        let of_ray = |[origin, direction]: &[glam::DVec3; 2]| {
            Oracle::of_ray(&read, origin.to_array(), direction.to_array())
        };
        let of_list = rays.iter().map(of_ray).collect();
        let ray = |&[origin, direction]: &[_; 2]| WorldRay { origin, direction };
        let rays = rays.iter().map(ray).collect();
        let scene = Arc::new(scene);
        Case {
            family,
            name,
            text,
            scene,
            size,
            rays,
            judged,
            of_pixels,
            of_list,
            background,
            colors,
        }
    }

    fn list(&self) -> Rays {
        Rays::List(self.rays.clone())
    }

    fn style(&self, n: u32, encoding: Encoding) -> Style {
        let background = if n > 1 { self.background } else { Background::Shown };
        Style { n_samples: Samples::nearest(n), background, ..Style::new(encoding) }
    }

    /// Where the judged pixels of a rectangle are among all judged, and in its rows.
    fn judged_in(&self, pixels: &Pixels) -> (Vec<usize>, Vec<usize>) {
        let judged = self.judged.iter().enumerate();
        judged
            .filter(|(_, [x, y])| {
                let (x, y) = (x.wrapping_sub(pixels.x), y.wrapping_sub(pixels.y));
                x < pixels.width && y < pixels.height
            })
            .map(|(i, [x, y])| (i, ((y - pixels.y) * pixels.width + x - pixels.x) as usize))
            .unzip()
    }

    /// A part of the picture that begins and ends amid its squares.
    fn part(&self) -> [u32; 4] {
        let [width, height] = self.size;
        [width / 3, height / 3, width.div_ceil(2), height.div_ceil(2)]
    }

    /// Asserts that the stages are those of the rays.
    fn assert_counted(&self, hits: &Hits, n_rays: usize, has_levels: bool) {
        assert_eq!(hits.counts.total(), n_rays as u64, "{}", self.name);
        let n_of = |level: Stage| hits.level.iter().filter(|at| **at == level as u8).count() as u64;
        let StageCounts { f32, f64, exact } = hits.counts;
        let of_levels = [Stage::F32, Stage::F64, Stage::Exact].map(n_of);
        assert!(!has_levels || of_levels == [f32, f64, exact], "{}", self.name);
    }

    fn failure(&self, way: &str, what: String, command: String) -> Failure {
        let (family, text) = (self.family, self.text.clone());
        let (scene, way) = (self.name.clone(), way.to_string());
        Failure { family, scene, text, way, what, command }
    }
}

// ---------------------------------------------------------------------------------------------
// Comparators

/// The places of what is not the truth.
fn wrong<F, T>(found: &[F], truth: &[T], is_true: impl Fn(&F, &T) -> bool) -> Vec<usize> {
    assert_eq!(found.len(), truth.len(), "results for other rays");
    (0..found.len()).filter(|&i| !is_true(&found[i], &truth[i])).collect()
}

fn has_id(found: &Hit, truth: &Hit) -> bool {
    found.id == truth.id
}

fn is_hit(found: &Hit, truth: &Hit) -> bool {
    let bits = |hit: &Hit| (hit.id, hit.t.to_bits(), hit.normal.map(f32::to_bits));
    bits(found) == bits(truth)
}

/// A pixel, and how many of its samples hit something, where that counts.
type Shown<P> = (P, Option<u16>);

fn has_hits(n_hits: Option<u16>, truth: &Truth) -> bool {
    n_hits.is_none_or(|n_hits| u32::from(n_hits) == truth.n_hits)
}

fn has_bytes(&(found, n_hits): &Shown<[u8; 3]>, truth: &Truth) -> bool {
    found == truth.srgb8() && has_hits(n_hits, truth)
}

fn has_shorts(&(found, n_hits): &Shown<[u16; 3]>, truth: &Truth) -> bool {
    found == truth.srgb16() && has_hits(n_hits, truth)
}

fn has_floats(&(found, n_hits): &Shown<[f32; 3]>, truth: &Truth) -> bool {
    found.map(f32::to_bits) == truth.linear().map(f32::to_bits) && has_hits(n_hits, truth)
}

// ---------------------------------------------------------------------------------------------
// Ways

/// A case on a device, with what was found wrong there.
struct Check<'a> {
    case: &'a Case,
    device: &'a Device,
    session: Session,
    counts: StageCounts,
    failures: Vec<Failure>,
}

impl<'a> Check<'a> {
    fn new(case: &'a Case, device: &'a Device) -> Check<'a> {
        let session = Session::new(Arc::clone(&case.scene), device.clone(), Kernel::Certified);
        Check { case, device, session, counts: StageCounts::default(), failures: Vec::new() }
    }

    /// All results of the device.
    fn run(mut self) -> (StageCounts, Vec<Failure>) {
        let [width, height] = self.case.size;
        let whole = self.session.pixels(width, height).unwrap();
        let [x, y, width, height] = self.case.part();
        let part = Pixels { x, y, width, height, ..whole };
        for surface in [false, true] {
            let picture = self.hits(&whole, surface);
            let of_part = self.hits(&part, surface);
            self.crop("hits", 1, &part, &picture, &of_part, is_hit);
            self.list(surface);
        }
        for (&n, truth) in &self.case.colors {
            let picture = self.colors::<[u8; 3]>(&whole, n, truth, "8 bits", has_bytes);
            let of_part = self.colors::<[u8; 3]>(&part, n, truth, "8 bits", has_bytes);
            self.crop("bytes", n, &part, &picture, &of_part, |found, whole| found == whole);
            self.colors::<[u16; 3]>(&part, n, truth, "16 bits", has_shorts);
            self.colors::<[f32; 3]>(&part, n, truth, "floats", has_floats);
        }
        (self.counts, self.failures)
    }

    fn hits(&mut self, pixels: &Pixels, surface: bool) -> Vec<Hit> {
        let hits =
            self.session.hits(pixels, Outputs { surface, level: surface }, &Control::default());
        let hits = hits.unwrap();
        self.count(&hits, pixels.len(), surface);
        let found = all_hits(&hits, surface);
        let (what, is_true) = of_surface(surface);
        self.judge(pixels, 1, what, &found, &self.case.of_pixels, is_true);
        found
    }

    fn count(&mut self, hits: &Hits, n_rays: usize, has_levels: bool) {
        self.counts.add(hits.counts);
        self.case.assert_counted(hits, n_rays, has_levels);
    }

    fn list(&mut self, surface: bool) {
        let mut hits = Hits::default();
        let wants = Outputs { surface, level: surface };
        self.session.trace(&self.case.list(), wants, &Control::default(), &mut hits).unwrap();
        self.count(&hits, self.case.rays.len(), surface);
        let (_, is_true) = of_surface(surface);
        self.judge_list("list", &all_hits(&hits, surface), is_true);
    }

    fn judge_list(&mut self, way: &str, found: &[Hit], is_true: fn(&Hit, &Hit) -> bool) {
        let truth = &self.case.of_list;
        for i in wrong(found, truth, is_true) {
            let what = format!("ray {i}: {:?} instead of {:?}", found[i], truth[i]);
            let WorldRay { origin, direction } = self.case.rays[i];
            let numbers = [origin.to_array(), direction.to_array()].concat();
            let numbers: Vec<String> = numbers.iter().map(|x| format!("{x:?}")).collect();
            let command = format!(
                "kugelblitz explain {} --ray={}",
                file_of(&self.case.name),
                numbers.join(",")
            );
            self.fail(way, what, command);
        }
    }

    fn colors<P: Pixel + Copy + Debug>(
        &mut self,
        pixels: &Pixels,
        n: u32,
        truth: &[Truth],
        what: &str,
        is_true: fn(&Shown<P>, &Truth) -> bool,
    ) -> Vec<Shown<P>> {
        let (style, control) = (self.case.style(n, P::ENCODING), Control::default());
        let (kept, _) = self.session.keep(pixels, style, Outputs::default(), &control).unwrap();
        let n_hits = kept.coverage.map(|coverage| coverage.n_hits);
        assert_eq!(n_hits.is_some(), style.background != Background::Shown);
        let colors = P::all(kept.colors).unwrap().into_iter().enumerate();
        let found: Vec<Shown<P>> =
            colors.map(|(i, rgb)| (rgb, n_hits.as_ref().map(|n_hits| n_hits[i]))).collect();
        self.judge(pixels, n, what, &found, truth, is_true);
        found
    }

    /// Compares the judged pixels of a rectangle with the truth.
    fn judge<F: Copy + Debug, T: Debug>(
        &mut self,
        pixels: &Pixels,
        n: u32,
        what: &str,
        found: &[F],
        truth: &[T],
        is_true: fn(&F, &T) -> bool,
    ) {
        assert_eq!(found.len(), (pixels.width * pixels.height) as usize, "{}", self.case.name);
        let (judged, places) = self.case.judged_in(pixels);
        let found: Vec<F> = places.iter().map(|&i| found[i]).collect();
        let truth: Vec<&T> = judged.iter().map(|&i| &truth[i]).collect();
        let way = format!("{what} of {} with {n} x {n}", rectangle(pixels));
        for i in wrong(&found, &truth, |found, truth| is_true(found, truth)) {
            let [x, y] = self.case.judged[judged[i]];
            let what = format!("pixel {x},{y}: {:?} instead of {:?}", found[i], truth[i]);
            let command = self.command(pixels, n, [x, y]);
            self.fail(&way, what, command);
        }
    }

    /// Compares a part with the same pixels of the whole picture.
    fn crop<F: Debug>(
        &mut self,
        what: &str,
        n: u32,
        part: &Pixels,
        picture: &[F],
        of_part: &[F],
        is_same: impl Fn(&F, &F) -> bool,
    ) {
        let row = |y: u32| {
            let first = ((part.y + y) * self.case.size[0] + part.x) as usize;
            &picture[first..first + part.width as usize]
        };
        let cut: Vec<&F> = (0..part.height).flat_map(row).collect();
        for i in wrong(of_part, &cut, |found, whole| is_same(found, whole)) {
            let (x, y) = (part.x + i as u32 % part.width, part.y + i as u32 / part.width);
            let said = format!("pixel {x},{y}: {:?}, in the picture {:?}", of_part[i], cut[i]);
            let command = self.command(part, n, [x, y]);
            self.fail(&format!("part and whole, {what}"), said, command);
        }
    }

    /// Repeats a way with the program, and then its pixel alone.
    fn command(&self, pixels: &Pixels, n: u32, [x, y]: [u32; 2]) -> String {
        let [width, height] = self.case.size;
        let device = self.device.kind();
        let draw = |crop: [u32; 4], file: &str| {
            let [x, y, w, h] = crop;
            format!(
                "kugelblitz render {} --size {width}x{height} --crop {x},{y},{w},{h} --samples {n} \
                 --device {device} -o {file}.npy",
                file_of(&self.case.name)
            )
        };
        let rectangle = [pixels.x, pixels.y, pixels.width, pixels.height];
        format!("{}\n    {}", draw(rectangle, "all"), draw([x, y, 1, 1], "alone"))
    }

    fn fail(&mut self, way: &str, what: String, command: String) {
        self.failures.push(self.case.failure(
            &format!("{}, {way}", self.device.kind()),
            what,
            command,
        ));
    }
}

/// `all` or `part`.
fn rectangle(pixels: &Pixels) -> &'static str {
    match [pixels.width, pixels.height] == [pixels.image_width, pixels.image_height] {
        true => "all",
        false => "part",
    }
}

/// What is judged with and without surfaces, and its comparator.
fn of_surface(surface: bool) -> (&'static str, fn(&Hit, &Hit) -> bool) {
    if surface { ("hits", is_hit) } else { ("ids", has_id) }
}

fn all_hits(hits: &Hits, surface: bool) -> Vec<Hit> {
    (0..hits.id.len())
        .map(|i| match surface {
            true => Hit { id: hits.id[i], t: hits.t[i], normal: hits.normal[i] },
            false => Hit { id: hits.id[i], ..MISS },
        })
        .collect()
}

// ---------------------------------------------------------------------------------------------
// Cases

/// The scenes with what the oracle says of them, found once for all tests: files, and of each family so many.
fn cases() -> &'static [Case] {
    static CASES: LazyLock<Vec<Case>> = LazyLock::new(|| {
        if let Ok(name) = std::env::var("KUGELBLITZ_CASE") {
            return vec![named(&name)];
        }
        let seed = setting("KUGELBLITZ_SEED", 1);
        let n_families = FAMILIES.len();
        let n_scenes = setting("KUGELBLITZ_SCENES", 6 * n_families as u64) as usize;
        let drawn = |i| Case::drawn(seed, i % n_families, (i / n_families) as u64);
        let mut cases: Vec<Case> = (0..n_scenes).into_par_iter().map(drawn).collect();
        cases.par_extend(files::names().into_par_iter().map(|name| files::case(&name)));
        cases
    });
    &CASES
}

/// The case of this name: `crowd-1-7`, or a file.
fn named(name: &str) -> Case {
    let mut parts = name.rsplitn(3, '-');
    let mut number = || parts.next().and_then(|part| part.parse::<u64>().ok());
    let (Some(number), Some(seed)) = (number(), number()) else {
        return files::case(name);
    };
    let family = parts.next().expect("a family");
    let family = FAMILIES.iter().position(|(name, _)| hyphened(name) == family);
    Case::drawn(seed, family.expect("a family"), number)
}

fn check_all(cases: &[&Case], device: &Device) {
    let checked: Vec<_> = cases.iter().map(|case| Check::new(case, device).run()).collect();
    let mut counts = StageCounts::default();
    let mut failures = Vec::new();
    for (of_case, failed) in checked {
        counts.add(of_case);
        failures.extend(failed);
    }
    println!("{}: {} scenes, {counts:?}", device.label(), cases.len());
    assert_none(&failures, cases.len());
    let are_few = cases.len() < 20;
    assert!(are_few || counts.f32 > 0 && counts.f64 > 0 && counts.exact > 0, "{counts:?}");
}

#[test]
fn the_cpu_with_one_thread() {
    on_cpu(1);
}

#[test]
fn the_cpu_with_threads() {
    on_cpu(3);
}

fn on_cpu(n_threads: usize) {
    let cases: Vec<&Case> = cases().iter().collect();
    let pool = ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
    pool.install(|| check_all(&cases, &Device::Cpu));
}

/// Fewer scenes, of all families: each has shaders to make.
#[test]
fn the_device() {
    let one_in = setting("KUGELBLITZ_DEVICE", 5) as usize;
    check_all(&in_turn(one_in, 0), &Device::Gpu(gpu()));
}

/// One case in so many, of all families; or the one that is replayed.
fn in_turn(one_in: usize, first: usize) -> Vec<&'static Case> {
    let one_in = if cases().len() == 1 { 1 } else { one_in };
    let n_families = FAMILIES.len();
    let is_its_turn =
        |i: usize| (first + i % n_families + 3 * (i / n_families)).is_multiple_of(one_in);
    let cases = cases().iter().enumerate().filter(|(i, _)| is_its_turn(*i));
    cases.map(|(_, case)| case).collect()
}

/// Exact arithmetic alone, for rays that bounds decide as well.
#[test]
fn exact_arithmetic_alone() {
    let failures = cases().par_iter().filter(|case| case.scene.n_objects() < 200).map(|case| {
        let mut check = Check::new(case, &Device::Cpu);
        let [width, height] = case.size;
        let whole = check.session.pixels(width, height).unwrap();
        let hit = |ray: &ExactRay| match nearest(ray, case.scene.objects()) {
            None => MISS,
            Some(hit) => Hit { id: hit.id, t: hit.t_f32(), normal: hit.normal_f32(ray) },
        };
        let exact = ExactPixels::new(&whole);
        let found: Vec<Hit> = case.judged.iter().map(|&[x, y]| hit(&exact.ray(x, y))).collect();
        for i in wrong(&found, &case.of_pixels, is_hit) {
            let what =
                format!("{:?}: {:?} instead of {:?}", case.judged[i], found[i], case.of_pixels[i]);
            check.fail("exact arithmetic", what, check.command(&whole, 1, case.judged[i]));
        }
        let found: Vec<Hit> = case.rays.iter().map(|ray| hit(&ExactRay::new(ray))).collect();
        check.judge_list("exact arithmetic, list", &found, is_hit);
        check.failures
    });
    assert_none(&failures.flatten().collect::<Vec<_>>(), cases().len());
}

fn assert_none(failures: &[Failure], n_scenes: usize) {
    if let Some(told) = told(failures, n_scenes) {
        panic!("{told}");
    }
}

/// A session keeps nothing of the scene, the camera and the kernel that it had before.
#[test]
fn one_session_for_all() {
    for device in [Device::Cpu, Device::Gpu(Arc::clone(devices::lighting()))] {
        let first = Arc::clone(&cases()[0].scene);
        let mut kept = Session::new(first, device.clone(), Kernel::Certified);
        // Far fewer for a device, which compiles for each.
        let one_in = if device.kind() == "cpu" { 3 } else { 13 };
        // What is asked for stays the same from scene to scene, or a tracer is made anew for that alone.
        for (kernel, shown) in [
            (Kernel::Certified, hits_of as fn(&mut Session) -> Vec<[u32; 5]>),
            (Kernel::Certified, colors_of),
            (Kernel::Stable, hits_of),
            (Kernel::Stable, colors_of),
        ] {
            kept.set_kernel(kernel);
            for case in cases().iter().step_by(one_in) {
                let of_case = case.scene.camera.clone().expect("a camera");
                // Another camera before the same scene, which needs the same shaders, and another scene.
                for (scene, camera) in [
                    (Arc::clone(&case.scene), of_case),
                    (Arc::clone(&case.scene), moved(case)),
                    (behind_a_wall(case), moved(case)),
                ] {
                    kept.set_scene(Arc::clone(&scene));
                    kept.set_camera(camera.clone());
                    let mut fresh = Session::new(scene, device.clone(), kernel);
                    fresh.set_camera(camera);
                    let about = format!("{} on {}", case.name, device.label());
                    assert!(shown(&mut kept) == shown(&mut fresh), "{about}\n{}", case.text);
                }
            }
        }
    }
}

/// Bits of what a session's picture shows.
fn hits_of(session: &mut Session) -> Vec<[u32; 5]> {
    let pixels = session.pixels(USUAL[0], USUAL[1]).unwrap();
    let wants = Outputs { surface: true, level: false };
    let hits = session.hits(&pixels, wants, &Control::default()).unwrap();
    let bits = |Hit { id, t, normal: [x, y, z] }: Hit| {
        [id, t.to_bits(), x.to_bits(), y.to_bits(), z.to_bits()]
    };
    all_hits(&hits, true).into_iter().map(bits).collect()
}

fn colors_of(session: &mut Session) -> Vec<[u32; 5]> {
    let pixels = session.pixels(USUAL[0], USUAL[1]).unwrap();
    let colors = session.colors::<[f32; 3]>(&pixels, Samples::ONE, &Control::default()).unwrap();
    colors.into_iter().map(|[r, g, b]| [r.to_bits(), g.to_bits(), b.to_bits(), 0, 0]).collect()
}

/// The case with a wall before the point that it looks at.
fn behind_a_wall(case: &Case) -> Arc<Scene> {
    let mut scene = (*case.scene).clone();
    let Camera { position, look_at, .. } = scene.camera.clone().expect("a camera");
    let (point, normal) =
        (position.lerp(look_at, 0.5), ScaledInteger::new(position - look_at).rounded());
    scene.planes.push(Plane { name: None, point, normal, color: Color([0.5; 3]) });
    Arc::new(scene)
}

/// The case's camera, a quarter of its way further.
fn moved(case: &Case) -> Camera {
    let camera = case.scene.camera.clone().expect("a camera");
    Camera { position: camera.position.lerp(camera.look_at, 0.25), ..camera }
}

// ---------------------------------------------------------------------------------------------
// Of the matrix itself

/// Each family that scenes were drawn of shows objects and light.
#[test]
fn no_family_is_empty() {
    // One that is replayed says nothing of its family.
    let drawn: BTreeSet<&str> =
        cases().iter().map(|case| case.family).filter(|_| cases().len() > 1).collect();
    for family in drawn {
        let cases = || cases().iter().filter(|case| case.family == family);
        let of_pixels = || cases().flat_map(|case| &case.of_pixels);
        let (hits, rays) = (of_pixels().filter(|hit| **hit != MISS).count(), of_pixels().count());
        let colors = || cases().flat_map(|case| &case.colors[&1]);
        let lit = colors().filter(|truth| truth.linear() != [0.0; 3]).count();
        let hard = colors().filter(|truth| truth.bits > 53).count();
        println!(
            "{family}: {hits} of {rays} pixels show an object, {lit} are not black, {hard} leave f64"
        );
        assert!(hits * 20 > rays, "{family}: {hits} of {rays} pixels show an object");
        assert!(lit * 20 > rays, "{family}: {lit} of {rays} pixels are not black");
        // What these are about is beyond f32 alone.
        let is_of_f32 = ["far wall", "galaxy"].contains(&family);
        assert!(hard > 0 || is_of_f32, "{family}: f64 tells all");
    }
}

#[test]
fn the_scenes_are_not_one_sided() {
    let of_pixels = || cases().iter().flat_map(|case| &case.of_pixels);
    let (hits, rays) = (of_pixels().filter(|hit| **hit != MISS).count(), of_pixels().count());
    let is_one = cases().len() == 1;
    assert!(is_one || hits * 4 > rays && hits * 20 < rays * 19, "{hits} of {rays}");
}

/// Each comparator passes the truth, and finds each number that is spoiled, where it is.
#[test]
fn the_comparators_see_each_number() {
    /// Spoils each result in each way by itself.
    fn spoil<F: Copy, T>(
        found: &[F],
        truth: &[T],
        is_true: fn(&F, &T) -> bool,
        ways: &[fn(&mut F)],
    ) {
        assert_eq!(wrong(found, truth, is_true), [0; 0]);
        for at in 0..found.len() {
            for way in ways {
                let mut spoiled = found.to_vec();
                way(&mut spoiled[at]);
                assert_eq!(wrong(&spoiled, truth, is_true), [at]);
            }
        }
    }
    let case = named("mixture-1-1");
    let (hits, colors) = (&case.of_pixels, &case.colors[&1]);
    spoil(hits, hits, has_id, &[|hit| hit.id ^= 1]);
    spoil(
        hits,
        hits,
        is_hit,
        &[
            |hit| hit.id ^= 1,
            |hit| hit.t = f32::from_bits(hit.t.to_bits() ^ 1),
            |hit| hit.normal[0] = f32::from_bits(hit.normal[0].to_bits() ^ 1),
            |hit| hit.normal[2] = -hit.normal[2],
        ],
    );
    fn shown<P>(of: fn(&Truth) -> P, colors: &[Truth]) -> Vec<Shown<P>> {
        colors.iter().map(|truth| (of(truth), Some(truth.n_hits as u16))).collect()
    }
    let bytes = shown(Truth::srgb8, colors);
    spoil(&bytes, colors, has_bytes, &[|at| at.0[0] ^= 1, |at| at.0[2] ^= 128, one_hit_more]);
    spoil(&shown(Truth::srgb16, colors), colors, has_shorts, &[|at| at.0[1] ^= 1, one_hit_more]);
    let other = |at: &mut Shown<[f32; 3]>| at.0[2] = f32::from_bits(at.0[2].to_bits() ^ 1);
    spoil(&shown(Truth::linear, colors), colors, has_floats, &[other, one_hit_more]);
}

fn one_hit_more<P>(shown: &mut Shown<P>) {
    shown.1 = shown.1.map(|n_hits| n_hits + 1);
}

/// A picture of another camera is wrong, and is told with its scene, its way and its command.
#[test]
fn a_wrong_picture_is_told() {
    let case = &named("mixture-1-1");
    let mut check = Check::new(case, &Device::Cpu);
    check.session.set_camera(moved(case));
    let (_, failures) = check.run();
    let told = told(&failures, 1).expect("failures");
    for part in [
        "wrong in 1 of 1 scenes",
        "mixture",
        "cpu, hits of all with 1 x 1",
        &case.name,
        "kugelblitz render",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
    let file = kugelblitz_tests::build_folder().join(format!("matrix/{}.toml", case.name));
    assert_eq!(std::fs::read_to_string(file).unwrap(), case.text);
}

/// A family that comes changes no other's scenes: they are drawn by its name.
#[test]
fn families_have_streams_of_their_own() {
    let [a, b] = [0, 1].map(|family| scenes::scene(1, family, 0));
    assert_ne!(a.text, b.text);
    assert_eq!(a.text, scenes::scene(1, 0, 0).text);
    assert_ne!(a.text, scenes::scene(2, 0, 0).text);
    assert_ne!(a.text, scenes::scene(1, 0, 1).text);
    let names: BTreeSet<u64> = FAMILIES.iter().map(|(name, _)| scenes::stream(name, 0)).collect();
    assert_eq!(names.len(), FAMILIES.len());
}

/// `ci/spoilings.sh` can apply each.
#[test]
fn spoilings_fit_the_source() {
    let list: toml::Table = text_of("tests/device/matrix/spoilings.toml").parse().expect("a list");
    let read = |path: &str| std::fs::read_to_string(root().join(path)).unwrap_or_default();
    let spoilings = list["spoiling"].as_array().expect("spoilings");
    let constants = list["constants"].as_array().expect("files");
    assert!(constants.iter().all(|file| !read(file.as_str().expect("a path")).is_empty()));
    let misfits: Vec<&str> = spoilings
        .iter()
        .filter(|spoiling| {
            let text = |key: &str| spoiling.get(key).and_then(|text| text.as_str());
            let (file, find) = (text("file").expect("a file"), text("find").expect("a text"));
            let changes = match text("halve") {
                Some(number) => find.matches(number).count() == 1,
                None => find != text("replace").expect("a text or a number"),
            };
            !changes || read(file).matches(find).count() != 1
        })
        .map(|spoiling| spoiling["name"].as_str().expect("a name"))
        .collect();
    assert!(!spoilings.is_empty() && misfits.is_empty(), "{misfits:?}");
}
