//! Meshes with alpha tests: leaves, fences and what closed forms are known of.

use glam::DVec2;
use shadowlab::Mesh;
use shadowlab::scene::{AlphaTest, AlphaTestParts, AlphaTexture, Wrap};

/// A texture of so many texels along each side, by its levels.
pub fn texture(size: [u32; 2], level: impl Fn(u32, u32) -> u8) -> AlphaTexture {
    let texels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| level(x, y)).collect();
    AlphaTexture::new(size, texels).unwrap()
}

/// A test of a texture, with cutoff 1/2.
pub fn alpha_test(texture: Option<AlphaTexture>, uv: &[[f32; 2]], wrap: Wrap) -> AlphaTest {
    let texture = texture.map(Into::into);
    AlphaTest::new(AlphaTestParts { texture, uv: uv.to_vec(), cutoff: 0.5, wrap: [wrap; 2], factor: 1.0 }).unwrap()
}

/// A rectangle from a corner along two edges, with texture coordinates from (0, 0) to `repeats`.
pub fn leaf(corner: [f64; 3], edges: [[f64; 3]; 2], texture: Option<AlphaTexture>, repeats: [f32; 2]) -> Mesh {
    let at = |s: f64, t: f64| [0, 1, 2].map(|k: usize| corner[k] + s * edges[0][k] + t * edges[1][k]);
    let vertices = [at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0)];
    let [u, v] = repeats;
    let uv = [[0.0, 0.0], [u, 0.0], [u, v], [0.0, v]];
    let test = texture.map(|texture| alpha_test(Some(texture), &uv, Wrap::Repeat));
    Mesh::with_alpha_test(&vertices, &[[0, 1, 2], [0, 2, 3]], test).unwrap()
}

/// Levels of a disc that opens a hole of a radius, in parts of the texture, with edges a texel wide.
pub fn hole(size: u32, radius: f64) -> AlphaTexture {
    texture([size; 2], |x, y| {
        let p = (DVec2::new(f64::from(x), f64::from(y)) + 0.5) / f64::from(size) - 0.5;
        let texels = (p.length() - radius) * f64::from(size);
        (255.0 * (0.5 + texels).clamp(0.0, 1.0)).round() as u8
    })
}

/// Levels that wave across and down, from 0 to 255.
pub fn waves(size: u32) -> AlphaTexture {
    texture([size; 2], |x, y| {
        let [x, y] = [x, y].map(|k| (f64::from(k) + 0.5) / f64::from(size) * std::f64::consts::TAU);
        (127.5 + 127.5 * (3.0 * x).sin() * (2.0 * y).cos()).round() as u8
    })
}
