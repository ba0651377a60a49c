//! Where the surface points of a picture are after instances have moved: a point keeps its place in its instance.

use glam::{DAffine3, DMat3, DVec3};
use rayon::prelude::*;

use super::hierarchy::Frame;
use crate::error::{Error, Result};
use crate::image::{GBuffer, Surfaces};
use crate::progress::Progress;
use crate::scene::{Camera, Scene};

/// Pixels between two looks at whether to go on.
const AT_ONCE: usize = 1 << 13;

/// What becomes of an instance's points.
enum Way {
    Stays,
    Moves {
        /// Relative to the origin of the positions, before and after.
        map: DAffine3,
        /// Inverse transpose of its linear part: keeps a normal on its side, also where the map mirrors.
        normal_map: DMat3,
    },
    /// An instance that was flat: its points have no one place in it.
    Lost,
}

/// The surface points that a camera sees in `before`, bit for bit where their instances stay, moved with their instances
/// where these stand elsewhere in `after`. Positions stay relative to the same origin; depths are the camera's, of points before
/// its near and behind its far plane 0 and 1. Points of a flattened instance that moves are left out: such pixels show
/// nothing.
///
/// # Errors
/// [`Error::InvalidArgument`] for scenes that differ in more than the places of their instances, and for an instance that they
/// have not; [`Error::Interrupted`].
pub fn moved_surfaces(
    surfaces: &Surfaces,
    depth: &[f32],
    camera: &Camera,
    [before, after]: [&Scene; 2],
    progress: &Progress,
) -> Result<GBuffer> {
    if !after.has_instances_of(before, progress)? {
        let of = |s: &Scene| format!("{} instances of {} meshes", s.instances().len(), s.meshes().len());
        let expected = format!("the meshes and instances of the scene before ({})", of(before));
        let fix = "move instances with scene.with_transforms";
        return Err(Error::argument("after", expected, format!("others ({})", of(after)), fix));
    }
    let way = |i: usize| {
        let (a, b) = (before.world_from_local(i), after.world_from_local(i));
        if a == b {
            return Way::Stays;
        }
        let [a, b] = [a, b].map(|m| DAffine3 { translation: m.translation - surfaces.origin, ..m });
        match Frame::new(a) {
            None => Way::Lost,
            Some(frame) => {
                let map = b * frame.local_from_world;
                Way::Moves { map, normal_map: normal_map(&map.matrix3) }
            }
        }
    };
    let ways: Vec<Way> = (0..before.instances().len()).into_par_iter().map(way).collect();
    let mut made = GBuffer {
        size: surfaces.size,
        origin: surfaces.origin,
        depth: depth.to_vec(),
        position: surfaces.position.to_vec(),
        normal: surfaces.normal.to_vec(),
        triangle: surfaces.triangle.to_vec(),
        instance: surfaces.instance.to_vec(),
    };
    let clip_from_world = camera.clip_from_world();
    for pixel in 0..made.triangle.len() {
        if pixel % AT_ONCE == 0 {
            progress.check()?;
        }
        let Some((point, normal)) = surfaces.receiver(pixel) else { continue };
        let index = surfaces.instance[pixel];
        let Some(way) = usize::try_from(index).ok().and_then(|i| ways.get(i)) else {
            let expected = format!("surfaces of the {} instances of the scene", ways.len());
            let fix = "draw it in the scene before";
            return Err(Error::argument("gbuffer", expected, format!("instance {index}"), fix));
        };
        let single = |v: DVec3| v.as_vec3().to_array();
        match way {
            Way::Stays => {}
            Way::Lost => {
                (made.triangle[pixel], made.instance[pixel], made.depth[pixel]) = (-1, -1, 1.0);
                (made.position[pixel], made.normal[pixel]) = ([0.0; 3], [0.0; 3]);
            }
            Way::Moves { map, normal_map } => {
                let point = map.transform_point3(point);
                made.position[pixel] = single(point);
                // Flattened by where it moves to, the plane has no normal of its own: the one it had will do.
                made.normal[pixel] = single((*normal_map * normal).try_normalize().unwrap_or(normal));
                let clip = clip_from_world * (surfaces.origin + point).extend(1.0);
                let is_before = clip.w > 0.0;
                made.depth[pixel] = if is_before { (clip.z / clip.w).clamp(0.0, 1.0) as f32 } else { 0.0 };
            }
        }
    }
    Ok(made)
}

/// The inverse transpose of a map, up to a positive factor: its cofactors on the side that the determinant says.
fn normal_map(map: &DMat3) -> DMat3 {
    let [x, y, z] = [map.x_axis, map.y_axis, map.z_axis];
    let cofactors = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y));
    if map.determinant() < 0.0 { -cofactors } else { cofactors }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_stay_on_their_side() {
        let sheared =
            DMat3::from_cols(DVec3::new(1.0, 0.3, 0.0), DVec3::new(-0.2, 2.0, 0.5), DVec3::new(0.0, 0.1, 0.7));
        for map in [sheared, sheared * DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0)), DMat3::IDENTITY * 1e-40] {
            let (u, v, normal) = (DVec3::new(0.3, 1.0, 0.2), DVec3::new(-1.0, 0.4, 0.9), DVec3::new(0.2, 0.1, -0.7));
            let plane_normal = u.cross(v);
            let moved = normal_map(&map) * plane_normal;
            let size = moved.length() * (map * u).length();
            assert!(moved.dot(map * u).abs() <= 1e-14 * size && moved.dot(map * v).abs() <= 1e-14 * size);
            assert_eq!((normal_map(&map) * plane_normal).dot(map * normal) > 0.0, plane_normal.dot(normal) > 0.0);
        }
    }
}
