//! Drawing a picture that lies on the device into a window.

use std::sync::Arc;

use super::compile::compile_present;
use super::live::Words;
use super::open::Gpu;
use super::pipeline::{Bindings, unless_refused};
use crate::error::Result;

/// Twin of `Present` in `shaders/present.wgsl`.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(crate) struct Present {
    /// Where the picture is shown, px of the window.
    pub left: u32,
    /// The same.
    pub top: u32,
    /// Columns of the window that it covers.
    pub shown_width: u32,
    /// Rows of the window that it covers.
    pub shown_height: u32,
    /// Columns of the picture.
    pub width: u32,
    /// Rows of the picture.
    pub height: u32,
    /// Columns of the window left of this one show the first picture, the others the second.
    pub divider: u32,
    /// Bit 0: the first picture has paint; bit 1: the second has.
    pub painted: u32,
}

/// One kernel's picture.
#[derive(Clone)]
pub(crate) struct Layer {
    /// Id of each pixel.
    pub ids: Arc<Words>,
    /// Colours of single pixels, which win over those of the ids.
    pub paint: Option<Arc<Words>>,
}

/// The pipeline that draws pictures.
pub(crate) struct Presenter {
    gpu: Arc<Gpu>,
    pipeline: wgpu::RenderPipeline,
    bindings: Bindings,
    uniform: wgpu::Buffer,
}

impl Presenter {
    /// Compiles the shader for a target of `format`.
    ///
    /// # Errors
    /// [`Error::Shader`] when the device refuses it.
    pub(crate) fn new(gpu: &Arc<Gpu>, format: wgpu::TextureFormat) -> Result<Presenter> {
        let device = &gpu.device;
        let shader = compile_present()?;
        let bindings = Bindings::for_stages(gpu, &shader, wgpu::ShaderStages::FRAGMENT)?;
        let pipeline = unless_refused(gpu, || {
            let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("present"),
                source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(shader.module)),
            });
            let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some("present"),
                bind_group_layouts: &[Some(&bindings.layout)],
                immediate_size: 0,
            });
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("present"),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("cover"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: None,
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("show"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(format.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        })?;
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let uniform = gpu.buffer("present", size_of::<Present>(), usage);
        Ok(Presenter { gpu: Arc::clone(gpu), pipeline, bindings, uniform })
    }

    /// Draws one or two layers, as `present` says.
    ///
    /// # Errors
    /// [`crate::Error::Shader`] where the shader binds something else.
    pub(crate) fn draw<'a>(
        &self,
        pass: &mut wgpu::RenderPass<'static>,
        mut present: Present,
        palette: &Words,
        layers: &'a [Layer],
    ) -> Result<()> {
        let (Some(first), Some(last)) = (layers.first(), layers.last()) else { return Ok(()) };
        let n_pixels = present.width as usize * present.height as usize;
        if [first, last].iter().any(|layer| layer.ids.len() < n_pixels) || n_pixels == 0 {
            return Ok(());
        }
        let paint = |layer: &'a Layer| layer.paint.as_ref().filter(|p| p.len() >= n_pixels);
        let painted = |layer| u32::from(paint(layer).is_some());
        present.painted = painted(first) | painted(last) << 1;
        self.gpu.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&present));
        // A layer without paint still needs a binding, which the shader then does not look at.
        let bound = |layer: &'a Layer| paint(layer).unwrap_or(&layer.ids).buffer();
        let [first_ids, last_ids] = [first, last].map(|layer| layer.ids.buffer());
        let buffers = [
            ("present", &self.uniform),
            ("palette", palette.buffer()),
            ("first_ids", first_ids),
            ("second_ids", last_ids),
            ("first_paint", bound(first)),
            ("second_paint", bound(last)),
        ];
        let resources = buffers.map(|(name, buffer)| (name, buffer.as_entire_binding()));
        let bind_group = self.bindings.bind(&self.gpu.device, resources)?;
        let [x, y, width, height] =
            [present.left, present.top, present.shown_width, present.shown_height]
                .map(|px| px as f32);
        pass.set_viewport(x, y, width, height, 0.0, 1.0);
        pass.set_scissor_rect(present.left, present.top, present.shown_width, present.shown_height);
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &bind_group, &[]);
        pass.draw(0..3, 0..1);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;

    #[test]
    fn present_has_nagas_offsets() {
        let shader = compile_present().unwrap();
        let members = shader.module.types.iter().find_map(|(_, ty)| match &ty.inner {
            naga::TypeInner::Struct { members, span } if ty.name.as_deref() == Some("Present") => {
                assert_eq!(*span as usize, size_of::<Present>());
                Some(members)
            }
            _ => None,
        });
        let found: Vec<_> = members
            .expect("a struct Present")
            .iter()
            .map(|member| (member.name.clone().unwrap_or_default(), member.offset as usize))
            .collect();
        macro_rules! offsets {
            ($($field:ident),+) => {
                vec![$((stringify!($field).to_string(), offset_of!(Present, $field))),+]
            };
        }
        let expected =
            offsets!(left, top, shown_width, shown_height, width, height, divider, painted);
        assert_eq!(found, expected);
    }
}
