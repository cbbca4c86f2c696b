//! The facts of a kernel that others ask for, in place of asking which kernel it is.

/// The facts of a kernel.
pub struct KernelInfo {
    /// The name on the command line and in reports.
    pub name: &'static str,
    /// The arithmetic.
    pub float: FloatType,
    /// The origin of its coordinates.
    pub space: Space,
    /// The kernel's promise.
    pub promise: Promise,
    /// Bytes of the numbers of a sphere and of a plane.
    pub record_bytes: [usize; 2],
    /// The names of the records in the kernel's shader end with this, after `Sphere` and `Plane`.
    pub record_names: &'static str,
    /// The parts of the shader that are the kernel's own.
    pub shader_parts: &'static [ShaderPart],
}

/// The floating-point numbers of a kernel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FloatType {
    /// 24 bits.
    F32,
    /// 53 bits. Not every device has them.
    F64,
}

impl FloatType {
    /// The type's name in WGSL.
    pub fn name(self) -> &'static str {
        match self {
            FloatType::F32 => "f32",
            FloatType::F64 => "f64",
        }
    }

    /// Bytes of a number of the type.
    pub fn size(self) -> usize {
        match self {
            FloatType::F32 => size_of::<f32>(),
            FloatType::F64 => size_of::<f64>(),
        }
    }
}

/// The origin of a kernel's coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Space {
    /// The world's.
    World,
    /// A point that suits the rays.
    Reference,
}

/// The promise of a kernel.
pub struct Promise {
    /// In words.
    pub words: &'static str,
    /// The promise in words for a device whose arithmetic is not known to be IEEE 754's.
    pub words_elsewhere: &'static str,
    /// The bounds that every device keeps. Without them, devices of IEEE 754's arithmetic are equal bit by bit,
    /// and no more is promised.
    pub exact: Option<Exactness>,
}

/// Exact ids, equal bits on all devices, and these bounds.
#[derive(Clone, Copy, Debug)]
pub struct Exactness {
    /// Largest error of `t`, in f32 steps at the exact `t`.
    pub t_ulp: f64,
    /// Largest distance of a normal from the exact one, each component of which is rounded: `√3` halves of an f32 step
    /// below 1.
    pub normal_distance: f64,
}

impl Promise {
    /// Nothing about exactness.
    pub const PARITY: Promise = Promise {
        words: "GPU and CPU equal bit by bit; exactness is not promised",
        words_elsewhere: "nothing on this device, whose arithmetic is not known to be IEEE 754's",
        exact: None,
    };
}

/// A part of a shader.
#[derive(Clone, Copy)]
pub struct ShaderPart {
    /// The part's file, as errors name it.
    pub file: &'static str,
    /// The part's text.
    pub text: &'static str,
}

macro_rules! part {
    ($name:literal) => {
        $crate::kernel::ShaderPart {
            file: concat!("shaders/", $name),
            text: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $name)),
        }
    };
}
pub(crate) use part;
