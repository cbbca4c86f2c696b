//! A second opinion on the exact module: rationals of another make, and other ways.
//!
//! It knows no discriminant and no square root. An object is its polynomial `F(t)`, found from
//! the values of the defining equation at −1, 0 and 1; a root is what separates the `t` before it
//! from the `t` after it, by the signs of `F` and `F'`; numbers are found by bisection; and two
//! roots are equal if their polynomials have a common root there.

use std::cmp::Ordering;

use glam::DVec3;
use kugelblitz::exact::Shape;
use kugelblitz::rays::{Lens, Pixels};
use kugelblitz::trace::Ray;
use num_bigint::BigInt;
use num_rational::BigRational;
use num_traits::{One, Signed, Zero};

pub type Q = BigRational;

/// Exact value of a finite f64.
pub fn q(x: f64) -> Q {
    Q::from_float(x).expect("finite")
}

fn int(x: i64) -> Q {
    Q::from_integer(x.into())
}

fn q3(v: DVec3) -> [Q; 3] {
    [q(v.x), q(v.y), q(v.z)]
}

fn dot(u: &[Q; 3], v: &[Q; 3]) -> Q {
    &u[0] * &v[0] + &u[1] * &v[1] + &u[2] * &v[2]
}

/// A ray in rationals.
#[derive(Clone, Debug)]
pub struct OracleRay {
    pub origin: [Q; 3],
    pub direction: [Q; 3],
}

impl OracleRay {
    pub fn new(ray: &Ray) -> OracleRay {
        OracleRay { origin: q3(ray.origin), direction: q3(ray.direction) }
    }

    /// The contract's centre ray, letter by letter.
    pub fn from_pixel(pixels: &Pixels, x: u32, y: u32) -> OracleRay {
        let view = &pixels.view;
        let (w, h) = (int(pixels.image_width.into()), int(pixels.image_height.into()));
        let half = Q::new(1.into(), 2.into());
        let (x, y) = (int(x.into()) + &half, int(y.into()) + &half);
        let right = (int(2) * x / &w - int(1)) * q(view.h) * (&w / &h);
        let up = (int(1) - int(2) * y / &h) * q(view.h);
        let (o, f) = (q3(view.position), q3(view.forward));
        let (r, u) = (q3(view.right), q3(view.true_up));
        let moved = |v: &[Q; 3]| std::array::from_fn(|i| &v[i] + &right * &r[i] + &up * &u[i]);
        match view.lens {
            Lens::Perspective => OracleRay { direction: moved(&f), origin: o },
            Lens::Orthographic => OracleRay { origin: moved(&o), direction: f },
        }
    }

    pub fn at(&self, t: &Q) -> [Q; 3] {
        std::array::from_fn(|i| &self.origin[i] + t * &self.direction[i])
    }
}

/// The value of the equation that defines the object, at a point.
fn equation(shape: &Shape, p: &[Q; 3]) -> Q {
    match *shape {
        Shape::Sphere { center, radius } => {
            let c = q3(center);
            let v: [Q; 3] = std::array::from_fn(|i| &p[i] - &c[i]);
            dot(&v, &v) - q(radius) * q(radius)
        }
        Shape::Plane { point, normal } => {
            let a = q3(point);
            let v: [Q; 3] = std::array::from_fn(|i| &p[i] - &a[i]);
            dot(&v, &q3(normal))
        }
    }
}

/// The smallest positive root of `F(t) = c2·t² + c1·t + c0`.
#[derive(Clone, Debug)]
pub struct OracleRoot {
    coefficients: [Q; 3],
    /// The same times a positive number, as integers.
    integers: [BigInt; 3],
    /// F below the root has this sign (down to 0).
    sign_before: i32,
    /// Whether the root lies on the falling half of the parabola (or at its lowest point).
    falling: bool,
}

fn sgn(x: &BigInt) -> i32 {
    if x.is_negative() { -1 } else { i32::from(x.is_positive()) }
}

impl OracleRoot {
    pub fn visible(ray: &OracleRay, shape: &Shape) -> Option<OracleRoot> {
        if let Shape::Sphere { radius: 0.0, .. } = shape {
            return None;
        }
        let [before, here, after] = [-1, 0, 1].map(|t| equation(shape, &ray.at(&int(t))));
        let c2 = (&after + &before) / int(2) - &here;
        let c1 = (&after - &before) / int(2);
        let c0 = here;
        if c2.is_zero() && c1.is_zero() {
            return None;
        }
        let falling = if c2.is_zero() {
            let t = -&c0 / &c1;
            if !t.is_positive() {
                return None;
            }
            false
        } else if c0.is_negative() {
            false
        } else if c0.is_zero() {
            if !c1.is_negative() {
                return None;
            }
            false
        } else {
            let lowest = -&c1 / (int(2) * &c2);
            if !lowest.is_positive() || ((&c2 * &lowest + &c1) * &lowest + &c0).is_positive() {
                return None;
            }
            true
        };
        // The common denominator; all denominators are positive.
        let scale = c2.denom() * c1.denom() * c0.denom();
        let integers = [&c0, &c1, &c2].map(|c| c.numer() * (&scale / c.denom()));
        let sign_before = if c2.is_zero() {
            -sgn(&integers[1])
        } else if falling {
            1
        } else {
            -1
        };
        Some(OracleRoot { coefficients: [c0, c1, c2], integers, sign_before, falling })
    }

    /// The order of the root and a positive rational `n/m`.
    pub fn cmp_rational(&self, x: &Q) -> Ordering {
        let (n, m) = (x.numer(), x.denom());
        let [c0, c1, c2] = &self.integers;
        let f = sgn(&((c2 * n + c1 * m) * n + c0 * m * m));
        let slope = sgn(&(c2 * n * BigInt::from(2) + c1 * m));
        if c2.is_zero() {
            return (f * self.sign_before).cmp(&0);
        }
        if self.falling {
            // Positive and falling: before the root. Beyond the lowest point: behind it.
            match (f, slope) {
                (0, s) if s <= 0 => Ordering::Equal,
                (1, -1) => Ordering::Greater,
                _ => Ordering::Less,
            }
        } else {
            // x > 0 and F(0) ≤ 0: below zero until the root.
            (-f).cmp(&0)
        }
    }

    /// The exponent `e` with `2^e ≤ root < 2^(e+1)`.
    fn exponent(&self) -> i64 {
        let (mut low, mut high) = (-20_000i64, 20_000i64);
        while low < high {
            let middle = (low + high + 1).div_euclid(2);
            if self.cmp_rational(&power(middle)) == Ordering::Less {
                high = middle - 1;
            } else {
                low = middle;
            }
        }
        low
    }

    /// A lower neighbour within a relative `2^-bits`.
    pub fn below(&self, bits: u32) -> Q {
        let mut low = power(self.exponent());
        let mut step = low.clone();
        for _ in 0..bits {
            step /= int(2);
            let middle = &low + &step;
            if self.cmp_rational(&middle) != Ordering::Less {
                low = middle;
            }
        }
        low
    }

    fn equals(&self, other: &OracleRoot) -> bool {
        let [c0, c1, c2] = &self.coefficients;
        let [e0, e1, e2] = &other.coefficients;
        // Clear the square: what remains is linear, and a common root is a root of it.
        let linear = c1 * e2 - e1 * c2;
        let constant = c0 * e2 - e0 * c2;
        if c2.is_zero() || e2.is_zero() {
            let x = if c2.is_zero() { -c0 / c1 } else { -e0 / e1 };
            return self.cmp_rational(&x).is_eq() && other.cmp_rational(&x).is_eq();
        }
        if linear.is_zero() {
            return constant.is_zero() && self.falling == other.falling;
        }
        let x = -constant / linear;
        x.is_positive() && self.cmp_rational(&x).is_eq() && other.cmp_rational(&x).is_eq()
    }

    pub fn compare(&self, other: &OracleRoot) -> Ordering {
        if self.equals(other) {
            return Ordering::Equal;
        }
        let exponents = self.exponent().cmp(&other.exponent());
        if exponents.is_ne() {
            return exponents;
        }
        let mut low = power(self.exponent());
        let mut step = low.clone();
        loop {
            step /= int(2);
            let middle = &low + &step;
            let (a, b) = (self.cmp_rational(&middle), other.cmp_rational(&middle));
            match a.cmp(&b) {
                Ordering::Equal if a.is_lt() => {}
                Ordering::Equal => low = middle,
                apart => return apart,
            }
        }
    }

    /// Nearest f32, ties to even; infinite beyond the largest.
    pub fn to_f32(&self) -> f32 {
        let value = |bits: u32| match f32::from_bits(bits) {
            f if f.is_infinite() => 2f64.powi(128),
            f => f64::from(f),
        };
        let (mut low, mut high) = (0u32, f32::INFINITY.to_bits());
        while low < high {
            let middle = low + (high - low) / 2;
            // Exact in f64: 25 bits, exponent −150 at the lowest.
            let midpoint = (value(middle) + value(middle + 1)) / 2.0;
            let rounds_up = match self.cmp_rational(&q(midpoint)) {
                Ordering::Less => false,
                Ordering::Equal => middle % 2 == 1,
                Ordering::Greater => true,
            };
            if rounds_up {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        f32::from_bits(low)
    }
}

pub fn power(exponent: i64) -> Q {
    let two = BigInt::one() << exponent.unsigned_abs();
    if exponent < 0 { Q::new_raw(BigInt::one(), two) } else { Q::from_integer(two) }
}

/// The visible object: id and `t` by the contract.
pub fn nearest(ray: &OracleRay, objects: &[(u32, Shape)]) -> Option<(u32, OracleRoot)> {
    let mut best: Option<(u32, OracleRoot)> = None;
    for (id, shape) in objects {
        let Some(root) = OracleRoot::visible(ray, shape) else {
            continue;
        };
        let wins = match &best {
            None => true,
            Some((best_id, best_root)) => match root.compare(best_root) {
                Ordering::Less => true,
                Ordering::Equal => id < best_id,
                Ordering::Greater => false,
            },
        };
        if wins {
            best = Some((*id, root));
        }
    }
    best.filter(|(_, root)| root.to_f32().is_finite())
}

/// Whether `component` is the f32 next to `value`, give or take `2^-200`.
pub fn is_nearest_f32(component: f32, value: &Q) -> bool {
    let neighbours = [component.next_down(), component.next_up()];
    let slack = power(-200);
    let here = (q(component.into()) - value).abs();
    neighbours.iter().all(|&n| here <= (q(n.into()) - value).abs() + &slack)
}
