//! `kugelblitz export`

use std::path::Path;

use kugelblitz::output::OutputFile;
use kugelblitz::rays::Pixels;
use kugelblitz::{Error, Result};
use kugelblitz_judge::compare::ObjectCounts;
use kugelblitz_judge::export;
use serde::Serialize;

use crate::args::ExportArgs;
use crate::head::Done;
use crate::output::{is_stdout, name, objects, shell_quoted};
use crate::{Run, scene};

#[derive(Serialize)]
pub struct Summary {
    language: &'static str,
    size: [u32; 2],
    objects: ObjectCounts,
    /// The command line that renders the file.
    run: String,
}

/// Writes a scene for another renderer.
pub fn run(args: &ExportArgs, run: &Run) -> Result<Done<Summary>> {
    let (picture, size) = (&args.picture, args.size.size);
    if args.output.is_none() && picture.print_scene.is_some() {
        return Ok(Done::scene_alone(picture.print_alone(&args.scene, size, 0, run)?));
    }
    let output = args.output.as_deref().unwrap_or(Path::new(OutputFile::STDOUT));
    picture.check_outputs(Some(output), "the scene for the other renderer", run)?;
    let (scene, composed) = picture.read(&args.scene, size, 0, run)?;
    let printed = picture.print(&composed, &scene, &args.scene)?;
    let Pixels { view, width, height, .. } = args.size.pixels(&scene, &args.scene)?;
    let palette: Vec<_> = scene.colors().collect();
    scene::refuse_overwriting(&[output], &[&args.scene], &scene)?;
    let mut file = OutputFile::create(output, false)?;
    let (language, size) = (args.language, [width, height]);
    let path = file.path().to_path_buf();
    export::write(language, &scene, &view, size, |id| palette[id as usize], &mut file)
        .map_err(Error::io(path))?;
    run.control.check()?;

    let command = language.command(&shell_quoted(output), size);
    let next =
        if is_stdout(output) { String::new() } else { format!("; render it with: {command}") };
    let (name, renderer) = (name(output), language.renderer());
    let line = format!("{name}: {} for {renderer}{next}", objects(&scene));
    let objects = ObjectCounts::of(&scene);
    let summary = Summary { language: language.name(), size, objects, run: command };
    Ok(Done::with_files(summary, printed.into_iter().chain([file]), line))
}
