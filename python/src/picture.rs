//! A picture in memory.

use std::io::Cursor;
use std::path::PathBuf;

use kugelblitz::Session;
use kugelblitz::digest::Digest;
use kugelblitz::memory::Available;
use kugelblitz::output::{self, OutputFile};
use kugelblitz::picture::{Bits, Channel, Format, Image, PictureOptions, PictureWriter, Samples};
use kugelblitz::rays::Pixels;
use kugelblitz::render::{Kept, Plan, Sink, plan};
use kugelblitz::scene::Camera;
use kugelblitz::shade::{Background, Colors, Encoding, Style};
use kugelblitz::trace::{Hits, Kernel, Wants};
use numpy::{Element, PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBytes, PyDict};

use crate::error;
use crate::rays::counts_of;
use crate::scene::Scene;
use crate::session::Shared;
use crate::work;

/// A picture in memory: arrays, row by row from the top, and files of them.
///
/// A notebook shows it. Arrays are made when they are first asked for, and copies: changing one changes no
/// file.
#[pyclass(frozen, module = "kugelblitz")]
pub struct Picture {
    scene: Py<Scene>,
    device: String,
    kernel: Kernel,
    camera: Camera,
    pixels: Pixels,
    style: Style,
    kept: Kept,
    linear: PyOnceLock<Vec<[f32; 3]>>,
    srgb16: PyOnceLock<Vec<[u16; 3]>>,
    /// The hits with `t` and normals, where `kept` has none.
    traced: PyOnceLock<Hits>,
}

impl Picture {
    /// What a session of this device and kernel kept of these pixels of the camera's picture.
    pub fn new(
        scene: Py<Scene>,
        (device, kernel): (&str, Kernel),
        (camera, pixels): (Camera, Pixels),
        style: Style,
        kept: Kept,
    ) -> Picture {
        Picture {
            scene,
            device: device.into(),
            kernel,
            camera,
            pixels,
            style,
            kept,
            linear: PyOnceLock::new(),
            srgb16: PyOnceLock::new(),
            traced: PyOnceLock::new(),
        }
    }

    /// The hits with `t` and normals: traced anew when they are first wanted, unless they were kept.
    fn hits(&self, py: Python<'_>) -> PyResult<&Hits> {
        self.scene.get().keep_surfaces();
        let kept = &self.kept.hits;
        if kept.t.len() == kept.id.len() {
            return Ok(kept);
        }
        self.traced.get_or_try_init(py, || {
            let wants = Wants { surface: true, level: true };
            let session = self.session(py)?;
            work::run_with_session(py, None, 0, &session, |session, control| {
                session.hits(&self.pixels, wants, control)
            })
        })
    }

    fn session(&self, py: Python<'_>) -> PyResult<Shared> {
        self.scene.get().session(py, &self.device, self.kernel, self.pixels.len())
    }

    /// The colours in another encoding, painted anew.
    fn painted(&self, py: Python<'_>, encoding: Encoding) -> PyResult<Colors> {
        let background = match self.style.background {
            Background::Shown => Background::Shown,
            Background::LeftOut | Background::Black => Background::Black,
        };
        let style = Style { encoding, background, ..self.style };
        let session = self.session(py)?;
        let (kept, _) = work::run_with_session(py, None, 0, &session, |session, control| {
            session.keep(&self.pixels, style, Wants::default(), control)
        })?;
        Ok(kept.colors)
    }

    /// Its colours, ids, depths and normals as channels.
    pub fn image(&self, py: Python<'_>) -> PyResult<Image> {
        let [height, width] = self.shape();
        let Colors::Srgb8(colors) = &self.kept.colors else { return Err(no_colors()) };
        let Hits { id, t, normal, .. } = self.hits(py)?;
        let channel = |name: &str, samples| Channel { name: name.into(), samples };
        let byte = |c: usize| Samples::U8(colors.iter().map(|color| color[c]).collect());
        let part = |c: usize| Samples::F32(normal.iter().map(|normal| normal[c]).collect());
        let Pixels { x, y, image_width, image_height, .. } = self.pixels;
        Ok(Image {
            format: "picture",
            width,
            height,
            is_list: false,
            whole: [image_width as usize, image_height as usize],
            first: [x.into(), y.into()],
            channels: vec![
                channel("R", byte(0)),
                channel("G", byte(1)),
                channel("B", byte(2)),
                channel("id", Samples::U32(id.clone())),
                channel("Z", Samples::F32(t.clone())),
                channel("N.X", part(0)),
                channel("N.Y", part(1)),
                channel("N.Z", part(2)),
            ],
            texts: Vec::new(),
        })
    }

    /// How it becomes a file.
    fn plan(&self, format: Format, options: PictureOptions) -> PyResult<Plan> {
        let (n_samples, n_objects) = (self.style.n_samples, self.scene.get().of.n_objects());
        let plan = plan(format, options, n_samples, &self.pixels, n_objects, Available::now());
        Ok(Plan { epsilon: self.style.epsilon, ..plan.map_err(error::of("path"))? })
    }

    fn shape(&self) -> [usize; 2] {
        [self.pixels.height as usize, self.pixels.width as usize]
    }

    fn flat<'py, T: Element>(
        &self,
        py: Python<'py>,
        numbers: Vec<T>,
    ) -> PyResult<Bound<'py, PyArray2<T>>> {
        PyArray1::from_vec(py, numbers).reshape(self.shape())
    }

    fn vectors<'py, T: Element>(
        &self,
        py: Python<'py>,
        vectors: Vec<[T; 3]>,
    ) -> PyResult<Bound<'py, PyArray3<T>>> {
        let [height, width] = self.shape();
        PyArray1::from_vec(py, vectors.into_flattened()).reshape([height, width, 3])
    }

    /// Writes the picture as it is in memory.
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
            PictureWriter::create_with(format, options, &self.pixels, &metadata, sink, name)?;
        let Kept { colors, hits, coverage } = &self.kept;
        writer.band(colors, coverage.as_ref(), hits, self.pixels.height)?;
        writer.finish()
    }
}

#[pymethods]
impl Picture {
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
    fn rgb8<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        match &self.kept.colors {
            Colors::Srgb8(colors) => self.vectors(py, colors.clone()),
            Colors::Srgb16(_) | Colors::Linear(_) => Err(no_colors()),
        }
    }

    /// Linear colours, the nearest floats; shape (height, width, 3). They are painted when they are first
    /// asked for.
    #[getter]
    fn rgb<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        let colors =
            self.linear.get_or_try_init(py, || match self.painted(py, Encoding::Linear)? {
                Colors::Linear(colors) => Ok(colors),
                Colors::Srgb8(_) | Colors::Srgb16(_) => Err(no_colors()),
            })?;
        self.vectors(py, colors.clone())
    }

    /// Colours in sRGB with 16 bits a channel; shape (height, width, 3). They are painted when they are first
    /// asked for.
    #[getter]
    fn rgb16<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u16>>> {
        let colors =
            self.srgb16.get_or_try_init(py, || match self.painted(py, Encoding::Srgb16)? {
                Colors::Srgb16(colors) => Ok(colors),
                Colors::Srgb8(_) | Colors::Linear(_) => Err(no_colors()),
            })?;
        self.vectors(py, colors.clone())
    }

    /// The scene that it shows.
    #[getter]
    fn scene(&self, py: Python<'_>) -> Py<Scene> {
        self.scene.clone_ref(py)
    }

    /// The share of each pixel's samples that hit an object; `None` unless the picture is transparent.
    #[getter]
    fn alpha<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f32>>>> {
        let Some(coverage) = &self.kept.coverage else { return Ok(None) };
        let alpha = (0..self.pixels.len()).map(|pixel| coverage.alpha(pixel)).collect();
        self.flat(py, alpha).map(Some)
    }

    /// Object ids, 0 for the background.
    #[getter]
    fn id<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u32>>> {
        self.flat(py, self.kept.hits.id.clone())
    }

    /// Depth along the view axis, +∞ on the background. Depths and normals are traced when they are first asked
    /// for; the scene's next pictures have them from the start.
    #[getter]
    fn t<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        self.flat(py, self.hits(py)?.t.clone())
    }

    /// Unit normals that face the camera, 0 on the background; shape (height, width, 3). Traced as `t` is.
    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f32>>> {
        self.vectors(py, self.hits(py)?.normal.clone())
    }

    /// The stage that decided each pixel: 0 f32, 1 f64, 2 exact arithmetic. It may differ between devices.
    #[getter]
    fn level<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<u8>>> {
        self.flat(py, self.kept.hits.level.clone())
    }

    /// How many pixels' centre rays each stage decided.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        counts_of(py, self.kept.hits.counts)
    }

    /// One hash of the picture's exact content, as `kugelblitz digest` prints it: the same on every device
    /// with the kernel `certified`.
    fn digest(&self, py: Python<'_>) -> PyResult<String> {
        let Colors::Srgb8(colors) = &self.kept.colors else {
            return Err(no_colors());
        };
        if self.kept.coverage.is_some() {
            let message = "a transparent picture has no digest; render it with its background";
            return Err(PyValueError::new_err(message));
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
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<()> {
        let bits = match bits {
            8 => Bits::Eight,
            16 => Bits::Sixteen,
            other => {
                let message = format!("bits: {other}, but a channel has 8 or 16");
                return Err(PyValueError::new_err(message));
            }
        };
        let format = Format::from_path(&path).map_err(error::of("path"))?;
        let transparent = self.style.background != Background::Shown;
        let options = PictureOptions { bits, certificates, transparent };
        if certificates && matches!(format, Format::Png | Format::Ppm) {
            let message =
                format!("certificates: {format} has no place for them; write .exr or .npy");
            return Err(PyValueError::new_err(message));
        }
        let plan = self.plan(format, options)?;
        let n_steps = plan.n_steps(&self.pixels, self.scene.get().of.is_lit());
        let session = self.session(py)?;
        work::run_with_session(py, progress, n_steps, &session, |session, control| {
            let file = OutputFile::create(&path, format.needs_seek())?;
            let file = match plan.style() == self.style {
                true => self.write(session, &plan, file, path.clone())?,
                false => {
                    session.set_camera(self.camera.clone());
                    session.draw(&self.pixels, &plan, file, control)?.1
                }
            };
            output::commit([file], control)
        })
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let transparent = self.style.background != Background::Shown;
        let options = PictureOptions { transparent, ..PictureOptions::default() };
        let (sink, name) = (Cursor::new(Vec::new()), PathBuf::from("picture"));
        let (plan, session) = (self.plan(Format::Png, options)?, self.session(py)?);
        let png = work::run_with_session(py, None, 0, &session, |session, _| {
            self.write(session, &plan, sink, name)
        })?;
        Ok(PyBytes::new(py, png.get_ref()))
    }

    fn __repr__(&self) -> String {
        let Pixels { width, height, .. } = self.pixels;
        let n_hits = self.kept.hits.n_hits();
        format!("<Picture: {width}×{height} pixels, {n_hits} of them see an object>")
    }
}

fn no_colors() -> PyErr {
    PyValueError::new_err("these colours were not kept")
}
