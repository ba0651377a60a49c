//! Statues on a plaza before two terraces and a half ring of columns: about 444,000 triangles, no one plane to be best on.
//!
//! ```text
//!                  exedra: columns, statues, the colossus        z = -31, upper terrace 2.1 m
//!        ---- balustrade ---- stairs ---- balustrade ----        z = -19
//!                  lower terrace, laurels, guards                0.9 m
//!     ------- balustrade ------ stairs ------ balustrade ---     z = -8
//!      bare   laurels  statues   walk   statues  laurels         plaza, y = 0
//!      trees  in tubs  railings fountain railings in tubs        z = 28
//! ```
//! What it shows: the setting of the measurements of Chong and Gortler, "Scene Optimized Shadow Mapping" `[chong2007]`, section 5:
//! as many triangles, casters down to fingers, spears, leaves and bars, receivers that are steps, plinths, terraces and the
//! statues themselves. Their scene was never published; this one is no copy of it.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};

use super::architecture::{baluster, column, fountain, plinth, railing, stairs, urn};
use super::assembly::{Assembly, Part, standing, turned};
use super::builder::Shape;
use super::figures::{Pose, figure};
use super::random::Random;
use super::spec::{LibraryParam, LibraryScene, LibrarySpec, Values};
use super::trees::{bare_tree, laurel};
use crate::error::Result;
use crate::scene::{Camera, DirectionalLight, Light};

/// The scene's self-description.
pub(super) const SPEC: LibrarySpec = LibrarySpec {
    name: "statues",
    title: "Statues on a plaza",
    shows: "the setting of the scene-optimized shadow maps: fingers, spears, leaves and bars cast shadows on steps, plinths, \
            terraces and statues",
    params: &[
        LibraryParam {
            name: "facets",
            default: FACETS,
            min: 12.0,
            max: 160.0,
            whole: true,
            doc: "facets around a statue's robe; a statue has about 120 triangles for each",
        },
        LibraryParam {
            name: "leaves",
            default: LEAVES,
            min: 1.0,
            max: 10_000.0,
            whole: true,
            doc: "leaves of a laurel",
        },
    ],
    build,
};

/// Chosen so that all triangles together are 444,000, as in the paper, to a thousandth.
const FACETS: f64 = 40.0;
const LEAVES: f64 = 860.0;
/// Heights of the terraces and z of their fronts, metres.
const LOWER: (f64, f64) = (0.9, -8.0);
const UPPER: (f64, f64) = (2.1, -19.0);
/// Middle of the exedra, the radius of its columns, and the floor that they stand on.
const EXEDRA: DVec3 = DVec3::new(0.0, UPPER.0 + 0.4, -31.0);
const RING: f64 = 11.0;
const PLINTH: f64 = 1.5;

/// The statues, by pose.
struct Figures {
    torch: Part,
    guard: Part,
    winged: Part,
    orator: Part,
    plinth: Part,
}

fn build(seed: u64, values: &Values) -> Result<LibraryScene> {
    let (facets, leaves) = (values.count("facets"), values.count("leaves"));
    let mut random = Random::new(seed, 7);
    let mut assembly = Assembly::new(values.progress);
    let mut statue = |pose| assembly.part(&figure(pose, facets));
    let (torch, guard, winged, orator) =
        (statue(Pose::Torch)?, statue(Pose::Guard)?, statue(Pose::Winged)?, statue(Pose::Orator)?);
    let figures = Figures { torch, guard, winged, orator, plinth: assembly.part(&plinth(PLINTH))? };
    let column = assembly.part(&column(16))?;
    assembly.fixed(&Shape::cuboid(DVec3::new(-110.0, -1.0, -110.0), DVec3::new(110.0, 0.0, 110.0)))?;
    terraces(&mut assembly)?;
    exedra(&mut assembly, column, &figures)?;
    walk(&mut assembly, column, &figures)?;
    guards(&mut assembly, &mut random, &figures);
    planting(&mut assembly, &mut random, leaves)?;
    let camera = Camera::look_at(
        DVec3::new(-2.3, 1.75, 28.5),
        DVec3::new(1.0, 1.6, -8.0),
        DVec3::Y,
        50f64.to_radians(),
        16.0 / 9.0,
        0.3,
        160.0,
    )?;
    let light = Light::Directional(DirectionalLight::new(DVec3::new(0.78, -0.5, -0.42))?);
    Ok(LibraryScene { name: SPEC.name, scene: assembly.scene()?, camera, light })
}

/// Two terraces with stairs in their middle, balustrades along their fronts, urns beside the stairs.
fn terraces(assembly: &mut Assembly) -> Result<()> {
    let pier = Shape::block(DVec3::new(0.6, 1.1, 0.6))
        .with(Shape::block(DVec3::new(0.74, 0.12, 0.74)).moved(DVec3::Y * 1.08))
        .with(Shape::block(DVec3::new(0.7, 0.2, 0.7)));
    let (pier, urn, baluster) = (assembly.part(&pier)?, assembly.part(&urn())?, assembly.part(&baluster())?);
    // Half widths of the terrace and of its stairs; bays of the balustrade on either side.
    for ((top, front), floor, half, stair, bays, steps) in
        [(LOWER, 0.0, 24.0, 6.0, 5, 6), (UPPER, LOWER.0, 18.0, 4.0, 4, 8)]
    {
        assembly.fixed(&Shape::cuboid(DVec3::new(-half, -0.3, -60.0), DVec3::new(half, top, front)))?;
        let rise = (top - floor) / steps as f64 - 0.001;
        let run = 0.36;
        let flight = stairs(steps, rise, run, 2.0 * stair);
        assembly.fixed(&flight.moved(DVec3::new(0.0, floor, front + run * steps as f64 - 0.4)))?;
        let inner = stair + 0.35;
        let bay = (half - 0.4 - inner) / f64::from(bays);
        for side in [-1.0, 1.0] {
            let rail = |low: f64, high: f64, deep: f64| {
                let (a, b) = (side * inner, side * (half - 0.4));
                let (low, high) = (top + low, top + high);
                Shape::cuboid(
                    DVec3::new(a.min(b), low, front - 0.4 - deep),
                    DVec3::new(a.max(b), high, front - 0.4 + deep),
                )
            };
            assembly.fixed(&rail(-0.02, 0.16, 0.17).with(rail(0.85, 0.92, 0.14)).with(rail(0.91, 1.0, 0.19)))?;
            for k in 0..=bays {
                let x = side * (inner + bay * f64::from(k));
                assembly.place_at(pier, x, top - 0.02, front - 0.4);
                if k == 0 {
                    assembly.place_at(urn, x, top + 1.17, front - 0.4);
                }
            }
            for k in 0..bays {
                for b in 1..=8 {
                    let x = inner + bay * (f64::from(k) + 0.05 + 0.1 * f64::from(b));
                    assembly.place_at(baluster, side * x, top + 0.15, front - 0.4);
                }
            }
        }
    }
    Ok(())
}

/// A half ring of columns on round steps, under an architrave; statues between the columns, the colossus in the middle.
fn exedra(assembly: &mut Assembly, column: Part, figures: &Figures) -> Result<()> {
    const COLUMNS: usize = 13;
    const SCALE: f64 = 1.2;
    let step = |radius: f64, top: f64| Shape::cylinder(radius, top + 0.3, 96).moved(DVec3::Y * (UPPER.0 - 0.3));
    let floor = step(RING + 1.7, 0.2).with(step(RING + 1.2, 0.4));
    assembly.fixed(&floor.moved(DVec3::new(EXEDRA.x, 0.0, EXEDRA.z)))?;
    // Behind the middle: from the left, around the back, to the right.
    let on_ring = |turn: f64, radius: f64| {
        let along = DVec2::from_angle(PI * (1.0 + turn));
        EXEDRA + DVec3::new(along.x, 0.0, along.y) * radius
    };
    // Statues look to the middle.
    let heading = |turn: f64| DVec2::from_angle(PI * (1.5 + turn));
    for k in 0..COLUMNS {
        let turn = k as f64 / (COLUMNS - 1) as f64;
        assembly.place(column, standing(on_ring(turn, RING) - DVec3::Y * 0.01, heading(turn), SCALE));
    }
    let eaves = 4.5 * SCALE - 0.02;
    let course = |inner: f64, outer: f64, low: f64, high: f64| {
        let rings: Vec<Vec<DVec3>> = (0..=56)
            .map(|k| {
                let turn = -0.03 + 1.06 * f64::from(k) / 56.0;
                let at = |radius: f64, y: f64| on_ring(turn, radius) + DVec3::Y * y;
                vec![at(inner, low), at(outer, low), at(outer, high), at(inner, high)]
            })
            .collect();
        Shape::skin(&rings)
    };
    let architrave = course(RING - 0.45, RING + 0.45, eaves, eaves + 0.55).with(course(
        RING - 0.6,
        RING + 0.6,
        eaves + 0.53,
        eaves + 0.72,
    ));
    assembly.fixed(&architrave.with(course(RING - 0.4, RING + 0.4, eaves + 0.7, eaves + 0.95)))?;
    let row = [figures.torch, figures.orator, figures.guard];
    for k in (1..COLUMNS - 2).step_by(2) {
        let turn = (k as f64 + 0.5) / (COLUMNS - 1) as f64;
        assembly.place(figures.plinth, standing(on_ring(turn, RING - 1.9), heading(turn), 0.8));
        let at = on_ring(turn, RING - 1.9) + DVec3::Y * (0.8 * PLINTH - 0.01);
        assembly.place(row[k / 2 % 3], standing(at, heading(turn), 1.0));
    }
    let drum = Shape::cylinder(2.3, 0.4, 64)
        .with(Shape::cylinder(1.9, 0.8, 64))
        .with(Shape::cylinder(1.2, 2.3, 48))
        .with(Shape::cylinder(1.35, 0.2, 48).moved(DVec3::Y * 2.2));
    assembly.fixed(&drum.moved(EXEDRA - DVec3::Y * 0.05))?;
    assembly.place(figures.winged, standing(EXEDRA + DVec3::Y * 2.33, DVec2::X, 2.2));
    Ok(())
}

/// The plaza: statues on plinths on both sides of a walk, iron railings between them, a fountain, two columns of victory.
fn walk(assembly: &mut Assembly, column: Part, figures: &Figures) -> Result<()> {
    let panel = assembly.part(&railing(2.0, 16))?;
    let row = [figures.guard, figures.orator, figures.torch, figures.winged];
    for k in 0..7 {
        let z = 24.0 - 4.6 * k as f64;
        for side in [-1.0, 1.0] {
            let at = DVec3::new(side * 5.6, 0.0, z);
            let part = row[(k + usize::from(side > 0.0)) % row.len()];
            assembly.place_at(figures.plinth, at.x, at.y, at.z);
            // Turned to the walk, and a little to who comes up it.
            assembly.place(part, turned(at + DVec3::Y * (PLINTH - 0.01), -side * 0.3 * PI));
            if k < 6 {
                assembly.place(panel, turned(at - DVec3::Z * 0.9, FRAC_PI_2));
            }
        }
    }
    let fountain = assembly.part(&fountain())?;
    assembly.place_at(fountain, 0.0, 0.0, 8.0);
    assembly.place(figures.torch, standing(DVec3::new(0.0, 2.66, 8.0), DVec2::X, 0.6));
    for side in [-1.0, 1.0] {
        let at = DVec3::new(side * 9.5, 0.0, -4.0);
        assembly.place(column, standing(at, DVec2::X, 1.5));
        assembly.place(figures.winged, standing(at + DVec3::Y * (1.5 * 4.5 - 0.02), DVec2::X, 0.9));
    }
    Ok(())
}

/// Guards with spears on the plaza, on the stairs and on the terraces.
fn guards(assembly: &mut Assembly, random: &mut Random, figures: &Figures) {
    let step = |k: f64| LOWER.0 * k / 6.0 - 0.02;
    for (x, y, z) in [
        (-1.9, 0.0, 18.6),
        (2.4, 0.0, 13.9),
        (-4.6, step(2.0), -6.78),
        (-1.6, step(4.0), -7.5),
        (3.4, step(3.0), -7.14),
        (-3.2, LOWER.0, -12.5),
        (4.9, LOWER.0, -11.4),
        (0.9, LOWER.0, -14.8),
    ] {
        let at = DVec3::new(x, y - 0.01, z);
        assembly.place(figures.guard, turned(at, random.range(-0.7, 0.7)));
    }
}

/// Laurels in tubs beside the walk and along the terrace; bare trees on both sides of the plaza.
fn planting(assembly: &mut Assembly, random: &mut Random, leaves: usize) -> Result<()> {
    let profile =
        [[0.0, -0.02], [0.36, -0.02], [0.46, 0.6], [0.5, 0.62], [0.5, 0.7], [0.42, 0.7], [0.4, 0.62], [0.0, 0.6]];
    let tub = Shape::lathe(&profile, 24);
    let laurels = [0, 1, 2].map(|_| tub.clone().with(laurel(random, leaves).moved(DVec3::Y * 0.55)));
    let laurels = laurels.iter().map(|t| assembly.part(t)).collect::<Result<Vec<_>>>()?;
    let bare = [0, 1].map(|_| bare_tree(random));
    let bare = bare.iter().map(|t| assembly.part(t)).collect::<Result<Vec<_>>>()?;
    for side in [-1.0, 1.0] {
        for k in 0..4 {
            let at = DVec3::new(side * 9.2, 0.0, 21.7 - 6.9 * f64::from(k));
            let heading = random.direction();
            assembly.place(laurels[random.below(3)], standing(at, heading, random.range(0.9, 1.1)));
        }
        for (x, z) in [(9.0, -11.0), (13.0, -13.5)] {
            let heading = random.direction();
            assembly.place(laurels[random.below(3)], standing(DVec3::new(side * x, LOWER.0, z), heading, 0.95));
        }
        for k in 0..2 {
            let at = DVec3::new(side * random.range(14.0, 17.5), 0.0, 16.0 - 12.0 * k as f64);
            let heading = random.direction();
            assembly.place(bare[k % 2], standing(at, heading, random.range(0.8, 1.05)));
        }
    }
    Ok(())
}
