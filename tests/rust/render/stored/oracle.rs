//! Maps of all kinds, and what they should store, by search: nothing here inverts a matrix or knows a formula of depth.

use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3, DVec4};
use shadowlab::geometry::Rows;
use shadowlab::parameterization::{Partition, PiecewiseLinear, PostWarp, Rectilinear};
use shadowlab::render::{Spacing, Stored, StoredSurface};
use shadowlab::scene::{DirectionalLight, SpotLight};
use shadowlab::{Light, Parameterization};

use crate::support::cpu::one_map;

/// A map and its light.
pub struct Case {
    pub name: &'static str,
    pub p: Parameterization,
    pub light: Light,
}

/// Perspective over a map: w from 1/2 to 2; depth halved, so that what was in the map stays before its far plane.
pub fn warp() -> DMat4 {
    DMat4::from_cols_array(&[1., 0., 0., 0., 0., 1.25, 0., 0.75, 0., 0., 0.5, 0., 0., 0.75, 0., 1.25])
}

/// The same of a spot's map with planes at so many units: depth is spaced by w, so that it ends at finite points.
pub fn warped_spot(spot: DMat4, [near, far]: [f64; 2]) -> DMat4 {
    let mut rows = Rows::of(&(warp() * spot));
    let (near, far) = (0.5 * near, 2.0 * far);
    rows.z = (rows.w - DVec4::W * near) * (far / (far - near));
    rows.matrix()
}

/// The square of half side `radius` about the origin, seen along a direction; depth 8 radii.
pub fn ortho(direction: DVec3, radius: f64) -> DMat4 {
    let view = glam::dcamera::rh::view::look_to_mat4(-4.0 * radius * direction, direction, DVec3::new(0.2, 0.1, 1.0));
    glam::dcamera::rh::proj::directx::orthographic(-radius, radius, -radius, radius, 0.0, 8.0 * radius) * view
}

fn partition(p: Parameterization, post_warp: PostWarp) -> Parameterization {
    let mut p = p;
    p.partitions[0].post_warp = post_warp;
    p
}

pub fn rectilinear() -> PostWarp {
    let knots = |k: [f64; 2]| PiecewiseLinear::new(&[[-1.0, -1.0], k, [1.0, 1.0]]).unwrap();
    PostWarp::Rectilinear(Arc::new(Rectilinear { x: knots([0.1, -0.3]), y: knots([-0.2, 0.25]) }))
}

pub fn logarithm() -> PostWarp {
    PostWarp::Log { scale: 1.0 / 2.0_f64.ln(), offset: 0.0 }
}

/// Maps of a directional and of a spot light: even, warped, behind both post-warps.
pub fn cases() -> Vec<Case> {
    let direction = DVec3::new(0.4, -1.0, 0.3).normalize();
    let sun = || Light::Directional(DirectionalLight::new(direction).unwrap());
    let eye = DVec3::new(0.7, 6.0, -0.5);
    let lamp = || Light::Spot(SpotLight::new(eye, -eye, 1.3, 50.0).unwrap());
    let view = glam::dcamera::rh::view::look_to_mat4(eye, -eye.normalize(), DVec3::X);
    let spot = glam::dcamera::rh::proj::directx::perspective(1.0, 1.0, 2.0, 9.0) * view;
    let even = ortho(direction, 3.0);
    vec![
        Case { name: "uniform", p: one_map(even), light: sun() },
        Case { name: "warped", p: one_map(warp() * even), light: sun() },
        Case { name: "log", p: partition(one_map(warp() * even), logarithm()), light: sun() },
        Case { name: "rectilinear", p: partition(one_map(warp() * even), rectilinear()), light: sun() },
        Case { name: "spot", p: one_map(spot), light: lamp() },
        Case { name: "warped spot", p: one_map(warped_spot(spot, [2.0, 9.0])), light: lamp() },
        Case { name: "rectilinear spot", p: partition(one_map(spot), rectilinear()), light: lamp() },
        Case {
            name: "mirrored",
            p: one_map(DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0)) * warp() * even),
            light: sun(),
        },
    ]
}

/// The point that a map puts at an NDC, by Newton's method with differences.
pub fn unprojected(map: &Partition, ndc: DVec3) -> DVec3 {
    let mut p = DVec3::new(0.01, 0.02, 0.03);
    for _ in 0..200 {
        let (at, w) = map.project(p);
        assert!(w > 0.0, "behind the map at {p}");
        let h = 1e-6;
        let column = |d: DVec3| (map.project(p + h * d).0 - map.project(p - h * d).0) / (2.0 * h);
        let jacobian = DMat3::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z));
        let step = jacobian.inverse() * (ndc - at);
        // Held within the map's scale: far steps of a perspective may leave it.
        let step = step.clamp_length_max(1.0);
        p += step;
        if step.length() < 1e-13 {
            break;
        }
    }
    let (at, _) = map.project(p);
    assert!((at - ndc).length() < 1e-9, "{ndc}: found {at} at {p}");
    p
}

/// NDC x and y of a texel's centre, or of a place beside it.
pub fn texel_ndc([x, y]: [f64; 2], size: u32) -> [f64; 2] {
    let n = f64::from(size);
    [(2.0 * x + 1.0) / n - 1.0, 1.0 - (2.0 * y + 1.0) / n]
}

/// A light ray of a map: a point before everything, and the way of the light.
pub fn ray(map: &Partition, [x, y]: [f64; 2]) -> (DVec3, DVec3) {
    let (near, far) = (unprojected(map, DVec3::new(x, y, 0.05)), unprojected(map, DVec3::new(x, y, 0.6)));
    (near, (far - near).normalize())
}

/// Where a ray meets triangles: distances and whether their outer side is averted, ascending, one for each place.
pub fn hits(triangles: &[[DVec3; 3]], (origin, way): (DVec3, DVec3)) -> Vec<(f64, bool)> {
    let mut found: Vec<(f64, bool)> = vec![];
    for [a, b, c] in triangles {
        let normal = (b - a).cross(c - a);
        let t = (a - origin).dot(normal) / way.dot(normal);
        let q = origin + t * way;
        let inside = [(a, b), (b, c), (c, a)].iter().all(|(p, n)| (*n - *p).cross(q - **p).dot(normal) >= -1e-12);
        if inside && found.iter().all(|(other, _)| (other - t).abs() > 1e-9) {
            found.push((t, way.dot(normal) > 0.0));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

/// What a map measures at points.
pub struct Measure<'a> {
    map: &'a Partition,
    along: DVec3,
    range: [f64; 2],
    spacing: Spacing,
}

impl<'a> Measure<'a> {
    pub fn new(map: &'a Partition, spacing: Spacing) -> Self {
        let (_, along) = ray(map, [0.0, 0.0]);
        let mut range = [f64::INFINITY, f64::NEG_INFINITY];
        for corner in 0..8 {
            let side = |bit: i32| f64::from(corner >> bit & 1);
            let p = unprojected(map, DVec3::new(2.0 * side(0) - 1.0, 2.0 * side(1) - 1.0, side(2)));
            range = [range[0].min(along.dot(p)), range[1].max(along.dot(p))];
        }
        Self { map, along, range, spacing }
    }
    pub fn at(&self, p: DVec3) -> f64 {
        match self.spacing {
            Spacing::Projective => self.map.project(p).0.z,
            Spacing::Linear => (self.along.dot(p) - self.range[0]) / (self.range[1] - self.range[0]),
        }
    }
}

/// World size of a texel across a ray at a point of it.
fn texel_size(map: &Partition, p: DVec3, way: DVec3, size: u32) -> f64 {
    let n = f64::from(size);
    let (u, v) = way.any_orthonormal_pair();
    let h = 1e-6;
    let column = |d: DVec3| (map.project(p + h * d).0 - map.project(p - h * d).0).truncate() * (n / (4.0 * h));
    let inverse = glam::DMat2::from_cols(column(u), column(v)).inverse();
    inverse.x_axis.length().max(inverse.y_axis.length())
}

/// What a texel should store before rounding, of the hits of its ray.
pub fn expected(measure: &Measure, ray: (DVec3, DVec3), hits: &[(f64, bool)], stored: Stored, size: u32) -> f64 {
    let at = |t: f64| measure.at(ray.0 + t * ray.1);
    let first = hits.first().map(|hit| hit.0);
    let second = hits.get(1).map(|hit| hit.0);
    match (stored.surface, first, second) {
        (StoredSurface::Back, ..) => hits.iter().find(|hit| hit.1).map_or(1.0, |hit| at(hit.0)),
        (_, None, _) => 1.0,
        (StoredSurface::Front, Some(a), _) => at(a),
        (StoredSurface::Second, _, b) => b.map_or(1.0, at),
        (StoredSurface::Midpoint, Some(a), b) => b.map_or(1.0, |b| at(0.5 * (a + b))),
        (StoredSurface::Dual, Some(a), b) => {
            let most = stored.limit * texel_size(measure.map, ray.0 + a * ray.1, ray.1, size);
            at(a + b.map_or(most, |b| most.min(0.5 * (b - a)))).min(1.0)
        }
    }
}
