//! Which column of a file is what.
//!
//! A file's columns have names: those of a csv header, of the fields of a structured array, of
//! `Properties=`. A field of several numbers is as many columns, `velocity:0`, `velocity:1` and so on.
//! What a scene names under `columns` is taken; the rest is found by the names that people give it.

use std::ops::Range;

use super::CloudFile;
use crate::error::{Error, Result};
use crate::plain::Shown;
use crate::scene::places::quoted;
use crate::scene::schema::{ColumnKeys, Section};
use crate::scene::{Color, Sphere};
use crate::words::{cut, did_you_mean};

/// What a column may be: the place of its key in [`ColumnKeys`]. What spheres are coloured by is in the places of
/// their colours.
pub(super) type Part = usize;

const X: Part = 0;
const RADIUS: Part = 3;
const DIAMETER: Part = 4;
pub(super) const RED: Part = 5;
const ELEMENT: Part = 8;

/// Puts the number of a part in its place.
pub(super) fn put(part: Part, number: f64, sphere: &mut Sphere, color: &mut Color) {
    match part {
        X..RADIUS => sphere.center[part] = number,
        RADIUS => sphere.radius = number,
        DIAMETER => sphere.radius = 0.5 * number,
        _ => color.0[part - RED] = number,
    }
}

/// What the scene says of each part: the name of its column, `None` in place of one where there is none.
fn said(columns: &ColumnKeys) -> [Option<Option<&str>>; 9] {
    let ColumnKeys { x, y, z, radius, diameter, red, green, blue, element, .. } = columns;
    [x, y, z, radius, diameter, red, green, blue, element]
        .map(|said| said.as_ref().map(Option::as_deref))
}

/// A file's columns, and how its kind calls them.
pub(super) struct Header<'h> {
    /// The names as they stand in the file.
    pub names: &'h [String],
    /// What has these names: `the header`, for one.
    pub what: &'h str,
    /// How a file of this kind is written.
    pub help: &'h str,
    /// True where a column `element` tells what lacks.
    pub has_elements: bool,
    /// True where a column may be named by its place, from 0.
    pub has_places: bool,
}

/// The columns that are read, by their places.
pub(super) struct Layout {
    pub parts: Vec<(usize, Part)>,
    /// The element, where it gives the radius, the colour.
    pub element: Option<(usize, [bool; 2])>,
    /// What the file calls that which spheres are coloured by.
    pub color_by: String,
    /// True where the file gives a radius, by itself or by the element.
    pub has_radius: bool,
    /// True where there are columns of colours.
    pub has_colors: bool,
    /// True where spheres are coloured by the length of a vector.
    pub has_vector: bool,
}

/// Names of centres; the first are those of an error.
const CENTERS: [[&str; 3]; 9] = [
    ["x", "y", "z"],
    ["xu", "yu", "zu"],
    ["pos:0", "pos:1", "pos:2"],
    ["position:0", "position:1", "position:2"],
    ["points:0", "points:1", "points:2"],
    ["center:0", "center:1", "center:2"],
    ["pos_x", "pos_y", "pos_z"],
    ["position_x", "position_y", "position_z"],
    ["center_x", "center_y", "center_z"],
];
const RADII: [&str; 3] = ["r", "radius", "radii"];
const DIAMETERS: [&str; 2] = ["diameter", "diam"];
const COLORS: [[&str; 3]; 6] = [
    ["red", "green", "blue"],
    ["r", "g", "b"],
    ["color:0", "color:1", "color:2"],
    ["colour:0", "colour:1", "colour:2"],
    ["colors:0", "colors:1", "colors:2"],
    ["rgb:0", "rgb:1", "rgb:2"],
];
const ELEMENTS: [&str; 3] = ["element", "species", "symbol"];

/// A name as it is compared: in lower case, without a unit: `X [m]`, `x(mm)` and `x / m` are `x`.
fn plain_name(name: &str) -> String {
    let name = name.trim();
    let ends = [name.find(['[', '(']), name.find(" / ")];
    let end = ends.into_iter().flatten().filter(|end| *end > 0).min().unwrap_or(name.len());
    name[..end].trim_end().to_lowercase()
}

/// The columns of one file, while their parts are found.
struct Finder<'f> {
    source: &'f CloudFile<'f>,
    columns: &'f ColumnKeys,
    said: [Option<Option<&'f str>>; 9],
    header: &'f Header<'f>,
    plain: Vec<String>,
}

impl Layout {
    /// Finds the columns. What lacks, what could be two things, and a radius that nobody would read
    /// are errors.
    pub fn find(source: &CloudFile, header: &Header) -> Result<Layout> {
        let keys = source.keys;
        let columns = &keys.columns.clone().unwrap_or_default();
        let plain = header.names.iter().map(|name| plain_name(name)).collect();
        let finder = Finder { source, columns, said: said(columns), header, plain };
        let center = finder.center()?;
        let color = finder.color()?;
        let radius = finder.radius(color)?;
        let color = color.filter(|_| keys.color_by.is_none());
        let element = finder.element()?;
        let (mut colors, mut color_by) =
            (Vec::from(color.as_slice().as_flattened()), String::new());
        if let Some(name) = &keys.color_by {
            colors = finder.color_by(name, center, radius)?;
            color_by = match colors[..] {
                [column] => header.names[column].clone(),
                _ => name.clone(),
            };
        }
        let gives =
            [radius.is_none() && !finder.denies(RADIUS), colors.is_empty() && !finder.denies(RED)];
        let element = element.filter(|_| gives.contains(&true));
        let numbered = |columns: &[usize], first: Part| {
            columns.iter().copied().zip(first..).collect::<Vec<_>>()
        };
        Ok(Layout {
            parts: [numbered(&center, X), Vec::from_iter(radius), numbered(&colors, RED)].concat(),
            element: element.map(|column| (column, gives)),
            color_by,
            has_radius: radius.is_some() || element.is_some() && gives[0],
            has_colors: color.is_some(),
            has_vector: color.is_none() && colors.len() > 1,
        })
    }
}

impl Finder<'_> {
    /// True where the scene says that no column is that.
    fn denies(&self, part: Part) -> bool {
        self.said[part] == Some(None)
    }

    /// The one column that is called so by its plain name.
    fn find(&self, name: &str) -> Result<Option<usize>> {
        let mut places = (0..self.plain.len()).filter(|&column| self.plain[column] == name);
        let place = places.next();
        if places.next().is_some() {
            let message = format!("{} names the column `{name}` twice", self.header.what);
            let help = "rename one of them, or name another under `columns`";
            return Err(self.source.wrong(message, help));
        }
        Ok(place)
    }

    fn is_there(&self, name: &str) -> bool {
        self.plain.iter().any(|plain| plain == name)
    }

    /// The columns that the user calls so: as it stands, by its plain name, by its place, or as a
    /// vector.
    fn called(&self, name: &str) -> Result<Vec<usize>> {
        let plain = plain_name(name);
        let is_place = |place: &usize| self.header.has_places && *place < self.plain.len();
        let found = match self.header.names.iter().position(|other| other == name) {
            Some(column) => Some(column),
            None => self.find(&plain)?.or_else(|| name.parse().ok().filter(is_place)),
        };
        if let Some(column) = found {
            return Ok(vec![column]);
        }
        let parts = (0..).map(|i| self.find(&format!("{plain}:{i}")));
        parts.map_while(Result::transpose).collect()
    }

    /// The column that the scene names for a part.
    fn named(&self, part: Part) -> Result<Option<usize>> {
        let Some(Some(name)) = self.said[part] else { return Ok(None) };
        let span = self.columns.span(ColumnKeys::INFO.keys[part].name);
        match self.called(name)?[..] {
            [column] => Ok(Some(column)),
            [] => Err(self.unknown(span, name)),
            _ => Err(self.vector(span, name)),
        }
    }

    fn unknown(&self, span: Range<usize>, name: &str) -> Error {
        let known = self.header.names.iter().chain(&self.plain).map(String::as_str);
        let hint = did_you_mean(known, name)
            .map_or(String::new(), |near| format!("did you mean {:?}? ", quoted(near)));
        let all = self.header.names.join(", ");
        let found = format!("{} has no column {:?}", self.header.what, quoted(name));
        let help = format!("{hint}its columns are {}", cut(&all, 300).shown());
        self.source.wrong_at(span, found, help)
    }

    fn vector(&self, span: Range<usize>, name: &str) -> Error {
        let name = quoted(name);
        let help = format!("choose one of them, \"{}:0\" for the first", name.shown());
        self.source.wrong_at(span, format!("{name:?} has several numbers"), help)
    }

    /// Three columns from this part on: those that the scene names, and the others by these names.
    fn three(&self, first: Part, names: &[&str; 3]) -> Result<[usize; 3]> {
        let mut columns = [0; 3];
        for (axis, name) in names.iter().enumerate() {
            columns[axis] = match self.named(first + axis)? {
                Some(column) => column,
                None => self.find(name)?.ok_or_else(|| {
                    let found = self.header.names.join(", ").to_lowercase();
                    let what = self.header.what;
                    let message =
                        format!("{what} has no column `{name}`, only {:?}", quoted(&found));
                    self.source.wrong(message, self.header.help)
                })?,
            };
        }
        Ok(columns)
    }

    fn is_any_named(&self, first: Part) -> bool {
        self.said[first..first + 3].iter().any(Option::is_some)
    }

    fn center(&self) -> Result<[usize; 3]> {
        let is_named = self.is_any_named(X);
        let is_there =
            |names: &&[&str; 3]| !is_named && names.iter().all(|name| self.is_there(name));
        self.three(X, CENTERS.iter().find(is_there).unwrap_or(&CENTERS[0]))
    }

    fn color(&self) -> Result<Option<[usize; 3]>> {
        if (RED..RED + 3).any(|part| self.denies(part)) {
            return Ok(None);
        }
        // `r` may be named as the radius.
        let radius = self.named(RADIUS)?;
        let is_named = self.is_any_named(RED);
        let is_free = |name: &&str| self.find(name).is_ok_and(|c| c.is_some() && c != radius);
        let is_there = |names: &&[&str; 3]| !is_named && names.iter().all(is_free);
        // One or two of them lack the others.
        let is_begun = is_named || COLORS[0].iter().any(|name| self.is_there(name));
        let names = COLORS.iter().find(is_there).or(is_begun.then_some(&COLORS[0]));
        names.map(|names| self.three(RED, names)).transpose()
    }

    /// The radius or the diameter.
    fn radius(&self, color: Option<[usize; 3]>) -> Result<Option<(usize, Part)>> {
        if self.denies(RADIUS) {
            return Ok(None);
        }
        match [self.named(RADIUS)?, self.named(DIAMETER)?] {
            [Some(_), Some(_)] => {
                let message = "both a radius and a diameter are named under `columns`";
                return Err(self.source.wrong(message, "name the one that is to be used"));
            }
            [Some(column), None] => return Ok(Some((column, RADIUS))),
            [None, Some(column)] => return Ok(Some((column, DIAMETER))),
            [None, None] => {}
        }
        for (names, part) in [(&RADII[..], RADIUS), (&DIAMETERS, DIAMETER)] {
            let found = names.iter().filter_map(|name| self.find(name).transpose());
            let mut found = found.collect::<Result<Vec<usize>>>()?;
            // One of them may be the red.
            found.retain(|column| !color.is_some_and(|color| color.contains(column)));
            if let [column] = found[..] {
                return Ok(Some((column, part)));
            }
            if let [one, other, ..] = found[..] {
                let [one, other] = [one, other].map(|column| quoted(&self.header.names[column]));
                return Err(self.source.wrong(
                    format!("both of the columns {one:?} and {other:?} may be the radius"),
                    format!(
                        "name one of them, e.g. `columns = {{ radius = \"{}\" }}`",
                        one.shown()
                    ),
                ));
            }
        }
        let is_like = |name: &&String| {
            ["radius", "radii", "diameter"].iter().any(|word| name.to_lowercase().contains(word))
        };
        let Some(unused) = self.header.names.iter().find(is_like) else { return Ok(None) };
        let unused = quoted(unused);
        let key = if unused.to_lowercase().contains("diam") { "diameter" } else { "radius" };
        Err(self.source.wrong(
            format!("the column {unused:?} is not used: is it the {key}?"),
            format!(
                "if so, `columns = {{ {key} = \"{}\" }}`; if not, \
                 `columns = {{ radius = false }}`, and `radius` for all spheres",
                unused.shown()
            ),
        ))
    }

    fn element(&self) -> Result<Option<usize>> {
        match self.named(ELEMENT)? {
            Some(column) => Ok(Some(column)),
            None if self.denies(ELEMENT) || !self.header.has_elements => Ok(None),
            None => ELEMENTS.iter().find_map(|name| self.find(name).transpose()).transpose(),
        }
    }

    fn color_by(
        &self,
        name: &str,
        center: [usize; 3],
        radius: Option<(usize, Part)>,
    ) -> Result<Vec<usize>> {
        let (found, span) = (self.called(name)?, self.source.keys.span("color_by"));
        match (found.len(), name, radius) {
            (1..=3, ..) => Ok(found),
            (4.., ..) => Err(self.vector(span, name)),
            // What the scene calls it, where the file has another name for it.
            (0, "x", _) => Ok(vec![center[0]]),
            (0, "y", _) => Ok(vec![center[1]]),
            (0, "z", _) => Ok(vec![center[2]]),
            (0, "radius", Some((column, RADIUS))) => Ok(vec![column]),
            _ => Err(self.unknown(span, name)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_compared_without_case_and_unit() {
        for name in ["x", " X ", "x [m]", "x(mm)", "X / m", "x [m] (raw)"] {
            assert_eq!(plain_name(name), "x", "{name}");
        }
        for (name, plain) in [("(x)", "(x)"), ("x_m", "x_m"), ("a/b", "a/b"), ("Größe", "größe")]
        {
            assert_eq!(plain_name(name), plain);
        }
    }
}
