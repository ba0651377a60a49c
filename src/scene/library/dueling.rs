//! The dueling frusta: the light shines nearly against the view, so shadows run towards the viewer.
//!
//! ```text
//!    eye >-----------  view  ----------->        <----- light, 13 degrees high
//! ```
//! What it shows: with light and view nearly parallel a perspective warp has no perspective aliasing to remove and LiSPSM
//! falls back to uniform (`[scherzer2005]`, "Robust Shadow Maps for Large Environments"); the same setting with shadows
//! towards the viewer is figure 3 of Chong and Gortler, "Scene Optimized Shadow Mapping" `[chong2007]`.

use glam::{DAffine3, DVec3};

use super::assembly::{Assembly, standing, turned};
use super::builder::Shape;
use super::figures::{Pose, figure};
use super::random::Random;
use super::spec::{LibraryParam, LibraryScene, LibrarySpec, Values};
use super::trees::bare_tree;
use crate::error::Result;
use crate::scene::{Camera, DirectionalLight, Light};

/// The scene's self-description.
pub(super) const SPEC: LibrarySpec = LibrarySpec {
    name: "dueling",
    title: "Shadows towards the viewer",
    shows: "dueling frusta: the light nearly opposes the view and long shadows run towards the eye",
    params: &[
        LibraryParam {
            name: "posts",
            default: 26.0,
            min: 2.0,
            max: 400.0,
            whole: true,
            doc: "fence posts on each side of the path, 2.2 m apart",
        },
        LibraryParam {
            name: "trees",
            default: 12.0,
            min: 0.0,
            max: 1000.0,
            whole: true,
            doc: "bare trees beside the path",
        },
    ],
    build,
};

const STEP: f64 = 2.2;

fn build(seed: u64, values: &Values) -> Result<LibraryScene> {
    let (posts, trees) = (values.count("posts"), values.count("trees"));
    let mut random = Random::new(seed, 6);
    let mut assembly = Assembly::new(values.progress);
    let tree_steps = trees.div_ceil(2) as f64;
    let end = -f64::max(STEP * posts as f64, 7.0 * tree_steps) - 25.0;
    assembly.fixed(&Shape::cuboid(DVec3::new(-70.0, -1.0, end - 30.0), DVec3::new(70.0, 0.0, 30.0)))?;
    fence(&mut assembly, &mut random, posts)?;

    let bare = [0, 1, 2].map(|_| bare_tree(&mut random));
    let bare = bare.iter().map(|t| assembly.part(t)).collect::<Result<Vec<_>>>()?;
    for k in 0..trees {
        let side = if k % 2 == 0 { -1.0 } else { 1.0 };
        let z = -9.0 - 7.0 * (k / 2) as f64 + random.range(-1.5, 1.5);
        let at = DVec3::new(side * random.range(4.6, 10.0), 0.0, z - 2.5 * side);
        let heading = random.direction();
        assembly.place(bare[random.below(3)], standing(at, heading, random.range(0.75, 1.15)));
    }
    // Walkers on the path; they come towards the viewer, as their shadows do.
    let walkers = [Pose::Torch, Pose::Guard, Pose::Winged].map(|pose| figure(pose, 40));
    let walkers = walkers.iter().map(|w| assembly.part(w)).collect::<Result<Vec<_>>>()?;
    for (k, (x, z)) in [(-0.95, -8.5), (0.85, -11.0), (0.1, -17.5), (-1.2, -25.0), (1.1, -29.0)].into_iter().enumerate()
    {
        assembly.place(walkers[k % 3], turned(DVec3::new(x, -0.01, z), random.range(-0.4, 0.4)));
    }
    let camera = Camera::look_at(
        DVec3::new(0.5, 2.4, 4.5),
        DVec3::new(-0.25, 1.25, -10.0),
        DVec3::Y,
        48f64.to_radians(),
        16.0 / 9.0,
        0.3,
        60.0 - end,
    )?;
    let light = Light::Directional(DirectionalLight::new(DVec3::new(0.12, -0.24, 1.0))?);
    Ok(LibraryScene { name: SPEC.name, scene: assembly.scene()?, camera, light })
}

/// Two rows of weathered posts with three rails, along both sides of the path.
fn fence(assembly: &mut Assembly, random: &mut Random, posts: usize) -> Result<()> {
    let post = Shape::chamfered_block(DVec3::new(0.16, 1.7, 0.16), 0.02).moved(DVec3::Y * -0.3);
    let post = assembly.part(&post)?;
    let mut rails = Shape::default();
    for height in [0.42, 0.76, 1.1] {
        let end = DVec3::new(0.0, height, -STEP);
        rails.add(Shape::beam(DVec3::new(0.0, height, 0.0), end, 0.05, 0.11));
    }
    let rails = assembly.part(&rails)?;
    for side in [-1.0, 1.0] {
        for k in 0..posts {
            let at = DVec3::new(side * 2.9, 0.0, 1.0 - STEP * k as f64);
            let lean = DAffine3::from_rotation_z(random.range(-0.05, 0.05))
                * DAffine3::from_rotation_x(random.range(-0.05, 0.05));
            assembly.place(post, DAffine3::from_translation(at) * lean);
            // A gap now and then: a rail is down.
            if k + 1 < posts && random.unit() < 0.9 {
                assembly.place(rails, DAffine3::from_translation(at + DVec3::X * (side * 0.09)));
            }
        }
    }
    Ok(())
}
