//! Scalars and vectors that the kernels are generic over. Twin of `shaders/vec.wgsl`.

use std::ops::{Add, Div, Mul, MulAssign, Neg, Sub};

/// What sums and products can be made of: a number, or several side by side. Each operation is one
/// correctly rounded operation.
pub trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
}

/// f32 or f64, with the operations that the kernels use. Each is one correctly rounded operation.
pub trait Real: Number + PartialOrd + MulAssign + Send + Sync {
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// 2.
    const TWO: Self;
    /// 4.
    const FOUR: Self;
    /// +∞.
    const INFINITY: Self;
    /// The largest finite number.
    const LARGEST: Self;
    /// A number that is small for the filter: its inverse is far below [`Real::LARGEST`].
    const SMALL: Self;
    /// The nearest number.
    fn from_f64(x: f64) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// The smaller of two numbers.
    fn min(self, other: Self) -> Self;
    /// The larger of two numbers.
    fn max(self, other: Self) -> Self;
}

macro_rules! real {
    ($float:ident, $small:expr) => {
        impl Number for $float {}

        impl Real for $float {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const TWO: Self = 2.0;
            const FOUR: Self = 4.0;
            const INFINITY: Self = $float::INFINITY;
            const LARGEST: Self = $float::MAX;
            const SMALL: Self = $small;
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                x as $float
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $float::sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $float::abs(self)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if other < self { other } else { self }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if other > self { other } else { self }
            }
        }
    };
}
real!(f32, 1.0 / (1u128 << 100) as f32);
real!(f64, 1.0 / (1u128 << 100) as f64);

/// The largest f32 not above `x`.
#[inline(always)]
pub fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// The smallest f32 not below `x`.
#[inline(always)]
pub fn round_up(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) < x { nearest.next_up() } else { nearest }
}

/// Three components.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vec3<R>(pub [R; 3]);

impl<R: Real> Vec3<R> {
    /// The zero vector.
    pub const ZERO: Self = Vec3([R::ZERO; 3]);
}

impl<R: Number> Vec3<R> {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(R, R) -> R) -> Self {
        Vec3([f(self.0[0], other.0[0]), f(self.0[1], other.0[1]), f(self.0[2], other.0[2])])
    }
}

impl<R: Number> Add for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<R: Number> Sub for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<R: Number> Mul<R> for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, scale: R) -> Self {
        self.zip(self, |a, _| a * scale)
    }
}

impl<R: Number> Neg for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.zip(self, |a, _| -a)
    }
}

impl From<glam::DVec3> for Vec3<f32> {
    fn from(v: glam::DVec3) -> Self {
        Vec3(v.as_vec3().to_array())
    }
}

impl From<glam::DVec3> for Vec3<f64> {
    fn from(v: glam::DVec3) -> Self {
        Vec3(v.to_array())
    }
}

/// `a·b`, summed from left to right on every device: WGSL's `dot` leaves the order open.
#[inline(always)]
pub fn dot3<R: Number>(a: Vec3<R>, b: Vec3<R>) -> R {
    a.0[0] * b.0[0] + a.0[1] * b.0[1] + a.0[2] * b.0[2]
}

/// `v / ‖v‖`, turned so that it faces against `direction`.
#[inline(always)]
pub fn facing<R: Real>(v: Vec3<R>, direction: Vec3<R>) -> Vec3<R> {
    let unit = v * (R::ONE / dot3(v, v).sqrt());
    if dot3(unit, direction) > R::ZERO { -unit } else { unit }
}
