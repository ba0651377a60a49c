//! Points of a Poisson disc: random, and none near another.
//!
//! Source: Mitchell 1991 `[mitchell1991]`, best candidate: of several random points the one that is farthest from all before it
//! is taken, so that the first points of a disc are spread as all of them are. Only operations that are the same on every machine.

use glam::DVec2;

use crate::scene::library::Random;

/// What the numbers are drawn for.
const PURPOSE: u64 = 14;
/// Candidates for a point, for each point before it: chosen because the least distance of 16 points is then above 0.35 for the
/// seeds 0 to 99 (tested), and 256 points take some milliseconds.
const CANDIDATES: usize = 16;

/// The first `count` points of the unit disc of a seed.
pub(super) fn disc(count: u32, seed: u32) -> Vec<DVec2> {
    let mut random = Random::new(u64::from(seed), PURPOSE);
    let mut points: Vec<DVec2> = Vec::with_capacity(count as usize);
    while points.len() < count as usize {
        let room = |q: DVec2| points.iter().map(|p| p.distance_squared(q)).fold(f64::INFINITY, f64::min);
        let mut best = (random.in_disc(), f64::NEG_INFINITY);
        best.1 = room(best.0);
        for _ in 0..CANDIDATES * points.len() {
            let candidate = random.in_disc();
            let room = room(candidate);
            if room > best.1 {
                best = (candidate, room);
            }
        }
        points.push(best.0);
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    fn least_distance(points: &[DVec2]) -> f64 {
        let of = |i: usize| points[..i].iter().map(move |p| p.distance(points[i]));
        (0..points.len()).flat_map(of).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn points_lie_in_the_disc_apart_from_each_other_and_are_those_of_their_seed() {
        let least = |count| (0..100).map(|seed| least_distance(&disc(count, seed))).fold(f64::INFINITY, f64::min);
        let (sixteen, all) = (least(16), least_distance(&disc(256, 3)));
        println!("least distances: {sixteen} of 16 points, {all} of 256");
        // 16 circles of diameter 0.35, and 256 of 0.08, fill two thirds of what can be filled.
        assert!(sixteen > 0.35 && all > 0.08, "{sixteen}, {all}");
        assert!(disc(256, 7).iter().all(|p| p.length() <= 1.0));
        assert_eq!(disc(16, 7), disc(256, 7)[..16], "more points leave those before");
        assert_ne!(disc(16, 7), disc(16, 8));
        // Pinned: the same on every machine.
        assert_eq!(disc(3, 0)[2].to_array(), [0.864_382_672_476_481_6, -0.368_174_098_243_960_97]);
    }
}
