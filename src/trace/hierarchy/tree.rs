//! An eight-wide bounding volume hierarchy over boxes, built top-down.
//!
//! Binned surface-area heuristic (Wald 2007 `[wald2007]`, on fast construction of SAH-based hierarchies);
//! eight-wide nodes by splitting the largest child until there are eight (Wald, Benthin, Boulos 2008 `[wald2008]`,
//! getting rid of packets). Leaves hold at most four items, since a leaf is one SIMD test.
//!
//! Ours rather than a bottom-up clustering: equal boxes (duplicated or degenerate triangles) split in the middle, so
//! the depth is bounded for every input, and the build runs on all cores.

use glam::Vec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::progress::Progress;

/// Children of a node.
pub const WIDTH: usize = 8;
/// Items of a leaf.
pub const LEAF: usize = 4;
/// Marks an unused slot in a leaf.
pub const NO_ITEM: u32 = u32::MAX;
/// Set in a child's code where it is a leaf; the rest is an index into [`Tree::leaves`] or [`Tree::nodes`].
pub const LEAF_BIT: u32 = 1 << 31;

/// Bins along each axis: 16 finds splits within a few percent of a full sweep (`[wald2007]`, section 4).
const BINS: usize = 16;
/// Items below which a subtree is not worth a task of its own (about 1 ms of work).
const TASK: usize = 8192;
/// Splits on a path after which the middle is taken: boxes in geometric progression could otherwise chain.
const MAX_SAH_DEPTH: u32 = 64;

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

/// A box to sort into the tree, and whose it is.
#[derive(Debug, Clone, Copy)]
pub struct Item {
    pub bounds: Box3,
    pub id: u32,
}

impl Item {
    /// Twice the centre: only compared.
    fn center2(&self) -> Vec3 {
        self.bounds.min + self.bounds.max
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
    /// A tree over items (at least one) with at most `leaf_size` of them in a leaf.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub fn build(mut items: Vec<Item>, leaf_size: usize, progress: &Progress) -> Result<Self> {
        let builder = Builder { leaf_size: leaf_size.clamp(1, LEAF), progress };
        let segment = Segment::new(&mut items, 0);
        let bounds = segment.bounds;
        let mut part = Part::default();
        let root = builder.subtree(segment, &mut part)?;
        part.nodes.shrink_to_fit();
        part.leaves.shrink_to_fit();
        Ok(Self { root, bounds, nodes: part.nodes, leaves: part.leaves })
    }
    /// Bytes held on the heap.
    pub fn memory(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>() + self.leaves.capacity() * size_of::<[u32; LEAF]>()
    }
}

/// Items that go below one child.
struct Segment<'a> {
    items: &'a mut [Item],
    bounds: Box3,
    centers2: Box3,
    depth: u32,
}

impl<'a> Segment<'a> {
    fn new(items: &'a mut [Item], depth: u32) -> Self {
        let of = |items: &[Item]| {
            items.iter().fold((Box3::EMPTY, Box3::EMPTY), |(b, c), i| (b.union(i.bounds), c.with_point(i.center2())))
        };
        let (bounds, centers2) = if items.len() > 4 * TASK {
            items
                .par_chunks(TASK)
                .map(of)
                .reduce(|| (Box3::EMPTY, Box3::EMPTY), |a, b| (a.0.union(b.0), a.1.union(b.1)))
        } else {
            of(items)
        };
        Self { items, bounds, centers2, depth }
    }
}

#[derive(Default)]
struct Part {
    nodes: Vec<Node>,
    leaves: Vec<[u32; LEAF]>,
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Box3,
    count: usize,
}

type Bins = [[Bin; BINS]; 3];

struct Builder<'p> {
    leaf_size: usize,
    progress: &'p Progress,
}

impl Builder<'_> {
    /// The code of a child that holds the segment; its nodes and leaves are appended to `part`.
    fn subtree(&self, segment: Segment, part: &mut Part) -> Result<u32> {
        if segment.items.len() <= self.leaf_size {
            let mut ids = [NO_ITEM; LEAF];
            segment.items.sort_unstable_by_key(|i| i.id);
            for (slot, item) in ids.iter_mut().zip(segment.items.iter()) {
                *slot = item.id;
            }
            part.leaves.push(ids);
            return Ok(LEAF_BIT | (part.leaves.len() - 1) as u32);
        }
        let index = part.nodes.len();
        part.nodes.push(Node::EMPTY);
        let parallel = segment.items.len() > TASK;
        let segments = self.eight(segment)?;
        let mut node = Node::EMPTY;
        if parallel {
            let built: Vec<(Box3, u32, Part)> = segments
                .into_par_iter()
                .map(|s| {
                    let (bounds, mut own) = (s.bounds, Part::default());
                    let code = self.subtree(s, &mut own)?;
                    Ok((bounds, code, own))
                })
                .collect::<Result<_>>()?;
            for (slot, (bounds, code, own)) in built.into_iter().enumerate() {
                let (nodes, leaves) = (part.nodes.len() as u32, part.leaves.len() as u32);
                let moved = |code: u32| code + if code & LEAF_BIT != 0 { leaves } else { nodes };
                node.set(slot, &bounds, moved(code));
                part.nodes.extend(own.nodes.into_iter().map(|mut n| {
                    n.children = n.children.map(moved);
                    n
                }));
                part.leaves.extend(own.leaves);
            }
        } else {
            for (slot, s) in segments.into_iter().enumerate() {
                let bounds = s.bounds;
                node.set(slot, &bounds, self.subtree(s, part)?);
            }
        }
        part.nodes[index] = node;
        Ok(index as u32)
    }

    /// Two to eight segments in place of one that is too large for a leaf.
    fn eight<'a>(&self, segment: Segment<'a>) -> Result<Vec<Segment<'a>>> {
        let mut segments = vec![segment];
        while segments.len() < WIDTH {
            let widest = (0..segments.len())
                .filter(|&i| segments[i].items.len() > self.leaf_size)
                .max_by(|&a, &b| segments[a].bounds.half_area().total_cmp(&segments[b].bounds.half_area()));
            let Some(widest) = widest else { break };
            // Every split of what takes longer than a task.
            if segments[widest].items.len() > TASK {
                self.progress.check()?;
            }
            let (left, right) = self.split(segments.swap_remove(widest));
            segments.extend([left, right]);
        }
        Ok(segments)
    }

    fn split<'a>(&self, segment: Segment<'a>) -> (Segment<'a>, Segment<'a>) {
        let depth = segment.depth + 1;
        let best = if depth <= MAX_SAH_DEPTH { self.best_plane(&segment) } else { None };
        let middle = match best {
            Some((axis, plane, scale)) => {
                let low = segment.centers2.min[axis];
                partition(segment.items, |i| bin_of(i.center2()[axis], low, scale) < plane)
            }
            None => {
                let extent = segment.centers2.max - segment.centers2.min;
                let axis = extent.max_position();
                let half = segment.items.len() / 2;
                segment.items.select_nth_unstable_by(half, |a, b| {
                    a.center2()[axis].total_cmp(&b.center2()[axis]).then(a.id.cmp(&b.id))
                });
                half
            }
        };
        let (left, right) = segment.items.split_at_mut(middle);
        (Segment::new(left, depth), Segment::new(right, depth))
    }

    /// The cheapest (axis, first bin of the right side, bins per length); none where all centres agree.
    fn best_plane(&self, segment: &Segment) -> Option<(usize, usize, f32)> {
        let extent = segment.centers2.max - segment.centers2.min;
        // Just below the bin count, so that the largest centre falls into the last bin. A denormal extent gives an
        // infinite scale; such an axis cannot be split by value.
        let scale: Vec3 = extent.to_array().map(|e| BINS as f32 * (1.0 - f32::EPSILON) / e).into();
        let low = segment.centers2.min;
        let empty: Bins = [[Bin { bounds: Box3::EMPTY, count: 0 }; BINS]; 3];
        let fill = |items: &[Item]| {
            let mut bins = empty;
            for item in items {
                let center2 = item.center2();
                for axis in 0..3 {
                    let bin = &mut bins[axis][bin_of(center2[axis], low[axis], scale[axis])];
                    bin.bounds = bin.bounds.union(item.bounds);
                    bin.count += 1;
                }
            }
            bins
        };
        let bins = if segment.items.len() > 4 * TASK {
            let parts: Vec<Bins> = segment.items.par_chunks(2 * TASK).map(fill).collect();
            parts.into_iter().fold(empty, |mut sum, part| {
                for (a, b) in sum.iter_mut().flatten().zip(part.iter().flatten()) {
                    a.bounds = a.bounds.union(b.bounds);
                    a.count += b.count;
                }
                sum
            })
        } else {
            fill(segment.items)
        };
        let mut best: Option<(f32, usize, usize)> = None;
        for axis in (0..3).filter(|&a| scale[a].is_finite()) {
            let mut right_cost = [f32::INFINITY; BINS];
            let (mut bounds, mut count) = (Box3::EMPTY, 0);
            for plane in (1..BINS).rev() {
                let bin = &bins[axis][plane];
                (bounds, count) = (bounds.union(bin.bounds), count + bin.count);
                right_cost[plane] = if count > 0 { self.cost(&bounds, count) } else { f32::INFINITY };
            }
            let (mut bounds, mut count) = (Box3::EMPTY, 0);
            for plane in 1..BINS {
                let bin = &bins[axis][plane - 1];
                (bounds, count) = (bounds.union(bin.bounds), count + bin.count);
                let cost = if count > 0 { self.cost(&bounds, count) + right_cost[plane] } else { f32::INFINITY };
                if cost < best.map_or(f32::INFINITY, |b| b.0) {
                    best = Some((cost, axis, plane));
                }
            }
        }
        best.map(|(_, axis, plane)| (axis, plane, scale[axis]))
    }

    /// The surface-area heuristic: area times SIMD tests.
    fn cost(&self, bounds: &Box3, count: usize) -> f32 {
        bounds.half_area() * count.div_ceil(self.leaf_size) as f32
    }
}

fn bin_of(center2: f32, low: f32, scale: f32) -> usize {
    // A NaN (zero extent times infinity) goes to bin 0.
    (((center2 - low) * scale) as usize).min(BINS - 1)
}

/// Moves the items that satisfy `left` to the front; returns their number.
fn partition(items: &mut [Item], left: impl Fn(&Item) -> bool) -> usize {
    let mut front = 0;
    for i in 0..items.len() {
        if left(&items[i]) {
            items.swap(front, i);
            front += 1;
        }
    }
    front
}

#[cfg(test)]
mod tests {
    use super::*;

    fn depth(tree: &Tree, code: u32) -> usize {
        if code & LEAF_BIT != 0 {
            return 0;
        }
        let node = &tree.nodes[code as usize];
        let used = (0..WIDTH).filter(|&i| node.planes[0][i] <= node.planes[1][i]);
        1 + used.map(|i| depth(tree, node.children[i])).max().unwrap()
    }

    fn check(tree: &Tree, items: &[Item], code: u32, bounds: Box3, seen: &mut [bool]) {
        if code & LEAF_BIT != 0 {
            for &id in tree.leaves[(code & !LEAF_BIT) as usize].iter().filter(|&&id| id != NO_ITEM) {
                assert!(!std::mem::replace(&mut seen[id as usize], true), "item {id} twice");
                let item = items[id as usize].bounds;
                assert_eq!(bounds.union(item), bounds, "item {id} leaves its box");
            }
            return;
        }
        let node = &tree.nodes[code as usize];
        for i in (0..WIDTH).filter(|&i| node.planes[0][i] <= node.planes[1][i]) {
            let at = |side: usize| Vec3::new(node.planes[side][i], node.planes[2 + side][i], node.planes[4 + side][i]);
            let child = Box3 { min: at(0), max: at(1) };
            assert_eq!(bounds.union(child), bounds, "a child leaves its parent");
            check(tree, items, node.children[i], child, seen);
        }
    }

    fn boxes(centers: impl Iterator<Item = Vec3>, size: f32) -> Vec<Item> {
        centers
            .enumerate()
            .map(|(id, c)| Item { bounds: Box3 { min: c, max: c + Vec3::splat(size) }, id: id as u32 })
            .collect()
    }

    #[test]
    fn every_item_is_held_once_and_the_depth_is_bounded() {
        let mut state = 1u32;
        let mut random = || {
            state = state.wrapping_mul(1664525).wrapping_add(1013904223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        let cases = [
            boxes((0..40_000).map(|_| Vec3::new(random(), random(), random())), 0.01),
            boxes((0..1000).map(|_| Vec3::ONE), 0.0),
            boxes((0..1000).map(|i| Vec3::X * (i % 2) as f32), 0.5),
            boxes((0..140).map(|i| Vec3::X * 2f32.powi(-i)), 0.0),
            boxes((0..1).map(|_| Vec3::ZERO), 0.0),
            boxes((0..5).map(|i| Vec3::Y * i as f32 * f32::MIN_POSITIVE / 4.0), 0.0),
        ];
        for items in cases {
            for leaf_size in [1, 4] {
                let tree = Tree::build(items.clone(), leaf_size, &Progress::new()).unwrap();
                let mut seen = vec![false; items.len()];
                check(&tree, &items, tree.root, tree.bounds, &mut seen);
                assert!(seen.iter().all(|&s| s));
                assert!(depth(&tree, tree.root) <= MAX_SAH_DEPTH as usize + 32);
            }
        }
    }
}
