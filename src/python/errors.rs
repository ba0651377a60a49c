//! Lookups into maps that are there, where they lie, and why pixels are wrong.

use glam::DVec3;
use numpy::{PyArray2, PyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use rayon::prelude::*;

use super::camera::{PyCamera, camera};
use super::convert::{OrRaise, argument_error, array, image, run_watched, size2};
use super::gbuffer::{PyGBuffer, gbuffer};
use super::light::light;
use super::parameterization::as_parameterization;
use super::render::{bias, filter_of};
use super::scene::{PyScene, scene};
use crate::aliasing::causes::{Blocker, Probe, cause, cause_of, displacement};
use crate::aliasing::usage;
use crate::image::Surfaces;
use crate::progress::Progress;
use crate::render::cpu::look_up as core_look_up;
use crate::render::cpu::lookup::Lookups;
use crate::render::{Bias, MaskSettings};
use crate::scene::Light;
use crate::trace::{FirstLit, Hit};

/// Where each pixel's receiver lies in its map: (H, W, 2) float64 and (H, W) int16.
#[pyfunction]
#[pyo3(signature = (gbuffer, camera, light, parameterization, *, resolution=None))]
#[allow(clippy::type_complexity)]
pub fn texel_coordinates<'py>(
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: Light,
    parameterization: &Bound<'py, PyAny>,
    resolution: Option<&Bound<'py, PyAny>>,
) -> PyResult<(Bound<'py, PyArray3<f64>>, Bound<'py, PyArray2<i16>>)> {
    let py = parameterization.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let resolution = resolution.map_or(Ok([p.resolution; 2]), |r| size2(r, "resolution"))?;
    let camera = &camera.get().camera;
    let (located, size) = gbuffer.get().with_surfaces(py, |surfaces| {
        let work = |progress: &_| usage::locate(surfaces, camera, &light, p, resolution, progress);
        Ok((run_watched(py, None, work)?, surfaces.size))
    })?;
    let [w, h] = size.map(|n| n as usize);
    Ok((image(py, located.texel.into_flattened(), [h, w, 2])?, image(py, located.map, [h, w])?))
}

/// How many pixels read each texel: (K, H, W) uint32.
#[pyfunction]
#[pyo3(signature = (gbuffer, camera, light, parameterization, *, resolution=None, filter="nearest"))]
pub fn reads<'py>(
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: Light,
    parameterization: &Bound<'py, PyAny>,
    resolution: Option<&Bound<'py, PyAny>>,
    filter: &str,
) -> PyResult<Bound<'py, PyArray3<u32>>> {
    let py = parameterization.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let resolution = resolution.map_or(Ok([p.resolution; 2]), |r| size2(r, "resolution"))?;
    let taps = (2.0 * filter_of(py, filter)?.reach_texels()) as u32;
    let camera = &camera.get().camera;
    let layers = p.partitions.len();
    let counts = gbuffer.get().with_surfaces(py, |surfaces| {
        run_watched(py, None, |progress| {
            let located = usage::locate(surfaces, camera, &light, p, resolution, progress)?;
            usage::reads(&located, layers, resolution, taps)
        })
    })?;
    let [w, h] = resolution.map(|n| n as usize);
    image(py, counts, [layers, h, w])
}

/// The shadow mask of surfaces through maps that are there: (H, W) float32, and which map each pixel asks (H, W) int16.
#[pyfunction]
#[pyo3(signature = (maps, gbuffer, camera, light, parameterization, *, bias=None, filter="nearest"))]
#[allow(clippy::type_complexity)]
pub fn look_up<'py>(
    maps: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: Light,
    parameterization: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = bias)] bias: Option<Bias>,
    filter: &str,
) -> PyResult<(Bound<'py, PyArray2<f32>>, Bound<'py, PyArray2<i16>>)> {
    let py = maps.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let (maps, resolution) = layers(maps, p.partitions.len())?;
    let maps = maps.as_slice()?;
    let camera = &camera.get().camera;
    let filter = filter_of(py, filter)?;
    let mask = gbuffer.get().with_surfaces(py, |surfaces| {
        let settings = MaskSettings { resolution, size: surfaces.size, bias: bias.unwrap_or_default(), filter };
        run_watched(py, None, |progress| core_look_up(maps, *surfaces, camera, &light, p, &settings, progress))
    })?;
    let [w, h] = mask.size.map(|n| n as usize);
    Ok((image(py, mask.data, [h, w])?, image(py, mask.partition, [h, w])?))
}

/// Why pixels are wrong: (H, W) int8 causes, and (H, W) float32 the distance in pixels to the nearest pixel whose truth is
/// what the map says; see `shadowlab.aliasing.causes`.
#[pyfunction]
#[pyo3(signature = (scene, camera, light, parameterization, differences, truth, *, gbuffer, maps, bias=None, filter="nearest"))]
#[allow(clippy::too_many_arguments, clippy::type_complexity)]
pub fn causes<'py>(
    #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
    #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
    #[pyo3(from_py_with = light)] light: Light,
    parameterization: &Bound<'py, PyAny>,
    differences: &Bound<'py, PyAny>,
    truth: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = gbuffer)] gbuffer: Bound<'py, PyGBuffer>,
    maps: &Bound<'py, PyAny>,
    #[pyo3(from_py_with = bias)] bias: Option<Bias>,
    filter: &str,
) -> PyResult<(Bound<'py, PyArray2<i8>>, Bound<'py, PyArray2<f32>>)> {
    let py = maps.py();
    let p = as_parameterization(parameterization)?;
    let p = &p.get().p;
    let (maps, resolution) = layers(maps, p.partitions.len())?;
    let maps = maps.as_slice()?;
    let filter = filter_of(py, filter)?;
    let (camera, scene) = (&camera.get().camera, scene.get());
    gbuffer.get().with_surfaces(py, |surfaces| {
        let [w, h] = surfaces.size.map(|n| n as usize);
        let differences = array::<i8>(differences, "differences", &[Some(h), Some(w)])?;
        let truth = array::<i8>(truth, "truth", &[Some(h), Some(w)])?;
        let (differences, truth) = (differences.as_slice()?, truth.as_slice()?);
        let settings = MaskSettings { resolution, size: surfaces.size, bias: bias.unwrap_or_default(), filter };
        let lookups = &Lookups::new(p, &light, surfaces.origin, &settings).or_raise(py)?;
        let (causes, distance) = run_watched(py, None, |progress| {
            let wrong: Vec<usize> = (0..differences.len()).filter(|&i| differences[i] > 0).collect();
            let blockers = blockers(scene, surfaces, &light, &wrong, progress)?;
            let mut causes: Vec<i8> =
                differences.iter().map(|&d| cause_of(d.min(0), &Probe::default(), None)).collect();
            let found: Vec<i8> = wrong
                .par_iter()
                .zip(&blockers)
                .map(|(&i, blocker)| one_cause(lookups, maps, surfaces, camera, differences[i], i, *blocker))
                .collect();
            wrong.iter().zip(found).for_each(|(&i, cause)| causes[i] = cause);
            Ok((causes, displacement(surfaces, &light, differences, truth)))
        })?;
        Ok((image(py, causes, [h, w])?, image(py, distance, [h, w])?))
    })
}

/// The maps as (K, H, W) or, of one, (H, W), with their width and height.
fn layers<'py>(maps: &Bound<'py, PyAny>, count: usize) -> PyResult<(numpy::PyReadonlyArrayDyn<'py, f32>, [u32; 2])> {
    let found = match count {
        1 => {
            array::<f32>(maps, "maps", &[None, None]).or_else(|_| array::<f32>(maps, "maps", &[Some(1), None, None]))?
        }
        _ => array::<f32>(maps, "maps", &[Some(count), None, None])?,
    };
    let shape = found.shape();
    let sides = [shape[shape.len() - 1], shape[shape.len() - 2]];
    match sides.map(u32::try_from) {
        [Ok(w), Ok(h)] if w > 0 && h > 0 => Ok((found, [w, h])),
        _ => {
            let fix = "Renderer.shadow_map makes them";
            Err(argument_error(maps.py(), "maps", "at least one texel", format!("shape {:?}", shape), fix))
        }
    }
}

/// What the light meets first on its way to each of some pixels: how far before it, and where, relative to the surfaces'
/// origin; nothing where that is the receiver itself.
fn blockers(
    scene: &PyScene,
    surfaces: &Surfaces,
    light: &Light,
    pixels: &[usize],
    progress: &Progress,
) -> crate::Result<Vec<Option<(f64, DVec3)>>> {
    let world = |&i: &usize| surfaces.origin + surfaces.receiver(i).unwrap_or_default().0;
    let points: Vec<DVec3> = pixels.iter().map(world).collect();
    let found = scene.tracer(progress)?.first_from_light(light, &points, progress)?;
    let blocker = |(&i, first): (&usize, &FirstLit)| {
        let Hit { triangle, instance, .. } = first.hit;
        // What a G-buffer calls a triangle is the row of the face array it was made from.
        let row = || scene.scene.mesh_of(instance as usize).source_face(triangle as usize) as i32;
        let is_other = || (instance, row()) != (surfaces.instance[i], surfaces.triangle[i]);
        (triangle >= 0 && first.before > 0.0 && is_other()).then(|| (first.before, first.at - surfaces.origin))
    };
    Ok(pixels.iter().zip(&found).map(blocker).collect())
}

/// The cause of one wrong pixel.
fn one_cause(
    lookups: &Lookups,
    maps: &[f32],
    surfaces: &Surfaces,
    camera: &crate::Camera,
    error: i8,
    pixel: usize,
    blocker: Option<(f64, DVec3)>,
) -> i8 {
    let Some((p_local, normal)) = surfaces.receiver(pixel) else { return cause::EDGE };
    let chosen = lookups.choose(p_local, camera.depth_of(surfaces.origin + p_local));
    let Some(k) = chosen else {
        return cause_of(error, &Probe::default(), blocker.map(|b| Blocker { distance: b.0, is_in_map: false }));
    };
    let texels = lookups.texels();
    let probe = lookups.map(k).probe(&maps[k * texels..(k + 1) * texels], p_local, normal);
    let blocker = blocker.map(|(distance, at)| Blocker { distance, is_in_map: lookups.map(k).holds_depth(at) });
    cause_of(error, &probe, blocker)
}
