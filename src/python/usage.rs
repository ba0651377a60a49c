//! Where receivers lie in their maps, and how many pixels read each texel.

use glam::DVec2;
use numpy::{PyArray2, PyArray3};
use pyo3::prelude::*;
use rayon::prelude::*;

use super::camera::{PyCamera, camera};
use super::convert::{image, run_watched, size2};
use super::gbuffer::{PyGBuffer, gbuffer};
use super::light::light;
use super::mask_settings::settings_of;
use super::parameterization::as_parameterization;
use crate::aliasing::usage;
use crate::render::Bias;
use crate::render::cpu::lookup::Lookups;
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

/// How many pixels read each texel: (K, H, W) uint32; and how many pixels do.
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
) -> PyResult<(Bound<'py, PyArray3<u32>>, usize)> {
    let py = parameterization.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let how = (Some(Bias::NONE), filter, None, None);
    let settings = settings_of(py, p, resolution, gbuffer.get().whole_picture(), how)?;
    let resolution = settings.resolution;
    let camera = &camera.get().camera;
    let layers = p.partitions.len();
    let (counts, pixels) = gbuffer.get().with_surfaces(py, |surfaces| {
        run_watched(py, None, |progress| {
            let located = usage::locate(surfaces, camera, &light, p, resolution, progress)?;
            let lookups = Lookups::new(p, camera, &light, surfaces.origin, &settings)?;
            let read = |pixel: usize, map: usize, count: &mut dyn FnMut([i64; 2])| {
                let Some((point, normal)) = surfaces.receiver(pixel) else { return };
                let place = DVec2::from_array(located.texel[pixel]);
                lookups.map(map).texels_at(point, normal, place, count);
            };
            let pixels = located.map.iter().filter(|&&map| map >= 0).count();
            Ok((usage::reads(&located, layers, resolution, read, progress)?, pixels))
        })
    })?;
    let [w, h] = resolution.map(|n| n as usize);
    Ok((image(py, counts, [layers, h, w])?, pixels))
}

/// How far from the point the centre of a texel that each pixel compares can lie, along the map's x and y, texels: (H, W, 2)
/// float64, NaN where no map serves it.
#[pyfunction]
#[pyo3(signature = (gbuffer, camera, light, parameterization, *, resolution=None, filter=None),
    text_signature = "(gbuffer, camera, light, parameterization, *, resolution=None, filter='nearest')")]
pub fn filter_reach<'py>(
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: Light,
    parameterization: &Bound<'py, PyAny>,
    resolution: Option<&Bound<'py, PyAny>>,
    filter: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let py = parameterization.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let how = (Some(Bias::NONE), filter, None, None);
    let settings = settings_of(py, p, resolution, gbuffer.get().whole_picture(), how)?;
    let resolution = settings.resolution;
    let camera = &camera.get().camera;
    let (reach, size) = gbuffer.get().with_surfaces(py, |surfaces| {
        let reach = run_watched(py, None, |progress| {
            let located = usage::locate(surfaces, camera, &light, p, resolution, progress)?;
            let lookups = Lookups::new(p, camera, &light, surfaces.origin, &settings)?;
            let of = |(pixel, &map): (usize, &i16)| {
                let at = usize::try_from(map).ok().zip(surfaces.receiver(pixel));
                at.map_or([f64::NAN; 2], |(k, (point, normal))| lookups.map(k).reach_at(point, normal).to_array())
            };
            Ok(located.map.par_iter().enumerate().map(of).collect::<Vec<_>>())
        })?;
        Ok((reach, surfaces.size))
    })?;
    let [w, h] = size.map(|n| n as usize);
    image(py, reach.into_flattened(), [h, w, 2])
}
