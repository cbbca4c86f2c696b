//! WGSL parts → one shader with what the scene needs → validated naga module → SPIR-V in which
//! every float result is decorated `NoContraction`.

use naga::back::spv;
use naga::compact::{KeepUnused, compact};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};

use super::layout::{Lamp, Layout, Lighting, Params, RayRecord, Walk};
use super::self_test::NUMERATOR;
use super::texture::TEXELS_PER_ROW;
use crate::bvh::{IS_LEAF, MOST_BOXES, MOST_BOXES_TO_LIGHT};
use crate::error::{Error, Result};
use crate::kernel::{About, FloatType, Kernel, SHARED_PARTS, ShaderPart, Space, part};
use crate::num::{Float as _, OPEN};
use crate::prepare::{LightKey, ShaderKey, SphereSearch, lamp_kind};
use crate::rays::Bundle;

/// Invocations of one workgroup, columns × rows of the tile.
pub const WORKGROUP: [u32; 2] = [8, 8];

const RENDER: ShaderPart = part!("render.wgsl");
const PLAIN_LIGHT: ShaderPart = part!("plain_light.wgsl");
const PRINTED_LIGHT: ShaderPart = part!("printed/light.wgsl");
const LIT: ShaderPart = part!("lit.wgsl");
const TREE: ShaderPart = part!("tree.wgsl");
const SELF_TEST: ShaderPart = part!("self_test.wgsl");

/// A validated shader.
pub struct Shader {
    /// The WGSL text that was put together.
    pub wgsl: String,
    /// The validated form of the text.
    pub module: naga::Module,
    /// The findings of its validation.
    pub info: ModuleInfo,
}

/// Puts together and validates a scene's shader.
///
/// # Errors
/// [`Error::Shader`] names the `.wgsl` file and line; that is a defect of the program.
pub fn compile(key: &ShaderKey) -> Result<Shader> {
    compile_edited(key, None)
}

/// A test's change of the WGSL text of every scene's shader.
pub type Edit = Box<dyn Fn(&str) -> String + Send + Sync>;

/// [`compile`], with the text edited where that is wanted.
pub(super) fn compile_edited(key: &ShaderKey, edit: Option<&Edit>) -> Result<Shader> {
    let mut parts = SHARED_PARTS.to_vec();
    parts.extend(key.kernel.about().wgsl.parts);
    match key.light {
        Some(LightKey::Plain { .. }) => parts.push(PLAIN_LIGHT),
        Some(LightKey::Certified { .. }) => parts.extend([PRINTED_LIGHT, LIT]),
        None => parts.push(RENDER),
    }
    if key.spheres == SphereSearch::Tree {
        parts.push(TREE);
    }
    compile_parts(&parts, &Choices { edit, ..Choices::new(key) })
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
    needs: Needs,
    /// All kinds of what is repeated: how often, and how often at most without a loop.
    counts: Vec<(&'static str, [usize; 2])>,
    /// WGSL for the facts whose home is Rust.
    constants: String,
    /// Done to the text that was put together.
    edit: Option<&'a Edit>,
}

impl Choices<'_> {
    fn new(key: &ShaderKey) -> Choices<'static> {
        let (needs, counts, constants) = (Needs::new(key), counts(key), constants(key));
        Choices { needs, counts, constants, edit: None }
    }
}

/// Bytes that each device's uniforms hold.
const UNIFORM_BYTES: usize = 16 << 10;

/// What rays look at one after the other: its names, and where it is. The numbers of a uniform are loaded once for all lanes,
/// within loops as well; what it has no room for lies in a buffer.
fn lists(key: &ShaderKey) -> String {
    let [sphere, plane] = key.kernel.about().record_bytes;
    let lists = [
        ("spheres", "SphereRecord", key.n_spheres, sphere),
        ("planes", "PlaneRecord", key.n_planes, plane),
        ("lamps", "Lamp", n_lamps(key), LAMP_BYTES),
    ];
    // With light in trees lavapipe of Mesa 22.3 crashes where the fourth uniform is that of the lamps.
    let is_lit_tree = key.light.is_some() && key.spheres == SphereSearch::Tree;
    let room = if is_lit_tree { 0 } else { UNIFORM_BYTES };
    let list = |(name, element, n, bytes): (&str, &str, usize, usize)| match n * bytes <= room {
        true => format!("@group(0) @binding(next) var<uniform> {name}: array<{element}, {n}>;\n"),
        false => format!("@group(0) @binding(next) var<storage, read> {name}: array<{element}>;\n"),
    };
    lists.into_iter().filter(|&(_, _, n, _)| n > 0).map(list).collect()
}

/// Loops around loops take twice as long on lavapipe, and long texts long to compile.
fn counts(key: &ShaderKey) -> Vec<(&'static str, [usize; 2])> {
    let (n_lamps, n_samples) = (n_lamps(key), n_samples(key).pow(2));
    vec![
        ("lamp", [n_lamps, MOST_REPEATED]),
        ("sample", [n_samples, MOST_REPEATED / n_lamps.max(1)]),
    ]
}

fn n_samples(key: &ShaderKey) -> usize {
    match key.light {
        Some(LightKey::Certified { n_samples, .. }) => n_samples as usize,
        _ => 1,
    }
}

fn n_lamps(key: &ShaderKey) -> usize {
    match key.light {
        Some(LightKey::Plain { n_lamps } | LightKey::Certified { n_lamps, .. }) => n_lamps,
        None => 0,
    }
}

macro_rules! needs {
    ($($(#[$doc:meta])* $need:ident,)*) => {
        /// What a scene needs of the parts, by the names that `//#if` asks for.
        #[derive(Default)]
        struct Needs { $($(#[$doc])* $need: bool,)* }

        impl Needs {
            /// Whether that is needed; `None` where there is no such name.
            fn get(&self, name: &str) -> Option<bool> {
                match name {
                    $(stringify!($need) => Some(self.$need),)*
                    _ => None,
                }
            }
        }
    };
}

needs! {
    /// Spheres, one after the other.
    spheres,
    /// Spheres, however they are found.
    any_spheres,
    /// The boxes of a tree.
    tree,
    /// Planes.
    planes,
    /// The formulas for spheres whose size hides their distance.
    close,
    /// `t` and normals.
    surface,
    /// Lights.
    lamps,
    /// Listed spheres in the way of light.
    met_spheres,
    /// Planes in the way of light.
    met_planes,
    /// Numbers that are moved from the camera to where a shadow ray starts.
    moved,
    /// Rays with origins of their own.
    anywhere,
    /// Rays from one point.
    point,
    /// Rays of a list.
    free,
    /// A kernel in f64.
    double,
    /// The kernel with a proof.
    certified,
}

impl Needs {
    fn new(key: &ShaderKey) -> Needs {
        // The host has made the numbers for rays from one point.
        let is_point = key.bundle == Bundle::Point;
        let is_plain_light = matches!(key.light, Some(LightKey::Plain { .. }));
        let about = key.kernel.about();
        let moved = is_plain_light && is_point && about.space == Space::Reference;
        let (n_met_spheres, n_met_planes) = match key.light {
            Some(LightKey::Certified { n_spheres, n_planes, .. }) => (n_spheres, n_planes),
            _ => (0, 0),
        };
        let tree = key.spheres == SphereSearch::Tree;
        Needs {
            spheres: key.n_spheres > 0,
            any_spheres: key.n_spheres > 0 || tree,
            tree,
            planes: key.n_planes > 0,
            close: key.close,
            surface: key.surface || is_plain_light,
            lamps: n_lamps(key) > 0,
            met_spheres: n_met_spheres > 0,
            met_planes: n_met_planes > 0,
            moved,
            anywhere: moved || !is_point,
            point: is_point,
            free: key.bundle == Bundle::Free,
            double: about.float == FloatType::F64,
            certified: key.kernel == Kernel::Certified,
        }
    }
}

fn workgroup() -> String {
    let [width, height] = WORKGROUP;
    format!("const WORKGROUP_WIDTH = {width}u;\nconst WORKGROUP_HEIGHT = {height}u;\n")
}

fn constants(key: &ShaderKey) -> String {
    let About { wgsl, float, .. } = key.kernel.about();
    let mut text = workgroup() + &aliases(float.name());
    for (count, record) in [(key.n_spheres, "Sphere"), (key.n_planes, "Plane")] {
        if count > 0 {
            text += &format!("alias {record}Record = {record}{};\n", wgsl.records);
        }
    }
    let mut constants = Vec::new();
    if key.spheres == SphereSearch::Tree {
        let most_boxes = if key.light.is_some() { MOST_BOXES_TO_LIGHT } else { MOST_BOXES };
        constants.extend([
            ("IS_LEAF", format!("{IS_LEAF}u")),
            ("MOST_BOXES", format!("{most_boxes}u")),
            ("NO_PLACE", format!("{}u", u32::MAX)),
            ("ROW_BITS", format!("{}u", TEXELS_PER_ROW.ilog2())),
        ]);
    }
    let unsigned = |name, value: usize| (name, format!("{value}u"));
    constants.extend([unsigned("N_SPHERES", key.n_spheres), unsigned("N_PLANES", key.n_planes)]);
    match key.light {
        Some(LightKey::Plain { .. }) => constants.extend([
            unsigned("LAMP_EYE", lamp_kind::EYE as usize),
            unsigned("LAMP_POINT", lamp_kind::POINT as usize),
            unsigned("LAMP_SUN", lamp_kind::SUN as usize),
        ]),
        Some(LightKey::Certified { n_spheres, n_planes, .. }) => {
            constants.extend([
                unsigned("N_SAMPLES", n_samples(key)),
                unsigned("N_COLORS", 1 + key.n_spheres + key.n_planes),
                unsigned("N_MET_SPHERES", n_spheres),
                unsigned("N_MET_PLANES", n_planes),
                unsigned("OPEN", OPEN as usize),
                ("KNOWN", FloatType::F32.literal(f32::KNOWN)),
                ("BEYOND", FloatType::F32.literal(f32::BEYOND)),
            ]);
        }
        None => {}
    }
    for (name, value) in constants {
        text += &format!("const {name} = {value};\n");
    }
    text += &Params::declaration();
    text += "@group(0) @binding(next) var<uniform> params: Params;\n";
    if key.bundle == Bundle::Free {
        text += &RayRecord::declaration();
    }
    if key.spheres == SphereSearch::Tree {
        text += &Walk::declaration();
    }
    if matches!(key.light, Some(LightKey::Plain { .. })) {
        text += &(Lighting::declaration() + &Lamp::declaration());
    }
    text + &lists(key)
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
    let place = |line: usize| {
        let &(file, start) =
            starts.iter().rfind(|&&(_, start)| start <= line).unwrap_or(&starts[0]);
        format!("{file}:{}", line - start + 1)
    };

    let mut module = naga::front::wgsl::parse_str(&wgsl).map_err(|error| {
        let line = error.location(&wgsl).map_or(1, |location| location.line_number as usize);
        Error::Shader(format!("{}: {}", place(line), error.message()))
    })?;
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::FLOAT64);
    let mut validate = |module: &naga::Module| {
        validator.validate(module).map_err(|error| {
            let line = error.location(&wgsl).map_or(1, |location| location.line_number as usize);
            Error::Shader(format!("{}: {}", place(line), error.emit_to_string(&wgsl)))
        })
    };
    validate(&module)?;
    // Printed formulas that the scene does not use.
    compact(&mut module, KeepUnused::No);
    let info = validate(&module)?;
    Ok(Shader { wgsl, module, info })
}

/// Up to so many lamps, times samples, are looked at without a loop.
pub(super) const MOST_REPEATED: usize = 32;

/// Bytes of a lamp, at most.
const LAMP_BYTES: usize = 64;

/// Turns of loops after which a shader may be stopped: llvmpipe ends all loops of an invocation after 65 535
/// (`LP_MAX_TGSI_LOOP_ITERATIONS`), without a word, and goes on behind them.
pub(super) const MOST_TURNS_IN_SOFTWARE: usize = 65_000;

/// Turns of loops in which a ray looks at the listed objects once.
pub(super) fn turns_of_ray(key: &ShaderKey) -> usize {
    key.n_spheres + key.n_planes
}

/// A block that a `//#` directive opens.
enum Block {
    If(bool),
    Each { counts: [usize; 2], body: String },
}

/// Carries out the directives of a part, keeping its line numbers:
/// - `//#if need` … `//#else` … `//#end` keeps the lines that the scene needs; a name that is not one of [`Needs`] is an
///   error;
/// - `//#each lamp` … `//#end` repeats its lines for each lamp, `INDEX` standing for its index.
fn expand(part: &ShaderPart, choices: &Choices) -> Result<String> {
    let mut open: Vec<Block> = Vec::new();
    let mut text = String::new();
    for (index, line) in part.text.lines().enumerate() {
        let wrong = |what: &str| Error::Shader(format!("{}:{}: {what}", part.file, index + 1));
        let directive = line.trim().strip_prefix("//#");
        match directive.map(|d| d.split_whitespace().collect::<Vec<_>>()).as_deref() {
            Some(["if", need]) => match choices.needs.get(need) {
                Some(holds) => open.push(Block::If(holds)),
                None => return Err(wrong(&format!("unknown need `{need}`"))),
            },
            Some(["else"]) => match open.last_mut() {
                Some(Block::If(keep)) => *keep = !*keep,
                _ => return Err(wrong("no //#if is open here")),
            },
            Some(["each", kind]) => match choices.counts.iter().find(|(known, _)| known == kind) {
                Some(&(_, counts)) => open.push(Block::Each { counts, body: String::new() }),
                None => return Err(wrong("unknown kind")),
            },
            Some(["end"]) => match open.pop() {
                Some(Block::If(_)) => {}
                Some(Block::Each { counts, body }) => text += &repeat(counts, &body),
                None => return Err(wrong("nothing is open here")),
            },
            Some(_) => return Err(wrong("unknown directive")),
            None if open.iter().any(|block| matches!(block, Block::If(false))) => {}
            None => match open.last_mut() {
                Some(Block::Each { body, .. }) => *body += line.trim(),
                _ => text += line,
            },
        }
        text += "\n";
    }
    match open.is_empty() {
        true => Ok(text),
        false => Err(Error::Shader(format!("{}: a directive is not closed", part.file))),
    }
}

fn repeat([count, most]: [usize; 2], body: &str) -> String {
    if count <= most {
        (0..count).map(|index| body.replace("INDEX", &format!("{index}u"))).collect()
    } else {
        let body = body.replace("INDEX", "i");
        format!("for (var i = 0u; i < {count}u; i++) {{ {body} }}")
    }
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
        let counts = vec![("lamp", [2, 2])];
        let choices = Choices { counts, constants: aliases("f32"), ..Choices::default() };
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
        assert!(error_of("//#if spheres\n").starts_with("shaders/broken.wgsl: "));
        assert!(error_of("\n//#end\n").starts_with("shaders/broken.wgsl:2: "));
        assert!(error_of("\n//#each lamp\n//#else").starts_with("shaders/broken.wgsl:3: "));
        assert!(error_of("//#each cube\n").starts_with("shaders/broken.wgsl:1: "));
        assert!(error_of("//#fi\n").starts_with("shaders/broken.wgsl:1: "));
    }

    /// A misspelt need would leave its lines out without a word, also where they are left out anyway.
    #[test]
    fn an_unknown_need_is_an_error() {
        assert_eq!(error_of("//#if spheres\n//#else\n//#end\n"), "");
        for (text, line) in [("\n//#if shperes\n//#end\n", 2), ("//#if spheres\n//#if plane\n", 2)]
        {
            let error = error_of(text);
            assert!(
                error.starts_with(&format!("shaders/broken.wgsl:{line}: unknown need ")),
                "{error}"
            );
        }
    }
}
