//! What a technique's maps promise to hold, by its settings and notes.

use glam::DVec3;
use shadowlab::Parameterization;
use shadowlab::focus::Samples;
use shadowlab::note::Kind;
use shadowlab::parameterization::Region;
use shadowlab::techniques::{Value, techniques_of};

use crate::support::views::View;

/// What a technique's maps promise to hold; every promise holds what those after it do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Promise {
    /// All of the instances' boxes that can be seen and lit.
    Body,
    /// That, within the depths of the samples that face the light.
    Depths,
    /// The samples that face the light.
    Seen,
    /// Those in shadow and their neighbours.
    Shadow,
}

impl Promise {
    pub fn of(p: &Parameterization) -> Self {
        let promise = Self::of_settings(&p.settings);
        let says = |kind: Kind| p.notes.iter().any(|note| note.kind() == kind);
        match promise {
            // This promises no more than its samples.
            _ if says(Kind::CoversSamples) => promise.max(Self::Seen),
            // Without samples there is the body, without shadows all samples.
            _ if p.partitions.len() == 1 && says(Kind::NoLitSample) => Self::Body,
            Self::Shadow if p.partitions.len() == 1 && says(Kind::NoShadow) => Self::Seen,
            _ => promise,
        }
    }
    fn of_settings(settings: &[(&str, Value)]) -> Self {
        let is = |name: &str, word: &str| {
            settings.iter().any(|(n, value)| *n == name && matches!(value, Value::Choice(w) if w == word))
        };
        if let Some((_, Value::Choice(inner))) = settings.iter().find(|(name, _)| *name == "inner") {
            let inner = techniques_of(inner).expect("a technique made it");
            return inner.iter().map(|t| Self::of_settings(&t.settings())).max().expect("one");
        }
        if settings.contains(&("stable", Value::Flag(true))) {
            Self::Body
        } else if is("fit", "shadow") {
            Self::Shadow
        } else if is("fit", "seen") {
            Self::Seen
        } else if is("range", "seen") {
            Self::Depths
        } else {
            Self::Body
        }
    }
    /// Positions, world, and normals of samples that it holds.
    pub fn held(self, v: &View, samples: &Samples) -> Vec<(DVec3, DVec3)> {
        match (self, &samples.shadows) {
            (Self::Shadow, Some(shadows)) => {
                let shaded = shadows.shaded.iter().map(|&i| samples.sample(i as usize));
                let in_depth =
                    |(p, _): &(DVec3, DVec3)| (v.camera.near()..=v.camera.far()).contains(&v.camera.depth_of(*p));
                shaded.filter(in_depth).collect()
            }
            _ => samples.lit(&v.camera, &v.light, &Region::ALL).collect(),
        }
    }
}
