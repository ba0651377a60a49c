//! A bundle's walk through the hierarchies. Where its rays part, each goes on alone.

use glam::{DAffine3, DVec3};

use super::one_ray::{Stack, traverse_instance, walk};
use super::visitors::Visitor;
use crate::trace::hierarchy::{Inner, LEAF_BIT, NO_ITEM, TracedMesh, Tree, WIDTH};
use crate::trace::kernel::Kernel;
use crate::trace::rays::{BUNDLE, Bundle, Each, Hull, LocalRay, LocalRays, RayBits, WorldRay, largest};

/// Rays below which each goes alone: a node costs the bundle about as much as two rays.
const FEW: u32 = 3;

/// Of a ray that has nothing left to look for: no box is met at a negative parameter.
const ENDED: f32 = -1.0;

/// What is still to be entered, kept between walks for its memory.
#[derive(Debug, Default)]
pub struct Stacks {
    together: Vec<Waiting>,
    alone: Stack,
}

/// A child still to be entered, and a lower bound of where any ray enters it.
#[derive(Debug, Clone, Copy)]
struct Waiting {
    node: u32,
    child: u32,
    entry: f32,
}

/// What a tree holds.
trait Leaves<V> {
    /// Shows one ray what is in a leaf; true ends its walk.
    fn alone<K: Kernel>(&self, leaf: usize, lane: usize, ray: &LocalRay, visitor: &mut V, stack: &mut Stack) -> bool;
    /// Shows several rays what is in a leaf; those whose walk ends.
    fn together<K: Kernel>(
        &self,
        leaf: usize,
        bundle: &Bundle,
        bits: RayBits,
        visitors: &mut [V; BUNDLE],
        stacks: &mut Stacks,
    ) -> RayBits;
}

struct Triangles<'a> {
    mesh: &'a TracedMesh,
    instance: u32,
}

impl<V: Visitor> Leaves<V> for Triangles<'_> {
    #[inline(always)]
    fn alone<K: Kernel>(&self, leaf: usize, _: usize, ray: &LocalRay, visitor: &mut V, _: &mut Stack) -> bool {
        visitor.visit::<K>(self.mesh, &self.mesh.packets[leaf], &ray.line(0), self.instance)
    }
    #[inline(always)]
    fn together<K: Kernel>(
        &self,
        leaf: usize,
        bundle: &Bundle,
        bits: RayBits,
        visitors: &mut [V; BUNDLE],
        _: &mut Stacks,
    ) -> RayBits {
        let packet = &self.mesh.packets[leaf];
        let mut ended = 0;
        for r in Each(bits) {
            ended |= u32::from(visitors[r].visit::<K>(self.mesh, packet, &bundle.rays.line(r), self.instance)) << r;
        }
        ended
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
    #[inline(always)]
    fn alone<K: Kernel>(&self, leaf: usize, lane: usize, _: &LocalRay, visitor: &mut V, stack: &mut Stack) -> bool {
        self.of(leaf).any(|i| traverse_instance::<K, V>(self.scene, i, &self.rays[lane], visitor, stack))
    }
    #[inline(always)]
    fn together<K: Kernel>(
        &self,
        leaf: usize,
        _: &Bundle,
        bits: RayBits,
        visitors: &mut [V; BUNDLE],
        stacks: &mut Stacks,
    ) -> RayBits {
        let mut ended = 0;
        for i in self.of(leaf) {
            ended |= instance_together::<K, V>(self.scene, i, self.rays, bits & !ended, visitors, stacks);
        }
        ended
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
    let ranges = std::array::from_fn(|r| visitors[r].range());
    let (local, together, apart) = LocalRays::new(local_from_world, &tree.bounds, rays, &ranges, band, bits);
    let walk = Walk { tree, local_from_world, band, leaves, rays };
    if together.count_ones() < FEW {
        return walk.alone::<K, V>(tree.root, together | apart, visitors, stacks);
    }
    let hull = Hull::new(&local, together);
    let ended = walk.together::<K, V>(&Bundle { rays: local, hull }, together, visitors, stacks);
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
            let (ray, alive, _) = LocalRay::new(self.local_from_world, &self.tree.bounds, &world, &range, self.band, 1);
            if alive == 0 {
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
                ended |= if is_leaf {
                    self.leaves.together::<K>((code & !LEAF_BIT) as usize, bundle, met, visitors, stacks)
                } else {
                    self.alone::<K, V>(code, met, visitors, stacks)
                };
                for r in Each(met) {
                    let is_ended = (ended >> r) & 1 != 0;
                    limits[r] = if is_ended { ENDED } else { bundle.rays.slab_limit(r, visitors[r].range()[1]) };
                }
                limit = largest(&limits);
            }
            loop {
                if stacks.together.len() == floor {
                    return ended;
                }
                let Some(next) = stacks.together.pop() else { return ended };
                if next.entry > limit {
                    continue;
                }
                let (node, child) = (&self.tree.nodes[next.node as usize], next.child as usize % WIDTH);
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
    while children != 0 {
        let child = children.trailing_zeros() as usize % WIDTH;
        children &= children - 1;
        let pushed = Waiting { node, child: child as u32, entry: entry[child] };
        stack.push(pushed);
        if V::IN_ORDER {
            let mut at = stack.len() - 1;
            while at > base && stack[at - 1].entry < pushed.entry {
                stack[at] = stack[at - 1];
                at -= 1;
            }
            stack[at] = pushed;
        }
    }
}
