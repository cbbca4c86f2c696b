//! Brings pictures into the window.

use std::sync::Arc;

use eframe::egui::{ColorImage, PaintCallbackInfo};
use eframe::egui_wgpu::{
    CallbackResources, CallbackTrait, RenderState, ScreenDescriptor, WgpuConfiguration,
    WgpuSetupCreateNew,
};
use eframe::wgpu;
use wgpu::{Adapter, AdapterInfo, DeviceType, Surface};

/// A picture for the window. egui's own shader has branches for all that widgets may want, which a device in software
/// takes one after the other: a frame at 1920 × 1080 was 320 ms of lavapipe's time with it, and is 53.
pub struct Presented {
    /// The colours.
    pub image: Arc<ColorImage>,
    /// Its place among those side by side.
    pub place: usize,
    /// How many these are.
    pub n_places: usize,
}

impl CallbackTrait for Presented {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _: &ScreenDescriptor,
        _: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(presenter) = resources.get_mut::<Presenter>() {
            presenter.taken.truncate(self.n_places);
            presenter.take(device, queue, self);
        }
        Vec::new()
    }

    fn paint(
        &self,
        _: PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &CallbackResources,
    ) {
        let presenter = resources.get::<Presenter>();
        if let Some((presenter, taken)) =
            presenter.and_then(|presenter| Some((presenter, presenter.taken.get(self.place)?)))
        {
            pass.set_pipeline(&presenter.pipeline);
            pass.set_bind_group(0, &taken.bindings, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}

/// What pictures are drawn with.
struct Presenter {
    pipeline: wgpu::RenderPipeline,
    nearest: wgpu::Sampler,
    /// As the window's: what is written is then what was read.
    format: wgpu::TextureFormat,
    taken: Vec<Taken>,
}

/// A picture on the device.
struct Taken {
    image: Arc<ColorImage>,
    texture: wgpu::Texture,
    bindings: wgpu::BindGroup,
}

/// How a window's device is chosen: hardware before software, and the one with this name, which traces, before others.
pub fn options(tracing: Option<String>) -> WgpuConfiguration {
    let choose = move |adapters: &[Adapter], surface: Option<&Surface>| {
        let rank = |adapter: &&Adapter| {
            let AdapterInfo { device_type, name, .. } = adapter.get_info();
            (device_type == DeviceType::Cpu, Some(name) != tracing)
        };
        let presents = |adapter: &&Adapter| {
            surface.is_none_or(|surface| {
                let able = surface.get_capabilities(adapter);
                !able.formats.is_empty() && !able.present_modes.is_empty()
            })
        };
        let mut adapters: Vec<_> = adapters.iter().collect();
        adapters.sort_by_key(rank);
        let names: Vec<_> = adapters.iter().map(|adapter| adapter.get_info().name).collect();
        let chosen = adapters.into_iter().find(presents).cloned();
        chosen.ok_or_else(|| format!("none of {}", names.join(", ")))
    };
    let setup = WgpuSetupCreateNew {
        native_adapter_selector: Some(Arc::new(choose)),
        ..WgpuSetupCreateNew::without_display_handle()
    };
    WgpuConfiguration { wgpu_setup: setup.into(), ..WgpuConfiguration::default() }
}

/// Makes ready for pictures in a window.
pub fn make_ready(window: &RenderState) {
    let (device, target) = (&window.device, window.target_format);
    let shader = device.create_shader_module(wgpu::include_wgsl!("present.wgsl"));
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("picture"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &shader,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[],
        },
        primitive: wgpu::PrimitiveState::default(),
        depth_stencil: None,
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &shader,
            entry_point: None,
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(target.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let nearest = device.create_sampler(&wgpu::SamplerDescriptor::default());
    let format = match target.is_srgb() {
        true => wgpu::TextureFormat::Rgba8UnormSrgb,
        false => wgpu::TextureFormat::Rgba8Unorm,
    };
    let presenter = Presenter { pipeline, nearest, format, taken: Vec::new() };
    window.renderer.write().callback_resources.insert(presenter);
}

impl Presenter {
    /// Brings a picture onto the device, unless it is there.
    fn take(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, presented: &Presented) {
        let Presented { image, place, .. } = presented;
        if self.taken.get(*place).is_none_or(|taken| taken.image.size != image.size) {
            let taken = self.room(device, image);
            self.taken.truncate(*place);
            self.taken.push(taken);
        } else if Arc::ptr_eq(&self.taken[*place].image, image) {
            return;
        }
        let taken = &mut self.taken[*place];
        taken.image = Arc::clone(image);
        let layout = wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(4 * taken.texture.width()),
            rows_per_image: None,
        };
        queue.write_texture(
            taken.texture.as_image_copy(),
            image.as_raw(),
            layout,
            taken.texture.size(),
        );
    }

    fn room(&self, device: &wgpu::Device, image: &Arc<ColorImage>) -> Taken {
        let [width, height] = image.size.map(|n| n as u32);
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let entry = |binding, resource| wgpu::BindGroupEntry { binding, resource };
        let bindings = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("picture"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                entry(0, wgpu::BindingResource::TextureView(&view)),
                entry(1, wgpu::BindingResource::Sampler(&self.nearest)),
            ],
        });
        Taken { image: Arc::clone(image), texture, bindings }
    }
}
