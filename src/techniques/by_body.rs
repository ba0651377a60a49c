//! A technique as papers have it: maps for the receivers' body, whatever is seen of it.

use super::inner::with_settings;
use super::kit::Technique;
use crate::error::Result;
use crate::parameterization::Value;

/// Words that look at samples, and what stands for them in a technique that looks at none.
const WORDS: [(&str, &str, &str); 6] = [
    ("range", "seen", "body"),
    ("fit", "seen", "exact"),
    ("fit", "shadow", "exact"),
    ("over", "seen", "body"),
    ("norm", "edge", "auto"),
    ("norm", "flips", "auto"),
];

/// The same technique with maps for the receivers' body: `range=body` and `fit=exact` where it looks at samples, and of a search
/// at visible edges the published warp distance. Techniques inside it likewise.
///
/// # Errors
/// As [`technique`](super::technique()); none for settings that a technique has.
pub fn by_body(of: &dyn Technique) -> Result<Box<dyn Technique>> {
    let settings = of.settings();
    let is = |name: &str, word: &str| settings.iter().any(|(n, v)| *n == name && *v == Value::Choice(word.into()));
    let by_edges = ["auto", "edge", "flips"].iter().any(|norm| is("norm", norm));
    let searches_seen = is("near", "optimal") && is("over", "seen") && by_edges;
    with_settings(of, by_body, |name, value, param| match value {
        Value::Choice(word) if name == "near" && word == "optimal" && searches_seen => Value::Choice("delta-z".into()),
        Value::Choice(word) => {
            let other = WORDS.iter().find(|(n, old, _)| *n == name && old == word);
            let new = other.map(|(_, _, new)| Value::Choice((*new).into()));
            // A technique that is for samples alone has no other word.
            new.and_then(|new| param.kind.accept(&new)).unwrap_or_else(|| value.clone())
        }
        other => other.clone(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::kit::Needs;
    use super::super::text::technique_of;
    use super::*;

    #[test]
    fn techniques_by_body_need_no_samples_and_stay_as_they_are_otherwise() {
        let texts = [
            ("lispsm", "lispsm:near=delta-z,over=body,range=body,fit=exact"),
            ("lispsm:near=0.5,axis=middle,norm=flips", "lispsm:near=0.5,axis=middle,over=body,range=body,fit=exact"),
            ("lispsm:near=optimal,over=body", "lispsm:over=body,range=body,fit=exact"),
            ("lispsm:norm=storage", "lispsm:norm=storage,over=body,range=body,fit=exact"),
            ("gmnpr:fit=intersection", "gmnpr:range=body,fit=intersection"),
            ("uniform:stable=true", "uniform:stable=true"),
        ];
        for (text, expected) in texts {
            let found = by_body(technique_of(text).unwrap().as_ref()).unwrap();
            assert_eq!(found.settings(), technique_of(expected).unwrap().settings(), "{text}");
            assert_eq!(found.needs(), Needs::Nothing, "{text}");
        }
        let nested = technique_of("z_partition:count=2,inner=(face_partition:inner=lispsm)/psm").unwrap();
        assert_eq!(nested.needs(), Needs::Shadows);
        assert_eq!(by_body(nested.as_ref()).unwrap().needs(), Needs::Nothing);
    }
}
