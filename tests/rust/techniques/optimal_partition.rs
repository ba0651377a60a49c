//! Scene-optimal partitions: the division against every division there is, and what holds of the maps of any view.

use shadowlab::note::Kind;
use shadowlab::progress::Progress;
use shadowlab::survey::outside;
use shadowlab::techniques::optimal_partition::least_division;
use shadowlab::techniques::technique_of;

use crate::support::views::{Random, from_library};

/// The least sum over all ways to cut so many intervals into `count` runs.
fn by_trial(first: usize, intervals: usize, count: usize, cost: &dyn Fn(usize, usize) -> f64) -> f64 {
    if count == 1 {
        return cost(first, intervals);
    }
    let ends = first + 1..=intervals - (count - 1);
    ends.map(|end| cost(first, end) + by_trial(end, intervals, count - 1, cost)).fold(f64::INFINITY, f64::min)
}

#[test]
fn the_division_is_the_least_of_all() {
    let mut random = Random(21);
    for intervals in 1..=8_usize {
        for count in 1..=intervals {
            let costs: Vec<f64> = (0..100).map(|_| random.between(0.0, 1.0)).collect();
            let cost = |first: usize, end: usize| costs[first * 10 + end];
            let (ends, sum) = least_division(intervals, count, cost);
            assert_eq!((ends.len(), ends[ends.len() - 1]), (count, intervals));
            let begins = [0].iter().chain(&ends);
            let again: f64 = begins.zip(&ends).map(|(first, end)| cost(*first, *end)).sum();
            assert!(ends.windows(2).all(|w| w[0] < w[1]) && (again - sum).abs() < 1e-12);
            assert!((sum - by_trial(0, intervals, count, &cost)).abs() < 1e-12, "{intervals} in {count}");
        }
    }
    // Costs without end leave a division all the same.
    assert_eq!(least_division(3, 2, |_, _| f64::INFINITY).0, [1, 3]);
    assert_eq!(least_division(2, 5, |_, _| 1.0).0, [1, 2]);
}

#[test]
fn maps_follow_each_other_and_hold_what_is_in_shadow() {
    for v in from_library() {
        let (name, samples) = (&v.name, v.samples());
        let made = |text: &str| {
            let technique = technique_of(text).expect(text);
            technique.parameterize_seen(&v.scene, &v.camera, &v.light, [512; 2], Some(&samples)).expect(text)
        };
        let one = made("scene_optimal");
        let single = made("optimal_partition:count=1");
        assert_eq!(one.partitions.len(), single.partitions.len());
        for (a, b) in one.partitions.iter().zip(&single.partitions) {
            assert_eq!(a.shadow_clip_from_world, b.shadow_clip_from_world, "{name}");
        }
        for (text, most) in [("count=2", 2), ("count=3", 3), ("count=8", 8), ("count=auto", 4)] {
            let p = made(&format!("optimal_partition:{text}"));
            let fewer = p.notes.iter().any(|note| note.kind() == Kind::FewerMaps);
            assert!(p.partitions.len() == most || fewer || text == "count=auto", "{name}, {text}");
            assert!((1..=most).contains(&p.partitions.len()));
            let depths: Vec<[f64; 2]> = p.partitions.iter().map(|map| map.eye_depth).collect();
            assert_eq!((depths[0][0], depths[depths.len() - 1][1]), (v.camera.near(), v.camera.far()));
            assert!(depths.windows(2).all(|w| w[0][1] == w[1][0]) && depths.iter().all(|d| d[0] < d[1]), "{depths:?}");
            let [_, dark] = outside(&samples, &p, &Progress::new()).expect("states");
            assert_eq!(dark, 0, "{name}, {text}");
        }
    }
}

#[test]
fn a_share_of_a_map_is_no_count() {
    let error = technique_of("optimal_partition:count=2.5").expect_err("no whole number").to_string();
    assert!(error.contains("count") && error.contains("whole number") && error.contains("2.5"), "{error}");
}
