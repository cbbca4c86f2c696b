//! A scene that is put together from a scene file or from data, and from wishes.
//!
//! The result is a text that a scene file could have, and it is read as scene files are: what a picture
//! shows is what the text says. Two things are found by looking at the spheres, and then written into
//! it: a camera that frames them, and the radius of spheres that have none.

use std::path::{Path, PathBuf};

use glam::DVec3;
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, TableLike, Value};

use super::clouds::is_cloud_file;
use super::framing::{USUAL_FOV_DEGREES, bounds};
use super::neighbours::usual_radius;
use super::open::Files;
use super::read::{parse_scene_from, text_of};
use super::wishes::usual_up;
use super::write::{camera_text, folder_of, seen_from};
use super::{
    Camera, Framing, FramingLens, ImageSize, Light, Paint, Projection, Scene, Sky, Source,
    WishedLens, Wishes, parse_scene,
};
use crate::control::Control;
use crate::error::{Error, Lack, Result, SceneError};
use crate::plain::steers;

/// Size of a picture of data.
const SIZE: [u32; 2] = [1280, 720];

/// Samples across and down a pixel of a picture of data.
const SAMPLES: u32 = 2;

/// The scene of a data file before any wish. Its light is bright where a surface faces the eye, never
/// brighter than its colour, and darker in hollows. A sky of 16 directions costs a quarter of one of 64,
/// and looks the same at a glance: see the guide, "Pictures from data".
const OF_DATA: &str = "\
background = \"#20242c\"

[camera]

[image]

[[light]]
position  = \"eye\"
intensity = 0.6
shadows   = false  # nothing that the eye sees is in its shadow

[sky]
intensity  = 0.4
directions = 16

[[spheres]]
";

/// The colour of spheres that have none.
const COLOR: &str = "#8fb4d9";

/// A scene as it was put together.
#[derive(Debug)]
pub struct Composed {
    /// The scene.
    pub scene: Scene,
    /// What was chosen because nobody said it, a sentence each.
    pub notes: Vec<String>,
    /// The file that it came from.
    path: PathBuf,
    text: String,
    size: Option<[u32; 2]>,
    samples: Option<u32>,
}

/// Reads the scene or the data at `path` with these wishes. Where there is no camera, one is placed so
/// that it frames all spheres.
///
/// # Errors
/// Those of [`super::read_scene_with`]; [`Error::Usage`] for wishes that can't be.
pub fn compose_scene(path: &Path, wishes: &Wishes, control: &Control) -> Result<Composed> {
    compose(Files::All, path, wishes, control)
}

/// As [`compose_scene`], for those who do it again while they watch the file, as
/// [`super::reread_scene`].
///
/// # Errors
/// As [`compose_scene`].
pub fn recompose_scene(path: &Path, wishes: &Wishes, control: &Control) -> Result<Composed> {
    compose(Files::Regular, path, wishes, control)
}

fn compose(files: Files, path: &Path, wishes: &Wishes, control: &Control) -> Result<Composed> {
    let of_data = is_cloud_file(path);
    let text = if of_data { OF_DATA.to_owned() } else { text_of(files, path)? };
    let read = |text: &str| parse_scene_from(files, text, path, control);
    let is_as_written = !of_data && wishes.leave_the_text();
    let (mut scene, mut notes, mut text) = match is_as_written {
        true => (read(&text)?, Vec::new(), text),
        false => {
            // What is wrong in the text itself, the reader tells.
            let document = parsed(&text, path).or_else(|odd| read(&text).and(Err(odd)))?;
            let mut draft = Draft { document };
            draft.apply(wishes, path, of_data)?;
            let (scene, notes) =
                draft.read(of_data, read).map_err(|error| of_draft(error, path, of_data))?;
            (scene, notes, draft.text())
        }
    };
    if of_data && scene.spheres.is_empty() {
        let help = "give a row or a line for each sphere";
        return Err(SceneError::whole_file(path, "there is no sphere in it", help).into());
    }
    if scene.camera.is_none() || wishes.frame() {
        let camera = place_camera(&scene, wishes, path)?;
        let mut draft = Draft { document: parsed(&text, path)? };
        draft.set_camera(&camera);
        text = draft.text();
        if !of_data && scene.camera.is_none() {
            notes.push(format!(
                "{}: the scene has no [camera]; this one frames all spheres",
                path.display()
            ));
        }
        scene.camera = Some(camera);
    }
    // As the text will have them.
    let is_possible = |size: &[u32; 2]| size.iter().all(|s| (1..=ImageSize::MAX_SIDE).contains(s));
    let size = wishes.size.filter(is_possible);
    if let Some([width, height]) = size {
        scene.image = Some(ImageSize { width, height });
    }
    scene.samples = wishes.samples.or(scene.samples);
    Ok(Composed { scene, notes, path: path.to_owned(), text, size, samples: wishes.samples })
}

impl Composed {
    /// The text of a scene file at `place` that means this scene: the names of its clouds lead there from
    /// that place, or from anywhere where it is `None`. Read, it is the same scene.
    ///
    /// # Errors
    /// [`Error::Io`] for a folder that is not there; [`Error::Usage`] for a path that has no place in a
    /// text.
    pub fn text(&self, place: Option<&Path>) -> Result<String> {
        let mut draft = Draft { document: parsed(&self.text, &self.path)? };
        draft.set_image(self.size, self.samples);
        let here = folder_of(&self.path)?;
        for cloud in draft.clouds() {
            let Some(name) = cloud.get("file").and_then(Item::as_str) else { continue };
            let file = here.join(name);
            let name = match place {
                // What leads there from this folder, still does.
                Some(place) if folder_of(place)? == here => continue,
                Some(place) => seen_from(place, &file)?,
                None => file.canonicalize().map_err(Error::io(&file))?,
            };
            set(cloud, "file", path_value(&name)?);
        }
        Ok(draft.text())
    }
}

/// A camera for a scene without one, or one that frames a scene anew, by what the wishes say of the camera and
/// of the picture's size. `path` is for messages.
///
/// # Errors
/// [`Error::Scene`] where there is no sphere to be framed; [`Error::Usage`] for wishes that can't be.
pub fn place_camera(scene: &Scene, wishes: &Wishes, path: &Path) -> Result<Camera> {
    let of_scene = scene.camera.as_ref();
    if scene.spheres.is_empty() && of_scene.is_none() {
        return scene.require_camera(path).cloned();
    }
    let above = wishes.up.or(of_scene.map(|camera| camera.up)).unwrap_or(DVec3::Y);
    let up = |from| wishes.up.unwrap_or_else(|| usual_up(from, above));
    let lens = framing_lens(wishes.lens, of_scene.map(|camera| camera.projection));
    if let Some(position) = wishes.position {
        // With a `look_at` as well, the text has all of it.
        let look_at = bounds(&scene.spheres)?.0;
        let projection = lens.projection();
        return checked(Camera { position, look_at, up: up(position - look_at), projection });
    }
    let from = match (wishes.view, of_scene) {
        (None, Some(camera)) => camera.position - camera.look_at,
        (view, _) => view.unwrap_or_default().direction(above),
    };
    let framing = Framing {
        from,
        up: up(from),
        lens,
        size: wishes.size.or(scene.image.map(|i| [i.width, i.height])).unwrap_or(SIZE),
        margin: wishes.margin.unwrap_or(Framing::MARGIN),
        look_at: wishes.look_at,
        n_turns: wishes.n_turns,
    };
    checked(Camera {
        position: from,
        look_at: DVec3::ZERO,
        up: framing.up,
        projection: lens.projection(),
    })?;
    checked(framing.camera(&scene.spheres)?)
}

fn framing_lens(wished: Option<WishedLens>, of_scene: Option<Projection>) -> FramingLens {
    match (wished, of_scene) {
        (Some(WishedLens::Fov(fov_degrees)), _) => FramingLens::Perspective { fov_degrees },
        (Some(WishedLens::Height(height)), _) => FramingLens::Orthographic { height: Some(height) },
        (Some(WishedLens::AnyHeight), _) | (None, Some(Projection::Orthographic { .. })) => {
            FramingLens::Orthographic { height: None }
        }
        (None, Some(Projection::Perspective { fov_degrees })) => {
            FramingLens::Perspective { fov_degrees }
        }
        (None, None) => FramingLens::Perspective { fov_degrees: USUAL_FOV_DEGREES },
    }
}

/// A camera that a scene file may have.
///
/// # Errors
/// [`Error::Usage`] in the words of the scene reader.
pub(crate) fn checked(camera: Camera) -> Result<Camera> {
    match parse_scene(&camera_text(&camera), Path::new("the camera")) {
        Ok(_) => Ok(camera),
        Err(Error::Scene(error)) => {
            let SceneError { message, help, .. } = *error;
            Err(Error::Usage(format!("the camera: {message}; {help}")))
        }
        Err(error) => Err(error),
    }
}

/// A scene file while it is changed.
struct Draft {
    document: DocumentMut,
}

impl Draft {
    fn text(&self) -> String {
        self.document.to_string()
    }

    /// The scene, with what data may lack: it is chosen, written into the text, and told.
    fn read(
        &mut self,
        of_data: bool,
        read: impl Fn(&str) -> Result<Scene>,
    ) -> Result<(Scene, Vec<String>)> {
        let (mut lacks_radius, mut notes) = (false, Vec::new());
        let mut scene = loop {
            let mut document = self.document.clone();
            if document.get("camera").and_then(Item::as_table).is_some_and(Table::is_empty) {
                document.remove("camera");
            }
            match read(&document.to_string()) {
                Err(Error::Scene(error)) if of_data && error.lacks == Some(Lack::Radius) => {
                    // Any, until the spheres are there.
                    lacks_radius = true;
                    self.set_of_cloud("radius", 1.0);
                }
                Err(Error::Scene(error)) if of_data && error.lacks == Some(Lack::Color) => {
                    self.set_of_cloud("color", COLOR);
                }
                read => break read?,
            }
        };
        if lacks_radius {
            let radius = with_three_digits(usual_radius(&scene.spheres));
            self.set_of_cloud("radius", radius);
            scene.spheres.iter_mut().for_each(|sphere| sphere.radius = radius);
            notes.push(format!(
                "the data have no radius: each sphere gets {radius:?}, half the median distance \
                 between neighbours; --radius says another"
            ));
        }
        Ok((scene, notes))
    }

    fn apply(&mut self, wishes: &Wishes, path: &Path, of_data: bool) -> Result<()> {
        if wishes.frame() && wishes.position.is_some() {
            return Err(Error::Usage(
                "--position says where the camera is, but --view, --margin and --height auto choose \
                 it so that everything is in the picture; leave one of them out"
                    .into(),
            ));
        }
        if of_data {
            let name = path.file_name().map(PathBuf::from).unwrap_or_default();
            self.set_of_cloud("file", path_value(&name)?);
            self.set_image(Some(SIZE), Some(SAMPLES));
            self.set_image(wishes.size, wishes.samples);
        }
        self.apply_to_camera(wishes, of_data)?;
        if let Some(background) = &wishes.background {
            set(self.document.as_table_mut(), "background", background);
        }
        match &wishes.ambient {
            None => {}
            Some(Some(light)) => set(self.document.as_table_mut(), "ambient", light),
            Some(None) => drop(self.document.remove("ambient")),
        }
        if let Some(lights) = &wishes.lights {
            let tables = lights.iter().map(light_table).collect();
            self.replace("light", (!lights.is_empty()).then_some(Item::ArrayOfTables(tables)));
        }
        if let Some(sky) = wishes.sky {
            self.replace("sky", sky.map(|sky| Item::Table(sky_table(&sky))));
        }
        self.apply_to_cloud(wishes, path)
    }

    /// Writes what is said of a camera that is not placed by itself.
    fn apply_to_camera(&mut self, wishes: &Wishes, of_data: bool) -> Result<()> {
        let has_camera = !of_data && self.document.contains_key("camera");
        let &Wishes { position, look_at, up, lens, .. } = wishes;
        if wishes.frame() {
            return Ok(());
        }
        if !has_camera {
            if let (Some(position), Some(look_at)) = (position, look_at) {
                let projection = framing_lens(lens, None).projection();
                let up = up.unwrap_or_else(|| usual_up(position - look_at, DVec3::Y));
                self.set_camera(&checked(Camera { position, look_at, up, projection })?);
            }
            return Ok(());
        }
        let Some(camera) = self.table("camera") else { return Ok(()) };
        for (key, vector) in [("position", position), ("look_at", look_at), ("up", up)] {
            if let Some(vector) = vector {
                set(camera, key, numbers(vector));
            }
        }
        match lens {
            Some(WishedLens::Fov(fov)) => set_one(camera, ["fov", "height"], fov),
            Some(WishedLens::Height(height)) => set_one(camera, ["height", "fov"], height),
            Some(WishedLens::AnyHeight) | None => {}
        }
        Ok(())
    }

    fn apply_to_cloud(&mut self, wishes: &Wishes, path: &Path) -> Result<()> {
        let data = &wishes.data;
        if *data == Default::default() {
            return Ok(());
        }
        let mut clouds = self.clouds();
        let n_clouds = clouds.len();
        let [cloud] = &mut clouds[..] else {
            return Err(Error::Usage(format!(
                "{}: --radius, --color, --color-by, --colormap, --range, --columns and --frame are for \
                 data, or for a scene with one [[spheres]], but this one has {n_clouds}; change the \
                 scene itself",
                path.display()
            )));
        };
        if let Some(radius) = data.radius {
            set(*cloud, "radius", radius);
        }
        if let Some(color) = &data.color {
            for key in ["color_by", "colormap", "range"] {
                cloud.remove(key);
            }
            set(*cloud, "color", color);
        }
        if let Some(column) = &data.color_by {
            cloud.remove("color");
            set(*cloud, "color_by", text_value(column)?);
        }
        if let Some(name) = &data.colormap {
            set(*cloud, "colormap", text_value(name)?);
        }
        if let Some(range) = data.range {
            set(*cloud, "range", Array::from_iter(range));
        }
        if !data.columns.is_empty() {
            let mut columns = InlineTable::new();
            for (column, name) in &data.columns {
                columns.insert(column, text_value(name)?);
            }
            set(*cloud, "columns", columns);
        }
        if let Some(frame) = data.frame {
            set(*cloud, "frame", i64::from(frame));
        }
        Ok(())
    }

    fn set_camera(&mut self, camera: &Camera) {
        let Some(table) = self.table("camera") else { return };
        set(table, "position", numbers(camera.position));
        set(table, "look_at", numbers(camera.look_at));
        set(table, "up", numbers(camera.up));
        match camera.projection {
            Projection::Perspective { fov_degrees } => {
                set_one(table, ["fov", "height"], fov_degrees);
            }
            Projection::Orthographic { height } => set_one(table, ["height", "fov"], height),
        }
    }

    fn set_image(&mut self, size: Option<[u32; 2]>, samples: Option<u32>) {
        if size.is_none() && samples.is_none() {
            return;
        }
        let Some(image) = self.table("image") else { return };
        if let Some([width, height]) = size {
            set(image, "width", i64::from(width));
            set(image, "height", i64::from(height));
        }
        if let Some(samples) = samples {
            set(image, "samples", i64::from(samples));
        }
    }

    /// The table with this name, made where there is none. `None` for what is no table: reading it tells.
    fn table(&mut self, key: &str) -> Option<&mut dyn TableLike> {
        let item = self.document.entry(key).or_insert(Item::Table(Table::new()));
        item.as_table_like_mut()
    }

    /// All clouds, which stand under headers or in a list.
    fn clouds(&mut self) -> Vec<&mut dyn TableLike> {
        match self.document.get_mut("spheres") {
            Some(Item::ArrayOfTables(tables)) => {
                tables.iter_mut().map(|table| table as &mut dyn TableLike).collect()
            }
            Some(Item::Value(Value::Array(values))) => values
                .iter_mut()
                .filter_map(Value::as_inline_table_mut)
                .map(|table| table as &mut dyn TableLike)
                .collect(),
            _ => Vec::new(),
        }
    }

    fn set_of_cloud(&mut self, key: &str, value: impl Into<Value>) {
        if let Some(cloud) = self.clouds().into_iter().next() {
            set(cloud, key, value);
        }
    }

    /// Puts a table or tables in the place of those with this name.
    fn replace(&mut self, key: &str, new: Option<Item>) {
        let old = self.document.remove(key);
        let place = match &old {
            Some(Item::Table(table)) => table.position(),
            Some(Item::ArrayOfTables(tables)) => tables.iter().next().and_then(Table::position),
            _ => None,
        };
        let Some(mut new) = new else { return };
        match &mut new {
            Item::Table(table) => table.set_position(place),
            Item::ArrayOfTables(tables) => {
                tables.iter_mut().for_each(|table| table.set_position(place));
            }
            _ => {}
        }
        self.document.insert(key, new);
    }
}

/// Sets a value and keeps the spaces and the comment beside it.
fn set(table: &mut dyn TableLike, key: &str, value: impl Into<Value>) {
    let mut value = value.into();
    let Some(item) = table.get_mut(key) else {
        table.insert(key, Item::Value(value));
        return;
    };
    if let Some(old) = item.as_value() {
        *value.decor_mut() = old.decor().clone();
    }
    *item = Item::Value(value);
}

/// Sets one of two keys of which a table has but one.
fn set_one(table: &mut dyn TableLike, [key, other]: [&str; 2], value: impl Into<Value>) {
    table.remove(other);
    set(table, key, value);
}

fn numbers(vector: DVec3) -> Array {
    Array::from_iter(vector.to_array())
}

impl From<&Paint> for Value {
    fn from(paint: &Paint) -> Value {
        match paint {
            Paint::Text(text) => Value::from(text.as_str()),
            Paint::Linear(linear) => Value::Array(Array::from_iter(*linear)),
            Paint::Grey(light) => Value::from(*light),
        }
    }
}

fn light_table(light: &Light) -> Table {
    let mut table = Table::new();
    let Light { source, color, intensity, shadows } = light;
    match source {
        Source::Eye => set(&mut table, "position", "eye"),
        Source::Point(point) => set(&mut table, "position", numbers(*point)),
        Source::Sun(direction) => set(&mut table, "direction", numbers(*direction)),
    }
    if color.0 != [1.0; 3] {
        set(&mut table, "color", Array::from_iter(color.0));
    }
    set(&mut table, "intensity", *intensity);
    if !shadows {
        set(&mut table, "shadows", false);
    }
    table
}

fn sky_table(sky: &Sky) -> Table {
    let mut table = Table::new();
    set(&mut table, "intensity", sky.intensity);
    set(&mut table, "directions", i64::from(sky.directions));
    table
}

/// A path as a scene names it.
fn path_value(path: &Path) -> Result<Value> {
    let Some(path) = path.to_str() else {
        let message = format!("{}: a scene can name only a file in UTF-8", path.display());
        return Err(Error::Usage(message));
    };
    text_value(path)
}

/// A text in double quotes, in which everything that steers a terminal is escaped.
fn text_value(text: &str) -> Result<Value> {
    let mut quoted = String::from('"');
    for c in text.chars() {
        match c {
            '"' | '\\' => quoted.extend(['\\', c]),
            '\n' => quoted += "\\n",
            '\t' => quoted += "\\t",
            c if steers(c) => quoted += &format!("\\u{:04x}", u32::from(c)),
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    let wrong = |_| Error::Usage(format!("{text:?} has no place in a scene file"));
    quoted.parse::<Value>().map_err(wrong)
}

/// The nearest number with three digits, which a scene can name shortly.
fn with_three_digits(number: f64) -> f64 {
    format!("{number:.2e}").parse().unwrap_or(number)
}

fn parsed(text: &str, path: &Path) -> Result<DocumentMut> {
    text.parse().map_err(|_| odd(path))
}

/// Of a scene that can be read, but not changed: nobody knows of one.
fn odd(path: &Path) -> Error {
    let path = path.display();
    Error::Usage(format!("{path}: options can't be written into this scene; change it by hand"))
}

/// An error in a text that the user never saw.
fn of_draft(error: Error, path: &Path, of_data: bool) -> Error {
    let Error::Scene(error) = error else { return error };
    let name = path.display().to_string();
    if !of_data {
        let path = format!("{name}, with the options").into();
        return Box::new(SceneError { path, ..*error }).into();
    }
    // Of data, places in the text say nothing: the message names the file and the line.
    let message = error.message.strip_prefix(&format!("{name}: ")).unwrap_or(&error.message);
    SceneError::whole_file(path, message, error.help.as_str()).into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::DataWishes;

    fn draft(text: &str, wishes: &Wishes, path: &str) -> String {
        let mut draft = Draft { document: parsed(text, Path::new(path)).unwrap() };
        draft.apply(wishes, Path::new(path), text == OF_DATA).unwrap();
        draft.text()
    }

    #[test]
    fn all_keys_of_data_are_written_and_exclude_each_other() {
        let by_column = DataWishes {
            color_by: Some("speed".into()),
            colormap: Some("viridis".into()),
            range: Some([0.0, 2.5]),
            columns: vec![("radius".into(), "R".into()), ("x".into(), "px".into())],
            frame: Some(3),
            ..DataWishes::default()
        };
        let wishes = Wishes { data: by_column, ..Wishes::default() };
        let text = draft(OF_DATA, &wishes, "a/heap.csv");
        for line in [
            "file = \"heap.csv\"",
            "color_by = \"speed\"",
            "colormap = \"viridis\"",
            "range = [0.0, 2.5]",
            "columns = { radius = \"R\", x = \"px\" }",
            "frame = 3",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}:\n{text}");
        }
        let color = Some(Paint::Text("#ff0000".into()));
        let plain = DataWishes { color, ..DataWishes::default() };
        let colored = draft(
            &text.replace("[camera]\n", ""),
            &Wishes { data: plain, ..Wishes::default() },
            "a.toml",
        );
        assert!(
            colored.contains("color = \"#ff0000\"") && !colored.contains("color_by"),
            "{colored}"
        );
        let again = draft(&colored, &wishes, "a.toml");
        assert!(again.contains("color_by") && !again.contains("color = "), "{again}");
    }

    #[test]
    fn tables_stay_in_their_order() {
        let sky = Some(Some(Sky { intensity: 0.5, directions: 8 }));
        let light = Light {
            source: Source::Sun(DVec3::NEG_Y),
            color: [1.0, 0.5, 0.0].into(),
            intensity: 0.5,
            shadows: false,
        };
        let lights = Some(vec![light, light]);
        let text = draft(OF_DATA, &Wishes { sky, lights, ..Wishes::default() }, "heap.csv");
        let headers: Vec<&str> = text.lines().filter(|line| line.starts_with('[')).collect();
        let expected = ["[camera]", "[image]", "[[light]]", "[[light]]", "[sky]", "[[spheres]]"];
        assert_eq!(headers, expected, "{text}");
        assert!(
            text.contains("color = [1.0, 0.5, 0.0]") && text.contains("shadows = false"),
            "{text}"
        );
        // In a list of a line as well.
        let listed = "spheres = [{ file = \"a.npy\", radius = 1 }]\n";
        let data = DataWishes { radius: Some(2.0), ..DataWishes::default() };
        let text = draft(listed, &Wishes { data, ..Wishes::default() }, "a.toml");
        assert_eq!(text, "spheres = [{ file = \"a.npy\", radius = 2.0 }]\n");
    }

    #[test]
    fn any_name_has_its_place() {
        for name in ["a\"b\\c", "\u{202e}\u{1b}[31m\n\t", "it's", "ü → 球"] {
            let value = text_value(name).unwrap();
            assert_eq!(value.as_str(), Some(name));
            assert!(!value.to_string().contains(steers), "{name:?}");
        }
    }
}
