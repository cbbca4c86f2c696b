//! WGSL parts → one shader with what the scene needs → validated naga module → SPIR-V in which
//! every float result is decorated `NoContraction`.

use std::fmt::Display;

use naga::back::spv;
use naga::compact::{KeepUnused, compact};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

use super::layout::{Lamp, Layout, Lighting, Params, RayRecord, Traversal};
use super::self_test::NUMERATOR;
use super::texture::TEXELS_PER_ROW;
use crate::bvh::{IS_LEAF, MOST_BOXES, MOST_BOXES_TO_LIGHT};
use crate::error::{Error, Result};
use crate::kernel::{FloatType, Kernel, SHARED_PARTS, ShaderPart, Space, part};
use crate::num::{Float as _, UNDECIDED};
use crate::prepare::{LightKey, ShaderKey};
use crate::rays::Lens;

/// Invocations of one workgroup, columns × rows of the tile.
pub const WORKGROUP: [u32; 2] = [8, 8];

const RENDER: ShaderPart = part!("render.wgsl");
const BASELINE_LIGHT: ShaderPart = part!("baseline_light.wgsl");
const PRINTED_LIGHT: ShaderPart = part!("printed/light.wgsl");
const LIT: ShaderPart = part!("lit.wgsl");
const TREE: ShaderPart = part!("tree.wgsl");
const SELF_TEST: ShaderPart = part!("self_test.wgsl");

/// A validated shader.
pub struct Shader {
    /// The validated form of the text that was put together.
    pub module: naga::Module,
    /// The findings of its validation.
    pub info: ModuleInfo,
}

/// A test's change of the WGSL text of every scene's shader.
pub type Edit = Box<dyn Fn(&str) -> String + Send + Sync>;

/// Puts together and validates a scene's shader, with the text edited where a test wants that.
///
/// # Errors
/// [`Error::Shader`] names the `.wgsl` file and line; that is a defect of the program.
pub fn compile(key: &ShaderKey, edit: Option<&Edit>) -> Result<Shader> {
    let mut parts = SHARED_PARTS.to_vec();
    parts.extend(key.kernel.about().shader_parts);
    match key.light {
        Some(LightKey::Baseline { .. }) => parts.push(BASELINE_LIGHT),
        Some(LightKey::Certified { .. }) => parts.extend([PRINTED_LIGHT, LIT]),
        None => parts.push(RENDER),
    }
    if key.tree {
        parts.push(TREE);
    }
    let (needs, repeats, constants) = (needs(key), repeats(key), constants(key));
    compile_parts(&parts, &Choices { needs, repeats, constants, edit })
}

/// The shader that looks at the arithmetic of a WGSL float type.
pub fn compile_self_test(float: &str) -> Result<Shader> {
    let constants =
        format!("alias FLOAT = {float};\nconst NUMERATOR = FLOAT({:?});\n", f64::from(NUMERATOR));
    compile_parts(&[SELF_TEST], &Choices { constants, ..Choices::default() })
}

/// The answers to the directives, and the constants of the parts.
#[derive(Default)]
struct Choices<'a> {
    /// What `//#if` may ask for.
    needs: Vec<(&'static str, bool)>,
    /// All kinds of what is repeated.
    repeats: Vec<(&'static str, Repeat)>,
    /// WGSL for the facts whose home is Rust.
    constants: String,
    /// Done to the text that was put together.
    edit: Option<&'a Edit>,
}

/// Bytes that each device's uniforms hold.
const UNIFORM_BYTES: usize = 16 << 10;

/// What rays look at one after the other: its names, and where it is. The numbers of a uniform are loaded once for all lanes,
/// within loops as well; what it has no room for lies in a buffer.
fn lists(key: &ShaderKey) -> String {
    let [sphere, plane] = key.kernel.about().record_bytes;
    // lavapipe of Mesa 22.3 crashes with light in trees, and with contacts of lamps, if lamps are in a uniform.
    let are_lamps_stored = key.tree || has_contacts(key);
    let room = if key.light.is_some() && key.tree { 0 } else { UNIFORM_BYTES };
    let room_of_lamps = if are_lamps_stored { 0 } else { UNIFORM_BYTES };
    let lists = [
        ("spheres", "SphereElement", key.n_spheres, sphere * key.n_spheres <= room),
        ("planes", "PlaneElement", key.n_planes, plane * key.n_planes <= room),
        ("lamps", "Lamp", n_lamps(key), LAMP_BYTES * n_lamps(key) <= room_of_lamps),
    ];
    let list = |(name, element, n, is_uniform): (&str, &str, usize, bool)| match is_uniform {
        true => format!("@group(0) @binding(next) var<uniform> {name}: array<{element}, {n}>;\n"),
        false => format!("@group(0) @binding(next) var<storage, read> {name}: array<{element}>;\n"),
    };
    lists.into_iter().filter(|&(_, _, n, _)| n > 0).map(list).collect()
}

/// What lines of a part are repeated for.
#[derive(Clone)]
enum Repeat {
    /// Each of so many, with a loop where they are more than the second number.
    Count([usize; 2]),
    /// Each of these shapes.
    Shapes(Vec<&'static str>),
}

/// The shapes, in the order of their ids.
const SHAPES: [&str; 2] = ["sphere", "plane"];

/// How many objects of each shape are looked at one after the other.
fn n_listed(key: &ShaderKey) -> [usize; SHAPES.len()] {
    [key.n_spheres, key.n_planes]
}

/// Kinds of occluders: the shapes, and large spheres.
const MET_SHAPES: [&str; 3] = [SHAPES[0], SHAPES[1], "ground"];

/// Numbers of occluders outside of a tree, for each of [`MET_SHAPES`].
fn n_met(key: &ShaderKey) -> [usize; MET_SHAPES.len()] {
    match key.light {
        Some(LightKey::Certified { n_met, .. }) => n_met,
        _ => [0; MET_SHAPES.len()],
    }
}

/// Loops around loops take twice as long on lavapipe, and long texts long to compile.
fn repeats(key: &ShaderKey) -> Vec<(&'static str, Repeat)> {
    let (n_lamps, n_samples) = (n_lamps(key), n_samples(key).pow(2));
    let most = if key.unrolls { MOST_REPEATED } else { 1 };
    let those = |all: &[&'static str], are: &[bool]| {
        let shapes = all.iter().zip(are).filter(|(_, is_one)| **is_one);
        Repeat::Shapes(shapes.map(|(shape, _)| *shape).collect())
    };
    let listed = n_listed(key).map(|n| n > 0);
    let [spheres, planes] = listed;
    vec![
        ("lamp", Repeat::Count([n_lamps, most])),
        ("sample", Repeat::Count([n_samples, most / n_lamps.max(1)])),
        ("listed shape", those(&SHAPES, &listed)),
        ("indexed shape", those(&SHAPES, &[spheres && !key.tree, planes])),
        ("met shape", those(&MET_SHAPES, &n_met(key).map(|n| n > 0))),
    ]
}

/// What the parts know of each shape: its record, how many there are, and the id of the first.
fn constants_of_shapes(key: &ShaderKey) -> String {
    let (mut text, mut first) = (String::new(), "1u".to_string());
    let records = key.kernel.about().record_names;
    for (shape, n_met) in MET_SHAPES.into_iter().zip(n_met(key)) {
        text += &named(&format!("const N_MET_SHAPES = {n_met}u;\n"), shape);
    }
    for (shape, n_listed) in SHAPES.into_iter().zip(n_listed(key)) {
        let of_any = format!(
            "alias ShapeElement = Shape{records};\n\
             const N_SHAPES = {n_listed}u;\n\
             fn first_shape() -> u32 {{ return {first}; }}\n"
        );
        text += &named(&of_any, shape);
        first += &format!(" + params.n_{shape}s");
    }
    text
}

fn n_samples(key: &ShaderKey) -> usize {
    match key.light {
        Some(LightKey::Certified { n_samples, .. }) => n_samples as usize,
        _ => 1,
    }
}

fn n_lamps(key: &ShaderKey) -> usize {
    match key.light {
        Some(LightKey::Baseline { n_lamps } | LightKey::Certified { n_lamps, .. }) => n_lamps,
        None => 0,
    }
}

fn has_contacts(key: &ShaderKey) -> bool {
    matches!(key.light, Some(LightKey::Certified { has_contacts: true, .. }))
}

/// Whether a scene needs of the parts what `//#if` asks for, by its name.
fn needs(key: &ShaderKey) -> Vec<(&'static str, bool)> {
    let about = key.kernel.about();
    let is_point = key.lens == Some(Lens::Perspective);
    let is_relative = about.space == Space::Reference;
    vec![
        // The boxes of a tree.
        ("tree", key.tree),
        // The formulas for spheres whose size hides their distance.
        ("close", key.close),
        // `t` and normals.
        ("surface", key.surface),
        // Lights.
        ("lamps", n_lamps(key) > 0),
        // Lamps that are close to surfaces.
        ("contacts", has_contacts(key)),
        // Numbers that are relative to the reference point,
        ("relative", is_relative),
        // and are moved to where each ray starts.
        ("moved", is_relative && !is_point),
        // Rays from one point.
        ("point", is_point),
        // Rays of a list.
        ("free", key.lens.is_none()),
        // A kernel in f64.
        ("double", about.float == FloatType::F64),
        // The kernel with a proof.
        ("certified", key.kernel == Kernel::Certified),
    ]
}

fn constants(key: &ShaderKey) -> String {
    fn unsigned(name: &str, value: impl Display) -> String {
        format!("const {name} = {value}u;\n")
    }
    let real = |name, value: f64| format!("const {name} = {:?}f;\n", value as f32);
    let [width, height] = WORKGROUP;
    let mut parts = vec![
        aliases(key.kernel.about().float.name()),
        unsigned("WORKGROUP_WIDTH", width),
        unsigned("WORKGROUP_HEIGHT", height),
        Params::declaration(),
        "@group(0) @binding(next) var<uniform> params: Params;\n".into(),
        constants_of_shapes(key),
    ];
    if key.tree {
        let most_boxes = if key.light.is_some() { MOST_BOXES_TO_LIGHT } else { MOST_BOXES };
        parts.extend([
            unsigned("IS_LEAF", IS_LEAF),
            unsigned("MOST_BOXES", most_boxes),
            unsigned("NO_PLACE", u32::MAX),
            unsigned("ROW_BITS", TEXELS_PER_ROW.ilog2()),
            Traversal::declaration(),
        ]);
    }
    if key.lens.is_none() {
        parts.push(RayRecord::declaration());
    }
    match key.light {
        Some(LightKey::Baseline { .. }) => parts.extend([
            unsigned("LAMP_EYE", Lamp::EYE),
            unsigned("LAMP_POINT", Lamp::POINT),
            unsigned("LAMP_SUN", Lamp::SUN),
            Lighting::declaration(),
            Lamp::declaration(),
        ]),
        Some(LightKey::Certified { .. }) => parts.extend([
            unsigned("N_SAMPLES", n_samples(key)),
            unsigned("N_COLORS", 1 + key.n_spheres + key.n_planes),
            unsigned("UNDECIDED", UNDECIDED),
            real("KNOWN", f32::KNOWN),
            real("BEYOND", f32::BEYOND),
        ]),
        None => {}
    }
    parts.push(lists(key));
    parts.concat()
}

/// The names of a number and of a vector in the parts that several kernels share.
fn aliases(real: &str) -> String {
    format!("alias Real = {real};\nalias Vec3 = vec3<{real}>;\n")
}

fn compile_parts(parts: &[ShaderPart], choices: &Choices) -> Result<Shader> {
    let mut wgsl = choices.constants.clone();
    let mut starts = vec![("constants", 1)];
    for part in parts {
        starts.push((part.file, wgsl.matches('\n').count() + 1));
        wgsl += &expand(part, choices)?;
    }
    let mut wgsl = number_bindings(&wgsl);
    if let Some(edit) = choices.edit {
        wgsl = edit(&wgsl);
    }
    let place = |location: Option<naga::SourceLocation>| {
        let line = location.map_or(1, |location| location.line_number as usize);
        let &(file, start) =
            starts.iter().rfind(|&&(_, start)| start <= line).unwrap_or(&starts[0]);
        format!("{file}:{}", line - start + 1)
    };

    let mut module = naga::front::wgsl::parse_str(&wgsl).map_err(|error| {
        Error::Shader(format!("{}: {}", place(error.location(&wgsl)), error.message()))
    })?;
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::FLOAT64);
    let mut validate = |module: &naga::Module| {
        validator.validate(module).map_err(|error| {
            let place = place(error.location(&wgsl));
            Error::Shader(format!("{place}: {}", error.emit_to_string(&wgsl)))
        })
    };
    validate(&module)?;
    // Printed formulas that the scene does not use.
    compact(&mut module, KeepUnused::No);
    let info = validate(&module)?;
    Ok(Shader { module, info })
}

/// Up to so many lamps, times samples, are looked at without a loop.
pub(super) const MOST_REPEATED: usize = 32;

/// Bytes of a lamp in a uniform, at most.
const LAMP_BYTES: usize = 64;

/// Turns of loops after which a shader may be stopped: llvmpipe ends all loops of an invocation after 65 535
/// (`LP_MAX_TGSI_LOOP_ITERATIONS`), without a word, and goes on behind them.
pub(super) const MOST_TURNS_IN_SOFTWARE: usize = 65_000;

/// A block that a `//#` directive opens.
enum Block {
    If(bool),
    Each(Repeat, String),
}

impl Block {
    /// Lines that are to be repeated.
    fn body(&mut self) -> Option<&mut String> {
        match self {
            Block::Each(_, body) => Some(body),
            Block::If(_) => None,
        }
    }
}

/// Carries out the directives of a part, keeping its line numbers:
/// - `//#if need` … `//#else` … `//#end` keeps the lines that the scene needs; a name that is not one of [`needs`] is an
///   error;
/// - `//#each lamp` … `//#end` repeats its lines for each lamp, `INDEX` standing for its index;
/// - `//#each listed shape` … `//#end` repeats its lines for each shape that has listed objects: in `shapes`, `ShapeRecord` and
///   `N_SHAPES` its name stands for the word.
fn expand(part: &ShaderPart, choices: &Choices) -> Result<String> {
    let mut open: Vec<Block> = Vec::new();
    let mut text = String::new();
    for (index, line) in part.text.lines().enumerate() {
        let wrong = |what: &str| Error::Shader(format!("{}:{}: {what}", part.file, index + 1));
        let directive = line.trim().strip_prefix("//#");
        match directive.map(|words| words.split_once(' ').unwrap_or((words, ""))) {
            Some(("if", need)) => match choices.needs.iter().find(|(known, _)| *known == need) {
                Some(&(_, holds)) => open.push(Block::If(holds)),
                None => return Err(wrong(&format!("unknown need `{need}`"))),
            },
            Some(("else", "")) => match open.last_mut() {
                Some(Block::If(keep)) => *keep = !*keep,
                _ => return Err(wrong("no //#if is open here")),
            },
            Some(("each", kind)) => {
                match choices.repeats.iter().find(|(known, _)| *known == kind) {
                    Some((_, repeat)) => open.push(Block::Each(repeat.clone(), String::new())),
                    None => return Err(wrong("unknown kind")),
                }
            }
            Some(("end", "")) => match open.pop() {
                Some(Block::If(_)) => {}
                Some(Block::Each(repeat, body)) => text += &repeat.of(&body),
                None => return Err(wrong("nothing is open here")),
            },
            Some(_) => return Err(wrong("unknown directive")),
            None if open.iter().any(|block| matches!(block, Block::If(false))) => {}
            None => match open.iter_mut().find_map(Block::body) {
                Some(body) => *body += line.trim(),
                None => text += line,
            },
        }
        text += "\n";
    }
    match open.is_empty() {
        true => Ok(text),
        false => Err(Error::Shader(format!("{}: a directive is not closed", part.file))),
    }
}

impl Repeat {
    fn of(&self, body: &str) -> String {
        match self {
            Repeat::Count([count, most]) if count <= most => {
                (0..*count).map(|index| body.replace("INDEX", &format!("{index}u"))).collect()
            }
            Repeat::Count([count, _]) => {
                let body = body.replace("INDEX", "i");
                format!("for (var i = 0u; i < {count}u; i++) {{ {body} }}")
            }
            Repeat::Shapes(shapes) => shapes.iter().map(|shape| named(body, shape)).collect(),
        }
    }
}

/// A text about any shape as one about this.
fn named(text: &str, shape: &str) -> String {
    let (upper, first) = (shape.to_uppercase(), shape.len().min(1));
    let capital = upper[..first].to_string() + &shape[first..];
    text.replace("SHAPE", &upper).replace("Shape", &capital).replace("shape", shape)
}

/// Numbers `@binding(next)` from 0 without gaps: wgpu's Vulkan backend numbers a layout's entries
/// so, and a passed-through shader must agree with it.
fn number_bindings(wgsl: &str) -> String {
    let mut pieces = wgsl.split("@binding(next)");
    let mut text = pieces.next().unwrap_or_default().to_string();
    for (binding, piece) in pieces.enumerate() {
        text += &format!("@binding({binding}){piece}");
    }
    text
}

impl Shader {
    /// SPIR-V words with every float result decorated `NoContraction`.
    ///
    /// # Errors
    /// [`Error::Shader`] when naga can't translate the module.
    pub fn spirv(&self) -> Result<Vec<u32>> {
        let options = spv::Options {
            flags: spv::WriterFlags::empty(),
            // Every index is below a length: see SAFETY in pipeline.rs.
            bounds_check_policies: naga::proc::BoundsCheckPolicies::default(),
            force_loop_bounding: false,
            ..spv::Options::default()
        };
        let words = spv::write_vec(&self.module, &self.info, &options, None)
            .map_err(|error| Error::Shader(format!("SPIR-V: {error}")))?;
        Ok(no_contraction(&words))
    }
}

/// Number of words before the first instruction of a SPIR-V module.
const SPIRV_HEADER_WORDS: usize = 5;

/// Iterates over `(opcode, words)` of a SPIR-V module.
pub fn instructions(words: &[u32]) -> impl Iterator<Item = (u16, &[u32])> {
    let mut at = SPIRV_HEADER_WORDS.min(words.len());
    std::iter::from_fn(move || {
        let first = *words.get(at)?;
        let length = ((first >> 16) as usize).max(1);
        let instruction = words.get(at..at + length)?;
        at += length;
        Some((first as u16, instruction))
    })
}

/// Decorates the result of each float arithmetic instruction `NoContraction`: without it a driver
/// may turn `a + b − a` into `b` (Vulkan specification, precision and operation of SPIR-V
/// instructions).
fn no_contraction(words: &[u32]) -> Vec<u32> {
    const OP_EXT_INST: u16 = 12;
    const OP_DECORATE: u32 = 71;
    const NO_CONTRACTION: u32 = 42;
    // SPIR-V unified specification, section 3: FNegate, FAdd, FSub, FMul, FDiv, FRem, FMod,
    // VectorTimesScalar … OuterProduct, Dot.
    let is_float = |op: u16| matches!(op, 127 | 129 | 131 | 133 | 136 | 140 | 141 | 142..=148);
    // GLSL.std.450: Sqrt, InverseSqrt, Fma.
    let is_float_extended = |number: u32| matches!(number, 31 | 32 | 50);

    let mut decorations = Vec::new();
    let mut insert_at = None;
    let mut at = SPIRV_HEADER_WORDS.min(words.len());
    for (op, instruction) in instructions(words) {
        // OpTypeVoid … OpConstantNull: the first of them ends the annotations.
        if insert_at.is_none() && matches!(op, 19..=46) {
            insert_at = Some(at);
        }
        let float = is_float(op) || (op == OP_EXT_INST && is_float_extended(instruction[4]));
        if float {
            decorations.extend([3 << 16 | OP_DECORATE, instruction[2], NO_CONTRACTION]);
        }
        at += instruction.len();
    }
    let insert_at = insert_at.unwrap_or(words.len());
    [&words[..insert_at], &decorations, &words[insert_at..]].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error_of(part: &'static str) -> String {
        let part = ShaderPart { file: "shaders/broken.wgsl", text: part };
        let repeats = vec![("lamp", Repeat::Count([2, 2]))];
        let needs = vec![("tree", false)];
        let choices = Choices { needs, repeats, constants: aliases("f32"), edit: None };
        match compile_parts(&[SHARED_PARTS[0], part], &choices) {
            Err(Error::Shader(message)) => message,
            _ => String::new(),
        }
    }

    /// A driver may fold a conversion there and back: then the self-test would look at nothing.
    #[test]
    fn the_self_test_converts_no_number_there_and_back() {
        const OP_F_CONVERT: u16 = 115;
        let words = compile_self_test("f64").unwrap().spirv().unwrap();
        let conversions: Vec<&[u32]> = instructions(&words)
            .filter(|(op, _)| *op == OP_F_CONVERT)
            .map(|(_, instruction)| instruction)
            .collect();
        let results: Vec<u32> = conversions.iter().map(|instruction| instruction[2]).collect();
        assert!(!results.is_empty(), "f64 becomes f32");
        assert!(conversions.iter().all(|instruction| !results.contains(&instruction[3])));
    }

    #[test]
    fn errors_name_the_file_and_the_line() {
        assert!(error_of("\nfn f() -> f32 { return x; }\n").starts_with("shaders/broken.wgsl:2: "));
        assert!(error_of("\n\nfn f() -> f32 { return; }").starts_with("shaders/broken.wgsl:3: "));
        assert!(error_of("//#if tree\n").starts_with("shaders/broken.wgsl: "));
        assert!(error_of("\n//#end\n").starts_with("shaders/broken.wgsl:2: "));
        assert!(error_of("\n//#each lamp\n//#else").starts_with("shaders/broken.wgsl:3: "));
        assert!(error_of("//#each cube\n").starts_with("shaders/broken.wgsl:1: "));
        assert!(error_of("//#fi\n").starts_with("shaders/broken.wgsl:1: "));
    }

    /// A misspelt need would leave its lines out without a word, also where they are left out anyway.
    #[test]
    fn an_unknown_need_is_an_error() {
        assert_eq!(error_of("//#if tree\n//#else\n//#end\n"), "");
        for (text, line) in [("\n//#if teer\n//#end\n", 2), ("//#if tree\n//#if lamp\n", 2)] {
            let error = error_of(text);
            assert!(
                error.starts_with(&format!("shaders/broken.wgsl:{line}: unknown need ")),
                "{error}"
            );
        }
    }
}
