//! The light that a surface gets from a lamp, for the oracle of light and colour.

use std::cmp::Ordering::{Equal, Greater, Less};

use super::enclosure::{Number, Undecided, dot, norm2};
use super::numbers::{LampNumbers, Model, difference, numerators, scaled};

/// A hit point `P/m` with a normal that faces the ray.
pub struct Surface<N> {
    pub id: u32,
    /// The contract's `t`, the first over the second.
    pub t: [N; 2],
    pub point: [N; 3],
    pub m: N,
    /// The normal, of any length.
    pub normal: [N; 3],
    pub length: N,
}

/// `n·ω` of a light that counts.
pub fn cosine<N: Number>(
    model: &Model<N>,
    surface: &Surface<N>,
    lamp: &LampNumbers<N>,
    shadows: bool,
) -> Result<Option<N>, Undecided> {
    let Surface { point, m, normal, length, .. } = surface;
    let w = match lamp.is_point {
        true => difference(&scaled(&lamp.place, m), point),
        false => lamp.place.clone(),
    };
    let along = dot(normal, &w);
    if along.sign()? != Greater || (shadows && is_in_shadow(model, surface, &w, lamp.is_point)?) {
        return Ok(None);
    }
    along.over(&length.times(&norm2(&w).root())).map(Some)
}

/// True where something is met from the surface along `w`, before `w` ends where it ends at a light.
/// `P + s·w` is in units of `1/m`; a sun's `s` is `m` times the contract's.
fn is_in_shadow<N: Number>(
    model: &Model<N>,
    surface: &Surface<N>,
    w: &[N; 3],
    ends: bool,
) -> Result<bool, Undecided> {
    let Surface { id: own, point, m, .. } = surface;
    // `numerator/denominator`, with a denominator greater than 0.
    let is_in_way = |numerator: &N, denominator: &N| -> Result<bool, Undecided> {
        Ok(numerator.sign()? == Greater && (!ends || numerator.minus(denominator).sign()? == Less))
    };
    let a = norm2(w);
    for (id, sphere) in (1..).zip(&model.spheres) {
        if sphere.radius.sign()? == Equal {
            continue;
        }
        let from_center = difference(point, &scaled(&sphere.center, m));
        let b = dot(w, &from_center);
        let roots = if id == *own {
            // One root is 0; their sum is −2b/a.
            vec![b.plus(&b).negative()]
        } else {
            let k = norm2(&from_center).minus(&sphere.radius2.times(&m.squared()));
            numerators(&a, &b, &k)?
        };
        for root in roots {
            if is_in_way(&root, &a)? {
                return Ok(true);
            }
        }
    }
    for (id, plane) in (model.spheres.len() as u32 + 1..).zip(&model.planes) {
        // The own plane is met at 0 alone.
        if id == *own {
            continue;
        }
        let along = dot(w, &plane.normal);
        let to_plane = dot(&difference(&scaled(&plane.point, m), point), &plane.normal);
        let is_met = match along.sign()? {
            Equal => false,
            Greater => is_in_way(&to_plane, &along)?,
            Less => is_in_way(&to_plane.negative(), &along.negative())?,
        };
        if is_met {
            return Ok(true);
        }
    }
    Ok(false)
}
