//! The formulas of the kernels `stable` (f32) and `double` (f64): relative to the ray's origin, and
//! free of cancellation. `shaders/printed/relative.wgsl` is printed from them.
//!
//! The discriminant is `r² − ‖P‖²`, the roots come without cancellation, and the normal comes from
//! half the chord. Offsets from the ray's origin are formed in f64 on the host where all rays start at one point, and from
//! high and low parts elsewhere. `stable` is the best that f32 can do without a proof, `double` all that one would do without
//! this crate's design: more digits make wrong objects rare, but nothing says which rays they are.

use bytemuck::{Pod, Zeroable};
use glam::DVec3;

use super::baseline::{Baseline, BaselineRay, first_positive};
use super::coordinates::split;
use super::info::{FloatType, KernelInfo, Promise, Space, part};
use crate::num::{self, Float as _, Mask, Ray, Real, ScaledInteger, V3};
use crate::scene::{Plane, Sphere};

/// The facts of the kernel `stable`.
pub(super) const STABLE: KernelInfo = KernelInfo {
    name: "stable",
    float: FloatType::F32,
    record_bytes: [size_of::<SphereStable>(), size_of::<PlaneStable>()],
    record_names: "Relative",
    shader_parts: &[part!("ray.wgsl"), part!("printed/relative.wgsl"), part!("relative.wgsl")],
    space: Space::Reference,
    promise: Promise::PARITY,
};

/// The facts of the kernel `double`.
pub(super) const DOUBLE: KernelInfo = KernelInfo {
    name: "double",
    float: FloatType::F64,
    record_bytes: [size_of::<SphereDouble>(), size_of::<PlaneDouble>()],
    ..STABLE
};

/// The ray's closest approach to a centre at `l = c − o`.
#[derive(Clone, Copy, Debug)]
pub struct Approach<R> {
    /// Offset from the closest point of the line to the centre.
    pub p: V3<R>,
    /// `d·l`
    pub b: R,
    /// `r² − p·p`
    pub delta: R,
}

/// Discriminant as `r² − ‖P‖²` (Hearn & Baker; Ray Tracing Gems, ch. 7, eq. 5).
#[inline(always)]
pub fn approach<R: Real>(ray: &Ray<R>, l: V3<R>, r: R) -> Approach<R> {
    let b = ray.direction.dot(l);
    let p = l - ray.direction * (b * ray.inv_a);
    Approach { p, b, delta: r * r - p.dot(p) }
}

/// Half the chord times `‖d‖²`: `√(a·(r² − p·p))`; negative for a miss.
#[inline(always)]
#[track_caller]
pub fn half_root<R: Real>(ray: &Ray<R>, delta: R) -> R {
    R::select(R::lit(0.0).le(delta), (ray.a * delta).sqrt(), R::lit(-1.0))
}

/// Near and far root without cancellation: `q` and `k/q` (Press et al., Numerical Recipes, 5.6),
/// with `k = l·l − r²` and `h ≥ 0`.
#[inline(always)]
pub fn roots_stable<R: Real>(ray: &Ray<R>, b: R, h: R, k: R) -> [R; 2] {
    let is_ahead = R::lit(0.0).lt(b);
    let q = R::select(is_ahead, b + h, b - h);
    let (one, other) = (k / q, q * ray.inv_a);
    let (near, far) = (R::select(is_ahead, one, other), R::select(is_ahead, other, one));
    [near, far]
}

/// The smallest positive root, or 0 for none.
#[inline(always)]
pub fn sphere_stable<R: Real>(ray: &Ray<R>, l: V3<R>, r: R, k: R) -> R {
    let (Approach { b, delta, .. }, zero) = (approach(ray, l, r), R::lit(0.0));
    if !zero.le(delta).any() {
        return zero;
    }
    let h = half_root(ray, delta);
    R::select(zero.le(h), first_positive(roots_stable(ray, b, h, k)), zero)
}

/// `t = ((a − o)·n) / (d·n)`. The positive `t`, or 0 for none.
#[inline(always)]
pub fn plane_stable<R: Real>(d: V3<R>, n_offset: R, n: V3<R>) -> R {
    let (t, zero) = (n_offset / d.dot(n), R::lit(0.0));
    R::select(zero.lt(t), t, zero)
}

/// The way from half the chord to the normal's end, times the radius: `o + t·d − c` cancels far away.
#[inline(always)]
pub fn from_center<R: Real>(ray: &Ray<R>, l: V3<R>, r: R, k: R) -> V3<R> {
    let Approach { p, delta, .. } = approach(ray, l, r);
    let half_chord = ray.direction * (half_root(ray, delta) * ray.inv_a);
    let is_outside = R::lit(0.0).lt(k);
    V3::select(is_outside, -half_chord, half_chord) - p
}

macro_rules! records {
    ($float:ident, $sphere:ident, $plane:ident) => {
        /// A sphere as the device sees it.
        #[derive(Clone, Copy, Debug, Pod, Zeroable)]
        #[repr(C)]
        pub struct $sphere {
            /// Centre relative to the reference point, high part.
            pub center: [$float; 3],
            /// Radius.
            pub radius: $float,
            /// Centre relative to the reference point, low part; −0 in f64, whose shader leaves it out.
            pub center_low: [$float; 3],
            /// `l·l − r²` for the reference point, rounded from f64.
            pub k: $float,
        }

        /// A plane as the device sees it.
        #[derive(Clone, Copy, Debug, Pod, Zeroable)]
        #[repr(C)]
        pub struct $plane {
            /// Point of the plane relative to the reference point, high part.
            pub offset: [$float; 3],
            /// `(a − o)·n` for the reference point, rounded from f64.
            pub n_offset: $float,
            /// Point of the plane relative to the reference point, low part; −0 in f64, whose shader leaves it out.
            pub offset_low: [$float; 3],
            /// Fills WGSL's alignment of vectors.
            pub pad0: $float,
            /// Normal, scaled by a power of two to a largest component in `1..2`.
            pub normal: [$float; 3],
            /// Fills WGSL's alignment of vectors.
            pub pad1: $float,
        }

        impl $sphere {
            /// Relative to `reference`.
            pub fn new(sphere: &Sphere, reference: DVec3) -> $sphere {
                let (l, radius) = (sphere.center - reference, sphere.radius);
                let ([center, low], k) = (split(l), l.length_squared() - radius * radius);
                let center_low = low_part(low);
                $sphere { center, radius: radius as $float, center_low, k: k as $float }
            }

            /// `l = c − o`
            #[inline(always)]
            pub fn offset<R: Real<One = $float>>(&self, ray: &BaselineRay<R>) -> V3<R> {
                offset(ray, self.center, self.center_low)
            }

            /// `k = l·l − r²`
            #[inline(always)]
            pub fn k<R: Real<One = $float>>(&self, ray: &BaselineRay<R>, l: V3<R>) -> R {
                let r = R::splat(self.radius);
                if ray.origin_low.is_none() { R::splat(self.k) } else { l.dot(l) - r * r }
            }
        }

        impl $plane {
            /// Relative to `reference`.
            pub fn new(plane: &Plane, reference: DVec3) -> $plane {
                let (l, normal) =
                    (plane.point - reference, ScaledInteger::new(plane.normal).rounded());
                let [offset, low] = split(l);
                $plane {
                    offset,
                    n_offset: l.dot(normal) as $float,
                    offset_low: low_part(low),
                    pad0: 0.0,
                    normal: V3::lit(normal).0,
                    pad1: 0.0,
                }
            }

            /// `(a − o)·n`
            #[inline(always)]
            pub fn n_offset<R: Real<One = $float>>(&self, ray: &BaselineRay<R>) -> R {
                let l = offset(ray, self.offset, self.offset_low);
                let is_given = ray.origin_low.is_none();
                if is_given { R::splat(self.n_offset) } else { l.dot(V3::splat(V3(self.normal))) }
            }
        }

        impl Baseline for $sphere {
            type Float = $float;

            #[inline(always)]
            fn t<R: Real<One = $float>>(&self, ray: &BaselineRay<R>) -> R {
                let r = R::splat(self.radius);
                // In both arms a `t`: an offset that is the same in all lanes would take them apart.
                match ray.origin_low {
                    None => {
                        sphere_stable(&ray.ray, V3::splat(V3(self.center)), r, R::splat(self.k))
                    }
                    Some(_) => {
                        let l = self.offset(ray);
                        sphere_stable(&ray.ray, l, r, self.k(ray, l))
                    }
                }
            }

            #[inline(always)]
            fn normal<R: Real<One = $float>>(&self, ray: &BaselineRay<R>, _: R) -> V3<R> {
                let l = self.offset(ray);
                from_center(&ray.ray, l, R::splat(self.radius), self.k(ray, l))
            }
        }

        impl Baseline for $plane {
            type Float = $float;

            #[inline(always)]
            fn t<R: Real<One = $float>>(&self, ray: &BaselineRay<R>) -> R {
                plane_stable(ray.ray.direction, self.n_offset(ray), V3::splat(V3(self.normal)))
            }

            #[inline(always)]
            fn normal<R: Real<One = $float>>(&self, _: &BaselineRay<R>, _: R) -> V3<R> {
                V3::splat(V3(self.normal))
            }
        }
    };
}
records!(f32, SphereStable, PlaneStable);
records!(f64, SphereDouble, PlaneDouble);

/// The second part of a record's vector: of f64 −0, which changes nothing that it is added to, as 0 would change −0.
fn low_part<F: num::Float>(low: [F; 3]) -> [F; 3] {
    if F::UNIT < f32::UNIT { [-F::default(); 3] } else { low }
}

/// From a ray's origin to a point in two parts, relative to the reference point.
#[inline(always)]
fn offset<R: Real>(ray: &BaselineRay<R>, high: [R::One; 3], low: [R::One; 3]) -> V3<R> {
    let high = V3::splat(V3(high));
    match ray.origin_low {
        None => high,
        Some(origin_low) => (high - ray.ray.origin) + (V3::splat(V3(low)) - origin_low),
    }
}
