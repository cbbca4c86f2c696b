//! A scene and its kernel on a device.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::baseline_light::BaselineLight;
use super::compile::MOST_TURNS_IN_SOFTWARE;
use super::hierarchy::{DeviceHierarchy, upload_hierarchy};
use super::light::CertifiedLight;
use super::objects::{check_limits, object_bytes, storage};
use super::open::Gpu;
use super::pass::Pass;
use super::pipeline::{Named, Resource};
use super::tiles::DeviceTile;
use crate::error::{Error, Result};
use crate::kernel::Kernel;
use crate::kernel::coordinates::Coordinates;
use crate::prepare::{CertifiedLighting, Lighting, Prepared, ShaderKey};
use crate::query::{Hits, Outputs, Rays, Timing};
use crate::rays::Pixels;
use crate::support::control::Control;
use crate::tracer::Backend;

/// Ways to lamps that the CPU looks along while it makes the numbers of a tree's sphere for light on a device. No bound.
const WAYS_OF_SPHERE: usize = 4;

/// Traces on a Vulkan device.
pub struct GpuTracer {
    gpu: Arc<Gpu>,
    prepared: Arc<Prepared>,
    wants: Outputs,
    key: ShaderKey,
    /// None before it is needed.
    pass: Option<Pass>,
    /// The spheres and the planes.
    objects: Vec<Named>,
    hierarchy: Option<DeviceHierarchy>,
    /// Whether the device can't take the kernel's stage: its arithmetic doesn't suit the proof of `certified`, there
    /// is no way to the rays' many spheres, or it would stop on the way through a long list of them.
    leaves_to_cpu: bool,
    /// See [`Backend::force_light`].
    is_light_forced: bool,
    /// Lights what rays of a kernel without a proof hit, made when that is first needed.
    baseline_light: Option<BaselineLight>,
    /// Lights what rays of `certified` hit, made when that is first needed.
    light: Option<CertifiedLight>,
    /// Time to put together and compile the shader.
    pub compile_time: Duration,
    /// Time to hand the scene to the device.
    pub upload_time: Duration,
}

impl GpuTracer {
    /// Compiles the shader that the scene needs and uploads the scene.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when the scene exceeds the device's limits, [`Error::Device`] when the
    /// device fails, [`Error::Shader`] when it refuses the shader, [`Error::NoAdapter`] when the
    /// kernel needs more than the adapter has.
    pub fn new(gpu: Arc<Gpu>, prepared: Arc<Prepared>, wants: Outputs) -> Result<GpuTracer> {
        gpu.facts.check_kernel(prepared.kernel)?;
        check_limits(&gpu, &prepared)?;
        let start = Instant::now();
        let objects = storage(&gpu, prepared.objects.bytes());
        let hierarchy = upload_hierarchy(&gpu, &prepared)?;
        let upload_time = start.elapsed();
        gpu.check()?;
        let leaves_to_cpu = leaves_to_cpu(&gpu, &prepared, hierarchy.as_ref())?;
        let mut tracer = GpuTracer {
            key: prepared.shader_key(wants),
            gpu,
            prepared,
            wants,
            pass: None,
            objects,
            hierarchy,
            leaves_to_cpu,
            is_light_forced: false,
            baseline_light: None,
            light: None,
            compile_time: Duration::ZERO,
            upload_time,
        };
        let start = Instant::now();
        // Where nothing is proposed, no shader is needed.
        if !(tracer.prepared.starts_in_f64() || leaves_to_cpu) {
            tracer.pass = Some(tracer.make_pass()?);
        }
        tracer.compile_time = start.elapsed();
        Ok(tracer)
    }

    fn make_pass(&self) -> Result<Pass> {
        Pass::new(
            &self.gpu,
            &self.prepared,
            &self.key,
            bound(&self.objects, self.hierarchy.as_ref()),
        )
    }
}

/// What a shader binds of a scene.
fn bound(objects: &[Named], hierarchy: Option<&DeviceHierarchy>) -> Vec<Named> {
    objects.iter().chain(hierarchy.into_iter().flatten()).cloned().collect()
}

fn leaves_to_cpu(
    gpu: &Gpu,
    prepared: &Prepared,
    hierarchy: Option<&DeviceHierarchy>,
) -> Result<bool> {
    let has_no_way = prepared.hierarchy.is_some() && hierarchy.is_none();
    let is_stopped = gpu.facts.is_software() && prepared.n_listed() > MOST_TURNS_IN_SOFTWARE;
    Ok(is_stopped
        || prepared.kernel == Kernel::Certified
            && (has_no_way || !gpu.arithmetic()?.suits_filter()))
}

/// Puts the results of a tile into their places; of a list's rays `t` is that of [`Coordinates::ray`].
fn store(
    coordinates: Coordinates,
    rays: &Rays,
    tile: &DeviceTile,
    arrays: &[&[u8]],
    hits: &mut Hits,
) {
    let place = tile.first..tile.first + tile.n_rays;
    hits.id[place.clone()].copy_from_slice(bytemuck::cast_slice(arrays[0]));
    let [_, t, normal] = arrays else { return };
    hits.t[place.clone()].copy_from_slice(bytemuck::cast_slice(t));
    hits.normal[place.clone()].copy_from_slice(bytemuck::cast_slice(normal));
    if let Rays::List(rays) = rays {
        for (t, ray) in hits.t[place.clone()].iter_mut().zip(&rays[place]) {
            let (_, _, exponent) = coordinates.ray(ray);
            *t = (f64::from(*t) * 2f64.powi(-exponent)) as f32;
        }
    }
}

impl Backend for GpuTracer {
    fn propose(
        &mut self,
        rays: &Rays,
        control: &Control,
        hits: &mut Hits,
    ) -> Result<Option<Timing>> {
        if self.leaves_to_cpu {
            return Ok(None);
        }
        hits.make_room(rays.len(), self.wants)?;
        let coordinates = self.prepared.coordinates();
        let mut take = |tile: &DeviceTile, arrays: &[&[u8]]| {
            store(coordinates, rays, tile, arrays, hits);
            control.advance(tile.n_rays as u64);
        };
        let pass = match self.pass.take() {
            Some(pass) => pass,
            None => self.make_pass()?,
        };
        self.pass.insert(pass).run(&self.prepared, rays, control, &mut take).map(Some)
    }

    fn light_plainly(
        &mut self,
        lighting: &Lighting,
        epsilon: f64,
        samples: &Pixels,
        control: &Control,
        lights: &mut Vec<[f64; 3]>,
    ) -> Result<bool> {
        let lights_all = self.is_light_forced || self.gpu.lights(true);
        let GpuTracer { gpu, prepared, objects, baseline_light: kept, leaves_to_cpu, .. } = self;
        if *leaves_to_cpu || !BaselineLight::is_wanted(gpu, prepared, lighting, lights_all) {
            return Ok(false);
        }
        let made = match kept.take().filter(|made| made.is_for(prepared, lighting, epsilon)) {
            Some(made) => made,
            None => match BaselineLight::new(gpu, prepared, objects, lighting, epsilon) {
                // The device binds too few buffers at once, or has too little room.
                Err(Error::TooLarge(_)) => return Ok(false),
                made => made?,
            },
        };
        kept.insert(made).light(prepared, samples, control, lights)?;
        Ok(true)
    }

    fn light(
        &mut self,
        lighting: &CertifiedLighting,
        pixels: &Pixels,
        control: &Control,
    ) -> Result<Option<&[u32]>> {
        let GpuTracer { gpu, prepared, objects, hierarchy, light: kept, leaves_to_cpu, .. } = self;
        let n_ways = pixels.len() * (lighting.n_samples as usize).pow(2) * lighting.lamps.len();
        let n_spheres = hierarchy.as_ref().map_or(0, |_| prepared.scene.spheres.len());
        let is_quicker = n_ways >= WAYS_OF_SPHERE * n_spheres;
        let is_wanted = self.is_light_forced || gpu.lights(is_quicker);
        if prepared.starts_in_f64() || *leaves_to_cpu || !is_wanted {
            return Ok(None);
        }
        let objects = (&objects[..], hierarchy.as_ref());
        let made = CertifiedLight::renewed(kept.take(), gpu, prepared, objects, lighting);
        let lit = made.and_then(|made| {
            *kept = made;
            kept.as_mut().map(|light| light.light(prepared, pixels, control)).transpose()
        });
        match lit {
            // The device binds too few buffers at once, or has too little room.
            Err(Error::TooLarge(_)) => Ok(None),
            lit => lit,
        }
    }

    /// All that may fail comes first, so that a tracer that can't be retargeted stays what it was. A moved camera
    /// costs no new shader.
    fn retarget(&mut self, prepared: &Arc<Prepared>) -> Result<()> {
        self.gpu.facts.check_kernel(prepared.kernel)?;
        if prepared.shader_key(self.wants) != self.key {
            let new = GpuTracer::new(Arc::clone(&self.gpu), Arc::clone(prepared), self.wants)?;
            let is_light_forced = self.is_light_forced;
            *self = GpuTracer { is_light_forced, ..new };
            return Ok(());
        }
        check_limits(&self.gpu, prepared)?;
        let hierarchy = upload_hierarchy(&self.gpu, prepared)?;
        let leaves_to_cpu = leaves_to_cpu(&self.gpu, prepared, hierarchy.as_ref())?;
        self.gpu.check()?;
        let bytes = object_bytes(prepared.objects.bytes());
        for ((_, resource), (_, bytes)) in self.objects.iter().zip(bytes) {
            if let Resource::Buffer(buffer) = resource {
                self.gpu.queue.write_buffer(buffer, 0, bytes);
            }
        }
        if let Some(pass) = self.pass.as_mut().filter(|_| hierarchy.is_some()) {
            pass.bind(bound(&self.objects, hierarchy.as_ref()));
        }
        (self.baseline_light, self.light) = (None, None);
        (self.hierarchy, self.leaves_to_cpu) = (hierarchy, leaves_to_cpu);
        self.prepared = Arc::clone(prepared);
        Ok(())
    }

    fn bytes(&self) -> u64 {
        let bound = bound(&self.objects, self.hierarchy.as_ref());
        bound.iter().map(|(_, resource)| resource.bytes()).sum::<u64>()
            + self.pass.as_ref().map_or(0, Pass::bytes)
            + self.baseline_light.as_ref().map_or(0, BaselineLight::bytes)
            + self.light.as_ref().map_or(0, CertifiedLight::bytes)
    }

    fn force_light(&mut self) {
        self.is_light_forced = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Arithmetic;
    use crate::lighting::certified_lighting;
    use crate::prepare::FEW_SPHERES;
    use crate::rays::{Pixels, View};
    use crate::scene::{Camera, Color, Light, Projection, Samples, Scene, Source, Sphere};
    use crate::tracer::Tracer;
    use glam::DVec3;

    fn row_of_spheres(n: usize) -> Arc<Scene> {
        let sphere = |i| Sphere {
            center: DVec3::new(i as f64 - n as f64 / 2.0, 0.0, -(n as f64)),
            radius: 0.4,
        };
        Arc::new(Scene { spheres: Vec::from_iter((0..n).map(sphere)).into(), ..Scene::default() })
    }

    /// A picture of `n` spheres in a row.
    fn picture_of_spheres(n: usize) -> (Rays, Arc<Prepared>) {
        let camera = Camera {
            position: DVec3::ZERO,
            look_at: DVec3::NEG_Z,
            up: DVec3::Y,
            projection: Projection::Perspective { fov_degrees: 60.0 },
        };
        let rays = Rays::Pixels(Pixels::whole(View::new(&camera), 80, 60));
        let prepared = Prepared::new(row_of_spheres(n), Kernel::Certified, &rays).unwrap();
        (rays, Arc::new(prepared))
    }

    fn light_at_the_eye() -> Light {
        Light { source: Source::Eye, color: Color([1.0; 3]), intensity: 1.0, shadows: true }
    }

    fn open() -> Gpu {
        Gpu::open("").expect("a Vulkan device; ci/setup.sh installs one")
    }

    fn hits_of(gpu: Gpu, is_suited: bool, rays: &Rays, prepared: &Arc<Prepared>) -> Hits {
        let wants = Outputs::default();
        let backend = GpuTracer::new(Arc::new(gpu), Arc::clone(prepared), wants).unwrap();
        assert_eq!(backend.leaves_to_cpu, !is_suited);
        traced(&mut Tracer::on(backend, Arc::clone(prepared), wants), rays)
    }

    /// No device here orders sums anew, so one is told that it does.
    #[test]
    fn the_cpu_takes_over_from_arithmetic_that_does_not_suit_the_proof() {
        for n in [FEW_SPHERES, 2 * FEW_SPHERES] {
            let (rays, prepared) = picture_of_spheres(n);
            let trace = |is_suited: bool| {
                let gpu = open();
                let found = gpu.arithmetic().unwrap();
                assert!(found.suits_filter());
                let told = gpu.tell_arithmetic(Arithmetic { no_contraction: is_suited, ..found });
                hits_of(told, is_suited, &rays, &prepared)
            };
            let (on_device, on_cpu) = (trace(true), trace(false));
            assert_eq!(on_device.id, on_cpu.id);
            assert!(on_cpu.n_hits() > 40);
        }
    }

    /// Where shaders can't be passed through, nothing forbids the driver to rearrange them. No
    /// adapter here is so, and one is told that it is.
    #[test]
    fn the_cpu_takes_over_without_passthrough() {
        let (rays, prepared) = picture_of_spheres(FEW_SPHERES);
        let [with, without] = [true, false].map(|passthrough| {
            let mut gpu = open();
            gpu.facts.passthrough = passthrough;
            let arithmetic = gpu.arithmetic().unwrap();
            assert_eq!(arithmetic.passthrough, passthrough);
            assert_eq!(arithmetic.suits_filter(), passthrough, "{arithmetic}");
            assert!(passthrough || !arithmetic.is_ieee());
            hits_of(gpu, passthrough, &rays, &prepared)
        });
        assert_eq!(with.id, without.id);
    }

    /// A ball before a plane, and what is seen of them with `t` and normals.
    fn ball_and_plane(n_balls: usize) -> (Rays, Arc<Prepared>) {
        let balls = "{ center = [0, 0, -4], radius = 1, color = \"#d62728\" }, ".repeat(n_balls);
        let text = format!(
            "camera = {{ position = [0, 1, 0], look_at = [0, 0, -4] }}\nsphere = [{balls}]\n\
             plane = [{{ point = [0, -1, 0], normal = [0, 1, 0], color = \"#8c8c8c\" }}]\n"
        );
        let scene = crate::scene::parse_scene(&text, "ball.toml".as_ref()).unwrap();
        let rays = Rays::Pixels(Pixels::whole(View::new(scene.camera.as_ref().unwrap()), 40, 30));
        let prepared = Prepared::new(Arc::new(scene), Kernel::Certified, &rays).unwrap();
        (rays, Arc::new(prepared))
    }

    fn traced(tracer: &mut Tracer, rays: &Rays) -> Hits {
        let mut hits = Hits::default();
        tracer.trace(rays, &Control::default(), &mut hits).unwrap();
        hits
    }

    /// A light that [`Backend::retarget`] would leave behind is made anew.
    #[test]
    fn light_is_that_of_the_prepared_scene() {
        let (_, first) = picture_of_spheres(2 * FEW_SPHERES);
        let (rays, _) = picture_of_spheres(1);
        let Rays::Pixels(pixels) = rays else { panic!("a picture") };
        let of = |kernel, scene: &Scene| {
            Arc::new(Prepared::new(Arc::new(scene.clone()), kernel, &rays).unwrap())
        };
        let mut lit = (*first.scene).clone();
        lit.lights = vec![light_at_the_eye()];
        let mut other = lit.clone();
        let spheres = lit.spheres.iter().map(|sphere| (*sphere, Color([0.2, 0.4, 0.6])));
        other.spheres = spheres.collect();
        let new = |prepared: &Arc<Prepared>| {
            let gpu = Arc::new(open());
            let mut tracer = GpuTracer::new(gpu, Arc::clone(prepared), Outputs::default()).unwrap();
            tracer.force_light();
            tracer
        };
        let codes = |tracer: &mut GpuTracer| {
            let lighting = certified_lighting(&tracer.prepared, &pixels, Samples::ONE).unwrap();
            let codes = tracer.light(&lighting, &pixels, &Control::default()).unwrap();
            codes.expect("light on the device").to_vec()
        };
        let [lit, other] = [&lit, &other].map(|scene| of(Kernel::Certified, scene));
        let mut tracer = new(&lit);
        let before = codes(&mut tracer);
        let left = tracer.light.take();
        tracer.retarget(&other).unwrap();
        tracer.light = left;
        let after = codes(&mut tracer);
        assert_ne!(after, before);
        assert_eq!(after, codes(&mut new(&other)));
    }

    /// The name of a buffer tells what it is, not its place; a wrong name is seen.
    #[test]
    fn buffers_of_one_kind_cannot_be_swapped() {
        let (rays, prepared) = ball_and_plane(1);
        let wants = Outputs { surface: true, level: false };
        let mut tracer = GpuTracer::new(Arc::new(open()), Arc::clone(&prepared), wants).unwrap();
        let mut propose = |objects: fn(&mut Vec<Named>)| {
            objects(&mut tracer.objects);
            let bound = bound(&tracer.objects, None);
            tracer.pass.as_mut().unwrap().bind(bound);
            let mut hits = Hits::default();
            tracer.propose(&rays, &Control::default(), &mut hits).map(|_| hits.id)
        };
        let expected = propose(|_| {}).unwrap();
        assert!([0, 1, 2].iter().all(|id| expected.contains(id)));
        assert_eq!(propose(|objects| objects.reverse()).unwrap(), expected);
        let swapped = propose(|objects| {
            let [(a, _), (b, _)] = objects.as_mut_slice() else { panic!("spheres and planes") };
            std::mem::swap(a, b);
        });
        assert_ne!(swapped.unwrap(), expected);
        let missing = propose(|objects| objects.truncate(1)).unwrap_err();
        assert!(matches!(missing, Error::Shader(_)), "{missing}");
    }

    /// The shader is refused for the second scene, after all else is made.
    #[test]
    fn a_tracer_that_cannot_be_retargeted_stays_what_it_was() {
        use std::sync::atomic::{AtomicBool, Ordering};
        let is_refused = Arc::new(AtomicBool::new(false));
        let refused = Arc::clone(&is_refused);
        let gpu = open().edit_shaders(move |wgsl| match refused.load(Ordering::Relaxed) {
            true => "no shader".into(),
            false => wgsl.into(),
        });
        let (rays, prepared) = ball_and_plane(1);
        let wants = Outputs { surface: true, level: false };
        let backend = GpuTracer::new(Arc::new(gpu), Arc::clone(&prepared), wants).unwrap();
        let mut tracer = Tracer::on(backend, prepared, wants);
        let expected = traced(&mut tracer, &rays);
        is_refused.store(true, Ordering::Relaxed);
        let (others, other) = ball_and_plane(3);
        let error = tracer.retarget(Arc::clone(&other)).unwrap_err();
        assert!(matches!(error, Error::Shader(_)), "{error}");
        assert!(traced(&mut tracer, &rays) == expected);
        is_refused.store(false, Ordering::Relaxed);
        tracer.retarget(other).unwrap();
        // The plane comes behind all balls.
        let ids = expected.id.iter().map(|&id| if id == 2 { 4 } else { id });
        assert!(traced(&mut tracer, &others).id.into_iter().eq(ids));
    }
}
