//! `explain`: the numbers of one ray, through the library and through the program.

mod common;
#[path = "common/program.rs"]
mod program;

use std::sync::Arc;

use common::{gpu, in_cube, log_uniform, plane, scene, sphere};
use glam::DVec3;
use kugelblitz::explain::text::{WIDTH, text};
use kugelblitz::explain::{
    Approximation, DEFAULT_OBJECTS, Explanation, ObjectExplanation, Quantity, Reason, explain,
    latex,
};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Projection, Scene, read_scene};
use kugelblitz::trace::{Ray, Rays};
use program::scene_file as file;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

/// A column of the table.
type Column = fn(&Quantity) -> Option<Approximation>;

fn ray(origin: [f64; 3], direction: [f64; 3]) -> Rays {
    Rays::List(vec![Ray { origin: origin.into(), direction: direction.into() }])
}

fn of_ray(scene: Scene, origin: [f64; 3], direction: [f64; 3]) -> Explanation {
    let explanation = explain(&Arc::new(scene), &ray(origin, direction), None).unwrap();
    assert_written(&explanation);
    explanation
}

fn of_pixel(name: &str, x: u32, y: u32) -> Explanation {
    let scene = Arc::new(read_scene(file(name).as_ref()).unwrap());
    let (camera, size) = (scene.camera.as_ref().unwrap(), scene.image.unwrap());
    let whole = Pixels::whole(View::new(camera), size.width, size.height);
    let rays = Rays::Pixels(Pixels { x, y, width: 1, height: 1, ..whole });
    let explanation = explain(&scene, &rays, None).unwrap();
    assert_written(&explanation);
    explanation
}

/// Asserts what holds for the text and the LaTeX of every explanation.
#[track_caller]
fn assert_written(explanation: &Explanation) {
    let text = text(explanation);
    for line in text.lines() {
        assert!(line.chars().count() <= WIDTH, "{line}");
        assert_eq!(line, line.trim_end(), "blanks at the end");
    }
    assert!(!text.chars().any(|c| c.is_control() && c != '\n'));
    let latex = latex::latex(explanation);
    let mut depth = 0i32;
    for c in latex.lines().filter(|line| !line.starts_with('%')).flat_map(str::chars) {
        assert!(c.is_ascii(), "{c}");
        depth += i32::from(c == '{') - i32::from(c == '}');
        assert!(depth >= 0, "{latex}");
    }
    assert_eq!(depth, 0, "{latex}");
    let count = |what: &str| latex.matches(what).count();
    assert_eq!(count(r"\begin{align*}"), explanation.objects.len() + 1);
    assert_eq!(count(r"\begin{align*}"), count(r"\end{align*}"));
    let math = latex.lines().filter(|line| !line.starts_with('%'));
    for line in math.filter(|line| !line.is_empty() && !line.ends_with("{align*}")) {
        assert_eq!(line.matches('&').count(), 1, "{line}");
        assert!(!line.contains("NaN") && !line.contains("inf"), "{line}");
    }
}

fn object(explanation: &Explanation, id: u32) -> &ObjectExplanation {
    explanation.objects.iter().find(|object| object.id == id).unwrap()
}

fn row<'a>(object: &'a ObjectExplanation, symbol: &str) -> &'a Quantity {
    object.quantities.iter().find(|row| row.symbol == symbol).unwrap()
}

fn exact<'a>(object: &'a ObjectExplanation, symbol: &str) -> Option<&'a str> {
    row(object, symbol).exact.as_ref().map(|exact| exact.decimal.as_str())
}

#[track_caller]
fn assert_why(object: &ObjectExplanation, reason: Reason, why: &[&str]) {
    assert_eq!(object.reason, reason);
    assert_eq!(object.why, why);
}

#[test]
fn figure_5_has_the_numbers_of_its_table() {
    let explanation = of_pixel("figure5", 640, 360);
    let ids: Vec<u32> = explanation.objects.iter().map(|object| object.id).collect();
    assert_eq!(ids, [2, 3, 1], "the nearest first, what is missed last");
    // b, k, D, r² − P·P, h, t₁, t₂
    let table: [(u32, [f64; 4], Option<[f64; 3]>); 3] = [
        (1, [-32.0, 283.0, -108.0, -27.0], None),
        (2, [-48.0, 576.0, 0.0, 0.0], Some([0.0, 24.0, 24.0])),
        (3, [-80.0, 1584.0, 64.0, 16.0], Some([4.0, 36.0, 44.0])),
    ];
    for (id, [b, k, d, delta], roots) in table {
        let object = object(&explanation, id);
        let numbers = [("a", 1.0), ("b", b), ("k", k), ("D", d), ("r²−P·P", delta)];
        let mut expected = numbers.map(|(symbol, x)| (symbol, Some(x))).to_vec();
        for (i, symbol) in ["h", "t₁", "t₂"].into_iter().enumerate() {
            expected.push((symbol, roots.map(|roots| roots[i])));
        }
        for (symbol, expected) in expected {
            let row = row(object, symbol);
            assert_eq!(exact(object, symbol), expected.map(|x| x.to_string()).as_deref());
            for entry in [row.lecture, row.stable, row.f64].into_iter().flatten() {
                assert_eq!(entry.value, expected, "{id}, {symbol}");
                assert_eq!(entry.error_ulp, expected.map(|_| 0.0), "{id}, {symbol}");
                assert!(!entry.wrong_sign);
            }
            let own_form = ["r²−P·P", "h"].contains(&symbol);
            assert_eq!((row.lecture.is_none(), row.f64.is_none()), (own_form, own_form));
            assert_eq!(row.stable.is_none(), symbol == "D");
        }
    }
    let winner = explanation.winner.as_ref().unwrap();
    assert_eq!((winner.id, winner.t.as_str(), winner.side), (2, "24", "front"));
    assert_eq!(winner.normal, ["-0.6", "-0.8", "0"]);
    assert_eq!(explanation.level, "exact");
    assert_why(
        object(&explanation, 2),
        Reason::Visible,
        &["nearest positive t: visible", "D = 0: the line touches the sphere"],
    );
    assert_why(
        object(&explanation, 3),
        Reason::Farther { than: 2 },
        &["farther than sphere 2 (touched)"],
    );
    assert_why(object(&explanation, 1), Reason::Missed, &["D < 0: the line misses the sphere"]);
}

#[test]
fn figure_5_reads_as_in_the_lecture() {
    let shown = text(&of_pixel("figure5", 640, 360));
    let expected = "
sphere 2 (touched)
  → nearest positive t: visible
  → D = 0: the line touches the sphere
  c = (3, 4, -24), r = 5
  o − c = (-3, -4, 24)
  a = d·d = 0 + 0 + 1 = 1
  b = 2·d·(o − c) = 2·(0 + 0 − 24) = -48
  k = (o − c)·(o − c) − r² = 601 − 25 = 576
  D = b² − 4·a·k = (-48)² − 4·1·576 = 0
  t = (−b ± √D) / (2·a) = (48 ± √0) / (2·1) = 24
               f32 lecture       f32 stable                       f64                        exact
  a                      1                1                         1                            1
  b                    -48              -48                       -48                          -48
";
    assert!(shown.contains(expected), "{shown}");
    let lines = latex::latex(&of_pixel("figure5", 640, 360));
    for line in [
        r"% sphere 2 (touched): nearest positive t: visible; D = 0: the line touches the sphere",
        r"b &= 2\,\vec{d} \cdot (\vec{o} - \vec{c}) = 2\,(0 + 0 - 24) = -48 \\",
        r"D &= b^2 - 4ak = (-48)^2 - 4 \cdot 1 \cdot 576 = 0 \\",
        r"t &= \frac{-b \pm \sqrt{D}}{2a} = \frac{48 \pm \sqrt{0}}{2 \cdot 1} = 24",
        r"D &= b^2 - 4ak = (-32)^2 - 4 \cdot 1 \cdot 283 = -108 < 0",
    ] {
        assert!(lines.lines().any(|other| other == line), "{line}\n{lines}");
    }
}

#[test]
fn spheres_behind_around_and_at_the_origin() {
    let at = |z, radius| scene(vec![sphere(DVec3::new(0.0, 0.0, z), radius)], vec![]);
    let down = [0.0, 0.0, -1.0];

    let behind = of_ray(at(5.0, 1.0), [0.0; 3], down);
    assert_why(object(&behind, 1), Reason::Behind, &["behind the camera: both t ≤ 0"]);
    assert_eq!(object(&behind, 1).gap, Some(4.0));
    assert!(behind.winner.is_none());
    assert!(text(&behind).contains("The ray sees the background."));

    let inside = of_ray(at(-1.0, 3.0), [0.0; 3], down);
    assert_why(
        object(&inside, 1),
        Reason::Visible,
        &["nearest positive t: visible", "inside: near root behind, far root counts"],
    );
    assert_eq!(inside.winner.as_ref().map(|winner| winner.side), Some("back"));
    assert_eq!(exact(object(&inside, 1), "t₁"), Some("-2"));
    assert_eq!(inside.winner.as_ref().map(|winner| winner.t.as_str()), Some("4"));

    let on_the_front = of_ray(at(-2.0, 2.0), [0.0; 3], down);
    assert_why(
        object(&on_the_front, 1),
        Reason::Visible,
        &[
            "nearest positive t: visible",
            "the origin lies on the sphere: near root 0, far root counts",
        ],
    );
    let on_the_back = of_ray(at(2.0, 2.0), [0.0; 3], down);
    assert_why(
        object(&on_the_back, 1),
        Reason::Behind,
        &["the origin lies on the sphere: no t > 0 (t = 0 does not count)"],
    );
}

#[test]
fn a_ray_without_a_direction_meets_nothing() {
    let around = scene(vec![sphere(DVec3::ZERO, 2.0)], vec![]);
    let nowhere = of_ray(around, [0.0; 3], [0.0; 3]);
    assert_eq!(object(&nowhere, 1).reason, Reason::Degenerate);
    let why = &object(&nowhere, 1).why[0];
    assert_eq!(why, "a number here can't be calculated with: no hit");
    assert!(nowhere.winner.is_none());
}

#[test]
fn planes_behind_parallel_and_too_far() {
    let at = |y, normal| scene(vec![], vec![plane(DVec3::new(0.0, y, 0.0), normal)]);
    let down = [0.0, -2.0, 0.0];

    let seen = of_ray(at(-3.0, DVec3::Y * 4.0), [0.0; 3], down);
    assert_eq!(exact(object(&seen, 1), "(a−o)·n"), Some("-12"));
    assert_eq!(exact(object(&seen, 1), "d·n"), Some("-8"));
    assert_eq!(exact(object(&seen, 1), "t"), Some("1.5"));
    for symbol in ["(a−o)·n", "d·n", "t"] {
        let row = row(object(&seen, 1), symbol);
        for entry in [row.lecture, row.stable, row.f64] {
            assert_eq!(entry.and_then(|entry| entry.error_ulp), Some(0.0), "{symbol}");
        }
    }
    let behind = of_ray(at(3.0, DVec3::Y), [0.0; 3], down);
    assert_why(object(&behind, 1), Reason::Behind, &["behind the camera: t < 0"]);
    let origin_in_it = of_ray(at(0.0, DVec3::Y), [0.0; 3], down);
    assert_why(
        object(&origin_in_it, 1),
        Reason::Behind,
        &["t = 0: the origin lies in the plane, which does not count"],
    );
    let parallel = of_ray(at(3.0, DVec3::X), [1.0, 0.0, 0.0], down);
    assert_why(object(&parallel, 1), Reason::Parallel, &["parallel: d·n = 0"]);
    let in_the_plane = of_ray(at(3.0, DVec3::X), [0.0; 3], down);
    assert_why(
        object(&in_the_plane, 1),
        Reason::Parallel,
        &["parallel: d·n = 0 (the ray runs in the plane, which is no hit)"],
    );
    let too_far = of_ray(at(-1e39, DVec3::Y), [0.0; 3], [0.0, -1.0, 0.0]);
    assert_eq!(object(&too_far, 1).reason, Reason::TooFar);
    assert_eq!(object(&too_far, 1).why[0], "t is larger than any f32: counts as background");
    assert!(too_far.winner.is_none());
}

#[test]
fn a_tie_is_told_on_both_sides() {
    let front = sphere(DVec3::new(0.0, 0.0, -5.0), 1.0);
    let larger = sphere(DVec3::new(0.0, 0.0, -7.0), 3.0);
    let tie = of_ray(scene(vec![front, larger], vec![]), [0.0; 3], [0.0, 0.0, -1.0]);
    assert_why(
        object(&tie, 1),
        Reason::Visible,
        &["nearest positive t: visible", "tie with sphere 2: the lower id wins"],
    );
    let lost = &["tie with sphere 1: the lower id wins"];
    assert_why(object(&tie, 2), Reason::TieLost { to: 1 }, lost);
    assert_eq!(tie.level, "exact");
}

/// At 10⁸ neighbouring f32 are 8 apart, so 10⁸ + 3 becomes 10⁸: `o − c` is (0, 0, 10) in place of
/// (−3, 0, 10), and a miss becomes a hit. For d = (0, 0, −1):
///
///   f32     k = 100 − 1 = 99    D = 400 − 396 =   4    t = 9 and 11
///   exact   k = 109 − 1 = 108   D = 400 − 432 = −32    none
///
/// k: 9 ulp of 2⁻¹⁷ (108 lies in 2⁶..2⁷) are 9·2¹⁷; D: 36 of 2⁻¹⁸ (32 in 2⁵..2⁶) are 36·2¹⁸.
#[test]
fn errors_are_those_calculated_by_hand() {
    let far = scene(vec![sphere(DVec3::new(100_000_003.0, 0.0, -10.0), 1.0)], vec![]);
    let explanation = of_ray(far, [1e8, 0.0, 0.0], [0.0, 0.0, -1.0]);
    let sphere = object(&explanation, 1);
    let entry = |value, error_ulp, wrong_sign| Some(Approximation { value, error_ulp, wrong_sign });
    let right = |value| entry(Some(value), Some(0.0), false);
    let none = entry(None, None, false);

    let k = row(sphere, "k");
    assert_eq!(k.lecture, entry(Some(99.0), Some(9.0 * 131_072.0), false));
    assert_eq!((k.stable, k.f64), (right(108.0), right(108.0)));
    let d = row(sphere, "D");
    assert_eq!(d.lecture, entry(Some(4.0), Some(36.0 * 262_144.0), true));
    assert_eq!((d.stable, d.f64), (None, right(-32.0)));
    let near = row(sphere, "t₁");
    assert_eq!(near.lecture, entry(Some(9.0), None, false));
    assert_eq!((near.stable, near.f64), (none, none));

    let why = ["D < 0: the line misses the sphere", "wrong in f32 lecture, which sees a hit"];
    assert_why(sphere, Reason::Missed, &why);
    let shown = text(&explanation);
    assert!(shown.contains("sign! 9.4e6 ulp"), "{shown}");
    assert!(shown.contains("no root"), "{shown}");
    let wrong: Vec<&str> =
        explanation.seen.iter().filter(|seen| !seen.right).map(|seen| seen.kernel).collect();
    assert_eq!(wrong, ["lecture"]);
}

/// A plane at t = 0.1: as f32 that is 13421773·2⁻²⁷ = 0.100000001490116…, which is 1.490116…·10⁻⁹
/// more than the f64 that the scene means, and an ulp there is 2⁻²⁷ = 7.450580…·10⁻⁹: one fifth.
#[test]
fn the_error_of_a_rounded_number_is_a_fraction_of_an_ulp() {
    let wall = scene(vec![], vec![plane(DVec3::new(0.0, 0.0, -0.1), DVec3::Z)]);
    let explanation = of_ray(wall, [0.0; 3], [0.0, 0.0, -1.0]);
    let row = row(object(&explanation, 1), "t");
    let error = row.lecture.and_then(|entry| entry.error_ulp).unwrap();
    assert!((error - 0.2).abs() < 1e-7, "{error}");
    assert_eq!(row.f64.and_then(|entry| entry.error_ulp), Some(0.0));
    assert_eq!(explanation.seen[0].t_error_ulp, Some(error), "the same error as of the result");
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
            let mut camera = common::camera(in_cube(&mut rng), in_cube(&mut rng) * 3.0);
            if round % 4 == 0 {
                camera.projection = Projection::Orthographic { height: 3.0 };
            }
            let whole = Pixels::whole(View::new(&camera), 301, 203);
            let (x, y) = (rng.random_range(0..301), rng.random_range(0..203));
            Rays::Pixels(Pixels { x, y, width: 1, height: 1, ..whole })
        } else {
            let direction = in_cube(&mut rng) * log_uniform(&mut rng, 1e-6, 1e6);
            Rays::List(vec![Ray { origin: in_cube(&mut rng) * 10.0, direction }])
        };
        let explanation = explain(&scene, &rays, None).unwrap();
        assert_written(&explanation);
        let ray = match &rays {
            Rays::Pixels(pixels) => pixels.ray(pixels.x, pixels.y),
            Rays::List(rays) => rays[0],
        };
        let components = [ray.origin.to_array(), ray.direction.to_array()].concat();
        for (row, component) in explanation.ray.iter().zip(components) {
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
                let roots = object.quantities.iter().filter(|row| row.symbol.starts_with('t'));
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
            of_ray(scene, origin.to_array(), direction.to_array());
        }
    }
}

#[test]
fn the_nearest_come_first_and_twenty_are_enough() {
    let spheres: Vec<_> = (0..30)
        .map(|i| {
            let x = if i % 2 == 0 { 0.0 } else { 50.0 - f64::from(i) };
            sphere(DVec3::new(x, 0.0, f64::from(i) * 3.0 - 100.0), 1.0)
        })
        .collect();
    let scene = Arc::new(scene(spheres, vec![]));
    let rays = ray([0.0; 3], [0.0, 0.0, -1.0]);
    let ids = |limit| -> Vec<u32> {
        let explanation = explain(&scene, &rays, limit).unwrap();
        assert_eq!(explanation.n_objects, 30);
        explanation.objects.iter().map(|object| object.id).collect()
    };
    let all = ids(None);
    let hit = (0..15).map(|i| 29 - 2 * i);
    let missed = (0..15).map(|i| 30 - 2 * i);
    assert_eq!(all, hit.chain(missed).collect::<Vec<u32>>());
    assert_eq!(ids(Some(DEFAULT_OBJECTS)), all[..20]);
    let shown = text(&explain(&scene, &rays, Some(DEFAULT_OBJECTS)).unwrap());
    assert!(shown.contains("Left out: 10 more of 30 objects"), "{shown}");
}

#[track_caller]
fn run(args: &[&str]) -> String {
    program::run(&[&["explain"], args].concat(), 0).text().to_owned()
}

#[test]
fn the_program_shows_what_the_gpu_computes() {
    gpu();
    let scene = file("figure5");
    for (on, shown) in [
        ("640,360", "certified GPU sphere 2 (touched)"),
        ("639,361", "certified GPU sphere 3 (pierced)"),
        ("0,0", "certified GPU background"),
    ] {
        let text = run(&[&scene, "--pixel", on, "--device", "gpu"]);
        assert!(text.contains(shown), "{text}");
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
        assert!(!text.contains("WRONG") && !text.contains("No GPU"), "{text}");
        assert!(!text.contains('\u{1b}'), "{text}");
    }
    let text = run(&[&scene, "--ray", "-0,0,0,0,0,-2", "--device", "gpu"]);
    assert!(text.contains("The ray sees sphere 2 (touched): t = 12\n"), "{text}");
    for kernel in ["lecture", "stable", "double", "certified"] {
        for device in ["CPU", "GPU"] {
            let start = format!("  {kernel:<9} {device} sphere 2 (touched) ");
            let line = text.lines().find(|line| line.starts_with(&start));
            let end = "12       0 ulp  -0.6000 -0.8000 0.0000";
            assert!(line.is_some_and(|line| line.ends_with(end)), "{text}");
        }
    }
}

#[test]
fn without_a_gpu_the_program_says_so() {
    let text = run(&[&file("figure5"), "--pixel", "640,360", "--device", "cpu"]);
    assert!(text.contains("No GPU took part: these are the CPU's results alone."), "{text}");
    assert!(!text.contains(" GPU sphere"), "{text}");
}

#[test]
fn json_has_the_head_of_the_others_and_all_numbers() {
    let facts = gpu().facts.clone();
    let scene = file("figure5");
    let json = |device| -> Value {
        let text = run(&[&scene, "--pixel", "640,360", "--device", device, "--json"]);
        serde_json::from_str(&text).unwrap()
    };
    let on_gpu = json("gpu");
    let keys: Vec<&str> = on_gpu.as_object().unwrap().keys().map(String::as_str).collect();
    let mut expected =
        ["schema", "version", "command", "adapter", "device", "objects", "explanation"];
    expected.sort_unstable();
    assert_eq!(keys, expected);
    assert_eq!((&on_gpu["schema"], &on_gpu["command"]), (&1.into(), &"explain".into()));
    assert_eq!(on_gpu["adapter"]["name"], facts.name.as_str());
    let explanation = &on_gpu["explanation"];
    let pixel = serde_json::json!({"x": 640, "y": 360, "width": 1281, "height": 721});
    assert_eq!(explanation["pixel"], pixel);
    assert_eq!(explanation["level"], "exact");
    assert_eq!(explanation["winner"]["t"], "24");
    let touched = &explanation["objects"][0];
    assert_eq!(touched["reason"], serde_json::json!({"is": "visible"}));
    assert_eq!(touched["terms"]["shape"], "sphere");
    let d = &touched["quantities"][3];
    assert_eq!(d["symbol"], "D");
    let zero = serde_json::json!({"value": 0.0, "error_ulp": 0.0, "wrong_sign": false});
    assert_eq!((&d["lecture"], &d["stable"], &d["f64"]), (&zero, &Value::Null, &zero));
    assert_eq!(d["exact"], serde_json::json!({"decimal": "0", "signum": 0}));
    assert_eq!(explanation["seen"].as_array().map(Vec::len), Some(8));
    assert_eq!(explanation["seen"][7]["device"], "gpu");

    let on_cpu = json("cpu");
    assert_eq!((&on_cpu["adapter"], &on_cpu["device"]), (&Value::Null, &"cpu".into()));
    assert_eq!(on_cpu["explanation"]["seen"].as_array().map(Vec::len), Some(4));
}

#[test]
fn latex_is_all_that_latex_prints() {
    let scene = file("figure1");
    let text = run(&[&scene, "--pixel", "100,600", "--device", "cpu", "--latex"]);
    assert!(text.starts_with("% pixel (100, 600) of 1280x720\n\\begin{align*}\n"), "{text}");
    assert!(text.ends_with("\\end{align*}\n"), "{text}");
    assert!(text.contains(r"\frac{-2.2}{-0.375868} \approx 5.85312"), "{text}");
    assert_written(&of_pixel("figure1", 100, 600));
}

#[test]
fn size_and_crop_mean_what_they_mean_elsewhere() {
    let scene = file("figure5");
    let start = [scene.as_str(), "--device", "cpu", "--pixel"];
    let small = run(&[&start[..], &["10,5", "--size", "21x11"]].concat());
    assert!(small.starts_with("Pixel (10, 5) of 21×11: "), "{small}");
    assert!(small.contains("The ray sees sphere 2 (touched): t = 24\n"), "{small}");
    let cropped = run(&[&start[..], &["10,5", "--size", "21x11", "--crop", "9,4,3,3"]].concat());
    assert_eq!(cropped, small, "a pixel counts from the corner of the whole picture");
}

#[test]
fn wrong_usage_exits_2_and_says_what_is_allowed() {
    let scene = file("figure5");
    let cases: [(&[&str], &str); 14] = [
        (&["--pixel", "1281,0"], "X goes from 0 to 1280, Y from 0 to 720"),
        (&["--pixel", "0,721"], "X goes from 0 to 1280, Y from 0 to 720"),
        (&["--pixel", "-1,0"], "X goes from 0 to 1280"),
        (&["--pixel", "5,5", "--crop", "10,20,30,40"], "X goes from 10 to 39, Y from 20 to 59"),
        (&["--pixel", "21,0", "--size", "21x11"], "X goes from 0 to 20, Y from 0 to 10"),
        (&["--pixel", "1.5,0"], "whole pixels"),
        (&["--pixel", "1"], "whole pixels"),
        (&["--ray", "0,0,0,0,0,0"], "points nowhere"),
        (&["--ray", "0,0,0,0,0,inf"], "not finite"),
        (&["--ray", "nan,0,0,0,0,1"], "not finite"),
        (&["--ray", "0,0,0,0,1"], "six numbers"),
        (&["--ray", "0,0,0,0,0,1", "--pixel", "1,1"], "cannot be used with"),
        (&["--ray", "0,0,0,0,0,1", "--size", "3x3"], "cannot be used with"),
        (&[], "--pixel"),
    ];
    for (args, says) in cases {
        let args = [&["explain", scene.as_str(), "--device", "cpu"], args].concat();
        let ran = program::run(&args, 2);
        assert!(ran.stderr.contains(says), "{args:?}\n{}", ran.stderr);
        assert_eq!(ran.stdout, b"", "{args:?}");
    }
}
