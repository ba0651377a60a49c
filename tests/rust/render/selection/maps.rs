//! Parameterizations of several maps, made by hand: what schemes return, without them.

use glam::{DMat4, DVec3, DVec4};
use shadowlab::parameterization::{Parameterization, Partition, Region, Selection};
use shadowlab::rays::LightFrame;
use shadowlab::scene::{PointLight, library};
use shadowlab::{Camera, Light, Scene};

use crate::support::by_body::by_body;

/// Many maps that are one.
pub const SAME: &str = "the same map eight times";

/// A view, its light and its maps.
pub struct View {
    pub name: String,
    pub scene: Scene,
    pub camera: Camera,
    pub light: Light,
    pub p: Parameterization,
    /// One map for the whole view, where the light has one.
    pub whole: Option<Parameterization>,
}

/// Maps of parts of the view by depth: `count` of them, as wide in the logarithm of depth as each other.
pub fn cascades(scene: &Scene, camera: &Camera, light: &Light, count: usize, inner: &str) -> Parameterization {
    let technique = by_body(inner);
    let split = |i: usize| camera.near() * (camera.far() / camera.near()).powf(i as f64 / count as f64);
    let mut whole: Option<Parameterization> = None;
    for i in 0..count {
        let (near, far) = (split(i), split(i + 1));
        let part = camera.with_depths(near, far).unwrap();
        // A part of the view that shows nothing has no map.
        let Ok(mut p) = technique.parameterize(scene, &part, light, 1024) else { continue };
        p.partitions.iter_mut().for_each(|m| m.eye_depth = [near, far]);
        match &mut whole {
            Some(whole) => whole.partitions.extend(p.partitions),
            None => whole = Some(p),
        }
    }
    whole.expect("something is in view")
}

/// The six faces of the cube around a point light, each a little wider than its region.
pub fn faces(light: &PointLight, near: f64, far: f64) -> Parameterization {
    /// Half a texel of 1024 beside the border: the filter's reach.
    const WIDER: f64 = 1.01;
    let apex = light.position();
    let face = |along: DVec3| {
        let frame = LightFrame::any(along);
        let matrix = frame.perspective(apex, WIDER, near, far).matrix();
        let functional = |n: DVec3| n.extend(-n.dot(apex));
        let sides = [frame.right, -frame.right, frame.up, -frame.up];
        let region = Region::new(&sides.map(|side| functional(along - side)));
        Partition { region, ..Partition::of_matrix(matrix) }
    };
    let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let mut p = Parameterization::of_partitions(axes.map(face).to_vec(), [1024; 2]);
    p.selection = Selection::Containment;
    p
}

/// One map cut in two by a plane that holds the light's rays.
pub fn halves(whole: &Parameterization, plane: DVec4) -> Parameterization {
    let half = |plane: DVec4| Partition { region: Region::new(&[plane]), ..whole.partitions[0].clone() };
    let mut p = Parameterization { partitions: vec![half(plane), half(-plane)], ..whole.clone() };
    p.selection = Selection::Containment;
    p
}

/// The same with a strip between the two that nobody serves.
pub fn halves_apart(whole: &Parameterization, plane: DVec4, half_width: f64) -> Parameterization {
    let mut p = halves(whole, plane);
    for (partition, plane) in p.partitions.iter_mut().zip([plane, -plane]) {
        partition.region = Region::new(&[plane - half_width * plane.truncate().length() * DVec4::W]);
    }
    p
}

/// The same map many times, each for a part of the view's depth.
pub fn repeated(whole: &Parameterization, camera: &Camera, count: usize) -> Parameterization {
    let split = |i: usize| camera.near() * (camera.far() / camera.near()).powf(i as f64 / count as f64);
    let one = |i| Partition { eye_depth: [split(i), split(i + 1)], ..whole.partitions[0].clone() };
    Parameterization { partitions: (0..count).map(one).collect(), ..whole.clone() }
}

/// A point light in the middle of what a scene holds, at a share of its height.
pub fn lamp(scene: &Scene, at: DVec3) -> PointLight {
    let bounds = scene.bounds();
    PointLight::new(bounds.min + bounds.extent() * at, bounds.diagonal()).unwrap()
}

/// Views of library scenes with many kinds of several maps.
pub fn views() -> Vec<View> {
    let mut all = vec![];
    for name in ["robots", "courtyard", "dueling"] {
        let library::LibraryScene { scene, camera, light, .. } = library::build(name, 1, &[]).unwrap();
        let whole = by_body("lispsm").parameterize(&scene, &camera, &light, 1024).unwrap();
        let mut push = |kind: &str, light: Light, p: Parameterization| {
            let (scene, name) = (scene.clone(), format!("{name}, {kind}"));
            let whole = (!matches!(light, Light::Point(_))).then(|| whole.clone());
            all.push(View { name, scene, camera, light, p, whole });
        };
        for inner in ["uniform", "lispsm"] {
            let p = cascades(&scene, &camera, &light, 4, inner);
            push(&format!("four of {inner}"), light, p.clone());
            push(&format!("four of {inner}, by containment"), light, {
                Parameterization { selection: Selection::Containment, ..p }
            });
        }
        let to_light = light.point().truncate();
        let n = to_light.cross(camera.forward()).normalize();
        let middle = camera.eye() + camera.forward();
        if light.point().w == 0.0 {
            push("two halves", light, halves(&whole, n.extend(-n.dot(middle))));
        }
        push(SAME, light, repeated(&whole, &camera, 8));
        let point = lamp(&scene, DVec3::new(0.52, 0.7, 0.47));
        let range = point.range();
        push("six faces", Light::Point(point), faces(&point, 1e-3 * range, range));
        // What schemes make of it.
        for text in ["z_partition:count=3,inner=lispsm", "face_partition:inner=uniform"] {
            let p = by_body(text).parameterize(&scene, &camera, &light, 1024).unwrap();
            push(text, light, p);
        }
        let p = by_body("lispsm");
        let p = p.parameterize(&scene, &camera, &Light::Point(point), 1024).unwrap();
        push("lispsm of a point light", Light::Point(point), p);
    }
    all
}

/// The map alone, for all receivers.
pub fn alone(p: &Parameterization, k: usize) -> Parameterization {
    let one = Partition { region: Region::ALL, eye_depth: [0.0, f64::INFINITY], ..p.partitions[k].clone() };
    Parameterization { partitions: vec![one], ..p.clone() }
}

/// A matrix that shows nothing of the world.
pub fn nowhere() -> DMat4 {
    DMat4::from_translation(DVec3::splat(1e9))
}
