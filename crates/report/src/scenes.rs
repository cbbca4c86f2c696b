//! The scenes of a report.

use std::path::Path;
use std::sync::Arc;

use kugelblitz::Result;
use kugelblitz::scene::{SHIPPED_SCENES, Scene, parse_scene};
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
    /// In the order of a report.
    pub(super) const ALL: [Class; 4] = [Class::Lecture, Class::Hard, Class::Lit, Class::Given];

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

/// A scene to be measured, and what a report says of it beside its numbers.
#[derive(Clone, Debug, Serialize)]
pub struct ReportScene {
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
    /// Lights in it, without a sky.
    pub n_lights: usize,
    /// The scene; it has a camera.
    #[serde(skip)]
    pub scene: Arc<Scene>,
}

impl ReportScene {
    /// A case of a scene; `text` is that of its file, empty for data, and `path` is for its name and for messages.
    ///
    /// # Errors
    /// [`Error::Scene`](kugelblitz::Error::Scene) without a camera.
    pub fn new(scene: Arc<Scene>, text: &str, path: &Path, class: Class) -> Result<ReportScene> {
        scene.require_camera(path)?;
        let comment = text.lines().next().and_then(|line| line.strip_prefix('#'));
        Ok(ReportScene {
            name: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            class,
            about: comment.unwrap_or_default().trim().to_string(),
            n_spheres: scene.spheres.len(),
            n_planes: scene.planes.len(),
            n_lights: scene.lights.len(),
            scene,
        })
    }
}

/// The scenes of a report that names none: the lecture's, the hard ones, and those that are hard to light.
///
/// # Errors
/// As [`ReportScene::new`]; they are part of the program.
pub fn default_cases() -> Result<Vec<ReportScene>> {
    let case = |&(path, text): &(&'static str, &str)| {
        let class = match path.rsplit_once('/') {
            None => Class::Lecture,
            Some(("hard", _)) => Class::Hard,
            // The lecture's scenes with light are measured without it.
            Some(("lit", _)) => return None,
            Some(_) => Class::Lit,
        };
        let path = Path::new(path);
        let scene = parse_scene(text, path);
        Some(scene.and_then(|scene| ReportScene::new(scene.into(), text, path, class)))
    };
    SHIPPED_SCENES.iter().filter_map(case).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_scene_says_what_it_shows() {
        for case in default_cases().unwrap() {
            assert!(!case.about.is_empty(), "{} says nothing about itself", case.name);
        }
    }
}
