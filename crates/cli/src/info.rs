//! `kugelblitz info`

use std::path::PathBuf;

use clap::Args;
use kugelblitz::Result;
use kugelblitz::picture::{Channel, Image, ImageFacts, read_image};
use kugelblitz::plain::Shown;
use kugelblitz::trace::StageCounts;
use kugelblitz::words::{count, joined};

use crate::head::Done;

/// Print what a picture says of itself
///
/// PNG and OpenEXR files by `render` tell the program's version, the scene's hash, the camera, size and
/// samples, the kernel, and how many pixels are proven; `camera = …` can be put into a scene file as it is.
/// Of files that tell nothing: format, size, channels. The whole file is read, so one that is cut off is
/// found.
#[derive(Args)]
pub struct InfoArgs {
    /// A picture (PNG, OpenEXR, NPY, PPM), or hits of `trace`
    #[arg(value_name = "OUT")]
    pub file: PathBuf,
}

/// Tells what a file says of itself.
pub fn run(args: &InfoArgs) -> Result<Done<ImageFacts>> {
    let image = read_image(&args.file)?;
    let facts = image.facts(&args.file);
    let mut text = format!("{}: {}\n", args.file.shown(), shape(&image));
    if let (Some([x, y, ..]), [w, h]) = (facts.window, image.whole) {
        text += &format!("part: at {x},{y} of {w}×{h}\n");
    }
    text += &format!("channels: {}\n", channels(&image));
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
    Ok(Done::in_words(facts, text))
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
