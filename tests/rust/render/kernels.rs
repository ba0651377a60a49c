//! The kernels of filters: numbers by hand, and what all of them have.

use glam::{DMat4, DVec2, DVec3};
use shadowlab::render::cpu::lookup::MapLookup;
use shadowlab::render::{Bias, Filter, Kernel, Kernels, Stored, Tap};
use shadowlab::scene::DirectionalLight;
use shadowlab::{Error, Light};

use crate::support::cpu::*;

/// Roundings of f64 in sums of up to 65 x 65 weights.
const EXACT: f64 = 1e-12;

/// The filters that are measured in texels.
fn in_texels() -> impl Iterator<Item = (&'static str, Kernels, Kernel)> {
    FILTERS.into_iter().filter(|text| !text.contains("px")).map(|text| {
        let kernels = Kernels::new(filter(text), None).unwrap();
        let kernel = kernels.fixed().unwrap();
        (text, kernels, kernel)
    })
}

fn places() -> impl Iterator<Item = DVec2> {
    let mut random = Random(5);
    let edges = [DVec2::new(8.0, 8.0), DVec2::new(8.5, 8.5), DVec2::new(0.0, 0.25)];
    edges.into_iter().chain((0..200).map(move |_| DVec2::new(random.number(0.0, 64.0), random.number(0.0, 64.0))))
}

fn taps(kernel: Kernel, place: DVec2) -> Vec<Tap> {
    kernel.taps(&[], place)
}

#[test]
fn weights_are_those_by_hand() {
    // A box of 2.5 texels about x = 10.3 reaches from 9.05 to 11.55; a texel high about y = 4.5 it is in row 4 alone.
    let found = taps(Kernel::Box(DVec2::new(2.5, 1.0)), DVec2::new(10.3, 4.5));
    let row: Vec<_> = found.iter().filter(|tap| tap.texel[1] == 4).map(|tap| (tap.texel[0], tap.weight)).collect();
    for ((column, weight), (i, expected)) in row.iter().zip([(9, 0.38), (10, 0.4), (11, 0.22), (12, 0.0)]) {
        assert!(*column == i && (weight - expected).abs() < EXACT, "{row:?}");
    }
    assert!(found.iter().filter(|tap| tap.texel[1] != 4).all(|tap| tap.weight == 0.0));
    // A triangle of 4 texels about a centre: 7/16, 1/4, 1/32.
    let found = taps(Kernel::Tent(DVec2::new(4.0, 4.0)), DVec2::new(8.5, 8.5));
    for tap in &found {
        let of = |i: i64| match (i - 8).abs() {
            0 => 0.4375,
            1 => 0.25,
            2 => 0.03125,
            _ => 0.0,
        };
        assert!((tap.weight - of(tap.texel[0]) * of(tap.texel[1])).abs() < EXACT, "{tap:?}");
    }
    assert_eq!(found.iter().filter(|tap| tap.weight > 0.0).count(), 25);
}

#[test]
fn weights_sum_to_one_within_the_reach() {
    for (text, kernels, kernel) in in_texels() {
        let reach = kernel.reach();
        for place in places() {
            let taps = kernel.taps(kernels.disc(), place);
            let sum: f64 = taps.iter().map(|tap| tap.weight).sum();
            assert!((sum - 1.0).abs() < EXACT, "{text} at {place}: {sum}");
            for Tap { texel: [i, j], weight } in taps {
                let away = (DVec2::new(i as f64 + 0.5, j as f64 + 0.5) - place).abs();
                assert!(weight >= 0.0);
                assert!(weight == 0.0 || away.cmple(reach + EXACT).all(), "{text} at {place}: {away} over {reach}");
                // What the average takes of this texel alone.
                let alone = kernel.average(kernels.disc(), place, |x, y| f64::from(u8::from([x, y] == [i, j])));
                assert!((alone - weight).abs() < EXACT, "{text} at {place}");
            }
        }
    }
}

#[test]
fn a_box_of_one_texel_is_bilinear_bit_for_bit() {
    let of = |text| Kernels::new(filter(text), None).unwrap().fixed();
    assert_eq!(of("pcf:size=1"), of("bilinear"));
    // The weights of boxes come to the same.
    for place in places() {
        let (bilinear, narrow) = (taps(Kernel::Bilinear, place), taps(Kernel::Box(DVec2::ONE), place));
        for tap in &narrow {
            let same = bilinear.iter().find(|other| other.texel == tap.texel).map_or(0.0, |other| other.weight);
            assert!((same - tap.weight).abs() < EXACT, "{place}");
        }
    }
}

#[test]
fn a_tent_is_the_box_of_half_its_width_twice() {
    const STEPS: usize = 4000;
    for (width, place) in [(4.0, 8.3), (1.0, 8.9), (3.7, 8.0)] {
        let tent = taps(Kernel::Tent(DVec2::new(width, 1.0)), DVec2::new(place, 0.5));
        let half = 0.5 * width;
        for column in 4..13 {
            let of = |taps: &[Tap]| taps.iter().filter(|tap| tap.texel[0] == column).map(|tap| tap.weight).sum::<f64>();
            // The box about the places of the other box, by the midpoint rule: of a piecewise linear function.
            let at = |i: usize| place + half * ((i as f64 + 0.5) / STEPS as f64 - 0.5);
            let moved = |i: usize| {
                let size = DVec2::new(half.max(1e-9), 1.0);
                of(&taps(Kernel::Box(size), DVec2::new(at(i), 0.5)))
            };
            let expected = (0..STEPS).map(moved).sum::<f64>() / STEPS as f64;
            assert!((of(&tent) - expected).abs() < 1e-6, "{width}, {column}: {} and {expected}", of(&tent));
        }
    }
}

#[test]
fn a_disc_compares_the_texels_of_its_points() {
    let kernels = Kernels::new(filter("poisson:count=16,radius=2.5,seed=3"), None).unwrap();
    let place = DVec2::new(8.2, 8.7);
    let mut expected: Vec<_> = kernels.disc().iter().map(|q| (place + 2.5 * *q).floor()).collect();
    for Tap { texel: [i, j], weight } in kernels.fixed().unwrap().taps(kernels.disc(), place) {
        let before = expected.len();
        expected.retain(|at| *at != DVec2::new(i as f64, j as f64));
        assert_eq!(weight * 16.0, (before - expected.len()) as f64);
    }
    assert!(expected.is_empty());
}

#[test]
fn a_straight_edge_gives_the_integral_of_the_kernel() {
    let partition = one_map(DMat4::IDENTITY).partitions.remove(0);
    let light = Light::Directional(DirectionalLight::new(DVec3::Z).unwrap());
    let (side, edge) = (64, 30.0);
    // Lit to the left of the edge.
    let map: Vec<f32> = (0..side * side).map(|i| if f64::from(i % side) < edge { 0.9 } else { 0.1 }).collect();
    let light_at = |filter, x: f64| {
        let size = [side as u32; 2];
        let lookup =
            MapLookup::new(&partition, &light, DVec3::ZERO, size, Bias::NONE, filter, Stored::default()).unwrap();
        lookup.light(&map, DVec3::new(2.0 * x / f64::from(side) - 1.0, 0.03, 0.5), DVec3::NEG_Z)
    };
    let mut last = [1.0f32; 4];
    for step in 0..200 {
        let x = 20.0 + 0.1 * f64::from(step);
        let t = edge - x;
        let of_tent = |t: f64| {
            let u = t.clamp(-1.0, 1.0);
            0.5 + u - 0.5 * u * u.abs()
        };
        let cases = [
            ("bilinear", (0.5 + t).clamp(0.0, 1.0)),
            ("pcf:size=3", (0.5 + t / 3.0).clamp(0.0, 1.0)),
            ("pcf:size=7.3", (0.5 + t / 7.3).clamp(0.0, 1.0)),
            ("tent:size=6", of_tent(t / 3.0)),
        ];
        for ((text, expected), last) in cases.into_iter().zip(&mut last) {
            let found = light_at(filter(text), x);
            assert!((f64::from(found) - expected).abs() < 1e-6, "{text} at {x}: {found}, not {expected}");
            assert!(found <= *last, "{text}: light falls towards the dark");
            *last = found;
        }
    }
    // Of a disc, the share of its points to the left.
    let disc = Kernels::new(filter("poisson:count=64,radius=5"), None).unwrap();
    for x in [27.3, 30.1, 33.8] {
        let left = disc.disc().iter().filter(|q| x + 5.0 * q.x < edge).count();
        assert_eq!(light_at(filter("poisson:count=64,radius=5"), x), left as f32 / 64.0);
    }
}

#[test]
fn a_kernel_in_pixels_takes_a_picture() {
    let error = Kernels::new(filter("pcf:size=3px"), None).unwrap_err();
    assert!(matches!(&error, Error::InvalidArgument { .. }) && error.to_string().contains("pcf:size=3px"), "{error}");
    assert!(Kernels::new(Filter::Nearest, None).unwrap().disc().is_empty());
}
