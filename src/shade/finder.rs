//! What is in the way of light: in f64 for some points side by side, and exactly.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use std::collections::HashSet;

use glam::DVec3;

use super::beam::{Beam, in_the_way};
use super::lamp::{Lamp, Lighting, Origin};
use crate::certify::{LANES, Pack, Stage};
use crate::exact::{ExactBeam, ExactPoint, is_outside};
use crate::guard::UNIT_F64;
use crate::prepare::{Prepared, exponent_of, scale_by_power_of_two};
use crate::rays::Rays;
use crate::scene::{Object, Scene};
use crate::trace::StageCounts;
use crate::tree::Segment;
use crate::vec3::Vec3;

/// Numbers side by side.
pub type Row = [f64; LANES];

/// Where objects are looked for.
pub struct Finder<'a> {
    pub stage: Stage<'a>,
    prepared: &'a Prepared,
    scene: &'a Scene,
    /// The objects that are not in the tree, without those that equal an earlier one.
    pub(super) listed: Vec<Listed>,
    /// From the reference point to that of the tree.
    pub(super) to_tree: DVec3,
    pub(super) lamps: Vec<LampF64>,
}

/// An object, relative to the reference point.
pub(super) struct Listed {
    pub id: u32,
    pub at: Vec3<f64>,
    pub shape: ListedShape,
}

pub(super) enum ListedShape {
    Sphere(f64),
    /// With its normal.
    Plane(Vec3<f64>),
}

/// [`Origin`], relative to the reference point.
#[derive(Clone, Copy)]
pub(super) enum LampF64 {
    Eye,
    Point(Vec3<f64>),
    Sun(Vec3<f64>),
}

/// Bounds of what a lamp gives, as parts of its weight.
#[derive(Clone, Copy)]
pub struct Given {
    pub low: Row,
    pub high: Row,
}

/// Beams side by side.
struct Beams {
    from: [Row; 3],
    way: [Row; 3],
    square: Row,
    inverse: Row,
    error: Row,
    turned: Row,
    is_endless: bool,
}

impl Beams {
    #[inline(always)]
    fn new(is_endless: bool) -> Beams {
        let (zero, zero3) = ([0.0; LANES], [[0.0; LANES]; 3]);
        let [square, inverse, error, turned] = [zero; 4];
        Beams { from: zero3, way: zero3, square, inverse, error, turned, is_endless }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, beam: Beam) {
        for axis in 0..3 {
            self.from[axis][lane] = beam.from.0[axis];
            self.way[axis][lane] = beam.way.0[axis];
        }
        (self.square[lane], self.inverse[lane]) = (beam.square, beam.inverse);
        (self.error[lane], self.turned[lane]) = (beam.error, beam.turned);
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> Beam {
        Beam {
            from: vector(&self.from, lane),
            way: vector(&self.way, lane),
            square: self.square[lane],
            inverse: self.inverse[lane],
            error: self.error[lane],
            turned: self.turned[lane],
            is_endless: self.is_endless,
            unit: UNIT_F64,
        }
    }
}

#[inline(always)]
fn vector(rows: &[Row; 3], lane: usize) -> Vec3<f64> {
    Vec3([rows[0][lane], rows[1][lane], rows[2][lane]])
}

impl<'a> Finder<'a> {
    pub fn new(prepared: &'a Prepared, rays: &'a Rays, lighting: Option<&Lighting>) -> Finder<'a> {
        let (scene, stage) = (&*prepared.scene, Stage::new(prepared, rays));
        let relative = |point: DVec3| Vec3::from(point - prepared.reference);
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
            let (at, shape) = match object {
                Object::Sphere(sphere) if sphere.radius == 0.0 => return None,
                Object::Plane(plane) if plane.normal == DVec3::ZERO => return None,
                Object::Sphere(sphere) => (sphere.center, ListedShape::Sphere(sphere.radius.abs())),
                Object::Plane(plane) => (plane.point, ListedShape::Plane(stage.plane(id).normal)),
            };
            let is_first = seen.insert(crate::certify::bits(object));
            is_first.then(|| Listed { id, at: relative(at), shape })
        });
        let listed = listed.collect();
        let lamp = |lamp: &Lamp| match lamp.origin {
            Origin::Eye => LampF64::Eye,
            Origin::Point(position) => LampF64::Point(relative(position)),
            Origin::Sun(way) => LampF64::Sun(scale_by_power_of_two(way, -exponent_of(way)).into()),
        };
        let lamps = lighting.map_or(Vec::new(), |l| l.lamps.iter().map(lamp).collect());
        Finder { stage, prepared, scene, listed, to_tree, lamps }
    }

    #[inline(always)]
    fn beam(&self, lamp: LampF64, at: Vec3<f64>, error: f64, direction: Vec3<f64>) -> Beam {
        match lamp {
            // Against the ray, whose direction is better known than the point.
            LampF64::Eye => Beam::to_eye(at, direction, self.stage.direction_error()),
            LampF64::Point(position) => Beam::to_point(at, error, position),
            LampF64::Sun(way) => Beam::to_sun(at, error, way),
        }
    }

    #[inline(always)]
    fn beams(&self, lamp: LampF64, pack: &Pack) -> Beams {
        let mut beams = Beams::new(matches!(lamp, LampF64::Sun(_)));
        match lamp {
            LampF64::Eye => {
                let turned = self.stage.direction_error();
                for lane in 0..LANES {
                    let (at, direction) = (vector(&pack.at, lane), vector(&pack.direction, lane));
                    beams.set(lane, Beam::to_eye(at, direction, turned));
                }
            }
            LampF64::Point(position) => {
                for lane in 0..LANES {
                    let (at, error) = (vector(&pack.at, lane), pack.error[lane]);
                    beams.set(lane, Beam::to_point(at, error, position));
                }
            }
            LampF64::Sun(way) => {
                for lane in 0..LANES {
                    let (at, error) = (vector(&pack.at, lane), pack.error[lane]);
                    beams.set(lane, Beam::to_sun(at, error, way));
                }
            }
        }
        beams
    }

    /// What the lamp with index `index` gives some points. `last` is the place in the tree of what was
    /// in the way before, which is looked at first.
    #[inline(always)]
    pub fn light(
        &self,
        index: usize,
        lamp: &Lamp,
        pack: &Pack,
        last: &mut Option<usize>,
        counts: &mut StageCounts,
    ) -> Given {
        let beams = self.beams(self.lamps[index], pack);
        let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
        for lane in 0..LANES {
            let normal = vector(&pack.normal, lane);
            let cosine = beams.get(lane).cosine(normal, pack.normal_error[lane]);
            (low[lane], high[lane]) = cosine;
        }
        for lane in 0..LANES {
            high[lane] = if pack.id[lane] != 0 { high[lane] } else { 0.0 };
        }
        if !lamp.shadows || lamp.origin == Origin::Eye || high == [0.0; LANES] {
            return Given { low, high };
        }
        let mut state = [in_the_way::NO; LANES];
        for object in &self.listed {
            let mut met = [in_the_way::NO; LANES];
            match object.shape {
                ListedShape::Sphere(r) => {
                    for lane in 0..LANES {
                        met[lane] = beams.get(lane).meets_sphere(object.at, r);
                    }
                }
                ListedShape::Plane(normal) => {
                    for lane in 0..LANES {
                        met[lane] = beams.get(lane).meets_plane(object.at, normal);
                    }
                }
            }
            for lane in 0..LANES {
                // No object is in its own light but for a sphere around the ray's origin.
                let met = if pack.id[lane] == object.id { in_the_way::NO } else { met[lane] };
                state[lane] = if met > state[lane] { met } else { state[lane] };
            }
        }
        for lane in 0..LANES {
            if high[lane] == 0.0 {
                continue;
            }
            counts.f64 += 1;
            if pack.is_inside[lane] && self.own_is_in_the_way(lamp, pack.id[lane]) {
                state[lane] = in_the_way::YES;
            }
            if state[lane] != in_the_way::YES && self.prepared.hierarchy.is_some() {
                let found = self.look_in_tree(&beams.get(lane), pack.id[lane], last, |_| ());
                state[lane] = state[lane].max(found);
            }
            low[lane] = if state[lane] == in_the_way::NO { low[lane] } else { 0.0 };
            high[lane] = if state[lane] == in_the_way::YES { 0.0 } else { high[lane] };
        }
        Given { low, high }
    }

    /// Whether the sphere around a ray's origin is in the way of light to its inside: it is where the lamp
    /// is outside.
    fn own_is_in_the_way(&self, lamp: &Lamp, id: u32) -> bool {
        match (lamp.origin, self.scene.object(id)) {
            (Origin::Point(position), Some(Object::Sphere(sphere))) => {
                is_outside(position, sphere.center, sphere.radius) != Some(false)
            }
            (Origin::Sun(_), Some(Object::Sphere(_))) => true,
            _ => false,
        }
    }

    /// What is in the way of a beam from an object among the spheres of the tree; `open` is told what may
    /// be, as long as nothing certainly is.
    fn look_in_tree(
        &self,
        beam: &Beam,
        own: u32,
        last: &mut Option<usize>,
        mut open: impl FnMut(u32),
    ) -> f64 {
        let Some(hierarchy) = &self.prepared.hierarchy else { return in_the_way::NO };
        let tree = &hierarchy.tree;
        let meets = |place: usize| {
            let index = tree.order[place];
            match index + 1 == own {
                true => in_the_way::NO,
                false => {
                    let sphere = &self.scene.spheres[index as usize];
                    let center = (sphere.center - self.prepared.reference).into();
                    beam.meets_sphere(center, sphere.radius.abs())
                }
            }
        };
        if last.is_some_and(|place| meets(place) == in_the_way::YES) {
            return in_the_way::YES;
        }
        let mut state = in_the_way::NO;
        let mut look_at = |place: usize| {
            let met = meets(place);
            if met == in_the_way::OPEN {
                open(tree.order[place] + 1);
            }
            state = state.max(met);
            let goes_on = met != in_the_way::YES;
            if !goes_on {
                *last = Some(place);
            }
            goes_on
        };
        let from = DVec3::from_array(beam.from.0);
        let origin = from + self.to_tree;
        let rounding = 4.0 * UNIT_F64 * (from.length() + self.to_tree.length());
        let segment = Segment {
            origin,
            way: DVec3::from_array(beam.way.0),
            is_endless: beam.is_endless,
            slack: beam.error + rounding,
        };
        match origin.is_finite() && segment.slack.is_finite() {
            true => tree.visit_segment(&segment, look_at),
            // f64 can't say where.
            false => {
                let _ = (0..tree.order.len()).all(&mut look_at);
            }
        }
        state
    }

    /// The way from a point to a lamp, exactly.
    pub fn exact_beam<'p>(&self, lamp: &Lamp, point: &'p ExactPoint) -> Option<ExactBeam<'p>> {
        match lamp.origin {
            Origin::Eye => ExactBeam::to_position(point, self.prepared.reference),
            Origin::Point(position) => ExactBeam::to_position(point, position),
            Origin::Sun(direction) => ExactBeam::against(point, direction),
        }
    }

    /// Whether the light of the lamp with index `index` reaches a sample's point exactly.
    pub fn is_seen(
        &self,
        index: usize,
        lamp: &Lamp,
        exact: &ExactBeam,
        sample: usize,
        id: u32,
        counts: &mut StageCounts,
    ) -> bool {
        if !lamp.shadows || lamp.origin == Origin::Eye {
            return true;
        }
        let is_in_the_way = |id: &u32| {
            self.scene.object(*id).is_some_and(|object| exact.is_blocked_by(&object.into()))
        };
        // The own sphere counts by its exact numbers, like the others.
        let mut candidates: Vec<u32> = self.listed.iter().map(|listed| listed.id).collect();
        if self.prepared.hierarchy.is_some() {
            candidates.push(id);
            let direction = self.stage.direction(sample);
            match self.stage.point_f64(sample, id) {
                Some((point, _)) => {
                    let beam = self.beam(self.lamps[index], point.at, point.error, direction);
                    let push = |id| candidates.push(id);
                    if self.look_in_tree(&beam, id, &mut None, push) == in_the_way::YES {
                        return false;
                    }
                }
                None => candidates.extend(1..=self.scene.spheres.len() as u32),
            }
        }
        counts.exact += 1;
        counts.f64 = counts.f64.saturating_sub(1);
        !candidates.iter().any(is_in_the_way)
    }
}
