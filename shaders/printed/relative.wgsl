// Printed from the Rust text; see tests/library/printed.rs.

fn sphere_stable(ray: Ray, l: Vec3, r: Real, k: Real) -> Real {
    let b = dot3(ray.direction, l);
    let p = l - ray.direction * (b * ray.inv_a);
    let delta = r * r - dot3(p, p);
    let h = select(-1.0, sqrt(ray.a * delta), 0.0 <= delta);
    let is_ahead = 0.0 < b;
    let q = select(b - h, b + h, is_ahead);
    let one = k / q;
    let other = q * ray.inv_a;
    let near = select(other, one, is_ahead);
    let far = select(one, other, is_ahead);
    return select(0.0, select(select(0.0, far, 0.0 < far), near, 0.0 < near), 0.0 <= h);
}

fn from_center(ray: Ray, l: Vec3, r: Real, k: Real) -> Vec3 {
    let b = dot3(ray.direction, l);
    let p = l - ray.direction * (b * ray.inv_a);
    let delta = r * r - dot3(p, p);
    let half_chord = ray.direction
        * (select(-1.0, sqrt(ray.a * delta), 0.0 <= delta) * ray.inv_a);
    let is_outside = 0.0 < k;
    return select(half_chord, -half_chord, is_outside) - p;
}

fn plane_stable(d: Vec3, n_offset: Real, n: Vec3) -> Real {
    let t = n_offset / dot3(d, n);
    return select(0.0, t, 0.0 < t);
}
