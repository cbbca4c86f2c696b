// Twin of PlainRay and Hit in src/kernel/plain.rs.

struct Ray {
    origin: Vec3,
    origin_low: Vec3,
    direction: Vec3,
    a: Real,
    inv_a: Real,
}

struct Hit {
    t: Real,
    id: u32,
}

fn ray_from(origin: Vec3, direction: Vec3) -> Ray {
    return ray_from_parts(origin, Vec3(0.0), direction);
}

fn ray_from_parts(origin: Vec3, origin_low: Vec3, direction: Vec3) -> Ray {
    let a = dot3(direction, direction);
    return Ray(origin, origin_low, direction, a, 1.0 / a);
}

// The nearer of the hit so far and a candidate, whose t is 0 where there is none. Equal t: the
// lower id, which comes first, stays.
fn closer(hit: Hit, t: Real, id: u32) -> Hit {
    let is_closer = t > 0.0 && t < hit.t;
    return Hit(select(hit.t, t, is_closer), select(hit.id, id, is_closer));
}
