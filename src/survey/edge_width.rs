//! How wide the texels of maps are across the edges of visible shadows, from samples: what says whether held maps still serve.
//!
//! Source: theory.md (10.7) and (10.8), for maps of any kind; [`techniques::kit::edge_width`](crate::techniques::kit::edge_width)
//! is the same for one homography that is being fitted.

use glam::DVec2;

use super::asked_maps::AskedMaps;
use crate::error::Result;
use crate::focus::Samples;
use crate::parameterization::Parameterization;
use crate::progress::Progress;
use crate::techniques::Holds;
use crate::techniques::kit::{CAP_PX, capped_px};

/// The mean width, capped at [`CAP_PX`], that a texel of maps of `size` texels has across the edges of the samples' shadows,
/// pixels. An edge that no map holds counts as the cap; 0 without edges.
///
/// # Errors
/// [`Error::InvalidArgument`](crate::Error::InvalidArgument) for samples without shadow states, or a matrix that is not finite.
pub fn edge_width(samples: &Samples, p: &Parameterization, size: [u32; 2]) -> Result<f64> {
    let asked = AskedMaps::new(samples, p, size)?;
    let (mut sum, mut weights) = (0.0, 0.0);
    for edge in asked.shadows.edges.iter().filter(|edge| asked.counts(edge.sample as usize)) {
        let n = DVec2::from_array(edge.normal.map(f64::from));
        let width = asked.texel(edge.sample as usize).map(|g| n.dot(g.x_axis).abs() + n.dot(g.y_axis).abs());
        let weight = f64::from(edge.weight);
        sum += weight * width.filter(|width| width.is_finite()).map_or(CAP_PX, capped_px);
        weights += weight;
    }
    Ok(if weights > 0.0 { sum / weights } else { 0.0 })
}

/// Samples that maps must hold and do not: of those that face the light all, or those in shadow and their neighbours in the
/// picture.
///
/// # Errors
/// As [`edge_width`].
pub fn missed(samples: &Samples, p: &Parameterization, holds: Holds, progress: &Progress) -> Result<usize> {
    let asked = AskedMaps::new(samples, p, p.resolution)?;
    let lost = match holds {
        Holds::Shadow => asked.lost(asked.shadows.shaded.iter().map(|&i| i as usize), progress)?,
        Holds::Seen | Holds::Body => asked.lost(0..samples.len(), progress)?,
    };
    Ok(lost.len())
}
