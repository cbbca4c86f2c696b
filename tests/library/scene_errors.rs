//! What is wrong in a scene file is said with its place, and nothing in a file makes the reader
//! panic.

use std::fmt::Write as _;
use std::path::Path;

use glam::DVec3;
use kugelblitz::Error;
use kugelblitz::error::SceneError;
use kugelblitz::scene::{
    Color, Light, Projection, Samples, Scene, Sky, Source, parse_scene, read_scene,
};
use kugelblitz_tests::text_of;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const SCENES: [&str; 9] = [
    "figure1",
    "figure2",
    "figure3",
    "figure4",
    "figure5",
    "inside",
    "orthographic",
    "lit/figure1",
    "lit/figure2",
];

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

/// A whole text with `‹` before and `›` behind the bytes that the error must be about (neither is
/// part of the file), and words that the message and the help must have.
type Case = (String, Words, Words);
type Words = &'static [&'static str];

/// `table` with `old` replaced by `new`, which carries the `‹›` marks.
fn case(table: &str, old: &str, new: &str, message: Words, help: Words) -> Case {
    assert!(table.contains(old), "{old:?} is not in\n{table}");
    (table.replacen(old, new, 1), message, help)
}

fn top(text: &str, message: Words, help: Words) -> Case {
    (format!("{text}{SPHERE}"), message, help)
}

#[rustfmt::skip]
fn cases() -> Vec<Case> {
    vec![
        // TOML itself
        case(SPHERE, "radius = 2", "radius = ‹›\n", &["TOML"], &[]),
        case(SPHERE, "radius = 2", "radius = 2\n‹radius› = 3", &["duplicate key"], &["[[sphere]]"]),
        case(SPHERE, "\"#d62728\"", "‹›#d62728", &["TOML"], &["quotes"]),
        case(SPHERE, "[[sphere]]", "[[sphere]‹›", &["TOML", "unclosed"], &["`]`"]),
        case(SPHERE, "= 2", "= ‹2x›", &["TOML"], &[]),
        // unknown keys at every level
        top("‹backgroud› = \"#000000\"\n", &["unknown key `backgroud`", "top of the file"], &["did you mean `background`?"]),
        top("‹fog› = 1\n", &["unknown key `fog`"], &["background, ambient, camera, image, light, sky, sphere, spheres, plane"]),
        top("[‹image1›]\n", &["unknown key `image1`"], &["`image`"]),
        case(CAMERA, "look_at", "‹lookat›", &["`lookat`", "[camera]"], &["did you mean `look_at`?"]),
        case(CAMERA, "[camera]", "[camera]\n‹background› = \"#ffffff\"", &["unknown key"], &["`background` belongs to the top of the file"]),
        case(IMAGE, "height", "‹heigth›", &["`heigth`", "[image]"], &["`height`"]),
        case(SPHERE, "radius", "‹Radius›", &["`Radius`", "[[sphere]]"], &["`radius`"]),
        case(SPHERE, "radius = 2", "radius = 2\n‹shine› = true", &["`shine`"], &["name, center, radius, color"]),
        case(PLANE, "color", "‹colour›", &["`colour`", "[[plane]]"], &["`color`"]),
        // of several, the first in the file
        case(SPHERE, "radius = 2", "‹zeta› = 2\nalpha = 3", &["`zeta`"], &[]),
        // wrong types
        top("background = ‹7›\n", &["integer", "`background`"], &["#rrggbb"]),
        top("camera = ‹\"left\"›\n", &["string", "`camera`"], &["[camera]"]),
        ("‹[[camera]]›\nposition = [0, 1, 6]\n".into(), &["list", "`camera`"], &["one table", "[camera]"]),
        ("‹[sphere]›\n".into(), &["table", "`sphere`"], &["list", "[[sphere]]"]),
        ("sphere = [‹3›]\n".into(), &["integer", "`sphere`"], &["[[sphere]]"]),
        case(CAMERA, "[0, 1, 6]", "‹6›", &["integer", "`position`"], &["three numbers", "position = ["]),
        case(CAMERA, "[0, 1, 6]", "‹[0, 1]›", &["2 values", "`position`"], &["three numbers"]),
        case(CAMERA, "[0, 1, 6]", "‹[0, 1, 6, 8]›", &["4 values"], &["three numbers"]),
        case(CAMERA, "[0, 1, 6]", "[0, ‹\"1\"›, 6]", &["string", "`position`"], &["number"]),
        case(IMAGE, "1280", "‹1280.0›", &["float", "`width`"], &["whole number of pixels"]),
        case(SPHERE, "= 2", "= ‹\"2\"›", &["string", "`radius`"], &["number", "radius = "]),
        case(SPHERE, "= 2", "= ‹true›", &["boolean"], &["number"]),
        case(SPHERE, "= 2", "= ‹1979-05-27›", &["date"], &["number"]),
        case(SPHERE, "= 2", "= ‹{ r = 2 }›", &["table"], &["number"]),
        case(SPHERE, "radius = 2", "radius = 2\nname = ‹5›", &["integer", "`name`"], &["string in quotes"]),
        case(PLANE, "[0.5, 0, 1]", "‹false›", &["boolean", "`color`"], &["#rrggbb"]),
        // a missing field
        case(CAMERA, "[camera]\nposition = [0, 1, 6]", "‹[camera]›", &["`position` is missing", "[camera]"], &["position = ["]),
        case(CAMERA, "[camera]\nposition = [0, 1, 6]\nlook_at = [0, 1, 0]", "‹[camera]›\nposition = [0, 1, 6]", &["`look_at` is missing"], &["look_at = ["]),
        case(IMAGE, "[image]\nwidth = 1280", "‹[image]›", &["`width` is missing"], &["width = 1280"]),
        case(IMAGE, "[image]\nwidth = 1280\nheight = 720", "‹[image]›\nwidth = 1280", &["`height` is missing"], &["height = 720"]),
        case(SPHERE, "[[sphere]]\ncenter = [0, 1, -4]", "‹[[sphere]]›", &["`center` is missing", "[[sphere]]"], &["center = ["]),
        case(SPHERE, "[[sphere]]\ncenter = [0, 1, -4]\nradius = 2", "‹[[sphere]]›\ncenter = [0, 1, -4]", &["`radius` is missing"], &["radius = "]),
        case(SPHERE, SPHERE, "‹[[sphere]]›\ncenter = [0, 1, -4]\nradius = 2", &["`color` is missing"], &["color = \"#"]),
        case(PLANE, "[[plane]]\npoint = [0, 0, 0]", "‹[[plane]]›", &["`point` is missing", "[[plane]]"], &["point = ["]),
        case(PLANE, "[[plane]]\npoint = [0, 0, 0]\nnormal = [0, 1, 0]", "‹[[plane]]›\npoint = [0, 0, 0]", &["`normal` is missing"], &["normal = ["]),
        ("sphere = [‹{ radius = 1 }›]\n".into(), &["`center` is missing"], &[]),
        (format!("{SPHERE}‹[[sphere]]›\nradius = 1\n"), &["`center` is missing"], &[]),
        // values out of range
        case(SPHERE, "= 2", "= ‹0›", &["`radius` is 0.0"], &["greater than 0"]),
        case(SPHERE, "= 2", "= ‹-1.5›", &["`radius` is -1.5"], &["greater than 0"]),
        case(SPHERE, "= 2", "= ‹1e-400›", &["`radius` is 0.0"], &["greater than 0"]),
        case(PLANE, "[0, 1, 0]", "‹[0, -0.0, 1e-400]›", &["`normal` is the zero vector"], &["direction", "zero"]),
        case(CAMERA, "[0, 1, 0]", "‹[0.0, 1.0, 6.0]›", &["`look_at`", "`position`", "same"], &["move"]),
        case(CAMERA, "[camera]", "[camera]\nup = ‹[0, 0, -7]›", &["`up` [0.0, 0.0, -7.0]", "parallel"], &["up = [0.0, 1.0, 0.0]"]),
        case(CAMERA, "[camera]", "[camera]\nup = ‹[0, 0, 1e300]›", &["parallel"], &["up ="]),
        case(CAMERA, "[camera]", "[camera]\nup = ‹[0, 0, 5e-324]›", &["parallel"], &["up ="]),
        case(CAMERA, "[camera]", "[camera]\nup = ‹[0, 0, 0]›", &["`up` is the zero vector"], &["direction"]),
        // the default `up` when looking straight down, and a thirds' direction that rounds
        case(CAMERA, "look_at = [0, 1, 0]", "look_at = ‹[0, -3, 6]›", &["default `up`", "parallel"], &["up = [0.0, 0.0, 1.0]"]),
        ("[camera]\nposition = [0, 0, 0]\nlook_at = [0.1, 0.2, 0.3]\nup = ‹[0.3, 0.6, 0.9]›\n".into(), &["parallel"], &["up = "]),
        case(CAMERA, "[camera]", "[camera]\nfov = ‹0›", &["`fov` is 0.0"], &["degrees", "180"]),
        case(CAMERA, "[camera]", "[camera]\nheight = ‹0›", &["`height` is 0.0"], &["world units", "greater than 0"]),
        case(CAMERA, "[camera]", "[camera]\nheight = ‹-2.5›", &["`height` is -2.5"], &["greater than 0"]),
        case(CAMERA, "[camera]", "[camera]\nheight = ‹5e-324›", &["`height` is 5e-324"], &["greater than 0"]),
        case(CAMERA, "[camera]", "[camera]\nheight = ‹inf›", &["`height`", "not a finite number"], &[]),
        case(CAMERA, "[camera]", "[camera]\nfov = 40\nheight = ‹4›", &["both `fov` and `height`"], &["orthographic", "remove one"]),
        case(CAMERA, "[camera]", "[camera]\nfov = ‹180.0›", &["`fov` is 180.0"], &["less than 180"]),
        case(CAMERA, "[camera]", "[camera]\nfov = ‹-40›", &["`fov` is -40.0"], &["greater than 0"]),
        case(CAMERA, "[camera]", "[camera]\nfov = ‹5e-324›", &["`fov` is 5e-324"], &["greater than 0"]),
        case(IMAGE, "1280", "‹0›", &["`width` is 0"], &["1 to 32768"]),
        case(IMAGE, "720", "‹32769›", &["`height` is 32769"], &["1 to 32768"]),
        case(IMAGE, "720", "‹-720›", &["`height` is -720"], &["1 to 32768"]),
        case(IMAGE, "720", "‹4294967297›", &["`height` is 4294967297"], &["1 to 32768"]),
        case(IMAGE, "720", "‹99999999999999999999›", &["99999999999999999999", "64 bits"], &["pixels"]),
        // numbers that are not finite or do not fit
        case(SPHERE, "= 2", "= ‹nan›", &["nan", "`radius`", "not a finite number"], &["finite"]),
        case(SPHERE, "= 2", "= ‹+inf›", &["inf", "not a finite number"], &["finite"]),
        case(SPHERE, "[0, 1, -4]", "[0, 1, ‹-1e999›]", &["-1e999", "`center`", "not a finite number"], &["1.8e308"]),
        case(PLANE, "[0, 1, 0]", "[0, ‹nan›, 0]", &["`normal`", "not a finite number"], &[]),
        case(PLANE, "[0.5, 0, 1]", "[0.5, ‹inf›, 1]", &["`color`", "not a finite number"], &[]),
        case(CAMERA, "[camera]", "[camera]\nfov = ‹-nan›", &["`fov`", "not a finite number"], &[]),
        case(CAMERA, "[camera]", "[camera]\nup = [‹inf›, 0, 0]", &["`up`", "not a finite number"], &[]),
        case(SPHERE, "= 2", "= ‹9223372036854775808›", &["9223372036854775808", "64 bits"], &["1e20"]),
        case(CAMERA, CAMERA, "[camera]\nposition = [-1e308, 0, 0]\nlook_at = ‹[1e308, 0, 0]›\n", &["`look_at`", "too far"], &["1.8e308"]),
        (format!("[camera]\nposition = [0, 0, -1e308]\nlook_at = [0, 0, 0]\n{}", SPHERE.replace("[0, 1, -4]", "‹[0, 0, 1e308]›")), &["`center`", "too far"], &[]),
        (format!("[camera]\nposition = [0, 0, -1e308]\nlook_at = [0, 0, 0]\n{}", PLANE.replace("[0, 0, 0]", "‹[0, 0, 1e308]›")), &["`point`", "too far"], &[]),
        case(SPHERE, "[0, 1, -4]\nradius = 2", "[1e308, 0, 0]\nradius = ‹1e308›", &["`radius`", "too far"], &[]),
        // colours
        case(SPHERE, "\"#d62728\"", "‹\"rot\"›", &["\"rot\" is not a colour"], &["#rrggbb", "name of CSS"]),
        case(SPHERE, "\"#d62728\"", "‹\"stealblue\"›", &["\"stealblue\" is not a colour"], &["did you mean \"steelblue\"?", "#rrggbb"]),
        case(SPHERE, "\"#d62728\"", "‹\"transparent\"›", &["is not a colour"], &["#rrggbb"]),
        case(SPHERE, "\"#d62728\"", "‹\"#ffff\"›", &["\"#ffff\""], &["#rrggbb"]),
        case(SPHERE, "\"#d62728\"", "‹\"#+62728\"›", &["is not a colour"], &["#rrggbb"]),
        case(PLANE, "[0.5, 0, 1]", "‹[0.5, 0, 255]›", &["255.0", "linear"], &["0 to 1"]),
        case(PLANE, "[0.5, 0, 1]", "‹[-0.5, 0, 1]›", &["-0.5"], &["0 to 1"]),
        case(PLANE, "[0.5, 0, 1]", "‹[0.5, 0]›", &["2 values", "`color`"], &["#rrggbb"]),
        // places count characters, and a byte order mark is none
        ("\u{feff}‹\"é\"› = 1\n".into(), &["unknown key `é`"], &[]),
        ("sphere = [{ name = \"日本\", ‹Radius› = 1 }]\r\n".into(), &["`Radius`"], &[]),
        // clouds; what is wrong in their files is in tests/library/clouds.rs
        case(CLOUD, "[[spheres]]\nfile = \"missing.npy\"", "‹[[spheres]]›", &["`file` is missing", "[[spheres]]"], &["file = \"cloud.npy\""]),
        case(CLOUD, "\"missing.npy\"", "‹7›", &["integer", "`file`"], &["string in quotes"]),
        case(CLOUD, "\"missing.npy\"", "‹\"missing.npy\"›", &["missing.npy: cannot read the cloud"], &["folder of the scene file"]),
        case(CLOUD, "\"missing.npy\"", "‹\"cloud.ply\"›", &["\"cloud.ply\"", "format"], &[".npy, .csv or .xyz"]),
        case(CLOUD, "\"missing.npy\"", "‹\"cloud\"›", &["\"cloud\"", "format"], &[".npy, .csv or .xyz"]),
        case(CLOUD, "= 0.01", "= ‹0›", &["`radius` is 0.0"], &["greater than 0"]),
        case(CLOUD, "= 0.01", "= ‹nan›", &["`radius`", "not a finite number"], &[]),
        case(CLOUD, "\"#1f77b4\"", "‹\"blu\"›", &["\"blu\" is not a colour"], &["did you mean \"blue\"?", "#rrggbb"]),
        case(CLOUD, "color", "‹colour›", &["`colour`", "[[spheres]]"], &["`color`"]),
        case(SPHERE, "radius = 2", "radius = 2\n‹file› = \"a.npy\"", &["`file`", "[[sphere]]"], &["`file` belongs to [[spheres]]"]),
        // lights, sky, ambient light and samples
        case(POINT, "[[light]]\nposition = [4, 6, 3]", "‹[[light]]›", &["`position` or `direction` is missing", "[[light]]"], &["position = [", "direction = ["]),
        case(POINT, "[4, 6, 3]", "[4, 6, 3]\ndirection = ‹[0, -1, 0]›", &["both `position` and `direction`"], &["sun", "remove one"]),
        case(POINT, "[4, 6, 3]", "‹\"camera\"›", &["`position` is \"camera\""], &["three numbers", "\"eye\""]),
        case(POINT, "[4, 6, 3]", "‹[4, 6]›", &["2 values", "`position`"], &["three numbers", "position = [4.0, 6.0, 3.0]"]),
        case(POINT, "[4, 6, 3]", "‹true›", &["boolean", "`position`"], &["three numbers"]),
        case(POINT, "[4, 6, 3]", "[4, ‹inf›, 3]", &["`position`", "not a finite number"], &[]),
        (format!("[camera]\nposition = [0, 0, -1e308]\nlook_at = [0, 0, 0]\n{}", POINT.replace("[4, 6, 3]", "‹[0, 0, 1e308]›")), &["`position`", "too far"], &["1.8e308"]),
        case(SUN, "[-1, -2, -1]", "‹[0, -0.0, 0]›", &["`direction` is the zero vector"], &["any length but zero"]),
        case(SUN, "[-1, -2, -1]", "[-1, ‹nan›, -1]", &["`direction`", "not a finite number"], &[]),
        case(SUN, "[-1, -2, -1]", "‹\"eye\"›", &["string", "`direction`"], &["three numbers"]),
        case(POINT, "[1, 0.5, 0]", "‹\"yelow\"›", &["\"yelow\" is not a colour"], &["did you mean \"yellow\"?", "#rrggbb"]),
        case(POINT, "[1, 0.5, 0]", "‹[1, 0.5, 2]›", &["2.0", "linear"], &["0 to 1"]),
        case(POINT, "0.9", "‹-0.9›", &["`intensity` is -0.9"], &["not negative", "intensity = 0.9"]),
        case(POINT, "0.9", "‹1e999›", &["`intensity`", "not a finite number"], &[]),
        case(POINT, "0.9", "‹\"0.9\"›", &["string", "`intensity`"], &["number"]),
        case(POINT, "false", "‹0›", &["integer", "`shadows`"], &["true or false", "shadows = true"]),
        case(POINT, "intensity", "‹intensty›", &["`intensty`", "[[light]]"], &["did you mean `intensity`?"]),
        case(POINT, "shadows", "‹shadow›", &["`shadow`", "[[light]]"], &["did you mean `shadows`?"]),
        case(POINT, "position", "‹center›", &["`center`", "[[light]]"], &["`center` belongs to [[sphere]]"]),
        ("‹[light]›\nposition = [4, 6, 3]\n".into(), &["table", "`light`"], &["list", "[[light]]"]),
        ("[[‹lights›]]\nposition = [4, 6, 3]\n".into(), &["`lights`"], &["did you mean `light`?"]),
        case(SKY, "[sky]\nintensity = 0.5", "‹[sky]›", &["`intensity` is missing", "[sky]"], &["intensity = 0.5"]),
        case(SKY, "0.5", "‹-1›", &["`intensity` is -1.0"], &["not negative"]),
        case(SKY, "16", "‹0›", &["`directions` is 0"], &["directions from 1 to 65536"]),
        case(SKY, "16", "‹65537›", &["`directions` is 65537"], &["1 to 65536"]),
        case(SKY, "16", "‹16.0›", &["float", "`directions`"], &["whole number"]),
        case(SKY, "directions", "‹direction›", &["`direction`", "[sky]"], &["`direction` belongs to [[light]]"]),
        case(SKY, "intensity", "‹color› = \"#ffffff\"\nintensity", &["`color`", "[sky]"], &["belongs to"]),
        ("‹[[sky]]›\nintensity = 1\n".into(), &["list", "`sky`"], &["one table", "[sky]"]),
        top("ambient = ‹-0.1›\n", &["`ambient` is -0.1"], &["not negative", "ambient = 0.1"]),
        top("ambient = ‹inf›\n", &["`ambient`", "not a finite number"], &[]),
        top("ambient = ‹\"dim\"›\n", &["\"dim\" is not a colour"], &["#rrggbb"]),
        top("ambient = ‹true›\n", &["boolean", "`ambient`"], &["#rrggbb"]),
        top("ambient = ‹[0.1, 0.1, 1.5]›\n", &["1.5", "linear"], &["0 to 1"]),
        ("[image]\nsamples = ‹0›\n".into(), &["`samples` is 0"], &["samples from 1 to 16"]),
        ("[image]\nsamples = ‹17›\n".into(), &["`samples` is 17"], &["1 to 16"]),
        ("[image]\nsamples = ‹2.0›\n".into(), &["float", "`samples`"], &["whole number of samples"]),
        ("[image]\n‹sample› = 4\n".into(), &["`sample`", "[image]"], &["did you mean `samples`?"]),
        ("‹[image]›\nsamples = 4\nwidth = 640\n".into(), &["`height` is missing"], &["height = 720"]),
        case(CAMERA, "[camera]", "[camera]\n‹samples› = 4", &["`samples`", "[camera]"], &["`samples` belongs to [image]"]),
    ]
}

#[test]
fn each_error_has_its_place_its_finding_and_its_advice() {
    let cases = cases();
    let mut wrong = String::new();
    for (marked, message, help) in &cases {
        let start = marked.find('‹').expect(marked);
        let end = marked.find('›').expect(marked) - '‹'.len_utf8();
        let text = marked.replace(['‹', '›'], "");
        let before = text[..start].trim_start_matches('\u{feff}');
        let line = before.matches('\n').count() + 1;
        let in_line = before.rsplit('\n').next().unwrap_or_default();
        let column = in_line.chars().count() + 1;
        let error = match parse(&text) {
            Ok(_) => {
                writeln!(wrong, "--- no error in\n{marked}").unwrap();
                continue;
            }
            Err(error) => error,
        };
        let place = format!("a.toml:{line}:{column}: ");
        // An empty mark is a place in the text where nothing certain was found.
        let spans = error.span == (start..end) || (start == end && error.span.start == start);
        let holds = spans
            && (error.line, error.column) == (line, column)
            && error.to_string() == place + &error.message
            && message.iter().all(|word| error.message.contains(word))
            && help.iter().all(|word| error.help.contains(word))
            && !error.help.is_empty()
            && error.text == text
            && error.path == Path::new("a.toml");
        if !holds {
            writeln!(
                wrong,
                "--- {marked}\n{error}\nhelp: {}\nspan {:?}, expected {:?} {line}:{column}\nwords {message:?} {help:?}",
                error.help,
                error.span,
                start..end,
            )
            .unwrap();
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
    assert!(cases.len() > 70, "{}", cases.len());
}

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

/// Linear colours have all digits that f64 has.
#[test]
fn linear_colours_are_f64() {
    let scene = parse(&PLANE.replace("[0.5, 0, 1]", "[0.1, 0.3, 1]")).unwrap();
    assert_eq!(scene.planes[0].color, Color([0.1, 0.3, 1.0]));
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

/// A nearest key is named only where the written one is a misspelling of it.
#[test]
fn a_key_is_suggested_where_one_is_near_and_not_elsewhere() {
    let help = |text: &str| parse(text).unwrap_err().help;
    let suggestion = |text: &str| -> Option<String> {
        let help = help(text);
        let rest = help.split("did you mean `").nth(1)?;
        Some(rest.split('`').next()?.to_owned())
    };
    for (header, near) in [
        (
            "",
            &[
                ("backgroud", "background"),
                ("background_", "background"),
                ("back_ground", "background"),
                ("Camera", "camera"),
                ("camrea", "camera"),
                ("camara", "camera"),
                ("Image", "image"),
                ("imgae", "image"),
                ("sfere", "sphere"),
                ("shpere", "sphere"),
                ("speres", "spheres"),
                ("planes", "plane"),
                ("palne", "plane"),
                ("lights", "light"),
                ("lihgt", "light"),
                ("ambiant", "ambient"),
                ("Sky", "sky"),
            ][..],
        ),
        (
            "[camera]",
            &[
                ("postion", "position"),
                ("pos", "position"),
                ("lookat", "look_at"),
                ("look-at", "look_at"),
                ("lookAt", "look_at"),
                ("fovy", "fov"),
                ("Up", "up"),
            ],
        ),
        (
            "[image]",
            &[("widht", "width"), ("heigth", "height"), ("hight", "height"), ("sample", "samples")],
        ),
        (
            "[[light]]",
            &[
                ("pos", "position"),
                ("dir", "direction"),
                ("colour", "color"),
                ("shadow", "shadows"),
            ],
        ),
        ("[sky]", &[("intensty", "intensity"), ("directons", "directions")]),
        (
            "[[sphere]]",
            &[
                ("centre", "center"),
                ("Center", "center"),
                ("raduis", "radius"),
                ("rad", "radius"),
                ("colour", "color"),
                ("nmae", "name"),
            ],
        ),
        ("[[plane]]", &[("norml", "normal"), ("normals", "normal"), ("piont", "point")]),
        ("[[spheres]]", &[("flie", "file"), ("files", "file"), ("radii", "radius")]),
    ] {
        for (key, expected) in near {
            let text = format!("{header}\n{key} = 1\n");
            assert_eq!(suggestion(&text).as_deref(), Some(*expected), "{text}");
        }
    }
    let far = [
        ("", "sun lamp fog scene title version objects box cube s a material torus"),
        ("[camera]", "target eye aspect near far direction focus size"),
        ("[image]", "aa dpi format w x"),
        ("[[sphere]]", "shine material mass texture velocity r c reflectivity"),
        ("[[plane]]", "d offset distance size texture"),
        ("[[spheres]]", "count scale path url"),
    ];
    for (header, keys) in far {
        for key in keys.split(' ') {
            let text = format!("{header}\n{key} = 1\n");
            assert_eq!(suggestion(&text), None, "{text}{}", help(&text));
            assert!(help(&text).contains("known keys here: "), "{text}{}", help(&text));
        }
    }
    // Of an unknown shape, the known ones are told.
    for shape in ["triangle", "box", "cone", "cylinder", "torus", "mesh", "disk", "cube", "lamp"] {
        for text in [format!("[[{shape}]]\nsize = 1\n"), format!("[{shape}]\nsize = 1\n")] {
            assert_eq!(suggestion(&text), None, "{text}{}", help(&text));
            let shapes = "the objects are [[sphere]], [[spheres]] and [[plane]]";
            assert!(help(&text).contains(shapes), "{text}{}", help(&text));
        }
    }
    assert_eq!(suggestion("[[spehre]]\n").as_deref(), Some("sphere"));
    // A key of another table is not a misspelling.
    assert!(help("[[sphere]]\nnormal = 1\n").contains("`normal` belongs to [[plane]]"));
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

/// Damages a scene in one of the ways in which files come out wrong.
fn mutate(rng: &mut ChaCha8Rng, scene: &str) -> Vec<u8> {
    const VALUES: [&str; 18] = [
        "nan",
        "-inf",
        "1e999",
        "-1e308",
        "1e-400",
        "0",
        "-1",
        "99999999999999999999",
        "0x7f",
        "true",
        "\"text\"",
        "\"#12345\"",
        "[]",
        "[1, 2]",
        "[[1], 2, 3]",
        "{ a = 1 }",
        "1979-05-27T07:32:00Z",
        "[nan, inf, -1e999]",
    ];
    const KEYS: [&str; 8] =
        ["radius", "center", "normal", "spheres", "\"\"", "camera.up", "raduis", "ключ"];
    let mut lines: Vec<String> = scene.lines().map(str::to_owned).collect();
    let some_line = rng.random_range(0..lines.len());
    let key_value = |rng: &mut ChaCha8Rng| {
        let with_value: Vec<_> = (0..lines.len()).filter(|&i| lines[i].contains('=')).collect();
        with_value[rng.random_range(0..with_value.len())]
    };
    match rng.random_range(0..9) {
        0 => drop(lines.remove(some_line)),
        1 => lines.insert(some_line, lines[rng.random_range(0..lines.len())].clone()),
        2 => {
            let (i, j) = (key_value(rng), key_value(rng));
            let value = lines[j].split_once('=').map(|(_, v)| v.to_owned());
            let key = lines[i].split_once('=').map(|(k, _)| k.to_owned());
            lines[i] = format!("{}={}", key.unwrap(), value.unwrap());
        }
        3 => {
            let i = key_value(rng);
            let key = lines[i].split('=').next().unwrap().to_owned();
            lines[i] = format!("{key}= {}", VALUES[rng.random_range(0..VALUES.len())]);
        }
        4 => {
            let i = key_value(rng);
            let value = lines[i].split_once('=').unwrap().1.to_owned();
            lines[i] = format!("{} ={value}", KEYS[rng.random_range(0..KEYS.len())]);
        }
        5 => {
            // One number of a line, so that vectors are hit inside as well.
            let i = key_value(rng);
            let value = VALUES[rng.random_range(0..VALUES.len())];
            let at = lines[i].rfind(|c: char| c.is_ascii_digit()).unwrap_or(0);
            let end = lines[i].len().min(at + 1);
            lines[i].replace_range(at..end, value);
        }
        6 => {
            let bytes = scene.as_bytes();
            return bytes[..rng.random_range(0..bytes.len())].to_vec();
        }
        7 => {
            let mut bytes = scene.as_bytes().to_vec();
            for _ in 0..rng.random_range(1..=8) {
                let at = rng.random_range(0..bytes.len());
                bytes[at] = rng.random();
            }
            return bytes;
        }
        _ => {
            let open = ["[", "{a=", "[[", "\"", "'''", "\\u", "[a."][rng.random_range(0..7)];
            lines.insert(some_line, open.repeat(rng.random_range(1..2000)));
        }
    }
    (lines.join("\n") + "\n").into_bytes()
}

#[test]
fn no_damaged_scene_panics() {
    const N: u64 = 1200;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged.toml");
    let texts = SCENES.map(|name| text_of(&format!("scenes/{name}.toml")));
    let (mut n_errors, mut n_objects) = (0, 0);
    for seed in 0..N {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut bytes = texts[rng.random_range(0..texts.len())].clone().into_bytes();
        for _ in 0..rng.random_range(1..=2) {
            if let Ok(text) = std::str::from_utf8(&bytes)
                && !text.is_empty()
                && text.contains('=')
            {
                bytes = mutate(&mut rng, text);
            }
        }
        let shown = String::from_utf8_lossy(&bytes);
        std::fs::write(&path, &bytes).unwrap();
        let result = std::panic::catch_unwind(|| read_scene(&path))
            .unwrap_or_else(|_| panic!("seed {seed}: panic on\n{shown}"));
        match result {
            Ok(scene) => {
                let finite = scene
                    .spheres
                    .iter()
                    .all(|s| s.radius > 0.0 && s.radius.is_finite() && s.center.is_finite())
                    && scene.planes.iter().all(|p| p.normal.length() > 0.0);
                assert!(finite, "seed {seed}: {scene:?}\nfrom\n{shown}");
                n_objects += scene.n_objects();
            }
            Err(Error::Scene(error)) => {
                n_errors += 1;
                let shows_place = error.text.get(error.span.clone()).is_some()
                    && error.line >= 1
                    && error.line <= error.text.matches('\n').count() + 1
                    && error.column >= 1;
                let says = !error.message.is_empty() && !error.help.is_empty();
                assert!(shows_place && says, "seed {seed}: {error:?}\nfrom\n{shown}");
            }
            Err(other) => panic!("seed {seed}: {other:?}\nfrom\n{shown}"),
        }
    }
    // Some damage is harmless (a changed comment or name), most is not.
    assert!(n_errors > N / 2 && n_errors < N, "{n_errors} of {N}");
    assert!(n_objects > 100, "{n_objects} objects were looked at");
}
