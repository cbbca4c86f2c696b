//! A scene file while it is changed: wishes become its keys, and all else stays as it was written.

use std::path::{Path, PathBuf};

use glam::DVec3;
use toml_edit::{Array, DocumentMut, InlineTable, Item, Table, TableLike, Value};

use super::wishes::{framing_lens, usual_up};
use super::write::checked;
use super::{Camera, Light, Paint, Projection, Samples, Sky, Source, WishedLens, Wishes};
use crate::error::{Error, Result};
use crate::plain::Shown;
use crate::plain::steers;

/// Size of a picture of data.
pub(super) const SIZE: [u32; 2] = [1280, 720];

/// Samples across and down a pixel of a picture of data.
pub(super) const SAMPLES: Samples = Samples::nearest(2);

/// The scene of a data file before any wish. Its light is bright where a surface faces the eye, never
/// brighter than its colour, and darker in hollows. A sky of 16 directions costs a quarter of one of 64,
/// and looks the same at a glance: see the guide, "Pictures from data".
pub(super) const OF_DATA: &str = "\
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
pub(super) const COLOR: &str = "#8fb4d9";

/// A scene file while it is changed.
pub(super) struct Draft {
    document: DocumentMut,
}

impl Draft {
    /// The scene file at `path` with this text.
    pub(super) fn new(text: &str, path: &Path) -> Result<Draft> {
        // Of a scene that can be read, but not changed: nobody knows of one.
        let odd = |_| {
            let path = path.shown();
            let help = "options can't be written into this scene; change it by hand";
            Error::Usage(format!("{path}: {help}"))
        };
        Ok(Draft { document: text.parse().map_err(odd)? })
    }

    /// Its text.
    pub(super) fn text(&self) -> String {
        self.document.to_string()
    }

    /// Its text without a camera that is still empty: something else is read first.
    pub(super) fn text_so_far(&self) -> String {
        let mut document = self.document.clone();
        if document.get("camera").and_then(Item::as_table).is_some_and(Table::is_empty) {
            document.remove("camera");
        }
        document.to_string()
    }

    /// Writes the wishes into it.
    ///
    /// # Errors
    /// [`Error::Usage`] for wishes that can't be.
    pub(super) fn apply(&mut self, wishes: &Wishes, path: &Path, of_data: bool) -> Result<()> {
        if wishes.frame() && wishes.position.is_some() {
            return Err(Error::Usage(
                "a position says where the camera is, but a view, a margin or an automatic height \
                 choose it so that everything is in the picture; leave one of them out"
                    .into(),
            ));
        }
        if of_data {
            let name = path.file_name().map(PathBuf::from).unwrap_or_default();
            self.clouds().into_iter().try_for_each(|cloud| set_file(cloud, &name))?;
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
                path.shown()
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

    /// Writes all of a camera.
    pub(super) fn set_camera(&mut self, camera: &Camera) {
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

    /// Writes the picture's columns and rows, and the samples across and down a pixel.
    pub(super) fn set_image(&mut self, size: Option<[u32; 2]>, samples: Option<Samples>) {
        if size.is_none() && samples.is_none() {
            return;
        }
        let Some(image) = self.table("image") else { return };
        if let Some([width, height]) = size {
            set(image, "width", i64::from(width));
            set(image, "height", i64::from(height));
        }
        if let Some(samples) = samples {
            set(image, "samples", i64::from(samples.across()));
        }
    }

    /// The table with this name, made where there is none. `None` for what is no table: reading it tells.
    fn table(&mut self, key: &str) -> Option<&mut dyn TableLike> {
        let item = self.document.entry(key).or_insert(Item::Table(Table::new()));
        item.as_table_like_mut()
    }

    /// All clouds, which stand under headers or in a list.
    pub(super) fn clouds(&mut self) -> Vec<&mut dyn TableLike> {
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

    /// Sets a key of the first cloud.
    pub(super) fn set_of_cloud(&mut self, key: &str, value: impl Into<Value>) {
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

/// The file that a cloud names.
pub(super) fn file_of(cloud: &dyn TableLike) -> Option<&str> {
    cloud.get("file").and_then(Item::as_str)
}

/// Lets a cloud name this file.
///
/// # Errors
/// [`Error::Usage`] for a path that has no place in a text.
pub(super) fn set_file(cloud: &mut dyn TableLike, path: &Path) -> Result<()> {
    let Some(path) = path.to_str() else {
        let message = format!("{}: a scene can name only a file in UTF-8", path.shown());
        return Err(Error::Usage(message));
    };
    set(cloud, "file", text_value(path)?);
    Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::DataWishes;

    fn draft(text: &str, wishes: &Wishes, path: &str) -> String {
        let mut draft = Draft::new(text, Path::new(path)).unwrap();
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
