//! What shaders are told of a light, its maps and a lookup: the host's side of choose.wgsl, lookup.wgsl and footprint.wgsl.
//!
//! All is formed in f64 relative to the eye, in its space's unit, and scaled by powers of two before it is rounded.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3, DVec4};

use super::kernel::Kernel;
use super::pairs::pairs;
use super::surface::EyeSpace;
use crate::error::{Error, Result};
use crate::parameterization::{Parameterization, Partition, PostWarp, Region, Selection};
use crate::render::{MaskSettings, Spacing, Stored, check_blend, depth_measure};
use crate::scene::Light;

/// `Choice` of choose.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Choice {
    light: [f32; 4],
    cone: [f32; 4],
    range: f32,
    maps: u32,
    selection: u32,
    unused: u32,
}

/// `Map` of choose.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Map {
    /// Rows of `shadow_clip_from_eye`.
    rows: [[f32; 4]; 4],
    region: [[f32; 4]; Region::MOST],
    gradients: [Gradient; 2],
    ray: [f32; 4],
    texel: [f32; 3],
    depth_end: f32,
    regions: u32,
    post_warp: u32,
    log_scale: f32,
    log_offset: f32,
    depth_begin: f32,
    unused: [u32; 3],
    /// What stored depths measure: numerator and denominator.
    depth: [[f32; 4]; 2],
    /// Rests of the rows and of these two.
    rows_low: [[f32; 4]; 4],
    depth_low: [[f32; 4]; 2],
}

/// `Gradient` of choose.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Gradient {
    at_eye: [f32; 3],
    unused: u32,
    turn: [f32; 3],
    unused_too: u32,
}

/// `Lookup` of lookup.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Lookup {
    bias_world: f32,
    bias_texels: f32,
    bias_ndc: f32,
    slope: f32,
    slope_limit: f32,
    plane: f32,
    bias_normal: f32,
    blend: f32,
    first_map: u32,
    end_map: u32,
    factor: f32,
    /// Of a normalised format steps times their size, else steps.
    units: f32,
    /// Binary digits of a float's step, 0 of a normalised format.
    digits: i32,
    unused: [u32; 3],
    kernel: Kernel,
}

impl Lookup {
    /// This lookup for a dispatch that sees to the pixels that ask some of the maps.
    pub fn part(self, maps: Range<usize>) -> Self {
        Self { first_map: maps.start as u32, end_map: maps.end as u32, ..self }
    }
}

impl EyeSpace {
    /// The light, and how receivers choose among maps.
    pub fn choice(&self, light: &Light, p: &Parameterization) -> Choice {
        let point = light.point();
        let place = if point.w == 0.0 { point.truncate() } else { (point.truncate() - self.eye) / self.unit };
        let (cone, range) = match light {
            Light::Directional(_) => (DVec4::new(0.0, 0.0, 0.0, -2.0), f64::INFINITY),
            Light::Spot(l) => (l.direction().extend((0.5 * l.cone_angle()).cos()), l.range()),
            Light::Point(l) => (DVec4::new(0.0, 0.0, 0.0, -2.0), l.range()),
        };
        Choice {
            light: place.extend(point.w).as_vec4().to_array(),
            cone: cone.as_vec4().to_array(),
            range: finite(self.length(range)),
            maps: p.partitions.len() as u32,
            selection: match p.selection {
                Selection::Depth => 0,
                Selection::Containment => 1,
            },
            unused: 0,
        }
    }

    /// Bias, blending and filter; the maps at hand are for the caller to fill in.
    ///
    /// # Errors
    /// [`crate::Error::InvalidArgument`] for an unusable bias or blend.
    pub fn lookup(&self, settings: &MaskSettings, kernel: Kernel) -> Result<Lookup> {
        let (bias, format) = (settings.bias.checked()?, settings.stored.format);
        Ok(Lookup {
            bias_world: self.length(bias.world).clamp(f32::MIN, f32::MAX),
            bias_texels: bias.texels as f32,
            bias_ndc: bias.ndc as f32,
            slope: bias.slope as f32,
            slope_limit: finite(bias.slope_limit as f32),
            plane: bias.plane as f32,
            bias_normal: bias.normal as f32,
            blend: check_blend(settings.blend)? as f32,
            first_map: 0,
            end_map: 0,
            factor: bias.factor as f32,
            units: match format.levels() {
                Some(_) => (bias.units * format.step(1.0)) as f32,
                None => bias.units as f32,
            },
            digits: match format.levels() {
                Some(_) => 0,
                None => -format.step(1.0).log2() as i32,
            },
            unused: [0; 3],
            kernel,
        })
    }

    /// The records of all maps of `resolution` texels.
    ///
    /// # Errors
    /// [`crate::Error::InvalidArgument`] for a matrix that is not finite, and for a rectilinear warp: a record has no room for
    /// its knots.
    pub fn maps(&self, p: &Parameterization, resolution: [u32; 2]) -> Result<Vec<Map>> {
        self.maps_of(p, resolution, Stored::default())
    }

    /// The same for lookups of what is stored.
    ///
    /// # Errors
    /// As [`EyeSpace::maps`], and [`crate::Error::InvalidArgument`] for a map that has no linear depth.
    pub fn maps_of(&self, p: &Parameterization, resolution: [u32; 2], stored: Stored) -> Result<Vec<Map>> {
        let farthest = p.partitions.last().map_or(0.0, |last| last.eye_depth[1]);
        let map = |partition: &Partition| {
            // Those that end where the last does have no end: Parameterization::first_map.
            let end = partition.eye_depth[1];
            let depth_end = if end >= farthest { f32::MAX } else { self.camera_depth(end).clamp(f32::MIN, f32::MAX) };
            let depth_begin = self.camera_depth(partition.eye_depth[0]).clamp(f32::MIN, f32::MAX);
            Ok(Map { depth_begin, depth_end, ..Map::new(partition, self.unit, resolution, stored)? })
        };
        p.relative_to(self.eye)?.partitions.iter().map(map).collect()
    }
}

impl Map {
    /// The record of a map for points relative to the eye, in world units; its depths are for the caller to fill in.
    fn new(partition: &Partition, unit: f64, resolution: [u32; 2], stored: Stored) -> Result<Self> {
        let relative_from_eye = DMat4::from_scale(DVec3::splat(unit));
        let clip_from_eye = partition.shadow_clip_from_world * relative_from_eye;
        // Clip coordinates are homogeneous: a power of two in all of them changes nothing but w.
        let scale = power_of_two_below(&clip_from_eye.to_cols_array());
        let rows: [DVec4; 4] = std::array::from_fn(|i| clip_from_eye.row(i) * scale);
        let functionals = partition.region.functionals();
        let mut region = [[0.0; 4]; Region::MOST];
        for (f, to) in functionals.iter().zip(&mut region) {
            let f = relative_from_eye * *f;
            *to = (f * power_of_two_below(&f.to_array())).as_vec4().to_array();
        }
        let (post_warp, log_scale, log_offset) = match partition.post_warp {
            PostWarp::None => (0, 0.0, 0.0),
            // ln of the row's w is that of w and that of the power of two.
            PostWarp::Log { scale: log_scale, offset } => (1, log_scale, offset - log_scale * scale.ln()),
            PostWarp::Rectilinear(_) => {
                let (expected, got) = ("maps without or with a logarithmic post-warp", "a rectilinear post-warp");
                return Err(Error::argument("parameterization", expected, got, "use the cpu renderer, which is exact"));
            }
        };
        let logarithm = (post_warp == 1).then_some(log_scale);
        let Gradients { x, y, ray } = Gradients::new(rows, logarithm);
        let largest = |[at_eye, turn]: [DVec3; 2]| power_of_two_below(&[at_eye.to_array(), turn.to_array()].concat());
        let (k_x, k_y, k_ray) = (largest(x), largest(y), power_of_two_below(&ray.to_array()));
        // Texels to a unit of NDC; y down.
        let [texels_x, texels_y] = [0.5 * f64::from(resolution[0]), -0.5 * f64::from(resolution[1])];
        let depth = match stored.spacing {
            Spacing::Projective => [rows[2], rows[3]],
            Spacing::Linear => depth_measure(&clip_from_eye, &partition.post_warp, stored.spacing)?,
        };
        let (rows, depth) = (rows.map(|row| pairs(row.to_array())), depth.map(|row| pairs(row.to_array())));
        let texel = DVec3::new(k_ray / (k_y * texels_x), k_ray / (k_x * texels_y), k_x * k_y / k_ray);
        Ok(Self {
            rows: rows.map(|[high, _]| high),
            rows_low: rows.map(|[_, low]| low),
            region,
            gradients: [Gradient::new(x, k_x), Gradient::new(y, k_y)],
            ray: (ray * k_ray).as_vec4().to_array(),
            texel: texel.as_vec3().to_array(),
            regions: functionals.len() as u32,
            post_warp,
            log_scale: log_scale as f32,
            log_offset: log_offset as f32,
            depth: depth.map(|[high, _]| high),
            depth_low: depth.map(|[_, low]| low),
            ..Self::zeroed()
        })
    }
}

impl Gradient {
    fn new([at_eye, turn]: [DVec3; 2], scale: f64) -> Self {
        let single = |v: DVec3| (v * scale).as_vec3().to_array();
        Self { at_eye: single(at_eye), turn: single(turn), ..Self::zeroed() }
    }
}

/// How the texel's coordinates change, apart from powers of w: footprint.wgsl has the formulas.
#[derive(Debug, Clone, Copy)]
struct Gradients {
    /// G_x at the eye, and what p is crossed with.
    x: [DVec3; 2],
    /// G_y likewise.
    y: [DVec3; 2],
    /// R: what is added, and the factor of p.
    ray: DVec4,
}

impl Gradients {
    /// Those of the rows x, y, z, w of a map, with the scale of a logarithm after it.
    fn new([x, y, _, w]: [DVec4; 4], logarithm: Option<f64>) -> Self {
        let (d_x, d_y, d_w) = (x.truncate(), y.truncate(), w.truncate());
        let of = |row: DVec4| [w.w * row.truncate() - row.w * d_w, row.truncate().cross(d_w)];
        match logarithm {
            None => {
                let constant = w.w * d_x.cross(d_y) + y.w * d_w.cross(d_x) + x.w * d_y.cross(d_w);
                Self { x: of(x), y: of(y), ray: constant.extend(d_x.cross(d_y).dot(d_w)) }
            }
            Some(scale) => Self { x: of(x), y: [scale * d_w, DVec3::ZERO], ray: (scale * d_x.cross(d_w)).extend(0.0) },
        }
    }
}

/// Infinities in shaders: WGSL need not know them.
fn finite(x: f32) -> f32 {
    x.min(f32::MAX)
}

/// The power of two that brings the largest of some numbers to [1, 2); 1 where all are zero.
fn power_of_two_below(numbers: &[f64]) -> f64 {
    let largest = numbers.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    if largest > 0.0 { 2f64.powi(-(largest.log2().floor() as i32).clamp(-1000, 1000)) } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::library;
    use crate::techniques::technique_of;

    const RESOLUTION: [u32; 2] = [512, 1024];
    /// Relative error of a central difference over 1e-4 of the unit, and of records rounded to f32.
    const DIFFERENCE: f64 = 1e-5;

    fn vector(v: [f32; 3]) -> DVec3 {
        DVec3::from_array(v.map(f64::from))
    }

    /// Texel coordinates of a point of the eye's space.
    fn texel(partition: &Partition, space: &EyeSpace, p_eye: DVec3) -> [f64; 2] {
        let (ndc, _) = partition.project(space.eye + space.unit * p_eye);
        [0.5 * f64::from(RESOLUTION[0]) * ndc.x, -0.5 * f64::from(RESOLUTION[1]) * ndc.y]
    }

    /// Gradients of the texel's coordinates and NDC y, as footprint.wgsl and choose.wgsl take them from a record.
    fn of_record(map: &Map, p: DVec3) -> ([DVec3; 2], f64) {
        let row = |i: usize| DVec4::from_array(map.rows[i].map(f64::from)).dot(p.extend(1.0));
        let w = row(3);
        let g = map.gradients.map(|g| vector(g.at_eye) + p.cross(vector(g.turn)));
        let ray = vector([map.ray[0], map.ray[1], map.ray[2]]) + f64::from(map.ray[3]) * p;
        let [f_x, f_y, _] = map.texel.map(f64::from);
        let f_y = if map.post_warp == 1 { f_y } else { f_y * w };
        // Steps of a texel along the map's axes, up to what lies along the ray, and from them the gradients.
        let (s_x, s_y) = (f_x * w * g[1].cross(ray) / ray.dot(ray), f_y * ray.cross(g[0]) / ray.dot(ray));
        let across = s_x.cross(s_y);
        let y = match map.post_warp {
            1 => f64::from(map.log_scale) * w.ln() + f64::from(map.log_offset),
            _ => row(1) / w,
        };
        ([s_y.cross(across), across.cross(s_x)].map(|g| g / across.dot(across)), y)
    }

    #[test]
    fn records_tell_how_texels_change() {
        for name in ["uniform", "lispsm:near=delta-z", "tsm:", "xpsm:", "log:", "log_psm:"] {
            let s = library::build("robots", 1, &[]).unwrap();
            let text = if name.contains(':') { format!("{name},range=body,fit=exact") } else { name.into() };
            let mut p = technique_of(&text).unwrap().parameterize(&s.scene, &s.camera, &s.light, 512).unwrap();
            let space = EyeSpace::new(&s.scene, &s.camera);
            for scale in [1.0, 2f64.powi(40), 3e-20] {
                // Clip coordinates are homogeneous, but for the logarithm of w.
                let partition = &mut p.partitions[0];
                partition.shadow_clip_from_world *= scale;
                if let PostWarp::Log { scale: log_scale, offset } = &mut partition.post_warp {
                    *offset -= *log_scale * scale.ln();
                }
                let (partition, map) = (&p.partitions[0], space.maps(&p, RESOLUTION).unwrap()[0]);
                for ahead in [0.3, 0.5, 0.8] {
                    let place = s.camera.eye() + (s.scene.bounds().center() - s.camera.eye()) * ahead;
                    let p_eye = (place - space.eye) / space.unit;
                    let (gradients, y) = of_record(&map, p_eye);
                    let h = 1e-4;
                    for (k, gradient) in gradients.into_iter().enumerate() {
                        let along = |axis: DVec3| {
                            let at = |p: DVec3| texel(partition, &space, p)[k];
                            (at(p_eye + h * axis) - at(p_eye - h * axis)) / (2.0 * h)
                        };
                        let expected = DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z));
                        let apart = (gradient - expected).length() / expected.length();
                        assert!(apart <= DIFFERENCE, "{text}, {k}: {gradient}, not {expected}: {apart:e}");
                    }
                    let expected = partition.project(place).0.y;
                    assert!(
                        (y - expected).abs() <= DIFFERENCE * expected.abs().max(1.0),
                        "{text}: {y}, not {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn records_have_the_layout_of_the_shader() {
        // WGSL aligns structs to 16 bytes, and a vec3f to as much.
        assert_eq!(
            (size_of::<Choice>(), size_of::<Map>(), size_of::<Gradient>(), size_of::<Lookup>()),
            (48, 448, 32, 64 + 16 + 16 * 128)
        );
        assert_eq!((std::mem::offset_of!(Map, texel), std::mem::offset_of!(Map, log_offset)), (272, 300));
    }
}
