//! `kugelblitz compare`

use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use glam::DVec3;
use kugelblitz::error::Message;
use kugelblitz::output::{self, OutputFile};
use kugelblitz::picture::{Image, read_rays, rgb8_file};
use kugelblitz::plain::Shown;
use kugelblitz::query::{Kernel, WorldRay};
use kugelblitz::rays::{Pixels, Rays};
use kugelblitz::scene::schema::CameraKeys;
use kugelblitz::scene::{Camera, Projection, Samples, Scene, SceneOverrides};
use kugelblitz::words::{count, joined};
use kugelblitz::{Error, Result, Session};
use kugelblitz_judge::compare::{
    Allowed, ColorKind, ExactChannels, HitComparison, HitDifference, HitSummary, PictureDifference,
    Quantity, TRANSFORMS, Transform, camera_of, compare_pictures, exact_picture, explain_pictures,
    has_camera, pixels_of, quantities_of, samples_of, whole_size,
};
use kugelblitz_judge::cost::ObjectCounts;
use serde::Serialize;

use crate::args::{DeviceArgs, PICTURE, SizeArgs, WholeArgs};
use crate::head::{Done, On};
use crate::info::FileContent;
use crate::options::samples_parser;
use crate::output::{check_ending, shell_quoted};
use crate::picture::{GivenOptions, PictureArgs, read_composed};
use crate::progress::Progress;
use crate::render::size;
use crate::{Run, device, wrong_usage};

/// Compare pictures, hits and scenes
///
/// A scene is compared as its exact picture; exit code 6 means that the other file is wrong. Ids, depths and
/// normals are compared with exact arithmetic, colours with the picture that `render` makes. Size, crop,
/// camera and samples are those of the other file if it has them. Two pictures (PNG, OpenEXR, NPY, PPM) are
/// compared channel by channel.
///
/// If much is wrong, transforms are tried: other conventions and common mistakes. The one that explains
/// the errors is named.
#[derive(Args)]
#[command(after_long_help = transforms_help())]
pub struct CompareArgs {
    #[command(flatten)]
    given: GivenOptions,
    /// Picture, hits or scene
    pub a: PathBuf,
    /// Picture, hits or scene
    pub b: PathBuf,
    /// Allowed errors, e.g. ids=0.1%,t=1e-4; --help lists the keys [default: none]
    ///
    /// Of hits: ids and silhouettes (fraction of wrong ids, away from and at silhouettes: 0.1%), t
    /// (relative, or in f32 steps: 4ulp), normal (degrees). Of colours: levels (8 or 16 bits), ulp,
    /// difference (absolute), pixels (fraction that may differ by more). Each may be `any`.
    #[arg(long, value_name = "KEY=LIMIT,…", help_heading = COMPARISON)]
    pub allow: Option<Allowed>,
    /// Transforms to apply, e.g. flip-rows,ids-1; --help lists them
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', allow_hyphen_values = true, help_heading = COMPARISON)]
    pub transform: Vec<Transform>,
    /// Quantities in the file: id, depth, distance, normal, color
    ///
    /// `depth` is along the view axis, `distance` from the eye. [default: by the names of its channels]
    #[arg(long = "as", value_name = "QUANTITY,…", value_delimiter = ',', help_heading = COMPARISON)]
    pub quantities: Vec<Quantity>,
    /// Channel or field with that quantity, if it has another name; of normals the part before .X
    #[arg(long, value_name = "NAME", requires = "quantities", help_heading = COMPARISON, hide_short_help = true)]
    pub channel: Option<String>,
    /// Rays of the hits: .npy, shape (N, 6), as for `trace`
    #[arg(long, value_name = "RAYS.npy", conflicts_with_all = ["size", "crop", "output", "samples"], help_heading = COMPARISON)]
    pub rays: Option<PathBuf>,
    /// Number of pixels to show for each kind of error, the worst first
    #[arg(long, value_name = "N", default_value_t = 3, help_heading = COMPARISON)]
    pub worst: usize,
    /// Also write a picture of the errors (.png)
    ///
    /// False hits are red, false misses orange, other objects yellow, errors of t and normals blue. Of
    /// colours, allowed differences are blue, others red to yellow.
    #[arg(short, long, value_name = "ERRORS.png", help_heading = COMPARISON)]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub size: SizeArgs,
    /// N × N samples per pixel [default: those of the picture, or of the scene]
    #[arg(long, value_name = "N", value_parser = samples_parser(), help_heading = PICTURE)]
    pub samples: Option<Samples>,
    #[command(flatten)]
    pub picture: PictureArgs,
    #[command(flatten)]
    pub device: DeviceArgs,
}

const COMPARISON: &str = "Comparison";

/// Returns the table of the transforms.
fn transforms_help() -> String {
    let line = |(form, meaning): (&str, &str)| format!("  {form:<20}  {meaning}\n");
    format!("Transforms:\n{}", TRANSFORMS.map(line).concat())
}

/// A comparison of two files.
#[derive(Serialize)]
pub struct CompareSummary {
    /// First file; with a scene, the file that is compared with the scene.
    a: String,
    /// Second file; with a scene, the scene.
    b: String,
    /// Device that traced the scene.
    #[serde(flatten)]
    on: Option<On>,
    /// Transforms that were applied.
    transforms: Vec<String>,
    /// Ids, `t` and normals, compared with a scene; `null` if they are not compared.
    hits: Option<HitSummary>,
    /// Colours; of two pictures, all channels; `null` if they are not compared.
    picture: Option<PictureDifference>,
    /// Differences beyond the allowed ones, one sentence each; empty if the comparison succeeds.
    broken: Vec<String>,
}

/// Compares two pictures, hits or scenes.
pub fn run(args: &CompareArgs, run: &Run) -> Result<Done<CompareSummary>> {
    let inputs = [&args.a, &args.b].into_iter().chain(&args.rays);
    let file = begin_picture(args.output.as_ref(), inputs, run)?;
    let content = |path| FileContent::of(path, &PictureArgs::default());
    match [content(&args.a)?, content(&args.b)?] {
        [FileContent::Picture(a), FileContent::Picture(b)] => of_pictures(args, [a, b], file, run),
        [FileContent::Picture(a), FileContent::Scene] => {
            with_scene(args, (&args.a, a), &args.b, file, run)
        }
        [FileContent::Scene, FileContent::Picture(b)] => {
            with_scene(args, (&args.b, b), &args.a, file, run)
        }
        [FileContent::Scene, FileContent::Scene] => of_scenes(args, file, run),
    }
}

fn of_pictures(
    args: &CompareArgs,
    pictures: [Image; 2],
    file: Option<OutputFile>,
    run: &Run,
) -> Result<Done<CompareSummary>> {
    args.picture.refuse_without_scene()?;
    if args.rays.is_some() || !args.quantities.is_empty() || args.samples.is_some() {
        return wrong_usage("--as, --channel, --rays and --samples are for comparing with a scene");
    }
    run.control.check()?;
    finish_pictures(args, pictures, file, None)
}

fn of_scenes(
    args: &CompareArgs,
    file: Option<OutputFile>,
    run: &Run,
) -> Result<Done<CompareSummary>> {
    let picture = |path: &PathBuf| {
        let size = args.size.whole.size;
        let overrides = SceneOverrides {
            needs_camera: true,
            samples: args.samples,
            ..args.picture.overrides(size)?
        };
        let (scene, _) = read_composed(path, &overrides, run)?;
        let pixels = args.size.pixels(&scene, path)?;
        let mut session =
            device::session(&args.device, Kernel::Certified, &scene, pixels.len(), run)?;
        let n_samples = scene.samples.unwrap_or_default();
        let all = ExactChannels::All;
        let image = exact_picture(&mut session, &pixels, n_samples, all, &run.control)?;
        Ok::<_, Error>((image, On::from(session.device())))
    };
    let ((a, on), (b, _)) = (picture(&args.a)?, picture(&args.b)?);
    finish_pictures(args, [a, b], file, Some(on))
}

/// Compares two pictures that are in memory.
fn finish_pictures(
    args: &CompareArgs,
    [mut a, b]: [Image; 2],
    file: Option<OutputFile>,
    on: Option<On>,
) -> Result<Done<CompareSummary>> {
    let CompareArgs { a: path_a, b: path_b, allow, transform, .. } = args;
    let allowed = allow.clone().unwrap_or_default();
    allowed.check_used(false, true)?;
    if let Some(other) = transform.iter().find(|it| !it.is_of_files()) {
        return wrong_usage(format!(
            "--transform {other}: only flips can be applied to two pictures"
        ));
    }
    transform.iter().for_each(|transform| transform.apply_to_image(&mut a));
    let names = [path_a, path_b].map(|path| path.display().to_string());
    let names_of = names.each_ref().map(String::as_str);
    let mut found = compare_pictures(names_of, [&a, &b], &allowed)?;
    if !found.broken.is_empty() {
        found.explained_by = explain_pictures([&a, &b], &allowed, &found)?;
    }
    let file = file.filter(|_| found.pixels > 0).map(|file| {
        let size = [a.width as u32, a.height as u32];
        write_picture(file, size, &found.picture(&a))
    });
    let (words, broken) = (found.in_words(), found.broken.clone());
    let [a, b] = names;
    let summary = CompareSummary {
        a,
        b,
        on,
        transforms: transform.iter().map(Transform::to_string).collect(),
        hits: None,
        picture: Some(found),
        broken: broken.clone(),
    };
    Ok(Done::compared(summary, words, file.transpose()?, &broken))
}

/// Compares a picture or hits with a scene.
fn with_scene(
    args: &CompareArgs,
    (path, mut image): (&PathBuf, Image),
    scene_path: &PathBuf,
    file: Option<OutputFile>,
    run: &Run,
) -> Result<Done<CompareSummary>> {
    let quantities = match args.quantities.as_slice() {
        [] => quantities_of(&image, args.channel.as_deref())?,
        given => given.to_vec(),
    };
    if args.channel.is_some() && quantities.len() != 1 {
        return wrong_usage("--channel has one quantity; give it with --as");
    }
    let has_hits = quantities.iter().any(|quantity| quantity.is_of_hits());
    let has_colors = quantities.contains(&Quantity::Color) && args.rays.is_none();
    let allowed = args.allow.clone().unwrap_or_default();
    allowed.check_used(has_hits, has_colors)?;
    let (scene, rays) = scene_and_rays(args, &image, [path, scene_path], run)?;
    let n = rays.len();
    let mut session = device::session(&args.device, Kernel::Certified, &scene, n, run)?;
    let colors = if has_colors { rays.pixels().copied() } else { None };
    let head = format!(
        "{}: {}, {} against exact arithmetic on {} ({})\n\n",
        path.shown(),
        rays.pixels().map_or(count(n, "ray"), size),
        joined(quantities.iter().map(|quantity| quantity.name()), ", "),
        scene_path.shown(),
        ObjectCounts::of(&scene)
    );
    let hits = if has_hits {
        let comparison = HitComparison {
            scene: Arc::clone(&scene),
            rays,
            image: image.clone(),
            quantities,
            channel: args.channel.clone(),
            transforms: args.transform.clone(),
            allowed: allowed.clone(),
        };
        let progress = Progress::start(run, 2 * n as u64);
        Some(progress.during(|| comparison.run(&mut session, &run.control))?)
    } else {
        None
    };
    let picture = colors.map(|pixels| {
        let n_samples = args.samples.or(samples_of(&image)).or(scene.samples).unwrap_or_default();
        let flips = args.transform.iter().filter(|transform| transform.is_of_files());
        flips.for_each(|transform| transform.apply_to_image(&mut image));
        let names = [path.display().to_string(), scene_path.display().to_string()];
        let names = names.each_ref().map(String::as_str);
        colors_with_scene(names, &image, &mut session, &pixels, n_samples, &allowed, run)
    });
    let picture = picture.transpose()?;
    run.control.check()?;
    finish_with_scene(args, [path, scene_path], (hits, picture), &image, (file, head), &session)
}

/// Compares colours with those of the exact picture.
fn colors_with_scene(
    names: [&str; 2],
    image: &Image,
    session: &mut Session,
    pixels: &Pixels,
    n_samples: Samples,
    allowed: &Allowed,
    run: &Run,
) -> Result<PictureDifference> {
    let Some(kind) = ColorKind::of(image) else {
        return wrong_usage(format!("the {} file has no colours R, G and B", image.format));
    };
    let mut colors = image.clone();
    colors.channels.retain(|channel| matches!(channel.name.as_str(), "R" | "G" | "B"));
    let channels = ExactChannels::Colors(kind);
    let mut exact = exact_picture(session, pixels, n_samples, channels, &run.control)?;
    // The place is the same: the pixels were taken from the file, or given.
    (exact.whole, exact.first) = (colors.whole, colors.first);
    let mut found = compare_pictures(names, [&colors, &exact], allowed)?;
    if !found.broken.is_empty() {
        found.explained_by = explain_pictures([&colors, &exact], allowed, &found)?;
    }
    Ok(found)
}

fn finish_with_scene(
    args: &CompareArgs,
    [path, scene_path]: [&PathBuf; 2],
    (hits, picture): (Option<HitDifference>, Option<PictureDifference>),
    image: &Image,
    (file, head): (Option<OutputFile>, String),
    session: &Session,
) -> Result<Done<CompareSummary>> {
    let of_hits = hits.as_ref().and_then(HitDifference::picture);
    let of_colors = picture
        .as_ref()
        .map(|difference| ([image.width as u32, image.height as u32], difference.picture(image)));
    let file = file.zip(of_hits.or(of_colors));
    let file = file.map(|(file, (size, colors))| write_picture(file, size, &colors)).transpose()?;
    let mut words = head;
    let mut broken = Vec::new();
    let hits = hits.map(|hits| {
        let options = args.given.to_string() + &camera_options(args, image, &hits.comparison.scene);
        let how = |ray| Some(explain_command(scene_path, &options, &hits.comparison.rays, ray));
        let worst = hits.worst(args.worst, how);
        words += &hits.in_words(&worst, |names| format!("--transform {names}"));
        broken.extend(hits.broken.clone());
        hits.summary(worst)
    });
    if let Some(picture) = &picture {
        if hits.is_some() {
            words += "\n";
        }
        words += &picture.in_words();
        broken.extend(picture.broken.clone());
    }
    let summary = CompareSummary {
        a: path.display().to_string(),
        b: scene_path.display().to_string(),
        on: Some(On::from(session.device())),
        transforms: args.transform.iter().map(Transform::to_string).collect(),
        hits,
        picture,
        broken: broken.clone(),
    };
    Ok(Done::compared(summary, words, file, &broken))
}

/// Reads the scene, and finds the rays that the file is of.
fn scene_and_rays(
    args: &CompareArgs,
    image: &Image,
    [path, scene_path]: [&PathBuf; 2],
    run: &Run,
) -> Result<(Arc<Scene>, Rays)> {
    if let Some(rays) = &args.rays {
        let scene = args.picture.scene_of_rays(scene_path, None, run)?;
        return Ok((scene, Rays::List(read_rays(rays, &run.control)?)));
    }
    let SizeArgs { whole: WholeArgs { size }, crop } = args.size;
    let size = whole_size(image, size, crop).map_err(|error| match error {
        Error::Usage(Message { text, hint }) => {
            Error::Usage(Message { text: format!("{}: {text}", path.shown()), hint })
        }
        error => error,
    })?;
    let mut overrides = SceneOverrides { needs_camera: true, ..args.picture.overrides(size)? };
    if args.picture.camera.is_empty()
        && let Some(camera) = camera_of(image)?
    {
        overrides.camera = CameraKeys::from(&camera);
    }
    let (scene, _) = read_composed(scene_path, &overrides, run)?;
    let pixels = SizeArgs { whole: WholeArgs { size }, crop }.pixels(&scene, scene_path)?;
    let pixels = if crop.is_some() { pixels } else { pixels_of(image, pixels)? };
    Ok((scene, Rays::Pixels(pixels)))
}

/// Returns the options of the camera that was taken from the picture, for another command.
fn camera_options(args: &CompareArgs, image: &Image, scene: &Scene) -> String {
    let is_of_picture = args.picture.camera.is_empty() && args.rays.is_none();
    let Some(Camera { position, look_at, up, projection }) =
        scene.camera.as_ref().filter(|_| is_of_picture && has_camera(image))
    else {
        return String::new();
    };
    let vector = |v: &DVec3| joined(v.to_array().map(|x| format!("{x:?}")), ",");
    let projection = match projection {
        Projection::Perspective { fov_degrees } => format!("--fov={fov_degrees:?}"),
        Projection::Orthographic { height } => format!("--height={height:?}"),
    };
    let [position, look_at, up] = [position, look_at, up].map(vector);
    format!(" --position={position} --look-at={look_at} --up={up} {projection}")
}

/// Returns the command that shows the numbers of a ray.
fn explain_command(scene: &Path, options: &str, rays: &Rays, ray: usize) -> String {
    let scene = shell_quoted(scene) + options;
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

/// Begins the file for a picture of errors or differences, if one is wanted, before the work.
fn begin_picture<'p>(
    output: Option<&PathBuf>,
    inputs: impl IntoIterator<Item = &'p PathBuf>,
    run: &Run,
) -> Result<Option<OutputFile>> {
    let Some(output) = output else { return Ok(None) };
    run.refuse_sharing_stdout([(output, "the picture")])?;
    check_ending(output, "png", "this picture is")?;
    output::refuse_overwriting([output], inputs)?;
    OutputFile::create(output, false).map(Some)
}

/// Writes a picture that no camera took; it is then whole, but not in its place.
fn write_picture(file: OutputFile, size: [u32; 2], pixels: &[[u8; 3]]) -> Result<OutputFile> {
    let bytes = rgb8_file(size, pixels).map_err(Error::io(file.path()))?;
    file.filled(&bytes)
}
