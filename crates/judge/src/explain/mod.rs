//! One ray in numbers: the lecture's formulas at work, and what f32 makes of them.
//!
//! [`explain`] computes an [`Explanation`] and prints nothing; [`text`] and [`latex`] write it
//! down. Every f32 number comes from the functions that the kernels themselves are made of, so it
//! is what the kernel worked with, bit by bit; every error is that number less the exact one.

mod calculator;
mod camera;
mod derivation;
mod expression;
pub mod latex;
mod light;
mod line;
pub(crate) mod numbers;
mod ray;
mod reason;
mod section;
mod shading;
pub(crate) mod step;
pub mod text;
mod words;

use std::sync::Arc;

use serde::{Serialize, Serializer};

pub use camera::CameraExplanation;
pub use derivation::Derivation;
pub use light::{
    ChannelByte, ColorExplanation, LightExplanation, LightVerdict, MeanExplanation,
    ShadingExplanation, SkyExplanation,
};
pub use numbers::{Approximation, Exact, FormulaNumber, six_digits};
pub use words::{Lang, Remark};

use kugelblitz::Control;
use kugelblitz::Result;
use kugelblitz::device::Device;
use kugelblitz::exact::{QuadraticSurd, Side, nearest};
use kugelblitz::plain::steers;
use kugelblitz::prepare::Prepared;
use kugelblitz::query::{Hits, Kernel, Outputs, Rays, Stage};
use kugelblitz::rays::Pixels;
use kugelblitz::scene::Scene;
use kugelblitz::support::parallel;

use crate::compare::Precision;
use crate::wrong_usage;
use calculator::Calculator as _;
use numbers::error_ulp;
use ray::RayNumbers;
use words::ExplanationWords;

/// How many objects are explained where nobody asks for more.
pub const DEFAULT_OBJECTS: usize = 20;

/// How many are explained at most. The others are counted: nobody reads more, and an explanation takes half a
/// millisecond.
pub const MOST_OBJECTS: usize = 1000;

/// Digits of a number in a formula where nobody asks for more.
pub const DEFAULT_DIGITS: usize = 6;

/// Most digits that results in formulas can have; on the way to them there may be more.
pub const MAX_DIGITS: usize = 40;

/// How a ray is explained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ExplainStyle {
    /// The objects that are explained at most, from 1 to [`MOST_OBJECTS`]; `None` for those.
    pub limit: Option<usize>,
    /// The language of all words.
    pub lang: Lang,
    /// Digits of the results in formulas, from 1 to [`MAX_DIGITS`].
    pub digits: usize,
}

impl Default for ExplainStyle {
    fn default() -> ExplainStyle {
        ExplainStyle { limit: Some(DEFAULT_OBJECTS), lang: Lang::English, digits: DEFAULT_DIGITS }
    }
}

/// Longest name of an object that is told whole.
const NAME_CHARS: usize = 30;

/// One ray and what it meets.
#[derive(Clone, Debug, Serialize)]
pub struct Explanation {
    /// The language of all words.
    #[serde(skip)]
    pub lang: Lang,
    /// Digits of the results in formulas.
    #[serde(skip)]
    pub digits: usize,
    /// The pixel; `null` for a ray that belongs to no pixel.
    pub pixel: Option<PixelOf>,
    /// The camera's part of the ray, and the formulas from the pixel to the ray; `null` for a ray that belongs to no pixel.
    /// Unstable in JSON.
    pub camera: Option<CameraExplanation>,
    /// Origin `o` and direction `d`, six numbers. Unstable in JSON.
    ///
    /// `stable` takes the origin in f64 or in two parts, so it has no number for `o`.
    #[serde(serialize_with = "quantities_alone")]
    pub ray: Derivation,
    /// Objects that the ray hits, the nearest first, then objects that the ray misses, the nearest to the ray first.
    pub objects: Vec<ObjectExplanation>,
    /// Number of objects of the scene.
    pub n_objects: usize,
    /// Number of the objects that are missing in `objects`.
    pub left_out: LeftOut,
    /// Visible object, by exact arithmetic; `null` for the background.
    pub winner: Option<Winner>,
    /// Point where the ray hits the visible object: its coordinates `p`, `f(p)`, which is 0, and the unit normal that faces the
    /// ray; `null` for the background. Unstable in JSON.
    ///
    /// `stable` has points relative to the camera, so it has no number for `p`. The column of f64 is the kernel `double`, here
    /// and in all parts that follow.
    pub point: Option<Derivation>,
    /// Light on the visible object, and its colour; absent for a scene without light with one sample per pixel. Unstable in JSON.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shading: Option<ShadingExplanation>,
    /// Stage that decided the ray with the kernel `certified`: `f32`, `f64` or `exact`.
    pub level: &'static str,
    /// Results of each kernel, on the CPU and then on the device.
    pub seen: Vec<KernelResult>,
}

fn quantities_alone<S: Serializer>(
    ray: &Derivation,
    serializer: S,
) -> std::result::Result<S::Ok, S::Error> {
    ray.quantities.serialize(serializer)
}

/// A pixel of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct PixelOf {
    /// Column.
    pub x: u32,
    /// Row.
    pub y: u32,
    /// Width of the whole picture, pixels.
    pub width: u32,
    /// Height of the whole picture, pixels.
    pub height: u32,
}

/// An object and its intersection with the ray.
#[derive(Clone, Debug, Serialize)]
pub struct ObjectExplanation {
    /// Id of the object.
    pub id: u32,
    /// Shape, id and name: `sphere 3 (red giant)`, without control characters. Unstable in JSON.
    pub label: String,
    /// `sphere` or `plane`. Unstable in JSON.
    pub shape: &'static str,
    /// The lecture's formulas with the exact numbers put in. Unstable in JSON.
    pub formulas: Vec<String>,
    /// The numbers of the formula in each arithmetic.
    #[serde(flatten)]
    pub derivation: Derivation,
    /// Reason why the object is visible or not, by exact arithmetic.
    pub reason: Reason,
    /// The reason in words, and remarks. Unstable in JSON.
    pub why: Vec<Remark>,
    /// Distance between the ray and the object, world units; `null` if the ray hits it. Unstable in JSON.
    pub gap: Option<f64>,
}

/// Reason why an object is visible or not.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum Reason {
    /// The object has the smallest positive `t`.
    Visible,
    /// Another object is nearer.
    Farther {
        /// Id of the visible object.
        than: u32,
    },
    /// Another object has the same `t` and a lower id.
    TieLost {
        /// Id of the other object.
        to: u32,
    },
    /// The line of the ray misses the object, `D < 0`.
    Missed,
    /// No root is positive.
    Behind,
    /// The ray is parallel to the plane, `d·n = 0`.
    Parallel,
    /// `t` is too large for f32.
    TooFar,
    /// The direction of the ray is zero.
    ///
    /// No command accepts such a ray.
    Degenerate,
}

/// Number of objects that are not explained.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Objects that the ray hits, but not first.
    pub hit: usize,
    /// Objects behind the origin of the ray, or at it.
    pub behind: usize,
    /// Objects that the whole line misses.
    pub missed: usize,
}

/// The visible object of a ray, by exact arithmetic.
#[derive(Clone, Debug, Serialize)]
pub struct Winner {
    /// Id of the object.
    pub id: u32,
    /// Shape, id and name, as in `objects`. Unstable in JSON.
    pub label: String,
    /// Ray parameter `t` to 20 digits.
    pub t: String,
    /// `t`, rounded to the nearest f32.
    pub t_f32: f32,
    /// Unit normal that faces the ray, to 20 digits.
    pub normal: [String; 3],
    /// `front` or `back`.
    pub side: &'static str,
    #[serde(skip)]
    root: QuadraticSurd,
}

/// The result of a kernel on one device.
#[derive(Clone, Debug, Serialize)]
pub struct KernelResult {
    /// Name of the kernel.
    pub kernel: &'static str,
    /// `gpu` or `cpu`.
    pub device: &'static str,
    /// Id of the object; 0 for the background.
    pub id: u32,
    /// Shape, id and name, as in `objects`, or `background`. Unstable in JSON.
    pub label: String,
    /// Ray parameter; +∞ on the background, which is `null` in JSON.
    pub t: f32,
    /// Unit normal; zero on the background.
    pub normal: [f32; 3],
    /// Whether the id is the exact one.
    pub right: bool,
    /// Error of `t` in f32 steps; `null` if it is infinite, or if the id is wrong.
    pub t_error_ulp: Option<f64>,
}

/// Explains one ray in a style.
///
/// # Errors
/// Returns [`kugelblitz::Error::Usage`] if `rays` is not one ray, or the number of digits is out of range.
pub fn explain(scene: &Arc<Scene>, rays: &Rays, style: &ExplainStyle) -> Result<Explanation> {
    let &ExplainStyle { limit, lang, digits } = style;
    if !(1..=MAX_DIGITS).contains(&digits) {
        return wrong_usage(format!("{digits} digits: a result has from 1 to {MAX_DIGITS}"));
    }
    let mut numbers = RayNumbers::new(scene, rays, style)?;
    let n_objects = scene.n_objects();
    let limit = limit.unwrap_or(MOST_OBJECTS).clamp(1, MOST_OBJECTS);
    let (ranked, left_out) = ranked(&numbers, limit);
    let first = ranked.first().filter(|rank| rank.root.is_some()).map(|rank| rank.id);
    numbers.hit = nearest(&numbers.exact, first.and_then(|id| Some((id, scene.object(id)?))));
    let objects = parallel::map(&ranked, |rank| numbers.object(rank));
    let objects = objects.into_iter().flatten().collect();

    let pixel =
        |p: &Pixels| PixelOf { x: p.x, y: p.y, width: p.image_width, height: p.image_height };
    let (of_point, point) = numbers.point().unzip();
    let (ray, camera) = numbers.ray();
    let mut explanation = Explanation {
        lang,
        digits,
        pixel: rays.pixels().map(pixel),
        camera,
        ray,
        objects,
        n_objects,
        left_out,
        winner: winner(&numbers),
        point: of_point,
        shading: numbers.shading(point.as_ref()),
        level: "f32",
        seen: Vec::new(),
    };
    for kernel in Kernel::ALL {
        explanation.add(scene, rays, kernel, &Device::Cpu)?;
    }
    Ok(explanation)
}

impl Explanation {
    /// Adds what a device sees, kernel by kernel; `device_of` gives the CPU for a kernel that the device can't run, of
    /// which there is no more to be said.
    ///
    /// # Errors
    /// Those of the tracers.
    pub fn add_device<'d>(
        &mut self,
        scene: &Arc<Scene>,
        rays: &Rays,
        device_of: impl Fn(Kernel) -> &'d Device,
    ) -> Result<()> {
        for kernel in Kernel::ALL {
            let device = device_of(kernel);
            if device.kind() != Device::Cpu.kind() {
                self.add(scene, rays, kernel, device)?;
            }
        }
        Ok(())
    }

    /// Adds what the CPU or another device sees, and the CPU's level.
    fn add(&mut self, scene: &Arc<Scene>, rays: &Rays, kernel: Kernel, on: &Device) -> Result<()> {
        let prepared = Arc::new(Prepared::new(Arc::clone(scene), kernel, rays)?);
        let device = on.kind();
        let wants = Outputs { surface: true, level: device == Device::Cpu.kind() };
        let mut hits = Hits::default();
        on.tracer(&prepared, wants)?.tracer.trace(rays, &Control::default(), &mut hits)?;
        if let (Kernel::Certified, Some(&level)) = (kernel, hits.level.first()) {
            self.level = ["f32", "f64", "exact"][usize::from(level).min(Stage::Exact as usize)];
        }
        let (id, t) = (hits.id[0], hits.t[0]);
        let right = id == self.winner.as_ref().map_or(0, |winner| winner.id);
        let exact = self.winner.as_ref().filter(|_| right).map(|winner| &winner.root);
        self.seen.push(KernelResult {
            kernel: kernel.name(),
            device,
            id,
            label: label_in(self.lang.words(), scene, id),
            t,
            normal: hits.normal[0],
            right,
            t_error_ulp: exact.map(|exact| error_ulp(t.into(), exact, Precision::Single)),
        });
        Ok(())
    }
}

/// The name of the object that has this id: `sphere 3 (red giant)`.
pub fn label(scene: &Scene, id: u32) -> String {
    label_in(Lang::English.words(), scene, id)
}

/// `sphere 3 (red giant)`, in the language of the words.
fn label_in(words: &ExplanationWords, scene: &Scene, id: u32) -> String {
    let Some(object) = scene.object(id) else { return words.background.into() };
    let kind = words.shape(object);
    let Some(name) = scene.name(id) else { return format!("{kind} {id}") };
    format!("{kind} {id} ({})", shortened(name, NAME_CHARS))
}

/// At most so many characters of a text, without those that steer a terminal.
fn shortened(text: &str, n_chars: usize) -> String {
    let is_plain = |c: &char| !c.is_control() && !steers(*c);
    let mut shown: String = text.chars().filter(is_plain).take(n_chars).collect();
    if text.chars().count() > n_chars {
        shown.pop();
        shown.push('…');
    }
    shown
}

fn winner(numbers: &RayNumbers) -> Option<Winner> {
    let hit = numbers.hit.as_ref()?;
    let normal = hit.normal(&numbers.exact)?;
    Some(Winner {
        id: hit.id,
        label: numbers.label(hit.id),
        t: hit.root.to_decimal(numbers::DIGITS),
        t_f32: hit.t_f32(),
        normal: normal.map(|component| component.to_decimal(numbers::DIGITS)),
        side: match hit.side {
            Side::Front => "front",
            Side::Back => "back",
        },
        root: hit.root.clone(),
    })
}

/// An object's place in the list.
struct Rank {
    id: u32,
    root: Option<Box<QuadraticSurd>>,
    /// `t` rounded, or the distance by which the ray passes.
    key: f64,
}

/// The objects in the order of [`Explanation::objects`], the first `limit` of them, and what the others are.
fn ranked(numbers: &RayNumbers, limit: usize) -> (Vec<Rank>, LeftOut) {
    let scene = numbers.scene;
    let rank = |index: usize| {
        let id = index as u32 + 1;
        let object = scene.object(id)?;
        let root = numbers.root(id);
        let key = root.as_ref().map_or_else(|| numbers.gap(object).0, QuadraticSurd::to_f64);
        Some(Rank { id, root: root.map(Box::new), key })
    };
    let mut ranks = parallel::filter_map(scene.n_objects(), rank);
    let order = |a: &Rank, b: &Rank| {
        // Rounding keeps the order, so only equal f64 need the exact comparison, and none of equal objects.
        let exact = || match (&a.root, &b.root) {
            (Some(x), Some(y)) if scene.object(a.id) != scene.object(b.id) => x.cmp(y),
            _ => std::cmp::Ordering::Equal,
        };
        (a.root.is_none().cmp(&b.root.is_none()))
            .then(a.key.total_cmp(&b.key))
            .then_with(exact)
            .then(a.id.cmp(&b.id))
    };
    ranks.sort_unstable_by(order);
    let others = ranks.split_off(limit.min(ranks.len()));
    (ranks, left_out(numbers, &others))
}

fn left_out(numbers: &RayNumbers, ranks: &[Rank]) -> LeftOut {
    let hit = ranks.iter().filter(|rank| rank.root.is_some()).count();
    let is_behind = |rank: &Rank| rank.root.is_none() && numbers.line_meets(rank.id) == Some(true);
    let behind = parallel::filter_map(ranks.len(), |at| is_behind(&ranks[at]).then_some(()));
    let behind = behind.len();
    LeftOut { hit, behind, missed: ranks.len() - hit - behind }
}
