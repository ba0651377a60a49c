//! Where the footprint has no number to tell: singular maps, nothing to measure in, light along a surface, exponents at the ends.

use glam::{DMat4, DVec3, DVec4};
use proptest::prelude::*;
use shadowlab::aliasing::footprint::{footprint, footprint_at};
use shadowlab::image::Footprint;
use shadowlab::{Parameterization, Progress};

use super::degenerate::{SIZE, SIZES, assert_finite, assert_sound, floor, maps_of, number, of_matrix, refused, vector};
use super::images::{image, views};
use super::measured::{PROJECTION, Picture, at, gbuffer};
use crate::support::by_body::by_body;
use crate::support::views::{View, by_hand, directional};

#[test]
fn singular_matrices_hold_nothing() {
    let v = &views()[0];
    let g = gbuffer(v, SIZE);
    let zero = DVec4::ZERO;
    let mut met = 0;
    let w = DVec4::W;
    let rows = [
        ("zero", [zero; 4]),
        ("no x", [zero, DVec4::Y * 0.01, DVec4::Z * 0.01, w]),
        ("no y", [DVec4::X * 0.01, zero, DVec4::Z * 0.01, w]),
        ("x and y the same", [DVec4::X * 0.01, DVec4::X * 0.01, DVec4::Z * 0.01, w]),
        ("w everywhere zero", [DVec4::X, DVec4::Y, DVec4::Z, zero]),
        ("constants", [w * 0.5, w * 0.5, w * 0.5, w]),
    ];
    for (what, [x, y, z, w]) in rows {
        let m = DMat4::from_cols(x, y, z, w).transpose();
        // Before a good map it is still the one that is looked up in, where it holds a point.
        let good = maps_of(v, "uniform");
        let both = [of_matrix(m).partitions, good.partitions.clone()].concat();
        for p in [of_matrix(m), Parameterization { partitions: both, ..good }] {
            let f = image(v, &g, &p);
            assert_sound(what, &f, p.partitions.len());
            let points: Vec<_> = (0..g.triangle.len()).filter_map(|i| Some((i, g.surfaces().receiver(i)?))).collect();
            let (places, normals): (Vec<_>, Vec<_>) = points.iter().map(|(_, (q, n))| (*q + g.origin, *n)).unzip();
            let mut held = 0;
            for (((i, _), (code, _)), q) in points.iter().zip(at(v, &p, SIZES, &places, &normals)).zip(&places) {
                let expected = match p.choose(*q, v.camera.depth_of(*q)) {
                    _ if f.map[*i] == Footprint::AVERTED => Footprint::AVERTED,
                    Some(k) if k + 1 == p.partitions.len() && k > 0 => k as i16,
                    _ => Footprint::NO_MAP,
                };
                assert_eq!(code, expected, "{what}: the point of pixel {i} of {} maps", p.partitions.len());
                assert_eq!(f.map[*i], expected, "{what}: pixel {i} of {} maps", p.partitions.len());
                held += usize::from(expected >= 0);
            }
            assert!(held == 0 || p.partitions.len() == 2, "{what}: {held} held by a singular map");
            met += held;
        }
    }
    assert!(met > 1000, "{met}");
}

#[test]
fn a_normal_for_every_point() {
    let v = floor(DVec3::NEG_Y);
    let good = maps_of(&v, "uniform");
    for (points, normals) in [(2, 3), (3, 2), (0, 1), (1, 0)] {
        let (points, normals) = (vec![[0.0, 0.0, -8.0]; points], vec![[0.0, 1.0, 0.0]; normals]);
        let found = footprint_at(&points, &normals, &v.camera, &v.light, &good, SIZES.map, SIZE);
        assert_eq!(refused(found), "normals", "{} points, {} normals", points.len(), normals.len());
    }
}

#[test]
fn maps_and_images_have_texels_and_pixels() {
    let v = floor(DVec3::NEG_Y);
    let (g, good) = (gbuffer(&v, SIZE), maps_of(&v, "uniform"));
    let (points, normals) = ([[0.0, 0.0, -8.0]], [[0.0, 1.0, 0.0]]);
    for none in [[0, 512], [512, 0], [0, 0]] {
        let image = footprint(&g.surfaces(), &v.camera, &v.light, &good, none, &Progress::new());
        assert_eq!(refused(image.map(|f| Picture::of(&f).count(Footprint::NO_MAP))), "resolution", "{none:?}");
        let found = footprint_at(&points, &normals, &v.camera, &v.light, &good, none, SIZE);
        assert_eq!(refused(found), "resolution", "{none:?}");
        let found = footprint_at(&points, &normals, &v.camera, &v.light, &good, SIZES.map, none);
        assert_eq!(refused(found), "size", "{none:?}");
    }
}

#[test]
fn a_wall_along_the_light_is_edge_on() {
    // Its normal is level up to a rounding of f32, and so is the angle under which light meets it: a projection error above the
    // inverse of that is noise, and would drown the mean of any image.
    let known = 1.0 / f64::from(f32::EPSILON);
    let (_, scene, camera) = by_hand().into_iter().find(|s| s.0 == "town").expect("the town");
    let v = View { name: "noon".into(), scene, camera, light: directional(DVec3::NEG_Y) };
    let p = by_body("uniform").parameterize(&v.scene, &v.camera, &v.light, 512).expect("a map");
    let g = gbuffer(&v, [193, 140]);
    let f = image(&v, &g, &p);
    let walls = (0..f.map.len()).filter(|&i| g.triangle[i] >= 0 && g.normal[i][1].abs() < 0.5);
    let (mut edge_on, mut all) = (0, 0);
    for i in walls {
        all += 1;
        edge_on += usize::from(f.map[i] == Footprint::AVERTED);
        assert!(f.map[i] < 0 || f64::from(f.numbers[i][PROJECTION]) <= known, "pixel {i}: {:?}", g.normal[i]);
    }
    assert!(all > 500 && edge_on > 100, "{edge_on} of {all}");
}

/// Numbers of all sizes that f64 has.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![3 => number(), 1 => any::<f64>().prop_filter("finite", |x| x.is_finite())]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_texel_is_nan_whatever_the_exponents(
        m in prop::collection::vec(any_number(), 16),
        q in vector(any_number().boxed()),
        n in vector(any_number().boxed()),
        log in any::<bool>(),
    ) {
        assert_finite(&m, q, n, log);
    }
}
