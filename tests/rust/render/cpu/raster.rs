//! The CPU depth pass: coverage and depth against exact arithmetic, clipping, extremes, determinism.

use glam::{DAffine3, DMat3, DMat4, DVec2, DVec3, DVec4};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Renderer, Stored};
use shadowlab::{Error, Progress, Scene};

use crate::support::cpu::*;

/// Rounding of one f32 operation on a value near 1.
const ULP: f64 = f32::EPSILON as f64;

/// The error that depth may have from f32 alone: the plane's terms, over the box of a triangle of `extent` pixels.
///
/// Setup: differences of coordinates (exact on the test's grid), three products, a quotient; evaluation: three products and
/// sums. Ten roundings of the largest term cover them.
fn depth_bound(gradient: DVec2, extent: f64) -> f64 {
    10.0 * 0.5 * ULP * (1.0 + (gradient.x.abs() + gradient.y.abs()) * (extent + 8.0))
}

/// Draws triangles one by one, holds each against the reference, and says how many texels were covered.
fn check_triangles(random: &mut Random, count: usize, size: [u32; 2], spread: f64) -> usize {
    let mut total = 0;
    for n in 0..count {
        // Either on pixel centres and borders, or at odd eighths of a grid step: never half way between two, where the last
        // bit of f32 decides.
        let middle = [random.number(0.0, size[0].into()), random.number(0.0, size[1].into())];
        let mut coordinate = |k: usize| match n % 3 {
            0 => ((middle[k] + random.number(-spread, spread)) * 2.0).round() / 2.0,
            _ => ((middle[k] + random.number(-spread, spread)) * 1024.0).round() / 1024.0 + 1.0 / 2048.0,
        };
        let xy = [0, 1, 2].map(|_| [coordinate(0), coordinate(1)]);
        let corners = xy.map(|[x, y]| DVec3::new(x, y, random.integer(0, 4096) as f64 / 4096.0));
        let got = depth(&triangles(&[corners]), clip_from_pixels(size), size);
        let mut expected = vec![false; got.len()];
        for [x, y] in reference_coverage(&corners, size) {
            expected[(y * size[0] + x) as usize] = true;
        }
        let z = corners.map(|p| p.z);
        let z_range = [z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2])];
        let extent = corners.iter().flat_map(|p| corners.map(|q| (q - *p).truncate().abs().max_element()));
        let extent = extent.fold(0.0, f64::max);
        let rounded =
            corners.map(|p| DVec3::new((p.x * 256.0).round_ties_even(), (p.y * 256.0).round_ties_even(), p.z));
        let area = |c: &[DVec3; 3]| (c[1] - c[0]).truncate().perp_dot((c[2] - c[0]).truncate());
        let ratio = area(&corners) * 65536.0 / area(&rounded);
        for (i, (&z, &covered)) in got.iter().zip(&expected).enumerate() {
            let (x, y) = (i as u32 % size[0], i as u32 / size[0]);
            if !covered {
                assert_eq!(z, 1.0, "{corners:?} covers ({x}, {y})");
                continue;
            }
            total += 1;
            let z = f64::from(z);
            assert!(z_range[0] - ULP <= z && z <= z_range[1] + ULP, "{corners:?} has {z} at ({x}, {y})");
            // Where rounding to the grid has changed the area a lot, the plane is the rounded triangle's.
            if (0.51..1.9).contains(&ratio) {
                let at = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                let (expected, gradient) = reference_depth(&corners, at).unwrap();
                let (expected, bound) = (expected.clamp(z_range[0], z_range[1]), depth_bound(gradient, extent));
                assert!((z - expected).abs() <= bound, "{corners:?} at ({x}, {y}): {z}, not {expected} +- {bound:e}");
            }
        }
    }
    total
}

#[test]
fn random_triangles_equal_the_exact_rasteriser() {
    let mut random = Random(1);
    let mut covered = 0;
    for (count, size, spread) in [
        (3000, [16, 16], 1.5),
        (2000, [37, 41], 6.0),
        (400, [70, 66], 40.0),
        // Larger than the 32-bit path takes, drawn in blocks, over several bands.
        (150, [203, 99], 300.0),
        (60, [64, 64], 2000.0),
        (300, [5, 3], 4.0),
        (100, [1, 1], 1.0),
        (60, [8, 65], 30.0),
    ] {
        covered += check_triangles(&mut random, count, size, spread);
    }
    assert!(covered > 200_000, "the test has drawn {covered} texels");
}

#[test]
fn the_reference_can_fail() {
    let size = [8, 8];
    let corners = [DVec3::new(0.0, 0.0, 0.5), DVec3::new(6.0, 0.0, 0.5), DVec3::new(0.0, 6.0, 0.5)];
    let count = |c: &[DVec3; 3]| reference_coverage(c, size).len();
    let moved = corners.map(|p| p + DVec3::X * (1.0 / 256.0));
    // The diagonal passes through centres, which are its right-hand border.
    assert_eq!(count(&corners), 15);
    assert_eq!(count(&moved), 21);
}

#[test]
fn a_fan_covers_each_texel_once() {
    let size = [48, 48];
    let mut random = Random(2);
    for n in 0..60 {
        // A fan around a point, which every few rounds lies on a centre, as do spokes at multiples of 45 degrees.
        let hub = match n % 3 {
            0 => DVec2::new(20.5, 25.5),
            _ => DVec2::new(random.number(15.0, 30.0), random.number(15.0, 30.0)),
        };
        let turn = if n % 2 == 0 { 0.0 } else { random.number(0.0, 7.0) };
        let rim: Vec<DVec2> =
            (0..8).map(|k| hub + 90.0 * DVec2::from_angle(turn + f64::from(k) * std::f64::consts::FRAC_PI_4)).collect();
        let mut times = vec![0; (size[0] * size[1]) as usize];
        for k in 0..8 {
            let corners = [hub, rim[k], rim[(k + 1) % 8]].map(|p| p.extend(0.5));
            for (t, z) in times.iter_mut().zip(depth(&triangles(&[corners]), clip_from_pixels(size), size)) {
                *t += usize::from(z < 1.0);
            }
        }
        assert!(times.iter().all(|&t| t == 1), "fan {n}: {times:?}");
    }
}

#[test]
fn a_full_screen_quad_is_its_plane() {
    for size in [[64, 64], [100, 30], [1, 1], [3, 7], [333, 257]] {
        let [w, h] = size.map(f64::from);
        let plane = |x: f64, y: f64| DVec3::new(x, y, 0.1 + 0.5 * x / w + 0.3 * y / h);
        let (a, b, c, d) = (plane(0.0, 0.0), plane(w, 0.0), plane(w, h), plane(0.0, h));
        let got = depth(&triangles(&[[a, b, c], [a, c, d]]), clip_from_pixels(size), size);
        for (i, z) in got.iter().enumerate() {
            let (x, y) = ((i as u32 % size[0]) as f64 + 0.5, (i as u32 / size[0]) as f64 + 0.5);
            let error = f64::from(*z) - plane(x, y).z;
            assert!(error.abs() <= 8.0 * ULP, "{size:?} ({x}, {y}): {error:e}");
        }
    }
}

/// A perspective `clip_from_world` that looks along -z with a field of 90 degrees.
fn perspective(near: f64, far: f64) -> DMat4 {
    glam::dcamera::rh::proj::directx::perspective(std::f64::consts::FRAC_PI_2, 1.0, near, far)
}

#[test]
fn a_floor_through_the_near_plane_is_seen_to_the_horizon_it_has() {
    // The floor y = -1 around the eye, corners far behind the eye (w < 0) and far outside the image.
    let s = 1e3;
    let (a, b, c, d) =
        (DVec3::new(-s, -1.0, s), DVec3::new(s, -1.0, s), DVec3::new(s, -1.0, -s), DVec3::new(-s, -1.0, -s));
    let (near, far, n) = (0.5, 200.0, 64u32);
    let m = perspective(near, far);
    for faces in [[[a, b, c], [a, c, d]], [[d, b, a], [b, d, c]]] {
        let got = depth(&triangles(&faces), m, [n, n]);
        for y in 0..n {
            let ndc_y = 1.0 - 2.0 * (f64::from(y) + 0.5) / f64::from(n);
            for x in 0..n {
                let z = f64::from(got[(y * n + x) as usize]);
                // The ray meets the floor at depth -1 / ndc_y.
                let depth = -1.0 / ndc_y;
                if ndc_y > 0.0 || depth > far {
                    assert_eq!(z, 1.0, "({x}, {y})");
                } else {
                    let expected = far * (depth - near) / (depth * (far - near));
                    // Clip z of a corner is about s - near in f32, which moves the near plane by s ULP: relative to near.
                    let bound = s * ULP / near;
                    assert!((z - expected).abs() < bound, "({x}, {y}): {z}, not {expected} +- {bound:e}");
                }
            }
        }
    }
}

#[test]
fn the_near_plane_cuts_exactly() {
    // A wall from before the near plane (z = 0 at x = 2, z = -1 at x = 0) to behind it.
    let size = [16, 16];
    let p = |x: f64, y: f64| DVec3::new(x, y, (x - 6.5) / 16.0);
    let quad = [[p(0.0, 0.0), p(16.0, 0.0), p(16.0, 16.0)], [p(0.0, 0.0), p(16.0, 16.0), p(0.0, 16.0)]];
    let got = depth(&triangles(&quad), clip_from_pixels(size), size);
    for (i, &z) in got.iter().enumerate() {
        let x = (i % 16) as f64 + 0.5;
        // At x = 6.5 depth is 0 exactly: on the cut, a left border.
        let expected = if x < 6.5 { 1.0 } else { (x - 6.5) / 16.0 };
        assert!((f64::from(z) - expected).abs() <= 4.0 * ULP, "({x}): {z}, not {expected}");
    }
}

#[test]
fn what_is_beyond_the_far_plane_is_left_out_per_texel() {
    let size = [16, 16];
    let p = |x: f64, y: f64| DVec3::new(x, y, x / 8.0);
    let quad = [[p(0.0, 0.0), p(16.0, 0.0), p(16.0, 16.0)], [p(0.0, 0.0), p(16.0, 16.0), p(0.0, 16.0)]];
    for (i, &z) in depth(&triangles(&quad), clip_from_pixels(size), size).iter().enumerate() {
        let x = (i % 16) as f64 + 0.5;
        assert!((f64::from(z) - (x / 8.0).min(1.0)).abs() <= 8.0 * ULP);
    }
}

#[test]
fn huge_triangles_do_not_overflow() {
    let size = [64, 64];
    for reach in [1e3, 1e5, 1e7, 1e12] {
        // One triangle over everything, its depth flat; then tilted, so that the plane can be checked.
        let corners = [DVec2::new(-reach, -reach), DVec2::new(3.0 * reach, -reach), DVec2::new(-reach, 3.0 * reach)];
        let flat = depth(&triangles(&[corners.map(|p| p.extend(0.25))]), clip_from_pixels(size), size);
        assert!(flat.iter().all(|&z| (f64::from(z) - 0.25).abs() <= 4.0 * ULP), "reach {reach}");
        // Half of the image: the edge runs along x = 32 from far above to far below.
        let half = [DVec2::new(32.0, -reach), DVec2::new(32.0, reach), DVec2::new(-reach, 0.0)];
        let got = depth(&triangles(&[half.map(|p| p.extend(0.25))]), clip_from_pixels(size), size);
        if reach < 1e7 {
            // Beyond that f32 itself cannot place the edge to a pixel.
            assert!(got.iter().enumerate().all(|(i, &z)| (z < 1.0) == (i % 64 < 32)), "reach {reach}");
        }
    }
}

#[test]
fn a_warp_with_casters_behind_its_centre_draws_only_what_is_before() {
    // w = 1 + y / 2 (world y in [-4, 4]): negative below y = -2. The plane z = 0.5 fills the part with w > 0.
    let m = DMat4::from_cols(
        DVec4::new(0.5, 0.0, 0.0, 0.0),
        DVec4::new(0.0, 0.5, 0.0, 0.5),
        DVec4::new(0.0, 0.0, 1.0, 0.0),
        DVec4::new(0.0, 0.0, 0.0, 1.0),
    );
    let quad = |y0: f64, y1: f64| {
        let p = |x: f64, y: f64| DVec3::new(x, y, 0.5);
        [[p(-40.0, y0), p(40.0, y0), p(40.0, y1)], [p(-40.0, y0), p(40.0, y1), p(-40.0, y1)]]
    };
    let size = [32, 32];
    let whole = depth(&triangles(&quad(-4.0, 4.0)), m, size);
    for (i, &z) in whole.iter().enumerate() {
        // ndc_y = y / 2 / w  ->  w = 1 / (1 - ndc_y), z = 0.5 (1 - ndc_y); clipped where z > w, z <= 1.
        let ndc_y = 1.0 - 2.0 * ((i / 32) as f64 + 0.5) / 32.0;
        let w = 1.0 / (1.0 - ndc_y);
        let y = 2.0 * (w - 1.0);
        let expected = if (-4.0..=4.0).contains(&y) { (0.5 / w).min(1.0) } else { 1.0 };
        assert!((f64::from(z) - expected).abs() <= 16.0 * ULP, "{i}: {z}, not {expected}");
    }
    assert!(depth(&triangles(&quad(-4.0, -2.5)), m, size).iter().all(|&z| z == 1.0));
}

/// A bumpy sheet, with triangles of many sizes.
fn sheet(n: usize) -> Vec<[DVec3; 3]> {
    let p = |i: usize, j: usize| {
        let (u, v) = (i as f64 / n as f64, j as f64 / n as f64);
        DVec3::new(u * u * 2.0 - 1.0, v * 2.0 - 1.0, 0.5 + 0.3 * (11.0 * u).sin() * (7.0 * v * v).cos())
    };
    let quads = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    quads
        .flat_map(|(i, j)| [[p(i, j), p(i + 1, j), p(i + 1, j + 1)], [p(i, j), p(i + 1, j + 1), p(i, j + 1)]])
        .collect()
}

#[test]
fn threads_make_no_difference() {
    let scene = triangles(&sheet(120));
    let p = maps(&[DMat4::IDENTITY, DMat4::from_rotation_z(0.3), DMat4::from_scale(DVec3::new(3.0, 2.0, 1.0))]);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            CpuRenderer::new().depth_maps(&scene, &p, [300, 200], Stored::default(), &Progress::new()).unwrap()
        })
    };
    let one = on(1);
    assert!(one.data.iter().any(|&z| z < 1.0));
    assert_eq!(one.layers, 3);
    assert_eq!(one, on(2));
    assert_eq!(one, on(5));
}

#[test]
fn memory_of_earlier_calls_leaves_no_trace() {
    let renderer = CpuRenderer::new();
    let draw = |r: &CpuRenderer, scene: &Scene, n: u32| {
        r.depth_maps(scene, &one_map(DMat4::IDENTITY), [n, n], Stored::default(), &Progress::new()).unwrap().data
    };
    let (large, small) = (triangles(&sheet(90)), triangles(&sheet(3)));
    let nothing = large.transformed(&DAffine3::from_translation(DVec3::X * 10.0)).unwrap();
    for (scene, n) in [(&large, 200), (&small, 50), (&nothing, 64), (&small, 300)] {
        assert_eq!(draw(&renderer, scene, n), draw(&CpuRenderer::new(), scene, n));
    }
    assert!(draw(&renderer, &nothing, 64).iter().all(|&z| z == 1.0));
}

#[test]
fn place_and_scale_of_the_world_do_not_matter() {
    let (size, corners) = ([128, 128], sheet(40));
    let at_origin = depth(&triangles(&corners), DMat4::IDENTITY, size);
    let utm = DVec3::new(512_345.0, 5_412_345.0, 1234.0);
    // UTM coordinates in f64 keep 1e-10 of a unit, so powers of two are equal to the last bit, others to f32's.
    for (scale, place) in
        [(2f64.powi(-20), DVec3::ZERO), (2f64.powi(30), DVec3::ZERO), (1.0, utm), (1e-6, DVec3::ZERO), (1e9, utm)]
    {
        let moved: Vec<_> = corners.iter().map(|t| t.map(|p| p * scale + place)).collect();
        let matrix = DMat4::from_scale(DVec3::splat(1.0 / scale)) * DMat4::from_translation(-place);
        let got = depth(&triangles(&moved), matrix, size);
        let differing = got.iter().zip(&at_origin).filter(|(a, b)| (**a - **b).abs() > 1e-6).count();
        assert!(differing <= 2, "scale {scale}, place {place}: {differing} texels differ");
    }
}

#[test]
fn mirrored_sheared_and_flattened_instances_are_drawn_as_their_triangles() {
    let corners = sheet(20);
    let maps = [
        DAffine3::from_scale(DVec3::new(-0.5, 0.5, 1.0)),
        DAffine3::from_mat3(DMat3::from_cols(DVec3::X * 0.5, DVec3::new(0.4, 0.5, 0.0), DVec3::Z)),
        DAffine3::from_scale_rotation_translation(
            DVec3::new(0.3, 0.9, 0.2),
            glam::DQuat::from_rotation_y(0.7),
            DVec3::new(0.1, 0.0, 0.4),
        ),
        DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0)),
    ];
    for map in maps {
        let placed = depth(&instances(triangle_mesh(&corners), &[map]), DMat4::IDENTITY, [96, 96]);
        let baked: Vec<_> = corners.iter().map(|t| t.map(|p| map.transform_point3(p))).collect();
        let baked = depth(&triangles(&baked), DMat4::IDENTITY, [96, 96]);
        assert!(baked.iter().any(|&z| z < 1.0));
        // The two round differently on the way to the grid: single vertices may snap to the other side.
        let differing = placed.iter().zip(&baked).filter(|(a, b)| (**a - **b).abs() > 1e-5).count();
        assert!(differing <= 8, "{map:?}: {differing} texels differ");
    }
}

#[test]
fn thousands_of_instances_fill_several_batches() {
    // 400 instances of 7,200 triangles: 2.9 million, three batches. Each shows as one tile of the map.
    let n = 20;
    let tile = |k: usize| {
        let (i, j) = ((k % n) as f64, (k / n) as f64);
        let place = DVec3::new((2.0 * i + 1.0) / n as f64 - 1.0, (2.0 * j + 1.0) / n as f64 - 1.0, 0.0);
        DAffine3::from_scale_rotation_translation(DVec3::new(0.05, 0.05, 1.0), glam::DQuat::IDENTITY, place)
    };
    let mesh = triangle_mesh(&sheet(60));
    let places: Vec<_> = (0..n * n).map(tile).collect();
    let size = [n as u32 * 16, n as u32 * 16];
    let got = depth(&instances(mesh, &places), DMat4::IDENTITY, size);
    let first = depth(&instances(triangle_mesh(&sheet(60)), &places[..1]), DMat4::IDENTITY, size);
    for j in 0..16 {
        for i in 0..16 {
            let at = |data: &[f32], x: usize, y: usize| data[(y * 16 + j) * size[0] as usize + x * 16 + i];
            // The first tile is at the bottom left.
            let expected = at(&first, 0, n - 1);
            assert!(expected < 1.0);
            for (x, y) in [(0, 0), (7, 3), (n - 1, n - 1), (0, n - 1), (n - 1, 0)] {
                let error = at(&got, x, y) - expected;
                assert!(error.abs() < 0.05, "tile ({x}, {y}), texel ({i}, {j}): {error}");
            }
        }
    }
}

#[test]
fn degenerate_triangles_cover_nothing() {
    let size = [32, 32];
    let p = |x: f64, y: f64| DVec3::new(x, y, 0.5);
    let cases = [
        [p(4.5, 4.5); 3],
        [p(4.5, 4.5), p(20.5, 4.5), p(4.5, 4.5)],
        [p(0.5, 0.5), p(10.5, 10.5), p(20.5, 20.5)],
        [p(5.5, 0.0), p(5.5, 10.0), p(5.5, 32.0)],
        // Seen exactly edge on: a vertical wall.
        [DVec3::new(3.0, 8.5, 0.0), DVec3::new(30.0, 8.5, 0.0), DVec3::new(12.0, 8.5, 1.0)],
    ];
    for corners in cases {
        assert!(depth(&triangles(&[corners]), clip_from_pixels(size), size).iter().all(|&z| z == 1.0), "{corners:?}");
    }
}

#[test]
fn bad_input_is_named() {
    let scene = triangles(&sheet(2));
    let draw = |p, size| CpuRenderer::new().depth_maps(&scene, &p, size, Stored::default(), &Progress::new());
    let is_about = |result: shadowlab::Result<_>, expected: &str| match result {
        Err(Error::InvalidArgument { name, .. }) => assert_eq!(name, expected),
        other => panic!("expected an invalid {expected}, got {other:?}"),
    };
    for size in [[0, 8], [8, 0], [16385, 8], [8, u32::MAX]] {
        is_about(draw(one_map(DMat4::IDENTITY), size), "resolution");
    }
    is_about(draw(one_map(DMat4::NAN), [8, 8]), "shadow_clip_from_world");
    is_about(draw(one_map(DMat4::from_scale(DVec3::INFINITY)), [8, 8]), "shadow_clip_from_world");
    is_about(draw(maps(&[]), [8, 8]), "parameterization");
    // Finite, though nothing can be seen through it; and a matrix of any magnitude draws the same.
    assert!(draw(one_map(DMat4::ZERO), [8, 8]).unwrap().data.iter().all(|&z| z == 1.0));
    let plain = draw(one_map(DMat4::IDENTITY), [8, 8]).unwrap();
    for scale in [1e-250, 1e250, 2f64.powi(1000)] {
        let got = draw(one_map(DMat4::IDENTITY * scale), [8, 8]).unwrap();
        assert!(got.data.iter().zip(&plain.data).all(|(a, b)| (a - b).abs() <= 2.0 * f32::EPSILON), "scale {scale:e}");
    }
    assert!(draw(one_map(DMat4::IDENTITY * -1.0), [8, 8]).unwrap().data.iter().all(|&z| z == 1.0));
}

#[test]
fn work_can_be_stopped() {
    let progress = Progress::new();
    progress.stop();
    let result = CpuRenderer::new().depth_maps(
        &triangles(&sheet(9)),
        &one_map(DMat4::IDENTITY),
        [64, 64],
        Stored::default(),
        &progress,
    );
    assert_eq!(result.unwrap_err(), Error::Interrupted);
}
