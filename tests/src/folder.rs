//! Scenes and clouds in a folder that is gone in the end.

use std::fs;
use std::path::PathBuf;

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
}
