//! The values that options take.

use std::num::NonZeroUsize;
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::value_parser;
use glam::DVec3;
use kugelblitz::query::WorldRay;
use kugelblitz::rays::{Pixels, View};
use kugelblitz::scene::{MAX_SIDE, Samples, Scene};
use kugelblitz::{Error, Result};

use crate::Run;
use crate::args::{SceneArgs, SizeArgs, WholeArgs};

/// The picture size where neither the command line nor the scene has one.
const DEFAULT_SIZE: [u32; 2] = [1280, 720];

/// Takes the names of `all`.
pub fn parser_of<
    T: Copy + Send + Sync + 'static,
    V: Into<PossibleValue> + 'static,
    const N: usize,
>(
    all: [T; N],
    name_of: fn(T) -> V,
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(all.map(name_of)).try_map(move |name| {
        let is_it = |one: &T| name_of(*one).into().matches(&name, false);
        all.into_iter().find(is_it).ok_or(format!("there is no {name}"))
    })
}

/// Reads samples across and down a pixel.
pub fn samples_parser() -> impl TypedValueParser<Value = Samples> {
    value_parser!(u32).range(1..=Samples::MOST.into()).try_map(Samples::new)
}

/// Reads `WxH`, in pixels.
pub fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parts = text.split_once(['x', 'X', '×']);
    match parts.and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?])) {
        Some(size) if !size.contains(&0) => Ok(size),
        _ => Err("give width x height in whole pixels, e.g. 1920x1080".into()),
    }
}

/// Reads `X,Y,W,H`, in pixels.
pub fn parse_crop(text: &str) -> Result<[u32; 4], String> {
    match numbers(text) {
        Some(crop @ [_, _, width, height]) if width > 0 && height > 0 => Ok(crop),
        _ => Err("give left column, top row, width and height in whole pixels, e.g. \
                  100,50,640,360"
            .into()),
    }
}

/// Reads how many there are to be.
pub fn parse_number(text: &str) -> Result<NonZeroUsize, String> {
    text.parse().map_err(|_| "give a whole number, 1 or more".into())
}

/// Reads a number that is as it has to be; `usage` says how.
pub fn number(text: &str, is_right: impl Fn(f64) -> bool, usage: &str) -> Result<f64, String> {
    text.parse().ok().filter(|x| is_right(*x)).ok_or(usage.into())
}

/// Reads a distance, finite and not negative.
pub fn parse_epsilon(text: &str) -> Result<f64, String> {
    number(text, |x| x.is_finite() && x >= 0.0, "give a distance, 0 or more, e.g. 1e-4")
}

/// Reads `X,Y`, in pixels, in the picture or not.
pub fn parse_pixel(text: &str) -> Result<[i64; 2], String> {
    numbers(text).ok_or("give column and row in whole pixels, e.g. 640,360".into())
}

/// Reads `OX,OY,OZ,DX,DY,DZ`, which may point nowhere.
pub fn parse_ray(text: &str) -> Result<WorldRay, String> {
    let [ox, oy, oz, dx, dy, dz] = numbers(text)
        .ok_or("give six numbers, the origin's and the direction's, e.g. 0,1,6,0,0,-1")?;
    Ok(WorldRay { origin: DVec3::new(ox, oy, oz), direction: DVec3::new(dx, dy, dz) })
}

/// Numbers between commas.
pub fn numbers<T: FromStr, const N: usize>(text: &str) -> Option<[T; N]> {
    let numbers: Option<Vec<T>> =
        text.split(',').map(|number| number.trim().parse().ok()).collect();
    numbers?.try_into().ok()
}

/// Refuses a picture that is too large, whatever the memory.
///
/// # Errors
/// [`Error::TooLarge`]
pub fn check_size([width, height]: [u32; 2]) -> Result<[u32; 2]> {
    if width.max(height) > MAX_SIDE {
        return Err(Error::TooLarge(format!(
            "--size {width}x{height}: a picture has at most {MAX_SIDE} pixels a side; render several \
             with different cameras"
        ).into()));
    }
    Ok([width, height])
}

impl WholeArgs {
    /// All pixels of the picture: of the command line's size, else the scene's, else 1280 × 720.
    ///
    /// # Errors
    /// [`Error::Scene`] without a camera in the scene at `path`, [`Error::TooLarge`].
    pub fn pixels(&self, scene: &Scene, path: &Path) -> Result<Pixels> {
        let view = View::new(scene.require_camera(path)?);
        let [width, height] = check_size(self.size.or(scene.image).unwrap_or(DEFAULT_SIZE))?;
        Ok(Pixels::whole(view, width, height))
    }
}

impl SizeArgs {
    /// The pixels that the options, else the scene at `path`, ask for.
    ///
    /// # Errors
    /// [`Error::Scene`] without a camera, [`Error::TooLarge`] and [`Error::Usage`] for a size or
    /// crop that can't be.
    pub fn pixels(&self, scene: &Scene, path: &Path) -> Result<Pixels> {
        let pixels = self.whole.pixels(scene, path)?;
        let Some(crop @ [x, y, width, height]) = self.crop else { return Ok(pixels) };
        pixels.part(crop).ok_or_else(|| {
            Error::Usage(
                format!(
                    "--crop {x},{y},{width},{height} is not inside the picture of {}x{} pixels",
                    pixels.image_width, pixels.image_height
                )
                .into(),
            )
        })
    }
}

impl SceneArgs {
    /// The scene as these options have it.
    ///
    /// # Errors
    /// Those of [`PictureArgs::scene`](crate::picture::PictureArgs::scene).
    pub fn scene(&self, run: &Run) -> Result<Arc<Scene>> {
        self.picture.scene(&self.path, self.size.whole.size, run)
    }

    /// The pixels that are asked for of this scene.
    ///
    /// # Errors
    /// Those of [`SizeArgs::pixels`].
    pub fn pixels(&self, scene: &Scene) -> Result<Pixels> {
        self.size.pixels(scene, &self.path)
    }
}
