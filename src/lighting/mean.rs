//! The exact colour of a pixel: the mean of its samples, as a sum that is enclosed as narrowly as a
//! question asks for.

use std::cell::{Ref, RefCell};
use std::cmp::Ordering;

use glam::DVec3;

use super::quantized::{QuantizedPixels, exact_pixel};
use crate::exact::{
    Dyadic, Enclosure, ExactBeam, ExactCosine, ExactPoint, QuadraticSurd, Rational, exact, integer,
};
use crate::prepare::{Lighting, PreparedLight};

/// Bits of the first enclosure.
const FEWEST_BITS: usize = 64;

/// Bits of the last one: what it doesn't tell apart counts as equal.
const MOST_BITS: usize = 4096;

/// A mean of colours, each an exact part and cosines times weights.
///
/// Where all cosines are seen to be rational ([`ExactCosine::fraction`]), so is the mean, and its order to another number is found
/// at once, equality too. Else bounds are narrowed until they tell.
#[derive(Debug)]
pub struct ExactMean<'a> {
    lighting: Option<&'a Lighting>,
    /// All sums are multiplied by it, so that they are dyadic.
    n_shares: Dyadic,
    divisor: Dyadic,
    /// The sum of what is rational.
    known: [Rational; 3],
    /// The other cosines, with their weights.
    terms: Vec<(ExactCosine<'a>, [Dyadic; 3])>,
    /// The sums enclosed so far, with their bits, ever narrower.
    enclosed: RefCell<Vec<[Enclosure; 3]>>,
}

impl<'a> ExactMean<'a> {
    /// The mean of `n_samples` samples, none of which is added yet, in this light.
    pub fn new(n_samples: u64, lighting: Option<&'a Lighting>) -> ExactMean<'a> {
        let n_shares = integer(lighting.map_or(1, |lighting| lighting.n_shares).into());
        ExactMean {
            lighting,
            divisor: integer(n_samples as i64) * &n_shares,
            n_shares,
            known: std::array::from_fn(|_| Rational::zero()),
            terms: Vec::new(),
            enclosed: RefCell::default(),
        }
    }

    /// Adds a sample that sees something of this colour: the light on it, where there are lamps and `at` is the point that is
    /// seen and the eye; else the colour itself. `is_seen` says whether the light of a lamp, given with
    /// its index, comes to the point.
    pub fn add_sample(
        &mut self,
        color: [f64; 3],
        at: Option<(&'a ExactPoint<'a>, DVec3)>,
        mut is_seen: impl FnMut((usize, &PreparedLight), &ExactBeam) -> bool,
    ) {
        let (color, lit) = (color.map(exact), self.lighting.zip(at));
        let ambient = lit.map_or([1.0; 3], |(lighting, _)| lighting.ambient);
        for (channel, part) in color.iter().enumerate() {
            let part = exact(ambient[channel]) * &self.n_shares * part;
            self.known[channel] = self.known[channel].plus(&(&part).into());
        }
        let Some((lighting, (point, eye))) = lit else { return };
        for (index, lamp) in lighting.lamps.iter().enumerate() {
            if let Some(beam) = lamp.beam(point, eye)
                && let Some(cosine) = beam.cosine()
                && is_seen((index, lamp), &beam)
            {
                let weights =
                    std::array::from_fn(|channel| &lamp.exact_weight[channel] * &color[channel]);
                self.add_light(cosine, weights);
            }
        }
    }

    /// Adds a cosine times its weights, which are at least 0.
    fn add_light(&mut self, cosine: ExactCosine<'a>, weights: [Dyadic; 3]) {
        match cosine.fraction() {
            Some(cosine) => {
                for (known, weight) in self.known.iter_mut().zip(&weights) {
                    *known = known.plus(&cosine.times(weight));
                }
            }
            None => self.terms.push((cosine, weights)),
        }
    }

    /// The order of a channel and `x`, which is at least 0: equal also where [`MOST_BITS`] bits don't
    /// tell them apart.
    pub(super) fn compare(&self, channel: usize, x: &Dyadic) -> Ordering {
        let x = x * &self.divisor;
        if self.terms.is_empty() {
            return self.known[channel].cmp_real(&x);
        }
        for doublings in (0..).take_while(|doublings| FEWEST_BITS << doublings <= MOST_BITS) {
            let Enclosure { low, high } = &self.sums(doublings)[channel];
            if *low > x {
                return Ordering::Greater;
            }
            if *high < x {
                return Ordering::Less;
            }
        }
        Ordering::Equal
    }

    /// The sums within bounds of [`FEWEST_BITS`], doubled so often.
    fn sums(&self, doublings: usize) -> Ref<'_, [Enclosure; 3]> {
        if self.enclosed.borrow().len() == doublings {
            let sums = self.enclose(FEWEST_BITS << doublings);
            self.enclosed.borrow_mut().push(sums);
        }
        Ref::map(self.enclosed.borrow(), |enclosed| &enclosed[doublings])
    }

    fn enclose(&self, n_bits: usize) -> [Enclosure; 3] {
        let mut sums = std::array::from_fn(|channel| self.known[channel].enclose(n_bits));
        for (cosine, weights) in &self.terms {
            let cosine = cosine.enclose(n_bits);
            for (sum, weight) in sums.iter_mut().zip(weights) {
                let term = cosine.times(&Enclosure::of(weight), n_bits);
                *sum = sum.plus(&term);
            }
        }
        sums
    }

    /// Bounds of a channel, computed with `n_bits` bits.
    pub fn enclosed(&self, channel: usize, n_bits: usize) -> Enclosure {
        self.mean_of(&self.enclose(n_bits)[channel], n_bits)
    }

    fn mean_of(&self, sum: &Enclosure, n_bits: usize) -> Enclosure {
        sum.over(&Enclosure::of(&self.divisor), n_bits).unwrap_or_else(|| sum.clone())
    }

    /// The colour as a picture has it: `u8` and `u16` are in sRGB, `f32` are the nearest linear ones.
    pub fn pixel<C: QuantizedPixels>(&self) -> [C; 3] {
        let near =
            |sum: &Enclosure| QuadraticSurd::from(self.mean_of(sum, FEWEST_BITS).low).to_f64();
        let guess = self.sums(0).each_ref().map(near);
        exact_pixel(self, guess)
    }
}
