// Colours of pixels whose samples' objects are known, in f64: numbers where each is the one that it must be,
// OPEN_COLOR where that is left to the CPU. Points are those of src/certify/point.rs, and means those of
// src/shade/lit.rs, where their bounds are derived.

// Member order is checked against src/gpu/layout.rs by a test.
struct LightOfAll {
    ambient: vec3<f64>,
    mean_error: f64,
    to_tree: vec3<f64>,
    n_lamps: u32,
    n_samples: u32,
    n_listed_spheres: u32,
    n_listed_planes: u32,
    n_boxes: u32,
    leaves_out: u32,
}

struct Lamp {
    at: vec3<f64>,
    kind: u32,
    shadows: u32,
    weight: vec3<f64>,
}

//#if of_scene
struct InTheWaySphere {
    center: vec3<f64>,
    radius: f64,
    id: u32,
}
//#end

//#if planes
struct InTheWayPlane {
    point: vec3<f64>,
    id: u32,
    normal: vec3<f64>,
}
//#end

@group(0) @binding(next) var<uniform> light_of_all: LightOfAll;
@group(0) @binding(next) var<storage, read> lamps: array<Lamp>;
@group(0) @binding(next) var<storage, read> palette: array<vec3<f64>>;
//#if floats
//#else
@group(0) @binding(next) var<storage, read> edges: array<f64>;
//#end
//#if of_scene
@group(0) @binding(next) var<storage, read> listed_spheres: array<InTheWaySphere>;
//#end
//#if planes
@group(0) @binding(next) var<storage, read> listed_planes: array<InTheWayPlane>;
//#end
//#if hierarchy
// The spheres' own indices are in the leaves.
@group(0) @binding(next) var<storage, read> boxes: array<Box>;
//#end
// Bytes in one word a pixel, or three words.
@group(0) @binding(next) var<storage, read_write> colors: array<u32>;
// Ways to lamps that were looked at for those pixels whose colours are not left open.
@group(0) @binding(next) var<storage, read_write> n_ways: atomic<u32>;

// Where a ray meets its object.
struct Point {
    at: Vec3,
    error: f64,
    normal: Vec3,
    normal_error: f64,
    is_known: bool,
    // Of a sphere around the ray's origin.
    is_inside: bool,
}

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

fn point_of(ray: Ray, id: u32) -> Point {
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

//#if hierarchy
struct Box {
    low: array<f32, 3>,
    high: array<f32, 3>,
    link: u32,
}

// One axis of a beam, in f32. Slab in src/tree/wide.rs has the derivation.
struct Slab {
    near_origin: f32,
    far_origin: f32,
    near_inverse: f32,
    far_inverse: f32,
    goes_down: bool,
    is_flat: bool,
}

fn slab_of(origin: f64, direction: f64, slack: f32) -> Slab {
    let goes_down = direction < 0.0;
    let here = f32(origin);
    let slack_here = select(slack, -slack, goes_down);
    let is_steep = abs(direction) > FLAT;
    let inverse = select(0.0f, f32(1.0 / select(1.0, direction, is_steep)), is_steep);
    return Slab(
        here + slack_here,
        here - slack_here,
        inverse * SLAB_NARROWER,
        inverse * SLAB_WIDER,
        goes_down,
        direction == 0.0,
    );
}

// Between which s a beam is within a slab of a box, cut from what it was before.
fn within(slab: Slab, low: f32, high: f32, before: vec2f) -> vec2f {
    let near = (select(low, high, slab.goes_down) - slab.near_origin) * slab.near_inverse;
    let far = (select(high, low, slab.goes_down) - slab.far_origin) * slab.far_inverse;
    let is_beside = slab.is_flat && (slab.near_origin < low || high < slab.far_origin);
    let is_steep = slab.near_inverse != 0.0;
    let cut = vec2f(max(before.x, near), min(before.y, far));
    return select(vec2f(before.x, select(before.y, -1.0f, is_beside)), cut, is_steep);
}

// Looks at the spheres of the tree that a beam may meet.
fn look_in_tree(beam: Beam, own: u32) -> u32 {
    let origin = beam.start + light_of_all.to_tree;
    let moved = sqrt(dot3(beam.start, beam.start))
        + sqrt(dot3(light_of_all.to_tree, light_of_all.to_tree));
    let beside = beam.error + 4.0 * UNIT * moved;
    let far = max(max(abs(origin.x), abs(origin.y)), abs(origin.z));
    let largest = max(max(abs(beam.way.x), abs(beam.way.y)), abs(beam.way.z));
    if !(beside < REACH && far < REACH && largest > NEGLIGIBLE) {
        return OPEN;
    }
    let slack = f32(far) * SLACK + f32(BESIDE * beside) + LEAST_SLACK;
    let direction = beam.way * (1.0 / largest);
    let x = slab_of(origin.x, direction.x, slack);
    let y = slab_of(origin.y, direction.y, slack);
    let z = slab_of(origin.z, direction.z, slack);
    // In units of the largest component; nothing is as far away as BEHIND_ALL.
    let end = f32(select(min(largest, BEHIND_ALL), BEHIND_ALL, beam.is_endless)) * SLAB_WIDER;
    var state = NO;
    var at = 0u;
    while at < light_of_all.n_boxes && state != YES {
        let node = boxes[at];
        var met = within(x, node.low[0], node.high[0], vec2f(0.0, end));
        met = within(y, node.low[1], node.high[1], met);
        met = within(z, node.low[2], node.high[2], met);
        let is_met = met.x <= met.y;
        let is_leaf = (node.link & IS_LEAF) != 0u;
        let index = node.link & ~IS_LEAF;
        if is_met && is_leaf && index + 1u != own {
            let sphere = scene_spheres[index];
            let center = sphere.center - seen_from.reference;
            state = max(state, meets_sphere(beam, center, abs(sphere.radius)));
        }
        at = select(node.link, at + 1u, is_met || is_leaf);
    }
    return state;
}
//#end

// What is in the way of a beam from an object.
fn in_the_way(beam: Beam, id: u32, is_inside: bool) -> u32 {
    var state = NO;
    //#if of_scene
    if is_inside {
        let own = scene_spheres[id - 1u];
        state = leaves_sphere(beam, own.center - seen_from.reference, abs(own.radius));
    }
    for (var i = 0u; i < light_of_all.n_listed_spheres && state != YES; i++) {
        let sphere = listed_spheres[i];
        if sphere.id != id {
            state = max(state, meets_sphere(beam, sphere.center, sphere.radius));
        }
    }
    //#end
    //#if planes
    for (var i = 0u; i < light_of_all.n_listed_planes && state != YES; i++) {
        let plane = listed_planes[i];
        if plane.id != id {
            state = max(state, meets_plane(beam, plane.point, plane.normal));
        }
    }
    //#end
    //#if hierarchy
    if state != YES {
        state = max(state, look_in_tree(beam, id));
    }
    //#end
    return state;
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
    n_ways: u32,
}

fn light_on(ray: Ray, point: Point, id: u32) -> Light {
    var sum = Light(light_of_all.ambient, light_of_all.ambient, 0u);
    for (var i = 0u; i < light_of_all.n_lamps; i++) {
        let lamp = lamps[i];
        let beam = beam_to(lamp, ray, point);
        var given = cosine(beam, point.normal, point.normal_error);
        if lamp.shadows != 0u && given.high > 0.0 {
            let state = in_the_way(beam, id, point.is_inside);
            given.low = select(0.0, given.low, state == NO);
            given.high = select(given.high, 0.0, state == YES);
            sum.n_ways += 1u;
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
    n_ways: u32,
    n_hits: u32,
}

//#if floats
// The word of the one f32 that both bounds of a channel round to, or OPEN_COLOR.
fn word_of(low: f64, high: f64) -> u32 {
    let is_held = low > SMALLEST_T && high < LARGEST_T;
    let word = f32(select(1.0, low, is_held));
    let is_one = is_held && word == f32(select(1.0, high, is_held));
    return select(select(OPEN_COLOR, bitcast<u32>(word), is_one), 0u, high == 0.0);
}
//#else
// The one number whose range has both bounds of a channel, or OPEN_COLOR.
fn word_of(low: f64, high: f64) -> u32 {
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
    let point = point_of(ray, id);
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
    let n = light_of_all.n_samples;
    var sum = Mean(Vec3(0.0), Vec3(0.0), 0u, 0u);
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
        atomicAdd(&n_ways, sum.n_ways);
    }
}
