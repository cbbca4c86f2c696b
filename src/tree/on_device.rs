//! The boxes of the tree as a device sees them, which looks there for what is in the way of light.

use bytemuck::{Pod, Zeroable};

use super::{IS_LEAF, Node, Tree};
use crate::guard::LARGEST_F32;

/// A box, in the order of the tree's nodes. Twin of `Box` in `shaders/lit.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct BoxOnDevice {
    /// Lower corner, relative to the tree's reference point.
    pub low: [f32; 3],
    /// Upper corner.
    pub high: [f32; 3],
    /// A leaf: [`IS_LEAF`] and the index of its sphere. Else the node that follows the subtree.
    pub link: u32,
}

/// Relative room of a slab.
const WIDER: f32 = 1.0 + 4.0 * f32::EPSILON;
const NARROWER: f32 = 1.0 - 4.0 * f32::EPSILON;

/// Room of an origin, relative to its largest component.
const SLACK: f32 = 4.0 / (1 << 24) as f32;

/// The least of it.
const LEAST_SLACK: f32 = 1.0 / (1u128 << 100) as f32;

/// For the roundings of the slack.
const BESIDE: f64 = 1.001;

/// Constants in f64 of the walk in `shaders/lit.wgsl`, by their names there.
///
/// No origin lies farther away than spheres do, and so every box is nearer than four times that, in the
/// largest component: `BEHIND_ALL` is behind them all. Where the direction's component is below `FLAT`, a
/// slab is not looked at, so that a product of a difference below `2⁶³` and an inverse stays finite.
pub const SEGMENT_CONSTANTS: [(&str, f64); 4] = [
    ("REACH", LARGEST_F32),
    ("BEHIND_ALL", 16.0 * LARGEST_F32),
    ("FLAT", 1.0 / LARGEST_F32),
    ("BESIDE", BESIDE),
];

/// The same in f32, for slabs as [`super::wide`] has them. A device rounds to f32 to nearest, which is measured, and each
/// sum, difference and product to either side, by `2u` at most. So an origin is off by `3u` of the `4u` that the slack
/// has, and a slab by `7u` (difference, inverse, its widening, product) of the `8u` that it is widened by.
/// What is flushed to 0 is far below the least slack.
pub const SLAB_CONSTANTS: [(&str, f32); 4] = [
    ("SLACK", SLACK),
    ("LEAST_SLACK", LEAST_SLACK),
    ("SLAB_NARROWER", NARROWER),
    ("SLAB_WIDER", WIDER),
];

impl Tree {
    /// The boxes.
    pub(crate) fn boxes_on_device(&self) -> Vec<BoxOnDevice> {
        let of_node = |&Node { low, high, link }: &Node| BoxOnDevice {
            low,
            high,
            link: match link & IS_LEAF {
                0 => link,
                _ => IS_LEAF | self.order[(link & !IS_LEAF) as usize],
            },
        };
        self.nodes.iter().map(of_node).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::guard::{round_down, round_up};
    use crate::random::SplitMix;

    /// A result of a device's f32, for which it has two choices.
    fn faithful(exact: f64, up: bool) -> f32 {
        if up { round_up(exact) } else { round_down(exact) }
    }

    /// How many slabs are entered later, left sooner, or begin beyond the origin, whichever way each operation
    /// rounds, when a slab is widened by `wider` and an origin has this slack.
    fn n_wrong(wider: f64, slack: f32) -> usize {
        let mut random = SplitMix::new(1425);
        let mut number = move || {
            let u = random.unit();
            let mantissa =
                1.0 + if u < 0.3 { (u * 50.0).floor() / 16777216.0 } else { random.unit() };
            let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
            sign * mantissa * 2f64.powi((6.0 * random.unit()) as i32 - 3)
        };
        let mut n = 0;
        for round in 0..200_000_u32 {
            let (origin, inverse) = (number(), number().abs());
            let choice = |bit: u32| round >> bit & 1 == 1;
            // The origin, rounded to nearest, and moved by the slack to either side.
            let far = origin.abs() as f32;
            let room = f64::from(far * slack);
            let here = f64::from(origin as f32);
            let near_origin = faithful(here + room, choice(0));
            let far_origin = faithful(here - room, choice(1));
            n += usize::from(f64::from(near_origin) < origin || f64::from(far_origin) > origin);
            // A side of a box, its true s and the one that bounds it.
            let side = number() as f32;
            let exact = (f64::from(side) - f64::from(near_origin)) * inverse;
            let difference = faithful(f64::from(side) - f64::from(near_origin), choice(2));
            let rounded = f64::from(inverse as f32);
            let narrow = faithful(rounded * f64::from((1.0 - wider) as f32), choice(3));
            let wide = faithful(rounded * f64::from((1.0 + wider) as f32), choice(3));
            let near = faithful(f64::from(difference) * f64::from(narrow), choice(4));
            let far = faithful(f64::from(difference) * f64::from(wide), choice(4));
            let is_ahead = exact > 0.0;
            n += usize::from(is_ahead && (f64::from(near) > exact || f64::from(far) < exact));
        }
        n
    }

    /// Half of what slabs are widened by would not do for a device, and not a quarter of the slack: half of it
    /// is a whole last place of the origin's, in which sums are rounded.
    #[test]
    fn slabs_hold_in_a_devices_rounding() {
        let wider = f64::from(WIDER) - 1.0;
        assert_eq!(n_wrong(wider, SLACK), 0);
        assert!(n_wrong(wider / 2.0, SLACK) > 0);
        assert!(n_wrong(wider, SLACK / 4.0) > 0);
    }
}
