//! What was found, ray by ray and in words.

use kugelblitz::scene::{Color, Scene, hex};
use kugelblitz::words::{NONE, percent};
use serde::Serialize;

use super::{Case, ClaimedHit, Claims, Judged, Quantity};
use crate::compare::{ErrorSpread, ErrorStats, NormalError, RayError, short};
use crate::explain::six_digits;

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
    /// How one sees why.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explain: Option<String>,
}

/// The kinds of findings, and what stands above them.
const KINDS: [(&str, &str); 4] = [
    ("wrong id", "wrong id"),
    ("wrong id at a silhouette", "wrong id at a silhouette"),
    ("t", "largest errors of t"),
    ("normal", "largest errors of normals"),
];

impl Judged {
    /// How wrong a ray is in each of the [`KINDS`]; `None` where that is as it may be.
    fn sizes(&self, ray: usize) -> [Option<f64>; KINDS.len()] {
        let (allowed, errors) = (&self.case.allowed, &self.errors);
        match errors.of_rays[ray] {
            RayError::Right { t, normal, .. } => {
                let t = t.filter(|t| !allowed.allows_t(t)).map(|t| t.ulp);
                let normal = normal.filter(|normal| !allowed.allows_normal(normal));
                // A component's difference is an angle in radians, if the length is right.
                let size = |n: NormalError| n.degrees.max(n.component.to_degrees());
                [None, None, t, normal.map(size)]
            }
            _ if errors.is_at_silhouette[ray] => [None, Some(0.0), None, None],
            _ => [Some(0.0), None, None, None],
        }
    }

    /// The rays with anything that is more wrong than it may be of one ray.
    pub fn wrong_rays(&self) -> impl Iterator<Item = usize> {
        (0..self.truth.hits.len()).filter(|&ray| self.sizes(ray).iter().any(Option::is_some))
    }

    /// The worst rays of each kind, at most `n` of each, without those that are as they may be: wrong ids evenly drawn,
    /// of `t` and normals the worst first. `explain` says how one sees why.
    pub fn worst(&self, n: usize, explain: impl Fn(usize) -> Option<String>) -> Vec<Finding> {
        let mut findings = Vec::new();
        for kind in 0..KINDS.len() {
            let wrong = |ray| Some((self.sizes(ray)[kind]?, ray));
            let mut wrong: Vec<(f64, usize)> =
                (0..self.truth.hits.len()).filter_map(wrong).collect();
            let n = n.min(wrong.len());
            if kind < 2 {
                wrong = (0..n).map(|k| wrong[k * wrong.len() / n]).collect();
            } else {
                wrong.sort_by(|a, b| b.0.total_cmp(&a.0));
                wrong.truncate(n);
            }
            let finding = |(size, ray)| self.finding(kind, size, ray, explain(ray));
            findings.extend(wrong.into_iter().map(finding));
        }
        findings
    }

    /// What is wrong with one ray: its id, or `t` and the normal; nothing where all is as it may be.
    pub fn of_ray(&self, ray: usize) -> Vec<Finding> {
        let sizes = self.sizes(ray).into_iter().enumerate();
        sizes.filter_map(|(kind, size)| Some(self.finding(kind, size?, ray, None))).collect()
    }

    fn finding(&self, kind: usize, size: f64, ray: usize, explain: Option<String>) -> Finding {
        let Judged { case: Case { scene, rays, claims, allowed, .. }, truth, .. } = self;
        let (exact, off) = (&truth.hits[ray], short(size));
        let (says, exact) = match (kind, claims.depth(ray), claims.normal(ray)) {
            (2, Some((t, _)), _) => {
                let what = if claims.has(Quantity::Distance) { "distance" } else { "t" };
                let says = format!("{what} = {t:?} ({off} ulp off)");
                (says, format!("t = {:?}", exact.t))
            }
            (3, _, Some(normal)) => {
                let vector = |[x, y, z]: [f64; 3]| format!("({x:.6}, {y:.6}, {z:.6})");
                let angle = match self.errors.of_rays[ray] {
                    RayError::Right { normal: Some(error), .. } => error.degrees,
                    _ => size,
                };
                let length = normal.length();
                let is_unit = (length - 1.0).abs() <= allowed.normal_component();
                let of_length = match is_unit || length.is_nan() {
                    true => String::new(),
                    false => format!(" of length {}", six_digits(length)),
                };
                let says = format!("{}{of_length}, {}° off", vector(normal.into()), short(angle));
                (says, vector(exact.normal))
            }
            _ => (says(scene, claims, ray), object_in_words(scene, exact.id)),
        };
        Finding { kind: KINDS[kind].0, ray, pixel: rays.pixel(ray), says, exact, explain }
    }

    /// Returns the errors, these findings and the hint, as the front end words it, in lines for people.
    pub fn in_words(&self, worst: &[Finding], hint: &str) -> String {
        let mut text = self.table();
        if let Some(lengths) = self.normal_lengths() {
            text += &format!("\nnormals: {}; expected 1\n", length_range(lengths));
        }
        for (kind, title) in KINDS {
            let own = worst.iter().filter(|finding| finding.kind == kind);
            let line = |Finding { ray, pixel, says, exact, explain, .. }: &Finding| {
                let at = pixel.map_or(format!("ray {ray}"), |[x, y]| format!("{x},{y}"));
                let how = explain.as_deref().unwrap_or_default();
                format!("  {at}: says {says}; exact: {exact}\n    {how}\n")
            };
            let lines: String = own.map(line).collect();
            if !lines.is_empty() {
                text += &format!("\n{title}:\n{lines}");
            }
        }
        if !hint.is_empty() {
            text += &format!("\nfar more of it would be right with {hint}\n");
        }
        let kept = if self.broken.is_empty() { ": kept" } else { "" };
        text + &format!("\nallowed: {}{kept}\n", self.case.allowed)
    }

    /// The errors away from silhouettes and at them.
    fn table(&self) -> String {
        let has_pixels = self.pixels().is_some();
        let parts = &self.errors.classes[..if has_pixels { 2 } else { 1 }];
        let mut text = String::new();
        if has_pixels {
            text +=
                "                             away from silhouettes            at silhouettes\n";
        }
        let mut row = |name: &str, cell: &dyn Fn(&ErrorStats) -> String| {
            text += &format!("{name:<24}");
            parts.iter().for_each(|part| text += &format!("{:>26}", cell(part)));
            text += "\n";
        };
        row(if has_pixels { "pixels" } else { "rays" }, &|part| part.rays.to_string());
        row("wrong ids", &|part| {
            format!("{} ({})", part.wrong_ids, percent(part.wrong_ids, part.rays))
        });
        row("  false hits", &|part| part.false_hits.to_string());
        row("  false misses", &|part| part.false_misses.to_string());
        row("  another object", &|part| part.wrong_object.to_string());
        let names = ["t, ulp", "t, relative", "normal, degrees", "normal, component"];
        for (kind, name) in names.into_iter().enumerate() {
            if parts.iter().all(|part| part.spreads()[kind].is_none()) {
                continue;
            }
            let mut row = |name: &str, shown: fn(ErrorSpread) -> String| {
                row(name, &|part| part.spreads()[kind].map_or(NONE.into(), shown));
            };
            row(&format!("{name}: median"), |spread| short(spread.median));
            row("  99 %", |spread| short(spread.p99));
            row("  worst", |ErrorSpread { worst, worst_ray, worst_pixel, .. }| match worst_pixel {
                Some([x, y]) => format!("{} at {x},{y}", short(worst)),
                None => format!("{} at ray {worst_ray}", short(worst)),
            });
        }
        text
    }
}

/// Returns a range of lengths as text: `length 0.5 to 2`, or `length 1`.
pub(super) fn length_range(ends: [f64; 2]) -> String {
    let [least, most] = ends.map(six_digits);
    if least == most { format!("length {least}") } else { format!("length {least} to {most}") }
}

fn says(scene: &Scene, claims: &Claims, ray: usize) -> String {
    match claims.seen(ray) {
        ClaimedHit::Id(id) => object_in_words(scene, id),
        ClaimedHit::Hit(is_hit) => if is_hit { "an object" } else { "the background" }.into(),
        ClaimedHit::Color(said) => {
            let mut colors = (0..).zip(scene.colors().map(Color::to_srgb8));
            let of = colors.find(|(_, color)| claims.is_like(said, *color));
            let whose = of.map_or("of no object".into(), |(id, _)| object_in_words(scene, id));
            format!("{whose}, {}", hex(said))
        }
    }
}

/// `object 3 “red giant”`, or `the background`.
fn object_in_words(scene: &Scene, id: u32) -> String {
    match (id, scene.object(id), scene.name(id)) {
        (0, ..) => "the background".into(),
        (_, None, _) => "no object of the scene".into(),
        (_, _, Some(name)) => format!("object {id} “{name}”"),
        (..) => format!("object {id}"),
    }
}

/// Colours that one is compared with, the next ones by their red.
const N_NEXT_COLORS: usize = 256;

impl Case {
    /// What makes the judgement of colours weak, where something does: objects whose colours are so near each other that
    /// claims in colours don't tell them apart. Each is compared with the next ones by their red alone.
    pub fn warning(&self) -> Option<String> {
        if !self.claims.is_by_color() {
            return None;
        }
        let (scene, tolerance) = (&*self.scene, self.claims.conventions.color_tolerance);
        let mut colors: Vec<([u8; 3], u32)> =
            scene.colors().map(Color::to_srgb8).zip(0..).collect();
        colors.sort_unstable();
        let within = |a: u8, b: u8| a.abs_diff(b) <= tolerance.saturating_mul(2);
        let like = |(i, &(color, id)): (usize, &([u8; 3], u32))| {
            let next = colors[i + 1..].iter().take(N_NEXT_COLORS);
            let mut next = next.take_while(|(other, _)| within(other[0], color[0]));
            let (_, other) = next.find(|(other, _)| (1..3).all(|c| within(other[c], color[c])))?;
            Some([id.min(*other), id.max(*other)])
        };
        let alike: Vec<[u32; 2]> = colors.iter().enumerate().filter_map(like).collect();
        let [a, b] = alike.first()?.map(|id| object_in_words(scene, id));
        Some(format!(
            "{} of the scene's colours are too near to another one, those of {a} and {b} for one: they are not told \
             apart",
            alike.len()
        ))
    }
}
