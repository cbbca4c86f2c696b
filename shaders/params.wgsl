// What all rays of a dispatch share.

// Member order is checked against src/gpu/layout.rs by a test.
//#if double
struct Params {
    forward: vec3<f64>,
    n_spheres: u32,
    n_planes: u32,
    right: vec3<f64>,
    step: f64,
    true_up: vec3<f64>,
    infinity: f64,
    origin: vec3<f64>,
    n_rays: u32,
    // Twice the offset of the tile's first pixel from the picture's centre: right, up.
    offset_i: i32,
    offset_j: i32,
    width: u32,
}
//#else
struct Params {
    forward: vec3f,
    n_spheres: u32,
    right_step: vec3f,
    n_planes: u32,
    true_up_step: vec3f,
    infinity: f32,
    origin: vec3f,
    n_rays: u32,
    // Twice the offset of the tile's first pixel from the picture's centre: right, up.
    offset_i: i32,
    offset_j: i32,
    width: u32,
    padding: u32,
}
//#end

@group(0) @binding(next) var<uniform> params: Params;
