//! Searches for the largest error of a step, in arithmetic as bad as its bound grants.

use std::cell::Cell;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::num::{Float, Real};
use crate::support::random::SplitMix;

thread_local! {
    static CHOICES: Cell<u64> = const { Cell::new(0) };
}

/// The unit of [`Worst`].
pub const UNIT: f64 = f32::UNIT;

/// A number of f32 whose operations are all off by as much as the table in [`crate::bounds`] allows: up or down, as a search
/// chooses one by one.
#[derive(Clone, Copy, Debug)]
pub struct Worst(pub f64);

impl Worst {
    /// A number that is off by so many units.
    pub fn off(exact: f64, units: f64) -> Worst {
        let choices = CHOICES.get();
        CHOICES.set(choices.rotate_right(1));
        Worst(exact * (1.0 + UNIT * if choices.is_multiple_of(2) { units } else { -units }))
    }
}

macro_rules! worst {
    ($($trait:ident $function:ident $sign:tt $units:literal $is_exact:expr),*) => {$(
        impl $trait for Worst {
            type Output = Worst;
            fn $function(self, other: Worst) -> Worst {
                let exact = self.0 $sign other.0;
                let is_exact: fn(f64, f64) -> bool = $is_exact;
                if is_exact(self.0, other.0) { Worst(exact) } else { Worst::off(exact, $units) }
            }
        }
    )*};
}

worst!(Add add + 1.0 |x, y| x == 0.0 || y == 0.0, Sub sub - 1.0 |x, y| x == 0.0 || y == 0.0,
    Mul mul * 1.0 |x, y| x.abs() == 1.0 || y.abs() == 1.0, Div div / 2.5 |_, y| y == 1.0);

impl Neg for Worst {
    type Output = Worst;
    fn neg(self) -> Worst {
        Worst(-self.0)
    }
}

impl Real for Worst {
    type One = f32;
    type Mask = bool;
    type Id = u32;
    fn splat(x: f32) -> Worst {
        Worst(x.into())
    }
    fn splat_id(id: u32) -> u32 {
        id
    }
    fn sqrt(self) -> Worst {
        Worst::off(self.0.sqrt(), 4.5)
    }
    fn abs(self) -> Worst {
        Worst(self.0.abs())
    }
    fn lt(self, other: Worst) -> bool {
        self.0 < other.0
    }
    fn le(self, other: Worst) -> bool {
        self.0 <= other.0
    }
    fn select(mask: bool, yes: Worst, no: Worst) -> Worst {
        if mask { yes } else { no }
    }
    fn select_id(mask: bool, yes: u32, no: u32) -> u32 {
        if mask { yes } else { no }
    }
}

/// A number of any sign and of sizes over some decades.
fn any(random: &mut SplitMix) -> f64 {
    let sign = if random.bits().is_multiple_of(2) { 1.0 } else { -1.0 };
    sign * (20.0 * random.unit() - 10.0).exp2()
}

/// The largest of what `needed` says of `N` numbers, as found by climbs from many starts. What is not a number counts
/// for nothing.
pub fn worst<const N: usize>(needed: impl Fn([f64; N]) -> f64) -> f64 {
    let climb = |start: u64| {
        let mut random = SplitMix::new(start);
        let (mut most, mut best, mut best_choices) = (f64::NEG_INFINITY, [1.0; N], 0);
        for step in 0..6000 {
            let (mut numbers, mut choices) = (best, best_choices);
            if step < 500 {
                (numbers, choices) = (std::array::from_fn(|_| any(&mut random)), random.bits());
            }
            for _ in 0..=random.bits() % 3 {
                let x = &mut numbers[random.bits() as usize % N];
                match random.bits() % 6 {
                    0 => *x = any(&mut random),
                    1 => *x = -*x,
                    2 => *x *= 1.0 + 0.2 * (random.unit() - 0.5),
                    3 => *x *= 1.0 + 64.0 * UNIT * (random.unit() - 0.5),
                    _ => choices ^= 1 << (random.bits() % 64),
                }
            }
            CHOICES.set(choices);
            let found = needed(numbers);
            if found >= most {
                (most, best, best_choices) = (found, numbers, choices);
            }
        }
        most
    };
    (0..16).map(climb).fold(f64::NEG_INFINITY, f64::max)
}

/// A constant, with its name, is enough for what is found, and half of it is not.
pub fn assert_tight(name: &str, constant: f64, found: f64) {
    println!("{name}: {found:.3} of {constant}");
    assert!(found <= constant && found > constant / 2.0, "{name}: {found} of {constant}");
}
