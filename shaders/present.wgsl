// Shows a picture in a part of the window. All colours are sRGB bytes, red lowest, on their way to
// a target that takes them as they are.

// Member order is checked against src/view/screen.rs by a test.
struct Present {
    // Where the picture is shown, px of the window.
    left: u32,
    top: u32,
    shown_width: u32,
    shown_height: u32,
    // Size of the picture; another one for the moment after the window was resized.
    width: u32,
    height: u32,
    // Columns of the window left of this one show the first picture, the others the second.
    divider: u32,
    // Bit 0: the first picture has paint; bit 1: the second has.
    painted: u32,
}

@group(0) @binding(next) var<uniform> present: Present;
// Colours by id; the last one stands for rays that are not decided yet.
@group(0) @binding(next) var<storage, read> palette: array<u32>;
@group(0) @binding(next) var<storage, read> first_ids: array<u32>;
@group(0) @binding(next) var<storage, read> second_ids: array<u32>;
// Colours of single pixels, where their alpha is not 0.
@group(0) @binding(next) var<storage, read> first_paint: array<u32>;
@group(0) @binding(next) var<storage, read> second_paint: array<u32>;

// One triangle that covers everything.
@vertex
fn cover(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4f {
    let x = f32(corner & 1u) * 4.0 - 1.0;
    let y = f32(corner >> 1u) * 4.0 - 1.0;
    return vec4f(x, y, 0.0, 1.0);
}

@fragment
fn show(@builtin(position) at: vec4f) -> @location(0) vec4f {
    let column = (u32(at.x) - present.left) * present.width / present.shown_width;
    let row = (u32(at.y) - present.top) * present.height / present.shown_height;
    let index = row * present.width + column;
    let is_first = u32(at.x) < present.divider;
    var id: u32;
    if is_first {
        id = first_ids[index];
    } else {
        id = second_ids[index];
    }
    var color = palette[min(id, arrayLength(&palette) - 1u)];
    if present.painted != 0u {
        var paint = 0u;
        if is_first && (present.painted & 1u) != 0u {
            paint = first_paint[index];
        }
        if !is_first && (present.painted & 2u) != 0u {
            paint = second_paint[index];
        }
        color = select(color, paint, (paint >> 24u) != 0u);
    }
    return vec4f(unpack4x8unorm(color).rgb, 1.0);
}
