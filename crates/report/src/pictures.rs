//! Pictures of the scenes where the kernels are most wrong.

use kugelblitz::Result;
use kugelblitz::control::Control;
use kugelblitz::rays::Pixels;
use kugelblitz::scene::Color;
use kugelblitz::trace::{Hits, Rays};
use kugelblitz_judge::verify::{RayError, Truth, ray_errors};

use super::measure::{SURFACE, Work, picture};
use super::scenes::Case;
use super::{Of, Row, RowKey};

/// Most scenes with pictures.
const MOST_SCENES: usize = 5;

/// A kernel's picture of a scene, and what is wrong with each pixel.
#[derive(Clone, Debug)]
pub struct ErrorPicture {
    /// What it is of.
    pub key: RowKey,
    /// Width and height, px.
    pub size: [u32; 2],
    /// 8-bit sRGB, row by row from the top.
    pub srgb: Vec<[u8; 3]>,
    /// The error of each pixel.
    pub faults: Vec<Fault>,
}

/// The error of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// As it should be.
    Right,
    /// The right object; the error of `t` in f32 steps at the exact `t`.
    TUlp(f64),
    /// An object where there is none.
    FalseHit,
    /// No object where there is one.
    FalseMiss,
    /// Another object than the visible one.
    WrongObject,
    /// A light is left out that counts.
    FalseShadow,
    /// A light is let in that doesn't count.
    Leak,
    /// The right lights, and another byte: how far the worst one is off.
    Levels(u8),
}

impl ErrorPicture {
    pub(super) fn new(
        row: &Row,
        pixels: &Pixels,
        srgb: Vec<[u8; 3]>,
        faults: impl Iterator<Item = Fault>,
    ) -> ErrorPicture {
        let size = [pixels.width, pixels.height];
        ErrorPicture { key: row.key.clone(), size, srgb, faults: faults.collect() }
    }

    /// The scene's name.
    pub(super) fn scene(&self) -> &str {
        match &self.key.of {
            Of::Scene { scene, .. } | Of::Light { scene } => scene,
            _ => "",
        }
    }
}

/// The scenes with the most that is wrong, the worst first: at most so many, and none without an error.
pub fn worst_first<'a>(
    scenes: impl Iterator<Item = &'a Case>,
    wrong: impl Fn(&'a Case) -> u64,
    most: usize,
) -> Vec<&'a Case> {
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
    pub fn pictures(&self, rows: &[Row], control: &Control) -> Result<Vec<ErrorPicture>> {
        let own = |case: &Case| {
            let of = Of::Scene { scene: case.name.clone(), class: case.class };
            rows.iter().filter(move |row| row.key.of == of)
        };
        let wrong = |case| own(case).map(Row::wrong_ids).sum();
        let mut pictures = Vec::new();
        for case in worst_first(self.timed(), wrong, MOST_SCENES) {
            let pixels = picture(case, self.settings.picture_size)?;
            let all = (0..pixels.len()).collect();
            let truth = Truth::of_pixels(&case.scene, &pixels, all, control)?;
            let rays = Rays::Pixels(pixels);
            let palette: Vec<[u8; 3]> = case.scene.colors().map(Color::to_srgb8).collect();
            // Black for an id that no object has.
            let color = |id: &u32| palette.get(*id as usize).copied().unwrap_or_default();
            for (benchmark, row) in self.of_first_device().zip(own(case)) {
                let mut tracer = benchmark.tracer(&case.scene, &rays, SURFACE)?.tracer;
                let mut hits = Hits::default();
                tracer.trace(&rays, control, &mut hits)?;
                let srgb = hits.id.iter().map(color).collect();
                let faults = ray_errors(&hits, &truth).map(Fault::from);
                pictures.push(ErrorPicture::new(row, &pixels, srgb, faults));
            }
        }
        Ok(pictures)
    }
}

impl From<RayError> for Fault {
    fn from(error: RayError) -> Fault {
        match error {
            RayError::FalseHit => Fault::FalseHit,
            RayError::FalseMiss => Fault::FalseMiss,
            RayError::WrongObject => Fault::WrongObject,
            RayError::Right { id: 0, .. } => Fault::Right,
            RayError::Right { t, .. } => Fault::TUlp(t.map_or(0.0, |t| t.ulp)),
        }
    }
}
