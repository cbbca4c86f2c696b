//! `t` and normals of many hits side by side: the steps of [`Stage::surface`], each for some hits
//! before the next, so that the compiler finds them side by side. What they leave open goes there.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use std::marker::PhantomData;
use std::ops::Range;

use bytemuck::Pod;

use super::nearness::{K, Place};
use super::surface::{Bounds, Inside, MISS, Outside, PlaneSight, Sight, SphereSight};
use super::{Stage, StageRays};
use crate::control::Control;
use crate::error::Result;
use crate::kernel::RayOf;
use crate::kernel::certified::UNDECIDED;
use crate::vec3::Vec3;

/// Hits or spheres side by side.
pub const LANES: usize = 64;

/// From here on it pays to fill one column after the other.
const MANY: usize = 8;

/// Numbers of a place and of the sights.
const PLACE: usize = size_of::<Place>() / size_of::<f64>();
const SPHERE: usize = size_of::<SphereSight>() / size_of::<f64>();
const PLANE: usize = size_of::<PlaneSight>() / size_of::<f64>();

/// Structs of `N` numbers, number by number.
struct Columns<const N: usize>([[f64; LANES]; N]);

impl<const N: usize> Columns<N> {
    const ZERO: Self = Columns([[0.0; LANES]; N]);

    #[inline(always)]
    fn get<T: Pod>(&self, lane: usize) -> T {
        bytemuck::cast::<[f64; N], T>(std::array::from_fn(|n| self.0[n][lane]))
    }

    #[inline(always)]
    fn set<T: Pod>(&mut self, lane: usize, row: T) {
        let row: [f64; N] = bytemuck::cast(row);
        for n in 0..N {
            self.0[n][lane] = row[n];
        }
    }

    /// Apart from [`Columns::set`], which runs of one hit should not wait for.
    #[inline(never)]
    fn fill<T: Pod>(&mut self, lanes: Range<usize>, row: T) {
        let row: [f64; N] = bytemuck::cast(row);
        for n in 0..N {
            self.0[n][lanes.clone()].fill(row[n]);
        }
    }
}

/// A part of the hits.
pub struct Part<'a, O> {
    /// Index of its first ray.
    pub first: usize,
    pub id: &'a [u32],
    /// What is found of them.
    pub out: O,
}

/// What is found of some hits.
pub trait Output {
    /// Takes a run of neighbours at once where it can, and then adds those that are open.
    fn take_run(&mut self, _: &Stage, _: &Run, _: &mut Vec<usize>) -> bool {
        false
    }
    /// These hit nothing.
    fn miss(&mut self, at: Range<usize>);
    /// Takes hits from a queue, and adds those that are open.
    fn take<S: Sight, const N: usize>(
        &mut self,
        stage: &Stage,
        hits: &Queue<S, N>,
        open: &mut Vec<usize>,
    );
}

/// `t` and normals.
pub struct Surfaces<'a> {
    pub t: &'a mut [f32],
    pub normal: &'a mut [[f32; 3]],
}

/// Neighbours in a row that hit one object.
#[derive(Clone, Copy, Default)]
pub struct Run {
    pub id: u32,
    /// Where in the part they begin.
    pub at: usize,
    pub n: usize,
    /// [`crate::rays::Pixels::offset2`] of the first one, where they are pixels.
    pub offset: (i64, i64),
}

impl Run {
    /// The hit at a place in the part alone.
    fn only(&self, at: usize) -> Run {
        let offset = (self.offset.0 + 2 * (at - self.at) as i64, self.offset.1);
        Run { id: self.id, at, n: 1, offset }
    }
}

/// Completes one part of the hits after the other.
pub struct Completer<'a> {
    stage: &'a Stage<'a>,
    spheres: SphereRuns,
    outside: Queue<Outside, SPHERE>,
    inside: Queue<Inside, SPHERE>,
    on_planes: Queue<PlaneSight, PLANE>,
    /// Places in the part of the hits that f64 leaves open.
    pub open: Vec<usize>,
    /// Of those that a run leaves open.
    in_row: Vec<usize>,
}

impl<'a> Completer<'a> {
    pub fn new(stage: &'a Stage<'a>) -> Box<Completer<'a>> {
        Box::new(Completer {
            stage,
            spheres: SphereRuns::default(),
            outside: Queue::default(),
            inside: Queue::default(),
            on_planes: Queue::default(),
            open: Vec::new(),
            in_row: Vec::new(),
        })
    }

    /// The stage whose hits it completes.
    pub fn stage(&self) -> &'a Stage<'a> {
        self.stage
    }

    /// Fills in `t` and normal of all rays but undecided ones.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled.
    pub fn complete(&mut self, part: &mut Part<Surfaces>, control: &Control) -> Result<()> {
        self.complete_in_f64(part);
        for at in self.open.drain(..) {
            control.check()?;
            let surface = self.stage.surface(part.first + at, part.id[at]);
            (part.out.t[at], part.out.normal[at]) = surface.unwrap_or(MISS);
        }
        Ok(())
    }

    /// Fills in those of all rays whose `t` is 0, one by one.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled.
    pub fn complete_open(&self, part: &mut Part<Surfaces>, control: &Control) -> Result<()> {
        for at in 0..part.id.len() {
            if part.out.t[at] == 0.0 && part.id[at] != UNDECIDED {
                control.check()?;
                let surface = self.stage.surface(part.first + at, part.id[at]);
                (part.out.t[at], part.out.normal[at]) = surface.unwrap_or(MISS);
            }
        }
        Ok(())
    }

    /// As [`Completer::complete`]; what f64 leaves open is in [`Completer::open`].
    pub fn complete_in_f64<O: Output>(&mut self, part: &mut Part<O>) {
        let stage = self.stage;
        let mut at = 0;
        while at < part.id.len() {
            let row = match &stage.rays {
                StageRays::Pixels { pixels, .. } => {
                    let (x, y) = pixels.xy(part.first + at);
                    let n = (pixels.x + pixels.width - x) as usize;
                    Run { id: 0, at, n: n.min(part.id.len() - at), offset: pixels.offset2(x, y) }
                }
                StageRays::List(_) => Run { id: 0, at, n: part.id.len(), offset: (0, 0) },
            };
            self.take_row(row, part);
            at += row.n;
        }
        self.look_at_spheres(part);
        self.outside.complete(stage, part, &mut self.open);
        self.inside.complete(stage, part, &mut self.open);
        self.on_planes.complete(stage, part, &mut self.open);
    }

    fn take_row<O: Output>(&mut self, row: Run, part: &mut Part<O>) {
        let stage = self.stage;
        let end = row.at + row.n;
        let mut at = row.at;
        while at < end {
            let id = part.id[at];
            if id == UNDECIDED {
                at += 1;
                continue;
            }
            if id == 0 {
                let n = run_length(&part.id[at..end]);
                part.out.miss(at..at + n);
                at += n;
                continue;
            }
            let run = Run { id, n: run_length(&part.id[at..end]), ..row.only(at) };
            at += run.n;
            if !stage.usable {
                self.open.extend(run.at..at);
                continue;
            }
            if run.n >= MANY && part.out.take_run(stage, &run, &mut self.in_row) {
                for at in std::mem::take(&mut self.in_row) {
                    self.take_run(run.only(at), part);
                }
            } else if stage.has_one_origin {
                self.take_run(run, part);
            } else {
                (run.at..at).for_each(|at| self.take_run(run.only(at), part));
            }
        }
    }

    /// Hits of one object from one origin.
    fn take_run<O: Output>(&mut self, run: Run, part: &mut Part<O>) {
        let stage = self.stage;
        match (run.id as usize - 1).checked_sub(stage.scene.spheres.len()) {
            Some(plane) => match stage.planes.get(plane) {
                Some(plane) => {
                    let ray = stage.ray_f64(part.first + run.at);
                    let sight = PlaneSight::new(plane, &ray, &stage.bounds);
                    self.on_planes.push(stage, run, sight, part, &mut self.open);
                }
                None => self.open.extend(run.at..run.at + run.n),
            },
            None => {
                self.spheres.runs[self.spheres.n] = run;
                self.spheres.n += 1;
                if self.spheres.n == LANES {
                    self.look_at_spheres(part);
                }
            }
        }
    }

    /// Puts the hits of all runs into their queues.
    fn look_at_spheres<O: Output>(&mut self, part: &mut Part<O>) {
        if self.spheres.n == 0 {
            return;
        }
        let (stage, open) = (self.stage, &mut self.open);
        self.spheres.find_sights(stage, part.first);
        for lane in 0..self.spheres.n {
            let run = self.spheres.runs[lane];
            let sight: SphereSight = self.spheres.sights.get(lane);
            if sight.k > 0.0 {
                self.outside.push(stage, run, Outside(sight), part, open);
            } else if sight.k < 0.0 {
                self.inside.push(stage, run, Inside(sight), part, open);
            } else {
                open.extend(run.at..run.at + run.n);
            }
        }
        self.spheres.n = 0;
    }
}

/// How many ids at the beginning are the same.
pub fn run_length(ids: &[u32]) -> usize {
    // So many are compared at a time.
    const BLOCK: usize = 16;
    let Some(&id) = ids.first() else { return 0 };
    let is_one = |ids: &&[u32]| ids.iter().fold(0, |other, &next| other | (next ^ id)) == 0;
    let n = BLOCK * ids.chunks_exact(BLOCK).take_while(is_one).count();
    n + ids[n..].iter().take_while(|&&next| next == id).count()
}

/// Runs of hits of spheres.
struct SphereRuns {
    n: usize,
    runs: [Run; LANES],
    places: Columns<PLACE>,
    sights: Columns<SPHERE>,
}

impl Default for SphereRuns {
    fn default() -> SphereRuns {
        let runs = [Run::default(); LANES];
        SphereRuns { n: 0, runs, places: Columns::ZERO, sights: Columns::ZERO }
    }
}

impl SphereRuns {
    fn find_sights(&mut self, stage: &Stage, first: usize) {
        let spheres = &stage.scene.spheres[..];
        for lane in 0..self.n {
            let Run { id, at, offset, .. } = self.runs[lane];
            let (reference, origin) = stage.origin(first + at, offset);
            self.places.set(lane, Place::new(&spheres[id as usize - 1], reference, origin));
        }
        let has_k = matches!(stage.rays, StageRays::Pixels { .. });
        let (places, sights, bounds) = (&self.places, &mut self.sights, stage.bounds);
        pulp::Arch::new().dispatch(FindSights { places, has_k, bounds, sights });
        for lane in 0..self.n {
            let is_open = self.sights.get::<SphereSight>(lane).k == 0.0;
            if has_k && is_open {
                let id = self.runs[lane].id;
                let k = stage.known_k(id, &spheres[id as usize - 1]);
                let sight = SphereSight::new(&self.places.get(lane), k, &stage.bounds);
                self.sights.set(lane, sight);
            }
        }
    }
}

struct FindSights<'a> {
    places: &'a Columns<PLACE>,
    /// Whether `k` for the point that places are relative to is of use.
    has_k: bool,
    bounds: Bounds,
    sights: &'a mut Columns<SPHERE>,
}

impl pulp::WithSimd for FindSights<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let FindSights { places, has_k, bounds, sights } = self;
        if has_k {
            for lane in 0..LANES {
                let place = places.get(lane);
                sights.set(lane, SphereSight::new(&place, Some(K::in_f64(&place)), &bounds));
            }
        } else {
            for lane in 0..LANES {
                sights.set(lane, SphereSight::new(&places.get(lane), None, &bounds));
            }
        }
    }
}

/// Hits that are completed together: those of one kind of sight, which has `N` numbers.
pub struct Queue<S, const N: usize> {
    n: usize,
    /// Where they are in the part.
    at: [usize; LANES],
    sights: Columns<N>,
    directions: Columns<3>,
    scales: [f64; LANES],
    kind: PhantomData<S>,
}

impl<S, const N: usize> Default for Queue<S, N> {
    fn default() -> Queue<S, N> {
        let (sights, directions, scales) = (Columns::ZERO, Columns::ZERO, [1.0; LANES]);
        Queue { n: 0, at: [0; LANES], sights, directions, scales, kind: PhantomData }
    }
}

impl<S: Sight, const N: usize> Queue<S, N> {
    /// Takes the hits of a run, and completes those that there is no room for.
    fn push<O: Output>(
        &mut self,
        stage: &Stage,
        mut run: Run,
        sight: S,
        part: &mut Part<O>,
        open: &mut Vec<usize>,
    ) {
        while run.n > 0 {
            if self.n == LANES {
                self.complete(stage, part, open);
            }
            let n = run.n.min(LANES - self.n);
            let lanes = self.n..self.n + n;
            match n {
                ..MANY => lanes.clone().for_each(|lane| self.sights.set(lane, sight)),
                _ => self.sights.fill(lanes.clone(), sight),
            }
            for (k, lane) in lanes.clone().enumerate() {
                self.at[lane] = run.at + k;
            }
            match &stage.rays {
                StageRays::Pixels { camera, .. } => {
                    let (i, j) = run.offset;
                    for (k, lane) in lanes.enumerate() {
                        let ray = camera.camera_ray((i + 2 * k as i64) as f64, j as f64);
                        self.directions.set(lane, ray.direction.0);
                    }
                }
                StageRays::List(_) => {
                    for (k, lane) in lanes.enumerate() {
                        let ray = stage.ray_f64(part.first + run.at + k);
                        let scale = ray.scale();
                        self.directions.set(lane, ray.ray.direction.0);
                        self.scales[lane] = if scale.is_normal() { scale } else { 0.0 };
                    }
                }
            }
            self.n += n;
            (run.at, run.n) = (run.at + n, run.n - n);
            run.offset.0 += 2 * n as i64;
        }
    }

    /// Passes on all that it holds.
    fn complete<O: Output>(&mut self, stage: &Stage, part: &mut Part<O>, open: &mut Vec<usize>) {
        if self.n > 0 {
            part.out.take(stage, self, open);
            self.n = 0;
        }
    }

    /// Where the hits are in their part.
    pub fn places(&self) -> &[usize] {
        &self.at[..self.n]
    }

    /// The direction of a hit's ray, and the object as that sees it.
    #[inline(always)]
    pub fn hit(&self, lane: usize) -> (Vec3<f64>, S) {
        (Vec3(self.directions.get(lane)), self.sights.get(lane))
    }
}

impl Output for Surfaces<'_> {
    fn take_run(&mut self, stage: &Stage, run: &Run, open: &mut Vec<usize>) -> bool {
        let StageRays::Pixels { camera, .. } = &stage.rays else { return false };
        let Some(sight) = stage.row_sight(run.id) else { return false };
        let places = run.at..run.at + run.n;
        let t = &mut self.t[places.clone()];
        sight.find(camera, run.offset, t, &mut self.normal[places]);
        if t.contains(&0.0) {
            open.extend((run.at..).zip(&*t).filter(|&(_, &t)| t == 0.0).map(|(at, _)| at));
        }
        true
    }

    fn miss(&mut self, at: Range<usize>) {
        self.t[at.clone()].fill(MISS.0);
        self.normal[at].fill(MISS.1);
    }

    fn take<S: Sight, const N: usize>(
        &mut self,
        stage: &Stage,
        hits: &Queue<S, N>,
        open: &mut Vec<usize>,
    ) {
        let (mut t, mut normal) = ([0.0; LANES], [[0.0; LANES]; 3]);
        let bounds = stage.bounds;
        pulp::Arch::new().dispatch(FindSurfaces { hits, bounds, t: &mut t, normal: &mut normal });
        for (lane, &at) in hits.places().iter().enumerate() {
            if t[lane] > 0.0 {
                self.t[at] = t[lane];
                self.normal[at] = [normal[0][lane], normal[1][lane], normal[2][lane]];
            } else {
                open.push(at);
            }
        }
    }
}

struct FindSurfaces<'a, S, const N: usize> {
    hits: &'a Queue<S, N>,
    bounds: Bounds,
    /// 0 where it is left open.
    t: &'a mut [f32; LANES],
    normal: &'a mut [[f32; LANES]; 3],
}

impl<S: Sight, const N: usize> pulp::WithSimd for FindSurfaces<'_, S, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<A: pulp::Simd>(self, _: A) {
        let FindSurfaces { hits, bounds, t, normal } = self;
        for lane in 0..LANES {
            let (direction, sight) = hits.hit(lane);
            let ray = RayOf::new(Vec3::ZERO, Vec3::ZERO, direction);
            let found = sight.surface(&ray, &bounds);
            let (t_here, n) = found.to_f32(ray.a, hits.scales[lane], &bounds.widening);
            t[lane] = t_here;
            for axis in 0..3 {
                normal[axis][lane] = n[axis];
            }
        }
    }
}
