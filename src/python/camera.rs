//! `_core.Camera`.

use std::f64::consts::FRAC_PI_3;

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments::{number_or, word};
use super::camera_matrices::from_matrices;
use super::convert::{
    OrRaise, argument_error, array, image, instance_of, mat4_to_array, number, rows3, to_exception, vec3, vec3_to_array,
};
use super::state::{Fault, Reader, Reduced, State, Writer, by_state, reduce};
use crate::error::Error;
use crate::scene::Camera;

/// A perspective camera (right-handed, looking along -z of its view space, NDC z in [0, 1]).
#[pyclass(name = "Camera", frozen, eq, hash, module = "shadowlab")]
#[derive(Clone)]
pub struct PyCamera {
    pub camera: Camera,
}

by_state!(PyCamera);

impl State for PyCamera {
    const NAME: &'static str = "Camera";
    fn write(&self, to: &mut Writer) {
        let c = &self.camera;
        [c.eye(), c.right(), c.up(), c.forward()].into_iter().for_each(|v| to.vector(v));
        to.numbers(&[c.fov_y(), c.aspect(), c.near(), c.far()]);
    }
    fn read(from: &mut Reader<'_>) -> Result<Self, Fault> {
        let (eye, axes) = (from.vector()?, [from.vector()?, from.vector()?, from.vector()?]);
        let [fov_y, aspect, near, far] = from.numbers()?;
        let camera = Camera::from_axes(eye, axes, fov_y, aspect, near, far).map_err(|e| e.to_string())?;
        Ok(Self { camera })
    }
}

/// What [`PyCamera::replace`] takes.
const CHANGES: [&str; 8] = ["eye", "target", "forward", "up", "fov_y", "aspect", "near", "far"];

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
    #[pyo3(signature = (eye, target, *, up=None, fov_y=None, aspect=None, near=None, far=None),
        text_signature = "(eye, target, *, up=None, fov_y=..., aspect=..., near=0.1, far=1000.0)")]
    #[allow(clippy::too_many_arguments)]
    fn look_at(
        py: Python<'_>,
        eye: &Bound<'_, PyAny>,
        target: &Bound<'_, PyAny>,
        up: Option<&Bound<'_, PyAny>>,
        fov_y: Option<&Bound<'_, PyAny>>,
        aspect: Option<&Bound<'_, PyAny>>,
        near: Option<&Bound<'_, PyAny>>,
        far: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let up = up.map_or(Ok(glam::DVec3::Y), |up| vec3(up, "up"))?;
        let (fov_y, aspect) = (number_or(fov_y, "fov_y", FRAC_PI_3)?, number_or(aspect, "aspect", 16.0 / 9.0)?);
        let (near, far) = (number_or(near, "near", 0.1)?, number_or(far, "far", 1000.0)?);
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
    /// The camera of a view and a projection matrix, such as an engine has.
    ///
    /// Parameters
    /// ----------
    /// view : (4, 4) array_like
    ///     View from world: a rotation and a translation. Either handedness of view space will do.
    /// projection : (4, 4) array_like
    ///     Clip from view, perspective, with the eye before the middle of the picture.
    /// convention : Convention or str, optional
    ///     How both are written, as for `Parameterization.from_matrix`: "opengl", "direct3d", "vulkan", "reversed_z",
    ///     "webgpu:vectors=row"... Its axes are those of the world that `view` starts from. As ours where none is given.
    /// far : float, optional
    ///     Far plane, world units, for a projection that has none: those without an end are supported with it alone.
    ///
    /// Returns
    /// -------
    /// Camera
    ///     Exact up to the rounding of what the matrices hold; `far` up to that times far / near, since it cancels there.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For numbers that are not finite; a view that scales, shears or is no rotation; an orthographic, off-centre,
    ///     sheared or singular projection; one without a far plane where no `far` is given, or with one where it is;
    ///     matrices that mirror the world, or have depths in another order than the convention.
    /// UnknownNameError
    ///     For a convention that does not exist.
    ///
    /// Examples
    /// --------
    /// >>> import shadowlab as sl
    /// >>> camera = sl.Camera.look_at((0, 2, 9), (0, 0, 0), near=1, far=100)
    /// >>> back = sl.Camera.from_matrices(camera.view, camera.projection)
    /// >>> round(back.far, 9)
    /// 100.0
    #[staticmethod]
    #[pyo3(name = "from_matrices", signature = (view, projection, convention=None, *, far=None))]
    fn of_matrices(
        view: &Bound<'_, PyAny>,
        projection: &Bound<'_, PyAny>,
        convention: Option<&Bound<'_, PyAny>>,
        far: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        Ok(Self { camera: from_matrices(view, projection, convention, far)? })
    }
    /// The same camera with other settings; what is not named stays as it is, bit for bit.
    ///
    /// Parameters
    /// ----------
    /// eye : (3,) array_like
    ///     Moves the camera; it looks the same way unless `target` or `forward` is given.
    /// target : (3,) array_like
    ///     Turns it to this point.
    /// forward : (3,) array_like
    ///     Turns it along this vector, of any length above 0; instead of `target`.
    /// up : (3,) array_like
    ///     Any vector not parallel to the view; the camera's own `up` where it is turned and none is given.
    /// fov_y, aspect, near, far : float
    ///     As for `look_at`.
    ///
    /// Returns
    /// -------
    /// Camera
    ///
    /// Raises
    /// ------
    /// UnknownNameError
    ///     For another name; the message lists the valid ones.
    /// ArgumentError
    ///     As for `look_at`, and for both `target` and `forward`.
    ///
    /// Examples
    /// --------
    /// >>> import shadowlab as sl
    /// >>> camera = sl.Camera.look_at((0, 2, 9), (0, 0, 0), near=1, far=100)
    /// >>> camera.replace(near=2.0).near, camera.replace(far=100.0) == camera
    /// (2.0, True)
    #[pyo3(signature = (**changes))]
    fn replace(&self, py: Python<'_>, changes: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let Some(changes) = changes else { return Ok(self.clone()) };
        for key in changes.keys() {
            let name = word(&key, "changes", "names of settings")?;
            if !CHANGES.contains(&name.as_str()) {
                let valid = CHANGES.map(String::from).into();
                return Err(to_exception(py, Error::UnknownName { kind: "setting of a camera".into(), name, valid }));
            }
        }
        let vector = |name: &str| changes.get_item(name)?.map(|v| vec3(&v, name)).transpose();
        let c = &self.camera;
        let scalar = |name: &str, own: f64| match changes.get_item(name)? {
            Some(value) => number(&value, name, "give a number"),
            None => Ok(own),
        };
        let (fov_y, aspect) = (scalar("fov_y", c.fov_y())?, scalar("aspect", c.aspect())?);
        let (near, far) = (scalar("near", c.near())?, scalar("far", c.far())?);
        let eye = vector("eye")?.unwrap_or(c.eye());
        let up = vector("up")?;
        let camera = match (vector("target")?, vector("forward")?) {
            (Some(_), Some(_)) => {
                let (expected, fix) = ("one of target and forward", "leave one of them out");
                return Err(argument_error(py, "target", expected, "both", fix));
            }
            (Some(target), None) => Camera::look_at(eye, target, up.unwrap_or(c.up()), fov_y, aspect, near, far),
            (None, None) if up.is_none() => {
                Camera::from_axes(eye, [c.right(), c.up(), c.forward()], fov_y, aspect, near, far)
            }
            (None, forward) => {
                let forward = forward.unwrap_or(c.forward());
                Camera::look_along(eye, forward, up.unwrap_or(c.up()), fov_y, aspect, near, far)
            }
        };
        Ok(Self { camera: camera.or_raise(py)? })
    }
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduce(py, self)
    }
    /// The values as a table, for notebooks.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("shadowlab.reports.html.values")?.call_method1("camera_html", (slf,))
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
