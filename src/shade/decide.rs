//! The colours of pixels that bounds leave open, exactly.

use std::cell::OnceCell;
use std::collections::HashMap;

use super::exactly::{add_light, beam};
use super::lamp::{Lamp, Origin};
use super::lit::Job;
use super::mean::ExactMean;
use super::occluders::Occluders;
use super::pass::{Open, Visibility};
use super::written::Written;
use crate::certify::{Pack, Surfaces};
use crate::exact::{ExactBeam, ExactPoint, Shape};
use crate::num::Lanes;
use crate::rays::Pixels;
use crate::seen::Surface;
use crate::trace::StageCounts;

/// Most colours that one thread keeps of pixels that were decided exactly.
const MOST_KNOWN: usize = 1 << 12;

/// Decides pixels.
#[derive(Clone, Copy)]
pub struct Decider<'a> {
    pub job: Job<'a>,
    pub occluders: &'a Occluders<'a>,
    pub samples: &'a Pixels,
    pub surfaces: &'a Surfaces<'a, f64>,
}

/// The colours of pixels that were decided before, by what their samples see, where that says all.
pub type Known<T> = HashMap<Vec<u32>, T>;

/// The point that a sample sees, as well as it is known so far.
struct SamplePoint<'a> {
    /// Index of its ray.
    at: usize,
    /// Of each lamp.
    visibility: &'a [Visibility],
    /// The object's id.
    id: u32,
    /// In f64; `None` where nothing is known.
    surface: Option<Surface<f64>>,
    exact: OnceCell<Option<(ExactPoint, Shape)>>,
}

impl SamplePoint<'_> {
    /// The point exactly, found when it is first asked for, and the shape of its object.
    fn exactly(&self, occluders: &Occluders) -> Option<&(ExactPoint, Shape)> {
        self.exact.get_or_init(|| occluders.stage.exact_point(self.at, self.id)).as_ref()
    }
}

impl Decider<'_> {
    /// A pixel's colour.
    pub fn decide<T: Written>(
        &self,
        open: &Open,
        known: &mut Known<T>,
        counts: &mut StageCounts,
    ) -> T {
        let n_lamps = self.job.lit.lighting.lamps.len();
        let visibility = |sample: usize| &open.visibility[sample * n_lamps..][..n_lamps];
        let samples = self.job.samples(open.pixel).enumerate();
        let samples: Vec<SamplePoint> =
            samples.map(|(sample, at)| self.sample(at, visibility(sample))).collect();
        let Some(seen) = self.seen_evenly(&samples, counts) else {
            return self.exact_mean(open, &samples, counts);
        };
        if let Some(color) = known.get(&seen) {
            return *color;
        }
        // Its shadow rays are counted already.
        let color = self.exact_mean(open, &samples, &mut StageCounts::default());
        if known.len() < MOST_KNOWN {
            known.insert(seen, color);
        }
        color
    }

    fn sample<'a>(&self, at: usize, visibility: &'a [Visibility]) -> SamplePoint<'a> {
        let id = self.job.ids[at];
        let mut surface = None;
        if self.surfaces.are_known() {
            let (x, y) = self.samples.xy(at);
            let (i, j) = self.samples.offset2(x, y);
            let mut packs = [Pack::<f64, 1>::default()];
            packs[0].offset = [Lanes([i as f64]), Lanes([j as f64])];
            packs[0].see(&[id], self.occluders.scene.spheres.len() as u32);
            self.surfaces.solve(&mut packs);
            surface = Some(packs[0].surface.lane(0)).filter(Surface::is_known);
        }
        SamplePoint { at, visibility, id, surface, exact: OnceCell::new() }
    }

    /// Whether the light of the lamp with index `index` reaches a point that faces it: as bounds have it, and exactly where they
    /// don't tell.
    fn is_seen(
        &self,
        (index, lamp): (usize, &Lamp),
        sample: &SamplePoint,
        counts: &mut StageCounts,
    ) -> bool {
        if !lamp.casts_shadows() {
            return true;
        }
        let known = sample.visibility[index];
        if known != Visibility::Unknown {
            counts.f64 += 1;
            return known == Visibility::Seen;
        }
        let ids = self.occluders.candidates(index, sample.id, sample.surface.as_ref());
        if ids.is_empty() {
            counts.f64 += 1;
            return true;
        }
        counts.exact += 1;
        let Some((point, _)) = sample.exactly(self.occluders) else { return true };
        let Some(ray) = beam(point, self.occluders.prepared.reference, lamp) else { return true };
        let mut objects = ids.into_iter().filter_map(|id| self.occluders.scene.object(id));
        !objects.any(|object| ray.is_blocked_by(&object.into()))
    }

    /// What says all of the colour of samples that see planes in the light of suns, or nothing: how many of them see which plane
    /// in which suns' light. On one side of a plane each sun's is the same everywhere. `None` for others.
    fn seen_evenly(&self, samples: &[SamplePoint], counts: &mut StageCounts) -> Option<Vec<u32>> {
        let (lamps, occluders) = (&self.job.lit.lighting.lamps, self.occluders);
        if !lamps.iter().all(|lamp| matches!(lamp.origin, Origin::Sun(_))) {
            return None;
        }
        let side = |sample: &SamplePoint| match sample.id {
            0 => Some(false),
            id => occluders.faces_front(id, sample.surface.as_ref()?),
        };
        let sides: Vec<bool> = samples.iter().map(side).collect::<Option<_>>()?;
        // For each kind of sample its object, its side with its suns, and how often it is there.
        let n_words = 3 + lamps.len() / 32;
        let (mut seen, mut one): (Vec<u32>, Vec<u32>) = Default::default();
        for (sample, faces_front) in samples.iter().zip(sides) {
            one.clear();
            one.resize(n_words, 0);
            one[0] = sample.id;
            if sample.id != 0 {
                one[1] = u32::from(faces_front);
                for (index, lamp) in lamps.iter().enumerate() {
                    let gives = (sample.visibility[index] == Visibility::Seen
                        || occluders.lights_plane(index, sample.id, faces_front))
                        && self.is_seen((index, lamp), sample, counts);
                    let bit = index + 1;
                    one[1 + bit / 32] |= u32::from(gives) << (bit % 32);
                }
            }
            let is_alike = |kind: &&mut [u32]| kind[..n_words - 1] == one[..n_words - 1];
            match seen.chunks_mut(n_words).find(is_alike) {
                Some(kind) => kind[n_words - 1] += 1,
                None => {
                    one[n_words - 1] = 1;
                    seen.extend_from_slice(&one);
                }
            }
        }
        Some(seen)
    }

    fn exact_mean<T: Written>(
        &self,
        open: &Open,
        samples: &[SamplePoint],
        counts: &mut StageCounts,
    ) -> T {
        let lighting = &self.job.lit.lighting;
        let n_counted = self.job.n_counted(open.pixel);
        let mut mean = ExactMean::new(n_counted * u64::from(lighting.n_shares));
        let eye = self.occluders.prepared.reference;
        for sample in samples {
            let point = sample.exactly(self.occluders);
            let at = point.map(|(point, shape)| (point, shape, eye));
            let is_seen = |lamp: (usize, &Lamp), _: &ExactBeam| self.is_seen(lamp, sample, counts);
            add_light(&mut mean, self.job.color(sample.id), Some(lighting), at, is_seen);
        }
        T::of_exact(&mean, &open.bounds)
    }
}
