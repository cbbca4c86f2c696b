// What the device's arithmetic really does. Twin of expected() in src/gpu/self_test.rs.

struct Operands {
    a: FLOAT,
    b: FLOAT,
}

struct Results {
    sum: FLOAT,
    product: FLOAT,
    quotient: FLOAT,
    root: FLOAT,
    // The rounding error of a + b by Knuth's two-sum: 0 where the driver rearranges.
    sum_error: FLOAT,
    // a b − round(a b): 0 where fma takes two roundings.
    fma_remainder: FLOAT,
    // a rounded to f32, which a kernel in f64 does with its results.
    narrowed: FLOAT,
}

@group(0) @binding(next) var<storage, read> operands: array<Operands>;
@group(0) @binding(next) var<storage, read_write> results: array<Results>;

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
        (a - a_part) + (b - b_part),
        fma(a, b, -product),
        FLOAT(f32(a)),
    );
}
