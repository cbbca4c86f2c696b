//! f32 of devices: as bad as theirs may be, and finite.

use std::cell::Cell;
use std::ops::{Add, Div, Mul, Neg, Sub};

use crate::num::{Float, Real};
use crate::support::random::SplitMix;

/// An f32 of a bad device: each operation is off by as much as the table in [`crate::bounds`] allows, either way.
#[derive(Clone, Copy, Debug)]
pub struct Shaky(pub f32);

thread_local! {
    static SHAKE: Cell<u64> = const { Cell::new(1) };
}

impl Shaky {
    fn off(x: f64, units: f64) -> Shaky {
        let mut random = SplitMix::new(SHAKE.get());
        let sign = if random.bits().is_multiple_of(2) { 1.0 } else { -1.0 };
        let x = x * (1.0 + sign * units * f32::UNIT);
        let is_up = random.bits().is_multiple_of(2);
        SHAKE.set(random.bits());
        Shaky(if is_up { f32::up(x) } else { f32::down(x) })
    }
}

macro_rules! shaky {
    ($($trait:ident $function:ident $sign:tt $units:literal),*) => {$(
        impl $trait for Shaky {
            type Output = Shaky;
            fn $function(self, other: Shaky) -> Shaky {
                Shaky::off(f64::from(self.0) $sign f64::from(other.0), $units)
            }
        }
    )*};
}

shaky!(Add add + 0.0, Sub sub - 0.0, Mul mul * 0.0, Div div / 1.5);

impl Neg for Shaky {
    type Output = Shaky;
    fn neg(self) -> Shaky {
        Shaky(-self.0)
    }
}

impl Real for Shaky {
    type One = f32;
    type Mask = bool;
    type Id = u32;
    fn splat(x: f32) -> Shaky {
        Shaky(x)
    }
    fn splat_id(id: u32) -> u32 {
        id
    }
    fn sqrt(self) -> Shaky {
        Shaky::off(f64::from(self.0).sqrt(), 3.5)
    }
    fn abs(self) -> Shaky {
        Shaky(self.0.abs())
    }
    fn lt(self, other: Shaky) -> bool {
        self.0 < other.0
    }
    fn le(self, other: Shaky) -> bool {
        self.0 <= other.0
    }
    fn select(mask: bool, yes: Shaky, no: Shaky) -> Shaky {
        if mask { yes } else { no }
    }
    fn select_id(mask: bool, yes: u32, no: u32) -> u32 {
        if mask { yes } else { no }
    }
}

/// f32 that keeps to the finite numbers, as a device must: [`crate::bounds`] says why.
#[derive(Clone, Copy, Debug)]
pub struct Finite(pub f32);

impl Finite {
    #[inline(never)]
    fn of(x: f32) -> Finite {
        assert!(x.is_finite(), "{x}");
        Finite(x)
    }
}

macro_rules! finite {
    ($($trait:ident $function:ident $sign:tt),*) => {$(
        impl $trait for Finite {
            type Output = Finite;
            fn $function(self, other: Finite) -> Finite {
                Finite::of(self.0 $sign other.0)
            }
        }
    )*};
}

finite!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Neg for Finite {
    type Output = Finite;
    fn neg(self) -> Finite {
        Finite(-self.0)
    }
}

impl Real for Finite {
    type One = f32;
    type Mask = bool;
    type Id = u32;
    fn splat(x: f32) -> Finite {
        Finite::of(x)
    }
    fn splat_id(id: u32) -> u32 {
        id
    }
    fn sqrt(self) -> Finite {
        Finite::of(self.0.sqrt())
    }
    fn abs(self) -> Finite {
        Finite(self.0.abs())
    }
    fn lt(self, other: Finite) -> bool {
        self.0 < other.0
    }
    fn le(self, other: Finite) -> bool {
        self.0 <= other.0
    }
    fn select(mask: bool, yes: Finite, no: Finite) -> Finite {
        if mask { yes } else { no }
    }
    fn select_id(mask: bool, yes: u32, no: u32) -> u32 {
        if mask { yes } else { no }
    }
}
