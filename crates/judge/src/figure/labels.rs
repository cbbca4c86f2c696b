//! Places for labels: beside their points, clear of lines and of each other.

use glam::DVec2;

/// Words beside a point.
pub struct Label {
    pub at: DVec2,
    /// Written in italics, before the rest; none for a number of an axis.
    pub letter: String,
    pub rest: String,
    pub class: &'static str,
    /// Height of the letters, px.
    pub size: f64,
}

/// Width of a letter as a part of its height: the mean of common fonts, and a little more.
const WIDTH: f64 = 0.56;

/// Directions from a point to its label, the liked ones first.
const DIRECTIONS: [(f64, f64); 8] = [
    (1.0, -1.0),
    (1.0, 1.0),
    (-1.0, -1.0),
    (-1.0, 1.0),
    (1.0, 0.0),
    (-1.0, 0.0),
    (0.0, -1.0),
    (0.0, 1.0),
];

/// Distances from a point to its label, as parts of the height of letters.
const DISTANCES: [f64; 3] = [0.45, 0.9, 1.6];

/// A box: its least and its largest corner.
type Room = (DVec2, DVec2);

/// A place for each label, the left end of its baseline: of all around its point the one with the least in it. Large labels choose first.
pub fn placed(labels: &[Label], ink: &[DVec2], size: DVec2) -> Vec<DVec2> {
    let mut taken: Vec<Room> = Vec::new();
    let mut places = vec![DVec2::ZERO; labels.len()];
    let mut order: Vec<usize> = (0..labels.len()).collect();
    order.sort_by(|a, b| labels[*b].size.total_cmp(&labels[*a].size));
    for index in order {
        let label = &labels[index];
        let cost = |&(low, high): &Room| {
            let n_ink = ink.iter().filter(|at| at.cmpge(low).all() && at.cmple(high).all()).count();
            let overlap = |&(other_low, other_high): &Room| {
                (high.min(other_high) - low.max(other_low)).max(DVec2::ZERO).element_product()
            };
            let outside = (-low).max(high - size).max(DVec2::ZERO).element_sum();
            let overlap: f64 = taken.iter().map(overlap).sum();
            n_ink as f64 * label.size + 4.0 * overlap + 10.0 * label.size * outside
        };
        let rooms = DISTANCES.iter().flat_map(|distance| {
            DIRECTIONS.iter().map(move |direction| room(label, *direction, *distance))
        });
        let Some(best) = rooms.min_by(|a, b| cost(a).total_cmp(&cost(b))) else { continue };
        taken.push(best);
        places[index] = DVec2::new(best.0.x, best.1.y - 0.25 * label.size);
    }
    places
}

/// The room of a label in a direction from its point.
fn room(label: &Label, (x, y): (f64, f64), distance: f64) -> Room {
    let n_letters = label.letter.chars().count() + label.rest.chars().count();
    let extent = DVec2::new(n_letters as f64 * WIDTH * label.size, 1.1 * label.size);
    let direction = DVec2::new(x, y);
    let middle = label.at + direction * (extent / 2.0 + distance * label.size);
    (middle - extent / 2.0, middle + extent / 2.0)
}
