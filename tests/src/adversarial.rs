//! f32 arithmetic as bad as the proof of the certified kernel allows: each operation rounds to
//! either neighbour of the true result, division may be off by 2.5 units more or less, the square
//! root by 4.5.

use std::cell::Cell;
use std::cmp::Ordering;
use std::ops::{Add, Div, Mul, Neg, Sub};

use kugelblitz::num::Real;

thread_local! {
    static CHOICES: Cell<u64> = const { Cell::new(0) };
    static IS_WIDE: Cell<bool> = const { Cell::new(false) };
}

/// Chooses this thread's roundings one by one: up for a 1, from the lowest bit on, and again after
/// 64 operations. With `wide`, division and square root go to the end of their tolerance.
pub fn set_choices(choices: u64, wide: bool) {
    CHOICES.set(choices);
    IS_WIDE.set(wide);
}

/// Rounds a true result: `nearest`, and on which side of it the truth lies. `spare` whole units
/// are this operation's tolerance beyond a neighbour.
fn round(nearest: f32, truth_is: Ordering, spare: i32) -> f32 {
    let choices = CHOICES.get();
    CHOICES.set(choices.rotate_right(1));
    let goes_up = choices & 1 == 1;
    let (below, above) = match truth_is {
        Ordering::Less => (nearest.next_down(), nearest),
        Ordering::Equal => (nearest, nearest),
        Ordering::Greater => (nearest, nearest.next_up()),
    };
    let is_zero = truth_is.is_eq() && nearest == 0.0;
    let steps = if IS_WIDE.get() && !is_zero { spare } else { 0 };
    let faithful = if goes_up { above } else { below };
    (0..steps).fold(faithful, |x, _| if goes_up { x.next_up() } else { x.next_down() })
}

/// A number of this arithmetic.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Adversarial(pub f32);

fn sum(a: f32, b: f32) -> f32 {
    // Two-sum in f64: `s + e` is the sum exactly.
    let (a, b) = (f64::from(a), f64::from(b));
    let s = a + b;
    let part = s - a;
    let e = (a - (s - part)) + (b - part);
    let nearest = s as f32;
    let difference = s - f64::from(nearest);
    let order = if difference != 0.0 { difference } else { e };
    match order.partial_cmp(&0.0) {
        Some(order) => round(nearest, order, 0),
        None => nearest,
    }
}

impl Add for Adversarial {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Adversarial(sum(self.0, other.0))
    }
}

impl Sub for Adversarial {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Adversarial(sum(self.0, -other.0))
    }
}

impl Mul for Adversarial {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        // 48 bits: exact in f64.
        let product = f64::from(self.0) * f64::from(other.0);
        let nearest = product as f32;
        let order = product.partial_cmp(&f64::from(nearest));
        Adversarial(order.map_or(nearest, |order| round(nearest, order, 0)))
    }
}

impl Div for Adversarial {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let nearest = (f64::from(self.0) / f64::from(other.0)) as f32;
        if !nearest.is_finite() || other.0 == 0.0 {
            return Adversarial(nearest);
        }
        // The sign of the exact remainder, against the divisor's.
        let rest = f64::from(self.0) - f64::from(nearest) * f64::from(other.0);
        let order = (rest * f64::from(other.0.signum())).partial_cmp(&0.0);
        Adversarial(order.map_or(nearest, |order| round(nearest, order, 1)))
    }
}

impl Neg for Adversarial {
    type Output = Self;
    fn neg(self) -> Self {
        Adversarial(-self.0)
    }
}

impl Real for Adversarial {
    type One = f32;
    type Mask = bool;
    type Id = u32;

    fn splat(x: f32) -> Self {
        Adversarial(x)
    }

    fn splat_id(id: u32) -> u32 {
        id
    }

    fn lt(self, other: Self) -> bool {
        self.0 < other.0
    }

    fn le(self, other: Self) -> bool {
        self.0 <= other.0
    }

    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }

    fn select_id(mask: bool, yes: u32, no: u32) -> u32 {
        if mask { yes } else { no }
    }

    fn sqrt(self) -> Self {
        let nearest = self.0.sqrt();
        if !nearest.is_finite() || nearest == 0.0 {
            return Adversarial(nearest);
        }
        let square = f64::from(nearest) * f64::from(nearest);
        let order = f64::from(self.0).partial_cmp(&square);
        Adversarial(order.map_or(nearest, |order| round(nearest, order, 3)))
    }

    fn abs(self) -> Self {
        Adversarial(self.0.abs())
    }
}
