//! The bodies K and B against random points: theory.md 1.1, as properties.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;
use shadowlab::focus::{Coverage, Focus, FocusedView};
use shadowlab::geometry::{Aabb, ConvexBody, Frustum, Plane};
use shadowlab::scene::{Camera, DirectionalLight, Instance, Light, Mesh, Scene, SpotLight};

/// Rounding of a chain of cuts, as a share of the body's size.
const SHARE: f64 = 1e-9;

fn unit() -> impl Strategy<Value = DVec3> {
    let x = || -1.0..1.0_f64;
    (x(), x(), x()).prop_filter_map("a direction", |(x, y, z)| {
        let v = DVec3::new(x, y, z);
        (v.length() > 0.1).then(|| v.normalize())
    })
}

fn inside_cube() -> impl Strategy<Value = DVec3> {
    let x = || -1.0..1.0_f64;
    (x(), x(), x()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

/// A box of the given half extents, as a scene.
fn scene(half: DVec3) -> Scene {
    let corners = Aabb { min: DVec3::NEG_ONE, max: DVec3::ONE }.corners().map(|p| p.to_array());
    let mesh = Mesh::new(&corners, &[[0, 7, 1], [0, 7, 2], [0, 7, 4], [3, 5, 6]]).expect("a mesh");
    let world_from_mesh = DAffine3::from_mat3(DMat3::from_diagonal(half));
    Scene::new(vec![Arc::new(mesh)], vec![Instance { mesh: 0, world_from_mesh }]).expect("a scene")
}

fn camera(eye: DVec3, forward: DVec3, fov: f64) -> Camera {
    Camera::look_at(eye, eye + forward, forward.any_orthonormal_vector(), fov, 1.5, 0.1, 40.0).expect("a camera")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// A box cut by random planes holds a point if and only if every half-space and the box do.
    #[test]
    fn a_cut_body_is_the_intersection(
        planes in prop::collection::vec((unit(), -0.9..0.9_f64), 1..12),
        points in prop::collection::vec(inside_cube(), 40),
    ) {
        let bounds = Aabb { min: DVec3::NEG_ONE, max: DVec3::ONE };
        let mut body = ConvexBody::from_aabb(&bounds);
        let planes: Vec<Plane> = planes.iter().map(|(normal, d)| Plane { normal: *normal, offset: -d }).collect();
        planes.iter().for_each(|plane| body.clip(plane));
        for v in body.vertices() {
            prop_assert!(planes.iter().all(|plane| plane.distance(*v) < SHARE));
            prop_assert!(v.abs().max_element() < 1.0 + SHARE);
        }
        for p in points {
            let outside = planes.iter().map(|plane| plane.distance(p)).fold(f64::NEG_INFINITY, f64::max);
            if outside < -SHARE {
                prop_assert!(!body.is_empty() && body.distance_outside(p) < SHARE, "lost {p}");
            } else if outside > SHARE && !body.is_empty() {
                prop_assert!(body.distance_outside(p) > 0.0, "{p} was not cut off");
            }
        }
        // The support of the body is that of its vertices: compared with the points that count.
        let held = |p: &DVec3| planes.iter().all(|plane| plane.distance(*p) < 0.0);
        let (low, high) = body.range(DVec3::X.extend(0.0));
        for p in (0..400).map(|i| (DVec3::new(0.618, 0.7549, 0.5698) * f64::from(i)).fract() * 2.0 - 1.0).filter(held) {
            prop_assert!(low - SHARE < p.x && p.x < high + SHARE);
        }
    }

    /// Theory.md 1.1 for directional light: receivers are in K, their casters in B, and every vertex of B sees K along l.
    #[test]
    fn casters_of_receivers_lie_in_b(
        half in (0.05..9.0_f64, 0.0..6.0_f64, 0.05..9.0_f64),
        eye in inside_cube(), forward in unit(), l in unit(), fov in 0.2..2.4_f64,
        points in prop::collection::vec((inside_cube(), 0.0..1.0_f64), 60),
    ) {
        let half = DVec3::new(half.0, half.1, half.2);
        let (scene, camera) = (scene(half), camera(eye * 12.0, forward, fov));
        let light = Light::Directional(DirectionalLight::new(l).expect("a light"));
        let view = FocusedView::new(&scene, &camera, &light, Focus::SceneFit);
        let slack = SHARE * view.scene_box.diagonal() + SHARE * 40.0;
        let l = match light { Light::Directional(l) => l.direction(), _ => unreachable!("made above") };
        let (k, b) = (view.receivers, view.casters());
        for (p, share) in points {
            let p = view.scene_box.center() + p * 0.5 * view.scene_box.extent();
            if !view.camera_frustum().planes().iter().all(|plane| plane.distance(p) < -slack) {
                continue;
            }
            prop_assert!(view.coverage == Coverage::AsAsked && k.distance_outside(p) < slack, "K lost {p}");
            let caster = p - l * (share * view.scene_box.diagonal());
            if view.scene_box.contains(caster) {
                prop_assert!(b.distance_outside(caster) < slack, "B lost {caster}");
            }
        }
        if view.coverage == Coverage::AsAsked {
            // Across the light B has K's extents (so XY and the warp come from K alone); and B is no larger than it must be.
            for across in [l.any_orthonormal_pair().0, l.any_orthonormal_pair().1] {
                let (one, two) = (k.range(across.extend(0.0)), b.range(across.extend(0.0)));
                prop_assert!((one.0 - two.0).abs() < slack && (one.1 - two.1).abs() < slack, "{one:?} {two:?}");
            }
            // Along the light B spans what is found without making it.
            let (low, high) = b.range(l.extend(0.0));
            let along = view.casters_along(l);
            prop_assert!((along[0] - low).abs() < slack && (along[1] - high).abs() < slack, "{along:?} {low} {high}");
            for v in b.vertices() {
                let reach = k.swept_against(l, 2.0 * view.scene_box.diagonal());
                prop_assert!(reach.distance_outside(*v) < slack && (*v).clamp(view.scene_box.min, view.scene_box.max).distance(*v) < slack);
            }
        }
    }

    /// The same for a spot: K inside its pyramid, casters between it and the light in B.
    #[test]
    fn casters_of_a_spot_lie_in_b(
        eye in inside_cube(), forward in unit(), at in inside_cube(), l in unit(),
        cone in 0.1..2.8_f64, fov in 0.2..2.4_f64,
        points in prop::collection::vec((inside_cube(), 0.0..1.0_f64), 60),
    ) {
        let (scene, camera) = (scene(DVec3::new(6.0, 3.0, 8.0)), camera(eye * 12.0, forward, fov));
        let spot = SpotLight::new(at * 15.0, l, cone, 25.0).expect("a light");
        let view = FocusedView::new(&scene, &camera, &Light::Spot(spot), Focus::SceneFit);
        let pyramid: Frustum = view.spot().expect("a spot").frustum;
        let slack = SHARE * 100.0;
        for (p, share) in points {
            let p = view.scene_box.center() + p * 0.5 * view.scene_box.extent();
            let held = |p: DVec3| pyramid.planes().iter().all(|plane| plane.distance(p) < -slack);
            if !(held(p) && view.camera_frustum().planes().iter().all(|plane| plane.distance(p) < -slack)) {
                continue;
            }
            prop_assert!(view.receivers.distance_outside(p) < slack, "K lost {p}");
            let caster = p + (pyramid.apex - p) * share;
            if held(caster) && view.scene_box.contains(caster) {
                prop_assert!(view.casters().distance_outside(caster) < slack, "B lost {caster}");
            }
        }
        if view.coverage == Coverage::AsAsked {
            let depth = view.spot().expect("a spot").depth();
            prop_assert!(view.receivers.range(depth).0 > 0.0 && view.casters().range(depth).0 > 0.0);
        }
    }
}
