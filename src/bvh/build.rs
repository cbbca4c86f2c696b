//! Building the tree: spheres are halved along the widest axis, into as many parts as full nodes would need, down to nodes
//! that are nearly full. The number of nodes and their depth follow from that of spheres alone.

use std::ops::Range;

use bytemuck::Zeroable;
use glam::DVec3;

use super::sides::{self, NOTHING, Sides};
use super::{Node, WIDTH};
use crate::error::Result;
use crate::scene::Sphere;
use crate::support::control::Control;
use crate::support::parallel;

/// A sphere that is put into the tree: the middle of its box, and which member it is.
#[derive(Clone, Copy, Zeroable)]
struct Item {
    middle: [f32; 3],
    member: u32,
}

/// Fewer items are shared by one thread.
const ALONE: usize = 1 << 12;

/// The nodes, the box around all, and the index of the sphere at each place, of the `members` among the spheres.
///
/// # Errors
/// [`crate::Error::Interrupted`]
pub(super) fn build(
    spheres: &[Sphere],
    reference: DVec3,
    members: &[u32],
    control: &Control,
) -> Result<(Vec<Node>, Sides, Vec<u32>)> {
    if members.is_empty() {
        return Ok((Vec::new(), NOTHING, Vec::new()));
    }
    let boxes: Vec<Sides> = parallel::table(members.len(), |member| {
        let Sphere { center, radius } = spheres[members[member] as usize];
        sides::of_sphere(center - reference, radius)
    });
    control.check()?;
    let mut items = parallel::table(members.len(), |member| {
        let [low, high] = boxes[member];
        let middle = std::array::from_fn(|k| 0.5 * low[k] + 0.5 * high[k]);
        Item { middle, member: member as u32 }
    });
    let mut nodes = vec![Node::EMPTY; n_nodes(items.len())];
    let builder = Builder { boxes: &boxes, control };
    let around = builder.grow(&mut items, 0, &mut nodes, 0)?;
    let order = parallel::table(items.len(), |place| members[items[place].member as usize]);
    Ok((nodes, around, order))
}

/// How `n` items are shared among the boxes of a node: as many parts as full nodes would need, of sizes that
/// differ by one at most.
#[derive(Clone, Copy)]
struct Shares {
    n: usize,
    parts: usize,
}

impl Shares {
    fn new(n: usize) -> Shares {
        let mut full = WIDTH;
        while full * WIDTH < n {
            full *= WIDTH;
        }
        Shares { n, parts: n.div_ceil(full) }
    }

    /// The items before a part.
    fn before(&self, part: usize) -> usize {
        part * (self.n / self.parts) + part.min(self.n % self.parts)
    }

    fn len(&self, part: usize) -> usize {
        self.before(part + 1) - self.before(part)
    }
}

/// The nodes of a tree over `n` spheres.
fn n_nodes(n: usize) -> usize {
    if n <= WIDTH {
        return 1;
    }
    let shares = Shares::new(n);
    let n_large = n % shares.parts;
    let small = n_nodes(n / shares.parts) * (shares.parts - n_large);
    1 + small + if n_large > 0 { n_nodes(n / shares.parts + 1) * n_large } else { 0 }
}

/// Puts the items of these parts into order, by halves along the widest axis.
fn share(items: &mut [Item], shares: Shares, parts: Range<usize>) {
    if parts.len() < 2 {
        return;
    }
    let (mut low, mut high) = ([f32::MAX; 3], [f32::MIN; 3]);
    for item in &*items {
        for axis in 0..3 {
            low[axis] = low[axis].min(item.middle[axis]);
            high[axis] = high[axis].max(item.middle[axis]);
        }
    }
    let width = |&axis: &usize| high[axis] - low[axis];
    let axis = (0..3).max_by(|a, b| width(a).total_cmp(&width(b))).unwrap_or(0);
    let middle = parts.start + parts.len() / 2;
    let at = shares.before(middle) - shares.before(parts.start);
    items.select_nth_unstable_by(at, |a, b| a.middle[axis].total_cmp(&b.middle[axis]));
    let (left, right) = items.split_at_mut(at);
    let halves = [(left, parts.start..middle), (right, middle..parts.end)];
    let half = |(items, parts): (&mut [Item], Range<usize>)| share(items, shares, parts);
    match at > ALONE {
        true => _ = parallel::map(halves, half),
        false => halves.into_iter().for_each(half),
    }
}

struct Builder<'a> {
    boxes: &'a [Sides],
    control: &'a Control,
}

/// What a subtree is made of: its items, the place of the first one, its nodes, and the number of the first one.
type BuildPart<'a> = (&'a mut [Item], usize, &'a mut [Node], usize);

impl Builder<'_> {
    /// Makes the nodes over some items, the first of which has this place; the first node has this number. Gives the
    /// box around all.
    fn grow(
        &self,
        items: &mut [Item],
        first_place: usize,
        nodes: &mut [Node],
        number: usize,
    ) -> Result<Sides> {
        let (root, mut below) = nodes.split_at_mut(1);
        let mut around = NOTHING;
        let mut add = |sides: Sides, link: usize, is_node: bool| {
            around = sides::union(around, sides);
            root[0].push(sides, link as u32, is_node);
        };
        if items.len() <= WIDTH {
            for (k, item) in items.iter().enumerate() {
                add(self.boxes[item.member as usize], first_place + k, false);
            }
            return Ok(around);
        }
        if items.len() > ALONE {
            self.control.check()?;
        }
        let shares = Shares::new(items.len());
        share(items, shares, 0..shares.parts);
        let (mut rest, mut at) = (items, number + 1);
        let mut parts: Vec<BuildPart> = Vec::with_capacity(shares.parts);
        for part in 0..shares.parts {
            let n = shares.len(part);
            let (items, others) = rest.split_at_mut(n);
            let (nodes, left) = below.split_at_mut(n_nodes(n));
            let n_here = nodes.len();
            parts.push((items, first_place + shares.before(part), nodes, at));
            at += n_here;
            (rest, below) = (others, left);
        }
        let make =
            |(items, first, nodes, at): BuildPart| Ok((self.grow(items, first, nodes, at)?, at));
        let made: Vec<(Sides, usize)> = match shares.n > ALONE / 4 {
            true => parallel::try_map(parts, make)?,
            false => parts.into_iter().map(make).collect::<Result<_>>()?,
        };
        for (sides, at) in made {
            add(sides, at, true);
        }
        Ok(around)
    }
}
