//! The scene, and what is done with it.

use std::collections::{BTreeMap, HashMap};
use std::ffi::CString;
use std::path::PathBuf;
use std::process;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;
use kugelblitz::control::Control;
use kugelblitz::cost::Cost;
use kugelblitz::device::{Device, rays_of_picture};
use kugelblitz::digest::scene_hash;
use kugelblitz::explain;
use kugelblitz::export::{self, Language};
use kugelblitz::generate::{Distribution, Recipe};
use kugelblitz::judge::Conventions;
use kugelblitz::output::{self, OutputFile};
use kugelblitz::rays::{Pixels, View, hit_records};
use kugelblitz::render::n_steps;
use kugelblitz::scene::{
    self, Color, ColorMap, Coloring, DataWishes, ImageSize, Light, Paint, Plane, Sky, Spheres,
    Wishes, compose_scene, is_cloud_file, parse_scene, read_scene_with, svg_of_colorings,
};
use kugelblitz::shade::{Background, Encoding, Style};
use kugelblitz::show::{self, Entry, Show};
use kugelblitz::trace::{Hits, Kernel, Ray, Rays, StageCounts, Wants};
use kugelblitz::{Error, Session};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::exceptions::{PyTypeError, PyUserWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};
use toml::Value;

use crate::argument::{Crop, Pixel, Size, Vector};
use crate::array::Numbers;
use crate::camera::{Camera, direction, finite, lens, usable_margin, usable_size, viewpoint};
use crate::drawing::{Drawing, Tinted};
use crate::error::{self, NoAdapterError};
use crate::explain::Explanation;
use crate::judge::{self, Judgement};
use crate::picture::Picture;
use crate::place;
use crate::session::Shared;
use crate::table::{scene_of, to_python, value};
use crate::verify::{Asked, Verification};
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
/// color_by : array of shape (N,), optional
///     Numbers that a `colormap` ("viridis", "magma", …; "_r" behind it turns it around) makes colours of, over
///     `range` (low, high) or over all of them; NaN gets `missing_color`. `legend()` shows which is which.
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
///     The one that pictures have where no other is given.
///
/// The scene keeps what was made for its pictures, the tree over its spheres above all, so that the next
/// camera needs no new one.
#[pyclass(frozen, module = "kugelblitz")]
pub struct Scene {
    pub of: Arc<scene::Scene>,
    /// How `color_by` became colours, where there is no file that it came from.
    coloring: Option<Coloring>,
    sessions: Mutex<Sessions>,
    /// Whether depths or normals of a picture were asked for.
    keeps_surfaces: AtomicBool,
}

/// Sessions by the device's name and the kernel, and the process that they are of.
#[derive(Default)]
struct Sessions {
    process: u32,
    of: HashMap<(String, Kernel), Shared>,
}

impl From<scene::Scene> for Scene {
    fn from(scene: scene::Scene) -> Scene {
        Scene {
            of: Arc::new(scene),
            coloring: None,
            sessions: Mutex::default(),
            keeps_surfaces: AtomicBool::new(false),
        }
    }
}

impl Scene {
    /// The session for so many rays.
    pub fn session(
        &self,
        py: Python<'_>,
        device: &str,
        kernel: Kernel,
        n_rays: usize,
    ) -> PyResult<Shared> {
        let device = place::device(py, device, kernel, self.of.spheres.len(), n_rays)?;
        let mut sessions = self.sessions.lock().unwrap_or_else(PoisonError::into_inner);
        if sessions.process != process::id() {
            *sessions = Sessions { process: process::id(), of: HashMap::new() };
        }
        let name = match &device {
            Device::Cpu => String::new(),
            Device::Gpu(gpu) => gpu.facts.name.clone(),
        };
        let make = || Shared::new(Session::new(Arc::clone(&self.of), device, kernel));
        Ok(sessions.of.entry((name, kernel)).or_insert_with(make).clone())
    }

    /// Has pictures keep depths and normals from now on: who wants them of one wants them of the next.
    pub fn keep_surfaces(&self) {
        self.keeps_surfaces.store(true, Ordering::Relaxed);
    }

    /// What pictures keep of their hits. Without a proof, only ids and depths of the same trace surely fit
    /// together.
    fn kept_of_hits(&self, kernel: Kernel) -> Wants {
        let is_wanted = self.keeps_surfaces.load(Ordering::Relaxed);
        Wants { surface: is_wanted || kernel != Kernel::Certified, level: true }
    }
}

/// The pixels of a picture, or of a part of it.
pub fn pixels_of(
    scene: &scene::Scene,
    camera: Option<&Camera>,
    size: Option<Size>,
    crop: Option<Crop>,
) -> PyResult<Pixels> {
    let camera = match (camera, &scene.camera) {
        (Some(camera), _) => &camera.of_scene,
        (None, Some(camera)) => camera,
        (None, None) => {
            let message = "camera: the scene has none; give one, e.g. Camera((0, 1, 6), (0, 0, 0)), or \
                           Camera.frame(scene)";
            return Err(PyValueError::new_err(message));
        }
    };
    let of_scene = scene.image.map(|image| Size([image.width, image.height]));
    let [width, height] = usable_size(size.or(of_scene).unwrap_or(Size([1280, 720])))?;
    let whole = Pixels::whole(View::new(camera), width, height);
    let Some(Crop([x, y, width, height])) = crop else { return Ok(whole) };
    let part = Pixels { x, y, width, height, ..whole };
    if part.is_empty() || !part.is_in_picture() {
        return Err(PyValueError::new_err(format!(
            "crop: ({x}, {y}, {width}, {height}) is not a part of the picture of {}x{} pixels",
            part.image_width, part.image_height
        )));
    }
    Ok(part)
}

/// Warns the user.
pub fn warn(py: Python<'_>, text: &str) -> PyResult<()> {
    let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &text, 2)
}

/// One ray in numbers; on a device as well, where there is one.
pub fn explained(
    py: Python<'_>,
    scene: &Arc<scene::Scene>,
    ray: &Rays,
    all: bool,
    lang: &str,
    digits: usize,
    device: Option<&dyn Fn(Kernel) -> PyResult<Device>>,
) -> PyResult<Explanation> {
    let style = explain::Style {
        limit: (!all).then_some(explain::DEFAULT_OBJECTS),
        lang: crate::explain::lang(lang)?,
        digits,
    };
    let mut devices = Vec::new();
    for kernel in Kernel::ALL {
        match device.map(|device| device(kernel)).transpose() {
            Ok(device) => devices.extend(device.map(|device| (kernel, device))),
            // A device may lack the types of a kernel.
            Err(error)
                if kernel != Kernel::Certified && error.is_instance_of::<NoAdapterError>(py) => {}
            Err(error) => return Err(error),
        }
    }
    let of = work::run(py, None, 0, |control| {
        let mut of = explain::explain_as(scene, ray, &style)?;
        control.check()?;
        of.add_device(scene, ray, |prepared, wants| {
            match devices.iter().find(|(kernel, _)| *kernel == prepared.kernel) {
                Some((_, device @ Device::Gpu(_))) => {
                    Ok(Some(device.tracer(prepared, wants)?.tracer))
                }
                Some((_, Device::Cpu)) | None => Ok(None),
            }
        })?;
        Ok(of)
    })?;
    Ok(Explanation { of })
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (
        spheres = None, *, radius = None, color = None, color_by = None, colormap = None, range = None,
        missing_color = None, names = None, planes = None, lights = None, sky = None, ambient = None,
        background = None, camera = None
    ))]
    #[allow(clippy::too_many_arguments, reason = "Python's arguments have names")]
    fn new(
        py: Python<'_>,
        spheres: Option<&Bound<'_, PyAny>>,
        radius: Option<&Bound<'_, PyAny>>,
        color: Option<&Bound<'_, PyAny>>,
        color_by: Option<&Bound<'_, PyAny>>,
        colormap: Option<&str>,
        range: Option<[f64; 2]>,
        missing_color: Option<&Bound<'_, PyAny>>,
        names: Option<&Bound<'_, PyAny>>,
        planes: Option<&Bound<'_, PyAny>>,
        lights: Option<&Bound<'_, PyAny>>,
        sky: Option<&Bound<'_, PyAny>>,
        ambient: Option<&Bound<'_, PyAny>>,
        background: Option<&Bound<'_, PyAny>>,
        camera: Option<&Camera>,
    ) -> PyResult<Scene> {
        let mut scene = scene::Scene::default();
        let mut coloring = None;
        if let Some(spheres) = spheres {
            scene.spheres = spheres_of(py, spheres, radius, color)?;
        } else if radius.is_some() || color.is_some() || color_by.is_some() || names.is_some() {
            return Err(PyValueError::new_err(
                "radius, color, color_by, names: there are no spheres that they are of",
            ));
        }
        if let Some(color_by) = color_by {
            if color.is_some() {
                let message = "color: `color_by` gives each sphere its own; leave one of them out";
                return Err(PyValueError::new_err(message));
            }
            let (spheres, made) =
                colored_by(scene.spheres, color_by, colormap, range, missing_color)?;
            scene.spheres = spheres;
            coloring = Some(made);
        } else if colormap.is_some() || range.is_some() || missing_color.is_some() {
            return Err(PyValueError::new_err(
                "colormap, range, missing_color: they say how numbers are coloured; give them by `color_by`",
            ));
        }
        if let Some(names) = names {
            name_all(&mut scene.spheres, names)?;
        }
        scene.planes = planes_of(planes)?;
        scene.lights = lights_of(lights)?;
        scene.sky = sky_of(sky)?;
        scene.ambient = ambient_of(ambient)?;
        if let Some(background) = background {
            scene.background = color_of("background", background)?;
        }
        scene.camera = camera.map(|camera| camera.of_scene.clone());
        Ok(Scene { coloring, ..scene.into() })
    }

    /// Reads a scene file (.toml), or makes a scene of data (.npy, .csv, .xyz, .dump and others): with a camera
    /// that frames everything, light, and a radius where the data have none. `notes` says what was chosen.
    ///
    /// `radius`, `color`, `color_by` (a column), `colormap`, `range`, `columns` (a dictionary such as
    /// {"radius": "R"}) and `frame` (from 1) are for data, or for a scene's only cloud. `view`, `up`, `fov`,
    /// `height` and `margin` are those of `Camera.frame`; `size` and `samples` win over the file's.
    #[staticmethod]
    #[pyo3(signature = (
        path, *, radius = None, color = None, color_by = None, colormap = None, range = None, columns = None,
        frame = None, view = None, up = None, fov = None, height = None, margin = None, size = None,
        samples = None, progress = None
    ))]
    #[allow(clippy::too_many_arguments, reason = "Python's arguments have names")]
    fn open(
        py: Python<'_>,
        path: PathBuf,
        radius: Option<f64>,
        color: Option<&Bound<'_, PyAny>>,
        color_by: Option<String>,
        colormap: Option<String>,
        range: Option<[f64; 2]>,
        columns: Option<BTreeMap<String, Bound<'_, PyAny>>>,
        frame: Option<u32>,
        view: Option<&str>,
        up: Option<Vector>,
        fov: Option<f64>,
        height: Option<&Bound<'_, PyAny>>,
        margin: Option<f64>,
        size: Option<Size>,
        samples: Option<u32>,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Scene> {
        let column = |(key, name): (String, Bound<'_, PyAny>)| Ok((key, name.str()?.to_string()));
        let columns = columns.unwrap_or_default().into_iter().map(column);
        let wishes = Wishes {
            view: view.map(viewpoint).transpose()?,
            margin: usable_margin(margin)?,
            up: up.map(|up| direction("up", up)).transpose()?,
            lens: lens(fov, height)?,
            size: size.map(usable_size).transpose()?,
            samples: samples.map(usable_samples).transpose()?,
            data: DataWishes {
                radius: radius.map(usable_radius).transpose()?,
                color: color.map(|color| paint("color", color)).transpose()?,
                color_by,
                colormap,
                range,
                columns: columns.collect::<PyResult<_>>()?,
                frame: frame.map(usable_frame).transpose()?,
            },
            ..Wishes::default()
        };
        // A file that needs nothing of this is only read: it may be of rays alone.
        let is_as_written = wishes == Wishes::default() && !is_cloud_file(&path);
        let read = |control: &Control| match is_as_written {
            true => read_scene_with(&path, control),
            false => {
                let composed = compose_scene(&path, &wishes, control)?;
                let mut scene = composed.scene;
                scene.notes.extend(composed.notes);
                Ok(scene)
            }
        };
        work::run_of_bytes(py, progress, read).map(Scene::from)
    }

    /// A cloud of spheres made up from a seed, the same on every machine, with a camera: `distribution` is
    /// "uniform", "clustered", "lattice", "shell", "galaxy" or "packing".
    #[staticmethod]
    #[pyo3(signature = (count, distribution = "uniform", *, seed = 0))]
    fn generate(py: Python<'_>, count: u64, distribution: &str, seed: u64) -> PyResult<Scene> {
        let all = Distribution::ALL;
        let found = all.into_iter().find(|known| known.name() == distribution);
        let distribution = found.ok_or_else(|| {
            let names = all.map(Distribution::name).join(", ");
            let message =
                format!("distribution: there is no {distribution:?}; give one of {names}");
            PyValueError::new_err(message)
        })?;
        let recipe = Recipe { distribution, count, seed };
        work::run(py, None, 0, |control| recipe.scene(control)).map(Scene::from)
    }

    /// The scene with some things changed: `camera`, `size`, `samples`, `planes`, `lights`, `sky`, `ambient` or
    /// `background`, as for `Scene`; None takes one away. The spheres are shared.
    #[pyo3(
        signature = (**changes),
        text_signature = "($self, *, camera=..., size=..., samples=..., planes=..., lights=..., sky=..., \
                          ambient=..., background=...)"
    )]
    fn replace(&self, changes: Option<&Bound<'_, PyDict>>) -> PyResult<Scene> {
        let mut scene = scene::Scene::clone(&self.of);
        for (key, given) in changes.into_iter().flatten() {
            let given = Some(given).filter(|given| !given.is_none());
            let given = given.as_ref();
            match &*key.extract::<String>()? {
                "camera" => {
                    let camera = given.map(|given| Ok::<_, PyErr>(given.cast::<Camera>()?.get()));
                    scene.camera = camera.transpose()?.map(|camera| camera.of_scene.clone());
                }
                "size" => {
                    let size = given.map(|given| usable_size(given.extract()?)).transpose()?;
                    scene.image = size.map(|[width, height]| ImageSize { width, height });
                }
                "samples" => {
                    scene.samples =
                        given.map(|given| usable_samples(given.extract()?)).transpose()?;
                }
                "planes" => scene.planes = planes_of(given)?,
                "lights" => scene.lights = lights_of(given)?,
                "sky" => scene.sky = sky_of(given)?,
                "ambient" => scene.ambient = ambient_of(given)?,
                "background" => {
                    let color = given.map(|given| color_of("background", given)).transpose()?;
                    scene.background = color.unwrap_or_default();
                }
                other => {
                    return Err(PyTypeError::new_err(format!(
                        "{other}: this can't be changed; give camera, size, samples, planes, lights, sky, \
                         ambient or background"
                    )));
                }
            }
        }
        Ok(Scene { coloring: self.coloring.clone(), ..scene.into() })
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

    /// What the reader of its files chose or understood: sentences.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.of.notes.clone()
    }

    /// Columns and rows that the scene asks for, if it does.
    #[getter]
    fn size(&self) -> Option<(u32, u32)> {
        self.of.image.map(|image| (image.width, image.height))
    }

    /// Samples across and down a pixel that the scene asks for, if it does.
    #[getter]
    fn samples(&self) -> Option<u32> {
        self.of.samples
    }

    /// Whether anything lights the objects; else they have their colours as they are.
    #[getter]
    fn is_lit(&self) -> bool {
        self.of.is_lit()
    }

    /// Which colours stand for which numbers: a `Drawing`, or `None` where nothing is coloured by numbers.
    fn legend(&self) -> Option<Drawing> {
        let of_files = self.of.clouds.iter().filter_map(|cloud| cloud.coloring.as_ref());
        let svg = svg_of_colorings(of_files.chain(&self.coloring))?;
        Some(Drawing { svg })
    }

    /// One hash of what the scene holds, but for its camera, size, samples and names: pictures tell it in their
    /// metadata.
    fn hash(&self, py: Python<'_>) -> PyResult<String> {
        work::run(py, None, 0, |_| Ok(scene_hash(&self.of)))
    }

    /// What the scene holds and what a picture of it takes: a dictionary with the keys of
    /// `kugelblitz check --json`.
    #[pyo3(signature = (camera = None, size = None))]
    fn check<'py>(
        &self,
        py: Python<'py>,
        camera: Option<&Camera>,
        size: Option<Size>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let has_camera = camera.is_some() || self.of.camera.is_some();
        let pixels = has_camera.then(|| pixels_of(&self.of, camera, size, None)).transpose()?;
        let cost = work::run(py, None, 0, |control| Cost::new(&self.of, pixels.as_ref(), control))?;
        let dict = to_python(py, &cost)?;
        let objects = PyDict::new(py);
        objects.set_item("spheres", self.n_spheres())?;
        objects.set_item("planes", self.n_planes())?;
        dict.set_item("objects", objects)?;
        Ok(dict)
    }

    /// Writes the scene for another renderer: `language` is "pov" (POV-Ray) or "tachyon". Returns the command
    /// that renders it.
    #[pyo3(signature = (path, language = "pov", camera = None, size = None))]
    fn export(
        &self,
        py: Python<'_>,
        path: PathBuf,
        language: &str,
        camera: Option<&Camera>,
        size: Option<Size>,
    ) -> PyResult<String> {
        let found = Language::ALL.into_iter().find(|known| known.name() == language);
        let language = found.ok_or_else(|| {
            let names = Language::ALL.map(Language::name).join(", ");
            PyValueError::new_err(format!(
                "language: there is no {language:?}; give one of {names}"
            ))
        })?;
        let Pixels { view, width, height, .. } = pixels_of(&self.of, camera, size, None)?;
        let palette: Vec<Color> = self.of.colors().collect();
        work::run(py, None, 0, |control| {
            let mut file = OutputFile::create(&path, false)?;
            let color_of = |id: u32| palette[id as usize];
            export::write(language, &self.of, &view, [width, height], color_of, &mut file)
                .map_err(Error::io(&path))?;
            output::commit([file], control)
        })?;
        Ok(language.command(&path.display().to_string(), [width, height]))
    }

    /// One ray in numbers: of the pixel (column, row) of the camera's picture, or of `ray`, (origin, direction).
    ///
    /// `all` is for every object in place of those that matter; `lang` is "en" or "de"; `digits` are those of
    /// results in formulas. `samples` is as for `render`.
    #[pyo3(signature = (
        camera = None, pixel = None, *, ray = None, size = None, samples = None, all = false, lang = "en",
        digits = 6, device = "cpu"
    ))]
    #[allow(clippy::too_many_arguments, reason = "Python's arguments have names")]
    fn explain(
        &self,
        py: Python<'_>,
        camera: Option<&Camera>,
        pixel: Option<Pixel>,
        ray: Option<(Bound<'_, PyAny>, Bound<'_, PyAny>)>,
        size: Option<Size>,
        samples: Option<u32>,
        all: bool,
        lang: &str,
        digits: usize,
        device: &str,
    ) -> PyResult<Explanation> {
        let rays = match (pixel, ray) {
            (Some(Pixel([x, y])), None) => {
                let whole = pixels_of(&self.of, camera, size, None)?;
                let inside = |at: i64, n: u32| u32::try_from(at).ok().filter(|at| *at < n);
                let (Some(x), Some(y)) = (inside(x, whole.width), inside(y, whole.height)) else {
                    return Err(PyValueError::new_err(format!(
                        "pixel: ({x}, {y}) is not in the picture of {}×{} pixels",
                        whole.width, whole.height
                    )));
                };
                Rays::Pixels(Pixels { x, y, width: 1, height: 1, ..whole })
            }
            (None, Some((origin, direction))) => {
                let point = |name: &str, given: &Bound<'_, PyAny>| {
                    given.extract::<Vector>().map_err(|_| {
                        PyTypeError::new_err(format!("ray: its {name} is three numbers"))
                    })
                };
                let origin = finite("ray", point("origin", &origin)?)?;
                let direction = crate::camera::direction("ray", point("direction", &direction)?)?;
                Rays::List(vec![Ray { origin, direction }])
            }
            _ => {
                let message =
                    "give a pixel (column, row) of a camera, or a ray (origin, direction)";
                return Err(PyTypeError::new_err(message));
            }
        };
        let scene = match samples.map(usable_samples).transpose()? {
            Some(_) if samples != self.of.samples => {
                Arc::new(scene::Scene { samples, ..scene::Scene::clone(&self.of) })
            }
            _ => Arc::clone(&self.of),
        };
        let open = |kernel| place::device(py, device, kernel, scene.spheres.len(), 1);
        explained(py, &scene, &rays, all, lang, digits, Some(&open))
    }

    /// Holds results of others against exact arithmetic: arrays of a picture (height, width) of a camera, or of
    /// rays, (N,).
    ///
    /// `camera_or_rays` is a `Camera`, the scene's own where none is given, or (origins, directions). Of the
    /// results any of `id`, `t` (depth along the view axis, or the ray's parameter), `distance`, `zbuffer` (with
    /// `near` and `far`), `normal` and `color` (bytes in sRGB, or linear floats, of unlit objects); or all of
    /// them as `against`: a structured array, `Hits`, a `Picture` or a file. `id_offset` is added to ids to make
    /// them count from 1, `no_hit` is the id of the background, `background` its depth, `scale` the length of a
    /// unit of depth; `normals` are "facing", "outward" or "either", in the axes of the "world" or the "camera"
    /// (`normal_space`). `allow` is what may be wrong, e.g. "ids=0.01%,silhouettes=5%,t=2ulp,normal=0.1"; without
    /// it what `certified` itself promises. `worst` errors of each kind are shown.
    #[pyo3(signature = (
        camera_or_rays = None, *, id = None, t = None, distance = None, zbuffer = None, normal = None,
        color = None, against = None, size = None, crop = None, id_offset = 0, no_hit = None,
        background = None, scale = 1.0, near = None, far = None, normals = "facing", normal_space = "world",
        color_tolerance = 1, rows_from_below = false, allow = None, worst = 3, device = "auto",
        progress = None
    ))]
    #[allow(clippy::too_many_arguments, reason = "Python's arguments have names")]
    fn judge<'py>(
        &self,
        py: Python<'py>,
        camera_or_rays: Option<&Bound<'py, PyAny>>,
        id: Option<&Bound<'py, PyAny>>,
        t: Option<&Bound<'py, PyAny>>,
        distance: Option<&Bound<'py, PyAny>>,
        zbuffer: Option<&Bound<'py, PyAny>>,
        normal: Option<&Bound<'py, PyAny>>,
        color: Option<&Bound<'py, PyAny>>,
        against: Option<&Bound<'py, PyAny>>,
        size: Option<Size>,
        crop: Option<Crop>,
        id_offset: i64,
        no_hit: Option<i64>,
        background: Option<f64>,
        scale: f64,
        near: Option<f64>,
        far: Option<f64>,
        normals: &str,
        normal_space: &str,
        color_tolerance: u8,
        rows_from_below: bool,
        allow: Option<&str>,
        worst: usize,
        device: &str,
        progress: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Judgement> {
        if !(scale.is_finite() && scale != 0.0) {
            return Err(PyValueError::new_err(format!("scale: {scale:?} is no length but 0")));
        }
        let (normal_side, normal_space) = judge::normals(normals, normal_space)?;
        let conventions = Conventions {
            quantities: Vec::new(),
            channel: None,
            id_offset,
            no_hit,
            background,
            scale,
            near_far: judge::planes(near, far)?,
            normal_side,
            normal_space,
            color_tolerance,
            rows_from_below,
        };
        let arrays = [
            ("id", id),
            ("t", t),
            ("distance", distance),
            ("zbuffer", zbuffer),
            ("normal", normal),
            ("color", color),
        ];
        let (allow, n_worst) = (allow, worst);
        let given = judge::Given {
            camera_or_rays,
            arrays,
            against,
            size,
            crop,
            conventions,
            allow,
            n_worst,
            device,
            progress,
        };
        given.judge(py, self)
    }

    /// Holds a kernel's picture, on a device and on the CPU, against exact arithmetic at `samples` pixels, drawn
    /// by `seed`: as many as take some seconds where no number is given. `kernel` may be "all".
    #[pyo3(signature = (
        camera = None, size = None, *, crop = None, samples = None, seed = 0, kernel = "certified",
        device = "auto", progress = None
    ))]
    #[allow(clippy::too_many_arguments, reason = "Python's arguments have names")]
    fn verify(
        &self,
        py: Python<'_>,
        camera: Option<&Camera>,
        size: Option<Size>,
        crop: Option<Crop>,
        samples: Option<usize>,
        seed: u64,
        kernel: &str,
        device: &str,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Verification> {
        let asked = Asked { camera, size, crop, samples, seed, kernel, device, progress };
        asked.verify(py, self)
    }

    /// The digest of a picture, band by band: the same on every device, and that of `render(…).digest()`.
    #[pyo3(signature = (camera = None, size = None, *, samples = None, crop = None, device = "auto", progress = None))]
    #[allow(clippy::too_many_arguments, reason = "Python's arguments have names")]
    fn digest(
        &self,
        py: Python<'_>,
        camera: Option<&Camera>,
        size: Option<Size>,
        samples: Option<u32>,
        crop: Option<Crop>,
        device: &str,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<String> {
        let pixels = pixels_of(&self.of, camera, size, crop)?;
        let n_samples = usable_samples(samples.or(self.of.samples).unwrap_or(1))?;
        let session = self.session(py, device, Kernel::Certified, pixels.len())?;
        let n_steps = n_steps(&pixels, n_samples, self.of.is_lit());
        work::run_with_session(py, progress, n_steps, &session, |session, control| {
            session.digest(&pixels, n_samples, control)
        })
    }

    /// What a picture shows beside colours, as colours for the eye: "depth", "normal", "id", "discriminant",
    /// "error", "side", "stage" and others.
    #[pyo3(signature = (
        what, camera = None, size = None, *, crop = None, device = "auto", kernel = "certified",
        progress = None
    ))]
    #[allow(clippy::too_many_arguments, reason = "Python's arguments have names")]
    fn show(
        &self,
        py: Python<'_>,
        what: &str,
        camera: Option<&Camera>,
        size: Option<Size>,
        crop: Option<Crop>,
        device: &str,
        kernel: &str,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Tinted> {
        let all = || Show::ALL.into_iter().filter(|show| *show != Show::Color);
        let show = all().find(|show| show.name() == what).ok_or_else(|| {
            let names = all().map(Show::name).collect::<Vec<_>>().join(", ");
            PyValueError::new_err(format!("what: there is no {what:?}; give one of {names}"))
        })?;
        let kernel = place::kernel(kernel)?;
        let pixels = pixels_of(&self.of, camera, size, crop)?;
        let session = self.session(py, device, kernel, pixels.len())?;
        let n_steps = show::n_steps(show, &pixels);
        let (shown, colors) =
            work::run_with_session(py, progress, n_steps, &session, |session, control| {
                show::keep(session, show, &pixels, control)
            })?;
        let entry = |(i, entry): (usize, Entry)| (entry.color, entry.meaning, shown.tally.count(i));
        let legend = shown.legend.clone().into_iter().enumerate().map(entry).collect();
        Ok(Tinted { size: [pixels.width, pixels.height], colors, legend })
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
        let trace = |session: &mut Session, control: &Control| {
            let mut hits = Hits::default();
            session.trace(&rays, wants, control, &mut hits)?;
            Ok((hit_records(&hits), hits.counts))
        };
        let (records, counts) =
            work::run_with_session(py, progress, n_rays as u64, &session, trace)?;
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
        slf: &Bound<'_, Scene>,
        py: Python<'_>,
        camera: Option<&Camera>,
        size: Option<Size>,
        samples: Option<u32>,
        crop: Option<Crop>,
        transparent: bool,
        device: &str,
        kernel: &str,
        epsilon: f64,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Picture> {
        let this = slf.get();
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
        let pixels = pixels_of(&this.of, camera, size, crop)?;
        let n_samples = usable_samples(samples.or(this.of.samples).unwrap_or(1))?;
        let background = if transparent { Background::LeftOut } else { Background::Shown };
        let style = Style { encoding: Encoding::Srgb8, n_samples, epsilon, background };
        let n_rays = rays_of_picture(&this.of, pixels.len(), n_samples);
        let session = this.session(py, device, kernel, n_rays)?;
        let n_steps = n_steps(&pixels, n_samples, this.of.is_lit());
        let wants = this.kept_of_hits(kernel);
        let keep =
            |session: &mut Session, control: &Control| session.keep(&pixels, style, wants, control);
        let (kept, _) = work::run_with_session(py, progress, n_steps, &session, keep)?;
        Ok(Picture::new(slf.clone().unbind(), (device, kernel), pixels, style, kept))
    }

    /// For pickle: rows, colours, names, the rest as the text of a scene file, and how numbers became colours.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, State<'py>)> {
        let spheres = &self.of.spheres;
        let names = (0..spheres.len())
            .filter_map(|index| Some((index as u32, spheres.name(index)?.to_string())));
        let names = if spheres.has_names() { names.collect() } else { HashMap::new() };
        let of_all = spheres.color(0).unwrap_or(Spheres::COLOR);
        let colors = match spheres.colors().all(|color| color == of_all) {
            true => PyArray1::from_slice(py, &of_all.0).into_any(),
            false => self.colors(py)?.into_any(),
        };
        let of_files = self.of.clouds.iter().filter_map(|cloud| cloud.coloring.as_ref());
        let mut colorings = of_files.chain(&self.coloring).map(|coloring| {
            let Coloring { column, map, range, missing_color, n_missing } = coloring;
            (column.clone(), map.name(), *range, missing_color.0, *n_missing)
        });
        let text = self.of.text_without_spheres();
        let state = (self.spheres(py)?, colors, names, text, colorings.next_back(), self.notes());
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
        coloring: Option<StateOfColoring>,
        notes: Vec<String>,
    ) -> PyResult<Scene> {
        let mut scene = parse_scene(text, "a pickled scene".as_ref()).map_err(error::of(""))?;
        scene.spheres = spheres_of(py, rows, None, Some(colors))?;
        names.into_iter().for_each(|(index, name)| scene.spheres.set_name(index, name));
        scene.notes = notes;
        let coloring = coloring.map(|(column, map, range, missing_color, n_missing)| Coloring {
            column,
            map: ColorMap::from_name(&map).unwrap_or_default(),
            range,
            missing_color: Color(missing_color),
            n_missing,
        });
        Ok(Scene { coloring, ..scene.into() })
    }

    fn __repr__(&self) -> String {
        let scene = &self.of;
        let light = if scene.is_lit() { ", lit" } else { "" };
        format!("<Scene: {} spheres, {} planes{light}>", scene.spheres.len(), scene.planes.len())
    }
}

/// See [`Scene::__reduce__`].
type State<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyAny>,
    HashMap<u32, String>,
    String,
    Option<StateOfColoring>,
    Vec<String>,
);

/// A [`Coloring`], its map by name.
type StateOfColoring = (String, String, [f64; 2], [f64; 3], usize);

fn planes_of(given: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Plane>> {
    let mut planes = Vec::new();
    for (n, plane) in each("planes", given)?.into_iter().enumerate() {
        let subject = format!("planes[{n}]");
        let table = Value::Array(vec![value(&subject, &plane)?]);
        planes.extend(scene_of(&subject, "plane", table)?.planes);
    }
    Ok(planes)
}

fn lights_of(given: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<Light>> {
    let mut lights = Vec::new();
    for (n, light) in each("lights", given)?.into_iter().enumerate() {
        let subject = format!("lights[{n}]");
        let table = Value::Array(vec![value(&subject, &light)?]);
        lights.extend(scene_of(&subject, "light", table)?.lights);
    }
    Ok(lights)
}

fn sky_of(given: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Sky>> {
    let Some(sky) = given else { return Ok(None) };
    Ok(scene_of("sky", "sky", value("sky", sky)?)?.sky)
}

fn ambient_of(given: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Color>> {
    let Some(ambient) = given else { return Ok(None) };
    Ok(scene_of("ambient", "ambient", value("ambient", ambient)?)?.ambient)
}

/// A colour as wishes have it.
fn paint(name: &str, given: &Bound<'_, PyAny>) -> PyResult<Paint> {
    let color = color_of(name, given)?;
    Ok(match given.extract::<String>() {
        Ok(text) => Paint::Text(text),
        Err(_) => Paint::Linear(color.0),
    })
}

fn usable_radius(radius: f64) -> PyResult<f64> {
    match radius.is_finite() && radius > 0.0 {
        true => Ok(radius),
        false => {
            Err(PyValueError::new_err(format!("radius: {radius:?} is no length greater than 0")))
        }
    }
}

fn usable_frame(frame: u32) -> PyResult<u32> {
    match frame {
        0 => Err(PyValueError::new_err("frame: 0, but frames are counted from 1")),
        frame => Ok(frame),
    }
}

fn usable_samples(samples: u32) -> PyResult<u32> {
    let most = scene::Scene::MAX_SAMPLES;
    match (1..=most).contains(&samples) {
        true => Ok(samples),
        false => Err(PyValueError::new_err(format!(
            "samples: {samples}, but there are 1 to {most} across a pixel"
        ))),
    }
}

/// Names for some or all of the spheres: a list with a name or None for each, or a dictionary by row.
fn name_all(spheres: &mut Spheres, names: &Bound<'_, PyAny>) -> PyResult<()> {
    let n = spheres.len();
    let rows: Vec<(usize, String)> = match names.extract::<HashMap<usize, String>>() {
        Ok(by_row) => by_row.into_iter().collect(),
        Err(_) => {
            let list: Vec<Option<String>> = names.extract().map_err(|_| {
                PyTypeError::new_err("names: give a name or None for each sphere, or {row: name}")
            })?;
            if list.len() != n {
                let message = format!("names: {} of them for {n} spheres", list.len());
                return Err(PyValueError::new_err(message));
            }
            list.into_iter().enumerate().filter_map(|(row, name)| Some((row, name?))).collect()
        }
    };
    for (row, name) in rows {
        if row >= n {
            let message = format!("names: row {row} (counted from 0), but there are {n} spheres");
            return Err(PyValueError::new_err(message));
        }
        spheres.set_name(row as u32, name);
    }
    Ok(())
}

/// Spheres with the colours of their numbers.
fn colored_by(
    spheres: Spheres,
    numbers: &Bound<'_, PyAny>,
    colormap: Option<&str>,
    range: Option<[f64; 2]>,
    missing_color: Option<&Bound<'_, PyAny>>,
) -> PyResult<(Spheres, Coloring)> {
    let map = colormap.map_or(Ok(ColorMap::default()), |name| {
        ColorMap::from_name(name).ok_or_else(|| {
            let names = ColorMap::names().collect::<Vec<_>>().join(", ");
            PyValueError::new_err(format!(
                "colormap: there is no {name:?}; give one of {names}, each also with _r behind it"
            ))
        })
    })?;
    let missing_color = missing_color.map(|color| color_of("missing_color", color)).transpose()?;
    // A series of pandas says what it is called.
    let name = numbers.getattr("name").and_then(|name| name.extract::<String>());
    let name = name.unwrap_or_else(|_| "color_by".into());
    let numbers = Numbers::new("color_by", numbers)?.list("one number for each sphere")?;
    let missing_color = missing_color.unwrap_or(Coloring::MISSING_COLOR);
    spheres.with_numbers(&name, &numbers, map, range, missing_color).map_err(error::of("color_by"))
}

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

/// Rays from two arrays.
///
/// # Errors
/// `ValueError` names the first row that is no ray.
pub fn rays_of(origins: &Bound<'_, PyAny>, directions: &Bound<'_, PyAny>) -> PyResult<Vec<Ray>> {
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
    let is_ray = |ray: &Ray| {
        ray.origin.is_finite() && ray.direction.is_finite() && ray.direction != DVec3::ZERO
    };
    let Some(row) = rays.iter().position(|ray| !is_ray(ray)) else { return Ok(rays) };
    let Ray { origin, direction } = rays[row];
    let (name, numbers, why) = match (origin.is_finite(), direction.is_finite()) {
        (false, _) => ("origins", origin, "not all numbers are finite"),
        (_, false) => ("directions", direction, "not all numbers are finite"),
        _ => ("directions", direction, "it points nowhere"),
    };
    let [x, y, z] = numbers.to_array();
    Err(PyValueError::new_err(format!(
        "{name}: row {row} (counted from 0) is ({x:?}, {y:?}, {z:?}): {why}"
    )))
}

/// A dictionary of how many rays each stage decided.
pub fn counts_of(py: Python<'_>, counts: StageCounts) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("f32", counts.f32)?;
    dict.set_item("f64", counts.f64)?;
    dict.set_item("exact", counts.exact)?;
    Ok(dict)
}
