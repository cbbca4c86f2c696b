//! Bounds of inputs, in arithmetic as bad as they grant.

pub mod worst;

use self::worst::{UNIT, Worst, assert_tight, worst};
use super::host::{HOST_UNIT_F64, input_in_f64};
use super::*;
use glam::DVec3;

fn vector(x: &[f64]) -> V3<f64> {
    V3([x[0], x[1], x[2]])
}

fn length(v: V3<f64>) -> f64 {
    v.dot(v).sqrt()
}

/// A vector whose components are off by so many units each.
fn rounded(v: V3<f64>, units: f64) -> V3<Worst> {
    V3(v.0.map(|x| Worst::off(x, units)))
}

fn exact(v: V3<Worst>) -> V3<f64> {
    V3(v.0.map(|x| x.0))
}

/// A pixel's `iR` and `jT`, which are across from each other, and `f` of length 1.
fn frame(x: &[f64]) -> [V3<f64>; 3] {
    let forward = DVec3::from_slice(x).normalize();
    let right = forward.cross(DVec3::from_slice(&x[3..])).normalize();
    [forward, right * x[6], right.cross(forward) * x[7]].map(|v| V3(v.to_array()))
}

#[test]
fn rays_of_pixels_are_within_their_errors() {
    let f64 = |lens| input_in_f64(Some(lens));
    let [eye, sun] = [Lens::Perspective, Lens::Orthographic];
    // What the view axis and a centre are off by, and a step, before a pixel's numbers are calculated.
    for (name, directions, offsets, of_axis, of_center, of_step) in [
        ("f32", PIXELS.direction, PARALLEL.offset, 0.5, 0.5, 0.5),
        ("f64", f64(eye).direction, f64(sun).offset, 0.0, 1.0, 2.0),
    ] {
        let found = worst(|x: [f64; 8]| {
            let [forward, right, up] = frame(&x);
            let [across, upward] = [right, up].map(|v| rounded(exact(rounded(v, of_step)), 1.0));
            let found = exact((rounded(forward, of_axis) + across) + upward);
            let direction = forward + right + up;
            length(found - direction) / (UNIT * length(direction))
        });
        assert_tight(&format!("direction, {name}"), directions, found);
        let found = worst(|x: [f64; 11]| {
            let ([_, right, up], center) = (frame(&x), vector(&x[8..]));
            let [across, upward] = [right, up].map(|v| rounded(exact(rounded(v, of_step)), 1.0));
            let found = exact(rounded(center, of_center) - (across + upward));
            let origin = right + up;
            length(found - (center - origin)) / (UNIT * (length(center) + length(origin)))
        });
        assert_tight(&format!("offset, {name}"), offsets, found);
    }
    let found = worst(|x: [f64; 12]| {
        let ([_, right, up], center, scale) = (frame(&x), vector(&x[8..]), x[11]);
        let [across, upward] = [right, up].map(|v| rounded(exact(rounded(v, 0.5)), 1.0));
        let found = exact(rounded(center, 0.5) - (across + upward) * Worst::off(scale, 0.5));
        let origin = (right + up) * scale;
        length(found - (center - origin)) / (UNIT * (length(center) + length(origin)))
    });
    assert_tight("offset from an anchor", ANCHORED, found);
    let once = worst(|x: [f64; 3]| {
        let v = vector(&x);
        length(exact(rounded(v, 1.0)) - v) / (UNIT * length(v))
    });
    let inputs = [f64(eye).offset, input_in_f64(None).offset];
    inputs.into_iter().for_each(|input| assert_tight("rounded once", input, once));
    // From f64.
    assert_tight("parallel direction", PARALLEL.direction, once / 2.0);
    let found = worst(|x: [f64; 6]| {
        let [center, origin] = [vector(&x), vector(&x[3..])];
        let found = rounded(center, 0.5) - rounded(origin, 0.5);
        length(exact(found) - (center - origin)) / (UNIT * (length(center) + length(origin)))
    });
    assert_tight("offset of lists", LIST.offset, found);
}

/// `k` and `N` in f64, `N` for faithful rounding, the units of which are half of those of `k`.
#[test]
fn offsets_are_within_their_errors() {
    let found = worst(|x: [f64; 4]| {
        let (l, r) = (rounded(vector(&x), 1.0), Worst(x[3]));
        let (l2, r2) = (vector(&x).dot(vector(&x)), x[3] * x[3]);
        ((l.dot(l) - r * r).0 - (l2 - r2)).abs() / (UNIT * (l2 + r2))
    });
    assert_tight("K_ERROR", 2.0 * K_ERROR, found);
    let found = worst(|x: [f64; 6]| {
        let (n, l) = (vector(&x), vector(&x[3..]));
        let found = V3(n.0.map(Worst)).dot(rounded(l, 1.0)).0;
        (found - n.dot(l)).abs() / (ROOM * UNIT * length(n) * length(l))
    });
    assert_tight("N_ERROR", N_ERROR, found);
}

#[test]
fn the_host_rounds_by_its_unit() {
    let of_product = worst(|[x, y]| (x.mul_add(y, -(x * y)) / (x * y)).abs());
    assert_tight("f64", 1.0, of_product / HOST_UNIT_F64);
    let of_number = worst(|[x, y]| (f64::from((x + y) as f32) / (x + y) - 1.0).abs());
    assert_tight("from f64", f32::ROUNDED, of_number / f32::UNIT);
}

#[test]
fn lengths_are_close_to_their_bounds() {
    assert_tight("tiny", length_bound(DVec3::splat(1e-100)) * 1e100, 3f64.sqrt());
    for (lens, name) in [(Lens::Perspective, "direction"), (Lens::Orthographic, "origin")] {
        let axes = [DVec3::ZERO, DVec3::NEG_Z, DVec3::X, DVec3::Y];
        let [position, forward, right, true_up] = axes;
        let view = View { position, forward, right, true_up, h: 3.0, lens };
        let pixels = Pixels::whole(view, 200, 100);
        let (bound, corner) = match lens {
            Lens::Perspective => (pixels.longest_direction(), pixels.direction(0, 0)),
            Lens::Orthographic => (pixels.spread(), pixels.origin_offset(0, 0)),
        };
        assert_tight(name, bound, corner.length());
    }
}
