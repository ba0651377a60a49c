//! Cameras from Python's arguments: aimed at a target, and others with changes.

use glam::{DVec2, DVec3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use super::arguments::{array, number, vec3, word};
use super::exceptions::{OrRaise, argument_error, to_exception, warn};
use crate::error::Error;
use crate::scene::{Camera, Lens, ViewVolume};

/// What [`replaced`] takes.
const CHANGES: [&str; 10] = ["eye", "target", "forward", "up", "fov_y", "height", "aspect", "near", "far", "shift"];

/// A camera at the first of two points that looks at the second.
pub fn aimed(
    py: Python<'_>,
    [eye, target]: [&Bound<'_, PyAny>; 2],
    up: Option<&Bound<'_, PyAny>>,
    volume: ViewVolume,
    shift: Option<&Bound<'_, PyAny>>,
) -> PyResult<Camera> {
    let (eye, target) = (vec3(eye, "eye")?, vec3(target, "target")?);
    let shift = shift.map(|shift| vec2(shift, "shift")).transpose()?.unwrap_or(DVec2::ZERO);
    let volume = volume.shifted(shift);
    if let Some(up) = up {
        return Camera::aimed(eye, target, vec3(up, "up")?, volume).or_raise(py);
    }
    let way = Camera::way(eye, target).or_raise(py)?;
    let (up, is_chosen) = Camera::usual_up(way).or_raise(py)?;
    let camera = Camera::aimed(eye, target, up, volume).or_raise(py)?;
    if is_chosen {
        let way = if way.y < 0.0 { "down" } else { "up" };
        warn(
            py,
            &format!(
                "up: the camera looks straight {way}, along the default up (0, 1, 0), so up is {}; give up=... for another",
                shown(up)
            ),
        )?;
    }
    Ok(camera)
}

/// The camera with other settings.
pub fn replaced(py: Python<'_>, c: &Camera, changes: &Bound<'_, PyDict>) -> PyResult<Camera> {
    for key in changes.keys() {
        let name = word(&key, "changes", "names of settings")?;
        if !CHANGES.contains(&name.as_str()) {
            let valid = CHANGES.map(String::from).into();
            return Err(to_exception(py, Error::UnknownName { kind: "setting of a camera".into(), name, valid }));
        }
    }
    let vector = |name: &str| changes.get_item(name)?.map(|v| vec3(&v, name)).transpose();
    let scalar = |name: &str| changes.get_item(name)?.map(|v| number(&v, name, "give a number")).transpose();
    let own = c.volume();
    let (fov_y, height) = (scalar("fov_y")?, scalar("height")?);
    let lens = match (own.lens, fov_y, height) {
        (Lens::Perspective { .. }, _, Some(got)) => {
            let fix = "give fov_y, or make another with Camera.orthographic";
            return Err(argument_error(py, "height", "no height of a perspective camera", got.to_string(), fix));
        }
        (Lens::Orthographic { .. }, Some(got), _) => {
            let fix = "give height, or make another with Camera.look_at";
            return Err(argument_error(
                py,
                "fov_y",
                "no field of view of an orthographic camera",
                got.to_string(),
                fix,
            ));
        }
        (Lens::Perspective { fov_y: own }, given, None) => Lens::Perspective { fov_y: given.unwrap_or(own) },
        (Lens::Orthographic { height: own }, None, given) => Lens::Orthographic { height: given.unwrap_or(own) },
    };
    let volume = ViewVolume {
        lens,
        aspect: scalar("aspect")?.unwrap_or(own.aspect),
        shift: changes.get_item("shift")?.map(|v| vec2(&v, "shift")).transpose()?.unwrap_or(own.shift),
        near: scalar("near")?.unwrap_or(own.near),
        far: scalar("far")?.unwrap_or(own.far),
    };
    let (eye, up) = (vector("eye")?.unwrap_or(c.eye()), vector("up")?);
    let forward = match (vector("target")?, vector("forward")?) {
        (Some(_), Some(_)) => {
            let (expected, fix) = ("one of target and forward", "leave one of them out");
            return Err(argument_error(py, "target", expected, "both", fix));
        }
        (Some(target), None) => Camera::way(eye, target).or_raise(py)?,
        (None, None) if up.is_none() => return Camera::from_axes(eye, c.axes(), volume).or_raise(py),
        (None, forward) => forward.unwrap_or(c.forward()),
    };
    if let Some(up) = up {
        return Camera::look_along(eye, forward, up, volume).or_raise(py);
    }
    let (up, is_chosen) = Camera::tilted_up(forward, c.up(), c.forward()).or_raise(py)?;
    let camera = Camera::look_along(eye, forward, up, volume).or_raise(py)?;
    if is_chosen {
        warn(
            py,
            &format!(
                "up: the camera is turned along its own up {}, so up is {}; give up=... for another",
                shown(c.up()),
                shown(up)
            ),
        )?;
    }
    Ok(camera)
}

/// Two numbers.
fn vec2(value: &Bound<'_, PyAny>, name: &str) -> PyResult<DVec2> {
    Ok(DVec2::from_slice(array::<f64>(value, name, &[Some(2)])?.as_slice()?))
}

/// A vector as it is written in Python, without negative zeros.
fn shown(v: DVec3) -> String {
    let [x, y, z] = (v + 0.0).to_array();
    format!("({x}, {y}, {z})")
}
