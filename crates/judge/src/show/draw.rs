//! Pictures of what a mode shows, into files and into memory.

use std::time::{Duration, Instant};

use kugelblitz::Control;
use kugelblitz::lighting::{Colors, Encoding, Framebuffer, Pixel, RenderStats, Style};
use kugelblitz::output::OutputFile;
use kugelblitz::picture::{Metadata, PictureWriter, Sink};
use kugelblitz::query::{Hits, Kernel, Outputs, Rays};
use kugelblitz::rays::Pixels;
use kugelblitz::render::{Plan, band_rows, bands};
use kugelblitz::scene::Samples;
use kugelblitz::{Result, Session};

use super::{Entry, Rgb, Show, tints};

/// What a mode shows of a picture, as far as it is painted: band by band, by [`ShownPicture::paint`].
#[derive(Clone, Debug)]
pub struct ShownPicture {
    /// Rays, hits and times.
    pub rendered: RenderStats,
    /// What the colours mean, and the pixels of each meaning.
    pub legend: Vec<Entry>,
    show: Show,
    range: Option<[f32; 2]>,
    /// The last band, whose colours [`draw`] has.
    rows: Framebuffer,
}

impl ShownPicture {
    /// Nothing yet of a picture whose `t` have this range.
    pub fn new(show: Show, range: Option<[f32; 2]>) -> ShownPicture {
        let (rendered, legend) = (RenderStats::default(), Entry::all(show, range));
        ShownPicture { rendered, legend, show, range, rows: Framebuffer::new(Encoding::Srgb8) }
    }

    /// The colours of a band; those of [`Show::Color`] are the objects' own, without light.
    ///
    /// # Errors
    /// Those of [`Session::trace`]; [`Error::Interrupted`](kugelblitz::Error::Interrupted) when `control` was cancelled.
    pub fn paint(
        &mut self,
        session: &mut Session,
        band: &Pixels,
        control: &Control,
    ) -> Result<Vec<Rgb>> {
        control.check()?;
        // The picture shows numbers in world units.
        session.keep_world_units();
        let ShownPicture { rendered, legend, rows: Framebuffer { hits, .. }, .. } = self;
        let timing = session.trace(&Rays::Pixels(*band), self.show.wants(), control, hits)?;
        rendered.timing.add(timing);
        rendered.counts.add(hits.counts);
        rendered.hits += hits.n_hits();
        let start = Instant::now();
        let tints = match session.prepared() {
            Some(prepared) => tints(self.show, prepared, band, hits, self.range, control)?,
            None => Vec::new(),
        };
        Entry::count(legend, band, &tints);
        let colors = tints.into_iter().map(|tint| tint.color).collect();
        rendered.shade += start.elapsed();
        Ok(colors)
    }

    /// The colours of all of a picture, in memory.
    fn paint_all(
        &mut self,
        session: &mut Session,
        pixels: &Pixels,
        control: &Control,
    ) -> Result<Vec<Rgb>> {
        let wants = self.show.wants();
        let n_rows = band_rows(pixels, wants);
        let mut colors = Vec::new();
        for band in bands(pixels, n_rows) {
            colors.extend(self.paint(session, &band, control)?);
        }
        control.check()?;
        Ok(colors)
    }
}

/// Steps of drawing `pixels` that [`Control`] counts.
pub fn n_steps(show: Show, pixels: &Pixels) -> u64 {
    let n_pixels = pixels.len() as u64;
    match show {
        Show::Depth => n_pixels + pixels.picture().len() as u64,
        Show::Error => 2 * n_pixels,
        _ => n_pixels,
    }
}

/// Draws what `show` shows of `pixels` into `file`, band by band. `plan` is for PNG or PPM. The file is then
/// whole, but not in its place: that takes [`output::commit`](kugelblitz::output::commit).
///
/// # Errors
/// Those of [`Show::check`], [`ShownPicture::paint`] and [`Sink::band`].
pub fn draw(
    session: &mut Session,
    show: Show,
    pixels: &Pixels,
    plan: &Plan,
    file: OutputFile,
    control: &Control,
) -> Result<(ShownPicture, OutputFile)> {
    let Plan { format, options, .. } = *plan;
    show.check(format, options)?;
    let path = file.path().to_owned();
    let mut writer =
        PictureWriter::create(format, options, pixels, &Metadata::default(), file, path)?;
    let mut write = Duration::ZERO;
    let mut shown = ShownPicture::new(show, range_of_t(None, session, show, pixels, control)?);
    for band in bands(pixels, plan.n_band_rows.min(band_rows(pixels, show.wants()))) {
        shown.rows.colors = Colors::Srgb8(shown.paint(session, &band, control)?);
        let start = Instant::now();
        writer.band(&shown.rows, band.height)?;
        write += start.elapsed();
    }
    control.check()?;
    let start = Instant::now();
    let file = writer.finish()?;
    shown.rendered.write = write + start.elapsed();
    Ok((shown, file))
}

/// What `show` shows of `pixels`, in memory.
///
/// # Errors
/// [`Error::TooLarge`](kugelblitz::Error::TooLarge) where it does not fit; those of [`ShownPicture::paint`].
pub fn keep(
    session: &mut Session,
    show: Show,
    pixels: &Pixels,
    control: &Control,
) -> Result<(ShownPicture, Vec<Rgb>)> {
    let mut shown = ShownPicture::new(show, range_of_t(None, session, show, pixels, control)?);
    let colors = shown.paint_all(session, pixels, control)?;
    Ok((shown, colors))
}

/// The smallest and the largest `t` of the whole picture that `pixels` are a part of, so that each part has
/// the whole one's colours, and of the range that is `known` of others; `None` where nothing is hit, or `show` does not ask.
///
/// # Errors
/// Those of [`Session::trace`].
pub fn range_of_t(
    known: Option<[f32; 2]>,
    session: &mut Session,
    show: Show,
    pixels: &Pixels,
    control: &Control,
) -> Result<Option<[f32; 2]>> {
    if show != Show::Depth {
        return Ok(None);
    }
    let (whole, mut hits, mut range) = (pixels.picture(), Hits::default(), known);
    for band in bands(&whole, band_rows(&whole, show.wants())) {
        control.check()?;
        session.trace(&Rays::Pixels(band), show.wants(), control, &mut hits)?;
        for &t in hits.t.iter().filter(|t| t.is_finite() && **t > 0.0) {
            let [low, high] = range.unwrap_or([t; 2]);
            range = Some([low.min(t), high.max(t)]);
        }
    }
    Ok(range)
}

/// The colours of `pixels` in memory: the first `split` columns by one kernel, the others by another. With
/// `n_samples` × `n_samples` samples a pixel where `show` is [`Show::Color`].
///
/// # Errors
/// [`Error::TooLarge`](kugelblitz::Error::TooLarge) where they do not fit the memory; those of [`Session::keep`] and
/// [`ShownPicture::paint`].
pub fn side_by_side(
    session: &mut Session,
    show: Show,
    pixels: &Pixels,
    (kernels, split): ([Kernel; 2], u32),
    n_samples: Samples,
    control: &Control,
) -> Result<Vec<Rgb>> {
    let mut colors = vec![[0; 3]; pixels.len()];
    let split = split.min(pixels.width);
    let halves = [
        Pixels { width: split, ..*pixels },
        Pixels { x: pixels.x + split, width: pixels.width - split, ..*pixels },
    ];
    let mut range = None;
    for kernel in kernels {
        session.set_kernel(kernel);
        range = range_of_t(range, session, show, pixels, control)?;
    }
    for (half, kernel) in halves.iter().zip(kernels).filter(|(half, _)| half.width > 0) {
        session.set_kernel(kernel);
        let of_half = if show == Show::Color {
            let style = Style { n_samples, ..Style::new(Encoding::Srgb8) };
            Pixel::all(session.keep(half, style, Outputs::default(), control)?.0.colors)?
        } else {
            ShownPicture::new(show, range).paint_all(session, half, control)?
        };
        let (first, n) = ((half.x - pixels.x) as usize, half.width as usize);
        let rows = colors.chunks_exact_mut(pixels.width as usize);
        for (row, of_half) in rows.zip(of_half.chunks_exact(n)) {
            row[first..][..n].copy_from_slice(of_half);
        }
    }
    Ok(colors)
}

#[cfg(test)]
mod tests {
    use kugelblitz::device::Device;
    use kugelblitz::picture::{Format, PictureOptions};
    use kugelblitz::render::plan;
    use kugelblitz::scene::parse_scene;
    use kugelblitz::support::memory::Available;

    use super::*;

    fn session() -> (Session, Pixels) {
        let text = include_str!("../../../../scenes/hard/far_1e8.toml");
        let scene = parse_scene(text, "far.toml".as_ref()).unwrap();
        let session = Session::new(scene, Device::Cpu, Kernel::Certified);
        let pixels = session.pixels(96, 60).unwrap();
        (session, pixels)
    }

    /// PPM bytes without their head, with bands of so many rows.
    fn drawn(
        session: &mut Session,
        show: Show,
        pixels: &Pixels,
        n_rows: u32,
    ) -> (Vec<Rgb>, ShownPicture) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ppm");
        let (options, available) = (PictureOptions::default(), Available::now());
        let plan = plan(Format::Ppm, options, Samples::ONE, pixels, 9, available).unwrap();
        let plan = Plan { n_band_rows: n_rows, ..plan };
        let file = OutputFile::create(&path, false).unwrap();
        let control = Control::default();
        let (shown, file) = draw(session, show, pixels, &plan, file, &control).unwrap();
        kugelblitz::output::commit([file], &control).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        let colors = &bytes[bytes.len() - 3 * pixels.len()..];
        (colors.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(), shown)
    }

    fn modes() -> impl Iterator<Item = Show> {
        Show::ALL.into_iter().filter(|show| *show != Show::Color)
    }

    #[test]
    fn bands_and_parts_have_the_whole_pictures_colours() {
        let (mut session, whole) = session();
        let part = Pixels { x: 20, y: 11, width: 40, height: 31, ..whole };
        // The stage may differ between a picture and its parts.
        for show in modes().filter(|show| *show != Show::Stage) {
            let (colors, shown) = drawn(&mut session, show, &whole, 60);
            let (in_bands, again) = drawn(&mut session, show, &whole, 7);
            assert!(colors == in_bands, "{show}");
            assert_eq!(shown.legend, again.legend, "{show}");
            let (of_part, _) = drawn(&mut session, show, &part, 9);
            let at = |i: usize| colors[(11 + i / 40) * 96 + 20 + i % 40];
            assert!((0..of_part.len()).all(|i| of_part[i] == at(i)), "{show}");
            assert!(colors.iter().any(|color| *color != colors[0]), "{show} shows something");
        }
    }

    #[test]
    fn two_kernels_are_drawn_side_by_side() {
        let (mut session, pixels) = session();
        let kernels = [Kernel::Lecture, Kernel::Certified];
        for show in Show::ALL {
            let control = Control::default();
            let mut both = |kernels, split| {
                side_by_side(&mut session, show, &pixels, (kernels, split), Samples::ONE, &control)
                    .unwrap()
            };
            let halves = both(kernels, 30);
            // Depth has one scale for both kernels.
            let [left, right] = match show {
                Show::Depth => [both(kernels, 96), both(kernels, 0)],
                _ => kernels.map(|kernel| both([kernel; 2], 48)),
            };
            for (i, color) in halves.iter().enumerate() {
                let expected = if i % 96 < 30 { left[i] } else { right[i] };
                assert_eq!(*color, expected, "{show}, {i}");
            }
            assert!(left != right || show == Show::Stage, "{show} tells the kernels apart");
        }
    }
}
