//! What shaders are told of a light, its maps and a lookup: the host's side of choose.wgsl and lookup.wgsl.
//!
//! All is formed in f64 relative to the eye, in its space's unit, and scaled by powers of two before it is rounded.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3, DVec4};

use super::surface::EyeSpace;
use crate::error::Result;
use crate::parameterization::{Parameterization, Partition, Region, Selection};
use crate::render::{Filter, MaskSettings};
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
    depth_end: f32,
    regions: u32,
    unused: [u32; 2],
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
    filter_kind: u32,
    first_map: u32,
    end_map: u32,
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

    /// Bias and filter; the maps at hand are for the caller to fill in.
    ///
    /// # Errors
    /// [`crate::Error::InvalidArgument`] for an unusable bias.
    pub fn lookup(&self, settings: &MaskSettings) -> Result<Lookup> {
        let bias = settings.bias.checked()?;
        Ok(Lookup {
            bias_world: self.length(bias.world).clamp(f32::MIN, f32::MAX),
            bias_texels: bias.texels as f32,
            bias_ndc: bias.ndc as f32,
            slope: bias.slope as f32,
            slope_limit: finite(bias.slope_limit as f32),
            filter_kind: match settings.filter {
                Filter::Nearest => 0,
                Filter::Pcf2x2 => 1,
            },
            first_map: 0,
            end_map: 0,
        })
    }

    /// The records of all maps.
    ///
    /// # Errors
    /// [`crate::Error::InvalidArgument`] for a matrix that is not finite.
    pub fn maps(&self, p: &Parameterization) -> Result<Vec<Map>> {
        let farthest = p.partitions.last().map_or(0.0, |last| last.eye_depth[1]);
        let map = |partition: &Partition| {
            // Those that end where the last does have no end: Parameterization::first_map.
            let end = partition.eye_depth[1];
            let depth_end = if end >= farthest { f32::MAX } else { self.length(end).clamp(f32::MIN, f32::MAX) };
            Map { depth_end, ..Map::new(partition, self.unit) }
        };
        Ok(p.relative_to(self.eye)?.partitions.iter().map(map).collect())
    }
}

impl Map {
    /// The record of a map for points relative to the eye, in world units; the end of its depths is for the caller to fill in.
    fn new(partition: &Partition, unit: f64) -> Self {
        let relative_from_eye = DMat4::from_scale(DVec3::splat(unit));
        let clip_from_eye = partition.shadow_clip_from_world * relative_from_eye;
        // Clip coordinates are homogeneous: a power of two in all of them changes nothing.
        let scale = power_of_two_below(&clip_from_eye.to_cols_array());
        let functionals = partition.region.functionals();
        let mut region = [[0.0; 4]; Region::MOST];
        for (f, to) in functionals.iter().zip(&mut region) {
            let f = relative_from_eye * *f;
            *to = (f * power_of_two_below(&f.to_array())).as_vec4().to_array();
        }
        Self {
            rows: std::array::from_fn(|i| (clip_from_eye.row(i) * scale).as_vec4().to_array()),
            region,
            regions: functionals.len() as u32,
            ..Self::zeroed()
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
