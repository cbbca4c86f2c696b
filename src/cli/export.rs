//! `kugelblitz export`

use kugelblitz::export;
use kugelblitz::output::{self, OutputFile};
use kugelblitz::rays::Pixels;
use kugelblitz::{Error, Result};
use serde::Serialize;

use super::head::{Objects, print_summary};
use super::output::{is_stdout, name, objects};
use super::{ExportArgs, Run, scene};

#[derive(Serialize)]
struct Summary {
    language: &'static str,
    size: [u32; 2],
    objects: Objects,
    /// The command line that renders the file.
    run: String,
}

/// Writes a scene for another renderer.
pub fn run(args: &ExportArgs, run: &Run) -> Result<()> {
    let advice = "write the scene to a file with -o";
    args.talk.refuse_json_beside(&[&args.output], "the scene", advice)?;
    let scene = scene::read(&args.scene, &args.talk, run)?;
    let Pixels { view, width, height, .. } = args.size.pixels(&scene, &args.scene)?;
    let palette: Vec<_> = scene.colors().collect();
    scene::refuse_overwriting(&[&args.output], &[&args.scene], &scene)?;
    let mut file = OutputFile::create(&args.output, false)?;
    let (language, size) = (args.language, [width, height]);
    export::write(language, &scene, &view, size, |id| palette[id as usize], &mut file)
        .map_err(Error::io(&args.output))?;
    run.control.check()?;

    let command = language.command(&args.output.display().to_string(), size);
    if args.talk.json {
        let (objects, run) = (Objects::from(&*scene), command.clone());
        let summary = Summary { language: language.name(), size, objects, run };
        print_summary("export", &summary)?;
    }
    output::commit([file], &run.control)?;
    let next = match is_stdout(&args.output) {
        true => String::new(),
        false => format!("; render it with: {command}"),
    };
    let (name, renderer) = (name(&args.output), language.renderer());
    args.talk.say(&format!("{name}: {} for {renderer}{next}", objects(&scene)));
    Ok(())
}
