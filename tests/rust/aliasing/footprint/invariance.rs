//! The same footprint wherever the world lies, however it is turned, and whatever its unit.
//!
//! World and map move together: the map's matrix takes the inverse of the movement, so that no technique is in play.

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, DVec4};
use shadowlab::Parameterization;
use shadowlab::parameterization::Region;
use shadowlab::scene::{Camera, DirectionalLight, Light, PointLight, SpotLight};

use super::measured::{PROJECTION, Sizes, apart, at, differing, gbuffer, matrix};
use super::{images, measured};
use crate::support::views::{Random, View};

const SIZES: Sizes = Sizes { image: [193, 140], map: [512, 384] };

/// Of images: positions in f32 relative to the scene's origin, normals that f32 found anew, and errors that grow with the slope.
const IMAGE: f64 = 1e-3;

/// Of positions in f32, in NDC.
const KNOT: f64 = 1e-5;

/// A similarity of the world.
#[derive(Debug, Clone, Copy)]
struct Movement {
    scale: f64,
    turn: DQuat,
    offset: DVec3,
}

impl Movement {
    fn affine(&self) -> DAffine3 {
        DAffine3::from_scale_rotation_translation(DVec3::splat(self.scale), self.turn, self.offset)
    }
    fn point(&self, p: DVec3) -> DVec3 {
        self.affine().transform_point3(p)
    }
    fn view(&self, v: &View) -> View {
        let (c, s) = (&v.camera, self.scale);
        let (eye, up) = (self.point(c.eye()), self.turn * c.up());
        // A target as far as the coordinates are large, so that its rounding turns no view.
        let target = eye + self.turn * c.forward() * eye.length().max(s);
        let camera = Camera::look_at(eye, target, up, c.fov_y(), c.aspect(), c.near() * s, c.far() * s);
        let light = match v.light {
            Light::Directional(l) => DirectionalLight::new(self.turn * l.direction()).map(Light::Directional),
            Light::Spot(l) => {
                let (position, direction) = (self.point(l.position()), self.turn * l.direction());
                SpotLight::new(position, direction, l.cone_angle(), l.range() * s).map(Light::Spot)
            }
            Light::Point(l) => PointLight::new(self.point(l.position()), l.range() * s).map(Light::Point),
        };
        View {
            name: format!("{} moved by {self:?}", v.name),
            scene: v.scene.transformed(&self.affine()).expect("a scene"),
            camera: camera.expect("a camera"),
            light: light.expect("a light"),
        }
    }
    fn maps(&self, p: &Parameterization) -> Parameterization {
        let back = DMat4::from(self.affine().inverse());
        let mut moved = p.clone();
        for map in &mut moved.partitions {
            map.shadow_clip_from_world *= back;
            map.eye_depth = map.eye_depth.map(|z| z * self.scale);
            let functionals: Vec<DVec4> = map.region.functionals().iter().map(|f| back.transpose() * *f).collect();
            map.region = Region::new(&functionals);
        }
        moved
    }
}

fn movements() -> Vec<Movement> {
    let utm = DVec3::new(455_000.0, 5_411_000.0, -1_200.0);
    let turn = DQuat::from_axis_angle(DVec3::new(0.6, 0.0, -0.8), 1.1);
    let none = Movement { scale: 1.0, turn: DQuat::IDENTITY, offset: DVec3::ZERO };
    vec![
        none,
        Movement { scale: 1e-6, ..none },
        Movement { scale: 1e6, ..none },
        Movement { turn, ..none },
        Movement { offset: utm, ..none },
        Movement { turn, offset: utm, ..none },
        Movement { scale: 1e3, turn, offset: utm },
        Movement { scale: 1e6, turn, offset: utm * 1e6 },
        Movement { scale: 1e-6, turn, offset: utm * 1e-6 },
    ]
}

/// How far from sure a code is: the nearest distance to a border of a map, of the light, or of facing it, as a share.
fn near_a_border(v: &View, p: &Parameterization, q: DVec3, n: DVec3, share: f64) -> bool {
    let grazing = n.normalize().dot(v.light.to_light(q).normalize()).abs() < share;
    let depth = v.camera.depth_of(q);
    let beside = |k: f64| {
        let away = v.camera.eye().lerp(q, k);
        let codes = [q, away].map(|q| (p.choose(q, v.camera.depth_of(q)), v.light.reaches(q)));
        codes[0] != codes[1]
    };
    let ends = p.partitions.iter().any(|map| apart(depth, map.eye_depth[1]) < share);
    grazing || ends || beside(1.0 - share) || beside(1.0 + share)
}

#[test]
fn points_have_the_same_texels() {
    let (mut compared, mut unsure) = (0, 0);
    images::each(|what, v, p| {
        let mut random = Random(5);
        let mut on = measured::shown(&gbuffer(v, SIZES.image), 60);
        let turned: Vec<_> = on
            .iter()
            .filter_map(|(q, _)| Some((*q, measured::facing(&mut random, measured::ways(&v.camera, &v.light, *q))?)))
            .collect();
        on.extend(turned);
        for movement in movements() {
            let (there, maps) = (movement.view(v), movement.maps(p));
            // A coordinate's last digit as a share of the depth: of the eye, of the point, and in the terms of the matrix.
            let size = |q: DVec3| (movement.offset.length() / movement.scale + q.length()) / v.camera.depth_of(q);
            for (q, n) in &on {
                let rounding = f64::EPSILON * (1.0 + size(*q));
                let here = at(v, p, SIZES, &[*q], &[*n])[0];
                let moved = at(&there, &maps, SIZES, &[movement.point(*q)], &[movement.turn * *n])[0];
                if here.0 != moved.0 {
                    assert!(near_a_border(v, p, *q, *n, 1e4 * rounding), "{what}, {movement:?}: {q}, {n}");
                    unsure += 1;
                    continue;
                }
                if here.0 < 0 {
                    continue;
                }
                // Of a slanted surface, and of a map that doubles over less than the depth.
                let (a, b) = (here.1, moved.1);
                let [to_eye, to_light] = measured::ways(&v.camera, &v.light, *q);
                let n = n.normalize();
                let slant = 1.0 / n.dot(to_light).abs() + 1.0 / n.dot(to_eye).abs() + a.major / a.minor;
                let h = measured::step(&v.camera, &p.partitions[here.0 as usize], *q);
                let tolerance = 1e3 * rounding * slant * (v.camera.depth_of(*q) * 1e-2 / h);
                let pairs = [
                    (a.major, b.major),
                    (a.minor, b.minor),
                    (a.perspective, b.perspective),
                    (a.projection, b.projection),
                    (a.perspective_ts[0], b.perspective_ts[0]),
                    (a.perspective_ts[1], b.perspective_ts[1]),
                    (a.depth, b.depth / movement.scale),
                ];
                for (k, (one, two)) in pairs.into_iter().enumerate() {
                    assert!(apart(two, one) < tolerance, "{what}, {movement:?}, {k}: {a:?} {b:?} {tolerance:e}");
                }
                let d = matrix(&a) - matrix(&b);
                let largest = d.to_cols_array().into_iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                assert!(largest < tolerance * a.major, "{what}, {movement:?}: {a:?} {b:?}");
                compared += 1;
            }
        }
    });
    println!("{compared} compared, {unsure} on borders");
    assert!(compared > 5000 && unsure * 100 < compared, "{compared} compared, {unsure} on borders");
}

#[test]
fn images_have_the_same_texels() {
    images::each(|what, v, p| {
        let g = gbuffer(v, SIZES.image);
        let here = images::image(v, &g, p);
        for movement in movements() {
            let (there, maps) = (movement.view(v), movement.maps(p));
            let g_there = gbuffer(&there, SIZES.image);
            let mut moved = images::image(&there, &g_there, &maps);
            let mut unsure = 0;
            for i in 0..here.map.len() {
                // A pixel on an edge, or a receiver on the border of a map, may go either way.
                let other = (g.triangle[i], g.instance[i], here.map[i])
                    != (g_there.triangle[i], g_there.instance[i], moved.map[i]);
                unsure += usize::from(other);
                // Slopes of f32 normals: a few digits are gone where light or view grazes.
                let slope = here.numbers[i][PROJECTION];
                let grazing = here.map[i] >= 0 && !(0.01..100.0).contains(&slope);
                // On a knot the size of a texel jumps.
                let on_a_knot = usize::try_from(here.map[i])
                    .ok()
                    .zip(g.surfaces().receiver(i))
                    .is_some_and(|(k, (q, _))| measured::gaps(&p.partitions[k], g.origin + q).min_element() < KNOT);
                if other || grazing || on_a_knot {
                    moved.map[i] = here.map[i];
                    moved.numbers[i] = here.numbers[i];
                }
            }
            assert!(unsure * 100 <= here.map.len(), "{what}, {movement:?}: {unsure} of {}", here.map.len());
            assert_eq!(differing(&here, &moved, IMAGE), None, "{what}, {movement:?}");
        }
    });
}

#[test]
fn powers_of_two_change_no_bit() {
    // Every product and quotient of f64 and f32 scales by them exactly.
    let stay = Movement { scale: 1.0, turn: DQuat::IDENTITY, offset: DVec3::ZERO };
    images::each(|what, v, p| {
        let on = measured::shown(&gbuffer(v, SIZES.image), 100);
        let (places, normals): (Vec<_>, Vec<_>) = on.iter().copied().unzip();
        // The camera is built in the same steps.
        let here = at(&stay.view(v), p, SIZES, &places, &normals);
        for scale in [(-20.0_f64).exp2(), 20.0_f64.exp2()] {
            let movement = Movement { scale, ..stay };
            let back = DMat4::from_mat3(DMat3::from_diagonal(DVec3::splat(1.0 / scale)));
            let mut maps = movement.maps(p);
            for (map, own) in maps.partitions.iter_mut().zip(&p.partitions) {
                map.shadow_clip_from_world = own.shadow_clip_from_world * back;
            }
            let far: Vec<DVec3> = places.iter().map(|q| *q * scale).collect();
            let mut moved = at(&movement.view(v), &maps, SIZES, &far, &normals);
            moved.iter_mut().for_each(|(_, t)| t.depth /= scale);
            for ((a, b), q) in here.iter().zip(&moved).zip(&places) {
                assert_eq!(a, b, "{what} x {scale} at {q}");
            }
        }
    });
}
