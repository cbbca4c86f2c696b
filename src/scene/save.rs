//! A scene into a file, so that it reads as the same scene again.

use std::io::Write;
use std::ops::Range;
use std::path::Path;

use super::schema::{CloudKeys, ColorSpace, SceneKeys};
use super::{Color, Scene, Sphere};
use crate::error::{Error, Result, wrong_usage};
use crate::npy;
use crate::output::{self, OutputFile};
use crate::plain::Shown;
use crate::support::control::Control;

/// Spheres that stand in the scene file itself; more go into a cloud beside it.
const MOST_IN_FILE: usize = 256;

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
            return wrong_usage(message);
        }
        let n_single = self.n_spheres_in_file();
        let cloud_path = path.with_extension("npy");
        let cloud = CloudKeys {
            color_space: Some(ColorSpace::Linear),
            ..CloudKeys::of_file(cloud_path.file_name().unwrap_or_default().as_ref())?
        };
        let has_cloud = n_single < self.spheres.len();
        let text = SceneKeys::of(self, n_single, has_cloud.then_some(cloud)).document();
        let mut file = OutputFile::create(path, false)?;
        file.write_all(text.as_bytes()).map_err(Error::io(path))?;
        if !has_cloud {
            return output::commit([file], control);
        }
        let mut data = OutputFile::create(&cloud_path, false)?;
        let rows = self.spheres.iter().copied().zip(self.spheres.colors()).skip(n_single);
        let rows = rows.map(|(sphere, Color(linear))| (sphere, linear));
        write_rows(&mut data, self.spheres.len() - n_single, rows, control)?;
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
        SceneKeys::of(self, 0, None).document()
    }
}

/// Writes an `.npy` file of spheres: rows of x, y, z, radius, red, green, blue. `control` counts its bytes.
///
/// # Errors
/// [`Error::Io`]; [`Error::Interrupted`].
pub(crate) fn write_rows(
    file: &mut OutputFile,
    n_rows: usize,
    mut rows: impl Iterator<Item = (Sphere, [f64; 3])>,
    control: &Control,
) -> Result<()> {
    let append = |part: Range<usize>, bytes: &mut Vec<u8>| {
        for (Sphere { center, radius }, [red, green, blue]) in rows.by_ref().take(part.len()) {
            let row = [center.x, center.y, center.z, radius, red, green, blue];
            bytes.extend(row.map(f64::to_le_bytes).as_flattened());
        }
    };
    let header = npy::header("'<f8'", &[n_rows as u64, 7]);
    file.write_rows(header, n_rows, size_of::<(Sphere, Color)>(), append, control)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::scene::{Camera, Light, Plane, Projection, Samples, Sky, Source, read_scene};
    use crate::support::random::SplitMix;

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
            image: Some([320, 200]),
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
