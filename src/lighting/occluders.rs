//! What may be in the way of light: in f64 for one ray or a ball of them, and exactly.

use glam::DVec3;

use crate::bounds::length_bound;
use crate::bvh::{Beam, Bvh, Corners, Traversal, Visitor};
use crate::num::{Float, Lanes, Real};
use crate::prepare::{
    Hierarchy, Lighting, Prepared, PreparedLight, ScaledInteger, exponent_of, power_of_two,
};
use crate::rays::Rays;
use crate::scene::{Object, Scene, Source};
use crate::shape::{Contact, Occluder, Occlusion, ShadowRay, SphereOccluder, Surface, shadow};
use crate::surface::Resolver;

/// Spheres that a ball is compared with at a time.
const LANES: usize = 8;

/// Where objects are looked for.
pub struct Occluders<'a> {
    pub stage: Resolver<'a>,
    pub prepared: &'a Prepared,
    pub scene: &'a Scene,
    /// The tree over many spheres.
    pub tree: Option<&'a Bvh>,
    /// [`Occluders::listed_in`], and the spheres among them before the first other object, side by side.
    listed: Vec<(u32, Occluder<f64>)>,
    spheres: Vec<SphereOccluder<Lanes<f64, LANES>>>,
    n_spheres: usize,
    /// From the reference point to that of the tree.
    to_tree: DVec3,
    /// The lamps' light, in their order.
    pub lights: Vec<LightSource>,
}

/// The origin of a lamp's light, and the surfaces near it.
pub struct LightSource {
    /// Relative to the reference point.
    pub origin: shadow::Origin,
    /// The objects that the lamp is close to, if it casts shadows.
    pub contacts: Vec<Contact>,
}

impl<'a> Occluders<'a> {
    pub fn new(prepared: &'a Prepared, rays: &'a Rays, lighting: &Lighting) -> Occluders<'a> {
        let (scene, stage) = (&*prepared.scene, Resolver::new(prepared, rays));
        let tree = prepared.hierarchy.as_ref().map(|hierarchy| &*hierarchy.bvh);
        let light = |lamp: &PreparedLight| {
            let origin = match lamp.origin {
                Source::Eye => shadow::Origin::Point(DVec3::ZERO),
                Source::Point(position) => shadow::Origin::Point(position - prepared.reference),
                Source::Sun(way) => shadow::Origin::Sun(ScaledInteger::new(way).rounded()),
            };
            let contacts = match lamp.origin {
                Source::Point(position) if lamp.casts_shadows() => contacts(prepared, position),
                _ => Vec::new(),
            };
            LightSource { origin, contacts }
        };
        let lights: Vec<LightSource> = lighting.lamps.iter().map(light).collect();
        let listed = Occluders::listed_in(prepared, &lights);
        let spheres: Vec<SphereOccluder<f64>> = listed
            .iter()
            .map_while(|(_, met)| if let Occluder::Sphere(met) = met { Some(*met) } else { None })
            .collect();
        Occluders {
            spheres: spheres.chunks(LANES).map(side_by_side).collect(),
            n_spheres: spheres.len(),
            stage,
            prepared,
            scene,
            tree,
            listed,
            to_tree: tree.map_or(DVec3::ZERO, |bvh| prepared.reference - bvh.reference),
            lights,
        }
    }

    /// Lists the places of the listed objects that may occlude the lamp with index `lamp` for a ball of points of the object `own`.
    /// Returns whether one occludes it for all of them.
    #[inline(always)]
    pub fn look_around(
        &self,
        lamp: usize,
        ball: &ShadowRay<f64>,
        own: u32,
        places: &mut Vec<usize>,
    ) -> bool {
        places.clear();
        let mut is_dark = false;
        let mut take = |place: usize, verdict: Occlusion<f64>| {
            if !verdict.is_clear() && self.listed[place].0 != own {
                is_dark |= verdict.is_blocked();
                places.push(place);
            }
        };
        for (first, spheres) in (0..).step_by(LANES).zip(&self.spheres) {
            let Occlusion { blocked, clear } = spheres.occlude(&ball.map(Lanes::splat), None);
            for lane in 0..LANES.min(self.n_spheres - first) {
                let (blocked, clear) = (blocked.0[lane], clear.0[lane]);
                take(first + lane, Occlusion { blocked, clear });
            }
        }
        for place in self.n_spheres..self.listed.len() {
            take(place, self.listed[place].1.occlude(ball, None));
        }
        let contacts = &self.lights[lamp].contacts;
        is_dark | (!contacts.is_empty() && self.look_at_contacts(contacts, ball, places))
    }

    /// Drops the places of objects that surely do not occlude a light with these contacts. Returns whether one of the contacts
    /// occludes it for all points of the ball.
    #[inline(never)]
    fn look_at_contacts(
        &self,
        contacts: &[Contact],
        ball: &ShadowRay<f64>,
        places: &mut Vec<usize>,
    ) -> bool {
        let mut is_dark = false;
        places.retain(|&place| {
            let (id, met) = &self.listed[place];
            let verdict = met.occlude(ball, Contact::side_at(contacts, *id));
            is_dark |= verdict.is_blocked();
            !verdict.is_clear()
        });
        is_dark
    }

    /// The objects that are not in the tree, without those that equal an earlier one, as shadow rays meet them in numbers of
    /// `F`, and their ids.
    pub fn listed_in<F: Float>(
        prepared: &Prepared,
        lights: &[LightSource],
    ) -> Vec<(u32, Occluder<F>)> {
        let reference = prepared.reference;
        let met = |(id, object)| match is_beyond::<F>(object, reference, lights) {
            true => (id, Occluder::Beyond),
            false => (id, Occluder::new(object, reference)),
        };
        prepared.listed(prepared.outside()).into_iter().map(met).collect()
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

    /// The ids of what f64 does not rule out to be in the way of the lamp with index `index` to a point of the object `own`.
    pub fn candidates(&self, index: usize, own: u32, surface: Option<&Surface<f64>>) -> Vec<u32> {
        let Some(surface) = surface else {
            return (1..=self.scene.n_objects() as u32).collect();
        };
        let LightSource { origin, contacts } = &self.lights[index];
        let aim = shadow::Aim::new(*origin);
        let ray = ShadowRay::new(&aim, surface.point, surface.point_error);
        let mut places = Vec::new();
        self.look_around(index, &ray, own, &mut places);
        let mut ids: Vec<u32> = places.into_iter().map(|place| self.listed[place].0).collect();
        if !surface.front {
            ids.push(own);
        }
        if let Some(bvh) = self.tree {
            let [point, room] = [surface.point.0, [surface.point_error; 3]].map(DVec3::from_array);
            let beam = self.beam(bvh, *origin, [point - room, point + room]);
            let mut look =
                OccluderVisitor { occluders: self, contacts, bvh, own, ray: &ray, ids: &mut ids };
            Traversal::default().all(bvh, bvh.root(), beam, &mut look);
        }
        ids
    }
}

/// Times the size of a tree: a light within is one that ways part at.
const NEAR: f64 = 4.0;

/// Looks for what may be in the way of a shadow ray.
struct OccluderVisitor<'a> {
    occluders: &'a Occluders<'a>,
    /// The contacts of the light.
    contacts: &'a [Contact],
    bvh: &'a Bvh,
    /// The object that it starts on.
    own: u32,
    ray: &'a ShadowRay<f64>,
    ids: &'a mut Vec<u32>,
}

impl Visitor for OccluderVisitor<'_> {
    fn last(&self) -> f32 {
        f32::INFINITY
    }

    fn see(&mut self, place: u32) {
        let id = self.bvh.ids[place as usize];
        let reference = self.occluders.prepared.reference;
        let met: SphereOccluder<f64> =
            SphereOccluder::new(&self.bvh.spheres[place as usize], reference);
        let verdict = met.occlude(self.ray, Contact::side_at(self.contacts, id));
        if id != self.own && !verdict.is_clear() {
            self.ids.push(id);
        }
    }
}

/// Returns the objects that a lamp is close to. In a tree, only spheres whose boxes contain the lamp are tested.
fn contacts(prepared: &Prepared, light: DVec3) -> Vec<Contact> {
    let contact = |object| Contact::new(object, light, prepared.reference);
    let listed = prepared.listed(prepared.outside()).into_iter();
    let mut contacts: Vec<Contact> = listed.filter_map(contact).collect();
    if let Some(Hierarchy { bvh, .. }) = &prepared.hierarchy {
        let at = light - bvh.reference;
        // Room for more than the rounding: a light close to a surface may be outside of the sphere's box.
        let room = at.abs() * 1e-3;
        // No box is farther away than the light itself.
        let beam = Beam::new([at - room, at + room], [DVec3::ZERO; 2], 0.0);
        let mut found = OccluderPlaces::default();
        Traversal::default().all(bvh, bvh.root(), beam, &mut found);
        contacts.extend(found.0.into_iter().filter_map(|place| {
            let place = place as usize;
            contact((bvh.ids[place], Object::Sphere(&bvh.spheres[place])))
        }));
    }
    contacts
}

/// Whether no shadow ray in `F` reaches a sphere.
///
/// A point that `F` knows is less than `2.7` times [`Float::FARTHEST`] from the reference point ([`Float::KNOWN`]). So shadow rays to
/// lamps within `4·FARTHEST` stay within, and the lines of those to suns pass the reference point as close.
fn is_beyond<F: Float>(object: Object, reference: DVec3, lights: &[LightSource]) -> bool {
    let Object::Sphere(sphere) = object else { return false };
    let (center, r) = (sphere.center - reference, sphere.radius.abs());
    // In a unit in which squares of lengths are in range.
    let unit = power_of_two(-exponent_of(center.abs().max(DVec3::splat(r))).max(0));
    let (center, r) = (center * unit, r * unit);
    let distance = length_bound(center);
    let reach = 4.0 * F::FARTHEST;
    let is_out_of_reach = |light: &LightSource| {
        let nearest = match light.origin {
            shadow::Origin::Point(at) if length_bound(at) > reach => return false,
            shadow::Origin::Point(_) => distance,
            shadow::Origin::Sun(way) => {
                // Of a line, or of a ray that goes away from the sphere.
                let way = -way / way.length();
                if center.dot(way) < 0.0 { distance } else { center.cross(way).length() }
            }
        };
        // Twice as far, and more than the rounding of `nearest`.
        nearest - r - 1e-12 * (distance + r) > 2.0 * reach * unit
    };
    center.is_finite() && lights.iter().all(is_out_of_reach)
}

/// Notes the places that it is shown.
#[derive(Default)]
struct OccluderPlaces(Vec<u32>);

impl Visitor for OccluderPlaces {
    fn last(&self) -> f32 {
        f32::INFINITY
    }

    fn see(&mut self, place: u32) {
        self.0.push(place);
    }
}

/// Some spheres side by side, the first one in the lanes that are left.
fn side_by_side(some: &[SphereOccluder<f64>]) -> SphereOccluder<Lanes<f64, LANES>> {
    let mut all: SphereOccluder<Lanes<f64, LANES>> = some[0].map(Lanes::splat);
    for (lane, met) in some.iter().enumerate() {
        for axis in 0..3 {
            all.center.0[axis].0[lane] = met.center.0[axis];
        }
        (all.r.0[lane], all.place.0[lane]) = (met.r, met.place);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Sphere;

    #[test]
    fn only_what_no_shadow_ray_reaches_is_beyond() {
        let lit_by = |origin| LightSource { origin, contacts: vec![] };
        let lamp = |x: f64| lit_by(shadow::Origin::Point(DVec3::X * x));
        // Towards its light, which comes along −x.
        let sun = || lit_by(shadow::Origin::Sun(-DVec3::X));
        let is_beyond = |center: DVec3, radius: f64, light: LightSource| {
            let (sphere, light) = (Sphere { center, radius }, [light]);
            let object = Object::Sphere(&sphere);
            [
                is_beyond::<f32>(object, DVec3::ZERO, &light),
                is_beyond::<f64>(object, DVec3::ZERO, &light),
            ]
        };
        for x in [1e75, 1e160, 1e200, 1e305] {
            let center = DVec3::X * x;
            assert_eq!(is_beyond(center, 1.0, lamp(3.0)), [true; 2], "{x:e}");
            assert_eq!(is_beyond(center, 0.9 * x, lamp(3.0)), [true; 2], "{x:e}");
            assert_eq!(is_beyond(center, x, lamp(3.0)), [false; 2], "{x:e}");
            assert_eq!(is_beyond(center, 1.0, lamp(2.0 * x)), [false; 2], "{x:e}");
            assert_eq!(is_beyond(center, 1.0, sun()), [false; 2], "{x:e}");
            assert_eq!(is_beyond(-center, 1.0, sun()), [true; 2], "{x:e}");
            assert_eq!(is_beyond(DVec3::Y * x, 1.0, sun()), [true; 2], "{x:e}");
        }
        assert_eq!(is_beyond(DVec3::X * 1e25, 1.0, lamp(3.0)), [true, false]);
        assert_eq!(is_beyond(DVec3::X * 1e18, 1.0, lamp(3.0)), [false; 2]);
        assert_eq!(is_beyond(DVec3::X * f64::INFINITY, 1.0, lamp(3.0)), [false; 2]);
    }
}
