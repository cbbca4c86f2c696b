//! A [`Report`] as one HTML page that needs nothing beside itself: no script, no other file.

mod pictures;

use kugelblitz_judge::markup::document;
use maud::{DOCTYPE, Markup, PreEscaped, html};

use super::answer::{answer, price};
use super::figures::{count, typeset};
use super::plot::{self, theme};
use super::tables::Table;
use super::{
    Baseline, CLOUD_SIZE, Count, LIGHT_SIZE, Report, ReportScene, SWEEPS, Settings, Sweep, print,
    tables,
};

/// The page's own style; colours are from the plots' table.
const STYLE: &str = include_str!("page.css");

/// The page may load its own style and pictures, and nothing else.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; img-src data:";

const PLANE: &str = "\
    Farther left is faster, lower is less often wrong. A point is a kernel on a device over all \
    scenes of a class; what has no wrong object lies in the strip below the axis. Steps join the \
    kernels that no other is both faster and less wrong than.";

const HOW_WRONG: &str = "\
    Errors are against exact arithmetic. Those of t and of the normal are of the rays that show the \
    right object; an ulp is the distance of neighbouring f32 numbers at the exact t.";

const HOW_FAST: &str = "\
    Nanoseconds a ray, the geometric mean of the scenes' medians, in parentheses that of their least \
    and largest times. “Ids” is which object each pixel shows. The last columns say which \
    arithmetic decided how many rays.";

const CLOUDS: &str = "\
    Tracing a picture's ids, reading back included. The spheres lie evenly in a cube, all of it in \
    view; `kugelblitz generate cloud --seed 1` makes the same.";

const LIGHT: &str = "\
    A shadow is wrong where a light counts for a pixel that exactly does not, or the other way round; \
    shares are of pixels times lights. Bytes are wrong where any of a pixel’s three is another one. ε is \
    how far from the surface shadow rays start, in units of the scene; it is no number that suits all \
    scenes. The kernel certified has none.";

/// The whole report.
pub fn html(report: &Report) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                title { "Kugelblitz: speed against error" }
                link rel="icon" href="data:,";
                style { (PreEscaped(theme::css_variables())) (PreEscaped(STYLE)) }
            }
            body {
                header {
                    h1 { "Speed against error" }
                    p.answer { (answer(report)) }
                    @if let Some(price) = price(report) { p { (price) } }
                    @if let Some(warning) = report.noise.warning() { p.warning { (warning) } }
                    dl {
                        @for (what, fact) in report.environment.named_lines() {
                            dt { (what) } dd { (fact) }
                        }
                    }
                }
                main {
                    @if let Some(baseline) = &report.baseline { (since(baseline, report)) }
                    @let plane = plot::plane(report);
                    @if !plane.is_empty() {
                        section {
                            h2 { "Time and error of each kernel" }
                            figure {
                                div.wide { (PreEscaped(plane.svg())) }
                                figcaption { (PLANE) }
                            }
                        }
                    }
                    @if !report.classes().is_empty() {
                        section {
                            h2 { "Classes of scenes" }
                            h3 { "How wrong" }
                            (print::html(&tables::class_errors(report)))
                            p.note { (HOW_WRONG) }
                            h3 { "How fast" }
                            (print::html(&tables::class_costs(report)))
                            p.note { (HOW_FAST) }
                        }
                    }
                    (titled("Many spheres", &tables::clouds(report), html! {
                        "Kernel certified at " (CLOUD_SIZE[0]) " × " (CLOUD_SIZE[1]) ". " (CLOUDS)
                    }))
                    @let n_lit_pixels = report.rows.iter().map(|row| row.count(Count::Pixels)).max();
                    (titled("Light", &tables::light(report), html! {
                        (LIGHT_SIZE[0]) " × " (LIGHT_SIZE[1]) " pixels, of which "
                        (typeset(&n_lit_pixels.unwrap_or(0).to_string()))
                        " were compared with exact arithmetic. " (LIGHT)
                    }))
                    (pictures::LIGHT.show(report))
                    @for sweep in &SWEEPS { (sweep_section(report, sweep)) }
                    (pictures::ERRORS.show(report))
                    @let overview = tables::overview(report);
                    @if !overview.is_empty() {
                        section {
                            h2 { "Scenes" }
                            p { "The share of rays with a wrong object; the details have all figures." }
                            (print::html(&overview))
                            @for scene in &report.scenes { (scene_details(report, scene)) }
                        }
                    }
                    @if !report.missing.is_empty() {
                        section {
                            h2 { "Not measured" }
                            ul {
                                @for missing in &report.missing {
                                    li { (missing.what) ": " (missing.why) }
                                }
                            }
                        }
                    }
                    (method(report))
                }
                footer {
                    p { "Kugelblitz " (report.environment.version) ", " (report.environment.date) }
                }
            }
        }
    };
    document(&page.into_string())
}

/// A table with what is to be known of it; nothing where it is empty.
fn titled(title: &str, table: &Table, note: Markup) -> Markup {
    html! {
        @if !table.is_empty() {
            section {
                h2 { (title) }
                (print::html(table))
                p.note { (note) }
            }
        }
    }
}

/// What changed since an earlier report.
fn since(baseline: &Baseline, report: &Report) -> Markup {
    html! {
        section {
            h2 { "Since the baseline" }
            @for words in baseline.in_words() { p { (words) } }
            @for (title, table) in &tables::since(baseline, report) {
                @if !table.is_empty() {
                    h3 { (title) }
                    (print::html(table))
                }
            }
        }
    }
}

/// A sweep; nothing where it has no point.
fn sweep_section(report: &Report, sweep: &Sweep) -> Markup {
    let chart = plot::sweep(report, sweep);
    html! {
        @if !chart.is_empty() {
            section {
                h2 { "Sweep: " (sweep.name) }
                p { (sweep.title) }
                figure.wide { (PreEscaped(chart.svg())) }
                details {
                    summary { "Its numbers" }
                    (print::html(&tables::sweep(report, sweep)))
                }
            }
        }
    }
}

/// All figures of a scene; nothing where its rays were not measured.
fn scene_details(report: &Report, scene: &ReportScene) -> Markup {
    let tables = tables::scene(report, &scene.name);
    html! {
        @if !tables[0].is_empty() {
            details {
                summary {
                    (scene.name)
                    small {
                        (count(scene.n_spheres, "sphere")) ", " (count(scene.n_planes, "plane"))
                    }
                }
                p { (scene.about) }
                @for table in &tables { (print::html(table)) }
            }
        }
    }
}

fn method(report: &Report) -> Markup {
    let Settings { size, samples, seed, rounds, runs, picture_size, .. } = report.settings;
    html! {
        section {
            h2 { "Method" }
            p {
                "Each scene was traced at " (size[0]) " × " (size[1]) " pixels. In each of "
                (count(rounds, "round")) ", every kernel on every device was made anew, its shader \
                 compiled with it; its first picture counts apart, then "
                (count(runs, "picture")) " were timed. So a time is the median of "
                (count(rounds * runs, "run")) ", beside the least and the largest. Times of tracing \
                 hold all stages but reading back, f64 and exact decisions included."
            }
            p {
                "Up to " (typeset(&samples.to_string())) " pixels of each picture, drawn at random with seed " (seed)
                " where it has more, were compared with exact arithmetic on the scene's f64 \
                 numbers. An object is wrong where the ray shows another one than the exact \
                 nearest: one where there is none (false hit), none where there is one (false \
                 miss), or another. “99.9 %” is the error that 99.9 % of the rays do not exceed."
            }
            @if !report.pictures.is_empty() {
                p {
                    "The error pictures have " (picture_size[0]) " × " (picture_size[1])
                    " pixels, each of them compared."
                }
            }
            p {
                "Drivers keep compiled shaders on disk: the largest time of compiling is of the \
                 first time ever, the least comes from that store. All times are of this run on \
                 this machine and drift with what else it did; errors are the same in each run."
            }
        }
    }
}
