//! The shape of a technique, and what all of them share: bodies before the warp, the fit after it.
//!
//! ```text
//! scene, camera, light -> FocusedView -> Warp::warp -> fit to the unit cube or the stable grid -> one map
//! one map, or several of a scheme that divides the view, or the six of a point light -> Parameterization
//! ```

use std::fmt::Debug;

use glam::{DVec3, DVec4};

use super::notes::gathered;
use super::{Settings, Spec};
use crate::error::{Error, Result};
use crate::focus::{
    Coverage, Focus, FocusedView, MapSize, ReceiverSamples, Tightening, fit, fit_logarithmic, scene_depth, stable_grid,
};
use crate::geometry::Rows;
use crate::parameterization::{Parameterization, Partition, PostWarp, Region, Selection, Value};
use crate::scene::{Camera, Light, PointLight, Scene, SpotLight};

/// A technique with its settings: a pure function from a view to a [`Parameterization`].
pub trait Technique: Debug + Send + Sync {
    /// What it says of itself.
    fn spec(&self) -> &'static Spec;
    /// Every parameter with its value, in the order of the spec.
    fn settings(&self) -> Vec<(&'static str, Value)>;
    /// Whether it looks at receivers: [`Part::samples`] must be there.
    fn needs_samples(&self) -> bool {
        false
    }
    /// The maps for a part of a view; the light is none that [`Technique::serves`] refuses, and no point light unless the
    /// technique makes its faces itself.
    ///
    /// # Errors
    /// [`Error::UnsuitedView`] for a view that the technique cannot serve.
    fn maps(&self, part: &Part) -> Result<Maps>;
    /// An error unless the technique serves the light.
    ///
    /// # Errors
    /// [`Error::UnsupportedLight`].
    fn serves(&self, light: &Light) -> Result<()> {
        let spec = self.spec();
        if spec.lights.serves(light) {
            return Ok(());
        }
        Err(Error::UnsupportedLight {
            technique: spec.name.to_string(),
            light: light.kind().into(),
            supported: spec.lights.names().into(),
        })
    }
    /// The maps for one scene, camera and light, made for `resolution` texels along each side, by a technique that needs no
    /// samples.
    ///
    /// # Errors
    /// As [`Technique::parameterize_seen`].
    fn parameterize(&self, scene: &Scene, camera: &Camera, light: &Light, resolution: u32) -> Result<Parameterization> {
        self.parameterize_seen(scene, camera, light, resolution, None)
    }
    /// The maps for one scene, camera and light, made for `resolution` texels along each side; `samples` of what the camera
    /// sees are used by techniques that [need them](Technique::needs_samples).
    ///
    /// # Errors
    /// [`Error::UnsupportedLight`]; [`Error::UnsuitedView`]; [`Error::InvalidArgument`] for a resolution that leaves no texel
    /// inside the border, or for missing samples.
    fn parameterize_seen(
        &self,
        scene: &Scene,
        camera: &Camera,
        light: &Light,
        resolution: u32,
        samples: Option<&ReceiverSamples>,
    ) -> Result<Parameterization> {
        self.serves(light)?;
        let size = MapSize::new(resolution)?;
        if self.needs_samples() && samples.is_none() {
            let fix = "render a small G-buffer of the view and hand over its samples";
            return Err(Error::argument("samples", "samples of what the camera sees", "none", fix));
        }
        let part = Part { scene, camera: *camera, light: *light, size, samples, region: Region::ALL };
        let Maps { maps, selection, mut notes } = match light {
            Light::Point(point) => faces_of(self, &part, point)?,
            _ => self.maps(&part)?,
        };
        notes.extend(gathered(maps.iter().map(|map| map.notes.as_slice())));
        let partitions = maps.into_iter().map(|map| map.partition).collect();
        Ok(Parameterization {
            technique: self.spec().name.to_string(),
            settings: self.settings(),
            partitions,
            selection,
            resolution: size.resolution,
            border_texels: size.border,
            notes,
        })
    }
}

/// What maps are made of: a view, or a part of one.
#[derive(Debug, Clone, Copy)]
pub struct Part<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The camera; its near and far planes bound the part.
    pub camera: Camera,
    /// The light.
    pub light: Light,
    /// Texels and border of each map.
    pub size: MapSize,
    /// What the camera sees, where the technique needs it.
    pub samples: Option<&'a ReceiverSamples>,
    /// The rays that the part is about.
    pub region: Region,
}

/// The maps of a part of a view.
#[derive(Debug, Clone, PartialEq)]
pub struct Maps {
    /// Nearest first; at least one.
    pub maps: Vec<Map>,
    /// How a receiver finds its map.
    pub selection: Selection,
    /// What the user should know of all of them.
    pub notes: Vec<String>,
}

/// One map with what there is to say of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Map {
    /// The map.
    pub partition: Partition,
    /// What the user should know.
    pub notes: Vec<String>,
}

/// What a warping technique's file holds beside its spec: the warp itself, with its settings read.
pub trait Warp: Debug + Send + Sync {
    /// The provisional map of a view; the fit crops it.
    ///
    /// # Errors
    /// [`Error::UnsuitedView`] for a view that the technique cannot serve.
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional>;
    /// Whether it looks at [`Part::samples`].
    fn needs_samples(&self) -> bool {
        false
    }
    /// What the map is made to cover.
    fn focus(&self) -> Focus {
        Focus::SceneFit
    }
    /// How the provisional map is brought to the unit cube.
    fn fitting(&self) -> Fitting {
        Fitting::UnitCube
    }
    /// How texels follow each other along the warp axis.
    fn spacing(&self) -> Spacing {
        Spacing::Projective
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

/// How texels follow each other along the axis of a warp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spacing {
    /// As the warp's own projection puts them.
    Projective,
    /// Evenly in the logarithm of its w, which must be constant along light rays: [`PostWarp::Log`]. A map whose w hardly
    /// varies over the receivers needs no logarithm and gets none.
    Logarithmic,
}

/// A warp with the focusing and fitting around it.
#[derive(Debug)]
pub(super) struct Focused {
    pub spec: &'static Spec,
    pub settings: Settings,
    pub tightening: Tightening,
    pub warp: Box<dyn Warp>,
}

impl Technique for Focused {
    fn spec(&self) -> &'static Spec {
        self.spec
    }
    fn settings(&self) -> Vec<(&'static str, Value)> {
        self.settings.values().to_vec()
    }
    fn needs_samples(&self) -> bool {
        self.warp.needs_samples()
    }
    fn maps(&self, part: &Part) -> Result<Maps> {
        Ok(Maps { maps: vec![self.map(part)?], selection: Selection::Depth, notes: Vec::new() })
    }
}

impl Focused {
    /// The map for all that a camera sees between its near and far planes.
    fn map(&self, part: &Part) -> Result<Map> {
        let Part { scene, camera, light, size, region, .. } = part;
        let view = |focus: Focus| FocusedView::new(scene, camera, light, focus);
        match (self.warp.fitting(), self.warp.focus(), light) {
            (Fitting::UnitCube, focus, _) => self.fitted(&view(focus).restricted(scene, region), part),
            (Fitting::StableGrid, Focus::Frustum | Focus::SceneFit, Light::Directional(directional)) => {
                let along = directional.direction();
                let grid = stable_grid(camera, along, scene_depth(scene.bounds(), along), size);
                let values = vec![("texel_x", grid.texel), ("texel_y", grid.texel), ("radius", grid.radius)];
                let view = FocusedView::new(scene, camera, light, Focus::Scene);
                Ok(self.finished(&view, part, &grid.clip_from_world, values, Vec::new()))
            }
            // Made without the camera, it stands still by itself.
            (Fitting::StableGrid, ..) => {
                let mut map = self.fitted(&view(Focus::Scene), part)?;
                let note = "stable: the map covers all that the light reaches, whatever the camera sees";
                map.notes.push(note.to_string());
                Ok(map)
            }
        }
    }
    fn fitted(&self, view: &FocusedView, part: &Part) -> Result<Map> {
        let Provisional { clip_from_local, mut values, mut notes } = self.warp.warp(view, part)?;
        let (scene, size, tightening) = (part.scene, &part.size, self.tightening);
        let (rows, post_warp) = match self.warp.spacing() {
            Spacing::Projective => {
                let fitted = fit(&clip_from_local, view, scene, size, tightening);
                if fitted.begins_late {
                    notes.retain(|note| !note.starts_with(INSIDE_A_BOX));
                    let distance = fitted.begins_at(view);
                    values.push(("begins_at", distance));
                    // Where nothing is seen there is no caster to miss.
                    if view.coverage == Coverage::AsAsked {
                        notes.push(begins_late(distance));
                    }
                }
                (fitted.clip_from_local, PostWarp::None)
            }
            Spacing::Logarithmic => fit_logarithmic(&clip_from_local, view, scene, size, tightening),
        };
        let seen = view.coverage == Coverage::AsAsked;
        if self.warp.spacing() == Spacing::Logarithmic && post_warp == PostWarp::None && seen && notes.is_empty() {
            notes.push("no logarithm: w hardly varies over what is seen".to_string());
        }
        values.extend(self.warp.values_of_fit(view, &rows, size));
        let clip_from_world = rows.moved_to_world(view.origin);
        if !sees_depth(&clip_from_world, &view.light) {
            return Err(Error::UnsuitedView {
                technique: self.spec.name.into(),
                reason: "depths along the light are lost to rounding: what is seen is too thin for a warp that strong"
                    .into(),
                fix: "weaken the warp, or use uniform".into(),
            });
        }
        let mut map = self.finished(view, part, &clip_from_world, values, notes);
        map.partition.post_warp = post_warp;
        Ok(map)
    }
    /// A map with the notes every technique owes.
    fn finished(
        &self,
        view: &FocusedView,
        part: &Part,
        clip_from_world: &Rows,
        values: Vec<Named>,
        mut notes: Vec<String>,
    ) -> Map {
        if view.coverage == Coverage::NothingSeen {
            let lit = if view.spot().is_some() { " that the light reaches" } else { "" };
            notes.insert(
                0,
                format!("the camera sees no part of the scene{lit}: the map covers what the light can reach"),
            );
        }
        let partition = Partition {
            shadow_clip_from_world: through_light(clip_from_world, &view.light, view.origin).matrix(),
            post_warp: PostWarp::None,
            eye_depth: view.eye_depth,
            region: part.region,
            technique: self.spec.name,
            values,
        };
        Map { partition, notes }
    }
}

/// How a note begins that says where a placed light's map begins.
pub(super) const INSIDE_A_BOX: &str = "the light is inside a mesh's box";

/// The note of a map that begins too late for casters next to the light.
pub(super) fn begins_late(distance: f64) -> String {
    format!("{INSIDE_A_BOX}: what is nearer to it than {distance:.4} casts no shadow")
}

/// The maps of the six faces around a point light, +x, -x, +y, -y, +z, -z, each as a spot light's: a receiver reads the face
/// on whose rays it lies. A warped map's square can hold rays of other faces, whose casters it does not look for.
fn faces_of<T: Technique + ?Sized>(technique: &T, part: &Part, point: &PointLight) -> Result<Maps> {
    let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let face = |along: DVec3| {
        let light = SpotLight::new(point.position(), along, std::f64::consts::FRAC_PI_2, point.range())?;
        // Towards the axis from the planes through the light and an edge between two faces.
        let border = |across: DVec3| {
            let normal = along + across;
            normal.extend(-normal.dot(point.position()))
        };
        let across: Vec<DVec4> = axes.into_iter().filter(|a| a.dot(along) == 0.0).map(border).collect();
        let region = Region::new(&across);
        technique.maps(&Part { light: Light::Spot(light), region, ..*part })
    };
    Ok(side_by_side(axes.into_iter().map(face).collect::<Result<_>>()?))
}

/// The maps of parts that divide the light's rays among them: a receiver reads the part that holds it. Where parts are
/// divided by camera depth, their maps are sorted by the depth they end at; as no map of another part holds a receiver, the
/// first that reaches its depth and holds it is its own part's.
pub(super) fn side_by_side(parts: Vec<Maps>) -> Maps {
    let by_depth = |part: &Maps| part.maps.len() > 1 && part.selection == Selection::Depth;
    let selection = if parts.iter().any(by_depth) { Selection::Depth } else { Selection::Containment };
    let mut all = Maps { maps: Vec::with_capacity(parts.len()), selection, notes: Vec::new() };
    let ends = parts.iter().flat_map(|part| &part.maps).map(|map| map.partition.eye_depth[1]);
    let farthest = ends.fold(0.0, f64::max);
    for mut part in parts {
        if selection == Selection::Depth {
            // The last has no end, nor has any map that is found by containment.
            let endless = if part.selection == Selection::Depth { part.maps.len() - 1 } else { 0 };
            part.maps[endless..].iter_mut().for_each(|map| map.partition.eye_depth[1] = farthest);
        }
        all.maps.extend(part.maps);
        all.notes.extend(part.notes.into_iter().filter(|note| !all.notes.contains(note)).collect::<Vec<_>>());
    }
    if selection == Selection::Depth {
        all.maps.sort_by(|a, b| a.partition.eye_depth[1].total_cmp(&b.partition.eye_depth[1]));
    }
    all
}

/// Whether depth grows along the light by more than the rounding of its own terms.
fn sees_depth(rows: &Rows, light: &Light) -> bool {
    let terms = rows.z * light.point();
    // Derived from f64: four products, each rounded by half a step, and three sums.
    terms.element_sum().abs() > 4.0 * f64::EPSILON * terms.abs().element_sum()
}

/// The same rows with x, y and w zero at the light (theory.md 0.1) to the last bit or two. The way through local coordinates
/// left the rounding of the translation at a placed light; the crop of a strong warp leaves that of far larger terms along a
/// directional one. What points near `origin` map to stays.
fn through_light(rows: &Rows, light: &Light, origin: DVec3) -> Rows {
    let p = light.point();
    let row = |r: DVec4| {
        let across = r.truncate();
        if p.w == 0.0 {
            let along = p.truncate() * across.dot(p.truncate());
            (across - along).extend(r.w + along.dot(origin))
        } else {
            across.extend(-across.dot(p.truncate()))
        }
    };
    Rows { x: row(rows.x), y: row(rows.y), z: rows.z, w: row(rows.w) }
}
