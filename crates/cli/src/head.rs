//! The JSON summaries: the head of each, and the parts that several have.

use std::ffi::OsString;
use std::fmt::{self, Display, Formatter};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use kugelblitz::device::Device;
use kugelblitz::error::ErrorSubject;
use kugelblitz::gpu::AdapterFacts;
use kugelblitz::lighting::ColorCounts;
use kugelblitz::lighting::RenderStats;
use kugelblitz::output::{self, OutputFile};
use kugelblitz::plain::Shown;
use kugelblitz::query::StageCounts;
use kugelblitz::scene::Samples;
use kugelblitz::words::{duration, joined};
use kugelblitz::{Error, Result, Session, SetupTimes};
use kugelblitz_judge::cost::ObjectCounts;
use kugelblitz_judge::show::Entry;
use serde::{Serialize, Serializer};

use crate::complain::help_of;
use crate::output::{json, ms, print, print_text};
use crate::{CommandLine, Run, arguments};

/// The version of `docs/json.md`; a report has its own.
const SCHEMA: u32 = 1;

/// Head of every summary, followed by the fields of the command and by a failure.
#[derive(Serialize)]
struct Summary<'a, Fields> {
    /// Version of the fields: 3 for `report`, 1 for all other commands.
    schema: u32,
    /// Version of the program.
    version: &'static str,
    /// Name of the command; `null` if the command line has none.
    command: Option<&'a str>,
    #[serde(flatten)]
    fields: Option<&'a Fields>,
    #[serde(flatten)]
    failure: Option<Failure>,
}

/// The summary of `command` as JSON.
///
/// # Errors
/// As [`json`].
pub fn summary(
    command: Option<&str>,
    fields: Option<&impl Serialize>,
    failure: Option<&Error>,
) -> Result<Vec<u8>> {
    let schema = if command == Some("report") { kugelblitz_report::SCHEMA } else { SCHEMA };
    let (version, failure) = (env!("CARGO_PKG_VERSION"), failure.map(Failure::from));
    json(&Summary { schema, version, command, fields, failure })
}

/// True once a summary is on standard output, which has one at most.
static IS_PRINTED: AtomicBool = AtomicBool::new(false);

/// What is done, and is still to be told and put in its place.
pub struct Done<S> {
    /// What --json tells.
    pub summary: S,
    /// What people read on standard output in its place.
    pub words: String,
    /// Outputs, whole but not yet in their places.
    pub files: Vec<OutputFile>,
    /// Lines for standard error, once the outputs are in their places.
    pub said: Vec<String>,
    /// What the work has found to be wrong.
    pub failure: Option<Error>,
}

impl<S: Serialize> Done<S> {
    /// Work that `words` tell of on standard output.
    pub fn in_words(summary: S, words: String) -> Done<S> {
        Done { summary, words, files: Vec::new(), said: Vec::new(), failure: None }
    }

    /// Work that made this file, of which `line` tells, and those beside it.
    pub fn with_file(
        summary: S,
        beside: impl IntoIterator<Item = OutputFile>,
        file: OutputFile,
        line: &str,
    ) -> Done<S> {
        let said = vec![format!("{}: {line}", file.path().shown())];
        let files = beside.into_iter().chain([file]).collect();
        Done { files, said, ..Done::in_words(summary, String::new()) }
    }

    /// A comparison that `words` tell of, which made this file, if any, and found this to be wrong.
    pub fn compared(
        summary: S,
        words: String,
        file: Option<OutputFile>,
        broken: &[String],
    ) -> Done<S> {
        let failure = (!broken.is_empty()).then(|| Error::Comparison(broken.join("; ")));
        Done { files: Vec::from_iter(file), failure, ..Done::in_words(summary, words) }
    }

    /// Tells of the work of `command`, and puts its outputs in their places.
    ///
    /// # Errors
    /// As [`print`] and [`output::commit`]; what the work has found to be wrong.
    pub fn finish(self, command: &'static str, run: &Run) -> Result<()> {
        let Done { summary, words, files, said, failure } = self;
        if run.talk.json {
            IS_PRINTED.store(true, Ordering::Relaxed);
            print(&self::summary(Some(command), Some(&summary), failure.as_ref())?)?;
        } else if !words.is_empty() {
            print_text(&words)?;
        }
        output::commit(files, &run.control)?;
        said.iter().for_each(|line| run.say(line));
        failure.map_or(Ok(()), Err)
    }
}

/// A failure.
#[derive(Serialize)]
struct Failure {
    /// Place and problem, as on standard error. The wording may change.
    error: String,
    /// Exit code.
    code: u8,
    /// Next step; absent if there is none. The wording may change.
    #[serde(skip_serializing_if = "String::is_empty")]
    help: String,
    /// Place of an error in a scene or in data.
    #[serde(skip_serializing_if = "Option::is_none")]
    place: Option<ErrorPlace>,
    /// Place of an error in data, or key whose value is wrong. A field that does not apply to the error is `null`.
    #[serde(skip_serializing_if = "Option::is_none")]
    subject: Option<SubjectSummary>,
}

/// The data file, line, row, column and key of an error, and the value there.
#[derive(Serialize)]
struct SubjectSummary {
    /// Data file; `null` for the scene file.
    file: Option<String>,
    /// Line of a text file, from 1.
    line: Option<u64>,
    /// Row of a NumPy array, from 0.
    row: Option<u64>,
    /// Name of the column in the file.
    column: Option<String>,
    /// Key of the scene whose value is wrong or does not fit the data.
    key: Option<&'static str>,
    /// Value in the data.
    value: Option<String>,
}

/// The place of a scene error.
#[derive(Serialize)]
struct ErrorPlace {
    /// Scene file, or the data if there is no scene file.
    file: String,
    /// Line, from 1; 0 if the error is about the whole file, or if there is no scene file.
    line: usize,
    /// Column in characters, from 1; 0 if `line` is 0.
    column: usize,
}

impl From<&Error> for Failure {
    fn from(error: &Error) -> Failure {
        let scene = match error {
            Error::Scene(error) => Some(error),
            _ => None,
        };
        let place = scene.map(|error| ErrorPlace {
            file: error.path.display().to_string(),
            line: error.line,
            column: error.column,
        });
        let subject = scene.filter(|error| error.subject != ErrorSubject::default()).map(|error| {
            let ErrorSubject { file, line, row, column, key } = error.subject.clone();
            let file = file.map(|file| file.display().to_string());
            SubjectSummary { file, line, row, column, key, value: error.value.clone() }
        });
        Failure {
            error: error.to_string(),
            code: error.exit_code(),
            help: help_of(error),
            place,
            subject,
        }
    }
}

/// Prints a failure as JSON where the command line asks for JSON and standard output has none yet. Where
/// an output goes there (`-`), it is not said.
pub fn failed_in_json<C: CommandLine>(error: &Error) {
    let arguments = arguments();
    let has_json = arguments.iter().any(|argument| argument == "--json");
    // As the value of an option, but for `--rays`, it is an output, also after `new`; otherwise it is an input.
    let is_output = |pair: &[OsString]| {
        let before = pair[0].to_string_lossy();
        pair[1] == "-" && before != "--rays" && (before.starts_with('-') || before == "new")
    };
    if !has_json || arguments.windows(2).any(is_output) || IS_PRINTED.load(Ordering::Relaxed) {
        return;
    }
    let mut words = arguments.iter().filter_map(|word| word.to_str());
    let first = words.find(|word| !word.starts_with('-'));
    let command = C::COMMAND.or(first.filter(|word| C::command().find_subcommand(word).is_some()));
    // Who reads no failure has the exit code.
    let _ = summary(command, None::<&()>, Some(error)).and_then(|text| print(&text));
}

/// The adapter and the kind of device that traced.
#[derive(Serialize)]
pub struct On {
    /// Adapter of the device; `null` for the CPU.
    adapter: Option<Adapter>,
    /// `gpu` or `cpu`.
    device: &'static str,
}

/// Name, type and driver of a Vulkan adapter.
#[derive(Serialize)]
struct Adapter {
    /// Name of the adapter.
    name: String,
    /// `discrete`, `integrated`, `virtual`, `software` or `other`.
    #[serde(rename = "type")]
    kind: &'static str,
    /// Name and version of the driver.
    driver: String,
}

impl From<&Device> for On {
    fn from(device: &Device) -> On {
        let adapter = |facts: &AdapterFacts| Adapter {
            name: facts.name.clone(),
            kind: facts.kind,
            driver: facts.driver.clone(),
        };
        On { adapter: device.facts().map(adapter), device: device.kind() }
    }
}

/// Number of rays, in total and by the stage that decided them.
#[derive(Serialize)]
pub struct RayCounts {
    /// Number of rays.
    total: u64,
    #[serde(flatten)]
    stages: StageCounts,
}

impl From<StageCounts> for RayCounts {
    fn from(stages: StageCounts) -> RayCounts {
        RayCounts { total: stages.total(), stages }
    }
}

/// A time, as milliseconds in JSON.
#[derive(Clone, Copy)]
pub struct Millis(pub Duration);

impl Serialize for Millis {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.serialize_f64(ms(self.0))
    }
}

/// Times of tracing and of colours, milliseconds.
#[derive(Serialize)]
pub struct StageTimes {
    /// Tracing in f32, and everything that a device does.
    trace: Millis,
    /// Tracing in f64.
    refine: Millis,
    /// Exact arithmetic.
    decide: Millis,
    /// Transfer from the device into memory.
    readback: Millis,
    /// Colours; absent in `ms_runs` if the picture is neither lit nor sampled.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shade: Option<Millis>,
}

impl From<&RenderStats> for StageTimes {
    fn from(RenderStats { timing, shade, .. }: &RenderStats) -> StageTimes {
        StageTimes {
            trace: Millis(timing.trace),
            refine: Millis(timing.refine),
            decide: Millis(timing.decide),
            readback: Millis(timing.readback),
            shade: Some(Millis(*shade)),
        }
    }
}

/// Times of a picture or of a list of rays, milliseconds.
#[derive(Serialize)]
pub struct DrawTimes {
    /// Reading the input; absent for a frame of a film.
    #[serde(skip_serializing_if = "Option::is_none")]
    read: Option<Millis>,
    /// Computing the records of the kernel.
    prepare: Millis,
    /// Building the hierarchy over many spheres, or updating it for another camera.
    build: Millis,
    /// Transfer to the device.
    upload: Millis,
    /// Compiling the shader.
    compile: Millis,
    #[serde(flatten)]
    stages: StageTimes,
    /// Writing the file.
    write: Millis,
    /// Total time since the start of the program, with opening the device; of a frame of a film, since the start of the
    /// frame.
    total: Millis,
}

/// `read 1.2 ms, prepare 0.1 ms`
impl Display for DrawTimes {
    fn fmt(&self, to: &mut Formatter) -> fmt::Result {
        let DrawTimes { read, prepare, build, upload, compile, stages, write, total } = self;
        let StageTimes { trace, refine, decide, readback, shade } = stages;
        let times = [
            ("read", read.as_ref()),
            ("prepare", Some(prepare)),
            ("build", Some(build)),
            ("upload", Some(upload)),
            ("compile", Some(compile)),
            ("trace", Some(trace)),
            ("refine", Some(refine)),
            ("decide", Some(decide)),
            ("readback", Some(readback)),
            ("shade", shade.as_ref()),
            ("write", Some(write)),
            ("total", Some(total)),
        ];
        let present = times.into_iter().filter_map(|(name, time)| Some((name, time?)));
        let words = present.map(|(name, time)| format!("{name} {}", duration(time.0)));
        to.write_str(&joined(words, ", "))
    }
}

/// A traced picture or list of rays.
#[derive(Serialize)]
pub struct Drawn {
    /// Rays of the pixels, without shadow rays, or of the list.
    rays: RayCounts,
    /// Number of pixels that show an object, or of rays that hit one.
    hits: u64,
    /// [Shadow rays](#shadow-rays) of a lit picture.
    #[serde(skip_serializing_if = "Option::is_none")]
    shadow_rays: Option<RayCounts>,
    /// Number of lit pixels, by the device that computed the colour. Unstable in JSON.
    #[serde(skip_serializing_if = "Option::is_none")]
    colors: Option<ColorCounts>,
    /// Times, milliseconds.
    pub ms: DrawTimes,
}

impl Drawn {
    /// What was drawn, with the times that it took to make it ready, to read its input where that is its own, and in all:
    /// from the program's start, so with opening the device as well; of a film's frame, from its own.
    pub fn new(
        done: &RenderStats,
        making: SetupTimes,
        read: Option<Duration>,
        total: Duration,
        is_lit: bool,
    ) -> Drawn {
        Drawn {
            rays: RayCounts::from(done.counts),
            hits: done.hits,
            shadow_rays: is_lit.then(|| done.shadow_rays.into()),
            colors: is_lit.then_some(done.colors),
            ms: DrawTimes {
                read: read.map(Millis),
                prepare: Millis(making.prepare),
                build: Millis(making.build),
                upload: Millis(making.upload),
                compile: Millis(making.compile),
                stages: StageTimes::from(done),
                write: Millis(done.write),
                total: Millis(total),
            },
        }
    }
}

/// What a session traces.
#[derive(Serialize)]
pub struct WorkSummary {
    #[serde(flatten)]
    on: On,
    /// Name of the kernel.
    kernel: &'static str,
    /// Width and height, pixels; absent for a list of rays.
    #[serde(skip_serializing_if = "Option::is_none")]
    size: Option<[u32; 2]>,
    /// Objects of the scene.
    objects: ObjectCounts,
    /// Number of samples across a pixel, and down it; absent for one sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<u32>,
}

impl WorkSummary {
    /// The work of `session`: a picture of this size with so many samples, or a list of rays.
    pub fn new(session: &Session, picture: Option<([u32; 2], Samples)>) -> WorkSummary {
        let (size, samples) = picture.unzip();
        WorkSummary {
            on: On::from(session.device()),
            kernel: session.kernel().name(),
            size,
            objects: ObjectCounts::of(session.scene()),
            samples: samples.filter(|n| *n > Samples::ONE).map(Samples::across),
        }
    }
}

/// A picture of `render`, or the hits of `trace`.
#[derive(Serialize)]
pub struct Traced {
    #[serde(flatten)]
    pub work: WorkSummary,
    #[serde(flatten)]
    pub drawn: Drawn,
    /// With `--show`: the quantity that the colours show.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub show: Option<&'static str>,
    /// With `--show`: the meaning of the colours.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub legend: Option<Vec<Entry>>,
    /// Memory on the device, bytes.
    pub bytes_device: u64,
    /// With `--repeat`: times of each run after the first, milliseconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ms_runs: Option<Vec<StageTimes>>,
}

/// `3 spheres, 1 plane, certified on the CPU, in 24 ms`, all that the user waited for.
pub fn traced_in_words(session: &Session, run: &Run) -> String {
    format!(
        "{}, {} on {}, in {}",
        ObjectCounts::of(session.scene()),
        session.kernel().name(),
        session.device().label(),
        duration(run.start.elapsed())
    )
}
