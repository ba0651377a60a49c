//! The procedural scenes.

use std::sync::Arc;

use numpy::{PyArray1, PyArray3};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use super::arguments::{items, word};
use super::camera::PyCamera;
use super::convert::{argument_error, image, number, run_watched, shown};
use super::light::light_to_object;
use super::mesh::PyMesh;
use crate::scene::library;

/// What a library scene is made of: meshes, mesh index (I,), transforms (I, 4, 4), camera, light.
type Parts<'py> = (Vec<PyMesh>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray3<f64>>, PyCamera, Bound<'py, PyAny>);

/// The parts of the library scene of that name.
#[pyfunction]
#[pyo3(signature = (name, seed, params))]
pub fn library_build<'py>(
    py: Python<'py>,
    name: &Bound<'py, PyAny>,
    seed: &Bound<'py, PyAny>,
    params: &Bound<'py, PyAny>,
) -> PyResult<Parts<'py>> {
    let name = word(name, "name", "the name of a scene of the library")?;
    let seed: u64 = seed.extract().map_err(|_| {
        let expected = "a whole number from 0 to 2**64 - 1";
        argument_error(py, "seed", expected, shown(seed), "choose another one")
    })?;
    let params = items(params, "params", "pairs of a name and a number", "give a list")?;
    let pair = |pair: &Bound<'py, PyAny>| -> PyResult<(String, f64)> {
        let parts = items(pair, "params", "pairs of a name and a number", "give a list")?;
        let [key, value] = parts.as_slice() else {
            return Err(argument_error(py, "params", "pairs of a name and a number", shown(pair), "give a list"));
        };
        let key = word(key, "params", "the name of a parameter")?;
        let value = number(value, &key, "see shadowlab.library.table()")?;
        Ok((key, value))
    };
    let params = params.iter().map(pair).collect::<PyResult<Vec<_>>>()?;
    let built = run_watched(py, None, |progress| library::watched(&name, seed, &params, progress))?;
    let instances = built.scene.instances();
    let rows = |i: &crate::scene::Instance| glam::DMat4::from(i.world_from_mesh).transpose().to_cols_array();
    Ok((
        built.scene.meshes().iter().map(|m| PyMesh { mesh: Arc::clone(m) }).collect(),
        image(py, instances.iter().map(|i| i64::from(i.mesh)).collect(), [instances.len()])?,
        image(py, instances.iter().flat_map(rows).collect(), [instances.len(), 4, 4])?,
        PyCamera { camera: built.camera },
        light_to_object(py, &built.light)?,
    ))
}

/// One dictionary a library scene: name, title, shows, params.
#[pyfunction]
pub fn library_specs(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let list = PyList::empty(py);
    for spec in library::specs() {
        let params = PyList::empty(py);
        for p in spec.params {
            let d = PyDict::new(py);
            d.set_item("name", p.name)?;
            d.set_item("default", p.default)?;
            d.set_item("min", p.min)?;
            d.set_item("max", p.max)?;
            d.set_item("doc", p.doc)?;
            params.append(d)?;
        }
        let d = PyDict::new(py);
        d.set_item("name", spec.name)?;
        d.set_item("title", spec.title)?;
        d.set_item("shows", spec.shows)?;
        d.set_item("params", params)?;
        list.append(d)?;
    }
    Ok(list)
}
