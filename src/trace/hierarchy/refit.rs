//! A tree whose boxes have moved: the same tree with larger boxes while that is good enough, and a new one otherwise.
//!
//! Refitting (Lauterbach, Yoon, Tuft, Manocha 2006 `[lauterbach2006]`) keeps who is whose child and takes boxes
//! anew from the leaves up. Rays find the same, as what is in a box stays in it; they only enter more boxes, the less the
//! order of the children fits where they are now. How many is what the surface-area heuristic estimates: the chance that a ray
//! which meets the root enters a node is about the ratio of their areas. That sum is compared with the sum at the
//! last build rather than with a limit of its own, so that it works for any scene.

use super::build::Item;
use super::tree::{Box3, LEAF_BIT, NO_ITEM, Node, Tree, WIDTH};
use crate::error::Result;
use crate::progress::Progress;

/// Growth of a tree's cost over that at its last build, above which it is built anew. Chosen because, in forest and robots of
/// `benches/moves.rs`, truth by a tree that grew by 1.2 takes as long as by a new one, by 1.7 it takes 1.1 to 1.4 times as
/// long, and by 2.8 twice; what a build takes longer than refitting is 2 % of tracing 512 x 288 pixels.
const MOST_GROWTH: f64 = 1.2;
/// Nodes between two looks at whether to go on.
const AT_ONCE: usize = 1 << 14;

/// The tree over items with at most one of them in a leaf, and what it cost when it was built. `before` is such a tree with
/// its cost, over the same items in other places; item i has the id i.
///
/// # Errors
/// [`Error::Interrupted`](crate::Error::Interrupted).
pub fn refitted_or_built(items: Vec<Item>, before: Option<(&Tree, f64)>, progress: &Progress) -> Result<(Tree, f64)> {
    if let Some((tree, built_cost)) = before.filter(|(tree, _)| tree.leaves.len() == items.len()) {
        let tree = refitted(tree, &items, progress)?;
        // False for NaN: of a tree without extent nothing is known.
        if cost(&tree) <= MOST_GROWTH * built_cost {
            return Ok((tree, built_cost));
        }
    }
    let tree = Tree::build::<1>(items, progress)?;
    let cost = cost(&tree);
    Ok((tree, cost))
}

/// The tree with boxes about where the items are now.
fn refitted(tree: &Tree, items: &[Item], progress: &Progress) -> Result<Tree> {
    let mut nodes = tree.nodes.clone();
    let mut bounds = vec![Box3::EMPTY; nodes.len()];
    let of_leaf = |leaf: u32| {
        let ids = tree.leaves[leaf as usize].iter().take_while(|&&id| id != NO_ITEM);
        ids.fold(Box3::EMPTY, |b, &id| b.union(items[id as usize].bounds()))
    };
    // Backwards, since children come after their parents.
    for index in (0..nodes.len()).rev() {
        if index % AT_ONCE == 0 {
            progress.check()?;
        }
        let before = nodes[index];
        let mut node = Node::EMPTY;
        for slot in used(&before) {
            let code = before.children[slot];
            let child = if code & LEAF_BIT != 0 { of_leaf(code & !LEAF_BIT) } else { bounds[code as usize] };
            node.set(slot, &child, code);
            bounds[index] = bounds[index].union(child);
        }
        nodes[index] = node;
    }
    let root = if tree.root & LEAF_BIT != 0 { of_leaf(tree.root & !LEAF_BIT) } else { bounds[tree.root as usize] };
    Ok(Tree { root: tree.root, bounds: root, nodes, leaves: tree.leaves.clone() })
}

/// How many nodes a ray that meets the tree enters, by the ratio of their areas to the root's. Leaves count alike in every
/// tree over the same items, so they are left out. NaN where the root has no area.
fn cost(tree: &Tree) -> f64 {
    let inner = |node: &Node| -> f64 {
        used(node).filter(|&slot| node.children[slot] & LEAF_BIT == 0).map(|slot| f64::from(area(node, slot))).sum()
    };
    1.0 + tree.nodes.iter().map(inner).sum::<f64>() / f64::from(tree.bounds.half_area())
}

fn used(node: &Node) -> impl Iterator<Item = usize> + use<> {
    let lower_and_upper = [node.planes[0], node.planes[1]];
    (0..WIDTH).filter(move |&slot| lower_and_upper[0][slot] <= lower_and_upper[1][slot])
}

fn area(node: &Node, slot: usize) -> f32 {
    let corner = |side: usize| [0, 2, 4].map(|axis| node.planes[axis + side][slot]).into();
    Box3 { min: corner(0), max: corner(1) }.half_area()
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    fn items(count: u32, place: impl Fn(f32) -> Vec3) -> Vec<Item> {
        let item = |id| {
            let min = place(id as f32);
            Item::new(Box3 { min, max: min + 0.1 }, id)
        };
        (0..count).map(item).collect()
    }
    fn scattered(k: f32) -> Vec3 {
        Vec3::new((k * 12.9898).sin(), (k * 78.233).sin(), (k * 37.719).sin()) * 20.0
    }
    fn built(items: &[Item]) -> (Tree, f64) {
        refitted_or_built(items.to_vec(), None, &Progress::new()).unwrap()
    }

    #[test]
    fn every_box_is_as_small_as_it_can_be() {
        fn check(tree: &Tree, items: &[Item], code: u32) -> (Box3, usize) {
            if code & LEAF_BIT != 0 {
                let id = tree.leaves[(code & !LEAF_BIT) as usize][0];
                return (items[id as usize].bounds(), 1);
            }
            let node = &tree.nodes[code as usize];
            used(node).fold((Box3::EMPTY, 0), |(bounds, count), slot| {
                let (child, below) = check(tree, items, node.children[slot]);
                let at = |side: usize| Vec3::from([0, 2, 4].map(|axis| node.planes[axis + side][slot]));
                assert_eq!((at(0), at(1)), (child.min, child.max));
                (bounds.union(child), count + below)
            })
        }
        let (before, after) = (items(3000, scattered), items(3000, |k| scattered(1.7 * k) * 3.0));
        let tree = refitted(&built(&before).0, &after, &Progress::new()).unwrap();
        assert_eq!(check(&tree, &after, tree.root), (tree.bounds, 3000));
    }

    #[test]
    fn a_tree_is_kept_where_little_moved_and_built_anew_where_all_did() {
        let before = items(3000, scattered);
        let (tree, cost_before) = built(&before);
        let kept = |after: Vec<Item>| {
            let (found, built_cost) =
                refitted_or_built(after.clone(), Some((&tree, cost_before)), &Progress::new()).unwrap();
            let is_kept = found.leaves == tree.leaves;
            assert_eq!(built_cost, if is_kept { cost_before } else { built(&after).1 });
            assert!(cost(&found) <= MOST_GROWTH * built_cost);
            is_kept
        };
        assert!(kept(before.clone()));
        assert!(kept(items(3000, |k| scattered(k) + 0.3 * scattered(k + 0.5) / 20.0)));
        // A scene that is as it was, larger and elsewhere.
        assert!(kept(items(3000, |k| scattered(k) * 2.0 + 100.0)));
        assert!(!kept(items(3000, |k| scattered(3000.0 - k))));
        // Another number of items is another tree.
        let (fewer, _) =
            refitted_or_built(items(2999, scattered), Some((&tree, cost_before)), &Progress::new()).unwrap();
        assert_eq!(fewer.leaves.len(), 2999);
    }

    #[test]
    fn items_without_extent_are_built() {
        let flat: Vec<Item> = (0..50).map(|id| Item::new(Box3 { min: Vec3::ONE, max: Vec3::ONE }, id)).collect();
        let (tree, cost) = built(&flat);
        assert!(cost.is_nan());
        let (again, _) = refitted_or_built(flat, Some((&tree, cost)), &Progress::new()).unwrap();
        assert_eq!(again.leaves.len(), 50);
    }
}
