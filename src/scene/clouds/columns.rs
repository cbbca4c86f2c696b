//! Finds the columns of a file that have the centre, the radius, the colour and the element of a sphere.
//!
//! Columns have names: from a header, from the fields of a structured array, from `Properties=`. A field of several numbers is
//! several columns: `velocity:0`, `velocity:1` and so on. What the scene names under `columns` is used; the rest is found by the
//! names that programs give it.

use std::ops::Range;

use glam::DVec3;

use super::CloudFile;
use super::units::{Factor, Unit, name_and_unit};
use crate::error::{Hint, Result, SceneError, Setting, SettingValue};
use crate::plain::Shown;
use crate::scene::places::quoted;
use crate::scene::schema::{ColumnChoice, ColumnKeys, Section};
use crate::scene::{Color, Sphere};
use crate::words::{cut, did_you_mean, list};

/// Content of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    /// A coordinate of the centre, by its axis.
    Center(usize),
    Radius,
    Diameter,
    /// A component of the colour.
    Color(usize),
    Alpha,
    /// A whole colour: `#rrggbb`, a name, or perhaps three bytes packed into a number.
    WholeColor {
        may_be_packed: bool,
    },
    /// A component of the number or vector that a colour map is applied to.
    Scalar(usize),
}

/// Stores the number of a part in a sphere and its colour.
pub(super) fn put(part: Part, number: f64, sphere: &mut Sphere, color: &mut Color) {
    match part {
        Part::Center(axis) => sphere.center[axis] = number,
        Part::Radius => sphere.radius = number,
        Part::Diameter => sphere.radius = 0.5 * number,
        Part::Color(component) | Part::Scalar(component) => color.0[component] = number,
        Part::Alpha | Part::WholeColor { .. } => {}
    }
}

/// A file's columns, and what its format calls them.
pub(super) struct Header<'h> {
    /// Names as they are in the file.
    pub names: &'h [String],
    /// What has these names: `the header`, for one.
    pub what: &'h str,
    /// Description of the format.
    pub help: &'static str,
    /// Whether a column `element` gives the radius and the colour that are missing.
    pub has_elements: bool,
    /// Whether a column may be named by its place, from 0.
    pub has_places: bool,
}

/// The columns that are read, by their places.
pub(super) struct ColumnLayout {
    /// Place and part of each column of numbers, with the factor to the unit of x.
    pub parts: Vec<(usize, Part, Factor)>,
    /// Coordinates that are the same for all spheres.
    pub constants: [Option<f64>; 3],
    /// Element.
    pub element: Option<usize>,
    /// Name in the file of the column that a colour map is applied to.
    pub color_by: String,
    /// Whether the file has a radius for each sphere.
    pub has_radius: bool,
    /// Whether the file has a colour for each sphere.
    pub has_colors: bool,
    /// Whether the element may give the radius, the colour: the scene allows it.
    pub takes_of_element: [bool; 2],
    /// Whether a colour map is applied to the length of a vector.
    pub has_vector: bool,
    /// Names of the columns that are not read.
    pub unused: Vec<String>,
    /// Names of the columns of red, green and blue, if they are known by their names.
    color_names: Vec<String>,
}

/// Names of the three coordinates; the first ones appear in errors.
const CENTERS: [[&str; 3]; 14] = [
    ["x", "y", "z"],
    ["xu", "yu", "zu"],
    ["pos:0", "pos:1", "pos:2"],
    ["position:0", "position:1", "position:2"],
    ["positions:0", "positions:1", "positions:2"],
    ["points:0", "points:1", "points:2"],
    ["coordinates:0", "coordinates:1", "coordinates:2"],
    ["center:0", "center:1", "center:2"],
    ["pos_x", "pos_y", "pos_z"],
    ["position_x", "position_y", "position_z"],
    ["position x", "position y", "position z"],
    ["position.x", "position.y", "position.z"],
    ["center_x", "center_y", "center_z"],
    ["coord_x", "coord_y", "coord_z"],
];
/// Names of single columns, by their key of `columns`.
const ALIASES: [(&str, &[&str]); 4] = [
    ("radius", &["r", "radius", "radii"]),
    ("diameter", &["diameter", "diam"]),
    ("color", &["color", "colour", "colors", "rgb", "rgba"]),
    ("element", &["element", "species", "symbol"]),
];
/// Names of the components of a colour and of alpha.
const COLORS: [[&str; 4]; 11] = [
    ["red", "green", "blue", "alpha"],
    ["r", "g", "b", "a"],
    ["rf", "gf", "bf", "af"],
    ["color:0", "color:1", "color:2", "color:3"],
    ["colour:0", "colour:1", "colour:2", "colour:3"],
    ["colors:0", "colors:1", "colors:2", "colors:3"],
    ["rgb:0", "rgb:1", "rgb:2", "rgb:3"],
    ["rgba:0", "rgba:1", "rgba:2", "rgba:3"],
    ["color_r", "color_g", "color_b", "color_a"],
    ["colour_r", "colour_g", "colour_b", "colour_a"],
    ["color.r", "color.g", "color.b", "color.a"],
];
/// Parts of names that are probably a radius or a colour.
const LIKE_RADIUS: [&str; 7] =
    ["radius", "radii", "diameter", "rvir", "r_vir", "durchmesser", "rayon"];
const LIKE_COLOR: [&str; 4] = ["color", "colour", "rgb", "farbe"];

/// Returns the names of a single column, by its key of `columns`.
fn aliases(key: &str) -> impl Iterator<Item = &'static str> {
    let names = ALIASES.iter().find(|(other, _)| *other == key).map(|(_, names)| *names);
    names.into_iter().flatten().copied()
}

/// Whether these names contain three coordinates.
pub(super) fn have_center(names: &[String]) -> bool {
    let plain: Vec<String> = names.iter().map(|name| name_and_unit(name).0).collect();
    let is_there = |name: &&str| plain.iter().any(|plain| plain == name);
    CENTERS.iter().any(|names| names.iter().all(&is_there))
}

/// A coordinate: the place of its column, or the number of all spheres.
#[derive(Clone, Copy, Debug)]
enum Coordinate {
    Column(usize),
    Constant(f64),
}

/// The columns of one file, while their parts are found.
struct Finder<'f, 'r> {
    source: &'f CloudFile<'f, 'r>,
    columns: &'f ColumnKeys,
    header: &'f Header<'f>,
    /// Names in lower case, without units.
    plain: Vec<String>,
    units: Vec<Option<&'f str>>,
}

impl ColumnLayout {
    /// Finds the columns. Missing and ambiguous ones are errors, and so is a radius or a colour that would not be read. Notes
    /// are added to `notes`.
    pub fn find<'f>(
        source: &'f CloudFile<'f, '_>,
        header: &'f Header<'f>,
        notes: &mut Vec<String>,
    ) -> Result<ColumnLayout> {
        let keys = source.keys;
        let none = ColumnKeys::default();
        let columns = keys.columns.as_ref().unwrap_or(&none);
        let (plain, units) = header.names.iter().map(|name| name_and_unit(name)).unzip();
        let finder = Finder { source, columns, header, plain, units };
        let center = finder.center()?;
        let color = finder.color()?;
        let radius = finder.radius(&color)?;
        let color = if keys.color_by.is_some() { Vec::new() } else { color };
        let element = finder.element()?;
        let (mut scalars, mut color_by) = (Vec::new(), String::new());
        if let Some(name) = &keys.color_by {
            scalars = finder.color_by(name, center, radius)?;
            color_by = match scalars[..] {
                [column] => header.names[column].clone(),
                _ => name.clone(),
            };
        }
        let lengths = finder.lengths(center, radius, notes)?;
        let scalars = scalars.iter().zip(0..).map(|(&column, i)| (column, Part::Scalar(i)));
        let others = color.iter().copied().chain(scalars);
        let parts: Vec<_> = lengths
            .into_iter()
            .chain(others.map(|(column, part)| (column, part, Factor::ONE)))
            .collect();
        let denies_color = finder.denies_color();
        let is_used = |place: usize| {
            parts.iter().any(|(column, ..)| *column == place) || element == Some(place)
        };
        // Without a name: row names, and what follows a separator at the end of each row.
        let is_named = |place: &usize| !header.names[*place].is_empty();
        let unused = (0..header.names.len()).filter(|&place| !is_used(place)).filter(is_named);
        Ok(ColumnLayout {
            constants: center.map(|coordinate| match coordinate {
                Coordinate::Constant(number) => Some(number),
                Coordinate::Column(_) => None,
            }),
            element,
            color_by,
            has_radius: radius.is_some(),
            has_colors: !color.is_empty(),
            takes_of_element: [columns.radius != Some(ColumnChoice::Absent), !denies_color],
            color_names: color
                .iter()
                .take(3)
                .map(|(place, _)| header.names[*place].clone())
                .collect(),
            has_vector: parts.iter().any(|(_, part, _)| *part == Part::Scalar(1)),
            unused: unused.map(|place| header.names[place].clone()).collect(),
            parts,
        })
    }
}

impl ColumnLayout {
    /// Whether each colour is one cell, whose scale is known.
    pub fn has_whole_colors(&self) -> bool {
        self.parts.iter().any(|(_, part, _)| matches!(part, Part::WholeColor { .. }))
    }

    /// Returns the advice to read the colours without their alpha.
    pub fn hint_without_alpha(&self) -> Hint {
        let keys = ["red", "green", "blue"];
        let names = self.color_names.iter().map(|name| SettingValue::Text(name.clone()));
        let columns = Setting {
            key: "columns",
            value: Some(SettingValue::Table(keys.into_iter().zip(names).collect())),
        };
        Hint::new("to ignore alpha, name the columns of the colour: {}", [columns])
    }
}

impl<'f> Finder<'f, '_> {
    fn wrong(&self, message: impl Into<String>, hint: impl Into<Hint>) -> Box<SceneError> {
        self.source.wrong(message, hint)
    }

    fn denies_color(&self) -> bool {
        let ColumnKeys { red, green, blue, color, .. } = self.columns;
        [red, green, blue, color].iter().any(|choice| **choice == Some(ColumnChoice::Absent))
    }

    /// Returns the column with this plain name.
    fn find(&self, name: &str) -> Result<Option<usize>> {
        let mut places = (0..self.plain.len()).filter(|&column| self.plain[column] == name);
        let place = places.next();
        if let (Some(one), Some(other)) = (place, places.next()) {
            // `r` next to `R`.
            let is_exact = |column: &usize| self.header.names[*column] == name;
            let mut exact = (0..self.plain.len()).filter(is_exact);
            if let (Some(column), None) = (exact.next(), exact.next()) {
                return Ok(Some(column));
            }
            let message = format!("{} has two columns `{name}`", self.header.what);
            let names = [one, other].map(|column| &self.header.names[column]);
            let hint = match key_of(name).filter(|_| names[0] != names[1]) {
                Some(key) => {
                    let setting = Setting::column_named(key, names[0].as_str());
                    Hint::new("choose one with {}", [setting])
                }
                None => Hint::from("rename one of them"),
            };
            return Err(self.wrong(message, hint).into());
        }
        Ok(place)
    }

    fn is_there(&self, name: &str) -> bool {
        self.plain.iter().any(|plain| plain == name)
    }

    /// Returns the columns with this name: the exact name, the plain name, the place, or a vector.
    fn called(&self, name: &str) -> Result<Vec<usize>> {
        let (plain, _) = name_and_unit(name);
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

    /// Returns the column that the scene names for this key of `columns`.
    fn chosen(&self, key: &'static str, choice: &Option<ColumnChoice>) -> Result<Option<usize>> {
        let Some(choice) = choice else { return Ok(None) };
        let span = self.columns.span(key);
        let name = match choice {
            ColumnChoice::Absent => return Ok(None),
            ColumnChoice::Named(name) => name,
            ColumnChoice::Constant(number) => {
                let hint = match key {
                    "radius" => Hint::new(
                        "give all spheres one radius with {}",
                        [Setting::number("radius", *number)],
                    ),
                    _ => Hint::from("name a column; only x, y and z can be a number"),
                };
                let message = format!("`{key}` cannot be the number {number:?}");
                return Err(self.source.wrong_at(span, message, hint).into());
            }
        };
        match self.called(name)?[..] {
            [column] => Ok(Some(column)),
            [] => {
                let mut error = self.unknown(span, name);
                if let Ok(number) = name.parse::<f64>()
                    && ["x", "y", "z"].contains(&key)
                {
                    let setting = Setting::column(key, SettingValue::Number(format!("{number:?}")));
                    error.hint =
                        Hint::new("to give all spheres this coordinate, write {}", [setting]);
                }
                Err(error.into())
            }
            _ => Err(self.vector(span, name).into()),
        }
    }

    fn unknown(&self, span: Range<usize>, name: &str) -> Box<SceneError> {
        let known = self.header.names.iter().chain(&self.plain).map(String::as_str);
        let hint = did_you_mean(known, name)
            .map_or(String::new(), |near| format!("did you mean {:?}? ", quoted(near)));
        let all = self.header.names.join(", ");
        let message = format!("{} has no column {:?}", self.header.what, quoted(name));
        let help = format!("{hint}its columns are {}", cut(&all, 300).shown());
        self.source.wrong_at(span, message, help)
    }

    fn vector(&self, span: Range<usize>, name: &str) -> Box<SceneError> {
        let shown = quoted(name);
        let help = format!("choose one of them, \"{}:0\" for the first", shown.shown());
        self.source.wrong_at(span, format!("{shown:?} has several numbers"), help)
    }

    /// Returns the column of this name, which must be there. `key` is its key of `columns`.
    fn required(&self, key: &'static str, name: &str) -> Result<usize> {
        if let Some(column) = self.find(name)? {
            return Ok(column);
        }
        let names = self.header.names;
        let found = names.join(", ");
        let message =
            format!("{} has no column `{name}`, only {:?}", self.header.what, quoted(&found));
        let has_others = || ["x", "y"].iter().all(|name| self.is_there(name));
        let hint = if key == "z" && has_others() {
            let zero = Setting::column("z", SettingValue::Number("0.0".into()));
            Hint::new("for data in a plane, give all spheres the same z with {}", [zero])
        } else {
            match &self.example_of_center()[..] {
                [] => self.header.help.into(),
                examples => {
                    let noun = if examples.len() == 1 { "column" } else { "columns" };
                    let value = Some(SettingValue::Table(examples.to_vec()));
                    let setting = Setting { key: "columns", value };
                    Hint::new("{}", [setting]).after(format!("name the {noun}, for example "))
                }
            }
        };
        Err(self.wrong(message, hint).into())
    }

    /// Returns names for all coordinates that are missing, similar ones first; none if there are too few.
    fn example_of_center(&self) -> Vec<(&'static str, SettingValue)> {
        let ColumnKeys { x, y, z, .. } = self.columns;
        let choices = [("x", x), ("y", y), ("z", z)];
        let is_chosen = |name: &str| {
            choices.iter().any(
                |(_, choice)| matches!(choice, Some(ColumnChoice::Named(chosen)) if chosen == name),
            )
        };
        let is_center = |name: &str| ["x", "y", "z"].contains(&name) || is_chosen(name);
        let names = self.header.names.iter().zip(&self.plain);
        let free =
            names.filter(|(name, plain)| !name.is_empty() && !is_chosen(name) && !is_center(plain));
        let mut free: Vec<(&String, &String)> = free.collect();
        let missing =
            choices.into_iter().filter(|(key, choice)| choice.is_none() && !self.is_there(key));
        let missing: Vec<&'static str> = missing.map(|(key, _)| key).collect();
        let mut found: Vec<Option<String>> = vec![None; missing.len()];
        let is_similar: [fn(&str, &str) -> bool; 3] = [
            |name, axis| name.starts_with(axis) || name.ends_with(axis),
            |name, axis| name.contains(axis),
            |_, _| true,
        ];
        for is_similar in is_similar {
            for (axis, found) in missing.iter().zip(&mut found).filter(|(_, found)| found.is_none())
            {
                let place = free.iter().position(|(_, plain)| is_similar(plain, axis));
                *found = place.map(|place| free.remove(place).0.clone());
            }
        }
        let all: Option<Vec<String>> = found.into_iter().collect();
        missing
            .into_iter()
            .zip(all.unwrap_or_default().into_iter().map(SettingValue::Text))
            .collect()
    }

    fn center(&self) -> Result<[Coordinate; 3]> {
        let ColumnKeys { x, y, z, .. } = self.columns;
        let choices = [("x", x), ("y", y), ("z", z)];
        // A name that is left over belongs to the same set as the others.
        let fits = |names: &&[&str; 3]| {
            let mut pairs = names.iter().zip(&choices);
            pairs.all(|(name, (_, choice))| choice.is_some() || self.is_there(name))
        };
        let names = CENTERS.iter().find(fits).unwrap_or(&CENTERS[0]);
        let mut center = [Coordinate::Constant(0.0); 3];
        for (axis, (key, choice)) in choices.into_iter().enumerate() {
            center[axis] = match choice {
                Some(ColumnChoice::Constant(number)) => Coordinate::Constant(*number),
                choice => Coordinate::Column(match self.chosen(key, choice)? {
                    Some(column) => column,
                    None => self.required(key, names[axis])?,
                }),
            };
        }
        for (axis, other) in [(0, 1), (0, 2), (1, 2)] {
            if let (Coordinate::Column(one), Coordinate::Column(two)) =
                (center[axis], center[other])
                && one == two
            {
                let keys = ["x", "y", "z"];
                let message = format!("`{}` and `{}` are the same column", keys[axis], keys[other]);
                let zero = Setting::column(keys[other], SettingValue::Number("0.0".into()));
                let hint = Hint::new(
                    "to give all spheres one coordinate, write {}, with a decimal point",
                    [zero],
                );
                return Err(self
                    .source
                    .wrong_at(self.columns.span(keys[other]), message, hint)
                    .into());
            }
        }
        Ok(center)
    }

    /// Returns the columns of the colour: components, or one whole colour.
    fn color(&self) -> Result<Vec<(usize, Part)>> {
        if self.denies_color() {
            return Ok(Vec::new());
        }
        let ColumnKeys { red, green, blue, color, radius, .. } = self.columns;
        if let Some(column) = self.chosen("color", color)? {
            return Ok(vec![(column, Part::WholeColor { may_be_packed: true })]);
        }
        // `r` may be named as the radius.
        let radius = self.chosen("radius", radius)?;
        let choices = [("red", red), ("green", green), ("blue", blue)];
        let is_chosen = choices.iter().any(|(_, choice)| choice.is_some());
        let is_free = |name: &&str| self.find(name).is_ok_and(|c| c.is_some() && c != radius);
        let is_there = |names: &&[&str; 4]| !is_chosen && names[..3].iter().all(is_free);
        // `R`, `G`, `B` next to the radius `r`.
        let capital = |name: &str| self.header.names.iter().position(|other| other == name);
        if let [Some(red), Some(green), Some(blue)] = ["R", "G", "B"].map(capital)
            && !is_chosen
            && capital("r").is_some()
        {
            let columns = [red, green, blue].into_iter().zip(0..3);
            let mut parts: Vec<_> =
                columns.map(|(column, component)| (column, Part::Color(component))).collect();
            parts.extend(capital("A").map(|alpha| (alpha, Part::Alpha)));
            return Ok(parts);
        }
        // If there are one or two of them, the others are missing; but `r` alone is the radius.
        let is_begun = |names: &&[&str; 4]| {
            names[0] != "r" && names[..3].iter().any(|name| self.is_there(name))
        };
        let names = COLORS.iter().find(is_there).or_else(|| match is_chosen {
            true => Some(&COLORS[0]),
            false => COLORS.iter().find(is_begun),
        });
        if let Some(names) = names {
            let mut parts = Vec::new();
            for (component, (key, choice)) in choices.into_iter().enumerate() {
                let column = match self.chosen(key, choice)? {
                    Some(column) => column,
                    None => self.required_color(key, names[component])?,
                };
                parts.push((column, Part::Color(component)));
            }
            if !is_chosen && let Some(alpha) = self.find(names[3])? {
                parts.push((alpha, Part::Alpha));
            }
            return Ok(parts);
        }
        for name in aliases("color") {
            if let Some(column) = self.find(name)? {
                let may_be_packed = name.starts_with("rgb");
                return Ok(vec![(column, Part::WholeColor { may_be_packed })]);
            }
        }
        let is_used_otherwise =
            self.source.keys.color.is_some() || self.source.keys.color_by.is_some();
        match self.like(&LIKE_COLOR) {
            Some(name) if !is_used_otherwise => Err(self.unread(name, "color", "colour").into()),
            _ => Ok(Vec::new()),
        }
    }

    fn required_color(&self, key: &'static str, name: &str) -> Result<usize> {
        if let Some(column) = self.find(name)? {
            return Ok(column);
        }
        let message =
            format!("{} has a part of a colour, but no column `{name}`", self.header.what);
        let settings = [Setting::column_named(key, "NAME"), Setting::no_column("color")];
        let hint = Hint::new("name it with {}, or ignore the colours with {}", settings);
        Err(self.wrong(message, hint).into())
    }

    /// Returns the first name that contains one of these words.
    fn like(&self, words: &[&str]) -> Option<&'f String> {
        self.header
            .names
            .iter()
            .find(|name| words.iter().any(|word| name.to_lowercase().contains(word)))
    }

    /// The error of a column that is probably the radius or the colour, but would not be read.
    fn unread(&self, name: &str, key: &'static str, what: &str) -> Box<SceneError> {
        let no_column = if key == "color" { "color" } else { "radius" };
        let settings = [Setting::column_named(key, name), Setting::no_column(no_column)];
        let message = format!("the column may be the {what}, but its name is not a known one");
        let hint = Hint::new("to use it, give {}; to ignore it, {}", settings);
        self.wrong(message, hint).in_column(name)
    }

    /// Returns the column of the radius or the diameter.
    fn radius(&self, color: &[(usize, Part)]) -> Result<Option<(usize, Part)>> {
        let ColumnKeys { radius, diameter, .. } = self.columns;
        if *radius == Some(ColumnChoice::Absent) {
            return Ok(None);
        }
        match [self.chosen("radius", radius)?, self.chosen("diameter", diameter)?] {
            [Some(_), Some(_)] => {
                let message = "both a radius and a diameter are named under `columns`";
                return Err(self.wrong(message, "name only the one to be used").into());
            }
            [Some(column), None] => return Ok(Some((column, Part::Radius))),
            [None, Some(column)] => return Ok(Some((column, Part::Diameter))),
            [None, None] => {}
        }
        for (part, key) in [(Part::Radius, "radius"), (Part::Diameter, "diameter")] {
            let found = aliases(key).filter_map(|name| self.find(name).transpose());
            let mut found = found.collect::<Result<Vec<usize>>>()?;
            // `r` may be the red.
            found.retain(|column| !color.iter().any(|(other, _)| other == column));
            if let [column] = found[..] {
                return Ok(Some((column, part)));
            }
            if let [one, other, ..] = found[..] {
                let [one, other] = [one, other].map(|column| &self.header.names[column]);
                let message =
                    format!("both {:?} and {:?} may be the {key}", quoted(one), quoted(other));
                let setting = Setting::column_named(key, one.as_str());
                let hint = Hint::new("choose one, for example with {}", [setting]);
                return Err(self.wrong(message, hint).into());
            }
        }
        // A radius of all spheres leaves no doubt.
        let Some(name) = self.like(&LIKE_RADIUS).filter(|_| self.source.keys.radius.is_none())
        else {
            return Ok(None);
        };
        let is_diameter =
            ["diam", "durchmesser"].iter().any(|word| name.to_lowercase().contains(word));
        let key = if is_diameter { "diameter" } else { "radius" };
        Err(self.unread(name, key, key).into())
    }

    /// Returns the columns of lengths, in the unit of x.
    fn lengths(
        &self,
        center: [Coordinate; 3],
        radius: Option<(usize, Part)>,
        notes: &mut Vec<String>,
    ) -> Result<Vec<(usize, Part, Factor)>> {
        let coordinate = |(axis, coordinate): (usize, &Coordinate)| match coordinate {
            Coordinate::Column(column) => Some((*column, Part::Center(axis))),
            Coordinate::Constant(_) => None,
        };
        let columns = center.iter().enumerate().filter_map(coordinate).chain(radius);
        let columns: Vec<(usize, Part)> = columns.collect();
        let Some(&(first, _)) = columns.first() else { return Ok(Vec::new()) };
        let (mut lengths, mut converted) = (Vec::new(), Vec::new());
        for (column, part) in columns {
            let factor = self.factor(column, first)?;
            if factor != Factor::ONE {
                converted.push(format!("`{}`", self.header.names[column].shown()));
            }
            lengths.push((column, part, factor));
        }
        if !converted.is_empty() {
            let unit = self.units[first].unwrap_or_default().shown();
            let verb = if converted.len() == 1 { "is" } else { "are" };
            notes.push(format!(
                "{} {verb} converted to {unit}, the unit of `{}`",
                list(&converted),
                self.header.names[first].shown()
            ));
        }
        Ok(lengths)
    }

    /// Returns the factor from the unit of a column to the unit of another one, which a column without a unit shares.
    fn factor(&self, column: usize, to: usize) -> Result<Factor> {
        let Some(from_unit) = self.units[column] else { return Ok(Factor::ONE) };
        let to_unit = self.units[to];
        if to_unit == Some(from_unit) {
            return Ok(Factor::ONE);
        }
        let known = |unit: &str| Unit::parse(unit);
        let factor = to_unit.and_then(|to| known(from_unit)?.factor_to(known(to)?));
        factor.map_or_else(
            || {
                let [name, other] = [column, to].map(|column| self.header.names[column].shown());
                let (message, hint) = match to_unit {
                    Some(_) => (
                        format!("its unit cannot be converted to the unit of `{other}`"),
                        "convert one of them in the file, so that both have the same unit".to_owned(),
                    ),
                    None => (
                        format!("it has a unit, but `{other}` has none"),
                        format!("write the unit of `{other}` into the file, for example `{other} [{from_unit}]`"),
                    ),
                };
                let error = self.wrong(message, hint).in_column(name);
                Err(error.with_value(from_unit).into())
            },
            Ok,
        )
    }

    fn element(&self) -> Result<Option<usize>> {
        let choice = &self.columns.element;
        match self.chosen("element", choice)? {
            Some(column) => Ok(Some(column)),
            None if choice.is_some() || !self.header.has_elements => Ok(None),
            None => aliases("element").find_map(|name| self.find(name).transpose()).transpose(),
        }
    }

    fn color_by(
        &self,
        name: &str,
        center: [Coordinate; 3],
        radius: Option<(usize, Part)>,
    ) -> Result<Vec<usize>> {
        let (found, span) = (self.called(name)?, self.source.keys.span("color_by"));
        let axis = ["x", "y", "z"].iter().position(|axis| *axis == name);
        match (found.len(), axis.map(|axis| center[axis]), radius) {
            (1..=3, ..) => Ok(found),
            (4.., ..) => Err(self.vector(span, name).into()),
            // The scene's name, where the file has another one.
            (0, Some(Coordinate::Column(column)), _) => Ok(vec![column]),
            (0, _, Some((column, Part::Radius))) if name == "radius" => Ok(vec![column]),
            _ => Err(self.unknown(span, name).into()),
        }
    }
}

/// Returns the key of `columns` for a name in a file; `None` if no key selects columns of this name.
fn key_of(name: &str) -> Option<&'static str> {
    let keys = ColumnKeys::INFO.keys.iter().map(|key| key.name);
    let single = ALIASES.iter().find(|(_, names)| names.contains(&name)).map(|(key, _)| *key);
    let coordinate = CENTERS.iter().find_map(|names| names.iter().position(|other| *other == name));
    let color =
        COLORS[1..].iter().find_map(|names| names[..3].iter().position(|other| *other == name));
    keys.into_iter()
        .find(|key| *key == name)
        .or(single)
        .or(coordinate.map(|axis| ["x", "y", "z"][axis]))
        .or(color.map(|component| ["red", "green", "blue"][component]))
}

/// Returns the constant coordinates as a centre.
pub(super) fn constant_center(constants: [Option<f64>; 3]) -> DVec3 {
    DVec3::from_array(constants.map(Option::unwrap_or_default))
}
