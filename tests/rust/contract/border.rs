//! The border of a map: read by filters, so as complete as the rest.

use glam::{DMat4, DVec2, DVec3};
use shadowlab::fit::BORDER_TEXELS;
use shadowlab::parameterization::{Partition, PostWarp};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Filter, Renderer, Stored};
use shadowlab::scene::{DirectionalLight, SpotLight};
use shadowlab::techniques::{specs, technique};
use shadowlab::{Camera, Light, Progress, Scene};

use crate::support::by_body::by_body;
use crate::support::cpu::{reach_texels, triangle_mesh};
use crate::support::views::{picture_of, shaded_samples};

const RESOLUTION: u32 = 32;
/// Of the casters, far above all that the camera sees.
const HEIGHT: f64 = 50.0;

fn quad(corners: [DVec3; 4]) -> Scene {
    let [a, b, c, d] = corners;
    Scene::from_mesh(triangle_mesh(&[[a, b, c], [a, c, d]])).expect("a quad")
}

/// A level square around a point.
fn level(middle: DVec3, half: f64) -> Scene {
    let corner = |x: f64, z: f64| middle + DVec3::new(x, 0.0, z) * half;
    quad([corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)])
}

/// Where the ray of a place of a map, in NDC, meets the casters' height.
fn at_height(map: &Partition, ndc: DVec2) -> DVec3 {
    let matrix = map.shadow_clip_from_world;
    let world_from_clip = matrix.inverse();
    let ndc = match &map.post_warp {
        PostWarp::None => ndc,
        PostWarp::Rectilinear(warp) => warp.before(ndc),
        PostWarp::Log { scale, offset } => {
            // y of the matrix is a constant and another over w.
            let (y, w) = (matrix.row(1), matrix.row(3));
            let constant = y.truncate().dot(w.truncate()) / w.truncate().length_squared();
            let inverse_w = ((offset - ndc.y) / scale).exp();
            DVec2::new(ndc.x, constant + (y.w - constant * w.w) * inverse_w)
        }
    };
    let [a, b] = [0.25, 0.75].map(|z| DMat4::project_point3(&world_from_clip, ndc.extend(z)));
    a + (b - a) * ((HEIGHT - a.y) / (b.y - a.y))
}

#[test]
fn a_caster_seen_by_a_border_texel_alone_is_in_the_map() {
    // One far aside at the height of the others, so that they change neither the scene's box nor what receives.
    let ground = level(DVec3::ZERO, 90.0).joined(&level(DVec3::new(80.0, HEIGHT, 80.0), 1.0)).expect("a scene");
    let camera =
        Camera::look_at(DVec3::new(0.0, 6.0, 6.0), DVec3::ZERO, DVec3::Y, 0.6, 1.0, 4.0, 14.0).expect("a camera");
    let sun = Light::Directional(DirectionalLight::new(DVec3::new(0.0, -1.0, -0.2)).expect("a light"));
    let lamp = SpotLight::new(DVec3::new(0.0, 70.0, 0.5), DVec3::NEG_Y, 0.9, 200.0).expect("a light");
    let step = 2.0 / f64::from(RESOLUTION);
    let edge = 1.0 - 0.5 * step;
    let inset = 1.0 - f64::from(BORDER_TEXELS) * step;
    // Through the middle of a texel, as `edge`.
    let along = 1.5 * step;
    for spec in specs() {
        for light in [sun, Light::Spot(lamp)] {
            if !spec.lights.serves(&light) {
                continue;
            }
            // What the camera sees is the ground.
            let samples = shaded_samples(&ground, &camera, &light, &picture_of(&ground, &camera));
            for t in [technique(spec.name, &[]).expect("a technique"), by_body(spec.name)] {
                let map = |scene: &Scene| {
                    t.parameterize_seen(scene, &camera, &light, [RESOLUTION; 2], Some(&samples)).expect("a map")
                };
                let before = map(&ground);
                let middles = [(edge, along), (-edge, along), (along, edge), (along, -edge)].map(DVec2::from);
                for (k, middle) in (0..before.partitions.len()).flat_map(|k| middles.map(|middle| (k, middle))) {
                    let what = format!("{} {} map {k} at {middle}", spec.name, light.kind());
                    // A quarter of a texel to either side of the texel's middle.
                    let corner =
                        |x: f64, y: f64| at_height(&before.partitions[k], middle + DVec2::new(x, y) * 0.25 * step);
                    let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
                    let caster = quad(corners);
                    let scene = ground.joined(&caster).expect("a scene");
                    let p = map(&scene);
                    for q in corners {
                        let (ndc, w) = p.partitions[k].project(q);
                        let across = ndc.truncate().abs().max_element();
                        assert!(
                            w > 0.0 && (inset..1.0).contains(&across),
                            "{what}: the corner at {ndc} is in the border"
                        );
                    }
                    let maps = CpuRenderer::new()
                        .depth_maps(&scene, &p, [RESOLUTION; 2], Stored::default(), &Progress::new())
                        .expect("maps");
                    let (expected, _) = p.partitions[k].project(at_height(&before.partitions[k], middle));
                    let texel = (DVec2::new(expected.x, -expected.y) * 0.5 + 0.5) * f64::from(RESOLUTION);
                    let n = RESOLUTION as usize;
                    let depth = maps.data[(k * n + texel.y as usize) * n + texel.x as usize];
                    // Rounding of a renderer in f32.
                    let rounding = 64.0 * f64::from(f32::EPSILON);
                    assert!((f64::from(depth) - expected.z).abs() < rounding, "{what}: {depth} and {expected}");
                    assert!((0.0..0.5).contains(&depth), "{what}: {depth}");
                }
            }
        }
    }
}

#[test]
fn no_filter_reads_beyond_the_border() {
    for (name, filter) in Filter::PLAIN {
        assert!(reach_texels(filter) <= f64::from(BORDER_TEXELS), "{name}");
    }
}
