//! HDF5 recording, readable while it grows ([`crate::recording::hdf5`] has its structure).
//!
//! With `segment_s` the recording is cut by emission time after pulse 0: `name.h5` becomes
//! `name_0000.h5`, `name_0001.h5`, …, each complete by itself.
//!
//! A failing write (full disk) ends the sink with an error; what was flushed before stays readable. Other
//! datasets may then be longer than `/pulse/index`: their further rows are not complete.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

use super::sink::{Closed, FLUSH_INTERVAL, Sink, SinkError, SinkReport};
use crate::files::{self, Draft};
use crate::pulse::Pulse;
use crate::recording::columns::{Column, Rows, columns};
use crate::recording::hdf5::fault::Fault;
use crate::recording::hdf5::file::{is_later_segment, recognise};
use crate::recording::hdf5::header::Segment;
use crate::recording::hdf5::reader::readable;
use crate::recording::hdf5::writer::{Writer, chunk_pulses};
use crate::recording::header::Header;

pub use crate::recording::hdf5::writer::CHUNK_PULSES;

/// A fast run flushes after this much data, too.
const FLUSH_BYTES: usize = 16 << 20;

/// An HDF5 recording under way.
#[derive(Debug)]
pub struct Hdf5Sink {
    path: PathBuf,
    segment_s: Option<f64>,
    header: Header,
    recording: Option<Writer>,
    segment: u64,
    /// The last pulse taken.
    last: Option<u64>,
    columns: Vec<Column>,
    block: Vec<Rows>,
    block_rows: usize,
    chunk_pulses: usize,
    pulses: u64,
    flushed: Instant,
    row_bytes: usize,
    unflushed_bytes: usize,
    /// Names of the files as they will be.
    files: Vec<PathBuf>,
    force: bool,
    surplus: Vec<PathBuf>,
    /// Files that are complete and closed, and their pulses.
    drafts: Vec<Draft>,
    closed_pulses: u64,
}

/// Name of a segment.
fn segment_path(path: &Path, segment: u64) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let extension = path.extension().map_or_else(|| "h5".into(), |e| e.to_string_lossy());
    path.with_file_name(format!("{stem}_{segment:04}.{extension}"))
}

/// What has the name of a segment, with its number. That does not make it one: `rec_20180509.h5` may be any
/// recording.
pub(super) fn named_as_segments(path: &Path) -> Vec<(u64, PathBuf)> {
    let stem = format!("{}_", path.file_stem().unwrap_or_default().to_string_lossy());
    let Ok(entries) = fs::read_dir(files::folder(path)) else { return Vec::new() };
    let mut found: Vec<(u64, PathBuf)> = entries
        .flatten()
        .map(|entry| path.with_file_name(entry.file_name()))
        .filter_map(|candidate| {
            let name = candidate.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let number = name.strip_prefix(&stem).and_then(|n| n.parse::<u64>().ok())?;
            (segment_path(path, number) == candidate).then_some((number, candidate))
        })
        .collect();
    found.sort();
    found
}

/// Files of an earlier run that this output would replace: of segments the first, which most runs make, and
/// those that were written as later ones.
fn existing(path: &Path, segment_s: Option<f64>) -> Vec<PathBuf> {
    if segment_s.is_none() {
        return if fs::symlink_metadata(path).is_ok() { vec![path.to_owned()] } else { Vec::new() };
    }
    let found = named_as_segments(path).into_iter();
    found.filter(|(number, path)| *number == 0 || is_later_segment(path)).map(|(_, path)| path).collect()
}

/// Number of the segment that an emission is in, s after pulse 0.
fn segment_at(since_start_s: f64, segment_s: f64) -> u64 {
    // Half a nanosecond: an emission meant to be at the cut is in the new segment.
    ((since_start_s + 0.5e-9) / segment_s).floor().max(0.0) as u64
}

/// Looks at everything that has the name of a segment of this run, as far as its mean PRF predicts how many
/// there will be.
fn reached(path: &Path, segment_s: f64, force: bool, header: &Header) -> Result<(), SinkError> {
    if header.pulses == 0 {
        return Ok(());
    }
    let segment_of = |pulse: u64| segment_at(pulse as f64 / header.prf_hz, segment_s);
    let last = header.first_pulse.saturating_add(header.pulses - 1);
    let range = segment_of(header.first_pulse)..=segment_of(last);
    for (_, path) in named_as_segments(path).into_iter().filter(|(number, _)| range.contains(number)) {
        files::preflight(&path, force, &recognise)?;
    }
    Ok(())
}

/// Whether a recording may be made here.
pub(super) fn preflight(path: &Path, segment_s: Option<f64>, force: bool) -> Result<(), SinkError> {
    if let Some(segment_s) = segment_s
        && !(segment_s.is_finite() && segment_s > 0.0)
    {
        return Err(SinkError::Segment { segment_s });
    }
    for path in existing(path, segment_s) {
        files::preflight(&path, force, &recognise)?;
    }
    Ok(files::folder_exists(path)?)
}

impl Hdf5Sink {
    /// Makes the file (the first of its segments); nothing is left of it when that fails.
    ///
    /// # Errors
    /// A header that cannot be recorded, what is there already, and what system or library refuses.
    pub fn create(
        path: &Path,
        segment_s: Option<f64>,
        force: bool,
        header: &Header,
    ) -> Result<Self, SinkError> {
        header.check()?;
        preflight(path, segment_s, force)?;
        // Segments that an earlier run has and this one may not reach.
        let mut surplus = Vec::new();
        if let Some(segment_s) = segment_s {
            reached(path, segment_s, force, header)?;
            if force {
                surplus = existing(path, Some(segment_s));
            }
        }
        let columns = columns(header);
        let chunk_pulses = chunk_pulses(header);
        let row_bytes = columns.iter().map(Column::row_bytes).sum();
        let block = columns
            .iter()
            .map(|column| Rows::with_capacity(column.element, column.width() * chunk_pulses))
            .collect();
        let mut sink = Self {
            path: path.to_owned(),
            segment_s,
            header: header.clone(),
            recording: None,
            segment: 0,
            last: None,
            columns,
            block,
            block_rows: 0,
            chunk_pulses,
            pulses: 0,
            flushed: Instant::now(),
            row_bytes,
            unflushed_bytes: 0,
            files: Vec::new(),
            force,
            surplus,
            drafts: Vec::new(),
            closed_pulses: 0,
        };
        // Without segments the file is there from the start; with them the first pulse decides which.
        if segment_s.is_none() {
            sink.open(path.to_owned())?;
        }
        Ok(sink)
    }

    fn open(&mut self, path: PathBuf) -> Result<(), SinkError> {
        let segment = Segment { number: self.segment, after: self.last };
        let mut recording = Writer::create(Draft::named(&path), &self.header, segment)
            .map_err(Fault::at(&path, "making the recording"))?;
        if let Err(fault) = recording.place_early(self.force) {
            recording.abandon();
            return Err(fault.into());
        }
        self.recording = Some(recording);
        self.surplus.retain(|old| *old != path);
        self.files.push(path);
        self.flushed = Instant::now();
        Ok(())
    }

    /// The recording that a pulse belongs to: opens the next segment where one begins.
    fn turn(&mut self, pulse: &Pulse) -> Result<(), SinkError> {
        let Some(segment_s) = self.segment_s else { return Ok(()) };
        let segment = segment_at(pulse.time.since(self.header.start), segment_s);
        if self.recording.is_none() || segment != self.segment {
            self.close_file()?;
            // One may move it on while the run goes on.
            self.drafts.last_mut().into_iter().for_each(Draft::hand_on);
            self.segment = segment;
            self.open(segment_path(&self.path, segment))?;
        }
        Ok(())
    }

    fn write_block(&mut self) -> Result<(), SinkError> {
        if self.block_rows == 0 {
            return Ok(());
        }
        if let Some(recording) = &mut self.recording {
            recording.append(&self.block).map_err(Fault::at(recording.path(), "writing pulses"))?;
        }
        self.block.iter_mut().for_each(Rows::clear);
        self.block_rows = 0;
        Ok(())
    }

    fn close_file(&mut self) -> Result<(), SinkError> {
        self.write_block()?;
        if let Some(recording) = self.recording.take() {
            let (path, pulses) = (recording.path().to_owned(), recording.rows() as u64);
            match recording.close() {
                Ok(mut draft) => {
                    draft.present()?;
                    draft.unlock();
                    self.drafts.push(draft);
                }
                Err(failed) => {
                    let (fault, draft) = *failed;
                    self.closed_pulses += readable(&draft);
                    return Err(Fault::at(&path, "closing the recording")(fault).into());
                }
            }
            self.closed_pulses += pulses;
        }
        Ok(())
    }
}

impl Sink for Hdf5Sink {
    fn name(&self) -> &'static str {
        "hdf5"
    }

    fn describe(&self) -> String {
        match self.segment_s {
            None => format!("HDF5 recording {}", self.path.display()),
            Some(s) => {
                format!("HDF5 recording {} in segments of {s} s", segment_path(&self.path, 0).display())
            }
        }
    }

    fn write(&mut self, pulse: &Pulse) -> Result<(), SinkError> {
        for column in &self.columns {
            column.check(pulse)?;
        }
        self.turn(pulse)?;
        for (column, rows) in self.columns.iter().zip(&mut self.block) {
            column.push(pulse, rows);
        }
        self.last = Some(pulse.index);
        self.block_rows += 1;
        self.pulses += 1;
        let written = self.recording.as_ref().map_or(0, Writer::rows);
        // After a flush in mid-chunk the next block ends where the chunk ends.
        if (written + self.block_rows).is_multiple_of(self.chunk_pulses) {
            self.write_block()?;
        }
        self.unflushed_bytes += self.row_bytes;
        if self.unflushed_bytes >= FLUSH_BYTES || self.flushed.elapsed() >= FLUSH_INTERVAL {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        self.write_block()?;
        if let Some(recording) = &mut self.recording {
            recording.flush().map_err(Fault::at(recording.path(), "flushing"))?;
        }
        self.flushed = Instant::now();
        self.unflushed_bytes = 0;
        Ok(())
    }

    fn close(&mut self) -> Result<Closed, SinkError> {
        self.close_file()?;
        let report = SinkReport {
            name: "hdf5".to_owned(),
            pulses: self.pulses,
            bytes: self.pulses * self.row_bytes as u64,
            files: std::mem::take(&mut self.files),
            ..SinkReport::default()
        };
        Ok(Closed {
            report,
            drafts: std::mem::take(&mut self.drafts),
            force: self.force,
            surplus: std::mem::take(&mut self.surplus),
            recognise: Some(recognise),
        })
    }

    fn readable(&mut self) -> Option<u64> {
        // Closes what can be closed.
        let growing = self.recording.take().map(|recording| readable(&recording.give_up()));
        Some(self.closed_pulses + growing.unwrap_or(0))
    }

    fn abandon(&mut self) {
        if let Some(recording) = self.recording.take() {
            recording.abandon();
        }
        self.drafts.drain(..).for_each(Draft::abandon);
    }
}
