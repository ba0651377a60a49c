//! States of samples: what they store, as arrays.
//!
//! ```text
//! head     origin; 1 and camera and size, or 0; 1 and the kind of light and the light, or 0
//! arrays   points (N, 3) f32   normals (N, 3) f32   states (N or 0,) i8
//!          samples at edges (M,) u32   their normals (M, 2) f32   weights (M,) f32
//!          shaded samples (K,) u32     states of pixels (P or 0,) i8
//! ```

use pyo3::prelude::*;

use super::arrays::borrowed;
use super::camera::PyCamera;
use super::convert::{SOON, image, run_parallel};
use super::light::{PyDirectionalLight, PyPointLight, PySpotLight};
use super::state::{Fault, OTHER_SEAL, Parts, Reader, State, Writer, seal};
use crate::digest::{Digest, Numbers};
use crate::error::Result;
use crate::focus::{EdgeSample, Picture, Samples, Shadows};
use crate::progress::Progress;
use crate::render::MAX_IMAGE_SIDE;
use crate::scene::Light;

/// The class.
pub const NAME: &str = "Samples";
/// What is written now.
pub const VERSION: u32 = 1;
const ARRAYS: usize = 8;

/// The scalars.
pub fn head_of(samples: &Samples, numbers: Numbers) -> Writer {
    let mut head = Writer::new(numbers);
    head.vector(samples.origin);
    head.kind(u8::from(samples.picture.is_some()));
    if let Some(picture) = &samples.picture {
        PyCamera { camera: picture.camera }.write(&mut head);
        picture.size.iter().for_each(|&n| head.count(u64::from(n)));
    }
    match samples.shadows.as_ref().map(|shadows| &shadows.light) {
        None => head.kind(0),
        Some(Light::Directional(light)) => {
            head.kind(1);
            PyDirectionalLight { light: *light }.write(&mut head);
        }
        Some(Light::Spot(light)) => {
            head.kind(2);
            PySpotLight { light: *light }.write(&mut head);
        }
        Some(Light::Point(light)) => {
            head.kind(3);
            PyPointLight { light: *light }.write(&mut head);
        }
    }
    head
}

fn read_head(from: &mut Reader<'_>) -> std::result::Result<(glam::DVec3, Option<Picture>, Option<Light>), Fault> {
    let origin = from.vector()?;
    let picture = match from.kind()? {
        0 => None,
        _ => {
            let camera = PyCamera::read(from).map_err(|_| "its camera is damaged")?.camera;
            let size = [from.count()?, from.count()?];
            if !size.iter().all(|n| (1..=MAX_IMAGE_SIDE).contains(n)) {
                return Err(format!("its picture has {size:?} pixels"));
            }
            Some(Picture::new(&camera, size))
        }
    };
    let light = match from.kind()? {
        0 => None,
        1 => Some(Light::Directional(PyDirectionalLight::read(from)?.light)),
        2 => Some(Light::Spot(PySpotLight::read(from)?.light)),
        3 => Some(Light::Point(PyPointLight::read(from)?.light)),
        other => return Err(format!("its light is of the kind {other}")),
    };
    Ok((origin, picture, light))
}

/// The digest of all of them.
pub fn sealed(samples: &Samples, numbers: Numbers, progress: &Progress) -> Result<[u8; 32]> {
    seal(NAME, VERSION, head_of(samples, numbers).bytes(), |digest| add(samples, digest, progress))
}

/// What equal samples share: numbers as numbers, and NaN to NaN.
pub fn identity(samples: &Samples, progress: &Progress) -> Result<[u8; 32]> {
    let mut digest = Digest::new(NAME, Numbers::Equal);
    digest.list(head_of(samples, Numbers::Equal).bytes());
    add(samples, &mut digest, progress)?;
    Ok(digest.finish())
}

fn add(samples: &Samples, digest: &mut Digest, progress: &Progress) -> Result<()> {
    let check = || progress.check();
    digest.watched_list(samples.points.as_flattened(), check)?;
    digest.watched_list(samples.normals.as_flattened(), check)?;
    if let Some(shadows) = &samples.shadows {
        digest.watched_list(&shadows.states, check)?;
        digest.list(&shadows.edges.iter().map(|e| e.sample).collect::<Vec<_>>());
        digest.list(&shadows.edges.iter().flat_map(|e| e.normal).collect::<Vec<_>>());
        digest.list(&shadows.edges.iter().map(|e| e.weight).collect::<Vec<_>>());
        digest.watched_list(&shadows.shaded, check)?;
        digest.watched_list(&shadows.image, check)?;
    }
    Ok(())
}

/// The arrays.
pub fn arrays_of<'py>(py: Python<'py>, samples: &Samples) -> PyResult<Vec<Bound<'py, PyAny>>> {
    let rows = |list: &Vec<[f32; 3]>| -> PyResult<Bound<'py, PyAny>> {
        Ok(image(py, list.as_flattened().to_vec(), [list.len(), 3])?.into_any())
    };
    let shadows = samples.shadows.as_ref();
    let edges = shadows.map_or(&[][..], |shadows| &shadows.edges);
    let states = shadows.map_or_else(Vec::new, |shadows| shadows.states.clone());
    let shaded = shadows.map_or_else(Vec::new, |shadows| shadows.shaded.clone());
    let pixels = shadows.map_or_else(Vec::new, |shadows| shadows.image.clone());
    let (n, m, k, p) = (states.len(), edges.len(), shaded.len(), pixels.len());
    Ok(vec![
        rows(&samples.points)?,
        rows(&samples.normals)?,
        image(py, states, [n])?.into_any(),
        image(py, edges.iter().map(|e| e.sample).collect(), [m])?.into_any(),
        image(py, edges.iter().flat_map(|e| e.normal).collect(), [m, 2])?.into_any(),
        image(py, edges.iter().map(|e| e.weight).collect(), [m])?.into_any(),
        image(py, shaded, [k])?.into_any(),
        image(py, pixels, [p])?.into_any(),
    ])
}

/// The ones of a state.
pub fn restored<'py>(py: Python<'py>, parts: &Parts<'py>) -> PyResult<Samples> {
    parts.check(py, VERSION, ARRAYS)?;
    let (origin, picture, light) = parts.read(py, read_head)?;
    let rows = |i: usize| -> PyResult<Vec<[f32; 3]>> {
        Ok(borrowed::<f32>(py, parts, i, &[None, Some(3)])?.as_slice()?.as_chunks::<3>().0.to_vec())
    };
    let (points, normals) = (rows(0)?, rows(1)?);
    let n = points.len();
    let states = borrowed::<i8>(py, parts, 2, &[None])?.as_slice()?.to_vec();
    let samples = borrowed::<u32>(py, parts, 3, &[None])?.as_slice()?.to_vec();
    let m = Some(samples.len());
    let edge_normals = borrowed::<f32>(py, parts, 4, &[m, Some(2)])?.as_slice()?.as_chunks::<2>().0.to_vec();
    let weights = borrowed::<f32>(py, parts, 5, &[m])?.as_slice()?.to_vec();
    let shaded = borrowed::<u32>(py, parts, 6, &[None])?.as_slice()?.to_vec();
    let pixels = borrowed::<i8>(py, parts, 7, &[None])?.as_slice()?.to_vec();
    let full = picture.map_or(0, |p| p.size[0] as usize * p.size[1] as usize);
    let fits = normals.len() == n
        && samples.iter().chain(&shaded).all(|&i| (i as usize) < n)
        && states.len() == if light.is_some() { n } else { 0 }
        && [0, full].contains(&pixels.len());
    if !fits {
        return Err(parts.error(py, "its arrays do not belong together"));
    }
    let mut found = Samples::default();
    (found.origin, found.points, found.normals, found.picture) = (origin, points.into(), normals.into(), picture);
    let zipped = samples.into_iter().zip(edge_normals).zip(weights);
    let edges = zipped.map(|((sample, normal), weight)| EdgeSample { sample, normal, weight }).collect();
    let known = light.map(|light| Shadows { light, states, edges, shaded, image: pixels });
    found.shadows = known;
    let sealed = parts.sealed();
    let restored = run_parallel(py, found.points.len() > SOON, |progress| {
        let is_whole = sealed.is_of(|digest| add(&found, digest, progress))?;
        Ok(is_whole.then(|| found.outlined()))
    })?;
    restored.ok_or_else(|| parts.error(py, OTHER_SEAL))
}
