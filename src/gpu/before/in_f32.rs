//! The numbers of a picture's light for a device that looks at it in f32 first.
//!
//! Those of f64 are rounded, to nearest; what that takes is granted where they are used: of places in [`super::point`] and
//! [`super::beam`]. Of the relative error of a pixel's mean, weights, colours and light from nowhere take half a unit
//! each, a lamp's product and a colour's 1, the quotient 2½, and the last products with their factors 2: less
//! than the 9 that [`n_terms`](super::numbers::n_terms) has beside a unit for each sum. So many units may have a square that counts. What is flushed to 0 is a small part of a
//! unit of the smallest edge, as no factor is above [`MOST_IN_F32`].

use rayon::prelude::*;

use super::beam::LARGEST_IN_F32;
use super::point::SeenFrom;
use super::records::{
    ColorInF32, LampInF32, LampInF64, LightInF32, LightInF64, LightOfAll, LightOfAllInF32,
    NarrowPlane, NarrowPlaneInTheWay, PlaneInTheWay,
};
use crate::guard::{UNIT_F32, UNIT_F64, round_up};
use crate::prepare::{Prepared, lamp_kind};
use crate::rays::Pixels;
use crate::shade::MOST_IN_F32;

/// The numbers of f32; `None` where weights or colours are out of its range.
pub fn in_f32(light: &LightInF64, prepared: &Prepared, samples: &Pixels) -> Option<LightInF32> {
    let LightOfAll { ambient, mean_error, to_tree, .. } = light.all;
    let lamps = light.lamps.iter().flat_map(|lamp| &lamp.weight);
    let colors = light.palette.iter().flat_map(|color| &color.parts);
    if !lamps.chain(colors).chain(&ambient).all(|part| (0.0..MOST_IN_F32).contains(part)) {
        return None;
    }
    let units = mean_error / UNIT_F64 * UNIT_F32;
    let all = LightOfAllInF32 {
        ambient: narrow(ambient),
        mean_error: round_up(units * (1.0 + units)),
        to_tree: narrow_place(to_tree),
        n_lamps: light.all.n_lamps,
        n_samples: light.all.n_samples,
        n_listed_spheres: light.all.n_listed_spheres,
        n_listed_planes: light.all.n_listed_planes,
        n_boxes: light.all.n_boxes,
        leaves_out: light.all.leaves_out,
        least_slack: light.all.least_slack,
        padding: [0; 2],
    };
    let seen = SeenFrom::new(samples, prepared.reference);
    let scene = &prepared.scene;
    Some(LightInF32 {
        all,
        lamps: light.lamps.iter().map(lamp_in_f32).collect(),
        seen_spheres: scene.spheres[..].par_iter().map(|sphere| seen.sphere(sphere)).collect(),
        seen_planes: scene.planes.iter().map(|plane| seen.plane(plane)).collect(),
        planes: light.planes.iter().map(plane_in_f32).collect(),
        palette: light.palette.par_iter().map(|color| ColorInF32::from(color.parts)).collect(),
        edges: light.edges.iter().map(|&edge| round_up(edge)).collect(),
    })
}

fn narrow(numbers: [f64; 3]) -> [f32; 3] {
    numbers.map(|number| number as f32)
}

/// A place, or one beyond [`LARGEST_IN_F32`] where f32 has none.
fn narrow_place(numbers: [f64; 3]) -> [f32; 3] {
    let is_far = numbers.iter().any(|x| x.abs() > LARGEST_IN_F32);
    narrow(if is_far { [4.0 * LARGEST_IN_F32; 3] } else { numbers })
}

/// A direction whose largest component is from 1 to 2, of which only what is 0 becomes 0: a sun's beam surely runs along
/// a plane where each product of the two is one with 0, as in `Beam::meets_plane`.
fn narrow_direction(numbers: [f64; 3]) -> [f32; 3] {
    const LEAST: f64 = 1.0 / (1u128 << 100) as f64;
    numbers.map(|number| match number.abs() {
        0.0 => 0.0,
        size => LEAST.max(size).copysign(number) as f32,
    })
}

fn lamp_in_f32(lamp: &LampInF64) -> LampInF32 {
    let &LampInF64 { at, kind, shadows, weight, .. } = lamp;
    let at = if kind == lamp_kind::SUN { narrow_direction(at) } else { narrow_place(at) };
    let weight = narrow(weight);
    LampInF32 { at, kind, shadows, padding: [0; 3], weight, padding_behind: 0 }
}

fn plane_in_f32(plane: &PlaneInTheWay) -> NarrowPlaneInTheWay {
    let narrow = NarrowPlane { normal: narrow_direction(plane.normal), ..plane.narrow };
    NarrowPlaneInTheWay { narrow, id: plane.id, padding: [0; 3] }
}
