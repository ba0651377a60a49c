//! Post-warps as kernels know them: of a logarithm, with that of w, which no processor finds for many receivers at once.

use glam::{DVec3, DVec4};

use crate::aliasing::receivers::{RUN, Receivers};
use crate::parameterization::Rectilinear;

/// A post-warp at a receiver.
#[derive(Debug, Clone, Copy)]
pub(super) enum Warped<'a> {
    None,
    /// [`Log`](crate::parameterization::PostWarp::Log), with the logarithm of w there.
    Log {
        scale: f64,
        offset: f64,
        ln_w: f64,
    },
    Rectilinear(&'a Rectilinear),
}

impl Warped<'_> {
    /// NDC after it, of NDC before it: [`PostWarp::apply`](crate::parameterization::PostWarp::apply).
    #[inline(always)]
    pub(super) fn apply(self, ndc: DVec3) -> DVec3 {
        match self {
            Self::None => ndc,
            Self::Log { scale, offset, ln_w } => DVec3::new(ndc.x, scale * ln_w + offset, ndc.z),
            Self::Rectilinear(warp) => warp.after(ndc.truncate()).extend(ndc.z),
        }
    }
}

/// The logarithm of w at a receiver, by the row that gives w.
pub(super) fn ln_w(row_w: DVec4, p: DVec3) -> f64 {
    row_w.dot(p.extend(1.0)).ln()
}

/// A post-warp at the receivers of a run, of a kind that is known to kernels.
pub(super) trait WarpedRun {
    /// That at a receiver.
    fn at(&self, i: usize) -> Warped<'_>;
}

/// No post-warp.
pub(super) struct Even;

/// A logarithm.
pub(super) struct Logarithm {
    scale: f64,
    offset: f64,
    ln_w: [f64; RUN],
}

impl Logarithm {
    /// That of a map at the receivers of a run, by the row that gives w.
    pub(super) fn new(row_w: DVec4, scale: f64, offset: f64, run: &Receivers) -> Self {
        let mut ln_w = [0.0; RUN];
        for (i, ln_w) in ln_w.iter_mut().enumerate() {
            *ln_w = self::ln_w(row_w, run.point(i));
        }
        Self { scale, offset, ln_w }
    }
}

impl WarpedRun for Even {
    #[inline(always)]
    fn at(&self, _i: usize) -> Warped<'_> {
        Warped::None
    }
}

impl WarpedRun for Logarithm {
    #[inline(always)]
    fn at(&self, i: usize) -> Warped<'_> {
        Warped::Log { scale: self.scale, offset: self.offset, ln_w: self.ln_w[i] }
    }
}
