//! The order of samples: of pixels, or by what they see, where a tree is walked for each object.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use super::Shade;
use crate::certify::Pack;
use crate::num::{Float, Lanes};

/// How samples are put side by side that see one object.
#[derive(Default)]
pub struct SampleOrder<F: Float, const N: usize> {
    /// Offsets in the order of pixels.
    before: Vec<[Lanes<F, N>; 2]>,
    /// Ids, and below each the lane in the order of pixels.
    from: Vec<u64>,
    /// Where each lane of the order of pixels went; nothing where all are in that order.
    to: Vec<u32>,
    /// Shades by what samples see.
    shades: Vec<Shade<F, N>>,
}

impl<F: Float, const N: usize> SampleOrder<F, N> {
    /// Puts samples side by side that see one object.
    #[inline(always)]
    pub fn sort(&mut self, packs: &mut [Pack<F, N>], n_spheres: u32) {
        let SampleOrder { before, from, to, .. } = self;
        to.clear();
        let first = packs[0].ids[0];
        if packs.iter().all(|pack| pack.is_uniform() && pack.ids[0] == first) {
            return;
        }
        before.clear();
        from.clear();
        for (number, pack) in packs.iter().enumerate() {
            before.push(pack.offset);
            for lane in 0..N {
                from.push(u64::from(pack.ids[lane]) << 32 | (number * N + lane) as u64);
            }
        }
        from.sort_unstable();
        to.resize(from.len(), 0);
        for (number, (pack, from)) in packs.iter_mut().zip(from.chunks_exact(N)).enumerate() {
            let mut seen = [0; N];
            for lane in 0..N {
                let at = from[lane] as u32 as usize;
                seen[lane] = (from[lane] >> 32) as u32;
                for axis in 0..2 {
                    pack.offset[axis].0[lane] = before[at / N][axis].0[at % N];
                }
                to[at] = (number * N + lane) as u32;
            }
            pack.see(&seen, n_spheres);
        }
    }

    /// The pack and the lane where a lane of the order of pixels is.
    pub fn place(&self, at: usize) -> (usize, usize) {
        let at = self.to.get(at).map_or(at, |&to| to as usize);
        (at / N, at % N)
    }

    /// Puts shades into the order of pixels again.
    pub fn restore(&mut self, shades: &mut Vec<Shade<F, N>>) {
        if self.to.is_empty() {
            return;
        }
        std::mem::swap(shades, &mut self.shades);
        shades.resize(self.shades.len(), Shade::default());
        for at in 0..self.to.len() {
            let (pack, lane) = self.place(at);
            shades[at / N].set_lane(at % N, &self.shades[pack], lane);
        }
    }
}
