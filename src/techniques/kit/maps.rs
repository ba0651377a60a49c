//! What a technique is given, a view or a part of one, and what it returns.

use crate::fit::MapSize;
use crate::focus::Samples;
use crate::note::Note;
use crate::parameterization::{Partition, Region, Selection};
use crate::progress::Progress;
use crate::scene::{Camera, Light, Scene};

/// What maps are made of: a view, or a part of one.
#[derive(Debug, Clone, Copy)]
pub struct Part<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The camera; its near and far planes bound the part.
    pub camera: Camera,
    /// The light.
    pub light: Light,
    /// Texels and border of each map.
    pub size: MapSize,
    /// What the camera sees, where the technique needs it.
    pub samples: Option<&'a Samples>,
    /// The rays that the part is about.
    pub region: Region,
    /// Tells whether to stop; asked for every map.
    pub progress: &'a Progress,
}

/// The least length of depths that a map is made for, as a share of their far end. Derived from f64: half of the digits of
/// their difference are left.
const LEAST_LENGTH: f64 = 1.0 / (1 << 26) as f64;

/// Depths of a camera with a length, whatever they are: nothing seen, or one depth alone, still gets a valid map.
pub fn with_length([near, far]: [f64; 2], camera: &Camera) -> [f64; 2] {
    if camera.is_orthographic() {
        // Depths may be of either sign, or 0.
        let scale = near.abs().max(far.abs()).max(camera.far() - camera.near());
        return [near.min(far - LEAST_LENGTH * scale), far];
    }
    [near.min(far * (1.0 - LEAST_LENGTH)), far]
}

/// The maps of a part of a view.
#[derive(Debug, Clone, PartialEq)]
pub struct Maps {
    /// Nearest first; at least one.
    pub maps: Vec<Partition>,
    /// How a receiver finds its map.
    pub selection: Selection,
    /// What the user should know of all of them.
    pub notes: Vec<Note>,
}
