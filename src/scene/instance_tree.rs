//! A hierarchy of boxes over the instances of a scene: made once with the scene, and walked wherever instances are looked for.
//!
//! Instances are sorted along a Z-order curve (Morton 1966 `[morton1966]`) and cut into runs of eight; eight runs make a
//! group, eight groups the next, as in a linear hierarchy (Lauterbach et al. 2009 `[lauterbach2009]`). The tree is complete,
//! so boxes lie in plain arrays, level by level, and nothing points anywhere: 12 bytes an instance, some 50 ms for a million.
//!
//! ```text
//!   levels[1]   [ 0 ............... ][ 1 ...
//!   levels[0]   [ 0 ][ 1 ] ... [ 7 ][ 8 ][ 9 ]     box j of level k holds places j << 3 (k + 1) to (j + 1) << 3 (k + 1)
//!   order       17 4 9 ..                          instances by place
//! ```

use std::ops::{ControlFlow, Range};

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::Aabb;
use crate::progress::Progress;

/// Logarithm of the children of a group and of the instances of a run.
const LOG2_WIDTH: u32 = 3;
/// Groups at the level from which a walk goes on in parallel, at least where there are as many: some for each thread.
const PARALLEL: usize = 64;
/// Bits of a place along each axis in a Z-order code.
const CODE_BITS: u32 = 21;

/// The hierarchy. Boxes are in the world and hold their instances with the roundings of these.
#[derive(Debug)]
pub struct InstanceTree {
    order: Vec<u32>,
    levels: Vec<Vec<Aabb>>,
}

/// What a walk comes across.
#[derive(Debug, Clone, Copy)]
pub enum Met<'a> {
    /// A group of instances in a box: whether to go into it.
    Group(&'a Aabb),
    /// An instance.
    One(usize),
}

/// What to do with a group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Enter {
    /// None of its instances counts.
    No,
    /// Each is looked at by itself.
    Each,
    /// All of them count.
    All,
}

impl InstanceTree {
    /// The tree over some boxes, at least one, which `of` finds in what is there for each instance.
    ///
    /// # Errors
    /// [`Error::Interrupted`](crate::Error::Interrupted).
    pub(super) fn new<T: Sync>(items: &[T], of: impl Fn(&T) -> &Aabb + Sync, progress: &Progress) -> Result<Self> {
        progress.check()?;
        let union = || Aabb::EMPTY;
        let centers = items.par_iter().map(|item| of(item).center());
        let centers = centers.fold(union, Aabb::with_point).reduce(union, Aabb::union);
        let per_unit = f64::from(1u32 << CODE_BITS) / centers.extent();
        let code = |item: &T| z_order((of(item).center() - centers.min) * per_unit);
        let mut coded: Vec<(u64, u32)> = items.par_iter().enumerate().map(|(i, item)| (code(item), i as u32)).collect();
        progress.check()?;
        coded.par_sort_unstable();
        progress.check()?;
        let order: Vec<u32> = coded.into_iter().map(|(_, i)| i).collect();
        let runs = order.par_chunks(1 << LOG2_WIDTH);
        let hull = |run: &[u32]| run.iter().fold(Aabb::EMPTY, |all, &i| all.union(*of(&items[i as usize])));
        let mut levels: Vec<Vec<Aabb>> = vec![runs.map(hull).collect()];
        progress.check()?;
        while let Some(last) = levels.last().filter(|last| last.len() > 1) {
            let groups = last.chunks(1 << LOG2_WIDTH).map(|g| g.iter().copied().fold(Aabb::EMPTY, Aabb::union));
            let groups = groups.collect();
            levels.push(groups);
        }
        Ok(Self { order, levels })
    }

    /// Meets groups, from the largest on, and the instances of those that are entered, until told to stop. What `meet` says of an
    /// instance does not matter.
    ///
    /// Level by level, in an order that jumps about, with one instance of each group at once: whoever looks for bounds soon has
    /// most of them, and enters few groups. So some instances are met twice.
    pub fn visit(&self, mut meet: impl FnMut(Met) -> ControlFlow<(), bool>) -> ControlFlow<()> {
        let (mut groups, mut below) = (vec![0], Vec::new());
        for level in (0..self.levels.len()).rev() {
            for at in scattered(groups.len()) {
                let index = groups[at];
                if !meet(Met::Group(&self.levels[level][index]))? {
                    continue;
                }
                let places = self.places(level, index);
                if level > 0 {
                    below.extend(self.children(level, index));
                    meet(Met::One(self.order[places.start + places.len() / 2] as usize))?;
                } else {
                    for &i in &self.order[places] {
                        meet(Met::One(i as usize))?;
                    }
                }
            }
            std::mem::swap(&mut groups, &mut below);
            below.clear();
        }
        ControlFlow::Continue(())
    }

    /// The instances that count, those near each other together: all of groups that `enter` takes whole, and those of groups
    /// entered for each that `counts` takes.
    pub fn select(&self, enter: impl Fn(&Aabb) -> Enter + Sync, counts: impl Fn(usize) -> bool + Sync) -> Vec<u32> {
        let level = self.levels.iter().rposition(|level| level.len() >= PARALLEL);
        let level = level.unwrap_or(self.levels.len() - 1);
        let parts: Vec<Vec<u32>> = (0..self.levels[level].len())
            .into_par_iter()
            .map(|index| {
                let mut found = Vec::new();
                self.select_group(level, index, &enter, &counts, &mut found);
                found
            })
            .collect();
        parts.concat()
    }

    /// What each instance is: what `group` says of all in a box, or, where it says nothing, `each` of the instance.
    pub fn classify<T: Copy + Send + Sync>(
        &self,
        group: impl Fn(&Aabb) -> Option<T> + Sync,
        each: impl Fn(usize) -> T + Sync,
    ) -> Vec<T> {
        let runs = &self.levels[0];
        let by_place: Vec<T> = (0..runs.len())
            .into_par_iter()
            .flat_map_iter(|run| {
                let whole = (1..self.levels.len()).rev().map(|level| (level, run >> (LOG2_WIDTH * level as u32)));
                let whole = whole.chain([(0, run)]).find_map(|(level, index)| group(&self.levels[level][index]));
                let (places, each) = (self.places(0, run), &each);
                self.order[places].iter().map(move |&i| whole.unwrap_or_else(|| each(i as usize)))
            })
            .collect();
        let mut by_instance = by_place.clone();
        for (&i, class) in self.order.iter().zip(by_place) {
            by_instance[i as usize] = class;
        }
        by_instance
    }

    fn select_group(
        &self,
        level: usize,
        index: usize,
        enter: &impl Fn(&Aabb) -> Enter,
        counts: &impl Fn(usize) -> bool,
        found: &mut Vec<u32>,
    ) {
        match enter(&self.levels[level][index]) {
            Enter::No => {}
            Enter::All => found.extend_from_slice(&self.order[self.places(level, index)]),
            Enter::Each if level == 0 => {
                found.extend(self.order[self.places(0, index)].iter().filter(|i| counts(**i as usize)));
            }
            Enter::Each => {
                for child in self.children(level, index) {
                    self.select_group(level - 1, child, enter, counts, found);
                }
            }
        }
    }

    /// The boxes below a group.
    fn children(&self, level: usize, index: usize) -> Range<usize> {
        let first = index << LOG2_WIDTH;
        first..(first + (1 << LOG2_WIDTH)).min(self.levels[level - 1].len())
    }

    /// The places of a group's instances in the order.
    fn places(&self, level: usize, index: usize) -> Range<usize> {
        let shift = LOG2_WIDTH * (level as u32 + 1);
        index << shift..((index + 1) << shift).min(self.order.len())
    }
}

/// The numbers below a count, each once, neighbours far apart: multiples of a number near the golden section of the count that has
/// no divisor in common with it.
fn scattered(count: usize) -> impl Iterator<Item = usize> {
    let divides = |step: &usize| {
        let (mut a, mut b) = (count, *step);
        while b > 0 {
            (a, b) = (b, a % b);
        }
        a == 1
    };
    let golden = (0.618 * count as f64) as usize;
    let step = (golden.max(1)..count).find(divides).unwrap_or(1);
    (0..count).map(move |i| (i as u64 * step as u64 % count as u64) as usize)
}

/// The code of a place along the curve: the bits of its coordinates, in [0, 2^21], in turn.
fn z_order(place: DVec3) -> u64 {
    // Casts saturate, and make 0 of a NaN, as of an axis along which all centres are one.
    let largest = (1 << CODE_BITS) - 1;
    let bits = place.to_array().map(|x| spread((x as u64).min(largest)));
    bits[0] | bits[1] << 1 | bits[2] << 2
}

/// The 21 lowest bits, two zeros between each two.
fn spread(x: u64) -> u64 {
    let x = (x | x << 32) & 0x1f_0000_0000_ffff;
    let x = (x | x << 16) & 0x1f_0000_ff00_00ff;
    let x = (x | x << 8) & 0x100f_00f0_0f00_f00f;
    let x = (x | x << 4) & 0x10c3_0c30_c30c_30c3;
    (x | x << 2) & 0x1249_2492_4924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    fn boxes(count: usize) -> Vec<Aabb> {
        let at = |i: usize| {
            let t = i as f64;
            DVec3::new((t * 0.37).sin() * 90.0, (t * 0.71).cos() * 3.0, (t * 0.113).sin() * 70.0)
        };
        (0..count).map(|i| Aabb { min: at(i) - 0.5, max: at(i) + 1.0 }).collect()
    }

    fn tree(boxes: &[Aabb]) -> InstanceTree {
        InstanceTree::new(boxes, |b| b, &Progress::new()).unwrap()
    }

    #[test]
    fn scattered_numbers_are_all_numbers() {
        for count in [0, 1, 2, 3, 4, 8, 9, 157, 1000] {
            let mut all: Vec<usize> = scattered(count).collect();
            assert!(count < 100 || all.windows(2).all(|w| w[0].abs_diff(w[1]) > count / 4), "{count}");
            all.sort_unstable();
            assert!(all.into_iter().eq(0..count), "{count}");
        }
    }

    #[test]
    fn codes_interleave_bits() {
        assert_eq!(spread(0b1011), 0b001_000_001_001);
        assert_eq!(spread((1 << 21) - 1).count_ones(), 21);
        assert_eq!(z_order(DVec3::new(1.0, 0.0, 1.0)), 0b101);
        assert_eq!(z_order(DVec3::splat(f64::NAN)), 0);
        assert_eq!(z_order(DVec3::splat(1e300)), (1 << 63) - 1);
    }

    #[test]
    fn a_selection_is_what_a_loop_finds() {
        for count in [1, 2, 7, 8, 9, 64, 65, 513, 5000] {
            let boxes = boxes(count);
            let tree = tree(&boxes);
            let inside = |b: &Aabb| b.min.x >= -20.0 && b.max.x <= 40.0;
            let touches = |b: &Aabb| b.max.x >= -20.0 && b.min.x <= 40.0;
            let enter = |b: &Aabb| match () {
                () if inside(b) => Enter::All,
                () if touches(b) => Enter::Each,
                () => Enter::No,
            };
            let mut found = tree.select(enter, |i| touches(&boxes[i]));
            found.sort_unstable();
            let expected: Vec<u32> = (0..count as u32).filter(|&i| touches(&boxes[i as usize])).collect();
            assert_eq!(found, expected, "{count}");
            let mut met = Vec::new();
            let _ = tree.visit(|seen| {
                if let Met::One(i) = seen {
                    met.push(i as u32);
                }
                ControlFlow::Continue(match seen {
                    Met::Group(b) => touches(b),
                    Met::One(_) => false,
                })
            });
            met.retain(|&i| touches(&boxes[i as usize]));
            met.sort_unstable();
            met.dedup();
            assert_eq!(met, expected, "{count}");
        }
    }

    #[test]
    fn a_walk_stops_when_told() {
        let tree = tree(&boxes(1000));
        let mut met = 0;
        let end = tree.visit(|seen| {
            met += usize::from(matches!(seen, Met::One(_)));
            if met == 10 { ControlFlow::Break(()) } else { ControlFlow::Continue(true) }
        });
        assert!(end.is_break() && met == 10);
    }

    #[test]
    fn equal_places_make_a_tree_too() {
        let tree = tree(&vec![Aabb { min: DVec3::ONE, max: DVec3::ONE }; 700]);
        assert_eq!(tree.select(|_| Enter::All, |_| false).len(), 700);
        assert_eq!(tree.select(|_| Enter::Each, |i| i % 7 == 0).len(), 100);
    }
}
