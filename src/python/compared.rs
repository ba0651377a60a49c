//! Which depths a lookup compares: where pixels lie in their maps, and the biased depth of each.

use glam::{DVec2, DVec3};
use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArrayDyn};
use pyo3::prelude::*;

use super::arguments::whole;
use super::bias::bias;
use super::camera::{PyCamera, camera};
use super::convert::{OrRaise, argument_error, array, image, run_watched};
use super::filter::unwarned_blend;
use super::gbuffer::{PyGBuffer, gbuffer};
use super::light::light;
use super::mask_settings::settings_of;
use super::parameterization::as_parameterization;
use super::stored::stored;
use crate::image::Footprint;
use crate::render::cpu::lookup::{Comparison, Lookups};
use crate::render::{Bias, Filter, MaskSettings, Stored, Tap};
use crate::scene::Light;

/// What pixels are compared with: the map (N,) int16, as `Footprint.map`; the place in it (N, 2) float64, texels; the biased depth
/// at the texel that it falls into (N,) float64, NaN where the pixel is lit without a look at the map; then the texels that are
/// read, (N, T, 2) int64, held to the map, their weights (N, T) float64, 0 behind a pixel's last, and the biased depth that each
/// is compared with (N, T) float64, NaN as before and where there is no texel. `map` is the index of a map that is asked in place
/// of the one that a pixel chooses.
#[pyfunction]
#[pyo3(signature = (gbuffer, camera, light, parameterization, pixels, *, resolution=None, bias=None, filter=None, stored=None,
    map=None),
    text_signature = "(gbuffer, camera, light, parameterization, pixels, *, resolution=None, bias=None, filter='nearest', \
                      stored=None, map=None)")]
#[allow(clippy::too_many_arguments)]
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
    map: Option<&Bound<'py, PyAny>>,
) -> PyResult<Compared<'py>> {
    let py = parameterization.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let settings = settings_of(py, p, resolution, gbuffer.get().whole_picture(), (bias, filter, None, stored))?;
    let camera = &camera.get().camera;
    let maps = [0, p.partitions.len() as i64 - 1];
    let map = map.map(|k| whole(k, "map", maps, "count maps from 0")).transpose()?.map(|k| k as usize);
    let pixels = array::<i64>(pixels, "pixels", &[None, Some(2)])?;
    let (pixels, width) = (pixels_of(py, &pixels, gbuffer.get())?, i64::from(gbuffer.get().picture()[0]));
    let found = gbuffer.get().with_surfaces(py, |surfaces| {
        run_watched(py, None, |progress| {
            let lookups = Lookups::new(p, camera, &light, surfaces.origin, &settings)?;
            let mut found = Vec::with_capacity(pixels.len());
            for [x, y] in pixels {
                progress.check()?;
                found.push(match surfaces.receiver((y * width + x) as usize) {
                    Some((point, normal)) => {
                        let p_world = surfaces.origin + point;
                        match light.illuminates(p_world, normal) {
                            false => One::without(Footprint::AVERTED),
                            true => match map.or_else(|| lookups.choose(point, camera.depth_of(p_world))) {
                                Some(k) => One::new(&lookups, k, point, normal),
                                None => One::without(Footprint::NO_MAP),
                            },
                        }
                    }
                    None => One::without(Footprint::NOTHING),
                });
            }
            Ok(found)
        })
    })?;
    let (n, most) = (found.len(), found.iter().map(|one| one.taps.len()).max().unwrap_or(0));
    let [last_x, last_y] = settings.resolution.map(|side| i64::from(side) - 1);
    let held = |[x, y]: [i64; 2]| [x.clamp(0, last_x), y.clamp(0, last_y)];
    let (mut texels, mut weights, mut depths) = (vec![0; 2 * n * most], vec![0.0; n * most], vec![f64::NAN; n * most]);
    for (one, first) in found.iter().zip((0..).step_by(most.max(1))) {
        for (i, (tap, depth)) in (first..).zip(&one.taps) {
            texels[2 * i..2 * i + 2].copy_from_slice(&held(tap.texel));
            (weights[i], depths[i]) = (tap.weight, *depth);
        }
    }
    let maps = found.iter().map(|one| one.map).collect();
    let places = found.iter().flat_map(|one| one.place).collect();
    let own = found.iter().map(|one| one.depth).collect();
    let (texels, weights) = (image(py, texels, [n, most, 2])?, image(py, weights, [n, most])?);
    let (maps, places, own) = (image(py, maps, [n])?, image(py, places, [n, 2])?, image(py, own, [n])?);
    Ok((maps, places, own, texels, weights, image(py, depths, [n, most])?))
}

/// The pixels (N, 2) of an array, if they lie in the picture.
fn pixels_of<'a>(py: Python<'_>, pixels: &'a PyReadonlyArrayDyn<'_, i64>, of: &PyGBuffer) -> PyResult<&'a [[i64; 2]]> {
    let (pixels, _) = pixels.as_slice()?.as_chunks::<2>();
    let [width, height] = of.picture().map(i64::from);
    let Some([x, y]) = pixels.iter().find(|[x, y]| !((0..width).contains(x) && (0..height).contains(y))) else {
        return Ok(pixels);
    };
    let expected = format!("columns and rows of a picture of {width} x {height} pixels");
    Err(argument_error(py, "pixels", expected, format!("({x}, {y})"), "count from 0 at the upper left"))
}

/// The map whose light is mixed in at each pixel, (N,) int16, -1 for none, and its share (N,) float64.
#[pyfunction]
#[allow(clippy::type_complexity)]
pub fn blended<'py>(
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: Light,
    parameterization: &Bound<'py, PyAny>,
    pixels: &Bound<'py, PyAny>,
    blend: &Bound<'py, PyAny>,
) -> PyResult<(Bound<'py, PyArray1<i16>>, Bound<'py, PyArray1<f64>>)> {
    let py = parameterization.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let (camera, blend) = (&camera.get().camera, unwarned_blend(py, Some(blend))?);
    let pixels = array::<i64>(pixels, "pixels", &[None, Some(2)])?;
    let (pixels, width) = (pixels_of(py, &pixels, gbuffer.get())?, i64::from(gbuffer.get().picture()[0]));
    // Where maps blend depends on neither of the others.
    let (bias, filter, stored) = (Bias::default(), Filter::Nearest, Stored::default());
    let settings =
        MaskSettings { resolution: p.resolution, size: gbuffer.get().whole_picture(), bias, filter, blend, stored };
    let (maps, shares): (Vec<i16>, Vec<f64>) = gbuffer.get().with_surfaces(py, |surfaces| {
        let lookups = Lookups::new(p, camera, &light, surfaces.origin, &settings).or_raise(py)?;
        let one = |[x, y]: &[i64; 2]| {
            let (point, normal) = surfaces.receiver((y * width + x) as usize)?;
            let p_world = surfaces.origin + point;
            let depth = camera.depth_of(p_world);
            let chosen = lookups.choose(point, depth).filter(|_| light.illuminates(p_world, normal))?;
            lookups.next(chosen, point, depth)
        };
        let found = pixels.iter().map(|pixel| one(pixel).map_or((-1, 0.0), |next| (next.map as i16, next.share)));
        Ok(found.unzip())
    })?;
    let n = maps.len();
    Ok((image(py, maps, [n])?, image(py, shares, [n])?))
}

type Compared<'py> = (
    Bound<'py, PyArray1<i16>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray3<i64>>,
    Bound<'py, PyArray2<f64>>,
    Bound<'py, PyArray2<f64>>,
);

/// How one pixel is compared.
struct One {
    map: i16,
    place: [f64; 2],
    /// At the texel that it falls into.
    depth: f64,
    /// Those that are read, each with its depth.
    taps: Vec<(Tap, f64)>,
}

impl One {
    fn without(map: i16) -> Self {
        Self { map, place: [f64::NAN; 2], depth: f64::NAN, taps: Vec::new() }
    }
    fn new(lookups: &Lookups, k: usize, point: DVec3, normal: DVec3) -> Self {
        let map = lookups.map(k);
        let (place, depth, taps) = match map.compare_at(point, normal) {
            Comparison::At(at) => {
                let depth = |tap: &Tap| map.depth_at(&at, DVec2::new(tap.texel[0] as f64, tap.texel[1] as f64) + 0.5);
                let own = map.depth_at(&at, at.p_texel.floor() + 0.5);
                (Some(at.p_texel), own, map.taps(&at).into_iter().map(|tap| (tap, depth(&tap))).collect())
            }
            Comparison::Lit => {
                let place = map.place_of(point);
                let taps = place.map_or(Vec::new(), |place| map.taps_at(point, normal, place));
                (place, f64::NAN, taps.into_iter().map(|tap| (tap, f64::NAN)).collect())
            }
        };
        Self { map: k as i16, place: place.map_or([f64::NAN; 2], |at| at.to_array()), depth, taps }
    }
}
