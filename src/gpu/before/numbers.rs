//! The numbers of a picture's light for a device that shades it.

use rayon::prelude::*;

use super::beam::LARGEST;
use super::in_f32::in_f32;
use super::narrow::{narrow_plane, narrow_sphere};
use super::records::{ColorInF64, LampInF64, LightInF64, LightOfAll, PlaneInTheWay};
use super::slabs::least_slack_of_beams;
use crate::guard::UNIT_F64;
use crate::kernel::Kernel;
use crate::prepare::{ColorWords, LightKey, Prepared, lamp_kind};
use crate::rays::{Pixels, Rays};
use crate::scene::{Color, Edges, Sphere};
use crate::seen::PlaneMet;
use crate::seen::shadow::Origin;
use crate::shade::{Lamp, Lighting, Met, Occluders};

/// The numbers for a device that shades the pixels of the kernel `certified`; `None` where that is left to
/// the CPU: of other kernels, and where numbers may leave the range that f64 has there.
pub fn light_in_f64(
    (key, lighting): (LightKey, &Lighting),
    prepared: &Prepared,
    samples: &Pixels,
) -> Option<LightInF64> {
    if prepared.kernel != Kernel::Certified {
        return None;
    }
    let rays = Rays::Pixels(*samples);
    let occluders = Occluders::new(prepared, &rays, lighting);
    let LightKey { words, n_samples, shows_background, leaves_out } = key;
    let (mut spheres, mut planes) = (Vec::new(), Vec::new());
    for listed in &occluders.listed {
        let id = listed.id;
        match listed.met {
            Met::Sphere(met) => {
                if !(all_in_range(&met.center.0) && met.r < LARGEST) {
                    return None;
                }
                spheres.push(id);
            }
            Met::Plane(PlaneMet { point, normal, .. }) => planes.push(PlaneInTheWay {
                point: point.0,
                id,
                padding: 0,
                normal: normal.0,
                padding_again: 0.0,
                narrow: narrow_plane(point.0, normal.0),
                padding_behind: [0; 4],
            }),
        }
    }
    let narrow = |sphere: &Sphere| {
        let center = sphere.center - prepared.reference;
        narrow_sphere(center.to_array(), sphere.radius.abs())
    };
    let tree = prepared.hierarchy.as_ref().map(|hierarchy| &hierarchy.tree);
    let all = LightOfAll {
        ambient: lighting.ambient,
        mean_error: n_terms(n_samples, lighting) as f64 * UNIT_F64,
        to_tree: occluders.to_tree.to_array(),
        n_lamps: lighting.lamps.len() as u32,
        n_samples,
        n_listed_spheres: spheres.len() as u32,
        n_listed_planes: planes.len() as u32,
        n_boxes: tree.map_or(0, |tree| tree.n_nodes() as u32),
        leaves_out: u32::from(leaves_out),
        least_slack: tree.map_or(0.0, |tree| least_slack_of_beams(tree.largest_coordinate())),
        padding: [0; 3],
    };
    let nothing = if shows_background { prepared.scene.background } else { Color::BLACK };
    let colors = std::iter::once(nothing).chain(prepared.scene.colors().skip(1));
    let edges = |edges: &Edges, largest: u16| -> Vec<f64> {
        (1..=largest).map(|number| edges.range(number).0).collect()
    };
    let light = LightInF64 {
        words,
        all,
        lamps: lighting.lamps.iter().zip(&occluders.origins).map(lamp_in_f64).collect(),
        narrow: prepared.scene.spheres[..].par_iter().map(narrow).collect(),
        spheres,
        planes,
        palette: colors.map(|color| ColorInF64::from(color.0)).collect(),
        edges: match words {
            ColorWords::Bytes => edges(Edges::srgb8(), 255),
            ColorWords::Shorts => edges(Edges::srgb16(), u16::MAX),
            ColorWords::Floats => Vec::new(),
        },
        in_f32: None,
    };
    if !is_in_range(&light) {
        return None;
    }
    let in_f32 = match words {
        // A device begins with them in f32; where it can't, all is left to the CPU.
        ColorWords::Bytes => Some(in_f32(&light, prepared, samples)?),
        ColorWords::Shorts | ColorWords::Floats => None,
    };
    Some(LightInF64 { in_f32, ..light })
}

/// What [`crate::shade`] counts as the terms of a pixel's mean; on a device the sum's roundings, the quotient's 2½
/// and 6 others are fewer too.
pub fn n_terms(n_samples: u32, lighting: &Lighting) -> usize {
    n_samples.pow(2) as usize + lighting.lamps.len() + 9
}

fn lamp_in_f64((lamp, here): (&Lamp, &Origin)) -> LampInF64 {
    let (at, kind) = match *here {
        Origin::Point(_) if lamp.origin == crate::shade::Origin::Eye => ([0.0; 3], lamp_kind::EYE),
        Origin::Point(position) => (position.to_array(), lamp_kind::POINT),
        Origin::Sun(way) => (way.to_array(), lamp_kind::SUN),
    };
    let shadows = u32::from(lamp.casts_shadows());
    LampInF64 { at, kind, shadows, weight: lamp.weight, padding: 0.0 }
}

fn all_in_range(numbers: &[f64]) -> bool {
    numbers.iter().all(|number| number.abs() < LARGEST)
}

/// Whether all other numbers have squares in f64's range, too, so that nothing overflows, and none that is
/// compared with 0 may be flushed to it.
fn is_in_range(light: &LightInF64) -> bool {
    let all = all_in_range;
    let is_kept = |number: &f64| *number == 0.0 || number.abs() > 1.0 / LARGEST;
    let are_kept = |numbers: &[f64]| numbers.iter().all(is_kept);
    all(&light.all.ambient)
        && all(&light.all.to_tree)
        && light.lamps.iter().all(|lamp| all(&lamp.at) && are_kept(&lamp.at) && all(&lamp.weight))
        && light.planes.iter().all(|plane| all(&plane.point) && are_kept(&plane.normal))
        && light.palette.iter().all(|color| all(&color.parts))
}
