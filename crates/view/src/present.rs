//! Brings pictures into the window.

use std::sync::{Arc, OnceLock};

use eframe::egui::PaintCallbackInfo;
use eframe::egui_wgpu::{CallbackResources, CallbackTrait, RenderState, ScreenDescriptor};
use eframe::wgpu;
use wgpu::util::DeviceExt;

/// Colours for the window.
#[derive(Clone)]
pub struct WindowImage {
    /// Columns and rows.
    size: [u32; 2],
    /// Red, green, blue, and 255.
    colors: Vec<[u8; 4]>,
    /// The colours on the window's device.
    taken: OnceLock<wgpu::BindGroup>,
}

impl WindowImage {
    /// With this many columns and rows.
    pub fn new(size: [u32; 2], colors: impl Iterator<Item = [u8; 3]>) -> Arc<WindowImage> {
        let colors = colors.map(opaque).collect();
        Arc::new(WindowImage { size, colors, taken: OnceLock::new() })
    }

    /// Gives the pixels from this one on other colours.
    pub fn change(image: &mut Arc<WindowImage>, first: usize, colors: Vec<[u8; 3]>) {
        let image = Arc::make_mut(image);
        image.taken.take();
        for (pixel, color) in image.colors[first..].iter_mut().zip(colors) {
            *pixel = opaque(color);
        }
    }
}

#[cfg(test)]
impl PartialEq<[[u8; 3]]> for WindowImage {
    fn eq(&self, colors: &[[u8; 3]]) -> bool {
        self.colors.iter().copied().eq(colors.iter().copied().map(opaque))
    }
}

fn opaque([r, g, b]: [u8; 3]) -> [u8; 4] {
    [r, g, b, 255]
}

/// An image as the window draws it. egui's own shader has branches for all that widgets may want, which a device in software
/// takes one after the other: a frame at 1920 × 1080 was 320 ms of lavapipe's time with it, and is 53.
pub struct Presented(pub Arc<WindowImage>);

impl CallbackTrait for Presented {
    fn prepare(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        _: &ScreenDescriptor,
        _: &mut wgpu::CommandEncoder,
        resources: &mut CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        if let Some(presenter) = resources.get::<Presenter>() {
            self.0.taken.get_or_init(|| presenter.take(device, queue, &self.0));
        }
        Vec::new()
    }

    fn paint(
        &self,
        _: PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        resources: &CallbackResources,
    ) {
        if let (Some(presenter), Some(taken)) = (resources.get::<Presenter>(), self.0.taken.get()) {
            pass.set_pipeline(&presenter.pipeline);
            pass.set_bind_group(0, taken, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}

/// What images are drawn with.
struct Presenter {
    pipeline: wgpu::RenderPipeline,
    /// As the window's: what is written is then what was read.
    format: wgpu::TextureFormat,
}

/// Makes ready for images in a window.
pub fn make_ready(window: &RenderState) {
    let (device, target) = (&window.device, window.target_format);
    let shader = device.create_shader_module(wgpu::include_wgsl!("present.wgsl"));
    let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("picture"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &shader,
            entry_point: None,
            compilation_options: Default::default(),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: None,
        multisample: Default::default(),
        fragment: Some(wgpu::FragmentState {
            module: &shader,
            entry_point: None,
            compilation_options: Default::default(),
            targets: &[Some(target.into())],
        }),
        multiview_mask: None,
        cache: None,
    });
    let format = match target.is_srgb() {
        true => wgpu::TextureFormat::Rgba8UnormSrgb,
        false => wgpu::TextureFormat::Rgba8Unorm,
    };
    window.renderer.write().callback_resources.insert(Presenter { pipeline, format });
}

impl Presenter {
    /// Brings an image onto the device.
    fn take(
        &self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        image: &WindowImage,
    ) -> wgpu::BindGroup {
        let [width, height] = image.size;
        let descriptor = wgpu::TextureDescriptor {
            label: Some("picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.format,
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        };
        let (order, bytes) = (Default::default(), image.colors.as_flattened());
        let texture = device.create_texture_with_data(queue, &descriptor, order, bytes);
        let view = texture.create_view(&Default::default());
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("picture"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&view),
            }],
        })
    }
}
