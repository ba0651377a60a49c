//! `_core.Samples`: what the camera sees, as points, for techniques that look at receivers.

use glam::DVec3;
use numpy::{PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;

use super::arguments::{paired_rows, whole, word_or};
use super::camera::{PyCamera, camera};
use super::convert::{OrRaise, argument_error, array, image, instance_of, rows3, run_sized, run_watched, size2};
use super::exceptions::refusable;
use super::gbuffer::{PyGBuffer, gbuffer};
use super::light::{light, light_to_object};
use super::parameterization::as_parameterization;
use super::sample_states::{NAME, VERSION, arrays_of, head_of, identity, sealed};
use super::state::{Reduced, first_eight, reduced};
use crate::digest::Numbers;
use crate::focus::{EdgeSample, Picture, Samples};
use crate::image::TruthMask;
use crate::survey;
use crate::techniques::Holds;

/// What a camera sees, as points: what techniques make maps for.
#[pyclass(name = "Samples", frozen, module = "shadowlab")]
pub struct PySamples {
    pub samples: Samples,
}

/// Samples that are looked at one by one in some milliseconds.
pub const SOON: usize = 1 << 16;

/// Samples for a technique.
pub enum Given<'py> {
    Samples(Bound<'py, PySamples>),
    GBuffer(Bound<'py, PyGBuffer>),
}

/// An argument of that kind, or nothing.
pub fn given<'py>(value: &Bound<'py, PyAny>) -> PyResult<Option<Given<'py>>> {
    if value.is_none() {
        return Ok(None);
    }
    if let Ok(g) = value.cast::<PyGBuffer>() {
        return Ok(Some(Given::GBuffer(g.clone())));
    }
    samples(value).map(|s| Some(Given::Samples(s)))
}

/// A samples argument.
pub fn samples<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PySamples>> {
    instance_of(value, "samples", "view.samples() makes them, and a technique takes a GBuffer as well")
}

/// Samples that `from_gbuffer` made of this G-buffer without shadows, under a light; `shadows` and `count` as there. They share
/// positions and normals.
#[pyfunction]
#[pyo3(signature = (samples, gbuffer, light, shadows, count))]
pub fn samples_under(
    #[pyo3(from_py_with = samples)] samples: Bound<'_, PySamples>,
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'_, PyGBuffer>,
    #[pyo3(from_py_with = light)] light: crate::Light,
    shadows: &Bound<'_, PyAny>,
    count: &Bound<'_, PyAny>,
) -> PyResult<PySamples> {
    let (py, samples) = (shadows.py(), &samples.get().samples);
    let [w, h] = gbuffer.get().picture();
    let states = states_of(shadows, "shadows", &[Some(h as usize), Some(w as usize)])?;
    let count = kept_of(Some(count))?;
    let samples = gbuffer.get().with_surfaces(py, |surfaces| {
        let seen = surfaces.triangle.iter().filter(|&&triangle| triangle >= 0).count();
        if samples.len() != seen || samples.picture.is_none_or(|picture| picture.size != [w, h]) {
            let expected = format!("samples of the {seen} pixels that show something, of {w} x {h}");
            return Err(argument_error(py, "samples", expected, samples.len(), "Samples.from_gbuffer makes them"));
        }
        run_watched(py, None, |progress| {
            samples.clone().with_shadows_watched(&light, states, surfaces, count, || progress.check())
        })
    })?;
    Ok(PySamples { samples })
}

#[pymethods]
impl PySamples {
    /// The pixels of a picture as samples.
    ///
    /// Parameters
    /// ----------
    /// gbuffer : GBuffer
    ///     What the camera sees.
    /// camera : Camera
    ///     The camera that sees it.
    /// light : DirectionalLight, SpotLight or PointLight, optional
    ///     The light of `shadows`.
    /// shadows : (H, W) int8 or float32, optional
    ///     States as `trace.Truth` has them, or a shadow mask (1 lit, 0 in shadow). Without them only `range=seen` and
    ///     `fit=seen` can use the samples.
    /// count : int
    ///     Samples at the shadows' edges that are kept, evenly chosen.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     An argument of another type or shape; shadows without a light.
    #[staticmethod]
    #[pyo3(signature = (gbuffer, camera, light=None, *, shadows=None, count=None),
        text_signature = "(gbuffer, camera, light=None, *, shadows=None, count=4096)")]
    fn from_gbuffer(
        py: Python<'_>,
        #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'_, PyGBuffer>,
        #[pyo3(from_py_with = camera)] camera: Bound<'_, PyCamera>,
        light: Option<&Bound<'_, PyAny>>,
        shadows: Option<&Bound<'_, PyAny>>,
        count: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let light = light.map(self::light).transpose()?;
        let count = kept_of(count)?;
        let camera = camera.get().camera;
        let [w, h] = gbuffer.get().picture().map(|n| Some(n as usize));
        let states = match (shadows, &light) {
            (None, _) => None,
            (Some(_), None) => return Err(lightless(py, "shadows")),
            (Some(shadows), Some(_)) => Some(states_of(shadows, "shadows", &[h, w])?),
        };
        gbuffer.get().check_samples(py)?;
        let samples = gbuffer.get().with_surfaces(py, |surfaces| {
            run_watched(py, None, |progress| {
                let check = || progress.check();
                let samples = Samples::of_surfaces_watched(surfaces, &camera, check)?;
                match (states, light) {
                    (Some(states), Some(light)) => samples.with_shadows_watched(&light, states, surfaces, count, check),
                    _ => Ok(samples),
                }
            })
        })?;
        Ok(Self { samples })
    }
    /// Samples of an engine's own.
    ///
    /// Parameters
    /// ----------
    /// positions : (N, 3) float
    ///     Visible surface points, world units; kept as float32 relative to their mean.
    /// normals : (N, 3) float
    ///     Unit normals on the side of the eye.
    /// camera : Camera
    ///     The camera that sees them.
    /// light : DirectionalLight, SpotLight or PointLight, optional
    ///     The light of `shadows`.
    /// size : int or (int, int), optional
    ///     Width and height, pixels, of the picture that they were taken from: each stands for a pixel of it. 128 where
    ///     none is given.
    /// shadows : (N,) int8 or float32, optional
    ///     States of the samples, as of `from_gbuffer`.
    /// edge_normals : (N, 2) float, optional
    ///     Unit normals, x to the right and y down, of the shadows' edges in the picture; zero for a sample at no edge.
    /// weights : (N,) float, optional
    ///     Pixels at edges that a sample stands for; 1 where none are given.
    /// count : int
    ///     Samples at the shadows' edges that are kept, evenly chosen.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     An argument of another type or shape, or not finite; shadows or edges without a light, edges without shadows.
    #[staticmethod]
    #[pyo3(signature = (positions, normals, camera, light=None, *, size=None, shadows=None, edge_normals=None, weights=None, count=None),
        text_signature = "(positions, normals, camera, light=None, *, size=None, shadows=None, edge_normals=None, weights=None, count=4096)")]
    #[allow(clippy::too_many_arguments)]
    fn from_arrays(
        py: Python<'_>,
        positions: &Bound<'_, PyAny>,
        normals: &Bound<'_, PyAny>,
        #[pyo3(from_py_with = camera)] camera: Bound<'_, PyCamera>,
        light: Option<&Bound<'_, PyAny>>,
        size: Option<&Bound<'_, PyAny>>,
        shadows: Option<&Bound<'_, PyAny>>,
        edge_normals: Option<&Bound<'_, PyAny>>,
        weights: Option<&Bound<'_, PyAny>>,
        count: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let light = light.map(self::light).transpose()?;
        let count = kept_of(count)?;
        let size = size.map_or(Ok([128; 2]), |size| size2(size, "size"))?;
        let positions = array::<f64>(positions, "positions", &[None, Some(3)])?;
        let positions: Vec<DVec3> = rows3(&positions)?.iter().map(|p| DVec3::from_array(*p)).collect();
        let n = Some(positions.len());
        let normals = paired_rows(normals, "normals", "positions", positions.len())?;
        let normals: Vec<DVec3> = rows3(&normals)?.iter().map(|p| DVec3::from_array(*p)).collect();
        for (name, list) in [("positions", &positions), ("normals", &normals)] {
            if !list.iter().all(|v| v.is_finite()) {
                return Err(argument_error(
                    py,
                    name,
                    "finite numbers",
                    "a NaN or an infinity",
                    "check where they come from",
                ));
            }
        }
        if let Some(n) = normals.iter().find(|n| (n.length() - 1.0).abs() > 1e-3) {
            return Err(argument_error(
                py,
                "normals",
                "unit vectors",
                format!("one of length {}", n.length()),
                "normalize them",
            ));
        }
        let samples = Samples::of_arrays(&positions, &normals, Picture::new(&camera.get().camera, size));
        let Some(light) = light else {
            return match (shadows, edge_normals) {
                (None, None) => Ok(Self { samples }),
                _ => Err(lightless(py, "shadows or edge_normals")),
            };
        };
        let Some(shadows) = shadows else {
            let fix = "give the states of the samples too";
            return match edge_normals {
                None => Ok(Self { samples }),
                Some(_) => Err(argument_error(py, "shadows", "states, where edge_normals are given", "none", fix)),
            };
        };
        let states = states_of(shadows, "shadows", &[n])?;
        let edges = edges_of(edge_normals, weights, n)?;
        Ok(Self { samples: py.detach(|| samples.with_states(&light, states, &edges, count)) })
    }
    /// How many samples there are.
    fn __len__(&self) -> usize {
        self.samples.chosen().len()
    }
    /// Visible surface points that the hulls of maps are made of: all pixels that show something, or all given points.
    #[getter]
    fn receivers(&self) -> usize {
        self.samples.len()
    }
    /// The light of the shadow states; None without any.
    #[getter]
    fn light<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.samples.shadows.as_ref().map(|shadows| light_to_object(py, &shadows.light)).transpose()
    }
    /// The camera that sees them.
    #[getter]
    fn camera(&self) -> Option<PyCamera> {
        self.samples.picture.as_ref().map(|picture| PyCamera { camera: picture.camera })
    }
    /// (width, height) of the picture that they come from, pixels.
    #[getter]
    fn size(&self) -> Option<(u32, u32)> {
        self.samples.picture.as_ref().map(|picture| picture.size.into())
    }
    /// (N, 3) float64: world positions.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.each(|i| self.samples.sample(i).0.to_array()))
    }
    /// (N, 3) float64: unit normals on the side of the eye.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        rows(py, self.each(|i| self.samples.sample(i).1.to_array()))
    }
    /// (N,) float64: depths along the view, world units.
    #[getter]
    fn eye_depth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let depth = |p: DVec3| self.samples.picture.as_ref().map_or(0.0, |picture| picture.camera.depth_of(p));
        let all = self.each(|i| depth(self.samples.sample(i).0));
        let n = all.len();
        image(py, all, [n])
    }
    /// (N, 2, 3) float64: the eye's Jacobian, pixels (x to the right, y down) per world unit (E.5).
    #[getter]
    fn jacobian<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let rows = |p: DVec3| {
            let found = self.samples.picture.as_ref().map(|picture| picture.gradients(p - picture.camera.eye()));
            found.unwrap_or_default().map(|g| g.to_array())
        };
        let all = self.each(|i| rows(self.samples.sample(i).0));
        let n = all.len();
        image(py, all.into_flattened().into_flattened(), [n, 2, 3])
    }
    /// (N,) float32: pixels that a sample stands for.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f32>>> {
        let all: Vec<f32> = self.samples.chosen().iter().map(|edge| edge.weight).collect();
        let n = all.len();
        image(py, all, [n])
    }
    /// (N,) int8: states as `trace.Truth` has them; -1 where they are not known.
    #[getter]
    fn shadow<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<i8>>> {
        let state = |i: usize| self.samples.shadows.as_ref().map_or(TruthMask::UNDECIDED, |shadows| shadows.states[i]);
        let all = self.each(state);
        let n = all.len();
        image(py, all, [n])
    }
    /// (N, 2) float32: unit normals of the shadows' edges in the picture, x to the right and y down, from shadow to light; zero
    /// for a sample at no edge.
    #[getter]
    fn edge_normals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        rows(py, self.samples.chosen().iter().map(|edge| edge.normal).collect())
    }
    /// Visible points that face the light and that no map holds, where all is lit.
    ///
    /// Parameters
    /// ----------
    /// parameterization : Parameterization
    ///     The maps.
    ///
    /// Returns
    /// -------
    /// (int, int)
    ///     All of them, and those in shadow.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     Samples without shadow states.
    fn outside(&self, parameterization: &Bound<'_, PyAny>) -> PyResult<(usize, usize)> {
        let py = parameterization.py();
        let p = as_parameterization(parameterization)?;
        let p = &p.get().p;
        let takes_long = self.samples.len() > SOON;
        Ok(run_sized(py, takes_long, |progress| survey::outside(&self.samples, p, progress))?.into())
    }
    /// Visible points that a map must hold and that no map holds.
    ///
    /// Parameters
    /// ----------
    /// parameterization : Parameterization
    ///     The maps.
    /// holds : {"shadow", "seen"}
    ///     What maps must hold: points in shadow and their neighbours in the picture, as outside of a map all is lit; or all
    ///     that face the light. As `Technique.holds`.
    ///
    /// Returns
    /// -------
    /// int
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     Samples without shadow states, or another word.
    #[pyo3(signature = (parameterization, holds=None), text_signature = "($self, parameterization, holds='shadow')")]
    fn missed(&self, parameterization: &Bound<'_, PyAny>, holds: Option<&Bound<'_, PyAny>>) -> PyResult<usize> {
        let py = parameterization.py();
        let p = as_parameterization(parameterization)?;
        let holds = match word_or(holds, "holds", "shadow", "shadow or seen")?.as_str() {
            "shadow" => Holds::Shadow,
            "seen" => Holds::Seen,
            other => {
                let fix = "Technique.holds has the word";
                return Err(argument_error(py, "holds", "shadow or seen", format!("{other:?}"), fix));
            }
        };
        let p = &p.get().p;
        run_sized(py, self.samples.len() > SOON, |progress| survey::missed(&self.samples, p, holds, progress))
    }
    /// The mean width of the texels of maps across the edges of visible shadows, pixels (10.8).
    ///
    /// A width w counts as 32 (1 - exp(-w / 32)), so that no single edge can rule the mean; an edge that no map holds counts as
    /// 32.
    ///
    /// Parameters
    /// ----------
    /// parameterization : Parameterization
    ///     The maps.
    /// resolution : int or (int, int), optional
    ///     Texels along the sides of each map; those it was made for where none are given.
    ///
    /// Returns
    /// -------
    /// float
    ///     Pixels of the picture that the samples come from; 0 where they have no edge.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     Samples without shadow states, or a resolution that is none.
    #[pyo3(signature = (parameterization, *, resolution=None))]
    fn edge_width(&self, parameterization: &Bound<'_, PyAny>, resolution: Option<&Bound<'_, PyAny>>) -> PyResult<f64> {
        let py = parameterization.py();
        let p = as_parameterization(parameterization)?;
        let p = &p.get().p;
        let resolution = resolution.map_or(Ok(p.resolution), |r| size2(r, "resolution"))?;
        py.detach(|| survey::edge_width(&self.samples, p, resolution)).or_raise(py)
    }
    fn __eq__(&self, py: Python<'_>, other: PyRef<'_, Self>) -> PyResult<bool> {
        Ok(std::ptr::eq(self, &*other) || self.identity(py)? == other.identity(py)?)
    }
    // Not by what `==` makes of both: the other side may answer with anything.
    fn __ne__(&self, py: Python<'_>, other: PyRef<'_, Self>) -> PyResult<bool> {
        Ok(!self.__eq__(py, other)?)
    }
    fn __hash__(&self, py: Python<'_>) -> PyResult<u64> {
        Ok(first_eight(&self.identity(py)?))
    }
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let (head, takes_long) = (head_of(&self.samples, Numbers::Exact), self.samples.len() > SOON);
        let seal = run_sized(py, takes_long, |progress| sealed(&self.samples, Numbers::Exact, progress))?;
        reduced(py, NAME, VERSION, head.bytes(), &seal, arrays_of(py, &self.samples)?)
    }
    fn __repr__(&self) -> String {
        let edges = self.samples.shadows.as_ref().map_or(0, |shadows| shadows.edges.len());
        format!("Samples({} at shadows' edges, of {} visible points)", edges, self.samples.len())
    }
}

impl PySamples {
    fn identity(&self, py: Python<'_>) -> PyResult<[u8; 32]> {
        run_sized(py, self.samples.len() > SOON, |progress| identity(&self.samples, progress))
    }
    fn each<T>(&self, of: impl Fn(usize) -> T) -> Vec<T> {
        self.samples.chosen().iter().map(|edge| of(edge.sample as usize)).collect()
    }
}

/// Rows as an array, without a copy.
fn rows<T: numpy::Element, const N: usize>(py: Python<'_>, rows: Vec<[T; N]>) -> PyResult<Bound<'_, PyArray2<T>>> {
    let n = rows.len();
    image(py, rows.into_flattened(), [n, N])
}

/// How many samples at edges are kept, 4096 where nobody says.
fn kept_of(count: Option<&Bound<'_, PyAny>>) -> PyResult<usize> {
    let found = count.map_or(Ok(4096), |count| whole(count, "count", [0, i64::MAX], "4096 is a good start"))?;
    Ok(found as usize)
}

fn lightless(py: Python<'_>, what: &str) -> PyErr {
    let fix = "give the light too: samples know the shadows of one light";
    argument_error(py, "light", format!("a light, where {what} are given"), "none", fix)
}

/// States of an array of them, or of a mask of light.
fn states_of(shadows: &Bound<'_, PyAny>, name: &str, shape: &[Option<usize>]) -> PyResult<Vec<i8>> {
    match array::<i8>(shadows, name, shape) {
        Ok(states) => return Ok(states.as_slice()?.to_vec()),
        Err(error) => refusable(shadows.py(), error)?,
    };
    let light = array::<f32>(shadows, name, shape)?;
    Ok(light.as_slice()?.iter().map(|share| TruthMask::of_light(*share)).collect())
}

/// The samples at edges of arrays.
fn edges_of(
    normals: Option<&Bound<'_, PyAny>>,
    weights: Option<&Bound<'_, PyAny>>,
    n: Option<usize>,
) -> PyResult<Vec<EdgeSample>> {
    let Some(normals) = normals else { return Ok(Vec::new()) };
    let py = normals.py();
    let normals = array::<f32>(normals, "edge_normals", &[n, Some(2)])?;
    let weights = weights.map(|w| array::<f32>(w, "weights", &[n])).transpose()?;
    let weights = weights.as_ref().map(|w| w.as_slice()).transpose()?;
    let mut edges = Vec::new();
    for (i, &[x, y]) in normals.as_slice()?.as_chunks::<2>().0.iter().enumerate() {
        let (length, weight) = (x.hypot(y), weights.map_or(1.0, |w| w[i]));
        if !(length.is_finite() && weight >= 0.0 && weight.is_finite()) {
            let got = format!("normal ({x}, {y}) and weight {weight} of sample {i}");
            return Err(argument_error(
                py,
                "edge_normals",
                "finite normals and weights of 0 or more",
                got,
                "check them",
            ));
        }
        if length > 0.0 && weight > 0.0 {
            edges.push(EdgeSample { sample: i as u32, normal: [x / length, y / length], weight });
        }
    }
    Ok(edges)
}
