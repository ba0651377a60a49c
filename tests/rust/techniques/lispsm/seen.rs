//! LiSPSM placed by what is seen: its measures against the finished matrix, and its optimum against dense scans.
//!
//! Source: theory.md 10.2, (10.7) and (10.8). Everything here is measured by finite differences of the finished matrix, of the
//! picture and of the light's rays along the surfaces of samples, which share nothing with the search but the definition.
//!
//! ```text
//!    picture <-- D -- surface -- J --> map        G = D J⁻¹ 2/N: a texel's two sides in pixels
//! ```

use glam::{DMat2, DMat3, DVec2, DVec3};
use shadowlab::focus::{Focus, FocusedView, Picture, Samples};
use shadowlab::parameterization::{Partition, Region};
use shadowlab::scene::{Camera, DirectionalLight, Light, Scene, SpotLight};
use shadowlab::techniques::technique_of;
use shadowlab::{Error, Parameterization};

use crate::support::by_body::by_body;
use crate::support::measure::LocalMap;
use crate::support::views::{Random, View, cube, look, placed, square};

const RESOLUTION: u32 = 1024;

/// Central differences with steps of 1e-6 of a sample's depth: h² and rounding over h.
const DIFFERENCES: f64 = 1e-5;

/// Where an edge's width stops to count, pixels (theory.md (10.8)).
const CAP_PX: f64 = 32.0;

/// What a search may miss of the least that 2000 distances find: between the scan's steps of its first, rough look.
const EDGE_MISSED: f64 = 1.01;
const NORM_MISSED: f64 = 1.1;

/// Samples that a search over what is seen looks at, at the most.
const SEARCHED: usize = 2048;

/// A floor with turned boxes before a camera, under the sun or a lamp.
fn town(random: &mut Random) -> View {
    let mut parts = vec![(square(), DMat3::from_diagonal(DVec3::new(60.0, 1.0, 60.0)), DVec3::ZERO)];
    for _ in 0..30 {
        let at = DVec3::new(random.between(-30.0, 30.0), random.between(0.0, 4.0), random.between(-30.0, 30.0));
        let size = DVec3::new(random.between(0.2, 3.0), random.between(0.2, 4.0), random.between(0.2, 3.0));
        let turn = DMat3::from_axis_angle(random.direction(), random.between(0.0, 6.0));
        parts.push((cube(), turn * DMat3::from_diagonal(size), at));
    }
    let eye = DVec3::new(random.between(-20.0, 20.0), random.between(1.5, 8.0), random.between(-20.0, 20.0));
    let ahead = random.direction().with_y(random.between(-0.5, -0.05));
    let camera = look(eye, eye + ahead, random.between(0.5, 1.4), 0.1, 200.0);
    let down = random.direction().with_y(random.between(-1.5, -0.3));
    let light = if random.below(3) == 0 {
        let lamp = SpotLight::new(eye + ahead * 15.0 - down * 20.0, down, random.between(0.7, 1.6), 120.0);
        Light::Spot(lamp.expect("a lamp"))
    } else {
        Light::Directional(DirectionalLight::new(down).expect("a light"))
    };
    View { name: format!("town from {eye} / {}", light.kind()), scene: placed(&parts), camera, light }
}

/// Views in which a search has edges to look at, with their samples.
fn towns(seed: u64, count: usize) -> Vec<(View, Samples)> {
    let mut random = Random(seed);
    let mut all = Vec::new();
    while all.len() < count {
        let view = town(&mut random);
        let samples = view.samples();
        if samples.shadows.as_ref().is_some_and(|shadows| shadows.edges.len() > 60) {
            all.push((view, samples));
        }
    }
    all
}

fn map(text: &str, v: &View, samples: &Samples) -> Parameterization {
    let t = technique_of(text).expect(text);
    t.parameterize_seen(&v.scene, &v.camera, &v.light, [RESOLUTION; 2], Some(samples)).expect(text)
}

/// Differences along two steps on a surface: columns (f(p + a) - f(p - a)) / 2.
fn along_surface(f: impl Fn(DVec3) -> DVec2, p: DVec3, [a, b]: [DVec3; 2]) -> DMat2 {
    DMat2::from_cols(0.5 * (f(p + a) - f(p - a)), 0.5 * (f(p + b) - f(p - b)))
}

/// Two steps along a sample's surface.
fn steps(camera: &Camera, p: DVec3, n: DVec3) -> [DVec3; 2] {
    let (a, b) = n.normalize().any_orthonormal_pair();
    [a, b].map(|axis| axis * (1e-6 * camera.depth_of(p)))
}

/// A sample at an edge: world position, normal, the edge's normal in the picture, and its weight.
type Edge = (DVec3, DVec3, DVec2, f64);

/// The samples at edges that a map has to answer for.
fn edges(v: &View, samples: &Samples) -> Vec<Edge> {
    let shadows = samples.shadows.as_ref().expect("states");
    let of = |edge: &shadowlab::focus::EdgeSample| {
        let (p, n) = samples.sample(edge.sample as usize);
        (p, n, DVec2::from_array(edge.normal.map(f64::from)), f64::from(edge.weight))
    };
    let counts = |(p, n, ..): &Edge| {
        let in_depth = (v.camera.near()..=v.camera.far()).contains(&v.camera.depth_of(*p));
        in_depth && n.dot(v.light.to_light(*p)) > 0.0
    };
    shadows.edges.iter().map(of).filter(counts).collect()
}

/// The capped mean width of a map's texels across edges, pixels.
fn edge_error(v: &View, picture: &Picture, edges: &[Edge], map: &Partition) -> f64 {
    let (mut sum, mut weights) = (0.0, 0.0);
    let eye = v.camera.eye();
    for (p, n, edge, weight) in edges {
        let steps = steps(&v.camera, *p, *n);
        let pixel = along_surface(|q| picture.place(q - eye), *p, steps);
        let ndc = along_surface(|q| map.project(q).0.truncate(), *p, steps);
        let texel = pixel * ndc.inverse() * (2.0 / f64::from(RESOLUTION));
        let width = edge.dot(texel.x_axis).abs() + edge.dot(texel.y_axis).abs();
        sum += weight * CAP_PX * (1.0 - (-width / CAP_PX).exp());
        weights += weight;
    }
    sum / weights
}

#[test]
fn edges_in_the_lights_rays_are_differences_along_the_surface() {
    let mut count = 0;
    for (v, samples) in towns(3, 8) {
        let (eye, picture) = (v.camera.eye(), samples.picture.expect("a picture"));
        let (rays, found) = samples.ray_edges(&v.camera, &v.light, &Region::ALL, 4096).expect("edges");
        let expected = edges(&v, &samples);
        assert_eq!(found.len(), expected.len(), "{}", v.name);
        for (ours, (p, n, edge, weight)) in found.iter().zip(expected) {
            let steps = steps(&v.camera, p, n);
            let pixel = along_surface(|q| picture.place(q - eye), p, steps);
            let ray = along_surface(|q| rays.ray(q - eye), p, steps);
            let across = (pixel * ray.inverse()).transpose() * edge;
            assert_eq!((ours.ray, ours.weight), (rays.ray(p - eye), weight), "{}", v.name);
            // Where the light grazes the surface a step along it hardly moves the ray.
            let grazing = n.dot(v.light.to_light(p).normalize());
            let off = (ours.across - across).length() / across.length();
            assert!(off < DIFFERENCES / grazing, "{}: {} and {across}, off by {off:e}, {grazing}", v.name, ours.across);
            count += 1;
        }
    }
    assert!(count > 800, "{count}");
}

#[test]
fn without_edges_every_sample_has_one_along_each_axis() {
    let floor = placed(&[(square(), DMat3::from_diagonal(DVec3::new(60.0, 1.0, 60.0)), DVec3::ZERO)]);
    let camera = look(DVec3::new(0.0, 4.0, 9.0), DVec3::ZERO, 0.9, 0.1, 100.0);
    let light = Light::Directional(DirectionalLight::new(DVec3::new(0.3, -1.0, 0.2)).expect("a light"));
    let v = View { name: "floor".into(), scene: floor, camera, light };
    let samples = v.samples();
    let (_, found) = samples.ray_edges(&camera, &light, &Region::ALL, 1000).expect("edges");
    let lit = samples.lit(&camera, &light, &Region::ALL).count();
    assert!(lit > 1000 && (250..=1000).contains(&found.len()), "{} of {lit}", found.len());
    let picture = samples.picture.expect("a picture");
    for pair in found.chunks(2) {
        let [x, y] = pair else { panic!("a pair") };
        assert_eq!(x.ray, y.ray);
        // The floor under the sun: the point whose ray this is, and its pixel's gradients.
        let frame = shadowlab::rays::LightFrame::any(DVec3::new(0.3, -1.0, 0.2).normalize());
        let on_floor = |ray: DVec2| {
            let p = frame.right * ray.x + frame.up * ray.y;
            p - frame.along * ((p.y + camera.eye().y) / frame.along.y)
        };
        let step = [DVec2::X * 1e-6, DVec2::Y * 1e-6];
        let pixel = |ray: DVec2| picture.place(on_floor(ray));
        let jacobian = DMat2::from_cols(
            (pixel(x.ray + step[0]) - pixel(x.ray - step[0])) / 2e-6,
            (pixel(x.ray + step[1]) - pixel(x.ray - step[1])) / 2e-6,
        );
        for (ours, row) in [(x.across, jacobian.row(0)), (y.across, jacobian.row(1))] {
            assert!((ours - row).length() < 1e-4 * row.length(), "{ours} and {row}");
        }
    }
    assert!(samples.ray_edges(&camera, &light, &Region::ALL, 1000).is_some());
    let bare = Samples::of_points(&[DVec3::ZERO], &[DVec3::Y]);
    assert!(bare.ray_edges(&camera, &light, &Region::ALL, 1000).is_none());
}

#[test]
fn the_error_that_a_search_reports_is_the_finished_maps() {
    let mut warped = 0;
    for (v, samples) in towns(7, 30) {
        let picture = samples.picture.expect("a picture");
        let all = edges(&v, &samples);
        for fit in ["shadow", "seen", "exact"] {
            let (p, what) = (map(&format!("lispsm:fit={fit}"), &v, &samples), format!("{}, {fit}", v.name));
            let [said, of] = ["error", "error_uniform"].map(|name| p.value(name).expect(name));
            let ours = edge_error(&v, &picture, &all, &p.partitions[0]);
            assert!((said / ours - 1.0).abs() < DIFFERENCES, "{what}: {said} and {ours}");
            let uniform = map(&format!("uniform:range=seen,fit={fit}"), &v, &samples);
            let theirs = edge_error(&v, &picture, &all, &uniform.partitions[0]);
            // A map of the body has a margin only where it is by samples.
            assert!((of / theirs - 1.0).abs() < DIFFERENCES, "{what}: {of} and {theirs}");
            assert!(said <= of, "{what}: {said} and {of}");
            warped += usize::from(said < 0.95 * of);
        }
    }
    assert!(warped > 45, "{warped} of 90 warped");
}

/// A view's warp distances: 2000 from 1e-3 to 1e5 of the depth that is seen, 1 % apart, and no warp.
fn scan(v: &View, rest: &str, samples: &Samples, error: impl Fn(&Parameterization) -> f64) -> (f64, f64) {
    let depth = samples.depths(&v.camera, &v.light, &Region::ALL).expect("depths")[1];
    let uniform = error(&map(&format!("uniform:range=seen,{rest}"), v, samples));
    let mut least = (uniform, f64::INFINITY);
    for i in 0..2000 {
        let distance = depth * 10.0_f64.powf(-3.0 + 8.0 * f64::from(i) / 1999.0);
        let e = error(&map(&format!("lispsm:near={distance},{rest}"), v, samples));
        if e < least.0 {
            least = (e, distance);
        }
    }
    least
}

#[test]
fn a_dense_scan_of_warp_distances_finds_hardly_better_edges() {
    for (v, samples) in towns(11, 12) {
        let picture = samples.picture.expect("a picture");
        let all = edges(&v, &samples);
        let error = |p: &Parameterization| edge_error(&v, &picture, &all, &p.partitions[0]);
        let ours = error(&map("lispsm:fit=shadow", &v, &samples));
        let (least, at) = scan(&v, "fit=shadow", &samples, error);
        assert!(ours <= least * EDGE_MISSED, "{}: {ours}, and {least} at {at}", v.name);
    }
}

/// The error of a finished map in a norm over samples.
fn norm_error(p: &Parameterization, view: &FocusedView, norm: &str, points: &[DVec3]) -> f64 {
    let map = LocalMap::new(p, &p.partitions[0], view.origin);
    let all = points.iter().map(|q| map.measured(view, *q));
    match norm {
        "mean" => all.map(|m| m.area).sum::<f64>() / points.len() as f64,
        _ => {
            let (along, across) = all.fold((0.0_f64, 0.0_f64), |(a, b), m| (a.max(m.along), b.max(m.across)));
            if norm == "linf" { along } else { along * across }
        }
    }
}

#[test]
fn a_dense_scan_of_warp_distances_finds_hardly_better_norms_over_what_is_seen() {
    for (v, samples) in towns(13, 4) {
        let view = FocusedView::new(&v.scene, &v.camera, &v.light, Focus::SceneFit);
        let points = samples.spread(&v.camera, &v.light, &Region::ALL, SEARCHED);
        for norm in ["linf", "storage", "mean"] {
            // Without a margin receivers span all but the border, as the measure has it.
            let text = format!("lispsm:near=optimal,norm={norm},fit=shadow,margin=0");
            let p = map(&text, &v, &samples);
            let what = format!("{} {norm}", v.name);
            let error = |p: &Parameterization| norm_error(p, &view, norm, &points);
            let (ours, said) = (error(&p), p.value("error").expect("an error"));
            assert!((said / ours - 1.0).abs() < DIFFERENCES, "{what}: {said} and {ours}");
            let (least, at) = scan(&v, "fit=shadow,margin=0", &samples, error);
            assert!(ours <= least * NORM_MISSED, "{what}: {ours}, and {least} at {at}");
        }
    }
}

#[test]
fn the_cameras_near_plane_does_not_matter() {
    let mut moved = 0;
    for (v, samples) in towns(17, 6) {
        let first = samples.depths(&v.camera, &v.light, &Region::ALL).expect("depths")[0];
        let of = |near: f64| {
            let camera = v.camera.with_depths(near, v.camera.far()).expect("depths");
            map("lispsm", &View { name: v.name.clone(), scene: v.scene.clone(), camera, light: v.light }, &samples)
        };
        let all = [1e-4, 1e-2, 0.5, 0.9].map(|share| of(share * first));
        for (p, _) in samples.lit(&v.camera, &v.light, &Region::ALL).step_by(37) {
            let [expected, others @ ..] = all.each_ref().map(|map| map.partitions[0].project(p).0);
            for other in others {
                assert!((other - expected).length() < 1e-9, "{}: {expected} and {other}", v.name);
            }
        }
        // Placed by the body, it does.
        let by_body = [1e-4, 0.9].map(|share| {
            let camera = v.camera.with_depths(share * first, v.camera.far()).expect("depths");
            let t = by_body("lispsm").parameterize(&v.scene, &camera, &v.light, RESOLUTION).expect("a map");
            t.partitions[0].shadow_clip_from_world
        });
        moved += usize::from(!by_body[0].abs_diff_eq(by_body[1], 1e-3));
    }
    assert!(moved > 3, "{moved} of 6 maps of the body move");
}

/// A scene that no light of a search reaches is answered, too.
#[test]
fn without_shadows_or_light_there_is_a_map_and_a_note() {
    let floor: Scene = placed(&[(square(), DMat3::from_diagonal(DVec3::new(30.0, 1.0, 30.0)), DVec3::ZERO)]);
    let camera = look(DVec3::new(0.0, 4.0, 9.0), DVec3::ZERO, 0.9, 0.1, 100.0);
    for (along, kind) in [(DVec3::new(0.3, -1.0, 0.2), "no_shadow"), (DVec3::new(0.3, 1.0, 0.2), "no_lit_sample")] {
        let light = Light::Directional(DirectionalLight::new(along).expect("a light"));
        let v = View { name: kind.into(), scene: floor.clone(), camera, light };
        let p = map("lispsm", &v, &v.samples());
        assert!(p.notes.iter().any(|note| note.kind().name() == kind), "{kind}: {:?}", p.notes);
        assert!(p.partitions[0].shadow_clip_from_world.is_finite());
    }
    let v = View {
        name: "no edge over the body".into(),
        scene: floor,
        camera,
        light: Light::Directional(DirectionalLight::new(DVec3::NEG_Y).expect("a light")),
    };
    for norm in ["edge", "flips"] {
        let error = technique_of(&format!("lispsm:near=optimal,norm={norm},over=body")).unwrap_err();
        assert!(matches!(&error, Error::InvalidArgument { name, .. } if name == "norm"), "{}: {error}", v.name);
    }
}
