//! The source keeps its order: modules import only modules before them, files stay small, pages say what is
//! there.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

use std::fs;
use std::path::{Path, PathBuf};

mod code;
mod modules;
mod pages;

const LONGEST_FILE: usize = 600;
const LONGEST_MAIN: usize = 30;
const WIDEST_COMMENT: usize = 110;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

#[test]
fn files_are_small_and_named_for_what_they_hold() {
    for folder in ["src", "tests", "examples", "benches"].map(|name| root().join(name)) {
        if !folder.is_dir() {
            continue;
        }
        for path in files(&folder, "rs") {
            let lines = fs::read_to_string(&path).unwrap().lines().count();
            assert!(lines <= LONGEST_FILE, "{}: {lines} lines", path.display());
            let stem = path.file_stem().unwrap().to_string_lossy().into_owned();
            let parent = path.parent().unwrap().file_name().unwrap().to_string_lossy().into_owned();
            for name in [stem, parent] {
                assert!(
                    !["util", "utils", "common", "helper", "helpers", "types", "misc"]
                        .contains(&name.as_str()),
                    "{}",
                    path.display()
                );
            }
        }
    }
    let main = fs::read_to_string(root().join("src/main.rs")).unwrap();
    assert!(main.lines().count() <= LONGEST_MAIN);
}

/// But for tables, code and what cannot be broken.
#[test]
fn comments_have_at_most_110_columns() {
    let mut long = Vec::new();
    for folder in ["src", "fft", "tests", "examples", "benches", "python/src", "fuzz/fuzz_targets"] {
        for path in files(&root().join(folder), "rs") {
            let text = fs::read_to_string(&path).unwrap();
            let mut code = false;
            for (line, row) in (1..).zip(text.lines()) {
                let Some(said) =
                    row.trim_start().strip_prefix("//").map(|c| c.trim_start_matches(['/', '!']))
                else {
                    code = false;
                    continue;
                };
                let said = said.trim_start();
                code ^= said.starts_with("```");
                let broken = said.contains(' ') && !said.starts_with('|') && !code;
                if broken && row.chars().count() > WIDEST_COMMENT {
                    long.push(format!("{}:{line}", path.display()));
                }
            }
        }
    }
    assert!(long.is_empty(), "comments of more than {WIDEST_COMMENT} columns: {long:#?}");
}
