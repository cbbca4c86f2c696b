//! Objects as rays see them: a file a shape, with the numbers that it becomes and the formula of where a ray meets it.
//! Each formula is written once, and runs in f32, f64 and lanes of both.
//!
//! Rays are relative to the eye's reference point, and no direction is shorter than 1.
//!
//! # Out of range
//! A record of an object that is farther away than [`Float::FARTHEST`], or whose size is out of range, lies at the reference
//! point, with errors that leave everything undecided: the hit, its side, and all points and normals. The record
//! of such a sphere still rules out rays: a tiny sphere gets the record of a larger one, and in f32 a far sphere gets the record
//! of a nearer one.
//!
//! Rays start up to [`RayOrigin::spread`] from the reference point, so the numbers of a record must be bounds for all such origins. The spread
//! itself is in range: the functions that make rays ensure this.

mod anchor;
mod contact;
mod ground;
mod light;
mod plane;
pub mod shadow;
mod sphere;

use glam::DVec3;

pub use anchor::{Anchor, Anchors};
pub use contact::Contact;
pub use ground::GroundOccluder;
pub use light::LightBounds;
pub use plane::{PlaneOccluder, PlaneRecord};
pub use shadow::{Occlusion, ShadowRay};
pub use sphere::{SphereLeaf, SphereOccluder, SphereRecord, is_near_surface};

use crate::bounds::{self, Footprint, InputError, ROOM, rows, steps};
pub use crate::num::Ray;
use crate::num::fields::{fields, numbers, words};
use crate::num::{Float, Lanes, Real, UNDECIDED, V3};
use crate::rays::Pixels;
use crate::scene::Object;

/// The numbers of an object in f64. Those in another number, and in all lanes, come from these.
pub trait Record: Copy {
    /// The record in numbers of `R`.
    type In<R: Real>: Copy;
    /// Each field by its rule: `near`, `down` or `up`.
    fn round<F: Float>(&self) -> Self::In<F>;
    /// One record in all lanes.
    fn splat<R: Real>(one: &Self::In<R::One>) -> Self::In<R>;
}

/// A record in numbers of `R`.
pub type In<T, R> = <T as Record>::In<R>;

/// Declares a record: fields are a `num` or a `vec`, and are rounded `near`, `down` or `up`.
macro_rules! record {
    ($(#[$doc:meta])* $name:ident { $($(#[$note:meta])* $field:ident: $kind:ident $rule:ident,)* }) => {
        $(#[$doc])*
        #[derive(bytemuck::Zeroable)]
        pub struct $name<R> {
            $($(#[$note])* pub $field: $crate::shape::record!(@type $kind R),)*
        }

        // A derive cannot look into a macro that stands for a type.
        impl<R: Copy> Clone for $name<R> {
            #[inline(always)]
            fn clone(&self) -> Self {
                *self
            }
        }

        impl<R: Copy> Copy for $name<R> {}

        $crate::num::fields::numbers! { $name { $($field: $kind),* } }

        impl $crate::shape::Record for $name<f64> {
            type In<R: $crate::num::Real> = $name<R>;

            fn round<F: $crate::num::Float>(&self) -> $name<F> {
                $name { $($field: $crate::num::fields::numbers!(@each $kind self.$field, F::$rule),)* }
            }

            #[inline(always)]
            fn splat<R: $crate::num::Real>(one: &$name<R::One>) -> $name<R> {
                one.map(R::splat)
            }
        }

        impl<const N: usize> $name<$crate::num::Lanes<f64, N>> {
            /// Rounds each field of records side by side by its rule.
            #[inline(always)]
            pub fn round_lanes<F: $crate::num::Float>(self) -> $name<$crate::num::Lanes<F, N>> {
                $name { $($field: $crate::num::fields::numbers!(
                    @each $kind self.$field, |x: $crate::num::Lanes<f64, N>| x.each(F::$rule)
                ),)* }
            }
        }
    };
    (@type num $R:ident) => { $R };
    (@type vec $R:ident) => { $crate::num::V3<$R> };
}
use record;

/// The rays that see objects: the point that their numbers are relative to, how far from it they start, and what they are
/// off by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayOrigin {
    /// A point of the scene.
    pub reference: DVec3,
    /// Bound of an origin's distance from there; at most [`Float::FARTHEST`].
    pub spread: f64,
    /// What the numbers of a ray are off by.
    pub input: InputError,
    /// How far the rays may be apart for which one ray stands.
    pub reach: Footprint,
    /// The unit of rounding that bounds are in: [`Float::UNIT`] where a device has a part in it, the host's own elsewhere.
    pub unit: f64,
}

impl RayOrigin {
    /// The rays of a picture as objects' numbers in arithmetic with this unit ask for them. One of them stands for all within
    /// `reach`.
    pub fn of_pixels(pixels: &Pixels, reach: Footprint, unit: f64) -> RayOrigin {
        RayOrigin {
            reference: pixels.view.position,
            spread: pixels.spread(),
            input: bounds::input_of(pixels.view.lens),
            reach,
            unit,
        }
    }

    /// Rays of a list as objects' numbers in f32 ask for them, with origins up to `spread` from a point.
    pub fn of_list(reference: DVec3, spread: f64) -> RayOrigin {
        RayOrigin {
            reference,
            spread,
            input: bounds::LIST,
            reach: Footprint::default(),
            unit: f32::UNIT,
        }
    }
}

/// Bounds of the `t` at which an object is seen. `low` at least [`Float::BEYOND`]: surely nowhere. `high` there: perhaps
/// nowhere.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bounds<R> {
    /// Lower bound.
    pub low: R,
    /// Upper bound.
    pub high: R,
}

numbers! { Bounds { low: num, high: num } }

/// What the rays of an eye share where they meet an object.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceErrorTerms<R> {
    /// No direction is longer.
    pub longest: R,
    /// What `t` counts in a point's error: the direction's own, and the rounding of `o + t·d`.
    pub of_t: R,
    /// What comes with the farthest origin.
    pub of_origin: R,
    /// What a normal `(t·d − l)/r` is off by for its own roundings.
    pub of_normal: R,
    /// What a number that is rounded is off by, relative.
    pub rounding: R,
    /// What a plane's `t` is off by for its roundings, relative.
    pub of_quotient: R,
}

numbers! {
    SurfaceErrorTerms {
        longest: num, of_t: num, of_origin: num, of_normal: num, rounding: num, of_quotient: num,
    }
}

impl<F: Float> SurfaceErrorTerms<F> {
    /// The lengths of an eye no direction of whose rays is longer than `longest`.
    pub fn new(eye: &RayOrigin, longest: f64) -> SurfaceErrorTerms<F> {
        let InputError { offset, direction } = eye.input;
        let of_t = ROOM * eye.unit * (direction + steps::POINT) * longest;
        let of_origin = ROOM * eye.unit * (offset + steps::POINT_ORIGIN) * eye.spread;
        // With that of the radius' inverse, and a sum with its error. No test sees the 2 halved: the inverse is rounded but once.
        let of_normal = ROOM * eye.unit * (steps::NORMAL_OF_POINT + 2.0);
        SurfaceErrorTerms {
            longest: F::up(ROOM * longest),
            of_t: F::up(of_t),
            of_origin: F::up(of_origin),
            of_normal: F::up(of_normal),
            rounding: F::up(ROOM * eye.unit),
            of_quotient: F::up(eye.unit * rows::INVERSE),
        }
    }
}

/// Where a ray that is known to hit an object does so. What is not known is off by [`Float::KNOWN`] or more.
#[derive(Clone, Copy, Debug)]
pub struct Surface<R: Real> {
    /// Bounds of `t`, the lower one 0 or the upper one [`Float::BEYOND`] where there is none.
    pub t: Bounds<R>,
    /// The point, relative to the eye's reference point.
    pub point: V3<R>,
    /// Bound of its distance from the true one.
    pub point_error: R,
    /// The normal, of about unit length, against the ray.
    pub normal: V3<R>,
    /// Bound of its distance from the true unit normal,
    pub normal_error: R,
    /// and of that of each component, with room for one sum.
    pub component_error: V3<R>,
    /// Where the ray comes from outside, as any does that hits a plane.
    pub front: R::Mask,
}

impl<R: Real> Default for Surface<R> {
    fn default() -> Surface<R> {
        Surface::unknown()
    }
}

impl<F: Float, const N: usize> Surface<Lanes<F, N>> {
    /// That of a lane.
    pub fn lane(&self, lane: usize) -> Surface<F> {
        let of = |v: &V3<Lanes<F, N>>| v.map(|x| x.0[lane]);
        Surface {
            t: self.t.map(|t| t.0[lane]),
            point: of(&self.point),
            point_error: self.point_error.0[lane],
            normal: of(&self.normal),
            normal_error: self.normal_error.0[lane],
            component_error: of(&self.component_error),
            front: self.front.0[lane] != F::Bits::default(),
        }
    }
}

impl<R: Real> Surface<R> {
    /// Where something is known.
    #[inline(always)]
    pub fn is_known(&self) -> R::Mask {
        self.point_error.lt(R::lit(R::One::KNOWN))
    }

    /// A surface of which nothing is known.
    #[inline(always)]
    pub fn unknown() -> Surface<R> {
        let (zero, beyond) = (R::lit(0.0), R::lit(R::One::BEYOND));
        Surface {
            t: Bounds { low: zero, high: beyond },
            point: V3([zero; 3]),
            point_error: beyond,
            normal: V3([zero; 3]),
            normal_error: beyond,
            component_error: V3([beyond; 3]),
            front: zero.lt(zero),
        }
    }

    /// The way along a ray to the middle of two bounds of `t`, and what it and the point there are off by, but for the
    /// origin: half the bounds' difference, `δε` of the direction, and the roundings of middle, product and sum.
    #[inline(always)]
    fn along(t: Bounds<R>, ray: &Ray<R>, lengths: &SurfaceErrorTerms<R>) -> (V3<R>, R) {
        let half = (t.high - t.low) * R::lit(0.5);
        let middle = t.low + half;
        let error = lengths.longest * half + lengths.of_t * middle;
        (ray.direction * middle, error)
    }

    /// `yes` where the mask holds, `no` elsewhere.
    #[inline(always)]
    pub fn select(mask: R::Mask, yes: Surface<R>, no: Surface<R>) -> Surface<R> {
        let number = |yes: R, no: R| R::select(mask, yes, no);
        Surface {
            t: Bounds { low: number(yes.t.low, no.t.low), high: number(yes.t.high, no.t.high) },
            point: V3::select(mask, yes.point, no.point),
            point_error: number(yes.point_error, no.point_error),
            normal: V3::select(mask, yes.normal, no.normal),
            normal_error: number(yes.normal_error, no.normal_error),
            component_error: V3::select(mask, yes.component_error, no.component_error),
            front: (mask & yes.front) | (!mask & no.front),
        }
    }
}

/// An object as an eye sees it.
pub trait ShapeRecord: Record {
    /// Whether [`ShapeRecord::is_close`] ever holds of such objects.
    const CAN_BE_CLOSE: bool = false;
    /// Whether [`ShapeRecord::bounds_close`] is needed.
    fn is_close(&self) -> bool {
        false
    }
    /// Where a ray meets it; `None` where surely no lane does.
    fn bounds<R: Real>(seen: &In<Self, R>, ray: &Ray<R>) -> Option<Bounds<R>>;
    /// Where a ray meets an object so large and so close that its size hides its distance; `None` where surely no lane does.
    #[inline(always)]
    fn bounds_close<R: Real>(seen: &In<Self, R>, ray: &Ray<R>) -> Option<Bounds<R>> {
        Self::bounds(seen, ray)
    }
    /// Where a ray that is known to hit it does so.
    fn surface<R: Real>(
        seen: &In<Self, R>,
        ray: &Ray<R>,
        lengths: &SurfaceErrorTerms<R>,
    ) -> Surface<R>;
    /// Where a ray that is known to hit an object that [`ShapeRecord::is_close`] does so.
    #[inline(always)]
    fn surface_close<R: Real>(
        seen: &In<Self, R>,
        ray: &Ray<R>,
        lengths: &SurfaceErrorTerms<R>,
    ) -> Surface<R> {
        Self::surface(seen, ray, lengths)
    }
}

/// Where a ray of an eye meets an object that has no record yet, in f64.
#[inline(always)]
pub fn bounds_from(eye: &RayOrigin, object: Object, ray: &Ray<f64>) -> Option<Bounds<f64>> {
    match object {
        Object::Sphere(sphere) => {
            let center = V3((sphere.center - eye.reference).to_array());
            SphereLeaf::at::<f64>(center, sphere.radius.abs(), eye).bounds(ray)
        }
        Object::Plane(plane) => {
            let l = V3((plane.point - eye.reference).to_array());
            PlaneRecord::bounds(&PlaneRecord::of::<f64>(plane, l, eye), ray)
        }
    }
}

/// Any object as shadow rays meet it.
#[derive(Clone, Copy)]
pub enum Occluder<F: Copy> {
    /// A sphere.
    Sphere(SphereOccluder<F>),
    /// A plane.
    Plane(PlaneOccluder<F>),
    /// A large sphere that the reference point is close to.
    Ground(GroundOccluder<F>),
    /// An object that no shadow ray reaches.
    Beyond,
}

impl<F: Float> Occluder<F> {
    /// For arithmetic of `F`, from a reference point.
    pub fn new(object: Object, reference: DVec3) -> Occluder<F> {
        match object {
            Object::Sphere(sphere) => match GroundOccluder::new(sphere, reference) {
                Some(met) => Occluder::Ground(met),
                None => Occluder::Sphere(SphereOccluder::new(sphere, reference)),
            },
            Object::Plane(plane) => Occluder::Plane(PlaneOccluder::new(plane, reference)),
        }
    }

    /// Returns whether the object occludes a light for rays that do not start on it. `side` is the side of a light that is close to the
    /// object ([`Contact`]).
    #[inline(always)]
    pub fn occlude<R: Real<One = F>>(&self, ray: &ShadowRay<R>, side: Option<f64>) -> Occlusion<R> {
        match (self, side) {
            (Occluder::Sphere(met), None) => met.map(R::splat).occlude(ray, None),
            (Occluder::Plane(met), None) => met.map(R::splat).occlude(ray, None),
            _ => self.occlude_rarely(ray, side),
        }
    }

    /// Not inlined: hot loops over the other occluders have fewer registers left with these formulas in them.
    #[inline(never)]
    fn occlude_rarely<R: Real<One = F>>(
        &self,
        ray: &ShadowRay<R>,
        side: Option<f64>,
    ) -> Occlusion<R> {
        let side = side.map(R::lit);
        match self {
            Occluder::Sphere(met) => met.map(R::splat).occlude(ray, side),
            Occluder::Plane(met) => met.map(R::splat).occlude(ray, side),
            Occluder::Ground(met) => met.map(R::splat).occlude(ray, side),
            Occluder::Beyond => Occlusion::none(),
        }
    }
}

impl Occluder<f32> {
    /// The place of its shape among all, and its words in a device's buffer; `None` if the device does not need it.
    pub fn words(&self) -> Option<(usize, Vec<f32>)> {
        match self {
            Occluder::Sphere(met) => Some((0, words::<8>(met).to_vec())),
            Occluder::Plane(met) => Some((1, words::<12>(met).to_vec())),
            Occluder::Ground(met) => Some((2, words::<8>(met).to_vec())),
            Occluder::Beyond => None,
        }
    }
}

/// The nearest object so far: bounds of its `t`, and the least that all others may have.
#[derive(Clone, Copy, Debug)]
pub struct Nearest<R: Real> {
    low: R,
    high: R,
    second: R,
    id: R::Id,
}

fields! { Nearest { low: num, high: num, second: num, id: id } }

/// f32 decides hits up to this `t`. Times a unit over the length of a direction, up to `2⁶⁰` ([`bounds::LARGEST_SHIFT`]), that is
/// in f32's range. Halving it is not covered by a test: a larger `t` is only left open.
pub const LARGEST_T: f64 = (1u128 << LARGEST_T_EXPONENT) as f64;

const LARGEST_T_EXPONENT: i32 = 66;
const _: () = assert!(LARGEST_T_EXPONENT + bounds::LARGEST_SHIFT < 127);

impl<R: Real> Nearest<R> {
    /// None at all.
    #[inline(always)]
    pub fn none() -> Nearest<R> {
        let beyond = R::lit(R::One::BEYOND);
        Nearest { low: beyond, high: beyond, second: beyond, id: R::splat_id(0) }
    }

    /// An upper bound of its `t`.
    #[inline(always)]
    pub fn high(&self) -> R {
        self.high
    }

    /// One more object.
    #[inline(always)]
    pub fn with(self, next: Bounds<R>, id: R::Id) -> Nearest<R> {
        let is_nearer = next.low.lt(self.low);
        Nearest {
            second: R::select(is_nearer, self.low, self.second.min(next.low)),
            low: R::select(is_nearer, next.low, self.low),
            high: R::select(is_nearer, next.high, self.high),
            id: R::select_id(is_nearer, id, self.id),
        }
    }

    /// The object's id, 0 for none, [`UNDECIDED`] where another may be as near; and where that is. Of equal `t` exact arithmetic gives
    /// the lower id.
    #[inline(always)]
    pub fn decide(self) -> (R::Id, R::Mask) {
        self.decide_up_to(R::lit(LARGEST_T))
    }

    /// [`Nearest::decide`], with another limit of `t`.
    #[inline(always)]
    pub fn decide_up_to(self, largest_t: R) -> (R::Id, R::Mask) {
        let is_none = R::lit(R::One::BEYOND).le(self.low);
        let is_hit = self.high.lt(self.second) & self.high.lt(largest_t);
        let is_sure = is_hit | is_none;
        (R::select_id(is_sure, self.id, R::splat_id(UNDECIDED)), !is_sure)
    }
}

/// Records of one shape with their ids, apart by [`ShapeRecord::is_close`].
struct RecordList<T: ShapeRecord, F: Float> {
    far: Vec<(u32, In<T, F>)>,
    close: Vec<(u32, In<T, F>)>,
}

impl<T: ShapeRecord, F: Float> RecordList<T, F> {
    fn new() -> RecordList<T, F> {
        RecordList { far: Vec::new(), close: Vec::new() }
    }

    fn push(&mut self, id: u32, seen: &T) {
        let group =
            if T::CAN_BE_CLOSE && seen.is_close() { &mut self.close } else { &mut self.far };
        group.push((id, seen.round()));
    }

    fn each<R: Real<One = F>>(&self, ray: &Ray<R>, mut take: impl FnMut(u32, Option<Bounds<R>>)) {
        for (id, seen) in &self.far {
            take(*id, T::bounds(&T::splat(seen), ray));
        }
        for (id, seen) in &self.close {
            take(*id, T::bounds_close(&T::splat(seen), ray));
        }
    }

    #[inline(always)]
    fn nearer<R: Real<One = F>>(&self, ray: &Ray<R>, mut best: Nearest<R>) -> Nearest<R> {
        for (id, seen) in &self.far {
            if let Some(next) = T::bounds(&T::splat(seen), ray) {
                best = best.with(next, R::splat_id(*id));
            }
        }
        if T::CAN_BE_CLOSE {
            for (id, seen) in &self.close {
                if let Some(next) = T::bounds_close(&T::splat(seen), ray) {
                    best = best.with(next, R::splat_id(*id));
                }
            }
        }
        best
    }
}

/// All objects as an eye sees them, in numbers of `F`.
pub struct Objects<F: Float> {
    spheres: RecordList<SphereRecord<f64>, F>,
    planes: RecordList<PlaneRecord<f64>, F>,
}

impl<F: Float> Objects<F> {
    /// These objects with their ids, as an eye sees them.
    pub fn new<'a>(
        objects: impl IntoIterator<Item = (u32, Object<'a>)>,
        eye: &RayOrigin,
    ) -> Objects<F> {
        let mut all = Objects { spheres: RecordList::new(), planes: RecordList::new() };
        for (id, object) in objects {
            match object {
                Object::Sphere(sphere) => {
                    all.spheres.push(id, &SphereRecord::new::<F>(sphere, eye))
                }
                Object::Plane(plane) => all.planes.push(id, &PlaneRecord::new::<F>(plane, eye)),
            }
        }
        all
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        let Objects { spheres, planes } = self;
        spheres.far.is_empty()
            && spheres.close.is_empty()
            && planes.far.is_empty()
            && planes.close.is_empty()
    }

    /// Hands over where a ray meets each; `None` where it surely doesn't.
    pub fn each<R: Real<One = F>>(
        &self,
        ray: &Ray<R>,
        mut take: impl FnMut(u32, Option<Bounds<R>>),
    ) {
        self.spheres.each(ray, &mut take);
        self.planes.each(ray, &mut take);
    }

    /// What each lane's ray sees.
    #[inline(always)]
    pub fn nearest<R: Real<One = F>>(&self, ray: &Ray<R>) -> Nearest<R> {
        self.planes.nearer(ray, self.spheres.nearer(ray, Nearest::none()))
    }
}

#[cfg(test)]
mod tests;
