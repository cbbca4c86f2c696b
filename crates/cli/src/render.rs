//! `kugelblitz render`

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use kugelblitz::device::rays_of_picture;
use kugelblitz::output::OutputFile;
use kugelblitz::picture::{ChannelBits, Format, PictureOptions};
use kugelblitz::plain::Shown;
use kugelblitz::prepare::Prepared;
use kugelblitz::query::{Kernel, Rays};
use kugelblitz::rays::Pixels;
use kugelblitz::render::{self, Plan};
use kugelblitz::scene::{Samples, Scene, SceneOverrides};
use kugelblitz::support::memory::Available;
use kugelblitz::{Error, Result, Session};
use kugelblitz_judge::figure::legend_svg;
use kugelblitz_judge::show::{self, Entry, Show};

use crate::args::RenderArgs;
use crate::device;
use crate::head::{Done, Drawn, StageTimes, Traced, WorkSummary, traced_in_words};
use crate::output::{check_ending, refuse_overwriting, written};
use crate::picture::read_composed;
use crate::progress::Progress;
use crate::show::check;
use crate::{Run, film, wrong_usage};

/// Renders one picture or several, or only prints the scene.
pub fn run(args: &RenderArgs, run: &Run) -> Result<()> {
    let n_turns = args.film.n_turns();
    let overrides = args.picture.overrides(args.size.whole.size)?;
    let overrides = SceneOverrides { n_turns, ..overrides };
    let Some(output) = &args.output else {
        return args.picture.print_alone(&args.scene, &overrides, run);
    };
    let begun = Begun::new(args, output, &overrides, run)?;
    if args.film.is_film() {
        film::run(args, output, begun, run)?.finish("render", run)
    } else {
        picture(args, output, begun, run)?.finish("render", run)
    }
}

fn picture(args: &RenderArgs, output: &Path, begun: Begun, run: &Run) -> Result<Done<Traced>> {
    let pixels = begun.pixels;
    begun.refuse_overwriting(args, output)?;
    // Early, so that a folder that isn't there is told before the work and not after it.
    let file = OutputFile::create(output, begun.format.needs_seek())?;

    let mut session = begun.session(args, run)?;
    let wants = match args.show {
        Show::Color => begun.plan()?.wants,
        show => show.wants(),
    };
    let making = Progress::of_preparing(run, &begun.scene, session.kernel())
        .during(|| session.make_ready(&Rays::Pixels(pixels), wants, &run.control))?;
    if session.prepared().is_some_and(Prepared::starts_in_f64) {
        run.note("f32 would leave most of these rays open: all begin in f64");
    }
    // Again: the scene's numbers have their memory by now.
    let plan = begun.plan()?;
    let progress = Progress::start(run, begun.n_steps);
    let (rendered, shown, file) = match args.show {
        Show::Color => {
            let (rendered, file) = session.draw(&pixels, &plan, file, &run.control)?;
            (rendered, None, file)
        }
        show => {
            let (shown, file) = show::draw(&mut session, show, &pixels, &plan, file, &run.control)?;
            (shown.rendered, Some(shown), file)
        }
    };
    drop(progress);

    let is_flat =
        begun.n_samples == Samples::ONE && !begun.scene.is_lit() && !plan.options.transparent;
    let again = || {
        let Plan { style, wants, n_band_rows, .. } = plan;
        let done =
            session.render_into(&pixels, style, wants, n_band_rows, &mut (), &run.control)?;
        let mut times = StageTimes::from(&done);
        // Flat colours count only with the first picture.
        times.shade = times.shade.filter(|_| !is_flat);
        Ok(times)
    };
    let ms_runs = args
        .repeat
        .map(|n| std::iter::repeat_with(again).take(n as usize).collect::<Result<Vec<_>>>())
        .transpose()?;

    let is_lit = begun.scene.is_lit() && shown.is_none();
    let shows_nothing = rendered.hits == 0;
    let drawn = Drawn::new(&rendered, making, Some(begun.read), run.start.elapsed(), is_lit);
    let summary = Traced {
        work: WorkSummary::new(&session, Some(([pixels.width, pixels.height], begun.n_samples))),
        drawn,
        show: shown.as_ref().map(|_| args.show.name()),
        legend: shown.map(|shown| shown.legend),
        bytes_device: session.bytes_device(),
        ms_runs,
    };
    let lines: Vec<String> = summary.legend.iter().flatten().map(Entry::to_string).collect();
    let line = format!("{}, {}", size(&pixels), traced_in_words(&session, run));
    let times = format!("note: {}", summary.drawn.ms);
    let mut done = Done::with_file(summary, begun.beside, file, &line);
    done.said.extend(lines);
    if shows_nothing {
        // A pixel's centre may miss what its samples hit.
        done.said.push(
            "note: no object is at the centre of a pixel: objects may be too small, or not in view"
                .into(),
        );
    }
    done.said.extend(run.talk.verbose.then_some(times));
    Ok(done)
}

/// A picture, or the first of several, that is known but not begun.
pub struct Begun {
    pub scene: Arc<Scene>,
    /// Time that reading took.
    pub read: Duration,
    pub pixels: Pixels,
    pub n_samples: Samples,
    /// What is traced, for the choice of a device.
    n_rays: usize,
    /// Steps of drawing it that [`Control`](kugelblitz::Control) counts.
    pub n_steps: u64,
    pub format: Format,
    /// The files of --print-scene and --legend.
    pub beside: Vec<OutputFile>,
    options: PictureOptions,
    epsilon: f64,
}

impl Begun {
    /// Reads the scene and checks all that is asked for.
    fn new(
        args: &RenderArgs,
        output: &PathBuf,
        overrides: &SceneOverrides,
        run: &Run,
    ) -> Result<Begun> {
        let (format, options) = what_to_write(args, output, run)?;
        if args.epsilon.is_some() && args.kernel.kernel == Kernel::Certified {
            return wrong_usage(
                "--epsilon is for kernels without a proof: certified decides exactly what is in a light's \
                 way, and needs none; leave it out, or choose another --kernel",
            );
        }
        let start = Instant::now();
        let (scene, composed) = read_composed(&args.scene, overrides, run)?;
        let pixels = args.size.pixels(&scene, &args.scene)?;
        let read = start.elapsed();
        if args.epsilon.is_some() && !scene.is_lit() {
            run.warn("--epsilon changes nothing: the scene has no light");
        }
        let n_pixels = pixels.len();
        let (n_samples, n_rays, n_steps) = match args.show {
            Show::Color => {
                let n = scene.samples.unwrap_or_default();
                let n_steps = render::n_steps(&pixels, n, scene.is_lit());
                (n, rays_of_picture(&scene, n_pixels, n), n_steps)
            }
            show => (Samples::ONE, n_pixels, show::n_steps(show, &pixels)),
        };
        let mut begun = Begun {
            scene,
            read,
            pixels,
            n_samples,
            n_rays,
            n_steps,
            format,
            beside: Vec::new(),
            options,
            epsilon: args.epsilon.unwrap_or(0.0),
        };
        begun.plan()?;
        begun.beside.extend(args.picture.print(&composed, &begun.scene, &args.scene)?);
        if let Some(path) = &args.legend {
            begun.beside.push(write_legend(path, args, &begun.scene)?);
        }
        Ok(begun)
    }

    /// Refuses an output that would replace what it is made from, or what is beside it.
    ///
    /// # Errors
    /// [`Error::Usage`]
    pub fn refuse_overwriting(&self, args: &RenderArgs, output: &Path) -> Result<()> {
        let outputs = [output].into_iter().chain(self.beside.iter().map(OutputFile::path));
        refuse_overwriting(outputs, [&args.scene], &self.scene)
    }

    /// The bands that fit the memory as it is.
    ///
    /// # Errors
    /// Those of [`render::plan`].
    pub fn plan(&self) -> Result<Plan> {
        let (n_objects, available) = (self.scene.n_objects(), Available::now());
        let Begun { format, options, n_samples, ref pixels, .. } = *self;
        let mut plan = render::plan(format, options, n_samples, pixels, n_objects, available)?;
        plan.style.epsilon = self.epsilon;
        Ok(plan)
    }

    /// Opens the device.
    ///
    /// # Errors
    /// Those of [`device::session`].
    pub fn session(&self, args: &RenderArgs, run: &Run) -> Result<Session> {
        device::session(&args.device, args.kernel.kernel, &self.scene, self.n_rays, run)
    }
}

/// The legend, whole but not yet in its place.
fn write_legend(path: &Path, args: &RenderArgs, scene: &Scene) -> Result<OutputFile> {
    check_ending(path, "svg", "a legend is")?;
    let colorings = scene.clouds.iter().filter_map(|cloud| cloud.coloring.as_ref());
    let svg = legend_svg(colorings).ok_or_else(|| {
        Error::Usage(format!(
            "--legend: no cloud of {} is coloured by a column; say which, e.g. `color_by = \"speed\"` \
             in its [[spheres]]",
            args.scene.shown()
        ).into())
    })?;
    written(path, svg.as_bytes())
}

/// The format and its options, checked against each other.
fn what_to_write(
    args: &RenderArgs,
    output: &PathBuf,
    run: &Run,
) -> Result<(Format, PictureOptions)> {
    let by_ending = Format::from_path(output);
    let format = match (args.format, by_ending) {
        (None, by_ending) => by_ending?,
        (Some(format), Ok(ending)) if ending != format => {
            return wrong_usage(format!(
                "{}: the name's ending says {ending}, but --format says {format}; change one of \
                 them",
                output.shown()
            ));
        }
        (Some(format), _) => format,
    };
    let outputs = [(output, "the picture")].into_iter().chain(args.picture.printed());
    run.refuse_sharing_stdout(outputs)?;
    let holds_numbers = format.holds_numbers();
    if args.certificates && !holds_numbers {
        return wrong_usage(format!(
            "{format} has no place for --certificates; write .exr or .npy"
        ));
    }
    let bits = match args.bits.as_deref() {
        Some(bits) if holds_numbers => {
            return wrong_usage(format!(
                "--bits {bits} is for png and ppm; {format} always holds 32-bit floats"
            ));
        }
        Some("16") => ChannelBits::Sixteen,
        _ => ChannelBits::Eight,
    };
    let (certificates, transparent) = (args.certificates, args.transparent);
    let options = PictureOptions { bits, certificates, transparent };
    options.check(format)?;
    check(args, format, options)?;
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
