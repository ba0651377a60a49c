//! `Camera.from_matrices`: matrices of any convention as the core reads them.

use glam::{DMat4, DVec4};
use pyo3::prelude::*;

use super::convert::{OrRaise, argument_error, array, mat4_from_rows, number};
use super::parameterization::convention as convention_of;
use crate::scene::Camera;

/// The camera of a view and a projection matrix that are written as a convention says.
pub fn from_matrices(
    view: &Bound<'_, PyAny>,
    projection: &Bound<'_, PyAny>,
    convention: Option<&Bound<'_, PyAny>>,
    far: Option<&Bound<'_, PyAny>>,
) -> PyResult<Camera> {
    let py = view.py();
    let matrix = |value: &Bound<'_, PyAny>, name: &str| -> PyResult<DMat4> {
        Ok(mat4_from_rows(array::<f64>(value, name, &[Some(4), Some(4)])?.as_slice()?))
    };
    let (mut view, mut projection) = (matrix(view, "view")?, matrix(projection, "projection")?);
    let far = far.map(|value| number(value, "far", "give the depth of the far plane, world units")).transpose()?;
    let mut depths = [0.0, 1.0];
    if let Some(convention) = convention {
        let convention = convention_of(convention)?;
        if convention.getattr("vectors")?.extract::<String>()? == "row" {
            (view, projection) = (view.transpose(), projection.transpose());
        }
        // The axes of their world are ours in another order, with signs: the inverse is the transpose.
        view *= matrix(&convention.getattr("world_from_their_world")?, "axes")?.transpose();
        let maps = array::<f64>(&convention.getattr("map_from_ndc")?, "tile", &[None, Some(4), Some(4)])?;
        let [map] = maps.as_slice()?.as_chunks::<16>().0 else {
            let fix = "a camera has one picture; name its tile";
            return Err(argument_error(py, "convention", "one tile", "several", fix));
        };
        let map = mat4_from_rows(map);
        let w = projection.row(3);
        let undone = |i: usize| -> DVec4 { (projection.row(i) - map.row(i).w * w) / map.row(i)[i] };
        projection = DMat4::from_cols(undone(0), undone(1), projection.row(2), w).transpose();
        let (low, high): (f64, f64) = convention.getattr("z_range")?.extract()?;
        depths = if convention.getattr("reversed_z")?.extract()? { [high, low] } else { [low, high] };
    }
    Camera::from_matrices(&view, &projection, depths, far).or_raise(py)
}
