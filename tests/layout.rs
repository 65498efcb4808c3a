//! The house keeps its order: rooms import only rooms before them, files stay small, names stay nouns.
#![allow(clippy::unwrap_used, clippy::expect_used, missing_docs)]

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Rooms in the order in which one may use another.
const ROOMS: [&str; 23] = [
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
    "echo",
    "transport",
    "sinks",
    "receive",
    "imaging",
    "config",
    "plan",
    "pipeline",
];
/// The last room; it may use all.
const TOP: &str = "cli";
const LONGEST_FILE: usize = 800;
const LONGEST_MAIN: usize = 30;

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

/// The text without comments and without what strings hold.
fn code(text: &str) -> String {
    let mut code = String::new();
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        match c {
            '/' if chars.peek() == Some(&'/') => while chars.next_if(|c| *c != '\n').is_some() {},
            '/' if chars.peek() == Some(&'*') => {
                let mut last = ' ';
                for c in chars.by_ref() {
                    if last == '*' && c == '/' {
                        break;
                    }
                    last = c;
                }
            }
            'r' if !code.ends_with(|c: char| c.is_alphanumeric() || c == '_')
                && matches!(chars.peek(), Some('"' | '#')) =>
            {
                let mut hashes = 0;
                while chars.next_if_eq(&'#').is_some() {
                    hashes += 1;
                }
                if chars.next_if_eq(&'"').is_some() {
                    let end = format!("\"{}", "#".repeat(hashes));
                    let mut held = String::new();
                    while !held.ends_with(&end) {
                        match chars.next() {
                            Some(c) => held.push(c),
                            None => break,
                        }
                    }
                } else {
                    // A raw identifier.
                    code.push_str("r#");
                }
            }
            '"' => {
                while let Some(c) = chars.next() {
                    match c {
                        '\\' => drop(chars.next()),
                        '"' => break,
                        _ => {}
                    }
                }
                code.push_str("\"\"");
            }
            // A quote mark as a character would open a string.
            '\'' if chars.peek() == Some(&'"') => {
                chars.next();
                chars.next();
            }
            '\'' if chars.peek() == Some(&'\\') => {
                chars.next();
                chars.next();
                chars.next_if_eq(&'\'');
            }
            c => code.push(c),
        }
    }
    code
}

/// Rooms named by `crate::room` and `crate::{room::..., room}` in code.
fn rooms_used(code: &str) -> BTreeSet<String> {
    let mut used = BTreeSet::new();
    let name = |text: &str| text.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    for (at, _) in code.match_indices("crate::") {
        let before = code[..at].chars().next_back();
        if before.is_some_and(|c| c.is_alphanumeric() || c == '_') {
            continue;
        }
        let rest = &code[at + "crate::".len()..];
        let Some(list) = rest.trim_start().strip_prefix('{') else {
            used.insert(name(rest));
            continue;
        };
        let (mut depth, mut start) = (1, true);
        for (i, c) in list.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 1 => start = true,
                c if start && depth == 1 && !c.is_whitespace() => {
                    used.insert(name(&list[i..]));
                    start = false;
                }
                _ => {}
            }
            if depth == 0 {
                break;
            }
        }
    }
    used
}

/// Place of a room in the order.
fn floor(room: &str) -> Option<usize> {
    if room == TOP { Some(ROOMS.len()) } else { ROOMS.iter().position(|r| *r == room) }
}

#[test]
fn the_reader_of_code_sees_what_compiles() {
    let text = "use crate::{a::b, c::{d, e}, f};\n// crate::no\n/* crate::no */ let s = \"crate::no\"; \
                r#\"crate::no\"# 'x' '\"' '\\'' crate::g::h() pub(crate) $crate::no xcrate::no";
    let used = rooms_used(&code(text).replace("$crate", "no_crate"));
    assert_eq!(used.into_iter().collect::<Vec<_>>(), ["a", "c", "f", "g"]);
}

#[test]
fn rooms_import_only_rooms_before_them() {
    let src = root().join("src");
    let mut faults = Vec::new();
    let mut seen = 0;
    for path in files(&src, "rs") {
        let inside = path.strip_prefix(&src).unwrap();
        let first = inside.components().next().unwrap().as_os_str().to_string_lossy().into_owned();
        let room = first.strip_suffix(".rs").unwrap_or(&first).to_owned();
        if room == "lib" || room == "main" {
            continue;
        }
        let Some(own) = floor(&room) else {
            faults.push(format!("{}: room {room} is not in the list", inside.display()));
            continue;
        };
        for used in rooms_used(&code(&fs::read_to_string(&path).unwrap())) {
            seen += 1;
            match floor(&used) {
                Some(other) if other <= own => {}
                Some(_) => {
                    faults.push(format!("{}: {room} uses {used}, which stands after it", inside.display()))
                }
                None => faults.push(format!("{}: crate::{used} is no room", inside.display())),
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(seen > 20, "only {seen} uses of rooms were seen");
}

#[test]
fn lib_names_the_rooms_in_order_and_holds_nothing_else() {
    let text = code(&fs::read_to_string(root().join("src/lib.rs")).unwrap());
    let rooms: Vec<&str> =
        text.lines().filter_map(|line| line.trim().strip_prefix("pub mod ")?.strip_suffix(';')).collect();
    let floors: Vec<usize> = rooms.iter().map(|room| floor(room).unwrap()).collect();
    assert!(floors.is_sorted(), "{rooms:?}");
    for line in text.lines().map(str::trim).filter(|line| !line.is_empty()) {
        assert!(line.starts_with("pub mod ") || line.starts_with("#!["), "lib.rs holds: {line}");
    }
}

#[test]
fn rooms_that_make_pulses_know_no_threads() {
    let quiet = ["scene", "sea", "motion", "geometry", "scattering", "radar", "echo"];
    for room in quiet {
        let folder = root().join("src").join(room);
        if !folder.is_dir() {
            continue;
        }
        for path in files(&folder, "rs") {
            let text = fs::read_to_string(&path).unwrap();
            // What a file's own tests do is their affair.
            let text = code(text.split("#[cfg(test)]").next().unwrap());
            for word in ["std::thread", "rayon::", "Mutex", "crossbeam", "std::net", "std::process"] {
                assert!(!text.contains(word), "{}: {word}", path.display());
            }
        }
    }
}

#[test]
fn transport_and_sinks_know_no_physics() {
    let physics = ["sea", "motion", "geometry", "scattering", "radar", "echo", "nav"];
    for room in ["transport", "sinks"] {
        for path in files(&root().join("src").join(room), "rs") {
            for used in rooms_used(&code(&fs::read_to_string(&path).unwrap())) {
                assert!(!physics.contains(&used.as_str()), "{}: crate::{used}", path.display());
            }
        }
    }
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
    // Names of documents that are not part of the repository; put together so that this file does not hold them.
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
