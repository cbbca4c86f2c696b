//! What lights a scene, as its pixels' points see it.

use glam::DVec3;

use crate::exact::{Dyadic, ExactBeam, ExactPoint, exact, integer, signum};
use crate::rays::{Lens, View};
use crate::scene::{Color, Light, Scene, Source};

/// Most of a weight or a colour for light in f32. No test sees it halved: the range may be smaller.
pub const MOST_IN_F32: f64 = (1u64 << 40) as f64;

/// A light, or a part of the sky.
#[derive(Clone, Debug, PartialEq)]
pub struct PreparedLight {
    /// Index of the light in the scene; `None` for a part of the sky.
    pub light: Option<usize>,
    /// Where its light comes from: the eye is the point that all rays start from, which lights what is seen from there, and
    /// in place of it there is a sun where they are parallel.
    pub origin: Source,
    /// Linear light that a surface across its rays gets: within 2 units `2⁻⁵²` of it, or `2⁻¹⁰⁷⁴` where it is
    /// subnormal; infinite where f64 does not have it.
    pub weight: [f64; 3],
    /// Exact light that a surface across its rays gets, times [`Lighting::n_shares`].
    pub exact_weight: [Dyadic; 3],
    /// Whether objects are in its way.
    pub shadows: bool,
}

impl PreparedLight {
    /// Whether something may be in its way: what is seen from the eye is lit from there.
    pub fn casts_shadows(&self) -> bool {
        self.shadows && self.origin != Source::Eye
    }

    /// The way to it from a point that is seen from `eye`.
    pub fn beam<'a>(&self, point: &'a ExactPoint<'a>, eye: DVec3) -> Option<ExactBeam<'a>> {
        match self.origin {
            Source::Eye => ExactBeam::to_position(point, eye),
            Source::Point(position) => ExactBeam::to_position(point, position),
            Source::Sun(direction) => ExactBeam::against(point, direction),
        }
    }
}

/// All that lights a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Lighting {
    /// Lights, then the sky's suns.
    pub lamps: Vec<PreparedLight>,
    /// Light from nowhere.
    pub ambient: [f64; 3],
    /// The exact weights are multiplied by it, so that they are dyadic: the number of the sky's suns.
    pub n_shares: u32,
}

impl Lighting {
    /// The lighting of a scene, `None` for one that shows colours as they are.
    pub fn new(scene: &Scene, view: &View) -> Option<Lighting> {
        if !scene.is_lit() {
            return None;
        }
        let n_shares = scene.sky.map_or(1, |sky| sky.directions.max(1));
        let shares = integer(n_shares.into());
        let lights = scene.lights.iter().enumerate().map(|(index, light)| {
            let Light { color, intensity, shadows, .. } = *light;
            let exact = color.0.map(|part| exact(part) * exact(intensity) * &shares);
            let weight = color.0.map(|part| part * intensity);
            let origin = origin_of(light, view);
            PreparedLight { light: Some(index), origin, weight, exact_weight: exact, shadows }
        });
        let suns = scene.sky.iter().flat_map(|sky| {
            let weight = [4.0 * sky.intensity / f64::from(n_shares); 3];
            let four = integer(4) * exact(sky.intensity);
            let exact_weight = [four.clone(), four.clone(), four];
            sky.suns().into_iter().map(move |direction| PreparedLight {
                light: None,
                origin: Source::Sun(direction),
                weight,
                exact_weight: exact_weight.clone(),
                shadows: true,
            })
        });
        // In exact numbers: a product of small ones may be 0 in f64.
        let gives_light =
            |lamp: &PreparedLight| lamp.exact_weight.iter().any(|part| signum(part) != 0);
        Some(Lighting {
            lamps: lights.chain(suns).filter(gives_light).collect(),
            ambient: scene.ambient.unwrap_or(Color::BLACK).0,
            n_shares,
        })
    }
}

fn origin_of(light: &Light, view: &View) -> Source {
    match (light.source, view.lens) {
        (Source::Point(position), Lens::Perspective) if position == view.position => Source::Eye,
        (Source::Eye, Lens::Orthographic) => Source::Sun(view.forward),
        (source, _) => source,
    }
}
