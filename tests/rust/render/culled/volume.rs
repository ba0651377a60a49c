//! Casters outside of a map's volume: the map without them is the map with them, bit for bit.

use glam::DVec3;
use rayon::prelude::*;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Bias, Cull, Filter, MaskSettings, Renderer, Rule, Stored};
use shadowlab::{Error, Parameterization, Progress, Scene};

use super::setups::{among_blocks, casters, check_counts, maps_of};
use crate::support::cpu::one_map;
use crate::support::views::{View, by_hand, directional, directions, from_library, points, spots};

/// What maps store, each drawn by passes of its own.
const STORED: [&str; 4] = ["front", "back:format=unorm16", "second", "dual:spacing=linear"];
const SETTINGS: MaskSettings = MaskSettings {
    resolution: [128; 2],
    size: [64, 48],
    bias: Bias::NONE,
    filter: Filter::Nearest,
    blend: 0.0,
    stored: Stored::FRONT,
};

fn drawn(renderer: &dyn Renderer, scene: &Scene, p: &Parameterization, stored: Stored, cull: Cull) -> Vec<f32> {
    match renderer.maps_of(scene, p, [128; 2], stored, cull, &Progress::new()) {
        Ok(maps) => maps.data,
        // A map that has no linear depth, whatever is drawn into it.
        Err(Error::InvalidArgument { name, .. }) if name == "stored" => Vec::new(),
        Err(error) => panic!("{error}"),
    }
}

/// Fails where the map differs.
fn compare(scene: &Scene, p: &Parameterization, stored: &str, name: &str) {
    let (cpu, stored) = (CpuRenderer::new(), stored.parse::<Stored>().unwrap());
    let [culled, whole] = [Cull::Volume, Cull::None].map(|cull| drawn(&cpu, scene, p, stored, cull));
    assert_eq!(differing(&culled, &whole), 0, "{name}, {stored}");
}

fn differing(a: &[f32], b: &[f32]) -> usize {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|(a, b)| a.to_bits() != b.to_bits()).count()
}

#[test]
fn the_comparison_fails_on_one_texel() {
    assert_eq!(differing(&[0.5, 0.25], &[0.5, 0.25f32.next_up()]), 1);
    assert_eq!(differing(&[0.0], &[-0.0]), 1);
}

#[test]
fn maps_of_every_technique_and_library_scene_lose_nothing() {
    from_library().par_iter().for_each(|v| {
        for (i, (name, p)) in maps_of(v, 128).into_iter().enumerate() {
            compare(&v.scene, &p, STORED[i % STORED.len()], &name);
            compare(&v.scene, &p, STORED[0], &name);
        }
    });
}

#[test]
fn maps_of_awkward_lights_lose_nothing() {
    let cases = by_hand();
    cases.into_par_iter().for_each(|(name, scene, camera)| {
        let directions = directions(&camera).into_iter().map(|(name, d)| (name, directional(d)));
        let placed = spots(&scene, &camera).into_iter().chain(points(&scene, &camera));
        // Every third, so that all kinds come with each scene.
        for (i, (light_name, light)) in directions.chain(placed).enumerate() {
            if (i + name.len()) % 3 != 0 {
                continue;
            }
            let v = View { name: format!("{name}, {light_name}"), scene: scene.clone(), camera, light };
            for (k, (name, p)) in maps_of(&v, 64).into_iter().enumerate() {
                if (i + k) % 4 == 0 {
                    compare(&v.scene, &p, STORED[(i + k) / 4 % STORED.len()], &name);
                }
            }
        }
    });
}

#[test]
fn most_casters_out_of_view_are_left_out() {
    let v = among_blocks();
    for (name, p) in maps_of(&v, 128) {
        let of_maps = casters(&v, &p, Cull::Volume, &SETTINGS);
        assert_eq!(of_maps.len(), p.partitions.len());
        let whole = casters(&v, &p, Cull::None, &SETTINGS);
        for (casters, whole) in of_maps.iter().zip(&whole) {
            check_counts(&v.scene, casters, &name);
            check_counts(&v.scene, whole, &name);
            assert_eq!(whole.instances[Rule::Drawn as usize], v.scene.instances().len() as u64);
        }
        if name.contains("lispsm") {
            let fewest = of_maps.iter().map(|c| c.instances[Rule::Drawn as usize]).min().unwrap();
            assert!((1..400).contains(&fewest), "{name}: {fewest} of 701 drawn");
        }
    }
}

#[test]
fn a_pass_draws_what_the_counts_say() {
    // A scene of the instances that are drawn alone has the same map.
    let v = among_blocks();
    for (name, p) in maps_of(&v, 128).into_iter().filter(|(_, p)| p.partitions.len() == 1) {
        let casters = &casters(&v, &p, Cull::Volume, &SETTINGS)[0];
        let drawn_alone = (0..casters.rules.len()).filter(|i| casters.rules[*i] == Rule::Drawn);
        let alone: Vec<_> = drawn_alone.map(|i| v.scene.instances()[i]).collect();
        let alone = Scene::new(v.scene.meshes().to_vec(), alone).unwrap();
        let cpu = CpuRenderer::new();
        let [a, b] = [&v.scene, &alone].map(|scene| drawn(&cpu, scene, &p, Stored::FRONT, Cull::None));
        assert_eq!(differing(&a, &b), 0, "{name}");
    }
}

#[test]
fn a_map_of_nothing_is_empty_and_seen_takes_a_picture() {
    let v = among_blocks();
    let beside = one_map(glam::DMat4::from_translation(DVec3::splat(1e4)));
    let cpu = CpuRenderer::new();
    assert!(drawn(&cpu, &v.scene, &beside, Stored::FRONT, Cull::Volume).iter().all(|z| *z == 1.0));
    let error = cpu.maps_of(&v.scene, &beside, [8; 2], Stored::FRONT, Cull::Seen, &Progress::new()).unwrap_err();
    assert!(matches!(&error, Error::InvalidArgument { name, .. } if name == "cull"), "{error}");
    let error = cpu.casters(&v.scene, &beside, Cull::Seen, None, &SETTINGS, &Progress::new()).unwrap_err();
    assert!(matches!(&error, Error::InvalidArgument { name, .. } if name == "cull"), "{error}");
}
