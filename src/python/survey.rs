//! What of a view is in shadow by an ordinary map, and wrong pixels foretold from samples.

use numpy::{Element, PyArray2};
use pyo3::prelude::*;

use super::bias::bias;
use super::camera::{PyCamera, camera};
use super::convert::{array, image, run_sized, run_watched, size2};
use super::gbuffer::{PyGBuffer, gbuffer};
use super::light::light;
use super::parameterization::as_parameterization;
use super::samples::{PySamples, SOON, samples};
use super::scene::{PyScene, scene};
use crate::image::Surfaces;
use crate::progress::Progress;
use crate::render::Bias;
use crate::survey;
use crate::techniques::Needs;

/// Which pixels are in shadow by one uniform map of 1024 x 1024 texels over the body: (H, W) int8.
#[pyfunction]
#[pyo3(signature = (scene, camera, light, gbuffer))]
pub fn mapped_states<'py>(
    #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: crate::Light,
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
) -> PyResult<Bound<'py, PyArray2<i8>>> {
    of_picture(&scene, &camera, &light, &gbuffer, survey::mapped_states)
}

/// How far before what each pixel shows, towards the light, what shades it lies by that map: (H, W) float32, world units; 0 where
/// that is lit, faces away from the light, or is nothing.
#[pyfunction]
#[pyo3(signature = (scene, camera, light, gbuffer))]
pub fn mapped_gaps<'py>(
    #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: crate::Light,
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    of_picture(&scene, &camera, &light, &gbuffer, survey::mapped_gaps)
}

/// What a look at a picture's surfaces under a light finds of each pixel.
fn of_picture<'py, T: Element + Send>(
    scene: &Bound<'py, PyScene>,
    camera: &Bound<'py, PyCamera>,
    light: &crate::Light,
    gbuffer: &Bound<'py, PyGBuffer>,
    look: fn(&crate::Scene, &crate::Camera, &crate::Light, Surfaces, &Progress) -> crate::Result<Vec<T>>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let py = scene.py();
    let (scene, camera) = (&scene.get().scene, &camera.get().camera);
    let [w, h] = gbuffer.get().picture().map(|n| n as usize);
    gbuffer.get().check_samples(py)?;
    let found = gbuffer.get().with_surfaces(py, |surfaces| {
        run_watched(py, None, |progress| look(scene, camera, light, *surfaces, progress))
    })?;
    image(py, found, [h, w])
}

/// The samples with shadow states that a technique draws for itself where none are given: of a picture of about 128 by 128
/// pixels, or of one that is there.
#[pyfunction]
#[pyo3(signature = (scene, camera, light, gbuffer=None))]
pub fn drawn_samples(
    py: Python<'_>,
    #[pyo3(from_py_with = scene)] scene: Bound<'_, PyScene>,
    #[pyo3(from_py_with = camera)] camera: Bound<'_, PyCamera>,
    #[pyo3(from_py_with = light)] light: crate::Light,
    gbuffer: Option<&Bound<'_, PyAny>>,
) -> PyResult<PySamples> {
    let gbuffer = gbuffer.map(self::gbuffer).transpose()?;
    gbuffer.as_ref().map_or(Ok(()), |g| g.get().check_samples(py))?;
    let (scene, camera, needs) = (&scene.get().scene, &camera.get().camera, Needs::Shadows);
    let samples = match gbuffer {
        Some(gbuffer) => gbuffer.get().with_surfaces(py, |surfaces| {
            run_watched(py, None, |progress| {
                survey::samples_of_surfaces(scene, camera, &light, *surfaces, needs, progress).map(Some)
            })
        })?,
        None => run_watched(py, None, |progress| survey::samples_of_view(scene, camera, &light, needs, progress))?,
    };
    Ok(PySamples { samples: samples.unwrap_or_default() })
}

/// Wrong pixels foretold from samples for maps of a resolution (10.9); `gaps` (H, W) float32 as of `mapped_gaps`, of their picture.
#[pyfunction]
#[pyo3(signature = (samples, parameterization, gaps, *, resolution=None, bias=None))]
pub fn predict_wrong(
    #[pyo3(from_py_with = samples)] samples: Bound<'_, PySamples>,
    parameterization: &Bound<'_, PyAny>,
    gaps: &Bound<'_, PyAny>,
    resolution: Option<&Bound<'_, PyAny>>,
    #[pyo3(from_py_with = bias)] bias: Option<Bias>,
) -> PyResult<f64> {
    let py = parameterization.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let resolution = resolution.map_or(Ok(p.resolution), |r| size2(r, "resolution"))?;
    let samples = &samples.get().samples;
    let shape = samples
        .picture
        .as_ref()
        .map_or([None; 2], |picture| [picture.size[1], picture.size[0]].map(|n| Some(n as usize)));
    let gaps = array::<f32>(gaps, "gaps", &shape)?;
    let (gaps, bias) = (gaps.as_slice()?, bias.unwrap_or_default());
    run_sized(py, samples.len() > SOON, |progress| survey::predict(samples, p, resolution, gaps, bias, progress))
}
