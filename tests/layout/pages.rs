//! Pages: scenarios, decisions, links, and what is cited of the physics page.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::{files, root};

#[test]
fn every_scenario_is_described() {
    let readme = fs::read_to_string(root().join("configs/README.md")).unwrap();
    let mut scenarios = 0;
    for path in files(&root().join("configs"), "toml") {
        scenarios += 1;
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert!(readme.contains(&format!("`{name}`")), "{name} is missing in configs/README.md");
    }
    assert!(scenarios > 0);
    for word in readme.split('`').filter(|word| word.ends_with(".toml") && !word.contains(' ')) {
        assert!(root().join("configs").join(word).is_file(), "configs/README.md names {word}");
    }
}

/// Pages of decisions, without their index.
fn decisions() -> Vec<PathBuf> {
    let mut pages = files(&root().join("docs/decisions"), "md");
    pages.retain(|path| path.file_name().unwrap() != "README.md");
    pages
}

#[test]
fn decisions_are_numbered_without_gaps() {
    let pages = decisions();
    assert!(!pages.is_empty());
    for (index, path) in pages.iter().enumerate() {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert!(name.starts_with(&format!("{:04}-", index + 1)), "{name} is not number {}", index + 1);
        let text = fs::read_to_string(path).unwrap();
        for heading in ["## Question", "## Choice", "## Price"] {
            assert!(text.contains(heading), "{name} lacks {heading}");
        }
    }
}

#[test]
fn decisions_have_a_status_and_a_line_in_the_index() {
    let index = fs::read_to_string(root().join("docs/decisions/README.md")).unwrap();
    let entries: Vec<&str> = index.lines().filter(|line| line.starts_with("- ")).collect();
    let pages = decisions();
    assert_eq!(entries.len(), pages.len(), "lines of docs/decisions/README.md, pages");
    for (path, entry) in pages.iter().zip(entries) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let text = fs::read_to_string(path).unwrap();
        let mut lines = text.lines();
        let heading = lines.next().and_then(|line| line.strip_prefix("# ")?.split_once(". "));
        let (number, title) =
            heading.unwrap_or_else(|| panic!("{name}: the first line is no numbered title"));
        assert_eq!(number, name[..4].trim_start_matches('0'), "{name}");

        // An empty line, then the status.
        let line = lines.nth(1).unwrap_or_default();
        let parts = line.strip_suffix('.').and_then(|line| line.rsplit_once(". Date: "));
        let (status, date) = parts.unwrap_or_else(|| panic!("{name}: no status and date: {line}"));
        let superseded = status.starts_with("Status: Superseded ");
        assert!(superseded || status == "Status: Accepted", "{name}: {status}");
        assert!(date.len() == 10 && date.bytes().all(|c| c.is_ascii_digit() || c == b'-'), "{name}: {date}");

        let begin = format!("- [{}]({name}): {title}", &name[..4]);
        assert!(entry.starts_with(&begin), "docs/decisions/README.md has {entry}, not {begin}");
        assert_eq!(superseded, entry[begin.len()..].contains("(superseded "), "{name} in the index");
    }
}

#[test]
fn links_between_pages_lead_to_files() {
    let top = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", "fuzz/README.md"];
    let mut pages = top.map(|page| root().join(page)).to_vec();
    for folder in ["docs", "configs", "hulls"] {
        pages.extend(files(&root().join(folder), "md"));
    }
    let mut faults = Vec::new();
    let mut links = 0;
    for page in pages {
        let text = fs::read_to_string(&page).unwrap();
        for (at, _) in text.match_indices("](") {
            let Some((target, _)) = text[at + 2..].split_once(')') else { continue };
            let file = target.split('#').next().unwrap();
            if file.is_empty() || file.contains("://") || file.contains(char::is_whitespace) {
                continue;
            }
            links += 1;
            if !page.parent().unwrap().join(file).exists() {
                faults.push(format!("{}: {target}", page.display()));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(links > 60, "only {links} links were seen");
}

/// Section numbers that follow a name of the physics page on a line: "section 3.1", "sections 3.1 and 3.2".
fn sections_cited(after: &str) -> Vec<String> {
    let text = after.trim_start_matches(['`', ')', ',', ':', ' ']);
    // A link names its file in brackets after the text.
    let text = text.strip_prefix("](physics.md)").unwrap_or(text).trim_start();
    let Some(mut rest) = text.strip_prefix("sections ").or_else(|| text.strip_prefix("section ")) else {
        return Vec::new();
    };
    let mut found = Vec::new();
    loop {
        let number: String = rest.chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
        let section = number.trim_end_matches('.');
        if section.is_empty() {
            return found;
        }
        found.push(section.to_owned());
        rest = &rest[section.len()..];
        let Some(next) = rest.strip_prefix(", ").or_else(|| rest.strip_prefix(" and ")) else { return found };
        rest = next;
    }
}

/// Text files that may cite the physics page.
fn cited_from() -> Vec<PathBuf> {
    let mut found = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md"].map(|page| root().join(page)).to_vec();
    for folder in ["src", "tests", "tools", "docs", "configs", "hulls", "examples", "benches"] {
        for extension in ["rs", "md", "py", "toml"] {
            found.extend(files(&root().join(folder), extension));
        }
    }
    // Tools without an ending.
    let tools = fs::read_dir(root().join("tools")).unwrap().map(|entry| entry.unwrap().path());
    found.extend(tools.filter(|path| path.is_file() && path.extension().is_none()));
    found
}

#[test]
fn sections_of_the_physics_page_exist() {
    let page = fs::read_to_string(root().join("docs/physics.md")).unwrap();
    let headings: Vec<&str> = page
        .lines()
        .filter_map(|line| line.strip_prefix("### ").or_else(|| line.strip_prefix("## ")))
        .filter_map(|heading| heading.split(' ').next())
        .filter(|number| number.starts_with(|c: char| c.is_ascii_digit()))
        .collect();
    let once: BTreeSet<&str> = headings.iter().copied().collect();
    assert!(once.len() == headings.len() && once.len() > 20, "{headings:?}");

    let mut faults = Vec::new();
    let mut cited = 0;
    let mut check = |path: &Path, line: usize, sections: Vec<String>| {
        cited += sections.len();
        let missing = sections.iter().filter(|section| !once.contains(section.as_str()));
        faults.extend(missing.map(|section| format!("{}:{line}: section {section}", path.display())));
    };
    for path in cited_from() {
        let Ok(text) = fs::read_to_string(&path) else { continue };
        for (number, line) in (1..).zip(text.lines()) {
            for (at, name) in line.match_indices("docs/physics.md") {
                check(&path, number, sections_cited(&line[at + name.len()..]));
            }
        }
    }
    // The page cites itself by the bare word.
    for (number, line) in (1..).zip(page.lines()) {
        for (at, _) in line.match_indices("section") {
            check(Path::new("docs/physics.md"), number, sections_cited(&line[at..]));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(cited > 60, "only {cited} sections are cited");
}

#[test]
fn physics_is_cited_from_documents_that_are_here() {
    // Names of documents that are not part of the repository; put together so that this file does not hold
    // them.
    let in_capitals = format!("{}{}", "PHYS", "ICS");
    let in_any_case = ["project", "physics"].map(|word| format!("{word} notes"));
    let mut faults = Vec::new();
    for path in cited_from() {
        let Ok(text) = fs::read_to_string(&path) else { continue };
        for (number, line) in (1..).zip(text.lines()) {
            let lower = line.to_lowercase();
            if line.contains(&in_capitals) || in_any_case.iter().any(|name| lower.contains(name)) {
                faults.push(format!("{}:{number}: {}", path.display(), line.trim()));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
