//! A technique with other settings, and the techniques inside it with theirs.

use super::kit::{Kind, ParamSpec, Technique};
use super::registry::technique;
use super::text::{techniques_of, text_of};
use crate::error::Result;
use crate::parameterization::Value;

/// The techniques inside a scheme; none inside a warp.
///
/// # Errors
/// None for settings that a technique has.
pub(super) fn inner_of(of: &dyn Technique) -> Result<Vec<Box<dyn Technique>>> {
    let inner = of.spec().params.iter().find(|param| param.kind == Kind::Techniques);
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
        let value = if param.kind == Kind::Techniques {
            let made = inner_of(of)?.iter().map(|t| inner(t.as_ref())).collect::<Result<Vec<_>>>()?;
            let texts: Vec<String> = made.iter().map(|t| text_of(t.as_ref())).collect();
            Value::Choice(match texts.as_slice() {
                [one] => one.clone(),
                several => several.iter().map(|text| format!("({text})")).collect::<Vec<_>>().join("/"),
            })
        } else {
            setting(name, value, param)
        };
        params.push((name.to_string(), value));
    }
    technique(of.spec().name, &params)
}
