// t and normals of hits in f64, where both have one f32 that they must be; 0 stands for a t that is left to
// the CPU. src/guard.rs says how far a normal may be off. lit.wgsl starts from the same hits.

@group(0) @binding(next) var<storage, read> ids: array<u32>;
//#if light
//#else
// The words of numbers, as ∞ and −0 must arrive.
@group(0) @binding(next) var<storage, read_write> ts: array<u32>;
@group(0) @binding(next) var<storage, read_write> normals: array<u32>;
//#end
//#if of_scene
@group(0) @binding(next) var<uniform> seen_from: SeenFrom;
@group(0) @binding(next) var<storage, read> scene_spheres: array<SceneSphere>;
//#end
//#if spheres
@group(0) @binding(next) var<storage, read> spheres: array<SphereRecord>;
//#if hierarchy
@group(0) @binding(next) var<storage, read> rest_ids: array<u32>;
//#end
//#end
//#if planes
@group(0) @binding(next) var<storage, read> planes: array<PlaneRecord>;
//#if light
//#else
// The words of unit normals, as the host rounds them.
@group(0) @binding(next) var<storage, read> units: array<vec4u>;
//#end
//#end

//#if light
//#else
struct Surface {
    t: u32,
    normal: vec3u,
}

// The one f32 that both bounds of t round to.
fn t_word(ray: Ray, root: Nearness) -> u32 {
    let is_hit = root.low > 0.0;
    let low = NARROWER / select(1.0, ray.a * root.high, is_hit);
    let high = WIDER / select(1.0, ray.a * root.low, is_hit);
    let is_held = is_hit && low > SMALLEST_T && high < LARGEST_T;
    let t = f32(select(1.0, low, is_held));
    let is_one = t == f32(select(1.0, high, is_held));
    return select(0u, bitcast<u32>(t), is_held && is_one);
}
//#end

//#if unit_normals
fn normalized(v: Vec3) -> Vec3 {
    return v * (1.0 / sqrt(dot3(v, v)));
}

// The unit normal where a ray meets an object, with a bound of its error.
struct Facing {
    normal: Vec3,
    error: f64,
    is_certain: bool,
    // Unless the ray starts in it.
    is_outside: bool,
}
//#end

//#if of_scene
fn half_chord_radius(ray: Ray, l: Vec3, r: f64, is_outside: bool) -> Vec3 {
    let p = l - ray.direction * (dot3(ray.direction, l) * ray.inv_a);
    let half_chord = sqrt(max(r * r - dot3(p, p), 0.0) * ray.inv_a);
    let chord = ray.direction * half_chord;
    return select(p - chord, -p - chord, is_outside);
}

fn record_of(id: u32) -> SphereCertified {
    //#if hierarchy
    //#if spheres
    let n_rest = arrayLength(&rest_ids);
    var at = n_rest;
    for (var i = 0u; i < n_rest; i++) {
        at = select(at, i, rest_ids[i] == id);
    }
    if at < n_rest {
        return spheres[at];
    }
    //#end
    return sphere_seen(scene_spheres[id - 1u]);
    //#else
    return spheres[id - 1u];
    //#end
}

fn sphere_normal(ray: Ray, sphere: SphereCertified, r: f64) -> Facing {
    //#if point
    let l = sphere.center;
    let is_outside = sphere.q_low > 0.0;
    let is_known = true;
    //#else
    let l = sphere.center - ray.origin;
    let k = dot3(l, l) - r * r;
    let is_outside = k > 0.0;
    let is_known = abs(k) > sphere.k_error;
    //#end
    let p = l - ray.direction * (dot3(ray.direction, l) * ray.inv_a);
    let inner = sphere.inner2 - dot3(p, p);
    let width = sphere.outer2 - sphere.inner2;
    let is_apart = inner >= 3.0 * width;
    let chord = width / (2.0 * sqrt(select(1.0, inner, is_apart)));
    let distance = sqrt(dot3(sphere.center, sphere.center)) * LENGTH_ROOM + seen_from.spread;
    let off = (NORMAL_CHORD * chord + NORMAL_DISTANCE * distance) / r + NORMAL_RADIUS;
    let normal = normalized(half_chord_radius(ray, l, r, is_outside));
    return Facing(normal, off, is_apart && is_known, is_outside);
}
//#end

//#if light
//#else
//#if of_scene
fn sphere_surface(ray: Ray, sphere: SphereCertified, r: f64) -> Surface {
    let facing = sphere_normal(ray, sphere, r);
    let low = vec3f(facing.normal - Vec3(facing.error));
    let high = vec3f(facing.normal + Vec3(facing.error));
    let is_one = all(low == high) && facing.is_certain;
    let t = t_word(ray, sphere_nearness(ray, sphere));
    return Surface(select(0u, t, is_one), bitcast<vec3u>(low));
}
//#end

//#if planes
fn plane_surface(ray: Ray, index: u32) -> Surface {
    let plane = planes[index];
    // Where t is certain, so is the side.
    let is_along = dot3(ray.direction, plane.normal) > 0.0;
    let unit = units[index];
    let is_turned = is_along == (unit.w == 0u);
    let sign = select(0u, 0x80000000u, is_turned);
    // Not −0.
    let normal = select(unit.xyz ^ vec3u(sign), vec3u(0u), unit.xyz == vec3u(0u));
    return Surface(t_word(ray, plane_nearness(ray, plane)), normal);
}
//#end

@compute @workgroup_size(WORKGROUP_WIDTH, WORKGROUP_HEIGHT)
fn render(@builtin(global_invocation_id) pixel: vec3u) {
    let index = pixel.y * params.width + pixel.x;
    if pixel.x >= params.width || index >= params.n_rays {
        return;
    }
    let i = Real(params.offset_i + 2 * i32(pixel.x));
    let j = Real(params.offset_j - 2 * i32(pixel.y));
    //#if point
    let ray = ray_from(params.origin, Vec3(0.0), camera_direction(i, j));
    //#else
    let ray = ray_from(camera_origin(i, j), Vec3(0.0), params.forward);
    //#end
    let id = ids[index];
    var surface = Surface(0u, vec3u(0u));
    if id == 0u {
        surface.t = INFINITY;
    }
    //#if of_scene
    if id != 0u && id <= params.n_spheres {
        surface = sphere_surface(ray, record_of(id), abs(scene_spheres[id - 1u].radius));
    }
    //#end
    //#if planes
    if id > params.n_spheres && id <= params.n_spheres + params.n_planes {
        surface = plane_surface(ray, id - params.n_spheres - 1u);
    }
    //#end
    ts[index] = surface.t;
    normals[3u * index] = surface.normal.x;
    normals[3u * index + 1u] = surface.normal.y;
    normals[3u * index + 2u] = surface.normal.z;
}
//#end
