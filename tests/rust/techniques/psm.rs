//! PSM: its tables, its equivalence with LiSPSM, its three cases and what lies between them.

use glam::DVec3;
use shadowlab::geometry::Rows;
use shadowlab::note::{Detail, Kind};
use shadowlab::rays::LightRays;

use crate::support::published_view::{EXACT, View, difference};
use crate::support::tables::{box_scene, matrix, number, points, sun, tables};

/// Smallest over largest w of the light's own perspective, where the camera's is not smaller (theory.md 3.3).
const LIGHTS_OWN: f64 = 0.01;

/// w > 0 on K, the winding of the light, rows that vanish on the light, depth that grows along it.
fn assert_sound(what: &str, v: &View, rows: &Rows) {
    let view = v.focused();
    let rays = LightRays::new(&v.light, view.origin);
    for p in view.receivers.vertices() {
        assert!(rows.w.dot(p.extend(1.0)) > 0.0, "{what}: w <= 0 at {p}");
        assert_eq!(rays.orientation(rows, *p), 1.0, "{what}: orientation at {p}");
        let along = rays.direction_at(*p).expect("a direction");
        assert!(rows.derivative(*p, along).z > 0.0, "{what}: depth at {p}");
    }
    for row in [rows.x, rows.y, rows.w] {
        let terms = (row * rays.point).abs().element_sum();
        assert!(row.dot(rays.point).abs() <= 4.0 * f64::EPSILON * terms, "{what}: {row} on the light");
    }
}

/// Smallest over largest w of K.
fn w_ratio(v: &View, rows: &Rows) -> f64 {
    let (low, high) = v.focused().receivers.range(rows.w);
    low / high
}

#[test]
fn the_matrices_of_the_tables() {
    let t = tables();
    let v = View::of_tables(&t);
    let origin = v.focused().origin;
    for (name, slide) in [("psm_slide0", 0.0), ("psm_slide10", 10.0)] {
        let (table, what) = (&t["matrices"][name], format!("psm:slide={slide},range=camera"));
        let p = v.map(&what);
        let value = |name: &str| p.value(name).expect(name);
        assert!((value("z_infinity") - number(&table["z_inf"])).abs() < EXACT, "{name}");
        assert_eq!((value("slide"), value("case"), value("axis_blend")), (slide, -1.0, 0.0), "{name}");
        assert_eq!(table["case"], "inverted");
        let ours = v.cropped(&v.rows(&what));
        let d = difference(&ours, &v.local(&matrix(&table["M"])), true);
        assert!(d < EXACT, "{name}: {d:e}");
        for (p, ndc) in points(&t["matrices"]["inputs"]["probes"]).iter().zip(points(&table["probes_ndc"])) {
            let image = ours.project(*p - origin);
            assert!((image - ndc).length() < EXACT, "{name}: {image} and {ndc}");
        }
    }
}

#[test]
fn overhead_dp_ds_is_the_closed_form_of_the_camera_itself() {
    let t = tables();
    let v = View::of_frustum(1.0, DVec3::NEG_Y);
    let rows = v.cropped(&v.rows("psm:slide=0"));
    let table = &t["ideal_dp_ds"];
    for (z, expected) in table["z"].as_array().unwrap().iter().zip(table["psm"].as_array().unwrap()) {
        let z = number(z);
        // dp/ds = (zn / z) dz/ds, s = (y + 1) / 2 (E.2); for PSM z (zf - zn) / zf (theory.md 3).
        let ours = 2.0 / (z * rows.derivative(DVec3::NEG_Z * z, DVec3::NEG_Z).y);
        assert!((ours / number(expected) - 1.0).abs() < EXACT, "z={z}: {ours}");
        assert!((ours / (z * 99.0 / 100.0) - 1.0).abs() < EXACT, "z={z}: {ours}");
    }
}

#[test]
fn a_slide_of_the_root_of_near_times_far_is_lispsm_overhead() {
    for aspect in [1.0, 1.6] {
        let mut v = View::of_frustum(aspect, DVec3::NEG_Y);
        // An even box: LiSPSM puts its reference point in the middle of the casters' depths, which is then the eye's.
        v.scene = box_scene(DVec3::new(-300.0, -50.0, -300.0), DVec3::new(300.0, 50.0, 300.0));
        let (psm, lispsm) = (v.map("psm:slide=10"), v.map("lispsm:near=basic"));
        assert_eq!(psm.value("case"), Some(0.0));
        for p in v.focused().camera_frustum().corners() {
            let [a, b] = [&psm, &lispsm].map(|p0| p0.partitions[0].project(p).0);
            assert!((a - b).length() < EXACT, "{a} and {b}");
        }
    }
}

#[test]
fn the_map_is_continuous_through_the_parallel_case() {
    for (right, up) in [(0.0, -1.0), (0.6, -0.8), (1.0, 0.0)] {
        let tilted = |tilt: f64| View::of_frustum(1.5, DVec3::new(right, up, tilt));
        let flat = tilted(0.0);
        for setting in ["psm", "psm:slide=0", "psm:slide=30"] {
            let level = flat.map(setting);
            assert_eq!(level.value("case"), Some(0.0));
            for tilt in [1e-5, 1e-7, 1e-9, 1e-12, 1e-15] {
                let turned = [tilt, -tilt].map(|t| tilted(t).map(setting));
                for p in flat.focused().camera_frustum().corners() {
                    let images = turned.each_ref().map(|m| m.partitions[0].project(p).0);
                    let at = level.partitions[0].project(p).0;
                    for image in images {
                        // Measured: NDC moves by at most 2.1 times the angle over n / f, where w is smallest.
                        let moved = (image - at).truncate().length();
                        assert!(moved < 1e-11 + 300.0 * tilt, "{setting} {tilt:e}: {at} {image}");
                    }
                }
            }
            let named = [1e-5, -1e-5].map(|t| tilted(t).map(setting).value("case"));
            // The light comes from ahead where it travels against the view.
            assert_eq!(named, [Some(1.0), Some(-1.0)], "{setting}");
        }
    }
}

#[test]
fn every_angle_and_azimuth_makes_a_sound_map_whose_perspective_has_its_bound() {
    for aspect in [0.5, 1.0, 2.4] {
        for degrees in
            [0.0, 1e-6, 0.01, 3.0, 20.0, 29.9, 30.0, 31.0, 60.0, 89.99, 90.0, 90.01, 120.0, 150.0, 179.0, 180.0]
        {
            for azimuth in [0.0_f64, 0.4, std::f64::consts::FRAC_PI_2, 3.0] {
                let theta = f64::to_radians(degrees);
                let (x, y) = (theta.sin() * azimuth.sin(), -theta.sin() * azimuth.cos());
                let v = View::of_frustum(aspect, DVec3::new(x, y, -theta.cos()));
                for (setting, ratio) in [("psm", 1.0_f64 / 3.0), ("psm:slide=0", 0.01), ("psm:slide=30", 31.0 / 130.0)]
                {
                    let what = format!("{setting} at {degrees}° {azimuth} {aspect}");
                    let rows = v.rows(setting);
                    assert_sound(&what, &v, &rows);
                    // n' / f' from the camera, and 1 / 100 or not more than that once more from the light's own perspective.
                    let least = ratio * ratio.min(LIGHTS_OWN) * (1.0 - EXACT);
                    assert!(w_ratio(&v, &rows) >= least, "{what}: {}", w_ratio(&v, &rows));
                }
            }
        }
    }
}

#[test]
fn light_straight_along_the_view_of_an_even_body_makes_a_uniform_map() {
    for (along, case) in [(DVec3::NEG_Z, -1.0), (DVec3::Z, 1.0)] {
        let v = View::of_frustum(1.3, along);
        // The axis is then that of the view: w is constant (theory.md 3).
        let p = v.map("psm");
        assert_eq!(p.value("case"), Some(case));
        assert!(p.notes[0].details() == [Detail::EqualDistances], "{:?}", p.notes);
        assert_eq!(p.partitions[0].shadow_clip_from_world, v.map("uniform").partitions[0].shadow_clip_from_world);
    }
}

#[test]
fn a_far_slide_is_no_warp() {
    let v = View::of_frustum(1.0, DVec3::new(0.3, -1.0, 0.4));
    let uniform = v.rows("uniform");
    let mut before = f64::INFINITY;
    for slide in [1e3, 1e5, 1e7] {
        let rows = v.rows(&format!("psm:slide={slide}"));
        let apart = |p: DVec3| (rows.project(p) - uniform.project(p)).truncate().length();
        let most = v.focused().receivers.vertices().iter().map(|p| apart(*p)).fold(0.0, f64::max);
        // The warp is what the depths differ by over the distance.
        assert!(most < 200.0 / slide && most < 0.02 * before, "{slide:e}: {most:e}");
        before = most;
    }
    let p = v.map("psm:slide=1e300");
    assert!(p.notes[0].kind() == Kind::NoWarp && p.partitions[0].values.iter().all(|(_, x)| x.is_finite()));
    assert!(difference(&v.local(&p.partitions[0].shadow_clip_from_world), &uniform, true) < EXACT);
}

#[test]
fn the_infinity_plane_stands_where_it_is_wanted() {
    let v = View::of_frustum(1.0, DVec3::new(0.3, -1.0, 0.4));
    for wanted in [1.2, 1.5, 2.5, 40.0] {
        let p = v.map(&format!("psm:infinity={wanted}"));
        assert!((p.value("z_infinity").unwrap() / wanted - 1.0).abs() < EXACT);
        assert!((p.value("slide").unwrap() / (wanted * 99.0 - 100.0) - 1.0).abs() < EXACT);
    }
    // A camera whose own lies beyond stays where it is.
    for (setting, slide) in [("psm:infinity=1", 0.0), ("psm:infinity=1.01", 0.0), ("psm:slide=7,infinity=40", 7.0)] {
        assert_eq!(v.map(setting).value("slide"), Some(slide), "{setting}");
    }
}

#[test]
fn depths_that_span_too_much_slide_back_with_a_note() {
    let camera = |near: f64, far: f64| {
        shadowlab::scene::Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 1.0, near, far).unwrap()
    };
    for along in [DVec3::NEG_Y, DVec3::new(0.3, -1.0, 0.4), DVec3::new(0.1, -0.2, -1.0), DVec3::new(0.0, -1e-7, 1.0)] {
        let mut v = View::of_frustum(1.0, along);
        v.camera = camera(1e-9, 250.0);
        let p = v.map("psm:slide=0");
        assert!(p.notes[0].kind() == Kind::SlideRaised, "{:?}", p.notes);
        assert_sound("deep", &v, &v.rows("psm:slide=0"));
        // A slab that is thinner than half of the digits has no depth to warp.
        v.camera = camera(100.0, 100.0 * (1.0 + 1e-9));
        let p = v.map("psm:slide=0");
        assert!(p.notes.iter().any(|n| n.kind() == Kind::NoWarp), "{:?}", p.notes);
    }
}

#[test]
fn nothing_seen_is_covered_all_the_same() {
    let mut v = View::of_frustum(1.0, DVec3::NEG_Y);
    v.scene = box_scene(DVec3::new(-1.0, -1.0, 5.0), DVec3::new(1.0, 1.0, 9.0));
    assert!(v.map("psm").notes[0].kind() == Kind::NothingSeen);
    v.light = sun(DVec3::X);
    assert!(v.map("psm").partitions[0].shadow_clip_from_world.is_finite());
}
