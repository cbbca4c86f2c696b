//! What may be in the way of light: in f64 for one ray or a ball of them, and exactly.

use std::collections::HashSet;

use glam::DVec3;

use super::lamp::{Lamp, Lighting, Origin};
use crate::bvh::{Beam, Bvh, Corners, Enter, Node, Visitor, Walk};
use crate::certify::Stage;
use crate::exact::{is_outside, slope_of};
use crate::guard::host::Bounded;
use crate::num::{Float, Lanes, Real, V3};
use crate::prepare::{Prepared, Scaled, exponent_of, power_of_two};
use crate::rays::Rays;
use crate::scene::{Object, Scene, Sphere};
use crate::seen::{In, Occluder, PlaneMet, Record, ShadowRay, SphereMet, Surface, Verdict, shadow};

/// Spheres that a ball is compared with at a time.
const LANES: usize = 8;

/// A sphere whose radius is this part of its distance has normals in f32 that are off by some thousandth of a byte's step. No
/// bound: of smaller ones f32 leaves more open than it saves.
const SMALL: f64 = 1.0 / 64.0;

/// Where objects are looked for.
pub struct Occluders<'a> {
    pub stage: Stage<'a>,
    pub prepared: &'a Prepared,
    pub scene: &'a Scene,
    /// The objects that are not in the tree, without those that equal an earlier one.
    pub listed: Vec<Listed>,
    /// The spheres of these side by side, with their places among them.
    spheres: Vec<(SphereMet<Lanes<f64, LANES>>, Vec<usize>)>,
    /// The places of the planes.
    planes: Vec<usize>,
    /// From the reference point to that of the tree.
    to_tree: DVec3,
    /// Whether its spheres appear so large that f32 mostly tells their bytes.
    pub are_large: bool,
    /// Where each lamp's light comes from, relative to the reference point.
    pub origins: Vec<shadow::Origin>,
    /// The suns among them as the scene has them.
    suns: Vec<Option<DVec3>>,
}

/// An object outside of the tree.
pub struct Listed {
    pub id: u32,
    pub met: Met<f64>,
}

/// An object as shadow rays meet it.
#[derive(Clone, Copy)]
pub enum Met<R: Copy> {
    Sphere(SphereMet<R>),
    Plane(PlaneMet<R>),
}

impl<F: Bounded> Met<F> {
    /// Whether it is in the way of rays that don't start on it.
    #[inline(always)]
    pub fn occlude<R: Real<One = F>>(&self, ray: &ShadowRay<R>) -> Verdict<R> {
        match self {
            Met::Sphere(met) => SphereMet::occlude(&<SphereMet<f64> as Record>::splat(met), ray),
            Met::Plane(met) => PlaneMet::occlude(&<PlaneMet<f64> as Record>::splat(met), ray),
        }
    }
}

impl<'a> Occluders<'a> {
    pub fn new(prepared: &'a Prepared, rays: &'a Rays, lighting: &Lighting) -> Occluders<'a> {
        let (scene, stage) = (&*prepared.scene, Stage::new(prepared, rays));
        let relative = |point: DVec3| point - prepared.reference;
        let planes = scene.spheres.len() as u32 + 1..=scene.n_objects() as u32;
        let (ids, to_tree): (Vec<u32>, _) = match &prepared.hierarchy {
            Some(hierarchy) => {
                let bvh = &hierarchy.bvh;
                let outside = bvh.outside.iter().copied();
                (outside.chain(planes).collect(), prepared.reference - bvh.reference)
            }
            None => ((1..=scene.n_objects() as u32).collect(), DVec3::ZERO),
        };
        let mut seen = HashSet::new();
        let listed = ids.into_iter().filter_map(|id| {
            let object = scene.object(id)?;
            let (is_first, met) = match object {
                Object::Sphere(sphere) if sphere.radius == 0.0 => return None,
                Object::Plane(plane) if plane.normal == DVec3::ZERO => return None,
                Object::Sphere(sphere) => {
                    let met = SphereMet::new::<f64>(relative(sphere.center), sphere.radius);
                    (seen.insert(crate::certify::bits(object)), Met::Sphere(met))
                }
                Object::Plane(plane) => {
                    let here = stage.plane(id);
                    let met = PlaneMet::new(relative(plane.point), here.normal);
                    (!here.is_repeated, Met::Plane(met))
                }
            };
            is_first.then_some(Listed { id, met })
        });
        let listed: Vec<Listed> = listed.collect();
        let is_plane = |place: &usize| matches!(listed[*place].met, Met::Plane(_));
        let planes = (0..listed.len()).filter(is_plane).collect();
        let some = prepared.hierarchy.as_ref().map_or(Vec::new(), |hierarchy| {
            let spheres = &hierarchy.bvh.spheres;
            spheres.iter().step_by(spheres.len() / 64 + 1).copied().collect()
        });
        let radius = |sphere: &Sphere| sphere.radius.abs();
        let apparent = |sphere: &Sphere| radius(sphere) / relative(sphere.center).length();
        let are_large = median(some.iter().map(apparent)).is_none_or(|size| size > SMALL);
        let origin = |lamp: &Lamp| match lamp.origin {
            Origin::Eye => shadow::Origin::Point(DVec3::ZERO),
            Origin::Point(position) => shadow::Origin::Point(relative(position)),
            Origin::Sun(way) => shadow::Origin::Sun(Scaled::new(way).rounded()),
        };
        let sun = |lamp: &Lamp| match lamp.origin {
            Origin::Sun(direction) => Some(direction),
            Origin::Eye | Origin::Point(_) => None,
        };
        Occluders {
            spheres: side_by_side(&listed),
            planes,
            stage,
            prepared,
            scene,
            listed,
            to_tree,
            are_large,
            origins: lighting.lamps.iter().map(origin).collect(),
            suns: lighting.lamps.iter().map(sun).collect(),
        }
    }

    /// Lists the places of the listed objects that may be in the way of rays from a ball of points of the object `own`, and says
    /// whether one is in the way of all.
    #[inline(always)]
    pub fn look_around(&self, ball: &ShadowRay<f64>, own: u32, places: &mut Vec<usize>) -> bool {
        places.clear();
        let mut is_dark = false;
        let mut take = |place: usize, verdict: Verdict<f64>| {
            if !verdict.is_clear() && self.listed[place].id != own {
                is_dark |= verdict.is_blocked();
                places.push(place);
            }
        };
        for (spheres, places) in &self.spheres {
            let Verdict { blocked, clear } = SphereMet::occlude(spheres, &ball.repeated());
            for (lane, &place) in places.iter().enumerate() {
                take(place, Verdict { blocked: blocked.0[lane], clear: clear.0[lane] });
            }
        }
        for &place in &self.planes {
            take(place, self.listed[place].met.occlude(ball));
        }
        is_dark
    }

    /// A listed object in numbers of `F`.
    pub fn met_listed<F: Bounded>(&self, listed: &Listed) -> Met<F> {
        match listed.met {
            Met::Sphere(_) => Met::Sphere(self.met(&self.scene.spheres[listed.id as usize - 1])),
            Met::Plane(met) => Met::Plane(met.round()),
        }
    }

    /// A sphere in numbers of `F`.
    #[inline(always)]
    pub fn met<F: Bounded>(&self, &Sphere { center, radius }: &Sphere) -> In<SphereMet<f64>, F> {
        SphereMet::new::<F>(center - self.prepared.reference, radius).round()
    }

    /// The tree over many spheres.
    pub fn tree(&self) -> Option<&Bvh> {
        self.prepared.hierarchy.as_ref().map(|hierarchy| &*hierarchy.bvh)
    }

    /// The ways between points, which lie between two corners from the reference point, and a light. They begin at the light
    /// where that is about as near as the tree is large, so that they part there; at the points where it is far.
    #[inline(always)]
    pub fn beam(&self, bvh: &Bvh, origin: shadow::Origin, [low, high]: Corners) -> Beam {
        // Each number is rounded at most three times, by a half; no test sees the rest.
        let room = |numbers: DVec3| numbers * (4.0 * f64::EPSILON);
        let farthest = low.abs().max(high.abs());
        let moved = |[low, high]: Corners, size: DVec3| {
            let room = room(size + self.to_tree.abs());
            [low + self.to_tree - room, high + self.to_tree + room]
        };
        match origin {
            shadow::Origin::Sun(direction) => {
                let points = moved([low, high], farthest);
                Beam::new(points, [-direction; 2], bvh.end(points))
            }
            shadow::Origin::Point(light) => {
                let (size, room) = (light.abs(), room(light.abs() + farthest));
                let is_near = (light + self.to_tree).abs().max_element() <= NEAR * bvh.size();
                let (from, [slow, quick]) = match is_near {
                    true => (moved([light; 2], size), [low - light - room, high - light + room]),
                    false => {
                        (moved([low, high], farthest), [light - high - room, light - low + room])
                    }
                };
                // With directions of a length about 1 f32 has room for slabs.
                let exponent = exponent_of(slow.abs().max(quick.abs()));
                let power = power_of_two(-exponent);
                Beam::new(from, [slow * power, quick * power], power_of_two(exponent))
            }
        }
    }

    /// Whether the sphere around a ray's origin is in the way of light to its inside: it is where the lamp
    /// is outside.
    pub fn own_is_in_the_way(&self, lamp: &Lamp, id: u32) -> bool {
        match (lamp.origin, self.scene.object(id)) {
            (Origin::Point(position), Some(Object::Sphere(sphere))) => {
                is_outside(position, sphere.center, sphere.radius) != Some(false)
            }
            (Origin::Sun(_), Some(Object::Sphere(_))) => true,
            _ => false,
        }
    }

    /// Whether the light of the lamp with index `index` reaches a point that faces it, in f64; and the ids of what leaves that
    /// open.
    pub fn look(
        &self,
        (index, lamp): (usize, &Lamp),
        own: u32,
        surface: Option<&Surface<f64>>,
    ) -> Result<bool, Vec<u32>> {
        let Some(surface) = surface else {
            let n_in_tree = if self.tree().is_some() { self.scene.spheres.len() as u32 } else { 0 };
            let listed = self.listed.iter().map(|listed| listed.id);
            return Err(listed.chain(1..=n_in_tree).chain([own]).collect());
        };
        if !surface.front && self.own_is_in_the_way(lamp, own) {
            return Ok(false);
        }
        let aim = shadow::Aim::new(self.origins[index]);
        let ray = ShadowRay::new(&aim, surface.point, surface.point_error);
        let mut open = Vec::new();
        for listed in self.listed.iter().filter(|listed| listed.id != own) {
            let verdict = listed.met.occlude(&ray);
            if verdict.is_blocked() {
                return Ok(false);
            }
            if !verdict.is_clear() {
                open.push(listed.id);
            }
        }
        if let Some(bvh) = self.tree() {
            let [point, room] = [surface.point.0, [surface.point_error; 3]].map(DVec3::from_array);
            let beam = self.beam(bvh, self.origins[index], [point - room, point + room]);
            let mut look =
                Look { occluders: self, bvh, own, ray: &ray, open: &mut open, is_dark: false };
            Walk::default().all(bvh, bvh.root(), beam, &mut look);
            if look.is_dark {
                return Ok(false);
            }
        }
        if open.is_empty() { Ok(true) } else { Err(open) }
    }

    /// Whether an object is a plane.
    pub fn is_plane(&self, id: u32) -> bool {
        id as usize > self.scene.spheres.len()
    }

    /// Whether a plane is seen from the side that its normal points to, as this surface of it is.
    pub fn faces_front(&self, id: u32, surface: &Surface<f64>) -> bool {
        surface.normal.dot(V3(self.stage.plane(id).normal.to_array())) > 0.0
    }

    /// Whether the sun with index `index` shines on that side of a plane, or on the other one: the same for all of it.
    pub fn lights_plane(&self, index: usize, id: u32, faces_front: bool) -> bool {
        let (shadow::Origin::Sun(way), Some(Object::Plane(plane))) =
            (self.origins[index], self.scene.object(id))
        else {
            return false;
        };
        let slope = -self.stage.plane(id).normal.dot(way);
        // The vectors' lengths are below 4, their product's rounding is 3 units. No test sees the
        // 64 halved: 18 would do.
        let is_known = slope.abs() > 64.0 * f64::UNIT;
        let sign = match (is_known, self.suns[index]) {
            (false, Some(direction)) => -slope_of(plane.normal, direction),
            _ if slope > 0.0 => 1,
            _ => -1,
        };
        sign == if faces_front { 1 } else { -1 }
    }
}

/// Times the size of a tree: a light within is one that ways part at.
const NEAR: f64 = 4.0;

/// Looks for what is in the way of a shadow ray.
struct Look<'a> {
    occluders: &'a Occluders<'a>,
    bvh: &'a Bvh,
    /// The object that it starts on.
    own: u32,
    ray: &'a ShadowRay<f64>,
    /// The ids of what leaves it open.
    open: &'a mut Vec<u32>,
    is_dark: bool,
}

impl Visitor for Look<'_> {
    fn last(&self) -> f32 {
        if self.is_dark { -1.0 } else { f32::INFINITY }
    }

    fn visit(&mut self, node: &Node, leaves: u32, _: &Enter) {
        for lane in (0..u32::BITS).filter(|lane| leaves >> lane & 1 == 1) {
            let place = node.place(lane) as usize;
            let id = self.bvh.ids[place];
            if id == self.own {
                continue;
            }
            let met = self.occluders.met::<f64>(&self.bvh.spheres[place]);
            let verdict = SphereMet::occlude(&met, self.ray);
            self.is_dark |= verdict.is_blocked();
            if !verdict.is_clear() {
                self.open.push(id);
            }
        }
    }
}

/// The middle one of some numbers.
fn median(numbers: impl Iterator<Item = f64>) -> Option<f64> {
    let mut numbers: Vec<f64> = numbers.collect();
    numbers.sort_unstable_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied()
}

/// The spheres among some objects, some at a time, with their places.
fn side_by_side(listed: &[Listed]) -> Vec<(SphereMet<Lanes<f64, LANES>>, Vec<usize>)> {
    let spheres = listed.iter().enumerate().filter_map(|(place, object)| match object.met {
        Met::Sphere(met) => Some((place, met)),
        Met::Plane(_) => None,
    });
    let spheres: Vec<(usize, SphereMet<f64>)> = spheres.collect();
    let group = |some: &[(usize, SphereMet<f64>)]| {
        // What follows the last one is not looked at.
        let mut group: SphereMet<Lanes<f64, LANES>> = SphereMet::splat(&some[0].1);
        for (lane, (_, met)) in some.iter().enumerate() {
            for axis in 0..3 {
                group.center.0[axis].0[lane] = met.center.0[axis];
            }
            (group.r.0[lane], group.place.0[lane]) = (met.r, met.place);
        }
        (group, some.iter().map(|&(place, _)| place).collect())
    };
    spheres.chunks(LANES).map(group).collect()
}
