// Twin of src/gpu/before/narrow.rs, where the bounds are derived.

// A beam in f32.
struct NarrowBeam {
    start: vec3f,
    start_low: vec3f,
    // Of length 1.
    direction: vec3f,
    way: vec3f,
    distance: f32,
    error: f32,
    is_endless: bool,
    is_known: bool,
}

fn dot3f(a: vec3f, b: vec3f) -> f32 {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

fn narrowed(beam: Beam) -> NarrowBeam {
    let length = select(0.0, beam.length, beam.square > 0.0);
    let far = max(max(abs(beam.start.x), abs(beam.start.y)), abs(beam.start.z));
    let error = ROOM * (beam.error + NARROW_START * far) + NARROW_LEAST;
    let in_range = (far < NARROW_REACH) & (error < NARROW_REACH)
        & (length > 1.0 / NARROW_REACH) & (length < BEYOND);
    let is_endless = beam.is_endless | (length > NARROW_END);
    let start = select(Vec3(0.0), beam.start, in_range);
    let direction = beam.way * beam.inverse_length;
    let way = select(direction, beam.way, in_range & !is_endless);
    //#if double
    // Of 24 bits each.
    let high = start * SPLITTER - (start * SPLITTER - start);
    //#else
    let high = start;
    //#end
    return NarrowBeam(
        vec3f(high),
        vec3f(start - high),
        vec3f(select(Vec3(0.0), direction, in_range)),
        vec3f(select(Vec3(0.0), way, in_range)),
        f32(select(min(length, NARROW_END), NARROW_END, is_endless)),
        f32(select(NARROW_REACH, error, in_range)),
        is_endless,
        in_range,
    );
}

// From where a beam starts to a place of two parts.
fn offset_to(beam: NarrowBeam, place: vec3f, low: vec3f) -> vec3f {
    return (place - beam.start) + (low - beam.start_low);
}

//#if of_scene
// The square of the distance between a beam and a place at this offset from its start.
fn nearest2(beam: NarrowBeam, l: vec3f) -> f32 {
    let foot = min(max(dot3f(l, beam.direction), 0.0f), beam.distance);
    let q = l - beam.direction * foot;
    return dot3f(q, q);
}

// Member order is checked against src/gpu/layout.rs by a test.
struct NarrowSphere {
    center: vec3f,
    radius: f32,
    center_low: vec3f,
}

fn meets_narrow_sphere(beam: NarrowBeam, sphere: NarrowSphere) -> u32 {
    let l = offset_to(beam, sphere.center, sphere.center_low);
    let r = sphere.radius;
    let l2 = dot3f(l, l);
    let least2 = nearest2(beam, l);
    let end = l - beam.way;
    let end2 = dot3f(end, end);
    let e = beam.error + NARROW_OFFSET * sqrt(l2);
    let inner = r - e;
    let outer = r + e;
    let inner2 = select(-1.0f, inner * inner * NARROW_INSIDE, inner > 0.0f);
    let outer2 = (outer * outer + NARROW_ASIDE * l2) * NARROW_OUTSIDE;
    let ends_inside = !beam.is_endless & (end2 < inner2);
    let ends_outside = beam.is_endless | (end2 > outer2);
    let in_range = beam.is_known & (r > 0.0f);
    let is_clear = (least2 > outer2) | ((l2 < inner2) & ends_inside);
    let is_crossed = (least2 < inner2) & ((l2 > outer2) | ends_outside);
    let known = select(select(OPEN, YES, is_crossed), NO, is_clear);
    return select(OPEN, known, in_range);
}

// Whether a beam that starts on the inside of a sphere leaves it: a ball is convex, so that its end says so.
fn leaves_narrow_sphere(beam: NarrowBeam, sphere: NarrowSphere) -> u32 {
    let l = offset_to(beam, sphere.center, sphere.center_low);
    let r = sphere.radius;
    let end = l - beam.way;
    let end2 = dot3f(end, end);
    let e = beam.error + NARROW_OFFSET * sqrt(dot3f(l, l));
    let inner = r - e;
    let outer = r + e;
    let is_inside = !beam.is_endless & (inner > 0.0f) & (end2 < inner * inner * NARROW_INSIDE);
    let is_outside = beam.is_endless | (end2 > outer * outer * NARROW_OUTSIDE);
    let in_range = beam.is_known & (r > 0.0f);
    return select(OPEN, select(select(OPEN, YES, is_outside), NO, is_inside), in_range);
}
//#end

//#if planes
// Member order is checked against src/gpu/layout.rs by a test.
struct NarrowPlane {
    point: vec3f,
    size: f32,
    point_low: vec3f,
    normal: vec3f,
}

fn meets_narrow_plane(beam: NarrowBeam, plane: NarrowPlane) -> u32 {
    let l = offset_to(beam, plane.point, plane.point_low);
    let end = l - beam.way;
    let near = sqrt(dot3f(l, l));
    let far = near + sqrt(dot3f(end, end));
    let start = dot3f(plane.normal, l);
    let start_error = plane.size * (beam.error + NARROW_PLANE * near);
    let stop =
        select(dot3f(plane.normal, end), -dot3f(plane.normal, beam.direction), beam.is_endless);
    let stop_error =
        plane.size * select(beam.error + NARROW_PLANE * far, NARROW_SLOPE, beam.is_endless);
    let in_range = beam.is_known & (plane.size > 0.0f);
    let are_known = (abs(start) > start_error) & (abs(stop) > stop_error) & in_range;
    let are_apart = (start > 0.0f) != (stop > 0.0f);
    return select(OPEN, select(NO, YES, are_apart), are_known);
}
//#end
