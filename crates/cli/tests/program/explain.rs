//! `explain`: what holds for the numbers of any ray. Whole explanations stand in `tests/answers/explain.txt`.

use std::sync::Arc;

use glam::DVec3;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::query::{Kernel, Rays, WorldRay};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Color, Light, Projection, Samples, Scene, Sky, Source, read_scene};
use kugelblitz_judge::explain::text::{WIDTH, text};
use kugelblitz_judge::explain::{
    Approximation, DEFAULT_DIGITS, ExplainStyle, Explanation, FormulaNumber, Lang,
    LightExplanation, LightVerdict, ObjectExplanation, Reason, explain,
};
use kugelblitz_tests::{gpu, in_cube, log_uniform, plane, runs, scene, sphere};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::calculator;
use crate::program::{self, scene_file as file};

/// Of all objects.
const ALL: ExplainStyle = ExplainStyle { limit: None, lang: Lang::English, digits: DEFAULT_DIGITS };

/// A column of the table.
type Column = fn(&FormulaNumber) -> Option<Approximation>;

fn ray(origin: [f64; 3], direction: [f64; 3]) -> Rays {
    Rays::List(vec![WorldRay { origin: origin.into(), direction: direction.into() }])
}

fn of_ray(scene: Scene, origin: [f64; 3], direction: [f64; 3]) -> Explanation {
    let explanation = explain(&Arc::new(scene), &ray(origin, direction), &ALL).unwrap();
    assert_written(&explanation);
    explanation
}

fn of_pixel(name: &str, x: u32, y: u32) -> Explanation {
    let scene = Arc::new(read_scene(file(name).as_ref()).unwrap());
    let (camera, [width, height]) = (scene.camera.as_ref().unwrap(), scene.image.unwrap());
    let whole = Pixels::whole(View::new(camera), width, height);
    let rays = Rays::Pixels(Pixels { x, y, width: 1, height: 1, ..whole });
    let explanation = explain(&scene, &rays, &ALL).unwrap();
    assert_written(&explanation);
    explanation
}

/// Asserts what holds for the text of every explanation.
#[track_caller]
fn assert_written(explanation: &Explanation) {
    let text = text(explanation);
    for line in text.lines() {
        assert!(line.chars().count() <= WIDTH, "{line}");
        assert_eq!(line, line.trim_end(), "blanks at the end");
    }
    assert!(!text.chars().any(|c| c.is_control() && c != '\n'));
    let (n_checked, wrong) = calculator::checked(&text, explanation.digits);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let n_hits =
        explanation.objects.iter().filter(|object| object.reason == Reason::Visible).count();
    assert!(n_checked >= 10 * n_hits, "{n_checked} expressions\n{text}");
}

fn object(explanation: &Explanation, id: u32) -> &ObjectExplanation {
    explanation.objects.iter().find(|object| object.id == id).unwrap()
}

fn row<'a>(object: &'a ObjectExplanation, symbol: &str) -> &'a FormulaNumber {
    object.derivation.quantities.iter().find(|row| row.symbol == symbol).unwrap()
}

fn exact<'a>(object: &'a ObjectExplanation, symbol: &str) -> Option<&'a str> {
    row(object, symbol).exact.as_ref().map(|exact| exact.decimal.as_str())
}

/// The calculator of these tests sees a digit that is wrong, and a formula that is.
#[test]
fn a_wrong_digit_is_noticed() {
    let shown = text(&of_pixel("figure2", 700, 300));
    let (n_checked, wrong) = calculator::checked(&shown, 6);
    assert!(n_checked > 30 && wrong.is_empty(), "{n_checked}: {wrong:?}");
    let lines: Vec<&str> = shown.lines().collect();
    let mut n_spoiled = 0;
    for (i, line) in lines.iter().enumerate() {
        let starts = [
            "  u = ",
            "  v = ",
            "  o − c",
            "  a = d·d",
            "  b = 2",
            "  k = ",
            "  D = ",
            "  p = ",
            "  n = ",
        ];
        let next = lines.get(i + 1).map_or("", |next| next.trim_start());
        let is_broken = next.starts_with(['=', '≈']);
        if is_broken || !starts.iter().any(|start| line.starts_with(start)) {
            continue;
        }
        // One more in the last digit of the last number, or one digit in a place before.
        let last = line.rfind(|c: char| c.is_ascii_digit()).unwrap();
        let digit = line[last..=last].parse::<u8>().unwrap();
        let other = (digit + if digit == 5 { 4 } else { 5 }) % 10;
        let spoiled = format!("{}{other}{}", &line[..last], &line[last + 1..]);
        let mut all = lines.clone();
        all[i] = &spoiled;
        let (_, wrong) = calculator::checked(&all.join("\n"), 6);
        assert!(!wrong.is_empty(), "{line} became {spoiled}");
        n_spoiled += 1;
    }
    assert!(n_spoiled > 10, "{n_spoiled}");
    for (line, n_wrong) in [
        ("  D = b² − 4·a·k = (-48)² − 4·1·576 = 2304 − 2304 = 1", 2),
        ("  t = (−b ± √D) / (2·a) = (80 ± √64) / (2·1), t₁ = 36, t₂ = 45", 1),
        ("  t = (−b ± √D) / (2·a) ≈ (80 ± √64.0001) / (2·1), t₁ ≈ 36, t₂ ≈ 44", 0),
        ("  p = o + t·d ≈ (0, 1, 0) + 0.5·(1, -2, 1e-3) ≈ (0.5, 0, 6e-4)", 1),
        ("  n·ω = n·w / |w| = (1·3 + 0·0 + 0·4) / √(3² + 0² + 4²) = 0.6", 0),
        ("  n·ω = n·w / |w| = (1·3 + 0·0 + 0·4) / √(3² + 0² + 4²) = 0.8", 1),
    ] {
        assert_eq!(calculator::checked(line, 6).1.len(), n_wrong, "{line}");
    }
}

/// D is the difference of two numbers that agree in their first 15 digits: the calculator sees that the numbers on the way to it
/// have as many as that takes.
#[test]
fn a_discriminant_near_zero_can_be_calculated() {
    let mut signs = [0; 2];
    for (step, by) in (1..20).flat_map(|step| [(step, 1e-13), (step, -1e-13)]) {
        let x = 3.0 + f64::from(step) * by;
        let grazing = scene(vec![sphere(DVec3::new(x, 0.0, -10.0), 3.0)], vec![]);
        let explanation = of_ray(grazing, [0.0; 3], [0.0, 0.0, -1.1]);
        let d = exact(object(&explanation, 1), "D").unwrap();
        assert!(d.contains("e-1") && text(&explanation).contains(&format!("≈ {}", &d[..5])), "{d}");
        signs[usize::from(d.starts_with('-'))] += 1;
    }
    assert_eq!(signs, [19, 19]);
}

#[test]
fn results_have_the_digits_that_are_asked_for() {
    let scene = Arc::new(read_scene(file("figure2").as_ref()).unwrap());
    let rays = ray([0.0; 3], [0.1, 0.03, -1.0]);
    for digits in [1, 2, 3, 12, 40] {
        let explanation =
            explain(&scene, &rays, &ExplainStyle { digits, ..ExplainStyle::default() }).unwrap();
        assert_written(&explanation);
        let shown = text(&explanation);
        let t = shown.split("t₁ ≈ ").nth(1).unwrap().split([',', '\n']).next().unwrap();
        let n_digits = t.chars().filter(char::is_ascii_digit).count();
        assert!(n_digits <= digits && n_digits + 2 >= digits, "{t}: {digits}");
        assert!(shown.contains(&format!("rounded to {digits} digits")), "{shown}");
    }
    for digits in [0, 41] {
        let error = explain(&scene, &rays, &ExplainStyle { digits, ..ExplainStyle::default() })
            .unwrap_err();
        assert_eq!(error.exit_code(), 2);
    }
}

/// The numbers shown are those that the kernels work with: of all the roots shown, the smallest
/// positive one of the smallest id is what the kernel itself reports, bit by bit.
#[test]
fn the_numbers_shown_are_the_kernels_own() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (mut n_hits, mut n_inexact) = (0, 0);
    for round in 0..300 {
        let spheres = (0..4)
            .map(|_| {
                let distance = log_uniform(&mut rng, 1.0, 1e4).abs();
                sphere(in_cube(&mut rng) * distance, distance * rng.random_range(0.01..0.9))
            })
            .collect();
        let length = log_uniform(&mut rng, 1e-3, 1e3);
        let planes = vec![plane(in_cube(&mut rng) * 100.0, in_cube(&mut rng) * length)];
        let scene = Arc::new(scene(spheres, planes));
        let rays = if round % 2 == 0 {
            let mut camera = kugelblitz_tests::camera(in_cube(&mut rng), in_cube(&mut rng) * 3.0);
            if round % 4 == 0 {
                camera.projection = Projection::Orthographic { height: 3.0 };
            }
            let whole = Pixels::whole(View::new(&camera), 301, 203);
            let (x, y) = (rng.random_range(0..301), rng.random_range(0..203));
            Rays::Pixels(Pixels { x, y, width: 1, height: 1, ..whole })
        } else {
            let direction = in_cube(&mut rng) * log_uniform(&mut rng, 1e-6, 1e6);
            Rays::List(vec![WorldRay { origin: in_cube(&mut rng) * 10.0, direction }])
        };
        let explanation = explain(&scene, &rays, &ALL).unwrap();
        assert_written(&explanation);
        let ray = match &rays {
            Rays::Pixels(pixels) => pixels.ray(pixels.x, pixels.y),
            Rays::List(rays) => rays[0],
        };
        let components = [ray.origin.to_array(), ray.direction.to_array()].concat();
        for (row, component) in explanation.ray.quantities.iter().zip(components) {
            let exact: f64 = row.exact.as_ref().unwrap().decimal.parse().unwrap();
            let largest = ray.origin.length() + ray.direction.length();
            assert!((component - exact).abs() < 1e-14 * largest, "round {round}: {row:?}");
        }
        let columns: [(&str, Column); 2] =
            [("lecture", |row| row.lecture), ("stable", |row| row.stable)];
        for (kernel, column) in columns {
            let mut expected = (0, f64::INFINITY);
            let mut objects: Vec<_> = explanation.objects.iter().collect();
            objects.sort_by_key(|object| object.id);
            for object in objects {
                let roots = object.derivation.quantities.iter();
                let roots = roots.filter(|row| row.symbol.starts_with('t'));
                let mut values = roots.filter_map(column).filter_map(|entry| entry.value);
                if let Some(t) = values.find(|&t| t > 0.0)
                    && t < expected.1
                {
                    expected = (object.id, t);
                }
            }
            let seen = explanation.seen.iter().find(|seen| seen.kernel == kernel).unwrap();
            assert_eq!((seen.id, f64::from(seen.t)), expected, "round {round}, {kernel}");
            n_hits += u32::from(seen.id > 0);
        }
        let certified = explanation.seen.iter().find(|seen| seen.kernel == "certified").unwrap();
        assert!(certified.right);
        assert_eq!(certified.t_error_ulp.is_some(), certified.id > 0, "round {round}");
        let error = certified.t_error_ulp.unwrap_or(0.0);
        assert!(error <= 0.5, "round {round}: {error} ulp");
        n_inexact += u32::from(error > 0.25);
    }
    assert!(n_hits > 200 && n_inexact > 20, "{n_hits}, {n_inexact}");
}

#[test]
fn no_line_is_wider_than_100_columns() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for exponent in [-320, -300, -160, -45, -20, 0, 20, 45, 160, 300] {
        let scale = 10f64.powi(exponent);
        for _ in 0..4 {
            let number = |rng: &mut ChaCha8Rng| log_uniform(rng, 0.1, 7.7) * scale;
            let mut vector = || DVec3::from_array(std::array::from_fn(|_| -number(&mut rng)));
            let ball = sphere(vector(), vector().x.abs());
            let other = sphere(vector(), vector().y.abs());
            let floor = plane(vector(), vector());
            let (origin, direction) = (vector(), vector());
            let mut scene = scene(vec![ball, other], vec![floor]);
            for index in 0..2 {
                let name = "a name with \u{1b}[31m colour\n and no end ".repeat(9);
                scene.spheres.set_name(index, name);
            }
            of_ray(scene.clone(), origin.to_array(), direction.to_array());
            scene.lights = vec![
                light(Source::Point(vector()), 1e-30),
                light(Source::Sun(vector()), -number(&mut rng).abs()),
                light(Source::Eye, 1.0),
            ];
            scene.sky = Some(Sky { intensity: 0.5, directions: 9 });
            of_ray(scene, origin.to_array(), direction.to_array());
        }
    }
}

fn light(source: Source, intensity: f64) -> Light {
    Light { source, color: Color([1.0; 3]), intensity, shadows: true }
}

/// A sphere on a floor, from inside a room, under a sky: all that a picture shows is explained.
fn lit_picture(samples: u32) -> Scene {
    let ball = sphere(DVec3::new(0.0, 1.0, 0.0), 1.0);
    let mut lit = scene(vec![ball, sphere(DVec3::new(1.4, 0.4, 0.3), 0.4)], vec![]);
    lit.spheres.set_name(0, "50 % of_a {ball} & #1 \\~^");
    lit.planes = vec![plane(DVec3::ZERO, DVec3::Y)];
    lit.camera =
        Some(kugelblitz_tests::camera(DVec3::new(0.0, 1.5, 5.0), DVec3::new(0.2, 0.6, 0.0)));
    lit.background = Color([0.2, 0.3, 0.4]);
    lit.lights = vec![
        Light {
            color: Color([1.0, 0.8, 0.6]),
            ..light(Source::Point(DVec3::new(4.0, 6.0, 3.0)), 0.7)
        },
        Light { shadows: false, ..light(Source::Sun(DVec3::new(1.0, -2.0, 0.5)), 0.2) },
    ];
    lit.sky = Some(Sky { intensity: 0.3, directions: 7 });
    lit.samples = Some(Samples::nearest(samples));
    lit
}

#[test]
fn the_byte_explained_is_the_byte_shown() {
    let mut n_hidden = [0; 2];
    for samples in [1, 3] {
        let scene = Arc::new(lit_picture(samples));
        let (width, height) = (40, 30);
        let mut session = Session::new(Arc::clone(&scene), Device::Cpu, Kernel::Certified);
        let picture = session.render(width, height).unwrap();
        let whole = session.pixels(width, height).unwrap();
        for index in (0..picture.srgb8.len()).step_by(17) {
            let (x, y) = whole.xy(index);
            let rays = Rays::Pixels(Pixels { x, y, width: 1, height: 1, ..whole });
            let explanation = explain(&scene, &rays, &ALL).unwrap();
            assert_written(&explanation);
            let german = ExplainStyle { lang: Lang::German, ..ExplainStyle::default() };
            assert_written(&explain(&scene, &rays, &german).unwrap());
            let shading = explanation.shading.as_ref().unwrap();
            assert_eq!(shading.mean.is_some(), samples > 1);
            let shown = shading.mean.as_ref().map_or(&shading.color, |mean| &mean.color);
            let bytes = shown.channels.each_ref().map(|channel| channel.byte);
            assert_eq!(bytes, picture.srgb8[index], "({x}, {y})");
            assert_eq!(explanation.point.is_some(), picture.hits.id[index] > 0);
            if let Some(sky) = &shading.sky {
                assert_eq!(sky.counting + sky.behind + sky.hidden, 7);
                n_hidden[0] += sky.hidden;
            }
            let is_hidden =
                |light: &&LightExplanation| matches!(light.verdict, LightVerdict::Hidden { .. });
            n_hidden[1] += shading.lights.iter().filter(is_hidden).count();
        }
    }
    assert!(n_hidden.iter().all(|n| *n > 5), "{n_hidden:?}");
}

#[test]
fn the_program_shows_what_the_gpu_computes() {
    gpu();
    let run = |args: [&str; 2]| {
        let scene = file("figure5");
        let ran = program::run(&[&["explain", &scene, "--device", "gpu"], &args[..]].concat(), 0);
        let text = ran.text().to_owned();
        assert!(!text.contains("WRONG") && !text.contains("No GPU"), "{text}");
        text
    };
    for (on, shown) in [
        ("640,360", "certified GPU sphere 2 (touched)"),
        ("639,361", "certified GPU sphere 3 (pierced)"),
        ("0,0", "certified GPU background"),
    ] {
        assert!(run(["--pixel", on]).contains(shown), "{shown}");
    }
    let text = run(["--ray", "-0,0,0,0,0,-2"]);
    for kernel in Kernel::ALL.into_iter().filter(|&kernel| runs(kernel)) {
        let start = format!("  {:<9} GPU sphere 2 (touched) ", kernel.name());
        let line = text.lines().find(|line| line.starts_with(&start));
        let end = "12       0 ulp  -0.6000 -0.8000 0.0000";
        assert!(line.is_some_and(|line| line.ends_with(end)), "{text}");
    }
}
