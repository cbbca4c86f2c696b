//! Results of comparisons.

use kugelblitz::picture::Image;
use kugelblitz::rays::{Pixels, Rays};
use kugelblitz_judge::compare::{
    ErrorStats, HitComparison, HitDifference, HitSummary, PictureDifference, Transform,
    TransformMatch,
};
use kugelblitz_judge::verify::Verified;
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict, PyDict};
use serde::Serialize;

use crate::drawing::tinted;
use crate::error::{wrong_type, wrong_value};
use crate::explain::{PyExplanation, explained};
use crate::image::indices;
use crate::table::{Given, PyValue, from_json, to_json, to_python};

/// Result of a comparison. True if no error exceeds the allowed one; `str()` is the text that the program prints.
#[pyclass(frozen, subclass, name = "Verdict", module = "kugelblitz")]
pub struct Outcome {
    broken: Vec<String>,
    /// Summary that the program prints with `--json`.
    json: String,
    text: String,
    /// Sentence for a comparison in which nothing is broken.
    praise: String,
}

impl Outcome {
    /// # Errors
    /// Returns `ValueError` for a summary that JSON cannot hold.
    pub fn new(
        broken: Vec<String>,
        summary: &impl Serialize,
        text: String,
        praise: impl Into<String>,
    ) -> PyResult<Outcome> {
        Ok(Outcome { broken, json: to_json(summary)?, text, praise: praise.into() })
    }
}

#[pymethods]
impl Outcome {
    /// Whether no error exceeds the allowed one.
    #[getter]
    fn kept(&self) -> bool {
        self.broken.is_empty()
    }

    /// Errors beyond the allowed ones, a sentence each.
    #[getter]
    fn broken(&self) -> Vec<String> {
        self.broken.clone()
    }

    /// The whole result, under the keys of the program's `--json`.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyValue<'py> {
        from_json(py, &self.json)
    }

    fn __bool__(&self) -> bool {
        self.kept()
    }

    fn __str__(&self) -> &str {
        &self.text
    }

    fn __repr__(slf: &Bound<'_, Outcome>) -> PyResult<String> {
        let (kind, this) = (slf.get_type().name()?, slf.get());
        let text = if this.kept() { this.praise.clone() } else { this.broken.join("; ") };
        Ok(format!("<{kind}: {text}>"))
    }
}

/// Check of the promises of each kernel, on a device and on the CPU.
#[pyclass(frozen, extends = Outcome, name = "Verification", module = "kugelblitz")]
pub struct KernelOutcome;

impl KernelOutcome {
    /// Returns the verdict on kernels, at pixels drawn by `seed`.
    pub fn new<'py>(py: Python<'py>, of: &Verified, seed: u64) -> PyResult<Bound<'py, Self>> {
        let Verified { size: [width, height], samples, .. } = of;
        let head = format!("{width}×{height}, {samples} pixels (seed {seed})");
        let text = format!("{head} against exact arithmetic\n{}", of.in_words());
        let base = Outcome::new(of.broken(), of, text, "all promises are kept")?;
        Bound::new(py, (KernelOutcome, base))
    }
}

/// Differences of two pictures. True if none exceeds the allowed one.
#[pyclass(frozen, extends = Outcome, name = "Difference", module = "kugelblitz")]
pub struct PictureOutcome {
    a: Image,
    of: PictureDifference,
}

impl PictureOutcome {
    /// Returns the verdict on the difference of `a` from another picture.
    pub fn new(py: Python<'_>, a: Image, of: PictureDifference) -> PyResult<Bound<'_, Self>> {
        let PictureDifference { pixels, differing, .. } = of;
        let praise = format!("{differing} of {pixels} pixels differ, no more than is allowed");
        let base = Outcome::new(of.broken.clone(), &of, of.in_words(), praise)?;
        Bound::new(py, (PictureOutcome { a, of }, base))
    }
}

#[pymethods]
impl PictureOutcome {
    /// Transforms of the first picture that explain the differences; None if there are none.
    #[getter]
    fn explained_by(&self) -> Option<&str> {
        transforms(&self.of.explained_by)
    }

    /// Number of compared pixels; 0 if the sizes differ.
    #[getter]
    fn n_pixels(&self) -> u64 {
        self.of.pixels
    }

    /// Number of pixels with any difference.
    #[getter]
    fn n_differing(&self) -> u64 {
        self.of.differing
    }

    /// Column and row of the first pixel with any difference.
    #[getter]
    fn first(&self) -> Option<[usize; 2]> {
        self.of.first
    }

    /// Indices of the pixels, row by row, with a difference beyond the allowed one.
    #[getter]
    fn beyond<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        indices(py, self.of.pixels_beyond())
    }

    /// Channels of both pictures, with `name`, `differing`, `largest`, `pixel` and others.
    #[getter]
    fn channels<'py>(&self, py: Python<'py>) -> PyValue<'py> {
        to_python(py, &self.of.channels)
    }

    /// Differences as colours: equal pixels dark, allowed differences blue, others red to yellow; None if the sizes
    /// differ.
    #[getter]
    fn picture<'py>(&self, py: Python<'py>) -> PyResult<Given<'py>> {
        let PictureOutcome { a, of } = self;
        let size = [a.width as u32, a.height as u32];
        let tinted = || tinted(py, size, &of.picture(a), Vec::new());
        (of.pixels > 0).then(tinted).transpose()
    }
}

/// Index of a ray, or column and row of a pixel.
#[derive(FromPyObject)]
enum RayPlace {
    Index(i64),
    Pixel([i64; 2]),
}

/// Differences of hits from the exact ones.
#[pyclass(frozen, extends = Outcome, name = "HitDifference", module = "kugelblitz")]
pub struct HitOutcome {
    of: HitDifference,
    /// Number of errors of each kind that are shown.
    n_worst: usize,
}

impl HitOutcome {
    /// Returns the verdict on hits, with `n_worst` errors of each kind.
    pub fn new(py: Python<'_>, of: HitDifference, n_worst: usize) -> PyResult<Bound<'_, Self>> {
        let praise = format!("all {} are as they may be", of.comparison.rays.len());
        let text = in_words(&of, n_worst);
        let this = HitOutcome { of, n_worst };
        let base = Outcome::new(this.of.broken.clone(), &this.summary(), text, praise)?;
        Bound::new(py, (this, base))
    }

    fn summary(&self) -> HitSummary {
        self.of.summary(self.of.worst(self.n_worst, |_| None))
    }

    /// Returns the index of a ray, or of a pixel's (column, row) in the whole picture.
    fn index(&self, at: &Bound<'_, PyAny>) -> PyResult<usize> {
        let n_rays = self.of.comparison.rays.len();
        let index = match (at.extract(), self.of.pixels()) {
            (Ok(RayPlace::Index(index)), _) => usize::try_from(index).ok(),
            (Ok(RayPlace::Pixel([x, y])), Some(&Pixels { x: left, y: top, width, .. })) => {
                let place = |at: i64, first: u32| u32::try_from(at - i64::from(first)).ok();
                let column = place(x, left).filter(|column| *column < width);
                column
                    .zip(place(y, top))
                    .map(|(column, row)| row as usize * width as usize + column as usize)
            }
            _ => return wrong_type("at: give the index of a ray, or (column, row) of a picture"),
        };
        match index.filter(|index| *index < n_rays) {
            Some(index) => Ok(index),
            None => wrong_value(format!("at: {at} is none of the {n_rays} that were compared")),
        }
    }
}

#[pymethods]
impl HitOutcome {
    /// Transforms that explain the errors, as `compare(…, transform=…)` takes them; None if there are none.
    #[getter]
    fn explained_by(&self) -> Option<&str> {
        transforms(&self.of.explained)
    }

    /// Objects with wrong rays, most wrong first: `id`, `name`, `rays`, `wrong_ids` and others.
    #[getter]
    fn by_object<'py>(&self, py: Python<'py>) -> PyValue<'py> {
        to_python(py, &self.of.objects)
    }

    /// Allowed errors, in words.
    #[getter]
    fn allowed(&self) -> String {
        self.of.comparison.allowed.of_hits()
    }

    /// Number of rays or pixels.
    #[getter]
    fn n_rays(&self) -> usize {
        self.of.comparison.rays.len()
    }

    /// Numbers of rays with wrong ids, and spread of errors, away from silhouettes; for a list of rays, of all rays.
    #[getter]
    fn away<'py>(&self, py: Python<'py>) -> PyValue<'py> {
        to_python(py, &self.of.errors.classes[0])
    }

    /// Numbers and spread, as in `away`, at silhouettes; None for a list of rays.
    #[getter]
    fn silhouettes<'py>(&self, py: Python<'py>) -> PyResult<Given<'py>> {
        let pixels = self.of.pixels();
        pixels.map(|_| to_python(py, &self.of.errors.classes[1])).transpose()
    }

    /// Numbers of rays, wrong ids, false hits, false misses, wrong objects and wrong rays.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let sum = |count: fn(&ErrorStats) -> u64| self.of.errors.classes.iter().map(count).sum();
        let counts: [(&str, u64); 6] = [
            ("rays", sum(|class| class.rays)),
            ("wrong_ids", sum(|class| class.wrong_ids)),
            ("false_hits", sum(|class| class.false_hits)),
            ("false_misses", sum(|class| class.false_misses)),
            ("wrong_object", sum(|class| class.wrong_object)),
            ("wrong", self.of.wrong_rays().count() as u64),
        ];
        counts.into_py_dict(py)
    }

    /// Indices of the rays or pixels, row by row, with an error beyond the allowed one.
    #[getter]
    fn wrong<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        indices(py, self.of.wrong_rays())
    }

    /// Worst errors of each kind: the claim about a ray, and the exact value.
    #[getter]
    fn worst<'py>(&self, py: Python<'py>) -> PyValue<'py> {
        to_python(py, &self.of.worst(self.n_worst, |_| None))
    }

    /// Errors as colours: false hits red, false misses orange, other objects yellow, errors of t and normals blue;
    /// None for a list of rays.
    #[getter]
    fn picture<'py>(&self, py: Python<'py>) -> PyResult<Given<'py>> {
        let picture = self.of.picture();
        picture.map(|(size, colors)| tinted(py, size, &colors, Vec::new())).transpose()
    }

    /// Errors of one ray beyond the allowed ones, by its index or a pixel's (column, row), as in `worst`.
    fn at<'py>(&self, py: Python<'py>, at: &Bound<'py, PyAny>) -> PyValue<'py> {
        to_python(py, &self.of.of_ray(self.index(at)?))
    }

    /// Explanation of a ray, by its index or a pixel's (column, row).
    #[pyo3(signature = (at, *, all = false, lang = "en", digits = 6))]
    fn explain(
        &self,
        py: Python<'_>,
        at: &Bound<'_, PyAny>,
        all: bool,
        lang: &str,
        digits: usize,
    ) -> PyResult<PyExplanation> {
        let ray = self.index(at)?;
        let HitComparison { scene, rays, .. } = &self.of.comparison;
        let ray = match rays {
            Rays::Pixels(pixels) => {
                let (x, y) = pixels.xy(ray);
                Rays::Pixels(Pixels { x, y, width: 1, height: 1, ..*pixels })
            }
            Rays::List(rays) => Rays::List(vec![rays[ray]]),
        };
        explained(py, scene, &ray, all, lang, digits, "cpu")
    }
}

/// Returns the text that the program prints, with the calls of Python that explain a ray.
fn in_words(of: &HitDifference, n_worst: usize) -> String {
    let how = |ray| match of.pixels() {
        Some(pixels) => {
            let ((x, y), w, h) = (pixels.xy(ray), pixels.image_width, pixels.image_height);
            format!("scene.explain(camera, ({x}, {y}), size=({w}, {h}))")
        }
        None => format!("scene.explain(ray=(origins[{ray}], directions[{ray}]))"),
    };
    let what = match of.pixels() {
        Some(pixels) => format!("{}×{}", pixels.width, pixels.height),
        None => format!("{} rays", of.comparison.rays.len()),
    };
    let (compared, scene) = (of.quantities().join(", "), &of.comparison.scene);
    let (spheres, planes) = (scene.spheres.len(), scene.planes.len());
    let worst = of.worst(n_worst, |ray| Some(how(ray)));
    format!(
        "{what}, {compared} against exact arithmetic (spheres: {spheres}, planes: {planes})\n\n"
    ) + &of.in_words(&worst, |names| format!("transform=\"{names}\""))
}

/// A comparison with a scene, as the program prints it.
#[derive(Serialize)]
struct SceneSummary<'a> {
    transforms: Vec<String>,
    hits: Option<HitSummary>,
    picture: Option<&'a PictureDifference>,
    broken: &'a [String],
}

/// Differences of a picture or hits from a scene.
#[pyclass(frozen, extends = Outcome, name = "Comparison", module = "kugelblitz")]
pub struct SceneOutcome {
    hits: Option<Py<HitOutcome>>,
    colors: Option<Py<PictureOutcome>>,
}

impl SceneOutcome {
    /// Returns the verdict on a picture or hits to which these transforms were applied.
    pub fn new<'py>(
        py: Python<'py>,
        transforms: &[Transform],
        hits: Option<Bound<'py, HitOutcome>>,
        colors: Option<Bound<'py, PictureOutcome>>,
    ) -> PyResult<Bound<'py, Self>> {
        let bases =
            [hits.as_ref().map(|hits| hits.as_super()), colors.as_ref().map(|it| it.as_super())];
        let bases = || bases.iter().flatten().map(|base| base.get());
        let broken: Vec<String> = bases().flat_map(|base| base.broken.clone()).collect();
        let summary = SceneSummary {
            transforms: transforms.iter().map(Transform::to_string).collect(),
            hits: hits.as_ref().map(|hits| hits.get().summary()),
            picture: colors.as_ref().map(|colors| &colors.get().of),
            broken: &broken,
        };
        let text: Vec<&str> = bases().map(|base| &*base.text).collect();
        let praise = "all is within the allowed errors";
        let base = Outcome::new(broken.clone(), &summary, text.join("\n"), praise)?;
        let parts =
            SceneOutcome { hits: hits.map(Bound::unbind), colors: colors.map(Bound::unbind) };
        Bound::new(py, (parts, base))
    }
}

#[pymethods]
impl SceneOutcome {
    /// Differences of ids, t and normals; None without them.
    #[getter]
    fn hits(&self) -> Option<&Py<HitOutcome>> {
        self.hits.as_ref()
    }

    /// Differences of the colours; None without them.
    #[getter]
    fn colors(&self) -> Option<&Py<PictureOutcome>> {
        self.colors.as_ref()
    }

    /// Transforms that explain the errors; None if there are none.
    #[getter]
    fn explained_by(&self) -> Option<&str> {
        let of_hits = self.hits.as_ref().and_then(|hits| hits.get().explained_by());
        of_hits.or_else(|| self.colors.as_ref()?.get().explained_by())
    }

    /// Errors as colours, of hits if there are any.
    #[getter]
    fn picture<'py>(&self, py: Python<'py>) -> PyResult<Given<'py>> {
        match (&self.hits, &self.colors) {
            (Some(hits), _) => hits.get().picture(py),
            (None, Some(colors)) => colors.get().picture(py),
            (None, None) => Ok(None),
        }
    }
}

fn transforms(found: &Option<TransformMatch>) -> Option<&str> {
    found.as_ref().map(|found| found.transforms.as_str())
}
