//! A technique whose maps are held while the camera moves: fitted to samples, with slack around them.
//!
//! Source: theory.md 10.6. The slack is a setting of every warp; a map for the body cannot have any.

use super::inner::{inner_of, with_settings};
use super::kit::{Holds, Needs, SLACK, Technique};
use super::text::text_of;
use crate::error::{Error, Result};
use crate::parameterization::Value;

/// The same technique with slack around the samples that its maps hold; techniques inside it likewise.
///
/// # Errors
/// [`Error::InvalidArgument`] for a slack out of range, or a technique that does not fit each of its maps to samples.
pub fn with_slack(of: &dyn Technique, slack: f64) -> Result<Box<dyn Technique>> {
    let inner = inner_of(of)?;
    if inner.is_empty() && (holds(of)? == Holds::Body || of.needs() == Needs::Nothing) {
        let expected = "maps that are fitted to samples, each with fit=shadow or fit=seen";
        let fix = "set fit=shadow; a map for all that can be seen has no samples to leave slack around";
        return Err(Error::argument("technique", expected, text_of(of), fix));
    }
    with_settings(
        of,
        |inner| with_slack(inner, slack),
        |name, value, _| if name == SLACK.name { Value::Number(slack) } else { value.clone() },
    )
}

/// What all maps of a technique must hold: the receivers' body if one of them does, else all visible receivers if one of them
/// does.
///
/// # Errors
/// None for settings that a technique has.
pub fn holds(of: &dyn Technique) -> Result<Holds> {
    let inner = inner_of(of)?;
    if inner.is_empty() {
        let is = |word: &str| of.settings().contains(&("fit", Value::Choice(word.into())));
        return Ok(if is("shadow") {
            Holds::Shadow
        } else if is("seen") {
            Holds::Seen
        } else {
            Holds::Body
        });
    }
    let all = inner.iter().map(|t| holds(t.as_ref())).collect::<Result<Vec<_>>>()?;
    Ok([Holds::Body, Holds::Seen].into_iter().find(|most| all.contains(most)).unwrap_or(Holds::Shadow))
}

#[cfg(test)]
mod tests {
    use super::super::text::technique_of;
    use super::*;

    fn of(text: &str) -> Box<dyn Technique> {
        technique_of(text).unwrap()
    }

    #[test]
    fn slack_reaches_every_warp_inside() {
        let texts = [
            ("scene_optimal", "scene_optimal:slack=1.25"),
            ("lispsm:fit=seen,slack=2", "lispsm:fit=seen,slack=1.25"),
            (
                "z_partition:count=2,inner=(face_partition:inner=lispsm)/psm",
                "z_partition:count=2,inner=(face_partition:inner=(lispsm:slack=1.25))/(psm:slack=1.25)",
            ),
        ];
        for (text, expected) in texts {
            let found = with_slack(of(text).as_ref(), 1.25).unwrap();
            assert_eq!(text_of(found.as_ref()), text_of(of(expected).as_ref()), "{text}");
        }
    }

    #[test]
    fn maps_without_samples_have_no_slack() {
        for text in
            ["uniform", "lispsm:fit=exact", "uniform:stable=true,fit=shadow", "z_partition:inner=lispsm/uniform"]
        {
            let error = with_slack(of(text).as_ref(), 1.1).unwrap_err();
            assert!(matches!(&error, Error::InvalidArgument { name, .. } if name == "technique"), "{text}: {error}");
        }
        assert!(with_slack(of("lispsm").as_ref(), 0.9).is_err());
    }

    #[test]
    fn the_most_that_a_map_holds_is_what_all_hold() {
        let texts = [
            ("lispsm", Holds::Shadow),
            ("tsm:fit=seen", Holds::Seen),
            ("uniform", Holds::Body),
            ("z_partition:inner=lispsm/(psm:fit=seen)", Holds::Seen),
            ("z_partition:inner=lispsm/uniform", Holds::Body),
        ];
        for (text, expected) in texts {
            assert_eq!(holds(of(text).as_ref()).unwrap(), expected, "{text}");
        }
    }
}
