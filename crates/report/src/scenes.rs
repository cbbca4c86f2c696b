//! Scenes of a report.

use std::path::Path;
use std::sync::Arc;

use kugelblitz::Result;
use kugelblitz::scene::{SHIPPED_SCENES, Scene, parse_scene};
use serde::Serialize;

/// Class of a scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum SceneClass {
    /// Figures of the lecture.
    Lecture,
    /// Scenes that are hard for f32.
    Hard,
    /// Scenes with hard shadows. Only their shadows are measured.
    Lit,
    /// Scenes from the command line.
    Given,
}

impl SceneClass {
    /// Classes whose rays are measured, in the order of a report.
    pub(crate) const TRACED: [SceneClass; 3] =
        [SceneClass::Lecture, SceneClass::Hard, SceneClass::Given];

    /// Returns the name for tables and plots.
    pub fn name(self) -> &'static str {
        match self {
            SceneClass::Lecture => "lecture's scenes",
            SceneClass::Hard => "hard scenes",
            SceneClass::Lit => "lit scenes",
            SceneClass::Given => "given scenes",
        }
    }
}

/// A scene to measure.
#[derive(Clone, Debug, Serialize)]
pub struct ReportScene {
    /// File name without folder and extension; the path if two files have the same name.
    pub name: String,
    /// Class of the scene.
    pub class: SceneClass,
    /// First comment of the file, which describes the scene.
    pub about: String,
    /// Number of spheres.
    pub n_spheres: usize,
    /// Number of planes.
    pub n_planes: usize,
    /// Number of lights, without a sky.
    pub n_lights: usize,
    /// Scene with a camera.
    #[serde(skip)]
    pub scene: Arc<Scene>,
}

impl ReportScene {
    /// Creates a case; `text` is the content of the scene file, empty for data, and `path` gives the name.
    ///
    /// # Errors
    /// Returns [`Error::Scene`](kugelblitz::Error::Scene) without a camera.
    pub fn new(
        scene: Arc<Scene>,
        text: &str,
        path: &Path,
        class: SceneClass,
    ) -> Result<ReportScene> {
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

/// Returns the default scenes: the lecture's, the hard ones, and those with hard shadows.
///
/// # Errors
/// Returns the errors of [`ReportScene::new`].
pub fn default_cases() -> Result<Vec<ReportScene>> {
    let case = |&(path, text): &(&'static str, &str)| {
        let class = match path.rsplit_once('/') {
            None => SceneClass::Lecture,
            Some(("hard", _)) => SceneClass::Hard,
            // The lecture's scenes with light are measured without it.
            Some(("lit", _)) => return None,
            Some(_) => SceneClass::Lit,
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
