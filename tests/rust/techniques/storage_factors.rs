//! Published storage factors, measured from finished matrices: one map, and several that share the depths of the view.
//!
//! Source: Lloyd, Tuft, Yoon, Manocha 2006 `[lloyd2006]`; Lloyd et al. 2008 `[lloyd2008]`; theory.md 18.1: light from
//! overhead, 60 degrees, a square image,
//! and a frustum full of receivers. The storage factor S is the largest m_s over all receivers times the largest m_t: the
//! texels that give every receiver one a pixel, over the pixels; of several maps, the sum.
//!
//! What m_s is: the height of a texel between its sides of constant s, in pixels. Off the view's axis a warp shears texels, and
//! their slanted sides are longer than that, by 1 / cos 30° at the corners of this frustum; the published forms are those of
//! the axis (dp/ds of theory.md E.1), where both agree, and of the height, which is the same across the view. m_t is the length
//! of a side of constant s. So height times m_t is the area of a texel, and both are measured over the body's whole outline.

use shadowlab::focus::{Focus, FocusedView};
use shadowlab::parameterization::Partition;
use shadowlab::scene::{Camera, Light, Scene};

use crate::support::measure::{self, DIFFERENCES, LocalMap, assert_printed, degrees, frustum, made, outline};

/// Far over near, of all tables.
const RATIOS: [f64; 4] = [10.0, 100.0, 1000.0, 1e4];

/// Points on an edge of the body. The worst is in a vertex wherever error rises or falls with depth.
const STEPS: i32 = 16;

/// The largest m_s and m_t of each map over its part of the view.
fn worst(text: &str, seen: &(Scene, Camera, Light)) -> Vec<[f64; 2]> {
    let (scene, camera, light) = seen;
    let p = made(text, seen);
    let worst_of = |map: &Partition| {
        let [near, far] = map.eye_depth;
        let camera = camera.with_depths(near, far).expect("depths");
        let view = FocusedView::new(scene, &camera, light, Focus::SceneFit);
        let local = LocalMap::new(&p, map, view.origin);
        outline(&view, STEPS).into_iter().fold([0.0_f64; 2], |[s, t], q| {
            let m = local.measured(&view, q);
            [s.max(m.height), t.max(m.across)]
        })
    };
    p.partitions.iter().map(worst_of).collect()
}

fn storage(text: &str, seen: &(Scene, Camera, Light)) -> f64 {
    worst(text, seen).into_iter().map(|[s, t]| s * t).sum()
}

fn assert_close(what: &str, ours: f64, closed_form: f64) {
    assert!((ours / closed_form - 1.0).abs() < DIFFERENCES, "{what}: {ours} is not {closed_form}");
}

/// 2 tan of half the field of view.
fn width() -> f64 {
    2.0 * degrees(30.0).tan()
}

#[test]
fn one_map_has_the_published_factors() {
    type ClosedForm = fn(f64) -> [f64; 2];
    let perspective: ClosedForm = |r| [(r - 1.0) / width(), 1.0];
    let logarithmic: ClosedForm = |r| [r.ln() / width(), 1.0];
    let warped = ["7.79", "85.7", "865", "8659"];
    let log = ["1.99", "3.99", "5.98", "7.98"];
    let rows: [(&str, ClosedForm, [&str; 4]); 6] = [
        ("uniform", |r| [(r - 1.0) / width(), r], ["77.9", "8574", "8.65e5", "8.66e7"]),
        ("psm:slide=0", perspective, warped),
        ("lispsm:near=1", perspective, warped),
        ("lispsm:near=basic", |r| [(r - 1.0) / (r.sqrt() * width()), r.sqrt()], warped),
        ("log", logarithmic, log),
        ("log_psm", logarithmic, log),
    ];
    for (text, closed_form, printed) in rows {
        for (r, printed) in RATIOS.into_iter().zip(printed) {
            let what = format!("{text}, f/n {r}");
            let seen = frustum(90.0, 0.0, r);
            let worst = worst(text, &seen);
            assert_eq!(worst.len(), 1, "{what}");
            let [s, t] = closed_form(r);
            assert_close(&format!("{what}, m_s"), worst[0][0], s);
            assert_close(&format!("{what}, m_t"), worst[0][1], t);
            assert_printed(&what, worst[0][0] * worst[0][1], printed);
        }
    }
    // Any warp distance between those of PSM and LiSPSM.
    for r in RATIOS {
        for share in [0.1, 0.3, 0.7] {
            let text = format!("lispsm:near={}", 1.0 + share * r.sqrt());
            assert_close(&text, storage(&text, &frustum(90.0, 0.0, r)), (r - 1.0) / width());
        }
    }
}

/// Maps, and printed factors of uniform and warped ones by far over near: four digits at the most, so 17150 is 1.715e4.
const SPLITS: [(u32, [(&str, &str); 4]); 4] = [
    (2, [("11.8", "3.75"), ("156", "15.6"), ("1677", "53.0"), ("1.715e4", "171")]),
    (3, [("6.46", "3.00"), ("43.9", "9.46"), ("234", "23.4"), ("1150", "53.4")]),
    (4, [("4.79", "2.70"), ("23.7", "7.49"), ("90.1", "16.0"), ("312", "31.2")]),
    (8, [("3.08", "2.31"), ("9.59", "5.39"), ("22.5", "9.50"), ("47.4", "15.0")]),
];

#[test]
fn logarithmic_splits_have_the_published_factors() {
    for (count, printed) in SPLITS {
        for (r, (uniform, warped)) in RATIOS.into_iter().zip(printed) {
            let seen = frustum(90.0, 0.0, r);
            let k = f64::from(count);
            let split = r.powf(1.0 / k);
            let cases = [
                ("uniform", split * (split - 1.0), uniform),
                ("(lispsm:near=basic)", split - 1.0, warped),
                ("(psm:slide=0)", split - 1.0, warped),
            ];
            for (inner, of_one, printed) in cases {
                let text = format!("z_partition:count={count},splits=logarithmic,range=camera,inner={inner}");
                let worst = worst(&text, &seen);
                let what = format!("{text}, f/n {r}");
                assert_eq!(worst.len(), count as usize, "{what}");
                // Equal in all splits.
                worst.iter().for_each(|[s, t]| assert_close(&what, s * t, of_one / width()));
                assert_printed(&what, storage(&text, &seen), printed);
            }
            // Splits of an ideal map add up to that map: nothing is gained.
            let text = format!("z_partition:count={count},splits=logarithmic,range=camera,inner=log");
            assert_close(&text, storage(&text, &seen), r.ln() / width());
        }
    }
}

#[test]
fn shear_lengthens_the_sides_of_texels_in_the_corners_by_what_the_header_says() {
    for text in ["psm:slide=0", "lispsm:near=1", "log"] {
        let seen = frustum(90.0, 0.0, 100.0);
        let view = measure::view_of(&seen);
        let p = made(text, &seen);
        let map = LocalMap::new(&p, &p.partitions[0], view.origin);
        for q in view.receivers.vertices() {
            let m = map.measured(&view, *q);
            assert_close(text, m.along / m.height, 1.0 / degrees(30.0).cos());
        }
    }
}
