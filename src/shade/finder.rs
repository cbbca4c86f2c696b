//! What is in the way of light: in f64 for some points side by side, and exactly.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use std::cell::OnceCell;
use std::collections::HashSet;

use glam::DVec3;
use pulp::Simd;

use super::beam::{Beam, in_the_way};
use super::bytes::SeenInF32;
use super::lamp::{Lamp, Lighting, Origin};
use crate::certify::{LANES, Pack, PointF64, Stage, Surfaces, registers};
use crate::exact::{ExactBeam, ExactPoint, Shape, is_outside, slope_of};
use crate::guard::UNIT_F64;
use crate::guard::host::{Bounded, HOST_UNIT_F64, input_in_f32, input_in_f64};
use crate::prepare::{Prepared, Scaled};
use crate::rays::{Lens, Rays};
use crate::scene::{Object, Scene};
use crate::seen::{Eye, PlaneSeen, Record, Seen, SphereSeen};
use crate::trace::StageCounts;
use crate::tree::{Ahead, Segment, Tree};
use crate::vec3::{Vec3, dot3};
use crate::wide::{Holds, SideBySide, WideF64};

/// Numbers side by side.
pub type Row = [f64; LANES];

/// Where objects are looked for.
pub struct Finder<'a> {
    pub stage: Stage<'a>,
    pub surfaces: Surfaces<'a>,
    lens: Lens,
    prepared: &'a Prepared,
    scene: &'a Scene,
    /// The objects that are not in the tree, without those that equal an earlier one.
    pub(super) listed: Vec<Listed>,
    /// The spheres of these.
    listed_spheres: Vec<Spheres>,
    /// Where the planes are among them.
    listed_planes: Vec<usize>,
    /// From the reference point to that of the tree.
    pub(super) to_tree: DVec3,
    /// Points of a pack within this distance share a walk through the tree. It is the radius of some
    /// sphere, so that their common beam is about as thick as what it meets.
    together: f64,
    pub(super) lamps: Vec<LampF64>,
    /// The suns among them as the scene has them.
    suns: Vec<Option<DVec3>>,
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

/// Spheres side by side.
struct Spheres {
    center: [Row; 3],
    radius: Row,
    /// Where they are among the listed objects.
    places: Vec<usize>,
}

impl Spheres {
    /// Those of some objects, at most [`LANES`] together.
    fn of(listed: &[Listed]) -> Vec<Spheres> {
        let spheres = listed.iter().enumerate().filter_map(|(place, object)| match object.shape {
            ListedShape::Sphere(radius) => Some((place, object.at, radius)),
            ListedShape::Plane(_) => None,
        });
        let spheres: Vec<(usize, Vec3<f64>, f64)> = spheres.collect();
        let side_by_side = |some: &[(usize, Vec3<f64>, f64)]| {
            let places = some.iter().map(|&(place, ..)| place).collect();
            // What follows the last one is not looked at.
            let mut all = Spheres { center: [[0.0; LANES]; 3], radius: [1.0; LANES], places };
            for (lane, &(_, at, radius)) in some.iter().enumerate() {
                all.radius[lane] = radius;
                for axis in 0..3 {
                    all.center[axis][lane] = at.0[axis];
                }
            }
            all
        };
        spheres.chunks(LANES).map(side_by_side).collect()
    }
}

/// [`Origin`], relative to the reference point.
#[derive(Clone, Copy)]
pub(super) enum LampF64 {
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
    pub(super) listed: Vec<usize>,
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

#[inline(always)]
fn load3<S: Simd>(simd: S, rows: &[Row; 3], first: usize) -> Vec3<WideF64<S>> {
    let [x, y, z] = rows;
    let load = |row: &Row| WideF64::load(simd, &row[first..]);
    Vec3([load(x), load(y), load(z)])
}

/// Beams side by side.
struct Beams {
    from: [Row; 3],
    way: [Row; 3],
    square: Row,
    inverse: Row,
    error: Row,
    end_error: Row,
    bend: Row,
    is_endless: bool,
}

impl Beams {
    #[inline(always)]
    fn new(is_endless: bool) -> Beams {
        let (zero, zero3) = ([0.0; LANES], [[0.0; LANES]; 3]);
        let [square, inverse, error, end_error, bend] = [zero; 5];
        Beams { from: zero3, way: zero3, square, inverse, error, end_error, bend, is_endless }
    }

    #[inline(always)]
    fn set<S: Simd>(&mut self, first: usize, beam: &Beam<WideF64<S>>) {
        for axis in 0..3 {
            beam.from.0[axis].store(&mut self.from[axis][first..]);
            beam.way.0[axis].store(&mut self.way[axis][first..]);
        }
        beam.square.store(&mut self.square[first..]);
        beam.inverse.store(&mut self.inverse[first..]);
        beam.error.store(&mut self.error[first..]);
        beam.end_error.store(&mut self.end_error[first..]);
        beam.bend.store(&mut self.bend[first..]);
    }

    /// Those of a register, but for what cosines are found of.
    #[inline(always)]
    fn get<S: Simd>(&self, simd: S, first: usize) -> Beam<WideF64<S>> {
        Beam {
            from: load3(simd, &self.from, first),
            way: load3(simd, &self.way, first),
            square: WideF64::load(simd, &self.square[first..]),
            inverse: WideF64::load(simd, &self.inverse[first..]),
            inverse_length: WideF64::splat(simd, f64::INFINITY),
            error: WideF64::load(simd, &self.error[first..]),
            end_error: WideF64::load(simd, &self.end_error[first..]),
            bend: WideF64::load(simd, &self.bend[first..]),
            is_endless: self.is_endless,
            turned: WideF64::splat(simd, f64::INFINITY),
            unit: UNIT_F64,
        }
    }

    /// [`Beam::meets_sphere`] of each.
    #[inline(always)]
    fn meet_sphere<S: Simd>(&self, simd: S, center: Vec3<f64>, r: f64) -> Row {
        let mut met = [in_the_way::NO; LANES];
        for first in registers::<S>() {
            let beam = self.get(simd, first);
            let of_each = beam.meets_sphere(beam.square.like3(center), beam.square.like(r));
            of_each.store(&mut met[first..]);
        }
        met
    }

    /// [`Beam::meets_plane`] of each.
    #[inline(always)]
    fn meet_plane<S: Simd>(&self, simd: S, point: Vec3<f64>, normal: Vec3<f64>) -> Row {
        let mut met = [in_the_way::NO; LANES];
        for first in registers::<S>() {
            self.get(simd, first).meets_plane(point, normal).store(&mut met[first..]);
        }
        met
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
    fn take<S: Simd>(&mut self, simd: S, id: u32, mut met: Row) {
        if self.pack.id.contains(&id) {
            for lane in 0..LANES {
                met[lane] = if self.pack.id[lane] == id { in_the_way::NO } else { met[lane] };
            }
        }
        for first in registers::<S>() {
            let state = WideF64::load(simd, &self.state[first..]);
            state.max(WideF64::load(simd, &met[first..])).store(&mut self.state[first..]);
        }
    }

    /// True where something is in all of these ways.
    #[inline(always)]
    fn are_blocked<S: Simd>(&self, simd: S, some: &Row) -> bool {
        let (zero, yes) = (WideF64::splat(simd, 0.0), WideF64::splat(simd, in_the_way::YES));
        registers::<S>().all(|first| {
            let is_asked = zero.lt(WideF64::load(simd, &some[first..]));
            let state = WideF64::load(simd, &self.state[first..]);
            !is_asked.and(state.lt(yes)).any()
        })
    }

    /// What a lamp gives the points along them.
    #[inline(always)]
    fn let_through<S: Simd>(&self, simd: S, given: &mut Given) {
        let (zero, no) = (WideF64::splat(simd, 0.0), WideF64::splat(simd, in_the_way::NO));
        let yes = WideF64::splat(simd, in_the_way::YES);
        for first in registers::<S>() {
            let state = WideF64::load(simd, &self.state[first..]);
            let low = WideF64::load(simd, &given.low[first..]);
            let high = WideF64::load(simd, &given.high[first..]);
            no.lt(state).select(zero, low).store(&mut given.low[first..]);
            state.lt(yes).select(high, zero).store(&mut given.high[first..]);
        }
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
fn middle<'p, S: Simd>(
    simd: S,
    points: impl Iterator<Item = (&'p Pack, &'p Row)>,
) -> (Vec3<f64>, f64) {
    let zero = WideF64::splat(simd, 0.0);
    let mut low = zero.like3(Vec3([f64::INFINITY; 3]));
    let (mut high, mut error) = (-low, zero);
    for (pack, asked) in points {
        for first in registers::<S>() {
            let is_asked = zero.lt(WideF64::load(simd, &asked[first..]));
            for axis in 0..3 {
                let at = WideF64::load(simd, &pack.at[axis][first..]);
                let (low, high) = (&mut low.0[axis], &mut high.0[axis]);
                *low = is_asked.and(at.lt(*low)).select(at, *low);
                *high = is_asked.and(high.lt(at)).select(at, *high);
            }
            let here = WideF64::load(simd, &pack.error[first..]);
            error = is_asked.and(error.lt(here)).select(here, error);
        }
    }
    let (mut lowest, mut highest) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
    for axis in 0..3 {
        lowest[axis] = least(low.0[axis]);
        highest[axis] = -least(-high.0[axis]);
    }
    middle_of(Vec3(lowest), Vec3(highest), -least(-error))
}

/// The same of a box from `low` to `high` and the largest of the points' errors.
#[inline(always)]
pub(super) fn middle_of(low: Vec3<f64>, high: Vec3<f64>, error: f64) -> (Vec3<f64>, f64) {
    let half = (high - low) * 0.5;
    let middle = low + half;
    let reach = 1.01 * dot3(half, half).sqrt() + UNIT_F64 * dot3(middle, middle).sqrt();
    let error = reach + error;
    if error < f64::INFINITY { (middle, error) } else { (Vec3::ZERO, f64::INFINITY) }
}

#[inline(always)]
fn least<S: Simd>(wide: WideF64<S>) -> f64 {
    let mut row = [f64::INFINITY; LANES];
    wide.store(&mut row);
    let mut least = row[0];
    for lane in 1..LANES {
        least = if row[lane] < least { row[lane] } else { least };
    }
    least
}

/// The id of all objects of the packs that a lamp may give something to, where they have one.
#[inline(always)]
fn only_id(packs: &[Pack], given: &[Given; PACKS]) -> Option<u32> {
    let mut only = None;
    for (pack, given) in packs.iter().zip(given) {
        if given.high != [0.0; LANES] {
            let id = *only.get_or_insert(pack.id[0]);
            if pack.id != [id; LANES] {
                return None;
            }
        }
    }
    only
}

#[inline(always)]
fn n_asked<S: Simd>(simd: S, asked: &Row) -> u64 {
    let zero = WideF64::splat(simd, 0.0);
    let mut n = 0;
    for first in registers::<S>() {
        n += zero.lt(WideF64::load(simd, &asked[first..])).bits().count_ones();
    }
    n.into()
}

impl<'a> Finder<'a> {
    /// Whether spheres are looked for in a tree.
    pub fn has_tree(&self) -> bool {
        self.prepared.hierarchy.is_some()
    }

    /// An object as an eye sees it in f32.
    pub fn seen_in_f32(&self, id: u32, eye: &Eye) -> SeenInF32 {
        match self.scene.object(id) {
            None => SeenInF32::Nothing,
            Some(Object::Sphere(sphere)) => {
                let seen = SphereSeen::new::<f32>(sphere, eye);
                SeenInF32::Sphere(seen.round(), seen.is_close())
            }
            Some(Object::Plane(plane)) => {
                SeenInF32::Plane(PlaneSeen::new::<f32>(plane, eye).round())
            }
        }
    }

    /// Number of objects.
    pub fn n_objects(&self) -> u32 {
        self.scene.n_objects() as u32
    }

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
            let is_first = match object {
                Object::Sphere(_) => seen.insert(crate::certify::bits(object)),
                Object::Plane(_) => !stage.plane(id).is_repeated,
            };
            is_first.then(|| Listed { id, at: relative(at), shape })
        });
        let listed: Vec<Listed> = listed.collect();
        let listed_spheres = Spheres::of(&listed);
        let is_plane = |place: &usize| matches!(listed[*place].shape, ListedShape::Plane(_));
        let listed_planes = (0..listed.len()).filter(is_plane).collect();
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
            Origin::Sun(way) => LampF64::Sun(Scaled::new(way).rounded().into()),
        };
        let lamps = lighting.lamps.iter().map(lamp).collect();
        let sun = |lamp: &Lamp| match lamp.origin {
            Origin::Sun(direction) => Some(direction),
            Origin::Eye | Origin::Point(_) => None,
        };
        let suns = lighting.lamps.iter().map(sun).collect();
        Finder {
            surfaces: Surfaces::new(&stage),
            lens: match rays {
                Rays::Pixels(pixels) => pixels.view.lens,
                Rays::List(_) => Lens::Perspective,
            },
            stage,
            prepared,
            scene,
            listed,
            listed_spheres,
            listed_planes,
            to_tree,
            together,
            lamps,
            suns,
        }
    }

    #[inline(always)]
    pub(super) fn beam<R: SideBySide<Plain: Bounded>>(
        &self,
        lamp: LampF64,
        at: Vec3<R>,
        error: R,
        direction: Vec3<R>,
    ) -> Beam<R> {
        match lamp {
            // Against the ray, whose direction is better known than the point.
            LampF64::Eye => Beam::to_eye(at, direction, self.direction_error::<R::Plain>()),
            LampF64::Point(position) => Beam::to_point(at, error, position),
            LampF64::Sun(way) => Beam::to_sun(at, error, way),
        }
    }

    /// Bound of the relative error of a picture's directions in numbers of `F`.
    fn direction_error<F: Bounded>(&self) -> f64 {
        match F::ROUNDED > 0.0 {
            true => F::UNIT * input_in_f32(self.lens).direction,
            false => HOST_UNIT_F64 * input_in_f64(Some(self.lens)).direction,
        }
    }

    /// The beams from the points of a pack in the register that begins with `first`.
    #[inline(always)]
    fn beams<S: Simd>(
        &self,
        simd: S,
        lamp: LampF64,
        pack: &Pack,
        first: usize,
    ) -> Beam<WideF64<S>> {
        let (at, direction) = (load3(simd, &pack.at, first), load3(simd, &pack.direction, first));
        self.beam(lamp, at, WideF64::load(simd, &pack.error[first..]), direction)
    }

    /// [`Beam::cosine`] of each point of a pack that lies on an object.
    #[inline(always)]
    fn cosines<S: Simd>(&self, simd: S, lamp: LampF64, pack: &Pack) -> Given {
        let mut given = Given::NOTHING;
        for first in registers::<S>() {
            let beams = self.beams(simd, lamp, pack, first);
            let normal_error = WideF64::load(simd, &pack.normal_error[first..]);
            let (low, high) = beams.cosine(load3(simd, &pack.normal, first), normal_error);
            let is_object = WideF64::load(simd, &pack.is_object[first..]);
            low.store(&mut given.low[first..]);
            (high * is_object).store(&mut given.high[first..]);
        }
        given
    }

    /// What the lamp with index `index` gives the points of some packs, up to [`PACKS`], the first of which
    /// is in this column of its row.
    #[inline(always)]
    pub fn light<S: Simd>(
        &self,
        simd: S,
        (index, lamp): (usize, &Lamp),
        (column, packs): (usize, &[Pack]),
        room: &mut Room,
        counts: &mut StageCounts,
    ) -> [Given; PACKS] {
        let mut given = [Given::NOTHING; PACKS];
        for (pack, given) in packs.iter().zip(&mut given) {
            *given = self.cosines(simd, self.lamps[index], pack);
        }
        if !lamp.casts_shadows() {
            return given;
        }
        let mut n = 0;
        for given in &given {
            n += n_asked(simd, &given.high);
        }
        if n == 0 {
            return given;
        }
        counts.f64 += n;
        let own = only_id(packs, &given);
        let asked = given.iter().map(|given| &given.high);
        let (from, error) = middle(simd, packs.iter().zip(asked));
        let around = self.beam(self.lamps[index], from, error, Vec3::ZERO);
        if self.look_around(simd, &around, own, room) {
            return [Given::NOTHING; PACKS];
        }
        let looks_in_tree = self.prepared.hierarchy.is_some();
        let mut beams = Beams::new(matches!(lamp.origin, Origin::Sun(_)));
        for (at, pack) in packs.iter().enumerate() {
            let given = &mut given[at];
            let asked = &{ given.high };
            let is_inside = pack.is_inside != [false; LANES];
            let is_free = room.listed.is_empty() && !looks_in_tree && !is_inside;
            if is_free || *asked == [0.0; LANES] {
                continue;
            }
            for first in registers::<S>() {
                // Once more: it takes longer to keep them.
                beams.set(first, &self.beams(simd, self.lamps[index], pack, first));
            }
            let mut ways = Ways { pack, beams: &beams, state: [in_the_way::NO; LANES] };
            for &at in &room.listed {
                let Listed { id, at, ref shape } = self.listed[at];
                let met = match *shape {
                    ListedShape::Sphere(r) => beams.meet_sphere(simd, at, r),
                    ListedShape::Plane(normal) => beams.meet_plane(simd, at, normal),
                };
                ways.take(simd, id, met);
            }
            for lane in (0..LANES).filter(|&lane| is_inside && asked[lane] > 0.0) {
                if pack.is_inside[lane] && self.own_is_in_the_way(lamp, pack.id[lane]) {
                    ways.state[lane] = in_the_way::YES;
                }
            }
            if looks_in_tree {
                self.look_together(simd, index, column + at, asked, &mut ways, room);
            }
            ways.let_through(simd, given);
        }
        given
    }

    /// Lists the listed objects that may be in the way of beams that lie in a thick one; says whether one is in
    /// the way of all. What is not in the way of the thick beam is in the way of none, and what is in its way is
    /// in that of all but those that start on it: `own` is the object where all start, if it is one.
    #[inline(always)]
    pub(super) fn look_around<S: Simd>(
        &self,
        simd: S,
        around: &Beam,
        own: Option<u32>,
        room: &mut Room,
    ) -> bool {
        let mut is_dark = false;
        room.listed.clear();
        let mut take = |place: usize, is_met: bool| {
            if Some(self.listed[place].id) != own {
                is_dark |= is_met && own.is_some();
                room.listed.push(place);
            }
        };
        let like = |number: f64| WideF64::splat(simd, number);
        let beams = around.repeated(like(0.0));
        for spheres in &self.listed_spheres {
            for first in registers::<S>() {
                let center = load3(simd, &spheres.center, first);
                let radius = WideF64::load(simd, &spheres.radius[first..]);
                let met = beams.meets_sphere(center, radius);
                let (mut some, crossed) =
                    (like(in_the_way::NO).lt(met).bits(), like(in_the_way::YES).le(met).bits());
                while some != 0 {
                    let lane = some.trailing_zeros();
                    some &= some - 1;
                    if let Some(&place) = spheres.places.get(first + lane as usize) {
                        take(place, crossed >> lane & 1 != 0);
                    }
                }
            }
        }
        for &place in &self.listed_planes {
            let object = &self.listed[place];
            if let ListedShape::Plane(normal) = object.shape
                && Some(object.id) != own
            {
                let met = around.meets_plane(object.at, normal);
                if met != in_the_way::NO {
                    take(place, met == in_the_way::YES);
                }
            }
        }
        is_dark
    }

    /// Looks among the spheres of the tree for what is in the ways to the lamp with index `index`, whose
    /// number in `asked` is positive.
    #[inline(always)]
    fn look_together<S: Simd>(
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
            self.meet(simd, tree, place, ways);
        }
        let mut asked = *asked;
        while let Some(first) =
            (0..LANES).find(|&lane| (asked[lane] > 0.0) & (ways.state[lane] != in_the_way::YES))
        {
            let (pack, mut some) = (ways.pack, [0.0; LANES]);
            let nearest = vector(&pack.at, first);
            for first in registers::<S>() {
                let at = load3(simd, &pack.at, first);
                let numbers = WideF64::load(simd, &asked[first..]);
                let like = |number: f64| numbers.like(number);
                let apart = at - numbers.like3(nearest);
                let is_near = dot3(apart, apart).le(like(self.together * self.together));
                let state = WideF64::load(simd, &ways.state[first..]);
                let is_open = state.lt(like(in_the_way::YES));
                is_near.and(is_open).select(numbers, like(0.0)).store(&mut some[first..]);
            }
            // Also where it is no number.
            some[first] = asked[first];
            for first in registers::<S>() {
                let is_taken = WideF64::splat(simd, 0.0).lt(WideF64::load(simd, &some[first..]));
                let numbers = WideF64::load(simd, &asked[first..]);
                is_taken.select(numbers.like(0.0), numbers).store(&mut asked[first..]);
            }
            let (from, error) = middle(simd, std::iter::once((pack, &some)));
            let around = self.beam(self.lamps[index], from, error, Vec3::ZERO);
            let last = &mut room.last[slot];
            let look_at = |place: usize| {
                if self.meet(simd, tree, place, ways) {
                    *last = Some(place);
                }
                !ways.are_blocked(simd, &some)
            };
            tree.walk_segment(simd, &self.segment(tree, &around), &mut room.ahead, look_at);
        }
    }

    /// Looks at the sphere at a place of the tree, and says whether it is in any of the ways.
    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, tree: &Tree, place: usize, ways: &mut Ways) -> bool {
        let index = tree.order[place];
        let sphere = &self.scene.spheres[index as usize];
        let center = (sphere.center - self.prepared.reference).into();
        let met = ways.beams.meet_sphere(simd, center, sphere.radius.abs());
        ways.take(simd, index + 1, met);
        met.contains(&in_the_way::YES)
    }

    /// A beam in the tree, all of whose spheres lie within a distance from the beam's start.
    #[inline(always)]
    fn segment(&self, tree: &Tree, beam: &Beam) -> Segment {
        let from = DVec3::from_array(beam.from.0);
        let origin = from + self.to_tree;
        let rounding = 4.0 * UNIT_F64 * (from.length() + self.to_tree.length());
        let farthest = 1.01 * (origin.length() + 1.74 * tree.largest_coordinate());
        let error = beam.error + beam.end_error.min(beam.bend * farthest);
        let (way, slack) = (DVec3::from_array(beam.way.0), error + rounding);
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
        tree.visit_segment(&self.segment(tree, beam), look_at);
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

    /// Whether the light of the lamp with index `index` reaches a point that faces it: in f64, and exactly where that does not
    /// tell.
    pub fn is_seen(
        &self,
        (index, lamp): (usize, &Lamp),
        sample: &SamplePoint,
        counts: &mut StageCounts,
    ) -> bool {
        if !lamp.casts_shadows() {
            return true;
        }
        let (state, open) = self.look((index, lamp), sample);
        if state != in_the_way::OPEN {
            return state == in_the_way::NO;
        }
        counts.exact += 1;
        counts.f64 = counts.f64.saturating_sub(1);
        let Some((point, _)) = sample.exactly(self) else { return true };
        let Some(beam) = self.exact_beam(lamp, point) else { return true };
        !open.into_iter().any(|id| {
            self.scene.object(id).is_some_and(|object| beam.is_blocked_by(&object.into()))
        })
    }

    /// Whether an object is a plane.
    pub fn is_plane(&self, id: u32) -> bool {
        id as usize > self.scene.spheres.len()
    }

    /// Whether a point of a plane is seen from the side that its normal points to.
    pub fn faces_front(&self, id: u32, point: &PointF64) -> bool {
        dot3(point.normal, self.stage.plane(id).normal) > 0.0
    }

    /// Whether the sun with index `index` shines on that side of a plane, or on the other one: the same for all of it.
    pub fn lights_plane(&self, index: usize, id: u32, faces_front: bool) -> bool {
        let (LampF64::Sun(way), Some(Object::Plane(plane))) =
            (self.lamps[index], self.scene.object(id))
        else {
            return false;
        };
        let normal = self.stage.plane(id).normal;
        let slope = -dot3(normal, way);
        // The vectors' lengths are below 4, their product's rounding is 3 units.
        let is_known = slope.abs() > 64.0 * UNIT_F64;
        let sign = match (is_known, self.suns[index]) {
            (false, Some(direction)) => -slope_of(plane.normal, direction),
            _ if slope > 0.0 => 1,
            _ => -1,
        };
        sign == if faces_front { 1 } else { -1 }
    }

    /// What f64 knows of what is in the way to a lamp from a point that faces it, and the ids of what may be.
    fn look(&self, (index, lamp): (usize, &Lamp), sample: &SamplePoint) -> (f64, Vec<u32>) {
        let (own, n_spheres) = (sample.id, self.scene.spheres.len() as u32);
        let mut open: Vec<u32> = Vec::new();
        let Some((point, is_inside)) = &sample.in_f64 else {
            open.extend(self.listed.iter().map(|listed| listed.id));
            open.extend(1..=if self.has_tree() { n_spheres } else { 0 });
            open.push(own);
            return (in_the_way::OPEN, open);
        };
        if *is_inside && self.own_is_in_the_way(lamp, own) {
            return (in_the_way::YES, open);
        }
        let beam: Beam = self.beam(self.lamps[index], point.at, point.error, Vec3::ZERO);
        let mut state = in_the_way::NO;
        for &Listed { id, at, ref shape } in self.listed.iter().filter(|listed| listed.id != own) {
            let met = match *shape {
                ListedShape::Sphere(r) => beam.meets_sphere(at, r),
                ListedShape::Plane(normal) => beam.meets_plane(at, normal),
            };
            if met == in_the_way::YES {
                return (met, open);
            }
            if met == in_the_way::OPEN {
                open.push(id);
            }
            state = state.max(met);
        }
        state = state.max(self.look_in_tree(&beam, own, |id| open.push(id)));
        (state, open)
    }
}

/// The point that a sample sees, as well as it is known so far.
pub struct SamplePoint {
    /// Index of its ray.
    pub at: usize,
    /// The object's id.
    pub id: u32,
    /// In f64, and whether it is on a sphere around the ray's origin; `None` where nothing is known.
    pub in_f64: Option<(PointF64, bool)>,
    exact: OnceCell<Option<(ExactPoint, Shape)>>,
}

impl SamplePoint {
    /// Of a ray that sees this object.
    pub fn new(finder: &Finder, at: usize, id: u32) -> SamplePoint {
        let in_f64 = finder.surfaces.point(at, id);
        SamplePoint { at, id, in_f64, exact: OnceCell::new() }
    }

    /// The point exactly, found when it is first asked for, and the shape of its object.
    pub fn exactly(&self, finder: &Finder) -> Option<&(ExactPoint, Shape)> {
        self.exact.get_or_init(|| finder.stage.exact_point(self.at, self.id)).as_ref()
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
            let (middle, reach) = middle(pulp::Scalar, std::iter::once((&pack, &asked)));
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
            let (from, error) = middle(pulp::Scalar, std::iter::once((&pack, &[1.0; LANES])));
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
