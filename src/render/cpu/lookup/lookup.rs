//! The shadow lookup of one receiver: where it lies in a map, and which depth is compared there.
//!
//! Source: theory.md 0 (light rays, texture coordinates), 13 (constant world bias, receiver-plane bias), 14 (comparisons are
//! averaged, never depths). The WGSL twin follows [`MapLookup::compare_at`] and [`MapLookup::light`] step by step; what is
//! f64 here may be f32 there, because the matrix is folded with the scene's origin before it is rounded.
//!
//! Spaces: *relative* is world minus the scene's origin (what a G-buffer stores). *texel* is the map in texels, x to the
//! right, y down, texel (i, j) covering [i, i+1) x [j, j+1).

use glam::{DMat4, DVec2, DVec3, DVec4};

use crate::error::{Error, Result};
use crate::parameterization::{Held, Parameterization, Partition, PostWarp, Region};
use crate::render::{Bias, Filter, MaskSettings};
use crate::scene::Light;

/// What a lookup needs to know of one map, its light and its settings.
#[derive(Debug, Clone)]
pub struct MapLookup {
    /// Rows x, y, z, w of `shadow_clip_from_relative`.
    pub(super) rows: [DVec4; 4],
    /// Width and height of the map, texels.
    pub(super) size: [u32; 2],
    /// The light's centre in relative space: (unit vector to the light, 0) or (position, 1).
    pub(super) light: DVec4,
    bias: Bias,
    pub(super) filter: Filter,
    pub(super) post_warp: PostWarp,
    /// Of a logarithm, how much depth falls over the filter's reach along y, in units of what its slope there says: where it
    /// rises with w, and where it falls.
    bend: [f64; 2],
    /// In relative space.
    region: Region,
}

/// The lookups into all maps of a parameterization, and which of them serves a receiver.
#[derive(Debug, Clone)]
pub struct Lookups<'a> {
    p: &'a Parameterization,
    maps: Vec<MapLookup>,
}

/// How a receiver is to be compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Comparison {
    /// Lit without a look at the map: outside of it, behind its projection centre, or nearer than its near plane.
    Lit,
    /// Lit where the stored depth is at least [`MapLookup::depth_at`] of the texel.
    At(Reference),
}

/// A receiver that is compared with texels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reference {
    /// Where in the map.
    pub p_texel: DVec2,
    /// Biased NDC depth, but for the part that each texel has of its own.
    pub z: f64,
    /// The receiver, relative to the origin, moved along its normal; and that.
    p: DVec3,
    normal: DVec3,
    /// NDC depth without bias.
    unbiased: f64,
    /// What depth on the receiver's plane changes by with each texel, and how much it may.
    per_texel: DVec2,
    limit: f64,
}

/// A receiver in a map, with how what it is there changes about it.
#[derive(Debug, Clone, Copy)]
struct Projected {
    p_texel: DVec2,
    /// Before the post-warp.
    plain: DVec3,
    ndc: DVec3,
    /// Gradients in world space: of the texel coordinates X and Y (down), and of NDC z.
    grad_x: DVec3,
    grad_y: DVec3,
    grad_z: DVec3,
    /// The cross product of the first two.
    cross: DVec3,
    /// Its part along the ray.
    det_ray: f64,
    /// To the light: a unit vector, whether the light is placed or at infinity.
    to_light: DVec3,
    /// World size of a texel across the ray, its longer side.
    texel: f64,
}

impl MapLookup {
    /// The lookup into the map of `partition`, `size` texels wide and high, for receivers relative to `origin`.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a matrix that is not finite, or an unusable bias.
    pub fn new(
        partition: &Partition,
        light: &Light,
        origin: DVec3,
        size: [u32; 2],
        bias: Bias,
        filter: Filter,
    ) -> Result<Self> {
        let clip_from_relative = partition.shadow_clip_from_world * DMat4::from_translation(origin);
        if !clip_from_relative.is_finite() {
            let fix = "check where the matrix comes from";
            return Err(Error::argument("shadow_clip_from_world", "16 finite numbers", "a NaN or an infinity", fix));
        }
        let point = light.point();
        let light = DVec4::from((point.truncate() - point.w * origin, point.w));
        let rows = std::array::from_fn(|i| clip_from_relative.row(i));
        let (post_warp, region) = (partition.post_warp.clone(), partition.region.relative_to(origin));
        let bend = bend(&post_warp, filter.reach_texels() * 2.0 / f64::from(size[1]));
        Ok(Self { rows, size, light, bias: bias.checked()?, filter, post_warp, bend, region })
    }

    /// How the map holds a receiver, `p` relative to the origin.
    pub fn holds(&self, p: DVec3) -> Held {
        if !self.region.contains(p) {
            return Held::Outside;
        }
        let p4 = p.extend(1.0);
        let [x, y, z, w] = self.rows.map(|row| row.dot(p4));
        Held::of(self.post_warp.apply(DVec3::new(x, y, z) / w, w), w)
    }

    /// The receiver in the map; nothing outside of it, and before its near plane.
    #[inline(always)]
    fn projected(&self, p: DVec3) -> Option<Projected> {
        let [row_x, row_y, row_z, row_w] = self.rows;
        let p4 = p.extend(1.0);
        let w = row_w.dot(p4);
        // Written so that a NaN (of a matrix at the limits of f64) counts as outside.
        if !(w > 0.0) {
            return None;
        }
        let plain = DVec3::new(row_x.dot(p4), row_y.dot(p4), row_z.dot(p4)) / w;
        let ndc = self.post_warp.apply(plain, w);
        let (u, v) = (0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y);
        if !(ndc.z >= 0.0 && (0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v)) {
            return None;
        }
        let size = DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
        // (E.5), quotient rule.
        let gradient = |row: DVec4, value: f64| (row.truncate() - value * row_w.truncate()) / w;
        let (mut grad_x, mut grad_y) = (gradient(row_x, plain.x), gradient(row_y, plain.y));
        match &self.post_warp {
            PostWarp::None => {}
            PostWarp::Log { scale, .. } => grad_y = row_w.truncate() * (scale / w),
            PostWarp::Rectilinear(warp) => {
                let slopes = warp.slopes(plain.truncate());
                (grad_x, grad_y) = (grad_x * slopes.x, grad_y * slopes.y);
            }
        }
        let (grad_x, grad_y) = (grad_x * (0.5 * size.x), grad_y * (-0.5 * size.y));
        let (cross, to_light) = (grad_x.cross(grad_y), self.way_to_light(p));
        // A texel seen along the ray is a parallelogram whose sides are the columns of the inverse of [grad_x; grad_y] across
        // the ray; their lengths are |grad_y|/|det| and |grad_x|/|det|.
        let longer = grad_x.cross(to_light).length().max(grad_y.cross(to_light).length());
        let det_ray = cross.dot(to_light).abs();
        // det = 0 means that the matrix does not belong to this light; a texel then has no size to speak of.
        let texel = if det_ray > 0.0 { longer / det_ray } else { 0.0 };
        let (p_texel, grad_z) = (DVec2::new(u, v) * size, gradient(row_z, ndc.z));
        Some(Projected { p_texel, plain, ndc, grad_x, grad_y, grad_z, cross, det_ray, to_light, texel })
    }

    /// Where and with which depth a receiver is compared, `p` relative to the origin, `normal` its unit normal.
    ///
    /// All derivatives are taken at the receiver itself; the world part of the bias moves it along its light ray, which
    /// leaves its place in the map alone (0.1), so only z and w are evaluated again.
    pub fn compare_at(&self, p: DVec3, normal: DVec3) -> Comparison {
        let Some(mut at) = self.projected(p) else { return Comparison::Lit };
        let mut p = p;
        if self.bias.normal != 0.0 {
            p += self.bias.normal * at.texel * normal;
            let Some(moved) = self.projected(p) else { return Comparison::Lit };
            at = moved;
        }
        let [_, _, row_z, row_w] = self.rows;

        // Part 1: along the ray (13.1).
        let shift = self.bias.world + self.bias.texels * at.texel;
        let p4_moved = (p + shift * at.to_light).extend(1.0);
        let w_moved = row_w.dot(p4_moved);
        // Moved past the light, or past the plane through it: nothing can be in between.
        if !(w_moved > 0.0) {
            return Comparison::Lit;
        }
        let mut z = row_z.dot(p4_moved) / w_moved - self.bias.ndc;

        // Part 2: what the receiver's own plane gains over the filter's reach (13.2). On the plane,
        // grad_z = a grad_x + b grad_y + c normal, so a = dz/dX and b = dz/dY are quotients of triple products.
        let (mut per_texel, mut limit) = (DVec2::ZERO, f64::INFINITY);
        if self.bias.slope > 0.0 || self.bias.plane > 0.0 {
            let facing = at.cross.dot(normal);
            let [a_det, b_det] = [at.grad_z.dot(at.grad_y.cross(normal)), -at.grad_z.dot(at.grad_x.cross(normal))];
            // On the plane, depth changes by these per texel, times det; Y grows down.
            let bends = self.bends(at.plain.truncate(), [a_det * facing > 0.0, b_det * facing < 0.0]);
            let reach = self.bias.slope * self.filter.reach_texels();
            if self.bias.slope_limit.is_finite() {
                // What a surface straight across the ray gains, by the change of w alone, carries nothing along the ray.
                let a_across = at.grad_z.dot(at.grad_y.cross(at.to_light)).abs() * bends.largest.x;
                let b_across = at.grad_z.dot(at.grad_x.cross(at.to_light)).abs() * bends.largest.y;
                let across = if at.det_ray > 0.0 { (a_across + b_across) / at.det_ray } else { 0.0 };
                limit = self.bias.slope_limit * at.texel * at.grad_z.dot(at.to_light).abs() + reach * across;
            }
            // A plane seen edge on (det = 0) has no finite slope in the map: the limit alone holds it.
            let is_edge_on = facing == 0.0;
            if self.bias.slope > 0.0 {
                let gain = (a_det.abs() * bends.falling.x + b_det.abs() * bends.falling.y) / facing.abs();
                z -= (reach * if is_edge_on { f64::INFINITY } else { gain }).min(limit);
            }
            if !is_edge_on {
                per_texel = DVec2::new(a_det, b_det) / facing;
            }
        }
        let (p_texel, unbiased) = (at.p_texel, at.ndc.z);
        Comparison::At(Reference { p_texel, z, p, normal, unbiased, per_texel, limit })
    }

    /// The depth that the texel with this centre is compared with, in [0, 1].
    ///
    /// Beyond the far plane casters are all nearer, and an empty texel stores 1. No bias takes a receiver out of the map's depth:
    /// nearer than the near plane is what lies there itself.
    #[inline(always)]
    pub fn depth_at(&self, reference: &Reference, centre: DVec2) -> f64 {
        if self.bias.plane == 0.0 {
            return reference.z.clamp(0.0, 1.0);
        }
        let change = match &self.post_warp {
            // NDC depth is affine on the plane.
            PostWarp::None => reference.per_texel.dot(centre - reference.p_texel),
            _ => self.change_on_plane(reference, centre),
        };
        (reference.z + self.bias.plane * change.clamp(-reference.limit, reference.limit)).clamp(0.0, 1.0)
    }

    /// How much farther the receiver's plane is at another place of the map; 0 where it is seen edge on.
    fn change_on_plane(&self, reference: &Reference, place: DVec2) -> f64 {
        let [_, _, row_z, row_w] = self.rows;
        let Some(q) = self.on_plane_at(reference.p, reference.normal, place) else { return 0.0 };
        let z = row_z.dot(q.extend(1.0)) / row_w.dot(q.extend(1.0));
        if z.is_finite() { z - reference.unbiased } else { 0.0 }
    }

    /// The share of light, 0 to 1, that arrives at a receiver which faces the light and is within its reach; `map` has
    /// rows from the top.
    pub fn light(&self, map: &[f32], p: DVec3, normal: DVec3) -> f32 {
        let Comparison::At(reference) = self.compare_at(p, normal) else { return 1.0 };
        let p_texel = reference.p_texel;
        let [width, height] = self.size;
        // Clamp to edge. Casts saturate.
        let lit = |i: i64, j: i64| -> f64 {
            // Of a texel beyond the edge, the plane where it would be.
            let z = self.depth_at(&reference, DVec2::new(i as f64 + 0.5, j as f64 + 0.5));
            let i = i.clamp(0, i64::from(width) - 1) as usize;
            let j = j.clamp(0, i64::from(height) - 1) as usize;
            f64::from(u8::from(f64::from(map[j * width as usize + i]) >= z))
        };
        match self.filter {
            Filter::Nearest => lit(p_texel.x.floor() as i64, p_texel.y.floor() as i64) as f32,
            Filter::Pcf2x2 => {
                // Weights between the four texel centres around the point.
                let corner = (p_texel - 0.5).floor();
                let f = p_texel - 0.5 - corner;
                let (i, j) = (corner.x as i64, corner.y as i64);
                let top = (1.0 - f.x) * lit(i, j) + f.x * lit(i + 1, j);
                let bottom = (1.0 - f.x) * lit(i, j + 1) + f.x * lit(i + 1, j + 1);
                ((1.0 - f.y) * top + f.y * bottom) as f32
            }
        }
    }
}

impl<'a> Lookups<'a> {
    /// The lookups of receivers relative to `origin`.
    ///
    /// # Errors
    /// As [`MapLookup::new`].
    pub fn new(p: &'a Parameterization, light: &Light, origin: DVec3, settings: &MaskSettings) -> Result<Self> {
        let MaskSettings { resolution, bias, filter, .. } = *settings;
        let one = |partition| MapLookup::new(partition, light, origin, resolution, bias, filter);
        Ok(Self { p, maps: p.partitions.iter().map(one).collect::<Result<_>>()? })
    }
    /// How many maps there are.
    pub fn count(&self) -> usize {
        self.maps.len()
    }
    /// Texels of one map.
    pub fn texels(&self) -> usize {
        self.maps.first().map_or(0, |m| m.size[0] as usize * m.size[1] as usize)
    }
    /// The lookup into one map.
    pub fn map(&self, k: usize) -> &MapLookup {
        &self.maps[k]
    }
    /// The map that serves a receiver, `p` relative to the origin: [`Parameterization::choose`].
    pub fn choose(&self, p: DVec3, eye_depth: f64) -> Option<usize> {
        Held::first(self.p.first_map(eye_depth)..self.maps.len(), |k| self.maps[k].holds(p))
    }
}

/// How far a plane's depth changes over the filter's reach along the map's x and y, in units of what its slope says.
#[derive(Debug, Clone, Copy)]
struct Bends {
    /// The way on which it falls.
    falling: DVec2,
    /// Either way, the larger one.
    largest: DVec2,
}

impl MapLookup {
    /// Of a place before the post-warp, of a plane whose depth rises along x, and along y up, or falls.
    fn bends(&self, at: DVec2, rises: [bool; 2]) -> Bends {
        match &self.post_warp {
            PostWarp::None => Bends { falling: DVec2::ONE, largest: DVec2::ONE },
            PostWarp::Log { scale, .. } => {
                let rises_with_w = rises[1] == (*scale > 0.0);
                let [rising, falling] = self.bend;
                let along = if rises_with_w { rising } else { falling };
                Bends { falling: DVec2::new(1.0, along), largest: DVec2::new(1.0, rising.max(falling)) }
            }
            // Depth is affine before the warp: what counts is how far the reach goes there.
            PostWarp::Rectilinear(warp) => {
                let reach =
                    2.0 * self.filter.reach_texels() / DVec2::new(f64::from(self.size[0]), f64::from(self.size[1]));
                if reach == DVec2::ZERO {
                    return Bends { falling: DVec2::ONE, largest: DVec2::ONE };
                }
                let (after, per_reach) = (warp.after(at), warp.slopes(at) / reach);
                let back = (at - warp.before(after - reach)) * per_reach;
                let on = (warp.before(after + reach) - at) * per_reach;
                let falling = |axis: usize| if rises[axis] { back[axis] } else { on[axis] };
                Bends { falling: DVec2::new(falling(0), falling(1)), largest: back.max(on) }
            }
        }
    }
}

/// How much the depth of a plane falls over `reach` in NDC y, in units of what its slope says: where it rises with w, and where
/// it falls. Under a logarithm depth is affine in 1/w = exp((offset - y) / scale), whose change grows towards the smaller w.
fn bend(post_warp: &PostWarp, reach: f64) -> [f64; 2] {
    match post_warp {
        PostWarp::Log { scale, .. } if reach != 0.0 => {
            let reach = (reach / scale).abs();
            [reach.exp_m1() / reach, -(-reach).exp_m1() / reach]
        }
        _ => [1.0; 2],
    }
}
