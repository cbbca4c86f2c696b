//! Two pictures, and kernels and devices, held against each other or against exact arithmetic; what comparisons come
//! to, see `_verdicts.py`.

use std::num::NonZeroUsize;

use kugelblitz::picture::Image;
use kugelblitz::rays::Pixels;
use kugelblitz::trace::Kernel;
use kugelblitz_judge::compare::{Allowed, PictureDifference, compare_pictures};
use kugelblitz_judge::verify::{Verification, Verified};
use numpy::PyArray1;
use pyo3::prelude::*;
use serde::Serialize;

use crate::drawing::tinted;
use crate::error::{self, wrong_value};
use crate::image::{image_of, indices};
use crate::place;
use crate::scene::Scene;
use crate::table::{Given, Object, helpers, to_python};
use crate::work::{self, Steps};

/// A `Verdict` of this kind: what is not as it may be, what the program prints as JSON and in words, and, where there
/// is one, an object that knows the rest.
pub fn verdict<'py>(
    py: Python<'py>,
    kind: &str,
    broken: &[String],
    summary: &impl Serialize,
    words: String,
    of: Given<'py>,
) -> Object<'py> {
    let arguments = (broken, to_python(py, summary)?, words, of);
    py.import("kugelblitz._verdicts")?.call_method1(kind, arguments)
}

/// What a `Difference` knows of its pixels.
#[pyclass(frozen, module = "kugelblitz._kugelblitz")]
pub struct Compared {
    a: Image,
    of: PictureDifference,
}

#[pymethods]
impl Compared {
    fn beyond<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        indices(py, self.of.pixels_beyond())
    }

    fn picture<'py>(&self, py: Python<'py>) -> PyResult<Given<'py>> {
        let size = [self.a.width as u32, self.a.height as u32];
        let tinted = || tinted(py, size, &self.of.picture(&self.a), Vec::new());
        (self.of.pixels > 0).then(tinted).transpose()
    }
}

/// Compares two pictures channel by channel: `Picture`s, arrays of colours (height, width, 3), structured
/// arrays, or paths of files.
///
/// Bytes and 16 bits are sRGB, floats linear; numbers of different types are compared as the one that has fewer
/// of them. `allow` is what may differ, e.g. "levels=1,ulp=4,difference=1e-6,pixels=0.1%"; nothing without it.
#[pyfunction]
#[pyo3(signature = (a, b, *, allow = ""))]
pub fn compare<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    b: &Bound<'py, PyAny>,
    allow: &str,
) -> Object<'py> {
    let picture = |name, given| helpers(py)?.call_method1("picture", (name, given))?.extract();
    let allowed = Allowed::of_pictures(allow).map_err(error::of("allow"))?;
    let [a, b] = [image_of(picture("a", a)?)?, image_of(picture("b", b)?)?];
    let of = work::run(py, |_| compare_pictures(["a", "b"], [&a, &b], &allowed))?;
    let compared = Bound::new(py, Compared { a, of })?;
    let of = &compared.get().of;
    let known = Some(compared.clone().into_any());
    verdict(py, "Difference", &of.broken, of, of.in_words(), known)
}

/// Holds a kernel, or all, against exact arithmetic at so many of these pixels, drawn by a seed.
pub fn verify<'py>(
    py: Python<'py>,
    scene: &Scene,
    pixels: &Pixels,
    (n_samples, seed): (Option<usize>, u64),
    (kernel, device): (&str, &str),
    progress: Given<'py>,
) -> Object<'py> {
    let kernels = match kernel {
        "all" => Kernel::ALL.to_vec(),
        name => vec![place::kernel(name)?],
    };
    let n_samples = match n_samples.map(NonZeroUsize::new) {
        Some(None) => {
            return wrong_value("samples: 0 pixels are nothing to compare; give 1 or more");
        }
        n_samples => n_samples.flatten(),
    };
    let verification =
        Verification::new(&scene.of, pixels, n_samples, seed).map_err(error::of(""))?;
    let devices = place::devices(py, device, &kernels, scene.of.spheres.len(), pixels.len())?;
    let has_gpu = devices.values().any(|device| device.facts().is_some());
    let steps = Steps::Rays(verification.n_steps(kernels.len(), has_gpu));
    let of = work::run_with_progress(py, progress, steps, |control| {
        verification.run(&kernels, |kernel| &devices[&kernel], control)
    })?;
    let Verified { size: [width, height], samples, seed, .. } = of;
    let head =
        format!("{width}×{height}, {samples} pixels (seed {seed}) against exact arithmetic\n");
    verdict(py, "Verification", &of.broken(), &of, head + &of.in_words(), None)
}
