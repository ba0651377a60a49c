//! Scene-optimal maps: derivatives against differences, costs against the map's own homography, and other optimizers.

use glam::{DMat2, DMat3, DVec2, DVec3};
use shadowlab::geometry::{convex_hull, planar_image};
use shadowlab::techniques::scene_optimal::{Cost, Objective, Problem, Published, Sample, Shape, enclosing, least};

use crate::support::views::Random;

const COSTS: [(Objective, f64); 6] = [
    (Objective::Edge, 32.0),
    (Objective::Edge, f64::INFINITY),
    (Objective::L1, 32.0),
    (Objective::L1, f64::INFINITY),
    (Objective::L2, f64::INFINITY),
    (Objective::Area, f64::INFINITY),
];

/// A hull of rays and samples inside of it whose pixels are those of an eye close to one end.
fn problem(random: &mut Random, cost: Cost, count: usize) -> (Vec<DVec2>, Vec<Sample>, Problem) {
    let corners = 5 + random.below(20);
    let middle = DVec2::new(random.between(-30.0, 30.0), random.between(-30.0, 30.0));
    let (turn, flat) = (DVec2::from_angle(random.between(0.0, 6.3)), random.between(0.2, 1.0));
    let place = |at: DVec2| middle + (at * DVec2::new(7.0, 7.0 * flat)).rotate(turn);
    let hull: Vec<DVec2> =
        (0..corners).map(|i| place(DVec2::from_angle(std::f64::consts::TAU * i as f64 / corners as f64))).collect();
    // Depth grows along a line of the plane, as on a floor before an eye.
    let (near, along) = (random.between(0.02, 0.5), DVec2::from_angle(random.between(0.0, 6.3)));
    let samples: Vec<Sample> = (0..count)
        .map(|_| {
            let at = DVec2::from_angle(random.between(0.0, 6.3)) * random.between(0.0, 0.98);
            let depth = near + 1.0 + along.dot(at);
            let pixel = DMat2::from_angle(random.between(0.0, 6.3))
                * DMat2::from_diagonal(DVec2::new(100.0 / depth, 100.0 / depth.powf(random.between(1.0, 2.0))));
            let edge = DVec2::from_angle(random.between(0.0, 6.3));
            let rows = if cost.objective == Objective::Edge {
                [pixel.transpose() * edge, DVec2::ZERO]
            } else {
                [pixel.row(0), pixel.row(1)]
            };
            Sample { y: place(at), rows, weight: random.between(0.5, 2.0) }
        })
        .collect();
    let made = Problem::new(&hull, samples.iter().copied(), DVec2::new(1022.0, 510.0), cost).expect("a problem");
    (hull, samples, made)
}

fn shape(random: &mut Random, problem: &Problem) -> Shape {
    let p = DVec2::from_angle(random.between(0.0, 6.3)) * random.between(0.1, 4.0);
    let first = random.between(0.0, 6.3);
    let axes = [first, first + random.between(0.4, 2.7)].map(DVec2::from_angle);
    Shape { h: problem.h_of(p).0, axes }
}

#[test]
fn derivatives_are_differences() {
    let (mut random, mut creases) = (Random(11), 0);
    for (objective, cap) in COSTS {
        for _ in 0..20 {
            let (_, _, problem) = problem(&mut random, Cost { objective, cap }, 60);
            let at = shape(&mut random, &problem);
            let (value, slopes) = problem.slopes(&at, usize::MAX);
            assert!((value / problem.value(&at, usize::MAX) - 1.0).abs() < 1e-14);
            let moved = |i: usize, by: f64| {
                let mut to = at;
                match i {
                    0 | 1 => to.h[i] += by,
                    i => to.axes[i - 2] = to.axes[i - 2].rotate(DVec2::from_angle(by)),
                }
                problem.value(&to, usize::MAX)
            };
            let size = slopes.iter().fold(0.0f64, |l, s| l.max(s.abs()));
            for (i, slope) in slopes.into_iter().enumerate() {
                // Richardson's step takes the error of central differences to the fourth power.
                let step = 2e-4 * if i < 2 { 1.0 / (1.0 + size / value) } else { 1.0 };
                let difference = |h: f64| (moved(i, h) - moved(i, -h)) / (2.0 * h);
                let [coarse, fine] = [difference(step), difference(0.5 * step)];
                if (coarse - fine).abs() > 1e-5 * size {
                    // A crease: an edge along a texel's side, or a corner of the hull that takes over from another.
                    creases += 1;
                    continue;
                }
                let expected = (4.0 * fine - coarse) / 3.0;
                assert!(
                    (slope - expected).abs() < 1e-8 * size,
                    "{objective:?} {cap}, {i}: {slope} and {expected} of {size}"
                );
            }
            let p = DVec2::new(0.3, -1.2) * random.between(0.1, 3.0);
            let (_, by_p) = problem.h_of(p);
            for j in 0..2 {
                let difference =
                    (problem.h_of(p + DVec2::AXES[j] * 1e-6).0 - problem.h_of(p - DVec2::AXES[j] * 1e-6).0) / 2e-6;
                assert!(
                    (by_p.col(j) - difference).length() < 1e-8 * (1.0 + by_p.col(j).length()),
                    "{by_p} {difference}"
                );
            }
        }
    }
    assert!(creases < 6 * 20 * 4 / 8, "{creases} creases");
}

/// The mean cost of a homography that is cropped to a hull, by its own derivatives.
fn by_homography(homography: &DMat3, hull: &[DVec2], samples: &[Sample], texels: DVec2, cost: &Cost) -> f64 {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    hull.iter().map(|y| planar_image(homography, *y).0).for_each(|at| (low, high) = (low.min(at), high.max(at)));
    let texel = DMat2::from_diagonal((high - low) / texels);
    let (mut sum, mut weights) = (0.0, 0.0);
    for s in samples {
        let (_, w, jacobian) = planar_image(homography, s.y);
        assert!(w > 0.0);
        let pixels = DMat2::from_cols(s.rows[0], s.rows[1]).transpose();
        sum += s.weight * cost.of(&(pixels * jacobian.inverse() * texel));
        weights += s.weight;
    }
    sum / weights
}

#[test]
fn a_shape_costs_what_its_cropped_homography_does_and_is_found_in_it() {
    let mut random = Random(12);
    for (objective, cap) in COSTS {
        for _ in 0..20 {
            let cost = Cost { objective, cap };
            let (hull, samples, problem) = problem(&mut random, cost, 40);
            let at = shape(&mut random, &problem);
            let homography = problem.homography(&at);
            let expected = by_homography(&homography, &hull, &samples, DVec2::new(1022.0, 510.0), &cost);
            let found = problem.value(&at, usize::MAX);
            assert!((found / expected - 1.0).abs() < 1e-9, "{objective:?}: {found} and {expected}");
            let again = problem.shape_of(&homography).expect("w is positive");
            assert!((problem.value(&again, usize::MAX) / found - 1.0).abs() < 1e-9);
            assert!((problem.h_of(problem.p_of(at.h)).0 - at.h).length() < 1e-9 * (1.0 + at.h.length()));
            // As light sees it: x and y turn as those of the rays.
            assert!(planar_image(&homography, samples[0].y).2.determinant() > 0.0);
        }
    }
}

/// Differential evolution over p and the angles: another way to an optimum.
fn evolved(random: &mut Random, problem: &Problem) -> f64 {
    let shape = |x: &[f64; 4]| Shape {
        h: problem.h_of(DVec2::new(x[0], x[1])).0,
        axes: [DVec2::from_angle(x[2]), DVec2::from_angle(x[3])],
    };
    let value = |x: &[f64; 4]| Some(problem.value(&shape(x), usize::MAX)).filter(|v| v.is_finite()).unwrap_or(f64::MAX);
    let mut all: Vec<([f64; 4], f64)> = (0..40)
        .map(|_| {
            let p = DVec2::from_angle(random.between(0.0, 6.3)) * random.between(0.0, 4.0);
            let a = random.between(0.0, 3.2);
            let x = [p.x, p.y, a, a + random.between(0.4, 2.7)];
            (x, value(&x))
        })
        .collect();
    for _ in 0..220 {
        for i in 0..all.len() {
            let [a, b, c] = [0, 1, 2].map(|_| random.below(all.len()));
            let best = all.iter().min_by(|a, b| a.1.total_cmp(&b.1)).expect("some").0;
            let from = if random.unit() < 0.5 { best } else { all[a].0 };
            let mutant: [f64; 4] = std::array::from_fn(|k| {
                if random.unit() < 0.9 { from[k] + 0.7 * (all[b].0[k] - all[c].0[k]) } else { all[i].0[k] }
            });
            let found = value(&mutant);
            if found <= all[i].1 {
                all[i] = (mutant, found);
            }
        }
    }
    all.iter().map(|one| one.1).fold(f64::INFINITY, f64::min)
}

#[test]
fn another_optimizer_finds_hardly_less() {
    let mut random = Random(13);
    let mut worst = 0.0_f64;
    for (objective, cap) in COSTS {
        for _ in 0..5 {
            let (_, _, problem) = problem(&mut random, Cost { objective, cap }, 150);
            let (found, cost) = least(&problem, &[]).expect("a shape");
            assert!((problem.value(&found, usize::MAX) / cost - 1.0).abs() < 1e-12);
            let other = evolved(&mut random, &problem);
            worst = worst.max(cost / other - 1.0);
            assert!(cost <= 1.01 * other, "{objective:?} {cap}: {cost} and {other}");
        }
    }
    println!("at most {worst:.2e} above");
}

#[test]
fn what_is_found_is_never_worse_than_a_start() {
    let mut random = Random(14);
    for (objective, cap) in COSTS {
        let (_, _, problem) = problem(&mut random, Cost { objective, cap }, 300);
        let starts: Vec<Shape> = (0..5).map(|_| shape(&mut random, &problem)).collect();
        let (_, cost) = least(&problem, &starts).expect("a shape");
        for start in &starts {
            assert!(cost <= problem.value(start, usize::MAX));
        }
    }
}

/// A hull and samples around zero, as the published search has them.
fn published(random: &mut Random) -> Published {
    let cost = Cost { objective: Objective::L2, cap: f64::INFINITY };
    let (hull, samples, _) = problem(random, cost, 50);
    let middle = hull.iter().sum::<DVec2>() / hull.len() as f64;
    let to = |y: DVec2| (y - middle) / 7.0;
    let samples = samples.iter().map(|s| Sample { y: to(s.y), rows: s.rows.map(|row| row * 7.0), ..*s }).collect();
    Published { hull: hull.into_iter().map(to).collect(), samples }
}

#[test]
fn the_published_gradient_is_a_difference_and_its_sum_never_rises() {
    let mut random = Random(15);
    let mut steps = 0;
    for _ in 0..30 {
        let problem = published(&mut random);
        let p4 = DVec3::new(random.between(-0.3, 0.3), random.between(-0.3, 0.3), 1.0).normalize();
        let Some(homography) = problem.affine(p4) else { continue };
        let slope = problem.slope(&homography);
        let row = |by: DVec3| {
            let [x, y, w] = [0, 1, 2].map(|i| homography.row(i));
            problem.sum(&DMat3::from_cols(x, y, w + by).transpose())
        };
        for j in 0..3 {
            let difference = |h: f64| (row(DVec3::AXES[j] * h) - row(DVec3::AXES[j] * -h)) / (2.0 * h);
            let expected = (4.0 * difference(1e-4) - difference(2e-4)) / 3.0;
            assert!((slope[j] - expected).abs() < 1e-8 * slope.length(), "{j}: {} and {expected}", slope[j]);
        }
        let history = problem.search(DVec3::Z).expect("a map");
        assert!(history.windows(2).all(|two| two[1].sum < two[0].sum) && history.len() <= 4, "{history:?}");
        steps += history.len() - 1;
        for step in &history {
            assert!((problem.sum(&step.homography) / step.sum - 1.0).abs() < 1e-12);
            for y in &problem.hull {
                let (at, w, _) = planar_image(&step.homography, *y);
                assert!(w > 0.0 && at.abs().max_element() < 1.0 + 1e-9, "{at}");
            }
        }
    }
    assert!(steps > 15, "{steps} steps in all");
}

#[test]
fn a_sheared_rectangle_is_the_least_of_all_directions_and_shears() {
    let mut random = Random(16);
    for _ in 0..20 {
        let mut corners: Vec<DVec2> =
            (0..30).map(|_| DVec2::new(random.between(-3.0, 3.0), random.between(-1.0, 1.0))).collect();
        convex_hull(&mut corners, &mut Vec::new());
        let found = enclosing(&corners).expect("an area");
        let extent = |axis: DVec2| {
            let at = corners.iter().map(|p| axis.dot(*p));
            let (low, high) = at.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
            high - low
        };
        let area = |angle: f64, shear: f64| {
            let along = DVec2::from_angle(angle);
            extent(along + along.perp() * shear) * extent(along.perp())
        };
        let directions = (0..2000).map(|i| std::f64::consts::PI * f64::from(i) / 2000.0);
        let shears = (-200..=200).map(|k| f64::from(k) * 0.02);
        let least = directions.flat_map(|a| shears.clone().map(move |k| (a, k)));
        let least = least.map(|(a, k)| area(a, k)).fold(f64::INFINITY, f64::min);
        assert!(found.area <= least * (1.0 + 1e-9), "{} and {least}", found.area);
        assert!(found.area > 0.97 * least, "{} and {least}", found.area);
        let [x, y] = found.rows;
        let inside = |p: &DVec2| [x, y].map(|row| row.dot(p.extend(1.0)).abs());
        assert!(corners.iter().all(|p| inside(p).iter().all(|v| *v < 1.0 + 1e-9)));
        let cross = x.truncate().perp_dot(y.truncate()).abs();
        assert!((4.0 / cross / found.area - 1.0).abs() < 1e-9, "its area is what it says");
    }
}
