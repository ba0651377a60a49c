//! Several maps: each pixel asks the one that holds it, and the mask tells which.

pub mod maps;
pub mod seams;

use glam::DVec3;
use rayon::prelude::*;
use shadowlab::image::{GBuffer, ShadowMask};
use shadowlab::parameterization::{Parameterization, Partition};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::scene::library;
use shadowlab::{Camera, Error, Light, Progress, Scene};

use crate::support::by_body::by_body;

use maps::{alone, nowhere, repeated, views};

const SIZE: [u32; 2] = [240, 160];
const SETTINGS: MaskSettings = MaskSettings {
    resolution: [512; 2],
    size: SIZE,
    bias: Bias::NONE,
    filter: Filter::Bilinear,
    blend: 0.0,
    stored: Stored::FRONT,
};

fn gbuffer(scene: &Scene, camera: &Camera) -> GBuffer {
    CpuRenderer::new().gbuffer(scene, camera, SIZE, &Progress::new()).unwrap()
}

fn mask(scene: &Scene, camera: &Camera, light: &Light, p: &Parameterization) -> ShadowMask {
    CpuRenderer::new().shadow_mask(scene, camera, light, p, &SETTINGS, &Progress::new()).unwrap()
}

#[test]
fn each_pixel_asks_the_map_that_holds_it() {
    views().par_iter().for_each(|v| {
        let (g, m) = (gbuffer(&v.scene, &v.camera), mask(&v.scene, &v.camera, &v.light, &v.p));
        let mut asked = vec![0; v.p.partitions.len()];
        for i in 0..g.depth.len() {
            let facing =
                g.surfaces().receiver(i).map(|(p, n)| (p + g.origin, n)).filter(|(p, n)| v.light.illuminates(*p, *n));
            let expected = facing.and_then(|(p, _)| v.p.choose(p, v.camera.depth_of(p)));
            assert_eq!(m.partition[i], expected.map_or(ShadowMask::NO_MAP, |k| k as i16), "{}, pixel {i}", v.name);
            match expected {
                Some(k) => asked[k] += 1,
                None if facing.is_some() => assert_eq!(m.data[i], 1.0, "{}: no map holds it", v.name),
                None => assert!(m.data[i] == 0.0 || g.triangle[i] < 0 && m.data[i].is_nan(), "{}", v.name),
            }
        }
        println!("{}: {asked:?} pixels ask each map", v.name);
        assert!(asked.iter().filter(|&&n| n > 100).count() >= 2, "{}: {asked:?}", v.name);
        for (k, _) in asked.iter().enumerate().filter(|(_, n)| **n > 0) {
            let single = mask(&v.scene, &v.camera, &v.light, &alone(&v.p, k));
            let mine = (0..m.data.len()).filter(|&i| m.partition[i] == k as i16);
            assert!(mine.into_iter().all(|i| m.data[i] == single.data[i]), "{}: not as map {k} alone", v.name);
        }
    });
}

#[test]
fn maps_that_are_the_same_give_the_same_mask() {
    let s = library::build("robots", 1, &[]).unwrap();
    let p = by_body("lispsm");
    let p = p.parameterize(&s.scene, &s.camera, &s.light, 512).unwrap();
    let one = mask(&s.scene, &s.camera, &s.light, &p);
    assert!(one.partition.iter().all(|k| [-1, 0].contains(k)) && one.partition.contains(&0));
    for count in [2, 24] {
        let many = mask(&s.scene, &s.camera, &s.light, &repeated(&p, &s.camera, count));
        let bits = |m: &ShadowMask| m.data.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&one), bits(&many), "{count}");
        let highest = many.partition.iter().max().copied();
        assert!(highest > Some(count as i16 / 4) && highest < Some(count as i16), "{highest:?}");
        // Farther pixels ask later maps.
        let g = gbuffer(&s.scene, &s.camera);
        let asking = (0..g.depth.len()).filter(|&i| many.partition[i] >= 0);
        let mut by_depth: Vec<(f32, i16)> = asking.map(|i| (g.depth[i], many.partition[i])).collect();
        by_depth.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        assert!(by_depth.is_sorted_by_key(|a| a.1), "{count}");
    }
}

#[test]
fn where_no_map_holds_it_a_pixel_is_lit_and_says_so() {
    let s = library::build("robots", 1, &[]).unwrap();
    let p = Parameterization::of_partitions(vec![Partition::of_matrix(nowhere()); 3], [512; 2]);
    let m = mask(&s.scene, &s.camera, &s.light, &p);
    assert!(m.partition.iter().all(|&k| k == ShadowMask::NO_MAP));
    assert!(m.data.iter().filter(|&&x| x == 1.0).count() > 1000);
    // What faces away is dark all the same.
    assert!(m.data.contains(&0.0));
}

#[test]
fn maps_that_nobody_asks_may_be_wrong_but_not_infinite() {
    let s = library::build("robots", 1, &[]).unwrap();
    let p = by_body("uniform");
    let p = p.parameterize(&s.scene, &s.camera, &s.light, 512).unwrap();
    let with = |matrix| Parameterization {
        partitions: vec![p.partitions[0].clone(), Partition::of_matrix(matrix)],
        ..p.clone()
    };
    assert_eq!(
        mask(&s.scene, &s.camera, &s.light, &p).data.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
        mask(&s.scene, &s.camera, &s.light, &with(nowhere())).data.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
    );
    let broken = with(glam::DMat4::from_scale(DVec3::splat(f64::NAN)));
    let r = CpuRenderer::new().shadow_mask(&s.scene, &s.camera, &s.light, &broken, &SETTINGS, &Progress::new());
    assert!(matches!(r, Err(Error::InvalidArgument { .. })), "{r:?}");
}

#[test]
fn more_maps_than_a_mask_can_number_are_refused() {
    let s = library::build("robots", 1, &[]).unwrap();
    let p = Parameterization::of_partitions(vec![Partition::of_matrix(nowhere()); 1 << 15], [16; 2]);
    let r = CpuRenderer::new().shadow_mask(&s.scene, &s.camera, &s.light, &p, &SETTINGS, &Progress::new());
    assert!(r.unwrap_err().to_string().contains("32767"));
}

#[test]
fn seams_are_no_worse_than_elsewhere() {
    seams::assert_seams_hold(&CpuRenderer::new());
}

#[test]
fn the_check_sees_a_gap_and_a_stranger_at_a_seam() {
    let view = views().into_iter().find(|v| v.name == "robots, two halves").unwrap();
    let truth = seams::truth(&view);
    let renderer = CpuRenderer::new();
    let check = |p: Parameterization| {
        let (scene, whole) = (view.scene.clone(), view.whole.clone());
        let v = maps::View { p, name: String::new(), scene, whole, ..view };
        std::panic::catch_unwind(|| seams::Found::new(&renderer, &v, &truth).assert_small(""))
    };
    assert!(check(view.p.clone()).is_ok());
    let plane = view.p.partitions[0].region.functionals()[0];
    assert!(check(maps::halves_apart(&view.p, plane, 0.05)).is_err(), "a gap");
    // A map between the two that shows nothing: a strip without shadows.
    let mut p = maps::halves_apart(&view.p, plane, 0.05);
    p.partitions.push(Partition::of_matrix(glam::DMat4::from_scale(DVec3::new(1e-9, 1e-9, 0.0))));
    assert!(check(p).is_err(), "a stranger");
}
