//! Lit pictures judged pixel by pixel by the oracle of light and colour. What is wrong comes back as
//! text with a case to paste. A test that takes this module takes `light_oracle.rs` as its module
//! `light_oracle`.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::Pixels;
use kugelblitz::scene::{Color, Object, Samples, Scene, Source};
use kugelblitz::shade::{Background, ColorCounts, Colors, Encoding, Painter, Style};
use kugelblitz::trace::{Hits, Kernel, Rays, StageCounts, Wants};
use kugelblitz::tracer::Tracer;

use crate::light_oracle::Oracle;

/// A lit scene and its picture.
#[derive(Clone, Debug)]
pub struct LightCase {
    pub scene: Arc<Scene>,
    pub pixels: Pixels,
    pub n_samples: u32,
    pub background: Background,
    /// Indices of pixels where something is aimed at: these are judged whatever the share of others.
    pub aims: Vec<usize>,
}

/// All numbers of a picture's pixels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Painted {
    pub ids: Vec<u32>,
    pub srgb8: Vec<[u8; 3]>,
    pub srgb16: Vec<[u16; 3]>,
    pub linear: Vec<[f32; 3]>,
    /// Where the background is not shown: samples of each pixel that hit an object.
    pub n_hits: Option<Vec<u16>>,
    pub shadow_rays: StageCounts,
    pub colors: ColorCounts,
}

/// What was judged.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    pub pixels: u64,
    pub samples: u64,
    /// Pixels with an object in the centre, and with light.
    pub hits: u64,
    pub lit: u64,
    /// Pixels that f64 did not decide, and those with an exact number on an edge.
    pub hard: u64,
    pub ties: u64,
    /// All ways from samples to lamps, also those of pixels that were not judged.
    pub shadow_rays: StageCounts,
    /// Colours that a device found, of all pixels.
    pub on_device: u64,
}

impl Tally {
    pub fn add(&mut self, other: Tally) {
        self.pixels += other.pixels;
        self.samples += other.samples;
        self.hits += other.hits;
        self.lit += other.lit;
        self.hard += other.hard;
        self.ties += other.ties;
        self.shadow_rays.add(other.shadow_rays);
        self.on_device += other.on_device;
    }
}

impl LightCase {
    pub fn new(scene: Scene, pixels: Pixels, n_samples: u32) -> LightCase {
        let (scene, background, aims) = (Arc::new(scene), Background::Shown, Vec::new());
        LightCase { scene, pixels, n_samples, background, aims }
    }

    pub fn oracle(&self) -> Oracle {
        let Pixels { view, image_width, image_height, .. } = self.pixels;
        Oracle::with_view(&self.scene, view, image_width, image_height, self.n_samples)
            .before(self.background)
    }

    /// The picture by the certified kernel.
    pub fn paint(&self, device: &Device) -> Painted {
        self.paint_by(Kernel::Certified, 0.0, device)
    }

    /// The picture by any kernel; where it has no proof, shadow rays start at `epsilon`.
    pub fn paint_by(&self, kernel: Kernel, epsilon: f64, device: &Device) -> Painted {
        let (hits, of_pixels, mut tracer) = self.traced(kernel, device);
        let mut of_samples = (self.n_samples > 1).then(|| {
            let prepared = self.prepared(kernel, &self.pixels.samples(self.n_samples));
            let tracer = device.tracer(&prepared, Wants::default()).unwrap().tracer;
            (prepared, tracer)
        });
        let mut painted = Painted { ids: hits.id.clone(), ..Painted::default() };
        for encoding in [Encoding::Srgb8, Encoding::Srgb16, Encoding::Linear] {
            let (prepared, of_samples) = match &mut of_samples {
                Some((prepared, tracer)) => (&*prepared, Some(&mut **tracer)),
                None => (&of_pixels, None),
            };
            let (n_samples, background) = (Samples::nearest(self.n_samples), self.background);
            let style = Style { n_samples, background, epsilon, ..Style::new(encoding) };
            let mut painter = Painter::new(prepared, style, &self.pixels, of_samples);
            let mut colors = Colors::new(encoding);
            let (control, tracer) = (Control::default(), Some(&mut *tracer as &mut dyn Tracer));
            let done = painter.paint_with(tracer, &self.pixels, &hits, &control, &mut colors);
            let done = done.unwrap();
            match colors {
                Colors::Srgb8(colors) => painted.srgb8 = colors,
                Colors::Srgb16(colors) => painted.srgb16 = colors,
                Colors::Linear(colors) => painted.linear = colors,
            }
            painted.n_hits = painter.coverage().map(|coverage| coverage.n_hits.clone());
            painted.shadow_rays.add(done.shadow_rays);
            painted.colors.add(done.colors);
        }
        painted
    }

    fn prepared(&self, kernel: Kernel, pixels: &Pixels) -> Arc<Prepared> {
        let (scene, rays) = (Arc::clone(&self.scene), Rays::Pixels(*pixels));
        Arc::new(Prepared::new(scene, kernel, &rays).unwrap())
    }

    fn traced(&self, kernel: Kernel, device: &Device) -> (Hits, Arc<Prepared>, Box<dyn Tracer>) {
        let prepared = self.prepared(kernel, &self.pixels);
        let mut tracer = device.tracer(&prepared, Wants::default()).unwrap().tracer;
        let mut hits = Hits::default();
        tracer.trace(&Rays::Pixels(self.pixels), &Control::default(), &mut hits).unwrap();
        (hits, prepared, tracer)
    }

    /// The scene as a file, and the pixel.
    pub fn paste(&self, index: usize) -> String {
        let (pixels, n, background) = (&self.pixels, self.n_samples, self.background);
        let scene = scene_text(&self.scene);
        let xy = pixels.xy(index);
        format!(
            "{scene}# pixel {xy:?} of {pixels:?}, {n} x {n} samples, background {background:?}\n"
        )
    }
}

/// Every `step`-th pixel, and those aimed at, must have the oracle's id, bytes and floats.
pub fn judge(case: &LightCase, painted: &Painted, step: usize) -> Result<Tally, String> {
    let n_pixels = case.pixels.len();
    let Painted { ids, srgb8, srgb16, linear, n_hits, shadow_rays, colors } = painted;
    if [ids.len(), srgb8.len(), srgb16.len(), linear.len()] != [n_pixels; 4] {
        return Err(format!("{n_pixels} pixels, but {} and {}", ids.len(), srgb8.len()));
    }
    let oracle = case.oracle();
    let n_samples = u64::from(case.n_samples).pow(2);
    let mut tally =
        Tally { shadow_rays: *shadow_rays, on_device: colors.device, ..Tally::default() };
    let judged: BTreeSet<usize> =
        (0..n_pixels).step_by(step).chain(case.aims.iter().copied()).collect();
    for i in judged {
        let (x, y) = case.pixels.xy(i);
        let truth = oracle.pixel(x, y);
        let say = |what: String| Err(format!("{what}\n{truth:?}\n{}", case.paste(i)));
        if ids[i] != truth.id {
            return say(format!("id {} instead of {}", ids[i], truth.id));
        }
        if srgb8[i] != truth.srgb8() {
            return say(format!("8 bits {:?} instead of {:?}", srgb8[i], truth.srgb8()));
        }
        if srgb16[i] != truth.srgb16() {
            return say(format!("16 bits {:?} instead of {:?}", srgb16[i], truth.srgb16()));
        }
        if linear[i].map(f32::to_bits) != truth.linear().map(f32::to_bits) {
            return say(format!("floats {:?} instead of {:?}", linear[i], truth.linear()));
        }
        if let Some(n_hits) = n_hits.as_ref().map(|n_hits| u32::from(n_hits[i]))
            && n_hits != truth.n_hits
        {
            return say(format!("hits {n_hits} instead of {}", truth.n_hits));
        }
        let is_tie = truth
            .channels
            .iter()
            .any(|channel| channel.srgb8.is_tie || channel.srgb16.is_tie || channel.linear.is_tie);
        let is_lit = truth.channels.iter().any(|channel| channel.mean[1] > 0.0);
        tally.add(Tally {
            pixels: 1,
            samples: n_samples,
            hits: u64::from(truth.id != 0),
            lit: u64::from(truth.id != 0 && is_lit),
            hard: u64::from(truth.bits > 53),
            ties: u64::from(is_tie),
            ..Tally::default()
        });
    }
    Ok(tally)
}

fn numbers(v: impl Into<[f64; 3]>) -> String {
    // Debug prints the shortest text that reads back as the same f64.
    let [x, y, z] = v.into();
    format!("[{x:?}, {y:?}, {z:?}]")
}

/// The scene's objects and lights as a scene file.
pub fn scene_text(scene: &Scene) -> String {
    let color = |Color(color): Color| numbers(color);
    let mut text = format!("background = {}\n", color(scene.background));
    if let Some(ambient) = scene.ambient {
        let _ = writeln!(text, "ambient = {}", color(ambient));
    }
    if let Some(sky) = scene.sky {
        let (intensity, directions) = (sky.intensity, sky.directions);
        let _ = writeln!(text, "[sky]\nintensity = {intensity:?}\ndirections = {directions}");
    }
    for light in &scene.lights {
        let source = match light.source {
            Source::Point(position) => format!("position = {}", numbers(position)),
            Source::Sun(direction) => format!("direction = {}", numbers(direction)),
            Source::Eye => "position = \"eye\"".to_string(),
        };
        let (color, intensity, shadows) = (color(light.color), light.intensity, light.shadows);
        let _ = writeln!(
            text,
            "[[light]]\n{source}\ncolor = {color}\nintensity = {intensity:?}\nshadows = {shadows}"
        );
    }
    for ((_, object), color_of) in scene.objects().zip(scene.colors().skip(1)) {
        let color = color(color_of);
        let _ = match object {
            Object::Sphere(sphere) => {
                let (center, radius) = (numbers(sphere.center), sphere.radius);
                writeln!(
                    text,
                    "[[sphere]]\ncenter = {center}\nradius = {radius:?}\ncolor = {color}"
                )
            }
            Object::Plane(plane) => {
                let (point, normal): (DVec3, DVec3) = (plane.point, plane.normal);
                let (point, normal) = (numbers(point), numbers(normal));
                writeln!(text, "[[plane]]\npoint = {point}\nnormal = {normal}\ncolor = {color}")
            }
        };
    }
    text
}
