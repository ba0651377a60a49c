//! Errors as numbers.

use numpy::{PyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;

use super::convert::{OrRaise, argument_error, array, image};
use crate::aliasing::against_truth::{Misclassified, misclassified as core_misclassified};

/// Where a shadow mask and the truth disagree.
#[pyclass(name = "Misclassified", frozen, module = "shadowlab.aliasing")]
pub struct PyMisclassified {
    m: Misclassified,
    image: Py<PyArray2<i8>>,
}

#[pymethods]
impl PyMisclassified {
    /// Wrong pixels: false shadow plus false light.
    #[getter]
    fn count(&self) -> u64 {
        self.m.count()
    }
    /// Pixels the map calls shadow and rays call lit.
    #[getter]
    fn false_shadow(&self) -> u64 {
        self.m.false_shadow
    }
    /// Pixels the map calls lit and rays call shadow.
    #[getter]
    fn false_light(&self) -> u64 {
        self.m.false_light
    }
    /// Pixels that show something in both and that rays could decide.
    #[getter]
    fn compared(&self) -> u64 {
        self.m.compared
    }
    /// Pixels whose truth changes with the numerical offset of the ray.
    #[getter]
    fn undecided(&self) -> u64 {
        self.m.undecided
    }
    /// Pixels in which only one of the two saw a surface.
    #[getter]
    fn unmatched(&self) -> u64 {
        self.m.unmatched
    }
    /// Wrong pixels by compared pixels; 0 where nothing was compared.
    #[getter]
    fn fraction(&self) -> f64 {
        self.m.fraction()
    }
    /// (H, W) int8: 0 agree, 1 false shadow, 2 false light, -1 not compared.
    #[getter]
    fn image(&self, py: Python<'_>) -> Py<PyArray2<i8>> {
        self.image.clone_ref(py)
    }
    fn __repr__(&self) -> String {
        let m = &self.m;
        format!(
            "Misclassified(count={}, false_shadow={}, false_light={}, compared={}, undecided={}, fraction={:.6})",
            m.count(),
            m.false_shadow,
            m.false_light,
            m.compared,
            m.undecided,
            m.fraction()
        )
    }
}

/// The pixels in which a shadow mask (H, W) float and the truth (H, W) int8 of the same view disagree.
#[pyfunction]
pub fn misclassified(py: Python<'_>, mask: &Bound<'_, PyAny>, truth: &Bound<'_, PyAny>) -> PyResult<PyMisclassified> {
    let mask = array::<f32>(mask, "mask", &[None, None])?;
    let shape = [mask.shape()[0], mask.shape()[1]];
    let truth = array::<i8>(truth, "truth", &[Some(shape[0]), Some(shape[1])])?;
    if shape.contains(&0) {
        let got = format!("shape {shape:?}");
        return Err(argument_error(py, "mask", "at least one pixel", got, "render an image first"));
    }
    let (mask, truth) = (mask.as_slice()?, truth.as_slice()?);
    let (m, codes) = py.detach(|| core_misclassified(mask, truth)).or_raise(py)?;
    Ok(PyMisclassified { m, image: image(py, codes, shape)?.unbind() })
}
