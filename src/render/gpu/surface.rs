//! What shaders are told of a view, a light and its maps: the host's side of surface.wgsl, gbuffer.wgsl and lookup.wgsl.
//!
//! All matrices are formed in f64 relative to the eye and divided by a power of two before they are rounded.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DMat3, DMat4, DVec3, DVec4};

use super::draw_list::Draw;
use super::scene_cache::DeviceScene;
use crate::error::Result;
use crate::parameterization::{Parameterization, Region, Selection};
use crate::render::{Filter, MaskSettings};
use crate::scene::{Camera, Light, Scene};

/// The eye's space of surface.wgsl: world axes, origin at the eye, lengths in `unit` world units.
#[derive(Debug, Clone, Copy)]
pub(super) struct EyeSpace {
    eye: DVec3,
    unit: f64,
}

/// `View` of surface.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct View {
    right: [f32; 3],
    width: u32,
    up: [f32; 3],
    height: u32,
    forward: [f32; 3],
    first_row: u32,
    eye_minus_origin: [f32; 3],
    rows: u32,
    unit: f32,
    first_slot: u32,
    end_slot: u32,
    unused: u32,
}

/// `Placement` of surface.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Placement {
    /// Rows.
    eye_from_local: [[f32; 4]; 3],
    first_vertex: u32,
    first_index: u32,
    instance: u32,
    unused: u32,
}

/// `Lookup` of lookup.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Lookup {
    light: [f32; 4],
    cone: [f32; 4],
    range: f32,
    bias_world: f32,
    bias_texels: f32,
    bias_ndc: f32,
    slope: f32,
    slope_limit: f32,
    filter_kind: u32,
    maps: u32,
    selection: u32,
    first_map: u32,
    end_map: u32,
    unused: u32,
}

/// `Map` of lookup.wgsl.
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

impl Lookup {
    /// This lookup for a dispatch that sees to the pixels that ask some of the maps.
    pub fn part(self, maps: Range<usize>) -> Self {
        Self { first_map: maps.start as u32, end_map: maps.end as u32, ..self }
    }
}

impl View {
    /// This view for a dispatch that sees to some rows and slots.
    pub fn part(self, rows: Range<u32>, slots: Range<u32>) -> Self {
        let (first_row, first_slot, end_slot) = (rows.start, slots.start, slots.end);
        Self { first_row, rows: rows.end - rows.start, first_slot, end_slot, ..self }
    }
}

impl EyeSpace {
    /// The space of a camera in a scene.
    pub fn new(scene: &Scene, camera: &Camera) -> Self {
        let eye = camera.eye();
        let reach = (scene.bounds().min - eye).abs().max((scene.bounds().max - eye).abs()).max_element();
        // A power of two divides without rounding; clamped so that it and its inverse stay normal numbers.
        let unit = if reach > 0.0 { 2f64.powi((reach.log2().ceil() as i32).clamp(-1000, 1000)) } else { 1.0 };
        Self { eye, unit }
    }

    /// A length of this space.
    fn length(&self, world: f64) -> f32 {
        (world / self.unit) as f32
    }

    /// The view of an image; rows and slots are for the caller to fill in.
    pub fn view(&self, scene: &Scene, camera: &Camera, size: [u32; 2]) -> View {
        let (tan_x, tan_y) = camera.tan_half_fov();
        View {
            right: (camera.right() * tan_x).as_vec3().to_array(),
            width: size[0],
            up: (camera.up() * tan_y).as_vec3().to_array(),
            height: size[1],
            forward: camera.forward().as_vec3().to_array(),
            eye_minus_origin: (self.eye - scene.origin()).as_vec3().to_array(),
            // What a G-buffer stores is f32 in world units; a unit outside of that range cannot be stored either way.
            unit: self.unit.clamp(f32::MIN_POSITIVE.into(), f32::MAX.into()) as f32,
            ..View::zeroed()
        }
    }

    /// The placements of the instances of a draw list.
    pub fn placements(&self, scene: &Scene, on_device: &DeviceScene, instances: &[u32]) -> Vec<Placement> {
        let placement = |&instance: &u32| {
            let world_from_local: &DAffine3 = &scene.world_from_local()[instance as usize];
            let linear: DMat3 = world_from_local.matrix3;
            let translation = (world_from_local.translation - self.eye) / self.unit;
            let row = |i: usize| (linear.row(i) / self.unit).extend(translation[i]).as_vec4().to_array();
            let mesh = on_device.meshes[scene.instances()[instance as usize].mesh as usize];
            Placement {
                eye_from_local: std::array::from_fn(row),
                first_vertex: mesh.first_vertex,
                first_index: mesh.first_index,
                instance,
                unused: 0,
            }
        };
        instances.iter().map(placement).collect()
    }

    /// The light, its bias and the filter; the maps at hand are for the caller to fill in.
    ///
    /// # Errors
    /// [`crate::Error::InvalidArgument`] for an unusable bias.
    pub fn lookup(&self, light: &Light, settings: &MaskSettings, p: &Parameterization) -> Result<Lookup> {
        let bias = settings.bias.checked()?;
        let point = light.point();
        let place = if point.w == 0.0 { point.truncate() } else { (point.truncate() - self.eye) / self.unit };
        let (cone, range) = match light {
            Light::Directional(_) => (DVec4::new(0.0, 0.0, 0.0, -2.0), f64::INFINITY),
            Light::Spot(l) => (l.direction().extend((0.5 * l.cone_angle()).cos()), l.range()),
            Light::Point(l) => (DVec4::new(0.0, 0.0, 0.0, -2.0), l.range()),
        };
        // No infinities in shaders: WGSL need not know them.
        let finite = |x: f32| x.min(f32::MAX);
        Ok(Lookup {
            light: place.extend(point.w).as_vec4().to_array(),
            cone: cone.as_vec4().to_array(),
            range: finite(self.length(range)),
            bias_world: self.length(bias.world).clamp(f32::MIN, f32::MAX),
            bias_texels: bias.texels as f32,
            bias_ndc: bias.ndc as f32,
            slope: bias.slope as f32,
            slope_limit: finite(bias.slope_limit as f32),
            filter_kind: match settings.filter {
                Filter::Nearest => 0,
                Filter::Pcf2x2 => 1,
            },
            maps: p.partitions.len() as u32,
            selection: match p.selection {
                Selection::Depth => 0,
                Selection::Containment => 1,
            },
            first_map: 0,
            end_map: 0,
            unused: 0,
        })
    }

    /// The records of all maps, whose matrices are finite.
    pub fn maps(&self, p: &Parameterization) -> Vec<Map> {
        let world_from_eye = DMat4::from_translation(self.eye) * DMat4::from_scale(DVec3::splat(self.unit));
        let farthest = p.partitions.last().map_or(0.0, |last| last.eye_depth[1]);
        let map = |partition: &crate::Partition| {
            let clip_from_eye = partition.shadow_clip_from_world * world_from_eye;
            // Clip coordinates are homogeneous: a power of two in all of them changes nothing.
            let scale = power_of_two_below(&clip_from_eye.to_cols_array());
            let rows = std::array::from_fn(|i| (clip_from_eye.row(i) * scale).as_vec4().to_array());
            let functionals = partition.region.functionals();
            let mut region = [[0.0; 4]; Region::MOST];
            for (f, to) in functionals.iter().zip(&mut region) {
                let f = world_from_eye.transpose() * *f;
                *to = (f * power_of_two_below(&f.to_array())).as_vec4().to_array();
            }
            // Those that end where the last does have no end: Parameterization::first_map.
            let end = partition.eye_depth[1];
            let depth_end = if end >= farthest { f32::MAX } else { self.length(end).clamp(f32::MIN, f32::MAX) };
            Map { rows, region, depth_end, regions: functionals.len() as u32, unused: [0; 2] }
        };
        p.partitions.iter().map(map).collect()
    }
}

/// The power of two that brings the largest of some numbers to [1, 2); 1 where all are zero.
fn power_of_two_below(numbers: &[f64]) -> f64 {
    let largest = numbers.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    if largest > 0.0 { 2f64.powi(-(largest.log2().floor() as i32).clamp(-1000, 1000)) } else { 1.0 }
}

/// The groups that a list of draws uses, each with its slots; at least one, the first from slot 0.
pub(super) fn slots_by_group(on_device: &DeviceScene, draws: &[Draw]) -> Vec<(u32, Range<u32>)> {
    let mut found: Vec<(u32, Range<u32>)> = Vec::new();
    for draw in draws {
        let group = on_device.meshes[draw.mesh as usize].group;
        match found.last_mut() {
            Some((g, slots)) if *g == group => slots.end = draw.slots.end,
            _ => found.push((group, draw.slots.clone())),
        }
    }
    if found.is_empty() {
        found.push((0, 0..0));
    }
    found
}
