//! `kugelblitz compare`

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use kugelblitz::compare::{
    ChannelDifference, PictureDifference, Tolerance, compare_pictures, difference_picture,
};
use kugelblitz::output::{self, OutputFile};
use kugelblitz::picture::{Format, Image, read_image, rgb8_file};
use kugelblitz::{Error, Result};
use serde::Serialize;

use super::head::print_verdict;
use super::output::print_text;
use super::{Run, TalkArgs};

/// Compare two pictures, channel by channel
///
/// PNG, OpenEXR, NPY, PPM, JPEG, TIFF, BMP, TGA and HDR, in any pair: channels are matched by name, and
/// numbers of different types are compared as the one that has fewer of them, linear floats with sRGB as
/// sRGB. Exit code 6 where more differs than --allow says.
#[derive(Args)]
pub struct CompareArgs {
    /// A picture
    pub a: PathBuf,
    /// Another one
    pub b: PathBuf,
    /// What may differ: levels, ulp and difference of a number, and the pixels that may differ more, e.g.
    /// levels=1,ulp=4,difference=1e-6,pixels=0.1% [default: nothing]
    #[arg(long, value_name = "WHAT")]
    pub allow: Option<Tolerance>,
    /// Also write a picture of the differences (.png): equal pixels dark, allowed differences blue, others
    /// red to yellow
    #[arg(short, long, value_name = "DIFFERENCE.png")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub talk: TalkArgs,
}

#[derive(Serialize)]
struct Summary<'a> {
    a: Side<'a>,
    b: Side<'a>,
    allowed: String,
    pixels: u64,
    differing: u64,
    beyond: u64,
    first: Option<[usize; 2]>,
    channels: Vec<OfChannel<'a>>,
    metadata_differs: &'a [String],
    broken: &'a [String],
}

#[derive(Serialize)]
struct Side<'a> {
    file: String,
    format: &'static str,
    size: [usize; 2],
    only: &'a [String],
}

#[derive(Serialize)]
struct OfChannel<'a> {
    #[serde(flatten)]
    found: &'a ChannelDifference,
    pixel: Option<[usize; 2]>,
}

/// Compares two pictures.
pub fn run(args: &CompareArgs, run: &Run) -> Result<()> {
    let CompareArgs { a: path_a, b: path_b, output, talk, .. } = args;
    let tolerance = args.allow.unwrap_or_default();
    let begin = |output: &PathBuf| begin_picture(output, &[path_a, path_b], talk);
    let file = output.as_ref().map(begin).transpose()?;
    let (a, b) = (read_image(path_a)?, read_image(path_b)?);
    run.control.check()?;
    let found = compare_pictures(&a, &b, &tolerance)?;
    let pixel = |i: usize| [i % a.width.max(1), i / a.width.max(1)];
    if let Some(file) = file.filter(|_| found.pixels > 0) {
        let size = [a.width as u32, a.height as u32];
        write_picture(file, size, &difference_picture(&a, &found), run)?;
    }
    let broken = found.broken.join("; ");
    let failure = (!broken.is_empty()).then_some(Error::Comparison(broken));
    if talk.json {
        let side = |path: &Path, image: &Image, only| Side {
            file: path.display().to_string(),
            format: image.format,
            size: [image.width, image.height],
            only,
        };
        let channels = found.channels.iter();
        let channels = channels.map(|found| OfChannel { found, pixel: found.at.map(pixel) });
        let summary = Summary {
            a: side(path_a, &a, &found.only_in[0]),
            b: side(path_b, &b, &found.only_in[1]),
            allowed: tolerance.to_string(),
            pixels: found.pixels,
            differing: found.differing,
            beyond: found.beyond,
            first: found.first.map(pixel),
            channels: channels.collect(),
            metadata_differs: &found.texts,
            broken: &found.broken,
        };
        print_verdict("compare", &summary, failure.as_ref())?;
    } else {
        print_text(&in_words([path_a, path_b], [&a, &b], &found, pixel))?;
    }
    failure.map_or(Ok(()), Err)
}

fn in_words(
    paths: [&Path; 2],
    images: [&Image; 2],
    found: &PictureDifference,
    pixel: impl Fn(usize) -> [usize; 2],
) -> String {
    let mut text = String::new();
    for (path, image) in paths.iter().zip(images) {
        let Image { format, width, height, .. } = image;
        text += &format!("{}: {format}, {width}×{height}\n", path.display());
    }
    if found.pixels > 0 {
        let PictureDifference { pixels, differing, beyond, .. } = found;
        text += &match differing {
            0 => format!("all {pixels} pixels are equal\n"),
            _ => format!(
                "{differing} of {pixels} pixels differ ({} %), {beyond} by more than is allowed\n",
                percent(*differing, *pixels)
            ),
        };
        text += "\nchannel   as      pixels that differ      largest       at   most ulp\n";
    }
    for channel in &found.channels {
        let ChannelDifference { name, compared_as, differing, largest, at, .. } = channel;
        let at = at.map_or("–".into(), |at| {
            let [x, y] = pixel(at);
            format!("{x},{y}")
        });
        let ulp = match channel.largest_ulp {
            None => "–".to_string(),
            Some(u64::MAX) => "∞".to_string(),
            Some(ulp) => ulp.to_string(),
        };
        let largest = match largest {
            0.0 => "0".to_string(),
            x if x.fract() == 0.0 && x.abs() < 1e9 => format!("{x}"),
            x => format!("{x:.3e}"),
        };
        text +=
            &format!("{name:<9} {compared_as:<5}{differing:>21}{largest:>13}{at:>9}{ulp:>11}\n");
    }
    for (path, only) in paths.iter().zip(&found.only_in) {
        if !only.is_empty() {
            text += &format!("only in {}: {}\n", path.display(), only.join(" "));
        }
    }
    if !found.texts.is_empty() {
        text += &format!("they say different things of themselves: {}\n", found.texts.join(" "));
    }
    text
}

/// Two digits, or as many as it takes.
pub fn percent(n: u64, all: u64) -> String {
    let percent = 100.0 * n as f64 / all.max(1) as f64;
    match percent {
        0.0 => "0".into(),
        large if large >= 10.0 => format!("{large:.0}"),
        small => {
            let digits = (1 - small.log10().floor() as i32).clamp(0, 12) as usize;
            format!("{small:.digits$}")
        }
    }
}

/// Begins the file for a picture of errors or differences, before the work.
pub fn begin_picture(output: &Path, inputs: &[&Path], talk: &TalkArgs) -> Result<OutputFile> {
    talk.refuse_json_beside(&[output], "the picture", "write the picture to a file")?;
    if Format::from_path(output).ok() != Some(Format::Png) {
        return Err(Error::Usage(format!(
            "{}: this picture is written as .png; name it so",
            output.display()
        )));
    }
    output::refuse_overwriting(&[output], inputs)?;
    OutputFile::create(output, false)
}

/// Writes a picture that no camera took.
pub fn write_picture(
    mut file: OutputFile,
    size: [u32; 2],
    pixels: &[[u8; 3]],
    run: &Run,
) -> Result<()> {
    let path = file.path().to_path_buf();
    let bytes = rgb8_file(size, pixels).map_err(Error::io(&path))?;
    file.write_all(&bytes).map_err(Error::io(&path))?;
    output::commit([file], &run.control)
}
