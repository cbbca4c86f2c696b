//! A report in two sentences.

use super::figures::{digits, digits_borne, list, percent};
use super::summary::{Cast, classes, time_of};
use super::{Class, ClassResult, Errors, Report, SceneResult};

/// Which kernels were wrong, where, and how much, in a sentence.
pub fn answer(report: &Report) -> String {
    let (mut right, mut parts) = (Vec::new(), Vec::new());
    for kernel in Cast::of(report).kernels {
        let scenes = worst_errors(report, kernel);
        let n_wrong = scenes.iter().filter(|(_, errors)| errors.wrong_ids() > 0).count();
        let by_share = |a: &Errors, b: &Errors| a.wrong_share().total_cmp(&b.wrong_share());
        let worst = scenes.iter().max_by(|(_, a), (_, b)| by_share(a, b));
        let Some((scene, errors)) = worst else { continue };
        let share = percent(errors.wrong_ids(), errors.rays);
        match (n_wrong, scenes.len()) {
            (0, _) => right.push(kernel.to_string()),
            (_, 1) => {
                parts.push(format!("{kernel} was wrong for {share} of the rays of {scene}"));
            }
            (_, n) => parts.push(format!(
                "{kernel} was wrong in {n_wrong} of {n} scenes, at worst for {share} of the rays \
                 ({scene})"
            )),
        }
    }
    if !right.is_empty() {
        let names = list(&right);
        parts.insert(0, format!("{names} showed the right object for every ray compared"));
    }
    match parts.is_empty() {
        true => "No scene was measured.".to_string(),
        false => format!("{}.", parts.join("; ")),
    }
}

/// The scenes that a kernel was compared in, each with its errors on the device where it was worst.
fn worst_errors<'a>(report: &'a Report, kernel: &str) -> Vec<(&'a str, &'a Errors)> {
    let of_scene = |scene: &'a SceneResult| {
        let rows = scene.rows.iter().filter(|row| row.contestant.kernel == kernel);
        let errors = rows.map(|row| &row.errors).filter(|errors| errors.rays > 0);
        let worst = errors.max_by(|a, b| a.wrong_share().total_cmp(&b.wrong_share()))?;
        Some((scene.name.as_str(), worst))
    };
    report.scenes.iter().filter_map(of_scene).collect()
}

/// The time of the kernels that were never wrong, against the fastest of all, in a sentence. `None`
/// where each was wrong.
pub fn price(report: &Report) -> Option<String> {
    let (cast, classes) = (Cast::of(report), classes(report));
    let mut parts = Vec::new();
    for device in &cast.devices {
        let mut kernels = Vec::new();
        for kernel in &cast.kernels {
            let ratios = classes.iter().map(|class| {
                let ratio = ratio(report, device, *class, kernel)?;
                Some(if classes.len() > 1 { format!("{ratio} ({})", class.name()) } else { ratio })
            });
            let ratios: Option<Vec<String>> = ratios.collect();
            let Some(ratios) = ratios.filter(|ratios| !ratios.is_empty()) else { continue };
            kernels.push(match kernels.is_empty() {
                true => format!("{kernel} takes {} times as long as the fastest", list(&ratios)),
                false => format!("{kernel} {} times", list(&ratios)),
            });
        }
        if !kernels.is_empty() {
            parts.push(format!("on {}, {}", cast.short(device), kernels.join(", ")));
        }
    }
    (!parts.is_empty()).then(|| format!("Without a wrong object: {}.", parts.join("; ")))
}

/// The time of a kernel that was never wrong in a class, against that of the fastest, in the digits that
/// both bear.
fn ratio(report: &Report, device: &str, class: Class, kernel: &str) -> Option<String> {
    let rows = || {
        let on_device = |row: &&ClassResult| row.class == class && row.contestant.device == device;
        report.classes.iter().filter(on_device).filter(|row| row.errors.rays > 0)
    };
    let own = rows().find(|row| row.contestant.kernel == kernel)?;
    let times = rows().map(|row| &row.trace_ns_per_ray).filter(|time| time_of(time).is_some());
    let fastest = times.min_by(|a, b| a.median.total_cmp(&b.median))?;
    let time = time_of(&own.trace_ns_per_ray).filter(|_| own.errors.wrong_ids() == 0)?;
    let n_digits = digits_borne(&own.trace_ns_per_ray).min(digits_borne(fastest));
    Some(digits(time / fastest.median, n_digits))
}
