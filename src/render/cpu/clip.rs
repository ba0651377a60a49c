//! Clipping of the few triangles that need it, in homogeneous space.
//!
//! Source: I. Sutherland, G. Hodgman, Reentrant polygon clipping (1974), on the planes z >= 0, z <= w and the guard band
//! |x| <= g w, |y| <= g w. Together the first two give w >= 0, so nothing behind the projection centre is ever divided.
//! Vertices that are kept keep the screen coordinates the fast path gives them; an edge is cut from its inner to its outer
//! end, so neighbours that share it cut it at the same point.

use super::screen::{CLIP, ScreenVertex, Viewport};

/// A corner of the polygon: its clip coordinates, and its screen vertex where it is one of the triangle's own.
#[derive(Debug, Clone, Copy)]
struct Corner {
    clip: [f64; 4],
    own: Option<ScreenVertex>,
}

/// The screen polygon (convex, in order) that is left of a triangle, in `out`; fewer than three vertices: nothing.
///
/// `clip` are the corners' clip coordinates, `screen` what the fast path made of them.
pub fn clip_triangle(viewport: &Viewport, clip: [[f32; 4]; 3], screen: [ScreenVertex; 3], out: &mut Vec<ScreenVertex>) {
    let [gx, gy] = viewport.guard.map(f64::from);
    let planes: [[f64; 4]; 6] = [
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, -1.0, 1.0],
        [1.0, 0.0, 0.0, gx],
        [-1.0, 0.0, 0.0, gx],
        [0.0, 1.0, 0.0, gy],
        [0.0, -1.0, 0.0, gy],
    ];
    let mut polygon: Vec<Corner> = (0..3)
        .map(|k| Corner { clip: clip[k].map(f64::from), own: (screen[k].code & CLIP == 0).then_some(screen[k]) })
        .collect();
    for plane in planes {
        let distance = |c: &Corner| c.clip.iter().zip(plane).map(|(x, p)| x * p).sum::<f64>();
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
    out.extend(polygon.iter().filter_map(|c| c.own.or_else(|| projected(viewport, c.clip))));
}

/// The point of the edge on the plane, from the end inside (d0 >= 0) to the one outside (d1 < 0).
fn cut(inside: &Corner, outside: &Corner, d0: f64, d1: f64, plane: [f64; 4]) -> Corner {
    let t = d0 / (d0 - d1);
    let mut clip: [f64; 4] = std::array::from_fn(|i| inside.clip[i] + t * (outside.clip[i] - inside.clip[i]));
    // Exactly on the near plane: rounding must not put it a hair before.
    if plane[2] == 1.0 {
        clip[2] = 0.0;
    }
    Corner { clip, own: None }
}

fn projected(viewport: &Viewport, clip: [f64; 4]) -> Option<ScreenVertex> {
    let [x, y, z, w] = clip;
    if w <= 0.0 {
        return None;
    }
    // Divided in f64: w may be far below the range of f32. The guard is enforced against the rounding of the cuts.
    let [gx, gy] = viewport.guard.map(f64::from);
    let ndc = [(x / w).clamp(-gx, gx), (y / w).clamp(-gy, gy), (z / w).clamp(0.0, 1.0)];
    let [x, y, z] = viewport.project([ndc[0] as f32, ndc[1] as f32, ndc[2] as f32, 1.0]);
    Some(ScreenVertex { x, y, z, code: 0 })
}
