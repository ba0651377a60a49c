//! `_core.Scene`.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering::SeqCst};
use std::time::Duration;

use arc_swap::ArcSwapOption;
use glam::DAffine3;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

use super::arguments::items;
use super::convert::{
    argument_error, array, image, instance_of, mat4_from_rows, run_parallel, run_sized, run_watched, vec3_to_array,
};
use super::mesh::{PyMesh, SOON};
use super::scene_states::reduce_scene;
use super::state::{Reduced, first_eight};
use crate::digest::hex;
use crate::error::{Error, Result};
use crate::memory::{check_room, with_room};
use crate::progress::Progress;
use crate::scene::{Instance, Scene};
use crate::trace::Tracer;

/// Between two looks at whether another thread has built the acceleration structure.
const BUILD_POLL: Duration = Duration::from_millis(1);

/// Meshes and their instances; the package's `Scene` adds loading.
#[pyclass(name = "Scene", subclass, frozen, module = "shadowlab._core")]
pub struct PyScene {
    pub scene: Scene,
    /// Shared by copies.
    traced: Arc<Traced>,
}

/// The acceleration structure of a scene, once there is one.
struct Traced {
    tracer: ArcSwapOption<Tracer>,
    /// The last one that was built for this scene or one that differs in the places of instances alone: they share what
    /// meshes need.
    family: Arc<ArcSwapOption<Tracer>>,
    /// The process in which a thread builds the tracer, 0 for none. After a fork no other process builds for this one.
    builder: AtomicU32,
}

impl Traced {
    /// None yet.
    fn within(family: Arc<ArcSwapOption<Tracer>>) -> Arc<Self> {
        Arc::new(Self { tracer: ArcSwapOption::empty(), family, builder: AtomicU32::new(0) })
    }
}

impl From<Scene> for PyScene {
    fn from(scene: Scene) -> Self {
        Self { scene, traced: Traced::within(Arc::default()) }
    }
}

impl PyScene {
    /// The acceleration structure, built at the first call; threads that ask at once wait for one of them to build it.
    pub fn tracer(&self, py: Python<'_>, report: Option<&Py<PyAny>>) -> PyResult<Arc<Tracer>> {
        loop {
            if let Some(tracer) = self.traced.tracer.load_full() {
                return Ok(tracer);
            }
            if let Some(_building) = Building::begin(&self.traced.builder) {
                let report = report.map(|r| r.clone_ref(py));
                let before = self.traced.family.load_full();
                let tracer = run_watched(py, report, |progress| match before {
                    Some(before) => before.moved(&self.scene, progress),
                    None => Tracer::new(&self.scene, progress),
                })?;
                let tracer = Some(Arc::new(tracer));
                self.traced.family.store(tracer.clone());
                self.traced.tracer.store(tracer);
                continue;
            }
            py.detach(|| std::thread::sleep(BUILD_POLL));
            py.check_signals()?;
        }
    }
}

/// The right to build, given back when dropped.
struct Building<'a>(&'a AtomicU32);

impl<'a> Building<'a> {
    /// Nothing where another thread of this process has it.
    fn begin(builder: &'a AtomicU32) -> Option<Self> {
        let (process, holder) = (std::process::id(), builder.load(SeqCst));
        let mine = holder != process && builder.compare_exchange(holder, process, SeqCst, SeqCst).is_ok();
        mine.then_some(Self(builder))
    }
}

impl Drop for Building<'_> {
    fn drop(&mut self) {
        self.0.store(0, SeqCst);
    }
}

/// The hash of a scene, found where it is not known yet.
fn hash_of(py: Python<'_>, scene: &Scene) -> PyResult<[u8; 32]> {
    match scene.known_hash() {
        Some(hash) => Ok(hash),
        None => {
            let triangles: usize = scene.meshes().iter().map(|mesh| mesh.triangles().len()).sum();
            run_sized(py, triangles + scene.instances().len() > SOON, |progress| scene.content_hash(progress))
        }
    }
}

/// A placement from its matrix, row-major.
fn placement(py: Python<'_>, name: impl FnOnce() -> String, rows: &[f64; 16]) -> PyResult<DAffine3> {
    if rows[12..] != [0.0, 0.0, 0.0, 1.0] {
        let got = format!("{:?}", &rows[12..]);
        let fix = "a scene places meshes by affine maps; divide by the corner element or drop the projection";
        return Err(argument_error(py, &name(), "a last row of 0, 0, 0, 1", got, fix));
    }
    Ok(DAffine3::from_mat4(mat4_from_rows(rows)))
}

/// A scene argument.
pub fn scene<'py>(value: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyScene>> {
    scene_named(value, "scene")
}

/// A scene argument of another name.
pub fn scene_named<'py>(value: &Bound<'py, PyAny>, name: &str) -> PyResult<Bound<'py, PyScene>> {
    let fix = "make one with load_scene, Scene.from_trimesh, Scene.from_arrays or library.scene";
    instance_of(value, name, fix)
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
        let (mesh_index, transforms) = match (mesh_index, transforms) {
            (Some(mesh_index), Some(transforms)) => (mesh_index, transforms),
            (None, None) => {
                // Another scene: its geometry, which both share from then on.
                let fix = "give meshes with mesh_index and transforms, or one Scene";
                let other = instance_of::<Self>(meshes, "meshes", fix)?;
                let other = other.get();
                return Ok(Self { scene: other.scene.clone(), traced: Arc::clone(&other.traced) });
            }
            (given, _) => {
                let name = if given.is_none() { "mesh_index" } else { "transforms" };
                return Err(argument_error(py, name, "one for each instance", "none", "give both, or neither"));
            }
        };
        let fix = "make them with shadowlab._core.Mesh, or use Scene.from_arrays";
        let meshes = items(meshes, "meshes", "a sequence of Mesh", fix)?;
        let mesh = |item: &Bound<'_, PyAny>| Ok(Arc::clone(&instance_of::<PyMesh>(item, "meshes", fix)?.get().mesh));
        let meshes = meshes.iter().map(mesh).collect::<PyResult<Vec<_>>>()?;
        let mesh_index = array::<i64>(mesh_index, "mesh_index", &[None])?;
        let transforms = array::<f64>(transforms, "transforms", &[None, Some(4), Some(4)])?;
        let (mesh_index, transforms) = (mesh_index.as_slice()?, transforms.as_slice()?.as_chunks::<16>().0);
        if mesh_index.len() != transforms.len() {
            let expected = format!("one matrix for each of the {} rows of mesh_index", mesh_index.len());
            return Err(argument_error(py, "transforms", expected, transforms.len(), "give as many"));
        }
        let mut instances = Vec::with_capacity(transforms.len());
        for (i, (&mesh, rows)) in mesh_index.iter().zip(transforms).enumerate() {
            if i.is_multiple_of(SOON) {
                py.check_signals()?;
            }
            let world_from_mesh = placement(py, || format!("transforms[{i}]"), rows)?;
            let Some(mesh) = u32::try_from(mesh).ok().filter(|&mesh| (mesh as usize) < meshes.len()) else {
                let expected = format!("the place of one of the {} meshes, from 0", meshes.len());
                return Err(argument_error(py, &format!("mesh_index[{i}]"), expected, mesh, "give one of them"));
            };
            instances.push(Instance { mesh, world_from_mesh });
        }
        let points: usize =
            instances.iter().filter_map(|i| meshes.get(i.mesh as usize)).map(|m| m.triangles().len()).sum();
        Ok(run_parallel(py, points > SOON, |progress| Scene::watched(meshes, instances, progress))?.into())
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
    fn content_hash(&self, py: Python<'_>) -> PyResult<String> {
        Ok(hex(&hash_of(py, &self.scene)?))
    }
    /// The scene with some instances placed anew; the package's `Scene` says more.
    ///
    /// Parameters
    /// ----------
    /// indices : (K,) array_like of int
    ///     Which instances, each once.
    /// matrices : (K, 4, 4) array_like of float
    ///     World from mesh, one for each of them.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For another shape or type, an index out of range or given twice, and a matrix that is not affine and finite or
    ///     takes the scene out of the range of 64-bit floats.
    fn with_transforms(&self, indices: &Bound<'_, PyAny>, matrices: &Bound<'_, PyAny>) -> PyResult<Self> {
        let py = indices.py();
        let indices = array::<i64>(indices, "indices", &[None])?;
        let indices = indices.as_slice()?;
        let matrices = array::<f64>(matrices, "matrices", &[None, Some(4), Some(4)])?;
        let matrices = matrices.as_slice()?.as_chunks::<16>().0;
        let count = self.scene.instances().len();
        let index = |(k, &given): (usize, &i64)| {
            let found = usize::try_from(given).ok().filter(|&i| i < count);
            found.ok_or_else(|| {
                let expected = format!("the index of one of the {count} instances, from 0");
                argument_error(py, &format!("indices[{k}]"), expected, given, "give one of them")
            })
        };
        let indices = indices.iter().enumerate().map(index).collect::<PyResult<Vec<_>>>()?;
        let mut maps = Vec::with_capacity(matrices.len());
        for (k, rows) in matrices.iter().enumerate() {
            if k.is_multiple_of(SOON) {
                py.check_signals()?;
            }
            maps.push(placement(py, || format!("matrices[{k}]"), rows)?);
        }
        let points: usize = indices.iter().map(|&i| self.scene.mesh_of(i).triangles().len()).sum();
        let is_long = points + count > SOON;
        let scene = run_parallel(py, is_long, |progress| self.scene.with_transforms(&indices, &maps, progress))?;
        Ok(Self { scene, traced: Traced::within(Arc::clone(&self.traced.family)) })
    }
    fn __add__(&self, other: PyRef<'_, Self>) -> PyResult<Self> {
        let (py, added) = (other.py(), &other.scene);
        let is_long = self.scene.instances().len() + added.instances().len() > SOON;
        Ok(run_parallel(py, is_long, |progress| self.scene.joined_watched(added, progress))?.into())
    }
    fn __eq__(&self, py: Python<'_>, other: PyRef<'_, Self>) -> PyResult<bool> {
        let (a, b) = (&self.scene, &other.scene);
        let counts = |s: &Scene| (s.meshes().len(), s.instances().len(), s.triangle_count());
        Ok(a.is(b) || (counts(a) == counts(b) && hash_of(py, a)? == hash_of(py, b)?))
    }
    // Not by what `==` makes of both: the other side may answer with anything.
    fn __ne__(&self, py: Python<'_>, other: PyRef<'_, Self>) -> PyResult<bool> {
        Ok(!self.__eq__(py, other)?)
    }
    fn __hash__(&self, py: Python<'_>) -> PyResult<u64> {
        Ok(first_eight(&hash_of(py, &self.scene)?))
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
    /// Instances.
    #[getter]
    fn instance_count(&self) -> usize {
        self.scene.instances().len()
    }
    /// Meshes.
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
        let scene = &self.scene;
        let (vertices, faces) = run_sized(py, scene.triangle_count() > SOON as u64, |progress| baked(scene, progress))?;
        let (v, f) = (vertices.len() / 3, faces.len() / 3);
        Ok((image(py, vertices, [v, 3])?, image(py, faces, [f, 3])?))
    }
}

/// Vertices or triangles between two looks at whether to go on: some milliseconds of work.
const AT_ONCE: usize = 1 << 16;

/// World vertices and indices of all instances, one after the other.
fn baked(scene: &Scene, progress: &Progress) -> Result<(Vec<f64>, Vec<i32>)> {
    let count: u64 = (0..scene.instances().len()).map(|i| scene.mesh_of(i).positions_local().len() as u64).sum();
    if count > i32::MAX as u64 {
        let expected = format!("a scene of at most {} vertices, instances counted each time", i32::MAX);
        return Err(Error::argument("scene", expected, count, "take its meshes and transforms instead"));
    }
    check_room("scene", 24 * count + 12 * scene.triangle_count(), || format!("{count} vertices"))?;
    let mut vertices = with_room("scene", 3 * count as usize)?;
    let mut faces = with_room("scene", 3 * scene.triangle_count() as usize)?;
    for i in 0..scene.instances().len() {
        let to_world = scene.world_from_local(i);
        let (mesh, first) = (scene.mesh_of(i), (vertices.len() / 3) as i32);
        for points in mesh.positions_local().chunks(AT_ONCE) {
            progress.check()?;
            vertices.extend(points.iter().flat_map(|p| to_world.transform_point3(p.as_dvec3()).to_array()));
        }
        for triangles in mesh.triangles().chunks(AT_ONCE) {
            progress.check()?;
            faces.extend(triangles.iter().flatten().map(|&v| first + v as i32));
        }
    }
    Ok((vertices, faces))
}
