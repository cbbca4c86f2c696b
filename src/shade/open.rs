//! What is made of the colours that a device proposes.

use rayon::prelude::*;

use super::lit::{Certified, Job, Lit, Work};
use super::occluders::Occluders;
use super::written::Written;
use super::{Background, Colors, Encoding, Style};
use crate::control::Control;
use crate::error::Result;
use crate::host;
use crate::prepare::{ColorWords, LightKey, OPEN_COLOR, Prepared};
use crate::rays::Pixels;
use crate::trace::{Rays, StageCounts};

impl Lit {
    /// What tells the numbers of this style from others of the same picture.
    pub fn light_key(&self) -> LightKey {
        let Style { encoding, n_samples, background, .. } = *self.style();
        LightKey {
            words: match encoding {
                Encoding::Srgb8 => ColorWords::Bytes,
                Encoding::Srgb16 => ColorWords::Shorts,
                Encoding::Linear => ColorWords::Floats,
            },
            n_samples: n_samples.across(),
            shows_background: background == Background::Shown,
            leaves_out: background == Background::LeftOut,
        }
    }

    /// As [`Lit::shade`], with the words that a device proposed of each pixel: those that it left open are
    /// shaded. Their number comes with the counts.
    ///
    /// # Errors
    /// Those of [`Lit::shade`].
    pub fn shade_open(
        &self,
        (prepared, samples, ids): (&Prepared, &Pixels, &[u32]),
        proposed: &[u32],
        control: &Control,
        colors: &mut Colors,
    ) -> Result<(u64, StageCounts)> {
        let rays = Rays::Pixels(*samples);
        prepared.prepare_shadows(control)?;
        let occluders = Occluders::new(prepared, &rays, &self.lighting);
        let job = Job { lit: self, ids, row: samples.width as usize };
        let job = Certified::new(job, &occluders, samples, false);
        match colors {
            Colors::Srgb8(out) => {
                let take = |words: &[u32; 1]| {
                    let [r, g, b, _] = words[0].to_le_bytes();
                    [r, g, b]
                };
                job.run_open(proposed, take, control, out)
            }
            Colors::Srgb16(out) => {
                let take = |words: &[u32; 3]| words.map(|word| word as u16);
                job.run_open(proposed, take, control, out)
            }
            Colors::Linear(out) => {
                let take = |words: &[u32; 3]| words.map(f32::from_bits);
                job.run_open(proposed, take, control, out)
            }
        }
    }
}

impl Certified<'_> {
    /// Fills `out` with what `take` makes of the `N` words of each pixel, and with the colours of those that are left
    /// open.
    fn run_open<T: Written, const N: usize>(
        &self,
        proposed: &[u32],
        take: impl Fn(&[u32; N]) -> T,
        control: &Control,
        out: &mut Vec<T>,
    ) -> Result<(u64, StageCounts)> {
        let (proposed, _) = proposed.as_chunks::<N>();
        out.clear();
        out.extend(proposed.iter().map(take));
        self.job.advance(control, proposed.len());
        let (row, part) = (self.job.n_columns(), self.job.part());
        let paint_row = |(y, out): (usize, &mut [T])| {
            let (mut n_open, mut work) = (0, Work::default());
            for (number, out) in out.chunks_mut(part).enumerate() {
                control.check()?;
                host::check()?;
                let first = y * row + number * part;
                let is_open = |pixel: &usize| proposed[*pixel][0] == OPEN_COLOR;
                let open = (first..first + out.len()).filter(is_open);
                let n_here = open.clone().count() as u64;
                if n_here > 0 {
                    self.find(open, (first, out), &mut work);
                }
                n_open += n_here;
            }
            Ok((n_open, work.counts))
        };
        let found = out.par_chunks_mut(row.max(1)).enumerate().map(paint_row);
        found.try_reduce(Default::default, |(n, mut counts), (n_more, more)| {
            counts.add(more);
            Ok((n + n_more, counts))
        })
    }
}
