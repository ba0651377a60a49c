//! Light that runs against the view, exactly and nearly: the plane across h stands along the rays there.

use glam::{DMat2, DVec3};

use super::measured::{EXACT, Sizes, assert_close, at, matrix, one, speed, step, texel};
use crate::support::by_body::by_body;
use crate::support::views::{View, by_hand, directional};

/// Square pixels.
const SIZES: Sizes = Sizes { image: [140, 100], map: [512, 384] };

/// Tilts that a halved angle of f64 has digits for, those it has half of the digits for, and none.
const TILTS: [f64; 12] = [0.5, 1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 3e-8, 1e-8, 1e-12, 0.0];

/// Differences of a map of f64, over steps of a hundredth of the depth.
const OF_MAPS: f64 = 1e-7;

#[test]
fn perspective_on_the_axis_is_the_cross_section_over_depth() {
    // On the axis of square pixels every turn of a cross-section is as long: J(h) is a turn of it, whatever h is.
    let (_, scene, camera) = by_hand().into_iter().find(|s| s.0 == "town").expect("the town");
    let focal_px = 0.5 * f64::from(SIZES.image[1]) / camera.half_size().y;
    let q = camera.eye() + camera.forward() * 30.0;
    for text in ["uniform", "lispsm", "psm", "xpsm"] {
        for tilt in TILTS {
            for sideways in [camera.up(), camera.right(), (camera.up() + camera.right() * 2.0).normalize()] {
                let along = (-camera.forward() - sideways * tilt).normalize();
                let (scene, light) = (scene.clone(), directional(along));
                let v = View { name: format!("{text}, {tilt:e} off"), scene, camera, light };
                let t = by_body(text);
                let p = t.parameterize(&v.scene, &v.camera, &v.light, 512).expect("a map");
                // Light that runs against the view lights no side that the eye sees, but for nearly edge-on ones: any normal
                // on the light's side will do here.
                let found = one(&v, &p, SIZES, q, -along);
                let map = &p.partitions[0];
                let (u, h) = (along.any_orthonormal_vector(), step(&camera, map, q));
                let column = |d: DVec3| speed(|x| texel(map, SIZES.map, x), q, d, h);
                let across_from_texels = DMat2::from_cols(column(u), column(along.cross(u))).inverse();
                let per_unit = focal_px / camera.depth_of(q);
                let what = format!("{} along {sideways}", v.name);
                let area = across_from_texels.determinant().abs() * per_unit * per_unit;
                assert_close(&format!("{what}: perspective"), found.perspective, area, OF_MAPS);
                let columns = [across_from_texels.x_axis, across_from_texels.y_axis];
                for (ours, column) in found.perspective_ts.iter().zip(columns) {
                    assert_close(&format!("{what}: perspective_ts"), *ours, column.length() * per_unit, OF_MAPS);
                }
            }
        }
    }
}

#[test]
fn a_texel_is_finite_wherever_light_runs_against_the_view() {
    let (_, scene, camera) = by_hand().into_iter().find(|s| s.0 == "town").expect("the town");
    let mut met = 0;
    for tilt in TILTS {
        let light = directional(-camera.forward() - camera.up() * tilt);
        let v = View { name: format!("{tilt:e} off"), scene: scene.clone(), camera, light };
        let p = by_body("lispsm").parameterize(&v.scene, &camera, &light, 512).expect("a map");
        // Along the very ray that runs against the light, and beside it by less and less.
        let exact = camera.eye() - v.light.to_light(DVec3::ZERO) * -20.0;
        let places: Vec<DVec3> = (0..14).map(|i| exact + camera.right() * 10_f64.powi(-i)).chain([exact]).collect();
        for turn in [DVec3::ZERO, camera.up() * 0.5, camera.right() * 3.0] {
            let n = v.light.to_light(DVec3::ZERO) + turn;
            for (code, t) in at(&v, &p, SIZES, &places, &vec![n; places.len()]) {
                if code < 0 {
                    continue;
                }
                let numbers = [t.major, t.minor, t.perspective, t.projection, t.perspective_ts[0], t.perspective_ts[1]];
                assert!(numbers.iter().all(|x| x.is_finite() && *x > 0.0), "{}: {t:?}", v.name);
                // The area of any parallelogram is at most that of the rectangle.
                let [a, b] = t.perspective_ts;
                assert!(t.perspective <= a * b * (1.0 + 1e-7), "{}: {t:?}", v.name);
                assert_close(&v.name, t.major * t.minor, t.perspective * t.projection, EXACT);
                assert!(matrix(&t).is_finite());
                met += 1;
            }
        }
    }
    assert!(met > 100, "{met}");
}
