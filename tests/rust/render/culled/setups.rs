//! Scenes of many instances, maps of every technique for them, and what becomes of their casters.

use glam::{DAffine3, DMat3, DVec3};
use shadowlab::image::GBuffer;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Casters, Cull, MaskSettings, Renderer, Rule};
use shadowlab::scene::Instance;
use shadowlab::techniques::{TECHNIQUES, technique_of};
use shadowlab::{Camera, Error, Light, Parameterization, Progress, Scene};

use crate::support::views::{Random, View, cube, directional, look, picture_of, samples_of, shaded_samples, square};

/// Techniques beside the defaults of all, by their texts.
const OTHERS: [&str; 6] = [
    "z_partition:count=3,overlap=0.3,inner=lispsm",
    "face_partition:inner=lispsm",
    "uniform:focus=none",
    "uniform:focus=frustum",
    "lispsm:fit=intersection,range=body",
    "z_partition:count=2,inner=rectilinear/log_psm",
];

/// The maps of every technique that takes the light, with their names.
pub fn maps_of(view: &View, resolution: u32) -> Vec<(String, Parameterization)> {
    let texts = TECHNIQUES.iter().map(|one| one.spec.name).chain(OTHERS);
    let (mut plain, mut shaded) = (None, None);
    let mut found = Vec::new();
    for text in texts {
        let technique = technique_of(text).expect(text);
        let samples = match technique.needs() {
            shadowlab::techniques::Needs::Nothing => None,
            shadowlab::techniques::Needs::Surfaces => {
                Some(&*plain.get_or_insert_with(|| samples_of(&view.scene, &view.camera)))
            }
            shadowlab::techniques::Needs::Shadows => Some(&*shaded.get_or_insert_with(|| {
                shaded_samples(&view.scene, &view.camera, &view.light, &picture_of(&view.scene, &view.camera))
            })),
        };
        match technique.parameterize_seen(&view.scene, &view.camera, &view.light, [resolution; 2], samples) {
            Ok(p) => found.push((format!("{}, {text}", view.name), p)),
            Err(Error::UnsupportedLight { .. } | Error::UnsuitedView { .. }) => {}
            Err(error) => panic!("{}, {text}: {error}", view.name),
        }
    }
    assert!(found.len() > 5, "{}", view.name);
    found
}

/// Blocks on a floor, upright or tilted, most of them out of view.
pub fn blocks(seed: u64, count: usize, half: f64) -> Scene {
    let mut random = Random(seed);
    let floor = DAffine3::from_scale(DVec3::new(half, 1.0, half));
    let mut instances = vec![Instance { mesh: 1, world_from_mesh: floor }];
    for i in 0..count {
        let size = DVec3::new(random.between(0.2, 1.0), random.between(0.5, 3.0), random.between(0.2, 1.0));
        let turn = DMat3::from_rotation_y(random.between(0.0, 6.0));
        let tilt = if i % 4 == 0 { DMat3::from_rotation_x(random.between(-0.5, 0.5)) } else { DMat3::IDENTITY };
        let mirror = DVec3::new(if i % 3 == 0 { -1.0 } else { 1.0 }, 1.0, 1.0);
        let at = DVec3::new(random.between(-half, half), size.y, random.between(-half, half));
        let linear = turn * tilt * DMat3::from_diagonal(size * mirror);
        instances.push(Instance { mesh: 0, world_from_mesh: DAffine3::from_mat3_translation(linear, at) });
    }
    Scene::new(vec![cube(), square()], instances).unwrap()
}

/// A view among blocks under a low sun.
pub fn among_blocks() -> View {
    let camera = look(DVec3::new(2.0, 3.0, 20.0), DVec3::new(0.0, 1.0, -5.0), 0.9, 0.1, 60.0);
    let light = directional(DVec3::new(-0.8, -0.5, -0.3));
    View { name: "blocks".into(), scene: blocks(5, 700, 60.0), camera, light }
}

pub fn gbuffer(scene: &Scene, camera: &Camera, size: [u32; 2]) -> GBuffer {
    CpuRenderer::new().gbuffer(scene, camera, size, &Progress::new()).unwrap()
}

/// What becomes of the casters of a view in each map of the cpu renderer.
pub fn casters(v: &View, p: &Parameterization, cull: Cull, settings: &MaskSettings) -> Vec<Casters> {
    let g = gbuffer(&v.scene, &v.camera, settings.size);
    let picture: Option<(_, &Camera, &Light)> = Some((g.surfaces(), &v.camera, &v.light));
    CpuRenderer::new().casters(&v.scene, p, cull, picture, settings, &Progress::new()).unwrap()
}

/// Fails unless counts are those of the rules, and nothing is lost.
pub fn check_counts(scene: &Scene, casters: &Casters, name: &str) {
    assert_eq!(casters.rules.len(), scene.instances().len(), "{name}");
    assert_eq!(casters.instances.iter().sum::<u64>(), scene.instances().len() as u64, "{name}");
    assert_eq!(casters.triangles.iter().sum::<u64>(), scene.triangle_count(), "{name}");
    for (_, rule) in Rule::NAMES {
        let of_rule = (0..casters.rules.len()).filter(|i| casters.rules[*i] == rule);
        let triangles: usize = of_rule.clone().map(|i| scene.mesh_of(i).triangles().len()).sum();
        let counts = (casters.instances[rule as usize], casters.triangles[rule as usize]);
        assert_eq!(counts, (of_rule.count() as u64, triangles as u64), "{name}, {rule:?}");
    }
}
