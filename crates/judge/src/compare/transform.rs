//! The differences between renderers that have a name: other conventions, and common mistakes.
//!
//! A [`Transform`] of a foreign result turns it into this program's conventions. A transform of what is expected makes the
//! expected result have the foreign mistake. [`super::search`] tries them.

use std::fmt;
use std::str::FromStr;

use glam::DVec3;
use kugelblitz::Control;
use kugelblitz::error::{Hint, Message};
use kugelblitz::picture::Image;
use kugelblitz::query::WorldRay;
use kugelblitz::rays::{Lens, Pixels, Rays, View};
use kugelblitz::scene::{Object, Scene, Sphere};
use kugelblitz::support::parallel;
use kugelblitz::words::did_you_mean_at_end;
use kugelblitz::{Error, Result};

use super::claims::{Claims, DepthKind, NormalSide};
use crate::verify::{Near, TrueHit, Truth, candidates};
use crate::wrong_usage;

/// A named difference between a foreign result and an exact one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Transform {
    /// The first row is the lowest one.
    FlipRows,
    /// The first column is the right one.
    FlipColumns,
    /// This number is added to the ids of objects.
    AddToIds(i64),
    /// Objects have other ids; which, is taken from the data.
    PermuteIds,
    /// The background has this id.
    NoHit(i64),
    /// `t` is the distance from the ray's origin.
    Distance,
    /// `t` is the ray parameter: with a camera, the depth along the view axis.
    Depth,
    /// `t` is 0 at the near plane and 1 at the far one, as rasterisers store it. Without the distances of the planes, they are
    /// taken from the data.
    ZBuffer(Option<[f64; 2]>),
    /// `t` is multiplied by this number; without it, it is taken from the data.
    Scale(Option<f64>),
    /// The background has this `t`.
    Background(f64),
    /// Normals have the opposite direction.
    NegateNormals,
    /// Normals point out of spheres, and as the scene has them for planes.
    OutwardNormals,
    /// Normals point into spheres, and as the scene has them for planes.
    InwardNormals,
    /// Normals have any of their two directions.
    UnsignedNormals,
    /// Normals have other lengths than 1.
    NormalizeNormals,
    /// Normals are in the camera's axes: right, up, and against the view axis.
    CameraNormals,
    /// Rays pass the pixels this far right of and below their centres, pixels.
    PixelOffset([f64; 2]),
    /// The field of view is the horizontal one.
    HorizontalFov,
    /// The aspect ratio is that of a picture with one row more.
    AspectOfMoreRows,
    /// Spheres are seen at their far roots.
    FarRoots,
    /// Spheres have the normals of their far roots.
    FarNormals,
}

use Transform::*;

/// The transforms: the form of each, and its meaning.
pub const TRANSFORMS: [(&str, &str); 21] = [
    ("flip-rows", "the first row is the lowest one"),
    ("flip-columns", "the first column is the right one"),
    ("ids+1, ids-1", "ids count from 0, or from 2; any other number as well"),
    ("permute-ids", "objects have other ids; which, is taken from the data"),
    ("no-hit=ID", "the id of the background, besides 0, -1 and 4294967295"),
    ("distance", "t is the distance from the ray's origin"),
    ("depth", "t is the depth along the view axis, although it is called a distance"),
    ("zbuffer=NEAR:FAR", "t is a z-buffer; without numbers, they are taken from the data"),
    ("scale=S", "t is multiplied by S; without a number, it is taken from the data"),
    ("background=T", "t of the background, besides infinity"),
    ("negate-normals", "normals have the opposite direction"),
    ("outward-normals", "normals point out of spheres, and as the scene has them for planes"),
    ("inward-normals", "normals point into spheres, and as the scene has them for planes"),
    ("unsigned-normals", "normals have any of their two directions"),
    ("normalize-normals", "normals have other lengths than 1"),
    ("camera-normals", "normals are in the camera's axes: right, up, back"),
    ("pixel-offset=X:Y", "rays pass the pixels X right of and Y below their centres, in pixels"),
    ("horizontal-fov", "the field of view is the horizontal one"),
    ("aspect-h+1", "the aspect ratio is W/(H + 1)"),
    ("far-roots", "spheres are seen at their far roots"),
    ("far-normals", "spheres have the normals of their far roots"),
];

/// Transforms that need no number and are no mistake by their form.
const WORDS: [(&str, Transform); 17] = [
    ("flip-rows", FlipRows),
    ("flip-columns", FlipColumns),
    ("permute-ids", PermuteIds),
    ("distance", Distance),
    ("depth", Depth),
    ("zbuffer", ZBuffer(None)),
    ("scale", Scale(None)),
    ("negate-normals", NegateNormals),
    ("outward-normals", OutwardNormals),
    ("inward-normals", InwardNormals),
    ("unsigned-normals", UnsignedNormals),
    ("normalize-normals", NormalizeNormals),
    ("camera-normals", CameraNormals),
    ("horizontal-fov", HorizontalFov),
    ("aspect-h+1", AspectOfMoreRows),
    ("far-roots", FarRoots),
    ("far-normals", FarNormals),
];

impl FromStr for Transform {
    type Err = Error;

    fn from_str(text: &str) -> Result<Transform> {
        if let Some((_, transform)) = WORDS.iter().find(|(word, _)| *word == text) {
            return Ok(*transform);
        }
        let whole = |text: &str| text.parse::<i64>().ok();
        let finite = |text: &str| text.parse::<f64>().ok().filter(|x| x.is_finite());
        let pair = |text: &str| {
            let (a, b) = text.split_once(':')?;
            Some([a.parse::<f64>().ok()?, b.parse::<f64>().ok()?])
        };
        let planes =
            |text: &str| pair(text).filter(|[near, far]| *near > 0.0 && *far > 0.0 && near != far);
        let offset = |text: &str| pair(text).filter(|xy| xy.iter().all(|x| x.is_finite()));
        let (name, value) = text.split_once('=').unwrap_or((text, ""));
        let (transform, expected) = match (name, name.strip_prefix("ids")) {
            (_, Some(number)) if number.starts_with(['+', '-']) => {
                (whole(number).map(AddToIds), "a whole number after ids, as in ids+1")
            }
            ("no-hit", _) => (whole(value).map(NoHit), "a whole number, as in no-hit=255"),
            ("zbuffer", _) => (
                planes(value).map(|planes| ZBuffer(Some(planes))),
                "two different distances above 0, as in zbuffer=0.1:100; one may be inf",
            ),
            ("scale", _) => (
                finite(value).filter(|s| *s != 0.0).map(|s| Scale(Some(s))),
                "a number other than 0, as in scale=0.001",
            ),
            ("background", _) => (finite(value).map(Background), "a number, as in background=0"),
            ("pixel-offset", _) => {
                (offset(value).map(PixelOffset), "two numbers, as in pixel-offset=-0.5:-0.5")
            }
            _ => {
                let names =
                    TRANSFORMS.map(|(form, _)| form.split(['=', ',']).next().unwrap_or(form));
                return wrong_usage(format!(
                    "no transform is called “{text}”; give {}{}",
                    names.join(", "),
                    did_you_mean_at_end(names, text)
                ));
            }
        };
        transform.ok_or_else(|| {
            Error::Usage(Message::new(
                format!("“{text}” is no transform"),
                Hint::new(&format!("give {expected}"), []),
            ))
        })
    }
}

impl fmt::Display for Transform {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            AddToIds(n) => write!(f, "ids{n:+}"),
            NoHit(id) => write!(f, "no-hit={id}"),
            ZBuffer(Some([near, far])) => write!(f, "zbuffer={near}:{far}"),
            Scale(Some(s)) => write!(f, "scale={s}"),
            Background(t) => write!(f, "background={t}"),
            PixelOffset([x, y]) => write!(f, "pixel-offset={x}:{y}"),
            other => {
                let word = WORDS.iter().find(|(_, transform)| transform == other);
                f.write_str(word.map_or("", |(word, _)| word))
            }
        }
    }
}

/// Which part of a comparison a transform changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TransformPart {
    /// The order of the pixels in the file.
    File,
    /// The foreign results.
    Claims,
    /// The expected results.
    Expected,
}

impl Transform {
    /// Returns the part that the transform changes.
    pub(super) fn part(self) -> TransformPart {
        match self {
            FlipRows | FlipColumns => TransformPart::File,
            PixelOffset(_) | HorizontalFov | AspectOfMoreRows | FarRoots | FarNormals => {
                TransformPart::Expected
            }
            _ => TransformPart::Claims,
        }
    }

    /// Whether the transform changes the order of a picture's pixels, so that it suits any two pictures.
    pub fn is_of_files(self) -> bool {
        self.part() == TransformPart::File
    }

    /// Whether the transform needs pixels of a camera, not a list of rays.
    pub(super) fn needs_pixels(self) -> bool {
        matches!(
            self,
            FlipRows
                | FlipColumns
                | CameraNormals
                | PixelOffset(_)
                | HorizontalFov
                | AspectOfMoreRows
        )
    }

    /// Applies the transform to the order of a picture's pixels.
    pub fn apply_to_image(self, image: &mut Image) {
        match self {
            FlipRows => image.flip_rows(),
            FlipColumns => image.flip_columns(),
            _ => {}
        }
    }

    /// Applies the transform to foreign results. `expected` are the exact results, from which missing numbers are taken.
    ///
    /// # Errors
    /// Returns [`Error::Usage`] if a number cannot be taken from the data.
    pub(super) fn apply(self, claims: &mut Claims, expected: &Expected) -> Result<()> {
        let view = expected.rays.pixels().map(|pixels| pixels.view);
        let unknown = |what: &str, example: &str| {
            Error::Usage(
                format!("{what} can't be found from the data; give it, as in {example}").into(),
            )
        };
        match self {
            AddToIds(n) => claims.map_ids(|id| match id {
                // 0 is the background, unless ids count from 0.
                Some(0) if n < 0 => None,
                id => id.and_then(|id| id.checked_add(n)),
            }),
            PermuteIds => permute_ids(claims, expected),
            NoHit(no_hit) => claims.map_ids(|id| id.filter(|&id| id != no_hit)),
            Distance => claims.set_depth_kind(DepthKind::Distance),
            Depth => claims.set_depth_kind(DepthKind::Parameter),
            ZBuffer(planes) => {
                let lens = view.map_or(Lens::Perspective, |view| view.lens);
                let planes = planes.or_else(|| fit_z_buffer(claims, expected, lens));
                let planes = planes.ok_or_else(|| unknown("the planes", "zbuffer=0.1:100"))?;
                claims.map_z_buffer(|z| t_of_z(z, planes, lens));
            }
            Scale(s) => {
                let s = s.or_else(|| fit_scale(claims, expected));
                let s = s.ok_or_else(|| unknown("the scale", "scale=0.001"))?;
                claims.map_depths(|t| t * s);
            }
            Background(background) => claims.map_depths(|t| match t {
                t if t == background || t as f32 == background as f32 => f64::INFINITY,
                t => t,
            }),
            NegateNormals => claims.map_normals(|n| -n),
            NormalizeNormals => claims.map_normals(|n| n / n.length()),
            OutwardNormals => claims.normal_side = NormalSide::Outward,
            InwardNormals => claims.normal_side = NormalSide::Inward,
            UnsignedNormals => claims.normal_side = NormalSide::Either,
            CameraNormals => {
                let Some(View { right, true_up, forward, .. }) = view else {
                    return wrong_usage(
                        "rays of a list have no camera; give normals in the world's axes",
                    );
                };
                claims.map_normals(|n| n.x * right + n.y * true_up - n.z * forward);
            }
            _ => {}
        }
        Ok(())
    }

    /// Returns this transform with the numbers that it takes from the data.
    pub(super) fn fitted(self, claims: &Claims, expected: &Expected) -> Option<Transform> {
        let lens = expected.rays.pixels().map_or(Lens::Perspective, |pixels| pixels.view.lens);
        match self {
            ZBuffer(None) => Some(ZBuffer(Some(fit_z_buffer(claims, expected, lens)?))),
            Scale(None) => Some(Scale(Some(fit_scale(claims, expected)?))),
            other => Some(other),
        }
    }

    /// Returns the rays that a foreign camera with this mistake casts through the pixels; `None` if the rays are the same.
    pub(super) fn rays(self, pixels: &Pixels, index: &[usize]) -> Option<Rays> {
        let [w, h] = [pixels.image_width, pixels.image_height].map(f64::from);
        let View { position, forward, right, true_up, lens, h: half_height } = pixels.view;
        let ray = |&i: &usize| {
            let (x, y) = pixels.xy(i);
            let (across, up) = pixels.offset2(x, y);
            let (across, up) = (across as f64, up as f64);
            let (across, up) = match self {
                PixelOffset([dx, dy]) => ((across + 2.0 * dx) / h, (up - 2.0 * dy) / h),
                HorizontalFov => (across / w, up / w),
                AspectOfMoreRows => (across / (h + 1.0), up / h),
                _ => return None,
            };
            let aside = right * (across * half_height) + true_up * (up * half_height);
            Some(match lens {
                Lens::Perspective => WorldRay { origin: position, direction: forward + aside },
                Lens::Orthographic => WorldRay { origin: position + aside, direction: forward },
            })
        };
        index.iter().map(ray).collect::<Option<Vec<WorldRay>>>().map(Rays::List)
    }
}

/// Exact results of some rays.
pub(super) struct Expected {
    /// All rays of the comparison.
    pub rays: Rays,
    /// The exact results of those with the indices `truth.index`. [`Claims`] compared with them are of the same rays, in this order.
    pub truth: Truth,
    /// Lengths of the directions of these rays.
    pub lengths: Vec<f64>,
    /// Whether normals of either direction are right.
    pub is_unsigned: bool,
}

/// Returns `t` for a number of a z-buffer; +∞ on the far plane or beyond.
fn t_of_z(z: f64, [near, far]: [f64; 2], lens: Lens) -> f64 {
    if if near < far { z >= 1.0 } else { z <= 0.0 } {
        return f64::INFINITY;
    }
    match lens {
        Lens::Orthographic => near + z * (far - near),
        Lens::Perspective => 1.0 / ((1.0 - z) / near + z / far),
    }
}

/// Least number of rays from which a number is taken.
const MIN_RAYS: usize = 8;

/// Returns the `t` of rays that hit something by both results: the foreign number and the exact one.
fn pairs<'a>(claims: &'a Claims, expected: &'a Expected) -> impl Iterator<Item = (f64, f64)> + 'a {
    let rays = expected.truth.hits.iter().zip(&expected.lengths).enumerate();
    rays.filter(|(_, (hit, _))| hit.id != 0).filter_map(|(ray, (hit, length))| {
        let t = claims.depth(ray)?;
        Some((t, hit.t * claims.t_factor(*length))).filter(|_| t.is_finite())
    })
}

/// Finds the planes of a z-buffer by least squares: `1/t` is linear in z, or `t` for parallel rays.
fn fit_z_buffer(claims: &Claims, expected: &Expected, lens: Lens) -> Option<[f64; 2]> {
    let full = claims.depth_full();
    let points: Vec<(f64, f64)> = pairs(claims, expected)
        .map(|(z, t)| (z / full, if lens == Lens::Perspective { 1.0 / t } else { t }))
        .filter(|(z, y)| (0.0..=1.0).contains(z) && y.is_finite())
        .collect();
    let n = points.len() as f64;
    if points.len() < MIN_RAYS {
        return None;
    }
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / n;
    let (mean_z, mean_y) = (mean(&|p| p.0), mean(&|p| p.1));
    let slope = mean(&|p| (p.0 - mean_z) * (p.1 - mean_y)) / mean(&|p| (p.0 - mean_z).powi(2));
    let ends = [mean_y - slope * mean_z, mean_y + slope * (1.0 - mean_z)];
    let planes = match lens {
        Lens::Orthographic => ends,
        Lens::Perspective => ends.map(|y| {
            let is_infinite = y.abs() < 1e-5 * ends[0].abs().max(ends[1].abs());
            if is_infinite { f64::INFINITY } else { 1.0 / y }
        }),
    };
    let planes = planes.map(|x| short_number(x, 1e-4));
    let are_planes = planes.iter().all(|x| *x > 0.0) && planes[0] != planes[1];
    are_planes.then_some(planes)
}

/// Finds the factor of `t`: the median of the ratios.
fn fit_scale(claims: &Claims, expected: &Expected) -> Option<f64> {
    let mut ratios: Vec<f64> =
        pairs(claims, expected).map(|(t, exact)| exact / t).filter(|x| x.is_finite()).collect();
    if ratios.len() < MIN_RAYS {
        return None;
    }
    let middle = ratios.len() / 2;
    let (_, median, _) = ratios.select_nth_unstable_by(middle, f64::total_cmp);
    Some(short_number(*median, 1e-6)).filter(|s| *s != 0.0)
}

/// Returns the number with the fewest digits that has at most this relative error.
fn short_number(x: f64, error: f64) -> f64 {
    let shorter = |digits: usize| format!("{x:.digits$e}").parse::<f64>().ok();
    let mut all = (0..17).filter_map(shorter);
    all.find(|short| (short - x).abs() <= error * x.abs()).unwrap_or(x)
}

/// Gives each foreign id that of the object that most of its rays see. No two foreign ids get the same object, so that a wrong
/// visibility stays wrong.
fn permute_ids(claims: &mut Claims, expected: &Expected) {
    let seen = expected.truth.hits.iter().enumerate().filter_map(|(ray, hit)| {
        let id = claims.id(ray)??;
        (hit.id != 0).then_some((id, hit.id))
    });
    let mut seen: Vec<(i64, u32)> = seen.collect();
    seen.sort_unstable();
    let mut counts: Vec<(usize, i64, u32)> =
        seen.chunk_by(|a, b| a == b).map(|run| (run.len(), run[0].0, run[0].1)).collect();
    counts.sort_unstable_by(|a, b| b.cmp(a));
    let mut object_of = std::collections::BTreeMap::new();
    let mut taken = std::collections::BTreeSet::new();
    for (_, id, object) in counts {
        if !object_of.contains_key(&id) && taken.insert(object) {
            object_of.insert(id, object);
        }
    }
    claims.map_ids(|id| match (id, id.and_then(|id| object_of.get(&id))) {
        (_, Some(&object)) => Some(object.into()),
        (None | Some(0), None) => None,
        // Ids that no object is left for stay wrong.
        _ => Some(i64::MAX),
    });
}

/// Returns the results of a renderer that takes the far root of each sphere.
///
/// # Errors
/// Returns [`Error::Interrupted`] if `control` was cancelled.
pub(super) fn truth_of_far_roots(
    scene: &Scene,
    rays: &Rays,
    index: &[usize],
    control: &Control,
) -> Result<Truth> {
    let hits = parallel::try_map(index, |&i| {
        control.check()?;
        let near = Near::new(rays, i);
        let hits = candidates(scene, &near).filter_map(|(id, object)| {
            let (t, normal) = match object {
                Object::Sphere(sphere) => far_root(&near, sphere)?,
                Object::Plane(plane) => {
                    let along = near.ray.direction.dot(plane.normal);
                    let offset = plane.point - near.reference - near.ray.origin;
                    (offset.dot(plane.normal) / along, plane.normal.normalize())
                }
            };
            (t > 0.0 && t.is_finite()).then(|| true_hit(id, t, normal))
        });
        Ok(hits.min_by(|a, b| a.t.total_cmp(&b.t)).unwrap_or(TrueHit::NONE))
    })?;
    Ok(Truth { index: index.to_vec(), hits })
}

/// Returns results with the normals of spheres' far roots.
pub(super) fn truth_of_far_normals(scene: &Scene, rays: &Rays, truth: &Truth) -> Truth {
    let hit = |(&i, hit): (&usize, &TrueHit)| match scene.object(hit.id) {
        Some(Object::Sphere(sphere)) => match far_root(&Near::new(rays, i), sphere) {
            Some((_, normal)) => true_hit(hit.id, hit.t, normal),
            None => hit.clone(),
        },
        _ => hit.clone(),
    };
    Truth {
        index: truth.index.clone(),
        hits: truth.index.iter().zip(&truth.hits).map(hit).collect(),
    }
}

fn true_hit(id: u32, t: f64, normal: DVec3) -> TrueHit {
    TrueHit { id, t, normal: normal.into(), normal_f32: normal.as_vec3().into(), is_back: false }
}

/// Returns `t` and the normal at a sphere's far root, in f64; `None` if the line misses it.
fn far_root(Near { reference, ray }: &Near, sphere: &Sphere) -> Option<(f64, DVec3)> {
    let (l, d) = (sphere.center - *reference - ray.origin, ray.direction);
    let (a, b) = (d.length_squared(), l.dot(d));
    let discriminant = b * b - a * (l.length_squared() - sphere.radius * sphere.radius);
    let t = (b + discriminant.sqrt()) / a;
    (discriminant >= 0.0).then(|| (t, (d * t - l) / sphere.radius.abs()))
}
