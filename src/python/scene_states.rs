//! States of meshes and scenes: what they store, as a few arrays, so that geometry which instances share is there once.
//!
//! ```text
//! Scene    positions (V, 3) f32   triangles (M, 3) u32   source faces (S,) u32       of all meshes, one after the other
//!          frames (K, 4) f64: scale, center              counts (K, 3) u32: vertices, triangles, dropped faces
//!          mesh index (I,) u32    world from mesh (I, 12) f64, by columns
//! Mesh     the first five, K = 1
//! ```
//! Where meshes have alpha tests, the state is of version 2 and those of [`alpha_states`](super::alpha_states) follow.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use pyo3::prelude::*;

use super::alpha_states::{BorrowedTests, OF_TESTS, Tests, with_tests};
use super::arrays::{borrowed, cut, uncounted};
use super::convert::{SOON, image, run_parallel, run_sized};
use super::state::{Fault, OTHER_SEAL, Parts, Reduced, reduced, seal};
use crate::digest::Digest;
use crate::error::{Error, Result};
use crate::progress::Progress;
use crate::scene::{AlphaTexture, Instance, Mesh, Scene, Stored};

const MESH: &str = "Mesh";
const SCENE: &str = "Scene";
/// Without and with alpha tests.
const VERSIONS: [u32; 2] = [1, 2];
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
    tests: Tests,
}

/// The same, borrowed.
struct Borrowed<'a> {
    positions: &'a [f32],
    triangles: &'a [u32],
    source_faces: &'a [u32],
    frames: &'a [f64],
    counts: &'a [u32],
    tests: BorrowedTests<'a>,
}

impl Meshes {
    fn of(meshes: &[Arc<Mesh>], progress: &Progress) -> Result<Self> {
        let mut all = Self::default();
        let mut textures: Vec<&Arc<AlphaTexture>> = Vec::new();
        for (index, mesh) in meshes.iter().enumerate() {
            progress.check()?;
            all.positions.extend(mesh.positions_local().iter().flat_map(|p| p.to_array()));
            all.triangles.extend_from_slice(mesh.triangles().as_flattened());
            all.source_faces.extend_from_slice(mesh.source_faces());
            let frame = mesh.mesh_from_local();
            all.frames.push(frame.matrix3.x_axis.x);
            all.frames.extend(frame.translation.to_array());
            // A mesh has fewer than 2^32 of each.
            all.counts
                .extend([mesh.positions_local().len(), mesh.triangles().len(), mesh.dropped_faces()].map(|n| n as u32));
            if let Some(test) = mesh.alpha_test() {
                all.tests.push(index as u32, test, &mut textures);
            }
        }
        Ok(all)
    }
    fn borrowed(&self) -> Borrowed<'_> {
        let Self { positions, triangles, source_faces, frames, counts, tests } = self;
        Borrowed { positions, triangles, source_faces, frames, counts, tests: tests.borrowed() }
    }
    fn version(&self) -> u32 {
        VERSIONS[usize::from(!self.tests.is_empty())]
    }
    /// All arrays, with those of instances before those of alpha tests.
    fn into_arrays<'py>(self, py: Python<'py>, instances: Vec<Bound<'py, PyAny>>) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let tests = self.tests.into_arrays(py)?;
        let (v, m, s, k) =
            (self.positions.len() / 3, self.triangles.len() / 3, self.source_faces.len(), self.counts.len() / 3);
        let own = vec![
            image(py, self.positions, [v, 3])?.into_any(),
            image(py, self.triangles, [m, 3])?.into_any(),
            image(py, self.source_faces, [s])?.into_any(),
            image(py, self.frames, [k, 4])?.into_any(),
            image(py, self.counts, [k, 3])?.into_any(),
        ];
        Ok([own, instances, tests].concat())
    }
}

impl Borrowed<'_> {
    fn add_to(&self, digest: &mut Digest, progress: &Progress) -> Result<()> {
        let check = || progress.check();
        digest.watched_list(self.positions, check)?;
        digest.watched_list(self.triangles, check)?;
        digest.watched_list(self.source_faces, check)?;
        digest.watched_list(self.frames, check)?;
        digest.watched_list(self.counts, check)?;
        self.tests.add_to(digest);
        progress.check()
    }
    /// Whether it takes long to look at them.
    fn are_many(&self) -> bool {
        self.triangles.len() > SOON
    }
    /// The meshes, each bit as it was.
    fn meshes(&self, progress: &Progress) -> Result<Vec<Arc<Mesh>>> {
        let mut rest = (self.positions, self.triangles, self.source_faces);
        let mut made = Vec::new();
        let mut tests = self.tests.tests(self.counts)?.into_iter().peekable();
        let frames = self.frames.as_chunks::<4>().0;
        for (&[v, m, dropped], &[scale, x, y, z]) in self.counts.as_chunks::<3>().0.iter().zip(frames) {
            progress.check()?;
            let s = if dropped > 0 { m } else { 0 };
            let index = made.len() as u32;
            let alpha_test = tests.next_if(|(mesh, _)| *mesh == index).map(|(_, test)| test);
            let positions = cut(&mut rest.0, v, 3)?;
            let triangles = cut(&mut rest.1, m, 3)?;
            made.push(Arc::new(Mesh::from_stored(Stored {
                positions_local: positions.as_chunks::<3>().0.iter().map(|&p| p.into()).collect(),
                triangles: triangles.as_chunks::<3>().0.to_vec(),
                source_faces: cut(&mut rest.2, s, 1)?.to_vec(),
                dropped_faces: dropped as usize,
                scale,
                center: DVec3::new(x, y, z),
                alpha_test,
            })?));
        }
        if !(rest.0.is_empty() && rest.1.is_empty() && rest.2.is_empty()) {
            return Err(uncounted());
        }
        Ok(made)
    }
}

/// Adds instances.
fn add_instances(digest: &mut Digest, index: &[u32], transforms: &[f64], progress: &Progress) -> Result<()> {
    digest.watched_list(index, || progress.check())?;
    digest.watched_list(transforms, || progress.check())
}

/// `__reduce__` of a mesh.
pub fn reduce_mesh<'py>(py: Python<'py>, mesh: &Arc<Mesh>) -> PyResult<Reduced<'py>> {
    let (meshes, seal) = run_sized(py, mesh.triangles().len() > SOON, |progress| {
        let meshes = Meshes::of(std::slice::from_ref(mesh), progress)?;
        let seal = seal(MESH, meshes.version(), &[], |digest| meshes.borrowed().add_to(digest, progress))?;
        Ok((meshes, seal))
    })?;
    let version = meshes.version();
    reduced(py, MESH, version, &[], &seal, meshes.into_arrays(py, Vec::new())?)
}

/// `__reduce__` of a scene.
pub fn reduce_scene<'py>(py: Python<'py>, scene: &Scene) -> PyResult<Reduced<'py>> {
    let triangles: usize = scene.meshes().iter().map(|mesh| mesh.triangles().len()).sum();
    let is_long = triangles + scene.instances().len() > SOON;
    let (meshes, index, transforms, seal) = run_sized(py, is_long, |progress| {
        let meshes = Meshes::of(scene.meshes(), progress)?;
        let index: Vec<u32> = scene.instances().iter().map(|i| i.mesh).collect();
        let transforms: Vec<f64> = scene.instances().iter().flat_map(|i| i.world_from_mesh.to_cols_array()).collect();
        let seal = seal(SCENE, meshes.version(), &[], |digest| {
            meshes.borrowed().add_to(digest, progress)?;
            add_instances(digest, &index, &transforms, progress)
        })?;
        Ok((meshes, index, transforms, seal))
    })?;
    let count = index.len();
    let version = meshes.version();
    let instances = vec![image(py, index, [count])?.into_any(), image(py, transforms, [count, 12])?.into_any()];
    reduced(py, SCENE, version, &[], &seal, meshes.into_arrays(py, instances)?)
}

/// An error unless the version is known and the arrays are as many as it has beside those of alpha tests.
fn check(py: Python<'_>, parts: &Parts<'_>, others: usize) -> PyResult<()> {
    let tests = if parts.version == VERSIONS[1] { OF_TESTS } else { 0 };
    parts.check(py, VERSIONS[1], others + tests)
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
    let meshes = Borrowed {
        positions: positions.as_slice()?,
        triangles: triangles.as_slice()?,
        source_faces: source_faces.as_slice()?,
        frames: frames.as_slice()?,
        counts: counts.as_slice()?,
        tests: BorrowedTests::default(),
    };
    if parts.version == VERSIONS[0] {
        return work(&meshes);
    }
    with_tests(py, parts, |tests| work(&Borrowed { tests, ..meshes }))
}

/// What `make` makes of a state whose seal is that of what `add` adds.
fn restored<T: Send>(
    py: Python<'_>,
    parts: &Parts<'_>,
    takes_long: bool,
    add: impl FnOnce(&mut Digest, &Progress) -> Result<()> + Send,
    make: impl FnOnce(&Progress) -> Result<T> + Send,
) -> PyResult<T> {
    let sealed = parts.sealed();
    let made = run_parallel(py, takes_long, |progress| {
        if !sealed.is_of(|digest| add(digest, progress))? {
            return Ok(Err(OTHER_SEAL.into()));
        }
        match make(progress) {
            Err(Error::Interrupted) => Err(Error::Interrupted),
            made => Ok(made.map_err(|e| e.to_string())),
        }
    })?;
    made.map_err(|fault: Fault| parts.error(py, fault))
}

/// The mesh of a state.
pub fn restored_mesh<'py>(py: Python<'py>, parts: &Parts<'py>) -> PyResult<Arc<Mesh>> {
    check(py, parts, OF_MESHES)?;
    parts.read(py, |_| Ok(()))?;
    let found = with_meshes(py, parts, |arrays| {
        let add = |digest: &mut Digest, progress: &Progress| arrays.add_to(digest, progress);
        restored(py, parts, arrays.are_many(), add, |progress| arrays.meshes(progress))
    })?;
    match found.as_slice() {
        [one] => Ok(Arc::clone(one)),
        others => Err(parts.error(py, format!("it holds {} meshes", others.len()))),
    }
}

/// The scene of a state.
pub fn restored_scene<'py>(py: Python<'py>, parts: &Parts<'py>) -> PyResult<Scene> {
    check(py, parts, OF_MESHES + OF_INSTANCES)?;
    parts.read(py, |_| Ok(()))?;
    let index = borrowed::<u32>(py, parts, OF_MESHES, &[None])?;
    let index = index.as_slice()?;
    let transforms = borrowed::<f64>(py, parts, OF_MESHES + 1, &[Some(index.len()), Some(12)])?;
    let transforms = transforms.as_slice()?;
    with_meshes(py, parts, |arrays| {
        let add = |digest: &mut Digest, progress: &Progress| {
            arrays.add_to(digest, progress)?;
            add_instances(digest, index, transforms, progress)
        };
        restored(py, parts, arrays.are_many() || index.len() > SOON, add, |progress| {
            let place = |(&mesh, columns): (&u32, &[f64; 12])| Instance {
                mesh,
                world_from_mesh: DAffine3::from_cols_array(columns),
            };
            let instances = index.iter().zip(transforms.as_chunks::<12>().0).map(place).collect();
            Scene::watched(arrays.meshes(progress)?, instances, progress)
        })
    })
}
