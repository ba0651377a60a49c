//! Stable maps as rendered: the camera moves, the texels do not.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use shadowlab::geometry::Aabb;
use shadowlab::render::cpu::CpuRenderer;
use shadowlab::render::{Renderer, Stored};
use shadowlab::techniques::{Value, technique};
use shadowlab::{Camera, Progress, Scene};

use crate::support::views::{self, Random, directional};

const RESOLUTION: u32 = 256;

/// Of a texel: rounding of coordinates near 5.4e6 (1e-9) over a texel of 0.3.
const WHOLE: f64 = 1e-6;

/// Two maps of one scene where both have texels.
#[derive(Debug)]
struct Difference {
    /// By how far the shift between the maps misses whole texels.
    off_lattice: f64,
    /// Texels compared that hold a caster.
    covered: usize,
    /// Texels that hold a caster in one of the maps only.
    flips: usize,
    /// Largest change of depth, NDC.
    depth: f64,
    /// Texels compared that hold none.
    empty: usize,
}

impl Difference {
    fn is_none(&self) -> bool {
        self.off_lattice < WHOLE && self.flips == 0 && self.depth < DEPTH_ROUNDING
    }
}

fn compare(scene: &Scene, cameras: [&Camera; 2], stable: bool) -> Difference {
    let t = technique("uniform", &[("stable".to_string(), Value::Flag(stable))]).expect("made");
    let light = directional(DVec3::new(0.4, -1.0, -0.3));
    let n = RESOLUTION as i64;
    let of = |camera: &Camera| {
        let p = t.parameterize(scene, camera, &light, RESOLUTION).expect("a map");
        let maps = CpuRenderer::new()
            .depth_maps(scene, &p, [RESOLUTION; 2], Stored::default(), &Progress::new())
            .expect("maps");
        let (ndc, _) = p.partitions[0].project(scene.origin());
        (maps.data, DVec2::new(ndc.x, -ndc.y) * 0.5 * n as f64)
    };
    let ((a, at_a), (b, at_b)) = (of(cameras[0]), of(cameras[1]));
    let exact = at_b - at_a;
    let shift = exact.round();
    let off_lattice = (exact - shift).abs().max_element();
    let mut d = Difference { off_lattice, covered: 0, flips: 0, depth: 0.0, empty: 0 };
    let (dx, dy) = (shift.x as i64, shift.y as i64);
    for (row, column) in (0..n).flat_map(|row| (0..n).map(move |column| (row, column))) {
        let (to_row, to_column) = (row + dy, column + dx);
        if !(0..n).contains(&to_row) || !(0..n).contains(&to_column) {
            continue;
        }
        let (one, two) = (a[(row * n + column) as usize], b[(to_row * n + to_column) as usize]);
        match (one < 1.0, two < 1.0) {
            (true, true) => {
                d.covered += 1;
                d.depth = d.depth.max(f64::from((one - two).abs()));
            }
            (false, false) => d.empty += 1,
            _ => d.flips += 1,
        }
    }
    d
}

/// Half a step of 16 bits. Corners are rounded to f32 where they lie in the map, to 2^-17 of a texel here, and a triangle seen
/// on edge has its whole depth within a texel; measured: 24 steps of f32.
const DEPTH_ROUNDING: f64 = 64.0 * f32::EPSILON as f64;

/// Turned boxes with nothing under them, so that a map has as many edges as there can be.
fn boxes() -> Scene {
    let mut random = Random(3);
    let parts: Vec<_> = (0..300)
        .map(|_| {
            let at = random.in_box(&Aabb { min: DVec3::new(-40.0, 0.0, -40.0), max: DVec3::new(40.0, 8.0, 40.0) });
            let turn = DMat3::from_axis_angle(random.direction(), random.between(0.0, 3.0));
            (views::cube(), turn * random.between(0.3, 1.5), at)
        })
        .collect();
    views::placed(&parts)
}

#[test]
fn a_moving_camera_moves_the_map_by_whole_texels_and_changes_none() {
    for offset in [DVec3::ZERO, DVec3::new(455_000.0, 80.0, -5_411_000.0)] {
        let scene = boxes().transformed(&DAffine3::from_translation(offset)).expect("moved");
        let look = |eye: DVec3, along: DVec3| views::look(offset + eye, offset + eye + along, 0.9, 0.1, 30.0);
        let eye = DVec3::new(2.0, 4.0, 9.0);
        let along = DVec3::new(-0.2, -0.3, -1.0);
        let first = look(eye, along);
        let moved = [
            ("translated", look(eye + DVec3::new(1.37, 0.21, -2.9), along)),
            ("a hair further", look(eye + DVec3::new(0.013, 0.0, 0.0), along)),
            ("rotated", look(eye, DVec3::new(0.3, -0.1, -1.0))),
            ("both", look(eye + DVec3::new(-3.1, 1.7, 4.4), DVec3::new(0.5, -0.6, -1.0))),
        ];
        for (name, second) in moved {
            let d = compare(&scene, [&first, &second], true);
            assert!(d.covered > 1000 && d.empty > 1000, "{name} {offset}: {d:?}");
            assert!(d.is_none(), "{name} {offset}: {d:?}");
            let loose = compare(&scene, [&first, &second], false);
            assert!(!loose.is_none() && loose.flips > 0, "{name} {offset}: {loose:?}");
        }
    }
}
