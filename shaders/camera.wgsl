// The ray of a pixel, or of a sample, by its column and row in the tile. Its formulas are printed: printed/camera.wgsl.
fn ray_at(place: vec2u) -> Ray {
    // Integers, exact in f32 up to 2^24.
    let across = params.step * Real(params.offset_i + 2 * i32(place.x));
    let up = params.step * Real(params.offset_j - 2 * i32(place.y));
    //#if point
    let direction = camera_direction(params.forward, params.right, params.true_up, across, up);
    return ray_from(params.origin, direction);
    //#else
    let aside = camera_origin(params.right, params.true_up, across, up);
    return ray_from(params.origin + aside, params.forward);
    //#end
}
