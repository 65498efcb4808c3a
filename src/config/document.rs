//! A scenario as written: a tree of values that know where they stand, and overrides put on it.

use std::fmt::Write as _;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::{At, Fault, Problem};

/// In the place of the number of an entry: a new one, behind those that are there.
const APPEND: &str = "+";
/// Longest piece of a scenario that a fault quotes, characters.
const LONGEST: usize = 60;
/// Entries of an array that a fault names.
const MOST_NAMED: usize = 8;

/// A value and its place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    pub(super) value: Value,
    pub(super) at: At,
}

/// A value as TOML knows it.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    Text(String),
    Integer(i128),
    Number(f64),
    Flag(bool),
    Time(String),
    Array(Vec<Node>),
    Table(Vec<Entry>),
}

/// A key of a table.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entry {
    pub(super) name: String,
    pub(super) at: At,
    pub(super) node: Node,
}

impl Node {
    pub(super) fn table(&self) -> Option<&[Entry]> {
        match &self.value {
            Value::Table(entries) => Some(entries),
            _ => None,
        }
    }

    pub(super) fn text(&self) -> Option<&str> {
        match &self.value {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The value as a fault shows it: short, on one line.
    pub(super) fn shown(&self) -> String {
        let text = match &self.value {
            Value::Table(_) => "a table".to_owned(),
            Value::Array(items) if items.iter().any(|n| matches!(n.value, Value::Table(_))) => {
                "an array of tables".to_owned()
            }
            _ => inline(self),
        };
        if text.chars().count() <= LONGEST {
            return text;
        }
        text.chars().take(LONGEST).chain("...".chars()).collect()
    }
}

/// Turns byte offsets into lines and columns.
struct Places<'t> {
    text: &'t str,
    line_starts: Vec<usize>,
    /// Characters before every [`BLOCK`]-th byte, so that a long line is not counted again for each of its
    /// values.
    before: Vec<usize>,
}

/// Bytes from one counted place to the next.
const BLOCK: usize = 256;

impl<'t> Places<'t> {
    fn new(text: &'t str) -> Self {
        let starts = text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i + 1);
        let mut characters = 0;
        let mut before = Vec::with_capacity(text.len() / BLOCK + 1);
        for block in text.as_bytes().chunks(BLOCK) {
            before.push(characters);
            characters += characters_of(block);
        }
        Self { text, line_starts: std::iter::once(0).chain(starts).collect(), before }
    }

    /// Characters before a byte.
    fn characters(&self, offset: usize) -> usize {
        let bytes = self.text.as_bytes();
        let offset = offset.min(bytes.len());
        let counted = self.before.get(offset / BLOCK).copied();
        let from = if counted.is_some() { offset / BLOCK * BLOCK } else { 0 };
        counted.unwrap_or(0) + characters_of(bytes.get(from..offset).unwrap_or_default())
    }

    fn at(&self, offset: usize) -> At {
        let line = self.line_starts.partition_point(|&start| start <= offset).max(1);
        let start = self.line_starts[line - 1];
        At::File { line, column: self.characters(offset).saturating_sub(self.characters(start)) + 1 }
    }
}

/// Characters of UTF-8 that begin in some bytes.
fn characters_of(bytes: &[u8]) -> usize {
    bytes.iter().filter(|byte| **byte & 0xC0 != 0x80).count()
}

/// Reads TOML. What the parser could make out is returned beside its faults.
pub(super) fn read(text: &str) -> (Node, Vec<Fault>) {
    let places = Places::new(text);
    let (table, errors) = DeTable::parse_recoverable(text);
    let faults = errors
        .iter()
        .map(|error| {
            let span = error.span().unwrap_or_default();
            let mut message = error.message().trim().replace('\n', " ");
            if let Some(written) = text.get(span.clone()).filter(|t| !t.is_empty() && !t.contains('\n')) {
                message = format!("{message} (at {})", written.chars().take(LONGEST).collect::<String>());
            }
            let problem = Problem::Syntax { message };
            Fault { at: places.at(span.start), key: String::new(), problem }
        })
        .collect();
    let root = Node { value: entries(table.get_ref(), &places), at: At::File { line: 1, column: 1 } };
    (root, faults)
}

fn entries(table: &DeTable<'_>, places: &Places<'_>) -> Value {
    let entry = |(name, value): (&Spanned<_>, &Spanned<DeValue<'_>>)| {
        let name: &Spanned<std::borrow::Cow<'_, str>> = name;
        Entry {
            name: name.get_ref().clone().into_owned(),
            at: places.at(name.span().start),
            node: node(value, places),
        }
    };
    Value::Table(table.iter().map(entry).collect())
}

fn node(value: &Spanned<DeValue<'_>>, places: &Places<'_>) -> Node {
    Node { at: places.at(value.span().start), value: convert(value.get_ref(), places) }
}

fn convert(value: &DeValue<'_>, places: &Places<'_>) -> Value {
    match value {
        DeValue::String(text) => Value::Text(text.clone().into_owned()),
        DeValue::Integer(digits) => i128::from_str_radix(digits.as_str(), digits.radix())
            .map_or(Value::Number(f64::INFINITY), Value::Integer),
        DeValue::Float(digits) => Value::Number(digits.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(flag) => Value::Flag(*flag),
        DeValue::Datetime(time) => Value::Time(time.to_string()),
        DeValue::Array(items) => Value::Array(items.iter().map(|item| node(item, places)).collect()),
        DeValue::Table(table) => entries(table, places),
    }
}

/// Puts `KEY=VALUE` overrides on the tree. The value is TOML, or plain text where it is not.
pub(super) fn put(root: &mut Node, overrides: &[(String, String)]) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (key, text) in overrides {
        let value = override_value(text);
        if let Err(reason) = put_one(root, key, value) {
            faults.push(Fault { at: At::Override, key: key.clone(), problem: Problem::Lost { reason } });
        }
    }
    faults
}

fn override_value(text: &str) -> Value {
    // The value stands at the end of a document of one key, so that every form of TOML is understood;
    // a line feed would let it bring keys of its own.
    let plain = || Value::Text(text.to_owned());
    if text.contains(['\n', '\r']) {
        return plain();
    }
    let line = format!("value = {text}");
    let (root, faults) = read(&line);
    match root.value {
        Value::Table(mut entries) if faults.is_empty() && entries.len() == 1 => {
            let mut node = entries.remove(0).node;
            mark(&mut node);
            node.value
        }
        _ => plain(),
    }
}

/// Everything inside an override came from the command line.
fn mark(node: &mut Node) {
    node.at = At::Override;
    match &mut node.value {
        Value::Array(items) => items.iter_mut().for_each(mark),
        Value::Table(entries) => {
            for entry in entries {
                entry.at = At::Override;
                mark(&mut entry.node);
            }
        }
        _ => {}
    }
}

fn put_one(root: &mut Node, key: &str, value: Value) -> Result<(), String> {
    if key.split('.').any(str::is_empty) {
        return Err(
            "a key is names joined by dots, such as radar.prf_hz, target.0.rcs_m2 or sink.+".to_owned()
        );
    }
    let mut here = root;
    let mut parts = key.split('.').peekable();
    let mut path = String::new();
    while let Some(part) = parts.next() {
        let last = parts.peek().is_none();
        let parent = if path.is_empty() { "the scenario".to_owned() } else { path.clone() };
        path = if path.is_empty() { part.to_owned() } else { format!("{path}.{part}") };
        here = match &mut here.value {
            Value::Table(entries) => {
                let found = entries.iter().position(|entry| entry.name == part);
                let appends = parts.peek() == Some(&APPEND);
                let index = found.unwrap_or_else(|| {
                    let value = if appends { Value::Array(Vec::new()) } else { Value::Table(Vec::new()) };
                    let node = Node { value, at: At::Override };
                    entries.push(Entry { name: part.to_owned(), at: At::Override, node });
                    entries.len() - 1
                });
                let entry = &mut entries[index];
                if last {
                    entry.at = At::Override;
                }
                &mut entry.node
            }
            Value::Array(items) => {
                if part == APPEND {
                    items.push(Node { value: Value::Table(Vec::new()), at: At::Override });
                }
                let len = items.len();
                let part = if part == APPEND { (len - 1).to_string() } else { part.to_owned() };
                let index = part.parse::<usize>().ok().filter(|index| *index < len);
                match index.or_else(|| named(items, &part)) {
                    Some(index) => &mut items[index],
                    None if len == 0 => return Err(format!("{parent} has no entries")),
                    None => {
                        let last = len - 1;
                        return Err(format!("{parent} has entries 0 to {last}{}, not {part}", names(items)));
                    }
                }
            }
            _ => return Err(format!("{parent} is not a table")),
        };
    }
    *here = Node { value, at: At::Override };
    Ok(())
}

/// Writes the tree as TOML that reads back as the same tree.
pub(super) fn write(root: &Node) -> String {
    let mut text = String::new();
    if let Value::Table(entries) = &root.value {
        write_table(&mut text, "", entries);
    }
    text
}

fn is_section(node: &Node) -> bool {
    matches!(node.value, Value::Table(_))
}

fn is_sections(node: &Node) -> bool {
    matches!(&node.value, Value::Array(items) if !items.is_empty() && items.iter().all(is_section))
}

/// The name of an entry of an array.
fn name_of(item: &Node) -> Option<&str> {
    item.table()?.iter().find(|entry| entry.name == "name")?.node.text()
}

/// The only entry of that name.
fn named(items: &[Node], name: &str) -> Option<usize> {
    let mut found = (0..items.len()).filter(|index| name_of(&items[*index]) == Some(name));
    found.next().filter(|_| found.next().is_none())
}

/// Names of entries, where they have any.
fn names(items: &[Node]) -> String {
    let names: Vec<&str> = items.iter().filter_map(name_of).collect();
    match names.get(..MOST_NAMED) {
        _ if names.is_empty() => String::new(),
        Some(first) if names.len() > MOST_NAMED => format!(" ({}, ...)", first.join(", ")),
        _ => format!(" ({})", names.join(", ")),
    }
}

fn write_table(text: &mut String, path: &str, entries: &[Entry]) {
    for entry in entries.iter().filter(|e| !is_section(&e.node) && !is_sections(&e.node)) {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{} = {}", bare(&entry.name), inline(&entry.node));
    }
    for entry in entries {
        let name = bare(&entry.name);
        let path = if path.is_empty() { name } else { format!("{path}.{name}") };
        match &entry.node.value {
            Value::Table(inner) => {
                let _ = writeln!(text, "\n[{path}]");
                write_table(text, &path, inner);
            }
            Value::Array(items) if is_sections(&entry.node) => {
                for item in items.iter().filter_map(Node::table) {
                    let _ = writeln!(text, "\n[[{path}]]");
                    write_table(text, &path, item);
                }
            }
            _ => {}
        }
    }
}

fn bare(name: &str) -> String {
    let plain = !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-');
    if plain { name.to_owned() } else { quoted(name) }
}

fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => quoted.push_str("\\\""),
            '\\' => quoted.push_str("\\\\"),
            c if c.is_control() => {
                let _ = write!(quoted, "\\u{:04X}", u32::from(c));
            }
            c => quoted.push(c),
        }
    }
    quoted.push('"');
    quoted
}

fn inline(node: &Node) -> String {
    match &node.value {
        Value::Text(text) => quoted(text),
        Value::Integer(value) => value.to_string(),
        Value::Number(value) if value.is_finite() => format!("{value:?}"),
        Value::Number(value) if value.is_nan() => "nan".to_owned(),
        Value::Number(value) => if *value > 0.0 { "inf" } else { "-inf" }.to_owned(),
        Value::Flag(flag) => flag.to_string(),
        Value::Time(time) => time.clone(),
        Value::Array(items) => {
            let items: Vec<String> = items.iter().map(inline).collect();
            format!("[{}]", items.join(", "))
        }
        Value::Table(entries) => {
            let entries: Vec<String> =
                entries.iter().map(|e| format!("{} = {}", bare(&e.name), inline(&e.node))).collect();
            format!("{{ {} }}", entries.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tree without its places.
    fn bare_tree(node: &Node) -> String {
        inline(node)
    }

    #[test]
    fn what_is_written_reads_back() {
        let text = "a = 1\nb = [1.5, -2e30, 1_000]\n\"odd key\" = \"q\\\"\\\\\\n\\u0001é\"\n[t]\nx = 0x10\n\
                    u = { v = [{ w = true }, 2], z = [] }\nwhen = 2018-05-30T20:15:00Z\n[[s]]\nn = 1\n[s.k]\nm = 0.1\n[[s]]\n";
        let (tree, faults) = read(text);
        assert!(faults.is_empty(), "{faults:?}");
        let (again, faults) = read(&write(&tree));
        assert!(faults.is_empty(), "{faults:?}\n{}", write(&tree));
        // `write` moves tables behind values; compare after a second turn, which is a fixed point.
        assert_eq!(write(&again), write(&tree));
        assert_eq!(bare_tree(&again).len(), bare_tree(&tree).len());
    }

    #[test]
    fn numbers_keep_every_bit() {
        for value in [0.1, 1.0 / 3.0, 1e300, 5e-324, 6_371_000.0, 1e16, 123_456_789.123_456_78] {
            let node = Node { value: Value::Number(value), at: At::Override };
            let (tree, faults) = read(&format!("x = {}", inline(&node)));
            assert!(faults.is_empty(), "{}: {faults:?}", inline(&node));
            assert_eq!(tree.table().unwrap()[0].node.value, Value::Number(value));
        }
    }

    #[test]
    fn a_plus_appends_an_entry() {
        let (mut root, _) = read("[[sink]]\nkind = \"null\"\n");
        let list = [
            ("sink.+", "{ kind = \"plain\", path = \"x\" }"),
            ("sink.+.kind", "null"),
            ("target.+.rcs_m2", "1"),
        ];
        let list: Vec<_> = list.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
        assert!(put(&mut root, &list).is_empty());
        insta::assert_snapshot!(write(&root), @r#"

        [[sink]]
        kind = "null"

        [[sink]]
        kind = "plain"
        path = "x"

        [[sink]]
        kind = "null"

        [[target]]
        rcs_m2 = 1
        "#);
    }

    #[test]
    fn an_override_brings_one_value_only() {
        assert_eq!(override_value("1\nb = 2"), Value::Text("1\nb = 2".to_owned()));
        assert_eq!(override_value("fast"), Value::Text("fast".to_owned()));
        assert_eq!(override_value("\"fast\""), Value::Text("fast".to_owned()));
        assert_eq!(override_value("2.5"), Value::Number(2.5));
        assert!(matches!(override_value("[1, 2]"), Value::Array(_)));
    }
}
