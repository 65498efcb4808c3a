//! A recording as a folder of plain files, for machines without HDF5.
//!
//! `meta.json` holds the header and, under `columns`, the type, row shape and words ([`super::descriptions`])
//! of every per-pulse file; under `descriptions` the words for what is there once. Column `a/b` is the file
//! `a/b.bin`: rows one after the other in C order, without any header, so
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
//! complex64. `pulse/index.bin` is written last at every flush ([`FLUSH_INTERVAL`]): after a kill the first
//! `n` rows of every file are complete, n being its length. The columns are listed in [`super::columns`].
//! Where reports may be changed, `truth/changes.jsonl` has a line for every change up to the last pulse:
//! `{"pulse":2220,"time_ns":..,"platform":"aircraft","text":"step position.up 5 m","source":"scenario"}`.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Component, Path, PathBuf};
use std::time::Instant;

use serde_json::{Map, Value, json};

use crate::files::{self, Draft, FileFault, Holding};
use crate::pulse::Pulse;

use super::columns::{Column, Element, Rows, columns};
use super::descriptions;
use super::sink::{Closed, FLUSH_INTERVAL, FORMAT_VERSION, Header, Sink, SinkError, SinkReport};
use super::unwritten::Unwritten;

/// Rows wait in memory until this many bytes are there (or a flush is due).
const BUFFER_BYTES: usize = 1 << 20;

/// The header.
const META: &str = "meta.json";
/// Changes of reports.
const CHANGES: &str = "truth/changes.jsonl";

/// A folder of plain files.
#[derive(Debug)]
pub struct PlainSink {
    target: PathBuf,
    /// None when it has been handed on.
    draft: Option<Draft>,
    force: bool,
    /// In the order of [`columns`]: the index last.
    files: Vec<PlainFile>,
    buffered_bytes: usize,
    row_bytes: usize,
    pulses: u64,
    flushed: Instant,
    changes: Option<Changes>,
}

/// The file of changes.
#[derive(Debug)]
struct Changes {
    unwritten: Unwritten,
    path: PathBuf,
    file: File,
}

#[derive(Debug)]
struct PlainFile {
    column: Column,
    rows: Rows,
    file: File,
}

/// Whether a folder may be made, or replaced, here.
pub(super) fn preflight(path: &Path, force: bool) -> Result<(), SinkError> {
    Ok(files::preflight(path, force, &recognise)?)
}

/// Largest `meta.json` that is looked at.
const META_BYTES: u64 = 256 << 20;

/// The files of a plain recording, if a folder holds one and nothing else. An empty folder holds nothing that
/// is lost.
fn recognise(path: &Path) -> Option<Holding> {
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
    if !fs::symlink_metadata(&path).is_ok_and(|data| data.is_file() && data.len() <= META_BYTES) {
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
    let fixed = [META, "replica.bin", CHANGES].map(PathBuf::from);
    let of_columns = columns.into_iter().map(|column| PathBuf::from(format!("{column}.bin")));
    let is_inside = |path: &PathBuf| path.components().all(|part| matches!(part, Component::Normal(_)));
    fixed.into_iter().chain(of_columns).filter(is_inside).collect()
}

impl PlainSink {
    /// Makes the folder; nothing is left of it when that fails.
    pub fn create(path: &Path, force: bool, header: &Header) -> Result<Self, SinkError> {
        header.check()?;
        preflight(path, force)?;
        let list = columns(header);
        let mut draft = Draft::named(path);
        fs::create_dir(draft.path()).map_err(SinkError::io(path, "making the folder"))?;
        draft.made(Holding::Folder(own_files(list.iter().map(|column| column.path.as_str()))))?;
        let made = Self::fill(draft.path(), list, header).and_then(|made| {
            draft.lock();
            draft.place_early(force)?;
            Ok(made)
        });
        match made {
            Ok((files, changes)) => {
                let row_bytes = files.iter().map(|file| file.column.row_bytes()).sum();
                Ok(Self {
                    target: path.to_owned(),
                    draft: Some(draft),
                    force,
                    files,
                    changes,
                    buffered_bytes: 0,
                    row_bytes,
                    pulses: 0,
                    flushed: Instant::now(),
                })
            }
            Err(error) => {
                draft.abandon();
                Err(error)
            }
        }
    }

    fn fill(
        path: &Path,
        list: Vec<Column>,
        header: &Header,
    ) -> Result<(Vec<PlainFile>, Option<Changes>), SinkError> {
        let write = |name: &str, bytes: &[u8]| {
            let file = path.join(name);
            fs::write(&file, bytes).map_err(SinkError::io(&file, "writing"))
        };
        write("replica.bin", bytemuck::cast_slice(&header.replica))?;
        let meta = format!("{:#}\n", meta(header, &list));
        write(META, meta.as_bytes())?;
        let row_bytes: usize = list.iter().map(Column::row_bytes).sum();
        let rows_kept = BUFFER_BYTES.div_ceil(row_bytes);
        let mut files = Vec::with_capacity(list.len());
        for column in list {
            let file_path = path.join(format!("{}.bin", column.path));
            if let Some(folder) = file_path.parent() {
                fs::create_dir_all(folder).map_err(SinkError::io(folder, "making the folder"))?;
            }
            let file = File::create_new(&file_path).map_err(SinkError::io(&file_path, "making the file"))?;
            let rows = Rows::with_capacity(column.element, column.width() * rows_kept);
            files.push(PlainFile { column, rows, file });
        }
        let changes = match &header.changes {
            None => None,
            Some(log) => {
                let file_path = path.join(CHANGES);
                fs::create_dir_all(path.join("truth")).map_err(SinkError::io(path, "making the folder"))?;
                let file =
                    File::create_new(&file_path).map_err(SinkError::io(&file_path, "making the file"))?;
                Some(Changes { unwritten: Unwritten::of(log), path: file_path, file })
            }
        };
        Ok((files, changes))
    }

    /// Where a file of the recording is now: the folder may have got its name since it was opened.
    fn place_of(&self, column: &Column) -> PathBuf {
        let folder = self.draft.as_ref().map_or(self.target.as_path(), Draft::path);
        folder.join(format!("{}.bin", column.path))
    }

    /// Where the recording is now: somebody may have moved it.
    fn folder(&self) -> Result<PathBuf, SinkError> {
        Ok(self.draft.as_ref().map_or_else(|| Ok(self.target.clone()), Draft::present)?)
    }

    /// Nobody has removed a file of it.
    fn is_all_there(&self) -> Result<(), SinkError> {
        let folder = self.folder()?;
        let at = |file: &PlainFile| folder.join(format!("{}.bin", file.column.path));
        match self.files.iter().find(|file| !files::is_at(&file.file, &at(file))) {
            Some(lost) => Err(FileFault::Removed { path: at(lost) }.into()),
            None => Ok(()),
        }
    }
}

impl Sink for PlainSink {
    fn name(&self) -> &'static str {
        "plain"
    }

    fn describe(&self) -> String {
        format!("plain recording {}", self.target.display())
    }

    fn write(&mut self, pulse: &Pulse) -> Result<(), SinkError> {
        for file in &self.files {
            file.column.check(pulse)?;
        }
        if let Some(Changes { unwritten, path, file }) = &mut self.changes {
            for entry in unwritten.up_to(pulse.index) {
                writeln!(file, "{}", json!(entry)).map_err(SinkError::io(path, "writing"))?;
            }
        }
        for file in &mut self.files {
            file.column.push(pulse, &mut file.rows);
        }
        self.pulses += 1;
        self.buffered_bytes += self.row_bytes;
        if self.buffered_bytes >= BUFFER_BYTES || self.flushed.elapsed() >= FLUSH_INTERVAL {
            self.flush()?;
        }
        Ok(())
    }

    fn flush(&mut self) -> Result<(), SinkError> {
        let mut failed = None;
        for (place, file) in self.files.iter_mut().enumerate() {
            if let Err(source) = file.file.write_all(file.rows.as_bytes()) {
                failed = Some((place, source));
                break;
            }
            file.rows.clear();
        }
        if let Some((place, source)) = failed {
            let path = self.place_of(&self.files[place].column);
            return Err(SinkError::Io { path, action: "writing", source });
        }
        self.buffered_bytes = 0;
        self.flushed = Instant::now();
        Ok(())
    }

    fn close(&mut self) -> Result<Closed, SinkError> {
        self.flush()?;
        for file in &self.files {
            file.file.sync_all().map_err(SinkError::io(&self.place_of(&file.column), "closing"))?;
        }
        self.is_all_there()?;
        let folder = self.folder()?;
        for name in [META, "replica.bin", CHANGES].iter().map(|name| folder.join(name)).filter(|p| p.exists())
        {
            let synced = File::open(&name).and_then(|file| file.sync_all());
            synced.map_err(SinkError::io(&name, "closing"))?;
        }
        let report = SinkReport {
            name: "plain".to_owned(),
            pulses: self.pulses,
            bytes: self.pulses * self.row_bytes as u64,
            files: vec![self.target.clone()],
            ..SinkReport::default()
        };
        let drafts = self.draft.take().into_iter().collect();
        Ok(Closed { report, drafts, force: self.force, recognise: Some(recognise), ..Closed::default() })
    }

    fn readable(&mut self) -> Option<u64> {
        // A reader opens all of it or nothing.
        if self.is_all_there().is_err() {
            return Some(0);
        }
        // Rows beyond the last whole pulse are cut off; where that fails, the index still says how many are
        // complete.
        let index_bytes =
            self.files.last().and_then(|index| index.file.metadata().ok()).map(|data| data.len());
        let pulses = index_bytes.map_or(0, |bytes| bytes / size_of::<u64>() as u64);
        for file in self.files.iter().rev() {
            let _ = file.file.set_len(pulses * file.column.row_bytes() as u64);
        }
        Some(pulses)
    }

    fn abandon(&mut self) {
        if let Some(draft) = self.draft.take() {
            draft.abandon();
        }
    }
}

/// `meta.json`.
fn meta(header: &Header, list: &[Column]) -> Value {
    let (start_ns, start_frac_ns) = header.start.to_unix_ns();
    let files: Map<String, Value> = list
        .iter()
        .map(|column| {
            let mut shape = column.shape.clone();
            let mut entry = json!(descriptions::of_column(column));
            if column.element == Element::Ci16 {
                shape.push(2);
                entry["axes"] =
                    format!("{}, in-phase and quadrature", entry["axes"].as_str().unwrap_or("")).into();
            }
            entry["dtype"] = column.element.numpy().into();
            entry["shape"] = shape.into();
            (column.path.clone(), entry)
        })
        .collect();
    let others: Map<String, Value> =
        descriptions::of_header(header).map(|of| (of.path.to_owned(), json!(of))).collect();
    json!({
        "format": "nereus",
        "version": FORMAT_VERSION,
        "software": header.software,
        "carrier_hz": header.carrier_hz,
        "sample_rate_hz": header.sample_rate_hz,
        "bandwidth_hz": header.bandwidth_hz,
        "pulse_s": header.pulse_s,
        "prf_hz": header.prf_hz,
        "channels": header.channels.iter().map(|c| &c.name).collect::<Vec<_>>(),
        "channel": header.channels,
        "pairs": header.pairs,
        "origin_lat_deg": header.origin.map(|o| o.lat_deg),
        "origin_lon_deg": header.origin.map(|o| o.lon_deg),
        "origin_h_m": header.origin.map(|o| o.h_m),
        "seed": header.seed,
        "config": header.config,
        "platforms": header.platforms,
        "transmitters": header.transmitters,
        "receivers": header.receivers,
        "targets": header.targets,
        "ships": header.ships,
        "clocks": header.clocks,
        "adc_bits": header.adc.map(|a| a.bits),
        "adc_step": header.adc.map(|a| a.step),
        "start_time_ns": start_ns,
        "start_time_frac_ns": start_frac_ns,
        "first_pulse": header.first_pulse,
        "truth": header.truth,
        "pulses": header.pulses,
        "shard": header.shard.map(|shard| shard.to_string()),
        "replica_dtype": Element::Cf32.numpy(),
        "columns": files,
        "descriptions": others,
    })
}
