//! Alpha tests: which points of a mesh's triangles exist, by the alpha of a texture.
//!
//! Source: glTF 2.0, alpha mode MASK (section 3.9.4) and texture wrapping (3.8.4): a point exists where its alpha is at least
//! the cutoff. Departure: texels are always weighted bilinearly at full size, whatever filter a file names. Without mipmaps a
//! shadow does not depend on the distance of the viewer, and the map and the truth have one answer.
//!
//! ```text
//!   (0, 0) -> u         Texel (i, j) has its centre at ((i + 1/2) / W, (j + 1/2) / H). Row 0 of the image is at the top,
//!     +---+---+---+     v = 0 is its upper edge.
//!   v |0,0|1,0|2,0|
//!     +---+---+---+
//! ```
//! The twin on the device is `render/gpu/shaders/alpha_test.wgsl`, in single precision.

use std::sync::Arc;

use glam::DVec2;

use crate::digest::Digest;
use crate::error::{Error, Result};

/// Alpha of a texel that covers all.
const OPAQUE: f64 = 255.0;
/// Texels of a neighbourhood that are looked at one by one; a larger one counts as mixed.
const MOST_TEXELS: i64 = 64;

/// How texture coordinates outside [0, 1] are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Wrap {
    /// The image again and again.
    Repeat = 0,
    /// The same, every second one mirrored.
    Mirror = 1,
    /// The texels at the edge.
    Clamp = 2,
}

impl Wrap {
    /// All of them, by number.
    pub const ALL: [Self; 3] = [Self::Repeat, Self::Mirror, Self::Clamp];

    /// The place in [0, 1] that a coordinate reads.
    fn folded(self, u: f64) -> f64 {
        match self {
            Self::Repeat => u - u.floor(),
            Self::Mirror => {
                let twice = u - 2.0 * (0.5 * u).floor();
                twice.min(2.0 - twice)
            }
            Self::Clamp => u.clamp(0.0, 1.0),
        }
    }

    /// The texel at a place next to an image of `count` texels.
    fn texel(self, at: i64, count: u32) -> usize {
        let count = i64::from(count);
        (if self == Self::Repeat { at.rem_euclid(count) } else { at.clamp(0, count - 1) }) as usize
    }

    /// Between which two centres a coordinate lies, the first of them as a whole number and a part of the way.
    fn between(self, u: f64, count: u32) -> (i64, f64) {
        let place = self.folded(u) * f64::from(count) - 0.5;
        let first = place.floor();
        (first as i64, place - first)
    }
}

/// Alpha by texel, 255 opaque.
#[derive(Debug, PartialEq)]
pub struct AlphaTexture {
    size: [u32; 2],
    texels: Vec<u8>,
}

impl AlphaTexture {
    /// A texture of `size` texels (width, height), rows from the top.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a side of 0, or another number of texels.
    pub fn new(size: [u32; 2], texels: Vec<u8>) -> Result<Self> {
        let count = size[0] as usize * size[1] as usize;
        if count == 0 || texels.len() != count {
            let got = format!("{} texels for {} x {}", texels.len(), size[0], size[1]);
            return Err(Error::argument("alpha.texture", "at least one texel, in whole rows", got, "give all rows"));
        }
        Ok(Self { size, texels })
    }
    /// Width and height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }
    /// Rows from the top.
    pub fn texels(&self) -> &[u8] {
        &self.texels
    }
    fn at(&self, x: usize, y: usize) -> f64 {
        f64::from(self.texels[y * self.size[0] as usize + x])
    }
}

/// What an alpha test is made of.
#[derive(Debug, Clone, PartialEq)]
pub struct AlphaTestParts {
    /// None: alpha is 1 all over.
    pub texture: Option<Arc<AlphaTexture>>,
    /// Texture coordinates by vertex.
    pub uv: Vec<[f32; 2]>,
    /// Least alpha that exists.
    pub cutoff: f64,
    /// Along u and v.
    pub wrap: [Wrap; 2],
    /// What the texture's alpha is multiplied with.
    pub factor: f64,
}

/// An alpha test of a mesh.
#[derive(Debug, Clone, PartialEq)]
pub struct AlphaTest {
    parts: AlphaTestParts,
    threshold: f32,
}

/// What exists of a small neighbourhood.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Presence {
    /// All of it.
    Full,
    /// Nothing.
    Empty,
    /// Parts of it, or it is not known.
    Mixed,
}

impl AlphaTest {
    /// The test that these parts describe.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for a coordinate that is not finite, or a cutoff or factor that is not a finite number of at
    /// least 0.
    pub fn new(parts: AlphaTestParts) -> Result<Self> {
        for (name, value) in [("alpha.cutoff", parts.cutoff), ("alpha.factor", parts.factor)] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(Error::argument(name, "a finite number of at least 0", value, "1 is fully opaque"));
            }
        }
        if let Some(row) = parts.uv.iter().position(|uv| !uv.iter().all(|x| x.is_finite())) {
            let fix = "give every vertex texture coordinates";
            return Err(Error::argument(
                format!("alpha.uv[{row}]"),
                "two finite numbers",
                format!("{:?}", parts.uv[row]),
                fix,
            ));
        }
        // Rounded once, so that all who compare compare with the same number: texels that equal it exactly exist everywhere.
        let threshold = if parts.cutoff == 0.0 { 0.0 } else { OPAQUE * parts.cutoff / parts.factor };
        let threshold = threshold.min(f64::from(f32::MAX)) as f32;
        Ok(Self { parts, threshold })
    }
    /// What it is made of.
    pub fn parts(&self) -> &AlphaTestParts {
        &self.parts
    }
    /// Least level of the texture, 0 to 255, that exists.
    pub fn threshold(&self) -> f32 {
        self.threshold
    }
    /// The same test of other vertices: of each the row that it had.
    pub(super) fn of_rows(self, rows: &[u32]) -> Self {
        let uv = rows.iter().map(|&row| self.parts.uv[row as usize]).collect();
        Self { parts: AlphaTestParts { uv, ..self.parts }, ..self }
    }
    /// Texture coordinates of a triangle's corners.
    pub fn corners(&self, triangle: [u32; 3]) -> [DVec2; 3] {
        triangle.map(|i| {
            let [u, v] = self.parts.uv[i as usize];
            DVec2::new(u.into(), v.into())
        })
    }
    /// Whether a point with these texture coordinates exists.
    pub fn exists(&self, uv: DVec2) -> bool {
        self.level(uv) >= f64::from(self.threshold)
    }
    /// Level of the texture, 0 to 255.
    pub fn level(&self, uv: DVec2) -> f64 {
        let Some(texture) = &self.parts.texture else { return OPAQUE };
        let ([wrap_u, wrap_v], [width, height]) = (self.parts.wrap, texture.size);
        let ((i, across), (j, down)) = (wrap_u.between(uv.x, width), wrap_v.between(uv.y, height));
        let (left, right) = (wrap_u.texel(i, width), wrap_u.texel(i + 1, width));
        let row = |j: i64| {
            let y = wrap_v.texel(j, height);
            mixed(texture.at(left, y), texture.at(right, y), across)
        };
        mixed(row(j), row(j + 1), down)
    }
    /// What exists of the rectangle of texture coordinates within `reach` of a point, along u and v.
    pub fn presence(&self, uv: DVec2, reach: DVec2) -> Presence {
        let threshold = f64::from(self.threshold);
        let Some(texture) = &self.parts.texture else {
            return if OPAQUE >= threshold { Presence::Full } else { Presence::Empty };
        };
        // Of a cell of four centres the level lies between the least and the greatest of them.
        let cells = |wrap: Wrap, u: f64, reach: f64, count: u32| {
            let size = f64::from(count);
            let place = wrap.folded(u) * size - 0.5;
            // Beyond a fold the texels are those before it again: the cells on this side are enough of them.
            [(place - reach * size).floor(), (place + reach * size).floor() + 1.0]
        };
        let [wrap_u, wrap_v] = self.parts.wrap;
        let [width, height] = texture.size;
        let (across, down) = (cells(wrap_u, uv.x, reach.x, width), cells(wrap_v, uv.y, reach.y, height));
        let texels = (across[1] - across[0] + 1.0) * (down[1] - down[0] + 1.0);
        // Not a number where the reach is none.
        if !(texels <= MOST_TEXELS as f64) {
            return Presence::Mixed;
        }
        let [across, down] = [across, down].map(|[first, last]| first as i64..=last as i64);
        let (mut least, mut greatest) = (f64::INFINITY, f64::NEG_INFINITY);
        for y in down.map(|j| wrap_v.texel(j, height)) {
            for x in across.clone().map(|i| wrap_u.texel(i, width)) {
                let level = texture.at(x, y);
                (least, greatest) = (least.min(level), greatest.max(level));
            }
        }
        if least >= threshold {
            return Presence::Full;
        }
        if greatest < threshold {
            return Presence::Empty;
        }
        // The level changes by no more than this along u, and along v, for each texel.
        let rise = greatest - least;
        let most = rise * (reach.x * f64::from(width) + reach.y * f64::from(height)) + LEVEL_ERROR;
        let above = self.level(uv) - threshold;
        if above > most {
            Presence::Full
        } else if above < -most {
            Presence::Empty
        } else {
            Presence::Mixed
        }
    }
    /// Adds all that pictures depend on.
    pub(super) fn add_to(&self, digest: &mut Digest) {
        let AlphaTestParts { texture, uv, cutoff, wrap, factor } = &self.parts;
        digest.text("alpha test");
        digest.list(uv.as_flattened());
        digest.list(&[*cutoff, *factor]);
        digest.list(&wrap.map(|wrap| wrap as u32));
        let (size, texels) = texture.as_ref().map_or(([0; 2], &[][..]), |t| (t.size, &t.texels));
        digest.list(&size);
        digest.list(texels);
    }
    /// Bytes held on the heap, and by the texture, which others may share.
    pub fn memory(&self) -> usize {
        let texture = self.parts.texture.as_ref().map_or(0, |t| t.texels.capacity());
        size_of::<Self>() + self.parts.uv.capacity() * size_of::<[f32; 2]>() + texture
    }
}

/// Bound on the rounding of a level in single precision: three weighted sums of numbers up to 255, 2^-24 each, on both sides.
const LEVEL_ERROR: f64 = 6.0 * OPAQUE * (f32::EPSILON as f64 / 2.0);

/// What lies a part of the way from one level to another; exactly that level where both are equal.
fn mixed(from: f64, to: f64, part: f64) -> f64 {
    from + (to - from) * part
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test(size: [u32; 2], texels: &[u8], wrap: Wrap, cutoff: f64) -> AlphaTest {
        let texture = Some(Arc::new(AlphaTexture::new(size, texels.to_vec()).unwrap()));
        AlphaTest::new(AlphaTestParts { texture, uv: vec![], cutoff, wrap: [wrap; 2], factor: 1.0 }).unwrap()
    }

    #[test]
    fn centres_have_their_texels_and_between_them_levels_are_weighted() {
        let test = test([3, 2], &[0, 30, 60, 90, 120, 150], Wrap::Clamp, 0.5);
        let level = |x: f64, y: f64| test.level(DVec2::new(x / 3.0, y / 2.0));
        for (i, j) in [(0, 0), (1, 0), (2, 1)] {
            let expected = f64::from(90 * j + 30 * i);
            assert!((level(f64::from(i) + 0.5, f64::from(j) + 0.5) - expected).abs() < 1e-12);
        }
        assert!((level(1.0, 1.0) - 60.0).abs() < 1e-12);
        assert_eq!((level(0.0, 0.0), level(-7.0, 9.0), level(99.0, -1.0)), (0.0, 90.0, 60.0));
    }

    #[test]
    fn images_repeat_or_are_mirrored() {
        let texels = [10, 200];
        let level = |wrap, u: f64| test([2, 1], &texels, wrap, 0.5).level(DVec2::new(u, 0.3));
        for k in [-1e6, -3.0, 0.0, 7.0, 4e9] {
            assert_eq!((level(Wrap::Repeat, k + 0.25), level(Wrap::Repeat, k + 0.75)), (10.0, 200.0));
            // Between the last texel and the first of the next image.
            assert_eq!(level(Wrap::Repeat, k), 105.0);
            let (first, second) = if k % 2.0 == 0.0 { (10.0, 200.0) } else { (200.0, 10.0) };
            assert_eq!((level(Wrap::Mirror, k + 0.25), level(Wrap::Mirror, k + 0.75)), (first, second));
            assert_eq!(level(Wrap::Mirror, k), first);
        }
        assert!(level(Wrap::Repeat, f64::from(f32::MAX)).is_finite() && level(Wrap::Repeat, -1e-300).is_finite());
    }

    #[test]
    fn a_texel_at_the_cutoff_exists() {
        for level in 1..=255u8 {
            let at = test([1, 1], &[level], Wrap::Repeat, f64::from(level) / 255.0);
            let above = test([1, 1], &[level], Wrap::Repeat, f64::from(level) / 255.0 * (1.0 + 1e-6));
            let (uv, reach) = (DVec2::new(0.37, -4.1), DVec2::splat(0.1));
            assert!(at.exists(uv) && !above.exists(uv), "{level}");
            assert_eq!((at.presence(uv, reach), above.presence(uv, reach)), (Presence::Full, Presence::Empty));
        }
    }

    #[test]
    fn a_neighbourhood_is_full_or_empty_only_where_all_of_it_is() {
        let texels: Vec<u8> = (0..49u32).map(|k| (k * k * 37 % 256) as u8).collect();
        for wrap in Wrap::ALL {
            let test = test([7, 7], &texels, wrap, 0.45);
            let mut counts = [0; 3];
            for k in 0..4000 {
                let at = DVec2::new(f64::from(k) * 0.0137 - 20.0, f64::from(k) * 0.0071 - 9.0);
                let reach = DVec2::new(0.02, 0.01) * f64::from(k % 5);
                let presence = test.presence(at, reach);
                counts[presence as usize] += 1;
                let mut within = (-4..=4).flat_map(|x| (-4..=4).map(move |y| DVec2::new(x.into(), y.into()) * 0.25));
                match presence {
                    Presence::Full => assert!(within.all(|d| test.exists(at + d * reach))),
                    Presence::Empty => assert!(within.all(|d| !test.exists(at + d * reach))),
                    Presence::Mixed => {}
                }
            }
            assert!(counts.iter().all(|&n| n > 50), "{counts:?}");
        }
    }

    #[test]
    fn what_no_test_is_made_of_is_refused() {
        let parts = AlphaTestParts { texture: None, uv: vec![], cutoff: 0.5, wrap: [Wrap::Repeat; 2], factor: 1.0 };
        let refused = |change: fn(&mut AlphaTestParts)| {
            let mut changed = parts.clone();
            change(&mut changed);
            matches!(AlphaTest::new(changed), Err(Error::InvalidArgument { .. }))
        };
        assert!(!refused(|_| {}));
        assert!(refused(|p| p.cutoff = f64::NAN) && refused(|p| p.cutoff = -0.1));
        assert!(refused(|p| p.factor = f64::INFINITY) && refused(|p| p.uv = vec![[0.0, f32::NAN]]));
        assert!(AlphaTexture::new([0, 3], vec![]).is_err() && AlphaTexture::new([2, 2], vec![1; 3]).is_err());
        let none = AlphaTest::new(AlphaTestParts { factor: 0.0, ..parts.clone() }).unwrap();
        let all = AlphaTest::new(AlphaTestParts { factor: 0.0, cutoff: 0.0, ..parts.clone() }).unwrap();
        assert!(!none.exists(DVec2::ZERO) && all.exists(DVec2::ZERO));
    }
}
