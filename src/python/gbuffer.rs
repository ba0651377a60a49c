//! `_core.GBuffer`.

use glam::Vec3;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use super::arguments::whole;
use super::arrays::{equal_lists, stored};
use super::camera::PyCamera;
use super::convert::{OrRaise, SOON, image, in_parts, instance_of, run_sized, vec3_to_array};
use super::state::{Parts, Reduced, State, Writer, first_eight, reduced, seal, state_error};
use crate::digest::{Digest, Numbers};
use crate::image::{GBuffer, Surfaces};
use crate::memory::check_images;
use crate::render::MAX_IMAGE_SIDE;
use crate::scene::Camera;

/// What a camera sees, one record a pixel.
#[pyclass(name = "GBuffer", frozen, module = "shadowlab")]
pub struct PyGBuffer {
    size: [u32; 2],
    /// Of the picture that it is a part of, or all of.
    whole: [u32; 2],
    origin: glam::DVec3,
    /// That drew it; states of the first version have none.
    camera: Option<Camera>,
    depth: Py<PyArray2<f32>>,
    relative: Py<PyArray3<f32>>,
    position: PyOnceLock<Py<PyAny>>,
    normal: Py<PyArray3<f32>>,
    triangle: Py<PyArray2<i32>>,
    instance: Py<PyArray2<i32>>,
}

/// Bytes of a sample while samples are made: its point, normal and state, and what finds those at edges.
const SAMPLE_BYTES: usize = 64;

/// Its state.
const NAME: &str = "GBuffer";
const VERSION: u32 = 3;
/// Those without a whole picture that they are a part of; the first without a camera, too.
const WHOLE_VERSIONS: [u32; 2] = [1, 2];

/// A G-buffer argument.
pub fn gbuffer<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyGBuffer>> {
    instance_of(value, "gbuffer", "sl.Renderer().gbuffer(scene, camera, size=(640, 360)) makes one")
}

/// The records of a rectangle (x, y, width, height) of a picture with rows of a width.
fn rectangle<T: Copy>(of: &[T], row_width: usize, [x, y, width, height]: [usize; 4]) -> Vec<T> {
    let row = |y: usize| of[y * row_width + x..][..width].iter().copied();
    (y..y + height).flat_map(row).collect()
}

impl PyGBuffer {
    /// Width and height, pixels.
    pub fn picture(&self) -> [u32; 2] {
        self.size
    }
    /// Width and height of the picture that it is a part of, or all of, pixels.
    pub fn whole_picture(&self) -> [u32; 2] {
        self.whole
    }
    /// An error unless there is memory for as many samples as it has pixels.
    pub fn check_samples(&self, py: Python<'_>) -> PyResult<()> {
        check_images("gbuffer", 1, self.size, SAMPLE_BYTES).or_raise(py)
    }
    /// Calls `work` with where its surfaces are.
    pub fn with_surfaces<T>(&self, py: Python<'_>, work: impl FnOnce(&Surfaces) -> PyResult<T>) -> PyResult<T> {
        let (position, normal) = (self.relative.bind(py).readonly(), self.normal.bind(py).readonly());
        let (triangle, instance) = (self.triangle.bind(py).readonly(), self.instance.bind(py).readonly());
        work(&Surfaces {
            size: self.size,
            origin: self.origin,
            position: position.as_slice()?.as_chunks::<3>().0,
            normal: normal.as_slice()?.as_chunks::<3>().0,
            triangle: triangle.as_slice()?,
            instance: instance.as_slice()?,
        })
    }

    /// One of the same camera and picture with the records that `work` makes of its surfaces, their depths and that camera.
    pub fn remade(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&Surfaces, &[f32], &Camera) -> PyResult<GBuffer>,
    ) -> PyResult<Self> {
        let camera = self.camera.ok_or_else(|| state_error(py, NAME, "it has no camera"))?;
        let depth = self.depth.bind(py).readonly();
        let made = self.with_surfaces(py, |surfaces| work(surfaces, depth.as_slice()?, &camera))?;
        Ok(Self { whole: self.whole, ..Self::new(py, made, camera)? })
    }

    /// The scalars of its state.
    fn head(&self, numbers: Numbers) -> Writer {
        let mut head = Writer::new(numbers);
        self.size.iter().for_each(|&n| head.count(u64::from(n)));
        head.vector(self.origin);
        if self.whole != self.size {
            self.whole.iter().for_each(|&n| head.count(u64::from(n)));
            head.kind(u8::from(self.camera.is_some()));
        }
        if let Some(camera) = self.camera {
            PyCamera { camera }.write(&mut head);
        }
        head
    }

    /// Adds its arrays to a digest.
    fn add_arrays(&self, py: Python<'_>, digest: &mut Digest) -> PyResult<()> {
        let depth = self.depth.bind(py).readonly();
        let depth = depth.as_slice()?;
        self.with_surfaces(py, |s| {
            run_sized(py, depth.len() > SOON, |progress| {
                let check = || progress.check();
                digest.watched_list(depth, check)?;
                digest.watched_list(s.position.as_flattened(), check)?;
                digest.watched_list(s.normal.as_flattened(), check)?;
                digest.watched_list(s.triangle, check)?;
                digest.watched_list(s.instance, check)
            })
        })
    }

    /// The one of a state; it keeps the arrays that came.
    pub fn restored<'py>(py: Python<'py>, parts: &Parts<'py>) -> PyResult<Self> {
        parts.check(py, VERSION, 5)?;
        let version = parts.version;
        let (size, whole, origin, camera) = parts.read(py, |from| {
            let (size, origin) = ([from.count()?, from.count()?], from.vector()?);
            let (whole, has_camera) = if WHOLE_VERSIONS.contains(&version) {
                (size, version > 1)
            } else {
                ([from.count()?, from.count()?], from.kind()? != 0)
            };
            let camera =
                if has_camera { Some(PyCamera::read(from).map_err(|_| "its camera is damaged")?.camera) } else { None };
            Ok((size, whole, origin, camera))
        })?;
        let fits = |n: u32, whole: u32| (1..=whole).contains(&n) && whole <= MAX_IMAGE_SIDE;
        if !(fits(size[0], whole[0]) && fits(size[1], whole[1]) && origin.is_finite()) {
            return Err(parts.error(py, format!("it has {size:?} of {whole:?} pixels around {origin}")));
        }
        let [w, h] = size.map(|n: u32| Some(n as usize));
        let vectors = |i| stored::<f32>(py, parts, i, &[h, w, Some(3)]);
        let indices = |i| stored::<i32>(py, parts, i, &[h, w]);
        let found = Self {
            size,
            whole,
            origin,
            camera,
            depth: stored::<f32>(py, parts, 0, &[h, w])?.into_any().cast_into::<PyArray2<f32>>()?.unbind(),
            relative: vectors(1)?.into_any().cast_into::<PyArray3<f32>>()?.unbind(),
            position: PyOnceLock::new(),
            normal: vectors(2)?.into_any().cast_into::<PyArray3<f32>>()?.unbind(),
            triangle: indices(3)?.into_any().cast_into::<PyArray2<i32>>()?.unbind(),
            instance: indices(4)?.into_any().cast_into::<PyArray2<i32>>()?.unbind(),
        };
        parts.check_seal(py, |digest| found.add_arrays(py, digest))?;
        Ok(found)
    }

    /// One that takes over the core's arrays.
    pub fn new(py: Python<'_>, g: GBuffer, camera: Camera) -> PyResult<Self> {
        let [w, h] = g.size.map(|n| n as usize);
        Ok(Self {
            size: g.size,
            whole: g.size,
            origin: g.origin,
            camera: Some(camera),
            depth: image(py, g.depth, [h, w])?.unbind(),
            relative: image(py, g.position.into_flattened(), [h, w, 3])?.unbind(),
            position: PyOnceLock::new(),
            normal: image(py, g.normal.into_flattened(), [h, w, 3])?.unbind(),
            triangle: image(py, g.triangle, [h, w])?.unbind(),
            instance: image(py, g.instance, [h, w])?.unbind(),
        })
    }
}

#[pymethods]
impl PyGBuffer {
    /// (width, height) in pixels.
    #[getter]
    fn size(&self) -> (u32, u32) {
        self.size.into()
    }
    /// (H, W) float32: NDC depth in [0, 1], 1 where nothing is.
    #[getter]
    fn depth(&self, py: Python<'_>) -> Py<PyArray2<f32>> {
        self.depth.clone_ref(py)
    }
    /// (H, W) float32: distances along the view, world units; infinite where nothing is.
    ///
    /// Raises
    /// ------
    /// StateError
    ///     For a G-buffer that version 0.1 pickled before it stored its camera.
    #[getter]
    fn view_depth<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let camera = self.camera.ok_or_else(|| state_error(py, NAME, "it has no camera"))?;
        let [w, h] = self.size.map(|n| n as usize);
        let depths = self.with_surfaces(py, |s| {
            let depth = |i: usize| s.receiver(i).map_or(f64::INFINITY, |(p, _)| camera.depth_of(s.origin + p)) as f32;
            let mut depths = Vec::with_capacity(w * h);
            in_parts(py, w * h, |part| {
                depths.extend(part.map(depth));
                Ok(())
            })?;
            Ok(depths)
        })?;
        image(py, depths, [h, w])
    }
    /// (H, W, 3) float64: world positions; the origin where nothing is. Computed at the first look.
    #[getter]
    fn position(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let found = match self.position.get(py) {
            Some(found) => found,
            None => {
                // Not within the cell: other threads run meanwhile, and a fork then would leave the cell locked in the child.
                let sum = self.with_surfaces(py, |s| {
                    let mut sum = Vec::with_capacity(3 * s.position.len());
                    in_parts(py, s.position.len(), |part| {
                        let world = |p: &[f32; 3]| (s.origin + Vec3::from_array(*p).as_dvec3()).to_array();
                        sum.extend(s.position[part].iter().flat_map(world));
                        Ok(())
                    })?;
                    Ok(sum)
                })?;
                let [w, h] = self.size.map(|n| n as usize);
                let sum = image(py, sum, [h, w, 3])?.into_any().unbind();
                self.position.get_or_init(py, || sum)
            }
        };
        Ok(found.clone_ref(py))
    }
    /// (H, W, 3) float32: world positions minus `origin`.
    #[getter]
    fn position_relative(&self, py: Python<'_>) -> Py<PyArray3<f32>> {
        self.relative.clone_ref(py)
    }
    /// (3,) float64: the world point positions are stored relative to.
    #[getter]
    fn origin<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vec3_to_array(py, self.origin)
    }
    /// (H, W, 3) float32: unit geometric normals on the side of the eye; zero where nothing is.
    #[getter]
    fn normal(&self, py: Python<'_>) -> Py<PyArray3<f32>> {
        self.normal.clone_ref(py)
    }
    /// (H, W) int32: row of the face array the mesh was made from; -1 where nothing is.
    #[getter]
    fn triangle(&self, py: Python<'_>) -> Py<PyArray2<i32>> {
        self.triangle.clone_ref(py)
    }
    /// (H, W) int32: index of the instance; -1 where nothing is.
    #[getter]
    fn instance(&self, py: Python<'_>) -> Py<PyArray2<i32>> {
        self.instance.clone_ref(py)
    }
    /// A rectangle of the picture: the same records, bit for bit, relative to the same origin.
    ///
    /// Parameters
    /// ----------
    /// x, y : int
    ///     Column and row of its upper left pixel.
    /// width, height : int
    ///     Pixels.
    ///
    /// Returns
    /// -------
    /// GBuffer
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For a rectangle without pixels, or one that leaves the picture.
    ///
    /// Examples
    /// --------
    /// >>> import shadowlab as sl
    /// >>> scene = sl.library.scene("robots")
    /// >>> g = sl.Renderer("cpu").gbuffer(scene, scene.camera, size=(16, 9))
    /// >>> part = g.crop(3, 4, 5, 2)
    /// >>> part.size, bool((part.depth == g.depth[4:6, 3:8]).all())
    /// ((5, 2), True)
    fn crop<'py>(
        &self,
        py: Python<'py>,
        x: &Bound<'py, PyAny>,
        y: &Bound<'py, PyAny>,
        width: &Bound<'py, PyAny>,
        height: &Bound<'py, PyAny>,
    ) -> PyResult<Self> {
        let fix = "choose a rectangle within the picture";
        let sides = self.size.map(i64::from);
        let part = |at: &Bound<'py, PyAny>, length: &Bound<'py, PyAny>, names: [&str; 2], side: i64| {
            let at = whole(at, names[0], [0, side - 1], fix)?;
            let length = whole(length, names[1], [1, side - at], fix)?;
            Ok::<_, PyErr>((at as usize, length as usize))
        };
        let (x, w) = part(x, width, ["x", "width"], sides[0])?;
        let (y, h) = part(y, height, ["y", "height"], sides[1])?;
        let (all, of) = (self.size[0] as usize, [x, y, w, h]);
        let depth = self.depth.bind(py).readonly();
        let depth = rectangle(depth.as_slice()?, all, of);
        self.with_surfaces(py, |s| {
            Ok(Self {
                size: [w as u32, h as u32],
                whole: self.whole,
                origin: self.origin,
                camera: self.camera,
                depth: image(py, depth, [h, w])?.unbind(),
                relative: image(py, rectangle(s.position, all, of).into_flattened(), [h, w, 3])?.unbind(),
                position: PyOnceLock::new(),
                normal: image(py, rectangle(s.normal, all, of).into_flattened(), [h, w, 3])?.unbind(),
                triangle: image(py, rectangle(s.triangle, all, of), [h, w])?.unbind(),
                instance: image(py, rectangle(s.instance, all, of), [h, w])?.unbind(),
            })
        })
    }
    // Not by what `==` makes of both: the other side may answer with anything.
    fn __ne__(&self, py: Python<'_>, other: PyRef<'_, Self>) -> PyResult<bool> {
        Ok(!self.__eq__(py, other)?)
    }
    fn __eq__(&self, py: Python<'_>, other: PyRef<'_, Self>) -> PyResult<bool> {
        if std::ptr::eq(self, &*other) {
            return Ok(true);
        }
        if self.head(Numbers::Equal).bytes() != other.head(Numbers::Equal).bytes() {
            return Ok(false);
        }
        let (a, b) = (self.depth.bind(py).readonly(), other.depth.bind(py).readonly());
        let same_depth = equal_lists(a.as_slice()?, b.as_slice()?);
        let same = self.with_surfaces(py, |a| {
            other.with_surfaces(py, |b| {
                Ok(equal_lists(a.position.as_flattened(), b.position.as_flattened())
                    && equal_lists(a.normal.as_flattened(), b.normal.as_flattened())
                    && equal_lists(a.triangle, b.triangle)
                    && equal_lists(a.instance, b.instance))
            })
        })?;
        Ok(same_depth && same)
    }
    fn __hash__(&self, py: Python<'_>) -> PyResult<u64> {
        let mut digest = Digest::new("GBuffer", Numbers::Equal);
        digest.list(self.head(Numbers::Equal).bytes());
        self.add_arrays(py, &mut digest)?;
        Ok(first_eight(&digest.finish()))
    }
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        let head = self.head(Numbers::Exact);
        // One that is a whole picture stays of the version that knows no other, and without a camera of the one that has none.
        let version = match (self.whole == self.size, &self.camera) {
            (false, _) => VERSION,
            (true, Some(_)) => WHOLE_VERSIONS[1],
            (true, None) => WHOLE_VERSIONS[0],
        };
        let seal = seal(NAME, version, head.bytes(), |digest| self.add_arrays(py, digest))?;
        let arrays = vec![
            self.depth.bind(py).clone().into_any(),
            self.relative.bind(py).clone().into_any(),
            self.normal.bind(py).clone().into_any(),
            self.triangle.bind(py).clone().into_any(),
            self.instance.bind(py).clone().into_any(),
        ];
        reduced(py, NAME, version, head.bytes(), &seal, arrays)
    }
    fn __repr__(&self) -> String {
        format!("GBuffer({} x {} pixels)", self.size[0], self.size[1])
    }
}
