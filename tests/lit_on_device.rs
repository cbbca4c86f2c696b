//! Colours that a device shades in f32 and f64 against those of the CPU, bit by bit. A device in software
//! is told to shade, which it leaves to the CPU otherwise.

mod common;

use std::path::Path;
use std::sync::Arc;

use common::{camera, in_cube, plane, sphere};
use glam::{DVec3, dvec3};
use kugelblitz::control::Control;
use kugelblitz::cpu::CpuTracer;
use kugelblitz::gpu::{Gpu, GpuTracer, Pick};
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{
    Camera, Color, Light, Projection, Samples, Scene, Sky, Source, Sphere, read_scene,
};
use kugelblitz::shade::{Background, Colors, Encoding, Painter, Style};
use kugelblitz::trace::{Hits, Kernel, Rays, Wants};
use kugelblitz::tracer::Tracer;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// A picture to be shaded.
struct Case {
    what: String,
    scene: Arc<Scene>,
    pixels: Pixels,
    style: Style,
}

/// What a device did of a picture.
#[derive(Clone, Copy, Debug, Default)]
struct Done {
    pixels: u64,
    in_f32: u64,
    left: u64,
    ways: u64,
}

impl Done {
    fn add(&mut self, other: Done) {
        self.pixels += other.pixels;
        self.in_f32 += other.in_f32;
        self.left += other.left;
        self.ways += other.ways;
    }
}

impl Case {
    fn new(what: &str, scene: &Arc<Scene>, camera: &Camera, [width, height]: [u32; 2]) -> Case {
        let pixels = Pixels::whole(View::new(camera), width, height);
        let (what, scene) = (what.to_string(), Arc::clone(scene));
        Case { what, scene, pixels, style: Style::new(Encoding::Srgb8) }
    }

    fn prepared(&self, n_samples: u32) -> Arc<Prepared> {
        let rays = Rays::Pixels(self.pixels.samples(n_samples));
        Arc::new(Prepared::new(Arc::clone(&self.scene), Kernel::Certified, &rays).unwrap())
    }

    /// The bits of the colours, and what the tracers' device did of them.
    fn paint(
        &self,
        encoding: Encoding,
        tracer: impl Fn(Arc<Prepared>) -> Box<dyn Tracer>,
    ) -> (Vec<[u32; 3]>, Done) {
        let (control, mut hits) = (Control::default(), Hits::default());
        let style = Style { encoding, ..self.style };
        let (of_pixels, of_samples) = (self.prepared(1), self.prepared(style.n_samples.across()));
        let mut tracers = [tracer(Arc::clone(&of_pixels)), tracer(Arc::clone(&of_samples))];
        let [pixels_tracer, samples_tracer] = &mut tracers;
        pixels_tracer.trace(&Rays::Pixels(self.pixels), &control, &mut hits).unwrap();
        let samples_tracer = (style.n_samples > Samples::ONE).then_some(&mut **samples_tracer);
        let mut painter = Painter::new(&of_samples, style, &self.pixels, samples_tracer);
        let mut colors = Colors::new(encoding);
        let tracer = Some(&mut **pixels_tracer as &mut dyn Tracer);
        let painted =
            painter.paint_with(tracer, &self.pixels, &hits, &control, &mut colors).unwrap();
        let pixels = self.pixels.len() as u64;
        let bits = match colors {
            Colors::Srgb8(colors) => colors.iter().map(|color| color.map(u32::from)).collect(),
            Colors::Srgb16(colors) => colors.iter().map(|color| color.map(u32::from)).collect(),
            Colors::Linear(colors) => colors.iter().map(|color| color.map(f32::to_bits)).collect(),
        };
        let in_f32 = painted.colors.device_f32;
        let ways = painted.shadow_rays.total();
        (bits, Done { pixels, in_f32, left: painted.colors.cpu, ways })
    }

    /// What the device did in each encoding, or where its picture differs from the CPU's.
    fn compare(&self, gpu: &Arc<Gpu>) -> Result<Done, String> {
        let encodings = [Encoding::Srgb8, Encoding::Srgb16, Encoding::Linear];
        let mut all = Done::default();
        for encoding in encodings {
            all.add(self.compare_in(encoding, gpu)?);
        }
        Ok(all)
    }

    fn compare_in(&self, encoding: Encoding, gpu: &Arc<Gpu>) -> Result<Done, String> {
        let (wants, what) = (Wants::default(), &self.what);
        let on_cpu = |prepared| Box::new(CpuTracer::new(prepared, wants)) as Box<dyn Tracer>;
        let (of_cpu, cpu) = self.paint(encoding, on_cpu);
        assert_eq!(cpu.left, cpu.pixels);
        let (of_device, done) = self.paint(encoding, |prepared| {
            Box::new(GpuTracer::new(Arc::clone(gpu), prepared, wants).unwrap())
        });
        if let Some(pixel) = (0..of_cpu.len()).find(|&at| of_cpu[at] != of_device[at]) {
            let place = self.pixels.xy(pixel);
            let [cpu, device] = [of_cpu[pixel], of_device[pixel]];
            return Err(format!(
                "{what}, {encoding:?} at {place:?}: {cpu:x?}, on the device {device:x?}"
            ));
        }
        let is_of_bytes = encoding == Encoding::Srgb8;
        assert!(done.in_f32 <= if is_of_bytes { done.pixels - done.left } else { 0 }, "{done:?}");
        // Of the same colours, a device may have more ways to look along. Of bytes both begin in f32, each with bounds of its own:
        // a way to light that only grazes a surface, as one of the sky's suns does on a huge ground, may be one to the CPU alone.
        let least = if is_of_bytes { cpu.ways - cpu.ways / 20 } else { cpu.ways };
        match done.ways >= least {
            true => Ok(done),
            false => {
                Err(format!("{what}, {encoding:?}: {} ways instead of {}", done.ways, cpu.ways))
            }
        }
    }
}

/// A device that shades.
fn open() -> Gpu {
    let gpu = Gpu::open(&Pick::Best).expect("a Vulkan device; ci/setup.sh installs one");
    gpu.always_in_f64()
}

/// The same with other words in the shaders of light in f32 or f64.
fn edited(float: &'static str, from: &'static str, to: &'static str) -> Arc<Gpu> {
    Arc::new(open().edit_shaders(move |wgsl| {
        let is_meant =
            wgsl.contains("struct LightOfAll") && wgsl.contains(&format!("alias Real = {float};"));
        if is_meant { wgsl.replace(from, to) } else { wgsl.into() }
    }))
}

/// Compares pictures, of which the device leaves at most this share to the CPU.
fn assert_equal(cases: &[Case], most: f64) -> Done {
    let gpu = Arc::new(open());
    let mut all = Done::default();
    for case in cases {
        let done = case.compare(&gpu).unwrap_or_else(|what| panic!("{what}"));
        let Done { pixels, in_f32, left, .. } = done;
        println!("{}: {in_f32} of {} in f32, {left} left to the CPU", case.what, pixels / 3);
        all.add(done);
    }
    println!("all: {} of {} left to the CPU", all.left, all.pixels);
    assert!(all.left as f64 <= most * all.pixels as f64, "{} of {}", all.left, all.pixels);
    all
}

/// The scenes of a folder as their cameras see them.
fn scenes_of(folder: &str, size: [u32; 2]) -> Vec<Case> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let files = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> =
        files.filter(|path| path.extension().is_some_and(|ending| ending == "toml")).collect();
    files.sort();
    let case = |path: &std::path::PathBuf| {
        let scene = Arc::new(read_scene(path).unwrap());
        let camera = scene.camera.clone().unwrap();
        Case::new(&path.display().to_string(), &scene, &camera, size)
    };
    files.iter().map(case).collect()
}

/// Balls of many colours.
fn balls(spheres: impl IntoIterator<Item = Sphere>) -> kugelblitz::scene::Spheres {
    let color = |k: usize| Color([0.9 - 0.01 * (k % 50) as f64, 0.2, 0.1 * (k % 9) as f64]);
    spheres.into_iter().enumerate().map(|(k, sphere)| (sphere, color(k))).collect()
}

fn light(source: Source, intensity: f64) -> Light {
    Light { source, color: Color([1.0, 0.875, 0.75]), intensity, shadows: true }
}

/// Lights of each kind, and a sky of which one sun is at the horizon.
fn lit(scene: Scene) -> Scene {
    let lights = vec![
        light(Source::Point(dvec3(3.0, 4.0, 2.0)), 0.5),
        light(Source::Sun(dvec3(-1.0, -2.0, -0.7)), 0.25),
        light(Source::Eye, 0.125),
        Light { shadows: false, ..light(Source::Point(dvec3(-4.0, 1.0, 3.0)), 0.125) },
    ];
    let (sky, ambient) = (Some(Sky { intensity: 0.125, directions: 7 }), Some(Color([0.03; 3])));
    Scene { lights, sky, ambient, ..scene }
}

/// Some balls over a floor and beside a wall, from outside and from inside of one of them, and by both cameras.
fn worlds(n_spheres: usize) -> Vec<Case> {
    let mut rng = ChaCha8Rng::seed_from_u64(1420 + n_spheres as u64);
    let size = 1.5 / (n_spheres as f64).cbrt();
    let mut spheres: Vec<Sphere> =
        (0..n_spheres).map(|_| sphere(in_cube(&mut rng) * 2.0, size)).collect();
    let planes = vec![
        plane(dvec3(0.0, -2.5, 0.0), dvec3(0.0, 3.0, 0.0)),
        plane(dvec3(-4.0, 0.0, 0.0), dvec3(1.0, 0.2, 0.1)),
    ];
    let outside = camera(dvec3(1.0, 1.5, 7.0), dvec3(0.0, -0.25, 0.0));
    let inside = camera(dvec3(0.1, 0.2, 2.3), dvec3(0.0, 0.0, -1.0));
    let across = Camera { projection: Projection::Orthographic { height: 6.0 }, ..outside.clone() };
    let mut cases = Vec::new();
    for with_room in [false, true] {
        if with_room {
            spheres[0] = sphere(dvec3(0.0, 0.0, 1.0), 5.6);
        }
        let scene =
            Scene { spheres: balls(spheres.clone()), planes: planes.clone(), ..Scene::default() };
        let scene = Arc::new(lit(scene));
        for (view, camera) in [("outside", &outside), ("inside", &inside), ("across", &across)] {
            let what = format!("{n_spheres} balls, {view}, room {with_room}");
            let case = Case::new(&what, &scene, camera, [40, 30]);
            let backgrounds = [Background::Shown, Background::LeftOut, Background::Black];
            for (n_samples, background) in (1..=3).zip(backgrounds) {
                let style =
                    Style { n_samples: Samples::nearest(n_samples), background, ..case.style };
                let scene = Arc::clone(&case.scene);
                let what = format!("{what}, {n_samples} samples");
                cases.push(Case { what, scene, style, ..case });
            }
        }
    }
    cases
}

#[test]
fn few_objects_are_shaded_as_on_the_cpu() {
    let done = assert_equal(&worlds(9), 0.001);
    assert!(done.ways > 200_000, "{done:?}");
}

#[test]
fn many_spheres_are_shaded_as_on_the_cpu() {
    let done = assert_equal(&worlds(700), 0.001);
    assert!(done.ways > 200_000, "{done:?}");
}

/// Spheres or planes alone.
#[test]
fn objects_of_one_kind_are_shaded_as_on_the_cpu() {
    let view = camera(dvec3(1.0, 1.5, 7.0), DVec3::ZERO);
    let floor = plane(dvec3(0.0, -1.0, 0.0), DVec3::Y);
    let ball = sphere(dvec3(0.0, 0.5, 0.0), 1.0);
    let planes = lit(Scene { planes: vec![floor], ..Scene::default() });
    let spheres = lit(Scene { spheres: balls([ball]), ..Scene::default() });
    let dark = Scene { lights: vec![], sky: None, ..spheres.clone() };
    let cases = [("planes", planes), ("spheres", spheres), ("no lamps", dark)];
    let cases = cases.map(|(what, scene)| Case::new(what, &Arc::new(scene), &view, [64, 48]));
    assert_equal(&cases, 0.001);
}

/// A ball on a floor, and a wall with light behind it: where they meet, as near as f64 can look at it; and the edge of
/// the ball's shadow, from near and from far away.
fn contacts() -> Vec<Case> {
    let spheres = [sphere(dvec3(0.0, 1.0, 0.0), 1.0), sphere(dvec3(2.0, 1.0, 0.0), 1.0)];
    let scene = Scene {
        spheres: balls(spheres),
        planes: vec![plane(DVec3::ZERO, DVec3::Y)],
        lights: vec![
            light(Source::Point(dvec3(4.0, 6.0, 3.0)), 0.7),
            light(Source::Sun(dvec3(-1.0, -1e-5, -1.0)), 0.3),
        ],
        ambient: Some(Color([0.03125; 3])),
        ..Scene::default()
    };
    let wall = plane(dvec3(-1.0, 0.0, 0.0), dvec3(1.0, 0.0, 0.3));
    let crossing = Scene {
        planes: vec![plane(DVec3::ZERO, DVec3::Y), wall],
        lights: vec![light(Source::Point(dvec3(-3.0, 2.0, 0.1)), 0.7)],
        ..Scene::default()
    };
    let (scene, crossing) = (Arc::new(scene), Arc::new(crossing));
    // A ray of the lamp that touches the ball.
    let (lamp, ball) = (dvec3(4.0, 6.0, 3.0), dvec3(0.0, 1.0, 0.0));
    let (way, aside) = (ball - lamp, (ball - lamp).normalize().any_orthonormal_vector());
    let touching = way + aside * (way.length_squared() / (way.length_squared() - 1.0)).sqrt();
    let edge = lamp - touching * (lamp.y / touching.y);
    let mut cases = Vec::new();
    for width in [1e-5, 1e-9, 1e-13, 1e-15] {
        for distance in [1.0, 1e4] {
            let what = format!("shadow's edge from {distance:e}, {width:e} wide");
            let eye = edge + dvec3(3.0, 0.5, 4.0) * distance;
            cases.push(Case::new(&what, &scene, &camera(eye, edge), [32, 32]));
            cases.last_mut().unwrap().pixels.view.h = width;
        }
        for look_at in [DVec3::ZERO, dvec3(1.0, 1.0, 0.0)] {
            let what = format!("contact at {look_at}, {width:e} wide");
            let eye = dvec3(3.0, 0.5, 4.0);
            cases.push(Case::new(&what, &scene, &camera(eye, look_at), [32, 32]));
            cases.last_mut().unwrap().pixels.view.h = width;
        }
        let what = format!("crossing, {width:e} wide");
        let eye = dvec3(3.0, 2.0, 4.0);
        cases.push(Case::new(&what, &crossing, &camera(eye, dvec3(-1.0, 0.0, 0.0)), [32, 32]));
        cases.last_mut().unwrap().pixels.view.h = width;
    }
    cases
}

#[test]
fn contacts_are_shaded_as_on_the_cpu() {
    assert_equal(&contacts(), 0.9);
}

#[test]
fn hard_scenes_are_shaded_as_on_the_cpu() {
    let mut cases = scenes_of("scenes/hard", [48, 27]);
    for case in &mut cases {
        let camera = case.scene.camera.clone().unwrap();
        let depth = camera.look_at - camera.position;
        let aside = depth.any_orthogonal_vector().normalize() * depth.length();
        let mut scene = (*case.scene).clone();
        scene.lights = vec![
            light(Source::Point(camera.position + aside * 0.3), 0.5),
            light(Source::Sun(depth.normalize() - DVec3::Y), 0.25),
            light(Source::Eye, 0.125),
        ];
        scene.sky = Some(Sky { intensity: 0.125, directions: 5 });
        case.scene = Arc::new(scene);
    }
    assert_equal(&cases, 0.5);
}

#[test]
fn lit_scenes_are_shaded_as_on_the_cpu() {
    assert_equal(&scenes_of("scenes/lit", [160, 90]), 0.001);
}

#[test]
fn lit_hard_scenes_are_shaded_as_on_the_cpu() {
    let (extreme, hard): (Vec<Case>, Vec<Case>) = scenes_of("scenes/lit/hard", [96, 54])
        .into_iter()
        .partition(|case| EXTREME.iter().any(|name| case.what.ends_with(&format!("/{name}.toml"))));
    assert_eq!(extreme.len(), EXTREME.len());
    assert_equal(&hard, 0.001);
    assert_equal(&extreme, 1.0);
}

/// Those whose numbers are at the ends of f64's range, or whose colours are on an edge: a device may leave them to
/// the CPU.
const EXTREME: [&str; 9] = [
    "along_1e-324",
    "along_1e-400",
    "along_leaning",
    "along_subnormal",
    "bright_eyes",
    "bright_sky",
    "byte_edge",
    "faint_light",
    "far_light",
];

/// Which of the edits of the shaders in f32 or f64 are in no picture's bytes or numbers.
fn missed(
    float: &'static str,
    encoding: Encoding,
    cases: &[Case],
    edits: &[(&'static str, &'static str)],
) -> Vec<&'static str> {
    let is_missed = |&&(from, to): &&(&'static str, &'static str)| {
        let gpu = edited(float, from, to);
        !cases.iter().any(|case| case.compare_in(encoding, &gpu).is_err())
    };
    edits.iter().filter(is_missed).map(|(from, _)| *from).collect()
}

/// What both have.
const IN_BOTH: [(&str, &str); 11] = [
    ("i < light_of_all.n_lamps", "i + 1u < light_of_all.n_lamps"),
    (
        "var sum = Light(light_of_all.ambient, light_of_all.ambient",
        "var sum = Light(Vec3(0.0), Vec3(0.0)",
    ),
    ("return beam_from(start, -direction, 0.0", "return beam_from(start, direction, 0.0"),
    ("beam.is_endless = true", "beam.is_endless = false"),
    ("position - start, 0.0", "start - position, 0.0"),
    ("if index + 1u != id {", "if false {"),
    ("if listed_planes[i].id != id {", "if false {"),
    ("place.y * params.width * n", "place.y * params.width"),
    ("light_of_all.leaves_out != 0u", "light_of_all.leaves_out == 0u"),
    ("* l2) * NARROW_OUTSIDE", "* l2) * 0.9f"),
    ("ROOM * (normal_error + beam.turned) + OF_COSINE * UNIT", "Real(-0.01)"),
];

/// The same among many spheres.
const IN_BOTH_TREES: [(&str, &str); 5] = [
    ("at + 1u, is_met || is_leaf)", "at + 1u, is_leaf)"),
    ("slab.far_origin) * slab.far_inverse", "slab.far_origin) * slab.far_inverse * 0.5f"),
    ("is_met && is_leaf && index", "is_leaf && false && index"),
    ("beam.start + light_of_all.to_tree", "beam.start"),
    ("* ASIDE_ROOM + beside", "* 0.0f - 0.02f"),
];

/// Each spoiled formula and each bound left out is seen as a wrong number: of 16 bits, which f64 finds at once.
#[test]
fn sabotage_is_noticed() {
    let (few, many) = (worlds(9), worlds(700));
    let mut near = contacts();
    near.extend(scenes_of("scenes/lit/hard", [96, 54]));
    let shorts = |cases: &[Case], edits: &[_]| missed("f64", Encoding::Srgb16, cases, edits);
    let mut all = shorts(&few, &IN_BOTH);
    all.extend(shorts(
        &few,
        &[
            ("select(unit, -unit, dot3", "select(unit, unit, dot3"),
            ("p - chord, -p - chord", "-p - chord, p - chord"),
            (
                "    if beam.is_endless {\n        return YES;",
                "    if beam.is_endless {\n        return NO;",
            ),
            ("NO, is_inside), in_range", "YES, is_inside), in_range"),
            ("let length = select(0.0, beam.length, beam.square > 0.0);", "let length = 0.5lf;"),
            ("3.5f * (NARROW_SLOPE + error)", "-0.1f"),
            ("(start > 0.0f) != (stop > 0.0f)", "(start > 0.0f) == (stop > 0.0f)"),
            ("OPEN_COLOR, number, is_one", "OPEN_COLOR, number ^ 1u, is_one"),
            ("colors[3u * index + 1u] = g", "colors[3u * index + 1u] = b"),
        ],
    ));
    let of_floats = [("bitcast<u32>(word), is_one", "bitcast<u32>(word) + 1u, is_one")];
    all.extend(missed("f64", Encoding::Linear, &few, &of_floats));
    all.extend(shorts(&many, &IN_BOTH_TREES));
    all.extend(shorts(&many, &[("return Met(known, 0u);", "return Met(2u - known, 0u);")]));
    all.extend(shorts(
        &near,
        &[
            ("let e = beam.error + UNIT * (OF_PLACE", "let e = 0.0 * UNIT * (OF_PLACE"),
            ("let start_error = ROOM * n * e;", "let start_error = Real(0.0);"),
            ("is_clear = (least2 > outer2)", "is_clear = (least2 > inner2)"),
            ("is_crossed = (least2 < inner2)", "is_crossed = (least2 < outer2)"),
            ("beam.error + NARROW_OFFSET * sqrt(l2)", "-1e-5f * sqrt(l2)"),
            ("let k = (own_r - r) *", "let k = (r - own_r) *"),
            ("return Met(meets_shell(", "return Met(2u - meets_shell("),
            ("(low - beam.start_low)", "0.0f * (low - beam.start_low)"),
            ("let start_error = plane.size *", "let start_error = 0.0f *"),
        ],
    ));
    assert!(all.is_empty(), "not noticed: {all:#?}");
}

/// The same of bytes, which f32 finds first. `tests/points.rs` and `tests/lemmas.rs` look at its bounds.
#[test]
fn sabotage_in_f32_is_noticed() {
    let (few, many) = (worlds(9), worlds(700));
    let mut near = contacts();
    near.extend(scenes_of("scenes/lit/hard", [96, 54]));
    let bytes = |cases: &[Case], edits: &[_]| missed("f32", Encoding::Srgb8, cases, edits);
    let mut all = bytes(&few, &IN_BOTH);
    all.extend(bytes(
        &few,
        &[
            ("select(plane.unit, -plane.unit", "select(-plane.unit, plane.unit"),
            ("let out = -p - chord", "let out = chord - p"),
            ("out * (sphere.inverse_radius * sphere.side)", "out * sphere.inverse_radius"),
            ("-aside * sphere.depth", "aside * sphere.depth"),
            ("narrow.center_low + out", "narrow.center_low"),
            ("(plane.slope.x + across) + up", "plane.slope.x + across"),
            ("(plane.offset - across) - up", "(plane.offset + across) - up"),
            ("NO, is_inside), in_range", "YES, is_inside), in_range"),
            ("(start > 0.0f) != (stop > 0.0f)", "(start > 0.0f) == (stop > 0.0f)"),
            ("r | g << 8u", "g | r << 8u"),
            ("OPEN_COLOR, number, is_one", "OPEN_COLOR, number ^ 1u, is_one"),
            ("- sphere.place_low.x", "- 0.01"),
            ("plane.slope.y * i", "plane.slope.y * (i + 0.01)"),
            ("edges[next - 1u] <= low", "edges[next - 1u] * 0.999 <= low"),
        ],
    ));
    all.extend(bytes(&many, &IN_BOTH_TREES));
    all.extend(bytes(&many, &[("return Met(known, 0u);", "return Met(2u - known, 0u);")]));
    all.extend(bytes(
        &near,
        &[
            ("is_clear = (least2 > outer2)", "is_clear = (least2 > inner2)"),
            ("is_crossed = (least2 < inner2)", "is_crossed = (least2 < outer2)"),
            ("beam.error + NARROW_OFFSET * sqrt(l2)", "-1e-5f * sqrt(l2)"),
        ],
    ));
    assert!(all.is_empty(), "not noticed: {all:#?}");
}

/// Where f32 is not sure, f64 is. A device that has none leaves that to the CPU.
#[test]
fn f32_is_sure_of_most_bytes() {
    let mut cases = scenes_of("scenes/lit", [320, 180]);
    cases.extend(worlds(700).into_iter().take(1));
    let [with, without] = [true, false].map(|has_f64| {
        let mut gpu = open();
        gpu.facts.f64 &= has_f64;
        Arc::new(gpu)
    });
    for case in &cases {
        let done = case.compare_in(Encoding::Srgb8, &with).unwrap_or_else(|what| panic!("{what}"));
        let alone =
            case.compare_in(Encoding::Srgb8, &without).unwrap_or_else(|what| panic!("{what}"));
        let open = 1.0 - done.in_f32 as f64 / done.pixels as f64;
        println!("{}: f32 leaves {:.2} % open", case.what, 100.0 * open);
        assert_eq!((alone.in_f32, alone.left), (done.in_f32, done.pixels - done.in_f32));
        assert!(open < 0.1, "{}: {open}", case.what);
    }
}
