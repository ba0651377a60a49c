//! The shadow lookup of one receiver: where it lies in a map, and which depth is compared there.
//!
//! Source: theory.md 0 (light rays, texture coordinates), 13 (constant world bias, receiver-plane bias), 14 (comparisons are
//! averaged, never depths): projected.rs, comparison.rs and filtered.rs. The WGSL twin follows [`MapLookup::compare_at`] and
//! [`MapLookup::light`] step by step; what is f64 here may be f32 there, because the matrix is folded with the scene's origin
//! before it is rounded.
//!
//! Spaces: *relative* is world minus the scene's origin (what a G-buffer stores). *texel* is the map in texels, x to the
//! right, y down, texel (i, j) covering [i, i+1) x [j, j+1).

use glam::{DMat4, DVec3, DVec4};

use super::parts::Parts;
use super::warped::{Warped, ln_w};
use crate::aliasing::texel::Eye;
use crate::error::{Error, Result};
use crate::parameterization::{Held, Parameterization, Partition, PostWarp, Region};
use crate::render::stored::DepthMeasure;
use crate::render::{Bias, Filter, Kernels, MaskSettings, Stored, check_blend};
use crate::scene::{Camera, Light};

/// What a lookup needs to know of one map, its light and its settings.
#[derive(Debug, Clone)]
pub struct MapLookup {
    /// Rows x, y, z, w of `shadow_clip_from_relative`.
    pub(super) rows: [DVec4; 4],
    /// What stored depths measure, in relative space; z / w of the rows where depth is projective.
    pub(super) depth: DepthMeasure,
    pub(super) stored: Stored,
    /// Width and height of the map, texels.
    pub(super) size: [u32; 2],
    /// The light's centre in relative space: (unit vector to the light, 0) or (position, 1).
    pub(super) light: DVec4,
    pub(super) bias: Bias,
    pub(super) kernels: Kernels,
    pub(super) post_warp: PostWarp,
    /// Of a logarithm and a kernel in texels, how much depth falls over its reach along y, in units of what its slope there says:
    /// where it rises with w, and where it falls.
    pub(super) bend: [f64; 2],
    /// Which of the settings are in use.
    pub(super) parts: Parts,
    /// In relative space.
    pub(super) region: Region,
}

/// The lookups into all maps of a parameterization, and which of them serves a receiver.
#[derive(Debug, Clone)]
pub struct Lookups<'a> {
    pub(super) p: &'a Parameterization,
    maps: Vec<MapLookup>,
    pub(super) blend: f64,
}

impl MapLookup {
    /// The lookup into the map of `partition`, `size` texels wide and high, for receivers relative to `origin`.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a matrix that is not finite, an unusable bias, an unusable filter or one in pixels, which
    /// takes a picture ([`Lookups::new`]), and a map that has no linear depth.
    pub fn new(
        partition: &Partition,
        light: &Light,
        origin: DVec3,
        size: [u32; 2],
        bias: Bias,
        filter: Filter,
        stored: Stored,
    ) -> Result<Self> {
        Self::with_kernels(partition, light, origin, size, bias, Kernels::new(filter, None)?, stored)
    }

    fn with_kernels(
        partition: &Partition,
        light: &Light,
        origin: DVec3,
        size: [u32; 2],
        bias: Bias,
        kernels: Kernels,
        stored: Stored,
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
        let (bias, stored) = (bias.checked()?, stored.checked()?);
        let depth = DepthMeasure::new(&clip_from_relative, &post_warp, stored.spacing)?;
        let (parts, bend) = (Parts::of(light, &bias, &kernels, &stored), [1.0; 2]);
        let mut lookup = Self { rows, depth, stored, size, light, bias, kernels, post_warp, bend, parts, region };
        if let Some(kernel) = lookup.kernels.fixed() {
            lookup.bend = lookup.bend_over(kernel.reach().y);
        }
        Ok(lookup)
    }

    /// How much depth falls over a reach along y, texels: see the field.
    pub(super) fn bend_over(&self, reach: f64) -> [f64; 2] {
        bend(&self.post_warp, reach * 2.0 / f64::from(self.size[1]))
    }

    /// How the map holds a receiver, `p` relative to the origin.
    pub fn holds(&self, p: DVec3) -> Held {
        if !self.region.contains(p) {
            return Held::Outside;
        }
        self.holds_by(self.warped_at(p), p)
    }
    /// The post-warp at a receiver.
    #[inline(always)]
    pub(super) fn warped_at(&self, p: DVec3) -> Warped<'_> {
        match &self.post_warp {
            PostWarp::None => Warped::None,
            &PostWarp::Log { scale, offset } => Warped::Log { scale, offset, ln_w: ln_w(self.rows[3], p) },
            PostWarp::Rectilinear(warp) => Warped::Rectilinear(warp),
        }
    }
    /// How a map with all rays holds a receiver; its post-warp is given for kernels that know it.
    #[inline(always)]
    pub(super) fn holds_by(&self, warped: Warped, p: DVec3) -> Held {
        let [x, y, z, w] = self.rows.map(|row| row.dot(p.extend(1.0)));
        Held::of(warped.apply(DVec3::new(x, y, z) / w), w)
    }

    /// How far a receiver lies from the map's middle towards its nearest edge: 1 at the edge.
    pub(super) fn way_from_middle(&self, p: DVec3) -> f64 {
        let [x, y, _, w] = self.rows.map(|row| row.dot(p.extend(1.0)));
        let ndc = self.post_warp.apply(DVec3::new(x, y, 0.0) / w, w);
        ndc.x.abs().max(ndc.y.abs())
    }
}

impl<'a> Lookups<'a> {
    /// The lookups of receivers relative to `origin`, in a picture of `settings.size` pixels.
    ///
    /// # Errors
    /// As [`MapLookup::new`].
    pub fn new(
        p: &'a Parameterization,
        camera: &Camera,
        light: &Light,
        origin: DVec3,
        settings: &MaskSettings,
    ) -> Result<Self> {
        let MaskSettings { resolution, size, bias, filter, stored, blend } = *settings;
        let kernels = Kernels::new(filter, Some(Eye::new(camera, origin, size)))?;
        let one =
            |partition| MapLookup::with_kernels(partition, light, origin, resolution, bias, kernels.clone(), stored);
        Ok(Self { p, maps: p.partitions.iter().map(one).collect::<Result<_>>()?, blend: check_blend(blend)? })
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
