//! An [`Explanation`] as plain text of at most [`WIDTH`] columns.

use super::derivation::Derivation;
use super::line::text_of;
use super::numbers::{COLUMNS, decimal_f32, decimal_f64};
use super::section::TextSection;
use super::words::{ExplanationWords, Remark};
use super::{
    Approximation, Explanation, FormulaNumber, KernelResult, LeftOut, MOST_OBJECTS, numbers,
    shortened,
};
use crate::markup::wrapped;

/// Columns that the text takes at most.
pub const WIDTH: usize = 100;

/// The whole explanation.
pub fn text(explanation: &Explanation) -> String {
    let words = explanation.lang.words();
    let mut text = section(&explanation.of_ray(), "", words);
    let first_sphere = explanation.objects.iter().position(|object| object.shape == "sphere");
    for (i, object) in explanation.objects.iter().enumerate() {
        let note = if first_sphere == Some(i) { words.stable_notes } else { "" };
        text += &format!("\n{}", section(&object.section(), note, words));
    }
    let LeftOut { hit, behind, missed } = explanation.left_out;
    let n_left_out = hit + behind + missed;
    if n_left_out > 0 {
        let left_out = [n_left_out, explanation.n_objects, hit, behind, missed];
        text += &format!("\n{}\n", Remark::of(words.left_out, left_out));
        if explanation.objects.len() < MOST_OBJECTS {
            text += &format!("{}\n", Remark::of(words.all_shows, [MOST_OBJECTS]));
        }
    }
    text += &format!("\n{}", section(&explanation.of_point(numbers::DIGITS), "", words));
    text += &seen(explanation, words);
    for of_light in explanation.of_light() {
        text += &format!("\n{}", section(&of_light, "", words));
    }
    let notes = Remark::of(words.notes, [explanation.digits]);
    let of_light = if explanation.shading.is_some() { words.light_notes } else { "" };
    text + &format!("\n{notes}{of_light}")
}

/// What the ray sees, in one or two lines.
pub fn verdict(explanation: &Explanation) -> String {
    let bare = TextSection { derivation: None, ..explanation.of_point(numbers::DIGITS) };
    section(&bare, "", explanation.lang.words())
}

/// A section, with a note before its numbers.
fn section(section: &TextSection, note: &str, words: &ExplanationWords) -> String {
    let subject: Vec<String> = section.subject.iter().map(Remark::to_string).collect();
    let mut text = subject.join(", ") + "\n";
    text.extend(section.why.iter().map(|why| format!("  → {why}\n")));
    let Some(Derivation { lines, quantities, .. }) = section.derivation else { return text };
    let notes = section.notes.iter();
    let notes = notes.flat_map(|note| wrapped(&note.to_string(), WIDTH, "  ", "  "));
    text.extend(text_of(lines).into_iter().chain(notes).map(|line| line + "\n"));
    text += note;
    if !quantities.is_empty() {
        text += &table(quantities, words);
    }
    text
}

/// A row of the table, right-aligned; columns that are blank at the end leave no blanks behind.
fn line(symbol: &str, [lecture, stable, double]: [String; 3], exact: &str) -> String {
    let row = format!("  {symbol:<7} {lecture:>16} {stable:>16} {double:>25} {exact:>28}");
    format!("{}\n", row.trim_end())
}

fn table(quantities: &[FormulaNumber], words: &ExplanationWords) -> String {
    let mut text = line("", COLUMNS.map(str::to_owned), words.exact);
    for row in quantities {
        let columns = row.columns();
        let value = |column: usize| match columns[column].map(|entry| entry.value) {
            None => String::new(),
            Some(None) => words.none.into(),
            Some(Some(x)) if column < 2 => decimal_f32(x),
            Some(Some(x)) => decimal_f64(x),
        };
        let exact = row.exact.as_ref().map_or(words.none, |exact| &exact.decimal);
        text += &line(words.symbol(row.symbol), [0, 1, 2].map(value), exact);
        let error = |entry: Approximation| error(&entry, row.exact.is_some(), words);
        let errors = columns.map(|entry| entry.map_or(String::new(), error));
        if errors.iter().any(|error| !error.is_empty() && error != words.exact) {
            text += &line("", errors, "");
        }
    }
    text
}

/// `0.31 ulp`, `sign! 3.1e6 ulp` where the sign is wrong.
fn error(entry: &Approximation, has_exact: bool, words: &ExplanationWords) -> String {
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
fn seen(explanation: &Explanation, words: &ExplanationWords) -> String {
    let stage = match explanation.level {
        "exact" => words.exact_arithmetic,
        other => other,
    };
    let [kernel, on, shows, error, normal] = words.shown;
    let mut text = format!(
        "\n{}\n\n  {kernel:<9} {on:<3} {shows:<25} {:>15} {error:>11}  {normal}\n",
        Remark::of(words.decided, [stage]),
        "t"
    );
    text.extend(explanation.seen.iter().map(|seen| of_seen(seen, words)));
    if explanation.seen.iter().all(|seen| seen.device != "gpu") {
        text += &format!("  {}\n", words.no_gpu);
    }
    text
}

fn of_seen(seen: &KernelResult, words: &ExplanationWords) -> String {
    let label = shortened(&seen.label, 25);
    let normal = || seen.normal.map(|component| format!("{component:.4}")).join(" ");
    let shown = (seen.id != 0).then(|| (decimal_f32(seen.t.into()), normal()));
    let (t, normal) = shown.unwrap_or_default();
    let error = match (seen.right, seen.t_error_ulp) {
        (false, _) => words.wrong.into(),
        (true, Some(error)) if error.is_infinite() => "∞".into(),
        (true, Some(error)) => format!("{} ulp", rough(error)),
        (true, None) => String::new(),
    };
    let device = seen.device.to_uppercase();
    let row = format!("  {:<9} {device:<3} {label:<25} {t:>15} {error:>11}  {normal}", seen.kernel);
    format!("{}\n", row.trim_end())
}
