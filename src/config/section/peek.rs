//! What a table holds, without a word about faults: for what depends on a key that another part reads.

use super::{Choice, Node, Section, Value};
use crate::config::keys::{Absent, Key, Kind};
use crate::config::scalars::plain_number;

impl<'a> Section<'a> {
    /// The number that [`Self::number`] gives, without a word about its faults.
    pub(in crate::config) fn peek(&self, key: &'static Key) -> Option<f64> {
        let Some(entry) = self.entry(key.name) else {
            return if let Absent::Number(value) = key.absent { Some(value) } else { None };
        };
        let Kind::Number { min, max, .. } = key.kind else { return None };
        plain_number(&entry.node).filter(|value| (min..=max).contains(value))
    }

    /// What a key of a table of this table is written as, without a word about faults.
    pub(in crate::config) fn peek_choice_in<C: Choice>(&self, table: &Key, key: &Key) -> Option<C> {
        let entries = self.entry(table.name)?.node.table()?;
        C::named(entries.iter().find(|entry| entry.name == key.name)?.node.text()?)
    }

    /// What is written as a text, without a word about faults.
    pub(in crate::config) fn peek_text(&self, key: &Key) -> Option<&'a str> {
        self.entry(key.name)?.node.text()
    }

    /// Whether a flag is set in any of the tables of an array, without a word about faults.
    pub(in crate::config) fn any_has_flag(&self, tables: &Key, key: &Key) -> bool {
        let Some(Value::Array(items)) = self.entry(tables.name).map(|entry| &entry.node.value) else {
            return false;
        };
        items
            .iter()
            .filter_map(Node::table)
            .flatten()
            .any(|entry| entry.name == key.name && matches!(entry.node.value, Value::Flag(true)))
    }

    /// A number of a table of this table, without a word about faults.
    pub(in crate::config) fn peek_in(&self, table: &Key, key: &'static Key) -> Option<f64> {
        self.within(table)?.peek(key)
    }

    /// A table of this table, to be looked into without a word about faults.
    pub(in crate::config) fn within(&self, table: &Key) -> Option<Section<'_>> {
        let Kind::Section(of) = table.kind else { return None };
        let entry = self.entry(table.name)?;
        Some(Section::new(self.reader, of, String::new(), entry.at, entry.node.table()?))
    }
}
