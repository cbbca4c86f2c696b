//! Light of the kernel `certified`: the bytes of pixels whose bounds in f32 tell them.

use std::sync::Arc;

use super::compile::MOST_TURNS_IN_SOFTWARE;
use super::open::Gpu;
use super::pass::Pass;
use super::pipeline::Named;
use super::tiles::DeviceTile;
use crate::control::Control;
use crate::error::Result;
use crate::num::Float as _;
use crate::num::V3;
use crate::num::fields::words;
use crate::prepare::{CertifiedLighting, LightKey, Prepared, ShaderKey};
use crate::rays::Pixels;
use crate::scene::Edges;
use crate::seen::Met;
use crate::trace::Rays;

/// Objects that the rays of a pixel are compared with at most: more take a card so long that it may be taken for dead.
const MOST_TESTS_OF_PIXEL: usize = 1 << 20;

/// Lights the pictures of one scene.
pub struct CertifiedLight {
    key: ShaderKey,
    /// What is bound of the light, with its names.
    uniforms: Vec<(&'static str, Vec<f32>)>,
    pass: Pass,
}

impl CertifiedLight {
    /// Lights with this one where that has the same numbers, else with a new one; `None` where the device leaves that to the
    /// CPU: one in software, which is slower, and where numbers don't fit its uniforms. `objects` are the buffers of the spheres
    /// and the planes.
    ///
    /// # Errors
    /// Those of [`Pass::new`].
    pub fn renewed(
        old: Option<CertifiedLight>,
        gpu: &Arc<Gpu>,
        prepared: &Prepared,
        objects: &[Named],
        lighting: &CertifiedLighting,
    ) -> Result<Option<CertifiedLight>> {
        if prepared.hierarchy.is_some() || prepared.starts_in_f64() || !gpu.lights() {
            return Ok(None);
        }
        let n_samples = (lighting.n_samples as usize).pow(2);
        let most =
            if gpu.facts.is_software() { MOST_TURNS_IN_SOFTWARE } else { MOST_TESTS_OF_PIXEL };
        // To find what a sample sees, where it meets that, and its colour, each takes a turn an object.
        let n_turns =
            3 * prepared.scene.n_objects() + lighting.lamps.len() * (lighting.occluders.len() + 1);
        if n_samples * n_turns > most {
            return Ok(None);
        }
        let uniforms = uniforms(lighting);
        let most = gpu.device.limits().max_uniform_buffer_binding_size;
        let bytes = uniforms.iter().map(|(_, words)| size_of_val(&words[..]) as u64);
        if bytes.chain(objects.iter().map(|(_, object)| object.bytes())).any(|n| n > most) {
            return Ok(None);
        }
        let is_sphere = |(_, met): &&(u32, Met<f32>)| matches!(met, Met::Sphere(_));
        let n_spheres = lighting.occluders.iter().filter(is_sphere).count();
        let light = LightKey::Certified {
            n_samples: lighting.n_samples,
            n_lamps: lighting.lamps.len(),
            n_spheres,
            n_planes: lighting.occluders.len() - n_spheres,
        };
        let key = prepared.light_key(light);
        if let Some(old) = old.filter(|old| old.key == key && old.uniforms == uniforms) {
            return Ok(Some(old));
        }
        let uniform = |(name, words): &(&'static str, Vec<f32>)| -> Named {
            (name, gpu.filled(name, bytemuck::cast_slice(words)).into())
        };
        let bound = objects.iter().cloned().chain(uniforms.iter().map(uniform)).collect();
        let pass = Pass::new(gpu, prepared, &key, bound)?;
        Ok(Some(CertifiedLight { key, uniforms, pass }))
    }

    /// Bytes on the device, beside the objects.
    pub fn bytes(&self) -> u64 {
        let of_light = self.uniforms.iter().map(|(_, words)| size_of_val(&words[..]) as u64);
        of_light.sum::<u64>() + self.pass.bytes()
    }

    /// See [`Tracer::light`](crate::tracer::Tracer::light).
    ///
    /// # Errors
    /// Those of [`Pass::run`].
    pub fn light(
        &mut self,
        prepared: &Prepared,
        pixels: &Pixels,
        control: &Control,
        codes: &mut Vec<u32>,
    ) -> Result<()> {
        codes.clear();
        let mut take = |_: &DeviceTile, arrays: &[&[u8]]| {
            codes.extend_from_slice(bytemuck::cast_slice(arrays[0]))
        };
        let rays = Rays::Pixels(*pixels);
        self.pass.run(prepared, &rays, control, &mut take).map(drop)
    }
}

/// The uniforms of `shaders/lit.wgsl`, in words.
fn uniforms(lighting: &CertifiedLighting) -> Vec<(&'static str, Vec<f32>)> {
    let CertifiedLighting { colors, occluders, lamps, ambient, width, lengths, .. } = lighting;
    let vec4 = |V3([x, y, z]): &V3<f32>, w| [*x, *y, *z, w];
    let id = |id: u32| [f32::from_bits(id), 0.0, 0.0, 0.0];
    let (mut spheres, mut planes) = (Vec::new(), Vec::new());
    for (own, met) in occluders {
        match met {
            Met::Sphere(met) => spheres.extend(words::<8>(met).into_iter().chain(id(*own))),
            Met::Plane(met) => planes.extend(words::<12>(met).into_iter().chain(id(*own))),
        }
    }
    let lamp = |lamp: &crate::prepare::CertifiedLamp| {
        let casts_shadows = if lamp.casts_shadows { 1.0 } else { 0.0 };
        words::<12>(&lamp.aim).into_iter().chain(vec4(&lamp.weight, casts_shadows))
    };
    let ambient = vec4(&ambient.low, 0.0).into_iter().chain(vec4(&ambient.high, 0.0));
    let of_all = words::<8>(lengths).into_iter().chain(ambient).chain(words::<4>(width));
    let all = [
        ("lighting", of_all.collect()),
        ("lamps", lamps.iter().flat_map(lamp).collect()),
        ("colors", colors.iter().flat_map(|color| vec4(color, 0.0)).collect()),
        ("ends", ends()),
        ("met_spheres", spheres),
        ("met_planes", planes),
    ];
    all.into_iter().filter(|(_, words): &(&str, Vec<f32>)| !words.is_empty()).collect()
}

/// Where each byte's range begins and ends, and where the next one does, in linear light: rounded up, as a number of f32 is below
/// an end where it is below that.
fn ends() -> Vec<f32> {
    let edges = Edges::srgb8();
    let begin = |byte: u16| match byte {
        0 => -1.0,
        1..=255 => f32::up(edges.range(byte).0),
        // No light is as bright, but for that of what is open.
        _ => (1u128 << 90) as f32,
    };
    (0..=255).flat_map(|byte| [begin(byte), begin(byte + 1), begin(byte + 2), 0.0]).collect()
}
