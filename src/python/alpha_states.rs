//! States of alpha tests, in those of meshes and scenes.
//!
//! ```text
//! settings (T, 2) f64: cutoff, factor          kinds (T, 4) u32: mesh, texture from 1 or 0 for none, wrap along u and v
//! texture coordinates (C, 2) f32               sizes (X, 2) u32: width, height       texels (N,) u8 of all textures
//! ```
//! A texture that meshes share is there once.

use std::sync::Arc;

use pyo3::prelude::*;

use super::alpha_test::shared_texture;
use super::arrays::{borrowed, cut, uncounted};
use super::convert::image;
use super::state::Parts;
use crate::digest::Digest;
use crate::error::Result;
use crate::scene::{AlphaTest, AlphaTestParts, AlphaTexture, Wrap};

/// Arrays of alpha tests, after all others.
pub const OF_TESTS: usize = 5;

/// The arrays of alpha tests.
#[derive(Default)]
pub struct Tests {
    settings: Vec<f64>,
    kinds: Vec<u32>,
    uv: Vec<f32>,
    sizes: Vec<u32>,
    texels: Vec<u8>,
}

/// Alpha tests, borrowed; all empty where there are none.
#[derive(Default, Clone, Copy)]
pub struct BorrowedTests<'a> {
    settings: &'a [f64],
    kinds: &'a [u32],
    uv: &'a [f32],
    sizes: &'a [u32],
    texels: &'a [u8],
}

impl Tests {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }
    /// The same, borrowed.
    pub fn borrowed(&self) -> BorrowedTests<'_> {
        let Self { settings, kinds, uv, sizes, texels } = self;
        BorrowedTests { settings, kinds, uv, sizes, texels }
    }
    /// Adds the test of a mesh; `textures` are those that were added.
    pub fn push<'a>(&mut self, mesh: u32, test: &'a AlphaTest, textures: &mut Vec<&'a Arc<AlphaTexture>>) {
        let AlphaTestParts { texture, uv, cutoff, wrap, factor } = test.parts();
        let number = texture.as_ref().map_or(0, |texture| {
            let known = textures.iter().position(|known| Arc::ptr_eq(known, texture));
            1 + known.unwrap_or_else(|| {
                textures.push(texture);
                self.sizes.extend(texture.size());
                self.texels.extend_from_slice(texture.texels());
                textures.len() - 1
            })
        });
        self.settings.extend([*cutoff, *factor]);
        self.kinds.extend([mesh, number as u32, wrap[0] as u32, wrap[1] as u32]);
        self.uv.extend_from_slice(uv.as_flattened());
    }
    /// None where there is no test.
    pub fn into_arrays(self, py: Python<'_>) -> PyResult<Vec<Bound<'_, PyAny>>> {
        let [t, c, x, n] = [self.kinds.len() / 4, self.uv.len() / 2, self.sizes.len() / 2, self.texels.len()];
        if t == 0 {
            return Ok(Vec::new());
        }
        Ok(vec![
            image(py, self.settings, [t, 2])?.into_any(),
            image(py, self.kinds, [t, 4])?.into_any(),
            image(py, self.uv, [c, 2])?.into_any(),
            image(py, self.sizes, [x, 2])?.into_any(),
            image(py, self.texels, [n])?.into_any(),
        ])
    }
}

impl BorrowedTests<'_> {
    /// Adds all of them.
    pub fn add_to(&self, digest: &mut Digest) {
        if self.kinds.is_empty() {
            return;
        }
        digest.list(self.settings);
        digest.list(self.kinds);
        digest.list(self.uv);
        digest.list(self.sizes);
        digest.list(self.texels);
    }
    /// The tests, each with the index of its mesh, in the order of these; `counts` as in the state of a scene.
    pub fn tests(&self, counts: &[u32]) -> Result<Vec<(u32, AlphaTest)>> {
        let (mut uv, mut texels) = (self.uv, self.texels);
        let mut textures = Vec::new();
        for &[width, height] in self.sizes.as_chunks::<2>().0 {
            let own = cut(&mut texels, width, height as usize)?;
            textures.push(shared_texture([width, height], own.to_vec())?);
        }
        let mut made: Vec<(u32, AlphaTest)> = Vec::new();
        for (&[cutoff, factor], &[mesh, texture, wrap_u, wrap_v]) in
            self.settings.as_chunks::<2>().0.iter().zip(self.kinds.as_chunks::<4>().0)
        {
            let count = counts.as_chunks::<3>().0.get(mesh as usize).ok_or_else(uncounted)?[0];
            let wrap = |number: u32| Wrap::ALL.get(number as usize).copied().ok_or_else(uncounted);
            let texture = match texture.checked_sub(1) {
                None => None,
                Some(index) => Some(textures.get(index as usize).cloned().ok_or_else(uncounted)?),
            };
            if made.last().is_some_and(|(last, _)| *last >= mesh) {
                return Err(uncounted());
            }
            let uv = cut(&mut uv, count, 2)?.as_chunks::<2>().0.to_vec();
            let parts = AlphaTestParts { texture, uv, cutoff, wrap: [wrap(wrap_u)?, wrap(wrap_v)?], factor };
            made.push((mesh, AlphaTest::new(parts)?));
        }
        if uv.is_empty() && texels.is_empty() { Ok(made) } else { Err(uncounted()) }
    }
}

/// Calls `work` with the alpha tests of a state that has them.
pub fn with_tests<'py, T>(
    py: Python<'py>,
    parts: &Parts<'py>,
    work: impl FnOnce(BorrowedTests<'_>) -> PyResult<T>,
) -> PyResult<T> {
    let first = parts.arrays.len() - OF_TESTS;
    let settings = borrowed::<f64>(py, parts, first, &[None, Some(2)])?;
    let settings = settings.as_slice()?;
    let kinds = borrowed::<u32>(py, parts, first + 1, &[Some(settings.len() / 2), Some(4)])?;
    let uv = borrowed::<f32>(py, parts, first + 2, &[None, Some(2)])?;
    let sizes = borrowed::<u32>(py, parts, first + 3, &[None, Some(2)])?;
    let texels = borrowed::<u8>(py, parts, first + 4, &[None])?;
    let (kinds, uv, sizes, texels) = (kinds.as_slice()?, uv.as_slice()?, sizes.as_slice()?, texels.as_slice()?);
    work(BorrowedTests { settings, kinds, uv, sizes, texels })
}
