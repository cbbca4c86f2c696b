//! The numbers of a picture's light for a device that shades it, and what is made of the colours
//! that it proposes.

use rayon::prelude::*;

use super::beam::LARGEST;
use super::in_f32::in_f32;
use super::lamp::{Lamp, Lighting};
use super::lit::{Certified, Job, Lit, Work};
use super::narrow::{narrow_plane, narrow_sphere};
use super::occluders::{Met, Occluders};
use super::written::Written;
use super::{Background, Colors, Encoding, Style};
use crate::control::Control;
use crate::error::Result;
use crate::guard::UNIT_F64;
use crate::host;
use crate::kernel::Kernel;
use crate::prepare::{
    ColorInF64, ColorWords, LampInF64, LightInF64, LightKey, LightOfAll, OPEN_COLOR, PlaneInTheWay,
    Prepared, lamp_kind,
};
use crate::rays::Pixels;
use crate::scene::{Color, Edges, Sphere};
use crate::seen::PlaneMet;
use crate::seen::shadow::Origin;
use crate::trace::{Rays, StageCounts};
use crate::tracer::{ProposeColors, ProposedColors};
use crate::tree::slabs::least_slack_of_beams;

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

    /// The numbers for a device that shades the pixels of the kernel `certified`; `None` where that is left to
    /// the CPU: of other kernels, and where numbers may leave the range that f64 has there.
    pub fn in_f64(&self, prepared: &Prepared, samples: &Pixels) -> Option<LightInF64> {
        let lighting = &self.lighting;
        if prepared.kernel != Kernel::Certified {
            return None;
        }
        let rays = Rays::Pixels(*samples);
        let occluders = Occluders::new(prepared, &rays, lighting);
        let LightKey { words, n_samples, shows_background, leaves_out } = self.light_key();
        let (mut spheres, mut planes) = (Vec::new(), Vec::new());
        for listed in &occluders.listed {
            let id = listed.id;
            match listed.met {
                Met::Sphere(met) => {
                    if !(all_in_range(&met.center.0) && met.r < LARGEST) {
                        return None;
                    }
                    spheres.push(id);
                }
                Met::Plane(PlaneMet { point, normal, .. }) => planes.push(PlaneInTheWay {
                    point: point.0,
                    id,
                    padding: 0,
                    normal: normal.0,
                    padding_again: 0.0,
                    narrow: narrow_plane(point.0, normal.0),
                    padding_behind: [0; 4],
                }),
            }
        }
        let narrow = |sphere: &Sphere| {
            let center = sphere.center - prepared.reference;
            narrow_sphere(center.to_array(), sphere.radius.abs())
        };
        let tree = prepared.hierarchy.as_ref().map(|hierarchy| &hierarchy.tree);
        let all = LightOfAll {
            ambient: lighting.ambient,
            mean_error: n_terms(n_samples, lighting) as f64 * UNIT_F64,
            to_tree: occluders.to_tree.to_array(),
            n_lamps: lighting.lamps.len() as u32,
            n_samples,
            n_listed_spheres: spheres.len() as u32,
            n_listed_planes: planes.len() as u32,
            n_boxes: tree.map_or(0, |tree| tree.n_nodes() as u32),
            leaves_out: u32::from(leaves_out),
            least_slack: tree.map_or(0.0, |tree| least_slack_of_beams(tree.largest_coordinate())),
            padding: [0; 3],
        };
        let nothing = if shows_background { prepared.scene.background } else { Color::BLACK };
        let colors = std::iter::once(nothing).chain(prepared.scene.colors().skip(1));
        let edges = |edges: &Edges, largest: u16| -> Vec<f64> {
            (1..=largest).map(|number| edges.range(number).0).collect()
        };
        let light = LightInF64 {
            words,
            all,
            lamps: lighting.lamps.iter().zip(&occluders.origins).map(lamp_in_f64).collect(),
            narrow: prepared.scene.spheres[..].par_iter().map(narrow).collect(),
            spheres,
            planes,
            palette: colors.map(|color| ColorInF64::from(color.0)).collect(),
            edges: match words {
                ColorWords::Bytes => edges(Edges::srgb8(), 255),
                ColorWords::Shorts => edges(Edges::srgb16(), u16::MAX),
                ColorWords::Floats => Vec::new(),
            },
            in_f32: None,
        };
        if !is_in_range(&light) {
            return None;
        }
        let in_f32 = match words {
            // A device begins with them in f32; where it can't, all is left to the CPU.
            ColorWords::Bytes => Some(in_f32(&light, prepared, samples)?),
            ColorWords::Shorts | ColorWords::Floats => None,
        };
        Some(LightInF64 { in_f32, ..light })
    }

    /// Has a device propose the words of pixels, at the rays of their samples and the ids that these see. Returns what
    /// that took; `None` where it has no part in it.
    ///
    /// # Errors
    /// Those of [`Tracer::trace`](crate::tracer::Tracer::trace).
    pub fn propose(
        &self,
        (prepared, samples, ids): (&Prepared, &Pixels, &[u32]),
        device: &mut dyn ProposeColors,
        control: &Control,
        proposed: &mut Vec<u32>,
    ) -> Result<Option<ProposedColors>> {
        let make = || self.in_f64(prepared, samples);
        device.propose_colors(self.light_key(), &make, (samples, ids), control, proposed)
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

/// What [`Lit::shade`] counts as the terms of a pixel's mean; on a device the sum's roundings, the quotient's 2½
/// and 6 others are fewer too.
pub fn n_terms(n_samples: u32, lighting: &Lighting) -> usize {
    n_samples.pow(2) as usize + lighting.lamps.len() + 9
}

fn lamp_in_f64((lamp, here): (&Lamp, &Origin)) -> LampInF64 {
    let (at, kind) = match *here {
        Origin::Point(_) if lamp.origin == super::Origin::Eye => ([0.0; 3], lamp_kind::EYE),
        Origin::Point(position) => (position.to_array(), lamp_kind::POINT),
        Origin::Sun(way) => (way.to_array(), lamp_kind::SUN),
    };
    let shadows = u32::from(lamp.casts_shadows());
    LampInF64 { at, kind, shadows, weight: lamp.weight, padding: 0.0 }
}

fn all_in_range(numbers: &[f64]) -> bool {
    numbers.iter().all(|number| number.abs() < LARGEST)
}

/// Whether all other numbers have squares in f64's range, too, so that nothing overflows, and none that is
/// compared with 0 may be flushed to it.
fn is_in_range(light: &LightInF64) -> bool {
    let all = all_in_range;
    let is_kept = |number: &f64| *number == 0.0 || number.abs() > 1.0 / LARGEST;
    let are_kept = |numbers: &[f64]| numbers.iter().all(is_kept);
    all(&light.all.ambient)
        && all(&light.all.to_tree)
        && light.lamps.iter().all(|lamp| all(&lamp.at) && are_kept(&lamp.at) && all(&lamp.weight))
        && light.planes.iter().all(|plane| all(&plane.point) && are_kept(&plane.normal))
        && light.palette.iter().all(|color| all(&color.parts))
}
