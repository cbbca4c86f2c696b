// Twin of src/gpu/before/beam.rs, where the bounds are derived. BEYOND stands for ∞. In f32, narrow.wgsl looks at objects.

// The way from a point to a lamp.
struct Beam {
    start: Vec3,
    way: Vec3,
    square: Real,
    // Of the way, and its inverse; 1 for no way at all.
    length: Real,
    inverse_length: Real,
    error: Real,
    is_endless: bool,
    turned: Real,
}

// Bounds of a number.
struct Bounds {
    low: Real,
    high: Real,
}

fn beam_from(start: Vec3, way: Vec3, error: Real, turned: Real) -> Beam {
    let square = dot3(way, way);
    let length = sqrt(select(1.0, square, square > 0.0));
    return Beam(start, way, square, length, 1.0 / length, error, false, turned);
}

fn to_point(start: Vec3, error: Real, position: Vec3) -> Beam {
    var beam = beam_from(start, position - start, 0.0, 0.0);
    let distance = select(0.0, beam.length, beam.square > 0.0);
    let far = max(max(abs(position.x), abs(position.y)), abs(position.z));
    let off = error + UNIT * (OF_PLACE * far + distance);
    let is_apart = (distance > 4.0 * off) & (distance > NEGLIGIBLE) & (distance < BEYOND);
    beam.error = select(BEYOND, off + OF_WAY * UNIT * distance, is_apart);
    beam.turned = select(BEYOND, OF_TURN * off * beam.inverse_length, is_apart);
    return beam;
}

fn to_eye(start: Vec3, direction: Vec3, turned: Real) -> Beam {
    return beam_from(start, -direction, 0.0, 2.0 * turned);
}

fn to_sun(start: Vec3, error: Real, direction: Vec3) -> Beam {
    var beam = beam_from(start, -direction, error, 0.0);
    beam.is_endless = true;
    return beam;
}

// Bounds of n·ω. Both are 0 where it is certain not to be positive.
fn cosine(beam: Beam, normal: Vec3, normal_error: Real) -> Bounds {
    let cosine = dot3(normal, beam.way) * beam.inverse_length;
    let error = ROOM * (normal_error + beam.turned) + OF_COSINE * UNIT;
    let low = cosine - error;
    let high = cosine + error;
    return Bounds(select(0.0, low, low > 0.0), select(0.0, min(high, 1.0), high > 0.0));
}

//#if double
fn length_of(v: Vec3) -> Real {
    return max(sqrt(dot3(v, v)), NEGLIGIBLE);
}

//#if of_scene
// NO, OPEN or YES: the largest of several wins.
fn meets_sphere(beam: Beam, center: Vec3, r: f64) -> u32 {
    let l = center - beam.start;
    let l2 = dot3(l, l);
    let far = max(max(abs(center.x), abs(center.y)), abs(center.z));
    let inverse = 1.0 / select(1.0, beam.square, beam.square > 0.0);
    let ahead = max(dot3(l, beam.way) * inverse, 0.0);
    let foot = select(min(ahead, 1.0), ahead, beam.is_endless);
    let q = l - beam.way * foot;
    let e = beam.error + UNIT * (OF_PLACE * far + OF_OFFSET * sqrt(l2));
    let least2 = dot3(q, q);
    let inner = r - e;
    let outer = r + e;
    let inner2 = select(-1.0, inner * inner * (1.0 - RELATIVE), inner > 0.0);
    let outer2 = outer * outer * (1.0 + RELATIVE);
    let end = l - beam.way;
    let end2 = dot3(end, end);
    let ends_inside = !beam.is_endless & (end2 < inner2);
    let ends_outside = beam.is_endless | (end2 > outer2);
    let in_range = (l2 < BEYOND) & (r < BEYOND) & (r > NEGLIGIBLE) & (e < BEYOND);
    let is_clear = (least2 > outer2) | ((l2 < inner2) & ends_inside);
    let is_crossed = (least2 < inner2) & ((l2 > outer2) | ends_outside);
    let known = select(select(OPEN, YES, is_crossed), NO, is_clear);
    return select(OPEN, known, in_range);
}
//#end

//#if of_scene
// The same of a beam that starts on another sphere.
fn meets_shell(
    beam: Beam,
    center: Vec3,
    r: f64,
    own_center: Vec3,
    own_r: f64,
    apart: Vec3,
) -> u32 {
    let l = center - beam.start;
    let far = max(max(abs(center.x), abs(center.y)), abs(center.z));
    let own_far = max(max(abs(own_center.x), abs(own_center.y)), abs(own_center.z));
    let l_length = length_of(l);
    let e = beam.error + UNIT * (OF_PLACE * max(far, own_far) + OF_OFFSET * l_length);
    let way = beam.length;
    let v = beam.start - own_center;
    let a = length_of(apart);
    let k = (own_r - r) * (own_r + r);
    let side = k + dot3(apart, apart + 2.0 * v);
    let reach = a + 2.0 * length_of(v);
    let side_error = ROOM * (2.0 * a * e + UNIT * OF_SHELL * (abs(k) + a * reach));
    let leaves = dot3(l, beam.way) < -ROOM * e * (way + 2.0 * l_length);
    let end = l - beam.way;
    let end2 = dot3(end, end);
    let inner = r - e;
    let outer = r + e;
    let inner2 = select(-1.0, inner * inner * (1.0 - RELATIVE), inner > 0.0);
    let outer2 = outer * outer * (1.0 + RELATIVE);
    let ends_inside = !beam.is_endless & (end2 < inner2);
    let ends_outside = beam.is_endless | (end2 > outer2);
    let starts_inside = side < -side_error;
    let in_range = (l_length < BEYOND) & (r < BEYOND) & (r > NEGLIGIBLE) & (own_r < BEYOND)
        & (own_r > NEGLIGIBLE) & (e < BEYOND) & (a < BEYOND) & (way < BEYOND);
    let is_clear = (starts_inside & ends_inside) | ((side > side_error) & leaves);
    let known = select(OPEN, YES, starts_inside & ends_outside);
    return select(OPEN, select(known, NO, is_clear), in_range);
}
//#end

//#if planes
fn meets_plane(beam: Beam, point: Vec3, normal: Vec3) -> u32 {
    let l = point - beam.start;
    let end = l - beam.way;
    let n = length_of(normal);
    let way = beam.length;
    let e = beam.error
        + UNIT * (length_of(point) + OF_PLANE * (length_of(l) + way));
    let start = dot3(normal, l);
    let start_error = ROOM * n * e;
    let sun_error = OF_SLOPE * UNIT * n * way;
    let stop = select(dot3(normal, end), -dot3(normal, beam.way), beam.is_endless);
    let stop_error = select(start_error, sun_error, beam.is_endless);
    let are_known = (abs(start) > start_error) & (abs(stop) > stop_error) & (e < BEYOND);
    let are_apart = (start > 0.0) != (stop > 0.0);
    let runs_along = beam.is_endless && all((normal == Vec3(0.0)) | (beam.way == Vec3(0.0)));
    let known = select(OPEN, select(NO, YES, are_apart), are_known);
    return select(known, NO, runs_along);
}
//#end
//#end
