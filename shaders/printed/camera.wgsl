// Printed from the Rust text; see tests/library/printed.rs.

fn camera_direction(forward: Vec3, right: Vec3, true_up: Vec3, across: Real, up: Real) -> Vec3 {
    return forward + right * across + true_up * up;
}

fn camera_origin(right: Vec3, true_up: Vec3, across: Real, up: Real) -> Vec3 {
    return right * across + true_up * up;
}
