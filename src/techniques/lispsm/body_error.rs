//! The perspective error of a warp over the receivers' body: how much of the image a texel covers.
//!
//! Source: theory.md E.1, E.2 and (E.6); the storage factor of Lloyd, Tuft, Yoon, Manocha 2006 `[lloyd2006]` and Lloyd,
//! Govindaraju, Quammen, Molnar, Manocha 2008 `[lloyd2008]`. For a surface whose normal halves the angle between eye
//! and light, R(N) of (E.6) is an isometry, so the pure perspective error of a texel is as long in the image as its
//! side is across the light's ray, over eye depth:
//!
//! ```text
//! m_t = |dX/dt| / (2 z tan)    m_s = |dX/ds| / (2 z tan)         s, t in [0, 1] along and across the warp axis
//! ```
//!
//! in heights of the image, X the point of the ray's cross-section. A length across the view at eye depth z is
//! 1 / (2 z tan) heights long wherever it is in the image, hence no angle to the view's axis. dX/ds is along the line
//! of constant t, so the shear of a warp counts.
//!
//! What depends on the warp distance alone is separated. With eta in [0, 1] along the body's extent D on the axis,
//! mu = D / Pn (0 is the uniform map) and q = (1 + mu eta) / (1 + mu), which is w over its largest value,
//!
//! ```text
//! dX/dt = a_x q Ex                      Ex = extent of x / q
//! dX/ds = (a_x x k + a_y q) q Ey        Ey = (Y1 - Y0) / (q(Y0) q(Y1)),   k = mu / ((1 + mu) D)
//! ```
//!
//! with a_x, a_y the cross-section's vectors per unit of the unwarped x and y. So one warp distance costs two dozen
//! operations a vertex, and a mean of areas, |det| = |a_x × a_y| q³ Ex Ey, four moments.
//!
//! The worst case is sought at the vertices of the body, and on its edges for a spot or with a weight. For a directional
//! light m_t is a quotient of affine functions, so largest in a vertex; m_s is a convex function over an affine one where the
//! line from the reference point to the point makes less than atan √2 with the axis, so largest in a vertex too. Beyond, on
//! edges that the least error does not come near: 8000 random optima are the body's worst to 1e-9.

use glam::{DMat2, DVec2, DVec3};

use super::measure::{Measure, across_along_per_ndc};
use crate::focus::FocusedView;
use crate::geometry::Rows;
use crate::rays::{LightFrame, LightRays};
use crate::techniques::kit::WarpSpace;

/// What is made small.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorNorm {
    /// The storage factor: the largest m_s over the body times the largest m_t, so the texels that give every point of the
    /// body one a pixel, over the pixels of a square image.
    Storage,
    /// The largest m_s: L-infinity along the view.
    Linf,
    /// The mean of the area m = |det dX/d(s, t)| / (2 z tan)² over the pixels that see the body; a pixel's own is the mean
    /// over the part of its ray inside, every octave of depth as likely. The expected number of pixels that share a texel
    /// with a pixel picked at random, where nothing is known of where in the body surfaces are.
    Mean,
}

/// A norm, and how errors count by depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorMeasure {
    /// What is made small.
    pub norm: ErrorNorm,
    /// How many times an error (of an area; of a length for [`ErrorNorm::Linf`]) at the near end of the receivers counts as
    /// one at their far end; a power of eye depth between.
    pub near_weight: f64,
}

/// The vectors across the light's ray at a point (along right and up of its frame) that one unit of a map's NDC x and one of
/// y stand for: the inverse of B_d of (E.6). Nothing where the map or the light is singular.
pub fn footprint(clip_from_local: &Rows, rays: &LightRays, p: DVec3) -> Option<DMat2> {
    let frame = LightFrame::any(rays.direction_at(p)?);
    let ndc_from_across = clip_from_local.jacobian(p, [frame.right, frame.up]);
    let regular = ndc_from_across.determinant().abs() > 0.0 && ndc_from_across.is_finite();
    regular.then(|| ndc_from_across.inverse())
}

/// The measure over the body for every warp distance of a warp space.
#[derive(Debug, Clone)]
pub struct BodyError {
    norm: ErrorNorm,
    /// 1 over the extent of the body along the axis; 0 for none, which has the uniform map alone.
    per_extent: f64,
    points: Vec<Sample>,
    /// Whether the worst of the body is at a point, not between.
    is_exact: bool,
    /// Means of weight |a_x × a_y| / (2 z tan)² eta^k.
    moments: [f64; 4],
}

/// Points of a body for which no memory is asked again.
const USUAL_POINTS: usize = 64;

/// Points on an edge: one for each of these ratios of depth, and at least and at most so many. Chosen because the worst of
/// 8000 random views and weights then is missed by 5 %, and by up to 55 % at vertices alone (tests/rust/techniques/lispsm/optimal.rs).
const EDGE_RATIO: f64 = 2.0;
const EDGE_POINTS: [f64; 2] = [4.0, 12.0];

/// A warp that gains no more than this at the points is none. Chosen because between them two maps of one body may have this
/// much more than each other: of 8000 random views none then is worse than uniform by a finer look (tests/rust/techniques/lispsm/optimal.rs).
const BETWEEN_POINTS: f64 = 0.01;

/// Ray grid of a mean, along each side of the body's rectangle in the image. Chosen because the mean of a slanted body then
/// is within a few percent of that over a million pixels (tests/rust/techniques/lispsm/optimal.rs).
const RAYS: usize = 6;

/// Ratio of depths that three Gauss nodes span in a mean. Chosen because 1 / z² over it is then integrated to 0.2 %.
const PANEL: f64 = 6.0;

/// A point of the body: x from the reference point's, and the products of a_x and a_y, weighted and over (2 z tan)².
#[derive(Debug, Clone, Copy, Default)]
struct Sample {
    x: f64,
    eta: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl BodyError {
    /// The measure of a space's warps over the receivers of its view.
    pub fn new(view: &FocusedView, space: &WarpSpace, measure: &ErrorMeasure) -> Self {
        let sampler = Sampler::new(view, space, measure);
        let mut points = Vec::with_capacity(USUAL_POINTS);
        let mut add = |p: DVec3| points.extend(sampler.sample(p).map(|(sample, _)| sample));
        view.receivers.vertices().iter().for_each(|p| add(*p));
        let is_exact = sampler.constant.is_some() && measure.near_weight == 1.0;
        if !is_exact && measure.norm != ErrorNorm::Mean {
            view.receivers.edges().for_each(|ends| sampler.along_edge(ends, &mut |p| add(p)));
        }
        let moments = if measure.norm == ErrorNorm::Mean { sampler.moments() } else { [0.0; 4] };
        Self { norm: measure.norm, per_extent: sampler.per_extent, points, is_exact, moments }
    }
    /// The measure of a space's warps over points of the local space, each a pixel.
    pub fn over(view: &FocusedView, space: &WarpSpace, measure: &ErrorMeasure, points: &[DVec3]) -> Self {
        let sampler = Sampler::new(view, space, measure);
        let mut sums = Moments::default();
        points.iter().for_each(|p| sums.add(sampler.sample(*p), 1.0));
        let moments = sums.sums.map(|s| if sums.total > 0.0 { s / sums.total } else { 0.0 });
        let points = points.iter().filter_map(|p| sampler.sample(*p)).map(|(sample, _)| sample).collect();
        Self { norm: measure.norm, per_extent: sampler.per_extent, points, is_exact: true, moments }
    }
    /// The largest squares of q |a_x| and of q |a_x x k + a_y q|.
    fn largest(&self, mu: f64) -> [f64; 2] {
        let (scale, k) = (1.0 / (1.0 + mu), mu / (1.0 + mu) * self.per_extent);
        let (mut across, mut along) = (0.0_f64, 0.0_f64);
        for p in &self.points {
            let (q, sheared) = ((1.0 + mu * p.eta) * scale, p.x * k);
            across = across.max(q * q * p.xx);
            along = along.max(q * q * (sheared * (sheared * p.xx + 2.0 * q * p.xy) + q * q * p.yy));
        }
        [across, along]
    }
}

impl Measure for BodyError {
    fn error(&self, mu: f64, ndc: DVec2) -> f64 {
        let across_along = ndc * across_along_per_ndc(mu);
        match self.norm {
            ErrorNorm::Storage => {
                let [across, along] = self.largest(mu);
                (across * along).sqrt() * across_along.element_product()
            }
            ErrorNorm::Linf => self.largest(mu)[1].sqrt() * across_along.y,
            ErrorNorm::Mean => {
                let [a, b, c, d] = self.moments;
                let mean = a + mu * (3.0 * b + mu * (3.0 * c + mu * d));
                mean / (1.0 + mu).powi(3) * across_along.element_product()
            }
        }
    }
    fn is_less(&self, error: f64, other: f64) -> bool {
        // A mean of both is over the same points.
        let between = if self.is_exact || self.norm == ErrorNorm::Mean { f64::EPSILON.sqrt() } else { BETWEEN_POINTS };
        error < other * (1.0 - between)
    }
}

/// What a point of the body says about the error, before any warp.
struct Sampler<'a> {
    view: &'a FocusedView<'a>,
    space: &'a WarpSpace,
    norm: ErrorNorm,
    weight_exponent: f64,
    per_extent: f64,
    /// The same footprint everywhere, where light and map are parallel.
    constant: Option<DMat2>,
}

impl<'a> Sampler<'a> {
    fn new(view: &'a FocusedView<'a>, space: &'a WarpSpace, measure: &ErrorMeasure) -> Self {
        let [near, far] = view.eye_depth;
        let octaves = (far / near).ln();
        let weight_exponent = if octaves > 0.0 { -measure.near_weight.ln() / octaves } else { 0.0 };
        let parallel = view.rays.point.w == 0.0 && space.rows.w.truncate() == DVec3::ZERO;
        let constant = if parallel { footprint(&space.rows, &view.rays, view.eye) } else { None };
        let per_extent = Some(space.extent().recip()).filter(|x| x.is_finite()).unwrap_or(0.0);
        Self { view, space, norm: measure.norm, weight_exponent, per_extent, constant }
    }
    /// Hands over points on an edge, even in the logarithm of depth.
    fn along_edge(&self, ends: [DVec3; 2], add: &mut impl FnMut(DVec3)) {
        let [near, far] = ends.map(|p| (p - self.view.eye).dot(self.view.camera.forward()).max(self.view.eye_depth[0]));
        let octaves = (far / near).ln();
        let count = (octaves.abs() / EDGE_RATIO.ln()).ceil().clamp(EDGE_POINTS[0], EDGE_POINTS[1]);
        for i in 1..=count as usize {
            let share = i as f64 / (count + 1.0);
            // Both quotients go to `share` as the depths become one.
            let level = octaves.abs() <= f64::EPSILON.sqrt();
            add(ends[0].lerp(ends[1], if level { share } else { (octaves * share).exp_m1() / octaves.exp_m1() }));
        }
    }
    /// The sample and the weighted area of its footprint over (2 z tan)².
    fn sample(&self, p: DVec3) -> Option<(Sample, f64)> {
        let (view, space) = (self.view, self.space);
        let [near, far] = view.eye_depth;
        let across = self.constant.or_else(|| footprint(&space.rows, &view.rays, p))?;
        let depth = (p - view.eye).dot(view.camera.forward()).max(near);
        let heights = 0.5 / (depth * view.camera.half_size().y);
        let weight = if self.weight_exponent == 0.0 { 1.0 } else { (depth / far).powf(self.weight_exponent) };
        let area = heights * heights * weight;
        // Each of m_s and m_t of the storage factor counts by the root of the weight of their product.
        let square = if self.norm == ErrorNorm::Linf { area * weight } else { area };
        let clip = space.rows.clip(p);
        let (x, y) = (clip.x / clip.w - space.x_ref, clip.y / clip.w - space.y[0]);
        let sample = Sample {
            x,
            eta: y * self.per_extent,
            xx: across.x_axis.length_squared() * square,
            xy: across.x_axis.dot(across.y_axis) * square,
            yy: across.y_axis.length_squared() * square,
        };
        Some((sample, across.determinant().abs() * area))
    }
    /// Means over the pixels that see the body of the weighted area times eta^k.
    fn moments(&self) -> [f64; 4] {
        let view = self.view;
        let (forward, eye) = (view.camera.forward(), view.eye);
        let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for p in view.receivers.vertices() {
            let at = *p - eye;
            let image = DVec2::new(at.dot(view.camera.right()), at.dot(view.camera.up()));
            let image = image / at.dot(forward).max(view.eye_depth[0]);
            (low, high) = (low.min(image), high.max(image));
        }
        let mut sums = Moments::default();
        for i in 0..RAYS * RAYS {
            let cell = DVec2::new((i % RAYS) as f64 + 0.5, (i / RAYS) as f64 + 0.5) / RAYS as f64;
            let image = low + (high - low) * cell;
            let ray = forward + view.camera.right() * image.x + view.camera.up() * image.y;
            self.along_ray(ray, &mut sums);
        }
        if sums.total == 0.0 {
            // A body so thin that it lies between the rays.
            view.receivers.vertices().iter().for_each(|p| sums.add(self.sample(*p), 1.0));
        }
        sums.sums.map(|s| s / sums.total)
    }
    /// Adds the mean over a pixel's ray (of depth 1 along the view) inside the body.
    fn along_ray(&self, ray: DVec3, sums: &mut Moments) {
        let view = self.view;
        let [mut near, mut far] = view.eye_depth;
        for plane in view.receiver_planes().chain(&view.scene_planes()) {
            // Outside is where the functional, at + rate z, is positive.
            let functional = plane.functional();
            let (at, rate) = (functional.dot(view.eye.extend(1.0)), functional.dot(ray.extend(0.0)));
            if rate > 0.0 {
                far = far.min(-at / rate);
            } else if rate < 0.0 {
                near = near.max(-at / rate);
            } else if at > 0.0 {
                return;
            }
        }
        // A flat body is met at one depth, by planes that round differently.
        if !(near <= far * (1.0 + f64::EPSILON.sqrt())) {
            return;
        }
        let octaves = (far / near).ln().max(0.0);
        let panels = (octaves / PANEL.ln()).ceil().max(1.0);
        // Gauss and Legendre's three nodes in ln z.
        const NODES: [(f64, f64); 3] = [(0.112_701_665_379_258_3, 5.0), (0.5, 8.0), (0.887_298_334_620_741_7, 5.0)];
        for panel in 0..panels as usize {
            for (node, weight) in NODES {
                let depth = near * (octaves * (panel as f64 + node) / panels).exp();
                sums.add(self.sample(view.eye + ray * depth), weight / (18.0 * panels));
            }
        }
    }
}

#[derive(Default)]
struct Moments {
    sums: [f64; 4],
    total: f64,
}

impl Moments {
    fn add(&mut self, sample: Option<(Sample, f64)>, weight: f64) {
        let Some((sample, area)) = sample else { return };
        let mut power = area * weight;
        for sum in &mut self.sums {
            *sum += power;
            power *= sample.eta;
        }
        self.total += weight;
    }
}
