//! What one pass draws: the instances that can show, their matrices, and one draw a mesh.

use std::ops::Range;

use bytemuck::{Pod, Zeroable};
use glam::DMat4;
use rayon::prelude::*;

use super::exact::{Depths, ExactTriangles};
use super::guard_band::GuardBand;
use super::scene_cache::DeviceScene;
use crate::render::precision::single_is_enough;
use crate::render::{Keep, Volume};
use crate::scene::Scene;

/// One instance in a pass, as shaders read it: the columns of `clip_from_local`, times a power of two.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub(super) struct ClipFromLocal(pub [[f32; 4]; 4]);

/// One draw: instances of one mesh.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Draw {
    /// Index of the mesh in the scene.
    pub mesh: u32,
    /// Places in the list's arrays.
    pub slots: Range<u32>,
    /// Whether the device projects them; else they are among the pass's exact triangles.
    pub is_on_device: bool,
}

/// What a pass draws.
#[derive(Debug, Default, Clone, PartialEq)]
pub(super) struct PassDraws {
    pub draws: Vec<Draw>,
    /// The instances that single precision would misplace.
    pub exact: ExactTriangles,
    /// The same of those with alpha tests, by the mesh.
    pub tested_exact: Vec<(u32, ExactTriangles)>,
}

/// The visible instances of one or several passes, each pass's after the other's.
#[derive(Default)]
pub(super) struct DrawList {
    pub clip_from_local: Vec<ClipFromLocal>,
    /// The scene's index of the instance at each slot.
    pub instances: Vec<u32>,
    /// Whether exact triangles of mirrored instances and maps are turned, so that all show their outer side alike.
    pub turns: bool,
}

impl PassDraws {
    /// What the device projects of meshes with alpha tests, or of those without.
    pub fn on_device<'a>(&'a self, on_device: &'a DeviceScene, is_tested: bool) -> impl Iterator<Item = &'a Draw> {
        let is_asked =
            move |draw: &&Draw| draw.is_on_device && on_device.meshes[draw.mesh as usize].test.is_some() == is_tested;
        self.draws.iter().filter(is_asked)
    }
    /// Whether anything has an alpha test.
    pub fn is_tested(&self, on_device: &DeviceScene) -> bool {
        !self.tested_exact.is_empty() || self.on_device(on_device, true).next().is_some()
    }
}

impl DrawList {
    /// Appends what `keep` takes of what a pass under `clip_from_world` can show; tells what it draws. The matrices are for the viewport that `guard`
    /// sets.
    #[allow(clippy::too_many_arguments)]
    pub fn push_pass(
        &mut self,
        scene: &Scene,
        on_device: &DeviceScene,
        clip_from_world: &DMat4,
        guard: GuardBand,
        depths: Depths,
        keep: Keep,
    ) -> PassDraws {
        let viewport_from_clip = guard.viewport_from_clip();
        let mut kept = keep.instances(scene, &Volume::of_clip(clip_from_world, 0.0));
        // By mesh, which is by group as well; those of one mesh stay in the scene's order, and so do equal depths.
        kept.par_sort_unstable_by_key(|&i| (scene.instances()[i as usize].mesh, i));
        let visible: Vec<(u32, DMat4, bool)> = kept
            .par_iter()
            .with_min_len(1024) // about 0.1 ms of work
            .map(|&instance| {
                let clip_from_local = scene.clip_from_local(clip_from_world, instance as usize);
                let is_on_device = single_is_enough(&clip_from_local, scene.mesh_of(instance as usize).bounds_local());
                (instance, viewport_from_clip * clip_from_local, is_on_device)
            })
            .collect();
        let mut pass = PassDraws::default();
        for (instance, viewport_from_local, is_on_device) in visible {
            let (mesh, slot) = (scene.instances()[instance as usize].mesh, self.instances.len() as u32);
            match pass.draws.last_mut() {
                Some(draw) if draw.mesh == mesh && draw.is_on_device == is_on_device => draw.slots.end = slot + 1,
                _ => pass.draws.push(Draw { mesh, slots: slot..slot + 1, is_on_device }),
            }
            if !is_on_device {
                let is_tested = on_device.meshes[mesh as usize].test.is_some();
                if is_tested && pass.tested_exact.last().is_none_or(|(last, _)| *last != mesh) {
                    pass.tested_exact.push((mesh, ExactTriangles::default()));
                }
                let exact = match pass.tested_exact.last_mut() {
                    Some((_, exact)) if is_tested => exact,
                    _ => &mut pass.exact,
                };
                exact.push(scene.mesh_of(instance as usize), &viewport_from_local, slot, depths, self.turns);
            }
            self.instances.push(instance);
            self.clip_from_local.push(single(&viewport_from_local));
        }
        pass
    }

    /// Appends a matrix that changes nothing, which belongs to no instance; gives its place. The list is complete then.
    pub fn push_identity(&mut self) -> u32 {
        self.clip_from_local.push(single(&DMat4::IDENTITY));
        self.clip_from_local.len() as u32 - 1
    }
}

/// The matrix in single precision, scaled by the power of two that brings its largest entry to [0.5, 1): clip coordinates
/// are homogeneous, so the picture is the same bit by bit, and no scale of the world leaves the range of f32.
fn single(clip_from_local: &DMat4) -> ClipFromLocal {
    let largest = clip_from_local.to_cols_array().iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let scale = if largest > 0.0 { 2f64.powi(-(largest.log2().floor() as i32 + 1).clamp(-1000, 1000)) } else { 1.0 };
    ClipFromLocal((*clip_from_local * scale).as_mat4().to_cols_array_2d())
}

#[cfg(test)]
mod tests {
    use glam::{Vec3, Vec4};

    use super::*;

    #[test]
    fn scaled_matrices_give_the_same_picture_at_every_scale() {
        let clip = glam::dcamera::rh::proj::directx::perspective(1.0, 1.5, 0.1, 100.0);
        let ndc = |m: ClipFromLocal| {
            let p = glam::Mat4::from_cols_array_2d(&m.0) * Vec4::from((Vec3::new(0.1, 0.2, -3.0), 1.0));
            p / p.w
        };
        for scale in [1.0, 2f64.powi(-300), 2f64.powi(300)] {
            assert_eq!(ndc(single(&(clip * scale))), ndc(single(&clip)));
        }
        assert_eq!(single(&DMat4::ZERO).0, [[0.0; 4]; 4]);
    }
}
