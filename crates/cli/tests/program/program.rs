//! The program as tests run it, and what comes out.

use std::process::{Command, Stdio};

use kugelblitz_tests::root;
use serde_json::Value;

/// A scene file that comes with the program: `figure1`, `hard/tiny`.
pub fn scene_file(name: &str) -> String {
    format!("{}/scenes/{name}.toml", root().display())
}

/// The program in a surrounding that makes Mesa complain and has no preferred adapter.
pub fn program(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_kugelblitz"));
    command
        .args(args)
        .env_remove("XDG_RUNTIME_DIR")
        .env_remove("WGPU_ADAPTER_NAME")
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
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
