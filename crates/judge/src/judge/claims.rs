//! What another renderer says of each ray.

use glam::DVec3;
use kugelblitz::picture::{ChannelValues, Image};
use kugelblitz::rays::{Lens, Rays, View};
use kugelblitz::scene::Color;
use kugelblitz::words::did_you_mean_at_end;
use kugelblitz::{Error, Result};

use super::conventions::{Conventions, NormalSide, NormalSpace, Quantity};
use crate::compare::RayResult;
use crate::wrong_usage;

/// An id that no object has.
const NO_OBJECT: u32 = u32::MAX;

/// Vectors that are shorter are no normals: nothing was hit.
const LEAST_NORMAL: f64 = 0.5;

/// Names of channels with ids.
const ID_NAMES: [&str; 8] =
    ["id", "ID", "Id", "ids", "objectId", "object_id", "objectID", "primID"];

/// Names of channels with depths along the view axis.
const DEPTH_NAMES: [&str; 6] = ["Z", "t", "depth", "Depth", "depth.Z", "Depth.Z"];

/// Names of channels with distances.
const DISTANCE_NAMES: [&str; 4] = ["distance", "Distance", "dist", "range"];

/// What stands before the axis in the names of channels with normals.
const NORMAL_NAMES: [&str; 7] = ["N", "normal", "Normal", "normals", "Normals", "Ng", "Ns"];

/// The axes, as channels are named.
const AXES: [[&str; 3]; 4] = [["X", "Y", "Z"], ["x", "y", "z"], ["0", "1", "2"], ["R", "G", "B"]];

/// What each ray is said to see.
#[derive(Clone, Debug, PartialEq)]
pub enum ClaimedHits {
    /// Ids as this program counts them.
    Ids(Vec<u32>),
    /// The objects' own colours, as sRGB, each with so many levels for rounding.
    Colors {
        /// The colour of each ray.
        srgb8: Vec<[u8; 3]>,
        /// Levels.
        tolerance: u8,
    },
    /// Whether anything is hit: where there is no id, but a depth or a normal.
    Hit(Vec<bool>),
}

/// What another renderer says of each ray, in this program's conventions.
#[derive(Clone, Debug, PartialEq)]
pub struct Claims {
    /// What it sees.
    pub seen: ClaimedHits,
    /// The ray parameter, or the distance.
    pub t: Option<Vec<f64>>,
    /// Whether `t` is the distance from where the ray starts.
    pub is_distance: bool,
    /// Normals of any length, in the world's axes.
    pub normal: Option<Vec<DVec3>>,
    /// The direction of the normals.
    pub side: NormalSide,
    /// What was found in the file.
    pub quantities: Vec<Quantity>,
}

impl Claims {
    /// Reads the claims of a picture of these rays, or of a list of results.
    ///
    /// # Errors
    /// [`Error::Usage`] where the picture does not have what is asked for, or where its channels' names tell
    /// nothing.
    pub fn new(mut image: Image, conventions: &Conventions, rays: &Rays) -> Result<Claims> {
        if conventions.rows_from_below {
            image.turn_over();
        }
        let quantities = match conventions.quantities.as_slice() {
            [] => quantities_of(&image, conventions)?,
            given => given.to_vec(),
        };
        if conventions.channel.is_some() && quantities.len() != 1 {
            return wrong_usage("--channel names one channel; say with --as what it tells");
        }
        let view = rays.pixels().map(|pixels| &pixels.view);
        let reader = Reader { image: &image, conventions, view };
        let (mut ids, mut colors, mut normal, mut depth) = (None, None, None, None);
        for &quantity in &quantities {
            match quantity {
                Quantity::Id => ids = Some(reader.ids()?),
                Quantity::Color => colors = Some(reader.colors()?),
                Quantity::Normal => normal = Some(reader.normals()?),
                _ if depth.is_some() => {
                    return wrong_usage(
                        "depths are of one kind: give one of depth, distance and zbuffer",
                    );
                }
                _ => depth = Some(reader.depths(quantity)?),
            }
        }
        let (t, is_hit) = depth.unzip();
        let tolerance = conventions.color_tolerance;
        let seen = match (ids, colors, is_hit, &normal) {
            (Some(ids), ..) => ClaimedHits::Ids(ids),
            (_, Some(srgb8), ..) => ClaimedHits::Colors { srgb8, tolerance },
            (_, _, Some(is_hit), _) => ClaimedHits::Hit(is_hit),
            (.., Some(normals)) => {
                let is_hit = normals.iter().map(|normal| normal.length() >= LEAST_NORMAL);
                ClaimedHits::Hit(is_hit.collect())
            }
            _ => return wrong_usage("there is nothing to be judged"),
        };
        Ok(Claims {
            seen,
            t,
            is_distance: quantities.contains(&Quantity::Distance),
            normal,
            side: conventions.normal_side,
            quantities,
        })
    }

    /// What is said of a ray, in terms of what is right there: of the right object where it may be meant, and with the
    /// normal that the right one is to be compared with.
    pub(super) fn row(
        &self,
        i: usize,
        right: &RayResult,
        is_back: bool,
        palette: &[[u8; 3]],
    ) -> RayResult {
        let object = if right.id == 0 { NO_OBJECT } else { right.id };
        let id = match &self.seen {
            ClaimedHits::Ids(ids) => ids[i],
            ClaimedHits::Hit(hit) if hit[i] => object,
            ClaimedHits::Hit(_) => 0,
            seen if seen.has_color(i, palette[right.id as usize]) => right.id,
            seen if seen.has_color(i, palette[0]) => 0,
            ClaimedHits::Colors { .. } => NO_OBJECT,
        };
        let faces = |normal: DVec3| right.normal.is_none_or(|right| normal.dot(right) >= 0.0);
        let turned = |normal: DVec3| match self.side {
            NormalSide::Outward if is_back => -normal,
            NormalSide::Either if !faces(normal) => -normal,
            _ => normal,
        };
        let normal = self.normal.as_ref().map(|normals| turned(normals[i]));
        RayResult { id, t: self.t.as_ref().map(|t| t[i]), normal }
    }
}

impl ClaimedHits {
    /// Whether a ray is said to see this colour.
    pub(super) fn has_color(&self, ray: usize, color: [u8; 3]) -> bool {
        let ClaimedHits::Colors { srgb8, tolerance } = self else { return false };
        color.into_iter().zip(srgb8[ray]).all(|(a, b)| a.abs_diff(b) <= *tolerance)
    }
}

/// What the names of the channels tell. Colours are looked at where there is nothing else.
fn quantities_of(image: &Image, conventions: &Conventions) -> Result<Vec<Quantity>> {
    let has = |names: &[&str]| names.iter().any(|name| image.channel(name).is_some());
    let has_depth = has(&DEPTH_NAMES);
    let depth = if conventions.near_far.is_some() { Quantity::ZBuffer } else { Quantity::Depth };
    let known = [
        (Quantity::Id, has(&ID_NAMES)),
        (depth, has_depth),
        (Quantity::Distance, !has_depth && has(&DISTANCE_NAMES)),
        (Quantity::Normal, NORMAL_NAMES.iter().any(|name| three_of(image, name).is_some())),
    ];
    let mut found: Vec<_> =
        known.into_iter().filter(|(_, is_there)| *is_there).map(|(q, _)| q).collect();
    if found.is_empty()
        && let Some([red, ..]) = colors_of(image)
        && (red.full().is_some() || image.format == "OpenEXR")
    {
        found.push(Quantity::Color);
    }
    if !found.is_empty() && conventions.channel.is_none() {
        return Ok(found);
    }
    let channels = names(image);
    wrong_usage(format!(
        "say with --as what {} of the {} file {} tells: id, depth, distance, zbuffer, normal or color",
        if channels.len() == 1 { "the channel" } else { "which of the channels" },
        image.format,
        channels.join(", "),
    ))
}

fn names(image: &Image) -> Vec<&str> {
    image.channels.iter().map(|channel| channel.name.as_str()).collect()
}

/// The three channels of a vector.
fn three_of<'a>(image: &'a Image, prefix: &str) -> Option<[&'a ChannelValues; 3]> {
    AXES.iter().find_map(|axes| {
        let [x, y, z] = axes.map(|axis| image.channel(&format!("{prefix}.{axis}")));
        Some([x?, y?, z?])
    })
}

fn colors_of(image: &Image) -> Option<[&ChannelValues; 3]> {
    let [r, g, b] = ["R", "G", "B"].map(|name| image.channel(name));
    Some([r?, g?, b?])
}

struct Reader<'a> {
    image: &'a Image,
    conventions: &'a Conventions,
    view: Option<&'a View>,
}

impl<'a> Reader<'a> {
    fn missing(&self, what: &str) -> Error {
        let channels = names(self.image).join(", ");
        let advice = if channels.is_empty() { "" } else { "; name one with --channel" };
        Error::Usage(format!(
            "the {} file has no channel with {what}, but {channels}{advice}",
            self.image.format
        ))
    }

    /// The one channel that tells something.
    fn one(&self, known: &[&str], what: &str) -> Result<&'a ChannelValues> {
        let image = self.image;
        if let Some(name) = &self.conventions.channel {
            return image.channel(name).ok_or_else(|| {
                let near = did_you_mean_at_end(names(image), name);
                Error::Usage(format!("the {} file has no channel {name}{near}", image.format))
            });
        }
        let by_name = known.iter().find_map(|name| image.channel(name));
        match (by_name, &*image.channels) {
            (Some(channel), _) => Ok(channel),
            (None, [only]) => Ok(&only.samples),
            _ => Err(self.missing(what)),
        }
    }

    fn ids(&self) -> Result<Vec<u32>> {
        let channel = self.one(&ID_NAMES, "ids")?;
        let Conventions { id_offset, no_hit, .. } = *self.conventions;
        let id = |i| {
            let Some(whole) = channel.whole(i) else {
                return if channel.number(i).is_finite() { NO_OBJECT } else { 0 };
            };
            let is_none = match no_hit {
                Some(no_hit) => whole == no_hit,
                None => whole == -1 || whole == i64::from(u32::MAX),
            };
            match whole.checked_add(id_offset) {
                _ if is_none => 0,
                Some(id) => u32::try_from(id).unwrap_or(NO_OBJECT),
                None => NO_OBJECT,
            }
        };
        Ok((0..channel.len()).map(id).collect())
    }

    /// `t` or the distance of each ray, and whether it hits anything.
    fn depths(&self, quantity: Quantity) -> Result<(Vec<f64>, Vec<bool>)> {
        let Conventions { background, scale, near_far, .. } = *self.conventions;
        let known: &[&str] = match quantity {
            Quantity::Distance => &[&DISTANCE_NAMES[..], &DEPTH_NAMES].concat(),
            _ => &DEPTH_NAMES,
        };
        let channel = self.one(known, quantity.name())?;
        let is_background = |x: f64| {
            x == f64::INFINITY || background.is_some_and(|b| x == b || x as f32 == b as f32)
        };
        let numbers = (0..channel.len()).map(|i| channel.number(i));
        if quantity != Quantity::ZBuffer {
            return Ok(numbers.map(|x| (x * scale, !is_background(x))).unzip());
        }
        let Some([near, far]) = near_far else {
            return wrong_usage("a z-buffer says nothing without --near and --far");
        };
        let full = channel.full().unwrap_or(1.0);
        let is_parallel = self.view.is_some_and(|view| view.lens == Lens::Orthographic);
        let t = |z: f64| {
            if is_parallel { near + z * (far - near) } else { 1.0 / ((1.0 - z) / near + z / far) }
        };
        let is_far = |z: f64| if near < far { z >= 1.0 } else { z <= 0.0 };
        Ok(numbers.map(|x| (t(x / full), !is_far(x / full) && !is_background(x))).unzip())
    }

    fn normals(&self) -> Result<Vec<DVec3>> {
        let image = self.image;
        let channels = match &self.conventions.channel {
            Some(name) => three_of(image, name),
            None => {
                let mut named = NORMAL_NAMES.iter().filter_map(|name| three_of(image, name));
                named.next().or_else(|| colors_of(image))
            }
        };
        let channels = channels.ok_or_else(|| self.missing("normals"))?;
        let axes = match (self.conventions.normal_space, self.view) {
            (NormalSpace::World, _) => [DVec3::X, DVec3::Y, DVec3::Z],
            (NormalSpace::Camera, Some(view)) => [view.right, view.true_up, -view.forward],
            (NormalSpace::Camera, None) => {
                return wrong_usage(
                    "rays of a list have no camera; give normals in the world's axes",
                );
            }
        };
        let normal = |i| {
            let parts = channels.map(|channel| match channel.full() {
                // −1 to 1, as whole numbers keep it.
                Some(full) => 2.0 * channel.number(i) / full - 1.0,
                None => channel.number(i),
            });
            parts[0] * axes[0] + parts[1] * axes[1] + parts[2] * axes[2]
        };
        Ok((0..channels[0].len()).map(normal).collect())
    }

    fn colors(&self) -> Result<Vec<[u8; 3]>> {
        let channels = colors_of(self.image).ok_or_else(|| self.missing("colours R, G and B"))?;
        let byte = |i| match channels[0].full() {
            None => Color(channels.map(|channel| channel.number(i).clamp(0.0, 1.0))).to_srgb8(),
            Some(_) => channels.map(|channel| {
                let full = channel.full().unwrap_or(255.0);
                (channel.number(i) / full * 255.0).round() as u8
            }),
        };
        Ok((0..channels[0].len()).map(byte).collect())
    }
}
