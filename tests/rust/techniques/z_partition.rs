//! Depth splits: those of the tables, given ones, those from samples, what is refused.

use glam::{DMat3, DMat4, DVec3};
use shadowlab::geometry::Rows;
use shadowlab::note::Kind;
use shadowlab::parameterization::Selection;
use shadowlab::scene::Light;
use shadowlab::techniques::technique_of;
use shadowlab::{Camera, Error, Parameterization, Scene};

use crate::support::by_body::by_body;
use crate::support::tables::{numbers, tables};
use crate::support::views::{self, Random, cube, directional, look, placed, samples_of};

/// Texels along a side of each map.
pub const RESOLUTION: u32 = 512;

/// Of f64 through a dozen operations on numbers of size 100.
const EXACT: f64 = 1e-9;

/// A body that fills the whole frustum of a camera at the origin that looks along -z.
pub fn filled(near: f64, far: f64, fov: f64) -> (Scene, Camera) {
    let room = DMat3::from_diagonal(DVec3::splat(3.0 * far));
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, fov, 1.0, near, far).expect("a camera");
    (placed(&[(cube(), room, DVec3::ZERO)]), camera)
}

/// The maps of a technique, with samples of what the camera sees.
pub fn maps(text: &str, scene: &Scene, camera: &Camera, light: &Light) -> Parameterization {
    let t = by_body(text);
    t.parameterize_seen(scene, camera, light, [RESOLUTION; 2], Some(&samples_of(scene, camera))).expect(text)
}

/// Begin of the first and the ends of all maps.
fn borders(p: &Parameterization) -> Vec<f64> {
    [p.partitions[0].eye_depth[0]].into_iter().chain(p.partitions.iter().map(|m| m.eye_depth[1])).collect()
}

fn assert_close(got: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(got.len(), expected.len(), "{got:?} {expected:?}");
    for (a, b) in got.iter().zip(expected) {
        assert!((a - b).abs() <= tolerance * b.abs(), "{got:?} {expected:?}");
    }
}

#[test]
fn splits_are_those_of_the_tables() {
    let table = &tables()["splits"];
    let (scene, camera) = filled(1.0, 100.0, 1.0);
    let light = directional(DVec3::NEG_Y);
    for (splits, key) in [("uniform", "uniform"), ("logarithmic", "log"), ("practical", "practical_0_5")] {
        for range in ["camera", "receivers"] {
            let p = maps(&format!("z_partition:splits={splits},range={range}"), &scene, &camera, &light);
            assert_close(&borders(&p), &numbers(&table[key]), EXACT);
            assert!(p.notes.is_empty() && p.selection == Selection::Depth, "{:?}", p.notes);
        }
    }
    // Where the scene ends before the camera does, so do the splits.
    let small = placed(&[(cube(), DMat3::from_diagonal(DVec3::splat(2.0)), DVec3::new(0.0, 0.0, -18.0))]);
    let p = maps("z_partition:splits=uniform,count=2", &small, &camera, &light);
    assert_close(&borders(&p), &[16.0, 18.0, 20.0], EXACT);
    let p = maps("z_partition:splits=uniform,count=2,range=camera", &small, &camera, &light);
    assert_close(&borders(&p), &[1.0, 50.5, 100.0], EXACT);
}

#[test]
fn warped_splits_are_those_of_the_tables() {
    let table = &tables()["zpartition_lispsm_overhead"];
    let fov = 2.0 * table["phi"].as_f64().expect("phi");
    let (scene, camera) = filled(1.0, 100.0, fov);
    let p = maps("z_partition:inner=lispsm", &scene, &camera, &directional(DVec3::NEG_Y));
    let splits = table["splits"].as_array().expect("splits");
    assert_eq!(p.partitions.len(), splits.len());
    let inset = f64::from(RESOLUTION - 2 * p.border_texels) / f64::from(RESOLUTION);
    for (map, split) in p.partitions.iter().zip(splits) {
        let [near, far, pn] = ["near", "far", "Pn"].map(|key| split[key].as_f64().expect(key));
        assert_close(&map.eye_depth, &[near, far], EXACT);
        // The table's is measured from the reference point to the near end, as ours is.
        assert_close(&[map.value("warp_distance").expect("a distance")], &[pn], EXACT);
        let flat: Vec<f64> = split["M"].as_array().expect("rows").iter().flat_map(numbers).collect();
        let expected = Rows::of(&DMat4::from_rows_array(flat.as_slice().try_into().expect("16 numbers")));
        let mut random = Random(5);
        for _ in 0..50 {
            let z = random.between(near, far);
            let across = z * (0.5 * fov).tan();
            let q = DVec3::new(random.between(-across, across), random.between(-across, across), -z);
            // x and y fill the inside of the border here, the whole map there; mirrored x is as good.
            let (got, there) = (map.project(q).0.truncate() / inset, expected.project(q).truncate());
            assert!((got.y - there.y).abs() < EXACT, "{got} {there}");
            assert!((got.x - there.x).abs().min((got.x + there.x).abs()) < EXACT, "{got} {there}");
        }
    }
}

#[test]
fn given_distances_are_kept_and_those_outside_leave_an_empty_split() {
    let (scene, camera) = filled(1.0, 100.0, 1.0);
    let light = directional(DVec3::new(0.1, -1.0, -0.2));
    let p = maps("z_partition:distances=(5,20,60)", &scene, &camera, &light);
    assert_close(&borders(&p), &[1.0, 5.0, 20.0, 60.0, 100.0], EXACT);
    let p = maps("z_partition:distances=(0.5,20,500)", &scene, &camera, &light);
    assert_close(&borders(&p), &[1.0, 1.0, 20.0, 100.0, 100.0], EXACT);
    let told = p.notes.iter().filter(|note| note.kind() == Kind::BorderOutside).count();
    assert_eq!(told, 2, "{:?}", p.notes);
    assert!(p.partitions.iter().all(|map| map.shadow_clip_from_world.is_finite()));
}

#[test]
fn an_overlap_begins_within_the_split_before() {
    let (scene, camera) = filled(1.0, 101.0, 1.0);
    let light = directional(DVec3::NEG_Y);
    let p = maps("z_partition:splits=uniform,overlap=0.2,count=4", &scene, &camera, &light);
    assert_close(&borders(&p), &[1.0, 26.0, 51.0, 76.0, 101.0], EXACT);
    let of = |name| p.partitions.iter().map(|map| map.value(name).expect("a depth")).collect::<Vec<f64>>();
    assert_close(&of("covered_near"), &[1.0, 21.0, 46.0, 71.0], EXACT);
    assert_close(&of("covered_far"), &[26.0, 51.0, 76.0, 101.0], EXACT);
    let at = |z: f64| DVec3::new(0.0, 0.0, -z);
    let inside = |k: usize, z: f64| p.partitions[k].project(at(z)).0.truncate().abs().max_element() <= 1.0;
    assert!(inside(1, 21.1) && !inside(1, 20.5), "as far as it overlaps");
    assert_eq!((p.choose(at(25.9), 25.9), p.choose(at(26.1), 26.1)), (Some(0), Some(1)), "no nearer is it chosen");
}

#[test]
fn splits_from_samples_follow_what_is_seen() {
    // A near box and a far wall with nothing between.
    let wall = DMat3::from_diagonal(DVec3::new(400.0, 400.0, 1.0));
    let near_box = (cube(), DMat3::from_diagonal(DVec3::new(0.4, 0.4, 0.4)), DVec3::new(0.0, 0.0, -3.0));
    let scene = placed(&[near_box, (cube(), wall, DVec3::new(0.0, 0.0, -201.0))]);
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 0.9, 1.4, 0.1, 500.0).expect("a camera");
    let light = directional(DVec3::new(0.1, -0.3, -1.0));
    let tight = |splits: &str, more: &str| {
        maps(&format!("z_partition:count=2,splits={splits},cover=samples{more}"), &scene, &camera, &light)
    };
    // Of f32 positions in an image of 64 pixels across.
    const SAMPLED: f64 = 1e-5;
    let p = tight("min-max", "");
    assert_close(&borders(&p), &[2.6, (2.6_f64 * 200.0).sqrt(), 200.0], SAMPLED);
    assert!(p.notes.iter().any(|note| note.kind() == Kind::CoversSamples), "{:?}", p.notes);
    let p = tight("equal-log", ",inner=lispsm");
    let [one, two] = [0, 1].map(|k| p.partitions[k].eye_depth);
    // The box shows its front alone, and the wall is one depth too: each has a split of a bin or less.
    assert!(one[0] > 2.59 && one[1] < 2.63 && two[0] > 198.0 && two[1] < 200.1, "{one:?} {two:?}");
    // All that could be seen is covered by default: the wall goes on to 202.
    let p = maps("z_partition:count=2,splits=equal-log", &scene, &camera, &light);
    assert_close(&[p.partitions[0].eye_depth[0], p.partitions[1].eye_depth[1]], &[2.6, 202.0], SAMPLED);
    assert_eq!(p.partitions[0].eye_depth[1], p.partitions[1].eye_depth[0]);
    // Nothing faces a light from behind the wall's front.
    let p = maps("z_partition:splits=equal-log", &scene, &camera, &directional(DVec3::Z));
    assert!(p.partitions.len() == 4 && p.notes[0].kind() == Kind::NoLitSample, "{:?}", p.notes);
}

#[test]
fn what_cannot_be_is_refused_and_says_why() {
    for (text, name, why) in [
        ("z_partition:distances=(5,3)", "distances", "ascending"),
        ("z_partition:stable=true,inner=lispsm", "inner", "uniform"),
        ("z_partition:stable=true,range=receivers", "range", "camera"),
        ("z_partition:stable=true,splits=min-max", "splits", "stand still"),
        ("z_partition:count=2,inner=uniform/uniform/lispsm", "inner", "no more techniques than splits"),
        ("z_partition:count=0", "count", "1 to 16"),
        ("z_partition:inner=(lispsm:nera=1)", "", "nera"),
        ("face_partition:inner=uniform/lispsm/uniform", "inner", "two"),
    ] {
        let error = technique_of(text).map(|t| format!("{:?}", t.settings())).unwrap_err();
        assert!(error.to_string().contains(why), "{text}: {error}");
        assert!(name.is_empty() || matches!(&error, Error::InvalidArgument { name: n, .. } if n == name), "{error}");
    }
    // Faces within faces.
    let (scene, camera) = filled(1.0, 100.0, 1.0);
    let nested = by_body("face_partition:inner=(face_partition:inner=face_partition)");
    let answer = nested.parameterize(&scene, &camera, &directional(DVec3::new(0.3, -0.2, 0.9)), RESOLUTION);
    assert!(matches!(answer, Err(Error::UnsuitedView { .. })), "{answer:?}");
}

#[test]
fn stable_splits_stand_still() {
    let (_, scene, camera) = views::by_hand().into_iter().find(|s| s.0 == "town").expect("the town");
    let light = directional(DVec3::new(0.4, -1.0, -0.3));
    let parameterize = |camera: &Camera| maps("z_partition:count=3,stable=true", &scene, camera, &light);
    let first = parameterize(&camera);
    let mut random = Random(3);
    for _ in 0..20 {
        let eye = camera.eye() + random.direction() * 3.0;
        let p = parameterize(&look(eye, eye + random.direction(), 1.1, 0.2, 300.0));
        assert_eq!(borders(&p), borders(&first));
        for (a, b) in p.partitions.iter().zip(&first.partitions) {
            assert_eq!(a.value("texel_x"), b.value("texel_x"));
            let texels = (a.project(DVec3::ZERO).0 - b.project(DVec3::ZERO).0) * 0.5 * f64::from(RESOLUTION);
            let moved = texels.truncate();
            assert!((moved - moved.round()).abs().max_element() < 1e-6, "{moved} texels");
        }
    }
}
