//! The front page and the pages of docs/: length, index, links, and commands that the program understands.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use clap::{CommandFactory, Parser};
use nereus::cli::Arguments;

use crate::program::package;

/// The front page and all pages directly below docs/.
pub fn pages() -> Vec<PathBuf> {
    let folder = fs::read_dir(package().join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let mut pages: Vec<PathBuf> = folder.filter(|path| path.extension().is_some_and(|e| e == "md")).collect();
    pages.sort();
    pages.insert(0, package().join("README.md"));
    pages
}

/// A page's name below the package.
pub fn name(page: &Path) -> String {
    page.strip_prefix(package()).unwrap().display().to_string()
}

/// What blocks of a language hold.
pub fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    let begin = format!("```{language}\n");
    page.split(&begin).skip(1).map(|rest| rest.split("```").next().unwrap()).collect()
}

/// Lines of shell blocks, without comments.
pub fn lines_of(page: &str) -> Vec<&str> {
    let lines = blocks(page, "sh").into_iter().flat_map(str::lines);
    lines.map(|line| line.split(" #").next().unwrap().trim()).filter(|line| !line.is_empty()).collect()
}

/// Words of a command, without what is the shell's.
pub fn words(line: &str) -> Vec<&str> {
    line.split(['|', '>']).next().unwrap().split_whitespace().collect()
}

/// Code within a line of a page; blocks are left out.
fn inline_code(page: &str) -> Vec<&str> {
    let prose = page.split("```").step_by(2);
    prose.flat_map(|text| text.split('`').skip(1).step_by(2)).collect()
}

/// Targets of links.
fn links(page: &str) -> Vec<&str> {
    page.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0)).collect()
}

#[test]
fn commands_are_understood_and_tools_exist() {
    let mut faults = Vec::new();
    let mut shown = BTreeSet::new();
    for path in pages() {
        let page = fs::read_to_string(&path).unwrap();
        for line in lines_of(&page) {
            let words = words(line);
            let fits = match words[0] {
                "nereus" => {
                    shown.insert(words[1].to_owned());
                    Arguments::try_parse_from(&words).is_ok()
                }
                "cargo" => true,
                "python3" => package().join(words[1]).is_file(),
                tool => package().join(tool).is_file(),
            };
            if !fits {
                faults.push(format!("{}: {line}", name(&path)));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    // Every subcommand is shown, but for the hidden one.
    let program = Arguments::command();
    let visible = program.get_subcommands().filter(|command| !command.is_hide_set());
    let missing: Vec<_> =
        visible.map(|command| command.get_name()).filter(|name| !shown.contains(*name)).collect();
    assert!(missing.is_empty(), "not shown: {missing:?}");
}

#[test]
fn commands_within_a_line_name_subcommands_and_options_that_exist() {
    let program = Arguments::command();
    let mut faults = Vec::new();
    let mut seen = 0;
    for path in pages() {
        let page = fs::read_to_string(&path).unwrap();
        for code in inline_code(&page).into_iter().filter(|code| code.starts_with("nereus ")) {
            let words = words(code);
            let Some(first) = words.get(1).filter(|word| word.starts_with(char::is_lowercase)) else {
                continue;
            };
            seen += 1;
            let Some(mut command) = program.find_subcommand(first) else {
                faults.push(format!("{}: {code}", name(&path)));
                continue;
            };
            if let Some(inner) = words.get(2).and_then(|word| command.find_subcommand(word)) {
                command = inner;
            }
            let options =
                words.iter().filter_map(|word| word.strip_prefix("--")).filter(|word| *word != "help");
            for option in options {
                if !command.get_arguments().any(|argument| argument.get_long() == Some(option)) {
                    faults.push(format!("{}: {code}: --{option}", name(&path)));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(seen > 60, "only {seen} commands were seen");
}

#[test]
fn the_front_page_is_short_and_the_index_has_every_page_once() {
    let front = fs::read_to_string(package().join("README.md")).unwrap();
    assert!(front.lines().count() <= 150, "README.md has {} lines", front.lines().count());
    let index = fs::read_to_string(package().join("docs/README.md")).unwrap();
    let entries: Vec<&str> = index.lines().filter(|line| line.starts_with("- [")).collect();
    for path in pages().iter().map(|path| name(path)).filter(|name| !name.ends_with("README.md")) {
        let page = path.strip_prefix("docs/").unwrap();
        let begin = format!("- [{page}]({page}): ");
        assert_eq!(
            entries.iter().filter(|line| line.starts_with(&begin)).count(),
            1,
            "{page} in docs/README.md"
        );
    }
}

/// As GitHub names a heading: small letters, hyphens for spaces, nothing else but letters and digits.
fn anchor(heading: &str) -> String {
    let small = heading.trim().to_lowercase().replace(' ', "-");
    small.chars().filter(|c| c.is_alphanumeric() || ['-', '_'].contains(c)).collect()
}

#[test]
fn links_to_headings_lead_to_headings() {
    let mut seen = 0;
    for path in pages() {
        let page = fs::read_to_string(&path).unwrap();
        for link in links(&page).into_iter().filter(|link| !link.contains("://")) {
            let Some((file, wanted)) = link.split_once('#') else { continue };
            seen += 1;
            let other = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            let text = fs::read_to_string(other).unwrap();
            let headings =
                text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#'));
            assert!(headings.map(anchor).any(|found| found == wanted), "{}: {link}", name(&path));
        }
    }
    assert!(seen > 10, "only {seen} links to headings");
}

#[test]
fn examples_of_scenarios_are_toml() {
    for path in pages() {
        let page = fs::read_to_string(&path).unwrap();
        for block in blocks(&page, "toml") {
            let read = block.parse::<toml::Table>();
            assert!(read.is_ok(), "{}: {read:?}\n{block}", name(&path));
        }
    }
}

#[test]
fn statements_of_the_paper_have_commands_and_measured_figures() {
    let page = fs::read_to_string(package().join("docs/paper.md")).unwrap();
    // Commands in the cells of its table can be copied as they stand.
    let cells: Vec<&str> =
        inline_code(&page).into_iter().filter(|code| code.starts_with("nereus ")).collect();
    assert!(cells.len() >= 8, "{cells:?}");
    for code in cells {
        assert!(Arguments::try_parse_from(words(code)).is_ok(), "{code}");
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
