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
use crate::tree::{Ahead, Segment, Tree};
use crate::vec3::{Vec3, dot3};

/// Numbers side by side.
pub type Row = [f64; LANES];

/// Where objects are looked for.
pub struct Finder<'a> {
    pub stage: Stage<'a>,
    prepared: &'a Prepared,
    scene: &'a Scene,
    /// The objects that are not in the tree, without those that equal an earlier one.
    listed: Vec<Listed>,
    /// From the reference point to that of the tree.
    to_tree: DVec3,
    /// Points of a pack within this distance share a walk through the tree. It is the radius of some
    /// sphere, so that their common beam is about as thick as what it meets.
    together: f64,
    lamps: Vec<LampF64>,
}

/// An object, relative to the reference point.
struct Listed {
    id: u32,
    at: Vec3<f64>,
    shape: ListedShape,
}

enum ListedShape {
    Sphere(f64),
    /// With its normal.
    Plane(Vec3<f64>),
}

/// [`Origin`], relative to the reference point.
#[derive(Clone, Copy)]
enum LampF64 {
    Eye,
    Point(Vec3<f64>),
    Sun(Vec3<f64>),
}

/// Packs that are looked at together.
pub const PACKS: usize = 8;

/// Bounds of what a lamp gives, as parts of its weight.
#[derive(Clone, Copy)]
pub struct Given {
    pub low: Row,
    pub high: Row,
}

impl Given {
    const NOTHING: Given = Given { low: [0.0; LANES], high: [0.0; LANES] };
}

/// Room for looking for what is in the way, and what was in it before.
#[derive(Default)]
pub struct Room {
    /// Indices of the listed objects that may be in the way.
    listed: Vec<usize>,
    ahead: Ahead,
    /// For each lamp and each pack of a row, the place in the tree of what was in the way last.
    last: Vec<Option<usize>>,
    n_columns: usize,
}

impl Room {
    /// For rows of so many packs.
    pub fn new(n_lamps: usize, n_columns: usize) -> Room {
        Room { last: vec![None; n_lamps * n_columns], n_columns, ..Room::default() }
    }
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

    /// [`Beam::meets_sphere`] of each.
    #[inline(always)]
    fn meet_sphere(&self, center: Vec3<f64>, r: f64) -> Row {
        let mut met = [in_the_way::NO; LANES];
        for lane in 0..LANES {
            met[lane] = self.get(lane).meets_sphere(center, r);
        }
        met
    }

    /// [`Beam::meets_plane`] of each.
    #[inline(always)]
    fn meet_plane(&self, point: Vec3<f64>, normal: Vec3<f64>) -> Row {
        let mut met = [in_the_way::NO; LANES];
        for lane in 0..LANES {
            met[lane] = self.get(lane).meets_plane(point, normal);
        }
        met
    }

    /// [`Beam::cosine`] of each that starts on an object.
    #[inline(always)]
    fn cosines(&self, pack: &Pack) -> Given {
        let (mut low, mut high) = ([0.0; LANES], [0.0; LANES]);
        let Pack { normal, normal_error, id, .. } = *pack;
        for lane in 0..LANES {
            let cosine = self.get(lane).cosine(vector(&normal, lane), normal_error[lane]);
            (low[lane], high[lane]) = cosine;
        }
        for lane in 0..LANES {
            high[lane] = if id[lane] != 0 { high[lane] } else { 0.0 };
        }
        Given { low, high }
    }
}

impl Listed {
    #[inline(always)]
    fn meets(&self, beam: &Beam) -> f64 {
        match self.shape {
            ListedShape::Sphere(r) => beam.meets_sphere(self.at, r),
            ListedShape::Plane(normal) => beam.meets_plane(self.at, normal),
        }
    }
}

/// What is known of the ways from a pack's points to a lamp.
struct Ways<'a> {
    pack: &'a Pack,
    beams: &'a Beams,
    /// Whether something is in them, see [`in_the_way`].
    state: Row,
}

impl Ways<'_> {
    /// Takes into account how they meet an object. None is in its own light but for a sphere around the
    /// ray's origin.
    #[inline(always)]
    fn take(&mut self, id: u32, met: &Row) {
        for lane in 0..LANES {
            let met = if self.pack.id[lane] == id { in_the_way::NO } else { met[lane] };
            self.state[lane] = if met > self.state[lane] { met } else { self.state[lane] };
        }
    }

    /// True where something is in all of these ways.
    #[inline(always)]
    fn are_blocked(&self, some: &Row) -> bool {
        let mut is_open = false;
        for lane in 0..LANES {
            is_open |= (some[lane] > 0.0) & (self.state[lane] != in_the_way::YES);
        }
        !is_open
    }
}

#[inline(always)]
fn vector(rows: &[Row; 3], lane: usize) -> Vec3<f64> {
    Vec3([rows[0][lane], rows[1][lane], rows[2][lane]])
}

/// The middle of the points whose number in `asked` is positive, and how far each true one may be from it.
/// Without points, or where one is no number, that is as far as can be.
///
/// They lie in a box, so that half its diagonal reaches them, the 0.01 for its rounding. The middle itself is
/// rounded once.
#[inline(always)]
fn middle<'p>(points: impl Iterator<Item = (&'p Pack, &'p Row)>) -> (Vec3<f64>, f64) {
    let (mut low, mut high) = ([[f64::INFINITY; LANES]; 3], [[f64::NEG_INFINITY; LANES]; 3]);
    let mut error = [0.0; LANES];
    for (pack, asked) in points {
        for lane in 0..LANES {
            let is_asked = asked[lane] > 0.0;
            for axis in 0..3 {
                let at = pack.at[axis][lane];
                let (low, high) = (&mut low[axis][lane], &mut high[axis][lane]);
                *low = if is_asked & (at < *low) { at } else { *low };
                *high = if is_asked & (at > *high) { at } else { *high };
            }
            let is_worse = is_asked & (pack.error[lane] > error[lane]);
            error[lane] = if is_worse { pack.error[lane] } else { error[lane] };
        }
    }
    let least = |row: &Row| row.iter().copied().fold(f64::INFINITY, f64::min);
    let most = |row: &Row| row.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (low, high) = (Vec3(low.each_ref().map(least)), Vec3(high.each_ref().map(most)));
    let half = (high - low) * 0.5;
    let middle = low + half;
    let reach = 1.01 * dot3(half, half).sqrt() + UNIT_F64 * dot3(middle, middle).sqrt();
    let error = most(&error) + reach;
    if error < f64::INFINITY { (middle, error) } else { (Vec3::ZERO, f64::INFINITY) }
}

impl<'a> Finder<'a> {
    pub fn new(prepared: &'a Prepared, rays: &'a Rays, lighting: &Lighting) -> Finder<'a> {
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
        let together = prepared.hierarchy.as_ref().map_or(0.0, |hierarchy| {
            let order = &hierarchy.tree.order;
            let some = order.iter().step_by(order.len() / 64 + 1);
            let mut radii: Vec<f64> =
                some.map(|&index| scene.spheres[index as usize].radius.abs()).collect();
            radii.sort_unstable_by(f64::total_cmp);
            radii.get(radii.len() / 2).copied().unwrap_or(0.0)
        });
        let lamp = |lamp: &Lamp| match lamp.origin {
            Origin::Eye => LampF64::Eye,
            Origin::Point(position) => LampF64::Point(relative(position)),
            Origin::Sun(way) => LampF64::Sun(scale_by_power_of_two(way, -exponent_of(way)).into()),
        };
        let lamps = lighting.lamps.iter().map(lamp).collect();
        Finder { stage, prepared, scene, listed, to_tree, together, lamps }
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
        // What is not referred to can be loaded side by side.
        let Pack { at, error, direction, .. } = *pack;
        match lamp {
            LampF64::Eye => {
                let turned = self.stage.direction_error();
                for lane in 0..LANES {
                    let (at, direction) = (vector(&at, lane), vector(&direction, lane));
                    beams.set(lane, Beam::to_eye(at, direction, turned));
                }
            }
            LampF64::Point(position) => {
                for lane in 0..LANES {
                    beams.set(lane, Beam::to_point(vector(&at, lane), error[lane], position));
                }
            }
            LampF64::Sun(way) => {
                for lane in 0..LANES {
                    beams.set(lane, Beam::to_sun(vector(&at, lane), error[lane], way));
                }
            }
        }
        beams
    }

    /// What the lamp with index `index` gives the points of some packs, up to [`PACKS`], the first of which
    /// is in this column of its row.
    #[inline(always)]
    pub fn light<S: pulp::Simd>(
        &self,
        simd: S,
        (index, lamp): (usize, &Lamp),
        (column, packs): (usize, &[Pack]),
        room: &mut Room,
        counts: &mut StageCounts,
    ) -> [Given; PACKS] {
        let mut given = [Given::NOTHING; PACKS];
        for (pack, given) in packs.iter().zip(&mut given) {
            *given = self.beams(self.lamps[index], pack).cosines(pack);
        }
        if !lamp.shadows || lamp.origin == Origin::Eye {
            return given;
        }
        let asked = given.each_ref().map(|given| given.high);
        if asked == [[0.0; LANES]; PACKS] {
            return given;
        }
        let (from, error) = middle(packs.iter().zip(&asked));
        // What is not in the way of a beam around all of them is in the way of none.
        let around = self.beam(self.lamps[index], from, error, Vec3::ZERO);
        room.listed.clear();
        for (at, object) in self.listed.iter().enumerate() {
            if object.meets(&around) != in_the_way::NO {
                room.listed.push(at);
            }
        }
        for (at, pack) in packs.iter().enumerate() {
            let (asked, given) = (&asked[at], &mut given[at]);
            if *asked == [0.0; LANES] {
                continue;
            }
            // Once more: it takes longer to keep them.
            let beams = &self.beams(self.lamps[index], pack);
            let mut ways = Ways { pack, beams, state: [in_the_way::NO; LANES] };
            for &at in &room.listed {
                let Listed { id, at, ref shape } = self.listed[at];
                let met = match *shape {
                    ListedShape::Sphere(r) => beams.meet_sphere(at, r),
                    ListedShape::Plane(normal) => beams.meet_plane(at, normal),
                };
                ways.take(id, &met);
            }
            for lane in 0..LANES {
                let is_asked = asked[lane] > 0.0;
                counts.f64 += u64::from(is_asked);
                if is_asked && pack.is_inside[lane] && self.own_is_in_the_way(lamp, pack.id[lane]) {
                    ways.state[lane] = in_the_way::YES;
                }
            }
            if self.prepared.hierarchy.is_some() {
                self.look_together(simd, index, column + at, asked, &mut ways, room);
            }
            for lane in 0..LANES {
                let state = ways.state[lane];
                given.low[lane] = if state == in_the_way::NO { given.low[lane] } else { 0.0 };
                given.high[lane] = if state == in_the_way::YES { 0.0 } else { given.high[lane] };
            }
        }
        given
    }

    /// Looks among the spheres of the tree for what is in the ways to the lamp with index `index`, whose
    /// number in `asked` is positive.
    #[inline(always)]
    fn look_together<S: pulp::Simd>(
        &self,
        simd: S,
        index: usize,
        column: usize,
        asked: &Row,
        ways: &mut Ways,
        room: &mut Room,
    ) {
        let Some(hierarchy) = &self.prepared.hierarchy else { return };
        let tree = &hierarchy.tree;
        // What was in the way of the pack above this one, and of the one beside it.
        let slot = index * room.n_columns + column;
        for place in [room.last[slot], room.last[slot.saturating_sub(1)]].into_iter().flatten() {
            self.meet(tree, place, ways);
        }
        let mut asked = *asked;
        while let Some(first) =
            (0..LANES).find(|&lane| (asked[lane] > 0.0) & (ways.state[lane] != in_the_way::YES))
        {
            let (pack, mut some) = (ways.pack, [0.0; LANES]);
            let at = vector(&pack.at, first);
            for lane in 0..LANES {
                let apart = vector(&pack.at, lane) - at;
                let is_near = dot3(apart, apart) <= self.together * self.together;
                let is_open = ways.state[lane] != in_the_way::YES;
                some[lane] = if is_near & is_open { asked[lane] } else { 0.0 };
            }
            // Also where it is no number.
            some[first] = asked[first];
            for lane in 0..LANES {
                asked[lane] = if some[lane] > 0.0 { 0.0 } else { asked[lane] };
            }
            let (from, error) = middle(std::iter::once((pack, &some)));
            let around = self.beam(self.lamps[index], from, error, Vec3::ZERO);
            let last = &mut room.last[slot];
            let look_at = |place: usize| {
                if self.meet(tree, place, ways) {
                    *last = Some(place);
                }
                !ways.are_blocked(&some)
            };
            tree.walk_segment(simd, &self.segment(&around), &mut room.ahead, look_at);
        }
    }

    /// Looks at the sphere at a place of the tree, and says whether it is in any of the ways.
    #[inline(always)]
    fn meet(&self, tree: &Tree, place: usize, ways: &mut Ways) -> bool {
        let index = tree.order[place];
        let sphere = &self.scene.spheres[index as usize];
        let center = (sphere.center - self.prepared.reference).into();
        let met = ways.beams.meet_sphere(center, sphere.radius.abs());
        ways.take(index + 1, &met);
        met.contains(&in_the_way::YES)
    }

    /// A beam in the tree.
    #[inline(always)]
    fn segment(&self, beam: &Beam) -> Segment {
        let from = DVec3::from_array(beam.from.0);
        let origin = from + self.to_tree;
        let rounding = 4.0 * UNIT_F64 * (from.length() + self.to_tree.length());
        let (way, slack) = (DVec3::from_array(beam.way.0), beam.error + rounding);
        Segment { origin, way, is_endless: beam.is_endless, slack }
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
    fn look_in_tree(&self, beam: &Beam, own: u32, mut open: impl FnMut(u32)) -> f64 {
        let Some(hierarchy) = &self.prepared.hierarchy else { return in_the_way::NO };
        let tree = &hierarchy.tree;
        let mut state = in_the_way::NO;
        let look_at = |place: usize| {
            let index = tree.order[place];
            if index + 1 != own {
                let sphere = &self.scene.spheres[index as usize];
                let center = (sphere.center - self.prepared.reference).into();
                let met = beam.meets_sphere(center, sphere.radius.abs());
                if met == in_the_way::OPEN {
                    open(index + 1);
                }
                state = state.max(met);
            }
            state != in_the_way::YES
        };
        tree.visit_segment(&self.segment(beam), look_at);
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
                    if self.look_in_tree(&beam, id, push) == in_the_way::YES {
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

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    /// How far points are from the middle of a pack at most, as a part of what is said.
    fn worst(point: impl Fn(&mut ChaCha8Rng) -> [f64; 3]) -> f64 {
        let mut rng = ChaCha8Rng::seed_from_u64(1423);
        let mut worst: f64 = 0.0;
        for _ in 0..20_000 {
            let mut pack = Pack { error: [0.0; LANES], ..Pack::NONE };
            for lane in 0..LANES {
                let at = point(&mut rng);
                for axis in 0..3 {
                    pack.at[axis][lane] = at[axis];
                }
            }
            let asked = std::array::from_fn(|_| if rng.random_bool(0.5) { 0.5 } else { 0.0 });
            let (middle, reach) = middle(std::iter::once((&pack, &asked)));
            assert_eq!(reach.is_infinite(), asked == [0.0; LANES]);
            for lane in (0..LANES).filter(|&lane| asked[lane] > 0.0) {
                // The points are so near each other that this is exact, or so far apart that it need not be.
                let away = vector(&pack.at, lane) - middle;
                worst = worst.max(dot3(away, away).sqrt() / reach);
            }
        }
        worst
    }

    /// Neither half of what a box reaches nor half of what its middle is rounded by would do.
    #[test]
    fn points_are_about_their_middle() {
        let apart = worst(|rng| std::array::from_fn(|_| rng.random_range(-1.0..1.0)));
        let close = worst(|rng| {
            std::array::from_fn(|_| if rng.random() { 1.0 } else { 1.0 + f64::EPSILON })
        });
        for worst in [apart, close] {
            assert!(worst <= 1.0 && worst > 0.5, "{apart} {close}");
        }
    }

    /// What is not in the way of a beam around points is in the way of none of theirs, and the same of what is
    /// in the way; a beam of half the error says what is wrong.
    #[test]
    fn a_thick_beam_speaks_for_those_in_it() {
        let mut rng = ChaCha8Rng::seed_from_u64(1424);
        let mut vector =
            |size: f64| Vec3(std::array::from_fn(|_| rng.random_range(-1.0..1.0) * size));
        let (mut n_said, mut n_wrong, mut n_wrong_of_half) = (0, 0, 0);
        for round in 0..40_000 {
            let (at, lamp) = (vector(1.0), vector(4.0));
            let size = [0.3, 0.01][round % 2];
            let beam = |from, error| match round % 3 {
                0 => Beam::to_sun(from, error, lamp),
                _ => Beam::to_point(from, error, lamp),
            };
            let mut pack = Pack { error: [1e-6; LANES], ..Pack::NONE };
            for lane in 0..LANES {
                let at = at + vector(size);
                for axis in 0..3 {
                    pack.at[axis][lane] = at.0[axis];
                }
            }
            let (from, error) = middle(std::iter::once((&pack, &[1.0; LANES])));
            // Mostly about as far away as the beam is thick.
            let r = 0.5 + 0.4 * vector(1.0).0[0];
            let center = at + (lamp - at) * (0.5 + vector(0.5).0[0]) + vector(r);
            let said = |error| beam(from, error).meets_sphere(center, r);
            let is_wrong = |said: f64| {
                (0..LANES).any(|lane| {
                    let thin = beam(self::vector(&pack.at, lane), pack.error[lane]);
                    let met = thin.meets_sphere(center, r);
                    said != in_the_way::OPEN && met != in_the_way::OPEN && met != said
                })
            };
            n_said += usize::from(said(error) != in_the_way::OPEN);
            n_wrong += usize::from(is_wrong(said(error)));
            n_wrong_of_half += usize::from(is_wrong(said(error / 2.0)));
        }
        assert_eq!(n_wrong, 0);
        assert!(n_said > 5000 && n_wrong_of_half > 10, "{n_said} {n_wrong_of_half}");
    }
}
