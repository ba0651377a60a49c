//! `_core.Renderer`.

use std::mem::ManuallyDrop;
use std::sync::{Arc, Mutex};

use numpy::PyArray2;
use pyo3::prelude::*;

use super::bias::bias;
use super::camera::{PyCamera, camera};
use super::convert::{OrRaise, exception, image, size2};
use super::culled::{casters_to_object, cull_of, maps_to_array, picture_of};
use super::drivers::made;
use super::footprint::footprint_arrays;
use super::gbuffer::{PyGBuffer, gbuffer};
use super::light::light;
use super::mask_settings::settings_of;
use super::parameterization::as_parameterization;
use super::scene::{PyScene, scene};
use super::stored::{stored, warn_of_open_meshes};
use crate::image::Surfaces;
use crate::render::{Bias, Cull, MaskSettings, Renderer, Stored};
use crate::scene::{Camera, Light};
use crate::threads;

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
///     No such adapter. Every method raises it where a renderer on a device is used in a process that was forked after it was
///     made.
/// UnknownNameError
///     No such backend.
#[pyclass(name = "Renderer", frozen, module = "shadowlab")]
pub struct PyRenderer {
    /// Not dropped in a process forked from the one that made it: drivers wait for threads of theirs that are not there.
    pub(super) renderer: ManuallyDrop<Arc<dyn Renderer>>,
    pub(super) process: u32,
    /// Held while a device draws: one call at a time, and none waits on a thread of the pool (see `run_watched`).
    pub(super) turn: Mutex<()>,
}

impl Drop for PyRenderer {
    fn drop(&mut self) {
        if self.process == std::process::id() {
            // SAFETY: dropped once, here.
            unsafe { ManuallyDrop::drop(&mut self.renderer) }
        }
    }
}

#[pymethods]
impl PyRenderer {
    #[new]
    #[pyo3(signature = (backend=None, *, adapter=None), text_signature = "(backend='auto', *, adapter=None)")]
    fn new(py: Python<'_>, backend: Option<&Bound<'_, PyAny>>, adapter: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let made = made(py, backend, adapter)?;
        let renderer = ManuallyDrop::new(made.or_raise(py)?);
        Ok(Self { renderer, process: std::process::id(), turn: Mutex::new(()) })
    }
    /// Kind of renderer: "cpu" or "gpu".
    #[getter]
    fn backend(&self) -> &'static str {
        self.renderer.backend()
    }
    /// The device in words.
    #[getter]
    fn adapter(&self, py: Python<'_>) -> PyResult<String> {
        if self.backend() == "gpu" {
            return Ok(self.renderer.adapter());
        }
        // It tells how many threads there are where it is asked.
        py.detach(|| threads::install(|| self.renderer.adapter())).or_raise(py)
    }
    /// Gives back the memory that the renderer keeps between calls.
    ///
    /// On a device these are the geometry of the scenes drawn last (at most 1 GiB) and images and buffers that wait for calls of
    /// the same sizes (at most 64 of each and 512 MiB together); on the processor the scratch memory of finished calls. The next
    /// call makes them anew. Everything goes with the renderer, too.
    ///
    /// Raises
    /// ------
    /// DeviceError
    ///     The device was lost.
    fn release(&self, py: Python<'_>) -> PyResult<()> {
        self.run(py, |renderer, _| renderer.release())
    }
    /// The shadow map: what is stored of each light ray, the depth of the nearest caster unless `stored` says otherwise.
    ///
    /// Parameters
    /// ----------
    /// scene : Scene
    /// parameterization : Parameterization, or (4, 4) or (K, 4, 4) array_like
    /// resolution : int or (int, int), optional
    ///     Texels: a side, or width and height. The parameterization's own where none is given.
    /// stored : Stored or str, optional
    ///     What the map stores. By default the nearest surface, as NDC depth in single precision.
    /// cull : str
    ///     Which instances are drawn: "volume", those whose box has a part in the map's volume; "none", all. The map is the same.
    ///     What is "seen" takes a picture: see `seen_map`.
    ///
    /// Returns
    /// -------
    /// (H, W) or, of several maps, (K, H, W) float32
    ///     The stored values, in [0, 1]; 1 where no caster is.
    ///
    /// Warns
    /// -----
    /// ShadowlabWarning
    ///     Open meshes where `stored` needs closed ones ("back", "second", "midpoint"), with the number of their border edges.
    #[pyo3(signature = (scene, parameterization, *, resolution=None, stored=None, cull=None),
        text_signature = "($self, scene, parameterization, *, resolution=None, stored=None, cull='volume')")]
    fn shadow_map<'py>(
        &self,
        #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
        parameterization: &Bound<'py, PyAny>,
        resolution: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = stored)] stored: Option<Stored>,
        cull: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = parameterization.py();
        let p = as_parameterization(parameterization)?;
        let p = &p.get().p;
        let resolution = resolution.map_or(Ok(p.resolution), |r| size2(r, "resolution"))?;
        let (scene, stored, cull) = (&scene.get().scene, stored.unwrap_or_default(), cull_of(py, cull)?);
        warn_of_open_meshes(py, scene, &stored)?;
        maps_to_array(py, self.run(py, |r, progress| r.maps_of(scene, p, resolution, stored, cull, progress))?)
    }
    /// The shadow maps as far as the pixels of a picture look them up.
    ///
    /// Casters whose shadow reaches no pixel are not drawn: texels that no pixel reads may be empty, and texels that are read
    /// may store something farther than what was left out, as long as no comparison changes. `sl.aliasing.look_up` with the
    /// same settings gives the mask of whole maps, bit for bit.
    ///
    /// Parameters
    /// ----------
    /// scene : Scene
    /// gbuffer : GBuffer
    ///     The picture.
    /// camera, light, parameterization, resolution, bias, filter, blend, stored
    ///     As they will be looked up: as in `shadow_mask`.
    ///
    /// Returns
    /// -------
    /// (H, W) or, of several maps, (K, H, W) float32
    ///     As `shadow_map`.
    ///
    /// Warns
    /// -----
    /// ShadowlabWarning
    ///     As `shadow_map`.
    ///
    /// Notes
    /// -----
    /// The "cpu" renderer leaves out casters over texels that no pixel reads, and those behind all receivers that read their
    /// texels. Behind a receiver counts where the map stores the front, back or second surface with projective spacing. The
    /// "gpu" renderer leaves out the former alone.
    #[pyo3(signature = (scene, gbuffer, camera, light, parameterization, *, resolution=None, bias=None, filter=None, blend=None, stored=None),
        text_signature = "($self, scene, gbuffer, camera, light, parameterization, *, resolution=None, bias=None, filter='nearest', blend=0.0, stored=None)")]
    #[allow(clippy::too_many_arguments)]
    fn seen_map<'py>(
        &self,
        #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
        #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
        #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
        #[pyo3(from_py_with = light)] light: Light,
        parameterization: &Bound<'py, PyAny>,
        resolution: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = bias)] bias: Option<Bias>,
        filter: Option<&Bound<'py, PyAny>>,
        blend: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = stored)] stored: Option<Stored>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = parameterization.py();
        let p = as_parameterization(parameterization)?;
        let p = &p.get().p;
        let settings = settings_of(py, p, resolution, gbuffer.get().whole_picture(), (bias, filter, blend, stored))?;
        let (scene, camera) = (&scene.get().scene, &camera.get().camera);
        warn_of_open_meshes(py, scene, &settings.stored)?;
        let maps = gbuffer.get().with_surfaces(py, |surfaces| {
            self.run(py, |r, progress| r.seen_maps(scene, *surfaces, camera, &light, p, &settings, progress))
        })?;
        maps_to_array(py, maps)
    }
    /// What becomes of the instances of a scene where this renderer draws maps: which are drawn, and which rule left out the
    /// others.
    ///
    /// Parameters
    /// ----------
    /// scene : Scene
    /// parameterization : Parameterization, or (4, 4) or (K, 4, 4) array_like
    /// resolution : int or (int, int), optional
    ///     Texels: a side, or width and height. The parameterization's own where none is given.
    /// cull : str
    ///     "volume", "seen" or "none", as in `shadow_mask`. "seen" takes `gbuffer`, `camera` and `light`.
    /// gbuffer : GBuffer, optional
    ///     The picture whose pixels look up the maps.
    /// camera, light, bias, filter, blend, stored
    ///     As its pixels look them up: as in `shadow_mask`.
    ///
    /// Returns
    /// -------
    /// shadowlab.aliasing.Casters
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For "seen" without a picture, its camera or its light.
    ///
    /// Examples
    /// --------
    /// >>> import shadowlab as sl
    /// >>> s = sl.library.scene("forest", trees=500)
    /// >>> p = sl.technique("lispsm").parameterize(s, s.camera, s.light)
    /// >>> found = sl.Renderer("cpu").casters(s, p)
    /// >>> found.drawn + found.culled == s.instance_count
    /// True
    #[pyo3(signature = (scene, parameterization, *, resolution=None, cull=None, gbuffer=None, camera=None, light=None, bias=None, filter=None, blend=None, stored=None),
        text_signature = "($self, scene, parameterization, *, resolution=None, cull='volume', gbuffer=None, camera=None, light=None, bias=None, filter='nearest', blend=0.0, stored=None)")]
    #[allow(clippy::too_many_arguments)]
    fn casters<'py>(
        &self,
        #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
        parameterization: &Bound<'py, PyAny>,
        resolution: Option<&Bound<'py, PyAny>>,
        cull: Option<&Bound<'py, PyAny>>,
        gbuffer: Option<&Bound<'py, PyAny>>,
        camera: Option<&Bound<'py, PyAny>>,
        light: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = bias)] bias: Option<Bias>,
        filter: Option<&Bound<'py, PyAny>>,
        blend: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = stored)] stored: Option<Stored>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = parameterization.py();
        let p = as_parameterization(parameterization)?;
        let p = &p.get().p;
        let (scene, cull) = (&scene.get().scene, cull_of(py, cull)?);
        let picture = picture_of(py, cull, gbuffer, camera, light)?;
        let mut settings = settings_of(py, p, resolution, [1, 1], (bias, filter, blend, stored))?;
        let run = |picture: Option<(Surfaces<'_>, &Camera, &Light)>, settings: &MaskSettings| {
            self.run(py, |renderer, progress| renderer.casters(scene, p, cull, picture, settings, progress))
        };
        let found = match &picture {
            None => run(None, &settings)?,
            Some((gbuffer, camera, light)) => {
                settings.size = gbuffer.get().whole_picture();
                let camera = &camera.get().camera;
                gbuffer.get().with_surfaces(py, |surfaces| run(Some((*surfaces, camera, light)), &settings))?
            }
        };
        casters_to_object(py, found)
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
        let (core, eye) = (&scene.get().scene, &camera.get().camera);
        let mut g = self.run(py, |renderer, progress| renderer.gbuffer(core, eye, size, progress))?;
        if core.meshes().iter().any(|m| m.dropped_faces() > 0) {
            for (triangle, &instance) in g.triangle.iter_mut().zip(&g.instance) {
                if instance >= 0 {
                    *triangle = core.mesh_of(instance as usize).source_face(*triangle as usize) as i32;
                }
            }
        }
        PyGBuffer::new(py, g, *eye)
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
    ///     One of `sl.filters()` with its settings, such as "nearest", "bilinear", "pcf:size=3", "tent:size=3px" or
    ///     "poisson:count=16,radius=2,seed=0"; lengths in texels, or with px in pixels.
    /// blend : float
    ///     The last share of each map's range of eye depth over which the light of the next map is mixed in, where that map
    ///     holds the receiver (`overlap` of z_partition sees to that); of maps that are chosen because they hold a receiver,
    ///     the share of the map at its border. 0 for none.
    /// stored : Stored or str, optional
    ///     What the map stores, as in `shadow_map`. The ndc part of the bias is in units of what is stored.
    /// cull : str
    ///     Which instances are drawn into the map: "volume", those whose box has a part in its volume; "seen", of these the
    ///     ones whose shadow may reach a pixel (`seen_map`; on a device as "volume"); "none", all. The mask is the same.
    ///
    /// Returns
    /// -------
    /// (H, W) float32
    ///     1 lit, 0 in shadow (also what faces away from the light), NaN where nothing is.
    ///
    /// Warns
    /// -----
    /// ShadowlabWarning
    ///     As `shadow_map`.
    #[pyo3(signature = (scene, camera, light, parameterization, *, size, resolution=None, bias=None, filter=None, blend=None, stored=None, cull=None),
        text_signature = "($self, scene, camera, light, parameterization, *, size, resolution=None, bias=None, filter='nearest', blend=0.0, stored=None, cull='volume')")]
    #[allow(clippy::too_many_arguments)]
    fn shadow_mask<'py>(
        &self,
        #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
        #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
        #[pyo3(from_py_with = light)] light: Light,
        parameterization: &Bound<'py, PyAny>,
        size: &Bound<'py, PyAny>,
        resolution: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = bias)] bias: Option<Bias>,
        filter: Option<&Bound<'py, PyAny>>,
        blend: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = stored)] stored: Option<Stored>,
        cull: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let py = parameterization.py();
        let p = as_parameterization(parameterization)?;
        let size = size2(size, "size")?;
        let settings = settings_of(py, &p.get().p, resolution, size, (bias, filter, blend, stored))?;
        warn_of_open_meshes(py, &scene.get().scene, &settings.stored)?;
        let mask = self.mask(&scene, &camera, &light, &p, cull_of(py, cull)?, &settings)?;
        let [w, h] = mask.size.map(|n| n as usize);
        image(py, mask.data, [h, w])
    }
    /// At which pixels each of several lights arrives, a bit per light.
    ///
    /// The eye view is drawn once for all lights. On the processor all lights with one map each are looked up in one pass
    /// over the pixels.
    ///
    /// Parameters
    /// ----------
    /// scene, camera
    ///     As in `shadow_mask`.
    /// lights : sequence of DirectionalLight, SpotLight or PointLight
    /// parameterizations : sequence of Parameterization, or (4, 4) or (K, 4, 4) array_like
    ///     The maps of each light.
    /// size, resolution, bias, filter, blend, stored, cull
    ///     As in `shadow_mask`, the same for all lights.
    ///
    /// Returns
    /// -------
    /// (H, W) or, of more than 32 lights, (P, H, W) uint32
    ///     Bit ``i % 32`` of picture ``i // 32``, counted from the lowest, is 1 where at least half of light `i` arrives, as
    ///     `aliasing.misclassified` judges its mask; 0 in shadow and where nothing is.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     No light, another number of parameterizations than of lights, and as `shadow_mask`.
    ///
    /// References
    /// ----------
    /// Chong, Gortler 2007, section 3: the shadow states of up to 32 lights in the four bytes of a pixel.
    ///
    /// Examples
    /// --------
    /// >>> import shadowlab as sl
    /// >>> s = sl.library.scene("robots")
    /// >>> lights = [s.light, sl.PointLight((0, 6, 0), range=40.0)]
    /// >>> maps = [sl.technique("uniform").parameterize(s, s.camera, light, resolution=256) for light in lights]
    /// >>> states = sl.Renderer("cpu").shadow_states(s, s.camera, lights, maps, size=(160, 90))
    /// >>> lit_by_lamp = (states >> 1) & 1 == 1
    /// >>> lit_by_lamp.shape
    /// (90, 160)
    #[pyo3(signature = (scene, camera, lights, parameterizations, *, size, resolution=None, bias=None, filter=None, blend=None, stored=None, cull=None),
        text_signature = "($self, scene, camera, lights, parameterizations, *, size, resolution=None, bias=None, filter='nearest', blend=0.0, stored=None, cull='volume')")]
    #[allow(clippy::too_many_arguments)]
    fn shadow_states<'py>(
        &self,
        #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
        #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
        lights: &Bound<'py, PyAny>,
        parameterizations: &Bound<'py, PyAny>,
        size: &Bound<'py, PyAny>,
        resolution: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = bias)] bias: Option<Bias>,
        filter: Option<&Bound<'py, PyAny>>,
        blend: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = stored)] stored: Option<Stored>,
        cull: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let how = (resolution, size2(size, "size")?, (bias, filter, blend, stored), cull_of(size.py(), cull)?);
        self.states(&scene, &camera, lights, parameterizations, how)
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
        #[pyo3(from_py_with = light)] light: Light,
        parameterization: &Bound<'py, PyAny>,
        size: &Bound<'py, PyAny>,
        resolution: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyArray2<i16>>> {
        let p = as_parameterization(parameterization)?;
        let (py, size) = (size.py(), size2(size, "size")?);
        let settings = settings_of(py, &p.get().p, resolution, size, (None, None, None, None))?;
        let mask = self.mask(&scene, &camera, &light, &p, Cull::Volume, &settings)?;
        let [w, h] = mask.size.map(|n| n as usize);
        image(py, mask.partition, [h, w])
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
        #[pyo3(from_py_with = light)] light: Light,
        parameterization: &Bound<'py, PyAny>,
        size: &Bound<'py, PyAny>,
        resolution: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = parameterization.py();
        let p = as_parameterization(parameterization)?;
        let own = &p.get().p;
        let resolution = resolution.map_or(Ok(own.resolution), |r| size2(r, "resolution"))?;
        let size = size2(size, "size")?;
        let (scene, eye) = (&scene.get().scene, &camera.get().camera);
        let found =
            self.run(py, |renderer, progress| renderer.footprint(scene, eye, &light, own, resolution, size, progress))?;
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
    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        Ok(format!("Renderer({:?}, adapter={:?})", self.backend(), self.adapter(py)?))
    }
}
