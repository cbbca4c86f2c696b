//! The behaviour of the device's arithmetic, measured on the device: no decision rests on the
//! driver's good manners. [`crate::bounds`] says what the proof assumes.

mod samples;

pub(super) use samples::NUMERATOR;

use std::fmt;

use super::compile::compile_self_test;
use super::open::Gpu;
use super::pipeline::{Program, Resource};
use super::room::BufferRoom;
use super::texture::{TEXELS_PER_ROW, texture};
use crate::error::{Error, Result};
use samples::{
    COMPARED, CONSTANT_OVER, CONVERTED, FMA_REMAINDER, INVERSE, KEPT, LARGER, LARGEST_RESULT,
    N_RESULTS, N_ROUNDED, N_SAMPLES, N_WORDS, NARROWED, PRODUCT, PRODUCT_SUM, QUOTIENT, ROOT,
    SCALED, SUM, SUM_ERROR, Sample, SampleOutcome, SampledFloat, Sort, samples,
};

/// Measured arithmetic of a device in one float type. An error is the distance from the correctly rounded result in steps of
/// the type, for operands and results in the normal range. Unstable in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Arithmetic {
    /// Whether shaders are passed to the driver unchanged. Otherwise `NoContraction` does not forbid the driver to fuse and
    /// to rearrange. Not measured.
    pub passthrough: bool,
    /// Whether two-sum returns the exact rounding error: the driver does not rearrange.
    pub no_contraction: bool,
    /// Whether a product is rounded before it is added: the driver does not fuse.
    pub rounded_products: bool,
    /// Whether `fma` rounds once.
    pub fused_fma: bool,
    /// Whether subnormal operands and results are kept.
    pub subnormals: bool,
    /// Whether results outside the normal range stay harmless: a subnormal counts as itself or as 0, and a number beyond
    /// `2¹²⁶` is large or ∞.
    pub safe_range: bool,
    /// Whether sums and products are one of the two neighbours of the exact result.
    pub faithful: bool,
    /// Maximum error of sums, steps.
    pub sum_ulp: u64,
    /// Maximum error of products, steps.
    pub product_ulp: u64,
    /// Maximum error of quotients, steps.
    pub quotient_ulp: u64,
    /// Maximum error of constants divided by a number, steps.
    pub reciprocal_ulp: u64,
    /// Maximum error of square roots, steps.
    pub root_ulp: u64,
    /// Whether finite numbers of the normal range, and 0, compare correctly.
    pub comparisons: bool,
    /// Whether numbers compare correctly with ∞. The kernel `certified` does not depend on that.
    pub infinities: bool,
    /// Whether integers up to `2²⁴` become f32 without an error.
    pub integers: bool,
    /// Whether words of a texture arrive bit by bit and count as their f32, subnormal ones possibly as 0.
    pub texels: bool,
    /// Whether numbers of the type are rounded to the nearest f32.
    pub narrows_to_nearest: bool,
}

impl Arithmetic {
    /// The findings where each operation is the one that IEEE 754 defines.
    const IEEE: Arithmetic = Arithmetic {
        passthrough: true,
        no_contraction: true,
        rounded_products: true,
        fused_fma: true,
        subnormals: true,
        safe_range: true,
        faithful: true,
        sum_ulp: 0,
        product_ulp: 0,
        quotient_ulp: 0,
        reciprocal_ulp: 0,
        root_ulp: 0,
        comparisons: true,
        infinities: true,
        integers: true,
        texels: true,
        narrows_to_nearest: true,
    };

    /// True where each operation is the one that IEEE 754 defines, so that results are bit-equal to
    /// the CPU's. No kernel has an `fma`.
    pub fn is_ieee(&self) -> bool {
        Arithmetic { fused_fma: true, ..*self } == Arithmetic::IEEE
    }

    /// True where the certified kernel's filter may run on this arithmetic: all that [`crate::bounds`]
    /// assumes of a device holds, which allows products to be fused. Results are counted in steps from the nearest one, which is half
    /// a unit off itself, so that quotients may be 2 and roots 4 steps off.
    pub fn suits_filter(&self) -> bool {
        self.passthrough
            && self.no_contraction
            && self.safe_range
            && self.faithful
            && self.quotient_ulp.max(self.reciprocal_ulp) <= MOST_STEPS[QUOTIENT]
            && self.root_ulp <= MOST_STEPS[ROOT]
            && self.comparisons
            && self.integers
            && self.texels
    }

    /// Where the certified kernel's filter runs for a device with this f32, in words.
    pub fn filter_in_words(&self) -> &'static str {
        match (self.suits_filter(), self.passthrough) {
            (true, _) => "f32 stage on this device",
            (false, true) => "f32 stage on the CPU: this arithmetic does not suit the proof",
            (false, false) => {
                "f32 stage on the CPU: shaders can't be passed through, so the driver may rearrange"
            }
        }
    }
}

/// Steps from the nearest result that the proof allows each operation that rounds.
const MOST_STEPS: [u64; N_ROUNDED] = [1, 1, 2, 4, 2, 2];

/// The findings, in words.
impl fmt::Display for Arithmetic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let off: Vec<String> = [
            ("+", self.sum_ulp),
            ("×", self.product_ulp),
            ("÷", self.quotient_ulp),
            ("1/x", self.reciprocal_ulp),
            ("√", self.root_ulp),
        ]
        .iter()
        .filter(|(_, steps)| *steps > 0)
        .map(|(operation, steps)| format!("{operation} off by up to {steps} ulp"))
        .collect();
        let rounding = match off.is_empty() {
            true => "+ × ÷ √ correctly rounded".to_string(),
            false => off.join(", "),
        };
        let mut words = vec![
            rounding.as_str(),
            if self.no_contraction { "nothing rearranged" } else { "rearranged by the driver" },
            if self.subnormals { "subnormals kept" } else { "subnormals flushed" },
            if self.fused_fma { "fma rounds once" } else { "fma rounds twice" },
        ];
        let defects = [
            (self.rounded_products, "products fused with sums"),
            (self.safe_range, "wrong results beyond the normal range"),
            (self.comparisons, "numbers compared wrongly"),
            (self.infinities, "∞ compared wrongly"),
            (self.integers, "integers not converted exactly"),
            (self.texels, "words of textures changed"),
            (self.narrows_to_nearest, "not rounded to the nearest f32"),
        ];
        words.extend(defects.iter().filter(|(holds, _)| !holds).map(|(_, defect)| defect));
        f.write_str(&words.join("; "))
    }
}

// The texels of all samples lie in one row.
const _: () = assert!(N_SAMPLES <= TEXELS_PER_ROW as usize);

/// Measures a float type, which the adapter must have.
pub fn measure<F: SampledFloat>(gpu: &Gpu) -> Result<Arithmetic> {
    let samples = samples::<F>();
    let outcomes = on_device(gpu, &samples)?;
    Ok(Arithmetic { passthrough: gpu.facts.passthrough, ..judge(&samples, &outcomes) })
}

fn judge<F: SampledFloat>(samples: &[Sample<F>], outcomes: &[SampleOutcome<F>]) -> Arithmetic {
    let mut found = Arithmetic::IEEE;
    for (sample, outcome) in samples.iter().zip(outcomes) {
        let expected = F::expected(sample);
        if sample.sort != Sort::Large {
            for operation in 0..N_ROUNDED {
                judge_rounded(&mut found, sample, operation, outcome, &expected);
            }
        }
        judge_words(&mut found, sample, outcome, &expected);
        if sample.sort == Sort::Near {
            let (results, expected) = (&outcome.results, &expected.results);
            // Where the sum itself is rounded another way, its error is another one.
            found.no_contraction &=
                results[SUM_ERROR] == expected[SUM_ERROR] || results[SUM] != expected[SUM];
            // Only where both operations round to nearest can this be expected.
            found.rounded_products &= results[PRODUCT_SUM] == expected[PRODUCT_SUM];
            found.fused_fma &= results[FMA_REMAINDER] == expected[FMA_REMAINDER];
        }
    }
    found
}

/// Looks at one of the operations that round.
fn judge_rounded<F: SampledFloat>(
    found: &mut Arithmetic,
    sample: &Sample<F>,
    operation: usize,
    outcome: &SampleOutcome<F>,
    expected: &SampleOutcome<F>,
) {
    let (result, nearest) = (outcome.results[operation], expected.results[operation]);
    let is_unary = matches!(operation, ROOT | INVERSE | CONSTANT_OVER);
    let operands_are_normal = sample.a.is_normal() && (is_unary || sample.b.is_normal());
    if !(operands_are_normal && nearest.is_normal() && !is_large(nearest.to_f64())) {
        found.subnormals &= result == nearest;
        found.safe_range &= is_safe(sample, operation, result);
        return;
    }
    let worst = match operation {
        SUM => &mut found.sum_ulp,
        PRODUCT => &mut found.product_ulp,
        QUOTIENT => &mut found.quotient_ulp,
        ROOT => &mut found.root_ulp,
        _ => &mut found.reciprocal_ulp,
    };
    *worst = (*worst).max(F::steps(result, nearest));
    let remainder = match operation {
        SUM => expected.results[SUM_ERROR],
        PRODUCT if nearest.has_remainder() => expected.results[FMA_REMAINDER],
        _ => return,
    };
    found.faithful &= F::is_faithful(result, nearest, remainder);
}

/// True if a result is what becomes of a sample where subnormal operands and results count as they
/// are or as 0 of either sign, and what is large may be ∞.
fn is_safe<F: SampledFloat>(sample: &Sample<F>, operation: usize, result: F) -> bool {
    let Sample { a, b, .. } = *sample;
    let mut readings = a.readings().into_iter().flat_map(|a| b.readings().map(|b| (a, b)));
    let found = result.to_f64();
    readings.any(|(a, b)| {
        let expected = F::expected(&Sample { a, b, ..*sample }).results[operation];
        let nearest = expected.to_f64();
        // 0/0, of two subnormals, is the only reading that is not a number.
        found == nearest
            || (found.is_nan() && nearest.is_nan())
            || (is_large(nearest) && is_large(found) && found * nearest > 0.0)
            || (nearest.is_finite() && !expected.is_normal() && found == 0.0)
            || (found.is_finite()
                && nearest.is_finite()
                && F::steps(result, expected) <= MOST_STEPS[operation])
    })
}

/// True of numbers from [`LARGEST_RESULT`] on, of either sign.
fn is_large(x: f64) -> bool {
    x.abs() >= LARGEST_RESULT
}

/// Looks at the words, and at the larger of two numbers, which comes of a comparison too.
fn judge_words<F: SampledFloat>(
    found: &mut Arithmetic,
    sample: &Sample<F>,
    outcome: &SampleOutcome<F>,
    expected: &SampleOutcome<F>,
) {
    let is_right = outcome.words[COMPARED] == expected.words[COMPARED]
        && outcome.results[LARGER] == expected.results[LARGER];
    match sample.sort {
        Sort::Tiny => found.subnormals &= is_right,
        _ if [sample.a, sample.b].iter().all(|x| x.to_f64().is_finite()) => {
            found.comparisons &= is_right
        }
        _ => found.infinities &= is_right,
    }
    let (words, expected) = (&outcome.words, &expected.words);
    if matches!(sample.sort, Sort::Near | Sort::Wide) {
        found.narrows_to_nearest &= words[NARROWED] == expected[NARROWED];
    }
    found.integers &= words[CONVERTED] == expected[CONVERTED];
    let is_scaled = words[SCALED] == expected[SCALED];
    let is_subnormal = f32::from_bits(sample.texel[2]).is_subnormal();
    if is_subnormal {
        found.subnormals &= is_scaled;
    }
    let is_flushed = is_subnormal && words[SCALED] << 1 == 0;
    found.texels &= words[KEPT] == expected[KEPT] && (is_scaled || is_flushed);
}

/// Runs the self-test's shader on the samples.
fn on_device<F: SampledFloat>(gpu: &Gpu, samples: &[Sample<F>]) -> Result<Vec<SampleOutcome<F>>> {
    let program = Program::new(gpu, &compile_self_test(F::WGSL)?, "self_test")?;
    let operands: Vec<[F; 2]> = samples.iter().map(|sample| [sample.a, sample.b]).collect();
    let texels: Vec<[u32; 4]> = samples.iter().map(|sample| sample.texel).collect();
    let bound = vec![
        ("operands", gpu.filled("operands", bytemuck::cast_slice(&operands)).into()),
        ("texels", Resource::Texture(texture(gpu, "texels", bytemuck::cast_slice(&texels))?)),
    ];
    let results =
        [("results", size_of::<[F; N_RESULTS]>()), ("words", size_of::<[u32; N_WORDS]>())];
    let room = BufferRoom::new(gpu, &program, samples.len(), &results, bound)?;
    let groups = [(samples.len() as u32).div_ceil(64), 1];
    let unfinished = |reason: &str| {
        Error::Device(format!("`{}` did not finish its self-test: {reason}", gpu.facts.name).into())
    };
    let mut outcomes = Vec::new();
    let encoder = room.dispatch(gpu, &program, groups);
    room.read(gpu, encoder, samples.len(), unfinished, &mut |arrays| {
        let results: Vec<[F; N_RESULTS]> = bytemuck::pod_collect_to_vec(arrays[0]);
        let words: Vec<[u32; N_WORDS]> = bytemuck::pod_collect_to_vec(arrays[1]);
        let of_all = results.into_iter().zip(words);
        outcomes.extend(of_all.map(|(results, words)| SampleOutcome { results, words }));
    })?;
    Ok(outcomes)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The findings for an IEEE 754 device with a change.
    fn judged(change: impl Fn(&Sample<f32>, &mut SampleOutcome<f32>)) -> Arithmetic {
        let samples = samples::<f32>();
        let outcome = |sample: &Sample<f32>| {
            let mut outcome = f32::expected(sample);
            change(sample, &mut outcome);
            outcome
        };
        let outcomes: Vec<_> = samples.iter().map(outcome).collect();
        judge(&samples, &outcomes)
    }

    /// A device whose operation gives this where a condition holds.
    fn with(
        operation: usize,
        holds: impl Fn(&Sample<f32>) -> bool,
        change: impl Fn(f32) -> f32,
    ) -> Arithmetic {
        judged(|sample, outcome| {
            if holds(sample) {
                outcome.results[operation] = change(outcome.results[operation]);
            }
        })
    }

    fn steps_up(n: u32) -> impl Fn(f32) -> f32 {
        move |x| f32::from_bits(x.to_bits() + n)
    }

    fn flushed(x: f32) -> f32 {
        if x.is_subnormal() { 0.0 } else { x }
    }

    fn flushed_with_sign(x: f32) -> f32 {
        if x.is_subnormal() { 0.0f32.copysign(x) } else { x }
    }

    fn is_near(sample: &Sample<f32>) -> bool {
        sample.sort == Sort::Near
    }

    #[test]
    fn ieee_arithmetic_passes() {
        let found = judged(|_, _| {});
        assert!(found.is_ieee() && found.suits_filter() && found.fused_fma && found.faithful);
        assert_eq!(found.filter_in_words(), "f32 stage on this device");
        let outcomes: Vec<_> = samples::<f64>().iter().map(f64::expected).collect();
        assert!(judge(&samples::<f64>(), &outcomes).is_ieee());
    }

    /// The proof covers more than IEEE 754.
    #[test]
    fn devices_that_the_proof_covers_pass() {
        for flushed in [flushed, flushed_with_sign] {
            let flush = judged(|sample, outcome| {
                let [_, integer, number, factor] = sample.texel;
                let number = flushed(f32::from_bits(number)).to_bits();
                let (a, b) = (flushed(sample.a), flushed(sample.b));
                let texel = [sample.texel[0], integer, number, factor];
                *outcome = f32::expected(&Sample { a, b, texel, ..*sample });
                outcome.results = outcome.results.map(flushed);
            });
            assert!(!flush.subnormals && !flush.is_ieee() && flush.suits_filter(), "{flush}");
        }
        let fused = judged(|sample, outcome| {
            outcome.results[PRODUCT_SUM] = sample.a.mul_add(sample.b, sample.b);
        });
        assert!(!fused.rounded_products && !fused.is_ieee() && fused.suits_filter(), "{fused}");
        assert!(fused.to_string().contains("fused"));
        let reciprocal = judged(|_, outcome| {
            for operation in [QUOTIENT, INVERSE, CONSTANT_OVER] {
                let result = &mut outcome.results[operation];
                if result.is_normal() {
                    *result = steps_up(2)(*result);
                }
            }
        });
        let both = [reciprocal.quotient_ulp, reciprocal.reciprocal_ulp];
        assert!(both == [2, 2] && reciprocal.suits_filter() && !reciprocal.is_ieee());
        let roots = with(ROOT, |_| true, |x| if x > 0.0 { steps_up(4)(x) } else { x });
        assert!(roots.root_ulp == 4 && roots.suits_filter());
        let twice = with(FMA_REMAINDER, |_| true, |_| 0.0);
        assert!(!twice.fused_fma && twice.suits_filter() && twice.is_ieee());
    }

    /// Each defect of the first list is noticed, and only those of the second leave the filter on
    /// the device.
    #[test]
    fn each_defect_is_noticed() {
        let tiny = |sample: &Sample<f32>| sample.sort == Sort::Tiny;
        let subnormal = |sample: &Sample<f32>| sample.a.is_subnormal();
        let high = |sample: &Sample<f32>| sample.sort == Sort::Wide && sample.a.abs() > 1e30;
        let low = |sample: &Sample<f32>| sample.sort == Sort::Wide && sample.a.abs() < 1e-30;
        let deleted = with(SUM_ERROR, |_| true, |_| 0.0);
        assert!(!deleted.no_contraction && !deleted.suits_filter(), "deleted two-sum");
        assert!(!with(FMA_REMAINDER, |_| true, |_| 0.0).fused_fma, "fma in two roundings");
        assert!(!with(SUM, tiny, flushed).subnormals, "flushed subnormals");
        assert_eq!(with(SUM, is_near, steps_up(2)).sum_ulp, 2);
        assert_eq!(with(PRODUCT, is_near, steps_up(1)).product_ulp, 1);
        assert_eq!(with(QUOTIENT, is_near, f32::next_down).quotient_ulp, 1);
        let sum = with(SUM, is_near, f32::next_up);
        assert!(!sum.faithful && !sum.suits_filter(), "a sum on the wrong side");
        let product = with(PRODUCT, high, f32::next_up);
        assert!(!product.faithful, "a product of large numbers on the wrong side");

        for (what, operation, steps, found) in [
            ("1/a of large numbers", INVERSE, 3, with(INVERSE, high, steps_up(3))),
            ("1/a of small numbers", INVERSE, 3, with(INVERSE, low, steps_up(3))),
            (
                "a constant over a number",
                CONSTANT_OVER,
                3,
                with(CONSTANT_OVER, is_near, steps_up(3)),
            ),
            ("roots of large numbers", ROOT, 6, with(ROOT, high, steps_up(6))),
            ("roots of small numbers", ROOT, 6, with(ROOT, low, steps_up(6))),
        ] {
            let worst = if operation == ROOT { found.root_ulp } else { found.reciprocal_ulp };
            assert!(worst == steps && !found.suits_filter(), "{what}: {found}");
        }
        for (what, found) in [
            ("quotients", with(QUOTIENT, |sample| high(sample) && sample.b.abs() < 1.0, |_| 0.0)),
            ("quotients of subnormals", with(QUOTIENT, subnormal, |_| f32::NAN)),
            ("a root of a subnormal", with(ROOT, subnormal, |_| f32::INFINITY)),
            ("a root of a subnormal", with(ROOT, subnormal, |x| 2.0 * x)),
            ("a product of subnormals", with(PRODUCT, subnormal, |_| f32::MIN_POSITIVE)),
            ("a small product", with(PRODUCT, tiny, |x| if x.is_subnormal() { -x } else { x })),
            ("a small sum", with(SUM, tiny, |x| x + f32::MIN_POSITIVE)),
            ("1/a of a subnormal", with(INVERSE, subnormal, |_| 0.0)),
            ("1/a of a subnormal", with(INVERSE, subnormal, |_| f32::NAN)),
        ] {
            assert!(!found.is_ieee() && !found.suits_filter(), "{what}: {found}");
            let is_named = !found.safe_range || found.quotient_ulp > 2;
            assert!(is_named && found.to_string() != judged(|_, _| {}).to_string(), "{what}");
        }
    }

    fn with_word(word: usize, change: impl Fn(&Sample<f32>, u32) -> u32) -> Arithmetic {
        judged(|sample, outcome| outcome.words[word] = change(sample, outcome.words[word]))
    }

    #[test]
    fn each_defect_of_words_and_comparisons_is_noticed() {
        let cut = with_word(NARROWED, |_, bits| bits - 1);
        assert!(!cut.narrows_to_nearest && !cut.is_ieee(), "narrowed toward zero");
        let halved = with_word(CONVERTED, |_, bits| bits & !1);
        assert!(!halved.integers && !halved.suits_filter(), "integers of 23 bits");
        let quiet = |_: &Sample<f32>, word| {
            if f32::from_bits(word).is_nan() { word | 0x0040_0000 } else { word }
        };
        let zeroed = |_: &Sample<f32>, word| flushed(f32::from_bits(word)).to_bits();
        let garbage = |sample: &Sample<f32>, word| {
            if f32::from_bits(sample.texel[2]).is_subnormal() { word | 0x3f80_0000 } else { word }
        };
        for (what, found) in [
            ("a NaN made quiet", with_word(KEPT, quiet)),
            ("a word flushed", with_word(KEPT, zeroed)),
            ("a subnormal read as another number", with_word(SCALED, garbage)),
        ] {
            assert!(!found.texels && !found.suits_filter(), "{what}");
        }
        let is_infinite = |sample: &Sample<f32>| sample.a.is_infinite() || sample.b.is_infinite();
        let finite = with_word(COMPARED, |sample, bits| {
            let is_large = sample.a.abs() >= f32::MAX / 2.0 && !is_infinite(sample);
            if is_large && bits == 0b00011 { 0b01110 } else { bits }
        });
        assert!(!finite.comparisons && finite.infinities && !finite.suits_filter());
        let infinite =
            with_word(COMPARED, |sample, bits| if is_infinite(sample) { 0 } else { bits });
        assert!(infinite.comparisons && !infinite.infinities);
        assert!(infinite.suits_filter() && !infinite.is_ieee());
        let smaller = with(LARGER, |sample| sample.sort == Sort::Large, |_| 0.0);
        assert!(!smaller.comparisons && !smaller.suits_filter(), "the smaller of two");
    }

    /// Two-sum in one shader proves nothing of another where nothing forbids the driver to
    /// rearrange.
    #[test]
    fn without_passthrough_nothing_is_proven() {
        let found = Arithmetic { passthrough: false, ..judged(|_, _| {}) };
        assert!(found.no_contraction && !found.suits_filter() && !found.is_ieee());
        assert!(found.filter_in_words().contains("passed through"));
    }
}
