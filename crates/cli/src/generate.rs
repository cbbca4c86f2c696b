//! `kugelblitz generate`

use std::iter::once;
use std::path::PathBuf;

use kugelblitz::Result;
use kugelblitz::generate::{Recipe, write_cloud, write_scene};
use kugelblitz::output::{self, OutputFile};
use kugelblitz::words::{count, duration};
use serde::Serialize;

use crate::args::GenerateArgs;
use crate::head::{Done, Millis};
use crate::output::{check_ending, is_stdout};
use crate::progress::Progress;
use crate::{Run, wrong_usage};

/// A generated data file.
#[derive(Serialize)]
pub struct GenerateSummary {
    /// Distribution of the spheres.
    distribution: &'static str,
    /// Number of spheres.
    count: u64,
    /// Seed of the random numbers.
    seed: u64,
    /// Path of the data file.
    file: String,
    /// Path of the scene file; `null` without `--scene`.
    scene: Option<String>,
    /// Times, milliseconds.
    ms: GenerateTimes,
}

/// Times, milliseconds.
#[derive(Serialize)]
struct GenerateTimes {
    /// Total time since the start of the program.
    total: Millis,
}

/// Makes a cloud.
pub fn run(args: &GenerateArgs, run: &Run) -> Result<Done<GenerateSummary>> {
    if !is_stdout(&args.output) {
        check_ending(&args.output, "npy", "a cloud is")?;
    } else if args.scene.is_some() {
        return wrong_usage(
            "--scene needs the name of the cloud's file; write the cloud to a file",
        );
    }
    let outputs = || once(&args.output).chain(&args.scene);
    run.refuse_sharing_stdout(outputs().map(|output| (output, "a file")))?;
    output::refuse_overwriting(outputs(), None::<&PathBuf>)?;
    let GenerateArgs { distribution, count: n, seed, .. } = *args;
    let recipe = Recipe { distribution, count: n, seed };
    let create = |path: &PathBuf| OutputFile::create(path, false);
    let mut file = create(&args.output)?;
    let mut scene = args.scene.as_ref().map(create).transpose()?;
    if let Some(scene) = &mut scene {
        write_scene(scene, &args.output, &recipe)?;
    }
    Progress::of_bytes(run).during(|| write_cloud(&mut file, &recipe, &run.control))?;
    let took = run.start.elapsed();
    let named = |path: &PathBuf| path.display().to_string();
    let summary = GenerateSummary {
        distribution: distribution.name(),
        count: n,
        seed,
        file: named(&args.output),
        scene: args.scene.as_ref().map(named),
        ms: GenerateTimes { total: Millis(took) },
    };
    let line = format!(
        "{}, {}, seed {seed}, in {}",
        count(n as usize, "sphere"),
        distribution.name(),
        duration(took)
    );
    let mut done = Done::with_file(summary, None, file, &line);
    // Behind the data that it names.
    done.files.extend(scene);
    Ok(done)
}
