//! Plane-optimal shadow maps: on one plane, shadow texels are screen pixels.
//!
//! Source: Chong and Gortler 2004 `[chong2004]` (a lixel for every pixel); theory.md 9 and (9.1): a point goes along
//! its light ray to the plane, and from there to the screen. Departures:
//! - The shared fit crops each axis to the receivers, so texels are pixels up to a crop that is constant over the plane.
//! - Viewer and light on opposite sides of the plane mirror the image. Every map here keeps the winding that the light sees:
//!   x is negated then (the value `mirrored` says so), where a renderer could switch the cull mode.
//! - The plane may be found from what is seen ([`dominant_plane`]).
//! - One map is made, so light rays that meet the plane behind the eye cannot be covered by the plane's own w: the paper
//!   splits. A map for samples leans its w towards a constant until it serves them; a map for the body is an error that
//!   tells how much is lost, or on demand a uniform map.
//!
//! ```text
//!        eye x         . light ray
//!             \  .   o  receiver       the receiver's texel is the pixel
//!              \   .                   in which the plane is seen where
//!        ________*______ plane         the ray goes through it
//! ```

use glam::{DVec3, DVec4};

use super::dominant::dominant_plane;
use super::lean::{LEAST_SHARE, leaned};
use crate::error::{Error, Result};
use crate::focus::{Coverage, FocusedView};
use crate::geometry::Rows;
use crate::note::{Detail, Note};
use crate::techniques::kit::light_projection::{spot_depth_range, uniform_rows};
use crate::techniques::kit::{
    Default, FIT, Kind, LEAST_KAPPA, LEAST_LAMBDA, LightSupport, MARGIN, Named, Needs, ParamSpec, Part, Provisional,
    RANGE, SLACK, Settings, Spec, Warp,
};

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "plane_optimal",
    title: "Plane-optimal shadow map",
    source: "Chong, Gortler 2004",
    lights: LightSupport { directional: true, spot: true, point: true },
    params: &[
        ParamSpec {
            name: "plane",
            unit: "",
            default: Default::Choice("dominant"),
            kind: Kind::Numbers { words: &["dominant"], count: [4, 4], min: f64::MIN, max: f64::MAX },
            doc: "the plane n·p + d = 0 in world space as (nx, ny, nz, d), or the one that most samples at the edges of visible \
                  shadows lie on, or where no shadow is known most visible receivers that face the light (dominant)",
        },
        ParamSpec {
            name: "fallback",
            unit: "",
            default: Default::Choice("none"),
            kind: Kind::Choice(&["none", "uniform"]),
            doc: "for a view that the plane cannot serve: an error that says why (none), or a uniform map with a note that \
                  does (uniform); a point light has such views among its six in nearly every scene",
        },
        RANGE,
        FIT,
        MARGIN,
        SLACK,
    ],
};

/// Samples of a search, at the most.
const MOST_EDGES: usize = 4096;

/// A plane `normal · p + offset = 0` with a unit normal.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Plane {
    normal: DVec3,
    offset: f64,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Choice {
    Dominant,
    /// World space.
    Given(Plane),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Fallback {
    None,
    Uniform,
}

#[derive(Debug)]
struct PlaneOptimal {
    plane: Choice,
    fallback: Fallback,
}

/// The warp from checked settings.
pub fn make(settings: &Settings) -> Result<Box<dyn Warp>> {
    let plane = match settings.numbers("plane") {
        [x, y, z, d] => Choice::Given(Plane::given(DVec3::new(*x, *y, *z), *d)?),
        _ => Choice::Dominant,
    };
    let fallback = settings.meaning("fallback", &[("none", Fallback::None), ("uniform", Fallback::Uniform)])?;
    Ok(Box::new(PlaneOptimal { plane, fallback }))
}

impl Plane {
    fn given(normal: DVec3, d: f64) -> Result<Self> {
        // Divided by the largest first: squares of the largest numbers overflow.
        let size = normal.abs().max_element();
        let (scaled, offset) = (normal / size, d / size);
        let plane = Self { normal: scaled.normalize(), offset: offset / scaled.length() };
        if size > 0.0 && plane.offset.is_finite() {
            return Ok(plane);
        }
        let expected = "a plane (nx, ny, nz, d) with a normal that is not zero and a finite distance from the origin";
        let got = format!("({}, {}, {}, {d})", normal.x, normal.y, normal.z);
        Err(Error::argument("plane", expected, got, "the ground at height h is (0, 1, 0, -h)"))
    }
    fn functional(&self) -> DVec4 {
        self.normal.extend(self.offset)
    }
    /// Relative to a local origin.
    fn moved_to(&self, origin: DVec3) -> Self {
        Self { normal: self.normal, offset: self.offset + self.normal.dot(origin) }
    }
}

/// Why a plane cannot serve a view, and what to do.
struct Unsuited {
    why: Note,
    fix: &'static str,
}

impl Unsuited {
    /// What another plane mends.
    fn plane(why: Detail, values: &[Named]) -> Self {
        let fix = "give another plane, or fallback=uniform for a uniform map here";
        Self { why: Note::no_warp(&[why], values), fix }
    }
}

impl Warp for PlaneOptimal {
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional> {
        let mut notes = Vec::new();
        if view.coverage == Coverage::NothingSeen {
            let clip_from_local = uniform_rows(view, part.scene, &mut notes);
            return Ok(Provisional { clip_from_local, values: Vec::new(), notes });
        }
        let mut values = Vec::with_capacity(8);
        let found = match self.plane(view, part, &mut values)? {
            Ok(plane) => through_plane(view, part, &plane, &mut values),
            Err(unsuited) => Err(unsuited),
        };
        match (found, self.fallback) {
            (Ok(clip_from_local), _) => {
                if let Some(spot) = view.spot() {
                    // For its note: the plane sets the depths of this map, not the light's perspective.
                    spot_depth_range(&spot, view, part.scene, &mut notes);
                }
                Ok(Provisional { clip_from_local, values, notes })
            }
            (Err(unsuited), Fallback::Uniform) => {
                notes.push(unsuited.why);
                let clip_from_local = uniform_rows(view, part.scene, &mut notes);
                Ok(Provisional { clip_from_local, values: Vec::new(), notes })
            }
            (Err(Unsuited { why, fix }), Fallback::None) => {
                Err(Error::UnsuitedView { technique: SPEC.name.into(), reason: why.reason(), fix: fix.into() })
            }
        }
    }
    fn needs(&self) -> Needs {
        if self.plane == Choice::Dominant { Needs::Surfaces } else { Needs::Nothing }
    }
}

impl PlaneOptimal {
    /// The plane, local to the view.
    fn plane(
        &self,
        view: &FocusedView,
        part: &Part,
        values: &mut Vec<Named>,
    ) -> Result<std::result::Result<Plane, Unsuited>> {
        let world = match (self.plane, part.samples) {
            (Choice::Given(plane), _) => plane,
            (Choice::Dominant, None) => {
                let fix = "hand over the samples of a small G-buffer, or give the plane";
                return Err(Error::argument("samples", "samples of what the camera sees", "none", fix));
            }
            (Choice::Dominant, Some(samples)) => match dominant_plane(view, &part.region, samples) {
                Some(found) => {
                    values.push(("plane_share", found.share));
                    Plane { normal: found.normal, offset: found.offset }.moved_to(-view.origin)
                }
                None => {
                    let samples = [("samples", samples.points.len() as f64)];
                    return Ok(Err(Unsuited::plane(Detail::NoSample, &samples)));
                }
            },
        };
        let (n, d) = (world.normal, world.offset);
        values.extend([("plane_x", n.x), ("plane_y", n.y), ("plane_z", n.z), ("plane_d", d)]);
        Ok(Ok(world.moved_to(view.origin)))
    }
}

/// The camera's rows through a plane (9.1), with w > 0 on the receivers' body.
fn through_plane(
    view: &FocusedView,
    part: &Part,
    plane: &Plane,
    values: &mut Vec<Named>,
) -> std::result::Result<Rows, Unsuited> {
    let (pi, light) = (plane.functional(), view.rays.point);
    let vertices = view.receivers.vertices();
    let farthest = |from: DVec3| vertices.iter().fold(0.0, |d: f64, p| d.max((*p - from).length()));
    // Of these two each is a height over the plane in a unit of which LEAST_KAPPA is nothing: a sine, or a share of a length.
    let light_height = pi.dot(light);
    let reach = if light.w == 0.0 { 1.0 } else { farthest(light.truncate()) };
    let light_in_plane = || Unsuited::plane(Detail::LightInPlane, &[]);
    if light_height.abs() <= LEAST_KAPPA * reach {
        return Err(light_in_plane());
    }
    // Beyond all digits of what is seen.
    if pi.w.abs() > farthest(view.eye) / f64::EPSILON {
        return Err(Unsuited::plane(Detail::PlaneTooFar, &[]));
    }
    // Of parallel rays the eye is a point at infinity, and its height a sine.
    let parallel = view.camera.is_orthographic();
    let eye_height = if parallel { pi.dot(view.camera.forward().extend(0.0)) } else { pi.dot(view.eye.extend(1.0)) };
    if eye_height.abs() <= LEAST_KAPPA * if parallel { 1.0 } else { farthest(view.eye) } {
        return Err(Unsuited::plane(Detail::EyeInPlane, &[]));
    }
    let [tx, ty] = view.camera.half_size().to_array();
    let row = |screen: DVec4| {
        // (9.1)
        let sheared = screen - pi * (screen.dot(light) / light_height);
        match light.w {
            // Zero on the light to the last bit (0.1).
            0.0 => (sheared.truncate() - light.truncate() * sheared.truncate().dot(light.truncate())).extend(sheared.w),
            _ => sheared,
        }
    };
    let from_eye = |v: DVec3| v.extend(-v.dot(view.eye));
    let (x, y) = (row(from_eye(view.camera.right() / tx)), row(from_eye(view.camera.up() / ty)));
    let w = if parallel { row(DVec4::W) } else { row(from_eye(view.camera.forward())) };
    // Parallel rays see all depths at one scale.
    let depths = if parallel { [1.0; 2] } else { view.eye_depth };
    let served = match view.outline {
        Some(outline) => {
            let w_row = outline.rays.homography(&Rows { x, y, z: DVec4::W, w }).row(2);
            let corners = outline.corners.iter().map(|p| w_row.dot(p.extend(1.0)));
            let (w_min, w_max) = corners.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), w| (a.min(w), b.max(w)));
            let floor = depths[0] / depths[1];
            if w_min < LEAST_SHARE.min(floor) * w_max || w_max <= 0.0 {
                let edges = part.samples.and_then(|s| s.ray_edges(&part.camera, &part.light, &part.region, MOST_EDGES));
                let edges = edges.map_or_else(Vec::new, |(_, edges)| edges);
                let found = leaned(outline, w_row, depths, &edges, &part.size);
                let (rows, lean) = found.ok_or_else(|| uncovered(view, part, plane, w))?;
                values.push(("lean", lean));
                return Ok(rows);
            }
            true
        }
        None => {
            let (w_min, w_max) = view.receivers.range(w);
            w_min > LEAST_LAMBDA * w_max
        }
    };
    if !served {
        return Err(uncovered(view, part, plane, w));
    }
    let z = match light.w {
        // ε of theory.md 9, from the middle of the receivers.
        0.0 => (-light.truncate()).extend(light.truncate().dot(view.middle())),
        // z / w = -1 / w grows away from the light, at which w vanishes.
        _ => DVec4::NEG_W,
    };
    let rows = Rows { x, y, z, w };
    let orientation = view.rays.orientation(&rows, view.middle());
    if orientation == 0.0 {
        return Err(light_in_plane());
    }
    values.push(("mirrored", f64::from(orientation < 0.0)));
    Ok(Rows { x: rows.x * orientation, ..rows })
}

/// What a plane leaves out: where w, the camera depth at which a receiver's light ray meets the plane, is not positive.
fn uncovered(view: &FocusedView, part: &Part, plane: &Plane, w: DVec4) -> Unsuited {
    let vertices = view.receivers.vertices();
    let behind = vertices.iter().filter(|p| w.dot(p.extend(1.0)) <= 0.0).count();
    let world = plane.moved_to(-view.origin);
    // To four places; adding zero takes the sign from one.
    let [x, y, z, d] =
        [world.normal.x, world.normal.y, world.normal.z, world.offset].map(|v| (v * 1e4).round() / 1e4 + 0.0);
    let mut why = vec![Detail::RaysBehindEye];
    let mut values = vec![("plane_x", x), ("plane_y", y), ("plane_z", z), ("plane_d", d)];
    values.extend([("behind", behind as f64), ("corners", vertices.len() as f64)]);
    if let Some(samples) = part.samples {
        let [near, far] = [part.camera.near(), part.camera.far()];
        let here = |p: &DVec3| (near..=far).contains(&part.camera.depth_of(*p)) && part.region.contains(*p);
        let (mut lost, mut all) = (0, 0);
        for p in samples.positions().filter(here) {
            all += 1;
            lost += usize::from(w.dot((p - view.origin).extend(1.0)) <= 0.0);
        }
        why.push(Detail::SamplesLost);
        values.extend([("samples", all as f64), ("lost", lost as f64)]);
    }
    Unsuited {
        why: Note::no_warp(&why, &values),
        fix: "give another plane, divide the view (z_partition, face_partition), or fallback=uniform for a uniform map here",
    }
}
