//! What was found, ray by ray and in words.

use serde::Serialize;

use super::allowed::short;
use super::{Allowed, Claims, Judgement, Part, Seen, Spread, alike, worst};
use crate::error::{Error, Result};
use crate::rays::Rays;
use crate::scene::{Color, Scene, hex};
use crate::verify::{RayError, Truth};
use crate::words::percent;

/// What was judged.
#[derive(Clone, Copy)]
pub struct Case<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The rays.
    pub rays: &'a Rays,
    /// What is exact.
    pub truth: &'a Truth,
    /// What another renderer says.
    pub claims: &'a Claims,
}

/// An error of one ray.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// What is wrong: `wrong id`, `wrong id at a silhouette`, `t`, `normal`.
    pub kind: &'static str,
    /// Index of the ray.
    pub ray: usize,
    /// Column and row, where the ray belongs to a pixel.
    pub pixel: Option<[u32; 2]>,
    /// What is claimed.
    pub says: String,
    /// What is right.
    pub exact: String,
}

/// The errors of some rays, with the pixels of the worst.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PartFound {
    /// How many there are.
    pub rays: u64,
    /// With a wrong id.
    pub wrong_ids: u64,
    /// An object where there is none.
    pub false_hits: u64,
    /// No object where there is one.
    pub false_misses: u64,
    /// Another object than the visible one.
    pub wrong_object: u64,
    /// Errors of `t` in f32 steps.
    pub t_ulp: Option<SpreadFound>,
    /// Errors of `t` relative to the exact one.
    pub t_relative: Option<SpreadFound>,
    /// Angles between the normals and the exact ones, degrees.
    pub normal_degrees: Option<SpreadFound>,
}

/// How errors are spread, and where the worst is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SpreadFound {
    /// The errors.
    #[serde(flatten)]
    pub spread: Spread,
    /// The pixel of the worst.
    pub worst_pixel: Option<[u32; 2]>,
}

/// The kinds of findings, as [`worst`] has them.
const KINDS: [&str; 4] = ["wrong id", "wrong id at a silhouette", "t", "normal"];

impl Case<'_> {
    fn pixel(&self, ray: usize) -> Option<[u32; 2]> {
        match self.rays {
            Rays::Pixels(pixels) => Some(pixels.xy(ray).into()),
            Rays::List(_) => None,
        }
    }

    /// The errors of a part of the rays.
    pub fn part(&self, part: &Part) -> PartFound {
        let of = |spread: Option<Spread>| {
            spread.map(|spread| SpreadFound { spread, worst_pixel: self.pixel(spread.worst_ray) })
        };
        PartFound {
            rays: part.rays,
            wrong_ids: part.wrong_ids(),
            false_hits: part.false_hits,
            false_misses: part.false_misses,
            wrong_object: part.wrong_object,
            t_ulp: of(part.t_ulp),
            t_relative: of(part.t_relative),
            normal_degrees: of(part.normal_degrees),
        }
    }

    /// The errors away from silhouettes and at them, in lines for people.
    pub fn table(&self, judgement: &Judgement) -> String {
        let is_picture = matches!(self.rays, Rays::Pixels(_));
        let parts: &[&Part] = match is_picture {
            true => &[&judgement.away, &judgement.silhouettes],
            false => &[&judgement.away],
        };
        let mut text = String::new();
        let mut row = |name: &str, cells: Vec<String>| {
            text += &format!("{name:<24}");
            cells.iter().for_each(|cell| text += &format!("{cell:>26}"));
            text += "\n";
        };
        let cells = |of: &dyn Fn(&Part) -> String| parts.iter().map(|part| of(part)).collect();
        match is_picture {
            true => {
                row("", vec!["away from silhouettes".into(), "at silhouettes".into()]);
                row("pixels", cells(&|part| part.rays.to_string()));
            }
            false => row("rays", cells(&|part| part.rays.to_string())),
        }
        let share = |n: u64, part: &Part| format!("{n} ({})", percent(n, part.rays));
        row("wrong ids", cells(&|part| share(part.wrong_ids(), part)));
        row("  false hits", cells(&|part| part.false_hits.to_string()));
        row("  false misses", cells(&|part| part.false_misses.to_string()));
        row("  another object", cells(&|part| part.wrong_object.to_string()));
        type Of = fn(&Part) -> Option<Spread>;
        let spreads: [(&str, Of); 3] = [
            ("t, ulp", |part| part.t_ulp),
            ("t, relative", |part| part.t_relative),
            ("normal, degrees", |part| part.normal_degrees),
        ];
        for (name, of) in spreads {
            if parts.iter().all(|part| of(part).is_none()) {
                continue;
            }
            let number = |part: &Part, number: fn(&Spread) -> f64| {
                of(part).map_or("–".into(), |spread| short(number(&spread)))
            };
            row(&format!("{name}: median"), cells(&|part| number(part, |spread| spread.median)));
            row("  99 %", cells(&|part| number(part, |spread| spread.p99)));
            let worst = |part: &Part| match of(part) {
                None => "–".into(),
                Some(spread) => match self.pixel(spread.worst_ray) {
                    Some([x, y]) => format!("{} at {x},{y}", short(spread.worst)),
                    None => format!("{} at ray {}", short(spread.worst), spread.worst_ray),
                },
            };
            row("  worst", cells(&worst));
        }
        text
    }

    /// The worst rays, at most `n` of each kind, without those whose `t` and normal are as they may be.
    pub fn worst(&self, judgement: &Judgement, allowed: &Allowed, n: usize) -> Vec<Finding> {
        let all = KINDS.into_iter().zip(worst(judgement, n));
        let all = all.flat_map(|(kind, rays)| rays.into_iter().map(move |ray| (kind, ray)));
        let shown = all.filter(|&(kind, ray)| is_wrong(kind, &judgement.errors[ray], allowed));
        shown.map(|(kind, ray)| self.one(kind, ray, &judgement.errors[ray])).collect()
    }

    /// What is wrong with one ray: its id, or `t` and the normal; nothing where all is as it may be.
    pub fn of_ray(&self, judgement: &Judgement, allowed: &Allowed, ray: usize) -> Vec<Finding> {
        let Some(error) = judgement.errors.get(ray) else { return Vec::new() };
        let is_at = judgement.is_at_silhouette.get(ray).copied().unwrap_or(false);
        let kinds = KINDS.into_iter().filter(|kind| *kind != KINDS[usize::from(!is_at)]);
        let wrong = kinds.filter(|kind| is_wrong(kind, error, allowed));
        wrong.map(|kind| self.one(kind, ray, error)).collect()
    }

    fn one(&self, kind: &'static str, ray: usize, error: &RayError) -> Finding {
        let (says, exact) = match (kind, error) {
            ("t", RayError::Right { t, .. }) => {
                let off = t.map_or(f64::NAN, |t| t.ulp);
                let claimed = self.claims.t.as_ref().map_or(f64::NAN, |t| t[ray]);
                let what = if self.claims.is_distance { "distance" } else { "t" };
                let exact = format!("t = {:?}", self.truth.t[ray]);
                (format!("{what} = {claimed:?} ({} ulp off)", short(off)), exact)
            }
            ("normal", RayError::Right { normal, .. }) => {
                let off = normal.map_or(f64::NAN, |normal| normal.degrees);
                let claimed = self.claims.normal.as_ref().map(|normal| normal[ray]);
                let [x, y, z] = claimed.map_or([f64::NAN; 3], |normal| normal.to_array());
                let [a, b, c] = self.truth.normal[ray];
                let says = format!("({x:.6}, {y:.6}, {z:.6}), {}° off", short(off));
                (says, format!("({a:.6}, {b:.6}, {c:.6})"))
            }
            _ => (self.says(ray), object_in_words(self.scene, self.truth.id[ray])),
        };
        Finding { kind, ray, pixel: self.pixel(ray), says, exact }
    }

    fn says(&self, ray: usize) -> String {
        match &self.claims.seen {
            Seen::Ids(ids) => object_in_words(self.scene, ids[ray]),
            Seen::Hit(hit) => if hit[ray] { "an object" } else { "the background" }.into(),
            Seen::Colors { srgb8, tolerance } => {
                let is_near = |color: Color| {
                    let pairs = color.to_srgb8().into_iter().zip(srgb8[ray]);
                    pairs.into_iter().all(|(a, b)| a.abs_diff(b) <= *tolerance)
                };
                let of = (0..).zip(self.scene.colors()).find(|(_, color)| is_near(*color));
                let whose =
                    of.map_or("of no object".into(), |(id, _)| object_in_words(self.scene, id));
                format!("{whose}, {}", hex(srgb8[ray]))
            }
        }
    }
}

/// Whether an error of this kind is more than may be.
fn is_wrong(kind: &str, error: &RayError, allowed: &Allowed) -> bool {
    match (kind, error) {
        ("t", RayError::Right { t, .. }) => t.is_some_and(|t| !allowed.allows_t(&t)),
        ("normal", RayError::Right { normal, .. }) => {
            normal.is_some_and(|normal| normal.degrees > allowed.normal_degrees)
        }
        ("t" | "normal", _) | (_, RayError::Right { .. }) => false,
        _ => true,
    }
}

/// `object 3 “red giant”`, or `the background`.
pub fn object_in_words(scene: &Scene, id: u32) -> String {
    match (id, scene.object(id), scene.name(id)) {
        (0, ..) => "the background".into(),
        (_, None, _) => "no object of the scene".into(),
        (_, _, Some(name)) => format!("object {id} “{name}”"),
        (..) => format!("object {id}"),
    }
}

/// Findings in lines for people, each with `how` one sees why.
pub fn in_words(findings: &[Finding], how: impl Fn(&Finding) -> String) -> String {
    let mut text = String::new();
    let mut last = "";
    for finding in findings {
        let Finding { kind, ray, pixel, says, exact } = finding;
        if *kind != last {
            let title = match *kind {
                "t" => "largest errors of t",
                "normal" => "largest errors of normals",
                wrong => wrong,
            };
            text += &format!("\n{title}:\n");
            last = kind;
        }
        let at = pixel.map_or(format!("ray {ray}"), |[x, y]| format!("{x},{y}"));
        text += &format!("  {at}: says {says}; exact: {exact}\n    {}\n", how(finding));
    }
    text
}

/// Refuses claims in colours where light changes them; where the scene's own are too near each other to tell
/// its objects, says so. `name` is the scene's in messages.
///
/// # Errors
/// [`Error::Usage`]
pub fn check_colors(scene: &Scene, claims: &Claims, name: &str) -> Result<Option<String>> {
    let Seen::Colors { tolerance, .. } = claims.seen else { return Ok(None) };
    if scene.is_lit() {
        return Err(Error::Usage(format!(
            "{name}: the scene is lit, so that colours don't tell its objects; judge ids, depths or normals, or \
             compare the picture with an exact one: `kugelblitz render` and `kugelblitz compare`"
        )));
    }
    Ok(alike(scene, tolerance).map(|(n, [a, b])| {
        format!(
            "{n} of the scene's colours are too near to another one, those of {} and {} for one: they are \
             not told apart",
            object_in_words(scene, a),
            object_in_words(scene, b)
        )
    }))
}
