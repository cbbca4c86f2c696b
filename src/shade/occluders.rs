//! What may be in the way of light: in f64 for one ray or a ball of them, and exactly.

use std::collections::HashSet;

use glam::DVec3;

use super::lamp::{Lamp, Lighting, Origin};
use crate::certify::Stage;
use crate::exact::{ExactBeam, ExactPoint, is_outside, slope_of};
use crate::guard::host::Bounded;
use crate::num::{Float, Lanes, Real, V3};
use crate::prepare::{Prepared, Scaled};
use crate::rays::Rays;
use crate::scene::{Object, Scene, Sphere};
use crate::seen::{
    In, Occluder, PlaneMet, Record, ShadowRay, SphereMet, SurfacePoint, Verdict, shadow,
};
use crate::tree::Segment;

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
    pub to_tree: DVec3,
    /// Points within this distance share a walk through the tree. It is the radius of some
    /// sphere, so that their ball is about as thick as what it meets.
    pub together: f64,
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
                let tree = &hierarchy.tree;
                let outside = tree.outside.iter().map(|index| index + 1);
                (outside.chain(planes).collect(), prepared.reference - tree.reference)
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
                    let normal = DVec3::from_array(here.normal.0);
                    let met = PlaneMet::new(relative(plane.point), normal);
                    (!here.is_repeated, Met::Plane(met))
                }
            };
            is_first.then_some(Listed { id, met })
        });
        let listed: Vec<Listed> = listed.collect();
        let is_plane = |place: &usize| matches!(listed[*place].met, Met::Plane(_));
        let planes = (0..listed.len()).filter(is_plane).collect();
        let some = prepared.hierarchy.as_ref().map_or(Vec::new(), |hierarchy| {
            let order = &hierarchy.tree.order;
            let some = order.iter().step_by(order.len() / 64 + 1);
            some.map(|&index| scene.spheres[index as usize]).collect()
        });
        let radius = |sphere: &Sphere| sphere.radius.abs();
        let apparent = |sphere: &Sphere| radius(sphere) / relative(sphere.center).length();
        let together = median(some.iter().map(radius)).unwrap_or(0.0);
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
            together,
            are_large,
            origins: lighting.lamps.iter().map(origin).collect(),
            suns: lighting.lamps.iter().map(sun).collect(),
        }
    }

    /// Whether spheres are looked for in a tree.
    pub fn has_tree(&self) -> bool {
        self.prepared.hierarchy.is_some()
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
            Met::Sphere(_) => Met::Sphere(self.met(listed.id - 1)),
            Met::Plane(met) => Met::Plane(met.round()),
        }
    }

    /// A sphere in numbers of `F`.
    #[inline(always)]
    pub fn met<F: Bounded>(&self, index: u32) -> In<SphereMet<f64>, F> {
        let &Sphere { center, radius } = &self.scene.spheres[index as usize];
        SphereMet::new::<F>(center - self.prepared.reference, radius).round()
    }

    /// A shadow ray in the tree, all of whose spheres lie within a distance from its start.
    #[inline(always)]
    pub fn segment(&self, ray: &ShadowRay<f64>) -> Option<Segment> {
        let tree = &self.prepared.hierarchy.as_ref()?.tree;
        let (from, way, is_endless) = ray.line();
        let from = DVec3::from_array(from.0);
        let origin = from + self.to_tree;
        // No test sees the 4 halved: the unit is two roundings.
        let rounding = 4.0 * f64::UNIT * (from.length() + self.to_tree.length());
        let farthest = farthest(origin, tree.largest_coordinate());
        let slack = ray.error_up_to(farthest) + rounding;
        Some(Segment { origin, way: DVec3::from_array(way.0), is_endless, slack })
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
        surface: Option<&SurfacePoint<f64>>,
    ) -> Result<bool, Vec<u32>> {
        let Some(surface) = surface else {
            let n_in_tree = if self.has_tree() { self.scene.spheres.len() as u32 } else { 0 };
            let listed = self.listed.iter().map(|listed| listed.id);
            return Err(listed.chain(1..=n_in_tree).chain([own]).collect());
        };
        if !surface.front && self.own_is_in_the_way(lamp, own) {
            return Ok(false);
        }
        let aim = shadow::Aim::new(self.origins[index]);
        let ray = ShadowRay::new(&aim, surface.point, surface.point_error);
        let mut open = Vec::new();
        let mut is_blocked = |id: u32, verdict: Verdict<f64>| {
            if !verdict.is_clear() {
                open.push(id);
            }
            verdict.is_blocked()
        };
        for listed in self.listed.iter().filter(|listed| listed.id != own) {
            if is_blocked(listed.id, listed.met.occlude(&ray)) {
                return Ok(false);
            }
        }
        let mut is_dark = false;
        if let (Some(hierarchy), Some(segment)) = (&self.prepared.hierarchy, self.segment(&ray)) {
            hierarchy.tree.visit_segment(&segment, |place| {
                let index = hierarchy.tree.order[place];
                is_dark |= index + 1 != own
                    && is_blocked(index + 1, SphereMet::occlude(&self.met::<f64>(index), &ray));
                !is_dark
            });
        }
        match (is_dark, open.is_empty()) {
            (true, _) => Ok(false),
            (false, true) => Ok(true),
            (false, false) => Err(open),
        }
    }

    /// The way from a point to a lamp, exactly.
    pub fn exact_ray<'p>(&self, lamp: &Lamp, point: &'p ExactPoint) -> Option<ExactBeam<'p>> {
        match lamp.origin {
            Origin::Eye => ExactBeam::to_position(point, self.prepared.reference),
            Origin::Point(position) => ExactBeam::to_position(point, position),
            Origin::Sun(direction) => ExactBeam::against(point, direction),
        }
    }

    /// Whether an object is a plane.
    pub fn is_plane(&self, id: u32) -> bool {
        id as usize > self.scene.spheres.len()
    }

    /// Whether a plane is seen from the side that its normal points to, as this surface of it is.
    pub fn faces_front(&self, id: u32, surface: &SurfacePoint<f64>) -> bool {
        surface.normal.dot(V3(self.stage.plane(id).normal.0)) > 0.0
    }

    /// Whether the sun with index `index` shines on that side of a plane, or on the other one: the same for all of it.
    pub fn lights_plane(&self, index: usize, id: u32, faces_front: bool) -> bool {
        let (shadow::Origin::Sun(way), Some(Object::Plane(plane))) =
            (self.origins[index], self.scene.object(id))
        else {
            return false;
        };
        let slope = -DVec3::from_array(self.stage.plane(id).normal.0).dot(way);
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

/// No point of a cube about 0 is farther away.
fn farthest(origin: DVec3, largest_coordinate: f64) -> f64 {
    1.01 * (origin.length() + 1.74 * largest_coordinate)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_a_cube_are_hardly_nearer_than_its_farthest_point() {
        for at in [1e-3, 1.0, 1e3] {
            let (origin, corner) = (DVec3::splat(at), DVec3::splat(-1.0));
            let part = origin.distance(corner) / farthest(origin, 1.0);
            assert!(part <= 1.0 && part > 0.98, "{at}: {part}");
        }
    }
}
