//! Techniques that make their maps for the receivers' body, whatever is seen of it: what closed forms, tables and published
//! numbers are about.

use shadowlab::techniques::{Technique, Value, by_body as body_of, technique, technique_of};

/// The technique of a text, for the body.
pub fn by_body(text: &str) -> Box<dyn Technique> {
    body_of(technique_of(text).expect(text).as_ref()).expect(text)
}

/// A technique by name and some of its parameters, for the body.
pub fn by_body_with(name: &str, given: &[(&str, Value)]) -> Box<dyn Technique> {
    let params: Vec<(String, Value)> = given.iter().map(|(n, v)| (n.to_string(), v.clone())).collect();
    body_of(technique(name, &params).expect(name).as_ref()).expect(name)
}
