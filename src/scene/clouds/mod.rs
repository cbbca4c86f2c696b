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
//! While a file is read, colours are the numbers of the file as they are, colours of either scale or what
//! spheres are coloured by. What they mean is known at the end, and then they become colours in their
//! places.

mod columns;
mod csv;
mod elements;
mod lammps;
mod npy;
mod text;
mod xyz;

use std::ffi::OsStr;
use std::fmt::Display;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::open::{Reader, Watched};
use super::places::quoted;
use super::schema::{CloudKeys, Section};
use super::spheres::{Problem, problem_of};
use super::table::Checked;
use super::{Cloud, Color, Coloring, MAX_OBJECTS, Scene, Sphere, hex, linear_of_bytes};
use crate::error::{Error, Result, SceneError};
use crate::memory::Available;
use crate::plain::Shown;
use crate::words::{count, cut};
use columns::Layout;

/// Reads all spheres of a file, and tells what its columns are.
type Format = fn(&mut Reading) -> Result<Layout>;

/// How a file is read, by its ending.
fn format_of(path: &Path) -> Option<Format> {
    match path.extension().and_then(OsStr::to_str)?.to_ascii_lowercase().as_str() {
        "npy" => Some(npy::read),
        "csv" | "tsv" | "txt" | "dat" => Some(|cloud| text::read(cloud, &csv::FORMAT)),
        "xyz" | "extxyz" => Some(|cloud| text::read(cloud, &xyz::FORMAT)),
        "dump" | "lammpstrj" => Some(|cloud| text::read(cloud, &lammps::FORMAT)),
        _ => None,
    }
}

/// True for a file that a cloud can be read from, by its ending.
pub fn is_cloud_file(path: &Path) -> bool {
    format_of(path).is_some()
}

/// Adds the spheres of all clouds to those that `scene` has, in the order of the file. Paths are
/// relative to `folder`. What was chosen of [`Reader::usual`] is returned.
pub(super) fn read_clouds(
    tables: &[CloudKeys],
    folder: &Path,
    reader: Reader,
    scene: &mut Scene,
) -> Result<CloudKeys> {
    let file_of = |keys: &CloudKeys| file_of(keys, folder);
    let files = tables.iter().map(file_of).collect::<Checked<Vec<_>>>()?;
    let n_bytes = |path: &Path| std::fs::metadata(path).map_or(0, |file| file.len());
    reader.control.expect_bytes(files.iter().map(|(path, _)| n_bytes(path)).sum());
    let mut chosen = CloudKeys::default();
    for (keys, (path, read)) in tables.iter().zip(files) {
        let source = CloudFile { keys, path, reader, before: scene };
        let mut cloud = Reading {
            source: &source,
            spheres: Vec::new(),
            color: None,
            colors: Vec::new(),
            file_colors: None,
            notes: Vec::new(),
            chosen,
        };
        let layout = read(&mut cloud)?;
        let coloring = cloud.finish_colors(&layout)?;
        let Reading { spheres, color, colors, notes, .. } = cloud;
        chosen = cloud.chosen;
        let path = source.path;
        // No more than `MAX_OBJECTS`, which is less than 2³².
        let first_id = scene.spheres.len() as u32 + 1;
        scene.clouds.push(Cloud { path, n_spheres: spheres.len(), first_id, coloring });
        scene.spheres.append(spheres, color.unwrap_or_default(), colors);
        scene.notes.extend(notes);
    }
    Ok(chosen)
}

/// The file of a cloud, and how it is read.
fn file_of(keys: &CloudKeys, folder: &Path) -> Checked<(PathBuf, Format)> {
    let file = keys.file()?;
    let path = folder.join(file);
    let format = format_of(&path).ok_or_else(|| {
        SceneError::new(
            keys.span("file"),
            format!("the name {:?} does not tell its format", quoted(file)),
            "a cloud is a file that ends in .npy, .csv or .xyz; .tsv, .txt and .dat are read as \
             .csv, .extxyz as .xyz, .dump and .lammpstrj as LAMMPS writes them",
        )
    })?;
    Ok((path, format))
}

/// Characters of what was found that a message tells: a cell or a word may be a whole file.
const MOST_FOUND: usize = 400;

/// A cloud's file.
struct CloudFile<'a> {
    keys: &'a CloudKeys,
    path: PathBuf,
    reader: Reader<'a>,
    /// The scene without this cloud.
    before: &'a Scene,
}

/// A cloud while it is read.
struct Reading<'a> {
    source: &'a CloudFile<'a>,
    spheres: Vec<Sphere>,
    /// The colour of all, unless the file has one for each.
    color: Option<Color>,
    colors: Vec<Color>,
    /// What is known of the colours in the file, where the list of colours holds these.
    file_colors: Option<FileColors>,
    notes: Vec<String>,
    chosen: CloudKeys,
}

/// What is known of the colours in a file.
#[derive(Default)]
struct FileColors {
    /// The first one with a number above 1, and where it stands.
    above_one: Option<(String, Color)>,
    /// True where a number is not a whole one.
    have_fractions: bool,
    /// True where their type is that of bytes.
    are_bytes: bool,
}

impl FileColors {
    /// Looks at a colour; `place` says where in the file it stands. True for one that is wrong on
    /// either scale.
    fn see(&mut self, color: Color, place: impl FnOnce() -> String) -> bool {
        let is_any = |is: fn(f64) -> bool| color.0.into_iter().any(is);
        self.have_fractions |= is_any(|part| part.fract() != 0.0);
        if self.above_one.is_none() && is_any(|part| part > 1.0) {
            self.above_one = Some((place(), color));
        }
        is_any(|part| !(0.0..=255.0).contains(&part))
    }
}

fn wrong_color(Color([red, green, blue]): Color) -> Problem {
    (
        format!("the colour is ({red:?}, {green:?}, {blue:?})"),
        "red, green and blue are linear, each from 0 to 1; or whole numbers from 0 to 255 in all rows",
    )
}

impl<'a> CloudFile<'a> {
    /// The file, and its length where it has one.
    fn open(&self) -> Result<(Watched<'a>, Option<u64>)> {
        let open = || {
            let file = self.reader.open(&self.path)?;
            let file = Watched { file, control: self.reader.control };
            let n_bytes = file.n_bytes()?;
            Ok((file, n_bytes))
        };
        open().map_err(|error| self.failed(&error))
    }

    /// Something in the file is wrong.
    fn wrong(&self, found: impl Display, help: impl Into<String>) -> Error {
        self.wrong_at(self.keys.span("file"), found, help)
    }

    /// Something in the file does not go with what stands there in the scene.
    fn wrong_at(&self, span: Range<usize>, found: impl Display, help: impl Into<String>) -> Error {
        let found = found.to_string();
        let message = format!("{}: {}", self.path.shown(), cut(&found, MOST_FOUND));
        SceneError::new(span, message, help).into()
    }

    fn wrong_row(&self, place: String, (found, help): Problem) -> Error {
        self.wrong(format!("{place}: {found}"), help)
    }

    /// The system can't read the file, or the user interrupted.
    fn failed(&self, error: &io::Error) -> Error {
        match self.reader.control.check() {
            Err(interrupted) => interrupted,
            Ok(()) => self.wrong(
                format!("cannot read the cloud: {error}"),
                "in a scene file, paths are relative to its folder",
            ),
        }
    }

    /// What a key says, of which there is an example; `in_file` is the part of the file that says it too.
    fn only_once<T>(
        &self,
        key: &str,
        example: &str,
        in_file: Option<&str>,
        given: Option<T>,
    ) -> Result<Option<T>> {
        match (in_file, &given) {
            (Some(own), Some(_)) => Err(SceneError::new(
                self.keys.span(key),
                format!("`{key}` is given, but {} has one for each sphere", self.path.shown()),
                format!(
                    "remove `{key}`; it is for files that have none, or whose own is left out by \
                     `columns = {{ {own} = false }}`"
                ),
            )
            .into()),
            (None, None) => Err(self.wrong(
                format!("the file has no {key} for its spheres"),
                format!("add for all of them, e.g. `{key} = {example}`"),
            )),
            _ => Ok(given),
        }
    }

    /// The frame that the scene asks for, the first one by itself.
    fn frame(&self) -> u32 {
        self.keys.frame.unwrap_or(0)
    }

    /// The error where the file has no more frames than `n_frames`.
    fn no_such_frame(&self, n_frames: u32) -> Error {
        let key = if self.keys.frame.is_some() { "frame" } else { "file" };
        let frames = count(n_frames as usize, "frame");
        let found = format!("the file has {frames}, so no frame {}", self.frame());
        let last = n_frames.saturating_sub(1);
        let help = format!("frames are counted from 0: the last one is {last}");
        self.wrong_at(self.keys.span(key), found, help)
    }

    /// Refuses `frame` of a file that has none.
    fn refuse_frame(&self) -> Checked<()> {
        match self.keys.frame {
            None => Ok(()),
            Some(_) => Err(SceneError::new(
                self.keys.span("frame"),
                format!("`frame` is given, but {} has no frames", self.path.shown()),
                "remove `frame`; it is for .xyz files and LAMMPS dumps of several steps",
            )),
        }
    }
}

impl Reading<'_> {
    /// Says something about the file that its reader may want to know.
    fn note(&mut self, words: impl Display) {
        self.notes.push(format!("{}: {words}", self.source.path.shown()));
    }

    /// A sphere with the radius that the scene says for all, or with 0. Its colour is kept. An error where
    /// the scene and the file both say one of them or neither does.
    fn template(&mut self, layout: &Layout) -> Result<Sphere> {
        let &CloudFile { keys, reader, .. } = self.source;
        let of_element = layout.element.is_some_and(|(_, [_, color])| color);
        let own_radius = layout.has_radius.then_some("radius");
        let own_color = if layout.has_colors {
            Some("red")
        } else {
            (of_element || keys.color_by.is_some()).then_some("element")
        };
        if let Some(usual) = reader.usual {
            let lacks_radius = own_radius.is_none() && keys.radius.is_none();
            let lacks_color = own_color.is_none() && keys.color.is_none();
            self.chosen.radius = usual.radius.filter(|_| lacks_radius);
            self.chosen.color = usual.color.filter(|_| lacks_color);
        }
        let (radius, color) =
            (keys.radius.or(self.chosen.radius), keys.color.or(self.chosen.color));
        let radius = self.source.only_once("radius", "0.01", own_radius, radius)?;
        self.color = self.source.only_once("color", "\"#1f77b4\"", own_color, color)?;
        self.file_colors = layout.has_colors.then(FileColors::default);
        Ok(Sphere { center: DVec3::ZERO, radius: radius.unwrap_or_default() })
    }

    /// Makes room for `n` more spheres, and no more.
    fn reserve(&mut self, n: usize) -> Result<()> {
        let path = self.source.path.shown();
        let n_before = self.source.before.n_objects() + self.spheres.len();
        let n_most = MAX_OBJECTS.saturating_sub(n_before);
        if n > n_most {
            return Err(Error::TooLarge(format!(
                "{path}: {n} spheres are too many: with {n_before} objects before them, at most {n_most} \
                 have an id of 32 bits; give fewer"
            )));
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
            return Err(Error::TooLarge(format!(
                "{path}: {n} spheres need {} MiB of memory, but only {} MiB are available {}, \
                 enough for {}; free some, or give fewer spheres",
                n_needed.div_ceil(1 << 20),
                available.bytes >> 20,
                available.limit,
                available.bytes / n_bytes_each
            )));
        }
        Ok(())
    }

    /// Adds a checked sphere, its colour as the file has it; `place` says where in the file it stands.
    fn push(&mut self, (sphere, color): (Sphere, Color), place: impl Fn() -> String) -> Result<()> {
        self.check(sphere, color, place)?;
        if self.spheres.len() == self.spheres.capacity() {
            self.reserve((self.spheres.len() / 4).max(1 << 16))?;
        }
        self.spheres.push(sphere);
        if self.color.is_none() {
            self.colors.push(color);
        }
        Ok(())
    }

    /// Refuses a sphere that has no meaning, and a colour that is wrong on either scale.
    fn check(&mut self, sphere: Sphere, color: Color, place: impl Fn() -> String) -> Result<()> {
        let eye = self.source.before.camera.as_ref().map_or(DVec3::ZERO, |camera| camera.position);
        let file_colors = self.file_colors.as_mut();
        let wrong_color = || file_colors?.see(color, &place).then(|| wrong_color(color));
        match problem_of(&sphere, eye).or_else(wrong_color) {
            None => Ok(()),
            Some(problem) => Err(self.source.wrong_row(place(), problem)),
        }
    }

    /// Makes colours of what the file has for them.
    fn finish_colors(&mut self, layout: &Layout) -> Result<Option<Coloring>> {
        if let Some(name) = &self.source.keys.color_by {
            return self.color_by(name, layout).map(Some);
        }
        let Some(FileColors { above_one, have_fractions, are_bytes }) = self.file_colors.take()
        else {
            return Ok(None);
        };
        match above_one {
            None if !are_bytes => return Ok(None),
            Some((place, color)) if have_fractions => {
                return Err(self.source.wrong_row(place, wrong_color(color)));
            }
            _ => {}
        }
        let linear = linear_of_bytes();
        for Color(parts) in &mut self.colors {
            *parts = parts.map(|part| linear[usize::from(part as u8)]);
        }
        self.note("its colours are whole numbers up to 255, read as sRGB like #rrggbb");
        Ok(None)
    }

    fn color_by(&mut self, name: &str, layout: &Layout) -> Result<Coloring> {
        if layout.has_vector {
            for Color(parts) in &mut self.colors {
                *parts = [DVec3::from_array(*parts).length(); 3];
            }
        }
        let CloudKeys { colormap, range, missing_color, .. } = *self.source.keys;
        let coloring = Coloring::paint(
            layout.color_by.clone(),
            colormap.unwrap_or_default(),
            range,
            missing_color.unwrap_or(Coloring::MISSING_COLOR),
            &mut self.colors,
        );
        let coloring = coloring.ok_or_else(|| {
            let found = format!("the column {:?} has no number", quoted(name));
            let help = "colour by another column, or give the `range` that it would have";
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
