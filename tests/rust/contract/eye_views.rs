//! The surface that the eye's view shows is the one that an exact ray meets first, whatever the near plane.
//!
//! G-buffers of random views against traced primary rays. The environment variables SHADOWLAB_EYE_VIEWS (a count) and
//! SHADOWLAB_EYE_VIEW (one number) choose others.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use shadowlab::image::GBuffer;
use shadowlab::render::Renderer;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::scene::PixelRay;
use shadowlab::trace::{Hit, Tracer};
use shadowlab::{Camera, Progress, Scene};

use super::eye_scenes::EyeView;
#[cfg(feature = "gpu")]
use crate::support::gpu;

/// Vertices are rounded to 1/256 px, so that edges move by up to 1/362 px, and by the rounding of what is projected.
const EDGE_PX: f64 = 1.0 / 256.0;

/// How far apart along the ray surfaces are that single precision may take for each other, relative to their distance.
struct Tolerance {
    depth: f64,
    /// Of a position, relative to the numbers that it is made from.
    position: f64,
}

/// What differed.
#[derive(Debug, Default)]
struct Tally {
    shown: u64,
    same: u64,
    on_edge: u64,
    as_near: u64,
    failures: Vec<String>,
}

struct Judge<'a> {
    scene: &'a Scene,
    camera: &'a Camera,
    size: [u32; 2],
    tolerance: Tolerance,
}

impl Judge<'_> {
    fn centre(&self, i: usize) -> DVec2 {
        let (x, y) = (i as u32 % self.size[0], i as u32 / self.size[0]);
        DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
    }

    /// Through the centre of a pixel.
    fn ray(&self, i: usize) -> PixelRay {
        let centre = self.centre(i);
        self.camera.pixel_ray(centre.x, centre.y, self.size)
    }

    /// The corners of a triangle, relative to the eye.
    fn corners(&self, (instance, triangle): (i32, i32)) -> [DVec3; 3] {
        let mesh = self.scene.mesh_of(instance as usize);
        let mut map = self.scene.world_from_local(instance as usize);
        map.translation -= self.camera.eye();
        mesh.triangles()[triangle as usize].map(|i| map.transform_point3(mesh.positions_local()[i as usize].as_dvec3()))
    }

    /// Pixels of a point before the eye, from which it is told.
    fn pixel(&self, p: DVec3) -> DVec2 {
        let w = self.camera.w_at(p.dot(self.camera.forward()));
        let across = DVec2::new(p.dot(self.camera.right()), p.dot(self.camera.up()));
        let ndc = across / (w * self.camera.half_size()) - self.camera.volume().shift;
        DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * DVec2::from_array(self.size.map(f64::from))
    }

    /// Whether a pixel's centre is within the grid's rounding of an edge of a triangle, as it is cut by the near and far planes.
    fn is_on_edge(&self, face: (i32, i32), centre: DVec2) -> bool {
        let corners = self.corners(face);
        let depth = |p: DVec3| p.dot(self.camera.forward());
        // Halfway to the near plane nothing is out of proportion, and for parallel rays nowhere; the cuts themselves are edges, too.
        let before = if self.camera.is_orthographic() { f64::NEG_INFINITY } else { 0.5 * self.camera.near() };
        let cut_at = |near: f64, k: usize| {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let (a, b) = if depth(a) < depth(b) { (b, a) } else { (a, b) };
            let is_cut = depth(a) > near && depth(b) < near;
            let end = if is_cut { a.lerp(b, (depth(a) - near) / (depth(a) - depth(b))) } else { b };
            (depth(a) > near).then_some((a, end, is_cut))
        };
        let mut edges: Vec<[DVec3; 2]> = (0..3).filter_map(|k| cut_at(before, k)).map(|(a, b, _)| [a, b]).collect();
        for plane in [self.camera.near(), self.camera.far()] {
            let cut: Vec<DVec3> = (0..3).filter_map(|k| cut_at(plane, k)).filter(|c| c.2).map(|c| c.1).collect();
            edges.extend(cut.first_chunk::<2>());
        }
        edges.into_iter().any(|edge| {
            let [a, b] = edge.map(|p| self.pixel(p));
            let along = b - a;
            let t = ((centre - a).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            let nearest = if t.is_nan() { a } else { a + t * along };
            nearest.distance(centre) <= EDGE_PX
        })
    }

    /// The camera depth at which a ray meets the plane of a triangle.
    fn depth(&self, face: (i32, i32), ray: PixelRay) -> f64 {
        let [a, b, c] = self.corners(face);
        let scale = (b - a).abs().max((c - a).abs()).max_element();
        let normal = ((b - a) / scale).cross((c - a) / scale);
        normal.dot(a - ray.from_eye) / normal.dot(ray.direction)
    }

    fn judge(&self, i: usize, g: &GBuffer, hit: &Hit, tally: &mut Tally) {
        let (centre, ray) = (self.centre(i), self.ray(i));
        let shown = (g.instance[i], g.triangle[i]);
        let exact = (hit.instance, hit.triangle);
        tally.shown += u64::from(shown.1 >= 0);
        if shown.1 >= 0 {
            self.judge_position(i, g, shown, ray, centre, tally);
        }
        if shown == exact {
            tally.same += 1;
            return;
        }
        let on_edge = |face: (i32, i32)| face.1 >= 0 && self.is_on_edge(face, centre);
        if on_edge(shown) || on_edge(exact) {
            tally.on_edge += 1;
            return;
        }
        let [near, far] = [self.camera.near(), self.camera.far()];
        let depth_of = |face: (i32, i32)| if face.1 >= 0 { self.depth(face, ray) } else { f64::INFINITY };
        let [a, b] = [depth_of(shown), depth_of(exact)];
        // Depths of parallel rays begin anywhere.
        let size = |b: f64| if self.camera.is_orthographic() { near.abs().max(far.abs()) } else { b };
        let alike = |a: f64, b: f64| (a - b).abs() <= self.tolerance.depth * size(b);
        if alike(a, b) || alike(a, near) || alike(b, near) || (alike(a.min(b), far) && a.max(b) > far) {
            tally.as_near += 1;
            return;
        }
        tally.failures.push(format!(
            "pixel {i}: shows {shown:?} at depth {a:e}, a ray meets {exact:?} at {b:e}, apart {:e}",
            (a - b).abs() / b
        ));
    }

    fn judge_position(&self, i: usize, g: &GBuffer, face: (i32, i32), ray: PixelRay, centre: DVec2, tally: &mut Tally) {
        let from_origin = DVec3::from_array(g.position[i].map(f64::from));
        let p = g.origin - self.camera.eye() + from_origin;
        let [a, b, c] = self.corners(face);
        let scale = (b - a).abs().max((c - a).abs()).max_element();
        let normal = ((b - a) / scale).cross((c - a) / scale).normalize_or_zero();
        let reach = from_origin.length() + p.length() + (self.camera.eye() - g.origin).length();
        let (off_plane, off_ray) = (normal.dot(p - a).abs(), (p - ray.from_eye).reject_from(ray.direction).length());
        let most = self.tolerance.position * (reach + a.length().max(b.length()).max(c.length()));
        // On the edge of a sliver the plane is met elsewhere, and the point is held within the triangle.
        if (off_plane > most || off_ray > most) && !self.is_on_edge(face, centre) {
            tally
                .failures
                .push(format!("pixel {i}: {p} is {off_plane:e} off {face:?}, {off_ray:e} off the ray, {most:e}"));
        }
    }
}

fn run(renderer: &dyn Renderer, tolerance: Tolerance, view: &EyeView, tally: &mut Tally) {
    let EyeView { scene, camera, size, .. } = view;
    let g = renderer.gbuffer(scene, camera, *size, &Progress::new()).expect("a picture");
    let tracer = Tracer::new(scene, &Progress::new()).expect("a hierarchy");
    let judge = Judge { scene, camera, size: *size, tolerance };
    let rays: Vec<PixelRay> = (0..g.depth.len()).map(|i| judge.ray(i)).collect();
    let from: Vec<[f64; 3]> = rays.iter().map(|ray| (camera.eye() + ray.at(camera.near())).to_array()).collect();
    let rays: Vec<[f64; 3]> = rays.iter().map(|ray| ray.direction.to_array()).collect();
    let hits = tracer.first_hit(&from, &rays, &Progress::new()).expect("hits");
    for (i, hit) in hits.iter().enumerate() {
        let hit = if hit.t <= camera.far() - camera.near() { *hit } else { Hit::NONE };
        judge.judge(i, &g, &hit, tally);
    }
}

fn check(renderer: &dyn Renderer, tolerance: fn() -> Tolerance, count: u64) {
    let of_environment = |name: &str| std::env::var(name).ok().map(|n| n.parse::<u64>().expect("a number"));
    let seeds = match of_environment("SHADOWLAB_EYE_VIEW") {
        Some(one) => one..one + 1,
        None => 0..of_environment("SHADOWLAB_EYE_VIEWS").unwrap_or(count),
    };
    let many = seeds.end - seeds.start >= count;
    let mut all: BTreeMap<String, Tally> = BTreeMap::new();
    let mut failed = Vec::new();
    for seed in seeds {
        let view = EyeView::random(seed);
        let kind = view.what.split(" of size").next().unwrap_or_default().to_string();
        let tally = all.entry(kind).or_default();
        run(renderer, tolerance(), &view, tally);
        if !tally.failures.is_empty() {
            let found = std::mem::take(&mut tally.failures);
            failed.push(format!("view {seed}: {} pixels, {}\n    {view:?}", found.len(), found[0]));
        }
    }
    for (kind, t) in &all {
        println!("{kind}: {} shown, {} same, {} on edges, {} as near", t.shown, t.same, t.on_edge, t.as_near);
    }
    for failure in failed.iter().take(12) {
        println!("  FAILED {failure}");
    }
    assert!(failed.is_empty(), "{} views, see the output", failed.len());
    if many {
        let shown: u64 = all.values().map(|t| t.shown).sum();
        let loose: u64 = all.values().map(|t| t.on_edge + t.as_near).sum();
        assert!(shown > 1000 * count && loose * 20 < shown, "{loose} of {shown} excused");
    }
}

#[test]
fn the_cpu_shows_what_exact_rays_meet() {
    check(&CpuRenderer::new(), || Tolerance { depth: 16.0 * EPSILON, position: 2.0 * EPSILON }, 600);
}

#[cfg(feature = "gpu")]
#[test]
fn the_gpu_shows_what_exact_rays_meet() {
    let Some(renderer) = gpu::renderer() else { return };
    check(&renderer, || Tolerance { depth: 16.0 * EPSILON, position: 4.0 * EPSILON }, 150);
}

const EPSILON: f64 = f32::EPSILON as f64;
