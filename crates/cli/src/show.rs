//! `render --show`

use clap::builder::PossibleValue;
use kugelblitz::Result;
use kugelblitz::picture::{Format, PictureOptions};
use kugelblitz_judge::show::Show;

use crate::args::RenderArgs;
use crate::wrong_usage;

/// The name on the command line.
pub fn name_of_show(show: Show) -> PossibleValue {
    PossibleValue::new(show.name()).help(show.explanation())
}

/// Refuses options that the shown numbers have no use for.
///
/// # Errors
/// [`Error::Usage`](kugelblitz::Error::Usage)
pub fn check(args: &RenderArgs, format: Format, options: PictureOptions) -> Result<()> {
    let show = args.show;
    show.check(format, options)?;
    let is_given = [
        ("--samples", args.picture.samples.is_some()),
        ("--epsilon", args.epsilon.is_some()),
        ("--repeat", args.repeat.is_some()),
        ("--turntable", args.film.is_film()),
    ];
    match is_given.into_iter().find(|&(_, is_given)| is_given && show != Show::Color) {
        None => Ok(()),
        Some((option, _)) => wrong_usage(format!(
            "--show {show} looks along the ray through each pixel's centre, without light; leave \
             {option} out"
        )),
    }
}
