//! A bundle's walk through the hierarchies. Where its rays part, each goes on alone.

use glam::{DAffine3, DVec3};

use super::leaves::{AtLeaf, Leaves, Triangles};
use super::one_ray::{Stack, traverse_instance, walk};
use super::stacks::{Stacks, Waiting};
use super::visitors::Visitor;
use crate::trace::hierarchy::{Inner, LEAF_BIT, NO_ITEM, Tree, WIDTH};
use crate::trace::kernel::Kernel;
use crate::trace::rays::{BUNDLE, Bundle, Each, Hull, LocalRay, LocalRays, RayBits, Shared, WorldRays, largest};

/// Rays below which each goes alone. Of two together each node takes about as long as of both alone, but there are fewer of them.
const FEW: u32 = 2;

/// Of a ray that has nothing left to look for: no box is met at a negative parameter.
const ENDED: f32 = -1.0;

/// The instances of a scene.
struct Instances<'a> {
    scene: &'a Inner,
    top: &'a Tree,
    rays: &'a WorldRays<BUNDLE>,
    shared: Shared,
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
        self.of(leaf).any(|i| traverse_instance::<K, V>(self.scene, i, &self.rays.get(lane), visitor, stack))
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
            ended |= instance_together::<K, V>(self.scene, i, self.rays, self.shared, bits & !ended, visitors, stacks);
        }
        AtLeaf { ended, seen: bits }
    }
    #[inline(always)]
    fn fetch<K: Kernel>(&self, _: usize) {}
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
    rays: &WorldRays<BUNDLE>,
    bits: RayBits,
    visitors: &mut [V; BUNDLE],
    stacks: &mut Stacks,
) -> RayBits {
    let shared = V::SHARED.or_nothing(rays, bits);
    let Some(top) = &scene.top else {
        return instance_together::<K, V>(scene, 0, rays, shared, bits, visitors, stacks);
    };
    let map = DAffine3::from_scale(DVec3::splat(scene.top_per_world));
    let leaves = Instances { scene, top, rays, shared };
    in_frame::<K, V, _>(top, &map, scene.top_per_world, &leaves, rays, shared, bits, visitors, stacks)
}

#[inline(always)]
fn instance_together<K: Kernel, V: Visitor>(
    scene: &Inner,
    instance: u32,
    rays: &WorldRays<BUNDLE>,
    shared: Shared,
    bits: RayBits,
    visitors: &mut [V; BUNDLE],
    stacks: &mut Stacks,
) -> RayBits {
    let placed = &scene.placed[instance as usize];
    let mesh = &scene.meshes[placed.mesh as usize];
    let leaves = Triangles { mesh, instance };
    let (map, scale) = (&placed.frame.local_from_world, placed.frame.local_per_world);
    in_frame::<K, V, _>(&mesh.tree, map, scale, &leaves, rays, shared, bits, visitors, stacks)
}

#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn in_frame<K: Kernel, V: Visitor, L: Leaves<V>>(
    tree: &Tree,
    local_from_world: &DAffine3,
    local_per_world: f64,
    leaves: &L,
    rays: &WorldRays<BUNDLE>,
    shared: Shared,
    bits: RayBits,
    visitors: &mut [V; BUNDLE],
    stacks: &mut Stacks,
) -> RayBits {
    // All visitors of a bundle ask for the same band.
    let band = visitors[0].band() * local_per_world;
    // Not a new one, which costs about as much to clear as a box to enter.
    let mut local = stacks.frames.pop().unwrap_or_else(|| Box::new(LocalRays::NONE));
    // Of no third kind for this visitor, which the compiler then knows.
    let shared = if shared == Shared::Nothing { shared } else { V::SHARED };
    local.fill(local_from_world, &tree.bounds, rays, shared, |r| visitors[r].range(), band, bits, L::TRIANGLES);
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
    if tree.root & LEAF_BIT != 0 {
        if together != 0 {
            ended |= leaves.together::<K>((tree.root & !LEAF_BIT) as usize, &local, together, visitors, stacks).ended;
        }
    } else if together.count_ones() < FEW {
        ended |= walk.alone::<K, V>(tree.root, &local, together, visitors, stacks);
    } else {
        let bundle = Bundle { hull: Hull::new(&local, together), rays: &local };
        ended |= walk.together::<K, V>(&bundle, together, visitors, stacks);
    }
    if apart != 0 {
        ended |= walk.apart::<K, V>(apart, visitors, stacks);
    }
    stacks.frames.push(local);
    ended
}

/// A tree in its frame, and the rays that walk through it.
struct Walk<'a, L> {
    tree: &'a Tree,
    local_from_world: &'a DAffine3,
    band: f64,
    leaves: &'a L,
    rays: &'a WorldRays<BUNDLE>,
}

impl<L> Walk<'_, L> {
    /// Each ray by itself, from a child's code on.
    #[inline(always)]
    fn alone<K: Kernel, V: Visitor>(
        &self,
        code: u32,
        local: &LocalRays<BUNDLE>,
        bits: RayBits,
        visitors: &mut [V; BUNDLE],
        stacks: &mut Stacks,
    ) -> RayBits
    where
        L: Leaves<V>,
    {
        let mut ended = 0;
        for r in Each(bits) {
            let ray = local.alone(r);
            ended |= u32::from(self.one::<K, V>(code, r, &ray, &mut visitors[r], &mut stacks.alone)) << r;
        }
        ended
    }

    /// Each of the rays that have not the way of the others, from the root on.
    #[cold]
    #[inline(never)]
    fn apart<K: Kernel, V: Visitor>(&self, bits: RayBits, visitors: &mut [V; BUNDLE], stacks: &mut Stacks) -> RayBits
    where
        L: Leaves<V>,
    {
        let mut ended = 0;
        for r in Each(bits) {
            let visitor = &mut visitors[r];
            let (world, range) = (WorldRays::from([self.rays.get(r)]), visitor.range());
            let mut ray = LocalRay::NONE;
            ray.fill(self.local_from_world, &self.tree.bounds, &world, Shared::Nothing, |_| range, self.band, 1, false);
            let is_there = ray.together != 0;
            let is_ended = is_there && self.one::<K, V>(self.tree.root, r, &ray, visitor, &mut stacks.alone);
            ended |= u32::from(is_ended) << r;
        }
        ended
    }

    #[inline(always)]
    fn one<K: Kernel, V: Visitor>(
        &self,
        code: u32,
        r: usize,
        ray: &LocalRay,
        visitor: &mut V,
        stack: &mut Stack,
    ) -> bool
    where
        L: Leaves<V>,
    {
        let at_leaf = |leaf, visitor: &mut V, stack: &mut Stack| self.leaves.alone::<K>(leaf, r, ray, visitor, stack);
        walk::<K, V>(self.tree, code, ray, visitor, stack, at_leaf)
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
        let mut ends = [0.0; BUNDLE];
        for r in 0..BUNDLE {
            ends[r] = visitors[r].range()[1];
        }
        let mut limits = bundle.rays.slab_limits(&ends);
        for r in 0..BUNDLE {
            limits[r] = if (bits >> r) & 1 != 0 { limits[r] } else { ENDED };
        }
        let mut limit = largest(&limits);
        let (mut code, mut met, mut ended) = (self.tree.root, bits, 0);
        loop {
            let is_leaf = code & LEAF_BIT != 0;
            if !is_leaf && met.count_ones() >= FEW {
                let node = &self.tree.nodes[code as usize];
                let (children, entry) = K::hull_boxes(node, &bundle.hull, limit);
                if children.is_power_of_two() {
                    // The only way on, of nearly all rays: those that miss its box find nothing below.
                    code = node.children[children.trailing_zeros() as usize % WIDTH];
                    continue;
                }
                push::<V>(&mut stacks.together, code, children, &entry, |child| {
                    let code = node.children[child];
                    if code & LEAF_BIT != 0 {
                        self.leaves.fetch::<K>((code & !LEAF_BIT) as usize);
                    } else {
                        K::fetch(&self.tree.nodes[code as usize]);
                    }
                });
            } else {
                let at = if is_leaf {
                    self.leaves.together::<K>((code & !LEAF_BIT) as usize, bundle.rays, met, visitors, stacks)
                } else {
                    AtLeaf { ended: self.alone::<K, V>(code, bundle.rays, met, visitors, stacks), seen: met }
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

/// Puts children on the stack, the nearest on top where that matters, and calls `fetch` with each.
#[inline(always)]
fn push<V: Visitor>(
    stack: &mut Vec<Waiting>,
    node: u32,
    mut children: u32,
    entry: &[f32; WIDTH],
    fetch: impl Fn(usize),
) {
    let base = stack.len();
    // Once for all: then nothing below asks for memory.
    stack.reserve(WIDTH);
    while children != 0 {
        let child = children.trailing_zeros() as usize % WIDTH;
        children &= children - 1;
        fetch(child);
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
