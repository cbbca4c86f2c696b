//! Which column of a file is what.
//!
//! A file's columns have names: those of a csv header, of the fields of a structured array, of
//! `Properties=`. A field of several numbers is as many columns, `velocity:0`, `velocity:1` and so on.
//! What a scene names under `columns` is taken; the rest is found by the names that people give it.

use std::ops::Range;

use super::CloudFile;
use crate::plain::Shown;
use crate::scene::places::{Stop, quoted};
use crate::scene::schema::{ColumnKeys, Section};
use crate::scene::{Color, Sphere};
use crate::words::{cut, did_you_mean};

/// What a column may be: what a scene names under this key, if it does; `None` in place of a name is its
/// `false`, no column is that.
type Part = (&'static str, fn(&ColumnKeys) -> &Option<Option<String>>);

const RADIUS: Part = ("radius", |keys| &keys.radius);
const DIAMETER: Part = ("diameter", |keys| &keys.diameter);
const ELEMENT: Part = ("element", |keys| &keys.element);
const CENTER: [Part; 3] = [("x", |keys| &keys.x), ("y", |keys| &keys.y), ("z", |keys| &keys.z)];
const COLOR: [Part; 3] =
    [("red", |keys| &keys.red), ("green", |keys| &keys.green), ("blue", |keys| &keys.blue)];

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

/// What the number in a column becomes.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Target {
    /// A coordinate of the centre.
    Center(usize),
    /// The radius, when it is multiplied by this: a diameter by ½.
    Radius(f64),
    /// A channel of the colour.
    Color(usize),
    /// A part of what the colour is made from, the length of a vector where there are several.
    ColorBy(usize),
}

impl Target {
    pub fn put(self, number: f64, sphere: &mut Sphere, color: &mut Color) {
        match self {
            Target::Center(axis) => sphere.center[axis] = number,
            Target::Radius(factor) => sphere.radius = factor * number,
            Target::Color(part) | Target::ColorBy(part) => color.0[part] = number,
        }
    }
}

/// The columns that are read, by their places.
pub(super) struct Layout {
    pub targets: Vec<(usize, Target)>,
    /// The element, where it gives the radius, the colour.
    pub element: Option<(usize, [bool; 2])>,
    /// What the file calls that which spheres are coloured by.
    pub color_by: String,
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
    header: &'f Header<'f>,
    plain: Vec<String>,
}

impl Layout {
    /// Finds the columns. What lacks, what could be two things, and a radius that nobody would read
    /// are errors.
    pub fn find(source: &CloudFile, header: &Header) -> Result<Layout, Stop> {
        let keys = source.keys;
        let columns = &keys.columns.clone().unwrap_or_default();
        let plain = header.names.iter().map(|name| plain_name(name)).collect();
        let finder = Finder { source, columns, header, plain };
        let center = finder.center()?;
        let color = finder.color()?;
        let radius = finder.radius(color)?;
        let color = color.filter(|_| keys.color_by.is_none());
        let gives = [
            radius.is_none() && !finder.denies(RADIUS),
            color.is_none() && keys.color_by.is_none() && !finder.denies(COLOR[0]),
        ];
        let element = finder.element()?.filter(|_| gives.contains(&true));
        let numbered = |columns: &[usize], target: fn(usize) -> Target| {
            let parts = columns.iter().enumerate();
            parts.map(|(part, column)| (*column, target(part))).collect::<Vec<_>>()
        };
        let mut targets = numbered(&center, Target::Center);
        targets.extend(radius.map(|(column, factor)| (column, Target::Radius(factor))));
        targets.extend(numbered(color.as_slice().as_flattened(), Target::Color));
        let mut color_by = String::new();
        if let Some(name) = &keys.color_by {
            let columns = finder.color_by(name, center, radius)?;
            color_by = match columns[..] {
                [column] => header.names[column].clone(),
                _ => name.clone(),
            };
            targets.extend(numbered(&columns, Target::ColorBy));
        }
        Ok(Layout { targets, element: element.map(|column| (column, gives)), color_by })
    }

    fn has(&self, is_it: impl Fn(Target) -> bool) -> bool {
        self.targets.iter().any(|(_, target)| is_it(*target))
    }

    pub fn has_radius(&self) -> bool {
        self.has(|target| matches!(target, Target::Radius(_)))
            || self.element.is_some_and(|(_, [radius, _])| radius)
    }

    /// True where there are columns of colours.
    pub fn has_colors(&self) -> bool {
        self.has(|target| matches!(target, Target::Color(_)))
    }

    /// True where spheres are coloured by the length of a vector.
    pub fn has_vector(&self) -> bool {
        self.has(|target| target == Target::ColorBy(1))
    }
}

impl Finder<'_> {
    /// True where the scene says that no column is that.
    fn denies(&self, part: Part) -> bool {
        part.1(self.columns) == &Some(None)
    }

    /// The one column that is called so by its plain name.
    fn find(&self, name: &str) -> Result<Option<usize>, Stop> {
        let mut places = (0..self.plain.len()).filter(|&column| self.plain[column] == name);
        match (places.next(), places.next()) {
            (_, Some(_)) => {
                let message = format!("{} names the column `{name}` twice", self.header.what);
                let help = "rename one of them, or name another under `columns`";
                Err(self.source.wrong(message, help))
            }
            (place, None) => Ok(place),
        }
    }

    fn is_there(&self, name: &str) -> bool {
        self.plain.iter().any(|plain| plain == name)
    }

    /// The columns that the user calls so: as it stands, by its plain name, by its place, or as a
    /// vector.
    fn called(&self, name: &str) -> Result<Vec<usize>, Stop> {
        let at = |name: &str| self.header.names.iter().position(|other| other == name);
        if let Some(column) =
            at(name).map_or_else(|| self.find(&plain_name(name)), |c| Ok(Some(c)))?
        {
            return Ok(vec![column]);
        }
        if let Ok(place) = name.parse::<usize>()
            && self.header.has_places
            && place < self.plain.len()
        {
            return Ok(vec![place]);
        }
        let parts = (0..).map(|i| self.find(&format!("{}:{i}", plain_name(name))));
        parts.map_while(Result::transpose).collect()
    }

    /// The column that the scene names for a part.
    fn named(&self, (key, name): Part) -> Result<Option<usize>, Stop> {
        let Some(Some(name)) = name(self.columns) else { return Ok(None) };
        match self.called(name)?[..] {
            [column] => Ok(Some(column)),
            [] => Err(self.unknown(self.columns.span(key), name)),
            _ => Err(self.vector(self.columns.span(key), name)),
        }
    }

    fn unknown(&self, span: Range<usize>, name: &str) -> Stop {
        let names = || self.header.names.iter().map(String::as_str);
        let known = names().chain(self.plain.iter().map(String::as_str));
        let hint = match did_you_mean(known, name) {
            Some(near) => format!("did you mean {:?}? ", quoted(near)),
            None => String::new(),
        };
        let all = names().collect::<Vec<_>>().join(", ");
        let found = format!("{} has no column {:?}", self.header.what, quoted(name));
        let help = format!("{hint}its columns are {}", cut(&all, 300).shown());
        self.source.wrong_at(span, found, help).into()
    }

    fn vector(&self, span: Range<usize>, name: &str) -> Stop {
        let name = quoted(name);
        let help = format!("choose one of them, \"{}:0\" for the first", name.shown());
        self.source.wrong_at(span, format!("{name:?} has several numbers"), help).into()
    }

    /// Three columns: those that the scene names, and the others by these names.
    fn three(&self, parts: [Part; 3], names: [&str; 3]) -> Result<[usize; 3], Stop> {
        let mut columns = [0; 3];
        for ((column, part), name) in columns.iter_mut().zip(parts).zip(names) {
            *column = match self.named(part)? {
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

    fn is_any_named(&self, parts: [Part; 3]) -> bool {
        parts.into_iter().any(|(_, name)| name(self.columns).is_some())
    }

    fn center(&self) -> Result<[usize; 3], Stop> {
        let is_there = |names: &&[&str; 3]| names.iter().all(|name| self.is_there(name));
        let names = if self.is_any_named(CENTER) {
            CENTERS[0]
        } else {
            *CENTERS.iter().find(is_there).unwrap_or(&CENTERS[0])
        };
        self.three(CENTER, names)
    }

    fn color(&self) -> Result<Option<[usize; 3]>, Stop> {
        if COLOR.into_iter().any(|part| self.denies(part)) {
            return Ok(None);
        }
        // `r` may be named as the radius.
        let radius = self.named(RADIUS)?;
        let is_free = |name: &&str| self.find(name).is_ok_and(|c| c.is_some() && c != radius);
        let is_there = |names: &&[&str; 3]| names.iter().all(is_free);
        let names = match COLORS.iter().find(is_there) {
            Some(names) if !self.is_any_named(COLOR) => names,
            // One or two of them.
            _ if self.is_any_named(COLOR) || COLORS[0].iter().any(|name| self.is_there(name)) => {
                &COLORS[0]
            }
            _ => return Ok(None),
        };
        self.three(COLOR, *names).map(Some)
    }

    /// The radius or the diameter, and what to multiply it with.
    fn radius(&self, color: Option<[usize; 3]>) -> Result<Option<(usize, f64)>, Stop> {
        if self.denies(RADIUS) {
            return Ok(None);
        }
        match (self.named(RADIUS)?, self.named(DIAMETER)?) {
            (Some(_), Some(_)) => {
                let message = "both a radius and a diameter are named under `columns`";
                return Err(self.source.wrong(message, "name the one that is to be used"));
            }
            (Some(radius), None) => return Ok(Some((radius, 1.0))),
            (None, Some(diameter)) => return Ok(Some((diameter, 0.5))),
            (None, None) => {}
        }
        let is_red = |column: &usize| color.is_some_and(|color| color.contains(column));
        let find_all = |names: &[&str]| -> Result<Vec<usize>, Stop> {
            let found = names.iter().map(|name| self.find(name)).collect::<Result<Vec<_>, _>>()?;
            Ok(found.into_iter().flatten().filter(|column| !is_red(column)).collect())
        };
        match (&find_all(&RADII)?[..], &find_all(&DIAMETERS)?[..]) {
            ([radius], _) => return Ok(Some((*radius, 1.0))),
            ([], [diameter]) => return Ok(Some((*diameter, 0.5))),
            ([], []) => {}
            ([one, other, ..], _) | ([], [one, other, ..]) => {
                let [one, other] = [one, other].map(|column| quoted(&self.header.names[*column]));
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

    fn element(&self) -> Result<Option<usize>, Stop> {
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
        radius: Option<(usize, f64)>,
    ) -> Result<Vec<usize>, Stop> {
        let (found, span) = (self.called(name)?, self.source.span("color_by"));
        if found.len() > 3 {
            return Err(self.vector(span, name));
        }
        if !found.is_empty() {
            return Ok(found);
        }
        // What the scene calls it, where the file has another name for it.
        let part = match name {
            "x" => Some(center[0]),
            "y" => Some(center[1]),
            "z" => Some(center[2]),
            "radius" => radius.filter(|(_, factor)| *factor == 1.0).map(|(column, _)| column),
            _ => None,
        };
        part.map(|column| vec![column]).ok_or_else(|| self.unknown(span, name))
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
