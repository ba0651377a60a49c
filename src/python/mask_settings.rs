//! The settings of a mask, read from arguments.

use pyo3::prelude::*;

use super::convert::size2;
use super::filter::{blend_of, filter_of};
use crate::parameterization::Parameterization;
use crate::render::{Bias, MaskSettings, Stored};

/// How maps are read, as arguments say it: bias, filter, blend and what is stored; the defaults where they are not given.
pub(super) type Reading<'a, 'py> =
    (Option<Bias>, Option<&'a Bound<'py, PyAny>>, Option<&'a Bound<'py, PyAny>>, Option<Stored>);

/// The settings of a mask; the resolution is the parameterization's own where none is given.
pub(super) fn settings_of(
    py: Python<'_>,
    p: &Parameterization,
    resolution: Option<&Bound<'_, PyAny>>,
    size: [u32; 2],
    (bias, filter, blend, stored): Reading,
) -> PyResult<MaskSettings> {
    Ok(MaskSettings {
        resolution: resolution.map_or(Ok(p.resolution), |r| size2(r, "resolution"))?,
        size,
        bias: bias.unwrap_or_default(),
        filter: filter_of(py, filter)?,
        blend: blend_of(py, blend, p)?,
        stored: stored.unwrap_or_default(),
    })
}
