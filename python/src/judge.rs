//! Results of others, held against exact arithmetic.

use std::sync::Arc;

use kugelblitz::Session;
use kugelblitz::control::Control;
use kugelblitz::picture::Image;
use kugelblitz::rays::{Pixels, Rays};
use kugelblitz::trace::Kernel;
use kugelblitz_judge::judge::{
    Allowed, Case, Conventions, Finding, Judged, NormalSide, NormalSpace, Quantity, pixels_of,
    whole_size,
};
use numpy::PyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use serde_json::json;

use crate::argument::{Crop, Pixel, Size};
use crate::camera::Camera;
use crate::drawing::Tinted;
use crate::error;
use crate::explain::{Explanation, explained};
use crate::image::{Shape, channels, image_of, indices};
use crate::rays::rays_of;
use crate::scene::Scene;
use crate::table::to_python;
use crate::work;

/// What became of results of others: how many are wrong, which, and what is right there. True where all is
/// as it may be; `str()` is the text that `kugelblitz judge` prints.
#[pyclass(frozen, module = "kugelblitz")]
pub struct Judgement {
    of: Judged,
    n_worst: usize,
}

impl Judgement {
    /// How one sees why, in Python.
    fn how(&self, ray: usize) -> String {
        match self.of.pixels() {
            Some(pixels) => {
                let ((x, y), w, h) = (pixels.xy(ray), pixels.image_width, pixels.image_height);
                format!("scene.explain(camera, ({x}, {y}), size=({w}, {h}))")
            }
            None => format!("scene.explain(ray=(origins[{ray}], directions[{ray}]))"),
        }
    }

    /// The worst without how one sees why.
    fn findings(&self) -> Vec<Finding> {
        self.of.worst(self.n_worst, |_| None)
    }

    /// The index of a ray, or of a pixel's (column, row) in the whole picture.
    fn index(&self, at: &Bound<'_, PyAny>) -> PyResult<usize> {
        let n = self.n_rays();
        let found = match (at.extract::<i64>(), at.extract::<Pixel>(), self.of.pixels()) {
            (Ok(index), ..) => usize::try_from(index).ok(),
            (_, Ok(Pixel([x, y])), Some(p)) => {
                let inside = |at: i64, first: u32, n: u32| {
                    let at = at.checked_sub(first.into())?;
                    usize::try_from(at).ok().filter(|at| *at < n as usize)
                };
                let at = inside(x, p.x, p.width).zip(inside(y, p.y, p.height));
                at.map(|(x, y)| y * p.width as usize + x)
            }
            _ => {
                let message = "at: give the index of a ray, or (column, row) of a picture";
                return Err(PyTypeError::new_err(message));
            }
        };
        found.filter(|index| *index < n).ok_or_else(|| {
            let at = at.repr().map_or_else(|_| "?".into(), |at| at.to_string());
            PyValueError::new_err(format!("at: {at} is none of the {n} that were judged"))
        })
    }
}

#[pymethods]
impl Judgement {
    /// Whether nothing is more wrong than it may be.
    #[getter]
    fn kept(&self) -> bool {
        self.of.broken.is_empty()
    }

    fn __bool__(&self) -> bool {
        self.kept()
    }

    /// What is more wrong than it may be, a sentence each.
    #[getter]
    fn broken(&self) -> Vec<String> {
        self.of.broken.clone()
    }

    /// Arguments with which far more of it would be right, where there are such.
    #[getter]
    fn hint(&self) -> Option<&str> {
        self.of.hint.as_deref()
    }

    /// What may be wrong, in words.
    #[getter]
    fn allowed(&self) -> String {
        self.of.case.allowed.to_string()
    }

    /// Number of rays or pixels.
    #[getter]
    fn n_rays(&self) -> usize {
        self.of.case.rays.len()
    }

    /// Numbers of rays with wrong ids and the spread of errors: away from silhouettes, or of rays.
    #[getter]
    fn away<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.of.errors.away)
    }

    /// The same at silhouettes; `None` for rays.
    #[getter]
    fn silhouettes<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.of.silhouettes().map(|part| to_python(py, part)).transpose()
    }

    /// Rays, wrong ids, false hits, false misses and wrong objects of all rays: a dictionary.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let [a, b] = [&self.of.errors.away, &self.of.errors.silhouettes];
        let counts = json!({
            "rays": a.rays + b.rays,
            "wrong_ids": a.wrong_ids + b.wrong_ids,
            "false_hits": a.false_hits + b.false_hits,
            "false_misses": a.false_misses + b.false_misses,
            "wrong_object": a.wrong_object + b.wrong_object,
            "wrong": self.of.wrong_rays().count(),
        });
        to_python(py, &counts)
    }

    /// Indices of the rays or pixels, row by row, with anything that is more wrong than it may be of one ray.
    #[getter]
    fn wrong<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        indices(py, self.of.wrong_rays())
    }

    /// The worst of each kind: a list of dictionaries with `kind`, `ray`, `pixel` (column, row), `says` and
    /// `exact`.
    #[getter]
    fn worst<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.findings())
    }

    /// What is wrong with one ray, by its index or a pixel's (column, row): as `worst`, and an empty list
    /// where all is as it may be.
    fn at<'py>(&self, py: Python<'py>, at: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let ray = self.index(at)?;
        to_python(py, &self.of.of_ray(ray))
    }

    /// The ray in numbers, by its index or a pixel's (column, row).
    #[pyo3(signature = (at, *, all = false, lang = "en", digits = 6))]
    fn explain(
        &self,
        py: Python<'_>,
        at: &Bound<'_, PyAny>,
        all: bool,
        lang: &str,
        digits: usize,
    ) -> PyResult<Explanation> {
        let index = self.index(at)?;
        let ray = match &self.of.case.rays {
            Rays::Pixels(pixels) => {
                let (x, y) = pixels.xy(index);
                Rays::Pixels(Pixels { x, y, width: 1, height: 1, ..*pixels })
            }
            Rays::List(rays) => Rays::List(vec![rays[index]]),
        };
        explained(py, &self.of.case.scene, &ray, all, lang, digits, None)
    }

    /// The errors as colours: false hits red, false misses orange, other objects yellow, errors of t and
    /// normals blue; `None` for rays.
    #[getter]
    fn picture(&self) -> Option<Tinted> {
        let (size, colors) = self.of.picture()?;
        Some(Tinted { size, colors, legend: Vec::new() })
    }

    /// All of it, under the keys of `kugelblitz judge --json`.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.of.summary(self.findings()))
    }

    fn __str__(&self) -> String {
        let (judged, scene) = (self.of.quantities().join(", "), &self.of.case.scene);
        let what = match self.of.pixels() {
            Some(pixels) => format!("{}×{}", pixels.width, pixels.height),
            None => format!("{} rays", self.n_rays()),
        };
        let (spheres, planes) = (scene.spheres.len(), scene.planes.len());
        let worst = self.of.worst(self.n_worst, |ray| Some(self.how(ray)));
        format!(
            "{what}, {judged} against exact arithmetic (spheres: {spheres}, planes: {planes})\n\n"
        ) + &self.of.in_words(&worst)
    }

    fn __repr__(&self) -> String {
        let n = self.n_rays();
        match self.of.broken.as_slice() {
            [] => format!("<Judgement: all {n} are as they may be>"),
            broken => format!("<Judgement: {}; print() it for more>", broken.join("; ")),
        }
    }
}

/// Arguments of `Scene.judge`.
pub struct Given<'a, 'py> {
    pub camera_or_rays: Option<&'a Bound<'py, PyAny>>,
    pub arrays: [(&'static str, Option<&'a Bound<'py, PyAny>>); 6],
    pub against: Option<&'a Bound<'py, PyAny>>,
    pub size: Option<Size>,
    pub crop: Option<Crop>,
    pub conventions: Conventions,
    pub allow: Option<&'a str>,
    pub n_worst: usize,
    pub device: &'a str,
    pub progress: Option<&'a Bound<'py, PyAny>>,
}

impl Given<'_, '_> {
    /// What is claimed, as channels; and what they tell.
    fn image(&self) -> PyResult<(Image, Vec<Quantity>)> {
        let given: Vec<_> =
            self.arrays.iter().filter_map(|(name, it)| Some((*name, (*it)?))).collect();
        match (self.against, given.is_empty()) {
            (Some(against), true) => return Ok((image_of("against", against)?, Vec::new())),
            (Some(_), false) => {
                let message = "against: it has all claims; leave the other arrays out";
                return Err(PyValueError::new_err(message));
            }
            (None, true) => {
                let message = "there is nothing to be judged: give id=, t=, distance=, zbuffer=, normal=, \
                               color= or against=";
                return Err(PyTypeError::new_err(message));
            }
            (None, false) => {}
        }
        let mut all: Option<(Shape, Image)> = None;
        let mut quantities = Vec::new();
        for (name, array) in given {
            let (quantity, names): (Quantity, &[&str]) = match name {
                "id" => (Quantity::Id, &["id"]),
                "t" => (Quantity::Depth, &["Z"]),
                "distance" => (Quantity::Distance, &["distance"]),
                "zbuffer" => (Quantity::ZBuffer, &["Z"]),
                "normal" => (Quantity::Normal, &["N.X", "N.Y", "N.Z"]),
                _ => (Quantity::Color, &["R", "G", "B"]),
            };
            let known = all.as_ref().map(|(shape, _)| *shape);
            let (shape, channels) = channels(name, array, names, known)?;
            let (_, image) = all.get_or_insert_with(|| (shape, shape.image()));
            image.channels.extend(channels);
            quantities.push(quantity);
        }
        all.map(|(_, image)| (image, quantities)).ok_or_else(|| PyTypeError::new_err("no array"))
    }

    /// The rays that the claims are about.
    fn rays(&self, scene: &Scene, image: &Image) -> PyResult<Rays> {
        if let Some(Ok((origins, directions))) = self
            .camera_or_rays
            .filter(|it| it.cast::<Camera>().is_err())
            .map(|it| it.extract::<(Bound<'_, PyAny>, Bound<'_, PyAny>)>())
        {
            if self.size.is_some() || self.crop.is_some() {
                let message = "size, crop: they are of a picture; rays have none";
                return Err(PyValueError::new_err(message));
            }
            return Ok(Rays::List(rays_of(&origins, &directions)?));
        }
        let camera = match self.camera_or_rays {
            None => None,
            Some(given) => Some(given.cast::<Camera>().map_err(|_| {
                let message = "camera_or_rays: give a Camera, or (origins, directions)";
                PyTypeError::new_err(message)
            })?),
        };
        let camera = camera.map(|camera| camera.get());
        let (size, crop) = (self.size.map(|size| size.0), self.crop.map(|crop| crop.0));
        let size = whole_size(image, size, crop).map_err(error::of(""))?;
        let pixels = crate::rays::pixels_of(&scene.of, camera, size.map(Size), self.crop)?;
        if self.crop.is_some() {
            return Ok(Rays::Pixels(pixels));
        }
        pixels_of(image, pixels).map(Rays::Pixels).map_err(error::of(""))
    }

    /// Holds the claims against exact arithmetic.
    pub fn judge(self, py: Python<'_>, scene: &Scene) -> PyResult<Judgement> {
        let allowed =
            Allowed::of_rays(self.allow.unwrap_or_default()).map_err(error::of("allow"))?;
        let (image, quantities) = self.image()?;
        let conventions = Conventions { quantities, ..self.conventions.clone() };
        let rays = self.rays(scene, &image)?;
        let n = rays.len();
        let case = Case::new(Arc::clone(&scene.of), rays, image, conventions, allowed)
            .map_err(error::of(""))?;
        if let Some(warning) = case.warning() {
            error::warn(py, &warning)?;
        }
        let session = scene.session(py, self.device, Kernel::Certified, n)?;
        let judge = |session: &mut Session, control: &Control| case.judge(session, control);
        let mut of = work::run_with_session(py, self.progress, 2 * n as u64, &session, judge)?;
        of.hint = of.hint.map(|options| as_arguments(&options));
        Ok(Judgement { of, n_worst: self.n_worst })
    }
}

/// The command line's options as arguments: `--id-offset 1` as `id_offset=1`.
fn as_arguments(options: &str) -> String {
    let options = options.split("--").map(str::trim).filter(|option| !option.is_empty());
    let argument = |option: &str| {
        let (name, value) = option.split_once([' ', '=']).unwrap_or((option, ""));
        let name = name.replace('-', "_");
        match value {
            "" => format!("{name}=True"),
            what if name == "as" => {
                let arrays = what.split(',').map(|name| if name == "depth" { "t" } else { name });
                format!("the arrays given as {}", arrays.collect::<Vec<_>>().join(", "))
            }
            number if number.parse::<f64>().is_ok() => format!("{name}={number}"),
            word => format!("{name}={word:?}"),
        }
    };
    options.map(argument).collect::<Vec<_>>().join(", ")
}

/// Which of its directions a normal has, and in which axes.
pub fn normals(side: &str, space: &str) -> PyResult<(NormalSide, NormalSpace)> {
    let wrong = |message: String| PyValueError::new_err(message);
    let side = match side {
        "facing" => NormalSide::Facing,
        "outward" => NormalSide::Outward,
        "either" => NormalSide::Either,
        other => {
            return Err(wrong(format!("normals: {other:?}; give facing, outward or either")));
        }
    };
    match space {
        "world" => Ok((side, NormalSpace::World)),
        "camera" => Ok((side, NormalSpace::Camera)),
        other => Err(wrong(format!("normal_space: {other:?}; give world or camera"))),
    }
}

/// A near and a far plane.
pub fn planes(near: Option<f64>, far: Option<f64>) -> PyResult<Option<[f64; 2]>> {
    match (near, far) {
        (None, None) => Ok(None),
        (Some(near), Some(far)) if near > 0.0 && far > 0.0 && near != far => Ok(Some([near, far])),
        _ => {
            let message = "near, far: give both, two different distances above 0; one may be inf";
            Err(PyValueError::new_err(message))
        }
    }
}
