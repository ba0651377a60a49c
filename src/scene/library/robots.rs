//! A group of jointed robots on a plane, about 11,000 triangles: small parts, gaps between limbs, one flat receiver.
//!
//! In the spirit of the scene "Robots" of "Theory to Practice: Generalized Minimum-Norm Perspective Shadow Maps" (2007,
//! section 4). These robots are our own; every limb is an instance of one of seven meshes.

use glam::{DAffine3, DQuat, DVec2, DVec3};

use super::assembly::{Assembly, Part, standing};
use super::builder::Shape;
use super::random::Random;
use super::spec::{LibraryParam, LibraryScene, LibrarySpec, Values};
use crate::error::Result;
use crate::scene::{Camera, DirectionalLight, Light};

/// The scene's self-description.
pub(super) const SPEC: LibrarySpec = LibrarySpec {
    name: "robots",
    title: "Robots on a plane",
    shows: "small articulated casters over one flat receiver, where the best warp can be told from a good one",
    params: &[LibraryParam {
        name: "robots",
        default: 10.0,
        min: 1.0,
        max: 2000.0,
        whole: true,
        doc: "how many robots",
    }],
    build,
};

/// Metres between neighbours in the loose grid that they stand on.
const SPACING: f64 = 2.3;
/// Where the hips are above the pelvis' origin and beside it; lengths of thigh and shin down to the sole.
const HIP: DVec3 = DVec3::new(0.15, 0.0, 0.0);
const THIGH: f64 = 0.46;
const SOLE: f64 = 0.54;
const SHOULDER: DVec3 = DVec3::new(0.42, 0.56, 0.0);
const UPPER_ARM: f64 = 0.36;

struct Parts {
    pelvis: Part,
    torso: Part,
    head: Part,
    upper_arm: Part,
    forearm: Part,
    thigh: Part,
    shin: Part,
}

/// Joint angles in radians; pairs are left and right. A positive pitch swings a limb forward.
struct Joints {
    waist: f64,
    lean: f64,
    head: f64,
    shoulder_pitch: [f64; 2],
    shoulder_roll: [f64; 2],
    elbow: [f64; 2],
    hip: [f64; 2],
    knee: [f64; 2],
}

fn build(seed: u64, values: &Values) -> Result<LibraryScene> {
    let robots = values.count("robots");
    let mut random = Random::new(seed, 2);
    let mut assembly = Assembly::new(values.progress);
    // As many columns as rows, or one more.
    let columns = (1..).find(|c| c * c >= robots).unwrap_or(1);
    let rows = robots.div_ceil(columns);
    let half = 0.5 * SPACING * columns as f64;
    let reach = 4.0 * half + 80.0;
    assembly.fixed(&Shape::cuboid(DVec3::new(-reach, -1.0, -reach), DVec3::new(reach, 0.0, reach)))?;
    let parts = parts(&mut assembly)?;
    for k in 0..robots {
        let (column, row) = (k % columns, k / columns);
        let jitter = random.direction() * random.range(0.0, 0.5);
        // Every other row is shifted by half a step, so that nobody hides behind a neighbour.
        let shift = if row % 2 == 0 { 0.25 } else { -0.25 };
        let x = SPACING * (column as f64 + 0.5 + shift) - half + jitter.x;
        let z = half - SPACING * (row as f64 + 0.5) + jitter.y;
        let heading = random.direction();
        let joints = pose(&mut random, k);
        place_robot(&mut assembly, &parts, DVec3::new(x, 0.0, z), heading, &joints);
    }
    let camera = Camera::look_at(
        DVec3::new(-0.5 * half, 3.0 + 0.1 * half, 1.5 * half + 2.4),
        DVec3::new(0.07 * half, 0.45, half - 0.5 * SPACING * rows as f64),
        DVec3::Y,
        37f64.to_radians(),
        16.0 / 9.0,
        0.5,
        100.0 + 2.0 * reach,
    )?;
    let light = Light::Directional(DirectionalLight::new(DVec3::new(-0.74, -0.5, 0.3))?);
    Ok(LibraryScene { name: SPEC.name, scene: assembly.scene()?, camera, light })
}

/// The seven meshes. Each limb hangs down from its joint at the origin; the robot looks along +z.
fn parts(assembly: &mut Assembly) -> Result<Parts> {
    let block = |x: f64, y: f64, z: f64, cut: f64| Shape::chamfered_block(DVec3::new(x, y, z), cut);
    let ball = |at: DVec3, radius: f64, segments: usize, rings: usize| {
        Shape::ellipsoid(at, DVec3::splat(radius), segments, rings)
    };
    let pelvis = block(0.34, 0.2, 0.26, 0.04).moved(DVec3::Y * -0.08);
    let torso = block(0.64, 0.52, 0.38, 0.07)
        .mapped(|p| DVec3::new(p.x * (0.72 + 0.54 * p.y), p.y, p.z * (0.85 + 0.3 * p.y)))
        .moved(DVec3::Y * 0.16)
        .with(Shape::cylinder(0.1, 0.14, 8).moved(DVec3::Y * 0.06))
        .with(Shape::cylinder(0.075, 0.14, 8).moved(DVec3::Y * 0.64));
    let eye = Shape::cylinder(0.055, 0.06, 8)
        .placed(&DAffine3::from_rotation_x(std::f64::consts::FRAC_PI_2))
        .moved(DVec3::new(0.0, 0.2, 0.15));
    let head = block(0.36, 0.32, 0.34, 0.06)
        .with(eye.clone().moved(DVec3::X * -0.085))
        .with(eye.moved(DVec3::X * 0.085))
        .with(Shape::cone(0.018, 0.34, 6).moved(DVec3::new(0.1, 0.3, -0.05)));
    let upper_arm = ball(DVec3::ZERO, 0.13, 8, 5).with(limb(0.07, 0.085, UPPER_ARM));
    let claw = Shape::cuboid(DVec3::new(-0.035, -0.52, -0.03), DVec3::new(0.035, -0.3, 0.015));
    let forearm = ball(DVec3::ZERO, 0.095, 6, 4)
        .with(limb(0.1, 0.07, 0.34))
        .with(claw.clone().moved(DVec3::Z * 0.075))
        .with(claw.moved(DVec3::Z * -0.06));
    let thigh = ball(DVec3::ZERO, 0.12, 6, 4).with(limb(0.085, 0.11, THIGH));
    let shin = ball(DVec3::ZERO, 0.11, 6, 4)
        .with(limb(0.11, 0.075, 0.46))
        .with(block(0.22, 0.12, 0.4, 0.03).moved(DVec3::new(0.0, -SOLE, 0.06)));
    Ok(Parts {
        pelvis: assembly.part(&pelvis)?,
        torso: assembly.part(&torso)?,
        head: assembly.part(&head)?,
        upper_arm: assembly.part(&upper_arm)?,
        forearm: assembly.part(&forearm)?,
        thigh: assembly.part(&thigh)?,
        shin: assembly.part(&shin)?,
    })
}

/// A rod that hangs down from the origin.
fn limb(end_radius: f64, joint_radius: f64, length: f64) -> Shape {
    Shape::lathe(&[[end_radius, -length], [joint_radius, 0.0]], 8)
}

/// One of five gestures, varied.
fn pose(random: &mut Random, index: usize) -> Joints {
    let mut around = |center: f64| center + random.range(-0.12, 0.12);
    let (waist, lean, head) = (around(0.0), 0.3 * around(0.1), 3.0 * around(0.0));
    let [shoulder_pitch, shoulder_roll, elbow, hip, knee] = match index % 5 {
        // Walking.
        0 => [[0.5, -0.5], [0.12, 0.12], [0.5, 0.3], [-0.42, 0.45], [-0.35, -0.2]],
        // Waving.
        1 => [[0.0, 0.2], [2.6, 0.2], [0.5, 0.5], [0.05, -0.05], [0.0, 0.0]],
        // Arms wide.
        2 => [[0.1, 0.1], [1.35, 1.35], [0.5, 0.5], [0.15, -0.15], [-0.1, 0.0]],
        // Pointing.
        3 => [[0.1, 1.5], [0.25, 0.05], [0.9, 0.05], [0.25, -0.2], [-0.15, 0.0]],
        // Marching, a knee raised.
        _ => [[0.8, -0.6], [0.15, 0.15], [1.3, 1.1], [1.1, 0.0], [-1.2, 0.0]],
    };
    Joints {
        waist: 2.0 * waist,
        lean,
        head,
        shoulder_pitch: shoulder_pitch.map(&mut around),
        shoulder_roll: shoulder_roll.map(|roll| (around(roll)).max(0.08)),
        elbow: elbow.map(|bend| around(bend).max(0.0)),
        hip: hip.map(&mut around),
        knee: knee.map(|bend| around(bend).min(0.0)),
    }
}

fn place_robot(assembly: &mut Assembly, parts: &Parts, at: DVec3, heading: DVec2, joints: &Joints) {
    let turn = |axis: DVec3, angle: f64| DAffine3::from_quat(DQuat::from_axis_angle(axis, angle));
    let shift = DAffine3::from_translation;
    let sides = [(0, -1.0), (1, 1.0)];
    let legs = sides.map(|(k, side)| {
        // Rotations about x: a negative angle swings what hangs down to +z, the front.
        let thigh = shift(DVec3::new(side * HIP.x, HIP.y, HIP.z)) * turn(DVec3::X, -joints.hip[k]);
        let shin = thigh * shift(DVec3::Y * -THIGH) * turn(DVec3::X, -joints.knee[k]);
        (thigh, shin)
    });
    // The lowest corner of both soles comes to stand on the plane, sunk by 4 mm so that no two faces coincide.
    let soles = [-0.1, 0.1].into_iter().flat_map(|x| [-0.13, 0.25].map(|z| DVec3::new(x, -SOLE, z)));
    let lowest = soles.flat_map(|p| legs.map(|(_, shin)| shin.transform_point3(p).y)).fold(f64::INFINITY, f64::min);
    let world = standing(at - DVec3::Y * (lowest + 0.004), heading, 1.0);
    assembly.place(parts.pelvis, world);
    for (thigh, shin) in legs {
        assembly.place(parts.thigh, world * thigh);
        assembly.place(parts.shin, world * shin);
    }
    let torso = world * turn(DVec3::Y, joints.waist) * turn(DVec3::X, joints.lean);
    assembly.place(parts.torso, torso);
    assembly.place(parts.head, torso * shift(DVec3::Y * 0.74) * turn(DVec3::Y, joints.head));
    for (k, side) in sides {
        let upper = torso
            * shift(DVec3::new(side * SHOULDER.x, SHOULDER.y, SHOULDER.z))
            * turn(DVec3::Z, side * joints.shoulder_roll[k])
            * turn(DVec3::X, -joints.shoulder_pitch[k]);
        assembly.place(parts.upper_arm, upper);
        assembly.place(parts.forearm, upper * shift(DVec3::Y * -UPPER_ARM) * turn(DVec3::X, -joints.elbow[k]));
    }
}
