//! Where meshes end: edges of one face only.

use std::collections::HashMap;

use glam::Vec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::progress::Progress;

/// Faces between two looks at whether to go on: about a millisecond of work.
const AT_ONCE: usize = 1 << 14;

/// How many edges of some triangles belong to one of them only. Corners at equal places are one corner; triangles of which two
/// corners are one have no edge that counts.
///
/// # Errors
/// [`crate::Error::Interrupted`].
pub fn border_edges(positions: &[Vec3], triangles: &[[u32; 3]], progress: &Progress) -> Result<usize> {
    let mut first_at: HashMap<[u32; 3], u32> = HashMap::with_capacity(positions.len());
    let mut corner = Vec::with_capacity(positions.len());
    for (chunk, some) in positions.chunks(AT_ONCE).enumerate() {
        progress.check()?;
        for (i, p) in some.iter().enumerate() {
            // 0 and -0 are one place.
            let place = (*p + Vec3::ZERO).to_array().map(f32::to_bits);
            corner.push(*first_at.entry(place).or_insert((chunk * AT_ONCE + i) as u32));
        }
    }
    let mut edges: Vec<u64> = Vec::with_capacity(3 * triangles.len());
    for some in triangles.chunks(AT_ONCE) {
        progress.check()?;
        for triangle in some {
            let [a, b, c] = triangle.map(|i| corner[i as usize]);
            if a != b && b != c && c != a {
                edges.extend([[a, b], [b, c], [c, a]].map(|[a, b]| u64::from(a.min(b)) << 32 | u64::from(a.max(b))));
            }
        }
    }
    edges.par_sort_unstable();
    progress.check()?;
    Ok(edges.chunk_by(|a, b| a == b).filter(|uses| uses.len() == 1).count())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

    #[test]
    fn edges_of_one_face_are_counted() {
        let at = |x: f32, y: f32, z: f32| Vec3::new(x, y, z);
        // A tetrahedron whose faces have corners of their own, one of them at -0.
        let p = [at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(0.0, 1.0, 0.0), at(0.0, 0.0, 1.0)];
        let faces = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mut corners: Vec<Vec3> = faces.iter().flat_map(|f| f.map(|i: usize| p[i])).collect();
        corners[0] = at(-0.0, 0.0, -0.0);
        let apart: Vec<[u32; 3]> = (0..4).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let count = |triangles: &[[u32; 3]]| border_edges(&corners, triangles, &Progress::new()).unwrap();
        assert_eq!((count(&apart), count(&apart[..3]), count(&apart[..1]), count(&[])), (0, 3, 3, 0));
        assert_eq!(count(&[[0, 3, 1]]), 0, "a face of two places has no edge");
        let stopped = Progress::new();
        stopped.stop();
        assert_eq!(border_edges(&corners, &apart, &stopped), Err(Error::Interrupted));
    }
}
