//! The eye-space blur of a shadow mask.

use numpy::PyArray2;
use pyo3::prelude::*;

use super::arguments::{number, whole, word_or};
use super::camera::{PyCamera, camera};
use super::convert::{OrRaise, array, image, run_watched};
use super::gbuffer::{PyGBuffer, gbuffer};
use crate::names::named;
use crate::render::{BlurSettings, BlurStrength, MAX_STEPS, blur as core_blur};

/// The mask after the blur: (H, W) float32; see `shadowlab.blur`.
#[pyfunction]
#[pyo3(signature = (mask, gbuffer, camera, *, iterations, strength=None, depth=None),
    text_signature = "(mask, gbuffer, camera, *, iterations, strength='depth', depth=None)")]
pub fn blur<'py>(
    mask: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    iterations: &Bound<'py, PyAny>,
    strength: Option<&Bound<'py, PyAny>>,
    depth: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyArray2<f32>>> {
    let py = mask.py();
    let steps = whole(iterations, "iterations", [0, i64::from(MAX_STEPS)], "8 blur by two pixels")? as u32;
    let name =
        word_or(strength, "strength", "depth", &format!("one of {}", BlurStrength::NAMES.map(|s| s.0).join(", ")))?;
    let strength = named("strength", &name, &BlurStrength::NAMES).or_raise(py)?;
    let depth = depth.map(|depth| number(depth, "depth", "leave it out for the nearest surface's")).transpose()?;
    let settings = BlurSettings { steps, strength, depth };
    let camera = &camera.get().camera;
    gbuffer.get().with_surfaces(py, |surfaces| {
        let [w, h] = surfaces.size.map(|n| n as usize);
        let mask = array::<f32>(mask, "mask", &[Some(h), Some(w)])?;
        let mask = mask.as_slice()?;
        let blurred = run_watched(py, None, |progress| core_blur(mask, surfaces, camera, &settings, progress))?;
        image(py, blurred, [h, w])
    })
}
