//! A scene file is read as it is written. What is said of wrong ones stands in `tests/answers`, which `ci/answers.sh` compares.

use std::path::Path;

use glam::DVec3;
use kugelblitz::Error;
use kugelblitz::error::SceneError;
use kugelblitz::scene::{
    Color, Light, Projection, Samples, Scene, Sky, Source, parse_scene, read_scene,
};

fn parse(text: &str) -> Result<Scene, Box<SceneError>> {
    match parse_scene(text, Path::new("a.toml")) {
        Ok(scene) => Ok(scene),
        Err(Error::Scene(error)) => Err(error),
        Err(other) => panic!("not a scene error: {other:?}\n{text}"),
    }
}

const CAMERA: &str = "[camera]\nposition = [0, 1, 6]\nlook_at = [0, 1, 0]\n";
const SPHERE: &str = "[[sphere]]\ncenter = [0, 1, -4]\nradius = 2\ncolor = \"#d62728\"\n";
const PLANE: &str = "[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\ncolor = [0.5, 0, 1]\n";
const CLOUD: &str = "[[spheres]]\nfile = \"missing.npy\"\nradius = 0.01\ncolor = \"#1f77b4\"\n";
const IMAGE: &str = "[image]\nwidth = 1280\nheight = 720\n";
const POINT: &str = "[[light]]\nposition = [4, 6, 3]\ncolor = [1, 0.5, 0]\nintensity = 0.9\n\
                     shadows = false\n";
const SUN: &str = "[[light]]\ndirection = [-1, -2, -1]\n";
const SKY: &str = "[sky]\nintensity = 0.5\ndirections = 16\n";

#[test]
fn the_tables_of_the_cases_are_right_as_they_stand() {
    for text in [CAMERA, SPHERE, PLANE, IMAGE, POINT, SUN, SKY] {
        parse(text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    }
}

#[test]
fn a_scene_is_read_as_it_is_written() {
    let text = format!(
        "background = \"#20242c\"\n{CAMERA}fov = 40\nup = [0, 2, 0.5]\n{IMAGE}\
         [[sphere]]\nname = \"b\"\ncenter = [0.1, 9007199254740993, 0x10]\nradius = 1_0.5\n\
         color = \"#D62728\"\n{SPHERE}{PLANE}"
    );
    let scene = parse(&text).unwrap();
    let camera = scene.require_camera(Path::new("a.toml")).unwrap();
    assert_eq!(scene.background, Color::from_srgb8([0x20, 0x24, 0x2c]));
    assert_eq!(camera.position.to_array(), [0.0, 1.0, 6.0]);
    assert_eq!(camera.look_at.to_array(), [0.0, 1.0, 0.0]);
    assert_eq!(camera.up.to_array(), [0.0, 2.0, 0.5]);
    assert_eq!(camera.projection, Projection::Perspective { fov_degrees: 40.0 });
    assert_eq!(scene.image.map(|i| (i.width, i.height)), Some((1280, 720)));
    assert_eq!(scene.spheres.name(0), Some("b"));
    // 2⁵³ + 1 is no f64; the nearest (ties to even) is 2⁵³.
    let center = [0.1, 9007199254740992.0, 16.0];
    assert_eq!(scene.spheres[0].center.to_array(), center);
    assert_eq!(scene.spheres[0].radius, 10.5);
    assert_eq!(scene.spheres.color(0).unwrap().to_srgb8(), [0xd6, 0x27, 0x28]);
    assert_eq!(scene.spheres.name(1), None);
    assert_eq!(scene.planes[0].normal.to_array(), [0.0, 1.0, 0.0]);
    assert_eq!(scene.planes[0].color, Color([0.5, 0.0, 1.0]));
    assert_eq!(scene.n_objects(), 3);
}

#[test]
fn lights_are_read_as_they_are_written() {
    let text = format!("ambient = 0.1\n[image]\nsamples = 3\n{POINT}{SUN}{SKY}");
    let scene = parse(&text).unwrap();
    let color = Color([1.0, 0.5, 0.0]);
    let point = Source::Point(DVec3::new(4.0, 6.0, 3.0));
    let white = Color([1.0; 3]);
    let sun = Source::Sun(DVec3::new(-1.0, -2.0, -1.0));
    assert_eq!(
        scene.lights,
        [
            Light { source: point, color, intensity: 0.9, shadows: false },
            Light { source: sun, color: white, intensity: 1.0, shadows: true },
        ]
    );
    assert_eq!(scene.sky, Some(Sky { intensity: 0.5, directions: 16 }));
    assert_eq!(scene.ambient, Some(Color([0.1; 3])));
    assert_eq!((scene.image, scene.samples), (None, Some(Samples::nearest(3))));
    assert!(scene.is_lit());

    let scene = parse("ambient = \"#808080\"\n[[light]]\nposition = \"eye\"\n").unwrap();
    assert_eq!(scene.lights[0].source, Source::Eye);
    assert_eq!(scene.ambient, Some(Color::from_srgb8([0x80; 3])));
    let scene = parse("ambient = [0, 0.25, 1]\n[sky]\nintensity = 0\n").unwrap();
    assert_eq!(scene.ambient, Some(Color([0.0, 0.25, 1.0])));
    assert_eq!(scene.sky, Some(Sky { intensity: 0.0, directions: 64 }));
    assert_eq!(parse("ambient = 7").unwrap().ambient, Some(Color([7.0; 3])));
    let most = parse(
        "[image]\nwidth = 2\nheight = 3\nsamples = 16\n[sky]\nintensity = 1\ndirections = 65536",
    )
    .unwrap();
    assert_eq!((most.samples, most.sky.unwrap().directions), (Some(Samples::nearest(16)), 65536));
    assert_eq!(most.image.map(|i| (i.width, i.height)), Some((2, 3)));
    let unlit = parse(&format!("{IMAGE}{SPHERE}")).unwrap();
    assert!(!unlit.is_lit() && unlit.samples.is_none());
}

#[test]
fn decimal_text_is_the_nearest_f64() {
    // Decimals just below, on and just above the middle between 1 and the next f64.
    let middle = "1.00000000000000011102230246251565404236316680908203125";
    let below = middle.replace("3125", "3124");
    let above = format!("{middle}1");
    for (text, radius) in [
        (middle, 1.0),
        (&below, 1.0),
        (&above, 1.0 + f64::EPSILON),
        ("1.7976931348623157e308", f64::MAX),
        ("4.9e-324", 5e-324),
        ("0.1", 0.1),
    ] {
        let text = SPHERE.replace("= 2", &format!("= {text}")).replace("[0, 1, -4]", "[0, 0, 0]");
        assert_eq!(parse(&text).unwrap().spheres[0].radius, radius, "{text}");
    }
}

#[test]
fn what_is_optional_has_its_default() {
    let scene = parse("").unwrap();
    assert_eq!(scene.background, Color::BLACK);
    assert_eq!((scene.n_objects(), scene.camera.is_none(), scene.image), (0, true, None));
    let camera = parse(CAMERA).unwrap().camera.unwrap();
    assert_eq!(camera.up.to_array(), [0.0, 1.0, 0.0]);
    assert_eq!(camera.projection, Projection::Perspective { fov_degrees: 45.0 });
    let camera = parse(&format!("{CAMERA}height = 5e-323")).unwrap().camera.unwrap();
    assert_eq!(camera.projection, Projection::Orthographic { height: 5e-323 });
    // Names may repeat, and a plain list of inline tables is the same as [[sphere]].
    let ball = "{ name = \"x\", center = [0, 0, 0], radius = 1, color = [1, 1, 1] }";
    let scene = parse(&format!("sphere = [{ball}, {ball}]")).unwrap();
    assert_eq!(scene.n_objects(), 2);
}

#[test]
fn a_scene_without_camera_says_so() {
    let scene = parse(SPHERE).unwrap();
    let error = scene.require_camera(Path::new("a.toml")).unwrap_err();
    assert_eq!(error.to_string(), "a.toml: the scene has no [camera]");
    assert_eq!(error.exit_code(), 3);
    let Error::Scene(error) = error else {
        panic!("{error:?}");
    };
    // The help holds a camera that can be pasted as it stands.
    let example = &error.help[error.help.find("[camera]").unwrap()..];
    assert!(parse(example).unwrap().camera.is_some(), "{example}");
}

#[test]
fn files_that_are_no_text_are_scene_errors() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("missing.toml");
    for path in [missing.as_path(), folder.path()] {
        let error = read_scene(path).unwrap_err();
        assert_eq!(error.exit_code(), 3);
        let start = format!("{}: cannot read the scene: ", path.display());
        assert!(error.to_string().starts_with(&start), "{error}");
    }
    let path = folder.path().join("latin1.toml");
    std::fs::write(&path, b"# ok\n# caf\xe9\n").unwrap();
    let Err(Error::Scene(error)) = read_scene(&path) else {
        panic!("a Latin-1 file was read");
    };
    assert_eq!((error.line, error.column), (2, 6));
    assert!(error.message.contains("0xe9"), "{error}");
    assert!(error.help.contains("UTF-8"));
    assert_eq!(&error.text[error.span.clone()], "\u{fffd}");
    std::fs::write(&path, CAMERA).unwrap();
    assert!(read_scene(&path).is_ok());
}

/// However much stands there, a message quotes a part of it.
#[test]
fn a_message_quotes_no_more_than_a_part() {
    let long = "9".repeat(100_000);
    for text in [
        format!("{long} = 1\n"),
        format!("[[{long}]]\n"),
        format!("background = \"{long}\"\n"),
        SPHERE.replace("= 2", &format!("= {long}")),
        SPHERE.replace("= 2", &format!("= 1e{long}")),
        IMAGE.replace("720", &long),
        CLOUD.replace("missing.npy", &long),
        SPHERE.replace("= 2", &format!("= {{ \"{long}\" = 2 }}")),
        format!("a = 1\n[{long}]\n[{long}]\n"),
        format!("{long}\n"),
    ] {
        let error = parse(&text).unwrap_err();
        assert!(error.message.len() + error.help.len() < 1000, "{error}\n{}", error.help);
    }
}
