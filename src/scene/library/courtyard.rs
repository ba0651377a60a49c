//! The demo: a court between two arcades in low afternoon sun, near to far.
//!
//! ```text
//!   x = -15 wall | gallery | arcade -10 |  lawn railings, statues, fountain  | arcade 10 | <- sun, low
//!                                          terrace and stairs at z > 2, temple front beyond the last bay
//! ```
//! What it shows: shadow texels are needed from the balustrade in front of the eye to the temple 70 m away; thin railings
//! and flutes tell aliasing apart; light falls through arches onto the paving.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DAffine3, DVec2, DVec3};

use super::architecture::{arch, baluster, column, fountain, plinth, railing, stairs, urn};
use super::assembly::{Assembly, standing, turned};
use super::builder::Shape;
use super::figures::{Pose, figure};
use super::random::Random;
use super::spec::{LibraryParam, LibraryScene, LibrarySpec, Values};
use super::trees::{poplar, topiary};
use crate::error::Result;
use crate::scene::{Camera, DirectionalLight, Light};

/// The scene's self-description.
pub(super) const SPEC: LibrarySpec = LibrarySpec {
    name: "courtyard",
    title: "Courtyard in low sun",
    shows: "near to far: a balustrade before the eye, long slanted shadows over the paving, a temple 70 m away",
    params: &[
        LibraryParam {
            name: "bays",
            default: 12.0,
            min: 4.0,
            max: 60.0,
            whole: true,
            doc: "arches on each side, 4.5 m each",
        },
        LibraryParam {
            name: "flutes",
            default: 20.0,
            min: 6.0,
            max: 96.0,
            whole: true,
            doc: "flutes of a column, 4 facets each",
        },
    ],
    build,
};

const BAY: f64 = 4.5;
const ARCADE_X: f64 = 10.0;
const TERRACE: f64 = 1.05;
const COLUMN: f64 = 4.5;
const ARCH_TOP: f64 = 2.5;

fn build(seed: u64, values: &Values) -> Result<LibraryScene> {
    let (bays, flutes) = (values.count("bays"), values.count("flutes"));
    let end = -(BAY * bays as f64);
    let mut assembly = Assembly::new(values.progress);
    let column = assembly.part(&column(flutes))?;

    let ground = Shape::cuboid(DVec3::new(-60.0, -1.0, end - 40.0), DVec3::new(60.0, 0.0, 40.0));
    assembly.fixed(&ground)?;
    arcades(&mut assembly, column, bays)?;
    gallery(&mut assembly, end)?;
    temple(&mut assembly, column, end)?;
    terrace(&mut assembly)?;
    garden(&mut assembly, end)?;
    planting(&mut assembly, seed, end)?;

    let camera = Camera::look_at(
        DVec3::new(-6.2, TERRACE + 1.6, 6.1),
        DVec3::new(0.5, 1.2, -24.0),
        DVec3::Y,
        54f64.to_radians(),
        16.0 / 9.0,
        0.3,
        160.0,
    )?;
    let light = Light::Directional(DirectionalLight::new(DVec3::new(-0.86, -0.47, -0.25))?);
    Ok(LibraryScene { name: SPEC.name, scene: assembly.scene()?, camera, light })
}

/// Columns, arches and a cornice with dentils on both sides.
fn arcades(assembly: &mut Assembly, column: super::assembly::Part, bays: usize) -> Result<()> {
    let arch = assembly.part(&arch(BAY, 1.78, ARCH_TOP, 0.72))?;
    let length = BAY * bays as f64;
    let middle = -0.5 * length;
    let course = |width: f64, low: f64, high: f64| {
        Shape::block(DVec3::new(width, high - low, length + width)).moved(DVec3::Y * low)
    };
    let top = COLUMN + ARCH_TOP;
    let cornice = course(0.8, top - 0.02, top + 0.3)
        .with(course(1.0, top + 0.44, top + 0.56))
        .with(course(0.84, top + 0.28, top + 0.46))
        .with(course(1.2, top + 0.54, top + 0.64))
        .with(course(0.7, top + 0.62, top + 0.8));
    let cornice = assembly.part(&cornice)?;
    let dentil = assembly.part(&Shape::block(DVec3::new(1.0, 0.12, 0.16)))?;
    for side in [-1.0, 1.0] {
        let x = side * ARCADE_X;
        for k in 0..=bays {
            assembly.place_at(column, x, 0.0, -BAY * k as f64);
        }
        for k in 0..bays {
            assembly.place(arch, turned(DVec3::new(x, COLUMN, -BAY * (k as f64 + 0.5)), FRAC_PI_2));
        }
        assembly.place_at(cornice, x, 0.0, middle);
        let dentils = (length / 0.375).round() as usize;
        for k in 0..dentils {
            assembly.place_at(dentil, x, top + 0.31, -(k as f64 + 0.5) * length / dentils as f64);
        }
    }
    Ok(())
}

/// Behind the left arcade: a wall with pilasters and a flat roof.
fn gallery(assembly: &mut Assembly, end: f64) -> Result<()> {
    let wall = Shape::cuboid(DVec3::new(-15.6, -0.1, end - 0.5), DVec3::new(-15.0, 8.2, 0.5));
    let roof = Shape::cuboid(DVec3::new(-15.2, COLUMN + ARCH_TOP + 0.05, end - 0.3), DVec3::new(-10.3, 7.26, 0.3));
    assembly.fixed(&wall.with(roof))?;
    let pilaster = Shape::block(DVec3::new(0.3, 6.9, 0.7)).with(Shape::block(DVec3::new(0.5, 0.4, 0.9)));
    let pilaster = assembly.part(&pilaster.with(Shape::block(DVec3::new(0.46, 0.3, 0.86)).moved(DVec3::Y * 6.4)))?;
    let count = (-end / BAY).round() as usize;
    for k in 0..=count {
        assembly.place_at(pilaster, -14.9, -0.02, -BAY * k as f64);
    }
    // A low wall closes the garden on the sunny side.
    let parapet = Shape::cuboid(DVec3::new(22.0, -0.1, end - 2.0), DVec3::new(22.4, 1.6, 3.0));
    assembly.fixed(&parapet.with(Shape::cuboid(DVec3::new(21.9, 1.58, end - 2.1), DVec3::new(22.5, 1.7, 3.1))))
}

/// The far end: six tall columns under a pediment, on three steps.
fn temple(assembly: &mut Assembly, column: super::assembly::Part, end: f64) -> Result<()> {
    const SCALE: f64 = 1.5;
    let front = end - 5.0;
    let base = 0.9;
    let mut body = Shape::default();
    for k in 0..3 {
        let (grow, top) = (0.45 * f64::from(2 - k), 0.3 * f64::from(k + 1));
        body.add(Shape::cuboid(
            DVec3::new(-8.0 - grow, -0.2 - 0.01 * f64::from(k), front - 9.0 - grow),
            DVec3::new(8.0 + grow, top, front + 1.0 + grow),
        ));
    }
    let eaves = base + SCALE * COLUMN;
    // The cella: two walls and a lintel leave a doorway, which stays dark.
    for (x0, x1, y0, y1) in [(-7.0, -1.3, base, eaves), (1.3, 7.0, base, eaves), (-1.4, 1.4, base + 4.4, eaves)] {
        body.add(Shape::cuboid(DVec3::new(x0, y0 - 0.05, front - 8.5), DVec3::new(x1, y1 + 0.03, front - 4.0)));
    }
    body.add(Shape::cuboid(DVec3::new(-7.4, eaves - 0.02, front - 8.8), DVec3::new(7.4, eaves + 0.8, front + 0.7)));
    body.add(Shape::cuboid(DVec3::new(-7.7, eaves + 0.78, front - 9.0), DVec3::new(7.7, eaves + 1.0, front + 1.0)));
    let gable = |half: f64, low: f64, high: f64| {
        let xs = [-half, 0.0, half];
        let lower = xs.map(|x| DVec2::new(x, low));
        let upper = [DVec2::new(-half, low + 0.06), DVec2::new(0.0, high), DVec2::new(half, low + 0.06)];
        (lower, upper)
    };
    let (lower, upper) = gable(7.5, eaves + 0.98, eaves + 3.1);
    body.add(Shape::plate(&lower, &upper, front - 8.7, front + 0.5));
    // Raking cornices over the gable.
    let lift = DVec2::new(0.0, 0.28);
    let (_, slope) = gable(7.9, eaves + 0.96, eaves + 3.12);
    body.add(Shape::plate(&slope, &slope.map(|p| p + lift), front - 9.0, front + 1.0));
    assembly.fixed(&body)?;
    for k in 0..6 {
        let at = DVec3::new(-6.5 + 2.6 * f64::from(k), base - 0.01, front);
        assembly.place(column, standing(at, DVec2::X, SCALE));
    }
    let statue = assembly.part(&figure(Pose::Winged, 32))?;
    assembly.place(statue, standing(DVec3::new(0.0, eaves + 3.3, front), DVec2::X, 1.0));
    Ok(())
}

/// Where the viewer stands: a terrace with a balustrade, urns and stairs down to the court.
fn terrace(assembly: &mut Assembly) -> Result<()> {
    const STAIR: f64 = 3.2;
    const FRONT: f64 = 4.2;
    assembly.fixed(&Shape::cuboid(DVec3::new(-16.0, -0.3, FRONT - 0.35), DVec3::new(16.0, TERRACE, 30.0)))?;
    let flight = stairs(6, TERRACE / 6.0 - 0.001, 0.36, 2.0 * STAIR);
    assembly.fixed(&flight.moved(DVec3::Z * (FRONT + 1.75)))?;
    let pier = Shape::block(DVec3::new(0.62, 1.12, 0.62))
        .with(Shape::block(DVec3::new(0.76, 0.12, 0.76)).moved(DVec3::Y * 1.1));
    let pier = assembly.part(&pier.with(Shape::block(DVec3::new(0.72, 0.2, 0.72))))?;
    let (urn, baluster) = (assembly.part(&urn())?, assembly.part(&baluster())?);
    for side in [-1.0, 1.0] {
        let rail = |low: f64, high: f64, half: f64| {
            let (inner, outer) = (side * (STAIR + 0.4), side * 15.6);
            let (x0, x1) = (f64::min(inner, outer), f64::max(inner, outer));
            Shape::cuboid(DVec3::new(x0, TERRACE + low, FRONT - half), DVec3::new(x1, TERRACE + high, FRONT + half))
        };
        assembly.fixed(&rail(-0.02, 0.16, 0.17).with(rail(0.85, 0.92, 0.14)).with(rail(0.91, 1.0, 0.19)))?;
        for k in 0..4 {
            let x = side * (STAIR + 0.4 + 3.9 * f64::from(k));
            assembly.place_at(pier, x, TERRACE - 0.02, FRONT);
            if k < 2 {
                assembly.place_at(urn, x, TERRACE + 1.2, FRONT);
            }
            for b in 0..11 {
                let step = side * (0.45 + 0.3 * f64::from(b));
                assembly.place_at(baluster, x + step, TERRACE + 0.15, FRONT);
            }
        }
    }
    Ok(())
}

/// Along the middle: the fountain, statues on plinths, iron railings beside the walk.
fn garden(assembly: &mut Assembly, end: f64) -> Result<()> {
    const PLINTH: f64 = 1.5;
    const PANEL: f64 = 2.25;
    let fountain_z = (-20.25f64).max(0.5 * end - 2.0);
    let fountain = assembly.part(&fountain())?;
    assembly.place_at(fountain, 0.0, 0.0, fountain_z);
    let plinth = assembly.part(&plinth(PLINTH))?;
    let figures = [Pose::Torch, Pose::Guard, Pose::Winged].map(|pose| figure(pose, 64));
    let figures = figures.iter().map(|f| assembly.part(f)).collect::<Result<Vec<_>>>()?;
    assembly.place(figures[0], standing(DVec3::new(0.0, 2.66, fountain_z), DVec2::X, 0.6));
    let panel = assembly.part(&railing(PANEL, 18))?;
    let places = ((-end - 4.5) / (2.0 * BAY)) as usize + 1;
    for k in 0..places {
        let z = -BAY * (1.5 + 2.0 * k as f64);
        for (side, part) in [(-1.0, figures[(2 * k) % 3]), (1.0, figures[(2 * k + 1) % 3])] {
            let x = side * 5.4;
            assembly.place_at(plinth, x, 0.0, z);
            // Turned to the walk and a little towards the terrace.
            assembly.place(part, turned(DVec3::new(x, PLINTH - 0.01, z), -side * 0.22 * PI));
        }
    }
    let panels = ((-end - 5.0) / PANEL) as usize;
    for k in 0..panels {
        let z = -3.5 - PANEL * k as f64;
        // Open around the fountain.
        if (z - 0.5 * PANEL - fountain_z).abs() > 4.2 {
            for side in [-1.0, 1.0] {
                assembly.place(panel, turned(DVec3::new(side * 4.1, 0.0, z), FRAC_PI_2));
            }
        }
    }
    Ok(())
}

/// Topiary in planters between the statues, cypresses beyond the sunny arcade.
fn planting(assembly: &mut Assembly, seed: u64, end: f64) -> Result<()> {
    let mut random = Random::new(seed, 1);
    let tub = Shape::lathe(
        &[
            [0.0, -0.02],
            [0.3, -0.02],
            [0.34, 0.06],
            [0.42, 0.5],
            [0.47, 0.52],
            [0.47, 0.6],
            [0.4, 0.6],
            [0.38, 0.52],
            [0.0, 0.5],
        ],
        32,
    );
    let tubs = [0, 1, 2].map(|_| tub.clone().with(topiary(&mut random).moved(DVec3::Y * 0.5)));
    let tubs = tubs.iter().map(|t| assembly.part(t)).collect::<Result<Vec<_>>>()?;
    let cypresses = [0, 1].map(|_| poplar(&mut random));
    let cypresses = cypresses.iter().map(|t| assembly.part(t)).collect::<Result<Vec<_>>>()?;
    let rows = (-end / (2.0 * BAY)) as usize;
    for k in 0..rows {
        let z = -BAY * (2.5 + 2.0 * k as f64);
        for side in [-1.0, 1.0] {
            let at = DVec3::new(side * (7.6 + random.range(-0.1, 0.1)), 0.0, z + random.range(-0.2, 0.2));
            let heading = random.direction();
            assembly.place(tubs[random.below(3)], standing(at, heading, random.range(0.95, 1.15)));
        }
        let at = DVec3::new(random.range(14.5, 19.0), 0.0, z + random.range(-1.5, 1.5));
        let heading = random.direction();
        let size = random.range(0.75, 1.05);
        let slim = DAffine3::from_scale(DVec3::new(0.8, 1.0, 0.8));
        assembly.place(cypresses[k % 2], standing(at, heading, size) * slim);
    }
    Ok(())
}
