//! `_core.Mesh` and `_core.Scene`.

use std::sync::{Arc, Mutex};

use glam::DAffine3;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use super::convert::{OrRaise, argument_error, array, image, instance_of, mat4_from_rows, rows3, vec3, vec3_to_array};
use super::scene_states::{reduce_mesh, reduce_scene};
use super::state::{Reduced, first_eight};
use crate::digest::hex;
use crate::progress::Progress;
use crate::scene::{Instance, Mesh, Scene, Stored};
use crate::trace::Tracer;

/// A triangle mesh, stored once however often it is placed.
#[pyclass(name = "Mesh", frozen, module = "shadowlab._core")]
pub struct PyMesh {
    pub mesh: Arc<Mesh>,
}

#[pymethods]
impl PyMesh {
    #[new]
    fn new(vertices: &Bound<'_, PyAny>, faces: &Bound<'_, PyAny>) -> PyResult<Self> {
        let py = vertices.py();
        let vertices = array::<f64>(vertices, "vertices", &[None, Some(3)])?;
        let faces = array::<i64>(faces, "faces", &[None, Some(3)])?;
        let (vertices, faces) = (rows3(&vertices)?, rows3(&faces)?);
        let mesh = py.detach(|| Mesh::new(vertices, faces)).or_raise(py)?;
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
        scale: f64,
        center: &Bound<'_, PyAny>,
    ) -> PyResult<Self> {
        let py = positions.py();
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
    fn content_hash(&self, py: Python<'_>) -> String {
        hex(&py.detach(|| self.mesh.content_hash()))
    }
    fn __eq__(&self, py: Python<'_>, other: PyRef<'_, Self>) -> bool {
        let (a, b) = (&self.mesh, &other.mesh);
        Arc::ptr_eq(a, b) || py.detach(|| a.content_hash() == b.content_hash())
    }
    fn __hash__(&self, py: Python<'_>) -> u64 {
        first_eight(&py.detach(|| self.mesh.content_hash()))
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
    #[getter]
    fn triangle_count(&self) -> usize {
        self.mesh.triangles().len()
    }
    #[getter]
    fn vertex_count(&self) -> usize {
        self.mesh.positions_local().len()
    }
    #[getter]
    fn dropped_faces(&self) -> usize {
        self.mesh.dropped_faces()
    }
    #[getter]
    fn memory(&self) -> usize {
        self.mesh.memory()
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

/// Meshes and their instances; the package's `Scene` adds loading and joining.
#[pyclass(name = "Scene", subclass, frozen, module = "shadowlab._core")]
pub struct PyScene {
    pub scene: Scene,
    tracer: Arc<Mutex<Option<Tracer>>>,
}

impl From<Scene> for PyScene {
    fn from(scene: Scene) -> Self {
        Self { scene, tracer: Arc::new(Mutex::new(None)) }
    }
}

impl PyScene {
    /// The acceleration structure, built at the first call.
    pub fn tracer(&self, progress: &Progress) -> crate::Result<Tracer> {
        let mut slot = self.tracer.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(tracer) = &*slot {
            return Ok(tracer.clone());
        }
        let tracer = Tracer::new(&self.scene, progress)?;
        *slot = Some(tracer.clone());
        Ok(tracer)
    }
}

/// A scene argument.
pub fn scene<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyScene>> {
    let fix = "make one with load_scene, Scene.from_trimesh, Scene.from_arrays or library.scene";
    instance_of(value, "scene", fix)
}

#[pymethods]
impl PyScene {
    #[new]
    #[pyo3(signature = (meshes, mesh_index=None, transforms=None))]
    fn new(
        meshes: &Bound<'_, PyAny>,
        mesh_index: Option<&Bound<'_, PyAny>>,
        transforms: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let py = meshes.py();
        let (Some(mesh_index), Some(transforms)) = (mesh_index, transforms) else {
            // Another scene: its geometry, which both share from then on.
            let other = scene(meshes)?;
            let other = other.get();
            return Ok(Self { scene: other.scene.clone(), tracer: Arc::clone(&other.tracer) });
        };
        let meshes: Vec<PyRef<'_, PyMesh>> = meshes.extract()?;
        let mesh_index = array::<i64>(mesh_index, "mesh_index", &[None])?;
        let transforms = array::<f64>(transforms, "transforms", &[None, Some(4), Some(4)])?;
        let (mesh_index, transforms) = (mesh_index.as_slice()?, transforms.as_slice()?.as_chunks::<16>().0);
        if mesh_index.len() != transforms.len() {
            let expected = format!("one matrix for each of the {} instances", mesh_index.len());
            return Err(argument_error(py, "transforms", expected, transforms.len(), "give as many"));
        }
        let mut instances = Vec::with_capacity(transforms.len());
        for (i, (&mesh, rows)) in mesh_index.iter().zip(transforms).enumerate() {
            if rows[12..] != [0.0, 0.0, 0.0, 1.0] {
                let name = format!("transforms[{i}]");
                let got = format!("{:?}", &rows[12..]);
                let fix = "a scene places meshes by affine maps; divide by the corner element or drop the projection";
                return Err(argument_error(py, &name, "a last row of 0, 0, 0, 1", got, fix));
            }
            let mesh = u32::try_from(mesh).unwrap_or(u32::MAX);
            instances.push(Instance { mesh, world_from_mesh: DAffine3::from_mat4(mat4_from_rows(rows)) });
        }
        let meshes: Vec<_> = meshes.iter().map(|m| m.mesh.clone()).collect();
        let scene = py.detach(|| Scene::new(meshes, instances)).or_raise(py)?;
        Ok(scene.into())
    }
    /// Hexadecimal hash of all that pictures depend on: 64 digits, the same in every process, on every machine and for
    /// every version of Python. Equal scenes have equal hashes.
    ///
    /// Meshes (vertices as stored, faces, and the rows that these had before faces were dropped), their order, and the
    /// instances with their order and transforms count. Names, `source`, `recipe`, cameras and lights do not. Computed at
    /// the first use and kept.
    ///
    /// Examples
    /// --------
    /// >>> import shadowlab as sl
    /// >>> a, b = (sl.library.scene("robots") for _ in range(2))
    /// >>> a.content_hash == b.content_hash, a == b, a is b
    /// (True, True, False)
    #[getter]
    fn content_hash(&self, py: Python<'_>) -> String {
        hex(&py.detach(|| self.scene.content_hash()))
    }
    fn __eq__(&self, py: Python<'_>, other: PyRef<'_, Self>) -> bool {
        let (a, b) = (&self.scene, &other.scene);
        let counts = |s: &Scene| (s.meshes().len(), s.instances().len(), s.triangle_count());
        a.is(b) || (counts(a) == counts(b) && py.detach(|| a.content_hash() == b.content_hash()))
    }
    fn __hash__(&self, py: Python<'_>) -> u64 {
        first_eight(&py.detach(|| self.scene.content_hash()))
    }
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduce_scene(py, &self.scene)
    }
    /// The meshes, each once.
    #[getter]
    fn meshes(&self) -> Vec<PyMesh> {
        self.scene.meshes().iter().map(|m| PyMesh { mesh: m.clone() }).collect()
    }
    /// (I,) int64: which mesh each instance places.
    #[getter]
    fn mesh_index<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        PyArray1::from_vec(py, self.scene.instances().iter().map(|i| i64::from(i.mesh)).collect())
    }
    /// (I, 4, 4) float64: world from mesh.
    #[getter]
    fn transforms<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray3<f64>>> {
        let instances = self.scene.instances();
        let rows = |i: &Instance| glam::DMat4::from(i.world_from_mesh).transpose().to_cols_array();
        image(py, instances.iter().flat_map(rows).collect(), [instances.len(), 4, 4])
    }
    /// (2, 3) float64: smallest and largest corner of the vertices that triangles use.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let b = self.scene.bounds();
        PyArray1::from_slice(py, &[b.min.to_array(), b.max.to_array()].concat()).reshape([2, 3])
    }
    /// (3,) float64: the middle of the bounds, which single-precision positions are relative to.
    #[getter]
    fn origin<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vec3_to_array(py, self.scene.origin())
    }
    /// Triangles, instances counted each time.
    #[getter]
    fn triangle_count(&self) -> u64 {
        self.scene.triangle_count()
    }
    #[getter]
    fn instance_count(&self) -> usize {
        self.scene.instances().len()
    }
    #[getter]
    fn mesh_count(&self) -> usize {
        self.scene.meshes().len()
    }
    /// Faces left out because a vertex of theirs is not finite.
    #[getter]
    fn dropped_faces(&self) -> usize {
        self.scene.meshes().iter().map(|m| m.dropped_faces()).sum()
    }
    /// Everything baked into world space: vertices (V, 3) float64, faces (F, 3) int32, in instance order.
    #[allow(clippy::type_complexity)]
    fn to_arrays<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<i32>>)> {
        let (mut vertices, mut faces) = (Vec::new(), Vec::new());
        py.detach(|| {
            for (i, to_world) in self.scene.world_from_local().iter().enumerate() {
                let mesh = self.scene.mesh_of(i);
                let first = (vertices.len() / 3) as i32;
                let points = mesh.positions_local().iter();
                vertices.extend(points.flat_map(|p| to_world.transform_point3(p.as_dvec3()).to_array()));
                faces.extend(mesh.triangles().iter().flatten().map(|&v| first + v as i32));
            }
        });
        let (v, f) = (vertices.len() / 3, faces.len() / 3);
        Ok((image(py, vertices, [v, 3])?, image(py, faces, [f, 3])?))
    }
}
