//! `kugelblitz compare`

use std::path::PathBuf;

use clap::Args;
use kugelblitz::output::{self, OutputFile};
use kugelblitz::picture::{read_image, rgb8_file};
use kugelblitz::{Error, Result};
use kugelblitz_judge::compare::{Allowed, PictureDifference, compare_pictures};

use crate::Run;
use crate::head::Done;
use crate::output::check_ending;

/// Compare two pictures, channel by channel
///
/// PNG, OpenEXR, NPY and PPM, in any pair: channels are matched by name, and numbers of different types
/// are compared as the one that has fewer of them, linear floats with sRGB as sRGB. Exit code 6 where
/// more differs than --allow says.
#[derive(Args)]
pub struct CompareArgs {
    /// A picture
    pub a: PathBuf,
    /// Another one
    pub b: PathBuf,
    /// What may differ: levels, ulp and difference of a number, and the pixels that may differ more, e.g.
    /// levels=1,ulp=4,difference=1e-6,pixels=0.1% [default: nothing]
    #[arg(long, value_name = "WHAT", value_parser = Allowed::of_pictures)]
    pub allow: Option<Allowed>,
    /// Also write a picture of the differences (.png): equal pixels dark, allowed differences blue, others
    /// red to yellow
    #[arg(short, long, value_name = "DIFFERENCE.png")]
    pub output: Option<PathBuf>,
}

/// Compares two pictures.
pub fn run(args: &CompareArgs, run: &Run) -> Result<Done<PictureDifference>> {
    let CompareArgs { a: path_a, b: path_b, output, allow } = args;
    let file = begin_picture(output.as_ref(), [path_a, path_b], run)?;
    let (a, b) = (read_image(path_a)?, read_image(path_b)?);
    run.control.check()?;
    let names = [path_a, path_b].map(|path| path.display().to_string());
    let allowed = allow.clone().map_or_else(|| Allowed::of_pictures(""), Ok)?;
    let found = compare_pictures(names.each_ref().map(String::as_str), [&a, &b], &allowed)?;
    let file = file.filter(|_| found.pixels > 0).map(|file| {
        let size = [a.width as u32, a.height as u32];
        write_picture(file, size, &found.picture(&a))
    });
    let (words, broken) = (found.in_words(), found.broken.clone());
    Ok(Done::compared(found, words, file.transpose()?, &broken))
}

/// Begins the file for a picture of errors or differences, where one is asked for, before the work.
pub fn begin_picture<'p>(
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
pub fn write_picture(file: OutputFile, size: [u32; 2], pixels: &[[u8; 3]]) -> Result<OutputFile> {
    let bytes = rgb8_file(size, pixels).map_err(Error::io(file.path()))?;
    file.filled(&bytes)
}
