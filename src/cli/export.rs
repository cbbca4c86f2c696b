//! `kugelblitz export`

use std::path::Path;

use kugelblitz::camera::Pixels;
use kugelblitz::export;
use kugelblitz::output::{self, OutputFile};
use kugelblitz::{Error, Result};
use serde::Serialize;

use super::head::{Head, Objects};
use super::output::{STDOUT, objects, print_json};
use super::{ExportArgs, Run, SizeArgs, scene};

#[derive(Serialize)]
struct Summary {
    #[serde(flatten)]
    head: Head,
    language: &'static str,
    size: [u32; 2],
    objects: Objects,
    /// What renders the file.
    run: String,
}

/// Writes a scene for another renderer.
pub fn run(args: &ExportArgs, run: &Run) -> Result<()> {
    let to_stdout = args.output == Path::new(OutputFile::STDOUT);
    if args.talk.json && to_stdout {
        return Err(Error::Usage(
            "the scene and --json can't both go to standard output; write the scene to a file with \
             -o"
            .into(),
        ));
    }
    let scene = scene::read(&args.scene, &args.talk, run)?;
    let whole = SizeArgs { size: args.size, crop: None };
    let Pixels { view, width, height, .. } = whole.pixels(&scene, &args.scene)?;
    let palette: Vec<_> = scene.colors().collect();
    scene::refuse_overwriting(&[&args.output], &[&args.scene], &scene)?;
    let mut file = OutputFile::create(&args.output, false)?;
    let (language, size) = (args.language, [width, height]);
    export::write(language, &scene, &view, size, |id| palette[id as usize], &mut file)
        .map_err(Error::io(&args.output))?;
    run.control.check()?;

    let command = language.command(&args.output.display().to_string(), size);
    if args.talk.json {
        print_json(&Summary {
            head: Head::new("export"),
            language: language.name(),
            size,
            objects: Objects::from(&*scene),
            run: command.clone(),
        })?;
    }
    output::commit([file], &run.control)?;
    let (name, next) = match to_stdout {
        true => (STDOUT.to_string(), String::new()),
        false => (args.output.display().to_string(), format!("; render it with: {command}")),
    };
    args.talk.say(&format!("{name}: {} for {}{next}", objects(&scene), language.renderer()));
    Ok(())
}
