//! The colours of a picture, band by band.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::{Colors, Encoding, Lighting, Lit, Shader};
use crate::control::Control;
use crate::error::Result;
use crate::prepare::Prepared;
use crate::rays::Pixels;
use crate::trace::{Coverage, Hits, Rays, StageCounts, Timing};
use crate::tracer::Tracer;

/// How pixels get their colours.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// The numbers that colours are written as.
    pub encoding: Encoding,
    /// Samples across and down a pixel, at least 1.
    pub n_samples: u32,
    /// For kernels without a proof: how far from a surface their shadow rays start, world units.
    pub epsilon: f64,
    /// What samples count that hit nothing.
    pub background: Background,
}

impl Style {
    /// One sample a pixel before the scene's background.
    pub fn new(encoding: Encoding) -> Style {
        Style { encoding, n_samples: 1, epsilon: 0.0, background: Background::Shown }
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

/// How many pixels of a lit picture have their colour from where.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct ColorCounts {
    /// The device.
    pub device: u64,
    /// The CPU: in f64, and exactly where that is not enough.
    pub cpu: u64,
}

impl ColorCounts {
    /// Adds another part of the same picture.
    pub fn add(&mut self, other: ColorCounts) {
        self.device += other.device;
        self.cpu += other.cpu;
    }
}

/// What painting took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Painted {
    /// How many of the samples' rays each stage decided, where they are not the pixels' centre rays.
    pub counts: StageCounts,
    /// How many ways from samples to lamps each stage decided.
    pub shadow_rays: StageCounts,
    /// How many pixels' colours the device and the CPU found, where they are not flat.
    pub colors: ColorCounts,
    /// Time for tracing the samples.
    pub timing: Timing,
    /// Time for colours.
    pub shade: Duration,
}

/// Makes the colours of a picture.
pub enum Painter<'a> {
    /// Each object has its own, and each pixel one sample.
    Flat(Shader),
    /// The scene has light, or each pixel several samples.
    Lit(Box<LitPainter<'a>>),
}

/// See [`Painter::Lit`].
pub struct LitPainter<'a> {
    lit: Lit,
    coverage: Option<Coverage>,
    /// Of the picture whose pixels are the samples.
    prepared: Arc<Prepared>,
    /// Traces it, where it is not the picture itself.
    tracer: Option<&'a mut (dyn Tracer + 'static)>,
    hits: Hits,
    /// What a device proposes.
    proposed: Vec<u32>,
}

impl<'a> Painter<'a> {
    /// Paints pixels. `prepared` is of the picture whose pixels are their samples, [`Pixels::samples`],
    /// and `tracer` traces it; with one sample a pixel it is the picture itself, which needs no second
    /// tracer.
    pub fn new(
        prepared: &Arc<Prepared>,
        style: Style,
        pixels: &Pixels,
        tracer: Option<&'a mut (dyn Tracer + 'static)>,
    ) -> Painter<'a> {
        let scene = &prepared.scene;
        let lighting = Lighting::new(scene, &pixels.view);
        let is_shown = style.background == Background::Shown;
        if lighting.is_none() && style.n_samples == 1 && is_shown {
            return Painter::Flat(Shader::new(scene, style.encoding));
        }
        Painter::Lit(Box::new(LitPainter {
            lit: Lit::new(Arc::clone(scene), lighting, style),
            coverage: (!is_shown).then(Coverage::default),
            prepared: Arc::clone(prepared),
            tracer,
            hits: Hits::default(),
            proposed: Vec::new(),
        }))
    }

    /// The numbers that it writes colours as.
    pub fn encoding(&self) -> Encoding {
        match self {
            Painter::Flat(shader) => shader.encoding(),
            Painter::Lit(painter) => painter.lit.style().encoding,
        }
    }

    /// How many samples of each pixel that was painted last hit an object, where those that don't are not
    /// [`Background::Shown`].
    pub fn coverage(&self) -> Option<&Coverage> {
        match self {
            Painter::Flat(_) => None,
            Painter::Lit(painter) => painter.coverage.as_ref(),
        }
    }

    /// Replaces `colors` by those of a band of pixels. `hits` are of its pixels' centre rays.
    ///
    /// # Errors
    /// Those of [`Tracer::trace`], [`Shader::shade`] and [`Lit::shade`].
    pub fn paint(
        &mut self,
        band: &Pixels,
        hits: &Hits,
        control: &Control,
        colors: &mut Colors,
    ) -> Result<Painted> {
        self.paint_with(None, band, hits, control, colors)
    }

    /// The same; the pixels' tracer `of_pixels` may have a device that shades.
    ///
    /// # Errors
    /// Those of [`Painter::paint`].
    pub fn paint_with(
        &mut self,
        of_pixels: Option<&mut dyn Tracer>,
        band: &Pixels,
        hits: &Hits,
        control: &Control,
        colors: &mut Colors,
    ) -> Result<Painted> {
        let painter = match self {
            Painter::Flat(shader) => {
                let start = Instant::now();
                shader.shade(hits, colors)?;
                return Ok(Painted { shade: start.elapsed(), ..Painted::default() });
            }
            Painter::Lit(painter) => painter,
        };
        let LitPainter { lit, coverage, prepared, tracer, hits: of_samples, proposed } =
            &mut **painter;
        let style = *lit.style();
        if colors.encoding() != style.encoding {
            *colors = Colors::new(style.encoding);
        }
        let mut painted = Painted::default();
        let (samples, ids, device) = match tracer {
            None => (*band, &hits.id, of_pixels),
            Some(tracer) => {
                let samples = band.samples(style.n_samples);
                painted.timing = tracer.trace(&Rays::Pixels(samples), control, of_samples)?;
                painted.counts = of_samples.counts;
                (samples, &of_samples.id, Some(&mut **tracer as &mut dyn Tracer))
            }
        };
        let start = Instant::now();
        let of_samples = (&samples, &ids[..]);
        let device = device.map(|tracer| tracer.shades_in_f64()).transpose()?.flatten();
        let n_ways = match device {
            Some(device) => {
                let make = || lit.in_f64(prepared, &samples);
                device.propose_colors(lit.light_key(), &make, of_samples, control, proposed)?
            }
            None => None,
        };
        painted.shadow_rays = match n_ways {
            Some(n_ways) => {
                let (n_open, counts) =
                    lit.shade_open(prepared, of_samples, proposed, control, colors)?;
                let n_pixels = colors.len() as u64;
                painted.colors = ColorCounts { device: n_pixels - n_open, cpu: n_open };
                StageCounts { f64: counts.f64 + n_ways, ..counts }
            }
            None => {
                let counts = lit.shade(prepared, &samples, ids, control, colors)?;
                painted.colors.cpu = colors.len() as u64;
                counts
            }
        };
        if let Some(coverage) = coverage {
            *coverage = lit.coverage(&samples, ids);
        }
        painted.shade = start.elapsed();
        Ok(painted)
    }
}
