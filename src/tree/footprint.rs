//! What a sphere may cover of a picture: whole pixels, so that looking for the spheres along a
//! pixel's ray compares integers, on every device alike.
//!
//! # Derivation
//! A point seen at `t` in the direction `f + x·R + y·T` is `t·(f + x·R + y·T)` from the eye. With
//! the reciprocal basis `g_f, g_R, g_T` of the frame (`g_f·f = 1`, `g_f·R = 0`, …) a point `p` has
//! `t = g_f·p` and `x = g_R·p / g_f·p`.
//!
//! The pairs `(g_f·p, g_R·p)` of the points of a sphere about `L` with radius `r` lie in the disc
//! about `(g_f·L, g_R·L)` with radius `σ·r`, where `σ²` is the largest eigenvalue of the two
//! vectors' Gram matrix, by Gershgorin at most `max(g_f², g_R²) + |g_f·g_R|`. So `x` lies between
//! the slopes of the tangents from the origin to that disc. These are its middle turned by `±φ`,
//! `sin φ = σr/D` with the middle's distance `D`; a tangent that leaves the half-plane `t > 0`
//! bounds nothing, nor do tangents where `D` is hardly above the radius.
//!
//! No point of the sphere has a smaller `t` than `g_f·L − r·|g_f|`.
//!
//! An orthographic camera sees `p` at `t = g_f·p` as well, but `x = g_R·p` needs no quotient: a sphere
//! lies between `g_R·L ± r·|g_R|`, and `2⁻³⁴(ℓ + r)` to spare is granted to both.
//!
//! # Rounding
//! In f64, with `ε = 2⁻⁵²` and a frame orthonormal to `2⁻¹⁰` ([`Pixels::is_in_range`]):
//! 1. The reciprocal basis is off by less than `4.5ε`, a product with `L`, which is rounded itself,
//!    by `8ε·ℓ`, `σ` by `12ε`.
//! 2. The radius is widened by `SPARE·(ℓ + r) = 2¹⁸ε(ℓ + r)`. So the disc holds the true one with
//!    nearly all of that to spare, however small `D` is against `ℓ`; and as `D < 1.01ℓ`, its
//!    tangents are turned outward by at least `2⁻³⁵` from the true ones. The bound of `t` has the
//!    same to spare.
//! 3. `D − ρ ≥ 2⁻¹⁰D` for the widened radius `ρ`, or nothing is bounded. So `T = √(D² − ρ²)` is off by
//!    less than `2¹⁰ε` of itself, and as `tan φ = ρ/T`, the tangents are turned by at most `ρT/D² <
//!    2⁻⁴·⁵` of that, with all other roundings by less than `2⁶ε = 2⁻⁴⁶`.
//! 4. A slope's quotient and its way to a column lose `4ε` of the column and of the picture's width,
//!    below `2⁻²⁰` pixel within the picture and next to it; `EDGE` is `2⁻¹⁰` pixel. Where `h/H`
//!    underflows, the whole picture is narrower than what the tangents are turned by.
//!
//! `SPARE` turns tangents `2¹¹` times as far as 3 asks for and `EDGE` is `2¹⁰` times what 4 does: half
//! of either is as right, and no ray shows it. Both are so small that hardly a footprint is a pixel
//! wider for them. Tests look at what is asked for, in exact arithmetic: the products of 1 and the
//! tangents of 3.

use glam::DVec3;

use crate::guard::round_down;
use crate::num::{Mask, Real, V3};
use crate::rays::{Lens, Pixels, View};

/// Part of a sphere's distance and radius that it is widened by: `2¹¹` times the need.
const SPARE: f64 = 1.0 / (1u64 << 34) as f64;

/// Part of a disc's distance below which its tangents bound nothing: half of it would make the need of
/// 3 larger by `√2`, still within `SPARE`, and no test sees it.
const GRAZING: f64 = 1.0 / (1u64 << 10) as f64;

/// What a footprint is widened by on each side before it is rounded to pixels, px: `2¹⁰` times the need, so
/// that no test sees it halved.
const EDGE: f64 = 1.0 / (1u64 << 10) as f64;

/// Most columns or rows of cells: 15 bits, without the one that [`Footprint::NONE`] is in.
const MOST_CELLS: u32 = (1 << 15) - 1;

/// The column and row of no cell.
pub(super) const NO_CELL: u16 = MOST_CELLS as u16;

/// A rectangle of cells that holds all pixels that may see a sphere, and a lower bound of its `t`.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Zeroable)]
pub struct Footprint {
    /// First and last column, cells.
    pub columns: [u16; 2],
    /// First and last row, cells.
    pub rows: [u16; 2],
    /// No pixel sees it nearer than this.
    pub t: f32,
}

impl Footprint {
    /// The footprint of what no pixel sees: it shares a cell with nothing, and changes no union.
    pub const NONE: Footprint =
        Footprint { columns: [NO_CELL, 0], rows: [NO_CELL, 0], t: f32::MAX };

    /// The smallest footprint that holds both.
    pub fn union(&self, other: &Footprint) -> Footprint {
        let hull = |[a, b]: [u16; 2], [c, d]: [u16; 2]| [a.min(c), b.max(d)];
        Footprint {
            columns: hull(self.columns, other.columns),
            rows: hull(self.rows, other.rows),
            t: self.t.min(other.t),
        }
    }
}

/// A picture that spheres are projected to.
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    /// `g_f`, `g_R`, `g_T`.
    depth: DVec3,
    across: DVec3,
    upward: DVec3,
    depth_length: f64,
    /// `σ` of columns and rows; for an orthographic camera `|g_R|` and `|g_T|`.
    stretch: [f64; 2],
    /// Half a pixel, at `t = 1`.
    step: f64,
    lens: Lens,
    width: u32,
    height: u32,
    cell_shift: u32,
}

impl Projection {
    /// The whole picture that `pixels` are part of. Its frame [`Pixels::is_in_range`].
    pub fn new(pixels: &Pixels) -> Projection {
        let View { forward, right, true_up, h, lens, .. } = pixels.view;
        let (width, height) = (pixels.image_width, pixels.image_height);
        let volume = forward.dot(right.cross(true_up));
        let depth = right.cross(true_up) / volume;
        let across = true_up.cross(forward) / volume;
        let upward = forward.cross(right) / volume;
        let stretch = [across, upward].map(|g: DVec3| match lens {
            Lens::Perspective => {
                (depth.length_squared().max(g.length_squared()) + depth.dot(g).abs()).sqrt()
            }
            Lens::Orthographic => g.length(),
        });
        let cells = |shift: u32| width.max(height).saturating_sub(1) >> shift;
        Projection {
            depth,
            across,
            upward,
            depth_length: depth.length(),
            stretch,
            step: h / f64::from(height),
            lens,
            width,
            height,
            cell_shift: (0..32).find(|&shift| cells(shift) < MOST_CELLS).unwrap_or(31),
        }
    }

    /// `g_f`: the vector whose product with an offset from the eye is its `t`.
    pub(crate) fn depth(&self) -> DVec3 {
        self.depth
    }

    /// A cell has `2^cell_shift` columns and rows of pixels: one but for huge pictures.
    pub fn cell_shift(&self) -> u32 {
        self.cell_shift
    }

    /// The footprint of the sphere at `l` from the eye with radius `r`; `None` where no pixel sees
    /// it.
    #[inline(always)]
    pub fn footprint(&self, l: DVec3, r: f64) -> Option<Footprint> {
        self.cells_of(&self.outline(V3(l.to_array()), r))
    }

    /// What spheres at `l` from the eye with radius `r` cover.
    #[inline(always)]
    pub(crate) fn outline<R: Real<One = f64>>(&self, l: V3<R>, r: R) -> Outline<R> {
        let depth = V3::lit(self.depth).dot(l);
        let across = V3::lit(self.across).dot(l);
        let upward = V3::lit(self.upward).dot(l);
        let spare = R::lit(SPARE) * (l.dot(l).sqrt() + r);
        let reach = r * R::lit(self.depth_length) + spare;
        let [radius_across, radius_upward] =
            [r * R::lit(self.stretch[0]) + spare, r * R::lit(self.stretch[1]) + spare];
        let [left, right, bottom, top] = match self.lens {
            Lens::Perspective => {
                let [left, right] = slopes(depth, across, radius_across);
                let [bottom, top] = slopes(depth, upward, radius_upward);
                [left, right, bottom, top]
            }
            Lens::Orthographic => [
                across - radius_across,
                across + radius_across,
                upward - radius_upward,
                upward + radius_upward,
            ],
        };
        let (step, two) = (R::lit(self.step), R::lit(2.0));
        let width = R::lit(f64::from(self.width) - 1.0);
        let height = R::lit(f64::from(self.height) - 1.0);
        Outline {
            columns: [(width + left / step) / two, (width + right / step) / two],
            rows: [(height - top / step) / two, (height - bottom / step) / two],
            t: (depth - reach).max(R::lit(0.0)),
            farthest: depth + reach,
        }
    }

    /// The cells of an outline; `None` where no pixel sees it.
    #[inline(always)]
    fn cells_of(&self, outline: &Outline<f64>) -> Option<Footprint> {
        let Outline { columns, rows, t, farthest } = *outline;
        let (columns, has_columns) = self.columns(columns[0], columns[1]);
        let (rows, has_rows) = self.rows(rows[0], rows[1]);
        let is_seen = has_columns & has_rows & (farthest > 0.0);
        is_seen.then(|| Footprint { columns, rows, t: round_down(t) })
    }

    /// First and last column of cells from `left` to `right`, and whether the picture has any.
    #[inline(always)]
    pub(crate) fn columns(&self, left: f64, right: f64) -> ([u16; 2], bool) {
        self.cells(left, right, self.width)
    }

    /// The same for rows.
    #[inline(always)]
    pub(crate) fn rows(&self, top: f64, bottom: f64) -> ([u16; 2], bool) {
        self.cells(top, bottom, self.height)
    }

    #[inline(always)]
    fn cells(&self, first: f64, last: f64, n: u32) -> ([u16; 2], bool) {
        // A bound that is NaN is none.
        let last_pixel = f64::from(n) - 1.0;
        let first = (first - EDGE).ceil().max(0.0);
        let last = (last + EDGE).floor().min(last_pixel);
        let cell = |pixel: f64| (whole(pixel.max(0.0).min(last_pixel)) >> self.cell_shift) as u16;
        ([cell(first), cell(last)], first <= last)
    }
}

/// A whole number below 2³² as such. Unlike `as`, it is done for several side by side on every processor.
#[inline(always)]
fn whole(number: f64) -> u32 {
    const ONES: f64 = (1u64 << 52) as f64;
    (number + ONES).to_bits() as u32
}

/// What a sphere covers of the picture's plane, px, and between which `t` it lies.
pub(crate) struct Outline<R> {
    pub columns: [R; 2],
    pub rows: [R; 2],
    pub t: R,
    pub farthest: R,
}

/// The least and the largest slope `b/a`, where `a > 0`, in the disc about `(a, b)`.
#[inline(always)]
fn slopes<R: Real<One = f64>>(a: R, b: R, radius: R) -> [R; 2] {
    let distance = (a * a + b * b).sqrt();
    let tangent = ((distance - radius) * (distance + radius)).sqrt();
    let is_bounded = (R::lit(GRAZING) * distance).lt(distance - radius);
    let [(first, has_first), (last, has_last)] =
        [slope(a, b, tangent, -radius), slope(a, b, tangent, radius)];
    [
        R::select(is_bounded.and(has_first), first, R::lit(f64::NEG_INFINITY)),
        R::select(is_bounded.and(has_last), last, R::lit(f64::INFINITY)),
    ]
}

/// The slope of a tangent, and whether it stays where `a > 0`.
#[inline(always)]
fn slope<R: Real<One = f64>>(a: R, b: R, tangent: R, radius: R) -> (R, R::Mask) {
    let turned = a * tangent - b * radius;
    ((b * tangent + a * radius) / turned, R::lit(0.0).lt(turned))
}

#[cfg(test)]
mod tests {
    use glam::dvec3;

    use super::*;
    use crate::exact::{Real, Root, real};
    use crate::random::SplitMix;

    fn exact(x: f64) -> Real {
        real(x).expect("a finite number")
    }

    fn to_f64(x: Real) -> f64 {
        Root::ratio(x, 1).to_f64()
    }

    fn volume(a: DVec3, b: DVec3, c: DVec3) -> Real {
        let [a, b, c] = [a, b, c].map(|v| v.to_array().map(exact));
        let minor = |i: usize, j: usize| &b[i] * &c[j] - &b[j] * &c[i];
        &a[0] * &minor(1, 2) + &a[1] * &minor(2, 0) + &a[2] * &minor(0, 1)
    }

    fn view(forward: DVec3, right: DVec3, true_up: DVec3, h: f64) -> View {
        let (position, lens) = (DVec3::ZERO, Lens::Perspective);
        View { position, forward, right, true_up, h, lens }
    }

    fn vector(random: &mut SplitMix) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| 2.0 * random.unit() - 1.0))
    }

    /// The coordinates of a point in the frame of a camera, by Cramer's rule.
    #[test]
    fn products_with_the_reciprocal_basis() {
        let mut random = SplitMix::new(1104);
        let mut worst = 0.0;
        for _ in 0..20_000 {
            let forward = vector(&mut random).normalize();
            let right = forward.cross(vector(&mut random)).normalize();
            let off = 2f64.powf(-11.0 - 42.0 * random.unit());
            let [forward, right, true_up] =
                [forward, right, right.cross(forward)].map(|v| v + off * vector(&mut random));
            let view = view(forward, right, true_up, 0.5);
            let pixels = Pixels::whole(view, 64, 48);
            if !pixels.is_in_range() {
                continue;
            }
            let Projection { depth, across, upward, .. } = Projection::new(&pixels);
            let l = vector(&mut random) * 2f64.powf(20.0 * random.unit() - 10.0);
            let whole = volume(forward, right, true_up);
            for (g, numerator) in [
                (depth, volume(l, right, true_up)),
                (across, volume(forward, l, true_up)),
                (upward, volume(forward, right, l)),
            ] {
                let error = to_f64(exact(g.dot(l)) * &whole - numerator) / to_f64(whole.clone());
                worst = f64::max(worst, error.abs() / (8.0 * f64::EPSILON * l.length()));
            }
        }
        println!("products: {worst:.3} of the bound");
        assert!(worst <= 1.0 && worst > 0.05, "{worst}");
    }

    /// How far a tangent is turned, from its distance to the middle of the disc.
    #[test]
    fn tangents_of_discs() {
        let mut random = SplitMix::new(1105);
        let mut worst: f64 = 0.0;
        for _ in 0..200_000 {
            let (a, b) = (vector(&mut random).x, vector(&mut random).x);
            let distance = (a * a + b * b).sqrt();
            // Small, any, and nearly as large as the distance.
            let part = match random.next() % 3 {
                0 => 2f64.powf(-30.0 * random.unit()),
                1 => random.unit(),
                _ => 1.0 - GRAZING * (1.0 + random.unit()),
            };
            let radius = distance * part;
            if distance - radius <= GRAZING * distance {
                continue;
            }
            for slope in slopes(a, b, radius).into_iter().filter(|slope| slope.is_finite()) {
                let [x, a, b, r] = [slope, a, b, radius].map(exact);
                let aside = &b - &x * &a;
                let length2 = exact(1.0) + &x * &x;
                let error = to_f64(&aside * &aside - &r * &r * &length2);
                let off = error / (2.0 * radius * to_f64(length2));
                let turned = off / ((distance - radius) * (distance + radius)).sqrt();
                // The slope's own rounding is item 4's.
                let turned = turned.abs() - 2.0 * f64::EPSILON;
                worst = worst.max(turned / 2f64.powi(-46));
            }
        }
        println!("tangents: {worst:.3} of the bound");
        assert!(worst <= 1.0 && worst > 0.05, "{worst}");
        // What the disc is widened by turns them 2¹¹ times as far.
        assert!(SPARE / 2.0 >= 2048.0 * 2f64.powi(-46));
    }

    /// A point at the pixel's very centre belongs to the pixel.
    #[test]
    fn cells_at_the_centre_of_a_pixel() {
        let frame = [DVec3::NEG_Z, DVec3::X, DVec3::Y];
        let [forward, right, true_up] = frame;
        let view = view(forward, right, true_up, 0.3);
        let projection = Projection::new(&Pixels::whole(view, 7, 5));
        let footprint = projection.footprint(dvec3(0.0, 0.0, -4.0), 1e-9).expect("it is seen");
        assert_eq!((footprint.columns, footprint.rows), ([3, 3], [2, 2]));
    }
}
