//! A bundle's walk through the hierarchies. Where its rays part, each goes on alone.

use glam::{DAffine3, DVec3};

use super::one_ray::{Stack, traverse_instance, walk};
use super::visitors::{Shown, Visitor};
use crate::trace::hierarchy::{Inner, LEAF_BIT, NO_ITEM, TracedMesh, Tree, WIDTH};
use crate::trace::kernel::{Kernel, Lanes};
use crate::trace::rays::{BUNDLE, Bundle, Each, Hull, LocalRay, LocalRays, RayBits, WorldRay, largest};

/// Rays below which each goes alone: a node costs the bundle about as much as two rays.
const FEW: u32 = 3;

/// Rays at a leaf from which on it pays to look roughly first: that costs about as much as two of them.
const WORTH_THE_ROUGH_TEST: u32 = 2;

/// Of a ray that has nothing left to look for: no box is met at a negative parameter.
const ENDED: f32 = -1.0;

/// What is still to be entered, kept between walks for its memory.
#[derive(Debug, Default)]
pub struct Stacks {
    together: Vec<Waiting>,
    alone: Stack,
    /// Instance and leaf that last ended a ray of a bundle: neighbours are mostly blocked by the same, so that is looked at first,
    /// for as long as it ends any.
    blocker: Option<(u32, u32)>,
}

/// A child still to be entered, and a lower bound of where any ray enters it, which is not negative: ordered by it.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
struct Waiting(u64);

impl Waiting {
    #[inline(always)]
    fn new(node: u32, child: usize, entry: f32) -> Self {
        // Numbers that are not negative have the order of their bits, and a tree has at most 2^29 nodes.
        Self(u64::from(entry.to_bits()) << 32 | u64::from(node << 3 | child as u32))
    }
    #[inline(always)]
    fn entry(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }
    #[inline(always)]
    fn node(self) -> usize {
        (self.0 as u32 >> 3) as usize
    }
    #[inline(always)]
    fn child(self) -> usize {
        self.0 as usize % WIDTH
    }
}

/// Rays of a bundle at a leaf.
struct AtLeaf {
    /// Those whose walk ends.
    ended: RayBits,
    /// Those that may have seen anything.
    seen: RayBits,
}

/// What a tree holds.
trait Leaves<V> {
    /// Whether it holds triangles, which several rays look at roughly first.
    const TRIANGLES: bool;

    /// Shows one ray what is in a leaf; true ends its walk.
    fn alone<K: Kernel>(&self, leaf: usize, lane: usize, ray: &LocalRay, visitor: &mut V, stack: &mut Stack) -> bool;
    /// Shows several rays what is in a leaf.
    fn together<K: Kernel>(
        &self,
        leaf: usize,
        rays: &LocalRays<BUNDLE>,
        bits: RayBits,
        visitors: &mut [V; BUNDLE],
        stacks: &mut Stacks,
    ) -> AtLeaf;
    /// The leaf of it that last ended a ray.
    fn blocker(&self, stacks: &Stacks) -> Option<usize>;
}

struct Triangles<'a> {
    mesh: &'a TracedMesh,
    instance: u32,
}

impl Triangles<'_> {
    #[inline(always)]
    fn shown(&self, leaf: usize) -> Shown<'_> {
        Shown { mesh: self.mesh, packet: &self.mesh.packets[leaf], instance: self.instance }
    }
}

impl<V: Visitor> Leaves<V> for Triangles<'_> {
    const TRIANGLES: bool = true;

    #[inline(always)]
    fn alone<K: Kernel>(&self, leaf: usize, _: usize, ray: &LocalRay, visitor: &mut V, _: &mut Stack) -> bool {
        visitor.visit::<K>(&self.shown(leaf), &ray.line(0))
    }
    #[inline(always)]
    fn together<K: Kernel>(
        &self,
        leaf: usize,
        rays: &LocalRays<BUNDLE>,
        bits: RayBits,
        visitors: &mut [V; BUNDLE],
        stacks: &mut Stacks,
    ) -> AtLeaf {
        let index = leaf as u32;
        let leaf = self.shown(leaf);
        let mut ended = 0;
        if bits.count_ones() < WORTH_THE_ROUGH_TEST {
            for r in Each(bits) {
                ended |= u32::from(visitors[r].visit::<K>(&leaf, &rays.line(r))) << r;
            }
            return AtLeaf { ended, seen: bits };
        }
        let near = K::rays_near(leaf.packet, rays);
        let seen = (near[0] | near[1] | near[2] | near[3]) & bits;
        for r in Each(seen) {
            let line = rays.line(r);
            let lane = |lane: usize| (near[lane] >> r & 1) << lane;
            for lane in Lanes(lane(0) | lane(1) | lane(2) | lane(3)) {
                if visitors[r].visit_one(&leaf, lane, &line) {
                    ended |= 1 << r;
                    break;
                }
            }
        }
        if ended != 0 {
            stacks.blocker = Some((self.instance, index));
        }
        AtLeaf { ended, seen }
    }
    #[inline(always)]
    fn blocker(&self, stacks: &Stacks) -> Option<usize> {
        stacks.blocker.filter(|blocker| blocker.0 == self.instance).map(|blocker| blocker.1 as usize)
    }
}

struct Instances<'a> {
    scene: &'a Inner,
    top: &'a Tree,
    rays: &'a [WorldRay; BUNDLE],
}

impl Instances<'_> {
    #[inline(always)]
    fn of(&self, leaf: usize) -> impl Iterator<Item = u32> {
        self.top.leaves[leaf].into_iter().take_while(|&i| i != NO_ITEM)
    }
}

impl<V: Visitor> Leaves<V> for Instances<'_> {
    const TRIANGLES: bool = false;

    #[inline(always)]
    fn alone<K: Kernel>(&self, leaf: usize, lane: usize, _: &LocalRay, visitor: &mut V, stack: &mut Stack) -> bool {
        self.of(leaf).any(|i| traverse_instance::<K, V>(self.scene, i, &self.rays[lane], visitor, stack))
    }
    #[inline(always)]
    fn together<K: Kernel>(
        &self,
        leaf: usize,
        _: &LocalRays<BUNDLE>,
        bits: RayBits,
        visitors: &mut [V; BUNDLE],
        stacks: &mut Stacks,
    ) -> AtLeaf {
        let mut ended = 0;
        for i in self.of(leaf) {
            ended |= instance_together::<K, V>(self.scene, i, self.rays, bits & !ended, visitors, stacks);
        }
        AtLeaf { ended, seen: bits }
    }
    #[inline(always)]
    fn blocker(&self, _: &Stacks) -> Option<usize> {
        None
    }
}

/// Shows each visitor everything its ray may meet, in whatever order: those of the rays
/// in `bits` that ended it.
#[inline(always)]
pub fn traverse_together<K: Kernel, V: Visitor>(
    scene: &Inner,
    rays: &[WorldRay; BUNDLE],
    bits: RayBits,
    visitors: &mut [V; BUNDLE],
    stacks: &mut Stacks,
) -> RayBits {
    let Some(top) = &scene.top else {
        return instance_together::<K, V>(scene, 0, rays, bits, visitors, stacks);
    };
    let map = DAffine3::from_scale(DVec3::splat(scene.top_per_world));
    let leaves = Instances { scene, top, rays };
    in_frame::<K, V, _>(top, &map, scene.top_per_world, &leaves, rays, bits, visitors, stacks)
}

#[inline(always)]
fn instance_together<K: Kernel, V: Visitor>(
    scene: &Inner,
    instance: u32,
    rays: &[WorldRay; BUNDLE],
    bits: RayBits,
    visitors: &mut [V; BUNDLE],
    stacks: &mut Stacks,
) -> RayBits {
    let placed = &scene.placed[instance as usize];
    let mesh = &scene.meshes[placed.mesh as usize];
    let leaves = Triangles { mesh, instance };
    let (map, scale) = (&placed.frame.local_from_world, placed.frame.local_per_world);
    in_frame::<K, V, _>(&mesh.tree, map, scale, &leaves, rays, bits, visitors, stacks)
}

#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn in_frame<K: Kernel, V: Visitor, L: Leaves<V>>(
    tree: &Tree,
    local_from_world: &DAffine3,
    local_per_world: f64,
    leaves: &L,
    rays: &[WorldRay; BUNDLE],
    bits: RayBits,
    visitors: &mut [V; BUNDLE],
    stacks: &mut Stacks,
) -> RayBits {
    // All visitors of a bundle ask for the same band.
    let band = visitors[0].band() * local_per_world;
    let mut ranges = [[0.0; 2]; BUNDLE];
    for r in 0..BUNDLE {
        ranges[r] = visitors[r].range();
    }
    let mut local = LocalRays::NONE;
    local.fill(local_from_world, &tree.bounds, rays, &ranges, band, bits, L::TRIANGLES);
    let (mut together, apart) = (local.together, local.apart);
    let mut ended = 0;
    if !V::IN_ORDER
        && let Some(leaf) = leaves.blocker(stacks)
    {
        // Only whether it ends a ray counts here. The rest, which depends on the leaves that are visited, is left to the walk.
        let mut copies = visitors.clone();
        ended = leaves.together::<K>(leaf, &local, together, &mut copies, stacks).ended;
        together &= !ended;
        if ended == 0 {
            stacks.blocker = None;
        }
    }
    let walk = Walk { tree, local_from_world, band, leaves, rays };
    if together.count_ones() < FEW {
        return ended | walk.alone::<K, V>(tree.root, together | apart, visitors, stacks);
    }
    let bundle = Bundle { hull: Hull::new(&local, together), rays: &local };
    ended |= walk.together::<K, V>(&bundle, together, visitors, stacks);
    ended | walk.alone::<K, V>(tree.root, apart, visitors, stacks)
}

/// A tree in its frame, and the rays that walk through it.
struct Walk<'a, L> {
    tree: &'a Tree,
    local_from_world: &'a DAffine3,
    band: f64,
    leaves: &'a L,
    rays: &'a [WorldRay; BUNDLE],
}

impl<L> Walk<'_, L> {
    /// Each ray by itself, from a child's code on.
    #[inline(always)]
    fn alone<K: Kernel, V: Visitor>(
        &self,
        code: u32,
        bits: RayBits,
        visitors: &mut [V; BUNDLE],
        stacks: &mut Stacks,
    ) -> RayBits
    where
        L: Leaves<V>,
    {
        let mut ended = 0;
        for r in Each(bits) {
            let visitor = &mut visitors[r];
            let (world, range) = ([self.rays[r]], [visitor.range()]);
            let mut ray = LocalRay::NONE;
            ray.fill(self.local_from_world, &self.tree.bounds, &world, &range, self.band, 1, false);
            if ray.together == 0 {
                continue;
            }
            let at_leaf =
                |leaf, visitor: &mut V, stack: &mut Stack| self.leaves.alone::<K>(leaf, r, &ray, visitor, stack);
            ended |= u32::from(walk::<K, V>(self.tree, code, &ray, visitor, &mut stacks.alone, at_leaf)) << r;
        }
        ended
    }

    #[inline(always)]
    fn together<K: Kernel, V: Visitor>(
        &self,
        bundle: &Bundle,
        bits: RayBits,
        visitors: &mut [V; BUNDLE],
        stacks: &mut Stacks,
    ) -> RayBits
    where
        L: Leaves<V>,
    {
        let floor = stacks.together.len();
        let mut limits = [ENDED; BUNDLE];
        for r in Each(bits) {
            limits[r] = bundle.rays.slab_limit(r, visitors[r].range()[1]);
        }
        let mut limit = largest(&limits);
        let (mut code, mut met, mut ended) = (self.tree.root, bits, 0);
        loop {
            let is_leaf = code & LEAF_BIT != 0;
            if !is_leaf && met.count_ones() >= FEW {
                let (children, entry) = K::hull_boxes(&self.tree.nodes[code as usize], &bundle.hull, limit);
                push::<V>(&mut stacks.together, code, children, &entry);
            } else {
                let at = if is_leaf {
                    self.leaves.together::<K>((code & !LEAF_BIT) as usize, bundle.rays, met, visitors, stacks)
                } else {
                    AtLeaf { ended: self.alone::<K, V>(code, met, visitors, stacks), seen: met }
                };
                ended |= at.ended;
                let changed = if V::IN_ORDER { at.seen } else { at.ended };
                if changed != 0 {
                    for r in Each(changed) {
                        let is_ended = (at.ended >> r) & 1 != 0;
                        limits[r] = if is_ended { ENDED } else { bundle.rays.slab_limit(r, visitors[r].range()[1]) };
                    }
                    limit = largest(&limits);
                }
            }
            loop {
                if stacks.together.len() == floor {
                    return ended;
                }
                let Some(next) = stacks.together.pop() else { return ended };
                if next.entry() > limit {
                    continue;
                }
                let (node, child) = (&self.tree.nodes[next.node()], next.child());
                met = K::rays_in_box(node, child, bundle, &limits);
                if met != 0 {
                    code = node.children[child];
                    break;
                }
            }
        }
    }
}

/// Puts children on the stack, the nearest on top where that matters.
#[inline(always)]
fn push<V: Visitor>(stack: &mut Vec<Waiting>, node: u32, mut children: u32, entry: &[f32; WIDTH]) {
    let base = stack.len();
    // Once for all: then nothing below asks for memory.
    stack.reserve(WIDTH);
    while children != 0 {
        let child = children.trailing_zeros() as usize % WIDTH;
        children &= children - 1;
        let pushed = Waiting::new(node, child, entry[child]);
        let mut at = stack.len();
        stack.push(pushed);
        if V::IN_ORDER {
            while at > base && stack[at - 1] < pushed {
                stack[at] = stack[at - 1];
                at -= 1;
            }
            stack[at] = pushed;
        }
    }
}
