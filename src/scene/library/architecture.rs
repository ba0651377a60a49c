//! Parts of classical buildings: fluted columns, arches, balusters, urns, iron railings.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::builder::{Shape, smoothed};

/// A column of 4.5 m and 0.36 m radius with base, `flutes` flutes, and a capital under a square slab.
pub(super) fn column(flutes: usize) -> Shape {
    let plinth = Shape::block(DVec3::new(0.98, 0.16, 0.98));
    let base = [
        [0.0, 0.1],
        [0.47, 0.12],
        [0.5, 0.17],
        [0.5, 0.22],
        [0.46, 0.27],
        [0.4, 0.3],
        [0.42, 0.34],
        [0.43, 0.37],
        [0.41, 0.41],
        [0.37, 0.44],
        [0.0, 0.46],
    ];
    let capital = [
        [0.0, 3.98],
        [0.34, 4.0],
        [0.36, 4.04],
        [0.34, 4.07],
        [0.32, 4.1],
        [0.34, 4.17],
        [0.42, 4.25],
        [0.48, 4.29],
        [0.49, 4.32],
        [0.0, 4.36],
    ];
    // The shaft swells by 2 cm and tapers (entasis); flutes are hollow arcs between sharp ridges.
    let shaft: Vec<[f64; 2]> = (0..=9)
        .map(|k| {
            let t = f64::from(k) / 9.0;
            [0.36 - 0.06 * t * t + 0.02 * t * (1.0 - t), 0.42 + 3.6 * t]
        })
        .collect();
    let shaft = Shape::lathe_modulated(&shaft, 4 * flutes, |turn, height| {
        let across = (turn * flutes as f64).fract();
        let fades = ((height - 0.5) / 0.12).min((3.96 - height) / 0.12).clamp(0.0, 1.0);
        1.0 - 0.075 * fades * (PI * across).sin()
    });
    let slab = Shape::block(DVec3::new(1.02, 0.16, 1.02)).moved(DVec3::Y * 4.34);
    plinth.with(Shape::lathe(&base, 40)).with(shaft).with(Shape::lathe(&capital, 40)).with(slab)
}

/// One bay of a wall over columns: springs at y = 0, `span` wide along x with a half-round opening, up to `top`; with a
/// moulding around the opening on both faces.
pub(super) fn arch(span: f64, radius: f64, top: f64, thickness: f64) -> Shape {
    const STEPS: usize = 28;
    let half = 0.5 * span;
    let curve = (0..=STEPS).map(|k| {
        let (sin, cos) = (PI * k as f64 / STEPS as f64).sin_cos();
        DVec2::new(-radius * cos, radius * sin)
    });
    let lower: Vec<DVec2> =
        std::iter::once(DVec2::new(-half, 0.0)).chain(curve.clone()).chain([DVec2::new(half, 0.0)]).collect();
    let upper: Vec<DVec2> = lower.iter().map(|p| DVec2::new(p.x, top)).collect();
    let mut arch = Shape::plate(&lower, &upper, -0.5 * thickness, 0.5 * thickness);
    for z in [-0.5 * thickness, 0.5 * thickness] {
        let path: Vec<(DVec3, f64)> = curve.clone().map(|p| ((p * (1.0 + 0.1 / radius)).extend(z), 0.07)).collect();
        arch.add(Shape::tube(&path, 8));
    }
    let key = Shape::cuboid(
        DVec3::new(-0.16, radius - 0.08, -0.5 * thickness - 0.1),
        DVec3::new(0.16, radius + 0.42, 0.5 * thickness + 0.1),
    );
    arch.with(key)
}

/// A stone baluster of 0.72 m.
pub(super) fn baluster() -> Shape {
    let profile = [
        [0.0, 0.05],
        [0.085, 0.05],
        [0.085, 0.09],
        [0.05, 0.12],
        [0.06, 0.16],
        [0.1, 0.25],
        [0.105, 0.3],
        [0.085, 0.38],
        [0.05, 0.48],
        [0.042, 0.54],
        [0.06, 0.57],
        [0.045, 0.6],
        [0.08, 0.65],
        [0.08, 0.68],
        [0.0, 0.68],
    ];
    let foot = Shape::block(DVec3::new(0.2, 0.06, 0.2));
    foot.with(Shape::lathe(&profile, 18)).with(Shape::block(DVec3::new(0.2, 0.05, 0.2)).moved(DVec3::Y * 0.67))
}

/// A stone urn of 0.95 m with 18 flutes.
pub(super) fn urn() -> Shape {
    let profile = [
        [0.0, 0.0],
        [0.2, 0.0],
        [0.2, 0.05],
        [0.1, 0.1],
        [0.07, 0.18],
        [0.1, 0.24],
        [0.22, 0.32],
        [0.3, 0.45],
        [0.32, 0.58],
        [0.28, 0.7],
        [0.24, 0.78],
        [0.26, 0.84],
        [0.36, 0.92],
        [0.36, 0.95],
        [0.31, 0.95],
        [0.2, 0.82],
        [0.0, 0.8],
    ];
    Shape::lathe_modulated(&smoothed(&profile, 3), 54, |turn, height| {
        let fades = ((height - 0.26) / 0.1).min((0.76 - height) / 0.1).clamp(0.0, 1.0);
        1.0 - 0.06 * fades * (PI * (turn * 18.0).fract()).sin()
    })
}

/// An iron railing along x from 0 to `length`: a bar every 12.5 cm, two rails, spear tips, a stout post at the start.
pub(super) fn railing(length: f64, bars: usize) -> Shape {
    let mut railing = Shape::default();
    for rail in [0.14, 0.92] {
        let (from, to) = (DVec3::new(-0.01, rail, 0.0), DVec3::new(length + 0.01, rail, 0.0));
        railing.add(Shape::beam(from, to, 0.035, 0.025));
    }
    for k in 1..bars {
        let x = length * k as f64 / bars as f64;
        let bar = [[0.011, 0.02], [0.011, 0.98], [0.024, 1.01], [0.0, 1.11]];
        railing.add(Shape::lathe(&bar, 6).moved(DVec3::X * x));
    }
    railing
        .with(Shape::lathe(&[[0.035, -0.05], [0.035, 1.1], [0.05, 1.12], [0.05, 1.16], [0.03, 1.18], [0.0, 1.25]], 10))
}

/// A fountain, 6.4 m across and 2.9 m high: a round basin, a foot, two bowls.
pub(super) fn fountain() -> Shape {
    let basin = [
        [0.0, -0.1],
        [3.25, -0.1],
        [3.25, 0.12],
        [3.1, 0.16],
        [3.0, 0.3],
        [3.05, 0.5],
        [3.2, 0.56],
        [3.2, 0.64],
        [2.75, 0.64],
        [2.7, 0.56],
        [2.72, 0.36],
        [0.0, 0.34],
    ];
    let foot = [
        [0.0, 0.2],
        [0.75, 0.2],
        [0.75, 0.5],
        [0.6, 0.56],
        [0.34, 0.75],
        [0.28, 1.0],
        [0.36, 1.15],
        [0.28, 1.25],
        [0.5, 1.38],
        [1.25, 1.6],
        [1.45, 1.72],
        [1.45, 1.78],
        [1.3, 1.78],
        [0.5, 1.56],
        [0.2, 1.6],
        [0.16, 2.0],
        [0.22, 2.1],
        [0.16, 2.16],
        [0.3, 2.24],
        [0.66, 2.38],
        [0.74, 2.46],
        [0.74, 2.5],
        [0.64, 2.5],
        [0.2, 2.38],
        [0.12, 2.4],
        [0.12, 2.56],
        [0.2, 2.6],
        [0.2, 2.66],
        [0.0, 2.68],
    ];
    let scalloped = |turn: f64, height: f64| {
        let lobe = (2.0 * PI * turn * 16.0).cos();
        1.0 + if height > 1.3 { 0.03 * lobe } else { 0.0 }
    };
    Shape::lathe(&basin, 96).with(Shape::lathe_modulated(&foot, 96, scalloped))
}

/// A plinth of `height` under a statue, 1 m wide.
pub(super) fn plinth(height: f64) -> Shape {
    let foot = Shape::chamfered_block(DVec3::new(1.16, 0.2, 1.16), 0.03).moved(DVec3::Y * -0.03);
    let body = Shape::chamfered_block(DVec3::new(0.9, height - 0.24, 0.9), 0.02).moved(DVec3::Y * 0.14);
    foot.with(body).with(Shape::chamfered_block(DVec3::new(1.06, 0.14, 1.06), 0.03).moved(DVec3::Y * (height - 0.14)))
}

/// A flight of `steps` that rises along -z from z = 0, `width` wide about x = 0, as one solid down to y = -0.2.
pub(super) fn stairs(steps: usize, rise: f64, run: f64, width: f64) -> Shape {
    let mut flight = Shape::default();
    for k in 0..steps {
        // Each step reaches back under the next ones, so that the flight has no gap to shine through.
        let (front, top) = (-(run * k as f64), rise * (k + 1) as f64);
        let back = -(run * steps as f64);
        let bottom = -0.2 - 0.01 * k as f64;
        let inset = 0.004 * k as f64;
        flight.add(Shape::cuboid(
            DVec3::new(inset - 0.5 * width, bottom, back - inset),
            DVec3::new(0.5 * width - inset, top, front),
        ));
    }
    flight
}
