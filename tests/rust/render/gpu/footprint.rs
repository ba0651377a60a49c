//! The texel at every pixel on a graphics device: as on the processor, to bounds that follow from single precision.

use glam::{DMat4, DVec3, DVec4};
use shadowlab::image::{Footprint, GBuffer};
use shadowlab::parameterization::PostWarp;
use shadowlab::rays::LightFrame;
use shadowlab::render::Renderer;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::scene::{DirectionalLight, PointLight, SpotLight, library};
use shadowlab::{Camera, Error, Light, Mesh, Parameterization, Progress, Result, Scene};

use super::footprints::{Agreement, NAMES, compare};
use crate::render::selection::maps::{self, View, faces, lamp};
use crate::support::by_body::by_body;
use crate::support::gpu::{camera_above, renderer, single_map};

const SIZE: [u32; 2] = [320, 240];
const RESOLUTION: [u32; 2] = [1024, 512];
/// Relative deviation that half of the pixels of a view stay within: a few roundings of single precision.
const HALF: f64 = 1e-6;
/// What all but [`GRAZING_SHARE`] stay within: a hundred times that, for surfaces that eye or light see at a hundredth.
const NEARLY_ALL: f64 = 1e-4;
/// Pixels of surfaces that eye or light graze closer than that; each has its own bound.
const GRAZING_SHARE: f64 = 1e-2;

/// A view of a library scene with the maps of a technique.
fn view_of(scene: &str, params: &[(String, f64)], technique: &str) -> View {
    let library::LibraryScene { scene: built, camera, light, .. } = library::build(scene, 1, params).unwrap();
    let p = by_body(technique).parameterize(&built, &camera, &light, RESOLUTION[0]).unwrap();
    View { name: format!("{scene}, {technique}"), scene: built, camera, light, p, whole: None }
}

/// A uniform map whose w goes from 1 to `ratio` along one of its axes, upwards or downwards.
fn warped(scene: &str, ratio: f64, upwards: f64) -> View {
    let mut v = view_of(scene, &[], "uniform");
    let (least, slope) = (0.5 * (1.0 + 1.0 / ratio), 0.5 * (1.0 - 1.0 / ratio) * upwards);
    // w from 1 / ratio at one side of the map to 1 at the other; y kept in [-1, 1], x in the map where w is large.
    let rows = DMat4::from_cols(
        DVec4::new(0.1, 0.0, 0.0, 0.0),
        DVec4::new(0.0, least, 0.0, slope),
        DVec4::new(0.0, 0.0, 1.0 / ratio, 0.0),
        DVec4::new(0.0, slope, 0.0, least),
    );
    let m = &mut v.p.partitions[0].shadow_clip_from_world;
    *m = rows.transpose() * *m;
    v.name = format!("{scene}, w over {ratio:e}, {upwards}");
    v
}

fn views() -> Vec<View> {
    let mut all: Vec<View> = [
        ("courtyard", "uniform"),
        ("courtyard", "z_partition:count=4,inner=lispsm"),
        ("courtyard", "log"),
        ("courtyard", "log_psm:warp=gmnpr"),
        ("robots", "lispsm"),
        ("robots", "tsm"),
        ("robots", "face_partition:inner=uniform"),
        ("robots", "z_partition:count=3,inner=log"),
        ("ceiling", "xpsm"),
        ("skylight", "psm"),
        ("dueling", "lispsm"),
        ("forest", "gmnpr"),
    ]
    .map(|(scene, technique)| view_of(scene, &[], technique))
    .into();
    let spot = [("spot".to_string(), 1.0)];
    all.extend(["uniform", "lispsm"].map(|technique| View {
        name: format!("skylight, spot, {technique}"),
        ..view_of("skylight", &spot, technique)
    }));
    for scene in ["robots", "courtyard"] {
        let mut v = view_of(scene, &[], "uniform");
        let point = lamp(&v.scene, DVec3::new(0.52, 0.7, 0.47));
        let range = point.range();
        (v.p, v.light) = (faces(&point, 1e-3 * range, range), Light::Point(point));
        v.name = format!("{scene}, six faces");
        let p = by_body("lispsm").parameterize(&v.scene, &v.camera, &v.light, RESOLUTION[0]).unwrap();
        let name = format!("{scene}, lispsm of a point light");
        all.push(View { name, scene: v.scene.clone(), camera: v.camera, light: v.light, p, whole: None });
        all.push(v);
    }
    for ratio in [1e2, 1e4] {
        all.extend([-1.0, 1.0].map(|upwards| warped("courtyard", ratio, upwards)));
    }
    all
}

/// The footprint and the G-buffer that a renderer makes of a view.
fn drawn(r: &dyn Renderer, v: &View, size: [u32; 2]) -> (Footprint, GBuffer) {
    let progress = Progress::new();
    let f = r.footprint(&v.scene, &v.camera, &v.light, &v.p, RESOLUTION, size, &progress).unwrap();
    (f, r.gbuffer(&v.scene, &v.camera, size, &progress).unwrap())
}

#[test]
fn both_renderers_find_the_same_texels() {
    let Some(gpu) = renderer() else { return };
    for v in views() {
        let (a, of_a) = drawn(&gpu, &v, SIZE);
        let (b, of_b) = drawn(&CpuRenderer::new(), &v, SIZE);
        let found = compare(&v, RESOLUTION, [&a, &b], [&of_a, &of_b]);
        println!("{}: {}", v.name, found.summary());
        found.assert_close(&v.name);
        assert!(found.same as f64 > 0.99 * a.map.len() as f64, "{}", v.name);
        assert!(found.served > found.same / 20, "{}: an empty footprint agrees with anything", v.name);
        for (k, name) in NAMES.into_iter().enumerate() {
            let (half, most) = (found.quantile(k, 0.5), found.quantile(k, 1.0 - GRAZING_SHARE));
            assert!(half <= HALF && most <= NEARLY_ALL, "{}, {name}: {half:e}, {most:e}", v.name);
        }
    }
}

#[test]
fn bands_of_rows_meet() {
    let Some(gpu) = renderer() else { return };
    // 44 bytes a pixel in bands of 32 MiB: two, the second of them smaller.
    let (v, size) = (view_of("robots", &[], "lispsm"), [1200, 900]);
    let [(a, of_a), (b, of_b)] = [&gpu as &dyn Renderer, &CpuRenderer::new()].map(|r| drawn(r, &v, size));
    let found = compare(&v, RESOLUTION, [&a, &b], [&of_a, &of_b]);
    println!("{}", found.summary());
    found.assert_close("bands");
    assert!(found.served > a.map.len() / 2);
}

#[test]
fn the_comparison_fails_on_one_pixel() {
    let v = view_of("robots", &[], "lispsm");
    let (f, g) = drawn(&CpuRenderer::new(), &v, SIZE);
    let compared = |change: &dyn Fn(&mut Footprint)| {
        let mut other = f.clone();
        change(&mut other);
        compare(&v, RESOLUTION, [&other, &f], [&g, &g])
    };
    let fails = |found: &Agreement| std::panic::catch_unwind(|| found.assert_close("")).is_err();
    let same = compared(&|_| ());
    assert!(same.over.is_empty() && same.other_map == 0 && same.worst_roundings == [0.0; 7], "{}", same.summary());
    same.assert_close("itself");
    // A pixel that is seen and lit well, and one that no map serves.
    let i =
        (0..f.map.len()).find(|&i| f.map[i] >= 0 && (0.5..2.0).contains(&f.plane(Footprint::PROJECTION)[i])).unwrap();
    let none = (0..f.map.len()).find(|&i| f.map[i] == Footprint::AVERTED).unwrap();
    let scaled = |i: usize, plane: usize, factor: f32| {
        compared(&|f| {
            let at = plane * f.map.len() + i;
            f.planes[at] *= factor;
        })
    };
    let planes = [
        Footprint::JACOBIAN,
        Footprint::MAJOR,
        Footprint::PERSPECTIVE,
        Footprint::PERSPECTIVE_TS,
        Footprint::PERSPECTIVE_TS + 1,
        Footprint::PROJECTION,
        Footprint::DEPTH,
    ];
    for (plane, name) in planes.into_iter().zip(NAMES) {
        let found = scaled(i, plane, 1.01);
        assert!(found.over.len() == 1 && found.over[0].0 == i && found.over[0].1 == name, "{name}: {:?}", found.over);
        assert!(fails(&found));
        assert_eq!(scaled(i, plane, 1.0 + 2.0 * f32::EPSILON).over, [], "the last place is nothing");
    }
    for i in [i, none] {
        let is_over = fails(&scaled(i, Footprint::MAJOR, f32::NAN));
        assert_eq!(is_over, i != none, "a NaN belongs where nothing is");
        assert!(fails(&compared(&|f| f.map[i] = Footprint::NO_MAP)));
        assert!(fails(&compared(&|f| f.map[i] = Footprint::NOTHING)));
    }
    assert!(fails(&compared(&|f| f.planes[none] = 1.0)), "a number where there is none");
}

/// The result of a footprint of robots, with something of the input changed.
fn of_robots(change: impl Fn(&mut View), resolution: [u32; 2], size: [u32; 2]) -> Option<Result<Footprint>> {
    let gpu = renderer()?;
    let mut v = view_of("robots", &[], "uniform");
    change(&mut v);
    Some(gpu.footprint(&v.scene, &v.camera, &v.light, &v.p, resolution, size, &Progress::new()))
}

#[test]
fn what_shows_nothing_has_no_texel() {
    let away = |v: &mut View| {
        let (eye, up) = (v.scene.bounds().max + DVec3::Y, DVec3::X);
        v.camera = Camera::look_at(eye, eye + DVec3::Y, up, 1.0, 1.0, 0.1, 1000.0).unwrap();
    };
    let Some(f) = of_robots(away, RESOLUTION, [50, 30]) else { return };
    let f = f.unwrap();
    assert!(f.map == [Footprint::NOTHING; 1500] && f.size == [50, 30]);
    assert!(f.planes.len() == 1500 * Footprint::PLANES && f.planes.iter().all(|x| x.is_nan()));
}

#[test]
fn what_no_light_reaches_is_averted() {
    let Some(gpu) = renderer() else { return };
    let corners = [[-9.0, 0.0, -9.0], [9.0, 0.0, -9.0], [9.0, 0.0, 9.0], [-9.0, 0.0, 9.0]];
    let scene = Scene::from_mesh(Mesh::new(&corners, &[[0, 1, 2], [0, 2, 3]]).unwrap()).unwrap();
    // A map from above, whoever the light is.
    let down = LightFrame::any(DVec3::NEG_Y);
    let p = single_map(down.perspective(4.0 * DVec3::Y, 1.0, 0.1, 100.0).matrix());
    let below = Light::Directional(DirectionalLight::new(DVec3::Y).unwrap());
    let near = Light::Point(PointLight::new(4.0 * DVec3::Y, 3.9).unwrap());
    let beside = Light::Spot(SpotLight::new(4.0 * DVec3::Y, DVec3::X, 1.0, 100.0).unwrap());
    let above = Light::Directional(DirectionalLight::new(DVec3::NEG_Y).unwrap());
    for (light, map) in
        [(below, Footprint::AVERTED), (near, Footprint::AVERTED), (beside, Footprint::AVERTED), (above, 0)]
    {
        let camera = camera_above(3.0);
        let f = gpu.footprint(&scene, &camera, &light, &p, RESOLUTION, [64, 48], &Progress::new()).unwrap();
        assert_eq!(f.map, [map; 64 * 48], "{light:?}");
        assert!(f.planes.iter().all(|x| x.is_nan() == (map < 0)));
    }
}

#[test]
fn maps_that_hold_nothing_or_are_singular_serve_nothing() {
    let Some(gpu) = renderer() else { return };
    let v = view_of("robots", &[], "uniform");
    let whole = v.p.partitions[0].shadow_clip_from_world;
    let rows = whole.transpose();
    let of_rows = |x, y, z, w| DMat4::from_cols(x, y, z, w).transpose();
    for (name, m) in [
        ("nowhere", maps::nowhere()),
        ("no y", of_rows(rows.x_axis, DVec4::ZERO, rows.z_axis, rows.w_axis)),
        ("x for y", of_rows(rows.x_axis, rows.x_axis, rows.z_axis, rows.w_axis)),
        ("no w", of_rows(rows.x_axis, rows.y_axis, rows.z_axis, DVec4::ZERO)),
        ("nothing", DMat4::ZERO),
    ] {
        let p = single_map(m);
        let of =
            |r: &dyn Renderer| r.footprint(&v.scene, &v.camera, &v.light, &p, RESOLUTION, [64; 2], &Progress::new());
        let (a, b) = (of(&gpu).unwrap(), of(&CpuRenderer::new()).unwrap());
        assert!(a.map.iter().all(|&k| k < 0) && a.map.contains(&Footprint::NO_MAP), "{name}");
        assert!(b.map.iter().all(|&k| k < 0), "{name}, cpu");
    }
    // A matrix that is flat in depth has texels like any other.
    let p = single_map(of_rows(rows.x_axis, rows.y_axis, DVec4::ZERO, rows.w_axis));
    let of =
        |p: &Parameterization| gpu.footprint(&v.scene, &v.camera, &v.light, p, RESOLUTION, [64; 2], &Progress::new());
    let (flat, whole) = (of(&p).unwrap(), of(&v.p).unwrap());
    let bits = |f: &Footprint| f.planes.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!((bits(&flat), &flat.map), (bits(&whole), &whole.map));
}

#[test]
fn what_cannot_be_is_a_typed_error() {
    let unchanged = |_: &mut View| ();
    let fails = |result: Option<Result<Footprint>>, named: &str| match result {
        Some(Err(Error::InvalidArgument { name, .. })) => assert_eq!(name, named),
        Some(other) => panic!("{:?}", other.map(|f| f.size)),
        None => {}
    };
    fails(of_robots(unchanged, RESOLUTION, [0, 10]), "size");
    fails(of_robots(unchanged, [10, 0], SIZE), "resolution");
    fails(of_robots(unchanged, RESOLUTION, [10, 16385]), "size");
    fails(of_robots(|v| v.p.partitions.clear(), RESOLUTION, SIZE), "partitions");
    for (number, place) in [(f64::NAN, 5), (f64::INFINITY, 15), (f64::MAX, 0)] {
        let spoilt = |v: &mut View| {
            let mut numbers = v.p.partitions[0].shadow_clip_from_world.to_cols_array();
            numbers[place] = number;
            v.p.partitions[0].shadow_clip_from_world = DMat4::from_cols_array(&numbers);
        };
        fails(of_robots(spoilt, RESOLUTION, SIZE), "shadow_clip_from_world");
    }
    let many = |v: &mut View| v.p.partitions = vec![v.p.partitions[0].clone(); 1 << 15];
    fails(of_robots(many, RESOLUTION, SIZE), "parameterization");
}

#[test]
fn a_power_of_two_in_a_matrix_changes_no_bit() {
    let Some(gpu) = renderer() else { return };
    for technique in ["lispsm", "log"] {
        let mut v = view_of("robots", &[], technique);
        let (a, _) = drawn(&gpu, &v, SIZE);
        for power in [-40, 1, 300] {
            let before = v.p.partitions[0].clone();
            let partition = &mut v.p.partitions[0];
            partition.shadow_clip_from_world *= 2f64.powi(power);
            if let PostWarp::Log { scale, offset } = &mut partition.post_warp {
                // ln of w with the power is that without, and that of the power.
                *offset -= *scale * f64::from(power) * std::f64::consts::LN_2;
            }
            let (b, _) = drawn(&gpu, &v, SIZE);
            let bits = |f: &Footprint| f.planes.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
            let other = a.map.iter().zip(&b.map).filter(|(a, b)| a != b).count();
            // The offset is rounded, so a pixel on the border of a logarithmic map may change its side.
            assert!(other <= if technique == "log" { 2 } else { 0 }, "{technique}, {power}: {other}");
            if other == 0 {
                assert_eq!(bits(&a), bits(&b), "{technique}, {power}");
            }
            v.p.partitions[0] = before;
        }
    }
}
