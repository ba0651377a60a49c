//! `_core.Technique` and the registry's table.

use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::PyTypeInfo;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyDict, PyFloat, PyInt, PyList, PyString, PyTuple};

use super::arguments::{items, word};
use super::camera::{PyCamera, camera};
use super::convert::{OrRaise, argument_error, array, number, run_sized, run_watched, shown, texels};
use super::exceptions::refusable;
use super::light::light;
use super::map_states::{read_settings, write_settings};
use super::parameterization::PyParameterization;
use super::samples::{Given, given};
use super::scene::{PyScene, scene};
use super::settings::{settings_dict, value_text};
use super::state::{Fault, Reader, Reduced, State, Writer, by_state, reduce};
use crate::focus::Samples;
use crate::parameterization::Value;
use crate::progress::Progress;
use crate::survey;
use crate::techniques::{self, Default, Holds, Needs, Technique};

/// Maps times instances, or times samples, that take some milliseconds.
const SOON: usize = 1 << 15;

/// A technique with its settings.
#[pyclass(name = "Technique", frozen, eq, hash, module = "shadowlab")]
pub struct PyTechnique {
    technique: Box<dyn Technique>,
}

by_state!(PyTechnique);

impl State for PyTechnique {
    const NAME: &'static str = "Technique";
    fn write(&self, to: &mut Writer) {
        to.text(self.technique.spec().name);
        write_settings(&self.technique.settings(), to);
    }
    fn read(from: &mut Reader<'_>) -> Result<Self, Fault> {
        let (name, settings) = (from.text()?, read_settings(from)?);
        let given: Vec<_> = settings.into_iter().map(|(name, value)| (name.to_string(), value)).collect();
        Ok(Self { technique: techniques::technique(&name, &given).map_err(|e| e.to_string())? })
    }
}

#[pymethods]
impl PyTechnique {
    /// The technique of that name; parameters by keyword, as `techniques()` lists them.
    #[new]
    #[pyo3(signature = (name, **params))]
    fn new(py: Python<'_>, name: &Bound<'_, PyAny>, params: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let name = word(name, "name", "the name of a technique")?;
        let mut given = Vec::new();
        for (key, value) in params.into_iter().flatten() {
            let key = word(&key, "params", "names of parameters")?;
            let value = value_from_object(&value, &key)?;
            given.push((key, value));
        }
        Ok(Self { technique: techniques::technique(&name, &given).or_raise(py)? })
    }
    /// Name in the registry.
    #[getter]
    fn name(&self) -> &'static str {
        self.technique.spec().name
    }
    /// Every parameter with its value.
    #[getter]
    fn settings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        settings_dict(py, &self.technique.settings())
    }
    /// Whether it looks at what the camera sees; see `samples` of `parameterize`.
    #[getter]
    fn needs_samples(&self) -> bool {
        self.technique.needs() != Needs::Nothing
    }
    /// Whether it looks at which visible surfaces are in shadow.
    #[getter]
    fn needs_shadows(&self) -> bool {
        self.technique.needs() == Needs::Shadows
    }
    /// The same technique with maps for the receivers' body, as papers have it: `range=body` and `fit=exact` where it looks at
    /// samples, and of a search at visible edges the published warp distance. Techniques inside it likewise.
    fn by_body(&self, py: Python<'_>) -> PyResult<Self> {
        Ok(Self { technique: techniques::by_body(self.technique.as_ref()).or_raise(py)? })
    }
    /// What all of its maps hold: "shadow", visible receivers in shadow and their neighbours; "seen", all visible receivers; or
    /// "body", whatever can be seen. Of techniques inside it the most.
    #[getter]
    fn holds(&self, py: Python<'_>) -> PyResult<&'static str> {
        Ok(match techniques::holds(self.technique.as_ref()).or_raise(py)? {
            Holds::Shadow => "shadow",
            Holds::Seen => "seen",
            Holds::Body => "body",
        })
    }
    /// The same technique with slack around the samples that its maps hold, so that they can be held while the camera moves.
    /// Techniques inside it likewise.
    ///
    /// Parameters
    /// ----------
    /// slack : float
    ///     Factor by which a map is larger, along each side, than what its samples span in it, 1 to 2.
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     A slack out of range, or a technique that does not fit each of its maps to samples.
    fn with_slack(&self, py: Python<'_>, slack: &Bound<'_, PyAny>) -> PyResult<Self> {
        let slack = number(slack, "slack", "1.08 is a good start")?;
        Ok(Self { technique: techniques::with_slack(self.technique.as_ref(), slack).or_raise(py)? })
    }
    /// The text that makes the technique again, with the settings that are not the default: `sl.technique(text)`.
    #[getter]
    fn text(&self) -> String {
        techniques::text_of(self.technique.as_ref())
    }
    /// The maps of this technique for a scene, camera and light.
    ///
    /// Parameters
    /// ----------
    /// scene : Scene
    /// camera : Camera
    /// light : DirectionalLight, SpotLight or PointLight
    /// resolution : int or (int, int), optional
    ///     Texels along the sides of the map, width and height where they differ; 1024 where none are given. The fit keeps a
    ///     border of whole texels and `stable` snaps to them.
    /// samples : Samples or GBuffer, optional
    ///     What the camera sees, for techniques that need it (`needs_samples`); they draw a G-buffer of about 128 by 128
    ///     pixels, and a uniform map for its shadows, where none is given. Others leave it unread.
    ///
    /// Returns
    /// -------
    /// Parameterization
    ///
    /// Raises
    /// ------
    /// UnsupportedError
    ///     The technique does not serve this kind of light, or this view.
    /// ArgumentError
    ///     An argument of the wrong type or outside its range.
    #[pyo3(signature = (scene, camera, light, *, resolution=None, samples=None),
        text_signature = "($self, scene, camera, light, *, resolution=1024, samples=None)")]
    fn parameterize<'py>(
        &self,
        py: Python<'py>,
        #[pyo3(from_py_with = scene)] scene: Bound<'py, PyScene>,
        #[pyo3(from_py_with = camera)] camera: Bound<'py, PyCamera>,
        #[pyo3(from_py_with = light)] light: crate::Light,
        resolution: Option<&Bound<'py, PyAny>>,
        #[pyo3(from_py_with = given)] samples: Option<Given<'py>>,
    ) -> PyResult<PyParameterization> {
        let (scene, camera, technique) = (&scene.get().scene, &camera.get().camera, &self.technique);
        let (needs, resolution) = (technique.needs(), texels(resolution)?);
        let fitted = |samples: Option<&Samples>, progress: &Progress| {
            technique.parameterize_watched(scene, camera, &light, resolution, samples, progress)
        };
        if needs == Needs::Nothing {
            // What a map takes grows with the boxes that it looks at.
            let takes_long = technique.most_maps().saturating_mul(scene.instances().len()) > SOON;
            return Ok(run_sized(py, takes_long, |progress| fitted(None, progress))?.into());
        }
        technique.serves(&light).or_raise(py)?;
        if let Some(Given::GBuffer(gbuffer)) = &samples {
            gbuffer.get().check_samples(py)?;
        }
        let p = match samples {
            Some(Given::Samples(samples)) => {
                let samples = &samples.get().samples;
                let takes_long = technique.most_maps().saturating_mul(samples.len()) > SOON;
                run_sized(py, takes_long, |progress| fitted(Some(samples), progress))?
            }
            Some(Given::GBuffer(gbuffer)) => gbuffer.get().with_surfaces(py, |surfaces| {
                run_watched(py, None, |progress| {
                    let seen = survey::samples_of_surfaces(scene, camera, &light, *surfaces, needs, progress)?;
                    fitted(Some(&seen), progress)
                })
            })?,
            None => run_watched(py, None, |progress| {
                let seen = survey::samples_of_view(scene, camera, &light, needs, progress)?;
                fitted(seen.as_ref(), progress)
            })?,
        };
        Ok(p.into())
    }
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduce(py, self)
    }
    fn __repr__(&self) -> String {
        let settings = self.technique.settings();
        let settings: Vec<String> = settings.iter().map(|(k, v)| format!(", {k}={}", value_text(v))).collect();
        format!("Technique({:?}{})", self.name(), settings.concat())
    }
}

/// One dictionary a technique: name, title, source, lights, params.
#[pyfunction]
pub fn technique_specs(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let list = PyList::empty(py);
    for spec in techniques::specs() {
        let params = PyList::empty(py);
        for p in spec.params {
            let d = PyDict::new(py);
            d.set_item("name", p.name)?;
            d.set_item("unit", p.unit)?;
            match p.default {
                Default::Number(x) => d.set_item("default", x)?,
                Default::Integer(x) => d.set_item("default", x)?,
                Default::Flag(x) => d.set_item("default", x)?,
                Default::Choice(x) => d.set_item("default", x)?,
            }
            d.set_item("range", p.kind.to_string())?;
            d.set_item("doc", p.doc)?;
            params.append(d)?;
        }
        let lights =
            [("directional", spec.lights.directional), ("spot", spec.lights.spot), ("point", spec.lights.point)];
        let d = PyDict::new(py);
        d.set_item("name", spec.name)?;
        d.set_item("title", spec.title)?;
        d.set_item("source", spec.source)?;
        d.set_item("lights", lights.iter().filter(|l| l.1).map(|l| l.0).collect::<Vec<_>>())?;
        d.set_item("params", params)?;
        list.append(d)?;
    }
    Ok(list)
}

/// Words of parameters that have another name now: technique, parameter, the old word and the new one.
#[pyfunction]
pub fn renamed_words() -> Vec<(&'static str, &'static str, &'static str, &'static str)> {
    techniques::RENAMED.iter().map(|r| (r.technique, r.param, r.words[0], r.words[1])).collect()
}

/// The text of a technique or of its name; nothing for another type.
fn text_of_technique(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<String>> {
    if let Ok(technique) = value.cast::<PyTechnique>() {
        return Ok(Some(techniques::text_of(&*technique.get().technique)));
    }
    if value.is_instance_of::<PyString>() { word(value, name, WORDS).map(Some) } else { Ok(None) }
}

/// The texts of several techniques as one; nothing where one of them is none.
fn text_of_techniques(values: &Bound<'_, PyAny>, name: &str) -> PyResult<Option<String>> {
    let mut texts = Vec::new();
    for value in items(values, name, WORDS, FIX)? {
        let Some(text) = text_of_technique(&value, name)? else { return Ok(None) };
        texts.push(if text.contains(':') { format!("({text})") } else { text });
    }
    Ok((!texts.is_empty()).then(|| texts.join("/")))
}

/// What a parameter may be.
const WORDS: &str = "a number, several, a bool, a word or a technique";
const FIX: &str = "see shadowlab.techniques()";

fn value_from_object(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Value> {
    // bool first: it is an int to Python.
    if value.is_instance_of::<PyBool>() {
        return Ok(Value::Flag(value.is_truthy()?));
    }
    if value.is_instance_of::<PyInt>() {
        // One beyond 64 bits is out of every range, and is told as a number.
        return Ok(match value.extract::<i64>() {
            Ok(whole) => Value::Integer(whole),
            Err(_) => Value::Number(value.extract::<f64>().unwrap_or(f64::INFINITY)),
        });
    }
    if value.is_instance_of::<PyFloat>() {
        return Ok(Value::Number(value.extract()?));
    }
    if let Some(text) = text_of_technique(value, name)? {
        return Ok(Value::Choice(text));
    }
    if (value.is_instance_of::<PyList>() || value.is_instance_of::<PyTuple>())
        && let Some(text) = text_of_techniques(value, name)?
    {
        return Ok(Value::Choice(text));
    }
    let py = value.py();
    let numpy = py.import("numpy")?;
    let is_scalar = value.is_instance(&numpy.getattr("generic")?)?;
    if is_scalar || value.cast::<PyUntypedArray>().is_ok_and(|array| array.ndim() == 0) {
        let item = value.call_method0("item").map_err(|e| refused(value, name, refusable(py, e)))?;
        // Dates and records are nothing else.
        if [PyBool::type_object(py), PyInt::type_object(py), PyFloat::type_object(py), PyString::type_object(py)]
            .iter()
            .any(|plain| item.get_type().is(plain))
        {
            return value_from_object(&item, name);
        }
        return Err(refused(value, name, Ok(())));
    }
    // Texts and techniques among numbers are neither.
    match array::<f64>(value, name, &[None]) {
        Ok(list) => Ok(Value::Numbers(list.as_slice()?.to_vec())),
        Err(error) => Err(refused(value, name, refusable(py, error))),
    }
}

/// The error for a value that is none, unless another one is on its way that is no mistake of the caller's.
fn refused<T>(value: &Bound<'_, PyAny>, name: &str, cause: PyResult<T>) -> PyErr {
    cause.err().unwrap_or_else(|| argument_error(value.py(), name, WORDS, shown(value), FIX))
}
