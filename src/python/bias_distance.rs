//! How far a bias carries each receiver of an image.

use numpy::PyArray2;
use pyo3::prelude::*;

use super::bias::bias;
use super::camera::{PyCamera, camera};
use super::convert::{image, run_watched};
use super::gbuffer::{PyGBuffer, gbuffer};
use super::light::light;
use super::mask_settings::settings_of;
use super::parameterization::as_parameterization;
use super::stored::stored;
use crate::render::cpu::lookup::bias_distance as distance;
use crate::render::{Bias, Stored};
use crate::scene::Light;

/// The bias of each pixel, (H, W) float32, world units along its light ray; NaN where nothing is compared.
#[pyfunction]
#[pyo3(signature = (gbuffer, camera, light, parameterization, *, resolution=None, bias=None, filter=None, stored=None),
    text_signature = "(gbuffer, camera, light, parameterization, *, resolution=None, bias=None, filter='nearest', stored=None)")]
#[allow(clippy::too_many_arguments)]
pub fn bias_distance<'py>(
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: Light,
    parameterization: &Bound<'py, PyAny>,
    resolution: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = bias)] bias: Option<Bias>,
    filter: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = stored)] stored: Option<Stored>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let py = parameterization.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let settings = settings_of(py, p, resolution, gbuffer.get().whole_picture(), (bias, filter, None, stored))?;
    let camera = &camera.get().camera;
    let (found, size) = gbuffer.get().with_surfaces(py, |surfaces| {
        let work = |progress: &_| distance(surfaces, camera, &light, p, &settings, progress);
        Ok((run_watched(py, None, work)?, surfaces.size))
    })?;
    let [w, h] = size.map(|n| n as usize);
    image(py, found, [h, w])
}
