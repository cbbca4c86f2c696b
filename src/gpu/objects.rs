//! The objects of a scene on the device: whether they fit, and their buffers.

use super::open::Gpu;
use super::pipeline::Named;
use super::texture::UPLOAD_BYTES;
use crate::error::{Error, Hint, Message, Result, Setting};
use crate::prepare::{Hierarchy, Prepared};
use crate::support::memory;

/// The names and bytes of the kinds of objects that there are.
pub fn object_bytes<'a>(
    (spheres, planes): (&'a [u8], &'a [u8]),
) -> impl Iterator<Item = (&'static str, &'a [u8])> {
    [("spheres", spheres), ("planes", planes)].into_iter().filter(|(_, bytes)| !bytes.is_empty())
}

/// The spheres and the planes on the device.
pub fn storage(gpu: &Gpu, objects: (&[u8], &[u8])) -> Vec<Named> {
    object_bytes(objects).map(|(name, bytes)| (name, gpu.filled(name, bytes).into())).collect()
}

/// Refuses a scene that the device can't bind, or that this machine has no memory to hand over; a
/// device in software keeps it there too.
///
/// # Errors
/// [`Error::TooLarge`]
pub fn check_limits(gpu: &Gpu, prepared: &Prepared) -> Result<()> {
    let facts = &gpu.facts;
    let limit = facts.max_binding_bytes.min(facts.max_buffer_bytes);
    let (spheres, planes) = prepared.objects.bytes();
    let parts = [
        ("spheres", spheres.len() as u64, prepared.n_listed_spheres()),
        ("planes", planes.len() as u64, prepared.scene.planes.len()),
    ];
    for (what, bytes, count) in parts {
        if bytes > limit {
            let most = limit / (bytes / count as u64);
            let text = format!(
                "the scene needs {} MiB for {count} {what}; `{}` binds at most {} MiB at once",
                bytes >> 20,
                facts.name,
                limit >> 20
            );
            let hint = Hint::new("use {}, or at most ", [Setting::text("device", "cpu")]);
            return Err(Error::TooLarge(Message::new(text, hint.then(format!("{most} {what}")))));
        }
    }
    let objects = (spheres.len() + planes.len()) as u64;
    let hierarchy = prepared.hierarchy.as_ref().map_or(0, Hierarchy::bytes);
    let on_their_way = objects + hierarchy.min(UPLOAD_BYTES as u64);
    let kept = if facts.is_software() { objects + hierarchy } else { 0 };
    let what = format!("handing the scene to `{}`", facts.name);
    let hint = Hint::new("use fewer objects, or {}", [Setting::text("device", "cpu")]);
    memory::require(what, on_their_way + kept, hint)
}
