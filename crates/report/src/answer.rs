//! A report in two sentences.

use super::figures::{digits, digits_borne, list, percent};
use super::{Count, Of, Report, Row};

/// Which kernels were wrong, where, and how much, in a sentence.
pub fn answer(report: &Report) -> String {
    let (mut right, mut parts) = (Vec::new(), Vec::new());
    for kernel in report.kernels() {
        let mut rows = report.rows_of(|of| matches!(of, Of::Scene { .. }));
        rows.retain(|row| row.key.kernel == kernel && row.count(Count::Rays) > 0);
        let by_share = |a: &&Row, b: &&Row| a.wrong_share().total_cmp(&b.wrong_share());
        let Some(worst) = rows.iter().copied().max_by(by_share) else { continue };
        let scene = worst.key.of.name();
        let share = percent(worst.wrong_ids(), worst.count(Count::Rays));
        let n_scenes = |rows: &[&Row]| rows.chunk_by(|a, b| a.key.of == b.key.of).count();
        let n_all = n_scenes(&rows);
        rows.retain(|row| row.wrong_ids() > 0);
        match (n_scenes(&rows), n_all) {
            (0, _) => right.push(kernel.to_string()),
            (_, 1) => {
                parts.push(format!("{kernel} was wrong for {share} of the rays of {scene}"));
            }
            (n_wrong, n) => parts.push(format!(
                "{kernel} was wrong in {n_wrong} of {n} scenes, at worst for {share} of the rays \
                 ({scene})"
            )),
        }
    }
    if !right.is_empty() {
        let names = list(&right);
        parts.insert(0, format!("{names} showed the right object for every ray compared"));
    }
    if parts.is_empty() {
        "No scene was measured.".to_string()
    } else {
        format!("{}.", parts.join("; "))
    }
}

/// The time of the kernels that were never wrong, against the fastest of all, in a sentence. `None`
/// where each was wrong.
pub fn price(report: &Report) -> Option<String> {
    let classes = report.classes();
    if classes.is_empty() {
        return None;
    }
    let mut parts = Vec::new();
    for device in report.devices() {
        let mut kernels = Vec::new();
        for kernel in report.kernels() {
            let ratios = classes.iter().map(|(class, rows)| {
                let ratio = ratio(rows, device, kernel)?;
                Some(if classes.len() > 1 { format!("{ratio} ({})", class.name()) } else { ratio })
            });
            let Some(ratios) = ratios.collect::<Option<Vec<String>>>() else { continue };
            kernels.push(if kernels.is_empty() {
                format!("{kernel} takes {} times as long as the fastest", list(&ratios))
            } else {
                format!("{kernel} {} times", list(&ratios))
            });
        }
        if !kernels.is_empty() {
            parts.push(format!("on {}, {}", report.short(device), kernels.join(", ")));
        }
    }
    (!parts.is_empty()).then(|| format!("Without a wrong object: {}.", parts.join("; ")))
}

/// The time of a kernel that was never wrong in a class, against that of the fastest, in the digits that
/// both bear.
fn ratio(class: &[&Row], device: &str, kernel: &str) -> Option<String> {
    let is_compared = |row: &&&Row| row.key.device == device && row.count(Count::Rays) > 0;
    let rows: Vec<&&Row> = class.iter().filter(is_compared).collect();
    let own = rows.iter().find(|row| row.key.kernel == kernel && row.wrong_ids() == 0)?;
    let times = rows.iter().filter_map(|row| row.time());
    let fastest = times.min_by(|a, b| a.median.total_cmp(&b.median))?;
    let time = own.time()?;
    let n_digits = digits_borne(&time).min(digits_borne(&fastest));
    Some(digits(time.median / fastest.median, n_digits))
}
