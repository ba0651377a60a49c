//! Techniques that make their maps for the receivers' body, whatever is seen of it: what closed forms, tables and published
//! numbers are about.
//!
//! The defaults look at visible surfaces. Everything here adds the settings that do not, to every warp of a technique, nested
//! ones included; a setting that is given stays.

use shadowlab::techniques::{
    Kind, Make, TECHNIQUES, Technique, Value, technique, technique_of, techniques_of, text_of,
};

/// Settings of a warp that look at no samples, where the warp has them.
const OF_BODY: [(&str, &str); 4] = [("range", "body"), ("fit", "exact"), ("near", "delta-z"), ("over", "body")];

/// Parameters of a technique with those that make its maps for the body.
pub fn of_body(name: &str, given: &[(&str, Value)]) -> Vec<(String, Value)> {
    let entry =
        TECHNIQUES.iter().find(|entry| entry.spec.name == name).unwrap_or_else(|| panic!("no technique {name}"));
    let mut params: Vec<(String, Value)> = given.iter().map(|(n, v)| (n.to_string(), v.clone())).collect();
    for p in entry.spec.params {
        let place = params.iter().position(|(n, _)| n == p.name);
        if p.kind == Kind::Techniques {
            let given = place.map_or_else(|| p.default.value(), |i| params[i].1.clone());
            let Value::Choice(text) = given else { panic!("{name}.{}: techniques, not {given}", p.name) };
            let inner: Vec<String> = pieces(&text, '/').into_iter().map(|t| bracketed(&body_text(t))).collect();
            let inner = (p.name.to_string(), Value::Choice(inner.join("/")));
            match place {
                Some(i) => params[i] = inner,
                None => params.push(inner),
            }
        } else if let (Make::Warp(_), None) = (entry.make, place) {
            // Words of one technique only may share a name with a number of another.
            let word = OF_BODY.iter().find(|(n, _)| *n == p.name).map(|(_, word)| *word);
            params.extend(word.map(|word| (p.name.to_string(), Value::Choice(word.into()))));
        }
    }
    params
}

/// A technique by name and some of its parameters, for the body.
pub fn by_body_with(name: &str, given: &[(&str, Value)]) -> Box<dyn Technique> {
    technique(name, &of_body(name, given)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// The technique of a text, for the body.
pub fn by_body(text: &str) -> Box<dyn Technique> {
    let text = bare(text);
    let (name, rest) = text.split_once(':').unwrap_or((text, ""));
    let settings = pieces(rest, ',').into_iter().filter(|piece| !piece.is_empty());
    let split = settings.map(|piece| piece.split_once('=').unwrap_or_else(|| panic!("{text}: no setting in {piece}")));
    let given: Vec<(&str, Value)> = split.map(|(key, value)| (key, Value::Choice(bare(value).into()))).collect();
    by_body_with(name, &given)
}

/// The text of a technique, for the body.
pub fn body_text(text: &str) -> String {
    text_of(by_body(text).as_ref())
}

fn bracketed(text: &str) -> String {
    format!("({text})")
}

/// A text without the parentheses around all of it.
fn bare(text: &str) -> &str {
    let text = text.trim();
    let inner = text.strip_prefix('(').and_then(|t| t.strip_suffix(')'));
    // "(a)/(b)" begins and ends with one, too.
    let closes_last = |inner: &str| {
        let mut depth = 0_i32;
        inner.chars().all(|c| {
            depth += i32::from(c == '(') - i32::from(c == ')');
            depth >= 0
        })
    };
    inner.filter(|inner| closes_last(inner)).map_or(text, bare)
}

/// The pieces between separators outside of parentheses.
fn pieces(text: &str, separator: char) -> Vec<&str> {
    let (mut depth, mut start, mut found) = (0_i32, 0, Vec::new());
    for (i, c) in text.char_indices() {
        depth += i32::from(c == '(') - i32::from(c == ')');
        if c == separator && depth == 0 {
            found.push(text[start..i].trim());
            start = i + c.len_utf8();
        }
    }
    found.push(text[start..].trim());
    found
}

#[test]
fn settings_are_added_to_every_warp_and_given_ones_stay() {
    let value = |t: &dyn Technique, name: &str| match t.settings().into_iter().find(|s| s.0 == name) {
        Some((_, Value::Choice(word))) => word,
        other => panic!("{name}: {other:?}"),
    };
    let plain = by_body("lispsm");
    let found = ["near", "over", "range", "fit", "norm"].map(|name| value(plain.as_ref(), name));
    assert_eq!(found, ["delta-z", "body", "body", "exact", "auto"]);
    let given = by_body("lispsm:near=optimal,fit=none");
    let found = ["near", "over", "range", "fit"].map(|name| value(given.as_ref(), name));
    assert_eq!(found, ["optimal", "body", "body", "none"]);
    let nested = by_body("z_partition:count=3,inner=(lispsm:near=basic,fit=none)/(z_partition:inner=tsm)");
    assert_eq!(value(nested.as_ref(), "range"), "auto");
    let inner = techniques_of(&value(nested.as_ref(), "inner")).expect("techniques");
    assert_eq!(["near", "range", "fit"].map(|name| value(inner[0].as_ref(), name)), ["basic", "body", "none"]);
    let innermost = technique_of(&value(inner[1].as_ref(), "inner")).expect("a technique");
    assert_eq!(["range", "fit"].map(|name| value(innermost.as_ref(), name)), ["body", "exact"]);
    // Those that are there where none is given, too.
    let faces = techniques_of(&value(by_body("face_partition").as_ref(), "inner")).expect("techniques");
    assert_eq!(value(faces[0].as_ref(), "fit"), "exact");
    for t in [plain, given, nested, by_body("face_partition"), by_body("psm:range=camera")] {
        assert_eq!(t.needs(), shadowlab::techniques::Needs::Nothing, "{:?}", t.settings());
    }
}
