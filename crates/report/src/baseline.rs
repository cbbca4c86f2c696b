//! What changed since an earlier report.

use serde::{Deserialize, Serialize};

use super::environment::program;
use super::{Count, Environment, Metric, Of, Report, Row, RowKey, SCHEMA, Settings, Spread};

/// An earlier report, as its JSON tells it.
#[derive(Clone, Debug, Deserialize)]
pub struct Earlier {
    environment: EarlierEnvironment,
    settings: Settings,
    rows: Vec<Row>,
}

/// What every summary begins with.
#[derive(Deserialize)]
struct Head {
    schema: u32,
    command: String,
}

#[derive(Clone, Debug, Deserialize)]
struct EarlierEnvironment {
    version: String,
    commit: Option<String>,
    date: String,
    host_cpu: String,
    n_cores: usize,
    adapters: Vec<EarlierAdapter>,
}

#[derive(Clone, Debug, Deserialize)]
struct EarlierAdapter {
    name: String,
    driver: String,
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
    /// Wrong ids that are not as many as before, where both compared the same rays.
    pub wrong_ids: Vec<WrongIds>,
}

/// A time, before and now.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// What was measured.
    #[serde(flatten)]
    pub key: RowKey,
    /// Which of its times.
    pub metric: Metric,
    /// The earlier one.
    pub before: Spread,
    /// This report's.
    pub now: Spread,
    /// This median over the earlier one.
    pub ratio: f64,
    /// Whether that is more than noise.
    pub verdict: TimeVerdict,
}

/// Wrong ids, before and now.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WrongIds {
    /// What was measured.
    #[serde(flatten)]
    pub key: RowKey,
    /// Rays compared.
    pub rays: u64,
    /// The earlier number.
    pub before: u64,
    /// This report's.
    pub now: u64,
}

/// What two times say of a change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TimeVerdict {
    /// Every run is faster than all before.
    Faster,
    /// Every run is slower than all before.
    Slower,
    /// Some are, some are not.
    WithinNoise,
    /// Apart, but of so few runs that chance does that too.
    TooFewRuns,
}

impl Earlier {
    /// Reads a report's JSON, to be compared with a report of `settings`.
    ///
    /// # Errors
    /// What is wrong with it, or why its times can't be compared, and the next step.
    pub fn parse(text: &str, settings: &Settings) -> Result<Earlier, String> {
        const ADVICE: &str = "give what `kugelblitz report -o NAME.json` wrote";
        let wrong = |error| format!("this is no report: {error}; {ADVICE}");
        let Head { schema, command } = serde_json::from_str(text).map_err(wrong)?;
        if command != "report" {
            return Err(format!("this is of the command `{command}`; {ADVICE}"));
        }
        if schema != SCHEMA {
            return Err(format!(
                "this report has the schema {schema}, and only {SCHEMA} is read: measure it again, and {ADVICE}"
            ));
        }
        let earlier: Earlier = serde_json::from_str(text).map_err(wrong)?;
        let ([width, height], [now_width, now_height]) = (earlier.settings.size, settings.size);
        if [width, height] != settings.size {
            return Err(format!(
                "it was measured at {width}x{height} pixels and this would be at \
                 {now_width}x{now_height}, where a ray takes another time; give --size {width}x{height}"
            ));
        }
        Ok(earlier)
    }
}

impl Baseline {
    /// Compares `report` with an `earlier` one, which was read from `file`.
    pub fn new(file: String, earlier: &Earlier, report: &Report) -> Baseline {
        let compared = |settings: &Settings| (settings.samples, settings.seed);
        let same_rays = compared(&earlier.settings) == compared(&report.settings);
        let (mut times, mut wrong_ids) = (Vec::new(), Vec::new());
        // A class has no runs of its own.
        for now in report.rows.iter().filter(|row| !matches!(row.key.of, Of::Class { .. })) {
            let Some(before) = earlier.rows.iter().find(|row| row.key == now.key) else { continue };
            times.extend(TIMES.iter().filter_map(|metric| Change::new(*metric, before, now)));
            let (key, rays) = (now.key.clone(), now.count(Count::Rays));
            let found = WrongIds { key, rays, before: before.wrong_ids(), now: now.wrong_ids() };
            if same_rays && before.count(Count::Rays) == rays && found.before != found.now {
                wrong_ids.push(found);
            }
        }
        let EarlierEnvironment { version, commit, date, .. } = earlier.environment.clone();
        let different = earlier.environment.differences(&report.environment);
        Baseline { file, version, commit, date, different, times, wrong_ids }
    }

    /// What is compared with what, and what came of it, a sentence or two in each.
    pub fn in_words(&self) -> Vec<String> {
        let n = self.times.len();
        let [faster, slower, few] =
            [TimeVerdict::Faster, TimeVerdict::Slower, TimeVerdict::TooFewRuns]
                .map(|verdict| self.times.iter().filter(|time| time.verdict == verdict).count());
        let mut words = vec![format!(
            "Against {} ({}, {}): {}.",
            self.file,
            program(&self.version, self.commit.as_deref()),
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
}

impl EarlierEnvironment {
    /// What of the machine was another.
    fn differences(&self, now: &Environment) -> Vec<String> {
        let mut different = Vec::new();
        if (&self.host_cpu, self.n_cores) != (&now.host_cpu, now.n_cores) {
            different.push(format!(
                "the CPU was {} with {} cores, and is {} with {}",
                self.host_cpu, self.n_cores, now.host_cpu, now.n_cores
            ));
        }
        for adapter in &now.adapters {
            let (name, driver) = (&adapter.facts.name, &adapter.facts.driver);
            let old = self.adapters.iter().find(|old| old.name == *name);
            if let Some(old) = old.filter(|old| old.driver != *driver) {
                different.push(format!("the driver of {name} was {}, and is {driver}", old.driver));
            }
        }
        different
    }
}

/// The times that are compared: those of which there are several runs a round.
const TIMES: [Metric; 3] = [Metric::TraceNsPerRay, Metric::SurfaceNsPerRay, Metric::PictureMs];

impl Change {
    /// `None` where there is nothing to compare.
    fn new(metric: Metric, before: &Row, now: &Row) -> Option<Change> {
        let (key, before, now) = (now.key.clone(), before.number(metric)?, now.number(metric)?);
        let (ratio, verdict) = (now.median / before.median, verdict(&before, &now));
        ratio.is_finite().then_some(Change { key, metric, before, now, ratio, verdict })
    }
}

/// A change that chance alone makes more often than this is none.
const CHANCE: f64 = 0.01;

/// Runs before and now that don't overlap are apart by more than noise, where there are enough of them: of
/// n and m runs of the same thing, all of one lot are below all of the other in 2 of (n + m)! / (n! m!)
/// orders.
fn verdict(before: &Spread, now: &Spread) -> TimeVerdict {
    let apart = if now.max < before.min {
        TimeVerdict::Faster
    } else if now.min > before.max {
        TimeVerdict::Slower
    } else {
        return TimeVerdict::WithinNoise;
    };
    let orders: f64 = (1..=now.n).map(|i| (before.n + i) as f64 / i as f64).product();
    if 2.0 / orders < CHANCE { apart } else { TimeVerdict::TooFewRuns }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(min: f64, max: f64, n: usize) -> Spread {
        Spread { median: (min + max) / 2.0, p999: max, min, max, n }
    }

    #[test]
    fn runs_that_overlap_are_noise() {
        let before = spread(10.0, 12.0, 9);
        for (now, expected) in [
            (spread(8.0, 9.9, 9), TimeVerdict::Faster),
            (spread(8.0, 10.0, 9), TimeVerdict::WithinNoise),
            (spread(12.0, 30.0, 9), TimeVerdict::WithinNoise),
            (spread(12.1, 30.0, 9), TimeVerdict::Slower),
            (spread(12.1, 30.0, 1), TimeVerdict::TooFewRuns),
            (spread(12.1, 30.0, 3), TimeVerdict::Slower),
        ] {
            assert_eq!(verdict(&before, &now), expected, "{now:?}");
        }
        // Three of each: 20 orders, two of which look like a change.
        let [few, later] = [spread(1.0, 2.0, 3), spread(3.0, 4.0, 3)];
        assert_eq!(verdict(&few, &later), TimeVerdict::TooFewRuns);
        let [five, later] = [spread(1.0, 2.0, 5), spread(3.0, 4.0, 5)];
        assert_eq!(verdict(&five, &later), TimeVerdict::Slower);
    }
}
