//! Runs of neighbouring triangles of a mesh with their boxes: what lies outside of a map is left out run by run, and what is drawn
//! one after the other lies side by side.
//!
//! Meshes mostly come in such an order. Of others (a subdivided sphere has the corners of all faces first) a copy is made along a
//! Z-order curve, Morton 1966 `[morton1966]`, with the vertices in the order of their first use: gathering them from all over the
//! mesh takes longer than all the rest of a small triangle. Triangles keep their numbers.

use glam::{Vec3, Vec3A};
use rayon::prelude::*;

/// Triangles of a cluster. Chosen by measurement: boxes of 64 leave out no more of a scene of 440,000 triangles.
pub const CLUSTER: usize = 128;
/// Least triangles of a mesh that has clusters: a smaller one is left out as a whole or is not worth the boxes.
const LEAST: usize = 8 * CLUSTER;
/// Faces of all boxes together, in those of the box around the mesh, up to which an order is taken for one of neighbours: clusters
/// that tile a surface have some two or three times its area.
const COHERENT: f32 = 8.0;
/// How much smaller the boxes of another order must be for it to be worth the copy.
const WORTH: f32 = 0.7;
/// Vertices for each triangle above which no copy is made: of a mesh whose triangles share none a copy would take 52 bytes a
/// triangle, and the vertices of a triangle lie side by side already.
const MOST_VERTICES: usize = 2;
/// Vertices of a block: which ones a cluster needs is known block by block. Chosen by counting: a cluster of a scene of 440,000
/// triangles has 95 vertices in 6 blocks, of which its neighbours need nearly all the rest.
pub const BLOCK: usize = 64;
/// Bits of a place along each axis in a Z-order code.
const CODE_BITS: u32 = 10;

/// The clusters of a mesh.
#[derive(Debug, Default)]
pub struct Clusters {
    boxes: Box<[Cluster]>,
    /// Those of each cluster, one after the other.
    blocks: Box<[u32]>,
    sorted: Option<Sorted>,
}

/// A mesh in the order of its clusters: 4 bytes a triangle more than the mesh itself takes.
#[derive(Debug)]
pub struct Sorted {
    /// Vertices in the local frame.
    pub positions: Box<[Vec3]>,
    /// Indices into [`Sorted::positions`].
    pub triangles: Box<[[u32; 3]]>,
    /// Their numbers in the mesh.
    pub numbers: Box<[u32]>,
}

/// A box in the mesh's local frame around [`CLUSTER`] triangles, or around what is left at the end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cluster {
    /// The smallest corner.
    pub min: Vec3,
    /// The largest corner.
    pub max: Vec3,
    /// Where its blocks begin and end in [`Clusters::blocks`].
    blocks: [usize; 2],
}

impl Cluster {
    /// That of some triangles, without blocks.
    fn new(positions: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let (mut min, mut max) = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
        for &i in triangles.as_flattened() {
            let p = Vec3A::from(positions[i as usize]);
            (min, max) = (min.min(p), max.max(p));
        }
        Self { min: min.into(), max: max.into(), blocks: [0; 2] }
    }
}

impl Clusters {
    /// The clusters of a mesh whose box has these edges; none of a small one.
    pub(super) fn new(positions_local: &[Vec3], triangles: &[[u32; 3]], extent: Vec3) -> Self {
        if triangles.len() < LEAST {
            return Self::default();
        }
        let boxes = boxes_of(positions_local, triangles);
        let area = area_of(&boxes);
        if area > COHERENT * half_area(extent) && positions_local.len() <= MOST_VERTICES * triangles.len() {
            let sorted = Sorted::new(positions_local, triangles);
            let boxes = boxes_of(&sorted.positions, &sorted.triangles);
            if area_of(&boxes) < WORTH * area {
                return Self::with_blocks(boxes, &sorted.triangles).with_order(sorted);
            }
        }
        Self::with_blocks(boxes, triangles)
    }
    fn with_blocks(mut boxes: Box<[Cluster]>, triangles: &[[u32; 3]]) -> Self {
        let blocks: Vec<Vec<u32>> = triangles.par_chunks(CLUSTER).map(blocks_of).collect();
        let mut end = 0;
        for (cluster, own) in boxes.iter_mut().zip(&blocks) {
            let start = end;
            end += own.len();
            cluster.blocks = [start, end];
        }
        Self { boxes, blocks: blocks.concat().into(), sorted: None }
    }
    fn with_order(self, sorted: Sorted) -> Self {
        Self { sorted: Some(sorted), ..self }
    }
    /// The boxes; none of a small mesh.
    pub fn boxes(&self) -> &[Cluster] {
        &self.boxes
    }
    /// The blocks of vertices that the triangles of one of them need, each once, by their numbers in the order of the vertices.
    pub fn blocks(&self, cluster: usize) -> &[u32] {
        let [start, end] = self.boxes[cluster].blocks;
        &self.blocks[start..end]
    }
    /// The mesh in their order, where that is not its own.
    pub fn sorted(&self) -> Option<&Sorted> {
        self.sorted.as_ref()
    }
    /// Bytes held on the heap.
    pub fn memory(&self) -> usize {
        let sorted = |s: &Sorted| size_of_val(&*s.positions) + size_of_val(&*s.triangles) + size_of_val(&*s.numbers);
        size_of_val(&*self.boxes) + size_of_val(&*self.blocks) + self.sorted.as_ref().map_or(0, sorted)
    }
}

impl Sorted {
    fn new(positions_local: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        const UNUSED: u32 = u32::MAX;
        let numbers = z_order(positions_local, triangles);
        let mut slots = vec![UNUSED; positions_local.len()];
        let mut positions = Vec::with_capacity(positions_local.len());
        let sorted = numbers.iter().map(|&number| {
            triangles[number as usize].map(|i| {
                let slot = &mut slots[i as usize];
                if *slot == UNUSED {
                    *slot = positions.len() as u32;
                    positions.push(positions_local[i as usize]);
                }
                *slot
            })
        });
        let triangles = sorted.collect();
        Self { positions: positions.into(), triangles, numbers }
    }
}

fn boxes_of(positions: &[Vec3], triangles: &[[u32; 3]]) -> Box<[Cluster]> {
    triangles.par_chunks(CLUSTER).map(|some| Cluster::new(positions, some)).collect()
}

/// The blocks that some triangles need, each once.
fn blocks_of(triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut blocks = Vec::new();
    for &i in triangles.as_flattened() {
        let block = i / BLOCK as u32;
        // Mostly one of the few last ones.
        if !blocks.iter().rev().any(|known| *known == block) {
            blocks.push(block);
        }
    }
    blocks
}

/// Half of the faces of all boxes.
fn area_of(boxes: &[Cluster]) -> f32 {
    boxes.iter().map(|b| half_area(b.max - b.min)).sum()
}

fn half_area(extent: Vec3) -> f32 {
    extent.x * extent.y + extent.y * extent.z + extent.z * extent.x
}

/// Triangles along a Z-order curve of their centres; those in one cell in their own order.
fn z_order(positions_local: &[Vec3], triangles: &[[u32; 3]]) -> Box<[u32]> {
    // Local coordinates are at most 1 (`mesh`).
    let cells = (1 << (CODE_BITS - 1)) as f32;
    let code = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|i| positions_local[i as usize]);
        let place = ((a + b + c) / 3.0 + 1.0) * cells;
        // Casts saturate.
        let bits = place.to_array().map(|x| spread((x as u32).min((1 << CODE_BITS) - 1)));
        bits[0] | bits[1] << 1 | bits[2] << 2
    };
    let coded = triangles.par_iter().enumerate().map(|(i, t)| u64::from(code(t)) << 32 | i as u64);
    let mut coded: Vec<u64> = coded.collect();
    coded.par_sort_unstable();
    coded.into_iter().map(|code| code as u32).collect()
}

/// The ten lowest bits, two zeros between each two.
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 2 * 32 * 32 triangles from -1 to 1, row by row.
    fn grid() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let at = |i: u32| i as f32 / 16.0 - 1.0;
        let positions = (0..33 * 33).map(|i| Vec3::new(at(i % 33), at(i / 33), 0.1 * at(i % 7))).collect();
        let corner = |i: u32| i / 32 * 33 + i % 32;
        let pair = |i: u32| [[0, 1, 34], [0, 34, 33]].map(|t: [u32; 3]| t.map(|k| corner(i) + k));
        (positions, (0..32 * 32).flat_map(pair).collect())
    }

    fn check(found: &Clusters, positions: &[Vec3], triangles: &[[u32; 3]]) {
        assert_eq!(found.boxes().len(), triangles.len().div_ceil(CLUSTER));
        let corners = |positions: &[Vec3], t: [u32; 3]| t.map(|i| positions[i as usize]);
        let mut own = (positions, triangles);
        if let Some(sorted) = found.sorted() {
            own = (&sorted.positions, &sorted.triangles);
            assert_eq!(own.0.len(), positions.len());
            for (&number, &t) in sorted.numbers.iter().zip(&sorted.triangles) {
                assert_eq!(corners(own.0, t), corners(positions, triangles[number as usize]));
            }
            let mut order = sorted.numbers.to_vec();
            order.sort_unstable();
            assert!(order.iter().copied().eq(0..triangles.len() as u32), "each triangle once");
        }
        for (k, (cluster, some)) in found.boxes().iter().zip(own.1.chunks(CLUSTER)).enumerate() {
            let indices = some.as_flattened();
            let all = || indices.iter().map(|&i| own.0[i as usize]);
            assert_eq!(cluster.min, all().fold(Vec3::INFINITY, Vec3::min));
            assert_eq!(cluster.max, all().fold(Vec3::NEG_INFINITY, Vec3::max));
            let mut blocks = found.blocks(k).to_vec();
            blocks.sort_unstable();
            let mut expected: Vec<u32> = indices.iter().map(|i| i / BLOCK as u32).collect();
            expected.sort_unstable();
            expected.dedup();
            assert_eq!(blocks, expected);
        }
    }

    #[test]
    fn boxes_hold_their_triangles_and_touch_them() {
        let (positions, triangles) = grid();
        let extent = Vec3::new(2.0, 2.0, 0.1);
        let own = Clusters::new(&positions, &triangles, extent);
        check(&own, &positions, &triangles);
        assert!(own.sorted().is_none(), "rows are neighbours");
        // Neighbours in the list are far apart: each cluster spans the square.
        let scattered: Vec<[u32; 3]> = (0..triangles.len()).map(|i| triangles[i * 577 % triangles.len()]).collect();
        let sorted = Clusters::new(&positions, &scattered, extent);
        check(&sorted, &positions, &scattered);
        assert!(sorted.sorted().is_some() && area_of(sorted.boxes()) < 2.0 * area_of(own.boxes()));
        assert!(Clusters::new(&positions, &triangles[..LEAST - 1], extent).boxes().is_empty());
        // Triangles that share no vertices have boxes and no copy.
        let apart: Vec<Vec3> = scattered.as_flattened().iter().map(|&i| positions[i as usize]).collect();
        let numbered: Vec<[u32; 3]> = (0..scattered.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let unshared = Clusters::new(&apart, &numbered, extent);
        check(&unshared, &apart, &numbered);
        assert!(unshared.sorted().is_none());
    }

    #[test]
    fn codes_interleave_bits() {
        assert_eq!(spread(0b1011), 0b001_000_001_001);
        assert_eq!(spread((1 << CODE_BITS) - 1).count_ones(), CODE_BITS);
        let far = [Vec3::splat(-2.0), Vec3::splat(2.0), Vec3::ZERO];
        assert_eq!(*z_order(&far, &[[1, 1, 1], [2, 2, 2], [0, 0, 0], [2, 2, 2]]), [2, 1, 3, 0]);
    }
}
