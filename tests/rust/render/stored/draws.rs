//! The two nearest depths of a texel: in any order, on any number of threads, by every path of the rasteriser.

use std::sync::Arc;

use glam::DVec3;
use shadowlab::parameterization::{Parameterization, PostWarp};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Format, Renderer, Spacing, Stored, StoredSurface};
use shadowlab::scene::{AlphaTest, AlphaTestParts, AlphaTexture, Wrap};
use shadowlab::{Mesh, Progress, Scene};

use super::oracle::{logarithm, rectilinear};
use crate::support::cpu::{Random, clip_from_pixels, one_map, triangles};

/// Of a depth drawn along with others and alone.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

fn stored(surface: StoredSurface, spacing: Spacing) -> Stored {
    Stored { surface, spacing, ..Stored::default() }
}

fn draw(scene: &Scene, p: &Parameterization, size: [u32; 2], stored: Stored) -> Vec<f32> {
    CpuRenderer::new().depth_maps(scene, p, size, stored, &Progress::new()).unwrap().data
}

/// Triangles of all sizes in a picture of so many pixels.
fn soup(random: &mut Random, count: usize, [w, h]: [u32; 2]) -> Vec<[DVec3; 3]> {
    let one = |i: usize| {
        let reach = [2.0, 12.0, 90.0, 900.0][i % 4];
        let middle = DVec3::new(random.number(0.0, w.into()), random.number(0.0, h.into()), random.number(0.1, 0.9));
        let mut corner = || {
            let p = middle + DVec3::new(random.number(-reach, reach), random.number(-reach, reach), 0.0);
            p.with_z(random.number(0.02, 0.98))
        };
        [corner(), corner(), corner()]
    };
    (0..count).map(one).collect()
}

fn parameterizations(size: [u32; 2]) -> Vec<(&'static str, Parameterization)> {
    let with = |post_warp: PostWarp| {
        let mut p = one_map(clip_from_pixels(size));
        if matches!(post_warp, PostWarp::Log { .. }) {
            // w has to vary for a logarithm of it.
            p.partitions[0].shadow_clip_from_world = super::oracle::warp() * clip_from_pixels(size);
        }
        p.partitions[0].post_warp = post_warp;
        p
    };
    vec![("plain", with(PostWarp::None)), ("log", with(logarithm())), ("rectilinear", with(rectilinear()))]
}

#[test]
fn a_lone_sheet_has_no_second_depth() {
    // At widths that are no multiple of a vector, runs of pixels overlap at the right.
    for size in [[101, 37], [13, 70], [8, 8], [5, 9], [64, 64], [1, 1]] {
        let [w, h] = size.map(f64::from);
        let (right, bottom) = (3.0 * w, 3.0 * h);
        let at = |x: f64, y: f64| DVec3::new(x, y, 0.2 + 0.6 * (x + w) / (4.0 * w) + 0.1 * (y + h) / (4.0 * h));
        let large =
            vec![[at(-w, -h), at(right, -h), at(-w, bottom)], [at(right, -h), at(right, bottom), at(-w, bottom)]];
        // And of many small ones.
        let n = 3;
        let grid = |i: i32, j: i32| at(w * f64::from(i) / f64::from(n), h * f64::from(j) / f64::from(n));
        let small: Vec<[DVec3; 3]> = (0..n * n)
            .map(|k| (k % n, k / n))
            .flat_map(|(i, j)| {
                [[grid(i, j), grid(i + 1, j), grid(i, j + 1)], [grid(i + 1, j), grid(i + 1, j + 1), grid(i, j + 1)]]
            })
            .collect();
        for sheet in [large, small] {
            let scene = triangles(&sheet);
            for (name, p) in parameterizations(size) {
                let second = draw(&scene, &p, size, stored(StoredSurface::Second, Spacing::Projective));
                assert!(second.iter().all(|z| *z == 1.0), "{name}, {size:?}: a sheet behind itself");
                let first = draw(&scene, &p, size, stored(StoredSurface::Front, Spacing::Linear));
                assert!(first.iter().filter(|z| **z < 1.0).count() * 4 >= first.len() * 3, "{name}, {size:?}");
            }
        }
    }
}

#[test]
fn the_two_nearest_depths_are_those_of_triangles_drawn_alone() {
    let mut random = Random(31);
    let size = [75, 40];
    for (name, p) in parameterizations(size) {
        let soup = soup(&mut random, 60, size);
        // Beside the map, so that every mesh has the same frame.
        let frame = [-3000.0, 3000.0].map(|x| [DVec3::new(x, x, 0.5); 3].map(|p| p + 0.01 * random.vector(0.0, 1.0)));
        let framed = |corners: &[[DVec3; 3]]| triangles(&[corners, &frame].concat());
        let scene = framed(&soup);
        let linear = |surface| draw(&scene, &p, size, stored(surface, Spacing::Linear));
        let (first, second) = (linear(StoredSurface::Front), linear(StoredSurface::Second));
        let alone: Vec<Vec<f32>> = soup
            .iter()
            .map(|triangle| draw(&framed(&[*triangle]), &p, size, stored(StoredSurface::Front, Spacing::Linear)))
            .collect();
        let mut checked = 0;
        for i in 0..first.len() {
            let mut depths: Vec<f32> = alone.iter().map(|map| map[i]).filter(|z| *z < 1.0).collect();
            depths.sort_by(f32::total_cmp);
            // Depths that could change places are no test.
            if depths.windows(2).any(|d| d[1] - d[0] < 1e-5) {
                continue;
            }
            let expected = [0, 1].map(|k: usize| depths.get(k).copied().unwrap_or(1.0));
            let apart = [first[i] - expected[0], second[i] - expected[1]].map(f32::abs);
            assert!(apart[0] <= ROUNDING && apart[1] <= ROUNDING, "{name}, {i}: {} {}", first[i], second[i]);
            checked += usize::from(depths.len() > 1);
        }
        assert!(checked > 1000, "{name}: {checked}");
    }
}

#[test]
fn the_order_of_triangles_and_the_number_of_threads_do_not_matter() {
    let mut random = Random(32);
    let size = [130, 90];
    for (name, p) in parameterizations(size) {
        let mut soup = soup(&mut random, 400, size);
        let all = |soup: &[[DVec3; 3]]| -> Vec<Vec<f32>> {
            let scene = triangles(soup);
            StoredSurface::NAMES.map(|(_, s)| draw(&scene, &p, size, stored(s, Spacing::Linear))).to_vec()
        };
        let one_way = all(&soup);
        let other_threads = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap().install(|| all(&soup));
        assert!(one_way == other_threads, "{name}: threads");
        for i in (1..soup.len()).rev() {
            soup.swap(i, random.integer(0, i as i64 + 1) as usize);
        }
        // The mesh's own frame is that of its box, whatever the order.
        assert!(one_way == all(&soup), "{name}: order");
    }
}

#[test]
fn alpha_tests_hold_for_both_layers() {
    // A sheet whose left half does not exist before a whole one, before another that exists at the left.
    let size = [64, 16];
    let sheet = |z: f64, levels: Option<Vec<u8>>| {
        let corners = [[0.0, 0.0, z], [64.0, 0.0, z], [64.0, 16.0, z], [0.0, 16.0, z]];
        let test = levels.map(|levels| {
            let texture = Some(Arc::new(AlphaTexture::new([2, 1], levels).unwrap()));
            let uv = vec![[0.0, 0.5], [1.0, 0.5], [1.0, 0.5], [0.0, 0.5]];
            AlphaTest::new(AlphaTestParts { texture, uv, cutoff: 0.5, wrap: [Wrap::Clamp; 2], factor: 1.0 }).unwrap()
        });
        Scene::from_mesh(Mesh::with_alpha_test(&corners, &[[0, 1, 2], [0, 2, 3]], test).unwrap()).unwrap()
    };
    let scene = sheet(0.25, Some(vec![0, 255]))
        .joined(&sheet(0.5, None))
        .and_then(|scene| scene.joined(&sheet(0.75, Some(vec![255, 0]))))
        .unwrap();
    let mut p = one_map(clip_from_pixels(size));
    for post_warp in [PostWarp::None, rectilinear()] {
        p.partitions[0].post_warp = post_warp;
        let of = |surface| draw(&scene, &p, size, stored(surface, Spacing::Projective));
        let (first, second) = (of(StoredSurface::Front), of(StoredSurface::Second));
        let pairs: Vec<(f32, f32)> = first.into_iter().zip(second).collect();
        assert!(pairs.iter().all(|pair| [(0.5, 0.75), (0.25, 0.5)].contains(pair)), "{:?}", &pairs[..64]);
        let right = pairs.iter().filter(|pair| pair.0 == 0.25).count();
        assert!(right > 128 && right < 896, "{right}");
    }
}

#[test]
fn stopped_work_says_so() {
    let scene = triangles(&soup(&mut Random(1), 10, [64; 2]));
    let progress = Progress::new();
    progress.stop();
    for (_, surface) in StoredSurface::NAMES {
        for (name, p) in parameterizations([64; 2]) {
            let one = Stored { surface, format: Format::Unorm16, ..Stored::default() };
            let result = CpuRenderer::new().depth_maps(&scene, &p, [64; 2], one, &progress);
            assert_eq!(result.unwrap_err(), shadowlab::Error::Interrupted, "{name}, {surface:?}");
        }
    }
}
