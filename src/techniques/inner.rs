//! A technique with other settings, and the techniques inside it with theirs.

use super::TECHNIQUES;
use super::kit::{Kind, ParamSpec, Technique};
use super::registry::{Entry, Make, technique};
use super::text::{techniques_of, text_of};
use crate::error::Result;
use crate::parameterization::Value;

/// The techniques inside a scheme; none inside a warp.
///
/// # Errors
/// None for settings that a technique has.
pub(super) fn inner_of(of: &dyn Technique) -> Result<Vec<Box<dyn Technique>>> {
    let inner = of.spec().params.iter().find(|param| is_inner(of, param));
    match of.settings().iter().find(|(name, _)| inner.is_some_and(|param| param.name == *name)) {
        Some((_, Value::Choice(text))) => techniques_of(text),
        _ => Ok(Vec::new()),
    }
}

/// The technique with the values that `setting` gives its parameters; those inside a scheme are what `inner` makes of them.
///
/// # Errors
/// As [`technique`], and those of `inner`.
pub(super) fn with_settings(
    of: &dyn Technique,
    inner: impl Fn(&dyn Technique) -> Result<Box<dyn Technique>>,
    setting: impl Fn(&str, &Value, &ParamSpec) -> Value,
) -> Result<Box<dyn Technique>> {
    let settings = of.settings();
    let mut params = Vec::with_capacity(settings.len());
    for ((name, value), param) in settings.iter().zip(of.spec().params) {
        let value = if is_inner(of, param) {
            let made = inner_of(of)?.iter().map(|t| inner(t.as_ref())).collect::<Result<Vec<_>>>()?;
            let texts: Vec<String> = made.iter().map(|t| format!("({})", text_of(t.as_ref()))).collect();
            Value::Choice(texts.join("/"))
        } else {
            setting(name, value, param)
        };
        params.push((name.to_string(), value));
    }
    technique(of.spec().name, &params)
}

/// Whether a parameter names techniques that make maps inside of a scheme; what a warp names has the warp's own settings.
fn is_inner(of: &dyn Technique, param: &ParamSpec) -> bool {
    let is_scheme = |entry: &Entry| entry.spec.name == of.spec().name && matches!(entry.make, Make::Scheme(_));
    param.kind == Kind::Techniques && TECHNIQUES.iter().any(is_scheme)
}
