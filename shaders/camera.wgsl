// Twin of CameraF32 in src/camera.rs.

// Centre ray of the pixel at twice the offset (i, j) from the picture's centre; both are integers,
// exact in f32 up to 2^24. right_step and true_up_step hold h/H already.
fn camera_direction(i: f32, j: f32) -> vec3f {
    return (params.forward + params.right_step * i) + params.true_up_step * j;
}
