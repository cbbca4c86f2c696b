//! Colours of lit or sampled pictures against exact arithmetic and against each other.

use std::fmt;

use kugelblitz::Control;
use kugelblitz::exact::ExactPixels;
use kugelblitz::lighting::{Colors, Encoding, Lighting, Style};
use kugelblitz::query::{Hits, Outputs};
use kugelblitz::rays::Pixels;
use kugelblitz::scene::{Color, Samples, Scene};
use kugelblitz::support::parallel;
use kugelblitz::{Result, Session};

use super::lit::{LitPoint, exact_mean};
use super::{Near, hit_of};

/// Colours of the same pixels in every encoding.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderedColors {
    /// sRGB, 8 bits a channel.
    pub srgb8: Vec<[u8; 3]>,
    /// sRGB, 16 bits a channel.
    pub srgb16: Vec<[u16; 3]>,
    /// Linear f32.
    pub linear: Vec<[f32; 3]>,
}

/// The part of [`Hits`] that is compared.
pub(super) const WANTS: Outputs = Outputs { surface: true, level: false };

/// All that [`RenderedColors`] has.
pub(super) const ENCODINGS: [Encoding; 3] = [Encoding::Srgb8, Encoding::Srgb16, Encoding::Linear];

impl RenderedColors {
    /// Returns the colours of a band of pixels, as a picture has them, with the hits of the pixels' centre rays. Kernels without
    /// a proof light only the pixels with the indices `lit`; the colours of their other pixels have no meaning.
    ///
    /// # Errors
    /// Returns the errors of [`Session::keep`] and [`Session::baseline_means`].
    pub fn kept(
        session: &mut Session,
        band: &Pixels,
        n_samples: Samples,
        lit: &[usize],
        control: &Control,
    ) -> Result<(Hits, RenderedColors)> {
        let means = session.baseline_means(band, (n_samples, WANTS), lit, control)?;
        if let Some((hits, means)) = means {
            let encoded = means.iter().map(|&mean| {
                let color = Color(mean);
                (color.to_srgb8(), (color.to_srgb16(), mean.map(|part| part as f32)))
            });
            let (srgb8, (srgb16, linear)) = encoded.unzip();
            return Ok((hits, RenderedColors { srgb8, srgb16, linear }));
        }
        let (mut hits, mut shown) = (Hits::default(), RenderedColors::default());
        for encoding in ENCODINGS {
            let style = Style { n_samples, ..Style::new(encoding) };
            let (kept, _) = session.keep(band, style, WANTS, control)?;
            hits = kept.hits;
            shown.set(kept.colors);
        }
        Ok((hits, shown))
    }

    /// Sets the colours of their encoding.
    fn set(&mut self, colors: Colors) {
        match colors {
            Colors::Srgb8(pixels) => self.srgb8 = pixels,
            Colors::Srgb16(pixels) => self.srgb16 = pixels,
            Colors::Linear(pixels) => self.linear = pixels,
        }
    }

    /// The exact colours of the pixels with these indices, by exact arithmetic on every object that f64 does
    /// not clearly rule out. No tree, no filter: this is what one is judged by. `control` counts each
    /// pixel as a ray.
    ///
    /// # Errors
    /// [`Error::Interrupted`](kugelblitz::Error::Interrupted) when `control` was cancelled.
    pub fn exact(
        scene: &Scene,
        pixels: &Pixels,
        n_samples: u32,
        index: &[usize],
        control: &Control,
    ) -> Result<RenderedColors> {
        let lighting = Lighting::new(scene, &pixels.view);
        let of_samples = pixels.samples(n_samples);
        let rays = ExactPixels::new(&of_samples);
        let seen = parallel::try_map(index, |&index| {
            control.check()?;
            control.advance(1);
            let at = (&of_samples, &rays);
            let samples =
                samples_of_pixel(scene, lighting.as_ref(), at, n_samples, pixels.xy(index));
            let samples = samples.iter().map(|(id, point)| (*id, point.as_ref()));
            let mean = exact_mean(scene, lighting.as_ref(), samples);
            Ok((mean.pixel::<u8>(), (mean.pixel::<u16>(), mean.pixel::<f32>())))
        })?;
        let (srgb8, (srgb16, linear)) = seen.into_iter().unzip();
        Ok(RenderedColors { srgb8, srgb16, linear })
    }

    /// The numbers of a pixel, bit by bit.
    fn bits(&self, index: usize) -> [Option<[u32; 3]>; 3] {
        [
            self.srgb8.get(index).map(|color| color.map(u32::from)),
            self.srgb16.get(index).map(|color| color.map(u32::from)),
            self.linear.get(index).map(|color| color.map(f32::to_bits)),
        ]
    }
}

/// Ids that the samples of a pixel see, and the points that light may fall on. `of_samples` are the
/// samples of the picture, as pixels and exactly.
pub(crate) fn samples_of_pixel<'a>(
    scene: &'a Scene,
    lighting: Option<&Lighting>,
    (of_samples, rays): (&Pixels, &ExactPixels),
    n_samples: u32,
    (x, y): (u32, u32),
) -> Vec<(u32, Option<LitPoint<'a>>)> {
    let sample = |at: u32| {
        let (x, y) = (x * n_samples + at % n_samples, y * n_samples + at / n_samples);
        let near = Near::of_pixel(of_samples, (x, y));
        let exact = rays.ray(x, y);
        let Some(hit) = hit_of(scene, &exact, &near) else { return (0, None) };
        (hit.id, lighting.map(|_| LitPoint::new(&exact, &hit, &near)))
    };
    parallel::map(0..n_samples * n_samples, sample)
}

/// Number of pixels whose colours differ.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct ColorDifferences {
    /// Pixels compared.
    pub pixels: u64,
    /// Pixels that differ in 8 bits.
    pub srgb8: u64,
    /// Pixels that differ in 16 bits.
    pub srgb16: u64,
    /// Pixels whose linear floats differ, bit by bit.
    pub linear: u64,
    /// Index of the first pixel that differs; `null` if none does.
    pub first: Option<usize>,
}

impl ColorDifferences {
    /// True where everything is equal.
    pub fn is_equal(&self) -> bool {
        self.first.is_none()
    }

    /// Counts pixels of a band, which begins at `first_pixel`: of `a` those with these indices, of `b` all, in their
    /// order. What one of the two lacks differs.
    pub fn see(
        &mut self,
        (a, index): (&RenderedColors, impl IntoIterator<Item = usize>),
        b: &RenderedColors,
        first_pixel: usize,
    ) {
        for (at, index) in index.into_iter().enumerate() {
            self.pixels += 1;
            let counts = [&mut self.srgb8, &mut self.srgb16, &mut self.linear];
            for ((count, a), b) in counts.into_iter().zip(a.bits(index)).zip(b.bits(at)) {
                if a.is_none() || a != b {
                    *count += 1;
                    self.first.get_or_insert(first_pixel + index);
                }
            }
        }
    }

    /// Counts the pixels of a band, which begins at `first_pixel`, whose colours in two results differ.
    pub fn see_all(&mut self, a: &RenderedColors, b: &RenderedColors, first_pixel: usize) {
        self.see((a, 0..a.srgb8.len().max(b.srgb8.len())), b, first_pixel);
    }
}

impl fmt::Display for ColorDifferences {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let ColorDifferences { pixels, srgb8, srgb16, linear, .. } = self;
        write!(f, "of {pixels} pixels, {srgb8} in 8 bits, {srgb16} in 16, {linear} in floats")
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;
    use kugelblitz::device::Device;
    use kugelblitz::query::Kernel;
    use kugelblitz::rays::View;
    use kugelblitz::render::n_steps;
    use kugelblitz::scene::{Camera, Color, Light, Plane, Sky, Source, Sphere};

    use super::super::{Differences, broken_promises};
    use super::*;
    use crate::compare::RayDifferences;

    /// A floor, spheres on it, and all kinds of light.
    fn scene() -> (Arc<Scene>, Pixels) {
        let camera = Camera::new(DVec3::new(0.0, 1.5, 5.0), DVec3::new(0.0, 0.5, 0.0));
        let pixels = Pixels::whole(View::new(&camera), 36, 24);
        let sphere = |x, radius| (Sphere { center: DVec3::new(x, radius, 0.0), radius }, x);
        let spheres = [sphere(-0.6, 0.7), sphere(0.9, 0.4)];
        let colored = |(sphere, x): (Sphere, f64)| (sphere, Color([0.5 + x / 2.0, 0.7, 0.2]));
        let light =
            |source, part| Light { source, color: Color(part), intensity: 0.6, shadows: true };
        let floor =
            Plane { name: None, point: DVec3::ZERO, normal: DVec3::Y, color: Color([0.8; 3]) };
        let scene = Scene {
            background: Color([0.1, 0.2, 0.3]),
            camera: Some(camera),
            spheres: spheres.into_iter().map(colored).collect(),
            planes: vec![floor],
            lights: vec![
                light(Source::Point(DVec3::new(3.0, 4.0, 2.0)), [1.0, 0.9, 0.8]),
                light(Source::Sun(DVec3::new(1.0, -1.0, -0.25)), [0.2, 0.2, 0.4]),
                light(Source::Eye, [0.1; 3]),
            ],
            sky: Some(Sky { intensity: 0.25, directions: 5 }),
            ambient: Some(Color([0.05; 3])),
            ..Scene::default()
        };
        (Arc::new(scene), pixels)
    }

    fn painted(scene: &Arc<Scene>, pixels: &Pixels, n_samples: u32) -> RenderedColors {
        let mut session = Session::new(Arc::clone(scene), Device::Cpu, Kernel::Certified);
        let n = Samples::nearest(n_samples);
        RenderedColors::kept(&mut session, pixels, n, &[], &Control::default()).unwrap().1
    }

    fn truth(scene: &Scene, pixels: &Pixels, n_samples: u32) -> RenderedColors {
        let all: Vec<usize> = (0..pixels.len()).collect();
        RenderedColors::exact(scene, pixels, n_samples, &all, &Control::default()).unwrap()
    }

    /// From others and from the truth.
    fn found(shown: &RenderedColors, truth: &RenderedColors) -> [ColorDifferences; 2] {
        let mut found = <[ColorDifferences; 2]>::default();
        found[0].see_all(shown, truth, 0);
        found[1].see((shown, 0..truth.srgb8.len()), truth, 0);
        found
    }

    /// Promises broken by colours that differ so between devices and from the exact ones.
    fn broken_of(kernel: Kernel, bit_equal: bool, colors: ColorDifferences) -> Vec<String> {
        let rays = RayDifferences { rays: 1, ..Default::default() };
        let differences = Differences { rays, colors: Some(colors) };
        broken_promises(kernel, bit_equal, Some(&differences), &[("GPU", &differences)])
    }

    fn broken(shown: &RenderedColors, truth: &RenderedColors) -> [Vec<String>; 2] {
        found(shown, truth).map(|colors| broken_of(Kernel::Certified, false, colors))
    }

    #[test]
    fn right_colours_keep_the_promise() {
        let (scene, pixels) = scene();
        for n_samples in [1, 2] {
            let truth = truth(&scene, &pixels, n_samples);
            let shown = painted(&scene, &pixels, n_samples);
            assert_eq!(shown, truth);
            assert_eq!(broken(&shown, &truth), [const { Vec::<String>::new() }; 2]);
            for found in found(&shown, &truth) {
                assert!(found.is_equal() && found.pixels == pixels.len() as u64, "{found:?}");
            }
        }
    }

    /// A light that is computed once, and only on some pixels, has the colours of pictures in each encoding.
    #[test]
    fn shared_light_has_the_colours_of_pictures() {
        let (lit, pixels) = scene();
        let unlit = Scene { lights: Vec::new(), sky: None, ambient: None, ..(*lit).clone() };
        let some: Vec<usize> = (0..pixels.len()).filter(|index| index % 7 < 2).collect();
        let scenes = [lit, Arc::new(unlit)];
        let sample_counts = scenes.iter().flat_map(|scene| [1, 2, 3].map(|n| (scene, n)));
        let cases =
            sample_counts.flat_map(|(scene, n)| Kernel::ALL.map(|kernel| (scene, kernel, n)));
        for (scene, kernel, n_samples) in cases {
            let case = format!("{}, {n_samples}, {}", kernel.name(), scene.is_lit());
            let n_samples = Samples::nearest(n_samples);
            let mut session = Session::new(Arc::clone(scene), Device::Cpu, kernel);
            let control = Control::default();
            let (hits, shown) =
                RenderedColors::kept(&mut session, &pixels, n_samples, &some, &control).unwrap();
            let n_steps = n_steps(&pixels, n_samples, scene.is_lit());
            let is_rendered_each = kernel == Kernel::Certified || !scene.is_lit();
            let n_steps = n_steps * if is_rendered_each { ENCODINGS.len() as u64 } else { 1 };
            assert_eq!(control.rays_done(), n_steps, "{case}");
            for (number, encoding) in ENCODINGS.into_iter().enumerate() {
                let style = Style { n_samples, ..Style::new(encoding) };
                let (kept, _) = session.keep(&pixels, style, WANTS, &control).unwrap();
                assert_eq!(hits, kept.hits, "{case}");
                let mut expected = RenderedColors::default();
                expected.set(kept.colors);
                for &index in &some {
                    let expected = expected.bits(index)[number];
                    assert!(expected.is_some(), "{case}");
                    assert_eq!(
                        shown.bits(index)[number],
                        expected,
                        "{case}, {encoding:?}, {index}"
                    );
                }
            }
        }
    }

    #[test]
    fn sabotage_of_colours_is_noticed() {
        let (scene, pixels) = scene();
        let truth = truth(&scene, &pixels, 1);
        let at = 11 * 36 + 17;
        type Sabotage = (&'static str, [u64; 3], fn(&mut RenderedColors, usize));
        let sabotages: [Sabotage; 7] = [
            ("byte", [1, 0, 0], |shown, i| shown.srgb8[i][2] ^= 1),
            ("16 bits", [0, 1, 0], |shown, i| shown.srgb16[i][0] ^= 1),
            ("float up", [0, 0, 1], |shown, i| shown.linear[i][1] = shown.linear[i][1].next_up()),
            ("float down", [0, 0, 1], |shown, i| {
                shown.linear[i][0] = shown.linear[i][0].next_down();
            }),
            ("not a number", [0, 0, 1], |shown, i| shown.linear[i][1] = f32::NAN),
            ("black", [1, 1, 1], |shown, i| {
                (shown.srgb8[i], shown.srgb16[i], shown.linear[i]) = Default::default();
            }),
            ("lacking", [1, 1, 1], |shown, _| {
                shown.srgb8.pop();
                shown.srgb16.pop();
                shown.linear.pop();
            }),
        ];
        for (what, counts, apply) in sabotages {
            let mut shown = truth.clone();
            apply(&mut shown, at);
            let first = Some(if what == "lacking" { pixels.len() - 1 } else { at });
            for found in found(&shown, &truth) {
                let ColorDifferences { pixels: n, srgb8, srgb16, linear, .. } = found;
                assert_eq!([srgb8, srgb16, linear], counts, "{what}");
                assert_eq!((found.first, n), (first, pixels.len() as u64), "{what}");
            }
            for broken in broken(&shown, &truth) {
                assert_eq!(broken.len(), 2, "{what}: {broken:?}");
            }
        }
        let [found, _] = found(&RenderedColors::default(), &truth);
        assert_eq!(found.srgb8, pixels.len() as u64, "nothing is not equal to something");
    }

    #[test]
    fn sabotage_of_shading_is_noticed() {
        let (scene, pixels) = scene();
        let [mut bright, mut moved] = [(); 2].map(|()| (*scene).clone());
        bright.lights.iter_mut().for_each(|light| light.shadows = false);
        moved.lights[0].source = Source::Point(DVec3::new(3.0, 4.0, 2.0 + 1e-6));
        let sabotages = [
            ("no shadows", painted(&Arc::new(bright), &pixels, 1), 1, 20),
            ("a moved light", painted(&Arc::new(moved), &pixels, 1), 1, 0),
            ("one sample", painted(&scene, &pixels, 1), 2, 20),
        ];
        for (what, shown, n_samples, n_bytes) in sabotages {
            let truth = truth(&scene, &pixels, n_samples);
            let [_, found] = found(&shown, &truth);
            assert!(found.srgb8 >= n_bytes && found.linear > n_bytes, "{what}: {found:?}");
            assert!(broken(&shown, &truth).iter().all(|broken| broken.len() == 2), "{what}");
        }
    }

    #[test]
    fn what_is_not_promised_is_not_broken_and_nothing_is_not_success() {
        let wrong = ColorDifferences { pixels: 9, srgb8: 3, first: Some(1), ..Default::default() };
        let n_broken = |kernel, bit_equal, found: &ColorDifferences| {
            broken_of(kernel, bit_equal, found.clone()).len()
        };
        assert_eq!(n_broken(Kernel::Stable, false, &wrong), 0);
        // Of the same arithmetic, GPU and CPU show the same, right or wrong.
        assert_eq!(n_broken(Kernel::Stable, true, &wrong), 1);
        assert_eq!(n_broken(Kernel::Certified, false, &wrong), 2);
        assert_eq!(n_broken(Kernel::Stable, false, &ColorDifferences::default()), 1);
    }
}
