//! What a texel of a shadow map looks like in the image, at one point of one surface.
//!
//! Source: theory.md E.2, (E.5) and (E.6); after Lloyd, Govindaraju, Quammen, Molnar, Manocha 2008 `[lloyd2008]` and
//! Chong, Gortler 2007 `[chong2007]`.
//!
//! ```text
//!         eye                light         J = d(pixel) / d(texel) on the surface's tangent plane
//!           \ e            / d
//!            \            /                 h halves the angle between the ways back to eye and light: on the
//!   pixel  ---\---  n h  /--- texel         plane across h a texel is as long and as wide in the image as its
//!              \    |/  /                   cross-section, so J(h) is the error of perspective alone, and
//!     __________\__/|__/_________
//!                 X  surface                |det J| = |det J(h)| cos(n, -e) / cos(n, -d)
//! ```
//!
//! With g_x, g_y the gradients of the texel's coordinates, a step of one texel along the surface with normal n is
//!
//! ```text
//! dX/dtx = (g_y × n) / (g_x × g_y · n)      dX/dty = (n × g_x) / (g_x × g_y · n)
//! ```
//!
//! and g_x × g_y is parallel to the map's ray through X, whatever the map: the ray is taken from there, so that the product
//! above holds for matrices that belong to another light, too. Rows of a logarithmic map differ in g_y alone (11.1). A
//! rectilinear warp stretches texels' coordinates by f' and g', so it divides the columns of J by these (10.12).
//!
//! One function of plain numbers without branches: called for a point, or in a loop that the compiler turns into vector
//! instructions.

use glam::{DVec2, DVec3, DVec4};

use crate::parameterization::{Partition, PostWarp};
use crate::scene::Camera;

/// An image of a camera: where points of a local space are in it.
#[derive(Debug, Clone, Copy)]
pub struct Eye {
    position: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    /// Pixels per unit of x / w and of y / w; y down. w is the depth before a perspective eye, 1 for parallel rays.
    pixels: [f64; 2],
    /// The middle of the picture, x / w and y / w.
    center: [f64; 2],
    /// 1 and 0 for rays from the eye, 0 and 1 for parallel ones: a loop over points has no branch.
    converging: f64,
    parallel: f64,
}

/// A map with its texels: where points of a local space are in it.
#[derive(Debug, Clone, Copy)]
pub struct TexelMap {
    x: DVec4,
    y: DVec4,
    w: DVec4,
    z: DVec4,
    /// Texels per unit of NDC x and y; y down.
    texels: [f64; 2],
    /// Of a logarithm: 1 and its scale, else 0 and 0.
    log: [f64; 2],
}

/// A texel in the image. Lengths in pixels. Meaningless where `w`, or the depth before a perspective eye, is not above 0.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Texel {
    /// d(pixel x, y) / d(texel x, y): `[xx, xy, yx, yy]`.
    pub jacobian: [f64; 4],
    /// The larger singular value of it: the longest extent of a texel.
    pub major: f64,
    /// The smaller one: the extent across that.
    pub minor: f64,
    /// Lengths of the columns of J(h), of one texel along the map's x and along its y: error of perspective alone.
    pub perspective_ts: [f64; 2],
    /// The determinant of J(h), unsigned: the area of a texel by perspective alone, square pixels.
    pub perspective: f64,
    /// cos(n, -e) / cos(n, -d): projection error.
    pub projection: f64,
    /// NDC in the map before its post-warp.
    pub ndc: [f64; 3],
    /// Clip w in the map.
    pub w: f64,
    /// Camera depth.
    pub depth: f64,
}

impl Eye {
    /// The image of `size` pixels for points relative to `origin`.
    pub fn new(camera: &Camera, origin: DVec3, size: [u32; 2]) -> Self {
        let (half, parallel) = (camera.half_size(), f64::from(camera.is_orthographic()));
        Self {
            position: camera.eye() - origin,
            right: camera.right(),
            up: camera.up(),
            forward: camera.forward(),
            pixels: [0.5 * f64::from(size[0]) / half.x, -0.5 * f64::from(size[1]) / half.y],
            center: camera.volume().center().to_array(),
            converging: 1.0 - parallel,
            parallel,
        }
    }
    /// What places across the view are divided by at a depth.
    #[inline(always)]
    fn w_at(&self, depth: f64) -> f64 {
        self.converging * depth + self.parallel
    }
    /// How far the point that a pixel shows moves on its plane, through `p` with a normal, as the pixel moves by one to the right,
    /// and by one down; not finite where the plane is seen edge on.
    #[inline(always)]
    pub fn pixel_on_plane(&self, p: DVec3, normal: DVec3) -> [DVec3; 2] {
        let from_eye = p - self.position;
        let w = self.w_at(from_eye.dot(self.forward));
        let ray = self.converging * from_eye + self.parallel * self.forward;
        let facing = normal.dot(ray);
        [self.right * (w / self.pixels[0]), self.up * (w / self.pixels[1])]
            .map(|step| step - ray * (normal.dot(step) / facing))
    }
    /// Where a point is in the image, pixels from its middle, y down; nothing where it is not before the eye.
    pub fn pixel_of(&self, p: DVec3) -> Option<DVec2> {
        let from_eye = p - self.position;
        let w = self.w_at(from_eye.dot(self.forward));
        let across = DVec2::new(from_eye.dot(self.right), from_eye.dot(self.up));
        (w > 0.0).then_some((across / w - DVec2::from_array(self.center)) * DVec2::from_array(self.pixels))
    }
}

impl TexelMap {
    /// The texels of a map of `size` texels.
    pub fn new(partition: &Partition, size: [u32; 2]) -> Self {
        let row = |i: usize| partition.shadow_clip_from_world.row(i);
        let log = match partition.post_warp {
            // A rectilinear warp comes after the kernel: [`Texel::stretched`].
            PostWarp::None | PostWarp::Rectilinear(_) => [0.0, 0.0],
            PostWarp::Log { scale, .. } => [1.0, scale],
        };
        let texels = [0.5 * f64::from(size[0]), -0.5 * f64::from(size[1])];
        Self { x: row(0), y: row(1), z: row(2), w: row(3), texels, log }
    }
}

impl Texel {
    /// The same in a map that is stretched along x and y by these factors, after which a texel covers less.
    pub fn stretched(&self, factors: DVec2) -> Self {
        let [a, b, c, d] = self.jacobian;
        let [x, y] = factors.to_array();
        let jacobian = [a / x, b / y, c / x, d / y];
        let (major, area) = (largest_singular_value(jacobian), self.major * self.minor / (x * y));
        Self {
            jacobian,
            major,
            minor: area / major,
            perspective_ts: [self.perspective_ts[0] / x, self.perspective_ts[1] / y],
            perspective: self.perspective / (x * y),
            ..*self
        }
    }
    /// Whether it has a size.
    pub fn is_finite(&self) -> bool {
        let numbers = [
            self.major,
            self.minor,
            self.projection,
            self.perspective,
            self.perspective_ts[0],
            self.perspective_ts[1],
            self.depth,
        ];
        numbers.iter().chain(&self.jacobian).all(|x| x.is_finite())
    }
}

/// The texel of a map, but for a rectilinear warp of it, at a point `p` of a surface with normal `n` (of any length), both in the space of map and eye.
#[inline(always)]
pub fn texel_in_image(map: &TexelMap, eye: &Eye, p: DVec3, n: DVec3) -> Texel {
    let row = |r: DVec4| r.x * p.x + r.y * p.y + r.z * p.z + r.w;
    let w = row(map.w);
    let inverse = 1.0 / w;
    let ndc = [row(map.x) * inverse, row(map.y) * inverse, row(map.z) * inverse];
    // Gradients of the texel's coordinates (E.5); of y = scale ln w under a logarithm (11.1).
    let gradient = |r: DVec4, value: f64, own: f64| {
        DVec3::new(own * r.x - value * map.w.x, own * r.y - value * map.w.y, own * r.z - value * map.w.z)
    };
    let g_x = gradient(map.x, ndc[0], 1.0) * (map.texels[0] * inverse);
    let (own, value) = (1.0 - map.log[0], (1.0 - map.log[0]) * ndc[1] - map.log[1]);
    let g_y = gradient(map.y, value, own) * (map.texels[1] * inverse);
    let ray = g_x.cross(g_y);

    // The pixel's coordinates, and their gradients up to the factor of the depth; of parallel rays it has no part in them.
    let from_eye = p - eye.position;
    let depth = from_eye.dot(eye.forward);
    let per_w = 1.0 / eye.w_at(depth);
    let turning = per_w * eye.converging;
    let (across, above) = (from_eye.dot(eye.right) * turning, from_eye.dot(eye.up) * turning);
    let scale = [eye.pixels[0] * per_w, eye.pixels[1] * per_w];
    let to_pixels = |step: DVec3| {
        let ahead = step.dot(eye.forward);
        [(step.dot(eye.right) - across * ahead) * scale[0], (step.dot(eye.up) - above * ahead) * scale[1]]
    };
    let columns = |n: DVec3, inverse: f64| {
        let (x, y) = (to_pixels(g_y.cross(n)), to_pixels(n.cross(g_x)));
        [[x[0] * inverse, x[1] * inverse], [y[0] * inverse, y[1] * inverse]]
    };
    let length = |[x, y]: [f64; 2]| (x * x + y * y).sqrt();

    // Unit ways from the eye and from the light; the light is on the side of the normal. Few divisions: they are half of the
    // work of the loop.
    let way = from_eye * eye.converging + eye.forward * eye.parallel;
    let (distance, ray_length) = (way.length(), ray.length());
    let (per_distance, per_ray) = (1.0 / distance, 1.0 / ray_length);
    let e = way * per_distance;
    let (facing, per_facing) = (ray.dot(n), 1.0 / ray.dot(n));
    let d = ray * (per_ray * -f64::copysign(1.0, facing));
    // R(h) of (E.6).
    // The plane across h reflects what lies across the light to what lies across the eye: w - b 2 (b·w) / (b·b) with b = e + d.
    // The reflection keeps lengths however few digits of b are left where light runs against the view; there it is none.
    let back = e + d;
    let squared = back.length_squared();
    let twice = if squared > f64::EPSILON { 2.0 / squared } else { 0.0 };
    let reflected = |step: DVec3| step - back * (twice * back.dot(step));
    let across = |step: DVec3| {
        let [x, y] = to_pixels(reflected(step));
        length([x, y]) * per_ray
    };
    let perspective_ts = [across(g_y.cross(d)), across(d.cross(g_x))];

    // The cross product of the pixel's gradients is along e, that of the texel's along d: areas come without the differences
    // of a determinant, and the smaller singular value keeps its digits however long a texel is.
    let perspective = (scale[0] * scale[1] * (distance * per_w) * per_ray).abs();
    let projection = (e.dot(n) * ray_length * per_facing).abs();
    let [[a, c], [b, d]] = columns(n, per_facing);
    let on_surface = [a, b, c, d];
    let major = largest_singular_value(on_surface);
    Texel {
        jacobian: on_surface,
        major,
        minor: perspective * projection / major,
        perspective_ts,
        perspective,
        projection,
        ndc,
        w,
        depth,
    }
}

/// The texel of a map with its post-warp, at a point as of [`texel_in_image`].
pub fn warped_texel(map: &TexelMap, post_warp: &PostWarp, eye: &Eye, p: DVec3, n: DVec3) -> Texel {
    let texel = texel_in_image(map, eye, p, n);
    match post_warp.rectilinear() {
        Some(warp) => texel.stretched(warp.slopes(DVec2::new(texel.ndc[0], texel.ndc[1]))),
        None => texel,
    }
}

/// The larger singular value of `[a, b, c, d]`, rows first.
#[inline(always)]
pub fn largest_singular_value([a, b, c, d]: [f64; 4]) -> f64 {
    let sum = ((a + d) * (a + d) + (b - c) * (b - c)).sqrt();
    let difference = ((a - d) * (a - d) + (b + c) * (b + c)).sqrt();
    0.5 * (sum + difference)
}
