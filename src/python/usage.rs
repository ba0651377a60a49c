//! Where receivers lie in their maps, and how many pixels read each texel.

use numpy::{PyArray2, PyArray3};
use pyo3::prelude::*;

use super::camera::{PyCamera, camera};
use super::convert::{image, run_watched, size2};
use super::gbuffer::{PyGBuffer, gbuffer};
use super::light::light;
use super::parameterization::as_parameterization;
use super::render::filter_of;
use crate::aliasing::usage;
use crate::scene::Light;

/// Where each pixel's receiver lies in its map: (H, W, 2) float64 and (H, W) int16.
#[pyfunction]
#[pyo3(signature = (gbuffer, camera, light, parameterization, *, resolution=None))]
#[allow(clippy::type_complexity)]
pub fn texel_coordinates<'py>(
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: Light,
    parameterization: &Bound<'py, PyAny>,
    resolution: Option<&Bound<'py, PyAny>>,
) -> PyResult<(Bound<'py, PyArray3<f64>>, Bound<'py, PyArray2<i16>>)> {
    let py = parameterization.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let resolution = resolution.map_or(Ok(p.resolution), |r| size2(r, "resolution"))?;
    let camera = &camera.get().camera;
    let (located, size) = gbuffer.get().with_surfaces(py, |surfaces| {
        let work = |progress: &_| usage::locate(surfaces, camera, &light, p, resolution, progress);
        Ok((run_watched(py, None, work)?, surfaces.size))
    })?;
    let [w, h] = size.map(|n| n as usize);
    Ok((image(py, located.texel.into_flattened(), [h, w, 2])?, image(py, located.map, [h, w])?))
}

/// How many pixels read each texel: (K, H, W) uint32.
#[pyfunction]
#[pyo3(signature = (gbuffer, camera, light, parameterization, *, resolution=None, filter=None),
    text_signature = "(gbuffer, camera, light, parameterization, *, resolution=None, filter='nearest')")]
pub fn reads<'py>(
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: Light,
    parameterization: &Bound<'py, PyAny>,
    resolution: Option<&Bound<'py, PyAny>>,
    filter: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray3<u32>>> {
    let py = parameterization.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let resolution = resolution.map_or(Ok(p.resolution), |r| size2(r, "resolution"))?;
    let taps = (2.0 * filter_of(py, filter)?.reach_texels()) as u32;
    let camera = &camera.get().camera;
    let layers = p.partitions.len();
    let counts = gbuffer.get().with_surfaces(py, |surfaces| {
        run_watched(py, None, |progress| {
            let located = usage::locate(surfaces, camera, &light, p, resolution, progress)?;
            usage::reads(&located, layers, resolution, taps, progress)
        })
    })?;
    let [w, h] = resolution.map(|n| n as usize);
    image(py, counts, [layers, h, w])
}
