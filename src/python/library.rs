//! The procedural scenes.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use super::arguments::{items, word};
use super::camera::PyCamera;
use super::convert::{argument_error, number, run_watched, shown};
use super::light::light_to_object;
use super::scene::PyScene;
use crate::scene::library;

/// A library scene, its camera and its light.
type Parts<'py> = (PyScene, PyCamera, Bound<'py, PyAny>);

/// The library scene of that name, its camera and its light.
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
    let light = light_to_object(py, &built.light)?;
    Ok((PyScene::from(built.scene), PyCamera { camera: built.camera }, light))
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
