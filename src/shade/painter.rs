//! The colours of a picture, band by band.

use std::sync::Arc;
use std::time::Instant;

use super::{Colors, Encoding, Lighting, Lit, Misses, Shader};
use crate::control::Control;
use crate::error::Result;
use crate::prepare::Prepared;
use crate::rays::Pixels;
use crate::render::Rendered;
use crate::trace::{Coverage, Hits, Rays, StageCounts};
use crate::tracer::Tracer;

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
    encoding: Encoding,
    /// Of the picture whose pixels are the samples.
    prepared: Arc<Prepared>,
    /// Traces it, where it is not the picture itself.
    tracer: Option<&'a mut (dyn Tracer + 'static)>,
    hits: Hits,
}

impl<'a> Painter<'a> {
    /// Paints pixels of `n_samples` × `n_samples` samples, with the `epsilon` of [`Lit::new`].
    /// `prepared` is of the picture whose pixels are the samples, [`Pixels::samples`], and `tracer`
    /// traces it; with one sample a pixel it is the picture itself, which needs no second tracer.
    pub fn new(
        prepared: &Arc<Prepared>,
        encoding: Encoding,
        pixels: &Pixels,
        (n_samples, epsilon): (u32, f64),
        misses: Misses,
        tracer: Option<&'a mut (dyn Tracer + 'static)>,
    ) -> Painter<'a> {
        let scene = &prepared.scene;
        let lighting = Lighting::new(scene, &pixels.view);
        if lighting.is_none() && n_samples == 1 {
            return Painter::Flat(Shader::new(scene, encoding).with_misses(misses));
        }
        Painter::Lit(Box::new(LitPainter {
            lit: Lit::new(Arc::clone(scene), lighting, n_samples, epsilon).with_misses(misses),
            encoding,
            prepared: Arc::clone(prepared),
            tracer,
            hits: Hits::default(),
        }))
    }

    /// The numbers that it writes colours as.
    pub fn encoding(&self) -> Encoding {
        match self {
            Painter::Flat(shader) => shader.encoding(),
            Painter::Lit(lit) => lit.encoding,
        }
    }

    /// How many samples of each pixel of the band that was painted last hit an object. `hits` are of
    /// its pixels' centre rays.
    pub fn coverage(&self, band: &Pixels, hits: &Hits) -> Coverage {
        match self {
            Painter::Lit(painter) if painter.tracer.is_some() => {
                let n_samples = painter.lit.n_samples();
                let row = band.samples(n_samples).width as usize;
                Coverage::of_samples(&painter.hits.id, row, n_samples)
            }
            Painter::Flat(_) | Painter::Lit(_) => Coverage::of_ids(&hits.id),
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
        rendered: &mut Rendered,
    ) -> Result<()> {
        let painter = match self {
            Painter::Flat(shader) => {
                let start = Instant::now();
                shader.shade(hits, colors)?;
                rendered.shade += start.elapsed();
                return Ok(());
            }
            Painter::Lit(painter) => painter,
        };
        let LitPainter { lit, encoding, prepared, tracer, hits: of_samples } = &mut **painter;
        if colors.encoding() != *encoding {
            *colors = Colors::new(*encoding);
        }
        let mut shade = |samples: &Pixels, ids: &[u32], rendered: &mut Rendered| {
            let start = Instant::now();
            let counts = lit.shade(prepared, samples, ids, control, colors)?;
            rendered.shade += start.elapsed();
            rendered.shadow_rays.add(counts);
            Ok(())
        };
        let Some(tracer) = tracer else { return shade(band, &hits.id, rendered) };
        let samples = band.samples(lit.n_samples());
        rendered.timing.add(tracer.trace(&Rays::Pixels(samples), control, of_samples)?);
        let StageCounts { f32, f64, exact } = of_samples.counts;
        rendered.counts.add(StageCounts { f32, f64, exact });
        shade(&samples, &of_samples.id, rendered)
    }
}
