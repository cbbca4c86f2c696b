//! A renderer in f64 with one planted mistake at a time: each is found, and named.

use glam::DVec3;
use kugelblitz::Control;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::picture::{Channel, ChannelValues, Image};
use kugelblitz::query::Kernel;
use kugelblitz::rays::{Pixels, Rays, View};
use kugelblitz::scene::{Object, Scene, parse_scene};

use super::*;

/// Larger than the sample of the search, 4096.
const SIZE: [u32; 2] = [96, 54];

/// Allowed of results in f64 that are stored as such.
const ALLOWED: &str = "ids=0,silhouettes=0.5%,t=1e-9,normal=1e-6";

/// The result of a pixel.
#[derive(Clone, Copy)]
struct Seen {
    id: i64,
    t: f64,
    normal: DVec3,
    /// The object's radius; 1 for planes and the background.
    radius: f64,
    /// Length of the ray's direction.
    length: f64,
}

/// A renderer: its camera, and how it meets a sphere.
#[derive(Clone, Copy, Default)]
struct Renderer {
    offset: [f64; 2],
    has_horizontal_fov: bool,
    n_more_rows: f64,
    has_far_roots: bool,
    has_far_normals: bool,
    /// An object, and by how much its centre is wrong.
    moved: Option<(i64, f64)>,
}

impl Renderer {
    fn draw(self, scene: &Scene) -> Vec<Seen> {
        let View { position, forward, right, true_up, h, .. } = view(scene);
        let [width, height] = SIZE.map(f64::from);
        let pixel = |i: u32| {
            let x = f64::from(i % SIZE[0]) + 0.5 + self.offset[0];
            let y = f64::from(i / SIZE[0]) + 0.5 + self.offset[1];
            let [half_width, half_height] = match self.has_horizontal_fov {
                true => [h, h * height / width],
                false => [h * width / (height + self.n_more_rows), h],
            };
            let across = (2.0 * x / width - 1.0) * half_width;
            let up = (1.0 - 2.0 * y / height) * half_height;
            self.trace(scene, position, forward + across * right + up * true_up)
        };
        (0..SIZE[0] * SIZE[1]).map(pixel).collect()
    }

    fn trace(self, scene: &Scene, o: DVec3, d: DVec3) -> Seen {
        let length = d.length();
        let mut seen = Seen { id: 0, t: f64::INFINITY, normal: DVec3::ZERO, radius: 1.0, length };
        for (id, object) in scene.objects() {
            let id = i64::from(id);
            let (t, normal, radius) = match object {
                Object::Plane(plane) => {
                    let t = (plane.point - o).dot(plane.normal) / d.dot(plane.normal);
                    (t, plane.normal.normalize(), 1.0)
                }
                Object::Sphere(sphere) => {
                    let moved = self.moved.map_or(0.0, |(of, by)| if of == id { by } else { 0.0 });
                    let l = sphere.center + moved - o;
                    let (a, b) = (d.dot(d), d.dot(l));
                    let root = (b * b - a * (l.dot(l) - sphere.radius.powi(2))).sqrt();
                    let [near, far] = [(b - root) / a, (b + root) / a];
                    let t = if near <= 0.0 || self.has_far_roots { far } else { near };
                    let at = if self.has_far_normals { far } else { t };
                    (t, (d * at - l) / sphere.radius, sphere.radius)
                }
            };
            if t > 0.0 && t < seen.t {
                seen = Seen { id, t, normal, radius, length };
            }
        }
        // Towards the eye, but for mistakes.
        if seen.normal.dot(d) > 0.0 && !self.has_far_roots && !self.has_far_normals {
            seen.normal = -seen.normal;
        }
        seen
    }
}

fn view(scene: &Scene) -> View {
    View::new(scene.camera.as_ref().expect("a camera"))
}

fn image(pixels: &[Seen], depth_name: &str) -> Image {
    let channel = |name: &str, samples| Channel { name: name.into(), samples };
    let numbers = |of: fn(&Seen) -> f64| ChannelValues::F64(pixels.iter().map(of).collect());
    Image {
        format: "NPY",
        width: SIZE[0] as usize,
        height: SIZE[1] as usize,
        whole: SIZE.map(|n| n as usize),
        channels: vec![
            channel("id", ChannelValues::I64(pixels.iter().map(|seen| seen.id).collect())),
            channel(depth_name, numbers(|seen| seen.t)),
            channel("N.X", numbers(|seen| seen.normal.x)),
            channel("N.Y", numbers(|seen| seen.normal.y)),
            channel("N.Z", numbers(|seen| seen.normal.z)),
        ],
        ..Image::default()
    }
}

fn compared(scene: &Scene, image: Image, transforms: &str) -> HitDifference {
    let pixels = Pixels::whole(view(scene), SIZE[0], SIZE[1]);
    let transforms = transforms.split(',').filter(|name| !name.is_empty());
    let comparison = HitComparison {
        scene: scene.clone().into(),
        rays: Rays::Pixels(pixels),
        quantities: quantities_of(&image, None).unwrap(),
        image,
        channel: None,
        transforms: transforms.map(|name| name.parse().unwrap()).collect(),
        allowed: ALLOWED.parse().unwrap(),
    };
    let mut session = Session::new(scene.clone(), Device::Cpu, Kernel::Certified);
    comparison.run(&mut session, &Control::default()).unwrap()
}

fn scene(name: &str) -> Scene {
    let text = match name {
        "figure1" => include_str!("../../../../scenes/figure1.toml"),
        _ => include_str!("../../../../scenes/inside.toml"),
    };
    parse_scene(text, name.as_ref()).unwrap()
}

/// The background is seen beside the first scene's back wall.
fn open_scene() -> Scene {
    let mut scene = scene("figure1");
    scene.planes.pop();
    scene
}

type Mistake = (&'static str, fn(&mut Vec<Seen>));

const MISTAKES: [Mistake; 22] = [
    ("flip-rows", |all| *all = rows(all).into_iter().rev().flatten().collect()),
    ("flip-columns", |all| {
        *all = rows(all).into_iter().flat_map(|row| row.into_iter().rev()).collect();
    }),
    ("ids+1", |all| all.iter_mut().for_each(|seen| seen.id -= 1)),
    ("ids-1", |all| all.iter_mut().for_each(|seen| seen.id += i64::from(seen.id > 0))),
    ("no-hit=255", |all| {
        all.iter_mut().filter(|seen| seen.id == 0).for_each(|seen| seen.id = 255);
    }),
    ("permute-ids", |all| {
        all.iter_mut().for_each(|seen| seen.id = [0, 40, 10, 7, 3, 9, 2, 100, 1][seen.id as usize]);
    }),
    ("distance", |all| all.iter_mut().for_each(|seen| seen.t *= seen.length)),
    ("background=1000", |all| {
        all.iter_mut().filter(|seen| seen.id == 0).for_each(|seen| (seen.t, seen.id) = (1e3, 0));
    }),
    ("scale=0.001", |all| all.iter_mut().for_each(|seen| seen.t *= 1e3)),
    ("zbuffer=0.5:200", |all| all.iter_mut().for_each(|seen| seen.t = z(seen.t, 0.5, 200.0))),
    ("zbuffer=200:0.5", |all| all.iter_mut().for_each(|seen| seen.t = z(seen.t, 200.0, 0.5))),
    ("zbuffer=0.5:inf", |all| {
        all.iter_mut().for_each(|seen| seen.t = z(seen.t, 0.5, f64::INFINITY));
    }),
    ("negate-normals", |all| all.iter_mut().for_each(|seen| seen.normal *= -1.0)),
    ("inward-normals", |all| {
        all.iter_mut()
            .filter(|seen| (1..=6).contains(&seen.id))
            .for_each(|seen| seen.normal *= -1.0);
    }),
    ("unsigned-normals", |all| {
        all.iter_mut().step_by(3).for_each(|seen| seen.normal *= -1.0);
    }),
    ("normalize-normals", |all| all.iter_mut().for_each(|seen| seen.normal *= 1.5 * seen.radius)),
    ("camera-normals", |all| {
        let View { right, true_up, forward, .. } = view(&scene("figure1"));
        let axes = |n: DVec3| DVec3::new(n.dot(right), n.dot(true_up), -n.dot(forward));
        all.iter_mut().for_each(|seen| seen.normal = axes(seen.normal));
    }),
    // Two at once.
    ("flip-rows,ids-1", |all| {
        *all = rows(all).into_iter().rev().flatten().collect();
        all.iter_mut().for_each(|seen| seen.id += i64::from(seen.id > 0));
    }),
    ("distance,negate-normals", |all| {
        all.iter_mut()
            .for_each(|seen| (seen.t, seen.normal) = (seen.t * seen.length, -seen.normal));
    }),
    ("ids+1,scale=100", |all| {
        all.iter_mut().for_each(|seen| (seen.id, seen.t) = (seen.id - 1, seen.t * 0.01));
    }),
    ("flip-rows,camera-normals", |all| {
        let View { right, true_up, forward, .. } = view(&scene("figure1"));
        let axes = |n: DVec3| DVec3::new(n.dot(right), n.dot(true_up), -n.dot(forward));
        all.iter_mut().for_each(|seen| seen.normal = axes(seen.normal));
        *all = rows(all).into_iter().rev().flatten().collect();
    }),
    ("flip-rows,flip-columns", |all| all.reverse()),
];

fn rows(all: &[Seen]) -> Vec<Vec<Seen>> {
    all.chunks(SIZE[0] as usize).map(<[Seen]>::to_vec).collect()
}

fn z(t: f64, near: f64, far: f64) -> f64 {
    (1.0 / near - 1.0 / t) / (1.0 / near - 1.0 / far)
}

/// The mistake is found, named, and gone with the transform that was named.
fn check(scene: &Scene, image: &Image, name: &str) {
    let before = compared(scene, image.clone(), "");
    assert!(!before.broken.is_empty(), "{name} passes as right");
    let explained = before.explained.unwrap_or_else(|| panic!("{name} is not named"));
    assert_eq!(explained.transforms, name);
    assert!(explained.agree > 0.98, "{name}: {explained}");
    let after = compared(scene, image.clone(), name);
    let Allowed { .. } = after.comparison.allowed;
    // Numbers from the data have few digits, and rays of another camera are rounded to f64.
    assert!(after.errors.classes[0].wrong_ids == 0, "{name}: {:?}", after.broken);
    let worst = after.errors.classes[0].t_relative.map_or(0.0, |spread| spread.worst);
    assert!(worst < 1e-6, "{name}: {worst:e}");
}

#[test]
fn other_conventions_are_named() {
    let scene = open_scene();
    let right = Renderer::default().draw(&scene);
    let without = compared(&scene, image(&right, "t"), "");
    assert_eq!(without.broken, [""; 0]);
    for (name, mistake) in MISTAKES {
        let mut wrong = right.clone();
        mistake(&mut wrong);
        let mut image = image(&wrong, "t");
        if name.starts_with("background") {
            image.channels.retain(|channel| channel.name == "t");
        }
        check(&scene, &image, name);
    }
    check(&scene, &image(&right, "distance"), "depth");
}

#[test]
fn normals_that_point_out_of_a_sphere_around_the_eye_are_named() {
    let scene = scene("inside");
    let mut all = Renderer::default().draw(&scene);
    // The first sphere is around the eye.
    all.iter_mut().filter(|seen| seen.id == 1).for_each(|seen| seen.normal *= -1.0);
    check(&scene, &image(&all, "t"), "outward-normals");
}

#[test]
fn wrong_cameras_and_roots_are_named() {
    let scene = open_scene();
    let right = Renderer::default();
    let offset = |x, y| Renderer { offset: [x, y], ..right };
    for (name, renderer) in [
        ("pixel-offset=-0.5:-0.5", offset(-0.5, -0.5)),
        ("pixel-offset=0.5:0.5", offset(0.5, 0.5)),
        ("pixel-offset=0:0.5", offset(0.0, 0.5)),
        ("pixel-offset=-0.5:0", offset(-0.5, 0.0)),
        ("horizontal-fov", Renderer { has_horizontal_fov: true, ..right }),
        ("aspect-h+1", Renderer { n_more_rows: 1.0, ..right }),
        ("far-roots", Renderer { has_far_roots: true, ..right }),
        ("far-normals", Renderer { has_far_normals: true, ..right }),
    ] {
        check(&scene, &image(&renderer.draw(&scene), "t"), name);
    }
}

#[test]
fn the_only_wrong_object_is_named_and_no_transform() {
    let scene = open_scene();
    for (id, by) in [(3, 1e-3), (1, -0.05), (6, 1e-6)] {
        let wrong = Renderer { moved: Some((id, by)), ..Renderer::default() }.draw(&scene);
        let found = compared(&scene, image(&wrong, "t"), "");
        assert!(!found.broken.is_empty() && found.explained.is_none(), "{:?}", found.explained);
        let [first, ..] = &found.objects[..] else { panic!("no object") };
        assert_eq!((i64::from(first.id), first.share_of_wrong), (id, 1.0));
        let text = found.in_words(&[], str::to_string);
        assert!(text.contains("all wrong pixels are on object"), "{text}");
    }
}

#[test]
fn transforms_are_read_as_they_are_written() {
    for (name, _) in MISTAKES {
        for name in name.split(',') {
            assert_eq!(name.parse::<Transform>().unwrap().to_string(), name);
        }
    }
    for wrong in ["ids", "ids+x", "zbuffer=1", "zbuffer=2:2", "scale=0", "scale=x", "up", "no-hit="]
    {
        let error = wrong.parse::<Transform>().unwrap_err().to_string();
        assert!(error.contains(wrong), "{error}");
    }
}
