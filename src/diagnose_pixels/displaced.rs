//! How far the edge of a shadow lies from a pixel in the image.

use super::looker::{Dark, Way};
use super::rays::{LightRays, Receiver};
use crate::aliasing::texel::Eye;

/// How far beyond its ends an edge of a triangle is taken to go on, edges: that of a finer mesh bends little from one to the next.
const BEYOND: f64 = 1.0;

/// From the receiver to the nearest point of the edge at which a shadow along a way ends, pixels: no further than where the way
/// crosses it.
pub(super) fn displacement(dark: &Dark, way: &Way, receiver: &Receiver, rays: &LightRays, eye: &Eye) -> f64 {
    let (pixel, crossed) = (eye.pixel_of(receiver.p), eye.pixel_of(way.at(dark.to)));
    let (Some(pixel), Some(crossed)) = (pixel, crossed) else { return f64::INFINITY };
    let at_most = pixel.distance(crossed);
    let Some(edge) = dark.edge else { return at_most };
    let ends = edge.map(|end| rays.shadow_of(end, receiver).and_then(|shadow| eye.pixel_of(shadow)));
    let [Some(a), Some(b)] = ends else { return at_most };
    let t = ((pixel - a).dot(b - a) / (b - a).length_squared()).clamp(-BEYOND, 1.0 + BEYOND);
    let nearest = pixel.distance(a.lerp(b, t));
    if nearest < at_most { nearest } else { at_most }
}
