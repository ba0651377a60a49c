//! The texel of the shadow map at every pixel of an image: [`texel_in_image`] for all receivers that face the light.
//!
//! Pixels are taken in runs of [`RUN`]; what the kernel finds of them is written out. Where there are several maps each run
//! asks them in the order of [`Parameterization::choose`], and skips those that none of its pixels may ask.

use std::mem::MaybeUninit;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::receivers::{RUN, Receivers, Shown};
use super::texel::{Eye, Texel, TexelMap, largest_singular_value, texel_in_image, warped_texel};
use crate::error::{Error, Result};
use crate::image::{Footprint, Surfaces};
use crate::memory::{copied, unwritten, written};
use crate::parameterization::{Held, Parameterization, PostWarp, Rectilinear};
use crate::progress::Progress;
use crate::scene::{Camera, Light, unit};
use crate::simd::dispatch;

/// A pixel that no map has been found for yet; for the codes of the others see [`Footprint`].
const PENDING: i16 = i16::MIN;

/// What a texel of `resolution` texels (width, height) looks like at each pixel of what a camera sees.
///
/// Measured are surfaces that face the light, on the side that the eye sees, within its cone and range, and that a map
/// holds: those whose shadow is looked up.
///
/// # Errors
/// [`Error::InvalidArgument`] for no map, a matrix that is not finite, or an empty image; [`Error::Interrupted`].
pub fn footprint(
    surfaces: &Surfaces,
    camera: &Camera,
    light: &Light,
    p: &Parameterization,
    resolution: [u32; 2],
    progress: &Progress,
) -> Result<Footprint> {
    let pixels = surfaces.triangle.len();
    let width = surfaces.size[0] as usize;
    let rows = Rows::new(surfaces, camera, light, p, resolution)?;
    let mut planes = unwritten::<f32>(Footprint::PLANES * pixels)?;
    let mut map = unwritten::<i16>(pixels)?;
    // Row by row, a slice of each plane.
    let mut out: Vec<RowOut> = map.chunks_mut(width).map(|map| RowOut { planes: Default::default(), map }).collect();
    for (k, plane) in planes.chunks_mut(pixels).enumerate() {
        out.iter_mut().zip(plane.chunks_mut(width)).for_each(|(out, row)| out.planes[k] = row);
    }
    progress.set_total(out.len() as u64);
    out.par_iter_mut().enumerate().try_for_each(|(y, out)| {
        progress.check()?;
        rows.row(y * width, out);
        progress.advance(1);
        Ok::<_, Error>(())
    })?;
    // SAFETY: every row has been written, or the error has been returned.
    unsafe { Ok(Footprint { size: surfaces.size, planes: written(planes), map: written(map) }) }
}

/// The texels at points (world) with normals, in f64, and the index of each one's map or why it has none.
///
/// Of a point behind a perspective eye or a normal without length [`Footprint::NOTHING`].
///
/// # Errors
/// [`Error::InvalidArgument`] for no map or a matrix that is not finite.
pub fn footprint_at(
    points: &[[f64; 3]],
    normals: &[[f64; 3]],
    camera: &Camera,
    light: &Light,
    p: &Parameterization,
    resolution: [u32; 2],
    size: [u32; 2],
) -> Result<Vec<(i16, Texel)>> {
    if points.len() != normals.len() {
        let fix = "give each point its normal";
        return Err(Error::argument("normals", format!("{} of them", points.len()), normals.len(), fix));
    }
    check_sides("size", size)?;
    check_sides("resolution", resolution)?;
    // Relative to the eye, where the digits are needed.
    let origin = camera.eye();
    let local = local_maps(p, origin)?;
    let maps: Vec<TexelMap> = local.partitions.iter().map(|m| TexelMap::new(m, resolution)).collect();
    let eye = Eye::new(camera, origin, size);
    let at = |(&p_world, &n): (&[f64; 3], &[f64; 3])| {
        let (p_world, n) = (DVec3::from_array(p_world), DVec3::from_array(n));
        let (p_local, depth) = (p_world - origin, camera.depth_of(p_world));
        let Some(n) = unit(n).filter(|n| n.is_finite() && camera.w_at(depth) > 0.0) else {
            return (Footprint::NOTHING, Texel::default());
        };
        if !light.illuminates(p_world, n) {
            return (Footprint::AVERTED, Texel::default());
        }
        match local.choose(p_local, depth) {
            Some(k) => match warped_texel(&maps[k], &local.partitions[k].post_warp, &eye, p_local, n) {
                texel if texel.is_finite() => (k as i16, texel),
                _ => (Footprint::NO_MAP, Texel::default()),
            },
            None => (Footprint::NO_MAP, Texel::default()),
        }
    };
    Ok(points.par_iter().zip(normals).map(at).collect())
}

/// The maps for points relative to an origin; at least one, and no more than an image can number.
pub(super) fn local_maps(p: &Parameterization, origin: DVec3) -> Result<Parameterization> {
    if p.partitions.is_empty() || p.partitions.len() > i16::MAX as usize {
        let expected = format!("1 to {} maps", i16::MAX);
        return Err(Error::argument("parameterization", expected, p.partitions.len(), "let a technique make it"));
    }
    p.relative_to(origin)
}

/// A map has texels, an image pixels.
fn check_sides(name: &'static str, [width, height]: [u32; 2]) -> Result<()> {
    if width > 0 && height > 0 {
        return Ok(());
    }
    Err(Error::argument(name, "sides of at least 1", format!("{width} x {height}"), "choose another size"))
}

/// An image has pixels, and each of them its records.
pub(super) fn check_surfaces(surfaces: &Surfaces) -> Result<()> {
    let pixels = surfaces.size[0] as usize * surfaces.size[1] as usize;
    if pixels == 0 {
        let got = format!("{} x {}", surfaces.size[0], surfaces.size[1]);
        return Err(Error::argument("gbuffer", "at least one pixel", got, "render an image first"));
    }
    for (name, len) in [
        ("gbuffer.position", surfaces.position.len()),
        ("gbuffer.normal", surfaces.normal.len()),
        ("gbuffer.triangle", surfaces.triangle.len()),
        ("gbuffer.instance", surfaces.instance.len()),
    ] {
        if len != pixels {
            return Err(Error::argument(name, format!("{pixels} records"), len, "take all arrays of one G-buffer"));
        }
    }
    Ok(())
}

/// One row of the result.
struct RowOut<'a> {
    planes: [&'a mut [MaybeUninit<f32>]; Footprint::PLANES],
    map: &'a mut [MaybeUninit<i16>],
}

/// What all rows share; points relative to the origin of the surfaces.
struct Rows<'a> {
    surfaces: &'a Surfaces<'a>,
    camera: &'a Camera,
    light: &'a Light,
    eye: Eye,
    maps: Vec<TexelMap>,
    local: Parameterization,
}

/// What the kernel finds in a run.
struct Found {
    planes: [[f32; RUN]; Footprint::PLANES],
    ndc: [[f64; RUN]; 3],
    w: [f64; RUN],
    /// 0 where all planes are finite.
    sound: [f32; RUN],
    /// 0 where the projective part has the point beside no map and before its projection centre.
    outside: [f32; RUN],
}

impl Found {
    const NONE: Self = Self {
        planes: [[f32::NAN; RUN]; Footprint::PLANES],
        ndc: [[0.0; RUN]; 3],
        w: [0.0; RUN],
        sound: [0.0; RUN],
        outside: [1.0; RUN],
    };

    /// Takes over what another found of a pixel.
    fn take(&mut self, from: &Self, i: usize) {
        for (to, from) in self.planes.iter_mut().zip(&from.planes) {
            to[i] = from[i];
        }
        self.sound[i] = from.sound[i];
    }

    /// Whether a texel of the map has a size there.
    fn is_finite(&self, i: usize) -> bool {
        self.sound[i] == 0.0
    }

    fn forget(&mut self, i: usize) {
        self.planes.iter_mut().for_each(|plane| plane[i] = f32::NAN);
    }

    /// Divides the texels' sides by the slopes of a warp: [`Texel::stretched`] for all.
    fn stretch(&mut self, warp: &Rectilinear) {
        for i in 0..RUN {
            let [x, y] = warp.slopes(DVec2::new(self.ndc[0][i], self.ndc[1][i])).to_array();
            let mut sides = [0.0; 4];
            for (k, by) in [x, y, x, y].into_iter().enumerate() {
                sides[k] = f64::from(self.planes[k][i]) / by;
                self.planes[k][i] = sides[k] as f32;
            }
            self.planes[4][i] = largest_singular_value(sides) as f32;
            for (k, by) in [(5, x * y), (6, x), (7, y)] {
                self.planes[k][i] = (f64::from(self.planes[k][i]) / by) as f32;
            }
            self.sound[i] = self.planes.iter().map(|plane| plane[i] * 0.0).sum();
        }
    }
}

dispatch! {
    /// The texels of one map at all points of a run.
    fn texels(map: &TexelMap, eye: &Eye, run: &Receivers, found: &mut Found) = texels_body
}

#[inline(always)]
fn texels_body(map: &TexelMap, eye: &Eye, run: &Receivers, found: &mut Found) {
    let (map, eye) = (*map, *eye);
    for i in 0..RUN {
        let t = texel_in_image(&map, &eye, run.point(i), run.normal(i));
        let [a, b, c, d] = t.jacobian;
        let [along_t, along_s] = t.perspective_ts;
        let values = [a, b, c, d, t.major, t.perspective, along_t, along_s, t.projection, t.depth];
        let mut sum = 0.0;
        for (plane, value) in found.planes.iter_mut().zip(values) {
            plane[i] = value as f32;
            // Zero of what is finite, NaN of what is not.
            sum += plane[i] * 0.0;
        }
        found.sound[i] = sum;
        let beside = t.ndc[0].abs().max(t.ndc[1].abs());
        // Written so that a NaN is outside.
        found.outside[i] = if (t.w > 0.0) & (beside <= 1.0) { 0.0 } else { 1.0 };
        for k in 0..3 {
            found.ndc[k][i] = t.ndc[k];
        }
        found.w[i] = t.w;
    }
}

impl<'a> Rows<'a> {
    fn new(
        surfaces: &'a Surfaces<'a>,
        camera: &'a Camera,
        light: &'a Light,
        p: &Parameterization,
        resolution: [u32; 2],
    ) -> Result<Self> {
        check_surfaces(surfaces)?;
        check_sides("resolution", resolution)?;
        let local = local_maps(p, surfaces.origin)?;
        let maps = local.partitions.iter().map(|m| TexelMap::new(m, resolution)).collect();
        Ok(Self { surfaces, camera, light, eye: Eye::new(camera, surfaces.origin, surfaces.size), maps, local })
    }

    /// Writes all of the row that begins at a pixel.
    fn row(&self, first: usize, out: &mut RowOut) {
        let width = out.map.len();
        let (mut found, mut of_map) = (Found::NONE, Found::NONE);
        // What shows nothing is a point like any other to the kernel, and forgotten afterwards.
        let mut run = Receivers::NONE;
        for x in (0..width).step_by(RUN) {
            let count = RUN.min(width - x);
            run.read(self.surfaces, first + x, count);
            let mut state = run.shown(self.surfaces, self.light, first + x, count).map(|shown| match shown {
                Shown::Nothing => Footprint::NOTHING,
                Shown::Averted => Footprint::AVERTED,
                Shown::Facing => PENDING,
            });
            if self.maps.len() == 1 && state.contains(&PENDING) {
                self.find(&run, &mut state, &mut found);
            } else {
                self.find_among(&run, &mut state, &mut found, &mut of_map);
            }
            let pixels = x..x + count;
            for (to, from) in out.planes.iter_mut().zip(&found.planes) {
                copied(&mut to[pixels.clone()], &from[..count]);
            }
            copied(&mut out.map[pixels], &state[..count]);
        }
    }

    /// The texels of a map at all points of a run.
    fn texels_of(&self, k: usize, run: &Receivers, found: &mut Found) {
        texels(&self.maps[k], &self.eye, run, found);
        if let Some(warp) = self.local.partitions[k].post_warp.rectilinear() {
            found.stretch(warp);
        }
    }

    /// Finds the texels of all pending pixels where there is one map.
    fn find(&self, run: &Receivers, state: &mut [i16; RUN], found: &mut Found) {
        self.texels_of(0, run, found);
        let only = &self.local.partitions[0];
        let is_plain = only.post_warp == PostWarp::None && only.region.functionals().is_empty();
        for (i, state) in state.iter_mut().enumerate() {
            if *state == PENDING {
                let held =
                    if is_plain { found.outside[i] == 0.0 } else { self.holds(0, run, found, i) != Held::Outside };
                let held = held && found.is_finite(i);
                *state = if held { 0 } else { Footprint::NO_MAP };
            }
            if *state < 0 {
                found.forget(i);
            }
        }
    }

    /// Finds map and texel of all pending pixels: the first map that a receiver is within, else the first that it is beyond.
    fn find_among(&self, run: &Receivers, state: &mut [i16; RUN], found: &mut Found, of_map: &mut Found) {
        (0..RUN).for_each(|i| found.forget(i));
        let pending: Vec<usize> = (0..RUN).filter(|&i| state[i] == PENDING).collect();
        let first = |&i: &usize| self.local.first_map(self.camera.depth_of(self.surfaces.origin + run.point(i)));
        let mut open: Vec<(usize, usize)> = pending.iter().map(|i| (*i, first(i))).collect();
        pending.iter().for_each(|&i| state[i] = Footprint::NO_MAP);
        for k in 0..self.maps.len() {
            if open.is_empty() {
                break;
            }
            if open.iter().all(|&(_, first)| first > k) {
                continue;
            }
            self.texels_of(k, run, of_map);
            open.retain(|&(i, first)| {
                let held = if k < first { Held::Outside } else { self.holds(k, run, of_map, i) };
                if held == Held::Within || held == Held::Beyond && state[i] == Footprint::NO_MAP {
                    found.take(of_map, i);
                    state[i] = k as i16;
                }
                held != Held::Within
            });
        }
        for i in pending {
            if state[i] >= 0 && !found.is_finite(i) {
                state[i] = Footprint::NO_MAP;
                found.forget(i);
            }
        }
    }

    /// How a map holds a receiver: as [`crate::Partition::holds`]; not at all where it is singular.
    fn holds(&self, k: usize, run: &Receivers, found: &Found, i: usize) -> Held {
        let partition = &self.local.partitions[k];
        if !partition.region.contains(run.point(i)) {
            return Held::Outside;
        }
        let ndc = DVec3::from_array([0, 1, 2].map(|axis| found.ndc[axis][i]));
        Held::of(partition.post_warp.apply(ndc, found.w[i]), found.w[i])
    }
}
