//! A scene as pickle keeps it: rows, colours, names, the rest as the text of a scene file, and how numbers became
//! colours.

use std::collections::HashMap;

use kugelblitz::scene::{Color, ColorMap, Coloring, Spheres, parse_scene};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::argument::in_rows;
use crate::error;
use crate::given::colored;
use crate::scene::PyScene;

/// What [`scene_of_state`] takes.
pub type PickledScene<'py> = (
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyAny>,
    HashMap<u32, String>,
    String,
    Option<StateOfColoring>,
    Vec<String>,
);

/// A [`Coloring`], its map by name or by its colours.
type StateOfColoring = (String, StateOfMap, [f64; 2], [f64; 3], usize);

/// The name of a [`ColorMap`], or the bytes of its colours.
type StateOfMap = (Option<String>, Vec<u8>);

/// What pickle keeps of a scene.
pub fn state_of<'py>(py: Python<'py>, scene: &PyScene) -> PyResult<PickledScene<'py>> {
    let spheres = &scene.of.spheres;
    let names = (0..spheres.len())
        .filter_map(|index| Some((index as u32, spheres.name(index)?.to_string())));
    let names = if spheres.has_names() { names.collect() } else { HashMap::new() };
    let of_all = spheres.color(0).unwrap_or(Spheres::COLOR);
    let colors = if spheres.colors().all(|color| color == of_all) {
        PyArray1::from_slice(py, &of_all.0).into_any()
    } else {
        scene.colors(py)?.into_any()
    };
    let colorings = scene.colorings().map(|coloring| {
        let Coloring { column, map, range, missing_color, n_missing } = coloring;
        let name = map.known_name();
        let colors = if name.is_none() { map.srgb8().as_flattened().to_vec() } else { Vec::new() };
        (column.clone(), (name, colors), *range, missing_color.0, *n_missing)
    });
    let text = scene.of.text_without_spheres();
    Ok((scene.spheres(py)?, colors, names, text, colorings.last(), scene.notes()))
}

/// The scene of what [`state_of`] gave.
#[pyfunction]
#[pyo3(signature = (*state))]
pub fn scene_of_state(py: Python<'_>, state: PickledScene<'_>) -> PyResult<PyScene> {
    let (rows, colors, names, text, coloring, notes) = state;
    let mut scene = parse_scene(&text, "a pickled scene".as_ref()).map_err(error::of(""))?;
    scene.spheres = colored(py, in_rows(&rows.readonly())?, Some(colors.extract()?), true)?;
    names.into_iter().for_each(|(index, name)| scene.spheres.set_name(index, name));
    scene.notes = notes.into_iter().map(Into::into).collect();
    let map_of = |(name, colors): StateOfMap| match colors.as_chunks().0.try_into() {
        Ok(colors) => ColorMap::from_srgb8(colors),
        Err(_) => name.and_then(|name| ColorMap::from_name(&name)).unwrap_or_default(),
    };
    let coloring = coloring.map(|(column, map, range, missing_color, n_missing)| Coloring {
        column,
        map: map_of(map),
        range,
        missing_color: Color(missing_color),
        n_missing,
    });
    Ok(PyScene::new_colored(scene, coloring))
}
