//! `kugelblitz explain`

use glam::DVec3;
use kugelblitz::query::{Rays, WorldRay};
use kugelblitz::rays::Pixels;
use kugelblitz::{Error, Result};
use kugelblitz_judge::cost::ObjectCounts;
use kugelblitz_judge::explain::{DEFAULT_OBJECTS, ExplainStyle, Explanation, explain, latex, text};
use serde::Serialize;

use crate::args::{ExplainArgs, SceneArgs};
use crate::device;
use crate::head::{Done, On};
use crate::{Run, wrong_usage};

/// The explanation of a ray.
#[derive(Serialize)]
pub struct ExplainSummary {
    #[serde(flatten)]
    on: On,
    /// Objects of the scene.
    objects: ObjectCounts,
    /// Explanation of the ray.
    explanation: Explanation,
}

/// Shows the formulas of one ray with its numbers in them.
pub fn run(args: &ExplainArgs, run: &Run) -> Result<Done<ExplainSummary>> {
    let SceneArgs { path, size, picture } = &args.scene;
    let scene = match args.ray {
        Some(_) => picture.scene_of_rays(path, size.whole.size, run)?,
        None => args.scene.scene(run)?,
    };
    let rays = match (args.ray, args.pixel.unwrap_or_default()) {
        (Some(ray), _) => Rays::List(vec![usable(ray)?]),
        (None, pixel) => Rays::Pixels(one_pixel(args.scene.pixels(&scene)?, pixel)?),
    };
    let style = ExplainStyle {
        limit: (!args.all).then_some(DEFAULT_OBJECTS),
        lang: args.lang.lang,
        digits: args.digits.into(),
    };
    let mut explanation = explain(&scene, &rays, &style)?;
    run.control.check()?;
    let device = device::open(&args.device.device, None, run)?;
    explanation.add_device(&scene, &rays, |kernel| device::or_cpu(&device, kernel, run))?;
    run.control.check()?;
    let words = if args.latex { latex::latex(&explanation) } else { text::text(&explanation) };
    let (on, objects) = (On::from(&device), ObjectCounts::of(&scene));
    Ok(Done::in_words(ExplainSummary { on, objects, explanation }, words))
}

/// The pixel alone, as part of its picture.
fn one_pixel(pixels: Pixels, [x, y]: [i64; 2]) -> Result<Pixels> {
    pixels.pixel([x, y]).ok_or_else(|| {
        Error::Usage(
            format!(
                "--pixel {x},{y} is not in the picture: X goes from {} to {}, Y from {} to {}",
                pixels.x,
                u64::from(pixels.x) + u64::from(pixels.width) - 1,
                pixels.y,
                u64::from(pixels.y) + u64::from(pixels.height) - 1
            )
            .into(),
        )
    })
}

fn usable(ray: WorldRay) -> Result<WorldRay> {
    if !ray.origin.is_finite() || !ray.direction.is_finite() {
        return wrong_usage("--ray has a number that is not finite");
    }
    if ray.direction == DVec3::ZERO {
        return wrong_usage("--ray has the direction (0, 0, 0), which points nowhere");
    }
    Ok(ray)
}
