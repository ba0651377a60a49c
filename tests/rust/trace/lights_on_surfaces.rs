//! Lights that touch geometry: on a surface, in its plane, at an edge or a vertex, inside of a body, parallel to a wall.
//!
//! The oracle knows quads and no rounding: a receiver is lit where it faces the light and no quad crosses the open segment
//! between them, those that hold the light left out.

use glam::{DAffine3, DMat3, DVec3};
use shadowlab::image::TruthMask;
use shadowlab::scene::{DirectionalLight, PointLight, SpotLight};
use shadowlab::trace::Tracer;
use shadowlab::{Camera, Light, Mesh, Progress, Scene};

const SIZE: [u32; 2] = [80, 60];
/// Undecided pixels: those whose rays pass an edge within the band of single precision. Of an image a thousandth, as in the
/// library's scenes.
const MOST_UNDECIDED: f64 = 1e-3;
/// A light as near as this to a surface stands on it, in units of the room: what single precision resolves there is 5e-7,
/// and in the yard 2e-6.
const TOUCH: f64 = 5e-7;
/// What is nearer than this to an edge of a shadow, in units of the room, is not asked.
const EDGE: f64 = 1e-4;

/// A room, 4 x 3 x 4 about the origin, with a table in it; in units of its own.
#[derive(Clone, Copy)]
struct Quad([DVec3; 4]);

impl Quad {
    fn normal(&self) -> DVec3 {
        (self.0[1] - self.0[0]).cross(self.0[3] - self.0[0]).normalize()
    }
    /// How far inside of its outline a point of its plane is; negative outside.
    fn inside(&self, p: DVec3) -> f64 {
        let n = self.normal();
        let side = |k: usize| n.cross(self.0[(k + 1) % 4] - self.0[k]).normalize().dot(p - self.0[k]);
        (0..4).map(side).fold(f64::INFINITY, f64::min)
    }
    fn holds(&self, p: DVec3) -> bool {
        self.normal().dot(p - self.0[0]).abs() < TOUCH && self.inside(p) > -TOUCH
    }
}

fn room() -> Vec<Quad> {
    let box_of = |low: DVec3, high: DVec3| {
        let p = |i: usize| DVec3::new([low.x, high.x][i & 1], [low.y, high.y][i >> 1 & 1], [low.z, high.z][i >> 2]);
        [[0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5], [0, 1, 3, 2], [4, 5, 7, 6]].map(|q| Quad(q.map(p)))
    };
    let table = [[-0.7, -0.6], [0.8, -0.6], [0.8, 0.5], [-0.7, 0.5]].map(|[x, z]| DVec3::new(x, 1.1, z));
    let mut all = box_of(DVec3::new(-2.0, 0.0, -2.0), DVec3::new(2.0, 3.0, 2.0)).to_vec();
    all.push(Quad(table));
    all.extend(box_of(DVec3::new(0.9, 0.0, 0.8), DVec3::new(1.5, 0.9, 1.6)));
    all
}

fn scene(quads: &[Quad], map: &DAffine3) -> Scene {
    let points: Vec<[f64; 3]> = quads.iter().flat_map(|q| q.0).map(|p| map.transform_point3(p).to_array()).collect();
    let faces: Vec<[i64; 3]> =
        (0..quads.len() as i64).flat_map(|q| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i: i64| i + 4 * q))).collect();
    Scene::from_mesh(Mesh::new(&points, &faces).unwrap()).unwrap()
}

/// What the oracle says of a point of a quad, seen from an eye; nothing near an edge of a shadow.
fn expected(quads: &[Quad], own: usize, p: DVec3, eye: DVec3, light: &Light) -> Option<bool> {
    let n = quads[own].normal();
    let n = if n.dot(eye - p) < 0.0 { -n } else { n };
    let to_light = light.to_light(p);
    let facing = n.dot(to_light.normalize());
    if facing < EDGE {
        return (facing < 1e-7 || facing > -EDGE).then_some(false).filter(|_| facing < 2e-7);
    }
    let place = light.point();
    let held = |q: &Quad| place.w != 0.0 && q.holds(place.truncate());
    let mut is_lit = light.reaches(p);
    for (k, q) in quads.iter().enumerate() {
        if k == own || held(q) {
            continue;
        }
        let across = q.normal().dot(to_light);
        let t = q.normal().dot(q.0[0] - p) / across;
        if !t.is_finite() || t < -EDGE || (place.w != 0.0 && t > 1.0 + TOUCH) {
            continue;
        }
        let inside = q.inside(p + t * to_light);
        let is_end = t < EDGE || (place.w != 0.0 && t > 1.0 - TOUCH);
        if inside.abs() < EDGE * (1.0 + t.abs()) || (is_end && inside > -EDGE) || across.abs() < EDGE {
            if inside > -2.0 * EDGE * (1.0 + t.abs()) {
                return None;
            }
            continue;
        }
        is_lit &= inside < 0.0;
    }
    // The rim of a cone.
    let near_rim = [DVec3::X, DVec3::Y, DVec3::Z]
        .iter()
        .flat_map(|d| [*d, -*d])
        .any(|d| light.reaches(p + EDGE * d) != light.reaches(p));
    (!near_rim).then_some(is_lit)
}

/// Compares the mask of a placed room with the oracle; the numbers of pixels that are lit and dark.
fn check(quads: &[Quad], map: &DAffine3, eye: DVec3, target: DVec3, light: &Light, what: &str) -> [usize; 2] {
    let unit = map.transform_vector3(DVec3::X).length();
    let world = |p: DVec3| map.transform_point3(p);
    let up = map.transform_vector3(DVec3::new(0.1, 1.0, 0.05));
    let camera = Camera::look_at(world(eye), world(target), up, 1.6, 4.0 / 3.0, 1e-3 * unit, 100.0 * unit).unwrap();
    let placed = match light {
        Light::Directional(l) => {
            Light::Directional(DirectionalLight::new(map.transform_vector3(l.direction())).unwrap())
        }
        Light::Point(l) => Light::Point(PointLight::new(world(l.position()), l.range() * unit).unwrap()),
        Light::Spot(l) => {
            let along = map.transform_vector3(l.direction());
            Light::Spot(SpotLight::new(world(l.position()), along, l.cone_angle(), l.range() * unit).unwrap())
        }
    };
    let scene = scene(quads, map);
    let tracer = Tracer::new(&scene, &Progress::new()).unwrap();
    let mask = tracer.shadow_mask(&camera, &placed, SIZE, &Progress::new()).unwrap().data;
    let back = map.inverse();
    let ray = |i: usize| camera.pixel_ray((i as u32 % SIZE[0]) as f64 + 0.5, (i as u32 / SIZE[0]) as f64 + 0.5, SIZE);
    let rays: Vec<[f64; 3]> = (0..mask.len()).map(|i| ray(i).direction.to_array()).collect();
    let hits = tracer.first_hit(&vec![camera.eye().to_array(); rays.len()], &rays, &Progress::new()).unwrap();
    let (mut counts, mut asked, mut undecided) = ([0; 2], 0, 0);
    for (i, hit) in hits.iter().enumerate().filter(|(_, hit)| hit.triangle >= 0) {
        let p = back.transform_point3(camera.eye() + hit.t * DVec3::from_array(rays[i]));
        let own = hit.triangle as usize / 2;
        undecided += usize::from(mask[i] == TruthMask::UNDECIDED);
        let Some(expected) = expected(quads, own, p, eye, light).filter(|_| mask[i] != TruthMask::UNDECIDED) else {
            continue;
        };
        asked += 1;
        counts[usize::from(!expected)] += 1;
        assert_eq!(mask[i], i8::from(expected), "{what}: quad {own} at {p}, light {:?}", light.point());
    }
    let seen = hits.iter().filter(|hit| hit.triangle >= 0).count();
    assert!(undecided as f64 <= MOST_UNDECIDED * seen as f64, "{what}: {undecided} undecided of {seen}");
    assert!(asked * 10 > seen * 9, "{what}: {asked} of {seen} asked");
    counts
}

/// The room as it is, at awkward sizes and places, and turned, where every vertex is rounded.
fn placements() -> [(&'static str, DAffine3); 5] {
    let turn = DMat3::from_rotation_y(0.7) * DMat3::from_rotation_x(0.31) * DMat3::from_rotation_z(-0.2);
    [
        ("as it is", DAffine3::IDENTITY),
        ("0.9 of it", DAffine3::from_scale(DVec3::splat(0.9))),
        ("turned", DAffine3::from_mat3(turn)),
        ("in UTM", DAffine3::from_mat3_translation(turn * 3.7, DVec3::new(512_345.6, 35.1, 4_987_654.3))),
        ("tiny", DAffine3::from_mat3_translation(turn * 1e-6, DVec3::new(1e-6, 2e-6, 3e-6))),
    ]
}

fn point(p: DVec3) -> Light {
    Light::Point(PointLight::new(p, 100.0).unwrap())
}

#[test]
fn lamps_that_touch_a_surface_light_what_is_before_it() {
    let quads = room();
    let v = DVec3::new;
    let size = 4.0;
    let mut places = vec![
        ("in the middle of the ceiling", v(0.3, 3.0, 0.2)),
        ("on an edge of the ceiling", v(2.0, 3.0, -0.4)),
        ("on a diagonal of the ceiling", v(1.2, 3.0, 1.2)),
        ("in a corner of the ceiling", v(-2.0, 3.0, 2.0)),
        ("on the floor", v(-1.1, 0.0, 0.7)),
        ("on a wall", v(2.0, 1.3, 0.1)),
        ("on the table", v(0.1, 1.1, 0.1)),
        ("at a corner of the table", v(0.8, 1.1, 0.5)),
        ("in the table's plane, beside it", v(-1.5, 1.1, 0.2)),
        ("at a corner of a chest", v(0.9, 0.9, 0.8)),
        ("on an edge of a chest", v(0.9, 0.9, 1.1)),
        ("inside of a chest", v(1.2, 0.4, 1.2)),
        ("hanging free", v(-0.4, 2.2, 0.3)),
    ];
    for off in [1e-9, -1e-9, -3e-8] {
        places.push(("a little off the ceiling", v(0.3, 3.0 - off * size, 0.2)));
        places.push(("a little off a wall", v(2.0 - off * size, 1.3, 0.1)));
        places.push(("a little off the table", v(0.1, 1.1 + off * size, 0.1)));
    }
    let mut total = [0; 2];
    for (placement, map) in placements() {
        for (i, (place, p)) in places.iter().enumerate() {
            let eyes = [(v(-1.7, 2.5, -1.6), v(1.0, 0.2, 1.0)), (v(1.6, 0.3, -1.7), v(-0.5, 2.4, 0.7))];
            let (eye, target) = eyes[i % 2];
            let counts = check(&quads, &map, eye, target, &point(*p), &format!("{placement}, {place}"));
            total = [total[0] + counts[0], total[1] + counts[1]];
        }
    }
    assert!(total.iter().all(|&n| n > 40_000), "{total:?}");
}

#[test]
fn spots_flush_with_a_wall_shine_into_the_room() {
    let quads = room();
    let v = DVec3::new;
    for (placement, map) in placements() {
        for (p, along, cone) in [
            (v(-2.0, 1.7, 0.3), DVec3::X, 2.6),
            (v(-2.0, 1.7, 0.3), v(1.0, -0.3, 0.2), 3.1),
            (v(0.2, 3.0, -0.3), DVec3::NEG_Y, 1.4),
            (v(0.2, 3.0, -0.3), DVec3::X, 1.4),
        ] {
            let light = Light::Spot(SpotLight::new(p, along, cone, 100.0).unwrap());
            let what = format!("{placement}, a spot at {p} along {along}");
            check(&quads, &map, v(1.6, 2.2, -1.7), v(-0.5, 0.4, 0.7), &light, &what);
        }
    }
}

#[test]
fn a_wall_parallel_to_the_sun_is_dark_and_shades_nothing() {
    let v = DVec3::new;
    let floor = Quad([v(-3.0, 0.0, -3.0), v(3.0, 0.0, -3.0), v(3.0, 0.0, 3.0), v(-3.0, 0.0, 3.0)]);
    let wall = Quad([v(0.4, 0.2, -2.0), v(0.4, 0.2, 2.0), v(0.4, 2.0, 2.0), v(0.4, 2.0, -2.0)]);
    for (placement, map) in placements() {
        for direction in [DVec3::NEG_Y, v(0.0, -0.4, 1.0), v(0.0, -1.0, -0.7)] {
            let light = Light::Directional(DirectionalLight::new(direction).unwrap());
            let what = format!("{placement}, sun along {direction}");
            let [lit, dark] = check(&[floor, wall], &map, v(2.5, 2.0, 2.0), v(0.3, 0.5, 0.0), &light, &what);
            assert!(lit > 900 && dark > 200, "{what}: {lit} {dark}");
        }
    }
}

#[test]
fn a_closed_body_keeps_its_lamp_to_itself() {
    let v = DVec3::new;
    let quads = room();
    let yard = Quad([v(-9.0, -0.5, -9.0), v(9.0, -0.5, -9.0), v(9.0, -0.5, 9.0), v(-9.0, -0.5, 9.0)]);
    let all: Vec<Quad> = quads.into_iter().chain([yard]).collect();
    for (placement, map) in placements() {
        // The half extent is 9: single precision resolves 2e-6.
        for p in [v(0.0, 1.5, 0.2), v(0.3, 3.0 - 2e-5, 0.2), v(-2.0 + 2e-5, 1.2, 0.4)] {
            let what = format!("{placement}, a lamp inside at {p}");
            let [lit, dark] = check(&all, &map, v(7.0, 5.0, 6.0), v(0.0, 0.5, 0.0), &point(p), &what);
            assert!(lit == 0 && dark > 900, "{what}: {lit} {dark}");
        }
    }
}
