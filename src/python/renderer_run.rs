//! How `_core.Renderer` draws: on the pool, one call of a device at a time, and in the process that made it.

use std::sync::PoisonError;

use pyo3::prelude::*;
use pyo3::sync::MutexExt;

use super::camera::PyCamera;
use super::convert::{run_watched, to_exception};
use super::parameterization::PyParameterization;
use super::render::PyRenderer;
use super::scene::PyScene;
use crate::error::Error;
use crate::image::ShadowMask;
use crate::progress::Progress;
use crate::render::{Cull, MaskSettings, Renderer};
use crate::scene::Light;

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
}
