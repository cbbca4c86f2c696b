//! `kugelblitz check`

use std::fmt::Write;

use kugelblitz::Result;
use kugelblitz::plain::Shown;
use kugelblitz::trace::Kernel;
use kugelblitz::words::{bytes, count};
use kugelblitz_judge::cost::{Built, Cost, LightOf, ObjectCounts, PictureCost};

use crate::Run;
use crate::args::{CheckArgs, SceneArgs};
use crate::head::Done;
use crate::picture::unused_columns;
use crate::progress::Progress;

/// Reads a scene and says what it costs.
pub fn run(args: &CheckArgs, run: &Run) -> Result<Done<Cost>> {
    let SceneArgs { path, size, picture } = &args.scene;
    let scene = picture.scene_of_rays(path, size.whole.size, run)?;
    let pixels = scene.camera.as_ref().map(|_| args.scene.pixels(&scene)).transpose()?;
    let progress = Progress::of_preparing(run, &scene, Kernel::Certified);
    let cost = progress.during(|| Cost::new(&scene, pixels.as_ref(), &run.control))?;
    let mut text = format!("{}: {}\n", args.scene.path.shown(), ObjectCounts::of(&scene));
    for cloud in &scene.clouds {
        let spheres = count(cloud.n_spheres, "sphere");
        let _ = writeln!(text, "{}: {spheres}, from id {}", cloud.path.shown(), cloud.first_id);
        if !cloud.unused_columns.is_empty() {
            let _ = writeln!(text, "{}: {}", cloud.path.shown(), unused_columns(cloud));
        }
    }
    if let Some(light) = &cost.light {
        let _ = writeln!(text, "lit by {}", light_in_words(light));
    }
    if let n @ 2.. = cost.samples {
        let _ = writeln!(text, "samples: {n} × {n} a pixel");
    }
    let _ = writeln!(text, "in memory: {}", bytes(cost.bytes_scene));
    for (kernel, n) in &cost.bytes_device {
        let _ = writeln!(text, "on the device, {kernel}: {}", bytes(*n));
    }
    if let Some(Built { spheres_outside, bytes: n, ms_build }) = &cost.hierarchy {
        let outside = match spheres_outside {
            0 => String::new(),
            n => format!(", without {}", count(*n, "sphere")),
        };
        let _ = writeln!(text, "hierarchy: {}, built in {ms_build:.0} ms{outside}", bytes(*n));
    }
    match &cost.picture {
        Some(PictureCost { size: [width, height], rays, bytes_memory, bytes_held }) => {
            let _ = writeln!(text, "picture: {width}×{height}, {rays} rays");
            let _ = writeln!(text, "memory held for it: {}", bytes(*bytes_held));
            for (format, n) in bytes_memory {
                let _ = writeln!(text, "memory to write {format}: {}", bytes(*n));
            }
        }
        None => text += "no camera: commands that draw place one that frames all spheres\n",
    }
    Ok(Done::in_words(cost, text))
}

/// `2 lights, a sky of 16 directions`
fn light_in_words(light: &LightOf) -> String {
    let mut parts = Vec::new();
    if light.lights > 0 {
        parts.push(count(light.lights, "light"));
    }
    if light.sky_directions > 0 {
        let directions = count(light.sky_directions as usize, "direction");
        parts.push(format!("a sky of {directions}"));
    }
    if light.ambient {
        parts.push("ambient light".into());
    }
    parts.join(", ")
}
