//! `_core.Renderer`, `_core.GBuffer`, `_core.Bias`.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

use super::camera::{PyCamera, camera};
use super::convert::{OrRaise, argument_error, image, instance_of, run_watched, size2, to_exception, vec3_to_array};
use super::light::light;
use super::parameterization::PyParameterization;
use super::scene::{PyScene, scene};
use crate::error::Error;
use crate::focus::ReceiverSamples;
use crate::image::{GBuffer, ShadowMask};
use crate::progress::Progress;
use crate::render::cpu::CpuRenderer;
use crate::render::{Bias, Filter, MAX_IMAGE_SIDE, MaskSettings, Renderer};
use crate::scene::{Camera, Scene};

/// How much nearer to the light a receiver is moved before it is compared. The parts add up.
///
/// Parameters
/// ----------
/// world : float
///     World units along the light ray.
/// texels : float
///     World size of a shadow texel at the receiver, across the light ray.
/// ndc : float
///     NDC depth.
/// slope : float
///     Times the depth that the receiver's own plane gains over the filter's reach: 1 removes all acne of a plane.
/// slope_limit : float
///     Upper limit of the slope part, world sizes of a shadow texel along the light ray; infinity for none.
#[pyclass(name = "Bias", frozen, eq, module = "shadowlab")]
#[derive(PartialEq, Clone)]
pub struct PyBias {
    bias: Bias,
}

#[pymethods]
impl PyBias {
    #[new]
    #[pyo3(signature = (*, world=None, texels=None, ndc=None, slope=None, slope_limit=None))]
    fn new(
        py: Python<'_>,
        world: Option<f64>,
        texels: Option<f64>,
        ndc: Option<f64>,
        slope: Option<f64>,
        slope_limit: Option<f64>,
    ) -> PyResult<Self> {
        let d = Bias::default();
        let bias = Bias {
            world: world.unwrap_or(d.world),
            texels: texels.unwrap_or(d.texels),
            ndc: ndc.unwrap_or(d.ndc),
            slope: slope.unwrap_or(d.slope),
            slope_limit: slope_limit.unwrap_or(d.slope_limit),
        };
        Ok(Self { bias: bias.checked().or_raise(py)? })
    }
    /// No bias at all: acne everywhere.
    #[staticmethod]
    fn none() -> Self {
        Self { bias: Bias::NONE }
    }
    #[getter]
    fn world(&self) -> f64 {
        self.bias.world
    }
    #[getter]
    fn texels(&self) -> f64 {
        self.bias.texels
    }
    #[getter]
    fn ndc(&self) -> f64 {
        self.bias.ndc
    }
    #[getter]
    fn slope(&self) -> f64 {
        self.bias.slope
    }
    #[getter]
    fn slope_limit(&self) -> f64 {
        self.bias.slope_limit
    }
    fn __repr__(&self) -> String {
        let b = &self.bias;
        format!(
            "Bias(world={}, texels={}, ndc={}, slope={}, slope_limit={})",
            b.world, b.texels, b.ndc, b.slope, b.slope_limit
        )
    }
}

/// A bias argument, or nothing for the default.
fn bias(value: &Bound<'_, PyAny>) -> PyResult<Option<Bias>> {
    if value.is_none() {
        return Ok(None);
    }
    Ok(Some(instance_of::<PyBias>(value, "bias", "say in which unit, for example Bias(world=0.01)")?.get().bias))
}

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

    fn new(py: Python<'_>, g: GBuffer) -> PyResult<Self> {
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
        let add = || self.relative.bind(py).as_any().add(self.origin(py)).map(Bound::unbind);
        self.position.get_or_try_init(py, add).map(|p| p.clone_ref(py))
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

/// A renderer: "cpu" (always there), "gpu" (wgpu), or "auto" (a hardware adapter where there is one, else the CPU).
///
/// Parameters
/// ----------
/// backend : str
/// adapter : str, optional
///     Part of the name of the graphics adapter to use.
///
/// Raises
/// ------
/// DeviceError
///     No such adapter.
/// UnknownNameError
///     No such backend.
#[pyclass(name = "Renderer", frozen, module = "shadowlab")]
pub struct PyRenderer {
    renderer: Arc<dyn Renderer>,
}

#[pymethods]
impl PyRenderer {
    #[new]
    #[pyo3(signature = (backend="auto", *, adapter=None))]
    fn new(py: Python<'_>, backend: &str, adapter: Option<&str>) -> PyResult<Self> {
        let made = looking_at_drivers(py, || -> crate::Result<Arc<dyn Renderer>> {
            match backend {
                "cpu" => Ok(Arc::new(CpuRenderer::new())),
                "gpu" => gpu(adapter),
                "auto" if adapter.is_some() => gpu(adapter),
                "auto" if hardware_adapter() => gpu(None),
                "auto" => Ok(Arc::new(CpuRenderer::new())),
                other => Err(Error::UnknownName {
                    kind: "backend".into(),
                    name: other.into(),
                    valid: ["auto", "cpu", "gpu"].map(String::from).into(),
                }),
            }
        })?;
        Ok(Self { renderer: made.or_raise(py)? })
    }
    /// "cpu" or "gpu".
    #[getter]
    fn backend(&self) -> &'static str {
        self.renderer.backend()
    }
    /// The device in words.
    #[getter]
    fn adapter(&self) -> String {
        self.renderer.adapter()
    }
    /// The shadow map: depth of the nearest caster along each light ray.
    ///
    /// Parameters
    /// ----------
    /// scene : Scene
    /// parameterization : Parameterization, or (4, 4) or (K, 4, 4) array_like
    /// resolution : int or (int, int), optional
    ///     Texels: a side, or width and height. The parameterization's own where none is given.
    ///
    /// Returns
    /// -------
    /// (H, W) or, of several maps, (K, H, W) float32
    ///     NDC depth in [0, 1], 1 where no caster is.
    #[pyo3(signature = (scene, parameterization, *, resolution=None))]
    fn shadow_map<'py>(
        &self,
        #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
        parameterization: &Bound<'py, PyAny>,
        resolution: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = parameterization.py();
        let p = as_parameterization(parameterization)?;
        let p = &p.get().p;
        let resolution = resolution.map_or(Ok([p.resolution; 2]), |r| size2(r, "resolution"))?;
        let (scene, renderer) = (&scene.get().scene, &self.renderer);
        let maps = run_watched(py, None, |progress| renderer.depth_maps(scene, p, resolution, progress))?;
        let [w, h] = maps.size.map(|n| n as usize);
        Ok(match maps.layers {
            1 => image(py, maps.data, [h, w])?.into_any(),
            k => image(py, maps.data, [k as usize, h, w])?.into_any(),
        })
    }
    /// What the camera sees.
    ///
    /// Parameters
    /// ----------
    /// scene : Scene
    /// camera : Camera
    /// size : int or (int, int)
    ///     Pixels: a side, or width and height.
    ///
    /// Returns
    /// -------
    /// GBuffer
    #[pyo3(signature = (scene, camera, *, size))]
    fn gbuffer<'py>(
        &self,
        #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
        #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
        size: &Bound<'py, PyAny>,
    ) -> PyResult<PyGBuffer> {
        let py = size.py();
        let size = size2(size, "size")?;
        let (core, eye, renderer) = (&scene.get().scene, &camera.get().camera, &self.renderer);
        let mut g = run_watched(py, None, |progress| renderer.gbuffer(core, eye, size, progress))?;
        if core.meshes().iter().any(|m| m.dropped_faces() > 0) {
            for (triangle, &instance) in g.triangle.iter_mut().zip(&g.instance) {
                if instance >= 0 {
                    *triangle = core.mesh_of(instance as usize).source_face(*triangle as usize) as i32;
                }
            }
        }
        PyGBuffer::new(py, g)
    }
    /// The light that arrives at each pixel, through the shadow map.
    ///
    /// Parameters
    /// ----------
    /// scene, camera, light, parameterization
    ///     As in `shadow_map` and `gbuffer`.
    /// resolution : int or (int, int), optional
    ///     Texels of the shadow map.
    /// size : int or (int, int)
    ///     Pixels of the image.
    /// bias : Bias, optional
    /// filter : str
    ///     "nearest" or "pcf2x2".
    ///
    /// Returns
    /// -------
    /// (H, W) float32
    ///     1 lit, 0 in shadow (also what faces away from the light), NaN where nothing is.
    #[pyo3(signature = (scene, camera, light, parameterization, *, size, resolution=None, bias=None, filter="nearest"))]
    #[allow(clippy::too_many_arguments)]
    fn shadow_mask<'py>(
        &self,
        #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
        #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
        #[pyo3(from_py_with = light)] light: crate::Light,
        parameterization: &Bound<'py, PyAny>,
        size: &Bound<'py, PyAny>,
        resolution: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = bias)] bias: Option<Bias>,
        filter: &str,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let py = parameterization.py();
        let p = as_parameterization(parameterization)?;
        let filter = Filter::NAMES.iter().find(|f| f.0 == filter).map(|f| f.1).ok_or_else(|| {
            let valid = Filter::NAMES.iter().map(|f| f.0.to_string()).collect();
            to_exception(py, Error::UnknownName { kind: "filter".into(), name: filter.into(), valid })
        })?;
        let mask = self.mask(&scene, &camera, &light, &p, size, resolution, bias.unwrap_or_default(), filter)?;
        let [w, h] = mask.size.map(|n| n as usize);
        image(py, mask.data, [h, w])
    }
    /// Which map each pixel asks, where there are several.
    ///
    /// Parameters
    /// ----------
    /// scene, camera, light, parameterization, size, resolution
    ///     As in `shadow_mask`.
    ///
    /// Returns
    /// -------
    /// (H, W) int16
    ///     Index into `parameterization.partitions`; -1 where nothing is seen, where the surface faces away from the light or
    ///     is beyond its reach, and where no map holds the point (which is lit then).
    #[pyo3(signature = (scene, camera, light, parameterization, *, size, resolution=None))]
    #[allow(clippy::too_many_arguments)]
    fn chosen_map<'py>(
        &self,
        #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
        #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
        #[pyo3(from_py_with = light)] light: crate::Light,
        parameterization: &Bound<'py, PyAny>,
        size: &Bound<'py, PyAny>,
        resolution: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray2<i16>>> {
        let p = as_parameterization(parameterization)?;
        let (bias, filter) = (Bias::default(), Filter::Nearest);
        let mask = self.mask(&scene, &camera, &light, &p, size, resolution, bias, filter)?;
        let [w, h] = mask.size.map(|n| n as usize);
        image(parameterization.py(), mask.partition, [h, w])
    }
    fn __repr__(&self) -> String {
        format!("Renderer({:?}, adapter={:?})", self.backend(), self.adapter())
    }
}

impl PyRenderer {
    #[allow(clippy::too_many_arguments)]
    fn mask(
        &self,
        scene: &Bound<'_, PyScene>,
        camera: &Bound<'_, PyCamera>,
        light: &crate::Light,
        p: &Bound<'_, PyParameterization>,
        size: &Bound<'_, PyAny>,
        resolution: Option<&Bound<'_, PyAny>>,
        bias: Bias,
        filter: Filter,
    ) -> PyResult<ShadowMask> {
        let own = &p.get().p;
        let settings = MaskSettings {
            resolution: resolution.map_or(Ok([own.resolution; 2]), |r| size2(r, "resolution"))?,
            size: size2(size, "size")?,
            bias,
            filter,
        };
        let (scene, camera, renderer) = (&scene.get().scene, &camera.get().camera, &self.renderer);
        run_watched(p.py(), None, |progress| renderer.shadow_mask(scene, camera, light, own, &settings, progress))
    }
}

/// The graphics adapters of this machine: one dictionary each. Loads the graphics drivers.
#[pyfunction]
pub fn adapters(py: Python<'_>) -> PyResult<Vec<std::collections::BTreeMap<&'static str, String>>> {
    #[cfg(feature = "gpu")]
    {
        let found = looking_at_drivers(py, crate::render::gpu::adapters)?;
        let dict = |a: crate::render::gpu::AdapterInfo| {
            [("name", a.name), ("backend", a.backend), ("device_type", a.device_type), ("driver", a.driver)].into()
        };
        Ok(found.into_iter().map(dict).collect())
    }
    #[cfg(not(feature = "gpu"))]
    {
        let _ = py;
        Ok(Vec::new())
    }
}

/// Runs what loads graphics drivers, without the GIL. Where no XDG_RUNTIME_DIR is set, as in containers and notebooks
/// over ssh, it is while this runs: Mesa prints an error otherwise, though nothing here needs that folder.
fn looking_at_drivers<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    const NAME: &str = "XDG_RUNTIME_DIR";
    let environment = py.import("os")?.getattr("environ")?;
    let added = cfg!(target_os = "linux") && !environment.contains(NAME)?;
    if added {
        environment.set_item(NAME, py.import("tempfile")?.call_method0("gettempdir")?)?;
    }
    let done = py.detach(work);
    if added {
        environment.del_item(NAME)?;
    }
    Ok(done)
}

#[cfg(feature = "gpu")]
fn gpu(adapter: Option<&str>) -> crate::Result<Arc<dyn Renderer>> {
    Ok(Arc::new(crate::render::gpu::GpuRenderer::new(adapter)?))
}

#[cfg(feature = "gpu")]
fn hardware_adapter() -> bool {
    crate::render::gpu::adapters().iter().any(|a| a.device_type != "cpu")
}

#[cfg(not(feature = "gpu"))]
fn gpu(adapter: Option<&str>) -> crate::Result<Arc<dyn Renderer>> {
    let fix = "this build has no GPU renderer: build with the feature \"gpu\", or use backend \"cpu\"";
    Err(Error::NoAdapter { wanted: adapter.map(String::from), found: Vec::new(), fix: fix.into() })
}

#[cfg(not(feature = "gpu"))]
fn hardware_adapter() -> bool {
    false
}

fn as_parameterization<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyParameterization>> {
    if let Ok(p) = value.cast::<PyParameterization>() {
        return Ok(p.clone());
    }
    let py = value.py();
    let made = py.get_type::<PyParameterization>().call_method1("from_matrix", (value,)).map_err(|_| {
        let got = value.get_type().name().map(|n| n.to_string()).unwrap_or_default();
        let expected = "a Parameterization, or a finite (4, 4) or (K, 4, 4) array";
        argument_error(py, "parameterization", expected, got, "call technique.parameterize(...) first")
    })?;
    Ok(made.cast_into::<PyParameterization>()?)
}
