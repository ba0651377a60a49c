//! Rectilinear maps: the density in closed form against others, what a warp never does, and the bases that it takes.

use glam::{DMat2, DMat3, DVec2};
use shadowlab::Error;
use shadowlab::fit::MapSize;
use shadowlab::focus::RayEdge;
use shadowlab::parameterization::{PiecewiseLinear, PostWarp};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Renderer, Stored};
use shadowlab::scene::{Light, SpotLight};
use shadowlab::techniques::rectilinear::{Densities, EdgeWidths, least_density};
use shadowlab::techniques::{Needs, technique_of};
use shadowlab::{Parameterization, Progress};

use crate::support::views::{Random, View, from_library};

const RESOLUTION: u32 = 512;
/// Of f64 through sums over a few thousand edges.
const EXACT: f64 = 1e-12;

/// Edges all over the square that the receivers of a map fill, each as wide as `across` says of its place.
fn edges(size: &MapSize, count: u32, mut across: impl FnMut(DVec2) -> DVec2) -> Vec<RayEdge> {
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(count) * 2.0 - 1.0;
    let places = (0..count * count).map(|i| DVec2::new(at(i % count), at(i / count)) * size.inset());
    let edge = |ray: DVec2| RayEdge { ray, pixel: DMat2::IDENTITY, across: across(ray), weight: 1.0, depth: 1.0 };
    places.map(edge).collect()
}

fn maps(text: &str, v: &View) -> Parameterization {
    let t = technique_of(text).expect(text);
    t.parameterize_seen(&v.scene, &v.camera, &v.light, [RESOLUTION; 2], Some(&v.samples())).expect(text)
}

fn functions(p: &Parameterization) -> Vec<&PiecewiseLinear> {
    p.partitions.iter().filter_map(|map| map.post_warp.rectilinear()).flat_map(|warp| [&warp.x, &warp.y]).collect()
}

#[test]
fn the_density_is_the_least_of_all() {
    let mut random = Random(41);
    for _ in 0..50 {
        let costs: Vec<f64> = (0..3).map(|_| random.between(0.0, 1.0).powi(3)).collect();
        let density = least_density(&costs);
        let sum = |density: &[f64]| costs.iter().zip(density).map(|(c, d)| if *c > 0.0 { c / d } else { 0.0 }).sum();
        let least: f64 = sum(&density);
        assert!((density.iter().sum::<f64>() / 3.0 - 1.0).abs() < EXACT);
        // By Cauchy and Schwarz.
        let roots: f64 = costs.iter().map(|cost| cost.sqrt()).sum();
        assert!((least / (roots * roots / 3.0) - 1.0).abs() < EXACT, "{least}");
        // All densities on a grid: none has less, and the closest hardly more.
        let grid = 200;
        let mut found = f64::INFINITY;
        for i in 1..3 * grid {
            for j in 1..3 * grid - i {
                let of = |n: i32| f64::from(n) / f64::from(grid);
                found = found.min(sum(&[of(i), of(j), of(3 * grid - i - j)]));
            }
        }
        assert!(least <= found * (1.0 + EXACT) && found < 1.01 * least, "{least} and {found}");
    }
    assert_eq!(least_density(&[0.0; 4]), [1.0; 4], "no cost tells one from another");
}

#[test]
fn even_costs_leave_the_map_even_and_others_draw_texels_to_them() {
    let size = MapSize::new([RESOLUTION, 256]).expect("a size");
    let homography = DMat3::from_cols_array(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let flat = EdgeWidths::new(&edges(&size, 128, |_| DVec2::new(900.0, 400.0)), &homography, &size, 32);
    let even = Densities::least(&flat, 0.1, 16.0).expect("edges");
    for density in even.along.iter().flatten() {
        assert!((density - 1.0).abs() < EXACT, "{density}");
    }
    // Without a cap the mean is that of both sides of a texel.
    let texel = DVec2::new(900.0 * 2.0 / 512.0, 400.0 * 2.0 / 256.0);
    let mean = flat.mean(&even, f64::INFINITY);
    assert!((mean / (texel.x + texel.y) - 1.0).abs() < EXACT, "{mean}");
    // Four times as wide on the right: twice as dense, the border of the halves smoothed.
    let halves = edges(&size, 128, |at| DVec2::new(if at.x > 0.0 { 400.0 } else { 100.0 }, 10.0));
    let halves = EdgeWidths::new(&halves, &homography, &size, 32);
    let found = Densities::least(&halves, 0.01, f64::INFINITY).expect("edges");
    let [x, y] = &found.along;
    assert!((x[28] / x[3] - 2.0).abs() < EXACT && (x[16] / x[15]) < 2.0, "{x:?}");
    assert!(y.iter().all(|density| (density - 1.0).abs() < EXACT));
    assert!(halves.mean(&found, f64::INFINITY) < halves.mean(&even, f64::INFINITY));
}

#[test]
fn more_steps_gain_next_to_nothing_and_none_loses() {
    let (mut random, size) = (Random(47), MapSize::new([RESOLUTION; 2]).expect("a size"));
    for cap in [4.0, 16.0, 64.0] {
        // Widths spread over decades around the cap, and are larger at some places.
        let all: Vec<DVec2> = (0..64 * 64).map(|_| DVec2::new(random.unit(), random.unit())).collect();
        let mut next = all.iter();
        let across = edges(&size, 64, |at| {
            let t = next.next().copied().unwrap_or_default();
            DVec2::new((5.0 * t.x + 2.0 * at.x).exp(), (5.0 * t.y * (1.0 - at.y * at.y)).exp()) * 64.0
        });
        let widths = EdgeWidths::new(&across, &DMat3::IDENTITY, &size, 64);
        let mean = |steps: usize| widths.mean(&Densities::after(steps, &widths, 0.05, cap), cap);
        assert!(mean(1) < mean(0), "{} and {}", mean(1), mean(0));
        for steps in 1..=Densities::STEPS {
            assert!(mean(steps) <= mean(steps - 1));
        }
        let [chosen, many] = [mean(Densities::STEPS), mean(10 * Densities::STEPS)];
        assert!(many > chosen * (1.0 - 2e-3), "cap {cap}: {chosen} and {many}");
    }
}

#[test]
fn a_floor_holds_and_one_leaves_all_even() {
    let mut random = Random(43);
    let size = MapSize::new([RESOLUTION; 2]).expect("a size");
    let homography = DMat3::IDENTITY;
    for floor in [1e-3, 0.05, 0.3, 0.9, 1.0] {
        let few = edges(&size, 6, |at| if at.x > 0.5 { DVec2::new(random_of(at), 3.0) } else { DVec2::ZERO });
        let widths = EdgeWidths::new(&few, &homography, &size, 64);
        let found = Densities::least(&widths, floor, random.between(4.0, 64.0)).expect("edges");
        for along in &found.along {
            let mean = along.iter().sum::<f64>() / along.len() as f64;
            assert!((mean - 1.0).abs() < EXACT, "{mean}");
            let least = along.iter().copied().fold(f64::INFINITY, f64::min);
            assert!(least >= floor * (1.0 - EXACT), "{least} below {floor}");
        }
    }
    let none = EdgeWidths::new(&[], &homography, &size, 8);
    assert!(Densities::least(&none, 0.1, 16.0).is_none());
}

fn random_of(at: DVec2) -> f64 {
    300.0 + 200.0 * (17.0 * at.x + 5.0 * at.y).sin()
}

#[test]
fn warps_ascend_keep_the_border_and_never_cost_more_than_none() {
    let (mut gained, mut views) = (0, 0);
    for v in from_library() {
        for text in ["rectilinear", "rectilinear:base=lispsm,bins=7", "rectilinear:base=uniform,cap=none,floor=0.01"] {
            let p = maps(text, &v);
            let what = format!("{} / {text}", v.name);
            assert_eq!(p.technique, "rectilinear", "{what}");
            let size = MapSize::new([RESOLUTION; 2]).and_then(|size| size.with_room(1.0, 1.0)).expect("a size");
            for f in functions(&p) {
                let knots: Vec<[f64; 2]> = f.knots().collect();
                assert!(knots.windows(2).all(|k| k[0][0] < k[1][0] && k[0][1] < k[1][1]), "{what}: {knots:?}");
                let inset = size.inset().x;
                for kept in [-1.0, -inset, inset, 1.0] {
                    assert!((f.after(kept) - kept).abs() <= EXACT, "{what}: {kept} to {}", f.after(kept));
                }
            }
            for map in &p.partitions {
                let (Some(even), Some(warped)) = (map.value("edge_width_even"), map.value("edge_width")) else {
                    assert_eq!(map.post_warp, PostWarp::None, "{what}");
                    continue;
                };
                assert!(warped <= even, "{what}: {warped} and {even}");
                gained += usize::from(warped < 0.9 * even);
                views += 1;
            }
        }
    }
    assert!(2 * gained > views, "{gained} of {views} maps gain a tenth");
}

#[test]
fn the_homography_is_that_of_the_base() {
    for v in from_library() {
        for (text, base) in [
            ("rectilinear", "scene_optimal"),
            ("rectilinear:fit=seen,range=body,margin=3", "scene_optimal:fit=seen,range=body,margin=3"),
            ("rectilinear:base=lispsm", "lispsm"),
            ("rectilinear:base=uniform", "uniform:range=seen,fit=shadow"),
            ("rectilinear:base=(uniform:turn=rectangle)", "uniform:turn=rectangle,range=seen,fit=shadow"),
            ("z_partition:count=2,inner=rectilinear", "z_partition:count=2,inner=scene_optimal"),
        ] {
            let (own, other) = (maps(text, &v), maps(base, &v));
            assert_eq!(own.partitions.len(), other.partitions.len());
            for (a, b) in own.partitions.iter().zip(&other.partitions) {
                assert_eq!(a.shadow_clip_from_world, b.shadow_clip_from_world, "{} / {text}", v.name);
                assert_eq!((a.eye_depth, &a.region), (b.eye_depth, &b.region), "{} / {text}", v.name);
            }
        }
    }
}

#[test]
fn a_floor_of_one_draws_the_map_of_the_base() {
    let v = from_library().into_iter().find(|v| v.name.contains("robots")).expect("a scene");
    let (own, base) = (maps("rectilinear:floor=1", &v), maps("scene_optimal", &v));
    let draw = |p| {
        CpuRenderer::new()
            .depth_maps(&v.scene, p, [RESOLUTION; 2], Stored::default(), &Progress::new())
            .expect("maps")
            .data
    };
    let (own, base) = (draw(&own), draw(&base));
    // Outlines move by 1/512 of a texel where the other rasteriser rounds.
    let differ = own.iter().zip(&base).filter(|(a, b)| (**a - **b).abs() > 1e-4).count();
    assert!(differ < own.len() / 100, "{differ} of {} texels", own.len());
}

#[test]
fn bases_that_have_no_projective_map_of_their_own_are_refused() {
    for (base, says) in [
        ("log_psm", "uneven"),
        ("rectilinear", "uneven"),
        ("z_partition", "divides"),
        ("face_partition", "divides"),
        ("(uniform:stable=true)", "stable"),
        ("(lispsm:fit=seen)", "without fit"),
        ("(lispsm:margin=2,near=basic)", "without margin"),
        ("(uniform:range=seen)", "without range"),
    ] {
        match technique_of(&format!("rectilinear:base={base}")) {
            Err(error @ Error::InvalidArgument { .. }) => {
                let text = error.to_string();
                assert!(text.starts_with("base: expected") && text.contains(says), "{base}: {text}");
            }
            other => panic!("{base}: {other:?}"),
        }
    }
    for base in ["nothing", "lispsm/uniform", "(lispsm:nera=1)"] {
        assert!(technique_of(&format!("rectilinear:base={base}")).is_err(), "{base}");
    }
    assert_eq!(technique_of("rectilinear:base=uniform").expect("one").needs(), Needs::Shadows);
}

#[test]
fn lights_are_those_of_the_base() {
    let lamp = Light::Spot(SpotLight::new(glam::DVec3::Y * 9.0, glam::DVec3::NEG_Y, 1.0, 50.0).expect("a lamp"));
    let serves = |text: &str| technique_of(text).expect(text).serves(&lamp);
    assert!(serves("rectilinear").is_ok() && serves("rectilinear:base=lispsm").is_ok());
    match serves("rectilinear:base=glpr") {
        Err(Error::UnsupportedLight { technique, .. }) => assert_eq!(technique, "glpr"),
        other => panic!("{other:?}"),
    }
}
