//! The faces of the camera's frustum: which get a map, and which rays each of them has.

use glam::{DMat3, DVec3};
use shadowlab::Parameterization;
use shadowlab::geometry::Frustum;
use shadowlab::note::Kind;
use shadowlab::parameterization::Selection;
use shadowlab::scene::{Light, SpotLight};

use super::z_partition::{filled, maps};
use crate::support::views::{Random, directional, look, placed, square};

/// Faces of the camera's frustum by the map's number.
fn faces(p: &Parameterization) -> Vec<usize> {
    p.partitions.iter().map(|map| map.value("face").expect("a face") as usize).collect()
}

#[test]
fn the_faces_are_those_through_which_light_leaves() {
    let (scene, camera) = filled(1.0, 100.0, 1.0);
    let faces_of = |d: DVec3| faces(&maps("face_partition", &scene, &camera, &directional(d)));
    let [left, right, bottom, top, near, far] = [0, 1, 2, 3, 4, 5];
    assert_eq!(faces_of(DVec3::NEG_Z), [far], "along the view");
    assert_eq!(faces_of(DVec3::Z), [left, right, bottom, top, near], "against the view");
    assert_eq!(faces_of(DVec3::NEG_Y), [bottom], "from above, along the far face");
    assert_eq!(faces_of(DVec3::new(0.0, -1.0, -0.1)), [bottom, far]);
    assert_eq!(faces_of(DVec3::new(0.0, -1.0, 0.1)), [left, right, bottom, near], "the sides open away from the eye");
    // Half of the field of view is 0.5 across and down: a side is left through by light steeper than that.
    assert_eq!(faces_of(DVec3::new(0.5_f64.tan() * 1.01, 0.0, -1.0)), [right, far]);
    assert_eq!(faces_of(DVec3::new(0.5_f64.tan() * 0.99, 0.0, -1.0)), [far]);
    // Sides get the first technique, ends the second.
    let p = maps("face_partition", &scene, &camera, &directional(DVec3::new(0.3, -1.0, -0.2)));
    assert_eq!(p.selection, Selection::Containment);
    let made: Vec<_> = p.partitions.iter().map(|map| map.technique).collect();
    assert_eq!((faces(&p), made), (vec![right, bottom, far], vec!["lispsm", "lispsm", "uniform"]));
    // A light at the eye, and one within the frustum.
    let spot =
        |z: f64, cone: f64| Light::Spot(SpotLight::new(DVec3::Z * z, DVec3::NEG_Z, cone, 300.0).expect("a spot"));
    assert_eq!(faces(&maps("face_partition", &scene, &camera, &spot(0.0, 0.9))), [far]);
    assert_eq!(faces(&maps("face_partition", &scene, &camera, &spot(-30.0, 2.0))), [left, right, bottom, top, far]);
}

/// The face through which light from a point leaves a frustum: where it first meets a plane.
fn leaves_through(frustum: &Frustum, q: DVec3, along: DVec3) -> (usize, f64) {
    let until = frustum.planes().map(|plane| {
        let rate = plane.normal.dot(along);
        if rate > 0.0 { -plane.distance(q) / rate } else { f64::INFINITY }
    });
    let first = (0..6).min_by(|&a, &b| until[a].total_cmp(&until[b])).expect("a face");
    let next = (0..6).filter(|&i| i != first).map(|i| until[i]).fold(f64::INFINITY, f64::min);
    (first, next - until[first])
}

#[test]
fn every_ray_is_in_the_region_of_the_face_it_leaves_through() {
    let (scene, camera) = filled(1.0, 30.0, 1.1);
    let frustum = camera.frustum_at(camera.eye());
    let [tx, ty] = frustum.half;
    let mut random = Random(23);
    let mut checked = [0; 6];
    for i in 0..60 {
        let light = if i % 2 == 0 {
            directional(random.direction())
        } else {
            let at = DVec3::new(random.between(-25.0, 25.0), random.between(-25.0, 25.0), random.between(-40.0, 10.0));
            let towards = DVec3::new(0.0, 0.0, -15.0) - at;
            Light::Spot(SpotLight::new(at, towards, 2.9, 500.0).expect("a spot"))
        };
        let p = maps("face_partition:inner=uniform", &scene, &camera, &light);
        let all = faces(&p);
        for _ in 0..200 {
            let z = random.between(1.0, 30.0);
            let q = DVec3::new(random.between(-z * tx, z * tx), random.between(-z * ty, z * ty), -z);
            if !light.reaches(q) {
                continue;
            }
            let (face, margin) = leaves_through(&frustum, q, -light.to_light(q));
            let holds: Vec<usize> = (0..all.len()).filter(|&k| p.partitions[k].region.contains(q)).collect();
            // On a border it is in both.
            if margin > 1e-9 {
                assert_eq!(holds.iter().map(|&k| all[k]).collect::<Vec<_>>(), [face], "{light:?} {q}");
                checked[face] += 1;
            }
            assert!(!holds.is_empty());
            assert_eq!(p.choose(q, z), Some(holds[0]), "{light:?} {q}");
        }
    }
    assert!(checked.iter().all(|&n| n > 50), "every face is left through: {checked:?}");
}

#[test]
fn faces_behind_which_nothing_is_seen_get_no_map() {
    let floor = placed(&[(square(), DMat3::from_diagonal(DVec3::new(5.0, 1.0, 5.0)), DVec3::ZERO)]);
    let camera = look(DVec3::new(0.0, 6.0, 20.0), DVec3::ZERO, 0.9, 0.1, 500.0);
    let p = maps("face_partition", &floor, &camera, &directional(DVec3::new(0.05, -1.0, -0.4)));
    assert_eq!(faces(&p), [2], "{:?}", p.notes);
    assert!(p.notes.iter().any(|note| note.kind() == Kind::FaceUnseen), "{:?}", p.notes);
}
