//! Results of others, held against exact arithmetic.

use std::sync::Arc;

use kugelblitz::error::{Setting, SettingValue};
use kugelblitz::picture::Image;
use kugelblitz::rays::{Pixels, Rays};
use kugelblitz::scene;
use kugelblitz::trace::Kernel;
use kugelblitz::words::joined;
use kugelblitz_judge::judge::{self, Allowed, Case, Conventions, Quantity, pixels_of, whole_size};
use numpy::PyArray1;
use pyo3::exceptions::{PyTypeError, PyUserWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::argument::{Crop, Size, rays_of};
use crate::camera::Camera;
use crate::drawing::tinted;
use crate::error::{self, wrong_value};
use crate::explain::{Explanation, explained};
use crate::image::{Found, image_of, indices};
use crate::scene::Scene;
use crate::table::{Given, Keywords, Object, helpers, to_python};
use crate::verdict::verdict;

/// What a `Judgement` knows of its rays.
#[pyclass(frozen, module = "kugelblitz._kugelblitz")]
pub struct Judged(judge::Judged);

#[pymethods]
impl Judged {
    fn wrong<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        indices(py, self.0.wrong_rays())
    }

    fn at<'py>(&self, py: Python<'py>, ray: usize) -> Object<'py> {
        to_python(py, &self.0.of_ray(ray))
    }

    fn explain(
        &self,
        py: Python<'_>,
        ray: usize,
        all: bool,
        lang: &str,
        digits: usize,
    ) -> PyResult<Explanation> {
        let Case { scene, rays, .. } = &self.0.case;
        let ray = match rays {
            Rays::Pixels(pixels) => {
                let (x, y) = pixels.xy(ray);
                Rays::Pixels(Pixels { x, y, width: 1, height: 1, ..*pixels })
            }
            Rays::List(rays) => Rays::List(vec![rays[ray]]),
        };
        explained(py, scene, &ray, all, lang, digits, "cpu")
    }

    fn picture<'py>(&self, py: Python<'py>) -> PyResult<Given<'py>> {
        let picture = self.0.picture();
        picture.map(|(size, colors)| tinted(py, size, &colors, Vec::new())).transpose()
    }
}

/// The names of what is claimed, as `_given.claims` takes them.
const CLAIMS: [&str; 7] = ["id", "t", "distance", "zbuffer", "normal", "color", "against"];

/// The fields of [`Conventions`].
const CONVENTIONS: [&str; 8] = [
    "id_offset",
    "no_hit",
    "background",
    "scale",
    "normals",
    "normal_space",
    "color_tolerance",
    "rows_from_below",
];

/// The other keyword arguments of [`judge`].
const OTHERS: [&str; 8] = ["size", "crop", "near", "far", "allow", "worst", "device", "progress"];

/// What the numbers mean.
fn conventions(keys: &Keywords<'_>, quantities: Vec<Quantity>) -> PyResult<Conventions> {
    let near_far = match (keys.extract("near")?, keys.extract("far")?) {
        (None, None) => None,
        (Some(near), Some(far)) if near > 0.0 && far > 0.0 && near != far => Some([near, far]),
        _ => {
            return wrong_value(
                "near, far: give both, two different distances above 0; one may be inf",
            );
        }
    };
    let text = keys.lines(&CONVENTIONS)?.join("\n");
    let given: Conventions = toml::from_str(&text).map_err(|error| {
        let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
        let line = text.lines().nth(before.matches('\n').count()).unwrap_or_default();
        PyValueError::new_err(format!("{line}: {}", error.message()))
    })?;
    match given.scale {
        scale if scale.is_finite() && scale != 0.0 => {
            Ok(Conventions { quantities, near_far, ..given })
        }
        scale => wrong_value(format!("scale: {scale:?} is no length but 0")),
    }
}

/// Pixels of a camera, or rays.
#[derive(FromPyObject)]
enum CameraOrRays<'py> {
    Camera(Bound<'py, Camera>),
    Rays(Bound<'py, PyAny>, Bound<'py, PyAny>),
}

/// The rays that the claims are about.
fn rays(
    py: Python<'_>,
    scene: &scene::Scene,
    camera_or_rays: Given<'_>,
    image: &Image,
    keys: &Keywords<'_>,
) -> PyResult<Rays> {
    let (size, crop) = (keys.extract("size")?, keys.extract("crop")?);
    let given = camera_or_rays.map(|given| given.extract()).transpose().map_err(|_| {
        PyTypeError::new_err("camera_or_rays: give a Camera, or (origins, directions)")
    })?;
    let camera = match &given {
        None => None,
        Some(CameraOrRays::Camera(camera)) => Some(camera.get()),
        Some(CameraOrRays::Rays(..)) if size.is_some() || crop.is_some() => {
            return wrong_value("size, crop: they are of a picture; rays have none");
        }
        Some(CameraOrRays::Rays(origins, directions)) => {
            return rays_of(origins, directions).map(Rays::List);
        }
    };
    let size = whole_size(image, size.map(|Size(size)| size), crop.map(|Crop(crop)| crop));
    let size = size.map_err(error::of(""))?.map(Size);
    let pixels = crate::argument::pixels_of(py, scene, camera, size, crop)?;
    match crop {
        Some(_) => Ok(Rays::Pixels(pixels)),
        None => pixels_of(image, pixels).map(Rays::Pixels).map_err(error::of("")),
    }
}

/// Holds claims of others against exact arithmetic.
pub fn judge<'py>(
    py: Python<'py>,
    scene: &Scene,
    camera_or_rays: Given<'py>,
    keys: Option<Bound<'py, PyDict>>,
) -> Object<'py> {
    let keys = Keywords::new(py, keys, &[&CLAIMS[..], &CONVENTIONS, &OTHERS].concat())?;
    let allowed: Option<String> = keys.extract("allow")?;
    let allowed = Allowed::of_rays(&allowed.unwrap_or_default()).map_err(error::of("allow"))?;
    let n_worst = keys.extract("worst")?.unwrap_or(3);
    let device = keys.extract("device")?.unwrap_or("auto".to_string());
    let claims = helpers(py)?.call_method("claims", (), Some(&keys.0))?;
    let (found, quantities): (Found<'_>, Vec<String>) = claims.extract()?;
    let image = image_of(found)?;
    let quantities = quantities.iter().map(|name| name.parse()).collect::<kugelblitz::Result<_>>();
    let quantities = quantities.map_err(error::of(""))?;
    let conventions = conventions(&keys, quantities)?;
    let rays = rays(py, &scene.of, camera_or_rays, &image, &keys)?;
    let n_rays = rays.len();
    let case = Case::new(Arc::clone(&scene.of), rays, image, conventions, allowed)
        .map_err(error::of(""))?;
    if let Some(warning) = case.warning() {
        error::warn::<PyUserWarning>(py, &warning)?;
    }
    let (progress, n_steps) = (keys.get("progress"), 2 * n_rays as u64);
    let on = (&*device, Kernel::Certified, n_rays);
    let of =
        scene.run(py, on, (progress, n_steps), |session, control| case.judge(session, control))?;
    let judged = Bound::new(py, Judged(of))?;
    let of = &judged.get().0;
    let hint = joined(of.hint.iter().map(argument_of), ", ");
    let summary = of.summary(of.worst(n_worst, |_| None), &hint);
    let known = Some(judged.clone().into_any());
    verdict(py, "Judgement", &of.broken, &summary, in_words(of, n_worst, &hint), known)
}

/// Returns a setting of the judge as an argument: `id_offset=1`. A quantity is the name of the argument itself.
fn argument_of(setting: &Setting) -> String {
    match setting {
        Setting { key: "as", value: Some(SettingValue::Text(quantities)) } => {
            let name = |quantity| if quantity == "depth" { "t" } else { quantity };
            format!("the arrays given as {}", joined(quantities.split(',').map(name), ", "))
        }
        setting => error::argument(setting),
    }
}

/// What the program prints, with how one sees why in Python.
fn in_words(of: &judge::Judged, n_worst: usize, hint: &str) -> String {
    let how = |ray| match of.pixels() {
        Some(pixels) => {
            let ((x, y), w, h) = (pixels.xy(ray), pixels.image_width, pixels.image_height);
            format!("scene.explain(camera, ({x}, {y}), size=({w}, {h}))")
        }
        None => format!("scene.explain(ray=(origins[{ray}], directions[{ray}]))"),
    };
    let what = match of.pixels() {
        Some(pixels) => format!("{}×{}", pixels.width, pixels.height),
        None => format!("{} rays", of.case.rays.len()),
    };
    let (judged, scene) = (of.quantities().join(", "), &of.case.scene);
    let (spheres, planes) = (scene.spheres.len(), scene.planes.len());
    let worst = of.worst(n_worst, |ray| Some(how(ray)));
    format!("{what}, {judged} against exact arithmetic (spheres: {spheres}, planes: {planes})\n\n")
        + &of.in_words(&worst, hint)
}
