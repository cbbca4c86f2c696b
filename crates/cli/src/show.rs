//! `render --show`

use clap::builder::PossibleValue;
use kugelblitz::Result;
use kugelblitz::picture::{Format, PictureOptions};
use kugelblitz::scene::hex;
use kugelblitz::words::{count, joined};
use kugelblitz_judge::show::{Entry, Show, ShownPicture};
use serde::Serialize;

use crate::args::RenderArgs;
use crate::wrong_usage;

/// Most pixels of a meaning that are told one by one.
const MOST_TOLD: usize = 4;

/// The name on the command line.
pub fn name_of_show(show: Show) -> PossibleValue {
    let value = PossibleValue::new(show.name());
    if show == Show::Color { value.alias("color") } else { value }
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
        ("--turntable or --camera-path", args.film.is_film()),
    ];
    match is_given.into_iter().find(|&(_, is_given)| is_given && show != Show::Color) {
        None => Ok(()),
        Some((option, _)) => wrong_usage(format!(
            "--show {show} looks along the ray through each pixel's centre, without light; leave \
             {option} out"
        )),
    }
}

/// An entry of the legend.
#[derive(Serialize)]
pub struct LegendEntry {
    color: String,
    meaning: String,
    /// How many pixels have this meaning, where they are counted.
    #[serde(skip_serializing_if = "Option::is_none")]
    pixels: Option<u64>,
    /// Column and row of each, where they are few.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    at: Vec<[u32; 2]>,
}

/// The legend.
pub fn legend(shown: &ShownPicture) -> Vec<LegendEntry> {
    let entry = |(i, entry): (usize, &Entry)| LegendEntry {
        color: hex(entry.color),
        meaning: entry.meaning.clone(),
        pixels: shown.tally.count(i),
        at: shown.tally.few(i).to_vec(),
    };
    shown.legend.iter().enumerate().map(entry).collect()
}

impl LegendEntry {
    /// The entry as a line for people.
    pub fn in_words(&self) -> String {
        let LegendEntry { color, meaning, pixels, at } = self;
        let mut line = format!("  {color}  {meaning}");
        if let Some(n) = pixels {
            line += &format!(": {}", count(*n as usize, "pixel"));
        }
        if (1..=MOST_TOLD).contains(&at.len()) {
            let places = joined(at.iter().map(|[x, y]| format!("{x},{y}")), " and ");
            line += &format!(", at {places}");
        }
        line
    }
}
