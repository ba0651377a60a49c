//! What a texel looks like in the image.

use numpy::PyUntypedArrayMethods;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments::paired_rows;
use super::camera::{PyCamera, camera};
use super::convert::{argument_error, array, image, rows3, run_watched, size2};
use super::gbuffer::{PyGBuffer, gbuffer};
use super::light::light;
use super::parameterization::as_parameterization;
use crate::aliasing::footprint::{footprint as core_footprint, footprint_at as core_footprint_at};
use crate::image::Footprint;

/// Points between two looks at whether to stop: some milliseconds of work.
const AT_ONCE: usize = 1 << 16;

/// The arrays of a footprint by name; numpy takes over all of them.
pub fn footprint_arrays(py: Python<'_>, f: Footprint) -> PyResult<Bound<'_, PyDict>> {
    let [w, h] = f.size.map(|n| n as usize);
    let d = PyDict::new(py);
    d.set_item("planes", image(py, f.planes, [Footprint::PLANES, h, w])?)?;
    d.set_item("map", image(py, f.map, [h, w])?)?;
    Ok(d)
}

/// What a texel looks like at each pixel of a G-buffer; see `shadowlab.aliasing.footprint`.
#[pyfunction]
#[pyo3(signature = (gbuffer, camera, light, parameterization, *, resolution=None))]
pub fn footprint<'py>(
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: crate::Light,
    parameterization: &Bound<'py, PyAny>,
    resolution: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let py = parameterization.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let resolution = resolution.map_or(Ok(p.resolution), |r| size2(r, "resolution"))?;
    let camera = &camera.get().camera;
    let found = gbuffer.get().with_surfaces(py, |surfaces| {
        run_watched(py, None, |progress| core_footprint(surfaces, camera, &light, p, resolution, progress))
    })?;
    footprint_arrays(py, found)
}

/// What a texel looks like at points (N, 3) of surfaces with normals (N, 3); see `shadowlab.aliasing.footprint_at`.
#[pyfunction]
#[pyo3(signature = (points, normals, camera, light, parameterization, *, size, resolution=None))]
#[allow(clippy::too_many_arguments)]
pub fn footprint_at<'py>(
    points: &Bound<'py, PyAny>,
    normals: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: crate::Light,
    parameterization: &Bound<'py, PyAny>,
    size: &Bound<'py, PyAny>,
    resolution: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let py = parameterization.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let resolution = resolution.map_or(Ok(p.resolution), |r| size2(r, "resolution"))?;
    let size = size2(size, "size")?;
    let points = array::<f64>(points, "points", &[None, Some(3)])?;
    let normals = paired_rows(normals, "normals", "points", points.shape()[0])?;
    let (points, normals) = (rows3(&points)?, rows3(&normals)?);
    for (name, rows) in [("points", points), ("normals", normals)] {
        if !rows.as_flattened().iter().all(|x| x.is_finite()) {
            return Err(argument_error(py, name, "finite numbers", "a NaN or an infinity", "leave such points out"));
        }
    }
    let camera = &camera.get().camera;
    let n = points.len();
    let (planes, map) = run_watched(py, None, |progress| {
        // What has not been measured is NaN, as in images; the depth is the caller's to tell.
        let (mut planes, mut map) = (vec![f64::NAN; Footprint::DEPTH * n], Vec::with_capacity(n));
        for (points, normals) in points.chunks(AT_ONCE).zip(normals.chunks(AT_ONCE)) {
            progress.check()?;
            for (k, t) in core_footprint_at(points, normals, camera, &light, p, resolution, size)? {
                if k >= 0 {
                    let ([a, b, c, d], [along_t, along_s]) = (t.jacobian, t.perspective_ts);
                    let values = [a, b, c, d, t.major, t.perspective, along_t, along_s, t.projection];
                    values.into_iter().enumerate().for_each(|(plane, value)| planes[plane * n + map.len()] = value);
                }
                map.push(k);
            }
        }
        // No point at all: what is wrong with the rest is told all the same.
        if n == 0 {
            core_footprint_at(&[], &[], camera, &light, p, resolution, size)?;
        }
        Ok((planes, map))
    })?;
    let d = PyDict::new(py);
    d.set_item("planes", image(py, planes, [Footprint::DEPTH, n])?)?;
    d.set_item("map", image(py, map, [n])?)?;
    Ok(d)
}
