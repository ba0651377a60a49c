//! The six faces of a point light, under every technique that serves it.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};
use shadowlab::image::TruthMask;
use shadowlab::note::Kind;
use shadowlab::parameterization::Selection;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::scene::{Instance, Light, PointLight, SpotLight};
use shadowlab::trace::Tracer;
use shadowlab::{Camera, Mesh, Progress, Scene};

use super::z_partition::maps;
use crate::support::by_body::by_body;
use crate::support::views::{Random, cube, look, placed, samples_of, square};

/// A closed room with columns in it, seen from a corner: walls one by one, so that a light in it is in no mesh's box, or as
/// one mesh.
fn room(one_by_one: bool) -> (Scene, Camera) {
    let v = DVec3::new;
    let scale = |x, y, z| DMat3::from_diagonal(v(x, y, z));
    let quarter = std::f64::consts::FRAC_PI_2;
    let middle = v(0.0, 3.0, 0.0);
    let mut parts = if one_by_one { Vec::new() } else { vec![(cube(), scale(6.0, 3.0, 5.0), middle)] };
    for side in if one_by_one { &[-1.0, 1.0][..] } else { &[] } {
        let (upright, across) = (DMat3::from_rotation_z(quarter), DMat3::from_rotation_x(quarter));
        parts.push((square(), scale(6.0, 1.0, 5.0), middle + DVec3::Y * (side * 3.0)));
        parts.push((square(), upright * scale(3.0, 1.0, 5.0), middle + DVec3::X * (side * 6.0)));
        parts.push((square(), across * scale(6.0, 1.0, 3.0), middle + DVec3::Z * (side * 5.0)));
    }
    // Some of them on the diagonals, where two faces of the light meet.
    for (x, z) in [(2.5, 2.5), (-2.0, -2.0), (2.2, -2.2), (-3.0, 1.0), (0.5, -3.0), (-1.8, 3.1)] {
        parts.push((cube(), DMat3::from_rotation_y(x) * scale(0.25, 1.0, 0.35), v(x, 1.0, z)));
    }
    parts.push((cube(), DMat3::from_rotation_x(0.7) * scale(0.5, 0.5, 0.5), v(-1.0, 4.6, -1.2)));
    (placed(&parts), look(v(5.5, 4.5, 4.6), v(-1.0, 1.5, -0.8), 1.2, 0.05, 40.0))
}

struct Compared {
    lit: usize,
    shadow: usize,
    wrong: usize,
    /// Wrong, though all around show the same thing in the same light.
    unexplained: usize,
    /// Compared, within [`SEAM`] of where two faces of the light meet.
    near_seam: usize,
    /// Of those, wrong in the middle of the same thing in the same light.
    wrong_at_seam: usize,
}

/// As sine of the angle: some texels of a map of 1024.
const SEAM: f64 = 0.01;

/// Most wrong pixels without a reason: shadows thinner than a few pixels have no pixel that shows them.
const UNEXPLAINED_SHARE: f64 = 2e-4;

/// The mask of a technique against traced truth.
fn compare(text: &str, scene: &Scene, camera: &Camera, light: &Light) -> Compared {
    const SIZE: [u32; 2] = [280, 200];
    let (renderer, progress) = (CpuRenderer::new(), Progress::new());
    let t = by_body(text);
    let p = t.parameterize_seen(scene, camera, light, [1024; 2], Some(&samples_of(scene, camera))).expect(text);
    let bias = Bias::default();
    let settings = MaskSettings {
        resolution: [1024; 2],
        size: SIZE,
        bias,
        filter: Filter::Nearest,
        blend: 0.0,
        stored: Stored::default(),
    };
    let mask = renderer.shadow_mask(scene, camera, light, &p, &settings, &progress).expect("a mask").data;
    let truth = Tracer::new(scene, &progress).expect("a tracer");
    let truth = truth.shadow_mask(camera, light, SIZE, &progress).expect("a mask").data;
    let g = renderer.gbuffer(scene, camera, SIZE, &progress).expect("a G-buffer");
    let mut c = Compared { lit: 0, shadow: 0, wrong: 0, unexplained: 0, near_seam: 0, wrong_at_seam: 0 };
    let [width, height] = SIZE.map(|n| n as usize);
    for i in 0..truth.len() {
        let (x, y) = (i % width, i / width);
        if !matches!(truth[i], TruthMask::LIT | TruthMask::SHADOW) {
            continue;
        }
        let wrong = (mask[i] >= 0.5) != (truth[i] == TruthMask::LIT);
        *if truth[i] == TruthMask::LIT { &mut c.lit } else { &mut c.shadow } += 1;
        let around = (y.saturating_sub(2)..(y + 3).min(height))
            .flat_map(|y| (x.saturating_sub(2)..(x + 3).min(width)).map(move |x| y * width + x));
        let same = |j: usize| truth[j] == truth[i] && g.instance[j] == g.instance[i] && g.normal[j] == g.normal[i];
        let unexplained = wrong && around.into_iter().all(same);
        c.wrong += usize::from(wrong);
        c.unexplained += usize::from(unexplained);
        if let Light::Point(l) = light {
            let d = (g.origin + DVec3::from_array(g.position[i].map(f64::from)) - l.position()).normalize().abs();
            let mut sorted = d.to_array();
            sorted.sort_by(f64::total_cmp);
            let near_seam = sorted[2] - sorted[1] < SEAM;
            c.near_seam += usize::from(near_seam);
            c.wrong_at_seam += usize::from(near_seam && unexplained);
        }
    }
    c
}

#[test]
fn a_point_light_in_a_room_shades_as_truth_does() {
    let (scene, camera) = room(true);
    let at = DVec3::new(0.2, 4.2, 0.1);
    let point = Light::Point(PointLight::new(at, 40.0).expect("a light"));
    let spot = Light::Spot(SpotLight::new(at, DVec3::new(-0.1, -1.0, -0.1), 1.9, 40.0).expect("a light"));
    let share = |c: &Compared| c.wrong as f64 / (c.lit + c.shadow) as f64;
    let reference = compare("uniform", &scene, &camera, &spot);
    println!("uniform under a spot: {:.4} wrong, {} unexplained", share(&reference), reference.unexplained);
    let techniques = [
        "uniform",
        "lispsm",
        "lispsm:near=0.5",
        "z_partition:count=3",
        "z_partition:count=2,splits=equal-log,inner=lispsm",
        "face_partition",
        "z_partition:count=2,inner=face_partition",
    ];
    for text in techniques {
        let c = compare(text, &scene, &camera, &point);
        let &Compared { lit, shadow, wrong, unexplained, near_seam, wrong_at_seam } = &c;
        let what = format!(
            "{text}: {lit} lit, {shadow} in shadow, {wrong} wrong ({:.4}), {unexplained} of them unexplained, \
                            {near_seam} at seams, {wrong_at_seam} wrong there",
            share(&c)
        );
        println!("{what}");
        assert!(lit > 10_000 && shadow > 3_000 && near_seam > 500, "{what}");
        assert!(share(&c) <= 2.0 * share(&reference).max(0.002), "{what}");
        assert_eq!(wrong_at_seam, 0, "{what}");
        assert!(unexplained as f64 <= UNEXPLAINED_SHARE * (lit + shadow) as f64, "{what}");
    }
}

#[test]
fn a_light_inside_a_mesh_keeps_depths_apart_at_its_walls() {
    let (scene, camera) = room(false);
    let light = Light::Point(PointLight::new(DVec3::new(0.2, 4.2, 0.1), 40.0).expect("a light"));
    for text in ["uniform", "lispsm", "lispsm:near=0.5", "z_partition:count=2,inner=lispsm", "face_partition"] {
        let p = maps(text, &scene, &camera, &light);
        assert!(p.notes.iter().any(|note| note.kind() == Kind::LightInBox), "{text}: {:?}", p.notes);
        let Compared { lit, shadow, wrong, unexplained, .. } = compare(text, &scene, &camera, &light);
        let what = format!("{text}: {wrong} of {} wrong, {unexplained} unexplained", lit + shadow);
        println!("{what}");
        assert!(wrong as f64 <= 0.004 * (lit + shadow) as f64, "{what}");
        assert!(unexplained as f64 <= UNEXPLAINED_SHARE * (lit + shadow) as f64, "{what}");
    }
}

#[test]
fn every_ray_of_a_point_light_has_one_face() {
    let (scene, camera) = room(true);
    let at = DVec3::new(0.2, 4.2, 0.1);
    let light = Light::Point(PointLight::new(at, 40.0).expect("a light"));
    let p = maps("uniform", &scene, &camera, &light);
    assert_eq!((p.partitions.len(), p.selection), (6, Selection::Containment));
    // Each direction has exactly one face, or two or three where they meet.
    let mut random = Random(8);
    for _ in 0..1000 {
        let d = random.direction();
        let q = at + d;
        let faces: Vec<usize> = (0..6).filter(|&k| p.partitions[k].region.contains(q)).collect();
        let axes = [d.x, -d.x, d.y, -d.y, d.z, -d.z];
        let longest = (0..6).max_by(|&a, &b| axes[a].total_cmp(&axes[b])).expect("a face");
        assert_eq!(faces, [longest]);
    }
    for seam in [DVec3::new(1.0, 1.0, 0.3), DVec3::new(0.2, -1.0, 1.0), DVec3::new(-1.0, 1.0, -1.0)] {
        let q = at + seam;
        let faces = (0..6).filter(|&k| p.partitions[k].region.contains(q)).count();
        assert_eq!(faces, if seam.abs().min_element() == 1.0 { 3 } else { 2 }, "{seam}");
    }
}

#[test]
fn a_point_light_out_of_view_or_reach_has_valid_maps() {
    let mesh = Arc::new(Mesh::new(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], &[[0, 1, 2]]).expect("a mesh"));
    let triangle = Scene::new(vec![mesh], vec![Instance { mesh: 0, world_from_mesh: DAffine3::IDENTITY }]);
    let triangle = triangle.expect("a scene");
    let camera = look(DVec3::new(0.3, 0.3, 4.0), DVec3::new(0.3, 0.3, 0.0), 0.6, 0.1, 20.0);
    for (at, range) in [(DVec3::Z * 9.0, 0.5), (DVec3::new(0.3, 0.3, 0.0), 5.0), (DVec3::new(1e6, 0.0, 0.0), 2e6)] {
        let light = Light::Point(PointLight::new(at, range).expect("a light"));
        for text in ["uniform", "lispsm", "z_partition", "face_partition"] {
            let p = maps(text, &triangle, &camera, &light);
            let finite = p.partitions.iter().all(|map| map.shadow_clip_from_world.is_finite());
            assert!(finite && p.partitions.len() >= 6, "{text} {at}");
        }
    }
}
