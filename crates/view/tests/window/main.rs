//! The window as its users meet it: the real one under Xvfb, driven by xdotool. What it shows is
//! compared with what `render` draws.

mod desk;

use std::fs;
use std::path::Path;
use std::process::Command;

use desk::{Desk, Image, Seen, camera_of, kugelblitz, log_gpu, render, render_show, scene};
use glam::DVec3;
use kugelblitz::gpu::list_adapters;
use kugelblitz::rays::View;

/// Size of most pictures here.
const SIZE: &str = "480x300";

/// What F2 and the keys behind it show.
const SHOWS: [&str; 6] = ["depth", "normal", "id", "discriminant", "error", "stage"];

/// The picture in the window is the one that `render` draws for the camera that P prints.
#[track_caller]
fn assert_as_rendered(seen: &mut Seen, scene: &Path, kernel: &str) -> Image {
    let camera = seen.camera();
    let [_, _, width, height] = seen.area();
    let expected = render(scene, &camera, [width, height], kernel);
    seen.wait_for_picture(&expected)
}

#[test]
fn the_window_shows_what_render_draws() {
    let desk = Desk::new();
    for (name, size) in [("figure1", "960x540"), ("figure5", SIZE), ("hard/huge_ground", SIZE)] {
        let scene = scene(name);
        let mut seen = Seen::open(&desk, &scene, &["--size", size]);
        log_gpu("the_window_shows_what_render_draws", &seen);
        let [left, _, width, height] = seen.area();
        assert_eq!((left, format!("{width}x{height}")), (0, size.into()));
        let mut kernel = "certified";
        // Those that the device can't run are passed over.
        let has_f64 = list_adapters()[0].f64;
        for next in ["lecture", "stable", "double", "certified"] {
            if next == "double" && !has_f64 {
                continue;
            }
            assert_as_rendered(&mut seen, &scene, kernel);
            seen.key("k");
            kernel = next;
            seen.wait(|event| event.is_settled() && event.kernels() == [kernel]);
        }
        seen.quit();
    }
}

#[test]
fn wayland_shows_the_same_picture() {
    let mut desk = Desk::with_wayland();
    let path = scene("figure1");
    let mut seen = Seen::open(&desk, &path, &[]);
    log_gpu("wayland_shows_the_same_picture", &seen);
    assert_eq!(seen.area()[2], 1400);
    // The compositor draws the pointer: on the bar it hides nothing of the picture.
    let bar = [5, 5];
    seen.point(bar);
    assert_as_rendered(&mut seen, &path, "certified");
    let [from, to] = [seen.at(240, 150), seen.at(340, 190)];
    seen.drag(from, to, 1, None);
    seen.point(bar);
    assert_as_rendered(&mut seen, &path, "certified");
    seen.quit();

    let mut seen = Seen::open(&desk, &path, &[]);
    desk.end();
    assert_eq!(seen.exit_code(), Some(1), "{}", seen.stderr());
    let last = seen.stderr().lines().last().map(str::to_owned);
    assert_eq!(last.as_deref(), Some("error: the display: the connection was lost"));
}

/// What each does to a camera in numbers, the tests of `rig.rs` ask.
#[test]
fn every_control_of_the_camera_works() {
    let desk = Desk::new();
    let path = scene("figure1");
    let mut seen = Seen::open(&desk, &path, &["--size", SIZE]);
    log_gpu("every_control_of_the_camera_works", &seen);
    let toml = seen.camera();
    assert_eq!(seen.clipboard(), toml);
    let home = camera_of(&toml);
    let view = View::new(&home);
    let [middle, aside] = [seen.at(240, 150), seen.at(340, 190)];
    // The eye's way since then: to the right, up and ahead.
    let way = |seen: &mut Seen| {
        let by = camera_of(&seen.camera()).position - home.position;
        DVec3::from([view.right, view.true_up, view.forward].map(|axis| by.dot(axis)))
    };

    // Dragged to the right and down, the eye goes to the left and up: about what it looks at, or straight.
    for (button, held, is_straight) in [(1, None, false), (2, None, true), (1, Some("shift"), true)]
    {
        seen.reset();
        seen.drag(middle, aside, button, held);
        assert_as_rendered(&mut seen, &path, "certified");
        let way = way(&mut seen);
        assert!(way.x < -0.1 && way.y > 0.1 && (way.z.abs() < 1e-9) == is_straight, "{way}");
    }

    // The wheel brings what is under the pointer nearer, by one or two steps, as the X server has it.
    seen.reset();
    let red = seen.at(150, 130);
    seen.point(red);
    let distance = |seen: &mut Seen, from: DVec3| camera_of(&seen.camera()).position.distance(from);
    let hovered = seen.hovers("(red)");
    let numbers = hovered.hover().unwrap().rsplit_once('(').unwrap().1.trim_end_matches(')');
    let numbers: Vec<f64> = numbers.split(", ").map(|n| n.parse().unwrap()).collect();
    let touched = DVec3::from_slice(&numbers);
    let before = home.position.distance(touched);
    seen.moves(|seen| seen.xdotool(&["click", "4"]));
    assert_as_rendered(&mut seen, &path, "certified");
    let nearer = distance(&mut seen, touched);
    assert!((0.7..0.95).contains(&(nearer / before)), "{nearer} of {before}");
    seen.moves(|seen| seen.xdotool(&["click", "5"]));
    assert!(distance(&mut seen, touched) > nearer);

    // A double click sets the pivot: orbiting then keeps the distance to that point.
    seen.reset();
    seen.point(middle);
    seen.hovers("(blue)");
    seen.point(red);
    seen.hovers("(red)");
    seen.at_once(|seen| seen.xdotool(&["click", "--repeat", "2", "--delay", "60", "1"]));
    seen.drag(middle, aside, 1, None);
    let change = distance(&mut seen, touched) - before;
    assert!(change.abs() < 1e-3 && way(&mut seen).length() > 0.5, "about {touched}: {change}");

    for (key, ahead) in [
        ("w", DVec3::Z),
        ("s", -DVec3::Z),
        ("d", DVec3::X),
        ("a", -DVec3::X),
        ("e", DVec3::Y),
        ("q", -DVec3::Y),
    ] {
        seen.reset();
        seen.moves(|seen| seen.key(key));
        let way = way(&mut seen);
        assert!(way.normalize().distance(ahead) < 1e-6, "{key}: {way}");
    }
    seen.reset();
    assert_eq!(camera_of(&seen.camera()), home);
    seen.moves(|seen| seen.key("f"));
    let direction = |seen: &mut Seen| View::new(&camera_of(&seen.camera())).forward;
    assert!(direction(&mut seen).distance(view.forward) < 1e-12);
    let [x, y, z] = DVec3::AXES;
    for (key, to_eye) in (1..).zip([x, y, z, -x, -y, -z]) {
        seen.moves(|seen| seen.key(&format!("{key}")));
        assert!(direction(&mut seen).distance(-to_eye) < 1e-12, "{key}");
    }
    assert_as_rendered(&mut seen, &path, "certified");
    seen.quit();
}

#[test]
fn nothing_is_lost_in_a_long_frame() {
    let desk = Desk::new();
    let path = scene("figure1");
    let mut seen = Seen::open(&desk, &path, &["--size", SIZE]);
    let home = camera_of(&seen.camera());
    let [middle, aside] = [seen.at(240, 150), seen.at(340, 190)];
    seen.at_once(|seen| seen.pull(middle, aside, 1, None));
    let turned = camera_of(&seen.camera());
    assert!(turned.position.x < home.position.x - 0.5, "{:?}", turned.position);
    assert!(turned.position.y > home.position.y + 0.5, "{:?}", turned.position);
    assert_as_rendered(&mut seen, &path, "certified");
    // Shift is free again when the frame comes.
    seen.reset();
    seen.at_once(|seen| seen.pull(middle, aside, 1, Some("shift")));
    let moved = camera_of(&seen.camera());
    let by = moved.position - home.position;
    assert!(by.length() > 0.1 && (moved.look_at - home.look_at - by).length() < 1e-9, "{by}");
    // Where the pointer is in the end, nobody has clicked.
    seen.at_once(|seen| {
        seen.point(middle);
        seen.xdotool(&["click", "1"]);
        seen.point(aside);
    });
    let explained = seen.wait(|event| event.name() == "explained");
    assert_eq!(explained.pixel(), [240, 150]);
    seen.quit();
}

/// Looks at the window until each pixel left of the divider is as in the first picture, and right of it as
/// in the second: all but the line itself and the names beside it.
#[track_caller]
fn wait_for_both(seen: &mut Seen, divider: u32, [left, right]: [&Image; 2]) {
    let part = |x: u32, y: u32| {
        if y > 250 || x.abs_diff(divider) < 4 {
            return None;
        }
        Some(if x < divider { left.at(x, y) } else { right.at(x, y) })
    };
    seen.wait_for(&format!("the divider at {divider}"), |image| {
        (0..300).all(|y| (0..480).all(|x| part(x, y).is_none_or(|c| c == image.at(x, y))))
    });
}

#[test]
fn two_kernels_stand_side_by_side() {
    let desk = Desk::new();
    let path = scene("hard/far_1e8");
    let mut seen = Seen::open(&desk, &path, &["--size", SIZE]);
    seen.key("c");
    seen.wait(|event| event.is_settled() && event.kernels() == ["lecture", "certified"]);
    let camera = seen.camera();
    let [lecture, certified] =
        ["lecture", "certified"].map(|kernel| render(&path, &camera, [480, 300], kernel));
    assert!(lecture != certified, "a scene that tells them apart");
    let mut divider = 240;
    for to in [240, 100, 390] {
        if to != divider {
            seen.at_once(|seen| seen.drag_divider(divider, to));
            divider = to;
        }
        wait_for_both(&mut seen, divider, [&lecture, &certified]);
    }
    // The left kernel is another one after shift + K.
    seen.key("shift+k");
    seen.wait(|event| event.is_settled() && event.kernels() == ["stable", "certified"]);
    seen.key("c");
    seen.wait(|event| event.is_settled() && event.kernels() == ["certified"]);
    assert_as_rendered(&mut seen, &path, "certified");
    seen.quit();
}

#[test]
fn numbers_are_seen_and_saved() {
    let desk = Desk::new();
    let (path, size) = (scene("hard/far_1e8"), [480, 300]);
    let mut seen = Seen::open(&desk, &path, &["--size", SIZE]);
    log_gpu("numbers_are_seen_and_saved", &seen);
    let camera = seen.camera();
    let save = |seen: &mut Seen| {
        seen.key("ctrl+s");
        let path = seen.wait(|event| event.name() == "saved").path().to_owned();
        (Image::open(&seen.folder().join(&path)), path)
    };
    // Where no legend lies upon it.
    let places = || (0..300).flat_map(|y| (0..480).map(move |x| (x, y)));
    let is_seen = |&(x, y): &(u32, u32)| x >= 420 || y < 90;
    for (i, show) in SHOWS.into_iter().enumerate() {
        seen.key(&format!("F{}", i + 2));
        let expected = render_show(&path, &camera, size, "certified", show);
        let is_plain =
            places().filter(is_seen).all(|(x, y)| expected.at(x, y) == expected.at(0, 0));
        assert!(!is_plain || show == "stage", "{show}");
        seen.wait_for(show, |image| {
            places().filter(is_seen).all(|(x, y)| image.at(x, y) == expected.at(x, y))
        });
        let (saved, name) = save(&mut seen);
        assert!(name.ends_with(&format!("far_1e8-{show}-1.png")), "{name}");
        assert!(saved == expected, "{show}");
    }
    // Two kernels: each half is its own picture's.
    seen.key("c");
    for (key, show) in [("F6", "error"), ("F1", "color")] {
        seen.key(key);
        seen.wait(|event| event.show() == show && event.is_settled() && event.kernels().len() == 2);
        let (saved, name) = save(&mut seen);
        assert!(name.contains("lecture-certified"), "{name}");
        let kernels = ["lecture", "certified"];
        let halves = kernels.map(|kernel| render_show(&path, &camera, size, kernel, show));
        assert!(halves[0] != halves[1], "{show} tells them apart");
        for (x, y) in places() {
            assert_eq!(saved.at(x, y), halves[usize::from(x >= 240)].at(x, y), "{show} {x} {y}");
        }
    }
    seen.key("c");
    seen.wait(|event| event.show() == "color" && event.is_settled() && event.kernels().len() == 1);
    assert_as_rendered(&mut seen, &path, "certified");
    for show in ["depth", "normal"] {
        seen.key("v");
        seen.wait(|event| event.show() == show);
    }
    seen.key("shift+v");
    seen.wait(|event| event.show() == "depth");
    // While the camera moves, the colours are shown; the depth comes again when it rests.
    seen.moves(|seen| seen.key("w"));
    assert_eq!(seen.last_shown().show(), "depth");
    seen.quit();
}

#[test]
fn light_and_samples_are_those_that_render_draws() {
    let desk = Desk::new();
    let path = scene("lit/figure1");
    let folder = tempfile::tempdir().unwrap();
    let with_samples = |name: &str, of: &str, n: u32| {
        let text = fs::read_to_string(scene(of)).unwrap().replace("samples = 3\n", "");
        let path = folder.path().join(name);
        fs::write(&path, text.replace("[image]\n", &format!("[image]\nsamples = {n}\n"))).unwrap();
        path
    };
    let lit = [1, 2].map(|n| with_samples(&format!("lit{n}.toml"), "lit/figure1", n));
    // The same objects without light.
    let flat = [1, 2].map(|n| with_samples(&format!("flat{n}.toml"), "figure1", n));

    let mut seen = Seen::open(&desk, &path, &["--size", SIZE]);
    log_gpu("light_and_samples_are_those_that_render_draws", &seen);
    assert!(seen.last_shown().is_lit() && seen.last_shown().number("samples") == 3);
    let mut pictures = vec![assert_as_rendered(&mut seen, &path, "certified")];
    let mut saved = Vec::new();
    for (key, n, is_lit, as_in) in [
        ("shift+n", 2, true, &lit[1]),
        ("l", 2, false, &flat[1]),
        ("shift+n", 1, false, &flat[0]),
        ("l", 1, true, &lit[0]),
    ] {
        seen.key(key);
        seen.wait(|event| {
            event.name() == "shown"
                && event.is_settled()
                && (event.is_lit(), event.number("samples")) == (is_lit, n)
        });
        pictures.push(assert_as_rendered(&mut seen, as_in, "certified"));
        seen.key("ctrl+s");
        saved.push(seen.wait(|event| event.name() == "saved").path().to_owned());
    }
    for (path, shown) in saved.iter().zip(&pictures[1..]) {
        assert!(Image::open(&seen.folder().join(path)) == *shown, "{path}");
    }
    for (i, picture) in pictures.iter().enumerate() {
        assert!(pictures[..i].iter().all(|other| other != picture), "{i} is like another");
    }

    // Light comes again when the camera rests; other numbers don't mind it.
    seen.moves(|seen| seen.key("3"));
    assert_as_rendered(&mut seen, &lit[0], "certified");
    seen.key("F4");
    seen.wait(|event| event.show() == "id" && event.is_settled() && !event.is_lit());
    seen.key("F1");
    seen.wait(|event| event.show() == "color" && event.is_settled());
    assert_as_rendered(&mut seen, &lit[0], "certified");
    seen.quit();
}

/// The text of the command `explain` for a pixel of a picture of [`SIZE`].
fn explained_outside(scene: &Path, x: u32, y: u32) -> String {
    let output = Command::new(kugelblitz())
        .args(["explain", scene.to_str().unwrap(), "--pixel", &format!("{x},{y}"), "--size", SIZE])
        .output()
        .unwrap();
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn a_pixel_tells_why() {
    let desk = Desk::new();
    let path = scene("figure2");
    let mut seen = Seen::open(&desk, &path, &["--size", SIZE]);
    log_gpu("a_pixel_tells_why", &seen);
    let [x, y] = [100, 200];
    let camera = seen.camera();
    let place = seen.at(x, y);
    seen.point(place);
    seen.hovers(&format!("pixel {x}, {y} · "));
    seen.xdotool(&["click", "1"]);
    let explained = seen.wait(|event| event.name() == "explained");
    let text = explained.text();
    assert_eq!(text, explained_outside(&path, x, y));
    // The pixel is marked with a ring and not covered.
    let flat = render(&path, &camera, [480, 300], "certified");
    seen.wait_for("the mark", |image| {
        let is_bright = |x: u32, y: u32| image.at(x, y).iter().all(|&channel| channel > 150);
        let is_white = |x: u32| (y - 1..=y + 1).any(|y| is_bright(x, y));
        image.at(x, y) == flat.at(x, y) && is_white(x + 12) && is_white(x - 12)
    });
    seen.key("ctrl+c");
    // P has copied the camera before.
    seen.wait_until("the copy", |seen| seen.clipboard() == text);
    seen.key("Escape");
    seen.point(seen.at(20, 20));
    assert_as_rendered(&mut seen, &path, "certified");
    seen.quit();
}

#[test]
fn the_scene_file_is_watched() {
    let desk = Desk::new();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let good = fs::read_to_string(scene("figure1")).unwrap();
    fs::write(&path, &good).unwrap();
    let mut seen = Seen::open(&desk, &path, &["--size", SIZE]);
    log_gpu("the_scene_file_is_watched", &seen);
    let before = assert_as_rendered(&mut seen, &path, "certified");

    // A good change, written in place.
    let other = good.replace("#d62728", "#00ff7f").replace("radius = 1.0\n", "radius = 1.4\n");
    fs::write(&path, &other).unwrap();
    seen.wait(|event| event.name() == "reloaded");
    let after = assert_as_rendered(&mut seen, &path, "certified");
    assert!(after != before);

    // A broken one, put in the old one's place: its error stands over the last good picture.
    let broken = folder.path().join("new");
    fs::write(&broken, other.replace("radius = 1.4", "radus = 1.4")).unwrap();
    fs::rename(&broken, &path).unwrap();
    let wrong = seen.wait(|event| event.name() == "scene_wrong");
    let error = wrong.error();
    let line = 1 + other.lines().position(|line| line == "radius = 1.4").unwrap();
    assert!(error.contains(&format!("scene.toml:{line}:1:")), "{error}");
    assert!(error.contains("radius"), "{error}");
    let shown = seen.wait_for("the error", |image| image.at(40, 30) != after.at(40, 30));
    for y in 120..300 {
        for x in 0..480 {
            assert_eq!(shown.at(x, y), after.at(x, y), "{x}, {y}");
        }
    }

    // The camera of the file moves the view; all is well again.
    let moved = good.replace("position = [0.0, 2.2, 9.0]", "position = [3.0, 2.2, 9.0]");
    fs::write(&path, &moved).unwrap();
    seen.wait(|event| event.name() == "reloaded");
    assert_as_rendered(&mut seen, &path, "certified");
    assert_eq!(camera_of(&seen.camera()).position.x, 3.0);
    // The user's camera stays where the file's camera does.
    seen.moves(|seen| seen.key("3"));
    let camera = seen.camera();
    fs::write(&path, moved.replace("#1f77b4", "#123456")).unwrap();
    seen.wait(|event| event.name() == "reloaded");
    assert_as_rendered(&mut seen, &path, "certified");
    assert_eq!(seen.camera(), camera);
    seen.quit();
}

#[test]
fn a_pipe_in_a_files_place_stops_nothing() {
    let desk = Desk::new();
    let folder = tempfile::tempdir().unwrap();
    let [path, cloud] = ["scene.toml", "cloud.csv"].map(|name| folder.path().join(name));
    let spheres = "x,y,z\n0.5,3.0,0.0\n";
    let good = format!(
        "{}\n[[spheres]]\nfile = {cloud:?}\nradius = 0.4\ncolor = \"#00ff7f\"\n",
        fs::read_to_string(scene("figure1")).unwrap()
    );
    let replace = |path: &Path, text: Option<&str>| {
        let new = folder.path().join("new");
        match text {
            Some(text) => fs::write(&new, text).unwrap(),
            None => make_pipe(&new),
        }
        fs::rename(&new, path).unwrap();
    };
    fs::write(&cloud, spheres).unwrap();
    fs::write(&path, &good).unwrap();
    let mut seen = Seen::open(&desk, &path, &["--size", SIZE]);
    log_gpu("a_pipe_in_a_files_place_stops_nothing", &seen);

    replace(&path, None);
    let wrong = seen.wait(|event| event.name() == "scene_wrong");
    assert!(wrong.error().contains("regular file"), "{}", wrong.error());
    seen.moves(|seen| seen.key("3"));
    let other = good.replace("#d62728", "#123456");
    replace(&path, Some(&other));
    seen.wait(|event| event.name() == "reloaded");
    assert_as_rendered(&mut seen, &path, "certified");

    replace(&cloud, None);
    replace(&path, Some(&good));
    let wrong = seen.wait(|event| event.name() == "scene_wrong");
    assert!(wrong.error().contains("cloud.csv"), "{}", wrong.error());
    assert!(wrong.error().contains("regular file"), "{}", wrong.error());
    replace(&cloud, Some(spheres));
    replace(&path, Some(&other));
    seen.wait(|event| event.name() == "reloaded");
    assert_as_rendered(&mut seen, &path, "certified");
    // A pipe does not keep the window from closing either.
    replace(&path, None);
    seen.wait(|event| event.name() == "scene_wrong");
    seen.quit();
}

fn make_pipe(path: &Path) {
    let mode = rustix::fs::Mode::RUSR | rustix::fs::Mode::WUSR;
    let kind = rustix::fs::FileType::Fifo;
    rustix::fs::mknodat(rustix::fs::CWD, path, kind, mode, 0).unwrap();
}

#[test]
fn a_window_that_others_end_ends() {
    for moving in [false, true] {
        for end in ["connection", "server", "compositor"] {
            let mut desk = match end {
                "compositor" => Desk::with_wayland(),
                _ => Desk::new(),
            };
            let mut seen = Seen::open(&desk, &scene("figure1"), &["--size", SIZE]);
            if moving {
                seen.keep_moving();
                let n = seen.last_shown().number("frame");
                seen.wait(|event| event.name() == "shown" && event.number("frame") > n + 10);
            }
            match end {
                "connection" => seen.xdotool(&["windowkill", &seen.window.to_string()]),
                _ => desk.end(),
            }
            let code = seen.exit_code();
            let stderr = seen.stderr();
            assert_eq!(code, Some(1), "{end}: {stderr}");
            // Where the X server is gone, Xlib may be the one that ends the program.
            let last = stderr.lines().last().unwrap_or_default();
            let is_told = last == "error: the display: the connection was lost";
            assert!(is_told || end == "server", "{end}: {stderr}");
        }
    }
}

#[test]
fn what_the_driver_prints_is_not_heard() {
    let desk = Desk::new();
    let mut seen = Seen::open(&desk, &scene("figure1"), &["--size", SIZE]);
    seen.moves(|seen| seen.key("2"));
    assert_eq!(seen.stderr(), "");
    seen.quit();
}

#[test]
fn the_window_is_resized_its_panels_hidden_and_it_closes() {
    let desk = Desk::new();
    let path = scene("figure1");
    let mut seen = Seen::open(&desk, &path, &["--size", SIZE, "--device", "cpu"]);
    for [width, height] in [[801, 503], [333, 700], [1100, 600]] {
        seen.resize(width, height);
        let [left, top, shown_width, shown_height] = seen.area();
        assert_eq!((left, shown_width), (0, width));
        assert!(top > 0 && shown_height < height);
        assert_as_rendered(&mut seen, &path, "certified");
    }
    seen.moves(|seen| seen.key("o"));
    assert_eq!(seen.area(), [0, 0, 1100, 600]);
    assert_as_rendered(&mut seen, &path, "certified");
    seen.moves(|seen| seen.key("o"));
    // The help covers the picture and does not change it.
    let picture = assert_as_rendered(&mut seen, &path, "certified");
    seen.key("h");
    seen.wait_for("the help", |image| *image != picture);
    seen.key("Escape");
    seen.wait_for_picture(&picture);
    seen.close();
}

#[test]
fn a_dropped_scene_is_opened() {
    let desk = Desk::new();
    let folder = tempfile::tempdir().unwrap();
    let [one, two] = ["one", "two"].map(|name| folder.path().join(format!("{name}.toml")));
    fs::copy(scene("figure1"), &one).unwrap();
    fs::write(&two, "[camera\n").unwrap();
    let mut seen = Seen::open(&desk, &one, &["--size", SIZE]);
    log_gpu("a_dropped_scene_is_opened", &seen);

    // A wrong one leaves the picture as it was.
    let camera = seen.camera();
    seen.drop_file(&two);
    let wrong = seen.wait(|event| event.name() == "scene_wrong");
    assert!(wrong.error().contains("two.toml"), "{}", wrong.error());
    assert_eq!(seen.camera(), camera);
    assert_as_rendered(&mut seen, &one, "certified");

    fs::copy(scene("figure5"), &two).unwrap();
    seen.drop_file(&two);
    let opened = seen.wait(|event| event.name() == "scene_opened");
    assert!(opened.path().ends_with("two.toml"), "{}", opened.path());
    seen.wait(desk::Event::is_settled);
    assert_as_rendered(&mut seen, &two, "certified");

    // The new one is watched, the old one is not.
    let text = fs::read_to_string(&two).unwrap();
    fs::write(&one, "[camera\n").unwrap();
    fs::write(&two, text.replace("radius = 5.0", "radius = 4.0")).unwrap();
    let next = seen.wait(|event| ["reloaded", "scene_wrong"].contains(&event.name()));
    assert_eq!(next.name(), "reloaded", "{}", next.error());
    assert_as_rendered(&mut seen, &two, "certified");
    seen.quit();
}

#[test]
fn two_saves_at_once_have_full_resolution_and_two_names() {
    let desk = Desk::new();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.toml");
    let text = fs::read_to_string(scene("figure2")).unwrap();
    fs::write(&path, text.replace("= 1280", "= 2000").replace("= 720", "= 1500")).unwrap();
    let mut seen = Seen::open(&desk, &path, &[]);
    seen.resize(500, 400);
    let expected = render(&path, &seen.camera(), [2000, 1500], "certified");
    seen.xdotool(&["key", "--delay", "0", "ctrl+s", "ctrl+s"]);
    let mut saved = [(); 2].map(|()| seen.wait(|event| event.name() == "saved").path().to_owned());
    saved.sort();
    for (path, name) in saved.iter().zip(["large-1.png", "large-2.png"]) {
        assert!(path.ends_with(name), "{path}");
        assert!(Image::open(&seen.folder().join(name)) == expected, "{path}");
    }
    seen.quit();
}

#[test]
fn a_save_that_fails_behind_a_closed_window_is_told() {
    let desk = Desk::new();
    let mut seen = Seen::open(&desk, &scene("figure2"), &["--size", "4000x3000"]);
    seen.allow_files_of(1000);
    // The window hears no more of the save, however quick that is.
    seen.at_once(|seen| seen.xdotool(&["key", "--delay", "0", "ctrl+s", "ctrl+q"]));
    let code = seen.exit_code();
    let stderr = seen.stderr();
    assert_eq!(code, Some(1), "{stderr}");
    assert!(stderr.contains("error: ./figure2-1.png: File too large"), "{stderr}");
    assert!(seen.log.iter().all(|event| event.name() != "trouble"), "{stderr}");
    assert!(!seen.folder().join("figure2-1.png").exists());
}

#[test]
fn a_lost_device_ends_the_window_in_words() {
    let desk = Desk::new();
    let path = scene("figure1");
    let mut seen = Seen::open(&desk, &path, &["--size", SIZE, "--lose-device-after", "40"]);
    log_gpu("a_lost_device_ends_the_window_in_words", &seen);
    seen.keep_moving();
    let code = seen.exit_code();
    assert_eq!(code, Some(5), "{}", seen.stderr());
    assert!(seen.stderr().starts_with("error: "), "{}", seen.stderr());
    assert!(seen.stderr().contains("given up"), "{}", seen.stderr());
}

#[test]
fn without_a_driver_it_says_how_to_get_one() {
    let desk = Desk::new();
    let folder = tempfile::tempdir().unwrap();
    let none = folder.path().join("none.json");
    let output = desk
        .program(folder.path())
        .args(["view", scene("figure1").to_str().unwrap()])
        .envs([("VK_DRIVER_FILES", &none), ("VK_ICD_FILENAMES", &none)])
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{stderr}");
    assert!(stderr.contains("no Vulkan device found with `VK_DRIVER_FILES="), "{stderr}");
    assert!(!stderr.contains("{}"), "{stderr}");
}

#[test]
fn a_summary_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output = desk::program("", folder.path())
        .args(["view", scene("figure1").to_str().unwrap(), "--json"])
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{stderr}");
    assert!(stderr.contains("--json: this command has no summary"), "{stderr}");
}

#[test]
#[ignore = "takes minutes"]
fn use_leaves_memory_bounded() {
    desk::usage::work_through();
}
