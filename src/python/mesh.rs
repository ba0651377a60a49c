//! `_core.Mesh`.

use std::sync::Arc;

use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;

use super::alpha_test::{alpha_test, alpha_test_object};
use super::convert::{OrRaise, array, image, number, rows3, run_sized, vec3, vec3_to_array};
use super::scene_states::reduce_mesh;
use super::state::{Reduced, first_eight};
use crate::digest::hex;
use crate::scene::{Mesh, Stored};

/// A triangle mesh, stored once however often it is placed.
#[pyclass(name = "Mesh", frozen, module = "shadowlab._core")]
pub struct PyMesh {
    pub mesh: Arc<Mesh>,
}

/// Triangles of which a mesh is made, hashed or written out in some milliseconds.
pub const SOON: usize = 1 << 15;

/// The hash of a mesh, found where it is not known yet.
fn hash_of(py: Python<'_>, mesh: &Mesh) -> PyResult<[u8; 32]> {
    match mesh.known_hash() {
        Some(hash) => Ok(hash),
        None => run_sized(py, mesh.triangles().len() > SOON, |progress| mesh.content_hash(progress)),
    }
}

#[pymethods]
impl PyMesh {
    #[new]
    #[pyo3(signature = (vertices, faces, *, alpha=None))]
    fn new(vertices: &Bound<'_, PyAny>, faces: &Bound<'_, PyAny>, alpha: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let py = vertices.py();
        let vertices = array::<f64>(vertices, "vertices", &[None, Some(3)])?;
        let faces = array::<i64>(faces, "faces", &[None, Some(3)])?;
        let (vertices, faces) = (rows3(&vertices)?, rows3(&faces)?);
        let alpha = alpha.map(alpha_test).transpose()?;
        let mesh = run_sized(py, faces.len() > SOON, |progress| Mesh::watched(vertices, faces, alpha, progress))?;
        Ok(Self { mesh: Arc::new(mesh) })
    }
    /// The mesh of vertices in its stored frame, kept bit for bit: what `positions_local` and `frame` give.
    ///
    /// Parameters
    /// ----------
    /// positions : (V, 3) array_like of float32
    ///     In units of `scale`, relative to `center`.
    /// faces : (M, 3) array_like of int
    ///     Rows of `positions`.
    /// scale : float
    ///     A power of two.
    /// center : (3,) array_like
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For numbers that are not finite, a scale that is no power of two, or another shape.
    /// SceneError
    ///     For an index out of range, or no face.
    #[staticmethod]
    fn from_local(
        positions: &Bound<'_, PyAny>,
        faces: &Bound<'_, PyAny>,
        scale: &Bound<'_, PyAny>,
        center: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let py = positions.py();
        let scale = number(scale, "scale", "give a power of two")?;
        let positions = array::<f32>(positions, "positions", &[None, Some(3)])?;
        let faces = array::<i64>(faces, "faces", &[None, Some(3)])?;
        let center = vec3(center, "center")?;
        let (positions, faces) = (rows3(&positions)?, rows3(&faces)?);
        let mesh = py.detach(|| {
            // What is no index is one too many.
            let index = |i: i64| u32::try_from(i).unwrap_or(u32::MAX);
            Mesh::from_stored(Stored {
                positions_local: positions.iter().map(|&p| p.into()).collect(),
                triangles: faces.iter().map(|face| face.map(index)).collect(),
                source_faces: Vec::new(),
                dropped_faces: 0,
                scale,
                center,
                alpha_test: None,
            })
        });
        Ok(Self { mesh: Arc::new(mesh.or_raise(py)?) })
    }
    /// (V, 3) float32: vertices as they are stored, relative to the frame's center and in units of its scale.
    #[getter]
    fn positions_local<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f32>>> {
        let points = self.mesh.positions_local();
        image(py, points.iter().flat_map(|p| p.to_array()).collect(), [points.len(), 3])
    }
    /// (scale, center (3,) float64) of the frame in which vertices are stored: `vertices` is center + scale * positions_local.
    #[getter]
    fn frame<'py>(&self, py: Python<'py>) -> (f64, Bound<'py, PyArray1<f64>>) {
        let frame = self.mesh.mesh_from_local();
        (frame.matrix3.x_axis.x, vec3_to_array(py, frame.translation))
    }
    /// Hexadecimal hash of all that pictures depend on, the same in every process; see `Scene.content_hash`.
    #[getter]
    fn content_hash(&self, py: Python<'_>) -> PyResult<String> {
        Ok(hex(&hash_of(py, &self.mesh)?))
    }
    fn __eq__(&self, py: Python<'_>, other: PyRef<'_, Self>) -> PyResult<bool> {
        let (a, b) = (&self.mesh, &other.mesh);
        Ok(Arc::ptr_eq(a, b) || hash_of(py, a)? == hash_of(py, b)?)
    }
    // Not by what `==` makes of both: the other side may answer with anything.
    fn __ne__(&self, py: Python<'_>, other: PyRef<'_, Self>) -> PyResult<bool> {
        Ok(!self.__eq__(py, other)?)
    }
    fn __hash__(&self, py: Python<'_>) -> PyResult<u64> {
        Ok(first_eight(&hash_of(py, &self.mesh)?))
    }
    fn __copy__<'py>(slf: &Bound<'py, Self>) -> Bound<'py, Self> {
        slf.clone()
    }
    fn __deepcopy__<'py>(slf: &Bound<'py, Self>, _memo: &Bound<'py, PyAny>) -> Bound<'py, Self> {
        slf.clone()
    }
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduce_mesh(py, &self.mesh)
    }
    /// Triangles.
    #[getter]
    fn triangle_count(&self) -> usize {
        self.mesh.triangles().len()
    }
    /// Vertices.
    #[getter]
    fn vertex_count(&self) -> usize {
        self.mesh.positions_local().len()
    }
    /// Faces left out because a vertex of theirs is not finite.
    #[getter]
    fn dropped_faces(&self) -> usize {
        self.mesh.dropped_faces()
    }
    /// Bytes that the mesh takes.
    #[getter]
    fn memory(&self) -> usize {
        self.mesh.memory()
    }
    /// Which points of the triangles exist, with texture coordinates for each of `vertices`; None where all do.
    #[getter]
    fn alpha<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.mesh.alpha_test().map(|test| alpha_test_object(py, test)).transpose()
    }
    /// (V, 3) float64, the mesh's own frame, as every consumer sees them (24 bits of the mesh's extent).
    #[getter]
    fn vertices<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let to_mesh = self.mesh.mesh_from_local();
        let points = self.mesh.positions_local();
        let flat: Vec<f64> = points.iter().flat_map(|p| to_mesh.transform_point3(p.as_dvec3()).to_array()).collect();
        image(py, flat, [points.len(), 3])
    }
    /// (M, 3) int32.
    #[getter]
    fn faces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<i32>>> {
        let triangles = self.mesh.triangles();
        let flat: Vec<i32> = triangles.iter().flatten().map(|&i| i as i32).collect();
        image(py, flat, [triangles.len(), 3])
    }
    fn __repr__(&self) -> String {
        format!("Mesh({} vertices, {} triangles)", self.vertex_count(), self.triangle_count())
    }
}
