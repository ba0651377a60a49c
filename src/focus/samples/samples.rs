//! Samples of what a camera sees: points with normals, whether they are in shadow, and where the shadows' edges are.
//!
//! Plain data made by whoever has a renderer, so that techniques stay pure functions. Source: Chong, Gortler 2007
//! `[chong2007]` (scene-optimized shadow maps: samples near shadow edges); Lauritzen, Salvi, Lefohn 2010 `[lauritzen2010]`
//! (sample distribution shadow maps); theory.md 9, 10.1 to 10.3 and 12.1.

use std::sync::Arc;

use glam::DVec3;

use super::edges::{EdgeSample, NO_SAMPLE, edges_of, thinned};
use super::outline::{Outline, RayFrame};
use super::picture::Picture;
use super::runs::Chosen;
use crate::error::Result;
use crate::image::{Surfaces, TruthMask};
use crate::parameterization::Region;
use crate::scene::{Camera, Light};

/// Visible surface points with their normals, in the order of the pixels they were seen in.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Samples {
    /// The world point that positions are relative to.
    pub origin: DVec3,
    /// World positions minus the origin; shared by the samples of one picture under several lights, as the normals are.
    pub points: Arc<Vec<[f32; 3]>>,
    /// Unit normals, on the side of the eye.
    pub normals: Arc<Vec<[f32; 3]>>,
    /// The picture they were seen in, where there is one.
    pub picture: Option<Picture>,
    /// Which of them are in shadow, where that is known.
    pub shadows: Option<Shadows>,
    /// Of all samples under the light of `shadows`: found once.
    outlines: Option<Outlines>,
}

/// Which samples are in shadow under one light, and where in the picture the shadows end.
#[derive(Debug, Clone, PartialEq)]
pub struct Shadows {
    /// The light.
    pub light: Light,
    /// [`TruthMask::LIT`] or [`TruthMask::SHADOW`]; other values for a sample whose state is not known.
    pub states: Vec<i8>,
    /// Samples at the edges of shadows, in an order of which every beginning is spread over the picture.
    pub edges: Vec<EdgeSample>,
    /// Samples in shadow, and their neighbours in the picture.
    pub shaded: Vec<u32>,
    /// The same states as a picture, rows from the top; empty without one.
    pub image: Vec<i8>,
}

/// Samples between two looks at whether to go on: some milliseconds of work.
pub(super) const AT_ONCE: usize = 1 << 16;

/// Samples, or pixels, that are looked at side by side.
pub(super) const TOGETHER: usize = 64;

/// Outlines of the samples that face a light, for the whole picture.
#[derive(Debug, Clone, PartialEq)]
struct Outlines {
    camera: Camera,
    depths: Option<[f64; 2]>,
    seen: Option<Outline>,
    shaded: Option<Outline>,
}

#[inline(always)]
pub(super) fn vector(v: [f32; 3]) -> DVec3 {
    // Not mapped: that is no part of a loop that is compiled for another set of instructions.
    DVec3::new(f64::from(v[0]), f64::from(v[1]), f64::from(v[2]))
}

impl Samples {
    /// Samples at points of the world, unit normals beside.
    pub fn of_points(points: &[DVec3], normals: &[DVec3]) -> Self {
        let origin = points.iter().copied().sum::<DVec3>() / points.len().max(1) as f64;
        let single = |v: DVec3| v.as_vec3().to_array();
        Self {
            origin,
            points: Arc::new(points.iter().map(|p| single(*p - origin)).collect()),
            normals: Arc::new(normals.iter().map(|n| single(*n)).collect()),
            ..Self::default()
        }
    }
    /// One sample for each pixel of the camera's picture that shows anything.
    pub fn of_surfaces(surfaces: &Surfaces, camera: &Camera) -> Self {
        // What is never told to stop cannot fail.
        Self::of_surfaces_watched(surfaces, camera, || Ok(())).unwrap_or_default()
    }
    /// The same, asking now and then whether to go on.
    ///
    /// # Errors
    /// Those of `check`.
    pub fn of_surfaces_watched(surfaces: &Surfaces, camera: &Camera, check: impl Fn() -> Result<()>) -> Result<Self> {
        let count = surfaces.triangle.iter().filter(|&&triangle| triangle >= 0).count();
        let of_seen = |of: &[[f32; 3]]| {
            let mut seen = Vec::with_capacity(count);
            for (some, triangles) in of.chunks(AT_ONCE).zip(surfaces.triangle.chunks(AT_ONCE)) {
                check()?;
                seen.extend(some.iter().zip(triangles).filter(|(_, triangle)| **triangle >= 0).map(|(v, _)| *v));
            }
            Ok(Arc::new(seen))
        };
        Ok(Self {
            origin: surfaces.origin,
            points: of_seen(surfaces.position)?,
            normals: of_seen(surfaces.normal)?,
            picture: Some(Picture::new(camera, surfaces.size)),
            ..Self::default()
        })
    }
    /// The same with what is in shadow under a light: `image` has a state for each pixel of the picture, as
    /// [`TruthMask`] has them. At most `count` samples at the shadows' edges are kept.
    pub fn with_shadows(self, light: &Light, image: Vec<i8>, surfaces: &Surfaces, count: usize) -> Self {
        // As above.
        self.with_shadows_watched(light, image, surfaces, count, || Ok(())).unwrap_or_default()
    }
    /// The same, asking now and then whether to go on.
    ///
    /// # Errors
    /// Those of `check`.
    pub fn with_shadows_watched(
        mut self,
        light: &Light,
        mut image: Vec<i8>,
        surfaces: &Surfaces,
        count: usize,
        check: impl Fn() -> Result<()>,
    ) -> Result<Self> {
        let Some(picture) = self.picture else { return Ok(self) };
        let mut states = Vec::with_capacity(self.len());
        for (some, triangles) in image.chunks(AT_ONCE).zip(surfaces.triangle.chunks(AT_ONCE)) {
            check()?;
            stretches(triangles, |pixel, _, count| states.extend_from_slice(&some[pixel..pixel + count]));
        }
        // Of what the light can reach alone: the others are dark without a look at a map.
        let facing = self.facing_watched(&picture.camera, light, &Region::ALL, &check)?;
        let mut sample_at = vec![NO_SAMPLE; image.len()];
        let (mut first, mut left) = (0, &facing[..]);
        for (some, triangles) in sample_at.chunks_mut(AT_ONCE).zip(surfaces.triangle.chunks(AT_ONCE)) {
            check()?;
            first += stretches(triangles, |pixel, sample, count| {
                let sample = first + sample;
                while let Some((&next, others)) = left.split_first()
                    && (next as usize) < sample + count
                {
                    some[pixel + next as usize - sample] = next;
                    left = others;
                }
            });
        }
        // Rays may see a surface where the picture has none.
        for (state, sample) in image.iter_mut().zip(&sample_at) {
            if *sample == NO_SAMPLE {
                *state = TruthMask::NOTHING;
            }
        }
        let (edges, shaded) = edges_of(|i| self.sample(i), &picture, &image, &sample_at, count, &check)?;
        self.outlines = self.outlines_of(light, &facing, &shaded);
        check()?;
        self.shadows = Some(Shadows { light: *light, states, edges, shaded, image });
        Ok(self)
    }
    /// Samples of an engine's own: world positions and unit normals as they are seen in a picture of a camera, and, under a
    /// light, their states and the normals of shadows' edges in the picture (zero for a sample at no edge) with weights.
    pub fn of_arrays(points: &[DVec3], normals: &[DVec3], picture: Picture) -> Self {
        Self { picture: Some(picture), ..Self::of_points(points, normals) }
    }
    /// The same with shadow states under a light and samples at shadows' edges, thinned to `count`.
    pub fn with_states(mut self, light: &Light, states: Vec<i8>, edges: &[EdgeSample], count: usize) -> Self {
        let shaded = (0..states.len()).filter(|&i| states[i] != TruthMask::LIT).map(|i| i as u32).collect();
        let edges = thinned(edges, count);
        self.shadows = Some(Shadows { light: *light, states, edges, shaded, image: Vec::new() });
        self.outlined()
    }
    /// Finds the outlines of all samples.
    pub fn outlined(mut self) -> Self {
        if let (Some(picture), Some(shadows)) = (&self.picture, &self.shadows) {
            let (camera, light) = (&picture.camera, &shadows.light);
            let (facing, shaded) =
                (self.facing(camera, light, &Region::ALL), self.shaded_of(camera, light, &Region::ALL));
            self.outlines = self.outlines_of(light, &facing, &shaded);
        }
        self
    }
    /// The same of those that face a light, and of those of them that are in shadow or beside one that is.
    fn outlines_of(&self, light: &Light, facing: &[u32], shaded: &[u32]) -> Option<Outlines> {
        let camera = self.picture?.camera;
        let rays = RayFrame::new(light, camera.eye());
        let [facing, shaded] = [facing, shaded].map(|indices| self.of_indices(indices, camera.eye()));
        let depths = depths_of(&camera, &facing);
        let [seen, shaded] = [facing, shaded].map(|chosen| Outline::of(rays?, &chosen));
        Some(Outlines { camera, depths, seen, shaded })
    }
    /// The samples at shadows' edges; where none is known, some of all samples, evenly chosen, with zero normals.
    pub fn chosen(&self) -> Vec<EdgeSample> {
        match self.shadows.as_ref().map(|shadows| &shadows.edges).filter(|edges| !edges.is_empty()) {
            Some(edges) => edges.clone(),
            None => {
                let all = |i: usize| EdgeSample { sample: i as u32, normal: [0.0; 2], weight: 1.0 };
                thinned(&(0..self.len()).map(all).collect::<Vec<_>>(), MOST_CHOSEN)
            }
        }
    }
    /// How many there are.
    pub fn len(&self) -> usize {
        self.points.len()
    }
    /// Whether nothing is seen.
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }
    /// World position and normal of a sample.
    pub fn sample(&self, i: usize) -> (DVec3, DVec3) {
        (self.origin + vector(self.points[i]), vector(self.normals[i]))
    }
    /// World positions.
    pub fn positions(&self) -> impl Iterator<Item = DVec3> + Clone + '_ {
        self.points.iter().map(|p| self.origin + vector(*p))
    }
    /// Of the samples in shadow and their neighbours those that a map for a part of a view has to answer for.
    fn shaded_of(&self, camera: &Camera, light: &Light, region: &Region) -> Vec<u32> {
        let shaded = self.shadows.iter().flat_map(|shadows| shadows.shaded.iter().copied());
        shaded.filter(|&i| self.counts_at(i, camera, light, region)).collect()
    }
    /// The outline of the samples that a map for a part of a view has to answer for; nothing where there is none.
    pub fn outline(&self, camera: &Camera, light: &Light, region: &Region) -> Option<Outline> {
        match self.known(camera, light, region) {
            Some(known) => known.seen.clone(),
            None => self.outline_of(camera, light, &self.facing(camera, light, region)),
        }
    }
    /// The same of those in shadow and their neighbours in the picture.
    pub fn shaded_outline(&self, camera: &Camera, light: &Light, region: &Region) -> Option<Outline> {
        match self.known(camera, light, region) {
            Some(known) => known.shaded.clone(),
            None => self.outline_of(camera, light, &self.shaded_of(camera, light, region)),
        }
    }
    fn known(&self, camera: &Camera, light: &Light, region: &Region) -> Option<&Outlines> {
        let whole = region.functionals().is_empty() && self.shadows.as_ref().is_some_and(|s| s.light == *light);
        // A far plane in place of an infinite one changes nothing where it is behind all samples.
        let is_same = |known: &Outlines| {
            let behind = known.depths.is_none_or(|depths| depths[1] <= camera.far());
            let far = if known.camera.far().is_finite() || !behind { known.camera.far() } else { camera.far() };
            known.camera.with_depths(known.camera.near(), far).is_ok_and(|known| known == *camera)
        };
        self.outlines.as_ref().filter(|known| whole && is_same(known))
    }
    fn of_indices<'a>(&'a self, indices: &'a [u32], eye: DVec3) -> Chosen<'a> {
        Chosen::new([&self.points, &self.normals], indices, self.picture.as_ref(), self.origin - eye)
    }
    fn outline_of(&self, camera: &Camera, light: &Light, indices: &[u32]) -> Option<Outline> {
        Outline::of(RayFrame::new(light, camera.eye())?, &self.of_indices(indices, camera.eye()))
    }
    /// How far from their surfaces they lie at most, world units.
    pub fn rounding(&self) -> f64 {
        let far = self.points.iter().map(|p| vector(*p).length_squared()).fold(0.0, f64::max);
        rounding_at(far.sqrt())
    }
    /// Near and far camera depth of the samples that face a light, out to the corners of their pixels and within the camera's
    /// planes; nothing where none does.
    pub fn depths(&self, camera: &Camera, light: &Light, region: &Region) -> Option<[f64; 2]> {
        match self.known(camera, light, region) {
            Some(known) => known.depths,
            None => depths_of(camera, &self.of_indices(&self.facing(camera, light, region), camera.eye())),
        }
    }
}

/// Calls `visit` with runs of pixels that all show something: the first, the number of those before it that do, and how many; the
/// number of all. Mostly all of many pixels do.
fn stretches(triangles: &[i32], mut visit: impl FnMut(usize, usize, usize)) -> usize {
    let mut before = 0;
    for (first, some) in (0..).step_by(TOGETHER).zip(triangles.chunks(TOGETHER)) {
        // The sign of any.
        if some.iter().fold(0, |all, triangle| all | triangle) >= 0 {
            visit(first, before, some.len());
            before += some.len();
            continue;
        }
        for (pixel, _) in (first..).zip(some).filter(|(_, triangle)| **triangle >= 0) {
            visit(pixel, before, 1);
            before += 1;
        }
    }
    before
}

/// How far from its surface a position lies at most, which is f32 relative to an origin so far away.
fn rounding_at(distance: f64) -> f64 {
    f64::from(f32::EPSILON) * distance
}

/// Near and far camera depth of samples, out to the corners of their pixels and within the camera's planes; nothing without any.
fn depths_of(camera: &Camera, chosen: &Chosen) -> Option<[f64; 2]> {
    let forward = camera.forward();
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for run in &chosen.runs {
        let picture = chosen.picture;
        let [near, far] = picture.map_or_else(|| run.range(forward), |picture| run.depths(picture));
        if near >= range[0] && far <= range[1] {
            continue;
        }
        for (p, n) in chosen.of_run(run) {
            let [near, far] = picture.map_or_else(|| [forward.dot(p); 2], |picture| picture.depths(p, n));
            range = [range[0].min(near), range[1].max(far)];
        }
    }
    // Surfaces lie up to a step before or behind.
    let step = rounding_at(chosen.farthest_from_origin());
    let ends = [range[0] - step, range[1] + step].map(|depth| depth.clamp(camera.near(), camera.far()));
    (range[0] <= range[1]).then_some(ends)
}

/// Samples that are shown where none lies at an edge.
const MOST_CHOSEN: usize = 4096;
