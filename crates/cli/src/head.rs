//! The JSON summaries: the head of each, and the parts that several have.

use std::ffi::OsString;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use kugelblitz::device::Device;
use kugelblitz::error::ErrorSubject;
use kugelblitz::gpu::AdapterFacts;
use kugelblitz::output::{self, OutputFile};
use kugelblitz::plain::Shown;
use kugelblitz::scene::Samples;
use kugelblitz::shade::ColorCounts;
use kugelblitz::shade::Rendered;
use kugelblitz::trace::StageCounts;
use kugelblitz::words::{duration, joined};
use kugelblitz::{Error, Making, Result, Session};
use kugelblitz_judge::cost::ObjectCounts;
use kugelblitz_judge::show::Entry;
use serde::{Serialize, Serializer};

use crate::complain::help_of;
use crate::output::{json, ms, print, print_text};
use crate::{CommandLine, Run, arguments};

/// The version of `docs/json.md`; a report has its own.
const SCHEMA: u32 = 1;

/// Every summary: its head, then the fields of the command, then what went wrong.
#[derive(Serialize)]
struct Summary<'a, Fields> {
    schema: u32,
    version: &'static str,
    /// `None` where the command line names none.
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

/// What went wrong.
#[derive(Serialize)]
struct Failure {
    error: String,
    /// The exit code.
    code: u8,
    /// The next step.
    #[serde(skip_serializing_if = "String::is_empty")]
    help: String,
    /// The place of a scene error.
    #[serde(skip_serializing_if = "Option::is_none")]
    place: Option<Place>,
    /// Data file, line, column and key of an error.
    #[serde(skip_serializing_if = "Option::is_none")]
    subject: Option<SubjectSummary>,
}

/// The data file, line, row, column and key that an error is about, and the value there.
#[derive(Serialize)]
struct SubjectSummary {
    file: Option<String>,
    line: Option<u64>,
    row: Option<u64>,
    column: Option<String>,
    key: Option<&'static str>,
    value: Option<String>,
}

/// The place of a scene error.
#[derive(Serialize)]
struct Place {
    file: String,
    /// From 1; 0 where the error is about the file as a whole.
    line: usize,
    column: usize,
}

impl From<&Error> for Failure {
    fn from(error: &Error) -> Failure {
        let scene = match error {
            Error::Scene(error) => Some(error),
            _ => None,
        };
        let place = scene.map(|error| Place {
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
    adapter: Option<Adapter>,
    device: &'static str,
}

#[derive(Serialize)]
struct Adapter {
    name: String,
    #[serde(rename = "type")]
    kind: &'static str,
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

/// Rays, and how many each stage decided.
#[derive(Serialize)]
pub struct RayCounts {
    total: u64,
    #[serde(flatten)]
    stages: StageCounts,
}

impl From<StageCounts> for RayCounts {
    fn from(stages: StageCounts) -> RayCounts {
        RayCounts { total: stages.total(), stages }
    }
}

/// Times by the names of what took them, as milliseconds.
pub struct Times(pub Vec<(&'static str, Duration)>);

impl Serialize for Times {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|&(name, time)| (name, ms(time))))
    }
}

impl Times {
    /// `read 1.2 ms, prepare 0.1 ms`
    pub fn in_words(&self) -> String {
        let times = self.0.iter().map(|&(name, time)| format!("{name} {}", duration(time)));
        joined(times, ", ")
    }
}

/// The stages of tracing and colours.
pub fn stages(Rendered { timing, shade, .. }: &Rendered) -> [(&'static str, Duration); 5] {
    [
        ("trace", timing.trace),
        ("refine", timing.refine),
        ("decide", timing.decide),
        ("readback", timing.readback),
        ("shade", *shade),
    ]
}

/// A traced picture or list of rays.
#[derive(Serialize)]
pub struct Drawn {
    rays: RayCounts,
    hits: u64,
    /// Shadow rays cast, of lit pictures only.
    #[serde(skip_serializing_if = "Option::is_none")]
    shadow_rays: Option<RayCounts>,
    /// Pixels by where their colours are from, of lit pictures only.
    #[serde(skip_serializing_if = "Option::is_none")]
    colors: Option<ColorCounts>,
    pub ms: Times,
}

impl Drawn {
    /// What was drawn, with the times that it took to make it ready, to read its input where that is its own, and in all:
    /// from the program's start, so with opening the device as well; of a film's frame, from its own.
    pub fn new(
        done: &Rendered,
        making: Making,
        read: Option<Duration>,
        total: Duration,
        is_lit: bool,
    ) -> Drawn {
        let before = [
            ("prepare", making.prepare),
            // The hierarchy over many spheres, or fitting it to another view.
            ("build", making.build),
            ("upload", making.upload),
            ("compile", making.compile),
        ];
        let read = read.map(|read| ("read", read));
        let times = read.into_iter().chain(before).chain(stages(done));
        Drawn {
            rays: RayCounts::from(done.counts),
            hits: done.hits,
            shadow_rays: is_lit.then(|| done.shadow_rays.into()),
            colors: is_lit.then_some(done.colors),
            ms: Times(times.chain([("write", done.write), ("total", total)]).collect()),
        }
    }
}

/// What a session traces.
#[derive(Serialize)]
pub struct Work {
    #[serde(flatten)]
    on: On,
    kernel: &'static str,
    /// Width and height; absent for lists of rays.
    #[serde(skip_serializing_if = "Option::is_none")]
    size: Option<[u32; 2]>,
    objects: ObjectCounts,
    /// Samples across and down a pixel, where there are several.
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<u32>,
}

impl Work {
    /// The work of `session`: a picture of this size with so many samples, or a list of rays.
    pub fn new(session: &Session, picture: Option<([u32; 2], Samples)>) -> Work {
        let (size, samples) = picture.unzip();
        Work {
            on: On::from(session.device()),
            kernel: session.kernel().name(),
            size,
            objects: ObjectCounts::of(session.scene()),
            samples: samples.filter(|n| *n > Samples::ONE).map(Samples::across),
        }
    }
}

/// The summary of `render` and `trace`.
#[derive(Serialize)]
pub struct Traced {
    #[serde(flatten)]
    pub work: Work,
    #[serde(flatten)]
    pub drawn: Drawn,
    /// What the colours show, where they are not the objects' own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub show: Option<&'static str>,
    /// What the colours mean.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub legend: Option<Vec<Entry>>,
    pub bytes_device: u64,
    /// Times of the `--repeat` runs, in order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ms_runs: Option<Vec<Times>>,
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
