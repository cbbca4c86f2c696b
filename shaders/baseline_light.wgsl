// Light as everyone computes it, for the kernels without a proof: from the point that a ray hits, another ray goes
// to each lamp, and what the kernel finds on it is in the way. It starts on the surface as the kernel's numbers
// have it, or an epsilon away. Twin of src/lighting/baseline.rs.

// Three numbers a ray.
@group(0) @binding(next) var<storage, read_write> lights: array<Real>;
@group(0) @binding(next) var<uniform> lighting: Lighting;

// What a ray from anywhere meets first.
fn closest_from_anywhere(ray: Ray) -> Hit {
    var hit = Hit(params.infinity, 0u);
    //#each listed shape
    for (var i = 0u; i < N_SHAPES; i++) {
        //#if relative
        hit = closer_shape(ray, hit, shape_from(ray, shapes[i]), first_shape() + i);
        //#else
        hit = closer_shape(ray, hit, shapes[i], first_shape() + i);
        //#end
    }
    //#end
    return hit;
}

// Whether the shadow ray, which starts epsilon nearer to the lamp, meets something before it. The lamp is at s = 1.
fn in_the_way(point: Vec3, way: Vec3, length: Real, is_endless: bool) -> bool {
    let step = lighting.epsilon / length;
    let origin = point + way * step;
    let hit = closest_from_anywhere(ray_from(origin, way));
    return hit.id != 0u && (is_endless || hit.t < 1.0 - step);
}

// The way from a hit to a lamp.
struct Way {
    way: Vec3,
    // n·ω
    cosine: Real,
    is_blocked: bool,
}

fn way_to(ray: Ray, hit: Hit, normal: Vec3, lamp: Lamp) -> Way {
    let point = ray.origin + ray.direction * hit.t;
    var way = lamp.at;
    if lamp.kind == LAMP_EYE {
        way = -(ray.direction * hit.t);
    }
    if lamp.kind == LAMP_POINT {
        way = lamp.at - point;
    }
    let length = sqrt(dot3(way, way));
    let cosine = dot3(normal, way) * (1.0 / length);
    var is_blocked = false;
    if cosine > 0.0 && lamp.shadows != 0u {
        is_blocked = in_the_way(point, way, length, lamp.kind == LAMP_SUN);
    }
    return Way(way, cosine, is_blocked);
}

// With what a lamp gives, I n·ω, if it counts.
fn with_lamp(sum: Vec3, ray: Ray, hit: Hit, normal: Vec3, lamp: Lamp) -> Vec3 {
    let way = way_to(ray, hit, normal, lamp);
    return select(sum, sum + lamp.weight * way.cosine, way.cosine > 0.0 && !way.is_blocked);
}

// The light that a ray's hit gets: the ambient one, and that of all lamps.
fn light(ray: Ray) -> Vec3 {
    let hit = closest(ray);
    var sum = lighting.ambient;
    if hit.id != 0u {
        let normal = normal_at(ray, hit);
        //#each lamp
        sum = with_lamp(sum, ray, hit, normal, lamps[INDEX]);
        //#end
    }
    return sum;
}

@compute @workgroup_size(WORKGROUP_WIDTH, WORKGROUP_HEIGHT)
fn render(@builtin(global_invocation_id) pixel: vec3u) {
    let index = pixel.y * params.width + pixel.x;
    let seen = light(ray_at(pixel.xy));
    if pixel.x < params.width && index < params.n_rays {
        lights[3u * index] = seen.x;
        lights[3u * index + 1u] = seen.y;
        lights[3u * index + 2u] = seen.z;
    }
}
