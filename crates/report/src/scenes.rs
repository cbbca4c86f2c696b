//! The scenes of a report.

use std::path::Path;
use std::sync::Arc;

use kugelblitz::Result;
use kugelblitz::control::Control;
use kugelblitz::scene::{Scene, parse_scene_with};
use serde::{Deserialize, Serialize};

/// Sort of a scene, by which results are put together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Class {
    /// The lecture's figures.
    Lecture,
    /// Where f32 has a hard time.
    Hard,
    /// Where shadows are hard to tell. Their light is measured, not their rays.
    Lit,
    /// Named on the command line.
    Given,
}

impl Class {
    /// In a table or a legend.
    pub fn name(self) -> &'static str {
        match self {
            Class::Lecture => "lecture's scenes",
            Class::Hard => "hard scenes",
            Class::Lit => "lit scenes",
            Class::Given => "given scenes",
        }
    }
}

/// What a report says of a scene, beside its numbers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MeasuredScene {
    /// The file's name without folder and ending.
    pub name: String,
    /// Sort of the scene.
    pub class: Class,
    /// The file's first comment: what it shows.
    pub about: String,
    /// Spheres in it.
    pub n_spheres: usize,
    /// Planes in it.
    pub n_planes: usize,
    /// Its lights, without a sky.
    pub n_lights: usize,
}

impl From<&Case> for MeasuredScene {
    fn from(case: &Case) -> MeasuredScene {
        MeasuredScene {
            name: case.name.clone(),
            class: case.class,
            about: case.about.clone(),
            n_spheres: case.scene.spheres.len(),
            n_planes: case.scene.planes.len(),
            n_lights: case.scene.lights.len(),
        }
    }
}

/// A scene to be measured.
#[derive(Clone, Debug)]
pub struct Case {
    /// The file's name without folder and ending.
    pub name: String,
    /// Sort of the scene.
    pub class: Class,
    /// The file's first comment: what it shows.
    pub about: String,
    /// The scene; it has a camera.
    pub scene: Arc<Scene>,
}

impl Case {
    /// A case from a scene file's text; `path` is for its name, for messages, and for its clouds,
    /// whose reading `control` follows.
    ///
    /// # Errors
    /// Those of [`parse_scene_with`]; [`Error::Scene`](kugelblitz::Error::Scene) without a camera.
    pub fn new(text: &str, path: &Path, class: Class, control: &Control) -> Result<Case> {
        let scene = parse_scene_with(text, path, control)?;
        scene.require_camera(path)?;
        let comment = text.lines().next().and_then(|line| line.strip_prefix('#'));
        Ok(Case {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            class,
            about: comment.unwrap_or_default().trim().to_string(),
            scene: Arc::new(scene),
        })
    }
}

/// The scenes of a report that names none: the lecture's, the hard ones, and those that are hard to light.
///
/// # Errors
/// As [`Case::new`]; they are part of the program.
pub fn default_cases() -> Result<Vec<Case>> {
    let control = Control::default();
    SCENES
        .iter()
        .map(|(class, path, text)| Case::new(text, Path::new(path), *class, &control))
        .collect()
}

macro_rules! scenes {
    ($($class:ident $path:literal),+ $(,)?) => {
        const SCENES: &[(Class, &str, &str)] =
            &[$((Class::$class, $path, include_str!(concat!("../../../scenes/", $path)))),+];
    };
}

scenes! {
    Lecture "figure1.toml",
    Lecture "figure2.toml",
    Lecture "figure3.toml",
    Lecture "figure4.toml",
    Lecture "figure5.toml",
    Lecture "inside.toml",
    Lecture "orthographic.toml",
    Hard "hard/far_1e4.toml",
    Hard "hard/far_1e6.toml",
    Hard "hard/far_1e8.toml",
    Hard "hard/tiny.toml",
    Hard "hard/huge_ground.toml",
    Hard "hard/grazing.toml",
    Hard "hard/touching.toml",
    Hard "hard/coincident.toml",
    Hard "hard/coincident_far.toml",
    Hard "hard/inside_nested.toml",
    Hard "hard/distant_1e2.toml",
    Hard "hard/distant_1e4.toml",
    Hard "hard/distant_1e6.toml",
    Hard "hard/near_parallel.toml",
    Lit "lit/hard/contacts.toml",
    Lit "lit/hard/contacts_1e-3.toml",
    Lit "lit/hard/contacts_1e-6.toml",
    Lit "lit/hard/contacts_1e3.toml",
    Lit "lit/hard/contacts_moved.toml",
    Lit "lit/hard/contacts_on_ball.toml",
    Lit "lit/hard/shells.toml",
    Lit "lit/hard/terminator.toml",
    Lit "lit/hard/low_sun.toml",
    Lit "lit/hard/along_subnormal.toml",
    Lit "lit/hard/along_1e-324.toml",
    Lit "lit/hard/along_1e-400.toml",
    Lit "lit/hard/along_leaning.toml",
    Lit "lit/hard/bright_eyes.toml",
    Lit "lit/hard/bright_sky.toml",
    Lit "lit/hard/faint_light.toml",
    Lit "lit/hard/byte_edge.toml",
    Lit "lit/hard/far_light.toml",
    Lit "lit/hard/coincident_floor.toml",
    Lit "lit/hard/galaxy.toml",
    Lit "lit/hard/galaxy_shadow.toml",
    Lit "lit/hard/galaxy_balls.toml",
    Lit "lit/hard/beyond_f64.toml",
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn no_scene_file_is_forgotten() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        let mut on_disk = BTreeSet::new();
        for folder in ["", "hard/", "lit/hard/"] {
            for entry in std::fs::read_dir(root.join(folder)).unwrap() {
                let name = entry.unwrap().file_name().into_string().unwrap();
                if name.ends_with(".toml") {
                    on_disk.insert(format!("{folder}{name}"));
                }
            }
        }
        let listed: BTreeSet<_> = SCENES.iter().map(|(_, path, _)| path.to_string()).collect();
        assert_eq!(listed, on_disk);
        for case in default_cases().unwrap() {
            assert!(!case.about.is_empty(), "{} says nothing about itself", case.name);
        }
    }
}
