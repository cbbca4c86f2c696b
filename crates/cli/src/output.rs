//! Data to standard output, talk to standard error.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use kugelblitz::output::{self, OutputFile};
use kugelblitz::plain::{Shown, plain, plain_json, steers};
use kugelblitz::scene::Scene;
use kugelblitz::{Error, Result};
use serde::Serialize;

use crate::{Run, wrong_usage};

/// Standard output as errors call it.
pub const STDOUT: &str = OutputFile::STDOUT_IN_WORDS;

/// `-` on the command line.
pub fn is_stdout(output: &Path) -> bool {
    output == Path::new(OutputFile::STDOUT)
}

/// Refuses a file whose name does not end as what is written does; `what` is e.g. `a figure is`.
///
/// # Errors
/// [`Error::Usage`]
pub fn check_ending(output: &Path, ending: &str, what: &str) -> Result<()> {
    if output.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending)) {
        return Ok(());
    }
    let name = output.shown();
    wrong_usage(format!("{name}: {what} written as .{ending}; name the file so"))
}

/// Refuses outputs that would replace what they are made from, the clouds of a scene as well, or each other.
///
/// # Errors
/// [`Error::Usage`]
pub fn refuse_overwriting<'p>(
    outputs: impl IntoIterator<Item: AsRef<Path>>,
    inputs: impl IntoIterator<Item = &'p PathBuf>,
    scene: &'p Scene,
) -> Result<()> {
    let clouds = scene.clouds.iter().map(|cloud| &cloud.path);
    output::refuse_overwriting(outputs, inputs.into_iter().chain(clouds))
}

/// A file with these bytes, which is whole but not in its place.
///
/// # Errors
/// Those of [`OutputFile::create`] and [`OutputFile::filled`].
pub fn written(path: &Path, bytes: &[u8]) -> Result<OutputFile> {
    OutputFile::create(path, false)?.filled(bytes)
}

/// A path as a shell takes it.
pub fn shell_quoted(path: &Path) -> String {
    let path = path.to_string_lossy();
    let start = if path.starts_with('-') { "./" } else { "" };
    text_quoted(&format!("{start}{path}"))
}

/// A text as a shell takes it.
pub fn text_quoted(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "%+,-./:=@_".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        return text.into();
    }
    let is_odd = |c: char| steers(c) || matches!(c, '\n' | '\t');
    if !text.contains(is_odd) {
        return format!("'{}'", text.replace('\'', "'\\''"));
    }
    let quoted = |c: char| match c {
        '\\' | '\'' => format!("\\{c}"),
        _ if is_odd(c) => c.to_string().bytes().map(|byte| format!("\\x{byte:02x}")).collect(),
        _ => c.into(),
    };
    let quoted: String = text.chars().map(quoted).collect();
    format!("$'{quoted}'")
}

/// Prints data.
///
/// # Errors
/// [`Error::Io`], for one when nobody reads any more.
pub fn print(data: &[u8]) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    stdout.write_all(data).and_then(|()| stdout.flush()).map_err(Error::io(STDOUT))
}

/// Prints text for people, with nothing in it that steers a terminal.
///
/// # Errors
/// As [`print`].
pub fn print_text(text: &str) -> Result<()> {
    print(plain(text).as_bytes())
}

/// Prints lines for people to standard error, with nothing in them that steers a terminal. Where
/// nobody reads them, all goes on without.
pub fn talk(lines: &str) {
    talk_in_colour(&plain(lines));
}

/// Prints lines as [`talk`] does, with colours of the program's own; foreign parts in them are [`plain`].
pub fn talk_in_colour(lines: &str) {
    // At once: other threads and the driver write there too.
    let _ = std::io::stderr().write_all(format!("{lines}\n").as_bytes());
}

/// One JSON object, for people to read as well.
///
/// # Errors
/// [`Error::Io`], for a map whose keys are no text.
pub fn json(object: &impl Serialize) -> Result<Vec<u8>> {
    json_line(serde_json::to_string_pretty(object))
}

fn json_line(text: serde_json::Result<String>) -> Result<Vec<u8>> {
    let text = text.map_err(std::io::Error::from).map_err(Error::io(STDOUT))?;
    Ok((plain_json(&text).into_owned() + "\n").into_bytes())
}

/// Prints one JSON object on a line of its own.
///
/// # Errors
/// As [`print`].
pub fn printed_line(object: &impl Serialize) -> Result<()> {
    print(&json_line(serde_json::to_string(object))?)
}

impl Run {
    /// Says a line that every run is worth.
    pub fn say(&self, line: &str) {
        if !self.talk.quiet {
            talk(line);
        }
    }

    /// Says a line that only --verbose asks for.
    pub fn note(&self, line: &str) {
        if self.talk.verbose {
            talk(&format!("note: {line}"));
        }
    }

    /// Says a line that the user must know even with --quiet.
    pub fn warn(&self, line: &str) {
        talk(&format!("warning: {line}"));
    }

    /// Refuses two of these outputs on standard output, or one beside --json. Each has a name, `the picture` for one.
    ///
    /// # Errors
    /// [`Error::Usage`]
    pub fn refuse_sharing_stdout<'o>(
        &self,
        outputs: impl IntoIterator<Item = (&'o PathBuf, &'o str)>,
    ) -> Result<()> {
        let there = outputs.into_iter().filter(|(output, _)| is_stdout(output));
        let mut there = there.map(|(_, what)| what).chain(self.talk.json.then_some("--json"));
        match (there.next(), there.next()) {
            (Some(one), Some(other)) => wrong_usage(format!(
                "{one} and {other} can't both go to standard output; write to a file"
            )),
            _ => Ok(()),
        }
    }
}

/// Milliseconds for reports, to the microsecond.
pub fn ms(duration: Duration) -> f64 {
    duration.as_micros() as f64 / 1e3
}
