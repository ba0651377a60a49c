//! The files of `src/techniques` against the list of techniques: nothing written and forgotten, nothing listed without a file.

use std::collections::BTreeSet;
use std::path::Path;

use shadowlab::techniques::{self, FIT, Kind, MARGIN, Make, ParamSpec, RANGE, TECHNIQUES, Value};

use crate::support::settings::BY_SAMPLES;

/// What `src/techniques` holds beside techniques: the list, how names and texts find its entries, what all are made with, and
/// what makes a technique by body of any.
const NO_TECHNIQUE: [&str; 5] = ["by_body.rs", "kit", "mod.rs", "registry.rs", "text.rs"];

#[test]
fn every_file_or_folder_is_a_technique_and_every_technique_has_one() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/techniques");
    let files: BTreeSet<String> = std::fs::read_dir(folder)
        .expect("the folder of the techniques")
        .map(|entry| entry.expect("a readable folder").file_name().to_string_lossy().into_owned())
        .filter(|name| !NO_TECHNIQUE.contains(&name.as_str()))
        .map(|name| name.trim_end_matches(".rs").to_string())
        .collect();
    let listed: BTreeSet<String> = TECHNIQUES.iter().map(|entry| entry.spec.name.replace('-', "_")).collect();
    assert_eq!(files, listed);
    assert_eq!(listed.len(), TECHNIQUES.len(), "two techniques share a name");
}

#[test]
fn defaults_are_valid_and_every_technique_can_be_made_from_its_own_settings() {
    for spec in techniques::specs() {
        let made = techniques::technique(spec.name, &[]).expect(spec.name);
        let settings = made.settings();
        assert_eq!(
            settings.iter().map(|s| s.0).collect::<Vec<_>>(),
            spec.params.iter().map(|p| p.name).collect::<Vec<_>>()
        );
        let given: Vec<(String, Value)> = settings.iter().map(|(n, v)| (n.to_string(), v.clone())).collect();
        let again = techniques::technique(spec.name, &given).expect("its own defaults");
        assert_eq!(again.settings(), settings);
        for p in spec.params {
            assert!(!p.doc.is_empty() && !p.doc.contains("  "), "{}.{}: {:?}", spec.name, p.name, p.doc);
            if let Kind::Choice(words) | Kind::ChoiceOrNumber { words, .. } = p.kind {
                for word in words {
                    let value = vec![(p.name.to_string(), Value::Choice(word.to_string()))];
                    let made = techniques::technique(spec.name, &value).expect(word);
                    assert!(made.settings().contains(&(p.name, Value::Choice(word.to_string()))));
                }
            }
        }
        assert!(!spec.title.is_empty() && !spec.source.is_empty() && !spec.lights.names().is_empty());
    }
}

#[test]
fn every_warp_lets_choose_what_places_it_and_what_its_map_holds() {
    for entry in TECHNIQUES.iter().filter(|entry| matches!(entry.make, Make::Warp(_))) {
        let spec = entry.spec;
        let Some([range, fit, margin]) = spec.params.last_chunk() else { panic!("{}: three parameters", spec.name) };
        assert_eq!(*margin, MARGIN, "{}", spec.name);
        for (ours, shared) in [(range, &RANGE), (fit, &FIT)] {
            assert_eq!(ours.name, shared.name, "{}: the last parameters", spec.name);
            let words = |p: &ParamSpec| match p.kind {
                Kind::Choice(words) => words,
                _ => panic!("{}.{}: words", spec.name, p.name),
            };
            // A search over samples has no map for the body.
            let all = words(shared)
                .iter()
                .filter(|word| !BY_SAMPLES.contains(&spec.name) || ["shadow", "seen", "body"].contains(word));
            assert!(all.into_iter().all(|word| words(ours).contains(word)), "{}: {ours:?}", spec.name);
            // What others are measured against looks at nothing.
            assert_eq!(ours.default == shared.default, spec.name != "uniform", "{}: {ours:?}", spec.name);
        }
    }
}

#[test]
fn unknown_names_list_the_valid_ones() {
    let unknown = techniques::technique("shadow", &[]).unwrap_err().to_string();
    assert!(techniques::specs().all(|spec| unknown.contains(spec.name)), "{unknown}");
    let unknown = techniques::technique("lispsm", &[("nera".into(), Value::Number(1.0))]).unwrap_err().to_string();
    assert!(["near", "near_factor", "axis"].iter().all(|name| unknown.contains(name)), "{unknown}");
}
