//! `_core.Parameterization` and `_core.Partition`.

use glam::DMat4;
use numpy::{PyArray1, PyArray2, PyArray3, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};

use super::arguments::word_or;
use super::convert::{OrRaise, argument_error, array, image, in_parts, mat4_from_rows, mat4_to_array, rows3, texels};
use super::exceptions::{exception, refusable};
use super::map_fields::{each, eye_depths, is_singular, post_warp_of, region_of};
use super::note::notes_tuple;
use super::settings::{settings_dict, value_text};
use super::state::{Reduced, by_state, reduce};
use crate::names::named;
use crate::parameterization::{Factors, Parameterization, Partition, PiecewiseLinear, PostWarp, Selection};

/// The maps of a technique for one scene, camera and light: plain data.
#[pyclass(name = "Parameterization", frozen, eq, hash, module = "shadowlab")]
pub struct PyParameterization {
    pub p: Parameterization,
}

/// One map of a parameterization.
#[pyclass(name = "Partition", frozen, eq, hash, module = "shadowlab")]
pub struct PyPartition {
    pub partition: Partition,
}

by_state!(PyParameterization, PyPartition);

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

/// How a receiver finds its map, with the names users know.
pub const SELECTIONS: [(&str, Selection); 2] = [("depth", Selection::Depth), ("containment", Selection::Containment)];

/// The `shadowlab.Convention` that a convention or its name means.
pub fn convention<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    value.py().import("shadowlab.conventions.convention")?.getattr("Convention")?.call_method1("of", (value,))
}

/// An error unless a convention leaves those coordinates as they are that a post-warp replaces.
fn keeps_warped(convention: &Bound<'_, PyAny>, post_warp: &PostWarp) -> PyResult<()> {
    let keeps = |axis: &str| convention.getattr(axis)?.extract::<bool>();
    let (kept, expected, fix) = match post_warp {
        PostWarp::None => return Ok(()),
        PostWarp::Log { .. } => (
            keeps("keeps_y")?,
            "a convention with y up in [-1, 1]",
            "the logarithm that replaces y is in NDC: apply it first, then the convention's map_from_ndc",
        ),
        PostWarp::Rectilinear(_) => (
            keeps("keeps_x")? && keeps("keeps_y")?,
            "a convention with x to the right and y up in [-1, 1]",
            "the rectilinear warp of x and y is in NDC: apply it first, then the convention's map_from_ndc",
        ),
    };
    if kept {
        return Ok(());
    }
    Err(argument_error(convention.py(), "convention", expected, convention.str()?.to_string(), fix))
}

#[pymethods]
impl PyParameterization {
    /// Somebody else's matrices as a parameterization.
    ///
    /// Parameters
    /// ----------
    /// matrix : (4, 4) or (K, 4, 4) array_like
    ///     Shadow clip from world: acts on column vectors; NDC x, y in [-1, 1] with y up, z in [0, 1] with 0 nearest the light;
    ///     or as the convention says.
    /// convention : Convention or str, optional
    ///     How the matrices are written, "opengl" for example; as ours where none is given.
    /// resolution : int or (int, int), optional
    ///     Texels along the sides, width and height where they differ, that the matrix was made for; 1024 where none are given.
    /// eye_depth : (K, 2) array_like, optional
    ///     Near and far camera depth that each map serves, world units; all depths where none are given.
    /// selection : str
    ///     How a receiver finds its map: "depth", by the camera depth, or "containment", the first that holds it.
    /// post_warp : sequence, optional
    ///     What follows each matrix: None; ``("log", scale, offset)`` where y is replaced by ``scale ln(w) + offset``; or
    ///     ``("rectilinear", x, y)`` with knots (N, 2) of two ascending functions, (before, after) in NDC each, linear between
    ///     and beyond them, by which x and y are replaced.
    /// regions : sequence of (N, 4) array_like, optional
    ///     The rays that each map serves, those of points p of our world with ``region @ (p, 1) >= 0``; all where N is 0.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For another shape, numbers that are not finite, a singular matrix, depths that are no ranges, knots that do not
    ///     ascend, or a convention that changes a coordinate that a post-warp replaces.
    /// UnknownNameError
    ///     For a convention or a selection that does not exist.
    #[staticmethod]
    #[pyo3(signature = (matrix, *, convention=None, resolution=None, eye_depth=None, selection=None, post_warp=None,
        regions=None),
        text_signature = "(matrix, *, convention=None, resolution=1024, eye_depth=None, selection='depth', post_warp=None, regions=None)")]
    #[allow(clippy::too_many_arguments)]
    fn from_matrix(
        matrix: &Bound<'_, PyAny>,
        convention: Option<&Bound<'_, PyAny>>,
        resolution: Option<&Bound<'_, PyAny>>,
        eye_depth: Option<&Bound<'_, PyAny>>,
        selection: Option<&Bound<'_, PyAny>>,
        post_warp: Option<&Bound<'_, PyAny>>,
        regions: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let py = matrix.py();
        let resolution = texels(resolution)?;
        let stack = array::<f64>(matrix, "matrix", &[None, Some(4), Some(4)]).or_else(|error| {
            refusable(py, error)?;
            array::<f64>(matrix, "matrix", &[Some(4), Some(4)])
        })?;
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
        let name = word_or(selection, "selection", "depth", "depth or containment")?;
        let selection = named("selection", &name, &SELECTIONS).or_raise(py)?;
        let ours = match convention {
            None => stack,
            Some(c) => array::<f64>(&self::convention(c)?.call_method1("to_ours", (stack.as_any(),))?, "matrix", &[])?,
        };
        let matrices = ours.as_slice()?.as_chunks::<16>().0;
        let mut partitions: Vec<_> = matrices.iter().map(|m| Partition::of_matrix(mat4_from_rows(m))).collect();
        if let Some(depths) = eye_depth.map(|value| eye_depths(value, partitions.len())).transpose()? {
            partitions.iter_mut().zip(depths).for_each(|(partition, depth)| partition.eye_depth = depth);
        }
        if let Some(list) = post_warp {
            let warps = each(list, "post_warp", partitions.len(), post_warp_of)?;
            if let Some(convention) = convention {
                let convention = self::convention(convention)?;
                warps.iter().try_for_each(|warp| keeps_warped(&convention, warp))?;
            }
            partitions.iter_mut().zip(warps).for_each(|(partition, warp)| partition.post_warp = warp);
        }
        if let Some(list) = regions {
            let found = each(list, "regions", partitions.len(), region_of)?;
            partitions.iter_mut().zip(found).for_each(|(partition, region)| partition.region = region);
        }
        Ok(Parameterization { selection, ..Parameterization::of_partitions(partitions, resolution) }.into())
    }
    /// The matrix, or the matrices where there are several maps, as a convention writes them.
    ///
    /// Parameters
    /// ----------
    /// convention : Convention or str
    ///     "opengl" for example.
    ///
    /// Returns
    /// -------
    /// (4, 4) or (K, 4, 4) float64
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     Where a convention changes a coordinate that the post-warp behind a map's matrix replaces.
    /// UnknownNameError
    ///     For a convention that does not exist.
    fn to<'py>(&self, convention: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let py = convention.py();
        let convention = self::convention(convention)?;
        self.p.partitions.iter().try_for_each(|map| keeps_warped(&convention, &map.post_warp))?;
        match self.p.partitions.as_slice() {
            [_] => convention.call_method1("from_ours", (self.matrix(py)?,)),
            _ => convention.call_method1("from_ours", (self.matrices(py)?,)),
        }
    }
    /// How a receiver finds its map: "depth" or "containment".
    #[getter]
    fn selection(&self) -> &'static str {
        SELECTIONS.iter().find(|s| s.1 == self.p.selection).map_or("depth", |s| s.0)
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
    /// What to know about this result; `str` of a note is its text. Equal notes of several maps are one.
    #[getter]
    fn notes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        notes_tuple(py, &self.p.notes)
    }
    /// Texels along the sides it was fitted for: one number, or (width, height) where they differ.
    #[getter]
    fn resolution<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let [width, height] = self.p.resolution;
        Ok(if width == height {
            width.into_pyobject(py)?.into_any()
        } else {
            (width, height).into_pyobject(py)?.into_any()
        })
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
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduce(py, self)
    }
    /// The maps as a table, for notebooks.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("shadowlab.reports.html.values")?.call_method1("parameterization_html", (slf,))
    }
    fn __repr__(&self) -> String {
        let settings: Vec<String> = self.p.settings.iter().map(|(k, v)| format!(", {k}={}", value_text(v))).collect();
        let notes: String = self.p.notes.iter().map(|note| format!("; {note}")).collect();
        format!(
            "Parameterization({:?}{}, maps={}, resolution={}{notes})",
            self.p.technique,
            settings.concat(),
            self.p.partitions.len(),
            match self.p.resolution {
                [width, height] if width == height => width.to_string(),
                [width, height] => format!("({width}, {height})"),
            }
        )
    }
}

impl PyPartition {
    fn factor<'py>(
        &self,
        py: Python<'py>,
        which: impl FnOnce(&Factors) -> DMat4,
    ) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.partition.factors.as_ref().map(|factors| mat4_to_array(py, &which(factors))).transpose()
    }
}

#[pymethods]
impl PyPartition {
    /// (4, 4) float64: shadow clip from world.
    #[getter]
    fn matrix<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        mat4_to_array(py, &self.partition.shadow_clip_from_world)
    }
    /// (4, 4) float64: light space from world, the first factor of ``matrix == fit @ warp @ lift``.
    ///
    /// Rows x, y and w of a point are the light's ray through it, row z is its place along the ray. Under a directional light:
    /// across, along the warp axis and along the light, in world units, w = 1. Under a spot: the light's perspective, w the
    /// depth along its axis, z = -1. None of matrices from elsewhere.
    #[getter]
    fn lift<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.factor(py, |factors| factors.lift)
    }
    /// (4, 4) float64: provisional clip space from light space, the second factor of ``matrix == fit @ warp @ lift``.
    ///
    /// Rows x, y and w are the homography on the light's rays that makes the technique; the identity of a uniform map. Row z is
    /// the depth before the crop. None of matrices from elsewhere.
    #[getter]
    fn warp<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.factor(py, |factors| factors.warp)
    }
    /// (4, 4) float64: clip space from provisional clip space, the third factor of ``matrix == fit @ warp @ lift``.
    ///
    /// The affine crop to receivers and casters, with the border, times a positive factor. None of matrices from elsewhere.
    #[getter]
    fn fit<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        self.factor(py, |factors| factors.fit)
    }
    /// (near, far) camera depth this map serves, world units.
    #[getter]
    fn eye_depth(&self) -> (f64, f64) {
        self.partition.eye_depth.into()
    }
    /// What follows the projective part: "none"; "log" for ``y = scale ln(w) + offset``; or "rectilinear", where x and y are
    /// replaced by ascending functions of themselves.
    #[getter]
    fn post_warp(&self) -> &'static str {
        self.partition.post_warp.name()
    }
    /// The terms of what follows the projective part: `scale` and `offset` of "log", nothing of the others.
    #[getter]
    fn post_warp_terms<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let d = PyDict::new(py);
        if let PostWarp::Log { scale, offset } = self.partition.post_warp {
            d.set_item("scale", scale)?;
            d.set_item("offset", offset)?;
        }
        Ok(d)
    }
    /// ((N, 2), (M, 2)) float64: the knots of the two functions of "rectilinear", for x and for y, (before, after) in NDC
    /// each; None of the others. They are linear between the knots, and beyond the outer ones as next to them.
    #[getter]
    #[allow(clippy::type_complexity)]
    fn post_warp_knots<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Option<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)>> {
        let Some(warp) = self.partition.post_warp.rectilinear() else { return Ok(None) };
        let knots = |f: &PiecewiseLinear| image(py, f.knots().flatten().collect(), [f.knots().len(), 2]);
        Ok(Some((knots(&warp.x)?, knots(&warp.y)?)))
    }
    /// (N, 4) float64: the rays this map serves, those of points p with `region @ (p, 1) >= 0`; all of them where N is 0.
    #[getter]
    fn region<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = self.partition.region.functionals();
        image(py, rows.iter().flat_map(|row| row.to_array()).collect(), [rows.len(), 4])
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
    /// What to know about this map; `str` of a note is its text. What concerns all maps alike is in `Parameterization.notes`.
    #[getter]
    fn notes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        notes_tuple(py, &self.partition.notes)
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
        in_parts(py, rows.len(), |part| {
            for &p in &rows[part] {
                let (p_ndc, p_w) = self.partition.project(p.into());
                ndc.extend(p_ndc.to_array());
                w.push(p_w);
            }
            Ok(())
        })?;
        Ok((image(py, ndc, [rows.len(), 3])?, image(py, w, [rows.len()])?))
    }
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduce(py, self)
    }
    fn __repr__(&self) -> String {
        let [near, far] = self.partition.eye_depth;
        format!("Partition({:?}, eye_depth=({near}, {far}))", self.partition.technique)
    }
}

/// A parameterization, or matrices as one.
pub fn as_parameterization<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyParameterization>> {
    if let Ok(p) = value.cast::<PyParameterization>() {
        return Ok(p.clone());
    }
    let py = value.py();
    let made = py.get_type::<PyParameterization>().call_method1("from_matrix", (value,)).map_err(|error| {
        let error = match refusable(py, error) {
            Ok(error) => error,
            Err(other) => return other,
        };
        // Of what may be matrices, `from_matrix` says what is wrong.
        if value.cast::<PyUntypedArray>().is_ok() || value.cast::<PyList>().is_ok() || value.cast::<PyTuple>().is_ok() {
            let message = error.value(py).to_string();
            if let Some(of_matrix) = message.strip_prefix("matrix: ") {
                return exception(py, "ArgumentError", format!("parameterization: {of_matrix}"));
            }
        }
        let got = value.get_type().name().map(|n| n.to_string()).unwrap_or_default();
        let expected = "a Parameterization, or a finite (4, 4) or (K, 4, 4) array";
        argument_error(py, "parameterization", expected, got, "call technique.parameterize(...) first")
    })?;
    Ok(made.cast_into::<PyParameterization>()?)
}
