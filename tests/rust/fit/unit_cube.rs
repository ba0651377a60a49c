//! How closely maps are cut to the unit cube: nothing is lost by any choice, and by default nothing is left over.
//!
//! The scenes are towns around the eye, so that boxes lie behind the reference point of a warp, where w <= 0, and across it.

#[allow(dead_code, reason = "shared with the contract tests")]
use glam::{DMat3, DMat4, DVec3, DVec4};
use shadowlab::geometry::{OrientedBox, Rows};
use shadowlab::note;
use shadowlab::scene::{Camera, Light, Scene, SpotLight};
use shadowlab::techniques::{FIT, Kind, Make, Needs, TECHNIQUES, Value};
use shadowlab::{Error, Parameterization};

use crate::support::boxes::Boxes;
use crate::support::by_body::by_body_with;
use crate::support::settings::BY_SAMPLES;
use crate::support::views::{Random, cube, directional, look, placed, square};

const RESOLUTION: u32 = 512;
const SCENES: u64 = 60;

/// Of maps whose w spans a few hundred, far inside of one of 2^24 steps of depth or 2^14 texels.
const TOLERANCE: f64 = 1e-9;

/// Kept free at either end of depth: 16 steps of 2^-24, of a range that has room for both.
const MARGIN: f64 = {
    let margin = 16.0 / (1 << 24) as f64;
    margin / (1.0 + 2.0 * margin)
};

/// How closely maps of the body are cut.
fn words() -> &'static [&'static str] {
    let Kind::Choice(words) = FIT.kind else { panic!("words") };
    let by_body = words.iter().position(|word| *word == "exact").expect("exact");
    &words[by_body..]
}

fn warps() -> impl Iterator<Item = &'static str> {
    // A map for samples alone has no such choice.
    let warps = TECHNIQUES.iter().filter(|entry| matches!(entry.make, Make::Warp(_)));
    warps.map(|entry| entry.spec.name).filter(|name| !BY_SAMPLES.contains(name))
}

/// A floor with turned boxes all around a low camera; under the sun, or a lamp above what it sees.
fn town(seed: u64) -> (Scene, Camera, Light) {
    let mut random = Random(seed);
    let v = DVec3::new;
    let mut parts = vec![(square(), DMat3::from_diagonal(v(60.0, 1.0, 60.0)), DVec3::ZERO)];
    for i in 0..24 {
        let at = v(random.between(-50.0, 50.0), random.between(-1.0, 12.0), random.between(-50.0, 50.0));
        let size = v(random.between(0.3, 6.0), random.between(0.3, 9.0), random.between(0.3, 6.0));
        let turn = DMat3::from_axis_angle(random.direction(), random.between(0.0, 6.0));
        parts.push((if i % 6 == 0 { square() } else { cube() }, turn * DMat3::from_diagonal(size), at));
    }
    let eye = v(random.between(-20.0, 20.0), random.between(1.0, 6.0), random.between(-20.0, 20.0));
    let ahead = v(random.between(-1.0, 1.0), random.between(-0.4, 0.1), random.between(-1.0, 1.0)).normalize();
    let camera = look(eye, eye + ahead, random.between(0.5, 1.6), 0.2, 80.0);
    let down = v(random.between(-1.0, 1.0), random.between(-1.5, -0.3), random.between(-1.0, 1.0));
    let light = if seed.is_multiple_of(3) {
        let lamp = SpotLight::new(eye + ahead * 25.0 - down * 20.0, down, random.between(0.5, 1.6), 120.0);
        Light::Spot(lamp.expect("a lamp"))
    } else {
        directional(down)
    };
    (placed(&parts), camera, light)
}

/// The map of a technique, or nothing where it does not serve the light or the view.
fn map_of(name: &str, fit: &str, at: &(Scene, Camera, Light), b: &Boxes) -> Option<Parameterization> {
    let t = by_body_with(name, &[("fit", Value::Choice(fit.into()))]);
    if !t.spec().lights.serves(&at.2) {
        return None;
    }
    let samples = (t.needs() != Needs::Nothing).then(|| b.samples(&mut Random(3), 64));
    match t.parameterize_seen(&at.0, &at.1, &at.2, [RESOLUTION; 2], samples.as_ref()) {
        Ok(p) => Some(p),
        Err(Error::UnsuitedView { .. }) => None,
        Err(error) => panic!("{name}: {error}"),
    }
}

fn local(p: &Parameterization, b: &Boxes) -> Rows {
    Rows::of(&(p.partitions[0].shadow_clip_from_world * DMat4::from_translation(b.origin)))
}

#[test]
fn no_choice_loses_a_caster_above_a_receiver() {
    for name in warps() {
        let (mut pairs, mut across) = (0, 0);
        for seed in 0..SCENES {
            let at = town(seed);
            let b = Boxes::new(&at.0, &at.1, &at.2, RESOLUTION);
            for fit in words() {
                let Some(p) = map_of(name, fit, &at, &b) else { continue };
                let rows = local(&p, &b);
                let signs = |i: &OrientedBox| i.range(rows.w).0 < 0.0 && i.range(rows.w).1 > 0.0;
                across += b.boxes.iter().filter(|i| signs(i)).count();
                let mut random = Random(seed);
                for _ in 0..40 {
                    let Some(receiver) = b.receiver(&mut random) else { continue };
                    let (ndc, w) = p.partitions[0].project(receiver.p + b.origin);
                    let begins = p.value("begins_at").unwrap_or(0.0);
                    let shown = |q: DVec3| begins == 0.0 || b.light.to_light(q + b.origin).length() > begins;
                    for caster in b.casters(receiver.p, &mut random).into_iter().filter(|q| shown(*q)) {
                        let (image, w_caster) = p.partitions[0].project(caster + b.origin);
                        let what = format!("{name}, {fit}, {seed}: {image} above {ndc}");
                        assert!(w > 0.0 && w_caster > 0.0, "{what}");
                        assert!((image - ndc).truncate().abs().max_element() < TOLERANCE, "{what}");
                        assert!(ndc.truncate().abs().max_element() <= 1.0, "{what}");
                        assert!(image.z >= 0.0 && image.z <= ndc.z + TOLERANCE && ndc.z <= 1.0, "{what}");
                        pairs += 1;
                    }
                }
            }
        }
        assert!(pairs > 1000, "{name}: only {pairs} pairs");
        // Without a warp w has one sign before the light.
        assert!(across > 100 || name == "uniform", "{name}: only {across} boxes across w = 0");
    }
}

/// What of a polygon lies where a functional is not negative.
fn clipped(polygon: &[DVec3], functional: DVec4) -> Vec<DVec3> {
    let height = |p: DVec3| functional.dot(p.extend(1.0));
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (at_a, at_b) = (height(a), height(b));
        if at_a >= 0.0 {
            kept.push(a);
        }
        if (at_a < 0.0) != (at_b < 0.0) {
            kept.push(a + (b - a) * (at_a / (at_a - at_b)));
        }
    }
    kept
}

/// All points where the faces of boxes, cut by functionals, have corners.
fn corners_of_cut_faces(boxes: &[OrientedBox], functionals: &[DVec4]) -> Vec<DVec3> {
    const FACES: [[usize; 4]; 6] = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
    let mut all = Vec::new();
    for b in boxes {
        let corners = b.corners();
        for face in FACES {
            let polygon = face.map(|i| corners[i]).to_vec();
            all.extend(functionals.iter().fold(polygon, |polygon, f| clipped(&polygon, *f)));
        }
    }
    all
}

#[test]
fn by_default_receivers_reach_every_border_and_the_ends_of_depth_are_exact() {
    let inset = f64::from(RESOLUTION - 2) / f64::from(RESOLUTION);
    for name in warps() {
        let mut maps = 0;
        for seed in 0..SCENES {
            let at = town(seed);
            let b = Boxes::new(&at.0, &at.1, &at.2, RESOLUTION);
            let (Some(p), [part]) = (map_of(name, "exact", &at, &b), &b.parts[..]) else { continue };
            if p.notes.iter().any(|n| n.kind() == note::Kind::LightInBox) {
                // What is nearest is no face of a box, but the lamp's near plane.
                continue;
            }
            let rows = local(&p, &b);
            let view = &part.view;
            // Receivers: faces inside K, and corners of K inside a box.
            let planes: Vec<_> = view.receiver_planes().copied().chain(view.scene_planes()).collect();
            let inside: Vec<DVec4> = planes.iter().map(|plane| -plane.functional()).collect();
            let mut receivers = corners_of_cut_faces(&b.boxes, &inside);
            let holds = |i: &OrientedBox, q: DVec3| {
                let at = DMat3::from_cols(i.half[0], i.half[1], i.half[2]).inverse() * (q - i.center);
                at.is_finite() && at.abs().max_element() <= 1.0
            };
            let corners = view.receivers.vertices().iter().copied();
            receivers.extend(corners.filter(|q| b.boxes.iter().any(|i| holds(i, *q))));
            if receivers.is_empty() {
                // K lies between the boxes.
                continue;
            }
            // Casters: in the map's own clip space, as a renderer cuts them.
            let mut sides = vec![rows.w + rows.x, rows.w - rows.x, rows.w + rows.y, rows.w - rows.y];
            sides.extend(view.light_planes().map(|planes| -planes[4].functional()));
            let casters = corners_of_cut_faces(&b.boxes, &sides);
            let nearest = casters.iter().map(|q| rows.project(*q).z).fold(f64::INFINITY, f64::min);
            assert!((nearest - MARGIN).abs() < TOLERANCE, "{name}, {seed}: near, {nearest:e} and {MARGIN:e}");
            let images = receivers.iter().map(|q| p.partitions[0].project(*q + b.origin).0);
            let extent = shadowlab::geometry::Aabb::from_points(images);
            let off = (extent.max - DVec3::new(inset, inset, 1.0 - MARGIN)).abs().max_element();
            let off = off.max((extent.min.truncate() + inset).abs().max_element());
            assert!(off < TOLERANCE, "{name}, {seed}: {extent:?}");
            maps += 1;
        }
        assert!(maps > 10, "{name}: only {maps} maps");
    }
}

#[test]
fn what_each_choice_costs() {
    for name in warps() {
        let mut looser = [0; 2];
        for seed in 0..SCENES {
            let at = town(seed);
            let b = Boxes::new(&at.0, &at.1, &at.2, RESOLUTION);
            let [part] = &b.parts[..] else { continue };
            // Texels across and steps of depth along the light, at one point.
            let mean = part.view.receivers.vertex_mean();
            let along = part.view.rays.direction_at(mean).expect("a direction");
            let of = |fit: &str| {
                let p = map_of(name, fit, &at, &b)?;
                let frame = shadowlab::rays::LightFrame::any(along);
                let rows = local(&p, &b);
                let area = rows.jacobian(mean, [frame.right, frame.up]).determinant().abs();
                Some((area, rows.derivative(mean, along).z))
            };
            let all = ["exact", "receivers", "intersection", "none"].map(of);
            let [Some(exact), Some(receivers), Some(intersection), Some(none)] = all else { continue };
            // A logarithm comes after the matrix, whose own y need not be as tight as it.
            let least = 1.0 - 1e-9;
            assert!(receivers.0 >= exact.0 * least && receivers.1 <= exact.1 / least, "{name}, {seed}");
            assert!(intersection.0 >= exact.0 * least && none.0 <= exact.0 / least, "{name}, {seed}");
            assert!(none.1 <= exact.1 / least, "{name}, {seed}: {none:?} {exact:?}");
            looser[0] += usize::from(receivers.1 < 0.99 * exact.1);
            looser[1] += usize::from(none.0 < 0.99 * exact.0);
        }
        assert!(looser.iter().all(|n| *n > 0), "{name}: {looser:?} of {SCENES} differ");
    }
}

#[test]
fn a_floor_that_casts_on_nothing_leaves_the_map_to_what_stands_on_it() {
    let v = DVec3::new;
    let floor = (square(), DMat3::from_diagonal(v(50.0, 1.0, 50.0)), DVec3::ZERO);
    let stone = (cube(), DMat3::IDENTITY, v(3.0, 1.0, 0.0));
    // In the plane of sun and stone, so that the map stands along the stone's sides.
    let camera = look(v(-60.0, 30.0, 0.0), DVec3::ZERO, 1.0, 1.0, 200.0);
    let sun = directional(v(1.0, -1.0, 0.0));
    let at = (placed(&[floor.clone(), stone.clone()]), camera, sun);
    let b = Boxes::new(&at.0, &at.1, &at.2, RESOLUTION);
    let texel = |at: &(Scene, Camera, Light), fit: &str| {
        let p = map_of("uniform", fit, at, &b).expect("a map");
        p.value("texel_x").expect("a size") * p.value("texel_y").expect("a size")
    };
    // The stone as the sun sees it: 2 by 2 √2, on 510 texels each way.
    let expected = 4.0 * 2.0_f64.sqrt() / (510.0 * 510.0);
    assert!((texel(&at, "intersection") / expected - 1.0).abs() < 1e-9, "{}", texel(&at, "intersection") / expected);
    assert!(texel(&at, "exact") > 300.0 * expected);
    // A second floor below: now the first casts on it wherever it is.
    let below = (square(), DMat3::from_diagonal(v(50.0, 1.0, 50.0)), DVec3::NEG_Y);
    let two = (placed(&[floor, stone, below]), camera, sun);
    assert!(texel(&two, "intersection") > 300.0 * expected);
}

#[test]
fn a_wall_in_the_plane_of_the_light_casts_on_itself() {
    // Turned by a right angle, it is off the plane by rounding, to either side.
    for turn in
        [DMat3::from_rotation_x(0.5 * std::f64::consts::PI), DMat3::from_rotation_x(-0.5 * std::f64::consts::PI)]
    {
        let wall = (square(), turn * DMat3::from_diagonal(DVec3::new(10.0, 1.0, 5.0)), DVec3::ZERO);
        let at = (
            placed(&[wall]),
            look(DVec3::new(3.0, 2.0, 20.0), DVec3::ZERO, 1.0, 0.1, 100.0),
            directional(DVec3::NEG_Y),
        );
        let b = Boxes::new(&at.0, &at.1, &at.2, RESOLUTION);
        for name in warps() {
            for fit in words() {
                let Some(p) = map_of(name, fit, &at, &b) else { continue };
                let [(top, _), (bottom, _)] = [5.0, -5.0].map(|y| p.partitions[0].project(DVec3::new(4.0, y, 0.0)));
                assert!(top.z >= 0.0 && top.z < bottom.z && bottom.z <= 1.0, "{name}, {fit}: {top} above {bottom}");
            }
        }
    }
}
