//! A report in two sentences.

use super::Metric::TraceNsPerRay;
use super::figures::{digits, digits_borne, list, percent};
use super::{Class, Count, Of, Report, Row, Spread};

/// Which kernels were wrong, where, and how much, in a sentence.
pub fn answer(report: &Report) -> String {
    let (mut right, mut parts) = (Vec::new(), Vec::new());
    for kernel in report.kernels() {
        let scenes = worst_rows(report, kernel);
        let n_wrong = scenes.iter().filter(|row| row.wrong_ids() > 0).count();
        let Some(row) = scenes.iter().copied().max_by(by_share) else { continue };
        let scene = row.key.of.name();
        let share = percent(row.wrong_ids(), row.count(Count::Rays));
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
    if parts.is_empty() {
        "No scene was measured.".to_string()
    } else {
        format!("{}.", parts.join("; "))
    }
}

fn by_share(a: &&Row, b: &&Row) -> std::cmp::Ordering {
    a.wrong_share().total_cmp(&b.wrong_share())
}

/// The row of the device where a kernel was worst, of each scene that it was compared in.
fn worst_rows<'a>(report: &'a Report, kernel: &str) -> Vec<&'a Row> {
    let mut rows = report.rows_of(|of| matches!(of, Of::Scene { .. }));
    rows.retain(|row| row.key.kernel == kernel && row.count(Count::Rays) > 0);
    let of_scenes = rows.chunk_by(|a, b| a.key.of == b.key.of);
    of_scenes.filter_map(|rows| rows.iter().copied().max_by(by_share)).collect()
}

/// The time of the kernels that were never wrong, against the fastest of all, in a sentence. `None`
/// where each was wrong.
pub fn price(report: &Report) -> Option<String> {
    let classes = report.classes();
    let mut parts = Vec::new();
    for device in report.devices() {
        let mut kernels = Vec::new();
        for kernel in report.kernels() {
            let ratios = classes.iter().map(|(class, rows)| {
                let ratio = ratio(rows, device, kernel)?;
                Some(if classes.len() > 1 {
                    format!("{ratio} ({})", Class::name(*class))
                } else {
                    ratio
                })
            });
            let ratios: Option<Vec<String>> = ratios.collect();
            let Some(ratios) = ratios.filter(|ratios| !ratios.is_empty()) else { continue };
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
    let rows = || {
        let rows = class.iter().filter(|row| row.key.device == device);
        rows.filter(|row| row.count(Count::Rays) > 0)
    };
    let own = rows().find(|row| row.key.kernel == kernel && row.wrong_ids() == 0)?;
    let times = rows().filter_map(|row| row.number(TraceNsPerRay)).filter(Spread::is_drawable);
    let fastest = times.min_by(|a, b| a.median.total_cmp(&b.median))?;
    let time = own.number(TraceNsPerRay).filter(Spread::is_drawable)?;
    let n_digits = digits_borne(&time).min(digits_borne(&fastest));
    Some(digits(time.median / fastest.median, n_digits))
}
