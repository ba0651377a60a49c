//! Rectilinear shadow maps: a homography, and after it the best separable warp for what is seen.
//!
//! Source: after Rosen 2012 `[rosen2012]`, who warps a map's rows and columns by importance that is projected on either axis;
//! theory.md 10.7, (10.12) to (10.14). Departures: the importance is what a texel costs across shadows' edges in the picture, and the
//! density that makes its sum least is known in closed form; the map before the warp is a technique's homography, not the
//! light's own projection.
//!
//! ```text
//!   |  |  |  |  |  |  |  |        | | |||||||| | |  |    |      columns where edges are coarse are narrow,
//!   a homography's columns        f' ∝ √C               others wide
//! ```

use super::base::Base;
use super::density::{Densities, EdgeWidths};
use crate::error::Result;
use crate::fit::MapSize;
use crate::focus::{Coverage, Focus, FocusedView};
use crate::geometry::Rows;
use crate::parameterization::{PiecewiseLinear, Rectilinear};
use crate::techniques::kit::{
    Default, Kind, LightSupport, MARGIN, Named, Needs, ParamSpec, Part, Provisional, RANGE, SLACK, Settings, Spacing,
    Spec, Warp,
};
use crate::techniques::scene_optimal::HELD;

/// What the technique says of itself.
pub static SPEC: Spec = Spec {
    name: "rectilinear",
    title: "Rectilinear shadow map: a homography, and rows and columns of uneven widths",
    source: "after Rosen 2012",
    lights: LightSupport { directional: true, spot: true, point: true },
    params: &[
        ParamSpec {
            name: "base",
            unit: "",
            default: Default::Choice("scene_optimal"),
            kind: Kind::Technique,
            doc: "the technique whose homography comes before the warp, with the range, fit and margin of this one; it \
                  decides which lights are served",
        },
        ParamSpec {
            name: "bins",
            unit: "",
            default: Default::Integer(256),
            kind: Kind::Integer { min: 1, max: 1024 },
            doc: "pieces of equal width before the warp along each axis, each with one density of texels",
        },
        ParamSpec {
            name: "floor",
            unit: "",
            default: Default::Number(0.5),
            kind: Kind::Number { min: 1e-3, max: 1.0 },
            doc: "least density of texels along either axis, as a share of its mean; 1 leaves the map even",
        },
        ParamSpec {
            name: "cap",
            unit: "pixels",
            default: Default::Number(16.0),
            kind: Kind::ChoiceOrNumber { words: &["none"], min: 0.5, max: 1e6 },
            doc: "width at which one sample stops to count",
        },
        RANGE,
        HELD,
        MARGIN,
        SLACK,
    ],
};

/// Samples at edges, at the most: all of a picture of 256 x 256 pixels.
const MOST_EDGES: usize = 1 << 16;

#[derive(Debug)]
struct RectilinearWarp {
    base: Base,
    bins: usize,
    floor: f64,
    /// Pixels; infinite for none.
    cap: f64,
}

/// The warp from checked settings.
pub fn make(settings: &Settings) -> Result<Box<dyn Warp>> {
    let base = Base::new(settings)?;
    let (bins, floor) = (settings.declared_number("bins")? as usize, settings.declared_number("floor")?);
    let cap = settings.number("cap").unwrap_or(f64::INFINITY);
    Ok(Box::new(RectilinearWarp { base, bins, floor, cap }))
}

impl Warp for RectilinearWarp {
    fn warp(&self, view: &FocusedView, part: &Part) -> Result<Provisional> {
        self.base.warp.warp(view, part)
    }
    fn needs(&self) -> Needs {
        Needs::Shadows
    }
    fn focus(&self) -> Focus {
        self.base.warp.focus()
    }
    fn spacing(&self) -> Spacing {
        Spacing::Rectilinear
    }
    fn base(&self) -> Option<&'static Spec> {
        Some(self.base.spec)
    }
    fn values_of_fit(&self, view: &FocusedView, clip_from_local: &Rows, size: &MapSize) -> Vec<Named> {
        self.base.warp.values_of_fit(view, clip_from_local, size)
    }
    fn rectilinear(
        &self,
        view: &FocusedView,
        part: &Part,
        clip_from_local: &Rows,
        values: &mut Vec<Named>,
    ) -> Result<Option<Rectilinear>> {
        if view.coverage == Coverage::NothingSeen {
            return Ok(None);
        }
        let edges = part.samples.and_then(|s| s.ray_edges(&part.camera, &part.light, &part.region, MOST_EDGES));
        let Some((rays, edges)) = edges else { return Ok(None) };
        // Rays are those of points relative to the eye.
        let homography = rays.homography(&clip_from_local.moved_to_world(view.origin - part.camera.eye()));
        let widths = EdgeWidths::new(&edges, &homography, &part.size, self.bins);
        let Some(densities) = Densities::least(&widths, self.floor, self.cap) else { return Ok(None) };
        values.push(("edge_width_even", widths.mean(&Densities::even(self.bins), self.cap)));
        values.push(("edge_width", widths.mean(&densities, self.cap)));
        let [x, y] = [0, 1].map(|axis| piecewise(&densities.along[axis], part.size.inset()[axis]));
        Ok(Some(Rectilinear { x: x?, y: y? }))
    }
}

/// The warp of an axis whose texels have these densities over [-inset, inset], relative to their mean; border and margin stay
/// as they are.
fn piecewise(densities: &[f64], inset: f64) -> Result<PiecewiseLinear> {
    let step = 2.0 * inset / densities.len() as f64;
    let mut knots = Vec::with_capacity(densities.len() + 3);
    if inset < 1.0 {
        knots.push([-1.0; 2]);
    }
    knots.push([-inset; 2]);
    let mut after = -inset;
    // Their mean is 1 up to rounding, which the end does not have.
    for (i, density) in densities.iter().enumerate().take(densities.len() - 1) {
        after += step * density;
        knots.push([step.mul_add((i + 1) as f64, -inset), after]);
    }
    knots.push([inset; 2]);
    if inset < 1.0 {
        knots.push([1.0; 2]);
    }
    PiecewiseLinear::new(&knots)
}
