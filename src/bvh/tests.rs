use super::traversal::{NARROWER, WIDER, below};
use super::*;
use crate::support::random::SplitMix;

fn tree(spheres: &[Sphere]) -> Bvh {
    Bvh::new(spheres, &Control::default()).unwrap()
}

fn spheres(n: usize) -> Vec<Sphere> {
    let mut random = SplitMix::new(610);
    let mut decades = |low: f64, high: f64| 10f64.powf(low + (high - low) * random.unit());
    (0..n)
        .map(|_| {
            let scale = decades(-3.0, 6.0);
            let l = DVec3::from_array(std::array::from_fn(|_| decades(-2.0, 1.0) - 1.0));
            Sphere { center: scale * l, radius: scale * decades(-6.0, -1.0) }
        })
        .collect()
}

/// Each sphere is in one leaf, within the boxes of all nodes above, by the margin.
#[test]
fn boxes_hold_what_is_below_them() {
    for n in [1, 2, 16, 17, 257, 4097, 5000] {
        let spheres = spheres(n);
        let bvh = tree(&spheres);
        assert_eq!((bvh.spheres.len(), &bvh.outside[..]), (n, &[][..]));
        let (mut seen, mut n_nodes) = (vec![0; n], 0);
        let mut open = vec![(0, [[f32::MIN; 3], [f32::MAX; 3]])];
        while let Some((number, [low, high])) = open.pop() {
            let node = &bvh.nodes[number as usize];
            n_nodes += 1;
            for lane in 0..node.boxes.count_ones() {
                let sides = node.sides(lane as usize);
                for axis in 0..3 {
                    assert!(low[axis] <= sides[0][axis] && sides[1][axis] <= high[axis]);
                }
                let link = node.place(lane);
                if lane < node.n_children {
                    open.push((link, sides));
                    continue;
                }
                seen[link as usize] += 1;
                let (sphere, id) = (bvh.spheres[link as usize], bvh.ids[link as usize]);
                assert_eq!(sphere, spheres[id as usize - 1]);
                let (l, r) = (sphere.center - bvh.reference, sphere.radius);
                for axis in 0..3 {
                    let margin = (l[axis].abs() + r) * 2f64.powi(-46);
                    assert!(f64::from(sides[0][axis]) <= l[axis] - r - margin, "{id} {axis}");
                    assert!(f64::from(sides[1][axis]) >= l[axis] + r + margin, "{id} {axis}");
                }
            }
        }
        assert_eq!(n_nodes, bvh.nodes.len());
        assert!(seen.iter().all(|&times| times == 1));
    }
}

/// A box's link leads behind all that is in it, and nothing else; neighbours are in order.
#[test]
fn flat_boxes_hold_what_is_behind_them() {
    for n in (1..=300).chain([5000]) {
        let spheres = spheres(n);
        let bvh = tree(&spheres);
        let boxes = bvh.boxes_from(DVec3::new(0.1, -3.0, 7e3), 0.0, |middle| -middle.x).unwrap();
        assert!(boxes.len() >= n + bvh.nodes.len() - 1 && 2 * boxes.len() <= 3 * n, "{n}");
        let mut seen = vec![0; n];
        // Where the boxes around the next one end, and their corners.
        let mut around: Vec<(usize, FlatBox)> = Vec::new();
        let middle = |flat: &FlatBox| 0.5 * (flat.low[0] + flat.high[0]);
        for (at, here) in boxes.iter().enumerate() {
            while let Some((_, before)) = around.pop_if(|&mut (end, _)| end == at) {
                let is_neighbour = around.last().is_none_or(|&(end, _)| at < end);
                assert!(!is_neighbour || middle(here) < middle(&before) + 1e-2, "{at} of {n}");
            }
            for (_, outer) in &around {
                let holds = |k: usize| outer.low[k] <= here.low[k] && here.high[k] <= outer.high[k];
                assert!((0..3).all(holds), "{at} of {n}");
            }
            if here.link & IS_LEAF != 0 {
                let place = (here.link & !IS_LEAF) as usize;
                assert_eq!(here.id, bvh.ids[place]);
                around.push((at + 1, *here));
                seen[place] += 1;
            } else {
                let end = at + here.link as usize;
                assert!(end > at && around.last().is_none_or(|&(outer, _)| end <= outer));
                around.push((end, *here));
            }
        }
        assert!(seen.iter().all(|&times| times == 1));
    }
}

#[test]
fn equal_spheres_make_no_deep_tree() {
    let sphere = |i: u32| Sphere {
        // Different, but not in f32.
        center: DVec3::new(1e5, -3.0 + 1e-12 * f64::from(i), 0.0),
        radius: 2.0,
    };
    let bvh = tree(&(0..5000).map(sphere).collect::<Vec<_>>());
    let mut deepest = 0;
    let mut open = vec![(0, 1)];
    while let Some((number, depth)) = open.pop() {
        deepest = deepest.max(depth);
        let node = &bvh.nodes[number as usize];
        open.extend((0..node.n_children).map(|lane| (node.place(lane), depth + 1)));
    }
    assert_eq!(deepest, 4, "levels");
}

/// Notes all that it is shown.
#[derive(Default)]
struct All(Vec<u32>);

impl Visitor for All {
    fn last(&self) -> f32 {
        f32::INFINITY
    }

    fn see(&mut self, place: u32) {
        self.0.push(place);
    }
}

/// Spheres that a ray of a beam goes through by the middle, and that a walk of the beam doesn't show; and how many it shows.
/// Of the beam only a share of its width is told.
fn lost(share: f64) -> [usize; 3] {
    let mut random = SplitMix::new(1212);
    let mut number = move || 2.0 * random.unit() - 1.0;
    let (mut n_lost, mut n_shown, mut n_through) = (0, 0, 0);
    let (mut walk, mut cut) = (Traversal::default(), Frontier::default());
    for case in 0..300 {
        let scale = 10f64.powi(case % 13 - 6);
        let mut vector = || DVec3::new(number(), number(), number());
        let spheres: Vec<Sphere> = (0..300)
            .map(|_| Sphere { center: vector() * scale, radius: vector().x.abs() * 0.15 * scale })
            .collect();
        let bvh = tree(&spheres);
        let middle = [vector() * scale, vector()];
        let widths = [vector().abs() * 0.1 * scale, vector().abs() * 0.05];
        let corners = |at: usize, share: f64| {
            [middle[at] - widths[at] * share, middle[at] + widths[at] * share]
        };
        let (origins, directions) = (corners(0, share), corners(1, share));
        let beam = Beam::new(origins, directions, 1e6 * scale);
        let mut shown = All::default();
        match case % 2 {
            0 => walk.all(&bvh, bvh.root(), beam, &mut shown),
            _ => {
                cut.make(&bvh, &beam);
                walk.all(&bvh, cut.nodes(), beam, &mut shown);
            }
        }
        n_shown += shown.0.len();
        for (place, sphere) in bvh.spheres.iter().enumerate() {
            let l = sphere.center - bvh.reference;
            for _ in 0..20 {
                let [origin, direction] =
                    [0, 1].map(|at| middle[at] + widths[at] * vector().signum());
                let t = direction.dot(l - origin) / direction.length_squared();
                let is_met = t > 0.0 && (origin + direction * t).distance(l) < sphere.radius;
                n_through += usize::from(is_met);
                n_lost += usize::from(is_met && !shown.0.contains(&(place as u32)));
            }
        }
    }
    [n_lost, n_shown, n_through]
}

#[test]
fn what_a_ray_of_a_beam_meets_is_shown() {
    let [n_lost, n_shown, n_through] = lost(1.0);
    println!("{n_shown} shown, {n_through} met");
    assert!(n_lost == 0 && n_through > 3000 && n_shown < 300 * 300 / 4, "{n_lost}");
    assert!(lost(0.5)[0] > 100, "half of a beam would do");
}

/// Rounding errors of the smallest numbers of f32, and of smaller ones, are absolute.
#[test]
fn bounds_in_f32_hold_for_the_smallest_numbers() {
    let mut random = SplitMix::new(745);
    for case in 0..200_000 {
        let size = 2f64.powi(case % 200 - 180);
        for x in [size * (1.0 + random.unit()), size * (1.0 + 1e-9 * random.unit())] {
            for x in [x, -x] {
                let (low, high) = (f64::from(below(x)), f64::from(above(x)));
                assert!(low <= x && x <= high, "{low:e} {x:e} {high:e}");
                let room = 3.0 * (x.abs() * 2f64.powi(-23) + 2f64.powi(-149));
                assert!(high - x <= room && x - low <= room, "{low:e} {x:e} {high:e}");
            }
        }
    }
}

/// A ray along an axis through the very edge of a box is not lost to 0 · ∞.
#[test]
fn flat_rays_are_not_lost() {
    let mut random = SplitMix::new(611);
    let mut number = || 2.0 * random.unit() - 1.0;
    let spheres: Vec<Sphere> = (0..300)
        .map(|_| Sphere { center: DVec3::new(number(), number(), number()), radius: 0.05 })
        .collect();
    let bvh = tree(&spheres);
    for (place, &Sphere { center, radius }) in bvh.spheres.iter().enumerate() {
        let l = center - bvh.reference;
        for (axis, sign) in [(0, 1.0), (1, 1.0), (2, 1.0), (0, -1.0), (1, -1.0), (2, -1.0)] {
            let direction = DVec3::AXES[axis] * sign;
            let mut origin = l - 5.0 * direction;
            origin[(axis + 1) % 3] += radius;
            let (mut shown, mut walk) = (All::default(), Traversal::default());
            let beam = Beam::new([origin; 2], [direction; 2], bvh.end([origin; 2]));
            walk.all(&bvh, bvh.root(), beam, &mut shown);
            assert!(shown.0.contains(&(place as u32)), "{origin:?} {direction:?} misses {l:?}");
            assert!(shown.0.len() < 100, "a ray looks at {} of 300", shown.0.len());
        }
    }
}

/// From where f64 can't say how far it is, all is met.
#[test]
fn beams_from_beyond_everything_meet_all() {
    let bvh = tree(&spheres(100));
    for far in [1e35, 1e300, f64::INFINITY, f64::NAN] {
        let (mut shown, mut walk) = (All::default(), Traversal::default());
        let origin = DVec3::splat(-far);
        let beam = Beam::new([origin; 2], [DVec3::ONE; 2], bvh.end([origin; 2]));
        walk.all(&bvh, bvh.root(), beam, &mut shown);
        assert_eq!(shown.0.len(), 100, "{far}");
    }
}

/// The box's side is exact in f32, and the origin so small that its own room doesn't count.
#[test]
fn the_relative_room_of_slabs() {
    /// The rounding to nearest of f32.
    const UNIT: f64 = 1.0 / (1 << 24) as f64;
    let mut random = SplitMix::new(1180);
    let mut number = || {
        let most = [1.0, 0.3, 0.1, 0.02][(4.0 * random.unit()) as usize];
        2f64.powf((6.0 * random.unit() - 3.0).round()) * (1.0 + most * random.unit())
    };
    let (mut later, mut sooner) = (0f64, 0f64);
    for _ in 0..8_000_000 {
        let [side, origin, direction] = [number(), number() * 2f64.powi(-12), number()];
        let side = side as f32;
        let beam = Beam::new([DVec3::X * origin; 2], [DVec3::X * direction; 2], 1e9);
        let [near, far] = beam.sides(side);
        let [near, far] = [near, far].map(|(found, origin)| {
            f64::from(found) / ((f64::from(side) - f64::from(origin)) / direction)
        });
        later = later.max((near / f64::from(NARROWER) - 1.0) / UNIT);
        sooner = sooner.max((1.0 - far / f64::from(WIDER)) / UNIT);
    }
    for (name, bound, found) in [("NARROWER", NARROWER, later), ("WIDER", WIDER, sooner)] {
        let constant = (f64::from(bound) - 1.0).abs() / UNIT;
        println!("{name}: {found:.3} of {constant}");
        assert!(found <= constant && found > constant / 2.0, "{name}: {found} of {constant}");
    }
}
