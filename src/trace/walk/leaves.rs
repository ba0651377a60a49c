//! What a tree holds, shown to the rays of a bundle, and the triangles of a mesh as such.

use super::one_ray::Stack;
use super::stacks::Stacks;
use super::visitors::{Shown, Visitor};
use crate::trace::hierarchy::TracedMesh;
use crate::trace::kernel::Kernel;
use crate::trace::rays::{BUNDLE, Each, LocalRay, LocalRays, RayBits};

/// Rays at a leaf from which on it pays to look roughly first: that costs about as much as the exact test of two or three.
const WORTH_THE_ROUGH_TEST: u32 = 3;

/// Rays of a bundle at a leaf.
pub struct AtLeaf {
    /// Those whose walk ends.
    pub ended: RayBits,
    /// Those that may have seen anything.
    pub seen: RayBits,
}

/// What a tree holds.
pub trait Leaves<V> {
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
    /// Has a leaf brought into the cache: it is looked at soon.
    fn fetch<K: Kernel>(&self, leaf: usize);
    /// The leaf of it that last ended a ray.
    fn blocker(&self, stacks: &Stacks) -> Option<usize>;
}

/// The triangles of a mesh, as those of one of its instances.
pub struct Triangles<'a> {
    pub mesh: &'a TracedMesh,
    pub instance: u32,
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
        let near = if V::AHEAD {
            K::rays_near::<true>(leaf.packet, rays, bits)
        } else {
            K::rays_near::<false>(leaf.packet, rays, bits)
        };
        let mut seen = 0;
        for (lane, near) in near.into_iter().enumerate() {
            let mut near = near & !ended;
            let face = leaf.face(lane);
            // Shadow rays of a bundle mostly begin on one triangle, which is near all of them.
            if near != 0 && visitors[near.trailing_zeros() as usize % BUNDLE].skips(face) {
                near = Each(near).filter(|&r| !visitors[r].skips(face)).fold(0, |kept, r| kept | 1 << r);
            }
            if near != 0 {
                seen |= near;
                ended |= V::visit_together::<K>(visitors, &leaf, lane, rays, near);
            }
        }
        if ended != 0 {
            stacks.blocker = Some((self.instance, index));
        }
        AtLeaf { ended, seen }
    }
    #[inline(always)]
    fn fetch<K: Kernel>(&self, leaf: usize) {
        K::fetch(&self.mesh.packets[leaf]);
    }
    #[inline(always)]
    fn blocker(&self, stacks: &Stacks) -> Option<usize> {
        stacks.blocker.filter(|blocker| blocker.0 == self.instance).map(|blocker| blocker.1 as usize)
    }
}
