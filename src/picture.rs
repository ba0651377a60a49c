//! The eye view of a neutral material under a light and a hemisphere of sky, as colours.

use crate::image::Surfaces;
use crate::simd::dispatch;

/// Pixels that are worked on at once, in planes that a core keeps near.
const RUN: usize = 32;

/// What all pixels share.
#[derive(Debug, Clone, Copy)]
pub struct Material<'a> {
    /// Linear light of each channel: of a face that looks down, what is added to that of one that looks up, and what the
    /// light adds where it arrives in full.
    pub parts: [[f32; 3]; 3],
    /// The bytes of linear light from 0 to 1, in even steps.
    pub coded: &'a [u8],
}

/// The unit way that the light travels.
#[derive(Debug, Clone, Copy)]
pub enum Way<'a> {
    /// Of a light at infinity.
    Everywhere([f32; 3]),
    /// At each pixel.
    Each(&'a [[f32; 3]]),
}

/// The colours of all pixels under a mask, the share of the light that arrives; of pixels that see nothing those of the
/// sky, one for each row. Lists have a value for each pixel.
///
/// # Panics
/// Where they have not, or the material has no coded bytes.
pub fn shaded(surfaces: &Surfaces, way: Way, mask: &[f32], material: &Material, sky: &[[u8; 3]]) -> Vec<[u8; 3]> {
    let width = surfaces.size[0] as usize;
    let mut picture = vec![[0; 3]; mask.len()];
    for (y, row) in picture.chunks_mut(width.max(1)).enumerate() {
        let pixels = y * width..y * width + row.len();
        let way = match way {
            Way::Everywhere(way) => Way::Everywhere(way),
            Way::Each(ways) => Way::Each(&ways[pixels.clone()]),
        };
        let (normals, triangles) = (&surfaces.normal[pixels.clone()], &surfaces.triangle[pixels.clone()]);
        shade_row(normals, triangles, way, &mask[pixels], material, sky[y], row);
    }
    picture
}

dispatch! {
    /// Writes the colours of a row.
    fn shade_row(
        normals: &[[f32; 3]],
        triangles: &[i32],
        way: Way,
        mask: &[f32],
        material: &Material,
        sky: [u8; 3],
        row: &mut [[u8; 3]],
    ) = row_body
}

#[inline(always)]
fn row_body(
    normals: &[[f32; 3]],
    triangles: &[i32],
    way: Way,
    mask: &[f32],
    material: &Material,
    sky: [u8; 3],
    row: &mut [[u8; 3]],
) {
    let (mut normal, mut along, mut arrives, mut steps) = ([[0.0; 3]; RUN], [[0.0; 3]; RUN], [0.0; RUN], [[0; RUN]; 3]);
    if let Way::Everywhere(way) = way {
        along = [way; RUN];
    }
    let (last, parts) = ((material.coded.len() - 1) as f32, material.parts);
    let coded =
        |[r, g, b]: [i32; 3]| [material.coded[r as usize], material.coded[g as usize], material.coded[b as usize]];
    for first in (0..row.len()).step_by(RUN) {
        let pixels = first..row.len().min(first + RUN);
        let count = pixels.len();
        normal[..count].copy_from_slice(&normals[pixels.clone()]);
        arrives[..count].copy_from_slice(&mask[pixels.clone()]);
        if let Way::Each(ways) = way {
            along[..count].copy_from_slice(&ways[pixels.clone()]);
        }
        for i in 0..RUN {
            let ([x, y, z], [a, b, c]) = (normal[i], along[i]);
            let cosine = unit(-(x * a + y * b + z * c));
            // Of pixels that are not looked up NaN.
            let arrives = cosine * if arrives[i].is_nan() { 0.0 } else { arrives[i].clamp(f32::MIN, f32::MAX) };
            let upward = 0.5 + 0.5 * y;
            for channel in 0..3 {
                let (flat, rise, sun) = (parts[0][channel], parts[1][channel], parts[2][channel]);
                steps[channel][i] = (unit(flat + rise * upward + sun * arrives) * last + 0.5) as i32;
            }
        }
        for (i, (colour, triangle)) in row[pixels.clone()].iter_mut().zip(&triangles[pixels]).enumerate() {
            *colour = if *triangle >= 0 { coded([steps[0][i], steps[1][i], steps[2][i]]) } else { sky };
        }
    }
}

/// The value between 0 and 1 nearest to it; 0 for what is no number.
#[inline(always)]
fn unit(value: f32) -> f32 {
    let value = if value > 0.0 { value } else { 0.0 };
    if value < 1.0 { value } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn each_pixel_has_the_colour_of_its_own_surface_light_and_row() {
        // More than two runs, and a part of one.
        let size = [2 * RUN as u32 + 3, 3];
        let n = (size[0] * size[1]) as usize;
        let normal: Vec<[f32; 3]> =
            (0..n).map(|i| if i % 5 == 0 { [0.0, 1.0, 0.0] } else { [0.6, 0.0, 0.8] }).collect();
        let triangle: Vec<i32> = (0..n).map(|i| if i % 7 == 3 { -1 } else { 1 }).collect();
        let mask: Vec<f32> = (0..n).map(|i| [0.0, 0.5, 1.0, f32::NAN][i % 4]).collect();
        let (position, instance) = (vec![[0.0; 3]; n], vec![0; n]);
        let surfaces = Surfaces {
            size,
            origin: DVec3::ZERO,
            position: &position,
            normal: &normal,
            triangle: &triangle,
            instance: &instance,
        };
        let coded: Vec<u8> = (0..=255).collect();
        let parts = [[0.1, 0.2, 0.3], [0.2, 0.2, 0.1], [0.5, 0.9, 0.4]];
        let material = Material { parts, coded: &coded };
        let sky = [[1, 2, 3], [4, 5, 6], [7, 8, 9]];
        let way = [0.0, -0.6, -0.8];
        let ways: Vec<[f32; 3]> = (0..n).map(|i| if i % 2 == 0 { way } else { [0.0, 0.6, -0.8] }).collect();
        for way_of in [Way::Everywhere(way), Way::Each(&ways)] {
            let picture = shaded(&surfaces, way_of, &mask, &material, &sky);
            for i in 0..n {
                let way = if let Way::Each(ways) = way_of { ways[i] } else { way };
                let cosine = -(0..3).map(|k| f64::from(normal[i][k] * way[k])).sum::<f64>();
                let arrives = cosine.clamp(0.0, 1.0) * if mask[i].is_nan() { 0.0 } else { f64::from(mask[i]) };
                let expected = [0, 1, 2].map(|c| {
                    let [flat, rise, sun] = parts.map(|part| f64::from(part[c]));
                    let up = 0.5 + 0.5 * f64::from(normal[i][1]);
                    ((flat + rise * up + sun * arrives).clamp(0.0, 1.0) * 255.0).round()
                });
                let row = i / size[0] as usize;
                let expected = if triangle[i] < 0 { sky[row].map(f64::from) } else { expected };
                // Single precision may round a half the other way.
                let apart = [0, 1, 2].map(|c| (expected[c] - f64::from(picture[i][c])).abs());
                assert!(apart.iter().all(|d| *d <= 1.0), "{i}: {:?} and {expected:?}", picture[i]);
            }
        }
    }
}
