//! Pictures straight from data, scenes without a camera, options beside a scene, and films.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::DVec3;
use kugelblitz::Session;
use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::frames::turntable;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::schema::{CameraKeys, CloudKeys, LightKeys, SkyKeys};
use kugelblitz::scene::{
    Color, Composed, Light, Projection, Samples, Scene, SceneOverrides, Sky, Source, Viewpoint,
    compose_scene, parse_scene, read_scene,
};
use kugelblitz::trace::{Hits, Kernel, Rays, Wants};
use kugelblitz_tests::folder::Folder;
use kugelblitz_tests::npy;
use tempfile::TempDir;

use crate::program;
use crate::program::{ends, program, run, scene_file};

fn path(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).to_str().unwrap().to_owned()
}

/// A folder with grains: `radius.npy` of 7 columns, `points.npy` of 3, `grains.csv`, `water.xyz`.
fn data() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let count = ["generate", "cloud", "--count", "300", "--distribution", "packing", "-q"];
    run(&[&count[..], &["-o", &path(&folder, "radius.npy")]].concat(), 0);
    let grid = (0..27).map(|i: i32| [i % 3, i / 3 % 3, i / 9].map(|k| 0.5 * f64::from(k)).to_vec());
    let points: Vec<Vec<f64>> = grid.collect();
    fs::write(path(&folder, "points.npy"), npy(&points, "<f8", false)).unwrap();
    fs::write(path(&folder, "grains.csv"), "x,y,z,r\n0,0,0,1\n2,0,0,1\n0,3,1,0.5\n").unwrap();
    fs::write(path(&folder, "water.xyz"), "3\nwater\nO 0 0 0\nH 0.76 0.59 0\nH -0.76 0.59 0\n")
        .unwrap();
    folder
}

/// The option counts as the key of a scene does.
#[test]
fn a_frame_is_counted_from_0() {
    let folder = data();
    let [steps, scene] = ["steps.xyz", "steps.toml"].map(|name| path(&folder, name));
    fs::write(&steps, "1\n\nC 1 0 0\n1\n\nC 2 0 0\n").unwrap();
    for (frame, x) in [("0", 1.0), ("1", 2.0)] {
        render(&[&steps, "--frame", frame, &format!("--print-scene={scene}")], 0);
        assert!(fs::read_to_string(&scene).unwrap().contains(&format!("frame = {frame}")));
        assert_eq!(read_scene(scene.as_ref()).unwrap().spheres[0].center.x, x);
    }
    let refused = render(&[&steps, "--frame", "2", "--print-scene"], 3);
    assert!(refused.stderr.contains("no frame 2"), "{}", refused.stderr);
}

const DATA: [&str; 4] = ["radius.npy", "points.npy", "grains.csv", "water.xyz"];

fn render(args: &[&str], code: i32) -> program::Ran {
    let small = ["--size", "96x64", "--device", "cpu"];
    run(&[&["render"][..], args, &small].concat(), code)
}

#[test]
fn data_become_pictures_and_scenes_that_give_them_again() {
    let folder = data();
    let elsewhere = tempfile::tempdir().unwrap();
    for name in DATA {
        let data = path(&folder, name);
        let [one, two, three] = ["1.png", "2.png", "3.png"].map(|out| path(&folder, out));
        let beside = path(&folder, "scene.toml");
        render(&[&data, "-o", &one, &format!("--print-scene={beside}")], 0);
        // Beside the data, the scene names them alone; from elsewhere, by all of their path.
        let text = fs::read_to_string(&beside).unwrap();
        assert!(text.contains(&format!("file = \"{name}\"")), "{text}");
        render(&[&beside, "-o", &two], 0);
        let printed = render(&[&data, "--print-scene"], 0);
        let far = path(&elsewhere, "scene.toml");
        fs::write(&far, &printed.stdout).unwrap();
        render(&[&far, "-o", &three], 0);
        let [one, two, three] = [one, two, three].map(|out| fs::read(out).unwrap());
        assert!(one == two && two == three, "{name}");
    }
}

#[test]
fn all_that_is_there_is_in_the_picture() {
    let folder = data();
    for name in DATA {
        for view in ["quarter", "iso", "x", "-x", "y", "-y", "z", "-z"] {
            for lens in [["--fov", "30"], ["--height", "auto"]] {
                let scene = path(&folder, "framed.toml");
                let print = format!("--print-scene={scene}");
                let args = [&path(&folder, name), "--view", view, "--margin", "0.05", &print];
                render(&[&args[..], &lens].concat(), 0);
                let scene = read_scene(scene.as_ref()).unwrap();
                let mut session = Session::new(scene, Device::Cpu, Kernel::Certified);
                let rays = Rays::Pixels(session.pixels(96, 64).unwrap());
                let (mut hits, control) = (Hits::default(), Control::default());
                session.trace(&rays, Wants::default(), &control, &mut hits).unwrap();
                let ids = hits.id;
                let seen = |x: usize, y: usize| ids[y * 96 + x] > 0;
                // 0.05 of 64 rows are 3.2 pixels.
                let is_edge = |x, y| x < 3 || y < 3 || x >= 93 || y >= 61;
                let is_near = |x, y| x < 5 || y < 5 || x >= 91 || y >= 59;
                let all = || (0..64).flat_map(|y| (0..96).map(move |x| (x, y)));
                let case = format!("{name} {view} {lens:?}");
                assert!(!all().any(|(x, y)| is_edge(x, y) && seen(x, y)), "{case}: cut off");
                assert!(all().any(|(x, y)| is_near(x, y) && seen(x, y)), "{case}: too small");
            }
        }
    }
}

fn composed(path: &str, overrides: &SceneOverrides) -> Composed {
    compose_scene(path.as_ref(), overrides, &Control::default()).unwrap()
}

/// The text is the scene: read again, it is the same, number for number.
#[track_caller]
fn same_again(composed: &Composed, place: &Path) -> (Scene, String) {
    let text = composed.text(Some(place)).unwrap();
    let again = parse_scene(&text, place).unwrap_or_else(|e| panic!("{e}\n{text}"));
    assert_eq!(again, composed.scene, "{text}");
    (again, text)
}

#[test]
fn the_printed_scene_is_the_scene() {
    let folder = data();
    let camera_of = |overrides: &SceneOverrides| {
        for name in DATA {
            let place = folder.path().join("again.toml");
            let (scene, _) = same_again(&composed(&path(&folder, name), overrides), &place);
            assert!(scene.camera.is_some() && scene.image.is_some());
        }
    };
    let of = |change: fn(&mut SceneOverrides)| {
        let mut overrides = SceneOverrides::default();
        change(&mut overrides);
        camera_of(&overrides);
    };
    of(|_| ());
    of(|w| w.view = Some(Viewpoint::Iso));
    of(|w| w.camera.position = Some(DVec3::new(30.0, 20.0, 50.0).into()));
    of(|w| {
        w.camera.position = Some(DVec3::splat(30.0).into());
        w.camera.look_at = Some(DVec3::X.into());
    });
    of(|w| w.camera.look_at = Some(DVec3::new(0.5, 0.25, 1e-3).into()));
    of(|w| (w.camera.up, w.view) = (Some(DVec3::Z.into()), Some(Viewpoint::Quarter)));
    of(|w| w.camera.fov = Some(75.0.into()));
    of(|w| w.camera.height = Some(12.0.into()));
    of(|w| w.is_height_chosen = true);
    of(|w| (w.size, w.samples) = (Some([300, 800]), Some(Samples::nearest(3))));
    of(|w| w.background = Some(Color([1.0, 0.5, 0.0])));
    of(|w| w.n_turns = 7);
    of(|w| (w.sky, w.ambient) = (Some(None), Some(Some(Color([0.25; 3])))));
    of(|w| {
        w.sky = Some(Some(SkyKeys::from(&Sky { intensity: 0.75, directions: 9 })));
        w.ambient = Some(Color::from_hex("#102030"));
        let light =
            |source| Light { source, color: [1.0; 3].into(), intensity: 0.5, shadows: true };
        let light = |source| LightKeys::from(&light(source));
        let sources = [Source::Eye, Source::Point(DVec3::Y * 9.0), Source::Sun(DVec3::NEG_Y)];
        w.lights = Some(sources.map(light).to_vec());
    });
    of(|w| w.lights = Some(Vec::new()));
}

#[test]
fn points_get_a_radius_that_is_told() {
    let folder = data();
    let (points, out) = (path(&folder, "points.npy"), path(&folder, "a.png"));
    let ran = render(&[&points, "-o", &out], 0);
    assert!(ran.stderr.contains("each sphere gets 0.25"), "{}", ran.stderr);
    let (scene, text) = same_again(
        &composed(&points, &SceneOverrides::default()),
        &folder.path().join("again.toml"),
    );
    assert!(scene.spheres.iter().all(|sphere| sphere.radius == 0.25), "{text}");
    let ran = render(&[&points, "-o", &out, "--radius", "0.125", "--color", "#ff0000"], 0);
    assert!(!ran.stderr.contains("radius"), "{}", ran.stderr);
    // What the data have is not replaced.
    let ran = render(&[&path(&folder, "grains.csv"), "-o", &out, "--radius", "2"], 3);
    assert!(ran.stderr.contains("has one for each sphere"), "{}", ran.stderr);
}

const LONELY: &str = "# Two balls.\nbackground = \"#102030\"  # night\n\n[[sphere]]\ncenter = [0, 0, 0]\n\
                      radius = 1\ncolor = \"#ff0000\"\n\n[[sphere]]\ncenter = [3, 0, 0]\nradius = 1\n\
                      color = \"#00ff00\"\n";

#[test]
fn a_scene_without_a_camera_gets_one_and_stays_as_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let scene = path(&folder, "balls.toml");
    fs::write(&scene, LONELY).unwrap();
    let again = folder.path().join("again.toml");
    let (found, text) = same_again(&composed(&scene, &SceneOverrides::default()), &again);
    assert!(text.starts_with(LONELY), "{text}");
    // Not lit: a scene says itself what lights it.
    assert!(!found.is_lit() && found.camera.is_some());
    let out = path(&folder, "a.png");
    let ran = render(&[&scene, "-o", &out], 0);
    assert!(ran.stderr.contains("has no [camera]"), "{}", ran.stderr);
    // In perspective or not, each option is in the text.
    let overrides = SceneOverrides {
        background: Color::from_hex("#ffffff"),
        lights: Some(vec![LightKeys::from(&Light {
            source: Source::Eye,
            color: [1.0; 3].into(),
            intensity: 1.0,
            shadows: true,
        })]),
        ..SceneOverrides::default()
    };
    let (_, text) = same_again(&composed(&scene, &overrides), &again);
    assert!(text.contains("background = \"#ffffff\"  # night"), "{text}");
    assert!(text.starts_with("# Two balls.\n") && text.contains("[[light]]"), "{text}");
    // Nothing to be seen: no camera can be placed.
    fs::write(&scene, "background = \"#102030\"\n").unwrap();
    let ran = render(&[&scene, "-o", &out], 3);
    assert!(ran.stderr.contains("no [camera]"), "{}", ran.stderr);
}

#[test]
fn options_win_over_a_scenes_camera() {
    let folder = tempfile::tempdir().unwrap();
    let scene = scene_file("figure1");
    let old = read_scene(scene.as_ref()).unwrap().camera.unwrap();
    let camera = |overrides: SceneOverrides| {
        let again = folder.path().join("again.toml");
        same_again(&composed(&scene, &overrides), &again).0.camera.unwrap()
    };
    let usual = SceneOverrides::default;
    assert_eq!(camera(usual()), old);
    let position = DVec3::new(1.0, 2.0, 9.0);
    let moved = camera(SceneOverrides {
        camera: CameraKeys { position: Some(position.into()), ..CameraKeys::default() },
        ..usual()
    });
    assert_eq!(
        (moved.position, moved.look_at, moved.projection),
        (position, old.look_at, old.projection)
    );
    let flat = camera(SceneOverrides {
        camera: CameraKeys { height: Some(3.0.into()), ..CameraKeys::default() },
        ..usual()
    });
    assert_eq!(
        (flat.position, flat.projection),
        (old.position, Projection::Orthographic { height: 3.0 })
    );
    let side = camera(SceneOverrides { view: Some(Viewpoint::X), ..usual() });
    let way = side.position - side.look_at;
    assert!(
        way.x > 0.0 && way.y == 0.0 && way.z == 0.0 && side.projection == old.projection,
        "{side:?}"
    );
    // With a margin alone, from where the scene's camera looks.
    let near = camera(SceneOverrides { margin: Some(0.0), ..usual() });
    let [a, b] = [&near, &old].map(|c| (c.position - c.look_at).normalize());
    assert!((a - b).length() < 1e-9, "{near:?}");
    let above = camera(SceneOverrides { view: Some(Viewpoint::Y), ..usual() });
    assert_eq!(above.up, DVec3::NEG_Z);
}

#[test]
fn the_keys_of_data_are_for_one_cloud() {
    let folder = data();
    let scene = path(&folder, "cloud.toml");
    let one = "[[spheres]]\nfile = \"points.npy\"\nradius = 0.1  # thin\ncolor = \"#ffffff\"\n";
    fs::write(&scene, one).unwrap();
    let cloud = CloudKeys { radius: Some(0.2.into()), ..CloudKeys::default() };
    let overrides = SceneOverrides { cloud, ..SceneOverrides::default() };
    let (found, text) =
        same_again(&composed(&scene, &overrides), &folder.path().join("again.toml"));
    assert!(found.spheres[0].radius == 0.2 && text.contains("radius = 0.2  # thin"), "{text}");
    let out = path(&folder, "a.png");
    fs::write(&scene, one.repeat(2)).unwrap();
    let ran = render(&[&scene, "-o", &out, "--radius", "1"], 2);
    assert!(ran.stderr.contains("one [[spheres]], but this one has 2"), "{}", ran.stderr);
    render(&[&scene_file("figure1"), "-o", &out, "--color", "#ff0000"], 2);
}

#[test]
fn what_is_no_scene_is_named() {
    let folder = data();
    let file = |name: &str, bytes: &[u8]| {
        let path = path(&folder, name);
        fs::write(&path, bytes).unwrap();
        path
    };
    let numpy = fs::read(path(&folder, "points.npy")).unwrap();
    let out = path(&folder, "a.png");
    for (scene, says) in [
        (file("heap", &numpy), "array of NumPy"),
        (file("heap.toml", &numpy), "array of NumPy"),
        (file("heap.npz", b"PK\x03\x04 \x00"), "ZIP"),
        (file("heap.csv.gz", b"\x1f\x8b\x08\x00"), "gzip"),
        (file("heap.bin", b"1\x00\x02\x03"), "binary data"),
        (file("heap.tab", b"x,y,z,r\n1,2,3,4\n"), "a table of numbers (.csv)"),
        (file("atoms.list", b"1\n\nC 0 0 0\n"), "a file of atoms (.xyz)"),
    ] {
        let ran = render(&[&scene, "-o", &out], 3);
        assert!(ran.stderr.contains(says), "{says}: {}", ran.stderr);
        assert!(!ran.stderr.chars().any(|c| c.is_control() && c != '\n'), "{:?}", ran.stderr);
    }
    // Commands that take scenes alone say what becomes one.
    for command in ["check", "verify"] {
        let ran = run(&[command, &path(&folder, "points.npy")], 3);
        assert!(ran.stderr.contains("--print-scene"), "{}", ran.stderr);
    }
    // What is wrong in the data is told once, with its line, and without a scene that nobody wrote.
    let wrong = file("wrong.csv", b"x,y,z,r\n1,2,3,4\n1,2,3,abc\n");
    let ran = render(&[&wrong, "-o", &out], 3);
    assert!(ran.stderr.contains("line 3: \"abc\" is not a number"), "{}", ran.stderr);
    assert_eq!(ran.stderr.matches("wrong.csv").count(), 1, "{}", ran.stderr);
    assert!(!ran.stderr.contains("[[spheres]]"), "{}", ran.stderr);
    render(&[&file("empty.csv", b"x,y,z,r\n"), "-o", &out], 3);
    assert!(!Path::new(&out).exists());
}

#[test]
fn wrong_options_are_named() {
    let folder = data();
    let (data, out) = (path(&folder, "grains.csv"), path(&folder, "a.png"));
    let cases: [&[&str]; 26] = [
        &["--view", "w"],
        &["--view", "x", "--position", "1,2,3"],
        &["--margin", "0.5"],
        &["--margin", "0.1", "--position", "1,2,3"],
        &["--height", "auto", "--position", "1,2,3"],
        &["--height", "0"],
        &["--height", "2", "--fov", "30"],
        &["--fov", "180"],
        &["--up", "0,0,0"],
        &["--up", "w"],
        &["--up", "x", "--view", "x"],
        &["--position", "1,2"],
        &["--position", "1,2,inf"],
        &["--position", "1,2,3", "--look-at", "1,2,3"],
        &["--background", "blau?"],
        &["--color", "1,2,3"],
        &["--light", "4,6"],
        &["--light", "eye@-1"],
        &["--light", "eye", "--light", "none"],
        &["--sky", "1,0"],
        &["--ambient", "-1"],
        &["--radius", "0"],
        &["--range", "1"],
        &["--samples", "17"],
        &["--columns", "radius"],
        &["--frames", "1-3"],
    ];
    for options in cases {
        let ran = run(&[&["render", &data, "-o", &out][..], options].concat(), 2);
        assert!(!ran.stderr.contains("unexpected argument"), "{options:?}: {}", ran.stderr);
    }
    assert!(!Path::new(&out).exists());
    // Two things can't both go to standard output, nor a scene over its data.
    run(&["render", &data, "-o", "-", "--format", "png", "--print-scene"], 2);
    run(&["render", &data, "-o", &out, "--json", "--print-scene"], 2);
    run(&["render", &data, &format!("--print-scene={data}")], 2);
    run(&["render", &data], 2);
}

#[test]
fn windows_and_exports_take_data_too() {
    let folder = data();
    let data = path(&folder, "grains.csv");
    let pov = run(&["export", "pov", &data, "--view", "z", "--height", "auto"], 0);
    assert!(pov.text().contains("orthographic"), "{}", pov.text());
    let scene = path(&folder, "scene.toml");
    let print = format!("--print-scene={scene}");
    run(&["export", "tachyon", &data, &print], 0);
    assert!(read_scene(scene.as_ref()).unwrap().camera.is_some());
    #[cfg(feature = "view")]
    {
        let printed = run(&["view", &data, "--size", "300x200", "--print-scene"], 0);
        assert!(printed.text().contains("width = 300"), "{}", printed.text());
    }
}

fn frames(folder: &TempDir, stem: &str) -> BTreeSet<PathBuf> {
    let files = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
    files.filter(|path| path.file_name().unwrap().to_str().unwrap().starts_with(stem)).collect()
}

#[test]
fn a_turntable_is_so_many_pictures() {
    let folder = data();
    let (data, out) = (path(&folder, "radius.npy"), path(&folder, "turn.png"));
    let ran = render(&[&data, "-o", &out, "--turntable", "5", "--json"], 0);
    let json = ran.json();
    assert_eq!(json["n_frames"], 5);
    assert_eq!(json["frames"][4]["file"], path(&folder, "turn-0005.png"));
    assert!(json["ffmpeg"].as_str().unwrap().contains("turn-%04d.png"));
    assert!(ran.stderr.contains("ffmpeg -framerate"), "{}", ran.stderr);
    let files = frames(&folder, "turn-");
    assert_eq!(files.len(), 5);
    let pictures: BTreeSet<Vec<u8>> = files.iter().map(|file| fs::read(file).unwrap()).collect();
    assert_eq!(pictures.len(), 5, "each is another picture");

    // The frames of a part are those of the whole, and what is there is left as it is.
    let [second, third] = ["turn-0002.png", "turn-0003.png"].map(|name| path(&folder, name));
    let before = fs::read(&third).unwrap();
    fs::remove_file(&third).unwrap();
    fs::write(&second, "kept").unwrap();
    let part = ["--turntable", "5", "--frames", "2-3", "--resume", "--json"];
    let json = render(&[&[&data[..], "-o", &out][..], &part].concat(), 0).json();
    let skipped = |at: usize| json["frames"][at]["skipped"].as_bool();
    assert_eq!((skipped(0), skipped(1), skipped(2)), (Some(true), Some(false), None));
    assert_eq!(fs::read(&third).unwrap(), before);
    assert_eq!(fs::read(&second).unwrap(), b"kept");
    render(&[&data, "-o", &out, "--turntable", "5", "--frames", "6"], 2);
    render(&[&data, "-o", "-", "--format", "png", "--turntable", "5"], 2);
    render(&[&data, "-o", &path(&folder, "missing/out.png"), "--turntable", "5"], 1);
}

#[test]
fn a_path_is_a_frame_a_line() {
    let folder = data();
    let (data, out) = (path(&folder, "grains.csv"), path(&folder, "path.png"));
    let places = path(&folder, "places.csv");
    fs::write(
        &places,
        "x,y,z,look_at_x,look_at_y,look_at_z,fov\n5,5,9,0,0,0,40\n-5,5,9,1,1,0,50\n",
    )
    .unwrap();
    render(&[&data, "-o", &out, "--camera-path", &places], 0);
    assert_eq!(frames(&folder, "path-").len(), 2);
    let alone = path(&folder, "alone.png");
    let camera = ["--position", "-5,5,9", "--look-at", "1,1,0", "--fov", "50"];
    render(&[&[&data[..], "-o", &alone][..], &camera].concat(), 0);
    assert!(fs::read(path(&folder, "path-0002.png")).unwrap() == fs::read(&alone).unwrap());
    fs::write(&places, "x,y,z\n5,5,9\n5,5\n").unwrap();
    let ran = render(&[&data, "-o", &out, "--camera-path", &places], 1);
    assert!(ran.stderr.contains("places.csv") && ran.stderr.contains("line"), "{}", ran.stderr);
    // A frame must not replace what it is made from.
    let trap = path(&folder, "trap-0001.npy");
    fs::copy(path(&folder, "points.npy"), &trap).unwrap();
    render(&[&trap, "-o", &path(&folder, "trap.npy"), "--turntable", "3"], 2);
}

/// The tree over many spheres is that of the first frame in all others.
#[test]
fn a_film_has_one_tree() {
    let folder = tempfile::tempdir().unwrap();
    let data = path(&folder, "many.npy");
    run(&["generate", "cloud", "--count", "20000", "-q", "-o", &data], 0);
    let scene = composed(&data, &SceneOverrides { n_turns: 3, ..SceneOverrides::default() }).scene;
    let cameras = turntable(scene.camera.as_ref().unwrap(), 3);
    let mut session = Session::new(scene, Device::Cpu, Kernel::Certified);
    let trees = cameras.iter().map(|camera| {
        let rays = Rays::Pixels(Pixels::whole(View::new(camera), 96, 64));
        session.make_ready(&rays, Wants::default(), &Control::default()).unwrap();
        Arc::clone(&session.prepared().unwrap().hierarchy.as_ref().unwrap().bvh)
    });
    let trees: Vec<_> = trees.collect();
    assert!(trees.iter().all(|tree| Arc::ptr_eq(tree, &trees[0])));
}

#[cfg(unix)]
#[test]
fn an_interrupted_film_leaves_whole_frames_and_goes_on() {
    let folder = data();
    let (data, out) = (path(&folder, "radius.npy"), path(&folder, "film.ppm"));
    let film =
        ["render", &data, "-o", &out, "--turntable", "400", "--device", "cpu", "--size", "200x120"];
    let mut child = program(&film).spawn().unwrap();
    let start = Instant::now();
    while frames(&folder, "film-").len() < 3 {
        assert!(start.elapsed() < Duration::from_secs(60) && child.try_wait().unwrap().is_none());
        std::thread::sleep(Duration::from_millis(5));
    }
    let id = rustix::process::Pid::from_child(&child);
    rustix::process::kill_process(id, rustix::process::Signal::INT).unwrap();
    let ended = child.wait_with_output().unwrap();
    assert_eq!(ended.status.code(), Some(130));
    let whole = frames(&folder, "film-");
    assert!(whole.len() < 400);
    for file in &whole {
        assert_eq!(fs::metadata(file).unwrap().len(), 15 + 3 * 200 * 120, "{}", file.display());
    }
    assert!(frames(&folder, ".kugelblitz").is_empty());
    let before = fs::metadata(path(&folder, "film-0001.ppm")).unwrap().modified().unwrap();
    let last = (whole.len() + 2).to_string();
    let frames_asked = format!("1-{last}");
    run(&[&film[..], &["--resume", "--frames", &frames_asked]].concat(), 0);
    assert_eq!(frames(&folder, "film-").len(), whole.len() + 2);
    let after = fs::metadata(path(&folder, "film-0001.ppm")).unwrap().modified().unwrap();
    assert_eq!(before, after);
}

#[test]
fn render_says_what_was_understood_and_writes_the_legend() {
    let folder = Folder::default();
    let camera = "[camera]\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\n";
    folder.write("a.csv", "x,y,z,r,speed [m/s]\n0,0,0,1,1\n0,0,0,1,2\n0,0,0,1,\n");
    let cloud = "[[spheres]]\nfile = \"a.csv\"\n";
    folder.write("a.toml", format!("{camera}{cloud}color_by = \"speed\"\n"));
    folder.write("b.toml", format!("{camera}{cloud}color = \"#ffffff\"\n"));
    let small = ["--size", "16x9", "--device", "cpu", "-o", "a.png", "--legend"];
    let render = |scene: &str, legend: &str, code: i32| {
        let mut command = program(&[&["render", scene][..], &small, &[legend]].concat());
        command.current_dir(folder.path("."));
        ends(command, code).stderr
    };
    let said = render("a.toml", "a.svg", 0);
    assert!(said.contains("a.csv: coloured by `speed [m/s]`, viridis from 1.0 to 2.0"), "{said}");
    assert!(fs::read_to_string(folder.path("a.svg")).unwrap().starts_with("<svg"));
    fs::remove_file(folder.path("a.png")).unwrap();
    for (scene, legend, advice) in
        [("b.toml", "b.svg", "color_by"), ("a.toml", "b.png", ".svg"), ("a.toml", "a.png", "")]
    {
        let said = render(scene, legend, 2);
        assert!(said.contains(advice), "{said}");
        assert!(!folder.path("b.svg").exists() && !folder.path("a.png").exists());
    }
}
