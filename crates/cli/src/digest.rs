//! `kugelblitz digest`

use std::path::{Path, PathBuf};

use clap::Args;
use kugelblitz::input::read_text;
use kugelblitz::output::{self, OutputFile};
use kugelblitz::plain::Shown;
use kugelblitz::query::Kernel;
use kugelblitz::render::n_steps;
use kugelblitz::scene::Samples;
use kugelblitz::{Error, Result};
use kugelblitz_judge::cost::ObjectCounts;
use kugelblitz_judge::markup::{document, escaped};
use serde::Serialize;

use crate::args::{DeviceArgs, PICTURE, SizeArgs, WholeArgs};
use crate::head::{Done, On};
use crate::options::{parse_size, samples_parser};
use crate::output::{refuse_overwriting, text_quoted};
use crate::picture::{GivenOptions, PictureArgs};
use crate::progress::Progress;
use crate::{Run, device, wrong_usage};

/// Print the digest of a picture: a hash of its exact content
///
/// Of the ids, t, normals and 8-bit colours of the kernel certified: the same on every device, with every
/// driver and number of threads. A project can keep it instead of a reference picture and tolerances.
#[derive(Args)]
pub struct DigestArgs {
    /// Scenes (TOML) or data: .npy, .csv, .xyz, LAMMPS dumps; `-` is stdin
    #[arg(value_name = "SCENE", required_unless_present = "check", conflicts_with = "check")]
    pub scenes: Vec<PathBuf>,
    /// Also write the digests to this text file, one line per scene
    #[arg(long, value_name = "DIGESTS.txt", conflicts_with_all = ["check", "crop"], help_heading = DIGESTS)]
    pub write: Option<PathBuf>,
    /// Compare with the digests of such a file
    ///
    /// Size and samples come from the file, all other options from this command line. The exit code is 6 if
    /// a digest differs.
    #[arg(long, value_name = "DIGESTS.txt", conflicts_with_all = ["size", "crop", "samples"], help_heading = DIGESTS)]
    pub check: Option<PathBuf>,
    /// Also write the result of --check as a JUnit report (.xml), for CI systems
    #[arg(long, value_name = "REPORT.xml", requires = "check", conflicts_with = "scenes", help_heading = DIGESTS)]
    pub junit: Option<PathBuf>,
    #[command(flatten)]
    pub size: SizeArgs,
    /// N × N samples per pixel [default: the scene's [image], or 1]
    #[arg(long, value_name = "N", value_parser = samples_parser(), help_heading = PICTURE)]
    pub samples: Option<Samples>,
    #[command(flatten)]
    given: GivenOptions,
    #[command(flatten)]
    pub picture: PictureArgs,
    #[command(flatten)]
    pub device: DeviceArgs,
}

const DIGESTS: &str = "Files of digests";

/// A picture, and what its digest is to be.
struct DigestJob {
    scene: PathBuf,
    size: SizeArgs,
    samples: Option<Samples>,
    expected: Option<String>,
}

/// The digest of a picture.
#[derive(Serialize)]
pub struct Digested {
    #[serde(flatten)]
    on: On,
    /// Path of the scene.
    scene: String,
    /// Width and height, pixels.
    size: [u32; 2],
    /// Number of samples across a pixel, and down it.
    samples: u32,
    /// Objects of the scene.
    objects: ObjectCounts,
    /// `kb2:` and 64 hexadecimal digits, see [digests](digests.md).
    digest: String,
    /// With `--check`: the digest in the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    expected: Option<String>,
}

/// The digests of pictures.
#[derive(Serialize)]
#[serde(untagged)]
pub enum DigestSummary {
    /// A single scene, without `--check`.
    One(Digested),
    /// Several scenes, or `--check`.
    Many {
        /// Digests, in the order of the scenes.
        digests: Vec<Digested>,
    },
}

impl Digested {
    /// A line of the file of `--write`.
    fn line(&self) -> String {
        let Digested { scene, size: [width, height], samples, digest, .. } = self;
        format!("{digest}  {width}x{height}  {samples}  {scene}\n")
    }

    /// What is wrong with it.
    fn fault(&self) -> Option<String> {
        let expected = self.expected.as_ref().filter(|expected| **expected != self.digest)?;
        Some(format!("{}: {}, expected {expected}", self.scene.shown(), self.digest))
    }

    /// Returns the command that renders the picture; `options` are those given for the scene.
    fn render_command(&self, options: &GivenOptions) -> String {
        let Digested { scene, size: [width, height], samples, .. } = self;
        let scene = text_quoted(scene);
        format!(
            "kugelblitz render {scene} -o picture.png --size {width}x{height} --samples {samples}{options}"
        )
    }
}

/// Prints the digests of pictures, or compares them with those of a file.
pub fn run(args: &DigestArgs, run: &Run) -> Result<Done<DigestSummary>> {
    // With --check there is no --write, and --junit is for --check alone.
    let output = args.write.as_ref().or(args.junit.as_ref());
    run.refuse_sharing_stdout(output.map(|output| (output, "the digests")))?;
    output::refuse_overwriting(output, args.scenes.iter().chain(&args.check))?;
    let file = output.map(|path| OutputFile::create(path, false)).transpose()?;
    let DigestArgs { size, samples, .. } = *args;
    let picture = |scene: PathBuf| DigestJob { scene, size, samples, expected: None };
    let pictures = match &args.check {
        Some(path) => pictures_of(path)?,
        None => args.scenes.iter().cloned().map(picture).collect(),
    };
    let digested = |picture| digest(picture, args, output, run);
    let mut digests = pictures.into_iter().map(digested).collect::<Result<Vec<_>>>()?;
    let lines: String = digests.iter().map(Digested::line).collect();
    let fault = |digested: &Digested| {
        let command = digested.render_command(&args.given);
        digested.fault().map(|fault| format!("{fault}\n  {command}\n"))
    };
    let faults: Vec<String> = digests.iter().filter_map(fault).collect();
    let text = if args.junit.is_some() { &junit(&digests, faults.len()) } else { &lines };
    let file = file.map(|file| file.filled(text.as_bytes())).transpose()?;
    let (n, n_wrong) = (digests.len(), faults.len());
    let broken = (n_wrong > 0).then(|| format!("{n_wrong} of {n} digests differ"));
    let words = match &args.check {
        Some(path) => {
            let (wrong, path) = (faults.concat(), path.shown());
            format!("{wrong}{} of {n} digests are those of {path}\n", n - n_wrong)
        }
        None if n == 1 => format!("{}\n", digests[0].digest),
        None => lines,
    };
    let summary = if args.check.is_none() && n == 1 {
        DigestSummary::One(digests.remove(0))
    } else {
        DigestSummary::Many { digests }
    };
    Ok(Done::compared(summary, words, file, broken.as_slice()))
}

/// The pictures that a file of `--write` has.
fn pictures_of(path: &Path) -> Result<Vec<DigestJob>> {
    let text = read_text(path, "digests", "check them in parts")?;
    let picture = |(number, line): (usize, &str)| {
        let wrong = || Error::Input {
            path: path.to_owned(),
            message: format!(
                "line {number}: expected a digest, a size, samples and a scene with two spaces between them, e.g. \
                 `kb2:…  96x54  1  scene.toml`; `kugelblitz digest SCENE… --write` writes such a file"
            ),
        };
        let parts: Vec<&str> = line.splitn(4, "  ").collect();
        let &[digest, size, samples, scene] = &parts[..] else { return Err(wrong()) };
        let size = parse_size(size).map_err(|_| wrong())?;
        let samples = samples.parse().ok().and_then(|n| Samples::new(n).ok()).ok_or_else(wrong)?;
        Ok(DigestJob {
            scene: scene.into(),
            size: SizeArgs { whole: WholeArgs { size: Some(size) }, crop: None },
            samples: Some(samples),
            expected: Some(digest.into()),
        })
    };
    let pictures = (1..).zip(text.lines()).map(picture).collect::<Result<Vec<_>>>()?;
    if pictures.is_empty() {
        return wrong_usage(format!("{}: there is no digest in it", path.shown()));
    }
    Ok(pictures)
}

fn digest(
    DigestJob { scene: path, size, samples, expected }: DigestJob,
    args: &DigestArgs,
    output: Option<&PathBuf>,
    run: &Run,
) -> Result<Digested> {
    let scene = args.picture.scene(&path, size.whole.size, run)?;
    refuse_overwriting(output, [&path], &scene)?;
    let pixels = size.pixels(&scene, &path)?;
    let samples = samples.or(scene.samples).unwrap_or_default();
    let mut session = device::session(&args.device, Kernel::Certified, &scene, pixels.len(), run)?;
    let n_steps = n_steps(&pixels, samples, scene.is_lit());
    let digest = || session.digest(&pixels, samples, &run.control);
    let digest = Progress::start(run, n_steps).during(digest)?;
    Ok(Digested {
        on: On::from(session.device()),
        scene: path.display().to_string(),
        size: [pixels.width, pixels.height],
        samples: samples.across(),
        objects: ObjectCounts::of(&scene),
        digest,
        expected,
    })
}

/// A JUnit report: a test case for each picture, of which so many fail.
fn junit(digests: &[Digested], n_failed: usize) -> String {
    let case = |digested: &Digested| {
        let failure = |fault: String| format!("<failure message=\"{}\"/>", escaped(&fault));
        let failure = digested.fault().map(failure).unwrap_or_default();
        let name = escaped(&digested.scene);
        format!("<testcase classname=\"digest\" name=\"{name}\">{failure}</testcase>\n")
    };
    let cases: String = digests.iter().map(case).collect();
    document(&format!(
        "<testsuite name=\"kugelblitz digest\" tests=\"{}\" failures=\"{n_failed}\">\n{cases}</testsuite>\n",
        digests.len()
    ))
}
