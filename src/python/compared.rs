//! Which depths a lookup compares: where pixels lie in their maps, and the biased depth of each.

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use super::camera::{PyCamera, camera};
use super::convert::{argument_error, array, image, run_watched, size2};
use super::gbuffer::{PyGBuffer, gbuffer};
use super::light::light;
use super::parameterization::as_parameterization;
use super::render::{bias, filter_of};
use super::stored::stored;
use crate::image::Footprint;
use crate::render::cpu::lookup::{Comparison, Lookups};
use crate::render::{Bias, MaskSettings, Stored};
use crate::scene::Light;

/// What pixels are compared with: the map (N,) int16, as `Footprint.map`; the place in it (N, 2) float64, texels; and the biased
/// depth (N,) float64, NaN where the pixel is lit without a look at the map.
#[pyfunction]
#[pyo3(signature = (gbuffer, camera, light, parameterization, pixels, *, resolution=None, bias=None, filter=None, stored=None),
    text_signature = "(gbuffer, camera, light, parameterization, pixels, *, resolution=None, bias=None, filter='nearest', stored=None)")]
#[allow(clippy::too_many_arguments, clippy::type_complexity)]
pub fn compared<'py>(
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: Light,
    parameterization: &Bound<'py, PyAny>,
    pixels: &Bound<'py, PyAny>,
    resolution: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = bias)] bias: Option<Bias>,
    filter: Option<&Bound<'py, PyAny>>,
    #[pyo3(from_py_with = stored)] stored: Option<Stored>,
) -> PyResult<(Bound<'py, PyArray1<i16>>, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>)> {
    let py = parameterization.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let resolution = resolution.map_or(Ok(p.resolution), |r| size2(r, "resolution"))?;
    let camera = &camera.get().camera;
    let (filter, stored) = (filter_of(py, filter)?, stored.unwrap_or_default());
    let pixels = array::<i64>(pixels, "pixels", &[None, Some(2)])?;
    let (pixels, _) = pixels.as_slice()?.as_chunks::<2>();
    let [width, height] = gbuffer.get().picture().map(i64::from);
    if let Some([x, y]) = pixels.iter().find(|[x, y]| !((0..width).contains(x) && (0..height).contains(y))) {
        let expected = format!("columns and rows of a picture of {width} x {height} pixels");
        return Err(argument_error(py, "pixels", expected, format!("({x}, {y})"), "count from 0 at the upper left"));
    }
    let found = gbuffer.get().with_surfaces(py, |surfaces| {
        let settings = MaskSettings { resolution, size: surfaces.size, bias: bias.unwrap_or_default(), filter, stored };
        run_watched(py, None, |progress| {
            let lookups = Lookups::new(p, &light, surfaces.origin, &settings)?;
            let unknown = [f64::NAN; 2];
            let mut found = Vec::with_capacity(pixels.len());
            for [x, y] in pixels {
                progress.check()?;
                let Some((point, normal)) = surfaces.receiver((y * width + x) as usize) else {
                    found.push((Footprint::NOTHING, unknown, f64::NAN));
                    continue;
                };
                let p_world = surfaces.origin + point;
                if !light.illuminates(p_world, normal) {
                    found.push((Footprint::AVERTED, unknown, f64::NAN));
                    continue;
                }
                let Some(k) = lookups.choose(point, camera.depth_of(p_world)) else {
                    found.push((Footprint::NO_MAP, unknown, f64::NAN));
                    continue;
                };
                let (place, depth) = match lookups.map(k).compare_at(point, normal) {
                    Comparison::At(at) => {
                        let centre = at.p_texel.floor() + 0.5;
                        (at.p_texel.to_array(), lookups.map(k).depth_at(&at, centre))
                    }
                    Comparison::Lit => (lookups.map(k).place_of(point).map_or(unknown, |at| at.to_array()), f64::NAN),
                };
                found.push((k as i16, place, depth));
            }
            Ok(found)
        })
    })?;
    let n = found.len();
    let maps = found.iter().map(|(map, ..)| *map).collect();
    let places = found.iter().flat_map(|(_, place, _)| *place).collect();
    let depths = found.iter().map(|(.., depth)| *depth).collect();
    Ok((image(py, maps, [n])?, image(py, places, [n, 2])?, image(py, depths, [n])?))
}
