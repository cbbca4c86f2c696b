//! The filter for neighbours in a row of pixels, side by side: the same operations as for one ray, but
//! for branches. Where no ray comes near an object, that one is done.

use std::marker::PhantomData;

use pulp::Simd;

use super::filter::{
    FarFilter, Filter, Nearness, ParallelFilter, PointFilter, UNDECIDED, Widening, closest_approach,
};
use super::lanes::{NearestOf, inside_at, outside_at, plane_nearness};
use super::records::{PlaneCertified, SphereCertified};
use crate::control::Control;
use crate::error::Result;
use crate::kernel::{Lists, RayOf};
use crate::rays::{CameraF32, Lens};
use crate::vec3::{Real, Vec3, dot3};
use crate::wide::{Holds, SideBySide, WideF32};

/// Rays side by side.
type Rays<S> = RayOf<WideF32<S>>;

/// Bounds of each ray's root; `None` where all rays miss.
type Roots<S> = Option<Nearness<WideF32<S>>>;

/// A filter that has steps without branches.
pub(crate) trait RowFilter: Filter {
    /// Twin of [`Filter::sphere_nearness`].
    fn sphere<S: Simd>(
        rays: &Rays<S>,
        sphere: &SphereCertified,
        widening: &Widening<f32>,
    ) -> Roots<S>;
    /// Twin of [`Filter::plane_nearness`].
    fn plane<S: Simd>(
        rays: &Rays<S>,
        plane: &PlaneCertified,
        widening: &Widening<f32>,
    ) -> Nearness<WideF32<S>>;
}

/// The closest approaches to a centre; `None` where all rays stay outside of a radius.
#[inline(always)]
fn approach<S: Simd>(
    rays: &Rays<S>,
    l: Vec3<WideF32<S>>,
    outer2: f32,
) -> Option<(WideF32<S>, WideF32<S>)> {
    let (s, m) = closest_approach(rays.direction, rays.inv_a, l);
    m.le(m.like(outer2)).any().then_some((s, m))
}

impl RowFilter for FarFilter {
    #[inline(always)]
    fn sphere<S: Simd>(rays: &Rays<S>, sphere: &SphereCertified, _: &Widening<f32>) -> Roots<S> {
        let (a, inv_a) = (rays.a, rays.inv_a);
        let &SphereCertified { center, inner2, outer2, q_high_or_r2: q, .. } = sphere;
        let (s, m) = approach(rays, a.like3(Vec3(center)), outer2)?;
        let (zero, q) = (a.like(0.0), a.like(q));
        let (inner, outer) = (a.like(inner2) - m, a.like(outer2) - m);
        let low = (s + (inner.abs() * inv_a).sqrt()) * q;
        let high = (s + (outer.abs() * inv_a).sqrt()) * q;
        Some(Nearness {
            low: zero.le(inner).select(low, zero),
            high: zero.le(outer).select(high, zero),
        })
    }

    #[inline(always)]
    fn plane<S: Simd>(
        rays: &Rays<S>,
        plane: &PlaneCertified,
        _: &Widening<f32>,
    ) -> Nearness<WideF32<S>> {
        let a = rays.a;
        let away = dot3(rays.direction, a.like3(Vec3(plane.normal)));
        let q = Nearness { low: a.like(plane.q_low), high: a.like(plane.q_high) };
        plane_nearness(rays, away, plane.direction_error, q)
    }
}

impl RowFilter for PointFilter {
    #[inline(always)]
    fn sphere<S: Simd>(
        rays: &Rays<S>,
        sphere: &SphereCertified,
        widening: &Widening<f32>,
    ) -> Roots<S> {
        let a = rays.a;
        let l = a.like3(Vec3(sphere.center));
        let q = Nearness { low: sphere.q_low.abs(), high: sphere.q_high_or_r2.abs() };
        let (inv_a, guard) = (rays.inv_a, sphere.guard());
        if sphere.q_low > 0.0 {
            let (s, m) = approach(rays, l, sphere.outer2)?;
            return Some(outside_at(s, m, inv_a, &guard, q));
        }
        let (s, m) = closest_approach(rays.direction, inv_a, l);
        Some(inside_at(s, m, inv_a, &guard, q, widening))
    }

    #[inline(always)]
    fn plane<S: Simd>(
        rays: &Rays<S>,
        plane: &PlaneCertified,
        widening: &Widening<f32>,
    ) -> Nearness<WideF32<S>> {
        <FarFilter as RowFilter>::plane(rays, plane, widening)
    }
}

impl RowFilter for ParallelFilter {
    #[inline(always)]
    fn sphere<S: Simd>(
        rays: &Rays<S>,
        sphere: &SphereCertified,
        widening: &Widening<f32>,
    ) -> Roots<S> {
        let (a, inv_a) = (rays.a, rays.inv_a);
        let l = a.like3(Vec3(sphere.center)) - rays.origin;
        let (s, m) = approach(rays, l, sphere.outer2)?;
        let (zero, slack, small) = (a.like(0.0), a.like(sphere.slack), a.like(f32::SMALL));
        let (inner, outer) = (a.like(sphere.inner2) - m, a.like(sphere.outer2) - m);
        let h_inner = (inner.max(zero) * inv_a).sqrt();
        let h_outer = (outer.max(zero) * inv_a).sqrt();
        let near_low = (s - h_outer) - slack;
        let near_high = (s - h_inner) + slack;
        let far_low = (s + h_inner) - slack;
        let far_high = (s + h_outer) + slack;
        let is_near = small.lt(near_low);
        let is_far = near_high.le(zero).and(small.lt(far_low));
        let t_low = is_near.select(near_low, far_low);
        let t_high = is_near.select(near_high, far_high);
        let is_missed = outer.lt(zero).or(far_high.le(zero));
        let is_hit = zero.le(inner).and(small.lt(far_low));
        let low = inv_a / t_high.max(small) * a.like(widening.narrower);
        let high = inv_a / t_low.max(small) * a.like(widening.wider);
        let high = is_near.or(is_far).select(high, a.like(f32::LARGEST));
        Some(Nearness { low: is_hit.select(low, zero), high: is_missed.select(zero, high) })
    }

    #[inline(always)]
    fn plane<S: Simd>(
        rays: &Rays<S>,
        plane: &PlaneCertified,
        widening: &Widening<f32>,
    ) -> Nearness<WideF32<S>> {
        let a = rays.a;
        let normal = a.like3(Vec3(plane.normal));
        let offset = (a.like3(Vec3(plane.offset)) - rays.origin)
            + (a.like3(Vec3(plane.offset_low)) - rays.origin_low);
        let n_offset = dot3(offset, normal);
        let slope = dot3(rays.direction, normal);
        let (zero, error) = (a.like(0.0), a.like(plane.n_offset_error));
        let away = n_offset.lt(zero).select(-slope, slope);
        let is_known = error.lt(n_offset.abs());
        // Elsewhere the quotients may be anything, and are not looked at.
        let magnitude = is_known.select(n_offset.abs(), error + error.like(1.0));
        let q = Nearness {
            low: a.like(widening.narrower) / (magnitude + error),
            high: a.like(widening.wider) / (magnitude - error),
        };
        let root = plane_nearness(rays, away, plane.direction_error, q);
        Nearness {
            low: is_known.select(root.low, zero),
            high: is_known.select(root.high, a.like(f32::LARGEST)),
        }
    }
}

/// [`decide_row`] of a filter.
pub(super) type DecideRow = fn(
    &Lists<SphereCertified, PlaneCertified>,
    &Widening<f32>,
    &CameraF32,
    (i64, i64),
    &Control,
    &mut [u32],
) -> Result<usize>;

/// Rays that lie in no row have no quicker way.
#[allow(clippy::unnecessary_wraps, reason = "it stands for one that can be cancelled")]
pub(super) fn no_row(
    _: &Lists<SphereCertified, PlaneCertified>,
    _: &Widening<f32>,
    _: &CameraF32,
    _: (i64, i64),
    _: &Control,
    _: &mut [u32],
) -> Result<usize> {
    Ok(0)
}

/// The ids of the first pixels of a row, as [`super::nearest_listed`] decides them: how many, which is
/// none or all.
///
/// # Errors
/// [`crate::Error::Interrupted`] when `control` was cancelled.
pub(super) fn decide_row<F: RowFilter>(
    lists: &Lists<SphereCertified, PlaneCertified>,
    widening: &Widening<f32>,
    camera: &CameraF32,
    offset: (i64, i64),
    control: &Control,
    ids: &mut [u32],
) -> Result<usize> {
    let row = Row { lists, widening, camera, offset, control, ids };
    pulp::Arch::new().dispatch(WithFilter::<F> { row, filter: PhantomData })
}

/// A row of pixels.
struct Row<'a> {
    lists: &'a Lists<SphereCertified, PlaneCertified>,
    widening: &'a Widening<f32>,
    camera: &'a CameraF32,
    /// [`crate::rays::Pixels::offset2`] of its first pixel.
    offset: (i64, i64),
    control: &'a Control,
    ids: &'a mut [u32],
}

/// A row, compiled for each instruction set that the processor may have.
struct WithFilter<'a, F> {
    row: Row<'a>,
    filter: PhantomData<F>,
}

/// Whole numbers below this are exact in f32, and so are their sums.
const LARGEST_OFFSET: i64 = 1 << 24;

/// Most numbers of a register.
const MOST_LANES: usize = 16;

impl<F: RowFilter> pulp::WithSimd for WithFilter<'_, F> {
    type Output = Result<usize>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Result<usize> {
        let Row { lists, widening, camera, offset: (i, j), control, ids } = self.row;
        let n_lanes = WideF32::<S>::LANES;
        let is_exact = i.abs() + 2 * (ids.len() as i64) < LARGEST_OFFSET;
        if ids.len() < n_lanes || n_lanes > MOST_LANES || !is_exact {
            return Ok(0);
        }
        let places: [f32; MOST_LANES] = std::array::from_fn(|lane| 2.0 * lane as f32);
        let places = WideF32::load(simd, &places);
        let mut at = 0;
        while at < ids.len() {
            // A ray may have millions of spheres to look at.
            control.check()?;
            // The last ones of a row that ends before are looked at again.
            let first = at.min(ids.len() - n_lanes);
            let i = places.like((i + 2 * first as i64) as f32) + places;
            let rays = camera.camera_rays(i, places.like(j as f32));
            let found = decide::<F, S>(simd, &rays, lists, widening);
            let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut ids[first..first + n_lanes]);
            bytes.copy_from_slice(bytemuck::bytes_of(&found));
            at = first + n_lanes;
        }
        Ok(ids.len())
    }
}

/// Pixels or points anywhere in a picture, each at its [`crate::rays::Pixels::offset2`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Places {
    i: Vec<f32>,
    j: Vec<f32>,
}

impl Places {
    /// Adds one, at most 2²³ from the middle.
    pub fn push(&mut self, (i, j): (i64, i64)) {
        self.i.push(i as f32);
        self.j.push(j as f32);
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.i.clear();
        self.j.clear();
    }
}

/// Objects as the rays of a picture see them.
pub(crate) struct SeenObjects<'a> {
    pub lists: &'a Lists<SphereCertified, PlaneCertified>,
    pub widening: Widening<f32>,
    pub camera: &'a CameraF32,
    /// That of [`crate::prepare::Prepared`].
    pub near: bool,
}

impl SeenObjects<'_> {
    /// Replaces `ids` by those of places, as [`super::nearest_listed`] decides them.
    pub fn decide(&self, places: &Places, ids: &mut Vec<u32>) {
        ids.clear();
        ids.resize(places.i.len(), UNDECIDED);
        let (arch, objects) = (pulp::Arch::new(), self);
        match self.camera.lens {
            Lens::Orthographic => {
                let filter = PhantomData::<ParallelFilter>;
                arch.dispatch(AtPlaces { objects, places, ids, filter });
            }
            Lens::Perspective if self.near => {
                let filter = PhantomData::<PointFilter>;
                arch.dispatch(AtPlaces { objects, places, ids, filter });
            }
            Lens::Perspective => {
                let filter = PhantomData::<FarFilter>;
                arch.dispatch(AtPlaces { objects, places, ids, filter });
            }
        }
    }
}

/// The rays at some places, compiled for each instruction set that the processor may have.
struct AtPlaces<'a, F> {
    objects: &'a SeenObjects<'a>,
    places: &'a Places,
    ids: &'a mut [u32],
    filter: PhantomData<F>,
}

impl<F: RowFilter> pulp::WithSimd for AtPlaces<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let AtPlaces { objects, places: Places { i, j }, ids, .. } = self;
        let SeenObjects { lists, widening, camera, .. } = objects;
        let n_lanes = WideF32::<S>::LANES;
        if n_lanes > MOST_LANES {
            return;
        }
        for ((i, j), ids) in i.chunks(n_lanes).zip(j.chunks(n_lanes)).zip(ids.chunks_mut(n_lanes)) {
            let load = |some: &[f32]| {
                let mut all = [0.0; MOST_LANES];
                all[..some.len()].copy_from_slice(some);
                WideF32::load(simd, &all)
            };
            let rays = camera.camera_rays(load(i), load(j));
            let found = decide::<F, S>(simd, &rays, lists, widening);
            let mut all = [0; MOST_LANES];
            bytemuck::cast_slice_mut(&mut all[..n_lanes])
                .copy_from_slice(bytemuck::bytes_of(&found));
            ids.copy_from_slice(&all[..ids.len()]);
        }
    }
}

#[inline(always)]
fn decide<F: RowFilter, S: Simd>(
    simd: S,
    rays: &Rays<S>,
    lists: &Lists<SphereCertified, PlaneCertified>,
    widening: &Widening<f32>,
) -> S::u32s {
    let zero = rays.a.like(0.0);
    let (none, undecided) = (simd.splat_u32s(0), simd.splat_u32s(UNDECIDED));
    let mut nearest = NearestOf::none(zero, none);
    let mut id = 0;
    for sphere in &lists.spheres {
        id += 1;
        if let Some(roots) = F::sphere(rays, sphere, widening) {
            nearest.nearer(roots, simd.splat_u32s(id));
        }
    }
    if F::IS_FAR {
        nearest.low = nearest.low * zero.like(widening.far_narrower);
    }
    for plane in &lists.planes {
        id += 1;
        nearest.nearer(F::plane(rays, plane, widening), simd.splat_u32s(id));
    }
    let is_certain = nearest.second_high.lt(nearest.low);
    // Without a candidate no upper bound is above 0, and the id is 0.
    let is_empty = nearest.high.le(zero);
    is_certain.or(is_empty).select_whole(nearest.id, undecided)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;

    use super::UNDECIDED;
    use crate::control::Control;
    use crate::kernel::arithmetic::Arithmetic;
    use crate::kernel::coordinates::Coordinates;
    use crate::kernel::twin::{Twin, WithTwin};
    use crate::kernel::{Kernel, Objects};
    use crate::prepare::Prepared;
    use crate::random::SplitMix;
    use crate::rays::{Pixels, View};
    use crate::scene::{Camera, Color, Plane, Projection, Scene, Sphere};
    use crate::trace::Rays;

    /// The ids of a picture's rows, and those of its rays one by one.
    struct Both<'a> {
        pixels: &'a Pixels,
        coordinates: Coordinates,
    }

    impl WithTwin for Both<'_> {
        type Output = [Vec<u32>; 2];

        fn with<T: Twin>(self, twin: &T) -> [Vec<u32>; 2] {
            let Both { pixels, coordinates } = self;
            let camera = T::Float::camera(&coordinates, pixels);
            let (mut rows, mut alone) = (Vec::new(), Vec::new());
            for y in 0..pixels.height {
                let mut ids = vec![0; pixels.width as usize];
                let offset = pixels.offset2(0, y);
                let n = twin.row(&camera, offset, &Control::default(), &mut ids).unwrap();
                assert!(n == ids.len() || n == 0 && n < 16, "{n} of a row");
                let ray =
                    |x: usize| T::Float::pixel_ray(&camera, offset.0 + 2 * x as i64, offset.1);
                alone.extend((0..n).map(|x| twin.closest(&ray(x)).id));
                rows.extend(&ids[..n]);
            }
            [rows, alone]
        }
    }

    fn both(scene: Scene, pixels: Pixels) -> [Vec<u32>; 2] {
        let rays = Rays::Pixels(pixels);
        let prepared = Prepared::new(Arc::new(scene), Kernel::Certified, &rays).unwrap();
        assert!(matches!(prepared.objects, Objects::Certified(_)));
        let both = Both { pixels: &pixels, coordinates: prepared.coordinates() };
        prepared.objects.with_twin(prepared.bundle(), prepared.near, both)
    }

    /// Spheres of all sizes about an eye, some around it or through it, and planes, some through it.
    fn case(seed: u64, projection: Projection) -> (Scene, Pixels) {
        let mut rng = SplitMix::new(seed);
        let mut number = || 2.0 * rng.unit() - 1.0;
        let mut vector = || DVec3::new(number(), number(), number());
        let position = vector() * 10.0;
        let mut size = || 10f64.powf(2.0 * vector().x);
        let sphere = |k: u64, center: DVec3, size: f64| match (seed + k) % 4 {
            0 => Sphere { center, radius: center.distance(position) },
            1 => Sphere { center, radius: center.distance(position) * (1.0 + 1e-6 * size) },
            _ => Sphere { center, radius: size },
        };
        let n_spheres = seed % 9;
        let spheres: Vec<Sphere> = (0..n_spheres)
            .map(|k| {
                let (radius, away) = (size(), 10.0 * size());
                let center = position + DVec3::new(size() - 1.0, 1.0 - size(), size()) * away;
                sphere(k, center, radius)
            })
            .collect();
        let plane = |k: u64| Plane {
            name: None,
            point: position + DVec3::new(0.0, k as f64 - 1.0, 1e-7),
            normal: DVec3::new(1e-3 * k as f64, 1.0, -0.1),
            color: Color::BLACK,
        };
        let planes = (0..seed % 4).map(plane).collect();
        let look_at = spheres.first().map_or(DVec3::ZERO, |sphere| sphere.center);
        let camera = Camera { position, look_at, up: DVec3::new(0.1, 1.0, 0.3), projection };
        let pixels = Pixels::whole(View::new(&camera), 16 + (seed % 37) as u32, 5);
        (Scene { spheres: spheres.into(), planes, ..Scene::default() }, pixels)
    }

    #[test]
    fn rows_propose_what_their_rays_alone_do() {
        for projection in [
            Projection::Perspective { fov_degrees: 40.0 },
            Projection::Perspective { fov_degrees: 150.0 },
            Projection::Orthographic { height: 30.0 },
        ] {
            let [mut n_hits, mut n_open, mut n_missed] = [0; 3];
            for seed in 0..600 {
                let (scene, pixels) = case(seed, projection);
                let [rows, alone] = both(scene, pixels);
                assert_eq!(rows, alone, "seed {seed}");
                assert!(!rows.is_empty());
                n_hits += rows.iter().filter(|&&id| id != 0 && id != UNDECIDED).count();
                n_open += rows.iter().filter(|&&id| id == UNDECIDED).count();
                n_missed += rows.iter().filter(|&&id| id == 0).count();
            }
            println!("{projection:?}: {n_hits} hits, {n_open} open, {n_missed} missed");
            assert!(n_hits > 10_000 && n_open > 100 && n_missed > 1000);
        }
    }
}
