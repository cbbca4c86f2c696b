// Printed from the Rust text; see tests/library/printed.rs.

struct Ray {
    origin: vec3f,
    direction: vec3f,
    a: f32,
    inv_a: f32,
}

struct Bounds {
    low: f32,
    high: f32,
}

struct Nearest {
    low: f32,
    high: f32,
    second: f32,
    id: u32,
}

struct SphereLeaf {
    center: vec3f,
    inner2: f32,
    outer2: f32,
    slack: f32,
    near_most: f32,
}

struct SphereRecord {
    center: vec3f,
    inner2: f32,
    outer2: f32,
    slack: f32,
    near_most: f32,
    k: f32,
    k_error: f32,
    is_close: f32,
    k_width: f32,
    inv_r: f32,
    offset_error: f32,
    moved_error: f32,
    r2: f32,
    least2: f32,
    of_chord: f32,
    normal_error: f32,
}

struct PlaneRecord {
    normal: vec3f,
    offset: f32,
    offset_error: f32,
    slope_error: f32,
    unit: vec3f,
    unit_error: f32,
}

fn ray_from(origin: vec3f, direction: vec3f) -> Ray {
    let a = dot3(direction, direction);
    let inv_a = 1.0 / a;
    return Ray(origin, direction, a, inv_a);
}

fn leaf_bounds(leaf: SphereLeaf, ray: Ray) -> Bounds {
    let l = leaf.center - ray.origin;
    let s = dot3(ray.direction, l) * ray.inv_a;
    let to_center = l - ray.direction * s;
    let m = dot3(to_center, to_center);
    let inner = leaf.inner2 - m;
    let outer = leaf.outer2 - m;
    let half_inner = sqrt(max(inner, 0.0) * ray.inv_a);
    let half_outer = sqrt(max(outer, 0.0) * ray.inv_a);
    let near_low = s - half_outer - leaf.slack;
    let near_high = min(s - half_inner + leaf.slack, leaf.near_most);
    let far_low = s + half_inner - leaf.slack;
    let far_high = s + half_outer + leaf.slack;
    let low = select(near_low, far_low, near_high <= 0.0);
    let high = select(far_high, near_high, 0.0 < near_low);
    let is_missed = (outer < 0.0) | (far_high <= 0.0);
    let is_hit = (0.0 <= inner) & (0.0 < far_low);
    let low_2 = select(low, 0x1p100f, is_missed);
    let high_2 = select(0x1p100f, high, is_hit);
    return Bounds(low_2, high_2);
}

fn sphere_leaf(sphere: SphereRecord) -> SphereLeaf {
    return SphereLeaf(sphere.center, sphere.inner2, sphere.outer2, sphere.slack,
        sphere.near_most);
}

fn sphere_bounds_close(sphere: SphereRecord, ray: Ray) -> Bounds {
    let l = sphere.center - ray.origin;
    let s = dot3(ray.direction, l) * ray.inv_a;
    let to_center = l - ray.direction * s;
    let m = dot3(to_center, to_center);
    let inner = sphere.inner2 - m;
    let outer = sphere.outer2 - m;
    let half_inner = sqrt(max(inner, 0.0) * ray.inv_a);
    let half_outer = sqrt(max(outer, 0.0) * ray.inv_a);
    let near_low = s - half_outer - sphere.slack;
    let near_high = min(s - half_inner + sphere.slack, sphere.near_most);
    let far_low = s + half_inner - sphere.slack;
    let far_high = s + half_outer + sphere.slack;
    let v = sphere.k - dot3(ray.origin, sphere.center + l);
    let outside = sphere.k_error < v;
    let inside = v <= -sphere.k_error;
    let sum_low = abs(s) + half_inner - sphere.slack;
    let sum_high = abs(s) + half_outer + sphere.slack;
    let least_k = max(abs(v) - sphere.k_error, 0.0) * ray.inv_a;
    let most_k = (abs(v) + sphere.k_error) * ray.inv_a;
    let low_k = least_k / max(sum_high, least_k * 0x1p-100f) * (1.0 - sphere.k_width);
    let least_sum = max(sphere.slack, most_k * 0x1p-100f);
    let high_k = most_k / max(sum_low, least_sum) * (1.0 + sphere.k_width);
    let high_k_2 = select(0x1p100f, high_k, least_sum < sum_low);
    let low = select(max(far_low, low_k), max(near_low, low_k), outside);
    let from_inside = select(far_high, min(far_high, high_k_2), s < 0.0);
    let high = select(from_inside, min(near_high, high_k_2), outside);
    let is_known = outside | inside;
    let low_2 = select(0.0, low, is_known);
    let high_2 = select(0x1p100f, high, is_known);
    let on_surface = sphere.k_error <= 0.0;
    let is_missed = (outside & (outer < 0.0)) | ((outside | on_surface) & (s < -sphere.slack));
    let is_behind = on_surface & (s <= sphere.slack);
    let is_hit = ((outside & (0.0 <= inner)) & (sphere.slack < s)) | (inside & !is_behind);
    let low_3 = select(low_2, 0x1p100f, is_missed);
    let high_3 = select(0x1p100f, high_2, is_hit);
    return Bounds(low_3, high_3);
}

fn plane_bounds(plane: PlaneRecord, ray: Ray) -> Bounds {
    let offset = plane.offset - dot3(plane.normal, ray.origin);
    let slope = dot3(plane.normal, ray.direction);
    let away = select(slope, -slope, offset < 0.0);
    let error = plane.slope_error * ray.a;
    let slow = away - error;
    let quick = away + error;
    let reach = abs(offset) + plane.offset_error;
    let least_slope = max(reach * 0x1p-100f, 0x1p-90f);
    let least = (abs(offset) - plane.offset_error) / max(quick, least_slope) * 0.99999905;
    let most = reach / max(slow, least_slope) * 1.000001;
    let is_known = plane.offset_error < abs(offset);
    let is_missed = is_known & (quick <= 0.0);
    let is_hit = is_known & (least_slope < slow);
    let low = select(0.0, min(least, 0x1p99f), is_known);
    let low_2 = select(low, 0x1p100f, is_missed);
    let high = select(0x1p100f, most, is_hit);
    return Bounds(low_2, high);
}

fn nearest_none() -> Nearest {
    return Nearest(0x1p100f, 0x1p100f, 0x1p100f, 0u);
}

fn nearest_with(nearest: Nearest, next: Bounds, id: u32) -> Nearest {
    let is_nearer = next.low < nearest.low;
    let second = select(min(nearest.second, next.low), nearest.low, is_nearer);
    let low = select(nearest.low, next.low, is_nearer);
    let high = select(nearest.high, next.high, is_nearer);
    let id_2 = select(nearest.id, id, is_nearer);
    return Nearest(low, high, second, id_2);
}

fn decide(nearest: Nearest) -> u32 {
    let is_none = 0x1p100f <= nearest.low;
    let is_hit = (nearest.high < nearest.second) & (nearest.high < 0x1p66f);
    let is_sure = is_hit | is_none;
    return select(0xffffffffu, nearest.id, is_sure);
}

struct Slabs {
    near_origin: vec3f,
    far_origin: vec3f,
    near_inverse: vec3f,
    far_inverse: vec3f,
}

struct SlabInterval {
    enter: vec3f,
    leave: vec3f,
}

fn slabs_of(ray: Ray, beside: f32) -> Slabs {
    let slack = max(max(abs(ray.origin.x), abs(ray.origin.y)), abs(ray.origin.z))
        * 2.0861626e-7 + beside;
    let goes_down = ray.direction < vec3f(0.0);
    let steep = max(abs(ray.direction), vec3f(0x1p-80f));
    let way = select(steep, -steep, goes_down);
    let aside = select(vec3f(slack), vec3f(-slack), goes_down);
    let inverse = 1.0 / way;
    let near_origin = ray.origin + aside;
    let far_origin = ray.origin - aside;
    let near_inverse = inverse * 0.9999992;
    let far_inverse = inverse * 1.0000008;
    return Slabs(near_origin, far_origin, near_inverse, far_inverse);
}

fn between(slabs: Slabs, low: vec3f, high: vec3f) -> SlabInterval {
    let goes_down = slabs.near_inverse < vec3f(0.0);
    let near_side = select(low, high, goes_down);
    let far_side = select(high, low, goes_down);
    let enter = (near_side - slabs.near_origin) * slabs.near_inverse;
    let leave = (far_side - slabs.far_origin) * slabs.far_inverse;
    return SlabInterval(enter, leave);
}

fn is_within(stretch: SlabInterval, t_max: f32) -> bool {
    let first = max(max(max(stretch.enter.x, stretch.enter.y), stretch.enter.z), 0.0);
    let last = min(min(min(stretch.leave.x, stretch.leave.y), stretch.leave.z), t_max);
    return first <= last;
}
