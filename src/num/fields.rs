//! The fields of structs of numbers, by their names and in their order: who prints formulas in another language declares the
//! structs by them, and a device's buffers hold them.

use super::{Real, V3};

/// Gives the fields of a struct, one after the other.
pub trait FieldSource<R: Real> {
    /// A number.
    fn num(&mut self, name: &'static str) -> R;
    /// Three of them.
    fn vec(&mut self, name: &'static str) -> V3<R>;
    /// An id.
    fn id(&mut self, name: &'static str) -> R::Id;
}

/// Takes them.
pub trait FieldSink<R: Real> {
    /// A number.
    fn num(&mut self, name: &'static str, x: R);
    /// Three of them.
    fn vec(&mut self, name: &'static str, v: V3<R>);
    /// An id.
    fn id(&mut self, name: &'static str, id: R::Id);
}

/// A struct of numbers of `R`.
pub trait Fields<R: Real>: Sized {
    /// The struct's name.
    const NAME: &'static str;
    /// One of these fields.
    fn read(source: &mut impl FieldSource<R>) -> Self;
    /// Hands over its fields.
    fn write(&self, sink: &mut impl FieldSink<R>);
}

/// Lists the fields of a struct, each a `num`, a `vec` or an `id`.
macro_rules! fields {
    ($name:ident { $($field:ident: $kind:ident),* $(,)? }) => {
        impl<R: $crate::num::Real> $crate::num::fields::Fields<R> for $name<R> {
            const NAME: &'static str = stringify!($name);

            fn read(source: &mut impl $crate::num::fields::FieldSource<R>) -> Self {
                $name { $($field: source.$kind(stringify!($field)),)* }
            }

            fn write(&self, sink: &mut impl $crate::num::fields::FieldSink<R>) {
                $(sink.$kind(stringify!($field), self.$field);)*
            }
        }
    };
}
pub(crate) use fields;

/// Lists the fields of a struct that has no ids, and lets each number be made into another one.
macro_rules! numbers {
    ($name:ident { $($field:ident: $kind:ident),* $(,)? }) => {
        $crate::num::fields::fields! { $name { $($field: $kind),* } }

        impl<R: Copy> $name<R> {
            /// These numbers, each made into another one.
            #[inline(always)]
            pub fn map<Q>(&self, of: impl Fn(R) -> Q + Copy) -> $name<Q> {
                $name { $($field: $crate::num::fields::numbers!(@each $kind self.$field, of),)* }
            }
        }
    };
    (@each num $x:expr, $of:expr) => { $of($x) };
    (@each vec $x:expr, $of:expr) => { $x.map($of) };
}
pub(crate) use numbers;

/// The words of a struct in a device's buffer: as WGSL has it, three numbers begin at a multiple of four words, and so does
/// what is behind the struct.
pub fn words<const N: usize>(record: &impl Fields<f32>) -> [f32; N] {
    struct Words<const N: usize>([f32; N], usize);

    impl<const N: usize> FieldSink<f32> for Words<N> {
        fn num(&mut self, _: &'static str, x: f32) {
            self.0[self.1] = x;
            self.1 += 1;
        }
        fn vec(&mut self, name: &'static str, v: V3<f32>) {
            self.1 = self.1.next_multiple_of(4);
            v.0.into_iter().for_each(|x| self.num(name, x));
        }
        fn id(&mut self, name: &'static str, id: u32) {
            self.num(name, f32::from_bits(id));
        }
    }

    let mut words = Words([0.0; N], 0);
    record.write(&mut words);
    words.0
}
