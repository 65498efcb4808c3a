//! `/truth/changes`: what was changed while a run went on.
//!
//! Texts have a fixed size: a file that is read while it grows cannot hold others.

use std::str::FromStr;
use std::sync::Arc;

use ::hdf5::types::FixedUnicode;
use ::hdf5::{Dataset, Extent, File, H5Type};

use super::attributes::checked;
use super::fault::Fault;
use super::sizes;
use crate::pulse::log::{Entry, Log, Origin};
use crate::recording::unwritten::Unwritten;

/// Where it is.
const PATH: &str = "truth/changes";
/// Longest text of a change, bytes; those of the program are shorter by far.
const TEXT: usize = 128;
/// Longest name of a platform, bytes.
const NAME: usize = 200;
/// Rows of a chunk.
const CHUNK: usize = 16;

// `repr(C)`: the library reads rows by the offsets of their fields.
#[derive(Clone, Copy, H5Type)]
#[repr(C)]
struct Row {
    pulse: u64,
    time_ns: i64,
    platform: FixedUnicode<NAME>,
    text: FixedUnicode<TEXT>,
    source: FixedUnicode<16>,
}

/// The table, being written.
#[derive(Debug)]
pub(super) struct ChangeTable {
    dataset: Dataset,
    rows: usize,
    unwritten: Unwritten,
}

fn fixed<const N: usize>(text: &str) -> Result<FixedUnicode<N>, Fault> {
    FixedUnicode::from_str(text).map_err(|error| Fault::Text(error.to_string()))
}

impl ChangeTable {
    /// An empty one.
    pub fn create(file: &File, log: &Arc<Log>) -> Result<Self, Fault> {
        let builder = file.new_dataset::<Row>().fletcher32().chunk(CHUNK).shape([Extent::resizable(0)]);
        Ok(Self { dataset: builder.create(PATH)?, rows: 0, unwritten: Unwritten::of(log) })
    }

    /// Appends the changes that pulses up to this one have.
    pub fn append_up_to(&mut self, pulse: u64) -> Result<(), Fault> {
        let entries = self.unwritten.up_to(pulse);
        if entries.is_empty() {
            return Ok(());
        }
        let row = |entry: &Entry| -> Result<Row, Fault> {
            Ok(Row {
                pulse: entry.pulse,
                time_ns: entry.time_ns,
                platform: fixed(&entry.platform)?,
                text: fixed(&entry.text)?,
                source: fixed(entry.origin.word())?,
            })
        };
        let rows = entries.iter().map(row).collect::<Result<Vec<_>, _>>()?;
        let end = self.rows + rows.len();
        self.dataset.resize([end])?;
        self.dataset.write_slice(&rows, self.rows..end)?;
        self.rows = end;
        Ok(())
    }
}

/// The changes of a recording; `None` of one in which nothing could be changed.
pub(super) fn read(file: &File, file_bytes: u64) -> Result<Option<Arc<Log>>, Fault> {
    if !file.group("truth")?.link_exists("changes") {
        return Ok(None);
    }
    let dataset = file.dataset(PATH)?;
    sizes::check(&dataset, None, file_bytes)?;
    let rows = dataset.read_raw::<Row>()?;
    let entry = |row: &Row| {
        let source = checked(row.source.as_bytes(), PATH)?;
        let origin = Origin::named(&source)
            .ok_or_else(|| Fault::Text(format!("/{PATH}: source '{}' is none", source.escape_debug())))?;
        Ok(Entry {
            pulse: row.pulse,
            time_ns: row.time_ns,
            platform: checked(row.platform.as_bytes(), PATH)?,
            text: checked(row.text.as_bytes(), PATH)?,
            origin,
        })
    };
    let entries = rows.iter().map(entry).collect::<Result<Vec<_>, Fault>>()?;
    Ok(Some(Arc::new(entries.into())))
}
