//! `kugelblitz figure`

use std::path::{Path, PathBuf};

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use kugelblitz::Result;
use kugelblitz::plain::Shown;
use kugelblitz::scene::parse_scene;
use kugelblitz_judge::figure::Figure;
use serde::Serialize;

use crate::Run;
use crate::args::{LangArgs, WholeArgs};
use crate::head::Done;
use crate::output::{check_ending, is_stdout, refuse_overwriting, written};
use crate::picture::PictureArgs;

/// Draw figure 2, 3, 4 or 5 of the lecture from a scene, as SVG
///
/// Figure 2: the rays from the left to the right edge of the picture and the objects they hit, seen from above.
/// Figure 3: a plane with its point a and normal n; figure 4: a sphere with its centre c and radius r; both in
/// the world's coordinate system, from the scene's camera, so that they fit over its picture. Figure 5: the
/// central ray, and the discriminant D of each sphere, which is rotated about the ray into the drawing. Hidden
/// lines are dashed; the colours suit light and dark pages.
#[derive(Args)]
pub struct FigureArgs {
    /// Figure of the lecture: 2, 3, 4 or 5
    #[arg(value_name = "N", value_parser = figure_parser(), hide_possible_values = true)]
    pub figure: Figure,
    /// Scene (TOML) or data: .npy, .csv, .xyz, LAMMPS dumps; `-` is stdin
    ///
    /// [default: the lecture's figure]
    pub scene: Option<PathBuf>,
    /// Drawing (.svg); `-` is stdout
    #[arg(short, long, value_name = "OUT.svg", default_value = "-")]
    pub output: PathBuf,
    /// Draw only the object with this id
    ///
    /// [default: all; in figures 3 and 4 the first plane or sphere]
    #[arg(long, value_name = "ID")]
    pub object: Option<u32>,
    #[command(flatten)]
    pub lang: LangArgs,
    #[command(flatten)]
    pub size: WholeArgs,
    #[command(flatten)]
    pub picture: PictureArgs,
}

/// Reads the number of a figure. Figure 1, the first one to try, has a special error.
fn figure_parser() -> impl TypedValueParser<Value = Figure> {
    let drawings = Figure::ALL.map(|figure| PossibleValue::new(figure.number()));
    let numbers = drawings.into_iter().chain([PossibleValue::new("1").hide(true)]);
    PossibleValuesParser::new(numbers).try_map(|number| {
        let figure = Figure::ALL.into_iter().find(|figure| figure.number() == number);
        figure.ok_or(
            "figure 1 is a rendered picture; create it with `kugelblitz render figure1 -o figure1.png`",
        )
    })
}

/// A figure of the lecture.
#[derive(Serialize)]
pub struct FigureSummary {
    /// Number of the figure in the lecture.
    figure: &'static str,
    /// Width and height, pixels.
    size: [u32; 2],
    /// Id of the object that the figure shows; `null` for all objects, in figures 2 and 5.
    object: Option<u32>,
    /// `en` or `de`.
    lang: &'static str,
}

/// Draws a figure.
pub fn run(args: &FigureArgs, run: &Run) -> Result<Done<FigureSummary>> {
    run.refuse_sharing_stdout([(&args.output, "the figure")])?;
    if !is_stdout(&args.output) {
        check_ending(&args.output, "svg", "a figure is")?;
    }
    let (figure, lang) = (args.figure, args.lang.lang);
    let (path, scene) = match &args.scene {
        Some(path) => (path.as_path(), args.picture.scene(path, args.size.size, run)?),
        None => {
            args.picture.refuse_without_scene()?;
            let (name, text) = figure.scene();
            (Path::new(name), parse_scene(text, Path::new(name))?.into())
        }
    };
    refuse_overwriting([&args.output], &args.scene, &scene)?;
    let pixels = args.size.pixels(&scene, path)?;
    let object = figure.object(&scene, args.object)?;
    let drawn = figure.draw(&scene, object, &pixels, lang)?;
    let file = written(&args.output, drawn.as_bytes())?;
    let (size, number) = ([pixels.width, pixels.height], figure.number());
    let summary = FigureSummary { figure: number, size, object, lang: lang.name() };
    let line = format!("figure {number} of {}", path.shown());
    Ok(Done::with_file(summary, None, file, &line))
}
