//! The command line's arguments.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{ArgGroup, Args, Parser, Subcommand, value_parser};
use kugelblitz::device::DeviceChoice;
use kugelblitz::generate::{Distribution, MAX_COUNT};
use kugelblitz::picture::Format;
use kugelblitz::trace::{Kernel, WorldRay};
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
    after_help = EXIT_CODES
)]
pub struct Cli {
    /// How much it says
    #[command(flatten)]
    pub talk: TalkArgs,
    /// What it is to do
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Subcommand)]
pub enum Command {
    Render(RenderArgs),
    Verify(VerifyArgs),
    Trace(TraceArgs),
    Explain(ExplainArgs),
    Compare(compare::CompareArgs),
    Info(info::InfoArgs),
    Report(ReportArgs),
    Export(ExportArgs),
    Figure(figure::FigureArgs),
    View(ViewArgs),
    New(new::NewArgs),
    Generate(GenerateArgs),
    Digest(digest::DigestArgs),
    /// List the Vulkan adapters and their limits
    Probe,
    Completions(CompletionsArgs),
    Man(man::ManArgs),
}

/// The options of every command.
#[derive(Args, Clone, Copy)]
#[command(next_display_order = 100)]
pub struct TalkArgs {
    /// Print a machine-readable summary (JSON) on standard output
    #[arg(long, global = true)]
    pub json: bool,
    /// Say nothing but warnings and errors
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say more, also what the driver prints
    #[arg(short, long, global = true)]
    pub verbose: bool,
}

/// The kernel of one run.
#[derive(Args)]
pub struct KernelArgs {
    /// Intersection kernel
    #[arg(long, default_value = Kernel::Certified.name(), value_parser = parser_of(Kernel::ALL, Kernel::name))]
    pub kernel: Kernel,
}

/// Where the rays are traced.
#[derive(Args)]
pub struct DeviceArgs {
    /// auto, gpu, cpu, or a part of an adapter's name
    ///
    /// `auto` takes a real GPU; where there is none, the quicker of the CPU and a Vulkan device in
    /// software (`-v` says why). `gpu` takes the best Vulkan adapter and never falls back. Both take
    /// the adapter that WGPU_ADAPTER_NAME names, where it is set.
    #[arg(long, value_name = "DEVICE", default_value = "auto", value_parser = DeviceChoice::parse)]
    pub device: DeviceChoice,
}

/// The size of a whole picture.
#[derive(Args, Clone, Copy)]
pub struct WholeArgs {
    /// Size of the picture, in pixels [default: the scene's [image], else 1280x720]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
}

/// The language of what is written.
#[derive(Args)]
pub struct LangArgs {
    /// Language of all words: en or de
    #[arg(long, default_value = Lang::English.name(), value_parser = parser_of(Lang::ALL, Lang::name),
        hide_possible_values = true)]
    pub lang: Lang,
}

/// Which pixels are traced.
#[derive(Args, Clone, Copy)]
pub struct SizeArgs {
    #[command(flatten)]
    pub whole: WholeArgs,
    /// Only this part of the picture: left column, top row, width, height
    #[arg(long, value_name = "X,Y,W,H", value_parser = parse_crop)]
    pub crop: Option<[u32; 4]>,
}

/// A scene, and which pixels of it.
#[derive(Args)]
pub struct SceneArgs {
    /// Scene file (TOML), or data: .npy, .csv, .xyz, LAMMPS dumps; `-` is standard input
    #[arg(value_name = "SCENE")]
    pub path: PathBuf,
    #[command(flatten)]
    pub size: SizeArgs,
    #[command(flatten)]
    pub picture: picture::PictureArgs,
}

/// Render a picture or a turntable film, of a scene or straight from data
///
/// Where there is no camera, one is placed so that it frames all spheres. Data are lit from the eye and
/// by a sky.
#[derive(Args)]
pub struct RenderArgs {
    /// Scene file (TOML), or data: .npy, .csv, .xyz, LAMMPS dumps; `-` is standard input
    pub scene: PathBuf,
    #[arg(short, long, value_name = "OUT", required_unless_present = "print_scene", help = format!(
        "Picture file; its ending ({}) tells the format. `-` is standard output",
        joined(Format::ALL.map(|format| format!(".{format}")), ", "),
    ))]
    pub output: Option<PathBuf>,
    /// Also write the bar of colours of each cloud that is coloured by a column, with its numbers
    #[arg(long, value_name = "LEGEND.svg", requires = "output")]
    pub legend: Option<PathBuf>,
    #[arg(long, help = format!(
        "Format, where the file's name doesn't tell it: {}",
        joined(Format::ALL.map(Format::name), ", "),
    ))]
    pub format: Option<Format>,
    /// Bits a colour channel in PNG and PPM: 8 or 16 [default: 8]
    #[arg(long, value_parser = ["8", "16"], hide_possible_values = true)]
    pub bits: Option<String>,
    /// Also write which level decided each pixel (EXR and NPY)
    #[arg(long)]
    pub certificates: bool,
    /// Leave the background out: alpha is the share of samples that hit an object (PNG, EXR and NPY)
    #[arg(long)]
    pub transparent: bool,
    /// How far from a surface shadow rays start, in the scene's unit; not for certified [default: 0]
    #[arg(long, value_name = "E", allow_negative_numbers = true, value_parser = parse_epsilon)]
    pub epsilon: Option<f64>,
    /// What the picture shows of each pixel: numbers as colours, with a legend on standard error, or in
    /// --json under `legend` (PNG and PPM)
    #[arg(long, value_name = "WHAT", default_value = Show::Color.name(), value_parser = parser_of(Show::ALL, name_of_show))]
    pub show: Show,
    /// Trace N times more and add their times to --json as `ms_runs`
    #[arg(long, value_name = "N", requires = "json", conflicts_with = "turntable")]
    pub repeat: Option<u32>,
    #[command(flatten)]
    pub kernel: KernelArgs,
    #[command(flatten)]
    pub device: DeviceArgs,
    #[command(flatten)]
    pub size: SizeArgs,
    #[command(flatten)]
    pub picture: picture::DrawArgs,
    #[command(flatten)]
    pub film: film::FilmArgs,
}

/// Compare GPU, CPU and exact arithmetic, pixel by pixel
///
/// Exact arithmetic takes some microseconds a pixel and object: with --size 320x180 a look at all
/// pixels is quick. Of scenes with light, and of pixels with several samples, bytes (8 and 16 bits)
/// and linear floats are compared as well: the exact ones take some microseconds for each sample and
/// light. The device also computes the light if it can, even if the CPU would be faster. Exit code 6 if a
/// kernel breaks its promise.
#[derive(Args)]
pub struct VerifyArgs {
    /// Pixels to compare with exact arithmetic, drawn at random [default: all up to 65536,
    /// fewer where there are very many objects, lights or samples]
    #[arg(long, value_name = "N", value_parser = parse_number)]
    pub samples: Option<NonZeroUsize>,
    /// Seed of the random draw
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    #[command(flatten)]
    pub kernel: KernelArgs,
    /// Verify every kernel
    #[arg(long, conflicts_with = "kernel")]
    pub all_kernels: bool,
    #[command(flatten)]
    pub device: DeviceArgs,
    #[command(flatten)]
    pub scene: SceneArgs,
}

/// Trace any rays of a NumPy file
#[derive(Args)]
pub struct TraceArgs {
    /// Scene file (TOML), which needs no camera, or data: .npy, .csv, .xyz, LAMMPS dumps; `-` is
    /// standard input
    pub scene: PathBuf,
    /// Rays: .npy, shape (N, 6), float64 or float32: origins and directions of any length. `-` is
    /// standard input
    #[arg(long, value_name = "RAYS.npy")]
    pub rays: PathBuf,
    /// Hits: .npy, a structured array (N,) with id (u4), t (f4), normal (3f4). `-` is standard
    /// output
    #[arg(short, long, value_name = "HITS.npy")]
    pub output: PathBuf,
    /// Also write which level decided each ray
    #[arg(long)]
    pub certificates: bool,
    #[command(flatten)]
    pub kernel: KernelArgs,
    #[command(flatten)]
    pub device: DeviceArgs,
    #[command(flatten)]
    pub data: picture::DataArgs,
}

/// Show the lecture's formulas with one ray's numbers in them
///
/// For each object: a, b, k, D and the roots (for a plane the quotient) in f32 as the kernels
/// lecture and stable calculate them, in f64 and exactly, with the error of each; why the object is
/// seen or not; and what every kernel shows, on the GPU too. With light in the scene also the point
/// that is seen, each light's way to it, n·ω and what is in its way, and the sum with its bytes.
#[derive(Args)]
#[command(group(ArgGroup::new("of").args(["pixel", "ray"]).required(true)))]
pub struct ExplainArgs {
    /// The pixel, counted from 0 at the top left of the whole picture
    #[arg(
        long,
        value_name = "X,Y",
        value_parser = parse_pixel,
        allow_hyphen_values = true
    )]
    pub pixel: Option<[i64; 2]>,
    /// A ray in place of a pixel: its origin and its direction, of any length
    #[arg(
        long,
        value_name = "OX,OY,OZ,DX,DY,DZ",
        value_parser = parse_ray,
        allow_hyphen_values = true,
        conflicts_with_all = ["size", "crop"]
    )]
    pub ray: Option<WorldRay>,
    /// Explain all objects, but at most the nearest 1000 [default: the nearest 20]
    #[arg(long)]
    pub all: bool,
    /// Print the formulas and verdicts as LaTeX (amsmath)
    #[arg(long, conflicts_with = "json")]
    pub latex: bool,
    /// Digits of each result in a formula; numbers on the way to it have as many as a calculator needs
    #[arg(long, value_name = "N", default_value_t = DEFAULT_DIGITS as u8,
        value_parser = value_parser!(u8).range(1..=MAX_DIGITS as i64))]
    pub digits: u8,
    #[command(flatten)]
    pub lang: LangArgs,
    #[command(flatten)]
    pub device: DeviceArgs,
    #[command(flatten)]
    pub scene: SceneArgs,
}

/// Measure speed against error: every kernel on every device
///
/// Without scenes: the lecture's and a hard set, error against distance, time against number of
/// spheres, and shadows with and without an epsilon. Errors are against exact arithmetic and the same
/// in every run; times are medians of repeated runs with their range.
#[derive(Args)]
pub struct ReportArgs {
    /// Scene files (TOML), or data: .npy, .csv, .xyz, LAMMPS dumps; `-` is standard input [default:
    /// the built-in scenes]
    #[arg(value_name = "SCENE")]
    pub scenes: Vec<PathBuf>,
    /// Also write a page (.html), all figures (.json), the tables (.md), or the plots (.svg); can be
    /// given several times
    #[arg(short, long, value_name = "OUT")]
    pub output: Vec<PathBuf>,
    /// Only this device: auto, gpu, cpu, or a part of an adapter's name [default: all]
    #[arg(long, value_name = "DEVICE", value_parser = DeviceChoice::parse)]
    pub device: Option<DeviceChoice>,
    /// Only this intersection kernel; can be given several times [default: all]
    #[arg(long, value_parser = parser_of(Kernel::ALL, Kernel::name))]
    pub kernel: Vec<Kernel>,
    /// Size of the pictures, in pixels [default: 1280x720]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,
    /// Pixels of each picture to compare with exact arithmetic, drawn at random [default: 65536]
    #[arg(long, value_name = "N", value_parser = parse_number)]
    pub samples: Option<NonZeroUsize>,
    /// Seed of the random draw, and of the generated scenes
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// Rounds of three timed runs each; shaders are compiled anew in each [default: 3]
    #[arg(long, value_name = "N", value_parser = parse_number)]
    pub rounds: Option<NonZeroUsize>,
    #[command(flatten)]
    pub picture: picture::PictureArgs,
}

/// Write a scene for another renderer: POV-Ray or Tachyon
///
/// The same objects and camera, with flat colours: no light, no shadow, no reflection.
#[derive(Args)]
pub struct ExportArgs {
    /// The other renderer's language
    #[arg(value_parser = parser_of(Language::ALL, Language::name))]
    pub language: Language,
    /// Scene file (TOML), or data: .npy, .csv, .xyz, LAMMPS dumps; `-` is standard input
    pub scene: PathBuf,
    /// File for the other renderer. `-` is standard output [default: -]
    #[arg(short, long, value_name = "OUT")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub size: WholeArgs,
    #[command(flatten)]
    pub picture: picture::DrawArgs,
}

/// Look at a scene in a window and move through it
///
/// Drag to orbit, use the wheel to zoom, click a pixel to ask why it shows what it shows; H lists
/// all controls. The scene file is watched: what changes in it is seen at once.
#[derive(Args)]
pub struct ViewArgs {
    /// Scene file (TOML), or data: .npy, .csv, .xyz, LAMMPS dumps
    pub scene: PathBuf,
    /// The kernel
    #[command(flatten)]
    pub kernel: KernelArgs,
    /// Where the rays are traced
    #[command(flatten)]
    pub device: DeviceArgs,
    /// The size of the picture
    #[command(flatten)]
    pub size: WholeArgs,
    /// Language of explanations: en or de
    #[arg(long, default_value = Lang::English.name(), value_parser = parser_of(Lang::ALL, Lang::name),
        hide_possible_values = true)]
    pub lang: Lang,
    /// Print what happens, one JSON object a line, in place of all else: for tests
    #[arg(long, hide = true)]
    pub log_events: bool,
    /// Give the device up after N frames, as if it had been lost: for tests
    #[arg(long, value_name = "N", hide = true)]
    pub lose_device_after: Option<u64>,
    /// What is shown where the scene does not say it
    #[command(flatten)]
    pub picture: picture::DrawArgs,
}

/// Generate synthetic spheres, as .npy
///
/// The array is float64 of shape (N, 7): x, y, z, radius, red, green, blue.
/// The same count and seed give the same file on every machine.
#[derive(Args)]
pub struct GenerateArgs {
    /// Number of spheres
    #[arg(long, value_name = "N", value_parser = value_parser!(u64).range(1..=MAX_COUNT))]
    pub count: u64,
    /// How the spheres lie in space
    ///
    /// uniform: evenly in the cube of side 1 about the origin, each of radius 0.3 / cbrt(N);
    /// lattice: each touches its six neighbours exactly; packing: touching spheres on the floor y = 0.
    #[arg(long, default_value = Distribution::Uniform.name(), value_parser = parser_of(Distribution::ALL, Distribution::name))]
    pub distribution: Distribution,
    /// Seed of the random numbers
    #[arg(long, value_name = "S", default_value_t = 0)]
    pub seed: u64,
    /// The file, .npy. `-` is standard output
    #[arg(short, long, value_name = "CLOUD.npy")]
    pub output: PathBuf,
    /// Also write a scene file with the cloud and a camera that sees all of it
    #[arg(long, value_name = "SCENE.toml")]
    pub scene: Option<PathBuf>,
}

/// Print a completion script for a shell
#[derive(Args)]
pub struct CompletionsArgs {
    /// The shell
    pub shell: clap_complete::Shell,
}
