//! `_core.Stored`.

use numpy::{PyArray1, PyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyString;

use super::arguments::{number, vec3, word};
use super::convert::{OrRaise, SOON, argument_error, array, image, instance_of, rows3, run_parallel, run_sized};
use super::exceptions::warn;
use super::parameterization::as_parameterization;
use super::state::{Fault, Reader, Reduced, State, Writer, by_state, reduce};
use crate::parameterization::Held;
use crate::progress::Progress;
use crate::render::{Format, Spacing, Stored, StoredSurface, depth_measure, step_along_ray};
use crate::scene::Scene;
use glam::{DMat4, DVec3};

/// What a shadow map stores: which surface, how its depth is spaced, in which format.
///
/// Parameters
/// ----------
/// surface : str
///     "front": the surface nearest to the light. "back": the nearest that faces away from it, by the winding of its mesh.
///     "second": the nearest depth beyond the first. "midpoint": the middle of both along the ray. "dual": the first depth
///     moved by half of the way to the second, at most by `limit`. A ray without a second depth stores 1 for "second" and
///     "midpoint", and the first depth plus `limit` for "dual". Or the text of all settings, as `str` gives it:
///     "back:spacing=linear,format=unorm16".
/// spacing : str
///     "projective": z / w of the map's matrix. "linear": distance along the light, of a directional light along its own
///     direction, of another along the map's central ray; 0 at the nearest and 1 at the farthest corner of the map.
/// format : str
///     "f32", "f16", "unorm16" or "unorm24"; stored depths are rounded to the nearest number of the format.
/// limit : float
///     Upper limit of how far "dual" moves the first depth along the ray, world sizes of a shadow texel at the surface, across
///     the ray; infinity for none.
///
/// Raises
/// ------
/// ArgumentError
///     A limit that is negative, or a text that does not read.
/// UnknownNameError
///     No such surface, spacing or format.
///
/// References
/// ----------
/// theory.md 13. Wang and Molnar 1994 (second depth), Woo 1992 (midpoint), Weiskopf and Ertl 2003 (dual).
///
/// Examples
/// --------
/// >>> import shadowlab as sl
/// >>> sl.Stored("back", format="unorm16")
/// Stored('back', spacing='projective', format='unorm16', limit=8.0)
/// >>> str(sl.Stored("back:spacing=linear"))
/// 'back:spacing=linear'
#[pyclass(name = "Stored", frozen, eq, hash, module = "shadowlab")]
#[derive(Clone)]
pub struct PyStored {
    stored: Stored,
}

by_state!(PyStored);

impl State for PyStored {
    const NAME: &'static str = "Stored";
    fn write(&self, to: &mut Writer) {
        let s = &self.stored;
        to.text(s.surface.name());
        to.text(s.spacing.name());
        to.text(s.format.name());
        to.numbers(&[s.limit]);
    }
    fn read(from: &mut Reader<'_>) -> Result<Self, Fault> {
        let fault = |e: crate::Error| e.to_string();
        let surface = StoredSurface::named(&from.text()?).map_err(fault)?;
        let spacing = Spacing::named(&from.text()?).map_err(fault)?;
        let format = Format::named(&from.text()?).map_err(fault)?;
        let [limit] = from.numbers()?;
        Ok(Self { stored: Stored { surface, spacing, format, limit }.checked().map_err(fault)? })
    }
}

#[pymethods]
impl PyStored {
    #[new]
    #[pyo3(signature = (surface=None, *, spacing=None, format=None, limit=None),
        text_signature = "(surface='front', *, spacing='projective', format='f32', limit=8.0)")]
    fn new(
        py: Python<'_>,
        surface: Option<&Bound<'_, PyAny>>,
        spacing: Option<&Bound<'_, PyAny>>,
        format: Option<&Bound<'_, PyAny>>,
        limit: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let mut stored = match surface {
            Some(surface) => {
                word(surface, "surface", "a surface, or the text of all settings")?.parse().or_raise(py)?
            }
            None => Stored::default(),
        };
        if let Some(name) = spacing {
            stored.spacing = Spacing::named(&word(name, "spacing", "one of projective, linear")?).or_raise(py)?;
        }
        if let Some(name) = format {
            stored.format = Format::named(&word(name, "format", "one of f32, f16, unorm16, unorm24")?).or_raise(py)?;
        }
        if let Some(limit) = limit {
            stored.limit = number(limit, "limit", "give a number of texels")?;
        }
        Ok(Self { stored: stored.checked().or_raise(py)? })
    }
    /// Which depth of a ray: "front", "back", "second", "midpoint" or "dual".
    #[getter]
    fn surface(&self) -> &'static str {
        self.stored.surface.name()
    }
    /// How depth is spaced: "projective" or "linear".
    #[getter]
    fn spacing(&self) -> &'static str {
        self.stored.spacing.name()
    }
    /// The numbers that depths are rounded to: "f32", "f16", "unorm16" or "unorm24".
    #[getter]
    fn format(&self) -> &'static str {
        self.stored.format.name()
    }
    /// Of "dual": how far at most the first depth is moved along the ray, world sizes of a shadow texel.
    #[getter]
    fn limit(&self) -> f64 {
        self.stored.limit
    }
    /// The size of one step of the format at points, world units along the light ray.
    ///
    /// Parameters
    /// ----------
    /// parameterization : Parameterization, or (4, 4) or (K, 4, 4) array_like
    /// points : (N, 3) array_like
    ///     World points. The first map that holds a point counts.
    ///
    /// Returns
    /// -------
    /// (N,) float64
    ///     The distance along the ray over which the stored depth changes by one step of the format.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     A point that no map holds, or a map that has no points before its projection centre, where depth is linear.
    ///
    /// References
    /// ----------
    /// theory.md (13.10); docs/bias.md has a table.
    fn step<'py>(
        &self,
        parameterization: &Bound<'py, PyAny>,
        points: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let py = parameterization.py();
        let p = as_parameterization(parameterization)?;
        let partitions = &p.get().p.partitions;
        let points = array::<f64>(points, "points", &[None, Some(3)])?;
        let n = points.shape()[0];
        let points = rows3(&points)?;
        let map_of = |p: &[f64; 3]| {
            Held::first(0..partitions.len(), |k| match partitions[k].holds(DVec3::from_array(*p)) {
                Held::Beyond => Held::Outside,
                held => held,
            })
        };
        if let Some(i) = points.iter().position(|p| map_of(p).is_none()) {
            let expected = "points that a map of the parameterization holds";
            let fix = "give points between the near and the far plane of a map";
            return Err(argument_error(py, &format!("points[{i}]"), expected, format!("{:?}", points[i]), fix));
        }
        let stored = self.stored;
        let steps = run_sized(py, n > SOON, |progress: &Progress| {
            let mut steps = vec![0.0; n];
            for (k, partition) in partitions.iter().enumerate() {
                progress.check()?;
                let mine: Vec<usize> = (0..n).filter(|&i| map_of(&points[i]) == Some(k)).collect();
                if mine.is_empty() {
                    continue;
                }
                let step = step_along_ray(partition, &stored)?;
                mine.iter().for_each(|&i| steps[i] = step(DVec3::from_array(points[i])));
            }
            Ok(steps)
        })?;
        image(py, steps, [n])
    }
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduce(py, self)
    }
    fn __str__(&self) -> String {
        self.stored.to_string()
    }
    fn __repr__(&self) -> String {
        let s = &self.stored;
        let limit = if s.limit == f64::INFINITY { "float('inf')".into() } else { format!("{:?}", s.limit) };
        let (surface, spacing, format) = (s.surface.name(), s.spacing.name(), s.format.name());
        format!("Stored('{surface}', spacing='{spacing}', format='{format}', limit={limit})")
    }
}

/// What the numbers of each map measure of points (p, 1) relative to an origin: (K, 2, 4) float64, the rows whose products with a
/// point are divided by each other. Of projective depth those are z and w of the matrix.
#[pyfunction]
pub fn depth_rows<'py>(
    parameterization: &Bound<'py, PyAny>,
    origin: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = stored)] stored: Option<Stored>,
) -> PyResult<Bound<'py, PyArray3<f64>>> {
    let py = parameterization.py();
    let p = as_parameterization(parameterization)?;
    let (origin, stored) = (vec3(origin, "origin")?, stored.unwrap_or_default());
    let mut rows = Vec::new();
    for partition in &p.get().p.partitions {
        let clip_from_relative = partition.shadow_clip_from_world * DMat4::from_translation(origin);
        let [of, by] = depth_measure(&clip_from_relative, &partition.post_warp, stored.spacing).or_raise(py)?;
        rows.extend(of.to_array().into_iter().chain(by.to_array()));
    }
    let n = rows.len() / 8;
    image(py, rows, [n, 2, 4])
}

/// The distance to the next number of the format at stored depths (N,): (N,) float64.
#[pyfunction]
pub fn depth_steps<'py>(
    #[pyo3(from_py_with = stored)] stored: Option<Stored>,
    depths: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let (py, format) = (depths.py(), stored.unwrap_or_default().format);
    let depths = array::<f64>(depths, "depths", &[None])?;
    let steps: Vec<f64> = depths.as_slice()?.iter().map(|&z| format.step(z)).collect();
    let n = steps.len();
    image(py, steps, [n])
}

/// What is stored, as an argument: a `Stored`, its text, or nothing for the default.
pub fn stored(value: &Bound<'_, PyAny>) -> PyResult<Option<Stored>> {
    if value.is_none() {
        return Ok(None);
    }
    if value.is_instance_of::<PyString>() {
        let text = word(value, "stored", "what a map stores")?;
        return text.parse().map(Some).or_raise(value.py());
    }
    Ok(Some(instance_of::<PyStored>(value, "stored", "give a Stored or its text, for example \"back\"")?.get().stored))
}

/// Warns of meshes that are open where casters have to be closed.
pub fn warn_of_open_meshes(py: Python<'_>, scene: &Scene, stored: &Stored) -> PyResult<()> {
    if !stored.surface.needs_closed() {
        return Ok(());
    }
    let [open, all, edges] = run_parallel(py, scene.triangle_count() as usize > SOON, |progress| {
        let mut found = [0_usize, scene.meshes().len(), 0];
        for mesh in scene.meshes() {
            let edges = mesh.border_edges(progress)?;
            found[0] += usize::from(edges > 0);
            found[2] += edges;
        }
        Ok(found)
    })?;
    if open == 0 {
        return Ok(());
    }
    let surface = stored.surface.name();
    let message = format!(
        "stored={surface:?}: {open} of {all} meshes are open, with {edges} border edges; where a light ray enters one and never \
         leaves it, a map of the {surface} surface holds no caster"
    );
    warn(py, &message)
}
