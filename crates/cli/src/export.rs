//! `kugelblitz export`

use kugelblitz::output::OutputFile;
use kugelblitz::{Error, Result};
use kugelblitz_judge::cost::ObjectCounts;
use kugelblitz_judge::export;
use serde::Serialize;

use crate::Run;
use crate::args::ExportArgs;
use crate::head::Done;
use crate::output::{is_stdout, refuse_overwriting, shell_quoted};
use crate::picture::read_composed;

/// A scene for another renderer.
#[derive(Serialize)]
pub struct ExportSummary {
    /// `pov` or `tachyon`.
    language: &'static str,
    /// Width and height, pixels.
    size: [u32; 2],
    /// Objects of the scene.
    objects: ObjectCounts,
    /// Command that renders the file.
    run: String,
}

/// Writes a scene for another renderer, or only prints the scene.
pub fn run(args: &ExportArgs, run: &Run) -> Result<()> {
    let picture = &args.picture;
    let overrides = picture.overrides(args.size.size)?;
    if args.output.is_none() && picture.print_scene.is_some() {
        return picture.print_alone(&args.scene, &overrides, run);
    }
    let output = &args.output.clone().unwrap_or(OutputFile::STDOUT.into());
    let outputs = [(output, "the scene for the other renderer")];
    run.refuse_sharing_stdout(outputs.into_iter().chain(picture.printed()))?;
    let (scene, composed) = read_composed(&args.scene, &overrides, run)?;
    let printed = picture.print(&composed, &scene, &args.scene)?;
    let pixels = args.size.pixels(&scene, &args.scene)?;
    refuse_overwriting([output], [&args.scene], &scene)?;
    let mut file = OutputFile::create(output, false)?;
    let (language, size) = (args.language, [pixels.width, pixels.height]);
    let path = file.path().to_path_buf();
    export::write(language, &scene, &pixels, &mut file).map_err(Error::io(path))?;
    run.control.check()?;

    let command = language.command(&shell_quoted(output), size);
    let next =
        if is_stdout(output) { String::new() } else { format!("; render it with: {command}") };
    let objects = ObjectCounts::of(&scene);
    let line = format!("{objects} for {}{next}", language.renderer());
    let summary = ExportSummary { language: language.name(), size, objects, run: command };
    Done::with_file(summary, printed, file, &line).finish("export", run)
}
