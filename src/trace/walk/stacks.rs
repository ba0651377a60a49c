//! What a walk still has to enter.

use super::one_ray::Stack;
use crate::trace::hierarchy::WIDTH;
use crate::trace::rays::{BUNDLE, LocalRays};

/// What is still to be entered, kept between walks for its memory.
#[derive(Debug, Default)]
pub struct Stacks {
    pub together: Vec<Waiting>,
    pub alone: Stack,
    /// Instance and leaf that last ended a ray of a bundle: neighbours are mostly blocked by the same, so that is looked at first,
    /// for as long as it ends any.
    pub blocker: Option<(u32, u32)>,
    /// The same of each of several lights.
    pub blockers: Vec<Option<(u32, u32)>>,
    /// Places for rays in a frame. Boxed, since they are taken out while a walk uses them.
    #[allow(clippy::vec_box)]
    pub frames: Vec<Box<LocalRays<BUNDLE>>>,
}

/// A child still to be entered, and a lower bound of where any ray enters it, which is not negative: ordered by it.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct Waiting(u64);

impl Waiting {
    #[inline(always)]
    pub fn new(node: u32, child: usize, entry: f32) -> Self {
        // Numbers that are not negative have the order of their bits, and a tree has at most 2^29 nodes.
        Self(u64::from(entry.to_bits()) << 32 | u64::from(node << 3 | child as u32))
    }
    #[inline(always)]
    pub fn entry(self) -> f32 {
        f32::from_bits((self.0 >> 32) as u32)
    }
    #[inline(always)]
    pub fn node(self) -> usize {
        (self.0 as u32 >> 3) as usize
    }
    #[inline(always)]
    pub fn child(self) -> usize {
        self.0 as usize % WIDTH
    }
}
