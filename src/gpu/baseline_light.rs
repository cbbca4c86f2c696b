//! Shading as kernels without a proof do: the light on what the rays of a picture hit.

use std::sync::Arc;

use super::compile::MOST_TURNS_IN_SOFTWARE;
use super::layout::{self, Layout};
use super::open::Gpu;
use super::pass::Pass;
use super::pipeline::Named;
use super::tiles::DeviceTile;
use crate::error::Result;
use crate::kernel::FloatType;
use crate::prepare::{LightKey, Lighting, Prepared, ShaderKey};
use crate::query::Rays;
use crate::rays::Pixels;
use crate::scene::Scene;
use crate::support::control::Control;

/// Objects times lamps up to which one ray takes less than a second or so.
const MOST_TESTS_OF_RAY: usize = 1 << 24;

/// Whether a device in software has the objects of a scene and so many lamps at hand: then it lights pictures sooner than the
/// CPU.
pub fn are_at_hand(scene: &Scene, n_lamps: usize) -> bool {
    scene.n_objects() <= 24 && n_lamps <= 32
}

/// Lights the pictures of one scene.
pub struct BaselineLight {
    /// The prepared scene, the light and the epsilon that it was made for.
    made_for: (Arc<Prepared>, Lighting, f64),
    /// Bytes of the lamps.
    bytes: u64,
    pass: Pass,
}

impl BaselineLight {
    /// Whether a device lights this. Unless it `lights_all`, that needs lamps and objects at hand: then even a software device is
    /// faster than the CPU.
    pub fn is_wanted(
        gpu: &Gpu,
        prepared: &Prepared,
        lighting: &Lighting,
        lights_all: bool,
    ) -> bool {
        let (n_objects, n_lamps) = (prepared.scene.n_objects(), lighting.lamps.len());
        let n_turns = (n_objects + 1).saturating_mul(n_lamps + 1);
        n_objects.saturating_mul(n_lamps) <= MOST_TESTS_OF_RAY
            && (n_turns <= MOST_TURNS_IN_SOFTWARE || !gpu.facts.is_software())
            && (are_at_hand(&prepared.scene, n_lamps) || lights_all)
    }

    /// Whether this was made for the same prepared scene and such light.
    pub fn is_for(&self, prepared: &Arc<Prepared>, lighting: &Lighting, epsilon: f64) -> bool {
        let (of_prepared, of_lighting, of_epsilon) = &self.made_for;
        Arc::ptr_eq(of_prepared, prepared) && of_lighting == lighting && *of_epsilon == epsilon
    }

    /// Compiles the shader. `objects` are the buffers of the spheres and the planes.
    ///
    /// # Errors
    /// Those of [`Pass::new`].
    pub fn new(
        gpu: &Arc<Gpu>,
        prepared: &Arc<Prepared>,
        objects: &[Named],
        lighting: &Lighting,
        epsilon: f64,
    ) -> Result<BaselineLight> {
        let light = LightKey::Baseline { n_lamps: lighting.lamps.len() };
        let key = ShaderKey { unrolls: gpu.facts.is_software(), ..prepared.light_key(light) };
        let float = prepared.kernel.about().float;
        let of_all = layout::Lighting { ambient: lighting.ambient, epsilon }.bytes(float);
        let lamp = |lamp| layout::Lamp::new(prepared.coordinates(), lamp).bytes(float);
        let lamps = lighting.lamps.iter().flat_map(lamp).collect();
        let of_light = [("lighting", of_all), ("lamps", lamps)];
        let of_light = of_light.into_iter().filter(|(_, bytes)| !bytes.is_empty());
        let of_light: Vec<Named> =
            of_light.map(|(name, bytes)| (name, gpu.filled(name, &bytes).into())).collect();
        let bytes = of_light.iter().map(|(_, light)| light.bytes()).sum();
        let bound = objects.iter().cloned().chain(of_light).collect();
        let pass = Pass::new(gpu, prepared, &key, bound)?;
        let made_for = (Arc::clone(prepared), lighting.clone(), epsilon);
        Ok(BaselineLight { made_for, bytes, pass })
    }

    /// Bytes on the device, beside the objects.
    pub fn bytes(&self) -> u64 {
        self.bytes + self.pass.bytes()
    }

    /// See [`Backend::light_plainly`](crate::tracer::Backend::light_plainly).
    ///
    /// # Errors
    /// Those of [`Pass::run`].
    pub fn light(
        &mut self,
        prepared: &Prepared,
        samples: &Pixels,
        control: &Control,
        lights: &mut Vec<[f64; 3]>,
    ) -> Result<()> {
        let rays = Rays::Pixels(*samples);
        lights.clear();
        lights.reserve(rays.len());
        let float = prepared.kernel.about().float;
        let mut take = |_: &DeviceTile, arrays: &[&[u8]]| match float {
            FloatType::F32 => {
                let found: &[[f32; 3]] = bytemuck::cast_slice(arrays[0]);
                lights.extend(found.iter().map(|light| light.map(f64::from)));
            }
            FloatType::F64 => lights.extend_from_slice(bytemuck::cast_slice(arrays[0])),
        };
        self.pass.run(prepared, &rays, control, &mut take).map(drop)
    }
}
