//! The order of samples: of pixels, or by what they see, where a tree is walked for each object.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use super::Shade;
use crate::num::{Float, Lanes};
use crate::surface::Pack;

/// How samples are put side by side that see one object.
#[derive(Default)]
pub struct SampleOrder<F: Float, const N: usize> {
    /// Offsets in the order of pixels.
    before: Vec<[Lanes<F, N>; 2]>,
    /// Neighbours that see one object: its id, and below it the first lane in the order of pixels.
    runs: Vec<u64>,
    /// Where each lane of the order of pixels went; nothing where all are in that order.
    to: Vec<u32>,
    /// Shades by what samples see.
    shades: Vec<Shade<F, N>>,
}

impl<F: Float, const N: usize> SampleOrder<F, N> {
    /// Puts samples side by side that see one object.
    #[inline(always)]
    pub fn sort(&mut self, packs: &mut [Pack<F, N>]) {
        let SampleOrder { before, runs, to, .. } = self;
        to.clear();
        let first = packs[0].ids[0];
        if packs.iter().all(|pack| pack.one() == Some(first)) {
            return;
        }
        before.clear();
        runs.clear();
        to.resize(N * packs.len(), 0);
        let mut last = None;
        for (number, pack) in packs.iter().enumerate() {
            before.push(pack.offset);
            for lane in 0..N {
                let (id, at) = (pack.ids[lane], number * N + lane);
                if last != Some(id) {
                    runs.push(u64::from(id) << 32 | at as u64);
                    last = Some(id);
                }
                // Of a run so far, where it ends.
                to[runs[runs.len() - 1] as u32 as usize] = at as u32 + 1;
            }
        }
        runs.sort_unstable();
        let (mut seen, mut place) = ([0; N], 0);
        for run in &*runs {
            let start = *run as u32 as usize;
            for at in start..to[start] as usize {
                let (number, lane) = (place / N, place % N);
                seen[lane] = (run >> 32) as u32;
                for axis in 0..2 {
                    packs[number].offset[axis].0[lane] = before[at / N][axis].0[at % N];
                }
                to[at] = place as u32;
                place += 1;
                if lane == N - 1 {
                    packs[number].see(&seen);
                }
            }
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
