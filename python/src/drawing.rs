//! Drawings and pictures that no camera took.

use std::io::Write;
use std::path::PathBuf;

use kugelblitz::Error;
use kugelblitz::control::Control;
use kugelblitz::output::{self, OutputFile};
use kugelblitz::picture::rgb8_file;
use kugelblitz::scene::{self, hex, parse_scene};
use kugelblitz_judge::figure::Figure;
use numpy::{PyArray1, PyArray3, PyArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::argument::Size;
use crate::camera::Camera;
use crate::error;
use crate::rays::pixels_of;
use crate::scene::Scene;
use crate::work;

/// A drawing in SVG. A notebook shows it; `str()` is its text.
#[pyclass(frozen, module = "kugelblitz")]
pub struct Drawing {
    pub svg: String,
}

#[pymethods]
impl Drawing {
    /// Writes a file, whose name ends in .svg.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        require_ending(&path, "svg", "a drawing")?;
        work::run(py, None, 0, |control| write(path, self.svg.as_bytes(), control))
    }

    fn _repr_svg_(&self) -> &str {
        &self.svg
    }

    fn __str__(&self) -> &str {
        &self.svg
    }

    fn __repr__(&self) -> String {
        format!("<Drawing: {} bytes of SVG>", self.svg.len())
    }
}

fn require_ending(path: &std::path::Path, ending: &str, what: &str) -> PyResult<()> {
    match path.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending)) {
        true => Ok(()),
        false => {
            let path = path.display();
            Err(PyValueError::new_err(format!(
                "path: {what} is a file that ends in .{ending}, not {path}"
            )))
        }
    }
}

/// Writes a file that appears whole or not at all.
fn write(path: PathBuf, bytes: &[u8], control: &Control) -> kugelblitz::Result<()> {
    let mut file = OutputFile::create(&path, false)?;
    file.write_all(bytes).map_err(Error::io(&path))?;
    output::commit([file], control)
}

/// Draws the lecture's figure 3, a plane, or 4, a sphere, as the camera sees it.
///
/// `scene` is the lecture's unless one is given, and `object` the id of what is drawn, else the first plane or
/// sphere. `size` is (columns, rows), `lang` "en" or "de". A figure fits over the picture of its size.
#[pyfunction]
#[pyo3(signature = (number, scene = None, camera = None, *, size = None, object = None, lang = "en"))]
pub fn figure(
    number: &Bound<'_, PyAny>,
    scene: Option<&Scene>,
    camera: Option<&Camera>,
    size: Option<Size>,
    object: Option<u32>,
    lang: &str,
) -> PyResult<Drawing> {
    let number = number.str()?.to_string();
    let figure = Figure::ALL.into_iter().find(|figure| figure.number() == number);
    let figure = figure.ok_or_else(|| {
        PyValueError::new_err(format!("number: there is no figure {number}; give 3 or 4"))
    })?;
    let own: scene::Scene;
    let scene = match scene {
        Some(scene) => &scene.of,
        None => {
            let (name, text) = figure.scene();
            own = parse_scene(text, name.as_ref()).map_err(error::of(""))?;
            &own
        }
    };
    let pixels = pixels_of(scene, camera, size, None)?;
    let object = match object {
        Some(id) => id,
        None => figure.object(scene).map_err(error::of("scene"))?,
    };
    let drawn = figure.draw(scene, object, &pixels, crate::explain::lang(lang)?);
    Ok(Drawing { svg: drawn.map_err(error::of("object"))? })
}

/// A picture of numbers: depths, errors or others as colours, with their legend. A notebook shows it.
#[pyclass(frozen, module = "kugelblitz")]
pub struct Tinted {
    pub size: [u32; 2],
    pub colors: Vec<[u8; 3]>,
    /// Colour, meaning, and how many pixels have it where they are counted.
    pub legend: Vec<([u8; 3], String, Option<u64>)>,
}

#[pymethods]
impl Tinted {
    /// Colours in sRGB, bytes; shape (height, width, 3).
    #[getter]
    fn rgb8<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<u8>>> {
        let [width, height] = self.size.map(|n| n as usize);
        PyArray1::from_slice(py, self.colors.as_flattened()).reshape([height, width, 3])
    }

    /// What the colours mean: ("#rrggbb", meaning, pixels or `None`).
    #[getter]
    fn legend(&self) -> Vec<(String, String, Option<u64>)> {
        let entry = |(color, meaning, n): &([u8; 3], String, Option<u64>)| {
            (hex(*color), meaning.clone(), *n)
        };
        self.legend.iter().map(entry).collect()
    }

    /// Writes a file, whose name ends in .png.
    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        require_ending(&path, "png", "this picture")?;
        work::run(py, None, 0, |control| {
            let bytes = rgb8_file(self.size, &self.colors).map_err(Error::io(&path))?;
            write(path, &bytes, control)
        })
    }

    fn _repr_png_<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let path = PathBuf::from("picture");
        let png =
            rgb8_file(self.size, &self.colors).map_err(Error::io(&path)).map_err(error::of(""))?;
        Ok(PyBytes::new(py, &png))
    }

    fn __repr__(&self) -> String {
        let [width, height] = self.size;
        format!("<Tinted: {width}×{height} pixels, {} colours with a meaning>", self.legend.len())
    }
}
