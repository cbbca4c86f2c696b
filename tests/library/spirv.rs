//! The SPIR-V that the program hands to the driver: nothing that the scene does not need, and
//! `NoContraction` on every float result. The words are walked here independently of the code that
//! decorates them.

use std::collections::HashSet;
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::gpu::{Shader, compile};
use kugelblitz::kernel::Float;
use kugelblitz::prepare::{FEW_SPHERES, Finding, LightKey, Prepared, ShaderKey};
use kugelblitz::rays::{Bundle, Pixels, View};
use kugelblitz::trace::{Kernel, Rays, Wants};
use kugelblitz_tests::{camera, scene, sphere};

/// `(opcode, operands)` of each instruction.
fn walk(words: &[u32]) -> Vec<(u32, &[u32])> {
    assert_eq!(words[0], 0x0723_0203, "SPIR-V's magic number");
    let mut rest = &words[5..];
    let mut found = Vec::new();
    while let [first, ..] = rest {
        let length = (first >> 16) as usize;
        assert!(length > 0 && length <= rest.len(), "a length of {length} words");
        found.push((first & 0xffff, &rest[1..length]));
        rest = &rest[length..];
    }
    found
}

/// Instructions with a float result that round nothing, by the numbers of the SPIR-V specification.
fn is_exact(op: u32, operands: &[u32]) -> bool {
    match op {
        // Undef, constants, function, parameter and call, loads, composites, conversions (their
        // rounding is not a contraction), bitcast, select, phi.
        1 | 43..=46 | 48..=52 | 54 | 55 | 57 | 61 | 77..=84 | 110..=115 | 124 | 169 | 245 => true,
        // Extended instructions: FAbs, FSign, Floor, Ceil, FMin, FMax, FClamp, NMin, NMax, NClamp.
        12 => matches!(operands[3], 4 | 6 | 8 | 9 | 37 | 40 | 43 | 79 | 80 | 81),
        _ => false,
    }
}

/// The number of decorated float results, or what is not decorated.
fn check_no_contraction(words: &[u32]) -> Result<usize, String> {
    let instructions = walk(words);
    let mut floats = HashSet::new();
    for (op, operands) in &instructions {
        match op {
            // OpTypeFloat, then vectors and matrices of them.
            22 => drop(floats.insert(operands[0])),
            23 | 24 if floats.contains(&operands[1]) => drop(floats.insert(operands[0])),
            _ => {}
        }
    }
    let decorated: HashSet<u32> = instructions
        .iter()
        .filter(|(op, operands)| *op == 71 && operands.get(1) == Some(&42))
        .map(|(_, operands)| operands[0])
        .collect();
    let mut n_decorated = 0;
    // Opcodes without a result whose first operand could look like a type: OpName … OpDecorate are
    // before the functions, OpStore, OpBranchConditional, OpReturnValue within.
    let no_result = [62, 63, 248, 249, 250, 251, 253, 254, 246, 247, 225, 99];
    let functions = instructions.iter().skip_while(|(op, _)| *op != 54);
    for (op, operands) in functions.filter(|(op, _)| !no_result.contains(op)) {
        let is_float = operands.len() >= 2 && floats.contains(&operands[0]);
        if !is_float || is_exact(*op, operands) {
            continue;
        }
        if !decorated.contains(&operands[1]) {
            return Err(format!("the result of opcode {op} {operands:?} is not decorated"));
        }
        n_decorated += 1;
    }
    Ok(n_decorated)
}

fn count(words: &[u32], opcode: u32) -> usize {
    walk(words).iter().filter(|(op, _)| *op == opcode).count()
}

/// Numbers of the bindings, sorted.
fn bindings(words: &[u32]) -> Vec<u32> {
    let mut numbers: Vec<u32> = walk(words)
        .iter()
        .filter(|(op, operands)| *op == 71 && operands[1] == 33)
        .map(|(_, operands)| operands[2])
        .collect();
    numbers.sort_unstable();
    numbers
}

fn key(kernel: Kernel, bundle: Bundle, spheres: Finding) -> ShaderKey {
    ShaderKey {
        kernel,
        bundle,
        spheres,
        n_spheres: 3,
        close: false,
        n_planes: 2,
        surface: false,
        light: None,
    }
}

/// All that the program can ask for.
fn all_keys() -> Vec<ShaderKey> {
    use Finding::{Listed, Tree};
    let mut all = Vec::new();
    for kernel in Kernel::ALL {
        let is_certified = kernel == Kernel::Certified;
        for bundle in Bundle::ALL {
            let findings = if is_certified { &[Listed, Tree][..] } else { &[Listed] };
            for (n_spheres, n_planes) in [(0, 0), (3, 0), (0, 2), (3, 2), (200, 150)] {
                for &spheres in findings {
                    let key = ShaderKey { n_spheres, n_planes, ..key(kernel, bundle, spheres) };
                    all.push(key);
                    if is_certified && n_spheres > 0 {
                        all.push(ShaderKey { close: true, ..key });
                    }
                    if !is_certified {
                        all.push(ShaderKey { surface: true, ..key });
                    }
                }
            }
        }
    }
    all
}

/// The shaders for the light on the hits of kernels without a proof.
fn keys_of_plain_light() -> Vec<ShaderKey> {
    let mut all = Vec::new();
    for kernel in Kernel::ALL.into_iter().filter(|&kernel| kernel != Kernel::Certified) {
        for bundle in [Bundle::Point, Bundle::Parallel] {
            for (n_spheres, n_planes) in [(0, 0), (3, 0), (0, 2), (3, 2), (40, 2), (200, 150)] {
                for n_lamps in [0, 3, 100, 1000] {
                    let key = key(kernel, bundle, Finding::Listed);
                    let light = Some(LightKey::Plain { n_lamps });
                    all.push(ShaderKey { n_spheres, n_planes, light, ..key });
                }
            }
        }
    }
    all
}

/// The shaders for bytes in the light of the kernel with a proof.
fn keys_of_certified_light() -> Vec<ShaderKey> {
    let mut all = Vec::new();
    for bundle in [Bundle::Point, Bundle::Parallel] {
        for (n_spheres, n_planes) in [(0, 0), (3, 0), (0, 2), (3, 2), (150, 2)] {
            for (n_lamps, n_samples) in [(0, 1), (3, 1), (3, 3), (100, 4)] {
                let light = LightKey::Certified { n_samples, n_lamps, n_spheres, n_planes };
                let key = key(Kernel::Certified, bundle, Finding::Listed);
                all.push(ShaderKey { n_spheres, n_planes, light: Some(light), ..key });
                all.push(ShaderKey { close: n_spheres > 0, ..all[all.len() - 1] });
            }
        }
    }
    all
}

fn shader(key: &ShaderKey) -> (Shader, Vec<u32>) {
    let shader = compile(key).unwrap_or_else(|error| panic!("{error}: {key:?}"));
    let words = shader.spirv().unwrap();
    (shader, words)
}

/// A module that lacks one decoration is noticed, whichever it is.
#[test]
fn sabotage_a_missing_decoration_is_noticed() {
    for kernel in Kernel::ALL {
        let (_, words) = shader(&key(kernel, Bundle::Point, Finding::Listed));
        let mut n_removed = 0;
        for at in 5..words.len() - 2 {
            if words[at] == (3 << 16 | 71) && words[at + 2] == 42 {
                let without = [&words[..at], &words[at + 3..]].concat();
                assert!(check_no_contraction(&without).is_err(), "word {at}");
                n_removed += 1;
            }
        }
        assert_eq!(Ok(n_removed), check_no_contraction(&words), "{}", kernel.name());
    }
}

fn has(shader: &Shader, word: &str) -> bool {
    let names = |name: &Option<String>| {
        name.as_ref().is_some_and(|name| name.to_lowercase().contains(word))
    };
    let module = &shader.module;
    module.functions.iter().any(|(_, function)| names(&function.name))
        || module.global_variables.iter().any(|(_, variable)| names(&variable.name))
        || module.types.iter().any(|(_, kind)| names(&kind.name))
}

/// The end of the names of a kernel's records, which `double` has in common with `stable`.
fn records_of(kernel: Kernel) -> String {
    kernel.about().wgsl.records.to_lowercase()
}

/// Names that a shader has, or has not, by what it is asked for.
fn names(key: &ShaderKey) -> Vec<(&'static str, bool)> {
    let [has_spheres, has_planes] = [key.n_spheres, key.n_planes].map(|n| n > 0);
    let mut names = vec![
        ("sphere", has_spheres || key.spheres == Finding::Tree),
        ("plane", has_planes),
        ("boxes", key.spheres == Finding::Tree),
    ];
    match key.light {
        None => {
            names.extend(["light", "lamp", "in_the_way", "anywhere"].map(|name| (name, false)));
            names.push(("camera", key.bundle != Bundle::Free));
            names.push(("rayrecord", key.bundle == Bundle::Free));
            names.push(("normal", key.surface));
        }
        Some(LightKey::Certified { n_lamps, .. }) => {
            names.push(("close", key.close));
            let of_lamps = ["lamp", "shadow", "verdict", "cosine"];
            names.extend(of_lamps.map(|name| (name, n_lamps > 0)));
        }
        Some(LightKey::Plain { n_lamps }) => {
            names.extend([("light", true), ("in_the_way", n_lamps > 0)]);
            // Rays from anywhere have other numbers only where those of the picture's rays don't hold.
            let is_moved =
                n_lamps > 0 && key.bundle == Bundle::Point && key.kernel != Kernel::Lecture;
            names.push(("sphere_from", is_moved && has_spheres));
            names.push(("plane_from", is_moved && has_planes));
        }
    }
    names
}

fn n_bindings(key: &ShaderKey) -> usize {
    let objects = usize::from(key.n_spheres > 0) + usize::from(key.n_planes > 0);
    match key.light {
        // Results, parameters; the list of rays; the tree.
        None => {
            let list = usize::from(key.bundle == Bundle::Free);
            let tree = if key.spheres == Finding::Tree { 3 } else { 0 };
            2 + objects + list + tree + if key.surface { 2 } else { 0 }
        }
        // Parameters and results, colours, the ends of bytes, and what is the same for all; and of lamps these and what may be
        // in their way.
        Some(LightKey::Certified { n_lamps, .. }) => {
            5 + objects + if n_lamps > 0 { 1 + objects } else { 0 }
        }
        // Parameters and results, what is the same for all, and lamps.
        Some(LightKey::Plain { n_lamps }) => 3 + objects + usize::from(n_lamps > 0),
    }
}

/// Nothing that the scene does not need: of objects what there is, one kernel, one source of rays, light in no shader but
/// its own, f64 where it is asked for; and all of it decorated.
#[test]
fn a_shader_has_what_it_is_asked_for() {
    const OP_FUNCTION: u32 = 54;
    const OP_CAPABILITY: u32 = 17;
    const FLOAT64: u32 = 10;
    let all = [all_keys(), keys_of_plain_light(), keys_of_certified_light()].concat();
    for key in all {
        let (whole, words) = shader(&key);
        let n_floats =
            check_no_contraction(&words).unwrap_or_else(|what| panic!("{what}: {key:?}"));
        // A ray's `a` and `1/a` alone are six operations.
        assert!(n_floats >= 6, "{n_floats} float results: {key:?}");
        let without_gaps: Vec<u32> = (0..n_bindings(&key) as u32).collect();
        assert_eq!(bindings(&words), without_gaps, "{key:?}");
        for (name, is_there) in names(&key) {
            assert_eq!(has(&whole, name), is_there, "{name}: {key:?}");
        }
        let asks = walk(&words).contains(&(OP_CAPABILITY, &[FLOAT64][..]));
        assert_eq!(asks, key.kernel.about().float == Float::F64, "{key:?}");
        if key.kernel == Kernel::Certified && key.light.is_some() {
            continue;
        }
        // The SPIR-V holds what the module holds: as many functions, and the entry point.
        assert_eq!(count(&words, OP_FUNCTION), whole.module.functions.len() + 1);
        let objects = key.n_spheres + key.n_planes > 0;
        for kernel in Kernel::ALL {
            let expected = objects && records_of(kernel) == records_of(key.kernel);
            let has_records = has(&whole, &records_of(kernel));
            assert_eq!(has_records, expected, "{}, {key:?}", kernel.name());
        }
        if key.n_planes > 0 && key.light.is_none() {
            let (_, without) = shader(&ShaderKey { n_planes: 0, ..key });
            assert!(check_no_contraction(&without).unwrap() < n_floats, "{key:?}");
        }
    }
}

#[test]
fn a_tree_only_where_there_are_many_spheres() {
    let camera = camera(DVec3::Z * 9.0, DVec3::ZERO);
    let rays = Rays::Pixels(Pixels::whole(View::new(&camera), 64, 48));
    for n in [0, 1, FEW_SPHERES, FEW_SPHERES + 1, 3000] {
        let spheres = (0..n).map(|i| sphere(DVec3::X * i as f64, 1.0)).collect();
        let scene = Arc::new(scene(spheres, vec![]));
        for kernel in Kernel::ALL {
            let prepared = Prepared::new(Arc::clone(&scene), kernel, &rays).unwrap();
            let has_tree = prepared.shader_key(Wants::default()).spheres == Finding::Tree;
            let is_many = kernel == Kernel::Certified && n > FEW_SPHERES;
            assert_eq!(has_tree, is_many, "{n} spheres, {}", kernel.name());
        }
    }
}
