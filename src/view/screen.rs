//! The window's surface, and what is drawn into it: the picture and the panels over it.

use std::sync::Arc;

use egui_wgpu::{Renderer, RendererOptions, ScreenDescriptor, wgpu};
use winit::dpi::PhysicalSize;
use winit::window::Window;

use crate::error::{Error, Result};
use crate::gpu::{Gpu, Layer, OpenWindow, Pick, Present, Presenter, Words, open_window};

/// A surface that is open.
pub struct Screen {
    pub gpu: Arc<Gpu>,
    window: Arc<Window>,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    /// True while the window may have another size than the surface.
    is_outdated: bool,
    presenter: Presenter,
    panels: Renderer,
}

/// A picture to be drawn.
pub struct Shown<'a> {
    /// Where and how.
    pub present: Present,
    /// Colours by id.
    pub palette: &'a Words,
    /// One or two kernels' pictures.
    pub layers: Vec<Layer>,
}

/// The panels of a frame.
#[derive(Default)]
pub struct Panels {
    /// Triangles.
    pub jobs: Vec<egui::ClippedPrimitive>,
    /// Textures that changed since the last frame that was handed over.
    pub textures: egui::TexturesDelta,
    /// Pixels of a point.
    pub pixels_per_point: f32,
}

/// The fate of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drawn {
    /// It is in the window.
    Yes,
    /// It must be drawn again.
    Again,
    /// Nobody can see it now.
    Hidden,
    /// The surface is gone.
    Lost,
}

impl Screen {
    /// Opens a device and the window's surface.
    ///
    /// # Errors
    /// [`Error::NoAdapter`] when none can show pictures, [`Error::Shader`].
    pub fn open(pick: &Pick, window: &Arc<Window>) -> Result<Screen> {
        let OpenWindow { gpu, surface, capabilities } = open_window(pick, Arc::clone(window))?;
        let gpu = Arc::new(gpu);
        let given = capabilities
            .formats
            .iter()
            .find(|format| !format.is_srgb())
            .or(capabilities.formats.first())
            .copied()
            .ok_or_else(|| Error::NoAdapter("the window takes no picture format".into()))?;
        // Colours are sRGB bytes already, so the target must take them as they are.
        let format = given.remove_srgb_suffix();
        // Without waiting for the screen where that is possible: a frame is drawn only when there
        // is something new.
        let present_mode = match capabilities.present_modes.contains(&wgpu::PresentMode::Mailbox) {
            true => wgpu::PresentMode::Mailbox,
            false => wgpu::PresentMode::Fifo,
        };
        let size = window.inner_size();
        let config = wgpu::SurfaceConfiguration {
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            format: given,
            color_space: wgpu::SurfaceColorSpace::Auto,
            width: size.width.max(1),
            height: size.height.max(1),
            present_mode,
            desired_maximum_frame_latency: 2,
            alpha_mode: wgpu::CompositeAlphaMode::Auto,
            view_formats: vec![format],
        };
        let presenter = Presenter::new(&gpu, format)?;
        // Colours of the legend are those of the picture, to the byte.
        let options = RendererOptions { dithering: false, ..RendererOptions::default() };
        let panels = Renderer::new(&gpu.device, format, options);
        let mut screen = Screen {
            gpu,
            window: Arc::clone(window),
            surface,
            config,
            is_outdated: false,
            presenter,
            panels,
        };
        screen.configure();
        screen.gpu.check()?;
        Ok(screen)
    }

    /// Takes the size that the window has now: one that an event told may be out of date.
    fn configure(&mut self) {
        let size = self.window.inner_size();
        if size.width > 0 && size.height > 0 {
            (self.config.width, self.config.height) = (size.width, size.height);
        }
        let side = self.gpu.device.limits().max_texture_dimension_2d;
        self.config.width = self.config.width.clamp(1, side);
        self.config.height = self.config.height.clamp(1, side);
        let _held = self.gpu.hold();
        self.surface.configure(&self.gpu.device, &self.config);
    }

    /// Takes note that the window has another size.
    pub fn resize(&mut self, size: PhysicalSize<u32>) {
        self.is_outdated |= (self.config.width, self.config.height) != (size.width, size.height);
    }

    /// Follows the window's size; gives that of the surface, px. To be called before a frame, when
    /// all events were heard: winit panics where a window that is gone is asked for its size.
    pub fn follow_window(&mut self) -> [u32; 2] {
        if std::mem::take(&mut self.is_outdated) {
            self.configure();
        }
        [self.config.width, self.config.height]
    }

    /// The largest texture that the panels may use.
    pub fn max_texture_side(&self) -> usize {
        self.gpu.device.limits().max_texture_dimension_2d as usize
    }

    /// Draws a frame and hands it to the window.
    ///
    /// # Errors
    /// The device's, when it is lost.
    pub fn draw(&mut self, shown: Option<Shown>, panels: &mut Panels) -> Result<Drawn> {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let textures = std::mem::take(&mut panels.textures);
        for (id, deltas) in &textures.set {
            for delta in deltas {
                self.panels.update_texture(device, queue, *id, delta);
            }
        }
        let drawn = self.draw_frame(shown, panels)?;
        for id in &textures.free {
            self.panels.free_texture(id);
        }
        self.gpu.check()?;
        Ok(drawn)
    }

    fn draw_frame(&mut self, shown: Option<Shown>, panels: &Panels) -> Result<Drawn> {
        use wgpu::CurrentSurfaceTexture as Current;
        let (texture, is_outdated) = match self.surface.get_current_texture() {
            Current::Success(texture) => (texture, false),
            Current::Suboptimal(texture) => (texture, true),
            Current::Outdated => {
                self.is_outdated = true;
                return Ok(Drawn::Again);
            }
            Current::Timeout | Current::Occluded => return Ok(Drawn::Hidden),
            Current::Lost => return Ok(Drawn::Lost),
            // The device has reported it too.
            Current::Validation => return Ok(Drawn::Again),
        };
        let view = texture.texture.create_view(&wgpu::TextureViewDescriptor {
            format: Some(self.config.format.remove_srgb_suffix()),
            ..wgpu::TextureViewDescriptor::default()
        });
        let commands = self.commands(&view, shown, panels)?;
        self.gpu.submit(commands);
        self.window.pre_present_notify();
        {
            let _held = self.gpu.hold();
            self.gpu.queue.present(texture);
        }
        self.is_outdated |= is_outdated;
        Ok(Drawn::Yes)
    }

    fn commands(
        &mut self,
        view: &wgpu::TextureView,
        shown: Option<Shown>,
        panels: &Panels,
    ) -> Result<wgpu::CommandBuffer> {
        let (device, queue) = (&self.gpu.device, &self.gpu.queue);
        let descriptor = ScreenDescriptor {
            size_in_pixels: [self.config.width, self.config.height],
            pixels_per_point: panels.pixels_per_point,
        };
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        // Only panels with commands of their own give some; these have none.
        let _ = self.panels.update_buffers(device, queue, &mut encoder, &panels.jobs, &descriptor);
        let attachment = wgpu::RenderPassColorAttachment {
            view,
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations {
                load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                store: wgpu::StoreOp::Store,
            },
        };
        let mut pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("window"),
                color_attachments: &[Some(attachment)],
                ..wgpu::RenderPassDescriptor::default()
            })
            .forget_lifetime();
        if let Some(Shown { present, palette, layers }) = shown
            && present.left + present.shown_width <= self.config.width
            && present.top + present.shown_height <= self.config.height
        {
            self.presenter.draw(&mut pass, present, palette, &layers)?;
        }
        self.panels.render(&mut pass, &panels.jobs, &descriptor);
        drop(pass);
        Ok(encoder.finish())
    }
}
