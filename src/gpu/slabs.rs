//! A ray in f32 and the boxes of the tree, with room for the arithmetic of any device. Twin of
//! `shaders/slabs.wgsl`.
//!
//! With the unit `ε` of [`crate::guard`], a slab `(c − o)·(1/d)` has these relative errors: ½ of the
//! direction, which the host rounds, 2½ of the inverse, and 1 each of its widening, the difference and
//! the product. That is `6ε` and something of second order: [`SLAB`]. Of the origin, ½ is left out with
//! its low part, and 1 is lost where the slack is added, both of its largest component: [`ASIDE`].
//!
//! A direction below [`FLAT`] doesn't move along its axis: up to the end of the tree, at `t ≤ 2⁴²` as
//! boxes and origins are within [`REACH`] and the largest component is at least 1, it moves by less than
//! `2⁻³⁸`. That, and what underflows, is in the slack's least part, `2⁻³⁷`; half of it would do for all
//! that a test finds. No slab reaches `2⁴¹·2⁸⁰·2 = 2¹²²`, so that none overflows. A `t_max` is
//! an upper bound of the nearest `t` so far, at most `2¹⁰⁰`, which is beyond all boxes.

use crate::num::{Float, Real, V3, round_down, round_up};

#[cfg(doc)]
use crate::bvh::REACH;

/// Relative room of a slab, in units `ε`.
pub const SLAB: f64 = 6.5;

/// How far a ray may lie beside the true one, in units `ε` of its origin's largest component.
pub const ASIDE: f64 = 1.75;

/// Components of a direction below this count as 0. No test sees it halved: slabs then reach `2¹²³`, and none overflows.
pub const FLAT: f64 = 1.0 / (1u128 << 80) as f64;

/// The least slack. No test sees it halved: it is still what a ray moves along a flat axis.
pub const LEAST_SLACK: f64 = 1.0 / (1u64 << 37) as f64;

/// The room in a ray's arithmetic.
#[derive(Clone, Copy, Debug)]
pub struct SlabRoom<R> {
    /// [`ASIDE`], relative.
    pub aside: R,
    /// [`LEAST_SLACK`]
    pub least_slack: R,
    /// [`FLAT`]
    pub flat: R,
    /// Below 1.
    pub nearer: R,
    /// Above 1.
    pub farther: R,
}

impl SlabRoom<f32> {
    /// That of f32, rounded outward.
    pub fn f32() -> SlabRoom<f32> {
        SlabRoom {
            aside: round_up(ASIDE * f32::UNIT),
            least_slack: round_up(LEAST_SLACK),
            flat: round_up(FLAT),
            nearer: round_down(1.0 - SLAB * f32::UNIT),
            farther: round_up(1.0 + SLAB * f32::UNIT),
        }
    }
}

/// A ray along one axis. What it enters first is a box's low side, or its high side where it goes down.
#[derive(Clone, Copy, Debug)]
pub struct Slab<R> {
    /// The origin, moved by the slack to meet the near side sooner.
    pub near_origin: R,
    /// The same to meet the far side later.
    pub far_origin: R,
    /// `1/direction`, nearer to 0.
    pub near_inverse: R,
    /// The same, farther from 0.
    pub far_inverse: R,
    /// Whether the direction is below 0.
    pub goes_down: bool,
    /// Whether it counts as 0; the inverses are then 1, nearly.
    pub is_flat: bool,
}

/// A ray along all axes.
#[derive(Clone, Copy, Debug)]
pub struct Slabs<R> {
    /// First axis.
    pub x: Slab<R>,
    /// Second one.
    pub y: Slab<R>,
    /// Third one.
    pub z: Slab<R>,
}

/// Bounds of the `t` between which a ray is in a slab; the largest number stands for never, or for ever.
#[derive(Clone, Copy, Debug)]
pub struct Stretch<R> {
    /// It is not in it before.
    pub enter: R,
    /// Nor after.
    pub leave: R,
}

/// The slab of one axis.
#[inline(always)]
pub fn slab_of<R: Real<Mask = bool>>(
    origin: R,
    direction: R,
    slack: R,
    room: &SlabRoom<R>,
) -> Slab<R> {
    let is_flat = direction.abs().lt(room.flat);
    let way = if is_flat { R::lit(1.0) } else { direction };
    let inverse = R::lit(1.0) / way;
    let goes_down = way.lt(R::lit(0.0));
    let aside = if goes_down { -slack } else { slack };
    Slab {
        near_origin: origin + aside,
        far_origin: origin - aside,
        near_inverse: inverse * room.nearer,
        far_inverse: inverse * room.farther,
        goes_down,
        is_flat,
    }
}

/// The slabs of a ray that may lie `beside` the true one, at least by what [`SlabRoom::least_slack`] is for.
#[inline(always)]
pub fn slabs_of<R: Real<Mask = bool>>(
    origin: V3<R>,
    direction: V3<R>,
    beside: R,
    room: &SlabRoom<R>,
) -> Slabs<R> {
    let V3([x, y, z]) = origin;
    let slack = x.abs().max(y.abs()).max(z.abs()) * room.aside + beside;
    Slabs {
        x: slab_of(x, direction.0[0], slack, room),
        y: slab_of(y, direction.0[1], slack, room),
        z: slab_of(z, direction.0[2], slack, room),
    }
}

/// When a ray is between two sides.
#[inline(always)]
pub fn stretch<R: Real<Mask = bool>>(slab: &Slab<R>, low: R, high: R) -> Stretch<R> {
    let near_side = if slab.goes_down { high } else { low };
    let far_side = if slab.goes_down { low } else { high };
    let near = (near_side - slab.near_origin) * slab.near_inverse;
    let far = (far_side - slab.far_origin) * slab.far_inverse;
    let (zero, largest) = (R::lit(0.0), R::lit(f32::MAX.into()));
    let never = if zero.lt(near) || far.lt(zero) { largest } else { zero };
    Stretch {
        enter: if slab.is_flat { never } else { near },
        leave: if slab.is_flat { largest } else { far },
    }
}

/// Whether a ray may meet a box at `0 ≤ t ≤ t_max`.
#[inline(always)]
pub fn meets<R: Real<Mask = bool>>(slabs: &Slabs<R>, low: V3<R>, high: V3<R>, t_max: R) -> bool {
    let x = stretch(&slabs.x, low.0[0], high.0[0]);
    let y = stretch(&slabs.y, low.0[1], high.0[1]);
    let z = stretch(&slabs.z, low.0[2], high.0[2]);
    let enter = x.enter.max(y.enter).max(z.enter).max(R::lit(0.0));
    enter.le(x.leave) && enter.le(y.leave) && enter.le(z.leave) && enter.le(t_max)
}
