//! `_core.Parameterization` and `_core.Partition`.

use numpy::{PyArray1, PyArray2, PyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::convert::{argument_error, array, image, mat4_from_rows, mat4_to_array, resolution, rows3};
use super::technique::{settings_dict, value_text};
use crate::parameterization::{Parameterization, Partition, PostWarp};

/// The maps of a technique for one scene, camera and light: plain data.
#[pyclass(name = "Parameterization", frozen, module = "shadowlab")]
pub struct PyParameterization {
    pub p: Parameterization,
}

/// One map of a parameterization.
#[pyclass(name = "Partition", frozen, module = "shadowlab")]
pub struct PyPartition {
    partition: Partition,
}

impl From<Parameterization> for PyParameterization {
    fn from(p: Parameterization) -> Self {
        Self { p }
    }
}

fn values_dict<'py>(py: Python<'py>, partition: &Partition) -> PyResult<Bound<'py, PyDict>> {
    let d = PyDict::new(py);
    for (name, value) in &partition.values {
        d.set_item(name, value)?;
    }
    Ok(d)
}

/// Whether a matrix of sixteen row-major numbers has no inverse; the size of its rows has no say.
fn is_singular(rows: &[f64; 16]) -> bool {
    let mut scaled = *rows;
    for row in scaled.as_chunks_mut::<4>().0 {
        let largest = row.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        row.iter_mut().for_each(|x| *x /= largest);
    }
    !mat4_from_rows(&scaled).inverse().is_finite()
}

#[pymethods]
impl PyParameterization {
    /// Somebody else's matrices as a parameterization.
    ///
    /// Parameters
    /// ----------
    /// matrix : (4, 4) or (K, 4, 4) array_like
    ///     Shadow clip from world: acts on column vectors; NDC x, y in [-1, 1] with y up, z in [0, 1] with 0 nearest the light.
    /// resolution : int
    ///     Texels along a side the matrix was made for.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For another shape, numbers that are not finite, or a singular matrix.
    #[staticmethod]
    #[pyo3(signature = (matrix, *, resolution=1024))]
    fn from_matrix(matrix: &Bound<'_, PyAny>, #[pyo3(from_py_with = resolution)] resolution: u32) -> PyResult<Self> {
        let py = matrix.py();
        let stack = array::<f64>(matrix, "matrix", &[None, Some(4), Some(4)])
            .or_else(|_| array::<f64>(matrix, "matrix", &[Some(4), Some(4)]))?;
        let numbers = stack.as_slice()?;
        if numbers.is_empty() || !numbers.iter().all(|x| x.is_finite()) {
            let got = format!("shape {:?} with NaN, infinity or nothing", stack.shape());
            return Err(argument_error(
                py,
                "matrix",
                "finite numbers, at least one matrix",
                got,
                "check where it comes from",
            ));
        }
        if numbers.as_chunks::<16>().0.iter().any(is_singular) {
            let fix = "a shadow matrix has an inverse; check where it comes from";
            return Err(argument_error(py, "matrix", "matrices of full rank", "a singular one", fix));
        }
        let partitions = numbers.as_chunks::<16>().0.iter().map(|rows| Partition::of_matrix(mat4_from_rows(rows)));
        let p = Parameterization::of_partitions(partitions.collect(), resolution);
        Ok(p.into())
    }
    /// Name of the technique, "matrix" for somebody else's.
    #[getter]
    fn technique(&self) -> &str {
        &self.p.technique
    }
    /// The technique's parameters as used.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        settings_dict(py, &self.p.settings)
    }
    /// Intermediate numbers by name (warp distance, sine of the light angle...) of a single map; of several, each has its own.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        match self.p.partitions.as_slice() {
            [one] => values_dict(py, one),
            _ => Ok(PyDict::new(py)),
        }
    }
    /// What to know about this result, in words.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.p.notes.clone()
    }
    /// Texels along a side it was fitted for.
    #[getter]
    fn resolution(&self) -> u32 {
        self.p.resolution
    }
    /// Texels at each side that no receiver maps to.
    #[getter]
    fn border_texels(&self) -> u32 {
        self.p.border_texels
    }
    /// The maps, nearest first.
    #[getter]
    fn partitions(&self) -> Vec<PyPartition> {
        self.p.partitions.iter().map(|partition| PyPartition { partition: partition.clone() }).collect()
    }
    /// (4, 4) float64: shadow clip from world, when there is one map.
    #[getter]
    fn matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        match self.p.partitions.as_slice() {
            [one] => mat4_to_array(py, &one.shadow_clip_from_world),
            many => {
                let got = format!("{} maps", many.len());
                Err(argument_error(py, "matrix", "a parameterization of one map", got, "read .matrices"))
            }
        }
    }
    /// (K, 4, 4) float64: shadow clip from world of every map.
    #[getter]
    fn matrices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let rows = |p: &Partition| p.shadow_clip_from_world.transpose().to_cols_array();
        image(py, self.p.partitions.iter().flat_map(rows).collect(), [self.p.partitions.len(), 4, 4])
    }
    fn __repr__(&self) -> String {
        let settings: Vec<String> = self.p.settings.iter().map(|(k, v)| format!(", {k}={}", value_text(v))).collect();
        let notes = if self.p.notes.is_empty() { String::new() } else { format!("; {}", self.p.notes.join("; ")) };
        format!(
            "Parameterization({:?}{}, maps={}, resolution={}{notes})",
            self.p.technique,
            settings.concat(),
            self.p.partitions.len(),
            self.p.resolution
        )
    }
}

#[pymethods]
impl PyPartition {
    /// (4, 4) float64: shadow clip from world.
    #[getter]
    fn matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        mat4_to_array(py, &self.partition.shadow_clip_from_world)
    }
    /// (near, far) camera depth this map serves, world units.
    #[getter]
    fn eye_depth(&self) -> (f64, f64) {
        self.partition.eye_depth.into()
    }
    /// What follows the projective part: "none", or "log" for `y = scale ln(w) + offset`.
    #[getter]
    fn post_warp(&self) -> &'static str {
        match self.partition.post_warp {
            PostWarp::None => "none",
            PostWarp::Log { .. } => "log",
        }
    }
    /// Name of the technique that made this map.
    #[getter]
    fn technique(&self) -> &'static str {
        self.partition.technique
    }
    /// Intermediate numbers by name.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        values_dict(py, &self.partition)
    }
    /// NDC (N, 3) and clip w (N,) of world points (N, 3). NDC means something where w > 0.
    #[allow(clippy::type_complexity)]
    fn project<'py>(
        &self,
        points: &Bound<'py, PyAny>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>)> {
        let py = points.py();
        let points = array::<f64>(points, "points", &[None, Some(3)])?;
        let rows = rows3(&points)?;
        let (mut ndc, mut w) = (Vec::with_capacity(3 * rows.len()), Vec::with_capacity(rows.len()));
        for &p in rows {
            let (p_ndc, p_w) = self.partition.project(p.into());
            ndc.extend(p_ndc.to_array());
            w.push(p_w);
        }
        Ok((image(py, ndc, [rows.len(), 3])?, image(py, w, [rows.len()])?))
    }
    fn __repr__(&self) -> String {
        let [near, far] = self.partition.eye_depth;
        format!("Partition(eye_depth=({near}, {far}))")
    }
}
