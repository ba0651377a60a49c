//! Light that is mixed between neighbouring maps: linear over the zone, of the two maps' own light, and nothing elsewhere.

use glam::{DMat4, DVec3};
use shadowlab::parameterization::{Parameterization, Selection};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::scene::{DirectionalLight, library};
use shadowlab::techniques::technique_of;
use shadowlab::{Camera, Error, Light, Progress, Scene};

use super::selection::maps::{alone, views};
use crate::support::cpu::*;

const SIZE: [u32; 2] = [160, 120];
/// Of single precision, in sums of two products.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

fn settings(blend: f64) -> MaskSettings {
    MaskSettings {
        resolution: [256; 2],
        size: SIZE,
        bias: Bias::default(),
        filter: Filter::Bilinear,
        blend,
        stored: Stored::default(),
    }
}

/// A floor with a roof over half of it, two maps of all: one that holds the roof and one that begins below it.
fn dark_then_lit() -> (Scene, Camera, Light, Parameterization) {
    let level = |y: f64| {
        let p = |x: f64, z: f64| DVec3::new(x, y, z);
        [[p(-9.0, -9.0), p(9.0, -9.0), p(9.0, 9.0)], [p(-9.0, -9.0), p(9.0, 9.0), p(-9.0, 9.0)]]
    };
    let scene = triangles(&[level(0.0), level(2.0)].concat());
    let camera =
        Camera::look_at(DVec3::new(0.0, 1.0, 6.0), DVec3::new(0.0, 0.3, 0.0), DVec3::Y, 0.7, 1.3, 0.1, 50.0).unwrap();
    let light = Light::Directional(DirectionalLight::new(DVec3::NEG_Y).unwrap());
    let map = |top: f64| {
        let view = glam::dcamera::rh::view::look_to_mat4(DVec3::Y * top, DVec3::NEG_Y, DVec3::NEG_Z);
        glam::dcamera::rh::proj::directx::orthographic(-10.0, 10.0, -10.0, 10.0, 0.0, top + 1.0) * view
    };
    let mut p = maps(&[map(3.0), map(1.5)]);
    p.partitions[0].eye_depth = [2.0, 7.0];
    p.partitions[1].eye_depth = [7.0, 50.0];
    (scene, camera, light, p)
}

#[test]
fn light_goes_linearly_from_one_map_to_the_next() {
    let (scene, camera, light, p) = dark_then_lit();
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    let g = cpu.gbuffer(&scene, &camera, SIZE, &progress).unwrap();
    for blend in [0.0, 0.2, 0.5, 1.0] {
        let mask = cpu.shadow_mask(&scene, &camera, &light, &p, &settings(blend), &progress).unwrap();
        let mut seen = [0; 3];
        for i in 0..mask.data.len() {
            let Some((point, normal)) = g.surfaces().receiver(i).filter(|(_, n)| n.y > 0.5) else { continue };
            assert!(normal.y > 0.5);
            let depth = camera.depth_of(point + g.origin);
            let zone = blend * 5.0;
            let expected = if zone > 0.0 {
                ((depth - (7.0 - zone)) / zone).clamp(0.0, 1.0)
            } else {
                f64::from(u8::from(depth > 7.0))
            };
            assert!((f64::from(mask.data[i]) - expected).abs() < 1e-6, "{blend}, {depth}: {}", mask.data[i]);
            assert_eq!(mask.partition[i], i16::from(depth > 7.0), "the chosen map stays the chosen one");
            seen[if expected == 0.0 {
                0
            } else if expected < 1.0 {
                1
            } else {
                2
            }] += 1;
        }
        assert!(
            seen[2] > 500 && (blend == 1.0 || seen[0] > 500) && (blend == 0.0 || seen[1] > 300),
            "{blend}: {seen:?}"
        );
    }
}

#[test]
fn without_the_next_map_nothing_is_mixed() {
    let (scene, camera, light, mut p) = dark_then_lit();
    // The next map is elsewhere, so that its own receivers are lit and those of the zone keep their map's light.
    p.partitions[1].shadow_clip_from_world *= DMat4::from_translation(DVec3::X * 100.0);
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    let of = |blend| cpu.shadow_mask(&scene, &camera, &light, &p, &settings(blend), &progress).unwrap();
    let bits = |mask: Vec<f32>| mask.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(of(0.0).data), bits(of(0.5).data));
}

#[test]
fn maps_that_are_chosen_by_what_they_hold_blend_at_their_border() {
    let (scene, camera, light, mut p) = dark_then_lit();
    p.selection = Selection::Containment;
    // The first map is half as wide: its border is at 5 of x and z.
    let half = DMat4::from_scale(DVec3::new(2.0, 2.0, 1.0));
    p.partitions[0].shadow_clip_from_world = half * p.partitions[0].shadow_clip_from_world;
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    let g = cpu.gbuffer(&scene, &camera, SIZE, &progress).unwrap();
    let mask = cpu.shadow_mask(&scene, &camera, &light, &p, &settings(0.4), &progress).unwrap();
    let mut mixed = 0;
    for i in 0..mask.data.len() {
        let Some((point, _)) = g.surfaces().receiver(i).filter(|(_, n)| n.y > 0.5) else { continue };
        let at = (point + g.origin).abs();
        let expected = ((at.x.max(at.z) / 5.0 - 0.6) / 0.4).clamp(0.0, 1.0);
        assert!((f64::from(mask.data[i]) - expected).abs() < 1e-5, "{at}: {}", mask.data[i]);
        mixed += usize::from(expected > 0.0 && expected < 1.0);
    }
    assert!(mixed > 300, "{mixed}");
}

#[test]
fn no_blending_is_what_the_chosen_maps_give_alone() {
    for v in views() {
        let draw = |p: &Parameterization, blend| {
            let settings = settings(blend);
            CpuRenderer::new().shadow_mask(&v.scene, &v.camera, &v.light, p, &settings, &Progress::new()).unwrap()
        };
        let (plain, blended) = (draw(&v.p, 0.0), draw(&v.p, 0.3));
        assert_eq!(plain.partition, blended.partition, "{}", v.name);
        let singles: Vec<_> = (0..v.p.partitions.len().min(8)).map(|k| draw(&alone(&v.p, k), 0.0).data).collect();
        for i in 0..plain.data.len() {
            let Some(own) = usize::try_from(plain.partition[i]).ok().and_then(|k| singles.get(k)) else { continue };
            assert_eq!(plain.data[i].to_bits(), own[i].to_bits(), "{}", v.name);
            assert!((0.0..=1.0).contains(&blended.data[i]), "{}", v.name);
        }
    }
}

#[test]
fn cascades_that_overlap_have_the_light_of_both_over_the_whole_zone() {
    let s = library::build("robots", 1, &[]).unwrap();
    let technique =
        technique_of("z_partition:distances=(8,12),overlap=0.3,inner=(uniform:range=body,fit=exact),range=body")
            .unwrap();
    let p = technique.parameterize(&s.scene, &s.camera, &s.light, 512).unwrap();
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    let draw = |p: &Parameterization, blend| {
        cpu.shadow_mask(&s.scene, &s.camera, &s.light, p, &settings(blend), &progress).unwrap()
    };
    let (mask, g) = (draw(&p, 0.3), cpu.gbuffer(&s.scene, &s.camera, SIZE, &progress).unwrap());
    let singles: Vec<_> = (0..3).map(|k| draw(&alone(&p, k), 0.0).data).collect();
    let mut mixed = 0;
    for i in 0..mask.data.len() {
        let Ok(k) = usize::try_from(mask.partition[i]) else { continue };
        let (point, _) = g.surfaces().receiver(i).unwrap();
        let depth = s.camera.depth_of(point + g.origin);
        let [begin, end] = p.partitions[k].eye_depth;
        let share =
            if k == 2 { 0.0 } else { ((depth - (0.7 * end + 0.3 * begin)) / (0.3 * (end - begin))).max(0.0) as f32 };
        let expected = (1.0 - share) * singles[k][i] + share * singles[(k + 1).min(2)][i];
        assert!((mask.data[i] - expected).abs() <= 8.0 * ROUNDING, "{depth}: {} and {expected}", mask.data[i]);
        mixed += usize::from(share > 0.0 && share < 1.0 && singles[k][i] != singles[(k + 1).min(2)][i]);
    }
    assert!(mixed > 20, "{mixed}");
}

#[test]
fn shares_outside_of_their_range_are_refused() {
    let (scene, camera, light, p) = dark_then_lit();
    for blend in [-0.1, 1.1, f64::NAN, f64::INFINITY] {
        let error = CpuRenderer::new()
            .shadow_mask(&scene, &camera, &light, &p, &settings(blend), &Progress::new())
            .unwrap_err();
        assert!(matches!(&error, Error::InvalidArgument { name, .. } if name == "blend"), "{error}");
    }
}
