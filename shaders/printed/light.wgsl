// Printed from the Rust text; see tests/library/printed.rs.

struct SurfaceErrorTerms {
    longest: f32,
    of_t: f32,
    of_origin: f32,
    of_normal: f32,
    rounding: f32,
    of_quotient: f32,
}

struct SurfacePoint {
    point: vec3f,
    point_error: f32,
    normal: vec3f,
    normal_error: f32,
    front: f32,
}

struct Anchor {
    base: vec3f,
    error: f32,
    across: f32,
    above: f32,
    scale: f32,
}

struct SphereOccluder {
    center: vec3f,
    r: f32,
    place: f32,
}

struct PlaneOccluder {
    point: vec3f,
    normal: vec3f,
    length: f32,
    place: f32,
}

struct GroundOccluder {
    center: vec3f,
    k: f32,
    k_error: f32,
    length: f32,
}

struct Aim {
    from_point: f32,
    to: vec3f,
    away: f32,
    turned: f32,
    last: f32,
    end2: f32,
}

struct ShadowRay {
    start: vec3f,
    way: vec3f,
    length: f32,
    inv_square: f32,
    inv_length: f32,
    error: f32,
    end_error: f32,
    bend: f32,
    from_point: f32,
    last: f32,
    end2: f32,
    turned: f32,
    unit: f32,
}

struct Occlusion {
    blocked: f32,
    clear: f32,
}

struct LightBounds {
    low: vec3f,
    high: vec3f,
}

fn sphere_surface_far(sphere: SphereRecord, ray: Ray, lengths: SurfaceErrorTerms) -> SurfacePoint {
    let l = sphere.center - ray.origin;
    let s = dot3(ray.direction, l) * ray.inv_a;
    let p = l - ray.direction * s;
    let chord2 = sphere.r2 - dot3(p, p);
    let half = sqrt(max(chord2, 0.0) * ray.inv_a);
    let v = sphere.k - dot3(ray.origin, sphere.center + l);
    let outside = sphere.k_error < v;
    let side = select(1.0, -1.0, outside);
    let inside = v <= -sphere.k_error;
    let is_known = (sphere.least2 <= chord2) & (outside | inside);
    let of_half = sphere.of_chord / select(1.0, half, is_known);
    let t = s + half * side;
    let radius = p * side - ray.direction * half;
    let error = select(0x1p100f, sphere.normal_error + of_half * sphere.inv_r, is_known);
    let point_error = lengths.longest * sphere.slack + 1.01 * of_half
        + (lengths.of_t * t + lengths.of_origin);
    let point = ray.origin + ray.direction * t;
    let error_2 = select(0x1p100f, point_error, is_known);
    let normal = radius * sphere.inv_r;
    let front = select(-1.0, 1.0, outside);
    return SurfacePoint(point, error_2, normal, error, front);
}

fn sphere_surface_close(sphere: SphereRecord, ray: Ray, lengths: SurfaceErrorTerms) -> SurfacePoint {
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
    let is_known_2 = outside | inside;
    let inv_r = select(1.0, sphere.inv_r, is_known_2);
    let half = (high_2 - low_2) * 0.5;
    let middle = low_2 + half;
    let error = lengths.longest * half + lengths.of_t * middle;
    let v_2 = ray.direction * middle;
    let point_error = (error + sphere.offset_error) * inv_r + lengths.of_normal;
    let half_chord = (half_inner + half_outer) * 0.5;
    let of_half = (half_outer - half_inner) * 0.5 * lengths.longest;
    let chord_error = sphere.normal_error + of_half * inv_r;
    let chord_error_2 = select(0x1p100f, chord_error, is_known_2);
    let is_chord = chord_error_2 < point_error;
    let outward = v_2 - l;
    let side = select(1.0, -1.0, outside);
    let by_chord = to_center * side - ray.direction * half_chord;
    let by_point = outward * -side;
    let normal = select(by_point, by_chord, is_chord) * inv_r;
    let point = ray.origin + v_2;
    let point_error_2 = error + lengths.of_origin;
    let normal_error = select(point_error, chord_error_2, is_chord) * 1.01;
    let front = select(-1.0, 1.0, outside);
    return SurfacePoint(point, point_error_2, normal, normal_error, front);
}

fn anchor_ray(anchor: Anchor, right: vec3f, up: vec3f, across: f32, above: f32, ray: Ray) -> Ray {
    let origin = (right * (across - anchor.across) + up * (above - anchor.above))
        * anchor.scale;
    return Ray(origin, ray.direction, ray.a, ray.inv_a);
}

fn plane_surface(plane: PlaneRecord, ray: Ray, lengths: SurfaceErrorTerms) -> SurfacePoint {
    let offset = plane.offset - dot3(plane.normal, ray.origin);
    let slope = dot3(plane.normal, ray.direction);
    let against = select(1.0, -1.0, 0.0 < slope);
    let slope_error = plane.slope_error * lengths.longest;
    let steep = abs(slope) * 0.0078125 - slope_error;
    let inverse = 1.0 / select(1.0, slope, 0.0 < steep);
    let t = offset * inverse;
    let of_quotient = abs(inverse) * (plane.offset_error + t * slope_error);
    let error = of_quotient * 1.01 + t * lengths.of_quotient;
    let is_known = 0.0 < min(t, steep);
    let t_2 = select(0.0, t, is_known);
    let error_2 = select(0x1p100f, error, is_known);
    let normal_error = select(0x1p100f, plane.unit_error, is_known);
    let point = ray.origin + ray.direction * t_2;
    let point_error = lengths.longest * error_2 + (lengths.of_t * t_2 + lengths.of_origin);
    let normal = plane.unit * against;
    let front = 0.0 <= 0.0;
    let front_2 = select(-1.0, 1.0, front);
    return SurfacePoint(point, point_error, normal, normal_error, front_2);
}

fn shadow_ray(aim: Aim, point: vec3f, point_error: f32) -> ShadowRay {
    let way = aim.to - point * aim.from_point;
    let way2 = dot3(way, way);
    let square = max(way2, 0x1p-100f);
    let length = sqrt(square);
    let inv_length = 1.0 / length;
    let off = (point_error + 0x1p-23f * (aim.away + length)) * aim.from_point;
    let is_far = (0x1p-100f < way2) & (way2 < 0x1p100f);
    let is_apart = (4.0 * off < length) & is_far;
    let end_error = 0x1p-23f * (aim.away + 5.0 * length) * aim.from_point;
    let turned = 1.02 * select(0.0, off, is_apart) * inv_length;
    let inv_square = 1.0 / square;
    let error = select(0x1p62f, min(point_error, 0x1p62f), is_apart);
    let bend = 1.2 * end_error * inv_length;
    let turned_2 = select(0x1p62f, turned, is_apart) + aim.turned;
    return ShadowRay(point, way, length, inv_square, inv_length, error, end_error, bend,
        aim.from_point, aim.last, aim.end2, turned_2, 0x1p-23f);
}

fn is_near(ray: ShadowRay) -> bool {
    return (max(max(abs(ray.start.x), abs(ray.start.y)), abs(ray.start.z)) < 0x1p40f)
        & (1.01
        * (ray.error
        + select(ray.end_error,
        min(ray.bend * (max(max(abs(ray.start.x), abs(ray.start.y)), abs(ray.start.z)) * 1.75),
        ray.end_error), ray.bend <= 8.0 * ray.unit)) < 0x1p40f);
}

fn shadow_slabs(ray: ShadowRay) -> Slabs {
    let v = (max(max(abs(ray.start.x), abs(ray.start.y)), abs(ray.start.z)) < 0x1p40f)
        & (1.01
        * (ray.error
        + select(ray.end_error,
        min(ray.bend * (max(max(abs(ray.start.x), abs(ray.start.y)), abs(ray.start.z)) * 1.75),
        ray.end_error), ray.bend <= 8.0 * ray.unit)) < 0x1p40f);
    let of_start = max(max(abs(ray.start.x), abs(ray.start.y)), abs(ray.start.z))
        * 2.0861626e-7;
    let room = of_start
        + (1.01
        * (ray.error
        + select(ray.end_error,
        min(ray.bend * (max(max(abs(ray.start.x), abs(ray.start.y)), abs(ray.start.z)) * 1.75),
        ray.end_error), ray.bend <= 8.0 * ray.unit)) + 0x1p-37f);
    let slack = select(0.0, room, v);
    let start = select(vec3f(0.0), ray.start, v);
    let goes_down = ray.way < vec3f(0.0);
    let steep = max(abs(ray.way), vec3f(0x1p-80f));
    let way = select(steep, -steep, goes_down);
    let aside = select(vec3f(slack), vec3f(-slack), goes_down);
    let inverse = 1.0 / way;
    let near_origin = start + aside;
    let far_origin = start - aside;
    let near_inverse = inverse * 0.9999992;
    let far_inverse = inverse * 1.0000008;
    return Slabs(near_origin, far_origin, near_inverse, far_inverse);
}

fn cosine(ray: ShadowRay, normal: vec3f, normal_error: f32) -> Bounds {
    let cosine = dot3(normal, ray.way) * ray.inv_length;
    let error = 1.01 * (normal_error + ray.turned) + 1.7881393e-6;
    let low = cosine - error;
    let high = cosine + error;
    let high_2 = select(1.0, high, high < 1.0);
    return Bounds(max(0.0, low), max(0.0, high_2));
}

fn sphere_occludes(met: SphereOccluder, ray: ShadowRay) -> Occlusion {
    let l = met.center - ray.start;
    let l2 = dot3(l, l);
    let foot = min(max(dot3(l, ray.way) * ray.inv_square, 0.0), ray.last);
    let q = l - ray.way * foot;
    let distance = sqrt(l2);
    let here = ray.error + ray.unit * (met.place + 14.5 * distance);
    let e = here + min(ray.bend * distance, ray.end_error);
    let in_range = max(e, distance) < 0x1p50f;
    let e_2 = select(0x1p62f, e, in_range);
    let least2 = dot3(q, q);
    let inner = met.r - e_2;
    let outer = met.r + e_2;
    let inner2 = inner * inner * 0.99999905;
    let inner2_2 = select(-1.0, inner2, 0.0 < inner);
    let v = outer * outer * 1.000001;
    let end = l - ray.way;
    let end2 = max(dot3(end, end), ray.end2);
    let v_2 = here + ray.end_error;
    let inner_2 = met.r - v_2;
    let outer_2 = met.r + v_2;
    let inner2_3 = inner_2 * inner_2 * 0.99999905;
    let inner2_4 = select(-1.0, inner2_3, 0.0 < inner_2);
    let end_inside = inner2_4 - end2;
    let end_outside = end2 - outer_2 * outer_2 * 1.000001;
    let clear = max(least2 - v, min(end_inside, inner2_2 - l2));
    let blocked = min(inner2_2 - least2, max(l2 - v, end_outside));
    return Occlusion(blocked, clear);
}

fn plane_occludes(met: PlaneOccluder, ray: ShadowRay) -> Occlusion {
    let l = met.point - ray.start;
    let distance = max(sqrt(dot3(l, l)), 0x1p-50f);
    let here = ray.error + ray.unit * (met.place + 6.0 * distance);
    let e = here + ray.end_error + ray.unit * (6.0 * ray.length);
    let start = dot3(met.normal, l);
    let start_error = 1.01 * met.length * here;
    let stop = dot3(met.normal, l * ray.from_point - ray.way);
    let of_slope = 5.0 * ray.unit * ray.length;
    let stop_error = met.length * max(1.01 * e * ray.from_point, of_slope);
    let in_range = e < 0x1p50f;
    let start_error_2 = select(0x1p100f, start_error, in_range);
    let above = start - start_error_2;
    let below = -start - start_error_2;
    let end_above = stop - stop_error;
    let end_below = -stop - stop_error;
    let blocked = max(min(above, end_below), min(below, end_above));
    let clear = max(min(above, end_above), min(below, end_below));
    let axis = min(abs(met.normal.x), abs(ray.way.x));
    let axis_2 = min(abs(met.normal.y), abs(ray.way.y));
    let axis_3 = min(abs(met.normal.z), abs(ray.way.z));
    let runs_along = max(max(max(axis, axis_2), axis_3), ray.from_point) <= 0.0;
    let clear_2 = select(clear, 1.0, runs_along);
    return Occlusion(blocked, clear_2);
}

fn sphere_occludes_beside(met: SphereOccluder, ray: ShadowRay, side: f32) -> Occlusion {
    let l = met.center - ray.start;
    let l2 = dot3(l, l);
    let foot = min(max(dot3(l, ray.way) * ray.inv_square, 0.0), ray.last);
    let q = l - ray.way * foot;
    let distance = sqrt(l2);
    let here = ray.error + ray.unit * (met.place + 14.5 * distance);
    let e = here + min(ray.bend * distance, ray.end_error);
    let in_range = max(e, distance) < 0x1p50f;
    let e_2 = select(0x1p62f, e, in_range);
    let least2 = dot3(q, q);
    let inner = met.r - e_2;
    let outer = met.r + e_2;
    let inner2 = inner * inner * 0.99999905;
    let inner2_2 = select(-1.0, inner2, 0.0 < inner);
    let v = outer * outer * 1.000001;
    let end = l - ray.way;
    let v_2 = here + ray.end_error;
    let length = sqrt(dot3(end, end));
    let rounding = 1.7881393e-6 * length;
    let along_error = 1.01 * (v_2 + (length + v_2) * ray.turned) + rounding;
    let v_3 = dot3(end, ray.way) * ray.inv_length;
    let stays_inside = min(inner2_2 - l2, 0.5 - side);
    let passes = min(max(least2 - v, v_3 - along_error), side + 0.5);
    let leaves = min(-v_3 - along_error, 0.5 - abs(side));
    let crosses = max(max(inner2_2 - least2, leaves), -side - 0.5);
    let clear = max(passes, stays_inside);
    let blocked = min(crosses, max(l2 - v, side - 0.5));
    return Occlusion(blocked, clear);
}

fn plane_occludes_beside(met: PlaneOccluder, ray: ShadowRay, side: f32) -> Occlusion {
    let l = met.point - ray.start;
    let distance = max(sqrt(dot3(l, l)), 0x1p-50f);
    let here = ray.error + ray.unit * (met.place + 6.0 * distance);
    let e = here + ray.end_error + ray.unit * (6.0 * ray.length);
    let start = dot3(met.normal, l);
    let start_error = 1.01 * met.length * here;
    let in_range = e < 0x1p50f;
    let start_error_2 = select(0x1p100f, start_error, in_range);
    let above = start - start_error_2;
    let below = -start - start_error_2;
    let end_above = -side - 0.5;
    let end_below = side - 0.5;
    let blocked = max(min(above, end_below), min(below, end_above));
    let clear = max(max(min(above, end_above), min(below, end_below)), 0.5 - abs(side));
    return Occlusion(blocked, clear);
}

fn ground_occludes(met: GroundOccluder, ray: ShadowRay) -> Occlusion {
    let is_point = 0.0 < ray.from_point;
    let l = met.center - ray.start;
    let distance = sqrt(dot3(l, l));
    let away = max(sqrt(dot3(ray.start, ray.start)), 0x1p-50f);
    let power = met.k - dot3(ray.start, met.center + l);
    let rounding = 6.0 * away * (met.length + distance) + abs(power);
    let moved = ray.error * (distance + distance + ray.error);
    let v = met.k_error + 1.01 * (ray.unit * rounding + moved);
    let light = ray.start + ray.way;
    let light_error = ray.end_error + ray.unit * sqrt(dot3(light, light));
    let l_2 = met.center - light;
    let distance_2 = sqrt(dot3(l_2, l_2));
    let away_2 = max(sqrt(dot3(light, light)), 0x1p-50f);
    let power_2 = met.k - dot3(light, met.center + l_2);
    let rounding_2 = 6.0 * away_2 * (met.length + distance_2) + abs(power_2);
    let moved_2 = light_error * (distance_2 + distance_2 + light_error);
    let v_2 = met.k_error + 1.01 * (ray.unit * rounding_2 + moved_2);
    let start_outside = power - v;
    let start_inside = -power - v;
    let end_outside = select(1.0, power_2 - v_2, is_point);
    let end_inside = select(-1.0, -power_2 - v_2, is_point);
    let power_3 = sqrt(max(start_outside, 0.0));
    let power_4 = sqrt(max(power + v, 0.0));
    let power_5 = sqrt(max(power_2 - v_2, 0.0));
    let power_6 = sqrt(max(power_2 + v_2, 0.0));
    let l_3 = met.center - ray.start;
    let offset_error = ray.error + ray.unit * (met.length + sqrt(dot3(l_3, l_3)));
    let length = sqrt(dot3(l_3, l_3));
    let rounding_3 = 1.7881393e-6 * length;
    let along_error = 1.01 * (offset_error + (length + offset_error) * ray.turned) + rounding_3;
    let v_3 = dot3(l_3, ray.way) * ray.inv_length;
    let off = ray.error + ray.end_error;
    let low = select(v_3 - along_error, ray.length - off - power_6, is_point);
    let high = select(v_3 + along_error, ray.length + off - power_5, is_point);
    let width = 12.0 * ray.unit * (ray.length + power_4 + power_6);
    let over = min(min(power_3 - high - width, start_outside), end_outside);
    let through = min(min(low - power_4 - width, start_outside), end_outside);
    let crossed = max(min(start_inside, end_outside), min(start_outside, end_inside));
    let clear = max(over, min(start_inside, end_inside));
    let blocked = max(through, crossed);
    return Occlusion(blocked, clear);
}

fn ground_occludes_beside(met: GroundOccluder, ray: ShadowRay, side: f32) -> Occlusion {
    let is_point = 0.0 < ray.from_point;
    let l = met.center - ray.start;
    let distance = sqrt(dot3(l, l));
    let away = max(sqrt(dot3(ray.start, ray.start)), 0x1p-50f);
    let power = met.k - dot3(ray.start, met.center + l);
    let rounding = 6.0 * away * (met.length + distance) + abs(power);
    let moved = ray.error * (distance + distance + ray.error);
    let v = met.k_error + 1.01 * (ray.unit * rounding + moved);
    let light = ray.start + ray.way;
    let light_error = ray.end_error + ray.unit * sqrt(dot3(light, light));
    let l_2 = met.center - light;
    let distance_2 = sqrt(dot3(l_2, l_2));
    let away_2 = max(sqrt(dot3(light, light)), 0x1p-50f);
    let power_2 = met.k - dot3(light, met.center + l_2);
    let rounding_2 = 6.0 * away_2 * (met.length + distance_2) + abs(power_2);
    let moved_2 = light_error * (distance_2 + distance_2 + light_error);
    let v_2 = met.k_error + 1.01 * (ray.unit * rounding_2 + moved_2);
    let start_outside = power - v;
    let start_inside = -power - v;
    let v_3 = side + 0.5;
    let power_3 = sqrt(max(start_outside, 0.0));
    let power_4 = sqrt(max(power + v, 0.0));
    let power_5 = sqrt(max(power_2 - v_2, 0.0));
    let power_6 = sqrt(max(power_2 + v_2, 0.0));
    let is_on = abs(side) <= 0.0;
    let v_4 = select(power_6, 0.0, is_on);
    let l_3 = met.center - ray.start;
    let offset_error = ray.error + ray.unit * (met.length + sqrt(dot3(l_3, l_3)));
    let length = sqrt(dot3(l_3, l_3));
    let rounding_3 = 1.7881393e-6 * length;
    let along_error = 1.01 * (offset_error + (length + offset_error) * ray.turned) + rounding_3;
    let v_5 = dot3(l_3, ray.way) * ray.inv_length;
    let off = ray.error + ray.end_error;
    let low = select(v_5 - along_error, ray.length - off - v_4, is_point);
    let high = select(v_5 + along_error, ray.length + off - select(power_5, 0.0, is_on),
        is_point);
    let width = 12.0 * ray.unit * (ray.length + power_4 + v_4);
    let over = min(min(power_3 - high - width, start_outside), v_3);
    let through = min(min(low - power_4 - width, start_outside), v_3);
    let crossed = max(min(start_inside, side - 0.5), min(start_outside, -side - 0.5));
    let clear = max(over, min(start_inside, 0.5 - side));
    let blocked = max(through, crossed);
    return Occlusion(blocked, clear);
}

fn verdict_with(verdict: Occlusion, next: Occlusion) -> Occlusion {
    let blocked = select(verdict.blocked, 1.0, 0.0 < next.blocked);
    let clear = select(-1.0, verdict.clear, 0.0 < next.clear);
    return Occlusion(blocked, clear);
}

fn behind(given: Bounds, verdict: Occlusion) -> Bounds {
    let low = select(0.0, given.low, 0.0 < verdict.clear);
    let high = select(given.high, 0.0, 0.0 < verdict.blocked);
    return Bounds(low, high);
}

fn light_with(light: LightBounds, weight: vec3f, given: Bounds) -> LightBounds {
    let low = light.low + weight * given.low;
    let high = light.high + weight * given.high;
    return LightBounds(low, high);
}

fn light_on(light: LightBounds, color: vec3f) -> LightBounds {
    let low = color * light.low;
    let high = color * light.high;
    return LightBounds(low, high);
}

fn light_plus(light: LightBounds, other: LightBounds) -> LightBounds {
    let low = light.low + other.low;
    let high = light.high + other.high;
    return LightBounds(low, high);
}

fn light_mean(sum: LightBounds, n: f32, width: Bounds) -> LightBounds {
    let low = sum.low * width.low / n;
    let high = sum.high * width.high / n;
    return LightBounds(low, high);
}
