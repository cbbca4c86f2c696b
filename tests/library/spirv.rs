//! The SPIR-V that the program hands to the driver: nothing that the scene does not need, and
//! `NoContraction` on every float result. The words are walked here independently of the code that
//! decorates them.

use std::collections::HashSet;
use std::sync::Arc;

use glam::DVec3;
use kugelblitz::gpu::compile;
use kugelblitz::kernel::FloatType;
use kugelblitz::prepare::{FEW_SPHERES, LightKey, Prepared, ShaderKey};
use kugelblitz::query::{Kernel, Outputs, Rays};
use kugelblitz::rays::{Lens, Pixels, View};
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

/// Functions and global variables that nothing uses.
fn unused(words: &[u32]) -> Vec<u32> {
    let instructions = walk(words);
    let is_global = |(op, operands): &(u32, &[u32])| *op == 59 && operands[2] != 7;
    let made = instructions.iter().filter(|made| made.0 == 54 || is_global(made));
    // By the entry point, or in a function.
    let (heads, functions): (Vec<_>, Vec<_>) = instructions.iter().partition(|(op, _)| *op == 15);
    let functions = functions.into_iter().skip_while(|(op, _)| *op != 54);
    let uses = functions.map(|(op, operands)| if op == 54 { &operands[2..] } else { operands });
    let used: HashSet<u32> =
        heads.iter().map(|head| head.1[1]).chain(uses.flatten().copied()).collect();
    made.map(|(_, operands)| operands[1]).filter(|id| !used.contains(id)).collect()
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

fn key(kernel: Kernel, lens: Option<Lens>, tree: bool) -> ShaderKey {
    ShaderKey {
        kernel,
        lens,
        tree,
        n_spheres: 3,
        close: false,
        n_planes: 2,
        surface: false,
        light: None,
        unrolls: true,
    }
}

/// All that the program can ask for.
fn all_keys() -> Vec<ShaderKey> {
    let mut all = Vec::new();
    for kernel in Kernel::ALL {
        let is_certified = kernel == Kernel::Certified;
        for lens in [Some(Lens::Perspective), Some(Lens::Orthographic), None] {
            let findings = if is_certified { &[false, true][..] } else { &[false] };
            for (n_spheres, n_planes) in [(0, 0), (3, 0), (0, 2), (3, 2), (200, 150)] {
                for &tree in findings {
                    let key = ShaderKey { n_spheres, n_planes, ..key(kernel, lens, tree) };
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
fn keys_of_baseline_light() -> Vec<ShaderKey> {
    let mut all = Vec::new();
    for kernel in Kernel::ALL.into_iter().filter(|&kernel| kernel != Kernel::Certified) {
        for lens in [Some(Lens::Perspective), Some(Lens::Orthographic)] {
            for (n_spheres, n_planes) in [(0, 0), (3, 0), (0, 2), (3, 2), (40, 2), (200, 150)] {
                for n_lamps in [0, 3, 100, 1000] {
                    let key = key(kernel, lens, false);
                    let light = Some(LightKey::Baseline { n_lamps });
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
    for lens in [Some(Lens::Perspective), Some(Lens::Orthographic)] {
        for (n_spheres, n_planes) in [(0, 0), (3, 0), (0, 2), (3, 2), (150, 2)] {
            for (n_lamps, n_samples) in [(0, 1), (3, 1), (3, 3), (100, 4)] {
                for tree in [false, true] {
                    let n_met = [n_spheres, n_planes, usize::from(n_lamps > 0 && n_planes > 0)];
                    let has_contacts = n_lamps == 3 && (tree || n_spheres + n_planes > 0);
                    let light = LightKey::Certified { n_samples, n_lamps, n_met, has_contacts };
                    let key = key(Kernel::Certified, lens, tree);
                    all.push(ShaderKey { n_spheres, n_planes, light: Some(light), ..key });
                    let close = n_spheres > 0 || tree;
                    all.push(ShaderKey { close, ..all[all.len() - 1] });
                }
            }
        }
    }
    all
}

fn spirv(key: &ShaderKey) -> Vec<u32> {
    compile(key, None).unwrap_or_else(|error| panic!("{error}: {key:?}")).spirv().unwrap()
}

/// A module that lacks one decoration is noticed, whichever it is.
#[test]
fn sabotage_a_missing_decoration_is_noticed() {
    for kernel in Kernel::ALL {
        let words = spirv(&key(kernel, Some(Lens::Perspective), false));
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

#[test]
fn sabotage_what_nothing_uses_is_noticed() {
    let words = spirv(&key(Kernel::Certified, Some(Lens::Perspective), false));
    let is_call = |(op, _): &(u32, &[u32])| *op == 57;
    let kept = walk(&words).into_iter().filter(|instruction| !is_call(instruction));
    let kept = kept
        .flat_map(|(op, operands)| [&[(operands.len() as u32 + 1) << 16 | op], operands].concat());
    let without_calls: Vec<u32> = words[..5].iter().copied().chain(kept).collect();
    assert!(!unused(&without_calls).is_empty());
}

fn n_bindings(key: &ShaderKey) -> usize {
    let objects = usize::from(key.n_spheres > 0) + usize::from(key.n_planes > 0);
    let is_tree = key.tree;
    let tree = if is_tree { 3 } else { 0 };
    match key.light {
        // Results, parameters; the list of rays; the tree.
        None => {
            let list = usize::from(key.lens.is_none());
            2 + objects + list + tree + if key.surface { 2 } else { 0 }
        }
        // Parameters and results, colours, the ends of bytes, and what is the same for all; and of lamps these and what may be
        // in their way. Of a tree its spheres as well, as the eye and as shadow rays meet them.
        Some(LightKey::Certified { n_lamps, n_met, .. }) => {
            let n_met = n_met.into_iter().filter(|&n| n > 0).count();
            let of_lamps = if n_lamps > 0 { 1 + n_met + usize::from(is_tree) } else { 0 };
            5 + objects + tree + usize::from(is_tree) + of_lamps
        }
        // Parameters and results, what is the same for all, and lamps.
        Some(LightKey::Baseline { n_lamps }) => 3 + objects + usize::from(n_lamps > 0),
    }
}

/// Nothing that the scene does not need: buffers of what there is, f64 where it is asked for, nothing that is not used; and all
/// of it decorated.
#[test]
fn a_shader_has_what_it_is_asked_for() {
    const OP_CAPABILITY: u32 = 17;
    const FLOAT64: u32 = 10;
    let all = [all_keys(), keys_of_baseline_light(), keys_of_certified_light()].concat();
    for key in all {
        let words = spirv(&key);
        let n_floats =
            check_no_contraction(&words).unwrap_or_else(|what| panic!("{what}: {key:?}"));
        // A ray's `a` and `1/a` alone are six operations.
        assert!(n_floats >= 6, "{n_floats} float results: {key:?}");
        let without_gaps: Vec<u32> = (0..n_bindings(&key) as u32).collect();
        assert_eq!(bindings(&words), without_gaps, "{key:?}");
        assert_eq!(unused(&words), [0; 0], "{key:?}");
        let asks = walk(&words).contains(&(OP_CAPABILITY, &[FLOAT64][..]));
        assert_eq!(asks, key.kernel.about().float == FloatType::F64, "{key:?}");
        if key.n_planes > 0 && key.light.is_none() {
            let without = spirv(&ShaderKey { n_planes: 0, ..key });
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
            let has_tree = prepared.shader_key(Outputs::default()).tree;
            let is_many = kernel == Kernel::Certified && n > FEW_SPHERES;
            assert_eq!(has_tree, is_many, "{n} spheres, {}", kernel.name());
        }
    }
}
