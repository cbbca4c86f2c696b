//! A scene file while it is changed: options become its keys, and all else stays as it was written.

use std::path::{Path, PathBuf};

use glam::DVec3;
use toml_edit::{DocumentMut, Item, Table, TableLike, Value};

use super::overrides::usual_up;
use super::schema::{CameraKeys, CloudKeys, ImageKeys, SceneKeys, Section};
use super::{Camera, Color, InputFormat, Samples, SceneOverrides};
use crate::error::{Error, Hint, Message, Result, Setting, wrong_usage};
use crate::output;
use crate::plain::Shown;

/// Size of a picture of data.
pub(super) const SIZE: [u32; 2] = [1280, 720];

/// Samples across and down a pixel of a picture of data.
pub(super) const SAMPLES: Samples = Samples::nearest(2);

/// The scene of a data file before any option. Its light is bright where a surface faces the eye, never
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

/// The keys of data that lack a radius, for which another is found once all spheres are there, or a colour.
pub(super) fn usual() -> CloudKeys {
    CloudKeys { radius: Some(1.0), color: Color::parse("#8fb4d9"), ..CloudKeys::default() }
}

/// A scene file while it is changed.
pub(super) struct SceneDocument {
    document: DocumentMut,
}

impl SceneDocument {
    /// The scene file at `path` with this text.
    pub(super) fn new(text: &str, path: &Path) -> Result<SceneDocument> {
        // Of a scene that can be read, but not changed: nobody knows of one.
        let odd = |_| {
            let path = path.shown();
            let help = "options can't be written into this scene; change it by hand";
            Error::Usage(format!("{path}: {help}").into())
        };
        Ok(SceneDocument { document: text.parse().map_err(odd)? })
    }

    /// The scene file's text.
    pub(super) fn text(&self) -> String {
        self.document.to_string()
    }

    /// The scene file's text without a camera that is still empty: something else is read first.
    pub(super) fn text_so_far(&self) -> String {
        let mut document = self.document.clone();
        if document.get("camera").and_then(Item::as_table).is_some_and(Table::is_empty) {
            document.remove("camera");
        }
        document.to_string()
    }

    /// Writes the options into it.
    ///
    /// # Errors
    /// [`Error::Usage`] for options that can't be.
    pub(super) fn apply(
        &mut self,
        options: &SceneOverrides,
        path: &Path,
        of_data: bool,
    ) -> Result<()> {
        if options.frame() && options.camera.position.is_some() {
            let placed =
                [Setting::named("view"), Setting::named("margin"), Setting::text("height", "auto")];
            let hint = Hint::new("remove {}, {} and {}, which place the camera", placed);
            return wrong_usage(Message::new(
                "a position cannot be combined with an automatic camera",
                hint,
            ));
        }
        if of_data {
            let name = path.file_name().map(PathBuf::from).unwrap_or_default();
            let format = match options.input_format {
                Some(InputFormat::Data(format)) => Some(format),
                _ => None,
            };
            let keys = CloudKeys { format, ..CloudKeys::of_file(&name)? };
            self.clouds().into_iter().for_each(|cloud| lay(cloud, &keys));
            let (size, samples) =
                (options.size.unwrap_or(SIZE), options.samples.unwrap_or(SAMPLES));
            self.set("image", &ImageKeys::new(Some(size), Some(samples)));
        }
        self.apply_to_camera(options, of_data)?;
        let top = SceneKeys {
            background: options.background,
            ambient: options.ambient.flatten(),
            ..SceneKeys::default()
        };
        lay(self.document.as_table_mut(), &top);
        if options.ambient == Some(None) {
            self.document.remove("ambient");
        }
        if let Some(lights) = &options.lights {
            let tables = lights.iter().map(table_of).collect();
            self.replace("light", (!lights.is_empty()).then_some(Item::ArrayOfTables(tables)));
        }
        if let Some(sky) = &options.sky {
            self.replace("sky", sky.as_ref().map(|sky| Item::Table(table_of(sky))));
        }
        self.apply_to_cloud(options, path)
    }

    /// Writes what is said of a camera that is not placed by itself.
    fn apply_to_camera(&mut self, options: &SceneOverrides, of_data: bool) -> Result<()> {
        if options.frame() {
            return Ok(());
        }
        let CameraKeys { position, look_at, up, .. } = options.camera;
        if !of_data && self.document.contains_key("camera") {
            self.set("camera", &options.camera);
        } else if let (Some(position), Some(look_at)) = (position, look_at) {
            let up = usual_up(position - look_at, up.unwrap_or(DVec3::Y));
            let projection = options.projection(None);
            let camera = Camera { position, look_at, up, projection }.check()?;
            self.set("camera", &CameraKeys::from(&camera));
        }
        Ok(())
    }

    fn apply_to_cloud(&mut self, options: &SceneOverrides, path: &Path) -> Result<()> {
        if options.cloud == CloudKeys::default() {
            return Ok(());
        }
        let mut clouds = self.clouds();
        let n_clouds = clouds.len();
        let [cloud] = &mut clouds[..] else {
            let message = format!(
                "{}: options for data need data, or a scene with exactly one [[spheres]]; found {n_clouds}",
                path.shown()
            );
            return wrong_usage(Message::new(message, "set the keys in the scene file instead"));
        };
        if options.cloud.color.is_some() {
            for key in ["colormap", "range", "missing_color"] {
                cloud.remove(key);
            }
        }
        lay(*cloud, &options.cloud);
        Ok(())
    }

    /// Writes keys into the table with this name, made where there is none. Of what is no table, reading tells.
    pub(super) fn set(&mut self, name: &str, keys: &impl Section) {
        let item = self.document.entry(name).or_insert(Item::Table(Table::new()));
        item.as_table_like_mut().into_iter().for_each(|table| lay(table, keys));
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

    /// Puts a table or tables in the place of those with this name.
    fn replace(&mut self, key: &str, new: Option<Item>) {
        match new {
            Some(new) => self.document.insert(key, new),
            None => self.document.remove(key),
        };
    }
}

/// Writes keys into a table: the spaces and the comments beside them stay, and what they exclude goes.
pub(super) fn lay<S: Section>(table: &mut dyn TableLike, keys: &S) {
    keys.each(&mut |key, value| {
        let text = value.toml();
        for (one, other, _) in S::INFO.exclusive {
            if key == *one {
                table.remove(other);
            } else if key == *other {
                table.remove(one);
            }
        }
        // What a kind writes can be read.
        let mut value = text.parse::<toml_edit::Value>().unwrap_or_else(|_| text.into());
        let Some(item) = table.get_mut(key) else {
            table.insert(key, Item::Value(value));
            return;
        };
        if let Some(old) = item.as_value() {
            *value.decor_mut() = old.decor().clone();
        }
        *item = Item::Value(value);
    });
}

fn table_of(keys: &impl Section) -> Table {
    let mut table = Table::new();
    lay(&mut table, keys);
    table
}

/// The file that a cloud names.
pub(super) fn file_of(cloud: &dyn TableLike) -> Option<&str> {
    cloud.get("file").and_then(Item::as_str)
}

/// `cloud` as a scene file at `scene` names it: alone where they share a folder.
pub(crate) fn seen_from(scene: &Path, cloud: &Path) -> Result<PathBuf> {
    let name = cloud.file_name().map(PathBuf::from).unwrap_or_default();
    let folder_of_cloud = folder_of(cloud)?;
    Ok(if folder_of(scene)? == folder_of_cloud { name } else { folder_of_cloud.join(name) })
}

/// The folder of a file that may not be there yet, from the root on.
pub(super) fn folder_of(path: &Path) -> Result<PathBuf> {
    let folder = output::folder_of(path);
    folder.canonicalize().map_err(Error::io(folder))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plain::steers;
    use crate::scene::schema::{LightKeys, SkyKeys, Value as _, read_value, table};
    use crate::scene::{Light, Sky, Source};

    fn changed(text: &str, options: &SceneOverrides, path: &str) -> String {
        let mut document = SceneDocument::new(text, Path::new(path)).unwrap();
        document.apply(options, Path::new(path), text == OF_DATA).unwrap();
        document.text()
    }

    fn of_cloud(toml: &str) -> SceneOverrides {
        let cloud = read_value("spheres", toml, table).unwrap();
        SceneOverrides { cloud, ..SceneOverrides::default() }
    }

    #[test]
    fn all_keys_of_data_are_written_and_exclude_each_other() {
        let options = of_cloud(
            "{ color_by = \"speed\", colormap = \"viridis\", range = [0, 2.5], frame = 3, \
             columns = { x = \"px\", radius = \"R\" } }",
        );
        let text = changed(OF_DATA, &options, "a/heap.csv");
        for line in [
            "file = \"heap.csv\"",
            "color_by = \"speed\"",
            "colormap = \"viridis\"",
            "range = [0.0, 2.5]",
            "columns = { x = \"px\", radius = \"R\" }",
            "frame = 3",
        ] {
            assert!(text.lines().any(|found| found == line), "{line}:\n{text}");
        }
        let plain = of_cloud("{ color = \"#ff0000\" }");
        let colored = changed(&text.replace("[camera]\n", ""), &plain, "a.toml");
        assert!(
            colored.contains("color = \"#ff0000\"") && !colored.contains("color_by"),
            "{colored}"
        );
        let again = changed(&colored, &options, "a.toml");
        assert!(again.contains("color_by") && !again.contains("color = "), "{again}");
    }

    #[test]
    fn tables_stay_in_their_order() {
        let sky = Some(Some(SkyKeys::from(&Sky { intensity: 0.5, directions: 8 })));
        let light = Light {
            source: Source::Sun(DVec3::NEG_Y),
            color: [1.0, 0.5, 0.0].into(),
            intensity: 0.5,
            shadows: false,
        };
        let light = LightKeys::from(&light);
        let lights = Some(vec![light.clone(), light]);
        let text = changed(
            OF_DATA,
            &SceneOverrides { sky, lights, ..SceneOverrides::default() },
            "heap.csv",
        );
        let headers: Vec<&str> = text.lines().filter(|line| line.starts_with('[')).collect();
        let expected = ["[camera]", "[image]", "[[light]]", "[[light]]", "[sky]", "[[spheres]]"];
        assert_eq!(headers, expected, "{text}");
        assert!(
            text.contains("color = [1.0, 0.5, 0.0]") && text.contains("shadows = false"),
            "{text}"
        );
        // In a list of a line as well.
        let listed = "spheres = [{ file = \"a.npy\", radius = 1 }]\n";
        let text = changed(listed, &of_cloud("{ radius = 2 }"), "a.toml");
        assert_eq!(text, "spheres = [{ file = \"a.npy\", radius = 2.0 }]\n");
    }

    #[test]
    fn any_name_has_its_place() {
        for name in ["a\"b\\c", "\u{202e}\u{1b}[31m\n\t", "it's", "ü → 球"] {
            let value: Value = name.toml().parse().unwrap();
            assert_eq!(value.as_str(), Some(name));
            assert!(!value.to_string().contains(steers), "{name:?}");
        }
    }
}
