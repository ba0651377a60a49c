//! Draped figures, about 2.1 m, that stand on y = 0 and look along +z: statues for plinths and for long shadows.
//!
//! The robe is a stack of elliptical rings whose radius is folded by a wave that fades from hem to waist; arms are tubes; the
//! attribute in the hand gives each its outline, down to fingers and feathers.

use std::f64::consts::TAU;

use glam::{DAffine3, DQuat, DVec3};

use super::builder::{Shape, circle, smoothed};

/// What a figure holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pose {
    /// A torch held high.
    Torch,
    /// A spear and a round shield.
    Guard,
    /// Wings spread, a wreath in the hand.
    Winged,
    /// An open hand raised, the fingers apart; a scroll in the other.
    Orator,
}

/// Height, half width, half depth, depth of the folds relative to the radius; metres.
const BODY: [[f64; 4]; 13] = [
    [0.00, 0.37, 0.31, 0.13],
    [0.08, 0.34, 0.29, 0.13],
    [0.45, 0.275, 0.24, 0.11],
    [0.80, 0.25, 0.215, 0.08],
    [1.02, 0.235, 0.185, 0.05],
    [1.20, 0.175, 0.140, 0.025],
    [1.30, 0.180, 0.140, 0.02],
    [1.44, 0.215, 0.155, 0.02],
    [1.57, 0.235, 0.140, 0.01],
    [1.66, 0.185, 0.110, 0.00],
    [1.72, 0.085, 0.080, 0.00],
    [1.80, 0.060, 0.062, 0.00],
    [1.92, 0.058, 0.060, 0.00],
];

/// A figure in a pose, with `segments` around the robe (about 110 triangles for each).
pub(super) fn figure(pose: Pose, segments: usize) -> Shape {
    let mut figure = robe(segments);
    let detail = segments / 2;
    figure.add(Shape::ellipsoid(DVec3::new(0.0, 1.99, 0.015), DVec3::new(0.092, 0.13, 0.112), detail, detail * 2 / 3));
    figure.add(Shape::ellipsoid(DVec3::new(0.0, 2.02, -0.09), DVec3::new(0.07, 0.065, 0.06), detail, detail / 2));
    let hand = |figure: &mut Shape, at: DVec3| {
        figure.add(Shape::ellipsoid(at, DVec3::splat(0.045), detail / 2, detail / 2));
    };
    let right_shoulder = DVec3::new(-0.2, 1.56, 0.0);
    let left_shoulder = DVec3::new(0.2, 1.56, 0.0);
    match pose {
        Pose::Torch => {
            let (elbow, fist) = (DVec3::new(-0.42, 1.74, 0.06), DVec3::new(-0.47, 2.08, 0.12));
            arm(&mut figure, [right_shoulder, elbow, fist], detail);
            hand(&mut figure, fist);
            let torch = [
                [0.0, -0.22],
                [0.016, -0.2],
                [0.028, 0.1],
                [0.075, 0.17],
                [0.08, 0.2],
                [0.03, 0.2],
                [0.07, 0.3],
                [0.05, 0.42],
                [0.0, 0.58],
            ];
            figure.add(Shape::lathe(&torch, detail).moved(fist));
            let (elbow, fist) = (DVec3::new(0.4, 1.27, -0.06), DVec3::new(0.2, 1.1, 0.15));
            arm(&mut figure, [left_shoulder, elbow, fist], detail);
            hand(&mut figure, fist);
        }
        Pose::Guard => {
            let (elbow, fist) = (DVec3::new(-0.42, 1.34, 0.0), DVec3::new(-0.5, 1.5, 0.26));
            arm(&mut figure, [right_shoulder, elbow, fist], detail);
            hand(&mut figure, fist);
            let spear = [[0.0, 0.0], [0.016, 0.05], [0.016, 2.45], [0.05, 2.5], [0.0, 2.85]];
            figure.add(Shape::lathe(&spear, detail / 2).moved(DVec3::new(fist.x, 0.0, fist.z)));
            let (elbow, fist) = (DVec3::new(0.4, 1.22, 0.02), DVec3::new(0.4, 1.02, 0.22));
            arm(&mut figure, [left_shoulder, elbow, fist], detail);
            let disc = [
                [0.0, 0.0],
                [0.3, 0.0],
                [0.42, -0.05],
                [0.43, -0.03],
                [0.3, 0.03],
                [0.1, 0.06],
                [0.08, 0.1],
                [0.0, 0.12],
            ];
            let facing = DQuat::from_rotation_z(-0.35) * DQuat::from_rotation_x(TAU / 4.0);
            let stand = DAffine3::from_rotation_translation(facing, DVec3::new(0.46, 0.9, 0.28));
            figure.add(Shape::lathe(&disc, segments).placed(&stand));
            let crest = [
                (DVec3::new(0.0, 2.0, -0.17), 0.02),
                (DVec3::new(0.0, 2.15, -0.13), 0.04),
                (DVec3::new(0.0, 2.2, 0.0), 0.045),
                (DVec3::new(0.0, 2.13, 0.11), 0.02),
            ];
            figure.add(Shape::tube(&crest, detail / 2));
        }
        Pose::Winged => {
            for side in [-1.0, 1.0] {
                wing(&mut figure, side);
            }
            let (elbow, fist) = (DVec3::new(-0.4, 1.42, 0.16), DVec3::new(-0.36, 1.66, 0.4));
            arm(&mut figure, [right_shoulder, elbow, fist], detail);
            hand(&mut figure, fist);
            let wreath: Vec<(DVec3, f64)> = circle(detail)
                .chain(circle(detail).take(1))
                .map(|(_, c)| (fist + DVec3::new(c.x * 0.15, 0.15 + c.y * 0.15, 0.0), 0.026))
                .collect();
            figure.add(Shape::tube(&wreath, detail / 2));
            let (elbow, fist) = (DVec3::new(0.36, 1.26, -0.1), DVec3::new(0.42, 0.98, 0.05));
            arm(&mut figure, [left_shoulder, elbow, fist], detail);
            hand(&mut figure, fist);
        }
        Pose::Orator => {
            let (elbow, palm) = (DVec3::new(-0.46, 1.62, 0.12), DVec3::new(-0.6, 1.98, 0.26));
            arm(&mut figure, [right_shoulder, elbow, palm], detail);
            open_hand(&mut figure, palm, detail / 3);
            let (elbow, fist) = (DVec3::new(0.38, 1.24, 0.02), DVec3::new(0.26, 1.12, 0.26));
            arm(&mut figure, [left_shoulder, elbow, fist], detail);
            hand(&mut figure, fist);
            let scroll = [[0.0, -0.2], [0.045, -0.19], [0.03, -0.17], [0.03, 0.17], [0.045, 0.19], [0.0, 0.2]];
            let lean = DAffine3::from_rotation_translation(DQuat::from_rotation_z(0.5), fist);
            figure.add(Shape::lathe(&scroll, detail / 2).placed(&lean));
        }
    }
    figure
}

/// A palm that faces forwards, with four fingers and a thumb a few centimetres long.
fn open_hand(figure: &mut Shape, palm: DVec3, segments: usize) {
    let segments = segments.max(5);
    let middle = palm + DVec3::Y * 0.05;
    figure.add(Shape::ellipsoid(middle, DVec3::new(0.048, 0.062, 0.022), 2 * segments, segments));
    // Turns from upright to either side, radians, and lengths, metres: forefinger to little finger, then the thumb.
    for (turn, length, radius) in
        [(0.26, 0.095, 0.012), (0.06, 0.108, 0.012), (-0.14, 0.1, 0.0115), (-0.36, 0.08, 0.01), (0.95, 0.075, 0.014)]
    {
        let along = DQuat::from_rotation_z(-turn) * DVec3::Y;
        let (root, tip) = (middle + along * 0.035, middle + along * (0.05 + length) + DVec3::Z * 0.02);
        let path =
            [(root, radius), (root.lerp(tip, 0.55), 0.95 * radius), (root.lerp(tip, 0.92), 0.8 * radius), (tip, 0.0)];
        figure.add(Shape::tube(&path, segments));
    }
}

fn robe(segments: usize) -> Shape {
    let rings: Vec<Vec<DVec3>> = smoothed(&BODY, 4)
        .into_iter()
        .map(|[height, x, z, fold]| {
            // The weight rests on one leg: the hips swing aside and the chest swings back.
            let sway = 0.045 * (height * 2.6).sin() * (1.9 - height).max(0.0);
            circle(segments)
                .map(|(turn, c)| {
                    let wave = (11.0 * TAU * turn + 1.5 * height).cos() + 0.5 * (5.0 * TAU * turn - 2.0 * height).cos();
                    let r = 1.0 + fold * wave;
                    DVec3::new(sway + x * r * c.x, height, -z * r * c.y)
                })
                .collect()
        })
        .collect();
    Shape::skin(&rings)
}

fn arm(figure: &mut Shape, [shoulder, elbow, hand]: [DVec3; 3], segments: usize) {
    let inside = shoulder - DVec3::new(0.06 * shoulder.x.signum(), 0.03, 0.0);
    let path = [
        (inside, 0.07),
        (shoulder, 0.075),
        (shoulder.lerp(elbow, 0.5), 0.062),
        (elbow, 0.05),
        (elbow.lerp(hand, 0.4), 0.047),
        (hand, 0.03),
    ];
    figure.add(Shape::tube(&path, segments));
}

/// A fan of feathers behind a shoulder; `side` is -1 or 1.
fn wing(figure: &mut Shape, side: f64) {
    const FEATHERS: usize = 11;
    let root = DVec3::new(side * 0.1, 1.5, -0.16);
    for k in 0..FEATHERS {
        let t = k as f64 / (FEATHERS - 1) as f64;
        // From upright by the head to hanging beside the hip.
        let angle = 0.25 + 1.75 * t;
        let length = 1.15 - 0.45 * t;
        let feather = Shape::ellipsoid(DVec3::Y * (0.5 * length), DVec3::new(0.085, 0.5 * length, 0.014), 8, 10);
        let turn = DQuat::from_rotation_z(-side * angle) * DQuat::from_rotation_y(side * 0.25);
        // Each feather lies a little behind its neighbour; none touch in one plane.
        let start = root + DVec3::new(side * 0.16 * (1.0 - t), 0.1 * (1.0 - t), -0.012 * k as f64);
        figure.add(feather.placed(&DAffine3::from_rotation_translation(turn, start)));
    }
    let spar = [
        (DVec3::new(side * 0.06, 1.4, -0.1), 0.05),
        (root + DVec3::new(side * 0.1, 0.08, -0.03), 0.045),
        (root + DVec3::new(side * 0.3, 0.45, -0.06), 0.02),
    ];
    figure.add(Shape::tube(&spar, 10));
}
