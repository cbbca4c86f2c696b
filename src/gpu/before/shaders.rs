//! The shaders for f64 and for light on a device, and what they need beyond [`InF64::lists`].

use super::filter::{Frame, InF64};
use crate::certify::PlaneF64;
use crate::guard::{LIST_F64, UNIT_F64, input_of_picture, steps};
use crate::kernel::certified::PlaneCertified;
use crate::kernel::{Float, Kernel};
use crate::prepare::{ColorWords, Finding, Prepared, ShaderKey};
use crate::rays::Bundle;
use crate::scene::Plane;

/// The shader for the light on hits in f32.
pub fn light_key_in_f32(prepared: &Prepared, words: ColorWords) -> ShaderKey {
    ShaderKey {
        kernel: Kernel::Certified,
        float: Float::F32,
        bundle: prepared.bundle(),
        some: false,
        spheres: match &prepared.hierarchy {
            Some(_) => Finding::Hierarchy,
            None => Finding::Listed,
        },
        n_spheres: prepared.scene.spheres.len().min(1),
        n_planes: prepared.scene.planes.len().min(1),
        surface: false,
        light: Some(words),
        plain_light: None,
    }
}

impl InF64 {
    /// The shader for all rays, or for some pixels that come as a list.
    pub fn shader_key(&self, prepared: &Prepared, some: bool) -> ShaderKey {
        let Frame { bundle, .. } = self.frame;
        let are_all = |is_so: fn(f64) -> bool| {
            bundle == Bundle::Point && self.lists.spheres.iter().all(|sphere| is_so(sphere.q_low))
        };
        ShaderKey {
            kernel: Kernel::Certified,
            float: Float::F64,
            bundle,
            some: some && bundle != Bundle::Free,
            spheres: match &prepared.hierarchy {
                Some(_) => Finding::Hierarchy,
                None if are_all(|q| q > 0.0) => Finding::ListedOutside,
                None if are_all(|q| q < 0.0) => Finding::ListedInside,
                None => Finding::Listed,
            },
            n_spheres: self.lists.spheres.len(),
            n_planes: self.lists.planes.len(),
            surface: false,
            light: None,
            plain_light: None,
        }
    }

    /// The shader for `t` and normals of hits.
    pub fn surface_key(&self, prepared: &Prepared) -> ShaderKey {
        ShaderKey { surface: true, ..self.shader_key(prepared, false) }
    }

    /// The shader for the light on hits. How many objects there are is no part of it.
    pub fn light_key(&self, prepared: &Prepared, words: ColorWords) -> ShaderKey {
        let key = self.shader_key(prepared, false);
        let (n_spheres, n_planes) = (key.n_spheres.min(1), key.n_planes.min(1));
        ShaderKey { light: Some(words), n_spheres, n_planes, ..key }
    }

    /// The words of the planes' exact unit normals, rounded, and whether the plane in the list is turned.
    pub fn units(&self, prepared: &Prepared) -> Vec<[u32; 4]> {
        let unit = |(plane, listed): (&Plane, &PlaneCertified<f64>)| {
            let PlaneF64 { normal, unit_f32, .. } = PlaneF64::new(plane, self.frame.input);
            let [x, y, z] = unit_f32.map(f32::to_bits);
            [x, y, z, u32::from(listed.normal != normal.0)]
        };
        prepared.scene.planes.iter().zip(&self.lists.planes).map(unit).collect()
    }
}

/// The constants of points in `shaders/lit.wgsl`, by their names there. A device's division is in the
/// bounds of `t`, its roots are lengths in bounds, and a plane's unit normal has a bound for a device.
pub fn factors_of_points(bundle: Bundle) -> [(&'static str, f64); 4] {
    let input = input_of_picture(bundle).unwrap_or(LIST_F64);
    [
        ("OF_POINT", input.direction + steps::POINT),
        ("OF_ORIGIN", input.offset + steps::POINT_ORIGIN),
        ("OF_PLANE_NORMAL", steps::NORMALIZED_WIDE),
        ("DIRECTION_ERROR", UNIT_F64 * input.direction),
    ]
}
