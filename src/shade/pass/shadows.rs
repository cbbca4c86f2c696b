//! What is in the way of light to the points that some samples see: listed objects, and those of the tree.
//!
//! The points of an object are looked at as a ball first, and those that are close together share a walk through the tree.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use glam::DVec3;

use super::{LightPass, Scratch};
use crate::bvh::{Bvh, Corners, Enter, Node, Visitor};
use crate::certify::{Pack, is_id};
use crate::guard::length_bound;
use crate::num::{Float, LaneBits, Lanes, Mask, Real, V3};
use crate::scene::Linear;
use crate::seen::shadow::Aim;
use crate::seen::{Occluder, Record, ShadowRay, SphereMet, Surface, Verdict};

/// Most packs whose points of an object share a walk through the tree: with more the beams get wide, with fewer there are more
/// of them.
const TOGETHER: usize = 8;

/// Points of one object, lane by lane.
#[derive(Clone, Copy)]
pub struct Extent<F: Float, const N: usize> {
    id: u32,
    low: V3<Lanes<F, N>>,
    high: V3<Lanes<F, N>>,
    error: Lanes<F, N>,
    /// 1 where some are seen from inside.
    back: Lanes<F, N>,
}

/// A ball around points of one object.
pub struct BoundingBall {
    id: u32,
    /// Whether some are seen from inside.
    has_back: bool,
    pub middle: V3<f64>,
    pub reach: f64,
}

impl<F: Float, const N: usize> Extent<F, N> {
    #[inline(always)]
    pub fn none(id: u32) -> Self {
        let (beyond, zero) = (V3([Lanes::lit(F::BEYOND); 3]), Lanes::lit(0.0));
        Extent { id, low: beyond, high: -beyond, error: zero, back: zero }
    }

    #[inline(always)]
    pub fn add(&mut self, is_in: LaneBits<F, N>, surface: &Surface<Lanes<F, N>>) {
        self.low = V3::select(is_in, self.low.min(surface.point), self.low);
        self.high = V3::select(is_in, self.high.max(surface.point), self.high);
        self.error = Lanes::select(is_in, self.error.max(surface.point_error), self.error);
        let back = Lanes::select(surface.front, Lanes::lit(0.0), Lanes::lit(1.0));
        self.back = Lanes::select(is_in, self.back.max(back), self.back);
    }

    /// The corners of a box around the points.
    #[inline(always)]
    fn ends(&self) -> Corners {
        let mut ends = [DVec3::ZERO; 2];
        for axis in 0..3 {
            ends[0][axis] = -most(-self.low.0[axis]);
            ends[1][axis] = most(self.high.0[axis]);
        }
        ends
    }

    /// Corners of a box around all true points.
    #[inline(always)]
    fn corners(&self) -> Corners {
        let ([low, high], error) = (self.ends(), most(self.error));
        // No test sees the roundings of these sums, which the beam has room for.
        [low - error, high + error]
    }

    /// From the middle of all lanes the true points are as far as half a diagonal of their box, the middle's own rounding, and
    /// the largest error.
    #[inline(always)]
    pub fn ball(&self) -> BoundingBall {
        let [low, high] = self.ends();
        let half = (high - low) * 0.5;
        let middle = low + half;
        // No test sees it halved: the unit is two roundings.
        let rounding = f64::UNIT * middle.length();
        let reach = 1.01 * length_bound(half) + rounding + most(self.error);
        let middle = V3(middle.to_array());
        BoundingBall { id: self.id, has_back: most(self.back) > 0.0, middle, reach }
    }
}

/// The largest of all lanes.
#[inline(always)]
fn most<F: Float, const N: usize>(lanes: Lanes<F, N>) -> f64 {
    let mut most = lanes.0[0];
    for lane in 1..N {
        most = most.max(lanes.0[lane]);
    }
    most.to_f64()
}

/// The ways from some samples to a light.
pub struct Way<F: Float, const N: usize> {
    rays: ShadowRay<Lanes<F, N>>,
    verdict: Verdict<Lanes<F, N>>,
    /// Positive where it is not known to be dark.
    asked: Lanes<F, N>,
    /// 1 where it is still to be looked at, else 0.
    left: Lanes<F, N>,
}

impl<F: Float, const N: usize> Way<F, N> {
    /// Whether one of these lanes is not known to be dark.
    #[inline(always)]
    fn is_open(&self, lanes: Lanes<F, N>) -> bool {
        Lanes::lit(0.0).lt(lanes.min(self.asked)).any()
    }
}

impl<F: Linear> LightPass<'_, F> {
    /// The points that samples see, by objects.
    #[inline(always)]
    pub fn gather<const N: usize>(&self, scratch: &mut Scratch<F, N>) {
        let Scratch { packs, boxes, balls, .. } = scratch;
        boxes.clear();
        for pack in packs {
            let mut left = pack.surface.is_known() & !is_id(&pack.ids, 0);
            while left.any() {
                let id = match pack.is_uniform() {
                    true => pack.ids[0],
                    false => first_of(left, &pack.ids),
                };
                let here = if pack.is_uniform() { left } else { left & is_id(&pack.ids, id) };
                let known = boxes.iter().rposition(|some| some.id == id);
                let at = known.unwrap_or_else(|| {
                    boxes.push(Extent::none(id));
                    boxes.len() - 1
                });
                boxes[at].add(here, &pack.surface);
                if pack.is_uniform() {
                    break;
                }
                left = left & !here;
            }
        }
        balls.clear();
        for some in boxes {
            balls.push(some.ball());
        }
    }

    /// Takes away what listed objects are in the way of.
    #[inline(always)]
    pub fn occlude<const N: usize>(&self, scratch: &mut Scratch<F, N>) {
        let Scratch { light: index, packs, given, balls, places, .. } = scratch;
        let given = &mut given[*index];
        let (light, lamp) = (&self.lights[*index], &self.job.lit.lighting.lamps[*index]);
        let aim = Aim::new(light.origin);
        for &mut BoundingBall { id, has_back, middle, reach } in balls {
            let mut both = packs.iter().zip(&*given);
            if !both.any(|(pack, given)| given.is_lit && pack.sees(id)) {
                continue;
            }
            let has_back = has_back && self.occluders.own_is_in_the_way(lamp, id);
            let ball = ShadowRay::new(&Aim::new(light.origin), middle, reach);
            let is_dark = self.occluders.look_around(&ball, id, places);
            if !is_dark && !has_back && places.is_empty() {
                continue;
            }
            for (pack, given) in packs.iter().zip(&mut *given) {
                if !given.is_lit || !pack.sees(id) {
                    continue;
                }
                let mut verdict = Verdict::dark();
                if !is_dark {
                    let rays = self.shadow_rays(&aim, pack);
                    verdict = Verdict::none();
                    for &place in &*places {
                        verdict = verdict.with(self.listed[place].occlude(&rays));
                    }
                    if has_back {
                        verdict = Verdict::select(pack.surface.front, verdict, Verdict::dark());
                    }
                }
                // Of those of which nothing is known the lower bound is 0 already.
                let here = pack.surface.is_known();
                let here = if pack.is_uniform() { here } else { here & is_id(&pack.ids, id) };
                given.take(Verdict::select(here, verdict, Verdict::none()));
            }
        }
    }

    /// Takes away what spheres of the tree are in the way of. The samples that see one object follow each other, lie close
    /// together, and share a walk.
    #[inline(always)]
    pub fn occlude_by_tree<const N: usize>(&self, scratch: &mut Scratch<F, N>) {
        let Some(bvh) = self.occluders.tree() else { return };
        let Scratch { light: index, packs, given, walk, ways, .. } = scratch;
        let light = &self.lights[*index];
        let aim = Aim::new(light.origin);
        let given = &mut given[*index];
        let (zero, one) = (Lanes::<F, N>::lit(0.0), Lanes::lit(1.0));
        ways.clear();
        for (pack, given) in packs.iter().zip(&*given) {
            let rays = self.shadow_rays(&aim, pack);
            let is_asked = zero.lt(given.bounds.high.min(one - given.clear));
            let is_asked = pack.surface.is_known() & is_asked;
            let asked = Lanes::select(is_asked, given.bounds.high, zero);
            let left = Lanes::select(is_asked, one, zero);
            ways.push(Way { rays, verdict: Verdict::none(), asked, left });
        }
        for first in 0..packs.len() {
            let left = |way: &Way<F, N>| (0..N).find(|&lane| zero.0[lane].lt(way.left.0[lane]));
            while let Some(lane) = left(&ways[first]) {
                let own = packs[first].ids[lane];
                let mut around = Extent::none(own);
                let behind = packs[first..].iter().take(TOGETHER);
                let last = first + behind.take_while(|pack| pack.sees(own)).count();
                let (packs, ways) = (&packs[first..last], &mut ways[first..last]);
                for (pack, way) in packs.iter().zip(&mut *ways) {
                    let here = is_id(&pack.ids, own) & zero.lt(way.left);
                    around.add(here, &pack.surface);
                    way.left = Lanes::select(here, zero, way.left);
                }
                let beam = self.occluders.beam(bvh, light.origin, around.corners());
                let mut darken = Darken { pass: self, bvh, own, packs, ways, is_dark: false };
                walk.all(bvh, bvh.root(), beam, &mut darken);
            }
        }
        for ((pack, given), way) in packs.iter().zip(given).zip(&*ways) {
            let is_known = pack.surface.is_known();
            given.take(Verdict::select(is_known, way.verdict, Verdict::none()));
        }
    }
}

/// Looks for what is in the way of light to points of one object.
struct Darken<'a, 'b, F: Float, const N: usize> {
    pass: &'a LightPass<'b, F>,
    bvh: &'a Bvh,
    /// Their object, which is not in their way.
    own: u32,
    packs: &'a [Pack<F, N>],
    ways: &'a mut [Way<F, N>],
    is_dark: bool,
}

impl<F: Linear, const N: usize> Visitor for Darken<'_, '_, F, N> {
    #[inline(always)]
    fn last(&self) -> f32 {
        if self.is_dark { -1.0 } else { f32::INFINITY }
    }

    #[inline(always)]
    fn visit(&mut self, node: &Node, mut leaves: u32, _: &Enter) {
        let (zero, one) = (Lanes::<F, N>::lit(0.0), Lanes::lit(1.0));
        while leaves != 0 {
            let place = node.place(leaves.trailing_zeros()) as usize;
            leaves &= leaves - 1;
            if self.bvh.ids[place] == self.own {
                continue;
            }
            let met = self.pass.occluders.met::<F>(&self.bvh.spheres[place]);
            let met = <SphereMet<f64> as Record>::splat(&met);
            let mut is_any_open = false;
            for (pack, way) in self.packs.iter().zip(&mut *self.ways) {
                let here = Lanes::select(is_id(&pack.ids, self.own), one, zero);
                if !way.is_open(here) {
                    continue;
                }
                let found = SphereMet::occlude(&met, &way.rays);
                let found = Verdict::select(zero.lt(here), found, Verdict::none());
                way.verdict = way.verdict.with(found);
                way.asked = Lanes::select(zero.lt(found.blocked), zero, way.asked);
                is_any_open |= way.is_open(here);
            }
            if !is_any_open {
                self.is_dark = true;
                return;
            }
        }
    }
}

/// The id of the first lane where a mask holds.
#[inline(always)]
fn first_of<F: Float, const N: usize>(mask: LaneBits<F, N>, ids: &[u32; N]) -> u32 {
    let mut id = 0;
    for lane in (0..N).rev() {
        id = if mask.0[lane] != F::Bits::default() { ids[lane] } else { id };
    }
    id
}
