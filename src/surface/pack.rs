//! Rays side by side that see objects.

#![allow(clippy::needless_range_loop, reason = "the lanes of several arrays go side by side")]

use crate::num::{Bits, Float, LaneBits, Lanes, Real, V3};
use crate::shape::Surface;

/// Rays that go side by side in f64.
pub const LANES: usize = 8;

/// Rays side by side, and where they meet their objects.
pub struct Pack<F: Float, const N: usize> {
    /// The objects' ids; 0 for none.
    pub ids: [u32; N],
    /// Twice the offset of pixels from the picture's centre, to the right and to the top.
    pub offset: [Lanes<F, N>; 2],
    /// The origins of a list's rays from the eye's reference point, their directions, and what their `t` is multiplied with.
    pub(super) reference: V3<Lanes<F, N>>,
    pub(super) direction: V3<Lanes<F, N>>,
    pub(super) scale: Lanes<F, N>,
    is_uniform: bool,
    /// What is found.
    pub surface: Surface<Lanes<F, N>>,
}

/// Rays that go side by side in f64, and where they meet their objects.
pub type PackF64 = Pack<f64, LANES>;

impl<F: Float, const N: usize> Default for Pack<F, N> {
    fn default() -> Pack<F, N> {
        let zero = Lanes::lit(0.0);
        Pack {
            ids: [0; N],
            offset: [zero; 2],
            reference: V3([zero; 3]),
            direction: V3([zero; 3]),
            scale: Lanes::lit(1.0),
            is_uniform: true,
            surface: Surface::unknown(),
        }
    }
}

impl<F: Float, const N: usize> Pack<F, N> {
    /// The object that all lanes see, or 0 for nothing, where they see the same.
    #[inline(always)]
    pub fn one(&self) -> Option<u32> {
        self.is_uniform.then_some(self.ids[0])
    }

    /// Whether some lane sees an object.
    #[inline(always)]
    pub fn sees(&self, id: u32) -> bool {
        if self.is_uniform { self.ids[0] == id } else { self.ids.contains(&id) }
    }

    /// Takes what its rays see, the last one in all lanes behind it.
    #[inline(always)]
    pub fn see(&mut self, ids: &[u32]) {
        let mut all = [ids[ids.len() - 1]; N];
        match <&[u32; N]>::try_from(ids) {
            Ok(ids) => all = *ids,
            Err(_) => all[..ids.len()].copy_from_slice(ids),
        }
        let differ = all.iter().fold(0, |differ, id| differ | (id ^ all[0]));
        (self.ids, self.is_uniform) = (all, differ == 0);
    }
}

/// Where each lane's id is this one.
#[inline(always)]
pub fn is_id<F: Float, const N: usize>(ids: &[u32; N], id: u32) -> LaneBits<F, N> {
    let mut here = LaneBits([F::Bits::default(); N]);
    for lane in 0..N {
        here.0[lane] = F::Bits::from_bool(ids[lane] == id);
    }
    here
}

/// The first lanes into a slice; all of them without a call.
#[inline(always)]
pub(super) fn put<T: Copy>(lanes: &[T; LANES], to: &mut [T]) {
    match <&mut [T; LANES]>::try_from(&mut *to) {
        Ok(to) => *to = *lanes,
        Err(_) => to.copy_from_slice(&lanes[..to.len()]),
    }
}
