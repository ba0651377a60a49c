//! An interior, about 23,000 triangles: a hall under an open roof of trusses and laths, its shadows all over floor and walls.
//!
//! ```text
//!            /|\          trusses every 2.5 m, purlins and laths between them, some laths missing
//!          /__|__\
//!         |       |       the light comes steeply from one side, so that floor and one long wall carry the pattern
//!         |_______|
//! ```
//! In the spirit of the scene "Ceiling" of "Theory to Practice: Generalized Minimum-Norm Perspective Shadow Maps" (2007,
//! section 4); the hall is our own. What it shows: casters close to the light cover the whole map, and no direction of it is
//! empty; focusing gains nothing and a warp has to earn its place.

use glam::{DVec2, DVec3};

use super::architecture::arch;
use super::assembly::{Assembly, turned};
use super::builder::Shape;
use super::random::Random;
use super::spec::{LibraryParam, LibraryScene, LibrarySpec, Values};
use crate::error::Result;
use crate::scene::{Camera, DirectionalLight, Light};

/// The scene's self-description.
pub(super) const SPEC: LibrarySpec = LibrarySpec {
    name: "ceiling",
    title: "Hall under an open roof",
    shows: "casters over the whole map: light through trusses and laths patterns floor and walls",
    params: &[
        LibraryParam {
            name: "trusses",
            default: 12.0,
            min: 3.0,
            max: 200.0,
            whole: true,
            doc: "roof trusses, 2.5 m apart",
        },
        LibraryParam {
            name: "missing",
            default: 0.22,
            min: 0.0,
            max: 0.9,
            whole: false,
            doc: "share of the roof's laths that is gone",
        },
    ],
    build,
};

const PITCH: f64 = 2.5;
const HALF_WIDTH: f64 = 6.0;
const EAVES: f64 = 5.2;
const RIDGE: f64 = 8.6;
/// Laths on each side of the ridge.
const LATHS: usize = 13;

fn build(seed: u64, values: &Values) -> Result<LibraryScene> {
    let trusses = values.count("trusses");
    let end = -(PITCH * (trusses + 1) as f64);
    let mut assembly = Assembly::new(values.progress);
    walls(&mut assembly, end)?;
    roof(&mut assembly, trusses, values.number("missing"), seed)?;
    piers(&mut assembly, trusses)?;
    furniture(&mut assembly, trusses, seed)?;
    let camera = Camera::look_at(
        DVec3::new(2.6, 2.3, -1.0),
        DVec3::new(-1.3, 2.1, -15.0),
        DVec3::Y,
        62f64.to_radians(),
        16.0 / 9.0,
        0.2,
        -end + 20.0,
    )?;
    let light = Light::Directional(DirectionalLight::new(DVec3::new(-0.52, -0.8, -0.22))?);
    Ok(LibraryScene { name: SPEC.name, scene: assembly.scene()?, camera, light })
}

fn walls(assembly: &mut Assembly, end: f64) -> Result<()> {
    assembly.fixed(&Shape::cuboid(DVec3::new(-8.0, -0.6, end - 4.0), DVec3::new(8.0, 0.0, 2.0)))?;
    let mut walls = Shape::default();
    for side in [-1.0, 1.0] {
        let (inner, outer) = (side * HALF_WIDTH, side * (HALF_WIDTH + 0.5));
        let (x0, x1) = (f64::min(inner, outer), f64::max(inner, outer));
        walls.add(Shape::cuboid(DVec3::new(x0, -0.3, end), DVec3::new(x1, EAVES, 0.0)));
        // The far wall stands on both sides of an arched doorway.
        let (inner, outer) = (side * 1.9, side * (HALF_WIDTH + 0.6));
        let (x0, x1) = (f64::min(inner, outer), f64::max(inner, outer));
        walls.add(Shape::cuboid(DVec3::new(x0, -0.31, end - 0.6), DVec3::new(x1, 2.6, end + 0.01)));
    }
    walls.add(arch(3.82, 1.6, 2.62, 0.6).moved(DVec3::new(0.0, 2.58, end - 0.29)));
    for side in [-1.0, 1.0] {
        let (inner, outer) = (side * 1.89, side * (HALF_WIDTH + 0.58));
        let (x0, x1) = (f64::min(inner, outer), f64::max(inner, outer));
        walls.add(Shape::cuboid(DVec3::new(x0, 2.59, end - 0.59), DVec3::new(x1, EAVES, end)));
    }
    for z in [end - 0.3, 0.3] {
        // Gables; behind the viewer a whole wall under one.
        let lower = [-HALF_WIDTH - 0.6, 0.0, HALF_WIDTH + 0.6]
            .map(|x| DVec2::new(x, if z > 0.0 { -0.3 } else { EAVES - 0.02 }));
        let upper = [0.1, RIDGE - EAVES + 0.35, 0.1].map(|y| EAVES + y);
        let upper = [0, 1, 2].map(|k: usize| DVec2::new(lower[k].x, upper[k]));
        walls.add(Shape::plate(&lower, &upper, z - 0.29, z + 0.29));
    }
    assembly.fixed(&walls)
}

fn roof(assembly: &mut Assembly, trusses: usize, missing: f64, seed: u64) -> Result<()> {
    let p = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let ridge = p(0.0, RIDGE);
    let mut truss = Shape::beam(p(-HALF_WIDTH - 0.3, EAVES), p(HALF_WIDTH + 0.3, EAVES), 0.26, 0.34)
        .with(Shape::beam(p(0.0, EAVES), ridge, 0.24, 0.24))
        .with(Shape::beam(p(-2.6, 6.75), p(2.6, 6.75), 0.16, 0.2));
    for side in [-1.0, 1.0] {
        let eaves = p(side * (HALF_WIDTH + 0.5), EAVES - 0.1);
        truss.add(Shape::beam(eaves, ridge, 0.22, 0.28));
        truss.add(Shape::beam(p(0.0, EAVES + 0.25), p(side * 2.9, 6.85), 0.15, 0.18));
        truss.add(Shape::beam(p(side * 3.0, EAVES), p(side * 3.0, 6.8), 0.14, 0.16));
        truss.add(Shape::beam(p(side * HALF_WIDTH, 3.7), p(side * 4.6, EAVES), 0.16, 0.18));
    }
    let truss = assembly.part(&truss)?;
    for k in 0..trusses {
        assembly.place_at(truss, 0.0, 0.0, -PITCH * (k as f64 + 1.0));
    }
    let length = PITCH * (trusses + 1) as f64;
    let along = |width: f64, height: f64, length: f64| Shape::block(DVec3::new(width, height, length));
    let purlin = assembly.part(&along(0.16, 0.2, length))?;
    // Two laths in a bay, so that a missing one leaves a gap of half a bay.
    let lath = assembly.part(&along(0.2, 0.05, 0.5 * PITCH + 0.02))?;
    let slope = |t: f64, side: f64| DVec2::new(side * t * (HALF_WIDTH + 0.5), RIDGE - t * (RIDGE - EAVES + 0.1));
    let mut random = Random::new(seed, 3);
    for side in [-1.0, 1.0] {
        for t in [0.33, 0.66, 0.97] {
            let at = slope(t, side);
            assembly.place_at(purlin, at.x, at.y + 0.1, -0.5 * length);
        }
        for row in 0..LATHS {
            let at = slope((row as f64 + 0.35) / LATHS as f64, side);
            for half_bay in 0..2 * (trusses + 1) {
                if random.unit() >= missing {
                    let z = -0.5 * PITCH * (half_bay as f64 + 0.5);
                    assembly.place_at(lath, at.x + random.range(-0.03, 0.03), at.y + 0.33, z);
                }
            }
        }
    }
    assembly.place_at(purlin, 0.0, RIDGE + 0.06, -0.5 * length);
    Ok(())
}

/// Round half-columns along both walls, one under each truss.
fn piers(assembly: &mut Assembly, trusses: usize) -> Result<()> {
    let shaft = [
        [0.0, -0.02],
        [0.36, -0.02],
        [0.36, 0.1],
        [0.27, 0.24],
        [0.235, 0.5],
        [0.21, 3.0],
        [0.27, 3.1],
        [0.24, 3.18],
        [0.35, 3.42],
        [0.0, 3.44],
    ];
    let pier = Shape::lathe(&shaft, 20).with(Shape::block(DVec3::new(0.7, 0.24, 0.7)).moved(DVec3::Y * 3.42));
    let pier = assembly.part(&pier)?;
    for k in 0..trusses {
        for side in [-1.0, 1.0] {
            assembly.place_at(pier, side * (HALF_WIDTH - 0.12), 0.0, -PITCH * (k as f64 + 1.0));
        }
    }
    Ok(())
}

/// Benches on both sides of the aisle, a few barrels and crates, ring lamps on chains.
fn furniture(assembly: &mut Assembly, trusses: usize, seed: u64) -> Result<()> {
    let mut random = Random::new(seed, 4);
    let mut bench = Shape::block(DVec3::new(2.9, 0.06, 0.42)).moved(DVec3::Y * 0.44);
    for k in 0..3 {
        let back = DVec3::new(0.0, 0.62 + 0.16 * f64::from(k), 0.2 + 0.03 * f64::from(k));
        bench.add(Shape::block(DVec3::new(2.9, 0.1, 0.03)).moved(back));
    }
    for x in [-1.38, 0.0, 1.38] {
        bench.add(Shape::block(DVec3::new(0.07, 0.46, 0.36)).moved(DVec3::new(x, -0.01, 0.0)));
        bench.add(Shape::beam(DVec3::new(x, 0.4, 0.18), DVec3::new(x, 1.06, 0.31), 0.06, 0.05));
    }
    let bench = assembly.part(&bench)?;
    let barrel = [
        [0.0, -0.01],
        [0.27, -0.01],
        [0.31, 0.2],
        [0.335, 0.45],
        [0.31, 0.7],
        [0.27, 0.9],
        [0.24, 0.9],
        [0.24, 0.86],
        [0.0, 0.86],
    ];
    let barrel = assembly.part(&Shape::lathe(&barrel, 16))?;
    let crate_part = assembly.part(&Shape::chamfered_block(DVec3::new(0.8, 0.7, 0.8), 0.03).moved(DVec3::Y * -0.01))?;
    let lamp = assembly.part(&lamp())?;
    for k in 0..trusses.saturating_sub(2) {
        let z = -PITCH * (k as f64 + 2.0) - 1.0;
        for side in [-1.0, 1.0] {
            assembly.place(bench, turned(DVec3::new(side * 2.9, 0.0, z), random.range(-0.04, 0.04)));
        }
        if k % 3 == 1 {
            assembly.place_at(lamp, 0.0, 3.0, -PITCH * (k as f64 + 1.0));
        }
    }
    for k in 0..4 {
        let angle = random.range(0.0, 1.5);
        let at = DVec3::new(-5.0 + 0.75 * f64::from(k % 2), 0.0, -2.9 - 0.8 * f64::from(k));
        let part = if k % 2 == 0 { crate_part } else { barrel };
        assembly.place(part, turned(at + DVec3::X * random.range(-0.06, 0.06), angle));
    }
    Ok(())
}

/// An iron ring of 0.8 m radius with eight candles, hung from a rod; the ring is at y = 0.
fn lamp() -> Shape {
    let hoop: Vec<[f64; 2]> = vec![[0.77, -0.03], [0.82, -0.03], [0.82, 0.03], [0.77, 0.03]];
    let mut lamp = super::builder::ring(&hoop, 32);
    lamp.add(Shape::lathe(&[[0.02, 0.75], [0.02, EAVES - 3.1]], 6));
    for turn in super::builder::circle(8).map(|(_, c)| DVec3::new(c.x, 0.0, c.y) * 0.795) {
        lamp.add(Shape::lathe(&[[0.03, 0.02], [0.03, 0.2], [0.0, 0.26]], 8).moved(turn));
        lamp.add(Shape::tube(&[(turn, 0.012), (DVec3::Y * 0.8, 0.012)], 4));
    }
    lamp
}
