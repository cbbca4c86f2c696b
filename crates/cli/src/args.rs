//! The command line's arguments.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Arg, ArgAction, ArgGroup, Args, Parser, Subcommand, value_parser};
use kugelblitz::device::DeviceChoice;
use kugelblitz::generate::{Distribution, MAX_COUNT};
use kugelblitz::picture::Format;
use kugelblitz::query::{Kernel, WorldRay};
use kugelblitz::words::joined;
use kugelblitz_judge::explain::{DEFAULT_DIGITS, Lang, MAX_DIGITS};
use kugelblitz_judge::export::Language;
use kugelblitz_judge::show::Show;

use crate::options::{
    parse_crop, parse_epsilon, parse_number, parse_pixel, parse_ray, parse_size, parser_of,
};
use crate::show::name_of_show;
use crate::{compare, digest, figure, film, info, man, new, picture, version};

/// What each exit code of the programs means.
pub const EXIT_CODES: &str = "\
Exit codes:
  0  done                      5  the device was lost or timed out
  1  failed otherwise          6  a comparison failed
  2  wrong usage               7  does not fit the device's limits or memory
  3  the scene is wrong      130  interrupted
  4  no suitable adapter, or no display for the window";

/// A ray tracer for spheres and planes, on Vulkan and on the CPU.
#[derive(Parser)]
#[command(
    name = "kugelblitz",
    version,
    long_version = version::long(),
    max_term_width = 100,
    disable_help_flag = true,
    after_help = EXIT_CODES
)]
pub struct Cli {
    /// Messages and help
    #[command(flatten)]
    pub talk: TalkArgs,
    /// Command to run
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    Render(RenderArgs),
    #[command(mut_args(scene_in_long_help))]
    Verify(VerifyArgs),
    Trace(TraceArgs),
    #[command(mut_args(scene_in_long_help))]
    Explain(ExplainArgs),
    #[command(mut_args(scene_in_long_help))]
    Compare(compare::CompareArgs),
    #[command(mut_args(scene_in_long_help))]
    Info(info::InfoArgs),
    #[command(mut_args(scene_in_long_help))]
    Report(ReportArgs),
    #[command(mut_args(scene_in_long_help))]
    Export(ExportArgs),
    #[command(mut_args(scene_in_long_help))]
    Figure(figure::FigureArgs),
    View(ViewArgs),
    New(new::NewArgs),
    Generate(GenerateArgs),
    #[command(mut_args(scene_in_long_help))]
    Digest(digest::DigestArgs),
    /// List the Vulkan adapters and their limits
    Probe,
    Completions(CompletionsArgs),
    Man(man::ManArgs),
}

/// Headings of groups of options.
pub const PICTURE: &str = "Picture";
pub const CAMERA: &str = "Camera (overrides the scene)";
pub const LIGHT: &str = "Light (overrides the scene)";
pub const DATA: &str = "Data (.npy, .csv, .xyz), or a scene with one cloud";
const COMPUTATION: &str = "Computation";

/// Hides the options that override the scene in the short help, which is a screen. `render -h` has them.
fn scene_in_long_help(option: Arg) -> Arg {
    let is_of_scene = [CAMERA, LIGHT, DATA].map(Some).contains(&option.get_help_heading());
    let is_hidden = is_of_scene || option.is_hide_short_help_set();
    option.hide_short_help(is_hidden)
}

/// The options of every command.
#[derive(Args, Clone, Copy, Default)]
#[command(next_display_order = 100, next_help_heading = "Messages")]
pub struct TalkArgs {
    /// Print a summary as JSON on standard output
    ///
    /// docs/json.md describes its fields.
    #[arg(long, global = true, hide_short_help = true)]
    pub json: bool,
    /// Print only warnings and errors
    #[arg(short, long, global = true, conflicts_with = "verbose", hide_short_help = true)]
    pub quiet: bool,
    /// Print details, also the messages of the driver
    #[arg(short, long, global = true, hide_short_help = true)]
    pub verbose: bool,
    /// Print help (all options with --help)
    #[arg(short, long, global = true, action = ArgAction::Help)]
    pub help: Option<bool>,
}

/// The kernel of one run.
#[derive(Args)]
#[command(next_help_heading = COMPUTATION)]
pub struct KernelArgs {
    /// lecture, stable, double, certified
    ///
    /// Intersection kernel. `lecture` and `stable` compute in f32, `double` in f64. Only `certified` proves its result.
    #[arg(long, default_value = Kernel::Certified.name(), value_parser = parser_of(Kernel::ALL, Kernel::name),
        hide_possible_values = true)]
    pub kernel: Kernel,
}

/// The device that traces the rays.
#[derive(Args)]
#[command(next_help_heading = COMPUTATION)]
pub struct DeviceArgs {
    /// auto, gpu, cpu, or part of a name
    ///
    /// The name is a Vulkan adapter's. `auto` selects a GPU; without one, the faster of the CPU and a software Vulkan device (`-v`
    /// prints the reason). `gpu` selects the best Vulkan adapter and never falls back to the CPU. Both
    /// select the adapter that WGPU_ADAPTER_NAME names, if it is set. The picture is the same on all
    /// devices.
    #[arg(long, value_name = "DEVICE", default_value = "auto", value_parser = DeviceChoice::parse)]
    pub device: DeviceChoice,
}

/// The size of a whole picture.
#[derive(Args, Clone, Copy)]
#[command(next_help_heading = PICTURE)]
pub struct WholeArgs {
    /// Size, pixels [default: the scene's, or 1280x720]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
}

/// The language of what is written.
#[derive(Args)]
pub struct LangArgs {
    /// Language of the output: en or de
    #[arg(long, default_value = Lang::English.name(), value_parser = parser_of(Lang::ALL, Lang::name),
        hide_possible_values = true)]
    pub lang: Lang,
}

/// Which pixels are traced.
#[derive(Args, Clone, Copy)]
#[command(next_help_heading = PICTURE)]
pub struct SizeArgs {
    #[command(flatten)]
    pub whole: WholeArgs,
    /// Only this part of the picture: left column, top row, width, height, pixels
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_crop, hide_short_help = true)]
    pub crop: Option<[u32; 4]>,
}

/// A scene, and which pixels of it.
#[derive(Args)]
pub struct SceneArgs {
    /// Scene (TOML) or data: .npy, .csv, .xyz, LAMMPS dumps; `-` is stdin
    #[arg(value_name = "SCENE")]
    pub path: PathBuf,
    #[command(flatten)]
    pub size: SizeArgs,
    #[command(flatten)]
    pub picture: picture::PictureArgs,
}

/// Render a picture or a film, from a scene or directly from particle data
///
/// A scene without a camera gets one that frames all spheres. Data are lit by a headlight and a sky,
/// unless options say otherwise.
#[derive(Args)]
pub struct RenderArgs {
    /// Scene (TOML) or data: .npy, .csv, .xyz, LAMMPS dumps; `-` is stdin
    pub scene: PathBuf,
    #[arg(short, long, value_name = "OUT", required_unless_present = "print_scene", help_heading = PICTURE,
        help = format!("Picture: {}; `-` is stdout", joined(Format::ALL.map(|format| format!(".{format}")), ", ")),
        long_help = format!(
            "Picture file. The extension selects the format: {}. `-` writes to standard output and needs --format",
            joined(Format::ALL.map(|format| format!(".{format}")), ", "),
    ))]
    pub output: Option<PathBuf>,
    #[arg(long, help_heading = PICTURE, hide_short_help = true, help = format!(
        "Picture format, if the file name has no extension that selects it: {}",
        joined(Format::ALL.map(Format::name), ", "),
    ))]
    pub format: Option<Format>,
    #[command(flatten)]
    pub size: SizeArgs,
    /// Transparent background (PNG, EXR and NPY)
    ///
    /// Alpha is the pixel's coverage: the fraction of its samples that hit an object.
    #[arg(long, help_heading = PICTURE)]
    pub transparent: bool,
    /// Bits per colour channel, 8 or 16 (PNG and PPM) [default: 8]
    #[arg(long, value_parser = ["8", "16"], hide_possible_values = true, help_heading = PICTURE, hide_short_help = true)]
    pub bits: Option<String>,
    /// Add a channel `level` with the arithmetic that decided each pixel: f32, f64 or exact (EXR and NPY)
    #[arg(long, help_heading = PICTURE, hide_short_help = true)]
    pub certificates: bool,
    /// Also write the colour bars, one for each cloud that is coloured by a column
    #[arg(long, value_name = "LEGEND.svg", requires = "output", help_heading = PICTURE, hide_short_help = true)]
    pub legend: Option<PathBuf>,
    /// Quantity to show as colours (PNG and PPM)
    ///
    /// The legend goes to standard error, with --json to `legend`.
    #[arg(long, value_name = "WHAT", default_value = Show::Color.name(), value_parser = parser_of(Show::ALL, name_of_show),
        help_heading = PICTURE, hide_short_help = true)]
    pub show: Show,
    #[command(flatten)]
    pub picture: picture::DrawArgs,
    #[command(flatten)]
    pub film: film::FilmArgs,
    #[command(flatten)]
    pub device: DeviceArgs,
    #[command(flatten)]
    pub kernel: KernelArgs,
    /// Distance from the surface at which shadow rays start, in scene units; not for certified [default: 0]
    #[arg(long, value_name = "E", allow_negative_numbers = true, value_parser = parse_epsilon, help_heading = COMPUTATION,
        hide_short_help = true)]
    pub epsilon: Option<f64>,
    /// Trace N more times and add their times to --json as `ms_runs`
    #[arg(long, value_name = "N", requires = "json", conflicts_with = "turntable", help_heading = COMPUTATION,
        hide_short_help = true)]
    pub repeat: Option<u32>,
}

/// Compare our GPU and CPU with exact arithmetic, pixel by pixel
///
/// Exact arithmetic takes some microseconds per pixel and object; --size 320x180 makes a check of all
/// pixels fast. For lit scenes and for several samples per pixel, bytes (8 and 16 bits) and linear
/// floats are compared too, which takes some microseconds per sample and light. The device also
/// computes the light if it can, even if the CPU would be faster. The exit code is 6 if a kernel breaks
/// its guarantee.
#[derive(Args)]
pub struct VerifyArgs {
    #[command(flatten)]
    pub scene: SceneArgs,
    /// Number of pixels to compare with exact arithmetic, selected at random
    ///
    /// [default: all, up to 65536; fewer if there are very many objects, lights or samples]
    #[arg(long, value_name = "N", value_parser = parse_number, help_heading = COMPUTATION)]
    pub samples: Option<NonZeroUsize>,
    /// Seed of the random selection
    #[arg(long, value_name = "S", default_value_t = 0, help_heading = COMPUTATION)]
    pub seed: u64,
    #[command(flatten)]
    pub device: DeviceArgs,
    #[command(flatten)]
    pub kernel: KernelArgs,
    /// Verify every kernel
    #[arg(long, conflicts_with = "kernel", help_heading = COMPUTATION)]
    pub all_kernels: bool,
}

/// Trace the rays of a NumPy file
#[derive(Args)]
pub struct TraceArgs {
    /// Scene (TOML) or data: .npy, .csv, .xyz, LAMMPS dumps; `-` is stdin
    ///
    /// It needs no camera.
    pub scene: PathBuf,
    /// Rays: .npy, float64 or float32 of shape (N, 6); `-` is stdin
    ///
    /// Each row is an origin and a direction of any length.
    #[arg(long, value_name = "RAYS.npy", help_heading = "Rays and hits")]
    pub rays: PathBuf,
    /// Hits: .npy, a structured array of shape (N,); `-` is stdout
    ///
    /// Its fields are id (u4), t (f4) and normal (3f4).
    #[arg(short, long, value_name = "HITS.npy", help_heading = "Rays and hits")]
    pub output: PathBuf,
    /// Add a field `level` with the arithmetic that decided each ray: f32, f64 or exact
    #[arg(long, help_heading = "Rays and hits")]
    pub certificates: bool,
    #[command(flatten)]
    pub data: picture::DataArgs,
    #[command(flatten)]
    pub device: DeviceArgs,
    #[command(flatten)]
    pub kernel: KernelArgs,
}

/// Explain one pixel: the lecture's formulas with the numbers of its ray
///
/// For each object: a, b, k, D and the roots (for a plane the quotient), in f32 as the kernels
/// lecture and stable compute them, in f64, and exactly, with the error of each; why the object is
/// visible or not; and the result of every kernel, on the GPU too. For a lit scene also the visible
/// point, n·ω and the occluder of each light, and their sum with its bytes.
#[derive(Args)]
#[command(group(ArgGroup::new("of").args(["pixel", "ray"]).required(true)))]
pub struct ExplainArgs {
    /// Pixel: column and row, counted from 0 at the top left
    ///
    /// Of the whole picture, also with --crop.
    #[arg(
        long,
        value_name = "X,Y",
        value_parser = parse_pixel,
        allow_hyphen_values = true
    )]
    pub pixel: Option<[i64; 2]>,
    /// Ray instead of a pixel: origin and direction, of any length
    #[arg(
        long,
        value_name = "OX,OY,OZ,DX,DY,DZ",
        value_parser = parse_ray,
        allow_hyphen_values = true,
        conflicts_with_all = ["size", "crop"]
    )]
    pub ray: Option<WorldRay>,
    /// Explain all objects, up to the nearest 1000 [default: the nearest 20]
    #[arg(long)]
    pub all: bool,
    /// Print the formulas and verdicts as LaTeX (amsmath)
    #[arg(long, conflicts_with = "json")]
    pub latex: bool,
    /// Digits of each result in a formula
    ///
    /// Intermediate numbers have as many digits as a calculator needs to reproduce the result.
    #[arg(long, value_name = "N", default_value_t = DEFAULT_DIGITS as u8,
        value_parser = value_parser!(u8).range(1..=MAX_DIGITS as i64))]
    pub digits: u8,
    #[command(flatten)]
    pub lang: LangArgs,
    #[command(flatten)]
    pub scene: SceneArgs,
    #[command(flatten)]
    pub device: DeviceArgs,
}

/// Measure speed against error: every kernel on every device
///
/// Without SCENE: the lecture's scenes and hard scenes, error against distance, time against number
/// of spheres, and shadows with and without an epsilon. Errors are against exact arithmetic and the same
/// in every run; times are medians of repeated runs, with their range.
#[derive(Args)]
pub struct ReportArgs {
    /// Scenes (TOML) or data: .npy, .csv, .xyz, LAMMPS dumps; `-` is stdin
    ///
    /// [default: the built-in scenes]
    #[arg(value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    /// Also write a page (.html), all results (.json), the tables (.md) or the plots (.svg); can be
    /// repeated
    #[arg(short, long, value_name = "OUT")]
    pub output: Vec<PathBuf>,
    /// Only this device: auto, gpu, cpu, or part of an adapter's name [default: all]
    #[arg(long, value_name = "DEVICE", value_parser = DeviceChoice::parse)]
    pub device: Option<DeviceChoice>,
    /// Only this kernel: lecture, stable, double or certified; can be repeated [default: all]
    #[arg(long, value_parser = parser_of(Kernel::ALL, Kernel::name), hide_possible_values = true)]
    pub kernel: Vec<Kernel>,
    /// Size of the pictures, pixels [default: 1280x720]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Number of pixels per picture to compare with exact arithmetic [default: 65536]
    #[arg(long, value_name = "N", value_parser = parse_number)]
    pub samples: Option<NonZeroUsize>,
    /// Seed of the random selection and of the generated scenes
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Rounds of three timed runs; each round compiles the shaders again [default: 3]
    #[arg(long, value_name = "N", value_parser = parse_number)]
    pub rounds: Option<NonZeroUsize>,
    #[command(flatten)]
    pub picture: picture::PictureArgs,
}

/// Export a scene to another renderer: POV-Ray or Tachyon
///
/// The file has the same objects, camera, lights and shadows. A sky becomes as many directional
/// lights as it has directions; without light, colours are flat. The command that renders it is
/// printed.
#[derive(Args)]
pub struct ExportArgs {
    /// Renderer: pov or tachyon
    #[arg(hide_possible_values = true, value_parser = parser_of(Language::ALL, Language::name))]
    pub language: Language,
    /// Scene (TOML) or data: .npy, .csv, .xyz, LAMMPS dumps; `-` is stdin
    pub scene: PathBuf,
    /// Output file; `-` is stdout [default: -]
    #[arg(short, long, value_name = "OUT", help_heading = PICTURE)]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub size: WholeArgs,
    #[command(flatten)]
    pub picture: picture::DrawArgs,
}

/// Open a scene in a window
///
/// Drag to orbit, scroll to zoom, click a pixel for its explanation; H lists all controls. The window
/// follows changes of the scene file.
#[derive(Args)]
pub struct ViewArgs {
    /// Scene (TOML) or data: .npy, .csv, .xyz, LAMMPS dumps
    pub scene: PathBuf,
    /// Size of the picture
    #[command(flatten)]
    pub size: WholeArgs,
    /// Language of explanations: en or de
    #[arg(long, default_value = Lang::English.name(), value_parser = parser_of(Lang::ALL, Lang::name),
        hide_possible_values = true)]
    pub lang: Lang,
    /// Print events, one JSON object per line, and nothing else: for tests
    #[arg(long, hide = true)]
    pub log_events: bool,
    /// Lose the device after N frames: for tests
    #[arg(long, value_name = "N", hide = true)]
    pub lose_device_after: Option<u64>,
    /// Camera, light and data
    #[command(flatten)]
    pub picture: picture::DrawArgs,
    /// Device that traces the rays
    #[command(flatten)]
    pub device: DeviceArgs,
    /// Intersection kernel
    #[command(flatten)]
    pub kernel: KernelArgs,
}

/// Generate synthetic spheres, as .npy
///
/// The array is float64 of shape (N, 7): x, y, z, radius, red, green, blue. The same count and seed
/// give the same file on every machine.
#[derive(Args)]
pub struct GenerateArgs {
    /// Number of spheres
    #[arg(long, value_name = "N", value_parser = value_parser!(u64).range(1..=MAX_COUNT))]
    pub count: u64,
    /// Distribution of the spheres in space
    ///
    /// uniform: uniform in the cube of side 1 around the origin, each of radius 0.3 / cbrt(N). lattice:
    /// each sphere touches its six neighbours exactly. packing: touching spheres on the floor y = 0.
    #[arg(long, default_value = Distribution::Uniform.name(), value_parser = parser_of(Distribution::ALL, Distribution::name))]
    pub distribution: Distribution,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Output file (.npy); `-` is stdout
    #[arg(short, long, value_name = "CLOUD.npy")]
    pub output: PathBuf,
    /// Also write a scene file with the spheres and a camera that frames them
    #[arg(long, value_name = "SCENE.toml")]
    pub scene: Option<PathBuf>,
}

/// Print a completion script for a shell
#[derive(Args)]
pub struct CompletionsArgs {
    /// The shell
    pub shell: clap_complete::Shell,
}
