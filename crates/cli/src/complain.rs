//! Prints errors on standard error, and words their next steps as options.

use std::io::ErrorKind;
use std::path::Path;

use crate::head::failed_in_json;
use crate::output::{STDOUT, talk, talk_in_colour, text_quoted};
use crate::{CommandLine, command_line};
use anstream::{AutoStream, ColorChoice};
use kugelblitz::Error;
use kugelblitz::error::{SceneError, Setting, SettingValue};
use kugelblitz::plain::{Shown, plain};
use kugelblitz::words::joined;
use unicode_width::{UnicodeWidthChar, UnicodeWidthStr};

/// Prints an error: its place in the scene file, the problem and the next step. `writes`: whether the command has output
/// files.
pub fn complain(error: &Error, writes: bool) {
    match error {
        Error::Scene(error) => complain_about_scene(error),
        Error::Interrupted if writes => talk("error: interrupted; no output file was changed"),
        // Nobody reads any more (`… | head`), so nobody misses anything.
        Error::Io { path, source }
            if path.as_os_str() == STDOUT && source.kind() == ErrorKind::BrokenPipe => {}
        _ => {
            let help = help_of(error);
            let help = if help.is_empty() { String::new() } else { format!("\n = help: {help}") };
            talk(&format!("error: {error}{help}"));
        }
    }
}

/// Returns the next step of an error: with keys for a scene file, with options otherwise.
pub fn help_of(error: &Error) -> String {
    match error {
        Error::Scene(scene) if !scene.is_about_bare_data() => error.hint().to_string(),
        _ => error.hint().worded(option),
    }
}

/// Returns a setting as an option: `--columns radius=false`, `--rows-from-below`.
pub fn option(Setting { key, value }: &Setting) -> String {
    let name = format!("--{}", key.replace('_', "-"));
    match value {
        None | Some(SettingValue::Present) => name,
        Some(value) => format!("{name} {}", word(value)),
    }
}

/// Returns the value of an option, in quotes if a shell would split or change it.
fn word(value: &SettingValue) -> String {
    let plain = match value {
        SettingValue::Text(text) => text.clone(),
        SettingValue::Number(number) => number.clone(),
        SettingValue::Present => "true".into(),
        SettingValue::Absent => "false".into(),
        SettingValue::Table(entries) => {
            let entry = |(name, value): &(&str, SettingValue)| match value {
                SettingValue::Text(text) => format!("{name}={text}"),
                value => format!("{name}={value}"),
            };
            joined(entries.iter().map(entry), ",")
        }
    };
    text_quoted(&plain)
}

/// Prints what clap found in the command line: that it is wrong, or that it asks for help or the
/// version. Returns the exit code.
pub fn complain_about_usage<C: CommandLine>(error: clap::Error) -> u8 {
    // It quotes arguments, which are read once more as they are shown.
    let shown = command_line().iter().map(|argument| Path::new(argument).shown());
    let error = C::try_parse_from(shown).err().unwrap_or(error);
    match error.print() {
        Err(failure) if !error.use_stderr() => {
            let failure = Error::io(STDOUT)(failure);
            complain(&failure, false);
            failure.exit_code()
        }
        _ if error.use_stderr() => {
            let rendered = error.render().to_string();
            let (message, _) = rendered.split_once("\n\n").unwrap_or((&rendered, ""));
            let usage = Error::Usage(message.trim().trim_start_matches("error: ").into());
            failed_in_json::<C>(&usage);
            usage.exit_code()
        }
        _ => error.exit_code() as u8,
    }
}

/// The colours of `error`, of what stands out, and of the frame; and what ends them.
const COLORS: [&str; 4] = ["\x1b[1;91m", "\x1b[1m", "\x1b[34m", "\x1b[0m"];

/// Prints a scene error with its lines of the file. Nothing in it steers a terminal but colours of its own.
fn complain_about_scene(error: &SceneError) {
    let is_plain = AutoStream::choice(&std::io::stderr()) == ColorChoice::Never;
    let [red, bold, blue, end] = if is_plain { [""; 4] } else { COLORS };
    let mut drawn = format!("{red}error{end}{bold}: {}{end}\n", plain(&error.to_string()));
    let lines = if error.line > 0 { lines_around(error) } else { Vec::new() };
    let width = lines.last().map_or(0, |(number, _)| number.to_string().len());
    let margin = " ".repeat(width);
    if !lines.is_empty() {
        let (path, column) = (error.path.shown(), error.column);
        drawn += &format!("{margin} {blue}┌─{end} {path}:{}:{column}\n", error.line);
        drawn += &format!("{margin} {blue}│{end}\n");
    }
    for (number, [before, place, behind]) in lines {
        drawn += &format!("{blue}{number:>width$} │{end} {before}{red}{place}{end}{behind}\n");
        if number == error.line {
            // The end of a line is a place, but has nothing to put a mark under.
            let marks = "^".repeat(place.width().max(1));
            let blank = |c: char| match c {
                '\t' => "\t".to_owned(),
                _ => " ".repeat(c.width().unwrap_or(0)),
            };
            let blank: String = before.chars().map(blank).collect();
            drawn += &format!("{margin} {blue}│{end} {blank}{red}{marks}{end}\n");
        }
    }
    if error.line > 0 {
        drawn += &format!("{margin} {blue}│{end}\n");
    }
    let help = match error.is_about_bare_data() {
        true => error.hint.worded(option),
        false => error.hint.to_string(),
    };
    let help = plain(&help).replace('\n', &format!("\n{margin}   "));
    talk_in_colour(&(drawn + &format!("{margin} {blue}={end} help: {help}")));
}

/// A line in parts: what is before a place in it, the place, and the rest.
type SourceLine = [String; 3];

/// The line of an error's place with its number, and the lines before and behind it, in which no place is. Of a place
/// of several lines, the first one counts.
fn lines_around(SceneError { text, span, line, .. }: &SceneError) -> Vec<(usize, SourceLine)> {
    let line_start = text[..span.start].rfind('\n').map_or(0, |newline| newline + 1);
    let before = &text[line_start..span.start];
    let shown = |(number, whole): (usize, &str)| {
        if number != *line {
            return (number, excerpt("", whole, 0));
        }
        let behind = whole.get(before.len()..).unwrap_or_default();
        // As lines end in files from Windows.
        let behind = behind.strip_suffix('\r').unwrap_or(behind);
        (number, excerpt(before, behind, span.len()))
    };
    // The place may be behind the last line feed.
    let lines = (1..).zip(text.lines().chain([""])).skip(line.saturating_sub(2));
    let lines = lines.take_while(|(number, _)| *number <= line + 1);
    lines.filter(|(number, whole)| number <= line || !whole.is_empty()).map(shown).collect()
}

/// Columns of a line that are shown.
const COLUMNS: usize = 200;

/// Columns of them from the place on, where the line is cut at both ends.
const COLUMNS_BEHIND: usize = 120;

/// Stands for the rest of a line.
const CUT: &str = "…";

/// A line of some [`COLUMNS`] at most, with nothing in it that steers a terminal: what is before a place in it, and what
/// begins with the place, of so many bytes.
fn excerpt(before: &str, behind: &str, n_bytes: usize) -> SourceLine {
    let n_before = before.chars().rev().take(COLUMNS).count();
    let n_behind = behind.chars().take(COLUMNS).count();
    let n_behind = n_behind.min(COLUMNS_BEHIND.max(COLUMNS - n_before));
    let n_before = n_before.min(COLUMNS - n_behind);

    let start = before.char_indices().rev().take(n_before).last();
    let start = start.map_or(before.len(), |(byte, _)| byte);
    let end = behind.char_indices().nth(n_behind).map_or(behind.len(), |(byte, _)| byte);
    let (place, rest) = behind[..end].split_at(n_bytes.min(end));
    let [before_cut, behind_cut] =
        [start > 0, end < behind.len()].map(|is_cut| if is_cut { CUT } else { "" });
    [
        format!("{before_cut}{}", plain(&before[start..])),
        plain(place).into_owned(),
        format!("{}{behind_cut}", plain(rest)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use kugelblitz::error::{ErrorSubject, Hint};

    /// `text` has the place between `‹` and `›`, and so have the lines that are expected.
    fn check(text: &str, expected: &str) {
        let start = text.find('‹').unwrap();
        let end = text.find('›').unwrap() - '‹'.len_utf8();
        let error = SceneError {
            path: "a.toml".into(),
            text: text.replace(['‹', '›'], ""),
            span: start..end,
            line: 1 + text[..start].matches('\n').count(),
            column: 1,
            subject: ErrorSubject::default(),
            value: None,
            message: String::new(),
            hint: Hint::NONE,
        };
        let shown =
            |(number, [before, place, behind]): (usize, SourceLine)| match number == error.line {
                true => format!("{before}‹{place}›{behind}"),
                false => [before, place, behind].concat(),
            };
        let lines: Vec<String> = lines_around(&error).into_iter().map(shown).collect();
        assert_eq!(lines.join("\n"), expected);
    }

    #[test]
    fn short_lines_stay_whole() {
        check("‹a›b", "‹a›b");
        check("1\n2\n3 ‹x› y\n4\n5\n", "2\n3 ‹x› y\n4");
        check("1\r\n‹é›\r\n3\r\n", "1\n‹é›\n3");
        check("‹›", "‹›");
        check("a\n‹›", "a\n‹›");
        check("a‹›\r\nb", "a‹›\nb");
        check("a‹\r\n›b", "a‹›\nb");
        check("‹[1,\n2,\n3]›\n4", "‹[1,›\n2,");
        let line = "0123456789".repeat(20);
        let marked = format!("{}‹{}›{}", &line[..150], &line[150..160], &line[160..]);
        check(&marked, &marked);
    }

    #[test]
    fn long_lines_are_cut_around_the_place() {
        let x = |n: usize| "x".repeat(n);
        check(&format!("‹{}›", x(201)), &format!("‹{}›…", x(200)));
        check(&format!("{}‹y›{}", x(500), x(500)), &format!("…{}‹y›{}…", x(80), x(119)));
        check(&format!("{}‹y›", x(500)), &format!("…{}‹y›", x(199)));
        check(&format!("{}‹y›{}", x(20), x(500)), &format!("{}‹y›{}…", x(20), x(179)));
        check(
            &format!("{}‹{}›", x(500), "é".repeat(500)),
            &format!("…{}‹{}›…", x(80), "é".repeat(120)),
        );
        check(&format!("{}\n‹y›\n{}", x(500), x(500)), &format!("{}…\n‹y›\n{}…", x(200), x(200)));
    }

    #[test]
    fn what_steers_moves_the_place_along() {
        check("\u{9b}‹\u{202e}›\r \x1b", "\\u{9b}‹\\u{202e}›\\r \\u{1b}");
    }
}
