//! Face partitioning: the light's rays are divided by the face of the camera's frustum through which they leave it.
//!
//! Source: Lloyd, Tuft, Yoon, Manocha 2006 `[lloyd2006]` (warping and partitioning for low error shadow maps); Kozlov
//! 2004 `[kozlov2004]` (the faces of the frustum as a shadow map's parts); theory.md 12.2. Seen from the light, the
//! faces that light leaves through tile the whole frustum, so each ray has one map, whatever lies along it. A side face
//! gets a warped map, as the error grows along it; over the near and the far face it does not, and a uniform map
//! serves. Departures:
//! - the warp of a side face runs along the view as seen from the light, as every warp here does, not along the face;
//! - faces behind which nothing is seen get no map;
//! - borders are homogeneous planes through the light and an edge, so placed lights are divided by the very same lines. A
//!   light inside the frustum is divided among all six.
//!
//! ```text
//!      \ light                          regions are told by the edges between two such faces alone: the outline
//!   ____\______________ top            of the frustum bounds what is seen anyway, and rounding there loses nothing
//!  |     \             |
//!  near   \            far  <- exit
//!  |_______\___________|
//!        bottom <- exit
//! ```

use std::sync::Arc;

use glam::{DVec3, DVec4};

use super::kit::faces::side_by_side;
use super::kit::{Default, Kind, LightSupport, Maps, Needs, ParamSpec, Part, Settings, Spec, Technique};
use super::techniques_of;
use crate::error::{Error, Result};
use crate::focus::{Coverage, Focus, FocusedView};
use crate::geometry::{Frustum, Sides};
use crate::note::{self, Detail, Note};
use crate::parameterization::{Region, Value};
use crate::rays::LightRays;
use crate::scene::Light;

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "face_partition",
    title: "Frustum faces as seen from the light",
    source: "Lloyd, Tuft, Yoon, Manocha 2006; Kozlov 2004",
    lights: LightSupport { directional: true, spot: true, point: true },
    params: &[ParamSpec {
        name: "inner",
        unit: "",
        default: Default::Choice("lispsm/uniform"),
        kind: Kind::Techniques,
        doc: "the technique of the side faces, and after a / that of the near and far faces; one alone serves all",
    }],
};

/// The least sine between light and a face that gets a map. Derived from f64: of a flatter face the borders are rounding, and
/// the light sees none of its texels; the rays beyond the border of its neighbours are theirs then.
const LEAST_SINE: f64 = 1.0 / (1 << 26) as f64;

/// The faces in the order of [`Frustum::planes`].
const FACES: [Detail; 6] = [Detail::Left, Detail::Right, Detail::Bottom, Detail::Top, Detail::Near, Detail::Far];
const NEAR: usize = 4;
const FAR: usize = 5;

#[derive(Debug)]
struct FacePartition {
    settings: Settings,
    sides: Box<dyn Technique>,
    /// Of the near and the far face; that of the sides where there is none.
    ends: Option<Box<dyn Technique>>,
}

/// The scheme from checked settings.
pub fn make(settings: Settings) -> Result<Box<dyn Technique>> {
    let mut inner = techniques_of(settings.word("inner"))?.into_iter();
    let (Some(sides), ends, None) = (inner.next(), inner.next(), inner.next()) else {
        let expected = "one technique for all faces, or two: of the sides and of the ends";
        return Err(Error::argument("inner", expected, settings.word("inner"), "name at most two, separated by /"));
    };
    Ok(Box::new(FacePartition { settings, sides, ends }))
}

impl Technique for FacePartition {
    fn spec(&self) -> &'static Spec {
        &SPEC
    }
    fn shared_settings(&self) -> Arc<[(&'static str, Value)]> {
        self.settings.shared()
    }
    fn needs(&self) -> Needs {
        self.inner().map(Technique::needs).max().unwrap_or(Needs::Nothing)
    }
    /// As far as both inner techniques do.
    fn serves(&self, light: &Light) -> Result<()> {
        self.inner().try_for_each(|t| t.serves(light))
    }
    fn most_maps(&self) -> usize {
        (0..FACES.len()).map(|face| self.technique_of(face).most_maps()).fold(0, usize::saturating_add)
    }
    fn maps(&self, part: &Part) -> Result<Maps> {
        let view = FocusedView::new(part.scene, &part.camera, &part.light, Focus::SceneFit);
        if view.restricted(part.scene, &part.region).coverage == Coverage::NothingSeen {
            return self.technique_of(FAR).maps(part);
        }
        let (mut parts, mut without) = (Vec::with_capacity(6), Vec::new());
        for (face, region) in regions(&view) {
            let Some(region) = part.region.and(&region) else {
                let reason = "its faces divide rays that another scheme has divided already".to_string();
                let fix = "let face_partition divide the view, and have its inner techniques divide the faces";
                return Err(Error::UnsuitedView { technique: SPEC.name.into(), reason, fix: fix.into() });
            };
            if view.restricted(part.scene, &region).coverage == Coverage::NothingSeen {
                without.push(FACES[face]);
                continue;
            }
            let mut maps = self.technique_of(face).maps(&Part { region, ..*part })?;
            maps.maps.iter_mut().for_each(|map| map.values.push(("face", face as f64)));
            parts.push(maps);
        }
        // Only where all of what is seen lies within rounding of the borders.
        if parts.is_empty() {
            return self.technique_of(FAR).maps(part);
        }
        let mut all = side_by_side(parts);
        if !without.is_empty() {
            all.notes.push(Note::detailed(note::Kind::FaceUnseen, &without, &[]));
        }
        Ok(all)
    }
}

impl FacePartition {
    fn inner(&self) -> impl Iterator<Item = &dyn Technique> {
        [Some(&self.sides), self.ends.as_ref()].into_iter().flatten().map(AsRef::as_ref)
    }
    fn technique_of(&self, face: usize) -> &dyn Technique {
        match &self.ends {
            Some(ends) if face == NEAR || face == FAR => ends.as_ref(),
            _ => self.sides.as_ref(),
        }
    }
}

/// The faces through which light leaves the camera's frustum, each with the rays that do, world. Together they hold all rays
/// through the frustum.
fn regions(view: &FocusedView) -> Vec<(usize, Region)> {
    let frustum = view.camera_frustum();
    let planes = frustum.planes();
    let centers = centers(&frustum);
    let sine = |face: usize| {
        let along = view.rays.direction_at(centers[face]).unwrap_or(-planes[face].normal);
        planes[face].normal.dot(along)
    };
    let mut exits: [bool; 6] = std::array::from_fn(|face| sine(face) > LEAST_SINE);
    // Light from the face's own plane or all but: no face is left through, as the far one is by most rays.
    if exits == [false; 6] {
        exits[FAR] = true;
    }
    let mut borders: [Vec<DVec4>; 6] = std::array::from_fn(|_| Vec::with_capacity(4));
    for Edge { faces: [a, b], through, along } in edges(&frustum) {
        if !(exits[a] && exits[b]) {
            continue;
        }
        let Some(border) = border(&view.rays, through, along) else { continue };
        // Towards the middle of one face and away from that of the other; the one further from the border tells better.
        let side = border.dot(centers[a].extend(1.0)) - border.dot(centers[b].extend(1.0));
        let towards_a = if side < 0.0 { -border } else { border };
        for (face, f) in [(a, towards_a), (b, -towards_a)] {
            borders[face].push(f.truncate().extend(f.w - f.truncate().dot(view.origin)));
        }
    }
    (0..6).filter(|&face| exits[face]).map(|face| (face, Region::new(&borders[face]))).collect()
}

/// The middle of each face, local.
fn centers(frustum: &Frustum) -> [DVec3; 6] {
    let ([left, right, bottom, top], [x, y]) = (frustum.edges(), frustum.center);
    let (near, far) = (frustum.near, frustum.far);
    let middle = 0.5 * (near + far);
    [
        frustum.at(left, y, middle),
        frustum.at(right, y, middle),
        frustum.at(x, bottom, middle),
        frustum.at(x, top, middle),
        frustum.at(x, y, near),
        frustum.at(x, y, far),
    ]
}

/// An edge of the frustum.
struct Edge {
    /// The faces that meet in it.
    faces: [usize; 2],
    /// A point on its line, local.
    through: DVec3,
    /// A unit vector along it.
    along: DVec3,
}

/// The twelve edges, each by a direction that no subtraction of corners has rounded.
fn edges(frustum: &Frustum) -> Vec<Edge> {
    let Frustum { apex, right, up, forward, sides, near, far, .. } = *frustum;
    let ([left_x, right_x, bottom_y, top_y], [x, y]) = (frustum.edges(), frustum.center);
    let mut all = Vec::with_capacity(12);
    // Left, right with bottom, top: through the apex, or along the axis.
    for (i, x) in [(0, left_x), (1, right_x)] {
        for (j, y) in [(2, bottom_y), (3, top_y)] {
            let (through, along) = match sides {
                Sides::Converging => (apex, (forward + right * x + up * y).normalize()),
                Sides::Parallel => (frustum.at(x, y, near), forward),
            };
            all.push(Edge { faces: [i, j], through, along });
        }
    }
    for (end, depth) in [(NEAR, near), (FAR, far)] {
        for (side, x) in [(0, left_x), (1, right_x)] {
            all.push(Edge { faces: [side, end], through: frustum.at(x, y, depth), along: up });
        }
        for (side, y) in [(2, bottom_y), (3, top_y)] {
            all.push(Edge { faces: [side, end], through: frustum.at(x, y, depth), along: right });
        }
    }
    all
}

/// The distance from the plane through the light and a line, as a functional of (p, 1); nothing for a line of light.
fn border(rays: &LightRays, through: DVec3, along: DVec3) -> Option<DVec4> {
    // The light as seen from the line: (-l, 0), or p - through.
    let light = rays.point.truncate() - through * rays.point.w;
    let normal = light.cross(along).try_normalize()?;
    Some(normal.extend(-normal.dot(through)))
}
