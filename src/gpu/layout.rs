//! The structs that the device sees besides the kernels' records. A test checks their offsets against
//! naga's.

use bytemuck::{Pod, Zeroable};

/// Twin of `Params` in `shaders/render.wgsl`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Params {
    /// View axis.
    pub forward: [f32; 3],
    /// Number of spheres.
    pub n_spheres: u32,
    /// Half a pixel to the right, at distance 1.
    pub right_step: [f32; 3],
    /// Number of planes.
    pub n_planes: u32,
    /// Half a pixel to the top at distance 1.
    pub true_up_step: [f32; 3],
    /// +∞, which WGSL has no literal for.
    pub infinity: f32,
    /// The camera's position for `lecture`, world units; zero otherwise.
    pub origin: [f32; 3],
    /// Rays of the tile.
    pub n_rays: u32,
    /// Twice the offset of the tile's first pixel from the picture's centre, right.
    pub offset_i: i32,
    /// The same, up.
    pub offset_j: i32,
    /// Columns of the tile.
    pub width: u32,
    /// Fills WGSL's 16-byte alignment of the struct.
    pub padding: u32,
}

/// Twin of `Params` in `shaders/render.wgsl` for the kernel `double`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct ParamsDouble {
    /// View axis.
    pub forward: [f64; 3],
    /// Number of spheres.
    pub n_spheres: u32,
    /// Number of planes.
    pub n_planes: u32,
    /// To the right.
    pub right: [f64; 3],
    /// Half a pixel at distance 1.
    pub step: f64,
    /// To the top.
    pub true_up: [f64; 3],
    /// +∞, which WGSL has no literal for.
    pub infinity: f64,
    /// The camera's position relative to the reference point.
    pub origin: [f64; 3],
    /// Rays of the tile.
    pub n_rays: u32,
    /// Twice the offset of the tile's first pixel from the picture's centre, right.
    pub offset_i: i32,
    /// The same, up.
    pub offset_j: i32,
    /// Columns of the tile.
    pub width: u32,
    /// Fills WGSL's 32-byte alignment of the struct.
    pub padding: [u32; 6],
}

/// Twin of `Walk` in `shaders/tree.wgsl`.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct Walk {
    /// Boxes of the tree.
    pub n_boxes: u32,
    /// How far beside the true ray that of the device may lie.
    pub beside: f32,
    /// Fills 16 bytes.
    pub padding: [u32; 2],
}

#[cfg(test)]
mod tests {
    use std::mem::{offset_of, size_of};

    use super::*;
    use crate::gpu::compile::compile;
    use crate::gpu::plain_light::{LampF32, LampF64, LightingF32, LightingF64};
    use crate::kernel::certified::{PlaneWords, SphereWords};
    use crate::kernel::coordinates::{RayRecord, RayRecordDouble};
    use crate::kernel::{lecture, relative};
    use crate::num::V3;
    use crate::num::fields::{Fields, Source, words};
    use crate::prepare::{Finding, LightKey, ShaderKey};
    use crate::rays::Bundle;
    use crate::seen::{PlaneSeen, SphereLeaf, SphereSeen};
    use crate::trace::Kernel;

    /// Name, offset and struct size of each member, as naga lays the struct out; arrays' element
    /// strides are the struct's size rounded up to its alignment.
    fn device_layout(kernel: Kernel, bundle: Bundle, name: &str) -> (u32, Vec<(String, u32)>) {
        let is_certified = kernel == Kernel::Certified;
        let key = ShaderKey {
            kernel,
            bundle,
            spheres: match is_certified && bundle == Bundle::Point {
                true => Finding::Tree,
                false => Finding::Listed,
            },
            n_spheres: 1,
            close: is_certified,
            n_planes: 1,
            surface: !is_certified,
            light: (!is_certified && bundle != Bundle::Free)
                .then_some(LightKey::Plain { n_lamps: 2 }),
        };
        let shader = compile(&key).expect("the shader compiles");
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
        ($kernel:ident, $bundle:ident, $ty:ty, $name:literal, $($field:ident),+) => {
            let expected = vec![$((stringify!($field).to_string(), offset_of!($ty, $field) as u32)),+];
            let (span, members) = device_layout(Kernel::$kernel, Bundle::$bundle, $name);
            assert_eq!(members, expected, "{}", $name);
            assert_eq!(span, size_of::<$ty>() as u32, "{}", $name);
        };
    }

    #[test]
    fn device_structs_have_nagas_offsets() {
        check!(
            Stable,
            Point,
            Params,
            "Params",
            forward,
            n_spheres,
            right_step,
            n_planes,
            true_up_step,
            infinity,
            origin,
            n_rays,
            offset_i,
            offset_j,
            width,
            padding
        );
        check!(Lecture, Point, lecture::SphereLecture, "SphereLecture", center, radius);
        check!(Lecture, Point, lecture::PlaneLecture, "PlaneLecture", point, normal);
        check!(
            Stable,
            Point,
            relative::SphereStable,
            "SphereRelative",
            center,
            radius,
            center_low,
            k
        );
        check!(
            Stable,
            Point,
            relative::PlaneStable,
            "PlaneRelative",
            offset,
            n_offset,
            offset_low,
            normal
        );
        check!(
            Double,
            Point,
            ParamsDouble,
            "Params",
            forward,
            n_spheres,
            n_planes,
            right,
            step,
            true_up,
            infinity,
            origin,
            n_rays,
            offset_i,
            offset_j,
            width
        );
        check!(
            Double,
            Point,
            relative::SphereDouble,
            "SphereRelative",
            center,
            radius,
            center_low,
            k
        );
        check!(
            Double,
            Point,
            relative::PlaneDouble,
            "PlaneRelative",
            offset,
            n_offset,
            offset_low,
            normal
        );
        check!(Double, Free, RayRecordDouble, "RayRecord", origin, direction);
        check!(Stable, Point, LightingF32, "Lighting", ambient, epsilon);
        check!(Double, Point, LightingF64, "Lighting", ambient, epsilon);
        check!(Stable, Point, LampF32, "Lamp", at, kind, weight, shadows);
        check!(Double, Point, LampF64, "Lamp", at, kind, weight, shadows);
        check!(Stable, Free, RayRecord, "RayRecord", origin, origin_low, direction);
        check!(Certified, Point, Walk, "Walk", n_boxes, beside, padding);
    }

    /// Finds each field of a record in its words.
    struct Places(Vec<(String, u32)>);

    impl Source<f32> for Places {
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
        let (span, members) = device_layout(Kernel::Certified, Bundle::Point, T::NAME);
        assert_eq!((span, members), (4 * N as u32, places.0), "{}", T::NAME);
    }

    #[test]
    fn words_of_records_have_nagas_offsets() {
        check_words::<SphereSeen<f32>, { size_of::<SphereWords>() / 4 }>();
        check_words::<PlaneSeen<f32>, { size_of::<PlaneWords>() / 4 }>();
        check_words::<SphereLeaf<f32>, 8>();
    }

    #[test]
    #[should_panic(expected = "Params")]
    fn a_swapped_member_is_noticed() {
        check!(
            Stable,
            Point,
            Params,
            "Params",
            forward,
            n_spheres,
            right_step,
            n_planes,
            true_up_step,
            infinity,
            origin,
            n_rays,
            offset_j,
            offset_i,
            width,
            padding
        );
    }
}
