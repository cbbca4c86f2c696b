//! Results of others, held against exact arithmetic.

use std::sync::Arc;

use kugelblitz::Session;
use kugelblitz::control::Control;
use kugelblitz::judge::{
    self, Allowed, Case, Claims, Conventions, Finding, NormalSide, NormalSpace, Quantity,
    RAY_BYTES, check_colors, error_picture, in_words, pixels_of,
};
use kugelblitz::memory;
use kugelblitz::picture::Image;
use kugelblitz::rays::{Pixels, Rays};
use kugelblitz::scene;
use kugelblitz::trace::Kernel;
use kugelblitz::verify::Truth;
use numpy::PyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
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
    scene: Arc<scene::Scene>,
    rays: Rays,
    truth: Truth,
    claims: Claims,
    of: judge::Judgement,
    #[pyo3(get)]
    /// What is more wrong than it may be, a sentence each.
    broken: Vec<String>,
    #[pyo3(get)]
    /// Arguments with which far more of it would be right, where there are such.
    hint: Option<String>,
    allowed: Allowed,
    n_worst: usize,
}

impl Judgement {
    fn case(&self) -> Case<'_> {
        Case { scene: &self.scene, rays: &self.rays, truth: &self.truth, claims: &self.claims }
    }

    fn pixels(&self) -> Option<&Pixels> {
        match &self.rays {
            Rays::Pixels(pixels) => Some(pixels),
            Rays::List(_) => None,
        }
    }

    fn findings(&self) -> Vec<Finding> {
        self.case().worst(&self.of, &self.allowed, self.n_worst)
    }

    fn judged(&self) -> Vec<&'static str> {
        self.claims.quantities.iter().map(|quantity| quantity.name()).collect()
    }

    /// How one sees why, in Python.
    fn how(&self, finding: &Finding) -> String {
        match (finding.pixel, self.pixels()) {
            (Some([x, y]), Some(pixels)) => {
                let (w, h) = (pixels.image_width, pixels.image_height);
                format!("scene.explain(camera, ({x}, {y}), size=({w}, {h}))")
            }
            _ => {
                let ray = finding.ray;
                format!("scene.explain(ray=(origins[{ray}], directions[{ray}]))")
            }
        }
    }

    /// The index of a ray, or of a pixel's (column, row) in the whole picture.
    fn index(&self, at: &Bound<'_, PyAny>) -> PyResult<usize> {
        let n = self.of.errors.len();
        let found = match (at.extract::<i64>(), at.extract::<Pixel>(), self.pixels()) {
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
        self.broken.is_empty()
    }

    fn __bool__(&self) -> bool {
        self.kept()
    }

    /// What may be wrong, in words.
    #[getter]
    fn allowed(&self) -> String {
        self.allowed.to_string()
    }

    /// Number of rays or pixels.
    #[getter]
    fn n_rays(&self) -> usize {
        self.of.errors.len()
    }

    /// Numbers of rays with wrong ids and the spread of errors: away from silhouettes, or of rays.
    #[getter]
    fn away<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.case().part(&self.of.away))
    }

    /// The same at silhouettes; `None` for rays.
    #[getter]
    fn silhouettes<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let part = || to_python(py, &self.case().part(&self.of.silhouettes));
        self.pixels().map(|_| part()).transpose()
    }

    /// Rays, wrong ids, false hits, false misses and wrong objects of all rays: a dictionary.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let parts = [&self.of.away, &self.of.silhouettes];
        let dict = PyDict::new(py);
        let sum = |of: fn(&judge::Part) -> u64| parts.iter().map(|part| of(part)).sum::<u64>();
        dict.set_item("rays", sum(|part| part.rays))?;
        dict.set_item("wrong_ids", sum(judge::Part::wrong_ids))?;
        dict.set_item("false_hits", sum(|part| part.false_hits))?;
        dict.set_item("false_misses", sum(|part| part.false_misses))?;
        dict.set_item("wrong_object", sum(|part| part.wrong_object))?;
        dict.set_item("wrong", self.wrong_rays().count())?;
        Ok(dict)
    }

    /// Indices of the rays or pixels, row by row, with anything that is more wrong than it may be of one ray.
    #[getter]
    fn wrong<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        indices(py, self.wrong_rays())
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
        to_python(py, &self.case().of_ray(&self.of, &self.allowed, ray))
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
        let ray = match &self.rays {
            Rays::Pixels(pixels) => {
                let (x, y) = pixels.xy(index);
                Rays::Pixels(Pixels { x, y, width: 1, height: 1, ..*pixels })
            }
            Rays::List(rays) => Rays::List(vec![rays[index]]),
        };
        explained(py, &self.scene, &ray, all, lang, digits, None)
    }

    /// The errors as colours: false hits red, false misses orange, other objects yellow, errors of t and
    /// normals blue; `None` for rays.
    #[getter]
    fn picture(&self) -> Option<Tinted> {
        let pixels = self.pixels()?;
        let size = [pixels.width, pixels.height];
        Some(Tinted { size, colors: error_picture(&self.of), legend: Vec::new() })
    }

    /// All of it, under the keys of `kugelblitz judge --json`.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let case = self.case();
        let pixels = self.pixels();
        let is_part = |p: &&Pixels| (p.width, p.height) != (p.image_width, p.image_height);
        to_python(
            py,
            &json!({
                "size": pixels.map(|p| [p.image_width, p.image_height]),
                "crop": pixels.filter(is_part).map(|p| [p.x, p.y, p.width, p.height]),
                "objects": { "spheres": self.scene.spheres.len(), "planes": self.scene.planes.len() },
                "rays": self.of.errors.len(),
                "judged": self.judged(),
                "allowed": self.allowed.to_string(),
                "away": case.part(&self.of.away),
                "silhouettes": pixels.map(|_| case.part(&self.of.silhouettes)),
                "worst": self.findings(),
                "hint": self.hint,
                "broken": self.broken,
            }),
        )
    }

    fn __str__(&self) -> String {
        let judged = self.judged().join(", ");
        let what = match self.pixels() {
            Some(pixels) => format!("{}×{}", pixels.width, pixels.height),
            None => format!("{} rays", self.of.errors.len()),
        };
        let (spheres, planes) = (self.scene.spheres.len(), self.scene.planes.len());
        let mut text = format!(
            "{what}, {judged} against exact arithmetic (spheres: {spheres}, planes: {planes})\n\n"
        );
        text += &self.case().table(&self.of);
        text += &in_words(&self.findings(), |finding| self.how(finding));
        if let Some(hint) = &self.hint {
            text += &format!("\nfar more of it would be right with {hint}\n");
        }
        let kept = if self.kept() { ": kept" } else { "" };
        text + &format!("\nallowed: {}{kept}\n", self.allowed)
    }

    fn __repr__(&self) -> String {
        let n = self.of.errors.len();
        match self.broken.as_slice() {
            [] => format!("<Judgement: all {n} are as they may be>"),
            broken => format!("<Judgement: {}; print() it for more>", broken.join("; ")),
        }
    }
}

impl Judgement {
    fn wrong_rays(&self) -> impl Iterator<Item = usize> {
        let errors = self.of.errors.iter().enumerate();
        errors.filter(|(_, error)| !self.allowed.is_right(error)).map(|(ray, _)| ray)
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
        if image.is_list {
            let message = "camera_or_rays: the arrays are lists of results; give the rays that they are of, \
                           (origins, directions)";
            return Err(PyValueError::new_err(message));
        }
        let own = [image.width, image.height].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
        let of_file = image.whole.map(|n| u32::try_from(n).unwrap_or(u32::MAX));
        let is_whole = image.whole == [image.width, image.height] && image.first == [0, 0];
        let size = match (self.size, self.crop) {
            (None, Some(_)) if is_whole => None,
            (size, _) => Some(size.unwrap_or(Size(of_file))),
        };
        let pixels = crate::rays::pixels_of(&scene.of, camera, size, self.crop)?;
        if self.crop.is_none() {
            if [pixels.image_width, pixels.image_height] != of_file {
                return Err(PyValueError::new_err(format!(
                    "size: ({}, {}), but the arrays are a picture of {}×{} pixels; say with crop= which part \
                     of it they are",
                    pixels.image_width, pixels.image_height, of_file[0], of_file[1]
                )));
            }
            return pixels_of(image, pixels).map(Rays::Pixels).map_err(error::of(""));
        }
        match [pixels.width, pixels.height] == own {
            true => Ok(Rays::Pixels(pixels)),
            false => Err(PyValueError::new_err(format!(
                "crop: it has {}×{} pixels, but the arrays have {}×{}",
                pixels.width, pixels.height, own[0], own[1]
            ))),
        }
    }

    /// Holds the claims against exact arithmetic.
    pub fn judge(self, py: Python<'_>, scene: &Scene) -> PyResult<Judgement> {
        let allowed: Allowed = match self.allow {
            None | Some("") => Allowed::default(),
            Some(text) => text.parse().map_err(error::of("allow"))?,
        };
        let (image, quantities) = self.image()?;
        let conventions = Conventions { quantities, ..self.conventions.clone() };
        let rays = self.rays(scene, &image)?;
        let n = rays.len();
        if image.len() != n {
            return Err(PyValueError::new_err(format!(
                "there are {} results for {n} rays; give one for each",
                image.len()
            )));
        }
        let bytes = (n as u64).saturating_mul(RAY_BYTES);
        memory::require(format!("judging {n} rays"), bytes, "judge a part of them")
            .map_err(error::of(""))?;
        let view = match &rays {
            Rays::Pixels(pixels) => Some(pixels.view),
            Rays::List(_) => None,
        };
        let claims =
            Claims::new(image.clone(), &conventions, view.as_ref()).map_err(error::of(""))?;
        if let Some(warning) = check_colors(&scene.of, &claims, "color").map_err(error::of(""))? {
            error::warn(py, &warning)?;
        }
        let session = scene.session(py, self.device, Kernel::Certified, n)?;
        let of_scene = Arc::clone(&scene.of);
        let judge = |session: &mut Session, control: &Control| {
            let truth = judge::truth(session, &rays, control)?;
            let of = judge::judge(&of_scene, &rays, &truth, &claims)?;
            let broken = allowed.broken(&of);
            let hint = match broken.is_empty() {
                true => None,
                false => {
                    let other = (&image, &conventions, view.as_ref());
                    judge::hint(&of_scene, &rays, &truth, other, (&claims, &of))?
                }
            };
            Ok((truth, of, broken, hint))
        };
        let (truth, of, broken, hint) =
            work::run_with_session(py, self.progress, 2 * n as u64, &session, judge)?;
        Ok(Judgement {
            scene: of_scene,
            rays,
            truth,
            claims,
            of,
            broken,
            hint: hint.map(|options| as_arguments(&options)),
            allowed,
            n_worst: self.n_worst,
        })
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
