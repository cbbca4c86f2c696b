//! What light costs. Which bytes are right is the matrix's to say, and that files hold them the answers' and Python's.

use std::num::NonZeroUsize;
use std::sync::Arc;

use kugelblitz::Control;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::gpu::Gpu;
use kugelblitz::lighting::{Encoding, Style, certified_lighting};
use kugelblitz::num::UNDECIDED;
use kugelblitz::prepare::Prepared;
use kugelblitz::query::{Kernel, Outputs, Rays, StageCounts};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Samples, Scene, parse_scene, read_scene};
use kugelblitz_judge::verify::Verification;
use kugelblitz_tests::root;

/// The stages that decided the ways to lights.
fn shadow_rays(file: &str, n_samples: u32) -> StageCounts {
    let scene = read_scene(&root().join("scenes/lit").join(file)).unwrap();
    let mut session = Session::new(scene, Device::Cpu, Kernel::Certified);
    let pixels = session.pixels(48, 27).unwrap();
    let style = Style { n_samples: Samples::nearest(n_samples), ..Style::new(Encoding::Linear) };
    let drawn = session.keep(&pixels, style, Outputs::default(), &Control::default());
    drawn.unwrap().1.shadow_rays
}

/// What is near a point is as well known in the light of a lamp 10²⁵ away as in that of one at hand, and planes in one place
/// are one.
#[test]
fn far_lamps_and_planes_in_one_place_need_no_exact_arithmetic() {
    let StageCounts { f64, exact, .. } = shadow_rays("hard/far_light.toml", 4);
    assert!(f64 > 10_000 && exact < 10, "{f64} in f64, {exact} exactly");
    assert_eq!(shadow_rays("hard/coincident_floor.toml", 1).exact, 0);
}

/// A sphere is a plane to 300 digits where it is vast and all else tiny, so that numbers cancel thousands of bits.
#[test]
fn a_vast_sphere_is_lit_as_a_plane() {
    for e in [-302, -307, -310, -320] {
        let [sphere, plane] = [
            "sphere = [{ center = [0, -8e307, 0], radius = 8e307, color = [1, 1, 1] }]",
            "plane = [{ point = [0, 0, 0], normal = [0, 1, 0], color = [1, 1, 1] }]",
        ]
        .map(|object| {
            let text = format!(
                "camera = {{ position = [0, 1e{e}, 0], look_at = [1e{e}, 0, 0], fov = 60 }}\n\
                 light = [{{ position = [1e{e}, 2e{e}, 0] }}]\n{object}"
            );
            let scene = parse_scene(&text, "vast.toml".as_ref()).unwrap();
            let mut session = Session::new(scene, Device::Cpu, Kernel::Certified);
            let pixels = session.pixels(6, 4).unwrap();
            session.colors::<[f32; 3]>(&pixels, Samples::ONE, &Control::default()).unwrap()
        });
        assert_eq!(sphere, plane, "1e{e}");
    }
}

/// The share of pixels that a device that lights by itself leaves open.
fn left_open(scene: &Scene, [width, height]: [u32; 2], n: u32) -> f64 {
    let gpu = Arc::new(Gpu::open("").unwrap().always_lights());
    let view = View::new(scene.camera.as_ref().unwrap());
    let pixels = Pixels::whole(view, width, height);
    let rays = Rays::Pixels(pixels.samples(n));
    let prepared = Prepared::new(Arc::new(scene.clone()), Kernel::Certified, &rays).unwrap();
    let prepared = Arc::new(prepared);
    let lighting = certified_lighting(&prepared, &pixels, Samples::nearest(n)).unwrap();
    let mut tracer = Device::Gpu(gpu).tracer(&prepared, Outputs::default()).unwrap().tracer;
    let device = tracer.backend().unwrap();
    let codes = device.light(&lighting, &pixels, &Control::default()).unwrap().expect("its light");
    let n_open = codes.iter().filter(|&&code| code == UNDECIDED).count();
    n_open as f64 / codes.len() as f64
}

/// Spheres that appear large, and are found through a tree, on a floor, in the light of a lamp and of more.
fn heap(more: &str) -> Scene {
    let at = |i: i32| (f64::from(i % 5) - 2.0, f64::from(i / 25), f64::from(i / 5 % 5) - 2.0);
    let sphere = |i| {
        let (x, y, z) = at(i);
        format!("[[sphere]]\ncenter = [{x}, {y}, {z}]\nradius = 0.4\ncolor = [0.8, 0.5, 0.2]\n")
    };
    let spheres: String = (0..75).map(sphere).collect();
    let text = "camera = { position = [3, 4, 7], look_at = [0, 0.8, 0], fov = 40 }\n\
         plane = [{ point = [0, -0.4, 0], normal = [0, 1, 0], color = [0.5, 0.5, 0.5] }]\n\
         light = [{ position = [5, 9, 4], intensity = 0.7 }]\n";
    parse_scene(&format!("{text}{more}{spheres}"), "heap.toml".as_ref()).unwrap()
}

#[test]
fn a_device_leaves_some_pixels_of_a_heap_open() {
    let sky = "sky = { intensity = 0.3, directions = 8 }\n";
    for (light, n) in [("", 1), ("", 3), (sky, 2)] {
        let open = left_open(&heap(light), [320, 180], n);
        assert!((0.001..0.03).contains(&open), "{n} x {n}, {light}: {open}");
    }
}

#[test]
fn a_device_leaves_few_pixels_of_the_figures_open() {
    for file in ["figure1.toml", "figure2.toml"] {
        let scene = read_scene(&root().join("scenes/lit").join(file)).unwrap();
        for n in [1, 3] {
            let open = left_open(&scene, [320, 180], n);
            assert!(open <= 0.015, "{file}, {n} x {n}: {open}");
        }
    }
}

/// Verification has the device compute the light, even on a software device, where the CPU would be faster.
#[test]
fn verification_notices_mistakes_in_light_on_a_device() {
    let scene = Arc::new(heap(""));
    let pixels = Pixels::whole(View::new(scene.camera.as_ref().unwrap()), 96, 54);
    let verification = Verification::new(&scene, &pixels, NonZeroUsize::new(1), 0);
    let hidden = "select(given.high, 0.0, 0.0 < verdict.blocked)";
    let cosine = "sum + lamp.weight * way.cosine";
    for (kernel, right, wrong) in [
        (Kernel::Certified, hidden, "select(0.0, given.high, 0.0 < verdict.blocked)"),
        (Kernel::Stable, cosine, "sum + lamp.weight"),
    ] {
        for text in [right, wrong] {
            let gpu = Gpu::open("").unwrap().edit_shaders(move |wgsl| wgsl.replace(right, text));
            let is_promised = kernel == Kernel::Certified || gpu.is_ieee(kernel).unwrap();
            let device = Device::Gpu(Arc::new(gpu));
            let verified = verification.run(&[kernel], |_| &device, &Control::default()).unwrap();
            let is_broken = !verified.broken().is_empty();
            assert_eq!(is_broken, text == wrong && is_promised, "{text}: {:?}", verified.broken());
        }
    }
}

/// A device also counts shadow rays of surfaces that face away from the light. `docs/json.md` documents the difference.
#[test]
fn a_device_counts_all_shadow_rays() {
    let scene = Arc::new(heap(""));
    let count = |device: Device| {
        let mut session = Session::new(Arc::clone(&scene), device, Kernel::Certified);
        session.force_light_on_device();
        let pixels = session.pixels(96, 54).unwrap();
        let style = Style::new(Encoding::Srgb8);
        let drawn = session.keep(&pixels, style, Outputs::default(), &Control::default());
        let rendered = drawn.unwrap().1;
        (rendered.shadow_rays.total(), rendered.colors.device, rendered.hits)
    };
    let (on_cpu, 0, n_hits) = count(Device::Cpu) else { panic!("light on the CPU") };
    let (on_device, n_pixels, _) = count(Device::Gpu(Arc::new(Gpu::open("").unwrap())));
    assert!(n_pixels > 0, "no light on the device");
    assert!(on_cpu < on_device && on_device <= n_hits, "{on_cpu} {on_device} {n_hits}");
}
