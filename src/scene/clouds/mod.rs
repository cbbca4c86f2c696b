//! `[[spheres]]`: files of many spheres, read as a stream.
//!
//! | format | a row | radius and colour |
//! | --- | --- | --- |
//! | NumPy (`.npy`) | x, y, z; x, y, z, r; or x, y, z, r, red, green, blue | sRGB: 0 to 1, or bytes |
//! | NumPy, structured | the fields of the array, by name | as above |
//! | tables (`.csv`, `.tsv`, `.txt`, `.dat`) | the columns of the header, between `,` `;` tabs or spaces | as above, or `#rrggbb` |
//! | XYZ (`.xyz`, `.extxyz`) | element, x, y, z in ångström, or the columns of `Properties=` | as above, else by element |
//! | LAMMPS dumps | the columns of `ITEM: ATOMS` | as above, else by element |
//!
//! The format is recognized by the file's content. `columns` names the columns whose names are not known ones. `radius` and
//! `color` are for all spheres, if the file has none. `color_by` applies a colour map to a column, whatever colours the file has.
//!
//! While a file is read, colours are the numbers of the file: on either scale, or those that a colour map is applied to. Their
//! meaning is known at the end; then they become colours in place.

mod columns;
mod csv;
mod elements;
mod lammps;
mod npy;
mod numbers;
mod text;
mod units;
mod xyz;

use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::decode::Input;
use super::open::InputReader;
use super::places::quoted;
use super::schema::{CloudKeys, ColorSpace, MissingRows, Section};
use super::sniff::{Content, DataFormat, recognize};
use super::spheres::{Problem, problem_of};
use super::table::Checked;
use super::{
    Cloud, Color, Coloring, MAX_OBJECTS, Scene, Sphere, hex, linear_from_srgb, linear_of_bytes,
};
use crate::error::{Error, ErrorSubject, Hint, Message, Result, SceneError, Setting};
use crate::plain::Shown;
use crate::support::memory::Available;
use crate::support::parallel;
use crate::words::{count, cut};
use columns::ColumnLayout;
pub(super) use numbers::n_numbers;
use text::FileColor;

/// Adds the spheres of all clouds to `scene`, in the order of the file. Paths are relative to `folder`. Returns the
/// keys that were taken from [`InputReader::usual`].
pub(super) fn read_clouds(
    tables: &[CloudKeys],
    folder: &Path,
    reader: InputReader,
    scene: &mut Scene,
) -> Result<CloudKeys> {
    let path_of = |keys: &CloudKeys| keys.file().map(|file| folder.join(file));
    let paths = tables.iter().map(path_of).collect::<Checked<Vec<_>>>()?;
    let n_bytes = |path: &PathBuf| std::fs::metadata(path).map_or(0, |file| file.len());
    reader.control.expect_bytes(paths.iter().map(n_bytes).sum());
    let mut chosen = CloudKeys::default();
    for (keys, path) in tables.iter().zip(paths) {
        let source = CloudFile { keys, path, reader, before: scene };
        let mut cloud = Reading {
            source: &source,
            spheres: Vec::new(),
            color: None,
            colors: Vec::new(),
            file_colors: None,
            of_element: [false; 2],
            n_missing: 0,
            notes: Vec::new(),
            chosen,
        };
        let layout = cloud.read()?;
        cloud.note_missing();
        let coloring = cloud.finish_colors(&layout)?;
        let Reading { spheres, color, colors, notes, .. } = cloud;
        chosen = cloud.chosen;
        let path = source.path;
        // At most `MAX_OBJECTS`, which is less than 2³².
        let first_id = scene.spheres.len() as u32 + 1;
        let unused_columns = layout.unused;
        scene.clouds.push(Cloud {
            path,
            n_spheres: spheres.len(),
            first_id,
            coloring,
            unused_columns,
        });
        scene.spheres.append(spheres, color.unwrap_or_default(), colors);
        scene.notes.extend(notes);
    }
    Ok(chosen)
}

/// Longest message about a file, characters: a cell or a word may be a whole file.
const MAX_MESSAGE: usize = 400;

/// A cloud's file.
struct CloudFile<'a, 'r> {
    keys: &'a CloudKeys,
    path: PathBuf,
    reader: InputReader<'a, 'r>,
    /// The scene without this cloud.
    before: &'a Scene,
}

/// A cloud while it is read.
struct Reading<'a, 'r> {
    source: &'a CloudFile<'a, 'r>,
    spheres: Vec<Sphere>,
    /// The colour of all, unless the file has one for each.
    color: Option<Color>,
    colors: Vec<Color>,
    /// Facts about the colours of the file, if it has some.
    file_colors: Option<FileColors>,
    /// Whether the element gives the radius, the colour.
    of_element: [bool; 2],
    /// Rows that were left out.
    n_missing: usize,
    notes: Vec<Message>,
    chosen: CloudKeys,
}

/// Colours that a thread converts at once.
const COLORS_AT_ONCE: usize = 1 << 12;

/// A place in a file.
#[derive(Clone, Copy, Debug)]
enum RowPlace {
    /// Line of a text, from 1.
    Line(u64),
    /// Row of an array, from 0.
    Row(u64),
}

/// An error in a row, without its place.
#[derive(Debug)]
struct RowError {
    message: String,
    hint: Hint,
    value: Option<String>,
    column: Option<String>,
}

impl RowError {
    fn new(message: impl Into<String>, hint: impl Into<Hint>) -> RowError {
        RowError { message: message.into(), hint: hint.into(), value: None, column: None }
    }

    fn with_value(self, value: impl Into<String>) -> RowError {
        RowError { value: Some(value.into()), ..self }
    }
}

impl From<Problem> for RowError {
    fn from((message, hint): Problem) -> RowError {
        RowError::new(message, hint)
    }
}

/// Facts about the colours of a file.
#[derive(Default)]
struct FileColors {
    /// The first one with a component above 1, and its place.
    above_one: Option<(RowPlace, Color)>,
    /// Whether a component is not a whole number.
    have_fractions: bool,
    /// Whether their type is bytes.
    are_bytes: bool,
    /// Whether an alpha is above 1, as the alpha of opaque bytes is.
    have_alpha_of_bytes: bool,
    /// The first alpha that is not 1, and the first that is not 255.
    transparent: [Option<(RowPlace, f64)>; 2],
}

impl FileColors {
    /// Takes a colour into account. Returns whether it is wrong on either scale.
    fn see(&mut self, FileColor { color, alpha, is_bytes }: FileColor, place: RowPlace) -> bool {
        let is_any = |is: fn(f64) -> bool| color.0.into_iter().any(is);
        self.are_bytes |= is_bytes;
        self.have_fractions |= is_any(|part| part.fract() != 0.0);
        if self.above_one.is_none() && is_any(|part| part > 1.0) {
            self.above_one = Some((place, color));
        }
        self.have_alpha_of_bytes |= alpha > 1.0;
        if !alpha.is_nan() {
            for (first, opaque) in self.transparent.iter_mut().zip([1.0, 255.0]) {
                if alpha != opaque && first.is_none() {
                    *first = Some((place, alpha));
                }
            }
        }
        is_any(|part| !(0.0..=255.0).contains(&part))
    }
}

fn wrong_color(Color([red, green, blue]): Color) -> RowError {
    RowError::new(
        format!("the colour is ({red:?}, {green:?}, {blue:?})"),
        "red, green and blue are from 0 to 1; or whole numbers from 0 to 255 in all rows",
    )
}

impl<'r> CloudFile<'_, 'r> {
    /// Opens the file.
    fn open(&self) -> Result<Input<'r>> {
        self.reader.input(&self.path).map_err(|error| self.failed(&error))
    }

    /// Returns the error of something in the file.
    fn wrong(&self, message: impl Into<String>, hint: impl Into<Hint>) -> Box<SceneError> {
        self.wrong_at(self.keys.span("file"), message, hint)
    }

    /// Returns the error of something in the file that does not fit the scene at this place.
    fn wrong_at(
        &self,
        span: Range<usize>,
        message: impl Into<String>,
        hint: impl Into<Hint>,
    ) -> Box<SceneError> {
        let message = cut(&message.into(), MAX_MESSAGE).into_owned();
        let mut error = SceneError::new(span, message, hint);
        error.subject = ErrorSubject { file: Some(self.path.clone()), ..ErrorSubject::default() };
        error
    }

    fn wrong_row(&self, place: RowPlace, fault: RowError) -> Box<SceneError> {
        let RowError { message, hint, value, column } = fault;
        let mut error = self.wrong(message, hint);
        match place {
            RowPlace::Line(line) => error.subject.line = Some(line),
            RowPlace::Row(row) => error.subject.row = Some(row),
        }
        (error.subject.column, error.value) = (column, value);
        error
    }

    /// Returns the error of a file that cannot be read, or an interruption.
    fn failed(&self, error: &io::Error) -> Error {
        match self.reader.control.check() {
            Err(interrupted) => interrupted,
            Ok(()) => {
                let has_escape =
                    self.keys.file.as_ref().is_some_and(|file| file.contains(char::is_control));
                let hint = match error.kind() {
                    io::ErrorKind::NotFound if has_escape => {
                        "in \"…\", a backslash starts an escape, such as `\\t` for a tab; write paths with `/`, or in '…': file = \
                         'data\\table.csv'"
                    }
                    io::ErrorKind::NotFound => {
                        "check the path; in a scene file, paths are relative to its folder"
                    }
                    io::ErrorKind::InvalidInput
                    | io::ErrorKind::UnexpectedEof
                    | io::ErrorKind::InvalidData => {
                        "the file may be damaged; copy or save it again"
                    }
                    _ => "check that the file can be read",
                };
                self.wrong(format!("cannot read the data: {error}"), hint).into()
            }
        }
    }

    /// Returns the value of a key. `in_file`, if the file has the value itself, is the key of `columns` that ignores it.
    fn only_once<T>(
        &self,
        key: &'static str,
        example: Setting,
        in_file: Option<&'static str>,
        given: Option<T>,
    ) -> Result<Option<T>> {
        let what = if key == "color" { "colour" } else { key };
        match (in_file, &given) {
            (Some(own), Some(_)) => {
                let message =
                    format!("the file has a {what} for each sphere, but `{key}` is given as well");
                let settings = [Setting::named(key), Setting::no_column(own)];
                let hint = Hint::new("remove {}, or ignore the file's with {}", settings);
                let mut error = self.wrong_at(self.keys.span(key), message, hint);
                error.subject.key = Some(key);
                Err(error.into())
            }
            (None, None) => {
                let message = format!("the file has no {what} for its spheres");
                Err(self
                    .wrong(message, Hint::new("give all of them one, for example {}", [example]))
                    .into())
            }
            _ => Ok(given),
        }
    }

    /// Returns the frame that the scene asks for: from 0, or from −1 backwards.
    fn frame(&self) -> i32 {
        self.keys.frame.unwrap_or(0)
    }

    /// Returns the error of a file that has only `n_frames` frames.
    fn no_such_frame(&self, n_frames: u32) -> Error {
        let key = if self.keys.frame.is_some() { "frame" } else { "file" };
        let frames = count(n_frames as usize, "frame");
        let message = format!("the file has {frames}, but no frame {}", self.frame());
        let last = f64::from(n_frames.saturating_sub(1));
        let hint =
            Hint::new("frames count from 0; the last one is {}", [Setting::number("frame", last)]);
        self.wrong_at(self.keys.span(key), message, hint).into()
    }

    /// Refuses `frame` for a file that has none.
    fn refuse_frame(&self) -> Checked<()> {
        self.refuse(
            self.keys.frame.is_some(),
            "frame",
            "the file has no frames",
            ".xyz files and LAMMPS dumps",
        )
    }

    /// Refuses `header` for a file whose columns are named otherwise.
    fn refuse_header(&self) -> Checked<()> {
        self.refuse(
            self.keys.header.is_some(),
            "header",
            "the file is not a table",
            "tables of text (.csv)",
        )
    }

    fn refuse(
        &self,
        is_given: bool,
        key: &'static str,
        message: &str,
        purpose: &str,
    ) -> Checked<()> {
        if !is_given {
            return Ok(());
        }
        let hint =
            Hint::new("remove {}", [Setting::named(key)]).then(format!("; it is for {purpose}"));
        let mut error = self.wrong_at(self.keys.span(key), message, hint);
        error.subject.key = Some(key);
        Err(error)
    }
}

impl Reading<'_, '_> {
    /// Reads all spheres of the file, and returns its columns.
    fn read(&mut self) -> Result<ColumnLayout> {
        let source = self.source;
        let input = source.open()?;
        let format = match source.keys.format {
            Some(format) => format,
            None => match recognize(input.head(), &source.path) {
                Content::Data(format) => format,
                Content::Foreign(foreign) => {
                    let message = format!("expected data of spheres, found {}", foreign.what);
                    return Err(source.wrong(message, foreign.hint(&source.path)).into());
                }
                Content::Scene => {
                    let hint = "give an .npy, .csv or .xyz file, or a LAMMPS dump";
                    return Err(source.wrong("the content is not recognized as data", hint).into());
                }
            },
        };
        match format {
            DataFormat::Npy => npy::read(self, input),
            DataFormat::Table => text::read(self, input, &csv::FORMAT),
            DataFormat::Xyz => text::read(self, input, &xyz::FORMAT),
            DataFormat::Lammps => text::read(self, input, &lammps::FORMAT),
        }
    }

    /// Adds a note about the file.
    fn note(&mut self, note: impl Into<Message>) {
        let Message { text, hint } = note.into();
        self.notes.push(Message { text: format!("{}: {text}", self.source.path.shown()), hint });
    }

    /// Whether rows without a coordinate or a radius are left out.
    fn skips_missing(&self) -> bool {
        self.source.keys.missing == Some(MissingRows::Skip)
    }

    /// Returns a sphere with the radius of all, or with 0; stores the colour of all. A key that the file makes superfluous is
    /// an error, and so is a radius or a colour that neither gives. An element gives only values that the scene does not give.
    fn template(&mut self, layout: &ColumnLayout) -> Result<Sphere> {
        let &CloudFile { keys, reader, .. } = self.source;
        let has_element = layout.element.is_some();
        let is_colored = layout.has_colors || keys.color_by.is_some();
        let [takes_radius, takes_color] = layout.takes_of_element;
        self.of_element = [
            has_element && takes_radius && !layout.has_radius && keys.radius.is_none(),
            has_element && takes_color && !is_colored && keys.color.is_none(),
        ];
        let [element_gives_radius, element_gives_color] = self.of_element;
        if let Some(usual) = reader.usual {
            let lacks_radius = !layout.has_radius && !element_gives_radius && keys.radius.is_none();
            let lacks_color = !is_colored && !element_gives_color && keys.color.is_none();
            self.chosen.radius = usual.radius.filter(|_| lacks_radius);
            self.chosen.color = usual.color.filter(|_| lacks_color);
        }
        if element_gives_radius {
            self.note("radii are the van der Waals radii of the elements, in ångström");
        }
        let center = columns::constant_center(layout.constants);
        let radius = match element_gives_radius {
            true => None,
            false => {
                let example = Setting::number("radius", 0.01);
                let own = layout.has_radius.then_some("radius");
                self.source.only_once("radius", example, own, keys.radius.or(self.chosen.radius))?
            }
        };
        if !element_gives_color && keys.color_by.is_none() {
            let example = Setting::text("color", "#1f77b4");
            let own = layout.has_colors.then_some("color");
            self.color =
                self.source.only_once("color", example, own, keys.color.or(self.chosen.color))?;
        }
        self.file_colors = layout.has_colors.then(FileColors::default);
        Ok(Sphere { center, radius: radius.unwrap_or_default() })
    }

    /// Reserves memory for `n` more spheres.
    fn reserve(&mut self, n: usize) -> Result<()> {
        let path = self.source.path.shown();
        let n_before = self.source.before.n_objects() + self.spheres.len();
        let n_most = MAX_OBJECTS.saturating_sub(n_before);
        if n > n_most {
            return Err(Error::TooLarge(format!(
                "{path}: {n} spheres are too many: with {n_before} objects before them, at most {n_most} \
                 have an id of 32 bits; give fewer"
            ).into()));
        }
        let is_first = self.source.before.spheres.is_empty();
        let n_bytes_each = match self.color {
            Some(_) if is_first => size_of::<Sphere>(),
            None if is_first => size_of::<(Sphere, Color)>(),
            // In the end they are copied behind the others.
            _ => 2 * size_of::<(Sphere, Color)>(),
        } as u64;
        // Where there are some already, both copies are held for a while.
        let n_needed = (self.spheres.len() + n) as u64 * n_bytes_each;
        let available = Available::now();
        let n_colors = if self.color.is_none() { n } else { 0 };
        if n_needed > available.bytes
            || self.spheres.try_reserve_exact(n).is_err()
            || self.colors.try_reserve_exact(n_colors).is_err()
        {
            return Err(Error::TooLarge(
                format!(
                    "{path}: {n} spheres need {} MiB of memory, but only {} MiB are available {}, \
                 enough for {}; free some, or give fewer spheres",
                    n_needed.div_ceil(1 << 20),
                    available.bytes >> 20,
                    available.limit,
                    available.bytes / n_bytes_each
                )
                .into(),
            ));
        }
        Ok(())
    }

    /// Adds a checked sphere, with its colour as the file has it.
    fn push(&mut self, (sphere, color): (Sphere, FileColor), place: RowPlace) -> Result<()> {
        if self.is_missing(&sphere) {
            self.n_missing += 1;
            return Ok(());
        }
        self.check(sphere, color, place)?;
        if self.spheres.len() == self.spheres.capacity() {
            self.reserve((self.spheres.len() / 4).max(1 << 16))?;
        }
        self.spheres.push(sphere);
        if self.color.is_none() {
            self.colors.push(color.color);
        }
        Ok(())
    }

    /// Whether the sphere is left out because a coordinate or the radius is missing.
    fn is_missing(&self, sphere: &Sphere) -> bool {
        self.skips_missing() && !(sphere.center.is_finite() && sphere.radius.is_finite())
    }

    /// Adds the note of how many rows were left out.
    fn note_missing(&mut self) {
        if self.n_missing > 0 {
            let (n_missing, n_rows) = (self.n_missing, self.n_missing + self.spheres.len());
            self.note(format!(
                "{n_missing} of {} without a coordinate or a radius left out",
                count(n_rows, "row")
            ));
        }
    }

    /// Refuses a sphere without a meaning, and a colour that is wrong on either scale.
    fn check(&mut self, sphere: Sphere, color: FileColor, place: RowPlace) -> Result<()> {
        let eye = self.source.before.camera.as_ref().map_or(DVec3::ZERO, |camera| camera.position);
        let file_colors = self.file_colors.as_mut();
        let wrong_color = || file_colors?.see(color, place).then(|| wrong_color(color.color));
        let mut problem = problem_of(&sphere, eye).map(RowError::from);
        if let Some(fault) = &mut problem
            && !(sphere.center.is_finite() && sphere.radius.is_finite())
        {
            let Sphere { center, radius } = sphere;
            fault.message = match center.is_finite() {
                true => format!("expected a finite radius, found {radius:?}"),
                false => format!("expected finite coordinates, found {:?}", center.to_array()),
            };
            fault.hint =
                Hint::new("leave out such rows with {}", [Setting::text("missing", "skip")]);
        }
        match problem.or_else(wrong_color) {
            None => Ok(()),
            Some(fault) => Err(self.source.wrong_row(place, fault).into()),
        }
    }

    /// Turns the numbers that the file has for colours into colours.
    fn finish_colors(&mut self, layout: &ColumnLayout) -> Result<Option<Coloring>> {
        if let Some(name) = &self.source.keys.color_by {
            return self.color_by(name, layout).map(Some);
        }
        let Some(colors) = self.file_colors.take() else { return Ok(None) };
        let FileColors { above_one, have_fractions, are_bytes, have_alpha_of_bytes, transparent } =
            colors;
        if let Some((place, color)) = above_one
            && have_fractions
        {
            return Err(self.source.wrong_row(place, wrong_color(color)).into());
        }
        let are_bytes = are_bytes || above_one.is_some() || have_alpha_of_bytes && !have_fractions;
        if let Some((place, alpha)) = transparent[usize::from(are_bytes)] {
            let fault = RowError::new(
                format!("the alpha is {alpha:?}, but spheres are opaque"),
                layout.hint_without_alpha(),
            );
            return Err(self.source.wrong_row(place, fault).into());
        }
        let is_linear = self.source.keys.color_space == Some(ColorSpace::Linear);
        let linear_bytes = linear_of_bytes();
        let convert = |part: f64| match (are_bytes, is_linear) {
            (true, true) => part / 255.0,
            (true, false) => linear_bytes[usize::from(part as u8)],
            (false, true) => part,
            (false, false) => linear_from_srgb(part),
        };
        if are_bytes || !is_linear {
            parallel::map(self.colors.chunks_mut(COLORS_AT_ONCE), |colors| {
                colors.iter_mut().for_each(|Color(parts)| *parts = parts.map(convert));
            });
        }
        // Without a doubt about the scale or the space, there is nothing to note.
        if layout.has_whole_colors() || self.source.keys.color_space.is_some() {
            return Ok(None);
        }
        if are_bytes {
            self.note("its colours are whole numbers up to 255, read as sRGB");
        } else {
            let hint =
                Hint::new("{} reads them as linear", [Setting::text("color_space", "linear")]);
            self.note(Message::new("its colours are numbers up to 1, read as sRGB", hint));
        }
        Ok(None)
    }

    fn color_by(&mut self, name: &str, layout: &ColumnLayout) -> Result<Coloring> {
        if layout.has_vector {
            for Color(parts) in &mut self.colors {
                *parts = [DVec3::from_array(*parts).length(); 3];
            }
        }
        let CloudKeys { colormap, range, missing_color, .. } = self.source.keys;
        let coloring = Coloring::paint(
            layout.color_by.clone(),
            colormap.clone().unwrap_or_default(),
            *range,
            missing_color.unwrap_or(Coloring::MISSING_COLOR),
            &mut self.colors,
        );
        let coloring = coloring.ok_or_else(|| {
            let found = format!("the column {:?} has no number", quoted(name));
            let help = "apply the colour map to another column";
            self.source.wrong_at(self.source.keys.span("color_by"), found, help)
        })?;
        let Coloring { column, map, range: [low, high], missing_color, n_missing } = &coloring;
        let (column, map) = (quoted(column), map.name());
        let mut words = format!("coloured by `{column}`, {map} from {low:?} to {high:?}");
        if *n_missing > 0 {
            let spheres = count(*n_missing, "sphere");
            let color = hex(missing_color.to_srgb8());
            words += &format!("; {spheres} without a number in {color}");
        }
        self.note(words);
        Ok(coloring)
    }
}
