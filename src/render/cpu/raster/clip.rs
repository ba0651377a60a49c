//! Clipping of the few triangles that need it, in homogeneous space.
//!
//! Source: Sutherland, Hodgman 1974 `[sutherland1974]`, on the planes z >= n w (n is 0 or -1), z <= (n + 2) w and the guard
//! band |x| <= g w, |y| <= g w. Together the first two give w >= 0, so nothing behind the projection centre is ever divided.
//! Vertices that are kept keep the screen coordinates the fast path gives them; an edge is cut from its inner to its outer
//! end, so neighbours that share it cut it at the same point. Only edges with an end that bears [`CLIP`] are cut: triangles
//! on both sides of such an edge come here.

use super::vertices::{CLIP, FAR_GUARD, ScreenVertex, Viewport};

/// A corner of the polygon: its clip coordinates, and its screen vertex where it is one of the triangle's own.
#[derive(Debug, Clone, Copy)]
struct Corner {
    clip: [f64; 4],
    own: Option<ScreenVertex>,
}

/// A vertex on the screen, and its grid position and depth before they were rounded.
#[derive(Debug, Clone, Copy)]
pub struct ExactVertex {
    pub screen: ScreenVertex,
    pub exact: [f64; 3],
}

/// The screen polygon (convex, in order) that is left of a triangle, in `out`; fewer than three vertices: nothing.
///
/// `clip` are the corners' clip coordinates, `screen` what the fast path made of them.
pub fn clip_triangle(viewport: &Viewport, clip: [[f64; 4]; 3], screen: [ScreenVertex; 3], out: &mut Vec<ExactVertex>) {
    let [gx, gy] = viewport.guard.map(f64::from);
    let near = f64::from(viewport.near);
    let planes: [[f64; 4]; 6] = [
        [0.0, 0.0, 1.0, -near],
        [0.0, 0.0, -1.0, near + f64::from(FAR_GUARD)],
        [1.0, 0.0, 0.0, gx],
        [-1.0, 0.0, 0.0, gx],
        [0.0, 1.0, 0.0, gy],
        [0.0, -1.0, 0.0, gy],
    ];
    let mut polygon: Vec<Corner> =
        (0..3).map(|k| Corner { clip: clip[k], own: (screen[k].code & CLIP == 0).then_some(screen[k]) }).collect();
    for plane in planes {
        let distance = |c: &Corner| {
            let d = c.clip.iter().zip(plane).map(|(x, p)| x * p).sum::<f64>();
            // Inside, as the fast path has found, whatever a rounding says.
            if c.own.is_some() { d.max(0.0) } else { d }
        };
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (i, current) in polygon.iter().enumerate() {
            let next = &polygon[(i + 1) % polygon.len()];
            let (d0, d1) = (distance(current), distance(next));
            if d0 >= 0.0 {
                kept.push(*current);
            }
            if d0 >= 0.0 && d1 < 0.0 {
                kept.push(cut(current, next, d0, d1, plane));
            } else if d0 < 0.0 && d1 >= 0.0 {
                kept.push(cut(next, current, d1, d0, plane));
            }
        }
        polygon = kept;
    }
    out.clear();
    // w = 0 is left only at the projection centre itself (x = y = z = w = 0), which has no direction to be seen in.
    out.extend(polygon.iter().filter_map(|c| match c.own {
        Some(screen) => Some(ExactVertex { screen, exact: exact_position(viewport, c.clip, screen) }),
        None => projected(viewport, c.clip),
    }));
}

/// The point of the edge on the plane, from the end inside (d0 >= 0) to the one outside (d1 < 0).
fn cut(inside: &Corner, outside: &Corner, d0: f64, d1: f64, plane: [f64; 4]) -> Corner {
    let t = d0 / (d0 - d1);
    let mut clip: [f64; 4] = std::array::from_fn(|i| inside.clip[i] + t * (outside.clip[i] - inside.clip[i]));
    // Exactly on the near plane: rounding must not put it a hair before.
    if plane[2] == 1.0 {
        clip[2] = -plane[3] * clip[3];
    }
    Corner { clip, own: None }
}

/// Grid position and depth in f64 of a vertex with the given clip coordinates, whose screen vertex is `screen`.
pub fn exact_position(viewport: &Viewport, clip: [f64; 4], screen: ScreenVertex) -> [f64; 3] {
    let exact = viewport.project_exactly(clip);
    // Where rounding to f32 alone has made w positive there is nothing better than what f32 says.
    if clip[3] > 0.0 && exact.iter().all(|v| v.is_finite()) {
        exact
    } else {
        [screen.x, screen.y, screen.z].map(f64::from)
    }
}

fn projected(viewport: &Viewport, clip: [f64; 4]) -> Option<ExactVertex> {
    let [x, y, z, w] = clip;
    if w <= 0.0 {
        return None;
    }
    // Divided in f64: w may be far below the range of f32. The guard is enforced against the rounding of the cuts.
    let [gx, gy] = viewport.guard.map(f64::from);
    let near = f64::from(viewport.near);
    let ndc = [(x / w).clamp(-gx, gx), (y / w).clamp(-gy, gy), (z / w).clamp(near, near + f64::from(FAR_GUARD))];
    let exact = viewport.project_exactly([ndc[0], ndc[1], ndc[2], 1.0]);
    let [x, y, z] = exact.map(|v| v as f32);
    Some(ExactVertex { screen: ScreenVertex { x, y, z, code: 0 }, exact })
}
