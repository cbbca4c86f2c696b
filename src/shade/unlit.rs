//! Samples → colours where a scene has no light: the colours of objects, and exact means of them.

use rayon::prelude::*;

use super::mean::ExactMean;
use super::written::{Interval, Written};
use super::{Background, Colors, Encoding, PIXELS_AT_ONCE, Style};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::exact::exact;
use crate::num::Float;
use crate::scene::{Color, Scene};
use crate::trace::SampleIds;

/// Gives pixels the flat colours of their objects. Colours are encoded once an object, not once a
/// pixel.
///
/// ```
/// # use kugelblitz::{scene::{Color, Scene}, shade::{Colors, Encoding, Shader, Style}};
/// let scene = Scene { background: Color([0.0, 1.0, 0.0]), ..Scene::default() };
/// let mut colors = Colors::new(Encoding::Srgb8);
/// Shader::new(&scene, &Style::new(Encoding::Srgb8)).shade(&[0], &mut colors)?;
/// assert_eq!(colors, Colors::Srgb8(vec![[0, 255, 0]]));
/// # Ok::<(), kugelblitz::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Shader {
    /// By id; the background's first.
    palette: Colors,
    background: Background,
}

impl Shader {
    /// A shader for the objects of `scene`.
    pub fn new(scene: &Scene, style: &Style) -> Shader {
        let color = |id: u32| color(scene, style.background, id);
        let colors = (0..=scene.n_objects() as u32).map(|id| Color(color(id)));
        let palette = match style.encoding {
            Encoding::Srgb8 => Colors::Srgb8(colors.map(Color::to_srgb8).collect()),
            Encoding::Srgb16 => Colors::Srgb16(colors.map(Color::to_srgb16).collect()),
            Encoding::Linear => Colors::Linear(colors.map(Color::to_f32).collect()),
        };
        Shader { palette, background: style.background }
    }

    /// Bytes of memory for the colours of `n_objects` objects and for those of `n_pixels` pixels.
    pub fn bytes(encoding: Encoding, n_objects: usize, n_pixels: u64) -> u64 {
        let n_colors = n_pixels.saturating_add(n_objects as u64 + 1);
        n_colors.saturating_mul(encoding.pixel_bytes() as u64)
    }

    /// Replaces `colors` by those of objects, by their ids.
    ///
    /// # Errors
    /// [`Error::Device`] for an id that no object has.
    pub fn shade(&self, ids: &[u32], colors: &mut Colors) -> Result<()> {
        let largest_id = ids.iter().fold(0, |largest, &id| largest.max(id));
        let n_colors = self.palette.len();
        if largest_id as usize >= n_colors {
            return Err(Error::Device(format!(
                "a pixel has the id {largest_id}, but the ids of this scene end at {}; the device \
                 gave a wrong answer: try --device cpu, and `kugelblitz probe` to look at it",
                n_colors - 1
            )));
        }
        match (&self.palette, colors) {
            (Colors::Srgb8(palette), Colors::Srgb8(out)) => look_up(palette, ids, out),
            (Colors::Srgb16(palette), Colors::Srgb16(out)) => look_up(palette, ids, out),
            (Colors::Linear(palette), Colors::Linear(out)) => look_up(palette, ids, out),
            (palette, other) => {
                *other = Colors::new(palette.encoding());
                return self.shade(ids, other);
            }
        }
        Ok(())
    }

    /// Replaces `colors`, which have the numbers of the style, by those of pixels of the scene.
    ///
    /// # Errors
    /// [`Error::Interrupted`] when `control` was cancelled.
    pub(super) fn mix(
        &self,
        scene: &Scene,
        samples: &SampleIds,
        control: &Control,
        colors: &mut Colors,
    ) -> Result<()> {
        match (&self.palette, colors) {
            (Colors::Srgb8(palette), Colors::Srgb8(out)) => {
                self.mix_in(palette, (scene, samples), control, out)
            }
            (Colors::Srgb16(palette), Colors::Srgb16(out)) => {
                self.mix_in(palette, (scene, samples), control, out)
            }
            (Colors::Linear(palette), Colors::Linear(out)) => {
                self.mix_in(palette, (scene, samples), control, out)
            }
            (palette, other) => {
                *other = Colors::new(palette.encoding());
                self.mix(scene, samples, control, other)
            }
        }
    }

    fn mix_in<T: Written>(
        &self,
        palette: &[T],
        (scene, samples): (&Scene, &SampleIds),
        control: &Control,
        out: &mut Vec<T>,
    ) -> Result<()> {
        control.check()?;
        // What shows several objects counts as background for now.
        let whole = samples.whole.par_iter().with_min_len(PIXELS_AT_ONCE);
        let color = |&id: &u32| palette.get(id as usize).copied().unwrap_or(palette[0]);
        whole.map(color).collect_into_vec(out);
        let mixed = samples.ids.par_chunks(samples.n_each.max(1)).with_min_len(PIXELS_AT_ONCE / 64);
        let mean = |ids: &[u32]| control.check().map(|()| self.mean(scene, ids));
        let mixed: Vec<T> = mixed.map(mean).collect::<Result<_>>()?;
        for (&pixel, color) in samples.mixed.iter().zip(mixed) {
            out[pixel as usize] = color;
        }
        Ok(())
    }

    /// The colour of a pixel whose samples see the objects with these ids.
    fn mean<T: Written>(&self, scene: &Scene, ids: &[u32]) -> T {
        let n_counted = match self.background {
            Background::Shown | Background::Black => ids.len(),
            Background::LeftOut => ids.iter().filter(|&&id| id != 0).count().max(1),
        };
        let mut sums = [0.0; 3];
        for &id in ids {
            for (sum, part) in sums.iter_mut().zip(color(scene, self.background, id)) {
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
                for (channel, part) in color(scene, self.background, id).into_iter().enumerate() {
                    mean.add(channel, &exact(part));
                }
            }
            T::of_exact(&mean, &bounds)
        })
    }
}

/// What an object, or the background, counts with.
pub(super) fn color(scene: &Scene, background: Background, id: u32) -> [f64; 3] {
    match id == 0 && background != Background::Shown {
        true => Color::BLACK.0,
        false => scene.color(id).0,
    }
}

fn look_up<T: Copy + Send + Sync>(palette: &[T], ids: &[u32], out: &mut Vec<T>) {
    ids.par_iter()
        .with_min_len(PIXELS_AT_ONCE)
        .map(|&id| palette[id as usize])
        .collect_into_vec(out);
}
