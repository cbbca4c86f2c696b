//! `t`, points and normals of rays that are known to hit an object: in lanes of f64, then with more digits, then exactly.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use glam::DVec3;
use pulp::{Simd, WithSimd};

use super::Resolver;
use super::pack::{LANES, Pack, PackF64, is_id, put};
use crate::bounds::host::{HOST_UNIT_F64, input_in_f64};
use crate::bounds::{self, Footprint, InputError};
use crate::exact::{DoubleDoubleRay, ExactHit, ExactRay, unit_f32, visible_hit};
use crate::num::{Float, Lanes, Mask, Real, V3, dispatch, one_by_one};
use crate::prepare::{LengthUnit, ScaledInteger, power_of_two};
use crate::rays::{Frame, Lens, Rays};
use crate::scene::Scene;
use crate::shape::{
    Anchor, Anchors, PlaneRecord, Ray, RayOrigin, Record, ShapeRecord, SphereRecord, Surface,
    SurfaceErrorTerms,
};

/// `t` and the normal of a hit.
pub type TAndNormal = (f32, [f32; 3]);

/// `t` and the normal of a ray that hits nothing.
pub const MISS: TAndNormal = (f32::INFINITY, [0.0; 3]);

/// No direction is longer whose components are below 2.
pub(super) const LONGEST_SCALED: f64 = 3.47;

/// Finds where the rays of a stage meet what they are known to hit, in numbers of `F`.
pub struct Surfaces<'a, F: Float> {
    scene: &'a Scene,
    /// Whether its bounds hold for these rays.
    pub are_known: bool,
    eye: RayOrigin,
    pub lengths: SurfaceErrorTerms<F>,
    rays: &'a Rays,
    /// The unit that `t` is multiplied by.
    unit: LengthUnit,
    /// A picture's; none for lists.
    camera: Option<(Frame<F>, Anchors)>,
    /// In the order of their ids: of pictures those that are not in a hierarchy's tree.
    spheres: Vec<OneSphere<F>>,
    /// By index; none for lists.
    planes: Vec<PlaneRecord<F>>,
    /// The planes' unit normals in f32, by index, where `t` and normals are to be rounded; else none.
    units: Vec<[f32; 3]>,
}

/// A sphere as all rays of a picture see it.
struct OneSphere<F: Float> {
    id: u32,
    seen: SphereRecord<F>,
    is_close: bool,
    /// What its numbers are relative to, where that is not the eye.
    anchor: Option<Anchor<F>>,
}

impl<'a> Surfaces<'a, f64> {
    /// For points and unit normals in f64.
    pub fn in_f64(stage: &Resolver<'a>) -> Surfaces<'a, f64> {
        let lens = match stage.rays {
            Rays::Pixels(pixels) => Some(pixels.view.lens),
            Rays::List(_) => None,
        };
        Surfaces::new(stage, input_in_f64(lens), HOST_UNIT_F64)
    }

    /// For `t` and normals in f32: a plane's is the nearest one already.
    pub fn to_be_rounded(stage: &Resolver<'a>) -> Surfaces<'a, f64> {
        let mut found = Surfaces::in_f64(stage);
        found.units = stage.prepared.scene.planes.iter().map(unit_f32).collect();
        for (seen, unit) in found.planes.iter_mut().zip(&found.units) {
            *seen = rounded(*seen, unit, |x| x);
        }
        found
    }

    /// `t`, 0 where it is left open, and the unit normals against them in f32, of the rays from `first` on, which see these
    /// objects.
    ///
    /// `room` is what it works in, from call to call.
    pub fn round(
        &self,
        first: usize,
        ids: &[u32],
        room: &mut Vec<PackF64>,
        t: &mut [f32],
        normal: &mut [[f32; 3]],
    ) {
        let row = match self.rays {
            Rays::Pixels(pixels) => pixels.width as usize,
            Rays::List(_) => ids.len(),
        };
        let rows = ids.chunks(row).zip(t.chunks_mut(row)).zip(normal.chunks_mut(row));
        for (first, ((ids, t), normal)) in (first..).step_by(row).zip(rows) {
            let packs = &mut *room;
            dispatch(Round { surfaces: self, first, ids, packs, t, normal });
        }
    }

    /// Puts the rays from `first` on, which are of one row and see these objects, into packs; the last lanes may repeat one.
    #[inline(always)]
    pub fn load<const N: usize>(&self, first: usize, ids: &[u32], packs: &mut Vec<Pack<f64, N>>) {
        let n_packs = ids.len().div_ceil(N);
        packs.resize_with(packs.len().max(n_packs), Pack::default);
        packs.truncate(n_packs);
        for (pack, ids) in packs.iter_mut().zip(ids.chunks(N)) {
            pack.see(ids);
        }
        match self.rays {
            Rays::Pixels(pixels) => {
                let (x, y) = pixels.xy(first);
                let (i, j) = pixels.offset2(x, y);
                let columns = Lanes(std::array::from_fn(|lane| 2.0 * lane as f64));
                let last = Lanes::lit((i + 2 * (ids.len() as i64 - 1)) as f64);
                for (i, pack) in (i..).step_by(2 * N).zip(packs) {
                    let across = (Lanes::lit(i as f64) + columns).min(last);
                    pack.offset = [across, Lanes::lit(j as f64)];
                    pack.scale = Lanes::lit(self.unit.factor());
                }
            }
            Rays::List(rays) => {
                let last = first + ids.len() - 1;
                for (at, pack) in (first..).step_by(N).zip(packs) {
                    for lane in 0..N {
                        let ray = &rays[last.min(at + lane)];
                        let scaled = ScaledInteger::new(ray.direction);
                        let factor = power_of_two(self.unit.exponent() - scaled.exponent());
                        pack.scale.0[lane] = if factor.is_normal() { factor } else { 0.0 };
                        let towards = scaled.rounded();
                        for axis in 0..3 {
                            pack.direction.0[axis].0[lane] = towards[axis];
                            pack.reference.0[axis].0[lane] = ray.origin[axis];
                        }
                    }
                }
            }
        }
    }
}

impl<'a> Surfaces<'a, f32> {
    /// For points and unit normals in f32.
    pub fn in_f32(stage: &Resolver<'a>, lens: Lens) -> Surfaces<'a, f32> {
        Surfaces::new(stage, bounds::input_of(lens), f32::UNIT)
    }
}

impl<'a, F: Float> Surfaces<'a, F> {
    /// Whether small spheres that are far away are known better from anchors.
    const HAS_ANCHORS: bool = F::UNIT >= f32::UNIT;

    fn new(stage: &Resolver<'a>, input: InputError, unit: f64) -> Surfaces<'a, F> {
        let (eye, longest) = match stage.rays {
            Rays::Pixels(pixels) => (
                RayOrigin::of_pixels(pixels, Footprint::default(), unit),
                pixels.longest_direction(),
            ),
            Rays::List(_) => {
                (RayOrigin { unit, ..RayOrigin::of_list(DVec3::ZERO, 0.0) }, LONGEST_SCALED)
            }
        };
        let eye = RayOrigin { input, ..eye };
        let scene = &*stage.prepared.scene;
        let mut found = Surfaces {
            scene,
            are_known: stage.find.are_known(),
            eye,
            lengths: SurfaceErrorTerms::new(&eye, longest),
            rays: stage.rays,
            unit: stage.prepared.unit,
            camera: None,
            spheres: Vec::new(),
            planes: Vec::new(),
            units: Vec::new(),
        };
        if let Rays::Pixels(pixels) = stage.rays {
            found.camera = Some((Frame::of_pixels(pixels), Anchors::new(pixels)));
            let one = |id| found.one_sphere(id);
            found.spheres = match stage.prepared.rest() {
                None => (1..=scene.spheres.len() as u32).map(one).collect(),
                Some(rest) => rest.iter().copied().map(one).collect(),
            };
            let plane = |plane| PlaneRecord::new::<F>(plane, &eye).round();
            found.planes = scene.planes.iter().map(plane).collect();
        }
        found
    }

    /// Ids up to this one are those of spheres, the ones behind it of planes.
    #[inline(always)]
    fn n_spheres(&self) -> u32 {
        self.scene.spheres.len() as u32
    }

    /// The rays of a pack.
    #[inline(always)]
    fn rays_of<const N: usize>(&self, pack: &Pack<F, N>) -> Ray<Lanes<F, N>> {
        match &self.camera {
            Some((camera, _)) => {
                let [across, up] = pack.offset;
                camera.ray(across, up)
            }
            None => Ray::new(V3([Lanes::lit(0.0); 3]), pack.direction),
        }
    }

    /// Where the rays of packs meet what they see; unknown where the bounds don't hold for them.
    #[inline(always)]
    pub fn solve<const N: usize>(&self, packs: &mut [Pack<F, N>]) {
        if !self.are_known {
            for pack in packs {
                pack.surface = Surface::unknown();
            }
            return;
        }
        let n_spheres = self.n_spheres();
        let is_sphere = |id| 0 < id && id <= n_spheres;
        let is_plane = |id| id > n_spheres;
        // Small loops over packs in memory are put into registers, where one large one is not.
        let mut last = None;
        for pack in one_by_one(&mut *packs).filter(|pack| pack.one().is_some_and(is_sphere)) {
            self.keep_of_sphere(pack, &mut last);
        }
        for pack in one_by_one(&mut *packs).filter(|pack| pack.one().is_some_and(is_plane)) {
            self.keep_of_plane(pack);
        }
        for pack in one_by_one(&mut *packs) {
            if !self.has_record(pack) {
                pack.surface = self.on_several(pack, false);
            }
        }
        for pack in one_by_one(packs) {
            if (!pack.surface.is_known() & !is_id(&pack.ids, 0)).any() {
                self.look_closer(pack);
            }
        }
    }

    /// Takes what is open in a pack, mostly at a silhouette, as if its spheres were close. It is rare, and so not in the loops
    /// that are compiled for each instruction set.
    #[inline(never)]
    fn look_closer<const N: usize>(&self, pack: &mut Pack<F, N>) {
        let found = self.on_several(pack, true);
        // What is known from an anchor is known better.
        pack.surface = match Self::HAS_ANCHORS {
            true => Surface::select(pack.surface.is_known(), pack.surface, found),
            false => found,
        };
    }

    /// A sphere as all rays of a picture see it.
    fn one_sphere(&self, id: u32) -> OneSphere<F> {
        let sphere = &self.scene.spheres[id as usize - 1];
        if Self::HAS_ANCHORS
            && let Some((_, anchors)) = &self.camera
        {
            let center = V3((sphere.center - self.eye.reference).to_array());
            let (seen, anchor, suits) = anchors.seen(center, sphere.radius.abs());
            if suits {
                let anchor = Some(anchor.round());
                return OneSphere { id, seen: seen.round(), is_close: false, anchor };
            }
        }
        let seen = SphereRecord::new::<F>(sphere, &self.eye);
        OneSphere { id, seen: seen.round(), is_close: seen.is_close(), anchor: None }
    }

    /// The record of the one plane that a pack sees.
    #[inline(always)]
    fn plane_of<const N: usize>(&self, pack: &Pack<F, N>) -> Option<&PlaneRecord<F>> {
        self.planes.get(pack.ids[0] as usize - 1 - self.scene.spheres.len())
    }

    /// Whether one record serves all its rays, or they see nothing.
    #[inline(always)]
    fn has_record<const N: usize>(&self, pack: &Pack<F, N>) -> bool {
        match pack.one() {
            None => false,
            Some(0) => true,
            Some(id) if id <= self.n_spheres() => self.camera.is_some(),
            Some(_) => self.plane_of(pack).is_some(),
        }
    }

    /// Where a pack's rays meet their objects: the spheres together, then each plane.
    #[inline(always)]
    fn on_several<const N: usize>(
        &self,
        pack: &Pack<F, N>,
        is_close: bool,
    ) -> Surface<Lanes<F, N>> {
        let (ids, ray) = (&pack.ids, self.rays_of(pack));
        let mut surface = self.on_spheres(pack, &ray, is_close);
        for lane in 0..N {
            let id = ids[lane];
            if id > self.n_spheres() && !ids[..lane].contains(&id) {
                let here = is_id(ids, id);
                surface = Surface::select(here, self.on_plane(id, pack, &ray), surface);
            }
        }
        surface
    }

    /// `last` is the last sphere of a tree that a pack saw alone.
    // What several branches return goes through memory, and in pieces: each keeps its own.
    #[inline(always)]
    fn keep_of_sphere<const N: usize>(
        &self,
        pack: &mut Pack<F, N>,
        last: &mut Option<OneSphere<F>>,
    ) {
        let Some((camera, _)) = &self.camera else { return };
        let id = pack.ids[0];
        let one = match self.spheres.binary_search_by_key(&id, |one| one.id) {
            Ok(place) => &self.spheres[place],
            Err(_) => {
                last.take_if(|last| last.id != id);
                last.get_or_insert_with(|| self.one_sphere(id))
            }
        };
        let (seen, lengths) = (SphereRecord::splat(&one.seen), self.lengths.map(Lanes::splat));
        let ray = self.rays_of(pack);
        match (&one.anchor, one.is_close) {
            (Some(anchor), _) if Self::HAS_ANCHORS => {
                let anchor = Anchor::splat(anchor);
                let ray = anchor.ray(camera.steps(), pack.offset, &ray);
                pack.surface = anchor.to_eye(SphereRecord::surface(&seen, &ray, &lengths));
            }
            (_, false) => pack.surface = SphereRecord::surface(&seen, &ray, &lengths),
            (_, true) => pack.surface = SphereRecord::surface_close(&seen, &ray, &lengths),
        }
    }

    #[inline(always)]
    fn keep_of_plane<const N: usize>(&self, pack: &mut Pack<F, N>) {
        let Some(seen) = self.plane_of(pack) else { return };
        let (seen, lengths) = (PlaneRecord::splat(seen), self.lengths.map(Lanes::splat));
        pack.surface = PlaneRecord::surface(&seen, &self.rays_of(pack), &lengths);
    }

    #[inline(always)]
    fn on_spheres<const N: usize>(
        &self,
        pack: &Pack<F, N>,
        ray: &Ray<Lanes<F, N>>,
        is_close: bool,
    ) -> Surface<Lanes<F, N>> {
        let (spheres, eye) = (&self.scene.spheres[..], &self.eye);
        let (mut center, mut r) = (V3([Lanes::<f64, N>::lit(0.0); 3]), Lanes::lit(0.0));
        for lane in 0..N {
            if let Some(sphere) = spheres.get((pack.ids[lane] as usize).wrapping_sub(1)) {
                for axis in 0..3 {
                    let from_eye = sphere.center[axis] - eye.reference[axis];
                    center.0[axis].0[lane] = from_eye - pack.reference.0[axis].0[lane].to_f64();
                }
                r.0[lane] = sphere.radius.abs();
            }
        }
        let lengths = self.lengths.map(Lanes::splat);
        if Self::HAS_ANCHORS
            && let (Some((camera, anchors)), false) = (&self.camera, is_close)
        {
            let (seen, anchor, suits) = anchors.seen(center, r);
            if !(Lanes::lit(0.0).lt(r) & !suits).any() {
                let (seen, anchor) = (seen.round_lanes(), anchor.round_lanes());
                let ray = anchor.ray(camera.steps(), pack.offset, ray);
                return anchor.to_eye(SphereRecord::surface(&seen, &ray, &lengths));
            }
        }
        let (k, spread) = (bounds::k_in_f64(center, r), Lanes::lit(eye.spread));
        let seen = SphereRecord::of::<F>(center, r, k, spread, eye.input, eye);
        let seen = seen.round_lanes();
        if is_close {
            return SphereRecord::surface_close(&seen, ray, &lengths);
        }
        let surface = SphereRecord::surface(&seen, ray, &lengths);
        // A close sphere is left to `look_closer`.
        let close = Lanes::lit(0.0).lt(seen.is_close);
        let point_error = Lanes::select(close, Lanes::lit(F::BEYOND), surface.point_error);
        Surface { point_error, ..surface }
    }

    #[inline(always)]
    fn on_plane<const N: usize>(
        &self,
        id: u32,
        pack: &Pack<F, N>,
        ray: &Ray<Lanes<F, N>>,
    ) -> Surface<Lanes<F, N>> {
        let index = id as usize - 1 - self.scene.spheres.len();
        let seen = match self.planes.get(index) {
            Some(seen) => PlaneRecord::splat(seen),
            None => match self.plane_of_list(index, pack) {
                Some(seen) => seen,
                None => return Surface::unknown(),
            },
        };
        PlaneRecord::surface(&seen, ray, &self.lengths.map(Lanes::splat))
    }

    /// A plane as each ray of a list sees it. Most of the loops that are compiled for each instruction set never have a list, and
    /// so none has this formula in it.
    #[inline(never)]
    fn plane_of_list<const N: usize>(
        &self,
        index: usize,
        pack: &Pack<F, N>,
    ) -> Option<PlaneRecord<Lanes<F, N>>> {
        let plane = self.scene.planes.get(index)?;
        let l = V3::lit(plane.point) - pack.reference.map(|x| x.each(F::to_f64));
        let mut seen = PlaneRecord::of::<F>(plane, l, &self.eye);
        if let Some(unit) = self.units.get(index) {
            seen = rounded(seen, unit, Lanes::lit);
        }
        Some(seen.round_lanes())
    }
}

/// With the unit normal whose components are nearest in f32.
#[inline(always)]
fn rounded<R: Copy>(
    seen: PlaneRecord<R>,
    unit: &[f32; 3],
    lit: impl Fn(f64) -> R,
) -> PlaneRecord<R> {
    let unit = V3(*unit).map(|x| lit(f64::from(x)));
    PlaneRecord { unit, unit_error: lit(0.0), ..seen }
}

/// Some rays, compiled for each instruction set that the processor may have.
struct Round<'a> {
    surfaces: &'a Surfaces<'a, f64>,
    first: usize,
    ids: &'a [u32],
    packs: &'a mut Vec<PackF64>,
    t: &'a mut [f32],
    normal: &'a mut [[f32; 3]],
}

/// Rays that go from stage to stage together.
const TOGETHER: usize = 64;

impl WithSimd for Round<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Round { surfaces, first, ids, packs, t, normal } = self;
        for (at, ids) in (0..).step_by(TOGETHER).zip(ids.chunks(TOGETHER)) {
            let is_missed = ids.iter().fold(0, |any, id| any | id) == 0;
            if !is_missed {
                surfaces.load(first + at, ids, packs);
                surfaces.solve(packs);
            }
            for (number, ids) in ids.chunks(LANES).enumerate() {
                let at = at + number * LANES;
                let (t, normal) = (&mut t[at..at + ids.len()], &mut normal[at..at + ids.len()]);
                match is_missed || packs[number].one() == Some(0) {
                    true => {
                        t.fill(MISS.0);
                        normal.fill(MISS.1);
                    }
                    false => round_pack(&packs[number], t, normal),
                }
            }
        }
    }
}

/// Rounds what is found of the first lanes of a pack; `t` is 0 where two numbers are as near.
#[inline(always)]
fn round_pack(pack: &PackF64, t: &mut [f32], normal: &mut [[f32; 3]]) {
    let Surface { t: bounds, normal: found, component_error, .. } = &pack.surface;
    let (low, high) = (bounds.low * pack.scale, bounds.high * pack.scale);
    let mut ts = [0.0; LANES];
    for lane in 0..LANES {
        let (low, high) = (low.0[lane] as f32, high.0[lane] as f32);
        let is_known = (low > 0.0) & (low == high) & (high < f32::INFINITY);
        ts[lane] = if is_known { low } else { 0.0 };
    }
    let mut components = [[0.0; LANES]; 3];
    for axis in 0..3 {
        let lows = (found.0[axis] - component_error.0[axis]).0;
        let highs = (found.0[axis] + component_error.0[axis]).0;
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
    if pack.one().is_none() {
        for lane in (0..LANES).filter(|&lane| pack.ids[lane] == 0) {
            (ts[lane], normals[lane]) = MISS;
        }
    }
    put(&ts, t);
    put(&normals, normal);
}

impl Resolver<'_> {
    /// `t` and normal of a hit that is known to exist: with some 100 bits, else exactly.
    pub fn surface(&self, index: usize, id: u32) -> Option<TAndNormal> {
        let object = self.prepared.scene.object(id)?;
        let unit = self.prepared.unit;
        if let Some(surface) = DoubleDoubleRay::new(self.rays, index).surface(object, unit.factor())
        {
            return Some(surface);
        }
        let ray = self.exact.ray(index);
        let hit = visible_hit(&ray, id, object);
        debug_assert!(hit.is_some(), "object {id} was decided for ray {index} but is not hit");
        Some(exact_surface(&ray, &hit?, unit))
    }
}

pub(super) fn exact_surface(ray: &ExactRay, hit: &ExactHit, unit: LengthUnit) -> TAndNormal {
    (hit.t_f32_in(unit.exponent()), hit.normal_f32(ray))
}
