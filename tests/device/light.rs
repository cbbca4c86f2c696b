//! Lit pictures against the oracle of light and colour, against each other, and as files. The random
//! ones are in `light_campaign.rs`.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use exr::prelude::{ReadChannels, ReadLayers};
use glam::{DVec3, dvec3};
use kugelblitz::Session;
use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::memory::Available;
use kugelblitz::output::{OutputFile, commit};
use kugelblitz::picture::{Bits, Format, PictureOptions};
use kugelblitz::rays::{Lens, Pixels, View};
use kugelblitz::render::plan;
use kugelblitz::scene::{
    Color, Light, Plane, Samples, Scene, Sky, Source, Sphere, linear_from_srgb, parse_scene,
    read_scene,
};
use kugelblitz::shade::Background;
use kugelblitz::trace::{Kernel, StageCounts};
use kugelblitz_tests::light_cases::light_case;
use kugelblitz_tests::light_judge::{LightCase, Painted, judge, scene_text};
use kugelblitz_tests::{camera, cases, gpu, in_cube, log_uniform, root};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const CPU: &Device = &Device::Cpu;

fn light(source: Source, intensity: f64) -> Light {
    Light { source, color: Color([1.0, 0.875, 0.75]), intensity, shadows: true }
}

fn sphere(center: DVec3, radius: f64) -> (Sphere, Color) {
    (Sphere { center, radius }, Color([0.9, 0.6, 0.3]))
}

fn plane(point: DVec3, normal: DVec3) -> Plane {
    Plane { name: None, point, normal, color: Color([0.5, 0.5, 0.75]) }
}

/// Judges every `step`-th pixel, and fails with what is wrong.
fn assert_right(name: &str, case: &LightCase, device: &Device, step: usize) {
    let judged = judge(case, &case.paint(device), step);
    let tally = judged.unwrap_or_else(|what| panic!("{name} on the {}: {what}", device.kind()));
    assert!(tally.pixels > 0, "{name}");
}

// ---------------------------------------------------------------------------------------------
// Scenes where light is hard

/// The scenes that renderers in f32 get wrong, with lights near the camera, above, and in the eye.
#[test]
fn hard_scenes_are_lit_right() {
    let folder = &root().join("scenes/hard");
    let mut n = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let mut scene = read_scene(&path).unwrap_or_else(|error| panic!("{error}"));
        let camera = scene.camera.clone().expect("a camera");
        let depth = camera.look_at - camera.position;
        let aside = depth.any_orthogonal_vector().normalize() * depth.length();
        scene.lights = vec![
            light(Source::Point(camera.position + aside * 0.3), 0.5),
            light(Source::Sun(depth.normalize() - DVec3::Y), 0.25),
            light(Source::Eye, 0.125),
        ];
        scene.sky = Some(Sky { intensity: 0.125, directions: 5 });
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        for (pixels, n_samples) in [
            (Pixels::whole(View::new(&camera), 41, 23), 1),
            (Pixels::whole(View::new(&camera), 13, 9), 3),
        ] {
            let case = LightCase::new(scene.clone(), pixels, n_samples);
            assert_right(&name, &case, CPU, 1);
            if n_samples == 1 {
                assert_right(&name, &case, &Device::Gpu(gpu()), 7);
            }
        }
        n += 1;
    }
    assert!(n > 10, "{n} hard scenes");
}

/// The scenes whose light is hard, numbers at the ends of f64's range among them.
#[test]
fn scenes_of_hard_light_are_lit_right() {
    let folder = root().join("scenes/lit/hard");
    let gpu = Device::Gpu(gpu());
    let mut n = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let scene = read_scene(&path).unwrap_or_else(|error| panic!("{error}"));
        let view = View::new(scene.camera.as_ref().expect("a camera"));
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        for (size, n_samples) in [([12, 8], 1), ([5, 4], 2)] {
            let pixels = Pixels::whole(view, size[0], size[1]);
            let case = LightCase::new(scene.clone(), pixels, n_samples);
            assert_right(&name, &case, CPU, 1);
            assert_right(&name, &case, &gpu, 3);
        }
        n += 1;
    }
    assert!(n >= 19, "{n} scenes");
}

/// What is near a point is as well known in the light of a lamp 10²⁵ away as in that of one at hand.
#[test]
fn far_lamps_need_no_exact_arithmetic() {
    let scene = read_scene(&root().join("scenes/lit/hard/far_light.toml"));
    let scene = scene.unwrap_or_else(|error| panic!("{error}"));
    let view = View::new(scene.camera.as_ref().unwrap());
    let case = LightCase::new(scene, Pixels::whole(view, 48, 27), 4);
    let StageCounts { f64, exact, .. } = case.paint(CPU).shadow_rays;
    assert!(f64 > 10_000 && exact < 10, "{f64} in f64, {exact} exactly");
}

/// A thousand planes in one place, whose normals have other lengths: the first one is seen, and f64 knows it.
#[test]
fn planes_in_one_place_are_one() {
    let mut rng = ChaCha8Rng::seed_from_u64(2404);
    let planes = (0..1000)
        .map(|_| {
            let across = dvec3(rng.random_range(-4.0..4.0), 0.0, rng.random_range(-4.0..4.0));
            plane(across, DVec3::Y * rng.random_range(-9.0..9.0))
        })
        .collect();
    let scene = Scene {
        planes,
        spheres: [sphere(DVec3::Y, 1.0)].into_iter().collect(),
        lights: vec![light(Source::Point(dvec3(4.0, 6.0, 3.0)), 0.9)],
        ..Scene::default()
    };
    let view = View::new(&camera(dvec3(3.0, 3.0, 8.0), DVec3::Y));
    let case = LightCase::new(scene, Pixels::whole(view, 24, 18), 1);
    let painted = case.paint(CPU);
    assert_eq!(painted.shadow_rays.exact, 0);
    assert!(painted.ids.iter().all(|id| *id <= 2) && painted.ids.contains(&2));
    assert_right("planes in one place", &case, CPU, 29);
}

/// A ball on a floor and a ball on it, seen so that the contacts are at `10⁻⁹` of the radius; moved and
/// scaled.
#[test]
fn contacts_are_dark_to_the_last_pixel() {
    for (by, scale) in [(0.0, 1.0), (0.0, 1e-6), (1e8, 1.0), (0.0, 1e6)] {
        for width in [1e-1, 1e-5, 1e-9, 1e-13] {
            let at = |v: DVec3| (v + DVec3::splat(by)) * scale;
            let contact = at(dvec3(0.0, 2.0, 0.0));
            let scene = Scene {
                spheres: [
                    sphere(at(dvec3(0.0, 1.0, 0.0)), scale),
                    sphere(at(dvec3(0.0, 3.0, 0.0)), scale),
                    sphere(at(dvec3(2.0, 1.0, 0.0)), scale),
                ]
                .into_iter()
                .collect(),
                planes: vec![plane(at(DVec3::ZERO), DVec3::Y)],
                lights: vec![
                    light(Source::Point(at(dvec3(4.0, 6.0, 3.0))), 0.7),
                    light(Source::Sun(dvec3(-1.0, -1e-5, -1.0)), 0.3),
                ],
                ambient: Some(Color([0.03125; 3])),
                ..Scene::default()
            };
            let mut view = View::new(&camera(at(dvec3(0.0, 2.0, 5.0)), contact));
            view.h = width;
            assert_right(
                "upper contact",
                &LightCase::new(scene.clone(), Pixels::whole(view, 15, 15), 1),
                CPU,
                1,
            );
            let floor = at(DVec3::ZERO);
            let mut view = View::new(&camera(at(dvec3(3.0, 0.5, 4.0)), floor));
            view.h = width;
            assert_right(
                "floor's contact",
                &LightCase::new(scene, Pixels::whole(view, 11, 11), 2),
                CPU,
                1,
            );
        }
    }
}

/// Shells around each other, with light outside, between and inside.
#[test]
fn thin_shells_shadow() {
    for gap in [4e-5, 1e-9, f64::EPSILON] {
        for outward in [2.0, 1.0 + gap / 2.0, 0.5] {
            let lamp = dvec3(2.0, 3.0, 6.0) / 7.0 * outward;
            let scene = Scene {
                spheres: [sphere(DVec3::ZERO, 1.0 + gap), sphere(DVec3::ZERO, 1.0)]
                    .into_iter()
                    .collect(),
                lights: vec![light(Source::Point(lamp), 0.75)],
                sky: Some(Sky { intensity: 0.25, directions: 3 }),
                ..Scene::default()
            };
            for eye in
                [dvec3(0.0, 0.0, 3.0), dvec3(0.0, 0.0, 1.0 + gap / 2.0), dvec3(0.1, 0.2, 0.3)]
            {
                let view = View::new(&camera(eye, dvec3(0.25, 0.125, -9.0)));
                let case = LightCase::new(scene.clone(), Pixels::whole(view, 12, 9), 1);
                assert_right("shells", &case, CPU, 1);
            }
        }
    }
}

/// A ground of radius 10⁹ with balls on it, as it is, far away and tiny.
#[test]
fn a_ground_as_large_as_a_planet() {
    for (by, scale) in [(0.0, 1.0), (1e8, 1.0), (0.0, 1e-6)] {
        let at = |v: DVec3| (v + DVec3::splat(by)) * scale;
        let scene = Scene {
            spheres: [
                sphere(at(dvec3(0.0, -1e9, 0.0)), 1e9 * scale),
                sphere(at(dvec3(0.0, 1.0, 0.0)), scale),
                sphere(at(dvec3(1.5, 0.5, 1.0)), 0.5 * scale),
            ]
            .into_iter()
            .collect(),
            lights: vec![
                light(Source::Point(at(dvec3(3.0, 4.0, 2.0))), 0.5),
                light(Source::Sun(dvec3(-3.0, -0.25, 1.0)), 0.5),
            ],
            ..Scene::default()
        };
        let view = View::new(&camera(at(dvec3(0.0, 1.5, 6.0)), at(dvec3(0.0, 0.5, 0.0))));
        assert_right("ground", &LightCase::new(scene, Pixels::whole(view, 24, 16), 2), CPU, 1);
    }
}

/// A floor under three suns that each give a third of this intensity: exactly the edge, which no finite
/// enclosure tells.
#[test]
fn equal_goes_up_or_to_even() {
    let across = View {
        position: dvec3(1.0, 3.0, 0.0),
        forward: -DVec3::Y,
        right: DVec3::X,
        true_up: DVec3::Z,
        h: 1.0,
        lens: Lens::Orthographic,
    };
    let suns = [dvec3(2.0, -1.0, 2.0), dvec3(-2.0, -1.0, 2.0), dvec3(2.0, -1.0, -2.0)];
    let floor = |intensity: f64| {
        let white = |sun| Light { color: Color([1.0; 3]), ..light(Source::Sun(sun), intensity) };
        let floor = Plane { color: Color([1.0; 3]), ..plane(DVec3::ZERO, DVec3::Y) };
        let lights = suns.map(white).to_vec();
        let scene = Scene { planes: vec![floor], lights, ..Scene::default() };
        LightCase::new(scene, Pixels::whole(across, 2, 2), 1)
    };
    for byte in [1, 17, 128, 200, 255] {
        let edge = linear_from_srgb((f64::from(byte) - 0.5) / 255.0);
        for (intensity, expected) in [(edge, byte), (edge.next_down(), byte - 1)] {
            let case = floor(intensity);
            assert_right("an edge", &case, CPU, 1);
            assert_eq!(case.paint(CPU).srgb8, [[expected as u8; 3]; 4]);
        }
    }
    for bits in [1, 0.3f32.to_bits(), 0.3f32.to_bits() + 1] {
        let (low, high) = (f32::from_bits(bits), f32::from_bits(bits + 1));
        let even = if bits % 2 == 0 { low } else { high };
        let edge = (f64::from(low) + f64::from(high)) / 2.0;
        for (intensity, expected) in [(edge, even), (edge.next_up(), high), (edge.next_down(), low)]
        {
            let case = floor(intensity);
            assert_right("an edge of floats", &case, CPU, 1);
            assert_eq!(case.paint(CPU).linear, [[expected; 3]; 4]);
        }
    }
}

/// Unit spheres in a cubic lattice, each touching six others, on a floor: enough for a tree. Suns along
/// the lattice, whose rays touch whole rows of spheres, and light at a contact, a centre and a gap.
#[test]
fn a_packing_of_touching_spheres() {
    let lattice =
        |n: i32| (0..n * n * n).map(move |k| [k % n, k / n % n, k / n / n].map(f64::from));
    for (by, scale) in [(0.0, 1.0), (1e8, 1.0), (0.0, 1e-6)] {
        let at = |v: DVec3| (v + DVec3::splat(by)) * scale;
        let spheres = lattice(9).map(|place| sphere(at(DVec3::from(place) * 2.0), scale));
        for source in [
            Source::Sun(-DVec3::Y),
            Source::Sun(dvec3(-1.0, -1.0, 0.0)),
            Source::Sun(dvec3(-1.0, -0.75, -2.0)),
            Source::Point(at(dvec3(7.0, 16.0, 16.0))),
            Source::Point(at(dvec3(9.0, 15.0, 15.0))),
            Source::Point(at(dvec3(16.0, 24.0, 20.0))),
        ] {
            let scene = Scene {
                spheres: spheres.clone().collect(),
                planes: vec![plane(at(DVec3::NEG_Y), DVec3::Y)],
                lights: vec![light(source, 0.75)],
                ambient: Some(Color([0.125; 3])),
                ..Scene::default()
            };
            let view = View::new(&camera(at(dvec3(20.0, 19.0, 26.0)), at(dvec3(9.0, 11.0, 12.0))));
            let case = LightCase::new(scene, Pixels::whole(view, 32, 24), 1);
            assert_right("packing", &case, CPU, 7);
        }
    }
}

/// Thousands of spheres over three decades that cut each other, under a sky and a point light.
#[test]
fn a_cloud_of_spheres() {
    let seed = cases::seed();
    println!("seed {seed}: KUGELBLITZ_SEED={seed} repeats this run");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    for (by, scale, n_samples) in [(0.0, 1.0, 2), (1e6, 1.0, 1), (0.0, 1e-6, 1)] {
        let at = |v: DVec3| (v + DVec3::splat(by)) * scale;
        let spheres = (0..2500).map(|_| {
            let radius = log_uniform(&mut rng, 1e-3, 0.3).abs();
            sphere(at(in_cube(&mut rng) * 2.0), radius * scale)
        });
        let spheres = spheres.collect();
        let scene = Scene {
            spheres,
            planes: vec![plane(at(DVec3::Y * -2.0), DVec3::Y)],
            lights: vec![light(Source::Point(at(in_cube(&mut rng) + DVec3::Y * 4.0)), 0.75)],
            sky: Some(Sky { intensity: 0.25, directions: 5 }),
            ..Scene::default()
        };
        let view = View::new(&camera(at(dvec3(1.0, 2.0, 6.0)), at(DVec3::ZERO)));
        let case = LightCase::new(scene, Pixels::whole(view, 48, 32), n_samples);
        assert_right("cloud", &case, CPU, 13);
    }
}

// ---------------------------------------------------------------------------------------------
// What must not change a picture

/// Spheres and planes with short numbers, under all kinds of light.
fn world(rng: &mut ChaCha8Rng, n_samples: u32) -> LightCase {
    let short = |v: DVec3| (v * 1024.0).round() / 1024.0;
    let spheres = (0..8).map(|_| {
        let radius = short(DVec3::splat(log_uniform(rng, 0.1, 2.0).abs())).x;
        sphere(short(in_cube(rng) * 4.0), radius.max(0.125))
    });
    let spheres = spheres.collect();
    let mut scene = Scene {
        spheres,
        planes: vec![plane(short(dvec3(0.0, -3.0, 0.0)), dvec3(0.125, 1.0, -0.25))],
        ambient: Some(Color([0.0625; 3])),
        sky: Some(Sky { intensity: 0.25, directions: 4 }),
        ..Scene::default()
    };
    scene.lights = vec![
        light(Source::Point(short(in_cube(rng) * 6.0)), 0.5),
        light(Source::Sun(short(in_cube(rng)) - DVec3::Y * 2.0), 0.25),
        light(Source::Eye, 0.125),
    ];
    let mut view = View::new(&camera(short(in_cube(rng) * 2.0 + DVec3::Z * 9.0), DVec3::ZERO));
    view.h = rng.random_range(0.2..0.7);
    if n_samples == 1 && rng.random() {
        (view.lens, view.h) = (Lens::Orthographic, 4.5);
    }
    LightCase::new(scene, Pixels::whole(view, 40, 25), n_samples)
}

fn worlds() -> Vec<LightCase> {
    let seed = cases::seed();
    println!("seed {seed}: KUGELBLITZ_SEED={seed} repeats this run");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    [1, 2, 1, 3, 1].into_iter().map(|n_samples| world(&mut rng, n_samples)).collect()
}

/// All points, vectors and lengths put through these maps.
fn mapped(
    case: &LightCase,
    point: impl Fn(DVec3) -> DVec3,
    vector: impl Fn(DVec3) -> DVec3,
    length: impl Fn(f64) -> f64,
) -> LightCase {
    let (mut scene, mut pixels) = ((*case.scene).clone(), case.pixels);
    for sphere in scene.spheres.iter_mut() {
        (sphere.center, sphere.radius) = (point(sphere.center), length(sphere.radius));
    }
    for plane in &mut scene.planes {
        (plane.point, plane.normal) = (point(plane.point), vector(plane.normal));
    }
    for light in &mut scene.lights {
        light.source = match light.source {
            Source::Point(at) => Source::Point(point(at)),
            Source::Sun(direction) => Source::Sun(vector(direction)),
            Source::Eye => Source::Eye,
        };
    }
    let view = &mut pixels.view;
    view.position = point(view.position);
    [view.forward, view.right, view.true_up] = [view.forward, view.right, view.true_up].map(vector);
    if view.lens == Lens::Orthographic {
        view.h = length(view.h);
    }
    LightCase::new(scene, pixels, case.n_samples)
}

/// The colours and ids, without how they were found.
fn content(painted: Painted) -> Painted {
    Painted { shadow_rays: Default::default(), colors: Default::default(), ..painted }
}

#[track_caller]
fn assert_same(one: &LightCase, other: &LightCase) {
    assert_eq!(content(one.paint(CPU)), content(other.paint(CPU)), "{}", one.paste(0));
}

#[test]
fn moved_scaled_and_mirrored_worlds_look_the_same() {
    for case in worlds() {
        // A sky does not turn.
        let mut scene = (*case.scene).clone();
        scene.sky = None;
        let case = LightCase::new(scene, case.pixels, case.n_samples);
        let by = dvec3(1e8, -3e7, 5e6);
        assert_same(&case, &mapped(&case, |p| p + by, |v| v, |x| x));
        for exponent in [-30, 20, -300] {
            let factor = 2f64.powi(exponent);
            assert_same(&case, &mapped(&case, |p| p * factor, |v| v, |x| x * factor));
        }
        let mirror = |v: DVec3| dvec3(-v.x, v.y, v.z);
        assert_same(&case, &mapped(&case, mirror, mirror, |x| x));
        let turn = |v: DVec3| dvec3(v.y, v.z, v.x);
        assert_same(&case, &mapped(&case, turn, turn, |x| x));
    }
}

#[test]
fn two_half_lights_are_one_in_any_order() {
    for case in worlds() {
        let mut scene = (*case.scene).clone();
        let halves = scene.lights.iter().flat_map(|&light| {
            let half = Light { intensity: light.intensity / 2.0, ..light };
            [half, half]
        });
        scene.lights = halves.rev().collect();
        assert_same(&case, &LightCase::new(scene, case.pixels, case.n_samples));
        // A color twice as bright at half the intensity, and a sun of another length.
        let mut scene = (*case.scene).clone();
        for light in &mut scene.lights {
            light.color = Color(light.color.0.map(|x| x * 0.5));
            light.intensity *= 2.0;
            if let Source::Sun(direction) = light.source {
                light.source = Source::Sun(direction * 0.125);
            }
        }
        assert_same(&case, &LightCase::new(scene, case.pixels, case.n_samples));
    }
}

#[test]
fn a_light_in_the_eye_is_a_light_there() {
    for case in worlds() {
        let mut scene = (*case.scene).clone();
        let View { position, forward, lens, .. } = case.pixels.view;
        scene.lights.iter_mut().filter(|light| light.source == Source::Eye).for_each(|light| {
            light.source = match lens {
                Lens::Perspective => Source::Point(position),
                Lens::Orthographic => Source::Sun(forward),
            };
        });
        assert_same(&case, &LightCase::new(scene, case.pixels, case.n_samples));
        // It casts no shadow that the eye sees; a sun has objects behind the camera in its way.
        if lens == Lens::Orthographic {
            continue;
        }
        let mut scene = (*case.scene).clone();
        scene.lights.iter_mut().filter(|light| light.source == Source::Eye).for_each(|light| {
            light.shadows = false;
        });
        assert_same(&case, &LightCase::new(scene, case.pixels, case.n_samples));
    }
}

#[test]
fn a_sky_is_suns() {
    for case in worlds() {
        let mut scene = (*case.scene).clone();
        let sky = scene.sky.take().unwrap();
        // 4 directions: each sun has the sky's intensity times 4/4.
        scene.lights.extend(
            sky.suns().into_iter().map(|sun| Light {
                color: Color([1.0; 3]),
                ..light(Source::Sun(sun), sky.intensity)
            }),
        );
        assert_same(&case, &LightCase::new(scene, case.pixels, case.n_samples));
    }
}

#[test]
fn samples_of_a_uniform_pixel_are_one() {
    // A floor that fills an orthographic picture, under suns: one colour everywhere.
    let scene = Scene {
        planes: vec![plane(DVec3::ZERO, dvec3(0.25, 1.0, 0.5))],
        lights: vec![light(Source::Sun(dvec3(1.0, -2.0, 0.5)), 0.7)],
        sky: Some(Sky { intensity: 0.5, directions: 9 }),
        ..Scene::default()
    };
    let view =
        View { lens: Lens::Orthographic, ..View::new(&camera(dvec3(1.0, 9.0, 2.0), DVec3::ZERO)) };
    let pixels = Pixels::whole(view, 5, 4);
    let one = content(LightCase::new(scene.clone(), pixels, 1).paint(CPU));
    assert!(one.linear.iter().all(|linear| *linear == one.linear[0]));
    for n_samples in [2, 3, 5] {
        let many = content(LightCase::new(scene.clone(), pixels, n_samples).paint(CPU));
        assert_eq!(one, many, "{n_samples}");
    }
}

/// Samples of pixels without light, most of which show one object alone, before every background.
#[test]
fn samples_without_light() {
    let mut rng = ChaCha8Rng::seed_from_u64(14);
    for n_samples in 1..=4 {
        for background in [Background::Shown, Background::LeftOut, Background::Black] {
            let case = world(&mut rng, n_samples);
            let mut scene = (*case.scene).clone();
            (scene.lights, scene.sky, scene.ambient) = (Vec::new(), None, None);
            scene.background = Color([0.1, 0.7, 0.3]);
            // Else there is no background.
            scene.planes.truncate((n_samples % 2) as usize);
            let mut case =
                LightCase { background, ..LightCase::new(scene, case.pixels, n_samples) };
            if n_samples > 2 {
                (case.pixels.view.lens, case.pixels.view.h) = (Lens::Orthographic, 4.5);
            }
            for device in [CPU, &Device::Gpu(gpu())] {
                assert_right("without light", &case, device, 1);
            }
        }
    }
}

#[test]
fn a_sun_is_a_point_very_far_away() {
    for case in worlds() {
        let mut scene = (*case.scene).clone();
        for light in &mut scene.lights {
            if let Source::Sun(direction) = light.source {
                light.source = Source::Point(direction * -(2f64.powi(60)));
            }
        }
        let far = LightCase::new(scene, case.pixels, case.n_samples).paint(CPU);
        let near = case.paint(CPU);
        assert_eq!(far.ids, near.ids);
        // The byte of a number within 2⁻⁵⁰ of an edge may change, and so may a shadow's edge.
        let differing = far.srgb8.iter().zip(&near.srgb8).filter(|(a, b)| a != b).count();
        assert!(differing <= 1, "{differing} pixels: {}", case.paste(0));
    }
}

// ---------------------------------------------------------------------------------------------
// Files and sessions

#[test]
fn sessions_and_files_have_the_same_numbers() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for n_samples in [1, 2] {
        let case = world(&mut rng, n_samples);
        let mut scene = (*case.scene).clone();
        scene.camera = Some(camera(dvec3(0.5, 1.0, 9.0), DVec3::ZERO));
        scene.samples = Some(Samples::nearest(n_samples));
        let view = View::new(scene.camera.as_ref().unwrap());
        let case = LightCase::new(scene.clone(), Pixels::whole(view, 40, 25), n_samples);
        assert_right("session", &case, CPU, 3);
        let expected = case.paint(CPU);
        for device in [Device::Cpu, Device::Gpu(gpu())] {
            let mut session = Session::new(scene.clone(), device, Kernel::Certified);
            let picture = session.render(40, 25).unwrap();
            assert_eq!((&picture.srgb8, &picture.hits.id), (&expected.srgb8, &expected.ids));
            let mut write = |name: &str, bits: Bits| {
                let path = folder.path().join(name);
                let format = Format::from_path(&path).unwrap();
                let options = PictureOptions { bits, ..PictureOptions::default() };
                let n_objects = scene.n_objects();
                let pixels = session.pixels(40, 25).unwrap();
                let plan = plan(
                    format,
                    options,
                    Samples::nearest(n_samples),
                    &pixels,
                    n_objects,
                    Available::now(),
                )
                .unwrap();
                let file = OutputFile::create(&path, format.needs_seek()).unwrap();
                let control = Control::default();
                let (_, file) = session.draw(&pixels, &plan, file, &control).unwrap();
                commit([file], &control).unwrap();
                path
            };
            let wide = image::open(write("wide.png", Bits::Sixteen)).unwrap().to_rgb16();
            let wide: Vec<[u16; 3]> = wide.pixels().map(|pixel| pixel.0).collect();
            assert_eq!(wide, expected.srgb16);
            for name in ["picture.png", "picture.ppm"] {
                let bytes = image::open(write(name, Bits::Eight)).unwrap().to_rgb8();
                let bytes: Vec<[u8; 3]> = bytes.pixels().map(|pixel| pixel.0).collect();
                assert_eq!(bytes, expected.srgb8, "{name}");
            }
            let npy = std::fs::read(write("picture.npy", Bits::Eight)).unwrap();
            // The records end in three floats.
            let records = npy[npy.len() - 40 * 25 * 32..].chunks(32);
            let linear: Vec<[f32; 3]> = records
                .map(|record| {
                    let float = |k: usize| f32::from_le_bytes(record[k..k + 4].try_into().unwrap());
                    [float(20), float(24), float(28)]
                })
                .collect();
            assert_eq!(linear, expected.linear);
            let exr = exr_channels(&write("picture.exr", Bits::Eight));
            let color = |at: usize| ["R", "G", "B"].map(|channel| exr[channel][at]);
            let linear: Vec<[f32; 3]> = (0..40 * 25).map(color).collect();
            assert_eq!(linear, expected.linear);
            assert!(exr["A"].iter().all(|&alpha| alpha == 1.0));
        }
    }
}

/// The channels of floats of an EXR file.
fn exr_channels(path: &Path) -> HashMap<String, Vec<f32>> {
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_file(path)
        .unwrap();
    let channels = image.layer_data.channel_data.list.into_iter();
    let floats = channels.filter_map(|channel| match channel.sample_data {
        exr::prelude::FlatSamples::F32(floats) => Some((channel.name.to_string(), floats)),
        _ => None,
    });
    floats.collect()
}

// ---------------------------------------------------------------------------------------------
// The comparison can fail

#[test]
fn the_judge_sees_every_wrong_number() {
    let mut case = world(&mut ChaCha8Rng::seed_from_u64(5), 2);
    case.background = Background::Black;
    let right = case.paint(CPU);
    judge(&case, &right, 1).unwrap();
    let i = 517;
    let refuse = |what: &str, change: &dyn Fn(&mut Painted)| {
        let mut wrong = right.clone();
        change(&mut wrong);
        let said = judge(&case, &wrong, 1).expect_err(what);
        assert!(said.starts_with(what) && said.contains("[[light]]"), "{what}: {said}");
        assert!(said.contains("pixel (37, 12)"), "{what}: {said}");
    };
    refuse("id", &|painted| painted.ids[i] += 1);
    refuse("8 bits", &|painted| painted.srgb8[i][2] ^= 1);
    refuse("16 bits", &|painted| painted.srgb16[i][1] ^= 1);
    refuse("floats", &|painted| painted.linear[i][0] = painted.linear[i][0].next_up());
    refuse("hits", &|painted| painted.n_hits.as_mut().unwrap()[i] ^= 1);
    let mut short = right.clone();
    short.srgb16.pop();
    judge(&case, &short, 1).expect_err("a pixel is missing");
}

#[test]
fn the_judge_sees_other_light() {
    let case = world(&mut ChaCha8Rng::seed_from_u64(6), 1);
    type Change = fn(&mut Scene);
    let changes: [(&str, Change); 7] = [
        ("no shadows", |scene| scene.lights[0].shadows = false),
        ("moved", |scene| scene.lights[0].source = Source::Point(DVec3::splat(7.0))),
        ("another sun", |scene| scene.lights[1].source = Source::Sun(dvec3(0.5, -2.0, 0.25))),
        ("brighter", |scene| scene.lights[2].intensity *= 1.0 + 1e-6),
        ("no ambient light", |scene| scene.ambient = None),
        ("another sky", |scene| scene.sky.as_mut().unwrap().directions = 5),
        ("the eye elsewhere", |scene| scene.lights.truncate(2)),
    ];
    for (what, change) in changes {
        let mut scene = (*case.scene).clone();
        change(&mut scene);
        let other = LightCase::new(scene, case.pixels, 1);
        judge(&other, &case.paint(CPU), 1).expect_err(what);
    }
    // Samples in another order, and another number of them.
    judge(&LightCase { n_samples: 2, ..case.clone() }, &case.paint(CPU), 1).expect_err("samples");
    // Metamorphic comparisons see a light that is moved by a little.
    let mut scene = (*case.scene).clone();
    scene.lights[1].source = Source::Sun(dvec3(0.5, -2.0, 0.25));
    let other = LightCase::new(scene, case.pixels, 1);
    assert_ne!(content(case.paint(CPU)), content(other.paint(CPU)));
}

/// The cases are hard enough for what everyone does: f64 without a proof, with and without an epsilon.
#[test]
fn the_judge_sees_what_other_kernels_do() {
    for (kernel, epsilon) in [(Kernel::Double, 0.0), (Kernel::Double, 1e-9), (Kernel::Stable, 1e-4)]
    {
        let n_cases = 130;
        let wrong = (0..n_cases).filter(|&index| {
            let (_, case) = light_case(9, index);
            let said = judge(&case, &case.paint_by(kernel, epsilon, CPU), 1);
            // A wrong id would be no merit of this judge.
            said.is_err_and(|what| !what.starts_with("id"))
        });
        let n_wrong = wrong.count();
        println!("{kernel:?}, epsilon {epsilon}: {n_wrong} of {n_cases} pictures wrong");
        assert!(n_wrong > n_cases as usize / 4, "{kernel:?} {epsilon}: {n_wrong}");
    }
}

#[test]
fn pasted_scenes_are_the_scenes() {
    for index in 0..52 {
        let (family, case) = light_case(3, index);
        let read = parse_scene(&scene_text(&case.scene), Path::new("case.toml"));
        match read {
            Ok(scene) => assert_eq!(Arc::new(scene), case.scene, "{family}"),
            // A number that files may not have; it can still be read by people.
            Err(error) => println!("{family} {index}: {error}"),
        }
    }
}
