//! Random forests: no rule changes what it must not change, wherever the camera and the light are.

use glam::{DAffine3, DMat3, DVec3};
use proptest::prelude::*;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Cull, MaskSettings, Renderer, Stored};
use shadowlab::scene::Instance;
use shadowlab::techniques::technique_of;
use shadowlab::{Error, Mesh, Progress, Scene};

use crate::support::cpu::{FILTERS, filter};
use crate::support::views::{Random, View, directional, look, square};

const TECHNIQUES: [&str; 7] =
    ["lispsm", "uniform", "tsm", "log_psm", "uniform:focus=none", "z_partition:count=3,inner=lispsm", "plane_optimal"];
const STORED: [&str; 5] = ["front", "back", "second:format=unorm16", "dual", "front:format=f16"];

/// A crown on a trunk, open below, with slivers.
fn tree(random: &mut Random) -> Mesh {
    let (sides, tip) = (5 + random.below(4) as i64, random.between(2.0, 5.0));
    let mut vertices = vec![[0.0, tip, 0.0], [0.0, 0.0, 0.0]];
    for i in 0..sides {
        let angle = std::f64::consts::TAU * i as f64 / sides as f64;
        let reach = random.between(0.6, 1.4);
        vertices.push([reach * angle.cos(), random.between(0.5, 1.0), reach * angle.sin()]);
    }
    let around = |i: i64| 2 + (i + 1) % sides;
    let faces: Vec<[i64; 3]> = (0..sides).flat_map(|i| [[0, around(i), 2 + i], [1, 2 + i, around(i)]]).collect();
    Mesh::new(&vertices, &faces).unwrap()
}

fn forest(random: &mut Random, count: usize, half: f64, origin: DVec3) -> Scene {
    let meshes = vec![tree(random).into(), tree(random).into(), square()];
    let floor = DMat3::from_diagonal(DVec3::new(half, 1.0, half));
    let mut instances = vec![Instance { mesh: 2, world_from_mesh: DAffine3::from_mat3_translation(floor, origin) }];
    for _ in 0..count {
        let at = DVec3::new(random.between(-half, half), random.between(-0.2, 0.2), random.between(-half, half));
        let turn = DMat3::from_rotation_y(random.between(0.0, 6.3)) * DMat3::from_rotation_x(random.between(-0.1, 0.1));
        let linear = turn * DMat3::from_diagonal(DVec3::splat(random.between(0.5, 2.0)));
        let world_from_mesh = DAffine3::from_mat3_translation(linear, origin + at);
        instances.push(Instance { mesh: random.below(2) as u32, world_from_mesh });
    }
    Scene::new(meshes, instances).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn maps_and_masks_stay(seed in any::<u64>(), count in 30_usize..400, which in 0_usize..10_000, far in any::<bool>()) {
        let random = &mut Random(seed);
        let half = random.between(20.0, 90.0);
        let origin = if far { DVec3::new(4.1e6, 120.0, -2.3e6) } else { DVec3::ZERO };
        let scene = forest(random, count, half, origin);
        let inside = |random: &mut Random| DVec3::new(random.between(-half, half), random.between(0.5, 6.0), random.between(-half, half));
        let (eye, target) = (inside(random), inside(random));
        let camera = look(origin + eye, origin + target, random.between(0.4, 1.4), 0.1, random.between(10.0, 300.0));
        let down = DVec3::new(random.between(-1.0, 1.0), -random.between(0.05, 1.0), random.between(-1.0, 1.0));
        let v = View { name: String::new(), scene, camera, light: directional(down) };
        let (text, progress) = (TECHNIQUES[which % TECHNIQUES.len()], Progress::new());
        let technique = technique_of(text).unwrap();
        let made = technique.parameterize_seen(&v.scene, &v.camera, &v.light, [200; 2], Some(&v.samples()));
        // A random view may show nothing that faces the light.
        prop_assume!(!matches!(made, Err(Error::UnsuitedView { .. })));
        let p = made.unwrap();
        let settings = MaskSettings {
            resolution: [200, 200],
            size: [72, 54],
            bias: if which % 2 == 0 { Default::default() } else { shadowlab::render::Bias::NONE },
            filter: filter(FILTERS[which % FILTERS.len()]),
            blend: 0.0,
            stored: STORED[which % STORED.len()].parse::<Stored>().unwrap(),
        };
        let cpu = CpuRenderer::new();
        let map = |cull| cpu.maps_of(&v.scene, &p, settings.resolution, settings.stored, cull, &progress).unwrap().data;
        prop_assert!(map(Cull::Volume) == map(Cull::None), "{text}, {}", settings.stored);
        let mask = |cull| {
            let mask = cpu.mask_of(&v.scene, &v.camera, &v.light, &p, &settings, cull, &progress).unwrap();
            mask.data.iter().map(|x| x.to_bits()).collect::<Vec<_>>()
        };
        prop_assert!(mask(Cull::Seen) == mask(Cull::None), "{text}, {settings:?}");
    }
}
