//! `_core.GBuffer`, and the receiver samples that techniques take from one.

use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use super::convert::{image, instance_of, vec3_to_array};
use crate::focus::ReceiverSamples;
use crate::image::{GBuffer, Surfaces};
use crate::progress::Progress;
use crate::render::cpu::CpuRenderer;
use crate::render::{MAX_IMAGE_SIDE, Renderer};
use crate::scene::{Camera, Scene};

/// What a camera sees, one record a pixel.
#[pyclass(name = "GBuffer", frozen, module = "shadowlab")]
pub struct PyGBuffer {
    size: [u32; 2],
    origin: glam::DVec3,
    depth: Py<PyArray2<f32>>,
    relative: Py<PyArray3<f32>>,
    position: PyOnceLock<Py<PyAny>>,
    normal: Py<PyArray3<f32>>,
    triangle: Py<PyArray2<i32>>,
    instance: Py<PyArray2<i32>>,
    samples: PyOnceLock<ReceiverSamples>,
}

/// Pixels of the G-buffer that techniques look at where none is given: a share of the receivers is then known to 1 / 256 of
/// the view along each side, and drawing it takes no longer than a small shadow map.
const SAMPLE_PIXELS: f64 = 65536.0;

/// What a camera sees, drawn small by the CPU renderer, with square pixels.
pub fn receiver_samples(scene: &Scene, camera: &Camera, progress: &Progress) -> crate::Result<ReceiverSamples> {
    let root = camera.aspect().sqrt();
    let side = |pixels: f64| pixels.round().clamp(1.0, f64::from(MAX_IMAGE_SIDE)) as u32;
    let size = [side(SAMPLE_PIXELS.sqrt() * root), side(SAMPLE_PIXELS.sqrt() / root)];
    Ok(ReceiverSamples::from_gbuffer(&CpuRenderer::new().gbuffer(scene, camera, size, progress)?))
}

/// A G-buffer argument.
pub fn gbuffer<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyGBuffer>> {
    instance_of(value, "gbuffer", "sl.Renderer().gbuffer(scene, camera, size=(640, 360)) makes one")
}

/// A G-buffer to take samples from, or nothing.
pub fn samples<'py>(value: &Bound<'py, PyAny>) -> PyResult<Option<Bound<'py, PyGBuffer>>> {
    if value.is_none() {
        return Ok(None);
    }
    instance_of::<PyGBuffer>(value, "samples", "sl.Renderer().gbuffer(scene, camera, size=256) makes one").map(Some)
}

impl PyGBuffer {
    /// The surface points it shows; found at the first look.
    pub fn receiver_samples<'py>(&'py self, py: Python<'py>) -> PyResult<&'py ReceiverSamples> {
        self.samples.get_or_try_init(py, || {
            let vectors = |a: &Py<PyArray3<f32>>| -> PyResult<Vec<[f32; 3]>> {
                Ok(a.bind(py).readonly().as_slice()?.as_chunks::<3>().0.to_vec())
            };
            // Only what samples are made of.
            Ok(ReceiverSamples::from_gbuffer(&GBuffer {
                size: self.size,
                origin: self.origin,
                depth: Vec::new(),
                position: vectors(&self.relative)?,
                normal: vectors(&self.normal)?,
                triangle: self.triangle.bind(py).readonly().as_slice()?.to_vec(),
                instance: Vec::new(),
            }))
        })
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

    /// One that takes over the core's arrays.
    pub fn new(py: Python<'_>, g: GBuffer) -> PyResult<Self> {
        let [w, h] = g.size.map(|n| n as usize);
        Ok(Self {
            size: g.size,
            origin: g.origin,
            depth: image(py, g.depth, [h, w])?.unbind(),
            relative: image(py, g.position.into_flattened(), [h, w, 3])?.unbind(),
            position: PyOnceLock::new(),
            normal: image(py, g.normal.into_flattened(), [h, w, 3])?.unbind(),
            triangle: image(py, g.triangle, [h, w])?.unbind(),
            instance: image(py, g.instance, [h, w])?.unbind(),
            samples: PyOnceLock::new(),
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
    /// (H, W, 3) float64: world positions; the origin where nothing is. Computed at the first look.
    #[getter]
    fn position(&self, py: Python<'_>) -> PyResult<Py<PyAny>> {
        let found = match self.position.get(py) {
            Some(found) => found,
            None => {
                // Not within the cell: numpy lets other threads run, and a fork then would leave the cell locked in the child.
                let sum = self.relative.bind(py).as_any().add(self.origin(py))?.unbind();
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
    fn __repr__(&self) -> String {
        format!("GBuffer({} x {} pixels)", self.size[0], self.size[1])
    }
}
