//! Depth maps whose texels a post-warp makes uneven: every texel against a ray of its own.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DMat4, DVec2, DVec3, DVec4};
use shadowlab::geometry::Rows;
use shadowlab::parameterization::{Parameterization, PiecewiseLinear, PostWarp, Rectilinear};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Renderer, Stored};
use shadowlab::{Error, Mesh, Progress, Scene};

use crate::support::cpu as cpu_support;
use crate::support::cpu::{Random, clip_from_pixels, depth, one_map, triangle_mesh, triangles};

/// Of the depth of a texel: its rounding to f32, and as much again for the plane it lies in.
const ROUNDING: f64 = 2.0 * f32::EPSILON as f64;
/// A ray that passes a side of a triangle closer than this share of the triangle may go either way. Of f64, with the condition
/// of triangles a thousand times as long as wide.
const GRAZING: f64 = 1e-9;

fn logarithmic(matrix: DMat4, scale: f64, offset: f64) -> Parameterization {
    let mut p = one_map(matrix);
    p.partitions[0].post_warp = PostWarp::Log { scale, offset };
    p
}

fn rectilinear(matrix: DMat4, x: PiecewiseLinear, y: PiecewiseLinear) -> Parameterization {
    let mut p = one_map(matrix);
    p.partitions[0].post_warp = PostWarp::Rectilinear(Arc::new(Rectilinear { x, y }));
    p
}

/// From -1 to 1, with pieces up to `ratio` times as steep as others.
fn ascending(random: &mut Random, pieces: usize, ratio: f64) -> PiecewiseLinear {
    let mut steps = || -> Vec<f64> {
        let steps: Vec<f64> = (0..pieces).map(|_| ratio.powf(random.number(0.0, 0.5))).collect();
        let sum: f64 = steps.iter().sum();
        steps.iter().map(|step| 2.0 * step / sum).collect()
    };
    let (before, after) = (steps(), steps());
    let mut knots = vec![[-1.0, -1.0]];
    for (x, y) in before.into_iter().zip(after) {
        let last = knots[knots.len() - 1];
        knots.push([last[0] + x, last[1] + y]);
    }
    PiecewiseLinear::new(&knots).expect("ascending knots")
}

fn draw(scene: &Scene, p: &Parameterization, size: [u32; 2]) -> Vec<f32> {
    CpuRenderer::new().depth_maps(scene, p, size, Stored::default(), &Progress::new()).expect("a map").data
}

/// The corners of all triangles as the scene stores them.
fn corners(scene: &Scene) -> Vec<[DVec3; 3]> {
    let one = |i: usize| {
        let (mesh, place) = (scene.mesh_of(i), scene.world_from_local(i));
        let at = move |v: u32| place.transform_point3(mesh.positions_local()[v as usize].as_dvec3());
        mesh.triangles().iter().map(move |t| t.map(at)).collect::<Vec<_>>()
    };
    (0..scene.instances().len()).flat_map(one).collect()
}

/// The functionals of (p, 1) that are 0 on the ray of a texel, by the definition of the map.
fn ray(rows: &Rows, post_warp: &PostWarp, ndc: DVec2) -> [DVec4; 2] {
    match post_warp {
        PostWarp::None => [rows.x - rows.w * ndc.x, rows.y - rows.w * ndc.y],
        PostWarp::Log { scale, offset } => {
            [rows.x - rows.w * ndc.x, rows.w - DVec4::W * ((ndc.y - offset) / scale).exp()]
        }
        PostWarp::Rectilinear(warp) => ray(rows, &PostWarp::None, warp.before(ndc)),
    }
}

/// Depth at a texel: the least z/w in [0, 1] of all points of the scene with w > 0 on its ray; nothing where the ray grazes a
/// triangle.
fn by_definition(corners: &[[DVec3; 3]], rows: &Rows, [a, b]: [DVec4; 2]) -> Option<f64> {
    let direction = a.truncate().cross(b.truncate());
    // A point of both planes.
    let system = DMat3::from_cols(a.truncate(), b.truncate(), direction).transpose();
    let foot = system.inverse() * DVec3::new(-a.w, -b.w, 0.0);
    let mut nearest = 1.0_f64;
    for [p, q, r] in corners {
        // Barycentric: foot + t direction = p + u (q - p) + v (r - p).
        let (e, f) = (*q - *p, *r - *p);
        let inverse = DMat3::from_cols(e, f, -direction).inverse();
        let DVec3 { x: u, y: v, z: t } = inverse * (foot - *p);
        let least = u.min(v).min(1.0 - u - v);
        if least.is_nan() || least < -GRAZING {
            continue;
        }
        let at = (foot + direction * t).extend(1.0);
        let (w, z) = (rows.w.dot(at), rows.z.dot(at) / rows.w.dot(at));
        if w > 0.0 && (least < GRAZING || z.abs() < GRAZING) {
            return None;
        }
        if w > 0.0 && z >= 0.0 {
            nearest = nearest.min(z);
        }
    }
    Some(nearest)
}

/// Holds a map against its definition; how many texels were compared, and how many of them show something.
fn compare(what: &str, scene: &Scene, p: &Parameterization, size: [u32; 2]) -> [usize; 2] {
    let map = draw(scene, p, size);
    let rows = Rows::of(&p.partitions[0].shadow_clip_from_world);
    // Products of its entries must not leave f64.
    let magnitude = rows.w.abs().max_element();
    let rows = rows.scaled(magnitude.recip());
    let mut post_warp = p.partitions[0].post_warp.clone();
    if let PostWarp::Log { scale, offset } = &mut post_warp {
        *offset += *scale * magnitude.ln();
    }
    let corners = corners(scene);
    let mut counts = [0; 2];
    for j in 0..size[1] {
        for i in 0..size[0] {
            let ndc = |k: u32, n: u32| (f64::from(k) + 0.5) / f64::from(n) * 2.0 - 1.0;
            let texel = DVec2::new(ndc(i, size[0]), -ndc(j, size[1]));
            let Some(expected) = by_definition(&corners, &rows, ray(&rows, &post_warp, texel)) else { continue };
            let drawn = f64::from(map[(j * size[0] + i) as usize]);
            assert!((drawn - expected).abs() <= ROUNDING, "{what}: texel {i}, {j}: {drawn} and {expected}");
            counts[0] += 1;
            counts[1] += usize::from(drawn < 1.0);
        }
    }
    counts
}

/// Small and large triangles around the origin.
fn random_scene(random: &mut Random) -> Scene {
    let all: Vec<[DVec3; 3]> = (0..60)
        .map(|i| {
            let (middle, size) = (random.vector(-3.0, 3.0), [0.1, 1.0, 8.0][i % 3]);
            [0, 1, 2].map(|_| middle + random.vector(-size, size))
        })
        .collect();
    triangles(&all)
}

#[test]
fn every_texel_is_what_a_ray_of_its_own_sees() {
    let mut random = Random(3);
    let mut seen = 0;
    for case in 0..40 {
        let scene = random_scene(&mut random);
        let placed = case % 2 == 1;
        // w grows along y, falls to 0 at y = -2.5, and a spot's along the light, too.
        let rows = Rows {
            x: DVec3::new(random.number(0.2, 0.5), random.number(-0.1, 0.1), 0.0).extend(0.05),
            // Of no consequence.
            y: random.vector(-1.0, 1.0).extend(7.0),
            z: random.vector(-0.05, 0.05).extend(0.6) + DVec4::Z * 0.15,
            w: DVec3::new(random.number(-0.05, 0.05), 0.4, if placed { 0.15 } else { 0.0 }).extend(1.0),
        };
        // Strong and weak, and the far end at the bottom.
        let scale = [0.15, 0.6, 3.0, -0.8][case / 2 % 4];
        let offset = random.number(-0.3, 0.3);
        let magnitude = [1.0, 1e-200, 1e200, 3.0][case % 4];
        let p = logarithmic(rows.matrix() * magnitude, scale, offset - scale * magnitude.ln());
        let size = [[37, 29], [64, 33], [9, 80], [3, 3], [1, 1]][case % 5];
        let [compared, shown] = compare(&format!("case {case}"), &scene, &p, size);
        // Grazing is rare: a few of 60 triangles' outlines, 1e-9 wide.
        assert!(compared >= (size[0] * size[1]) as usize - 1, "case {case}: {compared} compared");
        seen += shown;
    }
    assert!(seen > 10_000, "{seen} texels with something to see");
}

#[test]
fn every_texel_between_uneven_rows_and_columns_is_what_a_ray_of_its_own_sees() {
    let mut random = Random(29);
    let mut seen = 0;
    for case in 0..40 {
        let scene = random_scene(&mut random);
        // Even, falling to 0 among the triangles, and a spot's along the light, too.
        let (along, placed) = [(0.0, 0.0), (0.4, 0.0), (0.3, 0.15)][case % 3];
        let rows = Rows {
            x: DVec3::new(random.number(0.2, 0.5), random.number(-0.1, 0.1), 0.0).extend(0.05),
            y: DVec3::new(random.number(-0.1, 0.1), random.number(0.2, 0.5), 0.0).extend(0.02),
            z: random.vector(-0.05, 0.05).extend(0.6) + DVec4::Z * 0.15,
            w: DVec3::new(random.number(-0.05, 0.05), along, placed).extend(1.0),
        };
        let magnitude = [1.0, 1e-200, 1e200, 3.0][case % 4];
        let ratio = [1.0, 20.0, 1e4][case / 3 % 3];
        let warps = [0, 1].map(|_| ascending(&mut random, [1, 5, 64][case % 3], ratio));
        let [x, y] = warps;
        let p = rectilinear(rows.matrix() * magnitude, x, y);
        let size = [[37, 29], [64, 33], [9, 80], [3, 3], [1, 1]][case % 5];
        let [compared, shown] = compare(&format!("case {case}"), &scene, &p, size);
        assert!(compared >= (size[0] * size[1]) as usize - 1, "case {case}: {compared} compared");
        seen += shown;
    }
    assert!(seen > 10_000, "{seen} texels with something to see");
}

#[test]
fn knots_in_a_line_draw_what_no_warp_draws() {
    let scene = random_scene(&mut Random(31));
    let rows = Rows { z: DVec4::new(0.0, 0.0, 0.1, 0.5), ..Rows::of(&DMat4::from_scale(DVec3::splat(0.3))) };
    let even = |pieces: usize| {
        let knots: Vec<[f64; 2]> = (0..=pieces).map(|i| [2.0 * i as f64 / pieces as f64 - 1.0; 2]).collect();
        PiecewiseLinear::new(&knots).expect("knots")
    };
    let size = [120, 90];
    let warped = draw(&scene, &rectilinear(rows.matrix(), even(7), even(64)), size);
    let plain = draw(&scene, &one_map(rows.matrix()), size);
    // The grid of 1/256 moves outlines, and depths of steep triangles.
    let differ = warped.iter().zip(&plain).filter(|(a, b)| (**a - **b).abs() > 1e-3).count();
    assert!(differ < warped.len() / 100, "{differ} texels differ");
    assert!(warped.iter().filter(|z| **z < 1.0).count() > warped.len() / 4);
}

#[test]
fn the_comparison_sees_a_map_that_is_half_a_texel_off() {
    let scene = random_scene(&mut Random(5));
    let rows = Rows::of(&DMat4::from_translation(DVec3::Z * 0.5));
    let rows = Rows { w: DVec3::new(0.0, 0.3, 0.0).extend(1.2), z: rows.z * 0.2, ..rows };
    let p = logarithmic(rows.matrix(), 1.0, 0.0);
    compare("right", &scene, &p, [48, 48]);
    let moved = |dx: f64, dy: f64| {
        let map = draw(&scene, &p, [48, 48]);
        let other = Rows { x: rows.x + rows.w * (dx / 48.0), ..rows };
        let other = draw(&scene, &logarithmic(other.matrix(), 1.0, dy / 48.0), [48, 48]);
        map.iter().zip(&other).filter(|(a, b)| (**a - **b).abs() > ROUNDING as f32).count()
    };
    assert_eq!(moved(0.0, 0.0), 0);
    assert!(moved(1.0, 0.0) > 100 && moved(0.0, 1.0) > 100);
}

/// A wavy sheet over [-1.2, 1.2]² with inner vertices pushed about, `n` cells each way; z around 0.5.
fn sheet(n: u32, random: &mut Random) -> Mesh {
    let mut vertices = Vec::new();
    for j in 0..=n {
        for i in 0..=n {
            let cell = 2.4 / f64::from(n);
            let inner = f64::from(u8::from((1..n).contains(&i) && (1..n).contains(&j)));
            let jitter = DVec2::new(random.number(-0.3, 0.3), random.number(-0.3, 0.3)) * cell * inner;
            let p = DVec2::new(f64::from(i), f64::from(j)) * cell - 1.2 + jitter;
            vertices.push([p.x, p.y, 0.5 + 0.2 * (3.0 * p.x).sin() * (2.0 * p.y).cos()]);
        }
    }
    let at = |i: u32, j: u32| i64::from(j * (n + 1) + i);
    let cells = (0..n * n).map(|k| (k % n, k / n));
    let faces: Vec<[i64; 3]> = cells
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]])
        .collect();
    Mesh::new(&vertices, &faces).expect("a sheet")
}

/// w from 1 to `ratio` over y from -1 to 1, logarithm over the same.
fn over_unit_square(ratio: f64) -> Parameterization {
    let w = DVec3::new(0.0, 0.5 * (ratio - 1.0), 0.0).extend(0.5 * (ratio + 1.0));
    // x / w in [-1, 1] over the whole square at its narrow end only: the sheet is as wide as the map elsewhere.
    let rows = Rows { x: DVec3::X.extend(0.0), z: DVec4::Z, y: DVec4::Y, w };
    let scale = 2.0 / ratio.ln();
    logarithmic(Rows { x: rows.x * ratio, ..rows }.matrix(), scale, -1.0)
}

#[test]
fn a_closed_surface_has_no_hole_at_any_density() {
    let mut random = Random(11);
    // From a triangle larger than the map to many in a texel; more than one round of chunks.
    for n in [1, 7, 60, 400] {
        let scene = Scene::from_mesh(sheet(n, &mut random)).expect("a scene");
        for ratio in [1.001, 3.0, 1e3, 1e6] {
            let p = over_unit_square(ratio);
            // x / w = ratio x / w: at the far end the map is as wide as the sheet's middle.
            let map = draw(&scene, &p, [200, 160]);
            let wide = |k: usize| {
                let (i, j) = ((k % 200) as f64, (k / 200) as f64);
                let w = ((1.0 - (j + 0.5) / 80.0 + 1.0) * 0.5 * ratio.ln()).exp();
                (((i + 0.5) / 100.0 - 1.0) * w / ratio).abs() < 1.0
            };
            let holes = map.iter().enumerate().filter(|(k, z)| wide(*k) && **z >= 1.0).count();
            assert_eq!(holes, 0, "{n} cells, w over {ratio}");
        }
    }
}

#[test]
fn a_weak_logarithm_draws_what_the_ordinary_rasteriser_draws() {
    let size = [160, 120];
    let mut random = Random(17);
    let pixels: Vec<[DVec3; 3]> = (0..200)
        .map(|_| {
            let middle = random.vector(-20.0, 180.0);
            [0, 1, 2].map(|_| (middle + random.vector(-25.0, 25.0)) * DVec3::new(1.0, 1.0, 0.005) + DVec3::Z * 0.1)
        })
        .collect();
    let scene = triangles(&pixels);
    let plain = clip_from_pixels(size);
    // ln(1 + a y) / a is y up to a y² / 2: a ten-millionth of a texel.
    let slope = 1e-9;
    let rows = Rows::of(&plain);
    let w = rows.w + rows.y * slope;
    let map = draw(&scene, &logarithmic(Rows { w, ..rows }.matrix(), 1.0 / slope, 0.0), size);
    let ordinary = depth(&scene, plain, size);
    let at = |i: i64, j: i64| {
        let inside = (0..i64::from(size[0])).contains(&i) && (0..i64::from(size[1])).contains(&j);
        inside.then(|| ordinary[(j * i64::from(size[0]) + i) as usize])
    };
    let mut differ = 0;
    for (k, z) in map.iter().enumerate() {
        let (i, j) = (k as i64 % i64::from(size[0]), k as i64 / i64::from(size[0]));
        // The grid of 1/256 tilts no plane, but f32 positions of 160 texels do: 2^-17 texels.
        if (z - ordinary[k]).abs() > 1e-5 {
            differ += 1;
            let near = [(-1, 0), (1, 0), (0, -1), (0, 1)].map(|(x, y)| at(i + x, j + y));
            let edge = near.iter().flatten().any(|n| (n - z).abs() < 1e-3 || (n - ordinary[k]).abs() > 1e-3);
            assert!(edge, "texel {i}, {j}: {z} and {}", ordinary[k]);
        }
    }
    // Outlines move by up to 1/512 texel: of about 200 * 75 texels of outline, one in 256 at the most changes.
    assert!(differ <= 200 * 75 / 256, "{differ} texels differ");
    assert!(map.iter().filter(|z| **z < 1.0).count() > map.len() / 2);
}

#[test]
fn instances_threads_and_sizes_draw_the_same_map() {
    let mut random = Random(23);
    let mesh = sheet(20, &mut random);
    let places: Vec<DAffine3> = (0..300)
        .map(|_| {
            let turn = DMat3::from_rotation_z(random.number(0.0, 6.0)) * random.number(0.01, 0.2);
            DAffine3::from_mat3_translation(turn, random.vector(-1.5, 1.5) * DVec3::new(1.0, 1.0, 0.3))
        })
        .collect();
    let scene = cpu_support::instances(mesh, &places);
    let loose = corners(&scene);
    let p = over_unit_square(20.0);
    let map = draw(&scene, &p, [130, 90]);
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    assert_eq!(alone.install(|| draw(&scene, &p, [130, 90])), map);
    // Loose triangles are rounded anew: nearly the same.
    let other = draw(&Scene::from_mesh(triangle_mesh(&loose)).expect("a scene"), &p, [130, 90]);
    let differ = map.iter().zip(&other).filter(|(a, b)| (**a - **b).abs() > 1e-4).count();
    assert!(differ < map.len() / 1000, "{differ} differ");
    assert!(map.iter().filter(|z| **z < 1.0).count() > map.len() / 3);
}

#[test]
fn what_cannot_be_drawn_is_an_error() {
    let scene = random_scene(&mut Random(1));
    let matrix = over_unit_square(3.0).partitions[0].shadow_clip_from_world;
    let cases = [(0.0, 0.0), (f64::NAN, 0.0), (1.0, f64::INFINITY), (1e-3, 0.0), (1.0, 1e4), (f64::INFINITY, 0.0)];
    for (scale, offset) in cases {
        let result = CpuRenderer::new().depth_maps(
            &scene,
            &logarithmic(matrix, scale, offset),
            [8, 8],
            Stored::default(),
            &Progress::new(),
        );
        match result {
            Err(Error::InvalidArgument { name, .. }) => assert_eq!(name, "post_warp"),
            other => panic!("scale {scale}, offset {offset}: {other:?}"),
        }
    }
    // A w that never changes has no rows to be seen in.
    let constant = Rows { w: DVec4::W, ..Rows::of(&matrix) };
    assert!(draw(&scene, &logarithmic(constant.matrix(), 1.0, 0.1), [8, 8]).iter().all(|z| *z == 1.0));
    let progress = Progress::new();
    progress.stop();
    let stopped = CpuRenderer::new().depth_maps(&scene, &over_unit_square(3.0), [8, 8], Stored::default(), &progress);
    assert_eq!(stopped, Err(Error::Interrupted));
}
