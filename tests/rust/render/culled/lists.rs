//! Maps of a list: each is the map drawn alone, bit for bit, whatever was drawn before it into the same memory.

use glam::DVec3;
use rayon::prelude::*;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Cull, Renderer, Stored};
use shadowlab::{Error, Mesh, Parameterization, Progress, Scene};

use super::setups::maps_of;
use crate::support::views::{View, directional, from_library, look};

/// What maps store, each drawn by passes of its own.
const STORED: [&str; 3] = ["front", "dual:format=unorm16", "midpoint"];
const RESOLUTION: [u32; 2] = [128; 2];

/// 180,000 triangles in one mesh of hills, which hide each other from a low sun: many rounds of a small map.
fn hills() -> View {
    const N: usize = 300;
    let vertices: Vec<[f64; 3]> = (0..(N + 1) * (N + 1))
        .map(|i| {
            let (x, z) = ((i % (N + 1)) as f64 / 10.0 - 15.0, (i / (N + 1)) as f64 / 10.0 - 15.0);
            [x, 1.5 * (0.9 * x).sin() * (0.8 * z).cos() + 0.2 * (7.0 * x + 5.0 * z).sin(), z]
        })
        .collect();
    let corner = |q: usize| (q / N * (N + 1) + q % N) as i64;
    let pair = |q: usize| [[0, N as i64 + 1, 1], [1, N as i64 + 1, N as i64 + 2]].map(|t| t.map(|i| corner(q) + i));
    let mesh = Mesh::new(&vertices, &(0..N * N).flat_map(pair).collect::<Vec<_>>()).unwrap();
    let camera = look(DVec3::new(0.0, 4.0, 16.0), DVec3::ZERO, 0.9, 0.1, 40.0);
    let light = directional(DVec3::new(-0.9, -0.4, -0.3));
    View { name: "hills".into(), scene: Scene::from_mesh(mesh).unwrap(), camera, light }
}

fn drawn(cpu: &CpuRenderer, scene: &Scene, p: &Parameterization, stored: Stored, cull: Cull) -> Option<Vec<u32>> {
    match cpu.maps_of(scene, p, RESOLUTION, stored, cull, &Progress::new()) {
        Ok(maps) => Some(maps.data.into_iter().map(f32::to_bits).collect()),
        // A map that has no linear depth, whatever is drawn into it.
        Err(Error::InvalidArgument { name, .. }) if name == "stored" => None,
        Err(error) => panic!("{error}"),
    }
}

/// How many lists have been compared.
fn compare(v: &View) -> usize {
    let lists = maps_of(v, RESOLUTION[0]).into_iter().filter(|(_, p)| p.partitions.len() > 1);
    let mut compared = 0;
    for (i, (name, p)) in lists.enumerate() {
        let stored = STORED[i % STORED.len()].parse::<Stored>().unwrap();
        for cull in [Cull::Volume, Cull::None] {
            let Some(list) = drawn(&CpuRenderer::new(), &v.scene, &p, stored, cull) else { continue };
            let texels = list.len() / p.partitions.len();
            for (k, (map, partition)) in list.chunks(texels).zip(&p.partitions).enumerate() {
                let one = Parameterization::of_partitions(vec![partition.clone()], RESOLUTION);
                let alone = drawn(&CpuRenderer::new(), &v.scene, &one, stored, cull).unwrap();
                assert!(map == alone, "{name}, {stored}, {cull:?}: map {k}");
            }
            compared += 1;
        }
    }
    compared
}

#[test]
fn maps_of_a_list_are_those_drawn_alone() {
    let mut views = from_library();
    views.push(hills());
    let compared: usize = views.par_iter().map(compare).sum();
    assert!(compared > 4 * views.len(), "{compared} lists");
}
