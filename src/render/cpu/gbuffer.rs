//! What each pixel shows: the visible triangle turned into position and normal, in f64.
//!
//! Positions are where the ray through the pixel's centre meets the plane of the triangle: exact for the triangle as it
//! stands in the scene, free of the rounding of depth buffers and of the pixel grid.

use glam::DVec3;
use rayon::prelude::*;

use super::passes::{NO_TRIANGLE, Pass, pixel_count};
use crate::error::Result;
use crate::image::GBuffer;
use crate::memory::{unwritten, written};
use crate::progress::Progress;
use crate::render::check_extent;
use crate::scene::{Camera, PixelRay, Scene};

/// The G-buffer of what `pass` sees.
pub fn gbuffer(pass: &mut Pass, camera: &Camera) -> Result<GBuffer> {
    let (scene, size, progress) = (pass.scene, pass.size, pass.progress);
    check_extent(scene)?;
    let (depth, ids) = pass.depth_and_ids()?;
    resolve(scene, camera, size, depth, &ids, progress)
}

fn resolve(
    scene: &Scene,
    camera: &Camera,
    size: [u32; 2],
    mut depth: Vec<f32>,
    ids: &[u32],
    progress: &Progress,
) -> Result<GBuffer> {
    let n = pixel_count(size);
    let width = size[0] as usize;
    let first_ids = scene.first_triangles();
    let rays = Rays::new(camera, size);
    let eye_from_origin = camera.eye() - scene.origin();
    let (mut position, mut normal) = (unwritten::<[f32; 3]>(n)?, unwritten::<[f32; 3]>(n)?);
    let (mut triangle, mut instance) = (unwritten::<i32>(n)?, unwritten::<i32>(n)?);
    let rows = (position.par_chunks_mut(width), normal.par_chunks_mut(width));
    let rows = rows.0.zip(rows.1).zip(triangle.par_chunks_mut(width).zip(instance.par_chunks_mut(width)));
    let rows = rows.zip(ids.par_chunks(width).zip(depth.par_chunks_mut(width))).enumerate();
    rows.try_for_each(|(y, (((position, normal), (triangle, instance)), (ids, depth)))| {
        progress.check()?;
        let mut known: Option<Surface> = None;
        for x in 0..width {
            if ids[x] == NO_TRIANGLE {
                depth[x] = 1.0;
                position[x].write([0.0; 3]);
                normal[x].write([0.0; 3]);
                triangle[x].write(-1);
                instance[x].write(-1);
                continue;
            }
            // Neighbouring pixels often show the same triangle.
            let surface = match known {
                Some(surface) if surface.id == ids[x] => surface,
                _ => Surface::new(scene, camera, first_ids, ids[x]),
            };
            known = Some(surface);
            let ray = rays.at(x, y);
            let (t, n) = surface.seen_along(camera, &ray, f64::from(depth[x]));
            depth[x] = camera.volume().ndc_depth(t) as f32;
            position[x].write((eye_from_origin + ray.at(t)).as_vec3().to_array());
            normal[x].write(n.as_vec3().to_array());
            triangle[x].write(surface.triangle);
            instance[x].write(surface.instance);
        }
        Ok(())
    })?;
    // SAFETY: every row has been written, or the error has been returned.
    let (position, normal) = unsafe { (written(position), written(normal)) };
    let (triangle, instance) = unsafe { (written(triangle), written(instance)) };
    Ok(GBuffer { size, origin: scene.origin(), depth, position, normal, triangle, instance })
}

/// The rays through the centres of pixels: affine in the pixel, so three of them tell all.
struct Rays {
    first: PixelRay,
    right: PixelRay,
    down: PixelRay,
}

impl Rays {
    fn new(camera: &Camera, size: [u32; 2]) -> Self {
        let first = camera.pixel_ray(0.5, 0.5, size);
        let from_first = |x: f64, y: f64| {
            let ray = camera.pixel_ray(x, y, size);
            PixelRay { from_eye: ray.from_eye - first.from_eye, direction: ray.direction - first.direction }
        };
        Self { first, right: from_first(1.5, 0.5), down: from_first(0.5, 1.5) }
    }

    fn at(&self, x: usize, y: usize) -> PixelRay {
        let (x, y) = (x as f64, y as f64);
        let of = |part: fn(&PixelRay) -> DVec3| part(&self.first) + x * part(&self.right) + y * part(&self.down);
        PixelRay { from_eye: of(|ray| ray.from_eye), direction: of(|ray| ray.direction) }
    }
}

/// A visible triangle, relative to the eye.
#[derive(Debug, Clone, Copy)]
struct Surface {
    id: u32,
    triangle: i32,
    instance: i32,
    /// A corner.
    corner: DVec3,
    /// Unit normal; zero for a triangle without area.
    normal: DVec3,
    /// Camera depths of the nearest and the farthest corner.
    depths: [f64; 2],
    /// For each side a direction in the plane and an offset: 1 at the corner before it, 0 on it.
    sides: [(DVec3, f64); 3],
}

/// Of a plane seen edge on: sine of the angle to the ray that rounding leaves nothing of.
const EDGE_ON: f64 = 16.0 * f64::EPSILON;
/// How far beside a triangle its plane may be met, in parts of the triangle. Pixels on its rim are up to 1/362 px beside it.
const BESIDE: f64 = 1.0 / 64.0;

impl Surface {
    fn new(scene: &Scene, camera: &Camera, first_ids: &[u64], id: u32) -> Self {
        // Instances without triangles do not exist, so numbers are strictly increasing.
        let instance = first_ids.partition_point(|&first| first <= u64::from(id)) - 1;
        let triangle = id - first_ids[instance] as u32;
        let mesh = scene.mesh_of(instance);
        let eye_from_local = {
            let mut map = scene.world_from_local(instance);
            map.translation -= camera.eye();
            map
        };
        let corner = |i: u32| mesh.positions_local()[i as usize].as_dvec3();
        let [a, b, c] = mesh.triangles()[triangle as usize];
        let local = [corner(a), corner(b), corner(c)];
        let placed = |p: DVec3| eye_from_local.transform_point3(p);
        let [a, b, c] = [placed(local[0]), placed(local[1]), placed(local[2])];
        // Edges as differences of local coordinates: the world's translation has no part in them.
        let (ab, ac) = ((local[1] - local[0]), (local[2] - local[0]));
        let normal = unit_normal(eye_from_local.matrix3 * ab, eye_from_local.matrix3 * ac);
        let forward = camera.forward();
        let depths = [a.dot(forward), b.dot(forward), c.dot(forward)];
        Self {
            id,
            triangle: triangle as i32,
            instance: instance as i32,
            corner: a,
            normal,
            depths: [
                depths[0].min(depths[1]).min(depths[2]).max(camera.near()),
                depths[0].max(depths[1]).max(depths[2]).min(camera.far()),
            ],
            sides: [side(normal, [b, c, a]), side(normal, [c, a, b]), side(normal, [a, b, c])],
        }
    }

    /// Where a ray runs above or below the triangle, or [`BESIDE`] it: an interval of its depths, empty if it passes by.
    fn passage(&self, ray: &PixelRay) -> [f64; 2] {
        self.sides.iter().fold([f64::NEG_INFINITY, f64::INFINITY], |[begin, end], (inwards, offset)| {
            let (here, per_depth) = (inwards.dot(ray.from_eye) + offset + BESIDE, inwards.dot(ray.direction));
            let crossed = -here / per_depth;
            match per_depth {
                p if p > 0.0 => [begin.max(crossed), end],
                p if p < 0.0 => [begin, end.min(crossed)],
                _ if here >= 0.0 => [begin, end],
                _ => [f64::INFINITY, f64::NEG_INFINITY],
            }
        })
    }

    /// Whether a point of the plane is beside the triangle by more than the pixel grid makes of its rim.
    fn is_beside(&self, p: DVec3) -> bool {
        self.sides.iter().any(|(inwards, offset)| inwards.dot(p) + offset < -BESIDE)
    }

    /// The camera depth at which a pixel's ray meets the triangle's plane, and the unit normal towards the eye.
    ///
    /// A triangle seen nearly edge on covers pixels on the grid that its plane misses by up to
    /// 1/512 pixel, where the plane is met far away; the point is therefore held where the ray passes by the triangle, and
    /// within its camera depths. In a plane seen exactly edge on the triangle is met at its rim; without an area it leaves
    /// the rasterised depth.
    fn seen_along(&self, camera: &Camera, ray: &PixelRay, to_far: f64) -> (f64, DVec3) {
        let along = self.normal.dot(ray.direction);
        let t = self.normal.dot(self.corner - ray.from_eye) / along;
        let is_edge_on = along.abs() <= EDGE_ON * ray.direction.length();
        let passage = (is_edge_on || self.is_beside(ray.at(t))).then(|| self.passage(ray));
        let t = match passage {
            Some([begin, end]) if begin <= end => {
                if is_edge_on {
                    begin
                } else {
                    t.max(begin).min(end)
                }
            }
            _ if t.is_finite() => t,
            _ => camera.volume().depth_before_far(to_far),
        };
        // Not `clamp`: a triangle on the far plane may have its ends in the wrong order by a rounding.
        let t = t.max(self.depths[0]).min(self.depths[1]);
        let normal = match self.normal {
            DVec3::ZERO => -ray.direction.normalize(),
            n if along > 0.0 => -n,
            n => n,
        };
        (t, normal)
    }
}

/// A direction in the plane and an offset: 1 at the last corner, 0 on the side between the others.
#[inline(always)]
fn side(normal: DVec3, [from, to, before]: [DVec3; 3]) -> (DVec3, f64) {
    let inwards = normal.cross(to - from);
    let inwards = inwards / inwards.dot(before - from);
    (inwards, -inwards.dot(from))
}

/// The unit vector along the cross product, at any scale of the edges; zero where they are parallel.
fn unit_normal(ab: DVec3, ac: DVec3) -> DVec3 {
    let scaled = |v: DVec3| v / v.abs().max_element().max(f64::MIN_POSITIVE);
    let cross = scaled(ab).cross(scaled(ac));
    scaled(cross).normalize_or_zero()
}
