//! What a picture shows where its scene doesn't say it: options, and scenes made of data.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, value_parser};
use glam::DVec3;
use kugelblitz::output::OutputFile;
use kugelblitz::plain::plain_json;
use kugelblitz::scene::{
    Composed, DataWishes, Framing, Light, Paint, Samples, Scene, Sky, Source, Viewpoint,
    WishedLens, Wishes, compose_scene, parse_scene,
};
use kugelblitz::{Error, Result};

use crate::Run;
use crate::args::{MAX_SAMPLES, TalkArgs};
use crate::options::{check_size, numbers};
use crate::output::{is_stdout, print};
use crate::progress::Progress;
use crate::scene::{refuse_overwriting, say_notes};

/// What a picture shows: the options win over the scene.
#[derive(Args, Clone)]
#[command(next_help_heading = "What the picture shows (wins over the scene)")]
pub struct PictureArgs {
    /// Frame everything, seen from this side: quarter, iso, x, -x, y, -y, z, -z [default without a
    /// camera: quarter]
    #[arg(
        long,
        value_name = "SIDE",
        value_parser = view_parser(),
        hide_possible_values = true,
        allow_hyphen_values = true,
        conflicts_with = "position"
    )]
    pub view: Option<Viewpoint>,
    /// Frame everything, with this part of the picture's shorter side free at each edge [default: 0.04]
    #[arg(long, value_name = "PART", value_parser = parse_margin, allow_negative_numbers = true, conflicts_with = "position")]
    pub margin: Option<f64>,
    /// The camera's place
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub position: Option<DVec3>,
    /// The point in the middle of the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_point, allow_hyphen_values = true)]
    pub look_at: Option<DVec3>,
    /// The direction that appears upward: X,Y,Z, or x, -x, y, -y, z, -z [default: y]
    #[arg(long, value_name = "AXIS", value_parser = parse_up, allow_hyphen_values = true)]
    pub up: Option<DVec3>,
    /// Vertical field of view of a perspective camera, degrees [default without a camera: 30]
    #[arg(long, value_name = "DEGREES", value_parser = parse_fov, allow_negative_numbers = true, conflicts_with = "height")]
    pub fov: Option<f64>,
    /// An orthographic camera: the picture's height in the scene's unit, or `auto` to frame everything
    #[arg(long, value_name = "H", value_parser = parse_height, allow_negative_numbers = true)]
    pub height: Option<WishedLens>,
    /// Colour where no object is: "#rrggbb", a name of CSS, or linear R,G,B
    #[arg(long, value_name = "COLOUR", value_parser = parse_paint)]
    pub background: Option<Paint>,
    /// A light in place of all others; can be given several times: eye, a point X,Y,Z, a sun's way
    /// sun:X,Y,Z, each with its intensity behind @ (4,6,3@0.7); or none
    #[arg(long, value_name = "LIGHT", value_parser = parse_light, allow_hyphen_values = true)]
    pub light: Vec<WishedLight>,
    /// Soft light from everywhere: intensity, or intensity,directions; or none
    #[arg(long, value_name = "I,N", value_parser = parse_sky, allow_negative_numbers = true)]
    pub sky: Option<WishedSky>,
    /// Light that every surface gets: a number or a colour; or none
    #[arg(long, value_name = "LIGHT", value_parser = parse_ambient, allow_negative_numbers = true)]
    pub ambient: Option<WishedAmbient>,
    /// N × N samples a pixel, at most 16 × 16 [default: the scene's [image], else 1; 2 for data]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=MAX_SAMPLES).try_map(Samples::new))]
    pub samples: Option<Samples>,
    /// Write the scene that all this amounts to, to standard output or to FILE; without -o, do no more
    #[arg(
        long,
        value_name = "FILE",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = OutputFile::STDOUT
    )]
    pub print_scene: Option<PathBuf>,
    #[command(flatten)]
    pub data: DataArgs,
}

/// How data are read, and the spheres of a scene's only cloud.
#[derive(Args, Clone)]
#[command(next_help_heading = "Data (.npy, .csv, .xyz), or a scene's only cloud")]
pub struct DataArgs {
    /// Radius of all spheres, where the data have none [default: half the median distance between
    /// neighbours]
    #[arg(long, value_name = "R", value_parser = parse_radius, allow_negative_numbers = true)]
    pub radius: Option<f64>,
    /// Colour of all spheres, where the data have none: "#rrggbb", a name, or linear R,G,B
    #[arg(long, value_name = "COLOUR", value_parser = parse_paint, conflicts_with = "color_by")]
    pub color: Option<Paint>,
    /// Make colours of the numbers in this column
    #[arg(long, value_name = "COLUMN")]
    pub color_by: Option<String>,
    /// The colour map: viridis, magma, turbo, coolwarm, grey, …
    #[arg(long, value_name = "NAME")]
    pub colormap: Option<String>,
    /// The numbers at both ends of the colour map [default: the column's least and largest]
    #[arg(long, value_name = "LO,HI", value_parser = parse_range, allow_hyphen_values = true)]
    pub range: Option<[f64; 2]>,
    /// Which columns are which, where their names differ: radius=R,x=px
    #[arg(long, value_name = "KEY=NAME,…", value_delimiter = ',', value_parser = parse_column)]
    pub columns: Vec<(String, String)>,
    /// Which frame of several in a file, from 0
    #[arg(long, value_name = "N")]
    pub frame: Option<u32>,
}

/// A light, or none.
type WishedLight = Option<Light>;

/// A sky, or none.
#[derive(Clone, Copy, Debug)]
pub struct WishedSky(Option<Sky>);

/// Ambient light, or none.
#[derive(Clone, Debug)]
pub struct WishedAmbient(Option<Paint>);

/// The word for no light at all.
const NONE: &str = "none";

impl PictureArgs {
    /// The wishes of these options for a picture of this size, and of a turntable of `n_turns` pictures.
    ///
    /// # Errors
    /// [`Error::Usage`] where `none` stands beside lights; [`Error::TooLarge`].
    pub fn wishes(&self, size: Option<[u32; 2]>, n_turns: u32) -> Result<Wishes> {
        if self.light.len() > 1 && self.light.iter().any(Option::is_none) {
            return Err(Error::Usage("--light none stands alone".into()));
        }
        let DataArgs { radius, color, color_by, colormap, range, columns, frame } =
            self.data.clone();
        Ok(Wishes {
            view: self.view,
            margin: self.margin,
            position: self.position,
            look_at: self.look_at,
            up: self.up,
            lens: self.fov.map(WishedLens::Fov).or(self.height),
            n_turns,
            size: size.map(check_size).transpose()?,
            samples: self.samples,
            background: self.background.clone(),
            lights: (!self.light.is_empty())
                .then(|| self.light.iter().flatten().copied().collect()),
            sky: self.sky.map(|WishedSky(sky)| sky),
            ambient: self.ambient.clone().map(|WishedAmbient(light)| light),
            data: DataWishes { radius, color, color_by, colormap, range, columns, frame },
        })
    }

    /// Reads the scene or the data at `path`, shows how far it is, and says what was chosen.
    ///
    /// # Errors
    /// Those of [`PictureArgs::wishes`] and [`compose_scene`].
    pub fn read(
        &self,
        path: &Path,
        size: Option<[u32; 2]>,
        n_turns: u32,
        talk: &TalkArgs,
        run: &Run,
    ) -> Result<(Arc<Scene>, Composed)> {
        let wishes = self.wishes(size, n_turns)?;
        let progress = Progress::of_bytes(talk, &run.control);
        let mut composed = compose_scene(path, &wishes, &run.control)?;
        drop(progress);
        for note in &composed.notes {
            talk.say(&format!("note: {note}"));
        }
        say_notes(&composed.scene, talk);
        let scene = Arc::new(std::mem::take(&mut composed.scene));
        Ok((scene, composed))
    }

    /// Refuses two outputs on standard output. `what` is the one beside the scene: `the picture`.
    ///
    /// # Errors
    /// [`Error::Usage`]
    pub fn check_outputs(&self, output: Option<&Path>, what: &str, talk: &TalkArgs) -> Result<()> {
        let printed = self.print_scene.as_deref();
        let advice = "write to a file";
        talk.refuse_json_beside(&Vec::from_iter(output), what, advice)?;
        talk.refuse_json_beside(&Vec::from_iter(printed), "the scene", advice)?;
        match [output, printed].into_iter().flatten().all(is_stdout)
            && output.and(printed).is_some()
        {
            false => Ok(()),
            true => Err(Error::Usage(format!(
                "{what} and --print-scene can't both go to standard output; {advice}"
            ))),
        }
    }

    /// Writes what --print-scene asks for. A file is returned, to be put in its place at the end.
    ///
    /// # Errors
    /// Those of [`Composed::text`] and of writing; [`Error::Usage`] where it would replace the input.
    pub fn print(
        &self,
        composed: &Composed,
        scene: &Scene,
        input: &Path,
    ) -> Result<Option<OutputFile>> {
        let Some(place) = &self.print_scene else { return Ok(None) };
        if is_stdout(place) {
            return print(plain_json(&composed.text(None)?).as_bytes()).map(|()| None);
        }
        refuse_overwriting(&[place], &[input], scene)?;
        let mut file = OutputFile::create(place, false)?;
        let text = composed.text(Some(place))?;
        file.write_all(text.as_bytes()).map_err(Error::io(place))?;
        Ok(Some(file))
    }
}

fn view_parser() -> impl TypedValueParser<Value = Viewpoint> {
    PossibleValuesParser::new(Viewpoint::ALL.map(Viewpoint::name)).try_map(|name| {
        Viewpoint::ALL.into_iter().find(|view| view.name() == name).ok_or("there is no such side")
    })
}

fn finite(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|number: &f64| number.is_finite())
}

fn parse_point(text: &str) -> Result<DVec3, String> {
    let point = numbers(text).map(DVec3::from_array).filter(|point| point.is_finite());
    point.ok_or("give three numbers, e.g. 0,1.5,-2".into())
}

fn parse_up(text: &str) -> Result<DVec3, String> {
    let (axis, sign) = match text.strip_prefix('-') {
        Some(axis) => (axis, -1.0),
        None => (text, 1.0),
    };
    match axis {
        "x" => return Ok(sign * DVec3::X),
        "y" => return Ok(sign * DVec3::Y),
        "z" => return Ok(sign * DVec3::Z),
        _ => {}
    }
    match parse_point(text) {
        Ok(up) if up != DVec3::ZERO => Ok(up + DVec3::ZERO),
        _ => Err("give x, -x, y, -y, z, -z, or three numbers, e.g. 0,0,1".into()),
    }
}

fn parse_margin(text: &str) -> Result<f64, String> {
    let most = Framing::MAX_MARGIN;
    let margin = finite(text).filter(|margin| (0.0..=most).contains(margin));
    margin.ok_or(format!("give a part of the picture from 0 to {most}, e.g. 0.1"))
}

fn parse_fov(text: &str) -> Result<f64, String> {
    let fov = finite(text).filter(|&fov| fov > 0.0 && fov < 180.0);
    fov.ok_or("give degrees, greater than 0 and less than 180, e.g. 40".into())
}

fn parse_height(text: &str) -> Result<WishedLens, String> {
    match (text, finite(text)) {
        ("auto", _) => Ok(WishedLens::AnyHeight),
        (_, Some(height)) if height > 0.0 => Ok(WishedLens::Height(height)),
        _ => Err("give a length greater than 0 in the scene's unit, e.g. 2.5, or auto".into()),
    }
}

fn parse_radius(text: &str) -> Result<f64, String> {
    let radius = finite(text).filter(|&radius| radius > 0.0);
    radius.ok_or("give a length greater than 0 in the unit of the data, e.g. 0.5".into())
}

fn parse_range(text: &str) -> Result<[f64; 2], String> {
    let range = numbers(text).filter(|range: &[f64; 2]| range.iter().all(|end| end.is_finite()));
    range.ok_or("give two numbers, e.g. 0,2.5".into())
}

fn parse_column(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, name)) if !key.trim().is_empty() && !name.is_empty() => {
            Ok((key.trim().into(), name.into()))
        }
        _ => Err("give pairs of what a column is and its name, e.g. radius=R,x=px".into()),
    }
}

/// Reads a colour as scenes have it; the scene reader says whether it is one.
fn parse_paint(text: &str) -> Result<Paint, String> {
    let paint = match numbers::<f64, 3>(text) {
        Some(linear) => Paint::Linear(linear),
        None => Paint::Text(text.into()),
    };
    let value = match &paint {
        Paint::Linear(linear) => format!("{linear:?}"),
        _ => format!("'{}'", text.replace(['\'', '\n', '\r'], "?")),
    };
    match parse_scene(&format!("background = {value}"), "a colour".as_ref()) {
        Ok(_) => Ok(paint),
        Err(_) => {
            Err("give \"#rrggbb\" in quotes, a name of CSS, or linear red,green,blue from 0 to 1"
                .into())
        }
    }
}

fn parse_light(text: &str) -> Result<WishedLight, String> {
    if text == NONE {
        return Ok(None);
    }
    let usage = "give eye, a point X,Y,Z, a sun's way sun:X,Y,Z, each with its intensity behind @ where \
                 it is not 1, e.g. 4,6,3@0.7; or none";
    let (place, intensity) = match text.split_once('@') {
        Some((place, intensity)) => (place, finite(intensity).filter(|&light| light >= 0.0)),
        None => (text, Some(1.0)),
    };
    let source = match (place, place.strip_prefix("sun:")) {
        ("eye", _) => Some(Source::Eye),
        (_, Some(way)) => parse_point(way).ok().filter(|way| *way != DVec3::ZERO).map(Source::Sun),
        (point, None) => parse_point(point).ok().map(Source::Point),
    };
    match (source, intensity) {
        (Some(source), Some(intensity)) => {
            let color = [1.0; 3].into();
            Ok(Some(Light { source, color, intensity, shadows: true }))
        }
        _ => Err(usage.into()),
    }
}

fn parse_sky(text: &str) -> Result<WishedSky, String> {
    if text == NONE {
        return Ok(WishedSky(None));
    }
    let (intensity, directions) = match text.split_once(',') {
        Some((intensity, n)) => (intensity, u32::from_str(n.trim()).ok()),
        None => (text, Some(Sky::DIRECTIONS)),
    };
    let intensity = finite(intensity).filter(|&light| light >= 0.0);
    let directions = directions.filter(|n| (1..=Sky::MAX_DIRECTIONS).contains(n));
    match (intensity, directions) {
        (Some(intensity), Some(directions)) => Ok(WishedSky(Some(Sky { intensity, directions }))),
        _ => Err(format!(
            "give the light of an open plane, and where it is not {} the number of directions, at most \
             {}, e.g. 0.5,16; or none",
            Sky::DIRECTIONS,
            Sky::MAX_DIRECTIONS
        )),
    }
}

fn parse_ambient(text: &str) -> Result<WishedAmbient, String> {
    if text == NONE {
        return Ok(WishedAmbient(None));
    }
    match finite(text) {
        Some(light) if light >= 0.0 => Ok(WishedAmbient(Some(Paint::Grey(light)))),
        _ => match parse_paint(text) {
            Ok(paint) => Ok(WishedAmbient(Some(paint))),
            Err(usage) => {
                Err(format!("give a number, 0 or more; or for a colour, {usage}; or none"))
            }
        },
    }
}
