//! Conventions that would make more of the claims right.

use super::{Claims, Conventions, Judgement, NormalSide, NormalSpace, Part, Quantity, judge};
use crate::error::Result;
use crate::picture::Image;
use crate::rays::{Rays, View};
use crate::scene::Scene;
use crate::verify::{RayError, Truth};

/// Another convention, as options of the command line.
struct Other {
    options: String,
    conventions: Conventions,
}

/// The options under which these claims would be far more right, where there are such: results that mean
/// something else look like gross errors.
///
/// # Errors
/// Those of [`judge`].
pub fn hint(
    scene: &Scene,
    rays: &Rays,
    truth: &Truth,
    (image, conventions, view): (&Image, &Conventions, Option<&View>),
    (claims, judgement): (&Claims, &Judgement),
) -> Result<Option<String>> {
    let before = Faults::new(judgement);
    // What stays wrong anyway is of another scene.
    let most_wrong = rays.len() as f64 * MOST_WRONG;
    let mut best: Option<(Faults, String)> = None;
    for Other { options, conventions } in others(image, conventions, truth, claims, judgement) {
        let Ok(claims) = Claims::new(image.clone(), &conventions, view) else { continue };
        let found = Faults::new(&judge(scene, rays, truth, &claims)?);
        let is_best = best.as_ref().is_none_or(|(best, _)| found.is_better_than(best));
        let is_right = found.wrong_ids <= most_wrong.max(LITTLE[0]);
        if is_right && is_best && found.is_far_better_than(&before) {
            best = Some((found, options));
        }
    }
    Ok(best.map(|(_, options)| options))
}

/// The share of ids that may be wrong by the right conventions.
const MOST_WRONG: f64 = 0.05;

/// A few pixels, the rounding of f32, an angle that no eye sees.
const LITTLE: [f64; 3] = [8.0, 1e-6, 1e-3];

/// How wrong claims are, in few numbers.
struct Faults {
    wrong_ids: f64,
    t: f64,
    degrees: f64,
}

impl Faults {
    fn new(judgement: &Judgement) -> Faults {
        let parts = || [&judgement.away, &judgement.silhouettes].into_iter();
        let median = |of: fn(&Part) -> Option<f64>| parts().find_map(of).unwrap_or(0.0);
        Faults {
            wrong_ids: parts().map(|part| part.wrong_ids() as f64).sum(),
            t: median(|part| part.t_relative.map(|spread| spread.median)),
            degrees: median(|part| part.normal_degrees.map(|spread| spread.median)),
        }
    }

    fn numbers(&self) -> [f64; 3] {
        [self.wrong_ids, self.t, self.degrees]
    }

    /// Nothing is much worse, and something is a small part of what it was.
    fn is_far_better_than(&self, before: &Faults) -> bool {
        const MUCH: f64 = 4.0;
        let pairs = || self.numbers().into_iter().zip(before.numbers()).zip(LITTLE);
        pairs().all(|((now, before), little)| now <= before * MUCH + little)
            && pairs().any(|((now, before), little)| before > little && now * MUCH < before)
    }

    fn is_better_than(&self, other: &Faults) -> bool {
        self.wrong_ids < other.wrong_ids
            || self.wrong_ids == other.wrong_ids && self.t + self.degrees < other.t + other.degrees
    }
}

fn others(
    image: &Image,
    conventions: &Conventions,
    truth: &Truth,
    claims: &Claims,
    judgement: &Judgement,
) -> Vec<Other> {
    let mut others = Vec::new();
    let mut add = |options: &str, change: &dyn Fn(&mut Conventions)| {
        let mut conventions = conventions.clone();
        change(&mut conventions);
        others.push(Other { options: options.into(), conventions });
    };
    let has = |quantity| claims.quantities.contains(&quantity);
    if !image.is_list && !conventions.rows_from_below {
        add("--rows-from-below", &|c| c.rows_from_below = true);
    }
    if has(Quantity::Id) && conventions.id_offset == 0 {
        add("--id-offset 1", &|c| c.id_offset = 1);
        add("--id-offset=-1", &|c| c.id_offset = -1);
    }
    for (from, to) in [(Quantity::Depth, Quantity::Distance), (Quantity::Distance, Quantity::Depth)]
    {
        if has(from) {
            let replaced = |q: &Quantity| if *q == from { to } else { *q };
            let quantities: Vec<Quantity> = claims.quantities.iter().map(replaced).collect();
            let names: Vec<&str> = quantities.iter().map(|q| q.name()).collect();
            let options = format!("--as {}", names.join(","));
            add(&options, &|c| c.quantities.clone_from(&quantities));
        }
    }
    if let Some(background) = common_background(claims, judgement, conventions.scale)
        && conventions.background.is_none()
    {
        add(&format!("--background {background}"), &|c| c.background = Some(background));
    }
    if has(Quantity::Normal) {
        let is_inside = truth.is_back.contains(&true);
        let outward = NormalSide::Outward;
        let camera = NormalSpace::Camera;
        if is_inside {
            add("--normals outward", &|c| c.normal_side = outward);
        }
        add("--normals either", &|c| c.normal_side = NormalSide::Either);
        if !image.is_list {
            add("--normal-space camera", &|c| c.normal_space = camera);
            if is_inside {
                add("--normal-space camera --normals outward", &|c| {
                    (c.normal_side, c.normal_space) = (outward, camera);
                });
            }
        }
    }
    others
}

/// The number that most of the false hits have as their depth.
fn common_background(claims: &Claims, judgement: &Judgement, scale: f64) -> Option<f64> {
    let t = claims.t.as_ref()?;
    let false_hits = judgement.errors.iter().zip(t);
    let false_hits = false_hits.filter(|(error, t)| **error == RayError::FalseHit && t.is_finite());
    let mut depths: Vec<f64> = false_hits.map(|(_, &t)| t / scale).collect();
    depths.sort_unstable_by(f64::total_cmp);
    let runs = depths.chunk_by(|a, b| a == b);
    let longest = runs.max_by_key(|run| run.len())?;
    (2 * longest.len() > depths.len() && longest.len() > 1).then(|| longest[0])
}
