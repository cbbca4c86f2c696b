//! The SPIR-V that the program hands to the driver: nothing that the scene does not need, and
//! `NoContraction` on every float result. The words are walked here independently of the code that
//! decorates them.

use std::collections::HashSet;
use std::sync::Arc;

use kugelblitz::gpu::{Shader, compile};
use kugelblitz::kernel::Float;
use kugelblitz::prepare::{FEW_SPHERES, Finding, LightKey, Prepared, ShaderKey};
use kugelblitz::rays::{Bundle, Pixels, View};
use kugelblitz::scene::read_scene;
use kugelblitz::trace::{Kernel, Rays, Wants};
use kugelblitz_tests::root;

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

#[test]
fn every_float_result_is_decorated() {
    let all = [all_keys(), keys_of_plain_light(), keys_of_certified_light()].concat();
    for key in all {
        let (_, words) = shader(&key);
        let n = check_no_contraction(&words).unwrap_or_else(|what| panic!("{what}: {key:?}"));
        // A ray's `a` and `1/a` alone are six operations.
        assert!(n >= 6, "{n} float results: {key:?}");
    }
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

/// Names of the objects' record types.
fn records(shader: &Shader) -> Vec<String> {
    let names = shader.module.types.iter().filter_map(|(_, kind)| kind.name.as_deref());
    let names = names.map(str::to_lowercase);
    names
        .filter(|name| ["sphere", "plane"].iter().any(|kind| name.starts_with(kind)))
        .filter(|name| !name.ends_with("record") && !name.ends_with("leaf"))
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
    for key in all_keys() {
        let (whole, words) = shader(&key);
        assert_complete(&whole, &words);
        assert_eq!(has(&whole, "plane"), key.n_planes > 0, "{key:?}");
        let has_spheres = key.n_spheres > 0;
        assert_eq!(has(&whole, "sphere"), has_spheres || key.spheres == Finding::Tree, "{key:?}");
        // Results, parameters; spheres; planes; the list of rays; the hierarchy.
        let surface = if key.surface { 2 } else { 0 };
        let list = usize::from(key.bundle == Bundle::Free);
        let objects = usize::from(key.n_spheres > 0) + usize::from(key.n_planes > 0);
        let hierarchy = match key.spheres {
            Finding::Tree => 3,
            Finding::Listed => 0,
        };
        let expected = 2 + surface + objects + list + hierarchy;
        assert_eq!(bindings(&words).len(), expected, "{key:?}");
        if key.n_planes > 0 {
            let (_, without) = shader(&ShaderKey { n_planes: 0, ..key });
            let floats = |words: &[u32]| check_no_contraction(words).unwrap();
            assert!(floats(&without) < floats(&words), "{key:?}");
            assert_eq!(bindings(&without).len() + 1, bindings(&words).len(), "{key:?}");
        }
    }
}

/// The scenes that come along, their spheres, and the shader that the program then asks for.
fn scenes() -> Vec<(String, usize, ShaderKey)> {
    let mut found = Vec::new();
    for folder in ["scenes", "scenes/hard", "scenes/clouds", "scenes/lit/hard"] {
        let folder = root().join(folder);
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
                let key = prepared.shader_key(Wants::default());
                let name = format!("{} {}", path.display(), kernel.name());
                found.push((name, scene.spheres.len(), key));
            }
        }
    }
    found
}

/// The signs of a hierarchy: textures, and names.
fn traces_of_a_hierarchy(shader: &Shader, words: &[u32]) -> usize {
    const OP_TYPE_IMAGE: u32 = 25;
    let names = ["hierarchy", "walk", "boxes", "texel", "leaves"];
    let named = names.iter().filter(|name| has(shader, name)).count();
    count(words, OP_TYPE_IMAGE) + named
}

#[test]
fn a_hierarchy_only_where_there_are_many_spheres() {
    let mut n_with = 0;
    for (name, n_spheres, key) in scenes() {
        let (shader, words) = shader(&key);
        let has_hierarchy = key.spheres == Finding::Tree;
        assert_eq!(traces_of_a_hierarchy(&shader, &words) > 0, has_hierarchy, "{name}");
        let is_many = key.kernel == Kernel::Certified && n_spheres > FEW_SPHERES;
        assert_eq!(has_hierarchy, is_many, "{name}");
        n_with += usize::from(has_hierarchy);
    }
    assert!(n_with > 0);
}

/// The end of the names of a kernel's records, which `double` has in common with `stable`.
fn records_of(kernel: Kernel) -> String {
    kernel.about().wgsl.records.to_lowercase()
}

#[test]
fn only_one_kernel_and_one_source_of_rays() {
    for key in all_keys() {
        let (whole, _) = shader(&key);
        let objects = key.n_spheres + key.n_planes > 0;
        for kernel in Kernel::ALL {
            let expected = objects && records_of(kernel) == records_of(key.kernel);
            let has_records = has(&whole, &records_of(kernel));
            assert_eq!(has_records, expected, "{}, {key:?}", kernel.name());
        }
        let of_kernel = &*records_of(key.kernel);
        let records = records(&whole);
        assert!(records.iter().all(|name| name.ends_with(of_kernel)), "{key:?}");
        assert_eq!(records.is_empty(), !objects, "{records:?}: {key:?}");
        assert_eq!(has(&whole, "camera"), key.bundle != Bundle::Free, "{key:?}");
        assert_eq!(has(&whole, "rayrecord"), key.bundle == Bundle::Free, "{key:?}");
        let normals = key.surface;
        assert_eq!(has(&whole, "normal"), normals, "{key:?}");
    }
}

#[test]
fn f64_only_where_it_is_asked_for() {
    const OP_CAPABILITY: u32 = 17;
    const FLOAT64: u32 = 10;
    for key in all_keys() {
        let (_, words) = shader(&key);
        let asks = walk(&words).contains(&(OP_CAPABILITY, &[FLOAT64][..]));
        assert_eq!(asks, key.kernel.about().float == Float::F64, "{key:?}");
    }
}

/// Light is in no shader but its own.
#[test]
fn light_only_where_it_is_asked_for() {
    for key in all_keys() {
        let (whole, _) = shader(&key);
        let names = ["light", "lamp", "in_the_way", "anywhere"];
        assert!(!names.iter().any(|name| has(&whole, name)), "{key:?}");
    }
}

/// Of objects there is what the scene has, and shadows only where there are lamps.
#[test]
fn certified_light_has_what_there_is() {
    for key in keys_of_certified_light() {
        let (whole, words) = shader(&key);
        let Some(LightKey::Certified { n_lamps, .. }) = key.light else { panic!("{key:?}") };
        let [has_spheres, has_planes, has_lamps] =
            [key.n_spheres, key.n_planes, n_lamps].map(|n| n > 0);
        assert_eq!(has(&whole, "sphere"), has_spheres, "{key:?}");
        assert_eq!(has(&whole, "plane"), has_planes, "{key:?}");
        assert_eq!(has(&whole, "close"), key.close, "{key:?}");
        for name in ["lamp", "shadow", "verdict", "cosine"] {
            assert_eq!(has(&whole, name), has_lamps, "{name}: {key:?}");
        }
        let objects = usize::from(has_spheres) + usize::from(has_planes);
        // Parameters and results, colours, the ends of bytes, and what is the same for all; and of lamps these and what may be in
        // their way.
        let of_lamps = if has_lamps { 1 + objects } else { 0 };
        let n_bindings = (5 + objects + of_lamps) as u32;
        assert_eq!(bindings(&words), (0..n_bindings).collect::<Vec<_>>(), "{key:?}");
    }
}

/// Each has its kernel alone, of objects what there is, and for rays from anywhere other numbers only where those of
/// the picture's rays don't hold.
#[test]
fn plain_light_has_one_kernel_and_what_there_is() {
    for key in keys_of_plain_light() {
        let (whole, words) = shader(&key);
        assert_complete(&whole, &words);
        let has_lamps = !matches!(key.light, Some(LightKey::Plain { n_lamps: 0 }));
        assert!(has(&whole, "light"));
        assert_eq!(has(&whole, "in_the_way"), has_lamps, "{key:?}");
        assert_eq!(has(&whole, "sphere"), key.n_spheres > 0, "{key:?}");
        assert_eq!(has(&whole, "plane"), key.n_planes > 0, "{key:?}");
        let is_moved = has_lamps && key.bundle == Bundle::Point && key.kernel != Kernel::Lecture;
        assert_eq!(has(&whole, "sphere_from"), is_moved && key.n_spheres > 0, "{key:?}");
        assert_eq!(has(&whole, "plane_from"), is_moved && key.n_planes > 0, "{key:?}");
        let objects = usize::from(key.n_spheres > 0) + usize::from(key.n_planes > 0);
        // Parameters and results, what is the same for all, and lamps.
        assert_eq!(bindings(&words).len(), 3 + usize::from(has_lamps) + objects, "{key:?}");
        for kernel in Kernel::ALL {
            let expected = objects > 0 && records_of(kernel) == records_of(key.kernel);
            let has_records = has(&whole, &records_of(kernel));
            assert_eq!(has_records, expected, "{}, {key:?}", kernel.name());
        }
    }
}
