// Twin of V3::dot in src/num/mod.rs and of facing in src/kernel/baseline.rs.

// a·b, summed from left to right on every device: the built-in dot leaves the order open.
fn dot3(a: Vec3, b: Vec3) -> Real {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// v / ‖v‖, turned so that it faces against direction.
fn facing(v: Vec3, direction: Vec3) -> Vec3 {
    let unit = v * (1.0 / sqrt(dot3(v, v)));
    return select(unit, -unit, dot3(unit, direction) > 0.0);
}
