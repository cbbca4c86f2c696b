//! Scenes and clouds in a folder that is gone in the end.

use std::fs;
use std::path::PathBuf;

use kugelblitz::Error;
use kugelblitz::error::SceneError;
use kugelblitz::scene::{Scene, read_scene};
use tempfile::TempDir;

/// A folder with a scene in it.
pub struct Folder(TempDir);

impl Default for Folder {
    /// An empty one.
    fn default() -> Folder {
        Folder(tempfile::tempdir().unwrap())
    }
}

impl Folder {
    /// The path of `name` in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file.
    pub fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).unwrap();
    }

    /// Reads a scene of this text.
    pub fn read(&self, text: &str) -> kugelblitz::Result<Scene> {
        self.write("scene.toml", text);
        read_scene(&self.path("scene.toml"))
    }

    /// Reads a scene of one cloud in the file `name`; `keys` are those of its table.
    pub fn cloud(
        &self,
        name: &str,
        bytes: impl AsRef<[u8]>,
        keys: &str,
    ) -> kugelblitz::Result<Scene> {
        self.write(name, bytes);
        self.read(&format!("[[spheres]]\nfile = \"{name}\"\n{keys}\n"))
    }

    /// The scene of a cloud that is right.
    pub fn good(&self, name: &str, bytes: impl AsRef<[u8]>, keys: &str) -> Scene {
        self.cloud(name, bytes, keys)
            .unwrap_or_else(|error| panic!("{name} {keys}: {}", said(&error)))
    }

    /// The error, and the value in the scene that it points at.
    pub fn bad(
        &self,
        name: &str,
        bytes: impl AsRef<[u8]>,
        keys: &str,
    ) -> (Box<SceneError>, String) {
        match self.cloud(name, bytes, keys) {
            Err(Error::Scene(error)) => {
                let at = error.text[error.span.clone()].to_owned();
                (error, at)
            }
            Err(other) => panic!("{name} {keys}: {other:?}"),
            Ok(_) => panic!("{name} {keys}: no error"),
        }
    }
}

/// An error with its advice.
pub fn said(error: &Error) -> String {
    match error {
        Error::Scene(error) => format!("{error}\n{}", error.help),
        other => other.to_string(),
    }
}
