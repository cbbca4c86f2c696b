//! An [`Explanation`] as plain text of at most [`WIDTH`] columns.

use std::fmt::Write;

use super::formula::{Line, Notation, derivation, of_color, of_light, of_point, written};
use super::numbers::{decimal_f32, decimal_f64};
use super::{
    Approximation, Channel, ColorExplanation, Explanation, ObjectExplanation, Quantity, Seen,
    Shading, SkyExplanation, Winner, shortened,
};

/// Columns that the text takes at most.
pub const WIDTH: usize = 100;

const NOTES: &str = "\
Formulas: exact numbers, rounded to 6 digits (≈ where digits are missing). Tables: every f32 is the
one that the kernel works with. A line of errors follows where a number is not exact: in ulp, the
distance of neighbouring f32 numbers (f64 column: of f64 numbers) at the exact value.
stable, with L = c − o: b = −2·d·L, k = L·L − r², P = L − (d·L/a)·d, r² − P·P = D/4a,
h = √(a·(r² − P·P)) = √D/2; its roots are q/a and k/q with q = d·L ± h.
";

const LIGHT_NOTES: &str = "\
Light: w is the way to the light, ω = w/|w|, s the part of it up to what is in the way, I the colour
times the intensity. stable has its points relative to the camera; f64 is the kernel double; none of
the three uses an epsilon.
";

/// The whole explanation.
pub fn text(explanation: &Explanation) -> String {
    let mut text = match &explanation.pixel {
        Some(p) => format!(
            "Pixel ({}, {}) of {}×{}: the ray p(t) = o + t·d\n",
            p.x, p.y, p.width, p.height
        ),
        None => "The ray p(t) = o + t·d\n".to_owned(),
    };
    table(&explanation.ray, &mut text);
    for object in &explanation.objects {
        text.push('\n');
        text.push_str(&of_object(object));
    }
    let left_out = explanation.n_objects - explanation.objects.len().min(explanation.n_objects);
    if left_out > 0 {
        let _ = writeln!(text, "\nLeft out: {left_out} more of {} objects", explanation.n_objects);
    }
    text.push('\n');
    verdict(explanation, &mut text);
    if let Some(shading) = &explanation.shading {
        of_shading(shading, &mut text);
        text.push('\n');
        text.push_str(NOTES);
        return text + LIGHT_NOTES;
    }
    text.push('\n');
    text + NOTES
}

/// What lights the point, and the colour that comes of it.
fn of_shading(shading: &Shading, text: &mut String) {
    if let Some(point) = &shading.point {
        text.push_str("\nThe point that the ray sees\n");
        formulas(&of_point(point), text);
        table(&point.quantities, text);
    }
    for light in &shading.lights {
        let _ = writeln!(text, "\n{}, {}", light.name, light.place);
        remarks(&light.why, text);
        formulas(&of_light(light), text);
        if !light.quantities.is_empty() {
            table(&light.quantities, text);
        }
    }
    if let Some(SkyExplanation { directions, counting, behind, hidden, quantities }) = &shading.sky
    {
        let _ = writeln!(text, "\nsky, {counting} of {directions} directions");
        let _ = writeln!(
            text,
            "  → {counting} count, {behind} are behind the surface, {hidden} have something in \
             their way"
        );
        table(quantities, text);
    }
    text.push_str("\nThe colour of the ray\n");
    of_color_and_bytes(&shading.color, text);
    if let Some(mean) = &shading.mean {
        let _ =
            writeln!(text, "\nThe colour of the pixel: the mean of {0}×{0} samples", mean.samples);
        of_color_and_bytes(&mean.color, text);
    }
}

fn of_color_and_bytes(color: &ColorExplanation, text: &mut String) {
    formulas(&of_color(color), text);
    table(&color.quantities, text);
    for Channel { name, byte, range: [low, high], from_edge } in &color.channels {
        let ends = match (low.is_finite(), high.is_finite()) {
            (false, _) => format!("below {}", six_digits(*high)),
            (_, false) => format!("{} and more", six_digits(*low)),
            _ => format!("{} to {}", six_digits(*low), six_digits(*high)),
        };
        let away = &from_edge.short.text;
        let _ = writeln!(
            text,
            "  → {name} is byte {byte}, which stands for {ends}: {away} from its edge"
        );
    }
    remarks(&color.why, text);
}

fn remarks(why: &[String], text: &mut String) {
    for why in why {
        let _ = writeln!(text, "  → {why}");
    }
}

fn formulas(lines: &[Line], text: &mut String) {
    for line in written(lines, Notation::Text) {
        broken(&format!("  {line}"), text);
    }
}

/// One object: why, formula, numbers.
pub fn of_object(object: &ObjectExplanation) -> String {
    let mut text = format!("{}\n", object.label);
    for (i, why) in object.why.iter().enumerate() {
        let gap = object.gap.filter(|gap| i == 0 && *gap > 0.0);
        let gap = gap.map(|gap| format!("; it passes at a distance of {}", four_digits(gap)));
        let _ = writeln!(text, "  → {why}{}", gap.unwrap_or_default());
    }
    formulas(&derivation(object), &mut text);
    table(&object.quantities, &mut text);
    text
}

/// A line of a formula, continued on the next one where it is too wide.
fn broken(line: &str, text: &mut String) {
    let relation = [" = ", " ≈ "].into_iter().filter_map(|relation| line.rfind(relation)).max();
    match relation {
        Some(at) if line.chars().count() > WIDTH => {
            let _ = writeln!(text, "{}\n     {}", &line[..at], &line[at..]);
        }
        _ => {
            let _ = writeln!(text, "{line}");
        }
    }
}

/// A row of the table, right-aligned; columns that are blank at the end leave no blanks behind.
fn line(symbol: &str, cells: [String; 4], text: &mut String) {
    let [lecture, stable, double, exact] = cells;
    let row = format!("  {symbol:<7} {lecture:>16} {stable:>16} {double:>25} {exact:>28}");
    let _ = writeln!(text, "{}", row.trim_end());
}

fn table(quantities: &[Quantity], text: &mut String) {
    line("", ["f32 lecture", "f32 stable", "f64", "exact"].map(str::to_owned), text);
    for row in quantities {
        let columns = [(row.lecture, false), (row.stable, false), (row.f64, true)];
        let value = |(entry, double): (Option<Approximation>, bool)| match entry {
            None => String::new(),
            Some(Approximation { value: None, .. }) => "none".into(),
            Some(Approximation { value: Some(x), .. }) if double => decimal_f64(x),
            Some(Approximation { value: Some(x), .. }) => decimal_f32(x),
        };
        let [lecture, stable, double] = columns.map(value);
        let exact = row.exact.as_ref().map_or("none".into(), |exact| exact.decimal.clone());
        line(row.symbol, [lecture, stable, double, exact], text);
        let errors = columns.map(|(entry, _)| match entry {
            Some(entry) => error(&entry, row.exact.is_some()),
            None => String::new(),
        });
        if errors.iter().any(|error| !error.is_empty() && error != "exact") {
            let [lecture, stable, double] = errors;
            line("", [lecture, stable, double, String::new()], text);
        }
    }
}

/// `0.31 ulp`, `sign! 3.1e6 ulp` where the sign is wrong.
fn error(entry: &Approximation, has_exact: bool) -> String {
    match entry.error_ulp {
        None if entry.value.is_some() => "no root".into(),
        None if has_exact => "root lost".into(),
        None => String::new(),
        Some(0.0) => "exact".into(),
        Some(error) if error.is_infinite() && entry.value.is_some_and(f64::is_finite) => {
            "should be 0".into()
        }
        Some(error) if error.is_infinite() => "overflow".into(),
        Some(error) => {
            let sign = if entry.wrong_sign { "sign! " } else { "" };
            format!("{sign}{} ulp", rough(error))
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

fn verdict(explanation: &Explanation, text: &mut String) {
    match &explanation.winner {
        None => text.push_str("The ray sees the background.\n"),
        Some(Winner { label, t, normal, side, .. }) => {
            let _ = writeln!(text, "The ray sees {label}: t = {t}");
            let _ = writeln!(text, "  its {side}; the unit normal that faces the ray:");
            for (axis, component) in ["n.x", "n.y", "n.z"].into_iter().zip(normal) {
                let _ = writeln!(text, "  {axis} = {component}");
            }
        }
    }
    let stage = match explanation.level {
        "exact" => "exact arithmetic",
        other => other,
    };
    let _ = writeln!(text, "The kernel certified decided this ray in {stage}.\n");
    let _ = writeln!(
        text,
        "  {:<9} {:<3} {:<25} {:>15} {:>11}  normal",
        "kernel", "on", "shows", "t", "error"
    );
    for seen in &explanation.seen {
        of_seen(seen, text);
    }
    if explanation.seen.iter().all(|seen| seen.device != "gpu") {
        text.push_str("  No GPU took part: these are the CPU's results alone.\n");
    }
}

fn of_seen(seen: &Seen, text: &mut String) {
    let label = shortened(&seen.label, 25);
    let (t, normal) = match seen.id {
        0 => (String::new(), String::new()),
        _ => (
            decimal_f32(f64::from(seen.t)),
            seen.normal.map(|component| format!("{component:.4}")).join(" "),
        ),
    };
    let error = match (seen.right, seen.t_error_ulp) {
        (false, _) => "WRONG".into(),
        (true, Some(error)) if error.is_infinite() => "∞".into(),
        (true, Some(error)) => format!("{} ulp", rough(error)),
        (true, None) => String::new(),
    };
    let device = seen.device.to_uppercase();
    let row = format!("  {:<9} {device:<3} {label:<25} {t:>15} {error:>11}  {normal}", seen.kernel);
    let _ = writeln!(text, "{}", row.trim_end());
}

/// Six digits, without zeros that say nothing.
fn six_digits(x: f64) -> String {
    format!("{x:.5e}").parse().map_or_else(|_| String::new(), decimal_f64)
}

/// Four digits, without zeros that say nothing.
fn four_digits(x: f64) -> String {
    format!("{x:.3e}").parse().map_or_else(|_| String::new(), decimal_f64)
}
