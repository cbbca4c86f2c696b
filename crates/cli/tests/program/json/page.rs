//! The page `docs/json.md`: text that is kept, then tables of the fields.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::schema::{JsonObject, JsonType, Schema};

/// Line of the page after which everything is generated.
const MARK: &str = "<!-- Everything below is generated. -->\n";

/// Headings, with the type of each and its file. The heading of a summary names its commands.
const SECTIONS: [(&str, &str, &str); 14] = [
    ("Every object", "Summary", "cli/src/head.rs"),
    ("compare", "CompareSummary", "cli/src/compare.rs"),
    ("digest", "DigestSummary", "cli/src/digest.rs"),
    ("explain", "ExplainSummary", "cli/src/explain.rs"),
    ("export", "ExportSummary", "cli/src/export.rs"),
    ("figure", "FigureSummary", "cli/src/figure.rs"),
    ("generate", "GenerateSummary", "cli/src/generate.rs"),
    ("info", "InfoSummary", "cli/src/info.rs"),
    ("new", "NewSummary", "cli/src/new.rs"),
    ("probe", "ProbeSummary", "cli/src/probe.rs"),
    ("render, trace", "Traced", "cli/src/head.rs"),
    ("film", "FilmSummary", "cli/src/film.rs"),
    ("report", "Report", "report/src/lib.rs"),
    ("verify", "VerifySummary", "cli/src/verify.rs"),
];

/// Returns the objects of the summary of a command, or of a section with another heading.
pub fn summary(schema: &Schema, command: &str) -> Vec<JsonObject> {
    let is_of = |heading: &str| heading.split(", ").any(|name| name == command);
    let section = SECTIONS.iter().find(|(heading, ..)| is_of(heading));
    let (_, name, file) = section.unwrap_or_else(|| panic!("{command} has no section"));
    schema.objects(name, file)
}

/// Objects by their names, with the number of fields that contain each.
type Uses<'t> = BTreeMap<&'t str, (usize, &'t JsonObject)>;

fn count<'t>(object: &'t JsonObject, uses: &mut Uses<'t>) {
    for (inner, _) in object.fields.iter().filter_map(|field| field.json_type.object()) {
        let (n, _) = uses.entry(&inner.name).or_insert((0, inner));
        *n += 1;
        if *n == 1 {
            count(inner, uses);
        }
    }
}

/// Whether an object has a separate section.
fn is_shared(object: &JsonObject, uses: &Uses) -> bool {
    uses.get(object.name.as_str()).is_some_and(|(n, _)| *n > 1)
}

/// Returns `Ray counts` for `RayCounts`.
fn title(name: &str) -> String {
    let mut title = String::new();
    for letter in name.chars() {
        if letter.is_uppercase() && !title.is_empty() {
            title.push(' ');
            title.extend(letter.to_lowercase());
        } else {
            title.push(letter);
        }
    }
    title
}

fn link(heading: &str) -> String {
    let heading = heading.to_lowercase();
    format!("[{heading}](#{})", heading.replace(' ', "-").replace(',', ""))
}

/// Returns the name of a type in a table.
fn label(json_type: &JsonType, uses: &Uses) -> String {
    match json_type {
        JsonType::Text(_) => "text".into(),
        JsonType::Integer => "integer".into(),
        JsonType::Number => "number".into(),
        JsonType::Boolean => "boolean".into(),
        JsonType::Nullable(inner) => {
            let comma = if matches!(**inner, JsonType::List(..)) { "," } else { "" };
            format!("{}{comma} or null", label(inner, uses))
        }
        JsonType::List(inner, n) => {
            let n = n.map_or(String::new(), |n| format!("{n} "));
            format!("list of {n}{}", plural(&label(inner, uses)))
        }
        JsonType::Map(inner) => format!("map of {}", plural(&label(inner, uses))),
        JsonType::Object(object) if is_shared(object, uses) => link(&title(&object.name)),
        JsonType::Object(_) => "object".into(),
    }
}

/// Returns `lists of integers` for `list of integers`, `[exacts](#exact)` for `[exact](#exact)`.
fn plural(label: &str) -> String {
    match label.split_once(' ') {
        _ if label.starts_with('[') => label.replacen(']', "s]", 1),
        Some((noun, rest)) => format!("{noun}s {rest}"),
        None => format!("{label}s"),
    }
}

fn rows(page: &mut String, object: &JsonObject, prefix: &str, is_stable: bool, uses: &Uses) {
    for field in &object.fields {
        let path = format!("{prefix}{}", field.key);
        let is_stable = is_stable && field.is_stable;
        let stable = if is_stable { "yes" } else { "no" };
        let label = label(&field.json_type, uses);
        let optional = if field.is_optional { ", optional" } else { "" };
        let doc = match &field.json_type {
            JsonType::Text(values) => format!("{} {values}", field.doc),
            _ => field.doc.clone(),
        };
        let doc = doc.trim_end();
        let _ = writeln!(page, "| `{path}` | {label}{optional} | {stable} | {doc} |");
        if let Some((inner, list)) = field.json_type.object()
            && !is_shared(inner, uses)
        {
            rows(page, inner, &format!("{path}{list}."), is_stable, uses);
        }
    }
}

fn table(page: &mut String, object: &JsonObject, uses: &Uses) {
    assert!(!object.doc.is_empty(), "{} has no doc comment", object.name);
    let head = "| field | type | stable | meaning |\n| --- | --- | --- | --- |";
    let _ = writeln!(page, "\n{}\n\n{head}", object.doc);
    rows(page, object, "", true, uses);
}

/// Returns the page, with the text before the mark in `kept`.
pub fn page(kept: &str, schema: &Schema) -> String {
    let sections = SECTIONS.map(|(heading, name, file)| (heading, schema.objects(name, file)));
    let mut uses = Uses::new();
    sections.iter().flat_map(|(_, objects)| objects).for_each(|object| count(object, &mut uses));
    let text = kept.split(MARK).next().unwrap_or_default();
    let links = sections.each_ref().map(|(heading, _)| link(heading)).join(", ");
    let mut page = format!("{text}{MARK}\nSections: {links}, and [shapes](#shapes).\n");
    for (heading, objects) in &sections {
        let _ = writeln!(page, "\n## {heading}");
        objects.iter().for_each(|object| table(&mut page, object, &uses));
    }
    page += "\n## Shapes\n\nObjects in several of the tables above.\n";
    for (n, object) in uses.values() {
        if *n > 1 {
            let _ = writeln!(page, "\n### {}", title(&object.name));
            table(&mut page, object, &uses);
        }
    }
    page
}
