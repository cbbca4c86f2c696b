//! What a report says, in two sentences.

use super::figures::{count, digits, list, percent};
use super::summary::{Cast, classes, time_of};
use super::{ClassResult, Errors, Report};

/// What one kernel did in all scenes, on all devices.
struct Verdict<'a> {
    kernel: &'a str,
    n_scenes: usize,
    n_wrong_scenes: usize,
    /// The scene with the largest share of wrong ids.
    worst: Option<(&'a str, &'a Errors)>,
}

fn verdict<'a>(report: &'a Report, kernel: &'a str) -> Verdict<'a> {
    let mut verdict = Verdict { kernel, n_scenes: 0, n_wrong_scenes: 0, worst: None };
    for scene in &report.scenes {
        let rows: Vec<&Errors> = scene
            .rows
            .iter()
            .filter(|row| row.contestant.kernel == kernel && row.errors.rays > 0)
            .map(|row| &row.errors)
            .collect();
        let worst = rows.iter().max_by(|a, b| a.wrong_share().total_cmp(&b.wrong_share()));
        verdict.n_scenes += usize::from(!rows.is_empty());
        if let Some(worst) = worst.filter(|worst| worst.wrong_ids() > 0) {
            verdict.n_wrong_scenes += 1;
            let share = verdict.worst.map_or(0.0, |(_, errors)| errors.wrong_share());
            if worst.wrong_share() > share {
                verdict.worst = Some((&scene.name, worst));
            }
        }
    }
    verdict
}

/// Which kernels were wrong, where, and how much, in a sentence.
pub fn answer(report: &Report) -> String {
    let cast = Cast::of(report);
    let verdicts: Vec<Verdict> = cast
        .kernels
        .iter()
        .map(|kernel| verdict(report, kernel))
        .filter(|verdict| verdict.n_scenes > 0)
        .collect();
    let mut parts = Vec::new();
    let right: Vec<&Verdict> = verdicts.iter().filter(|v| v.n_wrong_scenes == 0).collect();
    if let Some(first) = right.first() {
        let names: Vec<String> = right.iter().map(|v| v.kernel.to_string()).collect();
        let place = match right.iter().all(|v| v.n_scenes == first.n_scenes) {
            true => match first.n_scenes {
                1 => "the scene".to_string(),
                n => format!("all {}", count(n, "scene")),
            },
            false => "their scenes".to_string(),
        };
        parts.push(format!(
            "{} showed the right object for every ray compared in {place}",
            list(&names)
        ));
    }
    for verdict in &verdicts {
        let Some((scene, errors)) = verdict.worst else { continue };
        let share = percent(errors.wrong_ids(), errors.rays);
        parts.push(match verdict.n_scenes {
            1 => format!("{} was wrong for {share} of the rays of {scene}", verdict.kernel),
            n => format!(
                "{} was wrong in {} of {n}, at worst for {share} of the rays ({scene})",
                verdict.kernel, verdict.n_wrong_scenes
            ),
        });
    }
    match parts.is_empty() {
        true => "No scene was measured.".to_string(),
        false => format!("{}.", parts.join("; ")),
    }
}

/// What being right costs, in a sentence: on each device the fastest of the kernels that were
/// never wrong there, against the fastest of all. `None` where no kernel was always right.
pub fn price(report: &Report) -> Option<String> {
    let cast = Cast::of(report);
    let parts: Vec<String> =
        cast.devices.iter().filter_map(|device| price_on(report, &cast, device)).collect();
    (!parts.is_empty()).then(|| format!("What being right costs: {}.", parts.join("; ")))
}

fn price_on<'a>(report: &'a Report, cast: &Cast<'a>, device: &'a str) -> Option<String> {
    let rows: Vec<(f64, &ClassResult)> = report
        .classes
        .iter()
        .filter(|row| row.contestant.device == device && row.errors.rays > 0)
        .filter_map(|row| Some((time_of(&row.trace_ns_per_ray)?, row)))
        .collect();
    let of = |kernel: &str| -> Vec<&(f64, &ClassResult)> {
        rows.iter().filter(|(_, row)| row.contestant.kernel == kernel).collect()
    };
    let classes = classes(report);
    let product = |kernel: &str| of(kernel).iter().map(|(time, _)| time).product::<f64>();
    let right = cast
        .kernels
        .iter()
        .filter(|kernel| {
            let own = of(kernel);
            own.len() == classes.len() && own.iter().all(|(_, row)| row.errors.wrong_ids() == 0)
        })
        .min_by(|a, b| product(a).total_cmp(&product(b)))?;
    let mut last = "";
    let parts: Vec<String> = of(right)
        .into_iter()
        .filter_map(|(own_time, row)| {
            let in_class = rows.iter().filter(|(_, other)| other.class == row.class);
            let (time, fastest) = in_class.min_by(|a, b| a.0.total_cmp(&b.0))?;
            let (class, fastest) = (row.class.name(), fastest.contestant.kernel.as_str());
            let ratio = digits(own_time / time, 3);
            let part = match fastest {
                _ if fastest == *right => format!("is the fastest in the {class}"),
                _ if fastest == last => format!("{ratio} times in the {class}"),
                _ => format!("takes {ratio} times as long as {fastest} in the {class}"),
            };
            last = fastest;
            Some(part)
        })
        .collect();
    Some(format!("on {}, {right} {}", cast.short(device), list(&parts)))
}
