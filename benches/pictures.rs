//! Writing pictures into memory.

use std::io::Cursor;
use std::sync::Arc;

use criterion::Throughput;
use kugelblitz::Control;
use kugelblitz::Result;
use kugelblitz::lighting::{Framebuffer, Palette, Style};
use kugelblitz::picture::{Format, Metadata, PictureOptions, PictureWriter, Sink};
use kugelblitz::prepare::Prepared;
use kugelblitz::query::{Hits, Kernel, Outputs, Rays};
use kugelblitz::rays::Pixels;
use kugelblitz::scene::Scene;
use kugelblitz::tracer::Tracer;

use kugelblitz_benches::{Candidate, compare, criterion, figure};

fn write(
    format: Format,
    pixels: &Pixels,
    scene: &Scene,
    rows: &mut Framebuffer,
) -> Result<Vec<u8>> {
    let options = PictureOptions::default();
    let style = Style::new(format.encoding(options.bits));
    Palette::new(scene, &style).shade(&rows.hits.id, &mut rows.colors)?;
    let sink = Cursor::new(Vec::new());
    let mut writer =
        PictureWriter::create(format, options, pixels, &Metadata::default(), sink, "memory")?;
    writer.band(rows, pixels.height)?;
    Ok(writer.finish()?.into_inner())
}

fn main() -> Result<()> {
    let (scene, pixels) = figure("figure1.toml", [1280, 720])?;
    let (scene, rays) = (Arc::new(scene), Rays::Pixels(pixels));
    let prepared = Arc::new(Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays)?);
    let (wants, mut hits) = (Outputs { surface: true, level: false }, Hits::default());
    Tracer::on_cpu(prepared, wants).trace(&rays, &Control::default(), &mut hits)?;

    let (pixels, scene, hits) = (&pixels, &*scene, &hits);
    let candidate = |format: Format| -> Result<Candidate> {
        let encoding = format.encoding(PictureOptions::default().bits);
        let mut rows = Framebuffer { hits: hits.clone(), ..Framebuffer::new(encoding) };
        write(format, pixels, scene, &mut rows)?;
        let n_pixels = Throughput::Elements(pixels.len() as u64);
        let work = move || write(format, pixels, scene, &mut rows);
        Ok(Candidate::new(format.name(), n_pixels, work))
    };
    let others = [Format::Png, Format::Exr, Format::Npy].map(candidate);
    let others = others.into_iter().collect::<Result<_>>()?;
    let mut criterion = criterion();
    compare(&mut criterion, "writing a picture", candidate(Format::Ppm)?, others)?;
    criterion.final_summary();
    Ok(())
}
