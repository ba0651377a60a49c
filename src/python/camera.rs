//! `_core.Camera`.

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use super::convert::{OrRaise, array, image, instance_of, mat4_to_array, rows3, vec3, vec3_to_array};
use crate::scene::Camera;

/// A perspective camera (right-handed, looking along -z of its view space, NDC z in [0, 1]).
#[pyclass(name = "Camera", frozen, eq, module = "shadowlab")]
#[derive(PartialEq, Clone)]
pub struct PyCamera {
    pub camera: Camera,
}

/// A camera argument.
pub fn camera<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyCamera>> {
    instance_of(value, "camera", "make one with Camera.look_at")
}

#[pymethods]
impl PyCamera {
    /// A camera at `eye` that looks at `target`.
    ///
    /// Parameters
    /// ----------
    /// eye, target : (3,) array_like
    ///     Positions, world units.
    /// up : (3,) array_like
    ///     Any vector not parallel to the view.
    /// fov_y : float
    ///     Full vertical field of view, radians, in (0, pi).
    /// aspect : float
    ///     Width by height.
    /// near, far : float
    ///     Depths along the view direction, 0 < near < far, world units.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For anything not finite or outside its range, and for `up` parallel to the view.
    #[staticmethod]
    #[pyo3(signature = (eye, target, *, up=None, fov_y=std::f64::consts::FRAC_PI_3, aspect=16.0 / 9.0, near=0.1, far=1000.0))]
    #[allow(clippy::too_many_arguments)]
    fn look_at(
        py: Python<'_>,
        eye: &Bound<'_, PyAny>,
        target: &Bound<'_, PyAny>,
        up: Option<&Bound<'_, PyAny>>,
        fov_y: f64,
        aspect: f64,
        near: f64,
        far: f64,
    ) -> PyResult<Self> {
        let up = up.map_or(Ok(glam::DVec3::Y), |up| vec3(up, "up"))?;
        let camera = Camera::look_at(vec3(eye, "eye")?, vec3(target, "target")?, up, fov_y, aspect, near, far);
        Ok(Self { camera: camera.or_raise(py)? })
    }
    /// (3,) float64: position, world units.
    #[getter]
    fn eye<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vec3_to_array(py, self.camera.eye())
    }
    /// (3,) float64, unit: the picture's right.
    #[getter]
    fn right<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vec3_to_array(py, self.camera.right())
    }
    /// (3,) float64, unit: the picture's up, across the view.
    #[getter]
    fn up<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vec3_to_array(py, self.camera.up())
    }
    /// (3,) float64, unit: the way the camera looks.
    #[getter]
    fn forward<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vec3_to_array(py, self.camera.forward())
    }
    /// Full vertical field of view, radians.
    #[getter]
    fn fov_y(&self) -> f64 {
        self.camera.fov_y()
    }
    /// Width by height.
    #[getter]
    fn aspect(&self) -> f64 {
        self.camera.aspect()
    }
    /// Depth of the near plane along the view direction, world units.
    #[getter]
    fn near(&self) -> f64 {
        self.camera.near()
    }
    /// Depth of the far plane along the view direction, world units.
    #[getter]
    fn far(&self) -> f64 {
        self.camera.far()
    }
    /// (4, 4) float64: view from world.
    #[getter]
    fn view<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        mat4_to_array(py, &self.camera.view())
    }
    /// (4, 4) float64: clip from view.
    #[getter]
    fn projection<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        mat4_to_array(py, &self.camera.projection())
    }
    /// (4, 4) float64: clip from world.
    #[getter]
    fn clip_from_world<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        mat4_to_array(py, &self.camera.clip_from_world())
    }
    /// Depth along the view direction of world points: (N, 3) -> (N,).
    fn depth<'py>(&self, points: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let py = points.py();
        let points = array::<f64>(points, "points", &[None, Some(3)])?;
        let depths: Vec<f64> = rows3(&points)?.iter().map(|&p| self.camera.depth_of(p.into())).collect();
        let n = depths.len();
        image(py, depths, [n])
    }
    fn __repr__(&self) -> String {
        let c = &self.camera;
        format!(
            "Camera(eye={}, forward={}, fov_y={:.6}, aspect={:.6}, near={}, far={})",
            c.eye(),
            c.forward(),
            c.fov_y(),
            c.aspect(),
            c.near(),
            c.far()
        )
    }
}
