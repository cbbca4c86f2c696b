// Colours of pixels whose samples' objects are known, in f32 or f64: numbers where each is the one that it must be,
// OPEN_COLOR where that is left to f64, or to the CPU. Points are those of src/certify/point.rs in f64, of
// src/gpu/before/point.rs in f32, and means those of src/shade/lit.rs, where their bounds are derived.

// Member order is checked against src/gpu/layout.rs by a test.
struct LightOfAll {
    ambient: Vec3,
    mean_error: Real,
    to_tree: Vec3,
    n_lamps: u32,
    n_samples: u32,
    n_listed_spheres: u32,
    n_listed_planes: u32,
    n_boxes: u32,
    leaves_out: u32,
    // Of the slabs of beams, above what is the origin's and the beam's.
    least_slack: f32,
}

struct Lamp {
    at: Vec3,
    kind: u32,
    shadows: u32,
    weight: Vec3,
}

//#if planes
//#if double
struct InTheWayPlane {
    point: vec3<f64>,
    id: u32,
    normal: vec3<f64>,
    narrow: NarrowPlane,
}
//#else
struct InTheWayPlane {
    narrow: NarrowPlane,
    id: u32,
}
//#end
//#end

//#if double
//#else
@group(0) @binding(next) var<storage, read> ids: array<u32>;
//#end
@group(0) @binding(next) var<uniform> light_of_all: LightOfAll;
@group(0) @binding(next) var<storage, read> lamps: array<Lamp>;
@group(0) @binding(next) var<storage, read> palette: array<Vec3>;
//#if floats
//#else
@group(0) @binding(next) var<storage, read> edges: array<Real>;
//#end
//#if of_scene
// Of all spheres, by their indices.
@group(0) @binding(next) var<storage, read> narrow_spheres: array<NarrowSphere>;
//#if double
//#else
@group(0) @binding(next) var<storage, read> seen_spheres: array<SeenSphere>;
//#end
// The ids of those that are looked at one after the other.
@group(0) @binding(next) var<storage, read> listed_spheres: array<u32>;
//#end
//#if planes
//#if double
//#else
@group(0) @binding(next) var<storage, read> seen_planes: array<SeenPlane>;
//#end
@group(0) @binding(next) var<storage, read> listed_planes: array<InTheWayPlane>;
//#end
//#if hierarchy
// The spheres' own indices are in the leaves.
@group(0) @binding(next) var<storage, read> boxes: array<Box>;
//#end
// Bytes in one word a pixel, or three words. Of bytes, f64 finds those that f32 has left open.
@group(0) @binding(next) var<storage, read_write> colors: array<u32>;
// Ways to lamps that were looked at for those pixels whose colours are not left open: all, and those where f32
// was not enough; and pixels whose colours took no f64.
@group(0) @binding(next) var<storage, read_write> n_ways: array<atomic<u32>, 3>;

// Where a ray meets its object.
struct Point {
    at: Vec3,
    error: Real,
    normal: Vec3,
    normal_error: Real,
    is_known: bool,
    // Of a sphere around the ray's origin.
    is_inside: bool,
}

//#if double
fn point_on(ray: Ray, root: Nearness, facing: Facing) -> Point {
    let is_hit = root.low > 0.0;
    let low = NARROWER / select(1.0, ray.a * root.high, is_hit);
    let high = WIDER / select(1.0, ray.a * root.low, is_hit);
    let is_held = is_hit && low > SMALLEST_T && high < LARGEST_T;
    let half = select(1.0, high - low, is_held) * 0.5;
    let t = select(1.0, low, is_held) + half;
    let length = sqrt(ray.a);
    let at = ray.direction * t;
    let error = ROOM * (length * half + OF_POINT * UNIT * t * length);
    let is_known = is_held && facing.is_certain;
    //#if point
    return Point(at, error, facing.normal, facing.error, is_known, !facing.is_outside);
    //#else
    let of_origin = ROOM * OF_ORIGIN * UNIT * sqrt(dot3(ray.origin, ray.origin));
    let is_inside = !facing.is_outside;
    return Point(
        ray.origin + at, error + of_origin, facing.normal, facing.error, is_known, is_inside);
    //#end
}

fn point_of(ray: Ray, i: Real, j: Real, id: u32) -> Point {
    //#if of_scene
    if id <= params.n_spheres {
        let sphere = record_of(id);
        let facing = sphere_normal(ray, sphere, abs(scene_spheres[id - 1u].radius));
        return point_on(ray, sphere_nearness(ray, sphere), facing);
    }
    //#end
    //#if planes
    let plane = planes[id - params.n_spheres - 1u];
    let unit = normalized(plane.normal);
    let normal = select(unit, -unit, dot3(unit, ray.direction) > 0.0);
    return point_on(ray, plane_nearness(ray, plane), Facing(normal, OF_PLANE_NORMAL * UNIT, true, true));
    //#else
    return Point(Vec3(0.0), 0.0, Vec3(0.0), 0.0, false, false);
    //#end
}
//#else
fn point_of(ray: Ray, i: Real, j: Real, id: u32) -> Point {
    //#if of_scene
    if id <= params.n_spheres {
        let sphere = seen_spheres[id - 1u];
        return sphere_point(ray, sphere_aside(sphere, i, j), sphere, narrow_spheres[id - 1u]);
    }
    //#end
    //#if planes
    return plane_point(ray, seen_planes[id - params.n_spheres - 1u], i, j);
    //#else
    return Point(Vec3(0.0), 0.0, Vec3(0.0), 0.0, false, false);
    //#end
}
//#end

//#if double
//#if of_scene
// Whether a beam that starts on the inside of a sphere leaves it: a ball is convex, so that its end says
// so, whose distance is known like that of any sphere.
fn leaves_sphere(beam: Beam, center: Vec3, r: f64) -> u32 {
    if beam.is_endless {
        return YES;
    }
    let l = center - beam.start;
    let far = max(max(abs(center.x), abs(center.y)), abs(center.z));
    let e = beam.error + UNIT * (OF_PLACE * far + OF_OFFSET * sqrt(dot3(l, l)));
    let end = l - beam.way;
    let end2 = dot3(end, end);
    let inner = r - e;
    let outer = r + e;
    let is_inside = inner > 0.0 && end2 < inner * inner * (1.0 - RELATIVE);
    let is_outside = end2 > outer * outer * (1.0 + RELATIVE);
    let in_range = (r < BEYOND) & (r > NEGLIGIBLE) & (e < BEYOND);
    return select(OPEN, select(select(OPEN, YES, is_outside), NO, is_inside), in_range);
}
//#end
//#end

// What is known of objects in the way, and whether that took f64.
struct Met {
    state: u32,
    in_f64: u32,
}

fn worse(met: Met, other: Met) -> Met {
    return Met(max(met.state, other.state), met.in_f64 | other.in_f64);
}

//#if of_scene
fn look_at_sphere(beam: Beam, narrow: NarrowBeam, index: u32, own: u32) -> Met {
    let known = meets_narrow_sphere(narrow, narrow_spheres[index]);
    //#if double
    if known != OPEN {
        return Met(known, 0u);
    }
    let sphere = scene_spheres[index];
    let center = sphere.center - seen_from.reference;
    let r = abs(sphere.radius);
    let met = meets_sphere(beam, center, r);
    if met != OPEN || own > params.n_spheres {
        return Met(met, 1u);
    }
    let on = scene_spheres[own - 1u];
    let own_center = on.center - seen_from.reference;
    let apart = on.center - sphere.center;
    return Met(meets_shell(beam, center, r, own_center, abs(on.radius), apart), 1u);
    //#else
    return Met(known, 0u);
    //#end
}
//#end

//#if planes
fn look_at_plane(beam: Beam, narrow: NarrowBeam, index: u32) -> Met {
    let plane = listed_planes[index];
    let known = meets_narrow_plane(narrow, plane.narrow);
    //#if double
    if known == OPEN {
        return Met(meets_plane(beam, plane.point, plane.normal), 1u);
    }
    return Met(known, 0u);
    //#else
    let across = (plane.narrow.normal == Vec3(0.0)) | (beam.way == Vec3(0.0));
    return Met(select(known, NO, beam.is_endless && all(across)), 0u);
    //#end
}
//#end

fn largest(v: Vec3) -> Real {
    return max(max(abs(v.x), abs(v.y)), abs(v.z));
}

//#if hierarchy
struct Box {
    low: array<f32, 3>,
    high: array<f32, 3>,
    link: u32,
}

// Looks at the spheres of the tree that a beam may meet.
fn look_in_tree(beam: Beam, narrow: NarrowBeam, own: u32) -> Met {
    let origin = beam.start + light_of_all.to_tree;
    let moved = OF_PLACE * (largest(beam.start) + largest(light_of_all.to_tree));
    let beside = beam.error + 4.0 * UNIT * moved;
    if !(beside < REACH && largest(origin) < REACH && narrow.is_known) {
        return Met(OPEN, 1u);
    }
    let slack = f32(BESIDE * beside) + light_of_all.least_slack;
    let slabs = slabs_of(vec3f(origin), narrow.direction, slack);
    let end = narrow.distance * FARTHER;
    var met = Met(NO, 0u);
    var at = 0u;
    while at < light_of_all.n_boxes && met.state != YES {
        let node = boxes[at];
        let low = vec3f(node.low[0], node.low[1], node.low[2]);
        let high = vec3f(node.high[0], node.high[1], node.high[2]);
        let is_met = meets(slabs, low, high, end);
        let is_leaf = (node.link & IS_LEAF) != 0u;
        let index = node.link & ~IS_LEAF;
        if is_met && is_leaf && index + 1u != own {
            met = worse(met, look_at_sphere(beam, narrow, index, own));
        }
        at = select(node.link, at + 1u, is_met || is_leaf);
    }
    return met;
}
//#end

// What is in the way of a beam from an object.
fn in_the_way(beam: Beam, id: u32, is_inside: bool) -> Met {
    let narrow = narrowed(beam);
    var met = Met(NO, 0u);
    //#if of_scene
    if is_inside {
        //#if double
        let own = scene_spheres[id - 1u];
        met = Met(leaves_sphere(beam, own.center - seen_from.reference, abs(own.radius)), 1u);
        //#else
        met = Met(leaves_narrow_sphere(narrow, narrow_spheres[id - 1u]), 0u);
        //#end
    }
    for (var i = 0u; i < light_of_all.n_listed_spheres && met.state != YES; i++) {
        let index = listed_spheres[i] - 1u;
        if index + 1u != id {
            met = worse(met, look_at_sphere(beam, narrow, index, id));
        }
    }
    //#end
    //#if planes
    for (var i = 0u; i < light_of_all.n_listed_planes && met.state != YES; i++) {
        if listed_planes[i].id != id {
            met = worse(met, look_at_plane(beam, narrow, i));
        }
    }
    //#end
    //#if hierarchy
    if met.state != YES {
        met = worse(met, look_in_tree(beam, narrow, id));
    }
    //#end
    return met;
}

fn beam_to(lamp: Lamp, ray: Ray, point: Point) -> Beam {
    if lamp.kind == LAMP_SUN {
        return to_sun(point.at, point.error, lamp.at);
    }
    if lamp.kind == LAMP_POINT {
        return to_point(point.at, point.error, lamp.at);
    }
    return to_eye(point.at, ray.direction, DIRECTION_ERROR);
}

// Bounds of what a point gets of each colour.
struct Light {
    low: Vec3,
    high: Vec3,
    n_ways: vec2u,
}

//#if double
// Half of a sky's suns are behind a surface, which f32 sees. Their directions are at most 2√3 long; the normal and they are
// rounded once, and the dot product is off by 3 units.
fn is_behind(normal: vec3f, error: f32, lamp: Lamp) -> bool {
    return lamp.kind == LAMP_SUN && dot3f(normal, vec3f(lamp.at)) > 3.5f * (NARROW_SLOPE + error);
}
//#end

fn light_on(ray: Ray, point: Point, id: u32) -> Light {
    var sum = Light(light_of_all.ambient, light_of_all.ambient, vec2u(0u));
    //#if double
    let normal = vec3f(point.normal);
    let normal_error = f32(ROOM * point.normal_error);
    //#end
    for (var i = 0u; i < light_of_all.n_lamps; i++) {
        let lamp = lamps[i];
        //#if double
        if is_behind(normal, normal_error, lamp) {
            continue;
        }
        //#end
        let beam = beam_to(lamp, ray, point);
        var given = cosine(beam, point.normal, point.normal_error);
        if lamp.shadows != 0u && given.high > 0.0 {
            let met = in_the_way(beam, id, point.is_inside);
            given.low = select(0.0, given.low, met.state == NO);
            given.high = select(given.high, 0.0, met.state == YES);
            sum.n_ways += vec2u(1u, met.in_f64);
        }
        sum.low += lamp.weight * given.low;
        sum.high += lamp.weight * given.high;
    }
    return sum;
}

// The sum of a pixel's samples.
struct Mean {
    low: Vec3,
    high: Vec3,
    n_ways: vec2u,
    n_hits: u32,
}

//#if floats
// The word of the one f32 that both bounds of a channel round to, or OPEN_COLOR.
fn word_of(low: Real, high: Real) -> u32 {
    let is_held = low > SMALLEST_T && high < LARGEST_T;
    let word = f32(select(1.0, low, is_held));
    let is_one = is_held && word == f32(select(1.0, high, is_held));
    return select(select(OPEN_COLOR, bitcast<u32>(word), is_one), 0u, high == 0.0);
}
//#else
// The one number whose range has both bounds of a channel, or OPEN_COLOR.
fn word_of(low: Real, high: Real) -> u32 {
    let largest = arrayLength(&edges);
    var number = 0u;
    for (var step = (largest + 1u) >> 1u; step > 0u; step >>= 1u) {
        let next = number + step;
        number = select(number, next, edges[next - 1u] <= low);
    }
    let is_one = number == largest || high < edges[min(number, largest - 1u)];
    return select(OPEN_COLOR, number, is_one);
}
//#end

// Adds a sample of a pixel; false where it can't tell.
fn add_sample(sum: ptr<function, Mean>, place: vec2u, id: u32) -> bool {
    if id == 0u {
        (*sum).low += palette[0];
        (*sum).high += palette[0];
        return true;
    }
    if id > params.n_spheres + params.n_planes {
        return false;
    }
    let i = Real(params.offset_i + 2 * i32(place.x));
    let j = Real(params.offset_j - 2 * i32(place.y));
    //#if point
    let ray = ray_from(params.origin, Vec3(0.0), camera_direction(i, j));
    //#else
    let ray = ray_from(camera_origin(i, j), Vec3(0.0), params.forward);
    //#end
    let point = point_of(ray, i, j, id);
    if !point.is_known {
        return false;
    }
    let light = light_on(ray, point, id);
    (*sum).low += palette[id] * light.low;
    (*sum).high += palette[id] * light.high;
    (*sum).n_ways += light.n_ways;
    (*sum).n_hits += 1u;
    return true;
}

@compute @workgroup_size(WORKGROUP_WIDTH, WORKGROUP_HEIGHT)
fn render(@builtin(global_invocation_id) pixel: vec3u) {
    let index = pixel.y * params.width + pixel.x;
    if pixel.x >= params.width || index >= params.n_rays {
        return;
    }
    //#if bytes
    //#if double
    if colors[index] != OPEN_COLOR {
        return;
    }
    //#end
    //#end
    let n = light_of_all.n_samples;
    var sum = Mean(Vec3(0.0), Vec3(0.0), vec2u(0u), 0u);
    var is_known = true;
    for (var row = 0u; row < n && is_known; row++) {
        for (var column = 0u; column < n && is_known; column++) {
            let place = pixel.xy * n + vec2u(column, row);
            is_known = add_sample(&sum, place, ids[place.y * params.width * n + place.x]);
        }
    }
    let n_counted = select(n * n, max(sum.n_hits, 1u), light_of_all.leaves_out != 0u);
    let low = sum.low / Real(i32(n_counted)) * (1.0 - light_of_all.mean_error);
    let high = sum.high / Real(i32(n_counted)) * (1.0 + light_of_all.mean_error);
    let r = word_of(low.x, high.x);
    let g = word_of(low.y, high.y);
    let b = word_of(low.z, high.z);
    let is_open = !is_known || max(max(r, g), b) == OPEN_COLOR;
    //#if bytes
    colors[index] = select(r | g << 8u | b << 16u, OPEN_COLOR, is_open);
    //#else
    colors[3u * index] = select(r, OPEN_COLOR, is_open);
    colors[3u * index + 1u] = g;
    colors[3u * index + 2u] = b;
    //#end
    if !is_open {
        atomicAdd(&n_ways[0], sum.n_ways.x);
        //#if double
        atomicAdd(&n_ways[1], sum.n_ways.y);
        //#else
        atomicAdd(&n_ways[2], 1u);
        //#end
    }
}
