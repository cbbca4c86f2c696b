//! What a picture says of how it was made: texts in PNG, attributes in OpenEXR.
//!
//! Nothing in it depends on the device, the driver, the number of threads or the time, so that a file
//! has the same bytes wherever it was made. So there are no counts of what each stage decided, which
//! differ between devices: of those, the channel `level` of `--certificates` tells.

use crate::kernel::Kernel;
use crate::lighting::Style;
use crate::rays::{Pixels, View};
use crate::scene::Camera;
use crate::scene::schema::{CameraKeys, Value as _};

/// Before the names of all texts but the program's.
const PREFIX: &str = "kugelblitz.";

/// The name of the text with the part of the whole picture.
const WINDOW: &str = "kugelblitz.window";

/// The name of the text with the size of the whole picture.
const SIZE: &str = "kugelblitz.size";

/// Names and texts, in order; empty for a picture that says nothing but its program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata(Vec<(String, String)>);

impl Metadata {
    /// What is to be said of a picture of the scene with this hash, see [`crate::digest::scene_hash`], with the camera that the
    /// scene or the caller named.
    pub fn new(
        scene: &str,
        camera: Option<&Camera>,
        pixels: &Pixels,
        kernel: Kernel,
        style: &Style,
    ) -> Metadata {
        let Style { n_samples, epsilon, .. } = *style;
        let Pixels { view, image_width, image_height, x, y, width, height } = *pixels;
        let mut texts = Metadata::default();
        texts.add("scene", scene);
        // The caller may look through another one.
        if let Some(camera) = camera.filter(|camera| View::new(camera) == view) {
            texts.add("camera", &format!("camera = {}", CameraKeys::from(camera).toml()));
        }
        texts.add("size", &format!("{image_width}x{image_height}"));
        if (width, height) != (image_width, image_height) {
            texts.add("window", &format!("{x},{y},{width},{height}"));
        }
        texts.add("samples", &format!("{0}x{0}", n_samples.across()));
        texts.add("kernel", kernel.name());
        if epsilon != 0.0 {
            texts.add("epsilon", &format!("{epsilon:?}"));
        }
        let n_pixels = pixels.len();
        let n_proven = if kernel == Kernel::Certified { n_pixels } else { 0 };
        texts.add("certificate", &format!("{n_proven} of {n_pixels} pixels proven"));
        texts
    }

    fn add(&mut self, name: &str, text: &str) {
        self.0.push((format!("{PREFIX}{name}"), text.to_owned()));
    }

    /// The names and texts.
    pub(super) fn texts(&self) -> &[(String, String)] {
        &self.0
    }
}

/// Size of the whole picture and the place of this part in it, where it is one and the texts tell.
pub(super) fn window_of(texts: &[(String, String)]) -> Option<([usize; 2], [i64; 4])> {
    let text = |name| texts.iter().find(|(of, _)| of == name).map(|(_, text)| text.as_str());
    let (width, height) = text(SIZE)?.split_once('x')?;
    let numbers: Option<Vec<i64>> = text(WINDOW)?.split(',').map(|n| n.parse().ok()).collect();
    Some(([width.parse().ok()?, height.parse().ok()?], numbers?.try_into().ok()?))
}
