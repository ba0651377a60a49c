//! Which files use each other in a circle, by the paths they name.
//!
//! A list (`mod.rs`, `lib.rs`) is looked through: what it re-exports belongs to the file that declares it, and a re-export is
//! no use. What a list declares itself, a table of techniques say, is its own.

use std::collections::{BTreeMap, BTreeSet};

use super::tokens::{imports, re_exported};

/// A module's path from the crate's root.
pub type Module = Vec<String>;

/// For each file the files it uses.
pub type Graph = BTreeMap<Module, BTreeSet<Module>>;

/// A file's tokens, without tests, and whether it is a list.
pub struct File {
    pub tokens: Vec<String>,
    pub is_list: bool,
}

/// Who uses whom among files.
pub fn graph(files: &BTreeMap<Module, File>) -> Graph {
    let homes: BTreeMap<Module, Module> = files
        .iter()
        .flat_map(|(module, file)| {
            let name = |path: Module| ([module.as_slice(), &path[path.len() - 1..]].concat(), path);
            re_exported(&file.tokens, module).into_iter().filter(|path| !path.is_empty()).map(name)
        })
        .collect();
    let used = |module: &Module, file: &File| {
        let mut paths = imports(&file.tokens, module);
        if file.is_list {
            // Each once: what is named again beside the re-export is used.
            for path in re_exported(&file.tokens, module) {
                if let Some(at) = paths.iter().position(|p| *p == path) {
                    paths.swap_remove(at);
                }
            }
        }
        let mut targets: BTreeSet<Module> = paths.into_iter().filter_map(|path| home(path, files, &homes)).collect();
        targets.remove(module);
        targets
    };
    files.iter().map(|(module, file)| (module.clone(), used(module, file))).collect()
}

/// The file that declares what a path names.
fn home(mut path: Module, files: &BTreeMap<Module, File>, homes: &BTreeMap<Module, Module>) -> Option<Module> {
    let mut seen = BTreeSet::new();
    while let Some(n) = (1..=path.len()).find(|&n| homes.contains_key(&path[..n]) && seen.insert(path[..n].to_vec())) {
        path = [homes[&path[..n]].as_slice(), &path[n..]].concat();
    }
    (1..=path.len()).rev().map(|n| &path[..n]).find(|prefix| files.contains_key(*prefix)).map(<[String]>::to_vec)
}

/// What is left of a graph without those that are in no circle and on no way between two: empty where there is none.
pub fn circles(mut graph: Graph) -> Graph {
    loop {
        let used: BTreeSet<Module> = graph.values().flatten().cloned().collect();
        let count = graph.len();
        graph.retain(|module, targets| !targets.is_empty() && used.contains(module));
        if graph.len() == count {
            return graph;
        }
        let left: BTreeSet<Module> = graph.keys().cloned().collect();
        graph.values_mut().for_each(|targets| targets.retain(|target| left.contains(target)));
    }
}
