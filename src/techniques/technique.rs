//! The shape of a technique, and what all of them share: bodies before the warp, the fit after it.
//!
//! ```text
//! scene, camera, light -> FocusedView -> Warp::warp -> fit to the unit cube or the stable grid -> Parameterization
//! ```

use std::fmt::Debug;

use glam::DVec4;

use super::{Settings, Spec};
use crate::error::{Error, Result};
use crate::focus::{Coverage, Focus, FocusedView, MapSize, fit, scene_depth, stable_grid};
use crate::geometry::Rows;
use crate::parameterization::{Parameterization, Partition, PostWarp, Value};
use crate::scene::{Camera, Light, Scene};

/// A technique with its settings: a pure function from a view to a [`Parameterization`].
pub trait Technique: Debug + Send + Sync {
    /// What it says of itself.
    fn spec(&self) -> &'static Spec;
    /// Every parameter with its value, in the order of the spec.
    fn settings(&self) -> Vec<(&'static str, Value)>;
    /// The maps for one scene, camera and light, made for `resolution` texels along each side.
    ///
    /// # Errors
    /// [`Error::UnsupportedLight`]; [`Error::InvalidArgument`] for a resolution that leaves no texel inside the border.
    fn parameterize(&self, scene: &Scene, camera: &Camera, light: &Light, resolution: u32) -> Result<Parameterization>;
}

/// What a technique's file holds beside its spec: the warp itself, with its settings read.
pub trait Warp: Debug + Send + Sync {
    /// The provisional map of a view; the fit crops it.
    fn warp(&self, view: &FocusedView, scene: &Scene) -> Provisional;
    /// What the map is made to cover.
    fn focus(&self) -> Focus {
        Focus::SceneFit
    }
    /// How the provisional map is brought to the unit cube.
    fn fitting(&self) -> Fitting {
        Fitting::UnitCube
    }
    /// Numbers that are known only once the map is fitted: `clip_from_local` is.
    fn values_of_fit(&self, _view: &FocusedView, _clip_from_local: &Rows, _size: &MapSize) -> Vec<Named> {
        Vec::new()
    }
}

/// A number with its name.
pub type Named = (&'static str, f64);

/// What a warp makes of a view.
#[derive(Debug, Clone, PartialEq)]
pub struct Provisional {
    /// From the view's local space: a shadow map's rows (theory.md 0.1) with w > 0 on the receivers' body.
    pub clip_from_local: Rows,
    /// Intermediate numbers.
    pub values: Vec<Named>,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// How a provisional map is brought to the unit cube.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fitting {
    /// As tightly as receivers and casters allow.
    UnitCube,
    /// So that texels stand still in the world while the camera moves. Only a map without a warp can: the grid replaces it.
    StableGrid,
}

/// A warp with the focusing and fitting around it.
#[derive(Debug)]
pub(super) struct Focused {
    pub spec: &'static Spec,
    pub settings: Settings,
    pub warp: Box<dyn Warp>,
}

impl Technique for Focused {
    fn spec(&self) -> &'static Spec {
        self.spec
    }
    fn settings(&self) -> Vec<(&'static str, Value)> {
        self.settings.values().to_vec()
    }
    fn parameterize(&self, scene: &Scene, camera: &Camera, light: &Light, resolution: u32) -> Result<Parameterization> {
        check_light(self.spec, light)?;
        let size = MapSize::new(resolution)?;
        let map = self.map(scene, camera, light, &size);
        Ok(Parameterization {
            technique: self.spec.name.to_string(),
            settings: self.settings(),
            partitions: vec![map.partition],
            resolution: size.resolution,
            border_texels: size.border,
            values: map.values,
            notes: map.notes,
        })
    }
}

/// One map of a technique.
struct Map {
    partition: Partition,
    values: Vec<Named>,
    notes: Vec<String>,
}

impl Focused {
    /// The map for all that a camera sees between its near and far planes.
    fn map(&self, scene: &Scene, camera: &Camera, light: &Light, size: &MapSize) -> Map {
        match (self.warp.fitting(), self.warp.focus(), light) {
            (Fitting::UnitCube, focus, _) => self.fitted(&FocusedView::new(scene, camera, light, focus), scene, size),
            (Fitting::StableGrid, Focus::Frustum | Focus::SceneFit, Light::Directional(directional)) => {
                let along = directional.direction();
                let grid = stable_grid(camera, along, scene_depth(scene.bounds(), along), size);
                let values = vec![("texel_x", grid.texel), ("texel_y", grid.texel), ("radius", grid.radius)];
                let view = FocusedView::new(scene, camera, light, Focus::Scene);
                finished(&view, &grid.clip_from_world, values, Vec::new())
            }
            // Made without the camera, it stands still by itself.
            (Fitting::StableGrid, ..) => {
                let mut map = self.fitted(&FocusedView::new(scene, camera, light, Focus::Scene), scene, size);
                let note = "stable: the map covers all that the light reaches, whatever the camera sees";
                map.notes.push(note.to_string());
                map
            }
        }
    }
    fn fitted(&self, view: &FocusedView, scene: &Scene, size: &MapSize) -> Map {
        let Provisional { clip_from_local, mut values, notes } = self.warp.warp(view, scene);
        let rows = fit(&clip_from_local, view, scene, size);
        values.extend(self.warp.values_of_fit(view, &rows, size));
        finished(view, &rows.moved_to_world(view.origin), values, notes)
    }
}

/// A map with the notes every technique owes.
fn finished(view: &FocusedView, clip_from_world: &Rows, values: Vec<Named>, mut notes: Vec<String>) -> Map {
    if view.coverage == Coverage::NothingSeen {
        let lit = if view.spot().is_some() { " that the light reaches" } else { "" };
        notes.insert(0, format!("the camera sees no part of the scene{lit}: the map covers what the light can reach"));
    }
    let partition = Partition {
        shadow_clip_from_world: through_light(clip_from_world, &view.light).matrix(),
        post_warp: PostWarp::None,
        eye_depth: view.eye_depth,
    };
    Map { partition, values, notes }
}

/// The same rows with x, y and w exactly zero at a placed light (theory.md 0.1), where the way through local coordinates
/// left the rounding of the translation.
fn through_light(rows: &Rows, light: &Light) -> Rows {
    let p = light.point();
    if p.w == 0.0 {
        return *rows;
    }
    let row = |r: DVec4| r.truncate().extend(-r.truncate().dot(p.truncate()));
    Rows { x: row(rows.x), y: row(rows.y), z: rows.z, w: row(rows.w) }
}

/// An error unless the technique serves the light.
fn check_light(spec: &Spec, light: &Light) -> Result<()> {
    if spec.lights.serves(light) {
        return Ok(());
    }
    Err(Error::UnsupportedLight {
        technique: spec.name.to_string(),
        light: light.kind().into(),
        supported: spec.lights.names().into(),
    })
}
