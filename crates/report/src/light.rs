//! Light: points that a kernel leaves dark though a lamp lights them, and such that it lights though
//! something is in the lamp's way.
//!
//! Whether a lamp counts at a point shows in a picture of the same scene in which everything is white and
//! no other lamp shines: where it is not black, the lamp counts. So the bytes and the shadows of every
//! kernel come from the same painter.

use std::collections::BTreeMap;
use std::sync::Arc;

use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::kernel::Kernel;
use kugelblitz::rays::Pixels;
use kugelblitz::scene::{Color, Light, Plane, Scene};
use kugelblitz::shade::{Pixel, Style};
use kugelblitz::{Result, Session};
use kugelblitz_judge::compare::{FALSE_HIT, WRONG_OBJECT, graded};
use kugelblitz_judge::verify::{RenderedColors, sample};

use super::measure::{IDS, Work, add, n_pixels, picture};
use super::pictures::{ErrorPicture, share_of_pixels, worst_first};
use super::{Benchmark, Count, Of, ReportScene, Row, RowKey};

/// Size of the pictures, px.
pub const LIGHT_SIZE: [u32; 2] = [640, 360];

/// Distances from a surface at which shadow rays of kernels without a proof start, world units: the last
/// is what tutorials take, the middle one is common in renderers.
const EPSILONS: [Option<f64>; 3] = [Some(0.0), Some(1e-4), Some(1e-3)];

/// Most pixels that are compared with exact arithmetic.
const SAMPLES: usize = 1 << 13;

/// A byte that is farther off is seen at a glance.
const FAR_LEVELS: u8 = 8;

/// Bytes that are off by so many levels go from the colour of what is right to that of a large error.
const LEVELS: [f64; 2] = [0.5, 64.0];

/// Most scenes with pictures.
const MOST_SCENES: usize = 2;

/// The kernel whose acne and leaks are shown: the best plain f32.
const SHOWN: Kernel = Kernel::Stable;

/// Pictures of the same pixels: the scene's own, and the linear one of each lamp alone.
#[derive(Clone)]
struct LitPixels {
    srgb: Vec<[u8; 3]>,
    lamps: Vec<Vec<[f32; 3]>>,
}

/// What is wrong with a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Wrong {
    false_shadows: u64,
    leaks: u64,
    levels: u8,
}

impl Wrong {
    fn counts(&self, n_lights: usize) -> [(Count, u64); 6] {
        [
            (Count::Pixels, 1),
            (Count::Verdicts, n_lights as u64),
            (Count::FalseShadows, self.false_shadows),
            (Count::Leaks, self.leaks),
            (Count::WrongBytes, u64::from(self.levels > 0)),
            (Count::FarBytes, u64::from(self.levels > FAR_LEVELS)),
        ]
    }

    fn is_of_shadows(&self) -> bool {
        self.false_shadows + self.leaks > 0
    }

    /// The pixel in a picture of errors: a light that is left out, which is acne, before one that is let in.
    fn color(&self) -> [u8; 3] {
        match *self {
            Wrong { false_shadows: 1.., .. } => FALSE_HIT,
            Wrong { leaks: 1.., .. } => WRONG_OBJECT,
            Wrong { levels, .. } => graded(levels.into(), LEVELS),
        }
    }
}

impl LitPixels {
    /// Compares `pixel` with a pixel of `exact`.
    fn wrong(&self, pixel: usize, exact: &LitPixels, exact_pixel: usize) -> Wrong {
        let mut wrong = Wrong::default();
        for (lamp, exact) in self.lamps.iter().zip(&exact.lamps) {
            match (lamp[pixel][0] > 0.0, exact[exact_pixel][0] > 0.0) {
                (false, true) => wrong.false_shadows += 1,
                (true, false) => wrong.leaks += 1,
                _ => {}
            }
        }
        let bytes = self.srgb[pixel].iter().zip(exact.srgb[exact_pixel]);
        wrong.levels = bytes.map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0);
        wrong
    }
}

/// A scene, and for each of its lights one in which it shines alone.
struct Separated {
    own: Arc<Scene>,
    lamps: Vec<Arc<Scene>>,
}

const WHITE: Color = Color([1.0; 3]);

impl Separated {
    fn of(scene: &Arc<Scene>) -> Result<Separated> {
        let alone = |light: &Light| {
            let white = |plane: &Plane| Plane { color: WHITE, ..plane.clone() };
            Ok(Arc::new(Scene {
                background: Color::BLACK,
                lights: vec![Light { color: WHITE, intensity: 1.0, ..*light }],
                sky: None,
                ambient: None,
                spheres: scene.spheres.clone().with_color(WHITE)?,
                planes: scene.planes.iter().map(white).collect(),
                ..Scene::clone(scene)
            }))
        };
        let lamps = scene.lights.iter().map(alone).collect::<Result<_>>()?;
        Ok(Separated { own: Arc::clone(scene), lamps })
    }

    /// The exact colours of the pixels with these indices.
    fn exactly(&self, pixels: &Pixels, index: &[usize], control: &Control) -> Result<LitPixels> {
        let colors = |scene: &Arc<Scene>| RenderedColors::exact(scene, pixels, 1, index, control);
        let srgb = colors(&self.own)?.srgb8;
        let lamps =
            self.lamps.iter().map(|lamp| Ok(colors(lamp)?.linear)).collect::<Result<_>>()?;
        Ok(LitPixels { srgb, lamps })
    }

    /// The colours that a kernel gives all pixels with an epsilon.
    fn painted(
        &self,
        kernel: Kernel,
        epsilon: Option<f64>,
        pixels: &Pixels,
        control: &Control,
    ) -> Result<LitPixels> {
        let how = (pixels, epsilon.unwrap_or(0.0), control);
        let srgb = painted(&self.own, kernel, how)?;
        let lamps =
            self.lamps.iter().map(|lamp| painted(lamp, kernel, how)).collect::<Result<_>>()?;
        Ok(LitPixels { srgb, lamps })
    }
}

/// A scene as a kernel lights it with an epsilon.
fn painted<P: Pixel>(
    scene: &Arc<Scene>,
    kernel: Kernel,
    (pixels, epsilon, control): (&Pixels, f64, &Control),
) -> Result<Vec<P>> {
    let mut session = Session::new(Arc::clone(scene), Device::Cpu, kernel);
    let style = Style { epsilon, ..Style::new(P::ENCODING) };
    let (kept, _) = session.keep(pixels, style, IDS, control)?;
    Pixel::all(kept.colors)
}

fn epsilons(kernel: Kernel) -> &'static [Option<f64>] {
    if kernel == Kernel::Certified { &[None] } else { &EPSILONS }
}

impl<'a> Work<'a> {
    /// The scenes whose light is measured.
    fn lit(&self) -> impl Iterator<Item = &'a ReportScene> + use<'a> {
        let is_measured = !self.benchmarks.is_empty();
        self.cases.iter().filter(move |case| is_measured && !case.scene.lights.is_empty())
    }

    fn n_light_samples(&self) -> usize {
        self.settings.samples.min(SAMPLES)
    }

    /// Rays and ways to lamps that [`Work::light_rows`] looks at, as [`Control::rays_done`] counts them.
    pub(super) fn n_light_rays(&self) -> u64 {
        let n_pixels = n_pixels(LIGHT_SIZE);
        let n_epsilons: usize =
            self.of_first_device().iter().map(|of| epsilons(of.kernel).len()).sum();
        // Each picture is painted with each epsilon, and has a ray and its light of each pixel.
        let n_of_picture =
            n_pixels.min(self.n_light_samples() as u64) + 2 * n_pixels * n_epsilons as u64;
        self.lit().map(|case| (1 + case.scene.lights.len() as u64) * n_of_picture).sum()
    }

    /// The light of each scene that has lights, by the benchmarks of the first device: the CPU paints for
    /// all of them.
    ///
    /// # Errors
    /// Those of tracing; [`Error::Interrupted`](kugelblitz::Error::Interrupted).
    pub(super) fn light_rows(&self) -> Result<Vec<Row>> {
        let mut rows = Vec::new();
        for case in self.lit() {
            let pixels = picture(case, LIGHT_SIZE)?;
            let scene = Separated::of(&case.scene)?;
            let index = sample(pixels.len(), self.n_light_samples(), self.settings.seed);
            let exact = scene.exactly(&pixels, &index, self.control)?;
            for (kernel, key) in with_epsilons(case, self.of_first_device()) {
                let lit = scene.painted(kernel, key.epsilon, &pixels, self.control)?;
                let mut counts = BTreeMap::new();
                for (at, &pixel) in index.iter().enumerate() {
                    let wrong = lit.wrong(pixel, &exact, at);
                    add(&mut counts, wrong.counts(exact.lamps.len()));
                }
                rows.push(Row { key, numbers: BTreeMap::new(), counts });
            }
        }
        Ok(rows)
    }

    /// Pictures of the scenes with the most wrong shadows of [`SHOWN`], as measured: what `certified` shows,
    /// and [`SHOWN`] with each epsilon. The first is what the others are compared with, and is itself
    /// compared with exact arithmetic where it was measured.
    ///
    /// # Errors
    /// Those of tracing; [`Error::Interrupted`](kugelblitz::Error::Interrupted).
    pub(super) fn light_pictures(&self, rows: &[Row]) -> Result<Vec<ErrorPicture>> {
        let of_kernel = |kernel| self.of_first_device().iter().find(|of| of.kernel == kernel);
        let (Some(certified), Some(plain)) = (of_kernel(Kernel::Certified), of_kernel(SHOWN))
        else {
            return Ok(Vec::new());
        };
        let wrong = |case: &ReportScene| {
            let own = |row: &&Row| with_epsilons(case, [plain]).any(|(_, key)| key == row.key);
            rows.iter().filter(own).map(Row::wrong_shadows).sum()
        };
        let mut pictures = Vec::new();
        for case in worst_first(self.lit(), wrong, MOST_SCENES) {
            let pixels = picture(case, self.settings.picture_size)?;
            let scene = Separated::of(&case.scene)?;
            let mut exact = None;
            for (kernel, key) in with_epsilons(case, [certified, plain]) {
                let lit = scene.painted(kernel, key.epsilon, &pixels, self.control)?;
                let exact = exact.get_or_insert_with(|| lit.clone());
                let all: Vec<Wrong> =
                    (0..pixels.len()).map(|pixel| lit.wrong(pixel, exact, pixel)).collect();
                let share = |what, is: fn(&&Wrong) -> bool| {
                    share_of_pixels(all.iter().filter(is).count(), what, pixels.len())
                };
                pictures.push(ErrorPicture {
                    key,
                    errors: all.iter().map(Wrong::color).collect(),
                    srgb: lit.srgb,
                    verdict: [
                        share("wrong shadow", |wrong| wrong.is_of_shadows()),
                        share("other wrong pixel", |wrong| {
                            !wrong.is_of_shadows() && wrong.levels > 0
                        }),
                    ],
                });
            }
        }
        Ok(pictures)
    }
}

/// Kernels of benchmarks with each of their epsilons, and what rows of the scene's light they have.
fn with_epsilons<'a>(
    case: &ReportScene,
    benchmarks: impl IntoIterator<Item = &'a Benchmark>,
) -> impl Iterator<Item = (Kernel, RowKey)> {
    benchmarks.into_iter().flat_map(move |benchmark| {
        epsilons(benchmark.kernel).iter().map(move |&epsilon| {
            let of = Of::Light { scene: case.name.clone() };
            (benchmark.kernel, RowKey { epsilon, ..benchmark.key(of) })
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pixels of a scene with four lights.
    fn lit() -> LitPixels {
        LitPixels {
            srgb: vec![[10, 20, 30], [200, 100, 0]],
            lamps: [[1.0, 0.5], [0.0, 0.5], [1e-30, 0.5], [0.25, 0.0]]
                .map(|lamp| lamp.map(|light| [light; 3]).to_vec())
                .to_vec(),
        }
    }

    /// False shadows, leaks, wrong bytes and far bytes.
    fn errors(lit: &LitPixels) -> [u64; 4] {
        let (exact, mut counts) = (self::lit(), BTreeMap::new());
        (0..2).for_each(|pixel| add(&mut counts, lit.wrong(pixel, &exact, pixel).counts(4)));
        assert_eq!((counts[&Count::Pixels], counts[&Count::Verdicts]), (2, 8));
        [Count::FalseShadows, Count::Leaks, Count::WrongBytes, Count::FarBytes]
            .map(|count| counts[&count])
    }

    #[test]
    fn a_right_picture_has_no_error_and_sabotage_is_noticed() {
        type Sabotage = (&'static str, [u64; 4], [u8; 3], fn(&mut LitPixels));
        let off = |levels: u8| graded(levels.into(), LEVELS);
        let (right, dark, leak) = (off(0), FALSE_HIT, WRONG_OBJECT);
        let sabotages: [Sabotage; 11] = [
            ("nothing", [0; 4], right, |_| {}),
            ("another brightness is no verdict", [0; 4], right, |s| s.lamps[1][1] = [1e-9; 3]),
            ("the faintest light", [1, 0, 0, 0], dark, |s| s.lamps[2][0] = [0.0; 3]),
            ("the fourth light", [1, 0, 0, 0], dark, |s| s.lamps[3][0] = [0.0; 3]),
            ("a negative light", [1, 0, 0, 0], dark, |s| s.lamps[0][0] = [-1.0; 3]),
            ("no number", [1, 0, 0, 0], dark, |s| s.lamps[0][0] = [f32::NAN; 3]),
            ("a leak", [0, 1, 0, 0], leak, |s| s.lamps[1][0] = [1e-9; 3]),
            ("a byte up", [0, 0, 1, 0], off(1), |s| s.srgb[0][2] += 1),
            ("eight levels down", [0, 0, 1, 0], off(8), |s| s.srgb[0][0] -= 8),
            ("nine levels up", [0, 0, 1, 1], off(9), |s| s.srgb[0][1] += 9),
            ("both", [1, 1, 1, 1], dark, |s| {
                (s.lamps[0][0], s.lamps[1][0]) = ([0.0; 3], [1.0; 3]);
                s.srgb[0] = [255; 3];
            }),
        ];
        let graded = [right, off(1), off(8), off(9), off(64), dark, leak];
        assert!((1..7).all(|i| !graded[..i].contains(&graded[i])));
        for (what, counts, color, apply) in sabotages {
            let mut wrong = lit();
            apply(&mut wrong);
            assert_eq!(errors(&wrong), counts, "{what}");
            let colors = [0, 1].map(|at| wrong.wrong(at, &lit(), at).color());
            assert_eq!(colors, [color, right], "{what}");
        }
    }

    #[test]
    fn each_light_has_a_picture_of_its_own() {
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
        let scene = Arc::new(kugelblitz::scene::parse_scene(text, "a.toml".as_ref()).unwrap());
        let scenes = Separated::of(&scene).unwrap();
        assert_eq!(scenes.lamps.len(), 4);
        for (scene, light) in scenes.lamps.iter().zip(&scene.lights) {
            let alone = Light { color: WHITE, intensity: 1.0, ..*light };
            assert_eq!(scene.lights, [alone]);
            assert!(scene.colors().eq([Color::BLACK, WHITE, WHITE]));
            assert!(scene.sky.is_none() && scene.ambient.is_none());
        }
    }
}
