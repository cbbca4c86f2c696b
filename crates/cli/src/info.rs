//! `kugelblitz info`

use std::fmt::Write;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use clap::Args;
use kugelblitz::Result;
use kugelblitz::picture::{Channel, Format, Image, ImageFacts, read_image};
use kugelblitz::plain::Shown;
use kugelblitz::query::{Kernel, StageCounts};
use kugelblitz::words::{bytes, count, joined};
use kugelblitz_judge::cost::{Built, Cost, LightOf, ObjectCounts, PictureCost};
use serde::Serialize;

use crate::Run;
use crate::args::SizeArgs;
use crate::head::Done;
use crate::output::is_stdout;
use crate::picture::{PictureArgs, unused_columns};
use crate::progress::Progress;

/// Describe a file: a scene, data, a picture or hits
///
/// Of scenes and data: objects, lights, memory, and the size of the picture; nothing is rendered. Of pictures by
/// `render`: version, hash of the scene, camera, size, samples, kernel, and number of certified pixels; the line
/// `camera = …` can be pasted into a scene file. Of other pictures: format, size and channels. The whole file is
/// read, so that a truncated one is found. An .npy with 3 to 7 columns, or with fields x, y and z, is data.
#[derive(Args)]
pub struct InfoArgs {
    /// Scene (TOML), data (.npy, .csv, .xyz, LAMMPS dumps), or picture (PNG, OpenEXR, NPY, PPM)
    ///
    /// `-` is a scene or data on standard input.
    pub file: PathBuf,
    #[command(flatten)]
    pub size: SizeArgs,
    #[command(flatten)]
    pub picture: PictureArgs,
}

/// What is in a file.
#[derive(Serialize)]
#[serde(untagged)]
pub enum InfoSummary {
    /// A picture or hits.
    Picture(ImageFacts),
    /// A scene or data.
    Scene(Box<Cost>),
}

/// The content of a file.
pub enum FileContent {
    /// A picture or hits.
    Picture(Image),
    /// A scene or data, which are not read yet.
    Scene,
}

impl FileContent {
    /// Finds what a file is, by its content. `picture` are options that make it a scene.
    ///
    /// # Errors
    /// Returns the errors of [`read_image`].
    pub fn of(path: &Path, picture: &PictureArgs) -> Result<FileContent> {
        if is_stdout(path) || picture.data.input_format.is_some() {
            return Ok(FileContent::Scene);
        }
        let mut start = Vec::new();
        let read = File::open(path).and_then(|file| file.take(8).read_to_end(&mut start));
        let is_picture = match (read, start.as_slice()) {
            // A built-in scene has no file; the reader of scenes words other errors.
            (Err(_), _) => false,
            _ if Format::from_path(path).is_ok_and(|format| format != Format::Npy) => true,
            (_, [0x76, 0x2f, 0x31, 0x01, ..] | [0x93, b'N', b'U', b'M', b'P', b'Y', ..]) => true,
            (_, [0x89, b'P', b'N', b'G', ..]) => true,
            (_, [b'P', b'1'..=b'7', b'\n' | b' ' | b'\r' | b'\t' | b'#', ..]) => true,
            _ => false,
        };
        if !is_picture {
            return Ok(FileContent::Scene);
        }
        // An .npy without fields can be an array of particles, of which a picture reads any number of columns.
        match read_image(path) {
            Ok(image) if !is_of_particles(&image) => Ok(FileContent::Picture(image)),
            Ok(_) => Ok(FileContent::Scene),
            Err(error) => Err(error),
        }
    }
}

/// Whether an array has particles: 3 to 7 columns, or fields x, y and z.
fn is_of_particles(image: &Image) -> bool {
    let has = |name: &&str| image.channel(name).is_some();
    let is_table = !image.is_list && has(&"value") && (3..=7).contains(&image.width);
    image.format == "NPY" && (is_table || ["x", "y", "z"].iter().all(has))
}

/// Prints what is in a file.
pub fn run(args: &InfoArgs, run: &Run) -> Result<Done<InfoSummary>> {
    match FileContent::of(&args.file, &args.picture)? {
        FileContent::Picture(image) => of_picture(args, &image),
        FileContent::Scene => of_scene(args, run),
    }
}

fn of_scene(args: &InfoArgs, run: &Run) -> Result<Done<InfoSummary>> {
    let InfoArgs { file, size, picture } = args;
    let scene = picture.scene_of_rays(file, size.whole.size, run)?;
    let pixels = scene.camera.as_ref().map(|_| size.pixels(&scene, file)).transpose()?;
    let progress = Progress::of_preparing(run, &scene, Kernel::Certified);
    let cost = progress.during(|| Cost::new(&scene, pixels.as_ref(), &run.control))?;
    let mut text = format!("{}: {}\n", file.shown(), ObjectCounts::of(&scene));
    for cloud in &scene.clouds {
        let spheres = count(cloud.n_spheres, "sphere");
        let _ = writeln!(text, "{}: {spheres}, from id {}", cloud.path.shown(), cloud.first_id);
        if !cloud.unused_columns.is_empty() {
            let _ = writeln!(text, "{}: {}", cloud.path.shown(), unused_columns(cloud));
        }
    }
    if let Some(light) = &cost.light {
        let _ = writeln!(text, "lit by {}", light_in_words(light));
    }
    if let n @ 2.. = cost.samples {
        let _ = writeln!(text, "samples: {n} × {n} a pixel");
    }
    let _ = writeln!(text, "in memory: {}", bytes(cost.bytes_scene));
    for (kernel, n) in &cost.bytes_device {
        let _ = writeln!(text, "on the device, {kernel}: {}", bytes(*n));
    }
    if let Some(Built { spheres_outside, bytes: n, ms_build }) = &cost.hierarchy {
        let outside = match spheres_outside {
            0 => String::new(),
            n => format!(", without {}", count(*n, "sphere")),
        };
        let _ = writeln!(text, "hierarchy: {}, built in {ms_build:.0} ms{outside}", bytes(*n));
    }
    match &cost.picture {
        Some(PictureCost { size: [width, height], rays, bytes_memory, bytes_held }) => {
            let _ = writeln!(text, "picture: {width}×{height}, {rays} rays");
            let _ = writeln!(text, "memory held for it: {}", bytes(*bytes_held));
            for (format, n) in bytes_memory {
                let _ = writeln!(text, "memory to write {format}: {}", bytes(*n));
            }
        }
        None => text += "no camera: commands that draw place one that frames all spheres\n",
    }
    Ok(Done::in_words(InfoSummary::Scene(Box::new(cost)), text))
}

fn of_picture(args: &InfoArgs, image: &Image) -> Result<Done<InfoSummary>> {
    args.picture.refuse_without_scene()?;
    let facts = image.facts(&args.file);
    let mut text = format!("{}: {}\n", args.file.shown(), shape(image));
    if let (Some([x, y, ..]), [w, h]) = (facts.window, image.whole) {
        text += &format!("part: at {x},{y} of {w}×{h}\n");
    }
    text += &format!("channels: {}\n", channels(image));
    if let Some(StageCounts { f32, f64, exact }) = facts.levels {
        text += &format!("decided: {f32} in f32, {f64} in f64, {exact} exactly\n");
    }
    for (name, words) in &image.texts {
        let name = name.strip_prefix("kugelblitz.").unwrap_or(name);
        // `camera = …` says its name itself, as a scene file has it.
        if !words.starts_with(&format!("{name} = ")) {
            text += &format!("{name}: ");
        }
        text += &format!("{words}\n");
    }
    if image.texts.is_empty() {
        text += "it says nothing of how it was made\n";
    }
    Ok(Done::in_words(InfoSummary::Picture(facts), text))
}

/// `PNG, 1280×720`, or `NPY, 12 results`.
fn shape(image: &Image) -> String {
    if image.is_list {
        format!("{}, {}", image.format, count(image.width, "result"))
    } else {
        format!("{}, {}×{}", image.format, image.width, image.height)
    }
}

/// `R G B u8, Z f32`
fn channels(image: &Image) -> String {
    let runs = image.channels.chunk_by(|a, b| a.samples.kind() == b.samples.kind());
    let run = |run: &[Channel]| {
        let names = joined(run.iter().map(|channel| channel.name.as_str()), " ");
        let kind = run.first().map_or("", |channel| channel.samples.kind());
        format!("{names} {kind}")
    };
    joined(runs.map(run), ", ")
}

/// `2 lights, a sky of 16 directions`
fn light_in_words(light: &LightOf) -> String {
    let mut parts = Vec::new();
    if light.lights > 0 {
        parts.push(count(light.lights, "light"));
    }
    if light.sky_directions > 0 {
        let directions = count(light.sky_directions as usize, "direction");
        parts.push(format!("a sky of {directions}"));
    }
    if light.ambient {
        parts.push("ambient light".into());
    }
    parts.join(", ")
}
