//! `t`, points and normals of rays that are known to hit an object: in lanes of f64, then with more digits, then exactly.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use pulp::{Simd, WithSimd};

use super::nearness::PlaneF64;
use super::{Stage, StageRays};
use crate::engine::{Camera, eye_of};
use crate::exact::{ExactHit, ExactRay, Shape, visible_root};
use crate::guard::host::{HOST_UNIT_F64, input_in_f64};
use crate::guard::{self, Reach};
use crate::num::{Float, Lanes, Mask, Real, V3};
use crate::prepare::{Scaled, power_of_two};
use crate::rays::Pixels;
use crate::scene::{Plane, Scene};
use crate::seen::{Bounds, Eye, Lengths, PlaneSeen, Ray, Record, Seen, SphereSeen, Surface};
use crate::shape::plane_normal;
use glam::DVec3;

/// Rays that go side by side.
pub const LANES: usize = 8;

type F64s = Lanes<f64, LANES>;

/// `t` and the normal of a hit.
pub type TAndNormal = (f32, [f32; 3]);

/// Those of a ray that hits nothing.
pub const MISS: TAndNormal = (f32::INFINITY, [0.0; 3]);

/// The exact unit normal of a plane, each component rounded to the nearest f32. `unit` is the same in f64.
pub fn unit_f32(plane: &Plane, unit: [f64; 3]) -> [f32; 3] {
    let error = guard::steps::NORMALIZED * guard::UNIT_F64;
    let [low, high] = [-error, error].map(|error| unit.map(|x| (x + error) as f32));
    if low == high {
        // Not `−0`.
        return low.map(|x| x + 0.0);
    }
    plane_normal(plane.normal).map_or([0.0; 3], |normal| normal.map(|x| x.to_f32()))
}

/// Finds where the rays of a stage meet what they are known to hit.
pub struct Surfaces<'a> {
    scene: &'a Scene,
    are_known: bool,
    eye: Eye,
    lengths: Lengths<f64>,
    rays: SurfaceRays<'a>,
    /// With their ids, in the order of these: of pictures those that are not in a hierarchy's tree.
    spheres: Vec<(u32, SphereSeen<f64>)>,
    /// By index; none for lists.
    planes: Vec<PlaneSeen<f64>>,
    planes_f64: Vec<PlaneF64>,
}

/// The same rays as [`StageRays`].
enum SurfaceRays<'a> {
    Pixels(&'a Pixels, Camera<f64>),
    List(&'a [crate::rays::Ray]),
}

/// What the rays of a pack see.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Nothing,
    Sphere,
    Plane,
    Several,
}

/// Rays side by side, and what is kept of where they meet their objects.
pub struct Pack<K> {
    /// The objects' ids; 0 for none.
    pub ids: [u32; LANES],
    n_spheres: u32,
    /// Of pixels twice their offset from the picture's centre.
    offset: [F64s; 2],
    /// Of a list's rays their origins, and what `t` is multiplied with.
    reference: V3<F64s>,
    scale: F64s,
    /// The rays.
    pub ray: Ray<F64s>,
    kind: Kind,
    /// Whether the formula for close spheres is needed.
    is_close: bool,
    /// Bounds of `t`,
    pub t: Bounds<F64s>,
    /// and what else is kept.
    pub kept: K,
}

impl<K: Default> Default for Pack<K> {
    fn default() -> Pack<K> {
        let zero = Lanes::lit(0.0);
        Pack {
            ids: [0; LANES],
            n_spheres: 0,
            offset: [zero; 2],
            reference: V3([zero; 3]),
            scale: Lanes::lit(1.0),
            ray: Ray { origin: V3([zero; 3]), direction: V3([zero; 3]), a: zero, inv_a: zero },
            kind: Kind::Nothing,
            is_close: false,
            t: Bounds::default(),
            kept: K::default(),
        }
    }
}

impl<K> Pack<K> {
    #[inline(always)]
    fn keep<O: Output<Kept = K>>(&mut self, surface: &Surface<F64s>) {
        self.t = surface.t;
        O::keep(surface, &mut self.kept);
    }

    /// Whether a lane's object is a sphere.
    #[inline(always)]
    pub fn is_sphere(&self, lane: usize) -> bool {
        self.ids[lane] <= self.n_spheres
    }
}

/// Takes what is found.
pub trait Output {
    /// What it keeps of a pack.
    type Kept: Default;
    /// Keeps it.
    fn keep(surface: &Surface<F64s>, kept: &mut Self::Kept);
    /// Takes the first `n` lanes for the rays at `at` and behind.
    fn take(&mut self, at: usize, n: usize, pack: &Pack<Self::Kept>);
    /// These hit nothing.
    fn miss(&mut self, at: usize, n: usize);
}

impl<'a> Surfaces<'a> {
    /// For points and unit normals.
    pub fn new(stage: &Stage<'a>) -> Surfaces<'a> {
        let (eye, longest, rays) = match &stage.rays {
            StageRays::Pixels { pixels, .. } => {
                let eye = eye_of(pixels, Reach::default(), HOST_UNIT_F64);
                let eye = Eye { input: input_in_f64(Some(pixels.view.lens)), ..eye };
                let rays = SurfaceRays::Pixels(pixels, Camera::new(pixels));
                (eye, pixels.longest_direction(), rays)
            }
            StageRays::List(rays) => {
                let eye = Eye {
                    reference: DVec3::ZERO,
                    spread: 0.0,
                    input: input_in_f64(None),
                    reach: Reach::default(),
                    unit: HOST_UNIT_F64,
                };
                // Components are below 2.
                (eye, 3.47, SurfaceRays::List(rays))
            }
        };
        let mut found = Surfaces {
            scene: stage.scene,
            are_known: stage.usable,
            eye,
            lengths: Lengths::new(&eye, longest),
            rays,
            spheres: Vec::new(),
            planes: Vec::new(),
            planes_f64: stage.planes.clone(),
        };
        if let StageRays::Pixels { .. } = &stage.rays {
            let spheres = &stage.scene.spheres[..];
            let seen = |id: u32| (id, SphereSeen::new::<f64>(&spheres[id as usize - 1], &eye));
            found.spheres = match stage.hierarchy {
                None => (1..=spheres.len() as u32).map(seen).collect(),
                Some(hierarchy) => hierarchy.rest.iter().copied().map(seen).collect(),
            };
            found.spheres.sort_unstable_by_key(|&(id, _)| id);
            let plane = |plane| PlaneSeen::new::<f64>(plane, &eye);
            found.planes = stage.scene.planes.iter().map(plane).collect();
        }
        found
    }

    /// For `t` and normals in f32: a plane's is the nearest one already.
    pub fn to_be_rounded(stage: &Stage<'a>) -> Surfaces<'a> {
        let mut found = Surfaces::new(stage);
        for (seen, plane) in found.planes.iter_mut().zip(&stage.planes) {
            *seen = rounded(*seen, plane, |x| x);
        }
        found
    }

    /// Whether its bounds hold for these rays.
    pub fn are_known(&self) -> bool {
        self.are_known
    }

    /// Gives `output` what it finds of the rays from `first` on, which see these objects.
    ///
    /// `room` is what it works in, from call to call.
    pub fn find<O: Output>(
        &self,
        first: usize,
        ids: &[u32],
        room: &mut Vec<Pack<O::Kept>>,
        output: &mut O,
    ) {
        pulp::Arch::new().dispatch(Find { surfaces: self, first, ids, packs: room, output });
    }

    /// Puts the rays from `first` on, which see these objects, into packs; the last lanes may repeat one.
    #[inline(always)]
    fn load<K: Default>(&self, first: usize, ids: &[u32], packs: &mut Vec<Pack<K>>) {
        let n_spheres = self.scene.spheres.len() as u32;
        let n_packs = ids.len().div_ceil(LANES);
        packs.resize_with(packs.len().max(n_packs), Pack::default);
        packs.truncate(n_packs);
        for (pack, ids) in packs.iter_mut().zip(ids.chunks(LANES)) {
            (pack.n_spheres, pack.is_close) = (n_spheres, false);
            pack.ids = [ids[ids.len() - 1]; LANES];
            pack.ids[..ids.len()].copy_from_slice(ids);
            let differ = pack.ids.iter().fold(0, |differ, id| differ | (id ^ pack.ids[0]));
            pack.kind = match pack.ids[0] {
                _ if differ != 0 => Kind::Several,
                0 => Kind::Nothing,
                id if id <= n_spheres => Kind::Sphere,
                _ => Kind::Plane,
            };
        }
        match &self.rays {
            SurfaceRays::Pixels(pixels, _) => {
                let (mut x, mut y) = pixels.xy(first);
                let end = pixels.x + pixels.width;
                let columns = Lanes(std::array::from_fn(|lane| 2.0 * lane as f64));
                for pack in packs {
                    let (i, j) = pixels.offset2(x, y);
                    pack.offset = [Lanes::lit(i as f64) + columns, Lanes::lit(j as f64)];
                    x += LANES as u32;
                    if x < end {
                        continue;
                    }
                    // The row ends here.
                    let n_here = LANES as u32 - (x - end);
                    (x, y) = (pixels.x, y + 1);
                    for lane in n_here as usize..LANES {
                        let (i, j) = pixels.offset2(x, y);
                        (pack.offset[0].0[lane], pack.offset[1].0[lane]) = (i as f64, j as f64);
                        x += 1;
                        if x == end {
                            (x, y) = (pixels.x, y + 1);
                        }
                    }
                }
            }
            SurfaceRays::List(rays) => {
                let last = first + ids.len() - 1;
                for (at, pack) in (first..).step_by(LANES).zip(packs) {
                    for lane in 0..LANES {
                        let ray = &rays[last.min(at + lane)];
                        let scaled = Scaled::new(ray.direction);
                        let factor = power_of_two(-scaled.exponent());
                        pack.scale.0[lane] = if factor.is_normal() { factor } else { 0.0 };
                        let towards = scaled.rounded();
                        for axis in 0..3 {
                            pack.ray.direction.0[axis].0[lane] = towards[axis];
                            pack.reference.0[axis].0[lane] = ray.origin[axis];
                        }
                    }
                }
            }
        }
    }

    #[inline(always)]
    fn aim<K>(&self, pack: &mut Pack<K>) {
        pack.ray = match &self.rays {
            SurfaceRays::Pixels(_, camera) => {
                let [across, up] = pack.offset;
                camera.ray(across.0, up.0)
            }
            SurfaceRays::List(_) => Ray::new(pack.ray.origin, pack.ray.direction),
        };
    }

    /// Whether nothing is known of a ray that hits a sphere.
    #[inline(always)]
    fn leaves_spheres_open<K>(&self, pack: &Pack<K>) -> bool {
        let mut is_open = false;
        for lane in 0..LANES {
            let is_known = pack.t.high.0[lane] < f64::BEYOND / 2.0;
            is_open |= !is_known & (pack.ids[lane] != 0) & pack.is_sphere(lane);
        }
        is_open
    }

    /// Where a pack's rays meet their objects: the spheres together, then each plane.
    #[inline(always)]
    fn on_several<K>(&self, pack: &Pack<K>) -> Surface<F64s> {
        let ids = &pack.ids;
        let mut surface = self.on_spheres(pack);
        for lane in 0..LANES {
            let id = ids[lane];
            if id > pack.n_spheres && !ids[..lane].contains(&id) {
                let mut here = [0.0; LANES];
                for lane in 0..LANES {
                    here[lane] = if ids[lane] == id { 1.0 } else { 0.0 };
                }
                let here = Lanes::lit(0.0).lt(Lanes(here));
                surface = Surface::select(here, self.on_plane(id, pack), surface);
            }
        }
        surface
    }

    #[inline(always)]
    fn on_sphere<K>(&self, pack: &Pack<K>) -> Surface<F64s> {
        match self.spheres.binary_search_by_key(&pack.ids[0], |&(id, _)| id) {
            Ok(place) => {
                let seen = &self.spheres[place].1;
                let (is_close, seen) = (seen.is_close(), SphereSeen::splat(seen));
                match is_close || pack.is_close {
                    false => SphereSeen::surface(&seen, &pack.ray, &self.lengths.splat()),
                    true => SphereSeen::surface_close(&seen, &pack.ray, &self.lengths.splat()),
                }
            }
            Err(_) => self.on_spheres(pack),
        }
    }

    #[inline(always)]
    fn on_spheres<K>(&self, pack: &Pack<K>) -> Surface<F64s> {
        let spheres = &self.scene.spheres[..];
        let (mut center, mut r) = (V3([Lanes::lit(0.0); 3]), Lanes::lit(0.0));
        for lane in 0..LANES {
            if let Some(sphere) = spheres.get((pack.ids[lane] as usize).wrapping_sub(1)) {
                for axis in 0..3 {
                    center.0[axis].0[lane] = sphere.center[axis];
                }
                r.0[lane] = sphere.radius.abs();
            }
        }
        let l = match &self.rays {
            SurfaceRays::Pixels(..) => center - V3::lit(self.eye.reference),
            SurfaceRays::List(_) => center - pack.reference,
        };
        let (l2, r2) = (l.dot(l), r * r);
        let k_error = Lanes::lit(guard::K_ERROR * guard::UNIT_F64) * (l2 + r2);
        let eye = &self.eye;
        let seen = SphereSeen::of::<f64>(l, r, l2 - r2, k_error, eye.input, eye);
        match pack.is_close || Lanes::lit(0.0).lt(seen.is_close).any() {
            false => SphereSeen::surface(&seen, &pack.ray, &self.lengths.splat()),
            true => SphereSeen::surface_close(&seen, &pack.ray, &self.lengths.splat()),
        }
    }

    #[inline(always)]
    fn on_plane<K>(&self, id: u32, pack: &Pack<K>) -> Surface<F64s> {
        let index = id as usize - 1 - self.scene.spheres.len();
        let seen = match (self.planes.get(index), self.planes_f64.get(index)) {
            (Some(seen), _) => PlaneSeen::splat(seen),
            (None, Some(plane)) => {
                let l = V3::lit(plane.point) - pack.reference;
                let normal = DVec3::from_array(plane.normal.0);
                rounded(PlaneSeen::of::<f64>(normal, l, &self.eye), plane, Lanes::lit)
            }
            // Undecided.
            (None, None) => return Surface::unknown(),
        };
        PlaneSeen::surface(&seen, &pack.ray, &self.lengths.splat())
    }
}

/// With the unit normal whose components are nearest in f32.
fn rounded<R: Copy>(seen: PlaneSeen<R>, plane: &PlaneF64, lit: impl Fn(f64) -> R) -> PlaneSeen<R> {
    let unit = V3(plane.unit_f32.map(|x| lit(f64::from(x))));
    PlaneSeen { unit, unit_error: lit(0.0), ..seen }
}

/// Some rays, compiled for each instruction set that the processor may have.
struct Find<'a, O: Output> {
    surfaces: &'a Surfaces<'a>,
    first: usize,
    ids: &'a [u32],
    packs: &'a mut Vec<Pack<O::Kept>>,
    output: &'a mut O,
}

/// Rays that go from stage to stage together.
const TOGETHER: usize = 64;

impl<O: Output> WithSimd for Find<'_, O> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Find { surfaces, first, ids, packs, output } = self;
        for (at, ids) in (0..).step_by(TOGETHER).zip(ids.chunks(TOGETHER)) {
            if ids.iter().fold(0, |any, id| any | id) == 0 {
                output.miss(at, ids.len());
                continue;
            }
            surfaces.load(first + at, ids, packs);
            // Small loops over packs in memory are put into registers, where one large one is not.
            packs.iter_mut().for_each(|pack| surfaces.aim(pack));
            for pack in packs.iter_mut().filter(|pack| pack.kind == Kind::Sphere) {
                pack.keep::<O>(&surfaces.on_sphere(pack));
            }
            for pack in packs.iter_mut().filter(|pack| pack.kind == Kind::Plane) {
                pack.keep::<O>(&surfaces.on_plane(pack.ids[0], pack));
            }
            for pack in packs.iter_mut().filter(|pack| pack.kind == Kind::Several) {
                pack.keep::<O>(&surfaces.on_several(pack));
            }
            // At a silhouette.
            for pack in packs.iter_mut().filter(|pack| surfaces.leaves_spheres_open(pack)) {
                pack.is_close = true;
                pack.keep::<O>(&surfaces.on_several(pack));
            }
            for (number, pack) in packs.iter().enumerate() {
                let n = LANES.min(ids.len() - number * LANES);
                match pack.kind == Kind::Nothing {
                    true => output.miss(at + number * LANES, n),
                    false => output.take(at + number * LANES, n, pack),
                }
            }
        }
    }
}

/// What [`InF32`] keeps of a [`Surface`].
#[derive(Default)]
pub struct Rounding {
    normal: V3<F64s>,
    component_error: V3<F64s>,
}

/// `t` and normals in f32.
pub struct InF32<'a> {
    /// 0 where it is left open.
    pub t: &'a mut [f32],
    /// Unit normals against the rays.
    pub normal: &'a mut [[f32; 3]],
}

impl Output for InF32<'_> {
    type Kept = Rounding;

    #[inline(always)]
    fn keep(surface: &Surface<F64s>, kept: &mut Rounding) {
        let &Surface { normal, component_error, .. } = surface;
        *kept = Rounding { normal, component_error };
    }

    #[inline(always)]
    fn take(&mut self, at: usize, n: usize, pack: &Pack<Rounding>) {
        let Rounding { normal, component_error } = &pack.kept;
        let (low, high) = (pack.t.low * pack.scale, pack.t.high * pack.scale);
        let mut ts = [0.0; LANES];
        for lane in 0..LANES {
            let (low, high) = (low.0[lane] as f32, high.0[lane] as f32);
            let is_known = (low > 0.0) & (low == high) & (high < f32::INFINITY);
            ts[lane] = if is_known { low } else { 0.0 };
        }
        let mut components = [[0.0; LANES]; 3];
        for axis in 0..3 {
            let lows = (normal.0[axis] - component_error.0[axis]).0;
            let highs = (normal.0[axis] + component_error.0[axis]).0;
            for lane in 0..LANES {
                let (low, high) = (lows[lane] as f32, highs[lane] as f32);
                // Not `−0`.
                components[axis][lane] = low + 0.0;
                ts[lane] = if low == high { ts[lane] } else { 0.0 };
            }
        }
        let mut normals = [[0.0; 3]; LANES];
        for lane in 0..LANES {
            let [x, y, z] = &components;
            normals[lane] = [x[lane], y[lane], z[lane]];
        }
        if pack.kind == Kind::Several {
            for lane in (0..LANES).filter(|&lane| pack.ids[lane] == 0) {
                (ts[lane], normals[lane]) = MISS;
            }
        }
        put(&ts, &mut self.t[at..at + n]);
        put(&normals, &mut self.normal[at..at + n]);
    }

    #[inline(always)]
    fn miss(&mut self, at: usize, n: usize) {
        self.t[at..at + n].fill(MISS.0);
        self.normal[at..at + n].fill(MISS.1);
    }
}

/// The first lanes into a slice; all of them without a call.
#[inline(always)]
fn put<T: Copy>(lanes: &[T; LANES], to: &mut [T]) {
    match <&mut [T; LANES]>::try_from(&mut *to) {
        Ok(to) => *to = *lanes,
        Err(_) => to.copy_from_slice(&lanes[..to.len()]),
    }
}

impl Stage<'_> {
    /// `t` and normal of a hit that is known to exist: with some 100 bits, else exactly.
    pub fn surface(&self, index: usize, id: u32) -> Option<TAndNormal> {
        let object = self.scene.object(id)?;
        if let Some(surface) = self.surface_in_balls(index, id, object) {
            return Some(surface);
        }
        let ray = self.exact_ray(index);
        let shape = Shape::from(object);
        let visible = visible_root(&ray, &shape);
        debug_assert!(visible.is_some(), "object {id} was decided for ray {index} but is not hit");
        let (root, side) = visible?;
        Some(exact_surface(&ray, &ExactHit { id, root, side }, &shape))
    }
}

pub(super) fn exact_surface(ray: &ExactRay, hit: &ExactHit, shape: &Shape) -> TAndNormal {
    (hit.t_f32(), hit.normal_f32(ray, shape))
}
