//! `_core.DirectionalLight`, `SpotLight`, `PointLight`.

use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

use super::arguments::items;
use super::convert::{OrRaise, argument_error, number, vec3, vec3_to_array, vec4_to_array};
use super::state::{Fault, Reader, Reduced, State, Writer, by_state, reduce};
use crate::scene::{DirectionalLight, Light, PointLight, SpotLight};

/// How to give the range of a placed light.
const REACH: &str = "give the distance that the light reaches, in world units";

/// A light at infinity that travels along `direction` ((3,), any length above 0).
#[pyclass(name = "DirectionalLight", frozen, eq, hash, module = "shadowlab")]
#[derive(Clone)]
pub struct PyDirectionalLight {
    pub(super) light: DirectionalLight,
}

impl State for PyDirectionalLight {
    const NAME: &'static str = "DirectionalLight";
    fn write(&self, to: &mut Writer) {
        to.vector(self.light.direction());
    }
    fn read(from: &mut Reader<'_>) -> Result<Self, Fault> {
        Ok(Self { light: DirectionalLight::of_unit(from.vector()?).map_err(|e| e.to_string())? })
    }
}

#[pymethods]
impl PyDirectionalLight {
    #[new]
    fn new(direction: &Bound<'_, PyAny>) -> PyResult<Self> {
        let light = DirectionalLight::new(vec3(direction, "direction")?).or_raise(direction.py())?;
        Ok(Self { light })
    }
    /// The light of a direction in the sky, such as the sun's.
    ///
    /// Parameters
    /// ----------
    /// azimuth : float
    ///     Where the light comes from, radians: a turn about the y axis, from +z (0) towards +x (pi/2).
    /// elevation : float
    ///     How high it stands above the horizon, radians, in [-pi/2, pi/2]; y points up, and pi/2 shines straight down.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For an angle that is not finite, or an elevation outside of its range.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, shadowlab as sl
    /// >>> sl.DirectionalLight.from_angles(np.radians(90), np.radians(30)).direction.round(3)
    /// array([-0.866, -0.5  , -0.   ])
    #[staticmethod]
    fn from_angles(py: Python<'_>, azimuth: &Bound<'_, PyAny>, elevation: &Bound<'_, PyAny>) -> PyResult<Self> {
        let fix = "give radians (np.radians turns degrees into them)";
        let (azimuth, elevation) = (number(azimuth, "azimuth", fix)?, number(elevation, "elevation", fix)?);
        Ok(Self { light: DirectionalLight::from_angles(azimuth, elevation).or_raise(py)? })
    }
    /// (3,) float64, unit: the way the light travels.
    #[getter]
    fn direction<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vec3_to_array(py, self.light.direction())
    }
    /// The word "directional".
    #[getter]
    fn kind(&self) -> &'static str {
        Light::Directional(self.light).kind()
    }
    /// (4,) float64: the centre of projection as a homogeneous point.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vec4_to_array(py, Light::Directional(self.light).point())
    }
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduce(py, self)
    }
    fn __repr__(&self) -> String {
        format!("DirectionalLight(direction={})", self.light.direction())
    }
}

/// A light at a point that shines into a circular cone of full angle `cone_angle` (radians) as far as `range`.
#[pyclass(name = "SpotLight", frozen, eq, hash, module = "shadowlab")]
#[derive(Clone)]
pub struct PySpotLight {
    pub(super) light: SpotLight,
}

impl State for PySpotLight {
    const NAME: &'static str = "SpotLight";
    fn write(&self, to: &mut Writer) {
        let l = &self.light;
        to.vector(l.position());
        to.vector(l.direction());
        to.numbers(&[l.cone_angle(), l.range()]);
    }
    fn read(from: &mut Reader<'_>) -> Result<Self, Fault> {
        let (position, direction, [cone_angle, range]) = (from.vector()?, from.vector()?, from.numbers()?);
        let light = SpotLight::new(position, direction, cone_angle, range).and_then(|l| l.with_unit(direction));
        Ok(Self { light: light.map_err(|e| e.to_string())? })
    }
}

#[pymethods]
impl PySpotLight {
    #[new]
    #[pyo3(signature = (position, direction, *, cone_angle, range))]
    fn new(
        position: &Bound<'_, PyAny>,
        direction: &Bound<'_, PyAny>,
        cone_angle: &Bound<'_, PyAny>,
        range: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let (p, d) = (vec3(position, "position")?, vec3(direction, "direction")?);
        let (cone_angle, range) = (number(cone_angle, "cone_angle", "give radians")?, number(range, "range", REACH)?);
        Ok(Self { light: SpotLight::new(p, d, cone_angle, range).or_raise(position.py())? })
    }
    /// (3,) float64: where the light is, world units.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vec3_to_array(py, self.light.position())
    }
    /// (3,) float64, unit: the way along the middle of the cone.
    #[getter]
    fn direction<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vec3_to_array(py, self.light.direction())
    }
    /// Full angle of the cone, radians.
    #[getter]
    fn cone_angle(&self) -> f64 {
        self.light.cone_angle()
    }
    /// How far the light reaches, world units.
    #[getter]
    fn range(&self) -> f64 {
        self.light.range()
    }
    /// The word "spot".
    #[getter]
    fn kind(&self) -> &'static str {
        Light::Spot(self.light).kind()
    }
    /// (4,) float64: the centre of projection as a homogeneous point.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vec4_to_array(py, Light::Spot(self.light).point())
    }
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduce(py, self)
    }
    fn __repr__(&self) -> String {
        let l = &self.light;
        let (p, d) = (l.position(), l.direction());
        format!("SpotLight(position={p}, direction={d}, cone_angle={:.6}, range={})", l.cone_angle(), l.range())
    }
}

/// A light at a point that shines everywhere as far as `range`.
#[pyclass(name = "PointLight", frozen, eq, hash, module = "shadowlab")]
#[derive(Clone)]
pub struct PyPointLight {
    pub(super) light: PointLight,
}

impl State for PyPointLight {
    const NAME: &'static str = "PointLight";
    fn write(&self, to: &mut Writer) {
        to.vector(self.light.position());
        to.numbers(&[self.light.range()]);
    }
    fn read(from: &mut Reader<'_>) -> Result<Self, Fault> {
        let (position, [range]) = (from.vector()?, from.numbers()?);
        Ok(Self { light: PointLight::new(position, range).map_err(|e| e.to_string())? })
    }
}

#[pymethods]
impl PyPointLight {
    #[new]
    #[pyo3(signature = (position, *, range))]
    fn new(position: &Bound<'_, PyAny>, range: &Bound<'_, PyAny>) -> PyResult<Self> {
        let light =
            PointLight::new(vec3(position, "position")?, number(range, "range", REACH)?).or_raise(position.py())?;
        Ok(Self { light })
    }
    /// (3,) float64: where the light is, world units.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vec3_to_array(py, self.light.position())
    }
    /// How far the light reaches, world units.
    #[getter]
    fn range(&self) -> f64 {
        self.light.range()
    }
    /// The word "point".
    #[getter]
    fn kind(&self) -> &'static str {
        Light::Point(self.light).kind()
    }
    /// (4,) float64: the centre of projection as a homogeneous point.
    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vec4_to_array(py, Light::Point(self.light).point())
    }
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduce(py, self)
    }
    fn __repr__(&self) -> String {
        format!("PointLight(position={}, range={})", self.light.position(), self.light.range())
    }
}

by_state!(PyDirectionalLight, PySpotLight, PyPointLight);

/// Any of the three.
pub fn light(value: &Bound<'_, PyAny>) -> PyResult<Light> {
    light_named(value, "light")
}

/// A light argument of another name.
pub fn light_named(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Light> {
    if let Ok(l) = value.cast::<PyDirectionalLight>() {
        return Ok(Light::Directional(l.get().light));
    }
    if let Ok(l) = value.cast::<PySpotLight>() {
        return Ok(Light::Spot(l.get().light));
    }
    if let Ok(l) = value.cast::<PyPointLight>() {
        return Ok(Light::Point(l.get().light));
    }
    if value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>() {
        let got = format!("several in a {}", value.get_type().name()?);
        return Err(argument_error(value.py(), name, "one light", got, "call it for each light"));
    }
    let got = value.get_type().name()?;
    Err(argument_error(value.py(), name, "a DirectionalLight, SpotLight or PointLight", got, "construct one"))
}

/// Several lights, each named by its place among them.
pub fn lights_named(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Vec<Light>> {
    let lights = items(value, name, "several lights", "give a list of lights")?;
    lights.iter().enumerate().map(|(i, one)| light_named(one, &format!("{name}[{i}]"))).collect()
}

/// The Python object of a core light.
pub fn light_to_object<'py>(py: Python<'py>, light: &Light) -> PyResult<Bound<'py, PyAny>> {
    Ok(match *light {
        Light::Directional(light) => Bound::new(py, PyDirectionalLight { light })?.into_any(),
        Light::Spot(light) => Bound::new(py, PySpotLight { light })?.into_any(),
        Light::Point(light) => Bound::new(py, PyPointLight { light })?.into_any(),
    })
}
