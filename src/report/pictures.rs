//! Pictures of the scenes where the kernels are most wrong.

use super::measure::{SURFACE, Subject, of_first_device, picture, timed};
use super::scenes::Case;
use super::{Effort, ErrorPicture, Fault, SceneResult};
use crate::control::Control;
use crate::error::Result;
use crate::scene::Color;
use crate::trace::{Hits, Rays};
use crate::verify::{RayError, Truth, ray_errors};

/// Most scenes with pictures.
const MOST_SCENES: usize = 5;

/// The scenes with the most wrong ids, as measured, the worst first.
fn worst<'a>(cases: &'a [Case], results: &[SceneResult]) -> Vec<&'a Case> {
    let wrong = |result: &SceneResult| -> u64 {
        result.rows.iter().map(|row| row.errors.wrong_ids()).sum()
    };
    worst_first(timed(cases).into_iter().zip(results.iter().map(wrong)), MOST_SCENES)
}

/// The scenes with the most that is wrong, the worst first: at most so many, and none without an error.
pub(super) fn worst_first<'a>(
    scenes: impl Iterator<Item = (&'a Case, u64)>,
    most: usize,
) -> Vec<&'a Case> {
    let mut ranked: Vec<_> = scenes.filter(|(_, wrong)| *wrong > 0).collect();
    ranked.sort_by_key(|(_, wrong)| std::cmp::Reverse(*wrong));
    ranked.into_iter().map(|(case, _)| case).take(most).collect()
}

/// Pictures of the worst scenes by the subjects of the first device.
///
/// # Errors
/// Those of tracing; [`Error::Interrupted`](crate::Error::Interrupted).
pub(super) fn take_pictures(
    cases: &[Case],
    results: &[SceneResult],
    subjects: &[Subject],
    effort: &Effort,
    control: &Control,
) -> Result<Vec<ErrorPicture>> {
    let subjects = of_first_device(subjects);
    let mut pictures = Vec::new();
    for case in worst(cases, results) {
        let pixels = picture(case, effort.picture_size)?;
        let all = (0..pixels.len()).collect();
        let truth = Truth::of_pixels(&case.scene, &pixels, all, control)?;
        let rays = Rays::Pixels(pixels);
        let palette: Vec<[u8; 3]> = case.scene.colors().map(Color::to_srgb8).collect();
        for subject in &subjects {
            let mut tracer = subject.tracer(&case.scene, &rays, SURFACE)?.tracer;
            let mut hits = Hits::default();
            tracer.trace(&rays, control, &mut hits)?;
            pictures.push(ErrorPicture {
                scene: case.name.clone(),
                contestant: subject.contestant.clone(),
                width: pixels.width,
                height: pixels.height,
                srgb: hits.id.iter().map(|&id| color(&palette, id)).collect(),
                faults: ray_errors(&hits, &truth).map(fault).collect(),
            });
        }
    }
    Ok(pictures)
}

/// Black for an id that no object has.
fn color(palette: &[[u8; 3]], id: u32) -> [u8; 3] {
    palette.get(id as usize).copied().unwrap_or_default()
}

fn fault(error: RayError) -> Fault {
    match error {
        RayError::FalseHit => Fault::FalseHit,
        RayError::FalseMiss => Fault::FalseMiss,
        RayError::WrongObject => Fault::WrongObject,
        RayError::Right { id: 0, .. } => Fault::Background,
        RayError::Right { t, .. } => Fault::Right { t_ulp: t.map_or(0.0, |t| t.ulp) },
    }
}
