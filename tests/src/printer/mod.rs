//! The number that prints: a formula that runs with it becomes a function of WGSL.
//!
//! A number is a node of a graph. It knows the place in the source that made it, and has the name that it is given there, by
//! `let` or as a field. Three numbers that are made alike are a vector again. The order of operations stays the formula's, and so
//! does their rounding.

pub mod formulas;
mod names;
mod text;

use std::cell::RefCell;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};
use std::panic::Location;

use kugelblitz::num::fields::{FieldSink, FieldSource, Fields};
use kugelblitz::num::{Mask, Real, V3};

pub use text::{Value, finish};

/// What a node does with its operands.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Op {
    /// A sign between two, and how closely it binds.
    Infix(&'static str, u8),
    Prefix(&'static str),
    Call(&'static str),
    /// A constant or an input.
    Leaf,
}

#[derive(Debug)]
struct Node {
    op: Op,
    operands: Vec<u32>,
    /// The text of a leaf; else empty.
    text: String,
    place: &'static Location<'static>,
}

thread_local! {
    static NODES: RefCell<Vec<Node>> = const { RefCell::new(Vec::new()) };
}

#[track_caller]
fn put(op: Op, operands: &[u32], text: String) -> u32 {
    let node = Node { op, operands: operands.to_vec(), text, place: Location::caller() };
    NODES.with_borrow_mut(|nodes| {
        nodes.push(node);
        nodes.len() as u32 - 1
    })
}

/// What a function takes or gives.
pub trait Printed: Sized {
    /// The type in WGSL.
    fn type_name() -> String;
    /// The one at a path.
    fn input(path: &str) -> Self;
    /// As an expression, from the text of each number in it.
    fn print(&self, text: &mut dyn FnMut(Value) -> String) -> String;
}

macro_rules! expressions {
    ($($(#[$doc:meta])* $name:ident: $type:literal)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug)]
        pub struct $name(u32);

        impl Printed for $name {
            fn type_name() -> String {
                $type.into()
            }
            fn input(path: &str) -> $name {
                $name(put(Op::Leaf, &[], path.into()))
            }
            fn print(&self, text: &mut dyn FnMut(Value) -> String) -> String {
                text(Value::One(self.0))
            }
        }
    )*};
}

expressions! {
    /// An `f32`.
    Wgsl: "f32"
    /// A `bool`.
    WgslMask: "bool"
    /// A `u32`.
    WgslId: "u32"
}

macro_rules! operators {
    ($name:ident: $($trait:ident $function:ident $sign:literal $rank:literal)*) => {$(
        impl $trait for $name {
            type Output = $name;
            #[track_caller]
            fn $function(self, other: $name) -> $name {
                $name(put(Op::Infix($sign, $rank), &[self.0, other.0], String::new()))
            }
        }
    )*};
}

operators! { Wgsl: Add add "+" 3 Sub sub "-" 3 Mul mul "*" 4 Div div "/" 4 }
operators! { WgslMask: BitAnd bitand "&" 1 BitOr bitor "|" 1 }

impl Neg for Wgsl {
    type Output = Wgsl;
    #[track_caller]
    fn neg(self) -> Wgsl {
        Wgsl(put(Op::Prefix("-"), &[self.0], String::new()))
    }
}

macro_rules! methods {
    ($($name:ident($($argument:ident: $type:ty),*) -> $result:ident: $op:expr, $operands:expr;)*) => {$(
        #[track_caller]
        fn $name($($argument: $type),*) -> $result {
            $result(put($op, &$operands, String::new()))
        }
    )*};
}

impl Not for WgslMask {
    type Output = WgslMask;
    #[track_caller]
    fn not(self) -> WgslMask {
        WgslMask(put(Op::Prefix("!"), &[self.0], String::new()))
    }
}

impl Mask for WgslMask {
    fn any(self) -> bool {
        true
    }
}

impl Real for Wgsl {
    type One = f32;
    type Mask = WgslMask;
    type Id = WgslId;

    /// Powers of two far from 1 are printed as such.
    fn splat(x: f32) -> Wgsl {
        assert!(x.is_finite(), "{x}: WGSL has finite numbers alone");
        let exponent = x.abs().log2();
        let is_far = x != 0.0 && exponent == exponent.floor() && exponent.abs() > 20.0;
        let sign = if x < 0.0 { "-" } else { "" };
        Wgsl::input(&if is_far { format!("{sign}0x1p{exponent}f") } else { format!("{x:?}") })
    }
    fn splat_id(id: u32) -> WgslId {
        WgslId::input(&if id > 1 << 16 { format!("{id:#x}u") } else { format!("{id}u") })
    }
    methods! {
        sqrt(self: Self) -> Wgsl: Op::Call("sqrt"), [self.0];
        abs(self: Self) -> Wgsl: Op::Call("abs"), [self.0];
        max(self: Self, other: Self) -> Wgsl: Op::Call("max"), [self.0, other.0];
        min(self: Self, other: Self) -> Wgsl: Op::Call("min"), [self.0, other.0];
        lt(self: Self, other: Self) -> WgslMask: Op::Infix("<", 2), [self.0, other.0];
        le(self: Self, other: Self) -> WgslMask: Op::Infix("<=", 2), [self.0, other.0];
        select(mask: WgslMask, yes: Self, no: Self) -> Wgsl: Op::Call("select"), [no.0, yes.0, mask.0];
        select_id(mask: WgslMask, yes: WgslId, no: WgslId) -> WgslId:
            Op::Call("select"), [no.0, yes.0, mask.0];
    }
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl Printed for V3<Wgsl> {
    fn type_name() -> String {
        "vec3f".into()
    }
    fn input(path: &str) -> V3<Wgsl> {
        V3(AXES.map(|axis| Wgsl::input(&format!("{path}.{axis}"))))
    }
    fn print(&self, text: &mut dyn FnMut(Value) -> String) -> String {
        text(Value::Three(self.0.map(|x| x.0)))
    }
}

/// The struct at a path.
struct At<'a>(&'a str);

impl At<'_> {
    fn field<T: Printed>(&self, name: &str) -> T {
        T::input(&format!("{}.{name}", self.0))
    }
}

impl FieldSource<Wgsl> for At<'_> {
    fn num(&mut self, name: &'static str) -> Wgsl {
        self.field(name)
    }
    fn vec(&mut self, name: &'static str) -> V3<Wgsl> {
        self.field(name)
    }
    fn id(&mut self, name: &'static str) -> WgslId {
        self.field(name)
    }
}

/// The name, the type and the text of each field of a struct.
struct Texts<'a> {
    text: &'a mut dyn FnMut(Value) -> String,
    fields: Vec<[String; 3]>,
}

impl Texts<'_> {
    fn add<T: Printed>(&mut self, name: &str, field: &T) {
        self.fields.push([name.into(), T::type_name(), field.print(self.text)]);
    }
}

impl FieldSink<Wgsl> for Texts<'_> {
    fn num(&mut self, name: &'static str, x: Wgsl) {
        self.add(name, &x);
    }
    fn vec(&mut self, name: &'static str, v: V3<Wgsl>) {
        self.add(name, &v);
    }
    fn id(&mut self, name: &'static str, id: WgslId) {
        self.add(name, &id);
    }
}

fn texts<T: Fields<Wgsl>>(of: &T, text: &mut dyn FnMut(Value) -> String) -> Vec<[String; 3]> {
    let mut texts = Texts { text, fields: Vec::new() };
    of.write(&mut texts);
    texts.fields
}

impl<T: Fields<Wgsl>> Printed for T {
    fn type_name() -> String {
        T::NAME.into()
    }
    fn input(path: &str) -> T {
        T::read(&mut At(path))
    }
    fn print(&self, text: &mut dyn FnMut(Value) -> String) -> String {
        let fields: Vec<String> = texts(self, text).into_iter().map(|[.., text]| text).collect();
        format!("{}({})", T::NAME, fields.join(", "))
    }
}

/// A struct in WGSL.
pub fn declaration<T: Fields<Wgsl>>() -> String {
    let fields = texts(&T::input(""), &mut |_| String::new());
    let lines = fields.into_iter().map(|[name, kind, _]| format!("    {name}: {kind},\n"));
    format!("struct {} {{\n{}}}\n\n", T::NAME, lines.collect::<String>())
}

/// Prints a formula as a function.
macro_rules! function {
    ($name:ident($($argument:ident: $type:ty),*) $body:expr) => {{
        $(let $argument = <$type as $crate::printer::Printed>::input(stringify!($argument));)*
        let result = $body;
        let arguments = [$((
            stringify!($argument),
            <$type as $crate::printer::Printed>::type_name(),
        )),*];
        $crate::printer::finish(stringify!($name), &arguments, &result)
    }};
}
use function;
