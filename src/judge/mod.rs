//! Results of other renderers against exact arithmetic.
//!
//! [`Claims`] are what another renderer says of each ray, read from an [`Image`] by [`Conventions`].
//! [`truth`] finds what is exact: the object by the kernel `certified`, which proves it, and `t` and the
//! normal by exact arithmetic on that object. [`judge`] holds one against the other, and [`Allowed`] says
//! what is still right.

mod allowed;
mod case;
mod claims;
mod conventions;
mod hints;
mod picture;
mod spread;

use glam::DVec3;

pub use allowed::{Allowed, AllowedT, Share};
pub use case::{Case, Finding, PartFound, SpreadFound, check_colors, in_words, object_in_words};
pub use claims::{Claims, Seen};
pub use conventions::{Conventions, NormalSide, NormalSpace, Quantity};
pub use hints::hint;
pub use picture::{FALSE_HIT, FALSE_MISS, WRONG_OBJECT, error_picture};
pub use spread::Spread;

use crate::control::Control;
use crate::error::{Error, Result};
use crate::picture::Image;
use crate::rays::{Pixels, Rays};
use crate::scene::{Color, Scene};
use crate::session::Session;
use crate::trace::{Hits, Kernel, Wants};
use crate::verify::{NormalError, RayError, TError, Truth};

/// Bytes of memory that judging a ray takes: what is exact, what is claimed in the file and by
/// another convention, and the errors.
pub const RAY_BYTES: u64 = 512;

/// The exact results of all rays.
///
/// # Errors
/// Those of [`Session::trace`]; [`Error::Usage`] for a session with another kernel than `certified`.
pub fn truth(session: &mut Session, rays: &Rays, control: &Control) -> Result<Truth> {
    if session.kernel() != Kernel::Certified {
        let message = format!("{} proves nothing; judge by certified", session.kernel().name());
        return Err(Error::Usage(message));
    }
    let mut hits = Hits::default();
    session.trace(rays, Wants::default(), control, &mut hits)?;
    Truth::of_known(session.scene(), rays, &hits.id, control)
}

/// What became of the claims.
#[derive(Clone, Debug)]
pub struct Judgement {
    /// The error of each ray.
    pub errors: Vec<RayError>,
    /// Whether one of a pixel's eight neighbours sees another object, by the exact ids; empty for lists
    /// of rays.
    pub is_at_silhouette: Vec<bool>,
    /// Of rays that are not at silhouettes.
    pub away: Part,
    /// Of those that are.
    pub silhouettes: Part,
}

/// Errors of some of the rays.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
pub struct Part {
    /// How many rays these are.
    pub rays: u64,
    /// Those that are said to hit an object where there is none.
    pub false_hits: u64,
    /// Those that are said to hit nothing where there is an object.
    pub false_misses: u64,
    /// Those that are said to hit another object than the visible one.
    pub wrong_object: u64,
    /// Errors of `t` in f32 steps, where the object is right.
    pub t_ulp: Option<Spread>,
    /// Errors of `t` relative to the exact one.
    pub t_relative: Option<Spread>,
    /// Angles between the normals and the exact ones, degrees.
    pub normal_degrees: Option<Spread>,
}

impl Part {
    /// Rays with a wrong id.
    pub fn wrong_ids(&self) -> u64 {
        self.false_hits + self.false_misses + self.wrong_object
    }

    fn new(errors: &[RayError], is_in: impl Fn(usize) -> bool) -> Part {
        let mut part = Part::default();
        let (mut ulps, mut relative, mut degrees) = (Vec::new(), Vec::new(), Vec::new());
        for (i, error) in errors.iter().enumerate().filter(|(i, _)| is_in(*i)) {
            part.rays += 1;
            match error {
                RayError::FalseHit => part.false_hits += 1,
                RayError::FalseMiss => part.false_misses += 1,
                RayError::WrongObject => part.wrong_object += 1,
                RayError::Right { t, normal, .. } => {
                    ulps.extend(t.map(|t| (t.ulp, i)));
                    relative.extend(t.map(|t| (t.relative, i)));
                    degrees.extend(normal.map(|normal| (normal.degrees, i)));
                }
            }
        }
        part.t_ulp = Spread::new(ulps);
        part.t_relative = Spread::new(relative);
        part.normal_degrees = Spread::new(degrees);
        part
    }
}

/// Whether one of a pixel's eight neighbours sees another object.
fn silhouettes(pixels: &Pixels, id: &[u32]) -> Vec<bool> {
    let (width, height) = (pixels.width as usize, pixels.height as usize);
    let at = |i: usize| {
        let (x, y) = (i % width, i / width);
        let rows = y.saturating_sub(1)..=(y + 1).min(height - 1);
        let columns = x.saturating_sub(1)..=(x + 1).min(width - 1);
        rows.flat_map(|y| columns.clone().map(move |x| y * width + x)).any(|j| id[j] != id[i])
    };
    (0..id.len()).map(at).collect()
}

/// Holds claims against the truth about the same rays.
///
/// # Errors
/// [`Error::Usage`] for claims about another number of rays.
pub fn judge(scene: &Scene, rays: &Rays, truth: &Truth, claims: &Claims) -> Result<Judgement> {
    let n = rays.len();
    if claims.len() != n || truth.id.len() != n {
        return Err(Error::Usage(format!(
            "{} results are to be judged by {} exact ones, for {n} rays",
            claims.len(),
            truth.id.len()
        )));
    }
    let palette: Vec<[u8; 3]> = match claims.seen {
        Seen::Colors { .. } => scene.colors().map(Color::to_srgb8).collect(),
        Seen::Ids(_) | Seen::Hit(_) => Vec::new(),
    };
    let errors: Vec<RayError> = (0..n)
        .map(|i| {
            let id = truth.id[i];
            wrong_id(&claims.seen, &palette, i, id).unwrap_or_else(|| RayError::Right {
                id,
                t: t_error(rays, truth, claims, i).filter(|_| id != 0),
                normal: normal_error(truth, claims, i).filter(|_| id != 0),
            })
        })
        .collect();
    let is_at_silhouette = match rays {
        Rays::Pixels(pixels) => silhouettes(pixels, &truth.id),
        Rays::List(_) => Vec::new(),
    };
    let is_at = |i: usize| is_at_silhouette.get(i).copied().unwrap_or(false);
    let away = Part::new(&errors, |i| !is_at(i));
    let of_silhouettes = Part::new(&errors, is_at);
    Ok(Judgement { errors, is_at_silhouette, away, silhouettes: of_silhouettes })
}

/// What is wrong with what a ray is said to see, if anything is.
fn wrong_id(seen: &Seen, palette: &[[u8; 3]], i: usize, id: u32) -> Option<RayError> {
    let (is_right, is_hit) = match seen {
        Seen::Ids(ids) => (ids[i] == id, ids[i] != 0),
        Seen::Hit(hit) => (hit[i] == (id != 0), hit[i]),
        Seen::Colors { srgb8, tolerance } => {
            let has = |id: u32| {
                let pairs = palette[id as usize].into_iter().zip(srgb8[i]);
                pairs.into_iter().all(|(a, b)| a.abs_diff(b) <= *tolerance)
            };
            (has(id), !has(0))
        }
    };
    match (is_right, is_hit, id) {
        (true, ..) => None,
        (false, false, _) => Some(RayError::FalseMiss),
        (false, true, 0) => Some(RayError::FalseHit),
        (false, true, _) => Some(RayError::WrongObject),
    }
}

fn t_error(rays: &Rays, truth: &Truth, claims: &Claims, i: usize) -> Option<TError> {
    let claimed = claims.t.as_ref()?[i];
    let length = || match rays {
        Rays::Pixels(pixels) => {
            let (x, y) = pixels.xy(i);
            pixels.direction(x, y).length()
        }
        Rays::List(rays) => rays[i].direction.length(),
    };
    let exact = if claims.is_distance { truth.t[i] * length() } else { truth.t[i] };
    Some(TError::of(claimed, exact))
}

fn normal_error(truth: &Truth, claims: &Claims, i: usize) -> Option<NormalError> {
    let claimed = claims.normal.as_ref()?[i];
    let exact = DVec3::from(truth.normal[i]);
    let facing = NormalError::of(claimed, exact);
    let turned = || NormalError::of(claimed, -exact);
    Some(match claims.side {
        NormalSide::Facing => facing,
        NormalSide::Outward if truth.is_back[i] => turned(),
        NormalSide::Outward => facing,
        NormalSide::Either => {
            let turned = turned();
            if turned.degrees < facing.degrees { turned } else { facing }
        }
    })
}

/// Colours that one is compared with, the next ones by their red.
const N_NEXT_COLORS: usize = 256;

/// Objects whose colours are so near each other that claims in colours don't tell them apart: how many were
/// found, and one pair. Each is compared with the next ones by their red alone.
pub fn alike(scene: &Scene, tolerance: u8) -> Option<(usize, [u32; 2])> {
    let mut colors: Vec<([u8; 3], u32)> = scene.colors().map(Color::to_srgb8).zip(0..).collect();
    colors.sort_unstable();
    let (mut n_alike, mut pair) = (0, None);
    for (i, &(color, id)) in colors.iter().enumerate() {
        let within = |a: u8, b: u8| a.abs_diff(b) <= tolerance.saturating_mul(2);
        let next = colors[i + 1..].iter().take_while(|(other, _)| within(other[0], color[0]));
        let next = next.take(N_NEXT_COLORS);
        let mut alike = next.filter(|(other, _)| (1..3).all(|c| within(other[c], color[c])));
        if let Some(&(_, other)) = alike.next() {
            n_alike += 1;
            pair.get_or_insert([id.min(other), id.max(other)]);
        }
    }
    Some((n_alike, pair?))
}

/// The indices of the worst rays of each kind, at most `n` of each: wrong ids away from silhouettes, wrong ids
/// at them, evenly drawn; the largest errors of `t` and those of the normals, the worst first.
pub fn worst(judgement: &Judgement, n: usize) -> [Vec<usize>; 4] {
    let errors = &judgement.errors;
    let is_at = |i: usize| judgement.is_at_silhouette.get(i).copied().unwrap_or(false);
    let wrong = |at: bool| {
        let wrong = errors.iter().enumerate();
        let wrong = wrong.filter(|(_, error)| !matches!(error, RayError::Right { .. }));
        let wrong: Vec<usize> = wrong.map(|(i, _)| i).filter(|&i| is_at(i) == at).collect();
        let n = n.min(wrong.len());
        (0..n).map(|k| wrong[k * wrong.len() / n]).collect()
    };
    let largest = |of: fn(&RayError) -> Option<f64>| {
        let all = errors.iter().enumerate();
        let all =
            all.filter_map(|(i, error)| Some((of(error)?, i)).filter(|(size, _)| *size > 0.0));
        let mut all: Vec<(f64, usize)> = all.collect();
        let by_size = |a: &(f64, usize), b: &(f64, usize)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
        if all.len() > n && n > 0 {
            all.select_nth_unstable_by(n - 1, by_size);
        }
        all.truncate(n);
        all.sort_unstable_by(by_size);
        all.into_iter().map(|(_, i)| i).collect()
    };
    let t = |error: &RayError| match error {
        RayError::Right { t, .. } => t.map(|t| t.ulp),
        _ => None,
    };
    let normal = |error: &RayError| match error {
        RayError::Right { normal, .. } => normal.map(|normal| normal.degrees),
        _ => None,
    };
    [wrong(false), wrong(true), largest(t), largest(normal)]
}

/// The pixels that a picture shows, of a camera's picture of that size: a part where the file says so.
///
/// # Errors
/// [`Error::Usage`] where the picture doesn't lie within the whole one.
pub fn pixels_of(image: &Image, whole: Pixels) -> Result<Pixels> {
    let narrow = |n: i64| u32::try_from(n).ok();
    let part = || {
        let [x, y] = image.first.map(narrow);
        let (width, height) = (narrow(image.width as i64)?, narrow(image.height as i64)?);
        let pixels = Pixels { x: x?, y: y?, width, height, ..whole };
        pixels.is_in_picture().then_some(pixels)
    };
    part().ok_or_else(|| {
        let [x, y] = image.first;
        Error::Usage(format!(
            "{}×{} pixels at {x},{y} don't lie in a picture of {}×{}; say which part they are with \
             --size and --crop",
            image.width, image.height, whole.image_width, whole.image_height
        ))
    })
}
