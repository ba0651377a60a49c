//! Filters as text, and how maps blend.

use pyo3::prelude::*;

use super::arguments::{number_or, word_or};
use super::convert::{OrRaise, to_exception};
use super::exceptions::warn;
use crate::parameterization::{Parameterization, Value};
use crate::render::{FILTERS, Filter, check_blend};

/// The filter of a text; the nearest texel where none is given.
pub fn filter_of(py: Python<'_>, text: Option<&Bound<'_, PyAny>>) -> PyResult<Filter> {
    let kinds: Vec<&str> = FILTERS.iter().map(|spec| spec.name).collect();
    let text = word_or(text, "filter", "nearest", &format!("one of {}, with settings", kinds.join(", ")))?;
    text.parse().map_err(|error| to_exception(py, error))
}

/// The kinds of filter: name, settings with examples of values, and what each is.
#[pyfunction]
pub fn filter_kinds() -> Vec<(&'static str, &'static str, &'static str)> {
    FILTERS.iter().map(|spec| (spec.name, spec.settings, spec.doc)).collect()
}

/// A filter's text as it is written by itself: checked, with all of its settings.
#[pyfunction]
pub fn filter_text(filter: &Bound<'_, PyAny>) -> PyResult<String> {
    Ok(filter_of(filter.py(), Some(filter))?.to_string())
}

/// The share over which maps blend; 0 where none is given.
pub fn unwarned_blend(py: Python<'_>, blend: Option<&Bound<'_, PyAny>>) -> PyResult<f64> {
    check_blend(number_or(blend, "blend", 0.0)?).or_raise(py)
}

/// The same, with a warning where the maps of a scheme do not overlap as far.
pub fn blend_of(py: Python<'_>, blend: Option<&Bound<'_, PyAny>>, p: &Parameterization) -> PyResult<f64> {
    let blend = unwarned_blend(py, blend)?;
    let overlap = p.settings.iter().find_map(|(name, value)| match value {
        Value::Number(overlap) if *name == "overlap" => Some(*overlap),
        _ => None,
    });
    if let Some(overlap) = overlap.filter(|overlap| *overlap < blend && p.partitions.len() > 1) {
        let what = format!(
            "blend: the maps of {} overlap by {overlap}, less than {blend}; where the next map does not hold a receiver of the \
             zone, its own map's light stays as it is; set overlap={blend}",
            p.technique
        );
        warn(py, &what)?;
    }
    Ok(blend)
}
