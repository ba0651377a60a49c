//! A forest on rolling hills: ten thousand trees from eight meshes, shrubs from three, several million triangles.
//!
//! ```text
//!     eye                              ^^^^^
//!    __o__                       ^^^^^/          a glade runs from the eye down into the valley; trees keep off it
//!         \_____^^^^^^^^^^^_____/
//! ```
//! What it shows: shadows from 10 m to a kilometre, and whether a tool keeps instances shared. Trees are placed by a
//! low-discrepancy sequence, so that any number of them covers the ground evenly.

use glam::{DAffine3, DVec2, DVec3};
use rayon::prelude::*;

use super::assembly::{Assembly, standing};
use super::random::{Noise, Random, below};
use super::spec::{LibraryParam, LibraryScene, LibrarySpec, Values};
use super::terrain::HeightField;
use super::trees::{oak, poplar, shrub, spruce};
use crate::error::Result;
use crate::memory::check_room;
use crate::scene::{Camera, DirectionalLight, Light};

/// The scene's self-description.
pub(super) const SPEC: LibrarySpec = LibrarySpec {
    name: "forest",
    title: "Forest on rolling hills",
    shows: "large scale through instancing: long shadows from the glade at the viewer's feet to hills a kilometre away",
    params: &[
        LibraryParam {
            name: "trees",
            default: 10_000.0,
            min: 1.0,
            max: 1_000_000.0,
            whole: true,
            doc: "how many trees",
        },
        LibraryParam {
            name: "extent",
            default: 1000.0,
            min: 200.0,
            max: 20_000.0,
            whole: false,
            doc: "edge of the square terrain, m",
        },
        LibraryParam {
            name: "relief",
            default: 1.0,
            min: 0.0,
            max: 4.0,
            whole: false,
            doc: "height of the hills, 1 = about 70 m",
        },
    ],
    build,
};

/// Cells of the terrain along each edge.
const CELLS: usize = 320;
/// What a tree and its share of the undergrowth take while the scene is made: an instance, its box and its places in the
/// hierarchy, 224 bytes.
const BYTES_PER_TREE: u64 = 256;

fn build(seed: u64, values: &Values) -> Result<LibraryScene> {
    let (trees, extent) = (values.count("trees"), values.number("extent"));
    check_room("trees", BYTES_PER_TREE * trees as u64, || format!("{trees}"))?;
    let hills = Hills { noise: Noise::new(seed, 7), extent, relief: values.number("relief") };
    let half = DVec2::splat(0.5 * extent);
    let terrain = HeightField::new(-half, half, [CELLS, CELLS], |x, z| hills.height(x, z));
    let mut assembly = Assembly::with_places(trees + trees / 8 + 1, values.progress)?;
    assembly.fixed(&terrain.solid(-60.0 * hills.relief - 2.0))?;
    plant(&mut assembly, seed, trees, &hills, &terrain)?;
    undergrowth(&mut assembly, seed, trees / 8, &hills, &terrain)?;

    let eye = hills.eye();
    let ground = terrain.height_at(eye.x, eye.y);
    let eye = DVec3::new(eye.x, ground + 4.5, eye.y);
    let ahead = 0.2 * extent;
    let target = DVec3::new(hills.glade(eye.z - ahead), eye.y - 0.11 * ahead, eye.z - ahead);
    let camera = Camera::look_at(eye, target, DVec3::Y, 50f64.to_radians(), 16.0 / 9.0, 0.5, 1.2 * extent)?;
    let light = Light::Directional(DirectionalLight::new(DVec3::new(-0.85, -0.44, -0.2))?);
    Ok(LibraryScene { name: SPEC.name, scene: assembly.scene()?, camera, light })
}

/// The shape of the land.
struct Hills {
    noise: Noise,
    extent: f64,
    relief: f64,
}

impl Hills {
    /// The height of the land: it falls from the viewer into a valley and rises to hills on the far side.
    fn height(&self, x: f64, z: f64) -> f64 {
        let ahead = self.eye().y - z;
        let t = ahead / self.extent;
        // Value noise in four octaves stays within 13 * 2 m; 26 + 30 m is the deepest that the land can lie.
        let rolling = 13.0 * self.noise.octaves(x / 190.0, z / 190.0, 4);
        let calm = 1.0 - 0.75 * bell(DVec2::new(x, z).distance(self.eye()) / (0.16 * self.extent));
        let fall = -30.0 * smooth((t + 0.04) / 0.3);
        // The far slope faces the viewer like a screen.
        let rise = 72.0 * smooth((t - 0.24) / 0.66);
        self.relief * (calm * rolling + fall + rise)
    }
    /// The middle line of the glade, x over z.
    fn glade(&self, z: f64) -> f64 {
        26.0 * self.noise.at(0.5, z / 130.0) + 8.0 * self.noise.at(9.5, z / 47.0)
    }
    /// Half the width of the glade at z: closes far from the eye.
    fn glade_half_width(&self, z: f64) -> f64 {
        let ahead = self.eye().y - z;
        let breath = 1.0 + 0.45 * self.noise.at(20.5, z / 31.0);
        6.0 * breath * (1.0 - smooth((ahead - 0.3 * self.extent) / (0.1 * self.extent)))
    }
    /// Where the viewer stands, x and z: on the glade, near the border of the terrain.
    fn eye(&self) -> DVec2 {
        let z = 0.44 * self.extent;
        DVec2::new(self.glade(z), z)
    }
}

/// 1 at 0, falling to 0 at -1 and 1, without a kink.
fn bell(t: f64) -> f64 {
    let t = (1.0 - t * t).max(0.0);
    t * t
}

/// From 0 at 0 to 1 at 1, without a kink.
fn smooth(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn plant(assembly: &mut Assembly, seed: u64, trees: usize, hills: &Hills, terrain: &HeightField) -> Result<()> {
    let mut random = Random::new(seed, 8);
    let species = [
        spruce(&mut random),
        spruce(&mut random),
        spruce(&mut random),
        oak(&mut random),
        oak(&mut random),
        oak(&mut random),
        poplar(&mut random),
        poplar(&mut random),
    ];
    let species = species.iter().map(|s| assembly.part(s)).collect::<Result<Vec<_>>>()?;
    // Spruces rule where the noise is high, oaks where it is low, poplars mix in between.
    let kinds = Noise::new(seed, 9);
    // Trunks keep off the border, where a crown would hang over the edge of the world.
    let margin = 4.0;
    let side = hills.extent - 2.0 * margin;
    let (mut u, mut v) = (random.unit(), random.unit());
    let mut planted = 0;
    // Random numbers follow each other; what is found from them does not.
    while planted < trees {
        assembly.check()?;
        let mut drawn = Vec::with_capacity(AT_ONCE.min(trees - planted));
        while drawn.len() < AT_ONCE.min(trees - planted) {
            // The R2 sequence (Roberts 2018 [roberts2018]): steps 1/g and 1/g^2 with g the plastic number.
            u = (u + 0.754_877_666_246_692_8).fract();
            v = (v + 0.569_840_290_998_053_2).fract();
            // Jittered by less than the spacing, so that no rows show.
            let spacing = side / (trees as f64).sqrt();
            let jitter = random.direction() * (random.unit() * 0.45 * spacing);
            let p = DVec2::new(u * side, v * side) + jitter;
            let p = p.clamp(DVec2::ZERO, DVec2::splat(side)) + (margin - 0.5 * hills.extent);
            let (heading, size, mood) = (random.direction(), random.range(0.6, 1.3), random.unit());
            let off_glade = (p.x - hills.glade(p.y)).abs() - hills.glade_half_width(p.y);
            let from_eye = p.distance(hills.eye());
            if off_glade < 0.0 || from_eye < 13.0 {
                continue;
            }
            drawn.push(Tree { p, heading, size, mood, kind: random.unit(), stretch: random.range(0.85, 1.2) });
        }
        planted += drawn.len();
        let placed = drawn.par_iter().map(|tree| {
            let Tree { p, heading, size, stretch, .. } = *tree;
            let at = DVec3::new(p.x, terrain.height_at(p.x, p.y), p.y);
            let stretch = DAffine3::from_scale(DVec3::new(1.0, stretch, 1.0));
            (species[tree.species(&kinds)], standing(at, heading, size) * stretch)
        });
        assembly.place_all(placed);
    }
    Ok(())
}

/// Trees that are placed at once, in parallel.
const AT_ONCE: usize = 1 << 16;

/// A tree as it was drawn.
struct Tree {
    p: DVec2,
    heading: DVec2,
    size: f64,
    /// Numbers in [0, 1): how it leans among the kinds of the place, and which of the chosen kind it is.
    mood: f64,
    kind: f64,
    stretch: f64,
}

impl Tree {
    /// Index of its species.
    fn species(&self, kinds: &Noise) -> usize {
        let mood = kinds.octaves(self.p.x / 90.0, self.p.y / 90.0, 3) + 0.5 * (self.mood - 0.5);
        match mood {
            m if m > 0.0 => below(self.kind, 3),
            m if m > -0.12 => 6 + below(self.kind, 2),
            _ => 3 + below(self.kind, 3),
        }
    }
}

/// Shrubs, denser around the viewer, on the glade as well.
fn undergrowth(assembly: &mut Assembly, seed: u64, shrubs: usize, hills: &Hills, terrain: &HeightField) -> Result<()> {
    let mut random = Random::new(seed, 10);
    let kinds = [shrub(&mut random), shrub(&mut random), shrub(&mut random)];
    let kinds = kinds.iter().map(|s| assembly.part(s)).collect::<Result<Vec<_>>>()?;
    let inside = 0.5 * hills.extent - 4.0;
    for _ in 0..shrubs {
        // The power of a uniform number crowds them near the eye (a root and a product: exact on every platform).
        let u = random.unit();
        let out = hills.extent * u * u.sqrt();
        let p = hills.eye() + random.direction() * (5.0 + out);
        let (heading, size, kind) = (random.direction(), random.range(0.4, 1.2), random.below(3));
        if p.abs().max_element() < inside {
            let at = DVec3::new(p.x, terrain.height_at(p.x, p.y), p.y);
            assembly.place(kinds[kind], standing(at, heading, size));
        }
    }
    Ok(())
}
