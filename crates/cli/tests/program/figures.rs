//! The lecture's figures 3 and 4 as drawings, and the guide's chapters on the lecture.

use std::fs;
use std::path::Path;

use glam::{DVec2, DVec3};
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::num::V3;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Scene, parse_scene};
use kugelblitz::trace::Kernel;
use kugelblitz_judge::explain::Lang;
use kugelblitz_judge::figure::Figure;
use kugelblitz_tests::{root, text_of};
use roxmltree::{Document, Node};

use crate::calculator;
use crate::program::{finish, program, run, scene_file};

fn parse(text: &str) -> Scene {
    parse_scene(text, Path::new("figure.toml")).unwrap()
}

fn pixels(scene: &Scene, width: u32, height: u32) -> Pixels {
    Pixels::whole(View::new(scene.camera.as_ref().unwrap()), width, height)
}

fn drawn(figure: Figure, scene: &Scene, pixels: &Pixels, lang: Lang) -> String {
    figure.draw(scene, figure.object(scene).unwrap(), pixels, lang).unwrap()
}

fn of_class<'a>(svg: &'a Document, class: &str) -> Vec<Node<'a, 'a>> {
    let has = |node: &Node| {
        node.attribute("class").is_some_and(|all| all.split(' ').any(|one| one == class))
    };
    svg.descendants().filter(has).collect()
}

/// The corners of a path.
fn corners(path: Node) -> Vec<DVec2> {
    let d = path.attribute("d").unwrap().trim_end_matches('Z');
    let corners = d.split(['M', 'L']).skip(1).map(|at| {
        let (x, y) = at.split_once(' ').unwrap();
        DVec2::new(x.parse().unwrap(), y.parse().unwrap())
    });
    corners.collect()
}

fn is_inside(corners: &[DVec2], at: DVec2) -> bool {
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    let crossed = edges.filter(|(a, b)| {
        (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossed.count() % 2 == 1
}

fn distance(corners: &[DVec2], at: DVec2) -> f64 {
    let edges = corners.iter().zip(corners.iter().cycle().skip(1));
    let to_edge = |(&a, &b): (&DVec2, &DVec2)| {
        let along = b - a;
        let s = (at - a).dot(along) / along.length_squared().max(f64::MIN_POSITIVE);
        (a + along * s.clamp(0.0, 1.0) - at).length()
    };
    edges.map(to_edge).fold(f64::INFINITY, f64::min)
}

/// Pixels of a rendered ball that are not those inside of a drawn outline; one on it may be either.
fn wrong_pixels(scene: &Scene, outline: &[DVec2], width: u32, height: u32) -> usize {
    let mut session = Session::new(scene.clone(), Device::Cpu, Kernel::Certified);
    let picture = session.render(width, height).unwrap();
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let wrong = pixels.zip(&picture.hits.id).filter(|((x, y), id)| {
        let at = DVec2::new(f64::from(*x) + 0.5, f64::from(*y) + 0.5);
        is_inside(outline, at) != (**id == 1) && distance(outline, at) > 0.05
    });
    wrong.count()
}

#[test]
fn the_sphere_drawn_is_the_sphere_rendered() {
    let (width, height) = (320, 180);
    let cameras = [
        ("on the axis", "position = [4.5, 3, 7.5], look_at = [0.25, 0, 0], fov = 36"),
        ("an ellipse", "position = [2, 1, 4], look_at = [-2, 0.5, 0], fov = 80"),
        ("orthographic", "position = [2, 3, 4], look_at = [0.5, 0, 0], height = 5"),
    ];
    for (what, camera) in cameras {
        let ball = |radius: f64| {
            parse(&format!(
                "camera = {{ {camera} }}\n[[sphere]]\ncenter = [0.25, 0, 0]\nradius = {radius}\n\
                 color = \"#ffffff\""
            ))
        };
        let scene = ball(1.5);
        let svg = drawn(Figure::Sphere, &scene, &pixels(&scene, width, height), Lang::English);
        let svg = Document::parse(&svg).unwrap();
        let outline = corners(of_class(&svg, "filled")[0]);
        assert_eq!(wrong_pixels(&scene, &outline, width, height), 0, "{what}");
        // The comparison sees another sphere.
        assert!(wrong_pixels(&ball(1.53), &outline, width, height) > 20, "{what}");
        let (low, high) = outline
            .iter()
            .fold((outline[0], outline[0]), |(low, high), at| (low.min(*at), high.max(*at)));
        let is_circle = ((high - low).x - (high - low).y).abs() < 0.5;
        assert_eq!(is_circle, what != "an ellipse", "{what}: {low}, {high}");
    }
}

#[test]
fn points_are_where_the_camera_sees_them() {
    for (figure, points) in [
        (Figure::Plane, vec![DVec3::new(1.0, -0.5, 0.0)]),
        (Figure::Sphere, vec![DVec3::ZERO, DVec3::new(0.5, 1.0, 1.0)]),
    ] {
        let scene = parse(figure.scene().1);
        let pixels = pixels(&scene, 1280, 720);
        let svg = drawn(figure, &scene, &pixels, Lang::English);
        let svg = Document::parse(&svg).unwrap();
        let dots = svg.descendants().filter(|node| node.has_tag_name("circle"));
        let dots: Vec<DVec2> = dots
            .map(|dot| ["cx", "cy"].map(|key| dot.attribute(key).unwrap().parse().unwrap()).into())
            .collect();
        for point in points {
            let near = |at: &&DVec2| (pixels.seen_at(point).unwrap() - **at).length() < 0.01;
            let at = dots.iter().find(near).unwrap_or_else(|| panic!("{point} of {dots:?}"));
            // The ray of the pixel that it is in passes by it, at most a pixel's diagonal away.
            let ray = pixels.ray(at.x as u32, at.y as u32);
            let from_eye = point - ray.origin;
            let off = from_eye - ray.direction * from_eye.dot(pixels.view.forward);
            let a_pixel = 2.0 * pixels.view.h / 720.0 * from_eye.dot(pixels.view.forward);
            assert!(off.length() < a_pixel, "{point}: {off}");
        }
    }
}

/// The words of a figure, each label whole.
fn labels(svg: &Document) -> Vec<String> {
    let texts = svg.descendants().filter(|node| node.has_tag_name("text"));
    let whole = |node: Node| -> String {
        node.descendants().filter(Node::is_text).filter_map(|part| part.text()).collect()
    };
    texts.map(whole).collect()
}

#[test]
fn figures_have_their_words_and_all_is_in_the_picture() {
    for (figure, words) in [
        (Figure::Plane, &["a = (1, −0.5, 0)", "n = (0.25, 1, 0)", "p", "p − a", "x", "y", "z"][..]),
        (
            Figure::Sphere,
            &["c = (0, 0, 0)", "r = 1.5", "p = (0.5, 1, 1)", "x", "y", "z", "1.5"][..],
        ),
    ] {
        let scene = parse(figure.scene().1);
        for (width, height) in [(1280, 720), (640, 480), (300, 500)] {
            for (lang, name) in [(Lang::English, "Figure"), (Lang::German, "Abbildung")] {
                let text = drawn(figure, &scene, &pixels(&scene, width, height), lang);
                assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
                let svg = Document::parse(&text).unwrap();
                let caption = format!("{name} {}: ", figure.number());
                let title = svg.descendants().find(|node| node.has_tag_name("title")).unwrap();
                assert!(title.text().unwrap().starts_with(&caption), "{text}");
                let found = labels(&svg);
                for word in words {
                    // The ends of axes may lie beyond a narrow picture.
                    let may_lack = width < height && word.len() == 1;
                    assert!(
                        may_lack || found.iter().any(|label| label == word),
                        "{word}: {found:?}"
                    );
                }
                for node in svg.descendants().filter(|node| node.has_tag_name("text")) {
                    let [x, y, size] = ["x", "y", "font-size"]
                        .map(|key| node.attribute(key).unwrap().parse::<f64>().unwrap());
                    assert!(x >= -0.1 && y - size > -size, "{node:?}");
                    assert!(x < f64::from(width) && y <= f64::from(height), "{node:?}");
                }
                assert!(of_class(&svg, "hidden").len() >= 2, "{text}");
                assert!(text.contains("prefers-color-scheme:dark"));
            }
        }
    }
}

/// Letters and lines stand out from a white and from a dark page, as WCAG asks: 4.5 for text.
#[test]
fn colours_suit_light_and_dark_pages() {
    let scene = parse(Figure::Plane.scene().1);
    let svg = drawn(Figure::Plane, &scene, &pixels(&scene, 1280, 720), Lang::English);
    let luminance = |hex: &str| {
        let color = kugelblitz::scene::Color::from_hex(hex).unwrap().0;
        0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]
    };
    let contrast = |a: f64, b: f64| (a.max(b) + 0.05) / (a.min(b) + 0.05);
    let (light, dark) = svg.split_once("@media screen").unwrap();
    for (rules, page) in [(light, "#ffffff"), (dark, "#15181d")] {
        let colors: Vec<&str> =
            rules.split("{color:").skip(1).filter_map(|rest| rest.split('}').next()).collect();
        assert_eq!(colors.len(), 5, "{rules}");
        for color in colors {
            let found = contrast(luminance(color), luminance(page));
            assert!(found > 4.5, "{color} on {page}: {found:.2}");
        }
    }
    assert!(contrast(luminance("#e6c34d"), luminance("#ffffff")) < 4.5, "the comparison fails");
}

/// What a ball hides of an axis is dashed, and nothing else is: the axes leave it at 1.5.
#[test]
fn what_is_hidden_is_dashed() {
    let scene = parse(Figure::Sphere.scene().1);
    let pixels = pixels(&scene, 1280, 720);
    let svg = drawn(Figure::Sphere, &scene, &pixels, Lang::English);
    let svg = Document::parse(&svg).unwrap();
    let near = |a: DVec2, b: DVec2| (a - b).length() < 12.0;
    let strokes = |is_hidden: bool| -> Vec<Vec<DVec2>> {
        let ink = of_class(&svg, "ink").into_iter().filter(|node| node.has_tag_name("path"));
        let classes = ink.filter(|node| {
            let class = node.attribute("class").unwrap();
            class.contains("hidden") == is_hidden
                && !class.contains("thin")
                && !class.contains("head")
        });
        classes.map(corners).collect()
    };
    for axis in DVec3::AXES {
        let leaves = pixels.seen_at(axis * 1.5).unwrap();
        let end = pixels.seen_at(axis * 2.0).unwrap();
        let before = strokes(true).iter().any(|line| near(*line.last().unwrap(), leaves));
        let beyond = strokes(false)
            .iter()
            .any(|line| near(line[0], leaves) && near(*line.last().unwrap(), end));
        assert!(before && beyond, "{axis}");
    }
}

#[test]
fn the_program_draws() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
    let out = at("figure3.svg");
    let ran = run(&["figure", "3", "-o", &out], 0);
    assert_eq!(ran.stdout, b"");
    assert!(ran.stderr.contains("figure 3 of figure3.toml"), "{}", ran.stderr);
    let of_file = fs::read_to_string(&out).unwrap();
    assert_eq!(run(&["figure", "3", &scene_file("figure3"), "-q"], 0).text(), of_file);
    let json = run(&["figure", "4", "--lang", "de", "--json", "-o", &out], 0).json();
    assert_eq!(
        (&json["figure"], &json["object"], &json["lang"]),
        (&"4".into(), &1.into(), &"de".into())
    );
    assert_eq!(json["size"], serde_json::json!([1280, 720]));
    assert!(fs::read_to_string(&out).unwrap().contains("Abbildung 4"));
    let small =
        run(&["figure", "4", &scene_file("figure1"), "--object", "3", "--size", "64x36"], 0);
    assert!(small.text().contains("viewBox=\"0 0 64 36\""), "{}", small.text());
    assert!(small.text().contains("(3.1, 1.25, −1)"), "{}", small.text());
}

#[test]
fn what_can_not_be_drawn_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let ball = "[[sphere]]\ncenter = [0, 0, 0]\nradius = 2\ncolor = \"#fff000\"\n";
    let floor = "[[plane]]\npoint = [0, 0, 9]\nnormal = [0, 1, 0]\ncolor = \"#fff000\"\n";
    let camera = |z: f64| format!("camera = {{ position = [0, 0, {z}], look_at = [0, 0, -9] }}\n");
    let inside = write("inside.toml", &format!("{}{ball}", camera(1.0)));
    let behind = write("behind.toml", &format!("{}{ball}", camera(-3.0)));
    let floor_behind = write("floor.toml", &format!("{}{floor}", camera(1.0)));
    let without_camera = write("eyeless.toml", ball);
    let svg = folder.path().join("out.svg").to_str().unwrap().to_owned();
    let over = write("over.svg", &format!("{}{ball}", camera(9.0)));
    let cases: [(&[&str], i32, &str); 5] = [
        (&["4", &inside], 2, "figure 4 shows sphere 1 from outside"),
        (&["4", &behind], 2, "move the scene's camera"),
        (&["3", &floor_behind], 2, "figure 3 shows plane 1"),
        (&["4", &without_camera], 3, "camera"),
        (&["4", &over, "-o", &over], 2, "this is the input"),
    ];
    for (args, code, says) in cases {
        let args = [&["figure"], args].concat();
        let args = if args.contains(&"-o") { args } else { [&args[..], &["-o", &svg]].concat() };
        let ran = finish(program(&args));
        assert_eq!(ran.code, code, "{args:?}\n{}", ran.stderr);
        assert!(ran.stderr.contains(says), "{args:?}\n{}", ran.stderr);
        assert!(!Path::new(&svg).exists(), "{args:?}");
    }
}

fn chapters() -> [String; 2] {
    ["lecture", "lecture-de"].map(|name| text_of(&format!("docs/guide/src/{name}.md")))
}

/// The cells of the table whose head begins with one of these.
fn table<'a>(chapter: &'a str, heads: [&str; 2]) -> Vec<Vec<&'a str>> {
    let is_head = |line: &&str| heads.iter().any(|head| line.starts_with(&format!("| {head} |")));
    let rows: Vec<_> = chapter
        .lines()
        .skip_while(|line| !is_head(line))
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .map(|line| line.trim_matches('|').split(" | ").map(str::trim).collect())
        .collect();
    assert!(rows.len() > 4, "{heads:?}");
    rows
}

#[test]
fn formulas_of_the_chapters_lead_somewhere() {
    let root = root();
    let chapters = chapters();
    let tables = chapters
        .each_ref()
        .map(|chapter| table(chapter, ["section | formula", "Abschnitt | Formel"]));
    for rows in &tables {
        for row in rows {
            let code = |cell: &str| cell.trim_matches(['`', '|', ' ']).to_owned();
            let function = code(row[2]);
            let files: Vec<_> = row[3..].iter().map(|cell| code(cell)).collect();
            let files: Vec<_> = files.iter().filter(|file| !file.is_empty()).collect();
            assert!(!files.is_empty(), "{function} is nowhere");
            for file in files {
                let text = fs::read_to_string(root.join(file)).expect(file);
                let defined = ["(", "<"].map(|after| format!("fn {function}{after}"));
                assert!(defined.iter().any(|fn_| text.contains(fn_)), "{function} in {file}");
            }
        }
    }
    let same = |rows: &[Vec<&str>]| -> Vec<String> {
        rows.iter().map(|row| [&row[..1], &row[2..]].concat().join(" ")).collect()
    };
    assert_eq!(same(&tables[0]), same(&tables[1]));
}

#[test]
fn the_chapters_have_the_same_slips() {
    let chapters = chapters();
    let [english, german] = chapters
        .each_ref()
        .map(|chapter| table(chapter, ["section | the text", "Abschnitt | der Text"]));
    let sections =
        |rows: &[Vec<&str>]| -> Vec<String> { rows.iter().map(|row| row[0].to_owned()).collect() };
    assert_eq!(sections(&english), sections(&german));
    assert!(english.len() >= 20 && english.iter().chain(&german).all(|row| row.len() == 3));
    // What is quoted is in the lecture's own words in both.
    for (english, german) in english.iter().zip(&german) {
        let quoted = |text: &str, ends: [char; 2]| {
            let rest = text.split_once(ends[0])?.1;
            Some(rest.split_once(ends[1])?.0.to_owned())
        };
        let words = quoted(english[1], ['"', '"']);
        assert_eq!(words, quoted(german[1], ['„', '“']), "{english:?}");
    }
}

/// Whether all sides of an equation are equal; those of a `≠` must differ.
fn holds(equation: &str) -> bool {
    let value = |side: &str| calculator::value(side).unwrap_or_else(|| panic!("{side}"));
    let sides: Vec<_> = equation
        .split(" ≠ ")
        .map(|side| side.split(" = ").map(value).collect::<Vec<_>>())
        .collect();
    let equal = sides.iter().all(|side| side.iter().all(|one| *one == side[0]));
    equal && sides.windows(2).all(|pair| pair[0][0] != pair[1][0])
}

#[test]
fn the_laws_of_the_scalar_product_hold() {
    let chapters = chapters();
    let tables = chapters.each_ref().map(|chapter| table(chapter, ["law", "Gesetz"]));
    for row in tables.iter().flatten() {
        assert!(holds(row[2]), "{row:?}");
    }
    assert_eq!(tables[0].len(), 5);
    assert!(!holds("(1, 2, 3) • (4, −5, 6) = 13"), "a wrong number is seen");
    assert!(!holds("2·(1, 2, 3) ≠ (2, 4, 6)"), "and a wrong ≠");

    // With the program's own function: exact in whole numbers, and the law that f32 breaks.
    let v = |x, y, z| V3([x, y, z]);
    let (a, b, c) = (v(1.0, 2.0, 3.0), v(4.0, -5.0, 6.0), v(7.0, 8.0, -9.0));
    assert_eq!([a.dot(b), b.dot(a), b.dot(c), a.dot(c)], [12.0, 12.0, -66.0, -4.0]);
    assert_eq!(a.dot(b + c), a.dot(b) + a.dot(c));
    let (a, b, c): (_, V3<f32>, _) = (v(1.0, 1.0, 1.0), v(1e8, 1.0, 0.0), v(-1e8, 0.0, 0.0));
    assert_eq!((a.dot(b + c), a.dot(b) + a.dot(c)), (1.0, 0.0));
}

#[test]
fn the_chapters_show_what_the_program_says() {
    for (chapter, lang) in chapters().iter().zip(["en", "de"]) {
        let shown = chapter.split("```text\n").nth(1).unwrap().split("```").next().unwrap();
        let scene = scene_file("figure5");
        let args = ["explain", &scene, "--pixel", "640,360", "--device", "cpu", "--lang", lang];
        let ran = run(&args, 0);
        assert!(ran.text().contains(shown), "{shown}\n{}", ran.text());
    }
}

#[test]
fn the_guides_figures_are_those_that_are_drawn() {
    let images = root().join("docs/guide/src/images");
    for (number, lang, name) in [
        ("3", "en", "figure3.svg"),
        ("4", "en", "figure4.svg"),
        ("3", "de", "figure3-de.svg"),
        ("4", "de", "figure4-de.svg"),
    ] {
        let drawn = run(&["figure", number, "--lang", lang, "-q"], 0);
        let kept = fs::read_to_string(images.join(name)).unwrap();
        let command = format!("kugelblitz figure {number} --lang {lang} -o {name}");
        assert!(drawn.text() == kept, "{name} is out of date; run: {command}");
    }
}
