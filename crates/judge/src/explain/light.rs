//! What lights the point that a ray sees, and the bytes that come out.

use serde::Serialize;

use super::derivation::Derivation;
use super::numbers::Exact;
use super::words::Remark;

/// How the point that a ray sees is lit, and the colour that comes of it.
#[derive(Clone, Debug, Serialize)]
pub struct Shading {
    /// The lights, in the order of the scene file; none for the background.
    pub lights: Vec<LightExplanation>,
    /// The sky.
    pub sky: Option<SkyExplanation>,
    /// The colour of the ray.
    pub color: ColorExplanation,
    /// The colour of the pixel, where it is the mean of several samples.
    pub mean: Option<MeanExplanation>,
}

/// A light as it falls on the point.
#[derive(Clone, Debug, Serialize)]
pub struct LightExplanation {
    /// `light 1`, counted in the order of the scene file.
    pub name: String,
    /// `at (4, 6, 3)`
    pub place: Remark,
    /// Whether it counts, exactly.
    pub verdict: LightVerdict,
    /// The verdict in words, and what else is worth a remark.
    pub why: Vec<Remark>,
    /// `w`, `n·ω`, `s` of what is in its way, and what it gives.
    #[serde(flatten)]
    pub derivation: Derivation,
}

/// Whether a light counts.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum LightVerdict {
    /// It counts.
    Counts,
    /// `n·ω < 0`.
    Behind,
    /// `n·ω = 0`; also a light at the point itself.
    Grazing,
    /// Something is in its way.
    Hidden {
        /// Id of the first object in the way.
        by: u32,
    },
    /// It is black, or its intensity is 0.
    Dark,
}

/// The suns of the sky.
#[derive(Clone, Debug, Serialize)]
pub struct SkyExplanation {
    /// All of them.
    pub directions: usize,
    /// Suns that illuminate the point.
    pub counting: usize,
    /// Suns below the surface's horizon.
    pub behind: usize,
    /// Suns that something hides from the point.
    pub hidden: usize,
    /// How many count, and what they give together.
    #[serde(flatten)]
    pub derivation: Derivation,
}

/// A linear colour and its bytes.
#[derive(Clone, Debug, Serialize)]
pub struct ColorExplanation {
    /// Red, green and blue.
    pub channels: [ChannelByte; 3],
    /// The channels in each arithmetic; how they come about, where light falls on what is seen.
    #[serde(flatten)]
    pub derivation: Derivation,
    /// What is worth a remark.
    pub why: Vec<Remark>,
}

/// A channel and its byte.
#[derive(Clone, Debug, Serialize)]
pub struct ChannelByte {
    /// `red`, `green` or `blue`.
    pub name: &'static str,
    /// The byte.
    pub byte: u8,
    /// The linear values that it stands for, from the first to below the second; endless for 0 and
    /// 255.
    pub range: [f64; 2],
    /// How far the exact value is from the nearest end of the range.
    pub from_edge: Exact,
}

/// The colour of a pixel.
#[derive(Clone, Debug, Serialize)]
pub struct MeanExplanation {
    /// Samples across and down the pixel.
    pub samples: u32,
    /// Their mean.
    pub color: ColorExplanation,
}
