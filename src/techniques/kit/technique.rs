//! The shape of a technique, and what all of them share: bodies before the warp, the fit after it.
//!
//! ```text
//! scene, camera, light -> FocusedView -> Warp::warp -> fit to the unit cube or the stable grid -> one map
//! one map, or several of a scheme that divides the view, or the six of a point light -> Parameterization
//! ```

use std::fmt::Debug;
use std::sync::Arc;

use super::faces::faces_of;
use super::maps::{Maps, Part};
use super::spec::Spec;
use crate::error::{Error, Result};
use crate::fit::MapSize;
use crate::focus::{Focus, FocusedView, Samples};
use crate::geometry::Rows;
use crate::note::{Kind, Note, gathered};
use crate::parameterization::{Parameterization, Rectilinear, Region, Value};
use crate::progress::Progress;
use crate::scene::{Camera, Light, Scene};

/// A technique with its settings: a pure function from a view to a [`Parameterization`].
pub trait Technique: Debug + Send + Sync {
    /// What it says of itself.
    fn spec(&self) -> &'static Spec;
    /// Every parameter with its value, in the order of the spec.
    fn settings(&self) -> Vec<(&'static str, Value)> {
        self.shared_settings().to_vec()
    }
    /// The same, as every parameterization that it makes holds them.
    fn shared_settings(&self) -> Arc<[(&'static str, Value)]>;
    /// What it looks at: [`Part::samples`] must have it.
    fn needs(&self) -> Needs {
        Needs::Nothing
    }
    /// How many maps it makes of a part of a view at the most.
    fn most_maps(&self) -> usize {
        1
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
        self.spec().serves(light)
    }
    /// The maps for one scene, camera and light, made for `resolution` texels along each side, by a technique that needs no
    /// samples.
    ///
    /// # Errors
    /// As [`Technique::parameterize_seen`].
    fn parameterize(&self, scene: &Scene, camera: &Camera, light: &Light, resolution: u32) -> Result<Parameterization> {
        self.parameterize_seen(scene, camera, light, [resolution; 2], None)
    }
    /// The maps for one scene, camera and light, made for `resolution` texels along x and y; `samples` of what the camera
    /// sees are used by techniques that [need them](Technique::needs).
    ///
    /// # Errors
    /// [`Error::UnsupportedLight`]; [`Error::UnsuitedView`]; [`Error::InvalidArgument`] for a resolution that leaves no texel
    /// inside the border, or for missing samples.
    fn parameterize_seen(
        &self,
        scene: &Scene,
        camera: &Camera,
        light: &Light,
        resolution: [u32; 2],
        samples: Option<&Samples>,
    ) -> Result<Parameterization> {
        self.parameterize_watched(scene, camera, light, resolution, samples, &Progress::new())
    }
    /// The same, stopped where `progress` says so.
    ///
    /// # Errors
    /// As [`Technique::parameterize_seen`], and [`Error::Interrupted`].
    fn parameterize_watched(
        &self,
        scene: &Scene,
        camera: &Camera,
        light: &Light,
        resolution: [u32; 2],
        samples: Option<&Samples>,
        progress: &Progress,
    ) -> Result<Parameterization> {
        self.serves(light)?;
        let size = MapSize::new(resolution)?;
        check(self.needs(), samples, light)?;
        // Depths are divided, and bodies have corners: an infinite far plane is moved to the end of the scene.
        let bounded = camera.bounded(scene.bounds());
        let part = Part { scene, camera: bounded, light: *light, size, samples, region: Region::ALL, progress };
        let Maps { maps, selection, mut notes } = match light {
            Light::Point(point) => faces_of(&part, point, |face| self.maps(face))?,
            _ => self.maps(&part)?,
        };
        let settings = self.shared_settings();
        if !camera.far().is_finite() && settings.contains(&("stable", Value::Flag(true))) {
            notes.push(Note::new(Kind::EndMoves, &[("far", part.camera.far())]));
        }
        notes.extend(gathered(maps.iter().map(|map| map.notes.as_slice())));
        Ok(Parameterization {
            technique: self.spec().name.to_string(),
            settings,
            partitions: maps,
            selection,
            resolution: size.resolution,
            border_texels: size.border,
            notes,
        })
    }
}

/// What a technique looks at beside the scene's boxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Needs {
    /// No samples.
    Nothing,
    /// Visible surfaces.
    Surfaces,
    /// Visible surfaces, and which of them are in shadow.
    Shadows,
}

/// An error unless the samples have what a technique looks at.
fn check(needs: Needs, samples: Option<&Samples>, light: &Light) -> Result<()> {
    let wrong = |expected: &'static str, got: &'static str, fix: &'static str| {
        Err(Error::argument("samples", expected, got, fix))
    };
    match (needs, samples) {
        (Needs::Nothing, _) => Ok(()),
        (_, None) => {
            let fix = "render a small G-buffer of the view and hand over its samples, or set range=body and fit=exact";
            wrong("samples of what the camera sees", "none", fix)
        }
        (Needs::Surfaces, _) => Ok(()),
        (Needs::Shadows, Some(samples)) => match &samples.shadows {
            None => wrong(
                "samples that say what is in shadow",
                "samples without shadows",
                "give them shadow states (view.samples() has them), or take a warp that needs none, as tsm:fit=seen",
            ),
            Some(shadows) if shadows.light != *light => wrong(
                "samples with the shadows of this light",
                "shadows of another light",
                "make the samples for this light",
            ),
            Some(_) => Ok(()),
        },
    }
}

/// What a warping technique's file holds beside its spec: the warp itself, with its settings read.
pub trait Warp: Debug + Send + Sync {
    /// The provisional map of a view; the fit crops it.
    ///
    /// # Errors
    /// [`Error::UnsuitedView`] for a view that the technique cannot serve.
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional>;
    /// What it looks at itself, beside what focusing and fitting do.
    fn needs(&self) -> Needs {
        Needs::Nothing
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
    /// The separable warp after a fitted map, of [`Spacing::Rectilinear`]; nothing where no sample tells one from another.
    fn rectilinear(
        &self,
        _view: &FocusedView,
        _part: &Part,
        _clip_from_local: &Rows,
        _values: &mut Vec<Named>,
    ) -> Result<Option<Rectilinear>> {
        Ok(None)
    }
    /// Whose lights it serves: another technique's, if its homography is that one's.
    fn base(&self) -> Option<&'static Spec> {
        None
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
    /// From the view's local space: a shadow map's rows (0.1) with w > 0 on the receivers' body.
    pub clip_from_local: Rows,
    /// Intermediate numbers.
    pub values: Vec<Named>,
    /// What the user should know.
    pub notes: Vec<Note>,
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
    /// Evenly in the logarithm of its w, which must be constant along light rays: [`PostWarp::Log`](crate::parameterization::PostWarp::Log). A map whose w hardly
    /// varies over the receivers needs no logarithm and gets none.
    Logarithmic,
    /// As a separable warp after the fitted map puts them: [`PostWarp::Rectilinear`](crate::parameterization::PostWarp::Rectilinear).
    Rectilinear,
}
