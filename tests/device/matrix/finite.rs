//! No operation of the formulas that find objects on a device takes or gives ∞ or NaN, which Vulkan lets a compiler
//! assume away; neither for objects and rays at the ends of the range, nor for those beyond it.
//!
//! Here they run on the records that a device has, in a number that notes what is not finite, and leave nothing out, as
//! shaders don't: also what is selected away is calculated. They must propose what a device's twin does.

use std::cell::{Cell, RefCell};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};
use std::panic::Location;
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::num::{Mask, Real};
use kugelblitz::prepare::{ObjectRecords, Prepared};
use kugelblitz::query::{Kernel, Rays, WorldRay};
use kugelblitz_tests::twins::Twin;
use kugelblitz_tests::{plane, scene, sphere, traced};

use super::devices::{Proposal, counted, differing, replay};
use super::{assert_none, cases};

/// An f32 that is looked at.
#[derive(Clone, Copy, Debug)]
struct Watched(f32);

/// What a comparison gives. Shaders leave nothing out where it does not hold.
#[derive(Clone, Copy)]
struct Truth(bool);

thread_local! {
    static OPERATIONS: Cell<u64> = const { Cell::new(0) };
    /// Places in the source, operations and operands.
    static NOT_FINITE: RefCell<Vec<String>> = const { RefCell::new(Vec::new()) };
}

/// Notes an operation whose operands or result are not finite.
#[track_caller]
fn look(what: &str, operands: &[f32]) {
    OPERATIONS.set(OPERATIONS.get() + 1);
    if !operands.iter().all(|x| x.is_finite()) {
        let found = format!("{}: {what} {operands:?}", Location::caller());
        NOT_FINITE.with_borrow_mut(|all| all.push(found));
    }
}

macro_rules! watched {
    ($($trait:ident $function:ident $sign:tt),*) => {$(
        impl $trait for Watched {
            type Output = Watched;
            #[track_caller]
            fn $function(self, other: Watched) -> Watched {
                let result = self.0 $sign other.0;
                look(stringify!($sign), &[self.0, other.0, result]);
                Watched(result)
            }
        }
    )*};
}

watched!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for Watched {
    type Output = Watched;
    fn neg(self) -> Watched {
        Watched(-self.0)
    }
}

impl BitAnd for Truth {
    type Output = Truth;
    fn bitand(self, other: Truth) -> Truth {
        Truth(self.0 & other.0)
    }
}

impl BitOr for Truth {
    type Output = Truth;
    fn bitor(self, other: Truth) -> Truth {
        Truth(self.0 | other.0)
    }
}

impl Not for Truth {
    type Output = Truth;
    fn not(self) -> Truth {
        Truth(!self.0)
    }
}

impl Mask for Truth {
    fn any(self) -> bool {
        true
    }
}

impl Real for Watched {
    type One = f32;
    type Mask = Truth;
    type Id = u32;
    #[track_caller]
    fn splat(x: f32) -> Watched {
        look("the number", &[x]);
        Watched(x)
    }
    fn splat_id(id: u32) -> u32 {
        id
    }
    #[track_caller]
    fn sqrt(self) -> Watched {
        look("√", &[self.0, self.0.sqrt()]);
        Watched(self.0.sqrt())
    }
    fn abs(self) -> Watched {
        Watched(self.0.abs())
    }
    #[track_caller]
    fn lt(self, other: Watched) -> Truth {
        look("<", &[self.0, other.0]);
        Truth(self.0 < other.0)
    }
    #[track_caller]
    fn le(self, other: Watched) -> Truth {
        look("≤", &[self.0, other.0]);
        Truth(self.0 <= other.0)
    }
    fn select(mask: Truth, yes: Watched, no: Watched) -> Watched {
        if mask.0 { yes } else { no }
    }
    fn select_id(mask: Truth, yes: u32, no: u32) -> u32 {
        if mask.0 { yes } else { no }
    }
}

/// What these rays see, and what was not finite; `None` where a device finds no way.
fn watch(prepared: &Prepared, rays: &Rays, places: &[usize]) -> Option<(Vec<u32>, Vec<String>)> {
    let twin = Twin::new(prepared)?;
    NOT_FINITE.take();
    let decide = |&index: &usize| twin.decide::<Watched>(&twin.ray(rays, index));
    Some((places.iter().map(decide).collect(), NOT_FINITE.take()))
}

#[test]
fn all_numbers_are_finite() {
    let (mut failures, mut n_trees) = (Vec::new(), [0; 2]);
    for case in cases() {
        for Proposal { way, rays, prepared, twin } in Proposal::all(case) {
            if !prepared.in_range {
                continue;
            }
            let places = match &rays {
                Rays::Pixels(pixels) => case.judged_in(pixels).1,
                Rays::List(rays) => (0..rays.len()).collect(),
            };
            let Some((found, not_finite)) = watch(&prepared, &rays, &places) else { continue };
            let mut fail = |what| {
                failures.push(case.failure(&format!("numbers of {way}"), what, replay(case)));
            };
            if let Some(first) = not_finite.first() {
                fail(format!("{} are not finite, the first: {first}", not_finite.len()));
            }
            let of_twin: Vec<u32> = places.iter().map(|&i| twin[i]).collect();
            let found = counted(&prepared, &rays, found);
            differing(&of_twin, &found, true).into_iter().for_each(fail);
            n_trees[usize::from(way == "list")] += usize::from(prepared.hierarchy.is_some());
        }
    }
    assert_none(&failures, cases().len());
    println!("{} operations, trees of pictures and lists: {n_trees:?}", OPERATIONS.get());
    let is_one = cases().len() == 1;
    assert!(is_one || OPERATIONS.get() > 1_000_000 && n_trees.iter().all(|n| *n > 10));
}

/// Each of these would be a division by zero, an overflow or `∞ · 0`: what must not be looked at
/// is noticed where it is.
#[test]
fn sabotage_an_infinity_is_noticed() {
    let scene =
        Arc::new(scene(vec![sphere(DVec3::NEG_Z * 3.0, 1.0)], vec![plane(DVec3::NEG_Y, DVec3::Y)]));
    let ray = WorldRay { origin: DVec3::ZERO, direction: DVec3::NEG_Z };
    let rays = Rays::List(vec![ray; 2]);
    type Change = fn(&mut Prepared);
    fn lists(prepared: &mut Prepared, what: impl Fn(&mut [f32])) {
        let ObjectRecords::Certified { lists, .. } = &mut prepared.objects else {
            panic!("certified")
        };
        what(&mut lists.spheres[0]);
    }
    let changes: [(&str, bool, Change); 4] = [
        ("nothing", false, |_| {}),
        ("an infinite centre", true, |p| lists(p, |s| s[2] = f32::INFINITY)),
        ("a chord that overflows", true, |p| lists(p, |s| s[4] = f32::INFINITY)),
        ("a centre that overflows when squared", true, |p| lists(p, |s| s[0] = 1e30)),
    ];
    for (what, is_noticed, change) in changes {
        let mut prepared = Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).unwrap();
        change(&mut prepared);
        let (_, not_finite) = watch(&prepared, &rays, &[0, 1]).unwrap();
        assert_eq!(!not_finite.is_empty(), is_noticed, "{what}: {not_finite:?}");
    }
}

/// A direction of zero is no ray, a radius of zero no sphere: both are missed.
#[test]
fn zero_directions_and_radii_are_missed() {
    let spheres = vec![sphere(DVec3::ZERO, 0.0), sphere(DVec3::ZERO, 2.0)];
    let scene = Arc::new(scene(spheres, vec![plane(DVec3::NEG_Y * 9.0, DVec3::Y)]));
    // On both sides of the reference point, so that a record of zeros lies before a ray.
    let ray = |x: f64, direction| WorldRay { origin: DVec3::X * x, direction };
    let rays = Rays::List(vec![
        ray(0.25, DVec3::ZERO),
        ray(0.25, DVec3::X),
        ray(0.75, DVec3::NEG_X),
        ray(0.5, DVec3::NEG_X),
    ]);
    let prepared = Prepared::new(Arc::clone(&scene), Kernel::Certified, &rays).unwrap();
    assert_eq!(watch(&prepared, &rays, &[0, 1, 2, 3]).unwrap().1, [""; 0]);
    let hits = traced(&scene, Kernel::Certified, &rays, None);
    assert_eq!((hits.id, hits.t), (vec![0, 2, 2, 2], vec![f32::INFINITY, 1.75, 2.75, 2.5]));
}
