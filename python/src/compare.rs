//! Comparisons of pictures, hits and scenes.

use std::sync::Arc;

use kugelblitz::picture::Image;
use kugelblitz::query::Kernel;
use kugelblitz::rays::Rays;
use kugelblitz::scene;
use kugelblitz_judge::compare::{
    Allowed, ColorKind, ExactChannels, HitComparison, PictureDifference, Quantity, Transform,
    compare_pictures, exact_picture, explain_pictures, pixels_of, quantities_of, whole_size,
};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyMapping;

use crate::argument::{Crop, SamplesArgument, Size, rays_of};
use crate::camera::PyCamera;
use crate::error::{self, wrong_value};
use crate::image::{Arrays, image_of};
use crate::picture::PyPicture;
use crate::scene::PyScene;
use crate::table::{Given, PyValue, helpers};
use crate::verdict::{HitOutcome, PictureOutcome, SceneOutcome};
use crate::work;

/// Transforms as one text with commas, or as several.
#[derive(FromPyObject)]
pub enum Transforms {
    /// One text.
    Text(String),
    /// Several texts.
    List(Vec<String>),
}

impl Transforms {
    fn parsed(given: Option<Transforms>) -> PyResult<Vec<Transform>> {
        let names = match given {
            None => Vec::new(),
            Some(Transforms::List(names)) => names,
            Some(Transforms::Text(text)) => text.split(',').map(str::to_owned).collect(),
        };
        let names = names.iter().map(|name| name.trim()).filter(|name| !name.is_empty());
        let parsed: kugelblitz::Result<Vec<Transform>> = names.map(str::parse).collect();
        parsed.map_err(error::of("transform"))
    }
}

/// Options of a comparison with a scene.
struct WithScene<'a, 'py> {
    camera: Option<&'a PyCamera>,
    rays: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    size: Option<Size>,
    crop: Option<Crop>,
    samples: Option<SamplesArgument>,
    transforms: Vec<Transform>,
    allowed: Allowed,
    worst: usize,
    device: &'a str,
    progress: Given<'py>,
}

/// Compares two of: a `Scene`, a `Picture`, hits, arrays, paths of files.
///
/// A scene stands for its exact picture, and returns a `Comparison`. What is compared with it may be a `Picture`, `Hits`, a
/// structured array, a dictionary of arrays with the keys `id`, `t`, `distance`, `normal` and `rgb`, or a file; arrays have the
/// shape (height, width), or (N,) for `rays`, which are (origins, directions). Without a `camera`, it is that of the picture or of
/// the scene. Two pictures are compared channel by channel, and return a `Difference`: `Picture`s, arrays of colours
/// (height, width, 3), structured arrays, or files. Bytes and 16 bits are sRGB, floats linear; numbers of different types are
/// compared as the one that has fewer of them.
///
/// `allow` sets the limits of allowed errors, e.g. "ids=0.01%,silhouettes=5%,t=2ulp,normal=0.1" of hits and
/// "levels=1,ulp=4,difference=1e-6,pixels=0.1%" of colours. `transform` names transforms of `a`, or of what is compared with the
/// scene, e.g. "flip-rows,ids+1". `worst` errors of each kind are shown.
#[pyfunction]
#[pyo3(signature = (
    a, b, *, camera = None, rays = None, size = None, crop = None, samples = None, transform = None, allow = "",
    worst = 3, device = "auto", progress = None
))]
pub fn compare<'py>(
    py: Python<'py>,
    a: &Bound<'py, PyAny>,
    b: &Bound<'py, PyAny>,
    camera: Option<&PyCamera>,
    rays: Option<(Bound<'py, PyAny>, Bound<'py, PyAny>)>,
    size: Option<Size>,
    crop: Option<Crop>,
    samples: Option<SamplesArgument>,
    transform: Option<Transforms>,
    allow: Option<&str>,
    worst: usize,
    device: &str,
    progress: Given<'py>,
) -> PyValue<'py> {
    let transforms = Transforms::parsed(transform)?;
    let allowed: Allowed = allow.unwrap_or_default().parse().map_err(error::of("allow"))?;
    let has_options =
        camera.is_some() || rays.is_some() || size.is_some() || crop.is_some() || samples.is_some();
    let options = WithScene {
        camera,
        rays,
        size,
        crop,
        samples,
        transforms,
        allowed,
        worst,
        device,
        progress,
    };
    match [a.cast::<PyScene>().ok(), b.cast::<PyScene>().ok()] {
        [None, None] if has_options => {
            wrong_value("camera, rays, size, crop, samples: they are for a comparison with a Scene")
        }
        [None, None] => {
            let (a, b) = (image_of("a", a)?, image_of("b", b)?);
            of_pictures(py, a, b, &options.transforms, &options.allowed)
        }
        [Some(scene), None] => with_scene(py, b, scene.get(), options),
        [None, Some(scene)] => with_scene(py, a, scene.get(), options),
        [Some(a), Some(b)] => {
            let picture = |scene: &PyScene| {
                let WithScene { camera, size, crop, samples, device, .. } = options;
                let pixels = crate::argument::pixels_of(py, &scene.of, camera, size, crop)?;
                let n_samples = n_samples(samples, None, &scene.of);
                let on = (device, Kernel::Certified, pixels.len());
                scene.run(py, on, (None, 0), |session, control| {
                    exact_picture(session, &pixels, n_samples, ExactChannels::All, control)
                })
            };
            let (a, b) = (picture(a.get())?, picture(b.get())?);
            of_pictures(py, a, b, &options.transforms, &options.allowed)
        }
    }
}

fn n_samples(
    given: Option<SamplesArgument>,
    picture: Option<&PyPicture>,
    scene: &scene::Scene,
) -> scene::Samples {
    let of_picture = picture.map(PyPicture::n_samples);
    given.map(|SamplesArgument(n)| n).or(of_picture).or(scene.samples).unwrap_or_default()
}

/// Compares two pictures channel by channel.
fn of_pictures<'py>(
    py: Python<'py>,
    mut a: Image,
    b: Image,
    transforms: &[Transform],
    allowed: &Allowed,
) -> PyValue<'py> {
    allowed.check_used(false, true).map_err(error::of("allow"))?;
    if let Some(other) = transforms.iter().find(|transform| !transform.is_of_files()) {
        return wrong_value(format!(
            "transform: only flips can be applied to two pictures, not {other}"
        ));
    }
    transforms.iter().for_each(|transform| transform.apply_to_image(&mut a));
    let of = work::run(py, |_| difference(["a", "b"], [&a, &b], allowed))?;
    Ok(PictureOutcome::new(py, a, of)?.into_any())
}

fn difference(
    names: [&str; 2],
    images: [&Image; 2],
    allowed: &Allowed,
) -> kugelblitz::Result<PictureDifference> {
    let mut found = compare_pictures(names, images, allowed)?;
    if !found.broken.is_empty() {
        found.explained_by = explain_pictures(images, allowed, &found)?;
    }
    Ok(found)
}

/// Compares pictures or hits with a scene.
fn with_scene<'py>(
    py: Python<'py>,
    given: &Bound<'py, PyAny>,
    scene: &PyScene,
    options: WithScene<'_, 'py>,
) -> PyValue<'py> {
    let picture = given.cast::<PyPicture>().ok().map(Bound::get);
    let (mut image, quantities) = foreign(given)?;
    let rays = rays(py, &scene.of, picture, &image, &options)?;
    let has_hits = quantities.iter().any(|quantity| quantity.is_of_hits());
    let pixels = rays.pixels().copied().filter(|_| quantities.contains(&Quantity::Color));
    let WithScene { samples, transforms, allowed, worst, device, progress, .. } = options;
    allowed.check_used(has_hits, pixels.is_some()).map_err(error::of("allow"))?;
    let n_samples = n_samples(samples, picture, &scene.of);
    let n_rays = rays.len();
    let comparison = HitComparison {
        scene: Arc::clone(&scene.of),
        rays,
        image: image.clone(),
        quantities,
        channel: None,
        transforms: transforms.clone(),
        allowed: allowed.clone(),
    };
    let on = (device, Kernel::Certified, n_rays);
    transforms.iter().for_each(|transform| transform.apply_to_image(&mut image));
    image.channels.retain(|channel| matches!(channel.name.as_str(), "R" | "G" | "B"));
    let work = |session: &mut kugelblitz::Session, control: &kugelblitz::Control| {
        let hits = has_hits.then(|| comparison.run(session, control)).transpose()?;
        let Some((pixels, kind)) = pixels.zip(ColorKind::of(&image)) else {
            return Ok((hits, None));
        };
        let channels = ExactChannels::Colors(kind);
        let mut exact = exact_picture(session, &pixels, n_samples, channels, control)?;
        (exact.whole, exact.first) = (image.whole, image.first);
        let names = ["the picture", "the scene"];
        Ok((hits, Some(difference(names, [&image, &exact], &allowed)?)))
    };
    let (hits, colors) = scene.run(py, on, (progress, 2 * n_rays as u64), work)?;
    let hits = hits.map(|of| HitOutcome::new(py, of, worst)).transpose()?;
    let colors = colors.map(|of| PictureOutcome::new(py, image, of)).transpose()?;
    Ok(SceneOutcome::new(py, &transforms, hits, colors)?.into_any())
}

/// Returns the channels of a picture or hits, and the quantities that they are of.
fn foreign(given: &Bound<'_, PyAny>) -> PyResult<(Image, Vec<Quantity>)> {
    if let Ok(mapping) = given.cast::<PyMapping>() {
        let found = helpers(given.py())?.call_method1("mapping", (mapping,))?;
        let (arrays, names): (Arrays<'_>, Vec<String>) = found.extract()?;
        let quantities = names.iter().map(|name| name.parse()).collect::<kugelblitz::Result<_>>();
        return Ok((arrays.image()?, quantities.map_err(error::of("a"))?));
    }
    let image = image_of("a", given)?;
    let quantities = quantities_of(&image, None).map_err(error::of(""))?;
    Ok((image, quantities))
}

/// Returns the rays that are compared.
fn rays(
    py: Python<'_>,
    scene: &scene::Scene,
    picture: Option<&PyPicture>,
    image: &Image,
    options: &WithScene<'_, '_>,
) -> PyResult<Rays> {
    let &WithScene { camera, ref rays, size, crop, .. } = options;
    if let Some((origins, directions)) = rays {
        if camera.is_some() || size.is_some() || crop.is_some() {
            return wrong_value("camera, size, crop: they are of a picture; rays have none");
        }
        return rays_of(origins, directions).map(Rays::List);
    }
    if image.is_list {
        return Err(PyTypeError::new_err("rays: hits of a list need (origins, directions)"));
    }
    if let (Some(picture), None) = (picture, camera) {
        return Ok(Rays::Pixels(picture.pixels()));
    }
    let size = whole_size(image, size.map(|Size(size)| size), crop.map(|Crop(crop)| crop));
    let size = size.map_err(error::of(""))?.map(Size);
    let pixels = crate::argument::pixels_of(py, scene, camera, size, crop)?;
    match crop {
        Some(_) => Ok(Rays::Pixels(pixels)),
        None => pixels_of(image, pixels).map(Rays::Pixels).map_err(error::of("")),
    }
}
