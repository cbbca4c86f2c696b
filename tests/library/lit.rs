//! Bytes of means in `shaders/lit.wgsl`, as naga understands it.

use std::collections::HashMap;

use kugelblitz::gpu::compile;
use kugelblitz::num::round_up;
use kugelblitz::prepare::{Finding, LightKey, ShaderKey};
use kugelblitz::rays::Bundle;
use kugelblitz::scene::Edges;
use kugelblitz::trace::Kernel;
use kugelblitz_tests::wgsl::{Machine, Value};

/// The byte whose range holds both numbers, 256 where none does, also where the guess is farthest from it: at the ends of all
/// ranges.
#[test]
fn bytes_are_those_whose_ranges_hold_both_bounds() {
    let light = LightKey::Certified { n_samples: 1, n_lamps: 0, n_spheres: 0, n_planes: 0 };
    let key = ShaderKey {
        kernel: Kernel::Certified,
        bundle: Bundle::Point,
        spheres: Finding::Listed,
        n_spheres: 0,
        close: false,
        n_planes: 0,
        surface: false,
        light: Some(light),
    };
    let shader = compile(&key).unwrap();
    let edges = Edges::srgb8();
    let begin = |byte: u16| match byte {
        0 => -1.0,
        1..=255 => round_up(edges.range(byte).0),
        _ => (1u128 << 90) as f32,
    };
    let ends = |byte: u16| [begin(byte), begin(byte + 1), begin(byte + 2), 0.0].map(Value::F32);
    let ends = Value::Parts((0..=255).map(|byte| Value::Parts(ends(byte).to_vec())).collect());
    let globals = HashMap::from([("ends", ends)]);
    let mut machine = Machine::new(&shader.module, &globals);
    let mut check = |low: f32, high: f32| {
        let byte = edges.number(low.into());
        let expected = if f64::from(high) < edges.range(byte).1 { byte } else { 256 };
        let found = machine.evaluate("byte_of", vec![Value::F32(low), Value::F32(high)]);
        assert_eq!(found, Value::U32(expected.into()), "{low:?} {high:?}");
    };
    for byte in 1..=255 {
        let (first, last) = (begin(byte), begin(byte - 1).max(0.0));
        for x in [last, (first + last) / 2.0, first.next_down(), first, first.next_up()] {
            check(x, x);
        }
        check(last, first.next_down());
        check(first.next_down(), first);
    }
    for bright in [1.0, 7.0, 1e9] {
        check(bright, bright);
        check(0.5, bright);
    }
    assert_eq!(machine.not_finite, Vec::<String>::new());
}
