// A picture in its rectangle of the window.

@group(0) @binding(0) var picture: texture_2d<f32>;

struct Corner {
    @builtin(position) position: vec4f,
    // In the picture, 0 to 1 from its top left corner.
    @location(0) at: vec2f,
}

// One triangle around the rectangle.
@vertex
fn corner(@builtin(vertex_index) i: u32) -> Corner {
    let at = 2.0 * vec2f(f32(i & 1u), f32(i >> 1u));
    return Corner(vec4f(2.0 * at.x - 1.0, 1.0 - 2.0 * at.y, 0.0, 1.0), at);
}

@fragment
fn pixel(corner: Corner) -> @location(0) vec4f {
    return textureLoad(picture, vec2u(corner.at * vec2f(textureDimensions(picture))), 0);
}
