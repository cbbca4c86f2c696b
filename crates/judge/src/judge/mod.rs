//! Results of other renderers against exact arithmetic.
//!
//! A [`Case`] is what another renderer says of the rays of a scene: an [`Image`], read by [`Conventions`] as [`Claims`].
//! [`Case::judge`] finds what is exact: the object by the kernel `certified`, which proves it, and `t` and the
//! normal by exact arithmetic on that object. [`Judged`] is one held against the other by what is [`Allowed`].

mod claims;
mod conventions;
mod hints;
mod words;

use std::sync::Arc;

use serde::Serialize;

pub use claims::{ClaimedHit, Claims};
pub use conventions::{Conventions, NormalSide, NormalSpace, Quantity};
pub use words::Finding;

pub use crate::compare::Allowed;
use kugelblitz::control::Control;
use kugelblitz::error::Setting;
use kugelblitz::memory;
use kugelblitz::picture::Image;
use kugelblitz::rays::{Pixels, Rays};
use kugelblitz::scene::{Color, Scene};
use kugelblitz::trace::{Hits, Kernel, Wants};
use kugelblitz::{Error, Result, Session};

use crate::compare::{
    ErrorStats, RayError, RayResult, TError, Tolerance, Unit, error_picture, short,
};
use crate::cost::ObjectCounts;
use crate::verify::{Near, TrueHit, Truth};
use crate::wrong_usage;

/// Bytes of memory that judging a ray takes: what is exact, what is claimed in the file and by
/// another convention, and the errors.
const RAY_BYTES: u64 = 512;

/// What is judged: another renderer's results, and what they are of.
pub struct Case {
    /// The scene.
    pub scene: Arc<Scene>,
    /// The rays.
    pub rays: Rays,
    /// The results as they were given.
    pub image: Image,
    /// The results in this program's conventions.
    pub claims: Claims,
    /// What may be wrong.
    pub allowed: Allowed,
}

impl Case {
    /// The case of these results.
    ///
    /// # Errors
    /// [`Error::Usage`] for another number of results than rays, where the results lack what is judged, and for colours
    /// where light changes them; [`Error::TooLarge`] where judging doesn't fit the memory.
    pub fn new(
        scene: Arc<Scene>,
        rays: Rays,
        image: Image,
        conventions: Conventions,
        allowed: Allowed,
    ) -> Result<Case> {
        let n = rays.len();
        if image.len() != n {
            return wrong_usage(format!(
                "there are {} results for {n} rays; give one for each",
                image.len()
            ));
        }
        let (what, bytes) = (format!("judging {n} rays"), (n as u64).saturating_mul(RAY_BYTES));
        memory::require(what, bytes, "judge a part of the picture (crop)")?;
        let claims = Claims::new(image.clone(), &conventions, &rays)?;
        if scene.is_lit() && claims.is_by_color() {
            return wrong_usage(
                "the scene is lit, so that colours don't tell its objects; judge ids, depths or normals, or \
                 compare the picture with an exact one: `kugelblitz render` and `kugelblitz compare`",
            );
        }
        Ok(Case { scene, rays, image, claims, allowed })
    }

    /// Holds the results against what `session` proves.
    ///
    /// # Errors
    /// Those of [`Session::trace`]; [`Error::Usage`] for a session with another kernel than `certified`.
    pub fn judge(self, session: &mut Session, control: &Control) -> Result<Judged> {
        if session.kernel() != Kernel::Certified {
            let name = session.kernel().name();
            return wrong_usage(format!("{name} proves nothing; judge by certified"));
        }
        let mut hits = Hits::default();
        session.trace(&self.rays, Wants::default(), control, &mut hits)?;
        let truth = Truth::of_known(session.scene(), &self.rays, &hits.id, control)?;
        let errors = self.errors(&self.claims, &truth);
        let mut judged = Judged { case: self, truth, errors, broken: Vec::new(), hint: Vec::new() };
        judged.broken = judged.broken();
        if !judged.broken.is_empty() {
            judged.hint = hints::hint(&judged);
        }
        Ok(judged)
    }

    /// The errors of claims about these rays.
    fn errors(&self, claims: &Claims, truth: &Truth) -> CaseErrors {
        let palette: Vec<[u8; 3]> = self.scene.colors().map(Color::to_srgb8).collect();
        let error = |(i, exact): (usize, &TrueHit)| {
            let mut right = RayResult::from(exact);
            if claims.has(Quantity::Distance) {
                right.t = right.t.map(|t| t * Near::new(&self.rays, i).ray.direction.length());
            }
            let said = claims.row(i, &right, exact.is_back, &palette);
            RayError::of(Some(said), &right, |normal| normal == exact.normal_f32)
        };
        let errors: Vec<RayError> = truth.hits.iter().enumerate().map(error).collect();
        let is_at_silhouette = match &self.rays {
            Rays::Pixels(pixels) => silhouettes(pixels, &truth.hits),
            Rays::List(_) => vec![false; errors.len()],
        };
        let class = |at| ErrorStats::new(&self.rays, &errors, |i| is_at_silhouette[i] == at);
        let classes = [false, true].map(class);
        CaseErrors { of_rays: errors, is_at_silhouette, classes }
    }
}

/// The errors of a case's rays.
#[derive(Clone, Debug)]
pub struct CaseErrors {
    /// The error of each ray.
    pub of_rays: Vec<RayError>,
    /// Whether one of a pixel's eight neighbours sees another object, by the exact ids; never in a list of rays.
    pub is_at_silhouette: Vec<bool>,
    /// Errors of the rays away from silhouettes, and of those at them.
    pub classes: [ErrorStats; 2],
}

/// A case that was held against exact arithmetic.
pub struct Judged {
    /// The case.
    pub case: Case,
    /// What is exact.
    pub truth: Truth,
    /// The errors.
    pub errors: CaseErrors,
    /// What is more wrong than it may be, one sentence each.
    pub broken: Vec<String>,
    /// Settings under which far more of it would be right; empty if there are none.
    pub hint: Vec<Setting>,
}

/// What became of a case.
#[derive(Serialize)]
pub struct JudgeSummary {
    size: Option<[u32; 2]>,
    /// Left column, top row, width and height of a part.
    crop: Option<[u32; 4]>,
    objects: ObjectCounts,
    rays: usize,
    judged: Vec<&'static str>,
    allowed: String,
    away: ErrorStats,
    silhouettes: Option<ErrorStats>,
    worst: Vec<Finding>,
    hint: Option<String>,
    broken: Vec<String>,
}

impl Judged {
    /// The pixels, where the rays are those of pixels.
    pub fn pixels(&self) -> Option<&Pixels> {
        self.case.rays.pixels()
    }

    /// The names of what was judged.
    pub fn quantities(&self) -> Vec<&'static str> {
        self.case.claims.quantities().map(Quantity::name).collect()
    }

    /// Returns all in numbers, with these findings and the hint as the front end words it.
    pub fn summary(&self, worst: Vec<Finding>, hint: &str) -> JudgeSummary {
        let (pixels, Case { scene, rays, allowed, .. }) = (self.pixels(), &self.case);
        let [away, silhouettes] = self.errors.classes.clone();
        let is_part = |p: &&Pixels| (p.width, p.height) != (p.image_width, p.image_height);
        JudgeSummary {
            size: pixels.map(|p| [p.image_width, p.image_height]),
            crop: pixels.filter(is_part).map(|p| [p.x, p.y, p.width, p.height]),
            objects: ObjectCounts::of(scene),
            rays: rays.len(),
            judged: self.quantities(),
            allowed: allowed.to_string(),
            away,
            silhouettes: pixels.map(|_| silhouettes),
            worst,
            hint: (!hint.is_empty()).then(|| hint.into()),
            broken: self.broken.clone(),
        }
    }

    /// The picture of the errors: its size and colours; `None` for a list of rays.
    pub fn picture(&self) -> Option<([u32; 2], Vec<[u8; 3]>)> {
        let CaseErrors { of_rays, is_at_silhouette, .. } = &self.errors;
        let pixels = self.pixels()?;
        let colors = error_picture(of_rays, |i| is_at_silhouette[i]);
        Some(([pixels.width, pixels.height], colors))
    }

    /// Least and greatest length of the normals, of all rays on the right object; `None` without normals.
    fn normal_lengths(&self) -> Option<[f64; 2]> {
        let ranges = self.errors.classes.iter().filter_map(|class| class.normal_length);
        ranges.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }

    fn broken(&self) -> Vec<String> {
        let (allowed, classes) = (&self.case.allowed, &self.errors.classes);
        let mut broken = Vec::new();
        let away = if classes[1].rays > 0 { " away from silhouettes" } else { "" };
        let places = [("ids", away), ("silhouettes", " at silhouettes")];
        for (ErrorStats { wrong_ids, rays, .. }, (key, place)) in classes.iter().zip(places) {
            let most = allowed.limit(key);
            if !most.allows_part(*wrong_ids, *rays) {
                broken.push(format!("{wrong_ids} of {rays} ids{place} are wrong, allowed: {most}"));
            }
        }
        let [ulp, relative, degrees, component] = [0, 1, 2, 3].map(|kind| {
            let spreads = classes.iter().filter_map(|class| class.spreads()[kind]);
            spreads.map(|spread| spread.worst).fold(0.0, f64::max)
        });
        if !allowed.allows_t(&TError { ulp, relative, is_nearest: false }) {
            broken.push(match allowed.limit("t") {
                Tolerance { most, unit: Unit::Ulp } => {
                    format!("t is off by {} ulp, allowed: {most}", short(ulp))
                }
                most => format!("t is off by a relative {}, allowed: {most}", short(relative)),
            });
        }
        let most = allowed.limit("normal");
        if !most.allows(degrees) {
            broken.push(format!("a normal is off by {}°, allowed: {most}°", short(degrees)));
        }
        let (within, most) = (most.allows(degrees), allowed.normal_component());
        if let Some(lengths) = self.normal_lengths()
            && component > most
            && (within || lengths.iter().any(|length| (length - 1.0).abs() > most))
        {
            broken.push(format!(
                "a component of a normal has an error of {}, allowed: {} (normals: {}; expected 1)",
                short(component),
                short(most),
                words::length_range(lengths)
            ));
        }
        broken
    }
}

/// Whether one of a pixel's eight neighbours sees another object.
fn silhouettes(pixels: &Pixels, hits: &[TrueHit]) -> Vec<bool> {
    let (width, height) = (pixels.width as usize, pixels.height as usize);
    let around = |at: usize, n: usize| at.saturating_sub(1)..(at + 2).min(n);
    let at = |i: usize| {
        let differs = |x: usize, y: usize| hits[y * width + x].id != hits[i].id;
        around(i / width, height).any(|y| around(i % width, width).any(|x| differs(x, y)))
    };
    (0..hits.len()).map(at).collect()
}

/// The size of the whole picture that `image` is to be a part of, by a size and a crop that are given or not; `None` for
/// the scene's own.
///
/// # Errors
/// [`Error::Usage`] for a list, and where the image has another size.
pub fn whole_size(
    image: &Image,
    size: Option<[u32; 2]>,
    crop: Option<[u32; 4]>,
) -> Result<Option<[u32; 2]>> {
    let Image { width, height, whole, first, is_list, .. } = *image;
    let of_file = whole.map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    let wrong = match (crop, size) {
        _ if is_list => {
            format!("a list of {width} results; give the rays that they are of (--rays)")
        }
        (Some([.., w, h]), _) if [w as usize, h as usize] != [width, height] => {
            format!("{width}×{height} pixels, but crop has {w}×{h}")
        }
        (Some(_), _) => {
            let is_whole = whole == [width, height] && first == [0, 0];
            return Ok(size.or((!is_whole).then_some(of_file)));
        }
        (None, Some([w, h])) if [w, h] != of_file => {
            let [width, height] = of_file;
            format!(
                "{width}×{height} pixels, but size has {w}×{h}; say with crop which part of it they are"
            )
        }
        _ => return Ok(Some(of_file)),
    };
    wrong_usage(wrong)
}

/// The pixels that a picture shows, of a camera's picture of that size: a part where the file says so.
///
/// # Errors
/// [`Error::Usage`] where the picture doesn't lie within the whole one.
pub fn pixels_of(image: &Image, whole: Pixels) -> Result<Pixels> {
    let Image { width, height, first: [x, y], .. } = image;
    let part = || {
        let part = [*x, *y, *width as i64, *height as i64].map(|n| u32::try_from(n).ok());
        let [x, y, width, height] = part;
        whole.part([x?, y?, width?, height?])
    };
    part().ok_or_else(|| {
        let Pixels { image_width, image_height, .. } = whole;
        Error::Usage(format!(
            "{width}×{height} pixels at {x},{y} don't lie in a picture of {image_width}×{image_height}; say which \
             part they are with size and crop"
        ).into())
    })
}
