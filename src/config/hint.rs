//! What may have been meant by an unknown key.

use super::error::Hint;
use super::keys::{self, Key, Table};

/// Keys that had another name in earlier versions: old, new.
const RENAMED: [(&str, &str); 3] =
    [("faint_db", "sidelobe_db"), ("rehearsal", "nominal"), ("patience_s", "timeout_s")];

/// What may have been meant by a key that the table does not have.
pub(super) fn hint(name: &str, table: &'static Table) -> Hint {
    if let Some((_, key)) =
        RENAMED.iter().find(|(old, key)| *old == name && table.keys.iter().any(|k| k.name == *key))
    {
        return Hint::Like(key);
    }
    let stem = |name: &str| name.rsplit_once('_').map_or(name.to_owned(), |(stem, _)| stem.to_owned());
    // A slip of one letter in a key without a unit is no other key in a wrong one.
    let slipped = |key: &&&Key| key.kind.unit().is_empty() && strsim::osa_distance(key.name, name) == 1;
    if let Some(key) = table.keys.iter().find(slipped) {
        return Hint::Like(key.name);
    }
    for key in table.keys {
        let unit = key.kind.unit();
        if !unit.is_empty() && (stem(key.name) == stem(name) || stem(key.name) == name) {
            return Hint::Unit { key: key.name, unit };
        }
    }
    let most = |key: &str| 1 + key.len() / 4;
    let length = name.chars().count();
    let near = table
        .keys
        .iter()
        // What differs more in length is farther away than that.
        .filter(|key| key.name.len().abs_diff(length) <= most(key.name))
        .map(|key| (strsim::osa_distance(key.name, name), key.name))
        .filter(|(distance, key)| *distance <= most(key))
        .min();
    if let Some((_, key)) = near {
        return Hint::Like(key);
    }
    let elsewhere = keys::TABLES.iter().find(|other| other.keys.iter().any(|key| key.name == name));
    match elsewhere {
        Some(other) => Hint::Elsewhere { table: other.heading },
        None => Hint::Known(names(table.keys)),
    }
}

pub(super) fn names(keys: &[&'static Key]) -> String {
    let names: Vec<&str> = keys.iter().map(|key| key.name).collect();
    names.join(", ")
}
