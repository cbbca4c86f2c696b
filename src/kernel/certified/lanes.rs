//! The steps of the filter without branches, for rays side by side in f32 or f64: operation by operation
//! those of [`super::filter`].

use super::filter::{GuardOf, Nearness, Widening};
use crate::kernel::RayOf;
use crate::vec3::Real;
use crate::wide::SideBySide;

/// Twin of [`super::outside_nearness`] from the closest approach.
#[inline(always)]
pub(crate) fn outside_at<R: SideBySide>(
    s: R,
    m: R,
    inv_a: R,
    guard: &GuardOf<R::Plain>,
    q: Nearness<R::Plain>,
) -> Nearness<R> {
    let (zero, slack) = (s.like(R::Plain::ZERO), s.like(guard.slack));
    let (inner, outer) = (s.like(guard.inner2) - m, s.like(guard.outer2) - m);
    let low = ((s - slack) + (inner.max(zero) * inv_a).sqrt()) * s.like(q.low);
    let high = ((s + slack) + (outer.max(zero) * inv_a).sqrt()) * s.like(q.high);
    Nearness {
        low: R::select(inner.lt(zero), zero, low),
        high: R::select(outer.lt(zero), zero, high),
    }
}

/// Twin of [`super::inside_nearness`] from the closest approach.
#[inline(always)]
pub(crate) fn inside_at<R: SideBySide>(
    s: R,
    m: R,
    inv_a: R,
    guard: &GuardOf<R::Plain>,
    q: Nearness<R::Plain>,
    widening: &Widening<R::Plain>,
) -> Nearness<R> {
    let (zero, slack, largest) =
        (s.like(R::Plain::ZERO), s.like(guard.slack), s.like(R::Plain::LARGEST));
    let inner = ((s.like(guard.inner2) - m).max(zero) * inv_a).sqrt();
    let outer = ((s.like(guard.outer2) - m).max(zero) * inv_a).sqrt();
    let u_low = (s.abs() + inner) - slack;
    let u_high = (s.abs() + outer) + slack;
    let is_ahead = zero.lt(s);
    let is_apart = zero.lt(u_low);
    let ahead_low = inv_a / u_high * s.like(widening.narrower);
    let ahead_high = inv_a / R::select(is_apart, u_low, slack) * s.like(widening.wider);
    let ahead_high = R::select(is_apart, ahead_high, largest);
    let low = R::select(is_ahead, ahead_low, u_low * s.like(q.low));
    let high = R::select(is_ahead, ahead_high, u_high * s.like(q.high));
    if q.high > R::Plain::ZERO {
        return Nearness { low, high };
    }
    let is_open = s.abs().le(slack);
    Nearness { low: R::select(is_open, zero, low), high: R::select(is_open, largest, high) }
}

/// Twin of [`super::plane_nearness`].
#[inline(always)]
pub(crate) fn plane_nearness<R: SideBySide>(
    rays: &RayOf<R>,
    away: R,
    direction_error: R::Plain,
    q: Nearness<R>,
) -> Nearness<R> {
    let error = away.like(direction_error) * rays.a.sqrt();
    Nearness {
        low: (away - error) * rays.inv_a * q.low,
        high: (away + error) * rays.inv_a * q.high,
    }
}

/// [`super::Nearest`] of rays side by side.
pub(crate) struct NearestOf<R: SideBySide> {
    pub low: R,
    pub high: R,
    pub second_high: R,
    pub id: R::Whole,
}

impl<R: SideBySide> NearestOf<R> {
    /// No candidate yet.
    #[inline(always)]
    pub fn none(zero: R, no_id: R::Whole) -> Self {
        NearestOf { low: zero, high: zero, second_high: zero, id: no_id }
    }

    /// [`super::Nearest::nearer`]
    #[inline(always)]
    pub fn nearer(&mut self, root: Nearness<R>, id: R::Whole) {
        let is_nearer = self.high.lt(root.high);
        let farther = R::select(is_nearer, self.high, root.high);
        self.low = R::select(is_nearer, root.low, self.low);
        self.high = R::select(is_nearer, root.high, self.high);
        self.second_high = self.second_high.max(farther);
        self.id = R::select_whole(is_nearer, id, self.id);
    }
}
