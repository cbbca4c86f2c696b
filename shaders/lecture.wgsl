// Twin of src/kernel/lecture.rs: the lecture's formulas, corrected, on world coordinates.

//#if spheres
struct SphereLecture {
    center: vec3f,
    radius: f32,
}

// The numbers of the quadratic equation a t² + b t + k = 0.
struct Quadratic {
    // d·d
    a: f32,
    // 2 d·(o − c)
    b: f32,
    // (o − c)·(o − c) − r²
    k: f32,
    // b² − 4ak
    discriminant: f32,
}

// Lecture 6: the sphere's equation with the ray put in.
fn quadratic(o: vec3f, d: vec3f, c: vec3f, r: f32) -> Quadratic {
    let a = dot3(d, d);
    let b = 2.0 * dot3(d, o - c);
    let k = dot3(o - c, o - c) - r * r;
    return Quadratic(a, b, k, b * b - 4.0 * a * k);
}

// Near and far root; they mean something where the discriminant is not negative.
fn quadratic_roots(q: Quadratic) -> vec2f {
    let root = sqrt(q.discriminant);
    return vec2f((-q.b - root) / (2.0 * q.a), (-q.b + root) / (2.0 * q.a));
}

// Lecture 6. Smallest positive root, or 0 for none.
fn sphere_lecture(o: vec3f, d: vec3f, c: vec3f, r: f32) -> f32 {
    let q = quadratic(o, d, c, r);
    let roots = quadratic_roots(q);
    let t = select(select(0.0, roots.y, roots.y > 0.0), roots.x, roots.x > 0.0);
    return select(0.0, t, q.discriminant >= 0.0);
}

fn closer_sphere(ray: Ray, hit: Hit, sphere: SphereLecture, id: u32) -> Hit {
    return closer(hit, sphere_lecture(ray.origin, ray.direction, sphere.center, sphere.radius), id);
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

fn closer_plane(ray: Ray, hit: Hit, plane: PlaneLecture, id: u32) -> Hit {
    return closer(hit, plane_lecture(ray.origin, ray.direction, plane.point, plane.normal), id);
}
//#end

fn closest(ray: Ray) -> Hit {
    var hit = Hit(params.infinity, 0u);
    //#if spheres
    for (var i = 0u; i < N_SPHERES; i++) {
        hit = closer_sphere(ray, hit, spheres[i], i + 1u);
    }
    //#end
    //#if planes
    for (var i = 0u; i < N_PLANES; i++) {
        hit = closer_plane(ray, hit, planes[i], params.n_spheres + i + 1u);
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
