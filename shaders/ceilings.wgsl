// The most that a device does in a second: bytes that it copies, and products with sums.

@group(0) @binding(next) var<storage, read> input: array<vec4u>;
@group(0) @binding(next) var<storage, read_write> output: array<vec4u>;

@compute @workgroup_size(64)
fn copy(
    @builtin(global_invocation_id) invocation: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let i = invocation.y * groups.x * 64u + invocation.x;
    if i < arrayLength(&input) {
        output[i] = input[i];
    }
}

// Eight chains, so that none waits for the result before.
@compute @workgroup_size(64)
fn multiply_add(
    @builtin(global_invocation_id) invocation: vec3u,
    @builtin(num_workgroups) groups: vec3u,
) {
    let i = invocation.y * groups.x * 64u + invocation.x;
    if i >= arrayLength(&output) {
        return;
    }
    let seed = FLOAT(input[i].x);
    let factor = FLOAT(0.75);
    var a = seed;
    var b = seed + FLOAT(1.0);
    var c = seed + FLOAT(2.0);
    var d = seed + FLOAT(3.0);
    var e = seed + FLOAT(4.0);
    var f = seed + FLOAT(5.0);
    var g = seed + FLOAT(6.0);
    var h = seed + FLOAT(7.0);
    for (var step = 0u; step < STEPS; step++) {
        a = fma(a, factor, seed);
        b = fma(b, factor, seed);
        c = fma(c, factor, seed);
        d = fma(d, factor, seed);
        e = fma(e, factor, seed);
        f = fma(f, factor, seed);
        g = fma(g, factor, seed);
        h = fma(h, factor, seed);
    }
    let sum = ((a + b) + (c + d)) + ((e + f) + (g + h));
    output[i] = vec4u(bitcast<u32>(f32(sum)), 0u, 0u, 0u);
}
