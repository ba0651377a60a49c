//! Imports point down, files stay small, and `mod.rs` holds lists: the house rules that a compiler does not know.
//!
//! The table is `docs/ARCHITECTURE.md`'s. What is read of a file is its tokens, so a path in a comment, a string or a
//! test module is no import.

#[path = "layers/tokens.rs"]
mod tokens;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use tokens::{imports, tokens_without_tests};

/// For each module, the others that it may use.
const MAY_USE: &[(&str, &[&str])] = &[
    ("error", &[]),
    ("digest", &[]),
    ("progress", &["error"]),
    ("memory", &["error"]),
    ("simd", &[]),
    ("geometry", &["error"]),
    ("image", &["error", "geometry"]),
    ("parameterization", &["error", "geometry"]),
    ("scene", &["digest", "error", "geometry", "progress"]),
    ("rays", &["error", "geometry", "scene"]),
    ("focus", &["error", "geometry", "image", "parameterization", "rays", "scene"]),
    ("fit", &["error", "focus", "geometry", "parameterization", "rays", "scene"]),
    ("aliasing", &["error", "geometry", "image", "memory", "parameterization", "progress", "rays", "scene", "simd"]),
    // A renderer on a device has a pass that is the twin of aliasing's footprint; the one on the processor calls it.
    (
        "render",
        &["aliasing", "error", "geometry", "image", "memory", "parameterization", "progress", "rays", "scene", "simd"],
    ),
    (
        "study",
        &["aliasing", "error", "geometry", "image", "parameterization", "progress", "rays", "render", "scene", "trace"],
    ),
    // Truth knows no parameterization.
    ("trace", &["error", "geometry", "image", "progress", "rays", "scene"]),
    ("techniques", &["error", "fit", "focus", "geometry", "image", "parameterization", "rays", "scene"]),
    (
        "python",
        &[
            "aliasing",
            "digest",
            "error",
            "focus",
            "geometry",
            "image",
            "parameterization",
            "progress",
            "rays",
            "render",
            "scene",
            "study",
            "techniques",
            "trace",
        ],
    ),
];

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
        return vec![format!("module {top:?} is not in the table of tests/layers.rs")];
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

#[test]
fn imports_point_down() {
    let src = root().join("src");
    let exports = re_exports(&read(&src.join("lib.rs")));
    let sources = files(&src, &["rs"]);
    let test_only: Vec<Vec<String>> = sources
        .iter()
        .flat_map(|path| {
            let (_, names) = tokens_without_tests(&read(path));
            let module = module_of(path);
            names.into_iter().map(move |name| [module.clone(), vec![name]].concat())
        })
        .collect();
    let mut complaints = Vec::new();
    for path in &sources {
        let module = module_of(path);
        if !test_only.iter().any(|exempt| module.starts_with(exempt)) {
            complaints.extend(forbidden(&module, &read(path), &exports));
        }
    }
    assert!(sources.len() > 20, "only {} sources found: is the walk broken?", sources.len());
    assert!(complaints.is_empty(), "imports that the table of layers forbids:\n{}", complaints.join("\n"));
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
        if path.file_name().is_some_and(|name| name == "mod.rs" || name == "lib.rs") {
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
