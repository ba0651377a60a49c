//! The CPU shadow mask: closed forms of bias, filter and limits; acne where it must be and nowhere else.

use glam::{DMat4, DVec3};
use shadowlab::parameterization::Parameterization;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::cpu::lookup::{Comparison, MapLookup};
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::scene::{DirectionalLight, PointLight, SpotLight};
use shadowlab::{Camera, Error, Light, Progress, Scene};

use crate::support::cpu::*;

/// The orthographic map of a directional light: the square of half side `radius` around `target`, depth 4 radii.
fn ortho(direction: DVec3, target: DVec3, radius: f64) -> DMat4 {
    let direction = direction.normalize();
    let up = direction.any_orthonormal_vector();
    let view = glam::dcamera::rh::view::look_to_mat4(target - 2.0 * radius * direction, direction, up);
    glam::dcamera::rh::proj::directx::orthographic(-radius, radius, -radius, radius, 0.0, 4.0 * radius) * view
}

fn directional(direction: DVec3) -> Light {
    Light::Directional(DirectionalLight::new(direction).unwrap())
}

/// A square of half side `s` across the y axis at height `y`.
fn level(s: f64, y: f64) -> [[DVec3; 3]; 2] {
    let p = |x: f64, z: f64| DVec3::new(x * s, y, z * s);
    [[p(-1.0, -1.0), p(1.0, -1.0), p(1.0, 1.0)], [p(-1.0, -1.0), p(1.0, 1.0), p(-1.0, 1.0)]]
}

/// Looks down on the origin from a little off the vertical.
fn from_above() -> Camera {
    Camera::look_at(DVec3::new(0.3, 6.0, 0.2), DVec3::ZERO, DVec3::Z, 0.8, 1.0, 0.1, 50.0).unwrap()
}

const SIZE: [u32; 2] = [96, 96];

fn mask_of(
    scene: &Scene,
    camera: &Camera,
    light: &Light,
    p: &Parameterization,
    resolution: u32,
    bias: Bias,
    filter: Filter,
) -> Vec<f32> {
    let settings =
        MaskSettings { resolution: [resolution; 2], size: SIZE, bias, filter, blend: 0.0, stored: Stored::default() };
    CpuRenderer::new().shadow_mask(scene, camera, light, p, &settings, &Progress::new()).unwrap().data
}

/// How many pixels of a mask are lit, partly lit, in shadow.
fn count(mask: &[f32]) -> [usize; 3] {
    let n = |f: fn(f32) -> bool| mask.iter().filter(|x| f(**x)).count();
    [n(|x| x == 1.0), n(|x| x > 0.0 && x < 1.0), n(|x| x == 0.0)]
}

/// The bias that only covers rounding: z of the map and of the receiver each have a few roundings to f32.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

#[test]
fn a_plane_has_acne_without_bias_and_none_under_the_slope() {
    // A floor wider than what the camera sees, so that no map texel is empty.
    let scene = triangles(&level(6.0, 0.0));
    for direction in [DVec3::new(0.3, -1.0, 0.2), DVec3::new(-2.0, -1.0, 0.7), DVec3::new(5.0, -1.0, 3.0)] {
        let light = directional(direction);
        let warp = DMat4::from_cols_array(&[1., 0., 0., 0., 0., 1.25, 0., 0.75, 0., 0., 1., 0., 0., 0.75, 0., 1.25]);
        let maps = [(ortho(direction, DVec3::ZERO, 7.0), false), (warp * ortho(direction, DVec3::ZERO, 9.0), true)];
        for (matrix, warped) in maps {
            let p = one_map(matrix);
            for filter in [Filter::Nearest, Filter::Bilinear] {
                let draw = |bias| count(&mask_of(&scene, &from_above(), &light, &p, 64, bias, filter));
                let [lit, ..] = draw(Bias::NONE);
                let all = (SIZE[0] * SIZE[1]) as usize;
                assert!(lit < all * 3 / 4, "without bias {lit} of {all} are lit: no acne to remove");
                let slope = Bias { slope: 1.0, ndc: ROUNDING, ..Bias::NONE };
                assert_eq!(draw(slope), [all, 0, 0], "{direction} {filter:?}");
                assert_eq!(draw(Bias::default()), [all, 0, 0], "{direction} {filter:?}, default");
                // Tight: nine tenths of it are not enough; a limit of nothing is no slope at all, but for what w adds.
                let [lit, ..] = draw(Bias { slope: 0.9, ..slope });
                assert!(lit < all, "{direction} {filter:?}: slope 0.9 suffices");
                let [none, ..] = draw(Bias { slope: 0.0, ..slope });
                let [limited, ..] = draw(Bias { slope_limit: 0.0, ..slope });
                assert!(if warped { limited > none } else { limited == none }, "{direction} {filter:?}: {limited}");
            }
        }
    }
}

#[test]
fn a_spot_lights_a_plane_without_acne() {
    let scene = triangles(&level(6.0, 0.0));
    let position = DVec3::new(2.0, 3.0, -1.0);
    let direction = -position;
    let spot = |cone: f64, range: f64| Light::Spot(SpotLight::new(position, direction, cone, range).unwrap());
    let view = glam::dcamera::rh::view::look_to_mat4(position, direction.normalize(), DVec3::X);
    let p = one_map(glam::dcamera::rh::proj::directx::perspective(1.2, 1.0, 0.5, 30.0) * view);
    let mask = mask_of(&scene, &from_above(), &spot(1.2, 30.0), &p, 128, Bias::default(), Filter::Nearest);
    let g = CpuRenderer::new().gbuffer(&scene, &from_above(), SIZE, &Progress::new()).unwrap();
    let narrow = mask_of(&scene, &from_above(), &spot(0.6, 3.9), &p, 128, Bias::default(), Filter::Nearest);
    for i in 0..mask.len() {
        let from_light = DVec3::from_array(g.position[i].map(f64::from)) + g.origin - position;
        let angle = from_light.angle_between(direction);
        assert_eq!(mask[i], f32::from(u8::from(angle < 0.6)), "pixel {i}");
        assert_eq!(narrow[i], f32::from(u8::from(angle < 0.3 && from_light.length() < 3.9)), "pixel {i}");
    }
    assert!(count(&mask)[2] > 500 && count(&narrow)[0] > 200);
    // From below the floor, which faces the eye: turned away from the light.
    let below = Camera::look_at(DVec3::new(0.3, -6.0, 0.2), DVec3::ZERO, DVec3::Z, 0.8, 1.0, 0.1, 50.0).unwrap();
    let under = mask_of(&scene, &below, &spot(1.2, 30.0), &p, 128, Bias::default(), Filter::Nearest);
    assert_eq!(count(&under), [0, 0, under.len()]);
    let point = Light::Point(PointLight::new(position, 3.9).unwrap());
    let by_range = mask_of(&scene, &from_above(), &point, &p, 128, Bias::default(), Filter::Nearest);
    assert!(count(&by_range)[2] > 500);
}

#[test]
fn a_blocker_throws_its_outline() {
    // A square of half side 0.5 at height 1 under a slanted light: its shadow is the square moved by (0.5, 0.25).
    let corners: Vec<_> = level(6.0, 0.0).into_iter().chain(level(0.5, 1.0)).collect();
    let scene = triangles(&corners);
    let direction = DVec3::new(0.5, -1.0, 0.25);
    let p = one_map(ortho(direction, DVec3::ZERO, 8.0));
    let g = CpuRenderer::new().gbuffer(&scene, &from_above(), SIZE, &Progress::new()).unwrap();
    let texel = 16.0 / 512.0;
    for filter in [Filter::Nearest, Filter::Bilinear] {
        let mask = mask_of(&scene, &from_above(), &directional(direction), &p, 512, Bias::default(), filter);
        let mut in_shadow = 0;
        for (i, &light) in mask.iter().enumerate() {
            let at = DVec3::from_array(g.position[i].map(f64::from)) + g.origin;
            let from_edge = (at.x - 0.5).abs().max((at.z - 0.25).abs()) - 0.5;
            // A texel's parallelogram on the floor is up to 1.2 times its side; two of them for the filter.
            if g.triangle[i] < 2 && from_edge.abs() > 2.5 * texel {
                assert_eq!(light, f32::from(u8::from(from_edge > 0.0)), "{at}");
                in_shadow += usize::from(from_edge < 0.0);
            }
        }
        assert!(in_shadow > 100);
    }
}

#[test]
fn each_part_of_the_bias_has_its_unit() {
    // A blocker everywhere, at height 0.1 over the floor, seen from between them: the floor alone is in view.
    let corners: Vec<_> = level(6.0, 0.0).into_iter().chain(level(6.0, 0.1)).collect();
    let scene = triangles(&corners);
    let eye = DVec3::new(0.0, 0.05, 0.0);
    let camera = Camera::look_at(eye, DVec3::new(0.0, 0.0, 0.001), DVec3::Z, 0.8, 1.0, 0.001, 5.0).unwrap();
    let direction = DVec3::new(0.6, -0.8, 0.0);
    let (radius, resolution) = (8.0, 128);
    let p = one_map(ortho(direction, DVec3::ZERO, radius));
    let lit = |bias: Bias| {
        let c = count(&mask_of(&scene, &camera, &directional(direction), &p, resolution, bias, Filter::Nearest));
        assert!(c[0] == 0 || c[2] == 0, "{bias:?} lights a part: {c:?}");
        c[0] > 0
    };
    // Along the ray the sheets are 0.1 / 0.8 apart; a nearest lookup is off by up to half a texel of slope, which is
    // 0.5 * (16 / 128) * tan * sqrt(2) = 0.066 along the ray here. In NDC the map is 4 radii deep.
    let (apart, slack) = (0.125, 0.07);
    for (unit, part) in [
        (1.0, (|x| Bias { world: x, ..Bias::NONE }) as fn(f64) -> Bias),
        (2.0 * radius / f64::from(resolution), |x| Bias { texels: x, ..Bias::NONE }),
        (4.0 * radius, |x| Bias { ndc: x, ..Bias::NONE }),
    ] {
        assert!(!lit(part((apart - slack) / unit)));
        assert!(lit(part((apart + slack) / unit)));
    }
    // The limit of the slope is in texels, along the ray.
    let texel = 2.0 * radius / f64::from(resolution);
    let steep = |limit| Bias { slope: 1000.0, slope_limit: limit, ..Bias::NONE };
    assert!(!lit(steep((apart - slack) / texel)));
    assert!(lit(steep((apart + slack) / texel)));
    assert!(lit(steep(f64::INFINITY)));
}

#[test]
fn the_limit_holds_a_plane_seen_edge_on() {
    // Depth -y / 2 + 1 / 2 over a map of 16 texels of 1/8; the normal is exactly across the light, so the slope is infinite.
    let down = DVec3::new(0.0, -1.0, 0.0);
    let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, -0.5, 0.0, 0.5], [0.0, 0.0, 0.0, 1.0]];
    let matrix = DMat4::from_cols_array_2d(&rows).transpose();
    let z = |normal: DVec3, bias: Bias| {
        let p = one_map(matrix);
        let lookup = MapLookup::new(
            &p.partitions[0],
            &directional(down),
            DVec3::ZERO,
            [16; 2],
            bias,
            Filter::Nearest,
            Stored::default(),
        )
        .unwrap();
        match lookup.compare_at(DVec3::new(0.01, -0.6, 0.02), normal) {
            Comparison::At(reference) => lookup.depth_at(&reference, reference.p_texel),
            Comparison::Lit => panic!("{bias:?} lights a receiver without a look at the map"),
        }
    };
    let limited = |limit| Bias { slope: 1.0, slope_limit: limit, ..Bias::NONE };
    for normal in [DVec3::X, DVec3::new(1.0, 1e-9, 0.0), DVec3::new(0.6, 0.0, 0.8)] {
        assert_eq!(z(normal, Bias::NONE), 0.8);
        for texels in [0.0, 1.0, 4.0] {
            // A texel along the ray is 1/8 of the world, 1/16 of depth.
            assert!((z(normal, limited(texels)) - (0.8 - texels / 16.0)).abs() < 1e-15, "{normal}, {texels}");
        }
        // Even where nothing holds it, it does not leave the map's depth.
        assert_eq!(z(normal, limited(f64::INFINITY)), 0.0);
    }
    assert_eq!(z(DVec3::Y, limited(4.0)), 0.8);
}

#[test]
fn outside_the_map_is_lit() {
    let corners: Vec<_> = level(6.0, 0.0).into_iter().chain(level(5.9, 1.0)).collect();
    let scene = triangles(&corners);
    let camera =
        Camera::look_at(DVec3::new(0.0, 0.9, 0.0), DVec3::new(0.1, 0.0, 0.0), DVec3::Z, 2.0, 1.0, 0.01, 50.0).unwrap();
    let down = DVec3::new(0.0, -1.0, 0.0);
    let draw =
        |m: DMat4| mask_of(&scene, &camera, &directional(down), &one_map(m), 64, Bias::default(), Filter::Nearest);
    let g = CpuRenderer::new().gbuffer(&scene, &camera, SIZE, &Progress::new()).unwrap();
    let whole = draw(ortho(down, DVec3::ZERO, 8.0));
    let part = draw(ortho(down, DVec3::ZERO, 0.5));
    for i in 0..whole.len() {
        if g.triangle[i] < 0 {
            assert!(whole[i].is_nan());
            continue;
        }
        let at = DVec3::from_array(g.position[i].map(f64::from)) + g.origin;
        if at.x.abs().max(at.z.abs()) < 5.5 {
            assert_eq!(whole[i], 0.0);
        }
        let from_border = at.x.abs().max(at.z.abs()) - 0.5;
        if from_border.abs() > 1e-5 {
            assert_eq!(part[i], f32::from(u8::from(from_border > 0.0)), "{at}");
        }
    }
    assert!(count(&part)[0] > 500 && count(&part)[2] > 500);
    // The floor nearer than the near plane: lit. The floor beyond the far plane, the roof within: in shadow.
    let depth = |near: f64, far: f64| {
        DMat4::from_cols_array(&[
            0.1,
            0.0,
            0.0,
            0.0,
            0.0,
            0.0,
            -1.0 / (far - near),
            0.0,
            0.0,
            0.1,
            0.0,
            0.0,
            0.0,
            0.0,
            (2.0 - near) / (far - near),
            1.0,
        ])
    };
    let inner = |mask: Vec<f32>| mask[48 * 96 + 48];
    assert_eq!(inner(draw(depth(0.0, 4.0))), 0.0);
    assert_eq!(inner(draw(depth(2.5, 4.0))), 1.0);
    assert_eq!(inner(draw(depth(0.5, 1.5))), 0.0);
    // Roof and floor beyond the far plane: the map is empty, and an empty texel is lit.
    assert_eq!(inner(draw(depth(0.1, 0.5))), 1.0);
    // w <= 0 everywhere.
    assert_eq!(inner(draw(depth(0.0, 4.0) * -1.0)), 1.0);
}

#[test]
fn the_filter_weighs_as_written() {
    let identity = maps(&[DMat4::IDENTITY]).partitions.remove(0);
    let light = directional(DVec3::Z);
    // Four texels, of which one is lit; the receiver at z = 0.5 faces the light.
    let map = [0.9f32, 0.1, 0.1, 0.1];
    let at = |filter, u: f64, v: f64| {
        let lookup =
            MapLookup::new(&identity, &light, DVec3::ZERO, [2, 2], Bias::NONE, filter, Stored::default()).unwrap();
        lookup.light(&map, DVec3::new(2.0 * u - 1.0, 1.0 - 2.0 * v, 0.5), DVec3::NEG_Z)
    };
    assert_eq!(at(Filter::Nearest, 0.49, 0.49), 1.0);
    assert_eq!(at(Filter::Nearest, 0.51, 0.49), 0.0);
    assert_eq!(at(Filter::Nearest, 0.49, 0.51), 0.0);
    assert_eq!(at(Filter::Bilinear, 0.25, 0.25), 1.0);
    assert_eq!(at(Filter::Bilinear, 0.0, 0.0), 1.0);
    assert_eq!(at(Filter::Bilinear, 0.5, 0.5), 0.25);
    assert_eq!(at(Filter::Bilinear, 0.375, 0.25), 0.75);
    assert_eq!(at(Filter::Bilinear, 0.375, 0.625), 0.75 * 0.25);
    assert_eq!(at(Filter::Bilinear, 1.0, 1.0), 0.0);
    // Half a texel outside: lit, whatever the map says.
    assert_eq!(at(Filter::Nearest, 1.01, 0.9), 1.0);
}

#[test]
fn each_pixel_uses_the_map_of_its_depth() {
    let corners: Vec<_> = level(6.0, 0.0).into_iter().chain(level(5.9, 1.0)).collect();
    let scene = triangles(&corners);
    let camera =
        Camera::look_at(DVec3::new(0.0, 0.5, -4.0), DVec3::new(0.0, 0.3, 0.0), DVec3::Y, 0.8, 1.0, 0.01, 50.0).unwrap();
    let down = DVec3::new(0.0, -1.0, 0.0);
    let sees = ortho(down, DVec3::ZERO, 8.0);
    // The second map looks elsewhere, so its receivers are lit.
    let mut p = maps(&[sees, ortho(down, DVec3::X * 100.0, 8.0)]);
    p.partitions[0].eye_depth = [0.0, 4.0];
    p.partitions[1].eye_depth = [4.0, 50.0];
    let mask = mask_of(&scene, &camera, &directional(down), &p, 64, Bias::default(), Filter::Nearest);
    let g = CpuRenderer::new().gbuffer(&scene, &camera, SIZE, &Progress::new()).unwrap();
    let mut seen = [0, 0];
    for i in 0..mask.len() {
        let at = DVec3::from_array(g.position[i].map(f64::from)) + g.origin;
        if g.triangle[i] >= 0 && g.triangle[i] < 2 && at.x.abs().max(at.z.abs()) < 5.5 {
            let near = camera.depth_of(at) <= 4.0;
            assert_eq!(mask[i], f32::from(u8::from(!near)));
            seen[usize::from(near)] += 1;
        }
    }
    assert!(seen[0] > 100 && seen[1] > 100);
}

#[test]
fn bad_settings_are_named() {
    let scene = triangles(&level(6.0, 0.0));
    let light = directional(DVec3::NEG_Y);
    let good = MaskSettings {
        resolution: [16; 2],
        size: [16; 2],
        bias: Bias::default(),
        filter: Filter::Nearest,
        blend: 0.0,
        stored: Stored::default(),
    };
    let name = |p: &Parameterization, settings: MaskSettings| match CpuRenderer::new().shadow_mask(
        &scene,
        &from_above(),
        &light,
        p,
        &settings,
        &Progress::new(),
    ) {
        Err(Error::InvalidArgument { name, .. }) => name.into_owned(),
        other => panic!("{other:?}"),
    };
    let p = one_map(ortho(DVec3::NEG_Y, DVec3::ZERO, 8.0));
    let biased = |bias| MaskSettings { bias, ..good };
    assert_eq!(name(&p, MaskSettings { resolution: [0, 4], ..good }), "resolution");
    assert_eq!(name(&p, MaskSettings { size: [4, 0], ..good }), "size");
    assert_eq!(name(&p, biased(Bias { world: f64::NAN, ..Bias::NONE })), "bias.world");
    assert_eq!(name(&p, biased(Bias { slope: -1.0, ..Bias::NONE })), "bias.slope");
    assert_eq!(name(&p, biased(Bias { slope_limit: f64::NAN, ..Bias::NONE })), "bias.slope_limit");
    assert_eq!(name(&maps(&[]), good), "parameterization");
    assert_eq!(name(&one_map(DMat4::NAN), good), "shadow_clip_from_world");
}
