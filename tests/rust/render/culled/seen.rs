//! Casters whose shadow reaches no pixel: the mask without them is the mask with them, bit for bit.

use rayon::prelude::*;
use shadowlab::image::ShadowMask;
use shadowlab::render::cpu::{CpuRenderer, look_up};
use shadowlab::render::{
    Bias, Casters, Cull, Filter, Format, MaskSettings, Renderer, Rule, Spacing, Stored, StoredSurface,
};
use shadowlab::{Parameterization, Progress};

use super::setups::{among_blocks, casters, check_counts, gbuffer, maps_of};
use crate::support::cpu::{FILTERS, filter};
use crate::support::views::{View, directional, directions, from_library, points, spots};

const SETTINGS: MaskSettings = MaskSettings {
    resolution: [256; 2],
    size: [120, 80],
    bias: Bias::NONE,
    filter: Filter::Nearest,
    blend: 0.0,
    stored: Stored::FRONT,
};

/// Biases of every part.
fn biases() -> [Bias; 7] {
    [
        Bias::default(),
        Bias::NONE,
        Bias { plane: 1.0, ..Bias::NONE },
        Bias { slope: 1.0, slope_limit: 4.0, ..Bias::NONE },
        Bias { normal: 1.5, world: 0.02, ..Bias::NONE },
        Bias { ndc: -0.003, plane: 1.0, slope_limit: 3.0, ..Bias::NONE },
        Bias { factor: 1.5, units: 4.0, texels: 0.5, ..Bias::NONE },
    ]
}

fn stored() -> Vec<Stored> {
    let surfaces = StoredSurface::NAMES.iter().map(|(_, surface)| *surface);
    let both = surfaces.flat_map(|surface| Spacing::NAMES.map(|(_, spacing)| (surface, spacing)));
    let formats = Format::NAMES.iter().cycle();
    both.zip(formats)
        .map(|((surface, spacing), (_, format))| Stored { surface, spacing, format: *format, ..Stored::FRONT })
        .collect()
}

fn differing(a: &ShadowMask, b: &ShadowMask) -> usize {
    let bits = |mask: &ShadowMask| mask.data.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    assert_eq!(a.partition, b.partition);
    bits(a).iter().zip(bits(b)).filter(|(a, b)| **a != *b).count()
}

/// Fails where the mask differs, drawn at once or looked up in maps of what is seen.
fn compare(v: &View, p: &Parameterization, settings: &MaskSettings, name: &str) {
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    let of = |cull| cpu.mask_of(&v.scene, &v.camera, &v.light, p, settings, cull, &progress).unwrap();
    let (whole, seen) = (of(Cull::None), of(Cull::Seen));
    assert_eq!(differing(&whole, &seen), 0, "{name}, {settings:?}");
    let g = gbuffer(&v.scene, &v.camera, settings.size);
    let (surfaces, looks) = (g.surfaces(), (&v.camera, &v.light));
    let maps = cpu.seen_maps(&v.scene, surfaces, looks.0, looks.1, p, settings, &progress).unwrap();
    let looked_up = look_up(&maps.data, surfaces, looks.0, looks.1, p, settings, &progress).unwrap();
    assert_eq!(differing(&whole, &looked_up), 0, "{name}, {settings:?}, looked up");
}

#[test]
fn the_comparison_fails_on_one_pixel() {
    let mask = |x: f32| ShadowMask { size: [2, 1], data: vec![x, f32::NAN], partition: vec![0, -1] };
    assert_eq!((differing(&mask(0.5), &mask(0.5)), differing(&mask(0.5), &mask(0.5f32.next_up()))), (0, 1));
}

#[test]
fn masks_of_every_technique_and_library_scene_stay() {
    let (biases, stored) = (biases(), stored());
    from_library().par_iter().for_each(|v| {
        for (i, (name, p)) in maps_of(v, 256).into_iter().enumerate() {
            for k in 0..3 {
                let settings = MaskSettings {
                    bias: biases[(i + 2 * k) % biases.len()],
                    filter: filter(FILTERS[(2 * i + k) % FILTERS.len()]),
                    blend: if k == 1 { 0.3 } else { 0.0 },
                    stored: if k == 0 { Stored::FRONT } else { stored[(i + k) % stored.len()] },
                    ..SETTINGS
                };
                compare(v, &p, &settings, &name);
            }
        }
    });
}

#[test]
fn masks_of_every_filter_bias_and_stored_depth_stay() {
    let v = among_blocks();
    let (biases, stored) = (biases(), stored());
    let maps = maps_of(&v, 256);
    let cases: Vec<(usize, usize, usize)> =
        (0..FILTERS.len()).flat_map(|f| (0..biases.len()).flat_map(move |b| (0..2).map(move |s| (f, b, s)))).collect();
    cases.par_iter().for_each(|&(f, b, s)| {
        let stored = stored[(f + 3 * b + 5 * s) % stored.len()];
        let settings = MaskSettings {
            filter: filter(FILTERS[f]),
            bias: biases[b],
            stored: if s == 0 { Stored { format: stored.format, ..Stored::FRONT } } else { stored },
            blend: 0.1 * (b % 3) as f64,
            ..SETTINGS
        };
        let (name, p) = &maps[(7 * f + 3 * b + s) % maps.len()];
        compare(&v, p, &settings, name);
    });
}

#[test]
fn masks_of_awkward_lights_stay() {
    let v = among_blocks();
    let directions = directions(&v.camera).into_iter().map(|(name, d)| (name, directional(d)));
    let lights: Vec<_> =
        directions.chain(spots(&v.scene, &v.camera)).chain(points(&v.scene, &v.camera)).enumerate().collect();
    lights.into_par_iter().for_each(|(i, (name, light))| {
        let of_light = View { name, scene: v.scene.clone(), camera: v.camera, light };
        for (k, (name, p)) in maps_of(&of_light, 128).into_iter().enumerate() {
            if (i + k) % 3 == 0 {
                let settings = MaskSettings { resolution: [128; 2], bias: biases()[(i + k) % 7], ..SETTINGS };
                compare(&of_light, &p, &settings, &name);
            }
        }
    });
}

#[test]
fn each_rule_leaves_out_casters() {
    let v = among_blocks();
    let of = |casters: &Casters, rule: Rule| casters.instances[rule as usize];
    for (name, p) in maps_of(&v, 256) {
        let (volume, seen) = (casters(&v, &p, Cull::Volume, &SETTINGS), casters(&v, &p, Cull::Seen, &SETTINGS));
        for (volume, seen) in volume.iter().zip(&seen) {
            check_counts(&v.scene, seen, &name);
            assert_eq!((of(volume, Rule::Unseen), of(volume, Rule::Behind)), (0, 0), "{name}");
            assert!(of(seen, Rule::Drawn) <= of(volume, Rule::Drawn), "{name}");
            for (i, (a, b)) in volume.rules.iter().zip(&seen.rules).enumerate() {
                assert_eq!(*a == Rule::Outside, *b == Rule::Outside, "{name}, instance {i}");
            }
        }
        if name.ends_with("uniform:focus=none") {
            let [drawn, outside, unseen, behind] = seen[0].instances;
            assert!(drawn > 20 && unseen > 200 && behind > 0, "{name}: {drawn}, {outside}, {unseen}, {behind}");
        }
        if name.ends_with("lispsm") && seen.len() == 1 {
            let [drawn, outside, unseen, behind] = seen[0].instances;
            assert!(drawn > 20 && outside > 100 && unseen > 10, "{name}: {drawn}, {outside}, {unseen}, {behind}");
        }
    }
}

#[test]
fn a_caster_that_is_wrongly_left_out_shows() {
    // Without every tenth of the casters that are drawn, some mask differs: the comparison above is not blind.
    let v = among_blocks();
    let (name, p) = maps_of(&v, 256).into_iter().find(|(name, _)| name.ends_with("lispsm")).unwrap();
    let found = &casters(&v, &p, Cull::Seen, &SETTINGS)[0];
    let drawn: Vec<usize> = (1..found.rules.len()).filter(|i| found.rules[*i] == Rule::Drawn).collect();
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    let g = gbuffer(&v.scene, &v.camera, SETTINGS.size);
    let mask = |without: &[usize]| {
        let kept = (0..found.rules.len()).filter(|i| !without.contains(i)).map(|i| v.scene.instances()[i]);
        let scene = shadowlab::Scene::new(v.scene.meshes().to_vec(), kept.collect()).unwrap();
        let maps = cpu.depth_maps(&scene, &p, SETTINGS.resolution, SETTINGS.stored, &progress).unwrap();
        look_up(&maps.data, g.surfaces(), &v.camera, &v.light, &p, &SETTINGS, &progress).unwrap()
    };
    let whole = mask(&[]);
    let left_out: Vec<usize> = (1..found.rules.len()).filter(|i| found.rules[*i] != Rule::Drawn).collect();
    assert_eq!(differing(&whole, &mask(&left_out)), 0, "{name}");
    let tenth: Vec<usize> = drawn.iter().copied().step_by(10).collect();
    assert!(differing(&whole, &mask(&tenth)) > 10, "{name}");
}
