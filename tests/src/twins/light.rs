//! What `shaders/lit.wgsl` does: each pixel alone, in f32.

use kugelblitz::num::{Float as _, UNDECIDED, V3};
use kugelblitz::prepare::{CertifiedLamp, CertifiedLighting, Prepared};
use kugelblitz::rays::{Frame, Pixels};
use kugelblitz::scene::{Object, QuantizationTable};
use kugelblitz::shape::{
    Anchors, Bounds, Contact, LightBounds, Occlusion, PlaneRecord, Ray, Record as _, ShadowRay,
    ShapeRecord as _, SphereRecord, Surface,
};
use rayon::prelude::*;

use super::Twin;

/// The bytes of pixels in the light of the kernel `certified`, by the formulas of a device: the twin that
/// [`Backend::light`](kugelblitz::tracer::Backend::light) is compared with. On the CPU f32 may decide more.
pub fn light_alone(prepared: &Prepared, lighting: &CertifiedLighting, pixels: &Pixels) -> Vec<u32> {
    let (n, eye) = (lighting.n_samples, &prepared.eye);
    let samples = pixels.samples(n);
    let camera = Frame::<f32>::of_pixels(&samples);
    let twin = Twin::new(prepared).expect("a device finds a way through the scene").lit();
    let anchors = Anchors::new(&samples);
    let surface = |id: u32, ray: &Ray<f32>, steps: [f32; 2]| match prepared.scene.object(id) {
        Some(Object::Sphere(sphere)) if prepared.hierarchy.is_some() => {
            let (seen, anchor) = anchors.of(sphere);
            let (is_close, seen, anchor) = (seen.is_close(), seen.round(), anchor.round());
            let ray = anchor.ray((camera.right, camera.true_up), steps, ray);
            anchor.to_eye(match is_close {
                false => SphereRecord::surface(&seen, &ray, &lighting.lengths),
                true => SphereRecord::surface_close(&seen, &ray, &lighting.lengths),
            })
        }
        Some(Object::Sphere(sphere)) => {
            let seen = SphereRecord::new::<f32>(sphere, eye);
            match seen.is_close() {
                false => SphereRecord::surface(&seen.round(), ray, &lighting.lengths),
                true => SphereRecord::surface_close(&seen.round(), ray, &lighting.lengths),
            }
        }
        Some(Object::Plane(plane)) => {
            let seen = PlaneRecord::new::<f32>(plane, eye).round();
            PlaneRecord::surface(&seen, ray, &lighting.lengths)
        }
        None => Surface::unknown(),
    };
    // The light that a sample gives; `None` where it is left open.
    let sample = |x: u32, y: u32| {
        let (i, j) = samples.offset2(x, y);
        let steps = [i as f32, j as f32];
        let ray = camera.ray(steps[0], steps[1]);
        let id = twin.decide(&ray);
        if id == 0 {
            let color = lighting.background;
            return Some(LightBounds { low: color, high: color });
        }
        if id == UNDECIDED {
            return None;
        }
        let color = V3(prepared.scene.color(id).0.map(f32::near));
        let surface = Some(surface(id, &ray, steps)).filter(Surface::is_known)?;
        let with = |light: LightBounds<f32>, lamp: &CertifiedLamp<f32>| {
            light.with(lamp.weight, given(lamp, lighting, &twin, &surface, id))
        };
        Some(lighting.lamps.iter().fold(lighting.ambient, with).on(color))
    };
    let code = |at: usize| {
        let (x, y) = pixels.xy(at);
        let mut sum = LightBounds { low: V3([0.0; 3]), high: V3([0.0; 3]) };
        for k in 0..n * n {
            let Some(light) = sample(x * n + k % n, y * n + k / n) else { return UNDECIDED };
            sum = sum.plus(light);
        }
        let LightBounds { low, high } = sum.mean((n * n) as f32, lighting.width);
        let mut code = 0;
        for channel in 0..3 {
            let [low, high] = [low, high].map(|bound| f64::from(bound.0[channel]));
            let byte = QuantizationTable::srgb8().number(low);
            let is_known = high < QuantizationTable::srgb8().range(byte).1;
            code |= if is_known { u32::from(byte) << (8 * channel) } else { UNDECIDED };
        }
        code
    };
    (0..pixels.len()).into_par_iter().map(code).collect()
}

/// What a lamp gives to a point of an object.
fn given(
    lamp: &CertifiedLamp<f32>,
    lighting: &CertifiedLighting,
    twin: &Twin,
    surface: &Surface<f32>,
    own: u32,
) -> Bounds<f32> {
    let ray = ShadowRay::new(&lamp.aim, surface.point, surface.point_error);
    // A cosine says nothing where a normal is off by 1.
    let is_known = surface.normal_error < 1.0;
    let normal = V3::select(is_known, surface.normal, V3([0.0; 3]));
    let (low, high) = ray.cosine(normal, surface.normal_error);
    let (mut verdict, contacts) = (Occlusion::none(), lamp.contacts_on_device());
    if lamp.casts_shadows {
        // From inside a sphere it is left open.
        verdict.clear = if surface.front { 1.0 } else { -1.0 };
        for (id, met) in lighting.occluders.iter().filter(|(id, _)| *id != own) {
            verdict = verdict.with(met.occlude(&ray, Contact::side_at(contacts, *id)));
        }
        if high > 0.0 {
            verdict = twin.shadow(verdict, &ray, contacts, own);
        }
    }
    Bounds { low, high }.behind(&verdict)
}
