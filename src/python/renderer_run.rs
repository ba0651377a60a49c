//! How `_core.Renderer` draws: on the pool, one call of a device at a time, and in the process that made it.

use std::sync::PoisonError;

use pyo3::prelude::*;
use pyo3::sync::MutexExt;

use super::arguments::items;
use super::camera::PyCamera;
use super::convert::{argument_error, image, run_watched, size2, to_exception};
use super::light::lights_named;
use super::mask_settings::{Reading, settings_of};
use super::parameterization::{PyParameterization, as_parameterization};
use super::render::PyRenderer;
use super::scene::PyScene;
use super::stored::warn_of_open_meshes;
use crate::error::Error;
use crate::image::{ShadowMask, ShadowStates};
use crate::progress::Progress;
use crate::render::{Cull, LightMaps, MaskSettings, Renderer};
use crate::scene::Light;

/// How states are drawn and read, as arguments say it: resolution, size, how maps are read, and which instances are drawn.
type StatesHow<'a, 'py> = (Option<&'a Bound<'py, PyAny>>, [u32; 2], Reading<'a, 'py>, Cull);

impl PyRenderer {
    /// Runs work with the renderer as `run_watched` does.
    pub(super) fn run<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&dyn Renderer, &Progress) -> crate::Result<T> + Send,
    ) -> PyResult<T> {
        let renderer = &**self.renderer;
        if renderer.backend() != "gpu" {
            return run_watched(py, None, |progress| work(renderer, progress));
        }
        if self.process != std::process::id() {
            let what = format!("this Renderer was made by process {}, from which this one was forked", self.process);
            let fix = "make a new Renderer in this process, or start workers by \"spawn\" or \"forkserver\"".into();
            return Err(to_exception(py, Error::Device { what, fix }));
        }
        let _turn = self.turn.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner);
        run_watched(py, None, |progress| work(renderer, progress))
    }
    /// The mask of a parameterization's maps.
    pub(super) fn mask(
        &self,
        scene: &Bound<'_, PyScene>,
        camera: &Bound<'_, PyCamera>,
        light: &Light,
        p: &Bound<'_, PyParameterization>,
        cull: Cull,
        settings: &MaskSettings,
    ) -> PyResult<ShadowMask> {
        let (scene, camera, own) = (&scene.get().scene, &camera.get().camera, &p.get().p);
        self.run(p.py(), |renderer, progress| renderer.mask_of(scene, camera, light, own, settings, cull, progress))
    }
    /// The states of several lights as an array.
    pub(super) fn states<'py>(
        &self,
        scene: &Bound<'py, PyScene>,
        camera: &Bound<'py, PyCamera>,
        lights: &Bound<'py, PyAny>,
        maps: &Bound<'py, PyAny>,
        (resolution, size, reading, cull): StatesHow<'_, 'py>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = scene.py();
        let lights = lights_named(lights, "lights")?;
        let expected = "a parameterization for each light";
        let maps = items(maps, "parameterizations", expected, "technique.parameterize(...) makes each")?;
        if maps.len() != lights.len() {
            let expected = format!("a parameterization for each of {} lights", lights.len());
            let fix = "give as many of both";
            return Err(argument_error(py, "parameterizations", expected, maps.len(), fix));
        }
        let maps = maps.iter().map(as_parameterization).collect::<PyResult<Vec<_>>>()?;
        let resolution = resolution.map(|r| size2(r, "resolution")).transpose()?;
        // Blending is warned of where it does nothing for any of the lights.
        let own = maps.iter().map(|p| &p.get().p).max_by_key(|p| p.partitions.len());
        let Some(own) = own else {
            return Err(argument_error(py, "lights", "at least one light", "none", "give some"));
        };
        let settings = settings_of(py, own, None, size, reading)?;
        let scene = &scene.get().scene;
        warn_of_open_meshes(py, scene, &settings.stored)?;
        let with_maps = lights.iter().zip(maps.iter().map(|p| &p.get().p));
        let all: Vec<LightMaps> = with_maps
            .map(|(light, p)| LightMaps { light, p, resolution: resolution.unwrap_or(p.resolution) })
            .collect();
        let eye = &camera.get().camera;
        let states =
            self.run(py, |renderer, progress| renderer.shadow_states(scene, eye, &all, &settings, cull, progress))?;
        let ([w, h], pictures) = (states.size.map(|n| n as usize), ShadowStates::pictures(lights.len()));
        Ok(match pictures {
            1 => image(py, states.data, [h, w])?.into_any(),
            _ => image(py, states.data, [pictures, h, w])?.into_any(),
        })
    }
}
