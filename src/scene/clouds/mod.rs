//! `[[spheres]]`: clouds of spheres, each from a file of its own, read as a stream.
//!
//! | ending | a row is | radius and colour |
//! | --- | --- | --- |
//! | `.npy` | x, y, z; x, y, z, r; or x, y, z, r, red, green, blue | linear, 0 to 1, or sRGB, 0 to 255 |
//! | `.npy`, structured | the fields of the array, by name | as above |
//! | `.csv`, also `.tsv`, `.txt`, `.dat` | what the header says, separated by `,` `;` tabs or spaces | as above |
//! | `.xyz`, also `.extxyz` | element, x, y, z in ångström, or what `Properties=` says | as above, else by element |
//! | `.dump`, `.lammpstrj` | what `ITEM: ATOMS` says | as above, else by element |
//!
//! `columns` says which column is what where its name doesn't. `radius` and `color` of the table say for
//! all spheres what the file lacks; where the file has it, the key is refused: one of the two would
//! be without effect. `color_by` colours by a column, whatever colours the file has.
//!
//! While a file is read, the list of colours holds the numbers of the file as they are, colours of
//! either scale or what spheres are coloured by. What they mean is known at the end, and then they
//! become colours in their places.

mod columns;
mod csv;
mod elements;
mod lammps;
mod npy;
mod text;
mod watched;
mod xyz;

use std::ffi::OsStr;
use std::fmt::Display;
use std::io;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::open::Files;
use super::places::{Fault, Stop, quoted};
use super::schema::Spanned as Given;
use super::spheres::{Problem, problem_of};
use super::table::Checked;
use super::{Cloud, Color, ColorMap, Coloring, MAX_OBJECTS, Scene, Sphere, Spheres, hex};
use crate::control::Control;
use crate::error::{Error, Lack};
use crate::memory::Available;
use crate::plain::Shown;
use crate::words::{count, cut};
use columns::Layout;
pub(super) use columns::{ColumnNames, Part};
use text::TextFormat;
pub(crate) use watched::Watched;

/// The table of a cloud in a scene file.
#[derive(Debug)]
pub(super) struct CloudTable {
    pub file: Given<String>,
    pub radius: Option<Given<f64>>,
    pub color: Option<Given<Color>>,
    pub columns: ColumnNames,
    pub color_by: Option<Given<String>>,
    pub colormap: ColorMap,
    pub range: Option<[f64; 2]>,
    pub missing_color: Color,
    pub frame: Option<Given<u32>>,
}

/// The kind of a file, by its ending.
#[derive(Clone, Copy)]
enum FileKind {
    Npy,
    Text(&'static TextFormat),
}

impl FileKind {
    fn of(path: &Path) -> Option<FileKind> {
        match path.extension().and_then(OsStr::to_str)?.to_ascii_lowercase().as_str() {
            "npy" => Some(FileKind::Npy),
            "csv" | "tsv" | "txt" | "dat" => Some(FileKind::Text(&csv::FORMAT)),
            "xyz" | "extxyz" => Some(FileKind::Text(&xyz::FORMAT)),
            "dump" | "lammpstrj" => Some(FileKind::Text(&lammps::FORMAT)),
            _ => None,
        }
    }

    /// How many times the file is gone through.
    fn n_passes(self) -> u64 {
        match self {
            // First the lines are counted.
            FileKind::Text(format) if !format.has_frames => 2,
            FileKind::Npy | FileKind::Text(_) => 1,
        }
    }
}

/// True for a file that a cloud can be read from, by its ending.
pub fn is_cloud_file(path: &Path) -> bool {
    FileKind::of(path).is_some()
}

/// Adds the spheres of all clouds to those that `scene` has, in the order of the file. Paths are
/// relative to `folder`.
pub(super) fn read_clouds(
    tables: &[CloudTable],
    folder: &Path,
    files: Files,
    scene: &mut Scene,
    control: &Control,
) -> Result<(), Stop> {
    let mut sources = Vec::with_capacity(tables.len());
    for table in tables {
        sources.push(Source::new(table, folder)?);
    }
    control.expect_bytes(sources.iter().map(Source::n_bytes_to_read).sum());
    let eye = scene.camera.as_ref().map_or(DVec3::ZERO, |camera| camera.position);
    for source in sources {
        let n_before = scene.spheres.len();
        let n_planes = scene.planes.len();
        let (spheres, notes) = (&mut scene.spheres, &mut scene.notes);
        let colors = FileColors::default();
        let mut cloud = Reading { source, files, eye, control, n_planes, spheres, colors, notes };
        match cloud.source.format {
            FileKind::Npy => npy::read(&mut cloud)?,
            FileKind::Text(format) => text::read(&mut cloud, format)?,
        }
        let coloring = cloud.finish_colors(n_before)?;
        let path = cloud.source.path;
        let n_spheres = scene.spheres.len() - n_before;
        // No more than `MAX_OBJECTS`, which is less than 2³².
        let first_id = n_before as u32 + 1;
        scene.clouds.push(Cloud { path, n_spheres, first_id, coloring });
    }
    Ok(())
}

/// A cloud's file, not yet opened.
struct Source<'t> {
    table: &'t CloudTable,
    path: PathBuf,
    format: FileKind,
}

impl<'t> Source<'t> {
    fn new(table: &'t CloudTable, folder: &Path) -> Checked<Source<'t>> {
        let path = folder.join(&table.file.value);
        match FileKind::of(&path) {
            Some(format) => Ok(Source { table, path, format }),
            None => Err(Fault::new(
                table.file.span.clone(),
                format!("the name {:?} does not tell its format", quoted(&table.file.value)),
                "a cloud is a file that ends in .npy, .csv or .xyz; .tsv, .txt and .dat are read as \
                 .csv, .extxyz as .xyz, .dump and .lammpstrj as LAMMPS writes them",
            )),
        }
    }

    fn n_bytes_to_read(&self) -> u64 {
        let n_bytes = std::fs::metadata(&self.path).map_or(0, |metadata| metadata.len());
        n_bytes.saturating_mul(self.format.n_passes())
    }
}

/// Characters of what was found that a message tells: a cell or a word may be a whole file.
const MOST_FOUND: usize = 400;

/// A sphere with what the scene file says for all of a cloud.
#[derive(Clone, Copy)]
struct Template {
    sphere: Sphere,
    /// The colour of all of them; where there is none, the file has one for each.
    color: Option<Color>,
}

/// A cloud while it is read: what its spheres must be, and where they go.
struct Reading<'a> {
    source: Source<'a>,
    files: Files,
    eye: DVec3,
    control: &'a Control,
    n_planes: usize,
    spheres: &'a mut Spheres,
    colors: FileColors,
    notes: &'a mut Vec<String>,
}

/// What is known of the colours in a file.
#[derive(Default)]
struct FileColors {
    /// True where the list of colours holds numbers of the file.
    is_from_file: bool,
    /// The first one with a number above 1, and where it stands.
    above_one: Option<(String, Color)>,
    /// True where a number is not a whole one.
    has_fractions: bool,
    /// True where their type is that of bytes.
    are_bytes: bool,
    /// True where spheres are coloured by the length of a vector.
    is_vector: bool,
    /// The name of what they are coloured by.
    column: String,
}

impl FileColors {
    /// Looks at a colour; `place` says where in the file it stands. False for one that is wrong on
    /// either scale.
    fn see<P: Display>(&mut self, color: Color, place: impl FnOnce() -> P) -> bool {
        let mut is_above_one = false;
        for part in color.0 {
            if !(0.0..=255.0).contains(&part) {
                return false;
            }
            self.has_fractions |= part.fract() != 0.0;
            is_above_one |= part > 1.0;
        }
        if is_above_one && self.above_one.is_none() {
            self.above_one = Some((place().to_string(), color));
        }
        true
    }
}

fn wrong_color(Color([red, green, blue]): Color) -> Problem {
    (
        format!("the colour is ({red:?}, {green:?}, {blue:?})"),
        "red, green and blue are linear, each from 0 to 1; or whole numbers from 0 to 255 in all rows",
    )
}

impl<'a> Reading<'a> {
    /// The file, and its length where it has one.
    fn open(&self) -> Result<(Watched<'a>, Option<u64>), Stop> {
        let open = || {
            let file = self.files.open(&self.source.path)?;
            let metadata = file.metadata()?;
            Ok((file, metadata.is_file().then_some(metadata.len())))
        };
        let (file, n_bytes) = open().map_err(|error| self.failed(&error))?;
        Ok((Watched::new(file, self.control), n_bytes))
    }

    /// Something in the file is wrong.
    fn wrong(&self, found: impl Display, help: impl Into<String>) -> Stop {
        let message =
            format!("{}: {}", self.source.path.shown(), cut(&found.to_string(), MOST_FOUND));
        Fault::new(self.source.table.file.span.clone(), message, help).into()
    }

    /// Nothing is wrong but that something is missing, which the scene file can say.
    fn lacking(&self, lacks: Lack, found: impl Display, help: impl Into<String>) -> Stop {
        match self.wrong(found, help) {
            Stop::Fault(fault) => Fault { lacks: Some(lacks), ..fault }.into(),
            stop => stop,
        }
    }

    /// The system can't read the file, or the user interrupted.
    fn failed(&self, error: &io::Error) -> Stop {
        match self.control.check() {
            Err(interrupted) => interrupted.into(),
            Ok(()) => self.wrong(
                format!("cannot read the cloud: {error}"),
                "paths are relative to the folder of the scene file",
            ),
        }
    }

    /// Says something about the file that its reader may want to know.
    fn note(&mut self, words: impl Display) {
        self.notes.push(format!("{}: {words}", self.source.path.shown()));
    }

    /// The radius (or 0) and the colour that the table says for all, or an error where the table
    /// and the file both say it or neither does.
    fn template(&mut self, layout: &Layout) -> Result<Template, Stop> {
        let CloudTable { radius, color, color_by, .. } = self.source.table;
        let has_color = layout.has_color() || color_by.is_some();
        let own_color = if layout.color.is_some() { "red" } else { "element" };
        let radius = radius.as_ref();
        let radius = self.only_once(("radius", "0.01"), "radius", layout.has_radius(), radius)?;
        let color = color.as_ref();
        let color = self.only_once(("color", "\"#1f77b4\""), own_color, has_color, color)?;
        self.colors.is_from_file = layout.color.is_some();
        self.colors.is_vector = layout.color_by.len() > 1;
        self.colors.column.clone_from(&layout.color_by_name);
        Ok(Template {
            sphere: Sphere { center: DVec3::ZERO, radius: radius.unwrap_or_default() },
            color,
        })
    }

    /// What a key says, with its name and an example; `own` is the part of the file that says it too.
    fn only_once<T: Copy>(
        &self,
        (key, example): (&str, &str),
        own: &str,
        in_file: bool,
        given: Option<&Given<T>>,
    ) -> Result<Option<T>, Stop> {
        match (in_file, given) {
            (true, None) => Ok(None),
            (false, Some(given)) => Ok(Some(given.value)),
            (true, Some(given)) => Err(Fault::new(
                given.span.clone(),
                format!(
                    "`{key}` is given, but {} has one for each sphere",
                    self.source.path.shown()
                ),
                format!(
                    "remove `{key}`; it is for files that have none, or whose own is left out by \
                     `columns = {{ {own} = false }}`"
                ),
            )
            .into()),
            (false, None) => {
                let lacks = match key {
                    "radius" => Lack::Radius,
                    _ => Lack::Color,
                };
                Err(self.lacking(
                    lacks,
                    format!("the file has no {key} for its spheres"),
                    format!("add for all of them, e.g. `{key} = {example}`"),
                ))
            }
        }
    }

    /// Makes room for `n` more spheres, of one colour or of any, and no more.
    fn reserve(&mut self, n: usize, color: Option<Color>) -> Result<(), Stop> {
        let path = self.source.path.shown();
        let n_before = self.spheres.len() + self.n_planes;
        if n > MAX_OBJECTS - n_before.min(MAX_OBJECTS) {
            return Err(Error::TooLarge(format!(
                "{path}: {n} spheres are too many: with {n_before} objects before them, at most {} \
                 have an id of 32 bits; give fewer",
                MAX_OBJECTS - n_before.min(MAX_OBJECTS)
            ))
            .into());
        }
        let n_bytes = self.spheres.bytes_of(n, color);
        let available = Available::now();
        // Where there are some already, both copies are held for a while.
        let n_needed = n_bytes + self.spheres.bytes();
        if n_needed > available.bytes || self.spheres.try_reserve(n, color).is_err() {
            return Err(Error::TooLarge(format!(
                "{path}: {n} spheres need {} MiB of memory, but only {} MiB are available {}, \
                 enough for {}; free some, or give fewer spheres",
                n_needed.div_ceil(1 << 20),
                available.bytes >> 20,
                available.limit,
                available.bytes / n_bytes.div_ceil(n.max(1) as u64).max(1)
            ))
            .into());
        }
        Ok(())
    }

    /// Adds a checked sphere, its colour as the file has it; `place` says where in the file it stands.
    fn push<P: Display>(
        &mut self,
        (sphere, color): (Sphere, Color),
        place: impl Fn() -> P,
    ) -> Result<(), Stop> {
        self.check(sphere, color, &place)?;
        if self.spheres.len() == self.spheres.capacity() {
            // Only what could not be counted before: a pipe, or a file without line feeds.
            self.reserve(self.spheres.len().max(1 << 16), Some(color))?;
        }
        self.spheres.push(sphere, color);
        Ok(())
    }

    /// Refuses a sphere that has no meaning, and a colour that is wrong on either scale.
    fn check<P: Display>(
        &mut self,
        sphere: Sphere,
        color: Color,
        place: impl Fn() -> P,
    ) -> Result<(), Stop> {
        if let Some(problem) = problem_of(&sphere, Color::BLACK, self.eye) {
            return Err(self.wrong_row(place(), problem));
        }
        if self.colors.is_from_file && !self.colors.see(color, &place) {
            return Err(self.wrong_row(place(), wrong_color(color)));
        }
        Ok(())
    }

    fn wrong_row(&self, place: impl Display, (found, help): Problem) -> Stop {
        self.wrong(format!("{place}: {found}"), help)
    }

    /// The frame that the scene asks for, the first one by itself.
    fn frame(&self) -> u32 {
        self.source.table.frame.as_ref().map_or(0, |frame| frame.value)
    }

    /// The error where the file has no more frames than `n_frames`.
    fn no_such_frame(&self, n_frames: u32) -> Stop {
        let span = match &self.source.table.frame {
            Some(frame) => frame.span.clone(),
            None => self.source.table.file.span.clone(),
        };
        let frames = count(n_frames as usize, "frame");
        let path = self.source.path.shown();
        Fault::new(
            span,
            format!("{path}: the file has {frames}, so no frame {}", self.frame()),
            format!("frames are counted from 0: the last one is {}", n_frames.saturating_sub(1)),
        )
        .into()
    }

    /// Refuses `frame` of a file that has none.
    fn refuse_frame(&self) -> Result<(), Stop> {
        match &self.source.table.frame {
            None => Ok(()),
            Some(frame) => Err(Fault::new(
                frame.span.clone(),
                format!("`frame` is given, but {} has no frames", self.source.path.shown()),
                "remove `frame`; it is for .xyz files and LAMMPS dumps of several steps",
            )
            .into()),
        }
    }

    /// Makes colours of what the file has for them, from the sphere with the index `first` on.
    fn finish_colors(&mut self, first: usize) -> Result<Option<Coloring>, Stop> {
        let table = self.source.table;
        if let Some(name) = &table.color_by {
            let coloring = self.color_by(name, first)?;
            let Coloring { column, map, range: [low, high], missing_color, n_missing } = &coloring;
            let mut words = format!(
                "coloured by `{}`, {} from {low:?} to {high:?}",
                quoted(column),
                map.name()
            );
            if *n_missing > 0 {
                let spheres = count(*n_missing, "sphere");
                let color = hex(missing_color.to_srgb8());
                words += &format!("; {spheres} without a number in {color}");
            }
            self.note(words);
            return Ok(Some(coloring));
        }
        let are_bytes = self.colors.are_bytes || self.colors.above_one.is_some();
        if !(self.colors.is_from_file && are_bytes) {
            return Ok(None);
        }
        if let Some((place, color)) = self.colors.above_one.take()
            && self.colors.has_fractions
        {
            return Err(self.wrong_row(place, wrong_color(color)));
        }
        let grey = |byte: usize| Color::from_srgb8([byte as u8; 3]).0[0];
        let linear: [f64; 256] = std::array::from_fn(grey);
        for Color(parts) in self.spheres.colors_mut(first) {
            *parts = parts.map(|part| linear[usize::from(part as u8)]);
        }
        self.note("its colours are whole numbers up to 255, read as sRGB like #rrggbb");
        Ok(None)
    }

    fn color_by(&mut self, name: &Given<String>, first: usize) -> Result<Coloring, Stop> {
        let CloudTable { colormap: map, range, missing_color, .. } = *self.source.table;
        let FileColors { is_vector, ref column, .. } = self.colors;
        let column = column.clone();
        let number = |Color([x, y, z]): Color| match is_vector {
            true => (x * x + y * y + z * z).sqrt(),
            false => x,
        };
        let colors = self.spheres.colors_mut(first);
        Coloring::paint(column, map, range, missing_color, colors, number).ok_or_else(|| {
            let path = self.source.path.shown();
            let message = format!("{path}: the column {:?} has no number", quoted(&name.value));
            let help = "colour by another column, or give the `range` that it would have";
            Fault::new(name.span.clone(), message, help).into()
        })
    }
}
