//! The result of a technique: plain data that renderers, analysis and users see.

use std::sync::Arc;

use glam::{DMat4, DVec3};

use super::partition::{Held, Partition};
use super::value::Value;
use crate::error::{Error, Result};
use crate::note::Note;

/// How a receiver finds its map, where there are several.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Selection {
    /// The first map whose depth range does not end before the receiver's camera depth, and which holds it.
    #[default]
    Depth,
    /// The first map that holds the receiver, whatever its camera depth.
    Containment,
}

/// A technique's settings turned into matrices for one scene, camera and light.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameterization {
    /// Name of the technique, or "matrix" for somebody else's.
    pub technique: String,
    /// The technique's parameters as used.
    pub settings: Arc<[(&'static str, Value)]>,
    /// The maps, nearest first. At least one.
    pub partitions: Vec<Partition>,
    /// How a receiver finds its map.
    pub selection: Selection,
    /// Texels along x and y the fit (border, snapping) was made for.
    pub resolution: [u32; 2],
    /// Texels at each side that no receiver maps to.
    pub border_texels: u32,
    /// What the user should know of all maps, or of some of them: those of the maps are gathered here.
    pub notes: Vec<Note>,
}

impl Parameterization {
    /// Somebody else's maps.
    pub fn of_partitions(partitions: Vec<Partition>, resolution: [u32; 2]) -> Self {
        Self {
            technique: "matrix".into(),
            settings: Arc::new([]),
            partitions,
            selection: Selection::Depth,
            resolution,
            border_texels: 0,
            notes: Vec::new(),
        }
    }
    /// The map in which a receiver at a world point and camera depth is looked up; nothing where no map holds it.
    pub fn choose(&self, p_world: DVec3, eye_depth: f64) -> Option<usize> {
        let maps = self.first_map(eye_depth)..self.partitions.len();
        Held::first(maps, |k| self.partitions[k].holds(p_world))
    }
    /// The first map that may serve a camera depth: under [`Selection::Depth`] the first that does not end before it; those
    /// that end where the last does have no end.
    pub fn first_map(&self, eye_depth: f64) -> usize {
        let Some(last) = self.partitions.last() else { return 0 };
        let reaches = |p: &Partition| eye_depth <= p.eye_depth[1] || p.eye_depth[1] >= last.eye_depth[1];
        match self.selection {
            Selection::Containment => 0,
            Selection::Depth => self.partitions.iter().position(reaches).unwrap_or(self.partitions.len() - 1),
        }
    }
    /// The first map that may serve receivers beyond the range of map `k`; nothing of a map whose range has no end.
    pub fn after(&self, k: usize) -> Option<usize> {
        let end = self.partitions[k].eye_depth[1];
        match self.selection {
            Selection::Containment => (k + 1 < self.partitions.len()).then_some(k + 1),
            Selection::Depth if end >= self.partitions.last()?.eye_depth[1] => None,
            Selection::Depth => self.partitions.iter().position(|p| p.eye_depth[1] > end),
        }
    }
    /// The same maps for points told relative to `origin`: what it does there, [`Parameterization::choose`] included.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a matrix that is not finite.
    pub fn relative_to(&self, origin: DVec3) -> Result<Self> {
        let mut moved = self.clone();
        for partition in &mut moved.partitions {
            partition.shadow_clip_from_world *= DMat4::from_translation(origin);
            if let Some(factors) = &mut partition.factors {
                factors.lift *= DMat4::from_translation(origin);
            }
            partition.region = partition.region.relative_to(origin);
            if !partition.shadow_clip_from_world.is_finite() {
                let fix = "check where the matrix comes from";
                return Err(Error::argument(
                    "shadow_clip_from_world",
                    "16 finite numbers",
                    "a NaN or an infinity",
                    fix,
                ));
            }
        }
        Ok(moved)
    }
    /// A named intermediate number of the first map that has it.
    pub fn value(&self, name: &str) -> Option<f64> {
        self.partitions.iter().find_map(|p| p.value(name))
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec4;

    use super::super::{PostWarp, Region};
    use super::*;

    /// A map of the square of half side `half` around the origin, for depths 0 to 1.
    fn square(half: f64, ends: f64) -> Partition {
        let matrix = DMat4::from_scale(DVec3::new(1.0 / half, 1.0 / half, 1.0));
        Partition { eye_depth: [0.0, ends], ..Partition::of_matrix(matrix) }
    }

    #[test]
    fn a_receiver_finds_the_first_map_from_its_depth_that_holds_it() {
        let mut p =
            Parameterization::of_partitions(vec![square(1.0, 1.0), square(2.0, 2.0), square(4.0, 3.0)], [64; 2]);
        let at = |x: f64, z: f64| DVec3::new(x, 0.0, z);
        assert_eq!(p.choose(at(0.5, 0.5), 0.5), Some(0));
        assert_eq!(p.choose(at(0.5, 0.5), 1.0), Some(0), "the end is part of the range");
        assert_eq!(p.choose(at(0.5, 0.5), 1.5), Some(1));
        assert_eq!(p.choose(at(0.5, 0.5), 9.0), Some(2), "the last map has no end");
        assert_eq!(p.choose(at(0.5, 0.5), f64::NAN), Some(2));
        assert_eq!(p.choose(at(1.5, 0.5), 0.5), Some(1), "the first does not hold it");
        assert_eq!(p.choose(at(5.0, 0.5), 0.5), None);
        assert_eq!(p.choose(at(f64::NAN, 0.5), 0.5), None);
        assert_eq!(p.choose(at(0.5, -0.5), 0.5), Some(0), "before the near plane is no reason");
        // Beyond the far plane of the first, a later one may know more.
        p.partitions[1].shadow_clip_from_world *= DMat4::from_scale(DVec3::new(1.0, 1.0, 0.25));
        assert_eq!(p.choose(at(0.5, 2.0), 0.5), Some(1));
        assert_eq!(p.choose(at(0.5, 5.0), 0.5), Some(0), "beyond all of them");
        p.selection = Selection::Containment;
        assert_eq!(p.choose(at(0.5, 0.5), 9.0), Some(0));
        p.partitions[0].region = Region::new(&[DVec4::new(-1.0, 0.0, 0.0, 0.0)]);
        assert_eq!(p.choose(at(0.5, 0.5), 0.0), Some(1), "outside of its region");
        assert_eq!(p.choose(at(0.0, 0.5), 0.0), Some(0), "the border belongs to it");
        // The farthest maps of two faces: none of them is the end of the other.
        p.selection = Selection::Depth;
        p.partitions[1] = square(4.0, 3.0);
        p.partitions[2] = square(2.0, 3.0);
        assert_eq!(p.choose(at(3.5, 0.5), 3.1), Some(1));
        assert_eq!(Parameterization::of_partitions(vec![], [1; 2]).choose(DVec3::ZERO, 0.0), None);
    }

    #[test]
    fn points_behind_the_projection_centre_are_in_no_map() {
        let behind = DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::Z, -DVec4::W);
        let p = Parameterization::of_partitions(vec![Partition::of_matrix(behind)], [64; 2]);
        assert_eq!(p.choose(DVec3::ZERO, 0.0), None);
        let mut log = Partition::of_matrix(behind);
        log.post_warp = PostWarp::Log { scale: 1.0, offset: 0.0 };
        assert_eq!(log.holds(DVec3::ZERO), Held::Outside);
    }
}
