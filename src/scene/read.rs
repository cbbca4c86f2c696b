//! Scene files (TOML) with the place of every error.

use std::path::{Path, PathBuf};

use super::Scene;
use crate::error::Result;

/// What is wrong in a scene file, and where.
#[derive(Debug, thiserror::Error)]
#[error("{}:{line}:{column}: {message}", path.display())]
pub struct SceneError {
    /// The file.
    pub path: PathBuf,
    /// The whole text of the file (empty where it could not be read as text).
    pub text: String,
    /// Bytes of `text` that the error is about.
    pub span: std::ops::Range<usize>,
    /// Line of the span's start, from 1.
    pub line: usize,
    /// Column of the span's start, characters, from 1.
    pub column: usize,
    /// What was found.
    pub message: String,
    /// What was expected, the nearest known key, or the next step.
    pub help: String,
}

/// Reads and checks a scene file.
pub fn read_scene(path: &Path) -> Result<Scene> {
    let text = std::fs::read_to_string(path).map_err(crate::Error::io(path))?;
    parse_scene(&text, path)
}

/// Reads and checks the text of a scene file; `path` is for messages.
pub fn parse_scene(_text: &str, _path: &Path) -> Result<Scene> {
    Err(crate::Error::Usage(String::new()))
}
