//! What the device proposes in f32 is what its Rust twin proposes, an object or "undecided", ray by
//! ray and before anything is resolved; and the comparison sees what it is there for.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::control::Control;
use kugelblitz::cpu::CpuTracer;
use kugelblitz::generate::{Distribution, Recipe, write_cloud, write_scene};
use kugelblitz::gpu::before::{propose_alone, propose_in_space};
use kugelblitz::gpu::{Gpu, GpuTracer, Pick};
use kugelblitz::num::OPEN;
use kugelblitz::output::{OutputFile, commit};
use kugelblitz::prepare::{FEW_SPHERES, LISTED_SPHERES, Objects, Prepared, Seen};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{Camera, Projection, Scene, Sphere, read_scene};
use kugelblitz::trace::{Hits, Kernel, Ray, Rays, Wants};
use kugelblitz::tracer::Tracer;
use kugelblitz_tests::{gpu, in_cube, log_uniform, plane, root, scene, sphere};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Rays into a scene.
#[derive(Clone)]
struct Case {
    what: String,
    scene: Arc<Scene>,
    rays: Rays,
}

impl Case {
    fn prepared(&self) -> Prepared {
        Prepared::new(Arc::clone(&self.scene), Kernel::Certified, &self.rays).unwrap()
    }
}

fn proposed(tracer: &mut dyn Tracer, rays: &Rays) -> Vec<u32> {
    let mut hits = Hits::default();
    tracer.propose(rays, &Control::default(), &mut hits).unwrap();
    hits.id
}

fn on_device(gpu: &Arc<Gpu>, prepared: Prepared, rays: &Rays) -> Vec<u32> {
    let wants = Wants::default();
    proposed(&mut GpuTracer::new(Arc::clone(gpu), Arc::new(prepared), wants).unwrap(), rays)
}

/// What the twin proposes, for which each ray goes through a hierarchy alone.
fn of_twin(prepared: Prepared, rays: &Rays) -> Vec<u32> {
    match (&prepared.hierarchy, rays) {
        (_, Rays::Pixels(pixels)) => propose_alone(&prepared, pixels).unwrap(),
        (Some(_), Rays::List(_)) => propose_in_space(&prepared, rays).unwrap(),
        _ => proposed(&mut CpuTracer::new(Arc::new(prepared), Wants::default()), rays),
    }
}

/// Rays of a comparison.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    rays: usize,
    undecided: usize,
    hits: usize,
}

impl Tally {
    fn of(ids: &[u32]) -> Tally {
        let count = |wanted: fn(u32) -> bool| ids.iter().filter(|&&id| wanted(id)).count();
        Tally {
            rays: ids.len(),
            undecided: count(|id| id == OPEN),
            hits: count(|id| id != 0 && id != OPEN),
        }
    }

    fn decided_share(&self) -> f64 {
        1.0 - self.undecided as f64 / self.rays as f64
    }

    fn add(&mut self, other: Tally) {
        self.rays += other.rays;
        self.undecided += other.undecided;
        self.hits += other.hits;
    }
}

/// Compares two proposals for the same rays. A device with the CPU's arithmetic must propose the
/// same for each ray, and so leave as many open. Another one may leave other rays open, but not
/// more than twice as many and a hundredth; where both decide, they see the same object.
fn compare(twin: &[u32], device: &[u32], is_ieee: bool) -> Result<Tally, String> {
    if twin.len() != device.len() || twin.is_empty() {
        return Err(format!("{} rays, of the device {}", twin.len(), device.len()));
    }
    let both_count = |a: u32, b: u32| is_ieee || a != OPEN && b != OPEN;
    let differs = |i: &usize| twin[*i] != device[*i] && both_count(twin[*i], device[*i]);
    let differing: Vec<usize> = (0..twin.len()).filter(differs).collect();
    if let Some(&first) = differing.first() {
        return Err(format!(
            "{} of {} rays differ, first ray {first}: {} and on the device {}",
            differing.len(),
            twin.len(),
            twin[first] as i32,
            device[first] as i32
        ));
    }
    let (of_twin, of_device) = (Tally::of(twin), Tally::of(device));
    if of_device.undecided > 2 * of_twin.undecided + twin.len() / 100 {
        return Err(format!("the device leaves too much open: {of_device:?}, twin {of_twin:?}"));
    }
    Ok(of_device)
}

fn compare_case(gpu: &Arc<Gpu>, case: &Case) -> Result<Tally, String> {
    let is_ieee = gpu.is_ieee(Kernel::Certified).unwrap();
    let prepared = case.prepared();
    let device = on_device(gpu, prepared.clone(), &case.rays);
    compare(&of_twin(prepared, &case.rays), &device, is_ieee)
        .map_err(|what| format!("{}: {what}", case.what))
}

/// The device must propose by itself, or the CPU would be compared with itself.
fn suited_gpu() -> Arc<Gpu> {
    let gpu = gpu();
    assert!(gpu.arithmetic().unwrap().suits_filter(), "{}", gpu.arithmetic().unwrap());
    gpu
}

fn assert_proposals(cases: &[Case]) -> Tally {
    let gpu = suited_gpu();
    let mut all = Tally::default();
    for case in cases {
        all.add(compare_case(&gpu, case).unwrap_or_else(|what| panic!("{what}")));
    }
    assert!(all.rays > 0 && all.hits > 0, "{all:?}");
    println!("{} decided in f32: {all:?}", all.decided_share());
    all
}

/// The picture that a camera sees, and a part of it.
fn pictures(what: &str, scene: &Arc<Scene>, camera: &Camera) -> [Case; 2] {
    let whole = Pixels::whole(View::new(camera), 203, 151);
    let part = Pixels { x: 101, y: 67, width: 43, height: 31, ..whole };
    [whole, part].map(|pixels| Case {
        what: format!("{what}, {} × {}", pixels.width, pixels.height),
        scene: Arc::clone(scene),
        rays: Rays::Pixels(pixels),
    })
}

/// A scene as its camera sees it, from far away, and from a place close to its first sphere.
fn views(what: &str, scene: Scene) -> Vec<Case> {
    let own = scene.camera.clone().unwrap();
    let scene = Arc::new(scene);
    let back = own.position - own.look_at;
    let mut cameras = vec![
        ("own view", own.clone()),
        ("from afar", Camera { position: own.look_at + back * 40.0, ..own.clone() }),
    ];
    if let Some(first) = scene.spheres.first() {
        let near = first.center + back.normalize() * first.radius * 1.001;
        cameras.push(("from close by", Camera { position: near, ..own.clone() }));
        cameras.push(("from inside", Camera { position: first.center, ..own.clone() }));
    }
    cameras.retain(|(_, camera)| camera.position != camera.look_at);
    let parallel = cameras.clone().into_iter().map(|(name, camera)| {
        let height = camera.position.distance(camera.look_at);
        let projection = Projection::Orthographic { height };
        (name, Camera { projection, ..camera })
    });
    cameras.extend(parallel.collect::<Vec<_>>());
    let named = cameras.iter().map(|(name, camera)| (format!("{what}, {name}"), camera));
    named.flat_map(|(name, camera)| pictures(&name, &scene, camera)).collect()
}

fn scene_files(folder: &str) -> Vec<PathBuf> {
    let folder = root().join(folder);
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> =
        entries.filter(|p| p.extension().is_some_and(|e| e == "toml")).collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

fn scenes_of(folder: &str) -> Vec<Case> {
    let files = scene_files(folder);
    files.iter().flat_map(|p| views(&p.display().to_string(), read_scene(p).unwrap())).collect()
}

fn cloud(distribution: Distribution, count: u64) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let (cloud, file) = (folder.path().join("cloud.npy"), folder.path().join("cloud.toml"));
    let recipe = Recipe { distribution, count, seed: 3 };
    let control = Control::default();
    let [mut rows, mut text] = [&cloud, &file].map(|path| OutputFile::create(path, false).unwrap());
    write_cloud(&mut rows, &recipe, &control).unwrap();
    write_scene(&mut text, &cloud, &recipe).unwrap();
    commit([rows, text], &control).unwrap();
    read_scene(&file).unwrap()
}

/// Clouds that the program makes up, and more made of them: dense clusters in thin space, a shell, and one far
/// from the origin.
fn clouds(count: u64) -> Vec<(&'static str, Scene)> {
    let uniform = cloud(Distribution::Uniform, count);
    let changed = |change: &dyn Fn(usize, &Sphere) -> Sphere| {
        let spheres = uniform.spheres.iter().enumerate().map(|(i, sphere)| change(i, sphere));
        Scene { spheres: spheres.collect(), ..uniform.clone() }
    };
    let n_clusters = (count as f64).cbrt() as usize;
    let clusters = changed(&|i, s| {
        let (middle, size) =
            (uniform.spheres[i % n_clusters].center, 0.5f64.powi(i as i32 % 6 + 3));
        sphere(middle + size * s.center, 2.0 * size * s.radius)
    });
    let shell = changed(&|_, s| sphere(0.5 * s.center.normalize(), 0.4 / (count as f64).sqrt()));
    let offset = DVec3::new(6e6, 0.0, -8e6);
    let mut far = changed(&|_, s| sphere(s.center + offset, s.radius));
    if let Some(camera) = &mut far.camera {
        (camera.position, camera.look_at) = (camera.position + offset, camera.look_at + offset);
    }
    let made = Distribution::ALL.map(|of| (of.name(), cloud(of, count)));
    made.into_iter().chain([("clusters", clusters), ("a shell", shell), ("far", far)]).collect()
}

#[test]
fn proposals_of_the_lectures_scenes() {
    let cases = scenes_of("scenes");
    let all = assert_proposals(&cases);
    // Measured 0.99998, with eyes on and in spheres among them.
    assert!(all.decided_share() > 0.9995, "{all:?}");
    let (gpu, mut easy) = (suited_gpu(), Tally::default());
    for case in cases.iter().filter(|case| case.what.contains("own view")) {
        easy.add(compare_case(&gpu, case).unwrap());
    }
    println!("{} decided in f32 in their own views: {easy:?}", easy.decided_share());
    // Measured 0.99997.
    assert!(easy.decided_share() > 0.9995, "{easy:?}");
}

#[test]
fn proposals_of_hard_scenes() {
    let all = assert_proposals(&scenes_of("scenes/hard"));
    assert!(all.undecided > 1000, "nothing is hard: {all:?}");
}

#[test]
fn proposals_of_clouds() {
    let mut cases = scenes_of("scenes/clouds");
    for count in [FEW_SPHERES as u64, FEW_SPHERES as u64 + 1, 1_000, 20_000] {
        for (name, scene) in clouds(count) {
            let planes = vec![plane(scene.spheres[0].center, DVec3::new(0.1, 1.0, 0.2))];
            let what = format!("{count} {name}");
            cases.extend(views(&format!("{what} and a plane"), Scene { planes, ..scene.clone() }));
            cases.extend(views(&what, scene));
        }
    }
    let with_hierarchy = cases.iter().filter(|case| case.prepared().hierarchy.is_some()).count();
    assert!(with_hierarchy > cases.len() / 2, "{with_hierarchy} of {}", cases.len());
    let (gpu, mut easy) = (suited_gpu(), Tally::default());
    for case in &cases {
        let tally = compare_case(&gpu, case).unwrap_or_else(|what| panic!("{what}"));
        if case.what.contains("uniform, own view") {
            easy.add(tally);
        }
    }
    println!("{} decided in f32 in clouds: {easy:?}", easy.decided_share());
    // Measured 0.9998.
    assert!(easy.hits > 0 && easy.decided_share() > 0.999, "{easy:?}");
}

/// A ray at a sphere's silhouette or along a plane, but for one part in `2¹⁰` … `2³⁰`.
fn grazing(rng: &mut ChaCha8Rng, scene: &Scene) -> Ray {
    let origin = in_cube(rng) * 10.0;
    let off = log_uniform(rng, 2f64.powi(-30), 2f64.powi(-10));
    let index = rng.random_range(0..scene.n_objects());
    let direction = match scene.spheres.get(index) {
        Some(sphere) => {
            let l = sphere.center - origin;
            let inside = l.length_squared() - sphere.radius * sphere.radius;
            let across = l.cross(in_cube(rng)).normalize();
            l + across * (1.0 + off) * sphere.radius * l.length() / inside.max(1.0).sqrt()
        }
        None => {
            let normal = scene.planes[index - scene.spheres.len()].normal;
            in_cube(rng).cross(normal) + normal * off
        }
    };
    Ray { origin, direction: direction * log_uniform(rng, 1e-12, 1e12) }
}

/// Half of the rays go anywhere, half graze something.
fn random_list(n_spheres: usize, n_planes: usize, seed: u64) -> Case {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let spheres = (0..n_spheres)
        .map(|_| {
            let distance = log_uniform(&mut rng, 1.0, 1e3).abs();
            sphere(in_cube(&mut rng) * distance, distance * rng.random_range(0.001..0.5))
        })
        .collect();
    let planes =
        (0..n_planes).map(|_| plane(in_cube(&mut rng) * 100.0, in_cube(&mut rng))).collect();
    let scene = scene(spheres, planes);
    let mut ray = |index: usize| match index % 2 {
        0 => grazing(&mut rng, &scene),
        _ => Ray {
            origin: in_cube(&mut rng) * 10.0,
            direction: in_cube(&mut rng) * log_uniform(&mut rng, 1e-12, 1e12),
        },
    };
    let rays = Rays::List((0..20_000).map(&mut ray).collect());
    Case {
        what: format!("list into {n_spheres} spheres and {n_planes} planes, seed {seed}"),
        scene: Arc::new(scene),
        rays,
    }
}

#[test]
fn proposals_for_lists_of_rays() {
    let sizes = [(1, 0), (0, 1), (7, 2), (24, 5), (LISTED_SPHERES, 3)];
    let cases: Vec<Case> = (50..)
        .zip(sizes)
        .map(|(seed, (spheres, planes))| random_list(spheres, planes, seed))
        .collect();
    assert!(cases.iter().all(|case| case.prepared().hierarchy.is_none()));
    let all = assert_proposals(&cases);
    // Measured 0.885: what is left open grazes.
    assert!(all.undecided > 1000 && all.decided_share() > 0.85, "{all:?}");
}

/// Lists into many spheres, and the same with many rays along and across an axis.
fn lists_into_clouds() -> Vec<Case> {
    let sizes = [(LISTED_SPHERES + 1, 0), (500, 3), (5_000, 0)];
    let mut cases: Vec<Case> = (80..)
        .zip(sizes)
        .map(|(seed, (spheres, planes))| random_list(spheres, planes, seed))
        .collect();
    for (mut case, axis) in cases.clone().into_iter().zip(DVec3::AXES) {
        let Rays::List(rays) = &mut case.rays else { panic!("a list") };
        for (index, ray) in rays.iter_mut().enumerate() {
            match index % 3 {
                0 => ray.direction = if index % 2 == 0 { axis } else { -axis },
                1 => ray.direction -= ray.direction * axis,
                _ => {}
            }
        }
        case.what += ", along an axis";
        cases.push(case);
    }
    cases
}

#[test]
fn proposals_for_lists_of_rays_into_many_spheres() {
    let cases = lists_into_clouds();
    for case in &cases {
        assert!(case.prepared().in_space().unwrap().is_some(), "{}", case.what);
    }
    let all = assert_proposals(&cases);
    // Measured 0.992.
    assert!(all.undecided > 500 && all.decided_share() > 0.98, "{all:?}");
    // A sphere that f32 has no box for leaves all rays open.
    let mut beside = random_list(500, 1, 89);
    let mut spheres = beside.scene.spheres.to_vec();
    spheres.push(sphere(DVec3::Y * 1e19, 1e19 - 30.0));
    beside.scene = Arc::new(scene(spheres, beside.scene.planes.clone()));
    assert_eq!(beside.prepared().hierarchy.unwrap().rest, [501]);
    let tally = compare_case(&suited_gpu(), &beside).unwrap_or_else(|what| panic!("{what}"));
    assert_eq!(tally.undecided, tally.rays);
}

/// Vulkan asks for no more than four storage buffers in a shader. A list of `certified` needs no more; where
/// a kernel does, it is told with numbers.
#[test]
fn lists_need_few_storage_buffers() {
    let case = random_list(300, 2, 88);
    let mut gpu = Gpu::open(&Pick::Best).unwrap();
    gpu.facts.max_storage_buffers = 4;
    let gpu = Arc::new(gpu);
    assert!(compare_case(&gpu, &case).unwrap().hits > 0);
    let prepared = Prepared::new(Arc::clone(&case.scene), Kernel::Stable, &case.rays).unwrap();
    let wants = Wants { surface: true, level: false };
    let refused = GpuTracer::new(gpu, Arc::new(prepared), wants).err().unwrap();
    assert_eq!(refused.exit_code(), 7);
    let text = refused.to_string();
    assert!(text.contains("6 storage buffers") && text.contains("at most 4"), "{text}");
}

/// Where spheres are too far from the rays for f32's slabs, the CPU takes the list.
#[test]
fn a_list_far_from_its_tree_is_left_to_the_cpu() {
    let mut case = random_list(500, 0, 90);
    let Rays::List(rays) = &mut case.rays else { panic!("a list") };
    rays[0].origin = DVec3::X * 3e12;
    let prepared = case.prepared();
    assert!(prepared.in_range && prepared.in_space().unwrap().is_none());
    let (control, wants) = (Control::default(), Wants { surface: true, level: false });
    let trace = |mut tracer: Box<dyn Tracer>| {
        let mut hits = Hits::default();
        tracer.trace(&case.rays, &control, &mut hits).unwrap();
        hits
    };
    let prepared = Arc::new(prepared);
    let of_device = GpuTracer::new(suited_gpu(), Arc::clone(&prepared), wants).unwrap();
    let of_device = trace(Box::new(of_device));
    assert_eq!(of_device, trace(Box::new(CpuTracer::new(prepared, wants))));
    assert!(of_device.n_hits() > 1000);
}

/// A tile of the CPU shows a ray more spheres than its walk alone does, never other objects.
#[test]
fn tiles_propose_what_single_rays_do_or_leave_it_open() {
    let (mut n_open, mut n_more) = (0, 0);
    for (name, scene) in clouds(5_000) {
        for case in views(name, scene) {
            let prepared = case.prepared();
            let alone = of_twin(prepared.clone(), &case.rays);
            let wants = Wants::default();
            let tiles = proposed(&mut CpuTracer::new(Arc::new(prepared), wants), &case.rays);
            assert_eq!(alone.len(), tiles.len());
            for (ray, (&alone, &tile)) in alone.iter().zip(&tiles).enumerate() {
                let what = || format!("{}, ray {ray}: {alone}, in a tile {tile}", case.what);
                assert!(tile == OPEN || tile == alone, "{}", what());
                n_open += usize::from(tile == OPEN);
                n_more += usize::from(tile != alone);
            }
        }
    }
    println!("{n_open} rays left open by tiles, {n_more} by tiles alone");
    assert!(n_open > 0 && n_more <= n_open / 2, "{n_more} of {n_open}");
}

/// An ordinary view, a hard one, many spheres, and rays that start anywhere.
fn sabotaged_cases() -> [Case; 5] {
    let read = |name| {
        let folder = root().join("scenes");
        read_scene(&folder.join(name)).unwrap()
    };
    let picture = |what, scene: Scene| {
        let camera = scene.camera.clone().unwrap();
        let [whole, _] = pictures(what, &Arc::new(scene), &camera);
        whole
    };
    [
        picture("figure 1", read("figure1.toml")),
        picture("touching spheres", read("hard/touching.toml")),
        picture("a cloud", cloud(Distribution::Uniform, 3_000)),
        random_list(7, 2, 60),
        random_list(500, 1, 61),
    ]
}

/// What a sabotage does.
enum Sabotage {
    /// Puts other words into the shader.
    Text(&'static str, &'static str),
    /// Hands other numbers to the device.
    Numbers(fn(&mut Prepared)),
}

/// The guard radii a third as far from each other.
fn cut_radii(inner2: &mut f32, outer2: &mut f32) {
    let (middle, sixth) = ((*inner2 + *outer2) / 2.0, (*outer2 - *inner2) / 6.0);
    (*inner2, *outer2) = (middle - sixth, middle + sixth);
}

fn cut_guards(prepared: &mut Prepared) {
    if let Objects::Certified(lists) = &mut prepared.objects {
        for sphere in &mut lists.spheres {
            cut_radii(&mut sphere.inner2, &mut sphere.outer2);
            sphere.slack /= 3.0;
        }
    }
    if let Some(hierarchy) = &mut prepared.hierarchy
        && let Some(Seen { far, .. }) = &mut hierarchy.seen
    {
        far.iter_mut().for_each(|sphere| cut_radii(&mut sphere.inner2, &mut sphere.outer2));
    }
}

fn cut_plane_errors(prepared: &mut Prepared) {
    if let Objects::Certified(lists) = &mut prepared.objects {
        for plane in &mut lists.planes {
            plane.direction_error /= 3.0;
            plane.n_offset_error /= 3.0;
        }
    }
}

#[test]
fn sabotage_of_a_shader_is_noticed() {
    use Sabotage::{Numbers, Text};
    let cases = sabotaged_cases();
    let honest = suited_gpu();
    for case in &cases {
        compare_case(&honest, case).unwrap_or_else(|what| panic!("{what}"));
    }
    let [figure, hard, cloud, list, tree] = [0, 1, 2, 3, 4];
    let decision = "return select(UNDECIDED, nearest.id, is_decided);";
    // What it is called, what it does, the cases that notice it, and whether a device with other
    // arithmetic than the CPU's is caught as well.
    let sabotages = [
        ("always undecided", Text(decision, "return UNDECIDED;"), vec![figure, cloud, list], true),
        ("never undecided", Text(decision, "return nearest.id;"), vec![hard, list], false),
        (
            "a flipped sign in the distance from the line",
            Text("let p = l - ray.direction * s;", "let p = l + ray.direction * s;"),
            vec![figure, cloud, list],
            true,
        ),
        (
            "a flipped sign of half the chord",
            Text("(s + sqrt(abs(outer) * ray.inv_a))", "(s - sqrt(abs(outer) * ray.inv_a))"),
            vec![cloud],
            true,
        ),
        (
            "a flipped sign of a plane's offset",
            Text("select(slope, -slope, n_offset < 0.0)", "select(-slope, slope, n_offset < 0.0)"),
            vec![list],
            true,
        ),
        (
            "a lost node",
            Text("covers(node, cell) &", "(at != 2u) & covers(node, cell) &"),
            vec![cloud],
            true,
        ),
        (
            "a lost box of the tree",
            Text("let is_met = meets(", "let is_met = at % 7u != 3u && meets("),
            vec![tree],
            true,
        ),
        (
            "a flipped side of a slab",
            Text("select(low, high, slab.goes_down)", "select(high, low, slab.goes_down)"),
            vec![tree],
            true,
        ),
        (
            "a slab that ends too soon",
            Text("* slab.far_inverse", "* (0.5 * slab.far_inverse)"),
            vec![tree],
            true,
        ),
        (
            "a bound of t that is too small",
            Text("return T_ROOM / max", "return 0.5 * T_ROOM / max"),
            vec![cloud, tree],
            true,
        ),
        (
            "a lost second object",
            Text("select(nearest.second_high, farther, farther > nearest.second_high)", "0.0"),
            vec![hard],
            false,
        ),
        ("guards cut to a third", Numbers(cut_guards), vec![hard, cloud, list], false),
        ("planes' bounds cut to a third", Numbers(cut_plane_errors), vec![list], false),
    ];
    let is_ieee = honest.is_ieee(Kernel::Certified).unwrap();
    for (what, sabotage, noticed_by, is_seen_anywhere) in sabotages {
        if !is_ieee && !is_seen_anywhere {
            continue;
        }
        for case in noticed_by.into_iter().map(|index| &cases[index]) {
            let mut spoiled = case.prepared();
            let device = match &sabotage {
                &Text(from, to) => {
                    let gpu = Gpu::open(&Pick::Best).unwrap();
                    Arc::new(gpu.edit_shaders(move |wgsl| {
                        assert!(wgsl.contains(from), "no shader has: {from}");
                        wgsl.replace(from, to)
                    }))
                }
                Numbers(spoil) => {
                    spoil(&mut spoiled);
                    Arc::clone(&honest)
                }
            };
            let ids = on_device(&device, spoiled, &case.rays);
            let verdict = compare(&of_twin(case.prepared(), &case.rays), &ids, is_ieee);
            assert!(verdict.is_err(), "{what} is not noticed in {}: {verdict:?}", case.what);
        }
    }
}

#[test]
fn sabotage_of_proposals_is_noticed() {
    let [_, case, ..] = sabotaged_cases();
    let twin = of_twin(case.prepared(), &case.rays);
    let tally = compare(&twin, &twin, true).unwrap();
    assert_eq!((tally.rays, tally.undecided), (twin.len(), Tally::of(&twin).undecided));
    let first = |is_wanted: fn(u32) -> bool| twin.iter().position(|&id| is_wanted(id)).unwrap();
    let open = first(|id| id == OPEN);
    let hit = first(|id| id != 0 && id != OPEN);
    let miss = first(|id| id == 0);
    for (index, id, is_seen_anywhere) in
        [(open, 1, false), (hit, OPEN, false), (hit, 0, true), (miss, 1, true)]
    {
        let mut device = twin.clone();
        device[index] = id;
        assert!(compare(&twin, &device, true).is_err(), "{} became {id}", twin[index]);
        assert_eq!(compare(&twin, &device, false).is_err(), is_seen_anywhere);
    }
    assert!(compare(&twin, &twin[1..], true).is_err(), "a missing ray");
    assert!(compare(&twin, &vec![OPEN; twin.len()], false).is_err(), "all undecided");
    assert!(compare(&[], &[], true).is_err(), "nothing compared");
}
