//! `kugelblitz info`

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use kugelblitz::Result;
use kugelblitz::picture::{Channel, Image, read_image};
use kugelblitz::plain::Shown;
use kugelblitz::trace::StageCounts;
use kugelblitz::words::count;
use serde::Serialize;

use crate::args::TalkArgs;
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
    #[command(flatten)]
    pub talk: TalkArgs,
}

#[derive(Serialize)]
pub struct Summary {
    file: String,
    format: &'static str,
    size: [usize; 2],
    /// Left column, top row, width and height of a part, and the size of the whole.
    window: Option<[i64; 4]>,
    whole: [usize; 2],
    is_list: bool,
    channels: Vec<OfChannel>,
    metadata: BTreeMap<String, String>,
    /// Pixels that each stage decided, of files with `level`.
    levels: Option<StageCounts>,
}

#[derive(Serialize)]
struct OfChannel {
    name: String,
    #[serde(rename = "type")]
    kind: &'static str,
}

/// Tells what a file says of itself.
pub fn run(args: &InfoArgs) -> Result<Done<Summary>> {
    let image = read_image(&args.file)?;
    let levels = image.stage_counts();
    let is_part = image.whole != [image.width, image.height] || image.first != [0, 0];
    let mut text = format!("{}: {}\n", args.file.shown(), shape(&image));
    if is_part {
        let ([w, h], [x, y]) = (image.whole, image.first);
        text += &format!("part: at {x},{y} of {w}×{h}\n");
    }
    text += &format!("channels: {}\n", channels(&image));
    if let Some(StageCounts { f32, f64, exact }) = levels {
        text += &format!("decided: {f32} in f32, {f64} in f64, {exact} exactly\n");
    }
    for (name, words) in &image.texts {
        let name = name.strip_prefix("kugelblitz.").unwrap_or(name);
        // `camera = …` says its name itself, as a scene file has it.
        text += &match words.starts_with(&format!("{name} = ")) {
            true => format!("{words}\n"),
            false => format!("{name}: {words}\n"),
        };
    }
    if image.texts.is_empty() {
        text += "it says nothing of how it was made\n";
    }
    let window = [image.first[0], image.first[1], image.width as i64, image.height as i64];
    let of_channel = |c: Channel| OfChannel { kind: c.samples.kind(), name: c.name };
    let summary = Summary {
        file: args.file.display().to_string(),
        format: image.format,
        size: [image.width, image.height],
        window: is_part.then_some(window),
        whole: image.whole,
        is_list: image.is_list,
        channels: image.channels.into_iter().map(of_channel).collect(),
        metadata: image.texts.into_iter().collect(),
        levels,
    };
    Ok(Done::in_words(summary, text))
}

/// `PNG, 1280×720`, or `NPY, 12 results`.
fn shape(image: &Image) -> String {
    match image.is_list {
        true => format!("{}, {}", image.format, count(image.width, "result")),
        false => format!("{}, {}×{}", image.format, image.width, image.height),
    }
}

/// `R G B u8, Z f32`
fn channels(image: &Image) -> String {
    let runs = image.channels.chunk_by(|a, b| a.samples.kind() == b.samples.kind());
    let run = |run: &[Channel]| {
        let names: Vec<&str> = run.iter().map(|channel| channel.name.as_str()).collect();
        let kind = run.first().map_or("", |channel| channel.samples.kind());
        format!("{} {kind}", names.join(" "))
    };
    runs.map(run).collect::<Vec<_>>().join(", ")
}
