//! A visible triangle, and where the ray of a pixel meets its plane.

use glam::DVec3;

use crate::scene::{Camera, PixelRay, Scene};

/// A visible triangle, relative to the eye.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface {
    pub(super) id: u32,
    pub(super) triangle: i32,
    pub(super) instance: i32,
    /// A corner.
    pub(super) corner: DVec3,
    /// Unit normal; zero for a triangle without area.
    pub(super) normal: DVec3,
    /// Camera depths of the nearest and the farthest corner.
    pub(super) depths: [f64; 2],
    /// For each side a direction in the plane and an offset: 1 at the corner before it, 0 on it.
    pub(super) sides: [(DVec3, f64); 3],
}

/// Of a plane seen edge on: sine of the angle to the ray that rounding leaves nothing of.
pub(super) const EDGE_ON: f64 = 16.0 * f64::EPSILON;
/// How far beside a triangle its plane may be met, in parts of the triangle. Pixels on its rim are up to 1/362 px beside it.
pub(super) const BESIDE: f64 = 1.0 / 64.0;

impl Surface {
    pub(super) fn new(scene: &Scene, camera: &Camera, first_ids: &[u64], id: u32) -> Self {
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
    pub(super) fn seen_along(&self, camera: &Camera, ray: &PixelRay, to_far: f64) -> (f64, DVec3) {
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
