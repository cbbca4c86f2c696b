//! The page's tables.

use maud::{Markup, html};

use super::cells::{
    FAULTS, QUANTILES, faults, heads, kernel, names, number, numbers, quantiles, table, time,
};
use crate::report::figures::{
    NONE, count, distribution, list, percent, quantity, stages, t_p999, wrong,
};
use crate::report::plot::typeset;
use crate::report::summary::{Cast, classes, lines, surface_ns_per_ray, xs};
use crate::report::{Class, ClassResult, Errors, PeerResult, Report, Row, SceneResult, Sweep};

/// One body a class, under its name.
fn by_class(report: &Report, n_columns: usize, row: impl Fn(&ClassResult) -> Markup) -> Markup {
    let of = |class: Class| report.classes.iter().filter(move |result| result.class == class);
    html! {
        @for class in classes(report) {
            tbody {
                @if let Some(first) = of(class).next() {
                    tr {
                        th.group colspan=(n_columns) {
                            (class.name()) ": " (count(first.n_scenes, "scene")) ", "
                            (typeset(&first.errors.rays.to_string())) " rays compared"
                        }
                    }
                }
                @for result in of(class) { tr { (row(result)) } }
            }
        }
    }
}

/// Errors of the classes.
pub fn class_errors(report: &Report) -> Markup {
    let cast = Cast::of(report);
    let head = html! {
        tr {
            th.name rowspan="2" { "kernel" } th.name rowspan="2" { "device" }
            th.over colspan="4" { "wrong ids" } th.over colspan="3" { "error of t, ulp" }
            th.over { "normal, °" }
        }
        tr { th { "share" } (heads(&FAULTS)) (heads(&["median", "99.9 %", "largest", "largest"])) }
    };
    let row = |result: &ClassResult| {
        let normal = distribution(result.errors.normal_degrees.as_ref());
        html! {
            (names(&result.contestant, &cast))
            (faults(&result.errors))
            (numbers(&distribution(result.errors.t_ulp.as_ref())))
            (numbers(&normal[2..]))
        }
    };
    table(&head, &by_class(report, 10, row))
}

/// Times of the classes, and which stage decided.
pub fn class_costs(report: &Report) -> Markup {
    let cast = Cast::of(report);
    let head = html! {
        tr {
            th.name rowspan="2" { "kernel" } th.name rowspan="2" { "device" }
            th.over colspan="2" { "time, ns a ray" } th.over colspan="3" { "decided in" }
        }
        tr { (heads(&["ids", "with t and normals", "f32", "f64", "exact"])) }
    };
    let row = |result: &ClassResult| {
        html! {
            (names(&result.contestant, &cast))
            (time(Some(&result.trace_ns_per_ray)))
            (time(surface_ns_per_ray(report, result).as_ref()))
            (numbers(&stages(&result.errors)))
        }
    };
    table(&head, &by_class(report, 7, row))
}

/// All scenes: who was wrong. Devices that agree in all scenes share a column.
pub fn overview(report: &Report) -> Markup {
    let cast = Cast::of(report);
    let columns: Vec<(&str, Vec<&str>)> =
        cast.kernels.iter().flat_map(|kernel| overview_columns(report, &cast, kernel)).collect();
    let is_shared = columns.iter().all(|(_, devices)| devices.len() == cast.devices.len());
    let short = |devices: &[&str]| -> String {
        let names = cast.devices.iter().filter(|device| devices.contains(device));
        list(&names.map(|device| cast.short(device).to_string()).collect::<Vec<_>>())
    };
    let head = html! {
        tr {
            th.name rowspan=(if is_shared { 1 } else { 2 }) { "scene" }
            @for (name, _) in &columns { th { (kernel(name)) } }
        }
        @if !is_shared { tr { @for (_, devices) in &columns { th { (short(devices)) } } } }
    };
    let body = html! {
        @for class in classes(report) {
            tbody {
                tr { th.group colspan=(columns.len() + 1) { (class.name()) } }
                @for scene in report.scenes.iter().filter(|scene| scene.class == class) {
                    tr {
                        td.name { (scene.name) }
                        @for (kernel, devices) in &columns {
                            (overview_cell(find(scene, kernel, devices[0])))
                        }
                    }
                }
            }
        }
    };
    html! {
        p {
            "The share of rays with a wrong object"
            @if is_shared { ", the same on " (short(&cast.devices)) }
            "; the details have all figures."
        }
        (table(&head, &body))
    }
}

fn find<'a>(scene: &'a SceneResult, kernel: &str, device: &str) -> Option<&'a Row> {
    let of = |row: &&Row| row.contestant.kernel == kernel && row.contestant.device == device;
    scene.rows.iter().find(of)
}

/// A kernel with groups of devices that have the same share of wrong ids in each scene.
fn overview_columns<'a>(
    report: &Report,
    cast: &Cast<'a>,
    kernel: &'a str,
) -> Vec<(&'a str, Vec<&'a str>)> {
    let shares = |device: &str| -> Vec<Option<(u64, u64)>> {
        let counts = |row: &Row| (row.errors.wrong_ids(), row.errors.rays);
        report.scenes.iter().map(|scene| find(scene, kernel, device).map(counts)).collect()
    };
    let mut groups: Vec<(&str, Vec<&str>)> = Vec::new();
    for device in &cast.devices {
        let own = shares(device);
        if own.iter().all(Option::is_none) {
            continue;
        }
        match groups.iter_mut().find(|(_, devices)| shares(devices[0]) == own) {
            Some((_, devices)) => devices.push(device),
            None => groups.push((kernel, vec![device])),
        }
    }
    groups
}

fn overview_cell(row: Option<&Row>) -> Markup {
    html! {
        @match row.map(|row| &row.errors).filter(|errors| errors.rays > 0) {
            None => { td.none { (NONE) } },
            Some(errors) if errors.wrong_ids() == 0 => { td.none { "0" } },
            Some(errors) => {
                td.some { (typeset(&percent(errors.wrong_ids(), errors.rays))) }
            },
        }
    }
}

/// All figures of one scene.
pub fn scene(report: &Report, scene: &SceneResult) -> Markup {
    let cast = Cast::of(report);
    html! {
        details {
            summary {
                (scene.name)
                small {
                    (count(scene.n_spheres, "sphere")) ", " (count(scene.n_planes, "plane"))
                }
            }
            p { (scene.about) }
            (scene_errors(scene, &cast))
            (scene_more_errors(scene, &cast))
            (scene_costs(scene, &cast))
        }
    }
}

fn scene_errors(scene: &SceneResult, cast: &Cast) -> Markup {
    let head = html! {
        tr {
            th.name rowspan="2" { "kernel" } th.name rowspan="2" { "device" }
            th rowspan="2" { "rays compared" }
            th.over colspan="4" { "wrong ids" } th.over colspan="3" { "error of t, ulp" }
        }
        tr { th { "share" } (heads(&FAULTS)) (heads(&QUANTILES)) }
    };
    let body = html! {
        tbody {
            @for row in &scene.rows {
                tr {
                    (names(&row.contestant, cast))
                    (number(&row.errors.rays.to_string()))
                    (faults(&row.errors))
                    (quantiles(row.errors.t_ulp.as_ref()))
                }
            }
        }
    };
    table(&head, &body)
}

fn scene_more_errors(scene: &SceneResult, cast: &Cast) -> Markup {
    let head = html! {
        tr {
            th.name rowspan="2" { "kernel" } th.name rowspan="2" { "device" }
            th.over colspan="3" { "error of t, relative" }
            th.over colspan="3" { "error of the normal, °" }
            th.over colspan="3" { "decided in" }
        }
        tr { (heads(&QUANTILES)) (heads(&QUANTILES)) (heads(&["f32", "f64", "exact"])) }
    };
    let body = html! {
        tbody {
            @for row in &scene.rows {
                tr {
                    (names(&row.contestant, cast))
                    (quantiles(row.errors.t_relative.as_ref()))
                    (quantiles(row.errors.normal_degrees.as_ref()))
                    (numbers(&stages(&row.errors)))
                }
            }
        }
    };
    table(&head, &body)
}

fn scene_costs(scene: &SceneResult, cast: &Cast) -> Markup {
    let head = html! {
        tr {
            th.name rowspan="2" { "kernel" } th.name rowspan="2" { "device" }
            th.over colspan="3" { "time, ns a ray" } th.over colspan="3" { "time, ms" }
            th rowspan="2" { "bytes on the device" }
        }
        tr {
            (heads(&["ids", "with t and normals", "device's clock"]))
            (heads(&["read-back", "compiling", "first picture"]))
        }
    };
    let body = html! {
        tbody {
            @for row in &scene.rows {
                @let cost = &row.cost;
                tr {
                    (names(&row.contestant, cast))
                    (time(Some(&cost.trace_ns_per_ray)))
                    (time(Some(&cost.surface_ns_per_ray)))
                    (time(cost.device_ns_per_ray.as_ref()))
                    (time(Some(&cost.readback_ms)))
                    (time(Some(&cost.compile_ms)))
                    (time(Some(&cost.first_picture_ms)))
                    (number(&cost.bytes_device.to_string()))
                }
            }
        }
    };
    table(&head, &body)
}

/// All numbers of a sweep: a row an x, and columns for each line.
pub fn sweep(report: &Report, sweep: &Sweep) -> Markup {
    let cast = Cast::of(report);
    let lines = lines(sweep);
    let points = || sweep.series.iter().flat_map(|series| &series.points);
    let has_errors = points().any(|point| point.errors.is_some());
    let has_times = points().any(|point| point.trace_ns_per_ray.is_some());
    let n_columns = if has_errors { 2 } else { 0 } + usize::from(has_times);
    let head = html! {
        tr {
            th.words rowspan="2" { (sweep.x_label) }
            @for line in &lines {
                th.over colspan=(n_columns) {
                    (kernel(&line.series.contestant.kernel)) ", " (list(&line.devices(&cast)))
                }
            }
        }
        tr {
            @for _ in &lines {
                @if has_errors { (heads(&["wrong ids", "t, 99.9 %, ulp"])) }
                @if has_times { (heads(&["ns a ray"])) }
            }
        }
    };
    let body = html! {
        tbody {
            @for x in xs(sweep) {
                tr {
                    td.name { (typeset(&quantity(x))) }
                    @for line in &lines {
                        @let point = line.series.points.iter().find(|point| point.x == x);
                        @if has_errors {
                            @let errors = point.and_then(|point| point.errors.as_ref());
                            @for shown in [wrong as fn(&Errors) -> String, t_p999] {
                                (number(&errors.map_or(NONE.to_string(), shown)))
                            }
                        }
                        @if has_times {
                            (time(point.and_then(|point| point.trace_ns_per_ray.as_ref())))
                        }
                    }
                }
            }
        }
    };
    table(&head, &body)
}

/// Other renderers.
pub fn peers(peers: &[PeerResult]) -> Markup {
    let head = html! {
        tr {
            th.name rowspan="2" { "renderer" } th.name rowspan="2" { "scene" }
            th rowspan="2" { "threads" } th rowspan="2" { "rays compared" }
            th.over colspan="4" { "wrong ids" }
            th rowspan="2" { "tracing, ns a ray" } th rowspan="2" { "process, ms" }
        }
        tr { th { "share" } (heads(&FAULTS)) }
    };
    let body = html! {
        tbody {
            @for result in peers {
                tr {
                    td.name { (result.peer) }
                    td.name { (result.scene) }
                    (number(&result.n_threads.to_string()))
                    (number(&result.errors.rays.to_string()))
                    (faults(&result.errors))
                    (time(result.trace_ns_per_ray.as_ref()))
                    (time(Some(&result.process_ms)))
                }
            }
        }
    };
    table(&head, &body)
}
