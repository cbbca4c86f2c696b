//! What the device's arithmetic really does, measured on the device: no decision rests on the
//! driver's good manners.

use std::fmt;
use std::time::Duration;

use bytemuck::Pod;

use super::adapter::Gpu;
use super::compile::compile_self_test;
use super::pipeline::{bind_group, bind_group_layout, pipeline};
use crate::compare::ulp_distance;
use crate::error::{Error, Result};
use crate::random::SplitMix;

/// What the self-test found for one float type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Arithmetic {
    /// Whether two-sum gives the exact rounding error: the driver neither fuses nor rearranges.
    pub no_contraction: bool,
    /// Whether `fma` rounds once.
    pub fused_fma: bool,
    /// Whether subnormal operands and results are kept.
    pub subnormals: bool,
    /// Whether sums and products are one of the two neighbours of the exact result.
    pub faithful: bool,
    /// Largest distance of sums from the correctly rounded ones, in steps of the type.
    pub sum_ulp: u64,
    /// The same for products.
    pub product_ulp: u64,
    /// The same for quotients.
    pub quotient_ulp: u64,
    /// The same for square roots.
    pub root_ulp: u64,
    /// Whether numbers of the type are rounded to the nearest f32.
    pub narrows_to_nearest: bool,
}

impl Arithmetic {
    /// Whether each operation is the one that IEEE 754 defines, so that results are bit-equal to
    /// the CPU's.
    pub fn is_ieee(&self) -> bool {
        self.no_contraction
            && self.subnormals
            && self.narrows_to_nearest
            && [self.sum_ulp, self.product_ulp, self.quotient_ulp, self.root_ulp] == [0; 4]
    }

    /// Whether the certified kernel's filter may run on this arithmetic: nothing is rearranged,
    /// sums and products are faithful, quotients within 2.5 units and roots within 4.5, as
    /// [`crate::guard`] assumes. Results are counted in steps from the nearest one, which is half a
    /// unit off itself, so that quotients may be 2 and roots 4 steps off.
    pub fn suits_filter(&self) -> bool {
        self.no_contraction && self.faithful && self.quotient_ulp <= 2 && self.root_ulp <= 4
    }

    /// Where the certified kernel's filter runs for a device with this f32, in words.
    pub fn filter_in_words(&self) -> &'static str {
        match self.suits_filter() {
            true => "f32 stage on this device",
            false => "f32 stage on the CPU: this arithmetic does not suit the proof",
        }
    }
}

/// What was found, in words.
impl fmt::Display for Arithmetic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let off: Vec<String> = [
            ("+", self.sum_ulp),
            ("×", self.product_ulp),
            ("÷", self.quotient_ulp),
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
        if !self.narrows_to_nearest {
            words.push("not rounded to the nearest f32");
        }
        f.write_str(&words.join("; "))
    }
}

/// Pairs of operands of each sort.
const PAIRS: u32 = 1024;

/// A device that takes longer than this for the self-test is not usable.
const TIMEOUT: Duration = Duration::from_secs(20);

/// A float type that the self-test can look at.
trait Float: Pod + PartialEq {
    /// WGSL's name of the type.
    const WGSL: &'static str;
    /// An operand with 24 or 53 random bits and an exponent near 0 or, if `small`, among the
    /// subnormals.
    fn operand(random: &mut SplitMix, small: bool) -> Self;
    /// Sum, product, quotient, root of |a|, error of the sum, remainder of the product, and `a`
    /// rounded to f32.
    fn expected(a: Self, b: Self) -> [Self; 7];
    fn steps(a: Self, b: Self) -> u64;
    /// Whether `found`, for the sum (0) or the product (1), is a neighbour of the exact result on
    /// the side where that result lies, or the nearest itself.
    fn is_faithful(a: Self, b: Self, operation: usize, found: Self, nearest: Self) -> bool;
}

macro_rules! float {
    ($float:ident, $bits:ident, $wgsl:literal, $mantissa:literal, $bias:literal, $steps:path) => {
        impl Float for $float {
            const WGSL: &'static str = $wgsl;

            fn operand(random: &mut SplitMix, small: bool) -> Self {
                let bits = random.next();
                let mantissa = bits as $bits & ((1 << $mantissa) - 1);
                let exponent = if small { 0 } else { $bias - 10 + (bits >> 58) as $bits % 20 };
                let magnitude = $float::from_bits(exponent << $mantissa | mantissa);
                if bits >> 57 & 1 == 0 { magnitude } else { -magnitude }
            }

            fn expected(a: Self, b: Self) -> [Self; 7] {
                let sum = a + b;
                let b_part = sum - a;
                let a_part = sum - b_part;
                let sum_error = (a - a_part) + (b - b_part);
                let product = a * b;
                let (root, remainder) = (a.abs().sqrt(), a.mul_add(b, -product));
                [sum, product, a / b, root, sum_error, remainder, $float::from(a as f32)]
            }

            fn steps(a: Self, b: Self) -> u64 {
                $steps(a, b)
            }

            fn is_faithful(a: Self, b: Self, operation: usize, found: Self, nearest: Self) -> bool {
                // The exact result lies above the nearest where its remainder is positive.
                let remainder = match operation {
                    0 => Self::expected(a, b)[4],
                    _ => Self::expected(a, b)[5],
                };
                found == nearest
                    || (remainder > 0.0 && found == nearest.next_up())
                    || (remainder < 0.0 && found == nearest.next_down())
            }
        }
    };
}
float!(f32, u32, "f32", 23, 127, ulp_distance);
float!(f64, u64, "f64", 52, 1023, steps_f64);

fn steps_f64(a: f64, b: f64) -> u64 {
    if a == b { 0 } else { a.to_bits().abs_diff(b.to_bits()) }
}

/// Measures f32.
pub fn test_f32(gpu: &Gpu) -> Result<Arithmetic> {
    run::<f32>(gpu)
}

/// Measures f64, which the adapter must have.
pub fn test_f64(gpu: &Gpu) -> Result<Arithmetic> {
    run::<f64>(gpu)
}

fn run<F: Float>(gpu: &Gpu) -> Result<Arithmetic> {
    let mut random = SplitMix::new(1);
    let operands: Vec<[F; 2]> = (0..2 * PAIRS)
        .map(|i| std::array::from_fn(|_| F::operand(&mut random, i >= PAIRS)))
        .collect();
    let found: Vec<[F; 7]> = on_device(gpu, &operands)?;
    Ok(judge(&operands, &found))
}

fn judge<F: Float>(operands: &[[F; 2]], found: &[[F; 7]]) -> Arithmetic {
    let mut result = Arithmetic {
        no_contraction: true,
        fused_fma: true,
        subnormals: true,
        faithful: true,
        sum_ulp: 0,
        product_ulp: 0,
        quotient_ulp: 0,
        root_ulp: 0,
        narrows_to_nearest: true,
    };
    for (i, (&[a, b], found)) in operands.iter().zip(found).enumerate() {
        let expected = F::expected(a, b);
        if i >= PAIRS as usize {
            // Subnormal operands: their sum is exact.
            result.subnormals &= found[0] == expected[0];
            continue;
        }
        let steps: [u64; 4] = std::array::from_fn(|k| F::steps(found[k], expected[k]));
        result.faithful &= (0..2).all(|k| F::is_faithful(a, b, k, found[k], expected[k]));
        result.sum_ulp = result.sum_ulp.max(steps[0]);
        result.product_ulp = result.product_ulp.max(steps[1]);
        result.quotient_ulp = result.quotient_ulp.max(steps[2]);
        result.root_ulp = result.root_ulp.max(steps[3]);
        // Where the sum itself is rounded another way, its error is another one.
        result.no_contraction &= found[4] == expected[4] || steps[0] > 0;
        result.fused_fma &= found[5] == expected[5];
        result.narrows_to_nearest &= found[6] == expected[6];
    }
    result
}

/// Runs the self-test's shader on the operands.
fn on_device<F: Float>(gpu: &Gpu, operands: &[[F; 2]]) -> Result<Vec<[F; 7]>> {
    let shader = compile_self_test(F::WGSL)?;
    let Gpu { device, queue, .. } = gpu;
    let layout = bind_group_layout(device, &shader);
    let pipeline = pipeline(gpu, &shader, "self_test", &layout)?;
    let buffer = |bytes: usize, usage| {
        device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("self-test"),
            size: bytes as u64,
            usage,
            mapped_at_creation: false,
        })
    };
    let result_bytes = size_of::<[F; 7]>() * operands.len();
    let input =
        buffer(size_of_val(operands), wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST);
    let output = buffer(result_bytes, wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC);
    let staging = buffer(result_bytes, wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST);
    queue.write_buffer(&input, 0, bytemuck::cast_slice(operands));
    let group = bind_group(device, &layout, [&input, &output]);
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups((operands.len() as u32).div_ceil(64), 1, 1);
    }
    encoder.copy_buffer_to_buffer(&output, 0, &staging, 0, None);
    queue.submit([encoder.finish()]);
    let view = gpu.map(&staging, result_bytes as u64, TIMEOUT).map_err(|reason| {
        Error::Device(format!("`{}` did not finish its self-test: {reason}", gpu.facts.name))
    })?;
    Ok(bytemuck::pod_collect_to_vec(&view))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(change: impl Fn(&[f32; 2], &mut [f32; 7])) -> Arithmetic {
        let mut random = SplitMix::new(7);
        let operands: Vec<[f32; 2]> = (0..2 * PAIRS)
            .map(|i| std::array::from_fn(|_| f32::operand(&mut random, i >= PAIRS)))
            .collect();
        let found: Vec<_> = operands
            .iter()
            .map(|pair| {
                let mut results = f32::expected(pair[0], pair[1]);
                change(pair, &mut results);
                results
            })
            .collect();
        judge(&operands, &found)
    }

    #[test]
    fn ieee_arithmetic_passes() {
        let found = judged(|_, _| {});
        assert!(found.is_ieee() && found.suits_filter() && found.fused_fma);
    }

    #[test]
    fn each_defect_is_noticed() {
        assert!(!judged(|_, r| r[4] = 0.0).no_contraction, "deleted two-sum");
        assert!(!judged(|_, r| r[5] = 0.0).fused_fma, "fma in two roundings");
        let flushed = |x: f32| if x.is_subnormal() { 0.0 } else { x };
        assert!(!judged(|_, r| r[0] = flushed(r[0])).subnormals, "flushed subnormals");
        assert_eq!(judged(|_, r| r[0] = r[0].next_up().next_up()).sum_ulp, 2);
        assert_eq!(judged(|_, r| r[1] = r[1].next_up()).product_ulp, 1);
        assert_eq!(judged(|_, r| r[2] = r[2].next_down()).quotient_ulp, 1);
        assert!(!judged(|_, r| r[0] = r[0].next_up()).faithful, "a sum on the wrong side");
        let cut = judged(|_, r| r[6] = r[6].next_down());
        assert!(!cut.narrows_to_nearest && !cut.is_ieee(), "narrowed toward zero");
        let worse = judged(|_, r| r[3] = f32::from_bits(r[3].to_bits() + 6));
        assert!(worse.root_ulp == 6 && !worse.suits_filter());
    }
}
