//! `kugelblitz judge`

use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args, ValueEnum};
use kugelblitz::error::Message;
use kugelblitz::picture::{Image, read_image, read_rays};
use kugelblitz::plain::Shown;
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Kernel, Rays, WorldRay};
use kugelblitz::words::{count, joined};
use kugelblitz::{Error, Result};
use kugelblitz_judge::cost::ObjectCounts;
use kugelblitz_judge::judge::{
    Allowed, Case, Conventions, JudgeSummary, NormalSide, NormalSpace, Quantity, pixels_of,
    whole_size,
};
use serde::Serialize;

use crate::args::{DeviceArgs, SizeArgs, WholeArgs};
use crate::compare::{begin_picture, write_picture};
use crate::complain::option;
use crate::head::{Done, On};
use crate::options::number;
use crate::output::shell_quoted;
use crate::picture::{CameraArgs, DataArgs, GivenOptions, PictureArgs};
use crate::progress::Progress;
use crate::render::size;
use crate::{Run, device, wrong_usage};

/// Hold another renderer's picture or hits against exact arithmetic
///
/// FILE has ids, depths, normals, or the objects' own colours: an OpenEXR file with the channels id, Z or
/// N.X…, a structured NumPy array with the fields id, t, normal, a plain NumPy array (say with --as what it
/// tells), or a PNG of the unlit objects. Its size is the picture's. Each pixel is judged, at a silhouette
/// or away from it: it is at one where any of its eight neighbours sees another object. Exit code 6 beyond
/// --allow.
#[derive(Args)]
pub struct JudgeArgs {
    #[command(flatten)]
    given: GivenOptions,
    /// Scene file (TOML), or data: .npy, .csv, .xyz, LAMMPS dumps; `-` is standard input
    pub scene: PathBuf,
    /// The other renderer's picture or hits
    #[arg(long, value_name = "FILE")]
    pub against: PathBuf,
    /// What FILE tells: id, depth (along the view axis), distance (from the eye), zbuffer, normal, color;
    /// several with commas [default: what its channels' names say]
    #[arg(long = "as", value_name = "WHAT", value_delimiter = ',')]
    pub quantities: Vec<Quantity>,
    /// The channel or field of FILE that tells it, where the name doesn't; of normals what stands before .X
    #[arg(long, value_name = "NAME", requires = "quantities")]
    pub channel: Option<String>,
    /// FILE has hits of these rays: .npy, shape (N, 6), as for `trace`
    #[arg(long, value_name = "RAYS.npy", conflicts_with_all = ["size", "crop", "output"])]
    pub rays: Option<PathBuf>,
    /// Added to FILE's ids to make them count from 1, e.g. 1 for those of Embree
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub id_offset: i64,
    /// The id of the background [default: -1 and 4294967295, and what is 0 with --id-offset]
    #[arg(long, value_name = "ID", allow_negative_numbers = true)]
    pub no_hit: Option<i64>,
    /// The depth of the background, beside infinity: 0, 1e10, the far plane
    #[arg(long, value_name = "DEPTH", allow_negative_numbers = true)]
    pub background: Option<f64>,
    /// Length of FILE's unit of depth in the scene's: 0.001 for millimetres, -1 for depths below 0
    #[arg(long, value_name = "S", default_value_t = 1.0, allow_negative_numbers = true, value_parser = scale)]
    pub scale: f64,
    /// The near plane of a z-buffer; where it is farther than --far, the buffer is reversed
    #[arg(long, value_name = "DISTANCE", requires = "far", value_parser = plane)]
    pub near: Option<f64>,
    /// The far plane of a z-buffer; may be inf
    #[arg(long, value_name = "DISTANCE", requires = "near", value_parser = plane)]
    pub far: Option<f64>,
    /// Which of their two directions FILE's normals have
    #[arg(long, value_enum, default_value_t = Normals::Facing)]
    pub normals: Normals,
    /// The axes of FILE's normals: the world's, or the camera's right, up and back
    #[arg(long, value_enum, default_value_t = Space::World)]
    pub normal_space: Space,
    /// How far a byte of an object's colour may be off
    #[arg(long, value_name = "LEVELS", default_value_t = Conventions::COLOR_TOLERANCE)]
    pub color_tolerance: u8,
    /// FILE's first row is the lowest
    #[arg(long)]
    pub rows_from_below: bool,
    /// What is still right: shares of wrong ids, the errors of t (ulp or relative) and normals (degrees),
    /// e.g. ids=0.01%,silhouettes=5%,t=2ulp,normal=0.1; each may be `any` [default: what certified itself
    /// promises]
    #[arg(long, value_name = "WHAT", value_parser = Allowed::of_rays)]
    pub allow: Option<Allowed>,
    /// Pixels of each kind of error to show, the worst first
    #[arg(long, value_name = "N", default_value_t = 3)]
    pub worst: usize,
    /// Also write a picture of the errors (.png): false hits red, false misses orange, other objects
    /// yellow, errors of t and normals blue
    #[arg(short, long, value_name = "ERROR.png")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub device: DeviceArgs,
    #[command(flatten)]
    pub size: SizeArgs,
    #[command(flatten)]
    pub camera: CameraArgs,
    #[command(flatten)]
    pub data: DataArgs,
}

/// The direction of normals.
#[derive(Clone, Copy, ValueEnum)]
pub enum Normals {
    /// Towards the ray.
    Facing,
    /// Out of a sphere, and as the scene gives it for a plane.
    Outward,
    /// Any of the two.
    Either,
}

/// The axes of normals.
#[derive(Clone, Copy, ValueEnum)]
pub enum Space {
    /// The world's.
    World,
    /// The camera's.
    Camera,
}

fn scale(text: &str) -> Result<f64, String> {
    number(text, |x| x.is_finite() && x != 0.0, "give a length other than 0, e.g. 0.001")
}

fn plane(text: &str) -> Result<f64, String> {
    number(text, |x| x > 0.0, "give a distance above 0, e.g. 0.1, or inf")
}

/// What was judged, and how.
#[derive(Serialize)]
pub struct Summary {
    #[serde(flatten)]
    on: On,
    against: String,
    format: &'static str,
    #[serde(flatten)]
    judged: JudgeSummary,
}

/// Judges another renderer's results.
pub fn run(args: &JudgeArgs, run: &Run) -> Result<Done<Summary>> {
    let inputs = [&args.scene, &args.against].into_iter().chain(&args.rays);
    let file = begin_picture(args.output.as_ref(), inputs, run)?;
    let conventions = conventions(args)?;
    let image = read_image(&args.against)?;
    let format = image.format;
    let (scene, rays) = scene_and_rays(args, &image, run)?;
    let n = rays.len();
    let allowed = args.allow.clone().map_or_else(|| Allowed::of_rays(""), Ok)?;
    let case = Case::new(Arc::clone(&scene), rays, image, conventions, allowed)?;
    case.warning().iter().for_each(|warning| run.warn(warning));

    let mut session = device::session(&args.device, Kernel::Certified, &scene, n, run)?;
    let progress = Progress::start(run, 2 * n as u64);
    let judged = progress.during(|| case.judge(&mut session, &run.control))?;
    run.control.check()?;
    let picture = file.zip(judged.picture());
    let file =
        picture.map(|(file, (size, colors))| write_picture(file, size, &colors)).transpose()?;
    let worst = judged.worst(args.worst, |ray| Some(explain(args, &judged.case.rays, ray)));
    let what = judged.pixels().map_or(count(n, "ray"), size);
    let head = format!(
        "{}: {what}, {} against exact arithmetic on {} ({})\n\n",
        args.against.shown(),
        judged.quantities().join(", "),
        args.scene.shown(),
        ObjectCounts::of(&scene)
    );
    let hint = joined(judged.hint.iter().map(option), " ");
    let words = head + &judged.in_words(&worst, &hint);
    let summary = Summary {
        on: On::from(session.device()),
        against: args.against.display().to_string(),
        format,
        judged: judged.summary(worst, &hint),
    };
    Ok(Done::compared(summary, words, file, &judged.broken))
}

fn conventions(args: &JudgeArgs) -> Result<Conventions> {
    let near_far = args.near.zip(args.far).map(|(near, far)| [near, far]);
    if let Some([near, far]) = near_far.filter(|[near, far]| near == far) {
        let message = format!("--near {near} --far {far}: there is nothing between these planes");
        return wrong_usage(message);
    }
    Ok(Conventions {
        quantities: args.quantities.clone(),
        channel: args.channel.clone(),
        id_offset: args.id_offset,
        no_hit: args.no_hit,
        background: args.background,
        scale: args.scale,
        near_far,
        normal_side: match args.normals {
            Normals::Facing => NormalSide::Facing,
            Normals::Outward => NormalSide::Outward,
            Normals::Either => NormalSide::Either,
        },
        normal_space: match args.normal_space {
            Space::World => NormalSpace::World,
            Space::Camera => NormalSpace::Camera,
        },
        color_tolerance: args.color_tolerance,
        rows_from_below: args.rows_from_below,
    })
}

/// The scene, and the rays that the file is of.
fn scene_and_rays(args: &JudgeArgs, image: &Image, run: &Run) -> Result<(Arc<Scene>, Rays)> {
    let (camera, data) = (args.camera.clone(), args.data.clone());
    let picture = PictureArgs { camera, data, ..PictureArgs::default() };
    let read = |size| picture.scene(&args.scene, size, run);
    if let Some(rays) = &args.rays {
        let scene = picture.scene_of_rays(&args.scene, None, run)?;
        return Ok((scene, Rays::List(read_rays(rays, &run.control)?)));
    }
    let SizeArgs { whole: WholeArgs { size }, crop } = args.size;
    let size = whole_size(image, size, crop).map_err(|error| match error {
        Error::Usage(Message { text, hint }) => {
            Error::Usage(Message { text: format!("{}: {text}", args.against.shown()), hint })
        }
        error => error,
    })?;
    let scene = read(size)?;
    let pixels = SizeArgs { whole: WholeArgs { size }, crop }.pixels(&scene, &args.scene)?;
    let pixels = if crop.is_some() { pixels } else { pixels_of(image, pixels)? };
    Ok((scene, Rays::Pixels(pixels)))
}

/// The command that shows why a ray sees what it sees.
fn explain(args: &JudgeArgs, rays: &Rays, ray: usize) -> String {
    let scene = format!("{}{}", shell_quoted(&args.scene), args.given);
    match rays {
        Rays::Pixels(pixels) => {
            let (x, y) = pixels.xy(ray);
            let (w, h) = (pixels.image_width, pixels.image_height);
            format!("kugelblitz explain {scene} --pixel {x},{y} --size {w}x{h}")
        }
        Rays::List(rays) => {
            let WorldRay { origin, direction } = rays[ray];
            let numbers = [origin.to_array(), direction.to_array()].concat();
            let numbers = joined(numbers.iter().map(|x| format!("{x:?}")), ",");
            format!("kugelblitz explain {scene} --ray={numbers}")
        }
    }
}
