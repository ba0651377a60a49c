//! The eye view as colours.

use glam::DVec3;
use numpy::{PyArray3, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;

use super::convert::{array, image, rows3};
use crate::image::Surfaces;
use crate::picture::{Material, Way, shaded};

/// The eye view (H, W, 3) uint8 of normals (H, W, 3) float32 and triangles (H, W) int32 under a mask (H, W) float32; see
/// `shadowlab.pictures.eye.shade`.
///
/// Ways that the light travels (1, 1, 3) or (H, W, 3) float32; linear light (3, 3) float32 of each channel, of a face that
/// looks down, what one adds that looks up, and what the light adds; the sky (H, 3) uint8; the bytes (65536,) uint8 of linear
/// light from 0 to 1.
#[pyfunction]
#[pyo3(signature = (normal, triangle, mask, *, ways, material, sky, coded))]
pub fn shade<'py>(
    normal: &Bound<'py, PyAny>,
    triangle: &Bound<'py, PyAny>,
    mask: &Bound<'py, PyAny>,
    ways: &Bound<'py, PyAny>,
    material: &Bound<'py, PyAny>,
    sky: &Bound<'py, PyAny>,
    coded: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArray3<u8>>> {
    let py = mask.py();
    let normal = array::<f32>(normal, "normal", &[None, None, Some(3)])?;
    let (h, w) = (normal.shape()[0], normal.shape()[1]);
    let triangle = array::<i32>(triangle, "triangle", &[Some(h), Some(w)])?;
    let mask = array::<f32>(mask, "mask", &[Some(h), Some(w)])?;
    let one: PyReadonlyArrayDyn<'_, f32> = array(ways, "ways", &[None, None, Some(3)])?;
    let is_one = one.shape()[..2] == [1, 1];
    let ways = if is_one { one } else { array(ways, "ways", &[Some(h), Some(w), Some(3)])? };
    let sky = array::<u8>(sky, "sky", &[Some(h), Some(3)])?;
    let parts = array::<f32>(material, "material", &[Some(3), Some(3)])?;
    let coded = array::<u8>(coded, "coded", &[Some(1 << 16)])?;
    // What else surfaces have is not looked at.
    let (normal, triangle, size) = (rows3(&normal)?, triangle.as_slice()?, [w as u32, h as u32]);
    let surfaces = Surfaces { size, origin: DVec3::ZERO, position: &[], normal, triangle, instance: &[] };
    let (mask, ways, sky, parts) = (mask.as_slice()?, rows3(&ways)?, rows3(&sky)?, rows3(&parts)?);
    let material = Material { parts: [parts[0], parts[1], parts[2]], coded: coded.as_slice()? };
    let way = if is_one { Way::Everywhere(ways[0]) } else { Way::Each(ways) };
    let picture = py.detach(|| shaded(&surfaces, way, mask, &material, sky));
    image(py, picture.into_flattened(), [h, w, 3])
}
