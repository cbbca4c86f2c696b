//! An [`Explanation`] as plain text of at most [`WIDTH`] columns.

use std::fmt::Write;

use super::latex::side;
use super::line::{Line, text_of};
use super::numbers::{decimal_f32, decimal_f64, six_digits};
use super::words::{Remark, Words};
use super::{
    Approximation, Channel, ColorExplanation, Explanation, LeftOut, MOST_OBJECTS, MeanExplanation,
    Quantity, Seen, Shading, SkyExplanation, Winner, shortened,
};

/// Columns that the text takes at most.
pub const WIDTH: usize = 100;

/// The whole explanation.
pub fn text(explanation: &Explanation) -> String {
    let words = explanation.lang.words();
    let mut text = format!("{}\n", explanation.subject());
    formulas(&explanation.ray_lines, &mut text);
    table(&explanation.ray, words, &mut text);
    let first_sphere = explanation.objects.iter().position(|object| object.shape == "sphere");
    for (i, object) in explanation.objects.iter().enumerate() {
        let _ = writeln!(text, "\n{}", object.label);
        remarks(&object.why, &mut text);
        formulas(&object.lines, &mut text);
        if first_sphere == Some(i) {
            text += words.stable_notes;
        }
        table(&object.quantities, words, &mut text);
    }
    let LeftOut { hit, behind, missed } = explanation.left_out;
    let n_left_out = hit + behind + missed;
    if n_left_out > 0 {
        let numbers = [n_left_out, explanation.n_objects, hit, behind, missed];
        let left_out = Remark::new(words.left_out, numbers.map(|n| n.to_string()));
        let _ = writeln!(text, "\n{left_out}");
        if explanation.objects.len() < MOST_OBJECTS {
            let _ = writeln!(text, "{}", Remark::new(words.all_shows, [MOST_OBJECTS.to_string()]));
        }
    }
    seen_and_shown(explanation, words, &mut text);
    if let Some(shading) = &explanation.shading {
        of_shading(shading, words, &mut text);
    }
    let _ = write!(text, "\n{}", Remark::new(words.notes, [explanation.digits.to_string()]));
    if explanation.shading.is_some() {
        text += words.light_notes;
    }
    text
}

/// What lights the point, and the colour that comes of it.
fn of_shading(shading: &Shading, words: &'static Words, text: &mut String) {
    for light in &shading.lights {
        let _ = writeln!(text, "\n{}, {}", light.name, light.place);
        remarks(&light.why, text);
        formulas(&light.lines, text);
        if !light.quantities.is_empty() {
            table(&light.quantities, words, text);
        }
    }
    if let Some(sky) = &shading.sky {
        let _ = writeln!(text, "\n{}", sky.subject(words));
        remarks(&[sky.counts(words)], text);
        table(&sky.quantities, words, text);
    }
    let _ = writeln!(text, "\n{}", Remark::plain(words.color_of_ray));
    of_color(&shading.color, words, text);
    if let Some(mean) = &shading.mean {
        let _ = writeln!(text, "\n{}", mean.subject(words));
        of_color(&mean.color, words, text);
    }
}

impl SkyExplanation {
    pub(super) fn subject(&self, words: &Words) -> Remark {
        Remark::new(words.sky, [self.counting, self.directions].map(|n| n.to_string()))
    }

    pub(super) fn counts(&self, words: &Words) -> Remark {
        let counts = [self.counting, self.behind, self.hidden].map(|n| n.to_string());
        Remark::new(words.sky_counts, counts)
    }
}

impl MeanExplanation {
    pub(super) fn subject(&self, words: &Words) -> Remark {
        Remark::new(words.color_of_pixel, [self.samples; 2].map(|n| n.to_string()))
    }
}

fn of_color(color: &ColorExplanation, words: &'static Words, text: &mut String) {
    formulas(&color.lines, text);
    table(&color.quantities, words, text);
    for (channel, name) in color.channels.iter().zip(words.channels) {
        let Channel { byte, range: [low, high], from_edge, .. } = channel;
        let away = from_edge.root.to_decimal(4);
        let mut parts = vec![name.to_owned(), byte.to_string()];
        let ends = [low, high].into_iter().filter(|end| end.is_finite());
        parts.extend(ends.map(|end| six_digits(*end)));
        parts.push(away);
        let phrase = match (low.is_finite(), high.is_finite()) {
            (false, _) => words.byte_below,
            (_, false) => words.byte_above,
            _ => words.byte,
        };
        remarks(&[Remark::new(phrase, parts)], text);
    }
    remarks(&color.why, text);
}

fn remarks(why: &[Remark], text: &mut String) {
    for why in why {
        let _ = writeln!(text, "  → {why}");
    }
}

fn formulas(lines: &[Line], text: &mut String) {
    for line in text_of(lines, WIDTH) {
        let _ = writeln!(text, "{line}");
    }
}

/// A row of the table, right-aligned; columns that are blank at the end leave no blanks behind.
fn line(symbol: &str, cells: [String; 4], text: &mut String) {
    let [lecture, stable, double, exact] = cells;
    let row = format!("  {symbol:<7} {lecture:>16} {stable:>16} {double:>25} {exact:>28}");
    let _ = writeln!(text, "{}", row.trim_end());
}

fn table(quantities: &[Quantity], words: &Words, text: &mut String) {
    let columns = ["f32 lecture", "f32 stable", "f64", words.exact_column];
    line("", columns.map(str::to_owned), text);
    for row in quantities {
        let columns = [(row.lecture, false), (row.stable, false), (row.f64, true)];
        let value = |(entry, double): (Option<Approximation>, bool)| match entry {
            None => String::new(),
            Some(Approximation { value: None, .. }) => words.none.into(),
            Some(Approximation { value: Some(x), .. }) if double => decimal_f64(x),
            Some(Approximation { value: Some(x), .. }) => decimal_f32(x),
        };
        let [lecture, stable, double] = columns.map(value);
        let exact = row.exact.as_ref().map_or(words.none.into(), |exact| exact.decimal.clone());
        line(words.symbol(row.symbol), [lecture, stable, double, exact], text);
        let errors = columns.map(|(entry, _)| match entry {
            Some(entry) => error(&entry, row.exact.is_some(), words),
            None => String::new(),
        });
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

/// What the ray sees, in one or two lines.
pub fn verdict(explanation: &Explanation) -> String {
    let words = explanation.lang.words();
    match &explanation.winner {
        None => format!("{}\n", Remark::plain(words.sees_background)),
        Some(winner) => {
            let Winner { label, t, .. } = winner;
            let mut text = format!("{}\n", Remark::new(words.sees, [label, t]));
            remarks(&[Remark::plain(side(words, winner))], &mut text);
            text
        }
    }
}

fn seen_and_shown(explanation: &Explanation, words: &'static Words, text: &mut String) {
    let _ = write!(text, "\n{}", verdict(explanation));
    if let Some(point) = &explanation.point {
        formulas(&point.lines, text);
        table(&point.quantities, words, text);
    }
    let stage = match explanation.level {
        "exact" => words.exact_arithmetic,
        other => other,
    };
    let _ = writeln!(text, "\n{}\n", Remark::new(words.decided, [stage]));
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

fn of_seen(seen: &Seen, words: &Words, text: &mut String) {
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
