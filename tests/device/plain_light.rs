//! Light as the kernels without a proof compute it: on a device that keeps to IEEE 754, in the operations of the
//! CPU, and so bit by bit in its numbers.

use std::sync::Arc;

use glam::dvec3;
use kugelblitz::control::Control;
use kugelblitz::cpu::CpuTracer;
use kugelblitz::device::Device;
use kugelblitz::gpu::{Gpu, GpuTracer, Pick};
use kugelblitz::prepare::{PlainLighting, Prepared};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{
    Camera, Color, Light, Projection, Samples, Scene, Sky, Source, Sphere, read_scene,
};
use kugelblitz::shade::{Background, Colors, Encoding, Lighting, Painter, Style};
use kugelblitz::trace::{Hits, Kernel, Rays, Wants};
use kugelblitz::tracer::Tracer;
use kugelblitz::verify::{Shown, broken_color_promises, compare_colors};
use kugelblitz_tests::{camera, in_cube, plane, root, sphere};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

const PLAIN: [Kernel; 3] = [Kernel::Lecture, Kernel::Stable, Kernel::Double];

/// A picture to be lit.
#[derive(Clone)]
struct Case {
    what: String,
    scene: Arc<Scene>,
    pixels: Pixels,
    style: Style,
}

/// Colours, and how many pixels have theirs from the device.
struct Lit {
    bits: Vec<[u32; 3]>,
    n_on_device: u64,
    n_ways: u64,
}

impl Case {
    fn new(what: &str, scene: &Arc<Scene>, camera: &Camera, [width, height]: [u32; 2]) -> Case {
        let pixels = Pixels::whole(View::new(camera), width, height);
        let (what, scene) = (what.to_string(), Arc::clone(scene));
        Case { what, scene, pixels, style: Style::new(Encoding::Linear) }
    }

    fn with(&self, n_samples: u32, epsilon: f64, background: Background) -> Case {
        let style =
            Style { n_samples: Samples::nearest(n_samples), epsilon, background, ..self.style };
        let what = format!("{}, {n_samples} samples, epsilon {epsilon:e}", self.what);
        Case { what, style, ..self.clone() }
    }

    fn prepared(&self, kernel: Kernel, n_samples: u32) -> Arc<Prepared> {
        let rays = Rays::Pixels(self.pixels.samples(n_samples));
        Arc::new(Prepared::new(Arc::clone(&self.scene), kernel, &rays).unwrap())
    }

    fn paint(&self, kernel: Kernel, tracer: impl Fn(Arc<Prepared>) -> Box<dyn Tracer>) -> Lit {
        let (control, mut hits) = (Control::default(), Hits::default());
        let Style { n_samples, encoding, .. } = self.style;
        let of_samples = self.prepared(kernel, n_samples.across());
        let mut of_pixels = tracer(self.prepared(kernel, 1));
        of_pixels.trace(&Rays::Pixels(self.pixels), &control, &mut hits).unwrap();
        let mut samples_tracer =
            (n_samples > Samples::ONE).then(|| tracer(Arc::clone(&of_samples)));
        let samples_tracer = samples_tracer.as_deref_mut();
        let mut painter = Painter::new(&of_samples, self.style, &self.pixels, samples_tracer);
        let mut colors = Colors::new(encoding);
        let painted = painter
            .paint_with(Some(&mut *of_pixels), &self.pixels, &hits, &control, &mut colors)
            .unwrap();
        let bits = match colors {
            Colors::Srgb8(colors) => colors.iter().map(|color| color.map(u32::from)).collect(),
            Colors::Srgb16(colors) => colors.iter().map(|color| color.map(u32::from)).collect(),
            Colors::Linear(colors) => colors.iter().map(|color| color.map(f32::to_bits)).collect(),
        };
        let n_ways = painted.shadow_rays.total();
        Lit { bits, n_on_device: painted.colors.device, n_ways }
    }

    /// The ways to lamps that were looked along, or where the device's picture differs from the CPU's.
    fn compare(&self, kernel: Kernel, gpu: &Arc<Gpu>) -> Result<u64, String> {
        let (wants, what) = (Wants::default(), format!("{}, {}", self.what, kernel.name()));
        let on_cpu = self.paint(kernel, |prepared| Box::new(CpuTracer::new(prepared, wants)));
        assert_eq!(on_cpu.n_on_device, 0, "{what}");
        let on_gpu = self.paint(kernel, |prepared| {
            Box::new(GpuTracer::new(Arc::clone(gpu), prepared, wants).unwrap())
        });
        // A device in software has no loop that is long enough for very many objects and lamps.
        let n_lamps = Lighting::new(&self.scene, &self.pixels.view).unwrap().lamps.len();
        if self.scene.n_objects() * n_lamps < 1 << 15 {
            assert_eq!(on_gpu.n_on_device, self.pixels.len() as u64, "{what}");
        }
        assert_eq!(on_gpu.n_ways, on_cpu.n_ways, "{what}");
        // On other devices no more is promised than that a picture comes.
        if !gpu.is_ieee(kernel).unwrap() {
            return Ok(on_cpu.n_ways);
        }
        match (0..on_cpu.bits.len()).find(|&at| on_cpu.bits[at] != on_gpu.bits[at]) {
            None => Ok(on_cpu.n_ways),
            Some(at) => {
                let (place, cpu, gpu) = (self.pixels.xy(at), on_cpu.bits[at], on_gpu.bits[at]);
                Err(format!("{what} at {place:?}: {cpu:x?}, on the device {gpu:x?}"))
            }
        }
    }
}

/// A device that lights each scene, with other words in the shaders that do.
fn device(edits: &[(&'static str, &'static str)]) -> Arc<Gpu> {
    let edits = edits.to_vec();
    let gpu = Gpu::open(&Pick::Best).expect("a Vulkan device; ci/setup.sh installs one");
    Arc::new(gpu.always_lights_plainly().edit_shaders(move |wgsl| {
        let edit = |wgsl: String, (from, to): &(&str, &str)| {
            assert!(wgsl.contains(from), "{from}");
            wgsl.replace(from, to)
        };
        match wgsl.contains("struct Lighting") {
            true => edits.iter().fold(wgsl.to_string(), edit),
            false => wgsl.into(),
        }
    }))
}

/// Whether the device runs a kernel.
fn runs(gpu: &Gpu, kernel: Kernel) -> bool {
    gpu.facts.check_kernel(kernel).is_ok()
}

/// Compares pictures in all kernels.
fn assert_equal(cases: &[Case]) {
    let gpu = device(&[]);
    let mut n_ways = 0;
    for case in cases {
        for kernel in PLAIN.into_iter().filter(|&kernel| runs(&gpu, kernel)) {
            n_ways += case.compare(kernel, &gpu).unwrap_or_else(|what| panic!("{what}"));
        }
    }
    println!("{n_ways} ways to lamps in {} pictures", cases.len());
    assert!(n_ways > 100_000, "{n_ways}");
}

/// The scenes of a folder as their cameras see them.
fn scenes_of(folder: &str, size: [u32; 2]) -> Vec<Case> {
    let folder = root().join(folder);
    let files = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> =
        files.filter(|path| path.extension().is_some_and(|ending| ending == "toml")).collect();
    files.sort();
    let case = |path: &std::path::PathBuf| {
        let scene = Arc::new(read_scene(path).unwrap());
        let camera = scene.camera.clone().unwrap();
        // Each ray of a plain kernel looks at all objects.
        let size = if scene.n_objects() > 1000 { [24, 14] } else { size };
        Case::new(&path.display().to_string(), &scene, &camera, size)
    };
    files.iter().map(case).collect()
}

fn light(source: Source, intensity: f64) -> Light {
    Light { source, color: Color([1.0, 0.875, 0.75]), intensity, shadows: true }
}

/// Lights of each kind, and a sky.
fn lit(scene: Scene, directions: u32) -> Scene {
    let lights = vec![
        light(Source::Point(dvec3(3.0, 4.0, 2.0)), 0.5),
        light(Source::Sun(dvec3(-1.0, -2.0, -0.7)), 0.25),
        light(Source::Eye, 0.125),
        // Just above the floor.
        light(Source::Point(dvec3(0.3, -2.49, 0.2)), 0.25),
        Light { shadows: false, ..light(Source::Point(dvec3(-4.0, 1.0, 3.0)), 0.125) },
    ];
    let (sky, ambient) = (Some(Sky { intensity: 0.125, directions }), Some(Color([0.03; 3])));
    Scene { lights, sky, ambient, ..scene }
}

/// Some balls over a floor and beside a wall, from outside and from inside of one of them, and by both cameras.
fn worlds(n_spheres: usize, directions: u32) -> Vec<Case> {
    let mut rng = ChaCha8Rng::seed_from_u64(1441 + n_spheres as u64);
    let size = 1.5 / (n_spheres as f64).cbrt();
    let mut spheres: Vec<Sphere> =
        (0..n_spheres).map(|_| sphere(in_cube(&mut rng) * 2.0, size)).collect();
    spheres[0] = sphere(dvec3(0.0, 0.0, 1.0), 5.6);
    let color = |k: usize| Color([0.9 - 0.01 * (k % 50) as f64, 0.2, 0.1 * (k % 9) as f64]);
    let planes = vec![
        plane(dvec3(0.0, -2.5, 0.0), dvec3(0.0, 3.0, 0.0)),
        plane(dvec3(-4.0, 0.0, 0.0), dvec3(1.0, 0.2, 0.1)),
    ];
    let spheres = spheres.into_iter().enumerate().map(|(k, sphere)| (sphere, color(k))).collect();
    let scene = Arc::new(lit(Scene { spheres, planes, ..Scene::default() }, directions));
    let outside = camera(dvec3(1.0, 1.5, 9.0), dvec3(0.0, -0.25, 0.0));
    let inside = camera(dvec3(0.1, 0.2, 2.3), dvec3(0.0, 0.0, -1.0));
    let across = Camera { projection: Projection::Orthographic { height: 6.0 }, ..outside.clone() };
    let cameras = [("outside", outside), ("inside", inside), ("across", across)];
    let case = |(view, camera): (&str, Camera)| {
        Case::new(&format!("{n_spheres} balls, {view}"), &scene, &camera, [40, 30])
    };
    cameras.map(case).into()
}

/// Each with one sample and with more, with and without epsilon, and before each kind of background.
fn in_all_styles(cases: Vec<Case>) -> Vec<Case> {
    let in_styles = |case: Case| {
        [
            case.with(1, 0.0, Background::Shown),
            case.with(1, 1e-3, Background::Black),
            case.with(2, 1e-4, Background::LeftOut),
            case.with(3, 0.0, Background::Shown),
        ]
    };
    cases.into_iter().flat_map(in_styles).collect()
}

#[test]
fn few_objects_are_lit_as_on_the_cpu() {
    assert_equal(&in_all_styles(worlds(9, 7)));
}

/// Objects that are not kept, and such as the shader goes through in a loop.
#[test]
fn many_objects_are_lit_as_on_the_cpu() {
    assert_equal(&[worlds(40, 2), worlds(90, 2)].concat());
}

#[test]
fn many_lamps_light_as_on_the_cpu() {
    let n_lamps = PlainLighting::FEW_LAMPS as u32 + 1;
    for n_spheres in [3, 30] {
        assert_equal(&worlds(n_spheres, n_lamps));
    }
}

#[test]
fn lit_scenes_are_lit_as_on_the_cpu() {
    let cases = scenes_of("scenes/lit", [96, 54]);
    let with = |case: &Case| {
        let n_samples = if case.scene.n_objects() > 1000 { 1 } else { 3 };
        [case.with(1, 1e-4, Background::Shown), case.with(n_samples, 0.0, Background::LeftOut)]
    };
    assert_equal(&cases.iter().flat_map(with).collect::<Vec<_>>());
}

/// Acne and leaks, point by point the same.
#[test]
fn lit_hard_scenes_are_lit_as_on_the_cpu() {
    let cases = scenes_of("scenes/lit/hard", [96, 54]);
    let with =
        |case: &Case| [0.0, 1e-4, 1e-1].map(|epsilon| case.with(1, epsilon, Background::Shown));
    assert_equal(&cases.iter().flat_map(with).collect::<Vec<_>>());
}

/// Pictures of several dispatches, parts of pictures, and all numbers that colours are written as.
#[test]
fn tiles_crops_and_encodings_are_lit_as_on_the_cpu() {
    let few = worlds(9, 7);
    let mut cases = Vec::new();
    for case in [&few[0], &few[2]] {
        for encoding in [Encoding::Srgb8, Encoding::Srgb16, Encoding::Linear] {
            let style = Style { encoding, ..case.style };
            let large = Pixels::whole(case.pixels.view, 301, 211);
            let part = Pixels { x: 17, y: 23, width: 31, height: 7, ..large };
            cases.push(Case { style, pixels: large, ..case.clone() });
            cases.push(Case { style, pixels: part, ..case.with(2, 0.0, Background::Shown) });
            cases.last_mut().unwrap().style.encoding = encoding;
        }
    }
    assert_equal(&cases);
}

/// A tracer that is given another scene, camera or epsilon lights with that.
#[test]
fn a_device_lights_what_it_has_been_given_last() {
    let gpu = device(&[]);
    let cases = [worlds(9, 7), worlds(9, 3), worlds(30, 7)].concat();
    let kernel = Kernel::Stable;
    let (control, wants) = (Control::default(), Wants::default());
    let mut tracer = GpuTracer::new(Arc::clone(&gpu), cases[0].prepared(kernel, 1), wants).unwrap();
    for case in cases
        .iter()
        .flat_map(|case| [0.0, 0.01].map(|epsilon| case.with(1, epsilon, Background::Shown)))
    {
        let prepared = case.prepared(kernel, 1);
        tracer.retarget(Arc::clone(&prepared)).unwrap();
        let on_cpu = case.paint(kernel, |prepared| Box::new(CpuTracer::new(prepared, wants)));
        let (mut hits, mut colors) = (Hits::default(), Colors::new(Encoding::Linear));
        tracer.trace(&Rays::Pixels(case.pixels), &control, &mut hits).unwrap();
        let mut painter = Painter::new(&prepared, case.style, &case.pixels, None);
        painter.paint_with(Some(&mut tracer), &case.pixels, &hits, &control, &mut colors).unwrap();
        let Colors::Linear(colors) = colors else { panic!("linear colours") };
        if gpu.is_ieee(kernel).unwrap() {
            let bits: Vec<_> = colors.iter().map(|color| color.map(f32::to_bits)).collect();
            assert!(bits == on_cpu.bits, "{}", case.what);
        }
    }
}

/// Each spoiled formula is seen as a wrong colour, of every kernel.
#[test]
fn sabotage_is_noticed() {
    let mut cases = worlds(9, 7);
    let contacts = scenes_of("scenes/lit/hard", [96, 54]);
    cases.extend(contacts.into_iter().filter(|case| case.what.ends_with("contacts.toml")));
    cases.extend(cases.clone().iter().map(|case| case.with(1, 0.3, Background::Shown)));
    let all = [
        ("var sum = lighting.ambient", "var sum = Vec3(0.0)"),
        ("i < lighting.n_lamps", "i + 1u < lighting.n_lamps"),
        ("sum += lamp.weight * way.cosine", "sum += lamp.weight"),
        ("way.cosine > 0.0 && !way.is_blocked", "way.cosine > 0.0"),
        ("&& lamp.shadows != 0u", ""),
        ("way = -(ray.direction * hit.t)", "way = ray.direction * hit.t"),
        ("way = lamp.at - point", "way = point - lamp.at"),
        ("ray.origin + ray.direction * hit.t;\n    var way", "ray.direction;\n    var way"),
        ("dot3(normal, way) * (1.0 / length)", "dot3(normal, way)"),
        ("lighting.epsilon / length", "lighting.epsilon"),
        ("point + way * step", "point"),
        ("(is_endless || hit.t < 1.0 - step)", "hit.t < 1.0 - step"),
        ("(is_endless || hit.t < 1.0 - step)", "true"),
        ("hit.t < 1.0 - step", "hit.t < 1.0"),
        ("lamp.kind == LAMP_SUN);", "false);"),
        ("lights[3u * index + 1u] = seen.y", "lights[3u * index + 1u] = seen.z"),
    ];
    for kernel in PLAIN {
        for edit in all {
            let gpu = device(&[edit]);
            if !runs(&gpu, kernel) || !gpu.is_ieee(kernel).unwrap() {
                continue;
            }
            let is_seen = cases.iter().any(|case| case.compare(kernel, &gpu).is_err());
            assert!(is_seen, "{}: {} is not noticed", kernel.name(), edit.0);
        }
    }
    // An operation more or less, and what is relative to the ray's origin.
    let (times, by) = ("dot3(normal, way) * (1.0 / length)", "dot3(normal, way) / length");
    for (kernel, from, to) in [
        (Kernel::Lecture, times, by),
        (Kernel::Stable, times, by),
        (
            Kernel::Stable,
            "+ (sphere.center_low - ray.origin_low);\n    return SphereStable",
            ";\n    return SphereStable",
        ),
        (Kernel::Stable, "PlaneStable(l, dot3(l, plane.normal)", "PlaneStable(l, plane.n_offset"),
        (
            Kernel::Double,
            "SphereDouble(l, sphere.radius, dot3(l, l)",
            "SphereDouble(l, sphere.radius, dot3(l, sphere.center)",
        ),
        (Kernel::Double, "PlaneDouble(l, dot3(l, plane.normal)", "PlaneDouble(l, plane.n_offset"),
    ] {
        let points = &cases[..2];
        let gpu = device(&[(from, to)]);
        if runs(&gpu, kernel) && gpu.is_ieee(kernel).unwrap() {
            let is_seen = points.iter().any(|case| case.compare(kernel, &gpu).is_err());
            assert!(is_seen, "{}: {from} is not noticed", kernel.name());
        }
    }
}

/// `verify` sees colours of a device that are not those of the CPU.
#[test]
fn a_spoiled_shader_breaks_the_promise() {
    let case = &worlds(9, 7)[0];
    let kernel = Kernel::Stable;
    let shown = |device: Device| {
        let (control, mut hits) = (Control::default(), Hits::default());
        let prepared = case.prepared(kernel, 1);
        let mut tracer = device.tracer(&prepared, Wants::default()).unwrap().tracer;
        tracer.trace(&Rays::Pixels(case.pixels), &control, &mut hits).unwrap();
        Shown::painted(&prepared, &case.pixels, Samples::ONE, &hits, &mut *tracer, None, &control)
            .unwrap()
    };
    let on_cpu = shown(Device::Cpu);
    let edits = [("hit.id != 0u && (is_endless", "hit.id == 0u && (is_endless")];
    for (edits, n_broken) in [(&edits[..0], 0), (&edits[..], 1)] {
        let gpu = device(edits);
        if gpu.is_ieee(kernel).unwrap() {
            let parity = compare_colors(&shown(Device::Gpu(gpu)), &on_cpu);
            let broken = broken_color_promises(kernel, true, Some(&parity), &[]);
            assert_eq!(broken.len(), n_broken, "{broken:?}");
            assert_eq!(broken_color_promises(kernel, false, Some(&parity), &[]).len(), 0);
        }
    }
}
