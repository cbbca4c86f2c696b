//! Exact pictures, to compare other ones with.

use kugelblitz::Control;
use kugelblitz::error::Message;
use kugelblitz::lighting::{Encoding, Style};
use kugelblitz::picture::{ChannelValues, Image};
use kugelblitz::query::{Kernel, Outputs};
use kugelblitz::rays::Pixels;
use kugelblitz::scene::{Camera, Samples, parse_scene};
use kugelblitz::{Error, Result, Session};

use crate::wrong_usage;

/// The channels of an exact picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExactChannels {
    /// Colours of this type.
    Colors(ColorKind),
    /// Colours as bytes, ids, `t` and normals.
    All,
}

/// Type of the numbers of colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ColorKind(Encoding);

impl ColorKind {
    /// Returns the type of a picture's colours; `None` for a picture without colours.
    pub fn of(image: &Image) -> Option<ColorKind> {
        let [red, _, _] = ["R", "G", "B"].map(|name| image.channel(name));
        Some(ColorKind(match red? {
            ChannelValues::U8(_) => Encoding::Srgb8,
            ChannelValues::U16(_) => Encoding::Srgb16,
            _ => Encoding::Linear,
        }))
    }
}

/// Renders the exact picture of `pixels` into memory.
///
/// # Errors
/// Returns [`Error::Usage`] for a session with another kernel than `certified`, and the errors of [`Session::keep`].
pub fn exact_picture(
    session: &mut Session,
    pixels: &Pixels,
    n_samples: Samples,
    channels: ExactChannels,
    control: &Control,
) -> Result<Image> {
    if session.kernel() != Kernel::Certified {
        let name = session.kernel().name();
        return wrong_usage(format!("{name} proves nothing; compare with certified"));
    }
    let (encoding, has_hits) = match channels {
        ExactChannels::Colors(ColorKind(encoding)) => (encoding, false),
        ExactChannels::All => (Encoding::Srgb8, true),
    };
    let style = Style { n_samples, ..Style::new(encoding) };
    let wants = Outputs { surface: has_hits, level: false };
    let (kept, _) = session.keep(pixels, style, wants, control)?;
    let hits = has_hits.then_some(&kept.hits);
    Ok(Image::of_pixels("exact picture", pixels, &kept.colors, hits))
}

/// Name of the text with the camera.
const CAMERA: &str = "kugelblitz.camera";

/// Whether a picture carries a camera.
pub fn has_camera(image: &Image) -> bool {
    image.text(CAMERA).is_some()
}

/// Returns the camera that a picture by this program carries.
///
/// # Errors
/// Returns [`Error::Usage`] for a camera that no scene can have.
pub fn camera_of(image: &Image) -> Result<Option<Camera>> {
    let Some(text) = image.text(CAMERA) else { return Ok(None) };
    let scene = parse_scene(text, "the picture's camera".as_ref());
    let scene = scene.map_err(|error| Error::Usage(Message::from(error.to_string())))?;
    Ok(scene.camera)
}

/// Returns the samples across and down a pixel that a picture by this program carries.
pub fn samples_of(image: &Image) -> Option<Samples> {
    let (across, _) = image.text("kugelblitz.samples")?.split_once('x')?;
    Samples::new(across.parse().ok()?).ok()
}
