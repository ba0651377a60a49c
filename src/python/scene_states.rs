//! States of meshes and scenes: what they store, as a few arrays, so that geometry which instances share is there once.
//!
//! ```text
//! Scene    positions (V, 3) f32   triangles (M, 3) u32   source faces (S,) u32       of all meshes, one after the other
//!          frames (K, 4) f64: scale, center              counts (K, 3) u32: vertices, triangles, dropped faces
//!          mesh index (I,) u32    world from mesh (I, 12) f64, by columns
//! Mesh     the first five, K = 1
//! ```

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use pyo3::prelude::*;

use super::arrays::borrowed;
use super::convert::image;
use super::state::{Parts, Reduced, reduced, seal};
use crate::digest::Digest;
use crate::error::{Error, Result};
use crate::scene::{Instance, Mesh, Scene, Stored};
use crate::threads;

const MESH: &str = "Mesh";
const SCENE: &str = "Scene";
const VERSION: u32 = 1;
/// Arrays of meshes, and of instances.
const OF_MESHES: usize = 5;
const OF_INSTANCES: usize = 2;

/// The arrays of some meshes.
#[derive(Default)]
struct Meshes {
    positions: Vec<f32>,
    triangles: Vec<u32>,
    source_faces: Vec<u32>,
    frames: Vec<f64>,
    counts: Vec<u32>,
}

/// The same, borrowed.
struct Borrowed<'a> {
    positions: &'a [f32],
    triangles: &'a [u32],
    source_faces: &'a [u32],
    frames: &'a [f64],
    counts: &'a [u32],
}

impl Meshes {
    fn of(meshes: &[Arc<Mesh>]) -> Self {
        let mut all = Self::default();
        for mesh in meshes {
            all.positions.extend(mesh.positions_local().iter().flat_map(|p| p.to_array()));
            all.triangles.extend_from_slice(mesh.triangles().as_flattened());
            all.source_faces.extend_from_slice(mesh.source_faces());
            let frame = mesh.mesh_from_local();
            all.frames.push(frame.matrix3.x_axis.x);
            all.frames.extend(frame.translation.to_array());
            // A mesh has fewer than 2^32 of each.
            all.counts
                .extend([mesh.positions_local().len(), mesh.triangles().len(), mesh.dropped_faces()].map(|n| n as u32));
        }
        all
    }
    fn borrowed(&self) -> Borrowed<'_> {
        let Self { positions, triangles, source_faces, frames, counts } = self;
        Borrowed { positions, triangles, source_faces, frames, counts }
    }
    fn into_arrays(self, py: Python<'_>) -> PyResult<Vec<Bound<'_, PyAny>>> {
        let (v, m, s, k) =
            (self.positions.len() / 3, self.triangles.len() / 3, self.source_faces.len(), self.counts.len() / 3);
        Ok(vec![
            image(py, self.positions, [v, 3])?.into_any(),
            image(py, self.triangles, [m, 3])?.into_any(),
            image(py, self.source_faces, [s])?.into_any(),
            image(py, self.frames, [k, 4])?.into_any(),
            image(py, self.counts, [k, 3])?.into_any(),
        ])
    }
}

impl Borrowed<'_> {
    fn add_to(&self, digest: &mut Digest) {
        digest.list(self.positions);
        digest.list(self.triangles);
        digest.list(self.source_faces);
        digest.list(self.frames);
        digest.list(self.counts);
    }
    /// The meshes, each bit as it was.
    fn meshes(&self) -> Result<Vec<Arc<Mesh>>> {
        let mut rest = (self.positions, self.triangles, self.source_faces);
        let mut made = Vec::new();
        let frames = self.frames.as_chunks::<4>().0;
        for (&[v, m, dropped], &[scale, x, y, z]) in self.counts.as_chunks::<3>().0.iter().zip(frames) {
            let s = if dropped > 0 { m } else { 0 };
            let positions = cut(&mut rest.0, v, 3)?;
            let triangles = cut(&mut rest.1, m, 3)?;
            made.push(Arc::new(Mesh::from_stored(Stored {
                positions_local: positions.as_chunks::<3>().0.iter().map(|&p| p.into()).collect(),
                triangles: triangles.as_chunks::<3>().0.to_vec(),
                source_faces: cut(&mut rest.2, s, 1)?.to_vec(),
                dropped_faces: dropped as usize,
                scale,
                center: DVec3::new(x, y, z),
            })?));
        }
        if !(rest.0.is_empty() && rest.1.is_empty() && rest.2.is_empty()) {
            return Err(uncounted());
        }
        Ok(made)
    }
}

/// The first `rows` rows of `width` numbers.
fn cut<'a, T>(rest: &mut &'a [T], rows: u32, width: usize) -> Result<&'a [T]> {
    let (first, others) = rest.split_at_checked((rows as usize).saturating_mul(width)).ok_or_else(uncounted)?;
    *rest = others;
    Ok(first)
}

fn uncounted() -> Error {
    Error::argument("counts", "as many rows as arrays have", "others", "take all of them from one scene")
}

/// Adds instances.
fn add_instances(digest: &mut Digest, index: &[u32], transforms: &[f64]) {
    digest.list(index);
    digest.list(transforms);
}

/// `__reduce__` of a mesh.
pub fn reduce_mesh<'py>(py: Python<'py>, mesh: &Arc<Mesh>) -> PyResult<Reduced<'py>> {
    let (meshes, seal) = py.detach(|| {
        let meshes = Meshes::of(std::slice::from_ref(mesh));
        let seal = seal(MESH, VERSION, &[], |digest| meshes.borrowed().add_to(digest));
        (meshes, seal)
    });
    reduced(py, MESH, VERSION, &[], &seal, meshes.into_arrays(py)?)
}

/// `__reduce__` of a scene.
pub fn reduce_scene<'py>(py: Python<'py>, scene: &Scene) -> PyResult<Reduced<'py>> {
    let (meshes, index, transforms, seal) = py.detach(|| {
        let meshes = Meshes::of(scene.meshes());
        let index: Vec<u32> = scene.instances().iter().map(|i| i.mesh).collect();
        let transforms: Vec<f64> = scene.instances().iter().flat_map(|i| i.world_from_mesh.to_cols_array()).collect();
        let seal = seal(SCENE, VERSION, &[], |digest| {
            meshes.borrowed().add_to(digest);
            add_instances(digest, &index, &transforms);
        });
        (meshes, index, transforms, seal)
    });
    let count = index.len();
    let mut arrays = meshes.into_arrays(py)?;
    arrays.push(image(py, index, [count])?.into_any());
    arrays.push(image(py, transforms, [count, 12])?.into_any());
    reduced(py, SCENE, VERSION, &[], &seal, arrays)
}

/// Calls `work` with the arrays of meshes.
fn with_meshes<'py, T>(
    py: Python<'py>,
    parts: &Parts<'py>,
    work: impl FnOnce(&Borrowed<'_>) -> PyResult<T>,
) -> PyResult<T> {
    let positions = borrowed::<f32>(py, parts, 0, &[None, Some(3)])?;
    let triangles = borrowed::<u32>(py, parts, 1, &[None, Some(3)])?;
    let source_faces = borrowed::<u32>(py, parts, 2, &[None])?;
    let frames = borrowed::<f64>(py, parts, 3, &[None, Some(4)])?;
    let counts = borrowed::<u32>(py, parts, 4, &[None, Some(3)])?;
    work(&Borrowed {
        positions: positions.as_slice()?,
        triangles: triangles.as_slice()?,
        source_faces: source_faces.as_slice()?,
        frames: frames.as_slice()?,
        counts: counts.as_slice()?,
    })
}

/// The mesh of a state.
pub fn restored_mesh<'py>(py: Python<'py>, parts: &Parts<'py>) -> PyResult<Arc<Mesh>> {
    parts.check(py, VERSION, OF_MESHES)?;
    parts.read(py, |_| Ok(()))?;
    let found = with_meshes(py, parts, |arrays| {
        parts.check_seal(py, |digest| arrays.add_to(digest))?;
        py.detach(|| arrays.meshes()).map_err(|e| parts.error(py, e))
    })?;
    match found.as_slice() {
        [one] => Ok(Arc::clone(one)),
        others => Err(parts.error(py, format!("it holds {} meshes", others.len()))),
    }
}

/// The scene of a state.
pub fn restored_scene<'py>(py: Python<'py>, parts: &Parts<'py>) -> PyResult<Scene> {
    parts.check(py, VERSION, OF_MESHES + OF_INSTANCES)?;
    parts.read(py, |_| Ok(()))?;
    let index = borrowed::<u32>(py, parts, OF_MESHES, &[None])?;
    let index = index.as_slice()?;
    let transforms = borrowed::<f64>(py, parts, OF_MESHES + 1, &[Some(index.len()), Some(12)])?;
    let transforms = transforms.as_slice()?;
    with_meshes(py, parts, |arrays| {
        parts.check_seal(py, |digest| {
            arrays.add_to(digest);
            add_instances(digest, index, transforms);
        })?;
        let made = py.detach(|| {
            let place = |(&mesh, columns): (&u32, &[f64; 12])| Instance {
                mesh,
                world_from_mesh: DAffine3::from_cols_array(columns),
            };
            let instances = index.iter().zip(transforms.as_chunks::<12>().0).map(place).collect();
            threads::install(|| Scene::new(arrays.meshes()?, instances))?
        });
        made.map_err(|e| parts.error(py, e))
    })
}
