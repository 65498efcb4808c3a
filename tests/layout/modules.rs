//! The order of modules, and files that depend on each other in a circle.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use crate::code::{Segments, code, passed_on, paths, without_tests};
use crate::{files, root};

/// Modules in the order in which one may use another. `cli` may use all.
const ORDER: [&str; 32] = [
    "cpu",
    "units",
    "frames",
    "time",
    "rng",
    "pulse",
    "files",
    "inputs",
    "scene",
    "sea",
    "nav",
    "motion",
    "geometry",
    "scattering",
    "radar",
    "paths",
    "echo",
    "transport",
    "recording",
    "sinks",
    "receive",
    "plot",
    "processor",
    "clutter",
    "config",
    "fidelity",
    "pipeline",
    "adequacy",
    "bench",
    "monitor",
    "cli",
    "main",
];

/// The sources: each file's module, and the modules it depends on.
struct Sources {
    files: BTreeMap<Segments, String>,
    uses: BTreeMap<Segments, BTreeSet<Segments>>,
}

impl Sources {
    fn read() -> Self {
        let src = root().join("src");
        let mut files_of = BTreeMap::new();
        for path in files(&src, "rs") {
            let inside = path.strip_prefix(&src).unwrap();
            let text = code(&fs::read_to_string(&path).unwrap());
            files_of.insert(module_of(inside), without_tests(&text).to_owned());
        }
        files_of.retain(|module, _| module.last().is_none_or(|name| name != "tests"));
        let passed: BTreeMap<Segments, Segments> = files_of
            .iter()
            .flat_map(|(module, text)| {
                passed_on(text).into_iter().filter_map(|(name, path)| {
                    Some(([module.as_slice(), &[name]].concat(), absolute(&path, module, &files_of)?))
                })
            })
            .collect();
        let uses = files_of
            .iter()
            .map(|(module, text)| {
                let named = paths(text);
                let used = named.iter().filter_map(|path| absolute(path, module, &files_of));
                let used = used.filter_map(|path| owner(resolved(path, &passed), &files_of));
                (module.clone(), used.filter(|other| other != module).collect())
            })
            .collect();
        Self { files: files_of, uses }
    }
}

/// `a/b.rs` and `a/b/mod.rs` as `[a, b]`.
fn module_of(path: &Path) -> Segments {
    let mut parts: Segments = path.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    let last = parts.pop().unwrap();
    let name = last.strip_suffix(".rs").unwrap();
    if !["mod", "lib"].contains(&name) {
        parts.push(name.to_owned());
    }
    parts
}

/// A path as written in a module, from the root of the crate; `None`: another crate's.
fn absolute(path: &[String], module: &[String], files: &BTreeMap<Segments, String>) -> Option<Segments> {
    let supers = path.iter().take_while(|segment| *segment == "super").count();
    match path.first()?.as_str() {
        "crate" => Some(path[1..].to_vec()),
        "self" => Some([module, &path[1..]].concat()),
        "super" => Some([&module[..module.len().checked_sub(supers)?], &path[supers..]].concat()),
        first => {
            let child = [module, &[first.to_owned()]].concat();
            files.contains_key(&child).then(|| [module, path].concat())
        }
    }
}

/// Where a name that modules pass on is defined.
fn resolved(mut path: Segments, passed: &BTreeMap<Segments, Segments>) -> Segments {
    for _ in 0..8 {
        let found = (1..=path.len()).rev().find_map(|n| Some((n, passed.get(&path[..n])?)));
        let Some((n, target)) = found else { break };
        path = [target.as_slice(), &path[n..]].concat();
    }
    path
}

/// The file that a path leads into.
fn owner(path: Segments, files: &BTreeMap<Segments, String>) -> Option<Segments> {
    (1..=path.len()).rev().map(|n| path[..n].to_vec()).find(|module| files.contains_key(module))
}

fn floor(module: &[String]) -> Option<usize> {
    ORDER.iter().position(|name| module.first().is_some_and(|first| first == name))
}

#[test]
fn modules_import_only_modules_before_them() {
    let sources = Sources::read();
    let mut faults = Vec::new();
    let mut seen = 0;
    for (module, used) in sources.uses.iter().filter(|(module, _)| !module.is_empty()) {
        let Some(own) = floor(module) else {
            faults.push(format!("{} is not in the list of modules", module.join("::")));
            continue;
        };
        for other in used.iter().filter(|other| !other.is_empty()) {
            seen += 1;
            if floor(other).is_none_or(|floor| floor > own) {
                faults.push(format!(
                    "{} uses {}, which stands after it",
                    module.join("::"),
                    other.join("::")
                ));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(seen > 500, "only {seen} uses of modules were seen");
}

/// A module and what lies below it may use each other; other files may not depend on each other in a circle.
#[test]
fn no_files_depend_on_each_other_in_a_circle() {
    let sources = Sources::read();
    let related = |a: &Segments, b: &Segments| a.starts_with(b) || b.starts_with(a);
    let uses: BTreeMap<&Segments, Vec<&Segments>> = sources
        .uses
        .iter()
        .map(|(module, used)| (module, used.iter().filter(|other| !related(module, other)).collect()))
        .collect();
    // All that can be reached from each file.
    let mut reached: BTreeMap<&Segments, BTreeSet<&Segments>> = BTreeMap::new();
    for module in sources.files.keys() {
        let mut found = BTreeSet::new();
        let mut open = vec![module];
        while let Some(next) = open.pop() {
            for other in &uses[next] {
                if found.insert(*other) {
                    open.push(other);
                }
            }
        }
        reached.insert(module, found);
    }
    let mut circles = Vec::new();
    for (module, used) in &uses {
        for other in used.iter().filter(|other| reached[*other].contains(module)) {
            circles.push(format!("{} -> {}", module.join("::"), other.join("::")));
        }
    }
    assert!(circles.is_empty(), "{} uses in circles:\n{}", circles.len(), circles.join("\n"));
}

#[test]
fn lib_names_the_modules_in_order_and_holds_nothing_else() {
    let text = code(&fs::read_to_string(root().join("src/lib.rs")).unwrap());
    let modules: Vec<&str> =
        text.lines().filter_map(|line| line.trim().strip_prefix("pub mod ")?.strip_suffix(';')).collect();
    let floors: Vec<usize> = modules.iter().map(|module| floor(&[(*module).to_owned()]).unwrap()).collect();
    assert!(floors.is_sorted() && floors.len() + 1 == ORDER.len(), "{modules:?}");
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
        let allowed = ["pub mod ", "#![", "#[doc(hidden)]", "pub use "];
        assert!(allowed.iter().any(|begin| line.starts_with(begin)), "lib.rs holds: {line}");
    }
}

#[test]
fn modules_that_make_pulses_know_no_threads() {
    for module in ["scene", "sea", "motion", "geometry", "scattering", "radar", "paths", "echo"] {
        for path in files(&root().join("src").join(module), "rs") {
            // What threads find once for each other is behind this type.
            if path.ends_with("paths/kept.rs") {
                continue;
            }
            let text = code(&fs::read_to_string(&path).unwrap());
            for word in ["std::thread", "rayon::", "Mutex", "crossbeam", "std::net", "std::process"] {
                assert!(!without_tests(&text).contains(word), "{}: {word}", path.display());
            }
        }
    }
}

#[test]
fn transport_and_sinks_know_no_physics() {
    let physics = ["sea", "motion", "geometry", "scattering", "radar", "paths", "echo", "nav"];
    let sources = Sources::read();
    for (module, used) in &sources.uses {
        if !module.first().is_some_and(|first| ["transport", "sinks"].contains(&first.as_str())) {
            continue;
        }
        for other in used {
            let first = other.first().map_or("", String::as_str);
            assert!(!physics.contains(&first), "{} uses {}", module.join("::"), other.join("::"));
        }
    }
}
