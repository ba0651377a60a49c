//! Surface points of G-buffers in scenes that move.

use numpy::PyArray2;
use pyo3::prelude::*;

use super::convert::{image, run_watched};
use super::gbuffer::{PyGBuffer, gbuffer};
use super::light::light;
use super::scene::{PyScene, scene, scene_named};
use crate::image::Surfaces;
use crate::scene::Scene;
use crate::trace::moved_surfaces;

/// Stands for a row of a face array that no triangle came from.
const NO_TRIANGLE: i32 = i32::MAX;

/// The surface points of a G-buffer of the scene `before`, moved with their instances to where these are in `after`.
///
/// Points whose instances stay are the same bit for bit. Points of a flattened instance that moves are left out.
#[pyfunction]
#[pyo3(signature = (gbuffer, before, after))]
pub fn moved_gbuffer(
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'_, PyGBuffer>,
    before: &Bound<'_, PyAny>,
    after: &Bound<'_, PyAny>,
) -> PyResult<PyGBuffer> {
    let (before, after) = (scene_named(before, "before")?, scene_named(after, "after")?);
    let (py, scenes) = (gbuffer.py(), [&before.get().scene, &after.get().scene]);
    gbuffer.get().remade(py, |surfaces, depth, camera| {
        run_watched(py, None, |progress| moved_surfaces(surfaces, depth, camera, scenes, progress))
    })
}

/// (H, W) int8: what light does at the surface points of a G-buffer, as `trace_shadow_mask` says it of those it finds.
#[pyfunction]
#[pyo3(signature = (scene, gbuffer, light))]
pub fn shadows_at<'py>(
    #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    #[pyo3(from_py_with = light)] light: crate::Light,
) -> PyResult<Bound<'py, PyArray2<i8>>> {
    let (py, scene) = (gbuffer.py(), scene.get());
    let tracer = scene.tracer(py, None)?;
    let truth = gbuffer.get().with_surfaces(py, |surfaces| {
        run_watched(py, None, |progress| {
            let triangle = triangles(&scene.scene, surfaces);
            tracer.shadows_at(&Surfaces { triangle: &triangle, ..*surfaces }, &light, progress)
        })
    })?;
    let [w, h] = truth.size.map(|n| n as usize);
    image(py, truth.data, [h, w])
}

/// The triangles of rows of face arrays: faces may have been dropped.
fn triangles(scene: &Scene, surfaces: &Surfaces) -> Vec<i32> {
    let triangle = |(&row, &instance): (&i32, &i32)| {
        let instance = usize::try_from(instance).ok().filter(|&i| row >= 0 && i < scene.instances().len());
        let Some(instance) = instance else { return row };
        scene.mesh_of(instance).triangle_of(row as usize).map_or(NO_TRIANGLE, |triangle| triangle as i32)
    };
    surfaces.triangle.iter().zip(surfaces.instance).map(triangle).collect()
}

/// Whether both scenes have the same meshes, by content, in the same instances, wherever these are.
#[pyfunction]
#[pyo3(signature = (before, after))]
pub fn same_instances(before: &Bound<'_, PyAny>, after: &Bound<'_, PyAny>) -> PyResult<bool> {
    let py = before.py();
    let (before, after) = (scene_named(before, "before")?, scene_named(after, "after")?);
    let (before, after) = (&before.get().scene, &after.get().scene);
    run_watched(py, None, |progress| after.has_instances_of(before, progress))
}
