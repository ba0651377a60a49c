//! A warp with what all of them share around it: the bodies before, the fit after, and the notes every map owes.

use std::sync::Arc;

use glam::{DMat4, DVec3, DVec4};

use super::light_space::LightSpace;
use super::maps::{Maps, Part, with_length};
use super::settings::{Holds, Range, Settings};
use super::spec::Spec;
use super::technique::{Fitting, Named, Needs, Provisional, Spacing, Technique, Warp};
use crate::error::{Error, Result};
use crate::fit::{MapSize, Tightening, fit, fit_logarithmic, scene_depth, stable_grid};
use crate::focus::{Coverage, Focus, FocusedView, Outline};
use crate::geometry::Rows;
use crate::note::{Kind, Note};
use crate::parameterization::{Factors, Partition, PostWarp, Selection, Value};
use crate::scene::Light;

/// A warp with the focusing and fitting around it.
#[derive(Debug)]
pub(in crate::techniques) struct Focused {
    pub spec: &'static Spec,
    pub settings: Settings,
    pub tightening: Tightening,
    pub range: Range,
    pub holds: Holds,
    /// Texels.
    pub margin: f64,
    pub slack: f64,
    pub warp: Box<dyn Warp>,
}

impl Technique for Focused {
    fn spec(&self) -> &'static Spec {
        self.spec
    }
    fn shared_settings(&self) -> Arc<[(&'static str, Value)]> {
        self.settings.shared()
    }
    fn needs(&self) -> Needs {
        let own = match (self.holds, self.range) {
            (Holds::Shadow, _) => Needs::Shadows,
            (Holds::Seen, _) | (_, Range::Seen) => Needs::Surfaces,
            (Holds::Body, Range::Body) => Needs::Nothing,
        };
        // A grid that stands still does not look at what is seen.
        if self.warp.fitting() == Fitting::StableGrid { Needs::Nothing } else { own.max(self.warp.needs()) }
    }
    fn serves(&self, light: &Light) -> Result<()> {
        self.warp.base().unwrap_or(self.spec).serves(light)
    }
    fn maps(&self, part: &Part) -> Result<Maps> {
        Ok(Maps { maps: vec![self.map(part)?], selection: Selection::Depth, notes: Vec::new() })
    }
}

impl Focused {
    /// The map for all that a camera sees between its near and far planes.
    fn map(&self, part: &Part) -> Result<Partition> {
        part.progress.check()?;
        let Part { scene, camera, light, size, region, .. } = part;
        let view = |focus: Focus| FocusedView::new(scene, camera, light, focus);
        match (self.warp.fitting(), self.warp.focus(), light) {
            (Fitting::UnitCube, focus, _) => {
                let seen = Seen::of(self, part)?;
                let near_far = seen.depths.filter(|_| self.range == Range::Seen && focus != Focus::Scene);
                let cut = match near_far.map(|depths| with_length(depths, camera)) {
                    Some([near, far]) => camera.with_depths(near, far)?,
                    None => *camera,
                };
                let mut view = FocusedView::uncut(scene, &cut, light, focus);
                view.cut(scene);
                view.restrict(scene, region);
                // A map of the whole scene is made without the camera, and relative to the scene's middle.
                let outline = seen.outline.as_ref().filter(|_| focus != Focus::Scene);
                view.hold(outline);
                let mut map = self.fitted(&view, part, &seen.size)?;
                if let Some([near, far]) = near_far {
                    map.values.extend([("seen_near", near), ("seen_far", far)]);
                    // Receivers that no sample shows are served, too.
                    map.eye_depth = [camera.near(), camera.far()];
                }
                map.notes.extend(seen.notes);
                Ok(map)
            }
            (Fitting::StableGrid, Focus::Frustum | Focus::SceneFit, Light::Directional(directional)) => {
                let along = directional.direction();
                let grid = stable_grid(camera, along, scene_depth(scene.bounds(), along), size);
                let values = vec![("texel_x", grid.texel.x), ("texel_y", grid.texel.y), ("radius", grid.radius)];
                let view = FocusedView::new(scene, camera, light, Focus::Scene);
                let lift = grid.frame.orthographic().matrix();
                let factors = Factors { lift, warp: DMat4::IDENTITY, fit: grid.crop };
                Ok(self.finished(&view, part, &grid.clip_from_world, factors, values, Vec::new()))
            }
            // Made without the camera, it stands still by itself.
            (Fitting::StableGrid, ..) => {
                let mut map = self.fitted(&view(Focus::Scene), part, size)?;
                map.notes.push(Note::new(Kind::Stable, &[]));
                Ok(map)
            }
        }
    }
    fn fitted(&self, view: &FocusedView, part: &Part, size: &MapSize) -> Result<Partition> {
        let part = &Part { size: *size, ..*part };
        let Provisional { clip_from_local, mut values, mut notes } = self.warp.warp(view, part)?;
        let (scene, tightening) = (part.scene, self.tightening);
        let (fitted, post_warp) = match self.warp.spacing() {
            Spacing::Projective | Spacing::Rectilinear => {
                let fitted = fit(&clip_from_local, view, scene, size, tightening);
                if fitted.begins_late {
                    notes.retain(|note| note.kind() != Kind::LightInBox);
                    let distance = fitted.begins_at(view);
                    values.push(("begins_at", distance));
                    // Where nothing is seen there is no caster to miss.
                    if view.coverage == Coverage::AsAsked {
                        notes.push(Note::new(Kind::LightInBox, &[("distance", distance)]));
                    }
                }
                let warp = match self.warp.spacing() {
                    Spacing::Rectilinear => self.warp.rectilinear(view, part, &fitted.clip_from_local, &mut values)?,
                    _ => None,
                };
                (fitted, warp.map_or(PostWarp::None, |warp| PostWarp::Rectilinear(Arc::new(warp))))
            }
            Spacing::Logarithmic => fit_logarithmic(&clip_from_local, view, scene, size, tightening),
        };
        let seen = view.coverage == Coverage::AsAsked;
        if self.warp.spacing() == Spacing::Logarithmic && post_warp == PostWarp::None && seen && notes.is_empty() {
            notes.push(Note::new(Kind::NoLogarithm, &[]));
        }
        let rows = fitted.clip_from_local;
        values.extend(self.warp.values_of_fit(view, &rows, size));
        let clip_from_world = rows.moved_to_world(view.origin);
        if !clip_from_world.matrix().is_finite() || !sees_depth(&clip_from_world, &view.light) {
            return Err(Error::UnsuitedView {
                technique: self.spec.name.into(),
                reason: "depths along the light are lost to rounding: what is seen is too thin for a warp that strong"
                    .into(),
                fix: "weaken the warp, or use uniform".into(),
            });
        }
        let space = LightSpace::of(view);
        let lift = through_light(&space.rows().moved_to_world(view.origin), &view.light, view.origin).matrix();
        let factors = Factors { lift, warp: space.warp(&fitted.provisional), fit: fitted.crop };
        let mut map = self.finished(view, part, &clip_from_world, factors, values, notes);
        map.post_warp = post_warp;
        Ok(map)
    }
    /// A map with the notes every technique owes.
    fn finished(
        &self,
        view: &FocusedView,
        part: &Part,
        clip_from_world: &Rows,
        factors: Factors,
        values: Vec<Named>,
        mut notes: Vec<Note>,
    ) -> Partition {
        if view.coverage == Coverage::NothingSeen {
            let kind = if view.spot().is_some() { Kind::NothingLit } else { Kind::NothingSeen };
            notes.insert(0, Note::new(kind, &[]));
        }
        Partition {
            shadow_clip_from_world: through_light(clip_from_world, &view.light, view.origin).matrix(),
            factors: Some(factors),
            post_warp: PostWarp::None,
            eye_depth: view.eye_depth,
            region: part.region,
            technique: self.spec.name,
            values,
            notes,
        }
    }
}

/// What samples say of a part of a view.
struct Seen {
    /// Near and far depth of what faces the light; nothing without samples, or where nothing does.
    depths: Option<[f64; 2]>,
    /// What the map must hold.
    outline: Option<Outline>,
    /// With the margin around it.
    size: MapSize,
    notes: Vec<Note>,
}

impl Seen {
    fn of(technique: &Focused, part: &Part) -> Result<Self> {
        let Part { camera, light, size, region, .. } = part;
        let (by_samples, mut notes) = (technique.holds != Holds::Body, Vec::new());
        let none = Self { depths: None, outline: None, size: *size, notes: Vec::new() };
        let Some(samples) = part.samples.filter(|_| by_samples || technique.range == Range::Seen) else {
            return Ok(none);
        };
        let Some(depths) = samples.depths(camera, light, region) else {
            notes.push(Note::new(Kind::NoLitSample, &[]));
            return Ok(Self { notes, ..none });
        };
        let seen = || samples.outline(camera, light, region);
        let outline = match technique.holds {
            Holds::Body => None,
            Holds::Seen => seen(),
            Holds::Shadow => samples.shaded_outline(camera, light, region).or_else(|| {
                notes.push(Note::new(Kind::NoShadow, &[]));
                seen()
            }),
        };
        let size = if by_samples { size.with_room(technique.margin, technique.slack)? } else { *size };
        Ok(Self { depths: Some(depths), outline, size, notes })
    }
}

/// Whether depth grows along the light by more than the rounding of its own terms.
fn sees_depth(rows: &Rows, light: &Light) -> bool {
    let terms = rows.z * light.point();
    // Derived from f64: four products, each rounded by half a step, and three sums.
    terms.element_sum().abs() > 4.0 * f64::EPSILON * terms.abs().element_sum()
}

/// The same rows with x, y and w zero at the light (0.1) to the last bit or two. The way through local coordinates
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
