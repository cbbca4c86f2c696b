//! An [`Explanation`] as plain text of at most [`WIDTH`] columns.

use std::fmt::Write;

use super::line::text_of;
use super::numbers::{COLUMNS, decimal_f32, decimal_f64};
use super::section::TextSection;
use super::words::{Remark, Words};
use super::{
    Approximation, Explanation, FormulaNumber, KernelResult, LeftOut, MOST_OBJECTS, numbers,
    shortened,
};

/// Columns that the text takes at most.
pub const WIDTH: usize = 100;

/// The whole explanation.
pub fn text(explanation: &Explanation) -> String {
    let words = explanation.lang.words();
    let mut text = String::new();
    section(&explanation.of_ray(), "", words, &mut text);
    let first_sphere = explanation.objects.iter().position(|object| object.shape == "sphere");
    for (i, object) in explanation.objects.iter().enumerate() {
        text.push('\n');
        let note = if first_sphere == Some(i) { words.stable_notes } else { "" };
        section(&object.section(), note, words, &mut text);
    }
    let LeftOut { hit, behind, missed } = explanation.left_out;
    let n_left_out = hit + behind + missed;
    if n_left_out > 0 {
        let left_out = [n_left_out, explanation.n_objects, hit, behind, missed];
        let _ = writeln!(text, "\n{}", Remark::of(words.left_out, left_out));
        if explanation.objects.len() < MOST_OBJECTS {
            let _ = writeln!(text, "{}", Remark::of(words.all_shows, [MOST_OBJECTS]));
        }
    }
    text.push('\n');
    section(&explanation.of_point(numbers::DIGITS), "", words, &mut text);
    seen(explanation, words, &mut text);
    for of_light in explanation.of_light() {
        text.push('\n');
        section(&of_light, "", words, &mut text);
    }
    let _ = write!(text, "\n{}", Remark::of(words.notes, [explanation.digits]));
    if explanation.shading.is_some() {
        text += words.light_notes;
    }
    text
}

/// What the ray sees, in one or two lines.
pub fn verdict(explanation: &Explanation) -> String {
    let TextSection { subject, why, .. } = explanation.of_point(numbers::DIGITS);
    let bare = TextSection { subject, why, lines: &[], quantities: &[] };
    let mut text = String::new();
    section(&bare, "", explanation.lang.words(), &mut text);
    text
}

/// A section, with a note before its numbers.
fn section(section: &TextSection, note: &str, words: &Words, text: &mut String) {
    let subject: Vec<String> = section.subject.iter().map(Remark::to_string).collect();
    let _ = writeln!(text, "{}", subject.join(", "));
    for why in &section.why {
        let _ = writeln!(text, "  → {why}");
    }
    for line in text_of(section.lines, WIDTH) {
        let _ = writeln!(text, "{line}");
    }
    *text += note;
    if !section.quantities.is_empty() {
        table(section.quantities, words, text);
    }
}

/// A row of the table, right-aligned; columns that are blank at the end leave no blanks behind.
fn line(symbol: &str, cells: [String; 4], text: &mut String) {
    let [lecture, stable, double, exact] = cells;
    let row = format!("  {symbol:<7} {lecture:>16} {stable:>16} {double:>25} {exact:>28}");
    let _ = writeln!(text, "{}", row.trim_end());
}

fn table(quantities: &[FormulaNumber], words: &Words, text: &mut String) {
    let [lecture, stable, double] = COLUMNS;
    line("", [lecture, stable, double, words.exact_column].map(str::to_owned), text);
    for row in quantities {
        let columns = row.columns();
        let value = |entry: Option<Approximation>, decimal: fn(f64) -> String| match entry {
            None => String::new(),
            Some(Approximation { value, .. }) => value.map_or(words.none.into(), decimal),
        };
        let [lecture, stable] = [columns[0], columns[1]].map(|entry| value(entry, decimal_f32));
        let double = value(columns[2], decimal_f64);
        let exact = row.exact.as_ref().map_or(words.none.into(), |exact| exact.decimal.clone());
        line(words.symbol(row.symbol), [lecture, stable, double, exact], text);
        let error = |entry: Approximation| error(&entry, row.exact.is_some(), words);
        let errors = columns.map(|entry| entry.map_or(String::new(), error));
        if errors.iter().any(|error| !error.is_empty() && error != words.exact) {
            let [lecture, stable, double] = errors;
            line("", [lecture, stable, double, String::new()], text);
        }
    }
}

/// `0.31 ulp`, `sign! 3.1e6 ulp` where the sign is wrong.
fn error(entry: &Approximation, has_exact: bool, words: &Words) -> String {
    match entry.error_ulp {
        None if entry.value.is_some() => words.no_root.into(),
        None if has_exact => words.root_lost.into(),
        None => String::new(),
        Some(0.0) => words.exact.into(),
        Some(error) if error.is_infinite() && entry.value.is_some_and(f64::is_finite) => {
            words.should_be_0.into()
        }
        Some(error) if error.is_infinite() => words.overflow.into(),
        Some(error) => {
            let ulp = format!("{} ulp", rough(error));
            if entry.wrong_sign { format!("{} {ulp}", words.sign) } else { ulp }
        }
    }
}

/// Two or three digits: what an error is worth.
fn rough(x: f64) -> String {
    match x {
        0.0 => "0".into(),
        ..0.005 => "<0.01".into(),
        0.005..9.995 => format!("{x:.2}"),
        9.995..99999.5 => format!("{x:.0}"),
        _ => format!("{x:.1e}"),
    }
}

/// What each kernel shows.
fn seen(explanation: &Explanation, words: &Words, text: &mut String) {
    let stage = match explanation.level {
        "exact" => words.exact_arithmetic,
        other => other,
    };
    let _ = writeln!(text, "\n{}\n", Remark::of(words.decided, [stage]));
    let [kernel, on, shows, error, normal] = words.shown;
    let head = format!("  {kernel:<9} {on:<3} {shows:<25} {:>15} {error:>11}  {normal}", "t");
    let _ = writeln!(text, "{head}");
    for seen in &explanation.seen {
        of_seen(seen, words, text);
    }
    if explanation.seen.iter().all(|seen| seen.device != "gpu") {
        let _ = writeln!(text, "  {}", words.no_gpu);
    }
}

fn of_seen(seen: &KernelResult, words: &Words, text: &mut String) {
    let label = shortened(&seen.label, 25);
    let (t, normal) = match seen.id {
        0 => (String::new(), String::new()),
        _ => (
            decimal_f32(f64::from(seen.t)),
            seen.normal.map(|component| format!("{component:.4}")).join(" "),
        ),
    };
    let error = match (seen.right, seen.t_error_ulp) {
        (false, _) => words.wrong.into(),
        (true, Some(error)) if error.is_infinite() => "∞".into(),
        (true, Some(error)) => format!("{} ulp", rough(error)),
        (true, None) => String::new(),
    };
    let device = seen.device.to_uppercase();
    let row = format!("  {:<9} {device:<3} {label:<25} {t:>15} {error:>11}  {normal}", seen.kernel);
    let _ = writeln!(text, "{}", row.trim_end());
}
