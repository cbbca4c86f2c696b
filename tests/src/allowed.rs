//! What the kernels `lecture` and `stable` may give on a device that keeps to Vulkan's table of precision,
//! ray by ray: their formulas in the intervals of [`super::span`].
//!
//! # How a bound comes about
//! The numbers that a device is given, the records of [`Prepared`] and the camera's or the list's, are
//! known bit by bit. Each operation of the shader then is one on intervals, in the same order, as the
//! formulas are those of the kernels' twins ([`lecture::quadratic`], [`relative::approach`]) in another
//! arithmetic. Where a comparison is open, both ways are gone. So each object has intervals of the `t`
//! that it may have and may or may not be missed, and a device's hit is allowed if its `t` is among those
//! of its object and no other object is surely nearer. The normal is found again from the `t` that the
//! device gave.
//!
//! The intervals of a formula's operations are as wide as their worst errors together, so that the bound
//! is that of a first-order error analysis, with its second order, for the numbers of this very ray. A
//! number that leaves f32's range has no bound, and neither has what is made of it.

use kugelblitz::kernel::Lists;
use kugelblitz::kernel::lecture::{self, PlaneLecture, SphereLecture};
use kugelblitz::kernel::plain::{Plain, PlainRay, PlainRays, facing};
use kugelblitz::kernel::relative::{self, Approach, PlaneStable, SphereStable};
use kugelblitz::num::{Real, V3};
use kugelblitz::prepare::{Objects, Prepared};
use kugelblitz::rays::Rays;
use kugelblitz::trace::Hits;
use rayon::prelude::*;

use super::span::Span;

/// Rays whose result no device may give that keeps to Vulkan's table of precision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outside {
    /// Rays looked at.
    pub rays: u64,
    /// Those with a result outside its bounds.
    pub outside: u64,
    /// Index of the first of them.
    pub first: Option<usize>,
}

impl Outside {
    /// Adds another part of the same picture, whose rays begin at `first_ray`.
    pub fn add(&mut self, other: &Outside, first_ray: usize) {
        self.rays += other.rays;
        self.outside += other.outside;
        self.first = self.first.or(other.first.map(|index| first_ray + index));
    }
}

/// Looks at the rays with these indices. `None` for kernels that are not f32 alone.
pub fn compare_to_allowed(
    prepared: &Prepared,
    rays: &Rays,
    hits: &Hits,
    index: &[usize],
) -> Option<Outside> {
    let allowed = Allowed::new(prepared, rays)?;
    let outside: Vec<usize> =
        index.par_iter().copied().filter(|&index| !allowed.has(hits, index)).collect();
    Some(Outside {
        rays: index.len() as u64,
        outside: outside.len() as u64,
        first: outside.first().copied(),
    })
}

/// The intervals of a ray's numbers.
type RaySpan = PlainRay<Span>;

/// What an object may give.
#[derive(Clone, Copy, Debug)]
struct Chance {
    /// `t` of either root.
    t: [Option<Span>; 2],
    may_be_missed: bool,
}

impl Chance {
    const MISSED: Chance = Chance { t: [None; 2], may_be_missed: true };

    fn of_plane(t: Span) -> Chance {
        let may_be_missed = t.is_any() || t.low <= 0.0;
        Chance { t: [t.above_zero(), None], may_be_missed }
    }

    /// Of the first root above 0, where there are roots.
    fn of_roots([near, far]: [Span; 2]) -> Chance {
        let far_may_count = near.is_any() || near.low <= 0.0;
        let far = if far_may_count { far } else { Span::ZERO };
        // ∞ is no hit, either.
        let may_be_missed = near.is_any() || far.is_any() || far_may_count && far.low <= 0.0;
        Chance { t: [near.above_zero(), far.above_zero()], may_be_missed }
    }

    /// Of what may be true with what may be as well.
    fn or(self, other: Chance) -> Chance {
        let either = |a: Option<Span>, b: Option<Span>| match (a, b) {
            (Some(a), Some(b)) => Some(Span { low: a.low.min(b.low), high: a.high.max(b.high) }),
            (a, b) => a.or(b),
        };
        Chance {
            t: [either(self.t[0], other.t[0]), either(self.t[1], other.t[1])],
            may_be_missed: self.may_be_missed || other.may_be_missed,
        }
    }

    fn scaled(self, by: f64) -> Chance {
        let t = self.t.map(|t| t.map(|t| t.scaled(by)));
        let leaves_range = t.iter().flatten().any(Span::is_any);
        Chance { t, may_be_missed: self.may_be_missed || leaves_range }
    }

    /// Whether the object may lose against a hit at `t`, or be that hit itself.
    fn may_be_behind(&self, t: f64) -> bool {
        self.may_be_missed || self.t.iter().flatten().any(|span| span.is_any() || span.high >= t)
    }
}

/// An object as a kernel sees it.
trait Seen {
    fn chance(&self, ray: &RaySpan) -> Chance;
    /// A vector along the normal, and another where a comparison is open.
    fn normals(&self, ray: &RaySpan, t: Span) -> [V3<Span>; 2];
}

impl Seen for SphereLecture {
    fn chance(&self, PlainRay { ray, .. }: &RaySpan) -> Chance {
        let (center, radius) = (V3::splat(V3(self.center)), Span::new(self.radius));
        let q = lecture::quadratic(ray.origin, ray.direction, center, radius);
        let Some(discriminant) = q.discriminant.not_below_zero() else { return Chance::MISSED };
        let roots = lecture::quadratic_roots(lecture::Quadratic { discriminant, ..q });
        let chance = Chance::of_roots(roots);
        match q.discriminant >= Span::ZERO {
            true => chance,
            false => chance.or(Chance::MISSED),
        }
    }

    fn normals(&self, ray: &RaySpan, t: Span) -> [V3<Span>; 2] {
        [self.normal(ray, t); 2]
    }
}

impl Seen for PlaneLecture {
    fn chance(&self, PlainRay { ray, .. }: &RaySpan) -> Chance {
        let [point, normal] = [self.point, self.normal].map(|v| V3::splat(V3(v)));
        Chance::of_plane((point - ray.origin).dot(normal) / ray.direction.dot(normal))
    }

    fn normals(&self, ray: &RaySpan, t: Span) -> [V3<Span>; 2] {
        [self.normal(ray, t); 2]
    }
}

/// The closest approach and half the chord, where there may be one.
fn approach(sphere: &SphereStable, ray: &RaySpan, l: V3<Span>) -> Option<(Approach<Span>, Span)> {
    let found = relative::approach(&ray.ray, l, Span::new(sphere.radius));
    Some((found, (ray.ray.a * found.delta.not_below_zero()?).sqrt()))
}

impl Seen for SphereStable {
    fn chance(&self, ray: &RaySpan) -> Chance {
        let l = self.offset(ray);
        let k = self.k(ray, l);
        let Some((Approach { b, delta, .. }, h)) = approach(self, ray, l) else {
            return Chance::MISSED;
        };
        let of_part = |b: Span| Chance::of_roots(relative::roots_stable(&ray.ray, b, h, k));
        let parts = match b.is_any() {
            true => [Some(Span::ANY), None],
            false => [b.above_zero(), b.not_above_zero()],
        };
        let [ahead, behind] = parts.map(|part| part.map(of_part));
        let chance = match (ahead, behind) {
            (Some(ahead), Some(behind)) => ahead.or(behind),
            (ahead, behind) => ahead.or(behind).unwrap_or(Chance::MISSED),
        };
        match delta >= Span::ZERO {
            true => chance,
            false => chance.or(Chance::MISSED),
        }
    }

    fn normals(&self, ray: &RaySpan, _: Span) -> [V3<Span>; 2] {
        let l = self.offset(ray);
        let k = self.k(ray, l);
        let Some((Approach { p, .. }, h)) = approach(self, ray, l) else {
            return [V3([Span::ANY; 3]); 2];
        };
        let half_chord = ray.ray.direction * (h * ray.ray.inv_a);
        let (outside, inside) = (-half_chord - p, half_chord - p);
        match (k > Span::ZERO, k.high <= 0.0) {
            (true, _) => [outside; 2],
            (_, true) => [inside; 2],
            _ => [outside, inside],
        }
    }
}

impl Seen for PlaneStable {
    fn chance(&self, ray: &RaySpan) -> Chance {
        let slope = ray.ray.direction.dot(V3::splat(V3(self.normal)));
        Chance::of_plane(self.n_offset(ray) / slope)
    }

    fn normals(&self, ray: &RaySpan, t: Span) -> [V3<Span>; 2] {
        [self.normal(ray, t); 2]
    }
}

/// The bounds of a scene's rays.
struct Allowed<'a> {
    prepared: &'a Prepared,
    rays: PlainRays<'a, f32>,
}

impl<'a> Allowed<'a> {
    fn new(prepared: &'a Prepared, rays: &'a Rays) -> Option<Allowed<'a>> {
        let is_in_f32 = matches!(prepared.objects, Objects::Lecture(_) | Objects::Stable(_));
        let rays = PlainRays::new(prepared.coordinates(), rays);
        is_in_f32.then_some(Allowed { prepared, rays })
    }

    fn has(&self, hits: &Hits, index: usize) -> bool {
        let (ray, scale) = (self.rays.one(index), self.rays.scales::<1>(index)[0]);
        let Some(&id) = hits.id.get(index) else { return false };
        let hit =
            HitOf { id, t: hits.t.get(index).copied(), normal: hits.normal.get(index).copied() };
        match &self.prepared.objects {
            Objects::Lecture(lists) => hit.is_allowed(lists, &ray, scale),
            Objects::Stable(lists) => hit.is_allowed(lists, &ray, scale),
            Objects::Double(_) | Objects::Certified { .. } => true,
        }
    }
}

/// The result of a ray, as far as it is there.
struct HitOf {
    id: u32,
    t: Option<f32>,
    normal: Option<[f32; 3]>,
}

impl HitOf {
    fn is_allowed<S: Seen, P: Seen>(&self, lists: &Lists<S, P>, ray: &RaySpan, scale: f64) -> bool {
        let spheres = lists.spheres.iter().map(|sphere| sphere as &dyn Seen);
        let objects: Vec<&dyn Seen> =
            spheres.chain(lists.planes.iter().map(|plane| plane as &dyn Seen)).collect();
        let chances: Vec<Chance> =
            objects.iter().map(|object| object.chance(ray).scaled(scale)).collect();
        let own = self.id.checked_sub(1).map(|index| index as usize);
        let t = match own {
            None => self.t.unwrap_or(f32::INFINITY),
            Some(index) => {
                let Some(chance) = chances.get(index) else { return false };
                let mut may_be = chance.t.iter().flatten();
                let t = match self.t {
                    Some(t) => may_be.any(|span| span.has(t)).then_some(t),
                    None => may_be.map(|span| span.low as f32).reduce(f32::min),
                };
                let Some(t) = t else { return false };
                t
            }
        };
        let nothing_is_nearer = chances
            .iter()
            .enumerate()
            .all(|(index, chance)| own == Some(index) || chance.may_be_behind(t.into()));
        nothing_is_nearer && self.normal_is_allowed(own.map(|i| objects[i]), ray, t, scale)
    }

    fn normal_is_allowed(
        &self,
        object: Option<&dyn Seen>,
        ray: &RaySpan,
        t: f32,
        scale: f64,
    ) -> bool {
        let Some(normal) = self.normal else { return true };
        let Some(object) = object else { return normal == [0.0; 3] };
        // Scaling back is exact, but where the range ends.
        let t = Span::new(t).scaled(1.0 / scale);
        let has = |v: V3<Span>| v.0.iter().zip(normal).all(|(span, x)| span.has(x));
        object.normals(ray, t).into_iter().any(|v| {
            let unit = facing(v, ray.ray.direction);
            has(unit) || !(unit.dot(ray.ray.direction) < Span::ZERO) && has(-unit)
        })
    }
}
