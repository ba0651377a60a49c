//! What shaders are told of a view: the host's side of surface.wgsl.
//!
//! All matrices are formed in f64 relative to the eye and divided by a power of two before they are rounded.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::{DAffine3, DMat3, DVec3};

use super::draw_list::Draw;
use super::pairs::pairs;
use super::scene_cache::DeviceScene;
use crate::scene::{Camera, Scene};

/// The eye's space of surface.wgsl: world axes, origin at a perspective eye, or on the view axis of parallel rays beside the
/// scene; lengths in `unit` world units.
#[derive(Debug, Clone, Copy)]
pub(super) struct EyeSpace {
    pub eye: DVec3,
    pub unit: f64,
    /// The camera depth of the origin.
    depth: f64,
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
    rays: u32,
    center: [f32; 3],
    nearest: f32,
    shift: [f32; 2],
    depth_at_origin: f32,
    unused: u32,
    /// Rests of right, up, forward, `eye_minus_origin` and center; vectors have four numbers there.
    low: [[f32; 4]; 5],
}

/// `Placement` of surface.wgsl.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Placement {
    /// Rows, each with its rest.
    eye_from_local: [[[f32; 4]; 2]; 3],
    first_vertex: u32,
    first_index: u32,
    instance: u32,
    unused: u32,
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
        // Parallel rays come from no point: the origin is where single precision has digits for the scene.
        let depth = if camera.is_orthographic() {
            camera.depth_of(scene.origin()).clamp(camera.near(), camera.far())
        } else {
            0.0
        };
        let eye = if camera.is_orthographic() { camera.eye() + camera.forward() * depth } else { camera.eye() };
        let reach = (scene.bounds().min - eye).abs().max((scene.bounds().max - eye).abs()).max_element();
        // A power of two divides without rounding; clamped so that it and its inverse stay normal numbers.
        let unit = if reach > 0.0 { 2f64.powi((reach.log2().ceil() as i32).clamp(-1000, 1000)) } else { 1.0 };
        Self { eye, unit, depth }
    }

    /// A length of this space.
    pub fn length(&self, world: f64) -> f32 {
        (world / self.unit) as f32
    }

    /// The camera depth of this space, whose origin need not be at depth 0.
    pub fn camera_depth(&self, world: f64) -> f32 {
        self.length(world - self.depth)
    }

    /// The view of an image; rows and slots are for the caller to fill in.
    pub fn view(&self, scene: &Scene, camera: &Camera, size: [u32; 2]) -> View {
        let (half, shift) = (camera.half_size(), camera.volume().shift);
        let parallel = camera.is_orthographic();
        // Tangents, or lengths of this space.
        let unit = if parallel { self.unit } else { 1.0 };
        let (right, up) = (camera.right() * (half.x / unit), camera.up() * (half.y / unit));
        let straight = if parallel { DVec3::ZERO } else { camera.forward() };
        let center = straight + right * shift.x + up * shift.y;
        let vectors = [right, up, camera.forward(), self.eye - scene.origin(), center].map(|v| pairs(v.to_array()));
        let [right, up, forward, eye_minus_origin, center] = vectors.map(|[high, _]| high);
        View {
            right,
            width: size[0],
            up,
            height: size[1],
            forward,
            rays: u32::from(parallel),
            center,
            nearest: if parallel { self.camera_depth(camera.near()).max(f32::MIN) } else { 0.0 },
            shift: shift.as_vec2().to_array(),
            depth_at_origin: self.depth as f32,
            eye_minus_origin,
            low: vectors.map(|[_, [x, y, z]]| [x, y, z, 0.0]),
            // What a G-buffer stores is f32 in world units; a unit outside of that range cannot be stored either way.
            unit: self.unit.clamp(f32::MIN_POSITIVE.into(), f32::MAX.into()) as f32,
            ..View::zeroed()
        }
    }

    /// The placements of the instances of a draw list.
    pub fn placements(&self, scene: &Scene, on_device: &DeviceScene, instances: &[u32]) -> Vec<Placement> {
        let placement = |&instance: &u32| {
            let world_from_local: DAffine3 = scene.world_from_local(instance as usize);
            let linear: DMat3 = world_from_local.matrix3;
            let translation = (world_from_local.translation - self.eye) / self.unit;
            let row = |i: usize| pairs((linear.row(i) / self.unit).extend(translation[i]).to_array());
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
