//! Runs a shader as naga understands it, one invocation at a time, and looks at every float: an
//! operation that takes or gives ∞ or NaN is reported, also where its result is selected away.

use std::collections::HashMap;

use naga::{
    BinaryOperator, Block, Expression, Function, Handle, Literal, LocalVariable, MathFunction,
    Module, ScalarKind, Statement, Type, TypeInner, UnaryOperator,
};

/// A value of the shader.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    F32(f32),
    U32(u32),
    I32(i32),
    Bool(bool),
    /// A vector, a struct or an array.
    Parts(Vec<Value>),
    /// A global or local variable, and the way to a part of it.
    Pointer(Root, Vec<usize>),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Root {
    Global(usize),
    Local(usize),
}

impl Value {
    pub fn vector(parts: [f32; 3]) -> Value {
        Value::Parts(parts.map(Value::F32).to_vec())
    }

    fn number(&self) -> usize {
        match self {
            Value::U32(index) => *index as usize,
            Value::I32(index) => *index as usize,
            _ => panic!("{self:?} as an index"),
        }
    }

    fn part(&self, index: usize) -> &Value {
        match self {
            Value::Parts(parts) => &parts[index],
            _ => panic!("part {index} of {self:?}"),
        }
    }

    fn is_true(&self) -> bool {
        match self {
            Value::Bool(value) => *value,
            _ => panic!("{self:?} as a condition"),
        }
    }

    fn is_finite(&self) -> bool {
        match self {
            Value::F32(x) => x.is_finite(),
            Value::Parts(parts) => parts.iter().all(Value::is_finite),
            _ => true,
        }
    }
}

/// A shader with its buffers and textures.
pub struct Machine<'a> {
    module: &'a Module,
    globals: Vec<Value>,
    /// What was not finite: function, operation, operands.
    pub not_finite: Vec<String>,
    /// Float operations so far.
    pub operations: u64,
}

enum Flow {
    Next,
    Break,
    Continue,
    Return(Option<Value>),
}

struct Frame<'a> {
    function: &'a Function,
    name: &'a str,
    arguments: Vec<Value>,
    locals: Vec<Value>,
    values: HashMap<usize, Value>,
}

impl<'a> Machine<'a> {
    /// `globals` by their names.
    pub fn new(module: &'a Module, globals: &HashMap<&str, Value>) -> Machine<'a> {
        let value = |name: &Option<String>| {
            let found = name.as_deref().and_then(|name| globals.get(name));
            found.cloned().unwrap_or(Value::Parts(Vec::new()))
        };
        let globals = module.global_variables.iter().map(|(_, v)| value(&v.name)).collect();
        Machine { module, globals, not_finite: Vec::new(), operations: 0 }
    }

    /// Replaces a part of a global variable.
    pub fn set(&mut self, global: &str, part: usize, value: Value) {
        let (handle, _) = self
            .module
            .global_variables
            .iter()
            .find(|(_, v)| v.name.as_deref() == Some(global))
            .unwrap_or_else(|| panic!("no global {global}"));
        match &mut self.globals[handle.index()] {
            Value::Parts(parts) => parts[part] = value,
            other => panic!("{other:?} has no parts"),
        }
    }

    /// What a global variable holds.
    pub fn global(&self, global: &str) -> &Value {
        let (handle, _) = self
            .module
            .global_variables
            .iter()
            .find(|(_, v)| v.name.as_deref() == Some(global))
            .unwrap_or_else(|| panic!("no global {global}"));
        &self.globals[handle.index()]
    }

    /// Runs the entry point.
    pub fn enter(&mut self, arguments: Vec<Value>) {
        let entry = &self.module.entry_points[0];
        self.call(&entry.function, &entry.name, arguments);
    }

    /// Runs a function.
    pub fn evaluate(&mut self, function: &str, arguments: Vec<Value>) -> Value {
        let mut all = self.module.functions.iter();
        let (_, found) =
            all.find(|(_, f)| f.name.as_deref() == Some(function)).expect("a function");
        self.call(found, found.name.as_deref().unwrap_or_default(), arguments).expect("a result")
    }

    fn call(
        &mut self,
        function: &'a Function,
        name: &'a str,
        arguments: Vec<Value>,
    ) -> Option<Value> {
        let mut frame =
            Frame { function, name, arguments, locals: Vec::new(), values: HashMap::new() };
        for (_, LocalVariable { ty, init, .. }) in function.local_variables.iter() {
            let value = match init {
                Some(init) => self.value(&frame, *init),
                None => self.zero(*ty),
            };
            frame.locals.push(value);
        }
        match self.run(&mut frame, &function.body) {
            Flow::Return(value) => value,
            _ => None,
        }
    }

    fn zero(&self, ty: Handle<Type>) -> Value {
        match &self.module.types[ty].inner {
            TypeInner::Scalar(scalar) => zero_scalar(scalar.kind),
            TypeInner::Vector { size, scalar } => {
                Value::Parts(vec![zero_scalar(scalar.kind); *size as usize])
            }
            TypeInner::Struct { members, .. } => {
                Value::Parts(members.iter().map(|member| self.zero(member.ty)).collect())
            }
            other => panic!("the zero of {other:?}"),
        }
    }

    /// A value of this type from a buffer's bytes.
    pub fn decode(module: &Module, ty: Handle<Type>, bytes: &[u8]) -> Value {
        let word = |at: usize| <[u8; 4]>::try_from(&bytes[at..at + 4]).unwrap();
        let scalar = |kind: ScalarKind, at: usize| match kind {
            ScalarKind::Float => Value::F32(f32::from_le_bytes(word(at))),
            ScalarKind::Uint => Value::U32(u32::from_le_bytes(word(at))),
            ScalarKind::Sint => Value::I32(i32::from_le_bytes(word(at))),
            other => panic!("{other:?} in a buffer"),
        };
        match &module.types[ty].inner {
            TypeInner::Scalar(s) => scalar(s.kind, 0),
            TypeInner::Vector { size, scalar: s } => {
                Value::Parts((0..*size as usize).map(|k| scalar(s.kind, 4 * k)).collect())
            }
            TypeInner::Struct { members, .. } => {
                let member = |m: &naga::StructMember| {
                    Machine::decode(module, m.ty, &bytes[m.offset as usize..])
                };
                Value::Parts(members.iter().map(member).collect())
            }
            TypeInner::Array { base, stride, .. } => {
                let chunks = bytes.chunks_exact(*stride as usize);
                Value::Parts(chunks.map(|part| Machine::decode(module, *base, part)).collect())
            }
            other => panic!("{other:?} in a buffer"),
        }
    }

    fn run(&mut self, frame: &mut Frame<'a>, block: &'a Block) -> Flow {
        for statement in block.iter() {
            let flow = match statement {
                Statement::Emit(range) => {
                    for handle in range.clone() {
                        let value = self.compute(frame, handle);
                        frame.values.insert(handle.index(), value);
                    }
                    Flow::Next
                }
                Statement::Block(block) => self.run(frame, block),
                Statement::If { condition, accept, reject } => {
                    let chosen = self.value(frame, *condition).is_true();
                    self.run(frame, if chosen { accept } else { reject })
                }
                Statement::Loop { body, continuing, break_if } => loop {
                    match self.run(frame, body) {
                        Flow::Break => break Flow::Next,
                        Flow::Return(value) => break Flow::Return(value),
                        Flow::Next | Flow::Continue => {}
                    }
                    self.run(frame, continuing);
                    if break_if.is_some_and(|stop| self.value(frame, stop).is_true()) {
                        break Flow::Next;
                    }
                },
                Statement::Break => Flow::Break,
                Statement::Continue => Flow::Continue,
                Statement::Return { value } => {
                    Flow::Return(value.map(|value| self.value(frame, value)))
                }
                Statement::Store { pointer, value } => {
                    let value = self.value(frame, *value);
                    let Value::Pointer(root, path) = self.value(frame, *pointer) else {
                        panic!("a store to no pointer")
                    };
                    let variable = match root {
                        Root::Global(index) => &mut self.globals[index],
                        Root::Local(index) => &mut frame.locals[index],
                    };
                    let place = path.iter().fold(variable, |at, &index| match at {
                        Value::Parts(parts) => &mut parts[index],
                        other => panic!("part {index} of {other:?}"),
                    });
                    *place = value;
                    Flow::Next
                }
                Statement::Call { function, arguments, result } => {
                    let arguments = arguments.iter().map(|&a| self.value(frame, a)).collect();
                    let called = &self.module.functions[*function];
                    let name = called.name.as_deref().unwrap_or("a function");
                    let value = self.call(called, name, arguments);
                    if let (Some(result), Some(value)) = (result, value) {
                        frame.values.insert(result.index(), value);
                    }
                    Flow::Next
                }
                other => panic!("{other:?}"),
            };
            if !matches!(flow, Flow::Next) {
                return flow;
            }
        }
        Flow::Next
    }

    /// The value of an expression that was computed, or needs no computing.
    fn value(&self, frame: &Frame, handle: Handle<Expression>) -> Value {
        if let Some(value) = frame.values.get(&handle.index()) {
            return value.clone();
        }
        match &frame.function.expressions[handle] {
            Expression::FunctionArgument(index) => frame.arguments[*index as usize].clone(),
            Expression::GlobalVariable(global) => {
                Value::Pointer(Root::Global(global.index()), Vec::new())
            }
            Expression::LocalVariable(local) => {
                Value::Pointer(Root::Local(local.index()), Vec::new())
            }
            other => self.constant(other, |part| self.value(frame, part)),
        }
    }

    fn constant(
        &self,
        expression: &Expression,
        part: impl Fn(Handle<Expression>) -> Value,
    ) -> Value {
        match expression {
            Expression::Literal(Literal::F32(x)) => Value::F32(*x),
            Expression::Literal(Literal::U32(x)) => Value::U32(*x),
            Expression::Literal(Literal::I32(x)) => Value::I32(*x),
            Expression::Literal(Literal::Bool(x)) => Value::Bool(*x),
            Expression::ZeroValue(ty) => self.zero(*ty),
            Expression::Constant(constant) => {
                self.global_constant(self.module.constants[*constant].init)
            }
            Expression::Compose { components, .. } => {
                Value::Parts(components.iter().map(|&c| part(c)).collect())
            }
            Expression::Splat { size, value } => Value::Parts(vec![part(*value); *size as usize]),
            other => panic!("{other:?}"),
        }
    }

    fn global_constant(&self, handle: Handle<Expression>) -> Value {
        let expression = &self.module.global_expressions[handle];
        self.constant(expression, |part| self.global_constant(part))
    }

    fn compute(&mut self, frame: &Frame, handle: Handle<Expression>) -> Value {
        let get = |handle: &Handle<Expression>| self.value(frame, *handle);
        let (operands, result) = match &frame.function.expressions[handle] {
            Expression::Access { base, index } => return access(get(base), get(index).number()),
            Expression::AccessIndex { base, index } => {
                return access(get(base), *index as usize);
            }
            Expression::Load { pointer } => {
                let Value::Pointer(root, path) = get(pointer) else { panic!("a load") };
                let variable = match root {
                    Root::Global(index) => &self.globals[index],
                    Root::Local(index) => &frame.locals[index],
                };
                let loaded = path.iter().fold(variable, |at, &index| at.part(index)).clone();
                (vec![], loaded)
            }
            Expression::ImageLoad { image, coordinate, .. } => {
                let Value::Pointer(Root::Global(index), _) = get(image) else { panic!("an image") };
                let coordinate = get(coordinate);
                assert_eq!(coordinate.part(1).number(), 0, "a texture of one row");
                (vec![], self.globals[index].part(coordinate.part(0).number()).clone())
            }
            Expression::Swizzle { size, vector, pattern } => {
                let vector = get(vector);
                let chosen = pattern[..*size as usize].iter();
                return Value::Parts(chosen.map(|&c| vector.part(c as usize).clone()).collect());
            }
            Expression::Unary { op, expr } => {
                let x = get(expr);
                (vec![x.clone()], each(&x, &|x| unary(*op, x)))
            }
            Expression::Binary { op, left, right } => {
                let (a, b) = (get(left), get(right));
                let result = each_two(&a, &b, &|a, b| binary(*op, a, b));
                (vec![a, b], result)
            }
            Expression::Select { condition, accept, reject } => {
                let (accept, reject) = (get(accept), get(reject));
                let chosen = match get(condition) {
                    Value::Parts(parts) => {
                        let part = |(k, yes): (usize, &Value)| {
                            if yes.is_true() { accept.part(k) } else { reject.part(k) }.clone()
                        };
                        Value::Parts(parts.iter().enumerate().map(part).collect())
                    }
                    yes if yes.is_true() => accept.clone(),
                    _ => reject.clone(),
                };
                (vec![accept, reject], chosen)
            }
            Expression::Math { fun, arg, arg1, .. } => {
                let (a, b) = (get(arg), arg1.as_ref().map(get));
                let result = match &b {
                    Some(b) => each_two(&a, b, &|a, b| math(*fun, a, Some(b))),
                    None => each(&a, &|a| math(*fun, a, None)),
                };
                (std::iter::once(a).chain(b).collect(), result)
            }
            Expression::As { expr, kind, convert } => {
                let x = get(expr);
                (vec![x.clone()], each(&x, &|x| cast(*kind, convert.is_some(), x)))
            }
            other => return self.constant(other, |part| self.value(frame, part)),
        };
        let is_float = |value: &Value| match value {
            Value::Parts(parts) => matches!(parts.first(), Some(Value::F32(_))),
            value => matches!(value, Value::F32(_)),
        };
        if is_float(&result) || operands.iter().any(is_float) {
            self.operations += 1;
            if !result.is_finite() || !operands.iter().all(Value::is_finite) {
                let what = &frame.function.expressions[handle];
                self.not_finite
                    .push(format!("{}: {what:?} of {operands:?}: {result:?}", frame.name));
            }
        }
        result
    }
}

fn zero_scalar(kind: ScalarKind) -> Value {
    match kind {
        ScalarKind::Float => Value::F32(0.0),
        ScalarKind::Uint => Value::U32(0),
        ScalarKind::Sint => Value::I32(0),
        ScalarKind::Bool => Value::Bool(false),
        other => panic!("{other:?}"),
    }
}

fn access(base: Value, index: usize) -> Value {
    match base {
        Value::Pointer(root, mut path) => {
            path.push(index);
            Value::Pointer(root, path)
        }
        base => base.part(index).clone(),
    }
}

fn each(x: &Value, f: &impl Fn(&Value) -> Value) -> Value {
    match x {
        Value::Parts(parts) => Value::Parts(parts.iter().map(f).collect()),
        x => f(x),
    }
}

fn each_two(a: &Value, b: &Value, f: &impl Fn(&Value, &Value) -> Value) -> Value {
    match (a, b) {
        (Value::Parts(a), Value::Parts(b)) => {
            Value::Parts(a.iter().zip(b).map(|(a, b)| f(a, b)).collect())
        }
        (Value::Parts(a), b) => Value::Parts(a.iter().map(|a| f(a, b)).collect()),
        (a, Value::Parts(b)) => Value::Parts(b.iter().map(|b| f(a, b)).collect()),
        (a, b) => f(a, b),
    }
}

fn unary(op: UnaryOperator, x: &Value) -> Value {
    match (op, x) {
        (UnaryOperator::Negate, Value::F32(x)) => Value::F32(-x),
        (UnaryOperator::Negate, Value::I32(x)) => Value::I32(x.wrapping_neg()),
        (UnaryOperator::LogicalNot, Value::Bool(x)) => Value::Bool(!x),
        (UnaryOperator::BitwiseNot, Value::U32(x)) => Value::U32(!x),
        other => panic!("{other:?}"),
    }
}

fn binary(op: BinaryOperator, a: &Value, b: &Value) -> Value {
    use BinaryOperator as Op;
    fn compare<T: PartialOrd>(op: BinaryOperator, a: T, b: T) -> Option<Value> {
        Some(Value::Bool(match op {
            Op::Equal => a == b,
            Op::NotEqual => a != b,
            Op::Less => a < b,
            Op::LessEqual => a <= b,
            Op::Greater => a > b,
            Op::GreaterEqual => a >= b,
            _ => return None,
        }))
    }
    let compared = match (a, b) {
        (Value::F32(a), Value::F32(b)) => compare(op, a, b),
        (Value::U32(a), Value::U32(b)) => compare(op, a, b),
        (Value::I32(a), Value::I32(b)) => compare(op, a, b),
        (Value::Bool(a), Value::Bool(b)) => compare(op, a, b),
        _ => None,
    };
    if let Some(result) = compared {
        return result;
    }
    match (op, a, b) {
        (Op::Add, Value::F32(a), Value::F32(b)) => Value::F32(a + b),
        (Op::Subtract, Value::F32(a), Value::F32(b)) => Value::F32(a - b),
        (Op::Multiply, Value::F32(a), Value::F32(b)) => Value::F32(a * b),
        (Op::Divide, Value::F32(a), Value::F32(b)) => Value::F32(a / b),
        (Op::Add, Value::U32(a), Value::U32(b)) => Value::U32(a.wrapping_add(*b)),
        (Op::Subtract, Value::U32(a), Value::U32(b)) => Value::U32(a.wrapping_sub(*b)),
        (Op::Multiply, Value::U32(a), Value::U32(b)) => Value::U32(a.wrapping_mul(*b)),
        (Op::Add, Value::I32(a), Value::I32(b)) => Value::I32(a.wrapping_add(*b)),
        (Op::Subtract, Value::I32(a), Value::I32(b)) => Value::I32(a.wrapping_sub(*b)),
        (Op::Multiply, Value::I32(a), Value::I32(b)) => Value::I32(a.wrapping_mul(*b)),
        (Op::And, Value::U32(a), Value::U32(b)) => Value::U32(a & b),
        (Op::InclusiveOr, Value::U32(a), Value::U32(b)) => Value::U32(a | b),
        (Op::ShiftLeft, Value::U32(a), Value::U32(b)) => Value::U32(a << b),
        (Op::ShiftRight, Value::U32(a), Value::U32(b)) => Value::U32(a >> b),
        (Op::LogicalAnd | Op::And, Value::Bool(a), Value::Bool(b)) => Value::Bool(*a && *b),
        (Op::LogicalOr | Op::InclusiveOr, Value::Bool(a), Value::Bool(b)) => Value::Bool(*a || *b),
        other => panic!("{other:?}"),
    }
}

fn math(fun: MathFunction, a: &Value, b: Option<&Value>) -> Value {
    match (fun, a, b) {
        (MathFunction::Abs, Value::F32(a), None) => Value::F32(a.abs()),
        (MathFunction::Sqrt, Value::F32(a), None) => Value::F32(a.sqrt()),
        (MathFunction::Max, Value::F32(a), Some(Value::F32(b))) => Value::F32(a.max(*b)),
        (MathFunction::Min, Value::F32(a), Some(Value::F32(b))) => Value::F32(a.min(*b)),
        (MathFunction::Min, Value::U32(a), Some(Value::U32(b))) => Value::U32(*a.min(b)),
        other => panic!("{other:?}"),
    }
}

fn cast(kind: ScalarKind, converts: bool, x: &Value) -> Value {
    match (kind, converts, x) {
        (ScalarKind::Float, true, Value::I32(x)) => Value::F32(*x as f32),
        (ScalarKind::Float, true, Value::F32(x)) => Value::F32(*x),
        (ScalarKind::Sint, true, Value::U32(x)) => Value::I32(*x as i32),
        (ScalarKind::Uint, true, Value::F32(x)) => Value::U32(*x as u32),
        (ScalarKind::Uint, true, Value::Bool(x)) => Value::U32((*x).into()),
        (ScalarKind::Float, false, Value::U32(x)) => Value::F32(f32::from_bits(*x)),
        other => panic!("{other:?}"),
    }
}
