//! The hierarchy's build, top-down and on all cores.
//!
//! Binned surface-area heuristic (Wald 2007 `[wald2007]`, on fast construction of SAH-based hierarchies);
//! eight-wide nodes by splitting the largest child until there are eight (Wald, Benthin, Boulos 2008 `[wald2008]`,
//! getting rid of packets). Leaves hold at most four items, since a leaf is one SIMD test.
//!
//! Ours rather than a bottom-up clustering: equal boxes (duplicated or degenerate triangles) split in the middle, so
//! the depth is bounded for every input, and the build runs on all cores. Splits depend on no order of work, so the tree is the
//! same on any number of threads.
//!
//! A split reads its items twice: to fill the bins, which then give the boxes of both sides, and to part them, which gives the
//! boxes of both sides' centres.

use glam::Vec4;
use rayon::prelude::*;

use super::tree::{Box3, LEAF, LEAF_BIT, NO_ITEM, Node, Tree, WIDTH};
use crate::error::{Error, Result};
use crate::progress::Progress;

/// Bins along each axis: 16 finds splits within a few percent of a full sweep (`[wald2007]`, section 4).
const BINS: usize = 16;
/// Items below which a subtree is not worth a task of its own (about 1 ms of work).
const TASK: usize = 8192;
/// Splits on a path after which the middle is taken: boxes in geometric progression could otherwise chain.
const MAX_SAH_DEPTH: u32 = 64;
/// Items of a tree: a walk keeps a node's index and a child's in 32 bits.
pub const MOST_ITEMS: usize = 1 << 29;

/// Four numbers at once; the fourth of any box has no meaning.
#[derive(Debug, Clone, Copy)]
struct Box4 {
    min: Vec4,
    max: Vec4,
}

impl Box4 {
    const EMPTY: Self = Self { min: Vec4::INFINITY, max: Vec4::NEG_INFINITY };

    #[inline(always)]
    fn with_point(self, p: Vec4) -> Self {
        Self { min: self.min.min(p), max: self.max.max(p) }
    }
    #[inline(always)]
    fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }
    #[inline(always)]
    fn half_area(&self) -> f32 {
        let e = (self.max - self.min).max(Vec4::ZERO);
        e.x * e.y + e.y * e.z + e.z * e.x
    }
    fn box3(&self) -> Box3 {
        Box3 { min: self.min.truncate(), max: self.max.truncate() }
    }
}

/// A box to sort into the tree, and whose it is: in the fourth number, as a float between 2 and infinity, so that arithmetic on all
/// four is as fast as on three.
#[derive(Debug, Clone, Copy)]
pub struct Item {
    min: Vec4,
    max: Vec4,
}

impl Item {
    /// The bits of 2.
    const ID: u32 = 1 << 30;

    /// `id` is below [`MOST_ITEMS`].
    #[inline(always)]
    pub fn new(bounds: Box3, id: u32) -> Self {
        Self { min: bounds.min.extend(f32::from_bits(Self::ID | id)), max: bounds.max.extend(0.0) }
    }
    #[inline(always)]
    fn id(&self) -> u32 {
        self.min.w.to_bits() & !Self::ID
    }
    #[inline(always)]
    fn bounds4(&self) -> Box4 {
        Box4 { min: self.min, max: self.max }
    }
    /// Its box.
    pub fn bounds(&self) -> Box3 {
        self.bounds4().box3()
    }
    /// Twice the centre: only compared.
    #[inline(always)]
    fn center2(&self) -> Vec4 {
        self.min + self.max
    }
}

/// Items that go below one child.
struct Segment<'a> {
    items: &'a mut [Item],
    bounds: Box4,
    centers2: Box4,
    depth: u32,
}

/// Nodes and leaves of a subtree.
#[derive(Default)]
struct Part {
    nodes: Vec<Node>,
    leaves: Vec<[u32; LEAF]>,
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Box4,
    count: usize,
}

type Bins = [[Bin; BINS]; 3];

const NO_BINS: Bins = [[Bin { bounds: Box4::EMPTY, count: 0 }; BINS]; 3];

/// The sides of a plane between two bins.
struct Plane {
    axis: usize,
    /// The first bin of the right side.
    first: usize,
    /// Bins per length, along each axis.
    scale: Vec4,
    bounds: [Box4; 2],
}

impl Tree {
    /// A tree over items (at least one) with at most `PER_LEAF` of them in a leaf, 1 to [`LEAF`].
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for more than [`MOST_ITEMS`]; [`Error::Interrupted`].
    pub fn build<const PER_LEAF: usize>(mut items: Vec<Item>, progress: &Progress) -> Result<Self> {
        const { assert!(PER_LEAF >= 1 && PER_LEAF <= LEAF) };
        if items.len() > MOST_ITEMS {
            let expected = format!("meshes of at most {MOST_ITEMS} triangles and as many instances");
            return Err(Error::argument("scene", expected, items.len(), "divide the mesh"));
        }
        let (bounds, centers2) = boxes(&items);
        let mut part = Part::default();
        let all = Segment { items: &mut items, bounds, centers2, depth: 0 };
        let root = Builder::<PER_LEAF> { progress }.subtree(all, &mut part)?;
        drop(items);
        part.nodes.shrink_to_fit();
        part.leaves.shrink_to_fit();
        Ok(Self { root, bounds: bounds.box3(), nodes: part.nodes, leaves: part.leaves })
    }
}

/// The boxes of items and of their centres.
fn boxes(items: &[Item]) -> (Box4, Box4) {
    let of = |items: &[Item]| {
        let empty = (Box4::EMPTY, Box4::EMPTY);
        items.iter().fold(empty, |(b, c), i| (b.union(i.bounds4()), c.with_point(i.center2())))
    };
    let both = |a: (Box4, Box4), b: (Box4, Box4)| (a.0.union(b.0), a.1.union(b.1));
    if items.len() > 4 * TASK {
        items.par_chunks(TASK).map(of).reduce(|| (Box4::EMPTY, Box4::EMPTY), both)
    } else {
        of(items)
    }
}

struct Builder<'p, const PER_LEAF: usize> {
    progress: &'p Progress,
}

impl<const PER_LEAF: usize> Builder<'_, PER_LEAF> {
    /// The code of a child that holds the segment; its nodes and leaves are appended to `part`.
    fn subtree(&self, segment: Segment, part: &mut Part) -> Result<u32> {
        if segment.items.len() <= PER_LEAF {
            let mut ids = [NO_ITEM; LEAF];
            for (slot, item) in ids.iter_mut().zip(segment.items.iter()) {
                *slot = item.id();
            }
            ids.sort_unstable();
            part.leaves.push(ids);
            return Ok(LEAF_BIT | (part.leaves.len() - 1) as u32);
        }
        let index = part.nodes.len();
        part.nodes.push(Node::EMPTY);
        let parallel = segment.items.len() > TASK;
        let segments = self.eight(segment)?.into_iter().flatten();
        let mut node = Node::EMPTY;
        if parallel {
            let built: Vec<(Box4, u32, Part)> = segments
                .collect::<Vec<_>>()
                .into_par_iter()
                .map(|s| {
                    let (bounds, mut own) = (s.bounds, Part::default());
                    let code = self.subtree(s, &mut own)?;
                    Ok((bounds, code, own))
                })
                .collect::<Result<_>>()?;
            // Once, so that what is there does not move several times.
            part.nodes.reserve_exact(built.iter().map(|b| b.2.nodes.len()).sum());
            part.leaves.reserve_exact(built.iter().map(|b| b.2.leaves.len()).sum());
            for (slot, (bounds, code, own)) in built.into_iter().enumerate() {
                let (nodes, leaves) = (part.nodes.len() as u32, part.leaves.len() as u32);
                let moved = |code: u32| code + if code & LEAF_BIT != 0 { leaves } else { nodes };
                node.set(slot, &bounds.box3(), moved(code));
                part.nodes.extend(own.nodes.into_iter().map(|mut n| {
                    n.children = n.children.map(moved);
                    n
                }));
                part.leaves.extend(own.leaves);
            }
        } else {
            for (slot, s) in segments.enumerate() {
                let bounds = s.bounds.box3();
                node.set(slot, &bounds, self.subtree(s, part)?);
            }
        }
        part.nodes[index] = node;
        Ok(index as u32)
    }

    /// Two to eight segments in place of one that is too large for a leaf.
    fn eight<'a>(&self, segment: Segment<'a>) -> Result<[Option<Segment<'a>>; WIDTH]> {
        let mut segments = [const { None }; WIDTH];
        // Of a segment that goes into a leaf: below every area.
        const DONE: f32 = -1.0;
        let mut areas = [DONE; WIDTH];
        let area_of = |s: &Segment| if s.items.len() > PER_LEAF { s.bounds.half_area() } else { DONE };
        areas[0] = area_of(&segment);
        segments[0] = Some(segment);
        for len in 1..WIDTH {
            // The last of equal ones.
            let widest = (0..len).fold(0, |best, i| if areas[i] >= areas[best] { i } else { best });
            // The last one takes its place.
            segments.swap(widest, len - 1);
            areas.swap(widest, len - 1);
            if areas[len - 1] == DONE {
                break;
            }
            let Some(whole) = segments[len - 1].take() else { break };
            // Every split of what takes longer than a task.
            if whole.items.len() > TASK {
                self.progress.check()?;
            }
            let halves = self.split(whole);
            for (slot, half) in [len - 1, len].into_iter().zip(halves) {
                areas[slot] = area_of(&half);
                segments[slot] = Some(half);
            }
        }
        Ok(segments)
    }

    fn split<'a>(&self, segment: Segment<'a>) -> [Segment<'a>; 2] {
        let depth = segment.depth + 1;
        let best = if depth <= MAX_SAH_DEPTH { self.best_plane(&segment) } else { None };
        let (middle, bounds, centers2) = match best {
            Some(plane) => {
                let (middle, centers2) = part(segment.items, segment.centers2.min, &plane);
                (middle, plane.bounds, centers2)
            }
            None => {
                let extent = segment.centers2.max - segment.centers2.min;
                let axis = extent.truncate().max_position();
                let half = segment.items.len() / 2;
                segment.items.select_nth_unstable_by(half, |a, b| {
                    a.center2()[axis].total_cmp(&b.center2()[axis]).then(a.id().cmp(&b.id()))
                });
                let [left, right] = [&segment.items[..half], &segment.items[half..]].map(boxes);
                (half, [left.0, right.0], [left.1, right.1])
            }
        };
        let (left, right) = segment.items.split_at_mut(middle);
        let side = |items, side: usize| Segment { items, bounds: bounds[side], centers2: centers2[side], depth };
        [side(left, 0), side(right, 1)]
    }

    /// The cheapest; none where all centres agree.
    fn best_plane(&self, segment: &Segment) -> Option<Plane> {
        let extent = segment.centers2.max - segment.centers2.min;
        // Just below the bin count, so that the largest centre falls into the last bin. A denormal extent gives an
        // infinite scale; such an axis cannot be split by value.
        let scale = Vec4::splat(BINS as f32 * (1.0 - f32::EPSILON)) / extent;
        let low = segment.centers2.min;
        let fill = |items: &[Item]| {
            let mut bins = NO_BINS;
            for item in items {
                let at = ((item.center2() - low) * scale).to_array();
                for axis in 0..3 {
                    let bin = &mut bins[axis][bin_at(at[axis])];
                    bin.bounds = bin.bounds.union(item.bounds4());
                    bin.count += 1;
                }
            }
            bins
        };
        let bins = if segment.items.len() > 4 * TASK {
            let parts: Vec<Bins> = segment.items.par_chunks(2 * TASK).map(fill).collect();
            parts.into_iter().fold(NO_BINS, |mut sum, part| {
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
            let (mut bounds, mut count) = (Box4::EMPTY, 0);
            for first in (1..BINS).rev() {
                let bin = &bins[axis][first];
                (bounds, count) = (bounds.union(bin.bounds), count + bin.count);
                right_cost[first] = if count > 0 { cost::<PER_LEAF>(&bounds, count) } else { f32::INFINITY };
            }
            let (mut bounds, mut count) = (Box4::EMPTY, 0);
            for first in 1..BINS {
                let bin = &bins[axis][first - 1];
                (bounds, count) = (bounds.union(bin.bounds), count + bin.count);
                let left_cost = if count > 0 { cost::<PER_LEAF>(&bounds, count) } else { f32::INFINITY };
                let cost = left_cost + right_cost[first];
                if cost < best.map_or(f32::INFINITY, |b| b.0) {
                    best = Some((cost, axis, first));
                }
            }
        }
        let (_, axis, first) = best?;
        let over = |bins: &[Bin]| bins.iter().fold(Box4::EMPTY, |b, bin| b.union(bin.bounds));
        let (left, right) = bins[axis].split_at(first);
        Some(Plane { axis, first, scale, bounds: [over(left), over(right)] })
    }
}

/// The surface-area heuristic: area times SIMD tests.
#[inline(always)]
fn cost<const PER_LEAF: usize>(bounds: &Box4, count: usize) -> f32 {
    bounds.half_area() * count.div_ceil(PER_LEAF) as f32
}

/// The bin of a centre so many bins above the lowest.
#[inline(always)]
fn bin_at(x: f32) -> usize {
    const LAST: f32 = (BINS - 1) as f32;
    // A NaN (zero extent times infinity) goes to the last bin. Such an axis is not split.
    let x = if x < LAST { x } else { LAST };
    // SAFETY: the lowest centre is the least of them all, so that x is not negative, and it is at most the last bin.
    let bin = unsafe { x.to_int_unchecked::<i32>() } as usize;
    bin % BINS
}

/// Moves the items left of a plane to the front: their number, and the boxes of both sides' centres.
#[inline(always)]
fn part(items: &mut [Item], low: Vec4, plane: &Plane) -> (usize, [Box4; 2]) {
    let (mut front, mut centers2) = (0, [Box4::EMPTY; 2]);
    for i in 0..items.len() {
        let item = items[i];
        let center2 = item.center2();
        let at = ((center2 - low) * plane.scale)[plane.axis];
        if bin_at(at) < plane.first {
            centers2[0] = centers2[0].with_point(center2);
            items[i] = items[front];
            items[front] = item;
            front += 1;
        } else {
            centers2[1] = centers2[1].with_point(center2);
        }
    }
    (front, centers2)
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

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
                let item = items[id as usize].bounds();
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
        centers.enumerate().map(|(id, c)| Item::new(Box3 { min: c, max: c + Vec3::splat(size) }, id as u32)).collect()
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
            let one = Tree::build::<1>(items.clone(), &Progress::new()).unwrap();
            let four = Tree::build::<4>(items.clone(), &Progress::new()).unwrap();
            for tree in [one, four] {
                let mut seen = vec![false; items.len()];
                check(&tree, &items, tree.root, tree.bounds, &mut seen);
                assert!(seen.iter().all(|&s| s));
                assert!(depth(&tree, tree.root) <= MAX_SAH_DEPTH as usize + 32);
            }
        }
    }

    #[test]
    fn the_tree_is_the_same_on_any_number_of_threads() {
        let mut state = 9u32;
        let mut random = || {
            state = state.wrapping_mul(1664525).wrapping_add(1013904223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        // Above four tasks: then boxes and bins are sums of parts.
        let items = boxes((0..5 * TASK).map(|_| Vec3::new(random(), random(), random())), 0.01);
        let with = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| Tree::build::<4>(items.clone(), &Progress::new()).unwrap())
        };
        let one = with(1);
        for threads in [2, 7] {
            let many = with(threads);
            assert_eq!((one.root, one.bounds, &one.leaves), (many.root, many.bounds, &many.leaves));
            assert_eq!(one.nodes.len(), many.nodes.len());
            assert!(one.nodes.iter().zip(&many.nodes).all(|(a, b)| a.planes == b.planes && a.children == b.children));
        }
    }
}
