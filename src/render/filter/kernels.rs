//! A filter ready for receivers: its disc, and for kernels in pixels the picture.

use std::sync::Arc;

use glam::{DMat2, DVec2, DVec3};

use super::disc::disc;
use super::kernel::Kernel;
use super::value::{Extent, Filter, Unit, WIDEST_TEXELS};
use crate::aliasing::texel::Eye;
use crate::error::{Error, Result};

/// What makes the kernels of a filter.
#[derive(Debug, Clone)]
pub struct Kernels {
    filter: Filter,
    /// The kernel in texels with its reach; for one in pixels those where a pixel is a texel.
    even: (Kernel, DVec2),
    /// The picture whose pixels a kernel is measured in; nothing for one in texels.
    eye: Option<Eye>,
    disc: Arc<[DVec2]>,
}

impl Kernels {
    /// The kernels of a filter; of one in pixels those of a picture.
    ///
    /// # Errors
    /// As [`Filter::checked`], and [`Error::InvalidArgument`] for a filter in pixels without a picture.
    pub fn new(filter: Filter, eye: Option<Eye>) -> Result<Self> {
        let disc = match filter.checked()? {
            Filter::Poisson { count, seed, .. } => disc(count, seed).into(),
            _ => Arc::default(),
        };
        let eye = eye.filter(|_| filter.is_in_pixels());
        if filter.is_in_pixels() && eye.is_none() {
            let fix = "give the kernel in texels, or the picture's camera";
            return Err(Error::argument("filter", "a kernel in texels where there is no picture", filter, fix));
        }
        let even = scaled(filter, DMat2::IDENTITY);
        Ok(Self { filter, even: (even, even.reach()), eye, disc })
    }
    /// The points of its disc in the unit disc; none of other kernels.
    pub fn disc(&self) -> &[DVec2] {
        &self.disc
    }
    /// The kernel where it is measured in texels; nothing for one in pixels.
    pub fn fixed(&self) -> Option<Kernel> {
        self.eye.is_none().then_some(self.even.0)
    }
    /// The kernel and its reach where its unit is a texel.
    #[inline(always)]
    pub(crate) fn even(&self) -> (Kernel, DVec2) {
        self.even
    }
    /// The kernel at a receiver `p` with a unit normal, in a map whose texel coordinates have these gradients there, and its reach.
    #[inline(always)]
    pub fn at(&self, p: DVec3, normal: DVec3, gradients: [DVec3; 2]) -> (Kernel, DVec2) {
        match &self.eye {
            None => self.even,
            Some(eye) => self.in_pixels(eye, p, normal, gradients),
        }
    }
    #[inline(never)]
    fn in_pixels(&self, eye: &Eye, p: DVec3, normal: DVec3, [x, y]: [DVec3; 2]) -> (Kernel, DVec2) {
        let [right, down] = eye.pixel_on_plane(p, normal);
        let image = DMat2::from_cols_array(&[x.dot(right), y.dot(right), x.dot(down), y.dot(down)]);
        let kernel = scaled(self.filter, image);
        (kernel, kernel.reach())
    }
}

/// The kernel where a step of its unit to the right and one down are these steps of texels (14.5).
fn scaled(filter: Filter, image: DMat2) -> Kernel {
    let widths = |Extent { length, unit }: Extent| match unit {
        Unit::Texels => DVec2::splat(length),
        Unit::Pixels => {
            let width = |row: DVec2| held(length * row.length(), 1.0, WIDEST_TEXELS);
            DVec2::new(width(image.row(0)), width(image.row(1)))
        }
    };
    match filter {
        Filter::Nearest => Kernel::Nearest,
        Filter::Bilinear => Kernel::Bilinear,
        Filter::Pcf { size } => match widths(size) {
            DVec2::ONE => Kernel::Bilinear,
            size => Kernel::Box(size),
        },
        Filter::Tent { size } => Kernel::Tent(widths(size)),
        Filter::Poisson { radius: Extent { length, unit: Unit::Texels }, .. } => {
            Kernel::Disc(DMat2::from_diagonal(DVec2::splat(length)))
        }
        Filter::Poisson { radius: Extent { length, .. }, .. } => {
            let x = held_row(length * image.row(0), DVec2::X);
            let y = held_row(length * image.row(1), DVec2::Y);
            Kernel::Disc(DMat2::from_cols(x, y).transpose())
        }
    }
}

/// A width within limits; the largest for a NaN, of a plane seen edge on.
fn held(width: f64, least: f64, most: f64) -> f64 {
    if width <= most { width.max(least) } else { most }
}

/// Half the extent of a disc along an axis of the map, as a vector over those of the picture, with a length within limits; along
/// the axis where it has no direction.
fn held_row(row: DVec2, axis: DVec2) -> DVec2 {
    let length = row.length();
    let held = held(length, 0.5, 0.5 * WIDEST_TEXELS);
    if length > 0.0 && length.is_finite() { row * (held / length) } else { axis * held }
}
