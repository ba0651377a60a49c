//! The texels of a map that pixels look up, tile by tile, with the farthest depth that is compared there.
//!
//! ```text
//!     . . . . . .        . no pixel looks here: a caster over these tiles alone changes no pixel
//!     . . 7 8 . .        7 the farthest depth that is compared in the tile: a caster behind it leaves every
//!     . 6 7 8 9 .          comparison as it is, whether it is stored or what lies behind it
//! ```
//! A pyramid of maxima answers for boxes of any size by a few tiles (Greene, Kass and Miller 1993 `[greene1993]`).

use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

use glam::{DMat4, DVec2, DVec3, DVec4};

use super::rule::Rule;
use crate::error::Result;
use crate::memory::with_room;
use crate::parameterization::{Partition, PostWarp};
use crate::render::stored::{Format, Spacing, Stored, StoredSurface};

/// Tiles along a side of the finest level, at most. Chosen as trees in a map of a forest have some tens of texels, and a
/// quarter of a megabyte stays in a level-2 cache.
const MOST_TILES: u32 = 256;
/// Tiles along a side that are looked at for one box.
const FEW: usize = 4;
/// Texels about a box that a renderer's grid and rounding may reach.
const PAD: f64 = 1.5;
/// What vertices' depths lose at most in single precision: a unit in the last place of 1 (`render::precision`), 2^-23, and the
/// division by w; doubled twice.
const DEPTH_ROUNDING: f64 = 1.0 / (1 << 20) as f64;
/// Least w of a box's corners, relative to the largest: nearer to the projection centre a box covers no rectangle to speak of.
const LEAST_W: f64 = 1e-6;
/// No pixel looks there.
const UNASKED: u32 = 0;

/// The texels that are looked up in one map.
#[derive(Debug)]
pub struct Asked {
    /// `shadow_clip_from_world` less the origin, which positions are relative to.
    rows: [DVec4; 4],
    origin: DVec3,
    post_warp: PostWarp,
    size: DVec2,
    /// Texels along a tile.
    tile: f64,
    /// Where depths can be compared, what they are rounded to.
    format: Option<Format>,
    /// Finest first: width, height, and rows of keys.
    levels: Vec<Level>,
}

#[derive(Debug)]
struct Level {
    size: [usize; 2],
    /// [`UNASKED`], or 1 more than the bits of the farthest depth.
    keys: Vec<u32>,
}

/// Tiles while pixels say what they look up.
#[derive(Debug)]
pub(crate) struct Marks {
    tile: f64,
    texels: DVec2,
    size: [usize; 2],
    keys: Vec<AtomicU32>,
}

impl Marks {
    /// Of a map of `size` texels.
    pub fn new(size: [u32; 2]) -> Result<Self> {
        let tile = size[0].max(size[1]).div_ceil(MOST_TILES);
        let tiles = size.map(|n| n.div_ceil(tile) as usize);
        let mut keys = with_room("resolution", tiles[0] * tiles[1])?;
        keys.resize_with(tiles[0] * tiles[1], || AtomicU32::new(UNASKED));
        Ok(Self { tile: f64::from(tile), texels: size.map(f64::from).into(), size: tiles, keys })
    }
    /// A pixel looks up texels no farther than `reach` from a place, and compares depths up to `depth` (0 to 1) there. Beyond
    /// the map's edge the texels at the edge are looked up.
    pub fn add(&self, place: DVec2, reach: DVec2, depth: f64) {
        let key = key_of(depth);
        let [columns, rows] = tiles_of(place - reach, place + reach, self.tile, self.texels, self.size);
        for row in rows[0]..=rows[1] {
            for at in &self.keys[row * self.size[0] + columns[0]..=row * self.size[0] + columns[1]] {
                // Mostly a neighbour has asked for as much.
                if at.load(Relaxed) < key {
                    at.fetch_max(key, Relaxed);
                }
            }
        }
    }
    /// Whether any pixel looks up a texel.
    pub fn is_asked(&self) -> bool {
        self.keys.iter().any(|key| key.load(Relaxed) != UNASKED)
    }
    /// What is looked up in the map of a partition that stores depths so.
    pub fn finish(self, partition: &Partition, origin: DVec3, stored: &Stored) -> Asked {
        let m = partition.shadow_clip_from_world * DMat4::from_translation(origin);
        // Of two layers a caster behind the receiver may be the second. A depth along the light is found from a rounded one by a
        // quotient that may enlarge its rounding.
        let is_nearest = stored.spacing == Spacing::Projective
            && matches!(stored.surface, StoredSurface::Front | StoredSurface::Back | StoredSurface::Second);
        let keys = self.keys.into_iter().map(AtomicU32::into_inner).collect();
        let mut levels = vec![Level { size: self.size, keys }];
        while let Some(next) = levels.last().and_then(Level::halved) {
            levels.push(next);
        }
        Asked {
            rows: [0, 1, 2, 3].map(|i| m.row(i)),
            origin,
            post_warp: partition.post_warp.clone(),
            size: self.texels,
            tile: self.tile,
            format: is_nearest.then_some(stored.format),
            levels,
        }
    }
}

/// The first and last column and row of the tiles that a rectangle of texels touches, the nearest ones where it lies beside the
/// map; a NaN touches all.
fn tiles_of(low: DVec2, high: DVec2, tile: f64, texels: DVec2, size: [usize; 2]) -> [[usize; 2]; 2] {
    [0, 1].map(|k| {
        if low[k].is_nan() || high[k].is_nan() {
            return [0, size[k] - 1];
        }
        let at = |x: f64| (x.clamp(0.0, texels[k] - 0.5) / tile) as usize;
        [at(low[k]), at(high[k]).min(size[k] - 1)]
    })
}

/// The key of a depth, rounded away from the light.
fn key_of(depth: f64) -> u32 {
    // Not `clamp`, which would let a NaN be.
    let depth = if depth < 1.0 { depth.max(0.0) } else { 1.0 };
    let rounded = depth as f32;
    let up = if f64::from(rounded) < depth { rounded.next_up() } else { rounded };
    up.to_bits() + 1
}

impl Level {
    /// The level of half as many tiles along each side; nothing of the last.
    fn halved(&self) -> Option<Self> {
        if self.size == [1, 1] {
            return None;
        }
        let [width, height] = self.size.map(|n| n.div_ceil(2));
        let mut keys = vec![UNASKED; width * height];
        for (row, from) in self.keys.chunks_exact(self.size[0]).enumerate() {
            let to = &mut keys[row / 2 * width..];
            from.iter().enumerate().for_each(|(column, key)| to[column / 2] = to[column / 2].max(*key));
        }
        Some(Self { size: [width, height], keys })
    }
}

impl Asked {
    /// The same for a renderer whose depths are not known to lie between those of a triangle's corners: texels alone count.
    #[cfg(feature = "gpu")]
    pub fn of_texels(self) -> Self {
        Self { format: None, ..self }
    }
    /// Why a caster with these corners (world) changes nothing; nothing where it may.
    pub(super) fn rule_against(&self, corners: &[DVec3; 8]) -> Option<Rule> {
        let (low, high, nearest) = self.footprint(corners)?;
        if high.cmplt(DVec2::ZERO).any() || low.cmpgt(self.size).any() {
            return Some(Rule::Unseen);
        }
        match self.farthest(low, high) {
            UNASKED => Some(Rule::Unseen),
            key => {
                let format = self.format?;
                let stored = format.quantise((nearest - DEPTH_ROUNDING).clamp(0.0, 1.0) as f32);
                (stored > f32::from_bits(key - 1)).then_some(Rule::Behind)
            }
        }
    }

    /// The rectangle of texels that a box may cover and its least depth; nothing where it reaches to the projection centre.
    fn footprint(&self, corners: &[DVec3; 8]) -> Option<(DVec2, DVec2, f64)> {
        let [row_x, row_y, row_z, row_w] = self.rows;
        let (mut low, mut high, mut nearest) = (DVec2::INFINITY, DVec2::NEG_INFINITY, f64::INFINITY);
        let (mut least_w, mut largest_w) = (f64::INFINITY, 0.0f64);
        for corner in corners {
            let p4 = (corner - self.origin).extend(1.0);
            let w = row_w.dot(p4);
            (least_w, largest_w) = (least_w.min(w), largest_w.max(w.abs()));
            let ndc = DVec3::new(row_x.dot(p4), row_y.dot(p4), row_z.dot(p4)) / w;
            (low, high) = (low.min(ndc.truncate()), high.max(ndc.truncate()));
            nearest = nearest.min(ndc.z);
        }
        if !(least_w > LEAST_W * largest_w) {
            return None;
        }
        // Under a post-warp as well, x and y ascend or descend.
        let ends = [self.post_warp.apply(low.extend(0.0), least_w), self.post_warp.apply(high.extend(0.0), largest_w)];
        let ends = ends.map(|ndc| DVec2::new(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * self.size);
        let (low, high) = (ends[0].min(ends[1]) - PAD, ends[0].max(ends[1]) + PAD);
        (low.is_finite() && high.is_finite() && nearest.is_finite()).then_some((low, high, nearest))
    }

    /// The largest key of the tiles under a rectangle.
    fn farthest(&self, low: DVec2, high: DVec2) -> u32 {
        let [columns, rows] = tiles_of(low, high, self.tile, self.size, self.levels[0].size);
        let spans = |level: usize, [first, last]: [usize; 2]| (last >> level) - (first >> level) < FEW;
        let level = (0..self.levels.len() - 1).find(|&k| spans(k, columns) && spans(k, rows));
        let level = level.unwrap_or(self.levels.len() - 1);
        let Level { size: [width, _], keys } = &self.levels[level];
        let mut found = UNASKED;
        for row in rows[0] >> level..=rows[1] >> level {
            let row = &keys[row * width..][columns[0] >> level..=columns[1] >> level];
            found = row.iter().fold(found, |all, key| all.max(*key));
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A map of the square from -1 to 1, depth from z = 1 down to 0, with one pixel that looks at a place.
    fn asked(place: DVec2, depth: f64, stored: Stored) -> Asked {
        let matrix = DMat4::from_scale(DVec3::new(1.0, 1.0, -1.0));
        let partition = Partition::of_matrix(DMat4::from_translation(DVec3::Z) * matrix);
        let marks = Marks::new([512, 512]).unwrap();
        marks.add(place, DVec2::splat(0.5), depth);
        marks.finish(&partition, DVec3::ZERO, &stored)
    }
    /// A small cube about texel coordinates and a depth.
    fn cube(place: [f64; 2], depth: f64) -> [DVec3; 8] {
        let [x, y] = place;
        let p = DVec3::new(x / 256.0 - 1.0, 1.0 - y / 256.0, 1.0 - depth);
        crate::geometry::Aabb { min: p - 1e-3, max: p + 1e-3 }.corners()
    }

    #[test]
    fn only_what_lies_before_a_receiver_of_its_tiles_counts() {
        let asked = asked(DVec2::new(100.5, 40.5), 0.5, Stored::FRONT);
        assert_eq!(asked.rule_against(&cube([100.0, 40.0], 0.2)), None);
        assert_eq!(asked.rule_against(&cube([100.0, 40.0], 0.5)), None, "as far as the receiver");
        assert_eq!(asked.rule_against(&cube([100.0, 40.0], 0.502)), Some(Rule::Behind));
        assert_eq!(asked.rule_against(&cube([120.0, 40.0], 0.2)), Some(Rule::Unseen));
        assert_eq!(asked.rule_against(&cube([-40.0, 40.0], 0.2)), Some(Rule::Unseen), "beside the map");
        assert_eq!(asked.rule_against(&cube([103.4, 40.0], 0.2)), None, "the next tile, by the grid's reach");
    }

    #[test]
    fn large_boxes_are_asked_by_few_tiles() {
        let asked = asked(DVec2::new(509.5, 511.5), 0.25, Stored::FRONT);
        let plate = |z: f64| crate::geometry::Aabb { min: DVec3::new(-1.0, -1.0, z), max: DVec3::new(1.0, 1.0, z) };
        assert_eq!(asked.rule_against(&plate(0.9).corners()), None);
        assert_eq!(asked.rule_against(&plate(0.7).corners()), Some(Rule::Behind));
        let left = crate::geometry::Aabb { min: DVec3::NEG_ONE, max: DVec3::new(0.0, 1.0, 1.0) };
        assert_eq!(asked.rule_against(&left.corners()), Some(Rule::Unseen));
    }

    #[test]
    fn depths_are_compared_as_they_are_stored() {
        let of = |text: &str| text.parse::<Stored>().unwrap();
        // A step of 16 bits is 1.5e-5: what lies behind by less may be rounded to before the receiver.
        let coarse = asked(DVec2::splat(100.0), 0.5 + 9e-6, of("front:format=unorm16"));
        let fine = asked(DVec2::splat(100.0), 0.5 + 9e-6, Stored::FRONT);
        let behind = cube([100.0, 100.0], 0.501 + 12e-6);
        assert_eq!((coarse.rule_against(&behind), fine.rule_against(&behind)), (None, Some(Rule::Behind)));
        for (text, expected) in
            [("back", Some(Rule::Behind)), ("second", Some(Rule::Behind)), ("dual", None), ("midpoint", None)]
        {
            let asked = asked(DVec2::splat(100.0), 0.5, of(text));
            assert_eq!(asked.rule_against(&cube([100.0, 100.0], 0.9)), expected, "{text}");
        }
        let asked = asked(DVec2::splat(100.0), 0.5, of("front:spacing=linear"));
        assert_eq!(asked.rule_against(&cube([100.0, 100.0], 0.9)), None, "linear");
    }

    #[test]
    fn places_beyond_the_edge_are_those_at_the_edge() {
        let asked = asked(DVec2::new(-3.0, 600.0), 1.0, Stored::FRONT);
        assert_eq!(asked.rule_against(&cube([1.0, 511.0], 0.2)), None);
        assert_eq!(asked.rule_against(&cube([9.0, 511.0], 0.2)), Some(Rule::Unseen));
        assert_eq!((key_of(f64::NAN), key_of(-1.0)), (1f32.to_bits() + 1, 1));
        assert!(f64::from(f32::from_bits(key_of(0.1) - 1)) >= 0.1);
    }
}
