//! One ray's walk through the hierarchies, nearest boxes first.

use glam::{DAffine3, DVec3};

use super::visitors::{Shown, Visitor};
use crate::trace::hierarchy::{Inner, LEAF_BIT, NO_ITEM, Tree, WIDTH};
use crate::trace::kernel::Kernel;
use crate::trace::rays::{LocalRay, Shared, WorldRay, WorldRays};

/// Boxes still to be entered: the child's code and where the ray enters it.
pub type Stack = Vec<(u32, f32)>;

/// Shows the visitor everything that the ray may meet. True where the visitor ended it.
#[inline(always)]
pub fn traverse_one<K: Kernel, V: Visitor>(scene: &Inner, ray: &WorldRay, visitor: &mut V, stack: &mut Stack) -> bool {
    let Some(top) = &scene.top else { return traverse_instance::<K, V>(scene, 0, ray, visitor, stack) };
    let map = DAffine3::from_scale(DVec3::splat(scene.top_per_world));
    let band = visitor.band() * scene.top_per_world;
    let mut local = LocalRay::NONE;
    local.fill(&map, &top.bounds, &WorldRays::from([*ray]), Shared::Nothing, |_| visitor.range(), band, 1, false);
    local.together != 0
        && walk::<K, V>(top, top.root, &local, visitor, stack, |leaf, visitor, stack| {
            let mut instances = top.leaves[leaf].into_iter().take_while(|&i| i != NO_ITEM);
            instances.any(|i| traverse_instance::<K, V>(scene, i, ray, visitor, stack))
        })
}

/// Shows the visitor everything in an instance that the ray may meet. True where the visitor ended it.
#[inline(always)]
pub fn traverse_instance<K: Kernel, V: Visitor>(
    scene: &Inner,
    instance: u32,
    ray: &WorldRay,
    visitor: &mut V,
    stack: &mut Stack,
) -> bool {
    let placed = &scene.placed[instance as usize];
    let mesh = &scene.meshes[placed.mesh as usize];
    let frame = &placed.frame;
    let band = visitor.band() * frame.local_per_world;
    let bounds = &mesh.tree.bounds;
    let mut local = LocalRay::NONE;
    local.fill(
        &frame.local_from_world,
        bounds,
        &WorldRays::from([*ray]),
        Shared::Nothing,
        |_| visitor.range(),
        band,
        1,
        false,
    );
    if local.together == 0 {
        return false;
    }
    let line = local.line(0);
    walk::<K, V>(&mesh.tree, mesh.tree.root, &local, visitor, stack, |leaf, visitor, _| {
        visitor.visit::<K>(&Shown { mesh, packet: &mesh.packets[leaf], instance }, &line)
    })
}

/// Calls `at_leaf` for every leaf below `code` whose box the ray meets, about nearest first, until it answers true.
#[inline(always)]
pub fn walk<K: Kernel, V: Visitor>(
    tree: &Tree,
    mut code: u32,
    ray: &LocalRay,
    visitor: &mut V,
    stack: &mut Stack,
    mut at_leaf: impl FnMut(usize, &mut V, &mut Stack) -> bool,
) -> bool {
    let floor = stack.len();
    let mut limit = ray.slab_limit(0, visitor.range()[1]);
    loop {
        while code & LEAF_BIT == 0 {
            let node = &tree.nodes[code as usize];
            let (mut bits, entry) = K::boxes(node, ray, limit);
            if bits == 0 {
                match pop(stack, floor, limit) {
                    Some(next) => code = next,
                    None => return false,
                }
                continue;
            }
            let mut nearest = bits.trailing_zeros() as usize;
            bits &= bits - 1;
            if !V::IN_ORDER {
                while bits != 0 {
                    let child = bits.trailing_zeros() as usize % WIDTH;
                    bits &= bits - 1;
                    stack.push((node.children[child], entry[child]));
                }
            } else if bits != 0 {
                // Insertion into the stack keeps the nearest on top; two or three children are the rule.
                let base = stack.len();
                while bits != 0 {
                    let mut child = bits.trailing_zeros() as usize;
                    bits &= bits - 1;
                    if entry[child % WIDTH] < entry[nearest % WIDTH] {
                        std::mem::swap(&mut child, &mut nearest);
                    }
                    let pushed = (node.children[child % WIDTH], entry[child % WIDTH]);
                    stack.push(pushed);
                    let mut at = stack.len() - 1;
                    while at > base && stack[at - 1].1 < pushed.1 {
                        stack[at] = stack[at - 1];
                        at -= 1;
                    }
                    stack[at] = pushed;
                }
            }
            code = node.children[nearest % WIDTH];
        }
        if at_leaf((code & !LEAF_BIT) as usize, visitor, stack) {
            stack.truncate(floor);
            return true;
        }
        limit = ray.slab_limit(0, visitor.range()[1]);
        match pop(stack, floor, limit) {
            Some(next) => code = next,
            None => return false,
        }
    }
}

#[inline(always)]
fn pop(stack: &mut Stack, floor: usize, limit: f32) -> Option<u32> {
    while stack.len() > floor {
        if let Some((code, entry)) = stack.pop()
            && entry <= limit
        {
            return Some(code);
        }
    }
    None
}
