//! The formulas that a device has from the Rust text.

use kugelblitz::gpu::slabs::{SlabInterval, Slabs, is_near};
use kugelblitz::kernel::relative::{from_center, plane_stable, sphere_stable};
use kugelblitz::num::fields::{FieldSink, FieldSource, Fields};
use kugelblitz::num::{Ray, Real, V3};
use kugelblitz::rays::{camera_direction, camera_origin};
use kugelblitz::shape::shadow::Aim;
use kugelblitz::shape::{
    Anchor, Bounds, GroundOccluder, LightBounds, Nearest, Occlusion, PlaneOccluder, PlaneRecord,
    ShadowRay, ShapeRecord, SphereLeaf, SphereOccluder, SphereRecord, Surface, SurfaceErrorTerms,
};

use super::{Wgsl as W, WgslId, declaration, function};

const HEAD: &str = "// Printed from the Rust text; see tests/library/printed.rs.\n\n";

/// The files of `shaders/printed`, with their texts.
pub fn all() -> [(&'static str, String); 4] {
    [
        ("camera.wgsl", camera()),
        ("relative.wgsl", relative()),
        ("shape.wgsl", seen()),
        ("light.wgsl", light()),
    ]
}

/// One text, with one line's end.
fn joined(parts: &[String]) -> String {
    parts.concat().trim_end().to_string() + "\n"
}

/// One text for kernels in f32 and in f64.
fn of_any_float(parts: &[String]) -> String {
    joined(parts).replace("vec3f", "Vec3").replace("f32", "Real")
}

/// The rays of cameras.
fn camera() -> String {
    of_any_float(&[
        HEAD.into(),
        function!(camera_direction(
            forward: V3<W>, right: V3<W>, true_up: V3<W>, across: W, up: W
        ) camera_direction(forward, right, true_up, across, up)),
        function!(camera_origin(right: V3<W>, true_up: V3<W>, across: W, up: W)
            camera_origin(right, true_up, across, up)),
    ])
}

/// Where rays meet objects, without a proof and without cancellation.
fn relative() -> String {
    of_any_float(&[
        HEAD.into(),
        function!(sphere_stable(ray: Ray<W>, l: V3<W>, r: W, k: W)
            sphere_stable(&ray, l, r, k)),
        function!(from_center(ray: Ray<W>, l: V3<W>, r: W, k: W) from_center(&ray, l, r, k)),
        function!(plane_stable(d: V3<W>, n_offset: W, n: V3<W>) plane_stable(d, n_offset, n)),
    ])
}

/// Where rays meet objects and the boxes of the tree, and which object is the nearest.
fn seen() -> String {
    let none = "no ray misses for sure while formulas are printed";
    joined(&[
        HEAD.into(),
        declaration::<Ray<W>>(),
        declaration::<Bounds<W>>(),
        declaration::<Nearest<W>>(),
        declaration::<SphereLeaf<W>>(),
        declaration::<SphereRecord<W>>(),
        declaration::<PlaneRecord<W>>(),
        function!(ray_from(origin: V3<W>, direction: V3<W>) Ray::new(origin, direction)),
        function!(leaf_bounds(leaf: SphereLeaf<W>, ray: Ray<W>) leaf.bounds(&ray).expect(none)),
        function!(sphere_leaf(sphere: SphereRecord<W>) sphere.leaf()),
        function!(sphere_bounds_close(sphere: SphereRecord<W>, ray: Ray<W>)
            SphereRecord::bounds_close(&sphere, &ray).expect(none)),
        function!(plane_bounds(plane: PlaneRecord<W>, ray: Ray<W>)
            PlaneRecord::bounds(&plane, &ray).expect(none)),
        function!(nearest_none() Nearest::<W>::none()),
        function!(nearest_with(nearest: Nearest<W>, next: Bounds<W>, id: WgslId)
            nearest.with(next, id)),
        function!(decide(nearest: Nearest<W>) nearest.decide().0),
        declaration::<Slabs<W>>(),
        declaration::<SlabInterval<W>>(),
        function!(slabs_of(ray: Ray<W>, beside: W) Slabs::new(&ray, beside)),
        function!(between(slabs: Slabs<W>, low: V3<W>, high: V3<W>) slabs.between(low, high)),
        function!(is_within(stretch: SlabInterval<W>, t_max: W) stretch.is_within(t_max)),
    ])
}

/// What light asks of a [`Surface`].
struct SurfacePoint {
    point: V3<W>,
    point_error: W,
    normal: V3<W>,
    normal_error: W,
    /// 1 where the ray comes from outside, else −1.
    front: W,
}

impl From<Surface<W>> for SurfacePoint {
    fn from(surface: Surface<W>) -> SurfacePoint {
        let Surface { point, point_error, normal, normal_error, front, .. } = surface;
        let front = W::select(front, W::lit(1.0), W::lit(-1.0));
        SurfacePoint { point, point_error, normal, normal_error, front }
    }
}

impl Fields<W> for SurfacePoint {
    const NAME: &'static str = "SurfacePoint";

    fn read(source: &mut impl FieldSource<W>) -> SurfacePoint {
        SurfacePoint {
            point: source.vec("point"),
            point_error: source.num("point_error"),
            normal: source.vec("normal"),
            normal_error: source.num("normal_error"),
            front: source.num("front"),
        }
    }

    fn write(&self, sink: &mut impl FieldSink<W>) {
        sink.vec("point", self.point);
        sink.num("point_error", self.point_error);
        sink.vec("normal", self.normal);
        sink.num("normal_error", self.normal_error);
        sink.num("front", self.front);
    }
}

/// The light on what rays see, and what is in its way.
fn light() -> String {
    joined(&[
        HEAD.into(),
        declaration::<SurfaceErrorTerms<W>>(),
        declaration::<SurfacePoint>(),
        declaration::<Anchor<W>>(),
        declaration::<SphereOccluder<W>>(),
        declaration::<PlaneOccluder<W>>(),
        declaration::<GroundOccluder<W>>(),
        declaration::<Aim<W>>(),
        declaration::<ShadowRay<W>>(),
        declaration::<Occlusion<W>>(),
        declaration::<LightBounds<W>>(),
        function!(sphere_surface_far(sphere: SphereRecord<W>, ray: Ray<W>, lengths: SurfaceErrorTerms<W>)
            SurfacePoint::from(SphereRecord::surface(&sphere, &ray, &lengths))),
        function!(sphere_surface_close(sphere: SphereRecord<W>, ray: Ray<W>, lengths: SurfaceErrorTerms<W>)
            SurfacePoint::from(SphereRecord::surface_close(&sphere, &ray, &lengths))),
        function!(anchor_ray(
            anchor: Anchor<W>, right: V3<W>, up: V3<W>, across: W, above: W, ray: Ray<W>
        ) anchor.ray((right, up), [across, above], &ray)),
        function!(plane_surface(plane: PlaneRecord<W>, ray: Ray<W>, lengths: SurfaceErrorTerms<W>)
            SurfacePoint::from(PlaneRecord::surface(&plane, &ray, &lengths))),
        function!(shadow_ray(aim: Aim<W>, point: V3<W>, point_error: W)
            ShadowRay::new(&aim, point, point_error)),
        function!(is_near(ray: ShadowRay<W>) is_near(&ray)),
        function!(shadow_slabs(ray: ShadowRay<W>) Slabs::to_light(&ray)),
        function!(cosine(ray: ShadowRay<W>, normal: V3<W>, normal_error: W) {
            let (low, high) = ray.cosine(normal, normal_error);
            Bounds { low, high }
        }),
        function!(sphere_occludes(met: SphereOccluder<W>, ray: ShadowRay<W>)
            SphereOccluder::occlude(&met, &ray, None)),
        function!(plane_occludes(met: PlaneOccluder<W>, ray: ShadowRay<W>)
            PlaneOccluder::occlude(&met, &ray, None)),
        function!(sphere_occludes_beside(met: SphereOccluder<W>, ray: ShadowRay<W>, side: W)
            SphereOccluder::occlude(&met, &ray, Some(side))),
        function!(plane_occludes_beside(met: PlaneOccluder<W>, ray: ShadowRay<W>, side: W)
            PlaneOccluder::occlude(&met, &ray, Some(side))),
        function!(ground_occludes(met: GroundOccluder<W>, ray: ShadowRay<W>)
            GroundOccluder::occlude(&met, &ray, None)),
        function!(ground_occludes_beside(met: GroundOccluder<W>, ray: ShadowRay<W>, side: W)
            GroundOccluder::occlude(&met, &ray, Some(side))),
        function!(verdict_with(verdict: Occlusion<W>, next: Occlusion<W>) verdict.with(next)),
        function!(behind(given: Bounds<W>, verdict: Occlusion<W>) given.behind(&verdict)),
        function!(light_with(light: LightBounds<W>, weight: V3<W>, given: Bounds<W>)
            light.with(weight, given)),
        function!(light_on(light: LightBounds<W>, color: V3<W>) light.on(color)),
        function!(light_plus(light: LightBounds<W>, other: LightBounds<W>) light.plus(other)),
        function!(light_mean(sum: LightBounds<W>, n: W, width: Bounds<W>) sum.mean(n, width)),
    ])
}
