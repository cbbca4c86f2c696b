//! What another renderer says of each ray.

use glam::DVec3;
use kugelblitz::error::{Hint, Message, Setting};
use kugelblitz::picture::{ChannelValues, Image};
use kugelblitz::rays::{Lens, Rays, View};
use kugelblitz::scene::Color;
use kugelblitz::words::did_you_mean_at_end;
use kugelblitz::{Error, Result};

use super::conventions::Quantity::{self, Depth, Distance, Id, Normal, ZBuffer};
use super::conventions::{Conventions, NormalSide, NormalSpace};
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

/// What a ray is said to see.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClaimedHit {
    /// An id as this program counts them.
    Id(u32),
    /// The object's own colour, as sRGB.
    Color([u8; 3]),
    /// Whether anything is hit: where there is no id, but a depth or a normal.
    Hit(bool),
}

/// What another renderer says of each ray: channels of a picture, and what their numbers mean.
#[derive(Clone, Debug)]
pub struct Claims {
    /// What was found in the file, each with its channels.
    columns: Vec<(Quantity, Vec<ChannelValues>)>,
    /// What their numbers mean.
    pub conventions: Conventions,
    /// The camera, where the rays are those of pixels.
    view: Option<View>,
}

impl Claims {
    /// Finds the claims in a picture of these rays, or in a list of results.
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
            let hint = Hint::new("give its quantity with {}", [Setting::named("as")]);
            return wrong_usage(Message::new("one channel has one quantity", hint));
        }
        let view = rays.pixels().map(|pixels| pixels.view);
        let mut claims = Claims { columns: Vec::new(), conventions: conventions.clone(), view };
        for quantity in quantities {
            if quantity.is_depth() && claims.quantities().any(Quantity::is_depth) {
                return wrong_usage(
                    "depths are of one kind: give one of depth, distance and zbuffer",
                );
            }
            let channels = claims.find(quantity, &image)?.into_iter().cloned().collect();
            claims.columns.push((quantity, channels));
        }
        Ok(claims)
    }

    /// The channels of a picture that tell something.
    fn find<'a>(&self, quantity: Quantity, image: &'a Image) -> Result<Vec<&'a ChannelValues>> {
        let Conventions { channel, near_far, normal_space, .. } = &self.conventions;
        let found = match (quantity, channel) {
            (Normal, Some(name)) => three_of(image, name),
            (Quantity::Color, _) | (_, None) => named(quantity, image),
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
            (Normal, _) if channel.is_none() => named(Quantity::Color, image),
            (Normal | Quantity::Color, _) => None,
            (_, [only]) => Some(vec![&only.samples]),
            (Distance, _) => named(Depth, image),
            _ => None,
        };
        let found = found.or_else(unnamed).ok_or_else(|| {
            let what = match quantity {
                Id => "ids",
                Normal => "normals",
                Quantity::Color => "colours R, G and B",
                depth => depth.name(),
            };
            let channels = names(image).join(", ");
            let hint = match channels.is_empty() {
                true => Hint::NONE,
                false => Hint::new("name one with {}", [Setting::named("channel")]),
            };
            Error::Usage(Message::new(
                format!("the {} file has no channel with {what}, but {channels}", image.format),
                hint,
            ))
        })?;
        match quantity {
            ZBuffer if near_far.is_none() => {
                let planes = [Setting::named("near"), Setting::named("far")];
                wrong_usage(Message::new(
                    "a z-buffer needs its planes",
                    Hint::new("give {} and {}", planes),
                ))
            }
            Normal if *normal_space == NormalSpace::Camera && self.view.is_none() => {
                wrong_usage("rays of a list have no camera; give normals in the world's axes")
            }
            _ => Ok(found),
        }
    }

    /// What was found in the file.
    pub fn quantities(&self) -> impl Iterator<Item = Quantity> {
        self.columns.iter().map(|(quantity, _)| *quantity)
    }

    /// Whether this was found in the file.
    pub fn has(&self, quantity: Quantity) -> bool {
        self.column(quantity).is_some()
    }

    /// Whether objects are told by their colours alone.
    pub(super) fn is_by_color(&self) -> bool {
        self.has(Quantity::Color) && !self.has(Id)
    }

    fn column(&self, quantity: Quantity) -> Option<&[ChannelValues]> {
        let column = self.columns.iter().find(|(found, _)| *found == quantity);
        column.map(|(_, channels)| channels.as_slice())
    }

    /// What a ray sees.
    pub fn seen(&self, ray: usize) -> ClaimedHit {
        if let Some([ids]) = self.column(Id) {
            return ClaimedHit::Id(self.id(ids, ray));
        }
        if let Some(channels @ [red, ..]) = self.column(Quantity::Color) {
            let numbers = [0, 1, 2].map(|c| channels[c].number(ray));
            return ClaimedHit::Color(match red.full() {
                None => Color(numbers.map(|x| x.clamp(0.0, 1.0))).to_srgb8(),
                Some(_) => std::array::from_fn(|c| {
                    let full = channels[c].full().unwrap_or(255.0);
                    (numbers[c] / full * 255.0).round() as u8
                }),
            });
        }
        ClaimedHit::Hit(match (self.depth(ray), self.normal(ray)) {
            (Some((_, is_hit)), _) => is_hit,
            (None, normal) => normal.is_some_and(|normal| normal.length() >= LEAST_NORMAL),
        })
    }

    fn id(&self, ids: &ChannelValues, ray: usize) -> u32 {
        let Some(whole) = ids.whole(ray) else {
            return if ids.number(ray).is_finite() { NO_OBJECT } else { 0 };
        };
        let is_none = match self.conventions.no_hit {
            Some(no_hit) => whole == no_hit,
            None => whole == -1 || whole == i64::from(u32::MAX),
        };
        match whole.checked_add(self.conventions.id_offset) {
            _ if is_none => 0,
            Some(id) => u32::try_from(id).unwrap_or(NO_OBJECT),
            None => NO_OBJECT,
        }
    }

    /// `t` or the distance of a ray, and whether it hits anything.
    pub fn depth(&self, ray: usize) -> Option<(f64, bool)> {
        let (quantity, channels) = self.columns.iter().find(|(of, _)| of.is_depth())?;
        let Conventions { background, scale, near_far, .. } = self.conventions;
        let x = channels[0].number(ray);
        let is_background =
            x == f64::INFINITY || background.is_some_and(|b| x == b || x as f32 == b as f32);
        let Some([near, far]) = near_far.filter(|_| *quantity == ZBuffer) else {
            return Some((x * scale, !is_background));
        };
        let z = x / channels[0].full().unwrap_or(1.0);
        let is_far = if near < far { z >= 1.0 } else { z <= 0.0 };
        let t = match self.view {
            Some(View { lens: Lens::Orthographic, .. }) => near + z * (far - near),
            _ => 1.0 / ((1.0 - z) / near + z / far),
        };
        Some((t, !is_far && !is_background))
    }

    /// The normal of a ray, of any length, in the world's axes.
    pub fn normal(&self, ray: usize) -> Option<DVec3> {
        let channels = self.column(Normal)?;
        let axes = match (self.conventions.normal_space, &self.view) {
            (NormalSpace::Camera, Some(view)) => [view.right, view.true_up, -view.forward],
            _ => [DVec3::X, DVec3::Y, DVec3::Z],
        };
        let parts = channels.iter().zip(axes).map(|(channel, axis)| match channel.full() {
            // −1 to 1, as whole numbers keep it.
            Some(full) => (2.0 * channel.number(ray) / full - 1.0) * axis,
            None => channel.number(ray) * axis,
        });
        parts.reduce(|sum, part| sum + part)
    }

    /// What is said of a ray, in terms of what is right there: of the right object where it may be meant, and with the
    /// normal that the right one is to be compared with.
    pub(super) fn row(
        &self,
        ray: usize,
        right: &RayResult,
        is_back: bool,
        palette: &[[u8; 3]],
    ) -> RayResult {
        let id = match self.seen(ray) {
            ClaimedHit::Id(id) => id,
            ClaimedHit::Hit(false) => 0,
            ClaimedHit::Hit(true) if right.id == 0 => NO_OBJECT,
            ClaimedHit::Hit(true) => right.id,
            ClaimedHit::Color(color) if self.is_like(color, palette[right.id as usize]) => right.id,
            ClaimedHit::Color(color) if self.is_like(color, palette[0]) => 0,
            ClaimedHit::Color(_) => NO_OBJECT,
        };
        if id == 0 {
            return RayResult { id, t: None, normal: None };
        }
        let faces = |normal: DVec3| right.normal.is_none_or(|right| normal.dot(right) >= 0.0);
        let turned = |normal: DVec3| match self.conventions.normal_side {
            NormalSide::Outward if is_back => -normal,
            NormalSide::Either if !faces(normal) => -normal,
            _ => normal,
        };
        let t = self.depth(ray).map(|(t, _)| t);
        RayResult { id, t, normal: self.normal(ray).map(turned) }
    }

    /// Whether a colour that is said to be seen may be this one.
    pub(super) fn is_like(&self, said: [u8; 3], color: [u8; 3]) -> bool {
        let most = self.conventions.color_tolerance;
        color.into_iter().zip(said).all(|(a, b)| a.abs_diff(b) <= most)
    }
}

/// What the names of the channels tell. Colours are looked at where there is nothing else.
fn quantities_of(image: &Image, conventions: &Conventions) -> Result<Vec<Quantity>> {
    let has = |quantity: &Quantity| named(*quantity, image).is_some();
    let depth = match conventions.near_far {
        _ if !has(&Depth) => Distance,
        Some(_) => ZBuffer,
        None => Depth,
    };
    let mut found = vec![Id, depth, Normal];
    found.retain(has);
    if found.is_empty()
        && let Some([red, ..]) = named(Quantity::Color, image).as_deref()
        && (red.full().is_some() || image.format == "OpenEXR")
    {
        found.push(Quantity::Color);
    }
    if !found.is_empty() && conventions.channel.is_none() {
        return Ok(found);
    }
    let channels = names(image);
    let text = format!(
        "{} of the {} file may be anything: {}",
        if channels.len() == 1 { "the channel" } else { "each of the channels" },
        image.format,
        channels.join(", "),
    );
    let hint =
        Hint::new("give {}: id, depth, distance, zbuffer, normal or color", [Setting::named("as")]);
    wrong_usage(Message::new(text, hint))
}

fn names(image: &Image) -> Vec<&str> {
    image.channels.iter().map(|channel| channel.name.as_str()).collect()
}

/// The channels whose names tell something.
fn named(quantity: Quantity, image: &Image) -> Option<Vec<&ChannelValues>> {
    let known: &[&str] = match quantity {
        Id => &ID_NAMES,
        Depth | ZBuffer => &DEPTH_NAMES,
        Distance => &DISTANCE_NAMES,
        Normal => return NORMAL_NAMES.iter().find_map(|name| three_of(image, name)),
        Quantity::Color => return ["R", "G", "B"].iter().map(|name| image.channel(name)).collect(),
    };
    known.iter().find_map(|name| image.channel(name)).map(|channel| vec![channel])
}

/// The three channels of a vector.
fn three_of<'a>(image: &'a Image, prefix: &str) -> Option<Vec<&'a ChannelValues>> {
    AXES.iter().find_map(|axes| {
        axes.iter().map(|axis| image.channel(&format!("{prefix}.{axis}"))).collect()
    })
}
