//! Inputs that once went wrong stay tested: each of `tests/data/cases` is named by a test.

use std::fs;
use std::path::Path;

use crate::program::package;

/// Those that no test names yet.
const MISSING: &[&str] = &[];

/// All sources below a folder but this file.
fn sources(folder: &Path, text: &mut String) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, text);
        } else if path.extension().is_some_and(|ends| ends == "rs") && !path.ends_with(file!()) {
            text.push_str(&fs::read_to_string(path).unwrap());
        }
    }
}

#[test]
fn every_case_is_named_by_a_test() {
    let mut text = String::new();
    for tests in ["cli", "nav", "agreement", "physics"] {
        sources(&package().join("tests").join(tests), &mut text);
    }
    let cases = package().join("tests/data/cases");
    let names = fs::read_dir(cases).unwrap().map(|entry| entry.unwrap().path());
    let named = |path: &Path| {
        let is_case = path.is_dir() || path.extension().is_some_and(|ends| ends == "toml");
        is_case.then(|| path.file_name().unwrap().to_string_lossy().trim_end_matches(".toml").to_owned())
    };
    let names: Vec<String> = names.filter_map(|path| named(&path)).collect();
    assert!(names.len() > 20, "{names:?}");
    let unnamed: Vec<&str> = names.iter().map(String::as_str).filter(|name| !text.contains(name)).collect();
    let forgotten: Vec<_> = unnamed.iter().filter(|name| !MISSING.contains(name)).collect();
    assert!(forgotten.is_empty(), "no test of tests/{{cli, nav, agreement, physics}} names {forgotten:?}");
    let found: Vec<_> = MISSING.iter().filter(|name| !unnamed.contains(name)).collect();
    assert!(found.is_empty(), "named by a test, or gone: take them off the list: {found:?}");
}
