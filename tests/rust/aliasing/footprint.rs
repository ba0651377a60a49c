//! What a texel looks like in the image: the published numbers, finite differences under every technique and awkward light,
//! and the product of perspective and slope (theory.md E.2). Closed forms, invariance and degenerate input have files of their
//! own.

mod closed_forms;
mod degenerate;
mod edges;
mod images;
mod invariance;
mod measured;
mod opposed;

use std::collections::BTreeMap;

use glam::DVec3;
use serde_json::Value as Json;
use shadowlab::image::Footprint;
use shadowlab::scene::Light;
use shadowlab::techniques::{Technique, specs, technique};
use shadowlab::{Error, Parameterization, Partition};

use crate::support::by_body::by_body;
use crate::support::tables::{self, camera, number, tables, vector};
use crate::support::views::{Random, View, by_hand, directional, directions, from_library, points, spots};
use measured::{
    DIFFERENCES, EXACT, Sizes, assert_close, at, facing, from_differences, gbuffer, matrix, one, shown, tolerance, ways,
};

/// Sides that differ, so that none can stand for another.
const SIZES: Sizes = Sizes { image: [96, 64], map: [512, 384] };

/// What the fit is told.
const RESOLUTION: u32 = 512;

/// The sine of light on a surface at which differences over its slope have half of their digits.
const EDGE_ON: f64 = 1e-6;

/// Matrices of the tables have sixteen digits, and J a few operations on them.
const OF_TABLES: f64 = 1e-9;

#[test]
fn the_jacobian_of_the_tables() {
    let t = tables();
    let side = |j: &Json| [0, 1].map(|i| j[i].as_u64().expect("a side") as u32);
    let (case, inputs) = (&t["jacobian"], &t["matrices"]["inputs"]);
    let camera = camera(&inputs["camera"]);
    let map = tables::matrix(&t["matrices"][case["matrix"].as_str().expect("a name")]["M"]);
    let (_, scene, _) = by_hand().swap_remove(0);
    let light = directional(vector(&inputs["light_direction_unnormalised"]));
    let v = View { name: "tables".into(), scene, camera, light };
    let p = Parameterization::of_partitions(vec![Partition::of_matrix(map)], [1024; 2]);
    let sizes = Sizes { image: side(&case["screen"]), map: side(&case["shadow"]) };
    let (x, n) = (vector(&case["X"]), vector(&case["N"]));
    let texel = one(&v, &p, sizes, x, n);
    // Theirs has y up in both.
    for (k, sign) in [1.0, -1.0, -1.0, 1.0].into_iter().enumerate() {
        assert_close("J", texel.jacobian[k], sign * number(&case["J"][k / 2][k % 2]), OF_TABLES);
    }
    assert_close("major", texel.major, number(&case["singular_values"][0]), OF_TABLES);
    assert_close("minor", texel.minor, number(&case["singular_values"][1]), OF_TABLES);
    let [cos_alpha, cos_beta] = ["cos_alpha", "cos_beta"].map(|k| number(&case[k]));
    assert_close("projection", texel.projection, cos_alpha / cos_beta, OF_TABLES);
    let det = number(&case["singular_values"][0]) * number(&case["singular_values"][1]);
    assert_close("perspective", texel.perspective, det * cos_beta / cos_alpha, OF_TABLES);
}

/// How many texels were held against differences, by technique.
#[derive(Default)]
struct Tally(BTreeMap<String, usize>);

/// Whether a point is on the border of a map, where rounding decides.
fn on_a_border(p: &Parameterization, q: DVec3) -> bool {
    p.partitions.iter().any(|map| {
        let (ndc, w) = map.project(q);
        // A few roundings of the terms of a matrix, of which f64 has sixteen digits.
        let edge = |x: f64| x.abs() < 1e-9;
        let in_region = |q: DVec3| map.region.contains(q);
        let beside = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis * (1e-9 * q.length()));
        edge(ndc.x.abs() - 1.0)
            || edge(ndc.y.abs() - 1.0)
            || edge(ndc.z - 1.0)
            || edge(w)
            || beside.iter().any(|d| in_region(q + *d) != in_region(q) || in_region(q - *d) != in_region(q))
    })
}

/// Holds the texels of some points under one technique against differences, closed forms and the choice of the map.
fn check(v: &View, name: &str, p: &Parameterization, on: &[(DVec3, DVec3)], tally: &mut Tally) {
    let (places, normals): (Vec<_>, Vec<_>) = on.iter().copied().unzip();
    for ((q, n), (code, texel)) in on.iter().zip(at(v, p, SIZES, &places, &normals)) {
        let what = format!("{} / {name} at {q}, {n}", v.name);
        let chosen = p.choose(*q, v.camera.depth_of(*q));
        let expected = match chosen {
            _ if !v.light.illuminates(*q, *n) => Footprint::AVERTED,
            Some(k) => k as i16,
            None => Footprint::NO_MAP,
        };
        if code != expected {
            assert!(on_a_border(p, *q) || v.camera.depth_of(*q) < EXACT, "{what}: map {code}, not {expected}");
            continue;
        }
        let Ok(k) = usize::try_from(code) else { continue };
        let [_, to_light] = ways(&v.camera, &v.light, *q);
        if n.normalize().dot(to_light) < EDGE_ON {
            continue;
        }
        let off = from_differences(v, &p.partitions[k], SIZES, *q, *n, &texel);
        assert!(off < tolerance(&v.camera, &p.partitions[k], *q), "{what}: {off:e} from differences, {texel:?}");
        check_parts(&what, v, *q, *n, &texel);
        *tally.0.entry(name.into()).or_default() += 1;
    }
}

/// The product of perspective and slope, and bounds of the extents.
fn check_parts(what: &str, v: &View, q: DVec3, n: DVec3, texel: &shadowlab::aliasing::texel::Texel) {
    let j = matrix(texel);
    // The rays of a map are those of the light up to the rounding of its rows, which the slope multiplies.
    let [to_eye, to_light] = ways(&v.camera, &v.light, q);
    let n = n.normalize();
    let slope = n.dot(to_eye) / n.dot(to_light);
    let rounding = DIFFERENCES * (1.0 + 1e-3 / n.dot(to_light) + 1e-3 / n.dot(to_eye).abs());
    assert_close(&format!("{what}: projection"), texel.projection, slope.abs(), rounding);
    // A determinant is a difference: to the digits of its terms.
    let [a, b, c, d] = texel.jacobian;
    let terms = (a * d).abs() + (b * c).abs();
    let area = texel.perspective * texel.projection;
    assert!((j.determinant().abs() - area).abs() <= 1e-10 * terms.max(area), "{what}: {area} is not |{j:?}|");
    assert_close(&format!("{what}: area"), texel.major * texel.minor, area, EXACT);
    let columns = [j.x_axis.length(), j.y_axis.length()];
    let (longest, both) = (columns[0].max(columns[1]), columns[0].hypot(columns[1]));
    let bounds = longest * (1.0 - EXACT)..=both * (1.0 + EXACT);
    assert!(bounds.contains(&texel.major), "{what}: major {} and columns {columns:?}", texel.major);
    assert!(texel.minor <= texel.major * (1.0 + 1e-7), "{what}: {texel:?}");
    assert_close(&format!("{what}: depth"), texel.depth, v.camera.depth_of(q), 1e-9);
}

/// Points that an image shows, with their normals and some more that face eye and light.
fn receivers(v: &View, seed: u64, most: usize) -> Vec<(DVec3, DVec3)> {
    let mut random = Random(seed);
    let seen = shown(&gbuffer(v, SIZES.image), most);
    let turned = seen.iter().filter_map(|(q, _)| Some((*q, facing(&mut random, ways(&v.camera, &v.light, *q))?)));
    let turned: Vec<_> = turned.collect();
    seen.into_iter().chain(turned).collect()
}

/// Every technique with its defaults, and some for the body whose maps are several, snapped, logarithmic or nearly singular.
fn techniques() -> Vec<(String, Box<dyn Technique>)> {
    let defaults = specs().map(|s| (s.name.to_string(), technique(s.name, &[]).expect("made")));
    let more = [
        "uniform:stable=true",
        "rectilinear:base=lispsm,bins=8",
        "psm:slide=0",
        "lispsm:near=basic",
        "log_psm:warp=lispsm",
        "z_partition:count=3,inner=log",
        "z_partition:count=2,inner=face_partition",
        "z_partition:splits=equal-log,cover=samples,inner=lispsm",
        "face_partition:inner=(z_partition:count=2)/uniform",
    ];
    defaults.chain(more.map(|text| (text.into(), by_body(text)))).collect()
}

fn check_all(v: &View, made: &[(String, Box<dyn Technique>)], most: usize, tally: &mut Tally) {
    let samples = v.samples();
    let on = receivers(v, 9, most);
    for (name, t) in made.iter().filter(|(_, t)| t.serves(&v.light).is_ok()) {
        match t.parameterize_seen(&v.scene, &v.camera, &v.light, [RESOLUTION; 2], Some(&samples)) {
            Ok(p) => check(v, name, &p, &on, tally),
            Err(Error::UnsuitedView { .. }) => {}
            Err(error) => panic!("{}, {name}: {error}", v.name),
        }
    }
}

/// Of every technique at least as many texels.
fn assert_all_tallied(tally: &Tally, made: &[(String, Box<dyn Technique>)], least: usize) {
    for (name, _) in made {
        let count = tally.0.get(name).copied().unwrap_or(0);
        println!("{name}: {count} texels");
        assert!(count >= least, "{name}: {count} texels");
    }
}

#[test]
fn differences_under_every_technique_on_the_library_scenes() {
    let (made, mut tally) = (techniques(), Tally::default());
    for v in from_library() {
        check_all(&v, &made, 20, &mut tally);
    }
    assert_all_tallied(&tally, &made, 100);
}

fn with_lights(name: &str, lights: impl Fn(&View) -> Vec<(String, Light)>) -> Vec<View> {
    let (name, scene, camera) = by_hand().into_iter().find(|s| s.0 == name).expect("a scene");
    let v = View { name: name.into(), scene, camera, light: directional(DVec3::NEG_Y) };
    let of = |(light_name, light)| View { name: format!("{name} / {light_name}"), scene: v.scene.clone(), light, ..v };
    lights(&v).into_iter().map(of).collect()
}

#[test]
fn differences_under_every_technique_and_awkward_light() {
    let (made, mut tally) = (techniques(), Tally::default());
    let lights = |v: &View| -> Vec<_> {
        let suns = directions(&v.camera).into_iter().map(|(n, d)| (n, directional(d)));
        suns.chain(spots(&v.scene, &v.camera)).chain(points(&v.scene, &v.camera)).collect()
    };
    for name in ["town", "cube", "sheared and mirrored", "eye in a corner"] {
        for v in with_lights(name, lights) {
            check_all(&v, &made, 6, &mut tally);
        }
    }
    assert_all_tallied(&tally, &made, 100);
}

#[test]
fn on_the_plane_across_h_there_is_perspective_alone() {
    let mut met = 0;
    for v in from_library() {
        for text in ["uniform", "lispsm", "log_psm", "z_partition:count=3"] {
            let t = by_body(text);
            let served = t.serves(&v.light).is_ok();
            let Some(p) = served.then(|| t.parameterize(&v.scene, &v.camera, &v.light, RESOLUTION).expect(text)) else {
                continue;
            };
            for (q, n) in receivers(&v, 4, 20) {
                let [to_eye, to_light] = ways(&v.camera, &v.light, q);
                let [(map, slanted), (across_map, across)] =
                    at(&v, &p, SIZES, &[q, q], &[n, (to_eye + to_light) * 3.0])[..]
                else {
                    panic!("two")
                };
                if map < 0 || across_map < 0 {
                    continue;
                }
                let what = format!("{} / {text} at {q}", v.name);
                // The light's own ray and that of the map agree to the digits of its matrix.
                assert_close(&what, across.projection, 1.0, 1e-9);
                assert_close(&what, across.major * across.minor, slanted.perspective, 1e-9);
                let j = matrix(&across);
                for (ours, column) in slanted.perspective_ts.iter().zip([j.x_axis, j.y_axis]) {
                    assert_close(&what, *ours, column.length(), 1e-9);
                }
                met += 1;
            }
        }
    }
    assert!(met > 300, "{met}");
}
