//! What an arbitrarily fine map of the same parameterization would hold on the rays through points: what light meets first
//! behind the near plane.

use glam::{DVec2, DVec3};

use crate::error::Result;
use crate::progress::Progress;
use crate::render::cpu::lookup::Lookups;
use crate::scene::{Light, Scene};
use crate::trace::{Hit, Tracer};

/// How far from a texel's centre what it holds may be met, texels: rasterisers round vertices to 1/256 of a texel, and the
/// ray that grazes what they drew has to lie within.
const SNAP: f64 = 1.0 / 128.0;
/// Where a texel that a ray through its centre does not confirm is asked again.
const ABOUT: [DVec2; 4] =
    [DVec2::new(-SNAP, 0.0), DVec2::new(SNAP, 0.0), DVec2::new(0.0, -SNAP), DVec2::new(0.0, SNAP)];

/// A receiver, and how a map samples it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Receiver {
    /// The map.
    pub map: usize,
    /// Relative to the origin.
    pub p: DVec3,
    /// Unit.
    pub normal: DVec3,
    /// Its place in the map, texels.
    pub place: DVec2,
    /// World size of a texel across the ray.
    pub texel: f64,
    /// The tangent of the angle between normal and light.
    pub slope: f64,
    /// A height above the plane that counts as none, of rays and of what maps hold, world units.
    pub touch: f64,
    /// See `touch`.
    pub grain: f64,
    /// Its instance and triangle.
    pub face: (i32, i32),
}

/// A point whose ray is asked about.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asked {
    /// The map whose near plane the ray begins at.
    pub map: usize,
    /// Relative to the origin.
    pub point: DVec3,
    /// How far before the point the ray begins at most, world units.
    pub at_most: f64,
}

/// What light meets first on the ray through a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Met {
    /// How far before the point, towards the light: negative behind it, minus infinity for nothing. World units.
    pub height: f64,
    /// The instance and the row of its face array, as in [`crate::image::Surfaces`]; -1 for nothing.
    pub face: (i32, i32),
    /// The triangle of the mesh; -1 for nothing.
    pub triangle: i32,
}

impl Met {
    /// Nothing.
    pub const NOTHING: Self = Self { height: f64::NEG_INFINITY, face: (-1, -1), triangle: -1 };
}

/// The rays of a light that maps sample.
pub(super) struct LightRays<'a> {
    /// What they are traced in.
    pub scene: &'a Scene,
    /// The same, ready for rays.
    pub tracer: &'a Tracer,
    /// Where they come from.
    pub light: &'a Light,
    /// The maps.
    pub lookups: &'a Lookups<'a>,
    /// The world point that points are relative to.
    pub origin: DVec3,
}

impl LightRays<'_> {
    /// What light meets first behind the near plane on the rays through points, in their order.
    pub fn met(&self, asked: &[Asked], progress: &Progress) -> Result<Vec<Met>> {
        self.met_behind(asked, |asked| self.lookups.map(asked.map).way_to_near(asked.point), progress)
    }

    /// What light meets first on the rays through points, in their order, whether a map holds it or not.
    pub fn met_from_light(&self, asked: &[Asked], progress: &Progress) -> Result<Vec<Met>> {
        self.met_behind(asked, |_| f64::INFINITY, progress)
    }

    fn met_behind(&self, asked: &[Asked], near: impl Fn(&Asked) -> f64, progress: &Progress) -> Result<Vec<Met>> {
        let (bounds, light) = (self.scene.bounds(), self.light.point());
        let mut origins = Vec::with_capacity(asked.len());
        let mut directions = Vec::with_capacity(asked.len());
        let mut starts = Vec::with_capacity(asked.len());
        for one in asked {
            let p_world = self.origin + one.point;
            let to_light = self.lookups.map(one.map).way_to_light(one.point);
            // From the light; from beyond everything where it is at infinity.
            let whole = match light.w != 0.0 {
                true => (light.truncate() - p_world).length(),
                false => (p_world - bounds.center()).length() + bounds.diagonal(),
            };
            let start = near(one).min(whole).min(one.at_most);
            // A point at the light has no ray: any that meets nothing before it.
            let way = if to_light == DVec3::ZERO { DVec3::NEG_Y } else { -to_light };
            origins.push((p_world - start * way).to_array());
            directions.push(way.to_array());
            starts.push(start);
        }
        let hits = self.tracer.first_hit(&origins, &directions, progress)?;
        let met = |(hit, start): (&Hit, &f64)| {
            if hit.triangle < 0 {
                return Met::NOTHING;
            }
            let row = self.scene.mesh_of(hit.instance as usize).source_face(hit.triangle as usize) as i32;
            Met { height: start - hit.t, face: (hit.instance, row), triangle: hit.triangle }
        };
        Ok(hits.iter().zip(&starts).map(met).collect())
    }

    /// What to ask where the ray of a place in the map meets the receiver's plane: a plane that is seen edge on is met at the
    /// receiver.
    pub fn at(&self, receiver: &Receiver, place: DVec2) -> Asked {
        let point = self.lookups.map(receiver.map).on_plane_at(receiver.p, receiver.normal, place);
        Asked { map: receiver.map, point: point.unwrap_or(receiver.p), at_most: f64::INFINITY }
    }

    /// What light meets at the centres of texels, each with what the texel holds over the receiver's plane; nothing where the
    /// texel holds what light does not meet there.
    pub fn confirmed(&self, of: &[(&Receiver, DVec2, f64)], progress: &Progress) -> Result<Vec<Option<Met>>> {
        let asked: Vec<Asked> = of.iter().map(|(receiver, centre, _)| self.at(receiver, *centre)).collect();
        let is_right = |n: usize, met: &Met| {
            let (receiver, _, gap) = of[n];
            // Within a texel, or both not above the plane.
            (met.height - gap).abs() <= receiver.texel * (1.0 + receiver.slope) || met.height.max(gap) <= receiver.grain
        };
        let met = self.met(&asked, progress)?;
        let mut found: Vec<Option<Met>> =
            met.into_iter().enumerate().map(|(n, m)| Some(m).filter(|m| is_right(n, m))).collect();
        let doubtful: Vec<usize> = (0..of.len()).filter(|&n| found[n].is_none()).collect();
        let again = doubtful.iter().flat_map(|&n| ABOUT.map(|step| self.at(of[n].0, of[n].1 + step)));
        let again = self.met(&again.collect::<Vec<_>>(), progress)?;
        for (&n, again) in doubtful.iter().zip(again.chunks(ABOUT.len())) {
            found[n] = again.iter().find(|met| is_right(n, met)).copied();
        }
        Ok(found)
    }

    /// The corners of the triangle that was met, relative to the origin.
    pub fn corners(&self, met: Met) -> [DVec3; 3] {
        let instance = met.face.0 as usize;
        let (mesh, to_world) = (self.scene.mesh_of(instance), self.scene.world_from_local()[instance]);
        let corners = mesh.triangles()[met.triangle as usize];
        corners.map(|k| to_world.transform_point3(mesh.positions_local()[k as usize].as_dvec3()) - self.origin)
    }
}
