//! Maps of parts that divide the light's rays among them, and the six faces of a point light.

use glam::{DVec3, DVec4};

use super::maps::{Maps, Part};
use crate::error::Result;
use crate::parameterization::{Region, Selection};
use crate::scene::{Light, PointLight, SpotLight};

/// The maps of the six faces around a point light, +x, -x, +y, -y, +z, -z, each as a spot light's: a receiver reads the face
/// on whose rays it lies. A warped map's square can hold rays of other faces, whose casters it does not look for.
pub(super) fn faces_of(part: &Part, point: &PointLight, maps: impl Fn(&Part) -> Result<Maps>) -> Result<Maps> {
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
        maps(&Part { light: Light::Spot(light), region, ..*part })
    };
    Ok(side_by_side(axes.into_iter().map(face).collect::<Result<_>>()?))
}

/// The maps of parts that divide the light's rays among them: a receiver reads the part that holds it. Where parts are
/// divided by camera depth, their maps are sorted by the depth they end at; as no map of another part holds a receiver, the
/// first that reaches its depth and holds it is its own part's.
pub(in crate::techniques) fn side_by_side(parts: Vec<Maps>) -> Maps {
    let by_depth = |part: &Maps| part.maps.len() > 1 && part.selection == Selection::Depth;
    let selection = if parts.iter().any(by_depth) { Selection::Depth } else { Selection::Containment };
    let mut all = Maps { maps: Vec::with_capacity(parts.len()), selection, notes: Vec::new() };
    let ends = parts.iter().flat_map(|part| &part.maps).map(|map| map.eye_depth[1]);
    let farthest = ends.fold(f64::NEG_INFINITY, f64::max);
    for mut part in parts {
        if selection == Selection::Depth {
            // The last has no end, nor has any map that is found by containment.
            let endless = if part.selection == Selection::Depth { part.maps.len() - 1 } else { 0 };
            part.maps[endless..].iter_mut().for_each(|map| map.eye_depth[1] = farthest);
        }
        all.maps.extend(part.maps);
        all.notes.extend(part.notes.into_iter().filter(|note| !all.notes.contains(note)).collect::<Vec<_>>());
    }
    if selection == Selection::Depth {
        all.maps.sort_by(|a, b| a.eye_depth[1].total_cmp(&b.eye_depth[1]));
    }
    all
}
