//! Time against error: each kernel on each device as a point, one a class of scenes.

use maud::{Markup, html};

use super::lanes::{Lane, scale_with_room};
use super::marks::{
    DASHES, Entry, Shape, TEXT_PX, band, c, legend, line, marker, svg, text, text_width, x_grid,
    x_labels, y_axis,
};
use super::scale::{Scale, tick_label, typeset};
use super::theme::kernel_class;
use crate::report::figures::{plain_document, spread, wrong};
use crate::report::summary::{Cast, PeerClass, classes, front, peer_classes, time_of};
use crate::report::{Class, Errors, Report, Spread};

const WIDTH: f64 = 860.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = WIDTH - 24.0;
const PLOT_HEIGHT: f64 = 320.0;
const LANE: f64 = 20.0;
const RADIUS: f64 = 5.5;

/// A point of the plane.
struct Point<'a> {
    class: Class,
    label: String,
    color: &'static str,
    shape: Shape,
    errors: &'a Errors,
    time: Spread,
}

/// Where points are.
struct Place {
    x: Scale,
    y: Scale,
    band_top: f64,
    lanes: Vec<Lane>,
}

impl Place {
    /// Points without a wrong id lie in the lane of their label, all others on the axis.
    fn of(&self, label: &str, errors: &Errors, time: f64) -> (f64, f64) {
        let lane = self.lanes.iter().position(|lane| lane.label == label);
        let y = match (errors.wrong_ids(), lane) {
            (0, Some(lane)) => self.lane_y(lane),
            _ => self.y.px(errors.wrong_share()),
        };
        (self.x.px(time), y)
    }

    fn lane_y(&self, lane: usize) -> f64 {
        self.band_top + (lane as f64 + 0.5) * LANE
    }
}

/// The plane as an SVG file.
pub fn plane(report: &Report) -> String {
    let cast = Cast::of(report);
    let peers = peer_classes(report);
    let mut points: Vec<Point> = report
        .classes
        .iter()
        .map(|row| Point {
            class: row.class,
            label: cast.label(&row.contestant),
            color: kernel_class(&row.contestant.kernel),
            shape: Shape::of_device(cast.device_index(&row.contestant.device)),
            errors: &row.errors,
            time: row.trace_ns_per_ray,
        })
        .collect();
    points.extend(peers.iter().filter_map(|peer| {
        Some(Point {
            class: peer.class,
            label: peer_label(report, peer),
            color: "other",
            shape: Shape::Diamond,
            errors: &peer.errors,
            time: peer.trace_ns_per_ray?,
        })
    }));
    points.retain(|point| point.errors.rays > 0 && time_of(&point.time).is_some());
    let (legend, legend_height) = legend(&entries(report, &cast), LEFT, 8.0, RIGHT);
    let top = 8.0 + legend_height + 34.0;
    let place = place(&points, top);
    let bottom = place.band_top + LANE * place.lanes.len() as f64;
    let fronts: Vec<Vec<(f64, f64)>> = classes(report)
        .into_iter()
        .map(|class| front_corners(report, &cast, class, &place))
        .collect();
    let body = html! {
        (legend)
        @if !place.lanes.is_empty() {
            (band(LEFT, place.band_top, RIGHT, bottom - place.band_top, "none"))
        }
        (x_grid(&place.x, top, bottom))
        (x_labels(&place.x, bottom, "time to trace one ray, ns (bar: least to largest)"))
        (y_axis(&place.y, LEFT, RIGHT, percent_label))
        (text(LEFT - 62.0, top - 14.0, "start", "ink", "rays with a wrong object"))
        @for (i, corners) in fronts.iter().enumerate() { (front_line(corners, i)) }
        @for point in &points { (bar(point, &place)) }
        @for point in &points { (dot(point, &place)) }
        @for (i, lane) in place.lanes.iter().enumerate() { (lane.draw(&place.x, place.lane_y(i))) }
        (labels(&points, &place, &fronts, top))
    };
    let description = "Time to trace one ray against the share of rays with a wrong object, one \
                       point for each kernel, device and class of scenes";
    plain_document(&svg(WIDTH, bottom + 54.0, description, &body))
}

/// A peer, with how many scenes it was run on where that is not the whole class.
fn peer_label(report: &Report, peer: &PeerClass) -> String {
    let n_scenes = report.scenes.iter().filter(|scene| scene.class == peer.class).count();
    match peer.n_scenes == n_scenes {
        true => peer.peer.to_string(),
        false => format!("{}, {} of {n_scenes} scenes", peer.peer, peer.n_scenes),
    }
}

fn percent_label(share: f64) -> String {
    format!("{} %", tick_label(100.0 * share))
}

/// One lane for each label that has points without a wrong id.
fn lanes(points: &[Point]) -> Vec<Lane> {
    let mut lanes: Vec<Lane> = Vec::new();
    for point in points.iter().filter(|point| point.errors.wrong_ids() == 0) {
        let (rays, times) = (point.errors.rays, (point.time.min, point.time.max));
        match lanes.iter_mut().find(|lane| lane.label == point.label) {
            Some(lane) => {
                lane.rays += rays;
                lane.times = (lane.times.0.min(times.0), lane.times.1.max(times.1));
            }
            None => lanes.push(Lane { label: point.label.clone(), rays, times }),
        }
    }
    lanes
}

fn place(points: &[Point], top: f64) -> Place {
    let lanes = lanes(points);
    let of_point = |point: &Point| [point.time.min, point.time.median, point.time.max];
    let times: Vec<f64> = points.iter().flat_map(of_point).collect();
    let mut shares: Vec<f64> = points.iter().map(|point| point.errors.wrong_share()).collect();
    if shares.iter().all(|share| *share == 0.0) {
        // Nobody was wrong: what could be seen goes from one ray to all.
        let rays = points.iter().map(|point| point.errors.rays).max().unwrap_or(1);
        shares.extend([1.0 / rays as f64, 1.0]);
    }
    Place {
        x: scale_with_room(&times, &lanes, (LEFT, RIGHT)),
        y: Scale::log(shares, (top + PLOT_HEIGHT, top)),
        band_top: top + PLOT_HEIGHT + 18.0,
        lanes,
    }
}

/// The corners of the front: from the fastest to the right, and down to each that is less wrong
/// than all faster ones.
fn front_corners(report: &Report, cast: &Cast, class: Class, place: &Place) -> Vec<(f64, f64)> {
    let mut corners: Vec<(f64, f64)> = Vec::new();
    for row in front(report, class) {
        let Some(time) = time_of(&row.trace_ns_per_ray) else { continue };
        let (x, y) = place.of(&cast.label(&row.contestant), &row.errors, time);
        corners.extend(corners.last().map(|(_, last_y)| (x, *last_y)));
        corners.push((x, y));
    }
    corners
}

fn front_line(corners: &[(f64, f64)], index: usize) -> Markup {
    let points: Vec<String> = corners.iter().map(|(x, y)| format!("{},{}", c(*x), c(*y))).collect();
    html! {
        @if corners.len() > 1 {
            polyline.soft points=(points.join(" ")) fill="none" stroke="currentColor"
                stroke-width="1.5" stroke-dasharray=(DASHES[index % DASHES.len()]) {}
        }
    }
}

fn bar(point: &Point, place: &Place) -> Markup {
    let (_, y) = place.of(&point.label, point.errors, point.time.median);
    let (Spread { min, max, .. }, is_range) = (point.time, point.time.max > point.time.min);
    html! {
        @if is_range && min > 0.0 && max.is_finite() {
            g class=(point.color) stroke-width="2" opacity="0.6" {
                (line(place.x.px(min), y, place.x.px(max), y))
            }
        }
    }
}

fn dot(point: &Point, place: &Place) -> Markup {
    let (x, y) = place.of(&point.label, point.errors, point.time.median);
    html! {
        g class=(point.color) {
            title {
                (point.label) ", " (point.class.name()) ": " (typeset(&wrong(point.errors))) " wrong, "
                (typeset(&spread(&point.time))) " ns a ray"
            }
            (marker(point.shape, point.class, x, y, RADIUS))
        }
    }
}

/// A rectangle that is taken: left, top, right, bottom.
type Taken = [f64; 4];

fn overlaps(a: &Taken, b: &Taken) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

/// Names beside the points with wrong ids, where there is room; a name without room is left out,
/// as colour and shape tell it, too.
fn labels(points: &[Point], place: &Place, fronts: &[Vec<(f64, f64)>], top: f64) -> Markup {
    let shown: Vec<(&Point, f64, f64)> = points
        .iter()
        .map(|point| (point, place.of(&point.label, point.errors, point.time.median)))
        .map(|(point, (x, y))| (point, x, y))
        .collect();
    let mut taken: Vec<Taken> = shown
        .iter()
        .flat_map(|(point, x, y)| {
            let (left, right) = (place.x.px(point.time.min), place.x.px(point.time.max));
            [[x - 8.0, y - 8.0, x + 8.0, y + 8.0], [left, y - 2.0, right, y + 2.0]]
        })
        .collect();
    for pair in fronts.iter().flat_map(|corners| corners.windows(2)) {
        let [(x1, y1), (x2, y2)] = [pair[0], pair[1]];
        taken.push([x1.min(x2) - 2.0, y1.min(y2) - 2.0, x1.max(x2) + 2.0, y1.max(y2) + 2.0]);
    }
    let mut drawn = Vec::new();
    for (point, x, y) in shown.iter().filter(|(point, ..)| point.errors.wrong_ids() > 0) {
        let width = text_width(&point.label);
        let (left, right) = (place.x.px(point.time.min), place.x.px(point.time.max));
        let candidates = [
            (right.max(x + 2.0) + 8.0, *y),
            (left.min(x - 2.0) - 8.0 - width, *y),
            (x + 4.0, y - 16.0),
            (x + 4.0, y + 16.0),
            (x - 4.0 - width, y - 16.0),
            (x - 4.0 - width, y + 16.0),
            (x - width / 2.0, y - 18.0),
            (x - width / 2.0, y + 18.0),
        ];
        let boxed =
            |(left, y): (f64, f64)| [left, y - TEXT_PX / 2.0, left + width, y + TEXT_PX / 2.0];
        let free = candidates.into_iter().find(|candidate| {
            let own = boxed(*candidate);
            own[0] >= LEFT
                && own[2] <= RIGHT
                && own[1] >= top - 10.0
                && own[3] <= place.band_top
                && !taken.iter().any(|other| overlaps(&own, other))
        });
        if let Some((left, y)) = free {
            taken.push(boxed((left, y)));
            drawn.push(text(left, y + 4.5, "start", "ink halo", &point.label));
        }
    }
    html! { @for label in &drawn { (label) } }
}

/// What colours, shapes and fillings mean.
fn entries(report: &Report, cast: &Cast) -> Vec<Entry> {
    let mut entries = Vec::new();
    for kernel in &cast.kernels {
        let color = kernel_class(kernel);
        entries.push(Entry {
            sample_px: 22.0,
            sample: Box::new(move |x, y| {
                html! { g class=(color) stroke-width="6" { (line(x - 11.0, y, x + 11.0, y)) } }
            }),
            words: kernel.to_string(),
        });
    }
    for (i, device) in cast.devices.iter().enumerate() {
        entries.push(sample(Shape::of_device(i), Class::Lecture, cast.short(device).to_string()));
    }
    if !report.peers.is_empty() {
        entries.push(sample(Shape::Diamond, Class::Lecture, "other renderers".into()));
    }
    for (i, class) in classes(report).into_iter().enumerate() {
        let dash = DASHES[i % DASHES.len()];
        entries.push(Entry {
            sample_px: 40.0,
            sample: Box::new(move |x, y| {
                html! {
                    g.soft {
                        g stroke-width="1.5" stroke-dasharray=(dash) {
                            (line(x - 20.0, y, x + 20.0, y))
                        }
                        (marker(Shape::Circle, class, x, y, RADIUS))
                    }
                }
            }),
            words: format!("{} and their Pareto front", class.name()),
        });
    }
    entries
}

fn sample(shape: Shape, class: Class, words: String) -> Entry {
    Entry {
        sample_px: 14.0,
        sample: Box::new(move |x, y| html! { g.soft { (marker(shape, class, x, y, RADIUS)) } }),
        words,
    }
}
