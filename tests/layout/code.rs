//! Reads Rust sources as far as the layout needs: code without comments and strings, and the paths it names.

use std::collections::BTreeMap;

/// A path as segments, `crate` left out.
pub type Segments = Vec<String>;

/// The text without comments and without what strings hold.
pub fn code(text: &str) -> String {
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

/// A file's own code: without its tests.
pub fn without_tests(code: &str) -> &str {
    code.find("#[cfg(test)]\nmod ").map_or(code, |at| &code[..at])
}

/// Paths that a file names in code: those of `use` trees, spread out, and others with at least one `::`.
pub fn paths(code: &str) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    let mut at = 0;
    while let Some((path, end)) = next_path(&code[at..]) {
        let rest = code[at + end..].trim_start();
        if let Some(list) = path.ends_with("::").then(|| rest.strip_prefix('{')).flatten() {
            let list = &list[..closing(list)];
            spread(path.trim_end_matches("::"), list, &mut found);
            at = code.len() - rest.len() + 1 + list.len();
        } else {
            let path = path.trim_end_matches("::");
            if path.contains("::") {
                found.push(segments(path));
            }
            at += end;
        }
    }
    found
}

/// Names that a file passes on: `pub use path::Name` as `Name -> path::Name`.
pub fn passed_on(code: &str) -> BTreeMap<String, Segments> {
    let mut found = BTreeMap::new();
    for (at, _) in code.match_indices("use ") {
        let before = code[..at].trim_end();
        let line = &before[before.rfind(['\n', ';', '}']).map_or(0, |end| end + 1)..];
        if !line.trim_start().starts_with("pub") {
            continue;
        }
        let Some((tree, _)) = code[at + 4..].split_once(';') else { continue };
        let mut leaves = Vec::new();
        match tree.split_once('{') {
            Some((head, list)) => spread(head.trim_end_matches("::"), &list[..closing(list)], &mut leaves),
            None => leaves.push(segments(tree.trim())),
        }
        for leaf in leaves {
            let name = leaf.last().cloned().unwrap_or_default();
            found.insert(name, leaf);
        }
    }
    found
}

fn segments(path: &str) -> Segments {
    let path = path.split(" as ").next().unwrap_or_default();
    path.split("::").map(|segment| segment.trim().to_owned()).collect()
}

/// Where a brace that is open closes.
fn closing(list: &str) -> usize {
    let mut depth = 1;
    for (i, c) in list.char_indices() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if depth == 0 {
            return i;
        }
    }
    list.len()
}

/// The next `a::b::c` or `a::b::` of a text, and where it ends.
fn next_path(code: &str) -> Option<(String, usize)> {
    let word = |c: char| c.is_alphanumeric() || c == '_';
    let mut from = 0;
    loop {
        let start = from + code[from..].find(|c: char| word(c))?;
        let mut end = start + code[start..].find(|c: char| !word(c)).unwrap_or(code.len() - start);
        while code[end..].starts_with("::") {
            end += 2;
            end += code[end..].find(|c: char| !word(c)).unwrap_or(code.len() - end);
        }
        let path = &code[start..end];
        let macro_crate = code[..start].ends_with('$') || code[..start].ends_with("::");
        if path.contains("::") && !macro_crate {
            return Some((path.to_owned(), end));
        }
        from = end;
    }
}

/// Leaves of a `use` tree.
fn spread(head: &str, list: &str, found: &mut Vec<Segments>) {
    let (mut depth, mut start) = (0, 0);
    let mut parts = Vec::new();
    for (i, c) in list.char_indices() {
        depth += i32::from(c == '{') - i32::from(c == '}');
        if c == ',' && depth == 0 {
            parts.push(&list[start..i]);
            start = i + 1;
        }
    }
    parts.push(&list[start..]);
    for part in parts.iter().map(|part| part.trim()).filter(|part| !part.is_empty()) {
        match part.split_once('{') {
            Some((more, inner)) => {
                let head = format!("{head}::{}", more.trim_end_matches("::"));
                spread(&head, &inner[..closing(inner)], found);
            }
            None if part == "self" => found.push(segments(head)),
            None => found.push(segments(&format!("{head}::{part}"))),
        }
    }
}

#[test]
fn code_and_its_paths_are_what_compiles() {
    let text = "use crate::{a::b, c::{d, e::{self, f}}, g as h};\n// crate::no\n/* crate::no */ \
                let s = \"crate::no\"; r#\"crate::no\"# 'x' '\"' '\\'' crate::i::j() pub(crate) $crate::no\n\
                pub use super::k::{L, M}; x.iter::<T>() ";
    let text = code(text);
    let named: Vec<String> = paths(&text).iter().map(|path| path.join("::")).collect();
    assert_eq!(
        named,
        [
            "crate::a::b",
            "crate::c::d",
            "crate::c::e",
            "crate::c::e::f",
            "crate::g",
            "crate::i::j",
            "super::k::L",
            "super::k::M"
        ]
    );
    let passed = passed_on(&text);
    assert_eq!(passed.keys().collect::<Vec<_>>(), ["L", "M"]);
    assert_eq!(passed["L"].join("::"), "super::k::L");
}
