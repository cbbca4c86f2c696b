//! The results of another renderer, as numbers of one meaning.

use std::str::FromStr;

use glam::DVec3;
use kugelblitz::error::{Hint, Message, Setting};
use kugelblitz::picture::{ChannelValues, Image};
use kugelblitz::words::did_you_mean_at_end;
use kugelblitz::{Error, Result};

use super::RayResult;
use crate::verify::TrueHit;
use crate::wrong_usage;

/// A quantity that a file has of each ray or pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Id of the visible object.
    Id,
    /// Depth along the view axis; of a list of rays, the ray parameter.
    Depth,
    /// Distance from the ray's origin.
    Distance,
    /// Normal at the visible point.
    Normal,
    /// Colour of the pixel.
    Color,
}

impl Quantity {
    /// All quantities.
    pub const ALL: [Quantity; 5] =
        [Quantity::Id, Quantity::Depth, Quantity::Distance, Quantity::Normal, Quantity::Color];

    /// Name of the quantity on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Id => "id",
            Quantity::Depth => "depth",
            Quantity::Distance => "distance",
            Quantity::Normal => "normal",
            Quantity::Color => "color",
        }
    }

    /// Whether the quantity is a result of a ray, not a colour.
    pub fn is_of_hits(self) -> bool {
        self != Quantity::Color
    }
}

impl FromStr for Quantity {
    type Err = Error;

    fn from_str(name: &str) -> Result<Quantity> {
        Quantity::ALL.into_iter().find(|quantity| quantity.name() == name).ok_or_else(|| {
            let names = Quantity::ALL.map(Quantity::name);
            let (known, near) = (names.join(", "), did_you_mean_at_end(names, name));
            Error::Usage(format!("no quantity is called “{name}”; give {known}{near}").into())
        })
    }
}

/// Names of channels with ids.
const ID_NAMES: [&str; 8] =
    ["id", "ID", "Id", "ids", "objectId", "object_id", "objectID", "primID"];

/// Names of channels with depths along the view axis.
const DEPTH_NAMES: [&str; 6] = ["Z", "t", "depth", "Depth", "depth.Z", "Depth.Z"];

/// Names of channels with distances.
const DISTANCE_NAMES: [&str; 4] = ["distance", "Distance", "dist", "range"];

/// What stands before the axis in the names of channels with normals.
const NORMAL_NAMES: [&str; 7] = ["N", "normal", "Normal", "normals", "Normals", "Ng", "Ns"];

/// Names of the axes of channels.
const AXES: [[&str; 3]; 4] = [["X", "Y", "Z"], ["x", "y", "z"], ["0", "1", "2"], ["R", "G", "B"]];

/// Meaning of a depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum DepthKind {
    /// The ray parameter: with a camera, the depth along the view axis.
    Parameter,
    /// The distance from the ray's origin.
    Distance,
}

/// Depths of rays.
#[derive(Clone, Debug)]
struct Depths {
    kind: DepthKind,
    /// +∞ if nothing is hit.
    values: Vec<f64>,
    /// Number of a whole-number type that is 1 in a z-buffer.
    full: f64,
}

/// The direction of normals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum NormalSide {
    /// Towards the ray.
    #[default]
    Facing,
    /// Out of a sphere, and as the scene has it for a plane.
    Outward,
    /// Into a sphere, and as the scene has it for a plane.
    Inward,
    /// Any of the two.
    Either,
}

/// Results of another renderer, ray by ray.
#[derive(Clone, Debug)]
pub struct Claims {
    /// `None` for the background. Absent if the file has no ids.
    ids: Option<Vec<Option<i64>>>,
    depths: Option<Depths>,
    normals: Option<Vec<DVec3>>,
    pub(super) normal_side: NormalSide,
}

/// An id that no object has.
const NO_OBJECT: u32 = u32::MAX;

/// Minimum length of a normal; shorter vectors mean that nothing was hit.
const MIN_NORMAL: f64 = 0.5;

impl Claims {
    /// Reads these quantities of a picture or of a list of results, at these indices of its pixels or results.
    ///
    /// # Errors
    /// Returns [`Error::Usage`] if the picture lacks a quantity.
    pub fn new(
        image: &Image,
        quantities: &[Quantity],
        channel: Option<&str>,
        indices: &[usize],
    ) -> Result<Claims> {
        let mut claims =
            Claims { ids: None, depths: None, normals: None, normal_side: NormalSide::default() };
        for &quantity in quantities.iter().filter(|quantity| quantity.is_of_hits()) {
            let channels = find(quantity, image, channel)?;
            let all = indices.iter().copied();
            match quantity {
                Quantity::Id => claims.ids = Some(all.map(|i| id_of(channels[0], i)).collect()),
                Quantity::Normal => {
                    claims.normals = Some(all.map(|i| normal_of(&channels, i)).collect());
                }
                depth => {
                    if claims.depths.is_some() {
                        return wrong_usage("t is of one kind: give one of depth and distance");
                    }
                    let kind = match depth {
                        Quantity::Distance => DepthKind::Distance,
                        _ => DepthKind::Parameter,
                    };
                    let values = all.map(|i| channels[0].number(i)).collect();
                    let full = channels[0].full().unwrap_or(1.0);
                    claims.depths = Some(Depths { kind, values, full });
                }
            }
        }
        Ok(claims)
    }

    /// Whether there are ids.
    pub(super) fn has_ids(&self) -> bool {
        self.ids.is_some()
    }

    /// Whether there are normals.
    pub(super) fn has_normals(&self) -> bool {
        self.normals.is_some()
    }

    /// Returns the kind of depths; `None` without depths.
    pub(super) fn depth_kind(&self) -> Option<DepthKind> {
        self.depths.as_ref().map(|depths| depths.kind)
    }

    /// Returns the id of a ray, `None` for the background, if there are ids.
    pub(super) fn id(&self, ray: usize) -> Option<Option<i64>> {
        self.ids.as_ref().map(|ids| ids[ray])
    }

    /// Returns `t` or the distance of a ray.
    pub fn depth(&self, ray: usize) -> Option<f64> {
        self.depths.as_ref().map(|depths| depths.values[ray])
    }

    /// Returns the normal of a ray.
    pub fn normal(&self, ray: usize) -> Option<DVec3> {
        self.normals.as_ref().map(|normals| normals[ray])
    }

    /// Returns the number of the depths' type that is 1 in a z-buffer.
    pub(super) fn depth_full(&self) -> f64 {
        self.depths.as_ref().map_or(1.0, |depths| depths.full)
    }

    /// Returns the factor by which the exact `t` of a ray is multiplied to be compared; `length` is that of its direction.
    pub(super) fn t_factor(&self, length: f64) -> f64 {
        match self.depth_kind() {
            Some(DepthKind::Distance) => length,
            _ => 1.0,
        }
    }

    pub(super) fn set_depth_kind(&mut self, kind: DepthKind) {
        if let Some(depths) = &mut self.depths {
            depths.kind = kind;
        }
    }

    pub(super) fn map_ids(&mut self, map: impl Fn(Option<i64>) -> Option<i64>) {
        self.ids.iter_mut().flatten().for_each(|id| *id = map(*id));
    }

    pub(super) fn map_depths(&mut self, map: impl Fn(f64) -> f64) {
        let values = self.depths.iter_mut().flat_map(|depths| &mut depths.values);
        values.for_each(|t| *t = map(*t));
    }

    /// Replaces depths by a function of numbers from 0 to 1.
    pub(super) fn map_z_buffer(&mut self, map: impl Fn(f64) -> f64) {
        let full = self.depth_full();
        self.map_depths(|z| map(z / full));
    }

    pub(super) fn map_normals(&mut self, map: impl Fn(DVec3) -> DVec3) {
        self.normals.iter_mut().flatten().for_each(|normal| *normal = map(*normal));
    }

    /// Returns whether a ray hits something, by its depth or its normal.
    pub(super) fn is_hit(&self, ray: usize) -> bool {
        match (self.depth(ray), self.normal(ray)) {
            (Some(t), _) => t != f64::INFINITY,
            (None, normal) => normal.is_some_and(|normal| normal.length() >= MIN_NORMAL),
        }
    }

    /// Returns the result of a ray, to be compared with the exact one: with the exact id if the file has none, and with the normal
    /// turned to the side of the ray.
    pub(super) fn result(&self, ray: usize, exact: &TrueHit, is_plane: bool) -> RayResult {
        let id = match self.id(ray) {
            Some(None) => 0,
            Some(Some(id)) => u32::try_from(id).unwrap_or(NO_OBJECT),
            None if !self.is_hit(ray) => 0,
            None if exact.id == 0 => NO_OBJECT,
            None => exact.id,
        };
        if id == 0 {
            return RayResult { id, t: None, normal: None };
        }
        let is_facing = |normal: DVec3| normal.dot(exact.normal.into()) >= 0.0;
        let turned = |normal: DVec3| match self.normal_side {
            NormalSide::Outward if exact.is_back => -normal,
            // As the scene has it for a plane.
            NormalSide::Inward if exact.is_back == is_plane => -normal,
            NormalSide::Either if !is_facing(normal) => -normal,
            _ => normal,
        };
        RayResult { id, t: self.depth(ray), normal: self.normal(ray).map(turned) }
    }
}

fn id_of(ids: &ChannelValues, i: usize) -> Option<i64> {
    match ids.whole(i) {
        Some(-1) => None,
        Some(id) if id == i64::from(u32::MAX) => None,
        Some(id) => Some(id),
        // A float that is not whole is no object's id; NaN and infinity are the background.
        None => ids.number(i).is_finite().then_some(i64::MAX),
    }
}

fn normal_of(channels: &[&ChannelValues], i: usize) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|axis| match channels[axis].full() {
        // −1 to 1, as whole numbers store it.
        Some(full) => 2.0 * channels[axis].number(i) / full - 1.0,
        None => channels[axis].number(i),
    }))
}

/// Returns the channels of a quantity.
fn find<'a>(
    quantity: Quantity,
    image: &'a Image,
    channel: Option<&str>,
) -> Result<Vec<&'a ChannelValues>> {
    let found = match (quantity, channel) {
        (Quantity::Normal, Some(name)) => three_of(image, name),
        (_, None) => named(quantity, image),
        (_, Some(name)) => {
            let channel = image.channel(name).ok_or_else(|| {
                let near = did_you_mean_at_end(names(image), name);
                Error::Usage(
                    format!("the {} file has no channel {name}{near}", image.format).into(),
                )
            })?;
            Some(vec![channel])
        }
    };
    let unnamed = || match (quantity, &*image.channels) {
        (Quantity::Normal, _) if channel.is_none() => named(Quantity::Color, image),
        (Quantity::Normal, _) => None,
        (_, [only]) => Some(vec![&only.samples]),
        (Quantity::Distance, _) => named(Quantity::Depth, image),
        _ => None,
    };
    found.or_else(unnamed).ok_or_else(|| {
        let what = match quantity {
            Quantity::Id => "ids",
            Quantity::Normal => "normals",
            other => other.name(),
        };
        let hint = Hint::new("name one with {}", [Setting::named("channel")]);
        let channels = names(image).join(", ");
        Error::Usage(Message::new(
            format!("the {} file has no channel with {what}, but {channels}", image.format),
            hint,
        ))
    })
}

/// Returns the quantities that the names of the channels tell.
///
/// # Errors
/// Returns [`Error::Usage`] if they tell nothing.
pub fn quantities_of(image: &Image, channel: Option<&str>) -> Result<Vec<Quantity>> {
    let has = |quantity: &Quantity| named(*quantity, image).is_some();
    let depth = if has(&Quantity::Depth) { Quantity::Depth } else { Quantity::Distance };
    let mut found = vec![Quantity::Id, depth, Quantity::Normal];
    found.retain(has);
    // Floats of a plain array may be normals.
    if let Some([red, ..]) = named(Quantity::Color, image).as_deref()
        && (red.full().is_some() || image.format == "OpenEXR" || !found.is_empty())
    {
        found.push(Quantity::Color);
    }
    if !found.is_empty() && channel.is_none() {
        return Ok(found);
    }
    let channels = names(image);
    let text = format!(
        "{} of the {} file may be anything: {}",
        if channels.len() == 1 { "the channel" } else { "each of the channels" },
        image.format,
        channels.join(", "),
    );
    let quantities = Quantity::ALL.map(Quantity::name).join(", ");
    let hint = Hint::new(&format!("give {{}}: {quantities}"), [Setting::named("as")]);
    wrong_usage(Message::new(text, hint))
}

fn names(image: &Image) -> Vec<&str> {
    image.channels.iter().map(|channel| channel.name.as_str()).collect()
}

/// Returns the channels with a known name of a quantity.
fn named(quantity: Quantity, image: &Image) -> Option<Vec<&ChannelValues>> {
    let known: &[&str] = match quantity {
        Quantity::Id => &ID_NAMES,
        Quantity::Depth => &DEPTH_NAMES,
        Quantity::Distance => &DISTANCE_NAMES,
        Quantity::Normal => return NORMAL_NAMES.iter().find_map(|name| three_of(image, name)),
        Quantity::Color => return ["R", "G", "B"].iter().map(|name| image.channel(name)).collect(),
    };
    known.iter().find_map(|name| image.channel(name)).map(|channel| vec![channel])
}

/// Returns the three channels of a vector.
fn three_of<'a>(image: &'a Image, prefix: &str) -> Option<Vec<&'a ChannelValues>> {
    AXES.iter().find_map(|axes| {
        axes.iter().map(|axis| image.channel(&format!("{prefix}.{axis}"))).collect()
    })
}
