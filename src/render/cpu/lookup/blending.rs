//! Which map's light is mixed in near the end of another's range: theory.md (14.6).
//!
//! ```text
//!   map k      |------------------------>|           the end of its range, or its border
//!   zone                         |=======|           its last share: light goes from that of map k to that of the next
//!   next map                    |--------------->    holds receivers of the zone where z_partition overlaps
//! ```

use glam::DVec3;

use super::lookup::Lookups;
use crate::parameterization::{Held, Selection};

/// A map whose light is mixed in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Next {
    /// The map.
    pub map: usize,
    /// Its share of the light, above 0 and at most 1.
    pub share: f64,
}

impl Lookups<'_> {
    /// The map that would serve a receiver beyond the range of the one that does, map `k`, and its share of the light; nothing
    /// outside of the zone, and where no further map holds the receiver. `p` is relative to the origin.
    pub fn next(&self, k: usize, p: DVec3, eye_depth: f64) -> Option<Next> {
        let share = match self.p.selection {
            Selection::Depth => {
                let [begin, end] = self.p.partitions[k].eye_depth;
                let zone = self.blend * (end - begin);
                (eye_depth - (end - zone)) / zone
            }
            Selection::Containment => (self.map(k).way_from_middle(p) - (1.0 - self.blend)) / self.blend,
        };
        // Written so that a NaN, of a range without an end, is none.
        if !(share > 0.0) {
            return None;
        }
        let map = Held::first(self.p.after(k)?..self.count(), |k| self.map(k).holds(p)).filter(|next| *next != k)?;
        Some(Next { map, share: share.min(1.0) })
    }
}
