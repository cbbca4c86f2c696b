// The steps of a pixel, or of a sample, from the picture's centre, by its column and row in the tile: integers, exact in f32 up to
// 2^24.
fn steps_at(place: vec2u) -> vec2<Real> {
    return vec2(Real(params.offset_i + 2 * i32(place.x)), Real(params.offset_j - 2 * i32(place.y)));
}

// Its ray. The formulas are printed: printed/camera.wgsl.
fn ray_at(place: vec2u) -> Ray {
    let steps = params.step * steps_at(place);
    let across = steps.x;
    let up = steps.y;
    //#if point
    let direction = camera_direction(params.forward, params.right, params.true_up, across, up);
    return ray_from(params.origin, direction);
    //#else
    let aside = camera_origin(params.right, params.true_up, across, up);
    return ray_from(params.origin + aside, params.forward);
    //#end
}
