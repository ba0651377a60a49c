//! The picture that samples come from: what a pixel spans on the plane of the surface that it shows.
//!
//! Source: theory.md 10.2 (hulls are completed to the corners of the samples' pixels) and (E.5). Everything is relative to the
//! eye.
//!
//! ```text
//!     eye x ----.----.      the corners of a pixel on the plane of its surface;
//!            \   `--. `-.   along a grazing plane no farther than a share of
//!             \______`--_`_ the distance, for nothing says that it goes on
//! ```

use glam::{DVec2, DVec3};

use crate::scene::{Camera, PixelRay};

/// A point lies on the plane of another one where the depth that the plane foretells of it is right to this share of its distance
/// ([`Camera::distance_at`]). Chosen
/// because neighbours on curved surfaces in pictures of 128 pixels a side stay below it, and casters off a wall above.
const SAME_SURFACE: f64 = 0.05;

/// A corner of a pixel lies at most this share of the sample's distance nearer or farther than the sample. Chosen because a few
/// far corners cost a map half of its texels, while neighbours of a pixel are rarely farther apart in depth.
const MOST_DEPTH_SHARE: f64 = 0.25;

/// Rays through the pixels of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Picture {
    /// Its camera.
    pub camera: Camera,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Ray at the top left corner of the picture, of depth 1, and its change over one pixel to the right and one down: of a
    /// perspective in its direction, of parallel rays in where they are.
    corner: PixelRay,
    per_x: DVec3,
    per_y: DVec3,
    /// Pixels per unit of x / w and of y / w; y down. The middle of the picture, in pixels from its corner, is that of x / w = 0.
    pixels: DVec2,
    straight_ahead: DVec2,
    /// Half of a pixel's two sides together over w, and the longest ray of all, of depth 1.
    half_pixel: f64,
    longest_ray: f64,
    /// Of parallel rays: [`MOST_DEPTH_SHARE`] of the picture's height; nothing of a perspective.
    parallel_reach: Option<f64>,
}

impl Picture {
    /// The picture of `size` pixels.
    pub fn new(camera: &Camera, size: [u32; 2]) -> Self {
        let (half, center) = (camera.half_size(), camera.volume().center());
        let (right, up) = (camera.right() * half.x, camera.up() * half.y);
        let (per_x, per_y) = (right * (2.0 / f64::from(size[0])), up * (-2.0 / f64::from(size[1])));
        let aside = camera.right() * center.x + camera.up() * center.y;
        let farthest = center.abs() + half;
        let pixels = DVec2::new(0.5 * f64::from(size[0]) / half.x, -0.5 * f64::from(size[1]) / half.y);
        let (corner, longest_ray, parallel_reach) = if camera.is_orthographic() {
            let corner = PixelRay { from_eye: aside - right + up, direction: camera.forward() };
            (corner, 1.0, Some(MOST_DEPTH_SHARE * camera.volume().height()))
        } else {
            let corner = PixelRay { from_eye: DVec3::ZERO, direction: camera.forward() - right + up + aside };
            (corner, (1.0 + farthest.x * farthest.x + farthest.y * farthest.y).sqrt(), None)
        };
        Self {
            camera: *camera,
            size,
            corner,
            per_x,
            per_y,
            half_pixel: 0.5 * (per_x.length() + per_y.length()),
            longest_ray,
            pixels,
            straight_ahead: 0.5 * DVec2::new(f64::from(size[0]), f64::from(size[1])) - center * pixels,
            parallel_reach,
        }
    }
    /// The point at a depth that is seen at a place of the picture, pixels from its top left corner.
    pub fn at(&self, place: DVec2, depth: f64) -> DVec3 {
        let PixelRay { from_eye, direction } = self.corner;
        let aside = self.per_x * place.x + self.per_y * place.y;
        match self.parallel_reach {
            None => (direction + aside) * depth,
            Some(_) => from_eye + aside + direction * depth,
        }
    }
    /// Where a point is seen, pixels from the top left corner.
    pub fn place(&self, p: DVec3) -> DVec2 {
        let w = self.camera.w_at(p.dot(self.camera.forward()));
        let across = DVec2::new(p.dot(self.camera.right()), p.dot(self.camera.up())) / w;
        across * self.pixels + self.straight_ahead
    }
    /// The pixel at a place of the picture, column and row; nothing outside.
    pub fn pixel(&self, at: DVec2) -> Option<[usize; 2]> {
        let inside = at.cmpge(DVec2::ZERO).all() && at.x < f64::from(self.size[0]) && at.y < f64::from(self.size[1]);
        inside.then_some([at.x as usize, at.y as usize])
    }
    /// Whether a point lies on the plane through `p` with normal `n`, as far as its depth says; all relative to the eye.
    pub fn is_on_plane(&self, (p, n): (DVec3, DVec3), q: DVec3) -> bool {
        let depth = self.camera.forward().dot(q);
        if self.camera.is_orthographic() {
            // How far before or behind the plane it lies.
            let off = n.dot(p - q) / n.dot(self.camera.forward());
            return off.abs() <= SAME_SURFACE * self.camera.distance_at(depth);
        }
        let share = n.dot(p) / n.dot(q / depth) / depth;
        (share - 1.0).abs() <= SAME_SURFACE
    }
    /// Gradients of [`Picture::place`].
    pub fn gradients(&self, p: DVec3) -> [DVec3; 2] {
        let (right, up, forward) = (self.camera.right(), self.camera.up(), self.camera.forward());
        if self.camera.is_orthographic() {
            return [right * self.pixels.x, up * self.pixels.y];
        }
        let per_depth = p.dot(forward).recip();
        let across = |axis: DVec3| (axis - forward * (p.dot(axis) * per_depth)) * per_depth;
        [across(right) * self.pixels.x, across(up) * self.pixels.y]
    }
    /// The point of the plane through `p` with this normal on a ray, within the share of its distance. The ray: its direction, of
    /// depth 1; of parallel rays how far aside of `p`.
    #[inline(always)]
    fn on_plane(&self, p: DVec3, normal: DVec3, ray: DVec3) -> DVec3 {
        let depth = p.dot(self.camera.forward());
        if let Some(most) = self.parallel_reach {
            let deeper = -normal.dot(ray) / normal.dot(self.camera.forward());
            // A plane along the rays is met anywhere: where it is, or as far as may be.
            let deeper = if deeper.is_nan() { 0.0 } else { deeper.clamp(-most, most) };
            return p + ray + self.camera.forward() * deeper;
        }
        // 1 / t is what rounds to nothing on a plane along the ray.
        let per_depth = normal.dot(ray) / normal.dot(p) * depth;
        let share = per_depth.recip();
        let [least, most] = [1.0 - MOST_DEPTH_SHARE, 1.0 + MOST_DEPTH_SHARE];
        // Negative beyond the horizon; a NaN for a plane through the eye.
        let share = if per_depth > 0.0 { share.clamp(least, most) } else { most };
        ray * (depth * share)
    }
    /// The corners of the pixel of a sample on the plane of its surface.
    #[inline(always)]
    pub fn corners(&self, p: DVec3, normal: DVec3) -> [DVec3; 4] {
        let center = match self.parallel_reach {
            None => p / p.dot(self.camera.forward()),
            Some(_) => DVec3::ZERO,
        };
        let (x, y) = (0.5 * self.per_x, 0.5 * self.per_y);
        // Written out: a closure over the four is not compiled for the instructions of its caller.
        [
            self.on_plane(p, normal, center - x - y),
            self.on_plane(p, normal, center + x - y),
            self.on_plane(p, normal, center + x + y),
            self.on_plane(p, normal, center - x + y),
        ]
    }
    /// Camera depths of the corners of a sample's pixel on the plane of its surface, at the least and at the most.
    pub fn depths(&self, p: DVec3, normal: DVec3) -> [f64; 2] {
        let depth = p.dot(self.camera.forward());
        // The corners' rays have products with the normal that differ from the middle's by at most this.
        let aside = 0.5 * (normal.dot(self.per_x).abs() + normal.dot(self.per_y).abs());
        let off_plane = normal.dot(self.camera.way_to(p)).abs();
        match self.parallel_reach {
            None => depth_shares(aside * depth / off_plane).map(|share| share * depth),
            Some(most) => {
                let step = (aside / off_plane).min(most);
                [depth - step, depth + step]
            }
        }
    }
    /// The same, at the least and at the most, of samples between two depths whose normals have at least `off_plane` for a product
    /// with the way to them ([`Camera::way_to`]): before an eye how far it lies off their planes.
    pub fn depths_within(&self, [near, far]: [f64; 2], off_plane: f64) -> [f64; 2] {
        match self.parallel_reach {
            None => {
                let span = depth_shares(self.half_pixel * far / off_plane);
                [near * span[0], far * span[1]]
            }
            Some(most) => {
                let step = (self.half_pixel / off_plane).min(most);
                [near - step, far + step]
            }
        }
    }
    /// How far the corners of a sample's pixel lie from it at the most.
    #[inline(always)]
    pub fn reach(&self, p: DVec3, normal: DVec3) -> f64 {
        self.reach_within(p.dot(self.camera.forward()), normal.dot(self.camera.way_to(p)).abs())
    }
    /// The same of samples no farther than a depth, with products as for [`Picture::depths_within`].
    #[inline(always)]
    pub fn reach_within(&self, depth: f64, off_plane: f64) -> f64 {
        if let Some(most) = self.parallel_reach {
            return self.half_pixel + (self.half_pixel / off_plane).min(most);
        }
        let half = self.half_pixel * depth;
        let distance = depth * self.longest_ray;
        // A step of `half` across the ray changes the depth of the plane by half / tan of the angle between them, and twice
        // that far bounds the change of that angle over the step; where it does not, the share does.
        let along = (2.0 * half * distance / off_plane).min(MOST_DEPTH_SHARE * distance);
        (1.0 + MOST_DEPTH_SHARE) * half + if along.is_nan() { MOST_DEPTH_SHARE * distance } else { along }
    }
}

/// Shares of a sample's depth at which the corners of its pixel are, whose rays have products with the normal that differ from
/// the middle's by a share of it.
fn depth_shares(share: f64) -> [f64; 2] {
    let far = if share < 1.0 { (1.0 - share).recip().min(1.0 + MOST_DEPTH_SHARE) } else { 1.0 + MOST_DEPTH_SHARE };
    // A NaN, of a plane through the eye, is no bound.
    [(1.0 + share).recip().max(1.0 - MOST_DEPTH_SHARE), far]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ViewVolume;

    fn pictures() -> [Picture; 4] {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::new(0.0, 0.2, -1.0), DVec3::Y, 1.0, 1.5, 0.1, 100.0).unwrap();
        let (plain, parallel) = (camera.volume(), ViewVolume::orthographic(4.0, 1.5, -2.0, 100.0));
        let shift = DVec2::new(0.4, -0.7);
        [plain, plain.shifted(shift), parallel, parallel.shifted(shift)]
            .map(|volume| Picture::new(&camera.with_volume(volume).unwrap(), [30, 20]))
    }

    #[test]
    fn rays_and_places_are_inverse_and_gradients_are_differences() {
        for picture in pictures() {
            let at = DVec2::new(7.25, 3.5);
            let p = picture.at(at, 4.0);
            let ray = picture.camera.pixel_ray(at.x, at.y, picture.size);
            assert!((p - ray.at(4.0)).length() < 1e-12);
            assert!((picture.place(p) - at).length() < 1e-12);
            let (step, h) = (DVec3::new(0.3, -0.2, 0.5), 1e-6);
            let difference = (picture.place(p + step * h) - picture.place(p - step * h)) / (2.0 * h);
            let found = picture.gradients(p).map(|g| g.dot(step));
            assert!((DVec2::from_array(found) - difference).length() < 1e-6, "{found:?} {difference}");
        }
    }

    #[test]
    fn corners_are_on_the_plane_and_half_a_pixel_away_and_within_reach() {
        for picture in pictures() {
            let forward = picture.camera.forward();
            let most = MOST_DEPTH_SHARE * picture.camera.distance_at(3.0);
            for normal in [DVec3::Y, DVec3::new(0.5, 0.7, 0.2).normalize(), DVec3::Z, forward.any_orthonormal_vector()]
            {
                for at in [DVec2::new(5.5, 15.5), DVec2::new(29.5, 19.5)] {
                    let p = picture.at(at, 3.0);
                    let [near, far] = picture.depths(p, normal);
                    let off_plane = normal.dot(picture.camera.way_to(p)).abs();
                    let [all_near, all_far] = picture.depths_within([3.0, 3.0], off_plane);
                    assert!(all_near <= near + 1e-12 && far <= all_far + 1e-12, "{normal} {at}");
                    for (corner, [x, y]) in
                        picture.corners(p, normal).iter().zip([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
                    {
                        assert!((picture.place(*corner) - at - DVec2::new(x, y)).length() < 1e-9);
                        assert!((*corner - p).length() <= picture.reach(p, normal) + 1e-12, "{normal} {at}");
                        let depth = corner.dot(forward);
                        let on_plane = (*corner - p).dot(normal).abs() < 1e-12;
                        assert!((near - 1e-12..=far + 1e-12).contains(&depth), "{normal} {at}: {near} {depth} {far}");
                        assert!(on_plane || (depth - 3.0).abs() > 0.99 * most, "{normal} {at}: {depth}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_neighbour_is_on_the_plane_or_before_it() {
        for picture in pictures() {
            let normal = DVec3::new(0.1, 0.3, 1.0).normalize();
            let (p, off) = (picture.at(DVec2::new(10.5, 10.5), 3.0), picture.camera.distance_at(3.0));
            let [_, corner, ..] = picture.corners(p, normal);
            assert!(picture.is_on_plane((p, normal), corner));
            let before = |share: f64| corner - picture.camera.way_to(corner).normalize() * (share * off);
            assert!(picture.is_on_plane((p, normal), before(0.01)) && !picture.is_on_plane((p, normal), before(0.1)));
        }
    }
}
