//! Pictures of the scenes where the kernels are most wrong.

use kugelblitz::Result;
use kugelblitz::scene::Color;
use kugelblitz::trace::{Hits, Rays};
use kugelblitz_judge::compare::error_picture;
use kugelblitz_judge::verify::{RayError, Truth, compare_to_exact, ray_errors};

use super::figures::{count, figure, percent};
use super::measure::{SURFACE, Work, picture};
use super::scenes::ReportScene;
use super::{Of, Row, RowKey};

/// Most scenes with pictures.
const MOST_SCENES: usize = 5;

/// A kernel's picture of a scene, and what is wrong with each pixel.
#[derive(Clone, Debug)]
pub struct ErrorPicture {
    /// What it is of.
    pub key: RowKey,
    /// 8-bit sRGB of [`Settings::picture_size`](super::Settings::picture_size), row by row from the top.
    pub srgb: Vec<[u8; 3]>,
    /// The error of each pixel as a colour.
    pub errors: Vec<[u8; 3]>,
    /// How many pixels are wrong, and by how much the others are off.
    pub verdict: [String; 2],
}

/// `12 wrong pixels (3 %)`
pub fn share_of_pixels(n: usize, what: &str, all: usize) -> String {
    match n {
        0 => format!("no {what}"),
        _ => format!("{} ({})", count(n, what), percent(n as u64, all as u64)),
    }
}

/// The scenes with the most that is wrong, the worst first: at most so many, and none without an error.
pub fn worst_first<'a>(
    scenes: impl Iterator<Item = &'a ReportScene>,
    wrong: impl Fn(&'a ReportScene) -> u64,
    most: usize,
) -> Vec<&'a ReportScene> {
    let mut ranked: Vec<_> = scenes.map(|case| (wrong(case), case)).collect();
    ranked.retain(|(wrong, _)| *wrong > 0);
    ranked.sort_by_key(|(wrong, _)| std::cmp::Reverse(*wrong));
    ranked.into_iter().map(|(_, case)| case).take(most).collect()
}

impl Work<'_> {
    /// Pictures of the worst scenes, as measured, by the benchmarks of the first device.
    ///
    /// # Errors
    /// Those of tracing; [`Error::Interrupted`](kugelblitz::Error::Interrupted).
    pub(super) fn pictures(&self, rows: &[Row]) -> Result<Vec<ErrorPicture>> {
        let of = |case: &ReportScene| Of::Scene { scene: case.name.clone(), class: case.class };
        let wrong =
            |case| rows.iter().filter(|row| row.key.of == of(case)).map(Row::wrong_ids).sum();
        let mut pictures = Vec::new();
        for case in worst_first(self.timed(), wrong, MOST_SCENES) {
            let pixels = picture(case, self.settings.picture_size)?;
            let all = (0..pixels.len()).collect();
            let rays = Rays::Pixels(pixels);
            let truth = Truth::of_rays(&case.scene, &rays, all, self.control)?;
            let palette: Vec<[u8; 3]> = case.scene.colors().map(Color::to_srgb8).collect();
            // Black for an id that no object has.
            let color = |id: &u32| palette.get(*id as usize).copied().unwrap_or_default();
            for benchmark in self.of_first_device() {
                let mut tracer = benchmark.tracer(&case.scene, &rays, SURFACE)?.tracer;
                let mut hits = Hits::default();
                tracer.trace(&rays, self.control, &mut hits)?;
                let errors: Vec<RayError> = ray_errors(&hits, &truth).collect();
                let found = compare_to_exact(&hits, &truth);
                pictures.push(ErrorPicture {
                    key: benchmark.key(of(case)),
                    srgb: hits.id.iter().map(color).collect(),
                    errors: error_picture(&errors, |_| false),
                    verdict: [
                        share_of_pixels(found.wrong_ids() as usize, "wrong pixel", pixels.len()),
                        format!("t up to {} ulp off", figure(found.t_ulp_max)),
                    ],
                });
            }
        }
        Ok(pictures)
    }
}
