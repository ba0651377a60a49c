//! Bias on planes: exact by the receiver's plane and by the slope, in every spacing and format.

use glam::{DMat4, DVec3};
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::cpu::lookup::{Comparison, MapLookup};
use shadowlab::render::{Bias, Filter, Format, Renderer, Spacing, Stored, step_along_ray};
use shadowlab::scene::{DirectionalLight, SpotLight};
use shadowlab::{Light, Parameterization, Progress};

use super::oracle::{logarithm, ortho, rectilinear, warp, warped_spot};
use crate::support::cpu::{Random, one_map, triangles};

const SIZE: [u32; 2] = [64; 2];
/// Vertices are rounded to 1/256 of a texel, each way by half of it: in reaches of a nearest lookup.
const SNAP: f64 = 2.0 / 256.0;
/// Roundings to f32 of the map, and of the triangle's plane, relative to the whole depth.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// A plane through the origin, a map that looks at it at an angle to its normal, and its light.
struct Sheet {
    normal: DVec3,
    along: [DVec3; 2],
    p: Parameterization,
    light: Light,
    name: String,
}

impl Sheet {
    fn new(random: &mut Random, degrees: f64, kind: usize) -> Self {
        let normal = random.vector(-1.0, 1.0).normalize();
        let (u, v) = normal.any_orthonormal_pair();
        let turn = random.number(0.0, 6.3);
        let side = u * turn.cos() + v * turn.sin();
        let angle = degrees.to_radians();
        let direction = (side * angle.sin() - normal * angle.cos()).normalize();
        let even = DMat4::from_rotation_z(random.number(0.0, 6.3)) * ortho(direction, 3.0);
        let eye = -6.0 * direction;
        let view = glam::dcamera::rh::view::look_to_mat4(eye, direction, DVec3::new(0.3, 0.9, 0.1));
        let spot = glam::dcamera::rh::proj::directx::perspective(0.5, 1.0, 3.0, 9.0) * view;
        let (matrix, name) = match kind {
            0 => (even, "uniform"),
            1 | 3 | 4 => (warp() * even, ["", "warped", "", "log", "rectilinear"][kind]),
            2 => (spot, "spot"),
            _ => (warped_spot(spot, [3.0, 9.0]), "warped spot"),
        };
        let mut p = one_map(matrix);
        match kind {
            3 => p.partitions[0].post_warp = logarithm(),
            4 => p.partitions[0].post_warp = rectilinear(),
            _ => {}
        }
        let light = match kind {
            2 | 5.. => Light::Spot(SpotLight::new(eye, direction, 1.5, 100.0).unwrap()),
            _ => Light::Directional(DirectionalLight::new(direction).unwrap()),
        };
        Self { normal, along: [u, v], p, light, name: format!("{name}, {degrees} degrees") }
    }
    /// A large square of it, moved along its normal; under a placed light it ends before the light.
    fn square(&self, height: f64, half: f64) -> [[DVec3; 3]; 2] {
        let [u, v] = self.along;
        let at = |x: f64, y: f64| height * self.normal + half * (x * u + y * v);
        [[at(-1., -1.), at(1., -1.), at(1., 1.)], [at(-1., -1.), at(1., 1.), at(-1., 1.)]]
    }
    fn point(&self, random: &mut Random) -> DVec3 {
        self.along[0] * random.number(-0.7, 0.7) + self.along[1] * random.number(-0.7, 0.7)
    }
    fn lookup(&self, bias: Bias, filter: Filter, stored: Stored) -> MapLookup {
        MapLookup::new(&self.p.partitions[0], &self.light, DVec3::ZERO, SIZE, bias, filter, stored).unwrap()
    }
    fn map(&self, corners: &[[DVec3; 3]], stored: Stored) -> Vec<f32> {
        CpuRenderer::new().depth_maps(&triangles(corners), &self.p, SIZE, stored, &Progress::new()).unwrap().data
    }
}

/// Half a step of the format, which stored depths are rounded by, and what depths are rounded by anyway.
fn rounding(stored: Stored) -> f64 {
    0.5 * stored.format.step(0.99) + ROUNDING
}

fn biases(stored: Stored) -> [(&'static str, Bias); 2] {
    let ndc = rounding(stored);
    [
        ("plane", Bias { plane: 1.0, slope: SNAP, ndc, ..Bias::NONE }),
        ("slope", Bias { slope: 1.0 + SNAP, ndc, ..Bias::NONE }),
    ]
}

fn kinds() -> impl Iterator<Item = Stored> {
    Spacing::NAMES.into_iter().flat_map(|(_, spacing)| {
        Format::NAMES.into_iter().map(move |(_, format)| Stored { spacing, format, ..Stored::default() })
    })
}

#[test]
fn planes_have_no_acne_in_any_format_or_spacing() {
    let mut random = Random(41);
    let mut without = 0;
    for degrees in 1..90 {
        let sheet = Sheet::new(&mut random, f64::from(degrees), degrees as usize % 6);
        let corners = sheet.square(0.0, 4.0);
        for stored in kinds() {
            let map = sheet.map(&corners, stored);
            for filter in [Filter::Nearest, Filter::Bilinear] {
                for (part, bias) in biases(stored) {
                    let lookup = sheet.lookup(bias, filter, stored);
                    let bare = sheet.lookup(Bias { slope: 0.0, plane: 0.0, ..bias }, filter, stored);
                    let mut looked_at = 0;
                    for _ in 0..120 {
                        let q = sheet.point(&mut random);
                        looked_at += usize::from(matches!(lookup.compare_at(q, sheet.normal), Comparison::At(_)));
                        let light = lookup.light(&map, q, sheet.normal);
                        assert_eq!(light, 1.0, "{}, {stored}, {filter:?}: acne by {part} at {q}", sheet.name);
                        without += usize::from(bare.light(&map, q, sheet.normal) < 1.0);
                    }
                    assert!(looked_at > 60, "{}: {looked_at} in the map", sheet.name);
                }
            }
        }
    }
    assert!(without > 10_000, "{without}: no acne to remove");
}

#[test]
fn a_caster_beyond_the_gap_shades_planes_in_any_format_and_spacing() {
    let (mut random, mut looked_at) = (Random(42), 0);
    for degrees in (1..90).step_by(3) {
        let sheet = Sheet::new(&mut random, f64::from(degrees), degrees as usize / 3 % 6);
        for stored in kinds() {
            // World units along the ray for a whole unit of depth: steps of even numbers are alike at all depths.
            let even = Stored { format: Format::Unorm16, ..stored };
            let step = step_along_ray(&sheet.p.partitions[0], &even).unwrap();
            for (part, bias) in biases(stored) {
                let points: Vec<DVec3> = (0..60).map(|_| sheet.point(&mut random)).collect();
                let lookup = sheet.lookup(bias, Filter::Nearest, stored);
                // What the bias takes off the depth of the plane, and up to as much that the plane itself falls from the
                // point to the texel's centre where that is not counted; then the rounding of the stored depth.
                let bare = sheet.lookup(Bias { plane: bias.plane, ..Bias::NONE }, Filter::Nearest, stored);
                let depth = |lookup: &MapLookup, q: DVec3| match lookup.compare_at(q, sheet.normal) {
                    Comparison::At(at) => lookup.depth_at(&at, at.p_texel.floor() + 0.5),
                    Comparison::Lit => 0.0,
                };
                let along = |q: &DVec3| 65535.0 * step(*q) * (depth(&bare, *q) - depth(&lookup, *q));
                let off = points.iter().map(along).fold(0.0, f64::max);
                let unit = points.iter().map(|q| 65535.0 * step(*q)).fold(0.0, f64::max);
                let gap = 1.1 * (2.0 * off + unit * rounding(stored));
                let height = gap * f64::from(degrees).to_radians().cos();
                if gap > 2.5 {
                    continue; // the square ends, or the light is on this side of it
                }
                let corners: Vec<_> = sheet.square(0.0, 4.0).into_iter().chain(sheet.square(height, 4.0)).collect();
                let map = sheet.map(&corners, stored);
                for q in points {
                    if let Comparison::At(_) = lookup.compare_at(q, sheet.normal) {
                        let light = lookup.light(&map, q, sheet.normal);
                        assert_eq!(light, 0.0, "{}, {stored}: light by {part} at {q} under {gap}", sheet.name);
                        looked_at += 1;
                    }
                }
            }
        }
    }
    assert!(looked_at > 10_000, "{looked_at}");
}

#[test]
fn steps_are_those_of_the_stored_depth() {
    let mut random = Random(43);
    for kind in 0..6 {
        let sheet = Sheet::new(&mut random, 30.0, kind);
        for stored in kinds() {
            let step = step_along_ray(&sheet.p.partitions[0], &stored).unwrap();
            let lookup = sheet.lookup(Bias::NONE, Filter::Nearest, stored);
            for _ in 0..20 {
                let q = sheet.point(&mut random);
                let to_light = lookup.way_to_light(q);
                let depth = |q: DVec3| match lookup.compare_at(q, sheet.normal) {
                    Comparison::At(at) => lookup.depth_at(&at, at.p_texel.floor() + 0.5),
                    Comparison::Lit => panic!("{q} is in the map"),
                };
                let h = 1e-5;
                let per_world = (depth(q - h * to_light) - depth(q + h * to_light)) / (2.0 * h);
                let expected = stored.format.step(depth(q)) / per_world;
                assert!((step(q) / expected - 1.0).abs() < 1e-6, "{}, {stored}: {} {expected}", sheet.name, step(q));
            }
        }
    }
}

#[test]
fn gaps_are_in_world_units_in_any_spacing() {
    let mut random = Random(44);
    for kind in 0..6 {
        let sheet = Sheet::new(&mut random, 35.0, kind);
        let height = 0.5;
        let corners: Vec<_> = sheet.square(0.0, 4.0).into_iter().chain(sheet.square(height, 4.0)).collect();
        for (_, spacing) in Spacing::NAMES {
            let stored = Stored { spacing, ..Stored::default() };
            let map = sheet.map(&corners, stored);
            let lookup = sheet.lookup(Bias::default(), Filter::Nearest, stored);
            for _ in 0..40 {
                let q = sheet.point(&mut random);
                let probe = lookup.probe(&map, q, sheet.normal, false);
                let Some(tap) = probe.taps.iter().find(|tap| tap.weight > 0.0) else { continue };
                // Along the ray of the texel's centre, which meets the plane at another angle.
                let at = lookup.on_plane_at(q, sheet.normal, tap.centre).unwrap();
                let expected = height / sheet.normal.dot(lookup.way_to_light(at));
                assert!((tap.gap - expected).abs() < 1e-3, "{}, {stored}: {} {expected}", sheet.name, tap.gap);
            }
        }
    }
}
