//! A picture in memory.

use std::io::Cursor;
use std::path::PathBuf;
use std::sync::OnceLock;

use kugelblitz::Control;
use kugelblitz::Session;
use kugelblitz::digest::Digest;
use kugelblitz::lighting::{Background, Colors, Encoding, Framebuffer, Style};
use kugelblitz::output::{self, OutputFile};
use kugelblitz::picture::{ChannelBits, Format, Image, PictureOptions, PictureWriter, Sink};
use kugelblitz::query::{Hits, Kernel, Outputs, StageCounts};
use kugelblitz::rays::Pixels;
use kugelblitz::render::{Plan, n_steps, plan};
use kugelblitz::scene::Camera;
use kugelblitz::support::memory::Available;
use numpy::{Element, PyArray1, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyBytes, PyDict};

use crate::error::{self, wrong_value};
use crate::process::once;
use crate::scene::PyScene;
use crate::table::{Given, PyValue};

/// Returns the numbers of rays that each stage decided, as a dictionary.
pub fn counts_of<'py>(py: Python<'py>, counts: &StageCounts) -> PyResult<Bound<'py, PyDict>> {
    let StageCounts { f32, f64, exact } = *counts;
    [("f32", f32), ("f64", f64), ("exact", exact)].into_py_dict(py)
}

/// A picture in memory: arrays, row by row from the top, and files of them.
///
/// A notebook shows it. Arrays are made when they are first asked for, and copies: changing one changes no
/// file.
#[pyclass(frozen, name = "Picture", module = "kugelblitz")]
pub struct PyPicture {
    pub scene: Py<PyScene>,
    pub device: String,
    pub kernel: Kernel,
    pub camera: Camera,
    pub pixels: Pixels,
    pub style: Style,
    pub kept: Framebuffer,
    pub linear: OnceLock<Colors>,
    pub srgb16: OnceLock<Colors>,
    /// The hits with `t` and normals, where `kept` has none.
    pub traced: OnceLock<Hits>,
}

impl PyPicture {
    /// The hits with `t` and normals: traced anew when they are first wanted, unless they were kept.
    fn hits(&self, py: Python<'_>) -> PyResult<&Hits> {
        self.scene.get().keep_surfaces();
        let kept = &self.kept.hits;
        if kept.t.len() == kept.id.len() {
            return Ok(kept);
        }
        once(&self.traced, || {
            let wants = Outputs { surface: true, level: true };
            self.run(py, (None, 0), |session, control| session.hits(&self.pixels, wants, control))
        })
    }

    /// Does `work` with the session that made the picture.
    fn run<T: Send>(
        &self,
        py: Python<'_>,
        progress: (Given<'_>, u64),
        work: impl FnOnce(&mut Session, &Control) -> kugelblitz::Result<T> + Send,
    ) -> PyResult<T> {
        let on = (&*self.device, self.kernel, self.pixels.len());
        self.scene.get().run(py, on, progress, work)
    }

    /// The colours in another encoding, painted when they are first wanted.
    fn painted<'py>(
        &self,
        py: Python<'py>,
        encoding: Encoding,
        colors: &OnceLock<Colors>,
    ) -> PyValue<'py> {
        let background = match self.style.background {
            Background::Shown => Background::Shown,
            Background::LeftOut | Background::Black => Background::Black,
        };
        let style = Style { encoding, background, ..self.style };
        let colors = once(colors, || {
            self.run(py, (None, 0), |session, control| {
                let (kept, _) = session.keep(&self.pixels, style, Outputs::default(), control)?;
                Ok(kept.colors)
            })
        })?;
        self.array_of(py, colors)
    }

    /// Colours as an array.
    fn array_of<'py>(&self, py: Python<'py>, colors: &Colors) -> PyValue<'py> {
        match colors {
            Colors::Srgb8(colors) => self.array(py, colors.as_flattened()),
            Colors::Srgb16(colors) => self.array(py, colors.as_flattened()),
            Colors::Linear(colors) => self.array(py, colors.as_flattened()),
        }
    }

    /// Returns the colours, ids, depths and normals as channels.
    pub fn image(&self, py: Python<'_>) -> PyResult<Image> {
        let hits = self.hits(py)?;
        Ok(Image::of_pixels("picture", &self.pixels, &self.kept.colors, Some(hits)))
    }

    /// Returns the pixels that the picture shows.
    pub fn pixels(&self) -> Pixels {
        self.pixels
    }

    /// Returns the number of samples across and down a pixel.
    pub fn n_samples(&self) -> kugelblitz::scene::Samples {
        self.style.n_samples
    }

    /// How it becomes a file.
    fn plan(&self, format: Format, options: PictureOptions) -> PyResult<Plan> {
        let (n_samples, n_objects) = (self.style.n_samples, self.scene.get().of.n_objects());
        let plan = plan(format, options, n_samples, &self.pixels, n_objects, Available::now());
        let mut plan = plan.map_err(error::of("path"))?;
        plan.style.epsilon = self.style.epsilon;
        Ok(plan)
    }

    /// The numbers of its pixels as an array: one of each, or several along a last axis.
    fn array<'py, T: Element>(&self, py: Python<'py>, numbers: &[T]) -> PyValue<'py> {
        let Pixels { width, height, .. } = self.pixels;
        let shape = [height as usize, width as usize, numbers.len() / self.pixels.len()];
        let n_axes = if shape[2] > 1 { 3 } else { 2 };
        Ok(PyArray1::from_slice(py, numbers).reshape(&shape[..n_axes])?.into_any())
    }

    /// Writes it as the program does, with what it says of itself.
    fn write<W: std::io::Write + std::io::Seek>(
        &self,
        session: &mut Session,
        plan: &Plan,
        sink: W,
        name: PathBuf,
    ) -> kugelblitz::Result<W> {
        let &Plan { format, options, .. } = plan;
        session.set_camera(self.camera.clone());
        let metadata = session.metadata(&self.pixels, plan);
        let mut writer =
            PictureWriter::create(format, options, &self.pixels, &metadata, sink, name)?;
        writer.band(&self.kept, self.pixels.height)?;
        writer.finish()
    }
}

#[pymethods]
impl PyPicture {
    /// Columns.
    #[getter]
    fn width(&self) -> u32 {
        self.pixels.width
    }

    /// Rows.
    #[getter]
    fn height(&self) -> u32 {
        self.pixels.height
    }

    /// Colours in sRGB, bytes; shape (height, width, 3).
    #[getter]
    fn rgb8<'py>(&self, py: Python<'py>) -> PyValue<'py> {
        self.array_of(py, &self.kept.colors)
    }

    /// Linear colours, the nearest floats; shape (height, width, 3). They are painted when they are first
    /// asked for.
    #[getter]
    fn rgb<'py>(&self, py: Python<'py>) -> PyValue<'py> {
        self.painted(py, Encoding::Linear, &self.linear)
    }

    /// Colours in sRGB with 16 bits a channel; shape (height, width, 3). They are painted when they are first
    /// asked for.
    #[getter]
    fn rgb16<'py>(&self, py: Python<'py>) -> PyValue<'py> {
        self.painted(py, Encoding::Srgb16, &self.srgb16)
    }

    /// The scene that it shows.
    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<PyScene> {
        self.scene.clone_ref(py)
    }

    /// The share of each pixel's samples that hit an object; `None` unless the picture is transparent.
    #[getter]
    fn alpha<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(coverage) = &self.kept.coverage else { return Ok(None) };
        let alpha: Vec<f32> = (0..self.pixels.len()).map(|pixel| coverage.alpha(pixel)).collect();
        self.array(py, &alpha).map(Some)
    }

    /// Object ids, 0 for the background.
    #[getter]
    fn id<'py>(&self, py: Python<'py>) -> PyValue<'py> {
        self.array(py, &self.kept.hits.id)
    }

    /// Depth along the view axis, +∞ on the background. Depths and normals are traced when they are first asked
    /// for; the scene's next pictures have them from the start.
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> PyValue<'py> {
        self.array(py, &self.hits(py)?.t)
    }

    /// Unit normals that face the camera, 0 on the background; shape (height, width, 3). Traced as `t` is.
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> PyValue<'py> {
        self.array(py, self.hits(py)?.normal.as_flattened())
    }

    /// The stage that decided each pixel: 0 f32, 1 f64, 2 exact arithmetic. It may differ between devices.
    #[getter]
    fn level<'py>(&self, py: Python<'py>) -> PyValue<'py> {
        self.array(py, &self.kept.hits.level)
    }

    /// How many pixels' centre rays each stage decided.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        counts_of(py, &self.kept.hits.counts)
    }

    /// One hash of the picture's exact content, as `kugelblitz digest` prints it: the same on every device
    /// with the kernel `certified`.
    fn digest(&self, py: Python<'_>) -> PyResult<String> {
        let Colors::Srgb8(colors) = &self.kept.colors else {
            return wrong_value("these colours were not kept");
        };
        if self.kept.coverage.is_some() {
            return wrong_value(
                "a transparent picture has no digest; render it with its background",
            );
        }
        let mut digest = Digest::new(&self.pixels, self.style.n_samples);
        digest.rows(self.hits(py)?, colors);
        Ok(digest.finish())
    }

    /// Writes a file; its ending (.png, .exr, .ppm, .npy) tells the format. `bits` (8 or 16) is for PNG and
    /// PPM; with `certificates`, EXR and NPY have the level of each pixel. Other numbers than bytes are
    /// painted anew.
    #[pyo3(signature = (path, *, bits = 8, certificates = false, progress = None))]
    fn save(
        &self,
        py: Python<'_>,
        path: PathBuf,
        bits: u8,
        certificates: bool,
        progress: Given<'_>,
    ) -> PyResult<()> {
        let bits = match bits {
            8 => ChannelBits::Eight,
            16 => ChannelBits::Sixteen,
            other => {
                return wrong_value(format!("bits: {other}, but a channel has 8 or 16"));
            }
        };
        let format = Format::from_path(&path).map_err(error::of("path"))?;
        let transparent = self.style.background != Background::Shown;
        let options = PictureOptions { bits, certificates, transparent };
        if certificates && !format.holds_numbers() {
            return wrong_value(format!(
                "certificates: {format} has no place for them; write .exr or .npy"
            ));
        }
        let plan = self.plan(format, options)?;
        let n_steps = n_steps(&self.pixels, self.style.n_samples, self.scene.get().of.is_lit());
        self.run(py, (progress, n_steps), |session, control| {
            let file = OutputFile::create(&path, format.needs_seek())?;
            let file = if plan.style == self.style {
                self.write(session, &plan, file, path.clone())?
            } else {
                session.set_camera(self.camera.clone());
                session.draw(&self.pixels, &plan, file, control)?.1
            };
            output::commit([file], control)
        })
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let transparent = self.style.background != Background::Shown;
        let options = PictureOptions { transparent, ..PictureOptions::default() };
        let (sink, name) = (Cursor::new(Vec::new()), PathBuf::from("picture"));
        let plan = self.plan(Format::Png, options)?;
        let png = self.run(py, (None, 0), |session, _| self.write(session, &plan, sink, name))?;
        Ok(PyBytes::new(py, png.get_ref()))
    }

    fn __repr__(&self) -> String {
        let Pixels { width, height, .. } = self.pixels;
        let n_hits = self.kept.hits.n_hits();
        format!("<Picture: {width}×{height} pixels, {n_hits} of them see an object>")
    }
}
