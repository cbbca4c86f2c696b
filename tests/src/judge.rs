//! Traces a scene and judges the result ray by ray against exact arithmetic. What is wrong comes
//! back as text with a case to paste, so that sabotage tests can ask for it.

use std::fmt::Write as _;
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::control::Control;
use kugelblitz::cpu::CpuTracer;
use kugelblitz::exact::{ExactHit, ExactPixels, ExactRay, Shape, nearest};
use kugelblitz::gpu::{Gpu, GpuTracer};
use kugelblitz::prepare::Prepared;
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Hits, Kernel, Rays, StageCounts, Wants};
use kugelblitz::tracer::Tracer;

/// Surfaces and stages.
pub const ALL: Wants = Wants { surface: true, level: true };

/// The result of one kernel on the CPU, or on `gpu`. All rays begin in f32, so that this is what is
/// judged; where the program begins in f64, its result is seen to be the same.
pub fn trace(scene: &Arc<Scene>, kernel: Kernel, rays: &Rays, gpu: Option<&Arc<Gpu>>) -> Hits {
    let prepared = Arc::new(Prepared::new(Arc::clone(scene), kernel, rays).unwrap());
    let starts_in_f64 = prepared.starts_in_f64();
    let mut tracer: Box<dyn Tracer> = match gpu {
        Some(gpu) => Box::new(GpuTracer::new(Arc::clone(gpu), prepared, ALL).unwrap()),
        None => Box::new(CpuTracer::new(prepared, ALL)),
    };
    let (control, mut hits) = (Control::default(), Hits::default());
    let timing = tracer.propose(rays, &control, &mut hits).unwrap();
    tracer.certify(rays, &control, &mut hits, timing).unwrap();
    if starts_in_f64 {
        let mut in_f64 = Hits::default();
        tracer.trace(rays, &control, &mut in_f64).unwrap();
        assert_eq!(in_f64.counts.f32, 0);
        assert!(in_f64.id == hits.id && in_f64.t == hits.t && in_f64.normal == hits.normal);
    }
    hits
}

/// The rays in exact numbers.
pub struct ExactRays<'a> {
    rays: &'a Rays,
    pixels: Option<ExactPixels>,
}

impl<'a> ExactRays<'a> {
    pub fn new(rays: &'a Rays) -> Self {
        let pixels = match rays {
            Rays::Pixels(pixels) => Some(ExactPixels::new(pixels)),
            Rays::List(_) => None,
        };
        ExactRays { rays, pixels }
    }

    pub fn ray(&self, index: usize) -> ExactRay {
        match (self.rays, &self.pixels) {
            (Rays::Pixels(pixels), Some(exact)) => {
                let (x, y) = pixels.xy(index);
                exact.ray(x, y)
            }
            (Rays::Pixels(_), None) => unreachable!("made in new"),
            (Rays::List(rays), _) => ExactRay::new(&rays[index]),
        }
    }
}

/// Ids and shapes of all objects.
pub fn objects(scene: &Scene) -> Vec<(u32, Shape)> {
    (1..=scene.n_objects() as u32).map(|id| (id, Shape::from(scene.object(id).unwrap()))).collect()
}

/// What was judged.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    pub rays: u64,
    pub hits: u64,
    pub normals: u64,
    pub counts: StageCounts,
}

impl Tally {
    pub fn add(&mut self, other: Tally) {
        self.rays += other.rays;
        self.hits += other.hits;
        self.normals += other.normals;
        self.counts.add(other.counts);
    }
}

/// Every id and every `t` must be the exact one (`t` rounded to the nearest f32), and the normal
/// of every `normal_step`-th ray, component by component, too.
pub fn judge(scene: &Scene, rays: &Rays, hits: &Hits, normal_step: usize) -> Result<Tally, String> {
    let n = rays.len();
    if [hits.id.len(), hits.t.len(), hits.normal.len(), hits.level.len()] != [n; 4] {
        return Err(format!("{n} rays, but {} ids, {} t", hits.id.len(), hits.t.len()));
    }
    if hits.counts.total() != n as u64 {
        return Err(format!("{n} rays, but {:?}", hits.counts));
    }
    let objects = objects(scene);
    let exact_rays = ExactRays::new(rays);
    let mut tally = Tally { rays: n as u64, counts: hits.counts, ..Tally::default() };
    for i in 0..n {
        let ray = exact_rays.ray(i);
        let exact = nearest(&ray, objects.iter().copied());
        judge_ray(hits, i, exact.as_ref(), || {
            if i % normal_step != 0 {
                return None;
            }
            tally.normals += u64::from(exact.is_some());
            let hit = exact.as_ref()?;
            let normal = hit.normal(&ray, &objects[hit.id as usize - 1].1)?;
            Some(normal.map(|component| component.to_f32()))
        })
        .map_err(|what| format!("{what}\n{}", paste(scene, rays, i)))?;
        tally.hits += u64::from(exact.is_some());
    }
    Ok(tally)
}

fn judge_ray(
    hits: &Hits,
    i: usize,
    exact: Option<&ExactHit>,
    normal: impl FnOnce() -> Option<[f32; 3]>,
) -> Result<(), String> {
    let id = exact.map_or(0, |hit| hit.id);
    if hits.id[i] != id {
        return Err(format!("id {} instead of {id}, level {}", hits.id[i], hits.level[i]));
    }
    let t = exact.map_or(f32::INFINITY, ExactHit::t_f32);
    if hits.t[i].to_bits() != t.to_bits() {
        return Err(format!("t {:e} instead of {t:e}, level {}", hits.t[i], hits.level[i]));
    }
    if let Some(normal) = normal() {
        let bits = |normal: [f32; 3]| normal.map(f32::to_bits);
        if bits(hits.normal[i]) != bits(normal) {
            return Err(format!("normal {:?} instead of {normal:?}", hits.normal[i]));
        }
    }
    Ok(())
}

fn numbers(v: DVec3) -> String {
    // Debug prints the shortest text that reads back as the same f64.
    format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z)
}

/// The scene as a file, and the ray.
pub fn paste(scene: &Scene, rays: &Rays, index: usize) -> String {
    let mut text = String::from("# scene\n");
    for sphere in &scene.spheres {
        let (center, radius) = (numbers(sphere.center), sphere.radius);
        let _ = writeln!(
            text,
            "[[sphere]]\ncenter = {center}\nradius = {radius:?}\ncolor = \"#ffffff\""
        );
    }
    for plane in &scene.planes {
        let (point, normal) = (numbers(plane.point), numbers(plane.normal));
        let _ =
            writeln!(text, "[[plane]]\npoint = {point}\nnormal = {normal}\ncolor = \"#808080\"");
    }
    let _ = match rays {
        Rays::List(rays) => writeln!(
            text,
            "# ray {index} of a list of {}: --ray {}",
            rays.len(),
            [rays[index].origin, rays[index].direction]
                .iter()
                .flat_map(|v| v.to_array())
                .map(|x| format!("{x:?}"))
                .collect::<Vec<_>>()
                .join(",")
        ),
        Rays::Pixels(pixels) => {
            writeln!(text, "# pixel {:?} of {pixels:?}", pixels.xy(index))
        }
    };
    text
}
