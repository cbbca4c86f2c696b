//! Each function in `shaders/` has its twin in Rust: the same name, and the same names of parameters in
//! the same order. The registry of kernels says which file is whose.

use std::collections::BTreeMap;
use std::fs;

use kugelblitz::kernel::SHARED_PARTS;
use kugelblitz::trace::Kernel;
use kugelblitz_tests::root;

/// Files that a device alone has, each with what it is compared with instead.
const DEVICE_ALONE: [(&str, &str); 8] = [
    ("shaders/params.wgsl", "a struct: src/gpu/layout.rs checks it"),
    (
        "shaders/render.wgsl",
        "bindings and the entry point: tests/device/parity.rs compares its results",
    ),
    ("shaders/hierarchy.wgsl", "walks textures: tests/device/proposals.rs compares its proposals"),
    ("shaders/tree.wgsl", "walks textures: tests/device/proposals.rs compares its proposals"),
    (
        "shaders/walk.wgsl",
        "what both walks share: tests/device/proposals.rs compares their proposals",
    ),
    ("shaders/undecided.wgsl", "lists and settles ids: the window's tests"),
    ("shaders/present.wgsl", "shows a picture: the window's tests"),
    ("shaders/self_test.wgsl", "measures the device: src/gpu/self_test.rs expects its results"),
];

/// A twin that is no kernel's.
const OF_LIGHT: (&str, &str) = ("shaders/plain_light.wgsl", "src/shade/plain.rs");

/// Functions whose twin has another name, each with that.
const OTHER_NAMES: [(&str, &str); 5] = [
    ("closest_from_anywhere", "closest of the kernel for rays that are free"),
    ("plane_from", "plane_n_offset of rays that are free"),
    ("sphere_from", "sphere_offset and sphere_k of rays that are free"),
    ("ray_from", "RayOf::new"),
    ("sphere_id", "the parameter of nearest_listed, another function with a hierarchy"),
];

/// Parameters in Rust that are bindings and constants in WGSL.
const BINDINGS: [&str; 6] = ["spheres", "planes", "n_spheres", "sphere_id", "widening", "room"];

/// A guard, which WGSL has as a sphere or as three numbers.
const GUARD: [&str; 3] = ["inner2", "outer2", "slack"];

/// The names of each function's parameters, one list for each function of the name.
type Functions = BTreeMap<String, Vec<Vec<String>>>;

/// The functions of a file in Rust or WGSL, without entry points.
fn functions(text: &str) -> Functions {
    let text = text.split("#[cfg(test)]").next().unwrap_or_default();
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    let text: String = lines.flat_map(|line| [line, "\n"]).collect();
    let mut found = Functions::new();
    for (start, _) in text.match_indices("fn ") {
        let before = text[..start].trim_end();
        let is_word = text[..start].ends_with([' ', '\n']) || start == 0;
        let is_entry = before.lines().last().is_some_and(|line| line.trim_start().starts_with('@'));
        let rest = &text[start + "fn ".len()..];
        let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
        if is_word && !is_entry && end > 0 {
            let name = rest[..end].to_string();
            found.entry(name).or_default().push(parameters(&rest[end..]));
        }
    }
    found
}

/// The names of the parameters between the first parentheses outside of `<…>`.
fn parameters(text: &str) -> Vec<String> {
    let (mut depth, mut before, mut is_list) = (0, ' ', false);
    let mut all = vec![String::new()];
    for letter in text.chars() {
        let is_arrow = (before, letter) == ('-', '>');
        before = letter;
        match letter {
            '(' if depth == 0 && !is_list => is_list = true,
            ')' if depth == 0 => break,
            '<' | '[' | '(' => depth += 1,
            '>' | ']' | ')' if !is_arrow => depth -= 1,
            ',' if depth == 0 => all.push(String::new()),
            _ if is_list => all.last_mut().expect("one at least").push(letter),
            _ => {}
        }
    }
    let name = |parameter: &String| {
        let pattern = parameter.split(':').next().unwrap_or_default().trim();
        pattern.trim_start_matches('&').trim_start_matches("mut ").to_string()
    };
    all.iter().map(name).filter(|name| !name.is_empty()).collect()
}

/// True where the parameters in WGSL are those in Rust; `self` stands for any one of them, or for what
/// is bound.
fn are_twins(wgsl: &[String], rust: &[String]) -> bool {
    let is_own = |name: &&str| *name != "self" && !BINDINGS.contains(name);
    let mut own: Vec<&str> = rust.iter().map(String::as_str).filter(is_own).collect();
    let given: Vec<&str> = wgsl.iter().map(String::as_str).collect();
    if let (Some(at), false) = (own.iter().position(|n| *n == "guard"), given.contains(&"guard")) {
        own.splice(at..=at, GUARD);
    }
    let is_receiver = |at: usize| [&given[..at], &given[at + 1..]].concat() == own;
    let is_method = rust.iter().any(|name| name == "self");
    given == own || is_method && (0..given.len()).any(is_receiver)
}

/// The faults of the functions of a WGSL file and those of its twin.
fn faults(wgsl: &Functions, rust: &Functions) -> Vec<String> {
    let mut faults = Vec::new();
    for (name, variants) in wgsl {
        if OTHER_NAMES.iter().any(|(other, _)| other == name) {
            continue;
        }
        let twins = rust.get(name).map_or(&[][..], Vec::as_slice);
        for parameters in variants {
            if !twins.iter().any(|twin| are_twins(parameters, twin)) {
                faults.push(format!("{name}({}): {twins:?}", parameters.join(", ")));
            }
        }
    }
    faults
}

/// Each part once: its file, and its twin where it has one.
fn parts() -> BTreeMap<&'static str, Option<&'static str>> {
    let own = Kernel::ALL.into_iter().flat_map(|kernel| kernel.about().wgsl.parts);
    let twins = own.chain(&SHARED_PARTS).map(|part| (part.file, part.twin));
    let alone = DEVICE_ALONE.map(|(file, _)| (file, None));
    let (file, twin) = OF_LIGHT;
    twins.chain(alone).chain([(file, Some(twin))]).collect()
}

fn read(path: &str) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

#[test]
fn each_shader_belongs_to_a_kernel_or_to_all_or_to_the_device_alone() {
    let folder = root().join("shaders");
    let files = fs::read_dir(folder).expect("a folder of shaders");
    let names = files.map(|file| file.expect("an entry").file_name());
    let mut files: Vec<_> =
        names.map(|name| format!("shaders/{}", name.to_string_lossy())).collect();
    files.sort();
    assert_eq!(files, parts().into_keys().collect::<Vec<_>>());
}

#[test]
fn twins_have_the_same_names() {
    let (mut n_functions, mut all) = (0, Vec::new());
    for (file, twin) in parts() {
        let Some(twin) = twin else { continue };
        let wgsl = functions(&read(file));
        n_functions += wgsl.len();
        let faults = faults(&wgsl, &functions(&read(twin)));
        all.extend(faults.into_iter().map(|fault| format!("{file}, {twin}: {fault}")));
    }
    assert!(n_functions > 35, "{n_functions}");
    assert!(all.is_empty(), "{}", all.join("\n"));
}

/// Exceptions that nothing needs any more.
#[test]
fn the_exceptions_are_there() {
    let files = parts().into_iter().filter(|(_, twin)| twin.is_some());
    let names: Vec<String> =
        files.flat_map(|(file, _)| functions(&read(file)).into_keys()).collect();
    for (name, _) in OTHER_NAMES {
        assert!(names.iter().any(|other| other == name), "{name}");
    }
}

#[test]
fn a_function_without_its_twin_is_noticed() {
    let wgsl = read("shaders/certified.wgsl");
    let rust = functions(&read("src/kernel/certified/filter.rs"));
    assert_eq!(faults(&functions(&wgsl), &rust), Vec::<String>::new());
    let sabotages = [
        ("fn far_nearness(", "fn distant_nearness("),
        ("fn far_nearness(ray: Ray, l: Vec3,", "fn far_nearness(l: Vec3, ray: Ray,"),
        ("inner2: Real, outer2: Real, q: Real", "outer2: Real, inner2: Real, q: Real"),
        ("fn nearer(nearest: Nearest, root: Nearness, id: u32)", "fn nearer(root: f32, n: f32)"),
        ("fn decide(nearest: Nearest)", "fn decide(nearest: Nearest, root: Nearness)"),
        ("//#if far\n", "//#if far\nfn made_up(ray: Ray) -> f32 { return ray.a; }\n"),
    ];
    for (from, to) in sabotages {
        assert!(wgsl.contains(from), "{from}");
        let sabotaged = faults(&functions(&wgsl.replacen(from, to, 1)), &rust);
        assert_eq!(sabotaged.len(), 1, "{to}: {sabotaged:?}");
    }
}

#[test]
fn functions_are_found_with_their_parameters() {
    let text = "pub(crate) fn f<F: Fn(u32) -> u32, const N: usize>(\n    &self,\n    a: [f32; 3],\n    \
                g: impl Fn(u32, f32) -> f32,\n) -> f32 {}\n// fn no(a: u32)\n@compute\nfn main(a: u32) {}\n\
                fn g() {}\n";
    let expected = [("f", vec!["self", "a", "g"]), ("g", vec![])];
    let expected: Functions = expected
        .into_iter()
        .map(|(name, all)| (name.into(), vec![all.into_iter().map(String::from).collect()]))
        .collect();
    assert_eq!(functions(text), expected);
}
