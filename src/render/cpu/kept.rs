//! Which clusters of a placed mesh a pass looks at, and in which order: those outside of its volume have no triangle in it, and
//! the order of triangles has no say in what is drawn, so the map stays, bit for bit.

use std::ops::Range;

use glam::{DMat4, Vec3};

use crate::render::{PlacedVolume, Volume};
use crate::scene::{CLUSTER, Cluster, Mesh};

/// The clusters that are not outside.
#[derive(Debug, Clone)]
pub struct Kept<'a> {
    /// Vertices in the mesh's local frame.
    pub positions: &'a [Vec3],
    /// Indices into [`Kept::positions`], in the order in which triangles are looked at.
    pub triangles: &'a [[u32; 3]],
    /// Their numbers in the mesh; empty where that is the order of the mesh.
    pub numbers: &'a [u32],
    /// None where all of the mesh is looked at.
    boxes: &'a [Cluster],
    /// The box around the mesh.
    whole: [Vec3; 2],
    /// A bit for each cluster.
    clusters: Vec<u64>,
}

impl<'a> Kept<'a> {
    /// Those of a mesh that a matrix takes to the volume's clip space.
    pub fn new(mesh: &'a Mesh, clip_from_local: &DMat4, volume: &Volume) -> Self {
        let found = mesh.clusters();
        let (positions, triangles, numbers) = match found.sorted() {
            Some(sorted) => (&*sorted.positions, &*sorted.triangles, &*sorted.numbers),
            None => (mesh.positions_local(), mesh.triangles(), &[][..]),
        };
        let boxes = found.boxes();
        // Of f32 vertices, so exact.
        let whole = [mesh.bounds_local().min.as_vec3(), mesh.bounds_local().max.as_vec3()];
        if boxes.is_empty() {
            return Self { positions, triangles, numbers, boxes, whole, clusters: Vec::new() };
        }
        let volume = PlacedVolume::new(volume, clip_from_local);
        let mut clusters = vec![0; boxes.len().div_ceil(64)];
        for (i, cluster) in boxes.iter().enumerate() {
            clusters[i / 64] |= u64::from(!volume.excludes(cluster.min, cluster.max)) << (i % 64);
        }
        Self { positions, triangles, numbers, boxes, whole, clusters }
    }

    /// The number in the mesh of the triangle at a place.
    #[inline(always)]
    pub fn number(&self, place: u32) -> u32 {
        if self.numbers.is_empty() { place } else { self.numbers[place as usize] }
    }

    /// What is left of a range of places in [`Kept::triangles`], cluster by cluster.
    #[inline]
    pub fn runs(&self, places: Range<u32>) -> impl Iterator<Item = Range<u32>> {
        let whole = self.boxes.is_empty();
        let size = if whole { u32::MAX } else { CLUSTER as u32 };
        let clusters = places.start / size..places.end.div_ceil(size);
        clusters.filter(move |&i| whole || self.has(i as usize)).map(move |i| {
            let first = i.saturating_mul(size);
            places.start.max(first)..places.end.min(first.saturating_add(size))
        })
    }

    /// What is left, cluster by cluster, or all of a mesh without clusters.
    pub fn pieces(&self) -> impl Iterator<Item = Range<u32>> {
        self.runs(0..self.triangles.len() as u32)
    }

    /// Whether pieces are clusters of a large mesh.
    pub fn has_clusters(&self) -> bool {
        !self.boxes.is_empty()
    }

    /// The box around the piece that begins at a place.
    pub fn bounds(&self, place: u32) -> [Vec3; 2] {
        match self.boxes.get(place as usize / CLUSTER) {
            Some(cluster) => [cluster.min, cluster.max],
            None => self.whole,
        }
    }

    /// For each of some runs of so many vertices whether one of them may belong to a triangle that is left.
    pub fn vertices(&self, run: usize) -> Vec<bool> {
        let mut needed = vec![self.boxes.is_empty(); self.positions.len().div_ceil(run)];
        for (_, cluster) in self.boxes.iter().enumerate().filter(|(i, _)| self.has(*i)) {
            let vertices = cluster.vertices();
            needed[vertices.start / run..vertices.end.div_ceil(run)].fill(true);
        }
        needed
    }

    #[inline(always)]
    fn has(&self, cluster: usize) -> bool {
        self.clusters[cluster / 64] >> (cluster % 64) & 1 == 1
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    /// A strip of 2000 triangles along x, from -1 to 1 in its own frame, two of which take 1/500 of it.
    fn strip() -> Mesh {
        let vertices: Vec<[f64; 3]> = (0..2002).map(|i| [f64::from(i / 2), f64::from(i % 2), 0.0]).collect();
        Mesh::new(&vertices, &(0..2000).map(|i| [i, i + 1, i + 2]).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn runs_are_the_clusters_that_reach_into_the_volume() {
        let mesh = strip();
        let clip_from_local = DMat4::from_translation(DVec3::new(1.0, 0.0, 0.5));
        let kept = Kept::new(&mesh, &clip_from_local, &Volume::of_clip(&clip_from_local, 0.0));
        // The frame is 1024 long, twice the strip's half, so x of -0.98 to 0 is seen.
        let x = |triangle: u32| mesh.positions_local()[mesh.triangles()[triangle as usize][0] as usize].x;
        for range in [0..2000, 130..131, 100..300, 900..1200] {
            let runs: Vec<Range<u32>> = kept.runs(range.clone()).collect();
            assert!(runs.windows(2).all(|r| r[0].end <= r[1].start) && runs.iter().all(|r| !r.is_empty()));
            for i in range.clone() {
                let is_left = runs.iter().any(|r| r.contains(&i));
                assert!(is_left || x(i) > 0.0, "{i} of {range:?} is left out");
                assert!(!is_left || x(i) < 0.3, "{i} of {range:?} is kept");
            }
        }
        let needed = kept.vertices(10);
        assert!(needed[..100].iter().all(|n| *n) && !needed[130] && needed.len() == 201);
        let all = Volume::new(&clip_from_local, [glam::DVec4::W; 6]);
        let kept = Kept::new(&mesh, &clip_from_local, &all);
        assert_eq!(kept.runs(5..2000).map(|r| r.len()).sum::<usize>(), 1995);
        assert!(kept.vertices(10).iter().all(|n| *n));
    }

    #[test]
    fn small_meshes_are_one_run() {
        let mesh = Mesh::new(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]).unwrap();
        let far = DMat4::from_translation(DVec3::X * 9.0);
        let kept = Kept::new(&mesh, &far, &Volume::of_clip(&far, 0.0));
        assert!(kept.runs(0..1).eq(std::iter::once(0..1)));
        assert_eq!((kept.runs(0..0).count(), kept.vertices(4)), (0, vec![true]));
    }
}
