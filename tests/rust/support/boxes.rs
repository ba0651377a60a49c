//! What a view can see, be lit by and be shaded by, as points of the boxes of its instances: an oracle that knows rays and
//! boxes, and nothing of maps.

use glam::{DMat3, DVec3};
use shadowlab::fit::MapSize;
use shadowlab::focus::{Coverage, Focus, FocusedView, Samples};
use shadowlab::geometry::{ConvexBody, OrientedBox};
use shadowlab::scene::{Camera, Light, Scene, SpotLight};

use crate::support::views::Random;

/// The part of the view that one light with a frustum or a direction reaches: all of it, or a point light's face.
pub struct Lit {
    pub view: FocusedView<'static>,
    /// Of each instance, what can be seen and lit; empty for most.
    pub seen: Vec<ConvexBody>,
}

pub struct Boxes {
    pub light: Light,
    /// The local origin, world.
    pub origin: DVec3,
    /// All instances, local.
    pub boxes: Vec<OrientedBox>,
    /// The lit parts in which anything is seen.
    pub parts: Vec<Lit>,
    /// Casters nearer to a placed light than this need not be in a map.
    pub nearest: f64,
}

/// A receiver and what lies above it.
pub struct Receiver {
    /// Local.
    pub p: DVec3,
    /// The normal of its box's side, towards the eye; only for samples.
    pub normal: DVec3,
}

impl Boxes {
    pub fn new(scene: &Scene, camera: &Camera, light: &Light, resolution: u32) -> Self {
        let lights: Vec<Light> = match light {
            Light::Point(p) => {
                let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
                let face = |axis| SpotLight::new(p.position(), axis, std::f64::consts::FRAC_PI_2, p.range());
                axes.iter().map(|axis| Light::Spot(face(*axis).expect("a face"))).collect()
            }
            other => vec![*other],
        };
        let origin = camera.eye();
        let placed = |i| OrientedBox::new(scene.mesh_of(i).bounds_local(), &scene.world_from_local(i), origin);
        let boxes: Vec<OrientedBox> = (0..scene.instances().len()).map(placed).collect();
        let mut nearest: f64 = 0.0;
        let mut parts = Vec::new();
        for light in lights {
            let view = FocusedView::new(scene, camera, &light, Focus::SceneFit);
            if let Some(spot) = view.spot() {
                // A point at this depth along the axis may be that much farther away, at a corner of the map with its border.
                let inset = MapSize::new([resolution; 2]).expect("a size").inset();
                let slant = 1.0_f64.hypot(spot.frustum.half[0] / inset.x * std::f64::consts::SQRT_2);
                nearest = nearest.max(spot.frustum.near * slant);
            }
            if view.coverage == Coverage::NothingSeen {
                continue;
            }
            let scene_planes = view.scene_planes();
            let seen = |b: &OrientedBox| {
                let mut body = ConvexBody::from_oriented_box(b);
                view.receiver_planes().chain(&scene_planes).for_each(|plane| body.clip(plane));
                body
            };
            parts.push(Lit { seen: boxes.iter().map(seen).collect(), view });
        }
        Self { light: *light, origin, boxes, parts, nearest }
    }
    /// A random receiver, local: a corner of what is seen of an instance, a point between corners, or one inside.
    pub fn receiver(&self, random: &mut Random) -> Option<Receiver> {
        if self.parts.is_empty() {
            return None;
        }
        let part = &self.parts[random.below(self.parts.len())];
        let filled: Vec<usize> = (0..part.seen.len()).filter(|&i| !part.seen[i].is_empty()).collect();
        let i = *filled.get(random.below(filled.len().max(1)))?;
        let corners = part.seen[i].vertices();
        let corner = |random: &mut Random| corners[random.below(corners.len())];
        let p = match random.below(4) {
            0 => corner(random),
            1 => corner(random).lerp(corner(random), random.unit()),
            _ => {
                let weights = [random.unit(), random.unit(), random.unit(), random.unit()];
                let sum: f64 = weights.iter().sum();
                weights.iter().map(|w| corner(random) * (w / sum.max(f64::MIN_POSITIVE))).sum()
            }
        };
        let within = match self.light {
            // Near its own edge a face may be served by the next one, whose map may begin later.
            Light::Point(l) => (self.nearest..=l.range()).contains(&(p + self.origin - l.position()).length()),
            _ => true,
        };
        let normal = self.boxes[i].normals()[random.below(6)];
        let normal = if normal.dot(part.view.camera.way_to(p)) > 0.0 { -normal } else { normal };
        within.then_some(Receiver { p, normal })
    }
    /// Points as a renderer would hand over, with the normals of their boxes' sides.
    pub fn samples(&self, random: &mut Random, count: usize) -> Samples {
        let seen: Vec<Receiver> = (0..count).filter_map(|_| self.receiver(random)).collect();
        let (points, normals): (Vec<DVec3>, Vec<DVec3>) = seen.iter().map(|r| (r.p + self.origin, r.normal)).unzip();
        Samples::of_points(&points, &normals)
    }
    /// Casters above a local point, local: the far end of each box on its ray to the light, or a point between the ends.
    pub fn casters(&self, p: DVec3, random: &mut Random) -> Vec<DVec3> {
        let to_light = self.light.to_light(p + self.origin);
        let placed = !matches!(self.light, Light::Directional(_));
        let mut found = Vec::new();
        for b in &self.boxes {
            let Some((near, far)) = through(b, p, to_light) else { continue };
            let end = if placed { far.min(1.0 - self.nearest / to_light.length()) } else { far };
            let at = if random.below(2) == 0 { end } else { random.between(near, end) };
            // A point that shares the receiver's rounding is the receiver.
            let apart = at * to_light.length() > 1e-9 * (p.length() + to_light.length() * f64::from(placed));
            let caster = p + to_light * at;
            // Boxes may stick out of the scene's, their meshes do not.
            if at > 0.0 && end >= near && apart && self.parts.iter().all(|part| part.view.scene_box.contains(caster)) {
                found.push(caster);
            }
        }
        found
    }
}

/// Where the ray from p along d runs through a box, in units of d from 0 on: two ends, which agree where the box is flat.
fn through(b: &OrientedBox, p: DVec3, d: DVec3) -> Option<(f64, f64)> {
    let flat = b.half.iter().position(|h| *h == DVec3::ZERO);
    let mut half = b.half;
    if let Some(k) = flat {
        half[k] = half[(k + 1) % 3].cross(half[(k + 2) % 3]).try_normalize()?;
    }
    let into = DMat3::from_cols(half[0], half[1], half[2]).inverse();
    let (at, along) = (into * (p - b.center), into * d);
    if !(at.is_finite() && along.is_finite()) {
        return None;
    }
    let (mut near, mut far) = (0.0_f64, f64::INFINITY);
    for axis in 0..3 {
        // A flat box ends where its plane is. One in whose plane the point lies up to rounding does not shade it.
        let reach = if flat == Some(axis) { 0.0 } else { 1.0 };
        if flat == Some(axis) && at[axis].abs() <= 1e-9 * (p.length() + b.center.length()) {
            return None;
        }
        if along[axis] == 0.0 {
            if at[axis].abs() > reach {
                return None;
            }
            continue;
        }
        let (s, t) = ((-reach - at[axis]) / along[axis], (reach - at[axis]) / along[axis]);
        (near, far) = (near.max(s.min(t)), far.min(s.max(t)));
    }
    (near <= far && far.is_finite()).then_some((near, far))
}

#[test]
fn a_ray_runs_through_solid_and_flat_boxes() {
    let solid = OrientedBox { center: DVec3::new(0.0, 5.0, 0.0), half: [DVec3::X, DVec3::Y, DVec3::Z * 2.0] };
    assert_eq!(through(&solid, DVec3::ZERO, DVec3::Y * 2.0), Some((2.0, 3.0)));
    assert_eq!(through(&solid, DVec3::new(0.0, 5.0, 0.0), DVec3::Y), Some((0.0, 1.0)));
    assert!(through(&solid, DVec3::X * 1.5, DVec3::Y).is_none());
    let flat = OrientedBox { half: [DVec3::X, DVec3::ZERO, DVec3::Z], ..solid };
    let (near, far) = through(&flat, DVec3::ZERO, DVec3::new(0.1, 1.0, 0.0)).expect("through it");
    assert!((near - 5.0).abs() < 1e-12 && (far - 5.0).abs() < 1e-12);
    assert!(through(&flat, DVec3::X * 0.9, DVec3::new(0.1, 1.0, 0.0)).is_none());
}
