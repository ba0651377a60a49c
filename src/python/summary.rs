//! The numbers of whole images: of texels and of causes, for `shadowlab.aliasing`.

use numpy::{Element, PyArray2, PyArrayDyn, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments::{number, whole};
use super::convert::{argument_error, array, image as numpy_image, run_watched};
use crate::aliasing::cause_counts::{CODES, cause_counts as core_cause_counts};
use crate::aliasing::cause_counts::{causes_by_depth as core_causes_by_depth, compared_depths as core_compared_depths};
use crate::aliasing::selection::Real;
use crate::aliasing::summary::{Asked, Band, Summary, Texels, bands as core_bands, summary as core_summary};

/// Arrays of pixels of one shape.
struct Arrays<'py, T: Element> {
    map: PyReadonlyArrayDyn<'py, i16>,
    values: Vec<PyReadonlyArrayDyn<'py, T>>,
}

impl<'py, T: Element> Arrays<'py, T> {
    fn new(map: &Bound<'py, PyAny>, values: &[(&Bound<'py, PyAny>, &str)]) -> PyResult<Self> {
        let map = array::<i16>(map, "map", &[])?;
        let shape: Vec<Option<usize>> = map.shape().iter().map(|side| Some(*side)).collect();
        let values = values.iter().map(|(value, name)| array::<T>(value, name, &shape)).collect::<PyResult<_>>()?;
        Ok(Self { map, values })
    }
}

/// Whether arrays are read in single precision: as the first one is.
fn is_single(value: &Bound<'_, PyAny>) -> bool {
    value.cast::<PyArrayDyn<f32>>().is_ok()
}

/// Numbers that rise; NaN does not.
fn rising(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<f64>> {
    let found = array::<f64>(value, name, &[None])?;
    let numbers = found.as_slice()?;
    if numbers.iter().any(|x| x.is_nan()) || numbers.windows(2).any(|pair| pair[0] >= pair[1]) {
        let fix = "sort them, and give each once";
        return Err(argument_error(value.py(), name, "numbers that rise", "others", fix));
    }
    Ok(numbers.to_vec())
}

/// The numbers of all pixels of a footprint that look up a texel, by name; None where none does. See
/// `shadowlab.aliasing.summary.Summary`.
#[pyfunction]
#[pyo3(signature = (map, major, perspective, along_t, along_s, projection, depth, *, maps, percentiles, edges, undersampled_from))]
#[allow(clippy::too_many_arguments)]
pub fn summarize<'py>(
    map: &Bound<'py, PyAny>,
    major: &Bound<'py, PyAny>,
    perspective: &Bound<'py, PyAny>,
    along_t: &Bound<'py, PyAny>,
    along_s: &Bound<'py, PyAny>,
    projection: &Bound<'py, PyAny>,
    depth: &Bound<'py, PyAny>,
    maps: &Bound<'py, PyAny>,
    percentiles: &Bound<'py, PyAny>,
    edges: &Bound<'py, PyAny>,
    undersampled_from: &Bound<'py, PyAny>,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let py = map.py();
    let values = [
        (major, "major"),
        (perspective, "perspective"),
        (along_t, "along_t"),
        (along_s, "along_s"),
        (projection, "projection"),
        (depth, "depth"),
    ];
    let maps = whole(maps, "maps", [0, i64::from(i16::MAX)], "as many as the parameterization has")? as usize;
    let (edges, asked) = (rising(edges, "edges")?, rising(percentiles, "percentiles")?);
    if asked.iter().any(|q| !(0.0..=100.0).contains(q)) {
        return Err(argument_error(py, "percentiles", "numbers from 0 to 100", "others", "give per cent"));
    }
    let undersampled_from = number(undersampled_from, "undersampled_from", "give pixels")?;
    let asked = Asked { maps, percentiles: &asked, edges: &edges, undersampled_from };
    let found = if is_single(major) {
        summary_of(py, &Arrays::<f32>::new(map, &values)?, &asked)?
    } else {
        summary_of(py, &Arrays::<f64>::new(map, &values)?, &asked)?
    };
    let Some(s) = found else { return Ok(None) };
    let d = PyDict::new(py);
    d.set_item("measured", s.measured)?;
    d.set_item("max", s.max)?;
    d.set_item("mean", s.mean)?;
    d.set_item("rms", s.rms)?;
    d.set_item("percentiles", s.percentiles)?;
    d.set_item("undersampled", s.undersampled)?;
    d.set_item("perspective_max", s.perspective_max)?;
    d.set_item("perspective_mean", s.perspective_mean)?;
    d.set_item("projection_mean", s.projection_mean)?;
    d.set_item("longest", s.longest.into_iter().map(|longest| longest.map(<(f64, f64)>::from)).collect::<Vec<_>>())?;
    d.set_item("histogram", s.histogram)?;
    d.set_item("depths", <(f64, f64)>::from(s.depths))?;
    Ok(Some(d))
}

fn summary_of<T: Element + Real>(py: Python<'_>, arrays: &Arrays<'_, T>, asked: &Asked) -> PyResult<Option<Summary>> {
    let values: Vec<&[T]> = arrays.values.iter().map(|array| array.as_slice()).collect::<Result<_, _>>()?;
    let [major, perspective, along_t, along_s, projection, depth] = values[..] else { unreachable!("six were read") };
    let texels = Texels { map: arrays.map.as_slice()?, major, perspective, along_t, along_s, projection, depth };
    run_watched(py, None, |progress| core_summary(&texels, asked, progress))
}

/// Of each band of depth between limits: pixels, and max, mean, 95th percentile of the values and the share of those above
/// `undersampled_from`, or None where it has no pixel.
#[pyfunction]
#[pyo3(signature = (map, major, depth, *, limits, undersampled_from))]
#[allow(clippy::type_complexity)]
pub fn summarize_bands<'py>(
    map: &Bound<'py, PyAny>,
    major: &Bound<'py, PyAny>,
    depth: &Bound<'py, PyAny>,
    limits: &Bound<'py, PyAny>,
    undersampled_from: &Bound<'py, PyAny>,
) -> PyResult<Vec<(usize, Option<(f64, f64, f64, f64)>)>> {
    let py = map.py();
    let values = [(major, "major"), (depth, "depth")];
    let limits = rising(limits, "limits")?;
    let from = number(undersampled_from, "undersampled_from", "give pixels")?;
    let found = if is_single(major) {
        bands_of(py, &Arrays::<f32>::new(map, &values)?, &limits, from)?
    } else {
        bands_of(py, &Arrays::<f64>::new(map, &values)?, &limits, from)?
    };
    Ok(found.into_iter().map(|band| (band.pixels, band.of_values.map(|[a, b, c, d]| (a, b, c, d)))).collect())
}

fn bands_of<T>(py: Python<'_>, arrays: &Arrays<'_, T>, limits: &[f64], from: f64) -> PyResult<Vec<Band>>
where
    T: Element + Real,
{
    let (map, major, depth) = (arrays.map.as_slice()?, arrays.values[0].as_slice()?, arrays.values[1].as_slice()?);
    run_watched(py, None, |progress| core_bands(map, major, depth, limits, from, progress))
}

/// Pixels by cause, from 0 (right) to 5 (other), and mean, 95th percentile and maximum of how far edges moved, pixels, or None.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn cause_counts<'py>(
    image: &Bound<'py, PyAny>,
    distance: &Bound<'py, PyAny>,
) -> PyResult<([u64; CODES], Option<(f64, f64, f64)>)> {
    let py = image.py();
    let (image, distance) = (array::<i8>(image, "image", &[])?, array::<f32>(distance, "distance", &[])?);
    let (image, distance) = (image.as_slice()?, distance.as_slice()?);
    let found = run_watched(py, None, |progress| core_cause_counts(image, distance, progress))?;
    Ok((found.counts, found.edges_px.map(<(f64, f64, f64)>::from)))
}

/// Nearest and farthest depth of the pixels that were compared, or None.
#[pyfunction]
pub fn compared_depths<'py>(image: &Bound<'py, PyAny>, depth: &Bound<'py, PyAny>) -> PyResult<Option<(f64, f64)>> {
    let py = image.py();
    let (image, depth) = (array::<i8>(image, "image", &[])?, array::<f64>(depth, "depth", &[])?);
    let (image, depth) = (image.as_slice()?, depth.as_slice()?);
    let found = run_watched(py, None, |progress| core_compared_depths(image, depth, progress))?;
    Ok(found.map(<(f64, f64)>::from))
}

/// Pixels by cause, (B, 6) uint64, in bands of depth between limits.
#[pyfunction]
#[pyo3(signature = (image, depth, *, limits))]
pub fn causes_by_depth<'py>(
    image: &Bound<'py, PyAny>,
    depth: &Bound<'py, PyAny>,
    limits: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray2<u64>>> {
    let py = image.py();
    let limits = rising(limits, "limits")?;
    let (causes, depth) = (array::<i8>(image, "image", &[])?, array::<f64>(depth, "depth", &[])?);
    let (causes, depth) = (causes.as_slice()?, depth.as_slice()?);
    let found = run_watched(py, None, |progress| core_causes_by_depth(causes, depth, &limits, progress))?;
    let bands = found.len();
    numpy_image(py, found.into_flattened(), [bands, CODES])
}
