//! Light of the kernel `certified`: the bytes of pixels whose bounds in f32 tell them.

use std::sync::Arc;

use super::compile::MOST_TURNS_IN_SOFTWARE;
use super::hierarchy::DeviceHierarchy;
use super::open::Gpu;
use super::pass::Pass;
use super::pipeline::Named;
use super::tiles::DeviceTile;
use crate::bvh::MOST_BOXES_TO_LIGHT;
use crate::error::{Hint, Result, Setting};
use crate::kernel::certified::SphereWords;
use crate::num::Float as _;
use crate::num::V3;
use crate::num::fields::words;
use crate::prepare::{CertifiedLamp, CertifiedLighting, LightKey, Prepared, ShaderKey};
use crate::query::Rays;
use crate::rays::Pixels;
use crate::scene::QuantizationTable;
use crate::shape::{Anchors, Record as _, SphereOccluder};
use crate::support::control::Control;
use crate::support::memory;
use crate::support::parallel;

/// Objects and boxes that the rays of a pixel are compared with at most: more take a card so long that it may be taken for dead.
const MOST_TESTS_OF_PIXEL: usize = 1 << 20;

/// What is bound, in words, with its names.
type LightLists = Vec<(&'static str, Vec<f32>)>;

/// Lights the pictures of one scene.
pub struct CertifiedLight {
    /// The prepared scene that the objects, the tree and the lists of its spheres were made for.
    made_for: Arc<Prepared>,
    key: ShaderKey,
    background: V3<f32>,
    /// What is bound of the light, with its names.
    uniforms: LightLists,
    /// Bytes of what is bound beside the objects and the tree.
    bytes: u64,
    pass: Pass,
    /// What it found last, kept for the next call: fresh memory takes longer than the light of few objects.
    codes: Vec<u32>,
}

impl CertifiedLight {
    /// Returns `old` if it was made for the same prepared scene and has the same numbers, otherwise a new one. Returns `None` if
    /// the device leaves the light to the CPU: if a ray takes too long, or if numbers do not fit its buffers. `objects` are the
    /// buffers of the listed spheres and the planes, `hierarchy` is the tree. Both belong to `prepared`.
    ///
    /// # Errors
    /// Those of [`Pass::new`]; [`Error::TooLarge`](crate::Error::TooLarge) where there is no memory for a tree's spheres.
    pub fn renewed(
        old: Option<CertifiedLight>,
        gpu: &Arc<Gpu>,
        prepared: &Arc<Prepared>,
        (objects, hierarchy): (&[Named], Option<&DeviceHierarchy>),
        lighting: &CertifiedLighting,
    ) -> Result<Option<CertifiedLight>> {
        let most =
            if gpu.facts.is_software() { MOST_TURNS_IN_SOFTWARE } else { MOST_TESTS_OF_PIXEL };
        let n_boxes = hierarchy.map_or(0, |_| MOST_BOXES_TO_LIGHT as usize);
        // To find what a sample sees, where it meets that, and its colour, each takes a turn an object. Of a tree's two loops the
        // outer one turns for each sphere that is found.
        let n_turns = 3 * prepared.n_listed()
            + 2 * n_boxes
            + lighting.lamps.len() * (lighting.occluders.len() + 1 + n_boxes);
        if (lighting.n_samples as usize).pow(2) * (n_turns + 1) > most {
            return Ok(None);
        }
        let mut uniforms = uniforms(lighting);
        if hierarchy.is_none() {
            uniforms.push(("colors", colors(prepared, lighting.background)));
        }
        let most = gpu.device.limits().max_uniform_buffer_binding_size;
        let n_bytes = |(_, words): &(&'static str, Vec<f32>)| size_of_val(&words[..]) as u64;
        let bytes = uniforms.iter().map(n_bytes);
        if bytes.chain(objects.iter().map(|(_, object)| object.bytes())).any(|n| n > most) {
            return Ok(None);
        }
        let (n_samples, n_lamps, mut n_met) = (lighting.n_samples, lighting.lamps.len(), [0; 3]);
        let shapes = lighting.occluders.iter().filter_map(|(_, met)| met.words());
        shapes.for_each(|(shape, _)| n_met[shape] += 1);
        let has_contacts = has_contacts(lighting);
        let light = LightKey::Certified { n_samples, n_lamps, n_met, has_contacts };
        let (mut key, background) = (prepared.light_key(light), lighting.background);
        // With the origins of parallel rays others than those beside the tree count as close.
        key.close |= hierarchy.is_some();
        key.unrolls = gpu.facts.is_software();
        // All else that is bound is made from the prepared scene.
        let is_same = |old: &CertifiedLight| {
            Arc::ptr_eq(&old.made_for, prepared)
                && (&old.key, &old.uniforms, old.background) == (&key, &uniforms, background)
        };
        if let Some(old) = old.filter(is_same) {
            return Ok(Some(old));
        }
        let mut lists = uniforms.clone();
        if hierarchy.is_some() {
            let Some(of_tree) = lists_of_tree(gpu, prepared, lighting)? else {
                return Ok(None);
            };
            lists.extend(of_tree);
        }
        let bytes = lists.iter().map(n_bytes).sum();
        let filled = |(name, words): (&'static str, Vec<f32>)| -> Named {
            (name, gpu.filled(name, bytemuck::cast_slice(&words)).into())
        };
        let tree = hierarchy.into_iter().flatten();
        let bound = objects.iter().chain(tree).cloned().chain(lists.into_iter().map(filled));
        let pass = Pass::new(gpu, prepared, &key, bound.collect())?;
        let (made_for, codes) = (Arc::clone(prepared), Vec::new());
        Ok(Some(CertifiedLight { made_for, key, background, uniforms, bytes, pass, codes }))
    }

    /// Bytes on the device, beside the objects.
    pub fn bytes(&self) -> u64 {
        self.bytes + self.pass.bytes()
    }

    /// See [`Backend::light`](crate::tracer::Backend::light).
    ///
    /// # Errors
    /// Those of [`Pass::run`].
    pub fn light(
        &mut self,
        prepared: &Prepared,
        pixels: &Pixels,
        control: &Control,
    ) -> Result<&[u32]> {
        let codes = &mut self.codes;
        codes.clear();
        let mut take = |_: &DeviceTile, arrays: &[&[u8]]| {
            codes.extend_from_slice(bytemuck::cast_slice(arrays[0]))
        };
        let rays = Rays::Pixels(*pixels);
        self.pass.run(prepared, &rays, control, &mut take)?;
        Ok(codes)
    }
}

fn vec4(V3([x, y, z]): V3<f32>, w: f32) -> [f32; 4] {
    [x, y, z, w]
}

/// The colours of all objects by id, the background's first.
fn colors(prepared: &Prepared, background: V3<f32>) -> Vec<f32> {
    let color = |id| match id {
        0 => vec4(background, 0.0),
        _ => vec4(V3(prepared.scene.color(id as u32).0.map(f32::near)), 0.0),
    };
    parallel::table(prepared.scene.n_objects() + 1, color).into_flattened()
}

const SEEN: usize = size_of::<SphereWords>() / size_of::<f32>();
const ANCHOR: usize = 8;

/// A sphere of a tree and its anchor.
type AnchoredWords = [f32; SEEN + ANCHOR];

/// What a shader binds of the spheres of a tree, by id; `None` where they are too many for that.
fn lists_of_tree(
    gpu: &Gpu,
    prepared: &Prepared,
    lighting: &CertifiedLighting,
) -> Result<Option<LightLists>> {
    let (spheres, facts) = (&prepared.scene.spheres[..], &gpu.facts);
    let Some(picture) = &prepared.picture else { return Ok(None) };
    let most = facts.max_binding_bytes.min(facts.max_buffer_bytes) as usize;
    if size_of::<AnchoredWords>() * spheres.len() > most {
        return Ok(None);
    }
    // As lists, on their way, and on a device in software once more.
    let bytes = size_of::<AnchoredWords>() + size_of::<[f32; 8]>() + size_of::<[f32; 4]>();
    memory::require(
        format!("{} spheres in the light of a device", spheres.len()),
        3 * (bytes * spheres.len()) as u64,
        Hint::new("use fewer spheres, or {}", [Setting::text("device", "cpu")]),
    )?;
    let anchors = Anchors::new(picture);
    let seen = |index: usize| -> AnchoredWords {
        let (seen, anchor) = anchors.of(&spheres[index]);
        let mut all = [0.0; SEEN + ANCHOR];
        all[..SEEN].copy_from_slice(&words::<SEEN>(&seen.round::<f32>()));
        all[SEEN..].copy_from_slice(&words::<ANCHOR>(&anchor.round::<f32>()));
        all
    };
    let met =
        |index: usize| words::<8>(&SphereOccluder::<f32>::new(&spheres[index], prepared.reference));
    let mut lists = vec![
        ("colors", colors(prepared, lighting.background)),
        ("seen_spheres", parallel::table(spheres.len(), seen).into_flattened()),
    ];
    if !lighting.lamps.is_empty() {
        let met = parallel::table(spheres.len(), met).into_flattened();
        lists.push(("met_in_tree", met));
    }
    Ok(Some(lists))
}

fn has_contacts(lighting: &CertifiedLighting) -> bool {
    lighting.lamps.iter().any(|lamp| !lamp.contacts.is_empty())
}

/// The contacts of a lamp: ids, 0 for none, then the sides.
fn contacts(lamp: &CertifiedLamp<f32>) -> Vec<f32> {
    let mut words = vec![0.0; 8];
    for (place, contact) in lamp.contacts_on_device().iter().enumerate() {
        (words[place], words[4 + place]) = (f32::from_bits(contact.id), contact.side as f32);
    }
    words
}

/// The uniforms of `shaders/lit.wgsl`, in words.
fn uniforms(lighting: &CertifiedLighting) -> LightLists {
    let CertifiedLighting { occluders, lamps, ambient, width, lengths, .. } = lighting;
    let has_contacts = has_contacts(lighting);
    let id = |id: u32| [f32::from_bits(id), 0.0, 0.0, 0.0];
    let mut met = [Vec::new(), Vec::new(), Vec::new()];
    for (own, occluder) in occluders {
        let Some((shape, words)) = occluder.words() else { continue };
        met[shape].extend(words.into_iter().chain(id(*own)));
    }
    let [spheres, planes, grounds] = met;
    let lamp = |lamp: &CertifiedLamp<f32>| {
        let casts_shadows = if lamp.casts_shadows { 1.0 } else { 0.0 };
        let light = words::<12>(&lamp.aim).into_iter().chain(vec4(lamp.weight, casts_shadows));
        light.chain(if has_contacts { contacts(lamp) } else { Vec::new() })
    };
    let ambient = vec4(ambient.low, 0.0).into_iter().chain(vec4(ambient.high, 0.0));
    let of_all = words::<8>(lengths).into_iter().chain(ambient).chain(words::<4>(width));
    let all = [
        ("lighting", of_all.collect()),
        ("lamps", lamps.iter().flat_map(lamp).collect()),
        ("ends", ends()),
        ("met_spheres", spheres),
        ("met_planes", planes),
        ("met_grounds", grounds),
    ];
    all.into_iter().filter(|(_, words): &(&str, Vec<f32>)| !words.is_empty()).collect()
}

/// Where each byte's range begins and ends, and where the next one does, in linear light: rounded up, as a number of f32 is below
/// an end where it is below that.
fn ends() -> Vec<f32> {
    let edges = QuantizationTable::srgb8();
    let begin = |byte: u16| match byte {
        0 => -1.0,
        1..=255 => f32::up(edges.range(byte).0),
        // No light is as bright, but for that of what is open.
        _ => (1u128 << 90) as f32,
    };
    (0..=255).flat_map(|byte| [begin(byte), begin(byte + 1), begin(byte + 2), 0.0]).collect()
}
