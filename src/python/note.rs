//! `_core.Note`.

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};

use super::arguments::{items, whole, word};
use super::convert::{OrRaise, argument_error, number, shown};
use super::state::{Fault, Reader, Reduced, State, Writer, reduce};
use crate::error::Error;
use crate::note::{Detail, Kind, Note, Span};

/// One thing to know about a result: what a technique could not do as asked, or what speaks against a matrix.
///
/// `str(note)` is its text; ``"; ".join(map(str, notes))`` is that of several. Code asks for `kind` and never reads the text.
///
/// Parameters
/// ----------
/// kind : str
///     One of `KINDS`.
/// details : sequence of str
///     What the kind alone does not say; `KINDS` lists the details of each kind.
/// values : mapping of str to number or (least, most), optional
///     The numbers that this kind with these details has, by name.
/// maps : sequence of int, optional
///     The maps that the note is about, counted from 0; all maps of the result where none are given.
///
/// Raises
/// ------
/// UnknownNameError
///     For a kind, or a detail of it, that does not exist.
/// ArgumentError
///     For other numbers than the kind has, and maps that are no indices.
///
/// Notes
/// -----
/// The kinds, with their numbers (lengths and depths in world units):
///
/// - "nothing_seen", "nothing_lit": the camera sees no part of the scene, or none that the light reaches.
/// - "no_warp": the map is a uniform one; `reasons` say why. `sine` of "below_min_sin"; `focus_depth` of "focus_has_share" and
///   "focus_before_body"; `samples` of "no_sample"; `plane_x`, `plane_y`, `plane_z`, `plane_d`, `behind` and `corners` of
///   "rays_behind_eye"; `samples` and `lost` of "samples_lost".
/// - "no_logarithm": a logarithmic map without its logarithm.
/// - "warp_distance_raised": from `given` to `least`.
/// - "warp_weakened": the strength of XPSM from `given` to `most`, per world unit.
/// - "slide_raised": the slide of PSM from `given` to `least`, for depths from `near` to `far`.
/// - "light_in_box": a placed light is inside a mesh's box; its map begins at `distance`.
/// - "stable": a stable map under a placed light covers all that the light reaches.
/// - "cover_unused": a setting of depth splits without effect.
/// - "no_lit_sample", "no_shadow": no visible surface faces the light, or none is in shadow.
/// - "covers_samples": depth splits cover camera depths `near` to `far` alone.
/// - "border_outside": a `border` between depth splits is not between the camera's planes `near` and `far`.
/// - "face_unseen": no map for the faces in `details`.
/// - "check_matrix": a given matrix is hardly a map of the light; `reasons` say why. `miss` of "misses_light", the sine by which
///   its rows miss the light; `share` of "depth_below_zero", per cent of the visible surface.
///
/// Examples
/// --------
/// >>> import shadowlab as sl
/// >>> scene = sl.library.scene("robots")
/// >>> along = sl.DirectionalLight(scene.camera.forward)
/// >>> note, = sl.technique("lispsm").by_body().parameterize(scene, scene.camera, along).notes
/// >>> note.kind, note.details
/// ('no_warp', ('light_along_axis',))
/// >>> str(note)
/// 'no warp, a uniform map: the light runs along the view'
#[pyclass(name = "Note", frozen, eq, hash, module = "shadowlab._core")]
#[derive(Clone, PartialEq, Eq, Hash)]
pub struct PyNote {
    pub note: Note,
}

impl From<Note> for PyNote {
    fn from(note: Note) -> Self {
        Self { note }
    }
}

impl State for PyNote {
    const NAME: &'static str = "Note";
    fn write(&self, to: &mut Writer) {
        let note = &self.note;
        to.text(note.kind().name());
        to.count(note.details().len() as u64);
        note.details().iter().for_each(|detail| to.text(detail.name()));
        // Their names follow from kind and details.
        note.values().iter().for_each(|(_, span)| to.numbers(&[span.least, span.most]));
        // One more than there are, so that 0 is "all maps".
        to.count(note.maps().map_or(0, |maps| 1 + maps.len() as u64));
        note.maps().into_iter().flatten().for_each(|&map| to.count(map as u64));
    }
    fn read(from: &mut Reader<'_>) -> Result<Self, Fault> {
        let kind = from.text()?;
        let kind = Kind::named(&kind).ok_or_else(|| format!("a note is of the kind {kind:?}"))?;
        let details = from.list(|from| {
            let detail = from.text()?;
            Detail::named(kind, &detail).ok_or_else(|| format!("a note has the detail {detail:?}"))
        })?;
        let zeros: Vec<_> = Note::names(kind, &details).into_iter().map(|name| (name, 0.0)).collect();
        let mut spans = Vec::new();
        for _ in &zeros {
            let [least, most] = from.numbers()?;
            spans.push(Span { least, most });
        }
        let maps = match from.count::<u64>()? {
            0 => None,
            count => Some((1..count).map(|_| from.count()).collect::<Result<Vec<usize>, Fault>>()?),
        };
        Ok(Note::detailed(kind, &details, &zeros).spanning(spans).about(maps).into())
    }
}

/// Notes as Python has them.
pub fn notes_tuple<'py>(py: Python<'py>, notes: &[Note]) -> PyResult<Bound<'py, PyTuple>> {
    PyTuple::new(py, notes.iter().cloned().map(PyNote::from))
}

/// A number, or both ends of a range.
fn span_of(value: &Bound<'_, PyAny>, name: &str) -> PyResult<Span> {
    let fix = "give a number, or a pair (least, most)";
    if !value.is_instance_of::<PyTuple>() && !value.is_instance_of::<PyList>() {
        return Ok(Span::of(number(value, name, fix)?));
    }
    let [least, most] = items(value, name, "(least, most)", fix)?
        .try_into()
        .map_err(|_: Vec<_>| argument_error(value.py(), name, "(least, most)", shown(value), fix))?;
    match (number(&least, name, fix)?, number(&most, name, fix)?) {
        (least, most) if least <= most => Ok(Span { least, most }),
        _ => Err(argument_error(value.py(), name, "(least, most)", shown(value), "put the lesser number first")),
    }
}

/// Indices of maps, at least one; nothing for all maps.
fn maps_of(value: Option<&Bound<'_, PyAny>>) -> PyResult<Option<Vec<usize>>> {
    let Some(value) = value else { return Ok(None) };
    let expected = "indices of maps, from 0, at least one";
    let fix = "give a list";
    let index = |item: &Bound<'_, PyAny>| Ok(whole(item, "maps", [0, i64::MAX], fix)? as usize);
    let maps = items(value, "maps", expected, fix)?.iter().map(index).collect::<PyResult<Vec<_>>>()?;
    match maps.is_empty() {
        true => Err(argument_error(value.py(), "maps", expected, "none", "give None for all maps")),
        false => Ok(Some(maps)),
    }
}

#[pymethods]
impl PyNote {
    /// Every kind with its details.
    #[classattr]
    #[pyo3(name = "KINDS")]
    fn kinds(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
        let kinds = PyDict::new(py);
        for kind in Kind::ALL {
            let details = Detail::ALL.iter().filter(|detail| detail.kind() == *kind).map(|detail| detail.name());
            kinds.set_item(kind.name(), PyTuple::new(py, details.collect::<Vec<_>>())?)?;
        }
        Ok(kinds)
    }
    #[new]
    #[pyo3(signature = (kind, details=None, values=None, maps=None))]
    fn new(
        py: Python<'_>,
        kind: &Bound<'_, PyAny>,
        details: Option<&Bound<'_, PyAny>>,
        values: Option<&Bound<'_, PyAny>>,
        maps: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let unknown = |what: &'static str, name: &str, valid: Vec<String>| Error::UnknownName {
            kind: what.into(),
            name: name.to_string(),
            valid,
        };
        let kinds = || Kind::ALL.iter().map(|kind| kind.name().to_string()).collect();
        let name = word(kind, "kind", "a kind of note, one of Note.KINDS")?;
        let kind = Kind::named(&name).ok_or_else(|| unknown("kind of note", &name, kinds())).or_raise(py)?;
        let expected = "names of details";
        let details = details.map_or_else(|| Ok(Vec::new()), |list| items(list, "details", expected, "give a list"))?;
        let details = details.iter().map(|item| word(item, "details", expected)).collect::<PyResult<Vec<_>>>()?;
        let of_kind = || Detail::ALL.iter().filter(|d| d.kind() == kind).map(|d| d.name().to_string()).collect();
        let detail = |name: &String| Detail::named(kind, name).ok_or_else(|| unknown("detail", name, of_kind()));
        let details = details.iter().map(detail).collect::<crate::Result<Vec<_>>>().or_raise(py)?;
        let names = Note::names(kind, &details);
        let given = values.map_or_else(|| Some(PyDict::new(py)), |values| values.cast::<PyDict>().ok().cloned());
        let given = given.filter(|dict| dict.len() == names.len());
        let given = given.filter(|dict| names.iter().all(|name| dict.contains(name).unwrap_or(false)));
        let Some(given) = given else {
            let expected =
                if names.is_empty() { "no numbers".into() } else { format!("a dict of {}", names.join(", ")) };
            let got = values.map_or_else(|| "none".to_string(), shown);
            return Err(argument_error(py, "values", expected, got, "give the numbers that this kind of note has"));
        };
        let spans: Vec<_> =
            names.iter().map(|name| span_of(&given.as_any().get_item(name)?, name)).collect::<PyResult<_>>()?;
        let zeros: Vec<_> = names.iter().map(|name| (*name, 0.0)).collect();
        Ok(Note::detailed(kind, &details, &zeros).spanning(spans).about(maps_of(maps)?).into())
    }
    /// What it is about: one of `KINDS`.
    #[getter]
    fn kind(&self) -> &'static str {
        self.note.kind().name()
    }
    /// What the kind alone does not say: why there is no warp, which faces have no map, what speaks against a matrix.
    #[getter]
    fn details<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.note.details().iter().map(|detail| detail.name()))
    }
    /// The text of each detail.
    #[getter]
    fn reasons<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        PyTuple::new(py, self.note.reasons())
    }
    /// Its numbers by name; (least, most) where they differ between maps.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let values = PyDict::new(py);
        for (name, span) in self.note.values() {
            if *span == Span::of(span.most) {
                values.set_item(name, span.most)?;
            } else {
                values.set_item(name, (span.least, span.most))?;
            }
        }
        Ok(values)
    }
    /// The maps that it is about, counted from 0; None where it is about all maps of the result. The text counts from 1.
    #[getter]
    fn maps<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyTuple>>> {
        self.note.maps().map(|maps| PyTuple::new(py, maps)).transpose()
    }
    /// The same note about other maps.
    ///
    /// Parameters
    /// ----------
    /// maps : sequence of int or None
    ///     Counted from 0; None for all maps of the result.
    ///
    /// Returns
    /// -------
    /// Note
    ///
    /// Raises
    /// ------
    /// ArgumentError
    ///     For maps that are no indices, and for none of them.
    #[pyo3(signature = (maps))]
    fn about(&self, maps: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        Ok(self.note.clone().about(maps_of(maps)?).into())
    }
    fn __str__(&self) -> String {
        self.note.to_string()
    }
    fn __repr__<'py>(&self, py: Python<'py>) -> PyResult<String> {
        let (kind, details, values, maps) = (self.kind(), self.details(py)?, self.values(py)?, self.maps(py)?);
        let mut text = format!("Note({kind:?}");
        if !details.is_empty() {
            text += &format!(", details={}", details.repr()?);
        }
        if !values.is_empty() {
            text += &format!(", values={}", values.repr()?);
        }
        if let Some(maps) = maps {
            text += &format!(", maps={}", maps.repr()?);
        }
        Ok(text + ")")
    }
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Reduced<'py>> {
        reduce(py, self)
    }
}
