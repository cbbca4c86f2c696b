//! The SPIR-V that the program hands to the driver: nothing that the scene does not need, and
//! `NoContraction` on every float result. The words are walked here independently of the code that
//! decorates them.

use std::collections::HashSet;
use std::sync::Arc;

use kugelblitz::camera::{Bundle, Pixels, View};
use kugelblitz::gpu::{Shader, compile};
use kugelblitz::prepare::{FEW_SPHERES, Needs, Prepared};
use kugelblitz::scene::read_scene;
use kugelblitz::trace::{Kernel, Rays, Wants};

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

fn needs(kernel: Kernel, bundle: Bundle) -> Needs {
    Needs {
        kernel,
        bundle,
        n_spheres: 3,
        n_planes: 2,
        surface: false,
        near: false,
        hierarchy: false,
    }
}

/// All combinations that the program can ask for, and some more.
fn all_needs() -> Vec<Needs> {
    let mut all = Vec::new();
    for kernel in Kernel::ALL {
        for bundle in Bundle::ALL {
            for (n_spheres, n_planes) in [(0, 0), (3, 0), (0, 2), (3, 2), (200, 150)] {
                for surface in [false, true] {
                    for inside in [false, true] {
                        let certified = kernel == Kernel::Certified;
                        let asked_for = match certified {
                            true => {
                                let may_be = match bundle {
                                    Bundle::Point => true,
                                    Bundle::Parallel => !inside,
                                    Bundle::Free => inside,
                                };
                                !surface && may_be
                            }
                            false => !inside,
                        };
                        if asked_for {
                            let needs = needs(kernel, bundle);
                            let needs =
                                Needs { n_spheres, n_planes, surface, near: inside, ..needs };
                            all.push(needs);
                            let by_pixel = match bundle {
                                Bundle::Point => inside,
                                Bundle::Parallel => true,
                                Bundle::Free => false,
                            };
                            if certified && by_pixel {
                                all.push(Needs { hierarchy: true, ..needs });
                            }
                        }
                    }
                }
            }
        }
    }
    all
}

fn shader(needs: &Needs) -> (Shader, Vec<u32>) {
    let shader = compile(needs).unwrap_or_else(|error| panic!("{error}: {needs:?}"));
    let words = shader.spirv().unwrap();
    (shader, words)
}

#[test]
fn every_float_result_is_decorated() {
    for needs in all_needs() {
        let (_, words) = shader(&needs);
        let n = check_no_contraction(&words).unwrap_or_else(|what| panic!("{what}: {needs:?}"));
        // A ray's `a` and `1/a` alone are six operations.
        assert!(n >= 6, "{n} float results: {needs:?}");
    }
}

/// A module that lacks one decoration is noticed, whichever it is.
#[test]
fn sabotage_a_missing_decoration_is_noticed() {
    for kernel in Kernel::ALL {
        let inside = kernel == Kernel::Certified;
        let (_, words) = shader(&Needs { near: inside, ..needs(kernel, Bundle::Point) });
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

/// Names of the objects' record types.
fn records(shader: &Shader) -> Vec<String> {
    let names = shader.module.types.iter().filter_map(|(_, kind)| kind.name.as_deref());
    let names = names.map(str::to_lowercase);
    names
        .filter(|name| ["sphere", "plane"].iter().any(|kind| name.starts_with(kind)))
        .filter(|name| !name.ends_with("record"))
        .collect()
}

/// The SPIR-V holds what the module holds: as many functions (and the entry point) and bindings.
fn assert_complete(shader: &Shader, words: &[u32]) {
    const OP_FUNCTION: u32 = 54;
    let module = &shader.module;
    assert_eq!(count(words, OP_FUNCTION), module.functions.len() + 1);
    let n_bindings = module.global_variables.iter().filter(|(_, v)| v.binding.is_some()).count();
    let numbers = bindings(words);
    assert_eq!(numbers, (0..n_bindings as u32).collect::<Vec<_>>(), "bindings without gaps");
}

#[test]
fn a_scene_without_planes_has_no_plane_code_and_no_plane_binding() {
    for needs in all_needs() {
        let (whole, words) = shader(&needs);
        assert_complete(&whole, &words);
        assert_eq!(has(&whole, "plane"), needs.n_planes > 0, "{needs:?}");
        let has_spheres = needs.n_spheres > 0;
        assert_eq!(has(&whole, "sphere"), has_spheres || needs.hierarchy, "{needs:?}");
        // Results, parameters; spheres; planes; the list of rays; the hierarchy.
        let surface = if needs.surface { 2 } else { 0 };
        let list = usize::from(needs.bundle == Bundle::Free);
        let objects = usize::from(needs.n_spheres > 0) + usize::from(needs.n_planes > 0);
        let hierarchy = match needs.hierarchy {
            true => 3 + usize::from(has_spheres),
            false => 0,
        };
        let expected = 2 + surface + objects + list + hierarchy;
        assert_eq!(bindings(&words).len(), expected, "{needs:?}");
        if needs.n_planes > 0 {
            let (_, without) = shader(&Needs { n_planes: 0, ..needs });
            let floats = |words: &[u32]| check_no_contraction(words).unwrap();
            assert!(floats(&without) < floats(&words), "{needs:?}");
            assert_eq!(bindings(&without).len() + 1, bindings(&words).len(), "{needs:?}");
        }
    }
}

/// The scenes that come along, their spheres, and what the program then asks of the device.
fn scenes() -> Vec<(String, usize, Needs)> {
    let mut found = Vec::new();
    for folder in ["scenes", "scenes/hard", "scenes/clouds"] {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|ending| ending != "toml") {
                continue;
            }
            let scene = read_scene(&path).unwrap();
            let view = View::new(scene.camera.as_ref().unwrap());
            let rays = Rays::Pixels(Pixels::whole(view, 64, 48));
            for kernel in Kernel::ALL {
                let prepared = Prepared::new(Arc::new(scene.clone()), kernel, &rays).unwrap();
                let needs = prepared.needs(Wants::default());
                let name = format!("{} {}", path.display(), kernel.name());
                found.push((name, scene.spheres.len(), needs));
            }
        }
    }
    found
}

/// What a hierarchy brings: textures, loops, and names.
fn traces_of_a_hierarchy(shader: &Shader, words: &[u32]) -> usize {
    const OP_TYPE_IMAGE: u32 = 25;
    const OP_LOOP_MERGE: u32 = 246;
    let names = ["hierarchy", "walk", "node", "cell", "texel", "rest_ids", "far_spheres"];
    let named = names.iter().filter(|name| has(shader, name)).count();
    count(words, OP_TYPE_IMAGE) + count(words, OP_LOOP_MERGE) + named
}

#[test]
fn a_hierarchy_only_where_there_are_many_spheres() {
    let mut n_with = 0;
    for (name, n_spheres, needs) in scenes() {
        let (shader, words) = shader(&needs);
        assert_eq!(traces_of_a_hierarchy(&shader, &words) > 0, needs.hierarchy, "{name}");
        let is_many = needs.kernel == Kernel::Certified && n_spheres > FEW_SPHERES;
        assert_eq!(needs.hierarchy, is_many, "{name}");
        n_with += usize::from(needs.hierarchy);
    }
    assert!(n_with > 0);
}

#[test]
fn code_for_rays_from_inside_only_where_one_starts_there() {
    let needs = needs(Kernel::Certified, Bundle::Point);
    let (without, without_words) = shader(&needs);
    let (with, with_words) = shader(&Needs { near: true, ..needs });
    assert!(!has(&without, "inside") && has(&with, "inside"));
    assert_complete(&without, &without_words);
    assert_complete(&with, &with_words);
    let floats = |words: &[u32]| check_no_contraction(words).unwrap();
    assert!(floats(&without_words) < floats(&with_words));
}

#[test]
fn only_one_kernel_and_one_source_of_rays() {
    for needs in all_needs() {
        let (whole, _) = shader(&needs);
        let objects = needs.n_spheres + needs.n_planes > 0;
        for kernel in Kernel::ALL {
            // `double` is made of the formulas of `stable`, but not of its records.
            let shares = (kernel, needs.kernel) == (Kernel::Stable, Kernel::Double);
            let expected = objects && (kernel == needs.kernel || shares);
            assert_eq!(has(&whole, kernel.name()), expected, "{}, {needs:?}", kernel.name());
        }
        let of_kernel = needs.kernel.name();
        let records = records(&whole);
        assert!(records.iter().all(|name| name.ends_with(of_kernel)), "{needs:?}");
        assert_eq!(records.is_empty(), !objects, "{records:?}: {needs:?}");
        assert_eq!(has(&whole, "camera"), needs.bundle != Bundle::Free, "{needs:?}");
        assert_eq!(has(&whole, "rayrecord"), needs.bundle == Bundle::Free, "{needs:?}");
        let normals = needs.surface;
        assert_eq!(has(&whole, "normal"), normals, "{needs:?}");
    }
}

#[test]
fn f64_only_in_the_kernel_that_calculates_in_it() {
    const OP_CAPABILITY: u32 = 17;
    const FLOAT64: u32 = 10;
    for needs in all_needs() {
        let (_, words) = shader(&needs);
        let asks = walk(&words).contains(&(OP_CAPABILITY, &[FLOAT64][..]));
        assert_eq!(asks, needs.kernel == Kernel::Double, "{needs:?}");
    }
}
