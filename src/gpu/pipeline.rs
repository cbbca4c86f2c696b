//! Shader → compute pipeline.

use super::compile::{Shader, WORKGROUP};
use super::device::OpenDevice;
use crate::error::{Error, Result};

/// The layout that the shader itself asks for: naga's bindings are the only list of them.
pub fn bind_group_layout(device: &wgpu::Device, shader: &Shader) -> wgpu::BindGroupLayout {
    bind_group_layout_for(device, shader, wgpu::ShaderStages::COMPUTE)
}

/// The same for other stages.
pub fn bind_group_layout_for(
    device: &wgpu::Device,
    shader: &Shader,
    visibility: wgpu::ShaderStages,
) -> wgpu::BindGroupLayout {
    let mut entries: Vec<_> = shader
        .module
        .global_variables
        .iter()
        .filter_map(|(_, variable)| {
            let buffer = |ty| wgpu::BindingType::Buffer {
                ty,
                has_dynamic_offset: false,
                min_binding_size: None,
            };
            let ty = match variable.space {
                naga::AddressSpace::Uniform => buffer(wgpu::BufferBindingType::Uniform),
                naga::AddressSpace::Storage { access } => {
                    buffer(wgpu::BufferBindingType::Storage {
                        read_only: !access.contains(naga::StorageAccess::STORE),
                    })
                }
                // Textures, which are all of one kind here.
                naga::AddressSpace::Handle => wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Uint,
                    view_dimension: wgpu::TextureViewDimension::D2,
                    multisampled: false,
                },
                _ => return None,
            };
            let binding = variable.binding.as_ref()?.binding;
            Some(wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None })
        })
        .collect();
    entries.sort_by_key(|entry| entry.binding);
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("kugelblitz"),
        entries: &entries,
    })
}

/// Binds the buffers in the order of the shader's bindings.
#[cfg(feature = "view")]
pub fn bind_group<'a>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    buffers: impl IntoIterator<Item = &'a wgpu::Buffer>,
) -> wgpu::BindGroup {
    bind_resources(device, layout, buffers.into_iter().map(wgpu::Buffer::as_entire_binding))
}

/// Binds buffers and textures in the order of the shader's bindings.
pub fn bind_resources<'a>(
    device: &wgpu::Device,
    layout: &wgpu::BindGroupLayout,
    resources: impl IntoIterator<Item = wgpu::BindingResource<'a>>,
) -> wgpu::BindGroup {
    let entries: Vec<_> = resources
        .into_iter()
        .enumerate()
        .map(|(binding, resource)| wgpu::BindGroupEntry { binding: binding as u32, resource })
        .collect();
    device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("kugelblitz"),
        layout,
        entries: &entries,
    })
}

/// The pipeline of a shader's entry point, passed through with `NoContraction` where the adapter
/// allows it.
///
/// # Errors
/// [`Error::Shader`] when the device refuses it.
pub fn pipeline(
    gpu: &OpenDevice,
    shader: &Shader,
    entry_point: &str,
    bind_group_layout: &wgpu::BindGroupLayout,
) -> Result<wgpu::ComputePipeline> {
    let device = &gpu.device;
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    let module = if gpu.facts.passthrough {
        pass_through(device, &shader.spirv()?, entry_point)
    } else {
        device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(entry_point),
            source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(shader.module.clone())),
        })
    };
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(entry_point),
        bind_group_layouts: &[Some(bind_group_layout)],
        immediate_size: 0,
    });
    let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some(entry_point),
        layout: Some(&layout),
        module: &module,
        entry_point: Some(entry_point),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    match pollster::block_on(scope.pop()) {
        Some(error) => Err(Error::Shader(format!("`{}` refuses: {error}", gpu.facts.name))),
        None => Ok(pipeline),
    }
}

#[allow(unsafe_code)]
fn pass_through(device: &wgpu::Device, spirv: &[u32], entry_point: &str) -> wgpu::ShaderModule {
    let [width, height] = WORKGROUP;
    let descriptor = wgpu::ShaderModuleDescriptorPassthrough {
        label: Some(entry_point),
        // The size is for Metal alone.
        entry_points: std::borrow::Cow::Owned(vec![wgpu::PassthroughShaderEntryPoint {
            name: entry_point.into(),
            workgroup_size: (width, height, 1),
        }]),
        spirv: Some(spirv.into()),
        ..Default::default()
    };
    // SAFETY: naga validated the module and wrote these words; only NoContraction decorations
    // were added, which change no memory access. Indices into buffers stay below lengths that the
    // host passes along. Those into textures are below `Walk::n_nodes`, or places of leaves, which
    // `Footprints::new` and the tree's builder count and `gpu::hierarchy` has texels for. Those into boxes are
    // below `LightOfAll::n_boxes`, as each link leads to a node of the tree or behind the last one, and ids of
    // objects are compared with their number first.
    unsafe { device.create_shader_module_passthrough(descriptor) }
}
