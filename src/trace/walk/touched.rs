//! The triangles that a light stands on: those that come nearer to a point than single precision resolves.
//!
//! ```text
//!   ____________L____  ceiling     which side of the ceiling the lamp is on is a matter of rounding, so the ceiling
//!              /                   shades nothing by itself
//!             /  the open segment
//!   _________P_______  floor
//! ```
//!
//! The distance to a triangle: Ericson 2005 `[ericson2005]`, section 5.1.5.

use glam::DVec3;

use crate::trace::hierarchy::{Face, Inner, LEAF_BIT, NO_ITEM, Tree, WIDTH};

/// Faces in ascending order; nearly always none.
#[derive(Debug, Default)]
pub struct Touched(Vec<Face>);

impl Touched {
    /// No face.
    pub const NONE: &'static Self = &Self(Vec::new());

    /// The faces whose distance from a point, relative to the scene's origin, is at most `reach` (world units).
    pub fn new(scene: &Inner, point: DVec3, reach: f64) -> Self {
        let mut found = Vec::new();
        // A scene without extent has no surface.
        if reach > 0.0 {
            match &scene.top {
                None => in_instance(scene, 0, point, reach, &mut found),
                Some(top) => boxes_near(top, point * scene.top_per_world, reach * scene.top_per_world, |leaf| {
                    for instance in top.leaves[leaf].into_iter().take_while(|&i| i != NO_ITEM) {
                        in_instance(scene, instance, point, reach, &mut found);
                    }
                }),
            }
        }
        found.sort_unstable();
        Self(found)
    }
    /// Whether a face is one of them.
    #[inline(always)]
    pub fn has(&self, face: Face) -> bool {
        !self.0.is_empty() && self.0.binary_search(&face).is_ok()
    }
}

fn in_instance(scene: &Inner, instance: u32, point: DVec3, reach: f64, found: &mut Vec<Face>) {
    let placed = &scene.placed[instance as usize];
    let mesh = &scene.meshes[placed.mesh as usize];
    let local = placed.frame.local_from_world.transform_point3(point);
    boxes_near(&mesh.tree, local, reach * placed.frame.local_per_world, |leaf| {
        for triangle in mesh.packets[leaf].triangles.into_iter().filter(|&t| t != NO_ITEM) {
            // In units of the reach, so that no product leaves the range of f64.
            let corners = scene.corners(instance, triangle).map(|p| (p - point) / reach);
            if nearest_to_origin(corners).length_squared() <= 1.0 {
                found.push((instance, triangle));
            }
        }
    });
}

/// Calls `at_leaf` for every leaf whose box may come within `reach` of a point.
fn boxes_near(tree: &Tree, point: DVec3, reach: f64, mut at_leaf: impl FnMut(usize)) {
    // The point is a f64 rounding away from where it should be, less than half of the reach, and boxes are f32.
    let reach = 2.0 * reach;
    let mut codes = vec![tree.root];
    while let Some(code) = codes.pop() {
        if code & LEAF_BIT != 0 {
            at_leaf((code & !LEAF_BIT) as usize);
            continue;
        }
        let node = &tree.nodes[code as usize];
        let is_near = |child: &usize| {
            (0..3).all(|axis| {
                let [low, high] = [node.planes[2 * axis][*child], node.planes[2 * axis + 1][*child]].map(f64::from);
                (low - reach..=high + reach).contains(&point[axis])
            })
        };
        codes.extend((0..WIDTH).filter(is_near).map(|child| node.children[child]));
    }
}

/// The point of a triangle that is nearest to the origin.
fn nearest_to_origin([a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let [along_ab, along_ac] = [-ab.dot(a), -ac.dot(a)];
    if along_ab <= 0.0 && along_ac <= 0.0 {
        return a;
    }
    let [beyond_b, b_along_ac] = [-ab.dot(b), -ac.dot(b)];
    if beyond_b >= 0.0 && b_along_ac <= beyond_b {
        return b;
    }
    let [c_along_ab, beyond_c] = [-ab.dot(c), -ac.dot(c)];
    if beyond_c >= 0.0 && c_along_ab <= beyond_c {
        return c;
    }
    let part = |share: f64, whole: f64| if whole > 0.0 { (share / whole).clamp(0.0, 1.0) } else { 0.0 };
    let of_c = along_ab * b_along_ac - beyond_b * along_ac;
    if of_c <= 0.0 && along_ab >= 0.0 && beyond_b <= 0.0 {
        return a + part(along_ab, along_ab - beyond_b) * ab;
    }
    let of_b = c_along_ab * along_ac - along_ab * beyond_c;
    if of_b <= 0.0 && along_ac >= 0.0 && beyond_c <= 0.0 {
        return a + part(along_ac, along_ac - beyond_c) * ac;
    }
    let of_a = beyond_b * beyond_c - c_along_ab * b_along_ac;
    let (towards_c, towards_b) = (b_along_ac - beyond_b, c_along_ab - beyond_c);
    if of_a <= 0.0 && towards_c >= 0.0 && towards_b >= 0.0 {
        return b + part(towards_c, towards_c + towards_b) * bc;
    }
    let all = of_a + of_b + of_c;
    a + part(of_b, all) * ab + part(of_c, all) * ac
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The nearest of many points of the triangle is no nearer, and one of them is nearly as near.
    #[test]
    fn no_point_of_a_triangle_is_nearer() {
        let mut state = 5u64;
        let mut random = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as f64 / f64::from(1u32 << 30) - 1.0
        };
        let mut vector = || DVec3::new(random(), random(), random());
        for case in 0..500 {
            let a = vector() + 0.7 * vector();
            let (mut b, mut c) = (a + vector(), a + vector());
            match case % 5 {
                0 => c = a.lerp(b, 0.4),
                1 => (b, c) = (a, a),
                2 => c = b,
                _ => {}
            }
            let nearest = nearest_to_origin([a, b, c]).length();
            let steps = 60;
            let all = (0..=steps).flat_map(|i| (0..=steps - i).map(move |j| (i, j)));
            let at = |(i, j): (i32, i32)| {
                let [u, v] = [i, j].map(|k| f64::from(k) / f64::from(steps));
                (a + u * (b - a) + v * (c - a)).length()
            };
            let best = all.map(at).fold(f64::INFINITY, f64::min);
            assert!(nearest <= best + 1e-12 && best - nearest < 0.06, "{case}: {nearest} {best}");
        }
    }
}
