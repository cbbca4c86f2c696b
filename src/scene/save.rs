//! A scene into a file, so that it reads as the same scene again.

use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;

use super::write::camera_text;
use super::{Color, Light, Plane, Scene, Sky, Source, Sphere};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::npy::write_float_header;
use crate::output::{self, OutputFile};
use crate::plain::Shown;

/// Spheres that stand in the scene file itself; more go into a cloud beside it.
const MOST_IN_FILE: usize = 256;

/// Columns of a cloud: centre, radius, linear colour.
const N_COLUMNS: usize = 7;

/// Rows of a cloud that are written at a time.
const ROWS_AT_ONCE: usize = 1 << 16;

impl Scene {
    /// Writes the scene into a `.toml` file and, if it has many spheres, those without a name into an
    /// `.npy` file of the same stem beside it, which is in its place first. Read again, it is the same
    /// scene: all numbers have all their digits.
    ///
    /// # Errors
    /// [`Error::Usage`] for a path without a name or one that a scene can't hold, as it is not UTF-8;
    /// [`Error::Io`]; [`Error::Interrupted`].
    pub fn save(&self, path: impl AsRef<Path>, control: &Control) -> Result<()> {
        let path = path.as_ref();
        if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) {
            let message = format!("{}: a scene is a file that ends in .toml", path.shown());
            return Err(Error::Usage(message));
        }
        let n_single = self.n_spheres_in_file();
        let cloud_path = path.with_extension("npy");
        let cloud = cloud_path.file_name().and_then(|name| name.to_str()).ok_or_else(|| {
            Error::Usage(format!("{}: a scene can name only a file in UTF-8", path.shown()))
        })?;
        let has_cloud = n_single < self.spheres.len();
        let text = self.text(n_single, has_cloud.then_some(cloud));
        let mut file = OutputFile::create(path, false)?;
        file.write_all(text.as_bytes()).map_err(Error::io(path))?;
        if !has_cloud {
            return output::commit([file], control);
        }
        let mut data = OutputFile::create(&cloud_path, false)?;
        self.write_cloud(n_single, &mut data, control)?;
        output::commit([data, file], control)
    }

    /// All of a few, else those up to the last one with a name, as ids follow the order.
    fn n_spheres_in_file(&self) -> usize {
        match self.spheres.len() {
            n if n <= MOST_IN_FILE => n,
            _ => self.spheres.last_name().map_or(0, |index| index as usize + 1),
        }
    }

    /// The text of a scene file with all but the spheres.
    pub fn text_without_spheres(&self) -> String {
        self.text(0, None)
    }

    fn text(&self, n_single: usize, cloud: Option<&str>) -> String {
        let mut text = format!("background = {}\n", color(self.background));
        if let Some(ambient) = self.ambient {
            line(&mut text, format_args!("ambient = {}", color(ambient)));
        }
        if let Some(camera) = &self.camera {
            text += "\n";
            text += &camera_text(camera);
        }
        if self.image.is_some() || self.samples.is_some() {
            text += "\n[image]\n";
            if let Some(image) = self.image {
                let (width, height) = (image.width, image.height);
                line(&mut text, format_args!("width = {width}\nheight = {height}"));
            }
            if let Some(samples) = self.samples {
                line(&mut text, format_args!("samples = {}", samples.across()));
            }
        }
        self.lights.iter().for_each(|light| light_text(light, &mut text));
        if let Some(Sky { intensity, directions }) = self.sky {
            let sky = format_args!("\n[sky]\nintensity = {intensity:?}\ndirections = {directions}");
            line(&mut text, sky);
        }
        for (index, sphere) in self.spheres[..n_single].iter().enumerate() {
            let (name, color) = (self.spheres.name(index), self.color(index as u32 + 1));
            sphere_text(name, sphere, color, &mut text);
        }
        if let Some(cloud) = cloud {
            // A name may hold quotes and backslashes.
            line(&mut text, format_args!("\n[[spheres]]\nfile = {}", toml::Value::from(cloud)));
        }
        self.planes.iter().for_each(|plane| plane_text(plane, &mut text));
        text
    }

    fn write_cloud(&self, first: usize, file: &mut OutputFile, control: &Control) -> Result<()> {
        let path = file.path().to_path_buf();
        let n_rows = self.spheres.len() - first;
        let mut bytes = Vec::new();
        let shape = [n_rows as u64, N_COLUMNS as u64];
        write_float_header(shape, &mut bytes);
        let mut left = (first..self.spheres.len()).peekable();
        while left.peek().is_some() || !bytes.is_empty() {
            control.check()?;
            for index in left.by_ref().take(ROWS_AT_ONCE) {
                let Sphere { center, radius } = self.spheres[index];
                let Color(color) = self.spheres.color(index).unwrap_or_default();
                let numbers = center.to_array().into_iter().chain([radius]).chain(color);
                numbers.for_each(|number| bytes.extend(number.to_le_bytes()));
            }
            file.write_all(&bytes).map_err(Error::io(&path))?;
            bytes.clear();
        }
        Ok(())
    }
}

fn line(text: &mut String, arguments: std::fmt::Arguments) {
    // A String takes all that is written to it.
    let _ = writeln!(text, "{arguments}");
}

/// Linear floats, so that no bit is lost.
fn color(color: Color) -> String {
    format!("{:?}", color.0)
}

fn name_text(name: Option<&str>, text: &mut String) {
    if let Some(name) = name {
        line(text, format_args!("name = {}", toml::Value::from(name)));
    }
}

fn light_text(light: &Light, text: &mut String) {
    let source = match light.source {
        Source::Point(at) => format!("position = {:?}", at.to_array()),
        Source::Sun(along) => format!("direction = {:?}", along.to_array()),
        Source::Eye => "position = \"eye\"".into(),
    };
    let Light { intensity, shadows, .. } = light;
    let color = color(light.color);
    let rest = format!("color = {color}\nintensity = {intensity:?}\nshadows = {shadows}");
    line(text, format_args!("\n[[light]]\n{source}\n{rest}"));
}

fn sphere_text(name: Option<&str>, sphere: &Sphere, of_all: Color, text: &mut String) {
    text.push_str("\n[[sphere]]\n");
    name_text(name, text);
    let (center, radius, color) = (sphere.center.to_array(), sphere.radius, color(of_all));
    line(text, format_args!("center = {center:?}\nradius = {radius:?}\ncolor = {color}"));
}

fn plane_text(plane: &Plane, text: &mut String) {
    text.push_str("\n[[plane]]\n");
    name_text(plane.name.as_deref(), text);
    let [point, normal] = [plane.point, plane.normal].map(|v| v.to_array());
    let color = color(plane.color);
    line(text, format_args!("point = {point:?}\nnormal = {normal:?}\ncolor = {color}"));
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::random::SplitMix;
    use crate::scene::{Camera, ImageSize, Projection, Samples, read_scene};

    fn scene(n_spheres: usize) -> Scene {
        let mut random = SplitMix::new(17);
        let mut number = || (random.unit() - 0.5) * 10f64.powf(40.0 * random.unit() - 20.0);
        let mut spheres = crate::scene::Spheres::default();
        for index in 0..n_spheres {
            let center = DVec3::new(number(), number(), number());
            let part = |n: usize| (index * n % 97) as f64 / 96.0;
            spheres.push(
                Sphere { center, radius: number().abs() },
                Color([part(1), part(3), part(5)]),
            );
        }
        if n_spheres > 2 {
            spheres.set_name(1, "a \"red\\ giant\"\n");
        }
        let camera = Camera {
            position: DVec3::new(0.1, 1e-300, 6.0),
            look_at: DVec3::new(0.0, 0.5, -1e9),
            up: DVec3::new(0.3, 1.0, 0.0),
            projection: Projection::Orthographic { height: 0.1 + 0.2 },
        };
        let light = |source| Light {
            source,
            color: Color([1.0, 0.5, 1.0 / 3.0]),
            intensity: 0.9,
            shadows: true,
        };
        let point = light(Source::Point(DVec3::new(4.0, 6.0, 3.0)));
        let sun = Light { shadows: false, ..light(Source::Sun(DVec3::NEG_Y)) };
        let plane = Plane {
            name: Some("floor".into()),
            point: DVec3::ZERO,
            normal: DVec3::new(0.0, 3.0, 0.1),
            color: Color([0.1, 0.2, 0.3]),
        };
        Scene {
            background: Color::from_srgb8([0x20, 0x24, 0x2c]),
            camera: Some(camera),
            image: Some(ImageSize { width: 320, height: 200 }),
            samples: Some(Samples::nearest(4)),
            lights: vec![point, sun, light(Source::Eye)],
            sky: Some(Sky { intensity: 0.5, directions: 64 }),
            ambient: Some(Color([0.1; 3])),
            spheres,
            planes: vec![plane.clone(), Plane { name: None, ..plane }],
            clouds: Vec::new(),
            notes: Vec::new(),
        }
    }

    #[test]
    fn a_saved_scene_reads_as_the_same() {
        let folder = tempfile::tempdir().unwrap();
        for (n_spheres, has_cloud) in [
            (0, false),
            (3, false),
            (MOST_IN_FILE, false),
            (MOST_IN_FILE + 1, true),
            (70_000, true),
        ] {
            let path = folder.path().join(format!("of {n_spheres}.toml"));
            let scene = scene(n_spheres);
            scene.save(&path, &Control::default()).unwrap();
            let read = read_scene(&path).unwrap();
            assert_eq!(!read.clouds.is_empty(), has_cloud);
            assert!(Scene { clouds: Vec::new(), ..read } == scene, "{n_spheres}");
        }
    }

    #[test]
    fn a_bare_scene_reads_as_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bare.toml");
        Scene::default().save(&path, &Control::default()).unwrap();
        assert_eq!(read_scene(&path).unwrap(), Scene::default());
    }

    #[test]
    fn what_is_refused_leaves_no_file() {
        let folder = tempfile::tempdir().unwrap();
        let control = Control::default();
        let refused = scene(3).save(folder.path().join("scene.png"), &control).unwrap_err();
        assert!(refused.to_string().contains(".toml"), "{refused}");
        control.cancel();
        let stopped = scene(1000).save(folder.path().join("scene.toml"), &control).unwrap_err();
        assert!(matches!(stopped, Error::Interrupted), "{stopped}");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
