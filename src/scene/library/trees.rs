//! Trees: of a few hundred triangles each for scenes that place them by the thousand, and finer ones for gardens.
//!
//! Every tree stands on y = 0 with half a metre of trunk below it, so that none floats on a slope. A seed changes the shape of
//! a tree, never its number of triangles.

use glam::{DVec2, DVec3};

use super::builder::Shape;
use super::random::Random;

/// How deep trunks reach below the ground, metres.
const ROOT_DEPTH: f64 = 0.5;

/// A spruce, 11 m: jagged tiers of drooping cones.
pub(super) fn spruce(random: &mut Random) -> Shape {
    const TIERS: usize = 8;
    const HEIGHT: f64 = 11.0;
    let mut tree = Shape::lathe(&[[0.24, -ROOT_DEPTH], [0.19, 1.6], [0.0, 0.9 * HEIGHT]], 7);
    for tier in 0..TIERS {
        let t = tier as f64 / TIERS as f64;
        let foot = 1.1 + 0.86 * (HEIGHT - 1.1) * t;
        let radius = 2.5 * (1.0 - 0.9 * t) * random.range(0.9, 1.1);
        let tip = foot + (2.5 - 1.1 * t) * random.range(0.95, 1.1);
        let offset = random.direction() * (0.12 * (1.0 - t));
        let jag = random.unit();
        let cone = Shape::lathe_modulated(&[[0.0, foot + 0.5], [radius, foot], [0.0, tip]], 14, |turn, _| {
            // Every other point is drawn in: boughs and the gaps between them.
            let is_bough = ((turn * 14.0).round() as usize).is_multiple_of(2);
            if is_bough { 1.0 + 0.12 * ((turn + jag) * 5.0).fract() } else { 0.68 }
        });
        tree.add(cone.moved(DVec3::new(offset.x, 0.0, offset.y)));
    }
    tree
}

/// A broad tree, 9 m: a forked trunk under a crown of leafy lumps.
pub(super) fn oak(random: &mut Random) -> Shape {
    const LUMPS: usize = 10;
    let fork = DVec3::new(0.1, 2.4, 0.05);
    let mut tree = Shape::tube(&[(DVec3::Y * -ROOT_DEPTH, 0.45), (DVec3::Y * 0.4, 0.3), (fork, 0.24)], 7);
    // The golden angle spreads the lumps around the crown whatever their number; built from its cosine and sine.
    let golden = DVec2::new(-0.737_368_878_078_319_7, 0.675_490_294_261_523_8);
    let mut heading = random.direction();
    for lump in 0..LUMPS {
        let t = lump as f64 / (LUMPS - 1) as f64;
        heading = golden.rotate(heading);
        // A dome: wide at its foot, closing to the top.
        let out = 2.5 * (1.0 - t * t) * random.range(0.8, 1.1);
        let center = DVec3::new(heading.x * out, 3.7 + 3.6 * t + random.range(-0.3, 0.3), heading.y * out);
        tree.add(Shape::tube(&[(fork - DVec3::Y * 0.2, 0.16), (center, 0.05)], 4));
        let size = random.range(1.25, 1.7) * (1.1 - 0.2 * t);
        tree.add(leafy_lump(center, DVec3::new(size, 0.72 * size, size), 8, 5, 0.06, random));
    }
    tree
}

/// A slender tree, 10 m: a spindle of foliage (poplar, cypress).
pub(super) fn poplar(random: &mut Random) -> Shape {
    let profile: Vec<[f64; 2]> = [
        [0.0, 0.9],
        [0.55, 1.1],
        [0.92, 2.0],
        [1.05, 3.3],
        [1.0, 4.7],
        [0.85, 6.1],
        [0.62, 7.5],
        [0.36, 8.8],
        [0.0, 10.2],
    ]
    .to_vec();
    let phase = random.unit();
    let lean = random.direction() * 0.25;
    let crown = Shape::lathe_modulated(&profile, 14, |turn, height| {
        1.0 + 0.16 * (((turn + phase) * 7.0 + height * 0.9).fract() - 0.5)
    })
    .mapped(|p| p + DVec3::new(lean.x, 0.0, lean.y) * (p.y * p.y / 100.0));
    Shape::lathe(&[[0.2, -ROOT_DEPTH], [0.15, 1.6], [0.0, 6.0]], 7).with(crown)
}

/// A bare tree, about 8 m: boughs that fork three times. Its shadow is a lattice of thin lines.
pub(super) fn bare_tree(random: &mut Random) -> Shape {
    let mut tree = Shape::tube(&[(DVec3::Y * -ROOT_DEPTH, 0.38), (DVec3::Y * 0.5, 0.26), (DVec3::Y * 2.2, 0.19)], 8);
    for _ in 0..4 {
        bough(&mut tree, random, DVec3::Y * 2.0, DVec3::Y, 2.3, 0.13, 3);
    }
    tree
}

fn bough(tree: &mut Shape, random: &mut Random, from: DVec3, along: DVec3, length: f64, radius: f64, forks: usize) {
    let heading = random.direction();
    let spread = random.range(0.45, 0.85);
    let turned = (along + DVec3::new(heading.x, random.range(0.0, 0.5), heading.y) * spread).normalize();
    let bend = random.direction() * (0.08 * length);
    let middle = from + turned * (0.5 * length) + DVec3::new(bend.x, 0.0, bend.y);
    let end = from + turned * length;
    let tip = if forks == 0 { 0.0 } else { 0.6 * radius };
    tree.add(Shape::tube(&[(from, radius), (middle, 0.8 * radius), (end, tip)], 5));
    if forks > 0 {
        for _ in 0..3 {
            bough(tree, random, end, turned, 0.68 * length, 0.58 * radius, forks - 1);
        }
    }
}

/// A shrub, 1 m: three leafy lumps half in the ground.
pub(super) fn shrub(random: &mut Random) -> Shape {
    let mut shrub = Shape::default();
    for size in [0.75, 0.6, 0.5] {
        let heading = random.direction() * (0.75 - size);
        let center = DVec3::new(2.2 * heading.x, 0.1, 2.2 * heading.y);
        shrub.add(leafy_lump(center, DVec3::new(size, 1.1 * size, size), 10, 7, 0.05, random));
    }
    shrub
}

/// A round topiary tree, 2.4 m, for a planter: a straight stem under a dense ball.
pub(super) fn topiary(random: &mut Random) -> Shape {
    let stem = Shape::lathe(&[[0.07, -0.1], [0.05, 0.5], [0.05, 1.5]], 12);
    stem.with(leafy_lump(DVec3::Y * 1.65, DVec3::new(0.72, 0.68, 0.72), 40, 26, 0.028, random))
}

/// A laurel, 3 m, for a tub: a stem, twigs, and a crown of single leaves, 6 triangles each. Light falls
/// through between them.
pub(super) fn laurel(random: &mut Random, leaves: usize) -> Shape {
    const TWIGS: usize = 24;
    let crown = DVec3::new(0.0, 2.05, 0.0);
    let radii = DVec3::new(0.78, 0.95, 0.78);
    let mut tree = Shape::tube(&[(DVec3::Y * -0.1, 0.06), (DVec3::Y * 1.2, 0.045), (DVec3::Y * 2.3, 0.015)], 8);
    for _ in 0..TWIGS {
        let root = DVec3::Y * random.range(1.25, 2.2);
        tree.add(Shape::tube(&[(root, 0.014), (crown + in_ball(random, 0.8) * radii, 0.004)], 4));
    }
    for _ in 0..leaves {
        // Most leaves are near the surface of the crown, which stays open inside.
        let out = in_ball(random, 0.55);
        let at = crown + out * radii;
        let along = (out.normalize() + DVec3::Y * random.range(-0.3, 0.5) + in_ball(random, 0.0) * 0.7).normalize();
        let side = along.any_orthonormal_vector();
        let across = (side + along.cross(side) * random.range(-2.0, 2.0)).normalize();
        let (length, width) = (random.range(0.1, 0.17), 0.042);
        let keel = along.cross(across) * 0.006;
        let middle = at + along * (0.45 * length);
        let ring = [across * width, keel, -across * width].map(|c| middle + c);
        tree.add(Shape::skin(&[vec![at], ring.to_vec(), vec![at + along * length]]));
    }
    tree
}

/// A point of the unit ball that is at least `inner` from its middle.
fn in_ball(random: &mut Random, inner: f64) -> DVec3 {
    loop {
        let p = DVec3::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0), random.range(-1.0, 1.0));
        // The inner bound keeps directions accurate.
        if (inner.max(0.1)..=1.0).contains(&p.length()) {
            return p;
        }
    }
}

/// An ellipsoid with a bumpy surface; `depth` is how deep each of six waves is, relative to the radius.
fn leafy_lump(center: DVec3, radii: DVec3, segments: usize, rings: usize, depth: f64, random: &mut Random) -> Shape {
    let waves: Vec<(DVec3, f64)> = (0..6)
        .map(|_| {
            let k = DVec3::new(random.range(-9.0, 9.0), random.range(-9.0, 9.0), random.range(-9.0, 9.0));
            (k, random.range(0.0, 6.0))
        })
        .collect();
    Shape::ellipsoid(DVec3::ZERO, DVec3::ONE, segments, rings).mapped(|p| {
        let bump: f64 = waves.iter().map(|(k, phase)| (k.dot(p) + phase).sin()).sum();
        center + p * (1.0 + depth * bump) * radii
    })
}
