// What the device's arithmetic really does. Twin of expected() in src/gpu/self_test/samples.rs.
// A driver may fold a conversion there and back, so what is converted is stored as it is.

struct Operands {
    a: FLOAT,
    b: FLOAT,
}

struct Results {
    sum: FLOAT,
    product: FLOAT,
    quotient: FLOAT,
    root: FLOAT,
    // Constant numerators, for which drivers may take the hardware's reciprocal.
    inverse: FLOAT,
    constant_over: FLOAT,
    larger: FLOAT,
    // The rounding error of a + b by Knuth's two-sum: 0 where the driver rearranges.
    sum_error: FLOAT,
    // a b − round(a b): 0 where fma takes two roundings.
    fma_remainder: FLOAT,
    // round(a b) + b: another number where the driver makes one operation of both.
    product_sum: FLOAT,
}

struct Words {
    // a rounded to f32, which a kernel in f64 does with its results.
    narrowed: f32,
    // One bit for each comparison of a and b that holds.
    compared: u32,
    // From a texel: an integer as a number, a word as it is, a number times a power of two.
    converted: f32,
    kept: u32,
    scaled: f32,
}

@group(0) @binding(next) var<storage, read> operands: array<Operands>;
@group(0) @binding(next) var<storage, read_write> results: array<Results>;
@group(0) @binding(next) var<storage, read_write> words: array<Words>;
@group(0) @binding(next) var texels: texture_storage_2d<rgba32uint, read>;

@compute @workgroup_size(64)
fn self_test(@builtin(global_invocation_id) invocation: vec3u) {
    let i = invocation.x;
    if i >= arrayLength(&operands) {
        return;
    }
    let a = operands[i].a;
    let b = operands[i].b;
    let sum = a + b;
    let b_part = sum - a;
    let a_part = sum - b_part;
    let product = a * b;
    results[i] = Results(
        sum,
        product,
        a / b,
        sqrt(abs(a)),
        1.0 / a,
        NUMERATOR / a,
        max(a, b),
        (a - a_part) + (b - b_part),
        fma(a, b, -product),
        product + b,
    );
    let texel = textureLoad(texels, vec2u(i, 0u));
    let compared = select(0u, 1u, a < b) | select(0u, 2u, a <= b) | select(0u, 4u, a == b)
        | select(0u, 8u, a >= b) | select(0u, 16u, a > b);
    words[i] = Words(
        f32(a),
        compared,
        f32(bitcast<i32>(texel.x)),
        texel.y,
        bitcast<f32>(texel.z) * bitcast<f32>(texel.w),
    );
}
