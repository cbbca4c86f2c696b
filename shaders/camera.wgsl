// Twin of Frame in src/rays/camera.rs, with the origin that PlainRays in src/kernel/plain.rs adds.

// Of the pixel at twice the offset (i, j) from the picture's centre; both are integers, exact in f32
// up to 2^24. right_step and true_up_step hold h/H already.
//#if point
fn camera_direction(i: Real, j: Real) -> Vec3 {
    //#if double
    return (params.forward + params.right * (params.step * i)) + params.true_up * (params.step * j);
    //#else
    return (params.forward + params.right_step * i) + params.true_up_step * j;
    //#end
}
//#end
//#if parallel
fn camera_origin(i: Real, j: Real) -> Vec3 {
    //#if double
    return params.origin + (params.right * (params.step * i) + params.true_up * (params.step * j));
    //#else
    return params.origin + (params.right_step * i + params.true_up_step * j);
    //#end
}
//#end
