//! Whether a recording is whole: everything in it is read once and held against what a recording promises.
//!
//! - The header is complete and sizes agree with names
//!   ([`Header::check`](crate::recording::header::Header::check)).
//! - Every column has as many rows as `/pulse/index`, and every row can be read. In HDF5 the library checks
//!   the Fletcher-32 checksum of every chunk meanwhile (recordings of earlier versions have none: then a
//!   damaged sample is not seen, which is noted).
//! - Pulse numbers ascend; where some are missing, the pulse after the gap is flagged (`AFTER_GAP`).
//! - Emission times ascend. Samples, times and states are finite numbers.
//! - The writer has closed the file: not so while it grows and after its writer was killed.
//!
//! A run that was stopped early is whole as far as it goes; how far it was to go is noted.
//!
//! ```
//! use nereus::recording::verify::verify;
//! assert!(verify("no/such/recording.h5".as_ref()).is_err());
//! ```

use std::fs;
use std::io::{Read, Seek};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Duration;

use serde::Serialize;

use super::columns::{Column, INDEX, Rows, columns};
use super::fault::{READING, RecordingError};
use super::instrument::EmitterRow;
use super::source::Source;
use crate::files::FileFault;
use crate::inputs;
use crate::pulse::flags::AFTER_GAP;

/// Rows are read in parts of about so many bytes.
const BLOCK_BYTES: usize = 4 << 20;
/// Most rows of a part: a whole number of chunks.
const BLOCK_ROWS: usize = 1024;
/// Faults that are listed; all are counted.
const LISTED: usize = 50;
/// Another `verify` holds the lock for an instant: so often, and at such intervals, is it tried.
const LOCK_TRIES: usize = 10;
const LOCK_PAUSE: Duration = Duration::from_millis(10);

/// What is wrong, and where.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Finding {
    /// A column with its rows, or the part of the file.
    #[serde(rename = "where")]
    pub place: String,
    /// What is wrong.
    pub what: String,
}

/// How a recording ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Ending {
    /// Its writer has closed it, as far as can be known.
    Closed,
    /// It is being written.
    Growing,
    /// The open-for-write flag is set, and no writer is there.
    WriterLost,
}

/// What was found.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Verdict {
    /// The recording.
    #[serde(serialize_with = "crate::files::lossy_path")]
    pub path: PathBuf,
    /// Whether nothing is wrong.
    pub whole: bool,
    /// How it ends.
    pub ending: Ending,
    /// Complete pulses.
    pub pulses: u64,
    /// First pulse.
    pub first: Option<u64>,
    /// Last pulse.
    pub last: Option<u64>,
    /// Pulses that the run dropped in real time, and flagged.
    pub dropped: u64,
    /// Pulses that the run was to have; 0 where that is not known.
    pub asked: u64,
    /// Those of them that the recording lacks.
    pub missing: u64,
    /// Bytes of per-pulse data that were read.
    pub bytes: u64,
    /// Faults in all.
    pub faults: u64,
    /// The first of them.
    pub findings: Vec<Finding>,
    /// What is no fault but good to know.
    pub notes: Vec<String>,
}

impl Verdict {
    fn fault(&mut self, place: impl Into<String>, what: impl Into<String>) {
        self.faults += 1;
        self.whole = false;
        if self.findings.len() < LISTED {
            self.findings.push(Finding { place: place.into(), what: what.into() });
        }
    }
}

/// Whether the superblock of an HDF5 file has the open-for-write flag.
fn is_marked(file: &mut fs::File) -> bool {
    // Signature (8 bytes), version, two sizes, then the flags: version 3 has the mark there.
    let mut start = [0; 12];
    let read = file.rewind().and_then(|()| file.read_exact(&mut start));
    read.is_ok() && start.starts_with(b"\x89HDF\r\n\x1a\n") && start[8] >= 3 && start[11] != 0
}

/// Whether a program keeps a file locked.
fn is_locked(file: &fs::File) -> bool {
    for attempt in 0..LOCK_TRIES {
        if attempt > 0 {
            thread::sleep(LOCK_PAUSE);
        }
        if !matches!(file.try_lock(), Err(fs::TryLockError::WouldBlock)) {
            return false;
        }
    }
    true
}

/// How a recording ends. In HDF5 a writer leaves its mark in the superblock until it has closed the file;
/// readers lock the file too, so a lock counts only beside that mark. In a plain recording writers alone lock
/// `meta.json`.
fn ending(path: &Path) -> Ending {
    let is_folder = path.is_dir();
    let Ok(mut file) = inputs::open(&if is_folder { path.join("meta.json") } else { path.to_owned() }) else {
        return Ending::Closed;
    };
    if !is_folder && !is_marked(&mut file) {
        return Ending::Closed;
    }
    if is_locked(&file) {
        return Ending::Growing;
    }
    // The writer may have closed it since.
    if !is_folder && is_marked(&mut file) { Ending::WriterLost } else { Ending::Closed }
}

/// Reads all of a recording. The error is for what cannot be looked at; what is damaged is in the verdict.
///
/// # Errors
/// A path where nothing can be read, and HDF5 in a build without it.
pub fn verify(path: &Path) -> Result<Verdict, RecordingError> {
    fs::metadata(path).map_err(FileFault::io(path, READING))?;
    let ending = ending(path);
    let mut verdict = Verdict {
        path: path.to_owned(),
        whole: true,
        ending,
        pulses: 0,
        first: None,
        last: None,
        dropped: 0,
        asked: 0,
        missing: 0,
        bytes: 0,
        faults: 0,
        findings: Vec::new(),
        notes: Vec::new(),
    };
    let source = match Source::open(path) {
        Ok(source) => source,
        Err(error @ RecordingError::NoHdf5 { .. }) => return Err(error),
        Err(error) => {
            verdict.fault("header", error.to_string());
            return Ok(verdict);
        }
    };
    match ending {
        Ending::Closed => {}
        Ending::Growing => {
            verdict.fault("end", "being written (or its writer was killed, and another program reads it)");
        }
        Ending::WriterLost => {
            verdict.fault("end", "its writer did not close it: pulses after its last flush are lost");
        }
    }
    let header = source.header();
    verdict.pulses = source.pulses() as u64;
    verdict.asked = header.pulses;
    verdict.missing = verdict.asked.saturating_sub(verdict.pulses);
    let list: Vec<Column> =
        columns(header).into_iter().filter(|c| !c.may_be_missing() || source.has(c)).collect();
    for column in &list {
        lengths(&source, column, &mut verdict);
        read_through(path, &source, column, &mut verdict);
    }
    order(path, &source, &list, &mut verdict);
    if verdict.missing > 0 {
        verdict.notes.push(format!("{} of the {} pulses of the run", verdict.pulses, verdict.asked));
    }
    for EmitterRow { antenna, carrier_hz, prf_hz, receivers, .. } in header.emitters() {
        let receivers = receivers.join(", ");
        let how = format!("{carrier_hz} Hz, {prf_hz} pulses/s, received by {receivers}");
        verdict.notes.push(format!("emitter {} on {}: {how}", antenna.name, antenna.platform));
    }
    if !source.has_checksums() {
        verdict.notes.push("without checksums: a changed sample that is a number is not seen".to_owned());
    }
    Ok(verdict)
}

/// Every column has the rows of the index.
fn lengths(source: &Source, column: &Column, verdict: &mut Verdict) {
    match source.length(column) {
        Ok((rows, 0)) if rows == verdict.pulses => {}
        Ok((rows, 0)) => {
            verdict.fault(
                format!("/{}", column.path),
                format!("{rows} rows where /{INDEX} has {}", verdict.pulses),
            );
        }
        Ok((rows, over)) => {
            verdict.fault(format!("/{}", column.path), format!("{rows} rows and {over} bytes of one more"));
        }
        Err(error) => verdict.fault(format!("/{}", column.path), error.to_string()),
    }
}

/// Parts of the rows.
fn parts(rows: usize, row_bytes: usize) -> impl Iterator<Item = Range<usize>> {
    let step = (BLOCK_BYTES / row_bytes.max(1)).clamp(1, BLOCK_ROWS);
    (0..rows).step_by(step).map(move |from| from..(from + step).min(rows))
}

/// Whether a column may hold what is no number: delays of targets that are not there, ages of unknown states.
fn may_be_nan(column: &Column) -> bool {
    ["truth/delay_s", "truth/doppler_hz"].contains(&column.path.as_str()) || column.path.ends_with("/age_s")
}

/// Reads every row of a column.
fn read_through(path: &Path, source: &Source, column: &Column, verdict: &mut Verdict) {
    let held = source.length(column).map_or(0, |(rows, _)| rows);
    for part in parts(verdict.pulses as usize, column.row_bytes()) {
        // What lies behind the end of the column has been reported as its length.
        if part.start as u64 >= held.max(1) {
            break;
        }
        let place = || format!("/{}, rows {}..{}", column.path, part.start, part.end);
        let bad = match source.rows(path, column, part.clone()) {
            Err(error) => {
                verdict.fault(place(), error.to_string());
                continue;
            }
            Ok(Rows::F64(values)) if !may_be_nan(column) => values.iter().filter(|v| !v.is_finite()).count(),
            Ok(Rows::Cf32(values)) => values.iter().filter(|v| !v.is_finite()).count(),
            Ok(_) => 0,
        };
        verdict.bytes += (part.len() * column.row_bytes()) as u64;
        if bad > 0 {
            verdict.fault(place(), format!("{bad} values are not finite"));
        }
    }
}

/// Numbers and times ascend; gaps are those of the run.
fn order(path: &Path, source: &Source, list: &[Column], verdict: &mut Verdict) {
    let find = |name: &str| list.iter().find(|column| column.path == name);
    let (Some(index), Some(flags), Some(ns), Some(part_ns)) =
        (find(INDEX), find("pulse/flags"), find("pulse/time_ns"), find("pulse/time_frac_ns"))
    else {
        return;
    };
    let mut before: Option<(u64, i64, f64)> = None;
    for part in parts(verdict.pulses as usize, 8) {
        let rows = |column: &Column| source.rows(path, column, part.clone()).ok();
        // What cannot be read has been reported.
        let (Some(Rows::U64(index)), Some(Rows::U32(flags)), Some(Rows::I64(ns)), Some(Rows::F64(part_ns))) =
            (rows(index), rows(flags), rows(ns), rows(part_ns))
        else {
            before = None;
            continue;
        };
        for (row, (((index, flags), ns), part_ns)) in
            (part.start..).zip(index.into_iter().zip(flags).zip(ns).zip(part_ns))
        {
            verdict.first.get_or_insert(index);
            if let Some((last, last_ns, last_part_ns)) = before {
                if index <= last {
                    verdict
                        .fault(format!("/{INDEX}, row {row}"), format!("pulse {index} after pulse {last}"));
                } else if index - last > 1 && flags & AFTER_GAP == 0 {
                    verdict.fault(
                        format!("/{INDEX}, row {row}"),
                        format!("pulses {}..{index} are missing, and the run did not drop them", last + 1),
                    );
                } else {
                    // Numbers of a damaged index may rise and fall, so the sum has no bound.
                    verdict.dropped = verdict.dropped.saturating_add(index - last - 1);
                }
                if ns < last_ns || ns == last_ns && part_ns <= last_part_ns {
                    verdict.fault(format!("/pulse/time_ns, row {row}"), "not after the pulse before it");
                }
            }
            before = Some((index, ns, part_ns));
            verdict.last = Some(index);
        }
    }
}
