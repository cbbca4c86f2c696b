//! The program as tests run it, and what comes out.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};

use kugelblitz_tests::{npy_of_rays, root};
use serde_json::Value;
use tempfile::TempDir;

/// A scene file that comes with the program: `figure1`, `hard/tiny`.
pub fn scene_file(name: &str) -> String {
    format!("{}/scenes/{name}.toml", root().display())
}

/// The path of `name` in a folder.
pub fn file(folder: &TempDir, name: &str) -> String {
    folder.path().join(name).to_str().unwrap().to_owned()
}

/// The names of what is in a folder.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<_> = entries.map(|name| name.into_string().unwrap()).collect();
    names.sort();
    names
}

/// The program in a surrounding that makes Mesa complain and has no preferred adapter.
pub fn program(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_kugelblitz"));
    command
        .args(args)
        .env_remove("XDG_RUNTIME_DIR")
        .env_remove("WGPU_ADAPTER_NAME")
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        // Markers are drawn as lines.
        .env("LC_ALL", "C.UTF-8")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// The program with the words of a line, in a folder.
pub fn in_folder(folder: &TempDir, line: &str) -> Command {
    let mut command = program(&line.split(' ').collect::<Vec<_>>());
    command.current_dir(folder);
    command
}

/// A folder with the link `scenes`, a scene in which a ray can tie, and one whose light is hidden, `tie.toml`, one that is wrong,
/// one without a camera, and rays.
pub fn material() -> TempDir {
    let tie = r##"
        camera = { position = [0, 0, 5], look_at = [0, 0, 0] }
        sphere = [
            { center = [0, 0, 0], radius = 1, color = "red" },
            { center = [0, 0, 0], radius = 1, color = "#0f0" },
            { center = [9, 0, 0], radius = 1, color = "blue" },
            { center = [0, 0, 3], radius = 0.1, color = "white" },
        ]
        plane = [{ point = [0, 0, -9], normal = [0, 0, 1], color = "#888888" }]
        light = [{ position = [0, 0, -5] }, { position = [3, 0.2, 8] }]
        sky = { intensity = 0.5, directions = 8 }
    "##;
    let folder = tempfile::tempdir().unwrap();
    let rays = [[0.0, 0.0, 0.0, 1.6, 0.3, -12.0], [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]];
    for (name, bytes) in [
        ("tie.toml", tie.as_bytes()),
        ("wrong.toml", b"[camera]\nlookat = [0, 0, 0]\n"),
        ("lonely.toml", b"background = \"#123456\"\n"),
        ("rays.npy", &npy_of_rays(&rays)),
    ] {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    symlink(root().join("scenes"), folder.path().join("scenes")).unwrap();
    folder
}

/// A run that has ended.
pub struct Ran {
    pub code: i32,
    pub stdout: Vec<u8>,
    pub stderr: String,
}

impl Ran {
    pub fn text(&self) -> &str {
        std::str::from_utf8(&self.stdout).unwrap()
    }

    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.stdout).unwrap_or_else(|e| panic!("{e}: {}", self.text()))
    }
}

/// Runs a command to its end, which is no panic.
#[track_caller]
pub fn finish(mut command: Command) -> Ran {
    let output = command.output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(!stderr.contains("panicked"), "{command:?}\n{stderr}");
    assert!(!stderr.contains("XDG_RUNTIME_DIR"), "{command:?}\n{stderr}");
    let code = output.status.code().unwrap_or_else(|| panic!("{command:?}: {}", output.status));
    Ran { code, stdout: output.stdout, stderr }
}

/// Runs a command to its end, which must have this exit code.
#[track_caller]
pub fn ends(command: Command, code: i32) -> Ran {
    let what = format!("{command:?}");
    let ran = finish(command);
    assert_eq!(ran.code, code, "{what}\n{}", ran.stderr);
    ran
}

/// Runs the program to its end, which must have this exit code.
#[track_caller]
pub fn run(args: &[&str], code: i32) -> Ran {
    ends(program(args), code)
}
