//! `kugelblitz render`

use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use kugelblitz::memory::Available;
use kugelblitz::output::{self, OutputFile};
use kugelblitz::picture::{Bits, Format, PictureOptions};
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::Pixels;
use kugelblitz::render::{self, Plan};
use kugelblitz::scene::{Scene, legend_svg};
use kugelblitz::trace::{Kernel, Rays};
use kugelblitz::{Error, Result, Session};

use super::device;
use super::head::{MsStages, Traced, print_summary, traced_in_words};
use super::output::{built, human, name};
use super::progress::Progress;
use super::{RenderArgs, Run, scene};

/// Renders one picture.
pub fn run(args: &RenderArgs, run: &Run) -> Result<()> {
    let (format, options) = what_to_write(args)?;
    let epsilon = epsilon(args)?;

    let start = Instant::now();
    let scene = scene::read(&args.scene, &args.talk, run)?;
    let pixels = args.size.pixels(&scene, &args.scene)?;
    let read = start.elapsed();
    if args.epsilon.is_some() && !scene.is_lit() {
        args.talk.warn("--epsilon changes nothing: the scene has no light");
    }
    let n_samples = args.samples.or(scene.samples).unwrap_or(1);
    let plan = || {
        let (n_objects, available) = (scene.n_objects(), Available::now());
        let plan = render::plan(format, options, n_samples, &pixels, n_objects, available)?;
        Ok::<_, Error>(Plan { epsilon, ..plan })
    };
    let wants = plan()?.wants();
    let outputs: Vec<&Path> =
        [&args.output].into_iter().chain(&args.legend).map(|p| &**p).collect();
    scene::refuse_overwriting(&outputs, &[&args.scene], &scene)?;
    let legend = args.legend.as_deref().map(|path| write_legend(path, args, &scene)).transpose()?;
    // Early, so that a folder that isn't there is told before the work and not after it.
    let file = OutputFile::create(&args.output, format.needs_seek())?;

    let kernel = args.kernel.kernel;
    let (choice, n_rays) = (&args.device.device, pixels.len());
    let device = device::open_for(choice, kernel, &scene, n_rays, &args.talk)?;
    let mut session = Session::new(Arc::clone(&scene), device, kernel);
    let progress = scene::preparing(&scene, kernel, &args.talk);
    let making = session.make_ready(&Rays::Pixels(pixels), wants, &run.control)?;
    drop(progress);
    if session.prepared().is_some_and(Prepared::starts_in_f64) {
        args.talk.note("f32 would leave most of these rays open: all begin in f64");
    }
    // Again: the scene's numbers have their memory by now.
    let plan = plan()?;
    let progress = Progress::start(&args.talk, &run.control, plan.n_steps(&pixels, scene.is_lit()));
    let (rendered, file) = session.draw(&pixels, &plan, file, &run.control)?;
    drop(progress);

    let again =
        || session.draw_nothing(&pixels, &plan, &run.control).map(|done| MsStages::again(&done));
    let ms_runs = args
        .repeat
        .map(|n| std::iter::repeat_with(again).take(n as usize).collect::<Result<Vec<_>>>())
        .transpose()?;

    if args.talk.json {
        let mut summary = Traced::new(&session, read, making, &rendered, run);
        summary.size = Some([pixels.width, pixels.height]);
        summary.samples = (n_samples > 1).then_some(n_samples);
        summary.shadow_rays = scene.is_lit().then(|| rendered.shadow_rays.into());
        summary.colors = scene.is_lit().then_some(rendered.colors);
        summary.ms_runs = ms_runs;
        print_summary("render", &summary)?;
    }
    output::commit([file].into_iter().chain(legend), &run.control)?;
    args.talk.say(&format!(
        "{}: {}, {}",
        name(&args.output),
        size(&pixels),
        traced_in_words(&session, making, rendered.timing)
    ));
    args.talk.note(&format!(
        "read {}, prepared {}, {}compiled {}, wrote {}, all in {}",
        human(read),
        human(making.prepare),
        built(making.build),
        human(making.compile),
        human(rendered.write),
        human(run.start.elapsed())
    ));
    Ok(())
}

/// The legend, whole but not yet in its place.
fn write_legend(path: &Path, args: &RenderArgs, scene: &Scene) -> Result<OutputFile> {
    if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("svg")) {
        let message = format!("{}: a legend is a picture of lines, .svg", path.display());
        return Err(Error::Usage(message));
    }
    let svg = legend_svg(&scene.clouds).ok_or_else(|| {
        Error::Usage(format!(
            "--legend: no cloud of {} is coloured by a column; say which, e.g. `color_by = \"speed\"` \
             in its [[spheres]]",
            args.scene.display()
        ))
    })?;
    let mut file = OutputFile::create(path, false)?;
    file.write_all(svg.as_bytes()).map_err(Error::io(path))?;
    Ok(file)
}

/// How far from a surface shadow rays start.
fn epsilon(args: &RenderArgs) -> Result<f64> {
    match args.epsilon {
        Some(_) if args.kernel.kernel == Kernel::Certified => Err(Error::Usage(
            "--epsilon is for kernels without a proof: certified decides exactly what is in a light's \
             way, and needs none; leave it out, or choose another --kernel"
                .into(),
        )),
        epsilon => Ok(epsilon.unwrap_or(0.0)),
    }
}

/// The format and its options, checked against each other.
fn what_to_write(args: &RenderArgs) -> Result<(Format, PictureOptions)> {
    let output = &args.output;
    let by_ending = Format::from_path(output);
    let format = match (args.format, by_ending) {
        (None, by_ending) => by_ending?,
        (Some(format), Ok(ending)) if ending != format => {
            return Err(Error::Usage(format!(
                "{}: the name's ending says {ending}, but --format says {format}; change one of \
                 them",
                output.display()
            )));
        }
        (Some(format), _) => format,
    };
    let advice = "write the picture to a file";
    args.talk.refuse_json_beside(&[output], "the picture", advice)?;
    let holds_colours_only = matches!(format, Format::Png | Format::Ppm);
    if args.certificates && holds_colours_only {
        return Err(Error::Usage(format!(
            "{format} has no place for --certificates; write .exr or .npy"
        )));
    }
    let bits = match args.bits.as_deref() {
        Some(bits) if !holds_colours_only => {
            return Err(Error::Usage(format!(
                "--bits {bits} is for png and ppm; {format} always holds 32-bit floats"
            )));
        }
        Some("16") => Bits::Sixteen,
        _ => Bits::Eight,
    };
    let (certificates, transparent) = (args.certificates, args.transparent);
    let options = PictureOptions { bits, certificates, transparent };
    options.check(format)?;
    Ok((format, options))
}

/// `1280×720`, and where it belongs if it is a part.
pub fn size(pixels: &Pixels) -> String {
    let Pixels { image_width, image_height, x, y, width, height, .. } = *pixels;
    if (width, height) == (image_width, image_height) {
        format!("{width}×{height}")
    } else {
        format!("{width}×{height} at {x},{y} of {image_width}×{image_height}")
    }
}
