//! The scene, and what is done with it.

use std::collections::HashMap;
use std::path::PathBuf;
use std::process;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use glam::DVec3;
use kugelblitz::Session;
use kugelblitz::device::Device;
use kugelblitz::rays::{Pixels, View, hit_records};
use kugelblitz::render::n_steps;
use kugelblitz::scene::{self, Color, ImageSize, Spheres, parse_scene, read_scene_with};
use kugelblitz::shade::{Background, Encoding, Style};
use kugelblitz::trace::{Hits, Kernel, Ray, Rays, StageCounts, Wants};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use toml::Value;

use crate::array::Numbers;
use crate::camera::Camera;
use crate::error;
use crate::picture::Picture;
use crate::place;
use crate::table::{scene_of, value};
use crate::work;

/// Spheres, planes and their light.
///
/// Parameters
/// ----------
/// spheres : array of shape (N, 3) or (N, 4), optional
///     Centres, and radii in the fourth column; world units.
/// radius : number or array of shape (N,), optional
///     Radii, where `spheres` has none.
/// color : colour, or array of shape (N, 3), optional
///     Of all spheres or of each: "#rrggbb", linear floats from 0 to 1, or bytes (uint8) in sRGB.
/// planes : list of dicts, optional
///     Each with `point`, `normal`, `color` and perhaps `name`.
/// lights : list of dicts, optional
///     Each with `position` (a point, or "eye") or `direction`, and perhaps `color`, `intensity`, `shadows`.
/// sky : dict, optional
///     `intensity`, and perhaps `directions`.
/// ambient, background : colour, optional
///     Light from nowhere; what pixels show that see nothing.
///
/// The scene keeps what was made for its pictures, the tree over its spheres above all, so that the next
/// camera needs no new one.
#[pyclass(frozen, module = "kugelblitz")]
pub struct Scene {
    pub of: Arc<scene::Scene>,
    sessions: Mutex<Sessions>,
}

/// A session that several threads may ask for.
pub type Shared = Arc<Mutex<Session>>;

/// Sessions by the device's name and the kernel, and the process that they are of.
#[derive(Default)]
struct Sessions {
    process: u32,
    of: HashMap<(String, Kernel), Shared>,
}

/// A session for work, whatever a panic left of it.
pub fn lock(session: &Shared) -> MutexGuard<'_, Session> {
    session.lock().unwrap_or_else(PoisonError::into_inner)
}

impl From<scene::Scene> for Scene {
    fn from(scene: scene::Scene) -> Scene {
        Scene { of: Arc::new(scene), sessions: Mutex::default() }
    }
}

impl Scene {
    /// The session for so many rays.
    fn session(
        &self,
        py: Python<'_>,
        device: &str,
        kernel: Kernel,
        n_rays: usize,
    ) -> PyResult<Shared> {
        let device = place::device(py, device, kernel, self.of.spheres.len(), n_rays)?;
        let mut sessions = self.sessions.lock().unwrap_or_else(PoisonError::into_inner);
        if sessions.process != process::id() {
            // Those of a process that forked this one can't be ended from here.
            std::mem::forget(std::mem::take(&mut *sessions));
            sessions.process = process::id();
        }
        let name = match &device {
            Device::Cpu => String::new(),
            Device::Gpu(gpu) => gpu.facts.name.clone(),
        };
        let make = || Arc::new(Mutex::new(Session::new(Arc::clone(&self.of), device, kernel)));
        Ok(Arc::clone(sessions.of.entry((name, kernel)).or_insert_with(make)))
    }

    /// The pixels of a picture, or of a part of it.
    fn pixels(
        &self,
        camera: Option<&Camera>,
        size: Option<(u32, u32)>,
        crop: Option<(u32, u32, u32, u32)>,
    ) -> PyResult<Pixels> {
        let camera = match (camera, &self.of.camera) {
            (Some(camera), _) => &camera.of_scene,
            (None, Some(camera)) => camera,
            (None, None) => {
                let message =
                    "camera: the scene has none; give one, e.g. Camera((0, 1, 6), (0, 0, 0))";
                return Err(PyValueError::new_err(message));
            }
        };
        let of_scene = self.of.image.map(|image| (image.width, image.height));
        let (width, height) = size.or(of_scene).unwrap_or((1280, 720));
        let most = ImageSize::MAX_SIDE;
        if !(1..=most).contains(&width) || !(1..=most).contains(&height) {
            return Err(PyValueError::new_err(format!(
                "size: ({width}, {height}), but a picture has 1 to {most} pixels a side"
            )));
        }
        let whole = Pixels::whole(View::new(camera), width, height);
        let Some((x, y, width, height)) = crop else { return Ok(whole) };
        let part = Pixels { x, y, width, height, ..whole };
        if part.is_empty() || !part.is_in_picture() {
            return Err(PyValueError::new_err(format!(
                "crop: ({x}, {y}, {width}, {height}) is not a part of the picture of {}x{} pixels",
                part.image_width, part.image_height
            )));
        }
        Ok(part)
    }
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (
        spheres = None, *, radius = None, color = None, planes = None, lights = None, sky = None,
        ambient = None, background = None
    ))]
    #[allow(clippy::too_many_arguments, reason = "Python's arguments have names")]
    fn new(
        py: Python<'_>,
        spheres: Option<&Bound<'_, PyAny>>,
        radius: Option<&Bound<'_, PyAny>>,
        color: Option<&Bound<'_, PyAny>>,
        planes: Option<&Bound<'_, PyAny>>,
        lights: Option<&Bound<'_, PyAny>>,
        sky: Option<&Bound<'_, PyAny>>,
        ambient: Option<&Bound<'_, PyAny>>,
        background: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Scene> {
        let mut scene = scene::Scene::default();
        if let Some(spheres) = spheres {
            scene.spheres = spheres_of(py, spheres, radius, color)?;
        } else if radius.is_some() || color.is_some() {
            return Err(PyValueError::new_err(
                "radius, color: there are no spheres that they are of",
            ));
        }
        for (n, plane) in each("planes", planes)?.into_iter().enumerate() {
            let subject = format!("planes[{n}]");
            let table = Value::Array(vec![value(&subject, &plane)?]);
            scene.planes.extend(scene_of(&subject, "plane", table)?.planes);
        }
        for (n, light) in each("lights", lights)?.into_iter().enumerate() {
            let subject = format!("lights[{n}]");
            let table = Value::Array(vec![value(&subject, &light)?]);
            scene.lights.extend(scene_of(&subject, "light", table)?.lights);
        }
        if let Some(sky) = sky {
            scene.sky = scene_of("sky", "sky", value("sky", sky)?)?.sky;
        }
        if let Some(ambient) = ambient {
            scene.ambient = scene_of("ambient", "ambient", value("ambient", ambient)?)?.ambient;
        }
        if let Some(background) = background {
            scene.background = color_of("background", background)?;
        }
        Ok(scene.into())
    }

    /// Reads a scene file (TOML) and the clouds that it names.
    #[staticmethod]
    #[pyo3(signature = (path, *, progress = None))]
    fn open(py: Python<'_>, path: PathBuf, progress: Option<&Bound<'_, PyAny>>) -> PyResult<Scene> {
        work::run(py, progress, 0, |control| read_scene_with(&path, control)).map(Scene::from)
    }

    /// Reads the text of a scene file; clouds are looked for from the folder of `path`.
    #[staticmethod]
    #[pyo3(signature = (text, path = PathBuf::from("scene.toml")))]
    fn parse(py: Python<'_>, text: &str, path: PathBuf) -> PyResult<Scene> {
        work::run(py, None, 0, |_| parse_scene(text, &path)).map(Scene::from)
    }

    /// Writes the scene into a `.toml` file, and many spheres into an `.npy` file beside it.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        work::run(py, None, 0, |control| self.of.save(&path, control))
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
    fn spheres<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = self.of.spheres.rows();
        PyArray1::from_slice(py, rows.as_flattened()).reshape([rows.len(), 4])
    }

    /// Linear colours of the spheres: a copy, of shape (N, 3).
    #[getter]
    fn colors<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let colors: Vec<[f64; 3]> = self.of.spheres.colors().map(|color| color.0).collect();
        let n = colors.len();
        PyArray1::from_vec(py, colors.into_flattened()).reshape([n, 3])
    }

    /// The camera of the scene's file, if it has one.
    #[getter]
    fn camera(&self) -> Option<Camera> {
        self.of.camera.clone().map(|of_scene| Camera { of_scene })
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
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let kernel = place::kernel(kernel)?;
        let rays = rays_of(origins, directions)?;
        let n_rays = rays.len();
        let session = self.session(py, device, kernel, n_rays)?;
        let rays = Rays::List(rays);
        let wants = Wants { surface: true, level: true };
        let (records, counts) = work::run_with_progress(py, progress, n_rays as u64, |control| {
            let mut hits = Hits::default();
            lock(&session).trace(&rays, wants, control, &mut hits)?;
            Ok((hit_records(&hits), hits.counts))
        })?;
        let records = PyArray1::from_vec(py, records);
        py.import("kugelblitz._hits")?.call_method1("hits", (records, counts_of(py, counts)?))
    }

    /// Draws a picture into memory.
    ///
    /// `camera` is the scene file's own unless one is given, `size` (width, height) in pixels, `samples` N for
    /// N x N a pixel, `crop` (left column, top row, width, height). With `transparent` the background is left
    /// out. `epsilon` is how far from a surface shadow rays start, for kernels without a proof. `device`,
    /// `kernel` and `progress` are as for `trace`.
    #[pyo3(signature = (
        camera = None, size = None, *, samples = None, crop = None, transparent = false,
        device = "auto", kernel = "certified", epsilon = 0.0, progress = None
    ))]
    #[allow(clippy::too_many_arguments, reason = "Python's arguments have names")]
    fn render(
        &self,
        py: Python<'_>,
        camera: Option<&Camera>,
        size: Option<(u32, u32)>,
        samples: Option<u32>,
        crop: Option<(u32, u32, u32, u32)>,
        transparent: bool,
        device: &str,
        kernel: &str,
        epsilon: f64,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Picture> {
        let kernel = place::kernel(kernel)?;
        if !(epsilon.is_finite() && epsilon >= 0.0) {
            return Err(PyValueError::new_err(format!(
                "epsilon: {epsilon:?} is no distance, 0 or more"
            )));
        }
        if epsilon != 0.0 && kernel == Kernel::Certified {
            return Err(PyValueError::new_err(
                "epsilon: certified decides exactly what is in a light's way and needs none; leave it \
                 out, or choose another kernel",
            ));
        }
        let pixels = self.pixels(camera, size, crop)?;
        let n_samples = samples.or(self.of.samples).unwrap_or(1);
        let background = if transparent { Background::LeftOut } else { Background::Shown };
        let style = Style { encoding: Encoding::Srgb8, n_samples, epsilon, background };
        let session = self.session(py, device, kernel, pixels.len())?;
        let n_steps = n_steps(&pixels, n_samples, self.of.is_lit());
        let (kept, _) = work::run_with_progress(py, progress, n_steps, |control| {
            lock(&session).keep(&pixels, style, Wants { surface: true, level: true }, control)
        })?;
        Ok(Picture::new(Arc::clone(&self.of), session, pixels, style, kept))
    }

    /// For pickle: rows, colours, names, and the rest as the text of a scene file.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, State<'py>)> {
        let names = (0..self.of.spheres.len())
            .filter_map(|index| Some((index as u32, self.of.spheres.name(index)?.to_string())));
        let names = if self.of.spheres.has_names() { names.collect() } else { HashMap::new() };
        let state = (self.spheres(py)?, self.colors(py)?, names, self.of.text_without_spheres());
        Ok((py.import("kugelblitz._pickle")?.getattr("scene_of_state")?, state))
    }

    /// A scene of what [`Scene::__reduce__`] gave.
    #[staticmethod]
    fn _of_state(
        py: Python<'_>,
        rows: &Bound<'_, PyAny>,
        colors: &Bound<'_, PyAny>,
        names: HashMap<u32, String>,
        text: &str,
    ) -> PyResult<Scene> {
        let mut scene = parse_scene(text, "a pickled scene".as_ref()).map_err(error::of(""))?;
        scene.spheres = spheres_of(py, rows, None, Some(colors))?;
        names.into_iter().for_each(|(index, name)| scene.spheres.set_name(index, name));
        Ok(scene.into())
    }

    fn __repr__(&self) -> String {
        let scene = &self.of;
        let light = if scene.is_lit() { ", lit" } else { "" };
        format!("<Scene: {} spheres, {} planes{light}>", scene.spheres.len(), scene.planes.len())
    }
}

/// See [`Scene::__reduce__`].
type State<'py> =
    (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, HashMap<u32, String>, String);

/// The entries of a list argument.
fn each<'py>(name: &str, given: Option<&Bound<'py, PyAny>>) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let Some(given) = given else { return Ok(Vec::new()) };
    if given.is_instance_of::<PyDict>() || given.is_instance_of::<PyString>() {
        let message = format!("{name}: give a list of dictionaries, also for one");
        return Err(PyTypeError::new_err(message));
    }
    let entries = given
        .try_iter()
        .map_err(|_| PyTypeError::new_err(format!("{name}: give a list of dictionaries")))?;
    entries.collect()
}

fn color_of(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Color> {
    Ok(scene_of(name, "background", value(name, given)?)?.background)
}

fn spheres_of(
    py: Python<'_>,
    spheres: &Bound<'_, PyAny>,
    radius: Option<&Bound<'_, PyAny>>,
    color: Option<&Bound<'_, PyAny>>,
) -> PyResult<Spheres> {
    let expected = "centres are (N, 3), and with radii (N, 4)";
    let spheres = Numbers::new("spheres", spheres)?;
    let n = spheres.shape().first().copied().unwrap_or(0);
    let rows: Vec<[f64; 4]> = match (spheres.shape(), radius) {
        ([_, 4], None) => spheres.table(4, expected)?.map(py, "spheres", |_, row| row)?,
        ([_, 4], Some(_)) => {
            return Err(PyValueError::new_err(
                "radius: `spheres` has radii already, in its fourth column; leave one of them out",
            ));
        }
        ([_, 3], Some(radius)) => {
            let radii = Numbers::new("radius", radius)?;
            let radii = match radii.shape() {
                [] => Radii::One(radius.extract()?),
                [length] if *length == n => Radii::Each(radii.list("one radius for each sphere")?),
                _ => return Err(radii.wrong_shape(&format!("there are {n} spheres"))),
            };
            spheres
                .table(3, expected)?
                .map(py, "spheres", |row, [x, y, z]| [x, y, z, radii.of(row)])?
        }
        ([_, 3], None) => {
            return Err(PyValueError::new_err(
                "radius: `spheres` has three columns, so give the radius of all, or one of each",
            ));
        }
        _ => return Err(spheres.wrong_shape(expected)),
    };
    let spheres = py.detach(|| Spheres::from_rows(rows)).map_err(error::of("spheres"))?;
    let Some(color) = color else { return Ok(spheres) };
    let one_for_all =
        color.is_instance_of::<PyString>() || { Numbers::new("color", color)?.shape().len() == 1 };
    if one_for_all {
        return spheres.with_color(color_of("color", color)?).map_err(error::of("color"));
    }
    let colors = Numbers::new("color", color)?;
    let is_bytes = colors.is_bytes;
    let colors =
        colors.table(3, "colours are (N, 3)")?.map(py, "color", |_, row| match is_bytes {
            true => Color::from_srgb8(row.map(|byte| byte as u8)),
            false => Color(row),
        })?;
    spheres.with_colors(colors).map_err(error::of("color"))
}

/// Radii of spheres.
enum Radii {
    One(f64),
    Each(Vec<f64>),
}

impl Radii {
    fn of(&self, row: usize) -> f64 {
        match self {
            Radii::One(radius) => *radius,
            Radii::Each(radii) => radii[row],
        }
    }
}

fn rays_of(origins: &Bound<'_, PyAny>, directions: &Bound<'_, PyAny>) -> PyResult<Vec<Ray>> {
    let py = origins.py();
    let origins = Numbers::new("origins", origins)?;
    let directions = Numbers::new("directions", directions)?;
    let of_origins = origins.table(3, "origins are (N, 3)")?;
    let of_directions = directions.table(3, "directions are (N, 3)")?;
    if of_origins.len() != of_directions.len() {
        let expected = format!("`origins` has {} rows", of_origins.len());
        return Err(directions.wrong_shape(&expected));
    }
    let ray = |row, origin| {
        let direction = of_directions.row(row);
        Ray { origin: DVec3::from_array(origin), direction: DVec3::from_array(direction) }
    };
    let rays = of_origins.map(py, "rays", ray)?;
    match rays.iter().position(|ray| ray.direction == DVec3::ZERO) {
        None => Ok(rays),
        Some(row) => Err(PyValueError::new_err(format!(
            "directions: row {row} (counted from 0) is (0, 0, 0), which points nowhere"
        ))),
    }
}

/// A dictionary of how many rays each stage decided.
pub fn counts_of(py: Python<'_>, counts: StageCounts) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("f32", counts.f32)?;
    dict.set_item("f64", counts.f64)?;
    dict.set_item("exact", counts.exact)?;
    Ok(dict)
}
