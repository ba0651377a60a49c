//! An eight-wide bounding volume hierarchy over boxes: what rays walk through.

use glam::Vec3;

/// Children of a node.
pub const WIDTH: usize = 8;
/// Items of a leaf.
pub const LEAF: usize = 4;
/// Marks an unused slot in a leaf.
pub const NO_ITEM: u32 = u32::MAX;
/// Set in a child's code where it is a leaf; the rest is an index into [`Tree::leaves`] or [`Tree::nodes`].
pub const LEAF_BIT: u32 = 1 << 31;

/// An axis-aligned box in single precision.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Box3 {
    pub min: Vec3,
    pub max: Vec3,
}

impl Box3 {
    pub const EMPTY: Self = Self { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    pub fn with_point(self, p: Vec3) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
    }
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }
    pub fn half_area(&self) -> f32 {
        let e = (self.max - self.min).max(Vec3::ZERO);
        e.x * e.y + e.y * e.z + e.z * e.x
    }
}

/// Eight children: `planes[2 * axis]` holds their lower, `planes[2 * axis + 1]` their upper bounds. An empty slot has
/// lower = +inf and upper = -inf, which no ray meets.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub struct Node {
    pub planes: [[f32; WIDTH]; 6],
    pub children: [u32; WIDTH],
}

impl Node {
    pub const EMPTY: Self = {
        let (lower, upper) = ([f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]);
        Self { planes: [lower, upper, lower, upper, lower, upper], children: [0; WIDTH] }
    };

    /// Puts a child into a slot.
    pub fn set(&mut self, slot: usize, bounds: &Box3, code: u32) {
        for axis in 0..3 {
            self.planes[2 * axis][slot] = bounds.min[axis];
            self.planes[2 * axis + 1][slot] = bounds.max[axis];
        }
        self.children[slot] = code;
    }
}

/// The hierarchy. `root` is a child's code.
#[derive(Debug)]
pub struct Tree {
    pub root: u32,
    pub bounds: Box3,
    pub nodes: Vec<Node>,
    pub leaves: Vec<[u32; LEAF]>,
}

impl Tree {
    /// Bytes held on the heap.
    pub fn memory(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>() + self.leaves.capacity() * size_of::<[u32; LEAF]>()
    }
}
