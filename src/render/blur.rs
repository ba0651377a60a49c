//! Eye-space blur of a shadow mask: binomial steps in the picture that stop at edges of depth and at creases.
//!
//! Source: theory.md 14, (14.1) and (14.2); `[scherzer2005]` blurs the mask in eye space, by a width that depends on depth. What
//! is our own: neighbours count by the distance to each other's plane instead of by the difference of their depths, so that
//! a wall seen at a grazing angle is one surface.

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::image::Surfaces;
use crate::memory::with_room;
use crate::progress::Progress;
use crate::scene::Camera;

/// Most steps: of a standard deviation of 45 pixels.
pub const MAX_STEPS: u32 = 4096;
/// Of positions in single precision: twice the rounding of both.
const ROUNDING: f64 = 2.0 * f32::EPSILON as f64;

/// How the width of a blur depends on depth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BlurStrength {
    /// As wide in the world at every depth, up to all steps near the viewer.
    #[default]
    Depth,
    /// As wide in the picture at every pixel.
    Even,
}

impl BlurStrength {
    /// The names users write.
    pub const NAMES: [(&'static str, Self); 2] = [("depth", Self::Depth), ("even", Self::Even)];
}

/// How a mask is blurred.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BlurSettings {
    /// Steps; each adds half a square pixel of variance along each axis.
    pub steps: u32,
    /// Where all of them are made.
    pub strength: BlurStrength,
    /// Of [`BlurStrength::Depth`]: the depth along the view up to which all steps are made; the nearest surface's for none.
    pub depth: Option<f64>,
}

/// The mask after the blur; NaN stays where it is and where nothing is seen.
///
/// # Errors
/// [`Error::InvalidArgument`] for a mask of another size or with values outside [0, 1], too many steps, and a depth that is not
/// above 0. [`Error::Interrupted`].
pub fn blur(
    mask: &[f32],
    surfaces: &Surfaces,
    camera: &Camera,
    settings: &BlurSettings,
    progress: &Progress,
) -> Result<Vec<f32>> {
    let (width, pixels) = (surfaces.size[0] as usize, surfaces.triangle.len());
    checked(mask, pixels, settings)?;
    let on = |i: usize| !mask[i].is_nan() && surfaces.triangle[i] >= 0;
    let neighbours = Neighbours { surfaces, camera, on: &on, width };
    progress.set_total(u64::from(settings.steps));
    let steps = image(width, pixels, progress, |i| neighbours.ways_off(i))?;
    let steps = steps_at(steps, settings);
    let right = image(width, pixels, progress, |i| match (i + 1) % width {
        0 => 0.0,
        _ => neighbours.weight(i, i + 1),
    })?;
    let below = image(width, pixels, progress, |i| match i + width < pixels {
        true => neighbours.weight(i, i + width),
        false => 0.0,
    })?;
    let mut light = image(width, pixels, progress, |i| if on(i) { mask[i] } else { 0.0 })?;
    let mut other = image(width, pixels, progress, |_| 0.0)?;
    for step in 0..settings.steps {
        for (stride, weights) in [(1, &right), (width, &below)] {
            other.par_chunks_mut(width).enumerate().try_for_each(|(y, row)| {
                progress.check()?;
                for (x, out) in row.iter_mut().enumerate() {
                    *out = stepped(&light, weights, y * width + x, stride, &steps, step);
                }
                Ok::<_, Error>(())
            })?;
            std::mem::swap(&mut light, &mut other);
        }
        progress.advance(1);
    }
    light.iter_mut().enumerate().filter(|(i, _)| !on(*i)).for_each(|(_, light)| *light = f32::NAN);
    Ok(light)
}

/// A pixel after one step along an axis (14.1): `weights` are those between each pixel and the next one along it.
#[inline]
fn stepped(light: &[f32], weights: &[f32], i: usize, stride: usize, steps: &[f32], step: u32) -> f32 {
    let here = light[i];
    // A part of a step adds that part of its variance.
    let share = 0.25 * (steps[i] - step as f32).clamp(0.0, 1.0);
    if share == 0.0 {
        return here;
    }
    let next = light.get(i + stride).map_or(0.0, |&next| weights[i] * (next - here));
    let previous = i.checked_sub(stride).map_or(0.0, |j| weights[j] * (light[j] - here));
    here + share * (next + previous)
}

/// The steps of each pixel from what places across the view are divided by there; 0 where nothing is.
fn steps_at(mut ways_off: Vec<f32>, settings: &BlurSettings) -> Vec<f32> {
    let all = settings.steps as f32;
    let nearest = ways_off.iter().copied().filter(|w| *w > 0.0).fold(f32::INFINITY, f32::min);
    let near = settings.depth.map_or(nearest, |depth| depth as f32);
    for w in &mut ways_off {
        *w = match settings.strength {
            _ if *w == 0.0 => 0.0,
            BlurStrength::Even => all,
            // The variance in the picture falls with the square of the depth (14.2).
            BlurStrength::Depth => all * (near / *w).min(1.0).powi(2),
        };
    }
    ways_off
}

/// An image, row by row.
fn image(width: usize, pixels: usize, progress: &Progress, of: impl Fn(usize) -> f32 + Sync) -> Result<Vec<f32>> {
    let mut made = with_room::<f32>("size", pixels)?;
    made.resize(pixels, 0.0);
    made.par_chunks_mut(width).enumerate().try_for_each(|(y, row)| {
        progress.check()?;
        row.iter_mut().enumerate().for_each(|(x, value)| *value = of(y * width + x));
        Ok::<_, Error>(())
    })?;
    Ok(made)
}

/// What pixels beside each other have in common.
struct Neighbours<'a, F> {
    surfaces: &'a Surfaces<'a>,
    camera: &'a Camera,
    /// Whether a pixel has a surface and a value.
    on: &'a F,
    width: usize,
}

impl<F: Fn(usize) -> bool + Sync> Neighbours<'_, F> {
    /// By what places across the view are divided; 0 where nothing is.
    fn ways_off(&self, i: usize) -> f32 {
        match self.surfaces.receiver(i) {
            Some((p, _)) if (self.on)(i) => {
                let depth = self.camera.depth_of(self.surfaces.origin + p);
                (self.camera.w_at(depth).abs() as f32).max(f32::MIN_POSITIVE)
            }
            _ => 0.0,
        }
    }

    /// 1 for two pixels of one plane, 0 where either lies a pixel or more off the other's plane or they are at right angles.
    fn weight(&self, i: usize, j: usize) -> f32 {
        let (true, true) = ((self.on)(i), (self.on)(j)) else { return 0.0 };
        let (Some((p, n)), Some((q, m))) = (self.surfaces.receiver(i), self.surfaces.receiver(j)) else { return 0.0 };
        let rounding = ROUNDING * (p.length() + q.length());
        let off = (n.dot(q - p).abs().max(m.dot(q - p).abs()) - rounding).max(0.0);
        let height = (self.surfaces.triangle.len() / self.width) as f64;
        let pixel = self.camera.volume().height() / height * f64::from(self.ways_off(i).min(self.ways_off(j)));
        let (near, alike) = ((1.0 - off / pixel).max(0.0), n.dot(m).clamp(0.0, 1.0));
        (near * alike * alike) as f32
    }
}

/// Raises for what cannot be blurred.
fn checked(mask: &[f32], pixels: usize, settings: &BlurSettings) -> Result<()> {
    if mask.len() != pixels {
        let expected = format!("as many pixels as the G-buffer: {pixels}");
        return Err(Error::argument("mask", expected, mask.len(), "render both at one size"));
    }
    if let Some(light) = mask.iter().find(|light| !(light.is_nan() || (0.0..=1.0).contains(*light))) {
        return Err(Error::argument("mask", "values in [0, 1], NaN where nothing is", light, "check the mask"));
    }
    if settings.steps > MAX_STEPS {
        let expected = format!("a whole number from 0 to {MAX_STEPS}");
        return Err(Error::argument("iterations", expected, settings.steps, "8 blur by two pixels"));
    }
    match settings.depth {
        Some(depth) if !(depth > 0.0 && depth.is_finite()) => {
            let fix = "leave it out for the nearest surface's";
            Err(Error::argument("depth", "a finite depth above 0", depth, fix))
        }
        _ => Ok(()),
    }
}
