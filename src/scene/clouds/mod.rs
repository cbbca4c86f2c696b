//! `[[spheres]]`: clouds of spheres, each from a file of its own, read as a stream.
//!
//! | ending | a row is | radius and colour |
//! | --- | --- | --- |
//! | `.npy` | x, y, z; x, y, z, r; or x, y, z, r, red, green, blue | linear, 0 to 1 |
//! | `.csv` | what the header says: x, y, z, and optionally r, and red, green, blue | linear, 0 to 1 |
//! | `.xyz` | element, x, y, z in ångström | by element |
//!
//! What a file lacks, `radius` and `color` of the table say for all its spheres. Where the file has
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
use super::table::Checked;
use super::{Cloud, Color, MAX_OBJECTS, Scene, Sphere};
use crate::control::Control;
use crate::error::Error;
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

/// What a scene file says about a cloud.
#[derive(Debug)]
pub(super) struct CloudTable {
    pub file: Given<String>,
    pub radius: Option<Given<f64>>,
    pub color: Option<Given<Color>>,
}

/// The kind of a file, by its ending.
#[derive(Clone, Copy)]
enum Format {
    Npy,
    Csv,
    Xyz,
}

impl Format {
    fn of(path: &Path) -> Option<Format> {
        match path.extension().and_then(OsStr::to_str)?.to_ascii_lowercase().as_str() {
            "npy" => Some(Format::Npy),
            "csv" => Some(Format::Csv),
            "xyz" => Some(Format::Xyz),
            _ => None,
        }
    }

    /// How many times the file is gone through.
    fn n_passes(self) -> u64 {
        match self {
            // First the lines are counted.
            Format::Csv => 2,
            Format::Npy | Format::Xyz => 1,
        }
    }
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
            Format::Npy => npy::read(&mut cloud)?,
            Format::Csv => csv::read(&mut cloud)?,
            Format::Xyz => xyz::read(&mut cloud)?,
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
    format: Format,
}

impl<'t> Source<'t> {
    fn new(table: &'t CloudTable, folder: &Path) -> Checked<Source<'t>> {
        let path = folder.join(&table.file.value);
        match Format::of(&path) {
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

/// A cloud while it is read: what its spheres must be, and where they go.
struct Reading<'a> {
    source: Source<'a>,
    files: Files,
    eye: DVec3,
    control: &'a Control,
    n_planes: usize,
    spheres: &'a mut Vec<Sphere>,
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

    /// A sphere with what the table says for all, or an error where the table and the file both
    /// say it or neither does.
    fn template(&self, has_radius: bool, has_color: bool) -> Result<Sphere, Stop> {
        let CloudTable { radius, color, .. } = self.source.table;
        let radius = self.only_once("radius", "0.01", has_radius, radius.as_ref())?;
        let color = self.only_once("color", "\"#1f77b4\"", has_color, color.as_ref())?;
        Ok(Sphere {
            name: None,
            center: DVec3::ZERO,
            radius: radius.unwrap_or_default(),
            color: color.unwrap_or_default(),
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
            (false, None) => Err(self.wrong(
                format!("the file has no {key} for its spheres"),
                format!("add for all of them, e.g. `{key} = {example}`"),
            )),
        }
    }

    /// Makes room for `n` more spheres, and no more.
    fn reserve(&mut self, n: usize) -> Result<(), Stop> {
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
        let n_bytes = n as u64 * size_of::<Sphere>() as u64;
        let available = Available::now();
        // Where there are some already, both copies are held for a while.
        let n_moved = if self.spheres.capacity() == 0 { 0 } else { self.spheres.len() };
        let n_needed = n_bytes + (n_moved * size_of::<Sphere>()) as u64;
        if n_needed > available.bytes || self.spheres.try_reserve_exact(n).is_err() {
            return Err(Error::TooLarge(format!(
                "{path}: {n} spheres need {} MiB of memory, but only {} MiB are available {}, \
                 enough for {}; free some, or give fewer spheres",
                n_needed.div_ceil(1 << 20),
                available.bytes >> 20,
                available.limit,
                available.bytes / size_of::<Sphere>() as u64
            ))
            .into());
        }
        Ok(())
    }

    /// Adds a checked sphere; `place` says where in the file it stands.
    fn push<P: Display>(&mut self, sphere: Sphere, place: impl FnOnce() -> P) -> Result<(), Stop> {
        if let Some(problem) = problem_of(&sphere, self.eye) {
            return Err(self.wrong_row(place(), problem));
        }
        if self.spheres.len() == self.spheres.capacity() {
            // Only what could not be counted before: a pipe, or a file without line feeds.
            self.reserve(self.spheres.len().max(1 << 16))?;
        }
        self.spheres.push(sphere);
        Ok(())
    }

    fn wrong_row(&self, place: impl Display, (found, help): Problem) -> Stop {
        self.wrong(format!("{place}: {found}"), help)
    }
}

/// What was found and what is expected.
type Problem = (String, &'static str);

/// Why this is no sphere of a scene seen from `eye`.
fn problem_of(sphere: &Sphere, eye: DVec3) -> Option<Problem> {
    let Sphere { center, radius, color: Color(color), .. } = sphere;
    let reach = center.abs() + DVec3::splat(*radius);
    let is_far = !(reach.is_finite() && (center - eye).is_finite());
    let is_colored = color.iter().all(|part| (0.0..=1.0).contains(part));
    if !is_far && *radius > 0.0 && is_colored {
        return None;
    }
    Some(if !center.is_finite() || !radius.is_finite() {
        let [x, y, z] = center.to_array();
        (
            format!("not all numbers are finite: centre ({x:?}, {y:?}, {z:?}), radius {radius:?}"),
            "coordinates and radii are finite numbers (up to 1.8e308)",
        )
    } else if *radius <= 0.0 {
        (format!("the radius is {radius:?}"), "a radius is greater than 0")
    } else if is_far {
        (
            "the sphere reaches too far from the eye or the origin".into(),
            "sums and differences of coordinates must stay below 1.8e308, the largest 64-bit float",
        )
    } else {
        let [red, green, blue] = color;
        (
            format!("the colour is ({red:?}, {green:?}, {blue:?})"),
            "red, green and blue are linear, each from 0 to 1",
        )
    })
}
