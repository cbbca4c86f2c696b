//! The numbers of a picture's light for a device that shades it in f64, and what is made of the colours
//! that it proposes.

use super::beam::LARGEST;
use super::finder::{Finder, LampF64, ListedShape};
use super::lamp::{Lamp, Lighting, Origin};
use super::lit::Lit;
use super::painter::Background;
use crate::guard::UNIT_F64;
use crate::prepare::{
    ColorInF64, LampInF64, LightInF64, LightOfAll, PlaneInTheWay, Prepared, SphereInTheWay,
    lamp_kind,
};
use crate::scene::{Color, Edges};

/// The numbers for a device; `None` where one may leave the range that f64 has there.
pub fn light_in_f64(
    lit: &Lit,
    lighting: &Lighting,
    prepared: &Prepared,
    finder: &Finder,
) -> Option<LightInF64> {
    let style = lit.style();
    let lamps = lighting.lamps.iter().zip(&finder.lamps).map(lamp_in_f64).collect();
    let (mut spheres, mut planes) = (Vec::new(), Vec::new());
    for listed in &finder.listed {
        let (id, at) = (listed.id, listed.at.0);
        match listed.shape {
            ListedShape::Sphere(radius) => {
                spheres.push(SphereInTheWay { center: at, radius, id, padding: [0; 7] });
            }
            ListedShape::Plane(normal) => {
                let (normal, padding, padding_again) = (normal.0, 0, 0.0);
                planes.push(PlaneInTheWay { point: at, id, padding, normal, padding_again });
            }
        }
    }
    let tree = prepared.hierarchy.as_ref().map(|hierarchy| &hierarchy.tree);
    let n_samples = style.n_samples as usize;
    let all = LightOfAll {
        ambient: lighting.ambient,
        mean_error: n_terms(n_samples.pow(2), lighting) as f64 * UNIT_F64,
        to_tree: finder.to_tree.to_array(),
        n_lamps: lighting.lamps.len() as u32,
        n_samples: style.n_samples,
        n_listed_spheres: spheres.len() as u32,
        n_listed_planes: planes.len() as u32,
        n_boxes: tree.map_or(0, |tree| tree.n_nodes() as u32),
        leaves_out: u32::from(style.background == Background::LeftOut),
        padding: [0; 4],
    };
    let nothing = match style.background {
        Background::Shown => prepared.scene.background,
        Background::LeftOut | Background::Black => Color::BLACK,
    };
    let colors = std::iter::once(nothing).chain(prepared.scene.colors().skip(1));
    let edges = Edges::srgb8();
    let light = LightInF64 {
        all,
        lamps,
        spheres,
        planes,
        palette: colors.map(|color| ColorInF64::from(color.0)).collect(),
        edges: (1..=255).map(|byte| edges.range(byte).0).collect(),
    };
    is_in_range(&light).then_some(light)
}

/// What [`Lit::shade`] counts as the terms of a pixel's mean; on a device the sum's roundings, the quotient's 2½
/// and 6 others are fewer too.
pub fn n_terms(n_samples: usize, lighting: &Lighting) -> usize {
    n_samples + lighting.lamps.len() + 9
}

fn lamp_in_f64((lamp, here): (&Lamp, &LampF64)) -> LampInF64 {
    let (at, kind) = match *here {
        LampF64::Eye => ([0.0; 3], lamp_kind::EYE),
        LampF64::Point(position) => (position.0, lamp_kind::POINT),
        LampF64::Sun(way) => (way.0, lamp_kind::SUN),
    };
    let shadows = u32::from(lamp.shadows && lamp.origin != Origin::Eye);
    LampInF64 { at, kind, shadows, weight: lamp.weight, padding: 0.0 }
}

/// Whether all numbers have squares in f64's range, so that nothing overflows, and none that is compared with
/// 0 may be flushed to it.
fn is_in_range(light: &LightInF64) -> bool {
    let all = |numbers: &[f64]| numbers.iter().all(|number| number.abs() < LARGEST);
    let is_kept = |number: &f64| *number == 0.0 || number.abs() > 1.0 / LARGEST;
    let are_kept = |numbers: &[f64]| numbers.iter().all(is_kept);
    all(&light.all.ambient)
        && all(&light.all.to_tree)
        && light.lamps.iter().all(|lamp| all(&lamp.at) && are_kept(&lamp.at) && all(&lamp.weight))
        && light.spheres.iter().all(|sphere| all(&sphere.center) && sphere.radius < LARGEST)
        && light.planes.iter().all(|plane| all(&plane.point) && are_kept(&plane.normal))
        && light.palette.iter().all(|color| all(&color.parts))
}
