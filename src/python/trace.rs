//! Truth by ray casting.

use std::borrow::Cow;

use numpy::{PyArray1, PyArray2, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyInt};
use rayon::prelude::*;

use super::arguments::{callable, number_or, paired_rows, whole};
use super::camera::{PyCamera, camera};
use super::convert::{array, image, rows3, run_watched, size2};
use super::light::{light, lights_named};
use super::scene::{PyScene, scene};
use crate::image::TruthMask;
use crate::trace::Hit;

/// (H, W) int8: 1 lit, 0 in shadow, -1 undecided, -2 nothing there.
#[pyfunction]
#[pyo3(signature = (scene, camera, light, *, size, progress=None))]
pub fn trace_shadow_mask<'py>(
    #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: crate::Light,
    size: &Bound<'py, PyAny>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray2<i8>>> {
    let py = size.py();
    let progress = progress.map(|report| callable(report, "progress")).transpose()?;
    let size = size2(size, "size")?;
    let (scene, camera) = (scene.get(), &camera.get().camera);
    let tracer = scene.tracer(py, progress.as_ref())?;
    let truth = run_watched(py, progress, |progress| tracer.shadow_mask(camera, &light, size, progress))?;
    let [w, h] = truth.size.map(|n| n as usize);
    image(py, truth.data, [h, w])
}

/// The same for each of several lights, whose rays from the eye are traced once: a list of (H, W) int8.
#[pyfunction]
#[pyo3(signature = (scene, camera, lights, *, size))]
pub fn trace_shadow_masks<'py>(
    #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    lights: &Bound<'py, PyAny>,
    size: &Bound<'py, PyAny>,
) -> PyResult<Vec<Bound<'py, PyArray2<i8>>>> {
    let py = size.py();
    let lights = lights_named(lights, "lights")?;
    let size = size2(size, "size")?;
    let (scene, camera) = (scene.get(), &camera.get().camera);
    let tracer = scene.tracer(py, None)?;
    let truths = run_watched(py, None, |progress| tracer.shadow_masks(camera, &lights, size, progress))?;
    let of = |truth: TruthMask| {
        let [w, h] = truth.size.map(|n| n as usize);
        image(py, truth.data, [h, w])
    };
    truths.into_iter().map(of).collect()
}

/// First hits of rays: t (N,) float64 (infinity for none), triangle (N,) int32, instance (N,) int32 (-1 for none).
#[pyfunction]
#[pyo3(signature = (scene, origins, directions))]
#[allow(clippy::type_complexity)]
pub fn first_hit<'py>(
    #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
    origins: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<i32>>, Bound<'py, PyArray1<i32>>)> {
    let py = origins.py();
    let origins = array::<f64>(origins, "origins", &[None, Some(3)])?;
    let origins = rows3(&origins)?;
    let directions = paired_rows(directions, "directions", "origins", origins.len())?;
    let directions = rows3(&directions)?;
    let scene = scene.get();
    let source = |h: &Hit| match h.triangle {
        ..0 => -1,
        triangle => scene.scene.mesh_of(h.instance as usize).source_face(triangle as usize) as i32,
    };
    let tracer = scene.tracer(py, None)?;
    let (t, triangle, instance): (Vec<f64>, Vec<i32>, Vec<i32>) = run_watched(py, None, |progress| {
        let hits = tracer.first_hit(origins, directions, progress)?;
        let t = hits.par_iter().map(|h| h.t).collect();
        let triangle = hits.par_iter().map(source).collect();
        Ok((t, triangle, hits.par_iter().map(|h| h.instance).collect()))
    })?;
    let n = t.len();
    Ok((image(py, t, [n])?, image(py, triangle, [n])?, image(py, instance, [n])?))
}

/// The corners (3, 3) float64 of a triangle of an instance, world, which turn counter-clockwise seen from its outer side; None
/// where there is no such triangle. `face` is the row of its mesh's face array, as `first_hit` gives it.
#[pyfunction]
pub fn face_corners<'py>(
    #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
    instance: &Bound<'py, PyAny>,
    face: &Bound<'py, PyAny>,
) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
    let py = instance.py();
    let [instance, face] = [(instance, "instance"), (face, "face")]
        .map(|(value, name)| whole(value, name, [-1, i64::from(i32::MAX)], "first_hit gives it"));
    let (scene, Ok(instance), Ok(face)) = (&scene.get().scene, usize::try_from(instance?), usize::try_from(face?))
    else {
        return Ok(None);
    };
    if instance >= scene.instances().len() {
        return Ok(None);
    }
    let Some(triangle) = scene.mesh_of(instance).triangle_of(face) else { return Ok(None) };
    let [a, b, c] = scene.corners(instance, triangle).map(|p| p.to_array());
    let is_mirrored = scene.world_from_local(instance).matrix3.determinant() < 0.0;
    let turned = if is_mirrored { [a, c, b] } else { [a, b, c] };
    image(py, turned.concat(), [3, 3]).map(Some)
}

/// Whether anything lies at 0 < t < t_max on each ray: (N,) bool.
#[pyfunction]
#[pyo3(signature = (scene, origins, directions, t_max=None))]
pub fn occluded<'py>(
    #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
    origins: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
    t_max: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let py = origins.py();
    let origins = array::<f64>(origins, "origins", &[None, Some(3)])?;
    let origins = rows3(&origins)?;
    let directions = paired_rows(directions, "directions", "origins", origins.len())?;
    let directions = rows3(&directions)?;
    let each = match t_max {
        Some(t) if !is_single(t) => Some(array::<f64>(t, "t_max", &[Some(origins.len())])?),
        _ => None,
    };
    let limits = match (&each, t_max) {
        (Some(each), _) => Cow::Borrowed(each.as_slice()?),
        (None, t) => Cow::Owned(vec![number_or(t, "t_max", f64::INFINITY)?; origins.len()]),
    };
    let tracer = scene.get().tracer(py, None)?;
    let answers = run_watched(py, None, |progress| tracer.occluded(origins, directions, &limits, progress))?;
    let n = answers.len();
    image(py, answers, [n])
}

/// Whether it is one number for all rays.
fn is_single(value: &Bound<'_, PyAny>) -> bool {
    let zero_axes = |array: &Bound<'_, PyUntypedArray>| array.ndim() == 0;
    value.is_instance_of::<PyFloat>()
        || value.is_instance_of::<PyInt>()
        || value.cast::<PyUntypedArray>().is_ok_and(zero_axes)
        || value.cast::<PyUntypedArray>().is_err() && value.len().is_err()
}

/// Bytes of the acceleration structure (built if it is not there yet).
#[pyfunction]
pub fn trace_memory<'py>(py: Python<'py>, #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>) -> PyResult<usize> {
    Ok(scene.get().tracer(py, None)?.memory())
}
