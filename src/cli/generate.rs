//! `kugelblitz generate`

use std::path::{Path, PathBuf};

use kugelblitz::generate::{Recipe, write_cloud, write_scene};
use kugelblitz::picture::OutputFile;
use kugelblitz::{Error, Result};
use serde::Serialize;

use super::head::Head;
use super::output::{count, human, ms, print_json};
use super::progress::Progress;
use super::{Generate, GenerateArgs, GenerateCloudArgs, Run};

#[derive(Serialize)]
struct Summary {
    #[serde(flatten)]
    head: Head,
    distribution: &'static str,
    count: u64,
    seed: u64,
    file: PathBuf,
    scene: Option<PathBuf>,
    ms: Ms,
}

#[derive(Serialize)]
struct Ms {
    total: f64,
}

/// Makes what is asked for.
pub fn run(args: &GenerateArgs, run: &Run) -> Result<()> {
    match &args.what {
        Generate::Cloud(args) => cloud(args, run),
    }
}

fn cloud(args: &GenerateCloudArgs, run: &Run) -> Result<()> {
    refuse_wrong_outputs(args)?;
    let GenerateCloudArgs { distribution, count: n, seed, .. } = *args;
    let recipe = Recipe { distribution, count: n, seed };
    let progress = Progress::of_bytes(&args.talk, &run.control);
    write_cloud(&args.output, &recipe, &run.control)?;
    drop(progress);
    if let Some(scene) = &args.scene {
        write_scene(scene, &args.output, &recipe)?;
    }
    let took = run.start.elapsed();
    if args.talk.json {
        print_json(&Summary {
            head: Head::new("generate"),
            distribution: distribution.name(),
            count: n,
            seed,
            file: args.output.clone(),
            scene: args.scene.clone(),
            ms: Ms { total: ms(took) },
        })?;
    }
    args.talk.say(&format!(
        "{}: {}, {}, seed {seed}, in {}",
        args.output.display(),
        count(n as usize, "sphere"),
        distribution.name(),
        human(took)
    ));
    Ok(())
}

fn refuse_wrong_outputs(args: &GenerateCloudArgs) -> Result<()> {
    let output = args.output.display();
    let stdout = Path::new(OutputFile::STDOUT);
    let to_stdout = args.output == stdout;
    if !to_stdout && args.output.extension().is_none_or(|ending| ending != "npy") {
        return Err(Error::Usage(format!("{output}: a cloud is written as .npy; name it so")));
    }
    if to_stdout && args.scene.is_some() {
        return Err(Error::Usage(
            "--scene needs the name of the cloud's file; write the cloud to a file".into(),
        ));
    }
    if args.talk.json && (to_stdout || args.scene.as_deref() == Some(stdout)) {
        return Err(Error::Usage(
            "a file and --json can't both go to standard output; write to a file".into(),
        ));
    }
    Ok(())
}
