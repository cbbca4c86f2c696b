//! The scene, and what is done with it.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};

use kugelblitz::Control;
use kugelblitz::device::rays_of_picture;
use kugelblitz::digest::scene_hash;
use kugelblitz::generate::{Distribution, Recipe};
use kugelblitz::lighting::{Background, Encoding, Style};
use kugelblitz::output::{self, OutputFile};
use kugelblitz::picture::hit_records;
use kugelblitz::query::{Hits, Kernel, Outputs, Rays};
use kugelblitz::render::n_steps;
use kugelblitz::scene::schema;
use kugelblitz::scene::{self, Coloring, SceneOverrides, compose_scene, parse_scene};
use kugelblitz::{Error, Session};
use kugelblitz_judge::cost::Cost;
use kugelblitz_judge::export::{self, Language};
use kugelblitz_judge::figure::legend_svg;
use kugelblitz_judge::show::{self, Entry, Show};
use kugelblitz_judge::verify::Verification;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::argument::{
    Crop, PixelArgument, SamplesArgument, Size, camera_of, named, one_ray, pixels_of,
    pixels_of_camera, rays_of,
};
use crate::camera::{FRAMING, PyCamera, framing};
use crate::drawing::{drawing, tinted};
use crate::error::{self, exception, wrong_value};
use crate::explain::{PyExplanation, explained};
use crate::given::{OF_SCENE, OF_SPHERES, change, named_map, spheres_of};
use crate::pickle::{PickledScene, state_of};
use crate::picture::{PyPicture, counts_of};
use crate::place;
use crate::session::Sessions;
use crate::table::{Given, Keywords, PyValue, to_python};
use crate::verdict::KernelOutcome;
use crate::work::{self, Steps};

/// Spheres, planes and their light.
///
/// Parameters
/// ----------
/// spheres : array of shape (N, 3) or (N, 4), optional
///     Centres, and radii in the fourth column; world units.
/// radius : number or array of shape (N,), optional
///     Radii, where `spheres` has none.
/// color : colour, or array of shape (N, 3) or (N, 4), or list of N names, optional
///     Colour of all spheres or of each: "#rrggbb", a name of CSS, floats from 0 to 1 or bytes (uint8), both in sRGB. Alpha must
///     be 1, or 255 in bytes.
/// color_by : array of shape (N,), optional
///     Numbers that a `colormap` turns into colours, over `range` (low, high) or over all of them; NaN gets `missing_color`.
///     `legend()` draws the map with its numbers.
/// colormap : name, or colormap of matplotlib, optional
///     "viridis" (default), "magma" and others, reversed with "_r"; or a function of numbers from 0 to 1 that returns colours,
///     which is sampled at 256 places.
/// names : list of names or None, or {row: name}, optional
///     What spheres are called in explanations.
/// planes : list of dicts, optional
///     Each with `point`, `normal`, `color` and perhaps `name`.
/// lights : list of dicts, optional
///     Each with `position` (a point, or "eye") or `direction`, and perhaps `color`, `intensity`, `shadows`.
/// sky : dict, optional
///     `intensity`, and perhaps `directions`.
/// ambient, background : colour, optional
///     Light from nowhere; what pixels show that see nothing.
/// camera : Camera, optional
///     The one that pictures have where no other is given; so are `size`, (columns, rows), and `samples`, N for
///     N x N a pixel.
/// color_space : "srgb" or "linear", optional
///     Colour space of all floats in colours; "srgb" by default. In linear space, bytes are divided by 255. `ambient` as a number
///     is a light intensity and is always linear.
///
/// Colours that a scene returns are linear: `colors`, and `rgb` of its pictures.
///
/// The scene keeps what was made for its pictures, the tree over its spheres above all, so that the next
/// camera needs no new one.
#[pyclass(frozen, name = "Scene", module = "kugelblitz")]
pub struct PyScene {
    pub of: Arc<scene::Scene>,
    /// How `color_by` became colours, where there is no file that it came from.
    coloring: Option<Coloring>,
    sessions: Sessions,
    /// Whether depths or normals of a picture were asked for.
    keeps_surfaces: AtomicBool,
}

impl From<scene::Scene> for PyScene {
    fn from(scene: scene::Scene) -> PyScene {
        PyScene::new_colored(scene, None)
    }
}

impl PyScene {
    /// A scene of spheres that got their colours so.
    pub fn new_colored(scene: scene::Scene, coloring: Option<Coloring>) -> PyScene {
        let (of, sessions) = (Arc::new(scene), Sessions::new());
        PyScene { of, coloring, sessions, keeps_surfaces: AtomicBool::new(false) }
    }

    /// How numbers became colours, of files and of arrays.
    pub fn colorings(&self) -> impl Iterator<Item = &Coloring> {
        let of_files = self.of.clouds.iter().filter_map(|cloud| cloud.coloring.as_ref());
        of_files.chain(&self.coloring)
    }

    /// Does `work` of so many rays and steps with the scene's session on a device.
    pub fn run<T: Send>(
        &self,
        py: Python<'_>,
        (device, kernel, n_rays): (&str, Kernel, usize),
        (progress, n_steps): (Given<'_>, u64),
        work: impl FnOnce(&mut Session, &Control) -> kugelblitz::Result<T> + Send,
    ) -> PyResult<T> {
        let device = place::device(py, device, kernel, self.of.spheres.len(), n_rays)?;
        let session = self.sessions.get(py, &self.of, device, kernel);
        work::run_with_session(py, progress, n_steps, &session, work)
    }

    /// Samples of a picture that is asked for so many.
    fn n_samples(&self, asked: Option<SamplesArgument>) -> scene::Samples {
        asked.map(|SamplesArgument(asked)| asked).or(self.of.samples).unwrap_or_default()
    }

    /// Has pictures keep depths and normals from now on: who wants them of one wants them of the next.
    pub fn keep_surfaces(&self) {
        self.keeps_surfaces.store(true, Ordering::Relaxed);
    }

    /// What pictures keep of their hits. Without a proof, only ids and depths of the same trace surely fit
    /// together.
    fn kept_of_hits(&self, kernel: Kernel) -> Outputs {
        let is_wanted = self.keeps_surfaces.load(Ordering::Relaxed);
        Outputs { surface: is_wanted || kernel != Kernel::Certified, level: true }
    }
}

/// The arguments of [`Scene::open`] beside [`FRAMING`].
const OF_DATA: [&str; 12] = [
    "radius",
    "color",
    "color_by",
    "color_space",
    "colormap",
    "range",
    "missing_color",
    "columns",
    "header",
    "missing",
    "frame",
    "samples",
];

#[pymethods]
impl PyScene {
    #[new]
    #[pyo3(
        signature = (spheres = None, **keys),
        text_signature = "(spheres=None, *, radius=None, color=None, color_by=None, colormap=None, \
                          range=None, missing_color=None, names=None, planes=None, lights=None, \
                          sky=None, ambient=None, background=None, camera=None, size=None, \
                          samples=None, color_space=None)"
    )]
    fn new(
        py: Python<'_>,
        spheres: Given<'_>,
        keys: Option<Bound<'_, PyDict>>,
    ) -> PyResult<PyScene> {
        let known = [&OF_SPHERES[..], &OF_SCENE, &["color_space"]].concat();
        let keys = Keywords::new(py, keys, &known)?;
        let (spheres, coloring) = spheres_of(py, spheres, &keys)?;
        let mut scene = scene::Scene { spheres, ..scene::Scene::default() };
        change(&mut scene, &keys)?;
        Ok(PyScene::new_colored(scene, coloring))
    }

    /// Reads a scene file (.toml), or makes a scene of data. Data get a camera that frames everything, light, and a
    /// radius if they have none. `notes` contains what was chosen.
    ///
    /// Formats of data: NumPy arrays (.npy), tables of text (.csv, .tsv and others), .xyz, and LAMMPS dumps, also
    /// compressed with gzip. The content decides, not the name.
    ///
    /// The following arguments are for data, or for the only [[spheres]] of a scene:
    ///
    /// radius : number, optional
    ///     Radius of all spheres, if the file has none.
    /// color : colour, optional
    ///     Colour of all spheres, if the file has none.
    /// color_by : name or place of a column, optional
    ///     Column that `colormap` (a name) turns into colours, over `range` (low, high); rows without a number get
    ///     `missing_color`.
    /// color_space : "srgb" or "linear", optional
    ///     Colour space of colours in the file, and of floats in `color` and `missing_color`; "srgb" by default.
    /// columns : dict, optional
    ///     Names or places (from 0) of columns, for example {"radius": "R"}. False ignores a column. A float is a
    ///     coordinate of all spheres: {"z": 0.0} for data in a plane.
    /// header : int, optional
    ///     Line that names the columns of a table, from 1.
    /// missing : "skip", optional
    ///     Leaves out rows without a coordinate or a radius.
    /// frame : int, optional
    ///     Frame of a file of several, from 0; -1 is the last one.
    ///
    /// `view`, `up`, `fov`, `height` and `margin` have the same meaning as in `Camera.frame`. `size` and `samples`
    /// replace the file's. `progress` is as for `trace`.
    #[staticmethod]
    #[pyo3(
        signature = (path, *, view = None, progress = None, **keys),
        text_signature = "(path, *, radius=None, color=None, color_by=None, color_space=None, \
                          colormap=None, range=None, missing_color=None, columns=None, header=None, \
                          missing=None, frame=None, view=None, up=None, fov=None, height=None, \
                          margin=None, size=None, samples=None, progress=None)"
    )]
    fn open(
        py: Python<'_>,
        path: PathBuf,
        view: Option<&str>,
        progress: Given<'_>,
        keys: Option<Bound<'_, PyDict>>,
    ) -> PyResult<PyScene> {
        let known = [&OF_DATA[..], &FRAMING].concat();
        let keys = Keywords::new(py, keys, &known)?;
        if keys.get("colormap").is_some() {
            let Some(map) = named_map(&keys)? else {
                return wrong_value(
                    "colormap: give a name; for another map, give an array to Scene(color_by=…)",
                );
            };
            keys.given.set_item("colormap", map.name())?;
        }
        let mut overrides = SceneOverrides {
            cloud: keys.section("", &[])?,
            samples: keys.value("samples", schema::samples)?,
            ..framing(view, &keys)?
        };
        // A file that needs nothing of this is only read: it may be of rays alone.
        overrides.needs_camera = overrides != SceneOverrides::default();
        let read = |control: &Control| {
            let composed = compose_scene(&path, &overrides, control)?;
            let mut scene = composed.scene;
            scene.notes.extend(composed.notes);
            Ok(scene)
        };
        if let Err(missing) = std::fs::metadata(&path) {
            return Err(exception(Error::Io { path, source: missing }, ""));
        }
        work::run_with_progress(py, progress, Steps::Bytes, read).map(PyScene::from)
    }

    /// A cloud of spheres made up from a seed, the same on every machine, with a camera: `distribution` is
    /// "uniform", "lattice" or "packing".
    #[staticmethod]
    #[pyo3(signature = (count, distribution = "uniform", *, seed = 0))]
    fn generate(py: Python<'_>, count: u64, distribution: &str, seed: u64) -> PyResult<PyScene> {
        let all = Distribution::ALL;
        let distribution = named("distribution", distribution, all, Distribution::name)?;
        let recipe = Recipe { distribution, count, seed };
        let made = work::run(py, |control| Ok(recipe.scene(control)))?;
        made.map(PyScene::from).map_err(error::of("count"))
    }

    /// The scene with some things changed: `camera`, `size`, `samples`, `planes`, `lights`, `sky`, `ambient` or
    /// `background`, as for `Scene`; None takes one away. The spheres are shared. `color_space` applies to
    /// floats in the new colours: "srgb" (default) or "linear".
    #[pyo3(
        signature = (**changes),
        text_signature = "($self, *, camera=..., size=..., samples=..., planes=..., lights=..., sky=..., \
                          ambient=..., background=..., color_space=None)"
    )]
    fn replace(&self, py: Python<'_>, changes: Option<Bound<'_, PyDict>>) -> PyResult<PyScene> {
        let mut scene = scene::Scene::clone(&self.of);
        let keys = Keywords::new(py, changes, &[&OF_SCENE[..], &["color_space"]].concat())?;
        change(&mut scene, &keys)?;
        Ok(PyScene::new_colored(scene, self.coloring.clone()))
    }

    /// Reads the text of a scene file; clouds are looked for from the folder of `path`.
    #[staticmethod]
    #[pyo3(
        signature = (text, path = PathBuf::from("scene.toml")),
        text_signature = "(text, path='scene.toml')"
    )]
    fn parse(py: Python<'_>, text: &str, path: PathBuf) -> PyResult<PyScene> {
        work::run(py, |_| parse_scene(text, &path)).map(PyScene::from)
    }

    /// Writes the scene into a `.toml` file, and many spheres into an `.npy` file beside it.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        work::run(py, |control| self.of.save(&path, control))
    }

    /// Number of spheres.
    #[getter]
    fn n_spheres(&self) -> usize {
        self.of.spheres.len()
    }

    /// Number of planes.
    #[getter]
    fn n_planes(&self) -> usize {
        self.of.planes.len()
    }

    /// Centres and radii: a copy, of shape (N, 4).
    #[getter]
    pub fn spheres<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = self.of.spheres.rows();
        PyArray1::from_slice(py, rows.as_flattened()).reshape([rows.len(), 4])
    }

    /// Linear colours of the spheres: a copy, of shape (N, 3). `Scene` takes them with `color_space="linear"`.
    #[getter]
    pub fn colors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let colors: Vec<[f64; 3]> = self.of.spheres.colors().map(|color| color.0).collect();
        let n = colors.len();
        PyArray1::from_vec(py, colors.into_flattened()).reshape([n, 3])
    }

    /// What the reader of its files chose or understood: sentences.
    #[getter]
    pub fn notes(&self) -> Vec<String> {
        self.of.notes.iter().map(|note| note.worded(error::argument)).collect()
    }

    /// Columns and rows that the scene asks for, if it does.
    #[getter]
    fn size(&self) -> Option<(u32, u32)> {
        self.of.image.map(|[width, height]| (width, height))
    }

    /// Samples across and down a pixel that the scene asks for, if it does.
    #[getter]
    fn samples(&self) -> Option<u32> {
        self.of.samples.map(scene::Samples::across)
    }

    /// Whether anything lights the objects; else they have their colours as they are.
    #[getter]
    fn is_lit(&self) -> bool {
        self.of.is_lit()
    }

    /// Which colours stand for which numbers: a `Drawing`, or `None` where nothing is coloured by numbers.
    fn legend<'py>(&self, py: Python<'py>) -> PyResult<Given<'py>> {
        legend_svg(self.colorings()).map(|svg| drawing(py, svg)).transpose()
    }

    /// One hash of what the scene holds, but for its camera, size, samples and names: pictures tell it in their
    /// metadata.
    fn hash(&self, py: Python<'_>) -> PyResult<String> {
        work::run(py, |_| Ok(scene_hash(&self.of)))
    }

    /// What the scene holds and what a picture of it takes: a dictionary with the keys of
    /// `kugelblitz info --json`.
    #[pyo3(signature = (camera = None, size = None))]
    fn check<'py>(
        &self,
        py: Python<'py>,
        camera: Option<&PyCamera>,
        size: Option<Size>,
    ) -> PyValue<'py> {
        let is_seen = camera.is_some() || self.of.camera.is_some() || self.n_spheres() > 0;
        let pixels = is_seen.then(|| pixels_of(py, &self.of, camera, size, None)).transpose()?;
        let cost = work::run(py, |control| Cost::new(&self.of, pixels.as_ref(), control))?;
        to_python(py, &cost)
    }

    /// Writes the scene for another renderer: `language` is "pov" (POV-Ray) or "tachyon". Returns the command
    /// that renders it.
    #[pyo3(signature = (path, language = "pov", camera = None, size = None))]
    fn export(
        &self,
        py: Python<'_>,
        path: PathBuf,
        language: &str,
        camera: Option<&PyCamera>,
        size: Option<Size>,
    ) -> PyResult<String> {
        let language = named("language", language, Language::ALL, Language::name)?;
        let pixels = pixels_of(py, &self.of, camera, size, None)?;
        work::run(py, |control| {
            let mut file = OutputFile::create(&path, false)?;
            export::write(language, &self.of, &pixels, &mut file).map_err(Error::io(&path))?;
            output::commit([file], control)
        })?;
        Ok(language.command(&path.display().to_string(), [pixels.width, pixels.height]))
    }

    /// One ray in numbers: of the pixel (column, row) of the camera's picture, or of `ray`, (origin, direction).
    ///
    /// `all` is for every object in place of those that matter; `lang` is "en" or "de"; `digits` are those of
    /// results in formulas. `samples` is as for `render`.
    #[pyo3(signature = (
        camera = None, pixel = None, *, ray = None, size = None, samples = None, all = false, lang = "en",
        digits = 6, device = "cpu"
    ))]
    fn explain(
        &self,
        py: Python<'_>,
        camera: Option<&PyCamera>,
        pixel: Option<PixelArgument>,
        ray: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
        size: Option<Size>,
        samples: Option<SamplesArgument>,
        all: bool,
        lang: &str,
        digits: usize,
        device: &str,
    ) -> PyResult<PyExplanation> {
        let ray = one_ray(py, &self.of, camera, size, pixel, ray)?;
        let scene = match samples.map(|SamplesArgument(samples)| samples) {
            samples @ Some(_) if samples != self.of.samples => {
                Arc::new(scene::Scene { samples, ..scene::Scene::clone(&self.of) })
            }
            _ => Arc::clone(&self.of),
        };
        explained(py, &scene, &ray, all, lang, digits, device)
    }

    /// Holds a kernel's picture, on a device and on the CPU, against exact arithmetic at `samples` pixels, drawn
    /// by `seed`: as many as take some seconds where no number is given. `kernel` may be "all".
    #[pyo3(signature = (
        camera = None, size = None, *, crop = None, samples = None, seed = 0, kernel = "certified",
        device = "auto", progress = None
    ))]
    fn verify<'py>(
        &self,
        py: Python<'py>,
        camera: Option<&PyCamera>,
        size: Option<Size>,
        crop: Option<Crop>,
        samples: Option<usize>,
        seed: u64,
        kernel: &str,
        device: &str,
        progress: Given<'py>,
    ) -> PyValue<'py> {
        let pixels = pixels_of(py, &self.of, camera, size, crop)?;
        let kernels = match kernel {
            "all" => Kernel::ALL.to_vec(),
            name => vec![place::kernel(name)?],
        };
        let n_samples = samples.map(NonZeroUsize::new);
        if n_samples == Some(None) {
            return wrong_value("samples: 0 pixels are nothing to compare; give 1 or more");
        }
        let verification = Verification::new(&self.of, &pixels, n_samples.flatten(), seed);
        let devices = place::devices(py, device, &kernels, self.n_spheres(), pixels.len())?;
        let has_gpu = devices.values().any(|device| device.facts().is_some());
        let steps = Steps::Rays(verification.n_steps(&kernels, has_gpu));
        let of = work::run_with_progress(py, progress, steps, |control| {
            verification.run(&kernels, |kernel| &devices[&kernel], control)
        })?;
        Ok(KernelOutcome::new(py, &of, seed)?.into_any())
    }

    /// The digest of a picture, band by band: the same on every device, and that of `render(…).digest()`.
    #[pyo3(signature = (camera = None, size = None, *, samples = None, crop = None, device = "auto", progress = None))]
    fn digest(
        &self,
        py: Python<'_>,
        camera: Option<&PyCamera>,
        size: Option<Size>,
        samples: Option<SamplesArgument>,
        crop: Option<Crop>,
        device: &str,
        progress: Given<'_>,
    ) -> PyResult<String> {
        let pixels = pixels_of(py, &self.of, camera, size, crop)?;
        let n_samples = self.n_samples(samples);
        let n_steps = n_steps(&pixels, n_samples, self.of.is_lit());
        let on = (device, Kernel::Certified, pixels.len());
        self.run(py, on, (progress, n_steps), |session, control| {
            session.digest(&pixels, n_samples, control)
        })
    }

    /// What a picture shows beside colours, as colours for the eye: "depth", "normal", "id", "discriminant",
    /// "error", "stage" and others.
    #[pyo3(signature = (
        what, camera = None, size = None, *, crop = None, device = "auto", kernel = "certified",
        progress = None
    ))]
    fn show<'py>(
        &self,
        py: Python<'py>,
        what: &str,
        camera: Option<&PyCamera>,
        size: Option<Size>,
        crop: Option<Crop>,
        device: &str,
        kernel: &str,
        progress: Given<'py>,
    ) -> PyValue<'py> {
        let all = Show::ALL.into_iter().filter(|show| *show != Show::Color);
        let show = named("what", what, all, Show::name)?;
        let kernel = place::kernel(kernel)?;
        let pixels = pixels_of(py, &self.of, camera, size, crop)?;
        let (on, n_steps) = ((device, kernel, pixels.len()), show::n_steps(show, &pixels));
        let (shown, colors) = self.run(py, on, (progress, n_steps), |session, control| {
            show::keep(session, show, &pixels, control)
        })?;
        let entry = |entry: Entry| (scene::hex(entry.color), entry.meaning, entry.pixels);
        let legend = shown.legend.into_iter().map(entry).collect();
        tinted(py, [pixels.width, pixels.height], &colors, legend)
    }

    /// The camera of the scene's file, if it has one.
    #[getter]
    fn camera(&self) -> Option<PyCamera> {
        self.of.camera.clone().map(|of_scene| PyCamera { of_scene })
    }

    /// The name of the object with this id, if it has one.
    fn name(&self, id: u32) -> Option<&str> {
        self.of.name(id)
    }

    /// The hits of any rays, as `Hits`.
    ///
    /// `origins` and `directions` have shape (N, 3); directions have any length but zero. `device` is "auto",
    /// "gpu", "cpu" or a part of an adapter's name; `kernel` is "certified", "double", "stable" or "lecture".
    /// `progress` is True for a bar of tqdm, a bar like one, or a callable that takes the steps done and their
    /// number.
    #[pyo3(signature = (origins, directions, *, device = "auto", kernel = "certified", progress = None))]
    fn trace<'py>(
        &self,
        py: Python<'py>,
        origins: &Bound<'py, PyAny>,
        directions: &Bound<'py, PyAny>,
        device: &str,
        kernel: &str,
        progress: Given<'py>,
    ) -> PyValue<'py> {
        let kernel = place::kernel(kernel)?;
        let rays = rays_of(origins, directions)?;
        let n_rays = rays.len();
        let rays = Rays::List(rays);
        let wants = Outputs { surface: true, level: true };
        let trace = |session: &mut Session, control: &Control| {
            let mut hits = Hits::default();
            session.trace(&rays, wants, control, &mut hits)?;
            Ok((hit_records(&hits), hits.counts))
        };
        let (records, counts) =
            self.run(py, (device, kernel, n_rays), (progress, n_rays as u64), trace)?;
        let records = PyArray1::from_vec(py, records);
        py.import("kugelblitz._hits")?.call_method1("hits", (records, counts_of(py, &counts)?))
    }

    /// Draws a picture into memory.
    ///
    /// `camera` is the scene file's own unless one is given; without any, all spheres are framed as by
    /// `Camera.frame`. `size` is (width, height) in pixels, `samples` N for N x N a pixel, `crop` (left column, top
    /// row, width, height). With `transparent` the background is left out. `epsilon` is the distance from a surface
    /// at which shadow rays start, for kernels without a proof. `device`, `kernel` and `progress` are as for `trace`.
    #[pyo3(signature = (
        camera = None, size = None, *, samples = None, crop = None, transparent = false,
        device = "auto", kernel = "certified", epsilon = 0.0, progress = None
    ))]
    fn render(
        slf: &Bound<'_, PyScene>,
        py: Python<'_>,
        camera: Option<&PyCamera>,
        size: Option<Size>,
        samples: Option<SamplesArgument>,
        crop: Option<Crop>,
        transparent: bool,
        device: &str,
        kernel: &str,
        epsilon: f64,
        progress: Given<'_>,
    ) -> PyResult<PyPicture> {
        let this = slf.get();
        let kernel = place::kernel(kernel)?;
        if !(epsilon.is_finite() && epsilon >= 0.0) {
            return wrong_value(format!("epsilon: {epsilon:?} is no distance, 0 or more"));
        }
        if epsilon != 0.0 && kernel == Kernel::Certified {
            return wrong_value(
                "epsilon: certified decides exactly what is in a light's way and needs none; leave it \
                 out, or choose another kernel",
            );
        }
        let camera = camera_of(py, &this.of, camera, size)?;
        let pixels = pixels_of_camera(&this.of, &camera, size, crop)?;
        let n_samples = this.n_samples(samples);
        let background = if transparent { Background::LeftOut } else { Background::Shown };
        let style = Style { encoding: Encoding::Srgb8, n_samples, epsilon, background };
        let n_rays = rays_of_picture(&this.of, pixels.len(), n_samples);
        let n_steps = n_steps(&pixels, n_samples, this.of.is_lit());
        let wants = this.kept_of_hits(kernel);
        let (kept, _) =
            this.run(py, (device, kernel, n_rays), (progress, n_steps), |session, control| {
                session.keep(&pixels, style, wants, control)
            })?;
        Ok(PyPicture {
            scene: slf.clone().unbind(),
            device: device.into(),
            kernel,
            camera,
            pixels,
            style,
            kept,
            linear: OnceLock::new(),
            srgb16: OnceLock::new(),
            traced: OnceLock::new(),
        })
    }

    /// For pickle: rows, colours, names, the rest as the text of a scene file, and how numbers became colours.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, PickledScene<'py>)> {
        Ok((py.import("kugelblitz._kugelblitz")?.getattr("scene_of_state")?, state_of(py, self)?))
    }

    fn __repr__(&self) -> String {
        let scene = &self.of;
        let light = if scene.is_lit() { ", lit" } else { "" };
        format!("<Scene: {} spheres, {} planes{light}>", scene.spheres.len(), scene.planes.len())
    }
}
