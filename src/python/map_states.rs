//! States of parameterizations, their maps and settings.

use std::sync::Arc;

use glam::{DMat4, DVec4};

use super::note::PyNote;
use super::parameterization::{PyParameterization, PyPartition, SELECTIONS};
use super::state::{Fault, Reader, State, Writer};
use crate::note::Note;
use crate::parameterization::{
    Factors, Parameterization, Partition, PiecewiseLinear, PostWarp, Rectilinear, Region, Value,
};
use crate::render::MAX_IMAGE_SIDE;

/// Kinds of post-warps.
const NO_WARP: u8 = 0;
const LOG: u8 = 1;
const RECTILINEAR: u8 = 2;

/// Writes settings.
pub fn write_settings(settings: &[(&str, Value)], to: &mut Writer) {
    to.count(settings.len() as u64);
    for (name, value) in settings {
        to.text(name);
        match value {
            Value::Number(x) => {
                to.kind(0);
                to.numbers(&[*x]);
            }
            Value::Integer(i) => {
                to.kind(1);
                to.whole(*i);
            }
            Value::Flag(flag) => {
                to.kind(2);
                to.kind(u8::from(*flag));
            }
            Value::Choice(word) => {
                to.kind(3);
                to.text(word);
            }
            Value::Numbers(list) => {
                to.kind(4);
                to.count(list.len() as u64);
                to.numbers(list);
            }
        }
    }
}

/// Settings with their names.
pub fn read_settings(from: &mut Reader<'_>) -> Result<Vec<(&'static str, Value)>, Fault> {
    from.list(|from| {
        let name = from.name()?;
        let value = match from.kind()? {
            0 => Value::Number(one(from)?),
            1 => Value::Integer(from.whole()?),
            2 => Value::Flag(from.kind()? != 0),
            3 => Value::Choice(from.text()?),
            4 => Value::Numbers(from.list(one)?),
            other => return Err(format!("setting {name:?} is of the kind {other}")),
        };
        Ok((name, value))
    })
}

fn one(from: &mut Reader<'_>) -> Result<f64, Fault> {
    Ok(from.numbers::<1>()?[0])
}

fn write_notes(notes: &[Note], to: &mut Writer) {
    to.count(notes.len() as u64);
    notes.iter().for_each(|note| PyNote::from(note.clone()).write(to));
}

fn read_notes(from: &mut Reader<'_>) -> Result<Vec<Note>, Fault> {
    from.list(|from| Ok(PyNote::read(from)?.note))
}

fn write_partition(partition: &Partition, to: &mut Writer) {
    to.numbers(&partition.shadow_clip_from_world.to_cols_array());
    to.count(u64::from(partition.factors.is_some()));
    if let Some(Factors { lift, warp, fit }) = &partition.factors {
        [lift, warp, fit].into_iter().for_each(|factor| to.numbers(&factor.to_cols_array()));
    }
    match &partition.post_warp {
        PostWarp::None => to.kind(NO_WARP),
        PostWarp::Log { scale, offset } => {
            to.kind(LOG);
            to.numbers(&[*scale, *offset]);
        }
        PostWarp::Rectilinear(warp) => {
            to.kind(RECTILINEAR);
            for function in [&warp.x, &warp.y] {
                to.count(function.knots().len() as u64);
                function.knots().for_each(|knot| to.numbers(&knot));
            }
        }
    }
    to.numbers(&partition.eye_depth);
    to.count(partition.region.functionals().len() as u64);
    partition.region.functionals().iter().for_each(|f| to.numbers(&f.to_array()));
    write_notes(&partition.notes, to);
    to.text(partition.technique);
    to.count(partition.values.len() as u64);
    for (name, value) in &partition.values {
        to.text(name);
        to.numbers(&[*value]);
    }
}

fn read_partition(from: &mut Reader<'_>) -> Result<Partition, Fault> {
    let matrix = DMat4::from_cols_array(&from.numbers()?);
    if !matrix.is_finite() {
        return Err("a matrix is not finite".into());
    }
    let factors = from.list(|from| {
        let mut factor = || from.numbers().map(|columns| DMat4::from_cols_array(&columns));
        Ok(Factors { lift: factor()?, warp: factor()?, fit: factor()? })
    })?;
    if factors.len() > 1 {
        return Err(format!("a map has {} products", factors.len()));
    }
    let post_warp = match from.kind()? {
        NO_WARP => PostWarp::None,
        LOG => {
            let [scale, offset] = from.numbers()?;
            PostWarp::Log { scale, offset }
        }
        RECTILINEAR => {
            let mut function = || {
                let knots = from.list(Reader::numbers::<2>)?;
                PiecewiseLinear::new(&knots).map_err(|_| "a warp's knots do not ascend".to_string())
            };
            PostWarp::Rectilinear(Arc::new(Rectilinear { x: function()?, y: function()? }))
        }
        other => return Err(format!("a map ends in a warp of the kind {other}")),
    };
    let eye_depth = from.numbers()?;
    let region = from.list(|from| Ok(DVec4::from_array(from.numbers()?)))?;
    if region.len() > Region::MOST {
        return Err(format!("a region has {} sides", region.len()));
    }
    let notes = read_notes(from)?;
    Ok(Partition {
        notes,
        shadow_clip_from_world: matrix,
        factors: factors.first().copied(),
        post_warp,
        eye_depth,
        region: Region::new(&region),
        technique: from.name()?,
        values: from.list(|from| Ok((from.name()?, one(from)?)))?,
    })
}

impl State for PyPartition {
    const NAME: &'static str = "Partition";
    fn write(&self, to: &mut Writer) {
        write_partition(&self.partition, to);
    }
    fn read(from: &mut Reader<'_>) -> Result<Self, Fault> {
        Ok(Self { partition: read_partition(from)? })
    }
}

impl State for PyParameterization {
    const NAME: &'static str = "Parameterization";
    fn write(&self, to: &mut Writer) {
        let p = &self.p;
        to.text(&p.technique);
        write_settings(&p.settings, to);
        to.count(p.partitions.len() as u64);
        p.partitions.iter().for_each(|partition| write_partition(partition, to));
        to.text(SELECTIONS.iter().find(|s| s.1 == p.selection).map_or("depth", |s| s.0));
        p.resolution.iter().for_each(|&texels| to.count(u64::from(texels)));
        to.count(u64::from(p.border_texels));
        write_notes(&p.notes, to);
    }
    fn read(from: &mut Reader<'_>) -> Result<Self, Fault> {
        let (technique, settings) = (from.text()?, read_settings(from)?);
        let partitions = from.list(read_partition)?;
        if partitions.is_empty() {
            return Err("it has no map".into());
        }
        let selection = from.text()?;
        let selection =
            SELECTIONS.iter().find(|s| s.0 == selection).ok_or_else(|| format!("maps are chosen by {selection:?}"))?.1;
        let (resolution, border_texels) = ([from.count()?, from.count()?], from.count()?);
        if !resolution.iter().all(|texels| (1..=MAX_IMAGE_SIDE).contains(texels)) {
            return Err(format!("its resolution is {resolution:?}"));
        }
        let notes = read_notes(from)?;
        let settings = settings.into();
        Ok(Parameterization { technique, settings, partitions, selection, resolution, border_texels, notes }.into())
    }
}
