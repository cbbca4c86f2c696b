//! Wrong rays by object: an error in one object's data shows there.

use std::collections::BTreeMap;

use kugelblitz::scene::Scene;
use serde::Serialize;

use super::claims::Claims;
use super::hits::HitComparison;
use super::transform::Expected;
use super::{Allowed, RayError};

/// Number of wrong rays of an object.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ObjectErrors {
    /// Id of the object; 0 for the background.
    pub id: u32,
    /// Name of the object; `null` if it has none.
    pub name: Option<String>,
    /// Rays that see the object by exact arithmetic.
    pub rays: u64,
    /// Rays with a wrong id that see the object by exact arithmetic or in the file.
    pub wrong_ids: u64,
    /// Rays that see the object, with a wrong `t`.
    pub wrong_t: u64,
    /// Rays that see the object, with a wrong normal.
    pub wrong_normals: u64,
    /// Share of all wrong rays that see the object by exact arithmetic or in the file, 0 to 1.
    pub share_of_wrong: f64,
}

/// Returns whether an error is allowed: of the id, of `t` and of the normal.
pub(super) fn is_allowed(error: &RayError, allowed: &Allowed) -> [bool; 3] {
    match error {
        RayError::Right { t, normal, .. } => [
            true,
            t.is_none_or(|t| allowed.allows_t(&t)),
            normal.is_none_or(|normal| allowed.allows_normal(&normal)),
        ],
        _ => [false, true, true],
    }
}

/// Returns the objects with wrong rays, most wrong first.
pub(super) fn errors_by_object(
    comparison: &HitComparison,
    claims: &Claims,
    expected: &Expected,
    errors: &[RayError],
) -> Vec<ObjectErrors> {
    let HitComparison { scene, allowed, .. } = comparison;
    let mut all: BTreeMap<u32, ObjectErrors> = BTreeMap::new();
    let mut n_wrong = 0_u64;
    let mut n_of = BTreeMap::<u32, u64>::new();
    for (ray, (error, hit)) in errors.iter().zip(&expected.truth.hits).enumerate() {
        let [id, t, normal] = is_allowed(error, allowed);
        if id && t && normal {
            continue;
        }
        n_wrong += 1;
        let claimed = match claims.id(ray) {
            Some(id) if !is_right(error) => id.unwrap_or(0).try_into().ok(),
            _ => None,
        };
        let exists = |id: &u32| *id == 0 || scene.object(*id).is_some();
        let claimed = claimed.filter(|claimed| *claimed != hit.id && exists(claimed));
        for object in [Some(hit.id), claimed].into_iter().flatten() {
            let of = all.entry(object).or_insert_with(|| ObjectErrors::none(scene, object));
            of.wrong_ids += u64::from(!id);
            of.wrong_t += u64::from(!t);
            of.wrong_normals += u64::from(!normal);
            *n_of.entry(object).or_default() += 1;
        }
    }
    for hit in &expected.truth.hits {
        if let Some(of) = all.get_mut(&hit.id) {
            of.rays += 1;
        }
    }
    let mut all: Vec<ObjectErrors> = all.into_values().collect();
    for of in &mut all {
        of.share_of_wrong = n_of[&of.id] as f64 / n_wrong as f64;
    }
    all.sort_by(|a, b| b.share_of_wrong.total_cmp(&a.share_of_wrong).then(b.id.cmp(&a.id)));
    all
}

fn is_right(error: &RayError) -> bool {
    matches!(error, RayError::Right { .. })
}

impl ObjectErrors {
    fn none(scene: &Scene, id: u32) -> ObjectErrors {
        ObjectErrors {
            id,
            name: scene.name(id).map(str::to_owned),
            rays: 0,
            wrong_ids: 0,
            wrong_t: 0,
            wrong_normals: 0,
            share_of_wrong: 0.0,
        }
    }
}
