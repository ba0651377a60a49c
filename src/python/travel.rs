//! `restore`: the value of a state, whatever its class.

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::PyTuple;

use super::aliasing::PyMisclassified;
use super::bias::PyBias;
use super::camera::PyCamera;
use super::gbuffer::PyGBuffer;
use super::light::{PyDirectionalLight, PyPointLight, PySpotLight};
use super::mesh::PyMesh;
use super::note::PyNote;
use super::parameterization::{PyParameterization, PyPartition};
use super::sample_states;
use super::samples::PySamples;
use super::scene::PyScene;
use super::scene_states::{restored_mesh, restored_scene};
use super::state::{Parts, State};
use super::stored::PyStored;
use super::technique::PyTechnique;

/// The value that was pickled: what `__reduce__` of every class names, with its state as arguments.
///
/// Raises
/// ------
/// StateError
///     For a state that is damaged, or that a newer version wrote.
#[pyfunction]
#[pyo3(signature = (*parts))]
pub fn restore<'py>(parts: &Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    let py = parts.py();
    let parts = Parts::of(parts)?;
    macro_rules! object {
        ($value:expr) => {
            Ok(Bound::new(py, $value)?.into_any())
        };
    }
    match parts.name.as_str() {
        PyBias::NAME => object!(parts.value::<PyBias>(py)?),
        PyCamera::NAME => object!(parts.value::<PyCamera>(py)?),
        PyDirectionalLight::NAME => object!(parts.value::<PyDirectionalLight>(py)?),
        PyNote::NAME => object!(parts.value::<PyNote>(py)?),
        PyParameterization::NAME => object!(parts.value::<PyParameterization>(py)?),
        PyPartition::NAME => object!(parts.value::<PyPartition>(py)?),
        PyPointLight::NAME => object!(parts.value::<PyPointLight>(py)?),
        PySpotLight::NAME => object!(parts.value::<PySpotLight>(py)?),
        PyStored::NAME => object!(parts.value::<PyStored>(py)?),
        PyTechnique::NAME => object!(parts.value::<PyTechnique>(py)?),
        "GBuffer" => object!(PyGBuffer::restored(py, &parts)?),
        "Mesh" => object!(PyMesh { mesh: Arc::clone(&restored_mesh(py, &parts)?) }),
        "Misclassified" => object!(PyMisclassified::restored(py, &parts)?),
        sample_states::NAME => object!(PySamples { samples: sample_states::restored(py, &parts)? }),
        "Scene" => object!(PyScene::from(restored_scene(py, &parts)?)),
        _ => Err(parts.error(py, "this version has no such class: it is damaged, or of a newer shadowlab")),
    }
}
