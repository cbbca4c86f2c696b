//! The lecture's figures 2 to 5 as drawings. Whole ones stand in `tests/answers/figures.txt`.

use std::path::Path;

use glam::DVec2;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::exact::{ExactPixels, nearest};
use kugelblitz::query::Kernel;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{SHIPPED_SCENES, Scene, parse_scene};
use kugelblitz_judge::explain::Lang;
use kugelblitz_judge::figure::Figure;
use roxmltree::{Document, Node};

fn parse(text: &str) -> Scene {
    parse_scene(text, Path::new("figure.toml")).unwrap()
}

fn pixels(scene: &Scene, width: u32, height: u32) -> Pixels {
    Pixels::whole(View::new(scene.camera.as_ref().unwrap()), width, height)
}

fn drawn(figure: Figure, scene: &Scene, pixels: &Pixels, lang: Lang) -> String {
    figure.draw(scene, None, pixels, lang).unwrap()
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

/// How many pixels of a plan are a unit of `t`: by each ray of figure 2 that sees something, of which exact arithmetic says what.
fn units_of_t(scene: &Scene, svg: &str) -> Vec<f64> {
    let svg = Document::parse(svg).unwrap();
    let x = |dot: &Node| dot.attribute("cx").unwrap().parse::<f64>().unwrap();
    let eye =
        x(&of_class(&svg, "ink").into_iter().find(|node| node.has_tag_name("circle")).unwrap());
    let dots = of_class(&svg, "found");
    let pixels = pixels(scene, 1280, 720);
    let rays = ExactPixels::new(&pixels);
    let hit = |x| nearest(&rays.ray(x, 360), scene.objects());
    let hits = [0, 255, 511, 767, 1023, 1279].into_iter().filter_map(hit);
    let ts: Vec<f64> = hits.map(|hit| hit.t_f64()).collect();
    assert_eq!(dots.len(), ts.len());
    dots.iter().zip(ts).map(|(dot, t)| (x(dot) - eye) / t).collect()
}

#[test]
fn the_points_of_a_plan_are_those_that_rays_see() {
    let spread = |units: Vec<f64>| {
        let (least, most) = units
            .iter()
            .fold((f64::INFINITY, 0.0_f64), |(low, high), unit| (low.min(*unit), high.max(*unit)));
        (most - least) / most
    };
    for (name, radius, other) in [
        ("figure1.toml", "radius = 1.0", "radius = 0.8"),
        ("figure2.toml", "radius = 0.9", "radius = 0.8"),
    ] {
        let (_, text) = SHIPPED_SCENES.iter().find(|(path, _)| *path == name).unwrap();
        let scene = parse(text);
        let svg = drawn(Figure::Rays, &scene, &pixels(&scene, 1280, 720), Lang::English);
        // The plan's own camera has short numbers.
        let units = units_of_t(&scene, &svg);
        assert!(spread(units.clone()) < 1e-3, "{name}: {units:?}");
        // The comparison sees another sphere.
        assert!(spread(units_of_t(&parse(&text.replace(radius, other)), &svg)) > 0.01, "{name}");
    }
}

#[test]
fn discriminants_have_their_exact_signs() {
    let (_, text) = SHIPPED_SCENES.iter().find(|(path, _)| *path == "figure5.toml").unwrap();
    let said = |text: &str| {
        let scene = parse(text);
        let svg = drawn(Figure::Discriminant, &scene, &pixels(&scene, 1281, 721), Lang::German);
        let svg = Document::parse(&svg).unwrap();
        let texts = svg.descendants().filter(|node| node.has_tag_name("text"));
        let written = |node: Node| {
            node.descendants()
                .filter_map(|part| part.text().filter(|_| part.is_text()))
                .collect::<String>()
        };
        texts.map(written).collect::<Vec<_>>()
    };
    let all = said(text);
    for expected in
        ["t = 0", "1: D = −108 < 0", "2: D = 0", "3: D = 64 > 0", "t = 24", "t = 36", "t = 44"]
    {
        assert!(all.iter().any(|text| text == expected), "{expected}: {all:?}");
    }
    // Farther by a step of f64, where f64 has D = 0 as well.
    let farther = said(&text.replace("[3.0, 4.0, -24.0]", "[3.0000000000000004, 4.0, -24.0]"));
    let second = farther.iter().find(|text| text.starts_with("2:")).unwrap();
    assert!(second.ends_with("e−14 < 0") && !farther.contains(&"t = 24".into()), "{farther:?}");
}
