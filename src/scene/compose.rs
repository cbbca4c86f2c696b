//! A scene that is put together from a scene file or from data, and from options.
//!
//! The result is a text that a scene file could have, and it is read as scene files are: what a picture
//! shows is what the text says. Two things are found by looking at the spheres, and then written into
//! it: a camera that frames them, and the radius of spheres that have none.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::document::{OF_DATA, SIZE, SceneDocument, file_of, folder_of, lay, seen_from, usual};
use super::framing::bounds;
use super::neighbours::usual_radius;
use super::open::InputReader;
use super::overrides::usual_up;
use super::schema::{CameraKeys, CloudKeys, ImageKeys};
use super::sniff::{Content, recognize};
use super::{Camera, Framing, InputFormat, MAX_SIDE, Scene, SceneOverrides, Viewpoint};
use crate::error::{Error, Hint, Message, Result, SceneError, Setting, wrong_usage};
use crate::output::OutputFile;
use crate::plain::Shown;
use crate::support::control::Control;
use crate::words::joined;

/// A scene as it was put together.
#[derive(Debug)]
pub struct Composed {
    /// The scene.
    pub scene: Scene,
    /// Notes of what was chosen by default.
    pub notes: Vec<Message>,
    /// The file that it came from.
    path: PathBuf,
    /// Whether that file is data.
    of_data: bool,
    text: String,
    image: ImageKeys,
}

/// Reads the scene or the data at `path` with these options. `control` counts the bytes of data, and can stop the reading.
/// Where data, or a scene of which anything is asked, have no camera, one is placed so that it frames all spheres.
///
/// # Errors
/// Those of [`super::read_scene`]; [`Error::Usage`] for options that can't be; [`Error::Interrupted`].
pub fn compose_scene(
    path: &Path,
    overrides: &SceneOverrides,
    control: &Control,
) -> Result<Composed> {
    compose(InputReader::new(control), path, overrides)
}

/// Reads the scene or the data at `path` as [`compose_scene`] does, for those who do it again while they watch the file: what is no
/// regular file, the scene's or a cloud's, is an error, for it could keep its reader for ever.
///
/// # Errors
/// As [`compose_scene`].
pub fn recompose_scene(
    path: &Path,
    overrides: &SceneOverrides,
    control: &Control,
) -> Result<Composed> {
    compose(InputReader { only_regular: true, ..InputReader::new(control) }, path, overrides)
}

fn compose(reader: InputReader, path: &Path, overrides: &SceneOverrides) -> Result<Composed> {
    let input = reader.open_scene(path)?;
    let content = match overrides.input_format {
        None => recognize(input.head(), path),
        Some(InputFormat::Scene) => Content::Scene,
        Some(InputFormat::Data(format)) => Content::Data(format),
    };
    let (mut text, opened, of_data) = match content {
        Content::Scene => (reader.text_of(input, path)?, None, false),
        Content::Data(_) => (OF_DATA.to_owned(), Some(input), true),
        Content::Foreign(foreign) => {
            let message = format!("expected a scene or data, found {}", foreign.what);
            return Err(SceneError::whole_file(path, message, foreign.hint(path)).into());
        }
    };
    let opened = RefCell::new(opened);
    let reader = InputReader { opened: of_data.then_some((path, &opened)), ..reader };
    let mut notes = Vec::new();
    let is_as_written = !of_data && overrides.leave_the_text();
    let mut scene = if is_as_written {
        reader.parse(&text, path)?.0
    } else {
        // What is wrong in the text itself, the reader reports.
        let mut document = SceneDocument::new(&text, path)
            .or_else(|odd| reader.parse(&text, path).and(Err(odd)))?;
        document.apply(overrides, path, of_data)?;
        let usual = usual();
        let reader = InputReader { usual: of_data.then_some(&usual), ..reader };
        let read = reader.parse(&document.text_so_far(), path);
        let (mut scene, chosen) = read.map_err(|error| of_document(error, path, of_data))?;
        notes.extend(choose(&mut scene, chosen, &mut document));
        text = document.text();
        scene
    };
    if of_data && scene.spheres.is_empty() {
        let help = "give a row or a line for each sphere";
        return Err(SceneError::whole_file(path, "the data have no sphere", help).into());
    }
    let lacks_camera = scene.camera.is_none() && (overrides.needs_camera || !is_as_written);
    if lacks_camera || overrides.frame() {
        let camera = place_camera(&scene, overrides, path, reader.control)?;
        let mut document = SceneDocument::new(&text, path)?;
        document.set("camera", &CameraKeys::from(&camera));
        text = document.text();
        if !of_data && scene.camera.is_none() {
            let name = path.shown();
            notes.push(
                format!("{name}: the scene has no [camera]; this one frames all spheres").into(),
            );
        }
        scene.camera = Some(camera);
    }
    // As the text will have them.
    let is_possible = |size: &[u32; 2]| size.iter().all(|side| (1..=MAX_SIDE).contains(side));
    let size = overrides.size.filter(is_possible);
    scene.image = size.or(scene.image);
    scene.samples = overrides.samples.or(scene.samples);
    let image = ImageKeys::new(size, overrides.samples);
    Ok(Composed { scene, notes, path: path.to_owned(), of_data, text, image })
}

impl Composed {
    /// The text of a scene file at `place` that means this scene: the names of its clouds lead there from
    /// that place, or from anywhere where it is `None`. Read, it is the same scene.
    ///
    /// # Errors
    /// [`Error::Io`] for a folder that is not there; [`Error::Usage`] for a path that has no place in a
    /// text.
    pub fn text(&self, place: Option<&Path>) -> Result<String> {
        if self.of_data && self.path.as_os_str() == OutputFile::STDOUT {
            let hint = "save them as a file, and give its path";
            return wrong_usage(Message::new(
                "a scene cannot name data that come from standard input",
                hint,
            ));
        }
        let mut document = SceneDocument::new(&self.text, &self.path)?;
        if self.image != ImageKeys::default() {
            document.set("image", &self.image);
        }
        let here = folder_of(&self.path)?;
        for cloud in document.clouds() {
            let Some(name) = file_of(cloud) else { continue };
            let file = here.join(name);
            let name = match place {
                // What leads there from this folder, still does.
                Some(place) if folder_of(place)? == here => continue,
                Some(place) => seen_from(place, &file)?,
                None => file.canonicalize().map_err(Error::io(&file))?,
            };
            lay(cloud, &CloudKeys::of_file(&name)?);
        }
        Ok(document.text())
    }
}

/// A camera for a scene without one, or one that frames a scene anew, by what the options say of the camera and
/// of the picture's size. `path` is for messages.
///
/// # Errors
/// [`Error::Scene`] where there is no sphere to be framed; [`Error::Usage`] for options that can't be;
/// [`Error::Interrupted`] when `control` was cancelled.
pub fn place_camera(
    scene: &Scene,
    overrides: &SceneOverrides,
    path: &Path,
    control: &Control,
) -> Result<Camera> {
    let of_scene = scene.camera.as_ref();
    if scene.spheres.is_empty() && of_scene.is_none() {
        return scene.require_camera(path).cloned();
    }
    let above = overrides.camera.up.or(of_scene.map(|camera| camera.up)).unwrap_or(DVec3::Y);
    // Seen along `up` itself, another direction is up in the picture.
    let up = |from| usual_up(from, above);
    let projection = overrides.projection(of_scene.map(|camera| camera.projection));
    if let Some(position) = overrides.camera.position {
        // With a `look_at` as well, the text has all of it.
        let look_at = bounds(&scene.spheres)?.0;
        return Camera { position, look_at, up: up(position - look_at), projection }.check();
    }
    let from = match (overrides.view, of_scene) {
        (None, Some(camera)) => camera.position - camera.look_at,
        (view, _) => view.unwrap_or(Viewpoint::QUARTER).direction(above),
    };
    let framing = Framing {
        from,
        up: up(from),
        projection,
        fits_height: overrides.camera.height.is_none(),
        size: overrides.size.or(scene.image).unwrap_or(SIZE),
        margin: overrides.margin.unwrap_or(Framing::MARGIN),
        look_at: overrides.camera.look_at,
        n_turns: overrides.n_turns,
    };
    Camera { position: from, look_at: DVec3::ZERO, up: framing.up, projection }.check()?;
    framing.camera(&scene.spheres, control)?.check()
}

/// Writes down what was chosen for data, where spheres without a radius get theirs. What is to be told of it is returned.
fn choose(
    scene: &mut Scene,
    mut chosen: CloudKeys,
    document: &mut SceneDocument,
) -> Option<Message> {
    if let Some(radius) = &mut chosen.radius {
        *radius = with_three_digits(usual_radius(&scene.spheres));
        scene.spheres.iter_mut().for_each(|sphere| sphere.radius = *radius);
    }
    document.clouds().into_iter().for_each(|cloud| lay(cloud, &chosen));
    let radius = chosen.radius?;
    let reason = match scene.spheres.len() {
        0 | 1 => "",
        _ => ", half the median distance between neighbours",
    };
    let unused: Vec<&String> =
        scene.clouds.iter().flat_map(|cloud| &cloud.unused_columns).collect();
    let columns = match unused.len() {
        0 => String::new(),
        _ => {
            format!(" (columns not used: {})", joined(unused.iter().map(|name| name.shown()), ", "))
        }
    };
    let text =
        format!("no column is known as the radius{columns}: each sphere gets {radius:?}{reason}");
    Some(Message::new(text, Hint::new("{} gives another one", [Setting::named("radius")])))
}

/// Returns the error of a text that the user has not seen.
fn of_document(error: Error, path: &Path, of_data: bool) -> Error {
    let Error::Scene(error) = error else { return error };
    let (text, span, line, column) = (String::new(), 0..0, 0, 0);
    let path = match of_data {
        // The subject has the place in the data; places in the text are of no use.
        true => path.to_owned(),
        false => {
            return Box::new(SceneError {
                path: format!("{}, with the options", path.shown()).into(),
                ..*error
            })
            .into();
        }
    };
    Box::new(SceneError { path, text, span, line, column, ..*error }).into()
}

/// The nearest number with three digits, which a scene can name shortly.
fn with_three_digits(number: f64) -> f64 {
    format!("{number:.2e}").parse().unwrap_or(number)
}
