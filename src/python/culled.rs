//! Which instances are drawn: the setting, the picture that it looks at, and what becomes of each.

use numpy::{PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use super::arguments::word_or;
use super::camera::{PyCamera, camera};
use super::convert::{OrRaise, argument_error, image, size2};
use super::gbuffer::{PyGBuffer, gbuffer};
use super::light::light;
use super::scene::{PyScene, scene};
use crate::Light;
use crate::image::DepthMaps;
use crate::names::named;
use crate::render::{self, Casters, Cull, Rule};

/// The setting of a word; the default where none is given.
pub fn cull_of(py: Python<'_>, word: Option<&Bound<'_, PyAny>>) -> PyResult<Cull> {
    let expected = format!("one of {}", Cull::NAMES.map(|one| one.0).join(", "));
    let word = word_or(word, "cull", Cull::default().name(), &expected)?;
    named("cull", &word, &Cull::NAMES).or_raise(py)
}

/// Whether maps of what a picture of `size` pixels sees are drawn sooner than whole ones.
#[pyfunction]
pub fn looking_pays(
    #[pyo3(from_py_with = scene)] scene: Bound<'_, PyScene>,
    size: &Bound<'_, PyAny>,
) -> PyResult<bool> {
    Ok(render::looking_pays(&scene.get().scene, size2(size, "size")?))
}

/// Maps as an array, without the axis of maps where there is one.
pub fn maps_to_array(py: Python<'_>, maps: DepthMaps) -> PyResult<Bound<'_, PyAny>> {
    let [w, h] = maps.size.map(|n| n as usize);
    Ok(match maps.layers {
        1 => image(py, maps.data, [h, w])?.into_any(),
        k => image(py, maps.data, [k as usize, h, w])?.into_any(),
    })
}

type Picture<'py> = (Bound<'py, PyGBuffer>, Bound<'py, PyCamera>, Light);

/// The picture that is looked at, where the setting takes one.
pub fn picture_of<'py>(
    py: Python<'py>,
    cull: Cull,
    given: Option<&Bound<'py, PyAny>>,
    eye: Option<&Bound<'py, PyAny>>,
    lamp: Option<&Bound<'py, PyAny>>,
) -> PyResult<Option<Picture<'py>>> {
    // Checked where they are given, whatever the setting.
    let (given, eye, lamp) =
        (given.map(gbuffer).transpose()?, eye.map(camera).transpose()?, lamp.map(light).transpose()?);
    if cull != Cull::Seen {
        return Ok(None);
    }
    let missing = |name: &str| {
        argument_error(py, name, "one, as cull=\"seen\" looks at a picture", "none", "give gbuffer, camera and light")
    };
    let given = given.ok_or_else(|| missing("gbuffer"))?;
    let eye = eye.ok_or_else(|| missing("camera"))?;
    Ok(Some((given, eye, lamp.ok_or_else(|| missing("light"))?)))
}

/// What becomes of the instances, as the package shows it.
pub fn casters_to_object(py: Python<'_>, found: Vec<Casters>) -> PyResult<Bound<'_, PyAny>> {
    let (maps, kinds) = (found.len(), Rule::NAMES.len());
    let count = found.first().map_or(0, |casters| casters.rules.len());
    let table = |of: fn(&Casters) -> &[u64; Rule::NAMES.len()]| -> PyResult<Bound<'_, PyArray2<i64>>> {
        image(py, found.iter().flat_map(of).map(|&n| n as i64).collect(), [maps, kinds])
    };
    let (instances, triangles) = (table(|c| &c.instances)?, table(|c| &c.triangles)?);
    let rules: Vec<u8> = found.iter().flat_map(|casters| casters.rules.iter().map(|rule| *rule as u8)).collect();
    let rules = image(py, rules, [maps * count])?.reshape([maps, count])?;
    let class = py.import("shadowlab.aliasing.casters")?.getattr("Casters")?;
    class.call1((rules, instances, triangles))
}
