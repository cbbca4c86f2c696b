//! What a device makes by itself: proposals before anything is repaired, what drivers of other arithmetic are seen through,
//! the kernels without a proof and their light, and mistakes in shaders.

use std::sync::{Arc, Mutex, OnceLock};

use kugelblitz::Control;
use kugelblitz::Session;
use kugelblitz::bounds::LARGEST_EXPONENT;
use kugelblitz::device::Device;
use kugelblitz::gpu::Gpu;
use kugelblitz::lighting::{Background, Encoding, Pixel as _, Style, certified_lighting};
use kugelblitz::num::UNDECIDED;
use kugelblitz::prepare::{CertifiedLighting, Prepared, exponent_of};
use kugelblitz::query::{Hits, Kernel, Outputs, Rays, Stage, WorldRay};
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::Samples;
use kugelblitz::tracer::Tracer;
use kugelblitz_tests::twins::{light_alone, propose_alone};
use kugelblitz_tests::{broken, gpu, spoiled, text_of};

use super::failures::Failure;
use super::{Case, assert_none, check_all, in_turn, named, rectangle, setting};

const PLAIN: [Kernel; 3] = [Kernel::Lecture, Kernel::Stable, Kernel::Double];

fn opened() -> Gpu {
    Gpu::open("").expect("a Vulkan device; ci/setup.sh installs one")
}

/// All of a case's picture, a part of it, and its list of rays.
fn rays_of(case: &Case) -> [(&'static str, Rays); 3] {
    let [width, height] = case.size;
    let whole = Pixels::whole(View::new(case.scene.camera.as_ref().unwrap()), width, height);
    let [x, y, width, height] = case.part();
    let part = Pixels { x, y, width, height, ..whole };
    [("all", Rays::Pixels(whole)), ("part", Rays::Pixels(part)), ("list", case.list())]
}

/// Runs a case alone.
pub fn replay(case: &Case) -> String {
    let name = &case.name;
    format!(
        "KUGELBLITZ_CASE={name} cargo test --profile ci -p kugelblitz-tests --test device matrix::"
    )
}

// ---------------------------------------------------------------------------------------------
// Proposals

/// Ids that the CPU decides in f32.
fn of_cpu(prepared: &Arc<Prepared>, rays: &Rays) -> Vec<u32> {
    let (mut hits, wants) = (Hits::default(), Outputs { level: true, ..Outputs::default() });
    let mut tracer = Tracer::on_cpu(Arc::clone(prepared), wants);
    tracer.trace(rays, &Control::default(), &mut hits).unwrap();
    let of_f32 = |(&id, &level)| if level == Stage::F32 as u8 { id } else { UNDECIDED };
    hits.id.iter().zip(&hits.level).map(of_f32).collect()
}

/// Leaves those open as well whose proposals count for nothing, as numbers leave f32's range.
pub fn counted(prepared: &Prepared, rays: &Rays, mut ids: Vec<u32>) -> Vec<u32> {
    let is_ordinary = |ray: &WorldRay| exponent_of(ray.direction).abs() <= LARGEST_EXPONENT;
    for (i, id) in ids.iter_mut().enumerate() {
        let counts = match rays {
            Rays::Pixels(_) => prepared.in_range,
            Rays::List(rays) => {
                let is_far = prepared.origins().is_far(rays[i].origin);
                prepared.in_range && is_ordinary(&rays[i]) && !is_far
            }
        };
        *id = if counts { *id } else { UNDECIDED };
    }
    ids
}

/// What a device proposes by its Rust twin; where it finds no way, all is open.
fn of_twin(prepared: &Prepared, rays: &Rays) -> Vec<u32> {
    propose_alone(prepared, rays).unwrap_or_else(|| vec![UNDECIDED; rays.len()])
}

fn n_open(ids: &[u32]) -> usize {
    ids.iter().filter(|&&id| id == UNDECIDED).count()
}

/// Where two proposals for the same rays see another object, or just another number where they must be equal.
pub fn differing(twin: &[u32], found: &[u32], are_equal: bool) -> Option<String> {
    assert_eq!(twin.len(), found.len());
    let differs = |&i: &usize| {
        twin[i] != found[i] && (are_equal || twin[i] != UNDECIDED && found[i] != UNDECIDED)
    };
    let i = (0..twin.len()).find(differs)?;
    Some(format!("ray {i}: {}, and its twin {}", found[i] as i32, twin[i] as i32))
}

/// Where a device proposes otherwise than its twin. With the same arithmetic they are equal; with another one other rays may
/// be left open, but not more than twice as many and a hundredth.
fn compare(twin: &[u32], found: &[u32], is_ieee: bool) -> Option<String> {
    let [of_twin, of_found] = [twin, found].map(n_open);
    let is_too_much = of_found > 2 * of_twin + twin.len() / 100;
    let share = || format!("{of_found} of {} open, of its twin {of_twin}", twin.len());
    differing(twin, found, is_ieee).or_else(|| is_too_much.then(share))
}

/// What was proposed for how many rays, and how many of them were left open.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    rays: usize,
    open: usize,
    /// Rays that the device itself proposed something for, and not the CPU in its stead.
    on_device: usize,
    /// Lit pixels whose bytes it proposed, or left open, and these.
    lit: usize,
    lit_open: usize,
    /// Lit pixels of scenes with a tree.
    lit_in_trees: usize,
}

/// Rays of a case, and what a device's twin proposes for them.
pub struct Proposal {
    pub way: &'static str,
    pub rays: Rays,
    pub prepared: Arc<Prepared>,
    pub twin: Vec<u32>,
}

impl Proposal {
    pub fn all(case: &Case) -> impl Iterator<Item = Proposal> {
        rays_of(case).into_iter().map(move |(way, rays)| {
            let scene = Arc::clone(&case.scene);
            let prepared = Arc::new(Prepared::new(scene, Kernel::Certified, &rays).unwrap());
            let twin = counted(&prepared, &rays, of_twin(&prepared, &rays));
            Proposal { way, rays, prepared, twin }
        })
    }

    /// What a device proposes, before anything is repaired; `None` where it leaves all to the CPU.
    fn found(&self, gpu: &Arc<Gpu>) -> Option<Vec<u32>> {
        let device = Device::Gpu(Arc::clone(gpu));
        let mut tracer = device.tracer(&self.prepared, Outputs::default()).unwrap().tracer;
        let (backend, mut hits) = (tracer.backend().unwrap(), Hits::default());
        backend.propose(&self.rays, &Control::default(), &mut hits).unwrap()?;
        Some(counted(&self.prepared, &self.rays, hits.id))
    }
}

/// What a device proposes for a case: never what is not true, and what its twin does.
fn propose(case: &Case, gpu: &Arc<Gpu>, tally: &mut Tally) -> Vec<Failure> {
    let mut failures = Vec::new();
    let is_ieee = gpu.is_ieee(Kernel::Certified).unwrap();
    for proposal in Proposal::all(case) {
        let Proposal { way, rays, prepared, twin } = &proposal;
        let mut fail = |who: &str, what: String| {
            let command = replay(case);
            failures.push(case.failure(&format!("{who} proposes, {way}"), what, command));
        };
        let (on_cpu, found) = (of_cpu(prepared, rays), proposal.found(gpu));
        if let Some(found) = &found {
            tally.on_device += found.len();
            compare(twin, found, is_ieee).into_iter().for_each(|what| fail("the device", what));
        }
        // Where a device has no way for so many objects, the CPU decides.
        let found = found.unwrap_or_else(|| on_cpu.clone());
        // Rays side by side may leave more open, or see more.
        differing(twin, &on_cpu, false).into_iter().for_each(|what| fail("the CPU", what));
        tally.rays += found.len();
        tally.open += n_open(&found);
        let (judged, places) = match rays {
            Rays::Pixels(pixels) => case.judged_in(pixels),
            Rays::List(rays) => ((0..rays.len()).collect(), (0..rays.len()).collect()),
        };
        let truth = if *way == "list" { &case.of_list } else { &case.of_pixels };
        for (i, at) in judged.into_iter().zip(places) {
            for (who, ids) in [("the device", &found), ("the twin", twin), ("the CPU", &on_cpu)] {
                if ids[at] != UNDECIDED && ids[at] != truth[i].id {
                    fail(who, format!("ray {at}: {} instead of {}", ids[at] as i32, truth[i].id));
                }
            }
        }
    }
    failures
}

/// Pixels of a case with their samples, and the bytes that a device's twin has for them in light.
struct LitPixels {
    pixels: Pixels,
    n: u32,
    prepared: Arc<Prepared>,
    lighting: CertifiedLighting,
    twin: OnceLock<Vec<u32>>,
}

impl LitPixels {
    /// Those that have light.
    fn all(case: &Case) -> Vec<LitPixels> {
        let mut all = Vec::new();
        for (_, rays) in rays_of(case) {
            let Rays::Pixels(pixels) = rays else { continue };
            for &n in case.colors.keys() {
                let (scene, samples) = (Arc::clone(&case.scene), Rays::Pixels(pixels.samples(n)));
                let prepared = Prepared::new(scene, Kernel::Certified, &samples).unwrap();
                let lighting = certified_lighting(&prepared, &pixels, Samples::nearest(n));
                let prepared = Arc::new(prepared);
                let twin = OnceLock::new();
                all.extend(lighting.map(|lighting| LitPixels {
                    pixels,
                    n,
                    prepared,
                    lighting,
                    twin,
                }));
            }
        }
        all
    }

    /// `None` where a device leaves them to the CPU.
    fn found(&self, gpu: &Arc<Gpu>) -> Option<Vec<u32>> {
        let device = Device::Gpu(Arc::clone(gpu));
        let mut tracer = device.tracer(&self.prepared, Outputs::default()).unwrap().tracer;
        let device = tracer.backend().unwrap();
        let codes = device.light(&self.lighting, &self.pixels, &Control::default()).unwrap();
        codes.map(<[u32]>::to_vec)
    }

    fn twin(&self) -> &[u32] {
        let twin = || light_alone(&self.prepared, &self.lighting, &self.pixels);
        self.twin.get_or_init(twin)
    }
}

/// What a device makes of a case's light: never a byte that is not true, and what its twin does.
fn light(case: &Case, gpu: &Arc<Gpu>, tally: &mut Tally) -> Vec<Failure> {
    let mut failures = Vec::new();
    let is_ieee = gpu.is_ieee(Kernel::Certified).unwrap();
    for lit in LitPixels::all(case) {
        let Some(codes) = lit.found(gpu) else { continue };
        tally.lit += codes.len();
        tally.lit_open += n_open(&codes);
        tally.lit_in_trees += if lit.prepared.hierarchy.is_some() { codes.len() } else { 0 };
        let LitPixels { pixels, n, .. } = &lit;
        let mut fail = |what: String| {
            let who = format!("the device lights, {}, {n} x {n}", rectangle(pixels));
            failures.push(case.failure(&who, what, replay(case)));
        };
        compare(lit.twin(), &codes, is_ieee).into_iter().for_each(&mut fail);
        if case.style(*n, Encoding::Srgb8).background == Background::Shown {
            let (judged, places) = case.judged_in(pixels);
            for (i, at) in judged.into_iter().zip(places) {
                let [r, g, b] = case.colors[n][i].srgb8().map(u32::from);
                if codes[at] != UNDECIDED && codes[at] != (r | g << 8 | b << 16) {
                    fail(format!("pixel {at}: {:06x}, not {r:02x} {g:02x} {b:02x}", codes[at]));
                }
            }
        }
    }
    failures
}

/// What a device proposes for a case, ids and bytes.
fn propose_and_light(case: &Case, gpu: &Arc<Gpu>, tally: &mut Tally) -> Vec<Failure> {
    let mut failures = propose(case, gpu, tally);
    failures.extend(light(case, gpu, tally));
    failures
}

fn propose_all(cases: &[&Case], gpu: &Arc<Gpu>) -> Tally {
    let mut tally = Tally::default();
    let failures: Vec<Failure> =
        cases.iter().flat_map(|case| propose_and_light(case, gpu, &mut tally)).collect();
    assert_none(&failures, cases.len());
    tally
}

#[test]
fn proposals_are_true_and_those_of_the_twin() {
    let gpu = lighting();
    assert!(gpu.arithmetic().unwrap().suits_filter(), "{}", gpu.arithmetic().unwrap());
    let cases = in_turn(setting("KUGELBLITZ_DEVICE", 5) as usize, 1);
    let tally = propose_all(&cases, gpu);
    println!("{tally:?}");
    let Tally { rays, open, on_device, lit, lit_open, lit_in_trees } = tally;
    assert!(cases.len() == 1 || on_device > rays / 2 && open > rays / 50, "{tally:?}");
    assert!(cases.len() == 1 || lit > 1000 && lit_open < lit, "{tally:?}");
    assert!(cases.len() == 1 || lit_in_trees > 1000, "{tally:?}");
}

#[test]
fn the_comparison_of_proposals_sees_what_it_is_for() {
    let twin = [UNDECIDED, 0, 1, 2, 1, 0];
    assert_eq!(compare(&twin, &twin, true), None);
    // A ray, what it becomes, and whether other arithmetic than the CPU's is no excuse.
    for (i, id, is_seen_anywhere) in
        [(0, 1, false), (2, UNDECIDED, false), (2, 0, true), (1, 1, true), (3, 1, true)]
    {
        let mut found = twin;
        found[i] = id;
        assert!(compare(&twin, &found, true).is_some(), "{i}: {id}");
        assert_eq!(compare(&twin, &found, false).is_some(), is_seen_anywhere, "{i}: {id}");
    }
    assert!(compare(&twin, &[UNDECIDED; 6], false).is_some());
}

// ---------------------------------------------------------------------------------------------
// Drivers

/// Drivers of other arithmetic, for which spoiled shaders stand, show the same; those whose arithmetic the filter's bounds
/// allow propose nothing that is not true.
#[test]
fn drivers_of_other_arithmetic() {
    type Spoil = fn(&[u32]) -> Vec<u32>;
    let drivers: [(&str, Spoil); 5] = [
        ("contracts", spoiled::contracts),
        ("reassociates", spoiled::reassociates),
        ("flushes", spoiled::flushes),
        ("rounds sums badly", spoiled::rounds_sums_badly),
        ("rounds quotients as it may", spoiled::rounds_quotients_as_allowed),
    ];
    let mut n_suited = 0;
    for (first, (name, spoil)) in drivers.into_iter().enumerate() {
        // The stand-in needs f64.
        if name == "contracts" && !gpu().facts.f64 {
            continue;
        }
        let cases = in_turn(3 * setting("KUGELBLITZ_DEVICE", 5) as usize, first);
        let gpu = Arc::new(opened().always_lights().edit_spirv(spoil));
        println!("{name}");
        check_all(&cases, &Device::Gpu(Arc::clone(&gpu)));
        if gpu.arithmetic().unwrap().suits_filter() {
            n_suited += 1;
            println!("{:?}", propose_all(&cases, &gpu));
        }
    }
    assert!(n_suited >= 2, "{n_suited}");
}

// ---------------------------------------------------------------------------------------------
// Kernels without a proof

/// A device that lights each scene by itself.
pub fn lighting() -> &'static Arc<Gpu> {
    static LIGHTING: OnceLock<Arc<Gpu>> = OnceLock::new();
    LIGHTING.get_or_init(|| Arc::new(opened().always_lights()))
}

fn bits(colors: &[[f32; 3]]) -> Vec<[u32; 3]> {
    colors.iter().map(|rgb| rgb.map(f32::to_bits)).collect()
}

/// Where a device with the CPU's arithmetic gives other bits than that for a case, in hits or in light. Of another one
/// nothing is promised.
fn plain(case: &Case, kernel: Kernel, gpu: &Arc<Gpu>, n_lit: &mut u64) -> Vec<Failure> {
    let mut failures = Vec::new();
    let mut fail = |way: String, what: String| {
        let command = replay(case);
        failures.push(case.failure(&format!("{}, {way}", kernel.name()), what, command));
    };
    let devices = [Device::Cpu, Device::Gpu(Arc::clone(gpu))];
    let mut sessions = devices.map(|device| Session::new(Arc::clone(&case.scene), device, kernel));
    let (control, wants) = (Control::default(), Outputs { surface: true, level: true });
    let is_ieee = gpu.is_ieee(kernel).unwrap();
    for (way, rays) in rays_of(case) {
        let [on_cpu, on_gpu] = sessions.each_mut().map(|session| {
            let mut hits = Hits::default();
            session.trace(&rays, wants, &control, &mut hits).unwrap();
            case.assert_counted(&hits, rays.len(), true);
            let of_stage = if kernel == Kernel::Double { hits.counts.f64 } else { hits.counts.f32 };
            assert_eq!(of_stage, rays.len() as u64, "{}", kernel.name());
            hits
        });
        if let Some(what) = broken(kernel, &on_cpu, &on_gpu) {
            fail(format!("hits of {way}"), what);
        }
        let Rays::Pixels(pixels) = rays else { continue };
        // As large as what is seen is far away.
        let camera = case.scene.camera.as_ref().unwrap();
        let depth = camera.position.distance(camera.look_at);
        for (n, epsilon) in [(1, 0.0), (1, 0.1 * depth), (2, 1e-6 * depth)] {
            if n > 1 && pixels.len() > 1000 {
                continue;
            }
            let style = Style { epsilon, ..case.style(n, Encoding::Linear) };
            let [on_cpu, on_gpu] = sessions.each_mut().map(|session| {
                let (kept, rendered) = session.keep(&pixels, style, wants, &control).unwrap();
                (bits(&<[f32; 3]>::all(kept.colors).unwrap()), rendered)
            });
            *n_lit += on_gpu.1.colors.device;
            let differs = |&i: &usize| is_ieee && on_cpu.0[i] != on_gpu.0[i];
            if let Some(i) = (0..pixels.len()).find(differs) {
                let (cpu, gpu) = (on_cpu.0[i], on_gpu.0[i]);
                let what = format!("pixel {i}: {gpu:x?}, on the CPU {cpu:x?}");
                fail(format!("light of {}, {n} x {n}, {epsilon:e}", rectangle(&pixels)), what);
            }
        }
    }
    failures
}

/// The kernels that a device runs.
fn plain_kernels(gpu: &Gpu) -> impl Iterator<Item = Kernel> {
    PLAIN.into_iter().filter(|&kernel| gpu.facts.check_kernel(kernel).is_ok())
}

#[test]
fn plain_kernels_are_those_of_the_cpu() {
    let (gpu, mut n_lit, mut failures) = (lighting(), 0, Vec::new());
    let cases = in_turn(2 * setting("KUGELBLITZ_DEVICE", 5) as usize, 2);
    for case in &cases {
        for kernel in plain_kernels(gpu) {
            failures.extend(plain(case, kernel, gpu, &mut n_lit));
        }
    }
    println!("{n_lit} colours of a device in {} scenes", cases.len());
    assert_none(&failures, cases.len());
    assert!(cases.len() == 1 || n_lit > 1000, "{n_lit}");
}

// ---------------------------------------------------------------------------------------------
// Mistakes in shaders

/// Says whether a device gives something else than it should.
type Look<'a> = Box<dyn Fn(&Arc<Gpu>) -> bool + 'a>;

/// Looks at what the kernel with a proof gives for a case.
fn looks_at_certified(case: &Case) -> Vec<Look<'static>> {
    let mut looks: Vec<Look> = Vec::new();
    for proposal in Proposal::all(case) {
        looks.push(Box::new(move |gpu| {
            proposal.found(gpu).is_some_and(|found| found != proposal.twin)
        }));
    }
    for lit in LitPixels::all(case) {
        looks.push(Box::new(move |gpu| lit.found(gpu).is_some_and(|codes| codes != lit.twin())));
    }
    looks
}

/// What a shader's text is changed to, and all texts that were compiled.
#[derive(Default)]
struct Editor {
    mistake: Mutex<Option<[String; 2]>>,
    texts: Mutex<Vec<String>>,
}

/// Each mistake of `shaders.toml` is seen, by one of these cases at least; none of them sees one in what is right. Only what has a
/// shader with the mistake in it is looked at.
#[test]
fn mistakes_in_shaders_are_seen() {
    let list: toml::Table = text_of("tests/device/matrix/shaders.toml").parse().expect("a list");
    let [certified, unproven] = ["certified", "plain"].map(|cases| {
        let names = list[cases].as_array().expect("names").iter();
        names.map(|name| named(name.as_str().expect("a name"))).collect::<Vec<Case>>()
    });
    let editor = Arc::new(Editor::default());
    let edits = Arc::clone(&editor);
    let gpu = opened().always_lights().edit_shaders(move |wgsl| {
        edits.texts.lock().unwrap().push(wgsl.into());
        match &*edits.mistake.lock().unwrap() {
            Some([find, replace]) => wgsl.replace(find, replace),
            None => wgsl.into(),
        }
    });
    let gpu = Arc::new(gpu);
    // Each with its kernel and the shaders that it runs.
    let mut looks: Vec<(Kernel, Look, Vec<String>)> = Vec::new();
    let kernels = plain_kernels(&gpu).chain([Kernel::Certified]);
    for kernel in kernels.filter(|&kernel| gpu.is_ieee(kernel).unwrap()) {
        let all: Vec<Look> = match kernel {
            Kernel::Certified => certified.iter().flat_map(looks_at_certified).collect(),
            _ => {
                let look = |case| {
                    let look = move |gpu: &_| !plain(case, kernel, gpu, &mut 0).is_empty();
                    Box::new(look) as Look
                };
                unproven.iter().map(look).collect()
            }
        };
        for look in all {
            gpu.forget_programs();
            assert!(!look(&gpu), "{}", kernel.name());
            looks.push((kernel, look, std::mem::take(&mut *editor.texts.lock().unwrap())));
        }
    }
    let mut unseen = Vec::new();
    for mistake in list["mistake"].as_array().expect("mistakes") {
        let text = |key: &str| mistake[key].as_str().expect("a text").to_string();
        let [name, find, replace] = ["name", "find", "replace"].map(text);
        *editor.mistake.lock().unwrap() = Some([find.clone(), replace]);
        for name_of_kernel in mistake["kernels"].as_array().expect("kernels") {
            let kernel = name_of_kernel.as_str().expect("a kernel");
            let mut of_kernel =
                looks.iter().filter(|(other, ..)| other.name() == kernel).peekable();
            if of_kernel.peek().is_none() {
                continue;
            }
            let has_it = |texts: &[String]| texts.iter().any(|text| text.contains(&find));
            let looks: Vec<&Look> =
                of_kernel.filter(|(.., texts)| has_it(texts)).map(|(_, look, _)| look).collect();
            gpu.forget_programs();
            if !looks.iter().any(|look| look(&gpu)) {
                unseen.push(format!("{kernel}: {name}, in the shaders of {} looks", looks.len()));
            }
        }
    }
    assert!(unseen.is_empty(), "{unseen:#?}");
    assert!(!looks.is_empty() || !gpu.is_ieee(Kernel::Certified).unwrap());
}
