//! Truth with alpha tests: closed forms, what a test must not change, fine maps, and pixels at the edges of holes.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};
use shadowlab::image::{GBuffer, TruthMask};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::scene::{AlphaTest, AlphaTestParts, DirectionalLight, Instance, PointLight, Wrap};
use shadowlab::trace::{Hit, Tracer};
use shadowlab::{Camera, Light, Mesh, Progress, Scene};

use crate::support::by_body::by_body;
use crate::support::cpu::Random;
use crate::support::foliage::{alpha_test, hole, leaf, texture, waves};

const SIZE: [u32; 2] = [240, 180];

fn place(meshes: Vec<Mesh>, maps: &[DAffine3]) -> Scene {
    let instances =
        (0..meshes.len() as u32).zip(maps).map(|(mesh, &world_from_mesh)| Instance { mesh, world_from_mesh });
    let instances = instances.collect();
    Scene::new(meshes.into_iter().map(Arc::new).collect(), instances).unwrap()
}

fn floor(half: f64) -> Mesh {
    leaf([-half, 0.0, -half], [[2.0 * half, 0.0, 0.0], [0.0, 0.0, 2.0 * half]], None, [1.0; 2])
}

/// A square over the floor at height 1, with a texture.
fn canopy(repeats: f32, texture: shadowlab::scene::AlphaTexture) -> Mesh {
    leaf([-1.0, 1.0, -1.0], [[2.0, 0.0, 0.0], [0.0, 0.0, 2.0]], Some(texture), [repeats; 2])
}

fn camera() -> Camera {
    Camera::look_at(DVec3::new(0.3, 6.0, 7.0), DVec3::ZERO, DVec3::Y, 0.7, 4.0 / 3.0, 0.5, 40.0).unwrap()
}

fn truth(scene: &Scene, camera: &Camera, light: &Light, size: [u32; 2]) -> TruthMask {
    Tracer::new(scene, &Progress::new()).unwrap().shadow_mask(camera, light, size, &Progress::new()).unwrap()
}

fn seen(scene: &Scene, camera: &Camera, size: [u32; 2]) -> GBuffer {
    CpuRenderer::new().gbuffer(scene, camera, size, &Progress::new()).unwrap()
}

#[test]
fn light_falls_through_a_round_hole() {
    let scene = place(vec![floor(6.0), canopy(1.0, hole(256, 0.3))], &[DAffine3::IDENTITY; 2]);
    let along = DVec3::new(0.4, -1.0, 0.2);
    let lights: [Light; 2] = [
        Light::Directional(DirectionalLight::new(along).unwrap()),
        Light::Point(PointLight::new(DVec3::new(0.5, 3.0, -0.4), 50.0).unwrap()),
    ];
    for light in lights {
        let (mask, g) = (truth(&scene, &camera(), &light, SIZE), seen(&scene, &camera(), SIZE));
        let (mut lit, mut undecided) = (0, 0);
        for (i, &answer) in mask.data.iter().enumerate().filter(|(i, _)| g.instance[*i] == 0) {
            let p = DVec3::from_array(g.position[i].map(f64::from)) + g.origin;
            let to_light = light.to_light(p);
            let through = p + to_light * ((1.0 - p.y) / to_light.y);
            let (x, z) = (through.x, through.z);
            let (from_rim, from_edge) = (DVec2::new(x, z).length() - 0.6, x.abs().max(z.abs()) - 1.0);
            undecided += usize::from(answer == TruthMask::UNDECIDED);
            // A quarter of a texel: levels are rounded to 1/255, and the rim is weighted between their centres.
            if from_rim.abs() < 0.002 || from_edge.abs() < 1e-4 {
                continue;
            }
            let expected = if from_edge < 0.0 && from_rim > 0.0 { TruthMask::SHADOW } else { TruthMask::LIT };
            assert_eq!(answer, expected, "{p} through {through}");
            lit += usize::from(from_rim < 0.0);
        }
        assert!(lit > 400 && undecided < 20, "{lit} {undecided}");
    }
}

/// Leaves with a test or without.
fn leaves(test: impl Fn(&[[f32; 2]]) -> Option<AlphaTest>) -> Mesh {
    let mut random = Random(9);
    let (mut vertices, mut uv) = (Vec::new(), Vec::new());
    for _ in 0..80 {
        let middle = random.vector(-1.0, 1.0) * DVec3::new(2.5, 0.6, 2.5) + DVec3::new(0.0, 1.2, 0.0);
        for _ in 0..3 {
            vertices.push((middle + 0.7 * random.vector(-1.0, 1.0)).to_array());
            uv.push([random.number(-2.0, 2.0) as f32, random.number(-2.0, 2.0) as f32]);
        }
    }
    let faces: Vec<[i64; 3]> = (0..80).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let test = test(&uv);
    Mesh::with_alpha_test(&vertices, &faces, test).unwrap()
}

/// Upright, mirrored, and pressed flat: the last has no inverse.
fn places() -> [DAffine3; 4] {
    let flat = DMat3::from_diagonal(DVec3::new(0.6, 0.0, 0.6));
    [
        DAffine3::IDENTITY,
        DAffine3::IDENTITY,
        DAffine3::from_translation(DVec3::new(2.0, 0.5, 0.0)) * DAffine3::from_scale(DVec3::new(-0.5, 0.7, 0.4)),
        DAffine3::from_mat3_translation(DMat3::from_rotation_x(0.4) * flat, DVec3::new(-1.0, 1.4, 0.5)),
    ]
}

fn forest(test: impl Fn(&[[f32; 2]]) -> Option<AlphaTest>) -> Scene {
    let meshes = [Arc::new(floor(6.0)), Arc::new(leaves(test))];
    let instances = places().into_iter().enumerate();
    let instances =
        instances.map(|(i, world_from_mesh)| Instance { mesh: u32::from(i > 0), world_from_mesh }).collect();
    Scene::new(meshes.to_vec(), instances).unwrap()
}

#[test]
fn a_test_that_keeps_all_changes_no_answer_and_one_that_keeps_nothing_leaves_nothing() {
    let plain = forest(|_| None);
    let kept = forest(|uv| Some(alpha_test(Some(texture([4, 1], |_, _| 128)), uv, Wrap::Repeat)));
    let none = forest(|uv| Some(alpha_test(Some(texture([4, 1], |_, _| 127)), uv, Wrap::Mirror)));
    let absent = Scene::from_mesh(floor(6.0)).unwrap();
    let light = Light::Directional(DirectionalLight::new(DVec3::new(0.3, -1.0, 0.5)).unwrap());
    let (camera, progress) = (camera(), Progress::new());
    assert_eq!(truth(&plain, &camera, &light, SIZE), truth(&kept, &camera, &light, SIZE));
    // The bounds of what is not there still count for what is decided, and the origin rounds differently.
    let (a, b) = (truth(&none, &camera, &light, SIZE), truth(&absent, &camera, &light, SIZE));
    let differ = a.data.iter().zip(&b.data).filter(|(a, b)| a != b).count();
    assert!(differ < 5, "{differ}");
    let mut random = Random(2);
    let origins: Vec<[f64; 3]> = (0..4000).map(|_| (random.vector(-3.0, 3.0).with_y(5.0)).to_array()).collect();
    let ways: Vec<[f64; 3]> = (0..4000).map(|_| (random.vector(-0.3, 0.3) - DVec3::Y).to_array()).collect();
    let met = |scene: &Scene| -> (Vec<Hit>, Vec<bool>) {
        let tracer = Tracer::new(scene, &progress).unwrap();
        let hits = tracer.first_hit(&origins, &ways, &progress).unwrap();
        (hits, tracer.occluded(&origins, &ways, &vec![3.5; origins.len()], &progress).unwrap())
    };
    assert_eq!(met(&plain), met(&kept));
    let (hits, blocked) = met(&none);
    assert!(hits.iter().all(|hit| hit.instance <= 0) && blocked.iter().all(|b| !b));
}

#[test]
fn rays_meet_what_exists_alone_and_together() {
    let scene = forest(|uv| Some(alpha_test(Some(waves(16)), uv, Wrap::Repeat)));
    let (tracer, progress) = (Tracer::new(&scene, &Progress::new()).unwrap(), Progress::new());
    let mut random = Random(4);
    let origins: Vec<[f64; 3]> = (0..6000).map(|_| (random.vector(-3.0, 3.0).with_y(5.0)).to_array()).collect();
    let ways: Vec<[f64; 3]> = (0..6000).map(|_| (random.vector(-0.3, 0.3) - DVec3::Y).to_array()).collect();
    let hits = tracer.first_hit(&origins, &ways, &progress).unwrap();
    let mut alone = tracer.one_by_one();
    let mut kept = 0;
    for ((o, d), hit) in origins.iter().zip(&ways).zip(&hits) {
        let (o, d) = (DVec3::from_array(*o), DVec3::from_array(*d));
        assert_eq!(alone.first_hit(o, d, f64::INFINITY), *hit);
        // All that the ray meets on the plain mesh, in order: the first that exists.
        let mut best = Hit::NONE;
        for i in 0..scene.instances().len() {
            let (mesh, map) = (scene.mesh_of(i), scene.world_from_local(i));
            for (t, triangle) in mesh.triangles().iter().enumerate() {
                let [a, b, c] = triangle.map(|v| map.transform_point3(mesh.positions_local()[v as usize].as_dvec3()));
                let (e1, e2, s) = (b - a, c - a, o - a);
                let (p, q) = (d.cross(e2), s.cross(e1));
                let inverse = 1.0 / e1.dot(p);
                let (u, v, at) = (s.dot(p) * inverse, d.dot(q) * inverse, e2.dot(q) * inverse);
                if !(u >= 0.0 && v >= 0.0 && u + v <= 1.0 && at > 0.0 && at < best.t) {
                    continue;
                }
                let exists = mesh.alpha_test().is_none_or(|test| {
                    let [a, b, c] = test.corners(*triangle);
                    test.exists(a * (1.0 - u - v) + b * u + c * v)
                });
                if exists {
                    best = Hit { t: at, triangle: t as i32, instance: i as i32 };
                }
            }
        }
        // Edges and levels at the cutoff aside.
        if best.instance == hit.instance && best.triangle == hit.triangle {
            assert!((best.t - hit.t).abs() < 1e-6 || best.t == hit.t, "{best:?} {hit:?}");
            kept += 1;
        }
    }
    assert!(kept > 5990, "{kept}");
}

#[test]
fn a_fine_map_and_the_truth_agree() {
    let scene = forest(|uv| Some(alpha_test(Some(waves(16)), uv, Wrap::Mirror)));
    let light = Light::Directional(DirectionalLight::new(DVec3::new(0.3, -1.0, 0.5)).unwrap());
    let p = by_body("uniform").parameterize(&scene, &camera(), &light, 4096).unwrap();
    let settings = MaskSettings {
        resolution: [4096; 2],
        size: SIZE,
        bias: Bias::default(),
        filter: Filter::Nearest,
        blend: 0.0,
        stored: Stored::default(),
    };
    let cpu = CpuRenderer::new();
    let mask = cpu.shadow_mask(&scene, &camera(), &light, &p, &settings, &Progress::new()).unwrap();
    let truth = truth(&scene, &camera(), &light, SIZE);
    let (mut wrong, mut compared, mut undecided, mut other) = (0, 0, 0, 0);
    for (&mask, &truth) in mask.data.iter().zip(&truth.data) {
        match truth {
            TruthMask::UNDECIDED => undecided += 1,
            TruthMask::NOTHING => other += usize::from(!mask.is_nan()),
            _ if mask.is_nan() => other += 1,
            _ => {
                compared += 1;
                wrong += usize::from((mask > 0.5) != (truth == TruthMask::LIT));
            }
        }
    }
    println!("{wrong} of {compared} wrong, {undecided} undecided, {other} others");
    // A texel of the map is 1/300 of the scene, and shadows have edges at all holes.
    assert!(wrong < compared / 50 && undecided < compared / 200 && other < 20, "{wrong} {undecided} {other}");
}

#[test]
fn what_lies_at_the_cutoff_is_undecided_only_where_it_changes() {
    // Levels rise along x from 0 to 255 over the canopy: the edge of its shadow is a line.
    let ramp = |levels: [u8; 2], cutoff: f64| {
        let test = alpha_test(
            Some(texture([2, 1], |x, _| levels[x as usize])),
            &[[0.25, 0.5], [0.75, 0.5], [0.75, 0.5], [0.25, 0.5]],
            Wrap::Clamp,
        );
        let test = AlphaTest::new(AlphaTestParts { cutoff, ..test.parts().clone() }).unwrap();
        let vertices = [[-1.0, 1.0, -1.0], [1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [-1.0, 1.0, 1.0]];
        Mesh::with_alpha_test(&vertices, &[[0, 1, 2], [0, 2, 3]], Some(test)).unwrap()
    };
    // From the side, so that the floor is seen below the canopy, and pixels lie on the edge itself: x = 0 at odd sizes.
    let camera = Camera::look_at(DVec3::new(0.0, 0.5, 6.0), DVec3::ZERO, DVec3::Y, 0.3, 1.0, 0.5, 20.0).unwrap();
    let light = Light::Directional(DirectionalLight::new(DVec3::NEG_Y).unwrap());
    let counts = |mesh: Mesh| {
        let scene = place(vec![floor(6.0), mesh], &[DAffine3::IDENTITY; 2]);
        let (mask, g) = (truth(&scene, &camera, &light, [101, 101]), seen(&scene, &camera, [101, 101]));
        let mut found = [0; 3];
        for (&answer, &instance) in mask.data.iter().zip(&g.instance) {
            if instance == 0 && (-1..=1).contains(&answer) {
                found[(answer + 1) as usize] += 1;
            }
        }
        found
    };
    // The middle column of pixels looks at the cutoff exactly.
    let [undecided, shadow, lit] = counts(ramp([0, 255], 0.5));
    assert!(undecided > 5 && undecided <= 101 && shadow > 300 && lit > 500, "{undecided} {shadow} {lit}");
    // All of it at the cutoff exists: nothing is undecided but at its outline.
    let [undecided, shadow, _] = counts(ramp([128, 128], 128.0 / 255.0));
    assert!(undecided < 5 && shadow > 800, "{undecided} {shadow}");
}
