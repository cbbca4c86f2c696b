// Twin of src/shade/beam.rs, where the bounds are derived. BEYOND stands for ∞.

// The way from a point to a lamp.
struct Beam {
    start: Vec3,
    way: Vec3,
    square: f64,
    inverse: f64,
    error: f64,
    is_endless: bool,
    turned: f64,
}

// Bounds of a number.
struct Bounds {
    low: f64,
    high: f64,
}

fn beam_from(start: Vec3, way: Vec3, error: f64, turned: f64) -> Beam {
    let square = dot3(way, way);
    let inverse = 1.0 / select(1.0, square, square > 0.0);
    return Beam(start, way, square, inverse, error, false, turned);
}

fn to_point(start: Vec3, error: f64, position: Vec3) -> Beam {
    let way = position - start;
    let distance = sqrt(dot3(way, way));
    let off = error + UNIT * (sqrt(dot3(position, position)) + distance);
    let is_apart = (distance > 4.0 * off) & (distance > NEGLIGIBLE) & (distance < BEYOND);
    let turned = 2.0 * off / select(1.0, distance, is_apart);
    return beam_from(
        start,
        way,
        select(BEYOND, off + OF_WAY * UNIT * distance, is_apart),
        select(BEYOND, turned, is_apart),
    );
}

fn to_eye(start: Vec3, direction: Vec3, turned: f64) -> Beam {
    return beam_from(start, -direction, 0.0, 2.0 * turned);
}

fn to_sun(start: Vec3, error: f64, direction: Vec3) -> Beam {
    var beam = beam_from(start, -direction, error, 0.0);
    beam.is_endless = true;
    return beam;
}

// Bounds of n·ω. Both are 0 where it is certain not to be positive.
fn cosine(beam: Beam, normal: Vec3, normal_error: f64) -> Bounds {
    let length = sqrt(select(1.0, beam.square, beam.square > 0.0));
    let cosine = dot3(normal, beam.way) * (1.0 / length);
    let error = ROOM * (normal_error + beam.turned) + OF_COSINE * UNIT;
    let low = cosine - error;
    let high = cosine + error;
    return Bounds(select(0.0, low, low > 0.0), select(0.0, min(high, 1.0), high > 0.0));
}

//#if of_scene
// NO, OPEN or YES: the largest of several wins.
fn meets_sphere(beam: Beam, center: Vec3, r: f64) -> u32 {
    let l = center - beam.start;
    let l2 = dot3(l, l);
    let far = max(max(abs(center.x), abs(center.y)), abs(center.z));
    let ahead = max(dot3(l, beam.way) * beam.inverse, 0.0);
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

//#if planes
fn meets_plane(beam: Beam, point: Vec3, normal: Vec3) -> u32 {
    let l = point - beam.start;
    let end = l - beam.way;
    let n = sqrt(dot3(normal, normal));
    let way = sqrt(beam.square);
    let e = beam.error
        + UNIT * (sqrt(dot3(point, point)) + OF_PLANE * (sqrt(dot3(l, l)) + way));
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
