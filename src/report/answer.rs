//! What a report says, in two sentences.

use super::figures::{count, digits, list, percent};
use super::summary::{Cast, classes, time_of};
use super::{Class, ClassResult, Errors, Report};

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
                2 => "both scenes".to_string(),
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

/// What the kernels take that were never wrong, against the fastest of all, in a sentence. `None`
/// where each was wrong.
pub fn price(report: &Report) -> Option<String> {
    let cast = Cast::of(report);
    let parts: Vec<String> =
        cast.devices.iter().filter_map(|device| price_on(report, &cast, device)).collect();
    (!parts.is_empty()).then(|| format!("Without a wrong object: {}.", parts.join("; ")))
}

fn price_on<'a>(report: &'a Report, cast: &Cast<'a>, device: &'a str) -> Option<String> {
    let mut kernels = Vec::new();
    for kernel in &cast.kernels {
        let ratios: Option<Vec<(String, &str)>> = classes(report)
            .into_iter()
            .map(|class| Some((ratio(report, device, class, kernel)?, class.name())))
            .collect();
        let Some(ratios) = ratios else { continue };
        kernels.push(if kernels.is_empty() {
            let named = |(ratio, class): &(String, &str)| match ratios.len() {
                1 => ratio.clone(),
                _ => format!("{ratio} ({class})"),
            };
            let ratios: Vec<_> = ratios.iter().map(named).collect();
            format!("{kernel} takes {} times as long as the fastest", list(&ratios))
        } else {
            let ratios: Vec<_> = ratios.into_iter().map(|(ratio, _)| ratio).collect();
            format!("{kernel} {} times", list(&ratios))
        });
    }
    (!kernels.is_empty()).then(|| format!("on {}, {}", cast.short(device), kernels.join(", ")))
}

/// The time of a kernel that was never wrong in a class, against that of the fastest.
fn ratio(report: &Report, device: &str, class: Class, kernel: &str) -> Option<String> {
    let rows = || {
        let on_device = |row: &&ClassResult| row.class == class && row.contestant.device == device;
        report.classes.iter().filter(on_device).filter(|row| row.errors.rays > 0)
    };
    let own = rows().find(|row| row.contestant.kernel == kernel)?;
    let fastest = rows().filter_map(|row| time_of(&row.trace_ns_per_ray)).reduce(f64::min)?;
    let time = time_of(&own.trace_ns_per_ray).filter(|_| own.errors.wrong_ids() == 0)?;
    Some(digits(time / fastest, 3))
}
