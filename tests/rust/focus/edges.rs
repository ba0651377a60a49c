//! Samples at the edges of shadows: their directions against edges known by construction, where there are none, and how they
//! are thinned.
//!
//! ```text
//!      sun \   ______ slab             the shadow of a slab's straight side on a floor, and the slab's own
//!           \ /_____/                  silhouette before it, which is no edge of a shadow
//!    _________#######__\______ floor
//! ```

use glam::{DMat3, DVec2, DVec3};
use shadowlab::Progress;
use shadowlab::focus::{EdgeSample, Samples};
use shadowlab::image::{GBuffer, TruthMask};
use shadowlab::render::Renderer;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::scene::{Camera, Light, Scene};
use shadowlab::trace::Tracer;

use crate::support::views::{Random, cube, directional, look, placed, square};

/// The floor's place in the list of instances, and the height of the slab's lower side.
const FLOOR: i32 = 0;
const HEIGHT: f64 = 6.0;
/// Of the slab, horizontally.
const HALF: DVec2 = DVec2::new(5.0, 3.0);

/// Of an edge's normal from 25 states: the most and the mean over straight edges at any angle, measured 15.0 and 5.0 degrees.
const MOST_DEG: f64 = 16.0;
const MEAN_DEG: f64 = 6.0;

/// A slab above a floor, turned about the vertical.
fn slab(turn: f64) -> Scene {
    let floor = (square(), DMat3::from_diagonal(DVec3::new(60.0, 1.0, 60.0)), DVec3::ZERO);
    let shape = DMat3::from_rotation_y(turn) * DMat3::from_diagonal(DVec3::new(HALF.x, 0.1, HALF.y));
    placed(&[floor, (cube(), shape, DVec3::new(0.0, HEIGHT + 0.1, 0.0))])
}

struct Seen {
    picture: GBuffer,
    samples: Samples,
    camera: Camera,
}

/// Traced states, and samples with at most `count` at edges.
fn seen(scene: &Scene, camera: Camera, light: &Light, size: [u32; 2], count: usize) -> Seen {
    let progress = Progress::new();
    let picture = CpuRenderer::new().gbuffer(scene, &camera, size, &progress).expect("a picture");
    let tracer = Tracer::new(scene, &progress).expect("a tracer");
    let truth = tracer.shadow_mask(&camera, light, size, &progress).expect("a mask").data;
    let surfaces = picture.surfaces();
    let samples = Samples::of_surfaces(&surfaces, &camera).with_shadows(light, truth, &surfaces, count);
    Seen { picture, samples, camera }
}

impl Seen {
    /// The pixel of each sample.
    fn pixels(&self) -> Vec<usize> {
        (0..self.picture.triangle.len()).filter(|&i| self.picture.triangle[i] >= 0).collect()
    }
    fn edges(&self) -> &[EdgeSample] {
        &self.samples.shadows.as_ref().expect("states").edges
    }
    /// Where a point is seen, pixels.
    fn place(&self, p: DVec3) -> DVec2 {
        self.samples.picture.expect("a picture").place(p - self.camera.eye())
    }
}

#[test]
fn a_straight_edge_on_a_floor_has_its_own_normal() {
    let mut random = Random(3);
    let (mut sum, mut most, mut count) = (0.0, 0.0_f64, 0);
    for i in 0..24 {
        let turn = f64::from(i) * 0.27;
        let along = DVec3::new(random.between(-0.8, 0.8), -1.0, random.between(-0.8, 0.8));
        let camera = look(DVec3::new(14.0, 22.0, 24.0), DVec3::ZERO, 0.8, 0.1, 200.0);
        let s = seen(&slab(turn), camera, &directional(along), [160, 114], usize::MAX);
        // The shadow: the slab's corners moved along the light to the floor. Its hull has straight sides.
        let corners: Vec<DVec3> = [HEIGHT, HEIGHT + 0.2]
            .iter()
            .flat_map(|y| [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, z)| (x, *y, z)))
            .map(|(x, y, z)| DMat3::from_rotation_y(turn) * DVec3::new(x * HALF.x, y, z * HALF.y))
            .map(|p| p + along * p.y)
            .collect();
        let mut hull: Vec<DVec2> = corners.iter().map(|p| s.place(*p)).collect();
        shadowlab::geometry::convex_hull(&mut hull, &mut Vec::new());
        let pixels = s.pixels();
        for edge in s.edges() {
            let pixel = pixels[edge.sample as usize];
            let at = DVec2::new((pixel % 160) as f64 + 0.5, (pixel / 160) as f64 + 0.5);
            // Distance from each side, of its line and of its ends.
            let sides = (0..hull.len()).map(|i| {
                let (a, b) = (hull[i], hull[(i + 1) % hull.len()]);
                let along = (b - a).normalize();
                // The hull is counter-clockwise in pixels: its outside is to the right.
                (-along.perp(), (at - a).perp_dot(along).abs(), (at - a).dot(along).min((b - at).dot(along)))
            });
            // Away from corners, where there is no one direction: the window reaches over 2.5 √2 pixels.
            let near: Vec<_> = sides.filter(|(_, off, inside)| *off < 5.0 && *inside > -5.0).collect();
            let [(outward, _, inside)] = near[..] else { continue };
            let mut window = (-2..=2).flat_map(|dy: i64| (-2..=2).map(move |dx: i64| pixel as i64 + 160 * dy + dx));
            let on_floor = |pixel: i64| s.picture.instance.get(pixel as usize) == Some(&FLOOR);
            if inside < 5.0 || !window.all(on_floor) {
                continue;
            }
            let normal = DVec2::from_array(edge.normal.map(f64::from));
            assert!((normal.length() - 1.0).abs() < 1e-6);
            let off = normal.angle_to(outward).abs().to_degrees();
            assert!(off < MOST_DEG, "{turn}: {normal} and {outward} at {at}, {off}");
            (sum, most, count) = (sum + off, most.max(off), count + 1);
        }
    }
    let mean = sum / f64::from(count);
    println!("{count} edges: {most} degrees at most, {mean} in the mean");
    assert!(count > 2000 && mean < MEAN_DEG, "{count}, {mean}");
}

#[test]
fn silhouettes_are_no_edges_of_shadows() {
    let size = [160, 114];
    let mut silhouettes = 0;
    for (i, along) in
        [DVec3::new(-1.2, -1.0, -2.6), DVec3::new(-1.5, -1.0, -2.9), DVec3::new(-0.9, -1.0, -2.9)].iter().enumerate()
    {
        // With light from behind the camera the lit slab covers a part of its own shadow.
        let camera = look(DVec3::new(9.0, 12.0, 20.0), DVec3::new(0.0, 3.0, 0.0), 0.9, 0.1, 200.0);
        let s = seen(&slab(0.4 * i as f64), camera, &directional(*along), size, usize::MAX);
        let pixels = s.pixels();
        let image = &s.samples.shadows.as_ref().expect("states").image;
        let floor = |pixel: usize| s.picture.instance[pixel] == FLOOR;
        let beside = |pixel: usize| {
            let (x, y) = ((pixel % 160) as i64, (pixel / 160) as i64);
            let inside = |(x, y): &(i64, i64)| (0..160).contains(x) && (0..114).contains(y);
            let all = [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)];
            all.into_iter().filter(inside).map(|(x, y)| (y * 160 + x) as usize).collect::<Vec<_>>()
        };
        let known = |pixel: usize| [TruthMask::LIT, TruthMask::SHADOW].contains(&image[pixel]);
        let other = |pixel: usize, q: usize| known(q) && image[q] != image[pixel];
        let mut expected: Vec<usize> = Vec::new();
        for pixel in (0..image.len()).filter(|&pixel| known(pixel)) {
            let differ: Vec<usize> = beside(pixel).into_iter().filter(|&q| other(pixel, q)).collect();
            // Nothing casts a shadow on the slab.
            if floor(pixel) && differ.iter().any(|&q| floor(q)) {
                expected.push(pixel);
            } else if !differ.is_empty() {
                silhouettes += 1;
            }
        }
        let mut found: Vec<usize> = s.edges().iter().map(|edge| pixels[edge.sample as usize]).collect();
        found.sort_unstable();
        assert_eq!(found, expected, "{along}");
    }
    assert!(silhouettes > 60, "{silhouettes}");
}

/// The share of pixels in each of 24 parts of a picture.
fn shares(pixels: impl Iterator<Item = usize>, size: [u32; 2]) -> [f64; 24] {
    let (mut shares, mut count) = ([0.0; 24], 0.0);
    for pixel in pixels {
        let (x, y) = (pixel as u32 % size[0], pixel as u32 / size[0]);
        shares[(y * 4 / size[1] * 6 + x * 6 / size[0]) as usize] += 1.0;
        count += 1.0;
    }
    shares.map(|n| n / count)
}

#[test]
fn fewer_edges_stand_for_all_and_every_beginning_is_spread() {
    let size = [320, 228];
    let mut random = Random(9);
    let mut parts = vec![(square(), DMat3::from_diagonal(DVec3::new(60.0, 1.0, 60.0)), DVec3::ZERO)];
    for _ in 0..40 {
        let turn = DMat3::from_rotation_y(random.between(0.0, 6.0));
        let at = DVec3::new(random.between(-25.0, 25.0), random.between(0.5, 3.0), random.between(-25.0, 25.0));
        parts.push((cube(), turn * DMat3::from_diagonal(DVec3::new(1.0, 0.5, 2.0)), at));
    }
    let camera = look(DVec3::new(10.0, 35.0, 40.0), DVec3::ZERO, 0.9, 0.1, 200.0);
    let (scene, light) = (placed(&parts), directional(DVec3::new(0.5, -1.0, 0.2)));
    let all = seen(&scene, camera, &light, size, usize::MAX);
    let pixels = all.pixels();
    let of = |edges: &[EdgeSample]| shares(edges.iter().map(|edge| pixels[edge.sample as usize]), size);
    let total = all.edges().len();
    assert!(total > 1000 && all.edges().iter().all(|edge| edge.weight == 1.0), "{total}");
    let expected = of(all.edges());
    let off =
        |edges: &[EdgeSample]| of(edges).iter().zip(expected).map(|(ours, all)| (ours - all).abs()).fold(0.0, f64::max);
    for count in [1, 7, 100, 333, 512, total - 1] {
        let fewer = seen(&scene, camera, &light, size, count);
        let edges = fewer.edges();
        assert_eq!(edges.len(), count);
        let weight = edges.iter().map(|edge| f64::from(edge.weight)).sum::<f64>();
        assert!((weight / total as f64 - 1.0).abs() < 1e-5, "{count}: {weight} of {total}");
        let mut once: Vec<u32> = edges.iter().map(|edge| edge.sample).collect();
        once.sort_unstable();
        once.dedup();
        assert_eq!(once.len(), count, "an edge twice");
        // Along the curve every step is taken once: a part of the picture is a few runs of it, each off by a step.
        for share in [1.0, 0.5, 0.25, 0.125] {
            let first = (count as f64 * share).ceil() as usize;
            if first >= 24 {
                let off = off(&edges[..first]);
                assert!(off < 4.0 / first as f64, "{count}, the first {first}: {off}");
            }
        }
    }
    // In the order of the picture, the beginning is its top.
    let mut by_row = all.edges().to_vec();
    by_row.sort_by_key(|edge| edge.sample);
    assert!(off(&by_row[..128]) > 0.1);
}
