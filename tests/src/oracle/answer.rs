//! What the oracle of light and colour answers: bytes and floats of an enclosure.

use std::sync::OnceLock;

use super::enclosure::Big;
use super::scene::linear;

/// One number of a pixel, and whether the exact one lies on an edge of its range as far as
/// [`TIE_BITS`](super::TIE_BITS) tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer<T> {
    pub value: T,
    pub is_tie: bool,
}

/// One colour channel of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Channel {
    /// The exact mean lies from the first to just above the second (`f64::next_up`).
    pub mean: [f64; 2],
    pub srgb8: Answer<u8>,
    pub srgb16: Answer<u16>,
    pub linear: Answer<f32>,
}

/// A pixel by the contract.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// What the centre ray sees.
    pub id: u32,
    /// Samples that hit something.
    pub n_hits: u32,
    pub channels: [Channel; 3],
    /// Bits that it took.
    pub bits: u64,
}

impl Truth {
    pub fn srgb8(&self) -> [u8; 3] {
        self.channels.map(|channel| channel.srgb8.value)
    }

    pub fn srgb16(&self) -> [u16; 3] {
        self.channels.map(|channel| channel.srgb16.value)
    }

    pub fn linear(&self) -> [f32; 3] {
        self.channels.map(|channel| channel.linear.value)
    }
}

/// The ends of the bytes' ranges: the least linear value of byte `i + 1`, for 8 or 16 bits.
pub fn edges(largest: u16) -> &'static [f64] {
    static EDGES: [OnceLock<Vec<f64>>; 2] = [OnceLock::new(), OnceLock::new()];
    EDGES[usize::from(largest > 255)].get_or_init(|| {
        let largest_f64 = f64::from(largest);
        (1..=largest).map(|b| linear((f64::from(b) - 0.5) / largest_f64)).collect()
    })
}

/// The byte whose range holds both ends, or at the last level the one whose lower edge they touch.
fn byte(ends: [f64; 2], largest: u16, is_last: bool) -> Option<Answer<u16>> {
    let [low, high] = ends.map(|end| edges(largest).partition_point(|edge| *edge <= end) as u16);
    (low == high || is_last).then_some(Answer { value: high, is_tie: low != high })
}

impl Channel {
    /// None where the enclosure touches an edge and this is not the last level.
    pub fn new(mean: &Big, is_last: bool) -> Option<Channel> {
        // An edge is an f64: it is above a number if and only if it is above the f64 below.
        let floors = mean.floors();
        let srgb8 = byte(floors, 255, is_last)?;
        let [low, high] = mean.nearest_f32();
        let is_tie = low.to_bits() != high.to_bits();
        if is_tie && !is_last {
            return None;
        }
        // Of neighbours, the one with an even last place.
        let linear = if high.to_bits() % 2 == 0 { high } else { low };
        Some(Channel {
            mean: floors,
            srgb8: Answer { value: srgb8.value as u8, is_tie: srgb8.is_tie },
            srgb16: byte(floors, 65535, is_last)?,
            linear: Answer { value: linear, is_tie },
        })
    }
}
