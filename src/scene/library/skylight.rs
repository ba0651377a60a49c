//! Curved receivers under the bars of a skylight: no warp that is best on a plane is best on these.
//!
//! The floor swells, cloth hangs in folds along two walls, columns, balls and rings stand about; above them a grid of
//! bars fills an opening in the ceiling.

use std::f64::consts::TAU;

use glam::{DAffine3, DQuat, DVec2, DVec3};

use super::assembly::{Assembly, turned};
use super::builder::{Shape, ring};
use super::random::Random;
use super::spec::{LibraryParam, LibraryScene, LibrarySpec, Values};
use super::terrain::HeightField;
use crate::error::Result;
use crate::scene::{Camera, DirectionalLight, Light, SpotLight};

/// The scene's self-description.
pub(super) const SPEC: LibrarySpec = LibrarySpec {
    name: "skylight",
    title: "Curved receivers under a skylight",
    shows: "straight bars cast onto a swelling floor, folded cloth, columns and balls: the receivers are not planar",
    params: &[
        LibraryParam {
            name: "bars",
            default: 11.0,
            min: 1.0,
            max: 60.0,
            whole: true,
            doc: "bars of the skylight in each direction",
        },
        LibraryParam {
            name: "swell",
            default: 0.3,
            min: 0.0,
            max: 0.6,
            whole: false,
            doc: "height of the floor's waves, m",
        },
        LibraryParam {
            name: "spot",
            default: 0.0,
            min: 0.0,
            max: 1.0,
            whole: true,
            doc: "1: a spot light above the skylight in place of the sun",
        },
    ],
    build,
};

const HALF: f64 = 6.0;
const CEILING: f64 = 6.0;
const OPENING: f64 = 5.0;

fn build(seed: u64, values: &Values) -> Result<LibraryScene> {
    let mut random = Random::new(seed, 5);
    let mut assembly = Assembly::new(values.progress);
    let swell = values.number("swell");
    let (phase_x, phase_z) = (random.range(0.0, TAU), random.range(0.0, TAU));
    let wave = |x: f64, z: f64| {
        0.5 * swell * ((0.9 * x + 0.5 * z + phase_x).sin() + 0.7 * (1.25 * z - 0.35 * x + phase_z).sin())
    };
    let floor = HeightField::new(DVec2::splat(-HALF), DVec2::splat(HALF), [80, 80], wave);
    assembly.fixed(&floor.solid(-1.5))?;
    room(&mut assembly)?;
    skylight(&mut assembly, values.count("bars"))?;
    cloth(&mut assembly, &mut random)?;
    objects(&mut assembly, &mut random, &floor)?;
    let eye = DVec3::new(2.6, 2.9, 5.4);
    let camera =
        Camera::look_at(eye, DVec3::new(-0.8, 1.35, -1.5), DVec3::Y, 58f64.to_radians(), 16.0 / 9.0, 0.2, 40.0)?;
    let sun = DVec3::new(-0.42, -1.0, -0.62);
    let light = if values.count("spot") == 1 {
        Light::Spot(SpotLight::new(
            DVec3::new(1.2, 12.0, 1.2),
            DVec3::new(-0.1, -1.0, -0.12),
            70f64.to_radians(),
            40.0,
        )?)
    } else {
        Light::Directional(DirectionalLight::new(sun)?)
    };
    Ok(LibraryScene { name: SPEC.name, scene: assembly.scene()?, camera, light })
}

fn room(assembly: &mut Assembly) -> Result<()> {
    let (h, t, top) = (HALF, 0.4, CEILING + 0.4);
    let mut room = Shape::default();
    for (min, max) in [
        (DVec3::new(-h - t, -1.6, -h - t), DVec3::new(-h + 0.02, top - 0.02, h + t)),
        (DVec3::new(h - 0.02, -1.6, -h - t), DVec3::new(h + t, top - 0.02, h + t)),
        (DVec3::new(-h - 0.1, -1.61, -h - t), DVec3::new(h + 0.1, top - 0.03, -h + 0.02)),
        (DVec3::new(-h - 0.1, -1.61, h - 0.02), DVec3::new(h + 0.1, top - 0.03, h + t)),
        // Four slabs leave the opening.
        (DVec3::new(-h - t, CEILING, -h - t), DVec3::new(-OPENING, top, h + t)),
        (DVec3::new(OPENING, CEILING, -h - t), DVec3::new(h + t, top, h + t)),
        (DVec3::new(-OPENING - 0.1, CEILING + 0.01, -h - t), DVec3::new(OPENING + 0.1, top - 0.01, -OPENING)),
        (DVec3::new(-OPENING - 0.1, CEILING + 0.01, OPENING), DVec3::new(OPENING + 0.1, top - 0.01, h + t)),
    ] {
        room.add(Shape::cuboid(min, max));
    }
    assembly.fixed(&room)
}

fn skylight(assembly: &mut Assembly, bars: usize) -> Result<()> {
    let reach = OPENING + 0.05;
    // Bars take at most a fifth of their spacing, however many there are.
    let width = f64::min(0.14, 0.2 * 2.0 * OPENING / (bars + 1) as f64);
    let bar = assembly.part(&Shape::block(DVec3::new(width, 0.16, 2.0 * reach)))?;
    for k in 1..=bars {
        let x = -OPENING + 2.0 * OPENING * k as f64 / (bars + 1) as f64;
        assembly.place_at(bar, x, CEILING + 0.16, 0.0);
        assembly.place(bar, turned(DVec3::new(0.0, CEILING + 0.1, x), 0.25 * TAU));
    }
    Ok(())
}

/// Folded cloth along the far wall and the left wall.
fn cloth(assembly: &mut Assembly, random: &mut Random) -> Result<()> {
    const COLUMNS: usize = 96;
    const ROWS: usize = 18;
    let phase = random.range(0.0, TAU);
    let fold = |x: f64, y: f64| {
        // Folds open towards the hem.
        let depth = 0.1 + 0.12 * (1.0 - y / CEILING);
        depth * ((4.1 * x + phase).sin() + 0.45 * (7.3 * x - 0.5 * y + 2.0 * phase).sin()) - 0.04 * y
    };
    // A sheet 3 cm thick: rings around it, stacked from hem to rail.
    let rings: Vec<Vec<DVec3>> = (0..=ROWS)
        .map(|row| {
            let y = 0.35 + (CEILING - 0.75) * row as f64 / ROWS as f64;
            let edge = (0..=COLUMNS).map(|c| -4.6 + 9.2 * c as f64 / COLUMNS as f64);
            let front = edge.clone().map(|x| DVec3::new(x, y, fold(x, y) + 0.015));
            let back = edge.rev().map(|x| DVec3::new(x, y, fold(x, y) - 0.015));
            front.chain(back).collect()
        })
        .collect();
    let rail = Shape::tube(&[(DVec3::new(-5.0, 5.62, -0.2), 0.04), (DVec3::new(5.0, 5.62, -0.2), 0.04)], 12);
    let cloth = assembly.part(&Shape::skin(&rings).with(rail))?;
    assembly.place_at(cloth, 0.4, 0.0, -HALF + 0.75);
    assembly.place(cloth, turned(DVec3::new(-HALF + 0.75, 0.0, 0.6), 0.25 * TAU));
    Ok(())
}

/// Columns, balls and rings, standing in the swell of the floor.
fn objects(assembly: &mut Assembly, random: &mut Random, floor: &HeightField) -> Result<()> {
    let column = Shape::lathe(&[[0.0, -0.6], [0.42, -0.6], [0.42, 2.6], [0.5, 2.68], [0.5, 2.8], [0.0, 2.8]], 48);
    let ball = Shape::ellipsoid(DVec3::ZERO, DVec3::ONE, 48, 32);
    let section: Vec<[f64; 2]> = super::builder::circle(20).map(|(_, c)| [0.75 + 0.2 * c.x, 0.2 * c.y]).collect();
    let (column, ball, hoop) = (assembly.part(&column)?, assembly.part(&ball)?, assembly.part(&ring(&section, 56))?);
    for (x, z, height) in [(-2.9, -2.6, 1.0), (-1.2, -3.4, 0.75), (0.7, -3.1, 1.1), (2.9, -2.7, 0.55)] {
        let at = DVec3::new(x + random.range(-0.15, 0.15), 0.0, z + random.range(-0.15, 0.15));
        let stand = DAffine3::from_scale_rotation_translation(
            DVec3::new(1.0, height, 1.0),
            DQuat::IDENTITY,
            at + DVec3::Y * floor.height_at(at.x, at.z),
        );
        assembly.place(column, stand);
    }
    for (x, z, radius) in [(-2.2, 0.4, 0.75), (-0.4, -1.0, 0.5), (0.9, 0.6, 0.62), (-0.7, 1.9, 0.34), (2.2, -0.9, 0.45)]
    {
        let at = DVec3::new(x + random.range(-0.12, 0.12), 0.0, z + random.range(-0.12, 0.12));
        let center = at + DVec3::Y * (floor.height_at(at.x, at.z) + 0.93 * radius);
        let stand = DAffine3::from_scale_rotation_translation(DVec3::splat(radius), DQuat::IDENTITY, center);
        assembly.place(ball, stand);
    }
    for (x, z, tilt) in [(1.9, 1.9, 0.2), (-3.3, 2.2, 1.35)] {
        let turn = DQuat::from_rotation_y(random.range(-0.6, 0.6)) * DQuat::from_rotation_x(tilt);
        let height = floor.height_at(x, z) + 0.12 + 0.75 * tilt.sin();
        assembly.place(hoop, DAffine3::from_rotation_translation(turn, DVec3::new(x, height, z)));
    }
    Ok(())
}
