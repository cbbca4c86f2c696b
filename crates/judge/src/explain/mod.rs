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
    ChannelByte, ColorExplanation, LightExplanation, LightVerdict, MeanExplanation, Shading,
    SkyExplanation,
};
pub use numbers::{Approximation, Exact, FormulaNumber, six_digits};
pub use words::{Lang, Remark};

use kugelblitz::Result;
use kugelblitz::control::Control;
use kugelblitz::device::Device;
use kugelblitz::exact::{Root, Side, nearest};
use kugelblitz::memory;
use kugelblitz::parallel;
use kugelblitz::plain::steers;
use kugelblitz::prepare::Prepared;
use kugelblitz::rays::Pixels;
use kugelblitz::scene::Scene;
use kugelblitz::trace::{Hits, Kernel, Level, Rays, Wants};

use crate::compare::Precision;
use crate::wrong_usage;
use calculator::Calculator as _;
use numbers::error_ulp;
use ray::RayNumbers;
use words::Words;

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
    /// The pixel, where the ray belongs to one.
    pub pixel: Option<PixelOf>,
    /// Camera's part of the ray, and the formulas from the pixel to the ray; `None` for a ray that belongs to no pixel.
    pub camera: Option<CameraExplanation>,
    /// `o` and `d`, six numbers. `stable` takes the origin in f64 or in two parts, so it has no
    /// number for `o`.
    #[serde(serialize_with = "quantities_alone")]
    pub ray: Derivation,
    /// The objects: those that the ray hits, the nearest first, then those that it misses, the
    /// ones that it passes nearest first.
    pub objects: Vec<ObjectExplanation>,
    /// Objects of the whole scene.
    pub n_objects: usize,
    /// Counts of the objects that are not among [`Explanation::objects`].
    pub left_out: LeftOut,
    /// The object that the ray sees, exactly; `None` for the background.
    pub winner: Option<Winner>,
    /// The point where the ray meets it: the coordinates, `f(p)`, which is 0, and the unit normal that
    /// faces the ray; `None` for the background. `stable` has its points relative to the camera, so it has
    /// no number for `p`. The column of f64 is the kernel `double`, here and for all that follows.
    pub point: Option<Derivation>,
    /// The light on what the ray sees, and its colour; `None` for a scene without light and pixels of
    /// one sample.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shading: Option<Shading>,
    /// The level at which the kernel `certified` decided the ray.
    pub level: &'static str,
    /// The results of each kernel, on the CPU and then on the device, where there is one.
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
    /// Width of the whole picture.
    pub width: u32,
    /// Height of the whole picture.
    pub height: u32,
}

/// One object as the ray meets it.
#[derive(Clone, Debug, Serialize)]
pub struct ObjectExplanation {
    /// Object id.
    pub id: u32,
    /// `sphere 3 (red giant)`, without anything that would steer a terminal.
    pub label: String,
    /// `sphere` or `plane`.
    pub shape: &'static str,
    /// The lecture's formulas with the exact numbers put in.
    pub formulas: Vec<String>,
    /// The numbers of the formula in each arithmetic.
    #[serde(flatten)]
    pub derivation: Derivation,
    /// Why the object won or lost, exactly.
    pub reason: Reason,
    /// The reason in words, and what else is worth a remark.
    pub why: Vec<Remark>,
    /// How far from the object the ray passes, world units, where it misses.
    pub gap: Option<f64>,
}

/// Why an object is seen, or isn't.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum Reason {
    /// The nearest positive `t`.
    Visible,
    /// There is a nearer one.
    Farther {
        /// Id of the visible object.
        than: u32,
    },
    /// Another object has the same `t` and a lower id.
    TieLost {
        /// Id of that object.
        to: u32,
    },
    /// `D < 0`.
    Missed,
    /// No root is positive.
    Behind,
    /// `d·n = 0`.
    Parallel,
    /// `t` is larger than f32 can tell.
    TooFar,
    /// The equation has no solution to speak of: the ray's direction is zero. (No command takes
    /// such a ray.)
    Degenerate,
}

/// How many objects are not explained, by what they are to the ray.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Hit by it, but not first.
    pub hit: usize,
    /// Behind its origin, or at it.
    pub behind: usize,
    /// Missed by the whole line.
    pub missed: usize,
}

/// The object that a ray sees, exactly.
#[derive(Clone, Debug, Serialize)]
pub struct Winner {
    /// Object id.
    pub id: u32,
    /// The object's name, as [`ObjectExplanation::label`].
    pub label: String,
    /// `t`, to 20 digits.
    pub t: String,
    /// `t`, correctly rounded.
    pub t_f32: f32,
    /// Unit normal that faces the ray, to 20 digits.
    pub normal: [String; 3],
    /// `front` or `back`.
    pub side: &'static str,
    #[serde(skip)]
    root: Root,
}

/// The result of a kernel on one device.
#[derive(Clone, Debug, Serialize)]
pub struct KernelResult {
    /// The kernel's name.
    pub kernel: &'static str,
    /// `cpu` or `gpu`.
    pub device: &'static str,
    /// Object id; 0 is the background.
    pub id: u32,
    /// The object's name, as [`ObjectExplanation::label`], or `background`.
    pub label: String,
    /// Ray parameter; +∞ on the background.
    pub t: f32,
    /// Unit normal; zero on the background.
    pub normal: [f32; 3],
    /// True where the id is the exact one.
    pub right: bool,
    /// Error of `t` in f32 steps, where the right object is hit.
    pub t_error_ulp: Option<f64>,
}

/// Upper bound of the memory for the explanation of an object and for its text, bytes. Measured: 19 KiB with 40 digits.
const SHOWN_BYTES: u64 = 24 << 10;

/// Explains one ray in a style.
///
/// # Errors
/// [`kugelblitz::Error::Usage`] where `rays` is not one ray, or for digits that can't be;
/// [`kugelblitz::Error::TooLarge`] where there is not the memory to explain so many objects.
pub fn explain(scene: &Arc<Scene>, rays: &Rays, style: &ExplainStyle) -> Result<Explanation> {
    let &ExplainStyle { limit, lang, digits } = style;
    if !(1..=MAX_DIGITS).contains(&digits) {
        return wrong_usage(format!("{digits} digits: a result has from 1 to {MAX_DIGITS}"));
    }
    let mut numbers = RayNumbers::new(scene, rays, style)?;
    let n_objects = scene.n_objects();
    let limit = limit.unwrap_or(MOST_OBJECTS).clamp(1, MOST_OBJECTS);
    let n_shown = limit.min(n_objects);
    // The ranks are put together from parts; every object may be hit.
    let ranking = n_objects * (2 * size_of::<Rank>() + size_of::<Root>());
    memory::require(
        format!("explaining {n_shown} of {n_objects} objects"),
        ranking as u64 + n_shown as u64 * SHOWN_BYTES,
        "free some, explain fewer objects, or split the scene",
    )?;
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
        let wants = Wants { surface: true, level: device == Device::Cpu.kind() };
        let mut hits = Hits::default();
        on.tracer(&prepared, wants)?.tracer.trace(rays, &Control::default(), &mut hits)?;
        if let (Kernel::Certified, Some(&level)) = (kernel, hits.level.first()) {
            self.level = ["f32", "f64", "exact"][usize::from(level).min(Level::Exact as usize)];
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
fn label_in(words: &Words, scene: &Scene, id: u32) -> String {
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
    root: Option<Box<Root>>,
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
        let key = root.as_ref().map_or_else(|| numbers.gap(object).0, Root::to_f64);
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
