//! `_core.Camera`.

use std::f64::consts::FRAC_PI_3;

use glam::DVec2;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments::{array, number, number_or};
use super::camera_changes::{aimed, replaced};
use super::camera_matrices::from_matrices;
use super::convert::{image, in_parts, instance_of, mat4_to_array, rows3, size2, vec3_to_array};
use super::exceptions::argument_error;
use super::scene::PyScene;
use super::state::{Fault, Reader, Reduced, State, Writer, by_state, reduce};
use crate::error::Error;
use crate::scene::{Camera, Lens, ViewVolume};

/// A camera (right-handed, looking along -z of its view space, NDC z in [0, 1]): a perspective one, by `look_at`, whose rays run
/// from `eye`, or an orthographic one, by `orthographic`, whose rays run along `forward`.
#[pyclass(name = "Camera", frozen, eq, hash, module = "shadowlab")]
#[derive(Clone)]
pub struct PyCamera {
    pub camera: Camera,
}

by_state!(PyCamera);

/// In place of a field of view, of which there is none: a shift follows, or height and shift of a box.
const SHIFTED: f64 = -1.0;
const ORTHOGRAPHIC: f64 = -2.0;

impl State for PyCamera {
    const NAME: &'static str = "Camera";
    const VERSION: u32 = 2;
    fn version(&self) -> u32 {
        let volume = self.camera.volume();
        let first = !volume.is_orthographic() && volume.shift == DVec2::ZERO && volume.far.is_finite();
        if first { 1 } else { 2 }
    }
    fn write(&self, to: &mut Writer) {
        let c = &self.camera;
        [c.eye(), c.right(), c.up(), c.forward()].into_iter().for_each(|v| to.vector(v));
        let ViewVolume { lens, aspect, shift, near, far } = c.volume();
        match lens {
            Lens::Perspective { fov_y } if shift == DVec2::ZERO => to.numbers(&[fov_y]),
            Lens::Perspective { fov_y } => to.numbers(&[SHIFTED, shift.x, shift.y, fov_y]),
            Lens::Orthographic { height } => to.numbers(&[ORTHOGRAPHIC, shift.x, shift.y, height]),
        }
        to.numbers(&[aspect, near, far]);
    }
    fn read(from: &mut Reader<'_>) -> Result<Self, Fault> {
        let (eye, axes) = (from.vector()?, [from.vector()?, from.vector()?, from.vector()?]);
        let [first] = from.numbers()?;
        let (lens, shift) = if first == SHIFTED || first == ORTHOGRAPHIC {
            let [x, y, size] = from.numbers()?;
            let is_box = first == ORTHOGRAPHIC;
            let lens = if is_box { Lens::Orthographic { height: size } } else { Lens::Perspective { fov_y: size } };
            (lens, DVec2::new(x, y))
        } else {
            (Lens::Perspective { fov_y: first }, DVec2::ZERO)
        };
        let [aspect, near, far] = from.numbers()?;
        let volume = ViewVolume { lens, aspect, shift, near, far };
        let camera = Camera::from_axes(eye, axes, volume).map_err(|e| e.to_string())?;
        Ok(Self { camera })
    }
}

/// A camera argument.
pub fn camera<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyCamera>> {
    instance_of(value, "camera", "make one with Camera.look_at or Camera.orthographic")
}

#[pymethods]
impl PyCamera {
    /// A perspective camera at `eye` that looks at `target`.
    ///
    /// Parameters
    /// ----------
    /// eye, target : (3,) array_like
    ///     Positions, world units.
    /// up : (3,) array_like, optional
    ///     Any vector not parallel to the view. +y where none is given; for a view along the y axis then what +y becomes as a
    ///     camera tilts that way: -z of one that looks straight down, +z of one that looks straight up.
    /// fov_y : float
    ///     Full vertical field of view, radians, in (0, pi).
    /// aspect : float
    ///     Width by height.
    /// near, far : float
    ///     Depths along the view direction, 0 < near < far, world units. `far` may be infinite: depth buffers then hold
    ///     `1 - near / z`, and maps are made for all that there is in the scene.
    /// shift : (2,) array_like
    ///     How far the middle of the picture lies to the right of the view axis and above it, in half widths and half heights
    ///     of the picture (an off-centre frustum, a shifted lens): (0, 1) has straight ahead at the lower edge. At most 1e6.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For anything not finite or outside its range, and for a given `up` parallel to the view.
    ///
    /// Warns
    /// -----
    /// ShadowlabWarning
    ///     Where no `up` is given and +y will not do.
    #[staticmethod]
    #[pyo3(signature = (eye, target, *, up=None, fov_y=None, aspect=None, near=None, far=None, shift=None),
        text_signature = "(eye, target, *, up=None, fov_y=..., aspect=..., near=0.1, far=1000.0, shift=None)")]
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
        shift: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let (fov_y, aspect) = (number_or(fov_y, "fov_y", FRAC_PI_3)?, number_or(aspect, "aspect", 16.0 / 9.0)?);
        let (near, far) = (number_or(near, "near", 0.1)?, number_or(far, "far", 1000.0)?);
        let volume = ViewVolume::perspective(fov_y, aspect, near, far);
        Ok(Self { camera: aimed(py, [eye, target], up, volume, shift)? })
    }
    /// An orthographic camera that looks from `eye` towards `target`: all of its rays run that way.
    ///
    /// Parameters
    /// ----------
    /// eye, target : (3,) array_like
    ///     Positions, world units. Depths begin at `eye`, which is in the middle of the picture.
    /// up : (3,) array_like, optional
    ///     As for `look_at`.
    /// height : float
    ///     Full height of the view volume, world units, above 0.
    /// aspect : float
    ///     Width by height.
    /// near, far : float
    ///     Depths along the view direction, near < far, world units, both finite. A view volume that begins behind `eye` has a
    ///     negative `near`.
    /// shift : (2,) array_like
    ///     As for `look_at`.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For anything not finite or outside its range, and for a given `up` parallel to the view.
    ///
    /// Warns
    /// -----
    /// ShadowlabWarning
    ///     Where no `up` is given and +y will not do.
    ///
    /// Examples
    /// --------
    /// >>> import shadowlab as sl
    /// >>> plan = sl.Camera.orthographic((0, 20, 0), (0, 0, 0), (0, 0, -1), height=30, near=0, far=40)
    /// >>> plan.is_orthographic, plan.height, plan.fov_y
    /// (True, 30.0, 0.0)
    #[staticmethod]
    #[pyo3(signature = (eye, target, up=None, *, height, aspect=None, near=None, far=None, shift=None),
        text_signature = "(eye, target, up=None, *, height, aspect=..., near=0.1, far=1000.0, shift=None)")]
    #[allow(clippy::too_many_arguments)]
    fn orthographic(
        py: Python<'_>,
        eye: &Bound<'_, PyAny>,
        target: &Bound<'_, PyAny>,
        up: Option<&Bound<'_, PyAny>>,
        height: &Bound<'_, PyAny>,
        aspect: Option<&Bound<'_, PyAny>>,
        near: Option<&Bound<'_, PyAny>>,
        far: Option<&Bound<'_, PyAny>>,
        shift: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let height = number(height, "height", "give a number")?;
        let aspect = number_or(aspect, "aspect", 16.0 / 9.0)?;
        let (near, far) = (number_or(near, "near", 0.1)?, number_or(far, "far", 1000.0)?);
        let volume = ViewVolume::orthographic(height, aspect, near, far);
        Ok(Self { camera: aimed(py, [eye, target], up, volume, shift)? })
    }
    /// (3,) float64: position, world units. Rays of an orthographic camera do not run through it: depths begin there.
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
    /// Whether all rays of the camera are parallel.
    #[getter]
    fn is_orthographic(&self) -> bool {
        self.camera.is_orthographic()
    }
    /// Full vertical field of view, radians; 0 of an orthographic camera, whose rays are parallel. A shift does not change it.
    #[getter]
    fn fov_y(&self) -> f64 {
        self.camera.fov_y()
    }
    /// Full height of the view volume, world units: of an orthographic camera at every depth, of a perspective one at depth 1,
    /// 2 tan(fov_y / 2).
    #[getter]
    fn height(&self) -> f64 {
        self.camera.volume().height()
    }
    /// How far the middle of the picture lies to the right of the view axis and above it, in half widths and half heights.
    #[getter]
    fn shift(&self) -> (f64, f64) {
        let shift = self.camera.volume().shift;
        (shift.x, shift.y)
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
    /// Depth of the far plane along the view direction, world units; infinity of a perspective camera without an end.
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
        let rows = rows3(&points)?;
        let mut depths = Vec::with_capacity(rows.len());
        in_parts(py, rows.len(), |part| {
            depths.extend(rows[part].iter().map(|&p| self.camera.depth_of(p.into())));
            Ok(())
        })?;
        image(py, depths, [rows.len()])
    }
    /// The corners of the picture at a depth, world.
    ///
    /// Parameters
    /// ----------
    /// depth : float
    ///     Along the view direction, world units; finite.
    ///
    /// Returns
    /// -------
    /// (4, 3) ndarray of float64
    ///     Left and right at the bottom, then left and right at the top.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For a depth that is not a finite number.
    fn corners<'py>(&self, depth: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let (py, fix) = (depth.py(), "give a depth between near and far, world units");
        let found = number(depth, "depth", fix)?;
        if !found.is_finite() {
            return Err(argument_error(py, "depth", "a finite number", found.to_string(), fix));
        }
        let corners = self.camera.corners_at(found).map(|p| (self.camera.eye() + p).to_array());
        image(py, corners.as_flattened().to_vec(), [4, 3])
    }
    /// The rays of places in the picture.
    ///
    /// Parameters
    /// ----------
    /// pixels : (N, 2) array_like
    ///     x to the right and y down, pixels from the picture's upper left corner: the first pixel's centre is (0.5, 0.5).
    /// size : (int, int)
    ///     Width and height of the picture, pixels.
    ///
    /// Returns
    /// -------
    /// origins, directions : (N, 3) ndarray of float64
    ///     World units. `origins + z * directions` has camera depth z: directions are not normalised.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For arrays of another shape, numbers that are not finite, or a side that is not above 0.
    ///
    /// Examples
    /// --------
    /// >>> import shadowlab as sl
    /// >>> camera = sl.Camera.orthographic((0, 0, 9), (0, 0, 0), height=2, aspect=1)
    /// >>> origins, directions = camera.rays([(0, 0), (2, 2)], (2, 2))
    /// >>> origins.tolist(), directions.tolist()
    /// ([[-1.0, 1.0, 9.0], [1.0, -1.0, 9.0]], [[0.0, 0.0, -1.0], [0.0, 0.0, -1.0]])
    #[allow(clippy::type_complexity)]
    fn rays<'py>(
        &self,
        pixels: &Bound<'py, PyAny>,
        size: &Bound<'py, PyAny>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
        let (py, [width, height]) = (pixels.py(), size2(size, "size")?);
        let pixels = array::<f64>(pixels, "pixels", &[None, Some(2)])?;
        let places = pixels.as_slice()?.as_chunks::<2>().0;
        let ray = self.camera.pixel_rays([width, height]);
        let room = 3 * places.len();
        let (mut origins, mut directions) = (Vec::with_capacity(room), Vec::with_capacity(room));
        in_parts(py, places.len(), |part| {
            for &[x, y] in &places[part] {
                if !(x.is_finite() && y.is_finite()) {
                    let (got, fix) = (format!("({x}, {y})"), "check where it comes from");
                    return Err(Error::argument("pixels", "finite numbers", got, fix));
                }
                let found = ray(x, y);
                origins.extend((self.camera.eye() + found.from_eye).to_array());
                directions.extend(found.direction.to_array());
            }
            Ok(())
        })?;
        let n = origins.len() / 3;
        Ok((image(py, origins, [n, 3])?, image(py, directions, [n, 3])?))
    }
    /// The same camera with a finite far plane: its own, or in place of an infinite one a plane just behind all of a scene.
    ///
    /// Parameters
    /// ----------
    /// scene : Scene
    ///     What it sees.
    ///
    /// Returns
    /// -------
    /// Camera
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np
    /// >>> import shadowlab as sl
    /// >>> scene = sl.library.robots()
    /// >>> camera = scene.camera.replace(far=np.inf)
    /// >>> bool(np.isfinite(camera.bounded(scene.scene).far)), scene.camera.bounded(scene.scene) == scene.camera
    /// (True, True)
    fn bounded(&self, #[pyo3(from_py_with = super::scene::scene)] scene: Bound<'_, PyScene>) -> Self {
        Self { camera: self.camera.bounded(scene.get().scene.bounds()) }
    }
    /// The camera of a view and a projection matrix, such as an engine has.
    ///
    /// Parameters
    /// ----------
    /// view : (4, 4) array_like
    ///     View from world: a rotation and a translation. Either handedness of view space will do.
    /// projection : (4, 4) array_like
    ///     Clip from view: perspective, of a shifted lens or not, with a far plane or without, or orthographic.
    /// convention : Convention or str, optional
    ///     How both are written, as for `Parameterization.from_matrix`: "opengl", "direct3d", "vulkan", "reversed_z",
    ///     "webgpu:vectors=row"... Its axes are those of the world that `view` starts from. As ours where none is given.
    /// far : float, optional
    ///     Far plane, world units, for a projection that has none, whose far plane is at infinity otherwise.
    ///
    /// Returns
    /// -------
    /// Camera
    ///     Exact up to the rounding of what the matrices hold; `far` up to that times far / near, since it cancels there.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For numbers that are not finite; a view that scales, shears or is no rotation; a sheared or singular projection, or one
    ///     with an oblique near plane; a `far` for a projection that has a far plane; matrices that mirror the world, or have
    ///     depths in another order than the convention.
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
    ///     Any vector not parallel to the view; the camera's own `up` where it is turned and none is given, or what that becomes
    ///     as the camera tilts where it is turned along it.
    /// fov_y, height : float
    ///     As for `look_at` and `orthographic`: a perspective camera has a field of view, an orthographic one a height.
    /// aspect, near, far : float
    ///     As for `look_at`.
    /// shift : (2,) array_like
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
    ///     As for `look_at`, for both `target` and `forward`, and for `fov_y` or `height` of the other kind of camera.
    ///
    /// Warns
    /// -----
    /// ShadowlabWarning
    ///     Where the camera is turned along its own `up`, and none is given.
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
        Ok(Self { camera: replaced(py, &self.camera, changes)? })
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
        let ViewVolume { lens, aspect, shift, near, far } = c.volume();
        let lens = match lens {
            Lens::Perspective { fov_y } => format!("fov_y={fov_y:.6}"),
            Lens::Orthographic { height } => format!("height={height:.6}"),
        };
        let shift = if shift == DVec2::ZERO { String::new() } else { format!(", shift=({}, {})", shift.x, shift.y) };
        let (eye, forward) = (c.eye(), c.forward());
        format!("Camera(eye={eye}, forward={forward}, {lens}, aspect={aspect:.6}, near={near}, far={far}{shift})")
    }
}
