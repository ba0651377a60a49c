//! Lookups into maps that are there, and why pixels are wrong.

use numpy::{PyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use super::bias::bias;
use super::camera::{PyCamera, camera};
use super::convert::{argument_error, array, image, run_watched};
use super::exceptions::refusable;
use super::filter::{filter_of, unwarned_blend};
use super::gbuffer::{PyGBuffer, gbuffer};
use super::light::light;
use super::mask_settings::settings_of;
use super::parameterization::as_parameterization;
use super::scene::{PyScene, scene};
use super::stored::stored;
use crate::diagnose_pixels::{Wrong, causes as core_causes};
use crate::render::cpu::look_up as core_look_up;
use crate::render::{Bias, MaskSettings, Stored};
use crate::scene::Light;

/// The shadow mask of surfaces through maps that are there: (H, W) float32, and which map each pixel asks (H, W) int16.
#[pyfunction]
#[pyo3(signature = (maps, gbuffer, camera, light, parameterization, *, bias=None, filter=None, blend=None, stored=None),
    text_signature = "(maps, gbuffer, camera, light, parameterization, *, bias=None, filter='nearest', blend=0.0, stored=None)")]
#[allow(clippy::too_many_arguments, clippy::type_complexity)]
pub fn look_up<'py>(
    maps: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: Light,
    parameterization: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = bias)] bias: Option<Bias>,
    filter: Option<&Bound<'py, PyAny>>,
    blend: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = stored)] stored: Option<Stored>,
) -> PyResult<(Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<i16>>)> {
    let py = maps.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let (maps, resolution) = layers(maps, p.partitions.len())?;
    let maps = maps.as_slice()?;
    let camera = &camera.get().camera;
    let settings = settings_of(py, p, None, gbuffer.get().whole_picture(), (bias, filter, blend, stored))?;
    let settings = MaskSettings { resolution, ..settings };
    let mask = gbuffer.get().with_surfaces(py, |surfaces| {
        run_watched(py, None, |progress| core_look_up(maps, *surfaces, camera, &light, p, &settings, progress))
    })?;
    let [w, h] = mask.size.map(|n| n as usize);
    Ok((image(py, mask.data, [h, w])?, image(py, mask.partition, [h, w])?))
}

/// Why pixels are wrong: (H, W) int8 causes, and (H, W) float32 how far a displaced edge lies from each pixel, in pixels; see
/// `shadowlab.aliasing.causes`.
#[pyfunction]
#[pyo3(signature = (scene, camera, light, parameterization, differences, *, gbuffer, maps, bias=None, filter=None, blend=None,
    stored=None),
    text_signature = "(scene, camera, light, parameterization, differences, *, gbuffer, maps, bias=None, filter='nearest', \
                      blend=0.0, stored=None)")]
#[allow(clippy::too_many_arguments, clippy::type_complexity)]
pub fn causes<'py>(
    #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: Light,
    parameterization: &Bound<'py, PyAny>,
    differences: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    maps: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = bias)] bias: Option<Bias>,
    filter: Option<&Bound<'py, PyAny>>,
    blend: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = stored)] stored: Option<Stored>,
) -> PyResult<(Bound<'py, PyArray2<i8>>, Bound<'py, PyArray2<f32>>)> {
    let py = maps.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let (maps, resolution) = layers(maps, p.partitions.len())?;
    let maps = maps.as_slice()?;
    let (filter, blend, stored) = (filter_of(py, filter)?, unwarned_blend(py, blend)?, stored.unwrap_or_default());
    let (camera, scene) = (&camera.get().camera, scene.get());
    gbuffer.get().with_surfaces(py, |surfaces| {
        let [w, h] = surfaces.size.map(|n| n as usize);
        let differences = array::<i8>(differences, "differences", &[Some(h), Some(w)])?;
        let differences = differences.as_slice()?;
        let (size, bias) = (gbuffer.get().whole_picture(), bias.unwrap_or_default());
        let settings = MaskSettings { resolution, size, bias, filter, blend, stored };
        let tracer = &*scene.tracer(py, None)?;
        let (causes, distance) = run_watched(py, None, |progress| {
            let (scene, light, settings, surfaces) = (&scene.scene, &light, &settings, *surfaces);
            let parameterization = p;
            let of = Wrong { scene, tracer, surfaces, camera, light, maps, parameterization, settings, differences };
            core_causes(&of, progress)
        })?;
        Ok((image(py, causes, [h, w])?, image(py, distance, [h, w])?))
    })
}

/// The maps as (K, H, W) or, of one, (H, W), with their width and height.
fn layers<'py>(maps: &Bound<'py, PyAny>, count: usize) -> PyResult<(numpy::PyReadonlyArrayDyn<'py, f32>, [u32; 2])> {
    let found = match count {
        1 => array::<f32>(maps, "maps", &[None, None]).or_else(|error| {
            refusable(maps.py(), error)?;
            array::<f32>(maps, "maps", &[Some(1), None, None])
        })?,
        _ => array::<f32>(maps, "maps", &[Some(count), None, None])?,
    };
    let shape = found.shape();
    let sides = [shape[shape.len() - 1], shape[shape.len() - 2]];
    match sides.map(u32::try_from) {
        [Ok(w), Ok(h)] if w > 0 && h > 0 => Ok((found, [w, h])),
        _ => {
            let fix = "Renderer.shadow_map makes them";
            Err(argument_error(maps.py(), "maps", "at least one texel", format!("shape {:?}", shape), fix))
        }
    }
}
