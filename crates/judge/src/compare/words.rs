//! The differences of hits, ray by ray and as text.

use kugelblitz::scene::Scene;
use kugelblitz::words::{NONE, percent};
use serde::Serialize;

use super::claims::{Claims, DepthKind};
use super::hits::{HitComparison, HitDifference};
use super::objects::ObjectErrors;
use super::{ErrorSpread, ErrorStats, NormalError, RayError, short};
use crate::explain::six_digits;

/// A wrong result of one ray.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// `wrong id`, `wrong id at a silhouette`, `t` or `normal`.
    pub kind: &'static str,
    /// Index of the ray.
    pub ray: usize,
    /// Column and row of the ray; `null` for a list of rays.
    pub pixel: Option<[u32; 2]>,
    /// Result in the file. Unstable in JSON.
    pub says: String,
    /// Exact result. Unstable in JSON.
    pub exact: String,
    /// Command that explains the ray. Unstable in JSON.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub explain: Option<String>,
}

/// Number of objects in the table of wrong rays.
const N_OBJECTS: usize = 8;

/// Minimum share of the wrong rays with which an object is named.
const MIN_SHARE: f64 = 0.9;

/// The kinds of findings, and what stands above them.
const KINDS: [(&str, &str); 4] = [
    ("wrong id", "wrong id"),
    ("wrong id at a silhouette", "wrong id at a silhouette"),
    ("t", "largest errors of t"),
    ("normal", "largest errors of normals"),
];

impl HitDifference {
    /// How wrong a ray is in each of the [`KINDS`]; `None` where that is as it may be.
    fn sizes(&self, ray: usize) -> [Option<f64>; KINDS.len()] {
        let (allowed, errors) = (&self.comparison.allowed, &self.errors);
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
        (0..self.expected.truth.hits.len())
            .filter(|&ray| self.sizes(ray).iter().any(Option::is_some))
    }

    /// The worst rays of each kind, at most `n` of each, without those that are as they may be: wrong ids evenly drawn,
    /// of `t` and normals the worst first. `explain` says how one sees why.
    pub fn worst(&self, n: usize, explain: impl Fn(usize) -> Option<String>) -> Vec<Finding> {
        let mut findings = Vec::new();
        for kind in 0..KINDS.len() {
            let wrong = |ray| Some((self.sizes(ray)[kind]?, ray));
            let mut wrong: Vec<(f64, usize)> =
                (0..self.expected.truth.hits.len()).filter_map(wrong).collect();
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
        let HitDifference { comparison, claims, .. } = self;
        let HitComparison { scene, rays, allowed, .. } = comparison;
        let (exact, off) = (self.exact(ray), short(size));
        let (says, exact) = match (kind, claims.depth(ray), claims.normal(ray)) {
            (2, Some(t), _) => {
                let is_distance = claims.depth_kind() == Some(DepthKind::Distance);
                let what = if is_distance { "distance" } else { "t" };
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

    /// Returns the errors and these findings in lines for people. `option` words the transforms for a front end.
    pub fn in_words(&self, worst: &[Finding], option: impl Fn(&str) -> String) -> String {
        let mut text = self.table();
        if let Some(lengths) = self.normal_lengths() {
            text += &format!("\nnormals: {}; expected 1\n", length_range(lengths));
        }
        for (kind, title) in KINDS {
            let own = worst.iter().filter(|finding| finding.kind == kind);
            let line = |Finding { ray, pixel, says, exact, explain, .. }: &Finding| {
                let at = pixel.map_or(format!("ray {ray}"), |[x, y]| format!("{x},{y}"));
                let how = explain.as_deref().unwrap_or_default();
                format!("  {at}: has {says}; exact: {exact}\n    {how}\n")
            };
            let lines: String = own.map(line).collect();
            if !lines.is_empty() {
                text += &format!("\n{title}:\n{lines}");
            }
        }
        text += &self.by_object();
        if let Some(explained) = &self.explained {
            text += &format!("\n{explained}: {}\n", option(&explained.transforms));
        }
        let kept = if self.broken.is_empty() { ": kept" } else { "" };
        text + &format!("\nallowed: {}{kept}\n", self.comparison.allowed.of_hits())
    }

    /// Returns the wrong rays by object in lines for people.
    fn by_object(&self) -> String {
        let Some(first) = self.objects.first() else { return String::new() };
        let scene = &self.comparison.scene;
        let mut text =
            "\nwrong, by object              rays   wrong ids     wrong t   normals\n".to_string();
        for ObjectErrors { id, rays, wrong_ids, wrong_t, wrong_normals, .. } in
            self.objects.iter().take(N_OBJECTS)
        {
            let name = object_in_words(scene, *id);
            text +=
                &format!("  {name:<22}{rays:>10}{wrong_ids:>12}{wrong_t:>12}{wrong_normals:>10}\n");
        }
        if let n @ 1.. = self.objects.len().saturating_sub(N_OBJECTS) {
            text += &format!("  and {n} more\n");
        }
        if scene.n_objects() > 1 && first.share_of_wrong >= MIN_SHARE {
            let share = match first.share_of_wrong {
                1.0 => "all".to_string(),
                share => format!("{:.0} % of the", share * 100.0),
            };
            let rays = if self.pixels().is_some() { "pixels" } else { "rays" };
            let object = object_in_words(scene, first.id);
            text += &format!("{share} wrong {rays} are on {object}\n");
        }
        text
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
    match claims.id(ray) {
        Some(id) => {
            let id = id.unwrap_or(0);
            object_in_words(scene, u32::try_from(id).unwrap_or(u32::MAX))
        }
        None => if claims.is_hit(ray) { "an object" } else { "the background" }.into(),
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
