// Twin of src/kernel/lecture.rs: the lecture's formulas, corrected, on world coordinates.

//#if spheres
struct SphereLecture {
    center: vec3f,
    radius: f32,
}

// Lecture 6: a t² + b t + k = 0. Smallest positive root, or 0 for none.
fn sphere_lecture(o: vec3f, d: vec3f, c: vec3f, r: f32) -> f32 {
    let a = dot3(d, d);
    let b = 2.0 * dot3(d, o - c);
    let k = dot3(o - c, o - c) - r * r;
    let discriminant = b * b - 4.0 * a * k;
    if !(discriminant >= 0.0) {
        return 0.0;
    }
    let root = sqrt(discriminant);
    let near = (-b - root) / (2.0 * a);
    let far = (-b + root) / (2.0 * a);
    return select(select(0.0, far, far > 0.0), near, near > 0.0);
}
//#end

//#if planes
struct PlaneLecture {
    point: vec3f,
    normal: vec3f,
}

// Lecture 5.2: t = ((a − o)·n) / (d·n). Positive t, or 0 for none.
fn plane_lecture(o: vec3f, d: vec3f, a: vec3f, n: vec3f) -> f32 {
    let t = dot3(a - o, n) / dot3(d, n);
    return select(0.0, t, t > 0.0);
}
//#end

fn closest(ray: Ray) -> Hit {
    var hit = Hit(params.infinity, 0u);
    //#if spheres
    for (var i = 0u; i < params.n_spheres; i++) {
        let t = sphere_lecture(ray.origin, ray.direction, spheres[i].center, spheres[i].radius);
        if t > 0.0 && t < hit.t {
            hit = Hit(t, i + 1u);
        }
    }
    //#end
    //#if planes
    for (var i = 0u; i < params.n_planes; i++) {
        let t = plane_lecture(ray.origin, ray.direction, planes[i].point, planes[i].normal);
        if t > 0.0 && t < hit.t {
            hit = Hit(t, params.n_spheres + i + 1u);
        }
    }
    //#end
    return hit;
}

//#if surface
fn normal_at(ray: Ray, hit: Hit) -> vec3f {
    let p = ray.origin + ray.direction * hit.t;
    //#if spheres
    if hit.id <= params.n_spheres {
        return facing(p - spheres[hit.id - 1u].center, ray.direction);
    }
    //#end
    //#if planes
    return facing(planes[hit.id - 1u - params.n_spheres].normal, ray.direction);
    //#else
    return vec3f(0.0);
    //#end
}
//#end
