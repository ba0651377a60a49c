//! What `Parameterization.from_matrix` is told of each map, checked.

use std::sync::Arc;

use glam::DVec4;
use pyo3::prelude::*;

use super::arguments::{items, word};
use super::convert::{argument_error, array, mat4_from_rows, number, shown, to_exception};
use crate::error::Error;
use crate::parameterization::{PiecewiseLinear, PostWarp, Rectilinear, Region};

/// Whether a matrix of sixteen row-major numbers has no inverse; the size of its rows has no say.
pub fn is_singular(rows: &[f64; 16]) -> bool {
    let mut scaled = *rows;
    for row in scaled.as_chunks_mut::<4>().0 {
        let largest = row.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        row.iter_mut().for_each(|x| *x /= largest);
    }
    !mat4_from_rows(&scaled).inverse().is_finite()
}

/// Near and far camera depth of each of `count` maps.
pub fn eye_depths(value: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<[f64; 2]>> {
    let depths = array::<f64>(value, "eye_depth", &[Some(count), Some(2)])?;
    let depths = depths.as_slice()?.as_chunks::<2>().0.to_vec();
    if let Some([near, far]) = depths.iter().find(|[near, far]| !(near.is_finite() && near < far)) {
        let (expected, fix) = ("a finite near depth and a far depth beyond it", "give (near, far) of each map");
        return Err(argument_error(value.py(), "eye_depth", expected, format!("({near}, {far})"), fix));
    }
    Ok(depths)
}

/// One thing for each of `count` maps.
pub fn each<T>(
    list: &Bound<'_, PyAny>,
    name: &str,
    count: usize,
    one: impl Fn(&Bound<'_, PyAny>) -> PyResult<T>,
) -> PyResult<Vec<T>> {
    let (expected, fix) = (format!("a list of {count}, one for each map"), "give one for each matrix");
    let items = items(list, name, &expected, fix)?;
    if items.len() != count {
        return Err(argument_error(list.py(), name, expected, shown(list), fix));
    }
    items.iter().map(one).collect()
}

/// None, ("log", scale, offset), or ("rectilinear", knots of x, knots of y).
pub fn post_warp_of(value: &Bound<'_, PyAny>) -> PyResult<PostWarp> {
    if value.is_none() {
        return Ok(PostWarp::None);
    }
    let expected = "None, (\"log\", scale, offset) with finite numbers and a scale other than 0, or \
                    (\"rectilinear\", x, y) with knots (N, 2)";
    let fix = "see Partition.post_warp_terms and post_warp_knots";
    let refused = || argument_error(value.py(), "post_warp", expected, shown(value), fix);
    let parts = items(value, "post_warp", expected, fix)?;
    let [kind, x, y] = parts.as_slice() else { return Err(refused()) };
    match word(kind, "post_warp", "\"log\" or \"rectilinear\"")?.as_str() {
        "rectilinear" => Ok(PostWarp::Rectilinear(Arc::new(Rectilinear { x: function_of(x)?, y: function_of(y)? }))),
        "log" => match (number(x, "post_warp", fix)?, number(y, "post_warp", fix)?) {
            (scale, offset) if scale.is_normal() && offset.is_finite() => Ok(PostWarp::Log { scale, offset }),
            _ => Err(refused()),
        },
        _ => Err(refused()),
    }
}

/// The function through knots (N, 2).
fn function_of(value: &Bound<'_, PyAny>) -> PyResult<PiecewiseLinear> {
    let knots = array::<f64>(value, "post_warp", &[None, Some(2)])?;
    PiecewiseLinear::new(knots.as_slice()?.as_chunks::<2>().0).map_err(|error| match error {
        Error::InvalidArgument { expected, got, fix, .. } => {
            argument_error(value.py(), "post_warp", expected, got, fix)
        }
        other => to_exception(value.py(), other),
    })
}

/// The rays of points whose functionals are not negative.
pub fn region_of(value: &Bound<'_, PyAny>) -> PyResult<Region> {
    if value.len().is_ok_and(|rows| rows == 0) {
        return Ok(Region::ALL);
    }
    let rows = array::<f64>(value, "regions", &[None, Some(4)])?;
    let rows: Vec<DVec4> = rows.as_slice()?.as_chunks::<4>().0.iter().map(|row| DVec4::from_array(*row)).collect();
    if rows.len() > Region::MOST || !rows.iter().all(|row| row.is_finite()) {
        let expected = format!("at most {} rows of finite numbers for each map", Region::MOST);
        let fix = "a region is an intersection of half-spaces through the light";
        return Err(argument_error(value.py(), "regions", expected, shown(value), fix));
    }
    Ok(Region::new(&rows))
}
