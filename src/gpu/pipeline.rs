//! Shader → compute pipeline. What a device can't bind is refused before it is asked, in words; what it
//! refuses itself comes back as an error, wherever in the making it does.

use super::compile::{Shader, WORKGROUP};
use super::open::Gpu;
use super::texture::{FORMAT, TEXEL_BYTES};
use crate::error::{Error, Hint, Message, Result, Setting};

/// A buffer or a texture, with the name that shaders have for it.
pub type Named = (&'static str, Resource);

/// What a shader binds.
#[derive(Clone)]
pub enum Resource {
    /// A buffer, as a whole.
    Buffer(wgpu::Buffer),
    /// A texture that holds a list.
    Texture(wgpu::TextureView),
}

impl From<wgpu::Buffer> for Resource {
    fn from(buffer: wgpu::Buffer) -> Resource {
        Resource::Buffer(buffer)
    }
}

impl Resource {
    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        match self {
            Resource::Buffer(buffer) => buffer.size(),
            Resource::Texture(view) => {
                let size = view.texture().size();
                u64::from(size.width) * u64::from(size.height) * TEXEL_BYTES as u64
            }
        }
    }
}

/// A shader, ready to run.
pub struct Program {
    pub pipeline: wgpu::ComputePipeline,
    layout: wgpu::BindGroupLayout,
    /// What the shader binds, as naga has it: the only list of that.
    names: Vec<(String, u32)>,
}

impl Program {
    /// Makes the program of a shader with this entry point, passed through with `NoContraction` where the adapter allows it.
    ///
    /// # Errors
    /// [`Error::TooLarge`] when the shader binds more than the device takes, [`Error::Shader`] when it
    /// refuses the shader.
    pub fn new(gpu: &Gpu, shader: &Shader, entry_point: &str) -> Result<Program> {
        let device = &gpu.device;
        let entries = entries(shader);
        check_limits(gpu, shader, &entries)?;
        let spirv = gpu.facts.passthrough.then(|| shader.spirv()).transpose()?;
        let spirv = spirv.map(|words| gpu.edited(words));
        let (layout, pipeline) = unless_refused(gpu, || {
            let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some("kugelblitz"),
                entries: &entries,
            });
            let module = match &spirv {
                Some(words) => pass_through(device, words, entry_point),
                None => device.create_shader_module(wgpu::ShaderModuleDescriptor {
                    label: Some(entry_point),
                    source: wgpu::ShaderSource::Naga(std::borrow::Cow::Owned(
                        shader.module.clone(),
                    )),
                }),
            };
            let of_pipeline = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(entry_point),
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            });
            let pipeline = device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some(entry_point),
                layout: Some(&of_pipeline),
                module: &module,
                entry_point: Some(entry_point),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                cache: None,
            });
            (layout, pipeline)
        })?;
        let globals = shader.module.global_variables.iter();
        let names = globals.filter_map(|(_, variable)| {
            Some((variable.name.clone()?, variable.binding.as_ref()?.binding))
        });
        Ok(Program { pipeline, layout, names: names.collect() })
    }

    /// Binds buffers and textures, in any order, by the names that the shader has for them.
    ///
    /// # Errors
    /// [`Error::Shader`] where these are not the shader's names, each once: a defect of the program.
    pub fn bind<'a>(
        &self,
        device: &wgpu::Device,
        resources: impl IntoIterator<Item = (&'static str, wgpu::BindingResource<'a>)>,
    ) -> Result<wgpu::BindGroup> {
        let mut entries: Vec<wgpu::BindGroupEntry> = Vec::with_capacity(self.names.len());
        let wrong = |name: &str, what| Error::Shader(format!("the binding `{name}` {what}"));
        for (name, resource) in resources {
            let known = self.names.iter().find(|(known, _)| known == name);
            let &(_, binding) = known.ok_or_else(|| wrong(name, "is not in the shader"))?;
            if entries.iter().any(|entry| entry.binding == binding) {
                return Err(wrong(name, "is given twice"));
            }
            entries.push(wgpu::BindGroupEntry { binding, resource });
        }
        let is_given = |binding| entries.iter().any(|entry| entry.binding == binding);
        if let Some((name, _)) = self.names.iter().find(|(_, binding)| !is_given(*binding)) {
            return Err(wrong(name, "of the shader is not given"));
        }
        Ok(device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("kugelblitz"),
            layout: &self.layout,
            entries: &entries,
        }))
    }
}

/// All of something, as it is bound under its name.
pub fn whole((name, resource): &Named) -> (&'static str, wgpu::BindingResource<'_>) {
    let binding = match resource {
        Resource::Buffer(buffer) => buffer.as_entire_binding(),
        Resource::Texture(view) => wgpu::BindingResource::TextureView(view),
    };
    (name, binding)
}

/// Makes something of a device, with the reason where that refuses it.
///
/// # Errors
/// [`Error::Shader`]
pub fn unless_refused<T>(gpu: &Gpu, make: impl FnOnce() -> T) -> Result<T> {
    let scope = gpu.device.push_error_scope(wgpu::ErrorFilter::Validation);
    let made = make();
    match pollster::block_on(scope.pop()) {
        Some(error) => Err(Error::Shader(format!("`{}` refuses: {error}", gpu.facts.name))),
        None => Ok(made),
    }
}

/// Compares what a shader needs at once with what the device has.
fn check_limits(gpu: &Gpu, shader: &Shader, entries: &[wgpu::BindGroupLayoutEntry]) -> Result<()> {
    use wgpu::{BindingType, BufferBindingType};
    let [mut n_storage, mut n_uniform, mut n_textures] = [0; 3];
    for entry in entries {
        *match entry.ty {
            BindingType::Buffer { ty: BufferBindingType::Uniform, .. } => &mut n_uniform,
            BindingType::Buffer { .. } => &mut n_storage,
            _ => &mut n_textures,
        } += 1;
    }
    let groups = shader.module.entry_points.iter().map(|entry| entry.workgroup_size);
    let most = |size: fn([u32; 3]) -> u32| groups.clone().map(size).max().unwrap_or(0);
    let limits = gpu.device.limits();
    let needs = [
        ("storage buffers", n_storage, gpu.facts.max_storage_buffers),
        ("uniform buffers", n_uniform, limits.max_uniform_buffers_per_shader_stage),
        ("textures", n_textures, limits.max_storage_textures_per_shader_stage),
        ("bindings", entries.len() as u32, limits.max_bindings_per_bind_group),
        (
            "invocations of a workgroup",
            most(|[x, y, z]| x * y * z),
            limits.max_compute_invocations_per_workgroup,
        ),
        ("columns of a workgroup", most(|[x, ..]| x), limits.max_compute_workgroup_size_x),
        ("rows of a workgroup", most(|[_, y, _]| y), limits.max_compute_workgroup_size_y),
    ];
    match needs.into_iter().find(|(_, needed, limit)| needed > limit) {
        Some((what, needed, limit)) => {
            let text = format!(
                "a shader for this needs {needed} {what}, and `{}` has at most {limit}",
                gpu.facts.name
            );
            let hint = Hint::new("use {}", [Setting::text("device", "cpu")]);
            Err(Error::TooLarge(Message::new(text, hint)))
        }
        None => Ok(()),
    }
}

fn entries(shader: &Shader) -> Vec<wgpu::BindGroupLayoutEntry> {
    let globals = shader.module.global_variables.iter();
    globals
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
                naga::AddressSpace::Handle => wgpu::BindingType::StorageTexture {
                    access: wgpu::StorageTextureAccess::ReadOnly,
                    format: FORMAT,
                    view_dimension: wgpu::TextureViewDimension::D2,
                },
                _ => return None,
            };
            let binding = variable.binding.as_ref()?.binding;
            let visibility = wgpu::ShaderStages::COMPUTE;
            Some(wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None })
        })
        .collect()
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
    // were added, which change no memory access, and nor does what a test makes of arithmetic. Indices
    // into buffers stay below lengths that the host passes along. Those into textures are below
    // `Traversal::n_boxes`, or places of leaves, which `gpu::hierarchy` has texels for. Those into lamps stay below the number of
    // lamps that come along.
    unsafe { device.create_shader_module_passthrough(descriptor) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::adapter::adapters;
    use crate::gpu::compile::compile_self_test;

    /// The best device, with some limits lower than it has them.
    fn open_within(lower: impl Fn(wgpu::Limits) -> wgpu::Limits) -> Gpu {
        let first = adapters().into_iter().next();
        let (adapter, facts) = first.expect("a Vulkan device; ci/setup.sh installs one");
        let limits = lower(adapter.limits());
        Gpu::open_within(&adapter, facts, limits).unwrap()
    }

    #[test]
    fn what_a_device_cannot_bind_is_refused_in_words_before_it_is_made() {
        let shader = compile_self_test("f32").unwrap();
        type Lower = fn(wgpu::Limits) -> wgpu::Limits;
        let lower: [(&str, Lower); 4] = [
            ("3 storage buffers", |limits| wgpu::Limits {
                max_storage_buffers_per_shader_stage: 2,
                ..limits
            }),
            ("1 textures", |limits| wgpu::Limits {
                max_storage_textures_per_shader_stage: 0,
                ..limits
            }),
            ("4 bindings", |limits| wgpu::Limits { max_bindings_per_bind_group: 3, ..limits }),
            ("64 invocations", |limits| wgpu::Limits {
                max_compute_invocations_per_workgroup: 32,
                ..limits
            }),
        ];
        for (what, lower) in lower {
            let gpu = open_within(lower);
            let error = Program::new(&gpu, &shader, "self_test").err().expect(what);
            assert_eq!(error.exit_code(), 7, "{error}");
            for part in [what, &gpu.facts.name] {
                assert!(error.to_string().contains(part), "{part}: {error}");
            }
            assert!(error.hint().to_string().contains("device = \"cpu\""), "{}", error.hint());
            gpu.check().unwrap_or_else(|later| panic!("{what}: {later}"));
        }
        assert!(Program::new(&open_within(|limits| limits), &shader, "self_test").is_ok());
    }

    /// Each of the shader's names once, or a word about which not.
    #[test]
    fn what_is_bound_has_the_names_of_the_shader() {
        let gpu = open_within(|limits| limits);
        let shader = compile_self_test("f32").unwrap();
        let program = Program::new(&gpu, &shader, "self_test").unwrap();
        let buffer = gpu.buffer("test", 64, wgpu::BufferUsages::STORAGE);
        let bind = |names: &[&'static str]| {
            let resources = names.iter().map(|&name| (name, buffer.as_entire_binding()));
            program.bind(&gpu.device, resources).err().map(|error| error.to_string())
        };
        let said = |names: &[&'static str]| bind(names).expect("an error");
        assert!(said(&["operands", "results", "more"]).contains("`more` is not in the shader"));
        assert!(said(&["results", "results"]).contains("`results` is given twice"));
        assert!(said(&["results"]).contains("`operands` of the shader is not given"));
    }

    /// Without a scope around it, the reason would be told by whatever the device does next.
    #[test]
    fn a_layout_that_is_refused_has_its_reason() {
        let gpu = open_within(|limits| wgpu::Limits {
            max_storage_buffers_per_shader_stage: 2,
            ..limits
        });
        let entries = entries(&compile_self_test("f32").unwrap());
        let layout = unless_refused(&gpu, || {
            let layout = gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: None,
                entries: &entries,
            });
            gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: None,
                bind_group_layouts: &[Some(&layout)],
                immediate_size: 0,
            })
        });
        let reason = layout.expect_err("three storage buffers").to_string();
        assert!(reason.contains("refuses") && reason.contains('2'), "{reason}");
        gpu.check().unwrap();
    }
}
