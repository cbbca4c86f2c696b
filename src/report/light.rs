//! Light: points that a kernel leaves dark though a lamp lights them, and such that it lights though
//! something is in the lamp's way.
//!
//! Whether each lamp counts at a point shows in a picture of the same scene in which everything is white
//! and each of three lamps has a channel of its own: where the channel is not 0, the lamp counts. So the
//! bytes and the shadows of every kernel come from the same painter.

use std::sync::Arc;

use serde::Serialize;

use super::measure::{IDS, Subject, of_first_device, picture};
use super::pictures::worst_first;
use super::scenes::Case;
use super::{Contestant, Effort};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::kernel::Kernel;
use crate::prepare::Prepared;
use crate::rays::Pixels;
use crate::scene::{Color, Light, Plane, Scene};
use crate::shade::{Colors, Encoding, Painter, Style};
use crate::trace::{Hits, Rays};
use crate::tracer::Tracer;
use crate::verify::{ColorTruth, sample};

/// Size of the pictures, px.
pub const LIGHT_SIZE: [u32; 2] = [640, 360];

/// Distances from a surface at which shadow rays of kernels without a proof start, world units: the last
/// is what tutorials take, the middle one is common in renderers.
const EPSILONS: [f64; 3] = [0.0, 1e-4, 1e-3];

/// Most pixels that are compared with exact arithmetic.
const SAMPLES: usize = 1 << 13;

/// A byte that is farther off is seen at a glance.
const FAR_LEVELS: u8 = 8;

/// Most scenes with pictures.
const MOST_SCENES: usize = 2;

/// The kernel whose acne and leaks are shown: the best plain f32.
const SHOWN: Kernel = Kernel::Stable;

/// One scene with lights, lit by each kernel.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LightResult {
    /// The file's name without folder and ending.
    pub scene: String,
    /// The file's first comment: what it shows.
    pub about: String,
    /// Its lights, without a sky.
    pub n_lights: usize,
    /// One row a kernel and epsilon.
    pub rows: Vec<LightRow>,
}

/// One kernel with one epsilon in one scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LightRow {
    /// Who was measured.
    #[serde(flatten)]
    pub contestant: Contestant,
    /// How far from a surface shadow rays start, world units; `None` for a kernel that needs none.
    pub epsilon: Option<f64>,
    /// How wrong it is.
    pub errors: LightErrors,
}

/// The light of one kernel against exact arithmetic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LightErrors {
    /// Pixels compared.
    pub pixels: u64,
    /// Pixels times lights: for each, a light counts or does not.
    pub verdicts: u64,
    /// Lights that count and are left out: acne.
    pub false_shadows: u64,
    /// Lights that don't count and are let in: leaks.
    pub leaks: u64,
    /// Pixels with a wrong byte.
    pub wrong_bytes: u64,
    /// Those with a byte that is off by more than 8 levels.
    pub far_bytes: u64,
}

impl LightErrors {
    /// Lights that are wrongly in shadow or not.
    pub fn wrong_shadows(&self) -> u64 {
        self.false_shadows + self.leaks
    }

    fn add(&mut self, wrong: &Wrong, n_lights: usize) {
        self.pixels += 1;
        self.verdicts += n_lights as u64;
        self.false_shadows += wrong.false_shadows;
        self.leaks += wrong.leaks;
        self.wrong_bytes += u64::from(wrong.levels > 0);
        self.far_bytes += u64::from(wrong.levels > FAR_LEVELS);
    }
}

/// A lit picture of a kernel, and what is wrong with each pixel.
#[derive(Clone, Debug)]
pub struct LightPicture {
    /// The scene's name.
    pub scene: String,
    /// The kernel and device.
    pub contestant: Contestant,
    /// See [`LightRow::epsilon`].
    pub epsilon: Option<f64>,
    /// Width, px.
    pub width: u32,
    /// Height, px.
    pub height: u32,
    /// 8-bit sRGB, row by row from the top.
    pub srgb: Vec<[u8; 3]>,
    /// The error of each pixel.
    pub faults: Vec<LightFault>,
}

/// The light's error in a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightFault {
    /// Every light and every byte as it should be.
    Right,
    /// A light is left out that counts.
    FalseShadow,
    /// A light is let in that doesn't count.
    Leak,
    /// The right lights, and another byte.
    Bytes {
        /// How far the worst byte is off.
        levels: u8,
    },
}

impl From<Wrong> for LightFault {
    fn from(wrong: Wrong) -> LightFault {
        match wrong {
            Wrong { false_shadows: 1.., .. } => LightFault::FalseShadow,
            Wrong { leaks: 1.., .. } => LightFault::Leak,
            Wrong { levels: 0, .. } => LightFault::Right,
            Wrong { levels, .. } => LightFault::Bytes { levels },
        }
    }
}

/// Pictures of the same pixels: the scene's own, and those with a channel for each lamp.
#[derive(Clone, Debug, Default)]
struct Shown {
    srgb: Vec<[u8; 3]>,
    separated: Vec<Vec<[f32; 3]>>,
}

/// What is wrong with a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Wrong {
    false_shadows: u64,
    leaks: u64,
    levels: u8,
}

impl Shown {
    fn counts(&self, pixel: usize, light: usize) -> bool {
        let separated = self.separated.get(light / 3).and_then(|picture| picture.get(pixel));
        separated.is_some_and(|channels| channels[light % 3] > 0.0)
    }

    /// Compares `pixel` with a pixel of `exact`. A pixel that is lacking is black and far off.
    fn wrong(&self, pixel: usize, exact: &Shown, exact_pixel: usize, n_lights: usize) -> Wrong {
        let mut wrong = Wrong::default();
        for light in 0..n_lights {
            match (self.counts(pixel, light), exact.counts(exact_pixel, light)) {
                (false, true) => wrong.false_shadows += 1,
                (true, false) => wrong.leaks += 1,
                _ => {}
            }
        }
        wrong.levels = match (self.srgb.get(pixel), exact.srgb.get(exact_pixel)) {
            (Some(a), Some(b)) => a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0),
            _ => u8::MAX,
        };
        wrong
    }
}

/// A scene's pictures: its own, and for each three of its lights one in which these have the channels.
struct Scenes {
    own: Arc<Scene>,
    separated: Vec<Arc<Scene>>,
}

const WHITE: Color = Color([1.0; 3]);

impl Scenes {
    fn of(scene: &Arc<Scene>) -> Result<Scenes> {
        let separated = |lights: &[Light]| {
            let channel = |index| Color(std::array::from_fn(|k| f64::from(u8::from(k == index))));
            let lights = lights.iter().zip([0, 1, 2].map(channel));
            let lights = lights.map(|(light, color)| Light { color, intensity: 1.0, ..*light });
            let white = |plane: &Plane| Plane { color: WHITE, ..plane.clone() };
            Ok(Arc::new(Scene {
                background: Color::BLACK,
                lights: lights.collect(),
                sky: None,
                ambient: None,
                spheres: scene.spheres.clone().with_color(WHITE)?,
                planes: scene.planes.iter().map(white).collect(),
                ..Scene::clone(scene)
            }))
        };
        let separated = scene.lights.chunks(3).map(separated).collect::<Result<_>>()?;
        Ok(Scenes { own: Arc::clone(scene), separated })
    }

    /// The exact colours of the pixels with these indices.
    fn exactly(&self, pixels: &Pixels, index: &[usize], control: &Control) -> Result<Shown> {
        let truth = |scene| ColorTruth::of_pixels(scene, pixels, 1, index.to_vec(), control);
        let separated = self.separated.iter().map(|scene| Ok(truth(scene)?.colors.linear));
        Ok(Shown {
            srgb: truth(&self.own)?.colors.srgb8,
            separated: separated.collect::<Result<_>>()?,
        })
    }

    /// The colours that a kernel gives all pixels, with each epsilon.
    fn painted(
        &self,
        subject: &Subject,
        pixels: &Pixels,
        control: &Control,
    ) -> Result<Vec<(Option<f64>, Shown)>> {
        let rays = Rays::Pixels(*pixels);
        let mut hits = Hits::default();
        subject.tracer(&self.own, &rays, IDS)?.tracer.trace(&rays, control, &mut hits)?;
        let paint = |scene: &Arc<Scene>, encoding, epsilon| {
            let prepared = Prepared::new(Arc::clone(scene), subject.kernel, &rays)?;
            let mut tracer = Tracer::on_cpu(Arc::new(prepared), IDS);
            let style = Style { epsilon, ..Style::new(encoding) };
            let mut colors = Colors::new(encoding);
            let mut painter = Painter::new(style, pixels, &mut tracer, None);
            painter.paint(pixels, &hits, control, &mut colors)?;
            Ok::<_, Error>(colors)
        };
        let shown = |epsilon: Option<f64>| {
            let distance = epsilon.unwrap_or(0.0);
            let mut shown = Shown::default();
            if let Colors::Srgb8(srgb) = paint(&self.own, Encoding::Srgb8, distance)? {
                shown.srgb = srgb;
            }
            for scene in &self.separated {
                if let Colors::Linear(channels) = paint(scene, Encoding::Linear, distance)? {
                    shown.separated.push(channels);
                }
            }
            Ok((epsilon, shown))
        };
        epsilons(subject.kernel).into_iter().map(shown).collect()
    }

    fn n_lights(&self) -> usize {
        self.own.lights.len()
    }

    /// Pictures that are painted with each epsilon.
    fn n_pictures(scene: &Scene) -> usize {
        1 + scene.lights.len().div_ceil(3)
    }
}

fn epsilons(kernel: Kernel) -> Vec<Option<f64>> {
    match kernel {
        Kernel::Certified => vec![None],
        _ => EPSILONS.map(Some).to_vec(),
    }
}

fn lit(cases: &[Case]) -> impl Iterator<Item = &Case> {
    cases.iter().filter(|case| !case.scene.lights.is_empty())
}

/// Rays and ways to lamps that [`measure_light`] looks at, as [`Control::rays_done`] counts them.
pub(super) fn n_rays(cases: &[Case], subjects: &[Subject], effort: &Effort) -> u64 {
    let [width, height] = LIGHT_SIZE.map(u64::from);
    let subjects = of_first_device(subjects);
    let of_case = |case: &Case| {
        let n_pictures = Scenes::n_pictures(&case.scene) as u64;
        let n_samples = (width * height).min(effort.samples.min(SAMPLES) as u64);
        let of_subject = |subject: &&Subject| {
            width * height * (1 + n_pictures * epsilons(subject.kernel).len() as u64)
        };
        n_pictures * n_samples + subjects.iter().map(of_subject).sum::<u64>()
    };
    match subjects.is_empty() {
        true => 0,
        false => lit(cases).map(of_case).sum(),
    }
}

/// The light of each scene that has lights, by the subjects of the first device: the CPU paints for all of
/// them.
///
/// # Errors
/// Those of tracing; [`Error::Interrupted`](crate::Error::Interrupted).
pub(super) fn measure_light(
    cases: &[Case],
    subjects: &[Subject],
    effort: &Effort,
    control: &Control,
) -> Result<Vec<LightResult>> {
    let subjects = of_first_device(subjects);
    if subjects.is_empty() {
        return Ok(Vec::new());
    }
    let of_case = |case: &Case| {
        let pixels = picture(case, LIGHT_SIZE)?;
        let scenes = Scenes::of(&case.scene)?;
        let index = sample(pixels.len(), effort.samples.min(SAMPLES), effort.seed);
        let exact = scenes.exactly(&pixels, &index, control)?;
        let mut rows = Vec::new();
        for subject in &subjects {
            for (epsilon, shown) in scenes.painted(subject, &pixels, control)? {
                let mut errors = LightErrors::default();
                for (at, &pixel) in index.iter().enumerate() {
                    let wrong = shown.wrong(pixel, &exact, at, scenes.n_lights());
                    errors.add(&wrong, scenes.n_lights());
                }
                rows.push(LightRow { contestant: subject.contestant.clone(), epsilon, errors });
            }
        }
        Ok(LightResult {
            scene: case.name.clone(),
            about: case.about.clone(),
            n_lights: scenes.n_lights(),
            rows,
        })
    };
    lit(cases).map(of_case).collect()
}

/// The scenes with the most wrong shadows of [`SHOWN`], as measured, the worst first.
fn worst<'a>(cases: &'a [Case], results: &[LightResult]) -> Vec<&'a Case> {
    let wrong = |result: &LightResult| -> u64 {
        let shown = result.rows.iter().filter(|row| row.contestant.kernel == SHOWN.name());
        shown.map(|row| row.errors.wrong_shadows()).sum()
    };
    worst_first(lit(cases).zip(results.iter().map(wrong)), MOST_SCENES)
}

/// Pictures of the worst scenes: what `certified` shows, and [`SHOWN`] with each epsilon. The first is what
/// the others are compared with, and is itself compared with exact arithmetic where it was measured.
///
/// # Errors
/// Those of tracing; [`Error::Interrupted`](crate::Error::Interrupted).
pub(super) fn take_light_pictures(
    cases: &[Case],
    results: &[LightResult],
    subjects: &[Subject],
    effort: &Effort,
    control: &Control,
) -> Result<Vec<LightPicture>> {
    let subjects = of_first_device(subjects);
    let of_kernel =
        |kernel: Kernel| subjects.iter().copied().find(|subject| subject.kernel == kernel);
    let (Some(certified), Some(plain)) = (of_kernel(Kernel::Certified), of_kernel(SHOWN)) else {
        return Ok(Vec::new());
    };
    let mut pictures = Vec::new();
    for case in worst(cases, results) {
        let pixels = picture(case, effort.picture_size)?;
        let scenes = Scenes::of(&case.scene)?;
        let proven = scenes.painted(certified, &pixels, control)?;
        let plainly = scenes.painted(plain, &pixels, control)?;
        let Some((_, exact)) = proven.first().cloned() else { continue };
        let of = |subject: &Subject, shown: Vec<(Option<f64>, Shown)>| {
            let contestant = subject.contestant.clone();
            shown.into_iter().map(move |(epsilon, shown)| (contestant.clone(), epsilon, shown))
        };
        for (contestant, epsilon, shown) in of(certified, proven).chain(of(plain, plainly)) {
            let fault = |pixel| shown.wrong(pixel, &exact, pixel, scenes.n_lights()).into();
            pictures.push(LightPicture {
                scene: case.name.clone(),
                contestant,
                epsilon,
                width: pixels.width,
                height: pixels.height,
                faults: (0..pixels.len()).map(fault).collect(),
                srgb: shown.srgb,
            });
        }
    }
    Ok(pictures)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pixels of a scene with four lights.
    fn shown() -> Shown {
        Shown {
            srgb: vec![[10, 20, 30], [200, 100, 0]],
            separated: vec![vec![[1.0, 0.0, 1e-30], [0.5; 3]], vec![[0.25, 0.0, 0.0], [0.0; 3]]],
        }
    }

    fn errors(shown: &Shown) -> LightErrors {
        let (exact, mut errors) = (self::shown(), LightErrors::default());
        (0..2).for_each(|pixel| errors.add(&shown.wrong(pixel, &exact, pixel, 4), 4));
        errors
    }

    #[test]
    fn a_right_picture_has_no_error() {
        let right = LightErrors { pixels: 2, verdicts: 8, ..LightErrors::default() };
        assert_eq!(errors(&shown()), right);
        // How bright a lamp is in its channel is no verdict.
        let mut brighter = shown();
        brighter.separated[0][1] = [9.0, 1e-9, 0.1];
        assert_eq!(errors(&brighter), right);
    }

    #[test]
    fn sabotage_is_noticed() {
        type Sabotage = (&'static str, [u64; 4], LightFault, fn(&mut Shown));
        let (dark, leak) = (LightFault::FalseShadow, LightFault::Leak);
        let bytes = |levels| LightFault::Bytes { levels };
        let sabotages: [Sabotage; 9] = [
            ("the faintest light", [1, 0, 0, 0], dark, |s| s.separated[0][0][2] = 0.0),
            ("the fourth light", [1, 0, 0, 0], dark, |s| s.separated[1][0][0] = 0.0),
            ("a negative light", [1, 0, 0, 0], dark, |s| s.separated[0][0][0] = -1.0),
            ("no number", [1, 0, 0, 0], dark, |s| s.separated[0][0][0] = f32::NAN),
            ("a leak", [0, 1, 0, 0], leak, |s| s.separated[0][0][1] = 1e-9),
            ("a byte up", [0, 0, 1, 0], bytes(1), |s| s.srgb[0][2] += 1),
            ("eight levels down", [0, 0, 1, 0], bytes(8), |s| s.srgb[0][0] -= 8),
            ("nine levels up", [0, 0, 1, 1], bytes(9), |s| s.srgb[0][1] += 9),
            ("both", [1, 1, 1, 1], dark, |s| {
                s.separated[0][0] = [0.0, 1.0, 1.0];
                s.srgb[0] = [255; 3];
            }),
        ];
        for (what, counts, fault, apply) in sabotages {
            let mut wrong = shown();
            apply(&mut wrong);
            let found = errors(&wrong);
            let LightErrors { false_shadows, leaks, wrong_bytes, far_bytes, .. } = found;
            assert_eq!([false_shadows, leaks, wrong_bytes, far_bytes], counts, "{what}");
            assert_eq!((found.pixels, found.verdicts), (2, 8), "{what}");
            let faults = [0, 1].map(|at| LightFault::from(wrong.wrong(at, &shown(), at, 4)));
            assert_eq!(faults, [fault, LightFault::Right], "{what}");
        }
    }

    #[test]
    fn a_pixel_that_lacks_is_wrong() {
        let mut short = shown();
        short.srgb.pop();
        short.separated.iter_mut().for_each(|channels| channels.truncate(1));
        let found = errors(&short);
        assert_eq!((found.false_shadows, found.wrong_bytes, found.far_bytes), (3, 1, 1));
        let found = errors(&Shown::default());
        assert_eq!((found.false_shadows, found.wrong_bytes, found.far_bytes), (6, 2, 2));
    }

    #[test]
    fn each_light_has_a_channel_of_its_own() {
        let text = r##"
            camera = { position = [0, 0, 9], look_at = [0, 0, 0] }
            background = "#ffffff"
            ambient = 0.5
            sky = { intensity = 1.0 }
            light = [
                { position = [0, 5, 5], color = "#123456" }, { direction = [0, -1, 0] },
                { position = "eye", intensity = 3.0 }, { position = [0, -5, 5], intensity = 0.0 },
            ]
            sphere = [{ center = [0, 0, 0], radius = 1, color = "#000000" }]
            plane = [{ point = [0, -1, 0], normal = [0, 1, 0], color = "#00ff00" }]
        "##;
        let scene = Arc::new(crate::scene::parse_scene(text, "a.toml".as_ref()).unwrap());
        let scenes = Scenes::of(&scene).unwrap();
        let channels: Vec<[f64; 3]> = scenes
            .separated
            .iter()
            .flat_map(|scene| scene.lights.iter().map(|light| light.color.0))
            .collect();
        let [red, green, blue] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(channels, [red, green, blue, red]);
        assert_eq!(Scenes::n_pictures(&scene), 3);
        let sources = scenes.separated.iter().flat_map(|scene| &scene.lights);
        assert!(sources.map(|light| light.source).eq(scene.lights.iter().map(|l| l.source)));
        for scene in &scenes.separated {
            assert!(scene.colors().eq([Color::BLACK, WHITE, WHITE]));
            assert!(scene.sky.is_none() && scene.ambient.is_none());
            assert!(scene.lights.iter().all(|light| light.intensity == 1.0));
        }
    }
}
