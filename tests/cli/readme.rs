//! Commands of the README are commands of the program.

use std::fs;

use clap::Parser;
use nereus::cli::Arguments;

use crate::program::{nereus, package};

/// Lines of shell blocks of a page that start with `nereus`, without comments and redirections.
fn commands_of(page: &str) -> Vec<Vec<String>> {
    let blocks = page.split("```sh\n").skip(1).map(|rest| rest.split("```").next().unwrap());
    blocks
        .flat_map(str::lines)
        .map(|line| line.split(" #").next().unwrap().split(" >").next().unwrap().trim())
        .filter(|line| line.starts_with("nereus "))
        .map(|line| line.split_whitespace().map(str::to_owned).collect())
        .collect()
}

/// Commands of the program in the first shell block of a page, all of them understood; the other lines begin with tools of the package, some
/// with `python3` before them.
pub fn commands_understood(page: &str) -> usize {
    let block = page.split("```sh\n").nth(1).unwrap().split("```").next().unwrap();
    let mut shown = 0;
    for line in block.lines().map(|line| line.split(" #").next().unwrap().trim()) {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[0] {
            "nereus" => {
                shown += 1;
                assert!(Arguments::try_parse_from(&words).is_ok(), "{line}");
            }
            "python3" => assert!(package().join(words[1]).is_file(), "{line}"),
            tool => assert!(package().join(tool).is_file(), "{line}"),
        }
    }
    shown
}

fn commands() -> Vec<Vec<String>> {
    commands_of(&fs::read_to_string(package().join("README.md")).unwrap())
}

#[test]
fn what_the_paper_says_stands_beside_commands_and_measured_figures() {
    let page = fs::read_to_string(package().join("docs/paper.md")).unwrap();
    // In blocks, and in the cells of its table.
    let cells = page.split('`').filter(|code| code.starts_with("nereus ") && !code.contains('\n'));
    let cells = cells.map(|code| code.split_whitespace().map(str::to_owned).collect());
    let commands: Vec<Vec<String>> = commands_of(&page).into_iter().chain(cells).collect();
    assert!(commands.len() >= 8, "{commands:?}");
    for words in &commands {
        assert!(Arguments::try_parse_from(words).is_ok(), "{words:?}");
    }
    // The table of the images is what tools/paper.py measured.
    let mut rows = csv::Reader::from_path(package().join("docs/paper-images.csv")).unwrap();
    let names = rows.headers().unwrap().clone();
    let mut shown = 0;
    for row in rows.records().map(Result::unwrap) {
        let of = |name: &str| row.get(names.iter().position(|n| n == name).unwrap()).unwrap();
        let number = |name: &str, digits: usize| format!("{:.digits$}", of(name).parse::<f64>().unwrap());
        let cell = match of("range_m") {
            "nan" => String::new(),
            _ => format!("{} x {}", number("range_m", 2), number("cross_m", 2)),
        };
        let wanted = format!(
            "| {} | {} | {} | {} | {} | {cell} |",
            of("config"),
            of("channel"),
            number("contrast", 1),
            number("strip_db", 1),
            number("seen", 2)
        );
        assert!(page.contains(&wanted), "{wanted}");
        shown += 1;
    }
    assert_eq!(shown, 16);
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
