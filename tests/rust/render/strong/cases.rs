//! Strong homographies and scenes that show under them.

use std::sync::Arc;

use glam::{DMat4, DVec3, DVec4};
use shadowlab::scene::Instance;
use shadowlab::{Mesh, Scene};

use crate::render::strong::oracle::{bounds, judge};
use crate::support::cpu::{Random, triangle_mesh};

/// How w varies over the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Family {
    /// Along one axis of the light's plane, constant along rays, as under LiSPSM: w = 0 is a plane.
    AlongOneAxis,
    /// As of an eye in the middle of the map's rays, looked at from the side, as under PSM.
    Eye,
    /// Along one axis, with a depth row that is nearly w's: depth tells next to nothing.
    FlatDepth,
}

impl Family {
    pub const ALL: [Self; 3] = [Self::AlongOneAxis, Self::Eye, Self::FlatDepth];

    /// `clip_from_world`, with w from 1 / `ratio` to 1 over the map, in a world of size 1, turned and moved.
    pub fn matrix(self, ratio: f64) -> DMat4 {
        let (near, far) = (1.0 / ratio, 1.0);
        // w = y' in [near, far] goes to NDC y in [-1, 1].
        let y_row = DVec4::new(0.0, (far + near) / (far - near), 0.0, -2.0 * far * near / (far - near));
        let w_row = DVec4::new(0.0, 1.0, 0.0, 0.0);
        let x_row = DVec4::new(1.3, 0.0, 0.0, 0.0);
        let clip = match self {
            // Depth from -1 to 1 along the rays, at every w.
            Self::AlongOneAxis => DMat4::from_cols(x_row, y_row, DVec4::new(0.0, 0.0, 0.2 * near, 0.4 * near), w_row),
            // Rays through the eye's space become parallel to its post-perspective z.
            Self::Eye => DMat4::from_cols(x_row, y_row, DVec4::new(0.0, 0.5, 0.45, 0.0), w_row),
            Self::FlatDepth => DMat4::from_cols(x_row, y_row, DVec4::new(0.0, 0.5, 0.05 * near, 0.0), w_row),
        };
        clip.transpose() * turned().inverse()
    }
}

/// World from the frame in which matrices are made.
fn turned() -> DMat4 {
    DMat4::from_translation(DVec3::new(3.0, -1.0, 0.5))
        * DMat4::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.8)
}

/// A few hundred triangles: most of them the size that they show at, at all w; some huge, many with corners behind w = 0.
pub fn case(family: Family, ratio: f64, seed: u64) -> (Scene, DMat4) {
    let clip_from_world = family.matrix(ratio);
    let world_from_clip = clip_from_world.inverse();
    let mut random = Random(seed + 1);
    let mut corners = vec![];
    for i in 0..240 {
        let mut ndc = DVec3::new(random.number(-1.1, 1.1), random.number(-1.1, 1.1), random.number(0.05, 0.95));
        if i % 2 == 0 {
            // Most of the world lies near y = 1 in the map.
            ndc.y = 1.0 - 2.0 * ratio.powf(-random.number(0.0, 1.0));
        }
        let reach = [0.05, 0.2, 1.0][i % 3];
        corners.push([0, 1, 2].map(|_| {
            let p = ndc + reach * random.vector(-1.0, 1.0) * DVec3::new(1.0, 1.0, 0.3);
            let p = world_from_clip * p.extend(1.0);
            p.truncate() / p.w
        }));
    }
    let (center, reach) = (turned().transform_point3(DVec3::Y * 0.5), 3.0);
    for _ in 0..40 {
        corners.push([0, 1, 2].map(|_| center + random.vector(-reach, reach)));
    }
    // Half of them in one mesh, half on their own: small ones keep digits that a shared mesh has no room for.
    let (together, alone) = corners.split_at(corners.len() / 2);
    let mut meshes = vec![triangle_mesh(together)];
    meshes.extend(alone.iter().map(|&t| triangle_mesh(&[t])));
    let place = |mesh: usize| Instance { mesh: mesh as u32, world_from_mesh: glam::DAffine3::IDENTITY };
    let instances = (0..meshes.len()).map(place).collect();
    (Scene::new(meshes.into_iter().map(Arc::new).collect(), instances).unwrap(), clip_from_world)
}

/// A tessellated plane that covers the map and goes on behind w = 0.
pub fn ground(family: Family, ratio: f64) -> (Scene, DMat4) {
    const N: i64 = 40;
    let world_from_made = turned();
    let vertices: Vec<[f64; 3]> = (0..=N)
        .flat_map(|j| (0..=N).map(move |i| (i, j)))
        .map(|(i, j)| {
            let x = 4.0 * (i as f64 / N as f64 - 0.5);
            // As fine towards w = 0 as beyond it.
            let t = 2.0 * (j as f64 / N as f64) - 0.6;
            world_from_made.transform_point3(DVec3::new(x, t.powi(3), 0.3 * t.powi(3))).to_array()
        })
        .collect();
    let at = |i: i64, j: i64| j * (N + 1) + i;
    let faces: Vec<[i64; 3]> = (0..N)
        .flat_map(|j| (0..N).map(move |i| (i, j)))
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]])
        .collect();
    (Scene::from_mesh(Mesh::new(&vertices, &faces).unwrap()).unwrap(), family.matrix(ratio))
}

/// Size of the maps.
pub const SIZE: [u32; 2] = [96, 80];
/// The ratios of w that are tried.
pub const RATIOS: [f64; 7] = [1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7];

/// Holds the maps that `draw` makes of scattered triangles against rays; prints what was found.
pub fn assert_no_triangle_is_lost(draw: impl Fn(&Scene, DMat4) -> Vec<f32>) {
    for family in Family::ALL {
        for ratio in RATIOS {
            let (mut texels, mut sharp) = (0, 0);
            for seed in 0..4 {
                let (scene, clip_from_world) = case(family, ratio, seed);
                let v = judge(&draw(&scene, clip_from_world), &bounds(&scene, &clip_from_world, SIZE));
                let what = format!("{family:?}, {ratio:e}, seed {seed}");
                println!("{what}: {} of {} sharp, {} covered, {} wrong", v.sharp, v.texels, v.covered, v.wrong.len());
                assert!(v.covered > v.texels / 2, "{what}: an empty map is easy to get right");
                assert!(v.wrong.is_empty(), "{what}: {} wrong: {:?}", v.wrong.len(), &v.wrong[..v.wrong.len().min(5)]);
                (texels, sharp) = (texels + v.texels, sharp + v.sharp);
            }
            assert!(sharp > texels / 3, "{family:?}, {ratio:e}: the oracle leaves all open: {sharp} of {texels}");
        }
    }
}

/// The same for a tessellated ground, which must also leave no texel empty.
pub fn assert_a_ground_has_no_hole(draw: impl Fn(&Scene, DMat4) -> Vec<f32>) {
    for family in Family::ALL {
        for ratio in RATIOS {
            let (scene, clip_from_world) = ground(family, ratio);
            let map = draw(&scene, clip_from_world);
            let holes = map.iter().filter(|&&z| z >= 1.0).count();
            assert_eq!(holes, 0, "{family:?}, {ratio:e}");
            let v = judge(&map, &bounds(&scene, &clip_from_world, SIZE));
            assert!(v.wrong.is_empty(), "{family:?}, {ratio:e}: {:?}", &v.wrong[..v.wrong.len().min(5)]);
        }
    }
}

/// Singular matrices draw what they can: a constant depth row loses nothing, a lost axis shows nothing.
pub fn assert_singular_matrices_are_drawn(draw: impl Fn(&Scene, DMat4) -> Vec<f32>) {
    let (scene, clip_from_world) = ground(Family::AlongOneAxis, 1e2);
    let rows = clip_from_world.transpose();
    let drawn = |rows: DMat4| draw(&scene, rows.transpose());
    let flat = drawn(DMat4::from_cols(rows.x_axis, rows.y_axis, 0.25 * rows.w_axis, rows.w_axis));
    assert!(flat.iter().all(|z| (z - 0.25).abs() < 1e-6), "all at one depth");
    for rows in [
        DMat4::from_cols(rows.x_axis, rows.x_axis, rows.z_axis, rows.w_axis),
        DMat4::from_cols(rows.x_axis, rows.y_axis, rows.z_axis, DVec4::ZERO),
        DMat4::from_cols(rows.x_axis, rows.y_axis, rows.z_axis, -rows.w_axis * 0.0),
        DMat4::ZERO,
    ] {
        let map = drawn(rows);
        // A plane that falls into a line on the map covers at most the texels along it.
        let covered = map.iter().filter(|&&z| z < 1.0).count();
        assert!(covered <= 2 * SIZE[0] as usize, "{covered}");
        assert!(map.iter().all(|z| (0.0..=1.0).contains(z)));
    }
}
