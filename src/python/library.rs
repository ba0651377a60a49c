//! The procedural scenes.

use std::sync::Arc;

use numpy::{PyArray1, PyArray3};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use super::camera::PyCamera;
use super::convert::{OrRaise, image};
use super::light::light_to_object;
use super::mesh::PyMesh;
use crate::scene::library;
use crate::threads;

/// What a library scene is made of: meshes, mesh index (I,), transforms (I, 4, 4), camera, light.
type Parts<'py> = (Vec<PyMesh>, Bound<'py, PyArray1<i64>>, Bound<'py, PyArray3<f64>>, PyCamera, Bound<'py, PyAny>);

/// The parts of the library scene of that name.
#[pyfunction]
#[pyo3(signature = (name, seed, params))]
pub fn library_build<'py>(py: Python<'py>, name: &str, seed: u64, params: Vec<(String, f64)>) -> PyResult<Parts<'py>> {
    let built = py.detach(|| threads::install(|| library::build(name, seed, &params))?).or_raise(py)?;
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
