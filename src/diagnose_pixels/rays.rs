//! What an arbitrarily fine map of the same parameterization would hold on the rays through points: what light meets first
//! behind the near plane.

use glam::{DVec2, DVec3, DVec4};

use crate::render::cpu::lookup::Lookups;
use crate::scene::{AlphaTest, Light, Scene};
use crate::trace::OneByOne;

/// How far behind what it met a ray goes on, parts of the scene's size and place.
const AGAIN: f64 = 1.0 / (1_u64 << 40) as f64;

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

/// What light meets first on the ray through a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Met {
    /// How far before the point, towards the light: negative behind it, minus infinity for nothing. World units.
    pub height: f64,
    /// Where, relative to the origin.
    pub at: DVec3,
    /// The instance and the row of its face array, as in [`crate::image::Surfaces`]; -1 for nothing.
    pub face: (i32, i32),
    /// The triangle of the mesh; -1 for nothing.
    pub triangle: i32,
}

impl Met {
    /// Nothing.
    pub const NOTHING: Self = Self { height: f64::NEG_INFINITY, at: DVec3::ZERO, face: (-1, -1), triangle: -1 };
    /// All heights, for [`LightRays::met`].
    pub const ANYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    /// The same from another point of the ray.
    pub fn seen_from(self, point: DVec3, to_light: DVec3) -> Self {
        match self.triangle < 0 {
            true => self,
            false => Self { height: (self.at - point).dot(to_light), ..self },
        }
    }
}

/// The rays of a light that maps sample.
pub(super) struct LightRays<'a> {
    /// What they are traced in.
    pub scene: &'a Scene,
    /// The maps.
    pub lookups: &'a Lookups<'a>,
    /// The world point that points are relative to.
    pub origin: DVec3,
    /// The light's centre, relative to the origin: (unit vector to the light, 0) or (position, 1).
    pub light: DVec4,
    /// The middle of all, relative to the origin, and how far across it is.
    middle: (DVec3, f64),
}

impl<'a> LightRays<'a> {
    /// For points relative to an origin.
    pub fn new(scene: &'a Scene, light: &Light, lookups: &'a Lookups<'a>, origin: DVec3) -> Self {
        let (bounds, point) = (scene.bounds(), light.point());
        let light = DVec4::from((point.truncate() - point.w * origin, point.w));
        Self { scene, lookups, origin, light, middle: (bounds.center() - origin, bounds.diagonal()) }
    }

    /// To the light: a unit vector; zero at the light.
    pub fn to_light(&self, p: DVec3) -> DVec3 {
        (self.light.truncate() - self.light.w * p).normalize_or_zero()
    }

    /// How far from the light a point lies; of one at infinity, from any plane across its rays.
    pub fn distance(&self, p: DVec3) -> f64 {
        match self.light.w != 0.0 {
            true => (self.light.truncate() - p).length(),
            false => -self.light.truncate().dot(p),
        }
    }

    /// From a point to the light; from beyond everything where it is at infinity.
    fn whole_way(&self, p: DVec3) -> f64 {
        match self.light.w != 0.0 {
            true => (self.light.truncate() - p).length(),
            false => (p - self.middle.0).length() + self.middle.1,
        }
    }

    /// What light meets first behind the near plane of a map on the ray through a point, between two heights.
    pub fn met(&self, tracer: &mut OneByOne, map: usize, point: DVec3, [lowest, highest]: [f64; 2]) -> Met {
        let start = self.lookups.map(map).way_to_near(point).min(self.whole_way(point)).min(highest);
        self.met_from(tracer, point, start, lowest)
    }

    /// What light meets first above a point, whether a map holds it or not.
    pub fn met_from_light(&self, tracer: &mut OneByOne, point: DVec3) -> Met {
        self.met_from(tracer, point, self.whole_way(point), 0.0)
    }

    fn met_from(&self, tracer: &mut OneByOne, point: DVec3, start: f64, lowest: f64) -> Met {
        let to_light = self.to_light(point);
        // A point at the light has no ray.
        if to_light == DVec3::ZERO || !start.is_finite() {
            return Met::NOTHING;
        }
        let hit = tracer.first_hit(self.origin + point + start * to_light, -to_light, start - lowest);
        if hit.triangle < 0 {
            return Met::NOTHING;
        }
        let row = self.scene.mesh_of(hit.instance as usize).source_face(hit.triangle as usize) as i32;
        let height = start - hit.t;
        Met { height, at: point + height * to_light, face: (hit.instance, row), triangle: hit.triangle }
    }

    /// Where the ray of a place in the map meets the receiver's plane: a plane that is seen edge on is met at the receiver.
    pub fn at(&self, receiver: &Receiver, place: DVec2) -> DVec3 {
        let point = self.lookups.map(receiver.map).on_plane_at(receiver.p, receiver.normal, place);
        point.unwrap_or(receiver.p)
    }

    /// Where a point's shadow falls on the receiver's plane; nothing where the ray does not meet it.
    pub fn shadow_of(&self, point: DVec3, receiver: &Receiver) -> Option<DVec3> {
        let to_light = self.light.truncate() - self.light.w * point;
        let height = receiver.normal.dot(point - receiver.p) / receiver.normal.dot(to_light);
        height.is_finite().then_some(point - height * to_light)
    }

    /// The alpha test of the triangle that was met, and the texture coordinates of its corners.
    pub fn alpha_test(&self, met: &Met) -> Option<(&'a AlphaTest, [DVec2; 3])> {
        let mesh = self.scene.mesh_of(met.face.0 as usize);
        let test = mesh.alpha_test()?;
        Some((test, test.corners(mesh.triangles()[met.triangle as usize])))
    }

    /// Whether the outer side of the triangle that was met, by the winding of its mesh however that is placed, is averted from
    /// the light.
    pub fn is_averted(&self, met: &Met) -> bool {
        let [a, b, c] = self.corners(met);
        let mirrored = self.scene.world_from_local(met.face.0 as usize).matrix3.determinant().signum();
        (b - a).cross(c - a).dot(self.to_light(met.at)) * mirrored < 0.0
    }

    /// A part of the ray that counts as none, of what is met one after the other: above double precision, below single.
    pub fn again(&self) -> f64 {
        AGAIN * (self.middle.1 + self.origin.length())
    }

    /// The corners of the triangle that was met, relative to the origin.
    pub fn corners(&self, met: &Met) -> [DVec3; 3] {
        self.scene.corners(met.face.0 as usize, met.triangle as usize).map(|p| p - self.origin)
    }
}
