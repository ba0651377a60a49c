//! Scenes whose instances move: a hierarchy that was taken along answers as one that was built for them, bit for bit.

use glam::{DAffine3, DMat3, DVec3};
use shadowlab::image::{Surfaces, TruthMask};
use shadowlab::render::Renderer;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::scene::{PointLight, library};
use shadowlab::trace::{Tracer, moved_surfaces};
use shadowlab::{Camera, Error, Light, Progress, Scene};

use crate::support::views::Random;

const SIZE: [u32; 2] = [96, 72];
/// Pixels whose truth at the drawn surface may differ from that of the ray through them: at silhouettes, where renderer and
/// ray may see different triangles.
const MOST_AT_SILHOUETTES: f64 = 2e-3;

fn built(scene: &Scene) -> Tracer {
    Tracer::new(scene, &Progress::new()).unwrap()
}

/// Some instances of a scene turned, pushed, scaled, mirrored or flattened; all of them where `share` is 1.
fn shaken(scene: &Scene, share: f64, random: &mut Random) -> Scene {
    let reach = scene.bounds().extent().max_element();
    let moved: Vec<usize> = (0..scene.instances().len()).filter(|_| random.between(0.0, 1.0) < share).collect();
    let map = |&i: &usize| {
        let turn =
            DMat3::from_rotation_y(random.between(-3.0, 3.0)) * DMat3::from_rotation_x(random.between(-0.3, 0.3));
        let size = [0.7, 1.0, -1.0, 0.0][if random.below(20) == 0 { random.below(4) } else { 1 }];
        let way = DVec3::new(random.between(-1.0, 1.0), random.between(0.0, 0.2), random.between(-1.0, 1.0));
        let own = scene.instances()[i].world_from_mesh;
        let about = DAffine3::from_translation(own.translation + 0.05 * reach * way);
        let linear = turn * DMat3::from_diagonal(DVec3::new(1.0, size, 1.0)) * own.matrix3;
        about * DAffine3::from_mat3(linear)
    };
    let maps: Vec<DAffine3> = moved.iter().map(map).collect();
    scene.with_transforms(&moved, &maps, &Progress::new()).unwrap()
}

fn rays(scene: &Scene, count: usize, random: &mut Random) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
    let bounds = *scene.bounds();
    let mut point = || {
        let t = DVec3::new(random.between(-0.2, 1.2), random.between(-0.2, 1.5), random.between(-0.2, 1.2));
        bounds.min + t * bounds.extent()
    };
    (0..count).map(|_| (point(), point())).map(|(from, to)| (from.to_array(), (to - from).to_array())).unzip()
}

fn same_answers(a: &Tracer, b: &Tracer, scene: &Scene, camera: &Camera, lights: &[Light], random: &mut Random) {
    let progress = Progress::new();
    for light in lights {
        let mask = |t: &Tracer| t.shadow_mask(camera, light, SIZE, &progress).unwrap();
        assert_eq!(mask(a), mask(b));
    }
    let (origins, directions) = rays(scene, 2000, random);
    let limits = vec![1.0; origins.len()];
    assert_eq!(
        a.first_hit(&origins, &directions, &progress).unwrap(),
        b.first_hit(&origins, &directions, &progress).unwrap()
    );
    assert_eq!(
        a.occluded(&origins, &directions, &limits, &progress).unwrap(),
        b.occluded(&origins, &directions, &limits, &progress).unwrap()
    );
}

#[test]
fn answers_are_those_of_a_hierarchy_built_anew() {
    let mut random = Random(7);
    for (name, params) in [("forest", vec![("trees".to_string(), 300.0)]), ("robots", vec![])] {
        let made = library::build(name, 1, &params).unwrap();
        let above = made.scene.bounds().center() + DVec3::Y * made.scene.bounds().extent().y;
        let lights = [made.light, Light::Point(PointLight::new(above, 1e3).unwrap())];
        let (mut scene, mut tracer) = (made.scene.clone(), built(&made.scene));
        for step in 0..12 {
            scene = shaken(&scene, [0.02, 0.2, 1.0][step % 3], &mut random);
            tracer = tracer.moved(&scene, &Progress::new()).unwrap();
            same_answers(&tracer, &built(&scene), &scene, &made.camera, &lights, &mut random);
        }
    }
}

#[test]
fn any_scene_may_follow_any_other() {
    let mut random = Random(3);
    let scenes = ["robots", "forest", "statues", "ceiling"].map(|name| library::build(name, 1, &[]));
    let scenes: Vec<_> = scenes.into_iter().flatten().collect();
    assert!(scenes.len() >= 3);
    for pair in scenes.windows(2) {
        let after = built(&pair[0].scene).moved(&pair[1].scene, &Progress::new()).unwrap();
        let (scene, lights) = (&pair[1].scene, [pair[1].light]);
        same_answers(&after, &built(scene), scene, &pair[1].camera, &lights, &mut random);
    }
}

#[test]
fn a_step_and_its_return_change_nothing() {
    let made = library::build("robots", 1, &[]).unwrap();
    let mask = |t: &Tracer| t.shadow_mask(&made.camera, &made.light, SIZE, &Progress::new()).unwrap();
    let tracer = built(&made.scene);
    let (first, places) = (mask(&tracer), made.scene.instances());
    let all: Vec<usize> = (0..places.len()).collect();
    let maps: Vec<DAffine3> = places.iter().map(|i| i.world_from_mesh).collect();
    let away: Vec<DAffine3> = maps.iter().map(|m| DAffine3::from_rotation_y(0.4) * *m).collect();
    let moved = made.scene.with_transforms(&all, &away, &Progress::new()).unwrap();
    let back = moved.with_transforms(&all, &maps, &Progress::new()).unwrap();
    let there = tracer.moved(&moved, &Progress::new()).unwrap();
    assert_ne!(mask(&there), first);
    assert_eq!(mask(&there.moved(&back, &Progress::new()).unwrap()), first);
}

#[test]
fn truth_at_drawn_surfaces_is_that_of_their_pixels() {
    for name in ["robots", "forest", "ceiling"] {
        let made = library::build(name, 1, &[]).unwrap();
        let tracer = built(&made.scene);
        let drawn = CpuRenderer::new().gbuffer(&made.scene, &made.camera, SIZE, &Progress::new()).unwrap();
        let at = tracer.shadows_at(&drawn.surfaces(), &made.light, &Progress::new()).unwrap();
        let through = tracer.shadow_mask(&made.camera, &made.light, SIZE, &Progress::new()).unwrap();
        let pairs = at.data.iter().zip(&through.data);
        let both: Vec<_> = pairs.filter(|(a, b)| TruthMask::is_decided(**a) && TruthMask::is_decided(**b)).collect();
        let differ = both.iter().filter(|(a, b)| a != b).count();
        assert!(both.len() > 1500 && differ as f64 <= MOST_AT_SILHOUETTES * both.len() as f64, "{name}: {differ}");
        let lit = both.iter().filter(|(a, _)| **a == TruthMask::LIT).count();
        assert!(lit > 100 && lit + 100 < both.len(), "{name}: {lit} of {} lit", both.len());
    }
}

#[test]
fn surface_points_go_with_their_instances() {
    let made = library::build("robots", 1, &[]).unwrap();
    let (scene, camera) = (&made.scene, &made.camera);
    let drawn = CpuRenderer::new().gbuffer(scene, camera, SIZE, &Progress::new()).unwrap();
    let seen = |i: usize| drawn.instance.iter().filter(|&&n| n == i as i32).count();
    let most_seen = (0..scene.instances().len()).filter(|&i| i > 0).max_by_key(|&i| seen(i)).unwrap();
    assert!(seen(most_seen) > 20);
    let moved_by = |map: DAffine3| {
        let place = map * scene.instances()[most_seen].world_from_mesh;
        let after = scene.with_transforms(&[most_seen], &[place], &Progress::new()).unwrap();
        moved_surfaces(&drawn.surfaces(), &drawn.depth, camera, [scene, &after], &Progress::new()).unwrap()
    };
    assert_eq!(moved_by(DAffine3::IDENTITY), drawn);
    let mirrored = DMat3::from_diagonal(DVec3::new(-1.0, 1.2, 1.0)) * DMat3::from_rotation_x(0.2);
    let map = DAffine3 { matrix3: mirrored, translation: DVec3::new(0.3, 0.1, -0.2) };
    let moved = moved_by(map);
    let reach = scene.bounds().extent().max_element();
    for i in 0..drawn.triangle.len() {
        if drawn.instance[i] != most_seen as i32 {
            assert_eq!(
                (moved.position[i], moved.normal[i], moved.depth[i]),
                (drawn.position[i], drawn.normal[i], drawn.depth[i])
            );
            continue;
        }
        let (before, after) = (drawn.surfaces().receiver(i).unwrap(), moved.surfaces().receiver(i).unwrap());
        let expected = map.transform_point3(drawn.origin + before.0) - drawn.origin;
        assert!((expected - after.0).length() < 4.0 * f64::from(f32::EPSILON) * reach);
        let normal = (mirrored.inverse().transpose() * before.1).normalize();
        assert!((normal - after.1).length() < 8.0 * f64::from(f32::EPSILON));
        let clip = camera.clip_from_world() * (drawn.origin + expected).extend(1.0);
        assert!((clip.z / clip.w - f64::from(moved.depth[i])).abs() < 1e-6);
    }
    // Nothing is known of points on what was flat; what becomes flat keeps its points.
    let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    let place = flat * scene.instances()[most_seen].world_from_mesh;
    let flattened = scene.with_transforms(&[most_seen], &[place], &Progress::new()).unwrap();
    let back = moved_surfaces(&drawn.surfaces(), &drawn.depth, camera, [&flattened, scene], &Progress::new()).unwrap();
    let left_out = (0..drawn.triangle.len()).filter(|&i| drawn.triangle[i] >= 0 && back.triangle[i] < 0).count();
    assert_eq!(left_out, seen(most_seen));
    assert!(moved_by(flat).position.iter().flatten().all(|x| x.is_finite()));
}

#[test]
fn surfaces_of_other_scenes_are_refused() {
    let [robots, forest] = ["robots", "forest"].map(|name| library::build(name, 1, &[]).unwrap());
    let drawn = CpuRenderer::new().gbuffer(&robots.scene, &robots.camera, SIZE, &Progress::new()).unwrap();
    let name_of = |error: Error| match error {
        Error::InvalidArgument { name, .. } => name.into_owned(),
        other => panic!("{other}"),
    };
    let scenes = [&robots.scene, &forest.scene];
    let error = moved_surfaces(&drawn.surfaces(), &drawn.depth, &robots.camera, scenes, &Progress::new()).unwrap_err();
    assert_eq!(name_of(error), "after");
    let tracer = built(&robots.scene);
    for (triangle, instance) in [(0, 1 << 20), (0, -1), (i32::MAX, 0)] {
        let (mut triangles, mut instances) = (drawn.triangle.clone(), drawn.instance.clone());
        (triangles[5], instances[5]) = (triangle, instance);
        let surfaces = Surfaces { triangle: &triangles, instance: &instances, ..drawn.surfaces() };
        let error = tracer.shadows_at(&surfaces, &robots.light, &Progress::new()).unwrap_err();
        assert_eq!(name_of(error), "gbuffer");
    }
}
