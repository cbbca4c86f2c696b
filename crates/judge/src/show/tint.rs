//! Numbers as colours: the one place that gives each mode its colours.

use kugelblitz::Control;
use kugelblitz::Result;
use kugelblitz::prepare::Prepared;
use kugelblitz::query::{Hits, Stage};
use kugelblitz::rays::{Pixels, Rays};
use kugelblitz::scene::{Color, Scene};
use kugelblitz::support::parallel;

use super::Show;
use super::discriminant::Discriminants;
use crate::compare::between;
use crate::verify::{RayError, Truth, ray_errors};

/// Red, green and blue bytes, sRGB.
pub type Rgb = [u8; 3];

/// A pixel's colour, and what it means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tint {
    /// The colour.
    pub color: Rgb,
    /// Place in the legend; `None` for a colour between those of the legend.
    pub entry: Option<u8>,
}

impl Tint {
    fn free(color: Rgb) -> Tint {
        Tint { color, entry: None }
    }

    fn of(swatches: &[Swatch], entry: usize) -> Tint {
        Tint { color: swatches[entry].0, entry: Some(entry as u8) }
    }
}

/// A colour with its meaning.
pub(super) type Swatch = (Rgb, &'static str);

const NOTHING: Rgb = [0x1c, 0x1f, 0x24];

const DEPTHS: [Swatch; 2] = [([244; 3], "near"), ([48; 3], "far")];

const NORMALS: [Swatch; 3] =
    [([255, 128, 128], "+x"), ([128, 255, 128], "+y"), ([128, 128, 255], "+z")];

/// By the sign of D, and without a sphere.
const SIGNS: [Swatch; 4] = [
    ([0x3b, 0x82, 0xc4], "D < 0: the line misses, no real solution"),
    ([0xff, 0xf0, 0x7a], "D = 0: the line touches, one real solution"),
    ([0xd6, 0x45, 0x2c], "D > 0: the line pierces, two real solutions"),
    (NOTHING, "no sphere, or more than 4096"),
];

const STAGES: [Swatch; 3] = [
    ([0x26, 0x3a, 0x4d], "f32"),
    ([0xf2, 0xb7, 0x01], "f64"),
    ([0xff, 0x4d, 0x6d], "exact arithmetic"),
];

/// The largest errors of the first entries of [`ERRORS`], ulp.
const MOST_ULP: [f64; 5] = [0.5, 1.0, 16.0, 4096.0, f64::INFINITY];

const ERRORS: [Swatch; 9] = [
    ([0x1d, 0x4d, 0x3a], "t is the nearest f32"),
    ([0x3a, 0x9d, 0x74], "t within 1 ulp"),
    ([0xa7, 0xc9, 0x57], "t within 16 ulp"),
    ([0xf2, 0xb7, 0x01], "t within 4096 ulp"),
    ([0xf0, 0x7d, 0x1a], "t is off by more"),
    (NOTHING, "background, rightly"),
    ([0xe0, 0x2f, 0x6b], "wrong object"),
    ([0xb0, 0x4c, 0xd8], "object missed"),
    ([0xff, 0x9e, 0xc4], "hit where nothing is"),
];

/// Places in [`ERRORS`].
const RIGHTLY_NOTHING: usize = 5;
const OTHER: usize = 6;
const MISSED: usize = 7;
const INVENTED: usize = 8;

/// The legend of `show`, in the order of [`Tint::entry`].
pub(super) fn swatches(show: Show) -> &'static [Swatch] {
    match show {
        Show::Color | Show::Id => &[],
        Show::Depth => &DEPTHS,
        Show::Normal => &NORMALS,
        Show::Discriminant => &SIGNS,
        Show::Error => &ERRORS,
        Show::Stage => &STAGES,
    }
}

/// Colours by id, the background's first: the objects' own where `show` has none by id.
pub fn palette(show: Show, scene: &Scene) -> Vec<Rgb> {
    tints_by_id(show, scene).into_iter().map(|tint| tint.color).collect()
}

/// Tints by id, with the colours of [`palette`].
fn tints_by_id(show: Show, scene: &Scene) -> Vec<Tint> {
    let tint = |(id, color): (u32, Color)| match (show, id) {
        (Show::Id, 0) => Tint::free(NOTHING),
        (Show::Id, _) => Tint::free(id_color(id)),
        _ => Tint::free(color.to_srgb8()),
    };
    (0..).zip(scene.colors()).map(tint).collect()
}

/// Hues a golden angle apart, so that neighbouring ids differ.
fn id_color(id: u32) -> Rgb {
    let hue = (f64::from(id) * 0.618_033_988_749_895).fract() * 6.0;
    let (value, chroma) = if id.is_multiple_of(2) { (0.95, 0.62) } else { (0.75, 0.55) };
    let channel = |shift: f64| {
        let distance = ((hue + shift) % 6.0 - 3.0).abs() - 1.0;
        ((value - chroma * (1.0 - distance.clamp(0.0, 1.0))) * 255.0).round() as u8
    };
    [channel(0.0), channel(4.0), channel(2.0)]
}

/// The colours of `pixels`, row by row. `hits` has what [`Show::wants`], of a scene that is `prepared` for
/// the kernel that is looked at; `range` is that of `t` in the whole picture, for [`Show::Depth`].
/// `control` counts the pixels that exact arithmetic looks at.
///
/// # Errors
/// [`Error::Interrupted`](kugelblitz::Error::Interrupted) when `control` was cancelled.
pub fn tints(
    show: Show,
    prepared: &Prepared,
    pixels: &Pixels,
    hits: &Hits,
    range: Option<[f32; 2]>,
    control: &Control,
) -> Result<Vec<Tint>> {
    let scene = &*prepared.scene;
    Ok(match show {
        Show::Color | Show::Id => {
            let by_id = tints_by_id(show, scene);
            hits.id.iter().map(|&id| by_id[id as usize]).collect()
        }
        Show::Depth => hits.t.iter().map(|&t| Tint::free(depth(t, range))).collect(),
        Show::Normal => {
            let normals = hits.normal.iter().zip(&hits.id);
            normals.map(|(&normal, &id)| Tint::free(normal_color(normal, id))).collect()
        }
        Show::Stage => {
            let stage = |&level: &u8| usize::from(level).min(Stage::Exact as usize);
            hits.level.iter().map(|level| Tint::of(&STAGES, stage(level))).collect()
        }
        Show::Discriminant => {
            let discriminants = Discriminants::new(prepared, pixels);
            let tint = |index| {
                control.check().ok()?;
                Some(match discriminants.at(index, hits.id[index]) {
                    Some((sign, nearness)) => shaded(sign, nearness),
                    None => Tint::of(&SIGNS, 3),
                })
            };
            let tints = parallel::filter_map(hits.id.len(), tint);
            control.check().map(|()| tints)?
        }
        Show::Error => {
            let all = (0..hits.id.len()).collect();
            let truth = Truth::of_rays(scene, &Rays::Pixels(*pixels), all, control)?;
            ray_errors(hits, &truth).map(|error| Tint::of(&ERRORS, entry(&error))).collect()
        }
    })
}

/// Near is bright; the scale is logarithmic.
fn depth(t: f32, range: Option<[f32; 2]>) -> Rgb {
    let (Some([low, high]), true) = (range, t.is_finite()) else { return NOTHING };
    let span = (f64::from(high) / f64::from(low)).ln().max(f64::MIN_POSITIVE);
    let share = ((f64::from(t) / f64::from(low)).ln() / span).clamp(0.0, 1.0);
    let [near, far] = DEPTHS.map(|(color, _)| color);
    between(near, far, share)
}

/// −1 … 1 as 0 … 255.
fn normal_color(normal: [f32; 3], id: u32) -> Rgb {
    if id == 0 {
        return NOTHING;
    }
    normal.map(|x| ((f64::from(x) + 1.0) * 127.5).round() as u8)
}

/// The place of an error in [`ERRORS`].
fn entry(error: &RayError) -> usize {
    match error {
        RayError::FalseHit => INVENTED,
        RayError::FalseMiss => MISSED,
        RayError::WrongObject => OTHER,
        RayError::Right { id: 0, .. } => RIGHTLY_NOTHING,
        RayError::Right { t, .. } => {
            let ulp = t.map_or(0.0, |t| t.ulp);
            MOST_ULP.iter().position(|most| ulp <= *most).unwrap_or(MOST_ULP.len() - 1)
        }
    }
}

/// Brighter the nearer the line comes to the middle of the sphere.
fn shaded(sign: i32, nearness: f64) -> Tint {
    let (entry, light) = match sign {
        0 => (1, 1.0),
        1 => (2, 0.45 + 0.55 * nearness.clamp(0.0, 1.0)),
        _ => (0, 0.25 + 0.75 / (1.0 + nearness.min(0.0).abs())),
    };
    let Tint { color, entry } = Tint::of(&SIGNS, entry);
    Tint { color: between([0; 3], color, light), entry }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;
    use std::sync::Arc;

    use kugelblitz::query::{Kernel, Outputs};
    use kugelblitz::rays::View;
    use kugelblitz::scene::parse_scene;
    use kugelblitz::tracer::Tracer;

    use super::*;

    const FIGURE5: &str = include_str!("../../../../scenes/figure5.toml");

    fn figure5() -> (Arc<Scene>, Pixels) {
        let scene = Arc::new(parse_scene(FIGURE5, Path::new("figure5.toml")).unwrap());
        let view = View::new(scene.camera.as_ref().unwrap());
        (scene, Pixels::whole(view, 1281, 721))
    }

    /// A part of the picture that shows all three spheres.
    fn middle() -> Pixels {
        Pixels { x: 560, y: 300, width: 161, height: 121, ..figure5().1 }
    }

    fn traced(scene: Arc<Scene>, kernel: Kernel, pixels: Pixels) -> (Prepared, Hits) {
        let rays = Rays::Pixels(pixels);
        let prepared = Prepared::new(scene, kernel, &rays).unwrap();
        let wants = Outputs { surface: true, level: true };
        let mut hits = Hits::default();
        let mut tracer = Tracer::on_cpu(Arc::new(prepared.clone()), wants);
        tracer.trace(&rays, &Control::default(), &mut hits).unwrap();
        (prepared, hits)
    }

    fn shown(show: Show, kernel: Kernel, pixels: Pixels) -> Vec<Tint> {
        let (prepared, hits) = traced(figure5().0, kernel, pixels);
        tints(show, &prepared, &pixels, &hits, None, &Control::default()).unwrap()
    }

    #[test]
    fn entries_name_the_colours_of_the_legend() {
        for show in Show::ALL {
            let swatches = swatches(show);
            for tint in shown(show, Kernel::Certified, middle()) {
                if let Some(entry) = tint.entry {
                    // That of the discriminant is shaded.
                    let (color, _) = swatches[usize::from(entry)];
                    assert!(show == Show::Discriminant || color == tint.color, "{show}");
                }
            }
        }
    }

    #[test]
    fn palettes_have_a_colour_for_each_id() {
        let (scene, _) = figure5();
        for show in Show::ALL {
            assert_eq!(palette(show, &scene).len(), scene.n_objects() + 1);
        }
        let ids: BTreeSet<Rgb> = (1..200).map(id_color).collect();
        assert!(ids.len() > 190, "{} colours", ids.len());
    }

    #[test]
    fn what_is_of_objects_has_the_colours_of_the_palette() {
        let pixels = middle();
        for show in Show::ALL.into_iter().filter(|show| show.is_of_objects()) {
            let (scene, (_, hits)) = (figure5().0, traced(figure5().0, Kernel::Stable, pixels));
            let palette = palette(show, &scene);
            let tints = shown(show, Kernel::Stable, pixels);
            assert!(tints.iter().zip(&hits.id).all(|(t, &id)| t.color == palette[id as usize]));
        }
    }

    #[test]
    fn depth_and_normal_follow_the_numbers() {
        assert_eq!([0.5, 24.0, 1e9].map(|t| depth(t, Some([0.5, 24.0]))[0]), [244, 48, 48]);
        assert_eq!(depth(12f32.sqrt(), Some([0.5, 24.0])), [146; 3]);
        assert_eq!(depth(2.0, Some([2.0, 2.0])), [244; 3]);
        assert_eq!([depth(f32::INFINITY, Some([0.5, 1.0])), depth(1.0, None)], [NOTHING; 2]);
        assert_eq!(normal_color([0.0, -1.0, 1.0], 3), [128, 0, 255]);
        assert_eq!(normal_color([0.0; 3], 0), NOTHING);
    }

    #[test]
    fn discriminants_stop_when_they_are_cancelled() {
        let pixels = middle();
        let (prepared, hits) = traced(figure5().0, Kernel::Certified, pixels);
        let control = Control::default();
        control.cancel();
        for show in [Show::Discriminant, Show::Error] {
            assert!(tints(show, &prepared, &pixels, &hits, None, &control).is_err());
        }
    }
}
