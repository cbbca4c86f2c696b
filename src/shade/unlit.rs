//! Samples → colours where a scene has no light: the colours of objects, and exact means of them.

use std::sync::Arc;

use rayon::prelude::*;

use super::mean::ExactMean;
use super::written::{Interval, Written};
use super::{Background, Colors, PIXELS_AT_ONCE, Shader, Style};
use crate::control::Control;
use crate::error::Result;
use crate::exact::exact;
use crate::num::Float;
use crate::scene::{Color, Scene};
use crate::trace::SampleIds;

/// Colours pixels of several samples, or without a background.
#[derive(Debug)]
pub struct Unlit {
    scene: Arc<Scene>,
    style: Style,
    /// By id; the background's first.
    palette: Colors,
}

impl Unlit {
    /// For the pictures of a scene without light.
    pub fn new(scene: Arc<Scene>, style: Style) -> Unlit {
        let mut palette = Shader::new(&scene, style.encoding).palette;
        if style.background != Background::Shown {
            match &mut palette {
                Colors::Srgb8(colors) => colors[0] = [0; 3],
                Colors::Srgb16(colors) => colors[0] = [0; 3],
                Colors::Linear(colors) => colors[0] = [0.0; 3],
            }
        }
        Unlit { scene, style, palette }
    }

    /// How pixels get their colours.
    pub fn style(&self) -> &Style {
        &self.style
    }

    /// Replaces `colors`, in this style's encoding, by those of pixels.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled.
    pub fn shade(&self, samples: &SampleIds, control: &Control, colors: &mut Colors) -> Result<()> {
        fn of<T: Copy>(palette: &[T]) -> impl Fn(u32) -> T {
            // What no object has counts as background.
            |id| palette.get(id as usize).copied().unwrap_or(palette[0])
        }
        match (&self.palette, colors) {
            (Colors::Srgb8(palette), Colors::Srgb8(out)) => {
                self.run(samples, of(palette), control, out)
            }
            (Colors::Srgb16(palette), Colors::Srgb16(out)) => {
                self.run(samples, of(palette), control, out)
            }
            (Colors::Linear(palette), Colors::Linear(out)) => {
                self.run(samples, of(palette), control, out)
            }
            (palette, other) => {
                *other = Colors::new(palette.encoding());
                self.shade(samples, control, other)
            }
        }
    }

    fn run<T: Written>(
        &self,
        samples: &SampleIds,
        color: impl Fn(u32) -> T + Sync,
        control: &Control,
        out: &mut Vec<T>,
    ) -> Result<()> {
        control.check()?;
        let whole = samples.whole.par_iter().with_min_len(PIXELS_AT_ONCE);
        whole.map(|&id| color(id)).collect_into_vec(out);
        let mixed = samples.ids.par_chunks(samples.n_each.max(1)).with_min_len(PIXELS_AT_ONCE / 64);
        let mixed: Vec<T> =
            mixed.map(|ids| control.check().map(|()| self.mean(ids))).collect::<Result<_>>()?;
        for (&pixel, color) in samples.mixed.iter().zip(mixed) {
            out[pixel as usize] = color;
        }
        Ok(())
    }

    fn color(&self, id: u32) -> [f64; 3] {
        match id == 0 && self.style.background != Background::Shown {
            true => Color::BLACK.0,
            false => self.scene.color(id).0,
        }
    }

    /// The colour of a pixel whose samples see the objects with these ids.
    fn mean<T: Written>(&self, ids: &[u32]) -> T {
        let n_counted = match self.style.background {
            Background::Shown | Background::Black => ids.len(),
            Background::LeftOut => ids.iter().filter(|&&id| id != 0).count().max(1),
        };
        let mut sums = [0.0; 3];
        for &id in ids {
            for (sum, part) in sums.iter_mut().zip(self.color(id)) {
                *sum += part;
            }
        }
        // A sum of `n` numbers is off by `n` roundings at most, and the quotient by two more.
        let error = match ids.len() {
            1 => 0.0,
            // No test sees it halved: the unit is two roundings.
            n => (n + 8) as f64 * f64::UNIT,
        };
        let bounds = sums.map(|sum| Interval {
            low: sum / n_counted as f64 * (1.0 - error),
            high: sum / n_counted as f64 * (1.0 + error),
        });
        T::of_bounds(&bounds).unwrap_or_else(|| {
            let mut mean = ExactMean::new(n_counted as u64);
            for &id in ids {
                for (channel, part) in self.color(id).into_iter().enumerate() {
                    mean.add(channel, &exact(part));
                }
            }
            T::of_exact(&mean, &bounds)
        })
    }
}
