//! The bodies of a view: K, where receivers can be seen and lit, and B, where their casters can be.
//!
//! Source: theory.md 1.1 and 1.2; Wimmer, Scherzer, Purgathofer 2004 `[wimmer2004]`, section 5; Scherzer 2005
//! `[scherzer2005]`, Wimmer and Scherzer 2006 `[wimmer2006]` (robust shadow maps). (1.1): K = V ∩ S (∩ Lf) and
//! B = conv(K ∪ light) ∩ S (∩ Lf), with V the camera's frustum, S the box of the scene and Lf the
//! pyramid around a spot's cone. Departure: the bodies are cut exactly from the box, no hull of points is built, so a
//! flat scene has a flat K and needs no padding here.
//!
//! Everything is told relative to the eye, so that coordinates as of UTM cost no digits.

use glam::{DVec3, DVec4};

use super::samples::Outline;
use crate::geometry::{Aabb, ConvexBody, Frustum, Plane, Rows, Sides};
use crate::parameterization::Region;
use crate::rays::{LightFrame, LightRays};
use crate::scene::{Camera, Light, Scene, SpotLight};

/// What a map is made to cover.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Focus {
    /// The whole scene's box, whatever the camera sees.
    Scene,
    /// The camera's frustum, whatever is in it.
    Frustum,
    /// What the camera can see of the scene: K, tightened to the instances' boxes.
    SceneFit,
}

/// Whether there is anything to cover.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Coverage {
    /// The body is what [`Focus`] asked for.
    AsAsked,
    /// No part of the scene is seen and lit; the body is the lit part of the whole scene, or the light's own frustum.
    NothingSeen,
}

/// A spot's map begins at this share of its reach where a caster's box is nearer. Derived from float32 depth: with near at
/// 2^-12 of far, one step of 2^-24 at the far end is 2^-12 of the distance; nearer still and far receivers lose their depth.
pub const NEAREST_SHARE_OF_REACH: f64 = 1.0 / 4096.0;

/// What a map must cover: plain data, relative to a local origin.
#[derive(Debug, Clone, Copy)]
pub struct FocusedView<'a> {
    /// The local origin, world: the eye where anything is seen.
    pub origin: DVec3,
    /// The eye, local.
    pub eye: DVec3,
    /// The camera; an infinite far plane is moved to the end of the scene.
    pub camera: Camera,
    /// The light.
    pub light: Light,
    /// The light's rays, local.
    pub rays: LightRays,
    /// K, the receivers' body, local.
    pub receivers: ConvexBody,
    /// Near and far camera depth of the receivers' body.
    pub eye_depth: [f64; 2],
    /// The scene's box, local.
    pub scene_box: Aabb,
    /// What was asked for.
    pub focus: Focus,
    /// What came of it.
    pub coverage: Coverage,
    /// The rays that a map must hold, where samples say so instead of the body.
    pub outline: Option<&'a Outline>,
    camera_planes: [Plane; 6],
    light_planes: Option<[Plane; 6]>,
    region_planes: [Plane; Region::MOST],
    region_count: usize,
}

/// The frame, pyramid and reach of a spot light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpotFrustum {
    /// Its frame; depends on the light only.
    pub frame: LightFrame,
    /// The pyramid around the cone, cut at the reach.
    pub frustum: Frustum,
}

impl SpotFrustum {
    /// The pyramid around a spot's cone: as far as its range or the scene's farthest point, from
    /// [`NEAREST_SHARE_OF_REACH`] of that on.
    pub fn new(spot: &SpotLight, origin: DVec3, scene_box: &Aabb) -> Self {
        let frame = LightFrame::any(spot.direction());
        let apex = spot.position() - origin;
        let deepest = scene_box.corners().iter().fold(0.0, |m: f64, p| m.max((*p - apex).dot(frame.along)));
        // Derived from f64: the near plane must lie apart from the light in coordinates of this size.
        let least = f64::EPSILON / NEAREST_SHARE_OF_REACH * (apex.length() + scene_box.diagonal());
        let far = if deepest > least { spot.range().min(deepest) } else { spot.range() };
        let tan_half = (0.5 * spot.cone_angle()).tan();
        let near = far * NEAREST_SHARE_OF_REACH;
        let LightFrame { right, up, along: forward } = frame;
        let (half, center) = ([tan_half; 2], [0.0; 2]);
        let frustum = Frustum { apex, right, up, forward, sides: Sides::Converging, half, center, near, far };
        Self { frame, frustum }
    }
    /// The light's perspective between two depths along the axis; at least one part in 1024 of `far` thick, so that a wall
    /// across the axis has a depth.
    pub fn perspective(&self, near: f64, far: f64) -> Rows {
        let near = near.min(far * (1.0 - 1.0 / 1024.0)).max(self.frustum.near.min(0.5 * far));
        self.frame.perspective(self.frustum.apex, self.frustum.half[0], near, far)
    }
    /// Depth along the axis as a functional of (p, 1).
    pub fn depth(&self) -> DVec4 {
        self.frame.along.extend(-self.frame.along.dot(self.frustum.apex))
    }
}

impl<'a> FocusedView<'a> {
    /// The bodies for a scene, a camera and a light.
    pub fn new(scene: &Scene, camera: &Camera, light: &Light, focus: Focus) -> Self {
        let mut view = Self::uncut(scene, camera, light, focus);
        view.cut(scene);
        view
    }
    /// The view before [`FocusedView::cut`], which cuts its body where it stands: [`FocusedView::new`] moves kilobytes.
    #[inline(always)]
    pub(crate) fn uncut(scene: &Scene, camera: &Camera, light: &Light, focus: Focus) -> Self {
        Self::bare(scene, camera, light, focus, if focus == Focus::Scene { scene.origin() } else { camera.eye() })
    }
    /// Makes the receivers' body of a view without one.
    pub(crate) fn cut(&mut self, scene: &Scene) {
        self.receivers.become_aabb(&self.scene_box);
        match self.focus {
            Focus::Scene => return self.keep_lit(),
            Focus::Frustum => self.receivers = self.camera_frustum().body(),
            Focus::SceneFit => self.camera_planes.iter().for_each(|plane| self.receivers.clip(plane)),
        }
        self.light_planes.iter().flatten().for_each(|plane| self.receivers.clip(plane));
        if self.receivers.is_empty() {
            *self = Self::around(scene, &self.camera, &self.light, self.focus);
        } else {
            self.eye_depth = self.receivers_depth();
        }
    }
    /// Makes it the view of only those receivers of `scene` on some of the light's rays (told in world space).
    pub fn restrict(&mut self, scene: &Scene, region: &Region) {
        if region.functionals().is_empty() || self.coverage == Coverage::NothingSeen {
            return;
        }
        for f in region.functionals() {
            let local = f.truncate().extend(f.dot(self.origin.extend(1.0)));
            let Some(plane) = Plane::where_positive(local) else { continue };
            self.receivers.clip(&plane);
            self.region_planes[self.region_count] = plane;
            self.region_count += 1;
        }
        if self.receivers.is_empty() {
            *self = Self::around(scene, &self.camera, &self.light, self.focus);
            return;
        }
        if self.focus != Focus::Scene {
            self.eye_depth = self.receivers_depth();
        }
    }
    /// The same view of only those receivers on some of the light's rays: [`FocusedView::restrict`].
    pub fn restricted(mut self, scene: &Scene, region: &Region) -> Self {
        self.restrict(scene, region);
        self
    }
    /// Makes maps hold an outline of samples instead of the body.
    pub fn hold(&mut self, outline: Option<&'a Outline>) {
        if self.coverage == Coverage::AsAsked {
            self.outline = outline;
        }
    }
    /// All that the light shines on along the view's rays, whatever the camera sees: where receivers can come into view.
    pub fn reachable(&self) -> ConvexBody {
        let mut body = ConvexBody::from_aabb(&self.scene_box);
        for plane in self.light_planes.iter().flatten().chain(&self.region_planes[..self.region_count]) {
            body.clip(plane);
        }
        body
    }
    /// A point that every map of the view holds.
    pub fn middle(&self) -> DVec3 {
        self.outline.map_or_else(|| self.receivers.vertex_mean(), |outline| outline.middle)
    }
    /// Near and far camera depth of the receivers' body.
    fn receivers_depth(&self) -> [f64; 2] {
        let forward = self.camera.forward();
        let (near, far) = self.receivers.range(forward.extend(-forward.dot(self.eye)));
        // The frustum's own planes, up to rounding: a split scheme may divide by the near depth.
        [near, far].map(|depth| depth.clamp(self.camera.near(), self.camera.far()))
    }
    /// The view of a camera that sees nothing: the whole scene as far as the light shines on it, relative to the scene's
    /// middle.
    fn around(scene: &Scene, camera: &Camera, light: &Light, focus: Focus) -> Self {
        let mut view = Self::bare(scene, camera, light, focus, scene.origin());
        view.coverage = Coverage::NothingSeen;
        view.receivers.become_aabb(&view.scene_box);
        view.keep_lit();
        view
    }
    /// Keeps of the scene's box what the light shines on.
    fn keep_lit(&mut self) {
        self.light_planes.iter().flatten().for_each(|plane| self.receivers.clip(plane));
        if self.receivers.is_empty() {
            self.coverage = Coverage::NothingSeen;
            self.receivers = match self.spot() {
                // Nothing is lit, so no point is owed a map; the pyramid of a nearly flat cone has no depth to its width.
                Some(spot) => Frustum { half: spot.frustum.half.map(|t| t.min(1.0)), ..spot.frustum }.body(),
                None => ConvexBody::from_aabb(&self.scene_box),
            };
        }
    }
    #[inline(always)]
    fn bare(scene: &Scene, camera: &Camera, light: &Light, focus: Focus, origin: DVec3) -> Self {
        let scene_box = Aabb { min: scene.bounds().min - origin, max: scene.bounds().max - origin };
        let camera = &camera.bounded(scene.bounds());
        let eye = camera.eye() - origin;
        let light_planes = match light {
            Light::Spot(spot) => Some(SpotFrustum::new(spot, origin, &scene_box).frustum.planes()),
            _ => None,
        };
        Self {
            origin,
            eye,
            camera: *camera,
            light: *light,
            rays: LightRays::new(light, origin),
            receivers: ConvexBody::BLANK,
            eye_depth: [camera.near(), camera.far()],
            scene_box,
            focus,
            coverage: Coverage::AsAsked,
            outline: None,
            camera_planes: camera.frustum_at(eye).planes(),
            light_planes,
            region_planes: [Plane { normal: DVec3::ZERO, offset: 0.0 }; Region::MOST],
            region_count: 0,
        }
    }
    /// The camera's frustum, local.
    pub fn camera_frustum(&self) -> Frustum {
        self.camera.frustum_at(self.eye)
    }
    /// The spot light's pyramid, local; nothing for other lights.
    pub fn spot(&self) -> Option<SpotFrustum> {
        match &self.light {
            Light::Spot(spot) => Some(SpotFrustum::new(spot, self.origin, &self.scene_box)),
            _ => None,
        }
    }
    /// The half-spaces that receivers lie in beside the scene's box.
    pub fn receiver_planes(&self) -> impl Iterator<Item = &Plane> {
        let by_camera = self.focus != Focus::Scene && self.coverage == Coverage::AsAsked;
        let camera = by_camera.then_some(&self.camera_planes).into_iter().flatten();
        let region = &self.region_planes[..self.region_count];
        camera.chain(self.light_planes.iter().flatten()).chain(region)
    }
    /// The six half-spaces of the light's pyramid, for a spot.
    pub fn light_planes(&self) -> Option<&[Plane; 6]> {
        self.light_planes.as_ref()
    }
    /// The six half-spaces of the scene's box.
    pub fn scene_planes(&self) -> [Plane; 6] {
        let Aabb { min, max } = self.scene_box;
        let plane = |normal: DVec3, p: DVec3| Plane::through(p, normal);
        [
            plane(DVec3::NEG_X, min),
            plane(DVec3::X, max),
            plane(DVec3::NEG_Y, min),
            plane(DVec3::Y, max),
            plane(DVec3::NEG_Z, min),
            plane(DVec3::Z, max),
        ]
    }
    /// B of (1.1), the casters' body: all points of the scene from which light can go on to a receiver in K.
    pub fn casters(&self) -> ConvexBody {
        let mut body = match self.light {
            // K lies in the scene's box, so twice the diagonal leaves it whatever the direction.
            Light::Directional(l) => self.receivers.swept_against(l.direction(), 2.0 * self.scene_box.diagonal()),
            Light::Spot(_) | Light::Point(_) => self.receivers.hull_with(self.rays.point.truncate()),
        };
        for plane in self.scene_planes().iter().chain(self.light_planes.iter().flatten()) {
            body.clip(plane);
        }
        // Only a body in the scene's border plane, by rounding.
        if body.is_empty() { self.receivers } else { body }
    }
    /// Smallest and largest place along a unit direction of B under light that travels along it.
    pub fn casters_along(&self, direction: DVec3) -> [f64; 2] {
        if self.focus == Focus::Frustum {
            // The frustum may reach beyond the scene's box, where a body that stays in it has no closed form.
            let (low, high) = self.casters().range(direction.extend(0.0));
            return [low, high];
        }
        [self.receivers.least_entry(direction, &self.scene_box), self.receivers.range(direction.extend(0.0)).1]
    }
    /// The unit vector from the eye to the middle of a body's vertices (theory.md 5.3); the view direction where
    /// the sum vanishes, and of parallel rays.
    pub fn middle_vector(&self, vertices: &[DVec3]) -> DVec3 {
        let sum: DVec3 = vertices.iter().map(|p| self.camera.way_to(*p - self.eye)).sum();
        sum.try_normalize().unwrap_or(self.camera.forward())
    }
}
