//! What the numbers of another renderer mean.

use std::str::FromStr;

use kugelblitz::words::did_you_mean_at_end;
use kugelblitz::{Error, Result};
use serde::Deserialize;

/// What a channel tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Which object is seen.
    Id,
    /// Depth along the view axis; of a list of rays, the ray parameter.
    Depth,
    /// Distance from where the ray starts.
    Distance,
    /// Depth as a rasteriser keeps it: 0 at the near plane, 1 at the far one.
    ZBuffer,
    /// The normal.
    Normal,
    /// The object's own colour, in place of an id.
    Color,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Quantity; 6] = [
        Quantity::Id,
        Quantity::Depth,
        Quantity::Distance,
        Quantity::ZBuffer,
        Quantity::Normal,
        Quantity::Color,
    ];

    /// The quantity's name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Id => "id",
            Quantity::Depth => "depth",
            Quantity::Distance => "distance",
            Quantity::ZBuffer => "zbuffer",
            Quantity::Normal => "normal",
            Quantity::Color => "color",
        }
    }

    /// Whether it tells how far away something is.
    pub(super) fn is_depth(self) -> bool {
        matches!(self, Quantity::Depth | Quantity::Distance | Quantity::ZBuffer)
    }
}

impl FromStr for Quantity {
    type Err = Error;

    fn from_str(name: &str) -> Result<Quantity> {
        Quantity::ALL.into_iter().find(|quantity| quantity.name() == name).ok_or_else(|| {
            let names = Quantity::ALL.map(Quantity::name);
            let (known, near) = (names.join(", "), did_you_mean_at_end(names, name));
            Error::Usage(
                format!("“{name}” is nothing that a channel tells; use {known}{near}").into(),
            )
        })
    }
}

/// Which of its two directions a normal has.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum NormalSide {
    /// The one that faces the ray.
    #[default]
    Facing,
    /// Out of a sphere, and as the scene gives it for a plane.
    Outward,
    /// Any of them.
    Either,
}

/// The axes that normals are told in.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum NormalSpace {
    /// The world's.
    #[default]
    World,
    /// The camera's: right, up, and against the view axis.
    Camera,
}

/// What the numbers of another renderer mean; by default they mean what this program's own do.
/// Read by serde, it has the names of the command line's options.
#[derive(Clone, Debug, Deserialize, PartialEq)]
#[serde(default, deny_unknown_fields)]
pub struct Conventions {
    /// What is judged; nothing: all that the names of the channels tell.
    #[serde(skip)]
    pub quantities: Vec<Quantity>,
    /// The channel to be judged, where its name tells nothing; of normals what stands before `.X`.
    pub channel: Option<String>,
    /// What is added to ids to make them count from 1.
    pub id_offset: i64,
    /// The id of the background. Without one, −1 and 2^32 − 1 mean it, and what is 0 with the offset.
    pub no_hit: Option<i64>,
    /// The depth of the background, beside +∞.
    pub background: Option<f64>,
    /// Length of a unit of depths, in the scene's.
    pub scale: f64,
    /// Distances of the near and the far plane of a z-buffer; where the near one is farther away, the
    /// buffer is reversed.
    pub near_far: Option<[f64; 2]>,
    /// The direction of normals.
    #[serde(rename = "normals")]
    pub normal_side: NormalSide,
    /// The axes of normals.
    pub normal_space: NormalSpace,
    /// How far a colour's bytes may be off, levels.
    pub color_tolerance: u8,
    /// True where the first row is the lowest.
    pub rows_from_below: bool,
}

impl Conventions {
    /// Levels that other renderers' own rounding of colours takes.
    pub const COLOR_TOLERANCE: u8 = 1;
}

impl Default for Conventions {
    fn default() -> Conventions {
        Conventions {
            quantities: Vec::new(),
            channel: None,
            id_offset: 0,
            no_hit: None,
            background: None,
            scale: 1.0,
            near_far: None,
            normal_side: NormalSide::default(),
            normal_space: NormalSpace::default(),
            color_tolerance: Conventions::COLOR_TOLERANCE,
            rows_from_below: false,
        }
    }
}
