//! What changed since an earlier report.

use serde::{Deserialize, Serialize};

use super::{Contestant, Effort, Report, SCHEMA, Spread};

/// An earlier report, as its JSON tells it. What it has more is left out.
#[derive(Clone, Debug, Deserialize)]
pub struct Earlier {
    evidence: EarlierEvidence,
    effort: EarlierEffort,
    scenes: Vec<EarlierScene>,
    clouds: Vec<EarlierCloud>,
}

/// What every summary begins with.
#[derive(Deserialize)]
struct Head {
    schema: u32,
    command: String,
}

#[derive(Clone, Debug, Deserialize)]
struct EarlierEvidence {
    version: String,
    commit: Option<String>,
    date: String,
    host_cpu: String,
    n_cores: usize,
    adapters: Vec<EarlierAdapter>,
}

#[derive(Clone, Debug, PartialEq, Deserialize)]
struct EarlierAdapter {
    name: String,
    driver: String,
}

#[derive(Clone, Debug, Deserialize)]
struct EarlierEffort {
    size: [u32; 2],
    samples: usize,
    seed: u64,
}

#[derive(Clone, Debug, Deserialize)]
struct EarlierScene {
    name: String,
    rows: Vec<EarlierRow>,
}

#[derive(Clone, Debug, Deserialize)]
struct EarlierRow {
    #[serde(flatten)]
    contestant: Contestant,
    errors: EarlierErrors,
    cost: EarlierCost,
}

#[derive(Clone, Debug, Deserialize)]
struct EarlierErrors {
    rays: u64,
    false_hits: u64,
    false_misses: u64,
    wrong_object: u64,
}

#[derive(Clone, Debug, Deserialize)]
struct EarlierCost {
    trace_ns_per_ray: Spread,
    surface_ns_per_ray: Spread,
}

#[derive(Clone, Debug, Deserialize)]
struct EarlierCloud {
    n_spheres: u64,
    #[serde(flatten)]
    contestant: Contestant,
    picture_ms: Spread,
}

/// What changed since an earlier report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Baseline {
    /// The earlier report's file.
    pub file: String,
    /// The version that it measured.
    pub version: String,
    /// The commit that it measured, if it tells.
    pub commit: Option<String>,
    /// When it was begun.
    pub date: String,
    /// What else than the program is different, in words: times then tell of that too.
    pub different: Vec<String>,
    /// All times that both have.
    pub times: Vec<Change>,
    /// Wrong ids that are not as many as before, where both compared the same pixels.
    pub wrong_ids: Vec<WrongIds>,
}

/// A time, before and now.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// The scene, or the number of spheres of a cloud.
    pub of: String,
    /// Who was measured.
    #[serde(flatten)]
    pub contestant: Contestant,
    /// What was measured, with its unit.
    pub what: &'static str,
    /// The earlier one.
    pub before: Spread,
    /// This report's.
    pub now: Spread,
    /// This median over the earlier one.
    pub ratio: f64,
    /// Whether that is more than noise.
    pub verdict: Verdict,
}

/// What two times say of a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// Every run is faster than all before.
    Faster,
    /// Every run is slower than all before.
    Slower,
    /// Some are, some are not.
    WithinNoise,
    /// Apart, but of so few runs that chance does that too.
    TooFewRuns,
}

/// Wrong ids, before and now.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WrongIds {
    /// The scene.
    pub of: String,
    /// Who was measured.
    #[serde(flatten)]
    pub contestant: Contestant,
    /// Pixels compared.
    pub rays: u64,
    /// The earlier number.
    pub before: u64,
    /// This report's.
    pub now: u64,
}

impl Earlier {
    /// Reads a report's JSON.
    ///
    /// # Errors
    /// What is wrong with it, and the next step.
    pub fn parse(text: &str) -> Result<Earlier, String> {
        const ADVICE: &str = "give what `kugelblitz report -o NAME.json` wrote";
        let wrong = |error| format!("this is no report: {error}; {ADVICE}");
        let head: Head = serde_json::from_str(text).map_err(wrong)?;
        match (head.command.as_str(), head.schema) {
            ("report", SCHEMA) => serde_json::from_str(text).map_err(wrong),
            ("report", other) => Err(format!(
                "this report has the schema {other}, and only {SCHEMA} is read: measure it again, and {ADVICE}"
            )),
            (other, _) => Err(format!("this is of the command `{other}`; {ADVICE}")),
        }
    }

    /// Whether times of `effort` can be compared with these.
    ///
    /// # Errors
    /// Why not, and the option that changes it.
    pub fn check(&self, effort: &Effort) -> Result<(), String> {
        let ([width, height], [now_width, now_height]) = (self.effort.size, effort.size);
        match self.effort.size == effort.size {
            true => Ok(()),
            false => Err(format!(
                "it was measured at {width}x{height} pixels and this would be at \
                 {now_width}x{now_height}, where a ray takes another time; give --size {width}x{height}"
            )),
        }
    }
}

impl Baseline {
    /// Compares `report` with an `earlier` one, which was read from `file`.
    pub fn new(file: String, earlier: &Earlier, report: &Report) -> Baseline {
        let same_pixels = (earlier.effort.size, earlier.effort.samples, earlier.effort.seed)
            == (report.effort.size, report.effort.samples, report.effort.seed);
        let (mut times, mut wrong_ids) = (Vec::new(), Vec::new());
        for scene in &report.scenes {
            let Some(old) = earlier.scenes.iter().find(|old| old.name == scene.name) else {
                continue;
            };
            for row in &scene.rows {
                let Some(old) = old.rows.iter().find(|old| old.contestant == row.contestant) else {
                    continue;
                };
                let spreads = [
                    ("ids, ns a ray", old.cost.trace_ns_per_ray, row.cost.trace_ns_per_ray),
                    (
                        "with t and normals, ns a ray",
                        old.cost.surface_ns_per_ray,
                        row.cost.surface_ns_per_ray,
                    ),
                ];
                times.extend(spreads.into_iter().filter_map(|(what, before, now)| {
                    Change::new(&scene.name, &row.contestant, what, before, now)
                }));
                let EarlierErrors { rays, false_hits, false_misses, wrong_object } = old.errors;
                let before = false_hits + false_misses + wrong_object;
                let now = row.errors.wrong_ids();
                if same_pixels && rays == row.errors.rays && before != now {
                    let (of, contestant) = (scene.name.clone(), row.contestant.clone());
                    wrong_ids.push(WrongIds { of, contestant, rays, before, now });
                }
            }
        }
        for cloud in &report.clouds {
            let is_same = |old: &&EarlierCloud| {
                (old.n_spheres, &old.contestant) == (cloud.n_spheres, &cloud.contestant)
            };
            if let Some(old) = earlier.clouds.iter().find(is_same) {
                let of = format!("{} spheres", cloud.n_spheres);
                let (what, now) = ("a picture, ms", cloud.picture_ms);
                times.extend(Change::new(&of, &cloud.contestant, what, old.picture_ms, now));
            }
        }
        Baseline {
            file,
            version: earlier.evidence.version.clone(),
            commit: earlier.evidence.commit.clone(),
            date: earlier.evidence.date.clone(),
            different: differences(&earlier.evidence, report),
            times,
            wrong_ids,
        }
    }

    /// The times that changed by more than noise.
    pub fn beyond_noise(&self) -> impl Iterator<Item = &Change> {
        let is_beyond = |c: &&Change| matches!(c.verdict, Verdict::Faster | Verdict::Slower);
        self.times.iter().filter(is_beyond)
    }

    /// What is compared with what, and what came of it, a sentence or two in each.
    pub fn in_words(&self) -> Vec<String> {
        let commit = self.commit.as_ref().map(|commit| format!(", commit {commit}"));
        let (commit, n) = (commit.unwrap_or_default(), self.times.len());
        let [faster, slower, few] =
            [Verdict::Faster, Verdict::Slower, Verdict::TooFewRuns].map(|v| self.count(v));
        let mut words = vec![format!(
            "Against {} (Kugelblitz {}{commit}, {}): {}.",
            self.file,
            self.version,
            self.date,
            match n {
                0 => "nothing of it was measured again".to_string(),
                _ => format!(
                    "of {n} times, {faster} got faster and {slower} slower by more than noise, \
                     which is where no run of one reaches into those of the other"
                ),
            }
        )];
        if few > 0 {
            words
                .push(format!("{few} are apart, but of too few runs to tell: give more --rounds."));
        }
        if !self.different.is_empty() {
            let different = self.different.join("; ");
            words.push(format!("Times tell of more than the program: {different}."));
        }
        words
    }

    /// How many times have a verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.times.iter().filter(|change| change.verdict == verdict).count()
    }
}

/// What of the machine is another than before.
fn differences(earlier: &EarlierEvidence, report: &Report) -> Vec<String> {
    let evidence = &report.evidence;
    let mut different = Vec::new();
    if (&earlier.host_cpu, earlier.n_cores) != (&evidence.host_cpu, evidence.n_cores) {
        different.push(format!(
            "the CPU was {} with {} cores, and is {} with {}",
            earlier.host_cpu, earlier.n_cores, evidence.host_cpu, evidence.n_cores
        ));
    }
    for adapter in &evidence.adapters {
        let (name, driver) = (&adapter.facts.name, &adapter.facts.driver);
        let old = earlier.adapters.iter().find(|old| old.name == *name);
        if let Some(old) = old.filter(|old| old.driver != *driver) {
            different.push(format!("the driver of {name} was {}, and is {driver}", old.driver));
        }
    }
    different
}

impl Change {
    /// `None` where there is nothing to compare.
    fn new(
        of: &str,
        contestant: &Contestant,
        what: &'static str,
        before: Spread,
        now: Spread,
    ) -> Option<Change> {
        let ratio = now.median / before.median;
        (before.n > 0 && now.n > 0 && ratio.is_finite()).then(|| Change {
            of: of.to_string(),
            contestant: contestant.clone(),
            what,
            before,
            now,
            ratio,
            verdict: verdict(&before, &now),
        })
    }
}

/// A change that chance alone makes more often than this is none.
const CHANCE: f64 = 0.01;

/// Runs before and now that don't overlap are apart by more than noise, where there are enough of them: of
/// n and m runs of the same thing, all of one lot are below all of the other in 2 of (n + m)! / (n! m!)
/// orders.
fn verdict(before: &Spread, now: &Spread) -> Verdict {
    let apart = match (now.max < before.min, now.min > before.max) {
        (true, _) => Verdict::Faster,
        (_, true) => Verdict::Slower,
        _ => return Verdict::WithinNoise,
    };
    let orders: f64 = (1..=now.n).map(|i| (before.n + i) as f64 / i as f64).product();
    if 2.0 / orders < CHANCE { apart } else { Verdict::TooFewRuns }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(min: f64, max: f64, n: usize) -> Spread {
        Spread { median: (min + max) / 2.0, min, max, n }
    }

    #[test]
    fn runs_that_overlap_are_noise() {
        let before = spread(10.0, 12.0, 9);
        for (now, expected) in [
            (spread(8.0, 9.9, 9), Verdict::Faster),
            (spread(8.0, 10.0, 9), Verdict::WithinNoise),
            (spread(12.0, 30.0, 9), Verdict::WithinNoise),
            (spread(12.1, 30.0, 9), Verdict::Slower),
            (spread(12.1, 30.0, 1), Verdict::TooFewRuns),
            (spread(12.1, 30.0, 3), Verdict::Slower),
        ] {
            assert_eq!(verdict(&before, &now), expected, "{now:?}");
        }
        // Three of each: 20 orders, two of which look like a change.
        let [few, later] = [spread(1.0, 2.0, 3), spread(3.0, 4.0, 3)];
        assert_eq!(verdict(&few, &later), Verdict::TooFewRuns);
        let [five, later] = [spread(1.0, 2.0, 5), spread(3.0, 4.0, 5)];
        assert_eq!(verdict(&five, &later), Verdict::Slower);
    }

    #[test]
    fn what_is_no_report_is_told() {
        let no = |text: &str| Earlier::parse(text).expect_err("no report");
        assert!(no("{}").contains("report -o NAME.json"), "{}", no("{}"));
        assert!(no("not json").contains("line 1"), "{}", no("not json"));
        let other = no("{\"schema\": 1, \"command\": \"render\"}");
        assert!(other.contains("command `render`"), "{other}");
        let old = no("{\"schema\": 0, \"command\": \"report\"}");
        assert!(old.contains("schema 0, and only 1 is read"), "{old}");
        let without_clouds = "{\"schema\": 1, \"command\": \"report\", \"scenes\": []}";
        assert!(no(without_clouds).contains("missing field"), "{}", no(without_clouds));
    }
}
