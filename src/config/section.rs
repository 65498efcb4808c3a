//! A table being read: hands out checked values, collects faults, and at the end knows which keys
//! nobody asked for.

mod peek;

use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};

use super::choices::{self, Choice};
use super::document::{Entry, Node, Value};
use super::error::{At, Fault, Problem, Warning};
use super::hint::{hint, names};
use super::keys::{self, Absent, Key, Kind, Table};
use super::scalars::{origin, plain_number, polarisation_pair, utc};
use crate::nav::csv;
use crate::nav::live::Origin;
use crate::scene::radar::Polarisation;
use crate::time::TimeTag;

/// Whether files that a scenario names must be there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Files {
    /// A file that is not there is a fault.
    Required,
    /// A scenario in a recording: its files may be anywhere.
    Optional,
}

/// What all sections of one scenario share.
pub(super) struct Reader {
    /// Folder of the scenario file.
    folder: PathBuf,
    files: Files,
    faults: RefCell<Vec<Fault>>,
    warnings: RefCell<Vec<Warning>>,
    /// Keys asked for, as (heading, key): the manual's test holds them against the list.
    asked: RefCell<BTreeSet<(&'static str, &'static str)>>,
}

impl Reader {
    pub(super) fn new(folder: &Path, files: Files, faults: Vec<Fault>) -> Self {
        Self {
            folder: folder.to_owned(),
            files,
            faults: RefCell::new(faults),
            warnings: RefCell::new(Vec::new()),
            asked: RefCell::new(BTreeSet::new()),
        }
    }

    /// Whether a file that must be there is not.
    fn lacks(&self, path: &Path) -> bool {
        self.files == Files::Required && !path.is_file()
    }

    /// Whether a file may be missing, and is.
    pub(super) fn is_left_aside(&self, path: &Path) -> bool {
        self.files == Files::Optional && !path.is_file()
    }

    pub(super) fn warn(&self, warning: Warning) {
        self.warnings.borrow_mut().push(warning);
    }

    pub(super) fn finish(self) -> (Vec<Fault>, Vec<Warning>, BTreeSet<(&'static str, &'static str)>) {
        (self.faults.into_inner(), self.warnings.into_inner(), self.asked.into_inner())
    }
}

/// One table.
pub(super) struct Section<'a> {
    reader: &'a Reader,
    table: &'static Table,
    path: String,
    at: At,
    entries: &'a [Entry],
    asked: RefCell<Vec<&'static str>>,
    /// Value of the key `kind`, for the message about keys of other kinds.
    kind: Cell<Option<&'static str>>,
    /// Set when it is unknown which keys belong here; only keys that belong nowhere are then faults.
    lenient: Cell<bool>,
}

impl<'a> Section<'a> {
    /// The whole document.
    pub(super) fn root(reader: &'a Reader, node: &'a Node) -> Self {
        Self::new(reader, &keys::root::TABLE, String::new(), node.at, node.table().unwrap_or(&[]))
    }

    fn new(reader: &'a Reader, table: &'static Table, path: String, at: At, entries: &'a [Entry]) -> Self {
        Self {
            reader,
            table,
            path,
            at,
            entries,
            asked: RefCell::new(Vec::new()),
            kind: Cell::new(None),
            lenient: Cell::new(false),
        }
    }

    pub(super) fn reader(&self) -> &'a Reader {
        self.reader
    }

    /// Whether the key is written.
    pub(super) fn has(&self, key: &Key) -> bool {
        self.entry(key.name).is_some()
    }

    fn entry(&self, name: &str) -> Option<&'a Entry> {
        self.entries.iter().find(|entry| entry.name == name)
    }

    /// A key of this table with the tables that it stands in.
    pub(super) fn path_of(&self, name: &str) -> String {
        if self.path.is_empty() { name.to_owned() } else { format!("{}.{name}", self.path) }
    }

    /// Reports a problem with a key, at its value, or at the table where it is not written.
    pub(super) fn fault(&self, key: &Key, problem: Problem) {
        let at = self.entry(key.name).map_or(self.at, |entry| entry.node.at);
        self.push(at, self.path_of(key.name), problem);
    }

    /// Reports a problem with the table.
    pub(super) fn fault_here(&self, problem: Problem) {
        self.push(self.at, self.path.clone(), problem);
    }

    fn push(&self, at: At, key: String, problem: Problem) {
        self.reader.faults.borrow_mut().push(Fault { at, key, problem });
    }

    fn wrong_type(&self, key: &'static Key, node: &Node) {
        self.fault(key, Problem::Type { found: node.shown(), allowed: key.kind.allowed() });
    }

    /// The value, or a fault where its node holds none.
    fn typed<T>(&self, key: &'static Key, node: &Node, value: Option<T>) -> Option<T> {
        if value.is_none() {
            self.wrong_type(key, node);
        }
        value
    }

    fn out_of_range(&self, key: &'static Key, found: String) {
        self.fault(key, Problem::Range { found, allowed: key.kind.allowed() });
    }

    fn ask(&self, key: &'static Key) -> Option<&'a Node> {
        self.asked.borrow_mut().push(key.name);
        self.reader.asked.borrow_mut().insert((self.table.heading, key.name));
        let found = self.entry(key.name).map(|entry| &entry.node);
        if found.is_none() && matches!(key.absent, Absent::Required) {
            self.fault(key, Problem::Missing { allowed: key.kind.allowed() });
        }
        found
    }

    /// A number; `None` when absent or faulty.
    pub(super) fn number(&self, key: &'static Key) -> Option<f64> {
        let Some(node) = self.ask(key) else {
            return match key.absent {
                Absent::Number(value) => Some(value),
                _ => None,
            };
        };
        let Kind::Number { min, max, above, .. } = key.kind else { return None };
        let value = self.typed(key, node, plain_number(node))?;
        let legal = (min..=max).contains(&value) && !(above && value == min);
        if !legal {
            self.out_of_range(key, node.shown());
        }
        legal.then_some(value)
    }

    /// A whole number; `None` when absent or faulty.
    pub(super) fn count(&self, key: &'static Key) -> Option<u64> {
        let Some(node) = self.ask(key) else {
            return match key.absent {
                Absent::Count(value) => Some(value),
                _ => None,
            };
        };
        let legal = |value: &u64| match key.kind {
            Kind::Count { min, max } => (min..=max).contains(value),
            Kind::OneOf(allowed) => allowed.contains(value),
            _ => false,
        };
        let Value::Integer(value) = node.value else {
            self.wrong_type(key, node);
            return None;
        };
        let value = u64::try_from(value).ok().filter(legal);
        if value.is_none() {
            self.out_of_range(key, node.shown());
        }
        value
    }

    /// The IPv4 address of an interface; `None` when absent or faulty.
    pub(super) fn interface(&self, key: &'static Key) -> Option<Ipv4Addr> {
        let (text, node) = self.text(key)?;
        let address = text.parse().ok().filter(|address: &Ipv4Addr| !address.is_multicast());
        self.typed(key, node, address)
    }

    /// A flag; `None` when faulty.
    pub(super) fn flag(&self, key: &'static Key) -> Option<bool> {
        match (self.ask(key), &key.absent) {
            (Some(Node { value: Value::Flag(flag), .. }), _) => Some(*flag),
            (Some(node), _) => self.typed(key, node, None),
            (None, Absent::Flag(flag)) => Some(*flag),
            (None, _) => None,
        }
    }

    /// A flag whose absence means what others say; `None` when faulty.
    pub(super) fn flag_or(&self, key: &'static Key, absent: bool) -> Option<bool> {
        if self.has(key) {
            return self.flag(key);
        }
        self.ask(key);
        Some(absent)
    }

    /// What one of the words of the key stands for; `None` when absent or faulty.
    pub(super) fn choice<C: Choice>(&self, key: &'static Key) -> Option<C> {
        debug_assert!(matches!(key.kind, Kind::Choice(words) if words() == choices::words::<C>()));
        let chosen = match (self.ask(key), &key.absent) {
            (Some(node), _) => self.typed(key, node, node.text().and_then(C::named)),
            (None, Absent::Word(word)) => C::named(word),
            (None, _) => None,
        };
        if key.name == "kind" {
            self.kind.set(chosen.map(C::word));
            self.lenient.set(chosen.is_none());
        }
        chosen
    }

    /// The same of a key whose default depends on others.
    pub(super) fn choice_or<C: Choice>(&self, key: &'static Key, absent: C) -> Option<C> {
        let written = self.has(key);
        let chosen = self.choice(key);
        if written { chosen } else { Some(absent) }
    }

    fn text(&self, key: &'static Key) -> Option<(&'a str, &'a Node)> {
        let node = self.ask(key)?;
        Some((self.typed(key, node, node.text())?, node))
    }

    /// A name; `None` when absent or faulty.
    pub(super) fn name(&self, key: &'static Key) -> Option<String> {
        let (text, node) = self.text(key)?;
        let letter = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
        // Names become folders and groups of recordings.
        let legal =
            !text.is_empty() && text.len() <= 64 && !text.starts_with('.') && text.chars().all(letter);
        self.typed(key, node, legal.then(|| text.to_owned()))
    }

    /// A text of one line; `None` when absent or faulty.
    pub(super) fn line(&self, key: &'static Key) -> Option<String> {
        let (text, node) = self.text(key)?;
        let legal = !text.chars().any(|c| c.is_control() && c != '\t');
        self.typed(key, node, legal.then(|| text.to_owned()))
    }

    /// A path to something to be made; `None` when absent or faulty.
    pub(super) fn output(&self, key: &'static Key) -> Option<PathBuf> {
        let (text, node) = self.text(key)?;
        let legal = !text.is_empty() && !text.contains('\0');
        self.typed(key, node, legal.then(|| PathBuf::from(text)))
    }

    /// Host and port; `None` when faulty, or absent without a default.
    pub(super) fn address(&self, key: &'static Key) -> Option<String> {
        if !self.has(key) {
            self.ask(key);
            return if let Absent::Word(word) = key.absent { Some(word.to_owned()) } else { None };
        }
        let (text, node) = self.text(key)?;
        let legal = text.rsplit_once(':').is_some_and(|(host, port)| {
            !host.is_empty()
                && !host.contains(char::is_whitespace)
                && port.parse::<u16>().is_ok_and(|p| p > 0)
        });
        self.typed(key, node, legal.then(|| text.to_owned()))
    }

    /// Where live navigation comes from; `None` when absent or faulty.
    pub(super) fn origin(&self, key: &'static Key, baud: u32) -> Option<Origin> {
        let (text, node) = self.text(key)?;
        let origin = self.typed(key, node, origin(text, baud))?;
        let Origin::File(path) = origin else { return Some(origin) };
        self.existing(key, path).map(Origin::File)
    }

    /// A file beside the scenario that exists.
    fn existing(&self, key: &'static Key, path: PathBuf) -> Option<PathBuf> {
        let path = self.reader.folder.join(path);
        if self.reader.lacks(&path) {
            self.fault(key, Problem::NoFile { path });
            return None;
        }
        Some(path)
    }

    /// A file that exists; `None` when faulty.
    pub(super) fn file(&self, key: &'static Key) -> Option<PathBuf> {
        self.existing(key, self.output(key)?)
    }

    /// Whether a key is written as this word; it is then asked for.
    pub(super) fn is_word(&self, key: &'static Key, word: &str) -> bool {
        let is = self.entry(key.name).is_some_and(|entry| entry.node.text() == Some(word));
        if is {
            self.ask(key);
        }
        is
    }

    /// The word of the key (`None` within), or a file that exists; `None` when absent or faulty.
    pub(super) fn file_or(&self, key: &'static Key) -> Option<Option<PathBuf>> {
        let Kind::FileOr(word) = key.kind else { return None };
        if self.is_word(key, word) {
            return Some(None);
        }
        let path = self.reader.folder.join(self.output(key)?);
        if self.reader.lacks(&path) {
            self.fault(key, Problem::NoFileOr { path, allowed: key.kind.allowed() });
            return None;
        }
        Some(Some(path))
    }

    /// An instant; `None` when absent or faulty.
    pub(super) fn time(&self, key: &'static Key) -> Option<TimeTag> {
        let node = self.ask(key)?;
        let time = match &node.value {
            Value::Text(text) | Value::Time(text) => utc(text),
            _ => None,
        };
        self.typed(key, node, time)
    }

    /// A day, since 1970-01-01; `None` when absent or faulty.
    pub(super) fn date(&self, key: &'static Key) -> Option<i64> {
        let node = self.ask(key)?;
        let day = match &node.value {
            Value::Text(text) | Value::Time(text) => csv::day(text),
            _ => None,
        };
        self.typed(key, node, day)
    }

    /// A word of the key (`Err`), or an instant; `None` when absent or faulty.
    pub(super) fn time_or<C: Choice>(&self, key: &'static Key) -> Option<Result<TimeTag, C>> {
        match C::WORDS.iter().find(|(word, _)| self.is_word(key, word)) {
            Some((_, value)) => Some(Err(*value)),
            None => self.time(key).map(Ok),
        }
    }

    /// A list of numbers; `None` when absent without default or faulty.
    pub(super) fn numbers(&self, key: &'static Key) -> Option<Vec<f64>> {
        let Kind::Numbers { least, most, min, max, .. } = key.kind else { return None };
        let Some(node) = self.ask(key) else {
            return matches!(key.absent, Absent::Zeros).then(|| vec![0.0; least]);
        };
        let values = match &node.value {
            Value::Array(items) if (least..=most).contains(&items.len()) => {
                items.iter().map(plain_number).collect::<Option<Vec<f64>>>()
            }
            _ => None,
        };
        let values = self.typed(key, node, values)?;
        if let Some(index) = values.iter().position(|value| !(min..=max).contains(value)) {
            self.out_of_range(key, format!("entry {index}, {},", keys::figure(values[index])));
            return None;
        }
        Some(values)
    }

    /// A list of points; `None` when absent or faulty.
    pub(super) fn points(&self, key: &'static Key) -> Option<Vec<[f64; 2]>> {
        let Kind::Points { least, most, limit, .. } = key.kind else { return None };
        let node = self.ask(key)?;
        let pair = |node: &Node| match &node.value {
            Value::Array(pair) => match &pair[..] {
                [x, y] => Some([plain_number(x)?, plain_number(y)?]),
                _ => None,
            },
            _ => None,
        };
        let points = match &node.value {
            Value::Array(items) if (least..=most).contains(&items.len()) => {
                items.iter().map(pair).collect::<Option<Vec<[f64; 2]>>>()
            }
            _ => None,
        };
        let points = self.typed(key, node, points)?;
        let legal = |value: &f64| (-limit..=limit).contains(value);
        if let Some(index) = points.iter().position(|point| !point.iter().all(legal)) {
            self.out_of_range(key, format!("entry {index}, {:?},", points[index]));
            return None;
        }
        Some(points)
    }

    /// A list of as many numbers as asked; `None` when absent without default or faulty.
    pub(super) fn vector<const N: usize>(&self, key: &'static Key) -> Option<[f64; N]> {
        self.numbers(key)?.try_into().ok()
    }

    /// A list of texts that `read` understands; `None` when absent or faulty.
    pub(super) fn words<T>(&self, key: &'static Key, read: impl Fn(&str) -> Option<T>) -> Option<Vec<T>> {
        let node = self.ask(key)?;
        let Kind::Words { least, most, .. } = key.kind else { return None };
        let words = match &node.value {
            Value::Array(items) if (least..=most).contains(&items.len()) => {
                let word = |item: &Node| item.text().and_then(&read);
                if let Some(bad) = items.iter().position(|item| word(item).is_none()) {
                    let found = format!("entry {bad}, {},", items[bad].shown());
                    self.fault(key, Problem::Type { found, allowed: key.kind.allowed() });
                    return None;
                }
                items.iter().map(word).collect()
            }
            _ => None,
        };
        self.typed(key, node, words)
    }

    /// Receive and transmit polarisation; `None` when faulty.
    pub(super) fn polarisations(&self, key: &'static Key) -> Option<[Polarisation; 2]> {
        let (text, node) = self.text(key)?;
        self.typed(key, node, polarisation_pair(text))
    }

    /// A table of this table; `None` when absent or faulty.
    pub(super) fn section(&self, key: &'static Key) -> Option<Section<'a>> {
        let entry_at = self.entry(key.name).map(|entry| entry.at);
        let node = self.ask(key)?;
        let Kind::Section(table) = key.kind else { return None };
        let entries = self.typed(key, node, node.table())?;
        // A table header is a better place than the value's own.
        let at = entry_at.unwrap_or(node.at);
        Some(Section::new(self.reader, table, self.path_of(key.name), at, entries))
    }

    /// A table of this table, or an empty one; `None` when faulty.
    pub(super) fn section_or_empty(&self, key: &'static Key) -> Option<Section<'a>> {
        if self.has(key) {
            return self.section(key);
        }
        self.ask(key);
        let Kind::Section(table) = key.kind else { return None };
        Some(Section::new(self.reader, table, self.path_of(key.name), self.at, &[]))
    }

    /// A table that may be switched off (`None` within) or be left to its defaults; `None` when faulty.
    pub(super) fn switched(&self, key: &'static Key) -> Option<Option<Section<'a>>> {
        let Kind::Switched(table) = key.kind else { return None };
        let on = |at, entries| Some(Section::new(self.reader, table, self.path_of(key.name), at, entries));
        let entry_at = self.entry(key.name).map(|entry| entry.at);
        match self.ask(key) {
            None => Some(matches!(key.absent, Absent::Flag(true)).then(|| on(self.at, &[])).flatten()),
            Some(Node { value: Value::Flag(flag), at }) => Some(if *flag { on(*at, &[]) } else { None }),
            Some(node) => {
                let entries = self.typed(key, node, node.table())?;
                Some(on(entry_at.unwrap_or(node.at), entries))
            }
        }
    }

    /// The entries of an array of tables; empty when absent or faulty.
    pub(super) fn sections(&self, key: &'static Key) -> Vec<Section<'a>> {
        let Some(node) = self.ask(key) else { return Vec::new() };
        let Kind::Sections(table) = key.kind else { return Vec::new() };
        let Value::Array(items) = &node.value else {
            self.wrong_type(key, node);
            return Vec::new();
        };
        if items.is_empty() && matches!(key.absent, Absent::Required) {
            self.fault(key, Problem::Missing { allowed: key.kind.allowed() });
        }
        let mut sections = Vec::with_capacity(items.len());
        for (index, item) in items.iter().enumerate() {
            let path = format!("{}.{index}", self.path_of(key.name));
            match item.table() {
                Some(entries) => {
                    sections.push(Section::new(self.reader, table, path, item.at, entries));
                }
                None => {
                    let problem = Problem::Type { found: item.shown(), allowed: key.kind.allowed() };
                    self.push(item.at, path, problem);
                }
            }
        }
        sections
    }

    /// Faults the keys that are written although they mean nothing here.
    pub(super) fn idle(&self, keys: &[&'static Key], when: &str) {
        for key in keys {
            if let Some(entry) = self.entry(key.name) {
                self.asked.borrow_mut().push(key.name);
                self.push(entry.at, self.path_of(key.name), Problem::Idle { when: when.to_owned() });
            }
        }
    }

    /// Faults unless exactly one of the keys is written; returns which.
    pub(super) fn exactly_one(&self, keys: &[&'static Key]) -> Option<&'static Key> {
        let written = self.at_most_one(keys);
        if !keys.iter().any(|key| self.has(key)) {
            self.fault_here(Problem::NoneOf { keys: names(keys) });
        }
        written
    }

    /// Faults when more than one of the keys is written; returns the one.
    pub(super) fn at_most_one(&self, keys: &[&'static Key]) -> Option<&'static Key> {
        let written: Vec<&'static Key> = keys.iter().copied().filter(|key| self.has(key)).collect();
        match written[..] {
            [] => None,
            [one] => Some(one),
            [.., last] => {
                self.fault(last, Problem::Several { keys: names(&written) });
                None
            }
        }
    }

    /// The table has been read: every key that nobody asked for is a fault.
    pub(super) fn finish(self) {
        let asked = self.asked.borrow();
        for entry in self.entries {
            if asked.iter().any(|name| *name == entry.name) {
                continue;
            }
            let problem = match self.table.keys.iter().find(|key| key.name == entry.name) {
                Some(_) if self.lenient.get() => continue,
                Some(_) => {
                    let when = match self.kind.get() {
                        Some(kind) => format!("kind = \"{kind}\""),
                        None => "beside the other keys".to_owned(),
                    };
                    Problem::Idle { when }
                }
                None => Problem::Unknown { hint: hint(&entry.name, self.table) },
            };
            self.push(entry.at, self.path_of(&entry.name), problem);
        }
    }
}
