//! Imports point down, files stay small, and `mod.rs` holds lists: the house rules that a compiler does not know.
//!
//! The table is `docs/ARCHITECTURE.md`'s. What is read of a file is its tokens, so a path in a comment, a string or a
//! test module is no import.

mod circles;
mod tokens;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use circles::{File, Module, circles, graph};
use tokens::{imports, tokens_without_tests};

/// For each module, the others that it may use.
const MAY_USE: &[(&str, &[&str])] = &[
    ("error", &[]),
    ("digest", &[]),
    ("progress", &["error"]),
    ("memory", &["error"]),
    ("names", &["error"]),
    ("simd", &[]),
    ("threads", &["error"]),
    ("geometry", &["error"]),
    ("image", &["error", "geometry"]),
    ("note", &[]),
    ("picture", &["image", "simd"]),
    ("parameterization", &["error", "geometry", "note"]),
    ("scene", &["digest", "error", "geometry", "memory", "progress"]),
    ("rays", &["error", "geometry", "scene"]),
    ("focus", &["error", "geometry", "image", "parameterization", "rays", "scene", "simd"]),
    ("fit", &["error", "focus", "geometry", "parameterization", "rays", "scene"]),
    ("aliasing", &["error", "geometry", "image", "memory", "parameterization", "progress", "rays", "scene", "simd"]),
    // A renderer on a device has a pass that is the twin of aliasing's footprint; the one on the processor calls it.
    (
        "render",
        &[
            "aliasing",
            "error",
            "geometry",
            "image",
            "memory",
            "names",
            "parameterization",
            "progress",
            "rays",
            "scene",
            "simd",
        ],
    ),
    (
        "diagnose_pixels",
        &["aliasing", "error", "geometry", "image", "parameterization", "progress", "rays", "render", "scene", "trace"],
    ),
    // Truth knows no parameterization.
    ("trace", &["error", "geometry", "image", "memory", "progress", "rays", "scene"]),
    (
        "techniques",
        &[
            "error",
            "fit",
            "focus",
            "geometry",
            "image",
            "note",
            "parameterization",
            "progress",
            "rays",
            "scene",
            "simd",
        ],
    ),
    // What is seen is drawn by a renderer and divided among maps; techniques get it as data.
    (
        "survey",
        &["aliasing", "error", "focus", "image", "parameterization", "progress", "render", "scene", "techniques"],
    ),
    (
        "python",
        &[
            "aliasing",
            "digest",
            "error",
            "focus",
            "geometry",
            "image",
            "memory",
            "names",
            "note",
            "parameterization",
            "picture",
            "progress",
            "rays",
            "render",
            "scene",
            "diagnose_pixels",
            "survey",
            "techniques",
            "threads",
            "trace",
        ],
    ),
];

/// Uses that close a circle and stay: from, to, and why.
const CIRCLES: &[(&str, &str, &str)] = &[
    ("techniques::z_partition::scheme", "techniques::text", INNER),
    ("techniques::z_partition::scheme", "techniques::registry", INNER),
    ("techniques::optimal_partition::scheme", "techniques::registry", INNER),
    ("techniques::face_partition", "techniques::text", INNER),
    ("techniques::rectilinear::base", "techniques::text", INNER),
    ("techniques::rectilinear::base", "techniques::registry", INNER),
    ("diagnose_pixels::looker", "diagnose_pixels::way", REMEMBERED),
];
const REMEMBERED: &str = "ways are followed with a looker, which remembers for a texel what following them found";
const INNER: &str = "a technique finds those inside it by name, in the list that it is in itself";

/// Beyond this a file has more than one concept (style: 100 to 350 lines, split above 500).
const MAX_LINES: usize = 500;

/// What a list needs none of.
const NOT_IN_LISTS: &[&str] = &["enum", "fn", "impl", "macro_rules", "struct", "trait", "union"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All files below `folder` with one of the extensions, sorted; none where there is no such folder.
fn files(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let Ok(entries) = fs::read_dir(folder) else { return found };
    for path in entries.map(|entry| entry.expect("a readable folder").path()) {
        if path.is_dir() {
            found.extend(files(&path, extensions));
        } else if path.extension().is_some_and(|e| extensions.iter().any(|x| e == *x)) {
            found.push(path);
        }
    }
    found.sort();
    found
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// `["render", "cpu", "raster"]` for `src/render/cpu/raster.rs`, nothing for `src/lib.rs`.
fn module_of(source: &Path) -> Vec<String> {
    let relative = source.strip_prefix(root().join("src")).expect("a file in src").with_extension("");
    let mut path: Vec<String> = relative.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    if path.last().is_some_and(|last| last == "mod" || last == "lib") {
        path.pop();
    }
    path
}

/// Which module each name comes from that `lib.rs` exports at the top: `Error` -> `error`.
fn re_exports(lib: &str) -> BTreeMap<String, String> {
    let crate_paths = lib.replace("pub use ", "pub use crate::");
    let paths = imports(&tokens_without_tests(&crate_paths).0, &[]);
    paths.into_iter().filter(|p| p.len() > 1).map(|p| (p[p.len() - 1].clone(), p[0].clone())).collect()
}

/// The imports of one file that the table forbids, each as a sentence.
fn forbidden(module: &[String], source: &str, re_exports: &BTreeMap<String, String>) -> Vec<String> {
    let Some(top) = module.first() else { return Vec::new() };
    let Some((_, allowed)) = MAY_USE.iter().find(|(name, _)| name == top) else {
        return vec![format!("module {top:?} is not in the table of tests/rust/layers.rs")];
    };
    let (tokens, _) = tokens_without_tests(source);
    let mut complaints = Vec::new();
    for mut path in imports(&tokens, module) {
        if let Some(home) = path.first().and_then(|first| re_exports.get(first)) {
            path.insert(0, home.clone());
        }
        let target = path.first().expect("a path");
        if target != top && !allowed.contains(&target.as_str()) {
            complaints.push(format!("{} uses crate::{}", module.join("::"), path.join("::")));
        }
    }
    complaints
}

/// The sources with their modules, without those that are only there for tests.
fn sources() -> Vec<(Module, PathBuf)> {
    let all: Vec<(Module, PathBuf)> =
        files(&root().join("src"), &["rs"]).into_iter().map(|path| (module_of(&path), path)).collect();
    let test_only: Vec<Module> = all
        .iter()
        .flat_map(|(module, path)| {
            let (_, names) = tokens_without_tests(&read(path));
            names.into_iter().map(move |name| [module.as_slice(), &[name]].concat())
        })
        .collect();
    let is_test = |module: &Module| test_only.iter().any(|exempt| module.starts_with(exempt));
    all.into_iter().filter(|(module, _)| !is_test(module)).collect()
}

fn is_list(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name == "mod.rs" || name == "lib.rs")
}

#[test]
fn imports_point_down() {
    let exports = re_exports(&read(&root().join("src/lib.rs")));
    let sources = sources();
    let complaints: Vec<String> =
        sources.iter().flat_map(|(module, path)| forbidden(module, &read(path), &exports)).collect();
    assert!(sources.len() > 20, "only {} sources found: is the walk broken?", sources.len());
    assert!(complaints.is_empty(), "imports that the table of layers forbids:\n{}", complaints.join("\n"));
}

#[test]
fn no_files_use_each_other_in_a_circle() {
    let file = |path: &Path| File { tokens: tokens_without_tests(&read(path)).0, is_list: is_list(path) };
    let mut uses = graph(&sources().into_iter().map(|(module, path)| (module, file(&path))).collect());
    let named = |text: &str| text.split("::").map(str::to_string).collect::<Module>();
    for (from, to, why) in CIRCLES {
        assert!(!why.is_empty());
        let is_there = uses.get_mut(&named(from)).is_some_and(|targets| targets.remove(&named(to)));
        assert!(is_there, "{from} does not use {to}: remove the exception");
    }
    assert!(uses.values().map(|targets| targets.len()).sum::<usize>() > 300, "few uses found: is the walk broken?");
    let left = circles(uses);
    let sentence = |(from, to): (&Module, &std::collections::BTreeSet<Module>)| {
        let to: Vec<String> = to.iter().map(|module| module.join("::")).collect();
        format!("{} uses {}", from.join("::"), to.join(", "))
    };
    assert!(left.is_empty(), "files in a circle:\n{}", left.iter().map(sentence).collect::<Vec<_>>().join("\n"));
}

#[test]
fn files_hold_one_concept() {
    let mut sources = Vec::new();
    for folder in ["src", "tests", "benches", "python", "docs"] {
        sources.extend(files(&root().join(folder), &["rs", "py", "pyi", "wgsl"]));
    }
    let too_long: Vec<String> = sources
        .iter()
        .map(|path| (path, read(path).lines().count()))
        .filter(|&(_, lines)| lines > MAX_LINES)
        .map(|(path, lines)| format!("{}: {lines} lines", path.strip_prefix(root()).unwrap().display()))
        .collect();
    assert!(too_long.is_empty(), "split by concept, {MAX_LINES} lines at the most:\n{}", too_long.join("\n"));
}

#[test]
fn mod_files_hold_lists_only() {
    let mut complaints = Vec::new();
    for path in files(&root().join("src"), &["rs"]) {
        if is_list(&path) {
            let (tokens, _) = tokens_without_tests(&read(&path));
            if let Some(word) = tokens.iter().find(|token| NOT_IN_LISTS.contains(&token.as_str())) {
                complaints.push(format!("{}: `{word}`", path.strip_prefix(root()).unwrap().display()));
            }
        }
    }
    for path in files(&root().join("python"), &["py"]) {
        if path.file_name().is_some_and(|name| name == "__init__.py") {
            let source = read(&path);
            // Python asks `__getattr__` and `__dir__` of a module that loads its parts on demand: they serve the list.
            let is_body =
                |line: &&str| line.starts_with("class ") || line.starts_with("def ") && !line.starts_with("def __");
            let bodies = source.lines().filter(is_body);
            complaints.extend(bodies.map(|line| format!("{}: `{line}`", path.strip_prefix(root()).unwrap().display())));
        }
    }
    assert!(complaints.is_empty(), "belongs into a file of its own:\n{}", complaints.join("\n"));
}

#[test]
fn a_forbidden_import_is_found_however_it_is_written() {
    let exports = re_exports("pub use error::{Error, Result};\npub use techniques::Technique;\n");
    let module = ["render".to_string(), "cpu".to_string()];
    for source in [
        "use crate::trace::Tracer;",
        "use crate::{scene::Scene, trace};",
        "use crate::{\n    scene::{Camera, Light},\n    image::{self, GBuffer},\n    techniques::{Spec as S},\n};",
        "use {std::fmt, crate::techniques::Spec};",
        "fn f() -> u32 { crate::python::convert::<u32>(1) }",
        "use super::super::focus::view;",
        "use super::{bias, super::techniques};",
        "mod inner { use super::super::super::trace; fn f() {} }",
        "use crate::Technique;",
        "use crate::*;",
        "use crate as everything;",
        "#[cfg(not(test))]\nuse crate::trace::Tracer;",
        "#[cfg(test)]\nuse crate::image;\nuse crate::trace;",
        "#[cfg(test)]\nmod tests { fn f() { let s = '{'; } }\nuse crate::trace;",
        "fn f<'a>() -> &'a str { \"\\\"\" }\nuse crate::trace;",
    ] {
        assert_eq!(forbidden(&module, source, &exports).len(), 1, "{source}");
    }
}

#[test]
fn what_is_no_import_or_points_down_passes() {
    let exports = re_exports("pub use error::{Error, Result};\n");
    let module = ["render".to_string(), "cpu".to_string()];
    for source in [
        "use crate::{error::{Error, Result}, scene::{self, Camera}};\nuse crate::Error;\nuse super::Bias;",
        "// use crate::trace;\n/* use crate::trace; /* nested */ */\n/// [`crate::trace::Tracer`]",
        "const A: &str = \"crate::trace\"; const B: &str = r#\"crate::\"trace\"\"#; const C: u8 = b'\\'';",
        "#[cfg(test)]\nmod tests {\n    use crate::trace::Tracer;\n    mod deeper { use crate::python; }\n}",
        "#[cfg(all(test, feature = \"gpu\"))]\nuse crate::{trace::Tracer, focus};\npub(crate) fn f() {}",
        "pub(in crate::render) fn f() {}\npub(super) fn g() {}",
        "mod inner { use super::super::trace; }\nuse super::trace;",
    ] {
        assert_eq!(forbidden(&module, source, &exports), Vec::<String>::new(), "{source}");
    }
    assert_eq!(forbidden(&["novelty".to_string()], "", &exports).len(), 1);
}

/// The files of a small crate: path, whether it is a list, text.
fn circles_in(crate_files: &[(&str, bool, &str)]) -> Vec<String> {
    let file = |&(path, is_list, text): &(&str, bool, &str)| {
        let module = path.split("::").filter(|part| !part.is_empty()).map(str::to_string).collect::<Module>();
        (module, File { tokens: tokens_without_tests(text).0, is_list })
    };
    circles(graph(&crate_files.iter().map(file).collect())).into_keys().map(|module| module.join("::")).collect()
}

#[test]
fn a_circle_is_found_however_it_is_written() {
    let (list, a_uses_b) =
        ("mod a;\nmod b;\npub use a::A;\npub(crate) use self::b::{B, other as Other};", "use super::b::B;");
    for b in [
        "use super::a::A;",
        "use crate::A;",
        "use crate::{a::A, Other};",
        "use super::A;",
        "fn f() { crate::a::g() }",
        "pub use super::a::A;",
        "mod inner { use super::super::a; }",
        "#[cfg(not(test))]\nuse super::a::A;",
    ] {
        assert_eq!(circles_in(&[("", true, list), ("a", false, a_uses_b), ("b", false, b)]), ["a", "b"], "{b}");
    }
    let parent = [("p", false, "mod child;\nuse child::f;\nfn g() {}"), ("p::child", false, "use super::g;")];
    assert_eq!(circles_in(&parent), ["p", "p::child"]);
    let table =
        [("t", true, "mod a;\npub use a::A;\nstatic ALL: &[A] = &[a::ONE];"), ("t::a", false, "use super::ALL;")];
    assert_eq!(circles_in(&table), ["t", "t::a"], "a list's own table is used and uses");
    let long = [("a", false, "use crate::b;"), ("b", false, "use crate::c;"), ("c", false, "use crate::a;")];
    assert_eq!(circles_in(&[&long[..], &[("d", false, "use crate::a;")]].concat()), ["a", "b", "c"]);
}

#[test]
fn uses_that_close_no_circle_pass() {
    let list = "mod a;\nmod b;\npub use a::A;\npub use b::B;";
    for b in [
        "use super::B;\nuse crate::B as Own;",
        "// use super::a;\nconst TEXT: &str = \"crate::a\";",
        "#[cfg(test)]\nmod tests { use super::super::a::A; }",
        "pub(in crate::a) fn f() {}",
        "use a::A;",
    ] {
        let found = circles_in(&[("", true, list), ("a", false, "use super::B;"), ("b", false, b)]);
        assert_eq!(found, Vec::<String>::new(), "{b}");
    }
}
