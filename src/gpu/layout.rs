//! The structs that shaders have besides the records of objects, each said once: its text in WGSL and its bytes come from here.
//! A test compares where its members lie with where naga has them.

use glam::DVec3;

use crate::kernel::FloatType;
use crate::kernel::coordinates::{Coordinates, split};
use crate::prepare;
use crate::rays::WorldRay;
use crate::scene::Source;

/// A number, three of them, or a whole number. In WGSL a number is a `Real`, which a kernel says what that is.
pub trait Member {
    /// The member's type in WGSL.
    fn wgsl(&self) -> &'static str;
    /// It begins at a multiple of so many bytes.
    fn align(&self, real: FloatType) -> usize;
    /// Appends its bytes.
    fn put(&self, real: FloatType, bytes: &mut Vec<u8>);
}

impl Member for f64 {
    fn wgsl(&self) -> &'static str {
        "Real"
    }
    fn align(&self, real: FloatType) -> usize {
        real.size()
    }
    fn put(&self, real: FloatType, bytes: &mut Vec<u8>) {
        match real {
            FloatType::F32 => bytes.extend_from_slice(&(*self as f32).to_ne_bytes()),
            FloatType::F64 => bytes.extend_from_slice(&self.to_ne_bytes()),
        }
    }
}

impl Member for [f64; 3] {
    fn wgsl(&self) -> &'static str {
        "Vec3"
    }
    fn align(&self, real: FloatType) -> usize {
        4 * self[0].align(real)
    }
    fn put(&self, real: FloatType, bytes: &mut Vec<u8>) {
        self.iter().for_each(|x| x.put(real, bytes));
    }
}

macro_rules! whole_numbers {
    ($($whole:ident)*) => {$(
        impl Member for $whole {
            fn wgsl(&self) -> &'static str {
                stringify!($whole)
            }
            fn align(&self, _: FloatType) -> usize {
                size_of::<$whole>()
            }
            fn put(&self, _: FloatType, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&self.to_ne_bytes());
            }
        }
    )*};
}
whole_numbers! { u32 i32 }

/// A struct that shaders have as well.
pub trait Layout: Default {
    /// The struct's name in WGSL.
    const NAME: &'static str;

    /// Shows its members, in their order.
    fn members(&self, show: &mut dyn FnMut(&'static str, &dyn Member));

    /// The struct in WGSL.
    fn declaration() -> String {
        let mut text = format!("struct {} {{", Self::NAME);
        let mut add = |name: &str, member: &dyn Member| {
            text += &format!(" {name}: {},", member.wgsl());
        };
        Self::default().members(&mut add);
        text + " }\n"
    }

    /// Appends its bytes, and what is left free up to the next one.
    fn put(&self, real: FloatType, bytes: &mut Vec<u8>) {
        let mut largest = 1;
        self.members(&mut |_, member| {
            let align = member.align(real);
            bytes.resize(bytes.len().next_multiple_of(align), 0);
            member.put(real, bytes);
            largest = largest.max(align);
        });
        bytes.resize(bytes.len().next_multiple_of(largest), 0);
    }

    /// The bytes of the struct, with what is left free up to the next one.
    fn bytes(&self, real: FloatType) -> Vec<u8> {
        let mut bytes = Vec::new();
        self.put(real, &mut bytes);
        bytes
    }
}

macro_rules! layouts {
    ($($(#[$doc:meta])* $name:ident { $($(#[$of:meta])* $field:ident: $type:ty,)* })*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default)]
        pub struct $name { $($(#[$of])* pub $field: $type,)* }

        impl Layout for $name {
            const NAME: &'static str = stringify!($name);

            fn members(&self, show: &mut dyn FnMut(&'static str, &dyn Member)) {
                $(show(stringify!($field), &self.$field);)*
            }
        }
    )*};
}

layouts! {
    /// What all rays of a dispatch share.
    Params {
        /// View axis.
        forward: [f64; 3],
        /// Number of spheres.
        n_spheres: u32,
        /// A step to the right of the picture, at distance 1.
        right: [f64; 3],
        /// Number of planes.
        n_planes: u32,
        /// A step to its top.
        true_up: [f64; 3],
        /// Steps of half a pixel; where the kernel is in f32, they are half a pixel.
        step: f64,
        /// The camera's position in the kernel's coordinates.
        origin: [f64; 3],
        /// +∞, which WGSL has no literal for.
        infinity: f64,
        /// Rays of the tile.
        n_rays: u32,
        /// Twice the offset of the tile's first pixel from the picture's centre, right.
        offset_i: i32,
        /// Twice the offset of the tile's first pixel from the picture's centre, up.
        offset_j: i32,
        /// Columns of the tile.
        width: u32,
    }

    /// A ray of a list.
    RayRecord {
        /// The ray's origin in the kernel's coordinates.
        origin: [f64; 3],
        /// What f32 rounds off that.
        origin_low: [f64; 3],
        /// The ray's direction, as [`Coordinates::ray`](crate::kernel::coordinates::Coordinates::ray) has it.
        direction: [f64; 3],
    }

    /// What a walk through the boxes of a tree has to know.
    Traversal {
        /// Boxes of the tree.
        n_boxes: u32,
        /// How far beside the true ray that of the device may lie.
        beside: f64,
    }

    /// The light of kernels without a proof.
    Lighting {
        /// Light from nowhere.
        ambient: [f64; 3],
        /// How far from a surface shadow rays start, world units.
        epsilon: f64,
    }

    /// One of their lights, or a sun of the sky.
    Lamp {
        /// The place of a point in the kernel's coordinates, or the way to a sun.
        at: [f64; 3],
        /// [`Lamp::EYE`], [`Lamp::POINT`] or [`Lamp::SUN`].
        kind: u32,
        /// Linear light that a surface across its rays gets.
        weight: [f64; 3],
        /// 0 where nothing is in its way.
        shadows: u32,
    }
}

impl RayRecord {
    /// A ray of a list.
    pub fn new(coordinates: Coordinates, ray: &WorldRay) -> RayRecord {
        let (origin, direction, _) = coordinates.ray(ray);
        let [origin, origin_low] = match coordinates.kernel.about().float {
            FloatType::F32 => split::<f32>(origin).map(|part| part.map(f64::from)),
            FloatType::F64 => split(origin),
        };
        RayRecord { origin, origin_low, direction: direction.to_array() }
    }
}

impl Lamp {
    /// The kind of the point that all rays start from.
    pub const EYE: u32 = 0;
    /// The kind of a point.
    pub const POINT: u32 = 1;
    /// The kind of a sun.
    pub const SUN: u32 = 2;

    /// A light, or a sun of the sky.
    pub fn new(coordinates: Coordinates, lamp: &prepare::PreparedLight) -> Lamp {
        let (at, kind) = match lamp.origin {
            Source::Eye => (DVec3::ZERO, Lamp::EYE),
            Source::Point(position) => (coordinates.of(position), Lamp::POINT),
            Source::Sun(direction) => (-direction, Lamp::SUN),
        };
        Lamp { at: at.to_array(), kind, weight: lamp.weight, shadows: lamp.shadows.into() }
    }
}

#[cfg(test)]
mod tests {
    use std::mem::{offset_of, size_of};

    use super::*;
    use crate::gpu::compile::compile;
    use crate::kernel::certified::{PlaneWords, SphereWords};
    use crate::kernel::{lecture, relative};
    use crate::num::V3;
    use crate::num::fields::{FieldSource, Fields, words};
    use crate::prepare::{LightKey, ShaderKey};
    use crate::query::Kernel;
    use crate::rays::Lens;
    use crate::shape::{PlaneRecord, SphereLeaf, SphereRecord};

    /// Name, offset and struct size of each member, as naga lays the struct out; arrays' element
    /// strides are the struct's size rounded up to its alignment.
    fn device_layout(kernel: Kernel, lens: Option<Lens>, name: &str) -> (u32, Vec<(String, u32)>) {
        let is_certified = kernel == Kernel::Certified;
        let key = ShaderKey {
            kernel,
            lens,
            tree: is_certified && lens == Some(Lens::Perspective),
            n_spheres: 1,
            close: is_certified,
            n_planes: 1,
            surface: !is_certified,
            light: (!is_certified && lens.is_some()).then_some(LightKey::Baseline { n_lamps: 2 }),
            unrolls: true,
        };
        let shader = compile(&key, None).expect("the shader compiles");
        for (_, ty) in shader.module.types.iter() {
            if let (Some(found), naga::TypeInner::Struct { members, span }) = (&ty.name, &ty.inner)
                && found == name
            {
                let members = members
                    .iter()
                    .map(|m| (m.name.clone().unwrap_or_default(), m.offset))
                    .collect();
                return (*span, members);
            }
        }
        panic!("no struct {name} in the shader");
    }

    macro_rules! check {
        ($kernel:ident, $ty:ty, $name:literal, $($field:ident),+) => {
            let expected = vec![$((stringify!($field).to_string(), offset_of!($ty, $field) as u32)),+];
            let (span, members) = device_layout(Kernel::$kernel, Some(Lens::Perspective), $name);
            assert_eq!(members, expected, "{}", $name);
            assert_eq!(span, size_of::<$ty>() as u32, "{}", $name);
        };
    }

    #[test]
    fn records_of_objects_have_nagas_offsets() {
        use lecture::{PlaneLecture, SphereLecture};
        use relative::{PlaneDouble, PlaneStable, SphereDouble, SphereStable};
        check!(Lecture, SphereLecture, "SphereLecture", center, radius);
        check!(Lecture, PlaneLecture, "PlaneLecture", point, normal);
        check!(Stable, SphereStable, "SphereRelative", center, radius, center_low, k);
        check!(Stable, PlaneStable, "PlaneRelative", offset, n_offset, offset_low, normal);
        check!(Double, SphereDouble, "SphereRelative", center, radius, center_low, k);
        check!(Double, PlaneDouble, "PlaneRelative", offset, n_offset, offset_low, normal);
    }

    #[test]
    #[should_panic(expected = "PlaneLecture")]
    fn a_swapped_member_is_noticed() {
        check!(Lecture, lecture::PlaneLecture, "PlaneLecture", normal, point);
    }

    fn check_layout<T: Layout>(kernel: Kernel, lens: Option<Lens>) {
        let real = kernel.about().float;
        let (mut bytes, mut members) = (Vec::new(), Vec::new());
        T::default().members(&mut |name, member| {
            bytes.resize(bytes.len().next_multiple_of(member.align(real)), 0u8);
            members.push((name.to_string(), bytes.len() as u32));
            member.put(real, &mut bytes);
        });
        let span = T::default().bytes(real).len() as u32;
        assert_eq!(device_layout(kernel, lens, T::NAME), (span, members), "{}", T::NAME);
    }

    #[test]
    fn layouts_are_nagas() {
        for kernel in [Kernel::Stable, Kernel::Double] {
            check_layout::<Params>(kernel, Some(Lens::Perspective));
            check_layout::<RayRecord>(kernel, None);
            check_layout::<Lighting>(kernel, Some(Lens::Perspective));
            check_layout::<Lamp>(kernel, Some(Lens::Perspective));
        }
        check_layout::<Traversal>(Kernel::Certified, Some(Lens::Perspective));
    }

    /// Numbers of other types, at their places.
    #[test]
    fn members_are_written_where_they_lie() {
        let lamp = Lamp { at: [1.0, 2.0, 3.0], kind: 4, weight: [5.0, 6.0, 7.0], shadows: 8 };
        let bytes = lamp.bytes(FloatType::F64);
        let number = |at: usize| f64::from_ne_bytes(bytes[at..at + 8].try_into().unwrap());
        let whole = |at: usize| u32::from_ne_bytes(bytes[at..at + 4].try_into().unwrap());
        assert_eq!([0, 8, 16, 32, 40, 48].map(number), [1.0, 2.0, 3.0, 5.0, 6.0, 7.0]);
        assert_eq!(([24, 56].map(whole), bytes.len()), ([4, 8], 64));
    }

    /// Finds each field of a record in its words.
    struct Places(Vec<(String, u32)>);

    impl FieldSource<f32> for Places {
        fn num(&mut self, name: &'static str) -> f32 {
            self.0.push((name.into(), 0));
            self.0.len() as f32
        }
        fn vec(&mut self, name: &'static str) -> V3<f32> {
            V3([self.num(name), -1.0, -2.0])
        }
        fn id(&mut self, name: &'static str) -> u32 {
            self.num(name).to_bits()
        }
    }

    fn check_words<T: Fields<f32>, const N: usize>() {
        let mut places = Places(Vec::new());
        let words: [f32; N] = words(&T::read(&mut places));
        for (number, (_, offset)) in (1..).zip(&mut places.0) {
            let at = words.iter().position(|&word| word == number as f32);
            *offset = 4 * at.expect("a field in the words") as u32;
        }
        let (span, members) = device_layout(Kernel::Certified, Some(Lens::Perspective), T::NAME);
        assert_eq!((span, members), (4 * N as u32, places.0), "{}", T::NAME);
    }

    #[test]
    fn words_of_records_have_nagas_offsets() {
        check_words::<SphereRecord<f32>, { size_of::<SphereWords>() / 4 }>();
        check_words::<PlaneRecord<f32>, { size_of::<PlaneWords>() / 4 }>();
        check_words::<SphereLeaf<f32>, 8>();
    }
}
