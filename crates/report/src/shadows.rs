//! Shadows with and without an epsilon, against exact arithmetic.
//!
//! Each light of a scene gets its own picture, in which it is the only light and everything is white: a pixel that is
//! not black is lit by it. So shadows and colours of all kernels come from the same code.

use std::sync::Arc;

use kugelblitz::Control;
use kugelblitz::device::Device;
use kugelblitz::kernel::Kernel;
use kugelblitz::lighting::{Pixel, Style};
use kugelblitz::rays::Pixels;
use kugelblitz::scene::{Color, Light, Plane, Scene};
use kugelblitz::{Result, Session};
use kugelblitz_judge::verify::{RenderedColors, sample};

use super::measure::{IDS, Work, n_pixels, pixels_of};
use super::{ReportScene, ShadowRow};

/// Distances from the surface at which shadow rays start, world units: none, one that is common in renderers, and one from
/// tutorials.
const EPSILONS: [Option<f64>; 3] = [Some(0.0), Some(1e-4), Some(1e-3)];

/// Maximum number of pixels to compare with exact arithmetic.
const MOST_SAMPLES: usize = 1 << 13;

const WHITE: Color = Color([1.0; 3]);

/// Pictures of the same pixels: the colours of the scene, and each light alone.
#[derive(Clone)]
struct LitPixels {
    srgb: Vec<[u8; 3]>,
    lights: Vec<Vec<[f32; 3]>>,
}

/// A scene, and for each of its lights a white scene with only this light.
struct SeparateLights {
    scene: Arc<Scene>,
    lights: Vec<Arc<Scene>>,
}

impl SeparateLights {
    fn new(scene: &Arc<Scene>) -> Result<SeparateLights> {
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
        let lights = scene.lights.iter().map(alone).collect::<Result<_>>()?;
        Ok(SeparateLights { scene: Arc::clone(scene), lights })
    }

    /// Returns the exact colours of the pixels with these indices.
    fn exact(&self, pixels: &Pixels, index: &[usize], control: &Control) -> Result<LitPixels> {
        let colors = |scene: &Arc<Scene>| RenderedColors::exact(scene, pixels, 1, index, control);
        let lights = self.lights.iter().map(|light| Ok(colors(light)?.linear));
        Ok(LitPixels { srgb: colors(&self.scene)?.srgb8, lights: lights.collect::<Result<_>>()? })
    }

    /// Returns the colours of the pixels with these indices, as a kernel computes them with an epsilon.
    fn rendered(
        &self,
        (kernel, epsilon): (Kernel, Option<f64>),
        pixels: &Pixels,
        index: &[usize],
        control: &Control,
    ) -> Result<LitPixels> {
        let how = (kernel, epsilon.unwrap_or(0.0), pixels, control);
        let lights = self.lights.iter().map(|light| rendered(light, how, index));
        let lights = lights.collect::<Result<_>>()?;
        Ok(LitPixels { srgb: rendered(&self.scene, how, index)?, lights })
    }
}

fn rendered<P: Pixel + Copy>(
    scene: &Arc<Scene>,
    (kernel, epsilon, pixels, control): (Kernel, f64, &Pixels, &Control),
    index: &[usize],
) -> Result<Vec<P>> {
    let mut session = Session::new(Arc::clone(scene), Device::Cpu, kernel);
    let style = Style { epsilon, ..Style::new(P::ENCODING) };
    let (kept, _) = session.keep(pixels, style, IDS, control)?;
    let all = P::all(kept.colors)?;
    Ok(index.iter().map(|&pixel| all[pixel]).collect())
}

fn epsilons(kernel: Kernel) -> &'static [Option<f64>] {
    if kernel == Kernel::Certified { &[None] } else { &EPSILONS }
}

impl ShadowRow {
    /// Counts the differences between the pixels of a kernel and the exact ones.
    fn compare(&mut self, rendered: &LitPixels, exact: &LitPixels) {
        for (rendered, exact) in rendered.lights.iter().zip(&exact.lights) {
            for (rendered, exact) in rendered.iter().zip(exact) {
                let [is_lit, is_lit_exactly] = [rendered, exact].map(|light| light[0] > 0.0);
                self.shadow_rays += 1;
                self.false_shadows += u64::from(is_lit_exactly && !is_lit);
                self.leaks += u64::from(is_lit && !is_lit_exactly);
            }
        }
        self.pixels += exact.srgb.len() as u64;
        let wrong = rendered.srgb.iter().zip(&exact.srgb).filter(|(a, b)| a != b);
        self.wrong_pixels += wrong.count() as u64;
    }
}

impl<'a> Work<'a> {
    fn lit_cases(&self) -> impl Iterator<Item = &'a ReportScene> + use<'a> {
        self.cases.iter().filter(|case| !case.scene.lights.is_empty())
    }

    /// Returns the kernels in their order, each with each of its epsilons.
    fn kernels_with_epsilons(&self) -> Vec<(Kernel, Option<f64>)> {
        let is_used = |kernel: &Kernel| self.benchmarks.iter().any(|of| of.kernel == *kernel);
        let kernels = Kernel::ALL.into_iter().filter(is_used);
        kernels.flat_map(|kernel| epsilons(kernel).iter().map(move |&e| (kernel, e))).collect()
    }

    fn n_shadow_samples(&self) -> usize {
        self.settings.samples.min(MOST_SAMPLES)
    }

    /// Returns the number of rays that [`Work::shadows`] traces or compares, as [`Control::rays_done`] counts them.
    pub(crate) fn n_shadow_rays(&self) -> u64 {
        let n_pixels = n_pixels(self.settings.size);
        let n_kernels = self.kernels_with_epsilons().len() as u64;
        if n_kernels == 0 {
            return 0;
        }
        // Each pixel has a camera ray and a shadow ray.
        let n_of_picture = n_pixels.min(self.n_shadow_samples() as u64) + 2 * n_pixels * n_kernels;
        self.lit_cases().map(|case| (1 + case.scene.lights.len() as u64) * n_of_picture).sum()
    }

    /// Measures the shadows of each scene with lights.
    ///
    /// # Errors
    /// Returns the errors of rendering, and [`Error::Interrupted`](kugelblitz::Error::Interrupted).
    pub(crate) fn shadows(&self) -> Result<Vec<ShadowRow>> {
        let (mut rows, kernels) = (Vec::new(), self.kernels_with_epsilons());
        for case in self.lit_cases().filter(|_| !kernels.is_empty()) {
            let pixels = pixels_of(case.camera()?, self.settings.size);
            let scenes = SeparateLights::new(&case.scene)?;
            let index = sample(pixels.len(), self.n_shadow_samples(), self.settings.seed);
            let exact = scenes.exact(&pixels, &index, self.control)?;
            for &(kernel, epsilon) in &kernels {
                let lit = scenes.rendered((kernel, epsilon), &pixels, &index, self.control)?;
                let (scene, kernel) = (case.name.clone(), kernel.name());
                let mut row = ShadowRow { scene, kernel, epsilon, ..ShadowRow::default() };
                row.compare(&lit, &exact);
                rows.push(row);
            }
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns two pixels of a scene with four lights.
    fn lit() -> LitPixels {
        LitPixels {
            srgb: vec![[10, 20, 30], [200, 100, 0]],
            lights: [[1.0, 0.5], [0.0, 0.5], [1e-30, 0.5], [0.25, 0.0]]
                .map(|light| light.map(|light| [light; 3]).to_vec())
                .to_vec(),
        }
    }

    #[test]
    fn a_right_picture_has_no_error_and_mutations_are_noticed() {
        type Mutation = (&'static str, [u64; 3], fn(&mut LitPixels));
        let mutations: [Mutation; 9] = [
            ("nothing", [0; 3], |_| {}),
            ("another brightness", [0; 3], |s| s.lights[1][1] = [1e-9; 3]),
            ("the faintest light", [1, 0, 0], |s| s.lights[2][0] = [0.0; 3]),
            ("the fourth light", [1, 0, 0], |s| s.lights[3][0] = [0.0; 3]),
            ("a negative light", [1, 0, 0], |s| s.lights[0][0] = [-1.0; 3]),
            ("NaN", [1, 0, 0], |s| s.lights[0][0] = [f32::NAN; 3]),
            ("a leak", [0, 1, 0], |s| s.lights[1][0] = [1e-9; 3]),
            ("a byte", [0, 0, 1], |s| s.srgb[0][2] += 1),
            ("all", [1, 1, 2], |s| {
                (s.lights[0][0], s.lights[1][0]) = ([0.0; 3], [1.0; 3]);
                s.srgb = vec![[255; 3]; 2];
            }),
        ];
        for (what, expected, mutate) in mutations {
            let mut mutated = lit();
            mutate(&mut mutated);
            let mut row = ShadowRow::default();
            row.compare(&mutated, &lit());
            assert_eq!((row.pixels, row.shadow_rays), (2, 8), "{what}");
            assert_eq!([row.false_shadows, row.leaks, row.wrong_pixels], expected, "{what}");
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
        let scenes = SeparateLights::new(&scene).unwrap();
        assert_eq!(scenes.lights.len(), 4);
        for (scene, light) in scenes.lights.iter().zip(&scene.lights) {
            let alone = Light { color: WHITE, intensity: 1.0, ..*light };
            assert_eq!(scene.lights, [alone]);
            assert!(scene.colors().eq([Color::BLACK, WHITE, WHITE]));
            assert!(scene.sky.is_none() && scene.ambient.is_none());
        }
    }
}
