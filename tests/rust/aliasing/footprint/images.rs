//! The footprint of an image against that of its points, one by one, and against what the renderer looks up.

use glam::{DMat4, DVec3};
use shadowlab::aliasing::footprint::footprint;
use shadowlab::aliasing::texel::Texel;
use shadowlab::image::{Footprint, GBuffer, ShadowMask};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::{Error, Parameterization, Progress};

use super::measured::{
    DEPTH, MAJOR, PERSPECTIVE, PERSPECTIVE_TS, PROJECTION, Picture, SINGLE, Sizes, at, differing, gbuffer,
};
use crate::support::by_body::by_body;
use crate::support::views::{View, by_hand, directional, points, spots};

pub const MAP: [u32; 2] = [512, 384];

/// Widths beside and off the runs of 64 that the kernel takes, and images of one pixel, row and column.
const IMAGES: [[u32; 2]; 10] =
    [[1, 1], [1, 7], [9, 1], [63, 5], [64, 4], [65, 4], [127, 3], [128, 2], [129, 3], [193, 70]];

pub fn image(v: &View, g: &GBuffer, p: &Parameterization) -> Picture {
    let found = footprint(&g.surfaces(), &v.camera, &v.light, p, MAP, &Progress::new()).expect("a footprint");
    assert_eq!(found.size, g.size);
    Picture::of(&found)
}

/// Lights of every kind on a town that some maps serve in parts only.
pub fn views() -> Vec<View> {
    let (_, scene, camera) = by_hand().into_iter().find(|s| s.0 == "town").expect("the town");
    let suns = [DVec3::new(0.4, -1.0, -0.3), camera.forward() - camera.up() * 1e-3, -camera.forward() - camera.up()];
    let suns = suns.map(|d| (format!("sun {d}"), directional(d)));
    let mut placed = spots(&scene, &camera);
    placed.truncate(3);
    let lights = suns.into_iter().chain(placed).chain(points(&scene, &camera));
    lights.map(|(name, light)| View { name, scene: scene.clone(), camera, light }).collect()
}

/// One map, several that are asked by depth and by containment, a logarithm, and knots.
pub const TECHNIQUES: [&str; 8] = [
    "lispsm",
    "log_psm",
    "z_partition:count=4",
    "z_partition:count=3,inner=log",
    "face_partition",
    "uniform:focus=none",
    "rectilinear:base=uniform",
    "z_partition:count=2,inner=rectilinear",
];

pub fn each(mut visit: impl FnMut(&str, &View, &Parameterization)) {
    for v in views() {
        let samples = v.samples();
        for text in TECHNIQUES {
            let t = by_body(text);
            if t.serves(&v.light).is_ok() {
                match t.parameterize_seen(&v.scene, &v.camera, &v.light, [512; 2], Some(&samples)) {
                    Ok(mut p) => {
                        visit(&format!("{} / {text}", v.name), &v, &p);
                        // Maps of the middle half, with receivers beside them and beyond their far planes.
                        for map in &mut p.partitions {
                            let half = DMat4::from_scale(DVec3::splat(2.0));
                            map.shadow_clip_from_world = half * map.shadow_clip_from_world;
                        }
                        visit(&format!("{} / middle of {text}", v.name), &v, &p);
                    }
                    Err(Error::UnsuitedView { .. }) => {}
                    Err(error) => panic!("{}, {text}: {error}", v.name),
                }
            }
        }
    }
}

/// A footprint of points as an image of f32.
fn of_points(v: &View, g: &GBuffer, p: &Parameterization) -> Picture {
    let seen: Vec<_> = (0..g.triangle.len()).map(|i| g.surfaces().receiver(i)).collect();
    let (places, normals): (Vec<_>, Vec<_>) =
        seen.iter().map(|s| s.map_or((DVec3::ZERO, DVec3::ZERO), |(q, n)| (q + g.origin, n))).unzip();
    let texels = at(v, p, Sizes { image: g.size, map: MAP }, &places, &normals);
    let numbers = |(code, t): &(i16, Texel)| {
        let ([a, b, c, d], [along_t, along_s]) = (t.jacobian, t.perspective_ts);
        let all = [a, b, c, d, t.major, t.perspective, along_t, along_s, t.projection, t.depth];
        if *code < 0 { [f32::NAN; 10] } else { all.map(|x| x as f32) }
    };
    Picture { numbers: texels.iter().map(numbers).collect(), map: texels.iter().map(|t| t.0).collect() }
}

#[test]
fn an_image_is_its_points_in_every_size() {
    let mut codes = std::collections::BTreeSet::new();
    each(|what, v, p| {
        for size in IMAGES {
            let g = gbuffer(v, size);
            let ours = image(v, &g, p);
            let theirs = of_points(v, &g, p);
            assert_eq!(differing(&ours, &theirs, SINGLE), None, "{what}, {size:?}");
            for (i, code) in ours.map.iter().enumerate() {
                let depth = ours.numbers[i][DEPTH];
                assert_eq!(depth.is_nan(), *code < 0, "{what}, {size:?}: pixel {i}");
                if *code >= 0 {
                    let own = f64::from(depth);
                    let depth = v.camera.depth_of(g.surfaces().receiver(i).expect("seen").0 + g.origin);
                    assert!((own - depth).abs() <= SINGLE * depth, "{what}: {own} {depth}");
                }
                codes.insert(*code);
            }
        }
    });
    assert!([-3, -2, -1, 0, 1, 2, 3].iter().all(|code| codes.contains(code)), "{codes:?}");
}

#[test]
fn the_same_bits_twice_and_from_a_renderer() {
    each(|what, v, p| {
        let g = gbuffer(v, [193, 70]);
        let one = image(v, &g, p).bits();
        assert_eq!(one, image(v, &g, p).bits(), "{what}");
        let single = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
        assert_eq!(one, single.install(|| image(v, &g, p)).bits(), "{what}: of one thread");
        let rendered = CpuRenderer::new().footprint(&v.scene, &v.camera, &v.light, p, MAP, [193, 70], &Progress::new());
        assert_eq!(one, Picture::of(&rendered.expect("a footprint")).bits(), "{what}: of the renderer");
    });
}

#[test]
fn the_map_is_the_one_that_the_mask_consults() {
    let renderer = CpuRenderer::new();
    each(|what, v, p| {
        let size = [160, 114];
        let settings = MaskSettings {
            resolution: [512, 512],
            size,
            bias: Bias::default(),
            filter: Filter::default(),
            blend: 0.0,
            stored: Stored::default(),
        };
        let mask = renderer.shadow_mask(&v.scene, &v.camera, &v.light, p, &settings, &Progress::new()).expect("a mask");
        let ours = image(v, &gbuffer(v, size), p);
        for (i, (k, consulted)) in ours.map.iter().zip(&mask.partition).enumerate() {
            assert_eq!((*k).max(ShadowMask::NO_MAP), *consulted, "{what}: pixel {i}");
            // What no map holds is lit, and what is averted dark.
            let light = match *k {
                Footprint::NO_MAP => Some(1.0),
                Footprint::AVERTED => Some(0.0),
                _ => None,
            };
            assert!(light.is_none_or(|x| mask.data[i] == x), "{what}: pixel {i}, {k} and {}", mask.data[i]);
            assert_eq!(*k == Footprint::NOTHING, mask.data[i].is_nan(), "{what}: pixel {i}");
        }
    });
}

#[test]
fn one_changed_pixel_is_seen() {
    let v = views().swap_remove(0);
    let p = by_body("lispsm").parameterize(&v.scene, &v.camera, &v.light, 512).expect("a map");
    let f = image(&v, &gbuffer(&v, [65, 40]), &p);
    let i = f.map.iter().rposition(|k| *k >= 0).expect("a texel");
    let nothing = f.map.iter().position(|k| *k < 0).expect("a pixel without one");
    assert_eq!(differing(&f, &f, 0.0), None);
    type Change = fn(&mut Picture, usize);
    let changes: [Change; 8] = [
        |f, i| f.numbers[i][MAJOR] *= 1.001,
        |f, i| f.numbers[i][PERSPECTIVE] *= 1.001,
        |f, i| f.numbers[i][PROJECTION] *= 1.001,
        |f, i| f.numbers[i][PERSPECTIVE_TS] *= 1.001,
        |f, i| f.numbers[i][PERSPECTIVE_TS + 1] *= 1.001,
        |f, i| f.numbers[i][2] += 0.001 * f.numbers[i][MAJOR],
        |f, i| f.numbers[i][MAJOR] = f32::NAN,
        |f, i| f.map[i] -= 1,
    ];
    for (k, change) in changes.iter().enumerate() {
        let mut other = f.clone();
        change(&mut other, i);
        assert_eq!(differing(&f, &other, 1e-4), Some(i), "change {k}");
        assert_eq!(differing(&other, &f, 1e-4), Some(i), "change {k}, the other way");
    }
    let mut other = f.clone();
    other.numbers[nothing][PERSPECTIVE] = 0.0;
    assert_eq!(differing(&f, &other, 1e-4), Some(nothing));
}
