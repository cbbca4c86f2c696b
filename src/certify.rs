//! What follows the certified kernel's f32 stage: f64 with the same filter, then exact arithmetic.
//! Undecided rays flow one way and never loop back.

use std::collections::{HashMap, HashSet};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use glam::DVec3;
use rayon::prelude::*;

use crate::camera::Pixels;
use crate::control::Control;
use crate::error::Result;
use crate::exact::{ExactHit, ExactPixels, ExactRay, Shape, nearest, sphere_numbers, visible_root};
use crate::guard::{self, Guard, InputError};
use crate::host;
use crate::kernel::RayOf;
use crate::kernel::certified::{
    GuardOf, Nearness, UNDECIDED, half_chord_radius, normalized, plane_nearness_at, sphere_nearness,
};
use crate::prepare::{Hierarchy, Prepared, Seen, exponent_of, scale_by_power_of_two};
use crate::scene::{Object, Plane, Scene, Sphere};
use crate::trace::{Hits, Kernel, Level, Ray, Rays, StageCounts, Timing, Wants};
use crate::tree::TreeRay;
use crate::vec3::{Vec3, dot3};

/// Largest error of an f64 normal before it is rounded to f32: with the rounding itself, `√3·2⁻²⁵`,
/// it stays below `2⁻²³`, also if it were twice as large; not four times.
const NORMAL_TOLERANCE: f64 = 1.0 / (1u64 << 25) as f64;
const _: () = assert!(NORMAL_TOLERANCE + 1.7321 / (1u64 << 25) as f64 <= 1.0 / (1u64 << 23) as f64);

/// Rays that one thread takes at a time.
const RAYS_PER_CHUNK: usize = 1024;

/// Decides what `prepared`'s kernel left open and fills in `t` and normals, for the certified
/// kernel; for the others it only counts.
pub fn finish(
    prepared: &Prepared,
    rays: &Rays,
    wants: Wants,
    control: &Control,
    hits: &mut Hits,
    mut timing: Timing,
) -> Result<Timing> {
    let n_rays = rays.len() as u64;
    hits.counts = StageCounts { f32: n_rays, ..StageCounts::default() };
    match prepared.kernel {
        Kernel::Lecture | Kernel::Stable => return Ok(timing),
        Kernel::Double => {
            hits.counts = StageCounts { f64: n_rays, ..StageCounts::default() };
            hits.level.fill(Level::F64 as u8);
            return Ok(timing);
        }
        Kernel::Certified => {}
    }
    let stage = Stage::new(prepared, rays);
    let start = Instant::now();
    let listed = || {
        Ok((0..).zip(&hits.id).filter(|&(_, &id)| id == UNDECIDED).map(|(ray, _)| ray).collect())
    };
    let undecided = undecided(prepared, rays, listed)?;
    for &ray in &undecided {
        hits.id[ray as usize] = UNDECIDED;
    }
    if wants.surface {
        stage.fill_surfaces(control, hits)?;
    }
    timing.refine = start.elapsed();

    stage.decide(&undecided, wants, control, &mut timing, |ray, settled| {
        put(settled, ray as usize, wants, hits);
    })?;
    Ok(timing)
}

/// The rays that f64 or exact arithmetic must decide, ascending: those that the backend left open,
/// which `listed` gives, and those whose f32 proposal counts for nothing, as its bounds don't hold or
/// as `t` could leave f32's range because the direction is very short or long.
///
/// # Errors
/// Those of `listed`.
pub fn undecided(
    prepared: &Prepared,
    rays: &Rays,
    listed: impl FnOnce() -> Result<Vec<u32>>,
) -> Result<Vec<u32>> {
    if prepared.kernel != Kernel::Certified {
        return Ok(Vec::new());
    }
    if !prepared.in_range {
        return Ok((0..rays.len() as u32).collect());
    }
    let mut undecided = listed()?;
    if let Rays::List(rays) = rays {
        let is_ordinary = |ray: &Ray| {
            exponent_of(ray.direction).abs() <= guard::LARGEST_EXPONENT
                && ray.direction != DVec3::ZERO
        };
        undecided.extend((0..).zip(rays).filter(|(_, ray)| !is_ordinary(ray)).map(|(at, _)| at));
        undecided.sort_unstable();
        undecided.dedup();
    }
    Ok(undecided)
}

/// The object of a ray that f32 left undecided.
#[cfg(feature = "view")]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Decided {
    /// Index of the ray.
    pub ray: u32,
    /// Its object; 0 is the background.
    pub id: u32,
    /// The stage that decided it.
    pub level: Level,
}

/// Decides some of the rays that [`undecided`] gave, for those who show a picture meanwhile.
///
/// # Errors
/// [`crate::Error::Interrupted`] when `control` was cancelled.
#[cfg(feature = "view")]
pub fn decide(
    prepared: &Prepared,
    rays: &Rays,
    undecided: &[u32],
    control: &Control,
) -> Result<Vec<Decided>> {
    let mut all = Vec::with_capacity(undecided.len());
    let stage = Stage::new(prepared, rays);
    let wants = Wants::default();
    stage.decide(undecided, wants, control, &mut Timing::default(), |ray, settled| {
        all.push(Decided { ray, id: settled.id, level: settled.level });
    })?;
    Ok(all)
}

/// Undecided rays that are looked at before they are settled.
const RAYS_AT_ONCE: usize = 1 << 16;

/// Candidates that are held for them together: every object may be a candidate of every ray.
const MOST_HELD: usize = 1 << 22;

fn put(settled: Settled, index: usize, wants: Wants, hits: &mut Hits) {
    hits.id[index] = settled.id;
    if wants.surface {
        hits.t[index] = settled.t;
        hits.normal[index] = settled.normal;
    }
    if wants.level {
        hits.level[index] = settled.level as u8;
    }
    hits.counts.f32 -= 1;
    match settled.level {
        Level::Exact => hits.counts.exact += 1,
        _ => hits.counts.f64 += 1,
    }
}

fn each_ray<T: Send>(
    rays: &[u32],
    control: &Control,
    work: impl Fn(usize) -> T + Sync,
) -> Result<Vec<T>> {
    let one = |checked: &mut Result<()>, &ray: &u32| {
        std::mem::replace(checked, Ok(()))?;
        control.check().map(|()| work(ray as usize))
    };
    rays.par_iter().map_init(host::check, one).collect()
}

fn each_pair<A: Send, T: Send>(
    rays: &[u32],
    others: Vec<A>,
    control: &Control,
    work: impl Fn(usize, A) -> T + Sync,
) -> Result<Vec<T>> {
    let one = |checked: &mut Result<()>, (&ray, other): (&u32, A)| {
        std::mem::replace(checked, Ok(()))?;
        control.check().map(|()| work(ray as usize, other))
    };
    rays.par_iter().zip(others).map_init(host::check, one).collect()
}

/// What the f64 filter says of a ray.
enum Decision {
    /// The object, 0 for the background.
    Decided(u32),
    /// Any of these, or none.
    Open(Vec<u32>),
}

impl Decision {
    /// Itself, where `room` has places for its candidates: it takes them. What is not held is
    /// looked for again.
    fn hold(self, room: &AtomicUsize) -> Option<Decision> {
        let Decision::Open(candidates) = &self else { return Some(self) };
        let take = |left: usize| left.checked_sub(candidates.len());
        let fits = room.fetch_update(Ordering::Relaxed, Ordering::Relaxed, take).is_ok();
        fits.then_some(self)
    }
}

/// One ray's result.
struct Settled {
    id: u32,
    t: f32,
    normal: [f32; 3],
    level: Level,
}

/// `t` and the normal of a hit.
type Surface = (f32, [f32; 3]);

/// The rays, in f64 and exactly.
enum StageRays<'a> {
    Pixels(&'a Pixels, Box<ExactPixels>),
    List(&'a [Ray]),
}

/// The stages after f32 for one scene and its rays.
struct Stage<'a> {
    scene: &'a Scene,
    rays: StageRays<'a>,
    /// Finds the spheres that are not in `rest`.
    hierarchy: Option<&'a Hierarchy>,
    /// For pixels: `k` of each sphere for the camera's position; none with a hierarchy.
    ks: Vec<K>,
    /// The same of [`Hierarchy::rest`], where `k` may be hard to come by.
    rest_ks: HashMap<u32, K>,
    /// Whether the f64 bounds hold for these rays.
    usable: bool,
    input: InputError,
    /// [`MOST_HELD`]
    most_held: usize,
}

/// A ray in f64: `reference + o + 2^−exponent·t·direction`.
struct RayF64 {
    /// The camera's position, or the origin of a list's ray.
    reference: DVec3,
    /// Its origin is the zero vector but for parallel rays.
    ray: RayOf<f64>,
    exponent: i32,
}

impl RayF64 {
    /// `p − reference − o`, in this order: the sum of the latter two would lose what they differ in.
    fn to_point(&self, point: DVec3) -> Vec3<f64> {
        Vec3::from(point - self.reference) - self.ray.origin
    }

    /// `ℓ` of [`guard`]: a bound of the distance of a point.
    fn distance(&self, point: DVec3) -> f64 {
        guard::length_bound(point - self.reference) + self.origin_length()
    }

    fn origin_length(&self) -> f64 {
        guard::length_bound(DVec3::from_array(self.ray.origin.0))
    }
}

impl<'a> Stage<'a> {
    fn new(prepared: &'a Prepared, rays: &'a Rays) -> Stage<'a> {
        let scene = &*prepared.scene;
        let hierarchy = prepared.hierarchy.as_ref();
        let k = |sphere| K::new(prepared.reference, sphere);
        let (rays, ks, usable, input) = match rays {
            Rays::Pixels(pixels) => (
                StageRays::Pixels(pixels, Box::new(ExactPixels::new(pixels))),
                match hierarchy {
                    None => scene.spheres.iter().map(k).collect(),
                    Some(_) => Vec::new(),
                },
                pixels.is_in_range(),
                guard::input_of(pixels.view.lens),
            ),
            Rays::List(rays) => (StageRays::List(rays), Vec::new(), true, guard::LIST_F64),
        };
        let rest = hierarchy.map_or(&[][..], |hierarchy| &hierarchy.rest);
        let rest_ks = match rays {
            StageRays::Pixels(..) => {
                rest.iter().map(|&id| (id, k(&scene.spheres[id as usize - 1]))).collect()
            }
            StageRays::List(_) => HashMap::new(),
        };
        let most_held = MOST_HELD;
        Stage { scene, rays, hierarchy, ks, rest_ks, usable, input, most_held }
    }

    fn ray_f64(&self, index: usize) -> RayF64 {
        match self.rays {
            StageRays::Pixels(pixels, _) => {
                let (x, y) = pixels.xy(index);
                let ray = pixels.ray_from_position(x, y);
                RayF64 { reference: pixels.view.position, ray, exponent: 0 }
            }
            StageRays::List(rays) => {
                let Ray { origin, direction } = rays[index];
                let exponent = exponent_of(direction);
                let direction = scale_by_power_of_two(direction, -exponent);
                let ray = RayOf::new(Vec3::ZERO, Vec3::ZERO, direction.into());
                RayF64 { reference: origin, ray, exponent }
            }
        }
    }

    fn exact_ray(&self, index: usize) -> ExactRay {
        match &self.rays {
            StageRays::Pixels(pixels, exact) => {
                let (x, y) = pixels.xy(index);
                exact.ray(x, y)
            }
            StageRays::List(rays) => ExactRay::new(&rays[index]),
        }
    }

    /// Decides `undecided` rays: in f64, and what is left exactly.
    fn decide(
        &self,
        undecided: &[u32],
        wants: Wants,
        control: &Control,
        timing: &mut Timing,
        mut put: impl FnMut(u32, Settled),
    ) -> Result<()> {
        for rays in undecided.chunks(RAYS_AT_ONCE) {
            let start = Instant::now();
            let room = AtomicUsize::new(self.most_held);
            let decisions = each_ray(rays, control, |ray| self.decide_f64(ray).hold(&room))?;
            timing.refine += start.elapsed();

            let start = Instant::now();
            let settled = each_pair(rays, decisions, control, |ray, decision| {
                match decision.unwrap_or_else(|| self.decide_f64(ray)) {
                    Decision::Decided(id) => self.settle(ray, &[id], Level::F64, wants),
                    Decision::Open(candidates) => {
                        self.settle(ray, &candidates, Level::Exact, wants)
                    }
                }
            })?;
            for (&ray, settled) in rays.iter().zip(settled) {
                put(ray, settled);
            }
            timing.decide += start.elapsed();
        }
        Ok(())
    }

    /// The filter again, in f64: keeps the candidates that could be nearest.
    fn decide_f64(&self, index: usize) -> Decision {
        let ray = self.ray_f64(index);
        if ray.ray.direction == Vec3::ZERO {
            return Decision::Decided(0);
        }
        let mut candidates = Candidates::default();
        let mut look = |id: u32| {
            if let Some(object) = self.scene.object(id) {
                candidates.add(id, self.nearness(&ray, id, object));
            }
            candidates.nearest_low
        };
        match self.hierarchy {
            Some(hierarchy) if self.usable => {
                let planes = self.scene.spheres.len()..self.scene.n_objects();
                for id in planes.map(|index| index as u32 + 1) {
                    look(id);
                }
                for &id in &hierarchy.rest {
                    look(id);
                }
                self.search(hierarchy, index, &ray, look);
            }
            _ => {
                for id in 1..=self.scene.n_objects() as u32 {
                    look(id);
                }
            }
        }
        match self.without_repeats(candidates.finish()).as_slice() {
            [] => Decision::Decided(0),
            [(id, root)] if self.to_f32(&ray, *root).is_some() => Decision::Decided(*id),
            open => Decision::Open(open.iter().map(|(id, _)| *id).collect()),
        }
    }

    /// Without candidates that equal an earlier one: of equals, the lowest id wins.
    fn without_repeats(
        &self,
        mut candidates: Vec<(u32, Nearness<f64>)>,
    ) -> Vec<(u32, Nearness<f64>)> {
        if candidates.len() > 1 {
            let mut seen = HashSet::with_capacity(candidates.len());
            candidates
                .retain(|(id, _)| self.scene.object(*id).is_some_and(|o| seen.insert(bits(o))));
        }
        candidates
    }

    /// Shows `look` the ids of the spheres that the ray may hit, nearer ones first; it returns a lower
    /// bound of the nearness that is still of interest.
    fn search(
        &self,
        hierarchy: &Hierarchy,
        index: usize,
        ray: &RayF64,
        mut look: impl FnMut(u32) -> f64,
    ) {
        if let (Some(seen), StageRays::Pixels(pixels, _)) = (&hierarchy.seen, &self.rays) {
            let Seen { footprints, far } = seen;
            let (x, y) = pixels.xy(index);
            footprints.visit(footprints.cells([x, y], [x, y]), f32::INFINITY, |_, place| {
                guard::round_up(t_bound(ray, look(far[place].id)))
            });
            return;
        }
        let tree = &*hierarchy.tree;
        let origin = ray.reference - tree.reference;
        let direction = DVec3::from_array(ray.ray.direction.0);
        tree.visit(&TreeRay { origin, direction }, |place| {
            t_bound(ray, look(tree.order[place] + 1))
        });
    }

    fn nearness(&self, ray: &RayF64, id: u32, object: Object) -> Nearness<f64> {
        match object {
            _ if !self.usable => Nearness::OPEN,
            Object::Sphere(sphere) if sphere.radius == 0.0 => Nearness::MISS,
            Object::Plane(plane) if plane.normal == DVec3::ZERO => Nearness::MISS,
            Object::Sphere(sphere) => match self.sphere_foot(ray, id, sphere) {
                Some(Foot { l, k, guard, .. }) => {
                    let Guard { inner2, outer2, slack, .. } = guard;
                    let guard = GuardOf { inner2, outer2, slack };
                    let K { value, error } = k;
                    sphere_nearness(&ray.ray, l, &guard, value, error, &guard::widening_f64())
                }
                None => Nearness::OPEN,
            },
            Object::Plane(plane) => self.plane_nearness(ray, plane).unwrap_or(Nearness::OPEN),
        }
    }

    fn plane_nearness(&self, ray: &RayF64, plane: &Plane) -> Option<Nearness<f64>> {
        let normal = scale_by_power_of_two(plane.normal, -exponent_of(plane.normal));
        let l = ray.to_point(plane.point);
        let distance = ray.distance(plane.point);
        let n_length = guard::length_bound(normal);
        guard::plane_in_range_f64(distance).then(|| {
            plane_nearness_at(
                &ray.ray,
                dot3(l, normal.into()),
                guard::plane_offset_error(
                    n_length,
                    distance,
                    guard::UNIT_F64,
                    self.input,
                    guard::TINY_F64,
                ),
                normal.into(),
                guard::plane_direction_error(n_length, guard::UNIT_F64, self.input),
                &guard::widening_f64(),
            )
        })
    }

    fn sphere_foot(&self, ray: &RayF64, id: u32, sphere: &Sphere) -> Option<Foot> {
        let r = sphere.radius.abs();
        let distance = ray.distance(sphere.center);
        if !guard::sphere_in_range_f64(r, distance) {
            return None;
        }
        let l = ray.to_point(sphere.center);
        let guard = Guard::new(r, distance, guard::UNIT_F64, self.input);
        let known = self.ks.get(id as usize - 1).or_else(|| self.rest_ks.get(&id));
        let k = match (&self.rays, known) {
            (_, Some(k)) => k.moved(ray, sphere, l),
            (StageRays::Pixels(..), None) => K::new(ray.reference, sphere).moved(ray, sphere, l),
            (StageRays::List(_), None) => K { value: dot3(l, l) - r * r, error: guard.k_error },
        };
        Some(Foot { l, k, r, distance, guard })
    }

    /// The one f32 that both ends of `t` round to, if there is one: then it is the exact root's
    /// nearest f32 as well. `t = 1/(a·w)`, its rounding (`a` 3 + 2δ, product 1, quotient 2.5) once
    /// more below the widening.
    fn to_f32(&self, ray: &RayF64, root: Nearness<f64>) -> Option<f32> {
        let widening = guard::widening_f64();
        let scale = 2f64.powi(-ray.exponent);
        let low = (widening.narrower / (ray.ray.a * root.high) * scale) as f32;
        let high = (widening.wider / (ray.ray.a * root.low) * scale) as f32;
        let safe = root.low > 0.0 && low > 0.0 && high.is_finite() && scale.is_normal();
        (safe && low == high).then_some(low)
    }

    /// `t` and normal in f64, or `None` where their bounds are too wide.
    fn surface_f64(&self, ray: &RayF64, id: u32, object: Object) -> Option<Surface> {
        let root = self.nearness(ray, id, object);
        let t = self.to_f32(ray, root)?;
        let normal = match object {
            Object::Sphere(sphere) => self.sphere_normal(ray, id, sphere)?,
            Object::Plane(plane) => {
                let normal = scale_by_power_of_two(plane.normal, -exponent_of(plane.normal));
                crate::vec3::facing(normal.into(), ray.ray.direction)
            }
        };
        Some((t, normal.0.map(|component| component as f32)))
    }

    /// The normal from half the chord, where its error is small enough.
    fn sphere_normal(&self, ray: &RayF64, id: u32, sphere: &Sphere) -> Option<Vec3<f64>> {
        let foot = self.sphere_foot(ray, id, sphere)?;
        let RayOf { direction, a, inv_a, .. } = ray.ray;
        let p = foot.l - direction * (dot3(direction, foot.l) * inv_a);
        let m = dot3(p, p);
        let half_chord = |r2: f64| ((r2 - m).max(0.0) * inv_a).sqrt();
        let width = half_chord(foot.guard.outer2) - half_chord(foot.guard.inner2);
        let (r, l) = (foot.r, foot.distance);
        let error = guard::normal_error(r, l, width * a.sqrt(), guard::UNIT_F64, self.input);
        if error > NORMAL_TOLERANCE || foot.k.value.abs() <= foot.k.error {
            return None;
        }
        Some(normalized(half_chord_radius(&ray.ray, foot.l, r, foot.k.value > 0.0)))
    }

    /// Fills in `t` and normal of all rays whose object is known.
    fn fill_surfaces(&self, control: &Control, hits: &mut Hits) -> Result<()> {
        hits.id
            .par_chunks(RAYS_PER_CHUNK)
            .zip(hits.t.par_chunks_mut(RAYS_PER_CHUNK))
            .zip(hits.normal.par_chunks_mut(RAYS_PER_CHUNK))
            .enumerate()
            .try_for_each(|(chunk, ((ids, ts), normals))| {
                control.check()?;
                host::check()?;
                for (i, &id) in ids.iter().enumerate() {
                    if id != 0 && id != UNDECIDED {
                        let surface = self.surface(chunk * RAYS_PER_CHUNK + i, id);
                        (ts[i], normals[i]) = surface.unwrap_or((f32::INFINITY, [0.0; 3]));
                    }
                }
                Ok(())
            })
    }

    /// `t` and normal of a hit that is known to exist: in f64, else exactly.
    fn surface(&self, index: usize, id: u32) -> Option<Surface> {
        let object = self.scene.object(id)?;
        if let Some(surface) = self.surface_f64(&self.ray_f64(index), id, object) {
            return Some(surface);
        }
        let ray = self.exact_ray(index);
        let shape = Shape::from(object);
        let visible = visible_root(&ray, &shape);
        debug_assert!(visible.is_some(), "object {id} was decided for ray {index} but is not hit");
        let (root, side) = visible?;
        Some(exact_surface(&ray, &ExactHit { id, root, side }, &shape))
    }

    /// The nearest of the candidates. One candidate that f64 decided needs no further decision.
    fn settle(&self, index: usize, candidates: &[u32], level: Level, wants: Wants) -> Settled {
        let miss = Settled { id: 0, t: f32::INFINITY, normal: [0.0; 3], level };
        if let (Level::F64, &[id]) = (level, candidates) {
            if id == 0 || !wants.surface {
                return Settled { id, ..miss };
            }
            let surface = self.surface(index, id);
            let (t, normal) = surface.unwrap_or((f32::INFINITY, [0.0; 3]));
            return Settled { id, t, normal, level };
        }
        let ray = self.exact_ray(index);
        let shapes =
            candidates.iter().filter_map(|&id| Some((id, Shape::from(self.scene.object(id)?))));
        match nearest(&ray, shapes) {
            None => miss,
            Some(hit) if !wants.surface => Settled { id: hit.id, ..miss },
            Some(hit) => match self.scene.object(hit.id) {
                Some(object) => {
                    let (t, normal) = exact_surface(&ray, &hit, &Shape::from(object));
                    Settled { id: hit.id, t, normal, level }
                }
                None => miss,
            },
        }
    }
}

/// Objects that could be the nearest.
#[derive(Default)]
struct Candidates {
    nearest_low: f64,
    roots: Vec<(u32, Nearness<f64>)>,
}

impl Candidates {
    fn add(&mut self, id: u32, root: Nearness<f64>) {
        if root.high > 0.0 && root.high >= self.nearest_low {
            self.nearest_low = f64::max(self.nearest_low, root.low);
            self.roots.push((id, root));
        }
    }

    /// Those that still could, in the order of their ids, as ties are decided.
    fn finish(mut self) -> Vec<(u32, Nearness<f64>)> {
        self.roots.retain(|(_, root)| root.high >= self.nearest_low);
        self.roots.sort_unstable_by_key(|(id, _)| *id);
        self.roots
    }
}

/// An upper bound of `t = 1/(a·w)` for a nearness `w` of at least `low`.
fn t_bound(ray: &RayF64, low: f64) -> f64 {
    guard::widening_f64().wider / (ray.ray.a * low)
}

/// `k = l·l − r²` and a bound of its error.
#[derive(Clone, Copy)]
struct K {
    value: f64,
    error: f64,
}

impl K {
    /// In f64 where that is good enough to round `t`, else exactly and rounded once. On the ground
    /// of a huge sphere f64 keeps too few of its digits, and each `t` would need exact arithmetic.
    fn new(origin: DVec3, sphere: &Sphere) -> K {
        if let Some((value, error)) = guard::k_f64(sphere.center - origin, sphere.radius) {
            return K { value, error };
        }
        let eye = ExactRay::new(&Ray { origin, direction: DVec3::X });
        match sphere_numbers(&eye, sphere.center, sphere.radius).map(|n| n.k.to_f64()) {
            Some(value) if value.abs() >= guard::TINY_F64 => {
                K { value, error: guard::UNIT_F64 * value.abs() }
            }
            // 0, or so near it that u/k could overflow: left to exact arithmetic.
            _ => K { value: 0.0, error: f64::MAX },
        }
    }

    /// `k` for the ray's origin, from that for the reference point: the same one where these are one.
    fn moved(self, ray: &RayF64, sphere: &Sphere, l: Vec3<f64>) -> K {
        if ray.ray.origin == Vec3::ZERO {
            return self;
        }
        let from_reference = sphere.center - ray.reference;
        let moved = dot3(ray.ray.origin, Vec3::from(from_reference) + l);
        let distance = guard::length_bound(from_reference);
        let K { value, error } = self;
        K {
            value: value - moved,
            error: guard::moved_k_error(value, error, distance, ray.origin_length()),
        }
    }
}

/// A sphere seen from a ray's origin.
struct Foot {
    l: Vec3<f64>,
    k: K,
    r: f64,
    distance: f64,
    guard: Guard,
}

fn exact_surface(ray: &ExactRay, hit: &ExactHit, shape: &Shape) -> Surface {
    (hit.t_f32(), hit.normal_f32(ray, shape))
}

/// The numbers of an object, the same for equal ones; a plane's radius is one that no sphere has.
fn bits(object: Object) -> [u64; 7] {
    let (at, normal, radius) = match object {
        Object::Sphere(sphere) => (sphere.center, DVec3::ZERO, sphere.radius),
        Object::Plane(plane) => (plane.point, plane.normal, f64::NAN),
    };
    let [x, y, z] = at.to_array().map(f64::to_bits);
    let [nx, ny, nz] = normal.to_array().map(f64::to_bits);
    [x, y, z, nx, ny, nz, radius.to_bits()]
}

#[cfg(test)]
mod tests;
