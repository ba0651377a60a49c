//! `_core.Renderer`, `_core.Bias`.

use std::sync::Arc;

use numpy::PyArray2;
use pyo3::prelude::*;

use super::camera::{PyCamera, camera};
use super::convert::{OrRaise, exception, image, instance_of, run_watched, size2, to_exception};
use super::footprint::footprint_arrays;
use super::gbuffer::PyGBuffer;
use super::light::light;
use super::parameterization::{PyParameterization, as_parameterization};
use super::scene::{PyScene, scene};
use super::state::{Fault, Reader, Reduced, State, Writer, by_state, reduce};
use crate::error::Error;
use crate::image::ShadowMask;
use crate::render::cpu::CpuRenderer;
use crate::render::{Bias, Filter, MaskSettings, Renderer};

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
#[pyclass(name = "Bias", frozen, eq, hash, module = "shadowlab")]
#[derive(Clone)]
pub struct PyBias {
    bias: Bias,
}

by_state!(PyBias);

impl State for PyBias {
    const NAME: &'static str = "Bias";
    fn write(&self, to: &mut Writer) {
        let b = &self.bias;
        to.numbers(&[b.world, b.texels, b.ndc, b.slope, b.slope_limit]);
    }
    fn read(from: &mut Reader<'_>) -> Result<Self, Fault> {
        let [world, texels, ndc, slope, slope_limit] = from.numbers()?;
        let bias = Bias { world, texels, ndc, slope, slope_limit };
        Ok(Self { bias: bias.checked().map_err(|e| e.to_string())? })
    }
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
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduce(py, self)
    }
    fn __repr__(&self) -> String {
        let b = &self.bias;
        format!(
            "Bias(world={}, texels={}, ndc={}, slope={}, slope_limit={})",
            b.world, b.texels, b.ndc, b.slope, b.slope_limit
        )
    }
}

/// The filter of a name.
pub fn filter_of(py: Python<'_>, name: &str) -> PyResult<Filter> {
    Filter::NAMES.iter().find(|f| f.0 == name).map(|f| f.1).ok_or_else(|| {
        let valid = Filter::NAMES.iter().map(|f| f.0.to_string()).collect();
        to_exception(py, Error::UnknownName { kind: "filter".into(), name: name.into(), valid })
    })
}

/// A bias argument, or nothing for the default.
pub fn bias(value: &Bound<'_, PyAny>) -> PyResult<Option<Bias>> {
    if value.is_none() {
        return Ok(None);
    }
    Ok(Some(instance_of::<PyBias>(value, "bias", "say in which unit, for example Bias(world=0.01)")?.get().bias))
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
        let filter = filter_of(py, filter)?;
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
    /// What a texel of the shadow map looks like at each pixel, computed where this renderer draws.
    ///
    /// Parameters
    /// ----------
    /// scene, camera, light, parameterization, size, resolution
    ///     As in `shadow_mask`.
    ///
    /// Returns
    /// -------
    /// shadowlab.aliasing.Footprint
    #[pyo3(signature = (scene, camera, light, parameterization, *, size, resolution=None))]
    #[allow(clippy::too_many_arguments)]
    fn footprint<'py>(
        &self,
        #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
        #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
        #[pyo3(from_py_with = light)] light: crate::Light,
        parameterization: &Bound<'py, PyAny>,
        size: &Bound<'py, PyAny>,
        resolution: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = parameterization.py();
        let p = as_parameterization(parameterization)?;
        let own = &p.get().p;
        let resolution = resolution.map_or(Ok([own.resolution; 2]), |r| size2(r, "resolution"))?;
        let size = size2(size, "size")?;
        let (scene, eye, renderer) = (&scene.get().scene, &camera.get().camera, &self.renderer);
        let found =
            run_watched(py, None, |progress| renderer.footprint(scene, eye, &light, own, resolution, size, progress))?;
        let class = py.import("shadowlab.aliasing.footprint")?.getattr("Footprint")?;
        class.call_method1("of_arrays", (footprint_arrays(py, found)?, p, resolution))
    }
    /// Refused: a device stays in its process.
    fn __reduce__(&self, py: Python<'_>) -> PyResult<()> {
        let message = format!(
            "Renderer: it holds a device, which cannot be pickled; make one in the other process: sl.Renderer({:?})",
            self.backend()
        );
        Err(exception(py, "StateError", message))
    }
    fn __copy__<'py>(slf: &Bound<'py, Self>) -> Bound<'py, Self> {
        slf.clone()
    }
    fn __deepcopy__<'py>(slf: &Bound<'py, Self>, _memo: &Bound<'py, PyAny>) -> Bound<'py, Self> {
        slf.clone()
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
