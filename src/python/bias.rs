//! `_core.Bias`.

use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;

use super::arguments::{number, number_or};
use super::convert::{OrRaise, instance_of};
use super::state::{Fault, Reader, Reduced, State, Writer, by_state, reduce};
use crate::render::Bias;

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
///     Upper limit of the slope part, world sizes of a shadow texel along the light ray; infinity for none. It limits the
///     plane part, too.
/// plane : float
///     1: a texel is compared with the depth of the receiver's own plane at its centre, which is exact for planes; 0: with
///     the depth of the receiver; a part of the way between.
/// normal : float
///     World sizes of a shadow texel by which the receiver is moved along its normal before anything else.
/// factor : float
///     As graphics APIs define it for their polygon offset: times the larger change of the depth of the receiver's plane by a
///     texel, along x or y. The slope limit holds it, too.
/// units : float
///     As they define it: steps of the format of what is stored, at the receiver's depth.
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
        to.numbers(&[b.world, b.texels, b.ndc, b.slope, b.slope_limit, b.plane, b.normal, b.factor, b.units]);
    }
    fn read(from: &mut Reader<'_>) -> Result<Self, Fault> {
        let [world, texels, ndc, slope, slope_limit, plane, normal, factor, units] = from.numbers()?;
        let bias = Bias { world, texels, ndc, slope, slope_limit, plane, normal, factor, units };
        Ok(Self { bias: bias.checked().map_err(|e| e.to_string())? })
    }
}

#[pymethods]
impl PyBias {
    #[new]
    #[pyo3(signature = (*, world=None, texels=None, ndc=None, slope=None, slope_limit=None, plane=None, normal=None, factor=None, units=None))]
    #[allow(clippy::too_many_arguments)]
    fn new(
        py: Python<'_>,
        world: Option<&Bound<'_, PyAny>>,
        texels: Option<&Bound<'_, PyAny>>,
        ndc: Option<&Bound<'_, PyAny>>,
        slope: Option<&Bound<'_, PyAny>>,
        slope_limit: Option<&Bound<'_, PyAny>>,
        plane: Option<&Bound<'_, PyAny>>,
        normal: Option<&Bound<'_, PyAny>>,
        factor: Option<&Bound<'_, PyAny>>,
        units: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let d = Bias::default();
        let bias = Bias {
            world: number_or(world, "world", d.world)?,
            texels: number_or(texels, "texels", d.texels)?,
            ndc: number_or(ndc, "ndc", d.ndc)?,
            slope: number_or(slope, "slope", d.slope)?,
            slope_limit: number_or(slope_limit, "slope_limit", d.slope_limit)?,
            plane: number_or(plane, "plane", d.plane)?,
            normal: number_or(normal, "normal", d.normal)?,
            factor: number_or(factor, "factor", d.factor)?,
            units: number_or(units, "units", d.units)?,
        };
        Ok(Self { bias: bias.checked().or_raise(py)? })
    }
    /// No bias at all: acne everywhere.
    #[staticmethod]
    fn none() -> Self {
        Self { bias: Bias::NONE }
    }
    /// The polygon offset of graphics APIs: factor max(|dz/dX|, |dz/dY|) + units r is taken off the depth, and nothing else.
    ///
    /// X and Y are texels, z the depth that is stored, and r is a step of its format: 2^-16 and 2^-24 of `unorm16` and `unorm24`
    /// (to a part in their number), 2^(e - 23) of `f32` and 2^(e - 10) of `f16` with the exponent e of the receiver's depth. APIs add
    /// it to casters when a map is drawn; here the receiver's own plane has it, which is the same where that is what the map holds.
    ///
    /// Parameters
    /// ----------
    /// factor, units : float
    ///     As in ``glPolygonOffset(factor, units)``; ``depthBiasSlopeScale`` and ``depthBias`` of WebGPU, Vulkan and Direct3D.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For what is no finite number.
    ///
    /// References
    /// ----------
    /// theory.md (13.11); OpenGL 4.6, section 14.6.5.
    #[staticmethod]
    fn polygon_offset(py: Python<'_>, factor: &Bound<'_, PyAny>, units: &Bound<'_, PyAny>) -> PyResult<Self> {
        let fix = "0 switches it off";
        let bias = Bias::polygon_offset(number(factor, "factor", fix)?, number(units, "units", fix)?);
        Ok(Self { bias: bias.checked().or_raise(py)? })
    }
    /// World units along the light ray.
    #[getter]
    fn world(&self) -> f64 {
        self.bias.world
    }
    /// World sizes of a shadow texel at the receiver, across the light ray.
    #[getter]
    fn texels(&self) -> f64 {
        self.bias.texels
    }
    /// NDC depth.
    #[getter]
    fn ndc(&self) -> f64 {
        self.bias.ndc
    }
    /// Times the depth that the receiver's own plane gains over the filter's reach.
    #[getter]
    fn slope(&self) -> f64 {
        self.bias.slope
    }
    /// Upper limit of the slope part, world sizes of a shadow texel along the light ray; infinity for none.
    #[getter]
    fn slope_limit(&self) -> f64 {
        self.bias.slope_limit
    }
    /// How much of the way to its own plane at the texel's centre the receiver is moved.
    #[getter]
    fn plane(&self) -> f64 {
        self.bias.plane
    }
    /// World sizes of a shadow texel along the normal.
    #[getter]
    fn normal(&self) -> f64 {
        self.bias.normal
    }
    /// Times the larger change of the depth of the receiver's plane by a texel.
    #[getter]
    fn factor(&self) -> f64 {
        self.bias.factor
    }
    /// Steps of the format of what is stored.
    #[getter]
    fn units(&self) -> f64 {
        self.bias.units
    }
    /// How far this bias carries each pixel of a view towards the light.
    ///
    /// Parameters
    /// ----------
    /// view : View
    ///     With one light.
    /// technique : str, Technique, Preset or Parameterization
    ///     Whose maps are looked up; no map is drawn.
    /// resolution : int
    ///     Texels along each side of the maps.
    /// filter : str
    ///     How they are read: the slope part covers its reach.
    /// renderer : Renderer or str, optional
    ///     Draws the eye view.
    ///
    /// Returns
    /// -------
    /// (H, W) float32
    ///     World units along the light ray, at the texel that the pixel falls into; NaN where nothing is compared. A bias past
    ///     the near plane or the light counts up to there. With `plane` it is negative where the receiver's plane is farther
    ///     from the light at the texel's centre than at the pixel.
    ///
    /// Examples
    /// --------
    /// >>> import numpy as np, shadowlab as sl
    /// >>> scene = sl.library.scene("robots")
    /// >>> view = sl.View(scene, scene.camera, scene.light, size=(160, 90))
    /// >>> distance = sl.Bias(world=0.01, texels=0, ndc=0, slope=0, plane=0).at(view, "uniform", 512, renderer="cpu")
    /// >>> bool(np.allclose(distance[~np.isnan(distance)], 0.01, rtol=1e-4))
    /// True
    #[pyo3(signature = (view, technique, resolution=None, *, filter=None, renderer=None),
        text_signature = "($self, view, technique, resolution=1024, *, filter='nearest', renderer=None)")]
    fn at<'py>(
        slf: &Bound<'py, Self>,
        view: &Bound<'py, PyAny>,
        technique: &Bound<'py, PyAny>,
        resolution: Option<&Bound<'py, PyAny>>,
        filter: Option<&Bound<'py, PyAny>>,
        renderer: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let resolution = resolution.map_or_else(|| 1024_u32.into_bound_py_any(py), |r| Ok(r.clone()))?;
        let filter = filter.map_or_else(|| "nearest".into_bound_py_any(py), |f| Ok(f.clone()))?;
        let at = py.import("shadowlab.experiments.bias_at")?.getattr("bias_at")?;
        at.call1((slf, view, technique, resolution, renderer, filter))
    }
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduce(py, self)
    }
    fn __repr__(&self) -> String {
        let b = &self.bias;
        format!(
            "Bias(world={}, texels={}, ndc={}, slope={}, slope_limit={}, plane={}, normal={}, factor={}, units={})",
            b.world, b.texels, b.ndc, b.slope, b.slope_limit, b.plane, b.normal, b.factor, b.units
        )
    }
}

/// A bias argument, or nothing for the default.
pub fn bias(value: &Bound<'_, PyAny>) -> PyResult<Option<Bias>> {
    if value.is_none() {
        return Ok(None);
    }
    Ok(Some(instance_of::<PyBias>(value, "bias", "say in which unit, for example Bias(world=0.01)")?.get().bias))
}
