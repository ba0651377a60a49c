//! Perspective shadow maps: a shadow map of the scene as the camera's own projection leaves it.
//!
//! Source: Stamminger and Drettakis 2002 `[stamminger2002]` (PSM); Kozlov 2004 `[kozlov2004]` (the virtual camera that
//! slides back, the infinity plane, the inverse projection); theory.md 3. In post-perspective space a directional light
//! is a point on the infinity plane. Departures:
//! - The three cases (light parallel to the image plane, before the viewer, behind the viewer) are one formula. With
//!   h = C (-l, 0) the light there and q the images, all rows of the published matrices are multiples of the differences
//!   `h.w q - h`, which point along the light in every case and have no pole where h.w vanishes. The case is noted only.
//! - The axis of the light's camera is the mean direction of the images (theory.md 3.4). It leans towards the view just
//!   as far as keeps the light's own perspective from being deeper than 1 : 100 (theory.md 3.3), or than the camera's
//!   where that is deeper: always possible, as from straight ahead it is not.
//! - Map y is the direction in which w grows, so the near end is at y = -1; depth and crop come from the shared fit.
//!
//! ```text
//!   e' <-- slide --> e    near             far        post-perspective:    near ____ far   infinity
//!   x                x     |  receivers     |                                  |    |        *  light
//!                          |________________|                                  |____|
//! ```

use glam::{DVec2, DVec3};

use super::kit::light_projection::uniform_rows;
use super::kit::{
    Default, FIT, Kind, LEAST_KAPPA, LEAST_LAMBDA, LightSupport, MARGIN, ParamSpec, Part, Provisional, RANGE, SLACK,
    Settings, Spec, Warp,
};
use crate::error::Result;
use crate::focus::{Coverage, FocusedView};
use crate::geometry::Rows;
use crate::note::{self, Detail, Note};
use crate::rays::LightFrame;
use crate::scene::Light;

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "psm",
    title: "Perspective shadow map",
    source: "Stamminger, Drettakis 2002; Kozlov 2004",
    lights: LightSupport { directional: true, spot: false, point: false },
    params: &[
        ParamSpec {
            name: "slide",
            unit: "world units",
            default: Default::Choice("infinity"),
            kind: Kind::ChoiceOrNumber { words: &["infinity"], min: 0.0, max: f64::MAX },
            doc: "how far the virtual camera stands behind the real one: as far as puts the infinity plane where it is \
                  wanted, or a length; 0 is the camera itself, the strongest warp",
        },
        ParamSpec {
            name: "infinity",
            unit: "",
            // The least of the range that Kozlov's examples use, 1.5 to 2.5: the strongest warp among them.
            default: Default::Number(1.5),
            kind: Kind::Number { min: 1.0, max: f64::MAX },
            doc: "the least depth of the infinity plane in post-perspective space, where receivers lie in [0, 1]; a camera \
                  whose own is less slides back; 1 asks for nothing",
        },
        ParamSpec {
            kind: Kind::Choice(&["seen", "body", "camera"]),
            doc: "near and far of the virtual camera: the depths of the visible surfaces that face the light (seen), of the \
                  part of the scene's box inside the camera's frustum, most of it air (body), or the camera's own as \
                  published in 2002 (camera)",
            ..RANGE
        },
        FIT,
        MARGIN,
        SLACK,
    ],
};

/// The nearest image is at least this share of the farthest one's distance from the light (theory.md 3.3).
const LEAST_DISTANCE: f64 = 0.01;

/// Below this share the light's homogeneous w is called parallel (theory.md 3.3). Affects only the case name that is reported.
const PARALLEL: f64 = 1e-7;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Slide {
    Infinity(f64),
    Length(f64),
}

#[derive(Debug)]
struct Psm {
    slide: Slide,
    depths: Depths,
}

/// Near and far of the virtual camera.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Depths {
    Receivers,
    Camera,
}

/// The warp from checked settings.
pub fn make(settings: &Settings) -> Result<Box<dyn Warp>> {
    let slide = match settings.number("slide") {
        Some(length) => Slide::Length(length),
        None => Slide::Infinity(settings.declared_number("infinity")?),
    };
    let receivers = Depths::Receivers;
    let depths = settings.meaning("range", &[("seen", receivers), ("body", receivers), ("camera", Depths::Camera)])?;
    Ok(Box::new(Psm { slide, depths }))
}

impl Warp for Psm {
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional> {
        let mut notes = Vec::new();
        let (Light::Directional(light), Coverage::AsAsked) = (&view.light, view.coverage) else {
            return Ok(Provisional {
                clip_from_local: uniform_rows(view, part.scene, &mut notes),
                values: Vec::new(),
                notes,
            });
        };
        if view.camera.is_orthographic() {
            notes.push(Note::no_warp(&[Detail::ParallelRays], &[]));
            let gamma = view.camera.forward().angle_between(light.direction());
            return Ok(Provisional {
                clip_from_local: uniform_rows(view, part.scene, &mut notes),
                values: vec![("gamma", gamma)],
                notes,
            });
        }
        let camera = VirtualCamera::new(self.depth_range(view), self.slide, &mut notes);
        let space = PostPerspective::new(view, &camera, light.direction());
        let mut values = Vec::with_capacity(8);
        values.push(("gamma", view.camera.forward().angle_between(light.direction())));
        values.push(("slide", camera.slide));
        let clip_from_local = match space {
            Some(space) => {
                values.push(("z_infinity", space.infinity));
                values.push(("case", space.case()));
                let (axis, blend) = space.axis(&camera);
                values.push(("axis_blend", blend));
                space.rows(&camera, axis)
            }
            None => None,
        };
        let clip_from_local = clip_from_local.unwrap_or_else(|| {
            notes.push(Note::no_warp(&[Detail::EqualDistances], &[]));
            uniform_rows(view, part.scene, &mut notes)
        });
        Ok(Provisional { clip_from_local, values, notes })
    }
}

impl Psm {
    fn depth_range(&self, view: &FocusedView) -> [f64; 2] {
        match self.depths {
            Depths::Receivers => view.eye_depth,
            Depths::Camera => [view.camera.near(), view.camera.far()],
        }
    }
}

/// The camera that stands `slide` behind the real one and encloses its frustum (theory.md 3.1).
#[derive(Debug, Clone, Copy)]
struct VirtualCamera {
    slide: f64,
    /// Near and far depth of the real camera, and of this one.
    real: [f64; 2],
    depths: [f64; 2],
}

impl VirtualCamera {
    fn new([near, far]: [f64; 2], slide: Slide, notes: &mut Vec<Note>) -> Self {
        let asked = match slide {
            Slide::Length(length) => length,
            // (3.1), Kozlov: z_inf = f' / (f' - n') with n' = n + slide, f' = f + slide.
            Slide::Infinity(z) => (z * (far - near) - far).max(0.0),
        };
        // n' / f' bounds w; twice the least leaves room for the light's own perspective.
        let share = 2.0 * LEAST_LAMBDA;
        let least = ((share * far - near) / (1.0 - share)).max(0.0);
        if asked < least {
            let values = [("given", asked), ("least", least), ("near", near), ("far", far)];
            notes.push(Note::new(note::Kind::SlideRaised, &values));
        }
        // Beyond the largest the map is uniform to the last bit.
        let slide = asked.clamp(least, far / f64::EPSILON);
        Self { slide, real: [near, far], depths: [near + slide, far + slide] }
    }
}

/// The images q of the receivers in the virtual camera's clip space C, and the light's there, h = C (-l, 0).
#[derive(Debug, Clone, Copy)]
struct PostPerspective<'a> {
    view: &'a FocusedView<'a>,
    /// The way the light travels.
    along: DVec3,
    forward: DVec3,
    /// Clip x and y as vectors to be multiplied with p - eye.
    across: [DVec3; 2],
    /// z_inf = f' / (f' - n').
    infinity: f64,
    light: DVec3,
    /// h.w
    light_w: f64,
}

impl<'a> PostPerspective<'a> {
    /// Nothing where the virtual camera's depths are equal up to half of the digits.
    fn new(view: &'a FocusedView<'a>, camera: &VirtualCamera, along: DVec3) -> Option<Self> {
        let [near, far] = camera.depths;
        if far - near <= f64::EPSILON.sqrt() * far {
            return None;
        }
        // A shifted picture moves h and q alike, so that nothing below changes: its middle is left out.
        let [tx, ty] = view.camera.half_size().to_array();
        // tan' = tan f / f': the larger of n / n' and f / f', so that the real frustum is enclosed.
        let narrower = far / camera.real[1];
        let across = [view.camera.right() * (narrower / tx), view.camera.up() * (narrower / ty)];
        let forward = view.camera.forward();
        let infinity = far / (far - near);
        let light_w = -along.dot(forward);
        let light = DVec3::new(-along.dot(across[0]), -along.dot(across[1]), infinity * light_w);
        Some(Self { view, along, forward, across, infinity, light, light_w })
    }
    /// 1 the light comes from ahead, -1 from behind (inverse projection), 0 from the side.
    fn case(&self) -> f64 {
        if self.light_w.abs() <= PARALLEL * self.light.length() { 0.0 } else { self.light_w.signum() }
    }
    /// `h.w q - h` of each vertex of the receivers' body, which points along the light, and its depth before the virtual
    /// camera.
    fn images(&self, camera: &VirtualCamera) -> impl Iterator<Item = (DVec3, f64)> {
        let Self { view, across, forward, infinity, light, light_w, .. } = *self;
        let (slide, near) = (camera.slide, camera.real[0]);
        view.receivers.vertices().iter().map(move |p| {
            let d = *p - view.eye;
            let depth = forward.dot(d);
            let clip = DVec3::new(across[0].dot(d), across[1].dot(d), infinity * (depth - near));
            (clip * (light_w / (depth + slide)) - light, depth + slide)
        })
    }
    /// The axis of the light's camera along the light, and how far it leans from the mean direction towards the view.
    fn axis(&self, camera: &VirtualCamera) -> (DVec3, f64) {
        let sum: DVec3 = self.images(camera).map(|(image, _)| image.normalize()).sum();
        // All images lie on one side of the infinity plane: the sum does not vanish.
        let mean = sum.normalize();
        if self.light_w == 0.0 {
            return (mean, 0.0);
        }
        // From straight ahead w is constant: the light's perspective undoes the camera's.
        let ahead = DVec3::NEG_Z * self.light_w.signum();
        let [near, far] = camera.depths;
        let distances = || self.images(camera).map(|(image, depth)| ([mean.dot(image), ahead.dot(image)], depth));
        let by_distance = least_blend(|| distances().map(|(d, _)| d), (near / far).min(LEAST_DISTANCE));
        let by_w = least_blend(|| distances().map(|([a, b], depth)| [a * depth, b * depth]), LEAST_LAMBDA);
        let blend = by_distance.max(by_w);
        (mean.lerp(ahead, blend), blend)
    }
    /// The rows of light camera and virtual camera together; nothing where w is constant, so that no direction is the
    /// warp's.
    fn rows(&self, camera: &VirtualCamera, axis: DVec3) -> Option<Rows> {
        let Self { view, along, forward, across, infinity, light, light_w } = *self;
        // a·C = A·d - s (depth - n), d = p - eye; µ = -a·h.
        let a = across[0] * axis.x + across[1] * axis.y;
        let s = -infinity * axis.z;
        let mu = -axis.dot(light);
        let near = camera.real[0];
        // w = h.w a·C + µ C.w = G·d + w_eye with G = (A·l) v - (l·v) A = l x (v x A).
        let gradient = along.cross(forward.cross(a));
        let w_eye = camera.slide * mu + light_w * s * near;
        let (frame, steep) = LightFrame::towards(along, gradient)?;
        let local = |linear: DVec3, at_eye: f64| linear.extend(at_eye - linear.dot(view.eye));
        let w = local(frame.up * steep, w_eye);
        let (w_min, w_max) = view.receivers.range(w);
        if w_max - w_min <= LEAST_KAPPA * w_max {
            return None;
        }
        // Modulo w both a·C and -C.w / h.w are the depth of the light's camera; together they have no pole. It grows by 1
        // with each unit along the light.
        let norm = mu * mu + light_w * light_w;
        let z_linear = ((a - forward * s) * mu - forward * light_w) / norm;
        let z_eye = (mu * s * near - light_w * camera.slide) / norm;
        // r·C with r across axis and view, sheared along the light.
        let turn = DVec2::new(-axis.y, axis.x).normalize();
        let r = across[0] * turn.x + across[1] * turn.y;
        let sheared = r - z_linear * r.dot(along);
        // Per unit across, as y is. Positive keeps the winding that the light sees (theory.md 0), for which the published
        // inverted case mirrors its right.
        let side = frame.right.dot(sheared);
        let x_linear = frame.right + frame.up * (frame.up.dot(sheared) / side);
        let x_eye = -r.dot(along) * z_eye / side;
        let (y_min, _) = view.receivers.range(frame.up.extend(0.0));
        Some(Rows {
            x: local(x_linear, x_eye),
            // Equal to the light camera's own y up to the crop, which is a constant over w.
            y: frame.up.extend(-y_min),
            z: local(z_linear, z_eye),
            w: w / w_max,
        })
    }
}

/// The least share t in [0, 1] at which the smallest of the values `(1 - t) a + t b` is at least `floor` times the largest;
/// 1 where none is.
///
/// Smallest minus `floor` times largest is concave in t, so Newton's steps from 0 stay before the root and reach it after as
/// many steps as it has corners on the way.
fn least_blend<I: Iterator<Item = [f64; 2]>>(values: impl Fn() -> I, floor: f64) -> f64 {
    let mut t = 0.0;
    while t < 1.0 {
        let at = |v: &[f64; 2]| v[0] + (v[1] - v[0]) * t;
        let by_value = |a: &[f64; 2], b: &[f64; 2]| at(a).total_cmp(&at(b));
        let (Some(low), Some(high)) = (values().min_by(by_value), values().max_by(by_value)) else { return t };
        let gap = at(&low) - floor * at(&high);
        if gap >= 0.0 {
            return t;
        }
        let slope = (low[1] - low[0]) - floor * (high[1] - high[0]);
        let next = if slope > 0.0 { t - gap / slope } else { 1.0 };
        // Rounding: as near to the root as the digits allow.
        if next <= t {
            return t;
        }
        t = next.min(1.0);
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_blend_is_the_root_of_the_concave_gap() {
        let blend = |values: &[[f64; 2]], floor: f64| least_blend(|| values.iter().copied(), floor);
        assert_eq!(blend(&[[0.5, 0.1], [1.0, 1.0]], 0.5), 0.0);
        // 0.1 + 0.4 t against 0.25: the highest stays 1.
        assert!((blend(&[[0.1, 0.5], [1.0, 1.0]], 0.25) - 0.375).abs() < 1e-15);
        // Another value is the smallest where it ends: (-1 + 2 t) rules first, (0.2 + 0.05 t) at the end.
        let values = [[-1.0, 1.0], [0.2, 0.25], [1.0, 1.0]];
        let t = blend(&values, 0.22);
        let at = |v: &[f64; 2]| v[0] + (v[1] - v[0]) * t;
        let low = values.iter().map(at).fold(f64::INFINITY, f64::min);
        assert!((low - 0.22).abs() < 1e-15, "{low}");
        assert_eq!(blend(&[[0.1, 0.2], [1.0, 1.0]], 0.5), 1.0);
    }
}
