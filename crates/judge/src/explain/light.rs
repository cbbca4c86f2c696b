//! What lights the point that a ray sees, and the bytes that come out.

use serde::Serialize;

use super::derivation::Derivation;
use super::numbers::Exact;
use super::words::Remark;

/// Light on the point that a ray sees, and the resulting colour.
#[derive(Clone, Debug, Serialize)]
pub struct ShadingExplanation {
    /// Lights, in the order of the scene file; none for the background.
    pub lights: Vec<LightExplanation>,
    /// Sky; `null` without one.
    pub sky: Option<SkyExplanation>,
    /// Colour of the ray.
    pub color: ColorExplanation,
    /// Colour of the pixel as the mean of several samples; `null` with one sample.
    pub mean: Option<MeanExplanation>,
}

/// A light and its effect on the point.
#[derive(Clone, Debug, Serialize)]
pub struct LightExplanation {
    /// Number in the order of the scene file: `light 1`.
    pub name: String,
    /// Position or direction in words: `at (4, 6, 3)`.
    pub place: Remark,
    /// Whether the light illuminates the point, by exact arithmetic.
    pub verdict: LightVerdict,
    /// The verdict in words, and remarks.
    pub why: Vec<Remark>,
    /// `w`, `n·ω`, `s` of what is in its way, and what it gives.
    #[serde(flatten)]
    pub derivation: Derivation,
}

/// Whether a light illuminates a point.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum LightVerdict {
    /// The light illuminates the point.
    Counts,
    /// The light is behind the surface, `n·ω < 0`.
    Behind,
    /// The light is in the tangent plane, `n·ω = 0`, or at the point itself.
    Grazing,
    /// An object occludes the light.
    Hidden {
        /// Id of the first occluder.
        by: u32,
    },
    /// The light is black, or its intensity is 0.
    Dark,
}

/// The directions of the sky.
#[derive(Clone, Debug, Serialize)]
pub struct SkyExplanation {
    /// Number of directions of the sky.
    pub directions: usize,
    /// Directions that illuminate the point.
    pub counting: usize,
    /// Directions behind the surface.
    pub behind: usize,
    /// Directions that an object occludes.
    pub hidden: usize,
    /// How many count, and what they give together.
    #[serde(flatten)]
    pub derivation: Derivation,
}

/// A linear colour and its bytes. Unstable in JSON.
#[derive(Clone, Debug, Serialize)]
pub struct ColorExplanation {
    /// Red, green and blue.
    pub channels: [ChannelByte; 3],
    /// The channels in each arithmetic; how they come about, where light falls on what is seen.
    #[serde(flatten)]
    pub derivation: Derivation,
    /// Remarks.
    pub why: Vec<Remark>,
}

/// A channel and its byte.
#[derive(Clone, Debug, Serialize)]
pub struct ChannelByte {
    /// `red`, `green` or `blue`.
    pub name: &'static str,
    /// Byte of the channel.
    pub byte: u8,
    /// Range of linear values with this byte, without its upper end. The lower end for 0 and the upper end for 255 are
    /// infinite, which is `null` in JSON.
    pub range: [f64; 2],
    /// Distance of the exact value from the nearest end of `range`.
    pub from_edge: Exact,
}

/// The colour of a pixel.
#[derive(Clone, Debug, Serialize)]
pub struct MeanExplanation {
    /// Number of samples across a pixel, and down it.
    pub samples: u32,
    /// Mean of the samples.
    pub color: ColorExplanation,
}
