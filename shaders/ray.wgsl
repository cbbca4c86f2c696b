// Twin of BaselineRay, Hit and the search for the nearest one in src/kernel/baseline.rs.

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

// The numbers of an object, for where this ray starts if a kernel's are for a point.
//#each listed shape
fn shape_at(ray: Ray, index: u32) -> ShapeElement {
    //#if moved
    return shape_from(ray, shapes[index]);
    //#else
    return shapes[index];
    //#end
}
//#end

fn closest(ray: Ray) -> Hit {
    var hit = Hit(params.infinity, 0u);
    //#each listed shape
    for (var i = 0u; i < N_SHAPES; i++) {
        hit = closer_shape(ray, hit, shape_at(ray, i), first_shape() + i);
    }
    //#end
    return hit;
}

fn normal_at(ray: Ray, hit: Hit) -> Vec3 {
    var normal = Vec3(0.0);
    //#each listed shape
    if hit.id - first_shape() < N_SHAPES {
        normal = shape_normal(ray, hit, shape_at(ray, hit.id - first_shape()));
    }
    //#end
    return facing(normal, ray.direction);
}
