//! What techniques answer: maps, or that a view does not suit them.

use std::collections::BTreeMap;

use shadowlab::fit::BORDER_TEXELS;
use shadowlab::focus::Samples;
use shadowlab::techniques::{Technique, Value, techniques_of};
use shadowlab::{Error, Parameterization, Result};

use crate::support::views::View;

/// What techniques answered: maps, or that a view does not suit them.
#[derive(Debug, Default)]
pub struct Answers {
    found: BTreeMap<&'static str, [usize; 2]>,
    views: usize,
}

impl Answers {
    /// The number of a view, from 0 on.
    pub fn turn(&mut self) -> usize {
        self.views += 1;
        self.views - 1
    }
    pub fn count(&mut self, technique: &'static str, maps: bool) {
        self.found.entry(technique).or_default()[usize::from(!maps)] += 1;
    }
    /// A technique that answers nothing but errors is none.
    pub fn assert_maps_of_all(&self) {
        for (technique, [maps, unsuited]) in &self.found {
            println!("{technique}: {maps} answers with maps, {unsuited} views that do not suit it");
            assert!(*maps > 0, "{technique}: no view suits it");
        }
    }
}

/// The maps; nothing where the view does not suit the technique.
pub fn answer(t: &dyn Technique, v: &View, resolution: u32, samples: &Samples) -> Result<Option<Parameterization>> {
    match t.parameterize_seen(&v.scene, &v.camera, &v.light, [resolution; 2], Some(samples)) {
        Ok(p) => Ok(Some(p)),
        Err(Error::UnsuitedView { reason, fix, .. }) if !reason.is_empty() && !fix.is_empty() => Ok(None),
        Err(Error::InvalidArgument { name, .. }) if name == "margin" && margin_is_too_wide(t, resolution) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Whether a margin, of the technique or one inside, leaves less than half of the texels between the borders of a map.
pub fn margin_is_too_wide(t: &dyn Technique, resolution: u32) -> bool {
    let between = f64::from(resolution - 2 * BORDER_TEXELS);
    t.settings().iter().any(|(name, value)| match (*name, value) {
        ("margin", Value::Number(margin)) => *margin > 0.25 * between,
        ("inner", Value::Choice(text)) => {
            let inner = techniques_of(text).expect("a technique made it");
            inner.iter().any(|t| margin_is_too_wide(t.as_ref(), resolution))
        }
        _ => false,
    })
}
