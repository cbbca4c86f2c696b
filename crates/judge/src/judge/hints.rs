//! Conventions that would make more of the claims right.

use kugelblitz::error::Setting;
use kugelblitz::words::joined;

use super::{
    Case, CaseErrors, Claims, Conventions, Judged, NormalSide, NormalSpace, Quantity, RayError,
};

/// Returns the settings under which these claims would be far more right; empty if there are none. Results that mean
/// something else look like gross errors.
pub(super) fn hint(judged: &Judged) -> Vec<Setting> {
    let Judged { case, truth, errors, .. } = judged;
    let before = faults(errors);
    // What stays wrong anyway is of another scene.
    let most_wrong = (case.rays.len() as f64 * MOST_WRONG).max(LITTLE[0]);
    let tried = others(judged).into_iter().filter_map(|(settings, conventions)| {
        let claims = Claims::new(case.image.clone(), &conventions, &case.rays).ok()?;
        let found = faults(&case.errors(&claims, truth));
        (found[0] <= most_wrong && is_far_better(found, before)).then_some((found, settings))
    });
    // Fewer ids are wrong, or as many and the rest is less so. Numbers that are not negative are ordered as their bits.
    let best = tried
        .min_by_key(|&([wrong_ids, t, degrees], _)| [wrong_ids, t + degrees].map(f64::to_bits));
    best.map(|(_, settings)| settings).unwrap_or_default()
}

/// The share of ids that may be wrong by the right conventions.
const MOST_WRONG: f64 = 0.05;

/// A few pixels, the rounding of f32, an angle that no eye sees.
const LITTLE: [f64; 3] = [8.0, 1e-6, 1e-3];

/// How wrong claims are: the number of wrong ids, and the medians of relative errors of `t` and of angles.
type Faults = [f64; 3];

fn faults(CaseErrors { classes, .. }: &CaseErrors) -> Faults {
    let median = |kind: usize| {
        let spread = classes.iter().find_map(|class| class.spreads()[kind]);
        spread.map_or(0.0, |spread| spread.median)
    };
    let wrong_ids = classes.iter().map(|class| class.wrong_ids as f64).sum();
    [wrong_ids, median(1), median(2)]
}

/// Nothing is much worse, and something is a small part of what it was.
fn is_far_better(now: Faults, before: Faults) -> bool {
    const MUCH: f64 = 4.0;
    let pairs = || now.into_iter().zip(before).zip(LITTLE);
    pairs().all(|((now, before), little)| now <= before * MUCH + little)
        && pairs().any(|((now, before), little)| before > little && now * MUCH < before)
}

/// Other conventions, with their settings.
fn others(judged: &Judged) -> Vec<(Vec<Setting>, Conventions)> {
    let Case { image, claims, .. } = &judged.case;
    let conventions = &claims.conventions;
    let mut others = Vec::new();
    let mut add = |settings: &[Setting], change: &dyn Fn(&mut Conventions)| {
        let mut conventions = conventions.clone();
        change(&mut conventions);
        others.push((settings.to_vec(), conventions));
    };
    if !image.is_list && !conventions.rows_from_below {
        add(&[Setting::on("rows_from_below")], &|c| c.rows_from_below = true);
    }
    if claims.has(Quantity::Id) && conventions.id_offset == 0 {
        add(&[Setting::number("id_offset", 1.0)], &|c| c.id_offset = 1);
        add(&[Setting::number("id_offset", -1.0)], &|c| c.id_offset = -1);
    }
    if claims.has(Quantity::Depth) || claims.has(Quantity::Distance) {
        let other = |quantity| match quantity {
            Quantity::Depth => Quantity::Distance,
            Quantity::Distance => Quantity::Depth,
            same => same,
        };
        let quantities: Vec<Quantity> = claims.quantities().map(other).collect();
        let names = joined(quantities.iter().map(|quantity| quantity.name()), ",");
        add(&[Setting::text("as", names)], &|c| c.quantities.clone_from(&quantities));
    }
    if let Some(background) = common_background(judged)
        && conventions.background.is_none()
    {
        add(&[Setting::number("background", background)], &|c| c.background = Some(background));
    }
    if claims.has(Quantity::Normal) {
        let is_inside = judged.truth.hits.iter().any(|hit| hit.is_back);
        let outward = NormalSide::Outward;
        let camera = NormalSpace::Camera;
        let normals = |side| Setting::text("normals", side);
        let in_camera_space = || Setting::text("normal_space", "camera");
        if is_inside {
            add(&[normals("outward")], &|c| c.normal_side = outward);
        }
        add(&[normals("either")], &|c| c.normal_side = NormalSide::Either);
        if !image.is_list {
            add(&[in_camera_space()], &|c| c.normal_space = camera);
            if is_inside {
                add(&[in_camera_space(), normals("outward")], &|c| {
                    (c.normal_side, c.normal_space) = (outward, camera);
                });
            }
        }
    }
    others
}

/// The number that most of the false hits have as their depth.
fn common_background(judged: &Judged) -> Option<f64> {
    let claims = &judged.case.claims;
    let of_ray = |(ray, error): (usize, &RayError)| {
        let (t, _) = claims.depth(ray).filter(|_| *error == RayError::FalseHit)?;
        t.is_finite().then(|| t / claims.conventions.scale)
    };
    let mut depths: Vec<f64> =
        judged.errors.of_rays.iter().enumerate().filter_map(of_ray).collect();
    depths.sort_unstable_by(f64::total_cmp);
    let runs = depths.chunk_by(|a, b| a == b);
    let longest = runs.max_by_key(|run| run.len())?;
    (2 * longest.len() > depths.len() && longest.len() > 1).then(|| longest[0])
}
