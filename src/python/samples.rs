//! `_core.Samples`: what the camera sees, as points, for techniques that look at receivers.

use pyo3::prelude::*;

use super::camera::{PyCamera, camera};
use super::convert::{argument_error, array, instance_of, run_watched};
use super::gbuffer::{PyGBuffer, gbuffer};
use super::light::light;
use crate::focus::Samples;
use crate::image::TruthMask;

/// What a camera sees, as points.
#[pyclass(name = "Samples", frozen, module = "shadowlab")]
pub struct PySamples {
    pub samples: Samples,
}

/// Samples for a technique.
pub enum Given<'py> {
    Samples(Bound<'py, PySamples>),
    GBuffer(Bound<'py, PyGBuffer>),
}

/// An argument of that kind.
pub fn given<'py>(value: &Bound<'py, PyAny>) -> PyResult<Option<Given<'py>>> {
    if value.is_none() {
        return Ok(None);
    }
    if let Ok(g) = value.cast::<PyGBuffer>() {
        return Ok(Some(Given::GBuffer(g.clone())));
    }
    instance_of::<PySamples>(value, "samples", "view.samples() makes them, and a GBuffer will do").map(|s| Some(Given::Samples(s)))
}

#[pymethods]
impl PySamples {
    /// The pixels of a G-buffer as samples.
    #[staticmethod]
    #[pyo3(signature = (gbuffer, camera, light=None, *, shadows=None, count=4096))]
    fn from_gbuffer(
        py: Python<'_>,
        #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'_, PyGBuffer>,
        #[pyo3(from_py_with = camera)] camera: Bound<'_, PyCamera>,
        light: Option<&Bound<'_, PyAny>>,
        shadows: Option<&Bound<'_, PyAny>>,
        count: usize,
    ) -> PyResult<Self> {
        let light = light.map(self::light).transpose()?;
        let camera = camera.get().camera;
        let [w, h] = gbuffer.get().picture().map(|n| Some(n as usize));
        let states = match (shadows, &light) {
            (None, _) => None,
            (Some(_), None) => {
                let fix = "give the light too: samples know the shadows of one light";
                return Err(argument_error(py, "light", "a light, where shadows are given", "none", fix));
            }
            (Some(shadows), Some(_)) => Some(states_of(shadows, &[h, w])?),
        };
        let samples = gbuffer.get().with_surfaces(py, |surfaces| {
            run_watched(py, None, |_| {
                let samples = Samples::of_surfaces(surfaces, &camera);
                Ok(match (states, light) {
                    (Some(states), Some(light)) => samples.with_shadows(&light, states, surfaces, count),
                    _ => samples,
                })
            })
        })?;
        Ok(Self { samples })
    }
    /// How many samples there are.
    fn __len__(&self) -> usize {
        self.samples.len()
    }
}

/// States of an array of them, or of a mask of light.
fn states_of(shadows: &Bound<'_, PyAny>, shape: &[Option<usize>]) -> PyResult<Vec<i8>> {
    if let Ok(states) = array::<i8>(shadows, "shadows", shape) {
        return Ok(states.as_slice()?.to_vec());
    }
    let light = array::<f32>(shadows, "shadows", shape)?;
    let state = |x: &f32| match x {
        x if x.is_nan() => TruthMask::NOTHING,
        x if *x >= 0.5 => TruthMask::LIT,
        _ => TruthMask::SHADOW,
    };
    Ok(light.as_slice()?.iter().map(state).collect())
}
