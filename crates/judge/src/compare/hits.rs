//! Results of another renderer against exact arithmetic.
//!
//! A [`HitComparison`] is a foreign result and the rays that it is of. [`HitComparison::run`] finds the exact results: the object by
//! the kernel `certified`, which proves it, and `t` and the normal by exact arithmetic on that object. [`HitDifference`] has the
//! errors, a table of them by object, and the transforms that explain them.

use std::sync::Arc;

use crate::cost::ObjectCounts;
use kugelblitz::Control;
use kugelblitz::picture::Image;
use kugelblitz::query::{Hits, Kernel, Outputs, WorldRay};
use kugelblitz::rays::{Pixels, Rays};
use kugelblitz::scene::{Object, Scene};
use kugelblitz::support::memory;
use kugelblitz::{Result, Session};
use serde::Serialize;

use super::claims::Claims;
use super::objects::{ObjectErrors, errors_by_object};
use super::search::{TransformMatch, explain};
use super::transform::{Expected, Transform, truth_of_far_normals, truth_of_far_roots};
use super::words::{Finding, length_range};
use super::{
    Allowed, AllowedKey, ErrorStats, LimitUnit, Quantity, RayError, RayResult, TError, Tolerance,
    error_picture, short,
};
use crate::verify::{Near, TrueHit, Truth};
use crate::wrong_usage;

/// Bytes of memory that comparing a ray takes: the exact result, the foreign one in the file and by another transform, and the
/// errors.
const RAY_BYTES: u64 = 512;

/// A foreign result, and what it is of.
pub struct HitComparison {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The rays.
    pub rays: Rays,
    /// The foreign result.
    pub image: Image,
    /// The quantities that are compared.
    pub quantities: Vec<Quantity>,
    /// The channel of the only quantity, if its name tells nothing.
    pub channel: Option<String>,
    /// The transforms that are applied.
    pub transforms: Vec<Transform>,
    /// Allowed errors.
    pub allowed: Allowed,
}

impl HitComparison {
    /// Compares the result with what `session` proves. Returns [`HitDifference`].
    ///
    /// # Errors
    /// Returns [`Error::Usage`](kugelblitz::Error::Usage) for another number of results than rays, a missing quantity, a transform that does not suit the
    /// rays, and a session with another kernel than `certified`; [`Error::TooLarge`](kugelblitz::Error::TooLarge) if it does not fit the memory; and the errors
    /// of [`Session::trace`].
    pub fn run(self, session: &mut Session, control: &Control) -> Result<HitDifference> {
        let n = self.rays.len();
        if self.image.len() != n {
            return wrong_usage(format!(
                "there are {} results for {n} rays; give one for each",
                self.image.len()
            ));
        }
        if session.kernel() != Kernel::Certified {
            let name = session.kernel().name();
            return wrong_usage(format!("{name} proves nothing; compare with certified"));
        }
        let (what, bytes) = (format!("comparing {n} rays"), (n as u64).saturating_mul(RAY_BYTES));
        memory::require(what, bytes, "compare a part of the picture (crop)")?;
        if let Rays::List(_) = self.rays
            && let Some(transform) = self.transforms.iter().find(|it| it.needs_pixels())
        {
            return wrong_usage(format!(
                "{transform} needs pixels of a camera, not a list of rays"
            ));
        }
        let all: Vec<usize> = (0..n).collect();
        let claims = self.claims(&[], &all)?;
        let expected = self.expected(&self.transforms, all, session, control)?;
        let claims = transformed(claims, &self.transforms, &expected)?;
        let errors = self.errors(&claims, &expected);
        let mut difference = HitDifference {
            objects: errors_by_object(&self, &claims, &expected, &errors.of_rays),
            comparison: self,
            claims,
            expected,
            errors,
            broken: Vec::new(),
            explained: None,
        };
        difference.broken = difference.broken();
        if !difference.broken.is_empty() {
            difference.explained = explain(&difference, session, control)?;
        }
        Ok(difference)
    }

    /// Reads the foreign results of the rays with these indices, in the order of pixels that the comparison's transforms and these
    /// ones give.
    pub(super) fn claims(&self, more: &[Transform], rays: &[usize]) -> Result<Claims> {
        let is_flipped = |flip: Transform| {
            let flips = self.transforms.iter().chain(more).filter(|it| **it == flip);
            flips.count() % 2 == 1
        };
        let [rows, columns] = [Transform::FlipRows, Transform::FlipColumns].map(is_flipped);
        let (width, height) = (self.image.width, self.image.height);
        let flipped = |at: usize, n: usize, is_flipped| if is_flipped { n - 1 - at } else { at };
        let index = |&ray: &usize| {
            flipped(ray / width, height, rows) * width + flipped(ray % width, width, columns)
        };
        let indices: Vec<usize> = rays.iter().map(index).collect();
        Claims::new(&self.image, &self.quantities, self.channel.as_deref(), &indices)
    }

    /// Finds what is expected of the rays with these indices under these transforms.
    pub(super) fn expected(
        &self,
        transforms: &[Transform],
        index: Vec<usize>,
        session: &mut Session,
        control: &Control,
    ) -> Result<Expected> {
        let of_camera = transforms
            .iter()
            .rev()
            .find_map(|transform| transform.rays(self.rays.pixels()?, &index));
        let has = |wanted: Transform| transforms.contains(&wanted);
        let is_unsigned = has(Transform::FarRoots) || has(Transform::FarNormals);
        let rays = match of_camera {
            Some(rays) => rays,
            None if index.len() == self.rays.len() => self.rays.clone(),
            None => Rays::List(index.iter().map(|&i| world_ray(&self.rays, i)).collect()),
        };
        let lengths = (0..rays.len()).map(|i| Near::new(&rays, i).ray.direction.length()).collect();
        let all = (0..rays.len()).collect::<Vec<_>>();
        let mut truth = if has(Transform::FarRoots) {
            truth_of_far_roots(&self.scene, &rays, &all, control)?
        } else {
            let mut hits = Hits::default();
            session.trace(&rays, Outputs::default(), control, &mut hits)?;
            Truth::of_known(&self.scene, &rays, &hits.id, control)?
        };
        if has(Transform::FarNormals) {
            truth = truth_of_far_normals(&self.scene, &rays, &truth);
        }
        truth.index = index;
        Ok(Expected { rays: self.rays.clone(), truth, lengths, is_unsigned })
    }

    /// Returns the error of each of the expected results. `claims` are those of the same rays.
    pub(super) fn ray_errors(&self, claims: &Claims, expected: &Expected) -> Vec<RayError> {
        let error = |(ray, (exact, length)): (usize, (&TrueHit, &f64))| {
            let mut right = RayResult::from(exact);
            right.t = right.t.map(|t| t * claims.t_factor(*length));
            let is_plane = matches!(self.scene.object(exact.id), Some(Object::Plane(_)));
            let mut result = claims.result(ray, exact, is_plane);
            if expected.is_unsigned {
                let faces = |normal: &_| right.normal.is_none_or(|right| right.dot(*normal) >= 0.0);
                result.normal = result.normal.map(|n| if faces(&n) { n } else { -n });
            }
            RayError::of(Some(result), &right, |normal| normal == exact.normal_f32)
        };
        expected.truth.hits.iter().zip(&expected.lengths).enumerate().map(error).collect()
    }

    fn errors(&self, claims: &Claims, expected: &Expected) -> HitErrors {
        let errors = self.ray_errors(claims, expected);
        let is_at_silhouette = match &self.rays {
            Rays::Pixels(pixels) => silhouettes(pixels, &expected.truth.hits),
            Rays::List(_) => vec![false; errors.len()],
        };
        let class = |at| ErrorStats::new(&self.rays, &errors, |i| is_at_silhouette[i] == at);
        let classes = [false, true].map(class);
        HitErrors { of_rays: errors, is_at_silhouette, classes }
    }
}

/// Returns a ray in the world.
fn world_ray(rays: &Rays, index: usize) -> WorldRay {
    match rays {
        Rays::Pixels(pixels) => {
            let (x, y) = pixels.xy(index);
            pixels.ray(x, y)
        }
        Rays::List(rays) => rays[index],
    }
}

/// Applies transforms of foreign results, in their order.
pub(super) fn transformed(
    mut claims: Claims,
    transforms: &[Transform],
    expected: &Expected,
) -> Result<Claims> {
    for transform in transforms {
        transform.apply(&mut claims, expected)?;
    }
    Ok(claims)
}

/// The errors of the rays.
#[derive(Clone, Debug)]
pub struct HitErrors {
    /// The error of each ray.
    pub of_rays: Vec<RayError>,
    /// Whether one of a pixel's eight neighbours sees another object, by the exact ids; never in a list of rays.
    pub is_at_silhouette: Vec<bool>,
    /// Errors of the rays away from silhouettes, and of those at them.
    pub classes: [ErrorStats; 2],
}

/// The differences of a foreign result from the exact one.
pub struct HitDifference {
    /// The comparison.
    pub comparison: HitComparison,
    /// The foreign results, with the transforms applied.
    pub claims: Claims,
    /// The exact results.
    pub(super) expected: Expected,
    /// The errors.
    pub errors: HitErrors,
    /// Wrong rays by object, most wrong first.
    pub objects: Vec<ObjectErrors>,
    /// Errors beyond the allowed ones, one sentence each.
    pub broken: Vec<String>,
    /// The transforms that explain the errors.
    pub explained: Option<TransformMatch>,
}

/// A comparison of hits, in numbers.
#[derive(Serialize)]
pub struct HitSummary {
    /// Width and height of the whole picture, pixels; `null` for a list of rays.
    size: Option<[u32; 2]>,
    /// Left column, top row, width and height of a part; `null` for a whole picture and for a list of rays.
    crop: Option<[u32; 4]>,
    /// Objects of the scene.
    objects: ObjectCounts,
    /// Rays compared.
    rays: usize,
    /// Quantities compared.
    compared: Vec<&'static str>,
    /// Allowed errors, as for `--allow`.
    allowed: String,
    /// Errors away from silhouettes; of a list of rays, all errors.
    away: ErrorStats,
    /// Errors at silhouettes; `null` for a list of rays.
    silhouettes: Option<ErrorStats>,
    /// Wrong rays by object, most wrong first.
    by_object: Vec<ObjectErrors>,
    /// Rays with the largest errors.
    worst: Vec<Finding>,
    /// Transforms that explain the errors; `null` if none do.
    explained_by: Option<TransformMatch>,
    /// Errors beyond the allowed ones, one sentence each; empty if the comparison succeeds.
    broken: Vec<String>,
}

impl HitDifference {
    /// The pixels, if the rays are those of pixels.
    pub fn pixels(&self) -> Option<&Pixels> {
        self.comparison.rays.pixels()
    }

    /// Returns the names of the compared quantities.
    pub fn quantities(&self) -> Vec<&'static str> {
        let of_hits = self.comparison.quantities.iter().filter(|quantity| quantity.is_of_hits());
        of_hits.map(|quantity| quantity.name()).collect()
    }

    /// Returns the exact results.
    pub(super) fn exact(&self, ray: usize) -> &TrueHit {
        &self.expected.truth.hits[ray]
    }

    /// Returns the comparison in numbers, with these findings.
    pub fn summary(&self, worst: Vec<Finding>) -> HitSummary {
        let (pixels, HitComparison { scene, rays, allowed, .. }) =
            (self.pixels(), &self.comparison);
        let [away, silhouettes] = self.errors.classes.clone();
        let is_part = |p: &&Pixels| (p.width, p.height) != (p.image_width, p.image_height);
        HitSummary {
            size: pixels.map(|p| [p.image_width, p.image_height]),
            crop: pixels.filter(is_part).map(|p| [p.x, p.y, p.width, p.height]),
            objects: ObjectCounts::of(scene),
            rays: rays.len(),
            compared: self.quantities(),
            allowed: allowed.of_hits(),
            away,
            silhouettes: pixels.map(|_| silhouettes),
            by_object: self.objects.clone(),
            worst,
            explained_by: self.explained.clone(),
            broken: self.broken.clone(),
        }
    }

    /// Returns size and colours of a picture of the errors; `None` for a list of rays.
    pub fn picture(&self) -> Option<([u32; 2], Vec<[u8; 3]>)> {
        let HitErrors { of_rays, is_at_silhouette, .. } = &self.errors;
        let pixels = self.pixels()?;
        let colors = error_picture(of_rays, |i| is_at_silhouette[i]);
        Some(([pixels.width, pixels.height], colors))
    }

    /// Returns minimum and maximum length of the normals, of all rays on the right object; `None` without normals.
    pub(super) fn normal_lengths(&self) -> Option<[f64; 2]> {
        let ranges = self.errors.classes.iter().filter_map(|class| class.normal_length);
        ranges.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }

    fn broken(&self) -> Vec<String> {
        let (allowed, classes) = (&self.comparison.allowed, &self.errors.classes);
        let mut broken = Vec::new();
        let away = if classes[1].rays > 0 { " away from silhouettes" } else { "" };
        let places = [(AllowedKey::Ids, away), (AllowedKey::Silhouettes, " at silhouettes")];
        for (ErrorStats { wrong_ids, rays, .. }, (key, place)) in classes.iter().zip(places) {
            let most = allowed.limit(key);
            if !most.allows_part(*wrong_ids, *rays) {
                broken.push(format!("{wrong_ids} of {rays} ids{place} are wrong, allowed: {most}"));
            }
        }
        let [ulp, relative, degrees, component] = [0, 1, 2, 3].map(|kind| {
            let spreads = classes.iter().filter_map(|class| class.spreads()[kind]);
            spreads.map(|spread| spread.worst).fold(0.0, f64::max)
        });
        if !allowed.allows_t(&TError { ulp, relative, is_nearest: false }) {
            broken.push(match allowed.limit(AllowedKey::T) {
                Tolerance { most, unit: LimitUnit::Ulp } => {
                    format!("t is off by {} ulp, allowed: {most}", short(ulp))
                }
                most => format!("t is off by a relative {}, allowed: {most}", short(relative)),
            });
        }
        let most = allowed.limit(AllowedKey::Normal);
        if !most.allows(degrees) {
            broken.push(format!("a normal is off by {}°, allowed: {most}°", short(degrees)));
        }
        let (within, most) = (most.allows(degrees), allowed.normal_component());
        if let Some(lengths) = self.normal_lengths()
            && component > most
            && (within || lengths.iter().any(|length| (length - 1.0).abs() > most))
        {
            broken.push(format!(
                "a component of a normal has an error of {}, allowed: {} (normals: {}; expected 1)",
                short(component),
                short(most),
                length_range(lengths)
            ));
        }
        broken
    }
}

/// Whether one of a pixel's eight neighbours sees another object.
fn silhouettes(pixels: &Pixels, hits: &[TrueHit]) -> Vec<bool> {
    let (width, height) = (pixels.width as usize, pixels.height as usize);
    let around = |at: usize, n: usize| at.saturating_sub(1)..(at + 2).min(n);
    let at = |i: usize| {
        let differs = |x: usize, y: usize| hits[y * width + x].id != hits[i].id;
        around(i / width, height).any(|y| around(i % width, width).any(|x| differs(x, y)))
    };
    (0..hits.len()).map(at).collect()
}
