//! What a picture shows where its scene doesn't say it: options, and scenes made of data.

use std::collections::HashSet;
use std::ffi::OsStr;
use std::fmt::{self, Display, Formatter};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::{ArgMatches, Args, Command, FromArgMatches, Id};
use glam::DVec3;
use kugelblitz::error::{Message, Setting};
use kugelblitz::output::{self, OutputFile};
use kugelblitz::plain::{Shown, plain_json};
use kugelblitz::scene::schema::{
    self, Argument, CameraKeys, CloudKeys, ColorSpace, ColumnKeys, LightKeys, MissingRows, SkyKeys,
    option, read_argument,
};
use kugelblitz::scene::{
    Cloud, Color, ColorMap, Composed, Framing, InputFormat, Samples, Scene, SceneOverrides,
    Viewpoint, compose_scene,
};
use kugelblitz::words::joined;
use kugelblitz::{Error, Result};

use crate::args::{CAMERA, DATA, LIGHT, PICTURE};
use crate::options::{check_size, number, parser_of, samples_parser};
use crate::output::{is_stdout, print, refuse_overwriting, text_quoted};
use crate::progress::Progress;

use crate::complain;
use crate::{Run, wrong_usage};

/// What a picture shows: the options win over the scene.
#[derive(Args, Clone, Default)]
pub struct PictureArgs {
    #[command(flatten)]
    pub camera: CameraArgs,
    #[command(flatten)]
    pub light: LightArgs,
    #[command(flatten)]
    pub data: DataArgs,
}

/// The camera.
#[derive(Args, Clone, Default, PartialEq)]
#[command(next_help_heading = CAMERA)]
pub struct CameraArgs {
    /// Frame everything from this side: quarter, iso, x, -x, y, -y, z or -z
    ///
    /// `quarter` is from the front, slightly right and above. [default without a camera: quarter]
    #[arg(
        long,
        value_name = "SIDE",
        value_parser = parser_of(Viewpoint::ALL, Viewpoint::name),
        hide_possible_values = true,
        allow_hyphen_values = true,
        conflicts_with = "position"
    )]
    pub view: Option<Viewpoint>,
    /// Frame everything, with this free margin at each edge, as a fraction of the picture's shorter
    /// side, from 0 to 0.45 [default: 0.04]
    #[arg(long, value_name = "PART", value_parser = parse_margin, allow_negative_numbers = true, conflicts_with = "position",
        hide_short_help = true)]
    pub margin: Option<f64>,
    /// Camera position
    #[arg(long, value_name = "X,Y,Z", value_parser = option(schema::point), allow_hyphen_values = true)]
    pub position: Option<DVec3>,
    /// Point at the centre of the picture
    #[arg(long, value_name = "X,Y,Z", value_parser = option(schema::point), allow_hyphen_values = true)]
    pub look_at: Option<DVec3>,
    /// Up direction: X,Y,Z, or x, -x, y, -y, z, -z
    ///
    /// [default: y]
    #[arg(long, value_name = "AXIS", value_parser = parse_up, allow_hyphen_values = true)]
    pub up: Option<DVec3>,
    /// Perspective camera: vertical field of view
    ///
    /// In degrees, between 0 and 180. [default without a camera: 30]
    #[arg(long, value_name = "DEGREES", value_parser = option(schema::fov), allow_negative_numbers = true, conflicts_with = "height")]
    pub fov: Option<f64>,
    /// Orthographic camera: height of the picture, or auto
    ///
    /// In scene units; `auto` frames everything.
    #[arg(long, value_name = "H", value_parser = value_or("auto", "", option(schema::height)), allow_negative_numbers = true)]
    pub height: Option<ValueOr<f64>>,
}

impl CameraArgs {
    /// Whether no option of the camera was given.
    pub fn is_empty(&self) -> bool {
        *self == CameraArgs::default()
    }
}

/// Light, and the background.
#[derive(Args, Clone, Default)]
#[command(next_help_heading = LIGHT)]
pub struct LightArgs {
    /// eye, X,Y,Z or sun:X,Y,Z, each @INTENSITY; or none
    ///
    /// Light that replaces all lights of the scene; can be repeated. `eye` is a headlight, `X,Y,Z` a
    /// point light, `sun:X,Y,Z` a directional light that shines in this direction. `@` sets the
    /// intensity: 4,6,3@0.7. `none` removes all lights.
    #[arg(long, value_name = "LIGHT", value_parser = value_or("none", LIGHT_USAGE, parse_light), allow_hyphen_values = true)]
    pub light: Vec<ValueOr<LightKeys>>,
    /// Ambient occlusion: intensity, directions; or none
    ///
    /// Soft light from all directions: the intensity on an open plane, and the number of directions,
    /// from 1 to 65536 [default: 16]. Each direction costs one shadow ray per sample. `none` removes
    /// the sky.
    #[arg(long, value_name = "I,N", value_parser = value_or("none", SKY_USAGE, parse_sky), allow_negative_numbers = true)]
    pub sky: Option<ValueOr<SkyKeys>>,
    /// Uniform light on every surface: a number or a colour; or none
    #[arg(long, value_name = "LIGHT", value_parser = value_or("none", "", option(schema::ambient)), allow_negative_numbers = true,
        hide_short_help = true)]
    pub ambient: Option<ValueOr<Color>>,
    /// Background colour
    ///
    /// "#rrggbb", a CSS name, or linear R,G,B from 0 to 1.
    #[arg(long, value_name = "COLOR", value_parser = option(schema::color))]
    pub background: Option<Color>,
}

/// How a picture is drawn, and the scene with all options.
#[derive(Args, Clone)]
#[command(next_help_heading = PICTURE)]
pub struct DrawArgs {
    /// N × N samples per pixel, for smooth edges
    ///
    /// Antialiasing, with N from 1 to 16. [default: the scene's [image], or 1; 2 for data]
    #[arg(long, value_name = "N", value_parser = samples_parser())]
    pub samples: Option<Samples>,
    /// Write the scene file of this picture
    ///
    /// With all options, to FILE or to standard output. Without --output, nothing is rendered.
    #[arg(
        long,
        value_name = "FILE",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = OutputFile::STDOUT
    )]
    pub print_scene: Option<PathBuf>,
    #[command(flatten)]
    pub picture: PictureArgs,
}

/// How data are read, and the spheres of a scene's only cloud.
#[derive(Args, Clone, Default)]
#[command(next_help_heading = DATA)]
pub struct DataArgs {
    /// Radius of all spheres, if the data have none
    ///
    /// [default: half the median distance between neighbours]
    #[arg(long, value_name = "R", value_parser = option(schema::radius), allow_negative_numbers = true)]
    pub radius: Option<f64>,
    /// Colour of all spheres, if the data have none
    ///
    /// "#rrggbb", a CSS name, or linear R,G,B from 0 to 1.
    #[arg(long, value_name = "COLOR", value_parser = option(schema::color), conflicts_with = "color_by")]
    pub color: Option<Color>,
    /// Colour the spheres by a column
    #[arg(long, value_name = "COLUMN")]
    pub color_by: Option<String>,
    /// Colour map: viridis, magma, turbo, coolwarm, …
    ///
    /// [default: viridis]
    #[arg(long, value_name = "NAME", value_parser = option(schema::colormap))]
    pub colormap: Option<ColorMap>,
    /// Values at the ends of the colour map
    ///
    /// [default: the column's minimum and maximum]
    #[arg(long, value_name = "LO,HI", value_parser = option(schema::range), allow_hyphen_values = true)]
    pub range: Option<[f64; 2]>,
    /// Frame, if the file has several, from 0
    ///
    /// -1 is the last one. [default: 0]
    #[arg(long, value_name = "N", value_parser = option(schema::frame), allow_negative_numbers = true)]
    pub frame: Option<i32>,
    /// Meaning of columns with unusual names: radius=R,x=px
    ///
    /// radius=false ignores a column; z=0.0 is a coordinate of all spheres.
    #[arg(long, value_name = "KEY=NAME,…", value_delimiter = ',', value_parser = parse_column, hide_short_help = true)]
    pub columns: Vec<(String, String)>,
    /// Colour space of colours in the data: srgb or linear [default: srgb]
    #[arg(long, value_name = "SPACE", value_parser = option(schema::color_space), hide_short_help = true)]
    pub color_space: Option<ColorSpace>,
    /// Line that names the columns of a table, from 1
    #[arg(long, value_name = "LINE", value_parser = option(schema::header), hide_short_help = true)]
    pub header: Option<u32>,
    /// Rows without a coordinate or a radius: `skip` leaves them out [default: an error]
    #[arg(long, value_name = "WHAT", value_parser = option(schema::missing), hide_short_help = true)]
    pub missing: Option<MissingRows>,
    /// Format of SCENE, if its content is not recognized: toml, npy, csv, xyz or lammps
    #[arg(long, value_name = "FORMAT", value_parser = parser_of(InputFormat::ALL.map(|(_, format)| format), name_of_input),
        hide_possible_values = true, hide_short_help = true)]
    pub input_format: Option<InputFormat>,
}

/// Returns the name of an input format.
fn name_of_input(format: InputFormat) -> &'static str {
    InputFormat::ALL.iter().find(|(_, other)| *other == format).map_or("", |(name, _)| name)
}

/// A value, or the word in its place: `auto` for a height, `none` for light. By this name clap takes it for a value.
type ValueOr<T> = Option<T>;

impl PictureArgs {
    /// The keys of these options for a picture of this size.
    ///
    /// # Errors
    /// [`Error::Usage`] where `none` stands beside lights; [`Error::TooLarge`].
    pub fn overrides(&self, size: Option<[u32; 2]>) -> Result<SceneOverrides> {
        let PictureArgs { camera, light, data } = self;
        if light.light.len() > 1 && light.light.contains(&None) {
            return wrong_usage("--light none stands alone");
        }
        let lights = light.light.iter().flatten().cloned().collect();
        Ok(SceneOverrides {
            view: camera.view,
            margin: camera.margin,
            is_height_chosen: camera.height == Some(None),
            camera: CameraKeys {
                position: camera.position,
                look_at: camera.look_at,
                up: camera.up,
                fov: camera.fov,
                height: camera.height.flatten(),
                ..CameraKeys::default()
            },
            size: size.map(check_size).transpose()?,
            background: light.background,
            lights: (!light.light.is_empty()).then_some(lights),
            sky: light.sky.clone(),
            ambient: light.ambient,
            cloud: data.keys()?,
            input_format: data.input_format,
            ..SceneOverrides::default()
        })
    }

    /// Reads the scene that `render` with these options draws, with a camera that frames all spheres if there is none.
    ///
    /// # Errors
    /// Those of [`PictureArgs::overrides`] and [`compose_scene`].
    pub fn scene(&self, path: &Path, size: Option<[u32; 2]>, run: &Run) -> Result<Arc<Scene>> {
        let overrides = SceneOverrides { needs_camera: true, ..self.overrides(size)? };
        read_composed(path, &overrides, run).map(|(scene, _)| scene)
    }

    /// Reads the scene for a command that needs no camera.
    ///
    /// # Errors
    /// Returns the errors of [`PictureArgs::scene`].
    pub fn scene_of_rays(
        &self,
        path: &Path,
        size: Option<[u32; 2]>,
        run: &Run,
    ) -> Result<Arc<Scene>> {
        read_composed(path, &self.overrides(size)?, run).map(|(scene, _)| scene)
    }

    /// Refuses options for the scenes of the program, which are shown as they are.
    ///
    /// # Errors
    /// [`Error::Usage`]
    pub fn refuse_without_scene(&self) -> Result<()> {
        if self.overrides(None)? == SceneOverrides::default() {
            return Ok(());
        }
        wrong_usage("options of what the picture shows need a SCENE; name its file")
    }
}

/// Options of [`CameraArgs`] and [`DataArgs`] as they were given, for the command line of another command.
///
/// Place it before these two in a command: reading their values removes the texts.
#[derive(Clone, Default)]
pub struct GivenOptions {
    text: String,
}

impl FromArgMatches for GivenOptions {
    fn from_arg_matches(matches: &ArgMatches) -> Result<GivenOptions, clap::Error> {
        let group = |name| matches.try_get_many::<Id>(name).ok().flatten();
        let mut options: Vec<&Id> = Vec::new();
        for id in ["CameraArgs", "LightArgs", "DataArgs"].into_iter().filter_map(group).flatten() {
            // A group has an option as often as it was given.
            if !options.contains(&id) {
                options.push(id);
            }
        }
        let option = |id: &Id| {
            let name = id.as_str().replace('_', "-");
            let values = matches.try_get_raw(id.as_str()).ok().flatten();
            let value =
                move |value: &OsStr| format!(" --{name}={}", text_quoted(&value.to_string_lossy()));
            values.into_iter().flatten().map(value)
        };
        Ok(GivenOptions { text: options.into_iter().flat_map(option).collect() })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = GivenOptions::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Args for GivenOptions {
    fn augment_args(command: Command) -> Command {
        command
    }

    fn augment_args_for_update(command: Command) -> Command {
        command
    }
}

impl Display for GivenOptions {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// Reads the scene or the data at `path`, shows how far it is, and says what was chosen.
///
/// # Errors
/// Those of [`compose_scene`].
pub fn read_composed(
    path: &Path,
    overrides: &SceneOverrides,
    run: &Run,
) -> Result<(Arc<Scene>, Composed)> {
    let compose = || compose_scene(path, overrides, &run.control);
    let mut composed = Progress::of_bytes(run).during(compose)?;
    // Options are for one cloud.
    let word = if composed.scene.clouds.len() > 1 { Setting::to_string } else { complain::option };
    for note in composed.notes.iter().chain(&composed.scene.notes) {
        run.say(&format!("note: {}", note.worded(word)));
    }
    for cloud in composed.scene.clouds.iter().filter(|cloud| !cloud.unused_columns.is_empty()) {
        run.note(&format!("{}: {}", cloud.path.shown(), unused_columns(cloud)));
    }
    let scene = Arc::new(std::mem::take(&mut composed.scene));
    Ok((scene, composed))
}

impl DrawArgs {
    /// The keys of these options for a picture of this size.
    ///
    /// # Errors
    /// Those of [`PictureArgs::overrides`].
    pub fn overrides(&self, size: Option<[u32; 2]>) -> Result<SceneOverrides> {
        let overrides = self.picture.overrides(size)?;
        Ok(SceneOverrides { samples: self.samples, needs_camera: true, ..overrides })
    }

    /// The place of --print-scene, with its name.
    pub fn printed(&self) -> Option<(&PathBuf, &'static str)> {
        self.print_scene.as_ref().map(|place| (place, "--print-scene"))
    }

    /// Writes the scene alone.
    ///
    /// # Errors
    /// [`Error::Usage`] beside --json; those of [`read_composed`], [`DrawArgs::print`] and [`output::commit`].
    pub fn print_alone(&self, path: &PathBuf, overrides: &SceneOverrides, run: &Run) -> Result<()> {
        run.refuse_sharing_stdout(self.printed())?;
        let (scene, composed) = read_composed(path, overrides, run)?;
        output::commit(self.print(&composed, &scene, path)?, &run.control)
    }

    /// Writes what --print-scene asks for. A file is returned, to be put in its place at the end.
    ///
    /// # Errors
    /// Those of [`Composed::text`] and of writing; [`Error::Usage`] where it would replace the input.
    pub fn print(
        &self,
        composed: &Composed,
        scene: &Scene,
        input: &PathBuf,
    ) -> Result<Option<OutputFile>> {
        let Some(place) = &self.print_scene else { return Ok(None) };
        if is_stdout(place) {
            return print(plain_json(&composed.text(None)?).as_bytes()).map(|()| None);
        }
        refuse_overwriting([place], [input], scene)?;
        let file = OutputFile::create(place, false)?;
        file.filled(composed.text(Some(place))?.as_bytes()).map(Some)
    }
}

impl DataArgs {
    fn keys(&self) -> Result<CloudKeys> {
        let mut said = HashSet::new();
        if let Some((key, _)) = self.columns.iter().find(|(key, _)| !said.insert(key)) {
            return wrong_usage(format!("--columns: `{key}` is said twice; say it once"));
        }
        let pair = |(key, value): &(String, String)| (key.clone(), column_argument(value));
        let columns = Argument::Table(self.columns.iter().map(pair).collect());
        let columns =
            read_argument::<ColumnKeys>("columns", &columns, schema::table).map_err(|fault| {
                Error::Usage(Message::new(format!("--columns: {}", fault.message), fault.hint))
            })?;
        Ok(CloudKeys {
            radius: self.radius,
            color: self.color,
            columns: Some(columns).filter(|_| !self.columns.is_empty()),
            color_space: self.color_space,
            color_by: self.color_by.clone(),
            colormap: self.colormap.clone(),
            range: self.range,
            header: self.header,
            missing: self.missing,
            frame: self.frame,
            ..CloudKeys::default()
        })
    }
}

/// Returns the names of the columns of a cloud that are not used.
pub fn unused_columns(cloud: &Cloud) -> String {
    let names = joined(cloud.unused_columns.iter().map(|name| name.shown()), ", ");
    format!("columns not used: {names}")
}

/// Reads the value of a column: `false` for none, a number with a decimal point for all spheres, else a name.
fn column_argument(value: &str) -> Argument {
    let number = value.parse().ok().filter(|number: &f64| number.is_finite());
    match number.filter(|_| value.contains(['.', 'e', 'E'])) {
        Some(number) => Argument::Float(number),
        None if value == "false" => Argument::Boolean(false),
        None => Argument::Text(value.into()),
    }
}

/// Reads a value, or the word in its place; `usage` says more of what to give.
fn value_or<T: Clone + Send + Sync + 'static>(
    word: &'static str,
    usage: &'static str,
    parse: impl Fn(&str) -> Result<T, String> + Clone + Send + Sync + 'static,
) -> impl Fn(&str) -> Result<ValueOr<T>, String> + Clone + Send + Sync + 'static {
    move |text| {
        if text == word {
            return Ok(None);
        }
        parse(text).map(Some).map_err(|help| format!("{help}{usage}; or {word}"))
    }
}

fn parse_up(text: &str) -> Result<DVec3, String> {
    let (axis, sign) = text.strip_prefix('-').map_or((text, 1.0), |axis| (axis, -1.0));
    match axis {
        "x" => Ok(sign * DVec3::X),
        "y" => Ok(sign * DVec3::Y),
        "z" => Ok(sign * DVec3::Z),
        _ => option(schema::direction)(text)
            .map_err(|help| format!("{help}; or x, -x, y, -y, z, -z")),
    }
}

fn parse_margin(text: &str) -> Result<f64, String> {
    let most = Framing::MAX_MARGIN;
    let usage = format!("give a part of the picture from 0 to {most}, e.g. 0.1");
    number(text, |margin| (0.0..=most).contains(&margin), &usage)
}

fn parse_column(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, name)) if !key.trim().is_empty() && !name.is_empty() => {
            Ok((key.trim().into(), name.into()))
        }
        _ => Err("expected KEY=NAME pairs, for example radius=R,x=px".into()),
    }
}

const LIGHT_USAGE: &str = "; give eye, a point X,Y,Z, a sun's way sun:X,Y,Z, each with its intensity behind @ where it is \
                     not 1, e.g. 4,6,3@0.7";

fn parse_light(text: &str) -> Result<LightKeys, String> {
    let (place, intensity) = text.split_once('@').unwrap_or((text, "1"));
    let (position, direction) = match place.strip_prefix("sun:") {
        Some(way) => (None, Some(option(schema::direction)(way)?)),
        None => (Some(option(schema::lamp)(place)?), None),
    };
    Ok(LightKeys {
        position,
        direction,
        intensity: Some(option(schema::intensity)(intensity)?),
        ..LightKeys::default()
    })
}

const SKY_USAGE: &str =
    "; give the light of an open plane, and perhaps the number of directions, e.g. 0.5,16";

fn parse_sky(text: &str) -> Result<SkyKeys, String> {
    let (intensity, directions) = match text.split_once(',') {
        Some((intensity, number)) => (intensity, Some(option(schema::directions)(number)?)),
        None => (text, None),
    };
    Ok(SkyKeys {
        intensity: Some(option(schema::intensity)(intensity)?),
        directions,
        ..SkyKeys::default()
    })
}
