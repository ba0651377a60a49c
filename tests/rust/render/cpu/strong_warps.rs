//! Maps whose w varies by many orders of magnitude, and nearly singular ones: no triangle is lost, none is where it is not.

use crate::render::strong::cases::{
    Family, SIZE, assert_a_ground_has_no_hole, assert_no_triangle_is_lost, assert_singular_matrices_are_drawn, ground,
};
use crate::render::strong::oracle::{bounds, judge};
use crate::support::cpu::depth;

#[test]
fn no_triangle_is_lost_whatever_w_does() {
    assert_no_triangle_is_lost(|scene, m| depth(scene, m, SIZE));
}

#[test]
fn a_ground_that_fills_the_map_has_no_hole() {
    assert_a_ground_has_no_hole(|scene, m| depth(scene, m, SIZE));
}

#[test]
fn singular_matrices_draw_what_they_can() {
    assert_singular_matrices_are_drawn(|scene, m| depth(scene, m, SIZE));
}

#[test]
fn the_oracle_sees_one_lost_texel() {
    let (scene, clip_from_world) = ground(Family::AlongOneAxis, 1e3);
    let bounds = bounds(&scene, &clip_from_world, SIZE);
    let mut map = depth(&scene, clip_from_world, SIZE);
    assert!(judge(&map, &bounds).wrong.is_empty());
    let kept = map[1000];
    for z in [1.0, 0.0, kept + 1e-3, kept - 1e-3, f32::NAN] {
        map[1000] = z;
        assert_eq!(judge(&map, &bounds).wrong.len(), 1, "{z}");
    }
}
