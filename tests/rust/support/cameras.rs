//! Cameras of every kind before a few scenes: parallel rays, pictures beside the view axis, no end, extreme aspects and fields of
//! view.

use glam::{DVec2, DVec3};
use shadowlab::scene::{Camera, Scene, ViewVolume};

use crate::support::views::by_hand;

/// The scene and a camera of each kind.
pub fn cameras_of_every_kind() -> Vec<(String, Scene, Camera)> {
    let all = by_hand();
    let find = |name: &str| all.iter().find(|s| s.0 == name).expect("a scene by hand").clone();
    let mut found = Vec::new();
    for name in ["town", "cube"] {
        let (_, scene, camera) = find(name);
        found.extend(kinds(&scene, &camera).into_iter().map(|(k, c)| (format!("{name}, {k}"), scene.clone(), c)));
    }
    // Seen edge on and from straight above, flat along and across the rays.
    for name in ["floor", "floor edge on", "floor from above", "line", "point", "nothing in view", "town from inside"] {
        let (_, scene, camera) = find(name);
        let plain = parallel(&camera, 20.0, -50.0, 120.0);
        found.push((format!("{name}, parallel"), scene, plain));
    }
    found
}

/// The camera with parallel rays.
pub fn parallel(camera: &Camera, height: f64, near: f64, far: f64) -> Camera {
    camera.with_volume(ViewVolume::orthographic(height, camera.aspect(), near, far)).expect("a box")
}

/// The pose of a camera with volumes of every kind.
pub fn kinds(scene: &Scene, camera: &Camera) -> Vec<(&'static str, Camera)> {
    let volume = camera.volume();
    let with = |volume: ViewVolume| camera.with_volume(volume).expect("a camera");
    let middle = camera.depth_of(scene.bounds().center());
    let size = scene.bounds().diagonal();
    let (near, far) = (volume.near, volume.far);
    let above = Camera::look_along(
        scene.bounds().center() + DVec3::Y * size,
        DVec3::NEG_Y,
        DVec3::NEG_Z,
        ViewVolume::orthographic(0.8 * size, 1.4, 0.0, 3.0 * size),
    );
    let aslant = ViewVolume::orthographic(0.3 * size, volume.aspect, near, far);
    let wide = |fov_deg: f64, aspect: f64| ViewVolume::perspective(fov_deg.to_radians(), aspect, near, far);
    vec![
        ("parallel", with(aslant)),
        ("parallel from straight above", above.expect("a camera")),
        ("parallel, from among it", with(aslant.with_depths(middle - size, middle + 0.1 * size))),
        ("parallel, shifted", with(aslant.shifted(DVec2::new(0.4, -0.8)))),
        ("parallel, behind the eye", with(aslant.with_depths(-3.0 * size, middle))),
        ("parallel, narrow", with(ViewVolume { aspect: 0.05, ..aslant })),
        ("shifted", with(volume.shifted(DVec2::new(0.6, -0.5)))),
        ("beside the axis", with(volume.shifted(DVec2::new(-1.3, 0.4)))),
        ("without an end", with(volume.with_depths(near, f64::INFINITY))),
        ("shifted, without an end", with(volume.with_depths(near, f64::INFINITY).shifted(DVec2::new(0.2, 1.0)))),
        ("narrow", with(ViewVolume { aspect: 0.05, ..volume })),
        ("broad", with(ViewVolume { aspect: 20.0, ..volume })),
        ("1 degree", with(wide(1.0, 1.4))),
        ("170 degrees, broad", with(wide(170.0, 20.0))),
        ("170 degrees, narrow", with(wide(170.0, 0.05))),
    ]
}
