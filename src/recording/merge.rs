//! Joins shards or segments of one run into the recording of the whole.
//!
//! Shards are put in the order of their pulses, whatever the order given. Their headers must agree in
//! everything but the range of pulses, and so must their changes of reports up to the last pulse of the
//! earlier one; no pulse may be in two of them. A gap between two shards is refused and named, unless the run
//! itself dropped those pulses: then the pulse after it carries `AFTER_GAP`, and the shard before it is the
//! one that its segment followed (`after_pulse`), or the part of the run before its own. The recording of the
//! whole run would have the same gap. The datasets of the result are those of the whole run, bit for bit.
//! Recordings of `nereus run --shard` know how many of them there are: all must be given, each whole.
//! Shards are copied in blocks of bounded size into a file beside the output, which gets its name at the end
//! ([`crate::files`]): a merge that fails leaves nothing, and what was there before. A complete result that
//! cannot be put in its place stays beside it, and the error names it.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};

use serde::Serialize;
use thiserror::Error;

use crate::files::{self, Draft};
use crate::pulse::flags;
use crate::pulse::log::Entry;

use super::columns::Rows;
use super::fault::RecordingError;
use super::hdf5::fault::Fault;
use super::hdf5::file::recognise;
use super::hdf5::header::Segment;
use super::hdf5::reader::Reader;
use super::hdf5::writer::Writer;
use super::header::Header;
use super::shard::Shard as Number;

/// A block of a copy takes about this much memory.
const BLOCK_BYTES: usize = 8 << 20;

/// What a merge did.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MergeReport {
    /// The result.
    #[serde(serialize_with = "crate::files::lossy_path")]
    pub out: PathBuf,
    /// Shards joined, in the order of their pulses.
    #[serde(serialize_with = "crate::files::lossy_paths")]
    pub shards: Vec<PathBuf>,
    /// Pulses in the result.
    pub pulses: u64,
    /// First pulse.
    pub first: u64,
    /// Last pulse.
    pub last: u64,
    /// Indices within the range that no shard has, because they were dropped in real time.
    pub dropped: u64,
}

/// Why shards cannot be joined.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MergeError {
    /// No shard was given, or none holds a pulse.
    #[error("nothing to merge: {shards} shards given, none holds a pulse")]
    Nothing {
        /// Shards given.
        shards: usize,
    },
    /// Two shards are not of the same run.
    #[error("{path}: not of the same run as {other}: {field} differs")]
    Different {
        /// One shard.
        path: PathBuf,
        /// The one that it is compared with.
        other: PathBuf,
        /// The first part of the header that differs.
        field: &'static str,
    },
    /// A shard is a folder.
    #[error("{path}: is a folder; only HDF5 recordings can be joined")]
    Folder {
        /// The shard.
        path: PathBuf,
    },
    /// Pulses are in two shards.
    #[error("{path}: begins with pulse {first}, but {other} goes to pulse {last}; shards must not overlap")]
    Overlap {
        /// The later shard.
        path: PathBuf,
        /// Its first pulse.
        first: u64,
        /// The earlier shard.
        other: PathBuf,
        /// Its last pulse.
        last: u64,
    },
    /// Pulses are in no shard.
    #[error("pulses {from}..{to} are in no shard: between {before} and {after}")]
    Gap {
        /// First missing pulse.
        from: u64,
        /// One past the last missing pulse.
        to: u64,
        /// The shard before.
        before: PathBuf,
        /// The shard after.
        after: PathBuf,
    },
    /// Shards of a run of shards are not given.
    #[error("{missing} of {of} shards are missing: {}; allowed: all shards of a run (nereus run --shard {}/{of} makes one)", named(numbers, *missing), numbers.first().unwrap_or(&1))]
    Missing {
        /// The first numbers of those that are missing.
        numbers: Vec<u64>,
        /// Missing shards.
        missing: u64,
        /// Shards of the run.
        of: u64,
    },
    /// A shard of a run of shards ended early.
    #[error(
        "{path}: shard {shard} was to make pulses {from}..{to} and has {pulses} of them; make it again with nereus run --shard {shard} --force"
    )]
    Short {
        /// The shard.
        path: PathBuf,
        /// Its number.
        shard: Number,
        /// First pulse that it was to make.
        from: u64,
        /// One past the last one.
        to: u64,
        /// Pulses that it holds.
        pulses: usize,
    },
    /// A shard's pulses are not in order.
    #[error("{path}: pulse {index} comes after pulse {before}; a recording's pulses ascend")]
    Order {
        /// The shard.
        path: PathBuf,
        /// The pulse out of order.
        index: u64,
        /// The pulse before it.
        before: u64,
    },
    /// A file cannot be read or written.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}

impl MergeError {
    /// Whether what was asked for is wrong, rather than the machine short of something.
    pub fn is_wrong_input(&self) -> bool {
        match self {
            Self::Recording(error) => error.is_wrong_input(),
            _ => true,
        }
    }
}

/// Missing shards that are named.
const NAMED: usize = 8;

fn named(numbers: &[u64], missing: u64) -> String {
    let list: Vec<String> = numbers.iter().map(u64::to_string).collect();
    format!("{}{}", list.join(", "), if missing > numbers.len() as u64 { ", ..." } else { "" })
}

/// A recording to be joined. It is closed meanwhile: there may be more of them than files that may be open.
struct Shard {
    path: PathBuf,
    header: Header,
    pulses: usize,
    first: u64,
    last: u64,
    /// Last pulse of the segment before it, if it is a later segment of a run.
    after: Option<u64>,
    /// Whether its first pulse is flagged: pulses before it were dropped.
    after_gap: bool,
}

impl Shard {
    /// Changes up to a pulse.
    fn changes(&self, pulse: u64) -> Vec<Entry> {
        self.header.changes.as_ref().map_or_else(Vec::new, |log| log.between(None, pulse))
    }

    /// Whether pulses between `before` and this shard were dropped by the run rather than lost with a file.
    fn follows_a_gap(&self, before: &Self) -> bool {
        let asked_to = before.header.first_pulse.saturating_add(before.header.pulses);
        self.after_gap
            && match self.after {
                Some(last) => last == before.last,
                None => self.header.first_pulse <= asked_to,
            }
    }
}

/// Joins `shards` into `out`; an existing `out` is replaced only with `force`.
///
/// # Errors
/// Shards that do not fit together, and files that cannot be read or written.
pub fn merge(shards: &[PathBuf], out: &Path, force: bool) -> Result<MergeReport, MergeError> {
    files::preflight(out, force, &recognise).map_err(RecordingError::from)?;
    let list = ordered(shards)?;
    let (Some(earliest), Some(latest)) = (list.first(), list.last()) else {
        return Err(MergeError::Nothing { shards: shards.len() });
    };
    // The run that the result is the recording of: from the first shard's range to the last's.
    let mut header = earliest.header.clone();
    let ends = list.iter().map(|s| s.header.first_pulse.saturating_add(s.header.pulses));
    header.first_pulse = list.iter().map(|s| s.header.first_pulse).min().unwrap_or(header.first_pulse);
    header.pulses = ends.max().unwrap_or(0).saturating_sub(header.first_pulse);
    header.shard = None;
    // Every shard has all changes up to its last pulse.
    header.changes = list.iter().rev().find_map(|shard| shard.header.changes.clone());

    let mut recording =
        Writer::create(Draft::named(out), &header, Segment { number: 0, after: earliest.after })
            .map_err(Fault::at(out, "making the result"))?;
    if let Err(error) = list.iter().try_for_each(|shard| copy(shard, &mut recording)) {
        recording.abandon();
        return Err(error);
    }
    let pulses = recording.rows() as u64;
    let draft = recording.close().map_err(|failed| {
        let (fault, draft) = *failed;
        draft.abandon();
        Fault::at(out, "closing the result")(fault)
    })?;
    draft.finish(force, &recognise).map_err(RecordingError::from)?;
    let (first, last) = (earliest.first, latest.last);
    Ok(MergeReport {
        out: out.to_owned(),
        shards: list.iter().map(|s| s.path.clone()).collect(),
        pulses,
        first,
        last,
        dropped: last.saturating_sub(first).saturating_add(1).saturating_sub(pulses),
    })
}

/// Opens the shards that hold pulses and puts them in order; refuses what does not fit together.
fn ordered(shards: &[PathBuf]) -> Result<Vec<Shard>, MergeError> {
    let mut list: Vec<Shard> = Vec::with_capacity(shards.len());
    let mut numbers: BTreeMap<u64, Ended> = BTreeMap::new();
    for path in shards {
        if path.is_dir() {
            return Err(MergeError::Folder { path: path.clone() });
        }
        let fault = || Fault::at(path, "reading the shard");
        let recorded = Reader::open(path).map_err(fault())?;
        if let Some(other) = list.first()
            && let Some(field) = other.header.difference(&recorded.header)
        {
            return Err(MergeError::Different { path: path.clone(), other: other.path.clone(), field });
        }
        let last =
            recorded.pulses.checked_sub(1).map(|row| recorded.index(row)).transpose().map_err(fault())?;
        if let Some(number) = recorded.header.shard {
            Ended::count(&mut numbers, number, path, &recorded, last);
        }
        if let Some(last) = last {
            list.push(Shard {
                path: path.clone(),
                pulses: recorded.pulses,
                first: recorded.index(0).map_err(fault())?,
                last,
                after: recorded.after_pulse(),
                after_gap: recorded.flags(0).map_err(fault())? & flags::AFTER_GAP != 0,
                header: recorded.header,
            });
        }
    }
    list.sort_by_key(|shard| shard.first);
    all_given(numbers)?;
    for pair in list.windows(2) {
        let [before, after] = pair else { continue };
        if before.changes(before.last) != after.changes(before.last) {
            return Err(MergeError::Different {
                path: after.path.clone(),
                other: before.path.clone(),
                field: "truth/changes",
            });
        }
        if after.first <= before.last {
            return Err(MergeError::Overlap {
                path: after.path.clone(),
                first: after.first,
                other: before.path.clone(),
                last: before.last,
            });
        }
        if after.first > before.last.saturating_add(1) && !after.follows_a_gap(before) {
            return Err(MergeError::Gap {
                from: before.last.saturating_add(1),
                to: after.first,
                before: before.path.clone(),
                after: after.path.clone(),
            });
        }
    }
    Ok(list)
}

/// How far a numbered shard goes, over all its files: a sink may have cut it into segments.
struct Ended {
    path: PathBuf,
    shard: Number,
    /// Pulses that it was to make, and those that its files hold.
    asked: Range<u64>,
    pulses: usize,
    last: Option<u64>,
}

impl Ended {
    /// Takes a file of a shard into account.
    fn count(of: &mut BTreeMap<u64, Self>, shard: Number, path: &Path, file: &Reader, last: Option<u64>) {
        let from = file.header.first_pulse;
        let asked = from..from.saturating_add(file.header.pulses);
        let fresh = || Self { path: path.to_owned(), shard, asked, pulses: 0, last: None };
        let ended = of.entry(shard.number()).or_insert_with(fresh);
        (ended.pulses, ended.last) = (ended.pulses + file.pulses, ended.last.max(last));
    }
}

/// Refuses a run of shards of which some are not given, or one ended early: nothing after it would show the
/// gap.
fn all_given(shards: BTreeMap<u64, Ended>) -> Result<(), MergeError> {
    let Some(of) = shards.values().next().map(|ended| ended.shard.of()) else { return Ok(()) };
    let given = shards.len() as u64;
    if given != of {
        // A damaged file may claim any number of shards.
        let numbers = (1..=of).filter(|number| !shards.contains_key(number)).take(NAMED).collect();
        return Err(MergeError::Missing { numbers, missing: of.saturating_sub(given), of });
    }
    let short = |ended: &Ended| ended.last.is_none_or(|last| last.saturating_add(1) < ended.asked.end);
    match shards.into_values().find(short) {
        None => Ok(()),
        Some(Ended { path, shard, asked, pulses, .. }) => {
            Err(MergeError::Short { path, shard, from: asked.start, to: asked.end, pulses })
        }
    }
}

fn copy(shard: &Shard, recording: &mut Writer) -> Result<(), MergeError> {
    let recorded = Reader::open(&shard.path).map_err(Fault::at(&shard.path, "reading the shard"))?;
    let block = (BLOCK_BYTES / recorded.row_bytes().max(1)).clamp(1, 4096);
    let mut before = None;
    let mut row = 0;
    while row < shard.pulses {
        let to = (row + block).min(shard.pulses);
        let rows = recorded.rows(row, to).map_err(Fault::at(&shard.path, "reading the shard"))?;
        if let Some(Rows::U64(indices)) = rows.last() {
            for &index in indices {
                if let Some(before) = before.filter(|&before| index <= before) {
                    return Err(MergeError::Order { path: shard.path.clone(), index, before });
                }
                before = Some(index);
            }
        }
        recording.append(&rows).map_err(Fault::at(recording.path(), "writing pulses"))?;
        recording.flush().map_err(Fault::at(recording.path(), "flushing"))?;
        row = to;
    }
    Ok(())
}
