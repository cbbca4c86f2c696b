//! What `export` writes is read back number by number, with a reader of its own.

use glam::DVec3;
use kugelblitz::rays::View;
use kugelblitz::scene::{Color, Scene, read_scene};
use kugelblitz_judge::export::{Language, write};
use kugelblitz_tests::{camera, in_cube, log_uniform, plane, root, scene, sphere};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

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
