//! The states of many lights are their masks, one bit each: over lights of every kind, techniques, biases and filters.

use glam::DVec3;
use shadowlab::image::{ShadowMask, ShadowStates};
use shadowlab::parameterization::Parameterization;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Bias, Cull, LightMaps, MaskSettings, Renderer, Stored};
use shadowlab::techniques::technique_of;
use shadowlab::{Camera, Error, Light, Progress, Scene};

use crate::support::cpu::{FILTERS, filter};
use crate::support::views::{
    by_hand, directional, directions, look, picture_of, placed, points, shaded_samples, spots, square,
};

/// A run of 64 pixels and a part of one.
const SIZE: [u32; 2] = [100, 70];

/// One map and several, with and without post-warp, of a body and of what is seen.
const TECHNIQUES: [&str; 6] = [
    "uniform",
    "lispsm:near=basic,range=body",
    "z_partition:count=3,overlap=0.3",
    "log:range=body",
    "tsm",
    "rectilinear",
];

/// Every part of a bias that has code of its own.
fn biases() -> [Bias; 5] {
    let d = Bias::default();
    [
        d,
        Bias::NONE,
        Bias { plane: 0.0, slope_limit: f64::INFINITY, ..d },
        Bias { normal: 1.0, ..d },
        Bias { world: 0.05, ..d },
    ]
}

fn settings(turn: usize) -> MaskSettings {
    MaskSettings {
        resolution: [1; 2],
        size: SIZE,
        bias: biases()[turn % 5],
        filter: filter(FILTERS[turn % FILTERS.len()]),
        blend: [0.0, 0.3][turn % 2],
        stored: Stored::FRONT,
    }
}

/// Each light with the maps of some technique that serves it.
fn with_maps(scene: &Scene, camera: &Camera, lights: &[Light], turn: usize) -> Vec<(Light, Parameterization)> {
    let picture = picture_of(scene, camera);
    let made = |(i, light): (usize, &Light)| {
        let samples = shaded_samples(scene, camera, light, &picture);
        let texts = (0..TECHNIQUES.len()).map(|k| TECHNIQUES[(turn + i + k) % TECHNIQUES.len()]);
        let mut serving = texts.filter_map(|text| {
            let t = technique_of(text).unwrap();
            t.serves(light).ok()?;
            match t.parameterize_seen(scene, camera, light, [48 + 16 * (i as u32 % 3), 64], Some(&samples)) {
                Ok(p) => Some(p),
                Err(Error::UnsuitedView { .. }) => None,
                Err(error) => panic!("{text}: {error}"),
            }
        });
        serving.next().map(|p| (*light, p))
    };
    lights.iter().enumerate().filter_map(made).collect()
}

/// The first light and pixel at which states are not those of masks.
fn first_difference(states: &ShadowStates, masks: &[ShadowMask]) -> Option<(usize, usize)> {
    let pixels = (states.size[0] * states.size[1]) as usize;
    assert_eq!(states.data.len(), masks.len().div_ceil(32) * pixels);
    let differs = |i: usize, pixel: usize| {
        let bit = states.data[i / 32 * pixels + pixel] >> (i % 32) & 1;
        (bit == 1) != (masks[i].data[pixel] >= 0.5)
    };
    (0..masks.len()).find_map(|i| (0..pixels).find(|pixel| differs(i, *pixel)).map(|pixel| (i, pixel)))
}

/// States and masks of lights with their maps.
fn both(
    renderer: &dyn Renderer,
    (scene, camera): (&Scene, &Camera),
    lights: &[(Light, Parameterization)],
    settings: &MaskSettings,
    cull: Cull,
) -> (ShadowStates, Vec<ShadowMask>) {
    let progress = Progress::new();
    let all: Vec<LightMaps> =
        lights.iter().map(|(light, p)| LightMaps { light, p, resolution: p.resolution }).collect();
    let states = renderer.shadow_states(scene, camera, &all, settings, cull, &progress).unwrap();
    let mask = |one: &LightMaps| {
        renderer.shadow_mask(scene, camera, one.light, one.p, &one.settings(settings), &progress).unwrap()
    };
    (states, all.iter().map(mask).collect())
}

#[test]
fn each_light_has_the_bits_of_its_mask() {
    let cpu = CpuRenderer::new();
    let (mut lit, mut dark, mut pictures) = (0, 0, 0);
    for (turn, (name, scene, camera)) in by_hand().into_iter().enumerate() {
        let suns = directions(&camera).into_iter().map(|(_, d)| directional(d));
        let lamps = spots(&scene, &camera).into_iter().chain(points(&scene, &camera)).map(|(_, light)| light);
        let lights: Vec<Light> = suns.chain(lamps).collect();
        let lights = with_maps(&scene, &camera, &lights, turn);
        // More than one picture has room for, too.
        let lights: Vec<_> = lights.iter().cycle().take([lights.len(), 37][turn % 2]).cloned().collect();
        let (settings, cull) = (settings(turn), [Cull::Volume, Cull::Seen, Cull::None][turn % 3]);
        let (states, masks) = both(&cpu, (&scene, &camera), &lights, &settings, cull);
        assert_eq!(first_difference(&states, &masks), None, "{name}: {settings:?}");
        pictures = pictures.max(states.data.len() / (SIZE[0] * SIZE[1]) as usize);
        lit += states.data.iter().map(|s| s.count_ones() as usize).sum::<usize>();
        dark += masks.iter().flat_map(|m| &m.data).filter(|light| **light < 0.5).count();
    }
    assert!(lit > 10_000 && dark > 10_000 && pictures == 2, "{lit} {dark} {pictures}");
}

#[test]
fn every_filter_and_bias_of_one_map_gives_the_bits_of_masks() {
    let cpu = CpuRenderer::new();
    let (_, scene, camera) = by_hand().swap_remove(0);
    let lights: Vec<Light> = directions(&camera).into_iter().map(|(_, d)| directional(d)).take(5).collect();
    let lights: Vec<_> = lights
        .iter()
        .map(|light| (*light, technique_of("uniform").unwrap().parameterize(&scene, &camera, light, 64).unwrap()))
        .collect();
    for text in FILTERS {
        for bias in biases() {
            let settings = MaskSettings { bias, filter: filter(text), blend: 0.0, ..settings(0) };
            let (states, masks) = both(&cpu, (&scene, &camera), &lights, &settings, Cull::Volume);
            assert_eq!(first_difference(&states, &masks), None, "{text}: {bias:?}");
        }
    }
}

/// A floor of 20 x 20 with a square of 4 x 4 above its middle, seen from above.
fn floor_and_lid() -> (Scene, Camera) {
    let scale = |side: f64| glam::DMat3::from_diagonal(DVec3::new(side, 1.0, side));
    let scene = placed(&[(square(), scale(10.0), DVec3::ZERO), (square(), scale(2.0), DVec3::Y)]);
    (scene, look(DVec3::new(0.0, 30.0, 0.01), DVec3::ZERO, 0.9, 1.0, 100.0))
}

#[test]
fn bits_are_known_where_light_comes_from_above_beside_and_below() {
    let (scene, camera) = floor_and_lid();
    let lights = [DVec3::NEG_Y, DVec3::new(1.0, -0.5, 0.0), DVec3::Y].map(directional);
    let lights = with_maps(&scene, &camera, &lights, 0);
    assert_eq!(lights.len(), 3);
    let (states, masks) = both(&CpuRenderer::new(), (&scene, &camera), &lights, &settings(0), Cull::Volume);
    let seen = |x: usize, y: usize| states.data[y * SIZE[0] as usize + x];
    // The middle is the lid, whose shadow under a light from above nobody sees; one from the left throws it two to the right.
    assert_eq!(seen(50, 35), 0b011);
    assert_eq!(seen(0, 0), 0, "the background is dark");
    let of_light = |i: u32| states.data.iter().filter(|s| *s >> i & 1 == 1).count();
    let surfaces = masks[0].data.iter().filter(|light| !light.is_nan()).count();
    // Texels about the lid's edges may darken what lies beside it.
    assert!(of_light(0) > surfaces * 9 / 10 && of_light(0) <= surfaces && of_light(2) == 0);
    assert!(of_light(1) < surfaces && of_light(1) > surfaces / 2, "{} of {surfaces}", of_light(1));
}

#[test]
fn a_change_of_one_bit_or_pixel_is_seen() {
    let (scene, camera) = floor_and_lid();
    let lights = [DVec3::NEG_Y, DVec3::new(1.0, -0.5, 0.0)].map(directional);
    let lights = with_maps(&scene, &camera, &lights, 0);
    let (states, masks) = both(&CpuRenderer::new(), (&scene, &camera), &lights, &settings(0), Cull::Volume);
    assert_eq!(first_difference(&states, &masks), None);
    let mut other = states.clone();
    other.data[35 * SIZE[0] as usize + 50] ^= 0b10;
    assert_eq!(first_difference(&other, &masks), Some((1, 35 * SIZE[0] as usize + 50)));
    let mut others = masks;
    others[0].data[7] = if others[0].data[7] >= 0.5 { 0.0 } else { 1.0 };
    assert_eq!(first_difference(&states, &others), Some((0, 7)));
}

#[test]
fn maps_that_are_not_held_together_give_the_same_bits() {
    let (scene, camera) = floor_and_lid();
    let lights = [DVec3::NEG_Y, DVec3::new(1.0, -0.5, 0.0), DVec3::new(-0.3, -1.0, 0.4)].map(directional);
    let mut lights = with_maps(&scene, &camera, &lights, 0);
    // As many texels as are held together, so that each map beside it takes a pass of its own.
    lights[1].1.resolution = [8192; 2];
    let (states, masks) = both(&CpuRenderer::new(), (&scene, &camera), &lights, &settings(0), Cull::Volume);
    assert_eq!(first_difference(&states, &masks), None);
}

#[test]
fn what_no_states_can_be_made_of_is_refused() {
    let (scene, camera) = floor_and_lid();
    let (light, progress) = (directional(DVec3::NEG_Y), Progress::new());
    let p = technique_of("uniform").unwrap().parameterize(&scene, &camera, &light, 64).unwrap();
    let none = Parameterization { partitions: Vec::new(), ..p.clone() };
    let good = LightMaps { light: &light, p: &p, resolution: [64; 2] };
    let bad = [
        ("lights", vec![]),
        ("parameterization", vec![good, LightMaps { p: &none, ..good }]),
        ("resolution", vec![good, LightMaps { resolution: [0, 64], ..good }]),
    ];
    for (expected, lights) in bad {
        let found = CpuRenderer::new().shadow_states(&scene, &camera, &lights, &settings(0), Cull::Volume, &progress);
        let Err(Error::InvalidArgument { name, .. }) = found else { panic!("{expected}: {found:?}") };
        assert_eq!(name, expected);
    }
    progress.stop();
    let found = CpuRenderer::new().shadow_states(&scene, &camera, &[good], &settings(0), Cull::Volume, &progress);
    assert_eq!(found, Err(Error::Interrupted));
}

#[cfg(feature = "gpu")]
#[test]
fn a_device_sets_the_bits_of_its_masks() {
    use shadowlab::parameterization::PostWarp;

    let Some(gpu) = crate::support::gpu::renderer() else { return };
    let (scene, camera) = floor_and_lid();
    let lights: Vec<Light> = directions(&camera).into_iter().map(|(_, d)| directional(d)).collect();
    let lights = with_maps(&scene, &camera, &lights, 1);
    let plain = MaskSettings { blend: 0.0, ..settings(1) };
    let drawn: Vec<_> =
        lights.into_iter().filter(|(_, p)| p.partitions.iter().all(|q| q.post_warp == PostWarp::None)).collect();
    let (states, masks) = both(&gpu, (&scene, &camera), &drawn, &plain, Cull::Volume);
    assert_eq!(first_difference(&states, &masks), None);
    assert!(drawn.len() > 3 && states.data.iter().any(|s| *s != 0));
}
