//! The plane that most of the visible, lit-facing receivers lie on.
//!
//! Votes over quantised normals give a few candidates; for each, every sample votes for all offsets that put the plane
//! within a share of its depth, and the offset with most votes wins (an exact sweep over the ends of these intervals, no
//! histogram). The share shrinks as long as half of the votes stay: even ground is told from what lies near it, rough ground
//! is not lost. The candidate that most samples are on is fitted to them by least squares. Each sample is a pixel and counts
//! as one. Nothing is drawn at random. Our own; the votes are a Hough transform in two steps.
//!
//! ```text
//!      eye x                                  a sample at depth z votes for the offsets
//!           \   z                             of planes that pass within z / 16 of it:
//!       _____\|___ ___ |‾‾|_____ __           narrow near the eye, where a plane
//!             |          box    floor         matters most, wide at the horizon
//! ```

use std::collections::BTreeMap;

use glam::{DMat3, DVec3};

use crate::focus::{FocusedView, Samples};
use crate::parameterization::Region;
use crate::rays::LightFrame;

/// A sample is on a plane this share of its depth away: a texel that is made for the plane is off by about that share there.
const ON_PLANE: f64 = 1.0 / 16.0;

/// Below this share the digits of float32 positions are at their end.
const FINEST: f64 = f32::EPSILON as f64;

/// A sample is of a plane whose normal has this cosine with its own: an angle of 14 degrees, as wide as a bin of normals.
const ALIKE: f64 = 1.0 - 1.0 / 32.0;

/// Bins of normals to an axis, from 0 to 1; whole numbers, so that level and upright surfaces lie in the middle of a bin.
const BINS: f64 = 4.0;

/// Candidates that are looked at. A surface that is not among the fullest bins of normals is none that dominates.
const CANDIDATES: usize = 4;

/// Samples that vote. Derived from counting: shares are known to 1 / sqrt of that, one part in 64.
const VOTERS: usize = 1 << 12;

/// With fewer samples at edges all samples vote.
const FEWEST_EDGES: usize = 16;

/// The plane `normal · p + offset = 0`, local to the view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DominantPlane {
    /// Unit vector, on the light's side as the samples' own.
    pub normal: DVec3,
    /// Minus the distance of the plane from the local origin along the normal.
    pub offset: f64,
    /// Share of the samples that face the light which lie on it.
    pub share: f64,
}

/// A visible point with its normal, relative to the eye.
#[derive(Debug, Clone, Copy)]
struct Seen {
    p: DVec3,
    normal: DVec3,
    /// [`Camera::distance_at`](crate::scene::Camera::distance_at) its depth.
    depth: f64,
}

/// A plane by its height over the eye along its normal.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    normal: DVec3,
    height: f64,
    /// Samples that are within `share` of their depth.
    votes: usize,
    share: f64,
}

impl Seen {
    fn is_like(&self, normal: DVec3) -> bool {
        self.normal.dot(normal) >= ALIKE
    }
    fn is_on(&self, c: &Candidate, share: f64) -> bool {
        self.is_like(c.normal) && (self.p.dot(c.normal) - c.height).abs() <= share * self.depth
    }
}

impl Candidate {
    fn count(&self, seen: &[Seen], share: f64) -> usize {
        seen.iter().filter(|s| s.is_on(self, share)).count()
    }
}

/// The samples of a part of the view that the light can reach and that face it.
fn facing<'a>(view: &'a FocusedView, region: &'a Region, samples: &'a Samples) -> impl Iterator<Item = Seen> + 'a {
    samples.lit(&view.camera, &view.light, region).filter_map(|(point, normal)| {
        let p = point - view.camera.eye();
        Some(Seen { p, normal: normal.try_normalize()?, depth: view.camera.distance_at(view.camera.forward().dot(p)) })
    })
}

/// The same of those at the edges of shadows, where a map can be wrong.
fn at_edges<'a>(
    view: &'a FocusedView<'a>,
    region: &'a Region,
    samples: &'a Samples,
) -> impl Iterator<Item = Seen> + 'a {
    let edges = samples.shadows.iter().flat_map(|shadows| &shadows.edges);
    edges.filter_map(move |edge| {
        let (point, normal) = samples.sample(edge.sample as usize);
        let p = point - view.camera.eye();
        samples.counts(&view.camera, &view.light, region, point, normal).then_some(())?;
        Some(Seen { p, normal: normal.try_normalize()?, depth: view.camera.distance_at(view.camera.forward().dot(p)) })
    })
}

/// The plane that most samples of this part of the view lie on, those at the edges of shadows where there are some; nothing where no sample faces the light.
pub fn dominant_plane(view: &FocusedView, region: &Region, samples: &Samples) -> Option<DominantPlane> {
    let edges: Vec<Seen> = at_edges(view, region, samples).collect();
    let all = if edges.len() < FEWEST_EDGES { facing(view, region, samples).collect() } else { edges };
    let voters = spread(&all);
    let mut best: Option<(usize, Candidate)> = None;
    for normal in normals(&voters) {
        let found = narrowed(&voters, normal);
        let served = found.count(&voters, ON_PLANE);
        if best.is_none_or(|(most, _)| served > most) {
            best = Some((served, found));
        }
    }
    let best = fitted(&voters, best?.1);
    let on = best.count(&all, ON_PLANE);
    Some(DominantPlane {
        normal: best.normal,
        offset: -(best.height + best.normal.dot(view.eye)),
        share: on as f64 / all.len() as f64,
    })
}

/// At most [`VOTERS`] of the samples, spread evenly over them at steps of the golden ratio: a constant step could hit one
/// column of the image alone.
fn spread(all: &[Seen]) -> Vec<Seen> {
    if all.len() <= VOTERS {
        return all.to_vec();
    }
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    (0..VOTERS).map(|i| all[((i as f64 * golden).fract() * all.len() as f64) as usize]).collect()
}

/// The mean normals around the fullest bins, the fullest first.
fn normals(seen: &[Seen]) -> Vec<DVec3> {
    let mut bins: BTreeMap<[i8; 3], (usize, DVec3)> = BTreeMap::new();
    for s in seen {
        let bin = bins.entry((s.normal * BINS).to_array().map(|x| x.round() as i8)).or_default();
        *bin = (bin.0 + 1, bin.1 + s.normal);
    }
    let mut fullest: Vec<(usize, DVec3)> = bins.into_values().collect();
    // Stable: equally full bins stay in the order of their keys.
    fullest.sort_by_key(|bin| std::cmp::Reverse(bin.0));
    let middle = |normal: DVec3| seen.iter().filter(|s| s.is_like(normal)).map(|s| s.normal).sum::<DVec3>();
    // A surface on the border of bins has its normals in several of them.
    fullest.iter().take(CANDIDATES).filter_map(|bin| middle(bin.1.try_normalize()?).try_normalize()).collect()
}

/// The plane of a normal with most votes, of the smallest share that half of the votes survive.
fn narrowed(seen: &[Seen], normal: DVec3) -> Candidate {
    let widest = vote(seen, normal, ON_PLANE);
    let mut best = widest;
    while best.share > FINEST {
        let closer = vote(seen, normal, 0.25 * best.share);
        if 2 * closer.votes < widest.votes {
            break;
        }
        best = closer;
    }
    best
}

/// The plane of a normal that most samples are near enough to: in the middle of where most of their intervals overlap.
fn vote(seen: &[Seen], normal: DVec3, share: f64) -> Candidate {
    let alike = seen.iter().filter(|s| s.is_like(normal));
    let mut ends: Vec<(f64, bool)> = Vec::with_capacity(2 * seen.len());
    for s in alike {
        let (height, room) = (s.p.dot(normal), share * s.depth);
        ends.extend([(height - room, true), (height + room, false)]);
    }
    // Where one ends and another begins, both hold.
    ends.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    let mut best = Candidate { normal, height: 0.0, votes: 0, share };
    let mut open = 0;
    for (i, (height, begins)) in ends.iter().enumerate() {
        if *begins {
            open += 1;
        } else {
            if open > best.votes {
                // The last to begin before the first to end bound what they have in common.
                let begin = ends[..i].last().map_or(*height, |e| e.0);
                best = Candidate { normal, height: 0.5 * (begin + height), votes: open, share };
            }
            open -= 1;
        }
    }
    best
}

/// The plane through its own samples by least squares of the distance over depth, as long as that loses none of them and
/// most of them stay when only closer ones count.
fn fitted(seen: &[Seen], mut best: Candidate) -> Candidate {
    while let Some(next) = least_squares(seen, &best) {
        let votes = next.count(seen, best.share);
        if votes < best.count(seen, best.share) {
            break;
        }
        best = Candidate { votes, ..next };
        let share = 0.25 * best.share;
        if best.share <= FINEST || 2 * best.count(seen, share) < votes {
            break;
        }
        best.share = share;
    }
    best
}

/// `height = h0 + slopes · across` over the candidate; nothing where its samples lie on a line.
fn least_squares(seen: &[Seen], c: &Candidate) -> Option<Candidate> {
    let frame = LightFrame::any(c.normal);
    let (mut square, mut product) = (DMat3::ZERO, DVec3::ZERO);
    for s in seen.iter().filter(|s| s.is_on(c, c.share)) {
        let row = DVec3::new(s.p.dot(frame.right), s.p.dot(frame.up), 1.0) / s.depth;
        square += DMat3::from_cols(row * row.x, row * row.y, row * row.z);
        product += row * ((s.p.dot(c.normal) - c.height) / s.depth);
    }
    // Half of the digits must be left, with each unknown in its own unit.
    let scale = DVec3::new(square.x_axis.x, square.y_axis.y, square.z_axis.z);
    if square.determinant() <= f64::EPSILON.sqrt() * scale.element_product() {
        return None;
    }
    let slope = square.inverse() * product;
    let normal = (c.normal - frame.right * slope.x - frame.up * slope.y).normalize();
    // The point above the eye's foot on the plane: at height h0 along the old normal.
    let height = normal.dot(c.normal * (c.height + slope.z));
    Some(Candidate { normal, height, ..*c }).filter(|c| c.normal.is_finite() && c.height.is_finite())
}
