//! What `export` writes is read back number by number, with a reader of its own.

use std::fs;
use std::path::Path;

use glam::DVec3;
use kugelblitz::rays::{Lens, View};
use kugelblitz::scene::{Color, Light, Scene, Source, parse_scene, read_scene};
use kugelblitz_judge::export::{Language, write};
use kugelblitz_tests::{camera, in_cube, log_uniform, plane, root, scene, sphere};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::program::{run, scene_file};

/// The subject of a line of a file in another language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Sphere,
    Plane,
    Background,
    Camera,
}

/// The numbers of a file by the line that holds them, as bits.
type Lines = Vec<(Kind, Vec<u64>)>;

fn bits(numbers: impl IntoIterator<Item = f64>) -> Vec<u64> {
    numbers.into_iter().map(f64::to_bits).collect()
}

/// The words of a line that are numbers.
fn numbers(line: &str) -> Vec<u64> {
    let words = line.split([' ', ',', '<', '>', '{', '}']).filter(|word| !word.is_empty());
    bits(words.filter_map(|word| word.parse::<f64>().ok()))
}

fn read(language: Language, text: &str) -> Lines {
    let mut lines = Lines::new();
    for line in text.lines() {
        let line = match language {
            Language::Pov => line.split("//").next().unwrap().trim(),
            Language::Tachyon => line,
        };
        let kind = match line.split(' ').next().unwrap() {
            "sphere" | "SPHERE" => Kind::Sphere,
            "plane" | "PLANE" => Kind::Plane,
            "background" | "BACKGROUND" => Kind::Background,
            "location" | "direction" | "right" | "up" => Kind::Camera,
            "ZOOM" | "CENTER" | "VIEWDIR" | "UPDIR" | "FRUSTUM" | "RESOLUTION" => Kind::Camera,
            _ => continue,
        };
        lines.push((kind, numbers(line)));
    }
    lines
}

/// The lines that a file must have.
fn expected(language: Language, scene: &Scene, view: &View, [w, h]: [u32; 2]) -> Lines {
    let (width, height) = (f64::from(w), f64::from(h));
    let vector = |v: DVec3| match language {
        Language::Pov => v.to_array(),
        Language::Tachyon => [v.x, v.y, -v.z],
    };
    let color = |color: Color| match language {
        Language::Pov => color.0,
        Language::Tachyon => color.to_srgb8().map(|byte| (f64::from(byte) + 0.5) / 255.0),
    };
    let line = |kind, parts: &[&[f64]]| (kind, bits(parts.concat()));
    let end = |c: Color| match language {
        Language::Pov => color(c).to_vec(),
        Language::Tachyon => [&[1.0, 0.0, 0.0, 1.0][..], &color(c), &[0.0]].concat(),
    };
    let mut lines = match language {
        Language::Pov => vec![
            line(Kind::Camera, &[&view.position.to_array()]),
            line(Kind::Camera, &[&view.forward.to_array()]),
            line(Kind::Camera, &[&(view.right * (2.0 * view.h * width / height)).to_array()]),
            line(Kind::Camera, &[&(view.true_up * (2.0 * view.h)).to_array()]),
        ],
        Language::Tachyon => {
            let (x, y) = (view.h * width / height, view.h);
            // Half a pixel to the left and down.
            let back = view.h / height;
            vec![
                line(Kind::Camera, &[&[width, height]]),
                line(Kind::Camera, &[&[0.5 / view.h]]),
                line(Kind::Camera, &[&vector(view.position)]),
                line(Kind::Camera, &[&vector(view.forward)]),
                line(Kind::Camera, &[&vector(view.true_up)]),
                line(Kind::Camera, &[&[-x - back, x - back, -y - back, y - back]]),
            ]
        }
    };
    lines.push(line(Kind::Background, &[&color(scene.background)]));
    for (s, color) in scene.spheres.iter().zip(scene.spheres.colors()) {
        let shape = [&vector(s.center)[..], &[s.radius]].concat();
        lines.push(line(Kind::Sphere, &[&shape, &end(color)]));
    }
    for p in &scene.planes {
        let (point, normal) = (vector(p.point), vector(p.normal));
        lines.push(match language {
            Language::Pov => line(Kind::Plane, &[&normal, &[0.0], &point, &end(p.color)]),
            Language::Tachyon => line(Kind::Plane, &[&point, &normal, &end(p.color)]),
        });
    }
    lines
}

/// Tells the first line that is wrong in a file.
fn compare(found: &Lines, expected: &Lines) -> Result<(), String> {
    if found.len() != expected.len() {
        return Err(format!("{} lines, not {}", found.len(), expected.len()));
    }
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        if found != expected {
            let show = |bits: &[u64]| bits.iter().map(|&b| f64::from_bits(b)).collect::<Vec<_>>();
            let (a, b) = (show(&found.1), show(&expected.1));
            return Err(format!("line {i}: {:?} {a:?}, not {:?} {b:?}", found.0, expected.0));
        }
    }
    Ok(())
}

fn text(language: Language, scene: &Scene, view: &View, size: [u32; 2]) -> String {
    let palette: Vec<_> = scene.colors().collect();
    let mut text = Vec::new();
    write(language, scene, view, size, |id| palette[id as usize], &mut text).unwrap();
    String::from_utf8(text).unwrap()
}

const SIZE: [u32; 2] = [641, 363];

fn figure(name: &str) -> (Scene, View) {
    let path = root().join("scenes").join(name);
    let scene = read_scene(&path).unwrap();
    let view = View::new(scene.camera.as_ref().unwrap());
    (scene, view)
}

#[test]
fn every_object_and_every_number_of_the_figures_comes_back() {
    for name in ["figure1.toml", "figure2.toml", "figure3.toml", "figure4.toml", "figure5.toml"] {
        let (scene, view) = figure(name);
        for language in Language::ALL {
            let found = read(language, &text(language, &scene, &view, SIZE));
            let expected = expected(language, &scene, &view, SIZE);
            compare(&found, &expected).unwrap_or_else(|what| panic!("{name}: {what}"));
        }
    }
}

/// The same numbers, and the word that tells what they mean; it stands before them.
#[test]
fn an_orthographic_camera_is_exported_as_one() {
    let (scene, mut view) = figure("figure1.toml");
    for (lens, words) in [
        (Lens::Perspective, ["perspective", "PROJECTION PERSPECTIVE"]),
        (Lens::Orthographic, ["orthographic", "PROJECTION ORTHOGRAPHIC"]),
    ] {
        view.lens = lens;
        for (language, word) in Language::ALL.into_iter().zip(words) {
            let text = text(language, &scene, &view, SIZE);
            let first = text.lines().position(|line| line.trim() == word).expect(word);
            let vectors = ["  location", "ZOOM"][usize::from(language == Language::Tachyon)];
            assert!(text.lines().nth(first + 1).unwrap().starts_with(vectors));
            compare(&read(language, &text), &expected(language, &scene, &view, SIZE)).unwrap();
        }
    }
}

/// Numbers of any size, also those with 17 digits and subnormal ones.
#[test]
fn any_f64_comes_back() {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut vector = || {
        let magnitude = log_uniform(&mut rng, 1e-310, 1e300);
        in_cube(&mut rng) * magnitude
    };
    let spheres = (0..300).map(|_| sphere(vector(), vector().x.abs())).collect();
    let planes = (0..300).map(|_| plane(vector(), vector())).collect();
    let mut scene = scene(spheres, planes);
    scene.spheres[0].center = DVec3::new(-0.0, 5e-324, f64::MAX);
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let colors = (0..300).map(|_| std::array::from_fn(|_| rng.random()));
    scene.spheres = scene.spheres.with_colors(colors.collect::<Vec<[f32; 3]>>()).unwrap();
    let view = View::new(&camera(DVec3::new(0.1, -0.2, 0.3), DVec3::new(1.0 / 3.0, 5.0, 7e8)));
    for language in Language::ALL {
        let found = read(language, &text(language, &scene, &view, SIZE));
        let expected = expected(language, &scene, &view, SIZE);
        compare(&found, &expected).unwrap();
    }
}

#[test]
fn sabotage_is_noticed() {
    let (scene, view) = figure("figure1.toml");
    for language in Language::ALL {
        let expected = expected(language, &scene, &view, SIZE);
        let right = read(language, &text(language, &scene, &view, SIZE));
        assert_eq!(compare(&right, &expected), Ok(()));
        for line in 0..right.len() {
            let mut wrong = right.clone();
            wrong.remove(line);
            assert!(compare(&wrong, &expected).is_err(), "line {line} dropped");
            for number in 0..right[line].1.len() {
                let mut wrong = right.clone();
                wrong[line].1[number] ^= 1;
                assert!(compare(&wrong, &expected).is_err(), "line {line}, number {number}");
            }
        }
        let (a, b) = (right.len() - 1, right.len() - 2);
        let mut wrong = right.clone();
        wrong.swap(a, b);
        assert!(compare(&wrong, &expected).is_err(), "two objects in the wrong order");
    }
}

#[test]
fn the_caller_gives_the_colours() {
    let (scene, view) = figure("figure2.toml");
    let code = |id: u32| Color::from_srgb8([id as u8, 17, 255]);
    let mut coded = scene.clone();
    coded.background = code(0);
    let ids = 1..=scene.spheres.len() as u32;
    coded.spheres = coded.spheres.with_colors(ids.map(code)).unwrap();
    for language in Language::ALL {
        let mut text = Vec::new();
        write(language, &scene, &view, SIZE, code, &mut text).unwrap();
        let found = read(language, std::str::from_utf8(&text).unwrap());
        compare(&found, &expected(language, &coded, &view, SIZE)).unwrap();
    }
}

/// The numbers of the lines that begin with a word.
fn lines_of(text: &str, word: &str) -> Vec<Vec<f64>> {
    let lines = text.lines().filter(|line| line.split(' ').next() == Some(word));
    lines.map(|line| numbers(line).into_iter().map(f64::from_bits).collect()).collect()
}

fn lit(text: &str) -> Scene {
    let text = format!("camera = {{ position = [1, 2, 9], look_at = [1, 2, 0] }}\n{text}");
    parse_scene(&text, Path::new("a.toml")).unwrap()
}

#[test]
fn lights_are_written() {
    let scene = lit("ambient = [0.25, 0.5, 0.75]\n\
                     light = [{ position = [4, 6, 3], color = [1, 0.5, 0], intensity = 0.75 }, \
                     { direction = [-1, -2, 2], shadows = false }, { position = \"eye\" }]\n\
                     sphere = [{ center = [3, 1, -40], radius = 2, color = [0.5, 0.1, 1] }]");
    let view = View::new(scene.camera.as_ref().unwrap());
    let [pov, tachyon] = Language::ALL.map(|language| text(language, &scene, &view, SIZE));

    let lights = lines_of(&pov, "light_source");
    assert_eq!(lights[0], [4.0, 6.0, 3.0, 0.75, 0.375, 0.0]);
    assert_eq!(lights[2], [1.0, 2.0, 9.0, 1.0, 1.0, 1.0]);
    let [x, y, z, 1.0, 1.0, 1.0, 1.0, 2.0, 9.0] = lights[1][..] else { panic!("{:?}", lights[1]) };
    let way = view.position - DVec3::new(x, y, z);
    let direction = DVec3::new(-1.0, -2.0, 2.0);
    assert!(way.length() > 100.0 * 49.0 && way.angle_between(direction) < 1e-7, "{way}");
    assert_eq!(pov.matches(" parallel point_at ").count(), 1);
    assert_eq!(pov.matches(" shadowless }").count(), 1);
    assert!(pov.contains("finish { ambient rgb <0.25, 0.5, 0.75> diffuse 1.0 }"), "{pov}");
    assert!(pov.contains("pigment { rgb <0.5, 0.1, 1.0> }"), "{pov}");

    // Tachyon's z is mirrored.
    let lights = lines_of(&tachyon, "LIGHT");
    assert_eq!(lights[0], [4.0, 6.0, -3.0, 0.0, 0.75, 0.375, 0.0]);
    assert_eq!(lights[1], [1.0, 2.0, -9.0, 0.0, 1.0, 1.0, 1.0]);
    let suns = lines_of(&tachyon, "DIRECTIONAL_LIGHT");
    assert_eq!(suns, [[-1.0, -2.0, -2.0, 1.0, 1.0, 1.0]]);
    assert!(tachyon.contains("# Without shadows, if Tachyon could:\nDIRECTIONAL_LIGHT "));
    assert!(tachyon.contains("AMBIENT 0.5 DIFFUSE 1.0 "), "{tachyon}");
    assert!(tachyon.contains("COLOR 0.5 0.1 1.0 TEXFUNC"), "{tachyon}");
    assert!(tachyon.is_ascii() && pov.is_ascii());
}

#[test]
fn a_sky_is_written_as_its_suns() {
    let mut scene = lit("[sky]\nintensity = 0.5\ndirections = 16\n");
    let suns = scene.sky.unwrap().suns();
    for projection in ["fov = 40", "height = 3"] {
        let camera = format!("[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n{projection}");
        scene.camera = parse_scene(&camera, Path::new("a.toml")).unwrap().camera;
        let view = View::new(scene.camera.as_ref().unwrap());
        let written = lines_of(&text(Language::Tachyon, &scene, &view, SIZE), "DIRECTIONAL_LIGHT");
        let expected = suns.iter().map(|sun| vec![sun.x, sun.y, -sun.z, 0.125, 0.125, 0.125]);
        assert!(written.into_iter().eq(expected));
        let pov = text(Language::Pov, &scene, &view, SIZE);
        assert_eq!(lines_of(&pov, "light_source").len(), 16);
    }
    // At the eye of an orthographic camera, a light is a sun.
    let eye =
        [Light { source: Source::Eye, color: Color([1.0; 3]), intensity: 1.0, shadows: true }];
    scene = Scene { lights: eye.to_vec(), sky: None, ..scene };
    let view = View::new(scene.camera.as_ref().unwrap());
    let written = lines_of(&text(Language::Tachyon, &scene, &view, SIZE), "DIRECTIONAL_LIGHT");
    assert_eq!(written, [[0.0, 0.0, 1.0, 1.0, 1.0, 1.0]]);
}

/// A name is a comment or not there, whatever is in it.
#[test]
fn a_name_stays_a_name() {
    let (mut scene, view) = figure("figure2.toml");
    let name = "x\nsphere { <0,0,0>, 9 }\r*/ #include \"x\" \u{2028}\nEND_SCENE é";
    scene.spheres.set_name(1, name);
    for language in Language::ALL {
        let text = text(language, &scene, &view, SIZE);
        assert!(text.is_ascii());
        let found = read(language, &text);
        compare(&found, &expected(language, &scene, &view, SIZE)).unwrap();
        if language == Language::Tachyon {
            assert_eq!(text.matches("END_SCENE").count(), 1);
            assert!(text.ends_with("END_SCENE\n"));
        }
    }
}

#[test]
fn the_command_writes_what_the_library_writes() {
    let (scene, view) = figure("figure3.toml");
    let path = scene_file("figure3");
    let folder = tempfile::tempdir().unwrap();
    for language in Language::ALL {
        let text = text(language, &scene, &view, SIZE);
        let ran = run(&["export", language.name(), &path, "--size", "641x363"], 0);
        assert_eq!(ran.text(), text);
        let talk = ran.stderr;
        assert!(talk.starts_with("standard output: ") && talk.lines().count() == 1, "{talk}");

        let file = folder.path().join(language.name());
        let out = file.to_str().unwrap();
        let args = ["export", language.name(), &path, "-o", out, "--json", "--size", "641x363"];
        let json = run(&args, 0).json();
        assert_eq!(fs::read_to_string(&file).unwrap(), text);
        assert_eq!(json["language"], language.name());
        assert_eq!(json["size"], serde_json::json!([641, 363]));
        assert_eq!(json["objects"]["spheres"], scene.spheres.len());
        assert!(json["run"].as_str().unwrap().contains(out), "{json}");
    }
}

#[test]
fn what_cannot_be_exported_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let (no_camera, out) = (path("no_camera.toml"), path("out.pov"));
    fs::write(
        &no_camera,
        "[[plane]]\npoint = [0.0, 0.0, 0.0]\nnormal = [0.0, 1.0, 0.0]\ncolor = \"#fff000\"",
    )
    .unwrap();
    fs::write(&out, "old").unwrap();
    let figure = scene_file("figure2");
    let cases: [(&[&str], i32, &str); 5] = [
        (&["export", "pov", &no_camera, "-o", &out], 3, "no [camera]"),
        (&["export", "pov", "missing.toml", "-o", &out], 3, "missing.toml"),
        (&["export", "blender", &figure, "-o", &out], 2, "possible values: pov, tachyon"),
        (&["export", "pov", &figure, "--json"], 2, "write to a file"),
        (&["export", "pov", &figure, "-o", &path("no/out.pov")], 1, "there is no folder"),
    ];
    for (args, code, message) in cases {
        let ran = run(args, code);
        assert!(ran.stderr.contains(message), "{args:?}: {}", ran.stderr);
        // With --json, the failure is an object.
        assert_eq!(ran.stdout.is_empty(), !args.contains(&"--json"), "{args:?}");
    }
    assert_eq!(fs::read_to_string(&out).unwrap(), "old");
}
