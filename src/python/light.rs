//! `_core.DirectionalLight`, `SpotLight`, `PointLight`.

use numpy::PyArray1;
use pyo3::prelude::*;

use super::convert::{OrRaise, argument_error, number, vec3, vec3_to_array, vec4_to_array};
use crate::scene::{DirectionalLight, Light, PointLight, SpotLight};

/// How to give the range of a placed light.
const REACH: &str = "give the distance that the light reaches, in world units";

/// A light at infinity that travels along `direction` ((3,), any length above 0).
#[pyclass(name = "DirectionalLight", frozen, eq, module = "shadowlab")]
#[derive(PartialEq, Clone)]
pub struct PyDirectionalLight {
    light: DirectionalLight,
}

#[pymethods]
impl PyDirectionalLight {
    #[new]
    fn new(direction: &Bound<'_, PyAny>) -> PyResult<Self> {
        let light = DirectionalLight::new(vec3(direction, "direction")?).or_raise(direction.py())?;
        Ok(Self { light })
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
    fn __repr__(&self) -> String {
        format!("DirectionalLight(direction={})", self.light.direction())
    }
}

/// A light at a point that shines into a circular cone of full angle `cone_angle` (radians) as far as `range`.
#[pyclass(name = "SpotLight", frozen, eq, module = "shadowlab")]
#[derive(PartialEq, Clone)]
pub struct PySpotLight {
    light: SpotLight,
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
    fn __repr__(&self) -> String {
        let l = &self.light;
        let (p, d) = (l.position(), l.direction());
        format!("SpotLight(position={p}, direction={d}, cone_angle={:.6}, range={})", l.cone_angle(), l.range())
    }
}

/// A light at a point that shines everywhere as far as `range`.
#[pyclass(name = "PointLight", frozen, eq, module = "shadowlab")]
#[derive(PartialEq, Clone)]
pub struct PyPointLight {
    light: PointLight,
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
    fn __repr__(&self) -> String {
        format!("PointLight(position={}, range={})", self.light.position(), self.light.range())
    }
}

/// Any of the three.
pub fn light(value: &Bound<'_, PyAny>) -> PyResult<Light> {
    if let Ok(l) = value.cast::<PyDirectionalLight>() {
        return Ok(Light::Directional(l.get().light));
    }
    if let Ok(l) = value.cast::<PySpotLight>() {
        return Ok(Light::Spot(l.get().light));
    }
    if let Ok(l) = value.cast::<PyPointLight>() {
        return Ok(Light::Point(l.get().light));
    }
    let got = value.get_type().name()?;
    Err(argument_error(value.py(), "light", "a DirectionalLight, SpotLight or PointLight", got, "construct one"))
}

/// The Python object of a core light.
pub fn light_to_object<'py>(py: Python<'py>, light: &Light) -> PyResult<Bound<'py, PyAny>> {
    Ok(match *light {
        Light::Directional(light) => Bound::new(py, PyDirectionalLight { light })?.into_any(),
        Light::Spot(light) => Bound::new(py, PySpotLight { light })?.into_any(),
        Light::Point(light) => Bound::new(py, PyPointLight { light })?.into_any(),
    })
}
