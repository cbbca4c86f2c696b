//! The colours of pixels that bounds leave open, exactly.

use std::cell::OnceCell;
use std::collections::HashMap;

use super::lit::Certified;
use super::mean::ExactMean;
use super::pass::{Open, Visibility};
use super::quantized::{QuantizedPixels, exact_pixel};
use crate::error::Result;
use crate::exact::{ExactBeam, ExactPoint};
use crate::prepare::PreparedLight;
use crate::query::StageCounts;
use crate::scene::Source;
use crate::shape::Surface;
use crate::support::control::Control;
use crate::surface::Pack;

/// Most bytes of what one thread knows pixels by that were decided exactly.
const MOST_KNOWN: usize = 1 << 20;

/// The colours of pixels that were decided before, by what their samples see, where that says all.
pub type Known<C> = HashMap<Vec<u8>, [C; 3]>;

/// The point that a sample sees, as well as it is known so far.
struct SamplePoint<'v, 'a> {
    /// Index of its ray.
    at: usize,
    /// What is surely known of each lamp's light on the sample.
    visibility: &'v [Visibility],
    /// The object's id.
    id: u32,
    /// In f64; `None` where nothing is known.
    surface: Option<Surface<f64>>,
    exact: OnceCell<Option<ExactPoint<'a>>>,
}

impl<'a> Certified<'a> {
    /// A pixel's colour.
    ///
    /// # Errors
    /// [`crate::Error::Interrupted`] when `control` was cancelled.
    pub fn decide<C: QuantizedPixels>(
        &self,
        open: &Open,
        control: &Control,
        known: &mut Known<C>,
        counts: &mut StageCounts,
    ) -> Result<[C; 3]> {
        let n_lamps = self.job.lit.lighting.lamps.len();
        let sample = |(number, at): (usize, usize)| {
            let (id, mut packs) = (self.job.ids[at], Vec::<Pack<f64, 1>>::new());
            self.in_f64.surfaces.load(at, &[id], &mut packs);
            self.in_f64.surfaces.solve(&mut packs);
            let surface = Some(packs[0].surface.lane(0)).filter(Surface::is_known);
            let visibility = &open.visibility[number * n_lamps..][..n_lamps];
            SamplePoint { at, visibility, id, surface, exact: OnceCell::new() }
        };
        let samples: Vec<SamplePoint> =
            self.job.samples_of(open.pixel).enumerate().map(sample).collect();
        let Some(seen) = self.seen_evenly(&samples, counts) else {
            return self.exact_mean(open, &samples, control, counts);
        };
        if let Some(color) = known.get(&seen) {
            return Ok(*color);
        }
        // Its shadow rays are counted already.
        let color = self.exact_mean(open, &samples, control, &mut StageCounts::default())?;
        if known.len() * seen.len() < MOST_KNOWN {
            known.insert(seen, color);
        }
        Ok(color)
    }

    /// A sample's point exactly, found when it is first asked for.
    fn exactly<'s>(&self, sample: &'s SamplePoint<'_, 'a>) -> Option<&'s ExactPoint<'a>> {
        let find = || self.occluders.stage.exact_point(sample.at, sample.id);
        sample.exact.get_or_init(find).as_ref()
    }

    /// Whether nothing is in the way of the light of the lamp with index `index`: as bounds have it, and exactly where they
    /// don't tell.
    fn is_seen(
        &self,
        (index, lamp): (usize, &PreparedLight),
        sample: &SamplePoint<'_, 'a>,
        counts: &mut StageCounts,
    ) -> bool {
        if !lamp.casts_shadows() {
            return true;
        }
        let known = sample.visibility[index];
        if known != Visibility::Unknown {
            counts.f64 += 1;
            return known == Visibility::ShapeRecord;
        }
        let ids = self.occluders.candidates(index, sample.id, sample.surface.as_ref());
        if ids.is_empty() {
            counts.f64 += 1;
            return true;
        }
        counts.exact += 1;
        let Some(point) = self.exactly(sample) else { return true };
        let Some(ray) = lamp.beam(point, self.occluders.prepared.reference) else { return true };
        let mut objects = ids.into_iter().filter_map(|id| self.occluders.scene.object(id));
        !objects.any(|object| ray.is_blocked_by(object))
    }

    /// What says all of the colour of samples that see planes in the light of suns, or nothing: of each its plane, and which
    /// suns nothing is in the way of. All rays of a picture see the same side of a plane, and there each sun's light is the same
    /// everywhere. `None` for others.
    fn seen_evenly(
        &self,
        samples: &[SamplePoint<'_, 'a>],
        counts: &mut StageCounts,
    ) -> Option<Vec<u8>> {
        let lamps = &self.job.lit.lighting.lamps;
        let n_spheres = self.occluders.scene.spheres.len() as u32;
        let is_even = lamps.iter().all(|lamp| matches!(lamp.origin, Source::Sun(_)))
            && samples.iter().all(|sample| sample.id == 0 || sample.id > n_spheres);
        if !is_even {
            return None;
        }
        let mut seen: Vec<Vec<u8>> = Vec::with_capacity(samples.len());
        for sample in samples {
            let lamps = lamps.iter().enumerate().filter(|_| sample.id != 0);
            let is_seen = lamps.map(|lamp| u8::from(self.is_seen(lamp, sample, counts)));
            seen.push(sample.id.to_le_bytes().into_iter().chain(is_seen).collect());
        }
        // A mean asks for no order.
        seen.sort_unstable();
        Some(seen.concat())
    }

    fn exact_mean<C: QuantizedPixels>(
        &self,
        open: &Open,
        samples: &[SamplePoint<'_, 'a>],
        control: &Control,
        counts: &mut StageCounts,
    ) -> Result<[C; 3]> {
        let n_counted = self.job.n_counted(open.pixel);
        let mut mean = ExactMean::new(n_counted, Some(&self.job.lit.lighting));
        let eye = self.occluders.prepared.reference;
        for sample in samples {
            control.check()?;
            let at = self.exactly(sample).map(|point| (point, eye));
            let is_seen =
                |lamp: (usize, &PreparedLight), _: &ExactBeam| self.is_seen(lamp, sample, counts);
            mean.add_sample(self.job.color(sample.id), at, is_seen);
        }
        Ok(exact_pixel(&mean, open.bounds.map(|bounds| bounds.low)))
    }
}
