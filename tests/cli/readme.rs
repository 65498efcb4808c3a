//! Commands of the README are commands of the program.

use std::fs;

use clap::Parser;
use nereus::cli::Arguments;

use crate::program::{nereus, package};

/// Lines of shell blocks that start with `nereus`, without comments and redirections.
fn commands() -> Vec<Vec<String>> {
    let readme = fs::read_to_string(package().join("README.md")).unwrap();
    let blocks = readme.split("```sh\n").skip(1).map(|rest| rest.split("```").next().unwrap());
    blocks
        .flat_map(str::lines)
        .map(|line| line.split(" #").next().unwrap().split(" >").next().unwrap().trim())
        .filter(|line| line.starts_with("nereus "))
        .map(|line| line.split_whitespace().map(str::to_owned).collect())
        .collect()
}

#[test]
fn commands_of_the_readme_are_understood() {
    let commands = commands();
    assert!(commands.len() >= 10, "{commands:?}");
    for words in &commands {
        assert!(Arguments::try_parse_from(words).is_ok(), "{words:?}");
    }
    for word in [
        "run", "check", "new", "merge", "sea", "snapshot", "wake", "table", "bench", "tradeoff", "receive",
        "nav", "focus", "speckle",
    ] {
        assert!(commands.iter().any(|words| words[1] == word), "README does not show {word}");
    }
}

#[test]
fn commands_of_the_readme_that_only_print_work() {
    for words in commands().iter().filter(|words| ["check", "new", "table"].contains(&words[1].as_str())) {
        let arguments: Vec<&str> = words[1..].iter().map(String::as_str).collect();
        let ended = nereus(package(), &arguments);
        assert_eq!(ended.code, 0, "{words:?}: {}", ended.stderr);
    }
}

#[test]
fn tools_of_the_readme_exist() {
    let readme = fs::read_to_string(package().join("README.md")).unwrap();
    for tool in [
        "tools/quickstart",
        "tools/test",
        "tools/gallery",
        "tools/baseline.py",
        "tools/steady.py",
        "tools/mocomp",
    ] {
        assert!(readme.contains(tool) && package().join(tool).is_file(), "{tool}");
    }
}
