//! Samples → colours where a scene has no light: the colours of objects, and exact means of them.

use super::mean::ExactMean;
use super::quantized::{QuantizedPixels, exact_pixel, pixel_between};
use super::{Background, Colors, Encoding, PIXELS_AT_ONCE, Style, of_any};
use crate::error::{Error, Hint, Message, Result, Setting};
use crate::num::Float;
use crate::query::{SampleIds, resize};
use crate::scene::{Color, Scene};
use crate::shape::Bounds;
use crate::support::control::Control;
use crate::support::parallel;

/// Gives pixels the flat colours of their objects. Colours are encoded once an object, not once a
/// pixel.
///
/// ```
/// # use kugelblitz::{scene::{Color, Scene}, lighting::{Colors, Encoding, Palette, Style}};
/// let scene = Scene { background: Color([0.0, 1.0, 0.0]), ..Scene::default() };
/// let mut colors = Colors::new(Encoding::Srgb8);
/// Palette::new(&scene, &Style::new(Encoding::Srgb8)).shade(&[0], &mut colors)?;
/// assert_eq!(colors, Colors::Srgb8(vec![[0, 255, 0]]));
/// # Ok::<(), kugelblitz::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Palette {
    /// By id; the background's first.
    palette: Colors,
    background: Background,
}

impl Palette {
    /// A shader for the objects of `scene`.
    pub fn new(scene: &Scene, style: &Style) -> Palette {
        let mut palette = Colors::new(style.encoding);
        of_any!(&mut palette, palette => {
            resize(palette, scene.n_objects() + 1);
            let parts = palette.chunks_mut(PIXELS_AT_ONCE).enumerate();
            parallel::map(parts, |(part, palette)| {
                // Most clouds have few colours, or one.
                let (mut last, mut encoded) = ([0.0; 3], [0.0; 3].map(QuantizedPixels::of));
                for (id, of_id) in (part * PIXELS_AT_ONCE..).zip(palette) {
                    let color = color(scene, style.background, id as u32);
                    if color != last {
                        (last, encoded) = (color, color.map(QuantizedPixels::of));
                    }
                    *of_id = encoded;
                }
            });
        });
        Palette { palette, background: style.background }
    }

    /// The one that an earlier picture of the same scene had, where it suits, else a new one.
    pub(super) fn renewed<'p>(
        old: &'p mut Option<Palette>,
        scene: &Scene,
        style: &Style,
    ) -> &'p Palette {
        let suits = |old: &mut Palette| {
            (old.palette.encoding(), old.background) == (style.encoding, style.background)
        };
        let palette = old.take_if(suits).unwrap_or_else(|| Palette::new(scene, style));
        old.insert(palette)
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
            let text = format!(
                "the device gave a wrong answer: a pixel has the id {largest_id}, but the ids of this scene end at {}",
                n_colors - 1
            );
            let hint = Hint::new(
                "use {}; `kugelblitz probe` shows the device",
                [Setting::text("device", "cpu")],
            );
            return Err(Error::Device(Message::new(text, hint)));
        }
        colors.look_up(&self.palette, ids);
        Ok(())
    }

    /// Replaces `colors` by those of pixels of the scene.
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
        control.check()?;
        // What shows several objects counts as background for now.
        colors.look_up(&self.palette, &samples.whole);
        of_any!(colors, colors => self.mix_in(colors, (scene, samples), control))
    }

    fn mix_in<C: QuantizedPixels>(
        &self,
        colors: &mut [[C; 3]],
        (scene, samples): (&Scene, &SampleIds),
        control: &Control,
    ) -> Result<()> {
        let n_each = samples.n_each.max(1);
        let means = |ids: &[u32]| {
            control.check()?;
            Ok(ids.chunks(n_each).map(|ids| self.mean(scene, ids)).collect::<Vec<[C; 3]>>())
        };
        let parts = samples.ids.chunks(PIXELS_AT_ONCE / 64 * n_each);
        let means = parallel::try_map(parts, means)?;
        for (&pixel, color) in samples.mixed.iter().zip(means.into_iter().flatten()) {
            colors[pixel as usize] = color;
        }
        Ok(())
    }

    /// The colour of a pixel whose samples see the objects with these ids.
    fn mean<C: QuantizedPixels>(&self, scene: &Scene, ids: &[u32]) -> [C; 3] {
        let n_counted = self.background.n_counted(ids.iter().copied());
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
        let bounds = sums.map(|sum| Bounds {
            low: sum / n_counted as f64 * (1.0 - error),
            high: sum / n_counted as f64 * (1.0 + error),
        });
        pixel_between(&bounds).unwrap_or_else(|| {
            let mut mean = ExactMean::new(n_counted, None);
            for &id in ids {
                mean.add_sample(color(scene, self.background, id), None, |_, _| true);
            }
            exact_pixel(&mean, bounds.map(|bounds| bounds.low))
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
