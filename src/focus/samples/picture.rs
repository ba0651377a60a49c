//! The picture that samples come from: what a pixel spans on the plane of the surface that it shows.
//!
//! Source: theory.md 10.2 (hulls are completed to the corners of the samples' pixels) and (E.5). Everything is relative to the
//! eye.
//!
//! ```text
//!     eye x ----.----.      the corners of a pixel on the plane of its surface;
//!            \   `--. `-.   along a grazing plane no farther than a share of
//!             \______`--_`_ the depth, for nothing says that it goes on
//! ```

use glam::{DVec2, DVec3};

use crate::scene::Camera;

/// A point lies on the plane of another one where the depth that the plane foretells of it is right to this share. Chosen
/// because neighbours on curved surfaces in pictures of 128 pixels a side stay below it, and casters off a wall above.
const SAME_SURFACE: f64 = 0.05;

/// A corner of a pixel lies at most this share of the sample's depth nearer or farther than the sample. Chosen because a few
/// far corners cost a map half of its texels, while neighbours of a pixel are rarely farther apart in depth.
const MOST_DEPTH_SHARE: f64 = 0.25;

/// Rays through the pixels of a picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Picture {
    /// Its camera.
    pub camera: Camera,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Ray at the top left corner of the picture, of depth 1, and its change over one pixel to the right and one down.
    corner: DVec3,
    per_x: DVec3,
    per_y: DVec3,
    /// Pixels per unit of x / depth and of y / depth; y down.
    pixels: DVec2,
    /// Half of a pixel's two sides together, and the longest ray of all, at depth 1.
    half_pixel: f64,
    longest_ray: f64,
}

impl Picture {
    /// The picture of `size` pixels.
    pub fn new(camera: &Camera, size: [u32; 2]) -> Self {
        let (tan_x, tan_y) = camera.tan_half_fov();
        let (right, up) = (camera.right() * tan_x, camera.up() * tan_y);
        let (per_x, per_y) = (right * (2.0 / f64::from(size[0])), up * (-2.0 / f64::from(size[1])));
        Self {
            camera: *camera,
            size,
            corner: camera.forward() - right + up,
            per_x,
            per_y,
            half_pixel: 0.5 * (per_x.length() + per_y.length()),
            longest_ray: (1.0 + tan_x * tan_x + tan_y * tan_y).sqrt(),
            pixels: DVec2::new(0.5 * f64::from(size[0]) / tan_x, -0.5 * f64::from(size[1]) / tan_y),
        }
    }
    /// The ray of depth 1 through a place of the picture, pixels from its top left corner.
    pub fn ray(&self, at: DVec2) -> DVec3 {
        self.corner + self.per_x * at.x + self.per_y * at.y
    }
    /// Where a point is seen, pixels from the top left corner.
    pub fn place(&self, p: DVec3) -> DVec2 {
        let across = DVec2::new(p.dot(self.camera.right()), p.dot(self.camera.up())) / p.dot(self.camera.forward());
        across * self.pixels + 0.5 * DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]))
    }
    /// The pixel at a place of the picture, column and row; nothing outside.
    pub fn pixel(&self, at: DVec2) -> Option<[usize; 2]> {
        let inside = at.cmpge(DVec2::ZERO).all() && at.x < f64::from(self.size[0]) && at.y < f64::from(self.size[1]);
        inside.then_some([at.x as usize, at.y as usize])
    }
    /// Whether a point lies on the plane through `p` with normal `n`, as far as its depth says; all relative to the eye.
    pub fn is_on_plane(&self, (p, n): (DVec3, DVec3), q: DVec3) -> bool {
        let depth = self.camera.forward().dot(q);
        let share = n.dot(p) / n.dot(q / depth) / depth;
        (share - 1.0).abs() <= SAME_SURFACE
    }
    /// Gradients of [`Picture::place`].
    pub fn gradients(&self, p: DVec3) -> [DVec3; 2] {
        let (right, up, forward) = (self.camera.right(), self.camera.up(), self.camera.forward());
        let per_depth = p.dot(forward).recip();
        let across = |axis: DVec3| (axis - forward * (p.dot(axis) * per_depth)) * per_depth;
        [across(right) * self.pixels.x, across(up) * self.pixels.y]
    }
    /// The point on a ray of depth 1 of the plane through `p` with this normal, within the share of its depth.
    #[inline(always)]
    pub fn on_plane(&self, p: DVec3, normal: DVec3, ray: DVec3) -> DVec3 {
        let depth = p.dot(self.camera.forward());
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
        let center = p / p.dot(self.camera.forward());
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
        depth_shares(aside * depth / normal.dot(p).abs()).map(|share| share * depth)
    }
    /// Shares of their depth at which those corners are, of samples no farther than a depth whose planes are no nearer to the eye
    /// than a distance.
    pub fn depth_shares_within(&self, depth: f64, off_plane: f64) -> [f64; 2] {
        depth_shares(self.half_pixel * depth / off_plane)
    }
    /// How far the corners of a sample's pixel lie from it at the most.
    #[inline(always)]
    pub fn reach(&self, p: DVec3, normal: DVec3) -> f64 {
        self.reach_within(p.dot(self.camera.forward()), normal.dot(p).abs())
    }
    /// The same of samples no farther than a depth, whose planes are no nearer to the eye than a distance.
    #[inline(always)]
    pub fn reach_within(&self, depth: f64, off_plane: f64) -> f64 {
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

    fn picture() -> Picture {
        let camera = Camera::look_at(DVec3::ZERO, DVec3::new(0.0, 0.2, -1.0), DVec3::Y, 1.0, 1.5, 0.1, 100.0);
        Picture::new(&camera.unwrap(), [30, 20])
    }

    #[test]
    fn rays_and_places_are_inverse_and_gradients_are_differences() {
        let picture = picture();
        let at = DVec2::new(7.25, 3.5);
        let p = picture.ray(at) * 4.0;
        assert!((picture.place(p) - at).length() < 1e-12);
        let (step, h) = (DVec3::new(0.3, -0.2, 0.5), 1e-6);
        let difference = (picture.place(p + step * h) - picture.place(p - step * h)) / (2.0 * h);
        let found = picture.gradients(p).map(|g| g.dot(step));
        assert!((DVec2::from_array(found) - difference).length() < 1e-6, "{found:?} {difference}");
    }

    #[test]
    fn corners_are_on_the_plane_and_half_a_pixel_away_and_within_reach() {
        let picture = picture();
        for normal in [DVec3::Y, DVec3::new(0.5, 0.7, 0.2).normalize(), DVec3::Z] {
            for at in [DVec2::new(5.5, 15.5), DVec2::new(29.5, 19.5)] {
                let p = picture.ray(at) * 3.0;
                for (corner, x, y) in picture
                    .corners(p, normal)
                    .iter()
                    .zip([-0.5, 0.5, 0.5, -0.5])
                    .zip([-0.5, -0.5, 0.5, 0.5])
                    .map(|((c, x), y)| (c, x, y))
                {
                    assert!((picture.place(*corner) - at - DVec2::new(x, y)).length() < 1e-9);
                    assert!((*corner - p).length() <= picture.reach(p, normal), "{normal} {at}");
                    let depth = corner.dot(picture.camera.forward()) / 3.0;
                    let on_plane = (*corner - p).dot(normal).abs() < 1e-12;
                    let [near, far] = picture.depths(p, normal).map(|depth| depth / 3.0);
                    assert!((near - 1e-12..=far + 1e-12).contains(&depth), "{normal} {at}: {near} {depth} {far}");
                    assert!(on_plane || (depth - 1.0).abs() > 0.249, "{normal} {at}: {depth}");
                }
            }
        }
    }
}
