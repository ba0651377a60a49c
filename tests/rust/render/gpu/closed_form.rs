//! The gpu renderer against closed forms, and what it answers to awkward input.

use std::sync::Arc;

use glam::{DAffine3, DMat4, DVec3};
use shadowlab::render::gpu::{GpuRenderer, adapters};
use shadowlab::render::{Bias, Filter, MaskSettings, Renderer, Stored};
use shadowlab::scene::{DirectionalLight, Instance, SpotLight};
use shadowlab::{Camera, Error, Light, Mesh, Progress, Scene};

use crate::support::gpu::{camera_above, renderer, single_map};

/// Depths are z / w in single precision, of numbers that went through a dozen operations.
const DEPTH_TOLERANCE: f64 = 16.0 * f32::EPSILON as f64;

/// A quad in the plane y = slope * x, 2 x 2 in x and z.
fn tilted_quad(slope: f64) -> Scene {
    let vertex = |x: f64, z: f64| [x, slope * x, z];
    let vertices = [vertex(-1.0, -1.0), vertex(1.0, -1.0), vertex(1.0, 1.0), vertex(-1.0, 1.0)];
    Scene::from_mesh(Mesh::new(&vertices, &[[0, 1, 2], [0, 2, 3]]).unwrap()).unwrap()
}

/// A square over [-half, half]² at height y, one of its triangles turned over.
fn square(half: f64, y: f64) -> Mesh {
    let vertices = [[-half, y, -half], [half, y, -half], [half, y, half], [-half, y, half]];
    Mesh::new(&vertices, &[[0, 1, 2], [0, 3, 2]]).unwrap()
}

/// Looks straight down: NDC x = x / half, NDC y = -z / half, depth 0 at y = top and 1 at y = bottom.
fn downwards(half: f64, top: f64, bottom: f64) -> DMat4 {
    DMat4::from_cols_array_2d(&[
        [1.0 / half, 0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0 / (bottom - top), 0.0],
        [0.0, -1.0 / half, 0.0, 0.0],
        [0.0, 0.0, -top / (bottom - top), 1.0],
    ])
}

#[test]
fn a_tilted_plane_has_its_depth_at_every_texel() {
    let Some(renderer) = renderer() else { return };
    let (scene, n) = (tilted_quad(0.5), 100u32);
    let maps = renderer
        .depth_maps(&scene, &single_map(downwards(1.25, 2.0, -2.0)), [n; 2], Stored::default(), &Progress::new())
        .unwrap();
    assert_eq!((maps.layers, maps.size, maps.data.len()), (1, [n; 2], (n * n) as usize));
    for j in 0..n {
        for i in 0..n {
            let at = |k: u32| 1.25 * (2.0 * (f64::from(k) + 0.5) / f64::from(n) - 1.0);
            let (x, z) = (at(i), at(j));
            let depth = f64::from(maps.data[(j * n + i) as usize]);
            // The quad's edges run along texel borders, 0.8 of the map: the picture has no doubtful texel.
            let expected = if x.abs() < 1.0 && z.abs() < 1.0 { (2.0 - 0.5 * x) / 4.0 } else { 1.0 };
            assert!((depth - expected).abs() < DEPTH_TOLERANCE, "({i}, {j}): {depth} for {expected}");
        }
    }
}

#[test]
fn every_scale_and_place_gives_the_same_map() {
    let Some(renderer) = renderer() else { return };
    let (scene, clip) = (tilted_quad(0.5), downwards(1.25, 2.0, -2.0));
    let near = renderer.depth_maps(&scene, &single_map(clip), [64; 2], Stored::default(), &Progress::new()).unwrap();
    for (scale, place) in [(2f64.powi(-20), DVec3::ZERO), (2f64.powi(30), DVec3::new(5e5, 4e6, 0.0) * 2f64.powi(30))] {
        let map = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), Default::default(), place);
        let moved = scene.transformed(&map).unwrap();
        let clip = clip * DMat4::from(map.inverse());
        let far = renderer.depth_maps(&moved, &single_map(clip), [64; 2], Stored::default(), &Progress::new()).unwrap();
        assert_eq!(far.data, near.data);
    }
}

#[test]
fn clipping_keeps_what_lies_between_near_and_far() {
    let Some(renderer) = renderer() else { return };
    // y from -1 to 1 over the quad; the map keeps 0.25 <= y <= 0.5: a quarter of the x range to the right of 0.25.
    let p = single_map(downwards(1.0, 0.5, 0.25));
    let maps = renderer.depth_maps(&tilted_quad(1.0), &p, [64; 2], Stored::default(), &Progress::new()).unwrap();
    let covered = maps.data.iter().filter(|&&z| z < 1.0).count();
    assert_eq!(covered, 64 * 8);
}

#[test]
fn triangles_across_the_eye_plane_are_clipped() {
    let Some(renderer) = renderer() else { return };
    // Ground 2 below an eye that looks along it: everything below the horizon, nothing above, vertices behind the eye.
    let scene = Scene::from_mesh(square(1000.0, -2.0)).unwrap();
    let camera = Camera::look_at(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 1.0, 1.0, 0.5, 2000.0).unwrap();
    let g = renderer.gbuffer(&scene, &camera, [128; 2], &Progress::new()).unwrap();
    for (i, triangle) in g.triangle.iter().enumerate() {
        let row = i / 128;
        let angle = (row as f64 + 0.5 - 64.0) / 64.0 * 0.5f64.tan();
        // The square ends at distance 1000, 0.002 below the horizon: a quarter of a pixel.
        assert_eq!(*triangle >= 0, angle > 0.002, "pixel {i} in row {row}");
        if *triangle >= 0 {
            let p = DVec3::from_array(g.position[i].map(f64::from)) + g.origin;
            let distance = 2.0 / angle;
            // Single precision, with a ray that meets the ground at `angle`.
            let tolerance = 1e3 * f64::from(f32::EPSILON) * 8.0 / angle;
            assert!((p.y + 2.0).abs() < 1e3 * 8.0 * f64::from(f32::EPSILON), "pixel {i}: {p}");
            assert!((-p.z - distance).abs() < tolerance, "pixel {i}: {p} for {distance}");
            assert_eq!(g.normal[i], [0.0, 1.0, 0.0]);
        }
    }
}

#[test]
fn gbuffer_tells_position_normal_triangle_and_instance_under_mirrored_and_sheared_transforms() {
    let Some(renderer) = renderer() else { return };
    let mesh = Arc::new(square(1.0, 0.0));
    // Columns: x to (0, 0, -1), y to anything, z to (1, 1, 0): mirrored and sheared, and lifted.
    let skew = DAffine3::from_cols_array_2d(&[[0.0, 0.0, -1.0], [9.0, 2.0, 7.0], [1.0, 1.0, 0.0], [0.0, 3.0, 0.0]]);
    let low = DAffine3::from_translation(DVec3::new(2.0, -1.0, 0.5));
    let instances = [low, skew].map(|world_from_mesh| Instance { mesh: 0, world_from_mesh });
    let scene = Scene::new(vec![mesh], instances.to_vec()).unwrap();
    let camera = camera_above(10.0);
    let g = renderer.gbuffer(&scene, &camera, [96, 64], &Progress::new()).unwrap();
    let mut seen = [0; 2];
    for i in 0..g.depth.len() {
        if g.instance[i] < 0 {
            assert_eq!((g.depth[i], g.triangle[i], g.position[i], g.normal[i]), (1.0, -1, [0.0; 3], [0.0; 3]));
            continue;
        }
        let p = DVec3::from_array(g.position[i].map(f64::from)) + g.origin;
        let (pixel_x, pixel_y) = ((i % 96) as f64 + 0.5, (i / 96) as f64 + 0.5);
        let ray = camera.pixel_ray(pixel_x, pixel_y, [96, 64]).direction;
        // Planes: y = -1, and the span of (0, 0, -1) and (1, 1, 0) through (0, 3, 0).
        let (normal, offset) = match g.instance[i] {
            0 => (DVec3::Y, -1.0),
            _ => (DVec3::new(-1.0, 1.0, 0.0).normalize(), 3.0 / 2f64.sqrt()),
        };
        seen[g.instance[i] as usize] += 1;
        let expected = camera.eye() + ray * ((offset - normal.dot(camera.eye())) / normal.dot(ray));
        // The eye is 10 away: single precision relative to that.
        assert!((p - expected).length() < 10.0 * 8.0 * f64::from(f32::EPSILON), "{p} for {expected}");
        let n = DVec3::from_array(g.normal[i].map(f64::from));
        assert!((n - normal).length() < 4.0 * f64::from(f32::EPSILON), "{n} for {normal}");
        // Triangle 0 holds (1, -1), triangle 1 holds (-1, 1) of the mesh's (x, z).
        let p_mesh = instances[g.instance[i] as usize].world_from_mesh.inverse().transform_point3(expected);
        if (p_mesh.x - p_mesh.z).abs() > 1e-3 {
            assert_eq!(g.triangle[i], i32::from(p_mesh.x < p_mesh.z));
        }
        let ndc = camera.clip_from_world() * p.extend(1.0);
        assert!((f64::from(g.depth[i]) - ndc.z / ndc.w).abs() < DEPTH_TOLERANCE);
    }
    assert!(seen[0] > 100 && seen[1] > 100, "{seen:?}");
}

/// A unit square 2 above ground that a light from straight above shines at.
fn table() -> Scene {
    let meshes = vec![Arc::new(square(4.0, 0.0)), Arc::new(square(1.0, 2.0))];
    let instances = (0..2).map(|mesh| Instance { mesh, world_from_mesh: DAffine3::IDENTITY }).collect();
    Scene::new(meshes, instances).unwrap()
}

#[test]
fn a_mask_has_the_shadow_where_it_belongs() {
    let Some(renderer) = renderer() else { return };
    let light = Light::Directional(DirectionalLight::new(DVec3::new(-1.0, -1.0, 0.0)).unwrap());
    // Along the light, x' = x - y is constant: the table's shadow lies at x in [-3, -1] on the ground.
    let shear = DMat4::from_cols_array_2d(&[
        [1.0, 0.0, 0.0, 0.0],
        [-1.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ]);
    let p = single_map(downwards(8.0, 4.0, -1.0) * shear);
    let camera = camera_above(20.0);
    for (filter, reach) in [(Filter::Nearest, 0.5), (Filter::Bilinear, 1.5)] {
        let settings = MaskSettings {
            resolution: [512; 2],
            size: [256; 2],
            bias: Bias::default(),
            filter,
            blend: 0.0,
            stored: Stored::default(),
        };
        let mask = renderer.shadow_mask(&table(), &camera, &light, &p, &settings, &Progress::new()).unwrap();
        let g = renderer.gbuffer(&table(), &camera, [256; 2], &Progress::new()).unwrap();
        let (mut lit, mut dark) = (0, 0);
        for i in 0..mask.data.len() {
            if g.instance[i] < 0 {
                assert!(mask.data[i].is_nan());
                continue;
            }
            let q = DVec3::from_array(g.position[i].map(f64::from)) + g.origin;
            let texel = 16.0 / 512.0;
            // How far outside the shadow, along the axis that decides.
            let outside = ((q.x + 2.0).abs() - 1.0).max(q.z.abs() - 1.0);
            if g.instance[i] == 1 || outside > reach * texel {
                assert_eq!(mask.data[i], 1.0, "{q}");
                lit += 1;
            } else if outside < -reach * texel {
                assert_eq!(mask.data[i], 0.0, "{q}");
                dark += 1;
            }
        }
        assert!(lit > 1000 && dark > 100, "{lit} {dark}");
    }
    // From below everything faces away.
    let below = Light::Directional(DirectionalLight::new(DVec3::Y).unwrap());
    let settings = MaskSettings {
        resolution: [64; 2],
        size: [64; 2],
        bias: Bias::default(),
        filter: Filter::Nearest,
        blend: 0.0,
        stored: Stored::default(),
    };
    let mask = renderer.shadow_mask(&table(), &camera, &below, &p, &settings, &Progress::new()).unwrap();
    assert!(mask.data.iter().all(|&x| x.is_nan() || x == 0.0));
}

#[test]
fn a_spot_lights_its_cone_alone() {
    let Some(renderer) = renderer() else { return };
    let spot = SpotLight::new(DVec3::new(0.0, 4.0, 0.0), DVec3::NEG_Y, 1.0, 10.0).unwrap();
    let view = glam::dcamera::rh::view::look_to_mat4(spot.position(), spot.direction(), DVec3::X);
    let p = single_map(glam::dcamera::rh::proj::directx::perspective(1.0, 1.0, 1.0, 10.0) * view);
    let (camera, scene) = (camera_above(20.0), Scene::from_mesh(square(4.0, 0.0)).unwrap());
    let settings = MaskSettings {
        resolution: [128; 2],
        size: [256; 2],
        bias: Bias::default(),
        filter: Filter::Nearest,
        blend: 0.0,
        stored: Stored::default(),
    };
    let light = Light::Spot(spot);
    let mask = renderer.shadow_mask(&scene, &camera, &light, &p, &settings, &Progress::new()).unwrap();
    let g = renderer.gbuffer(&scene, &camera, [256; 2], &Progress::new()).unwrap();
    let radius = 4.0 * 0.5f64.tan();
    let mut lit = 0;
    for (i, &value) in mask.data.iter().enumerate().filter(|(_, x)| !x.is_nan()) {
        let q = DVec3::from_array(g.position[i].map(f64::from)) + g.origin;
        let from_axis = q.x.hypot(q.z);
        if (from_axis - radius).abs() > 1e-4 {
            assert_eq!(value, if from_axis < radius { 1.0 } else { 0.0 }, "{q}");
            lit += i32::from(value == 1.0);
        }
    }
    assert!(lit > 500, "{lit}");
}

#[test]
fn partitions_are_layers_and_serve_their_depths() {
    let Some(renderer) = renderer() else { return };
    let mut p = single_map(downwards(4.0, 4.0, -1.0));
    // The second map sees nothing at all, so whatever it serves is lit.
    let mut empty = single_map(DMat4::from_translation(DVec3::new(100.0, 0.0, 0.0))).partitions.remove(0);
    p.partitions[0].eye_depth = [0.0, 21.0];
    empty.eye_depth = [21.0, 100.0];
    p.partitions.push(empty);
    let maps = renderer.depth_maps(&table(), &p, [33, 17], Stored::default(), &Progress::new()).unwrap();
    assert_eq!((maps.layers, maps.data.len()), (2, 2 * 33 * 17));
    assert!(maps.data[..33 * 17].iter().all(|&z| z < 1.0) && maps.data[33 * 17..].iter().all(|&z| z == 1.0));
    // Ground right under the eye is nearer than 21, its middle is in the table's shadow.
    let down = Light::Directional(DirectionalLight::new(DVec3::NEG_Y).unwrap());
    let settings = MaskSettings {
        resolution: [64; 2],
        size: [65; 2],
        bias: Bias::NONE,
        filter: Filter::Nearest,
        blend: 0.0,
        stored: Stored::default(),
    };
    let ground = |end: f64| {
        let mut p = p.clone();
        p.partitions[0].eye_depth[1] = end;
        p.partitions[1].eye_depth[0] = end;
        // The eye is below the table and looks at the ground under it.
        let eye = DVec3::new(3.0, 1.0, 0.0);
        let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.1, 1.0, 0.1, 100.0).unwrap();
        let mask = renderer.shadow_mask(&table(), &camera, &down, &p, &settings, &Progress::new()).unwrap();
        mask.data[65 * 32 + 32]
    };
    assert_eq!((ground(10.0), ground(1.0)), (0.0, 1.0));
}

#[test]
fn awkward_sizes_and_names_have_typed_errors() {
    let Some(renderer) = renderer() else { return };
    let (scene, p, progress) = (tilted_quad(0.5), single_map(downwards(1.25, 2.0, -2.0)), Progress::new());
    for size in [[0, 5], [5, 0], [1 << 20, 5], [5, u32::MAX]] {
        assert!(matches!(
            renderer.depth_maps(&scene, &p, size, Stored::default(), &progress),
            Err(Error::InvalidArgument { .. })
        ));
        assert!(matches!(
            renderer.gbuffer(&scene, &camera_above(5.0), size, &progress),
            Err(Error::InvalidArgument { .. })
        ));
    }
    let one = renderer.depth_maps(&scene, &p, [1; 2], Stored::default(), &progress).unwrap();
    assert!((f64::from(one.data[0]) - 0.5).abs() < DEPTH_TOLERANCE);
    let g = renderer.gbuffer(&scene, &camera_above(5.0), [1; 2], &progress).unwrap();
    assert_eq!(g.instance, [0]);
    let mut none = p.clone();
    none.partitions.clear();
    assert!(matches!(
        renderer.depth_maps(&scene, &none, [4; 2], Stored::default(), &progress),
        Err(Error::InvalidArgument { .. })
    ));
    // Positions are stored in single precision.
    let huge = scene.transformed(&DAffine3::from_scale(DVec3::splat(1e100))).unwrap();
    let far = Camera::look_at(DVec3::Y * 5e100, DVec3::ZERO, DVec3::Z, 1.0, 1.0, 1e98, 1e102).unwrap();
    assert!(matches!(renderer.gbuffer(&huge, &far, [4; 2], &progress), Err(Error::InvalidArgument { .. })));
    // A matrix with a NaN has no picture.
    let broken = single_map(DMat4::from_cols_array(&[f64::NAN; 16]));
    assert!(matches!(
        renderer.depth_maps(&scene, &broken, [4; 2], Stored::default(), &progress),
        Err(Error::InvalidArgument { .. })
    ));

    let stopped = Progress::new();
    stopped.stop();
    assert_eq!(renderer.depth_maps(&scene, &p, [4; 2], Stored::default(), &stopped), Err(Error::Interrupted));
    assert!(
        renderer.depth_maps(&scene, &p, [4; 2], Stored::default(), &progress).is_ok(),
        "usable after an interruption"
    );
}

#[test]
fn an_unknown_adapter_is_an_error_that_lists_the_known_ones() {
    let found = adapters();
    match GpuRenderer::new(Some("no such adapter")) {
        Err(Error::NoAdapter { wanted, found: listed, fix }) => {
            assert_eq!((wanted.as_deref(), listed.len()), (Some("no such adapter"), found.len()));
            assert!(!fix.is_empty());
        }
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("an adapter of that name"),
    }
    if let Some(first) = found.first() {
        let name = first.name.to_uppercase();
        let chosen = GpuRenderer::new(Some(&name)).unwrap();
        assert_eq!((chosen.backend(), chosen.adapter_info()), ("gpu", first));
        assert!(chosen.adapter().contains(&first.name));
    }
}

#[test]
fn ten_thousand_instances_are_drawn_where_they_stand() {
    let Some(renderer) = renderer() else { return };
    let mesh = Arc::new(square(0.25, 0.0));
    let place = |i: u32| DVec3::new(f64::from(i % 100) - 49.5, f64::from(i) * 1e-4, f64::from(i / 100) - 49.5);
    let instances = (0..10_000).map(|i| Instance { mesh: 0, world_from_mesh: DAffine3::from_translation(place(i)) });
    let scene = Scene::new(vec![mesh], instances.collect()).unwrap();
    // Four texels an instance along each axis, so that the middle 2 x 2 are covered.
    let p = single_map(downwards(50.0, 2.0, -1.0));
    let maps = renderer.depth_maps(&scene, &p, [400; 2], Stored::default(), &Progress::new()).unwrap();
    for (k, &z) in maps.data.iter().enumerate() {
        let (x, y) = (k % 400, k / 400);
        let inside = (1..3).contains(&(x % 4)) && (1..3).contains(&(y % 4));
        let height = (y / 4 * 100 + x / 4) as f64 * 1e-4;
        let expected = if inside { (2.0 - height) / 3.0 } else { 1.0 };
        assert!((f64::from(z) - expected).abs() < DEPTH_TOLERANCE, "texel {x}, {y}: {z} for {expected}");
    }
    // Each is told by its own number, those that are culled included in the count.
    let camera =
        Camera::look_at(DVec3::new(20.5, 20.0, 20.5), DVec3::new(20.5, 0.0, 20.5), DVec3::Z, 0.2, 1.0, 1.0, 50.0)
            .unwrap();
    let g = renderer.gbuffer(&scene, &camera, [64; 2], &Progress::new()).unwrap();
    let mut seen = std::collections::BTreeSet::new();
    for (position, &instance) in g.position.iter().zip(&g.instance).filter(|(_, i)| **i >= 0) {
        let p = DVec3::from_array(position.map(f64::from)) + g.origin - place(instance as u32);
        assert!(p.x.abs() < 0.2501 && p.z.abs() < 0.2501, "{p} of {instance}");
        seen.insert(instance);
    }
    assert!(seen.len() >= 9, "{seen:?}");
}

#[test]
fn scenes_come_and_go_and_threads_take_turns() {
    let Some(renderer) = renderer() else { return };
    let p = single_map(downwards(1.25, 4.0, -4.0));
    std::thread::scope(|scope| {
        for thread in 0..2 {
            let (renderer, p) = (&renderer, &p);
            scope.spawn(move || {
                for round in 0..40 {
                    // Dropped at the end of each round, while its buffers are still on the device.
                    let slope = f64::from(thread * 100 + round) * 0.01;
                    let scene = tilted_quad(slope);
                    let maps = renderer.depth_maps(&scene, p, [32; 2], Stored::default(), &Progress::new()).unwrap();
                    let x = 1.25 * (2.0 * 20.5 / 32.0 - 1.0);
                    let expected = (4.0 - slope * x) / 8.0;
                    let depth = f64::from(maps.data[16 * 32 + 20]);
                    assert!((depth - expected).abs() < DEPTH_TOLERANCE, "{slope}: {depth} for {expected}");
                }
            });
        }
    });
}
