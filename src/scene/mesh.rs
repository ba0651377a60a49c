//! Triangle meshes, stored once, in a local frame that single precision loves.
//!
//! A mesh keeps its vertices as f32 in a *local* frame: moved to the middle of their box and divided by a power of two, so
//! that the largest coordinate has magnitude in [0.5, 1]. Coordinates in UTM, at 1e-6 or at 1e9 therefore lose nothing
//! beyond the rounding to 24 bits of the mesh's own extent, and every consumer (both renderers, truth, bounds)
//! sees exactly the same geometry.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use glam::{DAffine3, DMat3, DVec3, Vec3};

use super::alpha_test::AlphaTest;
use super::borders::border_edges;
use super::clusters::Clusters;
use crate::digest::{Digest, Numbers};
use crate::error::{Error, Result};
use crate::geometry::Aabb;
use crate::progress::Progress;

/// What the hash of a mesh begins with; the number changes with what goes in.
const CONTENT: &str = "shadowlab mesh 1";

/// Faces or vertices between two looks at whether to go on: about a millisecond of work.
const AT_ONCE: usize = 1 << 16;

/// An indexed triangle mesh. Immutable; shared between instances through `Arc`.
#[derive(Debug)]
pub struct Mesh {
    id: u64,
    positions_local: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
    source_faces: Vec<u32>,
    mesh_from_local: DAffine3,
    bounds_local: Aabb,
    dropped_faces: usize,
    alpha_test: Option<Box<AlphaTest>>,
    content_hash: OnceLock<[u8; 32]>,
    border_edges: OnceLock<usize>,
    clusters: OnceLock<Clusters>,
}

/// What a mesh is stored as.
#[derive(Debug, Clone, PartialEq)]
pub struct Stored {
    /// [`Mesh::positions_local`].
    pub positions_local: Vec<Vec3>,
    /// [`Mesh::triangles`].
    pub triangles: Vec<[u32; 3]>,
    /// Rows of the caller's face array that triangles come from; empty where no face was dropped.
    pub source_faces: Vec<u32>,
    /// [`Mesh::dropped_faces`].
    pub dropped_faces: usize,
    /// Power of two: length of the local unit in the mesh's own frame.
    pub scale: f64,
    /// The local origin in the mesh's own frame.
    pub center: DVec3,
    /// [`Mesh::alpha_test`].
    pub alpha_test: Option<AlphaTest>,
}

impl Mesh {
    /// A mesh from vertices in its own frame and triangles of indices into them.
    ///
    /// Faces with a non-finite vertex are dropped and counted ([`Mesh::dropped_faces`]). Vertices no face uses are dropped,
    /// so they have no say in the bounds.
    ///
    /// # Errors
    /// [`Error::FaceIndex`] for an index out of range, [`Error::EmptyScene`] where no face is left.
    pub fn new(vertices: &[[f64; 3]], faces: &[[i64; 3]]) -> Result<Self> {
        Self::with_alpha_test(vertices, faces, None)
    }
    /// The same, with a test that has texture coordinates for each vertex.
    ///
    /// # Errors
    /// As [`Mesh::new`], and [`Error::InvalidArgument`] for another number of texture coordinates.
    pub fn with_alpha_test(vertices: &[[f64; 3]], faces: &[[i64; 3]], alpha_test: Option<AlphaTest>) -> Result<Self> {
        Self::watched(vertices, faces, alpha_test, &Progress::new())
    }
    /// The same, stopped where `progress` says so.
    ///
    /// # Errors
    /// As [`Mesh::with_alpha_test`], and [`Error::Interrupted`].
    pub fn watched(
        vertices: &[[f64; 3]],
        faces: &[[i64; 3]],
        alpha_test: Option<AlphaTest>,
        progress: &Progress,
    ) -> Result<Self> {
        const UNUSED: u32 = u32::MAX;
        let count = vertices.len();
        if count >= UNUSED as usize || faces.len() > i32::MAX as usize {
            return Err(Error::argument(
                "mesh",
                "fewer than 2^32 - 1 vertices and 2^31 faces",
                format!("{count} vertices and {} faces", faces.len()),
                "split the mesh",
            ));
        }
        check_coordinates(alpha_test.as_ref(), count)?;
        let mut compact = vec![UNUSED; count];
        let mut order: Vec<u32> = Vec::new();
        let mut triangles = Vec::with_capacity(faces.len());
        let mut kept: Vec<u32> = Vec::new();
        for (face, &indices) in faces.iter().enumerate() {
            if face.is_multiple_of(AT_ONCE) {
                progress.check()?;
            }
            if let Some(&index) = indices.iter().find(|&&i| i < 0 || i as usize >= count) {
                return Err(Error::FaceIndex { face, index, count });
            }
            if indices.iter().any(|&i| vertices[i as usize].iter().any(|x| !x.is_finite())) {
                continue;
            }
            triangles.push(indices.map(|i| {
                let slot = &mut compact[i as usize];
                if *slot == UNUSED {
                    *slot = order.len() as u32;
                    order.push(i as u32);
                }
                *slot
            }));
            kept.push(face as u32);
        }
        let dropped_faces = faces.len() - triangles.len();
        if triangles.is_empty() {
            let reason = if faces.is_empty() {
                format!("{count} vertices and no face")
            } else {
                format!("all {} faces have non-finite vertices", faces.len())
            };
            return Err(Error::EmptyScene { reason });
        }
        let source = |i: u32| DVec3::from_array(vertices[i as usize]);
        let mut bounds = Aabb::EMPTY;
        for some in order.chunks(AT_ONCE) {
            progress.check()?;
            bounds = bounds.union(Aabb::from_points(some.iter().map(|&i| source(i))));
        }
        let center = bounds.center();
        let half = (0.5 * bounds.max - 0.5 * bounds.min).max_element();
        let scale = power_of_two_at_least(half);
        let mut positions_local: Vec<Vec3> = Vec::with_capacity(order.len());
        for some in order.chunks(AT_ONCE) {
            progress.check()?;
            positions_local.extend(some.iter().map(|&i| ((source(i) - center) / scale).as_vec3()));
        }
        let source_faces = if dropped_faces > 0 { kept } else { Vec::new() };
        let alpha_test = alpha_test.map(|test| test.of_rows(&order));
        Ok(Self::assembled(Stored {
            positions_local,
            triangles,
            source_faces,
            dropped_faces,
            scale,
            center,
            alpha_test,
        }))
    }
    /// The mesh that is stored so, bit for bit.
    ///
    /// # Errors
    /// [`Error::InvalidArgument`] for what no mesh is stored as, [`Error::EmptyScene`] without a triangle.
    pub fn from_stored(stored: Stored) -> Result<Self> {
        let refused = |name: &'static str, expected: &'static str, got: String| {
            Err(Error::argument(name, expected, got, "take all of them from one mesh"))
        };
        let Stored { positions_local, triangles, source_faces, dropped_faces, scale, center, alpha_test } = &stored;
        let count = positions_local.len();
        if triangles.is_empty() {
            return Err(Error::EmptyScene { reason: format!("{count} vertices and no face") });
        }
        let mut used = 0;
        for (face, triangle) in triangles.iter().enumerate() {
            for index in triangle.map(|i| i as usize) {
                if index >= count {
                    return Err(Error::FaceIndex { face, index: index as i64, count });
                }
                if index > used {
                    let got = format!("vertex {index} before vertex {used}");
                    return refused("faces", "vertices in the order in which faces first use them", got);
                }
                used = used.max(index + 1);
            }
        }
        if used < count {
            return refused("positions", "vertices that faces use", format!("{} others", count - used));
        }
        if let Some(p) = positions_local.iter().find(|p| !p.is_finite()) {
            return refused("positions", "finite numbers", p.to_string());
        }
        // No sign, no fraction, an exponent of a normal number.
        let fraction = scale.to_bits() & ((1 << (f64::MANTISSA_DIGITS - 1)) - 1);
        if !(scale.is_normal() && *scale > 0.0 && fraction == 0) {
            return refused("scale", "a power of two", scale.to_string());
        }
        if !center.is_finite() {
            return refused("center", "finite numbers", center.to_string());
        }
        let faces = triangles.len().saturating_add(*dropped_faces);
        if faces > i32::MAX as usize {
            return refused("dropped_faces", "fewer than 2^31 faces", faces.to_string());
        }
        let expected = if *dropped_faces > 0 { triangles.len() } else { 0 };
        let rising =
            source_faces.is_sorted_by(|a, b| a < b) && source_faces.last().is_none_or(|&f| (f as usize) < faces);
        if source_faces.len() != expected || !rising {
            let got = format!("{} rows for {} triangles", source_faces.len(), triangles.len());
            return refused("source_faces", "a rising row for each triangle where faces were dropped, else none", got);
        }
        check_coordinates(alpha_test.as_ref(), count)?;
        Ok(Self::assembled(stored))
    }
    fn assembled(stored: Stored) -> Self {
        let Stored { positions_local, triangles, source_faces, dropped_faces, scale, center, alpha_test } = stored;
        let bounds_local = Aabb::from_points(positions_local.iter().map(|p| p.as_dvec3()));
        Self {
            id: next_id(),
            positions_local,
            triangles,
            source_faces,
            mesh_from_local: DAffine3::from_mat3_translation(DMat3::from_diagonal(DVec3::splat(scale)), center),
            bounds_local,
            dropped_faces,
            alpha_test: alpha_test.map(Box::new),
            content_hash: OnceLock::new(),
            border_edges: OnceLock::new(),
            clusters: OnceLock::new(),
        }
    }
    /// A number no other mesh of this process has; caches key on it.
    pub fn id(&self) -> u64 {
        self.id
    }
    /// Vertices in the local frame, magnitudes at most 1.
    pub fn positions_local(&self) -> &[Vec3] {
        &self.positions_local
    }
    /// Indices into [`Mesh::positions_local`].
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }
    /// The row of the caller's face array a triangle came from.
    pub fn source_face(&self, triangle: usize) -> u32 {
        if self.source_faces.is_empty() { triangle as u32 } else { self.source_faces[triangle] }
    }
    /// The triangle that came from a row of the caller's face array; nothing where that was dropped, and beyond the last.
    pub fn triangle_of(&self, face: usize) -> Option<usize> {
        if self.source_faces.is_empty() {
            return (face < self.triangles.len()).then_some(face);
        }
        self.source_faces.binary_search(&(face as u32)).ok()
    }
    /// The rows of the caller's face array that all triangles came from; empty where no face was dropped.
    pub fn source_faces(&self) -> &[u32] {
        &self.source_faces
    }
    /// A hash of all that pictures depend on, the same in every process; found at the first call. Numbers count by their
    /// value, so 0 and -0 are one.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn content_hash(&self, progress: &Progress) -> Result<[u8; 32]> {
        // Not `get_or_init`: a process that is forked while another thread hashes would wait for that thread for ever.
        let kept = &self.content_hash;
        if let Some(hash) = kept.get() {
            return Ok(*hash);
        }
        let hash = self.hashed(progress)?;
        let _ = kept.set(hash); // by another thread it is the same
        Ok(hash)
    }
    /// The hash, where it has been found.
    pub fn known_hash(&self) -> Option<[u8; 32]> {
        self.content_hash.get().copied()
    }
    /// Uniform power-of-two scale and translation from the local frame to the mesh's own.
    pub fn mesh_from_local(&self) -> &DAffine3 {
        &self.mesh_from_local
    }
    /// The box of the vertices, local frame.
    pub fn bounds_local(&self) -> &Aabb {
        &self.bounds_local
    }
    /// Boxes around runs of its triangles, found at the first call.
    pub(crate) fn clusters(&self) -> &Clusters {
        // As in `content_hash`: nobody waits. Two threads that ask at once find the same.
        if let Some(known) = self.clusters.get() {
            return known;
        }
        let extent = self.bounds_local.extent().as_vec3();
        let _ = self.clusters.set(Clusters::new(&self.positions_local, &self.triangles, extent));
        self.clusters.get().expect("set above")
    }
    /// Which points of the triangles exist; none where all do. Its texture coordinates are those of
    /// [`Mesh::positions_local`].
    pub fn alpha_test(&self) -> Option<&AlphaTest> {
        self.alpha_test.as_deref()
    }
    /// How many edges belong to one face only, corners at equal places counted as one: 0 of a closed mesh. Found at the first
    /// call.
    ///
    /// # Errors
    /// [`Error::Interrupted`].
    pub fn border_edges(&self, progress: &Progress) -> Result<usize> {
        // As in `content_hash`: nobody waits.
        if let Some(&known) = self.border_edges.get() {
            return Ok(known);
        }
        let found = border_edges(&self.positions_local, &self.triangles, progress)?;
        let _ = self.border_edges.set(found);
        Ok(found)
    }
    /// Faces left out because a vertex of theirs is not finite.
    pub fn dropped_faces(&self) -> usize {
        self.dropped_faces
    }
    fn hashed(&self, progress: &Progress) -> Result<[u8; 32]> {
        let mut digest = Digest::new(CONTENT, Numbers::Equal);
        digest.list(&self.mesh_from_local.to_cols_array());
        digest.watched_list(bytemuck::cast_slice::<_, f32>(&self.positions_local), || progress.check())?;
        digest.watched_list(self.triangles.as_flattened(), || progress.check())?;
        digest.count(self.dropped_faces);
        digest.watched_list(&self.source_faces, || progress.check())?;
        if let Some(test) = &self.alpha_test {
            test.add_to(&mut digest);
        }
        Ok(digest.finish())
    }
    /// Bytes held on the heap.
    pub fn memory(&self) -> usize {
        self.positions_local.capacity() * size_of::<Vec3>()
            + self.triangles.capacity() * size_of::<[u32; 3]>()
            + self.source_faces.capacity() * 4
            + self.clusters.get().map_or(0, Clusters::memory)
            + self.alpha_test.as_ref().map_or(0, |test| test.memory())
    }
}

/// An error unless each of so many vertices has texture coordinates.
fn check_coordinates(test: Option<&AlphaTest>, count: usize) -> Result<()> {
    match test.map(|test| test.parts().uv.len()) {
        Some(rows) if rows != count => {
            let expected = format!("a row for each of the {count} vertices");
            Err(Error::argument("alpha.uv", expected, format!("{rows} rows"), "give each vertex its coordinates"))
        }
        _ => Ok(()),
    }
}

/// The smallest power of two at least `x`, within the finite range; 1 for zero.
fn power_of_two_at_least(x: f64) -> f64 {
    if x == 0.0 {
        return 1.0;
    }
    // Clamped so that the scale and its inverse stay normal numbers.
    2f64.powi((x.log2().ceil() as i32).clamp(-1000, 1000))
}

/// Process-wide counter behind the ids of meshes and scenes.
pub(super) fn next_id() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    NEXT.fetch_add(1, Relaxed)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [[f64; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];

    #[test]
    fn local_frame_is_the_same_at_every_scale_and_place() {
        let near = Mesh::new(&TRIANGLE, &[[0, 1, 2]]).unwrap();
        for scale in [2f64.powi(-20), 2f64.powi(30), 2f64.powi(200)] {
            let moved = TRIANGLE.map(|p| [p[0] * scale + 5e5 * scale, p[1] * scale + 4e6 * scale, p[2] * scale]);
            let far = Mesh::new(&moved, &[[0, 1, 2]]).unwrap();
            assert_eq!(near.positions_local(), far.positions_local());
            let back = far.mesh_from_local().transform_point3(far.positions_local()[2].as_dvec3());
            assert_eq!(back.to_array(), moved[2]);
        }
    }

    #[test]
    fn what_was_stored_comes_back_and_nothing_else() {
        let broken = [TRIANGLE[0], TRIANGLE[1], [1e9, 0.1, -0.0], [f64::NAN; 3]];
        let mesh = Mesh::new(&broken, &[[0, 1, 3], [0, 1, 2]]).unwrap();
        let scale = mesh.mesh_from_local().matrix3.x_axis.x;
        let stored = Stored {
            positions_local: mesh.positions_local().to_vec(),
            triangles: mesh.triangles().to_vec(),
            source_faces: mesh.source_faces().to_vec(),
            dropped_faces: 1,
            scale,
            center: mesh.mesh_from_local().translation,
            alpha_test: None,
        };
        let back = Mesh::from_stored(stored.clone()).unwrap();
        let hash = |mesh: &Mesh| mesh.content_hash(&Progress::new()).unwrap();
        assert_eq!(hash(&back), hash(&mesh));
        assert_eq!(back.bounds_local(), mesh.bounds_local());
        let refused = |change: fn(&mut Stored)| {
            let mut changed = stored.clone();
            change(&mut changed);
            Mesh::from_stored(changed).unwrap_err()
        };
        assert!(matches!(refused(|s| s.triangles[0][1] = 3), Error::FaceIndex { face: 0, index: 3, count: 3 }));
        assert!(matches!(refused(|s| s.triangles.clear()), Error::EmptyScene { .. }));
        let invalid: [fn(&mut Stored); 12] = [
            |s| s.triangles[0] = [1, 0, 2],
            |s| s.positions_local.push(Vec3::ZERO),
            |s| s.positions_local[0].x = f32::NAN,
            |s| s.scale = 3.0,
            |s| s.scale = -2.0,
            |s| s.scale = f64::INFINITY,
            |s| s.scale = 0.0,
            |s| s.center.y = f64::NAN,
            |s| s.source_faces.clear(),
            |s| s.source_faces = vec![2],
            |s| s.dropped_faces = 0,
            |s| s.dropped_faces = usize::MAX,
        ];
        for change in invalid {
            assert!(matches!(refused(change), Error::InvalidArgument { .. }));
        }
    }

    #[test]
    fn broken_faces_are_counted_and_unused_vertices_have_no_say() {
        let vertices = [TRIANGLE[0], TRIANGLE[1], TRIANGLE[2], [f64::NAN, 0.0, 0.0], [1e9, 1e9, 1e9]];
        let mesh = Mesh::new(&vertices, &[[0, 1, 3], [0, 1, 2]]).unwrap();
        assert_eq!((mesh.dropped_faces(), mesh.triangles().len(), mesh.source_face(0)), (1, 1, 1));
        assert_eq!(mesh.positions_local().len(), 3);
        assert!(matches!(Mesh::new(&vertices, &[[0, 1, 3]]), Err(Error::EmptyScene { .. })));
        assert!(matches!(Mesh::new(&vertices, &[]), Err(Error::EmptyScene { .. })));
        assert_eq!(Mesh::new(&vertices, &[[0, 1, 5]]).unwrap_err(), Error::FaceIndex { face: 0, index: 5, count: 5 });
        assert_eq!(Mesh::new(&vertices, &[[0, 1, -1]]).unwrap_err(), Error::FaceIndex { face: 0, index: -1, count: 5 });
    }
}
