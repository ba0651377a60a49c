//! Errors as numbers.

use numpy::{PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;

use super::arrays::{equal_lists, stored};
use super::convert::{SOON, argument_error, array, image, run_sized};
use super::state::{Parts, Reduced, Writer, first_eight, reduced, seal};
use crate::aliasing::against_truth::{Misclassified, misclassified as core_misclassified};
use crate::digest::{Digest, Numbers};

/// Where a shadow mask and the truth disagree.
#[pyclass(name = "Misclassified", frozen, module = "shadowlab.aliasing")]
pub struct PyMisclassified {
    m: Misclassified,
    image: Py<PyArray2<i8>>,
}

/// Its state.
const NAME: &str = "Misclassified";
const VERSION: u32 = 1;

impl PyMisclassified {
    fn head(&self) -> Writer {
        let (m, mut head) = (&self.m, Writer::new(Numbers::Exact));
        [m.false_shadow, m.false_light, m.compared, m.undecided, m.unmatched].iter().for_each(|&n| head.count(n));
        head
    }
    fn add_image(&self, py: Python<'_>, digest: &mut Digest) -> PyResult<()> {
        let image = self.image.bind(py);
        image.shape().iter().for_each(|&n| digest.count(n));
        digest.list(image.readonly().as_slice()?);
        Ok(())
    }
    /// The one of a state; it keeps the image that came.
    pub fn restored<'py>(py: Python<'py>, parts: &Parts<'py>) -> PyResult<Self> {
        parts.check(py, VERSION, 1)?;
        let m = parts.read(py, |from| {
            Ok(Misclassified {
                false_shadow: from.count()?,
                false_light: from.count()?,
                compared: from.count()?,
                undecided: from.count()?,
                unmatched: from.count()?,
            })
        })?;
        let image = stored::<i8>(py, parts, 0, &[None, None])?.into_any().cast_into::<PyArray2<i8>>()?.unbind();
        let found = Self { m, image };
        parts.check_seal(py, |digest| found.add_image(py, digest))?;
        Ok(found)
    }
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
    fn __eq__(&self, py: Python<'_>, other: PyRef<'_, Self>) -> PyResult<bool> {
        let (a, b) = (self.image.bind(py), other.image.bind(py));
        let same = self.m == other.m && a.shape() == b.shape();
        Ok(same && equal_lists(a.readonly().as_slice()?, b.readonly().as_slice()?))
    }
    // Not by what `==` makes of both: the other side may answer with anything.
    fn __ne__(&self, py: Python<'_>, other: PyRef<'_, Self>) -> PyResult<bool> {
        Ok(!self.__eq__(py, other)?)
    }
    fn __hash__(&self, py: Python<'_>) -> PyResult<u64> {
        let mut digest = Digest::new(NAME, Numbers::Equal);
        digest.list(self.head().bytes());
        self.add_image(py, &mut digest)?;
        Ok(first_eight(&digest.finish()))
    }
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let head = self.head();
        let seal = seal(NAME, VERSION, head.bytes(), |digest| self.add_image(py, digest))?;
        reduced(py, NAME, VERSION, head.bytes(), &seal, vec![self.image.bind(py).clone().into_any()])
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
    let truth = array::<i8>(truth, "truth", &[None, None])?;
    if truth.shape() != shape {
        let got = format!("a mask {shape:?} and a truth {:?}", truth.shape());
        return Err(argument_error(py, "mask, truth", "images of one shape", got, "render both at one size"));
    }
    if shape.contains(&0) {
        let got = format!("shape {shape:?}");
        return Err(argument_error(py, "mask", "at least one pixel", got, "render an image first"));
    }
    let (mask, truth) = (mask.as_slice()?, truth.as_slice()?);
    let (m, codes) = run_sized(py, mask.len() > SOON, |progress| core_misclassified(mask, truth, progress))?;
    Ok(PyMisclassified { m, image: image(py, codes, shape)?.unbind() })
}
