//! Input of every kind has an answer: a code, finite numbers, or an error that says what to do.

use glam::{DMat4, DVec3};
use proptest::prelude::*;
use shadowlab::aliasing::footprint::{footprint, footprint_at};
use shadowlab::image::{Footprint, GBuffer};
use shadowlab::parameterization::PostWarp;
use shadowlab::{Error, Parameterization, Partition, Progress};

use super::images::{image, views};
use super::measured::{MAJOR, Picture, Sizes, at, gbuffer};
use crate::support::by_body::by_body;
use crate::support::views::{View, by_hand, directional};

pub const SIZE: [u32; 2] = [70, 50];
pub const SIZES: Sizes = Sizes { image: SIZE, map: [512, 384] };

/// The floor, which light from below does not reach.
pub fn floor(along: DVec3) -> View {
    let (name, scene, camera) = by_hand().into_iter().find(|s| s.0 == "floor").expect("the floor");
    View { name: name.into(), scene, camera, light: directional(along) }
}

pub fn maps_of(v: &View, text: &str) -> Parameterization {
    by_body(text).parameterize(&v.scene, &v.camera, &v.light, 512).expect("a map")
}

pub fn of_matrix(m: DMat4) -> Parameterization {
    Parameterization::of_partitions(vec![Partition::of_matrix(m)], [512; 2])
}

/// Every pixel is one of these codes or a map with finite numbers, and NaN where there is none.
pub fn assert_sound(what: &str, f: &Picture, maps: usize) {
    for (i, (code, numbers)) in f.map.iter().zip(&f.numbers).enumerate() {
        assert!((-3..maps as i16).contains(code), "{what}: {code}");
        let sound = |x: &f32| if *code >= 0 { x.is_finite() } else { x.is_nan() };
        assert!(numbers.iter().all(sound), "{what}: pixel {i}, {code}, {numbers:?}");
    }
}

#[test]
fn what_faces_away_and_what_is_not_there() {
    let v = floor(DVec3::NEG_Y);
    let g = gbuffer(&v, SIZE);
    let seen = g.triangle.iter().filter(|t| **t >= 0).count();
    assert!(seen > 500 && seen < g.triangle.len(), "{seen}");
    for text in ["uniform", "z_partition:count=3"] {
        let p = maps_of(&v, text);
        let lit = image(&v, &g, &p);
        assert_sound(text, &lit, p.partitions.len());
        assert_eq!(lit.count(Footprint::NOTHING), g.triangle.len() - seen);
        assert_eq!(lit.measured(), seen);
        // The same maps under a light from below.
        let below = View { light: directional(DVec3::Y), ..floor(DVec3::Y) };
        let f = image(&below, &g, &p);
        assert_sound(text, &f, p.partitions.len());
        assert_eq!(f.count(Footprint::AVERTED), seen, "{text}");
        assert_eq!(f.count(Footprint::NOTHING), g.triangle.len() - seen, "{text}");
        // Edge on is averted.
        let level = View { light: directional(DVec3::X), ..floor(DVec3::X) };
        assert_eq!(image(&level, &g, &p).count(Footprint::AVERTED), seen, "{text}");
    }
    let (_, scene, camera) = by_hand().into_iter().find(|s| s.0 == "nothing in view").expect("a scene");
    let nothing = View { name: "nothing".into(), scene, camera, light: directional(DVec3::NEG_Y) };
    let p = maps_of(&nothing, "uniform");
    let f = image(&nothing, &gbuffer(&nothing, SIZE), &p);
    assert_sound("nothing", &f, 1);
    assert_eq!(f.count(Footprint::NOTHING), f.map.len());
}

#[test]
fn points_without_a_texel_say_why() {
    let v = floor(DVec3::NEG_Y);
    let p = maps_of(&v, "uniform");
    let q = DVec3::new(0.0, 0.0, -8.0);
    let (eye, f) = (v.camera.eye(), v.camera.forward());
    let cases = [
        (q, DVec3::Y, 0),
        (q, DVec3::NEG_Y, Footprint::AVERTED),
        (q, DVec3::X, Footprint::AVERTED),
        (q, DVec3::ZERO, Footprint::NOTHING),
        (q, DVec3::NAN, Footprint::NOTHING),
        (q, DVec3::INFINITY, Footprint::NOTHING),
        (eye, DVec3::Y, Footprint::NOTHING),
        (eye - f, DVec3::Y, Footprint::NOTHING),
        (DVec3::NAN, DVec3::Y, Footprint::NOTHING),
        (eye + f * 1e9, DVec3::Y, Footprint::NO_MAP),
    ];
    let (places, normals): (Vec<_>, Vec<_>) = cases.iter().map(|c| (c.0, c.1)).unzip();
    for ((q, n, code), (ours, texel)) in cases.iter().zip(at(&v, &p, SIZES, &places, &normals)) {
        assert_eq!(ours, *code, "{q}, {n}: {texel:?}");
    }
    assert!(at(&v, &p, SIZES, &[], &[]).is_empty());
}

#[test]
fn matrices_that_are_none_of_this_light() {
    let v = &views()[0];
    let g = gbuffer(v, SIZE);
    let camera = v.camera.clip_from_world();
    let mut met = 0;
    let foreign = [
        ("the camera's own", camera),
        ("of another light", maps_of(&views()[1], "lispsm").partitions[0].shadow_clip_from_world),
        ("of a spot", maps_of(&views()[3], "uniform").partitions[0].shadow_clip_from_world),
        ("orthographic from the side", DMat4::from_scale(DVec3::splat(0.01))),
        ("mirrored", DMat4::from_scale(DVec3::new(-0.01, 0.01, 0.01))),
        ("tiny numbers", DMat4::from_cols_array(&camera.to_cols_array().map(|x| x * 1e-30))),
        ("huge numbers", DMat4::from_cols_array(&camera.to_cols_array().map(|x| x * 1e30))),
    ];
    for (what, m) in foreign {
        let f = image(v, &g, &of_matrix(m));
        assert_sound(what, &f, 1);
        met += f.measured();
        let mut log = of_matrix(m);
        log.partitions[0].post_warp = PostWarp::Log { scale: 0.3, offset: -0.2 };
        assert_sound(what, &image(v, &g, &log), 1);
    }
    assert!(met > 2000, "{met}");
    // A texel of the image itself, in pixels: its own size, whatever the surface.
    let one = image(v, &g, &of_matrix(camera));
    let own = at(v, &of_matrix(camera), Sizes { image: [512, 384], map: [512, 384] }, &[DVec3::ZERO], &[DVec3::Y])[0];
    for (ours, theirs) in own.1.jacobian.iter().zip([1.0, 0.0, 0.0, 1.0]) {
        assert!((ours - theirs).abs() < 1e-12, "{own:?}");
    }
    assert!(one.map.iter().zip(&one.numbers).all(|(k, n)| *k < 0 || (n[MAJOR] - 70.0 / 512.0).abs() < 1e-5));
}

pub fn refused<T: std::fmt::Debug>(result: Result<T, Error>) -> String {
    match result {
        Err(Error::InvalidArgument { name, .. }) => name.to_string(),
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_is_wrong_is_said() {
    let v = floor(DVec3::NEG_Y);
    let (g, good) = (gbuffer(&v, SIZE), maps_of(&v, "uniform"));
    let of = |g: &GBuffer, p: &Parameterization, map: [u32; 2]| {
        refused(footprint(&g.surfaces(), &v.camera, &v.light, p, map, &Progress::new()))
    };
    let at = |points: &[[f64; 3]], normals: &[[f64; 3]], p: &Parameterization, map: [u32; 2], image: [u32; 2]| {
        refused(footprint_at(points, normals, &v.camera, &v.light, p, map, image))
    };
    let empty = GBuffer {
        size: [0, 0],
        depth: vec![],
        position: vec![],
        normal: vec![],
        triangle: vec![],
        instance: vec![],
        ..g.clone()
    };
    assert_eq!(of(&empty, &good, SIZES.map), "gbuffer");
    assert_eq!(of(&GBuffer { size: [0, 7], ..empty }, &good, SIZES.map), "gbuffer");
    let mut short = g.clone();
    short.position.pop();
    assert_eq!(of(&short, &good, SIZES.map), "gbuffer.position");
    let mut long = g.clone();
    long.normal.push([0.0; 3]);
    assert_eq!(of(&long, &good, SIZES.map), "gbuffer.normal");
    let mut other = g.clone();
    other.triangle.truncate(10);
    assert_eq!(of(&other, &good, SIZES.map), "gbuffer.triangle");
    let mut fewer = g.clone();
    fewer.instance.truncate(10);
    assert_eq!(of(&fewer, &good, SIZES.map), "gbuffer.instance");
    let none = Parameterization { partitions: vec![], ..good.clone() };
    let many = Parameterization { partitions: vec![good.partitions[0].clone(); 32_768], ..good.clone() };
    let (points, normals) = ([[0.0, 0.0, -8.0]; 2], [[0.0, 1.0, 0.0]; 2]);
    for p in [&none, &many] {
        assert_eq!(of(&g, p, SIZES.map), "parameterization");
        assert_eq!(at(&points, &normals, p, SIZES.map, SIZE), "parameterization");
    }
    for x in [f64::NAN, f64::INFINITY] {
        let mut m = good.clone();
        m.partitions[0].shadow_clip_from_world.y_axis.z = x;
        assert_eq!(of(&g, &m, SIZES.map), "shadow_clip_from_world");
        assert_eq!(at(&points, &normals, &m, SIZES.map, SIZE), "shadow_clip_from_world");
    }
    let progress = Progress::new();
    progress.stop();
    let stopped = footprint(&g.surfaces(), &v.camera, &v.light, &good, SIZES.map, &progress);
    assert!(matches!(stopped, Err(Error::Interrupted)), "{stopped:?}");
}

/// Numbers of all sizes that f32 has squares of, and zero.
pub fn number() -> impl Strategy<Value = f64> {
    let sized = (-1.0..1.0_f64, -15.0..15.0_f64).prop_map(|(x, e)| x * 10_f64.powf(e));
    prop_oneof![8 => -2.0..2.0_f64, 2 => sized, 1 => Just(0.0), 1 => Just(1.0)]
}

pub fn vector(of: impl Strategy<Value = f64> + Clone) -> impl Strategy<Value = DVec3> {
    (of.clone(), of.clone(), of).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

/// The texel of one point, alone and as an image of one pixel.
pub fn assert_finite(numbers: &[f64], q: DVec3, n: DVec3, log: bool) {
    let flat: [f64; 16] = numbers.try_into().expect("16");
    let v = floor(DVec3::NEG_Y);
    let mut p = of_matrix(DMat4::from_cols_array(&flat));
    if log {
        p.partitions[0].post_warp = PostWarp::Log { scale: flat[0], offset: flat[5] };
    }
    // What overflows on the way to the eye is told.
    let arrays = ([q.to_array()], [n.to_array()]);
    let found = footprint_at(&arrays.0, &arrays.1, &v.camera, &v.light, &p, SIZES.map, SIZE);
    for (code, t) in found.unwrap_or_default() {
        let numbers =
            [t.major, t.minor, t.perspective, t.projection, t.perspective_ts[0], t.perspective_ts[1], t.depth];
        let numbers = [&numbers[..], &t.jacobian].concat();
        assert!(code < 0 || numbers.iter().all(|x| x.is_finite()), "{q}, {n}, {p:?}: {t:?}");
        assert!(code < 0 || (t.major >= 0.0 && t.minor >= 0.0 && t.projection >= 0.0), "{t:?}");
    }
    let single = |v: DVec3| v.to_array().map(|x| x.clamp(-1e30, 1e30) as f32);
    let g = GBuffer {
        size: [1, 1],
        origin: DVec3::ZERO,
        depth: vec![0.5],
        position: vec![single(q)],
        normal: vec![single(n)],
        triangle: vec![0],
        instance: vec![0],
    };
    if let Ok(f) = footprint(&g.surfaces(), &v.camera, &v.light, &p, SIZES.map, &Progress::new()) {
        assert_sound(&format!("{q}, {n}, {p:?}"), &Picture::of(&f), 1);
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_texel_is_nan(
        m in prop::collection::vec(number(), 16),
        q in vector(number().boxed()),
        n in vector(number().boxed()),
        log in any::<bool>(),
    ) {
        assert_finite(&m, q, n, log);
    }
}
