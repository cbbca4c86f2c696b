//! `[[spheres]]`: clouds of spheres, each from a file of its own, read as a stream.
//!
//! | ending | a row is | radius and colour |
//! | --- | --- | --- |
//! | `.npy` | x, y, z; x, y, z, r; or x, y, z, r, red, green, blue | linear, 0 to 1 |
//! | `.csv` | what the header says: x, y, z, and optionally r, and red, green, blue | linear, 0 to 1 |
//! | `.xyz` | element, x, y, z in ångström | by element |
//!
//! `radius` and `color` of the table say for all spheres what the file lacks. Where the file has
//! it, the key is refused: one of the two would be without effect.

mod csv;
mod elements;
mod npy;
mod watched;
mod xyz;

use std::ffi::OsStr;
use std::fmt::Display;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::open::Files;
use super::places::{Fault, Stop, cut, quoted};
use super::spheres::{Problem, problem_of};
use super::table::Checked;
use super::{Cloud, Color, MAX_OBJECTS, Scene, Sphere, Spheres};
use crate::control::Control;
use crate::error::{Error, Lack};
use crate::memory::Available;
pub(crate) use watched::Watched;

/// A value and its place in the scene file.
#[derive(Debug)]
pub(super) struct Given<T> {
    value: T,
    span: Range<usize>,
}

impl<T> Given<T> {
    pub fn new(span: Range<usize>, value: Checked<T>) -> Checked<Given<T>> {
        Ok(Given { value: value?, span })
    }
}

/// The table of a cloud in a scene file.
#[derive(Debug)]
pub(super) struct CloudTable {
    pub file: Given<String>,
    pub radius: Option<Given<f64>>,
    pub color: Option<Given<Color>>,
}

/// The kind of a file, by its ending.
#[derive(Clone, Copy)]
enum FileKind {
    Npy,
    Csv,
    Xyz,
}

impl FileKind {
    fn of(path: &Path) -> Option<FileKind> {
        match path.extension().and_then(OsStr::to_str)?.to_ascii_lowercase().as_str() {
            "npy" => Some(FileKind::Npy),
            "csv" => Some(FileKind::Csv),
            "xyz" => Some(FileKind::Xyz),
            _ => None,
        }
    }

    /// How many times the file is gone through.
    fn n_passes(self) -> u64 {
        match self {
            // First the lines are counted.
            FileKind::Csv => 2,
            FileKind::Npy | FileKind::Xyz => 1,
        }
    }
}

/// True for a file that a cloud can be read from, by its ending.
pub(super) fn is_cloud_file(path: &Path) -> bool {
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
        let spheres = &mut scene.spheres;
        let mut cloud = Reading { source, files, eye, control, n_planes, spheres };
        match cloud.source.format {
            FileKind::Npy => npy::read(&mut cloud)?,
            FileKind::Csv => csv::read(&mut cloud)?,
            FileKind::Xyz => xyz::read(&mut cloud)?,
        }
        let path = cloud.source.path;
        let n_spheres = scene.spheres.len() - n_before;
        // No more than `MAX_OBJECTS`, which is less than 2³².
        scene.clouds.push(Cloud { path, n_spheres, first_id: n_before as u32 + 1 });
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
                "a cloud is a file that ends in .npy, .csv or .xyz",
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
            format!("{}: {}", self.source.path.display(), cut(&found.to_string(), MOST_FOUND));
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

    /// The radius (or 0) and the colour that the table says for all, or an error where the table
    /// and the file both say it or neither does.
    fn template(&self, has_radius: bool, has_color: bool) -> Result<Template, Stop> {
        let CloudTable { radius, color, .. } = self.source.table;
        let radius = self.only_once("radius", "0.01", has_radius, radius.as_ref())?;
        let color = self.only_once("color", "\"#1f77b4\"", has_color, color.as_ref())?;
        Ok(Template {
            sphere: Sphere { center: DVec3::ZERO, radius: radius.unwrap_or_default() },
            color,
        })
    }

    fn only_once<T: Copy>(
        &self,
        key: &str,
        example: &str,
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
                    self.source.path.display()
                ),
                format!("remove `{key}`; it is for files that have none"),
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
        let path = self.source.path.display();
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

    /// Adds a checked sphere; `place` says where in the file it stands.
    fn push<P: Display>(
        &mut self,
        (sphere, color): (Sphere, Color),
        place: impl FnOnce() -> P,
    ) -> Result<(), Stop> {
        if let Some(problem) = problem_of(&sphere, color, self.eye) {
            return Err(self.wrong_row(place(), problem));
        }
        if self.spheres.len() == self.spheres.capacity() {
            // Only what could not be counted before: a pipe, or a file without line feeds.
            self.reserve(self.spheres.len().max(1 << 16), Some(color))?;
        }
        self.spheres.push(sphere, color);
        Ok(())
    }

    fn wrong_row(&self, place: impl Display, (found, help): Problem) -> Stop {
        self.wrong(format!("{place}: {found}"), help)
    }
}
