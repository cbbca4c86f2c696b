//! What is in the way of light to the points that some samples see: listed objects, and those of the tree.
//!
//! The points of an object are looked at as a ball first, and those that are close together share a walk through the tree.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use std::ops::Range;

use glam::DVec3;

use super::{LightPass, LightScratch};
use crate::bounds::length_bound;
use crate::bvh::{Bvh, Corners, Visitor};
use crate::num::{Float, LaneBits, Lanes, Mask, Real, V3};
use crate::scene::{Linear, Object};
use crate::shape::shadow::Aim;
use crate::shape::{Contact, Occluder, Occlusion, ShadowRay, SphereOccluder, Surface};
use crate::surface::{Pack, is_id};

/// Most packs whose points of an object are looked at together: with more the beams get wide, with fewer there are more of them.
const TOGETHER: usize = 8;

/// Points of one object, lane by lane.
#[derive(Clone, Copy)]
pub struct Extent<F: Float, const N: usize> {
    low: V3<Lanes<F, N>>,
    high: V3<Lanes<F, N>>,
    error: Lanes<F, N>,
    /// 1 where some are seen from inside.
    back: Lanes<F, N>,
}

/// A ball around points.
pub struct BoundingBall {
    pub middle: V3<f64>,
    pub reach: f64,
}

/// What some packs see of one object.
pub struct PointGroup {
    id: u32,
    packs: Range<usize>,
    ball: BoundingBall,
    corners: Corners,
    /// Whether some of its points are seen from inside.
    has_back: bool,
}

impl<F: Float, const N: usize> Extent<F, N> {
    #[inline(always)]
    pub fn none() -> Self {
        let (beyond, zero) = (V3([Lanes::lit(F::BEYOND); 3]), Lanes::lit(0.0));
        Extent { low: beyond, high: -beyond, error: zero, back: zero }
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
        BoundingBall { middle: V3(middle.to_array()), reach }
    }
}

/// The largest of all lanes.
#[inline(always)]
fn most<F: Float, const N: usize>(lanes: Lanes<F, N>) -> f64 {
    lanes.joined(F::max).to_f64()
}

/// The ways from some samples to a light.
pub struct ShadowWay<F: Float, const N: usize> {
    /// Their pack, among those of a group.
    at: usize,
    rays: ShadowRay<Lanes<F, N>>,
    verdict: Occlusion<Lanes<F, N>>,
    /// Positive where one is neither known to be dark nor known to be clear.
    asked: Lanes<F, N>,
}

impl<F: Float, const N: usize> ShadowWay<F, N> {
    /// Whether one is left.
    #[inline(always)]
    fn is_open(&self) -> bool {
        Lanes::lit(0.0).lt(self.asked).any()
    }
}

/// The lanes of a pack that are known to see an object.
#[inline(always)]
fn lanes_on<F: Float, const N: usize>(pack: &Pack<F, N>, id: u32) -> LaneBits<F, N> {
    let is_known = pack.surface.is_known();
    if pack.one() == Some(id) { is_known } else { is_known & is_id(&pack.ids, id) }
}

impl<F: Linear> LightPass<'_, F> {
    /// The points that samples see, by objects.
    #[inline(always)]
    pub fn gather<const N: usize>(&self, scratch: &mut LightScratch<F, N>) {
        let LightScratch { packs, groups, left, .. } = scratch;
        let together = self.occluders.tree.map_or(packs.len(), |_| TOGETHER);
        groups.clear();
        left.clear();
        for pack in &*packs {
            left.push(pack.surface.is_known() & !is_id(&pack.ids, 0));
        }
        for first in 0..packs.len() {
            while left[first].any() {
                let id = first_of(left[first], &packs[first].ids);
                let behind = &packs[first..packs.len().min(first + together)];
                let others = behind.iter().rposition(|pack| pack.sees(id));
                let last = first + others.map_or(1, |at| at + 1);
                let mut points = Extent::none();
                for (pack, left) in packs[first..last].iter().zip(&mut left[first..last]) {
                    let here = lanes_on(pack, id) & *left;
                    points.add(here, &pack.surface);
                    *left = *left & !here;
                }
                let has_back = most(points.back) > 0.0;
                let (ball, corners) = (points.ball(), points.corners());
                groups.push(PointGroup { id, packs: first..last, ball, corners, has_back });
            }
        }
    }

    /// Takes away what listed objects are in the way of.
    #[inline(always)]
    pub fn occlude<const N: usize>(&self, scratch: &mut LightScratch<F, N>) {
        let LightScratch { light: index, packs, given, groups, places, .. } = scratch;
        let (lamp, light) = (&self.job.lit.lighting.lamps[*index], &self.lighting.lamps[*index]);
        let of_ball = Aim::new(self.occluders.lights[*index].origin);
        let aim = light.aim.map(Lanes::splat);
        for PointGroup { id, packs: among, ball, has_back, .. } in &*groups {
            let (packs, given) = (&packs[among.clone()], &mut given[*index][among.clone()]);
            if !given.iter().any(|given| given.is_lit) {
                continue;
            }
            let is_dark_behind = |own: Object| own.darkens_its_back(lamp.origin);
            let has_back =
                *has_back && self.occluders.scene.object(*id).is_some_and(is_dark_behind);
            let ball = ShadowRay::new(&of_ball, ball.middle, ball.reach);
            let is_dark = self.occluders.look_around(*index, &ball, *id, places);
            if !is_dark && !has_back && places.is_empty() {
                continue;
            }
            for (pack, given) in packs.iter().zip(given) {
                if !given.is_lit || !pack.sees(*id) {
                    continue;
                }
                let mut verdict = Occlusion::dark();
                if !is_dark {
                    let rays = ShadowRay::new(&aim, pack.surface.point, pack.surface.point_error);
                    verdict = Occlusion::none();
                    if light.contacts.is_empty() {
                        for &place in &*places {
                            verdict =
                                verdict.with(self.lighting.occluders[place].1.occlude(&rays, None));
                        }
                    } else {
                        verdict = self.verdict_with_contacts(&light.contacts, places, &rays);
                    }
                    if has_back {
                        verdict = Occlusion::select(pack.surface.front, verdict, Occlusion::dark());
                    }
                }
                // Of those of which nothing is known the lower bound is 0 already.
                given.take(Occlusion::select(lanes_on(pack, *id), verdict, Occlusion::none()));
            }
        }
    }

    /// Returns which shadow rays to a light with contacts are occluded by some listed objects. This is rare, and so not in the loops that
    /// are compiled for each instruction set.
    #[inline(never)]
    fn verdict_with_contacts<const N: usize>(
        &self,
        contacts: &[Contact],
        places: &[usize],
        rays: &ShadowRay<Lanes<F, N>>,
    ) -> Occlusion<Lanes<F, N>> {
        places.iter().fold(Occlusion::none(), |verdict, &place| {
            let (id, met) = &self.lighting.occluders[place];
            verdict.with(met.occlude(rays, Contact::side_at(contacts, *id)))
        })
    }

    /// Takes away what spheres of the tree are in the way of.
    #[inline(always)]
    pub fn occlude_by_tree<const N: usize>(&self, scratch: &mut LightScratch<F, N>) {
        let Some(bvh) = self.occluders.tree else { return };
        let LightScratch { light: index, packs, given, groups, ways, walk, .. } = scratch;
        let (origin, aim) = (
            self.occluders.lights[*index].origin,
            self.lighting.lamps[*index].aim.map(Lanes::splat),
        );
        let (zero, one) = (Lanes::<F, N>::lit(0.0), Lanes::lit(1.0));
        for PointGroup { id, packs: among, corners, .. } in &*groups {
            let (packs, given) = (&packs[among.clone()], &mut given[*index][among.clone()]);
            ways.clear();
            for (at, (pack, given)) in packs.iter().zip(&*given).enumerate() {
                let asked = given.bounds.high.min(one - given.clear);
                let asked = Lanes::select(lanes_on(pack, *id), asked, zero);
                if zero.lt(asked).any() {
                    let rays = ShadowRay::new(&aim, pack.surface.point, pack.surface.point_error);
                    ways.push(ShadowWay { at, rays, verdict: Occlusion::none(), asked });
                }
            }
            if !ways.is_empty() {
                let beam = self.occluders.beam(bvh, origin, *corners);
                let (contacts, own) = (&self.lighting.lamps[*index].contacts[..], *id);
                let mut darken = OcclusionVisitor {
                    pass: self,
                    contacts,
                    bvh,
                    own,
                    ways,
                    is_met: false,
                    is_dark: false,
                };
                walk.all(bvh, bvh.root(), beam, &mut darken);
                if !darken.is_met {
                    continue;
                }
                for way in &*ways {
                    let here = lanes_on(&packs[way.at], *id);
                    given[way.at].take(Occlusion::select(here, way.verdict, Occlusion::none()));
                }
            }
        }
    }
}

/// Looks for what is in the way of light to points of one object.
struct OcclusionVisitor<'a, 'b, F: Float, const N: usize> {
    pass: &'a LightPass<'b, F>,
    /// The contacts of the light.
    contacts: &'a [Contact],
    bvh: &'a Bvh,
    /// Their object, which is not in their way.
    own: u32,
    ways: &'a mut [ShadowWay<F, N>],
    /// Whether a sphere was looked at,
    is_met: bool,
    /// and all ways are known to be dark.
    is_dark: bool,
}

impl<F: Linear, const N: usize> Visitor for OcclusionVisitor<'_, '_, F, N> {
    #[inline(always)]
    fn last(&self) -> f32 {
        if self.is_dark { -1.0 } else { f32::INFINITY }
    }

    #[inline(always)]
    fn see(&mut self, place: u32) {
        let zero = Lanes::<F, N>::lit(0.0);
        let place = place as usize;
        let id = self.bvh.ids[place];
        if id == self.own {
            return;
        }
        let reference = self.pass.occluders.prepared.reference;
        let met: SphereOccluder<F> = SphereOccluder::new(&self.bvh.spheres[place], reference);
        if let Some(side) = Contact::side_at(self.contacts, id) {
            return self.see_beside(&Occluder::Sphere(met), side);
        }
        let met = met.map(Lanes::splat);
        (self.is_met, self.is_dark) = (true, true);
        for way in &mut *self.ways {
            if way.is_open() {
                let found = met.occlude(&way.rays, None);
                way.verdict = way.verdict.with(found);
                way.asked = Lanes::select(zero.lt(found.blocked), zero, way.asked);
                self.is_dark &= !way.is_open();
            }
        }
    }
}

impl<F: Linear, const N: usize> OcclusionVisitor<'_, '_, F, N> {
    /// The sphere at a place that the light is close to.
    #[inline(never)]
    fn see_beside(&mut self, met: &Occluder<F>, side: f64) {
        (self.is_met, self.is_dark) = (true, true);
        for way in self.ways.iter_mut().filter(|way| way.is_open()) {
            let found = met.occlude(&way.rays, Some(side));
            way.verdict = way.verdict.with(found);
            way.asked =
                Lanes::select(Lanes::lit(0.0).lt(found.blocked), Lanes::lit(0.0), way.asked);
            self.is_dark &= !way.is_open();
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
