//! `kugelblitz new`

use std::path::PathBuf;

use clap::Args;
use kugelblitz::Result;
use kugelblitz::plain::Shown;
use serde::Serialize;

use crate::head::Done;
use crate::output::{check_ending, is_stdout, shell_quoted, written};
use crate::{Run, wrong_usage};

/// Write a small lit scene to start from
#[derive(Args)]
pub struct NewArgs {
    /// New scene file (.toml), which must not exist; `-` is stdout
    pub scene: PathBuf,
}

/// A new scene file.
#[derive(Serialize)]
pub struct NewSummary {
    /// Path of the file.
    file: String,
}

const SCENE: &str = include_str!("new.toml");

/// Writes the scene.
pub fn run(args: &NewArgs, run: &Run) -> Result<Done<NewSummary>> {
    let path = &*args.scene;
    run.refuse_sharing_stdout([(&args.scene, "the scene")])?;
    if !is_stdout(path) {
        check_ending(path, "toml", "a scene is")?;
        if path.symlink_metadata().is_ok() {
            return wrong_usage(format!(
                "{}: it is there already; name another file",
                path.shown()
            ));
        }
    }
    let file = written(path, SCENE.as_bytes())?;
    let line = if is_stdout(path) {
        "a scene to start from".into()
    } else {
        format!("`kugelblitz render {} -o picture.png` draws it", shell_quoted(path))
    };
    Ok(Done::with_file(NewSummary { file: path.display().to_string() }, None, file, &line))
}
