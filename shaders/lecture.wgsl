// Twin of src/kernel/lecture.rs: the lecture's formulas, corrected, on world coordinates.

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

// At a hit, of any length.
fn sphere_normal(ray: Ray, hit: Hit, sphere: SphereLecture) -> vec3f {
    return ray.origin + ray.direction * hit.t - sphere.center;
}

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

fn plane_normal(ray: Ray, hit: Hit, plane: PlaneLecture) -> vec3f {
    return plane.normal;
}
