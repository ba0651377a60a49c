//! A filter at one receiver, in texels: the texels that it compares, with their weights.

use glam::{DMat2, DVec2};

use super::value::WIDEST_TEXELS;

/// Texels along an axis that the widest kernel touches, and one more for rounding.
const MOST_TEXELS: usize = WIDEST_TEXELS as usize + 2;

/// What is averaged about one place of a map. Lengths in texels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kernel {
    /// The texel at the place.
    Nearest,
    /// The four nearest centres.
    Bilinear,
    /// A box with these sides.
    Box(DVec2),
    /// Triangles of these widths.
    Tent(DVec2),
    /// The unit disc under this map.
    Disc(DMat2),
}

/// A texel that is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tap {
    /// Its column and row; it may lie beyond the map's edge, where lookups take the nearest texel.
    pub texel: [i64; 2],
    /// Its weight; those of a kernel sum to 1.
    pub weight: f64,
}

impl Kernel {
    /// How far from the place the centre of a texel that is compared can lie along each axis, texels.
    pub fn reach(&self) -> DVec2 {
        match self {
            Self::Nearest => DVec2::splat(0.5),
            Self::Bilinear => DVec2::ONE,
            Self::Box(size) | Self::Tent(size) => 0.5 * *size + 0.5,
            Self::Disc(axes) => DVec2::new(axes.row(0).length(), axes.row(1).length()) + 0.5,
        }
    }

    /// The average of a function of texels (column, row) about a place; `disc` has the points of the unit disc.
    pub fn average(&self, disc: &[DVec2], place: DVec2, of: impl Fn(i64, i64) -> f64) -> f64 {
        // Casts saturate.
        match self {
            Self::Nearest => of(place.x.floor() as i64, place.y.floor() as i64),
            Self::Bilinear => bilinear(place, of),
            Self::Box(size) => separable(&Weights::of_box(place.x, size.x), &Weights::of_box(place.y, size.y), of),
            Self::Tent(size) => separable(&Weights::of_tent(place.x, size.x), &Weights::of_tent(place.y, size.y), of),
            Self::Disc(axes) => {
                let at = |q: &DVec2| (place + *axes * *q).floor();
                disc.iter().map(at).map(|at| of(at.x as i64, at.y as i64)).sum::<f64>() / disc.len() as f64
            }
        }
    }

    /// The texel that a place falls into.
    pub fn nearest(place: DVec2) -> [i64; 2] {
        let at = place.floor();
        [at.x as i64, at.y as i64]
    }

    /// The texels about a place with their weights, rows from the top; those of a disc as its points come, each texel once.
    pub fn taps(&self, disc: &[DVec2], place: DVec2) -> Vec<Tap> {
        let grid = |x: Weights, y: Weights| {
            let row = |(j, b): (i64, f64)| x.each().map(move |(i, a)| Tap { texel: [i, j], weight: a * b });
            y.each().flat_map(row).collect()
        };
        match self {
            Self::Nearest => vec![Tap { texel: Self::nearest(place), weight: 1.0 }],
            Self::Bilinear => grid(Weights::of_two(place.x), Weights::of_two(place.y)),
            Self::Box(size) => grid(Weights::of_box(place.x, size.x), Weights::of_box(place.y, size.y)),
            Self::Tent(size) => grid(Weights::of_tent(place.x, size.x), Weights::of_tent(place.y, size.y)),
            Self::Disc(axes) => {
                let mut taps: Vec<Tap> = Vec::with_capacity(disc.len());
                let weight = 1.0 / disc.len() as f64;
                for q in disc {
                    let at = (place + *axes * *q).floor();
                    let texel = [at.x as i64, at.y as i64];
                    match taps.iter_mut().find(|tap| tap.texel == texel) {
                        Some(tap) => tap.weight += weight,
                        None => taps.push(Tap { texel, weight }),
                    }
                }
                taps
            }
        }
    }
}

/// The average of a function of texels (column, row) with weights between the four texel centres around a place.
#[inline(always)]
pub(crate) fn bilinear(place: DVec2, of: impl Fn(i64, i64) -> f64) -> f64 {
    let corner = (place - 0.5).floor();
    let f = place - 0.5 - corner;
    // Casts saturate.
    let (i, j) = (corner.x as i64, corner.y as i64);
    between(f, [of(i, j), of(i + 1, j), of(i, j + 1), of(i + 1, j + 1)])
}

/// The average of four corners, rows first, with the weights of a place between them.
#[inline(always)]
pub(crate) fn between(f: DVec2, [a, b, c, d]: [f64; 4]) -> f64 {
    let top = (1.0 - f.x) * a + f.x * b;
    let bottom = (1.0 - f.x) * c + f.x * d;
    (1.0 - f.y) * top + f.y * bottom
}

/// The average of a function of texels with weights that are products, row after row.
fn separable(x: &Weights, y: &Weights, of: impl Fn(i64, i64) -> f64) -> f64 {
    y.each().map(|(j, b)| b * x.each().map(|(i, a)| a * of(i, j)).sum::<f64>()).sum()
}

/// The integral of a box up to a place from its middle (14.3).
#[inline(always)]
pub(crate) fn integral_of_box(t: f64, width: f64) -> f64 {
    (t / width).clamp(-0.5, 0.5)
}

/// The integral of a triangle up to a place from its middle (14.4).
#[inline(always)]
pub(crate) fn integral_of_tent(t: f64, width: f64) -> f64 {
    let u = (2.0 * t / width).clamp(-1.0, 1.0);
    u - 0.5 * u * u.abs()
}

/// The first texel that a kernel about a place touches.
#[inline(always)]
pub(crate) fn first_texel(place: f64, width: f64) -> f64 {
    (place - 0.5 * width).floor()
}

/// How many texels a kernel touches at most, from the first on.
pub(crate) fn texels_across(width: f64) -> usize {
    (width.ceil() as usize + 1).min(MOST_TEXELS)
}

/// Weights of neighbouring texels along one axis.
#[derive(Debug, Clone, Copy)]
struct Weights {
    first: i64,
    count: usize,
    values: [f64; MOST_TEXELS],
}

impl Weights {
    /// Of bilinear interpolation.
    fn of_two(place: f64) -> Self {
        let first = (place - 0.5).floor();
        let f = place - 0.5 - first;
        let mut values = [0.0; MOST_TEXELS];
        (values[0], values[1]) = (1.0 - f, f);
        Self { first: first as i64, count: 2, values }
    }
    /// Of a box: overlap over width (14.3).
    #[inline(always)]
    fn of_box(place: f64, width: f64) -> Self {
        Self::over(place, width, |t| integral_of_box(t, width))
    }
    /// Of a triangle (14.4).
    #[inline(always)]
    fn of_tent(place: f64, width: f64) -> Self {
        Self::over(place, width, |t| integral_of_tent(t, width))
    }
    /// Of a kernel with an integral, about its middle: each texel has what the integral gains over it.
    #[inline(always)]
    fn over(place: f64, width: f64, integral: impl Fn(f64) -> f64) -> Self {
        let (first, count) = (first_texel(place, width), texels_across(width));
        let mut values = [0.0; MOST_TEXELS];
        let mut before = integral(first - place);
        for (i, value) in values[..count].iter_mut().enumerate() {
            let after = integral(first + (i + 1) as f64 - place);
            *value = after - before;
            before = after;
        }
        Self { first: first as i64, count, values }
    }
    #[inline(always)]
    fn each(&self) -> impl Iterator<Item = (i64, f64)> + '_ {
        (self.first..).zip(self.values[..self.count].iter().copied())
    }
}
