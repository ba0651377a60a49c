//! Masks are looked up in runs of receivers: each pixel has what the lookup of one receiver gives, bit for bit.

use glam::{DMat4, DVec3, DVec4};
use rayon::prelude::*;
use shadowlab::image::{ShadowMask, Surfaces};
use shadowlab::parameterization::{Parameterization, Partition, PostWarp, Region, Selection};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::cpu::lookup::{Lookups, Next, look_up};
use shadowlab::render::{Bias, Format, MaskSettings, Renderer, Spacing, Stored};
use shadowlab::scene::{DirectionalLight, PointLight, SpotLight};
use shadowlab::techniques::{TECHNIQUES, technique};
use shadowlab::{Camera, Error, Light, Progress};

use crate::support::cpu::*;
use crate::support::views::{
    View, by_hand, directional, directions, from_library, picture_of, points, shaded_samples, spots,
};

/// A run of 64 pixels and a part of one.
const SIZE: [u32; 2] = [100, 70];

/// The mask, receiver by receiver.
fn one_by_one(
    maps: &[f32],
    surfaces: &Surfaces,
    camera: &Camera,
    light: &Light,
    p: &Parameterization,
    settings: &MaskSettings,
) -> ShadowMask {
    let lookups = Lookups::new(p, camera, light, surfaces.origin, settings).unwrap();
    let texels = lookups.texels();
    let at = |pixel: usize| {
        let Some((point, normal)) = surfaces.receiver(pixel) else { return (f32::NAN, ShadowMask::NO_MAP) };
        let p_world = surfaces.origin + point;
        if !light.illuminates(p_world, normal) {
            return (0.0, ShadowMask::NO_MAP);
        }
        let eye_depth = camera.depth_of(p_world);
        let Some(k) = lookups.choose(point, eye_depth) else { return (1.0, ShadowMask::NO_MAP) };
        let light_of = |k: usize| lookups.map(k).light(&maps[k * texels..(k + 1) * texels], point, normal);
        let next = if settings.blend > 0.0 { lookups.next(k, point, eye_depth) } else { None };
        let lit = match next {
            None => light_of(k),
            Some(Next { map, share }) => {
                // Maps add their shares in their order.
                let mut shares = [(k, 1.0 - share as f32), (map, share as f32)];
                shares.sort_by_key(|(k, _)| *k);
                let parts = shares.into_iter().filter(|(_, share)| *share > 0.0);
                parts.fold(0.0, |sum, (k, share)| sum + share * light_of(k))
            }
        };
        (lit, k as i16)
    };
    let (data, partition) = (0..surfaces.triangle.len()).map(at).unzip();
    ShadowMask { size: surfaces.size, data, partition }
}

/// The first pixel at which two masks differ by a bit.
fn first_difference(found: &ShadowMask, expected: &ShadowMask) -> Option<usize> {
    assert_eq!((found.size, found.data.len()), (expected.size, expected.data.len()));
    let bits = |mask: &ShadowMask, i: usize| (mask.data[i].to_bits(), mask.partition[i]);
    (0..found.data.len()).find(|&i| bits(found, i) != bits(expected, i))
}

/// How a mask is looked up.
#[derive(Clone, Copy)]
struct How {
    bias: Bias,
    filter: &'static str,
    blend: f64,
    stored: Stored,
}

impl How {
    fn settings(self, resolution: [u32; 2], size: [u32; 2]) -> MaskSettings {
        let How { bias, filter: text, blend, stored } = self;
        MaskSettings { resolution, size, bias, filter: filter(text), blend, stored }
    }
    /// Every kind of bias with every kind of filter; each view takes others.
    fn number(i: usize) -> Self {
        let biases = biases();
        let linear = Stored { spacing: Spacing::Linear, ..Stored::FRONT };
        let stored = [Stored::FRONT, Stored { format: Format::Unorm16, ..Stored::FRONT }, linear];
        Self {
            // Lengths without a common divisor.
            bias: biases[i % biases.len()],
            filter: FILTERS[i % FILTERS.len()],
            blend: [0.0, 0.0, 0.3, 0.0, 1.0][i % 5],
            stored: stored[if i.is_multiple_of(7) { i / 7 % 3 } else { 0 }],
        }
    }
}

fn biases() -> [Bias; 11] {
    let d = Bias::default();
    [
        d,
        Bias::NONE,
        Bias { slope_limit: f64::INFINITY, ..d },
        Bias { plane: 0.0, ..d },
        d,
        Bias { slope: 0.0, plane: 1.0, ..d },
        Bias { slope_limit: 0.0, world: 0.01, ..d },
        Bias { normal: 1.0, ..d },
        Bias::polygon_offset(1.0, 2.0),
        Bias { slope: 1.0, texels: -3.0, ..Bias::NONE },
        Bias { units: 3.0, ..d },
    ]
}

/// Holds masks of a view through the maps of all techniques that serve it against lookups one by one; how many there were.
fn check(v: &View, turn: usize) -> usize {
    let (cpu, progress) = (CpuRenderer::new(), Progress::new());
    let g = cpu.gbuffer(&v.scene, &v.camera, SIZE, &progress).unwrap();
    let samples = shaded_samples(&v.scene, &v.camera, &v.light, &picture_of(&v.scene, &v.camera));
    let mut checked = 0;
    for (i, entry) in TECHNIQUES.iter().enumerate() {
        let t = technique(entry.spec.name, &[]).unwrap();
        if t.serves(&v.light).is_err() {
            continue;
        }
        let p = match t.parameterize_seen(&v.scene, &v.camera, &v.light, [96, 64], Some(&samples)) {
            Ok(p) => p,
            Err(Error::UnsuitedView { .. }) => continue,
            Err(error) => panic!("{} / {}: {error}", v.name, entry.spec.name),
        };
        let mut how = How::number(turn * TECHNIQUES.len() + i);
        let draw = |how: How| cpu.depth_maps(&v.scene, &p, [96, 64], how.stored, &progress);
        let maps = match draw(how) {
            // A map without linear depth.
            Err(Error::InvalidArgument { name, .. }) if name == "stored" => {
                how.stored = Stored::FRONT;
                draw(how)
            }
            maps => maps,
        };
        let (maps, settings) = (maps.unwrap().data, how.settings([96, 64], SIZE));
        let found = look_up(&maps, g.surfaces(), &v.camera, &v.light, &p, &settings, &progress).unwrap();
        let expected = one_by_one(&maps, &g.surfaces(), &v.camera, &v.light, &p, &settings);
        if let Some(pixel) = first_difference(&found, &expected) {
            let values = (found.data[pixel], expected.data[pixel], found.partition[pixel], expected.partition[pixel]);
            panic!("{} / {} / {settings:?}: pixel {pixel}: {values:?}", v.name, entry.spec.name);
        }
        checked += 1;
    }
    checked
}

#[test]
fn masks_of_every_technique_are_those_of_receivers_one_by_one() {
    let mut views = from_library();
    for (i, (name, scene, camera)) in by_hand().into_iter().enumerate() {
        let lights = directions(&camera).into_iter().map(|(n, d)| (n, directional(d)));
        // Every fifth light in each scene, others in the next.
        let lights = lights.chain(spots(&scene, &camera)).chain(points(&scene, &camera)).skip(i % 5).step_by(5);
        views.extend(lights.map(|(light_name, light)| View {
            name: format!("{name} / {light_name}"),
            scene: scene.clone(),
            camera,
            light,
        }));
    }
    let checked: usize = views.par_iter().enumerate().map(|(turn, v)| check(v, turn)).sum();
    assert!(checked > 5 * views.len(), "{checked} masks of {} views", views.len());
}

/// Surfaces whose numbers nobody should give, and enough usable ones.
struct Hostile {
    position: Vec<[f32; 3]>,
    normal: Vec<[f32; 3]>,
    triangle: Vec<i32>,
    size: [u32; 2],
}

impl Hostile {
    fn new(random: &mut Random, size: [u32; 2]) -> Self {
        let count = (size[0] * size[1]) as usize;
        let odd = [0.0, -0.0, 1e30, -1e30, f32::MAX, f32::MIN, f32::MIN_POSITIVE, 1e-42, f32::NAN, f32::INFINITY, 1.0];
        let mut vector = |odd_in: i64| {
            let mut v = random.vector(-1.5, 1.5).as_vec3().to_array();
            if random.integer(0, odd_in) == 0 {
                v[random.integer(0, 3) as usize] = odd[random.integer(0, odd.len() as i64) as usize];
            }
            v
        };
        let position = (0..count).map(|_| vector(6)).collect();
        let normal = (0..count)
            .map(|i| match i % 7 {
                // Edge on to a light along y, and of no length.
                0 => [1.0, 0.0, 0.0],
                1 => [0.0; 3],
                2 => vector(2),
                _ => {
                    let n = glam::Vec3::from_array(vector(1 << 40)).normalize();
                    (if n.y < 0.0 { -n } else { n }).to_array()
                }
            })
            .collect();
        let triangle = (0..count).map(|i| if i % 11 == 3 { -1 } else { i as i32 }).collect();
        Self { position, normal, triangle, size }
    }
    fn surfaces(&self) -> Surfaces<'_> {
        let Self { position, normal, triangle, size, .. } = self;
        Surfaces { size: *size, origin: DVec3::new(0.1, -0.2, 0.3), position, normal, triangle, instance: triangle }
    }
}

/// Matrices with w through zero, of no rank, huge and tiny, besides usable ones; of one map and of several.
fn hostile_maps(random: &mut Random) -> Vec<Parameterization> {
    let rows = |rows: [[f64; 4]; 4]| DMat4::from_cols_array_2d(&rows).transpose();
    let down = rows([[0.7, 0.0, 0.1, 0.0], [0.0, 0.0, 0.6, 0.1], [0.0, -0.4, 0.0, 0.5], [0.0, 0.0, 0.0, 1.0]]);
    let w_is = |row: [f64; 4]| rows([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -0.3, 0.0, 0.5], row]);
    let mut any = || DMat4::from_cols_array(&std::array::from_fn(|_| random.number(-1.0, 1.0)));
    let mut all = vec![
        one_map(down),
        one_map(w_is([0.0, -1.0, 0.0, 0.0])),
        one_map(w_is([0.3, -1e-9, 0.2, 1e-12])),
        one_map(w_is([0.0, -1.0, 0.0, -5.0])),
        one_map(DMat4::ZERO),
        one_map(down * 1e200),
        one_map(down * 1e-300),
        one_map(down * f64::MAX),
        one_map(DMat4::from_scale(DVec3::splat(1e-3)) * down),
        one_map(rows([[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.5], [0.0, 0.0, 0.0, 1.0]])),
        maps(&[down, w_is([0.0, -1.0, 0.0, 0.0]), down * 0.5]),
    ];
    all.extend((0..6).map(|_| one_map(any())));
    let halves = [DVec4::new(1.0, 0.0, 0.0, 0.0), DVec4::new(-1.0, 0.0, 0.0, 0.1)];
    let part = |f| Partition { region: Region::new(&[f]), ..Partition::of_matrix(down) };
    let mut divided = Parameterization::of_partitions(halves.map(part).to_vec(), [1; 2]);
    divided.selection = Selection::Containment;
    all.push(divided);
    all.push(Parameterization::of_partitions(vec![part(halves[0])], [1; 2]));
    let mut log = one_map(w_is([0.2, -1.0, 0.0, 1.2]));
    log.partitions[0].post_warp = PostWarp::Log { scale: 0.7, offset: -0.1 };
    all.push(log);
    all
}

#[test]
fn hostile_receivers_maps_and_biases_have_the_same_answer_either_way() {
    let camera = Camera::look_at(DVec3::new(0.3, 3.0, 2.0), DVec3::ZERO, DVec3::Y, 0.9, 1.0, 0.1, 50.0).unwrap();
    let (above, down) = (DVec3::new(0.2, 1.0, -0.1), DVec3::new(0.1, -1.0, 0.2));
    let lights = [
        Light::Directional(DirectionalLight::new(DVec3::NEG_Y).unwrap()),
        Light::Spot(SpotLight::new(above, down, 1.4, 1e38).unwrap()),
        Light::Point(PointLight::new(above, 1e38).unwrap()),
    ];
    let huge = [
        Bias { ndc: f64::MAX, ..Bias::default() },
        Bias { world: 1e300, slope: 1e300, ..Bias::default() },
        Bias { texels: -1e300, slope_limit: 1e300, ..Bias::default() },
    ];
    let biases = [&biases()[..], &huge].concat();
    let mut random = Random(11);
    let (mut lit, mut dark, mut partly) = (0, 0, 0);
    let mut turn = 0;
    for p in hostile_maps(&mut random) {
        for light in &lights {
            for (bias, size) in biases.iter().zip([[64, 3], [1, 5], [63, 2], [65, 2], [200, 1]].into_iter().cycle()) {
                turn += 1;
                let hostile = Hostile::new(&mut random, size);
                let resolution = [[1, 1], [1, 7], [5, 3], [64, 64]][turn % 4];
                let stored = |random: &mut Random| match turn % 3 {
                    // Empty.
                    0 => 1.0,
                    _ => [0.0, 1.0, random.number(0.0, 1.0) as f32][random.integer(0, 3) as usize],
                };
                let texels = (resolution[0] * resolution[1]) as usize * p.partitions.len();
                let maps: Vec<f32> = (0..texels).map(|_| stored(&mut random)).collect();
                for text in [FILTERS[turn % FILTERS.len()], "nearest", "bilinear", "pcf:size=64"] {
                    let blend = if turn % 2 == 0 { 0.4 } else { 0.0 };
                    let how = How { bias: *bias, filter: text, blend, stored: Stored::FRONT };
                    let settings = how.settings(resolution, hostile.size);
                    let surfaces = hostile.surfaces();
                    let found = look_up(&maps, hostile.surfaces(), &camera, light, &p, &settings, &Progress::new());
                    // A sum of matrix entries at the limit of f64.
                    let Ok(found) = found else {
                        assert!(p.partitions[0].shadow_clip_from_world.to_cols_array().iter().any(|x| x.abs() > 1e300));
                        continue;
                    };
                    let expected = one_by_one(&maps, &surfaces, &camera, light, &p, &settings);
                    assert_eq!(first_difference(&found, &expected), None, "{p:?} {light:?} {settings:?}");
                    for (i, value) in found.data.iter().enumerate() {
                        assert_eq!(value.is_nan(), hostile.triangle[i] < 0, "{p:?} {light:?} {settings:?}");
                        // Weights of 65 texels sum to 1 up to a unit of single precision.
                        assert!(value.is_nan() || (0.0..=1.0 + f32::EPSILON).contains(value), "{value}");
                        if found.partition[i] >= 0 {
                            *[&mut lit, &mut dark, &mut partly][match *value {
                                0.0 => 1,
                                1.0 => 0,
                                _ => 2,
                            }] += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(lit > 1000 && dark > 1000 && partly > 1000, "{lit} {dark} {partly}");
}

#[test]
fn a_change_of_one_texel_is_seen() {
    let down = DMat4::from_cols_array_2d(&[
        [0.5, 0.0, 0.0, 0.0],
        [0.0, 0.0, -0.4, 0.0],
        [0.0, 0.5, 0.0, 0.0],
        [0.0, 0.0, 0.5, 1.0],
    ]);
    let (p, light) = (one_map(down), directional(DVec3::NEG_Y));
    let camera = Camera::look_at(DVec3::new(0.3, 3.0, 2.0), DVec3::ZERO, DVec3::Y, 0.9, 1.0, 0.1, 50.0).unwrap();
    let position: Vec<[f32; 3]> =
        (0..256).map(|i| [(i % 16) as f32 * 0.1 - 0.75, 0.0, (i / 16) as f32 * 0.1 - 0.75]).collect();
    let (normal, triangle) = (vec![[0.0, 1.0, 0.0]; 256], vec![0; 256]);
    let surfaces = Surfaces {
        size: [16; 2],
        origin: DVec3::ZERO,
        position: &position,
        normal: &normal,
        triangle: &triangle,
        instance: &triangle,
    };
    for text in FILTERS {
        let how = How { bias: Bias::default(), filter: text, blend: 0.0, stored: Stored::FRONT };
        let settings = how.settings([8; 2], [16; 2]);
        let mut maps = vec![1.0; 64];
        let found = look_up(&maps, surfaces, &camera, &light, &p, &settings, &Progress::new()).unwrap();
        assert_eq!(first_difference(&found, &one_by_one(&maps, &surfaces, &camera, &light, &p, &settings)), None);
        maps[3 * 8 + 4] = 0.1;
        let changed = one_by_one(&maps, &surfaces, &camera, &light, &p, &settings);
        assert!(first_difference(&found, &changed).is_some(), "{text}");
    }
}
