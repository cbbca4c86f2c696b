//! Kernels and devices, held against exact arithmetic.

use kugelblitz::device::Device;
use kugelblitz::trace::Kernel;
use kugelblitz_judge::verify::{self, Verified};
use pyo3::prelude::*;

use crate::argument::{Crop, Size};
use crate::camera::Camera;
use crate::error;
use crate::place;
use crate::rays::pixels_of;
use crate::scene::Scene;
use crate::table::to_python;
use crate::work;

/// Whether each kernel keeps what it promises, on a device and on the CPU. True where all do; `str()` is the
/// table that `kugelblitz verify` prints.
#[pyclass(frozen, module = "kugelblitz")]
pub struct Verification(Verified);

#[pymethods]
impl Verification {
    /// Whether all promises are kept.
    #[getter]
    fn kept(&self) -> bool {
        self.broken().is_empty()
    }

    fn __bool__(&self) -> bool {
        self.kept()
    }

    /// Promises that are broken, a sentence each.
    #[getter]
    fn broken(&self) -> Vec<String> {
        self.0.broken()
    }

    /// All of it, under the keys of `kugelblitz verify --json`.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0)
    }

    fn __str__(&self) -> String {
        let Verified { size: [width, height], samples, seed, .. } = self.0;
        format!("{width}×{height}, {samples} pixels (seed {seed}) against exact arithmetic\n")
            + &self.0.in_words()
    }

    fn __repr__(&self) -> String {
        match self.broken().as_slice() {
            [] => "<Verification: all promises are kept>".into(),
            broken => format!("<Verification: {}>", broken.join("; ")),
        }
    }
}

/// What [`Scene`]'s method of this name is asked for.
pub struct Asked<'a, 'py> {
    pub camera: Option<&'a Camera>,
    pub size: Option<Size>,
    pub crop: Option<Crop>,
    pub samples: Option<usize>,
    pub seed: u64,
    pub kernel: &'a str,
    pub device: &'a str,
    pub progress: Option<&'a Bound<'py, PyAny>>,
}

impl Asked<'_, '_> {
    pub fn verify(self, py: Python<'_>, scene: &Scene) -> PyResult<Verification> {
        let kernels = match self.kernel {
            "all" => Kernel::ALL.to_vec(),
            name => vec![place::kernel(name)?],
        };
        let pixels = pixels_of(&scene.of, self.camera, self.size, self.crop)?;
        let verification = verify::Verification::new(&scene.of, &pixels, self.samples, self.seed)
            .map_err(error::of(""))?;
        let open =
            |kernel| place::device(py, self.device, kernel, scene.of.spheres.len(), pixels.len());
        let device_of = |&kernel: &Kernel| match open(kernel) {
            Err(error)
                if kernels.len() > 1 && error.is_instance_of::<error::NoAdapterError>(py) =>
            {
                let why = error.value(py);
                error::warn(py, &format!("{} on the CPU alone: {why}", kernel.name()))?;
                Ok((kernel, Device::Cpu))
            }
            device => Ok((kernel, device?)),
        };
        let devices = kernels.iter().map(device_of).collect::<PyResult<Vec<_>>>()?;
        let has_gpu = devices.iter().any(|(_, device)| device.facts().is_some());
        let n_steps = verification.n_steps(kernels.len(), has_gpu);
        let run = |control: &kugelblitz::control::Control| {
            let device_of = |kernel| {
                let own = devices.iter().find(|(of, _)| *of == kernel);
                own.map_or(&Device::Cpu, |(_, device)| device)
            };
            verification.run(&kernels, device_of, control)
        };
        work::run_with_progress(py, self.progress, n_steps, run).map(Verification)
    }
}
