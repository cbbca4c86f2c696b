//! The search for transforms that explain errors.
//!
//! A result in another convention, or with a common mistake, looks like gross errors in many pixels. All transforms are tried on a
//! sample of the rays, then all pairs of them; that which makes nearly all of the sample right explains the errors.

use std::fmt;

use kugelblitz::Control;
use kugelblitz::{Result, Session};
use serde::Serialize;

use super::claims::{Claims, DepthKind};
use super::hits::{HitDifference, transformed};
use super::transform::{Expected, Transform, TransformPart};
use super::{LimitUnit, RayError};
use crate::compare::{Allowed, AllowedKey};
use crate::verify::sample;

/// Number of rays on which transforms are tried.
const N_SAMPLE: usize = 4096;

/// Minimum share of the sample that agrees under a transform that explains the errors.
const MIN_AGREE: f64 = 0.95;

/// Factor by which the transform lowers the number of rays that do not agree.
const MIN_GAIN: u64 = 4;

/// Minimum number of rays more that agree.
const MIN_RAYS: u64 = 8;

/// Relative error of `t` at which rays agree, if no more is allowed.
const T_ERROR: f64 = 1e-4;

/// Angle in degrees at which normals agree, if no more is allowed.
const NORMAL_ERROR: f64 = 0.1;

/// Transforms that explain the errors of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TransformMatch {
    /// Transforms, as for `--transform`.
    pub transforms: String,
    /// Share of the sampled rays or pixels that agree with the transforms, 0 to 1.
    pub agree: f64,
    /// Share of the sampled rays or pixels that agree without the transforms, 0 to 1.
    pub agree_without: f64,
}

impl TransformMatch {
    /// Creates the explanation by which `n_agree` of `n` rays or pixels agree, and `before` without it.
    pub(super) fn new(
        transforms: &[Transform],
        n_agree: u64,
        before: u64,
        n: u64,
    ) -> TransformMatch {
        let names: Vec<String> = transforms.iter().map(Transform::to_string).collect();
        let share = |of: u64| of as f64 / n as f64;
        TransformMatch {
            transforms: names.join(","),
            agree: share(n_agree),
            agree_without: share(before),
        }
    }
}

impl fmt::Display for TransformMatch {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let TransformMatch { transforms, agree, agree_without } = self;
        let [with, without] = [agree, agree_without].map(|share| share * 100.0);
        write!(f, "with {transforms}, {with:.2} % agree; without, {without:.2} %")
    }
}

/// Whether a transform explains errors: `n_agree` of `n` rays or pixels agree with it, and `before` without it.
pub(super) fn explains(n_agree: u64, before: u64, n: u64) -> bool {
    n_agree as f64 >= MIN_AGREE * n as f64
        && n_agree >= before + MIN_RAYS.min(n)
        && (n - n_agree) * MIN_GAIN <= n - before
}

/// Finds the transforms that explain the errors.
///
/// # Errors
/// Returns the errors of [`Session::trace`].
pub(super) fn explain(
    difference: &HitDifference,
    session: &mut Session,
    control: &Control,
) -> Result<Option<TransformMatch>> {
    let search = TransformSearch::new(difference, session, control)?;
    let n = search.index.len() as u64;
    let before = search.tried(&[])?.map_or(0, |(n_agree, _)| n_agree);
    let candidates = search.candidates();
    let singles: Vec<Vec<Transform>> = candidates.iter().map(|&one| vec![one]).collect();
    let pairs = candidates.iter().enumerate().flat_map(|(at, &one)| {
        let later = candidates[at + 1..].iter().filter(move |other| !one.excludes(**other));
        later.map(move |&other| vec![one, other])
    });
    for group in [singles, pairs.collect()] {
        let mut best: Option<(u64, Vec<Transform>)> = None;
        for transforms in group {
            control.check()?;
            let Some((n_agree, transforms)) = search.tried(&transforms)? else { continue };
            // The first one of those that agree as much is the simplest.
            let is_better = best.as_ref().is_none_or(|(most, _)| n_agree > *most);
            if explains(n_agree, before, n) && is_better {
                best = Some((n_agree, transforms));
            }
        }
        if let Some((n_agree, transforms)) = best {
            return Ok(Some(TransformMatch::new(&transforms, n_agree, before, n)));
        }
    }
    Ok(None)
}

struct TransformSearch<'a> {
    difference: &'a HitDifference,
    /// The sampled rays.
    index: Vec<usize>,
    /// The foreign results of the sampled rays, with the comparison's own transforms.
    claims: Claims,
    /// Transforms of what is expected, with their exact results; the first is none.
    expected: Vec<(Option<Transform>, Expected)>,
    /// Errors at which rays agree.
    agreement: Allowed,
}

impl<'a> TransformSearch<'a> {
    fn new(
        difference: &'a HitDifference,
        session: &mut Session,
        control: &Control,
    ) -> Result<TransformSearch<'a>> {
        let comparison = &difference.comparison;
        let index = sample(comparison.rays.len(), N_SAMPLE, 0);
        let mut expected = Vec::new();
        for transform in
            [None].into_iter().chain(TransformSearch::of_expected(difference).map(Some))
        {
            let transforms: Vec<Transform> =
                comparison.transforms.iter().copied().chain(transform).collect();
            let found = comparison.expected(&transforms, index.clone(), session, control)?;
            expected.push((transform, found));
        }
        let agreement = Allowed::for_search(&comparison.allowed, T_ERROR, NORMAL_ERROR);
        let claims = comparison.claims(&[], &index)?;
        let claims = transformed(claims, &comparison.transforms, &expected[0].1)?;
        Ok(TransformSearch { difference, index, claims, expected, agreement })
    }

    /// Returns the transforms of what is expected that may explain the errors.
    fn of_expected(difference: &HitDifference) -> impl Iterator<Item = Transform> {
        let has_pixels = difference.pixels().is_some();
        let halves = [[-0.5, -0.5], [0.5, 0.5], [-0.5, 0.5], [0.5, -0.5]];
        let sides = [[-0.5, 0.0], [0.5, 0.0], [0.0, -0.5], [0.0, 0.5]];
        let offsets = halves.into_iter().chain(sides).map(Transform::PixelOffset);
        let cameras = offsets.chain([Transform::HorizontalFov, Transform::AspectOfMoreRows]);
        let given = difference.comparison.transforms.clone();
        cameras
            .filter(move |_| has_pixels)
            .chain([Transform::FarRoots, Transform::FarNormals])
            .filter(move |it| !given.iter().any(|other| other.excludes(*it)))
    }

    /// Returns the transforms to try, the simplest first.
    fn candidates(&self) -> Vec<Transform> {
        let (comparison, claims) = (&self.difference.comparison, &self.claims);
        let mut all = vec![Transform::FlipRows, Transform::FlipColumns];
        if claims.has_ids() {
            all.extend([1, -1].map(Transform::AddToIds));
            all.extend(self.common_background_id().map(Transform::NoHit));
            all.push(Transform::PermuteIds);
        }
        match claims.depth_kind() {
            Some(DepthKind::Parameter) => all.push(Transform::Distance),
            Some(DepthKind::Distance) => all.push(Transform::Depth),
            None => {}
        }
        if claims.depth_kind().is_some() {
            all.extend(self.common_background().map(Transform::Background));
            all.extend([Transform::Scale(None), Transform::ZBuffer(None)]);
        }
        if claims.has_normals() {
            all.extend([
                Transform::NegateNormals,
                Transform::OutwardNormals,
                Transform::InwardNormals,
                Transform::NormalizeNormals,
                Transform::CameraNormals,
                Transform::UnsignedNormals,
            ]);
        }
        all.extend(self.expected.iter().filter_map(|(transform, _)| *transform));
        let has_pixels = self.difference.pixels().is_some();
        let is_new = |it: &Transform| !comparison.transforms.iter().any(|on| on.excludes(*it));
        all.retain(|it| is_new(it) && (has_pixels || !it.needs_pixels()));
        all
    }

    /// Returns the number of sampled rays that agree under these transforms, and the transforms with the numbers that were taken
    /// from the data; `None` if there are none to be taken.
    fn tried(&self, transforms: &[Transform]) -> Result<Option<(u64, Vec<Transform>)>> {
        let is_used = |(with, _): &(Option<Transform>, Expected)| {
            with.is_some_and(|with| transforms.contains(&with))
        };
        let at = self.expected.iter().position(is_used).unwrap_or(0);
        let expected = &self.expected[at].1;
        let comparison = &self.difference.comparison;
        let mut claims = comparison.claims(transforms, &self.index)?;
        claims = transformed(claims, &comparison.transforms, expected)?;
        let mut fitted = Vec::new();
        for transform in transforms {
            let Some(transform) = transform.fitted(&claims, expected) else { return Ok(None) };
            if transform.apply(&mut claims, expected).is_err() {
                return Ok(None);
            }
            fitted.push(transform);
        }
        let errors = comparison.ray_errors(&claims, expected);
        Ok(Some((self.count(&errors), fitted)))
    }

    fn count(&self, errors: &[RayError]) -> u64 {
        let agrees = |error: &&RayError| {
            super::objects::is_allowed(error, &self.agreement).into_iter().all(|is| is)
        };
        errors.iter().filter(agrees).count() as u64
    }

    /// Returns the `t` that most of the false hits have.
    fn common_background(&self) -> Option<f64> {
        let backgrounds = self.rays_of_background().filter_map(|ray| self.claims.depth(ray));
        let mut depths: Vec<f64> = backgrounds.filter(|t| t.is_finite()).collect();
        depths.sort_unstable_by(f64::total_cmp);
        most_common(&depths)
    }

    /// Returns the id that most rays to the background have.
    fn common_background_id(&self) -> Option<i64> {
        let mut ids: Vec<i64> =
            self.rays_of_background().filter_map(|ray| self.claims.id(ray)?).collect();
        ids.sort_unstable();
        most_common(&ids).filter(|id| *id != 0)
    }

    /// Returns the places in the sample of rays that see the background.
    fn rays_of_background(&self) -> impl Iterator<Item = usize> {
        let hits = self.expected[0].1.truth.hits.iter().enumerate();
        hits.filter(|(_, hit)| hit.id == 0).map(|(at, _)| at)
    }
}

/// Returns the item that more than half of the sorted ones are equal to.
fn most_common<T: Copy + PartialEq>(sorted: &[T]) -> Option<T> {
    let longest = sorted.chunk_by(|a, b| a == b).max_by_key(|run| run.len())?;
    (2 * longest.len() > sorted.len()).then(|| longest[0])
}

impl Transform {
    /// Whether another transform changes the same convention, so that both together are of no use.
    fn excludes(self, other: Transform) -> bool {
        use Transform::*;
        let convention = |transform| match transform {
            FlipRows => 0,
            FlipColumns => 1,
            AddToIds(_) | PermuteIds => 2,
            NoHit(_) => 3,
            Distance | Depth => 4,
            ZBuffer(_) | Scale(_) => 5,
            Background(_) => 6,
            NegateNormals | OutwardNormals | InwardNormals | UnsignedNormals => 7,
            NormalizeNormals => 8,
            CameraNormals => 9,
            PixelOffset(_) | HorizontalFov | AspectOfMoreRows => 10,
            FarRoots | FarNormals => 11,
        };
        let (one, two) = (convention(self), convention(other));
        // Transforms of what is expected are tried one at a time.
        one == two
            || (self.part() == TransformPart::Expected && other.part() == TransformPart::Expected)
    }
}

impl Allowed {
    /// Returns limits for the search: the given ones, but at least these.
    fn for_search(allowed: &Allowed, t: f64, degrees: f64) -> Allowed {
        let limit = |key, least: f64, unit| {
            let limit = allowed.limit(key);
            let most = if limit.unit == unit { limit.most.max(least) } else { least };
            super::Tolerance { most, unit }
        };
        let mut loose = allowed.clone();
        loose.set(AllowedKey::T, limit(AllowedKey::T, t, LimitUnit::Relative));
        loose.set(AllowedKey::Normal, limit(AllowedKey::Normal, degrees, LimitUnit::Degrees));
        loose
    }
}
