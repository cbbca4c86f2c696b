//! Tracing a picture band by band, so that memory is bounded by a band and not by the picture.

use std::time::Instant;

use crate::error::{Error, Hint, Message, Result, Setting};
use crate::lighting::{Background, Encoding, Framebuffer, Palette, RenderStats, Shading, Style};
use crate::picture::{Format, PictureOptions, Sink, writer_bytes};
use crate::query::{Hits, Outputs, Rays};
use crate::rays::Pixels;
use crate::scene::Samples;
use crate::support::control::Control;
use crate::support::memory::Available;

/// Bytes of [`Hits`] of a band. With ids alone that is twice a picture of 1920 × 1080; with `t` and
/// normals it is 0.8 million rays, so that the slowest format, EXR, is not busy with one band for
/// as long as Ctrl-C may take.
const BAND_BYTES: u64 = 16 << 20;

/// How a picture is cut into bands, and what that costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// The file's format.
    pub format: Format,
    /// How it is written.
    pub options: PictureOptions,
    /// How its pixels get their colours, with an epsilon of 0 unless it is changed.
    pub style: Style,
    /// The part of [`Hits`] that it needs.
    pub wants: Outputs,
    /// Rows of a band; the last one may have fewer.
    pub n_band_rows: u32,
    /// Memory for the hits of a band and for writing it.
    pub bytes: u64,
}

/// Steps of drawing `pixels` that [`Control`] counts: a ray is one, and so is the light on it.
pub fn n_steps(pixels: &Pixels, samples: Samples, is_lit: bool) -> u64 {
    let (n_pixels, n_samples) = (pixels.len() as u64, u64::from(samples.of_pixel()));
    let n_rays = if n_samples > 1 { 1 + n_samples } else { 1 };
    n_pixels * (n_rays + if is_lit { n_samples } else { 0 })
}

/// Rows of a band for `pixels`: as many as 16 MiB of [`Hits`] hold, and at least one.
pub fn band_rows(pixels: &Pixels, wants: Outputs) -> u32 {
    let row_bytes = Hits::bytes(u64::from(pixels.width), wants).max(1);
    let n_rows = u32::try_from(BAND_BYTES / row_bytes).unwrap_or(u32::MAX);
    n_rows.clamp(1, pixels.height.max(1))
}

/// [`band_rows`], and so few that the ids of all samples fit as well.
pub fn sampled_band_rows(pixels: &Pixels, samples: Samples, wants: Outputs) -> u32 {
    let n_rows = band_rows(pixels, wants);
    let n_samples = samples.across();
    if n_samples == 1 {
        return n_rows;
    }
    let of_samples = band_rows(&pixels.samples(n_samples), Outputs::default());
    n_rows.min(of_samples / n_samples).max(1)
}

/// Bytes for pixels of a scene of `n_objects` objects: their hits, those of their samples, colours and coverage.
pub(crate) fn band_bytes(band: &Pixels, style: &Style, wants: Outputs, n_objects: usize) -> u64 {
    let n_pixels = u64::from(band.width) * u64::from(band.height);
    let n_each = if style.n_samples > Samples::ONE { style.n_samples.of_pixel().into() } else { 0 };
    let coverage = if style.background == Background::Shown { 0 } else { size_of::<u16>() as u64 };
    Hits::bytes(n_pixels, wants)
        .saturating_add(Hits::bytes(n_pixels.saturating_mul(n_each), Outputs::default()))
        .saturating_add(Palette::bytes(style.encoding, n_objects, n_pixels))
        .saturating_add(n_pixels.saturating_mul(coverage))
}

/// Plans the bands of a picture of `n_objects` objects so that they fit the memory that is
/// `available`. Allocates nothing.
///
/// # Errors
/// Those of [`writer_bytes`], and [`Error::TooLarge`] when a band of one row is too much.
pub fn plan(
    format: Format,
    options: PictureOptions,
    n_samples: Samples,
    pixels: &Pixels,
    n_objects: usize,
    available: Available,
) -> Result<Plan> {
    let encoding = format.encoding(options.bits);
    let background = match (options.transparent, encoding) {
        (false, _) => Background::Shown,
        (true, Encoding::Linear) => Background::Black,
        (true, Encoding::Srgb8 | Encoding::Srgb16) => Background::LeftOut,
    };
    let style = Style { n_samples, background, ..Style::new(encoding) };
    let wants = format.wants(options.certificates);
    let n_band_rows = sampled_band_rows(pixels, n_samples, wants);
    let mut plan = Plan { format, options, style, wants, n_band_rows, bytes: 0 };
    loop {
        let band = pixels.rows(0, plan.n_band_rows);
        let writer = writer_bytes(format, options, pixels, plan.n_band_rows)?;
        plan.bytes = band_bytes(&band, &style, wants, n_objects).saturating_add(writer);
        if plan.bytes <= available.bytes {
            return Ok(plan);
        }
        if plan.n_band_rows == 1 {
            let text = format!(
                "writing a {format} picture {} pixels wide needs {} KiB of memory, but only {} KiB are available {}",
                pixels.width,
                plan.bytes.div_ceil(1 << 10),
                available.bytes >> 10,
                available.limit
            );
            let hint =
                Hint::new("free some, or render narrower parts with {}", [Setting::named("crop")]);
            return Err(Error::TooLarge(Message::new(text, hint)));
        }
        plan.n_band_rows /= 2;
    }
}

/// The bands of a rectangle of pixels, from top to bottom.
pub fn bands(pixels: &Pixels, n_band_rows: u32) -> impl Iterator<Item = Pixels> {
    let pixels = *pixels;
    let n_band_rows = n_band_rows.max(1);
    (0..pixels.height)
        .step_by(n_band_rows as usize)
        .map(move |first| pixels.rows(first, n_band_rows.min(pixels.height - first)))
}

/// Keeps the picture in memory.
impl Sink for Framebuffer {
    fn band(&mut self, rows: &Framebuffer, _: u32) -> Result<()> {
        self.hits.append(&rows.hits);
        self.colors.append(&rows.colors);
        if let Some(coverage) = &rows.coverage {
            self.coverage.get_or_insert_default().append(coverage);
        }
        Ok(())
    }
}

/// Forgets what it takes: for measuring.
impl Sink for () {
    fn band(&mut self, _: &Framebuffer, _: u32) -> Result<()> {
        Ok(())
    }
}

/// Traces and shades `pixels` band by band and hands over each band as soon as it is there. The caller
/// ends a file with [`PictureWriter::finish`](crate::picture::PictureWriter::finish).
///
/// # Errors
/// Those of [`Tracer::trace`](crate::tracer::Tracer::trace), [`Shading::paint`] and the sink; [`Error::Interrupted`] between bands as
/// well.
pub fn render(
    painter: &mut Shading,
    pixels: &Pixels,
    n_band_rows: u32,
    sink: &mut impl Sink,
    control: &Control,
) -> Result<RenderStats> {
    let mut rendered = RenderStats::default();
    let mut rows = Framebuffer::new(painter.encoding());
    for band in bands(pixels, n_band_rows) {
        control.check()?;
        let timing = painter.tracer().trace(&Rays::Pixels(band), control, &mut rows.hits)?;
        rendered.timing.add(timing);
        rendered.counts.add(rows.hits.counts);
        rendered.hits += rows.hits.n_hits();
        painter.paint(&band, &mut rows, control, &mut rendered)?;
        let start = Instant::now();
        sink.band(&rows, band.height)?;
        rendered.write += start.elapsed();
    }
    control.check()?;
    Ok(rendered)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;
    use std::time::Duration;

    use glam::DVec3;

    use super::*;
    use crate::kernel::Kernel;
    use crate::picture::{Metadata, PictureWriter};
    use crate::prepare::Prepared;
    use crate::query::Timing;
    use crate::rays::View;
    use crate::scene::{Camera, Color, Plane, Scene};
    use crate::support::memory::Limit;
    use crate::tracer::{Backend, Tracer};

    fn pixels(width: u32, height: u32) -> Pixels {
        let camera = Camera::new(DVec3::ZERO, DVec3::NEG_Z);
        Pixels::whole(View::new(&camera), width, height)
    }

    fn plane() -> Plane {
        Plane { name: None, point: DVec3::ZERO, normal: DVec3::Z, color: Color([1.0; 3]) }
    }

    /// Every pixel hits the object 1; the time is one microsecond a band.
    struct Wall {
        n_calls: u64,
        cancel_at: u64,
    }

    impl Backend for Wall {
        fn propose(
            &mut self,
            rays: &Rays,
            control: &Control,
            hits: &mut Hits,
        ) -> Result<Option<Timing>> {
            self.n_calls += 1;
            hits.make_room(rays.len(), Outputs::default())?;
            hits.id.fill(1);
            if self.n_calls == self.cancel_at {
                control.cancel();
            }
            Ok(Some(Timing { trace: Duration::from_micros(1), ..Timing::default() }))
        }
        fn retarget(&mut self, _: &Arc<Prepared>) -> Result<()> {
            Ok(())
        }
        fn bytes(&self) -> u64 {
            0
        }
    }

    fn room(bytes: u64) -> Available {
        Available { bytes, limit: Limit::Machine }
    }

    #[test]
    fn bands_cover_the_rectangle_once_in_order() {
        let mut pixels = pixels(100, 50);
        (pixels.x, pixels.y, pixels.width, pixels.height) = (3, 7, 40, 23);
        let bands: Vec<_> = bands(&pixels, 10).map(|band| (band.x, band.y, band.height)).collect();
        assert_eq!(bands, [(3, 7, 10), (3, 17, 10), (3, 27, 3)]);
    }

    #[test]
    fn common_pictures_are_one_band_and_large_ones_are_bounded() {
        let surface = Outputs { surface: true, level: false };
        assert_eq!(band_rows(&pixels(1920, 1080), Outputs::default()), 1080);
        assert_eq!(band_rows(&pixels(1920, 1080), surface), 436);
        let huge = pixels(32768, 32768);
        assert_eq!(band_rows(&huge, Outputs::default()), 128);
        for format in Format::ALL {
            let plan =
                plan(format, PictureOptions::default(), Samples::ONE, &huge, 9, room(u64::MAX))
                    .unwrap();
            assert!(plan.bytes < 256 << 20, "{format}: {plan:?}");
        }
    }

    #[test]
    fn little_memory_means_small_bands_and_too_little_is_refused() {
        let pixels = pixels(1000, 1000);
        let plan = |bytes| {
            plan(Format::Exr, PictureOptions::default(), Samples::ONE, &pixels, 9, room(bytes))
        };
        let all = plan(u64::MAX).unwrap();
        assert_eq!(all.n_band_rows, 838);
        let half = plan(all.bytes / 2).unwrap();
        assert!(half.n_band_rows < 838 && half.bytes <= all.bytes / 2, "{half:?}");
        let error = plan(100_000).unwrap_err();
        assert_eq!(error.exit_code(), 7);
        assert!(error.to_string().contains("only 97 KiB are available"), "{error}");
    }

    #[test]
    fn sums_are_of_all_bands_and_a_cancelled_run_stops_between_two() {
        let pixels = pixels(10, 25);
        let scene = Scene { planes: vec![plane()], ..Scene::default() };
        let scene = Arc::new(scene);
        let prepared = Prepared::new(scene, Kernel::Lecture, &Rays::Pixels(pixels)).unwrap();
        let style = Style::new(Encoding::Srgb8);
        let prepared = Arc::new(prepared);
        let draw = |cancel_at| {
            let wall = Wall { n_calls: 0, cancel_at };
            let mut tracer = Tracer::on(wall, Arc::clone(&prepared), Outputs::default());
            let mut palette = None;
            let mut painter = Shading::new(style, &pixels, &mut palette, &mut tracer, None);
            let (options, sink) = (PictureOptions::default(), std::io::Cursor::new(Vec::new()));
            let mut writer = PictureWriter::create(
                Format::Ppm,
                options,
                &pixels,
                &Metadata::default(),
                sink,
                "memory",
            )?;
            let control = Control::default();
            let rendered = render(&mut painter, &pixels, 10, &mut writer, &control)?;
            writer.finish()?;
            Ok(rendered)
        };
        let rendered = draw(u64::MAX).unwrap();
        assert_eq!((rendered.hits, rendered.counts.total()), (250, 250));
        assert_eq!(rendered.timing.trace, Duration::from_micros(3));
        for cancel_at in [1, 3] {
            let result: Result<RenderStats> = draw(cancel_at);
            assert!(matches!(result, Err(Error::Interrupted)), "{cancel_at}");
        }
    }
}
