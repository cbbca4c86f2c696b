//! Stand-ins for drivers that do otherwise than they are told: each changes the arithmetic of a shader's
//! SPIR-V words. Only scalars are touched, which is all that a kernel decides by.

use std::collections::HashMap;

const HEADER_WORDS: usize = 5;
const BOUND: usize = 3;

const OP_EXT_INST: u16 = 12;
const OP_CAPABILITY: u16 = 17;
const OP_TYPE_BOOL: u16 = 20;
const OP_TYPE_FLOAT: u16 = 22;
const OP_CONSTANT: u16 = 43;
const OP_FUNCTION: u16 = 54;
const OP_F_CONVERT: u16 = 115;
const OP_COPY_OBJECT: u16 = 83;
const OP_F_ADD: u16 = 129;
const OP_F_SUB: u16 = 131;
const OP_F_MUL: u16 = 133;
const OP_F_DIV: u16 = 136;
const OP_SELECT: u16 = 169;
const OP_F_ORD_LESS_THAN: u16 = 184;
const CAPABILITY_FLOAT64: u32 = 10;
const GLSL_F_ABS: u32 = 4;
const GLSL_SQRT: u32 = 31;
const OP_EXT_INST_IMPORT: u16 = 11;

/// An instruction of these words behind its first one.
fn instruction(op: u16, operands: &[u32]) -> Vec<u32> {
    let first = (operands.len() as u32 + 1) << 16 | u32::from(op);
    [&[first], operands].concat()
}

fn op(words: &[u32]) -> u16 {
    words[0] as u16
}

/// A module, instruction by instruction.
struct Module {
    header: Vec<u32>,
    instructions: Vec<Vec<u32>>,
    /// New types and constants, which go before the first function.
    new: Vec<Vec<u32>>,
}

impl Module {
    fn new(words: &[u32]) -> Module {
        let (header, mut rest) = words.split_at(HEADER_WORDS);
        let mut instructions = Vec::new();
        while let Some(first) = rest.first() {
            let (one, others) = rest.split_at((first >> 16) as usize);
            instructions.push(one.to_vec());
            rest = others;
        }
        Module { header: header.to_vec(), instructions, new: Vec::new() }
    }

    fn id(&mut self) -> u32 {
        let id = self.header[BOUND];
        self.header[BOUND] += 1;
        id
    }

    /// The id of a type or a constant, which is made where it is not there. Its own id is the operand at
    /// `place`.
    fn global(&mut self, op_wanted: u16, place: usize, others: &[u32]) -> u32 {
        let all = self.instructions.iter().chain(&self.new);
        for words in all.filter(|words| op(words) == op_wanted) {
            let mut operands = words[1..].to_vec();
            let id = operands.remove(place);
            if operands == others {
                return id;
            }
        }
        let id = self.id();
        let mut operands = others.to_vec();
        operands.insert(place, id);
        self.new.push(instruction(op_wanted, &operands));
        id
    }

    fn float(&mut self, bits: u32) -> u32 {
        self.global(OP_TYPE_FLOAT, 0, &[bits])
    }

    fn constant(&mut self, of_type: u32, value: f32) -> u32 {
        self.global(OP_CONSTANT, 1, &[of_type, value.to_bits()])
    }

    fn extended(&self) -> u32 {
        let import = self.instructions.iter().find(|words| op(words) == OP_EXT_INST_IMPORT);
        import.map_or(0, |words| words[1])
    }

    /// Puts the instructions of functions through `edit`.
    fn edited(mut self, mut edit: impl FnMut(&mut Module, &[u32]) -> Vec<Vec<u32>>) -> Vec<u32> {
        let instructions = self.instructions.clone();
        let start = instructions.iter().position(|words| op(words) == OP_FUNCTION);
        let (globals, functions) = instructions.split_at(start.unwrap_or(instructions.len()));
        let functions: Vec<_> = functions.iter().flat_map(|words| edit(&mut self, words)).collect();
        let capabilities =
            self.new.extract_if(.., |words| op(words) == OP_CAPABILITY).collect::<Vec<_>>();
        [&[self.header], &*capabilities, globals, &self.new, &functions].concat().concat()
    }
}

/// Type and id of the result of `+`, `−`, `×`, `÷` or `√` of f32 scalars.
fn rounded(module: &mut Module, words: &[u32]) -> Option<(u32, u32)> {
    let scalar = module.float(32);
    let is_root = op(words) == OP_EXT_INST && words[4] == GLSL_SQRT;
    let is_rounded = matches!(op(words), OP_F_ADD | OP_F_SUB | OP_F_MUL | OP_F_DIV) || is_root;
    (is_rounded && words[1] == scalar).then(|| (words[1], words[2]))
}

/// An instruction with `id` as its result.
fn with_result(words: &[u32], id: u32) -> Vec<u32> {
    let mut words = words.to_vec();
    words[2] = id;
    words
}

/// `a·b + c` of f32 numbers, for a sum of a product, in one rounding but for those of f64.
pub fn contracts(words: &[u32]) -> Vec<u32> {
    let mut module = Module::new(words);
    let [single, double] = [32, 64].map(|bits| module.float(bits));
    let float64 = instruction(OP_CAPABILITY, &[CAPABILITY_FLOAT64]);
    if !module.instructions.contains(&float64) {
        module.new.push(float64);
    }
    let mut products: HashMap<u32, [u32; 2]> = HashMap::new();
    module.edited(move |module, words| {
        if op(words) == OP_F_MUL && words[1] == single {
            products.insert(words[2], [words[3], words[4]]);
        }
        let is_sum = op(words) == OP_F_ADD && words[1] == single;
        let operands = if is_sum { [words[3], words[4]] } else { [0; 2] };
        let product = operands.iter().find_map(|id| products.get(id).map(|of| (*id, *of)));
        let Some((product, [a, b])) = product else { return vec![words.to_vec()] };
        let c = if operands[0] == product { operands[1] } else { operands[0] };
        let [wide_a, wide_b, wide_c, wide_product, wide_sum] = [(); 5].map(|()| module.id());
        let widened = |to, from| instruction(OP_F_CONVERT, &[double, to, from]);
        vec![
            widened(wide_a, a),
            widened(wide_b, b),
            widened(wide_c, c),
            instruction(OP_F_MUL, &[double, wide_product, wide_a, wide_b]),
            instruction(OP_F_ADD, &[double, wide_sum, wide_product, wide_c]),
            instruction(OP_F_CONVERT, &[single, words[2], wide_sum]),
        ]
    })
}

/// `b` for `(a + b) − a`, as real numbers have it.
pub fn reassociates(words: &[u32]) -> Vec<u32> {
    let mut sums: HashMap<u32, [u32; 2]> = HashMap::new();
    Module::new(words).edited(move |_, words| {
        if op(words) == OP_F_ADD {
            sums.insert(words[2], [words[3], words[4]]);
        }
        let rest = (op(words) == OP_F_SUB).then(|| sums.get(&words[3])).flatten();
        let rest = rest.and_then(|&[a, b]| match words[4] {
            taken if taken == a => Some(b),
            taken if taken == b => Some(a),
            _ => None,
        });
        match rest {
            Some(rest) => vec![instruction(OP_COPY_OBJECT, &[words[1], words[2], rest])],
            None => vec![words.to_vec()],
        }
    })
}

/// 0 for each subnormal result.
pub fn flushes(words: &[u32]) -> Vec<u32> {
    let mut module = Module::new(words);
    let (single, extended) = (module.float(32), module.extended());
    let truth = module.global(OP_TYPE_BOOL, 0, &[]);
    let [zero, least] = [0.0, f32::MIN_POSITIVE].map(|x| module.constant(single, x));
    module.edited(move |module, words| {
        let Some((of_type, result)) = rounded(module, words) else { return vec![words.to_vec()] };
        let [kept, magnitude, is_tiny] = [(); 3].map(|()| module.id());
        vec![
            with_result(words, kept),
            instruction(OP_EXT_INST, &[of_type, magnitude, extended, GLSL_F_ABS, kept]),
            instruction(OP_F_ORD_LESS_THAN, &[truth, is_tiny, magnitude, least]),
            instruction(OP_SELECT, &[of_type, result, is_tiny, zero, kept]),
        ]
    })
}

/// Results of some operations one or two units from the nearest.
fn rounds_off(words: &[u32], is_spoiled: impl Fn(&[u32]) -> bool) -> Vec<u32> {
    let mut module = Module::new(words);
    let single = module.float(32);
    let wider = module.constant(single, 1.0 + f32::EPSILON);
    module.edited(move |module, words| match rounded(module, words) {
        Some((of_type, result)) if is_spoiled(words) => {
            let nearest = module.id();
            vec![
                with_result(words, nearest),
                instruction(OP_F_MUL, &[of_type, result, nearest, wider]),
            ]
        }
        _ => vec![words.to_vec()],
    })
}

/// Sums that are off by more than a rounding.
pub fn rounds_sums_badly(words: &[u32]) -> Vec<u32> {
    rounds_off(words, |words| matches!(op(words), OP_F_ADD | OP_F_SUB))
}

/// Quotients and roots that are off, but no more than Vulkan allows.
pub fn rounds_quotients_as_allowed(words: &[u32]) -> Vec<u32> {
    rounds_off(words, |words| matches!(op(words), OP_F_DIV | OP_EXT_INST))
}
