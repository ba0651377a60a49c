//! The published and derived numbers: matrices, errors and bodies of `data/tables.json` (theory.md 17).
//!
//! Matrices are compared as the tables say: up to a positive scale, and up to a mirrored x. Where a table cut depth to the
//! body B instead of the casters' boxes, the same steps are called with that cut.

use glam::{DMat4, DVec3};
use serde_json::Value as Json;
use shadowlab::fit::{MapSize, crop, stable_grid};
use shadowlab::focus::{Focus, FocusedView};
use shadowlab::geometry::{ConvexBody, Rows, singular_values};
use shadowlab::rays::LightFrame;
use shadowlab::scene::{Camera, DirectionalLight, Light, Scene, SpotLight};
use shadowlab::techniques::kit::WarpSpace;

use crate::support::tables::{box_scene, camera, matrix, number, points, tables, vector};

/// Of the tables: bodies that came from a joggled hull are good to this (theory.md 17).
const JOGGLED: f64 = 1e-6;
/// Of f64 through a dozen operations on numbers of size 100.
const EXACT: f64 = 1e-9;

struct Setup {
    scene: Scene,
    camera: Camera,
    light: Light,
    along: DVec3,
}

/// The view that all matrices of the tables share.
fn setup(t: &Json) -> Setup {
    let inputs = &t["matrices"]["inputs"];
    let scene = box_scene(vector(&inputs["scene_aabb"][0]), vector(&inputs["scene_aabb"][1]));
    let light = DirectionalLight::new(vector(&inputs["light_direction_unnormalised"])).expect("a light");
    Setup { scene, camera: camera(&inputs["camera"]), light: Light::Directional(light), along: light.direction() }
}

/// A camera whose whole frustum is the body: the scene's box lies around it.
fn frustum_setup(camera: Camera, along: DVec3) -> FocusedView<'static> {
    let light = Light::Directional(DirectionalLight::new(along).expect("a light"));
    FocusedView::new(&box_scene(DVec3::splat(-300.0), DVec3::splat(300.0)), &camera, &light, Focus::SceneFit)
}

/// Largest difference of two matrices of one map, after scaling both to the largest entry and undoing a mirrored x.
fn difference(a: &DMat4, b: &DMat4) -> f64 {
    let normed = |m: &DMat4| {
        let largest = m.to_cols_array().iter().fold(0.0_f64, |s, x| s.max(x.abs()));
        Rows::of(&(*m * (1.0 / largest)))
    };
    let (a, b) = (normed(a), normed(b));
    let mirrored = Rows { x: -b.x, ..b };
    let apart = |b: &Rows| {
        let d = a.matrix() - b.matrix();
        d.to_cols_array().iter().fold(0.0_f64, |s, x| s.max(x.abs()))
    };
    apart(&b).min(apart(&mirrored))
}

fn assert_same_map(name: &str, ours: &Rows, view: &FocusedView, table: &DMat4, tolerance: f64) {
    let d = difference(&ours.moved_to_world(view.origin).matrix(), table);
    assert!(d < tolerance, "{name}: {d:e}");
}

/// Each point of `some` has one of `all` near it.
fn assert_subset(what: &str, some: &[DVec3], all: &[DVec3], tolerance: f64) {
    for p in some {
        let nearest = all.iter().map(|q| (*p - *q).length()).fold(f64::INFINITY, f64::min);
        assert!(nearest < tolerance, "{what}: {p} is {nearest:e} from the next");
    }
}

fn world(view: &FocusedView, body: &ConvexBody) -> Vec<DVec3> {
    body.vertices().iter().map(|p| *p + view.origin).collect()
}

#[test]
fn the_comparison_of_matrices_sees_a_change_of_one_entry() {
    let m = matrix(&tables()["matrices"]["lispsm_dz"]["M"]);
    assert!(difference(&m, &(m * 3.0)) < 1e-15);
    let mut rows = Rows::of(&m);
    rows.y.z *= 1.0 + 1e-6;
    assert!(difference(&m, &rows.matrix()) > 1e-9);
}

#[test]
fn the_bodies_are_those_of_the_tables() {
    let t = tables();
    let s = setup(&t);
    let inputs = &t["matrices"]["inputs"];
    let view = FocusedView::new(&s.scene, &s.camera, &s.light, Focus::SceneFit);
    let (k, table) = (world(&view, &view.receivers), points(&inputs["K_vertices"]));
    assert_eq!(k.len(), table.len());
    assert_subset("K", &k, &table, EXACT * 100.0);
    assert_subset("K", &table, &k, EXACT * 100.0);
    let range = &inputs["eye_depth_range_of_K"];
    assert!((view.eye_depth[0] - number(&range[0])).abs() < EXACT);
    assert!((view.eye_depth[1] - number(&range[1])).abs() < 100.0 * EXACT);
    // The tables' hull is joggled: beside the vertices it has points on edges and faces, so it holds ours, not the reverse.
    let (b, table) = (view.casters(), points(&inputs["B_vertices"]));
    assert_subset("B", &world(&view, &b), &table, 100.0 * JOGGLED);
    for p in table {
        assert!(b.distance_outside(p - view.origin) < 100.0 * JOGGLED, "{p} lies outside of B");
    }
}

#[test]
fn uniform_and_every_lispsm_matrix_of_the_tables() {
    let t = tables();
    let (s, m) = (setup(&t), &t["matrices"]);
    let view = FocusedView::new(&s.scene, &s.camera, &s.light, Focus::SceneFit);
    let (k, b) = (view.receivers, view.casters());
    let (frame, kappa) = LightFrame::towards(s.along, s.camera.forward()).expect("an axis");
    assert!((kappa - number(&m["inputs"]["kappa"])).abs() < EXACT);
    let uniform = crop(&frame.orthographic(), &view, k.vertices(), b.vertices());
    assert_same_map("uniform", &uniform, &view, &matrix(&m["uniform"]["M"]), JOGGLED);

    let space = WarpSpace::directional(&view, s.along, s.camera.forward()).expect("a warp");
    assert!((space.y[0] - number(&m["inputs"]["Ymin"])).abs() < EXACT);
    assert!((space.extent() - number(&m["inputs"]["D"])).abs() < 100.0 * EXACT);
    let [z0, z1] = space.line();
    for (name, near, far) in [("lispsm_dz", z0, z1), ("lispsm_nopt", view.eye_depth[0], view.eye_depth[1])] {
        let distance = space.equal_error_distance(near, far);
        let table = number(&m[name]["Pn"]);
        assert!((distance - table).abs() < table * EXACT, "{name}: {distance} and {table}");
        let ours = crop(&space.warped(distance), &view, k.vertices(), b.vertices());
        assert_same_map(name, &ours, &view, &matrix(&m[name]["M"]), JOGGLED);
    }
    // The middle of the tables' own (joggled) vertices: the vector counts vertices, so a split one counts twice.
    let table_b: Vec<DVec3> = points(&m["inputs"]["B_vertices"]).iter().map(|p| *p - view.origin).collect();
    let middle = &m["lispsm_middle_vector"];
    let space = WarpSpace::directional(&view, s.along, view.middle_vector(&table_b)).expect("a warp");
    assert!((space.rate - number(&middle["kappa"])).abs() < JOGGLED);
    assert!((space.rows.y.truncate() - vector(&middle["warp_axis"])).length() < JOGGLED);
    let [z0, z1] = space.line();
    let distance = space.equal_error_distance(z0, z1);
    assert!((distance / number(&middle["Pn"]) - 1.0).abs() < JOGGLED);
    let ours = crop(&space.warped(distance), &view, k.vertices(), b.vertices());
    assert_same_map("middle vector", &ours, &view, &matrix(&middle["M"]), JOGGLED);
}

#[test]
fn the_stable_grid_of_the_tables() {
    let t = tables();
    let (s, m) = (setup(&t), &t["matrices"]["stable_uniform"]);
    let size = MapSize::new([m["resolution"].as_u64().expect("texels") as u32; 2]).expect("a size");
    let depth = [number(&m["depth_range"][0]), number(&m["depth_range"][1])];
    let grid = stable_grid(&s.camera, s.along, depth, &size);
    assert!((grid.texel - number(&m["texel"])).abs().max_element() < EXACT);
    assert!((grid.radius - number(&m["sphere_radius"])).abs() < 100.0 * EXACT);
    assert!((grid.center - vector(&m["sphere_center"])).length() < 100.0 * EXACT);
    let d = difference(&grid.clip_from_world.matrix(), &matrix(&m["M"]));
    assert!(d < EXACT, "{d:e}");
}

#[test]
fn the_spot_matrices_of_the_tables() {
    let t = tables();
    let (s, m) = (setup(&t), &t["matrices"]);
    let l = &m["spot_uniform"]["light"];
    let [half, far] = ["half_angle", "far"].map(|k| number(&l[k]));
    let near = number(&l["near"]);
    let spot =
        SpotLight::new(vector(&l["position"]), vector(&l["direction_unnormalised"]), 2.0 * half, far).expect("a spot");
    let view = FocusedView::new(&s.scene, &s.camera, &Light::Spot(spot), Focus::SceneFit);
    let table = points(&m["spot_uniform"]["K_vertices"]);
    assert_subset("K", &world(&view, &view.receivers), &table, JOGGLED * 100.0);
    assert_subset("K", &table, &world(&view, &view.receivers), JOGGLED * 100.0);
    let pyramid = view.spot().expect("a spot");
    let perspective = pyramid.perspective(near, far);
    assert_same_map("spot", &perspective, &view, &matrix(&m["spot_uniform"]["M"]), EXACT);
    let k = view.receivers.vertices();
    assert_same_map(
        "focused",
        &crop(&perspective, &view, k, k),
        &view,
        &matrix(&m["spot_uniform"]["focused"]),
        JOGGLED,
    );
    let space = WarpSpace::spot(&view, &pyramid, [near, far], s.camera.forward()).expect("a warp");
    let [z0, z1] = space.line();
    let distance = space.equal_error_distance(z0, z1);
    let lambda = number(&m["spot_lispsm"]["lam"]);
    assert!((distance / space.extent() / lambda - 1.0).abs() < JOGGLED, "{} {lambda}", distance / space.extent());
    let ours = crop(&space.warped(distance), &view, k, k);
    assert_same_map("spot lispsm", &ours, &view, &matrix(&m["spot_lispsm"]["M"]), JOGGLED);
}

/// The warp space of a whole frustum, which casts as well in the tables.
fn whole_frustum_space(view: &FocusedView, along: DVec3) -> WarpSpace {
    let space = WarpSpace::directional(view, along, view.camera.forward()).expect("a warp");
    let (low, high) = view.receivers.range(space.rows.z);
    WarpSpace { z_ref: 0.5 * (low + high), ..space }
}

#[test]
fn lispsm_over_a_whole_frustum_at_each_light_angle() {
    let t = tables();
    let config = &t["theta_config"];
    let lambdas = &t["lambda"];
    for (degrees, case) in config["by_theta_deg"].as_object().expect("angles") {
        let along = vector(&case["light_direction"]);
        let view = frustum_setup(camera(&config["camera"]), along);
        let k = view.receivers;
        assert_eq!(k.vertices().len(), 8);
        let space = whole_frustum_space(&view, along);
        let table = &case["lispsm"];
        let distance = space.equal_error_distance(view.eye_depth[0], view.eye_depth[1]);
        assert!((distance / number(&table["Pn"]) - 1.0).abs() < EXACT, "{degrees}");
        assert!((distance / space.extent() / number(&table["lam"]) - 1.0).abs() < EXACT, "{degrees}");
        let ours = crop(&space.warped(distance), &view, k.vertices(), k.vertices());
        assert_same_map(degrees, &ours, &view, &matrix(&table["M"]), EXACT);
        let row = lambdas["theta_deg"]
            .as_array()
            .expect("angles")
            .iter()
            .position(|d| number(d) == degrees.parse::<f64>().unwrap());
        let [z0, z1] = space.line();
        let dz = space.equal_error_distance(z0, z1) / space.extent();
        let expected = number(&lambdas["lispsm_dz"][row.expect("the angle in the table of lambda")]);
        assert!((dz / expected - 1.0).abs() < EXACT, "{degrees}: {dz} and {expected}");
    }
}

/// The overhead view of theory.md E.1 and our cropped LiSPSM or uniform map of it.
fn overhead(t: &Json, warp: bool) -> (FocusedView<'static>, Rows) {
    let along = DVec3::NEG_Y;
    let view = frustum_setup(camera(&t["theta_config"]["camera"]), along);
    let k = view.receivers;
    let space = whole_frustum_space(&view, along);
    let distance = space.equal_error_distance(view.eye_depth[0], view.eye_depth[1]);
    let provisional = if warp { space.warped(distance) } else { space.rows };
    let rows = crop(&provisional, &view, k.vertices(), k.vertices());
    (view, rows)
}

#[test]
fn dp_ds_and_dp_dt_of_our_matrices_are_the_closed_forms() {
    let t = tables();
    for (key, derivative) in [("ideal_dp_ds", DVec3::NEG_Z), ("ideal_dp_dt", DVec3::X)] {
        for (technique, warp) in [("lispsm", true), ("uniform", false)] {
            let (_, rows) = overhead(&t, warp);
            let zs = t[key]["z"].as_array().expect("depths");
            for (z, expected) in zs.iter().zip(t[key][technique].as_array().expect("values")) {
                let (z, expected) = (number(z), number(expected));
                let p = DVec3::NEG_Z * z;
                // dp/ds = (zn / z) dz/ds with s = (y + 1) / 2; dp/dt = (zn / z) dx/dt over the near plane's width
                // (E.2), (E.4).
                let h = 1e-5 * z;
                let moved = (rows.project(p + derivative * h) - rows.project(p - derivative * h)) / (2.0 * h);
                let per_unit = if key == "ideal_dp_ds" { 0.5 * moved.y } else { 0.5 * moved.x };
                let width = if key == "ideal_dp_ds" { 1.0 } else { 2.0 * (30.0_f64).to_radians().tan() };
                let error = 1.0 / (z * per_unit.abs() * width);
                // Central differences: h² over the distance to the reference point, squared, plus rounding over h.
                assert!((error / expected - 1.0).abs() < 1e-8, "{key} {technique} z={z}: {error} and {expected}");
                let exact = rows.derivative(p, derivative);
                assert!((exact - moved).length() < 1e-8 * exact.length());
            }
        }
    }
}

#[test]
fn the_overhead_warp_has_equal_error_at_both_ends_and_its_least_between() {
    let t = tables();
    let (_, rows) = overhead(&t, true);
    let error = |z: f64| 2.0 / (z * rows.derivative(DVec3::NEG_Z * z, DVec3::NEG_Z).y.abs());
    assert!((error(1.0) - 9.9).abs() < EXACT && (error(100.0) - 9.9).abs() < EXACT);
    assert!((error(10.0) - number(&t["ideal_dp_ds"]["minima"]["lispsm"])).abs() < EXACT);
    assert!(error(9.0) > error(10.0) && error(11.0) > error(10.0));
}

#[test]
fn f_of_a_tilted_light_is_measured_on_our_matrices() {
    let t = tables();
    let f = &t["F"];
    let angles = f["theta_deg"].as_array().expect("angles");
    let mut checked = 0;
    for (i, angle) in angles.iter().enumerate() {
        let theta = number(angle).to_radians();
        let along = DVec3::new(0.0, -theta.sin(), -theta.cos());
        let view = frustum_setup(camera(&t["theta_config"]["camera"]), along);
        let k = view.receivers;
        let space = whole_frustum_space(&view, along);
        let [z0, z1] = space.line();
        let basic = space.equal_error_distance(view.eye_depth[0], view.eye_depth[1]);
        let dz = space.equal_error_distance(z0, z1);
        for (name, provisional) in
            [("lispsm", space.warped(basic)), ("lispsm_dz", space.warped(dz)), ("uniform", space.rows)]
        {
            let rows = crop(&provisional, &view, k.vertices(), k.vertices());
            for (j, z) in f["z"].as_array().expect("depths").iter().enumerate() {
                let z = number(z);
                // F = dz/ds / (z tan phi) on the centre ray, s in [0, 1] (6.2).
                let ours = 2.0 / (rows.derivative(DVec3::NEG_Z * z, DVec3::NEG_Z).y * z * number(&f["phi"]).tan());
                let table = number(&f[name][i][j]);
                // The tables' uniform column is a warp at a large distance: equal to 1e-7.
                assert!((ours / table - 1.0).abs() < 1e-6, "{name} {angle} z={z}: {ours} and {table}");
                checked += 1;
            }
        }
    }
    assert_eq!(checked, 12 * 7 * 3);
}

#[test]
fn the_jacobian_entry_of_the_tables() {
    let t = tables();
    let j = &t["jacobian"];
    let m = Rows::of(&matrix(&t["matrices"][j["matrix"].as_str().expect("a name")]["M"]));
    let eye = Rows::of(&matrix(&t["matrices"]["inputs"]["camera_clip_matrix"]));
    let (p, normal) = (vector(&j["X"]), vector(&j["N"]));
    let tangent = normal.any_orthonormal_pair();
    let directions = [tangent.0, tangent.1];
    let pixels = |rows: &Rows, size: &Json| {
        let half = glam::DMat2::from_diagonal(glam::DVec2::new(number(&size[0]), number(&size[1])) * 0.5);
        half * rows.jacobian(p, directions)
    };
    let ours = pixels(&eye, &j["screen"]) * pixels(&m, &j["shadow"]).inverse();
    for row in 0..2 {
        for column in 0..2 {
            let (a, b) = (ours.row(row)[column], number(&j["J"][row][column]));
            assert!((a - b).abs() < EXACT, "{row} {column}: {a} and {b}");
        }
    }
    let (major, minor) = singular_values(&ours);
    assert!((major - number(&j["singular_values"][0])).abs() < EXACT);
    assert!((minor - number(&j["singular_values"][1])).abs() < EXACT);
}
