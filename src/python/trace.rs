//! Truth by ray casting.

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use super::camera::PyCamera;
use super::convert::{argument_error, array, image, rows3, run_watched, size2};
use super::light::light;
use super::scene::PyScene;

/// (H, W) int8: 1 lit, 0 in shadow, -1 undecided, -2 nothing there.
#[pyfunction]
#[pyo3(signature = (scene, camera, light, *, size, progress=None))]
pub fn trace_shadow_mask<'py>(
    scene: PyRef<'py, PyScene>,
    camera: PyRef<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: crate::Light,
    size: &Bound<'py, PyAny>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyArray2<i8>>> {
    let py = size.py();
    let size = size2(size, "size")?;
    let (scene, camera) = (&*scene, &camera.camera);
    let truth =
        run_watched(py, progress, |progress| scene.tracer(progress)?.shadow_mask(camera, &light, size, progress))?;
    let [w, h] = truth.size.map(|n| n as usize);
    image(py, truth.data, [h, w])
}

/// First hits of rays: t (N,) float64 (infinity for none), triangle (N,) int32, instance (N,) int32 (-1 for none).
#[pyfunction]
#[pyo3(signature = (scene, origins, directions))]
#[allow(clippy::type_complexity)]
pub fn first_hit<'py>(
    scene: PyRef<'py, PyScene>,
    origins: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<i32>>, Bound<'py, PyArray1<i32>>)> {
    let py = origins.py();
    let origins = array::<f64>(origins, "origins", &[None, Some(3)])?;
    let origins = rows3(&origins)?;
    let directions = array::<f64>(directions, "directions", &[Some(origins.len()), Some(3)])?;
    let directions = rows3(&directions)?;
    let scene = &*scene;
    let hits = run_watched(py, None, |progress| scene.tracer(progress)?.first_hit(origins, directions, progress))?;
    let source = |h: &crate::trace::Hit| match h.triangle {
        ..0 => -1,
        triangle => scene.scene.mesh_of(h.instance as usize).source_face(triangle as usize) as i32,
    };
    let n = hits.len();
    Ok((
        image(py, hits.iter().map(|h| h.t).collect(), [n])?,
        image(py, hits.iter().map(source).collect(), [n])?,
        image(py, hits.iter().map(|h| h.instance).collect(), [n])?,
    ))
}

/// Whether anything lies at 0 < t < t_max on each ray: (N,) bool.
#[pyfunction]
#[pyo3(signature = (scene, origins, directions, t_max=None))]
pub fn occluded<'py>(
    scene: PyRef<'py, PyScene>,
    origins: &Bound<'py, PyAny>,
    directions: &Bound<'py, PyAny>,
    t_max: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray1<bool>>> {
    let py = origins.py();
    let origins = array::<f64>(origins, "origins", &[None, Some(3)])?;
    let origins = rows3(&origins)?;
    let directions = array::<f64>(directions, "directions", &[Some(origins.len()), Some(3)])?;
    let directions = rows3(&directions)?;
    let limits = match t_max {
        None => vec![f64::INFINITY; origins.len()],
        Some(t) => match t.extract::<f64>() {
            Ok(t) => vec![t; origins.len()],
            Err(_) => array::<f64>(t, "t_max", &[Some(origins.len())])?.as_slice()?.to_vec(),
        },
    };
    if let Some(bad) = limits.iter().find(|t| t.is_nan()) {
        return Err(argument_error(py, "t_max", "numbers, infinity for no limit", bad, "check where it comes from"));
    }
    let scene = &*scene;
    let answers =
        run_watched(py, None, |progress| scene.tracer(progress)?.occluded(origins, directions, &limits, progress))?;
    let n = answers.len();
    image(py, answers, [n])
}

/// Bytes of the acceleration structure (built if it is not there yet).
#[pyfunction]
pub fn trace_memory(py: Python<'_>, scene: PyRef<'_, PyScene>) -> PyResult<usize> {
    let scene = &*scene;
    run_watched(py, None, |progress| Ok(scene.tracer(progress)?.memory()))
}
