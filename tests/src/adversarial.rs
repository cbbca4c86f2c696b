//! f32 arithmetic as bad as the proof of the certified kernel allows: each operation rounds to
//! either neighbour of the true result, division may be off by 2.5 units more or less, the square
//! root by 4.5.

use std::cell::Cell;
use std::ops::{Add, Div, Mul, Neg, Sub};

use kugelblitz::num::Real;

/// Where inexact results go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// To the nearest, as IEEE 754 has it.
    Nearest,
    /// To the upper neighbour.
    Up,
    /// To the lower neighbour.
    Down,
    /// To either neighbour, at random.
    Random,
    /// To either neighbour; division and square root anywhere within their tolerance.
    Wide,
    /// Up; division and square root as far up as their tolerance goes.
    WideUp,
    /// Down, as far.
    WideDown,
    /// To the neighbour that [`set_choices`] says.
    Chosen,
    /// To that side; division and square root as far as their tolerance goes.
    ChosenWide,
}

impl Rounding {
    pub const ALL: [Rounding; 7] = [
        Rounding::Nearest,
        Rounding::Up,
        Rounding::Down,
        Rounding::Random,
        Rounding::Wide,
        Rounding::WideUp,
        Rounding::WideDown,
    ];
}

thread_local! {
    static ROUNDING: Cell<Rounding> = const { Cell::new(Rounding::Nearest) };
    static STATE: Cell<u64> = const { Cell::new(1) };
}

/// Sets this thread's rounding, and the seed of its random choices.
pub fn set_rounding(rounding: Rounding, seed: u64) {
    ROUNDING.set(rounding);
    STATE.set(seed | 1);
}

/// Chooses this thread's roundings one by one: up for a 1, from the lowest bit on, and again after
/// 64 operations. With `wide`, division and square root go to the end of their tolerance.
pub fn set_choices(choices: u64, wide: bool) {
    ROUNDING.set(if wide { Rounding::ChosenWide } else { Rounding::Chosen });
    STATE.set(choices);
}

fn next_choice() -> bool {
    let choices = STATE.get();
    STATE.set(choices.rotate_right(1));
    choices & 1 == 1
}

fn random_bits() -> u64 {
    // Xorshift64 (Marsaglia 2003): quick, and good enough for coins.
    let mut x = STATE.get();
    x ^= x << 13;
    x ^= x >> 7;
    x ^= x << 17;
    STATE.set(x);
    x >> 16
}

/// Rounds a true result: `nearest`, and on which side of it the truth lies. `spare` whole units
/// are this operation's tolerance beyond a neighbour.
fn round(nearest: f32, truth_is: std::cmp::Ordering, spare: i32) -> f32 {
    let rounding = ROUNDING.get();
    let exact = truth_is.is_eq();
    let is_chosen = matches!(rounding, Rounding::Chosen | Rounding::ChosenWide);
    let goes_up = is_chosen && next_choice();
    let (below, above) = match truth_is {
        std::cmp::Ordering::Less => (nearest.next_down(), nearest),
        std::cmp::Ordering::Equal => (nearest, nearest),
        std::cmp::Ordering::Greater => (nearest, nearest.next_up()),
    };
    let faithful = match rounding {
        Rounding::Nearest => nearest,
        Rounding::Up | Rounding::WideUp => above,
        Rounding::Down | Rounding::WideDown => below,
        Rounding::Chosen | Rounding::ChosenWide => {
            if goes_up {
                above
            } else {
                below
            }
        }
        Rounding::Random | Rounding::Wide => {
            if random_bits() & 1 == 0 {
                below
            } else {
                above
            }
        }
    };
    let steps = match rounding {
        _ if spare == 0 || (exact && nearest == 0.0) => 0,
        Rounding::Wide => (random_bits() % (2 * spare as u64 + 1)) as i32 - spare,
        Rounding::WideUp => spare,
        Rounding::WideDown => -spare,
        Rounding::ChosenWide => {
            if goes_up {
                spare
            } else {
                -spare
            }
        }
        _ => 0,
    };
    (0..steps.abs()).fold(faithful, |x, _| if steps > 0 { x.next_up() } else { x.next_down() })
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
