//! Opening a device that can show pictures in a window.

use super::adapter::{Pick, adapters_of, choose, instance, no_device};
use super::open::Gpu;
use crate::error::{Error, Result};

/// A device and the surface of a window.
pub(crate) struct OpenWindow {
    pub gpu: Gpu,
    pub surface: wgpu::Surface<'static>,
    /// The surface's abilities with this device.
    pub capabilities: wgpu::SurfaceCapabilities,
}

/// Opens the device that `pick` names among those that can show something in `window`.
///
/// # Errors
/// [`Error::NoAdapter`] when there is none.
pub(crate) fn open_window<W>(pick: &Pick, window: W) -> Result<OpenWindow>
where
    W: wgpu::rwh::HasWindowHandle + wgpu::rwh::HasDisplayHandle + Send + Sync + 'static,
{
    let instance = instance(wgpu::InstanceDescriptor::new_without_display_handle());
    let mut adapters = adapters_of(&instance);
    if adapters.is_empty() {
        // Without a driver there is no surface either, and of that wgpu tells nothing.
        return Err(no_device());
    }
    let surface = instance.create_surface(window).map_err(|error| {
        Error::NoAdapter(format!(
            "Vulkan can't show anything in a window here: {error}; use `kugelblitz render`"
        ))
    })?;
    adapters.retain(|(adapter, _)| adapter.is_surface_supported(&surface));
    if adapters.is_empty() {
        return Err(Error::NoAdapter(
            "no Vulkan device can show pictures in a window here; use `kugelblitz render`".into(),
        ));
    }
    let (adapter, facts) = choose(adapters, pick)?;
    let capabilities = surface.get_capabilities(&adapter);
    let gpu = Gpu::open_adapter(&adapter, facts)?;
    Ok(OpenWindow { gpu, surface, capabilities })
}
