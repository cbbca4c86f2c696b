//! Colours of lit or sampled pictures against exact arithmetic and against each other.

use std::sync::Arc;

use rayon::prelude::*;

use super::{Near, hit_of};
use crate::control::Control;
use crate::error::Result;
use crate::exact::ExactPixels;
use crate::kernel::Kernel;
use crate::prepare::Prepared;
use crate::rays::{Pixels, Ray};
use crate::render::Rendered;
use crate::scene::{Edges, Scene};
use crate::shade::{
    Colors, Encoding, ExactMean, Lighting, LitPoint, Painter, add_sample, mean_divisor,
};
use crate::trace::Hits;
use crate::tracer::Tracer;

/// Bytes of a pixel whose colour is compared: its index and its colours, and the same once more on the
/// way.
pub const COLOR_BYTES: u64 = 64;

/// Colours of the same pixels in every encoding.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shown {
    /// sRGB, 8 bits a channel.
    pub srgb8: Vec<[u8; 3]>,
    /// sRGB, 16 bits a channel.
    pub srgb16: Vec<[u16; 3]>,
    /// Linear f32.
    pub linear: Vec<[f32; 3]>,
}

impl Shown {
    /// The colours of a band of pixels, as a picture gets them. `hits` are of the pixels' centre rays;
    /// `prepared` and `tracer` are those of [`Painter::new`].
    ///
    /// # Errors
    /// Those of [`Painter::paint`].
    pub fn painted(
        prepared: &Arc<Prepared>,
        band: &Pixels,
        n_samples: u32,
        hits: &Hits,
        mut tracer: Option<&mut (dyn Tracer + 'static)>,
        control: &Control,
    ) -> Result<Shown> {
        let mut shown = Shown::default();
        for encoding in [Encoding::Srgb8, Encoding::Srgb16, Encoding::Linear] {
            let tracer = tracer.as_deref_mut();
            let mut painter = Painter::new(prepared, encoding, band, (n_samples, 0.0), tracer);
            let mut colors = Colors::new(encoding);
            painter.paint(band, hits, control, &mut colors, &mut Rendered::default())?;
            match colors {
                Colors::Srgb8(pixels) => shown.srgb8 = pixels,
                Colors::Srgb16(pixels) => shown.srgb16 = pixels,
                Colors::Linear(pixels) => shown.linear = pixels,
            }
        }
        Ok(shown)
    }

    /// The numbers of a pixel, bit by bit.
    fn bits(&self, index: usize) -> [Option<[u32; 3]>; 3] {
        [
            self.srgb8.get(index).map(|color| color.map(u32::from)),
            self.srgb16.get(index).map(|color| color.map(u32::from)),
            self.linear.get(index).map(|color| color.map(f32::to_bits)),
        ]
    }

    fn len(&self) -> usize {
        self.srgb8.len().max(self.srgb16.len()).max(self.linear.len())
    }
}

/// The exact colours of some of the pixels.
#[derive(Clone, Debug, Default)]
pub struct ColorTruth {
    /// The pixels, as indices into the colours of all pixels.
    pub index: Vec<usize>,
    /// Their colours.
    pub colors: Shown,
}

impl ColorTruth {
    /// The truth about the pixels with these indices, by exact arithmetic on every object that f64 does
    /// not clearly rule out. No tree, no filter: this is what one is judged by. `control` counts each
    /// pixel as a ray.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted) when `control` was cancelled.
    pub fn of_pixels(
        scene: &Scene,
        pixels: &Pixels,
        n_samples: u32,
        index: Vec<usize>,
        control: &Control,
    ) -> Result<ColorTruth> {
        let lighting = Lighting::new(scene, &pixels.view);
        let of_samples = pixels.samples(n_samples);
        let rays = ExactPixels::new(&of_samples);
        let seen = index.par_iter().map(|&index| {
            control.check()?;
            control.advance(1);
            let (x, y) = pixels.xy(index);
            let sample = |at: u32| {
                let (x, y) = (x * n_samples + at % n_samples, y * n_samples + at / n_samples);
                let (origin, direction) =
                    (of_samples.origin_offset(x, y), of_samples.direction(x, y));
                let ray = Ray { origin, direction };
                let near = Near { reference: pixels.view.position, ray };
                let exact = rays.ray(x, y);
                let Some(hit) = hit_of(scene, &exact, &near) else { return (0, None) };
                let point = || LitPoint::new(scene, &exact, &hit, (near.reference, &near.ray));
                (hit.id, lighting.as_ref().and_then(|_| point()))
            };
            let samples: Vec<_> = (0..n_samples * n_samples).map(sample).collect();
            let mut mean = ExactMean::new(mean_divisor(lighting.as_ref(), n_samples));
            for (id, point) in &samples {
                add_sample(&mut mean, scene, lighting.as_ref(), *id, point.as_ref());
            }
            Ok(numbers(&mean))
        });
        let seen: Vec<_> = seen.collect::<Result<_>>()?;
        let colors = Shown {
            srgb8: seen.iter().map(|seen| seen.0).collect(),
            srgb16: seen.iter().map(|seen| seen.1).collect(),
            linear: seen.iter().map(|seen| seen.2).collect(),
        };
        Ok(ColorTruth { index, colors })
    }
}

/// A mean in every encoding.
fn numbers(mean: &ExactMean) -> ([u8; 3], [u16; 3], [f32; 3]) {
    let guess: [f64; 3] = std::array::from_fn(|channel| mean.approximate(channel));
    let code = |channel: usize, edges: &Edges, most| {
        let guess = edges.number(guess[channel]);
        mean.code(channel, guess, most, |code| edges.range(code).0)
    };
    (
        std::array::from_fn(|channel| code(channel, Edges::srgb8(), 255) as u8),
        std::array::from_fn(|channel| code(channel, Edges::srgb16(), u16::MAX)),
        std::array::from_fn(|channel| mean.nearest_f32(channel, guess[channel] as f32)),
    )
}

/// How many pixels have other colours.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct ColorDifferences {
    /// Pixels compared.
    pub pixels: u64,
    /// Those that differ in 8 bits.
    pub srgb8: u64,
    /// Those that differ in 16 bits.
    pub srgb16: u64,
    /// Those whose linear floats differ, bit by bit.
    pub linear: u64,
    /// Index of the first pixel that differs anywhere.
    pub first: Option<usize>,
}

impl ColorDifferences {
    /// True where everything is equal.
    pub fn is_equal(&self) -> bool {
        self.first.is_none()
    }

    /// Adds another part of the same picture, whose pixels begin at `first_pixel`.
    pub fn add(&mut self, other: &ColorDifferences, first_pixel: usize) {
        self.pixels += other.pixels;
        self.srgb8 += other.srgb8;
        self.srgb16 += other.srgb16;
        self.linear += other.linear;
        self.first = self.first.or(other.first.map(|index| first_pixel + index));
    }

    /// One more pixel; what one of the two lacks differs.
    fn count(&mut self, index: usize, a: [Option<[u32; 3]>; 3], b: [Option<[u32; 3]>; 3]) {
        self.pixels += 1;
        let counts = [&mut self.srgb8, &mut self.srgb16, &mut self.linear];
        for ((count, a), b) in counts.into_iter().zip(a).zip(b) {
            if a.is_none() || a != b {
                *count += 1;
                self.first.get_or_insert(index);
            }
        }
    }
}

/// Compares the colours of the same pixels.
pub fn compare_colors(a: &Shown, b: &Shown) -> ColorDifferences {
    let mut found = ColorDifferences::default();
    for index in 0..a.len().max(b.len()) {
        found.count(index, a.bits(index), b.bits(index));
    }
    found
}

/// Compares colours with the truth about some of their pixels.
pub fn compare_colors_to_exact(shown: &Shown, truth: &ColorTruth) -> ColorDifferences {
    let mut found = ColorDifferences::default();
    for (at, &index) in truth.index.iter().enumerate() {
        found.count(index, shown.bits(index), truth.colors.bits(at));
    }
    found
}

/// The promises about colours that these results break, one sentence each. `parity` compares GPU
/// with CPU where both ran; `exact` has each device's name and result.
pub fn broken_color_promises(
    kernel: Kernel,
    parity: Option<&ColorDifferences>,
    exact: &[(&str, &ColorDifferences)],
) -> Vec<String> {
    let name = kernel.name();
    let mut broken = Vec::new();
    for (device, against) in exact {
        if against.pixels == 0 {
            broken.push(format!("{name} on the {device}: no colour was compared"));
        }
    }
    if kernel.about().promise.exact.is_none() {
        return broken;
    }
    let counts = |found: &ColorDifferences| {
        let ColorDifferences { pixels, srgb8, srgb16, linear, .. } = found;
        format!("of {pixels} pixels, {srgb8} in 8 bits, {srgb16} in 16, {linear} in floats")
    };
    if let Some(parity) = parity.filter(|parity| !parity.is_equal()) {
        broken.push(format!("{name}: GPU and CPU show different colours: {}", counts(parity)));
    }
    for (device, against) in exact.iter().filter(|(_, against)| !against.is_equal()) {
        broken.push(format!("{name} on the {device}: wrong colours: {}", counts(against)));
    }
    broken
}
