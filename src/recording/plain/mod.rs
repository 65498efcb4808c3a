//! Recordings as folders of plain files, for machines without HDF5.
//!
//! `meta.json` holds the header and, under `columns`, the type, row shape and description
//! ([`super::descriptions`]) of every per-pulse file; under `descriptions` that of what is there once. Column
//! `a/b` is the file `a/b.bin`: rows one after the other in C order, without any header, so
//!
//! ```python
//! import json, numpy as np
//! meta = json.load(open("rec/meta.json"))
//! n = np.fromfile("rec/pulse/index.bin", "<u8").size
//! iq = np.fromfile("rec/iq.bin", meta["columns"]["iq"]["dtype"])
//! iq = iq[: n * iq_width].reshape(n, *meta["columns"]["iq"]["shape"])
//! ```
//!
//! Codes of a converter are pairs of i2: a trailing axis of 2 (in-phase, quadrature). `replica.bin` is
//! complex64. `pulse/index.bin` is written last at every flush, at least every half second: after a kill the
//! first `n` rows of every file are complete, n being its length. The columns are listed in
//! [`super::descriptions`]. Where reports may be changed, `truth/changes.jsonl` has a line for every change
//! up to the last pulse:
//! `{"pulse":2220,"time_ns":..,"platform":"aircraft","text":"step position.up 5 m","source":"scenario"}`.

use std::fs;
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};

use serde_json::Value;

use super::columns::Column;
use super::fault::{READING, RecordingError};
use crate::files::{FileFault, Holding, Recognised};
use crate::inputs;
use crate::pulse::log::{Entry, Log};

mod header;
pub(crate) mod reader;
pub(crate) mod writer;

pub use header::plain_header;

/// The header.
const META: &str = "meta.json";
/// The transmitted pulse.
const REPLICA: &str = "replica.bin";
/// Changes of reports.
const CHANGES: &str = "truth/changes.jsonl";
/// Longest list of changes that is read, bytes: a run takes 1024 of them.
const MOST_CHANGES: u64 = 1 << 20;

/// The changes that a folder lists; `None` where it has no list. A line that is cut, as the last one of a run
/// that was killed, is left out.
///
/// # Errors
/// A list that cannot be read, or is longer than any that a run makes.
pub fn changes(folder: &Path) -> Result<Option<Log>, RecordingError> {
    let path = folder.join(CHANGES);
    let bytes = match inputs::read(&path, MOST_CHANGES) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        read => read.map_err(FileFault::io(&path, READING))?,
    };
    if bytes.len() as u64 > MOST_CHANGES {
        let detail = format!("{CHANGES} has more than {MOST_CHANGES} bytes; allowed: at most so many");
        return Err(RecordingError::Foreign { path: folder.to_owned(), detail });
    }
    let lines = bytes.split(|byte| *byte == b'\n');
    let entries: Vec<Entry> = lines.filter_map(|line| serde_json::from_slice(line).ok()).collect();
    Ok(Some(entries.into()))
}
/// Largest `meta.json` and `replica.bin` that are read.
const MOST_BYTES: u64 = 256 << 20;

/// The file of a column within the folder.
fn file_of(column: &str) -> String {
    format!("{column}.bin")
}

/// Where a column is in a folder.
fn place(folder: &Path, column: &Column) -> PathBuf {
    folder.join(file_of(&column.path))
}

/// What a new recording may replace.
pub(crate) fn recognise(path: &Path) -> Recognised {
    held(path).ok_or("folder that holds a plain recording and nothing else")
}

fn held(path: &Path) -> Option<Holding> {
    let (found, folders) = tree(path)?;
    if found.is_empty() {
        // Folders in it, even empty ones, are none that a recording has made.
        return folders.is_empty().then(|| Holding::Folder(Vec::new()));
    }
    let meta = own_meta(path)?;
    let columns = meta["columns"].as_object()?;
    let own = own_files(columns.keys().map(String::as_str));
    let is_own = |folder: &PathBuf| own.iter().any(|file| file.starts_with(folder));
    (found.iter().all(|file| own.contains(file)) && folders.iter().all(is_own))
        .then_some(Holding::Folder(own))
}

/// The header of a folder of this program.
fn own_meta(path: &Path) -> Option<Value> {
    let path = path.join(META);
    if !fs::symlink_metadata(&path).is_ok_and(|data| data.is_file() && data.len() <= MOST_BYTES) {
        return None;
    }
    let meta: Value = serde_json::from_slice(&fs::read(path).ok()?).ok()?;
    (meta["format"] == "nereus").then_some(meta)
}

/// Whether a recording holds what a receiver took from the wire, not what a run wrote.
pub(crate) fn is_received(path: &Path) -> bool {
    own_meta(path).is_some_and(|meta| meta["truth"] == false)
}

/// Every file and every folder below a folder; `None` if something there is neither.
fn tree(path: &Path) -> Option<(Vec<PathBuf>, Vec<PathBuf>)> {
    let mut files = Vec::new();
    let mut folders = Vec::new();
    let mut unseen = vec![PathBuf::new()];
    while let Some(folder) = unseen.pop() {
        for entry in fs::read_dir(path.join(&folder)).ok()? {
            let entry = entry.ok()?;
            let inside = folder.join(entry.file_name());
            match entry.file_type().ok()? {
                kind if kind.is_dir() => {
                    folders.push(inside.clone());
                    unseen.push(inside);
                }
                kind if kind.is_file() => files.push(inside),
                _ => return None,
            }
        }
    }
    Some((files, folders))
}

/// The files of a recording with these columns, the one that is locked first.
fn own_files<'a>(columns: impl IntoIterator<Item = &'a str>) -> Vec<PathBuf> {
    let fixed = [META, REPLICA, CHANGES].map(PathBuf::from);
    let of_columns = columns.into_iter().map(|column| PathBuf::from(file_of(column)));
    let is_inside = |path: &PathBuf| path.components().all(|part| matches!(part, Component::Normal(_)));
    fixed.into_iter().chain(of_columns).filter(is_inside).collect()
}
