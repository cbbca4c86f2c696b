//! Which column of a file is what.
//!
//! A file's columns have names: those of a csv header, of the fields of a structured array, of
//! `Properties=`. A field of several numbers is as many columns, `velocity:0`, `velocity:1` and so on.
//! What a scene names under `columns` is taken; the rest is found by the names that people give it.

use super::{Given, Reading};
use crate::plain::Shown;
use crate::scene::places::{Fault, Stop, quoted};
use crate::words::{cut, did_you_mean};

/// What a column may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    X,
    Y,
    Z,
    Radius,
    Diameter,
    Red,
    Green,
    Blue,
    Element,
}

impl Part {
    pub const ALL: [Part; 9] = [
        Part::X,
        Part::Y,
        Part::Z,
        Part::Radius,
        Part::Diameter,
        Part::Red,
        Part::Green,
        Part::Blue,
        Part::Element,
    ];
}

/// The names under `columns` in a scene; `None` in place of a name is its `false`: no column is that.
#[derive(Debug, Default)]
pub(crate) struct ColumnNames([Option<Given<Option<String>>>; Part::ALL.len()]);

impl ColumnNames {
    pub fn set(&mut self, part: Part, name: Option<Given<Option<String>>>) {
        self.0[part as usize] = name;
    }

    /// The name and its place.
    fn named(&self, part: Part) -> Option<&Given<Option<String>>> {
        self.0[part as usize].as_ref()
    }

    /// True where the scene says that no column is that.
    fn denies(&self, part: Part) -> bool {
        self.named(part).is_some_and(|name| name.value.is_none())
    }

    pub fn is_empty(&self) -> bool {
        self.0.iter().all(Option::is_none)
    }
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
#[derive(Debug, PartialEq)]
pub(super) struct Layout {
    pub center: [usize; 3],
    pub radius: Option<usize>,
    /// What the radius is times the number in its column: a diameter's half.
    pub radius_factor: f64,
    pub color: Option<[usize; 3]>,
    /// The element, where radius or colour are its.
    pub element: Option<usize>,
    /// True where an element gives the radius, the colour.
    pub element_gives: [bool; 2],
    /// What the colours are made from, the length of a vector where it has several parts.
    pub color_by: Vec<usize>,
    /// What the file calls that.
    pub color_by_name: String,
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
    cloud: &'f Reading<'f>,
    header: &'f Header<'f>,
    plain: Vec<String>,
}

impl Layout {
    /// Finds the columns. What lacks, what could be two things, and a radius that nobody would read
    /// are errors.
    pub fn find(cloud: &Reading, header: &Header) -> Result<Layout, Stop> {
        let plain = header.names.iter().map(|name| plain_name(name)).collect();
        let finder = Finder { cloud, header, plain };
        let columns = &cloud.source.table.columns;
        let center = finder.center()?;
        let color = finder.color()?;
        let (radius, radius_factor) = finder.radius(color)?;
        let is_colored_by = cloud.source.table.color_by.is_some();
        let color = color.filter(|_| !is_colored_by);
        let element = finder.element()?;
        let gives = [
            radius.is_none() && !columns.denies(Part::Radius),
            color.is_none() && !is_colored_by && !columns.denies(Part::Red),
        ];
        let element = element.filter(|_| gives.contains(&true));
        let element_gives = gives.map(|gives| gives && element.is_some());
        let mut layout = Layout {
            center,
            radius,
            radius_factor,
            color,
            element,
            element_gives,
            color_by: Vec::new(),
            color_by_name: String::new(),
        };
        if let Some(name) = &cloud.source.table.color_by {
            layout.color_by = finder.color_by(name, &layout)?;
            layout.color_by_name = match layout.color_by[..] {
                [column] => header.names[column].clone(),
                _ => name.value.clone(),
            };
        }
        Ok(layout)
    }

    pub fn has_radius(&self) -> bool {
        self.radius.is_some() || self.element_gives[0]
    }

    pub fn has_color(&self) -> bool {
        self.color.is_some() || self.element_gives[1]
    }
}

impl Finder<'_> {
    /// The one column that is called so by its plain name.
    fn find(&self, name: &str) -> Result<Option<usize>, Stop> {
        let mut places = (0..self.plain.len()).filter(|&column| self.plain[column] == name);
        match (places.next(), places.next()) {
            (_, Some(_)) => {
                let message = format!("{} names the column `{name}` twice", self.header.what);
                let help = "rename one of them, or name another under `columns`";
                Err(self.cloud.wrong(message, help))
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
    fn named(&self, part: Part) -> Result<Option<usize>, Stop> {
        let Some(given) = self.cloud.source.table.columns.named(part) else { return Ok(None) };
        let Some(name) = &given.value else { return Ok(None) };
        match self.called(name)?[..] {
            [column] => Ok(Some(column)),
            [] => Err(self.unknown(given, name)),
            _ => Err(self.vector(given, name)),
        }
    }

    fn at<T>(&self, given: &Given<T>, message: String, help: String) -> Stop {
        let message = format!("{}: {message}", self.cloud.source.path.shown());
        Fault::new(given.span.clone(), message, help).into()
    }

    fn unknown<T>(&self, given: &Given<T>, name: &str) -> Stop {
        let names = || self.header.names.iter().map(String::as_str);
        let known = names().chain(self.plain.iter().map(String::as_str));
        let hint = match did_you_mean(known, name) {
            Some(near) => format!("did you mean {:?}? ", quoted(near)),
            None => String::new(),
        };
        let all = names().collect::<Vec<_>>().join(", ");
        self.at(
            given,
            format!("{} has no column {:?}", self.header.what, quoted(name)),
            format!("{hint}its columns are {}", cut(&all, 300).shown()),
        )
    }

    fn vector<T>(&self, given: &Given<T>, name: &str) -> Stop {
        let name = quoted(name);
        self.at(
            given,
            format!("{name:?} has several numbers"),
            format!("choose one of them, \"{}:0\" for the first", name.shown()),
        )
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
                    self.cloud.wrong(message, self.header.help)
                })?,
            };
        }
        Ok(columns)
    }

    fn is_any_named(&self, parts: [Part; 3]) -> bool {
        let columns = &self.cloud.source.table.columns;
        parts.into_iter().any(|part| columns.named(part).is_some())
    }

    fn center(&self) -> Result<[usize; 3], Stop> {
        const PARTS: [Part; 3] = [Part::X, Part::Y, Part::Z];
        let is_there = |names: &&[&str; 3]| names.iter().all(|name| self.is_there(name));
        let names = match self.is_any_named(PARTS) {
            true => CENTERS[0],
            false => *CENTERS.iter().find(is_there).unwrap_or(&CENTERS[0]),
        };
        self.three(PARTS, names)
    }

    fn color(&self) -> Result<Option<[usize; 3]>, Stop> {
        const PARTS: [Part; 3] = [Part::Red, Part::Green, Part::Blue];
        let columns = &self.cloud.source.table.columns;
        if PARTS.into_iter().any(|part| columns.denies(part)) {
            return Ok(None);
        }
        if self.is_any_named(PARTS) {
            return self.three(PARTS, COLORS[0]).map(Some);
        }
        // `r` may be named as the radius.
        let radius = self.named(Part::Radius)?;
        let is_free = |name: &&str| self.find(name).is_ok_and(|c| c.is_some() && c != radius);
        let is_there = |names: &&[&str; 3]| names.iter().all(is_free);
        match COLORS.iter().find(is_there) {
            Some(names) => self.three(PARTS, *names).map(Some),
            // One or two of them.
            None if COLORS[0].iter().any(|name| self.is_there(name)) => {
                self.three(PARTS, COLORS[0]).map(Some)
            }
            None => Ok(None),
        }
    }

    /// The radius or the diameter, and what to multiply it with.
    fn radius(&self, color: Option<[usize; 3]>) -> Result<(Option<usize>, f64), Stop> {
        let columns = &self.cloud.source.table.columns;
        if columns.denies(Part::Radius) {
            return Ok((None, 1.0));
        }
        match (self.named(Part::Radius)?, self.named(Part::Diameter)?) {
            (Some(_), Some(_)) => {
                let message = "both a radius and a diameter are named under `columns`";
                return Err(self.cloud.wrong(message, "name the one that is to be used"));
            }
            (Some(radius), None) => return Ok((Some(radius), 1.0)),
            (None, Some(diameter)) => return Ok((Some(diameter), 0.5)),
            (None, None) => {}
        }
        let is_red = |column: &usize| color.is_some_and(|color| color.contains(column));
        let find_all = |names: &[&str]| -> Result<Vec<usize>, Stop> {
            let found = names.iter().map(|name| self.find(name)).collect::<Result<Vec<_>, _>>()?;
            Ok(found.into_iter().flatten().filter(|column| !is_red(column)).collect())
        };
        match (&find_all(&RADII)?[..], &find_all(&DIAMETERS)?[..]) {
            ([radius], _) => return Ok((Some(*radius), 1.0)),
            ([], [diameter]) => return Ok((Some(*diameter), 0.5)),
            ([], []) => {}
            ([one, other, ..], _) | ([], [one, other, ..]) => {
                let [one, other] = [one, other].map(|column| quoted(&self.header.names[*column]));
                return Err(self.cloud.wrong(
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
        let Some(unused) = self.header.names.iter().find(is_like) else { return Ok((None, 1.0)) };
        let unused = quoted(unused);
        let key = if unused.to_lowercase().contains("diam") { "diameter" } else { "radius" };
        Err(self.cloud.wrong(
            format!("the column {unused:?} is not used: is it the {key}?"),
            format!(
                "if so, `columns = {{ {key} = \"{}\" }}`; if not, \
                 `columns = {{ radius = false }}`, and `radius` for all spheres",
                unused.shown()
            ),
        ))
    }

    fn element(&self) -> Result<Option<usize>, Stop> {
        let columns = &self.cloud.source.table.columns;
        match self.named(Part::Element)? {
            Some(column) => Ok(Some(column)),
            None if columns.denies(Part::Element) || !self.header.has_elements => Ok(None),
            None => ELEMENTS.iter().find_map(|name| self.find(name).transpose()).transpose(),
        }
    }

    fn color_by(&self, name: &Given<String>, layout: &Layout) -> Result<Vec<usize>, Stop> {
        let found = self.called(&name.value)?;
        if found.len() > 3 {
            return Err(self.vector(name, &name.value));
        }
        if !found.is_empty() {
            return Ok(found);
        }
        // What the scene calls it, where the file has another name for it.
        let part = match &name.value[..] {
            "x" => Some(layout.center[0]),
            "y" => Some(layout.center[1]),
            "z" => Some(layout.center[2]),
            "radius" if layout.radius_factor == 1.0 => layout.radius,
            _ => None,
        };
        part.map(|column| vec![column]).ok_or_else(|| self.unknown(name, &name.value))
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
