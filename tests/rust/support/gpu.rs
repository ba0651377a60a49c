//! What the tests of the gpu renderer share.

use std::io::Write;

use glam::{DMat4, DVec3};
use shadowlab::render::gpu::GpuRenderer;
use shadowlab::{Camera, Error, Parameterization, Partition};

/// Where set, a missing adapter is a failure instead of a skip.
const REQUIRE: &str = "SHADOWLAB_REQUIRE_ALL";

/// A renderer, or nothing on a machine without adapters, which is told.
pub fn renderer() -> Option<GpuRenderer> {
    match GpuRenderer::new(None) {
        Ok(renderer) => Some(renderer),
        Err(Error::NoAdapter { .. }) if std::env::var(REQUIRE).is_ok_and(|v| v != "0" && !v.is_empty()) => {
            panic!("no graphics adapter, and {REQUIRE} is set")
        }
        Err(Error::NoAdapter { .. }) => {
            // Not eprintln: the test harness swallows what it prints in tests that pass, and skips are counted.
            let told = writeln!(std::io::stderr(), "\nskipped: no graphics adapter ({REQUIRE}=1 makes this a failure)");
            told.expect("standard error");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// A parameterization of one map.
pub fn single_map(shadow_clip_from_world: DMat4) -> Parameterization {
    Parameterization::of_partitions(vec![Partition::of_matrix(shadow_clip_from_world)], [64; 2])
}

/// A camera at a height above the origin that looks down, x to the right, -z to the top.
pub fn camera_above(height: f64) -> Camera {
    let eye = DVec3::new(0.0, height, 0.0);
    Camera::look_at(eye, DVec3::ZERO, DVec3::NEG_Z, 0.8, 1.0, 0.1, 10.0 * height).unwrap()
}
