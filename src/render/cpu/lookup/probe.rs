//! What a map holds around a receiver, in world units along the light's ray, with and without bias: see `aliasing::causes`.
//!
//! The gap of a texel is exact: the ray through the texel's centre meets the receiver's plane in one point (three linear
//! equations), and the stored depth lies on that ray at a distance that solves a linear equation again, since clip z and w are
//! affine along it.

use glam::{DVec2, DVec3, DVec4};

use super::comparison::Comparison;
use super::lookup::MapLookup;
use super::on_planes::meeting_point;
use crate::aliasing::causes::{Probe, Tap};
use crate::parameterization::PostWarp;
use crate::render::stored::DepthMeasure;
use crate::render::{Stored, Tap as Read};

/// Texels around the point that a probe looks at, each way.
const AROUND: i64 = 1;
/// Twice the half step of the grid of 1/256 of a texel that rasterisers round vertices to, in texels: each way half of it, and
/// the plane of depth goes through what was rounded.
const SNAP: f64 = 1.0 / 256.0;
/// A part of a texel that counts as nothing where rays tell surfaces apart: a quarter of [`SNAP`].
const TOUCH: f64 = SNAP / 4.0;
/// Two units in the last place of single precision near 1: of stored depths, and of positions relative to their size.
const ROUNDING: f64 = 2.0 * (f32::EPSILON as f64);

impl MapLookup {
    /// What the map, rows from the top, holds around a receiver at `p` relative to the origin with a unit normal. Which map it
    /// is, is for the caller to fill in. Of the texels around those that are not read are looked at if asked for.
    pub fn probe(&self, map: &[f32], p: DVec3, normal: DVec3, with_around: bool) -> Probe {
        let nothing = Probe { around: [f64::NEG_INFINITY; 9], ..Probe::default() };
        let Some(ndc) = self.ndc_within(p) else { return nothing };
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        let place = DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * size;
        let (texel, to_light) = (self.texel_size(p, ndc), self.way_to_light(p));
        let facing = normal.dot(to_light).abs();
        let slope = normal.cross(to_light).length() / facing.max(f64::EPSILON);
        let depth = self.depth.at(p.extend(1.0));
        // Depths are rounded to the format.
        let step = ROUNDING.max(self.stored.format.step(depth));
        let rounding = self.way_to_depth(p, to_light, depth - step).abs() + ROUNDING * p.length() * (1.0 + slope);
        let (grain, touch) = (SNAP * texel * (1.0 + slope) + rounding, TOUCH * texel + ROUNDING * p.length());
        let mut probe = Probe { is_held: true, place, texel, slope, grain, touch, ..nothing };
        let centre_of = |[x, y]: [i64; 2]| DVec2::new(x as f64 + 0.5, y as f64 + 0.5);
        let looked_at = |texel: [i64; 2]| {
            let stored = self.stored(map, texel);
            let [gap, step] = self.gap(stored, p, normal, centre_of(texel));
            (stored, gap, step)
        };
        if with_around {
            let middle = place.floor().as_i64vec2();
            for (n, gap) in (0..).zip(&mut probe.around) {
                *gap = looked_at([middle.x - AROUND + n % 3, middle.y - AROUND + n / 3]).1;
            }
        }
        // A bias that moves it past the light or the near plane lights it whatever the map holds.
        let comparison = self.compare_at(p, normal);
        let taps = match &comparison {
            Comparison::At(reference) => self.taps(reference),
            Comparison::Lit => self.taps_at(p, normal, place),
        };
        let tap = |tap: Read| {
            let (centre, (stored, gap, step)) = (centre_of(tap.texel), looked_at(tap.texel));
            let biased = match &comparison {
                Comparison::At(reference) => self.depth_at(reference, centre),
                Comparison::Lit => 0.0,
            };
            let (is_dark, is_dark_unbiased) = (stored < biased, stored < depth.min(1.0));
            Tap { weight: tap.weight, centre, gap, step, is_dark, is_dark_unbiased }
        };
        probe.taps = taps.into_iter().filter(|tap| tap.weight > 0.0).map(tap).collect();
        probe
    }

    /// Where a point, relative to the origin, lies in the map, texels; nothing behind its projection centre.
    pub fn place_of(&self, p: DVec3) -> Option<DVec2> {
        let [row_x, row_y, _, row_w] = self.rows;
        let p4 = p.extend(1.0);
        let w = row_w.dot(p4);
        let ndc = self.post_warp.apply(DVec3::new(row_x.dot(p4), row_y.dot(p4), 0.0) / w, w);
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        (w > 0.0).then_some(DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * size)
    }

    /// Where the ray of a place in the map, texels, meets the plane through `p` with a normal; nothing where the plane is seen
    /// edge on.
    pub fn on_plane_at(&self, p: DVec3, normal: DVec3, place: DVec2) -> Option<DVec3> {
        let [width, height] = self.size.map(f64::from);
        self.on_plane(p, normal, [2.0 * place.x / width - 1.0, 1.0 - 2.0 * place.y / height])
    }

    /// How far from a point towards the light the near plane cuts off; infinity where it is not on the way.
    pub fn way_to_near(&self, p: DVec3) -> f64 {
        let [_, _, row_z, row_w] = self.rows;
        let way = DepthMeasure { numerator: row_z, denominator: row_w }.way(p, self.way_to_light(p), 0.0);
        if way > 0.0 { way } else { f64::INFINITY }
    }

    /// What the map stores.
    pub fn what(&self) -> Stored {
        self.stored
    }

    /// Whether a point is before the far plane, so that a rasteriser draws it.
    pub fn is_before_far(&self, p: DVec3) -> bool {
        let [_, _, row_z, row_w] = self.rows;
        let p4 = p.extend(1.0);
        row_z.dot(p4) < row_w.dot(p4)
    }

    /// The depth that the map would store of a point, before it is rounded.
    pub fn depth_at_point(&self, p: DVec3) -> f64 {
        self.depth.at(p.extend(1.0))
    }

    /// How far along its ray lies what a rasteriser may give the same depth in single precision as a point, world units.
    pub fn same_depth(&self, p: DVec3) -> f64 {
        let [_, _, row_z, row_w] = self.rows;
        let of = DepthMeasure { numerator: row_z, denominator: row_w };
        let way = of.way(p, self.way_to_light(p), of.at(p.extend(1.0)) - ROUNDING);
        (if way.is_finite() { way.abs() } else { 0.0 }) + ROUNDING * p.length()
    }

    /// World size of a texel across the ray at a point, its longer side; 0 where the map is singular.
    pub fn texel_at(&self, p: DVec3) -> f64 {
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        let ndc = |place: DVec2| DVec2::new(2.0, -2.0) * (place / size) + DVec2::new(-1.0, 1.0);
        self.place_of(p).map_or(0.0, |place| self.texel_size(p, ndc(place).extend(0.0)))
    }

    /// Depth without bias of a point that [`MapLookup::compare_at`] compares.
    pub(super) fn depth_of(&self, p: DVec3) -> Option<f64> {
        self.ndc_within(p).map(|_| self.depth.at(p.extend(1.0)))
    }

    /// NDC of a point that the map holds with all that may shade it: before the near plane casters may be missing, beyond the
    /// far plane none is.
    fn ndc_within(&self, p: DVec3) -> Option<DVec3> {
        let [row_x, row_y, row_z, row_w] = self.rows;
        let p4 = p.extend(1.0);
        let w = row_w.dot(p4);
        let ndc = self.post_warp.apply(DVec3::new(row_x.dot(p4), row_y.dot(p4), row_z.dot(p4)) / w, w);
        (w > 0.0 && ndc.z >= 0.0 && ndc.x.abs() <= 1.0 && ndc.y.abs() <= 1.0).then_some(ndc)
    }

    /// To the light: a unit vector; zero at the light.
    pub fn way_to_light(&self, p: DVec3) -> DVec3 {
        (self.light.truncate() - self.light.w * p).normalize_or_zero()
    }

    /// How far along a unit vector depth becomes a stored value; 0 where it never changes.
    pub(super) fn way_to_depth(&self, p: DVec3, along: DVec3, z: f64) -> f64 {
        let way = self.depth.way(p, along, z);
        if way.is_finite() { way } else { 0.0 }
    }

    /// World size of a texel across the ray, its longer side; 0 where the map is singular.
    fn texel_size(&self, p: DVec3, ndc: DVec3) -> f64 {
        let across = self.way_to_light(p);
        let step = |ndc: [f64; 2]| self.on_plane(p, across, ndc).map_or(0.0, |q| (q - p).length());
        let (dx, dy) = (2.0 / f64::from(self.size[0]), 2.0 / f64::from(self.size[1]));
        step([ndc.x + dx, ndc.y]).max(step([ndc.x, ndc.y + dy]))
    }

    /// The point with these NDC x and y on the plane through `p` with a normal.
    fn on_plane(&self, p: DVec3, normal: DVec3, [x, y]: [f64; 2]) -> Option<DVec3> {
        let [row_x, row_y, _, row_w] = self.rows;
        let of = |x: f64, y: f64| (row_x - x * row_w, row_y - y * row_w);
        // Linear in (q, 1): its product is zero.
        let (across, along) = match &self.post_warp {
            PostWarp::None => of(x, y),
            // y = scale ln w + offset is known, so w is.
            PostWarp::Log { scale, offset } => (of(x, y).0, row_w - DVec4::W * ((y - offset) / scale).exp()),
            PostWarp::Rectilinear(warp) => of(warp.x.before(x), warp.y.before(y)),
        };
        let q = meeting_point(across, along, p, normal);
        q.is_finite().then_some(q)
    }

    /// The depth of a texel; beyond the edge that of the nearest one.
    fn stored(&self, map: &[f32], [i, j]: [i64; 2]) -> f64 {
        let [width, height] = self.size.map(i64::from);
        f64::from(map[(j.clamp(0, height - 1) * width + i.clamp(0, width - 1)) as usize])
    }

    /// How far from the receiver's plane towards the light lies what a texel holds, and how far one step of its number goes;
    /// minus infinity for nothing, and where the plane is seen edge on: its depth there is any.
    fn gap(&self, stored: f64, p: DVec3, normal: DVec3, centre: DVec2) -> [f64; 2] {
        match self.on_plane_at(p, normal, centre) {
            Some(q) if stored < 1.0 => {
                let to_light = self.way_to_light(q);
                let gap = self.way_to_depth(q, to_light, stored);
                let next = self.way_to_depth(q, to_light, stored - self.stored.format.step(stored));
                [gap, (next - gap).abs()]
            }
            _ => [f64::NEG_INFINITY, 0.0],
        }
    }
}
