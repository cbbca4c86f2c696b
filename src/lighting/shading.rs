//! The colours of a picture, band by band.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::lit::Lit;
use super::unlit::Palette;
use super::{Colors, Encoding, Lighting, of_any};
use crate::error::Result;
use crate::query::{Coverage, Hits, Rays, SampleIds, StageCounts, Timing};
use crate::rays::Pixels;
use crate::scene::Samples;
use crate::support::control::Control;
use crate::tracer::Tracer;

/// How pixels get their colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// The numbers that colours are written as.
    pub encoding: Encoding,
    /// Samples across and down a pixel.
    pub n_samples: Samples,
    /// For kernels without a proof: how far from a surface their shadow rays start, world units.
    pub epsilon: f64,
    /// What samples count that hit nothing.
    pub background: Background,
}

impl Style {
    /// One sample a pixel before the scene's background.
    pub fn new(encoding: Encoding) -> Style {
        Style { encoding, n_samples: Samples::ONE, epsilon: 0.0, background: Background::Shown }
    }
}

/// What samples count that hit nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Background {
    /// They have the scene's background colour.
    Shown,
    /// They are left out: a colour is the mean of the other samples, black where there are none.
    LeftOut,
    /// They are black: a colour is premultiplied with the share of the other samples.
    Black,
}

impl Background {
    /// The number that the sum of samples is divided by that see these objects.
    pub(super) fn n_counted(self, ids: impl Iterator<Item = u32>) -> u64 {
        match self {
            Background::Shown | Background::Black => ids.count() as u64,
            Background::LeftOut => ids.filter(|&id| id != 0).count().max(1) as u64,
        }
    }
}

/// Number of pixels of a lit picture, by the device that computed the colour. Unstable in JSON.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct ColorCounts {
    /// Pixels computed on the device.
    pub device: u64,
    /// Pixels of `device` that its f32 arithmetic decided, with a proof.
    pub device_f32: u64,
    /// Pixels computed on the CPU: in f32 or f64, or exactly if that is not enough.
    pub cpu: u64,
}

impl ColorCounts {
    /// Adds another part of the same picture.
    pub fn add(&mut self, other: ColorCounts) {
        self.device += other.device;
        self.device_f32 += other.device_f32;
        self.cpu += other.cpu;
    }
}

/// Pixels of a picture in memory, row by row: all of them, or a band's.
#[derive(Clone, Debug, PartialEq)]
pub struct Framebuffer {
    /// Hits of the pixels' centre rays.
    pub hits: Hits,
    /// One a pixel.
    pub colors: Colors,
    /// How many samples of each pixel hit an object, where those that don't are not [`Background::Shown`].
    pub coverage: Option<Coverage>,
}

impl Framebuffer {
    /// Nothing yet of a picture whose colours are written so.
    pub fn new(encoding: Encoding) -> Framebuffer {
        Framebuffer { hits: Hits::default(), colors: Colors::new(encoding), coverage: None }
    }
}

/// The result of drawing a picture, beside the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStats {
    /// Rays that hit an object.
    pub hits: u64,
    /// How many rays each stage decided.
    pub counts: StageCounts,
    /// Time in the stages of tracing.
    pub timing: Timing,
    /// How many ways from samples to lamps each stage decided.
    pub shadow_rays: StageCounts,
    /// How many lit pixels' colours the device and the CPU found.
    pub colors: ColorCounts,
    /// Time for colours.
    pub shade: Duration,
    /// Time for encoding and writing.
    pub write: Duration,
}

/// Makes the colours of a picture.
pub struct Shading<'a> {
    style: Style,
    look: Method<'a>,
    /// Traces the pixels' centre rays.
    tracer: &'a mut Tracer,
    /// Traces the samples, where there are several.
    of_samples: Option<&'a mut Tracer>,
    hits: Hits,
    samples: SampleIds,
}

/// How a scene looks.
enum Method<'a> {
    Lit(Lit),
    Unlit(&'a Palette),
}

impl<'a> Shading<'a> {
    /// Paints pixels, whose centre rays `tracer` traces, and `of_samples` their samples where these are several:
    /// [`Pixels::samples`]. `palette` is that of the scene's last picture, and serves again where it suits.
    pub fn new(
        style: Style,
        pixels: &Pixels,
        palette: &'a mut Option<Palette>,
        tracer: &'a mut Tracer,
        of_samples: Option<&'a mut Tracer>,
    ) -> Shading<'a> {
        debug_assert_eq!(style.n_samples > Samples::ONE, of_samples.is_some());
        let scene = &tracer.prepared().scene;
        let look = match Lighting::new(scene, &pixels.view) {
            None => Method::Unlit(Palette::renewed(palette, scene, &style)),
            Some(lighting) => Method::Lit(Lit::new(Arc::clone(scene), lighting, style)),
        };
        Shading {
            style,
            look,
            tracer,
            of_samples,
            hits: Hits::default(),
            samples: SampleIds::default(),
        }
    }

    /// The tracer of the pixels' centre rays.
    pub(crate) fn tracer(&mut self) -> &mut Tracer {
        self.tracer
    }

    /// The numbers that it writes colours as.
    pub fn encoding(&self) -> Encoding {
        self.style.encoding
    }

    /// Replaces the colours and the coverage of `rows` by those of a band of pixels, whose hits it has; those are needed where
    /// a pixel has one sample. What kernels without a proof see is lit by a tracer's device, where it has one that does. What
    /// that took is added to `rendered`.
    ///
    /// # Errors
    /// Those of [`Tracer::trace_samples`] and [`Palette::shade`]; [`crate::Error::Interrupted`].
    pub fn paint(
        &mut self,
        band: &Pixels,
        rows: &mut Framebuffer,
        control: &Control,
        rendered: &mut RenderStats,
    ) -> Result<()> {
        let Shading { style, look, tracer, of_samples, hits: room, samples } = self;
        let Framebuffer { hits, colors, coverage } = rows;
        let n_samples = style.n_samples.across();
        let has_coverage = style.background != Background::Shown;
        let coverage_of = |ids: &[u32]| {
            let n = n_samples as usize;
            Coverage::of_ids(ids, band.width as usize * n, n)
        };
        if colors.encoding() != style.encoding {
            *colors = Colors::new(style.encoding);
        }
        control.check()?;
        let start;
        *coverage = match (look, of_samples) {
            (Method::Unlit(shader), None) => {
                start = Instant::now();
                shader.shade(&hits.id, colors)?;
                has_coverage.then(|| coverage_of(&hits.id))
            }
            (Method::Unlit(shader), Some(tracer)) => {
                let timing = tracer.trace_samples(band, n_samples, control, room, samples)?;
                rendered.timing.add(timing);
                rendered.counts.add(samples.counts);
                start = Instant::now();
                shader.mix(&tracer.prepared().scene, samples, control, colors)?;
                has_coverage.then(|| samples.coverage())
            }
            (Method::Lit(lit), of_samples) => {
                let (ids, tracer) = match of_samples {
                    None => (&hits.id, &mut **tracer),
                    Some(tracer) => {
                        let samples = Rays::Pixels(band.samples(n_samples));
                        rendered.timing.add(tracer.trace(&samples, control, room)?);
                        rendered.counts.add(room.counts);
                        (&room.id, &mut **tracer)
                    }
                };
                start = Instant::now();
                let at = (band, &ids[..]);
                let (colors, shadow_rays) =
                    of_any!(colors, colors => lit.shade(at, tracer, control, colors)?);
                rendered.colors.add(colors);
                rendered.shadow_rays.add(shadow_rays);
                has_coverage.then(|| coverage_of(ids))
            }
        };
        rendered.shade += start.elapsed();
        Ok(())
    }

    /// Returns the linear colors of a band of pixels, before any encoding, by a kernel without a proof; `None` without light.
    /// `hits` are the hits of the pixels' centre rays. Only the pixels with the indices `lit` are lit.
    ///
    /// # Errors
    /// Returns the errors of [`Shading::paint`].
    pub(crate) fn baseline_means(
        &mut self,
        band: &Pixels,
        hits: &Hits,
        lit: &[usize],
        control: &Control,
    ) -> Result<Option<Vec<[f64; 3]>>> {
        let Shading { style, look, tracer, of_samples, hits: room, .. } = self;
        let Method::Lit(look) = look else { return Ok(None) };
        let (ids, tracer) = match of_samples {
            None => (&hits.id, &mut **tracer),
            Some(tracer) => {
                let samples = Rays::Pixels(band.samples(style.n_samples.across()));
                tracer.trace(&samples, control, room)?;
                (&room.id, &mut **tracer)
            }
        };
        look.means((band, ids), lit, tracer, control).map(Some)
    }
}
